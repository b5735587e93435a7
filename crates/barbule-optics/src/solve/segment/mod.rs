//! Fast wave simulation of a barbule segment in three dimensions.
//!
//! As [`surface`](super::surface), with an integral over the surface in place of one across it: each point reflects like the
//! ideal stack or crystal under it, and the currents there radiate over the whole hemisphere.
//!
//! A segment's top is z₀(x) + δ(x, y) with a small δ. Along y the currents go by Fourier transforms, which leaves for each
//! outgoing ω_y a cone of directions as in 2.5D: a matrix product over x with the kernel e^{−jk(xω_x + z₀ω_z)}, exact for any
//! cross section. e^{−jkδω_z} is interpolated over ω_z from a few Chebyshev nodes. Rows of directions lie at multiples of a step
//! from the mirror's ω_y = −ω_iy, which is a row. Source: the theory page on three dimensions.

mod crystal;
mod layered;
mod radiate;
#[cfg(test)]
mod tests;

use glam::DVec3;
use num_complex::{Complex32, Complex64};

use super::cost::Cost;
use crate::math::simd::Width;
use crate::progress::Progress;
use crate::scattering::directions::{e1, e2, omega};
use crate::spectrum::wave_number_per_um;
use crate::structure::{Line, Sampled, Segment, SegmentGrid};
use crate::{Error, Result};

/// CPU seconds that a roughened boundary takes at each cell, with the layer above it.
const PLACE_S: f64 = 2e-7;

/// CPU seconds of solving a crystal's orders.
const CRYSTAL_S: f64 = 0.4;

/// Components of a current: J_x, J_y, J_z, M_x, M_y, M_z.
const COMPONENTS: usize = 6;

/// Light on a segment: unit |E| within exp(−(x/w_x)² − (y/w_y)²).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentLight {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Longitudinal angle towards the light, rad.
    pub theta_i: f64,
    /// Azimuth towards the light, rad.
    pub phi_i: f64,
    /// w_x and w_y, µm.
    pub window_um: [f64; 2],
    /// How far light and view are turned about y against the segment, rad, as campaigns do with instances.
    pub turn: f64,
}

/// How finely a segment is sampled, and with which instructions it is computed.
#[derive(Debug, Clone, Copy)]
pub struct SegmentAccuracy {
    /// Largest cells along x and y in wavelengths.
    pub cells: [f64; 2],
    /// Places of a cell across at which its layers are known; their reflectances are averaged.
    pub parts: usize,
    /// Largest error of the interpolation over ω_z, in parts of a current.
    pub interpolation: f64,
    /// Bytes of transformed currents that are held at a time; what is over it is computed again in further passes.
    pub held_bytes: usize,
    /// SIMD instructions, on which only roundings depend.
    pub width: Width,
}

impl Default for SegmentAccuracy {
    /// At 400 nm, intensities within 1.3e-2 (relative L2) of those of cells half as long, energies within 4e-3; of crystals within
    /// 7e-5 and 1e-5.
    fn default() -> Self {
        Self { cells: [0.2, 0.25], parts: 2, interpolation: 1e-4, held_bytes: 1 << 30, width: Width::best() }
    }
}

/// Far fields of a segment over the hemisphere of outgoing directions (ω_x, ω_y, ω_z).
#[derive(Debug, Clone)]
pub struct Hemisphere {
    /// Spacing of ω_x and of ω_y.
    pub step: [f64; 2],
    /// ω_x reaches from −reach·step to reach·step.
    pub reach: usize,
    /// ω_y of each row.
    pub omega_y: Vec<f64>,
    /// 𝓔 along e₁ and e₂ of the outgoing direction for both incident polarizations, µm; 0 beyond the horizon. Shape:
    /// `[polarization][row][2·reach + 1][e₁, e₂]`.
    pub amplitudes: [Vec<[Complex32; 2]>; 2],
    /// Φ_i/c₀ for unit |E|, µm².
    pub incident_um2: f64,
}

