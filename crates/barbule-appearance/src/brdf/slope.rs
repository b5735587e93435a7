//! What each barbule's own slope makes of the wings of its lobe.
//!
//! Only barbules that happen to be tilted send light far from the mirror direction, so that in the wings they vary more than
//! speckle does (a contrast above 1), which no Gaussian field of one mean can. An instance's values are multiplied by
//!
//! ```text
//! τ = 1 + g(ω_i) h (E − 1),    h = a²/(0.2 + 0.2 a + 0.6 a³),    a = κ(ω_i)² b/l(λ, ω_i),    b = (x_i + x_o)²/(2 (z_i + z_o))
//! ```
//!
//! b is t² (z_i + z_o)/2 with the slope t = (x_i + x_o)/(z_i + z_o) of the facet that mirrors ω_i into ω_o: of facets that stand up, fewer
//! differ in phase where light comes and leaves flatly. It is the same both ways, so that τ is reciprocal. h is 0 in the mirror
//! direction, 1 at most, and falls again where light comes from edges instead of facets. E ≥ 0 of mean 1 is drawn for each
//! instance and each side of the mirror direction, the two wings of one barbule hardly correlate; E[τ] = 1 keeps the mean.

use std::sync::LazyLock;

use crate::math::normal;
use crate::math::rng::Stream;

/// Values that E has.
pub(super) const VALUES: usize = 256;

/// Deviation of lnE.
const DEVIATION: f64 = 1.16;

/// κ that a material may have.
pub(super) const STEEPNESS: (f32, f32) = (0.0, 1000.0);

/// ln of the least and of the largest κ that is looked for, and steps between.
const SCAN: (f64, f64, usize) = (-1.2, 4.6, 24);

/// Golden sections of a step, and of g from 0 to 1.
const SECTIONS: usize = 8;

/// α, β and γ of h = a²/(α + β a + γ a³), which is largest, 1, at a = 1: γ = 2α + β and 3α + 2β = 1. α was chosen: a smaller one
/// follows the wavelength better 30° beside the mirror direction, a larger one the starling's wings.
pub(super) const RISE: [f64; 3] = [0.2, 0.2, 0.6];

/// a beyond which h stays as it is, so that nothing overflows in single precision.
pub(super) const FARTHEST: f64 = 1e6;

/// Purpose of the random streams of this file.
const PURPOSE: u64 = 0x0073_6c6f_7065;

/// How an instance's slope tells in one incident direction.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Slope {
    /// κ.
    pub(super) steepness: f64,
    /// g, 0 to 1.
    pub(super) strength: f64,
    /// 1/l of the instances whose pattern is the same at all wavelengths.
    pub(super) achromatic_inverse_length: f64,
}

impl Slope {
    /// g h where ω_i + ω_o is `[x, z]`.
    pub(super) fn part(&self, [x, z]: [f64; 2], inverse_length: f64) -> f64 {
        self.of(self.steepness * self.steepness * bend([x, z]) * inverse_length)
    }

    /// g h for a.
    fn of(&self, a: f64) -> f64 {
        let a = a.min(FARTHEST);
        let [start, rise, fall] = RISE;
        self.strength * a * a / (start + rise * a + fall * a * a * a)
    }
}

/// b where ω_i + ω_o is `[x, z]`.
#[inline(always)]
pub(super) fn bend([x, z]: [f64; 2]) -> f64 {
    0.5 * x * x / z
}

/// The values of E: quantiles of a log-normal distribution, over their mean.
pub(super) fn values() -> Vec<f64> {
    let quantile = |k: usize| {
        let share = (k as f64 + 0.5) / VALUES as f64;
        libm::exp(DEVIATION * normal::quantile(share))
    };
    let values: Vec<f64> = (0..VALUES).map(quantile).collect();
    let mean = values.iter().sum::<f64>() / VALUES as f64;
    values.into_iter().map(|value| value / mean).collect()
}

/// Variance of E.
pub(super) static VARIANCE: LazyLock<f64> =
    LazyLock::new(|| values().iter().map(|value| (value - 1.0) * (value - 1.0)).sum::<f64>() / VALUES as f64);

/// Squared contrasts that so many instances are expected to show, population form, by g h.
#[derive(Debug)]
pub(super) struct Contrasts {
    /// Of τ times speckle, and of τ alone, at evenly spread g h from 0 to 1.
    nodes: Vec<[f64; 2]>,
}

/// Intervals of the table over g h.
const INTERVALS: usize = 32;

