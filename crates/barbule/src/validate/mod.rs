//! How accurate the fast simulation is: the same sections by it and by full waves, in numbers and figures.
//!
//! [`FullWaveOptions`] and [`three_d::SegmentOptions`] make plans of a structure, whose units several processes may compute
//! ([`Comparing`]).

mod ensemble;
mod exact;
mod figures;
mod numbers;
mod options;
mod spread;
pub mod three_d;
mod work;

pub use ensemble::Ensemble;
pub use numbers::{Case, Comparison, Incidence, tells_colours};
pub use options::FullWaveOptions;
pub use spread::Spread;
pub use work::{Compared, Comparing, UNITS, units_in};

use exact::Solved;
use rayon::prelude::*;

use crate::clock;
use crate::io::Units;
use crate::progress::{OnlyStops, Progress};
use crate::scattering::far_field::{FarField, Illumination, Polarization, Window};
use crate::solve::cost::Cost;
use crate::solve::far_fields::{Illuminations, Method, SectionSolver as _, Settings};
use crate::solve::full_wave::FullWave;
use crate::solve::{SHADOWED, incident_range, width_within_um};
use crate::spectrum::Wavelengths;
use crate::structure::{Closed, Section};
use crate::{Error, Result};

/// Light of a beam should come from within so many degrees of the azimuth asked: at 60° that is from less than 75°, from where on single
/// reflections are not enough, and leaves at most 2.3 % of the power beyond (two deviations).
pub const MOST_OFF_DEG: f64 = 15.0;

/// What is compared.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What it is called.
    pub name: String,
    /// Which individual, from 0.
    pub instance: usize,
    /// The section as both solvers get it.
    pub closed: Closed,
    /// Vacuum wavelengths.
    pub wavelengths: Wavelengths,
    /// Azimuths of incidence, rad; θ_i is 0.
    pub phi_i: Vec<f64>,
    /// Azimuths of the upper half at which patterns are compared.
    pub azimuths: usize,
    /// How full waves are solved.
    pub full: FullWave,
    /// What is compared with them: the fast simulation, or its formulas with shadows.
    pub method: Method,
}

impl Plan {
    /// The light of both: a beam. Under the window that the fast simulation usually has, which lies on the top, tilted tops would
    /// take more or less light than a beam brings them.
    #[must_use]
    pub fn light(&self) -> Illuminations {
        self.light_through(Window::Beam)
    }

    fn light_through(&self, window: Window) -> Illuminations {
        Illuminations {
            wavelengths_nm: self.wavelengths.nm().to_vec(),
            theta_i: vec![0.0],
            phi_i: self.phi_i.clone(),
            window,
        }
    }

    /// What the full waves of each wavelength take.
    ///
    /// # Errors
    /// As [`Prepared::cost`](crate::solve::far_fields::Prepared::cost).
    pub fn costs(&self, threads: usize, progress: &dyn Progress) -> Result<Vec<Cost>> {
        let exact = self.full.prepare(&self.closed.regions)?;
        let cost = |&nm: &f64| exact.cost(&self.light_of(nm), self.circle(), threads, &OnlyStops(progress));
        self.wavelengths.nm().iter().map(cost).collect()
    }

    /// Refuses angles from which the light does not come: a beam on a narrow section comes from many.
    ///
    /// # Errors
    /// At the longest wavelength the field's spectrum at 1/e lies more than [`MOST_OFF_DEG`] beside an azimuth.
    pub fn check_beams(&self) -> Result<()> {
        let (width_um, longest_nm) = (self.closed.regions.width_um, self.wavelengths.range_nm().1);
        for light in self.light_of(longest_nm).iter() {
            let least_um = width_within_um(&light, MOST_OFF_DEG.to_radians());
            if least_um.is_some_and(|least_um| width_um >= least_um) {
                continue;
            }
            let [from, to] = incident_range(&light, width_um).phi_i.map(f64::to_degrees);
            let remedy = least_um.map_or_else(
                || format!("give angles below {:.0}°", 90.0 - MOST_OFF_DEG),
                |least_um| {
                    format!(
                        "take a section from {:.1} µm on, or leave this angle out",
                        (10.0 * least_um).ceil() / 10.0
                    )
                },
            );
            return Err(Error::input(format!(
                "φ_i = {:.0}°: the beam on {width_um} µm comes from {from:.0}° to {to:.0}° at {longest_nm} nm, more than {MOST_OFF_DEG}° beside it; {remedy}",
                light.phi_i.to_degrees()
            )));
        }
        Ok(())
    }

