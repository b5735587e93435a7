//! Fourier modes of a slice and its scattering matrix.
//!
//! With all fields ∝ e^{jk(a_m x + b y)}, lengths in units of 1/k and Li's rules (the wall-normal E_x by the inverse of
//! the Toeplitz matrix of 1/ε, S = ⟦1/ε⟧⁻¹; E_y and E_z by T = ⟦ε⟧, Q = T⁻¹), Maxwell's equations are
//!
//!   E_x' = j[AQb H_x + (1 − AQA) H_y],   E_y' = j[(b²Q − 1) H_x − bQA H_y],
//!   H_x' = j[−bA E_x + (A² − T) E_y],    H_y' = j[(S − b²) E_x + bA E_y].
//!
//! Walls are vertical, so modes have E_x = 0 or H_x = 0 although the mount is conical, and the problem of 2N unknowns
//! falls into two of N, q² = γ² − b², both free of b:
//!
//!   (T − A²) v = γ² v:       E = (0, v),                 H = (−γ² v, bA v)/q,
//!   (1 − AQA) S u = γ² u:    E = (γ² u, −bQAS u),        H = (0, qS u).
//!
//! Sources: Moharam, Grann, Pommet & Gaylord 1995 (conical mount), Li 1996 (factorization, J. Opt. Soc. Am. A 13, 1870,
//! and scattering matrices, 13, 1024).

use super::profile::Slice;
use super::scattering::Scattering;
use crate::math::dense::Dense;
use crate::solve::crystal::orders::{DiffractionOrders, root};
use crate::{Complex64, Error, Result};

/// The orders kept, in units of k, with the reference medium between all parts of the stack.
///
/// Parts are joined at planes in layers without thickness of a reference medium. Any will do; an absorbing one has no
/// Rayleigh anomaly, where waves that go up and down would be the same.
pub(super) struct Harmonics {
    /// Orders −limit … limit.
    pub limit: i32,
    a: Vec<f64>,
    b: f64,
    q_host: Vec<Complex64>,
    host_eps: Complex64,
    q_reference: Vec<Complex64>,
    reference_eps: Complex64,
    k: f64,
}

impl Harmonics {
    pub(super) fn new(diffraction: &DiffractionOrders, limit: i32) -> Self {
        let a: Vec<f64> = (-limit..=limit).map(|m| diffraction.a(m)).collect();
        let b = diffraction.b;
        let reference_eps = diffraction.host_eps.norm() * Complex64::new(1.0, 0.5);
        Self {
            limit,
            b,
            q_host: (-limit..=limit).map(|m| diffraction.q_host(m)).collect(),
            host_eps: diffraction.host_eps,
            q_reference: a.iter().map(|a| root(reference_eps - b * b - a * a)).collect(),
            reference_eps,
            a,
            k: diffraction.k,
        }
    }

    /// Number of orders.
    pub(super) fn len(&self) -> usize {
        self.a.len()
    }

    /// Whether the host takes power.
    pub(super) fn host_absorbs(&self) -> bool {
        self.host_eps.im > 0.0
    }

    /// H̃ of a wave that goes up in the reference medium from its E, per order: (H_x, H_y) = V₀ (E_x, E_y).
    pub(super) fn admittance(&self, order: usize) -> [[Complex64; 2]; 2] {
        admittance(self.a[order], self.b, self.reference_eps, self.q_reference[order])
    }

    /// The inverse of [`admittance`](Self::admittance).
    fn impedance(&self, order: usize) -> [[Complex64; 2]; 2] {
        let (a, b, eps) = (self.a[order], self.b, self.reference_eps);
        let ba = b * a / eps;
        [[ba, 1.0 - a * a / eps], [b * b / eps - 1.0, -ba]]
            .map(|row| row.map(|value| value / self.q_reference[order]))
    }

    /// Power that flows down through a plane in the reference medium, from the waves' E that go down and up there.
    pub(super) fn flux(&self, down: &[Complex64], up: &[Complex64]) -> f64 {
        let count = self.len();
        (0..count)
            .map(|order| {
                let e = [order, order + count].map(|i| down[i] + up[i]);
                let d = [order, order + count].map(|i| up[i] - down[i]);
                let h = self.admittance(order).map(|row| row[0] * d[0] + row[1] * d[1]);
                (e[1] * h[0].conj() - e[0] * h[1].conj()).re
            })
            .sum()
    }

