//! One rod: its T-matrix in cylindrical waves with k_y ≠ 0, and the power that enters it.

use num_complex::Complex64;

use super::Wave;
use super::orders::Pair;
use crate::math::bessel::Cylinder;
use crate::math::roots::decaying_root;
use crate::solve::crystal::Shell;
use crate::{Error, Result};

/// Everything of one kind of rod that depends on wavelength and k_y alone.
///
/// Around a rod (E_y, H̃_y) = Σ_n (a_n J_{|n|}(κρ) + b_n H_{|n|}(κρ)) e^{jnϑ}, with x = ρ cosϑ, z = ρ sinϑ. Unknowns are
/// scaled with s_n = |H_n(κr)|, r the outer radius: â = a/s, b̂ = b·s, so that matrices stay of order one at any n.
#[derive(Debug, Clone)]
pub(super) struct RodTable {
    pub(super) radius: f64,
    /// 1/s_n, n = 0 … M.
    pub(super) inverse_scale: Vec<f64>,
    /// b̂_n = t_n â_n for n ≥ 0; the off-diagonal elements change their sign with n.
    pub(super) t: Vec<Pair>,
    /// s_n J_n, s_n κJ_n′, H_n/s_n, κH_n′/s_n at the outer radius.
    outer: Vec<[Complex64; 4]>,
}

/// Solutions of one order at one radius, J times and H over s = |H_n|, so that T is of order one for any n.
#[derive(Clone, Copy)]
struct Functions {
    j: Complex64,
    dj: Complex64,
    h: Complex64,
    dh: Complex64,
    s: f64,
}

impl Functions {
    /// Order n at radius ρ; derivatives with respect to ρ.
    fn at(table: &Cylinder, n: usize, kappa: Complex64) -> Self {
        let slope = |f: &[Complex64]| if n == 0 { -f[1] } else { (f[n - 1] - f[n + 1]) * 0.5 } * kappa;
        let s = table.h[n].norm();
        Self { j: table.j[n] * s, dj: slope(&table.j) * s, h: table.h[n] / s, dh: slope(&table.h) / s, s }
    }
}

/// Multiplies 2×2 matrices.
fn product(a: &Pair, b: &Pair) -> Pair {
    let element = |i: usize, k: usize| a[i][0] * b[0][k] + a[i][1] * b[1][k];
    [[element(0, 0), element(0, 1)], [element(1, 0), element(1, 1)]]
}

/// The inverse of a 2×2 matrix.
fn inverse(a: &Pair) -> Pair {
    let scale = (a[0][0] * a[1][1] - a[0][1] * a[1][0]).inv();
    [[a[1][1] * scale, -a[0][1] * scale], [-a[1][0] * scale, a[0][0] * scale]]
}

/// Scaled T of what lies within `radius` as seen from a medium (`kappa`, `eps`) outside, given the fields just inside: from
/// continuity of E_y, H̃_y and of E_ϑ = (j/κ²)(jnk_y/ρ E_y + k₀∂_ρH̃_y), H̃_ϑ = (j/κ²)(jnk_y/ρ H̃_y − k₀ε∂_ρE_y).
fn across(
    wave: &Wave,
    n: usize,
    radius: f64,
    inside: (Functions, Complex64, Complex64),
    t_inside: &Pair,
    outside: (Functions, Complex64, Complex64),
) -> Pair {
    let zero = Complex64::new(0.0, 0.0);
    let (fi, kappa2_in, eps_in) = inside;
    let (fo, kappa2, eps) = outside;
    let turn = Complex64::new(0.0, n as f64 * wave.ky / radius);
    let (mut a, mut b) = ([[zero; 2]; 2], [[zero; 2]; 2]);
    for column in 0..2 {
        let unit = [f64::from(u8::from(column == 0)), f64::from(u8::from(column == 1))];
        let value = |i: usize| fi.j * unit[i] + fi.h * t_inside[i][column];
        let slope = |i: usize| fi.dj * unit[i] + fi.dh * t_inside[i][column];
        let (e, h) = (value(0), value(1));
        let along_e = (turn * e + wave.k0 * slope(1)) / kappa2_in;
        let along_h = (turn * h - wave.k0 * eps_in * slope(0)) / kappa2_in;
        let dh = (kappa2 * along_e - turn * e) / wave.k0;
        let de = (turn * h - kappa2 * along_h) / (wave.k0 * eps);
        // the Wronskian is common to a and b
        for (i, (f, df)) in [(e, de), (h, dh)].into_iter().enumerate() {
            a[i][column] = f * fo.dh - df * fo.h;
            b[i][column] = df * fo.j - f * fo.dj;
        }
    }
    product(&b, &inverse(&a))
}

