//! How far another model of a material is from the material.

use rayon::prelude::*;

use crate::brdf::FeatherBrdf;
use crate::math::rng::Stream;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::{Illuminant, Observer, Weights, xyz_from_rgb};
use crate::spectrum::difference::{delta_e_2000, lab};
use crate::{DVec3, Result};

/// Wavelengths at which both are compared: 403, 422.5 … 695.5 nm, on which no table has its nodes.
const WAVES: usize = 16;
const FIRST_NM: f64 = 403.0;
const STEP_NM: f64 = 19.5;

/// Directions of the viewer: so many, up to this angle from the normal, each with so many directions of light.
const VIEWS: usize = 512;
pub(super) const MOST_POLAR_DEG: f64 = 70.0;
const LIGHTS: usize = 64;

/// Colours are compared of views at these angles from the normal, seen along the barbule, across it and between, each with so many
/// directions of light.
const POLARS_DEG: [f64; 4] = [0.0, 20.0, 40.0, 60.0];
const AZIMUTHS_DEG: [f64; 3] = [0.0, 45.0, 90.0];
const COLOUR_LIGHTS: usize = 2048;

/// Share of directions of light that are drawn evenly over the projected hemisphere, for what another model has where the material has
/// nothing.
pub(super) const EVEN: f64 = 0.2;

/// How far another model is from a material: of f cosθ_o of the mean over its barbules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// ∫|f' − f| cosθ_o over ∫f cosθ_o: over the directions of light, 403 to 695 nm (or R, G, B), and views up to 70° from the normal,
    /// all directions of projected area alike.
    pub relative_l1: f64,
    /// The same without the modulus: the share of light that is too much.
    pub bias: f64,
    /// ΔE00 of the colours of all light that is reflected towards a view, in D65, a perfect white being 100: the mean over views 0°, 20°,
    /// 40°, 60° from the normal, along the barbule, across it, and between.
    pub delta_e: f64,
}

/// Values at wavelengths in nm, for the viewer's direction and the light's.
pub type SpectralModel<'a> = dyn Fn(&[f64], DVec3, DVec3) -> Vec<f64> + Sync + 'a;

/// A model of another program: f cosθ_o in 1/sr, for the viewer's direction, which is ω_i of the material, and the light's. Both are in the
/// barbule's frame, above the horizon.
pub enum Model<'a> {
    /// At each of these wavelengths, nm.
    Spectral(&'a SpectralModel<'a>),
    /// Linear sRGB in D65, of which a perfect white has (1, 1, 1) cosθ_o/π.
    Rgb(&'a (dyn Fn(DVec3, DVec3) -> [f64; 3] + Sync)),
}

impl Deviation {
    /// Measures a model against the smooth mean of a material by some 60,000 pairs of directions, the same each time.
    ///
    /// # Errors
    /// None with the wavelengths that are compared.
    pub fn of(model: &Model<'_>, brdf: &FeatherBrdf) -> Result<Self> {
        let compare = Comparison::new(brdf)?;
        let [off, more, all] = compare.over_views(model);
        let delta_e = compare.of_colours(model);
        Ok(Self { relative_l1: off / all, bias: more / all, delta_e })
    }

    /// The relative L1 alone, in half the time.
    pub(super) fn relative_l1_of(model: &Model<'_>, brdf: &FeatherBrdf) -> Result<f64> {
        let [off, _, all] = Comparison::new(brdf)?.over_views(model);
        Ok(off / all)
    }
}

/// The material at the wavelengths of comparison.
struct Comparison<'a> {
    brdf: &'a FeatherBrdf,
    nm: [f64; WAVES],
    weights: Weights,
    white: [f64; 3],
}

impl<'a> Comparison<'a> {
    fn new(brdf: &'a FeatherBrdf) -> Result<Self> {
        let nm = std::array::from_fn(|k| FIRST_NM + STEP_NM * k as f64);
        let weights = Observer::under(Illuminant::D65).weights(&Wavelengths::new(nm)?);
        Ok(Self { brdf, nm, white: weights.xyz(&[1.0; WAVES]), weights })
    }

    /// Sums of |f' − f|, f' − f and f with the cosine over all views.
    fn over_views(&self, model: &Model<'_>) -> [f64; 3] {
        let views: Vec<[f64; 3]> = (0..VIEWS)
            .into_par_iter()
            .map(|view| {
                let mut random = Stream::new(1, &[view as u64]);
                let most = libm::sin(MOST_POLAR_DEG.to_radians());
                let radius = most * ((view as f64 + random.unit()) / VIEWS as f64).sqrt();
                let turn = std::f64::consts::TAU * random.unit();
                let at = DVec3::new(radius * libm::cos(turn), radius * libm::sin(turn), 0.0);
                let view = DVec3 { z: (1.0 - radius * radius).sqrt(), ..at };
                self.sums(model, view, LIGHTS, &mut random).0
            })
            .collect();
        sum(&views)
    }

    /// The mean ΔE00 of all light that is reflected towards some views.
    fn of_colours(&self, model: &Model<'_>) -> f64 {
        let colours: Vec<f64> = (0..POLARS_DEG.len() * AZIMUTHS_DEG.len())
            .into_par_iter()
            .map(|at| {
                let polar = POLARS_DEG[at / AZIMUTHS_DEG.len()].to_radians();
                let azimuth = AZIMUTHS_DEG[at % AZIMUTHS_DEG.len()].to_radians();
                let (sine, cosine) = (libm::sin(polar), libm::cos(polar));
                // Along the barbule is y.
                let view = DVec3::new(sine * libm::sin(azimuth), sine * libm::cos(azimuth), cosine);
                let mut random = Stream::new(2, &[at as u64]);
                let [own, other] = self.sums(model, view, COLOUR_LIGHTS, &mut random).1;
                delta_e_2000(own, other)
            })
            .collect();
        colours.iter().sum::<f64>() / colours.len() as f64
    }

