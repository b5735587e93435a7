//! The Gaussian process whose draws tell one barbule from another (S.32–S.49).

use fearless_simd::{Simd, f32x4, f32x16, f64x4, i16x16, i32x4, mask32x4, prelude::*};
use num_complex::Complex;
use std::f64::consts::TAU;

use super::arrays::{Arrays, TableArray};
use super::material::NOISE_TERMS;
use super::simd::{columns, spread, transposed, whole_and_rest};
use super::slope::{self, VALUES};
use crate::math::fft::Transformable as _;
use crate::math::rng::{Stream, hash};
use crate::scattering::statistics::NOISE_POINTS;
use crate::{Error, Result};

/// Base functions; rotated, shifted and mirrored they give every instance functions of its own: what both polarizations
/// share, and half a period further what the second has beside it.
const BASES: usize = 128;

/// Points in half a period.
const HALF: usize = NOISE_POINTS / 2;

/// Numbers at a point: of a base and of the next, (q_r, q_i) there and half a period further.
const WIDTH: usize = 8;

/// Numbers of a base: those of each point of half a period and of the next one. The second half of the period has the same
/// in another order.
const ROW: usize = WIDTH * (HALF + 1);

/// From one base to the next, over 1/h of the height phase k(z_i + z_o): intensities whose phases differ by Δ then correlate by
/// exp(−(hΔ)²) within 0.013, mean over where between two bases they lie.
pub const NOISE_SLICE: f64 = 1.5175;

/// Rotations of (q_r, q_i) in their plane.
const ROTATIONS: usize = 1024;

/// Bases beyond which the height phase does not count on, so that their numbers stay exact in single precision.
const MOST_SLICES: f64 = 32_768.0;

/// An odd number whose multiples spread over all bits.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Purpose of the random streams of this file.
const PURPOSE: u64 = 0x006e_6f69_7365;

/// The power spectrum P₁ … P_{N/2−1} of an autocovariance at lags 0 … N/2 − 1 of spacing 2/N.
///
/// The lags are normalized to C(0) = 1 and shifted by a constant so that they sum to zero over the period (S.34), tiny
/// negative P are clipped, P₀ = P_{N/2} = 0, and the result is normalized to Σ P = ½ over these terms. Without any
/// positive power (or with something not finite) the process is white.
#[must_use]
pub fn spectrum(autocovariance: &[f64]) -> Vec<f64> {
    let n = NOISE_POINTS;
    let lag = |k: usize| autocovariance.get(k).copied().unwrap_or(0.0);
    let mut circle: Vec<Complex<f64>> =
        (0..n).map(|k| Complex::new(lag(k.min(n - k).min(n / 2 - 1)), 0.0)).collect();
    // Dropping P₀ is the constant that makes the lags sum to zero.
    f64::forward(n).process_once(&mut circle);
    let power: Vec<f64> = circle[1..n / 2].iter().map(|c| c.re.max(0.0)).collect();
    let sum: f64 = power.iter().sum();
    if sum > 0.0 && sum.is_finite() {
        power.iter().map(|p| 0.5 * p / sum).collect()
    } else {
        vec![0.5 / NOISE_TERMS as f64; NOISE_TERMS]
    }
}

/// How noise changes with the wavelength, and as the light turns while x_i + x_o stays.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spectral {
    /// h, µm: fields whose height phases k(z_i + z_o) differ by Δ correlate by exp(−(hΔ)²/2).
    pub height_um: f64,
    /// Share of the instances whose pattern is the same at all wavelengths.
    pub achromatic: f64,
}

/// h that a material may have, µm.
const HEIGHTS_UM: [f64; 2] = [0.0, 100.0];

impl Spectral {
    /// Refuses what no material has.
    ///
    /// # Errors
    /// h is outside 0 to 100 µm, or the share outside 0 to 1.
    pub fn check(&self) -> Result<()> {
        for (name, value, [low, high]) in
            [("height_um", self.height_um, HEIGHTS_UM), ("achromatic", self.achromatic, [0.0, 1.0])]
        {
            if !(low..=high).contains(&value) {
                return Err(Error::input(format!(
                    "{name} is {value}, but must lie between {low} and {high}; fit the material again"
                )));
            }
        }
        Ok(())
    }
}