impl RodTable {
    /// Tables up to order `m` for concentric circles in the host.
    ///
    /// # Errors
    /// Cylinder functions leave the range of numbers.
    pub(super) fn new(wave: &Wave, shells: &[Shell], m: usize) -> Result<Self> {
        let kappa2_of = |eps: Complex64| {
            let kappa2 = wave.k0 * wave.k0 * (eps - wave.eps0) + wave.kappa0 * wave.kappa0;
            let least = 1e-14 * wave.k0 * wave.k0;
            if kappa2.norm() < least { Complex64::new(least, 0.0) } else { kappa2 }
        };
        let media: Vec<(Complex64, Complex64)> = std::iter::once((wave.eps, wave.kappa * wave.kappa))
            .chain(shells.iter().map(|shell| (shell.eps, kappa2_of(shell.eps))))
            .collect();
        // functions at circle i on its outer and on its inner side
        let mut sides = Vec::new();
        for (i, shell) in shells.iter().enumerate() {
            let radius = shell.diameter_um * 0.5;
            let [outer, inner] = [media[i], media[i + 1]].map(|(_, kappa2)| decaying_root(kappa2));
            sides.push((
                radius,
                Cylinder::new(outer * radius, m + 1)?,
                outer,
                Cylinder::new(inner * radius, m + 1)?,
                inner,
            ));
        }
        let radius = shells[0].diameter_um * 0.5;
        let mut rod = Self { radius, inverse_scale: Vec::new(), t: Vec::new(), outer: Vec::new() };
        for n in 0..=m {
            let mut t = [[Complex64::new(0.0, 0.0); 2]; 2];
            let mut scale = f64::INFINITY;
            for (i, (radius, outer, kappa_out, inner, kappa_in)) in sides.iter().enumerate().rev() {
                let ((eps_out, kappa2_out), (eps_in, kappa2_in)) = (media[i], media[i + 1]);
                let inside = (Functions::at(inner, n, *kappa_in), kappa2_in, eps_in);
                let outside = (Functions::at(outer, n, *kappa_out), kappa2_out, eps_out);
                // T is that of the circle within, its scale that of this radius; nothing scatters within the innermost
                let ratio = (inside.0.s / scale).powi(2);
                t = across(wave, n, *radius, inside, &t.map(|row| row.map(|x| x * ratio)), outside);
                scale = outside.0.s;
                if i == 0 {
                    let f = outside.0;
                    rod.outer.push([f.j, f.dj, f.h, f.dh]);
                }
            }
            rod.inverse_scale.push(scale.recip());
            rod.t.push(t);
        }
        if rod.t.iter().flatten().flatten().all(|x| x.is_finite()) {
            Ok(rod)
        } else {
            Err(Error::not_settled(format!(
                "the scattering of a rod of radius {radius} µm leaves the range of numbers"
            )))
        }
    }

    /// The highest order M.
    pub(super) fn m(&self) -> usize {
        self.t.len() - 1
    }

    /// b̂ of one order, n of either sign.
    pub(super) fn scattered(&self, n: i32, a: [Complex64; 2]) -> [Complex64; 2] {
        let t = &self.t[n.unsigned_abs() as usize];
        let sign = if n < 0 { -1.0 } else { 1.0 };
        [t[0][0] * a[0] + t[0][1] * a[1] * sign, t[1][0] * a[0] * sign + t[1][1] * a[1]]
    }

    /// Σ|â b̂| over the orders beyond the last on either side, E or H̃, from the last two as in a geometric series.
    pub(super) fn beyond(&self, a: &[[Complex64; 2]]) -> f64 {
        let m = self.m() as i32;
        let size = |n: i32| {
            let a = a[(n + m) as usize];
            let b = self.scattered(n, a);
            let norm = |v: [Complex64; 2]| v[0].norm_sqr().max(v[1].norm_sqr());
            (norm(a) * norm(b)).sqrt()
        };
        series(size(m), size(m - 1)) + series(size(-m), size(1 - m))
    }

    /// Power that enters one order's fields through the rod's surface, per length, over ½: −∮Re(E×H̃*)_ρ with
    /// (E×H̃*)_ρ = E_y H̃_ϑ* − E_ϑ H̃_y*.
    pub(super) fn power_in(&self, wave: &Wave, n: i32, a: [Complex64; 2]) -> f64 {
        let [j, dj, h, dh] = self.outer[n.unsigned_abs() as usize];
        let b = self.scattered(n, a);
        let [e, hy] = [0, 1].map(|i| a[i] * j + b[i] * h);
        let [de, dhy] = [0, 1].map(|i| a[i] * dj + b[i] * dh);
        let turn = Complex64::new(0.0, f64::from(n) * wave.ky / self.radius);
        let scale = Complex64::i() / (wave.kappa * wave.kappa);
        let around_e = scale * (turn * e + wave.k0 * dhy);
        let around_h = scale * (turn * hy - wave.k0 * wave.eps * de);
        -std::f64::consts::TAU * self.radius * (e * around_h.conj() - around_e * hy.conj()).re
    }
}

