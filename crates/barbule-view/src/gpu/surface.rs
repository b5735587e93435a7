//! Meshes under a lamp and an even sky: `shaders/surface.wgsl` and those that go with it.

use barbule_appearance::bsdf;
use barbule_light::spectrum::Wavelengths;
use barbule_light::spectrum::colour::Observer;
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

use super::colour::WavesOnGpu;
use super::device::{Gpu, UNIFORM};
use super::film::{DEPTH, Film, LIGHT, SAMPLES};
use super::grating::Grating;
use super::shaders::{FEATHER, GRATING, KERATIN, SURFACE, SURFACE_FEATHER, SURFACE_GRATING, WAVES};
use super::tables::Feather;
use crate::{Error, Result};

/// Bytes of a corner.
const CORNER: u64 = 64;

/// What corners hold, in their order: position, normal and tangent (three numbers each), place (two), slope and half width,
/// part, and the two words of the name.
const ATTRIBUTES: [wgpu::VertexAttribute; 7] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x2, 4 => Float32x2, 5 => Uint32, 6 => Uint32x2,
];

/// A mesh on the graphics card.
#[derive(Debug, Clone)]
pub struct Mesh {
    corners: wgpu::Buffer,
    triangles: wgpu::Buffer,
    count: u32,
}

impl Mesh {
    /// - `corners`: of 64 bytes each, position (mm), unit normal and unit tangent along the barbule, place on it, slope at the ends
    ///   of its cells (rad), half its width (mm), all single precision; then its part and the low and the high word of its name
    /// - `triangles`: numbers of corners, counter-clockwise seen from the upper side
    ///
    /// # Errors
    /// Bytes that are not whole corners, a corner that does not exist, or too little memory.
    pub fn new(gpu: &Gpu, corners: &[u8], triangles: &[[u32; 3]]) -> Result<Self> {
        let count = corners.len() as u64 / CORNER;
        if corners.len() as u64 % CORNER != 0 {
            return Err(Error::machine(format!(
                "the mesh is not drawn: its corners have {} bytes, not {CORNER} each",
                corners.len()
            )));
        }
        if let Some(corner) = triangles.iter().flatten().find(|corner| u64::from(**corner) >= count) {
            return Err(Error::machine(format!(
                "the mesh is not drawn: corner {corner} of {count} does not exist"
            )));
        }
        gpu.checked("a mesh", || {
            let buffer = |label: &str, bytes: &[u8], usage: wgpu::BufferUsages| {
                let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: (bytes.len() as u64).max(4),
                    usage: usage | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                gpu.queue().write_buffer(&buffer, 0, bytes);
                buffer
            };
            Self {
                corners: buffer("corners", corners, wgpu::BufferUsages::VERTEX),
                triangles: buffer("triangles", bytemuck::cast_slice(triangles), wgpu::BufferUsages::INDEX),
                count: 3 * triangles.len() as u32,
            }
        })
    }
}

/// Whence individuals' names follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cells {
    /// Places are along barbules in cells, and across.
    OfRibbons,
    /// Places are texture coordinates of a surface on which barbules lie like this.
    Clad(bsdf::Layout),
}

/// Light and eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From the scene, mm, to the picture: x and y within ±1, depth from 0 to 1.
    pub clip_from_scene: Mat4,
    /// Where the eye is, mm; or the unit vector towards one that is infinitely far.
    pub eye: Eye,
    /// Unit vector towards the lamp.
    pub to_lamp: Vec3,
    /// Irradiance of the lamp over π: what a white surface that faces it shines.
    pub lamp: f32,
    /// Linear sRGB of the sky's radiance.
    pub sky: [f32; 3],
    /// Share of the contrast of individuals that is shown: 0 for the smooth mean, 1 for all.
    pub contrast: f32,
    /// How individuals are named.
    pub cells: Cells,
}

/// Where one looks from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Eye {
    /// A place, mm.
    At(Vec3),
    /// A direction, of length 1.
    Towards(Vec3),
}

/// `View` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct ViewUniform {
    clip_from_scene: [[f32; 4]; 4],
    eye: [f32; 4],
    lamp: [f32; 4],
    sky: [f32; 4],
    barbules: [f32; 4],
    cells: [f32; 4],
}

impl View {
    fn uniform(&self) -> ViewUniform {
        let (eye, far) = match self.eye {
            Eye::At(place) => (place, 1.0),
            Eye::Towards(direction) => (direction, 0.0),
        };
        let [r, g, b] = self.sky;
        let (barbules, cells) = match self.cells {
            Cells::OfRibbons => ([0.0; 4], [0.0; 4]),
            Cells::Clad(layout) => {
                let [u, v] = layout.uv_mm;
                let barbules = [u, v, layout.width_mm, layout.length_mm].map(|length| length as f32);
                (barbules, [layout.cell_mm as f32, layout.swelling as f32, 1.0, 0.0])
            }
        };
        ViewUniform {
            clip_from_scene: self.clip_from_scene.to_cols_array_2d(),
            eye: eye.extend(far).into(),
            lamp: self.to_lamp.extend(self.lamp).into(),
            sky: [r, g, b, self.contrast],
            barbules,
            cells,
        }
    }
}

/// `Keratin` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct KeratinUniform {
    body: [f32; 4],
    optics: [f32; 4],
    albedo: [[f32; 4]; 9],
}

