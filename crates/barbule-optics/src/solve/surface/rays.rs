//! The rays under the elements of a surface and their reflectances at one angle after another.
//!
//! Rays are reflected in blocks. A block lists the layers that any of its rays crosses, so layers that a structure has
//! elsewhere cost nothing here, and what two media that meet reflect is known once per angle for all blocks.

use fearless_simd::prelude::*;
use num_complex::{Complex32, Complex64};

use super::points::Points;
use super::reflection::{BLOCK, Fractions, RESCALE_EVERY, cross, lanes, layer, reflectances_of, rescale};
use crate::Result;
use crate::math::simd::{Complex, SLIGHT, decay, load, slight_decay, splat, turn};
use crate::scattering::far_field::Window;
use crate::spectrum::wave_number_per_um;
use crate::structure::{Palette, PaletteMixture, Section, SlotMixture};

/// Real numbers per ray: real and imaginary parts of r_s and r_p.
pub(super) const SERIES: usize = 4;

/// Vectors of rays whose recursions run side by side, to hide the latency of one.
const TOGETHER: usize = 2;

/// Rays under one element of a points, which has two Gauss points: `parts` sub-elements (a power of two of them, at
/// most half a block) with two rays each.
///
/// Structure finer than an element is averaged: a point's reflectance is not that of the one ray under it but the value
/// with which the element's two points give the integrals over all its rays, of the reflectance and of its product with
/// the position.
pub(super) struct Rays {
    parts: usize,
    /// `[point of the element][ray of the element]`
    weights: [Vec<f32>; 2],
    palette: Palette,
    /// Media that fill a layer of a whole block.
    uniform: Vec<PaletteMixture>,
    /// Media of layers that differ between the rays of a block, under these.
    varying: Vec<SlotMixture>,
    /// Uniform media that meet: above (`None`: air) and below.
    meetings: Vec<(Option<usize>, usize)>,
    /// Layers of all blocks, top to bottom; the last of each block is its substrate.
    layers: Vec<Layer>,
    /// `[layer][ray]`; nothing for substrates.
    thickness_um: Vec<[f32; BLOCK]>,
    /// End of each block's layers.
    blocks: Vec<usize>,
}

/// One layer of a block.
struct Layer {
    medium: Fill,
    /// The meeting at the layer's top, where both media are uniform.
    meeting: Option<usize>,
    thickest_um: f32,
}

#[derive(Clone, Copy, PartialEq)]
enum Fill {
    Uniform(usize),
    Varying(usize),
}

/// The media of rays at one wavelength, as ε − 1.
pub(super) struct Media {
    k: f64,
    uniform: Vec<Complex64>,
    /// `[medium][re, im][ray]`
    varying: Vec<[[f32; BLOCK]; 2]>,
}

impl Media {
    /// ε − 1 of a varying medium for the rays `at` … of a block.
    #[inline(always)]
    fn varying<S: Simd>(&self, simd: S, medium: usize, at: usize) -> Complex<S::f32s> {
        let [re, im] = &self.varying[medium];
        Complex { re: load(simd, re, at), im: load(simd, im, at) }
    }
}

impl Rays {
    /// Casts rays for elements of at most `element_um`, at a place if there is one ([`Points::subdivided`]).
    ///
    /// # Errors
    /// As [`Points::new`].
    pub(super) fn cast(section: &Section, element_um: f64, parts: usize, place: Option<f64>) -> Result<Self> {
        let points = Points::subdivided(section, element_um, parts, Window::Gaussian, place)?;
        Ok(Self::under(&points, parts))
    }

    /// The rays under points, as many as elements cut into `parts` have.
    pub(super) fn under(points: &Points, parts: usize) -> Self {
        let mut rays = Self {
            parts,
            weights: moments(parts),
            palette: points.palette.clone(),
            uniform: Vec::new(),
            varying: Vec::new(),
            meetings: Vec::new(),
            layers: Vec::new(),
            thickness_um: Vec::new(),
            blocks: Vec::new(),
        };
        for start in (0..points.padded()).step_by(BLOCK) {
            rays.add_block(points, start);
        }
        rays.varying.shrink_to_fit();
        rays.layers.shrink_to_fit();
        rays.thickness_um.shrink_to_fit();
        rays
    }

