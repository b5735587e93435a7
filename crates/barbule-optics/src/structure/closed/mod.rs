//! Layered and lattice sections made of closed regions alone, for solvers that take nothing else.
//!
//! Nothing meets in a point: where layers touch they become rings in rings. The body is the outline of the first medium under the top,
//! closed by walls of it; in it lies the next layer between its two boundaries, and so on inwards, so that interfaces along normals are
//! the layers' own. Where the media are not the same above and below, the lower end of a layer keeps a gap of its host. What the
//! medium around parts can be left as slabs of their own ([`Ends::Open`]).

mod crystal;
mod layers;
#[cfg(test)]
mod tests;

pub use crystal::{ABSORPTION, RAMP, RAMP_STEP_UM};

use serde::{Deserialize, Serialize};

use super::section::{Inclusion, Loop, Medium, Parts, Polyline, Section, Substance, refuse};
use crate::Result;
use crate::material::Library;

/// Regions stay this far from their hosts' other boundaries, µm.
pub const GAP_UM: f64 = 0.010;

/// What lies under a crystal's rods, where the fast simulation has a half-space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Beneath {
    /// The host, that absorbs more and more up to [`ABSORPTION`]: it sends back less than 1e-4 of what comes there.
    #[default]
    Absorbing,
    /// The host alone, down to its bottom.
    Host,
}

/// How layers end at the sides of a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ends {
    /// Freely: layers that the medium around parts are slabs of their own in it, and what hardly any light reaches under the last of
    /// them is left out of both sections. Layers that touch lie in each other's walls all the same.
    #[default]
    Open,
    /// In walls of the first medium, as thick as the cortex: the outline of a whole barbule.
    Closed,
}

impl Ends {
    /// As flags and numbers name it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Closed => "closed",
        }
    }
}

/// A section in closed regions, and what both kinds of solvers compare.
#[derive(Debug, Clone, PartialEq)]
pub struct Closed {
    /// Of inclusions alone.
    pub regions: Section,
    /// The section for the fast simulation: mixtures are as uniform as in the regions, a crystal's rods as small.
    pub fast: Section,
    /// How its layers end; `None` for crystals, and for sections of inclusions alone.
    pub ends: Option<Ends>,
    /// What is not as it was, in sentences.
    pub changes: Vec<String>,
}

impl Section {
    /// This section as closed regions that do not touch.
    ///
    /// # Errors
    /// The last medium of a layered section is not air, or regions that cannot be told apart.
    pub fn closed(&self, beneath: Beneath, ends: Ends) -> Result<Closed> {
        if self.boundaries.is_empty() {
            let (regions, fast) = (self.clone(), self.clone());
            return Ok(Closed { regions, fast, ends: None, changes: Vec::new() });
        }
        let mut closing =
            Closing { library: self.library.clone(), inclusions: Vec::new(), changes: Vec::new() };
        let mut fast = self.uniform(&mut closing)?;
        let ends = self.crystal.is_none().then_some(ends);
        match ends {
            None => {
                let lattice = closing.crystal(self, beneath)?;
                if let Some((crystal, lattice)) = fast.crystal.as_mut().zip(lattice) {
                    crystal.lattice = lattice;
                }
            }
            Some(Ends::Closed) => closing.body(&fast)?,
            Some(Ends::Open) => {
                closing.leave_out_hidden(&mut fast)?;
                closing.slabs(&fast)?;
            }
        }
        let Closing { library, inclusions, changes } = closing;
        let parts = Parts {
            name: self.name.clone(),
            width_um: Some(self.width_um),
            media: vec![self.media[0].clone()],
            inclusions,
            source: format!("{}, its regions closed", self.source),
            ..Parts::default()
        };
        let mut regions = Self::new(parts, library)?;
        regions.materials.clone_from(&self.materials);
        Ok(Closed { regions, fast, ends, changes })
    }

    /// The same with mixtures as uniform as their mean and crystals as regular everywhere.
    fn uniform(&self, closing: &mut Closing) -> Result<Self> {
        let mut uniform = self.clone();
        let media = uniform.media.iter_mut().chain(uniform.inclusions.iter_mut().map(|i| &mut i.medium));
        for medium in media {
            if let Medium::Mixture { first, second, x_um, fraction } = medium {
                let mean = mean(x_um, fraction, self.width_um);
                let [a, b] = [&*first, &*second].map(Substance::label);
                let all = format!("mix({a},{b},{mean:.6})");
                // Indices have no names that expressions could hold.
                if [&*first, &*second].iter().any(|s| matches!(s, Substance::Index(_))) {
                    return refuse(format!("a mixture of {a} and {b} has no uniform mean; name both media"));
                }
                closing.changes.push(format!("the mixture of {a} and {b} is uniform: {mean:.3} of {b}"));
                *medium = Medium::Pure(Substance::Named(all));
            }
        }
        if uniform.crystal.as_mut().is_some_and(|crystal| crystal.regularity.take().is_some()) {
            closing.changes.push("the crystal is regular everywhere".into());
        }
        Ok(uniform)
    }
}

