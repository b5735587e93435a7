//! One barbule prepared for illumination: quadrature points on its top with what lies under each.

use num_complex::Complex64;

use super::reflection::{BLOCK, Incidence};
use crate::math::simd::Real;
use crate::scattering::far_field::Window;
use crate::spectrum::wave_number_per_um;
use crate::structure::{Columns, CrystalLayer, Lattice, Palette, Polyline, Ray, Section, SlotMixture, cast};
use crate::{Error, Result};

/// The quadrature points of one instance, which do not depend on wavelength and direction.
///
/// Each straight piece of the top is divided into elements of at most the given length with two Gauss points each;
/// arrays are padded to a multiple of 64 with points of no weight.
#[derive(Debug, Clone)]
pub(super) struct Points {
    /// What kernels read, in double precision.
    pub(super) double: Arrays<f64>,
    /// The same in single precision.
    pub(super) single: Arrays<f32>,
    /// g²·dl
    power_length_um: Vec<f64>,
    /// Arc length from the left end.
    pub(super) arc_um: Vec<f64>,
    /// Points before padding.
    pub(super) count: usize,
    /// Layers and substrate under a point, those of no thickness included.
    pub(super) slots: usize,
    pub(super) palette: Palette,
    mixtures: Vec<SlotMixture>,
    /// Corners of the top that turn by more than [`SMOOTH_TURN`]: first point after each, then `count`.
    pub(super) pieces: Vec<usize>,
    /// Largest distance of a point from the origin.
    pub(super) radius_um: f64,
    /// The crystal under the top.
    pub(super) lattice: Option<Lattice>,
}

/// Arrays over the quadrature points, padded.
#[derive(Debug, Clone, Default)]
pub(super) struct Arrays<T> {
    pub(super) x_um: Vec<T>,
    pub(super) z_um: Vec<T>,
    pub(super) tangent_x: Vec<T>,
    pub(super) tangent_z: Vec<T>,
    /// g·dl
    pub(super) window_length_um: Vec<T>,
    /// `[slot][point]`
    pub(super) thickness_um: Vec<T>,
    /// Over a crystal: the angle of the tangent against x, rad.
    pub(super) slope: Vec<T>,
    /// Over a crystal: the part of its period at which the point lies, 0 to 1.
    pub(super) lattice_turns: Vec<T>,
}

impl<T> Arrays<T> {
    fn bytes(&self) -> usize {
        let values = 5 * self.x_um.capacity()
            + self.thickness_um.capacity()
            + self.slope.capacity()
            + self.lattice_turns.capacity();
        values * size_of::<T>()
    }
}

impl Arrays<f64> {
    fn rounded(&self) -> Arrays<f32> {
        let round = |values: &[f64]| values.iter().map(|&v| v as f32).collect();
        Arrays {
            x_um: round(&self.x_um),
            z_um: round(&self.z_um),
            tangent_x: round(&self.tangent_x),
            tangent_z: round(&self.tangent_z),
            window_length_um: round(&self.window_length_um),
            thickness_um: round(&self.thickness_um),
            slope: round(&self.slope),
            lattice_turns: round(&self.lattice_turns),
        }
    }
}

/// The turn of the top at a vertex, rad, up to which the radiation kernel is interpolated across it.
const SMOOTH_TURN: f64 = 0.12;

/// Permittivities of one slot at one wavelength, less 1.
#[derive(Debug, Clone)]
pub(in crate::solve) enum SlotMedium<T> {
    Uniform(Complex64),
    Varying { re: Vec<T>, im: Vec<T> },
}

/// The points' media at one wavelength.
#[derive(Debug, Clone)]
pub(in crate::solve) struct Optics<T> {
    /// Vacuum wave number 2π/λ, rad/µm.
    pub(in crate::solve) k: f64,
    pub(in crate::solve) slots: Vec<SlotMedium<T>>,
}

impl Points {
    /// Prepares a section with elements of at most `element_um`.
    ///
    /// # Errors
    /// The light does not come through air, the top has no length, or something lies above it.
    pub(super) fn new(section: &Section, element_um: f64, window: Window) -> Result<Self> {
        Self::subdivided(section, element_um, 1, window, None)
    }

