//! Rows: feathers side by side whose roots lie along a curve, over each other like shingles. Tails and folded wings are made of them.
//!
//! Stations say where the roots are, which way the feathers lie and how large they are. They share the row evenly; between them all of that
//! goes along a cubic through their values (Catmull & Rom 1974), so that a row has no kinks. Each feather stands by its chord: the
//! straight line from where its shaft leaves the skin to its tip.

use glam::{DMat3, DVec3};

use super::coat::window;
use super::feather::{Feather, LeadingSide, Shaft};
use super::geometry::Place;
use crate::math::rng::{Stream, hash};
use crate::words;

/// Most feathers of a row, and most stations.
pub const MOST_FEATHERS: usize = 2000;
/// Most of both.
pub const MOST_STATIONS: usize = 100;
/// Names of random streams and variants.
const STAND: u64 = 0x726f_7773;
const VARIANT: u64 = 0x726f_7776;
/// Draws farther out than this many standard deviations are drawn in.
const FARTHEST: f64 = 2.5;

words! {
    /// Which end of a row lies on top.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Over {
        /// The first feather: each lies over the next one.
        #[default]
        "first": First,
        /// The last feather: each lies over the one before.
        "last": Last,
    }
}

/// What a row is like at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Where the shaft leaves the skin, mm.
    pub position_mm: DVec3,
    /// From there to the feather's tip; of any length.
    pub direction: DVec3,
    /// Out of the upper side of its vane; of any length, not along the direction.
    pub normal: DVec3,
    /// Factor to the feather's size.
    pub scale: f64,
    /// Factors to the widths of its leading and trailing vane, beyond that.
    pub widths: [f64; 2],
    /// Which of the row's kinds of feathers stands nearest to this station.
    pub kind: usize,
}

/// Feathers side by side.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatherRow {
    /// How many there are; twice as many with their mirror images.
    pub count: usize,
    /// From its first feather to its last; one at least.
    pub stations: Vec<Station>,
    /// Which end lies on top.
    pub over: Over,
    /// How far each lies under its neighbour, along its normal, mm.
    pub clearance_mm: f64,
    /// By how much each is rolled about its chord, so that its edge lies over the feather beneath and under the one above, rad. The
    /// topmost one lies flat, the others lower by what their raised edge rises.
    pub roll: f64,
    /// Whether the mirror image in the plane x = 0 stands beside it, half a clearance lower, so that feathers of both sides do not
    /// lie in each other.
    pub mirror: bool,
    /// Standard deviation of a feather's turn about its normal, rad, and of its size, as a share.
    pub turn_jitter: f64,
    /// See `turn_jitter`.
    pub size_jitter: f64,
    /// How many feathers of each kind are grown at most; each stands at many places.
    pub variants: usize,
}

/// One feather of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowStand {
    /// Where and how it stands at its place in the row.
    pub station: Station,
    /// Its place in the row, from 0; mirror images have the numbers of their images.
    pub index: usize,
    /// Its roll about its chord, rad; positive raises the edge that faces the row's end.
    pub roll: f64,
    /// Whether it is a mirror image.
    pub is_mirrored: bool,
    /// Which of the row's variants it is.
    pub variant: usize,
}

/// A feather that is grown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowVariant {
    /// Of which kind it is.
    pub kind: usize,
    /// The feather.
    pub feather: Feather,
}

/// A row whose feathers have their places.
#[derive(Debug, Clone, PartialEq)]
pub struct LaidRow {
    /// The feathers that are grown.
    pub variants: Vec<RowVariant>,
    /// All feathers, those of the row itself first.
    pub stands: Vec<RowStand>,
}

/// The seed from which one of a row's feathers grows.
#[must_use]
pub fn seed_of(variant: usize, seed: u64) -> u64 {
    hash(seed, &[VARIANT, variant as u64])
}

