//! The grid: spacing, time step, planes and absorbing layers.
//!
//! Waves of the discrete equations obey K_x² + K_z² + β² = εΩ² with K = f·(2/Δ) sin(kΔ/2) and Ω = (2/dt) sin(ω dt/2).
//! The run's ω is chosen so that Ω is exactly 2π/λ, and the factors f_x and f_z so that the incident wave's k_x is
//! exact everywhere and its k_z is in the host; what is left is of second order in Δ (other media, other orders,
//! boundaries). Lengths in µm, c = 1.

use std::ops::Range;

use super::medium::{Material, Medium};
use crate::solve::crystal::orders::DiffractionOrders;
use crate::{Complex64, Error, Result};

/// Number in which fields are kept.
pub(super) type Real = f32;

/// Part of the greatest stable time step that is used.
const COURANT: f64 = 0.99;
/// Amplitude that comes back from the absorbing layers, e^{−2·this}, for the incident wave's angle.
const DECAY: f64 = 6.0;
/// Cells between the outermost planes of interest and the absorbing layers.
const MARGIN: usize = 2;
/// Most cells of a grid, about 2 GB of fields.
const MOST_CELLS: f64 = 2e7;

#[derive(Debug, Clone)]
pub(super) struct Grid {
    pub nx: usize,
    /// Planes along z, upwards from k = 0.
    pub nz: usize,
    pub spacing: f64,
    pub dt: f64,
    /// ω of the run, so that (2/dt) sin(ω dt/2) = 2π/λ.
    pub omega: f64,
    pub fx: f64,
    pub fz: f64,
    /// z of plane 0, negative.
    bottom: f64,
    /// Plane through which transmitted power is measured, two cells or more below the edge.
    pub exit: usize,
    /// z of the lower edge of all that is not host.
    pub edge: f64,
    /// Planes between which E may meet absorbing matter: from the exit to the surface where the host absorbs.
    pub matter: Range<usize>,
    /// Planes whose field is kept for pictures.
    pub near: Range<usize>,
    /// Highest plane of the total field.
    pub source: usize,
    /// Plane on which reflected orders are measured.
    pub line: usize,
    /// Thickness of each absorbing layer, cells.
    pub absorber: usize,
    /// Greatest conductivity of the absorbing layers below and above.
    sigma: [f64; 2],
}

impl Grid {
    /// `offset` moves the surface up from a plane, in cells. `near_um` is the height above the surface up to which the
    /// field is kept; without it none is.
    pub(super) fn new(
        medium: &Medium,
        diffraction: &DiffractionOrders,
        cells_per_um: f64,
        absorber_um: f64,
        offset: f64,
        near_um: Option<f64>,
    ) -> Result<(Self, Material)> {
        let period = medium.cell.period_um;
        let nx = (period * cells_per_um - 1e-9).ceil().max(1.0) as usize;
        let spacing = period / nx as f64;
        let k = diffraction.k;
        let stretch = |wave: f64| {
            let half = wave * spacing / 2.0;
            if half.abs() < 1e-9 { 1.0 } else { half / half.sin() }
        };
        let (fx, fz) = (stretch(diffraction.a0 * k), stretch(diffraction.q_host(0).re * k));
        if diffraction.q_host(0).norm() * k * spacing > 1.0 || diffraction.n * k * spacing > 1.0 {
            return Err(Error::input(format!(
                "{cells_per_um} cells per µm are less than six per wavelength; give more"
            )));
        }
        let (top, low) = medium.extent().unwrap_or((0.0, 0.0));
        let cells = (low + 2.0 * absorber_um) / spacing * nx as f64;
        if cells > MOST_CELLS {
            return Err(Error::input(format!(
                "a period down to {low} µm needs {cells:.0} cells, more than {MOST_CELLS}; give fewer cells per µm"
            )));
        }
        let absorber = (absorber_um / spacing).ceil().max(8.0) as usize;
        let below = (low / spacing).ceil() as usize + absorber + 2 * MARGIN;
        let exit = absorber + MARGIN;
        let matter = if diffraction.host_eps.im > 0.0 {
            exit..below + 2
        } else {
            exit + MARGIN - 1..below - (top.max(0.0) / spacing).floor() as usize + 2
        };
        let source = below + 2 + MARGIN + (near_um.unwrap_or(0.0) / spacing).ceil() as usize;
        let line = source + 2;
        let mut grid = Self {
            nx,
            nz: line + MARGIN + absorber + 1,
            spacing,
            dt: 0.0,
            omega: 0.0,
            fx,
            fz,
            bottom: -(below as f64 + offset) * spacing,
            exit,
            edge: -low,
            matter,
            near: near_um.map_or(0..0, |_| exit..source + 1),
            source,
            line,
            absorber,
            sigma: [diffraction.q_host(0).re, diffraction.q_above(0).re]
                .map(|q| 4.0 * DECAY / (q.max(0.01) * absorber as f64 * spacing)),
        };
        let heights: Vec<f64> = (0..grid.nz).map(|k| grid.z(k as f64)).collect();
        let material = Material::new(medium, nx, &heights, spacing);
        grid.set_time_step(&material, diffraction);
        Ok((grid, material))
    }

