//! Barbules in three dimensions: a cross section carried along y, each of its boundaries with a small roughness of its own.
//!
//! Rock doves' melanin granules and hummingbirds' pancake melanosomes are no bodies that go on along y: they are laid out in
//! the plane anew. Source: the feather paper's supplement, §6.1, which leaves all numbers open; the theory page says ours.

mod cut;
mod pancakes;
mod relief;
mod sampled;
#[cfg(test)]
mod tests;

pub use cut::{Cut, CutLayer, Plane};
pub use sampled::{Layers, Line, Sampled, SegmentGrid};

use super::section::Section;
use super::species::{GeneratorParameters, SpeciesModel};
use super::{RockDove, Structure};
use crate::math::rng::Stream;
use crate::{Error, Result};
use pancakes::Pancakes;
use relief::Relief;

/// The longest and the shortest segment, µm.
pub const SEGMENT_LENGTHS_UM: [f64; 2] = [1.0, 1000.0];

/// The most boundaries that are roughened.
const MOST_BOUNDARIES: usize = 512;

/// What the random streams of a segment are for.
const TOP: u64 = 0x3d00;
const BOUNDARIES: u64 = 0x3d01;
const GRANULES: u64 = 0x3d02;
const PANCAKES: u64 = 0x3d03;

/// How many standard deviations of a field stand for half its span, as in profiles R(τ; a, b) along a barbule.
const SPAN: f64 = 2.2;

/// Roughness of each boundary: normally distributed heights with the autocorrelation exp(−Δx²/2τ_x² − Δy²/2τ_y²).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roughness {
    /// Standard deviation of the height, µm; 0 makes a segment exactly invariant along y.
    pub amplitude_um: f64,
    /// Correlation lengths τ along x and y, µm.
    pub correlation_um: [f64; 2],
}

impl Default for Roughness {
    /// 10 nm over half a micrometre: slopes of 0.02.
    fn default() -> Self {
        Self { amplitude_um: 0.01, correlation_um: [0.5, 0.5] }
    }
}

impl Roughness {
    /// None: segments are exactly invariant along y.
    pub const NONE: Self = Self { amplitude_um: 0.0, correlation_um: [1.0, 1.0] };

    /// # Errors
    /// A correlation length is not positive, the amplitude is negative or over 1 µm, or slopes would be over 1.
    pub fn check(&self) -> Result<()> {
        let Self { amplitude_um, correlation_um } = *self;
        if !correlation_um.iter().all(|tau| (0.02..=1000.0).contains(tau)) {
            return Err(Error::input(format!(
                "roughness: the correlation lengths are {} and {} µm; give lengths from 0.02 to 1000",
                correlation_um[0], correlation_um[1]
            )));
        }
        let most = (0.5 * correlation_um[0].min(correlation_um[1])).min(1.0);
        if !(0.0..=most).contains(&amplitude_um) {
            return Err(Error::input(format!(
                "roughness: the amplitude is {amplitude_um} µm; give 0 to {most} µm (at most 1, and half the shorter correlation length)"
            )));
        }
        Ok(())
    }
}

/// A barbule in three dimensions.
#[derive(Debug, Clone)]
pub struct Segment {
    /// The cross section that was carried along y.
    pub section: Section,
    /// How far it goes along y, µm: from −L/2 to L/2.
    pub length_um: f64,
    /// Of each boundary.
    pub roughness: Roughness,
    top: Option<Relief>,
    /// By the layer above each boundary below the top.
    boundaries: Vec<Relief>,
    under: Under,
}

/// What lies under the top.
#[derive(Debug, Clone)]
enum Under {
    /// The layers of the section, or its crystal.
    Section,
    /// Those of a rock dove with granules laid out in the plane.
    Granules(Granules),
    /// A hummingbird's melanosomes as discs.
    Pancakes(Pancakes),
}

/// Melanin granules under a film: how deep they begin, and the part of melanin among them.
#[derive(Debug, Clone)]
struct Granules {
    gap: Map,
    melanin: Map,
}

/// A field that spans a range.
#[derive(Debug, Clone)]
struct Map {
    relief: Relief,
    low: f64,
    high: f64,
}

