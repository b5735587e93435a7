//! Any material as the arrays of an RGL file: its values where the file's own warps put them.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use super::rgl::{Channels, Grid, RglArrays, jacobian, normal_of};
use super::warp::{Nodes, Warp};
use crate::Result;

/// Rows and columns of the table of σ.
const SIGMA_SIZE: [usize; 2] = [33, 17];

/// Shares of the mean that are added to densities, so that nothing is never drawn: of visible normals, and of luminance.
const VISIBLE_FLOOR: f64 = 0.002;
const LUMINANCE_FLOOR: f64 = 0.01;

/// The largest angle from the normal of ω, rad: nothing is seen at 90°.
const MOST_THETA: f64 = 88.0 * PI / 180.0;

/// Lowest light, as the cosine of its angle from the normal: below it values are 0.
const LOWEST: f64 = 1e-4;

/// How finely a material is tabulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolution {
    /// Angles of ω from the normal.
    pub thetas: usize,
    /// Azimuths of ω, both ends of the circle among them; odd.
    pub phis: usize,
    /// Rows and columns of values for each ω.
    pub values: usize,
    /// Rows (φ) and columns (θ) of the tables of normals.
    pub normals: [usize; 2],
}

impl Resolution {
    /// Bytes of the arrays with so many channels.
    #[must_use]
    pub fn bytes(&self, channels: usize) -> usize {
        let per_node = self.values * self.values * (channels + 1) + self.normals[0] * self.normals[1];
        4 * (self.thetas * self.phis * per_node + self.normals[0] * self.normals[1])
    }
}

/// Tabulates f cosθ_o of `channels`: `values` gets ω, the light's direction and room for each channel, in 1/sr and the file's frame.
/// `distribution` is D(m) in any unit: where it is large, values lie close.
///
/// # Errors
/// A distribution or values that are negative, not finite, or zero everywhere.
pub fn tabulate(
    resolution: &Resolution,
    channels: Channels,
    distribution: &(dyn Fn(DVec3) -> f64 + Sync),
    values: &(dyn Fn(DVec3, DVec3, &mut [f64]) + Sync),
) -> Result<RglArrays> {
    let Resolution { thetas, phis, values: side, normals } = *resolution;
    let count = match &channels {
        Channels::Wavelengths(nm) => nm.len(),
        Channels::Rgb => 3,
    };
    let ndf = Grid { size: normals, values: over(normals, |m, _| distribution(m) as f32) };
    let sigma = sigma_of(&ndf);
    let theta_i: Vec<f32> =
        (0..thetas).map(|t| (MOST_THETA * t as f64 / (thetas - 1) as f64) as f32).collect();
    let phi_i: Vec<f32> =
        (0..phis).map(|p| (PI * (2.0 * p as f64 / (phis - 1) as f64 - 1.0)) as f32).collect();
    let nodes: Vec<Node> = (0..(phis - 1) * thetas)
        .into_par_iter()
        .map(|node| {
            let (phi, theta) = (f64::from(phi_i[node / thetas]), f64::from(theta_i[node % thetas]));
            let place = [phi / TAU + 0.5, (2.0 * theta / PI).sqrt()];
            Node::new(normal_of(place, 0.0), side, (&ndf, sigma.at(place)), count, values)
        })
        .collect::<Result<_>>()?;
    let mut arrays = RglArrays {
        phi_i,
        theta_i,
        channels,
        ndf,
        sigma,
        vndf_size: normals,
        vndf: Vec::new(),
        size: [side; 2],
        luminance: Vec::new(),
        values: Vec::new(),
        has_jacobian: true,
    };
    // φ = π is φ = −π.
    for node in nodes.iter().chain(&nodes[..thetas]) {
        arrays.vndf.extend_from_slice(&node.vndf);
        arrays.luminance.extend_from_slice(&node.luminance);
        arrays.values.extend_from_slice(&node.values);
    }
    Ok(arrays)
}

