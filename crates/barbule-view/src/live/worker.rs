//! A thread beside the window that does one job at a time: the newest.
//!
//! A job that is asked for while another runs stops that one and takes the place of any that waits, so that a slider that is dragged
//! always shows what it was moved to last, and never what it passed.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use barbule::progress::{Shared, Snapshot};
use barbule::{Error, Result};

use super::{Found, Job, run};

/// Something that a worker tells.
#[derive(Debug)]
pub enum Update {
    /// It found something.
    Found(Found),
    /// The job is done: nothing more comes of it.
    Done,
    /// The job ended with an error; a job that was stopped tells nothing.
    Failed(Error),
}

/// A thread that does jobs. It ends with its owner, at once.
pub struct Worker {
    desk: Arc<Desk>,
    told: Receiver<(u64, Update)>,
    thread: Option<JoinHandle<()>>,
}

/// What the worker and its owner share.
#[derive(Default)]
struct Desk {
    state: Mutex<OnDesk>,
    bell: Condvar,
}

#[derive(Default)]
struct OnDesk {
    /// The number of the newest job.
    newest: u64,
    /// The job that waits.
    next: Option<Job>,
    /// How far the job is that runs.
    running: Option<Arc<Shared>>,
    is_closed: bool,
}

impl Desk {
    fn state(&self) -> MutexGuard<'_, OnDesk> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Worker {
    /// Starts the thread. `wake` is called on it whenever something is told, as to draw the window anew.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(wake: impl Fn() + Send + 'static) -> Result<Self> {
        let desk = Arc::new(Desk::default());
        let (tell, told) = channel();
        let own = Arc::clone(&desk);
        let thread = std::thread::Builder::new()
            .name("live".to_owned())
            .spawn(move || work(&own, &tell, &wake))
            .map_err(|error| {
                Error::machine(format!("the thread that computes cannot be started: {error}"))
            })?;
        Ok(Self { desk, told, thread: Some(thread) })
    }

    /// Asks for a job in place of whatever runs or waits; the job's number.
    pub fn ask(&self, job: Job) -> u64 {
        let mut state = self.desk.state();
        state.newest += 1;
        state.next = Some(job);
        state.running.iter().for_each(|progress| progress.cancel());
        self.desk.bell.notify_one();
        state.newest
    }

    /// Stops what runs and forgets what waits.
    pub fn stop(&self) {
        let mut state = self.desk.state();
        state.newest += 1;
        state.next = None;
        state.running.iter().for_each(|progress| progress.cancel());
    }

    /// How far the job is that runs; none where nothing does.
    #[must_use]
    pub fn progress(&self) -> Option<Snapshot> {
        self.desk.state().running.as_ref().map(|progress| progress.snapshot())
    }

    /// Whether a job runs or waits.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        let state = self.desk.state();
        state.next.is_some() || state.running.is_some()
    }

    /// What was told of the newest job since the last call; what older ones told is gone.
    #[must_use]
    pub fn updates(&self) -> Vec<Update> {
        let newest = self.desk.state().newest;
        self.told.try_iter().filter(|(number, _)| *number == newest).map(|(_, update)| update).collect()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        {
            let mut state = self.desk.state();
            state.is_closed = true;
            state.next = None;
            state.running.iter().for_each(|progress| progress.cancel());
        }
        self.desk.bell.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of a job is caught there; of the thread itself nothing is left to do.
            let _ = thread.join();
        }
    }
}

/// The thread's life: waits for a job, does it, tells what comes of it.
fn work(desk: &Desk, tell: &Sender<(u64, Update)>, wake: &dyn Fn()) {
    while let Some((number, job, progress)) = taken(desk) {
        let send = |update: Update| {
            // Nobody listens once the owner is gone.
            if tell.send((number, update)).is_ok() {
                wake();
            }
        };
        let done =
            catch_unwind(AssertUnwindSafe(|| run(&job, &*progress, &mut |found| send(Update::Found(found)))));
        desk.state().running = None;
        match done {
            Ok(Ok(())) => send(Update::Done),
            Ok(Err(error)) if error.is_interrupted() => {}
            Ok(Err(error)) => send(Update::Failed(error)),
            Err(_) => send(Update::Failed(Error::machine(
                "the computation ended unexpectedly; the window goes on, with what was computed before",
            ))),
        }
    }
}

