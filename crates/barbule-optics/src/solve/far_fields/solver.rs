//! The interface that all solvers of sections share.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Illuminations;
use crate::progress::{Clock, NO_CLOCK, OnlyStops, Progress};
use crate::scattering::far_field::{FarField, Illumination, IncidentLight};
use crate::solve::cost::{Cost, PROGRAM};
use crate::solve::surface::Size;
use crate::structure::Section;
use crate::{Error, Result};

/// Nodes per wavelength of solvers of equations, in the denser of the media at each boundary, unless somebody asks for others.
pub const ELEMENTS_PER_WAVELENGTH: f64 = 10.0;
/// Nodes per wavelength that make sense.
pub const ELEMENTS: std::ops::RangeInclusive<f64> = 4.0..=200.0;

/// A way to the far fields of sections, as programs offer it; its name tells it apart.
#[derive(Debug, Clone, Copy)]
pub struct Method {
    /// What it is chosen by.
    pub name: &'static str,
    /// What it is, in a few words.
    pub about: &'static str,
    /// What one of its results is called; several with an s.
    pub noun: &'static str,
    /// What takes less memory, to end a sentence with "give …".
    pub smaller: &'static str,
    /// Whether it solves Maxwell's equations up to discretization. The others follow the fast simulation's formulas, which lose or
    /// gain power near grazing: [`mirror_fraction`](crate::solve::surface::mirror_fraction).
    pub is_exact: bool,
    /// Its solver.
    pub solver: fn(&Settings) -> Box<dyn SectionSolver>,
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// What can be chosen of solvers; each takes what concerns it.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Nodes per wavelength in the denser of the media at each boundary.
    pub elements_per_wavelength: f64,
    /// Solutions of equations are given up where they would take more, bytes.
    pub memory_bytes: u64,
    /// Times them.
    pub clock: Clock,
}

impl Default for Settings {
    fn default() -> Self {
        Self { elements_per_wavelength: ELEMENTS_PER_WAVELENGTH, memory_bytes: u64::MAX, clock: NO_CLOCK }
    }
}

/// Solves for the far fields of sections.
pub trait SectionSolver: Sync {
    /// A section as this solver takes it.
    ///
    /// # Errors
    /// A section that it cannot do.
    fn prepare<'a>(&self, section: &'a Section) -> Result<Box<dyn Prepared + 'a>>;
}

/// A section as one solver takes it.
pub trait Prepared: Sync {
    /// What is not as it was given, in sentences.
    fn changes(&self) -> &[String] {
        &[]
    }

    /// What [`Self::scatter`] takes on so many threads: at most at once, and in all. Solvers that divide the section's boundaries for
    /// each wavelength do so here too, and take a part of a second each.
    ///
    /// # Errors
    /// As [`Self::scatter`], as far as that is known without its work; or a stop by `progress`.
    fn cost(
        &self,
        light: &Illuminations,
        azimuths: usize,
        threads: usize,
        progress: &dyn Progress,
    ) -> Result<Cost>;

    /// What the section does with each light, in the order of [`Illuminations::iter`], on so many azimuths of the range that the
    /// solver gives; the same bits on any number of threads.
    ///
    /// # Errors
    /// Light that does not come through air, a medium whose table does not reach, a solution that did not settle, or a stop by
    /// `progress`: the first in this order.
    fn scatter(
        &self,
        light: &Illuminations,
        azimuths: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Scattered>>;
}

/// What a section does with light of one wavelength from one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Scattered {
    /// The far field: over the upper half of azimuths, or over the full circle.
    pub far: FarField,
    /// The part of Φ_i that leaves into the upper half, by incident polarization; `None` for a plane wave.
    pub reflected: Option<[f64; 2]>,
    /// Where all light goes, from solvers of Maxwell's equations.
    pub exact: Option<Exact>,
    /// What these took: light of one wavelength and θ_i shares one solution.
    pub effort: Option<Effort>,
}

/// Where all light goes by Maxwell's equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exact {
    /// ∫ dσ over all azimuths, µm for unit |E|, by incident polarization.
    pub scattered_um: [f64; 2],
    /// By the forward amplitude (optical theorem), µm; `None` for a beam.
    pub extinction_um: Option<[f64; 2]>,
    /// What flows into absorbing regions, µm for unit |E|.
    pub absorbed_um: [f64; 2],
}

/// The size of a solution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Unknown numbers, four for each node.
    pub unknowns: usize,
    /// Nodes per wavelength in the denser medium.
    pub elements_per_wavelength: f64,
    /// Wall time, s.
    pub seconds: f64,
    /// Memory of the equations, bytes.
    pub memory_bytes: u64,
}

/// Bytes of an element of a field on azimuths, with those it is refined from.
const FIELD_VALUE: usize = 64;

/// A section whose illuminations are computed one by one, on a thread each: formulas with quadrature points along the top.
pub(in crate::solve) struct OneByOne<'a, F> {
    pub(in crate::solve) section: &'a Section,
    /// Longest quadrature element, µm.
    pub(in crate::solve) element_um: f64,
    /// The far field over so many azimuths of the upper half.
    pub(in crate::solve) far_field: F,
}

impl<F> Prepared for OneByOne<'_, F>
where
    F: Fn(&Section, &Illumination, usize, &dyn Progress) -> Result<FarField> + Sync,
{
    fn cost(
        &self,
        light: &Illuminations,
        azimuths: usize,
        threads: usize,
        _progress: &dyn Progress,
    ) -> Result<Cost> {
        let size = Size::foretell(self.section, self.element_um)?;
        let shortest_nm = light.wavelengths_nm.iter().copied().fold(f64::INFINITY, f64::min);
        let own = size.casting_bytes(1) + size.bytes() + size.workspace_bytes(shortest_nm, 1, 8);
        let each = PROGRAM + (own + 4 * FIELD_VALUE * azimuths) as u64;
        let at_once = light.count().min(threads) as u64;
        Ok(Cost { bytes: each.saturating_mul(at_once), ..Cost::default() })
    }

    fn scatter(
        &self,
        light: &Illuminations,
        azimuths: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Scattered>> {
        let one = |index: usize, progress: &dyn Progress| -> Result<Scattered> {
            let far = (self.far_field)(self.section, &light.at(index), azimuths, progress)?;
            let reflected = (far.light != IncidentLight::PlaneWave).then_some(far.radiated);
            Ok(Scattered { far, reflected, exact: None, effort: None })
        };
        if light.count() == 1 {
            return Ok(vec![one(0, progress)?]);
        }
        progress.begin("far fields", light.count() as u64);
        let found: Vec<_> = (0..light.count())
            .into_par_iter()
            .map(|index| {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let scattered = one(index, &OnlyStops(progress));
                progress.advance(1);
                scattered
            })
            .collect();
        found.into_iter().collect()
    }
}
