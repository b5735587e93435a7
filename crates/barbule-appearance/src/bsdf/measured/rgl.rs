//! Measured materials as the RGL database has them: values over a grid that follows the material's own lobe.
//!
//! f cosθ_o = S(u) D(m)/(4 σ(ω)), where m is the half vector, D a distribution of it, σ(ω) = ∫ D(m) max(0, ω·m) dm, and u the place of m in
//! the unit square after two warps: places of m are crowded by a density of visible normals, directions that are drawn by a luminance
//! within it (Dupuy & Jakob, *An Adaptive Parameterization for Efficient Material Acquisition and Rendering*, ACM TOG 37, 2018). All tables
//! are linear in between.
//!
//! Directions are in the file's frame: x along what was turned to φ = 0, z up. ω is the direction that tables are indexed by; renderers give
//! the viewer's.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::warp::{Nodes, Warp, cell, lerp};
use crate::{Error, Result};

/// A table over the unit square of directions: rows φ, columns θ, points on its borders.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Rows and columns, at least 2 of each.
    pub size: [usize; 2],
    /// `[row][column]`
    pub values: Vec<f32>,
}

/// What values are of.
#[derive(Debug, Clone, PartialEq)]
pub enum Channels {
    /// Vacuum wavelengths, nm, rising.
    Wavelengths(Vec<f32>),
    /// Linear sRGB.
    Rgb,
}

/// The arrays of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct RglArrays {
    /// Azimuths of ω, rad, rising; of isotropic materials one or two.
    pub phi_i: Vec<f32>,
    /// Its angles from the normal, rad, rising from 0.
    pub theta_i: Vec<f32>,
    /// What values are of.
    pub channels: Channels,
    /// D, 1/sr.
    pub ndf: Grid,
    /// σ.
    pub sigma: Grid,
    /// Rows and columns of the density of visible normals.
    pub vndf_size: [usize; 2],
    /// `[φ_i][θ_i][row][column]`
    pub vndf: Vec<f32>,
    /// Rows and columns of the luminance and of the values.
    pub size: [usize; 2],
    /// `[φ_i][θ_i][row][column]`
    pub luminance: Vec<f32>,
    /// S: `[φ_i][θ_i][channel][row][column]`
    pub values: Vec<f32>,
    /// Whether values are S; else they are f cosθ_o themselves.
    pub has_jacobian: bool,
}

/// A measured material ready for evaluation.
#[derive(Debug, Clone)]
pub struct Rgl {
    phi_i: Vec<f32>,
    theta_i: Vec<f32>,
    channels: Channels,
    ndf: Grid,
    sigma: Grid,
    vndf: Warp,
    luminance: Warp,
    size: [usize; 2],
    values: Vec<f32>,
    has_jacobian: bool,
    /// In how many parts of the circle azimuths were measured once, for what looks alike in all: 1, 2 or 4.
    parts: u32,
}

/// ω among the tables.
#[derive(Debug, Clone, Copy)]
pub struct Incident {
    /// In the part of the circle that the file has.
    w: DVec3,
    /// What was mirrored for that.
    signs: [f64; 2],
    /// What the half vector's azimuth is counted from.
    phi: f64,
    nodes: Nodes,
    sigma: f64,
}

/// Where a pair of directions is in the tables.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// In the warped square.
    u: [f64; 2],
    /// What S is multiplied by.
    factor: f64,
    /// Density of visible normals per sr of the direction that is drawn.
    visible: f64,
}