/// Draws of each group as large as a campaign are repeated until there are so many.
const DRAWS: usize = 64_000;

impl Contrasts {
    /// Draws instances in groups of `instances`: a sample's contrast falls short of the whole's the more, the rarer the
    /// instances are that make it.
    pub(super) fn new(instances: usize) -> Self {
        let instances = instances.max(2);
        let groups = DRAWS.div_ceil(instances);
        let values = values();
        let mut nodes = vec![[0.0; 2]; INTERVALS + 1];
        let mut drawn = vec![[0.0; 2]; instances];
        for group in 0..groups {
            let mut stream = Stream::new(0, &[PURPOSE, group as u64]);
            for draw in &mut drawn {
                *draw = [values[stream.bits() as usize % VALUES], -libm::log(1.0 - stream.unit())];
            }
            for (k, node) in nodes.iter_mut().enumerate() {
                let part = k as f64 / INTERVALS as f64;
                let of = |intensity: &dyn Fn(f64) -> f64| {
                    let (mut sum, mut squares) = (0.0, 0.0);
                    for [value, speckle] in &drawn {
                        let value = (1.0 + part * (value - 1.0)) * intensity(*speckle);
                        sum += value;
                        squares += value * value;
                    }
                    instances as f64 * squares / (sum * sum) - 1.0
                };
                node[0] += of(&|speckle| speckle) / groups as f64;
                node[1] += of(&|_| 1.0) / groups as f64;
            }
        }
        // Of speckle alone the expectation is known.
        let count = instances as f64;
        let known = (count - 1.0) / (count + 1.0) / nodes[0][0];
        nodes.iter_mut().for_each(|node| node[0] *= known);
        Self { nodes }
    }

    /// Of τ times speckle, and of τ alone.
    pub(super) fn at(&self, part: f64) -> [f64; 2] {
        let position = part.clamp(0.0, 1.0) * INTERVALS as f64;
        let below = (position as usize).min(INTERVALS - 1);
        let share = position - below as f64;
        [0, 1].map(|k| self.nodes[below][k] + share * (self.nodes[below + 1][k] - self.nodes[below][k]))
    }
}

/// Width of a band of outgoing azimuths over which contrasts are taken together, and how far from the mirror direction bands reach,
/// rad: beyond 40° they count less.
const BAND: f64 = 4.0 * RAD;
const NEAR: f64 = 40.0 * RAD;
const FAR: f64 = 48.0 * RAD;
const OF_FAR: f64 = 0.3;
const RAD: f64 = std::f64::consts::PI / 180.0;

/// What is within this of the horizon counts for nothing.
const HORIZON: f64 = 78.0 * RAD;

/// What was found of one incident polarization at one node in a band of azimuths.
struct Band {
    /// b/l.
    bend: f64,
    /// Contrast.
    contrast: f64,
    /// (s/f̂)² of the steady part.
    steady2: f64,
    /// What it counts.
    weight: f64,
}

/// What was found of one incident polarization at one node.
pub(super) struct Observed {
    bands: Vec<Band>,
}

impl Observed {
    /// From C² and (s/f̂)² of azimuths φ_o (rad) under light from φ_i at θ_i.
    pub(super) fn new(
        [cos_theta, phi_i]: [f64; 2],
        inverse_length: f64,
        azimuths: impl Iterator<Item = (f64, [f64; 2])>,
    ) -> Self {
        let count = (2.0 * FAR / BAND).round();
        let mut sums = vec![[0.0; 4]; count as usize];
        for (phi_o, [contrast2, steady2]) in azimuths {
            let place = ((phi_o + phi_i + FAR) / BAND).floor();
            if phi_o.abs() < HORIZON && contrast2 > 0.0 && (0.0..count).contains(&place) {
                let terms = [1.0, phi_o, contrast2, steady2];
                sums[place as usize].iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
            }
        }
        let band = |[count, phi_o, contrast2, steady2]: [f64; 4]| {
            let (phi_o, contrast) = (phi_o / count, (contrast2 / count).sqrt());
            let [x, z] = [libm::sin, libm::cos].map(|of| cos_theta * (of(phi_i) + of(phi_o)));
            let near = if (phi_o + phi_i).abs() < NEAR { 1.0 } else { OF_FAR };
            // Contrasts above 1 are those of a few bright instances, and as uncertain as they are large.
            let weight = near / contrast.max(1.0);
            Band { bend: bend([x, z]) * inverse_length, contrast, steady2: steady2 / count, weight }
        };
        Self { bands: sums.into_iter().filter(|[count, ..]| *count > 0.0).map(band).collect() }
    }

