//! Fields against fields, and campaigns against what they converge to.

use barbule::campaign::{Campaign, Parameters};
use barbule::math::simd::Width;
use barbule::progress::Unobserved;
use barbule::scattering::statistics::{AZIMUTHS, Axes};
use barbule::solve::surface::{Surface, Window, far_field};
use barbule::structure::{Section, Structure};
use num_complex::Complex64;

/// ‖a − b‖/‖b‖.
pub(crate) fn relative_l2(a: &[Complex64], b: &[Complex64]) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
    (difference / b.iter().map(Complex64::norm_sqr).sum::<f64>()).sqrt()
}

/// The largest errors of a campaign's fields (relative L2) and reflected powers against double precision with elements of
/// `element_um`, at one wavelength and cosθ_i, at the given cosφ_i and at 1, both polarizations.
pub(crate) fn campaign_errors(section: &Section, nm: f64, cosines: [f64; 2], element_um: f64) -> [f64; 2] {
    let axes = Axes { wavelengths_nm: vec![nm], cos_theta: vec![cosines[0]], cos_phi: vec![cosines[1], 1.0] };
    let structure = Structure::Sections { name: section.name.clone(), sections: vec![section.clone()] };
    let parameters = Parameters { axes: axes.clone(), instances: 1, seed: 1, tilt: 0.0 };
    let campaign = Campaign::new(&structure, parameters, Width::best(), &Unobserved).unwrap();
    let unit = campaign.unit(&campaign.wavelength(0, &Unobserved).unwrap(), 0, true);
    let surface = Surface::new(section, element_um, Window::Gaussian).unwrap();
    let mut worst = [0f64; 2];
    for (number, cosine) in axes.cos_phi.iter().enumerate() {
        let (theta, phi) = (cosines[0].acos(), cosine.acos());
        let exact = far_field(&surface, Window::Gaussian, nm, theta, phi, AZIMUTHS, Width::best()).unwrap();
        for p in 0..2 {
            let at = (number * 2 + p) * 2 * AZIMUTHS;
            let single: Vec<Complex64> = unit.fields[at..at + 2 * AZIMUTHS]
                .iter()
                .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
                .collect();
            let error = relative_l2(&single, &exact.fields[p].concat());
            let power = (unit.reflected[number * 2 + p] / exact.reflected[p] - 1.0).abs();
            worst = [worst[0].max(error), worst[1].max(power)];
        }
    }
    worst
}

/// The larger of each.
pub(crate) fn larger(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}
