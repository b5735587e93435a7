use super::*;
use crate::brdf::Synthesis;
use crate::progress::Unobserved;
use crate::scattering::directions;
use crate::scattering::statistics::{Axes, NOISE_POINTS, glints};
use crate::spectrum::Wavelengths;

const INSTANCES: usize = 50;

/// With so many nothing is doubted.
const MANY: usize = 1000;

/// A material of two mean lobes and a steady one, from smooth formulas; `steady` is the part that does not fluctuate.
fn model(sides: Sides, steady: f64, gamma: f32) -> FeatherMaterial {
    let wavelengths = Wavelengths::new([400.0, 694.0]).unwrap();
    let axes = Axes::new(&wavelengths, vec![0.3, 0.7, 1.0], vec![0.4, 0.7, 1.0]).unwrap().with_sides(sides);
    let mut set = ParameterSet { mean: vec![LobeSet::default(); 2], ..ParameterSet::default() };
    let push = |lobe: &mut LobeSet, m: f64, phi: f64, reflected: f64| {
        lobe.m.push(m as f32);
        lobe.phi.push(phi as f32);
        lobe.reflected.push(reflected as f32);
    };
    for node in 0..axes.len() {
        let [wave, theta, phi] = place(&axes, node);
        let (nm, phi_i) = (axes.wavelengths_nm()[wave], axes.phi_i(phi));
        let m = 0.06 + 0.04 * axes.cos_theta()[theta] + 0.02 * nm / 550.0;
        // Without mirror symmetry light of φ_i = 0 leaves to one side too.
        let aside = if sides == Sides::Both { 0.1 } else { 0.0 };
        push(&mut set.mean[0], m, 0.95 * phi_i + aside, 0.3);
        push(&mut set.mean[1], 3.0 * m, 0.9 * phi_i - aside, 0.2);
        set.steady.m.push(1.2 * m as f32);
        set.steady.phi.push((0.95 * phi_i + aside) as f32);
        set.steady.share.push(steady as f32);
        set.length.push((nm / 400.0 * (0.8 + 0.2 * libm::cos(phi_i))) as f32);
        set.fraction_1.push(0.6);
        set.fraction_1_slope.push(0.0);
    }
    let lags: Vec<f64> = (0..LAGS).map(|k| libm::exp(-(k as f64 / 8.0).powi(2))).collect();
    let sets = vec![set];
    FeatherMaterial {
        kind: FitKind::Marginal,
        sigma: 0.04,
        halo: None,
        correlation: vec![gamma; axes.len()],
        steepness: vec![4.0; axes.len() / 2],
        strength: vec![0.0; axes.len() / 2],
        achromatic_length: achromatic_lengths(&axes, &sets),
        sets,
        spectral: Spectral::default(),
        noise_power: spectrum(&lags),
        seed: 1,
        info: serde_json::Value::Null,
        axes,
    }
}

fn curves(material: &FeatherMaterial, node: usize) -> [Fitted; 2] {
    fitted(material, node, &directions::azimuths(AZIMUTHS).collect::<Vec<_>>())
}

/// What a campaign of so many instances of a material is expected to find.
fn statistics_of(material: &FeatherMaterial, instances: usize) -> Statistics {
    let mut out = Statistics::empty(material.axes.clone(), instances);
    let count = instances as f64;
    for node in 0..material.axes.len() {
        let [_, theta, _] = place(&material.axes, node);
        let cosine = material.axes.cos_theta()[theta];
        let sides = curves(material, node);
        for side in &sides {
            out.u.extend(side.mean.iter().map(|v| *v as f32));
            out.v.extend(side.mean.iter().map(|_| 0.0_f32));
            let correlation = 16.0 * f64::from(material.sets[0].length[node]) / NOISE_POINTS as f64;
            let kept = steady::of_kept_energy(&side.mean, cosine, correlation);
            let contrast = side.mean.iter().zip(&side.steady).map(|(mean, steady)| {
                let part = steady / mean.max(1e-300);
                (kept * (1.0 - part * part) * (count - 1.0) / (count + 1.0)).max(0.0).sqrt() as f32
            });
            out.contrast.extend(contrast);
            let total: f64 = side.mean.iter().sum();
            out.reflected.push(total * cosine * std::f64::consts::PI / AZIMUTHS as f64);
            out.reflected_std.push(0.0);
            let scale = 8.0 * f64::from(material.sets[0].length[node]);
            out.autocovariance.extend((0..LAGS).map(|k| libm::exp(-(k as f64 / scale).powi(2)) as f32));
        }
        out.pattern_correlation.push(correlation::expected(&sides, f64::from(material.correlation[node])));
        out.unpolarized_contrast.push(1.0);
    }
    out
}

