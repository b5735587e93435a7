//! Photonic crystals of rods: periodic along x, invariant along y, a few rows deep.
//!
//! Three independent solvers behind one interface: cylinder multipoles for circular rods, the Fourier modal method for
//! any shape, and finite differences in time. Time dependence e^{−jωt}, waves e^{+jk·r}, absorbing media have Im ε > 0,
//! H̃ = η₀H.

pub mod balance;
#[cfg(test)]
mod cells;
pub mod fdtd;
pub mod figures;
mod grating;
pub mod multipole;
pub mod planar;
pub mod rcwa;
#[cfg(test)]
mod reference;
mod table;

use rayon::prelude::*;

pub use fdtd::{Fdtd, NearField};
pub use multipole::Multipole;
pub use rcwa::Rcwa;
pub use table::{order_series, order_table};

use crate::progress::Progress;
use crate::structure::Lattice;
use crate::{Complex64, Error, Result};

/// Orders that may propagate in the host; solvers take memory with their square and time with their cube.
const MOST_ORDERS: f64 = 300.0;

/// A crystal at one wavelength: rods along y, periodic in x, in a host that fills everything below the flat surface
/// z = 0 and goes on below as a half-space; a lossless incidence medium above.
#[derive(Debug, Clone)]
pub struct Cell {
    /// Period along x, µm.
    pub period_um: f64,
    /// Relative permittivity above the surface, positive.
    pub incidence_eps: f64,
    /// Relative permittivity between and below the rods.
    pub host_eps: Complex64,
    /// Every rod of every row of one period.
    pub rods: Vec<Rod>,
}

/// A rod: concentric circles around one axis along y.
#[derive(Debug, Clone)]
pub struct Rod {
    /// Position of the axis, µm; any real number, its position modulo the period counts.
    pub x_um: f64,
    /// Depth of the axis below the surface, µm; more than the radius.
    pub depth_um: f64,
    /// Outermost first, diameters strictly falling.
    pub shells: Vec<Shell>,
}

/// What lies within one circle of a rod, up to the next smaller circle.
#[derive(Debug, Clone, Copy)]
pub struct Shell {
    /// Outer diameter, µm.
    pub diameter_um: f64,
    /// Relative permittivity.
    pub eps: Complex64,
}

/// A plane wave that comes from ω_i = (cosθ sinφ, sinθ, cosθ cosφ).
#[derive(Debug, Clone, Copy)]
pub struct Incidence {
    /// Wavelength in vacuum, nm.
    pub wavelength_nm: f64,
    /// Longitudinal angle, rad.
    pub theta_i: f64,
    /// Azimuth in the cross section, rad.
    pub phi_i: f64,
}

/// A propagating reflected order.
#[derive(Debug, Clone, Copy)]
pub struct Order {
    /// Its number: sinφ_o = −sinφ_i + mλ/(Δ n cosθ_i).
    pub m: i32,
    /// Its azimuth, rad.
    pub phi_o: f64,
    /// `[out][in]` along e₁, e₂ of the outgoing and of the incident direction.
    pub jones: [[Complex64; 2]; 2],
}

/// What becomes of a plane wave of unit amplitude.
#[derive(Debug, Clone)]
pub struct Response {
    /// Propagating reflected orders, m ascending.
    pub orders: Vec<Order>,
    /// Power into the half-space below the lowest rods' lower edge over incident power, per incident polarization.
    pub transmitted: [f64; 2],
    /// Power absorbed by the rods over incident power, per incident polarization, from the fields at them.
    pub absorbed: [f64; 2],
    /// The solver's own estimate of the error of R, the largest over orders and polarizations.
    pub convergence: f64,
}

/// A solver of crystals.
pub trait Crystal {
    /// The response of a cell to one plane wave in both polarizations.
    ///
    /// # Errors
    /// A cell or wave that has no meaning, or a computation that did not settle.
    fn respond(&self, cell: &Cell, incidence: &Incidence) -> Result<Response>;

    /// The responses to waves of one wavelength and one θ_i (rad) from azimuths `phi_i` (rad), which may share work.
    ///
    /// # Errors
    /// As [`Self::respond`].
    fn respond_to_azimuths(
        &self,
        cell: &Cell,
        wavelength_nm: f64,
        theta_i: f64,
        phi_i: &[f64],
    ) -> Result<Vec<Response>> {
        phi_i.iter().map(|&phi_i| self.respond(cell, &Incidence { wavelength_nm, theta_i, phi_i })).collect()
    }
}

