//! What the picture shows: the shape of a mode, in the material that there is, or, where there is none yet, in layers that reflect what is
//! known of the structure.

use std::collections::BTreeMap;
use std::sync::Arc;

use barbule::bsdf::{Keratin, Reflectance, Surface};
use barbule::campaign::spectrum::Collect;
use barbule::characterize::Found as Material;
use barbule::error::shortened;
use barbule::film::{ensemble, sweep};
use barbule::io::Folder;
use barbule::open::{self, Opening, folder_of};
use barbule::progress::Progress;
use barbule::resolve::{Worn, resolve};
use barbule::scene::description::{DetailLevel, FeatherObject, ReadyScene, SceneDescription};
use barbule::spectrum::Wavelengths;
use barbule::spectrum::dense::{Lambdas, WAVES};
use barbule::stack::Stack;
use barbule::vision::{FalseColour, false_colour};
use barbule::{Error, Result};

use super::{Curves, MaterialFound, MeanJob, mean};
use crate::gpu::{Reflected, Sight};
use crate::scene::{self, Bend, FeatherRequest, MOST_TRIANGLES, Part, Shape};
use crate::stage::{Coat, Show, Wear};
use crate::state::{Mode, Seer, State, Subject, View};

/// GGX α of the surface that stands for a stack, and of one that stands for barbules of which only the mean is known.
const SMOOTH: f64 = 0.12;
const ROUGH: f64 = 0.35;
/// Steps of the cosine where values are known at few angles.
const FEW_STEPS: usize = 64;
/// Angles at which means are computed before there is a material, rad.
const ANGLES: [f64; 5] = [0.0, 0.35, 0.7, 1.0, 1.3];
/// Of so many individuals at every so many-th wavelength: at once, then better.
const STEPS: [(usize, f64); 2] = [(1, 35.0), (8, 12.0)];
/// Individuals of stacks whose thicknesses spread.
const INDIVIDUALS: usize = 24;
/// The first surface of a grown feather is looked at where so little of it is grown, mm.
const TINY_MM: f64 = 0.05;

/// What is to be shown.
#[derive(Debug, Clone)]
pub struct ShowJob {
    subject: Subject,
    view: View,
    opening: Opening,
    material: Option<Arc<Material>>,
}

impl ShowJob {
    /// What a state shows, in a material where it has one.
    ///
    /// # Errors
    /// None.
    pub fn of(state: &State, material: Option<&MaterialFound>) -> Result<Self> {
        let (subject, view, opening) =
            (state.subject().clone(), state.view().clone(), state.opening().clone());
        Ok(Self { subject, view, opening, material: material.map(|found| Arc::clone(&found.found)) })
    }
}

/// Makes it, and hands it over as soon as there is something: of a structure without a material what is known of its mean, better and
/// better.
///
/// # Errors
/// A scene that shows no feather, a file that it names is missing, or a stop by `progress`.
pub fn show(job: &ShowJob, progress: &dyn Progress, found: &mut dyn FnMut(Show)) -> Result<()> {
    let sight = sight(&job.view.eye)?;
    let set = Set::of(job, progress)?;
    let mut tell = |coat: Option<Coat>| -> Result<()> {
        found(set.dressed(coat, sight.clone())?);
        Ok(())
    };
    if set.is_dressed {
        return tell(None);
    }
    if let Some(stack) = job.subject.stack() {
        let reflected = Arc::new(of_stack(stack, job.opening.seed, progress)?);
        return tell(Some(Coat::Layers { reflected, roughness: SMOOTH }));
    }
    let Some(structure) = job.subject.structure()? else {
        return Err(Error::input(format!(
            "{} has neither a material nor a structure of which one could be made",
            shortened(job.subject.text())
        )));
    };
    for (individuals, step_nm) in STEPS {
        let at = Wavelengths::new(
            (0..).map(|k| 390.0 + step_nm * f64::from(k)).take_while(|nm| *nm < 730.0).collect::<Vec<_>>(),
        )?;
        let (structure, seed) = (structure.clone(), job.opening.seed);
        let of_mean = MeanJob {
            structure,
            at,
            angle: ANGLES.to_vec(),
            individuals,
            seed,
            collect: Collect::Hemisphere,
        };
        let mut last = None;
        mean(&of_mean, progress, &mut |found| last = Some(found.curves))?;
        let curves = last.ok_or_else(|| Error::machine("a mean that is over no individuals"))?;
        let reflected = Arc::new(of_curves(&curves));
        tell(Some(Coat::Layers { reflected, roughness: ROUGH }))?;
    }
    Ok(())
}

