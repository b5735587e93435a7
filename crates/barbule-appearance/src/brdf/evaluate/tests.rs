use super::*;
use crate::brdf::fixtures::example;
use crate::brdf::table::{INVERSE_LENGTH, M, STATIONARY, STRENGTH, TILT};
use crate::math::rng::Stream;

/// f of S.25, its mean f̂ and the density of ω_o, formula by formula in double precision from the same tables.
fn plain(brdf: &FeatherBrdf, wave: f32, wi: DVec3, wo: DVec3, instance: u64) -> [f64; 3] {
    let sigma = brdf.sigma;
    let cos_theta = wi.x.hypot(wi.z).max(1e-6);
    let cell = brdf.tables[0].cell_plain(cos_theta, wi.z / cos_theta);
    let p = brdf.tables[0].lookup_plain(&cell, brdf.tables[0].place(wave)).map(f64::from);
    let value = |base: usize| {
        let (m, sine) = (p[base + M], (p[base + TILT] * wi.x / cos_theta).clamp(-0.9998, 0.9998));
        let incident = DVec3::new(cos_theta * sine, wi.y, cos_theta * (1.0 - sine * sine).sqrt());
        let h = (incident + wo).normalize();
        let q = m * m + (1.0 - m * m) * h.x * h.x;
        let d = m * m / (PI * q * q) * (-(h.y / sigma).powi(2)).exp();
        let g = 2.0 * wo.z / (wo.z + (wo.z * wo.z + m * m * (1.0 - wo.z * wo.z)).sqrt());
        let f = p[base + STRENGTH] * m / (2.0 * sigma * PI.sqrt() * incident.z) * d * g / wo.z;
        let a = m / (1.0 - m * m).max(1e-30).sqrt();
        let end = (1.0 - h.y * h.y).sqrt();
        let t = end / a;
        let half = (t / (1.0 + t * t) + t.atan()) / PI;
        let along = 1.0 / (PI * a * (1.0 + (h.x / a).powi(2)).powi(2) * half);
        let across = (-(h.y / sigma).powi(2)).exp() / (sigma * PI.sqrt() * libm::erf(1.0 / sigma));
        (f, along * across * h.z / (4.0 * incident.dot(h)))
    };
    let ((mean, density), (stationary, _)) = (value(0), value(STATIONARY));
    let stationary = stationary.min(mean);
    let draw = brdf.noise.draw(instance);
    let [qr, qi] = brdf.noise.at(&draw, ((wi.x + wo.x) * p[INVERSE_LENGTH]) as f32).map(f64::from);
    let spread = (0.5 * (mean - stationary)).sqrt();
    let f = (spread * qr + stationary.sqrt()).powi(2) + (spread * qi).powi(2);
    [f, mean, density]
}

/// Single precision leaves h_x an error of 1e-7, which is a relative 1e-7/m of D₁ and of the noise's slope.
#[test]
fn registers_agree_with_the_plain_formulas_at_every_width() {
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
                let [f, expected, density] = plain(&brdf, waves[lane], wi, wo, instance);
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
