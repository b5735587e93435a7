use super::*;
use crate::brdf::fixtures::{example, halo};
use crate::brdf::{Values, achromatic_lengths};
use crate::math::rng::Stream;
use crate::scattering::directions::omega;
use crate::scattering::statistics::{Axes, Sides};

/// Single precision leaves h_x an error of 1e-7, which is a relative 1e-7/m of D₁ and of the noise's slope.
#[test]
fn registers_agree_with_the_exact_formulas_at_every_width() {
    agree_at_every_width(&example(7));
    agree_at_every_width(&FeatherMaterial { halo: Some(halo()), ..example(7) });
}

fn agree_at_every_width(material: &FeatherMaterial) {
    let mut brdf = FeatherBrdf::new(material, Options::default()).unwrap();
    let mut levels = vec![Level::new()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(
        [Level::new().as_avx2().map(Level::Avx2), Level::new().as_sse2().map(Level::Sse2)]
            .into_iter()
            .flatten(),
    );
    for level in levels {
        brdf.level = level;
        let mut stream = Stream::new(4, &[]);
        let mut worst = [0.0_f64; 3];
        for instance in 0..2000 {
            let z = stream.uniform(0.02, 1.0);
            let (sin, cos) = stream.uniform(0.0, 6.3).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let wi = DVec3::new(r * cos, r * sin, z);
            let waves = [390.0, 433.0, 571.5, 680.0];
            let prepared = brdf.prepare(waves, wi);
            let Some((wo, pdf)) = prepared.sample(1, [stream.unit(), stream.unit()]) else { continue };
            let (speckled, mean) =
                (prepared.eval(wo, Some(&brdf.instance(instance))), prepared.eval(wo, None));
            let densities = prepared.pdfs(wo);
            assert_eq!(pdf, densities[1]);
            let twice: [f32; 8] = std::array::from_fn(|k| waves[k % 4]);
            assert_eq!(brdf.eval(twice, wi, wo, Some(instance))[4..], speckled);
            for lane in 0..4 {
                let exact = brdf.exact(f64::from(waves[lane]), wi);
                let Values { f, pdf: density, .. } = exact.values(wo, Some(instance));
                let expected = exact.values(wo, None).f;
                // Relative to the mean: an instance may be dark by chance.
                let errors = [
                    (f64::from(speckled[lane]) - f).abs() / expected.max(1e-6),
                    (f64::from(mean[lane]) / expected.max(1e-30) - 1.0).abs(),
                    (densities[lane] / density - 1.0).abs(),
                ];
                if expected > 1e-12 {
                    for (worst, error) in worst.iter_mut().zip(errors) {
                        *worst = worst.max(error);
                    }
                }
            }
        }
        assert!(worst[0] < 3e-4 && worst[1] < 2e-4 && worst[2] < 2e-4, "{level:?}: {worst:?}");
    }
}

#[test]
fn tables_stay_in_proportion_to_what_is_seen() {
    let refused = FeatherBrdf::new(&example(513), Options::default()).unwrap_err();
    assert!(refused.to_string().contains("limit of 512"), "{refused}");
}

/// Far fewer wavelengths are prepared, and nothing changes at those asked for.
#[test]
fn a_part_of_the_wavelengths_says_the_same_there() {
    let material = example(30);
    let whole = FeatherBrdf::new(&material, Options::default()).unwrap();
    let asked = [400.0, 433.3, 571.0, 694.0];
    let part = material.around(&asked).unwrap();
    assert!((5..9).contains(&part.axes.wavelengths_nm().len()), "{:?}", part.axes.wavelengths_nm());
    let part = FeatherBrdf::new(&part, Options::default()).unwrap();
    let (wi, wo) = (DVec3::new(0.3, 0.2, 0.9).normalize(), DVec3::new(-0.25, -0.18, 0.9).normalize());
    for nm in asked {
        for instance in [None, Some(7)] {
            let of = |brdf: &FeatherBrdf| brdf.exact(nm, wi).values(wo, instance);
            assert_eq!(of(&whole), of(&part), "{nm} nm");
        }
    }
    assert_eq!(example(1).around(&[500.0]).unwrap(), example(1));
}

/// Both polarizations apart, and values symmetrized.
#[test]
fn registers_agree_with_the_exact_formulas_for_all_options() {
    let mut material = example(3);
    let mut second = material.sets[0].clone();
    for lobe in &mut second.mean {
        lobe.m.iter_mut().for_each(|m| *m *= 1.3);
        lobe.reflected.iter_mut().for_each(|rho| *rho *= 0.4);
    }
    material.sets.push(second);
    for set in &mut material.sets {
        (set.fraction_1, set.fraction_1_slope) = (Vec::new(), Vec::new());
    }
    let (wi, wo) = (DVec3::new(0.3, 0.2, 0.9).normalize(), DVec3::new(-0.25, -0.18, 0.9).normalize());
    for polarization in [None, Some(Polarization::First), Some(Polarization::Second)] {
        for reciprocity in [Reciprocity::AsFitted, Reciprocity::Mean, Reciprocity::Steeper] {
            let options = Options { polarization, reciprocity, ..Options::default() };
            let brdf = FeatherBrdf::new(&material, options).unwrap();
            let exact = brdf.exact(500.0, wi).values(wo, Some(3));
            let found = brdf.eval([500.0; 4], wi, wo, Some(3))[0];
            assert!((f64::from(found) / exact.f - 1.0).abs() < 1e-4, "{options:?}: {found} {exact:?}");
            assert!((brdf.pdf(500.0, wi, wo) / exact.pdf - 1.0).abs() < 1e-4);
            assert!(exact.steady > 0.0 && exact.steady <= brdf.exact(500.0, wi).values(wo, None).f);
        }
    }
}

/// One node's lobes far apart from its neighbour's: between them both peaks are seen, and nothing is lost.
#[test]
fn neighbours_are_mixed_by_value() {
    let mut material = example(2);
    let axes = material.axes.clone();
    let set = &mut material.sets[0];
    for wave in 0..2 {
        for (theta, _) in axes.cos_theta().iter().enumerate() {
            for (phi, cosine) in axes.cos_phi().iter().enumerate() {
                let at = axes.index(wave, theta, phi);
                let phi_i = libm::acos(*cosine) as f32;
                let away = if phi.is_multiple_of(2) { 0.3 } else { -0.3 };
                for (lobe, share) in set.mean.iter_mut().zip([0.3, 0.1]) {
                    (lobe.m[at], lobe.phi[at], lobe.reflected[at]) =
                        (0.05, (phi_i + away).clamp(-1.5, 1.5), share);
                }
            }
        }
    }
    let brdf = FeatherBrdf::new(&material, Options::default()).unwrap();
    // Half way between cosφ_i of 0.70 and 0.75.
    let phi_i = f64::acos(0.725);
    let wi = DVec3::new(phi_i.sin(), 0.0, phi_i.cos());
    let exact = brdf.exact(400.0, wi);
    let at = |phi: f64| exact.across([phi.sin(), phi.cos()], 1.0, None).f;
    let (left, middle, right) = (at(-phi_i - 0.3), at(-phi_i), at(-phi_i + 0.3));
    assert!(middle < 0.2 * left.min(right), "{left} {middle} {right}");
    assert!((brdf.albedo(400.0, wi) - 0.4).abs() < 1e-6);
    let count = 20_000;
    let step = std::f64::consts::PI / f64::from(count);
    let sum: f64 =
        (0..count).map(|k| at((f64::from(k) + 0.5) * step - std::f64::consts::FRAC_PI_2)).sum::<f64>() * step;
    assert!((sum - 0.4).abs() < 1e-5, "{sum}");
}

/// Light from either side, where both are stored: the left one's lobes are not those of the right one.
#[test]
fn both_signs_have_their_own_lobes() {
    let alike = example(2);
    let mut both = alike.clone();
    both.axes = alike.axes.clone().with_sides(Sides::Both);
    let (one, two) = (&alike.axes, &both.axes);
    assert_eq!(two.phis(), 39);
    let spread = |values: &[f32], sign: f32| -> Vec<f32> {
        let node = |wave, theta, phi| values[one.index(wave, theta, two.cosine_of(phi))];
        let mut out = Vec::new();
        for wave in 0..2 {
            for theta in 0..20 {
                for phi in 0..two.phis() {
                    out.push(if phi < 20 { 1.0 } else { sign } * node(wave, theta, phi));
                }
            }
        }
        out
    };
    let set = &mut both.sets[0];
    for lobe in &mut set.mean {
        (lobe.m, lobe.phi, lobe.reflected) =
            (spread(&lobe.m, 1.0), spread(&lobe.phi, -1.0), spread(&lobe.reflected, 1.0));
    }
    let steady = &mut set.steady;
    (steady.m, steady.phi, steady.share) =
        (spread(&steady.m, 1.0), spread(&steady.phi, -1.0), spread(&steady.share, 1.0));
    let slopes = spread(&set.fraction_1_slope, -1.0);
    set.fraction_1_slope = slopes;
    for values in [&mut set.length, &mut set.fraction_1, &mut both.correlation] {
        *values = spread(values, 1.0);
    }
    both.achromatic_length = achromatic_lengths(&both.axes, &both.sets);
    both.steepness.resize(20 * two.phis(), 6.0);
    both.strength.resize(20 * two.phis(), 0.8);
    let mut dark = both.clone();
    let at = |phi: usize| dark_index(&both.axes, phi);
    for phi in 20..39 {
        for lobe in &mut dark.sets[0].mean {
            at(phi).for_each(|node| lobe.reflected[node] = 0.0);
        }
    }
    let brdfs =
        [&alike, &both, &dark].map(|material| FeatherBrdf::new(material, Options::default()).unwrap());
    for (theta, phi) in [(0.3, 0.7), (-0.5, -0.7), (0.1, -0.05), (0.0, 1.5), (0.9, -1.52)] {
        let wi = omega(theta, phi);
        let wo = omega(-theta + 0.02, -0.99 * phi);
        let [a, b, c] = brdfs.each_ref().map(|brdf| brdf.exact(430.0, wi).values(wo, None));
        assert!((a.f / b.f - 1.0).abs() < 1e-5 && (a.pdf / b.pdf - 1.0).abs() < 1e-5, "{a:?} {b:?}");
        let expected = if phi > 0.0 { b.f } else { 0.0 };
        // Between the normal and the first node on the other side both count.
        assert!((c.f - expected).abs() < 1e-6 * b.f || phi == -0.05 && c.f < b.f, "{theta} {phi}: {c:?}");
    }
}

fn dark_index(axes: &Axes, phi: usize) -> impl Iterator<Item = usize> + '_ {
    (0..2).flat_map(move |wave| (0..20).map(move |theta| axes.index(wave, theta, phi)))
}