/// Where noise is looked up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    /// (x_i + x_o)/l.
    pub x: f64,
    /// The same over the length that all wavelengths of an achromatic instance share.
    pub achromatic_x: f64,
    /// k(z_i + z_o), rad/µm.
    pub height_phase_per_um: f64,
}

/// Draws of the process, ready for lookup.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// In sixteen bits, so that all stay in a core's cache (1 MB), and one load holds all about a place. Shape
    /// `[base, point, 8]`.
    values: Vec<[i16; ROW]>,
    /// Cosine and sine of evenly spread angles, times the step of `values`.
    rotations: Vec<[f32; 2]>,
    /// E of the wings.
    wings: Vec<f32>,
    /// Autocovariance of the final process at lags 0 … N/2.
    autocovariance: Vec<f64>,
    /// 1 − C₁, twice: the interpolation's loss of variance at t.
    loss: f32,
    spectral: Spectral,
    seed: u64,
}

/// One instance: two independent functions, and a factor for each wing.
#[derive(Debug, Clone, Copy)]
pub struct Draw {
    /// E on the sides of t < 0 and of t ≥ 0, see the module `slope`.
    wings: [f32; 2],
    /// Where the height phase is 0, in bases.
    base: f32,
    /// Bases over the height phase in rad/µm; none where all wavelengths share one pattern.
    bases_um: f32,
    /// Whether they do.
    achromatic: bool,
    /// How both functions are shifted and mirrored.
    shift: i32,
    direction: i32,
    /// How what both polarizations share is turned, and what the second has beside it: cosine and sine times the step of
    /// the values.
    shared: [f32; 2],
    own: [f32; 2],
}

impl Draw {
    /// τ of an instance where this much of it, g h, goes with the slope t.
    pub(super) fn factor(&self, part: f64, t: f64) -> f64 {
        1.0 + part * (f64::from(self.wing(t)) - 1.0)
    }

    /// The x of this instance at a place.
    fn x(&self, at: &At) -> f64 {
        if self.achromatic { at.achromatic_x } else { at.x }
    }

    /// Whether the pattern is the same at all wavelengths.
    #[inline(always)]
    pub(super) fn is_achromatic(&self) -> bool {
        self.achromatic
    }

    /// E on the side of t.
    #[inline(always)]
    pub(super) fn wing(&self, t: f64) -> f32 {
        self.wings[usize::from(t >= 0.0)]
    }
}

impl Noise {
    /// Draws the base functions of P₁ … P_{N/2−1}.
    #[must_use]
    pub fn new(power: &[f64], spectral: Spectral, seed: u64) -> Self {
        let n = NOISE_POINTS;

        let inverse = f64::inverse(n);
        let mut scratch = vec![Complex::new(0.0, 0.0); inverse.scratch_len()];
        let mut values = vec![[0.0_f32; 2 * NOISE_POINTS]; BASES];
        let mut terms = vec![Complex::new(0.0, 0.0); n];
        for (base, values) in values.iter_mut().enumerate() {
            let mut stream = Stream::new(seed, &[PURPOSE, base as u64]);
            // One complex transform makes two real functions: with independent normal terms at ±l of power 2 P_l each
            // (real and imaginary parts of P_l), real and imaginary parts are independent and follow S.36.
            terms.fill(Complex::new(0.0, 0.0));
            for (l, p) in power.iter().enumerate().take(NOISE_TERMS) {
                let amplitude = p.sqrt();
                terms[l + 1] = Complex::new(stream.normal(), stream.normal()) * amplitude;
                terms[n - l - 1] = Complex::new(stream.normal(), stream.normal()) * amplitude;
            }
            inverse.process(&mut terms, &mut scratch);
            for (value, c) in values.chunks_exact_mut(2).zip(&terms) {
                value.copy_from_slice(&[c.re as f32, c.im as f32]);
            }
        }
        part_neighbours(&mut values);
        let (values, step) = quantized(&values);
        let autocovariance: Vec<f64> = (0..=n / 2)
            .map(|k| {
                let term = |l: usize, p: &f64| p * libm::cos(TAU * ((k * (l + 1)) % n) as f64 / n as f64);
                2.0 * power.iter().enumerate().map(|(l, p)| term(l, p)).sum::<f64>()
            })
            .collect();
        let rotations = (0..ROTATIONS)
            .map(|k| {
                let (sin, cos) = libm::sincos(TAU * (k as f64 + 0.5) / ROTATIONS as f64);
                [(step * cos) as f32, (step * sin) as f32]
            })
            .collect();
        let wings = slope::values().into_iter().map(|value| value as f32).collect();
        Self { values, rotations, wings, loss: loss(&autocovariance), autocovariance, spectral, seed }
    }

