//! Pictures by the renderer's own samples, better and better, beside the window.
//!
//! A [`Tracer`] has two threads: one adds samples to a film, one develops films as `barbule render` does, so that samples never wait for a
//! picture. What stands in a scene is grown once and kept for as long as only lamps, camera and development change. A new view is
//! seen in a small, noisy picture first, then in the size that was asked for, with 1, 2, 4, 8 … samples per pixel; the last picture has the
//! bytes of `barbule render` with the same scene, seed and number of samples.

mod darkroom;
mod job;
mod studio;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use barbule::progress::{Shared, Snapshot};
use barbule::render::film::Film;
use barbule::scene::camera::Camera;
use barbule::scene::description::ReadyScene;
use barbule::{DVec3, Error, Result};
use glam::DVec2;

pub use job::TraceJob;

use self::studio::Studio;

/// A small picture of a moved camera that is not there after this time is given up for a newer view.
const QUICK: Duration = Duration::from_millis(90);

/// A picture as far as it is traced.
#[derive(Debug, Clone)]
pub struct TracedPicture {
    /// Width and height, pixels: those that were asked for, or less in the first moments of a view.
    pub size: [u32; 2],
    /// RGBA, 8 bits, row by row; alpha is not multiplied in, and 255 where something stands behind the scene.
    pub rgba: Vec<u8>,
    /// Samples per pixel so far, mean over the picture.
    pub samples: f64,
    /// Samples per pixel that were asked for.
    pub of: u32,
    /// Standard error of a pixel's luminance over the luminance, in the tile that has most of it; unknown below two samples.
    pub noise: Option<f64>,
    /// Time that its samples took, s; what stands in the scene was grown before.
    pub seconds: f64,
    /// Factor from radiance to linear values that it was exposed by.
    pub exposure: f64,
    /// Whether it is smaller than was asked for.
    pub is_small: bool,
    /// What took its noise away, if anything did.
    pub denoised_by: Option<String>,
    /// Where a material was simulated coarsely: every so many-th wavelength and direction.
    pub thinned: Option<usize>,
    /// The camera.
    pub camera: Camera,
    /// How far the first hit is, mm along the ray through the pixel's middle, mean over samples; 0 where more than half hit nothing. Row by row.
    depth_mm: Vec<f32>,
}

impl TracedPicture {
    /// The place of the scene that is seen at a point of the picture, mm; nothing where the background is. `at`: 0 … 1 from left to right and from
    /// top to bottom.
    #[must_use]
    pub fn place(&self, at: [f64; 2]) -> Option<DVec3> {
        let pixel = |k: usize| ((at[k] * f64::from(self.size[k])) as u32).min(self.size[k].saturating_sub(1));
        let index = pixel(1) as usize * self.size[0] as usize + pixel(0) as usize;
        let depth = f64::from(self.depth_mm.get(index).copied().unwrap_or_default());
        if !at.iter().all(|x| (0.0..=1.0).contains(x)) || depth <= 0.0 {
            return None;
        }
        let ray = self.camera.ray(DVec2::from(at), DVec2::splat(0.5), self.size);
        Some(ray.origin + ray.direction * depth)
    }
}

/// Something that a tracer tells.
#[derive(Debug)]
pub enum TraceUpdate {
    /// The newest picture.
    Picture(Arc<TracedPicture>),
    /// Something that people should know, in a sentence.
    Note(String),
    /// All samples are there, and their picture is told.
    Done,
    /// There is no picture: why.
    Failed(Error),
}

/// Traces pictures of one scene after another, the newest. It ends with its owner, at once.
pub struct Tracer {
    desk: Arc<Desk>,
    thread: Option<JoinHandle<()>>,
}

