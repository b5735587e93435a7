//! Cylinder multipoles: circular rods, hollow or not, by lattice multiple scattering. No discretization, hence errors
//! that fall exponentially with the number of multipoles.
//!
//! Around each rod the fields E_y and H̃_y are cylindrical waves; a T-matrix (coupled by k_y ≠ 0) belongs to each kind of
//! rod, lattice sums couple a rod to the copies of itself and of rods at about the same depth, plane waves couple
//! layers of rods with each other and with the flat surface, whose conical Fresnel matrices are exact for evanescent
//! orders too. Sources: Yasumoto & Yoshitomi 1999 (IEEE Trans. Antennas Propag. 47, 1050) for arrays of cylinders, Linton
//! 2010 (SIAM Review 52, 630) for lattice sums; the formulas stand in the submodules.

mod lattice;
mod layer;
mod orders;
mod plan;
mod rod;
mod stack;
#[cfg(test)]
mod tests;

use num_complex::Complex64;

use super::cell::{check_angle, check_wavelength};
use super::solver::unless_cancelled;
use super::{Cell, CrystalResponse, CrystalSolver, Incidence, Order};
use crate::math::dense::Dense;
use crate::math::roots::decaying_root;
use crate::progress::Progress;
use crate::{Error, Result};

use lattice::LatticeSums;
use layer::{Frame, Scattering};
use orders::{Orders, Surface, flux_down};
use plan::{Plan, Sizes};
use rod::{RodTable, series};
use stack::Fields;

/// The error of R that the solver asks of itself by default.
pub const TOLERANCE: f64 = 1e-9;

/// Waves with a smaller cosθ are refused: κ in air is too small beside k.
const LEAST_COSINE: f64 = 1e-7;

/// The solver; see the module.
#[derive(Debug, Clone, Copy)]
pub struct Multipole {
    /// Estimated error of R at which the sizes of the expansions stop growing, at least 1e-11.
    pub tolerance: f64,
}

impl Default for Multipole {
    fn default() -> Self {
        Self { tolerance: TOLERANCE }
    }
}

impl CrystalSolver for Multipole {
    fn respond(&self, cell: &Cell, incidence: &Incidence) -> Result<CrystalResponse> {
        self.prepare(cell, incidence.wavelength_nm, incidence.theta_i)?.respond(incidence.phi_i)
    }

    fn respond_to_azimuths(
        &self,
        cell: &Cell,
        wavelength_nm: f64,
        theta_i: f64,
        phi_i: &[f64],
        progress: &dyn Progress,
    ) -> Result<Vec<CrystalResponse>> {
        let prepared = self.prepare(cell, wavelength_nm, theta_i)?;
        let one = |&phi_i: &f64| {
            unless_cancelled(progress)?;
            prepared.respond(phi_i)
        };
        phi_i.iter().map(one).collect()
    }
}

impl Multipole {
    /// What depends on wavelength and θ_i alone, for use with many φ_i. θ_i in rad.
    ///
    /// # Errors
    /// The wave has no meaning or is too near the horizon, or cylinder functions leave the range of numbers.
    pub fn prepare(&self, cell: &Cell, wavelength_nm: f64, theta_i: f64) -> Result<PreparedCell> {
        check_wavelength(&cell.surroundings(), wavelength_nm)?;
        check_angle("theta", theta_i)?;
        let plan = Plan::new(cell);
        let wave = Wave::new(cell, wavelength_nm, theta_i)?;
        let sizes = plan.sizes(&wave, self.tolerance);
        let tables = plan.tables(&wave, &sizes)?;
        Ok(PreparedCell { plan, wave, cos_theta: theta_i.cos(), tolerance: self.tolerance, sizes, tables })
    }
}

/// One wavelength and one k_y.
#[derive(Debug, Clone, Copy)]
struct Wave {
    /// 2π/λ and k_y, µm⁻¹.
    k0: f64,
    ky: f64,
    /// √(k₀²ε − k_y²) of the host and of the medium above, µm⁻¹.
    kappa: Complex64,
    kappa0: f64,
    /// Relative permittivities of the host and of the medium above.
    eps: Complex64,
    eps0: f64,
}

impl Wave {
    fn new(cell: &Cell, wavelength_nm: f64, theta_i: f64) -> Result<Self> {
        if theta_i.cos() <= LEAST_COSINE {
            return Err(Error::input(format!(
                "theta is {}°, too near the horizon for multipoles; use the Fourier modal solver",
                theta_i.to_degrees()
            )));
        }
        let k0 = crate::spectrum::wave_number_per_um(wavelength_nm);
        let n = cell.incidence_eps.sqrt();
        let kappa0 = k0 * n * theta_i.cos();
        let square = k0 * k0 * (cell.host_eps - cell.incidence_eps) + kappa0 * kappa0;
        let least = 1e-14 * k0 * k0;
        let kappa = decaying_root(if square.norm() < least { Complex64::new(least, 0.0) } else { square });
        Ok(Self {
            k0,
            ky: -k0 * n * theta_i.sin(),
            kappa,
            kappa0,
            eps: cell.host_eps,
            eps0: cell.incidence_eps,
        })
    }
}

