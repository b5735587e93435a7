//! How accurate the fast simulation is: the same sections by it and by full waves, in numbers and figures.

mod figures;
mod numbers;
pub mod three_d;

pub use numbers::{Case, Comparison, Incidence};

use rayon::prelude::*;

use crate::campaign::far_field_bytes;
use crate::clock;
use crate::progress::{OnlyStops, Progress};
use crate::scattering::far_field::{FarField, Polarization, Window};
use crate::solve::far_fields::{Illuminations, Method, far_fields};
use crate::solve::full_wave;
use crate::solve::surface::FINE_ELEMENT_UM;
use crate::spectrum::Wavelengths;
use crate::structure::{Closed, Section};
use crate::{Error, Result};

/// What is compared.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What it is called.
    pub name: String,
    /// The section as both solvers get it.
    pub closed: Closed,
    /// Vacuum wavelengths.
    pub wavelengths: Wavelengths,
    /// Azimuths of incidence, rad; θ_i is 0.
    pub phi_i: Vec<f64>,
    /// Azimuths of the upper half at which patterns are compared.
    pub azimuths: usize,
    /// Nodes per wavelength of the full waves.
    pub elements_per_wavelength: f64,
    /// What is compared with them: the fast simulation, or its formulas with shadows.
    pub method: Method,
    /// Standard deviation over which the fast simulation's outlines were averaged, µm.
    pub smooth_um: Option<f64>,
    /// Full waves are given up where their equations would take more, bytes.
    pub memory_bytes: u64,
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

    /// What the full waves take.
    ///
    /// # Errors
    /// As [`full_wave::cost`].
    pub fn cost(&self, threads: usize) -> Result<full_wave::Cost> {
        full_wave::cost(&self.closed.regions, &self.light(), self.elements_per_wavelength, threads)
    }

    /// Runs both.
    ///
    /// # Errors
    /// As the solvers; or the user cancelled.
    pub fn run(&self, progress: &dyn Progress) -> Result<Comparison> {
        let light = self.light();
        let by_formulas = |light: &Illuminations| {
            far_fields(&self.closed.fast, light, self.azimuths, self.method, &OnlyStops(progress))
        };
        let start = clock::system();
        let windowed = by_formulas(&self.light_through(Window::Gaussian))?;
        let fast_seconds = (clock::system() - start).as_secs_f64();
        let fast = by_formulas(&light)?;
        let shortest = self.wavelengths.nm().iter().copied().fold(f64::INFINITY, f64::min);
        let fast_bytes = far_field_bytes(&self.closed.fast, shortest, self.azimuths, FINE_ELEMENT_UM)?;
        let (incidences, count) = (self.phi_i.len(), self.wavelengths.len());
        progress.begin("full waves", count as u64);
        let mut cases = Vec::with_capacity(light.count());
        for (w, &wavelength_nm) in self.wavelengths.nm().iter().enumerate() {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let full = self.full_waves(wavelength_nm, &OnlyStops(progress))?;
            let of_this = w * incidences..(w + 1) * incidences;
            let formulas = fast[of_this.clone()].iter().zip(&windowed[of_this]);
            let pairs = formulas.zip(&full);
            cases
                .extend(pairs.map(|((fast, windowed), full)| self.case(wavelength_nm, fast, windowed, full)));
            progress.advance(1);
        }
        // [wavelength][incidence] → [incidence][wavelength]
        let of = |i: usize| (0..count).map(|w| cases[w * incidences + i].clone()).collect::<Vec<_>>();
        let found = (0..incidences)
            .into_par_iter()
            .map(|i| Incidence::new(self.phi_i[i].to_degrees(), of(i), &self.wavelengths));
        Ok(Comparison {
            name: self.name.clone(),
            width_um: self.closed.regions.width_um,
            changes: self.closed.changes.clone(),
            wavelengths_nm: self.wavelengths.nm().to_vec(),
            elements_per_wavelength: self.elements_per_wavelength,
            fast_seconds,
            has_shadows: self.method == Method::Shadowed,
            smooth_um: self.smooth_um,
            fast_bytes,
            incidences: found.collect(),
        })
    }

    fn full_waves(&self, wavelength_nm: f64, progress: &dyn Progress) -> Result<Vec<full_wave::Solved>> {
        let light = Illuminations { wavelengths_nm: vec![wavelength_nm], ..self.light() };
        // Every second of four times as many azimuths of the circle is one of the upper half's.
        let circle = 4 * self.azimuths;
        let (elements, memory_bytes) = (self.elements_per_wavelength, self.memory_bytes);
        full_wave::solve(
            &self.closed.regions,
            &light,
            circle,
            elements,
            memory_bytes,
            clock::system,
            progress,
        )
    }

    fn case(
        &self,
        wavelength_nm: f64,
        fast: &FarField,
        windowed: &FarField,
        full: &full_wave::Solved,
    ) -> Case {
        let unpolarized = |far: &FarField| -> Vec<f64> {
            let [a, b] = Polarization::BOTH.map(|p| far.per_radian(p));
            a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect()
        };
        let circle = unpolarized(&full.scattered.far);
        let upper = (0..self.azimuths).map(|n| circle[self.azimuths + 2 * n + 1]);
        let power_um = full.scattered.far.light.scale().powi(-2);
        let mean = |both: [f64; 2]| 0.5 * (both[0] + both[1]);
        let reflected = full.scattered.reflected.map_or(f64::NAN, mean);
        Case {
            wavelength_nm,
            fast: unpolarized(fast),
            full: upper.collect(),
            reflected: [mean(fast.radiated), reflected],
            windowed: mean(windowed.radiated),
            scattered: mean(full.scattered.far.radiated),
            absorbed: mean(full.scattered.absorbed_um) / power_um,
            effort: full.effort,
        }
    }
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
    use crate::progress::Unobserved;
    use crate::structure::{Beneath, Medium, Parts, Polyline};

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
            azimuths: usual_azimuths(&section, 550.0),
            closed: section.closed(Beneath::Absorbing).unwrap(),
            wavelengths: Wavelengths::new(vec![550.0]).unwrap(),
            phi_i: vec![60_f64.to_radians()],
            elements_per_wavelength: 6.0,
            method: Method::Fast,
            smooth_um: None,
            memory_bytes: u64::MAX,
        };
        let full = plan.full_waves(550.0, &Unobserved).unwrap().swap_remove(0);
        let by = |method: Method| {
            let fast =
                far_fields(&plan.closed.fast, &plan.light(), plan.azimuths, method, &Unobserved).unwrap();
            plan.case(550.0, &fast[0], &fast[0], &full)
        };
        let (plain, shadowed) = (by(Method::Direct), by(Method::Shadowed));
        // 0.620 and 0.804, 0.81 and 0.50 are reached.
        assert!(plain.correlation() < 0.65 && shadowed.correlation() > 0.75, "{}", shadowed.correlation());
        assert!(plain.rms() > 0.75 && shadowed.rms() < 0.55, "{} {}", plain.rms(), shadowed.rms());
    }
}