    /// The half-space of the host under a plane in the reference medium; nothing comes from below.
    pub(super) fn exit(&self) -> Scattering {
        let count = self.len();
        let zero = Dense::zeros(2 * count, 2 * count);
        let mut top = zero.clone();
        for order in 0..count {
            let host = admittance(self.a[order], self.b, self.host_eps, self.q_host[order]);
            let own = self.admittance(order);
            // V₀(up − down) = −V(up + down).
            let sum = Dense::from_fn(2, 2, |i, j| own[i][j] + host[i][j]);
            let reflection = sum.under(Dense::from_fn(2, 2, |i, j| own[i][j] - host[i][j]));
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                top[(order + i * count, order + j * count)] = reflection[(i, j)];
            }
        }
        Scattering { top, bottom: zero.clone(), down: zero.clone(), up: zero }
    }

    /// A layer of the host between two planes in the reference medium; its modes need no eigenproblem.
    pub(super) fn gap(&self, thickness_um: f64) -> Result<Scattering> {
        let count = self.len();
        let size = 2 * count;
        let mut modes =
            Modes { q: vec![Complex64::ZERO; size], e: Dense::identity(size), h: Dense::zeros(size, size) };
        for order in 0..count {
            let host = admittance(self.a[order], self.b, self.host_eps, self.q_host[order]);
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                modes.h[(order + i * count, order + j * count)] = host[i][j];
            }
            modes.q[order] = self.q_host[order];
            modes.q[order + count] = self.q_host[order];
        }
        self.layer(&modes, thickness_um)
    }

    /// A slice between two planes in the reference medium, first piece at x = 0.
    pub(super) fn slice(&self, slice: &Slice) -> Result<Scattering> {
        self.layer(&self.modes(slice)?, slice.thickness_um)
    }

    /// A layer of these modes.
    ///
    /// It is its own mirror image, so it answers waves that come in alike from both sides (E of each mode c(1 + X),
    /// X = e^{jqkd}) and unlike (c(1 − X)) separately, with G = V₀⁻¹V:
    /// R + T = [W(1+X) − G(1−X)][W(1+X) + G(1−X)]⁻¹ and R − T = [W(1−X) − G(1+X)][W(1−X) + G(1+X)]⁻¹.
    fn layer(&self, modes: &Modes, thickness_um: f64) -> Result<Scattering> {
        let count = self.len();
        let size = 2 * count;
        let growth: Vec<Complex64> =
            modes.q.iter().map(|q| (Complex64::I * q * (self.k * thickness_um)).exp()).collect();
        let mut partner = Dense::zeros(size, size);
        for order in 0..count {
            let z = self.impedance(order);
            for j in 0..size {
                let h = [modes.h[(order, j)], modes.h[(order + count, j)]];
                partner[(order, j)] = z[0][0] * h[0] + z[0][1] * h[1];
                partner[(order + count, j)] = z[1][0] * h[0] + z[1][1] * h[1];
            }
        }
        let combine = |sign_e: f64, sign_h: f64| {
            Dense::from_fn(size, size, |i, j| {
                modes.e[(i, j)] * (1.0 + sign_e * growth[j])
                    + sign_h * partner[(i, j)] * (1.0 - sign_e * growth[j])
            })
        };
        let even = combine(1.0, -1.0).over(&combine(1.0, 1.0));
        let odd = combine(-1.0, -1.0).over(&combine(-1.0, 1.0));
        let reflect = Dense::from_fn(size, size, |i, j| (even[(i, j)] + odd[(i, j)]) * 0.5);
        let through = Dense::from_fn(size, size, |i, j| (even[(i, j)] - odd[(i, j)]) * 0.5);
        if !reflect.is_finite() {
            return Err(Error::not_settled(
                "a slice's modes are not independent at exactly this wavelength and angle; change either by a part in a million",
            ));
        }
        Ok(Scattering { top: reflect.clone(), bottom: reflect, down: through.clone(), up: through })
    }

    fn modes(&self, slice: &Slice) -> Result<Modes> {
        let count = self.len();
        let direct = toeplitz(count, &slice.pieces, |eps| eps);
        let inverse = toeplitz(count, &slice.pieces, |eps| eps.inv());
        let identity = Dense::identity(count);
        let q_matrix = direct.under(identity.clone());
        let s_matrix = inverse.under(identity);
        let (a, b) = (&self.a, self.b);
        let lse = Dense::from_fn(count, count, |i, j| {
            direct[(i, j)] - if i == j { Complex64::from(a[i] * a[i]) } else { Complex64::ZERO }
        });
        let curl = Dense::from_fn(count, count, |i, j| {
            Complex64::from(f64::from(u8::from(i == j))) - a[i] * q_matrix[(i, j)] * a[j]
        });
        let (v_squares, v) = eigen(&lse)?;
        let (u_squares, u) = eigen(&curl.times(&s_matrix))?;
        let su = s_matrix.times(&u);
        let qasu = q_matrix.times(&Dense::from_fn(count, count, |i, j| a[i] * su[(i, j)]));
        let size = 2 * count;
        let mut modes = Modes {
            q: vec![Complex64::ZERO; size],
            e: Dense::zeros(size, size),
            h: Dense::zeros(size, size),
        };
        for j in 0..count {
            let q = root(v_squares[j] - b * b);
            modes.q[j] = q;
            for i in 0..count {
                modes.e[(count + i, j)] = v[(i, j)];
                modes.h[(i, j)] = -v_squares[j] * v[(i, j)] / q;
                modes.h[(count + i, j)] = b * a[i] * v[(i, j)] / q;
            }
            let mut square = u_squares[j];
            if square.norm() < 1e-14 {
                square = Complex64::from(1e-14);
            }
            let q = root(square - b * b);
            modes.q[count + j] = q;
            let size = (0..count).map(|i| b.abs() * qasu[(i, j)].norm()).fold(square.norm(), f64::max);
            for i in 0..count {
                modes.e[(i, count + j)] = square * u[(i, j)] / size;
                modes.e[(count + i, count + j)] = -b * qasu[(i, j)] / size;
                modes.h[(count + i, count + j)] = q * su[(i, j)] / size;
            }
        }
        Ok(modes)
    }
}