    /// The greatest stable step.
    ///
    /// With E = aD(t) + bD(t − dt) = S D + N (D − D(t − dt)), S = a + b = ξ' − |ξ''|tan(ω dt/2) and N = −b =
    /// |ξ''|/sin(ω dt), each mode of the discrete equations obeys z² + (s + n − 2)z + 1 − n = 0 with s and n the values
    /// of dt²·curl S curl and dt²·curl N curl in it: it decays for all s > 0, n ≥ 0, s + 2n < 4. The last is dt² times
    /// the largest eigenvalues of curl curl and of S + 2N = ξ' + |ξ''|cot(ω dt/2).
    fn set_time_step(&mut self, material: &Material, diffraction: &DiffractionOrders) {
        let square = |f: f64| (2.0 * f / self.spacing).powi(2);
        let curl = square(self.fx) + square(self.fz) + (diffraction.b * diffraction.k).powi(2);
        let mut dt = self.spacing;
        loop {
            let half = (diffraction.k * dt / 2.0).min(0.9).asin();
            let (stiff, least) = material.bounds(self.nx, self.nz, half.tan().recip(), half.tan());
            if curl * dt * dt * stiff < 4.0 * COURANT * COURANT && least > 0.0 {
                self.dt = dt;
                self.omega = 2.0 * half / dt;
                return;
            }
            dt *= 0.98;
        }
    }

    /// z of a plane (k) or between planes (k + ½).
    pub(super) fn z(&self, k: f64) -> f64 {
        self.bottom + k * self.spacing
    }

    /// k_z of an order in the incidence medium on this grid.
    pub(super) fn kz(&self, diffraction: &DiffractionOrders, m: i32) -> Complex64 {
        let kx = self.fx * 2.0 / self.spacing * (diffraction.a(m) * diffraction.k * self.spacing / 2.0).sin();
        let kz = crate::solve::crystal::orders::root(Complex64::from(
            diffraction.kappa() - (kx / diffraction.k).powi(2),
        ));
        (kz * diffraction.k * self.spacing / (2.0 * self.fz)).asin() * (2.0 / self.spacing)
    }

    /// Convolutional absorbing layers (Roden & Gedney 2000, Microw. Opt. Technol. Lett. 27, 334): per plane, shifted
    /// by `half` a cell, 1/κ and the recursion's two factors.
    pub(super) fn absorbing(&self, half: f64) -> Vec<[f64; 3]> {
        let depth = self.absorber as f64;
        (0..self.nz)
            .map(|k| {
                let place = k as f64 + half;
                let from_below = (depth - place) / depth;
                let from_above = (place - (self.nz - 1) as f64 + depth) / depth;
                let (u, sigma) =
                    if from_below > 0.0 { (from_below, self.sigma[0]) } else { (from_above, self.sigma[1]) };
                if u <= 0.0 {
                    return [1.0, 0.0, 0.0];
                }
                let (kappa, sigma) = (1.0 + 4.0 * u.powi(3), sigma * u.powi(3));
                let alpha = 0.2 * (1.0 - u).max(0.0);
                let b = (-(sigma / kappa + alpha) * self.dt).exp();
                [1.0 / kappa, b, sigma / (kappa * (sigma + alpha * kappa)) * (b - 1.0)]
            })
            .collect()
    }
}

/// The two real factors of E = a D(t) + b D(t − dt) that make ξ at the run's frequency, where D(t − dt) = e^{jω dt} D(t).
///
/// b ≤ 0 for absorbing media, which makes the medium passive at every frequency; unlike a conductivity it is explicit
/// for tensors too.
pub(super) fn blend(xi: Complex64, angle: f64) -> (f64, f64) {
    let (sine, cosine) = angle.sin_cos();
    let b = xi.im / sine;
    (xi.re - b * cosine, b)
}
