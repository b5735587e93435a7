//! Bodies as signed distances: ellipsoids and tapering tubes that melt into each other, and the closed mesh of their surface.
//!
//! A tube of a path with radii is the union of its rounded cones, each the envelope of a sphere that grows as it moves along a segment.
//! Parts are joined by a cubic smooth minimum [Quílez, *Smooth minimum*: min(a, b) − k h³/6 with h = max(k − |a − b|, 0)/k],
//! whose first and second derivatives are continuous, so that a blend has no crease.

mod nets;

use glam::{DMat3, DVec3};

use crate::progress::Progress;
use crate::scene::geometry::Mesh;
use crate::{Error, Result};

pub use nets::MOST_CELLS;

/// Segments between two points of a path.
const STEPS: u32 = 6;
/// Cells that are left about the parts.
const MARGIN: f64 = 2.5;
/// Distances are no steeper than this where a part is stretched: near the middle of flat ellipsoids they lose their meaning.
const LEAST_SLOPE: f64 = 1e-9;

/// A body made of parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// The parts, in the order in which they are joined.
    pub parts: Vec<Part>,
    /// Distance of the points that make its surface, mm.
    pub resolution_mm: f64,
}

/// One part of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// A point and a radius along a path, mm; one alone is a sphere.
    pub nodes: Vec<(DVec3, f64)>,
    /// Factors to its lengths along its own x, y and z.
    pub stretch: DVec3,
    /// How it is turned.
    pub turn: DMat3,
    /// Where its origin stands, mm.
    pub shift: DVec3,
    /// How far it melts into the parts before it, mm.
    pub blend_mm: f64,
    /// Whether it stands on both sides of the plane x = 0.
    pub is_mirrored: bool,
    /// Whether it is taken away from the parts before it.
    pub is_cut: bool,
}

impl Part {
    /// A smooth path through points: cubic (Catmull & Rom 1974), with radii that never leave those at the ends of their span.
    #[must_use]
    pub fn path(points: &[DVec3], radii: &[f64]) -> Vec<(DVec3, f64)> {
        let last = points.len() - 1;
        let mut nodes = Vec::with_capacity(last * STEPS as usize + 1);
        for span in 0..last {
            let at = |k: usize| points[(span + k).saturating_sub(1).min(last)];
            let (p, q, r, s) = (at(0), at(1), at(2), at(3));
            for step in 0..STEPS {
                let t = f64::from(step) / f64::from(STEPS);
                let point = q + 0.5
                    * t
                    * ((r - p) + t * ((2.0 * p - 5.0 * q + 4.0 * r - s) + t * (3.0 * (q - r) + s - p)));
                let eased = t * t * (3.0 - 2.0 * t);
                nodes.push((point, radii[span] + eased * (radii[span + 1] - radii[span])));
            }
        }
        nodes.push((points[last], radii[last]));
        nodes
    }

    /// Signed distance to its surface, mm, of first order: the value over its slope where it is stretched.
    fn distance(&self, point: DVec3) -> f64 {
        let mirrored = if self.is_mirrored { DVec3::new(point.x.abs(), point.y, point.z) } else { point };
        let own = self.turn.transpose() * (mirrored - self.shift) / self.stretch;
        let (distance, out) = self.unstretched(own);
        if self.stretch == DVec3::ONE {
            return distance;
        }
        let slope = (out / self.stretch).length();
        if slope > LEAST_SLOPE { distance / slope } else { distance * self.stretch.min_element() }
    }

    /// Signed distance in its own lengths, and the direction in which it grows.
    fn unstretched(&self, point: DVec3) -> (f64, DVec3) {
        if let [(middle, radius)] = self.nodes[..] {
            let off = point - middle;
            return (off.length() - radius, off.normalize_or_zero());
        }
        let cones = self.nodes.windows(2).map(|pair| cone(point, pair[0], pair[1]));
        cones.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, DVec3::ZERO))
    }

    /// A box that holds it, mm.
    fn bounds(&self) -> [DVec3; 2] {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &(point, radius) in &self.nodes {
            let middle = self.turn * (point * self.stretch) + self.shift;
            // Half extents of an ellipsoid with these half axes in its turn.
            let rows = self.turn.transpose();
            let reach = DVec3::from_array([0, 1, 2].map(|k| (rows.col(k) * self.stretch * radius).length()));
            (low, high) = (low.min(middle - reach), high.max(middle + reach));
        }
        if self.is_mirrored {
            let far = low.x.abs().max(high.x.abs());
            (low.x, high.x) = (-far, far);
        }
        [low, high]
    }
}