impl Order {
    /// Power of this order over incident power, by incident polarization, for light from azimuth `phi_i` (rad).
    #[must_use]
    pub fn reflectance(&self, phi_i: f64) -> [f64; 2] {
        let [first, second] = &self.jones;
        [0, 1].map(|q| (first[q].norm_sqr() + second[q].norm_sqr()) * self.phi_o.cos() / phi_i.cos())
    }
}

impl Response {
    /// Power of all reflected orders over incident power, by incident polarization.
    #[must_use]
    pub fn reflectance(&self, phi_i: f64) -> [f64; 2] {
        self.orders.iter().fold([0.0; 2], |[a, b], order| {
            let [first, second] = order.reflectance(phi_i);
            [a + first, b + second]
        })
    }

    /// The larger |R + T + A − 1| of both polarizations.
    #[must_use]
    pub fn imbalance(&self, phi_i: f64) -> f64 {
        let reflected = self.reflectance(phi_i);
        [0, 1]
            .map(|q| (reflected[q] + self.transmitted[q] + self.absorbed[q] - 1.0).abs())
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// The largest difference of an order's reflectance from that of another response to the same wave.
    #[must_use]
    pub fn distance(&self, other: &Self, phi_i: f64) -> f64 {
        let pairs = self.orders.iter().zip(&other.orders);
        pairs
            .flat_map(|(a, b)| {
                let (a, b) = (a.reflectance(phi_i), b.reflectance(phi_i));
                [(a[0] - b[0]).abs(), (a[1] - b[1]).abs()]
            })
            .fold(0.0, f64::max)
    }
}

impl Cell {
    /// A lattice at one vacuum wavelength.
    ///
    /// # Errors
    /// A medium has no index there, or the incidence medium absorbs.
    pub fn new(lattice: &Lattice, wavelength_nm: f64) -> Result<Self> {
        let eps = |substance| -> Result<Complex64> {
            let index = lattice.material(substance)?.index(wavelength_nm)?;
            Ok(index * index)
        };
        let incidence = lattice.material(&lattice.incidence)?.index(wavelength_nm)?;
        if incidence.im != 0.0 || incidence.re <= 0.0 {
            return Err(Error::input(format!(
                "lattice.incidence has the index {incidence} at {wavelength_nm} nm, but light must come through a medium that does not absorb"
            )));
        }
        let host_eps = eps(&lattice.host)?;
        let orders = 2.0 * lattice.period_um * host_eps.sqrt().re.max(incidence.re) / (wavelength_nm * 1e-3);
        if orders > MOST_ORDERS {
            return Err(Error::input(format!(
                "lattice.period of {} µm carries {orders:.0} orders at {wavelength_nm} nm, over {MOST_ORDERS}; give a shorter period",
                lattice.period_um
            )));
        }
        let shells = lattice
            .rods
            .iter()
            .map(|rod| {
                rod.circles
                    .iter()
                    .map(|circle| Ok(Shell { diameter_um: circle.diameter_um, eps: eps(&circle.medium)? }))
                    .collect::<Result<Vec<_>>>()
            })
            .collect::<Result<Vec<_>>>()?;
        Ok(Self {
            period_um: lattice.period_um,
            incidence_eps: incidence.re * incidence.re,
            host_eps,
            rods: lattice
                .placed()
                .map(|placed| Rod {
                    x_um: placed.x_um,
                    depth_um: placed.depth_um,
                    shells: shells[placed.rod].clone(),
                })
                .collect(),
        })
    }
}

/// Reflectance of all orders by polarization, `[phi_i][wavelength]`, wavelengths in parallel.
///
/// # Errors
/// As [`Cell::new`] and [`Crystal::respond`], or the user cancelled.
pub fn sweep(
    solver: &(impl Crystal + Sync),
    lattice: &Lattice,
    wavelengths_nm: &[f64],
    theta_i: f64,
    phi_i: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<[f64; 2]>> {
    progress.begin("solving", wavelengths_nm.len() as u64);
    let columns = wavelengths_nm
        .par_iter()
        .with_max_len(1)
        .map(|&nm| {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let responses = solver.respond_to_azimuths(&Cell::new(lattice, nm)?, nm, theta_i, phi_i)?;
            progress.advance(1);
            Ok(responses.iter().zip(phi_i).map(|(r, &phi)| r.reflectance(phi)).collect::<Vec<_>>())
        })
        .collect::<Result<Vec<_>>>()?;
    Ok((0..phi_i.len()).flat_map(|phi| columns.iter().map(move |column| column[phi])).collect())
}