/// What its threads and their owner share.
struct Desk {
    state: Mutex<OnDesk>,
    /// Rung for the thread that traces.
    tracing: Condvar,
    /// Rung for the thread that develops.
    developing: Condvar,
    wake: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct OnDesk {
    /// The number of the newest job.
    newest: u64,
    /// The first job of what stands in the newest one's scene: pictures of older ones show something else.
    oldest_shown: u64,
    /// The newest job.
    asked: Option<Arc<TraceJob>>,
    /// The job that waits.
    next: Option<Waiting>,
    running: Option<Running>,
    is_paused: bool,
    is_closed: bool,
    /// The film to be developed, the newest.
    negative: Option<Negative>,
    is_developing: bool,
    told: Told,
}

/// A job that waits.
struct Waiting {
    number: u64,
    job: Arc<TraceJob>,
    /// Whether it was begun and went back onto the desk, when somebody asked for a pause.
    is_begun: bool,
}

/// The job that runs.
struct Running {
    progress: Arc<Shared>,
    /// Since when it has been at its small first picture.
    quick_since: Option<Instant>,
}

/// What was told and not fetched yet.
#[derive(Default)]
struct Told {
    picture: Option<Arc<TracedPicture>>,
    notes: Vec<String>,
    done: Option<u64>,
    failed: Option<(u64, Error)>,
}

/// A film that waits to be developed.
struct Negative {
    number: u64,
    film: Arc<Film>,
    scene: Arc<ReadyScene>,
    /// Of what stands in the scene: another one is exposed anew.
    set: u64,
    /// Whether the exposure that was found last holds where lamps and set are the same.
    holds_exposure: bool,
    is_small: bool,
    cleans: bool,
    of: u32,
    seconds: f64,
    thinned: Option<usize>,
    is_last: bool,
}

impl Desk {
    fn state(&self) -> MutexGuard<'_, OnDesk> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands a film over to be developed, in place of one that waits.
    fn develop(&self, negative: Negative) {
        self.state().negative = Some(negative);
        self.developing.notify_one();
    }

    fn note(&self, sentence: String) {
        let mut state = self.state();
        if !state.told.notes.contains(&sentence) {
            state.told.notes.push(sentence);
        }
        drop(state);
        (self.wake)();
    }

    fn fail(&self, number: u64, error: Error) {
        self.state().told.failed = Some((number, error));
        (self.wake)();
    }

    /// Marks the beginning or end of a small first picture.
    fn set_quick(&self, since: Option<Instant>) {
        if let Some(running) = &mut self.state().running {
            running.quick_since = since;
        }
    }

    /// Whether somebody wants something else than the job that runs to go on.
    fn is_wanted_elsewhere(&self) -> bool {
        let state = self.state();
        state.is_closed || state.is_paused || state.next.is_some()
    }
}

impl OnDesk {
    /// Stops what runs, but for a small first picture that is nearly there.
    fn interrupt(&self, spares_quick: bool) {
        let Some(running) = &self.running else { return };
        let is_near = running.quick_since.is_some_and(|since| since.elapsed() < QUICK);
        if !(spares_quick && is_near) {
            running.progress.cancel();
        }
    }
}

impl Tracer {
    /// Starts the threads. `wake` is called on them whenever something is told, as to draw the window anew.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> Result<Self> {
        let desk = Arc::new(Desk {
            state: Mutex::default(),
            tracing: Condvar::new(),
            developing: Condvar::new(),
            wake: Box::new(wake),
        });
        let thread = |name: &str, life: fn(&Desk)| {
            let own = Arc::clone(&desk);
            let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || life(&own));
            thread
                .map_err(|error| Error::machine(format!("the thread that traces cannot be started: {error}")))
        };
        // A picture that is being developed is nobody's any more once the owner is gone: that thread is not waited for.
        thread("developing", darkroom::life)?;
        let tracing = thread("tracing", life);
        if tracing.is_err() {
            desk.state().is_closed = true;
            desk.developing.notify_one();
        }
        Ok(Self { thread: Some(tracing?), desk })
    }

    /// Asks for a picture in place of whatever is traced. What stands in the scene is grown anew only where it is another; samples are kept
    /// where only their number, the denoising or the development changed. Openings of one tracer know the same media.
    pub fn ask(&self, job: TraceJob) {
        let mut state = self.desk.state();
        state.newest += 1;
        let is_other = state.asked.as_ref().is_none_or(|asked| !asked.shows_the_same_as(&job));
        if is_other {
            state.oldest_shown = state.newest;
            state.told.picture = None;
        }
        let job = Arc::new(job);
        state.asked = Some(Arc::clone(&job));
        state.next = Some(Waiting { number: state.newest, job, is_begun: false });
        (state.told.failed, state.told.done) = (None, None);
        state.interrupt(!is_other);
        self.desk.tracing.notify_one();
    }

    /// Asks for the same with changes, as of the camera or of lamps. Whether something was asked for before.
    pub fn change(&self, change: impl FnOnce(&mut TraceJob)) -> bool {
        let asked = self.desk.state().asked.clone();
        let Some(asked) = asked else { return false };
        let mut job = asked.as_ref().clone();
        change(&mut job);
        self.ask(job);
        true
    }

    /// Samples wait, or go on where they were. A view that is asked for meanwhile has its small first picture.
    pub fn pause(&self, is_paused: bool) {
        let mut state = self.desk.state();
        state.is_paused = is_paused;
        if is_paused {
            state.interrupt(true);
        }
        self.desk.tracing.notify_one();
    }

    /// Whether samples wait.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.desk.state().is_paused
    }

    /// Stops what runs and forgets what waits; what has been grown is kept.
    pub fn stop(&self) {
        let mut state = self.desk.state();
        state.newest += 1;
        (state.oldest_shown, state.next, state.asked, state.negative) = (state.newest, None, None, None);
        state.told = Told::default();
        state.interrupt(false);
    }

    /// How far a stage of the job is that runs, with its name: growing feathers, or rendering.
    #[must_use]
    pub fn progress(&self) -> Option<Snapshot> {
        self.desk.state().running.as_ref().map(|running| running.progress.snapshot())
    }

    /// Whether something is traced or developed, or waits for it; what was paused does not.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        let state = self.desk.state();
        let waits = state.next.as_ref().is_some_and(|next| !(state.is_paused && next.is_begun));
        waits || state.running.is_some() || state.negative.is_some() || state.is_developing
    }

    /// What was told since the last call, pictures but the newest left out.
    #[must_use]
    pub fn updates(&self) -> Vec<TraceUpdate> {
        let mut state = self.desk.state();
        let newest = state.newest;
        let told = std::mem::take(&mut state.told);
        let notes = told.notes.into_iter().map(TraceUpdate::Note);
        let failed = told.failed.filter(|(number, _)| *number == newest);
        let failed = failed.map(|(_, error)| TraceUpdate::Failed(error));
        let done = told.done.filter(|number| *number == newest).map(|_| TraceUpdate::Done);
        told.picture.map(TraceUpdate::Picture).into_iter().chain(notes).chain(failed).chain(done).collect()
    }
}

