//! What the thread that traces keeps from picture to picture: what stands in the scene, and the film.

use std::sync::Arc;
use std::time::{Duration, Instant};

use barbule::picture::Set;
use barbule::progress::{Progress, Shared};
use barbule::render::film::Film;
use barbule::render::planes::Planes;
use barbule::render::run::{Ended, Goal, ROUND};
use barbule::scene::description::{ReadyScene, SceneDescription};
use barbule::{Error, Result};

use super::job::{Stand, TraceJob};
use super::{Desk, Negative};

/// A small first picture is this many times smaller to each side at first, and at most and least.
const SMALLER: u32 = 8;
const SMALLEST: u32 = 32;
const LARGEST: u32 = 4;
/// It should be there after this time, and be larger where it is there after a part of it.
const SOON: Duration = Duration::from_millis(80);
/// Pictures of at most so many pixels need no smaller ones before them.
const FEW_PIXELS: u64 = 10_000;
/// Where one sample of each pixel takes longer, pictures of sizes between come first.
const LONG: Duration = Duration::from_millis(1500);
/// Within a round that takes long, the picture is developed so often.
const OFTEN: Duration = Duration::from_secs(1);

/// What stands in a scene.
struct Kept {
    stand: Stand,
    ready: ReadyScene,
    set: Set,
    thinned: Option<usize>,
}

/// The film of a view.
struct Shot {
    of: SceneDescription,
    film: Arc<Film>,
    taken: Duration,
}

/// What is kept from picture to picture.
pub(super) struct Studio {
    kept: Option<Kept>,
    /// How many sets there were.
    sets: u64,
    shot: Option<Shot>,
    smaller: u32,
}

impl Default for Studio {
    fn default() -> Self {
        Self { kept: None, sets: 0, shot: None, smaller: SMALLER }
    }
}

/// A job on its way.
struct Work<'a> {
    number: u64,
    job: &'a TraceJob,
    scene: Arc<ReadyScene>,
    progress: &'a Shared,
    desk: &'a Desk,
}

impl Studio {
    /// Traces a picture until it has all its samples; films go to be developed as they come.
    ///
    /// # Errors
    /// Something that the scene names is not there or does not fit into memory, a number out of range, or a stop by `progress` or for
    /// a pause.
    pub(super) fn trace(
        &mut self,
        number: u64,
        job: &TraceJob,
        progress: &Shared,
        desk: &Desk,
    ) -> Result<()> {
        if !self.kept.as_ref().is_some_and(|kept| kept.stand.serves(job)) {
            self.grow(job, progress)?;
        }
        let Some(kept) = &self.kept else { return Err(Error::interrupted()) };
        let (scene, _) = job.ready(Some(&kept.ready), progress)?;
        let work = Work { number, job, scene: Arc::new(scene), progress, desk };
        let of = job.samples_of();
        let goes_on = self.shot.as_ref().is_some_and(|shot| {
            let planes = shot.film.planes();
            shot.of == of
                && shot.film.size() == job.size
                && planes.sensor == job.sensor
                && planes.compositing >= job.denoise
                && counts(&shot.film)[1] <= job.samples
        });
        if !goes_on {
            self.shot = None;
            job.check(true)?;
            self.quick(&work)?;
            if desk.is_wanted_elsewhere() {
                return Err(Error::interrupted());
            }
            let film = Arc::new(Film::with(job.size, job.planes())?);
            self.shot = Some(Shot { of, film, taken: Duration::ZERO });
        }
        self.refine(&work)
    }

    /// Grows what stands in a scene, in place of what stood there.
    fn grow(&mut self, job: &TraceJob, progress: &Shared) -> Result<()> {
        (self.kept, self.shot) = (None, None);
        job.check(false)?;
        let (ready, thinned) = job.ready(None, progress)?;
        let set = Set::new(&ready, job.opening.seed, progress)?;
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        self.kept = Some(Kept { stand: job.stand(), ready, set, thinned });
        self.sets += 1;
        self.smaller = SMALLER;
        Ok(())
    }