    /// The light of one wavelength.
    fn light_of(&self, wavelength_nm: f64) -> Illuminations {
        Illuminations { wavelengths_nm: vec![wavelength_nm], ..self.light() }
    }

    /// Azimuths of the full waves: every second of four times as many of the circle is one of the upper half's.
    fn circle(&self) -> usize {
        4 * self.azimuths
    }

    fn compare(&self, units: Option<&Units>, steps: &[u64], progress: &dyn Progress) -> Result<Comparison> {
        let light = self.light();
        let solver = (self.method.solver)(&Settings::default());
        let (formulas, exact) =
            (solver.prepare(&self.closed.fast)?, self.full.prepare(&self.closed.regions)?);
        // Full waves first: what is dear is kept before anything else can fail.
        let mut full = Vec::with_capacity(light.count());
        for (&wavelength_nm, &steps) in self.wavelengths.nm().iter().zip(steps) {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let (found, is_new) = self.solved(&*exact, wavelength_nm, units, progress)?;
            full.extend(found);
            progress.advance(if is_new { steps } else { 0 });
        }
        let by_formulas =
            |light: &Illuminations| formulas.scatter(light, self.azimuths, &OnlyStops(progress));
        let start = clock::system();
        let windowed = by_formulas(&self.light_through(Window::Gaussian))?;
        let fast_seconds = (clock::system() - start).as_secs_f64();
        let fast = by_formulas(&light)?;
        let fast_bytes = formulas.cost(&light, self.azimuths, 1, &OnlyStops(progress))?.bytes;
        let width_um = self.closed.regions.width_um;
        let cases: Vec<Case> = (light.iter().zip(&fast).zip(&windowed).zip(&full))
            .map(|(((one, fast), windowed), full)| case(&one, width_um, [&fast.far, &windowed.far], full))
            .collect();
        // [wavelength][incidence] → [incidence][wavelength]
        let (incidences, count) = (self.phi_i.len(), self.wavelengths.len());
        let of = |i: usize| (0..count).map(|w| cases[w * incidences + i].clone()).collect::<Vec<_>>();
        let found = (0..incidences)
            .into_par_iter()
            .map(|i| Incidence::new(self.phi_i[i].to_degrees(), of(i), &self.wavelengths));
        Ok(Comparison {
            name: self.name.clone(),
            instance: self.instance,
            width_um,
            ends: self.closed.ends,
            changes: self.closed.changes.clone(),
            wavelengths_nm: self.wavelengths.nm().to_vec(),
            elements_per_wavelength: self.full.elements_per_wavelength,
            fast_seconds,
            has_shadows: self.method == SHADOWED,
            smooth_um: self.closed.fast.smooth_um,
            fast_bytes,
            incidences: found.collect(),
        })
    }
}

/// In how many steps the progress of an individual is told, about.
const STEPS: f64 = 1000.0;

/// Several individuals against full waves; a [unit](Comparing) is a wavelength of one of them, whose incidences share one solution.
#[derive(Debug, Clone)]
pub struct FullWaves {
    plans: Vec<Plan>,
}

impl FullWaves {
    /// Of the plans of individuals under the same light.
    ///
    /// # Errors
    /// There are none, or their wavelengths differ.
    pub fn new(plans: Vec<Plan>) -> Result<Self> {
        let Some(first) = plans.first() else {
            return Err(Error::input("no individuals are compared; give at least one"));
        };
        if plans.iter().any(|plan| plan.wavelengths.nm() != first.wavelengths.nm()) {
            return Err(Error::input("individuals are compared under different light; give all the same"));
        }
        Ok(Self { plans })
    }