/// How an eye's picture is shown.
///
/// # Errors
/// There is no such eye, or it has more cones than a picture shows.
fn sight(eye: &Seer) -> Result<Sight> {
    match eye {
        Seer::People => Ok(Sight::default()),
        Seer::Bird(name) => {
            let eye = open::eye(name)?;
            Ok(Sight::Sensor(false_colour(&eye, &FalseColour::usual(&eye))?))
        }
    }
}

/// A shape, and what its parts wear beside the structure that is open.
struct Set {
    shape: Shape,
    /// By the codes of parts.
    wears: BTreeMap<u32, Wear>,
    rest: Wear,
    /// Codes of parts that wear what is open.
    open: Vec<u32>,
    /// Whether that is among what they wear already.
    is_dressed: bool,
}

impl Set {
    fn of(job: &ShowJob, progress: &dyn Progress) -> Result<Self> {
        match job.view.mode {
            Mode::Feather => Self::feather(job, progress),
            Mode::Sphere => Self::clad(job, scene::sphere()?, progress),
            Mode::Vane => Self::clad(job, scene::vane(&Bend::USUAL)?, progress),
            Mode::Snake => Self::clad(job, scene::snake()?, progress),
            Mode::Scene => Err(Error::input(
                "a scene is drawn by the renderer; choose another mode for a picture in real time",
            )),
        }
    }

    /// A surface that is all of what is open.
    fn clad(job: &ShowJob, mut shape: Shape, progress: &dyn Progress) -> Result<Self> {
        let code = Part::Distal.code(0);
        shape.vertices.iter_mut().for_each(|vertex| vertex.part = code);
        let mut wears = BTreeMap::new();
        let is_grating = job.subject.structure()?.is_none() && job.material.is_none();
        if let Some(found) = &job.material {
            let worn = open::worn(&found.material, found.hash.clone())?;
            wears.insert(code, Wear::over_dark(Coat::Feather(worn.brdf))?);
        } else if is_grating {
            let ready = job.ready(&|_| {}, progress)?;
            let (objects, _) = ready.objects_watched(job.opening.seed, progress)?;
            let surface = objects.first().map(|object| &object.surface);
            let surface = surface.ok_or_else(|| Error::machine("a scene without objects"))?;
            wears.insert(code, wear_of(surface)?);
        }
        let is_dressed = !wears.is_empty();
        Ok(Self { shape, wears, rest: Wear::dark()?, open: vec![code], is_dressed })
    }

    /// The feather of a scene, in what it wears there.
    fn feather(job: &ShowJob, progress: &dyn Progress) -> Result<Self> {
        let one_by_one = |scene: &mut SceneDescription| {
            if let Some(of) = scene.lone_feather_mut() {
                of.detail.level = DetailLevel::Barbules;
            }
        };
        let ready = job.ready(&one_by_one, progress)?;
        let Some(of) = ready.lone_feather() else {
            return Err(Error::input(format!(
                "the scene of {} shows no feather by itself; choose a preset that does, as starling-feather, or another mode",
                shortened(job.subject.text())
            )));
        };
        let shape = grown(of, job.opening.seed, progress)?;
        // Surfaces do not depend on how much of the feather is grown.
        let tiny = ready.changed(|scene| {
            if let Some(of) = scene.lone_feather_mut() {
                of.window.radius_mm = Some(TINY_MM);
            }
        })?;
        let (objects, _) = tiny.objects_watched(job.opening.seed, progress)?;
        let (mut wears, mut open) = (BTreeMap::new(), Vec::new());
        for (name, object) in tiny.object_names().iter().zip(&objects) {
            let Some(code) = code_of(name) else { continue };
            let mut wear = wear_of(&object.surface)?;
            if job.is_stood_in() && matches!(wear.coat, Coat::Feather(_)) {
                wear.coat = Coat::Keratin;
                open.push(code);
            }
            wears.insert(code, wear);
        }
        let is_dressed = open.is_empty();
        Ok(Self { shape, wears, rest: Wear::dark()?, open, is_dressed })
    }