/// The same with the intensities of drawn instances about the mirror direction.
fn with_glints(material: &FeatherMaterial, instances: usize) -> Statistics {
    let mut out = statistics_of(material, instances);
    let noise = material.noise();
    for node in 0..material.axes.len() {
        let [_, _, phi] = place(&material.axes, node);
        let synthesis = Synthesis::new(material, node);
        let drawn: Vec<Vec<f64>> =
            (0..instances as u64).map(|name| synthesis.intensity(&noise, name)).collect();
        for at in glints(material.axes.phi_i(phi)) {
            out.glints.extend(drawn.iter().map(|all| at.map_or(0.0, |at| all[at] as f32)));
        }
    }
    out
}

#[test]
fn how_wavelengths_differ_is_found_again_from_drawn_instances() {
    for (height_um, achromatic) in [(0.12, 0.3), (0.3, 0.0)] {
        let mut material = model(Sides::Alike, 0.0, 1.0);
        material.spectral = Spectral { height_um, achromatic };
        let (found, report) = fit(&with_glints(&material, 600), &FitOptions::default(), &Unobserved).unwrap();
        let Spectral { height_um: height, achromatic: share } = found.spectral;
        assert!((height / height_um - 1.0).abs() < 0.1, "{height} {height_um}");
        assert!((share - achromatic).abs() < 0.06, "{share} {achromatic}");
        let errors = report.spectral;
        assert!(errors.mirror < 0.05 && errors.beside < 0.05 && errors.turned < 0.05, "{errors:?}");
    }
}

/// ‖a − b‖/‖b‖.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    (square(&mut a.iter().zip(b).map(|(a, b)| a - b)) / square(&mut b.iter().copied())).sqrt()
}

#[test]
fn a_material_is_found_again_from_its_statistics() {
    for sides in [Sides::Alike, Sides::Both] {
        for polarized in [false, true] {
            let material = model(sides, 0.6, 0.7);
            let options = FitOptions { polarized, ..FitOptions::default() };
            let (found, report) = fit(&statistics_of(&material, MANY), &options, &Unobserved).unwrap();
            found.check().unwrap();
            assert!(report.residual_median < 1e-3 && report.residual_95 < 0.01, "{report:?}");
            assert!(report.flagged.is_empty() && report.clipped.is_empty(), "{report:?}");
            assert!((report.longest_length[0] - 1.735).abs() < 0.01, "{report:?}");
            for node in 0..material.axes.len() {
                let direction = super::super::fitted::direction(&material.axes, node);
                for (found, given) in curves(&found, node).iter().zip(&curves(&material, node)) {
                    let mean = apart(&found.mean, &given.mean);
                    assert!(mean < 0.01, "{sides:?} {direction:?} mean {mean}");
                    let steady = apart(&found.steady, &given.steady);
                    assert!(steady < 0.03, "{sides:?} {direction:?} steady {steady}");
                }
                let gamma = found.correlation[node];
                assert!((gamma - 0.7).abs() < 0.05, "{direction:?} {gamma}");
                for set in &found.sets {
                    assert!((set.length[node] / material.sets[0].length[node] - 1.0).abs() < 0.01);
                }
            }
        }
    }
}

/// The part of each polarization over the lobe, and both together as the whole.
#[test]
fn how_polarizations_change_over_a_lobe_is_found_again() {
    let mut material = model(Sides::Both, 0.4, 0.8);
    let phis = material.axes.phis();
    let slopes =
        (0..material.axes.len()).map(|node| (-0.4 * libm::sin(material.axes.phi_i(node % phis))) as f32);
    material.sets[0].fraction_1_slope = slopes.collect();
    let (found, _) = fit(&statistics_of(&material, MANY), &FitOptions::default(), &Unobserved).unwrap();
    let pairs = |of: fn(&ParameterSet) -> &Vec<f32>| of(&found.sets[0]).iter().zip(of(&material.sets[0]));
    for (found, given) in pairs(|set| &set.fraction_1_slope) {
        assert!((found - given).abs() < 0.02, "{found} {given}");
    }
    for (found, given) in pairs(|set| &set.fraction_1) {
        assert!((found - given).abs() < 0.005, "{found} {given}");
    }
}