impl Map {
    fn new(stream: &mut Stream, correlation_um: f64, low: f64, high: f64) -> Self {
        Self { relief: Relief::new(stream, [correlation_um; 2]), low, high }
    }

    fn value(&self, field: f32) -> f64 {
        let t = 0.5 + 0.5 * (f64::from(field) / SPAN).clamp(-1.0, 1.0);
        self.low + (self.high - self.low) * t
    }
}

impl Granules {
    fn new(dove: &RockDove, stream: &mut Stream) -> Self {
        Self {
            gap: Map::new(stream, dove.gap_correlation_um, dove.gap_low_um, dove.gap_high_um),
            melanin: Map::new(stream, dove.melanin_correlation_um, dove.melanin_low, dove.melanin_high),
        }
    }
}

impl Segment {
    /// Carries a section along y over `length_um` and roughens its boundaries.
    ///
    /// The same section, roughness and seed give the same segment, however finely it is sampled later.
    ///
    /// # Errors
    /// The section has no top or one that overhangs, is not lit through air, or the length or roughness is out of range.
    pub fn of_section(
        section: Section,
        length_um: f64,
        roughness: Roughness,
        seed: u64,
        index: usize,
    ) -> Result<Self> {
        section.check_lit_through_air()?;
        section.check_nothing_above_top()?;
        roughness.check()?;
        let [shortest, longest] = SEGMENT_LENGTHS_UM;
        if !(shortest..=longest).contains(&length_um) {
            return Err(Error::input(format!(
                "a segment of {length_um} µm cannot be made; give a length from {shortest} to {longest} µm"
            )));
        }
        if section.boundaries.is_empty() || section.top().x_um.windows(2).any(|x| x[1] <= x[0]) {
            return Err(Error::input(format!(
                "the top of the section '{}' overhangs or is missing; a segment needs one height above each place",
                section.name
            )));
        }
        let rough = roughness.amplitude_um > 0.0;
        let relief = |purpose: u64, part: u64| {
            let mut stream = Stream::new(seed, &[index as u64, purpose, part]);
            Relief::new(&mut stream, roughness.correlation_um)
        };
        let boundaries =
            if rough && section.crystal.is_none() { MOST_BOUNDARIES.min(slots(&section)?) } else { 0 };
        Ok(Self {
            length_um,
            roughness,
            top: rough.then(|| relief(TOP, 0)),
            boundaries: (0..boundaries).map(|part| relief(BOUNDARIES, part as u64)).collect(),
            under: Under::Section,
            section,
        })
    }

    /// A segment of a species: as [`Self::of_section`], with what a species lays out in the plane.
    fn of_species(
        model: &SpeciesModel,
        length_um: f64,
        roughness: Roughness,
        seed: u64,
        index: usize,
    ) -> Result<Self> {
        let section = model.section(seed, index)?;
        let mut segment = Self::of_section(section, length_um, roughness, seed, index)?;
        // Without roughness nothing may change along y.
        if roughness.amplitude_um > 0.0 {
            let path = |purpose| [index as u64, purpose];
            segment.under = match &model.parameters {
                GeneratorParameters::RockDove(dove) => {
                    Under::Granules(Granules::new(dove, &mut Stream::new(seed, &path(GRANULES))))
                }
                GeneratorParameters::Hummingbird(bird) => {
                    let area_um = [segment.section.width_um, length_um];
                    Under::Pancakes(Pancakes::new(bird, area_um, seed, index, PANCAKES)?)
                }
                _ => Under::Section,
            };
        }
        Ok(segment)
    }
}

impl Structure {
    /// One instance in three dimensions.
    ///
    /// # Errors
    /// As [`Structure::instance`] and [`Segment::of_section`].
    pub fn segment(&self, seed: u64, index: usize, length_um: f64, roughness: Roughness) -> Result<Segment> {
        match self {
            Self::Species(model) => Segment::of_species(model, length_um, roughness, seed, index),
            _ => Segment::of_section(self.instance(seed, index)?, length_um, roughness, seed, index),
        }
    }
}

/// Layers under the places of a section's top, those of no thickness included; in three dimensions none are averages.
fn slots(section: &Section) -> Result<usize> {
    let grid = SegmentGrid::across(section, sampled::COARSE_UM);
    Ok(super::cast::layers(section, &grid.rays(section, 1))?.slots)
}
