//! Finite differences in time (2.5D FDTD) for rods and flat layers.
//!
//! The grid has all six components, complex by two real grids (`fields`), with Bloch's boundary along x and the factor
//! e^{jβy} carried analytically, so that the fields' k_x and k_y are fixed. The incident wave enters at a plane above
//! the surface as a Gaussian pulse about the wavelength at hand, and every result is the running Fourier transform
//! there: a pulse ends, so the end of a run shows in the fields, where a steady state only creeps nearer. At fixed
//! (k_x, k_y) other frequencies of the pulse come in at other angles; its band therefore stays clear of the frequency
//! at which the incident wave would graze, and runs get longer as the incident wave nears the horizon: twenty thousand
//! periods at 89° (past that they are refused: [`Error::not_settled`]).
//!
//! Steps and media are exact at the wavelength (`grid`); the error is of second order in the spacing.

mod fields;
mod grid;
mod medium;
mod near;
mod spectrum;
#[cfg(test)]
mod tests;

pub use medium::Layer;
pub use near::NearField;

use super::cell::{passive, positive};
use super::orders::DiffractionOrders;
use super::{Cell, CrystalResponse, CrystalSolver, Incidence};
use crate::math::simd::Width;
use crate::{Complex64, Error, Result};
use fields::{Fields, Source};
use grid::Grid;
use medium::{Material, Medium};
use spectrum::Spectrum;

/// Samples of the running Fourier transform per period.
const SAMPLES: f64 = 6.0;
/// Samples between looks at how much it changed: three periods.
const CHECK: usize = 18;

/// The solver and its accuracy.
#[derive(Debug, Clone, Copy)]
pub struct Fdtd {
    /// Resolution; the period is rounded to a whole number of cells.
    pub cells_per_um: f64,
    /// A run ends when the Fourier transforms at the wavelength change by less than this part over three periods.
    pub tolerance: f64,
    /// Thickness of the absorbing layers above and below, µm.
    pub absorber_um: f64,
    /// Longest run after the pulse, periods of the wave.
    pub periods: usize,
    /// How far above a plane of the grid the surface lies, cells.
    pub offset: f64,
    /// Whether [`CrystalResponse::convergence`] is found, by a second run at 2/3 of the resolution.
    pub estimate: bool,
    /// Instruction set.
    pub width: Width,
}

impl Default for Fdtd {
    fn default() -> Self {
        Self {
            cells_per_um: 100.0,
            tolerance: 3e-4,
            absorber_um: 0.2,
            periods: 3000,
            offset: 0.0,
            estimate: true,
            width: Width::best(),
        }
    }
}

impl CrystalSolver for Fdtd {
    fn respond(&self, cell: &Cell, incidence: &Incidence) -> Result<CrystalResponse> {
        self.respond_to(cell, &[], incidence)
    }
}

impl Fdtd {
    /// The response of a cell with flat layers below its surface, too.
    ///
    /// # Errors
    /// Media, rods or waves that have no meaning, media with Re ε ≤ 0, or fields that do not decay.
    pub fn respond_to(
        &self,
        cell: &Cell,
        layers: &[Layer],
        incidence: &Incidence,
    ) -> Result<CrystalResponse> {
        let medium = Medium { cell, layers };
        let diffraction = self.diffraction(&medium, incidence)?;
        let mut response = self.solve(&medium, &diffraction)?;
        if self.estimate {
            let coarse = Self { cells_per_um: self.cells_per_um / 1.5, ..*self };
            let rough = coarse.solve(&medium, &diffraction)?;
            // An order that hardly fades above the surface (just past its Rayleigh angle) is absorbed badly at any
            // resolution; the balance of power shows it.
            let unbalanced = response.imbalance(incidence.phi_i);
            response.convergence = Some(diffraction.difference(&response, &rough).max(unbalanced));
        }
        Ok(response)
    }

