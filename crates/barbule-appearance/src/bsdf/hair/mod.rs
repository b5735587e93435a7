//! Hair: a round or elliptical, smooth-walled dielectric fibre with pigment inside and tilted scales outside. Also bare
//! barbs and down, and the rami and barbules of feathers without structural colour.
//!
//! f cosθ = Σ_p M_p(θ_i, θ_o) A_p N_p(φ): light leaves after p chords inside (R, TT, TRT, and all others together), with
//! the power A_p that Fresnel and absorption leave it, spread along the fibre by M and around it by N. The ray's own offset
//! from the axis decides A and N, so a fibre shows its width (Marschner et al. 2003; d'Eon et al. 2011; Chiang et al.
//! 2016; derivations in `docs/theory/hair.md`).
//!
//! A model of the whole fibre: light leaves towards every direction from the point where it came in, and goes on unhindered
//! by the fibre itself. Without absorption all of it leaves. Not reciprocal: the offset, and with it A and N, is the
//! viewer's.

mod absorption;
mod ellipse;
mod lanes;
mod section;
mod spread;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

pub use absorption::Absorption;

use self::ellipse::Ellipse;
use self::lanes::{Incidence, Middles, Powers, Spread, dispersed, dispersed_ellipse};
use self::section::{FOLLOWED, Round, WAYS};
use self::spread::{Azimuthal, Longitudinal};
use super::frame::Frame;
use super::hit::{Hit, Side};
use super::lobes::Lobes;
use super::reflectance::Reflectance;
use super::{Bsdf, Model};
use crate::material::Cauchy;
use crate::math::elementary::{atan2, sin_cos_turns};
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::{Error, Result};

/// Refractive index of a fibre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FibreIndex {
    /// The same at all wavelengths: 1.55 is human hair.
    Constant(f64),
    /// [Feather keratin](Cauchy::KERATIN). Each wavelength goes its own way, which takes longer.
    Keratin,
}

impl FibreIndex {
    /// At a wavelength, nm.
    fn at(self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Constant(index) => index,
            Self::Keratin => Cauchy::KERATIN.n(wavelength_nm),
        }
    }
}

/// What makes a fibre.
#[derive(Debug, Clone, PartialEq)]
pub struct HairParameters {
    /// β_m: how far lobes spread along the fibre, 0.02 … 1.
    pub longitudinal_roughness: f64,
    /// β_n: how far they spread around it, 0.02 … 1.
    pub azimuthal_roughness: f64,
    /// By how much the scales' free edges, which point to the tip, stand off the fibre, rad. 2° is human hair, 0 feathers.
    pub scale_tilt: f64,
    /// Refractive index.
    pub index: FibreIndex,
    /// What the inside absorbs over one half width.
    pub absorption: Absorption,
    /// Height of the section over its width, 0.1 … 10: 1 is round, under 1 flat, over 1 a blade. Heights stand along the
    /// vane's normal.
    pub height_over_width: f64,
}

/// Where a ray meets a fibre that is no primitive of its own: one of many on a surface.
#[derive(Debug, Clone, Copy)]
pub struct FibreSection {
    /// Unit vector along the fibre, from root to tip.
    pub axis: DVec3,
    /// Unit vector of the section's height, perpendicular to the axis.
    pub up: DVec3,
    /// Signed distance of the viewer's ray from the axis over half the width that is seen, −1 … 1; positive on the side of
    /// `wo` × `axis`.
    pub offset: f64,
    /// Factor to the absorption.
    pub pigment: f64,
}

impl FibreSection {
    /// With the ray's place across the fibre, −1 … 1 of the width that is seen from `wo`, positive along `axis` × `up`: the x
    /// of the frame with y along the fibre and z up.
    #[inline(always)]
    #[must_use]
    pub fn crossed(axis: DVec3, up: DVec3, across: f64, wo: DVec3) -> Self {
        Self { axis, up, offset: if wo.dot(up) >= 0.0 { -across } else { across }, pigment: 1.0 }
    }
}