    /// One sample of each pixel of a small picture, and of larger ones where the whole takes long.
    fn quick(&mut self, work: &Work<'_>) -> Result<()> {
        let pixels: u64 = work.job.size.iter().map(|side| u64::from(*side)).product();
        if pixels <= FEW_PIXELS {
            return Ok(());
        }
        work.desk.set_quick(Some(Instant::now()));
        let took = self.small(work, self.smaller);
        work.desk.set_quick(None);
        let at = self.smaller;
        self.smaller = match &took {
            Ok(took) if 4 * *took < SOON => at / 2,
            Ok(took) if *took <= SOON => at,
            _ => 2 * at,
        }
        .clamp(LARGEST, SMALLEST);
        let whole = took? * (at * at);
        let mut smaller = at / 2;
        while smaller > 1 && whole > LONG && !work.desk.is_wanted_elsewhere() {
            self.small(work, smaller)?;
            smaller /= 2;
        }
        Ok(())
    }

    /// One sample of each pixel of a picture that is so many times smaller to each side, and how long that took.
    fn small(&mut self, work: &Work<'_>, smaller: u32) -> Result<Duration> {
        let size = work.job.size.map(|side| side.div_ceil(smaller));
        let planes = Planes { compositing: false, ..work.job.planes() };
        let mut film = Film::with(size, planes)?;
        let taken = self.sample(work, &mut film, 1, &mut |_, _| {})?;
        work.desk.develop(self.negative(work, Arc::new(film), taken, true, false));
        Ok(taken)
    }

    /// Adds samples to a film until it has so many, and says how long that took.
    fn sample(
        &self,
        work: &Work<'_>,
        film: &mut Film,
        samples: u32,
        after_round: &mut dyn FnMut(&Film, Duration),
    ) -> Result<Duration> {
        let Some(kept) = &self.kept else { return Err(Error::interrupted()) };
        let begun = Instant::now();
        let goal = Goal { round: ROUND, ..Goal::samples(samples) };
        let ended =
            kept.set.render(&work.scene, film, work.job.opening.seed, goal, work.progress, &mut |film| {
                after_round(film, begun.elapsed());
                Ok(())
            })?;
        match ended {
            Ended::Stopped => Err(Error::interrupted()),
            Ended::Done | Ended::OutOfTime => Ok(begun.elapsed()),
        }
    }

    /// Rounds that each double what there is, until all samples are there.
    fn refine(&mut self, work: &Work<'_>) -> Result<()> {
        let job = work.job;
        let mut is_shown = false;
        loop {
            let Some(mut shot) = self.shot.take() else { return Err(Error::interrupted()) };
            let [there, _] = counts(&shot.film);
            let is_done = there >= job.samples;
            if is_done || work.desk.is_wanted_elsewhere() {
                if is_done || there > 0 && !is_shown {
                    let film = Arc::clone(&shot.film);
                    work.desk.develop(self.negative(work, film, shot.taken, false, is_done));
                }
                self.shot = Some(shot);
                return if is_done { Ok(()) } else { Err(Error::interrupted()) };
            }
            let target = (there + 1).next_power_of_two().min(job.samples);
            let (before, begun) = (shot.taken, Instant::now());
            let mut shown = begun;
            let sampled = self.sample(work, Arc::make_mut(&mut shot.film), target, &mut |film, taken| {
                // A denoised picture comes with each doubling alone.
                if !job.denoise && shown.elapsed() > OFTEN {
                    shown = Instant::now();
                    let film = Arc::new(film.clone());
                    work.desk.develop(self.negative(work, film, before + taken, false, false));
                }
            });
            shot.taken += begun.elapsed();
            let film = Arc::clone(&shot.film);
            let taken = shot.taken;
            self.shot = Some(shot);
            sampled?;
            if target < job.samples {
                work.desk.develop(self.negative(work, film, taken, false, false));
                is_shown = true;
            }
        }
    }

    fn negative(
        &self,
        work: &Work<'_>,
        film: Arc<Film>,
        taken: Duration,
        is_small: bool,
        is_last: bool,
    ) -> Negative {
        Negative {
            number: work.number,
            film,
            scene: Arc::clone(&work.scene),
            set: self.sets,
            holds_exposure: is_small || work.job.is_moving,
            is_small,
            cleans: work.job.denoise && !is_small,
            of: work.job.samples,
            seconds: taken.as_secs_f64(),
            thinned: self.kept.as_ref().and_then(|kept| kept.thinned),
            is_last,
        }
    }
}

/// Samples of the pixels that have fewest and most.
fn counts(film: &Film) -> [u32; 2] {
    let counts = (0..film.tiles()).map(|tile| film.bounds(tile)).map(|[x, y, ..]| film.count(x, y));
    counts.fold([u32::MAX, 0], |[least, most], count| [least.min(count), most.max(count)])
}
