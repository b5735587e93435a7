//! What a material's BRDF keeps of its promises, in figures: shared by the tests that hold them and the program that
//! prints them.

use barbule::brdf::{FeatherBrdf, FeatherMaterial};
use barbule::math::rng::Stream;
use barbule::scattering::directions::omega;
use glam::DVec3;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// ∫ pdf over a rectangle of (θ_o, φ_o), by recursive halving.
fn integral(brdf: &FeatherBrdf, wi: DVec3, area: [f64; 4], depth: u32) -> f64 {
    let [t0, t1, p0, p1] = area;
    let rule = |points: &[(f64, f64)]| -> f64 {
        let mut sum = 0.0;
        for &(x, wx) in points {
            let theta = t0 + (t1 - t0) * x;
            for &(y, wy) in points {
                let wo = omega(theta, p0 + (p1 - p0) * y);
                sum += wx * wy * brdf.pdf(500.0, wi, wo) * theta.cos();
            }
        }
        sum * (t1 - t0) * (p1 - p0)
    };
    let g3 = 0.5 - 0.15_f64.sqrt();
    let (coarse, fine) = (
        rule(&[(0.211_324_865_405_187, 0.5), (0.788_675_134_594_813, 0.5)]),
        rule(&[(g3, 5.0 / 18.0), (0.5, 4.0 / 9.0), (1.0 - g3, 5.0 / 18.0)]),
    );
    if depth > 1 && (coarse - fine).abs() < 5e-8 || depth > 12 {
        return fine;
    }
    let (tm, pm) = (0.5 * (t0 + t1), 0.5 * (p0 + p1));
    [[t0, tm, p0, pm], [tm, t1, p0, pm], [t0, tm, pm, p1], [tm, t1, pm, p1]]
        .iter()
        .map(|part| integral(brdf, wi, *part, depth + 1))
        .sum()
}

/// Inner edges between `count` bins that hold equally many of the values, and the ends ±90°.
fn edges(values: &[f64], count: usize) -> Vec<f64> {
    let right = std::f64::consts::FRAC_PI_2;
    let inner = (1..count).map(|k| values[k * values.len() / count]);
    std::iter::once(-right).chain(inner).chain([right]).collect()
}

/// The same bins cut finer: at quantiles, and beyond the outermost ones at distances that double.
fn finer(values: &[f64], edges: &[f64]) -> Vec<f64> {
    let count = values.len();
    let mut cuts: Vec<f64> = (1..24).map(|k| values[k * count / 24]).collect();
    let middle = values[count / 2];
    for end in [values[count / 24], values[23 * count / 24], values[0], values[count - 1]] {
        cuts.extend((0..12).map(|k| middle + (end - middle) * 1.7_f64.powi(k)));
    }
    cuts.extend(edges);
    cuts.retain(|c| (edges[0]..=edges[edges.len() - 1]).contains(c));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

/// ∫ pdf over each bin, `[θ, φ]`.
pub(crate) fn expected(brdf: &FeatherBrdf, wi: DVec3, pilot: [&[f64]; 2], bins: [&[f64]; 2]) -> Vec<f64> {
    let [thetas, phis] = [0, 1].map(|k| finer(pilot[k], bins[k]));
    let columns = bins[1].len() - 1;
    let mut sums = vec![0.0; (bins[0].len() - 1) * columns];
    for t in thetas.windows(2) {
        for p in phis.windows(2) {
            let inside = |edges: &[f64], at: f64| edges[1..edges.len() - 1].partition_point(|e| *e <= at);
            let row = inside(bins[0], 0.5 * (t[0] + t[1]));
            let column = inside(bins[1], 0.5 * (p[0] + p[1]));
            sums[row * columns + column] += integral(brdf, wi, [t[0], t[1], p[0], p[1]], 0);
        }
    }
    sums
}

/// How 20,000 samples at a wavelength compare with the density's integrals over 30 bins.
#[allow(dead_code)] // the program prints p alone
pub(crate) struct Chi {
    /// χ².
    pub(crate) statistic: f64,
    pub(crate) bins: u32,
    /// Probability of a larger χ².
    pub(crate) p: f64,
    /// ∫pdf over all bins, the outermost of which reach to the horizon.
    pub(crate) total: f64,
}

/// A χ² test of samples against their density at 500 nm.
pub(crate) fn chi_square(brdf: &FeatherBrdf, wi: DVec3, mut stream: Stream) -> Chi {
    let count = 20_000;
    let mut angles = |count: usize| -> Vec<(f64, f64)> {
        (0..count)
            .filter_map(|_| {
                let u = [stream.unit(), stream.unit()];
                brdf.sample(500.0, wi, u).map(|(wo, _)| (wo.y.asin(), wo.x.atan2(wo.z)))
            })
            .collect()
    };
    // Bins from a pilot run, so that they resolve the lobe wherever it is.
    let pilot = angles(4000);
    let sorted = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values
    };
    let pilot_theta = sorted(pilot.iter().map(|a| a.0).collect());
    let pilot_phi = sorted(pilot.iter().map(|a| a.1).collect());
    let (thetas, phis) = (edges(&pilot_theta, 5), edges(&pilot_phi, 6));
    let mut observed = [0.0; 30];
    for (t, p) in angles(count) {
        let row = thetas[1..5].partition_point(|e| *e <= t);
        observed[row * 6 + phis[1..6].partition_point(|e| *e <= p)] += 1.0;
    }
    let shares = expected(brdf, wi, [&pilot_theta, &pilot_phi], [&thetas, &phis]);
    let (mut statistic, mut bins) = (0.0, 0);
    let mut rest = [0.0; 2];
    for (o, share) in observed.iter().zip(&shares) {
        let e = share * count as f64;
        if e >= 8.0 {
            statistic += (o - e) * (o - e) / e;
            bins += 1;
        } else {
            rest = [rest[0] + o, rest[1] + e];
        }
    }
    if rest[1] >= 1.0 {
        statistic += (rest[0] - rest[1]).powi(2) / rest[1];
        bins += 1;
    }
    let p = 1.0 - ChiSquared::new(f64::from(bins - 1)).unwrap().cdf(statistic);
    Chi { statistic, bins, p, total: shares.iter().sum() }
}

