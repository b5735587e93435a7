//! Cylinder functions J_n and H_n⁽¹⁾ of complex argument, all orders at once.

use num_complex::Complex64;

use crate::{Error, Result};

/// J_n(z) and H_n⁽¹⁾(z) for n = 0 … n_max.
#[derive(Debug, Clone, Default)]
pub struct Cylinder {
    /// J_n(z).
    pub j: Vec<Complex64>,
    /// H_n⁽¹⁾(z).
    pub h: Vec<Complex64>,
}

impl Cylinder {
    /// Both kinds at z (Im z ≥ 0, z ≠ 0) up to order `n_max` ≥ 1.
    ///
    /// J_n/J_{n−1} comes from the backward recurrence 1/(2n/z − J_{n+1}/J_n) (Miller), H_n from the forward one, and
    /// the Wronskian J₁H₀ − J₀H₁ = 2j/(πz) ties J to H (DLMF 10.5.5, 10.6.1, 10.74).
    ///
    /// # Errors
    /// z is out of the range of the Hankel functions, or an order leaves the range of doubles.
    pub fn new(z: Complex64, n_max: usize) -> Result<Self> {
        let failed = || {
            Error::not_settled(format!(
                "cylinder functions of {z} up to order {n_max} leave the range of numbers"
            ))
        };
        let h0 = complex_bessel::hankel1(0.0, z).map_err(|_| failed())?;
        let h1 = complex_bessel::hankel1(1.0, z).map_err(|_| failed())?;
        let mut h = Vec::with_capacity(n_max + 1);
        h.extend([h0, h1]);
        let two_over_z = 2.0 / z;
        for n in 1..n_max {
            let next = two_over_z * n as f64 * h[n] - h[n - 1];
            h.push(next);
        }
        let size = (n_max as f64).max(z.norm());
        let start = (size + 25.0 + 5.0 * size.cbrt()) as usize;
        let mut ratio = Complex64::new(0.0, 0.0);
        let mut j = vec![ratio; n_max + 1];
        for n in (1..=start).rev() {
            let below = two_over_z * n as f64 - ratio;
            ratio = if below.norm_sqr() > 0.0 { below.inv() } else { Complex64::new(1e150, 0.0) };
            if n <= n_max {
                j[n] = ratio;
            }
        }
        j[0] = Complex64::i() * std::f64::consts::FRAC_2_PI / (z * (j[1] * h0 - h1));
        for n in 1..=n_max {
            j[n] = j[n - 1] * j[n];
        }
        let finite = j[0].is_finite() && h[n_max].is_finite();
        if finite { Ok(Self { j, h }) } else { Err(failed()) }
    }
}

/// H₀⁽¹⁾(z) and H₁⁽¹⁾(z) times e^{−jz} (Im z ≥ 0, z ≠ 0): they neither oscillate nor vanish far out.
///
/// # Errors
/// z is out of the range of the Hankel functions.
pub fn hankel_scaled(z: Complex64) -> Result<[Complex64; 2]> {
    let of = |order: f64| {
        complex_bessel::hankel1_scaled(order, z)
            .map_err(|_| Error::not_settled(format!("Hankel functions of {z} leave the range of numbers")))
    };
    Ok([of(0.0)?, of(1.0)?])
}

/// j^n.
#[must_use]
pub fn power_of_j(n: usize) -> Complex64 {
    match n % 4 {
        0 => Complex64::new(1.0, 0.0),
        1 => Complex64::new(0.0, 1.0),
        2 => Complex64::new(-1.0, 0.0),
        _ => Complex64::new(0.0, -1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_agree_with_the_bessel_crate() {
        for z in [
            Complex64::new(1.3, 0.0),
            Complex64::new(0.02, 1e-4),
            Complex64::new(2.404_825_557_695_773, 0.0),
            Complex64::new(7.0, 3.0),
            Complex64::new(0.1, 12.0),
            Complex64::new(40.0, 0.2),
        ] {
            let both = Cylinder::new(z, 24).unwrap();
            for n in 0..=24 {
                let j = complex_bessel::besselj(n as f64, z).unwrap();
                let h = complex_bessel::hankel1(n as f64, z).unwrap();
                let near = if n == 0 { both.j[1] } else { both.j[n - 1] };
                assert!((both.j[n] - j).norm() <= 1e-13 * (j.norm() + near.norm().min(1.0)), "J_{n}({z})");
                assert!((both.h[n] - h).norm() <= 1e-13 * h.norm(), "H_{n}({z})");
            }
        }
    }
}