impl Drop for Tracer {
    fn drop(&mut self) {
        {
            let mut state = self.desk.state();
            state.is_closed = true;
            state.next = None;
            state.interrupt(false);
        }
        self.desk.tracing.notify_one();
        self.desk.developing.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of a job is caught there; of the thread itself nothing is left to do.
            let _ = thread.join();
        }
    }
}

/// The life of the thread that traces: waits for a job and does it.
fn life(desk: &Desk) {
    let mut studio = Studio::default();
    while let Some((Waiting { number, job, .. }, progress)) = taken(desk) {
        let done = catch_unwind(AssertUnwindSafe(|| studio.trace(number, &job, &progress, desk)));
        let mut state = desk.state();
        state.running = None;
        let is_newest = state.next.is_none() && number == state.newest;
        match done {
            Ok(Ok(())) => {}
            Ok(Err(error)) if error.is_interrupted() => {
                if state.is_paused && is_newest {
                    state.next = Some(Waiting { number, job, is_begun: true });
                }
            }
            Ok(Err(error)) => {
                drop(state);
                desk.fail(number, error);
            }
            Err(_) => {
                drop(state);
                // What it left may be half made.
                studio = Studio::default();
                desk.fail(
                    number,
                    Error::machine("tracing the picture ended unexpectedly; move something to try again"),
                );
            }
        }
    }
}

/// The job that waits, once there is one that may run; none once the desk is closed.
fn taken(desk: &Desk) -> Option<(Waiting, Arc<Shared>)> {
    let mut state = desk.state();
    loop {
        if state.is_closed {
            return None;
        }
        let is_paused = state.is_paused;
        if let Some(next) = state.next.take_if(|next| !(is_paused && next.is_begun)) {
            let progress = Arc::new(Shared::default());
            state.running = Some(Running { progress: Arc::clone(&progress), quick_since: None });
            return Some((next, progress));
        }
        state = desk.tracing.wait(state).unwrap_or_else(PoisonError::into_inner);
    }
}

#[cfg(test)]
mod tests;