    /// Each individual; at least one.
    #[must_use]
    pub fn individuals(&self) -> &[Plan] {
        &self.plans
    }

    /// Runs both of each individual, one after the other. Full waves of each wavelength are kept as they come and taken from there
    /// another time: to the same bits, times and all.
    ///
    /// # Errors
    /// As the solvers; a unit cannot be written; or the user cancelled.
    pub fn run(&self, units: Option<&Units>, progress: &dyn Progress) -> Result<Ensemble> {
        let steps = self.begin(units, progress)?;
        let found = self.plans.iter().map(|plan| plan.compare(units, &steps, progress));
        Ensemble::new(found.collect::<Result<_>>()?)
    }

    /// Says how much there is to do, in steps of what the first individual's wavelengths take; the steps of each wavelength.
    fn begin(&self, units: Option<&Units>, progress: &dyn Progress) -> Result<Vec<u64>> {
        let costs = self.plans[0].costs(1, progress)?;
        let seconds: Vec<f64> = costs.into_iter().map(|cost| cost.seconds.unwrap_or_default()).collect();
        let all = seconds.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let steps: Vec<u64> = seconds.iter().map(|one| (STEPS * one / all).ceil() as u64).collect();
        // What is there from before takes no time.
        let left = self.plans.iter().flat_map(|plan| plan.missing(units)).map(|w| steps[w]).sum();
        progress.begin("full waves", left);
        Ok(steps)
    }
}

/// One wavelength and incidence by both.
fn case(light: &Illumination, width_um: f64, [fast, windowed]: [&FarField; 2], full: &Solved) -> Case {
    let mean = |both: [f64; 2]| 0.5 * (both[0] + both[1]);
    Case {
        wavelength_nm: light.wavelength_nm,
        fast: unpolarized(fast),
        full: full.pattern.clone(),
        reflected: [mean(fast.radiated), full.reflected],
        windowed: mean(windowed.radiated),
        scattered: full.scattered,
        absorbed: full.absorbed,
        range: incident_range(light, width_um),
        effort: full.effort,
    }
}

/// Unpolarized radiant intensity on each azimuth, 1/rad.
fn unpolarized(far: &FarField) -> Vec<f64> {
    let [a, b] = Polarization::BOTH.map(|p| far.per_radian(p));
    a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect()
}

