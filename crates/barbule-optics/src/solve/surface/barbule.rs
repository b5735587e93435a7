//! A barbule prepared for light from anywhere, and what reflects under its top at one wavelength.

use super::CAMPAIGN_ELEMENT_UM;
use super::cone::Cone;
use super::crystal::{CrystalOrders, series};
use super::nodes::nodes_for;
use super::points::Points;
use super::radiation::nodes_at_once;
use super::rays::Rays;
use super::reflection::COMPONENTS;
use super::reflector::Reflector;
use super::table::ReflectanceTable;
use crate::math::simd::Width;
use crate::progress::Progress;
use crate::scattering::far_field::Window;
use crate::scattering::orders::OrderSeries;
use crate::structure::{Columns, Ray, Section, SlotMixture, averaged_columns, cast};
use crate::{Error, Result};

/// Places of the top under which layers are looked for, to foretell how many there are.
const SAMPLED: usize = 256;

/// How large a barbule's preparation becomes, foretold without it.
#[derive(Debug, Clone, Copy)]
pub struct Size {
    /// Quadrature points.
    pub points: usize,
    /// Layers and substrate under a point.
    pub slots: usize,
    arc_um: f64,
    radius_um: f64,
    /// Bytes of a layer under a point, beside its thickness, where layers are averaged along the top.
    shares: usize,
    /// Bytes of the columns that are averaged.
    columns: usize,
}

impl Size {
    /// Of a section with quadrature elements of at most `element_um`, from the layers under some places of its top.
    ///
    /// # Errors
    /// As [`Barbule::new`].
    pub fn foretell(section: &Section, element_um: f64) -> Result<Self> {
        let top = section.top();
        let (mut points, mut arc_um) = (0, 0.0);
        let mut rays = Vec::new();
        let every = top.x_um.len().div_ceil(SAMPLED);
        for (index, (x, z)) in top.x_um.windows(2).zip(top.z_um.windows(2)).enumerate() {
            let (dx, dz) = (x[1] - x[0], z[1] - z[0]);
            let length = dx.hypot(dz);
            arc_um += length;
            points += 2 * (length / element_um).ceil().max(1.0) as usize;
            if index % every == 0 {
                let (x_um, z_um) = (x[0] + 0.5 * dx, z[0] + 0.5 * dz);
                rays.push(Ray { x_um, z_um, normal: [-dz / length, dx / length] });
            }
        }
        let Columns { slots, mixture, .. } = cast(section, &rays)?;
        let shares = mixture.iter().map(SlotMixture::bytes).max().unwrap_or(0) / rays.len().max(1);
        let columns = averaged_columns(section, arc_um) * 24 * slots;
        Ok(Self { points, slots, arc_um, radius_um: Self::radius_um(section), shares, columns })
    }

    /// Largest distance of a section's top from the origin, µm.
    #[must_use]
    pub fn radius_um(section: &Section) -> f64 {
        let top = section.top();
        top.x_um.iter().zip(&top.z_um).fold(0.0, |radius, (x, z)| x.hypot(*z).max(radius))
    }

    /// The larger of both in everything.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            points: self.points.max(other.points),
            slots: self.slots.max(other.slots),
            arc_um: self.arc_um.max(other.arc_um),
            radius_um: self.radius_um.max(other.radius_um),
            shares: self.shares.max(other.shares),
            columns: self.columns.max(other.columns),
        }
    }

    /// Bytes of what is prepared.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.points.saturating_mul(100 + (12 + self.shares) * self.slots)
    }

    /// Bytes while `parts` rays are cast under each point, at most: layers found, their columns, and points of them.
    #[must_use]
    pub fn casting_bytes(&self, parts: usize) -> usize {
        let layers = (28 + 2 * self.shares) * self.slots;
        self.points.saturating_mul(parts).saturating_mul(160 + layers).saturating_add(self.columns)
    }

    /// Bytes to which a workspace of values of `value` bytes grows on light of a wavelength (nm) from `incidences`
    /// azimuths at θ_i = 0, which is where fields have most angles.
    #[must_use]
    pub fn workspace_bytes(&self, wavelength_nm: f64, incidences: usize, value: usize) -> usize {
        let cone = Cone::new(wavelength_nm, 0.0, self.radius_um);
        let nodes = match value {
            8 => self.points,
            _ => nodes_for(self.arc_um, cone.kappa).min(self.points),
        };
        workspace_bytes(self.points, nodes, cone.angles, incidences, value)
    }
}

/// Bytes of kernel, currents and products of the matrix product with their packed copies; coefficients and fields; taps.
fn workspace_bytes(points: usize, nodes: usize, angles: usize, incidences: usize, value: usize) -> usize {
    let (columns, fields) = (COMPONENTS * incidences, 4 * incidences);
    let kernel = angles * nodes.min(nodes_at_once(angles, value == 4));
    let sources = columns * if value == 4 { nodes } else { nodes.min(nodes_at_once(angles, false)) };
    value * (2 * kernel + 2 * sources + columns * angles + 4 * fields * angles) + points * 64
}

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
        Self::at_place(section, ray_parts, None)
    }

    /// The same with the window at a place of the top, x in µm; what lies farther from it than
    /// half the width is not lit.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn at_place(section: &Section, ray_parts: usize, place: Option<f64>) -> Result<Self> {
        let points = Points::subdivided(section, CAMPAIGN_ELEMENT_UM, 1, Window::Gaussian, place)?;
        let rays = match points.lattice {
            Some(_) => None,
            None if ray_parts == 1 => Some(Rays::under(&points, 1)),
            None => Some(Rays::cast(section, CAMPAIGN_ELEMENT_UM, ray_parts, place)?),
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
        let nodes = super::nodes::Nodes::<f32>::equidistant(&self.points, cone.kappa).x_um.len();
        workspace_bytes(self.points.padded(), nodes, cone.angles, incidences, 4)
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
    /// A medium's table does not reach the wavelength, there are no rays, or a stop by `progress`.
    #[inline(never)]
    pub fn table(&self, wavelength_nm: f64, width: Width, progress: &dyn Progress) -> Result<Underside> {
        let Some(rays) = &self.rays else {
            return Err(Error::machine("this barbule was prepared without rays"));
        };
        let table = ReflectanceTable::new(width, &self.points, rays, wavelength_nm, progress)?;
        Ok(Underside(Reflector::Tabulated(table)))
    }

    /// What reflects under the top, solved here if it is a crystal, for light from `phi_i` (rad): the stacks themselves in
    /// either precision.
    pub(super) fn exactly<T: super::scalar::Scalar>(
        &self,
        wavelength_nm: f64,
        theta_i: f64,
        phi_i: &[f64],
        progress: &dyn Progress,
    ) -> Result<Reflector<T>> {
        match &self.points.lattice {
            None => Ok(Reflector::Stacks(self.points.optics(wavelength_nm)?)),
            Some(lattice) => {
                let range = |values: &[f64]| {
                    let [low, high] = [f64::INFINITY, f64::NEG_INFINITY];
                    values.iter().fold([low, high], |[low, high], &v| [low.min(v), high.max(v)])
                };
                let (slopes, phis) = (range(&self.points.double.slope), range(phi_i));
                let phi = [slopes[0] + phis[0], slopes[1] + phis[1]];
                let series = series(lattice, wavelength_nm, theta_i, phi, progress)?;
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