/// What belongs to one ω.
struct Node {
    vndf: Vec<f32>,
    luminance: Vec<f32>,
    /// `[channel][row][column]`
    values: Vec<f32>,
}

impl Node {
    fn new(
        w: DVec3,
        side: usize,
        (ndf, sigma): (&Grid, f64),
        channels: usize,
        values: &(dyn Fn(DVec3, DVec3, &mut [f64]) + Sync),
    ) -> Result<Self> {
        let mut vndf = over(ndf.size, |m, u| (jacobian(u) * w.dot(m).max(0.0)) as f32);
        vndf.iter_mut().zip(&ndf.values).for_each(|(v, d)| *v *= d);
        raise(&mut vndf, VISIBLE_FLOOR);
        let warp = Warp::new(ndf.size, vndf.clone())?;
        let own: Nodes = [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
        let points = side * side;
        let (mut table, mut luminance) = (vec![0.0; points * channels], vec![0.0; points]);
        let mut seen = vec![0.0; channels];
        for point in 0..points {
            let at =
                [point / side, point % side].map(|k| (k as f64 / (side - 1) as f64).clamp(1e-7, 1.0 - 1e-7));
            let (u_m, density) = warp.sample(&own, at);
            let m = normal_of(u_m, 0.0);
            let cosine = w.dot(m);
            let wo = (2.0 * cosine * m - w).normalize();
            if cosine <= 0.0 || wo.z <= LOWEST {
                continue;
            }
            values(w, wo, &mut seen);
            let scale = 4.0 * sigma / ndf.at(u_m);
            for (channel, value) in seen.iter().enumerate() {
                table[channel * points + point] = (value * scale) as f32;
            }
            let per_sr = density / (jacobian(u_m[1]) * 4.0 * cosine);
            luminance[point] = (seen.iter().sum::<f64>() / (channels as f64 * per_sr)) as f32;
        }
        raise(&mut luminance, LUMINANCE_FLOOR);
        Ok(Self { vndf, luminance, values: table })
    }
}

/// Adds a share of the mean; where all is zero, 1.
fn raise(density: &mut [f32], share: f64) {
    let mean = density.iter().map(|v| f64::from(*v)).sum::<f64>() / density.len() as f64;
    let floor = if mean > 0.0 { share * mean } else { 1.0 } as f32;
    density.iter_mut().for_each(|value| *value += floor);
}

/// Values at the points of the unit square of normals: of the normal and its column's place.
fn over(size: [usize; 2], value: impl Fn(DVec3, f64) -> f32) -> Vec<f32> {
    let at = |k: usize| {
        let u = [k / size[1], k % size[1]];
        let u: [f64; 2] = std::array::from_fn(|i| u[i] as f64 / (size[i] - 1) as f64);
        value(normal_of(u, 0.0), u[1])
    };
    (0..size[0] * size[1]).map(at).collect()
}

/// σ(ω) = ∫ D(m) max(0, ω·m) dm of what a table of D says at its points, by trapezoids.
fn sigma_of(ndf: &Grid) -> Grid {
    let [rows, columns] = ndf.size;
    let weight =
        |k: usize, count: usize| if k == 0 || k == count - 1 { 0.5 } else { 1.0 } / (count - 1) as f64;
    let mut normals = Vec::with_capacity(rows * columns);
    for (at, density) in ndf.values.iter().enumerate() {
        let place = [at / columns, at % columns];
        let area = weight(place[0], rows) * weight(place[1], columns);
        let u = [place[0] as f64 / (rows - 1) as f64, place[1] as f64 / (columns - 1) as f64];
        let m = normal_of(u, 0.0);
        normals.push((m, f64::from(*density) * area * jacobian(u[1])));
    }
    let of = |w: DVec3| normals.iter().map(|(m, share)| share * w.dot(*m).max(0.0)).sum::<f64>() as f32;
    Grid { size: SIGMA_SIZE, values: over(SIGMA_SIZE, |w, _| of(w)) }
}