impl Rgl {
    /// Checks a file's arrays and prepares them.
    ///
    /// # Errors
    /// Axes that do not rise or are out of range, arrays of other sizes than these say, values that are not finite, densities that are none.
    pub fn new(arrays: RglArrays) -> Result<Self> {
        let RglArrays {
            phi_i,
            theta_i,
            channels,
            ndf,
            sigma,
            vndf_size,
            vndf,
            size,
            luminance,
            values,
            has_jacobian,
        } = arrays;
        check_axis("theta_i", &theta_i, [0.0, FRAC_PI_2 + 1e-3])?;
        check_axis("phi_i", &phi_i, [-PI - 1e-3, TAU + 1e-3])?;
        let count = match &channels {
            Channels::Rgb => 3,
            Channels::Wavelengths(nm) => {
                check_axis("wavelengths", nm, [100.0, 1e5])?;
                nm.len()
            }
        };
        let nodes = phi_i.len() * theta_i.len();
        let whole = |name: &str, [rows, columns]: [usize; 2], of: usize, values: &[f32]| {
            let wanted = rows.checked_mul(columns).and_then(|one| one.checked_mul(of));
            let is_sound = rows >= 2 && columns >= 2 && wanted == Some(values.len());
            match values.iter().all(|value| value.is_finite()) {
                _ if !is_sound => Err(Error::input(format!(
                    "{name} has {} values where {of} times {rows} × {columns} belong",
                    values.len()
                ))),
                true => Ok(()),
                false => Err(Error::input(format!("{name} has a value that is not finite"))),
            }
        };
        whole("ndf", ndf.size, 1, &ndf.values)?;
        whole("sigma", sigma.size, 1, &sigma.values)?;
        whole("vndf", vndf_size, nodes, &vndf)?;
        whole("luminance", size, nodes, &luminance)?;
        whole("values", size, nodes * count, &values)?;
        let vndf = Warp::new(vndf_size, vndf).map_err(|error| error.at("vndf"))?;
        let luminance = Warp::new(size, luminance).map_err(|error| error.at("luminance"))?;
        let span = f64::from(phi_i[phi_i.len() - 1] - phi_i[0]);
        let parts = if phi_i.len() <= 2 { 1 } else { (TAU / span).round().clamp(1.0, 4.0) as u32 };
        Ok(Self { phi_i, theta_i, channels, ndf, sigma, vndf, luminance, size, values, has_jacobian, parts })
    }

    /// What values are of.
    #[must_use]
    pub fn channels(&self) -> &Channels {
        &self.channels
    }

    /// Memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.vndf.bytes()
            + self.luminance.bytes()
            + 4 * (self.values.len() + self.ndf.values.len() + self.sigma.values.len())
    }

    fn is_isotropic(&self) -> bool {
        self.phi_i.len() <= 2
    }

    /// ω, a unit vector above the horizon, among the tables.
    #[must_use]
    pub fn incident(&self, w: DVec3) -> Incident {
        let signs = self.signs(w);
        let w = mirrored(w, signs);
        let (theta, phi) = (libm::acos(w.z.clamp(-1.0, 1.0)), libm::atan2(w.y, w.x));
        let (t, a) = bracket(&self.theta_i, theta);
        let (p, b) = if self.is_isotropic() { (0, 0.0) } else { bracket(&self.phi_i, phi) };
        let node = |p: usize, t: usize| {
            p.min(self.phi_i.len() - 1) * self.theta_i.len() + t.min(self.theta_i.len() - 1)
        };
        let nodes = [
            (node(p, t), (1.0 - a) * (1.0 - b)),
            (node(p, t + 1), a * (1.0 - b)),
            (node(p + 1, t), (1.0 - a) * b),
            (node(p + 1, t + 1), a * b),
        ];
        let sigma = self.sigma.at([phi / TAU + 0.5, (2.0 * theta / PI).sqrt()]);
        let phi = if self.is_isotropic() { phi } else { 0.0 };
        Incident { w, signs, phi, nodes, sigma }
    }

    /// How x and y are mirrored so that ω lies in the part of the circle that the file has: φ_i of −π … 0, or −π … −π/2.
    fn signs(&self, w: DVec3) -> [f64; 2] {
        let turned = |v: f64| if v > 0.0 { -1.0 } else { 1.0 };
        match self.parts {
            1 => [1.0; 2],
            4 => [turned(w.x), turned(w.y)],
            _ => [turned(w.y); 2],
        }
    }

    /// f cosθ_o in 1/sr at wavelengths in nm, or of R, G and B; `wo` is above the horizon.
    #[inline]
    pub fn values(&self, incident: &Incident, wo: DVec3, nm: &[f64], to: &mut [f64]) {
        let Some(place) = self.place(incident, wo) else { return to.fill(0.0) };
        let [rows, columns] = self.size;
        let ((row, a), (column, b)) = (cell(place.u[0], rows), cell(place.u[1], columns));
        let weights = [(1.0 - a) * (1.0 - b), (1.0 - a) * b, a * (1.0 - b), a * b].map(|w| w * place.factor);
        let at = row * columns + column;
        let corners = [at, at + 1, at + columns, at + columns + 1];
        let per_channel = rows * columns;
        let count = self.values.len() / (per_channel * self.vndf.nodes());
        let of = |channel: usize| {
            let one = |(node, w): &(usize, f64)| {
                let from = (node * count + channel) * per_channel;
                let sum: f64 =
                    corners.iter().zip(weights).map(|(k, v)| f64::from(self.values[from + k]) * v).sum();
                w * sum
            };
            incident.nodes.iter().filter(|(_, w)| *w > 0.0).map(one).sum::<f64>().max(0.0)
        };
        match &self.channels {
            Channels::Rgb => to.iter_mut().enumerate().for_each(|(channel, value)| *value = of(channel)),
            Channels::Wavelengths(table) => {
                for (value, nm) in to.iter_mut().zip(nm) {
                    let (low, share) = bracket(table, *nm);
                    let below = of(low);
                    *value = if share > 0.0 { lerp(below, of(low + 1), share) } else { below };
                }
            }
        }
    }

    /// Density of [`Self::sample`] per sr.
    #[inline]
    #[must_use]
    pub fn pdf(&self, incident: &Incident, wo: DVec3) -> f64 {
        let Some(place) = self.place(incident, wo) else { return 0.0 };
        place.visible * self.luminance.density(&incident.nodes, place.u)
    }

    /// A direction; none where it would be below the horizon.
    #[must_use]
    pub fn sample(&self, incident: &Incident, u: [f64; 2]) -> Option<DVec3> {
        let (u, _) = self.luminance.sample(&incident.nodes, u);
        let (u_m, _) = self.vndf.sample(&incident.nodes, u);
        let m = normal_of(u_m, incident.phi);
        let wo = 2.0 * incident.w.dot(m) * m - incident.w;
        (wo.z > 0.0).then(|| mirrored(wo, incident.signs))
    }

    /// None for directions whose half vector is away from ω.
    #[inline]
    fn place(&self, incident: &Incident, wo: DVec3) -> Option<Place> {
        let m = (incident.w + mirrored(wo, incident.signs)).normalize_or_zero();
        let cosine = incident.w.dot(m);
        if cosine <= 0.0 {
            return None;
        }
        let u_m = place_of(m, incident.phi);
        let (u, density) = self.vndf.invert(&incident.nodes, u_m);
        let factor = if self.has_jacobian { self.ndf.at(u_m) / (4.0 * incident.sigma) } else { 1.0 };
        Some(Place { u, factor, visible: density / (jacobian(u_m[1]) * 4.0 * cosine) })
    }
}

