//! How a cell is taken apart: kinds of rods, layers, and the sizes of the expansions.

use super::Wave;
use super::layer::Place;
use super::rod::RodTable;
use super::stack::Level;
use crate::solve::crystal::{Cell, CellRod, Shell};
use crate::{Error, Result};

/// Rods that overlap in depth by more than this part of the smaller radius belong to one layer: plane waves between
/// them would grow before they fall. Touching rods of hexagonal rows overlap by 0.27.
const INTERLEAVED: f64 = 0.3;

/// Rods whose depths differ by less than this part of the period belong to one layer: plane waves fall too slowly.
const SHALLOW: f64 = 0.25;

/// Unknowns of rods that act on each other as one cluster; a wave then takes 20 s and 1 GB.
const MOST_UNKNOWNS: usize = 3000;

/// Most multipoles and orders.
const MOST_MULTIPOLES: usize = 60;
const MOST_ORDERS: f64 = 44.0;

/// Rods that act as one cluster.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    /// Its shape is one of [`Plan::shapes`].
    pub(super) level: Level,
    depth: f64,
}

/// A cell taken apart.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub(super) period: f64,
    pub(super) kinds: Vec<Vec<Shell>>,
    /// Layers that differ in more than a shift.
    pub(super) shapes: Vec<Vec<Place>>,
    pub(super) layers: Vec<Layer>,
    /// From the surface to the first layer's upper plane, µm.
    pub(super) first_gap: f64,
    /// Whether lattice sums between different rods are needed.
    pub(super) displaced: bool,
    /// Per kind: the least distance from its axis to an image within a neighbour, µm.
    clearance: Vec<f64>,
    /// The least height between images in neighbouring layers, or in the first layer and its mirror image, µm.
    least_height: f64,
}

/// Orders of the expansions.
#[derive(Debug, Clone)]
pub(super) struct Sizes {
    /// M by kind of rod.
    pub(super) multipoles: Vec<usize>,
    /// Plane waves between layers reach to |α_m| ≤ this, µm⁻¹.
    pub(super) alpha: f64,
}

impl Sizes {
    /// First and last order.
    pub(super) fn orders(&self, alpha0: f64, period: f64) -> (i32, i32) {
        let unit = std::f64::consts::TAU / period;
        let first = ((-self.alpha - alpha0) / unit).ceil() as i32;
        let last = ((self.alpha - alpha0) / unit).floor() as i32;
        (first.min(0), last.max(0))
    }

    /// Larger sizes where estimates exceed the tolerance; false at the largest.
    pub(super) fn grow(&mut self, kinds: &[f64], orders: f64, tolerance: f64, period: f64) -> bool {
        let mut grown = false;
        for (m, error) in self.multipoles.iter_mut().zip(kinds) {
            if *error > tolerance && *m < MOST_MULTIPOLES {
                *m = (*m + 4).min(MOST_MULTIPOLES);
                grown = true;
            }
        }
        let unit = std::f64::consts::TAU / period;
        if orders > tolerance && self.alpha < MOST_ORDERS * unit {
            self.alpha += 2.0 * unit;
            grown = true;
        }
        // NaN is no estimate
        grown && kinds.iter().all(|error| error.is_finite()) && orders.is_finite()
    }
}

/// How far from its axis towards another rod the images of that rod lie at most in a rod: r²/(d − r′), µm.
fn image(distance: f64, rod: &CellRod, other: &CellRod) -> f64 {
    let nearest = (distance - other.radius_um()).max(rod.radius_um());
    rod.radius_um().powi(2) / nearest
}

/// The height between images in two rods of different layers, µm; touching rods keep 0.42 of the height, as the
/// images near the point of contact are weak.
fn image_height(cell: &Cell, upper: &CellRod, lower: &CellRod) -> f64 {
    let height = lower.depth_um - upper.depth_um;
    let distance = cell.distance_um(upper, lower);
    let taken = (image(distance, upper, lower) + image(distance, lower, upper)) / distance;
    height * (1.0 - taken).max(0.42)
}