/// A cell prepared for one wavelength and one θ_i.
#[derive(Debug, Clone)]
pub struct PreparedCell {
    plan: Plan,
    wave: Wave,
    cos_theta: f64,
    tolerance: f64,
    sizes: Sizes,
    tables: Vec<RodTable>,
}

/// Estimated error of R from the last multipoles of each kind of rod and from the last orders between layers.
struct Estimate {
    kinds: Vec<f64>,
    orders: f64,
}

impl Estimate {
    fn worst(&self) -> f64 {
        self.kinds.iter().copied().fold(self.orders, f64::max)
    }
}

impl PreparedCell {
    /// The response to both polarizations from azimuth `phi_i`, rad. Sizes grow until the estimated error is small
    /// enough; they start anew for every call, so that results do not depend on what was asked before.
    ///
    /// # Errors
    /// `phi_i` not within ±π/2, or expansions that did not settle.
    pub fn respond(&self, phi_i: f64) -> Result<CrystalResponse> {
        check_angle("phi", phi_i)?;
        let (response, estimate) = self.evaluate(&self.sizes, &self.tables, phi_i)?;
        if estimate.worst() <= self.tolerance {
            return Ok(response);
        }
        let mut sizes = self.sizes.clone();
        let mut estimate = estimate;
        while sizes.grow(&estimate.kinds, estimate.orders, self.tolerance, self.plan.period) {
            let tables = self.plan.tables(&self.wave, &sizes)?;
            let (response, found) = self.evaluate(&sizes, &tables, phi_i)?;
            if found.worst() <= self.tolerance {
                return Ok(response);
            }
            estimate = found;
        }
        Err(Error::not_settled(format!(
            "the multipole expansion did not settle: its error is about {:.1e} at {} multipoles; use the Fourier modal solver",
            estimate.worst(),
            sizes.multipoles.iter().max().unwrap_or(&0)
        )))
    }

    /// The response with exactly this many multipoles per rod, whatever the error: for studies of convergence.
    ///
    /// # Errors
    /// `phi_i` not within ±π/2, or cylinder functions that leave the range of numbers.
    pub fn respond_with(&self, multipoles: usize, phi_i: f64) -> Result<CrystalResponse> {
        check_angle("phi", phi_i)?;
        let sizes = Sizes { multipoles: vec![multipoles; self.sizes.multipoles.len()], ..self.sizes };
        let tables = self.plan.tables(&self.wave, &sizes)?;
        Ok(self.evaluate(&sizes, &tables, phi_i)?.0)
    }

    fn evaluate(
        &self,
        sizes: &Sizes,
        tables: &[RodTable],
        phi_i: f64,
    ) -> Result<(CrystalResponse, Estimate)> {
        let (plan, wave) = (&self.plan, &self.wave);
        let alpha0 = -wave.kappa0 * phi_i.sin();
        let (first, last) = sizes.orders(alpha0, plan.period);
        let window = lattice::window(wave.kappa, alpha0, plan.period);
        let q_max = 2 * sizes.multipoles.iter().max().unwrap_or(&0);
        let margin = if plan.displaced { q_max as i32 / 4 } else { 0 };
        let all =
            Orders::new(wave, alpha0, plan.period, first.min(window.0 - margin), last.max(window.1 + margin));
        let orders = all.part(first, last);
        let reach = if plan.displaced { LatticeSums::reach(q_max) } else { q_max };
        let lattice = LatticeSums::new(wave.kappa, alpha0, plan.period, &all, reach);
        let frames = plan
            .shapes
            .iter()
            .map(|places| Frame::new(&orders, &all, &lattice, plan.period, tables, places))
            .collect::<Result<Vec<_>>>()?;
        let shapes: Vec<_> = frames.iter().map(Frame::scattering).collect();
        let surfaces: Vec<_> = (first..=last)
            .map(|m| {
                let at = orders.index(m);
                Surface::new(
                    wave,
                    orders.alpha[at],
                    self.gamma_above(orders.alpha[at], m, phi_i),
                    orders.gamma[at],
                )
            })
            .collect();
        let levels: Vec<_> = plan.layers.iter().map(|layer| layer.level).collect();
        let fields = stack::solve(&orders, &surfaces, &shapes, &levels, plan.first_gap);
        Ok(self.collect(&orders, &surfaces, &frames, &shapes, &fields, phi_i))
    }

    /// γ of order m in the medium above.
    fn gamma_above(&self, alpha: f64, m: i32, phi_i: f64) -> Complex64 {
        if m == 0 {
            return Complex64::new(self.wave.kappa0 * phi_i.cos(), 0.0);
        }
        let square = (self.wave.kappa0 - alpha) * (self.wave.kappa0 + alpha);
        if square >= 0.0 { Complex64::new(square.sqrt(), 0.0) } else { Complex64::new(0.0, (-square).sqrt()) }
    }