/// The widths, in points, that comparisons of the section should be drawn for: azimuths of the upper half.
#[must_use]
pub fn usual_azimuths(section: &Section, shortest_nm: f64) -> usize {
    // Speckles of a body as wide as W are λ/W wide; eight azimuths for each, and no fewer than 180.
    let speckle = shortest_nm * 1e-3 / section.width_um;
    ((8.0 * std::f64::consts::PI / speckle).ceil() as usize).clamp(180, 2000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;
    use crate::progress::{NO_CLOCK, Unobserved};
    use crate::solve::far_fields::SectionSolver;
    use crate::solve::{DIRECT, FAST};
    use crate::structure::{
        Beneath, Ends, FINER_THAN_LIGHT_UM, Inclusion, Loop, Medium, Parts, Polyline, Smoothing,
        SpeciesModel, Structure,
    };

    /// Ridges as steep as 25° hide at 60° what leaves the slopes that face away: with shadows the pattern is nearer to that of
    /// full waves.
    #[test]
    fn shadows_bring_steep_ridges_nearer_to_full_waves() {
        let x_um: Vec<f64> = (0..=220).map(|i| 0.03 * f64::from(i) - 3.3).collect();
        let ridge = |x: &f64| 0.25 * (std::f64::consts::TAU * x / 3.3 + 0.4).sin();
        let line = |depth: f64| Polyline {
            z_um: x_um.iter().map(|x| ridge(x) - depth).collect(),
            x_um: x_um.clone(),
        };
        let parts = Parts {
            name: "ridges".into(),
            width_um: Some(6.6),
            boundaries: vec![line(0.0), line(0.32), line(2.0)],
            media: ["air", "keratin", "melanin", "air"].map(Medium::named).to_vec(),
            ..Parts::default()
        };
        let section = Section::new(parts, Library::builtin()).unwrap();
        let plan = Plan {
            name: "ridges".into(),
            instance: 0,
            azimuths: usual_azimuths(&section, 550.0),
            closed: section.closed(Beneath::Absorbing, Ends::Open).unwrap(),
            wavelengths: Wavelengths::new(vec![550.0]).unwrap(),
            phi_i: vec![60_f64.to_radians()],
            full: FullWave { elements_per_wavelength: 6.0, memory_bytes: u64::MAX, clock: NO_CLOCK },
            method: DIRECT,
        };
        let scattered = |solver: &dyn SectionSolver, section: &Section, azimuths: usize| {
            let prepared = solver.prepare(section).unwrap();
            prepared.scatter(&plan.light(), azimuths, &Unobserved).unwrap().swap_remove(0)
        };
        let full = scattered(&plan.full, &plan.closed.regions, plan.circle());
        let by = |method: Method| {
            let solver = (method.solver)(&Settings::default());
            let fast = scattered(&*solver, &plan.closed.fast, plan.azimuths).far;
            case(&plan.light().at(0), 6.6, [&fast, &fast], &Solved::new(&full, plan.azimuths).unwrap())
        };
        let (plain, shadowed) = (by(DIRECT), by(SHADOWED));
        // 0.620 and 0.804, 0.81 and 0.50 are reached.
        assert!(plain.correlation() < 0.65 && shadowed.correlation() > 0.75, "{}", shadowed.correlation());
        assert!(plain.rms() > 0.75 && shadowed.rms() < 0.55, "{} {}", plain.rms(), shadowed.rms());
    }

    /// Two rows of voids finer than light in a film reflect what their effective medium does, and not what each column does for
    /// itself.
    #[test]
    fn rows_finer_than_light_reflect_as_full_waves_say() {
        let (length, wall, thick) = (0.16, 0.08, 0.096);
        let void = |(row, k): (usize, usize)| {
            let x = -2.35 + (length + wall) * (k as f64 + 0.37 * row as f64);
            let z = -0.096 - 0.24 * row as f64;
            let outline = Loop::polygon(vec![x, x + length, x + length, x], vec![z, z, z - thick, z - thick]);
            Inclusion { outline, medium: Medium::named("air"), holes: Vec::new() }
        };
        let line = |z_um: f64| Polyline { x_um: vec![-2.5, 0.0, 2.5], z_um: vec![z_um; 3] };
        let parts = Parts {
            name: "rows".into(),
            width_um: Some(5.0),
            boundaries: vec![line(0.0), line(-0.64)],
            media: ["air", "keratin", "air"].map(Medium::named).to_vec(),
            inclusions: (0..2).flat_map(|row| (0..19).map(move |k| (row, k))).map(void).collect(),
            ..Parts::default()
        };
        let section = Section::new(parts, Library::builtin()).unwrap();
        let closed = section.closed(Beneath::Absorbing, Ends::Open).unwrap();
        let full = FullWave { elements_per_wavelength: 6.0, memory_bytes: u64::MAX, clock: NO_CLOCK };
        let reflected = |solver: &dyn SectionSolver, section: &Section| reflected(solver, section, 550.0);
        let full = reflected(&full, &closed.regions);
        let fast = (FAST.solver)(&Settings::default());
        let mut smooth = closed.fast.clone();
        // The rows' period, 0.24 µm, is seven tenths of a wavelength in keratin: 0.06 µm would leave a third of it.
        smooth.smooth_um = Some(0.1);
        let (plain, smooth) = (reflected(&*fast, &closed.fast), reflected(&*fast, &smooth));
        // −14 and −10 % without, +0.2 and +0.5 % with averages.
        for ((full, plain), smooth) in full.iter().zip(plain).zip(smooth) {
            assert!(plain / full < 0.91 && (smooth / full - 1.0).abs() < 0.01, "{full} {plain} {smooth}");
        }
    }

    /// What a section reflects of unpolarized light of a wavelength from φ_i = 0° and 30°.
    fn reflected(solver: &dyn SectionSolver, section: &Section, wavelength_nm: f64) -> Vec<f64> {
        let light = Illuminations {
            wavelengths_nm: vec![wavelength_nm],
            theta_i: vec![0.0],
            phi_i: vec![0.0, 30_f64.to_radians()],
            window: Window::Beam,
        };
        let found = solver.prepare(section).unwrap().scatter(&light, 180, &Unobserved).unwrap();
        found.iter().map(|found| found.reflected.unwrap().iter().sum::<f64>() / 2.0).collect()
    }

    /// What full waves say that two hummingbirds reflect from 0° and 30°, by wavelength, nm:
    /// `barbule validate hummingbird:anna --full-wave --width 10 --layers 5 --wavelengths 550 --phi 0,30 --instance 0 -o anna`,
    /// and so with instance 1, and at 580 and 620 nm.
    const BY_FULL_WAVES: [(usize, f64, [f64; 2]); 4] = [
        (0, 550.0, [0.1860, 0.1270]),
        (1, 550.0, [0.1858, 0.1995]),
        (0, 580.0, [0.1892, 0.1996]),
        (0, 620.0, [0.2608, 0.2921]),
    ];

    /// The same of five rock doves, their own 20 µm: `barbule validate rock-dove --full-wave --ensemble 5 -o dove`.
    const DOVES_BY_FULL_WAVES: [(usize, f64, [f64; 2]); 15] = [
        (0, 448.0, [0.0856, 0.0786]),
        (0, 544.0, [0.2015, 0.1014]),
        (0, 640.0, [0.0754, 0.1372]),
        (1, 448.0, [0.0817, 0.0739]),
        (1, 544.0, [0.1767, 0.1283]),
        (1, 640.0, [0.0630, 0.1682]),
        (2, 448.0, [0.0880, 0.0567]),
        (2, 544.0, [0.1777, 0.1313]),
        (2, 640.0, [0.0664, 0.1744]),
        (3, 448.0, [0.0983, 0.0787]),
        (3, 544.0, [0.1815, 0.1400]),
        (3, 640.0, [0.0582, 0.1895]),
        (4, 448.0, [0.0799, 0.0644]),
        (4, 544.0, [0.2138, 0.1238]),
        (4, 640.0, [0.0782, 0.1630]),
    ];

    #[test]
    fn doves_reflect_as_full_waves_say() {
        let structure = Structure::builtin("rock-dove").unwrap();
        let fast = (FAST.solver)(&Settings::default());
        let mut errors = Vec::new();
        for (instance, wavelength_nm, full) in DOVES_BY_FULL_WAVES {
            let closed = structure.instance(1, instance).unwrap();
            let closed = closed.closed(Beneath::Absorbing, Ends::Open).unwrap();
            let found = reflected(&*fast, &closed.fast, wavelength_nm);
            errors.extend(found.iter().zip(full).map(|(found, full)| found / full - 1.0));
        }
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(mean.abs() < 0.03 && errors.iter().all(|error| error.abs() < 0.29), "{mean} {errors:?}");
    }

    #[test]
    fn hummingbirds_reflect_as_full_waves_say() {
        let anna = SpeciesModel::builtin("hummingbird", Some("anna"), Library::builtin()).unwrap();
        let narrow = anna.with_parameters(&[("width_um", 10.0.into()), ("layers", 5.into())]).unwrap();
        let structure = Structure::Species(Box::new(narrow)).smoothed(Smoothing::Over(FINER_THAN_LIGHT_UM));
        let fast = (FAST.solver)(&Settings::default());
        let mut errors = Vec::new();
        for (instance, wavelength_nm, full) in BY_FULL_WAVES {
            let section = structure.instance(1, instance).unwrap();
            let closed = section.closed(Beneath::Absorbing, Ends::Open).unwrap();
            let found = reflected(&*fast, &closed.fast, wavelength_nm);
            errors.extend(found.iter().zip(full).map(|(found, full)| found / full - 1.0));
        }
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(mean.abs() < 0.03 && errors.iter().all(|error| error.abs() < 0.08), "{mean} {errors:?}");
    }
}
