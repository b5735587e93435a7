//! Values from the arrays of [`BrdfTables`] alone, as `docs/formats/brdf-tables.md` has them step by step: slow, in double
//! precision, and the reference of every other back end.

use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::arrays::Numbers;
use super::exact::Values;
use super::tables::{BrdfTables, Reciprocity, TablesHeader};
use crate::math::normal;
use crate::math::rng::hash;
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::FitKind;
use crate::scattering::statistics::Sides;

/// Points in half a period of the noise.
const HALF: usize = 512;

/// z of directions that leave the surface is above this.
const LEAST_COSINE: f64 = 1e-10;

/// A feather's BRDF, evaluated in the obvious way.
#[derive(Debug, Clone)]
pub struct PlainBrdf {
    header: TablesHeader,
    arrays: BTreeMap<String, Vec<f64>>,
}

/// ω_i in its cell, steps 1 and 2.
struct Light {
    /// −1 where mirrored.
    sign: f64,
    tau: f64,
    y: f64,
    cos_theta: f64,
    /// Places of the cell along θ and φ, the nearer one first, and the shares of the others.
    rows: [usize; 2],
    columns: [usize; 2],
    shares: [f64; 2],
}

/// A node that counts, step 3.
struct Node {
    weight: f64,
    /// Its number.
    at: usize,
    c: f64,
    t: f64,
}

/// What the nodes of a set say together, steps 4, 5 and 10.
#[derive(Default)]
struct Across {
    mean: f64,
    steady: f64,
    inverse_length: f64,
    gamma: f64,
    fraction: f64,
    fraction_slope: f64,
    density: f64,
    chance: f64,
}

