//! A workbench: one worker that computes one kind of result, and what it was asked for last.

use std::time::Duration;

use super::{Job, Update, Worker};
use crate::Result;

/// A worker that is asked anew only when what its result depends on has changed.
pub(super) struct Bench<K> {
    worker: Worker,
    /// What the newest result depends on; none where nothing is wanted.
    asked: Option<K>,
    /// Whether more of the newest job is to come.
    is_open: bool,
    /// Whether the newest job has found something.
    has_found: bool,
    /// The stage that runs, and when it began, s of the window's clock.
    stage: (u64, f64),
}

/// How far a job is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pace {
    /// What is done, in the words of who does it.
    pub label: String,
    /// The part that is done, 0 to 1.
    pub fraction: f64,
    /// The time that is left at the pace so far.
    pub left: Option<Duration>,
}

impl<K: PartialEq> Bench<K> {
    /// A bench without work; `wake` is called when its worker has something to tell.
    pub(super) fn new(wake: impl Fn() + Send + 'static) -> Result<Self> {
        Ok(Self {
            worker: Worker::start(wake)?,
            asked: None,
            is_open: false,
            has_found: false,
            stage: (0, 0.0),
        })
    }

    /// Asks for a result that depends on `key`, unless it is asked for already; without a key nothing is wanted. `job` makes the job, or
    /// none where there is nothing to compute. Whether something has changed.
    ///
    /// # Errors
    /// As `job`; it is not asked again before the key changes.
    pub(super) fn want(&mut self, key: Option<K>, job: impl FnOnce() -> Result<Option<Job>>) -> Result<bool> {
        if key == self.asked {
            return Ok(false);
        }
        let is_wanted = key.is_some();
        self.asked = key;
        self.stop();
        self.has_found = false;
        if is_wanted && let Some(job) = job()? {
            self.ask(job);
        }
        Ok(true)
    }

    /// Asks for a job in place of the one that runs, which its result depends on as before.
    pub(super) fn ask(&mut self, job: Job) {
        self.worker.ask(job);
        (self.is_open, self.stage) = (true, (0, 0.0));
    }

    /// Stops what runs; what was found stays.
    pub(super) fn stop(&mut self) {
        if self.is_open {
            self.worker.stop();
            self.is_open = false;
        }
    }

    /// Whether more is to come.
    pub(super) fn is_open(&self) -> bool {
        self.is_open
    }

    /// Whether the newest job has found something.
    pub(super) fn has_found(&self) -> bool {
        self.has_found
    }

    /// What was told since the last call.
    pub(super) fn updates(&mut self) -> Vec<Update> {
        let updates = self.worker.updates();
        for update in &updates {
            match update {
                Update::Found(_) => self.has_found = true,
                Update::Done | Update::Failed(_) => self.is_open = false,
            }
        }
        updates
    }

    /// How far it is; `now` is the window's clock, s.
    pub(super) fn pace(&mut self, now: f64) -> Option<Pace> {
        let snapshot = self.worker.progress().filter(|_| self.is_open)?;
        if self.stage.0 != snapshot.stage {
            self.stage = (snapshot.stage, now);
        }
        let elapsed = Duration::try_from_secs_f64(now - self.stage.1).unwrap_or_default();
        Some(Pace { fraction: snapshot.fraction(), left: snapshot.left(elapsed), label: snapshot.label })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::{FilmJob, Found};
    use barbule::material::Library;
    use barbule::spectrum::Wavelengths;
    use barbule::stack::Stack;
    use std::time::Instant;

    fn film() -> Job {
        let stack = Stack::parse("air/keratin:300/air", &Library::builtin()).unwrap();
        Job::Film(FilmJob { stack, at: Wavelengths::usual(), angle: vec![0.0], individuals: 1, seed: 1 })
    }

    #[test]
    fn a_job_is_asked_for_once_for_each_key() {
        let mut bench = Bench::new(|| {}).unwrap();
        assert!(bench.want(Some(1), || Ok(Some(film()))).unwrap());
        assert!(bench.is_open() && !bench.want(Some(1), || panic!("it is asked for already")).unwrap());
        let start = Instant::now();
        let mut updates = Vec::new();
        while bench.is_open() && start.elapsed() < Duration::from_secs(20) {
            updates.extend(bench.updates());
        }
        assert!(matches!(&updates[..], [Update::Found(Found::Film(_)), Update::Done]) && bench.has_found());
        // A job that cannot be made is not tried again.
        assert!(bench.want(Some(2), || Err(crate::Error::input("no"))).is_err());
        assert!(!bench.want(Some(2), || panic!("it was refused already")).unwrap());
        assert!(bench.want(None, || panic!("nothing is wanted")).unwrap());
        assert!(bench.asked.is_none() && !bench.is_open() && bench.pace(1.0).is_none());
    }
}
