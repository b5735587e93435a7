//! What surfaces are made of and how they scatter light.
//!
//! A [`Surface`] is data. Bound to a [`Hit`], a direction of the viewer and the wavelengths of a path it is a [`Bsdf`],
//! which is evaluated and sampled. A model is one file: its parameters with `bind`, and its bound form with `lobes`,
//! `eval` and `sample` in the frame of the side that is seen. Light may leave on both sides.
//!
//! Directions are unit vectors that point away from the surface: `wo` towards the viewer, `wi` towards the light. Values
//! are in 1/sr without the cosine.

mod barb;
mod clad;
mod conductor;
mod dielectric;
mod feather;
mod frame;
mod grating;
mod hair;
mod hit;
mod keratin;
mod lambertian;
mod lobes;
mod map;
pub mod measured;
mod microfacet;
mod palette;
mod phase_film;
mod reflectance;
mod relief;
mod rough_dielectric;
#[cfg(test)]
mod tests;
mod texture;
mod thin_film;

use glam::DVec3;

pub use barb::{
    BarbModel, BarbSurface, Dress, FlatVane, Mark, Markings, Pattern, RAMUS_DEPTH, RAMUS_ROOT, Ramus, Region,
    Ring, Row, RowDisorder, STATIONS, StraightBarb, Substance, ZoneDress, ZonePlan, Zones, axes, ramus_taper,
};
pub use clad::{Clad, Layout};
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use feather::{Arch, BarbuleSurface, Cells};
pub use frame::Frame;
pub use grating::{Grating, GratingTables};
pub use hair::{Absorption, FibreIndex, FibreSection, Hair, HairParameters};
pub use hit::{Hit, OnRibbon, Side};
pub use keratin::Keratin;
pub use lambertian::{Lambertian, Pictures};
pub use lobes::Lobes;
pub use map::SurfaceMap;
pub use measured::{Measured, MeasuredTables};
pub use microfacet::FacetRoughness;
pub use palette::Palette;
pub use phase_film::{PhaseFilm, blueness};
pub use reflectance::Reflectance;
pub use relief::Relief;
pub use rough_dielectric::RoughDielectric;
pub use texture::{NumberMap, Texture};
pub use thin_film::ThinFilm;

use crate::spectrum::dense::{Lambdas, WAVES};
use crate::spectrum::sensor::Band;

/// What a surface is made of.
#[derive(Debug, Clone)]
pub enum Surface {
    /// Perfectly diffuse.
    Lambertian(Lambertian),
    /// Pigmented keratin, the same on both sides: shafts, rami.
    Keratin(Keratin),
    /// A barbule's plate.
    Barbule(BarbuleSurface),
    /// A surface clad in barbules.
    Clad(Box<Clad>),
    /// A barb with the barbules that its ribbon stands for.
    Barb(Box<BarbSurface>),
    /// A fibre of hair, round or elliptical.
    Hair(Hair),
    /// Rough metal.
    Conductor(Conductor),
    /// A smooth boundary of a clear medium.
    Dielectric(Dielectric),
    /// A rough one.
    RoughDielectric(RoughDielectric),
    /// Layers over a rough base.
    ThinFilm(ThinFilm),
    /// A diffraction grating over pigment.
    Grating(Grating),
    /// Tables of measured light.
    Measured(Measured),
    /// Others, chosen from place to place.
    Map(SurfaceMap),
}