impl PlainBrdf {
    /// Copies the arrays.
    #[must_use]
    pub fn new(tables: &BrdfTables) -> Self {
        let doubles = |numbers: &Numbers<'_>| -> Vec<f64> {
            match numbers {
                Numbers::F64(values) => values.to_vec(),
                Numbers::F32(values) => values.iter().map(|v| f64::from(*v)).collect(),
                Numbers::I16(values) => values.iter().map(|v| f64::from(*v)).collect(),
            }
        };
        let arrays = tables.arrays().into_iter().map(|array| (array.name, doubles(&array.numbers)));
        Self { header: tables.header(), arrays: arrays.collect() }
    }

    /// f, s and the density at a wavelength (nm); f is that of an instance, or the smooth mean.
    #[must_use]
    pub fn values(&self, wavelength_nm: f64, wi: DVec3, wo: DVec3, instance: Option<u64>) -> Values {
        if !(wi.z > LEAST_COSINE && wo.z > LEAST_COSINE) {
            return Values::default();
        }
        let there = self.one_way(wavelength_nm, wi, wo, instance);
        if self.header.reciprocity == Reciprocity::AsFitted {
            return there;
        }
        let back = self.one_way(wavelength_nm, wo, wi, instance);
        if self.header.reciprocity == Reciprocity::Mean || self.header.sides == Sides::Both {
            let (f, steady) = (0.5 * (there.f + back.f), 0.5 * (there.steady + back.steady));
            return Values { f, steady, pdf: there.pdf };
        }
        let tangents = [wi, wo].map(|w| w.x.abs() / w.z);
        let is_steeper = tangents[1] < tangents[0] || (tangents[1] == tangents[0] && wo.z > wi.z);
        let [least, most] = [80.0_f64, 85.0].map(|phi| phi.to_radians().cos());
        let cosine = (wi.z / wi.x.hypot(wi.z)).min(wo.z / wo.x.hypot(wo.z));
        let w = ((least - cosine) / (least - most)).clamp(0.0, 1.0);
        let of = |there: f64, back: f64| {
            (1.0 - w) * if is_steeper { back } else { there } + w * (there * back).max(0.0).sqrt()
        };
        Values { f: of(there.f, back.f), steady: of(there.steady, back.steady), pdf: there.pdf }
    }

    /// ω_o drawn from the mean lobes at a wavelength (nm), steps 11 to 14.
    #[must_use]
    pub fn sample(&self, wavelength_nm: f64, wi: DVec3, [u0, u1]: [f64; 2]) -> Option<DVec3> {
        if wi.z.is_nan() || wi.z <= LEAST_COSINE {
            return None;
        }
        let light = self.light(wi);
        let nodes = self.nodes(&light, wavelength_nm);
        let mut chances = Vec::new();
        for set in 0..self.header.sets {
            for node in &nodes {
                for lobe in 0..2 {
                    let k = self.of_set(set, "shares")[4 * node.at + 2 + lobe];
                    chances.push((node.weight * k, set, node, lobe));
                }
            }
        }
        let mut rest = u0 * chances.iter().map(|(chance, ..)| chance).sum::<f64>();
        let mut drawn = None;
        for &(chance, set, node, lobe) in chances.iter().filter(|(chance, ..)| *chance > 0.0) {
            drawn = Some((set, node, lobe, (rest / chance).min(1.0 - f64::EPSILON)));
            if rest < chance {
                break;
            }
            rest -= chance;
        }
        let (set, node, lobe, u) = drawn?;
        let numbers = &self.of_set(set, "nodes")[16 * node.at..][..16];
        let [sin_phi, cos_phi] = azimuth(numbers[lobe], numbers[6 + lobe] / node.t, node.t / light.tau, u1);
        let [y, cos_theta] = self.inclination(&light, &nodes, u);
        let wo = DVec3::new(cos_theta * light.sign * sin_phi, y, cos_theta * cos_phi);
        (wo.z > LEAST_COSINE).then_some(wo)
    }

    fn of(&self, name: &str) -> &[f64] {
        &self.arrays[name]
    }

    fn of_set(&self, set: usize, name: &str) -> &[f64] {
        if self.header.sets == 1 { self.of(name) } else { self.of(&format!("p{}.{name}", set + 1)) }
    }

    fn light(&self, wi: DVec3) -> Light {
        let cos_theta = wi.x.hypot(wi.z);
        let sign = if self.header.sides == Sides::Alike && wi.x < 0.0 { -1.0 } else { 1.0 };
        let (sin_phi, cos_phi) = (sign * wi.x / cos_theta, wi.z / cos_theta);
        let (row, theta) = find(self.of("theta"), cos_theta);
        let (column, phi) = find(self.of("phi"), (1.0 - cos_phi).copysign(sin_phi));
        let outwards = self.of("phi")[column] >= 0.0;
        Light {
            sign,
            tau: tau(sin_phi, cos_phi.max(1e-4)),
            y: wi.y,
            cos_theta,
            rows: [row, row + 1],
            columns: if outwards { [column, column + 1] } else { [column + 1, column] },
            shares: [theta, if outwards { phi } else { 1.0 - phi }],
        }
    }

    fn nodes(&self, light: &Light, wavelength_nm: f64) -> Vec<Node> {
        let (wave, share) = find(self.of("wavelengths_nm"), wavelength_nm);
        let mut axes = [(share, 0), (light.shares[0], 1), (light.shares[1], 2)];
        axes.sort_by(|a, b| b.0.total_cmp(&a.0));
        let ([mut up, mut row, mut column], mut above) = ([0; 3], 1.0);
        let mut nodes = Vec::new();
        for step in 0..4 {
            let below = axes.get(step).map_or(0.0, |(share, _)| *share);
            let (t, p) = (light.rows[row], light.columns[column]);
            let w = (wave + up).min(self.header.waves - 1);
            nodes.push(Node {
                weight: f64::from((above - below) as f32),
                at: (t * self.header.phis + p) * self.header.waves + w,
                c: self.of("cos_theta")[t],
                t: self.of("tangents")[p],
            });
            above = below;
            match axes.get(step) {
                Some((_, 0)) => up = 1,
                Some((_, 1)) => row = 1,
                _ => column = 1,
            }
        }
        nodes
    }

    /// κ, g and 1/l of achromatic instances.
    fn slope(&self, light: &Light) -> [f64; 3] {
        let [theta, phi] = light.shares;
        let (a, b) = (theta.max(phi), theta.min(phi));
        let first = if theta >= phi { [1, 0] } else { [0, 1] };
        let mut mixed = [0.0; 3];
        for (weight, [row, column]) in [(1.0 - a, [0, 0]), (a - b, first), (b, [1, 1])] {
            let at = light.rows[row] * self.header.phis + light.columns[column];
            for (k, sum) in mixed.iter_mut().enumerate() {
                *sum += weight * self.of("slopes")[3 * at + k];
            }
        }
        mixed
    }

    fn across(&self, set: usize, light: &Light, nodes: &[Node], [sin_phi, cos_phi]: [f64; 2]) -> Across {
        let tau = light.tau * tau(light.sign * sin_phi, cos_phi.max(1e-8));
        let mut sum = Across::default();
        for &Node { weight, at, c, t } in nodes {
            let numbers = &self.of_set(set, "nodes")[16 * at..][..16];
            let shares = &self.of_set(set, "shares")[4 * at..][..4];
            let e = 1.0 / t.hypot(tau);
            let cosine = 2.0 * tau * t * e * e;
            let z = c * cosine;
            let weighted = weight * cosine / cos_phi.max(1e-8);
            for lobe in 0..3 {
                let [m2, r, m, a] = [0, 3, 6, 9].map(|first| numbers[first + lobe]);
                let q = m2 + r * ((tau - m) * e).powi(2);
                let aligned = if self.header.kind == FitKind::Marginal { (tau + m) * e } else { 1.0 };
                let root = (z * z + m2 * (1.0 - z * z)).sqrt();
                if lobe == 2 {
                    sum.steady += weight * a / (q * q);
                } else {
                    sum.mean += weighted * a * aligned * z / (q * q * (z + root));
                    sum.density += weighted * shares[lobe] * (t + tau * m / t) * e / (q * q);
                    sum.chance += weight * shares[2 + lobe];
                }
            }
            sum.inverse_length += weight * numbers[12];
            sum.gamma += weight * numbers[13];
            sum.fraction += weight * numbers[14];
            sum.fraction_slope += weight * numbers[15];
        }
        Across { steady: sum.steady.min(1.0) * sum.mean, ..sum }
    }

    fn one_way(&self, wavelength_nm: f64, wi: DVec3, wo: DVec3, instance: Option<u64>) -> Values {
        let (light, cos_o) = (self.light(wi), wo.x.hypot(wo.z));
        let nodes = self.nodes(&light, wavelength_nm);
        let sets = self.header.sets;
        let (mut f, mut steady, mut density, mut chance) = (0.0, 0.0, 0.0, 0.0);
        for set in 0..sets {
            let mut across = self.across(set, &light, &nodes, [wo.x / cos_o, wo.z / cos_o]);
            let facet = (light.sign * (wi.x + wo.x) / (wi.z + wo.z)).clamp(-1.0, 1.0);
            across.fraction = (across.fraction + across.fraction_slope * facet).clamp(0.0, 1.0);
            let own = match (self.header.polarization, sets, set) {
                (Some(Polarization::First), ..) | (None, 2, 0) => 2.0 * across.fraction,
                (Some(Polarization::Second), ..) | (None, 2, _) => 2.0 - 2.0 * across.fraction,
                (None, ..) => 1.0,
            };
            (across.mean, across.steady) = (own * across.mean, own * across.steady);
            f += match instance {
                None => across.mean,
                Some(name) => self.drawn(set, &across, self.slope(&light), [wi, wo], wavelength_nm, name),
            } / sets as f64;
            steady += across.steady / sets as f64;
            density += across.density;
            chance += across.chance;
        }
        let cosine = light.cos_theta * cos_o - light.y * wo.y;
        let sine = light.y * cos_o + wo.y * light.cos_theta;
        let t2 = if cosine > 0.0 { sine * sine / (2.0 + 2.0 * cosine) } else { 0.5 * (1.0 - cosine) };
        let sigmas = self.sigmas();
        let inverse_q = self.of("inverse_q");
        let last = inverse_q.len() / sigmas.len() - 1;
        let place = light.cos_theta.sqrt() * last as f64;
        let low = (place as usize).min(last - 1);
        let share = place - low as f64;
        let (mut l, mut along) = (0.0, 0.0);
        for (part, (sigma, own)) in sigmas.iter().zip(self.parts(&nodes)).enumerate() {
            let spread = own * (-t2 / (sigma * sigma)).exp();
            let q = |row: usize| inverse_q[row * sigmas.len() + part];
            l += spread * (q(low) * (1.0 - share) + q(low + 1) * share) / wo.z;
            let mass: f64 = ends(light.y).iter().map(|t| libm::erf(t / sigma)).sum();
            along += spread * (1.0 - t2).max(0.0).sqrt() / (sigma * PI.sqrt() * cos_o * mass);
        }
        Values { f: l * f, steady: l * steady, pdf: density / chance * along }
    }

    /// σ of the Gaussians along the barbule.
    fn sigmas(&self) -> Vec<f64> {
        let halo = self.header.halo.into_iter().take_while(|sigma| *sigma > 0.0);
        std::iter::once(self.header.sigma).chain(halo).collect()
    }

    /// Their shares.
    fn parts(&self, nodes: &[Node]) -> [f64; 4] {
        let Some(along) = self.arrays.get("along") else { return [1.0, 0.0, 0.0, 0.0] };
        let of = |part: usize| nodes.iter().map(|node| node.weight * along[4 * node.at + part]).sum();
        [0, 1, 2, 3].map(of)
    }

    /// P of an instance, steps 7 and 8.
    fn drawn(
        &self,
        set: usize,
        across: &Across,
        [kappa, g, achromatic]: [f64; 3],
        [wi, wo]: [DVec3; 2],
        wavelength_nm: f64,
        name: u64,
    ) -> f64 {
        let h = hash(self.header.seed, &[name]);
        let [first, own] = self.noise(h, wi + wo, wavelength_nm, [across.inverse_length, achromatic]);
        let rest = (1.0 - across.gamma * across.gamma).max(0.0).sqrt();
        let second = [0, 1].map(|k| across.gamma * first[k] + rest * own[k]);
        let Across { mean, steady, fraction, .. } = *across;
        let value = match (self.header.polarization, self.header.sets, set) {
            (Some(Polarization::First), ..) | (None, 2, 0) => speckle(mean, steady, first),
            (Some(Polarization::Second), ..) | (None, 2, _) => speckle(mean, steady, second),
            (None, ..) => {
                let of = |part: f64, noise| speckle(2.0 * part * mean, 2.0 * part * steady, noise);
                0.5 * (of(fraction, first) + of(1.0 - fraction, second))
            }
        };
        let sum = wi + wo;
        let wing = self.of("wings")[(h >> if sum.x < 0.0 { 8 } else { 28 }) as usize % 256];
        let a = (0.5 * kappa * kappa * sum.x * sum.x / sum.z * across.inverse_length).min(1e6);
        value * (1.0 + g * (wing - 1.0) * a * a / (0.2 + 0.2 * a + 0.6 * a.powi(3)))
    }

    /// q and q' of an instance by its hash, at ω_i + ω_o, with 1/l and that of achromatic instances.
    fn noise(
        &self,
        h: u64,
        sum: DVec3,
        wavelength_nm: f64,
        [inverse_length, achromatic]: [f64; 2],
    ) -> [[f64; 2]; 2] {
        let more = h.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let is_achromatic = ((more >> 48) as f64) < 65_536.0 * self.header.spectral.achromatic;
        let x = sum.x * if is_achromatic { achromatic } else { inverse_length };
        let place = 512.0 * x.clamp(-512.0, 512.0) - 0.5;
        let (k, t) = (place.floor() as i64, place - place.floor());
        let (shift, direction) = ((h >> 16) as i64 % 1024, if h >> 63 == 1 { -1 } else { 1 });
        let first = (h % 128) as f64 + (more >> 40 & 255) as f64 / 256.0;
        // Single precision, as of the program's own. The number is written out, and not `NOISE_SLICE`: this is the reference,
        // by the documentation alone, that would catch another one there.
        let height = if is_achromatic { 0.0 } else { (self.header.spectral.height_um / 1.5175) as f32 };
        let base = (first + f64::from(height) * sum.z * 2000.0 * PI / wavelength_nm).min(32_768.0);
        let s = base - base.floor();
        let scale = (1.0 - 2.0 * t * (1.0 - t) * (1.0 - self.of("autocovariance")[1])).sqrt()
            * (1.0 - 2.0 * s * (1.0 - s)).sqrt();
        let mut numbers = [0.0; 4];
        for (k, weight) in [(k, 1.0 - t), (k + 1, t)] {
            let point = (shift + direction * k).rem_euclid(1024) as usize;
            let row = (base as usize % 128) * (HALF + 1) + point % HALF;
            for (part, number) in numbers.iter_mut().enumerate() {
                let part = if point < HALF { part } else { (part + 2) % 4 };
                for (next, share) in [(0, 1.0 - s), (4, s)] {
                    *number += weight * share / scale * self.of("codes")[8 * row + next + part];
                }
            }
        }
        let turned = |bits: u64, [a, b]: [f64; 2]| {
            let at = 2 * (bits as usize % 1024);
            let (c, s) = (self.of("rotations")[at], self.of("rotations")[at + 1]);
            [a * c - b * s, a * s + b * c]
        };
        let [a, b, own_a, own_b] = numbers;
        [turned(h >> 40, [a, b]), turned(h >> 50, [own_a, own_b])]
    }

    /// sinθ_o and cosθ_o, step 13.
    fn inclination(&self, light: &Light, nodes: &[Node], u: f64) -> [f64; 2] {
        let (sigmas, parts) = (self.sigmas(), self.parts(nodes));
        let (mut part, mut u) = (0, u * parts.iter().sum::<f64>());
        while part + 1 < sigmas.len() && u >= parts[part] {
            u -= parts[part];
            part += 1;
        }
        let u = (u / parts[part]).min(1.0 - f64::EPSILON);
        let sigma = sigmas[part];
        let [below, above] = ends(light.y);
        let [from, to] = [0.5 * libm::erfc(below / sigma), 0.5 * libm::erfc(-above / sigma)];
        let p = (from + u * (to - from)).clamp(1e-300, 1.0 - f64::EPSILON / 2.0);
        let t = (sigma * FRAC_1_SQRT_2 * normal::quantile(p)).clamp(-below, above);
        let (sine, cosine) = (2.0 * t * (1.0 - t * t).sqrt(), 1.0 - 2.0 * t * t);
        [sine * light.cos_theta - cosine * light.y, cosine * light.cos_theta + sine * light.y]
    }
}

