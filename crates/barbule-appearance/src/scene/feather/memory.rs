//! The memory that a feather takes, from its sizes alone, before anything grows.
//!
//! Counts are integrals over the vane, upper ones where disorder decides; bytes are what allocators hold while the feather grows and the
//! hierarchy over it is built, at most at once. Both are held against
//! what grows and what runs take by tests of the library and of the program.

use super::outline::Vane;
use super::row::{BORDER, LEAST_SINE, MOST_IN_TUFT};
use super::shaft::Shaft;
use super::{Feather, Level, VaneDisc, stretch, swatch};
use crate::scene::memory::{IN_PIECES, PER_PLACE, REPEATED, Rami, per_segment};

/// Bytes of a shaft with its hierarchy.
const PER_SHAFT: f64 = 3.5e6;
/// Bytes of a barb in the vane's plane; of one in space; of its ramus as a mesh and as fibres; of the latter alone.
const PER_FLAT_BARB: f64 = 900.0;
const PER_BARB: f64 = 2000.0;
const PER_RAMUS: f64 = 20_000.0;
const PER_FIBRE: f64 = 2200.0;
/// Bytes of a barbule's nodes, and of those of a downy one, which becomes a curve.
const PER_BARBULE: f64 = 400.0;
const PER_DOWNY_BARBULE: f64 = 600.0;
/// Bytes of a barb's strip of a sheet with its hierarchy, and of an envelope.
const PER_STRIP: f64 = 19_000.0;
const PER_ENVELOPE: f64 = 22_000.0;
/// Triangles of a ramus, its segments as a fibre, and segments of a barbule.
const RAMUS_TRIANGLES: f64 = 384.0;
const RAMUS_SEGMENTS: f64 = 24.0;
const BARBULE_SEGMENTS: f64 = 6.0;
/// Bytes that a triangle takes in a hierarchy that is built.
const PER_TRIANGLE: f64 = 300.0;
/// How much closer loose barbs stand, seen from above, than those of the vane: they are all about the shaft.
const CLOSER: f64 = 1.6;
/// How much more of a vane a window may hold than of one of straight shaft and barbs at right angles.
const LEANING: f64 = 1.1;
/// Parts of a vane on which it is summed.
const PARTS: u32 = 256;

/// What grows of a feather.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Census {
    /// Barbs of the vane with more of them.
    pub laid_out: f64,
    /// Barbs that are raised into space, since they may reach into the window.
    pub raised: f64,
    /// Barbs of the closed vane in the window, and of the downy part.
    pub barbs: [f64; 2],
    /// Lengths of both together in the window, mm.
    pub barbs_mm: [f64; 2],
    /// Barbules of both in the window.
    pub barbules: [f64; 2],
}

impl Census {
    /// Memory of the barbs while they are laid out and raised, bytes.
    #[must_use]
    pub fn laid_out_bytes(&self) -> f64 {
        self.laid_out * PER_FLAT_BARB + self.raised * PER_BARB
    }
}

impl Feather {
    /// What grows of it within a window.
    #[must_use]
    pub fn census(&self, window: VaneDisc) -> Census {
        let (shape, downy) = (&self.barbs, &self.downy);
        let (spacing_mm, shaft) = (1e-3 * shape.spacing_um, Shaft::new(&self.shaft));
        let first = self.shaft.length_mm * self.shaft.calamus;
        let vane_mm = self.shaft.length_mm - first;
        // Barbs of both kinds alternate at the border.
        let loose_to = if downy.share >= 1.0 { 1.0 } else { downy.share * (1.0 + 0.5 * BORDER) };
        let own_mm = if loose_to > 0.0 { downy.barb_length_mm } else { 0.0 };
        let (mut laid_out, mut raised, mut with_eye_mm) = ([0.0_f64; 2], [0.0; 2], 0.0);
        for (vane, laid_out) in Vane::BOTH.into_iter().zip(&mut laid_out) {
            let step = vane_mm / f64::from(PARTS);
            for part in 0..PARTS {
                let t = (f64::from(part) + 0.5) / f64::from(PARTS);
                let angle = self.insertion(vane, t);
                let sine = libm::sin(angle).max(LEAST_SINE);
                let barbs = step * sine / self.spacing_mm(t);
                *laid_out += barbs;
                let along = first + t * vane_mm;
                let of_eye = self.reach(&shaft, [0.0, along], angle).map(|[length, _]| 1.1 * length);
                let reach = of_eye.unwrap_or(1.3 * shape.half_width_mm(vane) / sine).max(own_mm);
                let reaches = |radius: f64| {
                    along + step > window.along_mm - reach - radius
                        && along - step < window.along_mm + 1.2 * radius
                };
                if window.radius_mm.is_none_or(reaches) {
                    raised[usize::from(t < loose_to)] += barbs;
                    if t >= loose_to {
                        with_eye_mm += barbs * of_eye.unwrap_or_default();
                    }
                }
            }
            *laid_out += MOST_IN_TUFT as f64;
        }
        let disc = window.radius_mm.map_or(f64::INFINITY, |radius| std::f64::consts::PI * radius * radius);
        // So many barbs cross a disc on either side of the shaft.
        let crossing = window.radius_mm.map_or(f64::INFINITY, |radius| 4.0 * (radius / spacing_mm + 1.0));
        // Barbs that lean, and a shaft that is bent, bring some more into it.
        let closed = if self.eye.is_there() {
            with_eye_mm + 2.0 * MOST_IN_TUFT as f64 * (self.eye.half_length_mm + self.eye.fringe_mm)
        } else {
            (LEANING * self.vane_area_in(window)).min(self.vane_area().min(disc)) / spacing_mm
        };
        let closed_mm = if downy.share < 1.0 { closed } else { 0.0 };
        let loose_mm = match own_mm {
            own if own > 0.0 => (1.15 * own * raised[1]).min(2.5 * disc / spacing_mm),
            _ => self.vane_area().min(CLOSER * disc) / spacing_mm * loose_to.min(1.0),
        };
        let tuft = 2.0 * MOST_IN_TUFT as f64;
        let rows = [1e3 / self.distal.spacing_um + 1e3 / self.proximal.spacing_um, 2e3 / downy.spacing_um];
        Census {
            laid_out: laid_out[0].max(laid_out[1]),
            raised: raised[0] + raised[1] + tuft,
            barbs: [(raised[0] + tuft).min(crossing), raised[1]],
            barbs_mm: [closed_mm, loose_mm],
            barbules: [closed_mm * rows[0], loose_mm * rows[1]],
        }
    }