/// A fibre's material. Its frame's y points from root to tip.
#[derive(Debug, Clone)]
pub struct Hair {
    index: FibreIndex,
    absorption: Absorption,
    azimuthal_roughness: f64,
    /// Of the section, over its width.
    height: f64,
    /// Of each way through the fibre.
    along: [Longitudinal; WAYS],
    around: Azimuthal,
    spread: Spread,
    /// Sine and cosine of what the scales add to the viewer's inclination, for each way.
    tilts: [[f64; 2]; WAYS],
}

/// Scales tilt the surface normal towards the root by α. By Snell's law of small angles R then leaves at the inclination
/// −θ_o − 2α, TT at −θ_o + 2(η − 1)α and TRT at −θ_o + (4η − 2)α; these are the factors for η = 1.5.
const TILTS: [f64; WAYS] = [2.0, -1.0, -4.0, 0.0];

impl Hair {
    /// Everything that does not depend on a hit.
    ///
    /// # Errors
    /// A parameter out of range.
    pub fn new(parameters: HairParameters) -> Result<Self> {
        let HairParameters {
            longitudinal_roughness: m,
            azimuthal_roughness: n,
            scale_tilt,
            index,
            absorption,
            height_over_width: height,
        } = parameters;
        let range = 0.02..=1.0;
        if !(range.contains(&m) && range.contains(&n)) {
            return Err(Error::input(format!(
                "hair of roughness {m} along and {n} around the fibre: give 0.02 to 1 for both"
            )));
        }
        if scale_tilt.is_nan() || scale_tilt.abs() > MOST_TILT {
            let degrees = scale_tilt.to_degrees();
            return Err(Error::input(format!(
                "hair with scales tilted by {degrees} degrees: give -20 to 20"
            )));
        }
        if let FibreIndex::Constant(index) = index
            && !(1.01..=3.9).contains(&index)
        {
            return Err(Error::input(format!("hair of index {index}: give 1.01 to 3.9")));
        }
        if !HEIGHTS.contains(&height) {
            return Err(Error::input(format!("hair of height over width {height}: give 0.1 to 10")));
        }
        // The fits of Chiang et al. 2016, §4.1, of both widths to what roughness looks like.
        let root = 0.726 * m + 0.812 * m * m + 3.7 * libm::pow(m, 20.0);
        let variance = root * root;
        let scale = SCALE * (0.265 * n + 1.194 * n * n + 5.372 * libm::pow(n, 22.0));
        let wide = Longitudinal::new(4.0 * variance);
        let along = [Longitudinal::new(variance), Longitudinal::new(0.25 * variance), wide, wide];
        let around = Azimuthal::new(scale);
        Ok(Self {
            index,
            absorption,
            azimuthal_roughness: n,
            height,
            along,
            around,
            spread: Spread::new(&along, &around),
            tilts: TILTS.map(|factor| [libm::sin(factor * scale_tilt), libm::cos(factor * scale_tilt)]),
        })
    }