    /// Of one view: sums of |f' − f|, f' − f and f with the cosine over random lights, and both colours in CIELAB.
    fn sums(
        &self,
        model: &Model<'_>,
        view: DVec3,
        lights: usize,
        random: &mut Stream,
    ) -> ([f64; 3], [[f64; 3]; 2]) {
        let prepared = self.brdf.prepare(self.nm.map(|nm| nm as f32), view);
        let (mut sums, mut own_xyz, mut other_xyz) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for light in 0..lights {
            let u = [random.unit(), random.unit()];
            let drawn =
                if random.unit() < EVEN { Some(even(u)) } else { prepared.direction(light % WAVES, u) };
            let Some(wo) = drawn.filter(|wo| wo.z > 1e-3) else { continue };
            let mean = prepared.pdfs(wo).iter().sum::<f64>() / WAVES as f64;
            let density = (1.0 - EVEN) * mean + EVEN * wo.z / std::f64::consts::PI;
            let own = prepared.eval(wo, None).map(|f| f64::from(f) * wo.z);
            let add = |to: &mut [f64; 3], xyz: [f64; 3]| {
                to.iter_mut().zip(xyz).for_each(|(sum, v)| *sum += v / density);
            };
            add(&mut own_xyz, self.weights.xyz(&own));
            let mut count = |own: &[f64], other: &[f64]| {
                for (own, other) in own.iter().zip(other) {
                    let one = [(other - own).abs(), other - own, *own];
                    sums.iter_mut().zip(one).for_each(|(sum, v)| *sum += v / density);
                }
            };
            match model {
                Model::Spectral(values) => {
                    let other = values(&self.nm, view, wo);
                    count(&own, &other);
                    add(&mut other_xyz, self.weights.xyz(&other));
                }
                Model::Rgb(values) => {
                    let other = values(view, wo);
                    count(&self.weights.linear_rgb(&own), &other);
                    add(&mut other_xyz, xyz_from_rgb(other));
                }
            }
        }
        let seen = |xyz: [f64; 3]| lab(xyz.map(|v| v / lights as f64), self.white);
        (sums, [seen(own_xyz), seen(other_xyz)])
    }
}

/// A direction of the projected hemisphere, all alike.
fn even([u, v]: [f64; 2]) -> DVec3 {
    let (radius, turn) = (u.sqrt(), std::f64::consts::TAU * v);
    DVec3::new(radius * libm::cos(turn), radius * libm::sin(turn), (1.0 - u).max(0.0).sqrt())
}

fn sum(views: &[[f64; 3]]) -> [f64; 3] {
    views.iter().fold([0.0; 3], |sum, view| std::array::from_fn(|k| sum[k] + view[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Options;
    use crate::characterize::Catalog;
    use crate::structure::Structure;

    fn starling() -> FeatherBrdf {
        let found = Catalog::default().shipped(&Structure::builtin("starling").unwrap()).unwrap().unwrap();
        FeatherBrdf::new(&found.material, Options::default()).unwrap()
    }

    /// The material itself is not off; a tenth too much of it is a tenth too much, and a colour as far off as a tenth of its light.
    #[test]
    fn deviations_are_those_of_what_was_planted() {
        let brdf = starling();
        let times = |factor: f64| {
            let values = |nm: &[f64], wi: DVec3, wo: DVec3| {
                let of = |nm: &f64| f64::from(brdf.eval([*nm as f32; 4], wi, wo, None)[0]) * wo.z * factor;
                nm.iter().map(of).collect::<Vec<f64>>()
            };
            Deviation::of(&Model::Spectral(&values), &brdf).unwrap()
        };
        let same = times(1.0);
        assert!(same.relative_l1 < 1e-6 && same.bias.abs() < 1e-6 && same.delta_e < 1e-4, "{same:?}");
        let more = times(1.1);
        assert!((more.relative_l1 - 0.1).abs() < 1e-6 && (more.bias - 0.1).abs() < 1e-6, "{more:?}");
        assert!(more.delta_e > 0.2 && more.delta_e < 3.0, "{more:?}");
    }

    /// Light where the material has none counts, and colours of a model in R, G, B are compared in R, G, B.
    #[test]
    fn a_grey_surface_is_no_feather() {
        let brdf = starling();
        let grey = |_: DVec3, wo: DVec3| [0.2 * wo.z / std::f64::consts::PI; 3];
        let found = Deviation::of(&Model::Rgb(&grey), &brdf).unwrap();
        assert!(found.relative_l1 > 0.8 && found.delta_e > 5.0, "{found:?}");
        let colours = |wi: DVec3, wo: DVec3| {
            let compare = Comparison::new(&brdf).unwrap();
            let own = brdf.eval(compare.nm.map(|nm| nm as f32), wi, wo, None);
            compare.weights.linear_rgb(&own.map(|f| f64::from(f) * wo.z))
        };
        let found = Deviation::of(&Model::Rgb(&colours), &brdf).unwrap();
        assert!(found.relative_l1 < 1e-6 && found.delta_e < 0.1, "{found:?}");
    }
}
