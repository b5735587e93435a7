//! The lobes of four wavelengths at once, in vector registers.
//!
//! Everything here is inlined into one dispatched function, so it has neither closures nor calls that the compiler
//! could leave outside. Their reference is the module `exact`.

use fearless_simd::{Simd, f32x4, f32x8, i32x8, prelude::*};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, LN_2, LOG2_E, PI};

use super::simd::transposed;
use super::table::{LARGEST_SINE, Table};

/// Lobe parameters of one set at four wavelengths and one incident direction: the mean lobes of the four wavelengths,
/// then the stationary ones.
#[derive(Clone, Copy)]
pub(super) struct LobeLanes<S: Simd> {
    m2: f32x8<S>,
    /// x and z of ω_eff.
    x: f32x8<S>,
    z: f32x8<S>,
    amplitude: f32x8<S>,
    /// 1/l.
    pub(super) inverse_length: f32x4<S>,
}

/// The same in memory.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct StoredLobes {
    pub(super) m2: [f32; 8],
    pub(super) x: [f32; 8],
    pub(super) z: [f32; 8],
    pub(super) amplitude: [f32; 8],
    inverse_length: [f32; 4],
}

impl StoredLobes {
    pub(super) const NONE: Self =
        Self { m2: [1.0; 8], x: [0.0; 8], z: [1.0; 8], amplitude: [0.0; 8], inverse_length: [1.0; 4] };

    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S) -> LobeLanes<S> {
        LobeLanes {
            m2: f32x8::from_slice(simd, &self.m2),
            x: f32x8::from_slice(simd, &self.x),
            z: f32x8::from_slice(simd, &self.z),
            amplitude: f32x8::from_slice(simd, &self.amplitude),
            inverse_length: f32x4::from_slice(simd, &self.inverse_length),
        }
    }
}

impl<S: Simd> LobeLanes<S> {
    /// Looks up a set; `factor` = 1/(σ π^{3/2}).
    #[inline(always)]
    pub(super) fn new(simd: S, table: &Table, wavelengths_nm: [f32; 4], wi: [f32; 3], factor: f32) -> Self {
        let [x, _, z] = wi;
        let cos_theta = (x * x + z * z).sqrt().max(1e-6);
        let inverse = 1.0 / cos_theta;
        let sin_phi = x * inverse;
        let cell = table.cell(simd, cos_theta, z * inverse);
        let (index, weight) = table.places(simd, wavelengths_nm);
        let (a_mean, a_rest) = table.lookup(simd, &cell, index[0], weight[0]).split();
        let (b_mean, b_rest) = table.lookup(simd, &cell, index[1], weight[1]).split();
        let (c_mean, c_rest) = table.lookup(simd, &cell, index[2], weight[2]).split();
        let (d_mean, d_rest) = table.lookup(simd, &cell, index[3], weight[3]).split();
        let [m, tilt, strength, inverse_length] = transposed(a_mean, b_mean, c_mean, d_mean);
        let [m_rest, tilt_rest, strength_rest, _] = transposed(a_rest, b_rest, c_rest, d_rest);
        let (m, tilt): (f32x8<S>, f32x8<S>) = (m.combine(m_rest), tilt.combine(tilt_rest));
        let strength: f32x8<S> = strength.combine(strength_rest);
        let sine = (tilt * sin_phi).min(LARGEST_SINE).max(-LARGEST_SINE);
        let z = (f32x8::splat(simd, 1.0) - sine * sine).sqrt() * cos_theta;
        let m2 = m * m;
        // f̂ = ρ m/(2σ√π J) · D₁ D₂ · 2/(z + root): all constant factors.
        let amplitude = strength * (m2 * m) * factor / z;
        Self { m2, x: sine * cos_theta, z, amplitude, inverse_length }
    }

    #[inline(always)]
    pub(super) fn store(self) -> StoredLobes {
        StoredLobes {
            m2: self.m2.into(),
            x: self.x.into(),
            z: self.z.into(),
            amplitude: self.amplitude.into(),
            inverse_length: self.inverse_length.into(),
        }
    }

