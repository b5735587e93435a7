//! Circles in circles by series of cylinder waves: exact to rounding, and nothing in common with boundary elements.
//!
//! E_y and H̃_y are sums of J_n and H_n about every circle's centre; waves about other centres are moved by Graf's theorem
//! (DLMF 10.23.7; the multiple-scattering method of Kerker 1969 and Bohren and Huffman 1983, 8.4, for one circle). Angles α are
//! from +z towards +x.

use std::f64::consts::PI;

use crate::Complex64;
use crate::math::bessel::Cylinder;
use crate::math::dense::Dense;

/// A circle with the index inside and the circle around it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circle {
    pub(super) at: [f64; 2],
    pub(super) radius_um: f64,
    pub(super) index: Complex64,
    pub(super) parent: Option<usize>,
}

/// The far field [e₁, e₂] at azimuths, for incident polarization 0 or 1 of a plane wave of unit |E|.
pub(super) struct Series<'a> {
    pub(super) circles: &'a [Circle],
    pub(super) k: f64,
    pub(super) theta_i: f64,
    pub(super) phi_i: f64,
    pub(super) orders: i32,
}

impl Series<'_> {
    fn kappa(&self, index: Complex64) -> Complex64 {
        let k_y = self.k * self.theta_i.sin();
        (self.k * self.k * index * index - k_y * k_y).sqrt()
    }

    fn around(&self, circle: usize) -> Complex64 {
        self.circles[circle].parent.map_or(Complex64::new(1.0, 0.0), |p| self.circles[p].index)
    }

    fn count(&self) -> usize {
        (2 * self.orders + 1) as usize
    }

    /// Unknowns of a circle: A of E_y, A of H̃_y (J inside), B of E_y, B of H̃_y (H outside); place of order n.
    fn place(&self, circle: usize, kind: usize, n: i32) -> usize {
        (circle * 4 + kind) * self.count() + (n + self.orders) as usize
    }

    pub(super) fn far(&self, polarization: usize, phi_o: &[f64]) -> [Vec<Complex64>; 2] {
        let unknowns = self.solve(polarization);
        let kappa = self.kappa(Complex64::new(1.0, 0.0));
        let cos = self.theta_i.cos();
        let component = |kind: usize| -> Vec<Complex64> {
            let at = |&phi: &f64| {
                let mut sum = Complex64::ZERO;
                for (c, circle) in self.circles.iter().enumerate().filter(|(_, c)| c.parent.is_none()) {
                    let path = circle.at[0] * phi.sin() + circle.at[1] * phi.cos();
                    let place = (-Complex64::i() * kappa * path).exp();
                    for n in -self.orders..=self.orders {
                        let b = unknowns[self.place(c, 2 + kind, n)];
                        let turn = f64::from(n) * (phi - PI / 2.0);
                        sum += place * b * Complex64::from_polar(1.0, turn);
                    }
                }
                sum * (2.0 / (PI * kappa)).sqrt() * Complex64::from_polar(1.0, -PI / 4.0) / cos
            };
            phi_o.iter().map(at).collect()
        };
        [component(0), component(1)]
    }

    fn solve(&self, polarization: usize) -> Vec<Complex64> {
        let size = self.circles.len() * 4 * self.count();
        let mut matrix = Dense::zeros(size, size);
        let mut right = Dense::zeros(size, 1);
        for circle in 0..self.circles.len() {
            self.match_circle(circle, polarization, &mut matrix, &mut right);
        }
        matrix.solve(&mut right);
        right.column(0).to_vec()
    }

    /// E_y, H̃_y, E_t and H̃_t are the same on both sides, order by order.
    fn match_circle(&self, c: usize, polarization: usize, matrix: &mut Dense, right: &mut Dense) {
        let circle = self.circles[c];
        let (outer, inner) = (self.around(c), circle.index);
        let (k_out, k_in) = (self.kappa(outer), self.kappa(inner));
        let out = Ring::new(k_out, circle.radius_um, self.orders);
        let ins = Ring::new(k_in, circle.radius_um, self.orders);
        for n in -self.orders..=self.orders {
            // Terms: (regular wave?, side, field kind, unknown's place, factor).
            let mut terms = Vec::new();
            for kind in 0..2 {
                terms.push((false, true, kind, self.place(c, 2 + kind, n), Complex64::new(1.0, 0.0)));
                terms.push((true, false, kind, self.place(c, kind, n), Complex64::new(1.0, 0.0)));
                for (o, other) in self.circles.iter().enumerate().filter(|&(o, _)| o != c) {
                    if other.parent == circle.parent {
                        // Siblings' outgoing waves arrive as regular ones.
                        for m in -self.orders..=self.orders {
                            let factor = moved(k_out, circle.at, other.at, m - n, true);
                            terms.push((true, true, kind, self.place(o, 2 + kind, m), factor));
                        }
                    } else if other.parent == Some(c) {
                        // Children's outgoing waves are outgoing about this centre, too.
                        for m in -self.orders..=self.orders {
                            let factor = moved(k_in, circle.at, other.at, m - n, false);
                            terms.push((false, false, kind, self.place(o, 2 + kind, m), factor));
                        }
                    } else if circle.parent == Some(o) {
                        for m in -self.orders..=self.orders {
                            let factor = moved(k_out, circle.at, other.at, m - n, false);
                            terms.push((true, true, kind, self.place(o, kind, m), factor));
                        }
                    }
                }
            }
            let rows = [0, 1, 2, 3].map(|equation| self.place(c, equation, n));
            for (regular, outside, kind, place, factor) in terms {
                let (ring, index) = if outside { (&out, outer) } else { (&ins, inner) };
                let sign = if outside { 1.0 } else { -1.0 };
                let parts = self.traces(ring, index, n, regular, kind, circle.radius_um);
                for (row, part) in rows.iter().zip(parts) {
                    matrix[(*row, place)] += sign * factor * part;
                }
            }
            if circle.parent.is_none() {
                // e^{jκρ cos(α − φ_i − π)}, times the phase of the centre.
                let path = circle.at[0] * self.phi_i.sin() + circle.at[1] * self.phi_i.cos();
                let phase = (-Complex64::i() * k_out * path).exp();
                let turn = f64::from(n) * (0.5 * PI - self.phi_i - PI);
                let (kind, field) =
                    if polarization == 0 { (0, self.theta_i.cos()) } else { (1, -self.theta_i.cos()) };
                let factor = phase * Complex64::from_polar(field, turn);
                for (row, part) in rows.iter().zip(self.traces(&out, outer, n, true, kind, circle.radius_um))
                {
                    right[(*row, 0)] -= factor * part;
                }
            }
        }
    }

    /// E_y, H̃_y, E_t, H̃_t of one wave of E_y (kind 0) or H̃_y (kind 1), from Maxwell's equations: κ²E_t = −jk∂_nH̃_y + jk_y∂_tE_y,
    /// κ²H̃_t = jkn²∂_nE_y + jk_y∂_tH̃_y.
    fn traces(
        &self,
        ring: &Ring,
        index: Complex64,
        n: i32,
        regular: bool,
        kind: usize,
        radius_um: f64,
    ) -> [Complex64; 4] {
        let (value, slope) = ring.wave(n, regular);
        let j = Complex64::i();
        let k_y = -self.k * self.theta_i.sin();
        let kappa_squared = self.kappa(index) * self.kappa(index);
        let along = j * k_y * j * f64::from(n) / radius_um * value / kappa_squared;
        let zero = Complex64::ZERO;
        if kind == 0 {
            [value, zero, along, j * self.k * index * index * slope / kappa_squared]
        } else {
            [zero, value, -j * self.k * slope / kappa_squared, along]
        }
    }
}

