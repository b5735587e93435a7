//! Layers on a rough surface as a texture and a header, for `shaders/layers.wgsl`: what they reflect by wavelength and angle, and what
//! facets make of it.

use std::f64::consts::TAU;

use bytemuck::{Pod, Zeroable};

use super::device::{Gpu, NUMBERS, UNIFORM, texture_type};
use super::tables::WIDTH;
use crate::{Error, Result};

/// Steps of the cosine in tables of the albedo.
const ALBEDO_STEPS: usize = 32;
/// Facets that are summed for it: rings, and facets of a ring.
const RINGS: usize = 20;
const FACETS: usize = 40;
/// The least cosine for which anything is asked: films have no answer at 90°.
const LEAST_COSINE: f64 = 1e-3;

/// What layers reflect of unpolarized light.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflected {
    /// Vacuum wavelengths, nm, rising.
    pub nm: Vec<f64>,
    /// Steps of the cosine of the angle of incidence, from 0 to 1.
    pub steps: usize,
    /// Shape: `[wavelength, steps + 1]`, row-major.
    pub values: Vec<f32>,
}

/// `LayersHeader` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Header {
    how: [f32; 4],
    sizes: [u32; 4],
}

/// Layers in the order in which the texture holds their numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedLayers {
    header: Header,
    numbers: Vec<f32>,
    nm: Vec<f64>,
}

/// Layers on the graphics card.
#[derive(Debug, Clone)]
pub struct Layers {
    group: wgpu::BindGroup,
}

impl Reflected {
    /// Steps of the cosine with which multilayers of some µm are right to 1e-3 of their peak from 0 to 84°.
    pub const STEPS: usize = 512;

    /// The angles of the steps, rad, from 90° (just under) to 0.
    #[must_use]
    pub fn angles(steps: usize) -> Vec<f64> {
        (0..=steps).map(|step| (step as f64 / steps as f64).max(LEAST_COSINE).acos()).collect()
    }
}

impl PackedLayers {
    /// Packs what layers reflect, on facets of GGX α `roughness`, 0.02 to 1.
    ///
    /// # Errors
    /// A roughness out of range, or values that do not fit their wavelengths and steps.
    pub fn new(reflected: &Reflected, roughness: f64) -> Result<Self> {
        let Reflected { nm, steps, values } = reflected;
        if !(0.02..=1.0).contains(&roughness) {
            return Err(Error::input(format!("layers of roughness {roughness}; give 0.02 to 1")));
        }
        if *steps == 0 || values.len() != nm.len() * (steps + 1) {
            return Err(Error::machine(format!(
                "{} values do not fit {} wavelengths and {steps} steps of the angle",
                values.len(),
                nm.len()
            )));
        }
        let mut numbers = values.clone();
        let albedos: Vec<Vec<f32>> = (0..=ALBEDO_STEPS)
            .map(|step| {
                let cosine = (step as f64 / ALBEDO_STEPS as f64).max(LEAST_COSINE);
                albedo(reflected, cosine, roughness)
            })
            .collect();
        numbers.extend((0..nm.len()).flat_map(|wave| albedos.iter().map(move |of| of[wave])));
        let sizes = [*steps, ALBEDO_STEPS, values.len(), 0].map(|size| size as u32);
        Ok(Self { header: Header { how: [roughness as f32, 0.0, 0.0, 0.0], sizes }, numbers, nm: nm.clone() })
    }

    /// What the texture holds, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.numbers.as_slice())
    }

    /// The tables' own wavelengths, nm.
    #[must_use]
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.nm
    }
}

/// What all facets together reflect of light at an angle, by wavelength: the mean over the facets that are seen (Heitz 2018, whose
/// projected hemisphere is gone over in rings of equal area) of R and of what is not hidden on its way out.
fn albedo(reflected: &Reflected, cosine: f64, alpha: f64) -> Vec<f32> {
    let columns = reflected.steps + 1;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let hidden = |z: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 / (z * z) - 1.0)).max(1.0).sqrt() - 1.0);
    // Towards the light, with the surface stretched so that its facets are a hemisphere.
    let stretched = (alpha * sine).hypot(cosine);
    let (x, z) = (alpha * sine / stretched, cosine / stretched);
    let mut sum = vec![0.0; reflected.nm.len()];
    for (ring, facet) in (0..RINGS).flat_map(|ring| (0..FACETS).map(move |facet| (ring, facet))) {
        let radius = ((ring as f64 + 0.5) / RINGS as f64).sqrt();
        let (sin, cos) = (TAU * (facet as f64 + 0.5) / FACETS as f64).sin_cos();
        let across = radius * cos;
        // The lower half of the disc is where the hemisphere is seen from aside.
        let share = 0.5 * (1.0 + z);
        let edge = (1.0 - across * across).max(0.0).sqrt();
        let along = (1.0 - share) * edge + share * radius * sin;
        let up = (1.0 - across * across - along * along).max(0.0).sqrt();
        // Axes: (0, 1, 0) and (−z, 0, x) beside (x, 0, z).
        let normal = [alpha * (up * x - along * z), alpha * across, (up * z + along * x).max(1e-9)];
        let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
        let h = normal.map(|v| v / length);
        let at_facet = sine * h[0] + cosine * h[2];
        let out = 2.0 * at_facet * h[2] - cosine;
        if at_facet <= 0.0 || out <= 0.0 {
            continue;
        }
        let seen = (1.0 + hidden(cosine)) / (1.0 + hidden(cosine) + hidden(out));
        let place = at_facet.min(1.0) * reflected.steps as f64;
        let below = (place as usize).min(reflected.steps - 1);
        let part = (place - below as f64) as f32;
        for (sum, row) in sum.iter_mut().zip(reflected.values.chunks_exact(columns)) {
            *sum += seen as f32 * (row[below] + (row[below + 1] - row[below]) * part);
        }
    }
    sum.into_iter().map(|sum| sum / (RINGS * FACETS) as f32).collect()
}