/// The job that waits, once there is one; none once the desk is closed.
fn taken(desk: &Desk) -> Option<(u64, Job, Arc<Shared>)> {
    let mut state = desk.state();
    loop {
        if state.is_closed {
            return None;
        }
        if let Some(job) = state.next.take() {
            let progress = Arc::new(Shared::default());
            state.running = Some(Arc::clone(&progress));
            return Some((state.newest, job, progress));
        }
        state = desk.bell.wait(state).unwrap_or_else(PoisonError::into_inner);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::{FilmJob, MeanJob};
    use barbule::campaign::spectrum::Collect;
    use barbule::material::Library;
    use barbule::spectrum::Wavelengths;
    use barbule::stack::Stack;
    use barbule::structure::Structure;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::{Duration, Instant};

    /// Most time that a job of minutes may go on after it was stopped; a tenth of it on a machine with nothing else to do.
    const AT_ONCE: Duration = Duration::from_secs(1);

    fn film(nm: f64) -> Job {
        let stack = Stack::parse(&format!("air/keratin:{nm}/air"), &Library::builtin()).unwrap();
        Job::Film(FilmJob { stack, at: Wavelengths::usual(), angle: vec![0.0], individuals: 1, seed: 1 })
    }

    /// A job that takes minutes.
    fn long() -> Job {
        Job::Mean(Box::new(MeanJob {
            structure: Structure::builtin("starling").unwrap(),
            at: Wavelengths::usual(),
            angle: (0..40).map(|k| 0.02 * f64::from(k)).collect(),
            individuals: 2000,
            seed: 1,
            collect: Collect::Hemisphere,
        }))
    }

    /// Waits until a condition holds, and says how long that took.
    fn until(condition: impl Fn() -> bool) -> Duration {
        let start = Instant::now();
        while !condition() {
            assert!(start.elapsed() < Duration::from_secs(60), "it never happens");
            std::thread::sleep(Duration::from_millis(1));
        }
        start.elapsed()
    }

    fn films(updates: &[Update]) -> Vec<f64> {
        let first = |update: &Update| match update {
            Update::Found(Found::Film(curves)) => Some(curves.reflected[0]),
            _ => None,
        };
        updates.iter().filter_map(first).collect()
    }

    fn reflected(nm: f64) -> f64 {
        let Job::Film(job) = film(nm) else { panic!() };
        crate::live::film(&job, &barbule::Unobserved).unwrap().reflected[0]
    }

    #[test]
    fn the_newest_job_wins_and_what_older_ones_tell_is_gone() {
        let woken = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&woken);
        let worker = Worker::start(move || _ = count.fetch_add(1, Ordering::Relaxed)).unwrap();
        worker.ask(long());
        until(|| worker.progress().is_some_and(|now| now.stage > 0));
        for nm in 100..200 {
            worker.ask(film(f64::from(nm)));
        }
        until(|| !worker.is_busy());
        // The last one is told after it has ended.
        let mut updates = Vec::new();
        let start = Instant::now();
        while !matches!(updates.last(), Some(Update::Done)) && start.elapsed() < Duration::from_secs(10) {
            updates.extend(worker.updates());
        }
        assert_eq!(films(&updates), [reflected(199.0)]);
        assert!(woken.load(Ordering::Relaxed) >= 2);
        assert!(worker.updates().is_empty());
    }

    /// The least of a few, since whatever else a machine does delays threads.
    #[test]
    fn what_runs_stops_at_once() {
        let worker = Worker::start(|| {}).unwrap();
        let stopped = |_| {
            worker.ask(long());
            until(|| worker.progress().is_some_and(|now| now.done > 0));
            worker.stop();
            until(|| !worker.is_busy())
        };
        let took = (0..5).map(stopped).min().unwrap();
        assert!(took < AT_ONCE, "{took:?}");
        assert!(worker.updates().is_empty());
        // An owner that goes away need not wait either.
        let dropped = |_| {
            let worker = Worker::start(|| {}).unwrap();
            worker.ask(long());
            until(|| worker.progress().is_some_and(|now| now.done > 0));
            let start = Instant::now();
            drop(worker);
            start.elapsed()
        };
        let took = (0..5).map(dropped).min().unwrap();
        assert!(took < AT_ONCE, "{took:?}");
    }

    #[test]
    fn errors_are_told_and_the_worker_goes_on() {
        let worker = Worker::start(|| {}).unwrap();
        let Job::Film(job) = film(100.0) else { panic!() };
        worker.ask(Job::Film(FilmJob { angle: vec![2.0], ..job }));
        until(|| !worker.is_busy());
        let mut told = Vec::new();
        let start = Instant::now();
        while told.is_empty() && start.elapsed() < Duration::from_secs(10) {
            told = worker.updates();
        }
        assert!(matches!(&told[..], [Update::Failed(error)] if error.is_input()), "{told:?}");
        worker.ask(film(150.0));
        let mut updates = Vec::new();
        while !matches!(updates.last(), Some(Update::Done)) && start.elapsed() < Duration::from_secs(20) {
            updates.extend(worker.updates());
        }
        assert_eq!(films(&updates), [reflected(150.0)]);
    }
}