    pub(super) fn seed(&self) -> u64 {
        self.seed
    }

    /// How it changes with the wavelength.
    #[must_use]
    pub fn spectral(&self) -> Spectral {
        self.spectral
    }

    pub(super) fn arrays(&self) -> [TableArray<'_>; 4] {
        [
            TableArray::new("codes", &[BASES, HALF + 1, WIDTH], self.values.as_flattened()),
            TableArray::new("rotations", &[ROTATIONS, 2], self.rotations.as_flattened()),
            TableArray::new("wings", &[VALUES], &self.wings),
            TableArray::new("autocovariance", &[HALF + 1], &self.autocovariance),
        ]
    }

    pub(super) fn from_arrays(from: Arrays<'_>, spectral: Spectral, seed: u64) -> Result<Self> {
        let codes = from.get("codes", &[BASES, HALF + 1, WIDTH], &[[-32_768.0, 32_767.0]])?;
        let rotations = from.get("rotations", &[ROTATIONS, 2], &[[-1e3, 1e3]])?;
        let one = 1.0 + 1e-9;
        let autocovariance = from.get("autocovariance", &[HALF + 1], &[[-one, one]])?.to_vec();
        Ok(Self {
            values: codes.as_chunks().0.to_vec(),
            rotations: rotations.as_chunks().0.to_vec(),
            wings: from.get("wings", &[VALUES], &[[0.0, 100.0]])?.to_vec(),
            loss: loss(&autocovariance),
            autocovariance,
            spectral,
            seed,
        })
    }

    /// The autocovariance of the process at lags 0 … N/2, spacing 2/N.
    #[must_use]
    pub fn autocovariance(&self) -> &[f64] {
        &self.autocovariance
    }

    /// The draw that belongs to an instance.
    #[must_use]
    #[inline(always)]
    pub fn draw(&self, instance: u64) -> Draw {
        let bits = hash(self.seed, &[instance]);
        let rotation = |first: u32| self.rotations[(bits >> first) as usize % ROTATIONS];
        // Other bits of the same name.
        let more = bits.wrapping_mul(GOLDEN);
        let Spectral { height_um, achromatic } = self.spectral;
        let achromatic = ((more >> 48) as f64) < achromatic * 65_536.0;
        Draw {
            wings: [bits >> 8, bits >> 28].map(|bits| self.wings[bits as usize % VALUES]),
            base: (bits as usize % BASES) as f32 + (more >> 40 & 0xff) as f32 / 256.0,
            bases_um: if achromatic { 0.0 } else { (height_um / NOISE_SLICE) as f32 },
            achromatic,
            shift: (bits >> 16) as i32 & (NOISE_POINTS as i32 - 1),
            direction: if bits >> 63 == 0 { 1 } else { -1 },
            shared: rotation(40),
            own: rotation(50),
        }
    }