/// The place below and the share of the next.
fn find(places: &[f64], at: f64) -> (usize, f64) {
    if places.len() == 1 {
        return (0, 0.0);
    }
    let below = places.partition_point(|place| *place <= at).clamp(1, places.len() - 1) - 1;
    (below, ((at - places[below]) / (places[below + 1] - places[below])).clamp(0.0, 1.0))
}

/// τ of an azimuth by its sine and cosine.
fn tau(sine: f64, cosine: f64) -> f64 {
    if sine < 0.0 { cosine / (1.0 - sine) } else { (1.0 + sine) / cosine }
}

/// t₋ and t₊.
fn ends(y: f64) -> [f64; 2] {
    [(0.5 * (1.0 - y)).sqrt(), (0.5 * (1.0 + y)).sqrt()]
}

fn speckle(mean: f64, steady: f64, [q_r, q_i]: [f64; 2]) -> f64 {
    let steady = steady.min(mean);
    let half = 0.5 * (mean - steady);
    (half.sqrt() * q_r + steady.sqrt()).powi(2) + half * q_i * q_i
}

/// sinφ_o and cosφ_o of a lobe with this m² and τ(−φ_eff), turned back by the factor T/τ_i: step 12.
fn azimuth(m2: f64, tau_eff: f64, back: f64, u: f64) -> [f64; 2] {
    let half = FRAC_1_SQRT_2 / tau_eff.hypot(1.0);
    let (sine, cosine) = ((1.0 - tau_eff) * half, (1.0 + tau_eff) * half);
    let [below, above] = [sine - cosine, sine + cosine].map(|sum| FRAC_1_SQRT_2 * sum);
    let a = (m2 / (1.0 - m2).max(1e-12)).sqrt();
    let h = if a > 1000.0 {
        below + u * (above - below)
    } else {
        let [first, last] = [below, above].map(|h| student(h / a));
        a * quantile(first + u * (last - first))
    };
    let phi = 2.0 * h.clamp(below, above).asin() - 2.0 * sine.atan2(cosine);
    let tau = tau(phi.sin(), phi.cos().max(0.0)) * back;
    [(tau - 1.0) * (tau + 1.0) / (tau * tau + 1.0), 2.0 * tau / (tau * tau + 1.0)]
}