/// |f(ω_i, ω_o) − f(ω_o, ω_i)| at 547 nm over pairs drawn from the lobe, weighted by what they carry, over the mean of
/// both.
pub(crate) fn reciprocity_deviation(brdf: &FeatherBrdf) -> f64 {
    let mut stream = Stream::new(8, &[]);
    let (mut difference, mut sum) = (0.0, 0.0);
    for _ in 0..20_000 {
        let wi = omega(stream.uniform(-1.2, 1.2), stream.uniform(-1.2, 1.2));
        let Some((wo, pdf)) = brdf.sample(547.0, wi, [stream.unit(), stream.unit()]) else { continue };
        let there = f64::from(brdf.eval([547.0; 4], wi, wo, None)[0]);
        let back = f64::from(brdf.eval([547.0; 4], wo, wi, None)[0]);
        difference += (there - back).abs() * wo.z / pdf;
        sum += 0.5 * (there + back) * wo.z / pdf;
    }
    difference / sum
}

/// Albedos of 400 instances, from the `first` name on, at 547 nm over that of the mean: average and standard deviation.
pub(crate) fn instance_albedos(brdf: &FeatherBrdf, first: u64) -> [f64; 2] {
    let wi = omega(0.2, 0.3);
    let mut stream = Stream::new(5, &[]);
    let samples: Vec<(DVec3, f64)> =
        (0..2000).filter_map(|_| brdf.sample(547.0, wi, [stream.unit(), stream.unit()])).collect();
    let prepared = brdf.prepare([547.0; 4], wi);
    let albedo = |instance: Option<u64>| -> f64 {
        let instance = instance.map(|name| brdf.instance(name));
        samples.iter().map(|(wo, pdf)| f64::from(prepared.eval(*wo, instance.as_ref())[0]) * wo.z / pdf).sum()
    };
    let mean = albedo(None);
    let count = 400;
    let ratios: Vec<f64> = (first..first + count).map(|n| albedo(Some(n)) / mean).collect();
    let average = ratios.iter().sum::<f64>() / count as f64;
    let variance = ratios.iter().map(|r| (r - average).powi(2)).sum::<f64>() / count as f64;
    [average, variance.sqrt()]
}

/// Smallest and largest albedo over random wavelengths and directions, also between the nodes of the tables.
pub(crate) fn albedos(brdf: &FeatherBrdf, count: usize) -> [f64; 2] {
    let mut stream = Stream::new(12, &[]);
    let mut ends = [f64::INFINITY, 0.0_f64];
    for _ in 0..count {
        let (z, azimuth) = (stream.unit().max(1e-4), stream.uniform(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        let wi = DVec3::new(r * azimuth.cos(), r * azimuth.sin(), z);
        let albedo = brdf.albedo(stream.uniform(380.0, 720.0) as f32, wi);
        ends = [ends[0].min(albedo), ends[1].max(albedo)];
    }
    ends
}

/// All nodes reflect all light.
pub(crate) fn whiten(material: &mut FeatherMaterial) {
    for set in &mut material.sets {
        for (lobe, share) in set.mean.iter_mut().zip([1.0, 0.0]) {
            lobe.reflected.fill(share);
        }
    }
}

/// A material that ships.
pub(crate) fn shipped(stem: &str) -> FeatherMaterial {
    barbule::io::decode_material(barbule_birds::material(stem).unwrap()).unwrap()
}