    /// Lists the layers of the rays `start` … `start + BLOCK`.
    fn add_block(&mut self, points: &Points, start: usize) {
        let first = self.layers.len();
        let padded = points.padded();
        for slot in 0..points.slots {
            let substrate = slot + 1 == points.slots;
            let mut thickness = [0f32; BLOCK];
            if !substrate {
                let from = slot * padded + start;
                thickness.copy_from_slice(&points.single.thickness_um[from..from + BLOCK]);
            }
            let thickest_um = thickness.iter().fold(0f32, |a, &b| a.max(b));
            if thickest_um <= 0.0 && !substrate {
                continue;
            }
            let medium = self.fill(points, slot, start);
            // Layers of one medium on each other are one layer.
            let above = self.layers[first..].last().map(|above| above.medium);
            if let (Fill::Uniform(_), false) = (medium, substrate)
                && above == Some(medium)
            {
                let last = self.layers.len() - 1;
                let row = &mut self.thickness_um[last];
                row.iter_mut().zip(thickness).for_each(|(sum, more)| *sum += more);
                self.layers[last].thickest_um = row.iter().fold(0f32, |a, &b| a.max(b));
                continue;
            }
            let meeting = self.meeting(above, medium);
            self.layers.push(Layer { medium, meeting, thickest_um });
            self.thickness_um.push(thickness);
        }
        self.blocks.push(self.layers.len());
    }

    /// What fills a slot under the rays `start` ….
    fn fill(&mut self, points: &Points, slot: usize, start: usize) -> Fill {
        let one = match points.mixture(slot, start, start + BLOCK) {
            SlotMixture::Uniform(one) => one,
            varying => {
                self.varying.push(varying);
                return Fill::Varying(self.varying.len() - 1);
            }
        };
        let known = self.uniform.iter().position(|m| *m == one);
        Fill::Uniform(known.unwrap_or_else(|| {
            self.uniform.push(one);
            self.uniform.len() - 1
        }))
    }

    /// The meeting of two media, air above the first.
    fn meeting(&mut self, above: Option<Fill>, below: Fill) -> Option<usize> {
        let pair = match (above, below) {
            (None, Fill::Uniform(below)) => (None, below),
            (Some(Fill::Uniform(above)), Fill::Uniform(below)) => (Some(above), below),
            _ => return None,
        };
        let known = self.meetings.iter().position(|other| *other == pair);
        Some(known.unwrap_or_else(|| {
            self.meetings.push(pair);
            self.meetings.len() - 1
        }))
    }

    /// Parts into which elements are cut.
    pub(super) fn parts(&self) -> usize {
        self.parts
    }

    /// Blocks of rays.
    pub(super) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Weights with which an element's rays count at its two points.
    pub(super) fn weights(&self) -> &[Vec<f32>; 2] {
        &self.weights
    }

    /// Bytes that they take.
    pub(super) fn bytes(&self) -> usize {
        let varying: usize = self.varying.iter().map(|media| size_of_val(media) + media.bytes()).sum();
        size_of_val(&self.thickness_um[..]) + size_of_val(&self.layers[..]) + varying
    }

    /// The media at a vacuum wavelength.
    ///
    /// # Errors
    /// A table of a medium does not reach the wavelength.
    pub(super) fn media(&self, wavelength_nm: f64) -> Result<Media> {
        let indices = self.palette.indices(wavelength_nm)?;
        let uniform = self.uniform.iter().map(|m| m.contrast(&indices)).collect();
        let split = |media: &SlotMixture| {
            let values: [Complex64; BLOCK] = std::array::from_fn(|ray| media.contrast(ray, &indices));
            [values.map(|v| v.re as f32), values.map(|v| v.im as f32)]
        };
        Ok(Media {
            k: wave_number_per_um(wavelength_nm),
            uniform,
            varying: self.varying.iter().map(split).collect(),
        })
    }