    /// (q_r, q_i) for each incident polarization: the second's is γ q + √(1−γ²) q' with γ = `correlation`.
    /// Interpolated with the weights of S.47, which keep the variance; the period along x is 2.
    #[must_use]
    pub fn at_both(&self, draw: &Draw, at: &At, correlation: f64) -> [[f64; 2]; 2] {
        let [first, own] = self.exact(draw, at);
        let rest = (1.0 - correlation * correlation).max(0.0).sqrt();
        [first, [0, 1].map(|part| correlation * first[part] + rest * own[part])]
    }

    /// [`at_four`](Self::at_four) in double precision, one formula after another.
    fn exact(&self, draw: &Draw, at: &At) -> [[f64; 2]; 2] {
        let position = draw.x(at).clamp(-512.0, 512.0) * (0.5 * NOISE_POINTS as f64) - 0.5;
        let (k, t) = (position.floor(), position - position.floor());
        let slice = f64::from(draw.base) + f64::from(draw.bases_um) * at.height_phase_per_um;
        let slice = slice.min(MOST_SLICES);
        let (base, s) = (slice.floor(), slice - slice.floor());
        let row = &self.values[base as usize % BASES];
        let value = |k: i32, part: usize| {
            let point = (draw.shift + draw.direction * k) as usize & (NOISE_POINTS - 1);
            let part = if point < HALF { part } else { part ^ 2 };
            let of = |next: usize| f64::from(row[WIDTH * (point % HALF) + 4 * next + part]);
            (1.0 - s) * of(0) + s * of(1)
        };
        // (1−t)² + t² + 2 t (1−t) C₁, and the same of independent functions
        let scale = 1.0 / (1.0 - 2.0 * t * (1.0 - t) * (1.0 - self.autocovariance[1])).sqrt();
        let scale = scale / (1.0 - 2.0 * s * (1.0 - s)).sqrt();
        let between =
            |part: usize| scale * ((1.0 - t) * value(k as i32, part) + t * value(k as i32 + 1, part));
        let turned = |[cosine, sine]: [f32; 2], part: usize| {
            let (cosine, sine) = (f64::from(cosine), f64::from(sine));
            let (a, b) = (between(part), between(part + 1));
            [a * cosine - b * sine, a * sine + b * cosine]
        };
        [turned(draw.shared, 0), turned(draw.own, 2)]
    }

    /// Where four x lie between the points, and their height phases (rad/µm) between the bases.
    #[inline(always)]
    pub(super) fn place<S: Simd>(&self, simd: S, draw: &Draw, x: f32x4<S>, phase: f32x4<S>) -> Place<S> {
        let one = f32x4::splat(simd, 1.0);
        // x_k = (2k + 1 − N)/N, up to half a period. The bounds keep the index exact far outside (−1, 1).
        let position = x.max(-512.0).min(512.0) * (0.5 * NOISE_POINTS as f32) - 0.5;
        let (index, t) = whole_and_rest(position);
        let bases = phase.mul_add(f32x4::splat(simd, draw.bases_um), f32x4::splat(simd, draw.base));
        let (base, s) = whole_and_rest(bases.min(MOST_SLICES as f32));
        // (1−t)² + t² + 2 t (1−t) C₁ = 1 − 2 t (1−t)(1 − C₁), and the same with C₁ = 0.
        let (rest, left) = (one - t, one - s);
        let scale = one / ((one - t * rest * self.loss) * (one - s * left * 2.0)).sqrt();
        // Mirrored functions go downwards: both points are still read together. Half of all draws are, so a branch would
        // be foretold wrongly as often.
        let mirrored = draw.direction < 0;
        let mask = mask32x4::splat(simd, mirrored);
        let shift = i32x4::splat(simd, draw.shift - i32::from(mirrored));
        let point = mask.select(shift - index, shift + index);
        let (low, high) = (mask.select(t, rest), mask.select(rest, t));
        Place { point, low, high, base, this: left, next: s, scale }
    }