/// V(x).
fn student(x: f64) -> f64 {
    (x / (1.0 + x * x) + x.atan()) / PI
}

/// The x of V(x) = v: its δ by halving.
fn quantile(v: f64) -> f64 {
    let z = PI - 2.0 * PI * v.abs();
    let (mut low, mut high) = (0.0, PI);
    for _ in 0..64 {
        let delta = 0.5 * (low + high);
        if delta - delta.sin() < z { low = delta } else { high = delta }
    }
    (1.0 / (0.25 * (low + high)).tan()).copysign(v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::fixtures::{example, halo};
    use crate::brdf::{FeatherBrdf, FeatherMaterial, Options};
    use crate::math::rng::Stream;

    /// The largest errors of f and s over the smooth mean, of densities over themselves, and of sampled directions.
    fn errors(material: &FeatherMaterial, options: Options) -> [f64; 3] {
        let brdf = FeatherBrdf::new(material, options).unwrap();
        let plain = PlainBrdf::new(brdf.tables());
        let mut stream = Stream::new(3, &[]);
        let mut worst = [0.0_f64; 3];
        for instance in 0..400 {
            let z = stream.uniform(0.005, 1.0);
            let (sin, cos) = stream.uniform(0.0, 6.3).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let wi = DVec3::new(r * cos, r * sin, z);
            let u = [stream.unit(), stream.unit()];
            let nm = stream.uniform(380.0, 720.0) as f32;
            let (drawn, plainly) = (brdf.sample(nm, wi, u), plain.sample(f64::from(nm), wi, u));
            assert_eq!(drawn.is_some(), plainly.is_some(), "{wi} {u:?}");
            let (Some((wo, _)), Some(plainly)) = (drawn, plainly) else { continue };
            worst[2] = worst[2].max((wo - plainly).length());
            let exact = brdf.exact(f64::from(nm), wi);
            let mean = exact.values(wo, None).f;
            for name in [None, Some(instance)] {
                let (exact, plain) = (exact.values(wo, name), plain.values(f64::from(nm), wi, wo, name));
                let error = (exact.f - plain.f).abs().max((exact.steady - plain.steady).abs()) / mean;
                worst[0] = worst[0].max(error);
                worst[1] = worst[1].max((plain.pdf / exact.pdf - 1.0).abs());
            }
        }
        worst
    }

    fn assert_same(material: &FeatherMaterial, options: Options) {
        let [f, pdf, direction] = errors(material, options);
        println!("{:?}: f {f:.1e}, pdf {pdf:.1e}, direction {direction:.1e}", material.kind);
        assert!(f < 1e-12 && pdf < 1e-12 && direction < 1e-12, "{options:?}: {f} {pdf} {direction}");
    }

    #[test]
    fn the_page_says_what_the_program_does() {
        let material = example(5);
        for options in [
            Options::default(),
            Options { reciprocity: Reciprocity::Mean, sigma: Some(0.2), ..Options::default() },
            Options { reciprocity: Reciprocity::Steeper, ..Options::default() },
            Options { polarization: Some(Polarization::First), ..Options::default() },
            Options { polarization: Some(Polarization::Second), ..Options::default() },
        ] {
            assert_same(&material, options);
        }
        assert_same(&example(1), Options::default());
        assert_same(&FeatherMaterial { halo: Some(halo()), ..example(5) }, Options::default());
        assert_same(&FeatherMaterial { kind: FitKind::Cone, ..material }, Options::default());
    }

    #[test]
    fn the_page_says_what_the_program_does_with_two_polarizations_and_both_sides() {
        let mut material = example(3);
        let axes = material.axes.clone();
        // Both signs of φ_i, the left one's lobes narrower.
        material.axes = axes.clone().with_sides(Sides::Both);
        let both = material.axes.clone();
        let spread = |values: &[f32], sign: f32, factor: f32| -> Vec<f32> {
            (0..both.len())
                .map(|at| {
                    let (cell, phi) = (at / both.phis(), at % both.phis());
                    let value = values[cell * axes.phis() + both.cosine_of(phi)];
                    if phi < axes.phis() { value } else { sign * factor * value }
                })
                .collect()
        };
        let mut set = material.sets[0].clone();
        for lobe in &mut set.mean {
            lobe.m = spread(&lobe.m, 1.0, 0.6);
            lobe.phi = spread(&lobe.phi, -1.0, 1.0);
            lobe.reflected = spread(&lobe.reflected, 1.0, 0.8);
        }
        set.steady.m = spread(&set.steady.m, 1.0, 0.6);
        set.steady.phi = spread(&set.steady.phi, -1.0, 1.0);
        set.steady.share = spread(&set.steady.share, 1.0, 0.8);
        set.length = spread(&set.length, 1.0, 1.0);
        (set.fraction_1, set.fraction_1_slope) = (Vec::new(), Vec::new());
        material.correlation = spread(&material.correlation, 1.0, 1.0);
        material.steepness = vec![6.0; axes.cos_theta().len() * both.phis()];
        material.strength = (0..material.steepness.len()).map(|k| (k % 10) as f32 / 10.0).collect();
        material.achromatic_length = vec![1.3; material.steepness.len()];
        let mut second = set.clone();
        second.mean[1].reflected.iter_mut().for_each(|rho| *rho *= 0.5);
        material.sets = vec![set, second];
        for polarization in [None, Some(Polarization::First), Some(Polarization::Second)] {
            assert_same(&material, Options { polarization, ..Options::default() });
        }
        assert_same(&material, Options { reciprocity: Reciprocity::Steeper, ..Options::default() });
    }
}