    /// At a hit on a round curve, seen from `wo`. The offset follows from the normal: that of a round curve stands on its
    /// axis. A section that is not round fills the curve's width from wherever it is seen.
    #[inline(always)]
    pub(super) fn bind<'a>(&'a self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'a> {
        let side = hit.side(wo);
        let across = (side.wo.x * side.wo.x + side.wo.z * side.wo.z).sqrt();
        let offset = if across > 0.0 { (side.wo.x / across).clamp(-1.0, 1.0) } else { 0.0 };
        let up = if self.is_round() { DVec2::Y } else { in_section(&side.frame, hit.vane_normal) };
        Bsdf::new(Model::Hair(Bound::new(self, offset, up, side.wo, wavelengths)), side)
    }

    /// Where a ray meets a fibre that is no primitive of its own, seen from `wo`: one of many on a ribbon or a mesh. Light
    /// comes from everywhere, whichever way that surface faces; the shading normal points to the viewer, across the
    /// fibre.
    #[inline(never)]
    #[must_use]
    pub fn bind_section(&self, section: &FibreSection, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'_> {
        let FibreSection { axis, up, offset, pigment } = *section;
        let z = (wo - axis * axis.dot(wo)).normalize_or(up);
        let frame = Frame { x: axis.cross(z), y: axis, z };
        let side = Side { is_upper: true, normal: z, frame, wo: frame.to_local(wo) };
        let up = in_section(&frame, up);
        let bound = Bound::pigmented(self, offset.clamp(-1.0, 1.0), up, side.wo, wavelengths, pigment);
        Bsdf::new(Model::Hair(bound), side)
    }

    /// What a mass of such fibres reflects.
    ///
    /// # Errors
    /// None.
    pub fn mass_reflectance(&self) -> Result<Reflectance> {
        self.absorption.mass_reflectance(self.azimuthal_roughness)
    }

    /// Height of the section over its width.
    #[inline]
    #[must_use]
    pub fn height_over_width(&self) -> f64 {
        self.height
    }

    #[inline(always)]
    fn is_round(&self) -> bool {
        self.height == 1.0
    }
}

/// The unit vector across the fibre that is nearest to a direction of the scene, x and z in the fibre's frame; z where they
/// are parallel.
#[inline(always)]
fn in_section(frame: &Frame, direction: DVec3) -> DVec2 {
    DVec2::new(frame.x.dot(direction), frame.z.dot(direction)).normalize_or(DVec2::Y)
}

/// Of heights over widths.
const HEIGHTS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// 20°.
const MOST_TILT: f64 = 20_f64.to_radians();

/// √(π/8): a logistic distribution of this scale has at 0 the density of the normal one of deviation 1.
const SCALE: f64 = 0.626_657_068_657_750_1;

/// A fibre at the wavelengths of a path, one direction of the viewer and one offset.
pub(super) struct Bound<'a> {
    hair: &'a Hair,
    /// Unit vector towards the viewer in the section, x and z.
    viewer: [f64; 2],
    /// Sine and cosine of the viewer's inclination as each way sees it over the scales.
    inclinations: [[f64; 2]; WAYS],
    /// Where the followed ways leave.
    middles: Middles,
    powers: Powers,
}

impl<'a> Bound<'a> {
    /// - `offset`: signed distance of the viewer's ray from the axis over half the width that is seen, positive towards
    ///   growing azimuths (from x to z)
    /// - `up`: unit vector of the section's height, x and z; of no matter for a round one
    #[inline(always)]
    pub(super) fn new(hair: &'a Hair, offset: f64, up: DVec2, wo: DVec3, wavelengths: Lambdas) -> Self {
        Self::pigmented(hair, offset, up, wo, wavelengths, 1.0)
    }

    /// The same with a factor to the absorption.
    #[inline(always)]
    fn pigmented(
        hair: &'a Hair,
        offset: f64,
        up: DVec2,
        wo: DVec3,
        wavelengths: Lambdas,
        pigment: f64,
    ) -> Self {
        let sin = wo.y.clamp(-1.0, 1.0);
        let cos = (1.0 - sin * sin).sqrt();
        let across = (wo.x * wo.x + wo.z * wo.z).sqrt();
        let viewer = if across > 0.0 { [wo.x / across, wo.z / across] } else { [0.0, 1.0] };
        let depths = hair.absorption.at_each(wavelengths).map(|depth| depth * pigment);
        let (middles, powers) = if hair.is_round() {
            match hair.index {
                FibreIndex::Constant(index) => {
                    let section = Round::new(offset, [sin, cos], index);
                    (Middles::Same(section.azimuths), Powers::new(&section, &depths))
                }
                FibreIndex::Keratin => dispersed(offset, [sin, cos], &keratin(wavelengths), &depths),
            }
        } else {
            let viewer = DVec2::from_array(viewer);
            // Across stands to up as x to z.
            let toward = DVec2::new(viewer.perp_dot(up), viewer.dot(up));
            elliptical(hair, toward, offset, [sin, cos], wavelengths, &depths)
        };
        let mut inclinations = [[sin, cos]; WAYS];
        for (inclination, [sin_tilt, cos_tilt]) in inclinations.iter_mut().zip(&hair.tilts) {
            *inclination = [sin * cos_tilt + cos * sin_tilt, (cos * cos_tilt - sin * sin_tilt).abs()];
        }
        Self { hair, viewer, inclinations, middles, powers }
    }