    /// q_r and q_i of what both polarizations share, then of what the second has beside it, at four places.
    #[inline(always)]
    pub(super) fn at_four<S: Simd>(&self, simd: S, draw: &Draw, place: &Place<S>) -> [f32x4<S>; 4] {
        let Place { point, low, high, base, this, next, scale } = *place;
        let [a, b, c, d] = quarters(
            simd,
            [
                self.about(base[0], point[0]),
                self.about(base[1], point[1]),
                self.about(base[2], point[2]),
                self.about(base[3], point[3]),
            ],
        );
        let near = quarter(b).mul_add(spread(low * next), quarter(a) * spread(low * this));
        let far = quarter(d).mul_add(spread(high * next), quarter(c) * spread(high * this));
        let [a, b, c, d] = columns(near + far);
        let further = (point & i32x4::splat(simd, HALF as i32)).simd_gt(i32x4::splat(simd, 0));
        let (a, c) = (further.select(c, a), further.select(a, c));
        let (b, d) = (further.select(d, b), further.select(b, d));
        // Last, since the codes are read while the scale's root and division take their time.
        let (cos, sin) = (scale * draw.shared[0], scale * draw.shared[1]);
        let (cos_own, sin_own) = (scale * draw.own[0], scale * draw.own[1]);
        [a * cos - b * sin, a * sin + b * cos, c * cos_own - d * sin_own, c * sin_own + d * cos_own]
    }

    /// The codes at a point and the next, of a base and the next: one load holds all sixteen.
    #[inline(always)]
    fn about(&self, base: i32, point: i32) -> &[i16] {
        let at = WIDTH * (point as usize & (HALF - 1));
        &self.values[base as usize & (BASES - 1)][at..at + 2 * WIDTH]
    }
}

/// The first four codes of four places side by side, the second, the third and the fourth.
#[inline(always)]
fn quarters<S: Simd>(simd: S, [a, b, c, d]: [&[i16]; 4]) -> [i16x16<S>; 4] {
    let a = i16x16::from_slice(simd, a).bitcast::<f64x4<S>>();
    let b = i16x16::from_slice(simd, b).bitcast::<f64x4<S>>();
    let c = i16x16::from_slice(simd, c).bitcast::<f64x4<S>>();
    let d = i16x16::from_slice(simd, d).bitcast::<f64x4<S>>();
    let [a, b, c, d] = transposed(a, b, c, d);
    [a.bitcast(), b.bitcast(), c.bitcast(), d.bitcast()]
}

#[inline(always)]
fn quarter<S: Simd>(codes: i16x16<S>) -> f32x16<S> {
    let (low, high) = codes.widen();
    f32x16::float_from(low.combine(high))
}

/// 1 − C₁, twice.
fn loss(autocovariance: &[f64]) -> f32 {
    (2.0 * (1.0 - autocovariance[1])) as f32
}

/// Points and bases of the noise beside four places, and their weights.
pub(super) struct Place<S: Simd> {
    /// The lower of both points.
    point: i32x4<S>,
    low: f32x4<S>,
    high: f32x4<S>,
    base: i32x4<S>,
    this: f32x4<S>,
    next: f32x4<S>,
    /// What keeps the variance.
    scale: f32x4<S>,
}

/// The points of the noise between two places, where its interpolation has corners.
pub(super) fn knots(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let n = NOISE_POINTS as f64;
    let place = |x: f64| 0.5 * (x * n + n - 1.0);
    let (first, last) = (place(low).ceil() as i64, place(high).floor() as i64);
    (first..=last).map(move |k| (2.0 * k as f64 + 1.0 - n) / n)
}

/// Turns bases into their negatives, which are as likely, so that each is, in the mean over all, independent of the next: the weights
/// between two bases take them for that, and a mean correlation ρ would make instances (π/2 − 1) ρ too bright, a percent where the 128 are
/// left as they were drawn.
fn part_neighbours(values: &mut [[f32; 2 * NOISE_POINTS]]) {
    let product = |a: &[f32; 2 * NOISE_POINTS], b: &[f32; 2 * NOISE_POINTS]| -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    };
    let (mut sum, last) = (0.0, values.len() - 1);
    for base in 1..=last {
        let mut own = product(&values[base - 1], &values[base]);
        if base == last {
            // Bases are a circle.
            own += product(&values[last], &values[0]);
        }
        if sum * own > 0.0 {
            values[base].iter_mut().for_each(|value| *value = -*value);
            own = -own;
        }
        sum += own;
    }
}

