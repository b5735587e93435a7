//! Beams as plane waves: light whose field is a window's on the plane z = 0, not on a top that rises and falls.

use std::f64::consts::{PI, SQRT_2};

use crate::scattering::far_field::{
    Azimuths, FarField, Illumination, IncidentLight, Window, coefficients, refinement,
};
use crate::structure::Section;
use crate::{Complex64, Result};

/// Beyond so many beam radii a Gaussian is below 1e-16.
const GAUSSIAN_END: f64 = 6.1;

/// A plane wave of a beam; it has the beam's k_y.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaneWave {
    /// Azimuth of incidence, rad.
    pub(super) phi_i: f64,
    /// |E|.
    pub(super) amplitude: f64,
}

/// A plane wave of unit |E|; or, on a section `width_um` wide whose points lie within `radius_um` of the origin, the waves of
/// the beam whose field on z = 0 is g(x) e^{jk_i·r}, without evanescent ones.
pub(super) fn plane_waves(light: &Illumination, width_um: f64, radius_um: f64) -> Vec<PlaneWave> {
    if light.window == Window::PlaneWave {
        return vec![PlaneWave { phi_i: light.phi_i, amplitude: 1.0 }];
    }
    let kappa = light.wave_number_per_um() * light.theta_i.cos();
    let beam = width_um / 4.0;
    // The spectrum of g is (w/2√π) e^{−(qw/2)²}; a sum at distance Δq repeats the beam at 2π/Δq.
    let repeat = 2.0 * (radius_um + GAUSSIAN_END * beam);
    let step = 2.0 * PI / repeat;
    let end = (2.0 * GAUSSIAN_END / beam / step).ceil() as i64;
    let middle = kappa * light.phi_i.sin();
    let waves = (-end..=end).filter_map(|n| {
        let q = n as f64 * step;
        // k_x = −κ sinφ.
        let sin = (middle - q) / kappa;
        let spectrum = beam / (2.0 * PI.sqrt()) * (-(0.5 * q * beam).powi(2)).exp();
        (sin.abs() < 1.0).then(|| PlaneWave { phi_i: sin.asin(), amplitude: spectrum * step })
    });
    waves.collect()
}

/// From where the light of a beam comes: no bounded light has one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IncidentRange {
    /// The azimuths at which the field's spectrum has fallen to 1/e of its middle's, rad; ±90° where that lies beyond the horizon.
    pub phi_i: [f64; 2],
    /// The part of the window's power whose waves would come from beyond the horizon, and so do not come.
    pub beyond_horizon: f64,
}

/// The range of a beam with the window g(x) = exp(−x²/w²), w = W/4, of a section W wide: its spectrum e^{−(qw/2)²} over k_x is that of
/// sinφ = sinφ_i ± λ/(πw cosθ_i) at 1/e.
#[must_use]
pub fn incident_range(light: &Illumination, width_um: f64) -> IncidentRange {
    let kappa_w = light.wave_number_per_um() * light.theta_i.cos() * width_um / 4.0;
    let (middle, half) = (libm::sin(light.phi_i), 2.0 / kappa_w);
    // Power has the square of the field's spectrum: a normal distribution of deviation 1/w.
    let beyond = |room: f64| 0.5 * libm::erfc(room * kappa_w / SQRT_2);
    IncidentRange {
        phi_i: [middle - half, middle + half].map(|sine| libm::asin(sine.clamp(-1.0, 1.0))),
        beyond_horizon: beyond(1.0 - middle) + beyond(1.0 + middle),
    }
}

/// How wide a section must be for the light of a beam to come from within `most_off` (rad) of its azimuth, µm, by [`incident_range`];
/// `None` where that reaches over the horizon at any width.
#[must_use]
pub fn width_within_um(light: &Illumination, most_off: f64) -> Option<f64> {
    let phi = light.phi_i.abs();
    // Towards the horizon angles open faster.
    let half = libm::sin(phi + most_off) - libm::sin(phi);
    let kappa = light.wave_number_per_um() * light.theta_i.cos();
    (phi + most_off < 0.5 * PI).then(|| 8.0 / (kappa * half))
}

/// Φ_i of a beam, that on a flat top as wide as the section, µm.
pub(super) fn power_um(width_um: f64, light: &Illumination) -> f64 {
    // ∫ exp(−2x²/(W/4)²) dx over ±W/2.
    let beam = width_um / 4.0;
    let flat = beam * (PI / 2.0).sqrt() * libm::erf(2.0 * 2f64.sqrt());
    flat * light.theta_i.cos() * light.phi_i.cos().max(0.0)
}