    /// r_s and r_p of the rays of a block at one angle, `[re r_s, im r_s, re r_p, im r_p][ray]`; `trips` is scratch.
    #[inline(always)]
    pub(super) fn reflect<S: Simd>(
        &self,
        simd: S,
        media: &Media,
        angle: &AtAngle,
        block: usize,
        trips: &mut Vec<Trip>,
        out: &mut [[f32; BLOCK]; SERIES],
    ) {
        let first = if block == 0 { 0 } else { self.blocks[block - 1] };
        let end = self.blocks[block];
        let (layers, thickness_um) = (&self.layers[first..end], &self.thickness_um[first..end]);
        // Apart from the recursion, which waits for its own results, these keep all units busy.
        trips.resize(layers.len(), [[0.0; BLOCK]; 4]);
        for ((layer, row), trip) in layers.iter().zip(thickness_um).zip(&mut *trips) {
            round_trips(simd, media, angle, layer, row, trip);
        }
        let lanes = S::f32s::LEN;
        for from in (0..BLOCK).step_by(TOGETHER * lanes) {
            let values = recur(simd, media, angle, layers, trips, from);
            for (vector, [s, p]) in values.into_iter().enumerate() {
                let at = from + vector * lanes;
                for (row, value) in out.iter_mut().zip([s.re, s.im, p.re, p.im]) {
                    value.store_slice(&mut row[at..at + lanes]);
                }
            }
        }
    }
}

/// e^{2jkqd} of a layer for the rays of a block, and q where it varies, `[re, im, re q, im q][ray]`.
pub(super) type Trip = [[f32; BLOCK]; 4];

/// e^{2jkqd} of a layer of thicknesses `row` (µm).
#[inline(always)]
fn round_trips<S: Simd>(
    simd: S,
    media: &Media,
    angle: &AtAngle,
    layer: &Layer,
    row: &[f32; BLOCK],
    [out_re, out_im, q_re, q_im]: &mut Trip,
) {
    let lanes = S::f32s::LEN;
    let medium = match layer.medium {
        Fill::Uniform(medium) => medium,
        Fill::Varying(medium) => {
            let (turns, decays): (S::f32s, S::f32s) =
                (splat(simd, media.k / std::f64::consts::PI), splat(simd, 2.0 * media.k));
            let cos_squared: S::f32s = splat(simd, angle.cos_alpha * angle.cos_alpha);
            for at in (0..BLOCK).step_by(lanes) {
                let thickness: S::f32s = load(simd, row, at);
                let contrast = media.varying::<S>(simd, medium, at);
                let (_, q) = self::layer::<S, S::f32s>(simd, contrast, cos_squared);
                q.re.store_slice(&mut q_re[at..at + lanes]);
                q.im.store_slice(&mut q_im[at..at + lanes]);
                let (sin, cos) = turn(simd, thickness * turns * q.re);
                let size: S::f32s = decay(simd, thickness * decays * q.im);
                (cos * size).store_slice(&mut out_re[at..at + lanes]);
                (sin * size).store_slice(&mut out_im[at..at + lanes]);
            }
            return;
        }
    };
    let Wave { turns_per_um, decay_per_um, .. } = angle.waves[medium];
    let (turns, decays) = (S::f32s::splat(simd, turns_per_um), S::f32s::splat(simd, decay_per_um));
    // Most layers are thin or do not absorb.
    let most = decay_per_um * layer.thickest_um;
    if most <= 0.0 {
        for at in (0..BLOCK).step_by(lanes) {
            let (sin, cos) = turn(simd, load::<S, S::f32s>(simd, row, at) * turns);
            cos.store_slice(&mut out_re[at..at + lanes]);
            sin.store_slice(&mut out_im[at..at + lanes]);
        }
    } else if most <= SLIGHT {
        for at in (0..BLOCK).step_by(lanes) {
            let thickness: S::f32s = load(simd, row, at);
            let (sin, cos) = turn(simd, thickness * turns);
            let size: S::f32s = slight_decay(simd, thickness * decays);
            (cos * size).store_slice(&mut out_re[at..at + lanes]);
            (sin * size).store_slice(&mut out_im[at..at + lanes]);
        }
    } else {
        for at in (0..BLOCK).step_by(lanes) {
            let thickness: S::f32s = load(simd, row, at);
            let (sin, cos) = turn(simd, thickness * turns);
            let size: S::f32s = decay(simd, thickness * decays);
            (cos * size).store_slice(&mut out_re[at..at + lanes]);
            (sin * size).store_slice(&mut out_im[at..at + lanes]);
        }
    }
}