/// Distance to the envelope of spheres between two, and the direction in which it grows. Of all spheres with their middle at t on the
/// segment the nearest is where (t − y)/|p − c(t)| = (r₂ − r₁)/l, y being the point's place along it: t = y + x tan α, sin α = (r₂ − r₁)/l.
fn cone(point: DVec3, (a, r): (DVec3, f64), (b, s): (DVec3, f64)) -> (f64, DVec3) {
    let to_b = b - a;
    let length = to_b.length();
    let sphere = |middle: DVec3, radius: f64| {
        let off = point - middle;
        (off.length() - radius, off.normalize_or_zero())
    };
    let sine = (s - r) / length;
    if length.is_nan() || length <= 0.0 || sine.abs() >= 1.0 {
        // One sphere holds the other.
        return if r >= s { sphere(a, r) } else { sphere(b, s) };
    }
    let along = to_b / length;
    let y = (point - a).dot(along);
    let x = (point - a - along * y).length();
    let t = (y + x * sine / (1.0 - sine * sine).sqrt()).clamp(0.0, length);
    sphere(a + along * t, r + (s - r) * t / length)
}

/// The smaller of two distances, rounded where they differ by less than `blend`.
fn smooth_min(a: f64, b: f64, blend: f64) -> f64 {
    if blend <= 0.0 {
        return a.min(b);
    }
    let near = (blend - (a - b).abs()).max(0.0) / blend;
    a.min(b) - near * near * near * blend / 6.0
}

impl Form {
    /// Signed distance to its surface, mm, negative within: of first order, and exact for spheres and tubes without blends.
    #[must_use]
    pub fn distance(&self, point: DVec3) -> f64 {
        self.parts.iter().fold(f64::INFINITY, |joined, part| {
            let own = part.distance(point);
            match part.is_cut {
                true => -smooth_min(-joined, own, part.blend_mm),
                false if joined == f64::INFINITY => own,
                false => smooth_min(joined, own, part.blend_mm),
            }
        })
    }

    /// The direction in which the distance grows, by differences over a hundredth of the resolution.
    #[must_use]
    pub fn outwards(&self, point: DVec3) -> DVec3 {
        let step = 0.01 * self.resolution_mm;
        let slope = |axis: DVec3| self.distance(point + axis * step) - self.distance(point - axis * step);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize_or(DVec3::Z)
    }

    /// A box that holds it with a margin, mm.
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        let mut all = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for part in self.parts.iter().filter(|part| !part.is_cut) {
            let [low, high] = part.bounds();
            // A blend is a sixth of its width thicker.
            let pad = DVec3::splat(part.blend_mm / 6.0 + MARGIN * self.resolution_mm);
            all = [all[0].min(low - pad), all[1].max(high + pad)];
        }
        all
    }

    /// Cells along x, y and z of the grid on which its surface is found.
    #[must_use]
    pub fn cells(&self) -> [f64; 3] {
        let [low, high] = self.bounds();
        ((high - low) / self.resolution_mm).ceil().max(DVec3::ONE).to_array()
    }

    /// Triangles at most of a surface that runs straight through its box: what memory is foretold from.
    #[must_use]
    pub fn triangles(&self) -> f64 {
        let [x, y, z] = self.cells();
        8.0 * (x * y + y * z + z * x)
    }

    /// Refuses too fine a grid.
    ///
    /// # Errors
    /// Over [`MOST_CELLS`] cells; a form without a size.
    pub fn check(&self) -> Result<()> {
        let cells: f64 = self.cells().iter().product();
        if cells.is_nan() || cells > MOST_CELLS {
            return Err(Error::input(format!(
                "resolution_mm of {} makes a grid of {cells:.3e} cells, over the limit of {MOST_CELLS:.0e}; give a coarser one",
                self.resolution_mm
            )));
        }
        Ok(())
    }

    /// Its surface: closed, outward, with the normals of the distance; the same bits on any number of threads.
    ///
    /// # Errors
    /// Too fine a grid, nothing left of it, or a stop by `progress`.
    pub fn mesh(&self, progress: &dyn Progress) -> Result<Mesh> {
        self.check()?;
        nets::mesh(self, progress)
    }
}

#[cfg(test)]
mod tests;