    fn collect(
        &self,
        orders: &Orders,
        surfaces: &[Surface],
        frames: &[Frame<'_>],
        shapes: &[Scattering],
        fields: &Fields,
        phi_i: f64,
    ) -> (CrystalResponse, Estimate) {
        let (wave, n) = (&self.wave, self.wave.eps0.sqrt());
        let grazing = (wave.kappa0 * phi_i.cos()).max(1e-12 * wave.k0);
        // twice the flux of a wave with E_y = 1 or with H̃_y = 1
        let incident = [n * phi_i.cos() / self.cos_theta, phi_i.cos() / (n * self.cos_theta)]
            .map(|flux| flux.max(f64::MIN_POSITIVE));
        let lowest = fields.gaps.last().map_or(&fields.surface[0], |gap| &gap[0]);
        let transmitted = [0, 1].map(|q| {
            let down = lowest.column(q);
            let flux =
                |m: usize| flux_down(wave, orders.alpha[m], orders.gamma[m], down[m], down[m + orders.len()]);
            (0..orders.len()).map(flux).sum::<f64>() / incident[q]
        });
        let mut absorbed = [0.0; 2];
        let mut beyond = [0, 1].map(|_| vec![0.0; self.plan.kinds.len()]);
        for (shape, frame) in frames.iter().enumerate() {
            let of_shape =
                || self.plan.layers.iter().zip(&fields.layers).filter(move |(l, _)| l.level.shape == shape);
            let [down, up] = [0, 1].map(|way| Dense::beside(of_shape().map(|(_, waves)| &waves[way])));
            for (case, places) in frame.multipoles(&shapes[shape], &down, &up).iter().enumerate() {
                for (place, a) in frame.places.iter().zip(places) {
                    let table = &frame.tables[place.kind];
                    let power: f64 =
                        (0..).zip(a).map(|(i, &a)| table.power_in(wave, i - table.m() as i32, a)).sum();
                    absorbed[case % 2] += power / (self.plan.period * incident[case % 2]);
                    beyond[case % 2][place.kind] += table.beyond(a) * 4.0 / (self.plan.period * grazing);
                }
            }
        }
        let gaps = fields.gaps.iter().chain([&fields.surface]);
        let left_out = [0, 1].map(|q| {
            gaps.clone()
                .map(|[down, up]| orders_beyond(orders, down.column(q), up.column(q)) / grazing)
                .sum::<f64>()
        });
        let kinds = beyond[0].iter().zip(&beyond[1]).map(|(a, b): (&f64, &f64)| a.max(*b)).collect();
        let estimate = Estimate { kinds, orders: left_out[0].max(left_out[1]) };
        let reflected = self.reflected(orders, surfaces, &fields.surface[1], phi_i);
        let convergence = Some(estimate.worst());
        let mut response = CrystalResponse { orders: reflected, transmitted, absorbed, convergence };
        if wave.eps.im > 0.0 {
            // The flux into the rods is not what the host takes around them, of which there is no sum of its own.
            let reflectance = response.reflectance(phi_i);
            response.absorbed = [0, 1].map(|q| (1.0 - reflectance[q] - transmitted[q]).max(0.0));
        }
        (response, estimate)
    }

    /// Propagating orders above the surface.
    fn reflected(&self, orders: &Orders, surfaces: &[Surface], rising: &Dense, phi_i: f64) -> Vec<Order> {
        let (count, n) = (orders.len(), self.wave.eps0.sqrt());
        let mut found = Vec::new();
        for (i, surface) in surfaces.iter().enumerate() {
            let m = orders.first + i as i32;
            let sine = orders.alpha[i] / self.wave.kappa0;
            if m != 0 && sine.abs() >= 1.0 {
                continue;
            }
            let mut jones = [[Complex64::new(0.0, 0.0); 2]; 2];
            for q in 0..2 {
                let up = [rising[(i, q)], rising[(i + count, q)]];
                let out = [0, 1].map(|row| {
                    let direct = if m == 0 { surface.r[row][q] } else { Complex64::new(0.0, 0.0) };
                    direct + surface.t_below[row][0] * up[0] + surface.t_below[row][1] * up[1]
                });
                // E along e₁ has E_y = cosθ; incident E along e₂ has H̃_y = −n cosθ, outgoing +n cosθ
                let scale = if q == 0 { 1.0 } else { -n };
                jones[0][q] = out[0] * scale;
                jones[1][q] = out[1] * (scale / n);
            }
            let phi_o = if m == 0 { -phi_i } else { sine.asin() };
            found.push(Order { m, phi_o, jones });
        }
        found
    }
}

/// Σ|γ D U| over the orders beyond the last on either side.
fn orders_beyond(orders: &Orders, down: &[Complex64], up: &[Complex64]) -> f64 {
    let count = orders.len();
    let size = |m: usize| {
        let product = |at: usize| (down[at].norm_sqr() * up[at].norm_sqr()).sqrt();
        product(m).max(product(m + count)) * orders.gamma[m].norm()
    };
    if count < 2 { size(0) } else { series(size(0), size(1)) + series(size(count - 1), size(count - 2)) }
}
