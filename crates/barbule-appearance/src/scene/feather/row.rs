//! The barbs of one side in the plane of the unrolled vane: where they leave the shaft, how they bend, how long they are.
//!
//! In that plane x is the distance from the shaft's axis and y the arc length on it, mm. Barbs are laid out here, moved by
//! what befalls the vane in [`super::split`], and raised into space in [`super::barb`].

use glam::DVec2;

use super::outline::Vane;
use super::shaft::Shaft;
use super::{BarbShape, Feather, noise, smoothstep};
use crate::Result;
use crate::math::rng::{Stream, hash};
use crate::progress::Progress;
use crate::scene::go_on;

/// Steps of a barb's path.
pub(super) const PATH_STEPS: usize = 48;
/// Least sine of the insertion angle: barbs parallel to the shaft would never leave it.
pub(super) const LEAST_SINE: f64 = 0.15;
/// Shortest barb, mm.
const SHORTEST_MM: f64 = 0.05;
/// Most barbs of the tuft at the tip, on one side.
pub(super) const MOST_IN_TUFT: usize = 24;
/// Where barbs begin, over the shaft's half width.
pub(super) const BASE_SHARE: f64 = 0.75;
/// Length of the border of the downy part over its length: in it barbs of both kinds alternate.
pub(super) const BORDER: f64 = 0.4;

/// A barb in the plane of the vane.
#[derive(Debug, Clone)]
pub(super) struct FlatBarb {
    /// Identity.
    pub id: u64,
    /// Arc length of its base on the shaft, mm.
    pub along: f64,
    /// Place of its base in the vane: 0 at the first barb, 1 at the tip.
    pub t: f64,
    /// Angle to the shaft at its base, rad.
    pub angle: f64,
    /// Length of its path, mm.
    pub length: f64,
    /// Its path at equal steps.
    pub path: [DVec2; PATH_STEPS + 1],
    /// How loose it is: 0 in the closed vane, 1 well inside the downy part.
    pub looseness: f64,
    /// Whether it belongs to the tuft at the tip.
    pub is_tuft: bool,
    /// Whether nothing holds its distal and its proximal barbules.
    pub is_free: [bool; 2],
    /// How far it slides under its neighbours at its end, mm.
    pub under: f64,
    /// Up to where on it neighbours hold it, mm: everywhere where it has no end outside of an eye.
    pub hooked_mm: f64,
}

/// Everything that names and shapes the barbs of one side.
pub(super) struct Row<'a> {
    pub feather: &'a Feather,
    pub shaft: &'a Shaft,
    pub vane: Vane,
    /// Names all draws of this side.
    pub name: u64,
}

/// Where a barb leaves the shaft, before disorder.
struct Base {
    along: f64,
    angle: f64,
    is_tuft: bool,
}

impl BarbShape {
    /// How much a barb that leaves the shaft at an angle turns towards the tip: never so far that it would follow the shaft,
    /// nor that its neighbours, as far apart along the shaft as at their bases, would touch.
    pub(super) fn curl_at(&self, angle: f64) -> f64 {
        self.curl.min(0.6 * angle)
    }

    /// Distance between neighbours at their ends over that at their bases.
    pub(super) fn closing(&self, angle: f64) -> f64 {
        libm::sin(angle - self.curl_at(angle)) / libm::sin(angle)
    }
}

