//! Which barbule of a row a ray meets.
//!
//! In the plane across the barbules a row is a blind: slats side by side, each turned about its own axis. A ray that meets
//! the barb's envelope is followed through the slats near it, so nearer ones hide others, gaps open and close with the
//! direction, and the slats shade each other.

use super::row::Row;
use crate::math::rng::{hash, split_mix};

/// Values of a barbule's path.
const PATH: usize = 33;
/// Most slats that are looked at for one ray.
const MOST_SLATS: usize = 12;

/// A row ready for rays.
#[derive(Debug, Clone)]
pub(super) struct Lookup {
    pub row: Row,
    path: [[f64; 3]; PATH],
    /// Height over width of fibres; slats have none.
    round: Option<f64>,
}

/// One slat: where its middle line lies from where the ray meets the envelope, ahead and up, mm, and its turn.
#[derive(Debug, Clone, Copy, Default)]
struct Slat {
    at: [f64; 2],
    sin: f64,
    cos: f64,
}

/// The slats near a ray. Two coordinates: ahead, towards the barb's tip, and up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blind {
    slats: [Slat; MOST_SLATS],
    count: usize,
    half_width: f64,
    round: Option<f64>,
    /// The slat that was met, and where.
    met: usize,
    point: [f64; 2],
}

/// A barbule that was met, and what is about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met {
    pub barbule: Barbule,
    pub blind: Blind,
}

/// A barbule where it was met.
#[derive(Debug, Clone, Copy)]
pub(super) struct Barbule {
    /// Its name.
    pub id: u64,
    /// Its number along the row.
    pub index: i64,
    /// Share of its length.
    pub t: f64,
    /// Its length, mm.
    pub length: f64,
    /// Its angle to the barb, its lift and its turn about its own axis, rad.
    pub angle: f64,
    pub lift: f64,
    pub tilt: f64,
    /// −1 … 1 over its width, towards the barb's tip.
    pub across: f64,
    pub half_width: f64,
}

/// Where a ray meets a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Distance from the row's root at the ramus, to the side, mm.
    pub side: f64,
    /// Arc length on the barb, mm, and the barb's own length.
    pub along: f64,
    pub barb: f64,
    /// How far the viewer's direction leans to the side and along the barb over how far up.
    pub lean: [f64; 2],
    /// Name of the row.
    pub name: u64,
}

impl Lookup {
    /// `round`: height over width of barbules that are fibres; without it they are flat.
    pub(super) fn new(row: Row, round: Option<f64>) -> Self {
        Self { row, path: row.path(), round }
    }

    /// Where a barbule is this far to the side, over its length: the share of its length, and how far it has come along the barb and
    /// up. Beyond its reach it is its end.
    #[inline]
    fn at_side(&self, side: f64) -> [f64; 3] {
        let (mut low, mut high) = (0, PATH - 1);
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            if self.path[middle][0] > side { high = middle } else { low = middle }
        }
        let ([a, along, up], [b, next_along, next_up]) = (self.path[low], self.path[high]);
        let rest = ((side - a) / (b - a)).clamp(0.0, 1.0);
        let mix = |from: f64, to: f64| from + (to - from) * rest;
        [(low as f64 + rest) / (PATH - 1) as f64, mix(along, next_along), mix(up, next_up)]
    }

    /// The first barbule on the way to a viewer. `towards` maps the mean direction of a barbule there, by its angle and lift, to the
    /// viewer's direction ahead and up in the plane across it.
    #[inline(never)]
    pub(super) fn meet(&self, place: Place, towards: impl FnOnce(f64, f64) -> [f64; 2]) -> Option<Met> {
        let row = &self.row;
        // Barbules are as long as where they are rooted says, from where they come here; and rise from the envelope, so the ray
        // meets them nearer to the viewer.
        let mut usual = row.length_at(place.along / place.barb - 0.5 * row.length / place.barb);
        let (mut side, mut along) = (place.side.max(0.0), place.along);
        let (mut t, mut advance) = (0.0, 0.0);
        for _ in 0..ROUNDS {
            let up;
            [t, advance, up] = self.at_side(side / usual);
            side = (place.side + place.lean[0] * up * usual).max(0.0);
            along = place.along + place.lean[1] * up * usual;
            usual = row.length_at((along - usual * advance) / place.barb);
        }
        let longest = usual * (1.0 + MOST_TENTS * row.disorder.length).min(1.5);
        if side > longest * self.path[PATH - 1][0] {
            return None;
        }
        let (angle, lift) = (row.angle_at(t), row.lift_at(t));
        let [ahead, up] = towards(angle, lift);
        // Barbules lie this far apart in the plane across them.
        let sin = libm::sin(angle);
        let half_width = row.half_width_at(t);
        let place_in_row = (along - usual * advance) / row.spacing - 0.5;
        let base_tilt = row.tilt_at(t);
        // Slats of this plane that may cover the ray: its own width, and what it leans over the slats' height.
        let disorder = &row.disorder;
        let raised = 2.0 * disorder.lift * t * usual;
        let height = half_width * libm::sin(base_tilt.abs() + 2.0 * disorder.turn) + raised;
        let lean = height * (ahead / up.abs().max(LEAST_UP)).abs() + 2.0 * disorder.angle * t * usual;
        // And beside them those whose shadows fall there.
        let shading = raised + row.spacing * sin;
        let reach =
            (half_width + lean + shading) / (row.spacing * sin.max(LEAST_UP)) + 3.0 * disorder.spacing;
        let first =
            (place_in_row - reach).ceil().max((place_in_row - 0.5 * MOST_SLATS as f64).ceil()).max(0.0)
                as i64;
        let last = (place_in_row + reach).floor().min((place.barb / row.spacing).floor() - 1.0) as i64;
        let mut blind = Blind {
            slats: [Slat::default(); MOST_SLATS],
            count: 0,
            half_width,
            round: self.round,
            met: 0,
            point: [0.0; 2],
        };
        let mut best: Option<(f64, Barbule)> = None;
        for index in (first..=last).take(MOST_SLATS) {
            let id = hash(place.name, &[index as u64]);
            let [shift, longer] = tents(id);
            // Each reaches as far as its own length lets it.
            let length = usual * (1.0 + disorder.length * longer).clamp(0.5, 1.5);
            if side > length * self.path[PATH - 1][0] {
                continue;
            }
            let [turn, swing] = tents(split_mix(id));
            let [raise, bow] = tents(split_mix(!id));
            let tilt = base_tilt + disorder.turn * turn;
            let lag = (index as f64 + disorder.spacing * shift - place_in_row) * row.spacing * sin;
            // Turned and raised about its root, it lies off the others by so much here.
            let swung = -disorder.angle * swing * t * usual;
            let raised = disorder.lift * (raise * t - 0.5 * bow * t * (1.0 - t)) * usual;
            let slat = Slat { at: [lag + swung, raised], sin: libm::sin(tilt), cos: libm::cos(tilt) };
            blind.slats[blind.count] = slat;
            if let Some((depth, across)) = slat.met([0.0; 2], [ahead, up], half_width, self.round)
                && best.is_none_or(|(nearest, ..)| depth > nearest)
            {
                blind.met = blind.count;
                blind.point = [depth * ahead, depth * up];
                let angle = angle + disorder.angle * swing;
                let lift = lift + disorder.lift * (raise + row.bow_at(t) * bow);
                best = Some((depth, Barbule { id, index, t, length, angle, lift, tilt, across, half_width }));
            }
            blind.count += 1;
        }
        let (_, barbule) = best?;
        Some(Met { barbule, blind })
    }
}