    /// Prepares a section with each element of at most `element_um` cut into `parts`. At a `place` (x, µm) the window stands there
    /// instead of on the middle, what lies farther from it than half the width is left out, and phases are counted from the
    /// middle of what is lit.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn subdivided(
        section: &Section,
        element_um: f64,
        parts: usize,
        window: Window,
        place: Option<f64>,
    ) -> Result<Self> {
        let center_um = place.unwrap_or(0.0);
        let farthest_um = place.map_or(f64::INFINITY, |_| 0.5 * section.width_um);
        section.check_lit_through_air()?;
        section.check_nothing_above_top()?;
        let top = section.top();
        let gauss = 0.5 / 3f64.sqrt();
        let mut rays = Vec::new();
        let (mut tangent_x, mut tangent_z) = (Vec::new(), Vec::new());
        let (mut window_length_um, mut power_length_um, mut arc_um) = (Vec::new(), Vec::new(), Vec::new());
        let mut pieces = Vec::new();
        let mut arc = 0.0;
        let mut before: Option<(f64, f64)> = None;
        for (x, z) in top.x_um.windows(2).zip(top.z_um.windows(2)) {
            let (dx, dz) = (x[1] - x[0], z[1] - z[0]);
            let length = dx.hypot(dz);
            let (tx, tz) = (dx / length, dz / length);
            if before.is_some_and(|(bx, bz)| (bx * tz - bz * tx).abs() > SMOOTH_TURN.sin())
                && pieces.last().copied().unwrap_or(0) < rays.len()
            {
                pieces.push(rays.len());
            }
            before = Some((tx, tz));
            if (x[0] - center_um).abs().max((x[1] - center_um).abs()) > farthest_um {
                arc += length;
                continue;
            }
            let elements = (length / element_um).ceil().max(1.0) as usize * parts;
            for element in 0..elements {
                for side in [-gauss, gauss] {
                    let t = (element as f64 + 0.5 + side) / elements as f64;
                    let (px, pz) = (x[0] + t * dx, z[0] + t * dz);
                    let weight = length / (2.0 * elements as f64);
                    let g = window.at(px - center_um, section.width_um);
                    rays.push(Ray { x_um: px, z_um: pz, normal: [-tz, tx] });
                    tangent_x.push(tx);
                    tangent_z.push(tz);
                    window_length_um.push(g * weight);
                    power_length_um.push(g * g * weight);
                    arc_um.push(arc + t * length);
                }
            }
            arc += length;
        }
        pieces.push(rays.len());
        let Columns { slots, thickness_um, mixture: mixtures, palette, .. } = cast(section, &rays)?;
        let double = Arrays {
            x_um: rays.iter().map(|ray| ray.x_um).collect(),
            z_um: rays.iter().map(|ray| ray.z_um).collect(),
            tangent_x,
            tangent_z,
            window_length_um,
            ..Arrays::default()
        };
        let mut points = Self {
            double,
            single: Arrays::default(),
            power_length_um,
            arc_um,
            count: rays.len(),
            slots,
            palette,
            mixtures,
            pieces,
            radius_um: 0.0,
            lattice: None,
        };
        if let Some(crystal) = &section.crystal {
            points.bury(crystal, top);
        }
        if place.is_some() {
            points.refer_to_middle();
        }
        points.radius_um =
            points.double.x_um.iter().zip(&points.double.z_um).fold(0.0, |r, (x, z)| x.hypot(*z).max(r));
        points.pad(&thickness_um)
    }

    /// Counts x and z from the middle of what is lit, so that phases do not turn with the direction more than they must.
    fn refer_to_middle(&mut self) {
        let total = self.power_length_um.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        for places in [&mut self.double.x_um, &mut self.double.z_um] {
            let middle = self.power_length_um.iter().zip(&*places).map(|(w, v)| w * v).sum::<f64>() / total;
            places.iter_mut().for_each(|place| *place -= middle);
        }
    }

    /// Adds what a crystal under the top says of each point.
    fn bury(&mut self, crystal: &CrystalLayer, top: &Polyline) {
        let arrays = &mut self.double;
        let origin = top.arc_at_zero(&top.arc_um()) + crystal.offset_um;
        let turns = |s: f64| ((s - origin) / crystal.lattice.period_um).rem_euclid(1.0);
        arrays.lattice_turns = self.arc_um.iter().map(|&s| turns(s)).collect();
        arrays.slope = arrays.tangent_x.iter().zip(&arrays.tangent_z).map(|(x, z)| z.atan2(*x)).collect();
        if let Some(regularity) = &crystal.regularity {
            // Of the reflected field alone: the incident power has its own weights.
            for (weight, x) in arrays.window_length_um.iter_mut().zip(&arrays.x_um) {
                *weight *= regularity.at(*x);
            }
        }
        self.lattice = Some(crystal.lattice.clone());
    }

    /// Repeats the last point without weight until the arrays fill whole blocks; `thickness` (µm) is `[slot][point]`.
    fn pad(mut self, thickness: &[f64]) -> Result<Self> {
        let Some(last) = self.count.checked_sub(1) else {
            return Err(Error::input("the top boundary has no length"));
        };
        let padded = self.count.next_multiple_of(BLOCK);
        let Arrays { x_um, z_um, tangent_x, tangent_z, window_length_um, thickness_um, slope, lattice_turns } =
            &mut self.double;
        if self.lattice.is_some() {
            for values in [slope, lattice_turns] {
                let value = values[last];
                values.resize(padded, value);
            }
        }
        for values in [x_um, z_um, tangent_x, tangent_z, &mut self.arc_um] {
            let value = values[last];
            values.resize(padded, value);
        }
        window_length_um.resize(padded, 0.0);
        thickness_um.reserve_exact(self.slots * padded);
        for row in thickness.chunks_exact(self.count) {
            thickness_um.extend_from_slice(row);
            thickness_um.resize(thickness_um.len() + padded - self.count, row[last]);
        }
        self.single = self.double.rounded();
        Ok(self)
    }

    /// What fills a slot at the points from `start` to before `end`, the last one repeated.
    pub(super) fn mixture(&self, slot: usize, start: usize, end: usize) -> SlotMixture {
        let points = (start..end).map(|point| point.min(self.count - 1));
        self.mixtures[slot].under(points, self.palette.materials.len())
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        let mixtures: usize = self.mixtures.iter().map(SlotMixture::bytes).sum();
        let lengths = (self.power_length_um.capacity() + self.arc_um.capacity()) * size_of::<f64>();
        self.double.bytes() + self.single.bytes() + lengths + mixtures
    }

    /// Points including padding.
    pub(super) fn padded(&self) -> usize {
        self.single.x_um.len()
    }

    /// The media at a vacuum wavelength.
    ///
    /// # Errors
    /// A table of a medium does not reach the wavelength.
    pub(super) fn optics<T: Real>(&self, wavelength_nm: f64) -> Result<Optics<T>> {
        let indices = self.palette.indices(wavelength_nm)?;
        let padded = self.padded();
        let slots = self
            .mixtures
            .iter()
            .map(|slot| match slot {
                SlotMixture::Uniform(mixture) => SlotMedium::Uniform(mixture.contrast(&indices)),
                varying => {
                    let values = (0..self.count).map(|point| varying.contrast(point, &indices));
                    let (mut re, mut im): (Vec<T>, Vec<T>) =
                        values.map(|value| (T::of(value.re), T::of(value.im))).unzip();
                    re.resize(padded, re[self.count - 1]);
                    im.resize(padded, im[self.count - 1]);
                    SlotMedium::Varying { re, im }
                }
            })
            .collect();
        Ok(Optics { k: wave_number_per_um(wavelength_nm), slots })
    }

    /// Φ_i = ∫ g² max(0, n·ω_i) dl, the incident power per length for unit |E| and c₀ = 1, µm.
    pub(super) fn incident_power_um(&self, theta_i: f64, phi_i: f64) -> f64 {
        let incidence = Incidence::new(theta_i, phi_i);
        (0..self.count)
            .map(|p| {
                self.power_length_um[p]
                    * incidence.cos_alpha(self.double.tangent_x[p], self.double.tangent_z[p]).max(0.0)
            })
            .sum()
    }
}