impl FeatherRow {
    /// Lays feathers of these kinds; the same for the same seed.
    #[must_use]
    pub fn lay(&self, feathers: &[Feather], seed: u64) -> LaidRow {
        let sides = if self.mirror { 2 } else { 1 };
        let mut laid = LaidRow { variants: Vec::new(), stands: Vec::with_capacity(sides * self.count) };
        for side in 0..sides {
            let stands: Vec<RowStand> =
                (0..self.count).map(|index| self.stand(index, side == 1, feathers, seed)).collect();
            for (kind, of_kind) in feathers.iter().enumerate() {
                let own: Vec<usize> = (0..self.count).filter(|&i| stands[i].station.kind == kind).collect();
                let groups = self.variants.min(own.len());
                let group = |rank: usize| rank * groups / own.len();
                for variant in 0..groups {
                    let members: Vec<usize> = (own.iter().enumerate())
                        .filter(|(rank, _)| group(*rank) == variant)
                        .map(|(_, &index)| index)
                        .collect();
                    let number = laid.variants.len();
                    let mean = |vane: usize| {
                        members.iter().map(|&i| stands[i].station.widths[vane]).sum::<f64>()
                            / members.len() as f64
                    };
                    let feather = shaped(of_kind, [mean(0), mean(1)], side == 1);
                    laid.variants.push(RowVariant { kind, feather });
                    laid.stands.extend(members.iter().map(|&i| RowStand { variant: number, ..stands[i] }));
                }
            }
        }
        laid.stands.sort_by_key(|stand| (stand.is_mirrored, stand.index));
        laid
    }

    /// One of its feathers; its variant is not known yet.
    fn stand(&self, index: usize, is_mirrored: bool, feathers: &[Feather], seed: u64) -> RowStand {
        let share = if self.count > 1 { index as f64 / (self.count - 1) as f64 } else { 0.0 };
        let mut station = self.at(share);
        let mut stream = Stream::new(seed, &[STAND, index as u64, u64::from(is_mirrored)]);
        let mut jitter = |spread: f64| spread * stream.normal().clamp(-FARTHEST, FARTHEST);
        let (sin, cos) = libm::sincos(jitter(self.turn_jitter));
        station.direction = station.direction * cos + station.normal.cross(station.direction) * sin;
        station.scale *= (1.0 + jitter(self.size_jitter)).max(0.2);
        let beneath = match self.over {
            Over::First => index,
            Over::Last => self.count - 1 - index,
        };
        let is_topmost = beneath == 0;
        let roll = if is_topmost { 0.0 } else { self.roll };
        // Beside the topmost, which lies flat, the raised edge of the others is as high as it would be without a roll.
        let sunk =
            libm::sin(roll) * station.scale * half_width_mm(feathers.get(station.kind), station.widths);
        let lower = self.clearance_mm * (beneath as f64 + if is_mirrored { 0.5 } else { 0.0 });
        station.position_mm -= station.normal * (lower + sunk);
        let longest_mm = feathers.iter().map(|feather| feather.shaft.length_mm).fold(0.0, f64::max);
        let raised = if self.over == Over::First { 1.0 } else { -1.0 };
        let roll = raised * roll * self.towards_end(share, longest_mm);
        RowStand { station, index, roll, is_mirrored, variant: 0 }
    }

    /// What the row is like at a share of it, 0 to 1, with unit vectors at right angles.
    #[must_use]
    pub fn at(&self, share: f64) -> Station {
        let last = self.stations.len() - 1;
        let along = share.clamp(0.0, 1.0) * last as f64;
        let from = (along as usize).min(last.saturating_sub(1));
        let rest = along - from as f64;
        // Beyond the ends the row goes straight on.
        let four = |value: &dyn Fn(&Station) -> DVec3| {
            let [a, b] = [from, (from + 1).min(last)].map(|i| value(&self.stations[i]));
            let before = if from > 0 { value(&self.stations[from - 1]) } else { 2.0 * a - b };
            let after = if from + 2 <= last { value(&self.stations[from + 2]) } else { 2.0 * b - a };
            catmull_rom([before, a, b, after], rest)
        };
        let direction = four(&|s| s.direction.normalize_or(DVec3::NEG_Y)).normalize_or(DVec3::NEG_Y);
        let normal = four(&|s| s.normal.normalize_or(DVec3::Z));
        let normal =
            (normal - direction * normal.dot(direction)).normalize_or(direction.any_orthonormal_vector());
        let sizes = four(&|s| DVec3::new(s.scale, s.widths[0], s.widths[1])).max(DVec3::splat(LEAST_SIZE));
        Station {
            position_mm: four(&|s| s.position_mm),
            direction,
            normal,
            scale: sizes.x,
            widths: [sizes.y, sizes.z],
            kind: self.stations[if rest < 0.5 { from } else { (from + 1).min(last) }].kind,
        }
    }

