//! Elementary functions without branches or calls, for one number or eight at once, with the same bits either way and on
//! every machine. Each is within a few units in the last place of the exact value, which tests hold against `libm`.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LOG2_E, PI, TAU};

use fearless_simd::{Simd, f64x8, prelude::*, u64x8};

/// Adding and subtracting it rounds to whole numbers, which then stand in the last bits: 1.5 · 2⁵².
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// ln 2 in two parts; the first has zeros at its end, so that whole multiples of it are exact.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// e^x within 4e-16 of itself for −708 ≤ x ≤ 709; beyond, the value at the nearer end.
#[inline(always)]
#[must_use]
pub fn exp(x: f64) -> f64 {
    let x = x.clamp(-708.0, 709.0);
    let shifted = x * LOG2_E + ROUNDER;
    let whole = shifted - ROUNDER;
    let r = (x - whole * LN_2_HIGH) - whole * LN_2_LOW;
    // Σ r^k/k!, |r| ≤ ln 2 / 2.
    let mut sum = 1.0 / 479_001_600.0;
    sum = sum * r + 1.0 / 39_916_800.0;
    sum = sum * r + 1.0 / 3_628_800.0;
    sum = sum * r + 1.0 / 362_880.0;
    sum = sum * r + 1.0 / 40_320.0;
    sum = sum * r + 1.0 / 5_040.0;
    sum = sum * r + 1.0 / 720.0;
    sum = sum * r + 1.0 / 120.0;
    sum = sum * r + 1.0 / 24.0;
    sum = sum * r + 1.0 / 6.0;
    sum = sum * r + 0.5;
    sum = sum * r + 1.0;
    sum = sum * r + 1.0;
    // The whole number's bits become the exponent: below 1024 in modulus, so that two's complement and bias meet.
    let exponent = shifted.to_bits().wrapping_sub(ROUNDER.to_bits() - 1023);
    sum * f64::from_bits(exponent << 52)
}

/// [`exp`] of each lane.
#[inline(always)]
#[must_use]
pub fn exp_each<S: Simd>(simd: S, x: f64x8<S>) -> f64x8<S> {
    let all = |v: f64| f64x8::splat(simd, v);
    let x = x.max(all(-708.0)).min(all(709.0));
    let shifted = x * all(LOG2_E) + all(ROUNDER);
    let whole = shifted - all(ROUNDER);
    let r = (x - whole * all(LN_2_HIGH)) - whole * all(LN_2_LOW);
    let mut sum = all(1.0 / 479_001_600.0);
    sum = sum * r + all(1.0 / 39_916_800.0);
    sum = sum * r + all(1.0 / 3_628_800.0);
    sum = sum * r + all(1.0 / 362_880.0);
    sum = sum * r + all(1.0 / 40_320.0);
    sum = sum * r + all(1.0 / 5_040.0);
    sum = sum * r + all(1.0 / 720.0);
    sum = sum * r + all(1.0 / 120.0);
    sum = sum * r + all(1.0 / 24.0);
    sum = sum * r + all(1.0 / 6.0);
    sum = sum * r + all(0.5);
    sum = sum * r + all(1.0);
    sum = sum * r + all(1.0);
    let exponent = shifted.bitcast::<u64x8<S>>() - u64x8::splat(simd, ROUNDER.to_bits() - 1023);
    sum * (exponent << 52).bitcast::<f64x8<S>>()
}

/// The bits of √½: numbers are m 2^e with m from there to √2.
const LEAST_MANTISSA: u64 = 0x3fe6_a09e_667f_3bcd;
/// The bits of 2⁵², whose last bits are whole numbers.
const WHOLE: u64 = 0x4330_0000_0000_0000;
const MANTISSA: u64 = 0x000f_ffff_ffff_ffff;

/// ln x within 4e-16 of max(1, |ln x|) for normal x over 0.
#[inline(always)]
#[must_use]
pub fn ln(x: f64) -> f64 {
    let bits = x.to_bits().wrapping_sub(LEAST_MANTISSA.wrapping_sub(1023 << 52));
    let e = f64::from_bits((bits >> 52) | WHOLE) - (f64::from_bits(WHOLE) + 1023.0);
    let m = f64::from_bits((bits & MANTISSA).wrapping_add(LEAST_MANTISSA));
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let mut sum = 1.0 / 19.0;
    sum = sum * s2 + 1.0 / 17.0;
    sum = sum * s2 + 1.0 / 15.0;
    sum = sum * s2 + 1.0 / 13.0;
    sum = sum * s2 + 1.0 / 11.0;
    sum = sum * s2 + 1.0 / 9.0;
    sum = sum * s2 + 1.0 / 7.0;
    sum = sum * s2 + 1.0 / 5.0;
    sum = sum * s2 + 1.0 / 3.0;
    let twice = s + s;
    e * LN_2_HIGH + (twice * s2 * sum + (twice + e * LN_2_LOW))
}