impl Surface {
    /// Its scattering function at a hit, for a viewer in the direction `wo`.
    #[inline(always)]
    #[must_use]
    pub fn bind(&self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'_> {
        match self {
            Self::Lambertian(surface) => surface.bind(hit, wo, wavelengths),
            Self::Keratin(surface) => surface.bind(hit, wo, wavelengths),
            Self::Barbule(surface) => surface.bind(hit, wo, wavelengths),
            Self::Clad(clad) => clad.bind(hit, wo, wavelengths),
            Self::Barb(barb) => barb.bind(hit, wo, wavelengths),
            Self::Hair(surface) => surface.bind(hit, wo, wavelengths),
            Self::Conductor(surface) => surface.bind(hit, wo, wavelengths),
            Self::Dielectric(surface) => surface.bind(hit, wo),
            Self::RoughDielectric(surface) => surface.bind(hit, wo),
            Self::ThinFilm(surface) => surface.bind(hit, wo, wavelengths),
            Self::Grating(surface) => surface.bind(hit, wo, wavelengths),
            Self::Measured(surface) => surface.bind(hit, wo, wavelengths),
            Self::Map(map) => map.at(hit.uv).bind_apart(hit, wo, wavelengths),
        }
    }

    /// As [`Surface::bind`], for the surfaces of a map.
    #[inline(never)] // a copy of its own ends the recursion
    fn bind_apart(&self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'_> {
        self.bind(hit, wo, wavelengths)
    }

    /// The band of the tables of gratings and films, beyond which they have no values; nothing of all others.
    #[must_use]
    pub fn tabulated(&self) -> Option<Band> {
        match self {
            Self::Grating(_) => Some(Grating::BAND),
            Self::ThinFilm(_) => Some(ThinFilm::BAND),
            Self::Map(map) => map.surfaces().iter().find_map(Self::tabulated),
            _ => None,
        }
    }

    /// Share of the light along a straight line that does not pass a hit unchanged, 0 … 1. `wo` points back along the
    /// ray and `wi` onwards.
    #[must_use]
    pub fn opacity(&self, hit: &Hit, wi: DVec3, wo: DVec3) -> f64 {
        match self {
            Self::Barbule(surface) => surface.opacity(hit, wi, wo),
            Self::Clad(clad) => clad.barbule().opacity(hit, wi, wo),
            Self::Barb(barb) => barb.opacity(hit, wo),
            Self::Lambertian(surface) => surface.opacity(hit),
            Self::Map(map) => map.at(hit.uv).opacity(hit, wi, wo),
            Self::Keratin(_)
            | Self::Hair(_)
            | Self::Conductor(_)
            | Self::Dielectric(_)
            | Self::RoughDielectric(_)
            | Self::ThinFilm(_)
            | Self::Grating(_)
            | Self::Measured(_) => 1.0,
        }
    }

    /// Whether the opacity is 1 everywhere, so that nobody need ask.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        match self {
            Self::Barbule(surface) => surface.opacity >= 1.0,
            Self::Clad(clad) => clad.barbule().opacity >= 1.0,
            Self::Barb(_) => false,
            Self::Lambertian(surface) => surface.is_opaque(),
            Self::Map(map) => map.surfaces().iter().all(Self::is_opaque),
            Self::Keratin(_)
            | Self::Hair(_)
            | Self::Conductor(_)
            | Self::Dielectric(_)
            | Self::RoughDielectric(_)
            | Self::ThinFilm(_)
            | Self::Grating(_)
            | Self::Measured(_) => true,
        }
    }
}

/// The scattering function of one hit seen from one direction at the wavelengths of a path.
pub struct Bsdf<'a> {
    model: Model<'a>,
    side: Side,
    /// The barbules beside it that keep light from it.
    shade: Option<barb::Shade>,
}

