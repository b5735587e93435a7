//! Vector kernels that are chosen for the processor at run time, with a scalar form that tests force.
//!
//! Sums are ordered by the width in use, so bits are the same for any thread count at one width and agree to rounding
//! across widths.

use std::sync::LazyLock;

use fearless_simd::{Level, prelude::*};

use crate::error::did_you_mean;
use crate::{Error, Result};

/// The widest instructions of this processor, found once: for kernels that take too little time to look each time.
#[inline(always)]
#[must_use]
pub fn level() -> Level {
    static LEVEL: LazyLock<Level> = LazyLock::new(Level::new);
    *LEVEL
}

/// As [`fearless_simd::dispatch`], for large kernels: of the instructions of x86-64 only AVX-512, AVX2 and what all processors
/// have. Each is one more copy to compile, and the plain one that stands in for missing instructions takes LLVM's promotion of
/// variables minutes, which grows faster than a function's size.
#[doc(hidden)]
#[macro_export]
macro_rules! __dispatch_large {
    ($level:expr, $simd:pat => $kernel:expr) => {{
        #[cfg(target_arch = "x86_64")]
        {
            macro_rules! __with {
                ($token:expr) => {{
                    let token = $token;
                    let $simd = token;
                    ::fearless_simd::Simd::vectorize(
                        token,
                        #[inline(always)]
                        || $kernel,
                    )
                }};
            }
            match $level {
                ::fearless_simd::Level::Avx512(token) => __with!(token),
                ::fearless_simd::Level::Avx2(token) => __with!(token),
                level => match level.as_sse2().or_else(|| $crate::math::simd::level().as_sse2()) {
                    Some(token) => __with!(token),
                    None => unreachable!("every x86-64 has SSE2"),
                },
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            ::fearless_simd::dispatch!($level, $simd => $kernel)
        }
    }};
}

pub use crate::__dispatch_large as dispatch_large;

/// An instruction set to compute with.
#[derive(Debug, Clone, Copy)]
pub struct Width(pub Level);

impl Default for Width {
    fn default() -> Self {
        Self::best()
    }
}

impl Width {
    /// The widest that this processor has.
    #[must_use]
    pub fn best() -> Self {
        Self(Level::new())
    }

    /// No vector instructions: the reference for the others.
    #[must_use]
    pub fn scalar() -> Self {
        Self(Level::fallback())
    }

    /// The name under which stores record it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            level if level.is_fallback() => "scalar",
            #[cfg(target_arch = "aarch64")]
            Level::Neon(_) => "neon",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(_) => "avx512",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) => "avx2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse4_2(_) => "sse4.2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse2(_) => "sse2",
            _ => "simd128",
        }
    }

    /// Every width that this processor has, widest first.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let best = Level::new();
        let mut levels = vec![best];
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        levels.extend(
            [
                best.as_avx2().map(Level::Avx2),
                best.as_sse4_2().map(Level::Sse4_2),
                best.as_sse2().map(Level::Sse2),
            ]
            .into_iter()
            .flatten(),
        );
        levels.push(Level::fallback());
        let mut widths: Vec<Self> = levels.into_iter().map(Self).collect();
        widths.dedup_by_key(|width| width.name());
        widths
    }

    /// The width of this name, where the processor has it.
    ///
    /// # Errors
    /// An unknown name, or one that this processor lacks.
    pub fn named(name: &str) -> Result<Self> {
        let available = Self::available();
        available.iter().copied().find(|width| width.name() == name).ok_or_else(|| {
            let names: Vec<_> = available.iter().map(|width| width.name()).collect();
            let hint = did_you_mean(name, names.iter().copied());
            Error::input(format!(
                "SIMD width '{name}' is not one of this processor's: {}{hint}",
                names.join(", ")
            ))
        })
    }
}

/// A precision that kernels are written for.
pub trait Real: SimdFloatElement {
    /// Terms of the series of sin(x)/x − 1 over x², highest first, for |x| ≤ π/4.
    const SIN: &'static [f64];
    /// Terms of the series of (cos x − 1)/x², highest first, for |x| ≤ π/4.
    const COS: &'static [f64];
    /// Terms of e^{−y}, highest first, for y ≤ DECAY_END/2^DECAY_SQUARINGS, all signs positive.
    const EXP: &'static [f64];
    /// e^{−x} counts as e^{−DECAY_END} past it.
    const DECAY_END: f64;
    /// How often the series of a part of the exponent is squared.
    const DECAY_SQUARINGS: i32;
    /// 2π in parts whose products with whole numbers below 2^20 (2^10) are exact.
    const TWO_PI: [f64; 3];
    /// Smallest divisors that do not overflow.
    const TINY: f64;
    /// cosα of a direction that counts as grazing: products of several such numbers must not underflow.
    const GRAZING: f64;
    /// The nearest number of this precision.
    fn of(value: f64) -> Self;
    /// Its whole part; 0 for negative numbers.
    fn index(self) -> usize;
}