impl Layers {
    /// The layout of the group that layers are: group 1 of every shader that draws some.
    #[must_use]
    pub fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
        gpu.layout("layers", &[UNIFORM, texture_type(NUMBERS)])
    }

    /// Uploads tables.
    ///
    /// # Errors
    /// The adapter has too little memory.
    pub fn new(gpu: &Gpu, packed: &PackedLayers) -> Result<Self> {
        let group = gpu.checked("the layers' tables", || {
            let header = gpu.uniform("layers header", bytemuck::bytes_of(&packed.header));
            let numbers = gpu.texture("layers", wgpu::TextureFormat::R32Float, WIDTH, &packed.numbers);
            gpu.bound(
                "layers",
                &Self::layout(gpu),
                &[header.as_entire_binding(), wgpu::BindingResource::TextureView(&numbers)],
            )
        })?;
        Ok(Self { group })
    }

    /// What a pass binds as its group 1.
    #[must_use]
    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn white(steps: usize) -> Reflected {
        Reflected { nm: vec![500.0, 600.0], steps, values: vec![1.0; 2 * (steps + 1)] }
    }

    /// What single scattering by perfect mirrors keeps: nearly all on smooth surfaces. Of the facets that are seen along the normal the
    /// share α²/(1 + α²) is steeper than 45° and sends light downwards; some of the rest is hidden.
    #[test]
    fn mirrors_lose_only_what_they_hide() {
        let of = |cosine: f64, alpha: f64| f64::from(albedo(&white(8), cosine, alpha)[0]);
        assert!((of(1.0, 0.02) - 1.0).abs() < 1e-3 && (of(0.5, 0.02) - 1.0).abs() < 2e-3);
        let upwards = 1.0 - 0.25 / 1.25;
        assert!((0.8 * upwards..upwards).contains(&of(1.0, 0.5)), "{}", of(1.0, 0.5));
        assert!(of(0.2, 0.5) < 1.0);
    }

    /// Against the integral of f over the hemisphere, on even steps of the slope's plane.
    #[test]
    fn the_albedo_is_the_integral_of_f() {
        let (alpha, cosine) = (0.3_f64, 0.6_f64);
        let mut reflected = white(16);
        for (k, value) in reflected.values.iter_mut().enumerate() {
            *value = 0.2 + 0.04 * (k % 17) as f32;
        }
        let found = f64::from(albedo(&reflected, cosine, alpha)[0]);
        let sine = (1.0 - cosine * cosine).sqrt();
        let hidden = |z: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 / (z * z) - 1.0)).sqrt() - 1.0);
        let (polar, around) = (400, 400);
        let mut sum = 0.0;
        for (i, j) in (0..polar).flat_map(|i| (0..around).map(move |j| (i, j))) {
            let (z, turn) = ((i as f64 + 0.5) / polar as f64, TAU * (j as f64 + 0.5) / around as f64);
            let r = (1.0 - z * z).sqrt();
            let half = [sine + r * turn.cos(), r * turn.sin(), cosine + z];
            let length = half.iter().map(|v| v * v).sum::<f64>().sqrt();
            let h = half.map(|v| v / length);
            let t = (h[0] * h[0] + h[1] * h[1]) / (alpha * alpha) + h[2] * h[2];
            let d = 1.0 / (PI * alpha * alpha * t * t);
            let at_facet = sine * h[0] + cosine * h[2];
            let share = 0.2 + 0.04 * 16.0 * at_facet;
            let f = share * d / (4.0 * cosine * z * (1.0 + hidden(cosine) + hidden(z)));
            sum += f * z * TAU / (polar * around) as f64;
        }
        assert!((found / sum - 1.0).abs() < 3e-3, "{found} {sum}");
    }

    #[test]
    fn tables_that_do_not_fit_are_refused() {
        let refused =
            |reflected: &Reflected, alpha| PackedLayers::new(reflected, alpha).unwrap_err().to_string();
        assert!(refused(&white(8), 0.0).contains("roughness 0; give 0.02 to 1"));
        let short = Reflected { values: vec![0.0; 3], ..white(8) };
        assert!(refused(&short, 0.1).contains("3 values do not fit 2 wavelengths and 8 steps"));
    }
}
