//! A feather's tables as two textures and a header, for `shaders/feather.wgsl`.
//!
//! All of [`BrdfTables`] that values need, in texels of four numbers, one section after another in rows of [`WIDTH`]:
//!
//! | section | texels | numbers |
//! | --- | --- | --- |
//! | cosθ_i | Θ | `theta`, C |
//! | v_i | Φ | `phi`, T |
//! | λ | Λ | `wavelengths_nm` |
//! | slopes | Θ Φ | κ, g, 1/l |
//! | 1/Q | 4097 | of each Gaussian |
//! | rotations | 1024 | cosine, sine, and of the first 256 E of `wings` |
//! | nodes | 5 Θ Φ Λ for each set | the sixteen numbers; ρ, h₁, h₂, h₃ |
//!
//! The noise's codes are whole numbers, and so a texture of their own, of two texels a point.

use std::collections::BTreeMap;

use barbule_appearance::brdf::{BrdfTables, NOISE_SLICE, Numbers, Reciprocity, TablesHeader};
use barbule_base::math::rng::split_mix;
use barbule_light::scattering::far_field::Polarization;
use barbule_light::scattering::lobe::FitKind;
use barbule_light::scattering::statistics::Sides;
use bytemuck::{Pod, Zeroable};

use super::device::{Gpu, NUMBERS, UNIFORM, texture_type};
use crate::{Error, Result};

/// Texels of a row: what every adapter has, under WebGL2 too. The shader divides by it with shifts.
pub(super) const WIDTH: u32 = 2048;
/// Texels of a node.
const NODE_TEXELS: usize = 5;

/// `FeatherHeader` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Header {
    sizes: [u32; 4],
    starts: [u32; 4],
    more: [u32; 4],
    flags: [u32; 4],
    spreads: [f32; 4],
    noise: [f32; 4],
    name: [u32; 4],
}

/// A feather's tables in the order in which textures hold them.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedTables {
    header: Header,
    numbers: Vec<[f32; 4]>,
    codes: Vec<[i16; 4]>,
    wavelengths_nm: Vec<f64>,
}

/// A feather's tables on the graphics card.
#[derive(Debug, Clone)]
pub struct Feather {
    group: wgpu::BindGroup,
}

/// First texels of the sections, in their order, and how many there are in all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Sections {
    theta: usize,
    phi: usize,
    waves: usize,
    slopes: usize,
    inverse_q: usize,
    rotations: usize,
    nodes: usize,
    end: usize,
}

impl Sections {
    fn new(header: &TablesHeader, inverse_q: usize, rotations: usize) -> Self {
        let cells = header.thetas * header.phis;
        let (phi, waves) = (header.thetas, header.thetas + header.phis);
        let slopes = waves + header.waves;
        let first_q = slopes + cells;
        let first_rotation = first_q + inverse_q;
        let nodes = first_rotation + rotations;
        let end = nodes + header.sets * cells * header.waves * NODE_TEXELS;
        Self { theta: 0, phi, waves, slopes, inverse_q: first_q, rotations: first_rotation, nodes, end }
    }
}

/// Arrays by their names, in single precision.
struct Named(BTreeMap<String, Vec<f32>>);

impl Named {
    fn get(&self, name: &str) -> Result<&[f32]> {
        self.0.get(name).map(Vec::as_slice).ok_or_else(|| {
            Error::input(format!("array {name} is missing; make the tables again from the material"))
        })
    }

    fn of_set(&self, header: &TablesHeader, set: usize, name: &str) -> Result<&[f32]> {
        if header.sets == 1 { self.get(name) } else { self.get(&format!("p{}.{name}", set + 1)) }
    }
}

