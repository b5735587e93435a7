//! Student's t distribution, for confidence intervals of few values.

use std::f64::consts::FRAC_2_PI;

/// The t that a variable of so many degrees of freedom stays within, ±t, with this probability; infinite without any freedom.
///
/// By bisection on the finite series for whole degrees of freedom (Abramowitz & Stegun 26.7.3, 26.7.4), to 1e-12.
///
/// # Panics
/// The probability is not within (0, 1).
#[must_use]
pub fn two_sided_t(probability: f64, freedom: usize) -> f64 {
    assert!(probability > 0.0 && probability < 1.0, "a probability of {probability}");
    if freedom == 0 {
        return f64::INFINITY;
    }
    // θ = atan(t/√ν), from 0 to π/2.
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    while high - low > 1e-15 {
        let mid = 0.5 * (low + high);
        if mid <= low || mid >= high {
            break;
        }
        if within(mid, freedom) < probability { low = mid } else { high = mid }
    }
    libm::tan(0.5 * (low + high)) * (freedom as f64).sqrt()
}

/// P(|T| < √ν tanθ).
fn within(theta: f64, freedom: usize) -> f64 {
    let (sin, cos) = libm::sincos(theta);
    let odd = freedom % 2 == 1;
    let mut term = if odd { cos } else { 1.0 };
    let mut sum = 0.0;
    let mut k = if odd { 3 } else { 2 };
    while k <= freedom {
        sum += term;
        let j = k as f64;
        term *= cos * cos * (j - 1.0) / j;
        k += 2;
    }
    if odd { FRAC_2_PI * (theta + sin * sum) } else { sin * sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun, table 26.10.
        for (freedom, t) in
            [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (10, 2.228), (29, 2.045), (120, 1.980)]
        {
            assert!(
                (two_sided_t(0.95, freedom) - t).abs() < 6e-4,
                "{freedom}: {}",
                two_sided_t(0.95, freedom)
            );
        }
        assert!((two_sided_t(0.99, 5) - 4.032).abs() < 6e-4);
        assert!(two_sided_t(0.95, 0).is_infinite());
    }
}
