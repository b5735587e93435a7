//! Cost of one evaluation, sample and density of a feather material, and of a hair fibre, four wavelengths at a time.
//! `cargo bench --workspace --bench brdf [-- FILE.barbule]`
//!
//! Every call has its own directions, instance and wavelengths, so that tables come from the caches in which they
//! would be in a renderer. Figures are the lower quartile of many short runs: what else runs on the machine lengthens
//! some of them and shortens none.

#![allow(clippy::print_stdout)] // its output is its result

use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::bsdf::{Absorption, FibreIndex, Frame, Hair, HairParameters, Hit, Surface};
use barbule::spectrum::dense::Lambdas;
use barbule_bench::brdf::{Call, calls, nanoseconds, nanoseconds_together};
use cpu_time::ProcessTime;
use glam::DVec3;
use std::hint::black_box;
use std::time::Instant;

/// How often all calls are made.
const ROUNDS: usize = 100;

/// Between a call's four wavelengths another four.
fn eight(call: &Call) -> [f32; 8] {
    std::array::from_fn(|k| call.waves[k / 2] + if k % 2 == 0 { 0.0 } else { 36.0 })
}

fn say(name: &str, nanoseconds: f64) {
    println!("{name:45} {nanoseconds:7.1} ns");
}

fn measure<R>(name: &str, calls: &[Call], call: impl FnMut(&Call, u64) -> R) {
    say(name, nanoseconds(calls, ROUNDS, call));
}

/// A fibre at the wavelengths of a call; light from its one direction to the other.
fn measure_hair(name: &str, calls: &[Call], index: FibreIndex, height_over_width: f64) {
    let absorption = Absorption::pigments(0.6, 0.1).expect("pigments");
    let parameters = HairParameters {
        longitudinal_roughness: 0.25,
        azimuthal_roughness: 0.3,
        scale_tilt: 0.035,
        index,
        absorption,
        height_over_width,
    };
    let surface = Surface::Hair(Hair::new(parameters).expect("hair"));
    let frame = Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
    let hit = Hit { frame, ..Hit::default() };
    let waves = |c: &Call| Lambdas::new(eight(c).map(f64::from));
    measure(&format!("{name}: bind"), calls, |c, _| surface.bind(&hit, c.wi, waves(c)));
    measure(&format!("{name}: bind, eval"), calls, |c, _| surface.bind(&hit, c.wi, waves(c)).eval(c.wo));
    measure(&format!("{name}: bind, sample"), calls, |c, n| {
        let choice = (n % 64) as f64 / 64.0;
        surface.bind(&hit, c.wi, waves(c)).sample([c.u[0], c.u[1], choice])
    });
    // One bound fibre towards many directions: what light sampling adds to a hit.
    let bound = surface.bind(&hit, calls[0].wi, waves(&calls[0]));
    measure(&format!("{name}: eval"), calls, |c, n| bound.eval(if n % 2 == 0 { c.wo } else { -c.wo }));
}

/// One prepared evaluation towards a light of its own, and three towards others.
fn towards_four(brdf: &FeatherBrdf, call: &Call, number: u64) -> [[f32; 4]; 4] {
    let prepared = brdf.prepare(call.waves, call.wi);
    let draw = brdf.instance(number);
    let near = |x: f64, z: f64| (call.wo + DVec3::new(x, 0.0, z)).normalize();
    [call.wo, near(0.1, 0.0), near(-0.1, 0.1), near(0.05, 0.1)].map(|wo| prepared.eval(wo, Some(&draw)))
}

fn main() {
    let material = example(50);
    let (begun, before) = (Instant::now(), ProcessTime::now());
    let brdf = FeatherBrdf::new(&material, Options::default()).expect("a material");
    let (wall, cpu) = (begun.elapsed().as_secs_f64(), before.elapsed().as_secs_f64());
    println!("{:45} {cpu:7.2} CPU s, {wall:.2} s", "load");
    if let Some(file) = std::env::args().skip(1).find(|a| !a.starts_with('-')) {
        let material = barbule::io::read_material(file.as_ref()).expect("a material");
        let before = ProcessTime::now();
        black_box(FeatherBrdf::new(&material, Options::default()).expect("a material"));
        println!("{:45} {:7.2} CPU s", format!("load of {file}"), before.elapsed().as_secs_f64());
    }
    let calls = calls(&brdf);
    measure("eval of 4 wavelengths with instance", &calls, |c, n| brdf.eval(c.waves, c.wi, c.wo, Some(n)));
    measure("eval of 4 wavelengths, smooth", &calls, |c, _| brdf.eval(c.waves, c.wi, c.wo, None));
    measure("eval of 8 wavelengths with instance", &calls, |c, n| brdf.eval(eight(c), c.wi, c.wo, Some(n)));
    measure("eval of 8 wavelengths, smooth", &calls, |c, _| brdf.eval(eight(c), c.wi, c.wo, None));
    say("eval of 4 wavelengths together, instance", nanoseconds_together(&brdf, &calls, true));
    say("eval of 4 wavelengths together, smooth", nanoseconds_together(&brdf, &calls, false));
    // What a renderer does: several lights at each point.
    measure("four evaluations of 4 of one hit, instance", &calls, |c, n| towards_four(&brdf, c, n));
    measure("prepare", &calls, |c, _| brdf.prepare(c.waves, c.wi));
    measure("sample with density", &calls, |c, _| brdf.sample(c.waves[0], c.wi, c.u));
    measure("densities of 4 wavelengths", &calls, |c, _| brdf.pdfs(c.waves, c.wi, c.wo));
    let few: Vec<Call> = (0..256).map(|k| calls[k % 16].clone()).collect();
    measure("eval with instance, tables in L1", &few, |c, n| brdf.eval(c.waves, c.wi, c.wo, Some(n % 4)));
    measure("eval smooth, tables in L1", &few, |c, _| brdf.eval(c.waves, c.wi, c.wo, None));
    measure_hair("hair", &calls, FibreIndex::Constant(1.55), 1.0);
    measure_hair("hair of keratin's dispersion", &calls, FibreIndex::Keratin, 1.0);
    measure_hair("elliptical hair", &calls, FibreIndex::Constant(1.55), 0.5);
    measure_hair("elliptical hair of keratin's dispersion", &calls, FibreIndex::Keratin, 0.5);
}