/// A model bound to wavelengths. A surface may bind to different ones: a barbule's underside is keratin.
#[allow(clippy::large_enum_variant)] // lives on the stack for one hit; a box would be an allocation a hit
enum Model<'a> {
    Lambertian(lambertian::Bound),
    Keratin(keratin::Bound<'a>),
    Feather(feather::Bound<'a>),
    Hair(hair::Bound<'a>),
    Conductor(conductor::Bound),
    Dielectric(dielectric::Bound),
    RoughDielectric(rough_dielectric::Bound),
    ThinFilm(thin_film::Bound<'a>),
    Grating(grating::Bound<'a>),
    Measured(measured::Bound<'a>),
}

/// Calls a function that all models have.
macro_rules! of_model {
    ($model:expr, $function:ident($($argument:expr),*)) => {
        match $model {
            Model::Lambertian(model) => model.$function($($argument),*),
            Model::Keratin(model) => model.$function($($argument),*),
            Model::Feather(model) => model.$function($($argument),*),
            Model::Hair(model) => model.$function($($argument),*),
            Model::Conductor(model) => model.$function($($argument),*),
            Model::Dielectric(model) => model.$function($($argument),*),
            Model::RoughDielectric(model) => model.$function($($argument),*),
            Model::ThinFilm(model) => model.$function($($argument),*),
            Model::Grating(model) => model.$function($($argument),*),
            Model::Measured(model) => model.$function($($argument),*),
        }
    };
}

/// Value and densities for one direction.
#[derive(Debug, Clone, Copy)]
pub struct Evaluation {
    /// 1/sr, at each wavelength.
    pub f: [f64; WAVES],
    /// Density of the direction if that wavelength were the hero, 1/sr.
    pub pdf: [f64; WAVES],
    /// Modulus of the cosine between the direction and the shading normal.
    pub cosine: f64,
}

const NOTHING: Evaluation = Evaluation { f: [0.0; WAVES], pdf: [0.0; WAVES], cosine: 0.0 };

/// A direction drawn from a BSDF.
#[derive(Debug, Clone, Copy)]
pub struct BsdfSample {
    /// Unit vector in the scene.
    pub wi: DVec3,
    /// The BSDF there; its density is over 0 at the hero.
    pub evaluation: Evaluation,
    /// From which kind of lobe it was drawn.
    pub lobes: Lobes,
}

impl<'a> Bsdf<'a> {
    #[inline]
    fn new(model: Model<'a>, side: Side) -> Self {
        Self { model, side, shade: None }
    }

    /// The same among neighbours that keep light from it.
    #[inline]
    fn shaded(self, shade: barb::Shade) -> Self {
        Self { shade: Some(shade), ..self }
    }

    /// The shading normal on the viewer's side.
    #[inline]
    #[must_use]
    pub fn shading_normal(&self) -> DVec3 {
        self.side.frame.z
    }

    /// The kinds of scattering that it has.
    #[must_use]
    pub fn lobes(&self) -> Lobes {
        of_model!(&self.model, lobes())
    }

    /// Scattering of light from `wi` to the viewer; nothing where the face and the shading normal disagree on the side.
    #[inline(always)]
    #[must_use]
    pub fn eval(&self, wi: DVec3) -> Evaluation {
        let local = self.side.frame.to_local(wi);
        let face = wi.dot(self.side.normal);
        let reflected = face > 0.0 && local.z > 0.0;
        let scatters = reflected || (face < 0.0 && local.z < 0.0 && self.lobes().has(Lobes::TRANSMISSION));
        if !scatters || self.side.wo.z <= 0.0 || self.shade.as_ref().is_some_and(|shade| shade.hides(wi)) {
            return NOTHING;
        }
        let (f, pdf) = of_model!(&self.model, eval(self.side.wo, local));
        Evaluation { f, pdf, cosine: local.z.abs() }
    }

    /// Density of [`Bsdf::sample`] per sr if each wavelength were the hero.
    #[must_use]
    pub fn pdf(&self, wi: DVec3) -> [f64; WAVES] {
        self.eval(wi).pdf
    }

    /// Draws a direction at the hero wavelength from three uniform numbers; `None` where nothing is scattered.
    #[inline(always)]
    #[must_use]
    pub fn sample(&self, u: [f64; 3]) -> Option<BsdfSample> {
        if let Model::Dielectric(model) = &self.model {
            return model.sample_in_scene(&self.side, u);
        }
        let (local, lobes) = of_model!(&self.model, sample(self.side.wo, u))?;
        let wi = self.side.frame.to_world(local).normalize();
        let evaluation = self.eval(wi);
        (evaluation.pdf[0] > 0.0).then_some(BsdfSample { wi, evaluation, lobes })
    }
}