impl Real for f64 {
    const SIN: &'static [f64] = &[
        -1.0 / 1_307_674_368_000.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 39_916_800.0,
        1.0 / 362_880.0,
        -1.0 / 5040.0,
        1.0 / 120.0,
        -1.0 / 6.0,
    ];
    const COS: &'static [f64] = &[
        1.0 / 20_922_789_888_000.0,
        -1.0 / 87_178_291_200.0,
        1.0 / 479_001_600.0,
        -1.0 / 3_628_800.0,
        1.0 / 40_320.0,
        -1.0 / 720.0,
        1.0 / 24.0,
        -0.5,
    ];
    const EXP: &'static [f64] = &[
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ];
    const DECAY_END: f64 = 40.0;
    const DECAY_SQUARINGS: i32 = 7;
    const TWO_PI: [f64; 3] =
        [6.283_185_306_936_502_5, 2.430_840_202_521_586_4e-10, 8.089_064_995_183_803e-21];
    const TINY: f64 = 1e-150;
    const GRAZING: f64 = 1e-6;
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn index(self) -> usize {
        self as usize
    }
}

impl Real for f32 {
    const SIN: &'static [f64] = &[1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0];
    const COS: &'static [f64] = &[1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5];
    const EXP: &'static [f64] =
        &[1.0 / 40_320.0, 1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
    const DECAY_END: f64 = 20.0;
    const DECAY_SQUARINGS: i32 = 5;
    const TWO_PI: [f64; 3] = [6.2822265625, 0.0009586811065673828, 6.357301884918343e-08];
    const TINY: f64 = 1e-15;
    const GRAZING: f64 = 1e-3;
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn index(self) -> usize {
        self as usize
    }
}

/// A complex number per lane.
#[derive(Clone, Copy)]
pub struct Complex<V> {
    /// Real parts.
    pub re: V,
    /// Imaginary parts.
    pub im: V,
}

/// Arithmetic on lanes of reals, written for inlining into a dispatched kernel.
pub trait Lanes<S: Simd>: SimdFloat<S, Element: Real> {}
impl<S: Simd, V: SimdFloat<S, Element: Real>> Lanes<S> for V {}

impl<V: Copy> Complex<V> {
    /// self + other.
    #[inline(always)]
    #[must_use]
    pub fn plus<S: Simd>(self, other: Self) -> Self
    where
        V: Lanes<S>,
    {
        Self { re: self.re + other.re, im: self.im + other.im }
    }

    /// self − other.
    #[inline(always)]
    #[must_use]
    pub fn minus<S: Simd>(self, other: Self) -> Self
    where
        V: Lanes<S>,
    {
        Self { re: self.re - other.re, im: self.im - other.im }
    }

    /// self · other.
    #[inline(always)]
    #[must_use]
    pub fn times<S: Simd>(self, other: Self) -> Self
    where
        V: Lanes<S>,
    {
        Self {
            re: self.re.mul_sub(other.re, self.im * other.im),
            im: self.re.mul_add(other.im, self.im * other.re),
        }
    }

    /// self·a + b
    #[inline(always)]
    pub fn mul_add<S: Simd>(self, a: Self, b: Self) -> Self
    where
        V: Lanes<S>,
    {
        Self {
            re: (-self.im).mul_add(a.im, self.re.mul_add(a.re, b.re)),
            im: self.re.mul_add(a.im, self.im.mul_add(a.re, b.im)),
        }
    }

    /// Times a real number.
    #[inline(always)]
    #[must_use]
    pub fn scale<S: Simd>(self, factor: V) -> Self
    where
        V: Lanes<S>,
    {
        Self { re: self.re * factor, im: self.im * factor }
    }

