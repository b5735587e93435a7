//! Fields against fields, and campaigns against what they converge to.

use barbule::campaign::{Campaign, CampaignParameters, Keep, Resources};
use barbule::progress::Unobserved;
use barbule::scattering::far_field::{Illumination, Window};
use barbule::scattering::statistics::{AZIMUTHS, Axes};
use barbule::solve::surface::{Accuracy, far_field};
use barbule::spectrum::Wavelengths;
use barbule::structure::{Section, Structure};
use num_complex::Complex64;

/// ‖a − b‖/‖b‖.
pub(crate) fn relative_l2(a: &[Complex64], b: &[Complex64]) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
    (difference / b.iter().map(Complex64::norm_sqr).sum::<f64>()).sqrt()
}

/// A beam that lights a barbule's width; angles in rad.
pub(crate) fn beam(wavelength_nm: f64, theta_i: f64, phi_i: f64) -> Illumination {
    Illumination { wavelength_nm, theta_i, phi_i, window: Window::Gaussian }
}

/// The largest errors of a campaign's fields (relative L2) and reflected powers against double precision with elements of
/// `element_um`, at one wavelength and cosθ_i, at the given cosφ_i and at 1, both polarizations.
pub(crate) fn campaign_errors(section: &Section, nm: f64, cosines: [f64; 2], element_um: f64) -> [f64; 2] {
    let wavelengths = Wavelengths::new([nm]).unwrap();
    let axes = Axes::new(&wavelengths, vec![cosines[0]], vec![cosines[1], 1.0]).unwrap();
    let structure = Structure::Sections { name: section.name.clone(), sections: vec![section.clone()] };
    let parameters =
        CampaignParameters { axes: axes.clone(), instances: 1, seed: 1, tilt: 0.0, mirror: false, places: 1 };
    let campaign = Campaign::new(&structure, parameters, &Resources::default(), &Unobserved).unwrap();
    let tables = campaign.tables(0, &Unobserved).unwrap();
    let unit = campaign.unit(&tables, 0, Keep::Fields, &Unobserved).unwrap();
    let mut worst = [0f64; 2];
    for number in 0..axes.cos_phi().len() {
        let light = beam(nm, axes.theta_i(0), axes.phi_i(number));
        let accuracy = Accuracy { element_um, ..Accuracy::default() };
        let exact = far_field(section, &light, AZIMUTHS, &accuracy).unwrap();
        for p in 0..2 {
            let at = (number * 2 + p) * 2 * AZIMUTHS;
            let single: Vec<Complex64> = unit.fields[at..at + 2 * AZIMUTHS]
                .iter()
                .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
                .collect();
            let error = relative_l2(&single, &exact.amplitudes[p].concat());
            let power = (unit.reflected[number * 2 + p] / exact.radiated[p] - 1.0).abs();
            worst = [worst[0].max(error), worst[1].max(power)];
        }
    }
    worst
}

/// The larger of each.
pub(crate) fn larger(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}