impl Hemisphere {
    /// Directions of a row.
    #[must_use]
    pub fn columns(&self) -> usize {
        2 * self.reach + 1
    }

    /// ω_x of a column.
    #[must_use]
    pub fn omega_x(&self, column: usize) -> f64 {
        (column as f64 - self.reach as f64) * self.step[0]
    }

    /// Unpolarized |𝓔|²/(Φ_i/c₀), 1/sr: the intensity as a part of the incident power. Shape: `[row][column]`.
    #[must_use]
    pub fn intensity(&self) -> Vec<f64> {
        let [a, b] = &self.amplitudes;
        let square = |field: &[Complex32; 2]| f64::from(field[0].norm_sqr() + field[1].norm_sqr());
        a.iter().zip(b).map(|(a, b)| 0.5 * (square(a) + square(b)) / self.incident_um2).collect()
    }

    /// Solid angle of each direction of the grid, sr: what its cell covers of the row, exactly. Shape: `[row][column]`.
    #[must_use]
    pub fn solid_angles(&self) -> Vec<f64> {
        let weight = |y: f64, column: usize| {
            let radius = (1.0 - y * y).max(0.0).sqrt();
            let edge = |at: f64| (at / radius).clamp(-1.0, 1.0).asin();
            let x = self.omega_x(column);
            self.step[1] * (edge(x + 0.5 * self.step[0]) - edge(x - 0.5 * self.step[0]))
        };
        self.omega_y.iter().flat_map(|&y| (0..self.columns()).map(move |column| weight(y, column))).collect()
    }

    /// Φ_r/Φ_i of unpolarized light.
    #[must_use]
    pub fn reflected(&self) -> f64 {
        self.intensity().iter().zip(self.solid_angles()).map(|(value, angle)| value * angle).sum()
    }
}

/// The incident wave and how the segment lies under it.
struct Incidence {
    k: f64,
    /// Towards the light.
    omega: DVec3,
    /// Electric fields of the two polarizations; the magnetic ones are `[e₂, −e₁]`.
    electric: [DVec3; 2],
    magnetic: [DVec3; 2],
    window_um: [f64; 2],
}

impl Incidence {
    fn new(light: &SegmentLight) -> Self {
        let phi = light.phi_i + light.turn;
        let (first, second) = (e1(light.theta_i, phi), e2(phi));
        Self {
            k: wave_number_per_um(light.wavelength_nm),
            omega: omega(light.theta_i, phi),
            electric: [first, second],
            magnetic: [second, -first],
            window_um: light.window_um,
        }
    }

    /// Part of the window along x or y.
    fn window(&self, axis: usize, at_um: f64) -> f64 {
        (-(at_um / self.window_um[axis]).powi(2)).exp()
    }
}

/// One point of the top under light.
struct Place {
    /// Outward.
    normal: DVec3,
    cos_alpha: f64,
    /// Amplitude of the wave times the area of the cell, µm², with its phase but for that along y.
    wave: Complex64,
}

impl Place {
    /// The point of a line in this row, of cells of `area_um2`; `None` in its own shadow.
    fn new(incidence: &Incidence, line: &Line, row: usize, y_um: f64, area_um2: f64) -> Option<Self> {
        let up =
            DVec3::new(-(line.slope + f64::from(line.slopes[0][row])), -f64::from(line.slopes[1][row]), 1.0);
        let length = up.length();
        let normal = up / length;
        let cos_alpha = normal.dot(incidence.omega);
        if cos_alpha <= 0.0 {
            return None;
        }
        let size = incidence.window(0, line.x_um) * incidence.window(1, y_um) * area_um2 * length;
        let z = line.z_um + f64::from(line.rise_um[row]);
        let path = incidence.omega.x * line.x_um + incidence.omega.z * z;
        let (sin, cos) = (-incidence.k * path).sin_cos();
        Some(Self { normal, cos_alpha, wave: Complex64::new(cos, sin) * size })
    }

