//! How work is shared out to several processes that do not know of each other.

use std::fmt;
use std::iter::StepBy;
use std::ops::Range;
use std::str::FromStr;

use crate::error::shortened;
use crate::{Error, Result};

/// Into how many parts work is shared out at most.
pub const MOST_SHARDS: usize = 100_000;

/// One of several equal parts of work.
///
/// Parts are neighbours in the order of work, differ by at most one unit and together are all of it; a part may be empty where there are
/// more parts than units. Nothing that is computed depends on how work is shared out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shard {
    number: usize,
    of: usize,
}

impl Shard {
    /// All of the work.
    pub const WHOLE: Self = Self { number: 0, of: 1 };

    /// Part `number`, from 0, of `of`.
    ///
    /// # Errors
    /// Not 0 ≤ `number` < `of` ≤ [`MOST_SHARDS`].
    pub fn new(number: usize, of: usize) -> Result<Self> {
        if number < of && of <= MOST_SHARDS {
            return Ok(Self { number, of });
        }
        Err(Error::input(format!(
            "part {number} of {of}: give i and n with 0 <= i < n, n up to {MOST_SHARDS}"
        )))
    }

    /// Which part this is, from 0.
    #[must_use]
    pub fn number(self) -> usize {
        self.number
    }

    /// Of how many.
    #[must_use]
    pub fn of(self) -> usize {
        self.of
    }

    /// The places, in the order of work, of this part's units where there are `count` in all.
    #[must_use]
    pub fn range(self, count: usize) -> Range<usize> {
        // The product may be over what 32 bits hold.
        let bound = |part: usize| (count as u128 * part as u128 / self.of as u128) as usize;
        bound(self.number)..bound(self.number + 1)
    }

    /// The places of this part's units where units are dealt out in turn: part i has every `of`-th from i on. Where neighbours take about
    /// the same time, so do such parts.
    pub fn every(self, count: usize) -> StepBy<Range<usize>> {
        (self.number..count.max(self.number)).step_by(self.of)
    }

    /// The places of this part's units where each takes another time, `costs` in any unit: parts of about equal time, of neighbours in the
    /// order of work. The same costs give the same parts.
    #[must_use]
    pub fn by_cost(self, costs: &[f64]) -> Vec<usize> {
        let all: f64 = costs.iter().sum();
        if !(all > 0.0 && all.is_finite()) {
            return self.range(costs.len()).collect();
        }
        let mut before = 0.0;
        let mut own = Vec::new();
        for (place, cost) in costs.iter().enumerate() {
            let middle = (before + 0.5 * cost) / all;
            before += cost;
            if ((middle * self.of as f64) as usize).min(self.of - 1) == self.number {
                own.push(place);
            }
        }
        own
    }
}

impl FromStr for Shard {
    type Err = Error;

    /// Reads `i/n`.
    fn from_str(text: &str) -> Result<Self> {
        let refuse = |what: &str| Error::input(format!("{}: {what}", shortened(text)));
        let numbers =
            text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match numbers {
            Some((number, of)) if number < of => Self::new(number, of)
                .map_err(|_| refuse(&format!("work is cut into at most {MOST_SHARDS} parts"))),
            _ => Err(refuse("write i/n with 0 <= i < n, as in 0/4")),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_neighbours_of_equal_size_and_together_everything() {
        for (count, of) in [(0, 3), (1, 1), (6, 3), (7, 3), (2, 5), (1020, 16), (20_000_000, MOST_SHARDS)] {
            let mut next = 0;
            for number in 0..of {
                let range = Shard::new(number, of).unwrap().range(count);
                assert_eq!(range.start, next);
                assert!((count / of..=count.div_ceil(of)).contains(&range.len()), "{count} {of}");
                next = range.end;
            }
            assert_eq!(next, count);
        }
        assert_eq!(Shard::WHOLE.range(7), 0..7);
    }

    #[test]
    fn parts_in_turn_are_together_everything() {
        for (count, of) in [(0, 3), (7, 3), (2, 5), (1, 1)] {
            let mut all: Vec<usize> =
                (0..of).flat_map(|number| Shard::new(number, of).unwrap().every(count)).collect();
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
        }
        assert_eq!(Shard::new(1, 3).unwrap().every(7).collect::<Vec<_>>(), [1, 4]);
    }

    #[test]
    fn parts_by_cost_take_about_equal_time_and_are_together_everything() {
        let costs: Vec<f64> = (0..25).map(|w| (400.0 / (400.0 + 12.0 * f64::from(w))).powi(3)).collect();
        let all: f64 = costs.iter().sum();
        for of in [1, 2, 5, 25, 40] {
            let parts: Vec<Vec<usize>> =
                (0..of).map(|i| Shard::new(i, of).unwrap().by_cost(&costs)).collect();
            assert_eq!(parts.concat(), (0..25).collect::<Vec<_>>());
            for part in &parts {
                let cost: f64 = part.iter().map(|place| costs[*place]).sum();
                assert!(cost < all / of as f64 + 1.0, "{of} {part:?}");
            }
        }
        // Where nothing is known of the costs they count as equal.
        for unknown in [[0.0; 4], [f64::NAN; 4], [f64::INFINITY; 4]] {
            assert_eq!(Shard::new(1, 2).unwrap().by_cost(&unknown), [2, 3]);
        }
    }

    #[test]
    fn parts_that_are_none_are_refused() {
        for bad in ["", "1", "2/2", "-1/2", "0/0", "1/2/3", "a/b", "0.5/2", "1/", "/2"] {
            let error = bad.parse::<Shard>().unwrap_err();
            assert!(
                error.is_input() && error.to_string().ends_with("0 <= i < n, as in 0/4"),
                "{bad}: {error}"
            );
        }
        let error = "0/100001".parse::<Shard>().unwrap_err();
        assert_eq!(error.to_string(), "0/100001: work is cut into at most 100000 parts");
        let read: Shard = " 3 / 16".parse().unwrap();
        assert_eq!((read, read.to_string()), (Shard::new(3, 16).unwrap(), "3/16".to_owned()));
        assert!(Shard::new(4, 4).unwrap_err().to_string().starts_with("part 4 of 4: "));
    }
}