impl PackedTables {
    /// Packs tables for textures of at most `most_rows` rows ([`Gpu::most_texels_along`]).
    ///
    /// # Errors
    /// They have more rows.
    pub fn new(tables: &BrdfTables, most_rows: u32) -> Result<Self> {
        let header = tables.header();
        let (mut named, mut codes) = (BTreeMap::new(), Vec::new());
        for array in tables.arrays() {
            let floats = match array.numbers {
                Numbers::F64(values) => values.iter().map(|v| *v as f32).collect(),
                Numbers::F32(values) => values.to_vec(),
                Numbers::I16(values) => {
                    codes = values.as_chunks().0.to_vec();
                    continue;
                }
            };
            named.insert(array.name, floats);
        }
        let named = Named(named);
        let gaussians = 1 + header.halo.iter().filter(|sigma| **sigma > 0.0).count();
        let [rows_of_q, rotations] =
            [named.get("inverse_q")?.len() / gaussians, named.get("rotations")?.len() / 2];
        let sections = Sections::new(&header, rows_of_q, rotations);
        let rows = sections.end.max(codes.len()).div_ceil(WIDTH as usize);
        if rows > most_rows as usize {
            return Err(Error::input(format!(
                "the material's tables are a texture of {WIDTH} × {rows} texels, but this graphics adapter has {most_rows} rows at most; make the material with fewer directions or wavelengths"
            )));
        }
        let numbers = numbers(&header, &named, gaussians)?;
        debug_assert_eq!(numbers.len(), sections.end);
        let wavelengths = tables.arrays().into_iter().find(|array| array.name == "wavelengths_nm");
        let wavelengths_nm = match wavelengths.map(|array| array.numbers) {
            Some(Numbers::F64(nm)) => nm.to_vec(),
            _ => Vec::new(),
        };
        let loss = 1.0 - named.get("autocovariance")?.get(1).copied().unwrap_or(1.0);
        Ok(Self { header: packed(&header, sections, gaussians, loss), numbers, codes, wavelengths_nm })
    }

    /// What the textures hold, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.numbers.as_slice()) + size_of_val(self.codes.as_slice())
    }

    /// The tables' own wavelengths, nm.
    #[must_use]
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }
}

/// All sections.
fn numbers(header: &TablesHeader, named: &Named, gaussians: usize) -> Result<Vec<[f32; 4]>> {
    let pairs = |first: &str, second: &str| -> Result<Vec<[f32; 4]>> {
        let both = named.get(first)?.iter().zip(named.get(second)?);
        Ok(both.map(|(a, b)| [*a, *b, 0.0, 0.0]).collect())
    };
    let mut all = pairs("theta", "cos_theta")?;
    all.extend(pairs("phi", "tangents")?);
    all.extend(named.get("wavelengths_nm")?.iter().map(|nm| [*nm, 0.0, 0.0, 0.0]));
    all.extend(named.get("slopes")?.as_chunks::<3>().0.iter().map(|[kappa, g, l]| [*kappa, *g, *l, 0.0]));
    let of_q = |row: &[f32]| std::array::from_fn(|part| row.get(part).copied().unwrap_or(0.0));
    all.extend(named.get("inverse_q")?.chunks_exact(gaussians).map(of_q));
    let wings = named.get("wings")?;
    let rotations = named.get("rotations")?.as_chunks::<2>().0.iter().enumerate();
    all.extend(rotations.map(|(k, [c, s])| [*c, *s, wings.get(k).copied().unwrap_or(0.0), 0.0]));
    let along = if gaussians > 1 { named.get("along")?.as_chunks::<4>().0 } else { &[] };
    for set in 0..header.sets {
        let nodes = named.of_set(header, set, "nodes")?.as_chunks::<16>().0;
        let reflected = named.of_set(header, set, "reflected")?;
        for (at, (node, reflected)) in nodes.iter().zip(reflected).enumerate() {
            all.extend_from_slice(node.as_chunks().0);
            let [_, h1, h2, h3] = along.get(at).copied().unwrap_or([1.0, 0.0, 0.0, 0.0]);
            all.push([*reflected, h1, h2, h3]);
        }
    }
    Ok(all)
}

/// The header; `loss` is 1 − C₁.
fn packed(header: &TablesHeader, sections: Sections, gaussians: usize, loss: f32) -> Header {
    let polarization = match header.polarization {
        None => 0,
        Some(Polarization::First) => 1,
        Some(Polarization::Second) => 2,
    };
    let reciprocity = match header.reciprocity {
        Reciprocity::AsFitted => 0,
        Reciprocity::Steeper => 1,
        Reciprocity::Mean => 2,
    };
    let [h1, h2, h3] = header.halo;
    let spread = |sigma: f64| if sigma > 0.0 { (-1.0 / (sigma * sigma)) as f32 } else { 0.0 };
    // In the order of a name's hash: the seed's own.
    let seed = split_mix(header.seed);
    let achromatic = (65_536.0 * header.spectral.achromatic).ceil() as u32;
    let texels = header.thetas * header.phis * header.waves * NODE_TEXELS;
    let whole = |places: [usize; 4]| places.map(|place| place as u32);
    Header {
        sizes: whole([header.thetas, header.phis, header.waves, header.sets]),
        starts: whole([sections.theta, sections.phi, sections.waves, sections.slopes]),
        more: whole([sections.inverse_q, sections.rotations, sections.nodes, texels]),
        flags: [
            u32::from(header.kind == FitKind::Marginal),
            u32::from(header.sides == Sides::Alike),
            reciprocity,
            polarization,
        ],
        spreads: [header.sigma, h1, h2, h3].map(spread),
        noise: [(header.spectral.height_um / NOISE_SLICE) as f32, loss, gaussians as f32, 0.0],
        name: [seed as u32, (seed >> 32) as u32, achromatic, 0],
    }
}

