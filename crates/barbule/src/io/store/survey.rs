//! How far a store is: in all, and by the parts of a job array.

use std::time::Duration;

use rayon::prelude::*;

use super::running::Run;
use super::{Files, Status};
use crate::clock;
use crate::progress::Shard;

/// What is there of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Found {
    Nothing,
    /// Something that fails its checksums.
    Damaged,
    /// All of it, since so long.
    Whole(Duration),
}

/// How the units of a store are dealt out to parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Deal {
    /// [`Shard::range`].
    Neighbours,
    /// [`Shard::every`].
    InTurn,
}

/// How far every unit of a store is, and which processes compute.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Survey {
    deal: Deal,
    /// In the order of work.
    found: Vec<Found>,
    /// In the order of their parts.
    runs: Vec<Run>,
}

/// How far a part of the units is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Which.
    pub shard: Shard,
    /// What is there of it.
    pub status: Status,
    /// The process that computes it, or was killed while it did.
    pub run: Option<Run>,
    /// What the process that computes it needs for the rest, at the speed that it has had; unknown before its first unit.
    pub left: Option<Duration>,
}

impl Part {
    /// Whether all of its units are there.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.status.done == self.status.units
    }

    /// Whether a process computes it.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.run.is_some_and(|run| run.is_alive)
    }
}

impl Survey {
    /// Reads all of `count` units, and looks who computes: a unit is there if the file of its `key` is, the last that is written of it.
    pub(in crate::io) fn new(
        files: &Files,
        count: usize,
        deal: Deal,
        key: &(dyn Fn(usize) -> String + Sync),
        is_whole: &(dyn Fn(usize) -> bool + Sync),
    ) -> Self {
        let now = clock::now();
        // First: who ends meanwhile has finished units.
        let runs = files.runs(now);
        let found = |unit: usize| {
            let key = key(unit);
            match files.has(&key) {
                false => Found::Nothing,
                true if is_whole(unit) => Found::Whole(files.age(&key, now)),
                true => Found::Damaged,
            }
        };
        Self { deal, found: (0..count).into_par_iter().map(found).collect(), runs }
    }

    /// How many units are done, missing and damaged.
    #[must_use]
    pub fn status(&self) -> Status {
        status(&self.found)
    }

    /// The processes that compute, and those that were killed and of which something is left to delete; by their parts.
    #[must_use]
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Into how many parts those that compute share the work out, or else those that were killed; `None` where they do not agree, or there
    /// are none.
    #[must_use]
    pub fn shards(&self) -> Option<usize> {
        let of = |is_alive: bool| -> Vec<usize> {
            self.runs.iter().filter(|run| run.is_alive == is_alive).map(|run| run.shard.of()).collect()
        };
        let (living, killed) = (of(true), of(false));
        let asked = if living.is_empty() { killed } else { living };
        let first = *asked.first()?;
        asked.iter().all(|of| *of == first).then_some(first)
    }

    /// How far a part is.
    #[must_use]
    pub fn part(&self, shard: Shard) -> Part {
        let all = &self.found;
        let found: Vec<Found> = match self.deal {
            Deal::Neighbours => all[shard.range(all.len())].to_vec(),
            Deal::InTurn => shard.every(all.len()).map(|unit| all[unit]).collect(),
        };
        let status = status(&found);
        // They are sorted by their parts, the living before the killed.
        let order = |shard: Shard| (shard.of(), shard.number());
        let at = self.runs.partition_point(|run| order(run.shard) < order(shard));
        let run = self.runs.get(at).filter(|run| run.shard == shard).copied();
        let left = run.filter(|run| run.is_alive).and_then(|run| {
            let is_its = |found: &&Found| matches!(found, Found::Whole(age) if *age <= run.since);
            let computed = found.iter().filter(is_its).count();
            let missing = status.units - status.done;
            (computed > 0).then(|| run.since.mul_f64(missing as f64 / computed as f64))
        });
        Part { shard, status, run, left }
    }
}

fn status(found: &[Found]) -> Status {
    let count = |is: fn(&Found) -> bool| found.iter().filter(|one| is(one)).count();
    Status {
        units: found.len(),
        done: count(|one| matches!(one, Found::Whole(_))),
        damaged: count(|one| *one == Found::Damaged),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(number: usize, of: usize, since_s: u64, is_alive: bool) -> Run {
        let shard = Shard::new(number, of).unwrap();
        Run { shard, process: 7, since: Duration::from_secs(since_s), is_alive }
    }

    #[test]
    fn parts_say_what_is_done_who_computes_and_what_is_left() {
        let whole = |age_s: u64| Found::Whole(Duration::from_secs(age_s));
        let found = vec![
            // Before it began, and since.
            whole(900),
            whole(60),
            whole(10),
            Found::Nothing,
            whole(800),
            Found::Damaged,
            Found::Nothing,
            Found::Nothing,
        ];
        let survey = |deal: Deal| {
            let runs = vec![run(0, 2, 100, true), run(1, 2, 500, false)];
            Survey { deal, found: found.clone(), runs }
        };
        let halves = |survey: &Survey| [0, 1].map(|i| survey.part(Shard::new(i, 2).unwrap()));
        let in_turn = survey(Deal::InTurn);
        let done = halves(&in_turn).map(|part| (part.status.done, part.status.damaged));
        assert_eq!(done, [(3, 0), (1, 1)]);
        let survey = survey(Deal::Neighbours);
        assert_eq!(survey.status(), Status { units: 8, done: 4, damaged: 1 });
        assert_eq!(survey.shards(), Some(2));
        let [first, second] = halves(&survey);
        assert_eq!(first.status, Status { units: 4, done: 3, damaged: 0 });
        // Two units in 100 s, and one is left.
        assert!(first.is_running() && !first.is_done());
        assert_eq!(first.left, Some(Duration::from_secs(50)));
        assert_eq!(second.status, Status { units: 4, done: 1, damaged: 1 });
        assert!(!second.is_running() && second.run.is_some() && second.left.is_none());
        // Another division of the same work.
        let third = survey.part(Shard::new(0, 8).unwrap());
        assert!(third.is_done() && third.run.is_none());
    }

    #[test]
    fn those_that_compute_decide_how_work_is_shared_out() {
        let shards = |runs: Vec<Run>| Survey { deal: Deal::Neighbours, found: Vec::new(), runs }.shards();
        assert_eq!(shards(vec![]), None);
        assert_eq!(shards(vec![run(0, 4, 1, true), run(1, 4, 1, true), run(0, 16, 1, false)]), Some(4));
        assert_eq!(shards(vec![run(0, 4, 1, true), run(0, 1, 1, true)]), None);
        assert_eq!(shards(vec![run(0, 16, 1, false)]), Some(16));
    }
}
