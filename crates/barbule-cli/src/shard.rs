//! `--shard i/n`, and what `--status` says of all parts of a job array.

use barbule::error::shortened;
use barbule::io::store::{Part, Run, Survey};
use barbule::progress::{MOST_SHARDS, Shard};
use barbule::{Error, Result};
use serde_json::{Value, json};

use crate::common::duration;

/// So many parts are listed in words, one a line.
const MOST_LINES: usize = 40;

/// What `--shard` is given.
pub(crate) fn parse(text: &str) -> Result<Shard> {
    text.parse().map_err(|error| Error::input(format!("--shard {error}")))
}

/// What `--shards` is given.
pub(crate) fn count(text: &str) -> Result<usize> {
    text.trim().parse::<usize>().ok().filter(|n| (1..=MOST_SHARDS).contains(n)).ok_or_else(|| {
        Error::input(format!(
            "--shards {}: give the number of parts, from 1 to {MOST_SHARDS}",
            shortened(text)
        ))
    })
}

/// How far the parts of a campaign are.
pub(crate) struct Parts {
    parts: Vec<Part>,
    /// How many there are; fewer may be shown.
    of: usize,
}

impl Parts {
    /// All parts of `shards`, or of as many as those that compute share the work into; of them only one where it is asked for. Nothing
    /// where neither says how many there are.
    pub(crate) fn of(survey: &Survey, only: Option<Shard>, shards: Option<usize>) -> Self {
        let of = only.map(Shard::of).or(shards).or_else(|| survey.shards()).unwrap_or(0);
        let all = (0..of).filter_map(|number| Shard::new(number, of).ok());
        let parts =
            all.filter(|shard| only.is_none_or(|only| only == *shard)).map(|shard| survey.part(shard));
        Self { parts: parts.collect(), of }
    }

    /// A line for each part that is not done, or for all where there are few, and which are left to start.
    pub(crate) fn lines(&self) -> Vec<String> {
        let are_few = self.parts.len() <= MOST_LINES;
        let shown = || self.parts.iter().filter(|part| are_few || !part.is_done());
        let mut lines: Vec<String> = shown().take(MOST_LINES).map(line).collect();
        match shown().count().saturating_sub(MOST_LINES) {
            0 => {}
            more => lines.push(format!("and {more} more that are not done")),
        }
        if let Some(left) = self.seconds_left() {
            lines.push(format!("those that run need about {} more", duration(left)));
        }
        let to_start = self.to_start();
        if !to_start.is_empty() && self.of > 1 {
            lines.push(format!("to be started (again): {}", as_ranges(&to_start)));
        }
        lines
    }

    /// What is left of those that run until the last of them ends, s; unknown where none has done a unit.
    fn seconds_left(&self) -> Option<f64> {
        let left = self.parts.iter().filter(|part| !part.is_done()).filter_map(|part| part.left);
        left.max().map(|left| left.as_secs_f64())
    }

    /// The numbers of those that are neither done nor computed.
    fn to_start(&self) -> Vec<usize> {
        let idle = self.parts.iter().filter(|part| !part.is_done() && !part.is_running());
        idle.map(|part| part.shard.number()).collect()
    }

    /// The same for programs.
    pub(crate) fn json(&self) -> Value {
        let one = |part: &Part| {
            json!({
                "shard": part.shard.number(),
                "units": part.status.units,
                "done": part.status.done,
                "damaged": part.status.damaged,
                "state": state(part),
                "seconds_left": part.left.filter(|_| !part.is_done()).map(|left| left.as_secs_f64()),
            })
        };
        json!({
            "count": self.of,
            "parts": self.parts.iter().map(one).collect::<Vec<_>>(),
            "seconds_left": self.seconds_left(),
            "to_start": self.to_start(),
        })
    }
}

/// The processes that compute, for programs.
pub(crate) fn running(survey: &Survey) -> Value {
    let one = |run: &Run| {
        json!({
            "shard": run.shard.number(),
            "shards": run.shard.of(),
            "process": run.process,
            "seconds": run.since.as_secs(),
        })
    };
    survey.runs().iter().filter(|run| run.is_alive).map(one).collect()
}

/// How a part stands, in a word.
fn state(part: &Part) -> &'static str {
    match part.run {
        _ if part.is_done() => "done",
        Some(run) if run.is_alive => "running",
        Some(_) => "killed",
        None => "waiting",
    }
}

fn line(part: &Part) -> String {
    let status = part.status;
    let damaged = if status.damaged > 0 { format!(", {} damaged", status.damaged) } else { String::new() };
    let how = match part.run {
        _ if part.is_done() => "done".to_owned(),
        Some(run) if run.is_alive => {
            let left = part
                .left
                .map_or_else(String::new, |left| format!(", about {} left", duration(left.as_secs_f64())));
            format!("running for {} as process {}{left}", duration(run.since.as_secs_f64()), run.process)
        }
        Some(_) => "killed".to_owned(),
        None => "not running".to_owned(),
    };
    format!("shard {}: {} of {} units{damaged}, {how}", part.shard, status.done, status.units)
}

/// Rising numbers as schedulers take them: `0,3-7,12`.
pub(crate) fn as_ranges(numbers: &[usize]) -> String {
    let ranges = numbers.chunk_by(|a, b| a + 1 == *b).filter_map(|run| Some((run.first()?, run.last()?)));
    let words =
        ranges.map(|(first, last)| if first == last { first.to_string() } else { format!("{first}-{last}") });
    words.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_schedulers_take_them() {
        for (numbers, text) in
            [(&[][..], ""), (&[4], "4"), (&[0, 1], "0-1"), (&[0, 3, 4, 5, 7, 9, 10], "0,3-5,7,9-10")]
        {
            assert_eq!(as_ranges(numbers), text);
        }
    }

    #[test]
    fn values_that_share_nothing_out_are_refused_by_their_flag() {
        assert_eq!(
            parse("2/2").unwrap_err().to_string(),
            "--shard 2/2: write i/n with 0 <= i < n, as in 0/4"
        );
        assert_eq!(parse("1/2").unwrap(), Shard::new(1, 2).unwrap());
        for bad in ["0", "x", "-1", "100001"] {
            assert!(count(bad).unwrap_err().to_string().ends_with("from 1 to 100000"), "{bad}");
        }
        assert_eq!(count("16").unwrap(), 16);
    }
}