/// How often a barbule's length and height are looked up where it was found.
const ROUNDS: usize = 4;

/// The largest of what [`tents`] give.
const MOST_TENTS: f64 = 2.45;

/// Least sine by which a ray leans out of the slats' plane.
const LEAST_UP: f64 = 0.05;

/// What is nearer than this shades nothing, mm: a place would shade itself.
const LEAST_DISTANCE: f64 = 1e-6;

impl Slat {
    /// Where a line meets it, see [`Self::crossed`] and [`Self::passed`].
    #[inline]
    fn met(&self, from: [f64; 2], to: [f64; 2], half_width: f64, round: Option<f64>) -> Option<(f64, f64)> {
        match round {
            None => self.crossed(from, to, half_width),
            Some(height) => self.passed(from, to, half_width, height),
        }
    }

    /// How far along a line it passes a fibre's axis, and on which side: −1 … 1 over the half of its silhouette.
    #[inline]
    fn passed(
        &self,
        from: [f64; 2],
        [ahead, up]: [f64; 2],
        half_width: f64,
        height: f64,
    ) -> Option<(f64, f64)> {
        let length = (ahead * ahead + up * up).sqrt().max(f64::MIN_POSITIVE);
        let (dx, dz) = (ahead / length, up / length);
        let (x, z) = (from[0] - self.at[0], from[1] - self.at[1]);
        // The ellipse's extent at right angles to the line, in its own axes.
        let (along, out) = (dx * self.cos - dz * self.sin, dx * self.sin + dz * self.cos);
        let silhouette = half_width * (out * out + height * height * along * along).sqrt();
        let offset = (x * dz - z * dx) / silhouette;
        (offset.abs() <= 1.0).then_some((-(x * dx + z * dz) / length, offset))
    }

    /// Where the line from `from` along `[ahead, up]` crosses the slat: how far along the line, and −1 … 1 over its width,
    /// positive ahead.
    #[inline]
    fn crossed(&self, from: [f64; 2], [ahead, up]: [f64; 2], half_width: f64) -> Option<(f64, f64)> {
        // Its upper normal leans ahead by the turn: (sin, cos); it lies along (cos, −sin).
        let steep = ahead * self.sin + up * self.cos;
        if steep.abs() < 1e-9 {
            return None;
        }
        let distance = ((self.at[0] - from[0]) * self.sin + (self.at[1] - from[1]) * self.cos) / steep;
        let (x, z) = (from[0] + distance * ahead - self.at[0], from[1] + distance * up - self.at[1]);
        let across = (x * self.cos - z * self.sin) / half_width;
        (across.abs() <= 1.0).then_some((distance, across))
    }
}

impl Blind {
    /// Whether another slat stands between the met place and a direction ahead and up.
    #[inline]
    pub(super) fn is_shaded(&self, direction: [f64; 2]) -> bool {
        self.slats[..self.count].iter().enumerate().any(|(k, slat)| {
            k != self.met
                && slat
                    .met(self.point, direction, self.half_width, self.round)
                    .is_some_and(|(distance, _)| distance > LEAST_DISTANCE)
        })
    }
}

/// Two independent numbers of mean 0 and deviation 1 that a name stands for, each the sum of two uniform ones.
#[inline]
pub(super) fn tents(name: u64) -> [f64; 2] {
    let bits = split_mix(name ^ 0x1f83_d9ab_fb41_bd6b);
    let part = |k: u32| (bits >> (16 * k) & 0xffff) as f64;
    // Two uniform numbers of 2¹⁶ values have a mean of 2¹⁶ − 1 and a variance of (2³² − 1)/6.
    let scale = (6.0_f64 / 4_294_967_295.0).sqrt();
    [(part(0) + part(1) - 65_535.0) * scale, (part(2) + part(3) - 65_535.0) * scale]
}
