//! Measured materials: tables of reflected light over directions, from files of the RGL and MERL databases, and such as are made here.

mod merl;
mod rgl;
mod tabulate;
#[cfg(test)]
pub(super) mod tests;
mod warp;

use std::sync::{Arc, LazyLock};

use glam::DVec3;

pub use merl::{MERL_SIZE, Merl};
pub use rgl::{Channels, Grid, Incident, Rgl, RglArrays, jacobian, normal_of};
pub use tabulate::{Resolution, tabulate};
pub use warp::{Nodes, Warp};

use super::hit::Hit;
use super::lobes::Lobes;
use super::{Bsdf, Model};
use crate::spectrum::dense::{DenseSpectrum, Lambdas, WAVES};
use crate::spectrum::primaries::shares;

/// What spectra R, G and B stand for.
static SHARES: LazyLock<[DenseSpectrum; 3]> = LazyLock::new(shares);

/// Tables of a measured material.
#[derive(Debug, Clone)]
pub enum MeasuredTables {
    /// Spectral or of R, G and B, isotropic or not.
    Rgl(Box<Rgl>),
    /// Of R, G and B, isotropic.
    Merl(Box<Merl>),
}

impl MeasuredTables {
    /// Memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::Rgl(rgl) => rgl.bytes(),
            Self::Merl(_) => 4 * 3 * MERL_SIZE.iter().product::<usize>(),
        }
    }
}

/// A surface of a measured material, the same on both sides. The file's x lies where texture coordinates' u grows, on
/// fibres along them; its z along the normal.
/// Tables are indexed by the viewer's direction. Between wavelengths values are linear, and outside those of the ends; R, G and B stand for
/// the spectra of [`shares`].
#[derive(Debug, Clone)]
pub struct Measured(Arc<MeasuredTables>);

impl Measured {
    /// A surface of these tables.
    #[must_use]
    pub fn new(tables: Arc<MeasuredTables>) -> Self {
        Self(tables)
    }

    /// At a hit, seen from `wo`.
    #[inline]
    pub(super) fn bind(&self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'_> {
        let side = Hit { frame: hit.texture_frame().0, ..*hit }.side(wo);
        let seen = match &*self.0 {
            MeasuredTables::Rgl(rgl) => Seen::Rgl(rgl, rgl.incident(of_file(side.wo))),
            MeasuredTables::Merl(merl) => Seen::Merl(merl),
        };
        let shares = SHARES.each_ref().map(|share| share.at_each(wavelengths));
        Bsdf::new(Model::Measured(Bound { seen, nm: wavelengths.nm(), shares }), side)
    }
}

/// From the frame of barbules (y along them) to the file's, whose x is along them.
#[inline]
#[must_use]
pub fn of_file(w: DVec3) -> DVec3 {
    DVec3::new(w.y, -w.x, w.z)
}

/// From the file's frame to that of barbules.
#[inline]
#[must_use]
pub fn of_barbule(w: DVec3) -> DVec3 {
    DVec3::new(-w.y, w.x, w.z)
}

/// Tables as one viewer sees them.
enum Seen<'a> {
    Rgl(&'a Rgl, Incident),
    Merl(&'a Merl),
}

/// A measured material at the wavelengths of a path.
pub(super) struct Bound<'a> {
    seen: Seen<'a>,
    nm: [f64; WAVES],
    /// Red, green and blue of each wavelength.
    shares: [[f64; WAVES]; 3],
}

impl Bound<'_> {
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::REFLECTION.and(Lobes::GLOSSY)
    }

    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        let mut f = [0.0; WAVES];
        let pdf = match &self.seen {
            Seen::Rgl(rgl, incident) => {
                let light = of_file(wi);
                match rgl.channels() {
                    Channels::Wavelengths(_) => rgl.values(incident, light, &self.nm, &mut f),
                    Channels::Rgb => {
                        let mut colour = [0.0; 3];
                        rgl.values(incident, light, &[], &mut colour);
                        f = self.spectrum(colour);
                    }
                }
                f = f.map(|f| f / wi.z);
                rgl.pdf(incident, light)
            }
            Seen::Merl(merl) => {
                f = self.spectrum(merl.f(of_file(wo), of_file(wi)));
                merl.pdf(of_file(wo), of_file(wi))
            }
        };
        (f, [pdf; WAVES])
    }

    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        let wi = match &self.seen {
            Seen::Rgl(rgl, incident) => rgl.sample(incident, [u[0], u[1]]),
            Seen::Merl(merl) => merl.sample(of_file(wo), u),
        }?;
        Some((of_barbule(wi), self.lobes()))
    }

    fn spectrum(&self, [r, g, b]: [f64; 3]) -> [f64; WAVES] {
        std::array::from_fn(|k| r * self.shares[0][k] + g * self.shares[1][k] + b * self.shares[2][k])
    }
}