/// The mean of a fraction over the width.
fn mean(x_um: &[f64], fraction: &[f64], width_um: f64) -> f64 {
    const SAMPLES: u32 = 1000;
    let at = |i: u32| width_um * ((f64::from(i) + 0.5) / f64::from(SAMPLES) - 0.5);
    let sum: f64 = (0..SAMPLES).map(|i| super::section::profile(x_um, fraction, at(i))).sum();
    sum / f64::from(SAMPLES)
}

struct Closing {
    library: Library,
    inclusions: Vec<Inclusion>,
    changes: Vec<String>,
}

/// A region between an upper and a lower curve.
#[derive(Debug, Clone)]
struct Band {
    upper: Vec<[f64; 2]>,
    lower: Vec<[f64; 2]>,
}

impl Band {
    fn ends(&self) -> [f64; 2] {
        [self.upper[0][0], self.upper[self.upper.len() - 1][0]]
    }

    fn outline(&self) -> Loop {
        let points = self.upper.iter().chain(self.lower.iter().rev());
        let (x_um, z_um) = points.map(|p| (p[0], p[1])).unzip();
        Loop::polygon(x_um, z_um)
    }
}

impl Closing {
    fn push(&mut self, band: &Band, medium: &Medium) {
        self.inclusions.push(Inclusion {
            outline: band.outline(),
            medium: medium.clone(),
            holes: Vec::new(),
        });
    }
}

fn label(medium: &Medium) -> String {
    medium.substances().map(Substance::label).collect::<Vec<_>>().join(" and ")
}

fn points(curve: &Polyline) -> Vec<[f64; 2]> {
    curve.x_um.iter().zip(&curve.z_um).map(|(&x, &z)| [x, z]).collect()
}

fn raised(curve: &[[f64; 2]], by_um: f64) -> Vec<[f64; 2]> {
    curve.iter().map(|&[x, z]| [x, z + by_um]).collect()
}

/// The height of a curve at x.
fn height(curve: &[[f64; 2]], x: f64) -> f64 {
    let right = curve.partition_point(|p| p[0] <= x).clamp(1, curve.len() - 1);
    let (a, b) = (curve[right - 1], curve[right]);
    a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0]))
}

fn mean_gap(upper: &[[f64; 2]], lower: &[[f64; 2]]) -> f64 {
    let sum: f64 = upper.iter().map(|&[x, z]| z - height(lower, x)).sum();
    sum / upper.len() as f64
}

/// What of the region between two curves lies in a host, away from its walls and its other boundaries: one band, or several
/// where it is too thin in between. The gap is kept along z; `moved_um` learns by how much a curve gave way at most.
fn inner(
    host: &Band,
    upper: &[[f64; 2]],
    lower: &[[f64; 2]],
    walls_um: f64,
    moved_um: &mut f64,
) -> Vec<Band> {
    let [left, right] = host.ends();
    let (left, right) = (left + walls_um, right - walls_um);
    let mut grid: Vec<f64> = [upper, lower].iter().flat_map(|curve| curve.iter().map(|p| p[0])).collect();
    grid.extend([left, right]);
    grid.retain(|x| (left..=right).contains(x));
    grid.sort_by(f64::total_cmp);
    grid.dedup_by(|a, b| *a - *b < 1e-6);
    let heights = |x: f64| {
        let top = height(upper, x).min(height(&host.upper, x) - GAP_UM);
        let bottom = height(lower, x).max(height(&host.lower, x) + GAP_UM);
        [top, bottom]
    };
    let is_open = |x: f64| {
        let [top, bottom] = heights(x);
        top - bottom >= GAP_UM
    };
    let mut bands = Vec::new();
    for run in grid.chunk_by(|a, b| is_open(*a) == is_open(*b)) {
        if run.len() < 3 || !is_open(run[0]) {
            continue;
        }
        let [from, to] = [run[0], run[run.len() - 1]];
        let cut = |curve: &[[f64; 2]], side: usize| -> Vec<[f64; 2]> {
            let inside = curve.iter().map(|p| p[0]).filter(|x| from + 1e-4 < *x && *x < to - 1e-4);
            let xs = std::iter::once(from).chain(inside).chain(std::iter::once(to));
            xs.map(|x| [x, heights(x)[side]]).collect()
        };
        let band = Band { upper: cut(upper, 0), lower: cut(lower, 1) };
        let moved = band.upper.iter().map(|p| height(upper, p[0]) - p[1]);
        let moved = moved.chain(band.lower.iter().map(|p| p[1] - height(lower, p[0])));
        *moved_um = moved.fold(*moved_um, f64::max);
        bands.push(band);
    }
    bands
}