    /// Memory that a window of it takes while it grows and its hierarchy is built, bytes, at most and about; `layers`: the sorts of places
    /// that its vanes show where they are sheets.
    #[must_use]
    pub fn bytes(&self, window: VaneDisc, level: Level, rami: Rami, layers: usize) -> f64 {
        let census = self.census(window);
        let Census { barbs: [closed, loose], barbules, .. } = census;
        let begun = PER_SHAFT + census.laid_out_bytes();
        let ramus = |segment: f64| match rami {
            Rami::Meshes => PER_RAMUS + RAMUS_TRIANGLES * PER_TRIANGLE,
            Rami::Fibres => PER_RAMUS + RAMUS_SEGMENTS * segment,
        };
        let grown = match level {
            Level::Barbules => {
                let segments = BARBULE_SEGMENTS * (barbules[0] + barbules[1]) + RAMUS_TRIANGLES * closed;
                let [segment, of_down] = per_segment(segments);
                barbules[0] * (PER_BARBULE + BARBULE_SEGMENTS * segment)
                    + barbules[1] * (PER_DOWNY_BARBULE + BARBULE_SEGMENTS * of_down)
                    + closed * ramus(segment)
                    + loose * (PER_FIBRE + RAMUS_SEGMENTS * segment)
            }
            Level::Barbs => {
                closed * ramus(IN_PIECES)
                    + loose * (PER_FIBRE + RAMUS_SEGMENTS * IN_PIECES)
                    + self.stretches_bytes(census.barbs_mm)
            }
            Level::Envelopes => (closed + loose) * PER_ENVELOPE,
            Level::Vane => closed * PER_STRIP + loose * PER_ENVELOPE + self.shown_bytes(rami, layers),
        };
        begun + grown
    }

    /// About how many stretches of barbules stand in a window, where these repeat.
    #[must_use]
    pub fn places_in(&self, window: VaneDisc) -> f64 {
        2.0 * self.census(window).barbs_mm.iter().sum::<f64>() / stretch::LENGTH_MM
    }

    /// Memory of rows of stretches along barbs of the closed vane and of the downy part that are so long together, mm.
    fn stretches_bytes(&self, barbs_mm: [f64; 2]) -> f64 {
        let downy = self.downy.barbules();
        let rows = [(barbs_mm[0], &self.distal), (barbs_mm[0], &self.proximal), (2.0 * barbs_mm[1], &downy)];
        let one = |(mm, shape): (f64, &super::BarbuleShape)| {
            if mm <= 0.0 {
                return 0.0;
            }
            let spacing_mm = 1e-3 * shape.spacing_um;
            let count = libm::round(stretch::LENGTH_MM / spacing_mm).max(1.0);
            let places = mm / (count * spacing_mm);
            let made = 2.0 * stretch::MADE as f64;
            let shown = made.min(places);
            count * (made * PER_BARBULE + shown * BARBULE_SEGMENTS * REPEATED) + places * PER_PLACE
        };
        rows.into_iter().map(one).sum()
    }

    /// How much of that is for what the vanes show where they are sheets: a swatch of each side for each layer.
    #[must_use]
    pub fn shown_bytes(&self, rami: Rami, layers: usize) -> f64 {
        let Census { laid_out, barbs_mm, .. } = self.census(VaneDisc::WHOLE);
        let barbs = swatch::BARBS as f64;
        let ramus = match rami {
            Rami::Meshes => PER_RAMUS + RAMUS_TRIANGLES * PER_TRIANGLE,
            Rami::Fibres => PER_RAMUS + RAMUS_SEGMENTS * IN_PIECES,
        };
        // One side of it, so that there are half as many stretches.
        let mean_mm = 0.5 * barbs_mm[0] / laid_out.max(1.0);
        let swatch = barbs * ramus + 0.5 * self.stretches_bytes([2.0 * barbs * mean_mm, 0.0]);
        2.0 * layers as f64 * swatch
    }
}
