//! The workers for one thing that is open.
//!
//! Films and single individuals are asked for at each change, since they take milliseconds. Means over individuals come better and
//! better: first at the view's angle alone, then at all. A material is looked for at each change, and made only when somebody asks.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use barbule::brdf::{FeatherBrdf, FeatherMaterial, Options};
use barbule::campaign::spectrum::Collect;
use barbule::open::Opening;
use barbule::scattering::directions::omega;
use barbule::spectrum::Wavelengths;

use super::bench::Bench;
use super::desk::Effort;
use super::results::Known;
use super::{
    FilmJob, Found, HemisphereJob, IndividualJob, Job, MaterialFound, MaterialJob, MeanJob, Update, Viewer,
};
use crate::state::{Seer, Shown, Subject, View, What};
use crate::{Error, Result};

/// Angles of incidence of films, degrees: from, to and step. They cost next to nothing.
const FILM_DEG: [usize; 3] = [0, 85, 5];
/// Angles of incidence of means, degrees.
const MEAN_DEG: [usize; 3] = [0, 75, 15];

/// What every result depends on: what it is of, with its sizes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Who {
    text: String,
    moved: BTreeMap<String, f64>,
}

impl Who {
    pub(super) fn of(subject: &Subject) -> Self {
        Self { text: subject.text().to_owned(), moved: subject.moved() }
    }
}

/// What curves depend on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CurvesOf {
    who: Who,
    angle_deg: f64,
    eye: Seer,
}

/// What an individual depends on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct IndividualOf {
    who: Who,
    index: usize,
    angle_deg: f64,
    wavelength_nm: f64,
    eye: Seer,
}

/// What a lobe depends on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LobeOf {
    hash: String,
    angle_deg: f64,
    individual: Option<u64>,
}

/// The workers for one thing.
pub(super) struct Benches {
    who: Option<Who>,
    pub(super) curves: Bench<CurvesOf>,
    /// Whether the curves are asked for at all angles, rather than first at the view's.
    at_all_angles: bool,
    pub(super) individual: Bench<IndividualOf>,
    pub(super) material: Bench<Who>,
    pub(super) lobe: Bench<LobeOf>,
    prepared: Option<Prepared>,
    viewer: Option<(Seer, Wavelengths)>,
    wake: Wake,
}

/// A material that is being made ready for evaluation, on a thread of its own: that takes tenths of a second.
struct Prepared {
    hash: String,
    made: Receiver<Result<FeatherBrdf>>,
}

/// Draws the window anew.
pub(super) type Wake = Arc<dyn Fn() + Send + Sync>;

/// A bench whose worker draws the window anew.
pub(super) fn bench<K: PartialEq>(wake: &Wake) -> Result<Bench<K>> {
    let wake = Arc::clone(wake);
    Bench::new(move || wake())
}

/// How something is looked at, and what may be done for it.
pub(super) struct Order<'a> {
    pub(super) view: &'a View,
    pub(super) opening: &'a Opening,
    pub(super) effort: Effort,
}

impl Benches {
    pub(super) fn new(wake: &Wake) -> Result<Self> {
        Ok(Self {
            who: None,
            curves: bench(wake)?,
            at_all_angles: false,
            individual: bench(wake)?,
            material: bench(wake)?,
            lobe: bench(wake)?,
            prepared: None,
            viewer: None,
            wake: Arc::clone(wake),
        })
    }

    pub(super) fn stop(&mut self) {
        self.curves.stop();
        self.individual.stop();
        self.material.stop();
        self.lobe.stop();
    }

    pub(super) fn is_busy(&self) -> bool {
        let Self { curves, individual, material, lobe, prepared, .. } = self;
        prepared.is_some() || curves.is_open() || individual.is_open() || material.is_open() || lobe.is_open()
    }

    /// Asks for whatever depends on something that has changed. All are asked for, also where one cannot be.
    pub(super) fn ask(&mut self, subject: Option<&Subject>, order: &Order, of: &mut Known) -> Result<()> {
        let who = subject.map(Who::of);
        if who.as_ref().map(|who| &who.text) != self.who.as_ref().map(|who| &who.text) {
            // Of something else nothing is left to be shown.
            *of = Known::default();
        }
        self.who.clone_from(&who);
        let material = self.ask_material(subject, order, of);
        let curves = self.ask_curves(subject, order, of);
        let individual = self.ask_individual(subject, order, of);
        let lobe = self.ask_lobe(order, of);
        material.and(curves).and(individual).and(lobe)
    }