/// The recursion of the theory page for the rays `from` … of a block.
#[inline(always)]
fn recur<S: Simd>(
    simd: S,
    media: &Media,
    angle: &AtAngle,
    layers: &[Layer],
    trips: &[Trip],
    from: usize,
) -> [[Complex<S::f32s>; 2]; TOGETHER] {
    let (zero, one): (S::f32s, S::f32s) = (splat(simd, 0.0), splat(simd, 1.0));
    let nothing = (Complex { re: zero, im: zero }, Complex { re: one, im: zero });
    let mut fractions: [Fractions<S::f32s>; TOGETHER] = [[nothing; 2]; TOGETHER];
    for (index, (layer, [re, im, ..])) in layers.iter().zip(trips).enumerate().rev() {
        if index + 1 < layers.len() {
            for (vector, fractions) in fractions.iter_mut().enumerate() {
                let at = from + vector * S::f32s::LEN;
                let trip = Complex { re: load(simd, re, at), im: load(simd, im, at) };
                for (top, _) in fractions {
                    *top = top.times::<S>(trip);
                }
            }
        }
        if let Some(meeting) = layer.meeting {
            let meeting = angle.meetings[meeting];
            for fractions in &mut fractions {
                for ((top, bottom), r) in fractions.iter_mut().zip(meeting) {
                    let r = Complex { re: S::f32s::splat(simd, r.re), im: S::f32s::splat(simd, r.im) };
                    (*top, *bottom) = (r.mul_add::<S>(*bottom, *top), r.mul_add::<S>(*top, *bottom));
                }
            }
        } else {
            let above = index.checked_sub(1).map(|above| (layers[above].medium, &trips[above]));
            let below = (layer.medium, &trips[index]);
            for (vector, fractions) in fractions.iter_mut().enumerate() {
                let at = from + vector * S::f32s::LEN;
                let above = angle.medium(simd, media, above, at);
                let below = angle.medium(simd, media, Some(below), at);
                cross::<S, S::f32s>(above, below, fractions);
            }
        }
        if index % RESCALE_EVERY == 1 {
            for fractions in &mut fractions {
                rescale::<S, S::f32s>(simd, fractions);
            }
        }
    }
    let mut values = [[Complex { re: zero, im: zero }; 2]; TOGETHER];
    for (value, fractions) in values.iter_mut().zip(fractions) {
        *value = reflectances_of::<S, S::f32s>(fractions);
    }
    values
}

/// What is the same at one angle under all rays.
pub(super) struct AtAngle {
    cos_alpha: f64,
    waves: Vec<Wave>,
    /// r_s and r_p of each meeting of uniform media.
    meetings: Vec<[Complex32; 2]>,
}

/// A uniform medium at one angle.
#[derive(Clone, Copy)]
struct Wave {
    eps: Complex64,
    /// q = √(ε − sin²α)
    q: Complex64,
    /// Phase of the way down and up per thickness, in turns.
    turns_per_um: f32,
    decay_per_um: f32,
}