/// Sine and cosine of a number of turns, within 3e-16, for moduli below 10⁹.
#[inline(always)]
#[must_use]
pub fn sin_cos_turns(turns: f64) -> [f64; 2] {
    // The nearest quarter of a turn, and the angle from it, at most π/4.
    let shifted = 4.0 * turns + ROUNDER;
    let quarter = shifted.to_bits();
    let a = TAU * (turns - 0.25 * (shifted - ROUNDER));
    let a2 = a * a;
    let mut sin = 1.0 / 1_307_674_368_000.0;
    sin = -sin * a2 + 1.0 / 6_227_020_800.0;
    sin = -sin * a2 + 1.0 / 39_916_800.0;
    sin = -sin * a2 + 1.0 / 362_880.0;
    sin = -sin * a2 + 1.0 / 5_040.0;
    sin = -sin * a2 + 1.0 / 120.0;
    sin = -sin * a2 + 1.0 / 6.0;
    let sin = a - a * a2 * sin;
    let mut cos = 1.0 / 20_922_789_888_000.0;
    cos = -cos * a2 + 1.0 / 87_178_291_200.0;
    cos = -cos * a2 + 1.0 / 479_001_600.0;
    cos = -cos * a2 + 1.0 / 3_628_800.0;
    cos = -cos * a2 + 1.0 / 40_320.0;
    cos = -cos * a2 + 1.0 / 720.0;
    cos = -cos * a2 + 1.0 / 24.0;
    let cos = 1.0 - a2 * (0.5 - a2 * cos);
    let (sin, cos) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    // A quarter turn on, the sine is the cosine and the cosine the negative sine.
    let sin = f64::from_bits(sin.to_bits() ^ ((quarter & 2) << 62));
    let cos = f64::from_bits(cos.to_bits() ^ ((quarter.wrapping_add(1) & 2) << 62));
    [sin, cos]
}

/// The angle of a point from +x towards +y, −π … π, within 1e-15; 0 for the origin.
#[inline(always)]
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    let (long, short) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
    // tan(π/8): what is steeper is turned back by an eighth of a turn.
    let is_steep = short > 0.414_213_562_373_095_03 * long;
    let (over, under) = if is_steep { (short - long, short + long) } else { (short, long) };
    let t = over / under.max(f64::MIN_POSITIVE);
    let t2 = t * t;
    let t4 = t2 * t2;
    // Σ (−1)^k t^(2k)/(2k + 1), in steps of t⁴: even and odd k apart, so that they wait less for each other.
    let mut even = 1.0 / 33.0;
    even = even * t4 + 1.0 / 29.0;
    even = even * t4 + 1.0 / 25.0;
    even = even * t4 + 1.0 / 21.0;
    even = even * t4 + 1.0 / 17.0;
    even = even * t4 + 1.0 / 13.0;
    even = even * t4 + 1.0 / 9.0;
    even = even * t4 + 1.0 / 5.0;
    even = even * t4 + 1.0;
    let mut odd = 1.0 / 35.0;
    odd = odd * t4 + 1.0 / 31.0;
    odd = odd * t4 + 1.0 / 27.0;
    odd = odd * t4 + 1.0 / 23.0;
    odd = odd * t4 + 1.0 / 19.0;
    odd = odd * t4 + 1.0 / 15.0;
    odd = odd * t4 + 1.0 / 11.0;
    odd = odd * t4 + 1.0 / 7.0;
    odd = odd * t4 + 1.0 / 3.0;
    let angle = t * (even - t2 * odd) + if is_steep { FRAC_PI_4 } else { 0.0 };
    let angle = if y.abs() > x.abs() { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    angle.copysign(y)
}

/// What [`atan2_rough`] is right to.
pub const ROUGH: f64 = 1.2e-5;