    #[inline(always)]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::REFLECTION.and(Lobes::TRANSMISSION).and(Lobes::GLOSSY)
    }

    /// The density is the value times the cosine over the albedo, since every lobe is drawn in proportion to its power
    /// and exactly: samples all weigh the albedo.
    #[inline(always)]
    pub(super) fn eval(&self, _wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        let sin = wi.y.clamp(-1.0, 1.0);
        let cos = (1.0 - sin * sin).sqrt();
        let [x, z] = self.viewer;
        let azimuth = atan2(x * wi.z - z * wi.x, x * wi.x + z * wi.z);
        let light = Incidence { sin, cos, azimuth };
        let scattered = self.hair.spread.scattered(&self.powers, light, &self.inclinations, &self.middles);
        // The integrator multiplies by this cosine again.
        let inverse = 1.0 / wi.z.abs().max(LEAST_COSINE);
        let (mut f, mut pdf) = ([0.0; WAVES], [0.0; WAVES]);
        for k in 0..WAVES {
            f[k] = scattered[k] * inverse;
            pdf[k] = scattered[k] * self.powers.inverse_albedo[k];
        }
        (f, pdf)
    }

    #[inline(always)]
    pub(super) fn sample(&self, _wo: DVec3, [u, v, choice]: [f64; 3]) -> Option<(DVec3, Lobes)> {
        let mut rest = choice / self.powers.inverse_albedo[0];
        let mut way = 0;
        while way < FOLLOWED && rest >= self.powers.of[way][0] {
            rest -= self.powers.of[way][0];
            way += 1;
        }
        // What the choice leaves is uniform again.
        let again = (rest / self.powers.of[way][0].max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let sin = self.hair.along[way].sample(self.inclinations[way], u, again);
        let cos = (1.0 - sin * sin).sqrt();
        let azimuth =
            if way < FOLLOWED { self.middles.of_hero()[way] + self.hair.around.sample(v) } else { TAU * v };
        let [sin_azimuth, cos_azimuth] = sin_cos_turns(azimuth / TAU);
        let [x, z] = self.viewer;
        let wi = DVec3::new(
            cos * (x * cos_azimuth - z * sin_azimuth),
            sin,
            cos * (z * cos_azimuth + x * sin_azimuth),
        );
        let side = if wi.z > 0.0 { Lobes::REFLECTION } else { Lobes::TRANSMISSION };
        Some((wi, side.and(Lobes::GLOSSY)))
    }
}

/// Middles and powers of a fibre that is not round; arguments as of [`Ellipse::new`].
#[inline(never)] // out of the way of round fibres
fn elliptical(
    hair: &Hair,
    toward: DVec2,
    offset: f64,
    inclination: [f64; 2],
    wavelengths: Lambdas,
    depths: &[f64; WAVES],
) -> (Middles, Powers) {
    match hair.index {
        FibreIndex::Constant(index) => {
            let section = Ellipse::new(hair.height, toward, offset, inclination, index);
            (Middles::Same(section.azimuths), Powers::of_ellipse(&section, depths))
        }
        FibreIndex::Keratin => {
            let index = keratin(wavelengths);
            dispersed_ellipse(hair.height, toward, offset, inclination, &index, depths)
        }
    }
}

/// Refractive indices of feather keratin.
#[inline(always)]
fn keratin(wavelengths: Lambdas) -> [f64; WAVES] {
    wavelengths.map(|w| Cauchy::KERATIN.n(w))
}

/// Only a direction in the tangent plane itself is nearer.
const LEAST_COSINE: f64 = 1e-12;