    /// |E|² and the permittivity in a period, from below the rods to `above_um` (µm) over the surface.
    ///
    /// # Errors
    /// As [`Self::respond_to`].
    pub fn near_field(&self, cell: &Cell, incidence: &Incidence, above_um: f64) -> Result<NearField> {
        let medium = Medium { cell, layers: &[] };
        let diffraction = self.diffraction(&medium, incidence)?;
        let (grid, material) = Grid::new(
            &medium,
            &diffraction,
            self.cells_per_um,
            self.absorber_um,
            self.offset,
            Some(above_um),
        )?;
        let runs =
            [self.run(&material, &diffraction, &grid, 0)?, self.run(&material, &diffraction, &grid, 1)?];
        Ok(NearField::new(&medium, &grid, &runs))
    }

    /// The wave on a medium that this solver can take.
    fn diffraction(&self, medium: &Medium, incidence: &Incidence) -> Result<DiffractionOrders> {
        let diffraction = DiffractionOrders::new(&medium.cell.surroundings(), incidence)?;
        positive("number of cells per µm", self.cells_per_um)?;
        positive("thickness of the absorbing layers", self.absorber_um)?;
        for layer in medium.layers {
            if !(layer.top_um >= 0.0 && layer.bottom_um > layer.top_um && layer.bottom_um.is_finite()) {
                return Err(Error::input(format!(
                    "the layer from {} to {} µm must have a thickness and lie below the surface",
                    layer.top_um, layer.bottom_um
                )));
            }
        }
        for eps in medium.materials() {
            passive("layer", eps)?;
            if eps.re <= 0.0 {
                return Err(Error::input(format!(
                    "FDTD needs media with a positive real permittivity, not {eps}; use RCWA"
                )));
            }
        }
        Ok(diffraction)
    }

    fn solve(&self, medium: &Medium, diffraction: &DiffractionOrders) -> Result<CrystalResponse> {
        let (grid, material) =
            Grid::new(medium, diffraction, self.cells_per_um, self.absorber_um, self.offset, None)?;
        let runs = [self.run(&material, diffraction, &grid, 0)?, self.run(&material, diffraction, &grid, 1)?];
        let orders = diffraction
            .propagating()
            .into_iter()
            .map(|m| diffraction.order(m, std::array::from_fn(|q| runs[q].order(diffraction, &grid, m))))
            .collect();
        let (mut transmitted, mut absorbed) = ([0.0; 2], [0.0; 2]);
        for q in 0..2 {
            let incident = incident_flux(diffraction, &grid, q);
            transmitted[q] = runs[q].transmitted(&grid) / incident;
            absorbed[q] = runs[q].absorbed(&material, diffraction, &grid) / incident;
            if diffraction.host_eps.im > 0.0 {
                // What the host takes between the lowest edge and the exit passed the edge.
                let below = runs[q].absorbed_below_the_edge(&material, diffraction, &grid) / incident;
                transmitted[q] += below;
                absorbed[q] = (absorbed[q] - below).max(0.0);
            }
        }
        Ok(CrystalResponse { orders, transmitted, absorbed, convergence: None })
    }

