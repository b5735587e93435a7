//! How far the simulation is off near grazing incidence: what it makes a flat perfect mirror reflect.
//!
//! A barbule of width W in its window g is lit over a projected width W cosφ_i, and its lobe of about λ/(W cosθ_i) in
//! sinφ_o ends at the horizon. Near grazing the lobe is no longer narrow, the part of it beyond the horizon is lost, and
//! the equivalent currents, which are those of an endless mirror, radiate too much or too little. A mirror shows it
//! undisturbed: with r_s = −1, r_p = +1 on a flat top the formulas give, for both polarizations,
//!
//! ```text
//! R = κ/(8π cosφ_i ∫g² dx) ∫ |G|² [(cosφ_i + cosφ_o)² + sin²θ_i (sinφ_i + sinφ_o)²] dφ_o,
//! G = ∫ g e^{−jκx(sinφ_i + sinφ_o)} dx,    κ = k cosθ_i,
//! ```
//!
//! which is 1 where the simulation holds.

use std::f64::consts::PI;
use std::sync::OnceLock;

use crate::spectrum::wave_number_per_um;

/// Where a mirror's reflected fraction is off by more than this, so are other reflectances, and they are flagged.
pub const LARGEST_MIRROR_ERROR: f64 = 0.03;

/// Values of the window's transform per unit of its argument, and the argument up to which it is kept: what lies beyond
/// holds less than 1e-5 of the power.
const PER_UNIT: f64 = 128.0;
const REACH: f64 = 16.0;

/// Steps of the quadrature over the window.
const STEPS: usize = 400;

/// Largest step of the quadrature over azimuths, as a phase over a quarter of the width.
const LARGEST_STEP: f64 = 0.2;

/// The fraction of the incident power that the simulation makes a flat perfect mirror reflect, `width_um` wide, in the
/// Gaussian window, at a vacuum wavelength (nm) and θ_i, φ_i (rad).
#[must_use]
pub fn mirror_fraction(width_um: f64, wavelength_nm: f64, theta_i: f64, phi_i: f64) -> f64 {
    // g = exp(−(x/a)²) over |x| ≤ 2a.
    let a = 0.25 * width_um;
    let size = wave_number_per_um(wavelength_nm) * theta_i.cos() * a;
    let window = Window::get();
    let (sin_i, cos_i) = phi_i.sin_cos();
    let [from, to] = [-REACH, REACH].map(|p| (p / size - sin_i).clamp(-1.0, 1.0).asin());
    let steps = (size * (to - from) / LARGEST_STEP).ceil().clamp(64.0, 4096.0);
    let step = (to - from) / steps;
    let sum: f64 = (0..steps as usize)
        .map(|n| {
            let (sin_o, cos_o) = (from + (n as f64 + 0.5) * step).sin_cos();
            let along = theta_i.sin() * (sin_i + sin_o);
            window.at(size * (sin_i + sin_o)).powi(2) * ((cos_i + cos_o).powi(2) + along * along)
        })
        .sum();
    size / (8.0 * PI * cos_i * window.power) * sum * step
}

/// The window e^{−t²} over |t| ≤ 2.
struct Window {
    /// ∫ e^{−t²} cos(pt) dt at p = n/[`PER_UNIT`].
    transform: Vec<f64>,
    /// ∫ e^{−2t²} dt.
    power: f64,
}

impl Window {
    fn get() -> &'static Self {
        static WINDOW: OnceLock<Window> = OnceLock::new();
        WINDOW.get_or_init(|| {
            let transform = (0..=(REACH * PER_UNIT) as usize + 1)
                .map(|n| integral(|t| (-t * t).exp() * (n as f64 / PER_UNIT * t).cos()))
                .collect();
            Self { transform, power: integral(|t| (-2.0 * t * t).exp()) }
        })
    }

    /// The transform, linear between its values.
    fn at(&self, p: f64) -> f64 {
        let place = (p.abs() * PER_UNIT).min(REACH * PER_UNIT);
        let (n, part) = (place as usize, place.fract());
        self.transform[n] * (1.0 - part) + self.transform[n + 1] * part
    }
}

/// ∫ of an even function over |t| ≤ 2 by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    let step = 2.0 / STEPS as f64;
    let weight = |n: usize| match n {
        0 | STEPS => 1.0,
        n if n % 2 == 1 => 4.0,
        _ => 2.0,
    };
    2.0 * step / 3.0 * (0..=STEPS).map(|n| weight(n) * f(n as f64 * step)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Complex64;
    use crate::material::Library;
    use crate::scattering::far_field::{Illumination, Window as Light};
    use crate::solve::surface::{Accuracy, far_field};
    use crate::structure::{Medium, Parts, Polyline, Section, Substance};

    fn mirror(width_um: f64) -> Section {
        let half = 0.5 * width_um;
        let parts = Parts {
            width_um: Some(width_um),
            boundaries: vec![Polyline { x_um: vec![-half, 0.0, half], z_um: vec![0.0; 3] }],
            media: vec![Medium::named("air"), Medium::Pure(Substance::Index(Complex64::new(0.0, 1e6)))],
            ..Parts::default()
        };
        Section::new(parts, Library::builtin()).unwrap()
    }

    #[test]
    fn the_closed_form_is_what_the_simulation_makes_of_a_mirror() {
        for (width, nm, theta, phi) in [
            (25.0, 694.0, 0.0, 0.0f64),
            (25.0, 694.0, 0.0, 75.0),
            (25.0, 694.0, 0.0, 85.0),
            (25.0, 694.0, 0.0, -89.9),
            (25.0, 400.0, 87.0, 0.0),
            (40.0, 550.0, 60.0f64, 80.0),
            (10.0, 694.0, -70.0, 60.0),
            (5.0, 600.0, 89.0, 20.0),
        ] {
            let (theta_i, phi_i) = (theta.to_radians(), phi.to_radians());
            let light = Illumination { wavelength_nm: nm, theta_i, phi_i, window: Light::Gaussian };
            // Enough azimuths for the horizon, where intensities end abruptly.
            let far = far_field(&mirror(width), &light, 20_000, &Accuracy::default()).unwrap();
            let expected = mirror_fraction(width, nm, theta_i, phi_i);
            for simulated in far.radiated {
                let apart = (simulated / expected - 1.0).abs();
                assert!(apart < 1e-3, "{width} {nm} {theta} {phi}: {simulated} {expected}");
            }
        }
    }

    #[test]
    fn a_wide_mirror_reflects_all_light_and_only_grazing_light_is_flagged() {
        let at = |degrees: f64| mirror_fraction(25.0, 694.0, 0.0, degrees.to_radians());
        assert!((at(0.0) - 1.0).abs() < 1e-4 && (at(60.0) - 1.0).abs() < 2e-3);
        assert!((at(75.0) - 1.0).abs() < LARGEST_MIRROR_ERROR);
        assert!((at(80.0) - 1.0).abs() > LARGEST_MIRROR_ERROR);
        // Ever further off towards the horizon, and always a number.
        let last = at(90.0 - 1e-13);
        assert!(last.is_finite() && last > 1e12, "{last}");
    }
}