/// Modes as columns: E and H̃ (x, then y components) of those that go up, and q.
struct Modes {
    q: Vec<Complex64>,
    e: Dense,
    h: Dense,
}

/// H̃ of a wave that goes up in a medium from its E: (H_x, H_y) = V (E_x, E_y).
fn admittance(a: f64, b: f64, eps: Complex64, q: Complex64) -> [[Complex64; 2]; 2] {
    let ba = Complex64::from(b * a);
    // −q² − b² for a² − ε, which would lose its digits at an anomaly.
    [[-ba, -q * q - b * b], [eps - b * b, ba]].map(|row| row.map(|value| value / q))
}

fn eigen(matrix: &Dense) -> Result<(Vec<Complex64>, Dense)> {
    matrix.eigen().ok_or_else(|| Error::not_settled("the eigenvalues of a slice were not found"))
}

/// The matrix of the Fourier coefficients c_{m−n} of f(ε(x)).
fn toeplitz(count: usize, pieces: &[(f64, Complex64)], f: impl Fn(Complex64) -> Complex64) -> Dense {
    let mut coefficients = vec![Complex64::ZERO; 2 * count - 1];
    let mut begin = 0.0;
    for &(length, eps) in pieces {
        let value = f(eps);
        for (index, coefficient) in coefficients.iter_mut().enumerate() {
            let g = std::f64::consts::TAU * (index as f64 - (count as f64 - 1.0));
            // ∫ e^{−jgx} dx over the piece, from its middle.
            let half = g * length / 2.0;
            let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
            *coefficient += value * Complex64::from_polar(length * sinc, -g * (begin + length / 2.0));
        }
        begin += length;
    }
    Dense::from_fn(count, count, |i, j| coefficients[i + count - 1 - j])
}