impl KeratinUniform {
    fn new(keratin: &bsdf::Keratin, observer: Observer) -> Result<Self> {
        let wavelengths = Wavelengths::new((360..=830).map(f64::from).collect::<Vec<_>>())?;
        let body: Vec<f64> = wavelengths.nm().iter().map(|nm| keratin.body().at(*nm)).collect();
        let [r, g, b] = observer.weights(&wavelengths).linear_rgb(&body).map(|v| v as f32);
        let (boundary, mean) = keratin.boundary();
        let mut albedo = [[0.0; 4]; 9];
        for (place, value) in albedo.as_flattened_mut().iter_mut().zip(boundary) {
            *place = *value as f32;
        }
        let optics = [keratin.roughness() as f32, keratin.index() as f32, mean as f32, 0.0];
        Ok(Self { body: [r, g, b, 0.0], optics, albedo })
    }
}

/// What is beside the barbules' BRDF.
#[derive(Debug, Clone, Copy)]
pub struct Dress<'a> {
    /// How barbules differ from place to place.
    pub cells: bsdf::Cells,
    /// Their undersides, and the walls between cells.
    pub under: &'a bsdf::Keratin,
    /// Rami.
    pub ramus: &'a bsdf::Keratin,
    /// Shafts.
    pub shaft: &'a bsdf::Keratin,
}

/// `Dress` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct DressUniform {
    keratins: [KeratinUniform; 3],
    cells: [f32; 4],
    arch: [f32; 4],
}

impl DressUniform {
    fn new(dress: &Dress<'_>, observer: Observer) -> Result<Self> {
        let of = |keratin: &bsdf::Keratin| KeratinUniform::new(keratin, observer);
        let bsdf::Cells { size, barbule_size, wall_mm, arch } = dress.cells;
        let arch = arch.map_or([0.0; 4], |arch| [arch.low.sin(), arch.high.sin(), arch.blur, 1.0]);
        Ok(Self {
            keratins: [of(dress.under)?, of(dress.ramus)?, of(dress.shaft)?],
            cells: [size, barbule_size, wall_mm, 0.0].map(|v| v as f32),
            arch: arch.map(|v| v as f32),
        })
    }
}

/// What upper sides are made of.
#[derive(Debug, Clone, Copy)]
pub enum Coat<'a> {
    /// Barbules.
    Feather(&'a Feather),
    /// A grating.
    Grating(&'a Grating),
}

/// Draws meshes.
#[derive(Debug, Clone)]
pub struct Surfaces {
    feather: wgpu::RenderPipeline,
    grating: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    dress: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Surfaces {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// The driver refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let layout = gpu.layout_for("view", wgpu::ShaderStages::VERTEX_FRAGMENT, &[UNIFORM, UNIFORM]);
        let of = |material: &wgpu::BindGroupLayout, sources: [&str; 2]| {
            let [first, last] = sources;
            let source = [WAVES, first, KERATIN, SURFACE, last].concat();
            gpu.checked("the shader of surfaces", || pipeline(gpu, material, &layout, source))
        };
        let feather = of(&Feather::layout(gpu), [FEATHER, SURFACE_FEATHER])?;
        let grating = of(&Grating::layout(gpu), [GRATING, SURFACE_GRATING])?;
        let view = gpu.uniform("view", bytemuck::bytes_of(&ViewUniform::zeroed()));
        let dress = gpu.uniform("dress", bytemuck::bytes_of(&DressUniform::zeroed()));
        let both = [view.as_entire_binding(), dress.as_entire_binding()];
        let group = gpu.bound("view", &layout, &both);
        Ok(Self { feather, grating, view, dress, group })
    }

    /// Another view, from the next frame on.
    pub fn look(&self, gpu: &Gpu, view: &View) {
        gpu.queue().write_buffer(&self.view, 0, bytemuck::bytes_of(&view.uniform()));
    }

    /// Other cells and keratin, as an observer sees it, from the next frame on.
    ///
    /// # Errors
    /// None, as long as wavelengths rise.
    pub fn dress(&self, gpu: &Gpu, dress: &Dress<'_>, observer: Observer) -> Result<()> {
        let uniform = DressUniform::new(dress, observer)?;
        gpu.queue().write_buffer(&self.dress, 0, bytemuck::bytes_of(&uniform));
        Ok(())
    }

    /// One frame: a mesh on a film, which is empty before it.
    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        film: &Film,
        mesh: &Mesh,
        waves: &WavesOnGpu,
        coat: Coat<'_>,
    ) {
        let (pipeline, material) = match coat {
            Coat::Feather(feather) => (&self.feather, feather.group()),
            Coat::Grating(grating) => (&self.grating, grating.group()),
        };
        let mut pass = film.begin(encoder);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, waves.group(), &[]);
        pass.set_bind_group(1, material, &[]);
        pass.set_bind_group(2, &self.group, &[]);
        pass.set_vertex_buffer(0, mesh.corners.slice(..));
        pass.set_index_buffer(mesh.triangles.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..mesh.count, 0, 0..1);
    }
}

fn pipeline(
    gpu: &Gpu,
    material: &wgpu::BindGroupLayout,
    view: &wgpu::BindGroupLayout,
    source: String,
) -> wgpu::RenderPipeline {
    let device = gpu.device();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("surfaces"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let waves = WavesOnGpu::layout(gpu);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("surfaces"),
        bind_group_layouts: &[Some(&waves), Some(material), Some(view)],
        immediate_size: 0,
    });
    let corners = wgpu::VertexBufferLayout {
        array_stride: CORNER,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("surfaces"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs_surface"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(corners)],
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs_surface"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(LIGHT.into())],
        }),
        // Both sides are seen.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: SAMPLES, ..wgpu::MultisampleState::default() },
        multiview_mask: None,
        cache: None,
    })
}
