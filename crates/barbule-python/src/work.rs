//! Work without the interpreter's lock: on as many threads as asked, watched, and stopped by Ctrl-C.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use barbule::progress::{Progress, Shared};
use barbule::{Error, Result};
use pyo3::prelude::*;

use crate::error::{OrRaise as _, raised};

/// How often signals are looked for and progress is told.
const LOOK: Duration = Duration::from_millis(50);

/// Progress as numbers, and what the library has to say on the way.
#[derive(Default)]
pub(crate) struct Watched {
    shared: Shared,
    said: std::sync::Mutex<Vec<String>>,
}

impl Progress for Watched {
    fn begin(&self, label: &str, total: u64) {
        self.shared.begin(label, total);
    }

    fn advance(&self, steps: u64) {
        self.shared.advance(steps);
    }

    fn is_cancelled(&self) -> bool {
        self.shared.is_cancelled()
    }

    fn doubt(&self, what: &str) {
        self.said.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(what.to_owned());
    }
}

/// What a call says about how it is computed.
#[derive(Default)]
pub(crate) struct How {
    /// Threads; as many as there are cores without one.
    pub(crate) threads: Option<usize>,
    /// Called as `progress(label, done, total)` from the calling thread, a few times a second; an exception stops the work.
    pub(crate) progress: Option<Py<PyAny>>,
}

impl How {
    pub(crate) fn new(threads: Option<usize>, progress: Option<Py<PyAny>>) -> Self {
        Self { threads, progress }
    }

    /// Runs work on its own thread while this one, which has the interpreter's signals, waits without the lock.
    pub(crate) fn run<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&dyn Progress) -> Result<T> + Send,
    ) -> PyResult<T> {
        let pool = self.pool().or_raise(py)?;
        let watched = Watched::default();
        let (found, raised_here) = std::thread::scope(|scope| {
            let (done, mut ended) = channel();
            let watching = &watched;
            let worker = scope.spawn(move || {
                let found = match &pool {
                    Some(pool) => pool.install(|| work(watching)),
                    None => work(watching),
                };
                // Nobody listens if the caller has given up.
                let _ = done.send(());
                found
            });
            let mut failure: Option<PyErr> = None;
            loop {
                // The receiver is this thread's alone, so that it moves in and out of the closure.
                let (waited, back) = py.detach(move || (ended.recv_timeout(LOOK), ended));
                ended = back;
                if !matches!(waited, Err(RecvTimeoutError::Timeout)) {
                    break;
                }
                if failure.is_none()
                    && let Err(error) = self.tell(py, &watched.shared)
                {
                    failure = Some(error);
                    watched.shared.cancel();
                }
            }
            (py.detach(|| worker.join()), failure)
        });
        if let Some(error) = raised_here {
            return Err(error);
        }
        warn(py, &watched)?;
        match found {
            Ok(found) => found.map_err(|error| raised(py, &error)),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }

    fn tell(&self, py: Python<'_>, shared: &Shared) -> PyResult<()> {
        py.check_signals()?;
        let Some(progress) = &self.progress else { return Ok(()) };
        let now = shared.snapshot();
        if now.stage == 0 {
            return Ok(());
        }
        progress.call1(py, (now.label, now.done, now.total)).map(|_| ())
    }

    pub(crate) fn pool(&self) -> Result<Option<rayon::ThreadPool>> {
        let Some(threads) = self.threads else { return Ok(None) };
        if !(1..=4096).contains(&threads) {
            return Err(Error::input(format!("'threads' is {threads}; give a number from 1 to 4096")));
        }
        let built = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        built.map(Some).map_err(|error| Error::machine(format!("threads cannot be started: {error}")))
    }
}

/// What the library doubts becomes `barbule.errors.DoubtWarning`s.
fn warn(py: Python<'_>, watched: &Watched) -> PyResult<()> {
    let said = watched.said.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if said.is_empty() {
        return Ok(());
    }
    let errors = py.import("barbule.errors")?;
    said.iter().try_for_each(|doubt| errors.call_method1("doubt", (doubt,)).map(|_| ()))
}