/// As [`image_height`], between a rod and its mirror image above the surface.
fn image_depth(rod: &CellRod) -> f64 {
    let height = 2.0 * rod.depth_um;
    height * (1.0 - 2.0 * image(height, rod, rod) / height).max(0.42)
}

impl Plan {
    /// Takes a cell apart.
    pub(super) fn new(cell: &Cell) -> Self {
        let mut kinds: Vec<Vec<Shell>> = Vec::new();
        let mut kind_of = Vec::new();
        for rod in &cell.rods {
            let same = |kind: &Vec<Shell>| {
                let equal = |(a, b): (&Shell, &Shell)| a.diameter_um == b.diameter_um && a.eps == b.eps;
                kind.len() == rod.shells.len() && kind.iter().zip(&rod.shells).all(equal)
            };
            let kind = kinds.iter().position(same).unwrap_or(kinds.len());
            if kind == kinds.len() {
                kinds.push(rod.shells.clone());
            }
            kind_of.push(kind);
        }
        let mut clearance = vec![f64::INFINITY; kinds.len()];
        for (i, rod) in cell.rods.iter().enumerate() {
            let free_of = |distance: f64, other: &CellRod| distance - image(distance, other, rod);
            let mut free = free_of(cell.period_um, rod).min(free_of(2.0 * rod.depth_um, rod));
            for (_, other) in cell.rods.iter().enumerate().filter(|(k, _)| *k != i) {
                free = free.min(free_of(cell.distance_um(rod, other), other));
            }
            clearance[kind_of[i]] = clearance[kind_of[i]].min(free);
        }
        let mut plan = Self {
            period: cell.period_um,
            kinds,
            shapes: Vec::new(),
            layers: Vec::new(),
            first_gap: 0.0,
            displaced: false,
            clearance,
            least_height: f64::INFINITY,
        };
        plan.split(cell, &kind_of);
        plan
    }

    /// Makes the layers.
    fn split(&mut self, cell: &Cell, kind_of: &[usize]) {
        let mut sorted: Vec<usize> = (0..cell.rods.len()).collect();
        sorted.sort_by(|&a, &b| {
            let (a, b) = (&cell.rods[a], &cell.rods[b]);
            a.depth_um.total_cmp(&b.depth_um).then(a.x_um.total_cmp(&b.x_um))
        });
        let apart = |a: usize, b: usize| {
            let (a, b) = (&cell.rods[a], &cell.rods[b]);
            let (r, s) = (a.radius_um(), b.radius_um());
            b.depth_um - a.depth_um >= (r + s - INTERLEAVED * r.min(s)).max(SHALLOW * cell.period_um)
        };
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (i, &rod) in sorted.iter().enumerate() {
            let separate = sorted[..i].iter().all(|&a| sorted[i..].iter().all(|&b| apart(a, b)));
            match groups.last_mut() {
                Some(group) if !separate => group.push(rod),
                _ => groups.push(vec![rod]),
            }
        }
        for group in &groups {
            self.displaced |= group.len() > 1;
            self.add_layer(cell, group, kind_of);
        }
        self.place_planes(cell, &groups);
    }

    fn add_layer(&mut self, cell: &Cell, group: &[usize], kind_of: &[usize]) {
        let origin = &cell.rods[group[0]];
        let last = &cell.rods[group[group.len() - 1]];
        let flat = last.depth_um - origin.depth_um < 1e-12;
        let depth = if flat { origin.depth_um } else { 0.5 * (origin.depth_um + last.depth_um) };
        let places: Vec<Place> = group
            .iter()
            .map(|&i| {
                let rod = &cell.rods[i];
                let dx = rod.x_um - origin.x_um;
                let x = dx - (dx / cell.period_um).floor() * cell.period_um;
                Place { kind: kind_of[i], x, z: if flat { 0.0 } else { depth - rod.depth_um } }
            })
            .collect();
        let same = |shape: &Vec<Place>| {
            let near = |(a, b): (&Place, &Place)| {
                a.kind == b.kind && (a.x - b.x).abs().max((a.z - b.z).abs()) < 1e-13
            };
            shape.len() == places.len() && shape.iter().zip(&places).all(near)
        };
        let shape = self.shapes.iter().position(same).unwrap_or(self.shapes.len());
        if shape == self.shapes.len() {
            self.shapes.push(places);
        }
        let level = Level { shape, x: origin.x_um, above: 0.0, below: 0.0 };
        self.layers.push(Layer { level, depth });
    }

