//! How the units of an atlas go on many workers: simulated, with workers that are slow and work that fails.
//!
//! Workers either take the next unit when they are free, as those of a scheduler do, or have their share from the beginning, as the
//! parts of a job array (`--shard i/n`).

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use crate::math::rng::Stream;

/// The name under which the random streams of workers and of failures are drawn.
const PURPOSE: u64 = 0x6174_6c61_7330_0002;

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Faults {
    /// Part of the workers that are slow.
    pub slow_part: f64,
    /// How many times longer these take.
    pub slow_factor: f64,
    /// Part of the units during which the worker dies, at any moment; they are done again.
    pub failing_part: f64,
    /// Seconds until a worker has started, at first and after each death: program, preparation.
    pub start_s: f64,
    /// Seconds that handing out a unit and writing its results take beside its work.
    pub overhead_s: f64,
}

impl Faults {
    /// Nothing goes wrong and nothing takes time but the work.
    pub const NONE: Self =
        Self { slow_part: 0.0, slow_factor: 1.0, failing_part: 0.0, start_s: 0.0, overhead_s: 0.0 };

    /// One worker in a hundred takes thrice as long, one unit in a hundred loses its worker.
    pub const USUAL: Self =
        Self { slow_part: 0.01, slow_factor: 3.0, failing_part: 0.01, start_s: 2.0, overhead_s: 0.01 };
}

/// How a run went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    /// From the first start to the last result, seconds.
    pub seconds: f64,
    /// The units' own seconds over those of all workers until the end.
    pub efficiency: f64,
    /// Units that were begun again.
    pub repeated: usize,
}

/// A time that sorts.
#[derive(Debug, Clone, Copy, PartialEq)]
struct At(f64);

impl Eq for At {}

impl PartialOrd for At {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for At {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl Schedule {
    /// Free workers take the next of the units, which take so many seconds each; what failed goes to the end of the line.
    #[must_use]
    pub fn taken(unit_s: &[f64], workers: usize, faults: &Faults, seed: u64) -> Self {
        let workers = workers.max(1);
        let slowness = slowness(workers, faults, seed);
        let mut line: VecDeque<usize> = (0..unit_s.len()).collect();
        let mut free: BinaryHeap<Reverse<(At, usize)>> =
            (0..workers).map(|worker| Reverse((At(faults.start_s), worker))).collect();
        let (mut end, mut repeated) = (0.0_f64, 0);
        // Failed units are known to have failed only when their worker died.
        let mut failed: BinaryHeap<Reverse<(At, usize)>> = BinaryHeap::new();
        let mut attempts = vec![0_u64; unit_s.len()];
        while let Some(Reverse((At(now), worker))) = free.pop() {
            while failed.peek().is_some_and(|Reverse((at, _))| at.0 <= now) {
                line.extend(failed.pop().map(|Reverse((_, unit))| unit));
            }
            let Some(unit) = line.pop_front() else {
                // Whoever finds nothing waits for what may still fail.
                if let Some(Reverse((at, _))) = failed.peek() {
                    free.push(Reverse((*at, worker)));
                }
                continue;
            };
            let whole = faults.overhead_s + unit_s[unit] * slowness[worker];
            match fails(unit, attempts[unit], faults, seed) {
                None => {
                    let done = now + whole;
                    end = end.max(done);
                    free.push(Reverse((At(done), worker)));
                }
                Some(part) => {
                    let died = now + part * whole;
                    attempts[unit] += 1;
                    repeated += 1;
                    failed.push(Reverse((At(died), unit)));
                    free.push(Reverse((At(died + faults.start_s), worker)));
                }
            }
        }
        Self::of(unit_s, workers, end, repeated)
    }

