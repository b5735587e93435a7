//! Which facets are most like a material.

use rayon::prelude::*;

use super::facets::{Distribution, Facets};
use crate::brdf::FeatherBrdf;
use crate::export::deviation::{EVEN, MOST_POLAR_DEG};
use crate::math::rng::Stream;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::Observer;
use crate::{DVec3, Result};

/// Two kinds of facets on the same surface, by their shares.
///
/// Their roughness grows as the eye's azimuth φ does, with powers of 1/cosφ: a barbule spreads light along itself by the same angle
/// whatever φ is, and normals of mirrors must lean the more for that the more light slants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobes {
    /// Those of most light, then the others, as an eye at φ = 0 has them.
    pub facets: [Facets; 2],
    /// Share of the second, at most ½.
    pub share: f64,
    /// The powers of α along and across.
    pub growth: [f64; 2],
}

impl Lobes {
    /// The facets that an eye in this direction has.
    fn towards(&self, wi: DVec3) -> [Facets; 2] {
        let slant = (wi.x.hypot(wi.z) / wi.z.max(1e-6)).min(MOST_SLANT);
        let [along, across] = self.growth.map(|power| libm::pow(slant, power));
        self.facets.map(|facets| Facets {
            along: (facets.along * along).min(ALPHAS[1]),
            across: (facets.across * across).min(ALPHAS[1]),
            ..facets
        })
    }

    /// f cosθ_o in 1/sr of both.
    pub(super) fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        let [first, second] = self.towards(wi).map(|facets| facets.value(wi, wo));
        first + self.share * (second - first)
    }

    /// ∫ f cosθ_o dω_o of both, by so many steps of two numbers.
    pub(super) fn albedo(&self, wi: DVec3, steps: usize) -> f64 {
        let [first, second] = self.towards(wi).map(|facets| facets.albedo(wi, steps));
        first + self.share * (second - first)
    }
}

/// 1/cosφ grows no further than here, at 78°.
pub(super) const MOST_SLANT: f64 = 5.0;

/// Views up to [`MOST_POLAR_DEG`] from the normal, and of each so many directions of light.
const VIEWS: usize = 48;
const LIGHTS: usize = 48;

/// Wavelengths that a brightness is made of: 400, 420 … 700 nm.
pub(super) const WAVES: usize = 16;

pub(super) fn waves() -> [f64; WAVES] {
    std::array::from_fn(|k| 400.0 + 20.0 * k as f64)
}

/// α of facets, the share of the second ones, and the powers of growth.
pub(super) const ALPHAS: [f64; 2] = [0.01, 1.0];
const MOST_SHARE: f64 = 0.95;
const POWERS: [f64; 2] = [-1.0, 2.0];

/// Steps of the facets' albedos while they are searched.
const ALBEDO_STEPS: usize = 10;

/// Steps of the search: of the logarithm of an α and of the share, from the first to the last.
const FIRST_STEP: f64 = 0.4;
const LAST_STEP: f64 = 0.01;

/// A view, what it sees of all light in brightness, and random lights: direction, brightness of f cosθ_o, one over the density.
struct View {
    wi: DVec3,
    albedo: f64,
    lights: Vec<(DVec3, f64, f64)>,
}

/// The facets whose ∫|f' − f| cosθ_o in brightness is least, where each view sees as much light as of the material.
///
/// # Errors
/// None with the wavelengths that are taken.
pub(super) fn fitted(brdf: &FeatherBrdf) -> Result<Lobes> {
    let views = views(brdf)?;
    use Distribution::{Beckmann, Ggx};
    let kinds = [[Beckmann, Beckmann], [Beckmann, Ggx], [Ggx, Ggx]];
    let tried: Vec<(Lobes, f64)> = kinds
        .into_par_iter()
        .flat_map_iter(|kinds| STARTS.iter().map(move |start| (kinds, start)))
        .map(|(kinds, start)| searched(&views, kinds, start))
        .collect();
    let best = tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let mut lobes = best.map_or_else(|| lobes(kinds[0], &STARTS[0]), |(lobes, _)| lobes);
    if lobes.share > 0.5 {
        lobes.facets.reverse();
        lobes.share = 1.0 - lobes.share;
    }
    Ok(lobes)
}