    /// With a coat for what is open.
    fn dressed(&self, coat: Option<Coat>, sight: Sight) -> Result<Show> {
        let mut wears = self.wears.clone();
        for code in self.open.iter().filter(|_| coat.is_some()) {
            let under = wears.get(code).cloned().map_or_else(Wear::dark, Ok)?;
            let coat = coat.clone().unwrap_or(Coat::Keratin);
            wears.insert(*code, Wear { coat, ..under });
        }
        Ok(Show { shape: self.shape.clone(), wears, rest: self.rest.clone(), sight })
    }
}

impl ShowJob {
    /// Whether another material is worn in the scene in place of that of what is open, which is not there yet.
    fn is_stood_in(&self) -> bool {
        self.material.is_none() && !matches!(self.view.mode, Mode::Scene) && self.subject.kind() != "scene"
    }

    /// The scene that the renderer draws of it, with all that it names.
    ///
    /// # Errors
    /// Something that it names is not there.
    pub fn scene(&self, progress: &dyn Progress) -> Result<ReadyScene> {
        self.ready(&|_| {}, progress)
    }

    /// The scene with all that it names; what is open is in its own material, where there is one.
    fn ready(&self, change: &dyn Fn(&mut SceneDescription), progress: &dyn Progress) -> Result<ReadyScene> {
        let (mut description, _) = self.subject.scene(&self.view, &self.opening, progress)?;
        change(&mut description);
        let own = self.subject.typed()?.map(|typed| typed.name);
        let mut dye = |name: &str| -> Result<Worn> {
            match &self.material {
                Some(found) if own.as_deref() == Some(name) => {
                    open::worn(&found.material, found.hash.clone())
                }
                _ if own.as_deref() == Some(name) && self.is_stood_in() => stand_in(),
                _ => {
                    let found = open::material(name, &self.opening, progress)?;
                    open::worn(&found.material, found.hash)
                }
            }
        };
        let folder = Folder(folder_of(self.subject.text()));
        resolve(description, &folder, &mut dye, self.opening.seed, progress)
    }
}

/// A material that is there, worn until another one is.
fn stand_in() -> Result<Worn> {
    let opening = Opening { may_compute: false, ..Opening::default() };
    let found = open::material("starling", &opening, &barbule::Unobserved)?;
    Worn::new(&found.material, found.hash)
}

/// The feather's own barbules as far as adapters draw them.
fn grown(of: &FeatherObject, seed: u64, progress: &dyn Progress) -> Result<Shape> {
    let zones = of.zone_plan()?.map(|plan| of.feather.zones(plan)).transpose()?;
    let request = FeatherRequest {
        feather: &of.feather,
        window: of.window,
        zones: zones.as_ref(),
        seed,
        most_triangles: MOST_TRIANGLES,
    };
    Ok(scene::feather(&request, progress)?.0)
}

/// The part's code by its name among a scene's objects; none of what meshes do not tell apart.
fn code_of(name: &str) -> Option<u32> {
    let (zone, part) = match name.strip_prefix("zone ") {
        Some(rest) => {
            let (number, part) = rest.split_once(' ')?;
            (number.parse().ok()?, part)
        }
        None => (0, name),
    };
    let part = match part {
        "shaft" => Part::Shaft,
        "barbs" => Part::Ramus,
        "distal barbules" => Part::Distal,
        "proximal barbules" => Part::Proximal,
        "pale barbules" => Part::Pale,
        "down" => Part::Down,
        _ => return None,
    };
    Some(part.code(zone))
}

