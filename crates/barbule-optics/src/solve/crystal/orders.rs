//! The plane-wave orders of a grating: wave vectors over k, and Jones matrices from the fields along y.

use super::{Cell, Incidence, Order, Response};
use crate::{Complex64, Error, Result};

/// Below this q² (over k²) an order counts as evanescent, and |q| as its root: at a Rayleigh anomaly waves that go up
/// and down are one and the same. Whatever q is used, the flux of the fields built from it stays balanced.
const GRAZING_Q_SQUARED: f64 = 1e-14;

/// Longest period, in wavelengths of the incidence medium: orders as many on either side are solved for.
const LONGEST_PERIOD: f64 = 100.0;

/// Wave vectors over k = 2π/λ of the orders of one incident wave: (a_m, b, ±q_m).
#[derive(Debug, Clone, Copy)]
pub(super) struct Grating {
    /// 2π/λ, 1/µm.
    pub k: f64,
    /// Refractive index of the incidence medium.
    pub n: f64,
    /// k_x/k of the incident wave, −n cosθ sinφ.
    pub a0: f64,
    /// λ/Δ.
    pub step: f64,
    /// k_y/k of all waves, −n sinθ.
    pub b: f64,
    pub cos_theta: f64,
    cos_phi: f64,
    pub host_eps: Complex64,
}

impl Grating {
    /// The orders of a cell's medium, with everything checked that both solvers need.
    pub(super) fn new(
        period_um: f64,
        incidence_eps: f64,
        host_eps: Complex64,
        incidence: &Incidence,
    ) -> Result<Self> {
        positive("period", period_um)?;
        positive("permittivity of the incidence medium", incidence_eps)?;
        passive("host", host_eps)?;
        positive("wavelength", incidence.wavelength_nm)?;
        for (name, angle) in [("theta", incidence.theta_i), ("phi", incidence.phi_i)] {
            if angle.is_nan() || angle.abs() >= std::f64::consts::FRAC_PI_2 {
                return Err(Error::input(format!(
                    "{name} is {}°, at or past grazing; give an angle between -90 and 90",
                    angle.to_degrees()
                )));
            }
        }
        let n = incidence_eps.sqrt();
        let wavelength_um = incidence.wavelength_nm * 1e-3;
        if period_um * n > LONGEST_PERIOD * wavelength_um {
            return Err(Error::input(format!(
                "the period of {period_um} µm is more than {LONGEST_PERIOD} wavelengths, too long for a periodic solver"
            )));
        }
        let (sin_theta, cos_theta) = incidence.theta_i.sin_cos();
        let (sin_phi, cos_phi) = incidence.phi_i.sin_cos();
        Ok(Self {
            k: std::f64::consts::TAU / wavelength_um,
            n,
            a0: -n * cos_theta * sin_phi,
            step: wavelength_um / period_um,
            b: -n * sin_theta,
            cos_theta,
            cos_phi,
            host_eps,
        })
    }

    /// k_x/k of an order.
    pub(super) fn a(&self, m: i32) -> f64 {
        self.a0 + f64::from(m) * self.step
    }

    /// κ = n² − b² = n² cos²θ of the incidence medium.
    pub(super) fn kappa(&self) -> f64 {
        (self.n * self.cos_theta).powi(2)
    }

    /// q above the surface.
    pub(super) fn q_above(&self, m: i32) -> Complex64 {
        if m == 0 {
            return Complex64::from(self.n * self.cos_theta * self.cos_phi);
        }
        let (c, a) = (self.n * self.cos_theta, self.a(m));
        root(Complex64::from((c - a) * (c + a)))
    }

    /// q in the host.
    pub(super) fn q_host(&self, m: i32) -> Complex64 {
        root(self.host_eps - self.b * self.b - self.a(m) * self.a(m))
    }

    /// Numbers of the reflected orders that carry power, ascending.
    pub(super) fn propagating(&self) -> Vec<i32> {
        let reach = ((2.0 * self.n) / self.step).ceil() as i32 + 1;
        (-reach..=reach).filter(|&m| self.q_above(m).re > 0.0).collect()
    }