    /// 1 where the row's next feathers are to the right of a feather, seen from above with its tip upwards; −1 where they are to its left.
    /// Roots of a fan are close together, so that the middles of feathers decide.
    fn towards_end(&self, share: f64, longest_mm: f64) -> f64 {
        let step = 0.5 / self.stations.len() as f64;
        let [low, high] = [share - step, share + step].map(|at| at.clamp(0.0, 1.0));
        let middle = |at: f64| {
            let station = self.at(at);
            station.position_mm + station.direction * (0.5 * station.scale * longest_mm)
        };
        let Station { direction, normal, .. } = self.at(share);
        if (middle(high) - middle(low)).dot(direction.cross(normal)) < 0.0 { -1.0 } else { 1.0 }
    }
}

/// The wider vane of a feather whose vanes are so much wider than said.
fn half_width_mm(feather: Option<&Feather>, [leading, trailing]: [f64; 2]) -> f64 {
    let of = |Feather { barbs, .. }: &Feather| {
        f64::max(barbs.leading_half_width_mm * leading, barbs.trailing_half_width_mm * trailing)
    };
    feather.map_or(0.0, of)
}

/// Sizes between stations fall no lower than this share.
const LEAST_SIZE: f64 = 0.05;

/// The cubic from the second of four values to the third whose slopes there are those between its neighbours.
fn catmull_rom([a, b, c, d]: [DVec3; 4], t: f64) -> DVec3 {
    let (slope_b, slope_c) = ((c - a) * 0.5, (d - b) * 0.5);
    let (tt, ttt) = (t * t, t * t * t);
    b * (2.0 * ttt - 3.0 * tt + 1.0)
        + slope_b * (ttt - 2.0 * tt + t)
        + c * (3.0 * tt - 2.0 * ttt)
        + slope_c * (ttt - tt)
}

/// A feather with vanes so much wider; of the other wing, if it stands in the mirror image.
fn shaped(feather: &Feather, [leading, trailing]: [f64; 2], is_mirrored: bool) -> Feather {
    let mut own = *feather;
    own.barbs.leading_half_width_mm *= leading;
    own.barbs.trailing_half_width_mm *= trailing;
    if is_mirrored {
        own.leading = match own.leading {
            LeadingSide::Left => LeadingSide::Right,
            LeadingSide::Right => LeadingSide::Left,
        };
        let shaft = &mut own.shaft;
        (shaft.bend, shaft.bend_quadratic, shaft.torsion) =
            (-shaft.bend, -shaft.bend_quadratic, -shaft.torsion);
    }
    own
}

impl RowStand {
    /// Where its variant stands, whose window begins at [`window`]: its tip lies along the station's direction.
    #[must_use]
    pub fn place(&self, feather: &Feather, id: u64) -> Place {
        let shaft = Shaft::new(&feather.shaft);
        let ends = [window(feather).along_mm, feather.shaft.length_mm];
        let [root, tip] = ends.map(|along| shaft.at(along).point);
        let chord = (tip - root).normalize_or(DVec3::Y);
        let Station { position_mm, direction, normal, scale, .. } = self.station;
        let there = frame(direction, normal, self.roll);
        if !self.is_mirrored {
            return Place {
                scale,
                turn: there * frame(chord, DVec3::Z, 0.0).transpose(),
                shift: position_mm,
                id,
            };
        }
        // The variant is a mirror image itself; both mirrors together are a turn.
        let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        let turn = mirror * there * frame(mirror * chord, DVec3::Z, 0.0).transpose() * mirror;
        Place { scale, turn, shift: mirror * position_mm, id }
    }
}

/// Right, along, and out of the vane, which is rolled about `along`: positive raises its right edge.
fn frame(along: DVec3, normal: DVec3, roll: f64) -> DMat3 {
    let normal = (normal - along * normal.dot(along)).normalize_or(along.any_orthonormal_vector());
    let right = along.cross(normal);
    let (sin, cos) = libm::sincos(roll);
    DMat3::from_cols(right * cos + normal * sin, along, normal * cos - right * sin)
}

#[cfg(test)]
mod tests;
