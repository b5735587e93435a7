//! The scalar sum beside Maxwell's equations: ridges along y, whose orders are known both ways.
//!
//! A period of heights h(x) over a body of index n is solved by Fourier modes ([`Rcwa`]): grooves of air in the body, sliced. By the scalar
//! sum the order of direction ω_m carries R Γ |c_m|² of the incident power, which is ∫ f cosθ_o dω_o over its lobe.

use glam::DVec3;

use super::spectrum;
use crate::progress::Unobserved;
use crate::scattering::grating::{Coherence, Normalization, Place, Setup};
use crate::solve::crystal::rcwa::profile::{Body, Outline};
use crate::solve::crystal::{Incidence, Rcwa, Surroundings};
use crate::spectrum::Wavelengths;
use crate::structure::Heightfield;
use crate::{Complex64, Error, Result};

/// A reflected order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderPower {
    /// Its number: the component of its direction along x is −sinφ_i + mλ/d.
    pub m: i32,
    /// That component.
    pub sine: f64,
    /// Its power over the incident power by the scalar sum, for light with its electric field along the ridges and across them: of these
    /// the sum knows Fresnel's reflectances at the half angle alone. Their mean is what the sum says of unpolarized light.
    pub scalar: [f64; 2],
    /// The same exactly.
    pub exact: [f64; 2],
}

/// All orders of ridges under one wave.
#[derive(Debug, Clone, PartialEq)]
pub struct RidgeOrders {
    /// m ascending.
    pub orders: Vec<OrderPower>,
    /// The exact solver's estimate of its own error of a power.
    pub uncertainty: f64,
}

impl OrderPower {
    /// Scalar and exact power of unpolarized light.
    #[must_use]
    pub fn unpolarized(&self) -> [f64; 2] {
        [self.scalar, self.exact].map(|[along, across]| 0.5 * (along + across))
    }

    /// Scalar and exact power by polarization: 0 along the ridges, 1 across them.
    #[must_use]
    pub fn polarized(&self, polarization: usize) -> [f64; 2] {
        [self.scalar[polarization], self.exact[polarization]]
    }
}

impl RidgeOrders {
    /// Powers of all orders, scalar and exact, as `of` has them of each.
    #[must_use]
    pub fn whole(&self, of: impl Fn(&OrderPower) -> [f64; 2]) -> [f64; 2] {
        self.orders.iter().map(of).fold([0.0; 2], |[a, b], [scalar, exact]| [a + scalar, b + exact])
    }

    /// Share of the light that the scalar sum puts into wrong orders, invents or loses: Σ |scalar − exact| over Σ exact.
    #[must_use]
    pub fn misplaced(&self, of: impl Fn(&OrderPower) -> [f64; 2]) -> f64 {
        let apart: f64 = self.orders.iter().map(&of).map(|[scalar, exact]| (scalar - exact).abs()).sum();
        apart / self.whole(of)[1]
    }
}

/// Orders of ridges with these heights over one period (a field of one row) of a body of index `index` in air, under light of a wavelength
/// from the azimuth `phi_i` (rad) across them.
///
/// # Errors
/// Heights along y too, a wave or an index without meaning, eigenvalues that were not found.
pub fn ridge_orders(
    period: &Heightfield,
    index: f64,
    wavelength_nm: f64,
    phi_i: f64,
    solver: &Rcwa,
) -> Result<RidgeOrders> {
    if period.cells()[1] != 1 {
        return Err(Error::input("ridges have one row of heights; these have several"));
    }
    let period_um = period.size_um()[0];
    let surroundings = Surroundings::new(period_um, 1.0, Complex64::from(index * index))?;
    let incidence = Incidence { wavelength_nm, theta_i: 0.0, phi_i };
    let exact = solver.respond_to(&surroundings, &grooves(period), &incidence)?;
    let at = Wavelengths::new([wavelength_nm])?;
    // So wide that each order is alone.
    let coherence = Coherence::Fixed(1000.0);
    let setup = Setup {
        coherence,
        place: Place::Anywhere,
        normalization: Normalization::Energy,
        index,
        ..Setup::default()
    };
    let lobe = setup.of_wavelength(1e-3 * wavelength_nm);
    let w_i = DVec3::new(phi_i.sin(), 0.0, phi_i.cos());
    let orders = exact
        .orders
        .iter()
        .map(|order| {
            let sine = -w_i.x + f64::from(order.m) * 1e-3 * wavelength_nm / period_um;
            let w_o = DVec3::new(sine, 0.0, (1.0 - sine * sine).max(0.0).sqrt());
            let unpolarized = spectrum(period, &setup, &at, w_i, w_o, &Unobserved)?[0] / lobe;
            let along = share_along((0.5 * (1.0 + w_i.dot(w_o))).sqrt(), index);
            let scalar = [along * unpolarized, (2.0 - along) * unpolarized];
            Ok(OrderPower { m: order.m, sine, scalar, exact: order.reflectance(phi_i) })
        })
        .collect::<Result<_>>()?;
    Ok(RidgeOrders { orders, uncertainty: exact.convergence.unwrap_or(0.0) })
}

/// Fresnel's reflectance across the plane of incidence, over that of unpolarized light.
fn share_along(cosine: f64, index: f64) -> f64 {
    let inside = (1.0 - (1.0 - cosine * cosine) / (index * index)).sqrt();
    let along = (cosine - index * inside) / (cosine + index * inside);
    let across = (index * cosine - inside) / (index * cosine + inside);
    2.0 * along * along / (along * along + across * across)
}

/// Air above the heights, down from the highest.
fn grooves(period: &Heightfield) -> Vec<Body> {
    let heights = period.height_um();
    let step = period.pitch_um()[0];
    let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    if highest - lowest < 1e-9 {
        return Vec::new();
    }
    let at = |i: usize| [step * i as f64, highest - heights[i % heights.len()]];
    let mut points = vec![[0.0, 0.0], [step * heights.len() as f64, 0.0]];
    points.extend((0..=heights.len()).rev().map(at));
    vec![Body { x_um: 0.0, depth_um: 0.0, outline: Outline::Polygon(points), eps: Complex64::ONE }]
}