    /// Puts the planes of reference midway between the facing axes of layers, and between surface and first layer.
    fn place_planes(&mut self, cell: &Cell, groups: &[Vec<usize>]) {
        let top = |group: &Vec<usize>| cell.rods[group[0]].depth_um;
        let bottom = |group: &Vec<usize>| cell.rods[group[group.len() - 1]].depth_um;
        for (i, group) in groups.iter().enumerate() {
            let upper = if i == 0 { 0.5 * top(group) } else { 0.5 * (bottom(&groups[i - 1]) + top(group)) };
            let edge =
                group.iter().map(|&k| cell.rods[k].depth_um + cell.rods[k].radius_um()).fold(0.0, f64::max);
            let lower = groups.get(i + 1).map_or(edge, |next| 0.5 * (bottom(group) + top(next)));
            let layer = &mut self.layers[i];
            layer.level.above = layer.depth - upper;
            layer.level.below = lower - layer.depth;
            if i == 0 {
                self.first_gap = upper;
                self.least_height =
                    group.iter().map(|&k| image_depth(&cell.rods[k])).fold(f64::INFINITY, f64::min);
            } else {
                for (&a, &b) in groups[i - 1].iter().flat_map(|a| group.iter().map(move |b| (a, b))) {
                    self.least_height =
                        self.least_height.min(image_height(cell, &cell.rods[a], &cell.rods[b]));
                }
            }
        }
    }

    /// Sizes from the geometry, such that few directions need larger ones.
    pub(super) fn sizes(&self, wave: &Wave, tolerance: f64) -> Sizes {
        let digits = -tolerance.max(1e-14).ln();
        let unit = std::f64::consts::TAU / self.period;
        let multipoles = self.kinds.iter().zip(&self.clearance).map(|(shells, clearance)| {
            let radius = shells[0].diameter_um * 0.5;
            let contrast = ((shells[0].eps - wave.eps) / (shells[0].eps + wave.eps)).norm().clamp(1e-6, 0.9);
            // images of the neighbours: (r/clearance)^{2M}, and for touching rods, whose images pile up at the point of
            // contact, exp(−√(8M|ln τ|)); both with what was measured as their factor
            let apart = digits / (2.0 * (clearance / radius).ln().max(1e-3)) - 1.0;
            let touching = 0.13 * digits * digits / -contrast.ln();
            (apart.min(touching)).ceil().clamp(4.0, 40.0) as usize
        });
        let alpha =
            wave.kappa.norm().max(wave.kappa0) + 0.78 * digits / self.least_height.min(4.0 * self.period);
        Sizes { multipoles: multipoles.collect(), alpha: alpha.min(MOST_ORDERS * unit) }
    }

    /// T-matrices of every kind.
    ///
    /// # Errors
    /// Cylinder functions leave the range of numbers, or rods that act on each other have too many multipoles together.
    pub(super) fn tables(&self, wave: &Wave, sizes: &Sizes) -> Result<Vec<RodTable>> {
        let unknowns = |places: &Vec<Place>| {
            places.iter().map(|p| 2 * (2 * sizes.multipoles[p.kind] + 1)).sum::<usize>()
        };
        let most = self.shapes.iter().map(|places| (unknowns(places), places.len())).max();
        if let Some((unknowns, rods)) = most.filter(|(unknowns, _)| *unknowns > MOST_UNKNOWNS) {
            return Err(Error::input(format!(
                "{rods} rods of a period lie at about the same depth and ask for {unknowns} unknowns together, over \
                 {MOST_UNKNOWNS}; give fewer rods in a period, or use the Fourier modal solver"
            )));
        }
        self.kinds.iter().zip(&sizes.multipoles).map(|(shells, &m)| RodTable::new(wave, shells, m)).collect()
    }
}