impl Row<'_> {
    /// All barbs from the vane's base to its tip.
    ///
    /// # Errors
    /// A stop by `progress`.
    pub(super) fn barbs(&self, progress: &dyn Progress) -> Result<Vec<FlatBarb>> {
        let barb = |(index, base): (usize, &Base)| {
            go_on(progress)?;
            Ok(self.barb(index, base))
        };
        self.bases().iter().enumerate().map(barb).collect()
    }

    /// Barbs stand at their perpendicular spacing, so at steps p/sin α of the shaft; a fan of them ends the vane.
    fn bases(&self) -> Vec<Base> {
        let barbs = &self.feather.barbs;
        let [first, tip] = self.shaft.vane_range();
        let last = tip - barbs.tuft * (tip - first);
        let step = |s: f64| {
            let t = self.shaft.vane(s);
            let angle = self.feather.insertion(self.vane, t);
            (angle, self.feather.spacing_mm(t) / libm::sin(angle).max(LEAST_SINE))
        };
        // Left and right do not stand opposite each other.
        let mut s = first + step(first).1 * Stream::new(self.name, &[0]).unit();
        let mut bases = Vec::new();
        while s < last {
            let (angle, before) = step(s);
            bases.push(Base { along: s, angle, is_tuft: false });
            // The midpoint rule: angles change along the step.
            s += step(s + 0.5 * before).1;
        }
        self.tuft(last, tip, &mut bases);
        bases
    }

    /// The tuft: a fan between the last barb and the shaft, as many as keep the spacing at the outline.
    fn tuft(&self, last: f64, tip: f64, bases: &mut Vec<Base>) {
        let barbs = &self.feather.barbs;
        if last >= tip {
            return;
        }
        let t = self.shaft.vane(last);
        let angle = self.feather.insertion(self.vane, t);
        let length = match self.reach(last, angle) {
            Some([length, _]) => length,
            None => self.length(last, &self.bend([angle, self.feather.turn_of(angle, t)], 0.0, 0.0, 1.0)),
        };
        let arc = length * angle / (1e-3 * barbs.spacing_um);
        let count = (libm::round(arc) as usize).min(MOST_IN_TUFT);
        for k in 1..=count {
            let share = k as f64 / (count + 1) as f64;
            bases.push(Base {
                along: last + 0.8 * share * (tip - last),
                angle: angle * (1.0 - share),
                is_tuft: true,
            });
        }
    }

    fn barb(&self, index: usize, base: &Base) -> FlatBarb {
        let (feather, disorder) = (self.feather, &self.feather.disorder);
        let id = hash(self.name, &[1, index as u64]);
        let mut stream = Stream::new(id, &[]);
        let spacing = feather.spacing_mm(self.shaft.vane(base.along).clamp(0.0, 1.0));
        let along = base.along + disorder.barb_spacing * spacing * stream.normal();
        let t = self.shaft.vane(along).clamp(0.0, 1.0);
        // Neighbours hold each other: angles and waves drift together, the less the closer they stand at their ends.
        let drift =
            |what: u64| noise::normal(hash(self.name, &[2, what]), index as f64 / disorder.barb_coherence);
        let calm = if base.is_tuft { 0.2 } else { feather.barbs.closing(base.angle).min(1.0) };
        let angle = (base.angle + calm * disorder.barb_angle * drift(0)).clamp(0.01, 1.55);
        let looseness = self.looseness(t, stream.unit());
        let (wave, phase) = (calm * disorder.barb_wave * drift(1), drift(2));
        let turn = [angle, feather.turn_of(angle, t)];
        let (whole, hooked_mm) = match (feather.downy.barb_length_mm, self.reach(along, angle)) {
            (length, _) if looseness > 0.0 && length > 0.0 => (length, f64::INFINITY),
            (_, Some([length, hooked])) => (length, if looseness > 0.0 { f64::INFINITY } else { hooked }),
            _ => (self.length(along, &self.bend(turn, wave, phase, 1.0)), f64::INFINITY),
        };
        let worn = disorder.wear * noise::fractal(hash(self.name, &[3]), 25.0 * t);
        let grown = (1.0 + disorder.barb_length * stream.normal()) * (1.0 - worn);
        let end = disorder.barb_end * spacing * stream.normal();
        let length = (whole * grown + end).max(SHORTEST_MM);
        // A longer barb goes on where a shorter one ends: it does not bend otherwise, which would lead it across.
        let bend = self.bend(turn, wave, phase, length / whole);
        let x = BASE_SHARE * self.shaft.radius(along);
        let path = bend.map(|unit| DVec2::new(x, along) + unit * whole);
        FlatBarb {
            id,
            along,
            t,
            angle,
            length,
            path,
            looseness,
            is_tuft: base.is_tuft,
            is_free: [looseness > 0.0 || hooked_mm == 0.0; 2],
            under: 0.0,
            hooked_mm,
        }
    }

    /// How loose a barb is at a place of the vane; `draw`, uniform, decides in the border.
    fn looseness(&self, t: f64, draw: f64) -> f64 {
        let share = self.feather.downy.share;
        let border = share * (1.0 + BORDER * (draw - 0.5));
        if share >= 1.0 {
            1.0
        } else if t < border {
            // Near the border they are calmer, but never so calm that hooks would hold them.
            0.25 + 0.75 * smoothstep((border - t) / (0.5 * share))
        } else {
            0.0
        }
    }

    /// Length of a barb of a feather with an eye, and up to where it is hooked, mm; nothing where there is no eye.
    fn reach(&self, along: f64, angle: f64) -> Option<[f64; 2]> {
        let start = BASE_SHARE * self.shaft.radius(along);
        self.feather.reach(self.shaft, [start, along], angle)
    }

    /// The path of a barb of length 1 from the origin, by its angle and its turn: it turns towards the tip evenly, and waves; `extent`:
    /// how much of it there is, and more than 1 of its continuation.
    fn bend(&self, [angle, curl]: [f64; 2], wave: f64, phase: f64, extent: f64) -> [DVec2; PATH_STEPS + 1] {
        let step = extent / PATH_STEPS as f64;
        let mut path = [DVec2::ZERO; PATH_STEPS + 1];
        for i in 0..PATH_STEPS {
            let u = (i as f64 + 0.5) * step;
            // The wave begins calm: the base stands as the insertion says.
            let turned = angle - curl * u + wave * u * libm::sin(phase + 5.0 * u);
            path[i + 1] = path[i] + DVec2::new(libm::sin(turned), libm::cos(turned)) * step;
        }
        path
    }

    /// By how much a path of length 1 is stretched for its end to lie on the outline: the first crossing, by bisection.
    fn length(&self, along: f64, bend: &[DVec2; PATH_STEPS + 1]) -> f64 {
        const PARTS: u32 = 96;
        let end = bend[PATH_STEPS];
        let start = BASE_SHARE * self.shaft.radius(along);
        let outside =
            |l: f64| start + l * end.x >= self.feather.half_width(self.shaft, self.vane, along + l * end.y);
        let barbs = &self.feather.barbs;
        let widest = barbs.leading_half_width_mm.max(barbs.trailing_half_width_mm);
        let [_, tip] = self.shaft.vane_range();
        // Past the tip and past the widest place nothing is inside.
        let longest = (widest / end.x.abs().max(1e-6)).min((tip - along).max(0.0) / end.y.max(1e-6) + widest);
        let mut high = longest;
        for i in 1..=PARTS {
            let l = longest * f64::from(i) / f64::from(PARTS);
            if outside(l) {
                high = l;
                break;
            }
        }
        let mut low = (high - longest / f64::from(PARTS)).max(0.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if outside(middle) { high = middle } else { low = middle }
        }
        high
    }
}