    /// f̂ and s ≤ f̂; `sin_theta` is y of ω_i.
    #[inline(always)]
    pub(super) fn values(
        self,
        simd: S,
        sin_theta: f32,
        wo: [f32; 3],
        inverse_sigma2: f32,
    ) -> (f32x4<S>, f32x4<S>) {
        let [x, y, z] = wo;
        let sy2 = (sin_theta + y) * (sin_theta + y);
        let outgoing = f32x8::splat(simd, z);
        let (sx, sz) = (self.x + f32x8::splat(simd, x), self.z + outgoing);
        let sx2 = sx * sx;
        let yz = sz.mul_add(sz, f32x8::splat(simd, sy2));
        let n2 = yz + sx2;
        // D₁ = m² n⁴ / (π (m² n² + (1−m²) s_x²)²) with s = ω_eff + ω_o, n = |s|.
        let ratio = n2 / self.m2.mul_add(yz, sx2);
        let root =
            outgoing + self.m2.mul_add(f32x8::splat(simd, 1.0 - z * z), f32x8::splat(simd, z * z)).sqrt();
        let spread = exp_of_negative(simd, f32x8::splat(simd, sy2 * inverse_sigma2) / n2);
        let (mean, rest) = (self.amplitude * spread * (ratio * ratio) / root).split();
        (mean, rest.min(mean))
    }

    /// Roughly the reflected fractions at the four wavelengths.
    #[inline(always)]
    pub(super) fn weights(self) -> f32x4<S> {
        let (amplitude, _) = (self.amplitude * self.z / (self.m2 * self.m2.sqrt())).split();
        amplitude + 1e-9
    }

    /// Density of ω_o per sr at each wavelength: p(h_y) p(h_x | h_y) h_z / (4 ω_eff·h) with ω_eff·h = n/2 and
    /// `y_factor` = 1/(σ√π erf(1/σ)).
    #[inline(always)]
    pub(super) fn densities(
        self,
        simd: S,
        sin_theta: f32,
        wo: [f32; 3],
        inverse_sigma2: f32,
        y_factor: f32,
    ) -> f32x4<S> {
        let one = f32x4::splat(simd, 1.0);
        let ((m2, _), (x, _), (z, _)) = (self.m2.split(), self.x.split(), self.z.split());
        let (sx, sy, sz) = (x + wo[0], sin_theta + wo[1], z + wo[2]);
        let sx2 = sx * sx;
        let n2 = sz.mul_add(sz, sx2 + sy * sy);
        let inverse = one / n2;
        let hy2 = inverse * (sy * sy);
        // a² grows without bound as m → 1, where h_x is uniform.
        let a2 = m2 / (one - m2).max(1e-12);
        let a = a2.sqrt();
        let end = (one - hy2).max(0.0).sqrt();
        let q = sx2 * inverse / a2 + 1.0;
        let (hy2_wide, _) = (hy2.combine(hy2) * inverse_sigma2, ());
        let (spread, _) = exp_of_negative(simd, hy2_wide).split();
        // h_z/(2n) = s_z/(2n²)
        spread * sz * inverse * (0.5 * y_factor / PI) / (a * q * q * half_distribution(simd, end / a))
    }
}

/// ∫₀^t 2/(π (1+s²)²) ds for t ≥ 0, relative error 2e-7.
#[inline(always)]
fn half_distribution<S: Simd>(simd: S, t: f32x4<S>) -> f32x4<S> {
    let one = f32x4::splat(simd, 1.0);
    let inverse = one / t.max(1e-30);
    let steep = t.simd_gt(one);
    let w = steep.select(inverse, t);
    let w2 = w * w;
    // atan w for 0 ≤ w ≤ 1, absolute error 2e-8 (Abramowitz & Stegun, 4.4.49).
    let mut series = f32x4::splat(simd, 0.002_866_225_7);
    for coefficient in [
        -0.016_165_737,
        0.042_909_614,
        -0.075_289_64,
        0.106_562_64,
        -0.142_089,
        0.199_935_51,
        -0.333_331_45,
        1.0,
    ] {
        series = series.mul_add(w2, f32x4::splat(simd, coefficient));
    }
    let low = w * series;
    let atan = steep.select(f32x4::splat(simd, FRAC_PI_2) - low, low);
    // t/(1+t²) = w/(1+w²)
    (w / (w2 + 1.0) + atan) * FRAC_1_PI
}

/// exp(−u) for u ≥ 0, relative error 3e-7; zero (below 1e-37) for large u.
#[inline(always)]
fn exp_of_negative<S: Simd>(simd: S, u: f32x8<S>) -> f32x8<S> {
    let y = (u * -LOG2_E).max(-125.0);
    let whole = y.round_ties_even();
    let f = (y - whole) * LN_2;
    let bits = (whole.to_int::<i32x8<S>>() + i32x8::splat(simd, 127)) << 23;
    let mut series = f32x8::splat(simd, 1.0 / 720.0);
    for coefficient in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        series = series.mul_add(f, f32x8::splat(simd, coefficient));
    }
    let zero = f32x8::splat(simd, 0.0);
    u.simd_gt(f32x8::splat(simd, 86.0)).select(zero, series * bits.bitcast::<f32x8<S>>())
}