    /// How far from the contrasts that were found those are which this slope gives. What was found below that of speckle is
    /// the steady part's doing and no slope's: there the slope's aim is to leave speckle as it is.
    fn error(&self, contrasts: &Contrasts, slope: &Slope) -> f64 {
        let least = contrasts.at(0.0)[0].sqrt();
        let of = |band: &Band| {
            let [speckle, alone] = contrasts.at(slope.of(slope.steepness * slope.steepness * band.bend));
            let steady2 = if band.contrast > least { band.steady2 } else { 0.0 };
            let apart = band.contrast.max(least) - (speckle - steady2 * (speckle - alone)).sqrt();
            band.weight * apart * apart
        };
        self.bands.iter().map(of).sum()
    }
}

/// The slope with which instances vary as the simulated ones; none where any would make them vary too much. A scan of lnκ,
/// then golden sections, with the best g for each.
pub(super) fn solved(contrasts: &Contrasts, observed: &[Observed]) -> Slope {
    let error = |slope: &Slope| -> f64 { observed.iter().map(|one| one.error(contrasts, slope)).sum() };
    let at = |ln: f64| -> (f64, Slope) {
        let steepness = libm::exp(ln);
        let (strength, least) =
            golden([0.0, 1.0], |strength| error(&Slope { steepness, strength, ..Slope::default() }));
        (least, Slope { steepness, strength, ..Slope::default() })
    };
    let (first, last, steps) = SCAN;
    let step = (last - first) / steps as f64;
    let place = |k: usize| first + k as f64 * step;
    let scanned: Vec<f64> = (0..=steps).map(|k| at(place(k)).0).collect();
    let best = (0..=steps).min_by(|&a, &b| scanned[a].total_cmp(&scanned[b])).unwrap_or(0);
    let (ln, least) = golden([place(best) - step, place(best) + step], |ln| at(ln).0);
    if least < error(&Slope::default()) { at(ln).1 } else { Slope::default() }
}

/// Where a function of one valley is least, and its value there.
fn golden([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> (f64, f64) {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let [mut a, mut b] = [high - ratio * (high - low), low + ratio * (high - low)];
    let [mut at_a, mut at_b] = [f(a), f(b)];
    for _ in 0..SECTIONS {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - ratio * (high - low);
            at_a = f(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + ratio * (high - low);
            at_b = f(b);
        }
    }
    if at_a < at_b { (a, at_a) } else { (b, at_b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_keep_the_mean_and_are_never_dark_twice() {
        let values = values();
        assert!((values.iter().sum::<f64>() / VALUES as f64 - 1.0).abs() < 1e-12);
        assert!(values.iter().all(|value| *value > 0.0));
        // The log-normal distribution's own variance, less what quantiles leave out of its tail.
        let whole = libm::exp(DEVIATION * DEVIATION) - 1.0;
        assert!((0.75 * whole..whole).contains(&*VARIANCE), "{} {whole}", *VARIANCE);
        let slope = Slope { steepness: 1.0, strength: 1.0, ..Slope::default() };
        let most = (0..10_000).map(|k| slope.part([0.001 * f64::from(k), 0.5], 1.0)).fold(0.0, f64::max);
        assert!((most - 1.0).abs() < 1e-6 && slope.part([1.0, 0.5], 1.0) <= 1.0 + 1e-12, "{most}");
        assert_eq!(slope.part([0.0, 1.0], 1.0), 0.0);
        assert!(Slope { steepness: 1000.0, ..slope }.part([1.9, 1e-12], 64.0).is_finite());
    }

    /// Of many instances the contrasts are those of the moments: E[τ²] times 2 or 1, less 1.
    #[test]
    fn contrasts_of_many_instances_follow_from_the_moments() {
        let contrasts = Contrasts::new(16_000);
        for part in [0.0, 0.3, 1.0] {
            let squares = 1.0 + part * part * *VARIANCE;
            let [speckle, alone] = contrasts.at(part);
            assert!((speckle / (2.0 * squares - 1.0) - 1.0).abs() < 0.05, "{part} {speckle} {squares}");
            assert!((alone - (squares - 1.0)).abs() < 0.05 * squares, "{part} {alone} {squares}");
        }
        // Few instances seldom hold one of the rare bright ones.
        let few = Contrasts::new(50).at(1.0);
        assert!(few[0] < 0.95 * contrasts.at(1.0)[0], "{few:?}");
    }
}
