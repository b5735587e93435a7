//! What a grown feather measures: taken from its geometry, to be held against the sizes it was grown from.

use glam::{DVec3, Vec3};

use super::{Barb, BarbuleShape, Feather, Grown, Level, Shaft, Vane, VaneDisc};
use crate::Result;
use crate::bsdf::ramus_taper;
use crate::progress::Progress;

/// Mean length of the barbules along a barb over the greatest.
const MEAN_LENGTH: f64 = 0.86;
/// Cells of the grid on which coverage is counted, along either side.
const CELLS: usize = 512;
/// Where on the vane coverage is counted, as a share of its length.
const PLACE: f64 = 0.62;
/// Largest radius of the part that is grown for it, mm.
const PATCH_MM: f64 = 2.0;

/// Measures of one vane, from its grown barbs.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct VaneMeasures {
    /// Barbs that leave the shaft.
    pub barbs: usize,
    /// Barbs of the tuft at the tip, beside them.
    pub tuft: usize,
    /// Greatest distance of a barb's end from the shaft, mm.
    pub widest_mm: f64,
    /// Mean over the vane of that distance, mm.
    pub mean_width_mm: f64,
    /// Mean perpendicular distance of neighbours at their bases, µm.
    pub spacing_um: f64,
    /// Angle of the first and of the last barb to the shaft, degrees.
    pub base_angle_deg: f64,
    /// That of the last one before the tuft, degrees.
    pub tip_angle_deg: f64,
    /// Mean length of a barb, mm.
    pub mean_barb_mm: f64,
    /// Longest barb, mm.
    pub longest_barb_mm: f64,
}

/// Measures of a feather.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Measures {
    /// Length of the shaft along its curve, mm.
    pub length_mm: f64,
    /// Length from its base to its tip, straight, mm.
    pub straight_mm: f64,
    /// Length of the quill, mm.
    pub calamus_mm: f64,
    /// Width of the quill, mm.
    pub calamus_width_mm: f64,
    /// The leading vane.
    pub leading: VaneMeasures,
    /// The trailing vane.
    pub trailing: VaneMeasures,
    /// Barbs that are downy.
    pub downy_barbs: usize,
    /// Barbules of all barbs.
    pub barbules: usize,
    /// Barbules on a mm of a barb of the closed vane, both sides together.
    pub barbules_per_mm: f64,
    /// Share of the closed vane that light along its normal meets, where there is such.
    pub coverage: Option<f64>,
}

impl Feather {
    /// Measures a feather that is grown from these draws.
    ///
    /// # Errors
    /// As [`Feather::check`], or a stop by `progress`.
    pub fn measures(&self, seed: u64, identity: u64, progress: &dyn Progress) -> Result<Measures> {
        let whole = VaneDisc { along_mm: 0.0, radius_mm: None };
        let (shaft, barbs) = self.barbs_within(whole, (seed, identity), progress)?;
        let [first, last] = shaft.vane_range();
        let points: Vec<DVec3> = (0..=1000).map(|i| shaft.at(last * f64::from(i) / 1000.0).point).collect();
        let of = |vane| self.vane_measures(&shaft, &barbs, vane);
        let barbules = barbs.iter().map(|barb| self.barbule_count(barb)).sum();
        let per_mm = 1e3 / self.distal.spacing_um + 1e3 / self.proximal.spacing_um;
        let downy_per_mm = 2e3 / self.downy.spacing_um;
        Ok(Measures {
            length_mm: points.windows(2).map(|pair| (pair[1] - pair[0]).length()).sum(),
            straight_mm: (points[1000] - points[0]).length(),
            calamus_mm: first,
            calamus_width_mm: 2.0 * shaft.radius(0.5 * first),
            leading: of(Vane::Leading),
            trailing: of(Vane::Trailing),
            downy_barbs: barbs.iter().filter(|barb| barb.is_loose).count(),
            barbules,
            barbules_per_mm: if self.downy.share < 1.0 { per_mm } else { downy_per_mm },
            coverage: self.coverage(seed, identity, progress)?,
        })
    }