/// In sixteen bits, with the step that makes the variance over all bases and points exactly 1, so that E[f] = f̂ over
/// the instances that exist.
fn quantized(values: &[[f32; 2 * NOISE_POINTS]]) -> (Vec<[i16; ROW]>, f64) {
    let largest = values.as_flattened().iter().fold(1e-30_f32, |largest, v| largest.max(v.abs()));
    let scale = f32::from(i16::MAX) / largest;
    let whole = |base: usize| -> [i16; ROW] {
        std::array::from_fn(|k| {
            let row = &values[(base + k % WIDTH / 4) % values.len()];
            let (point, part) = (k / WIDTH + k % 4 / 2 * HALF, k % 2);
            (row[2 * (point % NOISE_POINTS) + part] * scale).round() as i16
        })
    };
    let rows: Vec<[i16; ROW]> = (0..values.len()).map(whole).collect();
    // Each base stands in two rows.
    let squares =
        |row: &[i16; ROW]| -> f64 { row[..WIDTH * HALF].iter().map(|v| f64::from(*v).powi(2)).sum() };
    let sum: f64 = 0.5 * rows.iter().map(squares).sum::<f64>();
    let step = ((2 * NOISE_POINTS * rows.len()) as f64 / sum.max(1.0)).sqrt();
    (rows, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A band-limited process with correlation length 0.02.
    fn noise() -> Noise {
        let lags: Vec<f64> =
            (0..512).map(|k| libm::exp(-(2.0 * f64::from(k) / 1024.0 / 0.02).powi(2))).collect();
        Noise::new(&spectrum(&lags), Spectral { height_um: 0.2, achromatic: 0.25 }, 5)
    }

    fn at(x: f64, height_phase_per_um: f64) -> At {
        At { x, achromatic_x: x, height_phase_per_um }
    }

    /// Between two bases instances are as bright as on one, over all that there are.
    #[test]
    fn instances_are_as_bright_between_bases_as_on_them() {
        for seed in 0..8 {
            for length in [0.02, 0.1] {
                let lags: Vec<f64> =
                    (0..512).map(|k| libm::exp(-(2.0 * f64::from(k) / 1024.0 / length).powi(2))).collect();
                let noise = Noise::new(&spectrum(&lags), Spectral::default(), seed);
                let [cos, sin] = noise.rotations[0];
                let mean = |s: f32| {
                    let mut sum = 0.0;
                    for base in 0..BASES {
                        let draw = Draw {
                            base: base as f32 + s,
                            shift: 0,
                            direction: 1,
                            shared: [cos, sin],
                            own: [cos, sin],
                            ..noise.draw(0)
                        };
                        for point in 0..NOISE_POINTS {
                            let x = (2 * point + 1) as f64 / NOISE_POINTS as f64 - 1.0;
                            let [[r, i], _] = noise.at_both(&draw, &at(x, 0.0), 1.0);
                            sum += 0.5 * (r * r + i * i);
                        }
                    }
                    sum / (BASES * NOISE_POINTS) as f64
                };
                assert!(
                    (mean(0.0) - 1.0).abs() < 1e-6 && (mean(0.5) - 1.0).abs() < 4e-3,
                    "{seed}: {}",
                    mean(0.5)
                );
            }
        }
    }

    /// Intensities of chromatic instances correlate by exp(−(hΔ)²), those of achromatic ones wholly, and where they are looked up
    /// at other places only these are the same.
    #[test]
    fn height_phases_and_lengths_tell_wavelengths_apart() {
        let noise = noise();
        let intensity = |instance: u64, at: &At| -> f64 {
            let [[r, i], _] = noise.at_both(&noise.draw(instance), at, 1.0);
            0.5 * (r * r + i * i)
        };
        let correlation = |first: &At, second: &At| -> f64 {
            let count = 60_000;
            let terms = (0..count).map(|k| (intensity(k, first) - 1.0) * (intensity(k, second) - 1.0));
            terms.sum::<f64>() / count as f64
        };
        let Spectral { height_um, achromatic } = noise.spectral();
        for apart in [0.0, 1.5, 3.0, 5.0, 8.0, 15.0] {
            let found = correlation(&at(0.1, 12.0), &at(0.1, 12.0 + apart));
            let expected = achromatic + (1.0 - achromatic) * libm::exp(-(height_um * apart).powi(2));
            // Three standard deviations of a product of exponential numbers.
            assert!((found - expected).abs() < 0.04, "{apart}: {found} {expected}");
        }
        let found = correlation(&at(0.1, 12.0), &At { achromatic_x: 0.1, ..at(0.2, 12.0) });
        assert!((found - achromatic).abs() < 0.04, "{found}");
    }

    #[test]
    fn values_have_zero_mean_unit_variance_and_the_autocovariance_also_between_points() {
        let noise = noise();
        let count = 40_000;
        for x in [0.0, 0.000_488, 0.1003, -0.77] {
            let (mut mean, mut variance, mut cross, mut between) = (0.0, 0.0, 0.0, 0.0);
            let mut lag = [0.0; 3];
            for instance in 0..count {
                let draw = noise.draw(instance);
                let [[r, i], [r_2, i_2]] = noise.at_both(&draw, &at(x, 17.3), 0.6);
                between += 0.5 * (r * r_2 + i * i_2);
                mean += r + i;
                variance += 0.5 * (r * r + i * i);
                cross += r * i;
                for (k, sum) in lag.iter_mut().enumerate() {
                    let [[r2, i2], _] =
                        noise.at_both(&draw, &at(x + (5 * (k + 1)) as f64 / 512.0, 17.3), 1.0);
                    *sum += 0.5 * (r * r2 + i * i2);
                }
            }
            let n = count as f64;
            // Three standard deviations of the sums: √(2/n), √(1/n), …
            assert!((mean / n).abs() < 0.03, "{x} mean {}", mean / n);
            assert!((variance / n - 1.0).abs() < 0.02, "{x} variance {}", variance / n);
            assert!((cross / n).abs() < 0.02);
            assert!((between / n - 0.6).abs() < 0.02, "{x} between polarizations {}", between / n);
            for (k, sum) in lag.iter().enumerate() {
                let expected = noise.autocovariance()[5 * (k + 1)];
                assert!((sum / n - expected).abs() < 0.02, "{x} lag {k}: {} {expected}", sum / n);
            }
        }
    }

    #[test]
    fn interpolation_loses_no_variance_for_a_rough_process() {
        // Correlation length 0.6 of a spacing: plain linear interpolation would lose 40 % of the variance midway.
        let lags: Vec<f64> = (0..512).map(|k| libm::exp(-(f64::from(k) / 0.6).powi(2))).collect();
        let noise = Noise::new(&spectrum(&lags), Spectral::default(), 1);
        let count = 40_000;
        let mid: f64 =
            (0..count).map(|i| noise.at_both(&noise.draw(i), &at(0.0, 0.0), 1.0)[0][0].powi(2)).sum::<f64>();
        assert!((mid / count as f64 - 1.0).abs() < 0.02, "{}", mid / count as f64);
    }

    #[test]
    fn the_spectrum_is_that_of_the_autocovariance() {
        let lags: Vec<f64> = (0..512).map(|k| libm::cos(TAU * 7.0 * f64::from(k) / 1024.0)).collect();
        let power = spectrum(&lags);
        assert_eq!(power.len(), NOISE_TERMS);
        // Lag N/2 repeats none of the 512 given: a thousandth of the power leaks.
        assert!((power[6] - 0.5).abs() < 2e-3, "{}", power[6]);
        assert!((power.iter().sum::<f64>() - 0.5).abs() < 1e-12);
        assert!(spectrum(&[]).iter().chain(&spectrum(&[f64::NAN; 4])).all(|p| *p > 0.0));
    }
}