    /// One polarization, until the fields have gone.
    fn run(
        &self,
        material: &Material,
        diffraction: &DiffractionOrders,
        grid: &Grid,
        polarization: usize,
    ) -> Result<Spectrum> {
        let (beta, kx) = (diffraction.b * diffraction.k, diffraction.a0 * diffraction.k);
        let mut fields = Fields::new(grid, material, beta, kx, self.width);
        let source = source(diffraction, grid, polarization);
        // Grazing frequency over this one's: the band ends there.
        let index = diffraction.n;
        let graze = ((diffraction.a0 / index).hypot(diffraction.b / index)).min(1.0 - 1e-9);
        let tau = (PULSE / (1.0 - graze)).max(SHORTEST) / grid.omega;
        let start = 4.5 * tau;
        if 2.0 * start * grid.omega > LONGEST_PULSE * std::f64::consts::TAU {
            return Err(Error::not_settled(format!(
                "the incident wave is so near the horizon that its pulse takes {:.0} periods, past the limit of {}; use RCWA there",
                2.0 * start * grid.omega / std::f64::consts::TAU,
                LONGEST_PULSE
            )));
        }
        let pulse = |t: f64| (-0.5 * ((t - start) / tau).powi(2)).exp();
        let period = std::f64::consts::TAU / grid.omega;
        let stride = ((period / SAMPLES / grid.dt) as usize).max(1);
        let mut spectrum = Spectrum::new(grid);
        let mut before = spectrum.clone();
        let mut factors = Vec::with_capacity(stride);
        let last = (2.0 * start / grid.dt) as usize / stride + self.periods * SAMPLES as usize;
        for sample in 1..=last {
            let n = (sample - 1) * stride;
            factors.clear();
            factors.extend((n..n + stride).map(|n| {
                [n as f64, n as f64 + 0.5].map(|step| {
                    let t = step * grid.dt;
                    Complex64::from_polar(pulse(t), -grid.omega * t)
                })
            }));
            fields.advance(&source, &factors);
            let t = (n + stride) as f64 * grid.dt;
            spectrum.add(grid, &fields, t, [pulse(t), pulse(t - 0.5 * grid.dt)]);
            if !sample.is_multiple_of(CHECK) {
                continue;
            }
            let change = spectrum.change(&before);
            if !change.is_finite() && t > start {
                return Err(Error::not_settled("the fields on the grid grew without bound"));
            }
            if t > start + 4.0 * tau && change < self.tolerance {
                spectrum.normalize();
                return Ok(spectrum);
            }
            before.clone_from(&spectrum);
        }
        Err(Error::not_settled(format!(
            "fields still change by more than {} after {} periods; allow more, or use another solver near grazing",
            self.tolerance, self.periods
        )))
    }
}

/// Distance of the grazing frequency from the pulse's, in widths of its spectrum.
const PULSE: f64 = 2.0;
/// Longest pulse, periods of the wave: to 89.1° from the normal.
const LONGEST_PULSE: f64 = 25_000.0;
/// Shortest pulse, τω.
const SHORTEST: f64 = 4.0;

/// Incident (E_x, E_y, H̃_x, H̃_y) at z = 0, travelling down.
fn incident_fields(diffraction: &DiffractionOrders, polarization: usize) -> [Complex64; 4] {
    let [e, h] = diffraction.incident(polarization);
    let (eps, kappa, q) = (diffraction.n * diffraction.n, diffraction.kappa(), diffraction.q_above(0).re);
    let ba = diffraction.b * diffraction.a0;
    [(-q * h - ba * e) / kappa, e, (eps * q * e - ba * h) / kappa, h].map(Complex64::from)
}

fn source(diffraction: &DiffractionOrders, grid: &Grid, polarization: usize) -> Source {
    let [ex, ey, hx, hy] = incident_fields(diffraction, polarization);
    let kz = grid.kz(diffraction, 0).re;
    let at = |value: Complex64, half_x: f64, half_z: f64| {
        let phase = |i: usize| {
            diffraction.a0 * diffraction.k * (i as f64 + half_x) * grid.spacing
                - kz * grid.z(grid.source as f64 + half_z)
        };
        (0..grid.nx).map(|i| value * Complex64::from_polar(1.0, phase(i))).collect()
    };
    Source {
        plane: grid.source,
        e_x: at(ex, 0.5, 0.0),
        e_y: at(ey, 0.0, 0.0),
        h_x: at(hx, 0.0, 0.5),
        h_y: at(hy, 0.5, 0.5),
    }
}

/// Power of the incident wave through a row of cells, E at a plane and H̃ half a cell below.
fn incident_flux(diffraction: &DiffractionOrders, grid: &Grid, polarization: usize) -> f64 {
    let [ex, ey, hx, hy] = incident_fields(diffraction, polarization);
    let lag = Complex64::from_polar(1.0, grid.kz(diffraction, 0).re * grid.spacing / 2.0);
    grid.nx as f64 * (ey * (hx * lag).conj() - ex * (hy * lag).conj()).re
}