#[test]
fn one_lobe_is_one_set_of_arrays() {
    let mut material = model(Sides::Alike, 0.5, 1.0);
    material.sets[0].mean[1].reflected.fill(0.0);
    let options = FitOptions { lobe: LobeForm::Ggx, ..FitOptions::default() };
    let (found, report) = fit(&statistics_of(&material, MANY), &options, &Unobserved).unwrap();
    assert_eq!(found.sets[0].mean.len(), 1);
    assert!(report.residual_95 < 1e-3, "{report:?}");
    for (m, given) in found.sets[0].mean[0].m.iter().zip(&material.sets[0].mean[0].m) {
        assert!((m / given - 1.0).abs() < 2e-3);
    }
}

/// The statistics of so many drawn instances.
fn drawn(material: &FeatherMaterial, first: u64, instances: usize) -> Statistics {
    let mut out = statistics_of(material, instances);
    let noise = material.noise();
    let count = instances as f64;
    for node in 0..material.axes.len() {
        let synthesis = Synthesis::new(material, node);
        let mut sums = vec![[[0.0; 4]; 2]; AZIMUTHS];
        for instance in first..first + instances as u64 {
            for (sum, sides) in sums.iter_mut().zip(synthesis.fields(&noise, instance)) {
                for (sum, [re, im]) in sum.iter_mut().zip(sides) {
                    let intensity = re * re + im * im;
                    let terms = [intensity, intensity * intensity, re, im];
                    sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term / count);
                }
            }
        }
        for (k, sums) in sums.iter().enumerate() {
            for (p, [u, square, re, im]) in sums.iter().copied().enumerate() {
                let at = (node * 2 + p) * AZIMUTHS + k;
                out.u[at] = u as f32;
                out.v[at] = ((count * (re * re + im * im) - u) / (count - 1.0)) as f32;
                out.contrast[at] = (square / (u * u) - 1.0).max(0.0).sqrt() as f32;
            }
        }
    }
    out
}

#[test]
fn speckle_has_next_to_no_steady_part_even_in_few_instances() {
    let material = model(Sides::Alike, 0.0, 1.0);
    let mut parts = Vec::new();
    for draw in 0..4 {
        let (found, _) =
            fit(&drawn(&material, 1000 * draw, INSTANCES), &FitOptions::default(), &Unobserved).unwrap();
        found.check().unwrap();
        for node in 0..found.axes.len() {
            let [side, _] = curves(&found, node);
            parts.push(side.steady.iter().sum::<f64>() / side.mean.iter().sum::<f64>());
        }
    }
    let mean = parts.iter().sum::<f64>() / parts.len() as f64;
    assert!(mean < 0.1, "{mean} {parts:?}");
}

#[test]
fn fields_of_one_phase_are_steady_even_in_few_instances() {
    let material = model(Sides::Alike, 0.8, 0.5);
    let (found, report) = fit(&drawn(&material, 0, INSTANCES), &FitOptions::default(), &Unobserved).unwrap();
    let part = |set: &ParameterSet| -> f64 {
        set.steady.share.iter().map(|v| f64::from(*v)).sum::<f64>() / set.steady.share.len() as f64
    };
    let [found, given] = [part(&found.sets[0]), part(&material.sets[0])];
    assert!((found / given - 1.0).abs() < 0.15, "{found} {given} {report:?}");
    assert!(report.coherent_median > 0.3, "{report:?}");
}