/// Waves of all orders on a circle.
struct Ring {
    kappa: Complex64,
    cylinder: Cylinder,
}

impl Ring {
    fn new(kappa: Complex64, radius_um: f64, orders: i32) -> Self {
        Self { kappa, cylinder: Cylinder::new(kappa * radius_um, orders as usize + 1).unwrap() }
    }

    fn function(&self, n: i32, regular: bool) -> Complex64 {
        let values = if regular { &self.cylinder.j } else { &self.cylinder.h };
        let sign = if n < 0 && n % 2 != 0 { -1.0 } else { 1.0 };
        sign * values[n.unsigned_abs() as usize]
    }

    /// Value and slope along the radius.
    fn wave(&self, n: i32, regular: bool) -> (Complex64, Complex64) {
        let slope = 0.5 * (self.function(n - 1, regular) - self.function(n + 1, regular));
        (self.function(n, regular), self.kappa * slope)
    }
}

/// The factor of C_n(about `to`) e^{jnα} in a wave of order n + `difference` about `from`: Z_{m−n}(κd) e^{j(m−n)β}, β the
/// angle of the way from `from` to `to`; Z = H where an outgoing wave becomes a regular one, else J.
fn moved(kappa: Complex64, to: [f64; 2], from: [f64; 2], difference: i32, outgoing: bool) -> Complex64 {
    let (dx, dz) = (to[0] - from[0], to[1] - from[1]);
    let distance = dx.hypot(dz);
    if distance == 0.0 {
        return if difference == 0 { Complex64::new(1.0, 0.0) } else { Complex64::ZERO };
    }
    let order = difference.unsigned_abs() as usize;
    let cylinder = Cylinder::new(kappa * distance, order.max(1)).unwrap();
    let value = if outgoing { cylinder.h[order] } else { cylinder.j[order] };
    let sign = if difference < 0 && difference % 2 != 0 { -1.0 } else { 1.0 };
    let angle = dx.atan2(dz);
    sign * value * Complex64::from_polar(1.0, f64::from(difference) * angle)
}