    /// self / other.
    #[inline(always)]
    #[must_use]
    pub fn over<S: Simd>(self, other: Self) -> Self
    where
        V: Lanes<S>,
    {
        let norm = other.re.mul_add(other.re, other.im * other.im);
        Self {
            re: self.re.mul_add(other.re, self.im * other.im) / norm,
            im: self.im.mul_sub(other.re, self.re * other.im) / norm,
        }
    }
}

/// The same value in every lane. A function, not a closure: kernels need it inlined where their instructions are on.
#[inline(always)]
pub fn splat<S: Simd, V: Lanes<S>>(simd: S, value: f64) -> V {
    V::splat(simd, V::Element::of(value))
}

/// The lanes from position `at` on.
#[inline(always)]
pub fn load<S: Simd, V: Lanes<S>>(simd: S, values: &[V::Element], at: usize) -> V {
    V::from_slice(simd, &values[at..at + V::LEN])
}

/// A polynomial with these coefficients, highest first.
#[inline(always)]
fn polynomial<S: Simd, V: Lanes<S>>(simd: S, coefficients: &[f64], x: V) -> V {
    let mut sum: V = splat(simd, coefficients[0]);
    for &coefficient in &coefficients[1..] {
        sum = sum.mul_add(x, splat::<S, V>(simd, coefficient));
    }
    sum
}

/// sin and cos of each lane; absolute error for |x| ≤ 200 below 3e-15 in double, 2e-5 in single precision (the
/// rounding of x itself).
///
/// Reduction to [−π, π] in three parts (Cody & Waite 1980), Taylor series of a quarter of the angle, two
/// doublings.
#[inline(always)]
pub fn sin_cos<S: Simd, V: Lanes<S>>(simd: S, x: V) -> (V, V) {
    let one: V = splat(simd, 1.0);
    let turns = (x * splat::<S, V>(simd, std::f64::consts::FRAC_1_PI * 0.5)).round_ties_even();
    let mut r = x;
    for part in V::Element::TWO_PI {
        r = turns.mul_add(splat::<S, V>(simd, -part), r);
    }
    let r = r * splat::<S, V>(simd, 0.25);
    let z = r * r;
    let sin = (polynomial::<S, V>(simd, V::Element::SIN, z) * z).mul_add(r, r);
    // 1 − cos, which the doublings keep small where the angle is.
    let versine = -(polynomial::<S, V>(simd, V::Element::COS, z) * z);
    // sin 2a = 2 sin a cos a; 1 − cos 2a = 2 sin² a.
    let cos = one - versine;
    let half_sin_2 = sin * cos;
    let sin_2 = half_sin_2 + half_sin_2;
    let squared = sin * sin;
    let cos_2 = one - (squared + squared);
    let half_sin_4 = sin_2 * cos_2;
    let squared_2 = sin_2 * sin_2;
    (half_sin_4 + half_sin_4, one - (squared_2 + squared_2))
}

/// sin and cos of 2πx of each lane, from half the angle; absolute error below 2e-7 and that of x itself.
#[inline(always)]
pub fn turn<S: Simd>(simd: S, x: S::f32s) -> (S::f32s, S::f32s) {
    let r = x - x.round_ties_even();
    let z = r * r;
    // 2 sin πr and cos πr, interpolated at Chebyshev points of r².
    let twice_sin = polynomial::<S, S::f32s>(simd, TWICE_SIN, z) * r;
    let cos = polynomial::<S, S::f32s>(simd, COS_HALF, z);
    let half: S::f32s = splat(simd, -0.5);
    (twice_sin * cos, (twice_sin * twice_sin).mul_add(half, splat::<S, S::f32s>(simd, 1.0)))
}

/// 2 sin(πr)/r over r², highest first, for |r| ≤ 1/2: 2.7e-8.
const TWICE_SIN: &[f64] = &[
    0.155_315_320_617_039_2,
    -1.196_582_571_243_090_2,
    5.100_155_046_429_394,
    -10.335_420_167_015_783,
    6.283_185_280_261_416,
];

/// cos(πr) over r², highest first, for |r| ≤ 1/2: 4.7e-8.
const COS_HALF: &[f64] = &[
    0.219_689_611_097_467_54,
    -1.331_876_568_080_326,
    4.058_411_352_862_426,
    -4.934_792_830_619_63,
    0.999_999_953_247_608_5,
];

/// e^{−x} of each lane for x ≥ 0; relative error below 3e-14 in double, 2e-6 in single precision; what is below e^{−40}
/// (e^{−20}) counts as that.
#[inline(always)]
pub fn decay<S: Simd, V: Lanes<S>>(simd: S, x: V) -> V {
    let squarings = V::Element::DECAY_SQUARINGS;
    let y = x.min(splat::<S, V>(simd, V::Element::DECAY_END)) * splat::<S, V>(simd, 0.5f64.powi(squarings));
    let mut sum = slight_decay(simd, y);
    for _ in 0..squarings {
        sum = sum * sum;
    }
    sum
}

/// Up to here a decay is slight.
pub const SLIGHT: f32 = 0.625;

/// e^{−x} of each lane for 0 ≤ x ≤ [`SLIGHT`] (half of it in double precision); relative error as [`decay`].
#[inline(always)]
pub fn slight_decay<S: Simd, V: Lanes<S>>(simd: S, x: V) -> V {
    polynomial::<S, V>(simd, V::Element::EXP, -x)
}

/// The principal root of re + j·im for im ≥ 0, so that both parts of the root are ≥ 0.
#[inline(always)]
pub fn root<S: Simd, V: Lanes<S>>(simd: S, z: Complex<V>) -> Complex<V> {
    let half: V = splat(simd, 0.5);
    let norm = z.re.mul_add(z.re, z.im * z.im).sqrt();
    let large = ((norm + z.re.abs()) * half).sqrt().max(splat::<S, V>(simd, V::Element::TINY));
    let small = z.im * half / large;
    let forward = z.re.simd_ge(splat::<S, V>(simd, 0.0));
    Complex { re: forward.select(large, small), im: forward.select(small, large) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::dispatch;

    #[inline(always)]
    fn evaluate<S: Simd>(simd: S, x: &[f64]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let lanes = S::f64s::LEN;
        let mut results = (vec![0.0; x.len()], vec![0.0; x.len()], vec![0.0; x.len()]);
        for start in (0..x.len()).step_by(lanes) {
            let v = S::f64s::from_slice(simd, &x[start..start + lanes]);
            let (sin, cos) = sin_cos::<S, S::f64s>(simd, v);
            sin.store_slice(&mut results.0[start..start + lanes]);
            cos.store_slice(&mut results.1[start..start + lanes]);
            decay::<S, S::f64s>(simd, v.abs()).store_slice(&mut results.2[start..start + lanes]);
        }
        results
    }

    #[test]
    fn elementary_functions_match_libm_at_every_width() {
        let x: Vec<f64> = (0..4000).map(|i| (f64::from(i) - 2000.0) * 0.1 + 1e-3).collect();
        for width in Width::available() {
            let (sin, cos, decay) = dispatch!(width.0, simd => evaluate(simd, &x));
            for (i, &v) in x.iter().enumerate() {
                assert!(
                    (sin[i] - libm::sin(v)).abs() < 3e-15,
                    "{} sin {v}: {}",
                    width.name(),
                    sin[i] - libm::sin(v)
                );
                assert!((cos[i] - libm::cos(v)).abs() < 3e-15, "{} cos {v}", width.name());
                if v.abs() < 39.0 {
                    let exact = libm::exp(-v.abs());
                    assert!(
                        (decay[i] - exact).abs() < 3e-14 * exact,
                        "{} exp {v}: {}",
                        width.name(),
                        decay[i] / exact
                    );
                }
            }
        }
    }

    #[inline(always)]
    fn evaluate_single<S: Simd>(simd: S, x: &[f32]) -> Vec<(f32, f32, f32)> {
        let mut results = Vec::new();
        for chunk in x.chunks_exact(S::f32s::LEN) {
            let v = S::f32s::from_slice(simd, chunk);
            let (sin, cos) = sin_cos::<S, S::f32s>(simd, v);
            let decay = decay::<S, S::f32s>(simd, v.abs());
            results.extend((0..S::f32s::LEN).map(|i| (sin[i], cos[i], decay[i])));
        }
        results
    }

    #[test]
    fn single_precision_functions_are_as_good_as_their_arguments() {
        let x: Vec<f32> = (0..4096).map(|i| (i as f32 - 2048.0) * 0.09).collect();
        for width in Width::available() {
            let results = dispatch!(width.0, simd => evaluate_single(simd, &x));
            for (&v, (sin, cos, decay)) in x.iter().zip(results) {
                let v = f64::from(v);
                assert!((f64::from(sin) - v.sin()).abs() < 2e-6, "{} {v}", width.name());
                assert!((f64::from(cos) - v.cos()).abs() < 2e-6, "{} {v}", width.name());
                if v.abs() < 19.0 {
                    assert!(
                        (f64::from(decay) / (-v.abs()).exp() - 1.0).abs() < 6e-6,
                        "{} {v} {decay}",
                        width.name()
                    );
                }
            }
        }
    }

    #[test]
    fn widths_are_found_by_name() {
        assert_eq!(Width::named("scalar").unwrap().name(), "scalar");
        assert!(Width::named("avx1024").unwrap_err().to_string().contains("not one of this processor's"));
    }
}
