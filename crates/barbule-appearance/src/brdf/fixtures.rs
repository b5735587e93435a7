//! A made-up material for tests and benchmarks.

use super::halo::Halo;
use super::material::{FeatherMaterial, LobeSet, ParameterSet, achromatic_lengths};
use super::noise::{Spectral, spectrum};
use crate::scattering::lobe::FitKind;
use crate::scattering::statistics::Axes;
use crate::spectrum::Wavelengths;

/// A plausible green feather from smooth formulas, on the default directions (20 × 20) and wavelengths 400 … 694 nm.
///
/// It stands in where a material is needed but no simulation is meant: `waves` wavelengths, nothing else to choose.
///
/// # Panics
/// Never: the axes rise.
#[must_use]
pub fn example(waves: usize) -> FeatherMaterial {
    let waves = waves.max(1);
    let cosines: Vec<f64> = (1..=20).map(|k| f64::from(k) / 20.0).collect();
    let step = 294.0 / waves.max(2).saturating_sub(1) as f64;
    let wavelengths_nm: Vec<f64> = (0..waves).map(|k| 400.0 + k as f64 * step).collect();
    let wavelengths = Wavelengths::new(wavelengths_nm).expect("rising wavelengths");
    let axes = Axes::new(&wavelengths, cosines.clone(), cosines).expect("rising cosines");
    let mut set = ParameterSet { mean: vec![LobeSet::default(); 2], ..ParameterSet::default() };
    let mut correlation = Vec::new();
    for &wave in axes.wavelengths_nm() {
        for &ct in axes.cos_theta() {
            for &cp in axes.cos_phi() {
                let grazing = ct * cp;
                let phi_i = libm::acos(cp);
                // A band that moves to shorter waves with incidence, over Fresnel-like reflection at grazing.
                let centre = 460.0 + 90.0 * grazing;
                let band = libm::exp(-((wave - centre) / 45.0).powi(2));
                let reflected = (0.03 + 0.25 * band + 0.7 * (1.0 - grazing).powi(5)).min(0.98);
                let coherent = 0.15 + 0.6 * (1.0 - grazing).powi(2);
                let m = 0.06 + 0.25 * (1.0 - ct) * cp + 0.02 * wave / 550.0;
                let phi = 0.95 * phi_i + 0.05 * phi_i.powi(3) / 2.467;
                push(&mut set.mean[0], m, phi, 0.8 * reflected);
                // Nearer to the normal and wider.
                push(&mut set.mean[1], 1.6 * m, 0.9 * phi, 0.2 * reflected);
                set.steady.m.push((0.1 + 0.3 * (1.0 - cp)) as f32);
                set.steady.phi.push(phi_i as f32);
                set.steady.share.push(coherent as f32);
                set.length.push((wave / 400.0 * (0.8 + 0.2 * cp)) as f32);
                set.fraction_1.push((0.5 + 0.3 * (1.0 - grazing)) as f32);
                set.fraction_1_slope.push((-0.4 * libm::sin(phi_i)) as f32);
                correlation.push((0.6 + 0.4 * grazing) as f32);
            }
        }
    }
    let lags: Vec<f64> = (0..512).map(|k| libm::exp(-(f64::from(k) / 8.0).powi(2))).collect();
    let sets = vec![set];
    FeatherMaterial {
        kind: FitKind::Marginal,
        sigma: 0.04,
        halo: None,
        correlation,
        steepness: vec![6.0; 400],
        strength: vec![0.8; 400],
        achromatic_length: achromatic_lengths(&axes, &sets),
        spectral: Spectral { height_um: 0.15, achromatic: 0.25 },
        noise_power: spectrum(&lags),
        seed: 1,
        axes,
        sets,
        info: serde_json::json!({ "species": "example", "variant": "green" }),
    }
}

/// A plausible halo of two Gaussians, whose shares and power change with wavelength and direction.
#[must_use]
pub fn halo() -> Halo {
    let mut halo = Halo {
        sigma: vec![0.1, 0.3],
        wavelengths_nm: vec![400.0, 530.0, 700.0],
        cos_theta: vec![0.5, 1.0],
        cos_phi: vec![0.4, 0.9, 1.0],
        index: 1.6,
        ..Halo::default()
    };
    for narrow in [true, false] {
        for &nm in &halo.wavelengths_nm {
            for ct in &halo.cos_theta {
                for cp in &halo.cos_phi {
                    let share = 0.05 * (550.0 / nm).powi(2) * (0.5 + 0.5 * ct * cp);
                    halo.shares.push((if narrow { 2.0 * share } else { 0.1 - 0.5 * share }) as f32);
                    if narrow {
                        halo.power.push((0.8 + 0.1 * ct + 0.1 * cp) as f32);
                    }
                }
            }
        }
    }
    halo
}

fn push(lobe: &mut LobeSet, m: f64, phi: f64, reflected: f64) {
    lobe.m.push(m as f32);
    lobe.phi.push(phi as f32);
    lobe.reflected.push(reflected as f32);
}
