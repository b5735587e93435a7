//! The cost of a material's values: many short runs, of which the lower quartile is told, since what else runs on a machine lengthens
//! some of them and shortens none.

use std::hint::black_box;
use std::time::Instant;

use barbule::brdf::{FeatherBrdf, PlainBrdf};
use barbule::math::rng::Stream;
use barbule::progress::Progress;
use barbule::{Error, Result};
use glam::DVec3;

/// Calls with arguments of their own, so that tables come from the caches in which they would be in a renderer.
const COUNT: usize = 4096;
/// Calls in a run.
const RUN: usize = 256;
/// How often all calls are made; plain ones take many times as long.
const ROUNDS: usize = 100;
const PLAIN_CALLS: usize = 256;

/// One call's arguments; the lobe sends light from the one direction to the other (no zeros to skip).
#[derive(Debug, Clone)]
pub struct Call {
    /// Towards the light.
    pub wi: DVec3,
    /// Towards the eye.
    pub wo: DVec3,
    /// Wavelengths, nm.
    pub waves: [f32; 4],
    /// Two uniform numbers.
    pub u: [f64; 2],
}

/// What one call takes, ns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrdfFigures {
    /// Four wavelengths of an instance.
    pub instance_ns: f64,
    /// Four wavelengths of the mean.
    pub smooth_ns: f64,
    /// Four wavelengths of an instance, 256 pairs of directions together.
    pub together_ns: f64,
    /// A direction drawn with its density.
    pub sample_ns: f64,
    /// How much longer the plain evaluation takes for four wavelengths of an instance.
    pub plain_ratio: f64,
    /// The largest difference of both, over the largest value.
    pub difference: f64,
}

/// Arguments of as many calls.
#[must_use]
pub fn calls(brdf: &FeatherBrdf) -> Vec<Call> {
    let mut stream = Stream::new(1, &[]);
    let mut calls = Vec::new();
    while calls.len() < COUNT {
        let z = stream.uniform(0.1, 1.0);
        let (sin, cos) = stream.uniform(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let wi = DVec3::new(r * cos, r * sin, z);
        let u = [stream.unit(), stream.unit()];
        let first = stream.uniform(400.0, 470.0);
        let waves = [0.0, 75.0, 150.0, 220.0].map(|step| (first + step) as f32);
        if let Some((wo, _)) = brdf.sample(waves[0], wi, u) {
            calls.push(Call { wi, wo, waves, u });
        }
    }
    calls
}

/// Lower quartile of ns per call over runs of some calls.
pub fn nanoseconds<R>(calls: &[Call], rounds: usize, mut call: impl FnMut(&Call, u64) -> R) -> f64 {
    let mut times = Vec::new();
    let mut instance = 0;
    for _ in 0..rounds {
        for run in calls.chunks(RUN) {
            let begun = Instant::now();
            for arguments in run {
                instance += 1;
                black_box(call(black_box(arguments), instance));
            }
            times.push(begun.elapsed().as_secs_f64() * 1e9 / run.len() as f64);
        }
    }
    quartile(times)
}

/// The same of pairs together, as many in a run; of instances, or of the mean.
#[must_use]
pub fn nanoseconds_together(brdf: &FeatherBrdf, calls: &[Call], has_instances: bool) -> f64 {
    let directions: Vec<_> = calls.iter().map(|call| [call.wi, call.wo]).collect();
    let waves: Vec<_> = calls.iter().map(|call| call.waves).collect();
    let mut names: Vec<u64> = (0..calls.len() as u64).collect();
    let mut values = vec![[0.0; 4]; calls.len()];
    let mut times = Vec::new();
    for _ in 0..ROUNDS {
        names.iter_mut().for_each(|name| *name += COUNT as u64);
        for first in (0..calls.len()).step_by(RUN) {
            let run = first..calls.len().min(first + RUN);
            let begun = Instant::now();
            let names = has_instances.then(|| &names[run.clone()]);
            brdf.eval_all(&directions[run.clone()], &waves[run.clone()], names, &mut values[run.clone()]);
            black_box(&values);
            times.push(begun.elapsed().as_secs_f64() * 1e9 / run.len() as f64);
        }
    }
    quartile(times)
}

fn quartile(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 4]
}

/// Measures a material's values on one thread, and holds them against the plain evaluation.
///
/// # Errors
/// The user cancelled.
pub fn measure(brdf: &FeatherBrdf, progress: &dyn Progress) -> Result<BrdfFigures> {
    const STAGES: u64 = 5;
    progress.begin("values of the material", STAGES);
    let done = |value: f64| {
        progress.advance(1);
        if progress.is_cancelled() { Err(Error::interrupted()) } else { Ok(value) }
    };
    let calls = calls(brdf);
    let fast = |c: &Call, n: u64| brdf.eval(c.waves, c.wi, c.wo, Some(n));
    let instance_ns = done(nanoseconds(&calls, ROUNDS, fast))?;
    let smooth_ns = done(nanoseconds(&calls, ROUNDS, |c, _| brdf.eval(c.waves, c.wi, c.wo, None)))?;
    let together_ns = done(nanoseconds_together(brdf, &calls, true))?;
    let sample_ns = done(nanoseconds(&calls, ROUNDS, |c, _| brdf.sample(c.waves[0], c.wi, c.u)))?;
    let plain = PlainBrdf::new(brdf.tables());
    let values = |c: &Call, n: u64| c.waves.map(|nm| plain.values(f64::from(nm), c.wi, c.wo, Some(n)).f);
    let few = &calls[..PLAIN_CALLS];
    let plain_ratio = done(nanoseconds(few, 1, values) / instance_ns)?;
    let (mut difference, mut largest) = (0.0_f64, 0.0_f64);
    for (number, call) in few.iter().enumerate() {
        for (a, b) in fast(call, number as u64).iter().zip(values(call, number as u64)) {
            difference = difference.max((f64::from(*a) - b).abs());
            largest = largest.max(b);
        }
    }
    let difference = difference / largest;
    Ok(BrdfFigures { instance_ns, smooth_ns, together_ns, sample_ns, plain_ratio, difference })
}