impl Grid {
    /// The value at a place, linear between points.
    #[inline]
    #[must_use]
    pub fn at(&self, place: [f64; 2]) -> f64 {
        let [rows, columns] = self.size;
        let ((row, a), (column, b)) = (cell(place[0], rows), cell(place[1], columns));
        let value = |i: usize, j: usize| f64::from(self.values[(row + i) * columns + column + j]);
        lerp(lerp(value(0, 0), value(1, 0), a), lerp(value(0, 1), value(1, 1), a), b)
    }
}

/// Solid angle per area of the unit square of normals, sr: θ = u² π/2 and φ = (2v − 1)π.
#[inline]
#[must_use]
pub fn jacobian(u: f64) -> f64 {
    (2.0 * PI * PI * u * libm::sin(u * u * FRAC_PI_2)).max(1e-6)
}

/// The direction of a place (φ, θ) in the unit square, its azimuth counted from `phi`.
#[inline]
#[must_use]
pub fn normal_of([v, u]: [f64; 2], phi: f64) -> DVec3 {
    let (theta, phi) = (u * u * FRAC_PI_2, (2.0 * v - 1.0) * PI + phi);
    let sine = libm::sin(theta);
    DVec3::new(sine * libm::cos(phi), sine * libm::sin(phi), libm::cos(theta))
}

/// The place (φ, θ) of a direction in the unit square, its azimuth counted from `phi`.
#[inline]
pub(super) fn place_of(m: DVec3, phi: f64) -> [f64; 2] {
    let theta = libm::atan2(m.x.hypot(m.y), m.z);
    let v = (libm::atan2(m.y, m.x) - phi) / TAU + 0.5;
    [v - v.floor(), (2.0 * theta / PI).min(1.0).sqrt()]
}

#[inline]
fn mirrored(w: DVec3, [x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(w.x * x, w.y * y, w.z)
}

/// The node below a value and the share of the next; the end values hold outside.
#[inline]
fn bracket(axis: &[f32], value: f64) -> (usize, f64) {
    if axis.len() < 2 {
        return (0, 0.0);
    }
    let above = axis.partition_point(|node| f64::from(*node) <= value).clamp(1, axis.len() - 1);
    let (low, high) = (f64::from(axis[above - 1]), f64::from(axis[above]));
    (above - 1, ((value - low) / (high - low)).clamp(0.0, 1.0))
}

fn check_axis(name: &str, axis: &[f32], [low, high]: [f64; 2]) -> Result<()> {
    let is_within = axis.iter().all(|value| (low..=high).contains(&f64::from(*value)));
    if axis.is_empty() || !is_within || axis.windows(2).any(|pair| pair[1] <= pair[0]) {
        return Err(Error::input(format!("{name} must rise, from {low:.3} to {high:.3} at most")));
    }
    Ok(())
}