impl Feather {
    /// The layout of the group that a material is: group 1 of every shader that draws one.
    #[must_use]
    pub fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
        gpu.layout("feather", &[UNIFORM, texture_type(NUMBERS), texture_type(wgpu::TextureSampleType::Sint)])
    }

    /// Uploads tables.
    ///
    /// # Errors
    /// The adapter has too little memory.
    pub fn new(gpu: &Gpu, tables: &PackedTables) -> Result<Self> {
        let group = gpu.checked("a feather's tables", || {
            let header = gpu.uniform("feather header", bytemuck::bytes_of(&tables.header));
            let float = wgpu::TextureFormat::Rgba32Float;
            let numbers = gpu.texture("feather numbers", float, WIDTH, &tables.numbers);
            let codes = gpu.texture("feather codes", wgpu::TextureFormat::Rgba16Sint, WIDTH, &tables.codes);
            gpu.bound(
                "feather",
                &Self::layout(gpu),
                &[
                    header.as_entire_binding(),
                    wgpu::BindingResource::TextureView(&numbers),
                    wgpu::BindingResource::TextureView(&codes),
                ],
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
    use barbule_appearance::brdf::fixtures::{example, halo};
    use barbule_appearance::brdf::{FeatherMaterial, Options};

    use super::*;

    fn tables() -> BrdfTables {
        BrdfTables::new(&FeatherMaterial { halo: Some(halo()), ..example(3) }, Options::default()).unwrap()
    }

    #[test]
    fn sections_hold_what_the_header_says() {
        let tables = tables();
        let packed = PackedTables::new(&tables, 2048).unwrap();
        let (header, plain) = (packed.header, tables.header());
        let at = |section: u32, k: usize| packed.numbers[section as usize + k];
        let floats = |name: &str| {
            let array = tables.arrays().into_iter().find(|array| array.name == name).unwrap();
            match array.numbers {
                Numbers::F32(values) => values.to_vec(),
                Numbers::F64(values) => values.iter().map(|v| *v as f32).collect(),
                Numbers::I16(values) => values.iter().map(|v| f32::from(*v)).collect(),
            }
        };
        assert_eq!(at(header.starts[0], 1)[..2], [floats("theta")[1], floats("cos_theta")[1]]);
        assert_eq!(at(header.starts[1], 2)[..2], [floats("phi")[2], floats("tangents")[2]]);
        assert_eq!(at(header.starts[2], 1)[0], floats("wavelengths_nm")[1]);
        assert_eq!(at(header.starts[3], 4)[..3], floats("slopes")[12..15]);
        let gaussians = header.noise[2] as usize;
        assert_eq!(at(header.more[0], 4096)[..gaussians], floats("inverse_q")[4096 * gaussians..]);
        assert_eq!(
            at(header.more[1], 255)[..3],
            [floats("rotations")[510], floats("rotations")[511], floats("wings")[255]]
        );
        let last = plain.thetas * plain.phis * plain.waves - 1;
        let node = header.more[2] as usize + 5 * last;
        assert_eq!(packed.numbers[node + 3], floats("nodes")[16 * last + 12..]);
        assert_eq!(packed.numbers[node + 4][1..], floats("along")[4 * last + 1..]);
        assert_eq!(packed.numbers[node + 4][0], floats("reflected")[last]);
        assert_eq!(packed.numbers.len(), node + 5);
        assert_eq!(packed.codes[3].map(f32::from)[..], floats("codes")[12..16]);
    }

    #[test]
    fn tables_beyond_the_adapter_are_refused_in_one_sentence() {
        let refused = PackedTables::new(&tables(), 8).unwrap_err().to_string();
        assert_eq!(
            refused,
            "the material's tables are a texture of 2048 × 65 texels, but this graphics adapter has 8 rows at most; make the material with fewer directions or wavelengths"
        );
    }
}