/// The far field of a section in a beam from that in each of its plane waves, which `of_wave` gives on so many azimuths of the
/// upper half.
pub(super) fn far_field(
    section: &Section,
    beam: &Illumination,
    azimuths: usize,
    of_wave: &dyn Fn(&Illumination, usize) -> Result<FarField>,
) -> Result<FarField> {
    section.check_lit_through_air()?;
    let top = section.top();
    let radius_um = top.x_um.iter().zip(&top.z_um).map(|(x, z)| x.hypot(*z)).fold(0.0, f64::max);
    let kappa = beam.wave_number_per_um() * beam.theta_i.cos();
    let refine = refinement(coefficients(kappa, radius_um), azimuths);
    let fine = Azimuths::UpperHalf(azimuths * refine);
    let none = vec![Complex64::ZERO; azimuths * refine];
    let mut sums = [[none.clone(), none.clone()], [none.clone(), none]];
    for PlaneWave { phi_i, amplitude } in plane_waves(beam, section.width_um, radius_um) {
        let wave = Illumination { phi_i, window: Window::PlaneWave, ..*beam };
        let far = of_wave(&wave, azimuths * refine)?;
        for (sum, field) in sums.iter_mut().flatten().zip(far.amplitudes.iter().flatten()) {
            sum.iter_mut().zip(field).for_each(|(sum, value)| *sum += value * amplitude);
        }
    }
    let light = IncidentLight::Beam { power_um: power_um(section.width_um, beam) };
    let scale = light.scale();
    let power = |components: &[Vec<Complex64>; 2]| -> f64 {
        components.iter().flatten().map(Complex64::norm_sqr).sum::<f64>()
    };
    let radiated = [0, 1].map(|p| beam.theta_i.cos() * fine.step() * scale * scale * power(&sums[p]));
    let kept = |values: &Vec<Complex64>| -> Vec<Complex64> {
        values.iter().skip(refine / 2).step_by(refine).map(|value| value * scale).collect()
    };
    let amplitudes = sums.each_ref().map(|components| components.each_ref().map(kept));
    Ok(FarField {
        light,
        theta_i: beam.theta_i,
        azimuths: Azimuths::UpperHalf(azimuths),
        amplitudes,
        radiated,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{self, reflect};
    use crate::material::Library;
    use crate::math::rng::Stream;
    use crate::scattering::far_field::Polarization;
    use crate::solve::surface::{Accuracy, FINE_ELEMENT_UM};
    use crate::solve::{direct, surface};
    use crate::structure::{Medium, Parts, Polyline};

    const WAVELENGTH_NM: f64 = 500.0;

    fn section(width_um: f64, media: &[&str], height: impl Fn(f64) -> f64) -> Section {
        let x_um: Vec<f64> = (0..=200).map(|i| width_um * (f64::from(i) / 200.0 - 0.5)).collect();
        let line = |depth: f64| Polyline {
            z_um: x_um.iter().map(|x| height(*x) - depth).collect(),
            x_um: x_um.clone(),
        };
        let parts = Parts {
            name: "beam".into(),
            width_um: Some(width_um),
            boundaries: (1..media.len()).map(|k| line(0.3 * (k - 1) as f64)).collect(),
            media: media.iter().map(|name| Medium::named(name)).collect(),
            ..Parts::default()
        };
        Section::new(parts, Library::builtin()).unwrap()
    }

    fn light(phi_deg: f64, window: Window) -> Illumination {
        Illumination { wavelength_nm: WAVELENGTH_NM, theta_i: 0.0, phi_i: phi_deg.to_radians(), window }
    }

    fn fast(section: &Section, light: &Illumination) -> FarField {
        surface::far_field(section, light, 400, &Accuracy::default()).unwrap()
    }

    /// A beam brings a tilted plane its own power and not, as a window on the top does, what falls on a tilted window. What comes
    /// back is Fresnel's.
    #[test]
    fn a_tilted_plane_reflects_its_share_of_the_beam() {
        let slope = 0.15;
        let plane = section(40.0, &["air", "keratin"], |x| slope * x);
        let keratin = Library::builtin().get("keratin").unwrap().index(WAVELENGTH_NM).unwrap();
        for phi_deg in [-40.0, 0.0, 40.0] {
            let [in_beam, on_top] =
                [Window::Beam, Window::Gaussian].map(|w| fast(&plane, &light(phi_deg, w)));
            // The normal leans to −x.
            let alpha = f64::to_radians(phi_deg) + libm::atan(slope);
            let polarizations = [film::Polarization::S, film::Polarization::P];
            for (radiated, polarization) in in_beam.radiated.iter().zip(polarizations) {
                let r =
                    reflect(&[1.0.into(), keratin], &[], WAVELENGTH_NM, alpha.abs(), polarization).unwrap();
                assert!(
                    (radiated / r.norm_sqr() - 1.0).abs() < 0.02,
                    "{phi_deg}: {radiated} {}",
                    r.norm_sqr()
                );
            }
            let power = |far: &FarField| far.light.scale().powi(-2);
            let expected = 1.0 - slope * f64::to_radians(phi_deg).tan();
            assert!((power(&on_top) / power(&in_beam) - expected).abs() < 1e-3, "{phi_deg} {expected}");
        }
    }

    /// What the formulas say of the waves that a beam is made of.
    #[test]
    fn the_range_of_a_beam_is_that_of_its_waves() {
        for (width_um, phi_deg, nm) in
            [(3.0, 60.0, 550.0), (6.0, 60.0, 550.0), (10.0, -30.0, 694.0), (20.0, 0.0, 400.0)]
        {
            let light = Illumination { wavelength_nm: nm, ..light(phi_deg, Window::Beam) };
            let range = incident_range(&light, width_um);
            // Far enough for the sum to be the integral.
            let waves = plane_waves(&light, width_um, 40.0 * width_um);
            let most = waves.iter().map(|wave| wave.amplitude).fold(0.0, f64::max);
            let strong = |wave: &&PlaneWave| wave.amplitude > most / std::f64::consts::E;
            let found =
                [waves.iter().find(strong), waves.iter().rfind(strong)].map(|wave| wave.unwrap().phi_i);
            let [from, to] = range.phi_i;
            let (low, high) = (found[0].min(found[1]), found[0].max(found[1]));
            let at_horizon = to > 0.499 * PI;
            assert!(
                (low - from).abs() < 0.01 && (at_horizon || (high - to).abs() < 0.01),
                "{found:?} {range:?}"
            );
            // ∫ (w/2√π)² e^{−(qw)²/2} dq = w/(2√(2π)), over the step of the sum.
            let step = 2.0 * PI / (2.0 * (40.0 * width_um + GAUSSIAN_END * width_um / 4.0));
            let all = 0.25 * width_um / (2.0 * (2.0 * PI).sqrt()) * step;
            let kept: f64 = waves.iter().map(|wave| wave.amplitude.powi(2)).sum();
            assert!((1.0 - kept / all - range.beyond_horizon).abs() < 5e-3, "{} {range:?}", 1.0 - kept / all);
        }
        let [at_3_um, at_6_um] = [3.0, 6.0]
            .map(|w| incident_range(&Illumination { wavelength_nm: 550.0, ..light(60.0, Window::Beam) }, w));
        assert!((at_3_um.beyond_horizon - 0.13).abs() < 0.005, "{at_3_um:?}");
        let [from, to] = at_6_um.phi_i.map(f64::to_degrees);
        assert!((from - 48.5).abs() < 0.1 && (to - 79.4).abs() < 0.1, "{from} {to}");
        let oblique = light(60.0, Window::Beam);
        let width_um = width_within_um(&oblique, 15_f64.to_radians()).unwrap();
        let to = incident_range(&oblique, width_um).phi_i[1];
        assert!((to.to_degrees() - 75.0).abs() < 1e-9, "{to}");
        assert_eq!(width_within_um(&light(80.0, Window::Beam), 15_f64.to_radians()), None);
    }

    /// A plane of another height is met elsewhere by a slanting beam, and sends up the same pattern. At z = 0 the beam's field is
    /// the window's; each of its plane waves has its own reflectance.
    #[test]
    fn a_plane_sends_up_the_same_at_any_height() {
        let [low, high] = [0.0, 1.0].map(|z| section(40.0, &["air", "keratin", "melanin"], move |_| z));
        let [below, above] = [&low, &high].map(|plane| fast(plane, &light(50.0, Window::Beam)));
        let windowed = fast(&low, &light(50.0, Window::Gaussian));
        for p in Polarization::BOTH {
            let [a, b, c] = [&below, &above, &windowed].map(|far| far.intensity(p).unwrap());
            let apart = |x: &[f64], y: &[f64]| {
                let squares = x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
                (squares / x.iter().map(|x| x * x).sum::<f64>()).sqrt()
            };
            assert!(apart(&a, &b) < 2e-3, "{}", apart(&a, &b));
            // In the second polarization Brewster's angle is near.
            let most = if p == Polarization::First { 0.02 } else { 0.15 };
            assert!(apart(&a, &c) < most, "{}", apart(&a, &c));
        }
    }

    #[test]
    fn plain_formulas_say_the_same_of_a_beam() {
        let mut stream = Stream::new(3, &[]);
        let waves: Vec<[f64; 2]> =
            (1..6).map(|k| [0.4 * f64::from(k), stream.uniform(0.0, 2.0 * PI)]).collect();
        let height = |x: f64| 0.06 * waves.iter().map(|[k, phase]| libm::cos(k * x + phase)).sum::<f64>();
        let film = section(12.0, &["air", "keratin", "melanin"], height);
        let light = Illumination { theta_i: 0.2, ..light(35.0, Window::Beam) };
        let (fast, plain) =
            (fast(&film, &light), direct::far_field(&film, &light, 400, FINE_ELEMENT_UM).unwrap());
        let flat = |far: &FarField| -> Vec<Complex64> {
            far.amplitudes.iter().flatten().flatten().copied().collect()
        };
        let (a, b) = (flat(&fast), flat(&plain));
        let apart: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).norm_sqr()).sum();
        let all: f64 = b.iter().map(Complex64::norm_sqr).sum();
        assert!(apart / all < 1e-6, "{}", (apart / all).sqrt());
        assert!((fast.radiated[0] / plain.radiated[0] - 1.0).abs() < 1e-3);
    }
}