    /// How many barbules stand on a barb.
    #[must_use]
    pub fn barbule_count(&self, barb: &Barb) -> usize {
        let on = |spacing_um: f64| (barb.length_mm / (1e-3 * spacing_um)) as usize;
        self.barbules_of(barb).iter().map(|shape| on(shape.spacing_um)).sum()
    }

    fn vane_measures(&self, shaft: &Shaft, barbs: &[Barb], vane: Vane) -> VaneMeasures {
        let all: Vec<&Barb> = barbs.iter().filter(|barb| barb.vane == vane).collect();
        let own: Vec<&Barb> = all.iter().copied().filter(|barb| !barb.is_tuft).collect();
        // From the geometry: the distance of a barb's end from the shaft's curve there, and the base's tangent.
        let width = |barb: &Barb| {
            let end = barb.points[barb.points.len() - 1];
            let nearest = |s: f64| end - shaft.at(s).point;
            let along = (barb.along_mm + 0.7 * barb.length_mm).min(shaft.vane_range()[1]);
            // Two steps along the shaft bring the station beside the end.
            let beside = (0..3).fold(along, |s, _| s + nearest(s).dot(shaft.at(s).tip));
            (nearest(beside).dot(shaft.at(beside).right)).abs()
        };
        let angle = |barb: &Barb| {
            let begin = barb.points[1] - barb.points[0];
            begin.normalize().dot(shaft.at(barb.along_mm).tip).clamp(-1.0, 1.0).acos()
        };
        let widths: Vec<f64> = own.iter().map(|barb| width(barb)).collect();
        let spacings: Vec<f64> = own
            .windows(2)
            .map(|pair| {
                (pair[1].along_mm - pair[0].along_mm) * 0.5 * (angle(pair[0]).sin() + angle(pair[1]).sin())
            })
            .collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let lengths: Vec<f64> = all.iter().map(|barb| barb.length_mm).collect();
        // Angles drift: the mean of some barbs is that of the place.
        let ends =
            |barbs: &[&Barb]| mean(&barbs.iter().map(|barb| angle(barb).to_degrees()).collect::<Vec<_>>());
        let few = own.len().min(5);
        VaneMeasures {
            barbs: own.len(),
            tuft: all.len() - own.len(),
            widest_mm: widths.iter().copied().fold(0.0, f64::max),
            mean_width_mm: mean_along(&own, &widths),
            spacing_um: 1e3 * mean(&spacings),
            base_angle_deg: ends(&own[..few]),
            tip_angle_deg: ends(&own[own.len() - few..]),
            mean_barb_mm: mean(&lengths),
            longest_barb_mm: lengths.iter().copied().fold(0.0, f64::max),
        }
    }

    /// How many fibres lie over a place of the closed vane in the mean, rami and barbules, by their sizes alone: a barbule is 0.86 of its
    /// greatest length in the mean over a barb.
    #[must_use]
    pub fn cover(&self) -> f64 {
        let row = |shape: &BarbuleShape| MEAN_LENGTH * shape.length_um * shape.width_um / shape.spacing_um;
        let ramus = ramus_taper(0.5) * self.barbs.width_um;
        (ramus + row(&self.distal) + row(&self.proximal)) / self.barbs.spacing_um
    }

