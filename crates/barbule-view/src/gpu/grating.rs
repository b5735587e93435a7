//! A diffraction grating's tables as a texture and a header, for `shaders/grating.wgsl`.
//!
//! All of [`GratingTables`] in texels of four numbers, one section after another in rows of [`WIDTH`]: the series of the
//! places, four terms a texel; ρ; the pigment, one value per nm from 300 to 830.

use barbule_appearance::bsdf;
use barbule_appearance::bsdf::GratingTables;
use barbule_light::fresnel::fresnel;
use bytemuck::{Pod, Zeroable};

use super::device::{Gpu, NUMBERS, UNIFORM, texture_type};
use super::tables::WIDTH;
use crate::{Error, Result};

/// Terms that the shader reads: as many as the renderer admits.
const MOST_TERMS: usize = 64;

/// `GratingHeader` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Header {
    places: [u32; 4],
    starts: [u32; 4],
    steps: [f32; 4],
    optics: [f32; 4],
    rho: [f32; 4],
    mean: [f32; 4],
}

/// A grating's tables in the order in which the texture holds them.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedGrating {
    header: Header,
    numbers: Vec<[f32; 4]>,
}

/// A grating on the graphics card.
#[derive(Debug, Clone)]
pub struct Grating {
    group: wgpu::BindGroup,
}

impl PackedGrating {
    /// Packs tables for textures of at most `most_rows` rows ([`Gpu::most_texels_along`]).
    ///
    /// # Errors
    /// They have more rows, or more terms than 64.
    pub fn new(grating: &bsdf::Grating, most_rows: u32) -> Result<Self> {
        let tables = grating.tables();
        let quads = tables.terms.div_ceil(4);
        let places = tables.series.len() / tables.terms;
        let pigment = tables.pigment.values();
        let texels = places * quads + tables.rho.len() + pigment.len();
        let rows = texels.div_ceil(WIDTH as usize);
        if tables.terms > MOST_TERMS {
            return Err(Error::input(format!(
                "the grating has {} terms, but {MOST_TERMS} at most are shown; give heights that differ less",
                tables.terms
            )));
        }
        if rows > most_rows as usize {
            return Err(Error::input(format!(
                "the grating's tables are a texture of {WIDTH} × {rows} texels, but this graphics adapter has {most_rows} rows at most; give a smaller patch"
            )));
        }
        let mut numbers = Vec::with_capacity(texels);
        for series in tables.series.chunks_exact(tables.terms) {
            numbers.extend(series.chunks(4).map(|four| {
                let term = |k: usize| four.get(k).copied().unwrap_or(0.0);
                [term(0), term(1), term(2), term(3)]
            }));
        }
        let starts = [numbers.len(), numbers.len() + tables.rho.len()];
        numbers.extend(tables.rho.iter().map(|rho| [*rho, 0.0, 0.0, 0.0]));
        numbers.extend(pigment.iter().map(|value| [*value as f32, 0.0, 0.0, 0.0]));
        Ok(Self { header: packed(&tables, quads, starts), numbers })
    }

    /// What the texture holds, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.numbers.as_slice())
    }
}

/// The header; `starts` are the first texels of ρ and of the pigment.
fn packed(tables: &GratingTables<'_>, quads: usize, starts: [usize; 2]) -> Header {
    let [waves, cosines, azimuths] = tables.rho_shape;
    let whole = |places: [usize; 4]| places.map(|place| place as u32);
    let [x, y] = tables.step_per_um;
    let deviation = |step: f64| tables.deviation_per_um.map_or(0.0, |deviation| deviation / step);
    let band = bsdf::Grating::BAND;
    let between = band.width_nm() / (waves - 1) as f64;
    let single = |numbers: [f64; 4]| numbers.map(|v| v as f32);
    Header {
        places: whole([tables.most[0], tables.most[1], quads, tables.terms]),
        starts: whole([starts[0], starts[1], azimuths, cosines]),
        steps: single([1.0 / x, 1.0 / y, deviation(x), deviation(y)]),
        optics: single([2.0 / tables.kappa_most_per_um, tables.scale, tables.index, tables.reach]),
        rho: single([tables.lowest, band.low_nm(), between, waves as f64]),
        mean: single([mean_reflectance(tables.index), 0.0, 0.0, 0.0]),
    }
}

/// ∫ R(θ) 2 cosθ sinθ dθ of a boundary, by the midpoint rule: what it reflects of even light.
fn mean_reflectance(index: f64) -> f64 {
    let steps = 1000;
    let term = |k: i32| {
        let cosine = (f64::from(k) + 0.5) / f64::from(steps);
        2.0 * cosine * fresnel(cosine, index)
    };
    (0..steps).map(term).sum::<f64>() / f64::from(steps)
}

impl Grating {
    /// The layout of the group that a grating is: group 1 of every shader that draws one.
    #[must_use]
    pub fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
        gpu.layout("grating", &[UNIFORM, texture_type(NUMBERS)])
    }

    /// Uploads tables.
    ///
    /// # Errors
    /// The adapter has too little memory.
    pub fn new(gpu: &Gpu, tables: &PackedGrating) -> Result<Self> {
        let group = gpu.checked("a grating's tables", || {
            let header = gpu.uniform("grating header", bytemuck::bytes_of(&tables.header));
            let format = wgpu::TextureFormat::Rgba32Float;
            let numbers = gpu.texture("grating numbers", format, WIDTH, &tables.numbers);
            gpu.bound(
                "grating",
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

    /// Of n = 1.5: 0.0918, as tables of diffuse reflectance have it.
    #[test]
    fn a_boundary_reflects_nine_hundredths_of_even_light() {
        assert!((mean_reflectance(1.5) - 0.0918).abs() < 1e-4, "{}", mean_reflectance(1.5));
    }
}