/// As [`atan2`], within [`ROUGH`] (Abramowitz and Stegun 1964, 4.4.49), in a quarter of the time.
#[inline(always)]
#[must_use]
pub fn atan2_rough(y: f64, x: f64) -> f64 {
    let (long, short) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
    let t = short / long.max(f64::MIN_POSITIVE);
    let t2 = t * t;
    let sum = (0.020_835_1 * t2 - 0.085_133_0) * t2 + 0.180_141_0;
    let angle = t * ((sum * t2 - 0.330_299_5) * t2 + 0.999_866_0);
    let angle = if y.abs() > x.abs() { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    angle.copysign(y)
}

/// Arc sine of −1 … 1, within 2e-15.
#[inline(always)]
#[must_use]
pub fn asin(x: f64) -> f64 {
    atan2(x, ((1.0 - x) * (1.0 + x)).max(0.0).sqrt())
}

/// Eight times [`asin`].
#[inline(always)]
pub fn asin_each<S: Simd>(simd: S, x: f64x8<S>) -> f64x8<S> {
    let all = |v: f64| f64x8::splat(simd, v);
    let cos = ((all(1.0) - x) * (all(1.0) + x)).max(all(0.0)).sqrt();
    let sin = x.abs();
    let (long, short) = (cos.max(sin), cos.min(sin));
    let is_steep = short.simd_gt(all(0.414_213_562_373_095_03) * long);
    let over = is_steep.select(short - long, short);
    let under = is_steep.select(short + long, long);
    let t = over / under.max(all(f64::MIN_POSITIVE));
    let t2 = t * t;
    let t4 = t2 * t2;
    let even = all(1.0 / 33.0) * t4 + all(1.0 / 29.0);
    let even = even * t4 + all(1.0 / 25.0);
    let even = even * t4 + all(1.0 / 21.0);
    let even = even * t4 + all(1.0 / 17.0);
    let even = even * t4 + all(1.0 / 13.0);
    let even = even * t4 + all(1.0 / 9.0);
    let even = even * t4 + all(1.0 / 5.0);
    let even = even * t4 + all(1.0);
    let odd = all(1.0 / 35.0) * t4 + all(1.0 / 31.0);
    let odd = odd * t4 + all(1.0 / 27.0);
    let odd = odd * t4 + all(1.0 / 23.0);
    let odd = odd * t4 + all(1.0 / 19.0);
    let odd = odd * t4 + all(1.0 / 15.0);
    let odd = odd * t4 + all(1.0 / 11.0);
    let odd = odd * t4 + all(1.0 / 7.0);
    let odd = odd * t4 + all(1.0 / 3.0);
    let angle = t * (even - t2 * odd) + is_steep.select(all(FRAC_PI_4), all(0.0));
    let angle = sin.simd_gt(cos).select(all(FRAC_PI_2) - angle, angle);
    angle.copysign(x)
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::math::rng::Stream;
    use crate::math::simd::Width;

    #[test]
    fn exponentials_are_those_of_libm() {
        let mut stream = Stream::new(71, &[]);
        for k in 0..20_000 {
            let x = if k % 2 == 0 { stream.uniform(-708.0, 709.0) } else { stream.uniform(-2.0, 2.0) };
            assert!((exp(x) / libm::exp(x) - 1.0).abs() < 4.5e-16, "{x}");
        }
        assert_eq!((exp(0.0), exp(-1e9), exp(1e9)), (1.0, exp(-708.0), exp(709.0)));
    }

    #[test]
    fn logarithms_are_those_of_libm() {
        let mut stream = Stream::new(72, &[]);
        for _ in 0..20_000 {
            let x = libm::exp(stream.uniform(-700.0, 700.0));
            assert!((ln(x) - libm::log(x)).abs() < 4.5e-16 * libm::log(x).abs().max(1.0), "{x}");
            let x = stream.uniform(0.4, 2.5);
            assert!((ln(x) - libm::log(x)).abs() < 4.5e-16, "{x}");
        }
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn eight_at_once_are_as_one_at_every_width() {
        let mut stream = Stream::new(75, &[]);
        for _ in 0..200 {
            let x: [f64; 8] = std::array::from_fn(|_| stream.uniform(-800.0, 800.0));
            let z = x.map(|x| (0.01 * x).clamp(-1.0, 1.0));
            for Width(level) in Width::available() {
                let found = dispatch!(level, simd => exp_each(simd, f64x8::from_slice(simd, &x)).to_array());
                assert_eq!(found.map(f64::to_bits), x.map(|x| exp(x).to_bits()));
                let found = dispatch!(level, simd => asin_each(simd, f64x8::from_slice(simd, &z)).to_array());
                assert_eq!(found.map(f64::to_bits), z.map(|z| asin(z).to_bits()));
            }
        }
    }

    #[test]
    fn sines_and_cosines_are_those_of_libm() {
        let mut stream = Stream::new(73, &[]);
        for _ in 0..20_000 {
            let turns = stream.uniform(-0.5, 0.5);
            let [sin, cos] = sin_cos_turns(turns);
            assert!((sin - libm::sin(TAU * turns)).abs() < 5e-16, "{turns}");
            assert!((cos - libm::cos(TAU * turns)).abs() < 5e-16, "{turns}");
            assert!((sin_cos_turns(turns + 3.0)[0] - sin).abs() < 3e-15);
        }
        assert_eq!(sin_cos_turns(0.25), [1.0, 0.0]);
        assert_eq!(sin_cos_turns(-0.5).map(f64::abs), [0.0, 1.0]);
        assert_eq!(sin_cos_turns(0.5)[1], -1.0);
    }

    #[test]
    fn angles_are_those_of_libm() {
        let mut stream = Stream::new(74, &[]);
        for _ in 0..20_000 {
            let (y, x) = (stream.normal(), stream.normal());
            assert!((atan2(y, x) - libm::atan2(y, x)).abs() < 1e-15, "{y} {x}");
            assert!((atan2_rough(y, x) - libm::atan2(y, x)).abs() < ROUGH, "{y} {x}");
            let s = stream.uniform(-1.0, 1.0);
            assert!((asin(s) - libm::asin(s)).abs() < 2e-15, "{s}");
        }
        for (y, x) in [(0.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (-1.0, -1.0)]
        {
            assert!((atan2(y, x) - libm::atan2(y, x)).abs() < 1e-15, "{y} {x}");
        }
        assert_eq!((asin(1.0), asin(-1.0)), (FRAC_PI_2, -FRAC_PI_2));
    }
}
