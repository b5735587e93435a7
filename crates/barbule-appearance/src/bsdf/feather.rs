//! A barbule's surface: its tabulated BRDF above, another one or dark keratin below, and keratin where its cells meet.

mod cells;

use std::sync::Arc;

use glam::DVec3;

pub use cells::{Arch, Cells};

use super::hit::Hit;
use super::keratin::{self, Keratin};
use super::lobes::Lobes;
use super::{Bsdf, Model};
use crate::brdf::{Draw, FeatherBrdf, PreparedBrdf};
use crate::spectrum::dense::{Lambdas, WAVES};

/// A barbule: a BRDF of its own above, and below too or keratin. What neither reflects is absorbed by the melanin inside.
#[derive(Debug, Clone)]
pub struct BarbuleSurface {
    /// Of the upper side.
    pub brdf: Arc<FeatherBrdf>,
    /// Whether every cell is a draw of its own (its glints), or all show the smooth mean.
    pub instances: bool,
    /// Of the lower side as lit from below, turned by 180° about the barbule's long axis; `None`: that is keratin.
    pub below: Option<Arc<FeatherBrdf>>,
    /// Of the lower side without a BRDF, and of the walls between cells on both.
    pub under: Keratin,
    /// How it differs from place to place.
    pub cells: Cells,
    /// Share of light that does not pass straight through, 0 … 1.
    pub opacity: f64,
}

impl BarbuleSurface {
    /// At a hit, seen from `wo`. The viewer's side is the incident one of the tabulated BRDF, which is not reciprocal:
    /// light paths are followed backwards.
    #[inline]
    pub(super) fn bind<'a>(&'a self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'a> {
        let side = hit.side(wo);
        // The frame of a lower side is the upper one turned about the barbule, as the section was when it was simulated from below.
        let brdf = if side.is_upper { Some(&self.brdf) } else { self.below.as_ref() };
        let model = match brdf {
            Some(brdf) if side.wo.z > 0.0 && !self.cells.is_wall(hit) => {
                let size = self.cells.size(hit);
                let prepared = brdf.prepare(wavelengths.nm().map(|w| (w / size) as f32), side.wo);
                let contrast = hit.ribbon.contrast;
                let seen = self.instances && contrast > LEAST_CONTRAST;
                let instance = seen.then(|| brdf.instance(hit.instance));
                // An arch is a trough from below: at −x it leans as the arch at x.
                let arch = self.cells.arch.map(|arch| arch.at(hit));
                Model::Feather(Bound { prepared, instance, contrast, arch })
            }
            _ => Model::Keratin(keratin::Bound { keratin: &self.under, wavelengths }),
        };
        Bsdf::new(model, side)
    }

    /// See [`super::Surface::opacity`]; the same everywhere.
    #[inline]
    pub(super) fn opacity(&self, _hit: &Hit, _wi: DVec3, _wo: DVec3) -> f64 {
        self.opacity
    }
}

/// Below this share of an instance's contrast nobody sees it in the noise of samples.
const LEAST_CONTRAST: f64 = 0.1;

/// A barbule's BRDF at the wavelengths of a path and one direction of the viewer.
pub(super) struct Bound<'a> {
    prepared: PreparedBrdf<'a, WAVES>,
    instance: Option<Draw>,
    /// Share of the instance's departure from the mean that is seen.
    contrast: f64,
    arch: Option<cells::OnArch>,
}

impl Bound<'_> {
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::REFLECTION.and(Lobes::GLOSSY)
    }

    #[inline]
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        let mut f = self.prepared.eval(wi, self.instance.as_ref()).map(f64::from);
        // Off the cone there is neither light nor a sample.
        let pdf = if f == [0.0; WAVES] { [0.0; WAVES] } else { self.prepared.pdfs(wi) };
        if self.instance.is_some() && self.contrast < 1.0 {
            let mean = self.prepared.eval(wi, None);
            for (f, mean) in f.iter_mut().zip(mean) {
                *f = f64::from(mean) + self.contrast * (*f - f64::from(mean));
            }
        }
        if let Some(arch) = &self.arch {
            let share = arch.share(wo, wi);
            f = f.map(|f| f * share);
        }
        (f, pdf)
    }

    #[inline]
    pub(super) fn sample(&self, _wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        Some((self.prepared.direction(0, [u[0], u[1]])?, self.lobes()))
    }
}
