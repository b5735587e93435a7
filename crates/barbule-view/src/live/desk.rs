//! What is computed beside the window: from what is open, and how it is looked at, to the jobs that are asked for, and from what they
//! find to [`Results`].

use std::sync::Arc;

use barbule::open::Opening;

use super::bench::{Bench, Pace};
use super::benches::{Benches, Order, Wake, Who, bench};
use super::results::{Known, Results};
use super::{Found, Job, MaterialJob, ShowJob, Update};
use crate::state::{Mode, Seer, State};
use crate::{Error, Result};

/// Individuals of a mean.
const INDIVIDUALS: usize = 50;
/// Pixels along the diameter of a lobe.
const LOBE_PIXELS: usize = 128;

/// How much is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Individuals of a mean.
    pub individuals: usize,
    /// Pixels along the diameter of a lobe.
    pub lobe_pixels: usize,
    /// Whether anything can be drawn.
    pub draws: bool,
}

impl Default for Effort {
    fn default() -> Self {
        Self { individuals: INDIVIDUALS, lobe_pixels: LOBE_PIXELS, draws: true }
    }
}

/// What the picture's shape and coat depend on; light and camera are not among it.
#[derive(Debug, Clone, PartialEq)]
struct ShowOf {
    who: Who,
    mode: Mode,
    preset: Option<String>,
    eye: Seer,
    hash: Option<String>,
}

/// What has become known since the last look.
#[derive(Default)]
pub(crate) struct News {
    /// What went wrong.
    pub errors: Vec<Error>,
    /// Something else to be drawn.
    pub show: Option<Box<crate::stage::Show>>,
}

/// What is computed at the moment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Busy {
    /// Of what kind of result, as in `material`.
    pub what: &'static str,
    /// What is done, in the words of who does it.
    pub label: String,
    /// The part that is done, 0 to 1.
    pub fraction: f64,
    /// The time that is left, s.
    pub left_s: Option<f64>,
}

/// The workers, and what they were asked for.
pub(crate) struct Desk {
    own: Benches,
    pinned: Benches,
    show: Bench<ShowOf>,
}

impl Desk {
    /// Starts the workers; `wake` draws the window anew.
    ///
    /// # Errors
    /// The system gives no thread.
    pub(crate) fn new(wake: impl Fn() + Send + Sync + 'static) -> Result<Self> {
        let wake: Wake = Arc::new(wake);
        Ok(Self { own: Benches::new(&wake)?, pinned: Benches::new(&wake)?, show: bench(&wake)? })
    }

    /// Asks for whatever has changed, takes what was found, and says what else is new.
    pub(crate) fn follow(&mut self, state: &State, effort: Effort, results: &mut Results) -> News {
        let mut news = News::default();
        let (view, opening) = (state.view(), state.opening());
        let sides = [
            (&mut self.own, Some(state.subject()), &mut results.own),
            (&mut self.pinned, state.pinned(), &mut results.pinned),
        ];
        for (benches, subject, of) in sides {
            let order = Order { view, opening, effort };
            let outcome = benches.ask(subject, &order, of);
            news.errors.extend(outcome.err());
            news.errors.extend(benches.take(subject, &order, of));
        }
        if effort.draws {
            news.errors.extend(self.ask_show(state, &results.own).err());
        }
        for update in self.show.updates() {
            match update {
                Update::Found(Found::Show(show)) => news.show = Some(show),
                Update::Failed(error) => news.errors.push(error),
                Update::Found(_) | Update::Done => {}
            }
        }
        news
    }

    fn ask_show(&mut self, state: &State, of: &Known) -> Result<()> {
        let (subject, view) = (state.subject(), state.view());
        // Whether there is a material is known in a moment; until then what was drawn stays.
        let is_looked_for = self.own.material.is_open() && !self.own.material.has_found();
        if view.mode == Mode::Scene || is_looked_for {
            return Ok(());
        }
        // Flat layers are drawn as what they are, whatever material was made of them.
        let material = of.material.as_ref().filter(|_| subject.stack().is_none());
        let hash = material.map(|found| found.found.hash.clone());
        let key = ShowOf {
            who: Who::of(subject),
            mode: view.mode,
            preset: view.preset.clone(),
            eye: view.eye.clone(),
            hash,
        };
        let job = || Ok(Some(Job::Show(Box::new(ShowJob::of(state, material)?))));
        self.show.want(Some(key), job).map(|_| ())
    }

    /// Makes the material of what is open.
    ///
    /// # Errors
    /// There is no structure that it could be made of.
    pub(crate) fn make_material(&mut self, state: &State, whole: bool) -> Result<()> {
        let Some(structure) = state.structure()? else {
            return Err(Error::input(format!(
                "of a {} no material is made; open a species, a stack or sections",
                state.subject().kind()
            )));
        };
        let opening = Opening { may_compute: true, ..state.opening().clone() };
        self.own.material.ask(Job::Material(Box::new(MaterialJob { structure, opening, whole })));
        Ok(())
    }

    /// Stops everything; what was found stays.
    pub(crate) fn stop(&mut self) {
        self.own.stop();
        self.pinned.stop();
        self.show.stop();
    }

    /// Whether something is computed.
    #[must_use]
    pub(crate) fn is_busy(&self) -> bool {
        self.own.is_busy() || self.pinned.is_busy() || self.show.is_open()
    }

    /// Whether a material of what is open is looked for or made.
    #[must_use]
    pub(crate) fn is_making_material(&self) -> bool {
        self.own.material.is_open()
    }

    /// What takes longest of what is computed; `now` is the window's clock, s.
    pub(crate) fn busy(&mut self, now: f64) -> Option<Busy> {
        let Self { own, pinned, show, .. } = self;
        let all: [(&'static str, Option<Pace>); 7] = [
            ("material", own.material.pace(now)),
            ("mean", own.curves.pace(now)),
            ("mean of the pinned one", pinned.curves.pace(now)),
            ("picture", show.pace(now)),
            ("individual", own.individual.pace(now)),
            ("individual of the pinned one", pinned.individual.pace(now)),
            ("lobe", own.lobe.pace(now)),
        ];
        all.into_iter().find_map(|(what, pace)| {
            let Pace { label, fraction, left } = pace?;
            Some(Busy { what, label, fraction, left_s: left.map(|left| left.as_secs_f64()) })
        })
    }
}