/// Instances whose slopes make wings vary more than speckle are found so again.
#[test]
fn slopes_are_found_again_from_drawn_instances() {
    let mut material = model(Sides::Alike, 0.3, 0.8);
    material.strength.fill(0.7);
    let (found, report) = fit(&drawn(&material, 0, MANY), &FitOptions::default(), &Unobserved).unwrap();
    let regions = report.mean_regions().map(|pair| pair.unwrap());
    assert!(regions[2][0] > 1.3, "{regions:?}");
    for [simulated, synthesized] in regions {
        assert!((simulated - synthesized).abs() < 0.06, "{regions:?}");
    }
    for (values, given) in [(&found.steepness, 4.0), (&found.strength, 0.7)] {
        let mut values = values.clone();
        values.sort_by(f32::total_cmp);
        assert!((values[values.len() / 2] / given - 1.0).abs() < 0.15, "{given} {values:?}");
    }
}

#[test]
fn intensities_that_hardly_vary_leave_instances_that_hardly_vary() {
    for contrast in [0.4, 0.6, 0.75] {
        let mut statistics = statistics_of(&model(Sides::Alike, 0.5, 1.0), INSTANCES);
        statistics.contrast.fill(contrast);
        statistics.unpolarized_contrast.fill(f64::from(contrast));
        statistics.pattern_correlation.fill(1.0);
        let (_, report) = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap();
        for pattern in &report.patterns {
            // A steady lobe has narrower wings than the mean: there instances vary as speckle does, so that all over
            // they vary more, the more the steadier the light is.
            for [wanted, found] in pattern.regions.iter().filter_map(|side| side[0]) {
                assert!((found - wanted).abs() < 0.06, "{wanted} {found} {pattern:?}");
            }
            let [wanted, found] = pattern.contrast;
            assert!((-0.03..0.2).contains(&(found - wanted)), "{wanted} {found} {pattern:?}");
        }
    }
}

#[test]
fn contrasts_that_differ_between_mirror_and_wings_are_kept() {
    let material = model(Sides::Alike, 0.95, 1.0);
    let (_, report) = fit(&statistics_of(&material, INSTANCES), &FitOptions::default(), &Unobserved).unwrap();
    let [mirror, _, wings] = report.mean_regions().map(|pair| pair.unwrap());
    assert!(wings[0] - mirror[0] > 0.2, "{mirror:?} {wings:?}");
    for pattern in &report.patterns {
        for [simulated, synthesized] in pattern.regions.iter().flatten().flatten() {
            assert!((simulated - synthesized).abs() < 0.1, "{pattern:?}");
        }
    }
    for [simulated, synthesized] in [mirror, wings] {
        assert!((simulated - synthesized).abs() < 0.06, "{report:?}");
    }
}

#[test]
fn patterns_of_polarizations_correlate_as_they_should() {
    for gamma in [0.0, 0.5, 0.9] {
        let material = model(Sides::Alike, 0.6, gamma);
        let (_, report) =
            fit(&statistics_of(&material, INSTANCES), &FitOptions::default(), &Unobserved).unwrap();
        for pattern in &report.patterns {
            let [simulated, synthesized] = pattern.correlation;
            assert!((simulated - synthesized).abs() < 0.1, "{gamma} {pattern:?}");
        }
    }
}

#[test]
fn what_is_over_all_light_is_clipped_and_said() {
    let mut statistics = statistics_of(&model(Sides::Alike, 0.5, 1.0), INSTANCES);
    statistics.u.iter_mut().for_each(|u| *u *= 3.0);
    let (found, report) = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap();
    found.check().unwrap();
    assert_eq!(report.clipped.len(), found.axes.len());
    for node in 0..found.axes.len() {
        let total: f32 = found.sets[0].mean.iter().map(|lobe| lobe.reflected[node]).sum();
        assert!((total - 1.0).abs() < 1e-5, "{total}");
    }
}

#[test]
fn broken_statistics_are_refused_and_empty_ones_survive() {
    let whole = statistics_of(&model(Sides::Alike, 0.5, 1.0), INSTANCES);
    let mut statistics = whole.clone();
    for values in
        [&mut statistics.u, &mut statistics.v, &mut statistics.autocovariance, &mut statistics.contrast]
    {
        values.fill(0.0);
    }
    let (dark, _) = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap();
    dark.check().unwrap();
    statistics.u.pop();
    let error = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap_err();
    assert!(error.to_string().contains("u has"), "{error}");
    let wide = FitOptions { sigma: 1.0, ..FitOptions::default() };
    assert!(fit(&whole, &wide, &Unobserved).unwrap_err().is_input());
}
