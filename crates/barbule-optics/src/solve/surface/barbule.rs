//! A barbule prepared for light from anywhere, and what reflects under its top at one wavelength.

use super::CAMPAIGN_ELEMENT_UM;
use super::cone::Cone;
use super::crystal::{CrystalOrders, series};
use super::points::Points;
use super::rays::Rays;
use super::reflection::COMPONENTS;
use super::reflector::Reflector;
use super::table::ReflectanceTable;
use crate::math::simd::Width;
use crate::scattering::far_field::Window;
use crate::scattering::orders::OrderSeries;
use crate::structure::Section;
use crate::{Error, Result};

/// One instance of a barbule, prepared: points along its top, and rays through the layers under them.
pub struct Barbule {
    pub(super) points: Points,
    rays: Option<Rays>,
}

impl Barbule {
    /// Prepares a section with quadrature elements of at most `element_um`.
    ///
    /// # Errors
    /// The light does not come through air, or the top has no length.
    pub fn new(section: &Section, element_um: f64, window: Window) -> Result<Self> {
        Ok(Self { points: Points::new(section, element_um, window)?, rays: None })
    }

    /// Prepares a section as campaigns do: elements of [`CAMPAIGN_ELEMENT_UM`] in a Gaussian window, each cut into
    /// `ray_parts` for rays; over a crystal there are none.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn for_campaign(section: &Section, ray_parts: usize) -> Result<Self> {
        let points = Points::new(section, CAMPAIGN_ELEMENT_UM, Window::Gaussian)?;
        let rays = match points.lattice {
            Some(_) => None,
            None => Some(Rays::cast(section, CAMPAIGN_ELEMENT_UM, ray_parts)?),
        };
        Ok(Self { points, rays })
    }

    /// Φ_i, the incident power per length for unit |E| and c₀ = 1, µm.
    #[must_use]
    pub fn incident_power_um(&self, theta_i: f64, phi_i: f64) -> f64 {
        self.points.incident_power_um(theta_i, phi_i)
    }

    /// Parts into which elements are cut for the rays under them; `None` without rays.
    #[must_use]
    pub fn ray_parts(&self) -> Option<usize> {
        self.rays.as_ref().map(Rays::parts)
    }

    /// Layers and substrate under a point, those of no thickness included.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.points.slots
    }

    /// Bytes that it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.points.bytes() + self.rays.as_ref().map_or(0, Rays::bytes)
    }

    /// Bytes of the media at one wavelength, which its [`Underside`] keeps where they vary along the top.
    #[must_use]
    pub fn media_bytes(&self) -> usize {
        if self.points.lattice.is_some() { 0 } else { 8 * self.points.padded() * self.points.slots }
    }

    /// Bytes to which a workspace grows on light from `incidences` azimuths.
    #[must_use]
    pub fn workspace_bytes(&self, cone: &Cone, incidences: usize) -> usize {
        let (points, angles) = (self.points.padded(), cone.angles);
        let nodes = super::nodes::Nodes::<f32>::equidistant(&self.points, cone.kappa).x_um.len();
        let (columns, fields) = (COMPONENTS / 2 * incidences, 4 * incidences);
        // Kernel, currents and products of the matrix product with their packed copies; coefficients; taps.
        2 * 4 * (angles * nodes + columns * (angles + nodes)) + 8 * fields * angles + 4 * points * 16
    }

    /// What reflects under the top at a vacuum wavelength: the stacks themselves.
    ///
    /// # Errors
    /// A medium's table does not reach the wavelength.
    #[inline(never)]
    pub fn stacks(&self, wavelength_nm: f64) -> Result<Underside> {
        Ok(Underside(Reflector::Stacks(self.points.optics(wavelength_nm)?)))
    }

    /// What reflects under the top at a vacuum wavelength: reflectances tabulated from the rays, for many directions.
    ///
    /// # Errors
    /// A medium's table does not reach the wavelength, or there are no rays.
    #[inline(never)]
    pub fn table(&self, wavelength_nm: f64, width: Width) -> Result<Underside> {
        let Some(rays) = &self.rays else {
            return Err(Error::machine("this barbule was prepared without rays"));
        };
        let table = ReflectanceTable::new(width, &self.points, rays, wavelength_nm)?;
        Ok(Underside(Reflector::Tabulated(table)))
    }

    /// What reflects under the top, solved here if it is a crystal: the stacks themselves in either precision.
    pub(super) fn exactly<T: super::scalar::Scalar>(
        &self,
        wavelength_nm: f64,
        theta_i: f64,
    ) -> Result<Reflector<T>> {
        match &self.points.lattice {
            None => Ok(Reflector::Stacks(self.points.optics(wavelength_nm)?)),
            Some(lattice) => {
                let series = series(lattice, wavelength_nm, theta_i)?;
                Ok(Reflector::Crystal(CrystalOrders::new(&series, theta_i, lattice.bottom_um())))
            }
        }
    }
}

/// What reflects under a barbule's top at one wavelength: layers at any θ_i, or a crystal, the same under all barbules, at
/// one.
pub struct Underside(pub(super) Reflector<f32>);

impl Underside {
    /// A crystal that is `depth_um` deep at the θ_i (rad) of a series of its orders.
    #[must_use]
    #[inline(never)]
    pub fn crystal(series: &OrderSeries, theta_i: f64, depth_um: f64) -> Self {
        Self(Reflector::Crystal(CrystalOrders::new(series, theta_i, depth_um)))
    }

    /// Bytes of its tables.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match &self.0 {
            Reflector::Stacks(_) => 0,
            Reflector::Tabulated(table) => table.bytes(),
            Reflector::Crystal(orders) => orders.bytes(),
        }
    }
}