/// A surface of the renderer as it is drawn in real time: of fibres and paint the colour alone, in keratin's gloss.
///
/// # Errors
/// A colour that is none.
fn wear_of(surface: &Surface) -> Result<Wear> {
    let of_keratin = |keratin: &Keratin| Ok(Wear { keratin: keratin.clone(), ..Wear::dark()? });
    let body = |reflectance: Reflectance| of_keratin(&Keratin::new(0.5, 1.56, reflectance)?);
    match surface {
        Surface::Barbule(barbule) => barbules(barbule),
        Surface::Clad(clad) => barbules(clad.barbule()),
        Surface::Grating(grating) => Wear::over_dark(Coat::Grating(Arc::new(grating.clone()))),
        Surface::Keratin(keratin) => of_keratin(keratin),
        Surface::Hair(hair) => body(hair.mass_reflectance()?),
        Surface::Lambertian(paint) => match paint.even() {
            Some(reflectance) => body(reflectance),
            None => Wear::dark(),
        },
        Surface::ThinFilm(film) => {
            let at = Wavelengths::usual();
            let values = at.nm().iter().flat_map(|nm| {
                let of = |step: usize| {
                    let reflected: [f64; WAVES] =
                        film.reflected(step as f64 / FEW_STEPS as f64, Lambdas::splat(*nm));
                    reflected[0] as f32
                };
                (0..=FEW_STEPS).map(of).collect::<Vec<_>>()
            });
            let reflected = Reflected { nm: at.nm().to_vec(), steps: FEW_STEPS, values: values.collect() };
            Wear::over_dark(Coat::Layers { reflected: Arc::new(reflected), roughness: ROUGH })
        }
        _ => Wear::dark(),
    }
}

fn barbules(barbule: &barbule::bsdf::BarbuleSurface) -> Result<Wear> {
    Ok(Wear {
        coat: Coat::Feather(Arc::clone(&barbule.brdf)),
        cells: barbule.cells,
        keratin: barbule.under.clone(),
    })
}

/// What flat layers reflect, exactly; in the mean where thicknesses spread.
fn of_stack(stack: &Stack, seed: u64, progress: &dyn Progress) -> Result<Reflected> {
    let at = Wavelengths::usual();
    let random = stack.is_random();
    let steps = if random { FEW_STEPS } else { Reflected::STEPS };
    let angles = Reflected::angles(steps);
    let found = if random {
        ensemble(stack, &at, &angles, INDIVIDUALS, seed, progress)?.mean.unpolarized()
    } else {
        sweep(stack, &at, &angles, progress)?.unpolarized()
    };
    // From [angle, wavelength].
    let values = (0..at.len()).flat_map(|wave| (0..=steps).map(move |angle| (wave, angle)));
    let values = values.map(|(wave, angle)| found[angle * at.len() + wave] as f32).collect();
    Ok(Reflected { nm: at.nm().to_vec(), steps, values })
}

/// What is known at a few angles, linear between them and held beyond the last.
fn of_curves(curves: &Curves) -> Reflected {
    let waves = curves.at.len();
    let angles = Reflected::angles(FEW_STEPS);
    let at = |wave: usize, angle: f64| {
        let above = curves.angle.partition_point(|known| *known < angle).clamp(1, curves.angle.len() - 1);
        let [low, high] = [above - 1, above].map(|k| (curves.angle[k], curves.reflected[k * waves + wave]));
        let share = ((angle - low.0) / (high.0 - low.0)).clamp(0.0, 1.0);
        low.1 + (high.1 - low.1) * share
    };
    let values = (0..waves).flat_map(|wave| angles.iter().map(move |angle| (wave, *angle)));
    let values = values.map(|(wave, angle)| at(wave, angle) as f32).collect();
    Reflected { nm: curves.at.nm().to_vec(), steps: FEW_STEPS, values }
}
