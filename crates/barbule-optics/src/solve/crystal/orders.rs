//! The plane-wave orders of a periodic structure: wave vectors over k, and Jones matrices from the fields along y.

use super::{CrystalResponse, Incidence, Order, Surroundings};
use crate::math::roots::decaying_root;
use crate::{Complex64, Result};

/// Below this q² (over k²) an order counts as evanescent, and |q| as its root: at a Rayleigh anomaly waves that go up
/// and down are one and the same. Whatever q is used, the flux of the fields built from it stays balanced.
const GRAZING_Q_SQUARED: f64 = 1e-14;

/// Wave vectors over k = 2π/λ of the orders of one incident wave: (a_m, b, ±q_m).
#[derive(Debug, Clone, Copy)]
pub(super) struct DiffractionOrders {
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

impl DiffractionOrders {
    /// The orders of a wave that is checked here.
    ///
    /// # Errors
    /// The wave has no meaning for any solver.
    pub(super) fn new(surroundings: &Surroundings, incidence: &Incidence) -> Result<Self> {
        incidence.check(surroundings)?;
        let Surroundings { period_um, incidence_eps, host_eps } = *surroundings;
        let n = incidence_eps.sqrt();
        let wavelength_um = incidence.wavelength_nm * 1e-3;
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
    pub(super) fn difference(&self, a: &CrystalResponse, b: &CrystalResponse) -> f64 {
        let pairs = a.orders.iter().zip(&b.orders).map(|(a, b)| (self.power(a), self.power(b)));
        pairs.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).map(f64::abs).fold(0.0, f64::max)
    }
}

/// The root of a wave that decays or goes forth, away from zero.
pub(super) fn root(q_squared: Complex64) -> Complex64 {
    if q_squared.norm() < GRAZING_Q_SQUARED {
        return Complex64::new(0.0, GRAZING_Q_SQUARED.sqrt());
    }
    decaying_root(q_squared)
}
