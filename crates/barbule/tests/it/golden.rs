//! BRDFs against `data/brdf.json`, by which back ends are held; `examples/brdf_golden` writes it.

use barbule::brdf::{FeatherBrdf, PlainBrdf};
use glam::DVec3;

use crate::measure::golden::{Golden, Light, Material, tables};

fn golden() -> Golden {
    serde_json::from_str(include_str!("data/brdf.json")).unwrap()
}

/// What a back end says about a wavelength number, ω_i and ω_o: f of the mean and of the instance, and the density.
type Values<'a> = &'a dyn Fn(usize, DVec3, DVec3) -> [f64; 3];

/// Largest errors of f of the mean, of an instance, and of the density, over the largest of each at one wavelength and
/// incident direction; an instance may be dark by chance, so the mean counts there too.
fn errors(light: &[Light], values: Values) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    for Light { wi, wo, mean, drawn, pdf, .. } in light {
        for (wave, rows) in mean.iter().zip(drawn).zip(pdf).enumerate() {
            let rows = [rows.0.0, rows.0.1, rows.1];
            let mut peaks = rows.map(|row| row.iter().fold(0.0_f64, |peak, v| peak.max(*v)));
            peaks[1] = peaks[1].max(peaks[0]);
            for (k, wo) in wo.iter().enumerate() {
                let found = values(wave, DVec3::from_array(*wi), DVec3::from_array(*wo));
                for n in 0..3 {
                    worst[n] = worst[n].max((found[n] - rows[n][k]).abs() / peaks[n]);
                }
            }
        }
    }
    worst
}

/// Largest distance of a sampled direction from that of the file.
fn distance(golden: &Golden, light: &[Light], sample: &dyn Fn(f64, DVec3, [f64; 2]) -> Option<DVec3>) -> f64 {
    let mut worst = 0.0_f64;
    for Light { wi, sampled, .. } in light {
        for (nm, row) in golden.wavelengths_nm.iter().zip(sampled) {
            for (u, expected) in golden.u.iter().zip(row) {
                let found = sample(*nm, DVec3::from_array(*wi), *u);
                assert_eq!(found.is_some(), expected.is_some(), "{wi:?} {nm} {u:?}");
                if let (Some(found), Some(expected)) = (found, expected) {
                    worst = worst.max((found - DVec3::from_array(*expected)).length());
                }
            }
        }
    }
    worst
}

/// Reached are 4e-7, and of an instance 1.5e-4: where s comes near f̂, √(f̂ − s) has half of single precision's digits.
#[test]
fn the_registers_agree_with_the_golden_values() {
    let golden = golden();
    let mut worst = [0.0_f64; 3];
    for material in &golden.materials {
        let brdf = FeatherBrdf::from_tables(tables(&material.name));
        let waves: [f32; 4] = std::array::from_fn(|k| golden.wavelengths_nm[k] as f32);
        let values = |wave: usize, wi: DVec3, wo: DVec3| {
            let of = |instance| f64::from(brdf.eval(waves, wi, wo, instance)[wave]);
            [of(None), of(Some(golden.instance)), brdf.pdfs(waves, wi, wo)[wave]]
        };
        let errors = errors(&material.light, &values);
        let sample = |nm: f64, wi, u| Some(brdf.sample(nm as f32, wi, u)?.0);
        let apart = distance(&golden, &material.light, &sample);
        println!("{}: {errors:?} {apart:.1e}", material.name);
        worst = std::array::from_fn(|n| worst[n].max(errors[n]));
        assert!(apart < 1e-12, "{apart}");
    }
    let [mean, drawn, pdf] = worst;
    assert!(mean < 1e-6 && drawn < 2e-4 && pdf < 1e-6, "{worst:?}");
}

#[test]
fn the_plain_evaluation_of_the_tables_agrees_with_the_golden_values() {
    let golden = golden();
    for material in &golden.materials {
        let plain = PlainBrdf::new(&tables(&material.name));
        let values = |wave: usize, wi: DVec3, wo: DVec3| {
            let of = |instance| plain.values(golden.wavelengths_nm[wave], wi, wo, instance);
            let mean = of(None);
            [mean.f, of(Some(golden.instance)).f, mean.pdf]
        };
        let errors = errors(&material.light, &values);
        let sample = |nm: f64, wi, u| plain.sample(nm, wi, u);
        let apart = distance(&golden, &material.light, &sample);
        println!("{}: {errors:?} {apart:.1e}", material.name);
        assert!(errors.iter().all(|error| *error < 1e-12) && apart < 1e-12, "{errors:?} {apart}");
    }
}

/// Elementary functions of other systems leave a few roundings.
#[test]
fn the_golden_values_are_those_that_the_program_writes() {
    let (golden, made) = (golden(), Golden::made());
    let about = |golden: &Golden| {
        let name = |material: &Material| (material.name.clone(), material.hash.clone());
        let names: Vec<_> = golden.materials.iter().map(name).collect();
        (golden.origin.clone(), golden.version, golden.wavelengths_nm.clone(), golden.u.clone(), names)
    };
    assert_eq!(about(&golden), about(&made));
    for material in &golden.materials {
        let brdf = FeatherBrdf::from_tables(tables(&material.name));
        let values = |wave: usize, wi: DVec3, wo: DVec3| {
            let exact = brdf.exact(golden.wavelengths_nm[wave], wi);
            let mean = exact.values(wo, None);
            [mean.f, exact.values(wo, Some(golden.instance)).f, mean.pdf]
        };
        let errors = errors(&material.light, &values);
        assert!(errors.iter().all(|error| *error < 1e-13), "{errors:?}");
    }
}