    /// The wavelengths at which whoever sees needs reflectances.
    fn wavelengths(&mut self, eye: &Seer) -> Result<Wavelengths> {
        if let Some((_, at)) = self.viewer.as_ref().filter(|(own, _)| own == eye) {
            return Ok(at.clone());
        }
        let at = Viewer::new(eye)?.wavelengths().clone();
        self.viewer = Some((eye.clone(), at.clone()));
        Ok(at)
    }

    fn ask_curves(&mut self, subject: Option<&Subject>, order: &Order, of: &mut Known) -> Result<()> {
        let View { angle_deg, eye, .. } = order.view;
        let at = self.wavelengths(eye)?;
        let key = self.who.clone().map(|who| CurvesOf { who, angle_deg: *angle_deg, eye: eye.clone() });
        let is_film = subject.is_some_and(|subject| subject.stack().is_some());
        let job = || match subject {
            Some(subject) => curves_job(subject, order, at, is_film),
            None => Ok(None),
        };
        if self.curves.want(key, job)? {
            self.at_all_angles = is_film;
            of.is_whole = false;
            if !self.curves.is_open() {
                of.curves = None;
            }
        }
        Ok(())
    }

    fn ask_individual(&mut self, subject: Option<&Subject>, order: &Order, of: &mut Known) -> Result<()> {
        let View { angle_deg, eye, individual, wavelength_nm, .. } = order.view;
        let at = self.wavelengths(eye)?;
        let key = self.who.clone().map(|who| IndividualOf {
            who,
            index: *individual,
            angle_deg: *angle_deg,
            wavelength_nm: *wavelength_nm,
            eye: eye.clone(),
        });
        let job = || {
            let structure = subject.map(Subject::structure).transpose()?.flatten();
            Ok(structure.map(|structure| {
                Job::Individual(Box::new(IndividualJob {
                    structure,
                    seed: order.opening.seed,
                    index: *individual,
                    at,
                    wavelength_nm: Some(*wavelength_nm),
                    incident: [0.0, angle_deg.to_radians()],
                }))
            }))
        };
        if self.individual.want(key, job)? && !self.individual.is_open() {
            of.individual = None;
        }
        Ok(())
    }

    /// Looks whether the material is there.
    fn ask_material(&mut self, subject: Option<&Subject>, order: &Order, of: &mut Known) -> Result<()> {
        let own = match subject.map(Subject::what) {
            Some(What::Material(found, _)) if !subject.is_some_and(Subject::is_moved) => Some(found),
            _ => None,
        };
        let job = || {
            let structure = subject.filter(|_| own.is_none()).map(Subject::structure).transpose()?.flatten();
            let opening = Opening { may_compute: false, ..order.opening.clone() };
            let job = |structure| MaterialJob { structure, opening, whole: false };
            Ok(structure.map(|structure| Job::Material(Box::new(job(structure)))))
        };
        if self.material.want(self.who.clone(), job)? && !self.material.is_open() {
            of.material = own.map(|found| MaterialFound { found: Arc::clone(found), thinned: None });
        }
        Ok(())
    }

    fn ask_lobe(&mut self, order: &Order, of: &mut Known) -> Result<()> {
        let hash = of.material.as_ref().map(|found| &found.found.hash);
        let Some(hash) = hash else {
            (of.brdf, of.hemisphere, self.prepared) = (None, None, None);
            return self.lobe.want(None, || Ok(None)).map(|_| ());
        };
        let is_prepared = self.prepared.as_ref().is_some_and(|prepared| prepared.hash == *hash);
        if of.brdf.is_none() && !is_prepared {
            self.prepared = of.material.as_ref().map(|found| self.prepare(found)).transpose()?;
        }
        let Some(brdf) = &of.brdf else { return Ok(()) };
        let individual = (order.view.shown == Shown::Individuals).then_some(order.view.individual as u64);
        let angle_deg = order.view.angle_deg;
        let key = LobeOf { hash: hash.clone(), angle_deg, individual };
        let job = || {
            Ok(Some(Job::Hemisphere(Box::new(HemisphereJob {
                brdf: Arc::clone(brdf),
                incident: omega(0.0, angle_deg.to_radians()),
                individual,
                side: order.effort.lobe_pixels,
                at: Wavelengths::usual(),
            }))))
        };
        self.lobe.want(Some(key), job).map(|_| ())
    }