/// Sum of what follows the last term of a series that falls by last/before, taken between 0.1 and 0.7.
pub(super) fn series(last: f64, before: f64) -> f64 {
    let ratio = if before > 0.0 { (last / before).clamp(0.1, 0.7) } else { 0.1 };
    last * ratio / (1.0 - ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(theta: f64) -> Wave {
        let (k0, eps) = (13.0, Complex64::new(2.4, 0.0));
        let kappa0 = k0 * theta.cos();
        let kappa = (k0 * k0 * (eps - 1.0) + kappa0 * kappa0).sqrt();
        Wave { k0, ky: -k0 * theta.sin(), kappa, kappa0, eps, eps0: 1.0 }
    }

    fn shell(diameter_um: f64, re: f64, im: f64) -> Shell {
        Shell { diameter_um, eps: Complex64::new(re, im) }
    }

    fn unscaled(rod: &RodTable, n: usize) -> Pair {
        rod.t[n].map(|row| row.map(|x| x * rod.inverse_scale[n].powi(2)))
    }

    #[test]
    fn across_the_axis_the_coefficients_are_those_of_mie() {
        let (wave, inside) = (wave(0.0), shell(0.2, 3.1, 0.4));
        let rod = RodTable::new(&wave, &[inside], 8).unwrap();
        let (x, y) = (wave.kappa * 0.1, wave.k0 * inside.eps.sqrt() * 0.1);
        let [at_x, at_y] = [x, y].map(|z| Cylinder::new(z, 9).unwrap());
        let table = |z| if z == x { &at_x } else { &at_y };
        let (j, h) = (|n: usize, z| table(z).j[n], |n: usize, z| table(z).h[n]);
        let ratio = (inside.eps / wave.eps).sqrt();
        for n in 1..=8 {
            let (dj, dh) = (|z| (j(n - 1, z) - j(n + 1, z)) / 2.0, |z| (h(n - 1, z) - h(n + 1, z)) / 2.0);
            // Bohren & Huffman 1983, section 8.4, with relative index `ratio`
            let e =
                -(ratio * dj(y) * j(n, x) - j(n, y) * dj(x)) / (ratio * dj(y) * h(n, x) - j(n, y) * dh(x));
            let m =
                -(dj(y) * j(n, x) - ratio * j(n, y) * dj(x)) / (dj(y) * h(n, x) - ratio * j(n, y) * dh(x));
            let t = unscaled(&rod, n);
            assert!(
                (t[0][0] - e).norm() < 1e-13 * e.norm() && (t[1][1] - m).norm() < 1e-13 * m.norm(),
                "{n}"
            );
            assert!(t[0][1].norm() + t[1][0].norm() < 1e-16 * e.norm());
        }
    }

    #[test]
    fn fields_tangential_to_the_rod_are_continuous_at_oblique_incidence() {
        let (wave, inside, radius) = (wave(0.9), shell(0.2, 3.1, 0.4), 0.1);
        let rod = RodTable::new(&wave, &[inside], 8).unwrap();
        let inner = decaying_root(wave.k0 * wave.k0 * (inside.eps - 1.0) + wave.kappa0 * wave.kappa0);
        let a = [Complex64::new(0.3, -1.1), Complex64::new(0.8, 0.2)];
        for n in -7i32..=7 {
            let order = n.unsigned_abs() as usize;
            let [j, dj, h, dh] = rod.outer[order];
            let b = rod.scattered(n, a);
            let [e, hy] = [0, 1].map(|i| a[i] * j + b[i] * h);
            let [de, dhy] = [0, 1].map(|i| a[i] * dj + b[i] * dh);
            let f = Functions::at(&Cylinder::new(inner * radius, 9).unwrap(), order, inner);
            let slope = f.dj / f.j;
            let turn = Complex64::new(0.0, f64::from(n) * wave.ky / radius);
            let around = |kappa2: Complex64, eps: Complex64, de: Complex64, dhy: Complex64| {
                [(turn * e + wave.k0 * dhy) / kappa2, (turn * hy - wave.k0 * eps * de) / kappa2]
            };
            let outside = around(wave.kappa * wave.kappa, wave.eps, de, dhy);
            let inside = around(inner * inner, inside.eps, e * slope, hy * slope);
            for (x, y) in outside.into_iter().zip(inside) {
                assert!((x - y).norm() < 1e-12 * x.norm(), "{n}: {x} {y}");
            }
        }
    }

    #[test]
    fn shells_without_contrast_are_not_there() {
        let wave = wave(-0.7);
        let compare = |a: &[Shell], b: &[Shell]| {
            let [a, b] = [a, b].map(|shells| RodTable::new(&wave, shells, 12).unwrap());
            for n in 0..=12 {
                let [t, u] = [&a, &b].map(|rod| unscaled(rod, n));
                let size = u.iter().flatten().map(|x| x.norm()).fold(0.0, f64::max);
                for i in 0..4 {
                    assert!(
                        (t[i / 2][i % 2] - u[i / 2][i % 2]).norm()
                            < 1e-12 * size.max(b.inverse_scale[n].powi(2))
                    );
                }
            }
        };
        let core = shell(0.1, 1.0, 0.0);
        compare(&[shell(0.2, 3.1, 0.4), shell(0.1, 3.1, 0.4)], &[shell(0.2, 3.1, 0.4)]);
        compare(&[shell(0.2, 3.1, 0.4), core, shell(0.03, 1.0, 0.0)], &[shell(0.2, 3.1, 0.4), core]);
        compare(&[shell(0.12, 2.4, 0.0), core], &[core]);
    }
}