    /// The incident wave's (E_y, H̃_y) in the given polarization (0: E along e₁, 1: E along e₂).
    pub(super) fn incident(&self, polarization: usize) -> [f64; 2] {
        if polarization == 0 { [self.cos_theta, 0.0] } else { [0.0, -self.n * self.cos_theta] }
    }

    /// A reflected order from its (E_y, H̃_y) per incident polarization: E = J₁e₁ + J₂e₂ has E_y = J₁ cosθ, and
    /// H̃ = nω×E has H̃_y = n J₂ cosθ.
    pub(super) fn order(&self, m: i32, fields: [[Complex64; 2]; 2]) -> Order {
        let cosine = (self.q_above(m).re / (self.n * self.cos_theta)).min(1.0);
        let sine = self.a(m) / (self.n * self.cos_theta);
        let jones = std::array::from_fn(|out| {
            std::array::from_fn(|polarization| {
                let scale = if out == 0 { self.cos_theta } else { self.n * self.cos_theta };
                fields[polarization][out] / scale
            })
        });
        Order { m, phi_o: sine.atan2(cosine), jones }
    }

    /// Power of a reflected order over incident power, per incident polarization.
    pub(super) fn power(&self, order: &Order) -> [f64; 2] {
        let scale = self.q_above(order.m).re / self.q_above(0).re;
        std::array::from_fn(|q| scale * (order.jones[0][q].norm_sqr() + order.jones[1][q].norm_sqr()))
    }

    /// Largest difference of an order's power between two responses to the same wave.
    pub(super) fn difference(&self, a: &Response, b: &Response) -> f64 {
        let pairs = a.orders.iter().zip(&b.orders).map(|(a, b)| (self.power(a), self.power(b)));
        pairs.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).map(f64::abs).fold(0.0, f64::max)
    }
}

/// The root with Im ≥ 0 (and Re ≥ 0 where it is real), away from zero.
pub(super) fn root(q_squared: Complex64) -> Complex64 {
    if q_squared.norm() < GRAZING_Q_SQUARED {
        return Complex64::new(0.0, GRAZING_Q_SQUARED.sqrt());
    }
    let q = q_squared.sqrt();
    if q.im < 0.0 || (q.im == 0.0 && q.re < 0.0) { -q } else { q }
}

/// Refuses all but positive finite numbers.
pub(super) fn positive(name: &str, value: f64) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::input(format!("the {name} is {value}, but it must be a positive number")))
}

/// Refuses media that are not finite, amplify, or have ε = 0.
pub(super) fn passive(name: &str, eps: Complex64) -> Result<()> {
    if eps.is_finite() && eps.im >= 0.0 && eps.norm() > 1e-12 {
        return Ok(());
    }
    Err(Error::input(format!(
        "the {name}'s relative permittivity is {eps}, but it must be finite, not 0, and have an imaginary part of at least 0"
    )))
}

/// Refuses rods that have no meaning or stick out of the surface.
pub(super) fn check_rods(cell: &Cell) -> Result<()> {
    for (index, rod) in cell.rods.iter().enumerate() {
        let place = |error: Error| error.at(format!("rod {index}"));
        positive("depth", rod.depth_um).map_err(place)?;
        if !rod.x_um.is_finite() || rod.shells.is_empty() {
            return Err(place(Error::input("it needs a finite position and at least one shell")));
        }
        let mut outer = f64::INFINITY;
        for shell in &rod.shells {
            positive("diameter", shell.diameter_um).map_err(place)?;
            passive("shell", shell.eps).map_err(place)?;
            if shell.diameter_um >= outer {
                return Err(place(Error::input(format!(
                    "its shells must be given outermost first, but {} follows {outer}",
                    shell.diameter_um
                ))));
            }
            outer = shell.diameter_um;
        }
        if rod.shells[0].diameter_um >= 2.0 * rod.depth_um {
            return Err(place(Error::input(format!(
                "its radius {} µm reaches the surface from a depth of {} µm; bury it deeper",
                rod.shells[0].diameter_um / 2.0,
                rod.depth_um
            ))));
        }
    }
    Ok(())
}