    /// Worker i of n has units i, i + n and so on; a worker that dies starts again and goes on with what it lacks.
    #[must_use]
    pub fn shared_out(unit_s: &[f64], workers: usize, faults: &Faults, seed: u64) -> Self {
        let workers = workers.max(1);
        let slowness = slowness(workers, faults, seed);
        let (mut end, mut repeated) = (0.0_f64, 0);
        for (worker, slow) in slowness.iter().enumerate() {
            let mut now = faults.start_s;
            for unit in (worker..unit_s.len()).step_by(workers) {
                let whole = faults.overhead_s + unit_s[unit] * slow;
                let mut attempt = 0;
                while let Some(part) = fails(unit, attempt, faults, seed) {
                    now += part * whole + faults.start_s;
                    attempt += 1;
                    repeated += 1;
                }
                now += whole;
            }
            end = end.max(now);
        }
        Self::of(unit_s, workers, end, repeated)
    }

    fn of(unit_s: &[f64], workers: usize, seconds: f64, repeated: usize) -> Self {
        let own: f64 = unit_s.iter().sum();
        let efficiency = if seconds > 0.0 { own / (workers as f64 * seconds) } else { 1.0 };
        Self { seconds, efficiency, repeated }
    }
}

/// How many times longer each worker takes: a given part of them is slow.
fn slowness(workers: usize, faults: &Faults, seed: u64) -> Vec<f64> {
    let slow = (faults.slow_part * workers as f64).round() as usize;
    let order = Stream::new(seed, &[PURPOSE, 0]).permutation(workers);
    let mut all = vec![1.0; workers];
    for worker in order.into_iter().take(slow) {
        all[worker] = faults.slow_factor.max(1.0);
    }
    all
}

/// The part of a unit after which its worker dies, if it does.
fn fails(unit: usize, attempt: u64, faults: &Faults, seed: u64) -> Option<f64> {
    // A unit that always failed would never end.
    const MOST: u64 = 20;
    let mut stream = Stream::new(seed, &[PURPOSE, 1, unit as u64, attempt]);
    (attempt < MOST && stream.unit() < faults.failing_part).then(|| stream.unit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_units_fill_all_workers() {
        for workers in [1, 4, 10] {
            let units = vec![2.0; 40];
            let taken = Schedule::taken(&units, workers, &Faults::NONE, 1);
            assert_eq!((taken.seconds, taken.repeated), (80.0 / workers as f64, 0));
            assert!((taken.efficiency - 1.0).abs() < 1e-12);
            assert_eq!(Schedule::shared_out(&units, workers, &Faults::NONE, 1), taken);
        }
    }

    #[test]
    fn a_slow_worker_holds_up_shares_and_hardly_a_line() {
        let faults = Faults { slow_part: 0.1, slow_factor: 3.0, ..Faults::NONE };
        let units = vec![1.0; 1000];
        let [line, shares] =
            [Schedule::taken(&units, 10, &faults, 1), Schedule::shared_out(&units, 10, &faults, 1)];
        assert_eq!(shares.seconds, 300.0);
        // Nine and a third workers.
        assert!((line.seconds - 1000.0 / (9.0 + 1.0 / 3.0)).abs() < 3.0, "{line:?}");
    }

    #[test]
    fn what_fails_is_done_again_and_everything_ends() {
        let faults = Faults { failing_part: 0.2, start_s: 1.0, ..Faults::NONE };
        let units = vec![1.0; 500];
        for schedule in [Schedule::taken(&units, 7, &faults, 3), Schedule::shared_out(&units, 7, &faults, 3)]
        {
            assert!((80..180).contains(&schedule.repeated), "{schedule:?}");
            assert!(schedule.efficiency > 0.5 && schedule.efficiency < 0.9, "{schedule:?}");
        }
        let always = Faults { failing_part: 1.0, ..Faults::NONE };
        assert_eq!(Schedule::taken(&[1.0], 2, &always, 1).repeated, 20);
        assert_eq!(Schedule::taken(&[], 3, &Faults::NONE, 1).seconds, 0.0);
    }
}