/// Logarithms of α along and across of both facets, the share, and the powers of growth.
type Numbers = [f64; 7];

/// Where searches begin. The second facets are longer across, or a halo.
const STARTS: [Numbers; 2] =
    [[-3.2, -2.0, -3.2, -1.2, 0.3, 1.0, 0.0], [-3.2, -1.8, -1.6, -1.6, 0.2, 1.0, 0.0]];

fn lobes(kinds: [Distribution; 2], at: &Numbers) -> Lobes {
    let alpha = |log: f64| libm::exp(log).clamp(ALPHAS[0], ALPHAS[1]);
    let facets = std::array::from_fn(|k| Facets {
        distribution: kinds[k],
        along: alpha(at[2 * k]),
        across: alpha(at[2 * k + 1]),
    });
    let growth = [at[5], at[6]].map(|power| power.clamp(POWERS[0], POWERS[1]));
    Lobes { facets, share: at[4].clamp(0.0, MOST_SHARE), growth }
}

/// A search along each number in turn, whose steps are halved where none helps.
fn searched(views: &[View], kinds: [Distribution; 2], start: &Numbers) -> (Lobes, f64) {
    let cost = |at: &Numbers| cost(views, &lobes(kinds, at));
    let mut at = *start;
    let (mut least, mut step) = (cost(&at), FIRST_STEP);
    while step > LAST_STEP {
        let before = least;
        for number in 0..at.len() {
            for sign in [1.0, -1.0] {
                let mut tried = at;
                tried[number] += sign * step;
                let found = cost(&tried);
                if found < least {
                    (at, least) = (tried, found);
                    break;
                }
            }
        }
        if least >= before {
            step *= 0.5;
        }
    }
    (lobes(kinds, &at), least)
}

fn cost(views: &[View], lobes: &Lobes) -> f64 {
    let of = |view: &View| {
        let scale = view.albedo / lobes.albedo(view.wi, ALBEDO_STEPS);
        let off = |(wo, f, over): &(DVec3, f64, f64)| over * (scale * lobes.value(view.wi, *wo) - f).abs();
        view.lights.iter().map(off).sum::<f64>()
    };
    views.iter().map(of).sum()
}

fn views(brdf: &FeatherBrdf) -> Result<Vec<View>> {
    let nm = waves();
    let weights = Observer::default().weights(&Wavelengths::new(nm)?);
    let mut random = Stream::new(3, &[]);
    let most = libm::sin(MOST_POLAR_DEG.to_radians());
    let view = |k: usize| {
        let radius = most * ((k as f64 + random.unit()) / VIEWS as f64).sqrt();
        let turn = std::f64::consts::TAU * random.unit();
        let wi =
            DVec3::new(radius * libm::cos(turn), radius * libm::sin(turn), (1.0 - radius * radius).sqrt());
        let prepared = brdf.prepare(nm.map(|nm| nm as f32), wi);
        let mut lights = Vec::with_capacity(LIGHTS);
        for light in 0..LIGHTS {
            let u = [random.unit(), random.unit()];
            let drawn = if random.unit() < EVEN {
                let (radius, turn) = (u[0].sqrt(), std::f64::consts::TAU * u[1]);
                Some(DVec3::new(radius * libm::cos(turn), radius * libm::sin(turn), (1.0 - u[0]).sqrt()))
            } else {
                prepared.direction(light % WAVES, u)
            };
            let Some(wo) = drawn.filter(|wo| wo.z > 1e-3) else { continue };
            let mean = prepared.pdfs(wo).iter().sum::<f64>() / WAVES as f64;
            let density = (1.0 - EVEN) * mean + EVEN * wo.z / std::f64::consts::PI;
            let f = weights.xyz(&prepared.eval(wo, None).map(|f| f64::from(f) * wo.z))[1];
            lights.push((wo, f, 1.0 / density));
        }
        let albedo = weights.xyz(&nm.map(|nm| brdf.albedo(nm as f32, wi)))[1];
        View { wi, albedo, lights }
    };
    Ok((0..VIEWS).map(view).collect())
}