    /// Share of the closed vane that a ray along its normal meets: rami and barbules, projected onto the vane beside the
    /// shaft, counted on a grid. Nothing where all is downy.
    ///
    /// # Errors
    /// As [`Feather::grow`], or a stop by `progress`.
    pub fn coverage(&self, seed: u64, identity: u64, progress: &dyn Progress) -> Result<Option<f64>> {
        if self.downy.share > PLACE {
            return Ok(None);
        }
        let shaft = Shaft::new(&self.shaft);
        let [first, last] = shaft.vane_range();
        let along_mm = first + PLACE * (last - first);
        let inside = 2.0 * shaft.radius(along_mm);
        let outside = Vane::BOTH
            .map(|vane| 0.8 * self.half_width(&shaft, vane, along_mm))
            .into_iter()
            .fold(inside + PATCH_MM, f64::min);
        if outside <= inside {
            return Ok(None);
        }
        let window = VaneDisc { along_mm, radius_mm: Some(1.5 * outside) };
        let grown = self.grow_watched(window, Level::Barbules, None, (seed, identity), progress)?;
        let station = shaft.at(along_mm);
        let to_vane = |p: Vec3| {
            let p = p.as_dvec3();
            [p.dot(station.right), p.dot(station.tip)]
        };
        let size = outside - inside;
        let mut sum = 0.0;
        for side in [-1.0, 1.0] {
            let mut grid = Grid::new([0.5 * side * (inside + outside), 0.0], size);
            grid.cover(&grown, to_vane);
            sum += 0.5 * grid.share();
        }
        Ok(Some(sum))
    }
}

/// Mean over the arc length of the shaft of values at barbs' bases (trapezoids).
fn mean_along(barbs: &[&Barb], values: &[f64]) -> f64 {
    let (mut area, mut length) = (0.0, 0.0);
    for (pair, ends) in barbs.windows(2).zip(values.windows(2)) {
        let step = pair[1].along_mm - pair[0].along_mm;
        area += 0.5 * step * (ends[0] + ends[1]);
        length += step;
    }
    if length > 0.0 { area / length } else { values.first().copied().unwrap_or_default() }
}

/// A square of the vane's plane in cells that are covered or not.
struct Grid {
    low: [f64; 2],
    cell: f64,
    covered: Vec<bool>,
}

impl Grid {
    fn new(middle: [f64; 2], size: f64) -> Self {
        let low = middle.map(|m| m - 0.5 * size);
        Self { low, cell: size / CELLS as f64, covered: vec![false; CELLS * CELLS] }
    }

    fn share(&self) -> f64 {
        self.covered.iter().filter(|covered| **covered).count() as f64 / self.covered.len() as f64
    }

    fn cover(&mut self, grown: &Grown, to_vane: impl Fn(Vec3) -> [f64; 2]) {
        for mesh in &grown.rami.meshes {
            for triangle in &mesh.triangles {
                self.triangle(triangle.map(|corner| to_vane(mesh.positions[corner as usize])));
            }
        }
        let barbules = grown.all_barbules();
        for ribbon in &barbules.ribbons {
            for pair in barbules.nodes_of(ribbon).windows(2) {
                let [a, b] = [&pair[0], &pair[1]]
                    .map(|node| [to_vane(node.point - node.across), to_vane(node.point + node.across)]);
                self.triangle([a[0], a[1], b[0]]);
                self.triangle([b[0], a[1], b[1]]);
            }
        }
    }

    /// Covers the cells whose middles lie in a triangle.
    fn triangle(&mut self, corners: [[f64; 2]; 3]) {
        let corners = corners.map(|corner| [0, 1].map(|k| (corner[k] - self.low[k]) / self.cell - 0.5));
        let range = |k: usize| {
            let values = corners.map(|corner| corner[k]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min).ceil().max(0.0);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max).floor().min(CELLS as f64 - 1.0);
            (low as usize, high)
        };
        let ((left, right), (bottom, top)) = (range(0), range(1));
        let edge = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        };
        let [a, b, c] = corners;
        for y in bottom.. {
            if y as f64 > top {
                break;
            }
            for x in left.. {
                if x as f64 > right {
                    break;
                }
                let p = [x as f64, y as f64];
                let sides = [edge(a, b, p), edge(b, c, p), edge(c, a, p)];
                if sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0) {
                    self.covered[y * CELLS + x] = true;
                }
            }
        }
    }
}
