//! Isotropic materials as the MERL database has them: R, G and B over the half vector's angle, the difference's angle and its azimuth.
//!
//! Matusik, Pfister, Brand & McMillan, *A Data-Driven Reflectance Model*, ACM TOG 22, 2003: 90 angles θ_h, closest at 0 (θ_h = (π/2) (k/90)²),
//! 90 angles θ_d of a degree, and 180 azimuths φ_d of a degree; f does not change with φ_d → φ_d + π. Values are those of the nearest
//! cell below, as the database's own reader takes them.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::rgl::{jacobian, normal_of, place_of};
use super::warp::{Nodes, Warp};
use crate::spectrum::colour::luminance;
use crate::{Error, Result};

/// Angles of the half vector, of the difference, and azimuths of the difference.
pub const MERL_SIZE: [usize; 3] = [90, 90, 180];

/// Viewers' angles for which directions are drawn, and places of half vectors.
const ANGLES: usize = 32;
const PLACES: [usize; 2] = [33, 65];

/// Share of directions that are drawn from a cosine lobe, for what the table of places is too coarse for.
const DIFFUSE: f64 = 0.1;

/// A measured isotropic material.
#[derive(Debug, Clone)]
pub struct Merl {
    /// f in 1/sr of linear sRGB: `[channel][θ_h][θ_d][φ_d]`
    values: Vec<f32>,
    halves: Warp,
}

impl Merl {
    /// From f in 1/sr: `[channel][θ_h][θ_d][φ_d]`, R, G and B. Negative values, which stand for no measurement, become 0.
    ///
    /// # Errors
    /// Another number of values, one that is not finite, or a material that reflects nothing.
    pub fn new(mut values: Vec<f32>) -> Result<Self> {
        let wanted = 3 * MERL_SIZE.iter().product::<usize>();
        if values.len() != wanted {
            return Err(Error::input(format!("there are {} values where {wanted} belong", values.len())));
        }
        if values.iter().any(|value| !value.is_finite()) {
            return Err(Error::input("there is a value that is not finite"));
        }
        values.iter_mut().for_each(|value| *value = value.max(0.0));
        let mut density = Vec::with_capacity(ANGLES * PLACES[0] * PLACES[1]);
        for angle in 0..ANGLES {
            let w = viewer(angle);
            for place in 0..PLACES[0] * PLACES[1] {
                let at = [place / PLACES[1], place % PLACES[1]];
                let u: [f64; 2] = std::array::from_fn(|k| at[k] as f64 / (PLACES[k] - 1) as f64);
                let m = normal_of(u, 0.0);
                let cosine = w.dot(m);
                let wo = 2.0 * cosine * m - w;
                let is_seen = cosine > 0.0 && wo.z > 0.0;
                let seen = if is_seen { luminance(f(&values, w, wo)) * wo.z * cosine } else { 0.0 };
                density.push((seen * jacobian(u[1])) as f32);
            }
        }
        Ok(Self { values, halves: Warp::new(PLACES, density)? })
    }

    /// f in 1/sr of linear sRGB; both directions are above the horizon.
    #[must_use]
    pub fn f(&self, w: DVec3, wo: DVec3) -> [f64; 3] {
        f(&self.values, w, wo)
    }

    /// Density of [`Self::sample`] per sr.
    #[must_use]
    pub fn pdf(&self, w: DVec3, wo: DVec3) -> f64 {
        let m = (w + wo).normalize_or_zero();
        let cosine = w.dot(m);
        if cosine <= 0.0 {
            return 0.0;
        }
        let u = place_of(m, libm::atan2(w.y, w.x));
        let density = self.halves.density(&nodes(w), u) / (jacobian(u[1]) * 4.0 * cosine);
        (1.0 - DIFFUSE) * density + DIFFUSE * wo.z / PI
    }

    /// A direction; none where it would be below the horizon.
    #[must_use]
    pub fn sample(&self, w: DVec3, u: [f64; 3]) -> Option<DVec3> {
        if u[2] < DIFFUSE {
            let (radius, turn) = (u[0].sqrt(), 2.0 * PI * u[1]);
            return Some(DVec3::new(
                radius * libm::cos(turn),
                radius * libm::sin(turn),
                (1.0 - u[0]).max(0.0).sqrt(),
            ));
        }
        let (place, _) = self.halves.sample(&nodes(w), [u[0], u[1]]);
        let m = normal_of(place, libm::atan2(w.y, w.x));
        let wo = 2.0 * w.dot(m) * m - w;
        (wo.z > 0.0).then_some(wo)
    }
}

/// Viewers stand at φ = 0, at cosines from 1 down to nearly 0.
fn viewer(angle: usize) -> DVec3 {
    let cosine = 1.0 - (angle as f64 + 0.01).min((ANGLES - 1) as f64 - 0.01) / (ANGLES - 1) as f64;
    DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine)
}

fn nodes(w: DVec3) -> Nodes {
    let at = (1.0 - w.z).clamp(0.0, 1.0) * (ANGLES - 1) as f64;
    let low = (at as usize).min(ANGLES - 2);
    let share = at - low as f64;
    [(low, 1.0 - share), (low + 1, share), (0, 0.0), (0, 0.0)]
}

fn f(values: &[f32], w: DVec3, wo: DVec3) -> [f64; 3] {
    let m = (w + wo).normalize_or(DVec3::Z);
    let sine = m.x.hypot(m.y);
    let theta_h = libm::atan2(sine, m.z);
    // Turned so that m is upright: about z first, then about y.
    let (c, s) = if sine > 1e-12 { (m.x / sine, m.y / sine) } else { (1.0, 0.0) };
    let about_z = DVec3::new(c * wo.x + s * wo.y, c * wo.y - s * wo.x, wo.z);
    let d = DVec3::new(m.z * about_z.x - sine * about_z.z, about_z.y, sine * about_z.x + m.z * about_z.z);
    let theta_d = libm::atan2(d.x.hypot(d.y), d.z);
    let phi_d = libm::atan2(d.y, d.x);
    let phi_d = if phi_d < 0.0 { phi_d + PI } else { phi_d };
    let [halves, differences, azimuths] = MERL_SIZE;
    let index = |at: f64, count: usize| (at.max(0.0) as usize).min(count - 1);
    let h = index((theta_h / FRAC_PI_2).sqrt() * halves as f64, halves);
    let d = index(theta_d / FRAC_PI_2 * differences as f64, differences);
    let a = index(phi_d / PI * azimuths as f64, azimuths);
    let at = (h * differences + d) * azimuths + a;
    std::array::from_fn(|channel| f64::from(values[channel * halves * differences * azimuths + at]))
}