    /// Makes a material ready for evaluation.
    fn prepare(&self, found: &MaterialFound) -> Result<Prepared> {
        let (tell, made) = channel();
        let (wake, own) = (Arc::clone(&self.wake), Arc::clone(&found.found));
        let work = move || {
            let material: &FeatherMaterial = &own.material;
            // Nobody waits for it once another is open.
            let _ = tell.send(FeatherBrdf::new(material, Options::default()));
            wake();
        };
        std::thread::Builder::new().name("material".to_owned()).spawn(work).map_err(|error| {
            Error::machine(format!("the thread that prepares materials cannot be started: {error}"))
        })?;
        Ok(Prepared { hash: found.found.hash.clone(), made })
    }

    /// Takes what was found; what went wrong.
    pub(super) fn take(&mut self, subject: Option<&Subject>, order: &Order, of: &mut Known) -> Vec<Error> {
        let mut errors = Vec::new();
        let (curves, individual) = (self.curves.updates(), self.individual.updates());
        let (material, lobe) = (self.material.updates(), self.lobe.updates());
        let was_made = material.iter().any(|update| matches!(update, Update::Done));
        for update in curves.into_iter().chain(individual).chain(material).chain(lobe) {
            match update {
                Update::Found(found) => errors.extend(self.found(found, subject, order, of).err()),
                Update::Failed(error) => errors.push(error),
                Update::Done => {}
            }
        }
        if was_made && !self.material.has_found() {
            // There is none of it as it is now.
            of.material = None;
        }
        match self.prepared.as_ref().map(|prepared| prepared.made.try_recv()) {
            None | Some(Err(TryRecvError::Empty)) => {}
            Some(outcome) => {
                self.prepared = None;
                match outcome {
                    Ok(Ok(brdf)) => of.brdf = Some(Arc::new(brdf)),
                    Ok(Err(error)) => errors.push(error),
                    Err(_) => errors.push(Error::machine("the material could not be made ready")),
                }
            }
        }
        errors
    }

    fn found(
        &mut self,
        found: Found,
        subject: Option<&Subject>,
        order: &Order,
        of: &mut Known,
    ) -> Result<()> {
        match found {
            Found::Film(curves) => {
                (of.curves, of.individuals, of.is_whole) = (Some(curves), 1, true);
                if subject.and_then(Subject::stack).is_some_and(|stack| stack.is_random()) {
                    of.individuals = order.effort.individuals;
                }
            }
            // At all angles only the last is better than what there is at one.
            Found::Mean(mean) if self.at_all_angles && !mean.is_whole => {}
            Found::Mean(mean) => {
                (of.curves, of.individuals) = (Some(mean.curves), mean.individuals);
                of.is_whole = mean.is_whole && self.at_all_angles;
                if mean.is_whole && !self.at_all_angles {
                    self.at_all_angles = true;
                    let at = self.wavelengths(&order.view.eye)?;
                    let job = subject.map(|subject| curves_job(subject, order, at, true)).transpose()?;
                    job.flatten().into_iter().for_each(|job| self.curves.ask(job));
                }
            }
            Found::Individual(one) => of.individual = Some(*one),
            Found::Material(material) => {
                let hash = of.material.as_ref().map(|before| &before.found.hash);
                if hash != Some(&material.found.hash) {
                    (of.brdf, self.prepared) = (None, None);
                }
                of.material = Some(material);
            }
            Found::Hemisphere(lobe) => of.hemisphere = Some(lobe),
            Found::Show(_) => {}
        }
        Ok(())
    }
}

/// Reflectance of films at all angles at once; of everything else the mean, first at the view's angle alone.
fn curves_job(subject: &Subject, order: &Order, at: Wavelengths, at_all_angles: bool) -> Result<Option<Job>> {
    let (individuals, seed) = (order.effort.individuals, order.opening.seed);
    let own = order.view.angle_deg;
    if let Some(stack) = subject.stack() {
        let angle = angles(FILM_DEG, own.abs());
        return Ok(Some(Job::Film(FilmJob { stack: stack.clone(), at, angle, individuals, seed })));
    }
    let Some(structure) = subject.structure()? else { return Ok(None) };
    let angle = if at_all_angles { angles(MEAN_DEG, own) } else { vec![own.to_radians()] };
    let collect = Collect::Hemisphere;
    Ok(Some(Job::Mean(Box::new(MeanJob { structure, at, angle, individuals, seed, collect }))))
}

/// Angles in rad, rising, and one more among them.
fn angles([from, to, step]: [usize; 3], own_deg: f64) -> Vec<f64> {
    let mut all: Vec<f64> = (from..=to).step_by(step).map(|degrees| degrees as f64).collect();
    if !all.contains(&own_deg) {
        all.push(own_deg);
        all.sort_by(f64::total_cmp);
    }
    all.into_iter().map(f64::to_radians).collect()
}
