use super::*;
use crate::brdf::Values;
use crate::brdf::fixtures::example;
use crate::math::rng::Stream;

/// Single precision leaves h_x an error of 1e-7, which is a relative 1e-7/m of D₁ and of the noise's slope.
#[test]
fn registers_agree_with_the_exact_formulas_at_every_width() {
    let mut brdf = FeatherBrdf::new(&example(7), Options::default()).unwrap();
    let mut levels = vec![Level::new(), Level::fallback()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(Level::new().as_avx2().map(Level::Avx2));
    for level in levels {
        brdf.level = level;
        let mut stream = Stream::new(4, &[]);
        let mut worst = [0.0_f64; 3];
        for instance in 0..3000 {
            let z = stream.uniform(0.02, 1.0);
            let (sin, cos) = stream.uniform(0.0, 6.3).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let wi = DVec3::new(r * cos, r * sin, z);
            let waves = [390.0, 433.0, 571.5, 680.0];
            let prepared = brdf.prepare(waves, wi);
            let Some((wo, pdf)) = prepared.sample(1, [stream.unit(), stream.unit()]) else { continue };
            let (speckled, mean) = (prepared.eval(wo, Some(instance)), prepared.eval(wo, None));
            let densities = prepared.pdf4(wo);
            assert_eq!(pdf, densities[1]);
            assert_eq!(brdf.eval(waves, wi, wo, Some(instance)), speckled);
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
    second.mean.m.iter_mut().for_each(|m| *m *= 1.3);
    second.mean.reflected.iter_mut().for_each(|rho| *rho *= 0.4);
    material.sets.push(second);
    for set in &mut material.sets {
        (set.fraction_1, set.stationary_fraction_1) = (Vec::new(), Vec::new());
    }
    let (wi, wo) = (DVec3::new(0.3, 0.2, 0.9).normalize(), DVec3::new(-0.25, -0.18, 0.9).normalize());
    for polarization in [None, Some(Polarization::First), Some(Polarization::Second)] {
        for reciprocal in [false, true] {
            let options = Options { polarization, reciprocal, ..Options::default() };
            let brdf = FeatherBrdf::new(&material, options).unwrap();
            let exact = brdf.exact(500.0, wi).values(wo, Some(3));
            let found = brdf.eval([500.0; 4], wi, wo, Some(3))[0];
            assert!((f64::from(found) / exact.f - 1.0).abs() < 1e-4, "{options:?}: {found} {exact:?}");
            assert!((brdf.pdf(500.0, wi, wo) / exact.pdf - 1.0).abs() < 1e-4);
            assert!(exact.steady > 0.0 && exact.steady <= brdf.exact(500.0, wi).values(wo, None).f);
        }
    }
}