    /// What falls on it, µm²: |wave|²/area·cosα.
    fn power(&self, area_um2: f64) -> f64 {
        // The wave has the slanted area, the power g² times it.
        let slanted = area_um2 / self.normal.z;
        self.wave.norm_sqr() / slanted * self.cos_alpha
    }
}

/// What makes the currents along a line.
enum Reflector<'a> {
    Layers(layered::Stacks<'a>),
    Crystal(crystal::Crystal<'a>),
}

/// Currents of both polarizations along one line, times the cells' areas. Shape: `[polarization][component][y]`.
type Currents = [[Vec<Complex64>; COMPONENTS]; 2];

/// The far fields of a segment.
///
/// # Errors
/// The light is not over the segment, a window or wavelength is not positive, a medium's table does not reach the
/// wavelength, a crystal cannot be solved, or the user cancelled.
pub fn far_field(
    segment: &Segment,
    light: &SegmentLight,
    accuracy: &SegmentAccuracy,
    progress: &dyn Progress,
) -> Result<Hemisphere> {
    let grid = grid(segment, light, accuracy)?;
    let sampled = segment.sampled(grid, accuracy.parts)?;
    let incidence = Incidence::new(light);
    let reflector = Reflector::new(segment, &sampled, light, &incidence, accuracy.width, progress)?;
    radiate::radiate(&sampled, &reflector, &incidence, light, accuracy, progress)
}

/// What [`far_field`] takes on so many threads; the seconds within a factor of two.
///
/// # Errors
/// As [`far_field`], as far as that is known without its work.
pub fn cost(
    segment: &Segment,
    light: &SegmentLight,
    accuracy: &SegmentAccuracy,
    threads: usize,
) -> Result<Cost> {
    let grid = grid(segment, light, accuracy)?;
    let (bytes, radiating) = radiate::cost(&grid, segment.roughness, light, accuracy, threads)?;
    let places = (grid.cells[0] * grid.cells[1] * segment.roughened()) as f64;
    let orders = if segment.section.crystal.is_some() { CRYSTAL_S } else { 0.0 };
    Ok(Cost {
        bytes: bytes + segment.sampled_bytes(&grid, accuracy.parts),
        seconds: Some((radiating + PLACE_S * places + orders) / threads.max(1) as f64),
        ..Cost::default()
    })
}

/// The cells on which a segment is sampled.
///
/// # Errors
/// As [`far_field`].
pub fn grid(segment: &Segment, light: &SegmentLight, accuracy: &SegmentAccuracy) -> Result<SegmentGrid> {
    let SegmentLight { wavelength_nm, window_um, theta_i, phi_i, turn } = *light;
    if !(wavelength_nm > 0.0 && window_um.iter().all(|w| *w > 0.0)) {
        return Err(Error::input("the light on a segment needs a positive wavelength and positive windows"));
    }
    if omega(theta_i, phi_i).z <= 0.0 || !turn.is_finite() {
        return Err(Error::input("the light on a segment must come from above it"));
    }
    Ok(SegmentGrid::new(segment, accuracy.cells.map(|cells| cells * wavelength_nm * 1e-3)))
}

impl<'a> Reflector<'a> {
    fn new(
        segment: &'a Segment,
        sampled: &'a Sampled<'a>,
        light: &SegmentLight,
        incidence: &Incidence,
        width: Width,
        progress: &dyn Progress,
    ) -> Result<Self> {
        Ok(match &segment.section.crystal {
            None => Self::Layers(layered::Stacks::new(sampled, light.wavelength_nm, width)?),
            Some(layer) => Self::Crystal(crystal::Crystal::new(
                segment,
                layer,
                sampled,
                light.wavelength_nm,
                incidence,
                progress,
            )?),
        })
    }

    /// The currents along a line, and the power that falls on it, µm².
    fn currents(
        &self,
        incidence: &Incidence,
        line: &Line,
        room: &mut layered::Room,
        out: &mut Currents,
    ) -> f64 {
        match self {
            Self::Layers(stacks) => stacks.currents(incidence, line, room, out),
            Self::Crystal(crystal) => crystal.currents(incidence, line, out),
        }
    }
}
