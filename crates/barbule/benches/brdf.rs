//! Cost of one evaluation, sample and density of a feather material, four wavelengths at a time.

use barbule::brdf::{FeatherBrdf, Options, example};
use barbule::math::rng::Stream;
use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;

/// Random incident directions, each with an outgoing one that the lobe sends light to (no zeros to skip).
fn directions(brdf: &FeatherBrdf, count: usize) -> Vec<(DVec3, DVec3)> {
    let mut stream = Stream::new(1, &[]);
    let mut pairs = Vec::new();
    while pairs.len() < count {
        let z = stream.uniform(0.1, 1.0);
        let (sin, cos) = stream.uniform(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let wi = DVec3::new(r * cos, r * sin, z);
        if let Some((wo, _)) = brdf.sample(550.0, wi, [stream.unit(), stream.unit()]) {
            pairs.push((wi, wo));
        }
    }
    pairs
}

fn bench(c: &mut Criterion) {
    let material = example(50);
    let Ok(brdf) = FeatherBrdf::new(&material, Options::default()) else { return };
    let pairs = directions(&brdf, 4096);
    let waves = [420.0, 490.0, 565.0, 640.0];
    let mut at = 0;
    let mut next = move || {
        at = (at + 1) % pairs.len();
        (pairs[at], at as u64)
    };
    c.bench_function("eval of 4 wavelengths with instance", |b| {
        b.iter(|| {
            let ((wi, wo), instance) = next();
            black_box(brdf.eval(waves, wi, wo, Some(instance)))
        });
    });
    c.bench_function("eval of 4 wavelengths, smooth", |b| {
        b.iter(|| {
            let ((wi, wo), _) = next();
            black_box(brdf.eval(waves, wi, wo, None))
        });
    });
    c.bench_function("prepare", |b| b.iter(|| black_box(brdf.prepare(waves, next().0.0))));
    c.bench_function("sample with density", |b| {
        b.iter(|| {
            let ((wi, _), instance) = next();
            let u = (instance as f64 + 0.5) / 4096.0;
            black_box(brdf.sample(550.0, wi, [u, (97.0 * u).fract()]))
        });
    });
    c.bench_function("densities of 4 wavelengths", |b| {
        b.iter(|| {
            let ((wi, wo), _) = next();
            black_box(brdf.pdf4(waves, wi, wo))
        });
    });
    c.bench_function("load", |b| b.iter(|| black_box(FeatherBrdf::new(&material, Options::default()))));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).warm_up_time(std::time::Duration::from_millis(200))
        .measurement_time(std::time::Duration::from_millis(800));
    targets = bench
}
criterion_main!(benches);