impl AtAngle {
    pub(super) fn new(rays: &Rays, media: &Media, cos_alpha: f64) -> Self {
        let wave = |contrast: &Complex64| {
            let q = (contrast + cos_alpha * cos_alpha).sqrt();
            Wave {
                eps: contrast + 1.0,
                q,
                turns_per_um: (media.k / std::f64::consts::PI * q.re) as f32,
                decay_per_um: (2.0 * media.k * q.im) as f32,
            }
        };
        let waves: Vec<Wave> = media.uniform.iter().map(wave).collect();
        let meet = |&(above, below): &(Option<usize>, usize)| {
            let (eps, q) = above.map_or((Complex64::ONE, Complex64::from(cos_alpha)), |above| {
                (waves[above].eps, waves[above].q)
            });
            let Wave { eps: below_eps, q: below_q, .. } = waves[below];
            let (x, y) = (below_eps * q, eps * below_q);
            [(q - below_q) / (q + below_q), (x - y) / (x + y)]
                .map(|r| Complex32::new(r.re as f32, r.im as f32))
        };
        let meetings = rays.meetings.iter().map(meet).collect();
        Self { cos_alpha, waves, meetings }
    }

    /// ε and q of a layer's medium (`None`: air) for the rays `at` … of a block.
    #[inline(always)]
    fn medium<S: Simd>(
        &self,
        simd: S,
        media: &Media,
        medium: Option<(Fill, &Trip)>,
        at: usize,
    ) -> (Complex<S::f32s>, Complex<S::f32s>) {
        match medium {
            None => lanes::<S, S::f32s>(simd, (Complex64::ONE, Complex64::from(self.cos_alpha))),
            Some((Fill::Uniform(medium), _)) => {
                let Wave { eps, q, .. } = self.waves[medium];
                lanes::<S, S::f32s>(simd, (eps, q))
            }
            Some((Fill::Varying(medium), [_, _, q_re, q_im])) => {
                let contrast = media.varying::<S>(simd, medium, at);
                let eps = Complex { re: contrast.re + splat::<S, S::f32s>(simd, 1.0), im: contrast.im };
                (eps, Complex { re: load(simd, q_re, at), im: load(simd, q_im, at) })
            }
        }
    }
}

/// The weights with which an element's rays count at its two points, so that integrals over the element of a reflectance
/// and of its product with the position are kept.
fn moments(parts: usize) -> [Vec<f32>; 2] {
    let gauss = 1.0 / 3f64.sqrt();
    // The position of each ray on [−1, 1]; the points are at ∓1/√3.
    let positions: Vec<f64> = (0..parts)
        .flat_map(|part| [-gauss, gauss].map(|side| (2.0 * part as f64 + 1.0 + side) / parts as f64 - 1.0))
        .collect();
    [-1.0, 1.0].map(|side| {
        let weight = |xi: &f64| ((1.0 + side * xi / gauss) / (2 * parts) as f64) as f32;
        positions.iter().map(weight).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_carry_the_integral_of_their_rays_and_its_first_moment() {
        for parts in [1, 2, 4, 8] {
            let weights = moments(parts);
            let gauss = 1.0 / 3f32.sqrt();
            let ends = (0..2 * parts).map(|ray| {
                let side = if ray % 2 == 0 { -gauss } else { gauss };
                ((2 * (ray / 2) + 1) as f32 + side) / parts as f32 - 1.0
            });
            let (mut mean, mut moment, mut square) = (0.0, 0.0, 0.0);
            for (ray, xi) in ends.enumerate() {
                let (a, b) = (weights[0][ray], weights[1][ray]);
                // The two points' values for a reflectance that is 1, or ξ, or 1 on this ray alone.
                mean += a + b;
                moment += (b - a) * gauss * xi;
                square += a + b - 1.0 / parts as f32;
            }
            assert!((mean - 2.0).abs() < 1e-5 && square.abs() < 1e-5, "{parts}: {mean}");
            // ∫ξ² dξ over [−1, 1], as two Gauss points give it.
            assert!((moment - 2.0 / 3.0).abs() < 1e-5, "{parts}: {moment}");
        }
    }
}
