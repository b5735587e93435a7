//! A grating of even waves, whose period and height are sliders: the orders of a sinusoidal surface, in closed form.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use barbule_appearance::bsdf;
use barbule_light::scattering::grating::{Orders, Powers};

use crate::Result;

/// Terms of the Chebyshev series over κ.
const TERMS: usize = 20;
/// The shortest wavelength of which a series knows, µm: the renderer's band begins there.
const SHORTEST_UM: f64 = 0.36;
/// Standard deviation of the window of coherence, µm: a few periods, so that the orders of neighbouring wavelengths run into each other.
const COHERENCE_UM: f64 = 3.0;
/// Refractive index of the surface, and the colour of the pigment beneath, linear sRGB.
const INDEX: f64 = 1.56;
const PIGMENT: [f64; 3] = [0.02, 0.018, 0.016];

/// Ridges across the surface: heights (`height_um`/2) cos(2πx/`period_um`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ridges {
    /// From ridge to ridge, µm.
    pub period_um: f64,
    /// From the lowest place to the highest, µm.
    pub height_um: f64,
}

impl Default for Ridges {
    fn default() -> Self {
        Self { period_um: 1.6, height_um: 0.12 }
    }
}

impl Ridges {
    /// The periods that the slider reaches, µm.
    pub const PERIODS_UM: [f64; 2] = [0.5, 4.0];
    /// The heights that the slider reaches, µm.
    pub const HEIGHTS_UM: [f64; 2] = [0.02, 0.3];

    /// Powers |c_j(κ)|² of the orders.
    ///
    /// A wave of phase κ a cos(2πx/T) is the sum of i^j J_j(κa) exp(2πijx/T) (Jacobi and Anger), a half the height, so
    /// |c_j|² = J_j²(κa); as Chebyshev series by their values at the series' own nodes.
    ///
    /// # Errors
    /// A period out of range.
    pub fn powers(&self) -> Result<Powers> {
        let kappa_most = 2.0 * TAU / SHORTEST_UM;
        let amplitude = 0.5 * self.height_um;
        // Further orders hold less than 1e-6 of the power.
        let most = (kappa_most * amplitude).ceil() as i32 + 6;
        let node = |k: usize| libm::cos(PI * (k as f64 + 0.5) / TERMS as f64);
        let mut series = Vec::with_capacity((2 * most as usize + 1) * TERMS);
        for order in -most..=most {
            let values: Vec<f64> = (0..TERMS)
                .map(|k| libm::jn(order.abs(), 0.5 * (node(k) - 1.0) * kappa_most * amplitude).powi(2))
                .collect();
            series.extend((0..TERMS).map(|term| {
                let of = |(k, value): (usize, &f64)| {
                    value * libm::cos(PI * term as f64 * (k as f64 + 0.5) / TERMS as f64)
                };
                let sum: f64 = values.iter().enumerate().map(of).sum();
                (sum * if term == 0 { 1.0 } else { 2.0 } / TERMS as f64) as f32
            }));
        }
        let orders = Orders { most: [most as usize, 0], period_um: [self.period_um; 2] };
        Powers::new(orders, kappa_most, TERMS, series)
    }

    /// The surface, dark beneath.
    ///
    /// # Errors
    /// A period out of range.
    pub fn surface(&self) -> Result<bsdf::Grating> {
        bsdf::Grating::new(&Arc::new(self.powers()?), COHERENCE_UM, INDEX, PIGMENT)
    }

    /// Where the first order of a wavelength (µm) leaves for light from straight above, rad; nothing where it does not.
    #[must_use]
    pub fn first_order(&self, wavelength_um: f64) -> Option<f64> {
        let sine = wavelength_um / self.period_um;
        (sine < 1.0).then(|| sine.asin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the ends of both sliders the series are the squares of the Bessel functions, and all orders together have all the power.
    #[test]
    fn orders_are_those_of_a_sine() {
        for height_um in Ridges::HEIGHTS_UM {
            let ridges = Ridges { height_um, ..Ridges::default() };
            let powers = ridges.powers().unwrap();
            for kappa in [-0.3, -7.0, -20.0, -34.0] {
                let all = powers.all_at(kappa);
                let most = powers.orders().most[0];
                assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-4, "{height_um} {kappa}");
                for (place, power) in all.iter().enumerate() {
                    let order = place.abs_diff(most) as i32;
                    let expected = libm::jn(order, 0.5 * kappa * height_um).powi(2);
                    assert!((power - expected).abs() < 1e-5, "{height_um} {kappa} {order}");
                }
            }
        }
    }

    #[test]
    fn first_orders_leave_by_the_gratings_equation() {
        let ridges = Ridges { period_um: 1.0, ..Ridges::default() };
        assert!((ridges.first_order(0.5).unwrap() - PI / 6.0).abs() < 1e-12);
        assert_eq!(ridges.first_order(1.2), None);
    }
}
