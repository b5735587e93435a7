//! Meshes under a lamp and an even sky: `shaders/surface.wgsl` and those that go with it.

use std::mem::offset_of;
use std::ops::Range;

use barbule_appearance::bsdf;
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

use super::colour::{Sight, WavesOnGpu};
use super::device::{Gpu, UNIFORM};
use super::film::{DEPTH, Film, LIGHT, samples};
use super::grating::Grating;
use super::layers::Layers;
use super::shaders::{
    FEATHER, GRATING, KERATIN, LAYERS, SURFACE, SURFACE_FEATHER, SURFACE_GRATING, SURFACE_KERATIN,
    SURFACE_LAYERS, WAVES,
};
use super::tables::Feather;
use crate::Result;
use crate::scene::{Shape, Vertex};

/// What corners hold, in the order of [`Vertex`]: position, normal and tangent (three numbers each), place (two), slope and half width,
/// and, after the part, the two words of the name.
const ATTRIBUTES: [wgpu::VertexAttribute; 6] = [
    attribute(0, wgpu::VertexFormat::Float32x3, offset_of!(Vertex, position_mm)),
    attribute(1, wgpu::VertexFormat::Float32x3, offset_of!(Vertex, normal)),
    attribute(2, wgpu::VertexFormat::Float32x3, offset_of!(Vertex, tangent)),
    attribute(3, wgpu::VertexFormat::Float32x2, offset_of!(Vertex, place)),
    attribute(4, wgpu::VertexFormat::Float32x2, offset_of!(Vertex, swelling)),
    attribute(5, wgpu::VertexFormat::Uint32x2, offset_of!(Vertex, name)),
];

const fn attribute(shader_location: u32, format: wgpu::VertexFormat, offset: usize) -> wgpu::VertexAttribute {
    wgpu::VertexAttribute { format, offset: offset as u64, shader_location }
}

/// A mesh on the graphics card.
#[derive(Debug, Clone)]
pub struct Mesh {
    corners: wgpu::Buffer,
    triangles: wgpu::Buffer,
    parts: Vec<(u32, Range<u32>)>,
    bytes: u64,
}

impl Mesh {
    /// Uploads a shape, the triangles of each part together.
    ///
    /// # Errors
    /// As [`Shape::check`], or too little memory.
    pub fn new(gpu: &Gpu, shape: &Shape) -> Result<Self> {
        shape.check()?;
        let code = |corners: &[u32; 3]| shape.vertices[corners[0] as usize].part;
        let mut triangles = shape.triangles.clone();
        triangles.sort_by_key(code);
        let mut parts = Vec::new();
        let mut from = 0;
        for part in triangles.chunk_by(|a, b| code(a) == code(b)) {
            let to = from + 3 * part.len() as u32;
            parts.push((code(&part[0]), from..to));
            from = to;
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
            let (corners, indices) = (shape.vertex_bytes(), bytemuck::cast_slice(&triangles));
            Self {
                bytes: (corners.len() + size_of_val(indices)) as u64,
                corners: buffer("corners", corners, wgpu::BufferUsages::VERTEX),
                triangles: buffer("triangles", indices, wgpu::BufferUsages::INDEX),
                parts,
            }
        })
    }

    /// Codes of its parts, rising: [`Part::code`](crate::scene::Part::code).
    pub fn parts(&self) -> impl Iterator<Item = u32> + '_ {
        self.parts.iter().map(|(code, _)| *code)
    }

    /// What its buffers hold, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
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
    fn new(keratin: &bsdf::Keratin, sight: &Sight) -> Result<Self> {
        let [r, g, b] = sight.shown(&|nm| keratin.body().at(nm))?.map(|v| v as f32);
        let (boundary, mean) = keratin.boundary();
        let mut albedo = [[0.0; 4]; 9];
        for (place, value) in albedo.as_flattened_mut().iter_mut().zip(boundary) {
            *place = *value as f32;
        }
        let optics = [keratin.roughness() as f32, keratin.index() as f32, mean as f32, 0.0];
        Ok(Self { body: [r, g, b, 0.0], optics, albedo })
    }
}

/// What is beside a part's own scattering.
#[derive(Debug, Clone, Copy)]
pub struct Trim<'a> {
    /// How barbules differ from place to place.
    pub cells: bsdf::Cells,
    /// Undersides, walls between cells, and all of what has no coat of its own.
    pub keratin: &'a bsdf::Keratin,
}

/// `Dress` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct DressUniform {
    keratin: KeratinUniform,
    cells: [f32; 4],
    arch: [f32; 4],
}

/// A part's trim on the graphics card.
#[derive(Debug, Clone)]
pub struct Dress {
    group: wgpu::BindGroup,
    uniform: wgpu::Buffer,
}

impl DressUniform {
    fn new(trim: &Trim<'_>, sight: &Sight) -> Result<Self> {
        let bsdf::Cells { size, barbule_size, wall_mm, arch } = trim.cells;
        let arch = arch.map_or([0.0; 4], |arch| [arch.low.sin(), arch.high.sin(), arch.blur, 1.0]);
        Ok(Self {
            keratin: KeratinUniform::new(trim.keratin, sight)?,
            cells: [size, barbule_size, wall_mm, 0.0].map(|v| v as f32),
            arch: arch.map(|v| v as f32),
        })
    }
}

impl Dress {
    /// Uploads a trim, as somebody sees it.
    ///
    /// # Errors
    /// None, as long as wavelengths rise.
    pub fn new(gpu: &Gpu, trim: &Trim<'_>, sight: &Sight) -> Result<Self> {
        let uniform = gpu.uniform("dress", bytemuck::bytes_of(&DressUniform::new(trim, sight)?));
        let group = gpu.bound("dress", &Self::layout(gpu), &[uniform.as_entire_binding()]);
        Ok(Self { group, uniform })
    }

    /// Another in its place, from the next frame on.
    ///
    /// # Errors
    /// As [`Dress::new`].
    pub fn change(&self, gpu: &Gpu, trim: &Trim<'_>, sight: &Sight) -> Result<()> {
        let uniform = DressUniform::new(trim, sight)?;
        gpu.queue().write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        Ok(())
    }

    fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
        gpu.layout("dress", &[UNIFORM])
    }
}

/// What the upper sides of a part are made of, and at which wavelengths of its tables it is drawn.
#[derive(Debug, Clone, Copy)]
pub enum Coat<'a> {
    /// Barbules.
    Feather(&'a Feather, &'a WavesOnGpu),
    /// A grating.
    Grating(&'a Grating, &'a WavesOnGpu),
    /// Layers on a rough surface.
    Layers(&'a Layers, &'a WavesOnGpu),
    /// Nothing but the keratin of its trim.
    Keratin,
}

/// Draws meshes.
#[derive(Debug, Clone)]
pub struct Surfaces {
    feather: wgpu::RenderPipeline,
    grating: wgpu::RenderPipeline,
    layers: wgpu::RenderPipeline,
    keratin: wgpu::RenderPipeline,
    /// Depths alone, so that nothing is shaded that is hidden.
    depth: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    group: wgpu::BindGroup,
    /// Groups 0 and 1 of what has no material: drivers are not trusted with holes.
    nothing: wgpu::BindGroup,
}

impl Surfaces {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// The driver refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let layout = gpu.layout_for("view", wgpu::ShaderStages::VERTEX_FRAGMENT, &[UNIFORM]);
        let of = |material: Option<&wgpu::BindGroupLayout>, own: &[&str]| {
            let source = [own, &[KERATIN, SURFACE]].concat().concat();
            gpu.checked("the shader of surfaces", || pipeline(gpu, material, &layout, Pass::Light, source))
        };
        let of_material = |material: &wgpu::BindGroupLayout, [first, last]: [&str; 2]| {
            of(Some(material), &[WAVES, first, last])
        };
        let feather = of_material(&Feather::layout(gpu), [FEATHER, SURFACE_FEATHER])?;
        let grating = of_material(&Grating::layout(gpu), [GRATING, SURFACE_GRATING])?;
        let layers = of_material(&Layers::layout(gpu), [LAYERS, SURFACE_LAYERS])?;
        let keratin = of(None, &[SURFACE_KERATIN])?;
        let source = [KERATIN, SURFACE, SURFACE_KERATIN].concat();
        let depth =
            gpu.checked("the shader of depths", || pipeline(gpu, None, &layout, Pass::Depth, source))?;
        let view = gpu.uniform("view", bytemuck::bytes_of(&ViewUniform::zeroed()));
        let group = gpu.bound("view", &layout, &[view.as_entire_binding()]);
        let nothing = gpu.bound("nothing", &gpu.layout("nothing", &[]), &[]);
        Ok(Self { feather, grating, layers, keratin, depth, view, group, nothing })
    }

    /// Another view, from the next frame on.
    pub fn look(&self, gpu: &Gpu, view: &View) {
        gpu.queue().write_buffer(&self.view, 0, bytemuck::bytes_of(&view.uniform()));
    }

    /// One frame: a mesh on a film, which is empty before it; `wear` says of the code of each of its parts what that wears.
    pub fn draw<'a>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        film: &Film,
        mesh: &Mesh,
        wear: impl Fn(u32) -> (Coat<'a>, &'a Dress),
    ) {
        let mut pass = film.begin(encoder);
        pass.set_vertex_buffer(0, mesh.corners.slice(..));
        pass.set_index_buffer(mesh.triangles.slice(..), wgpu::IndexFormat::Uint32);
        if let Some((code, _)) = mesh.parts.first() {
            let (_, dress) = wear(*code);
            pass.set_pipeline(&self.depth);
            for (number, group) in (0..).zip([&self.nothing, &self.nothing, &self.group, &dress.group]) {
                pass.set_bind_group(number, group, &[]);
            }
            pass.draw_indexed(0..mesh.parts.iter().map(|(_, range)| range.end).max().unwrap_or(0), 0, 0..1);
        }
        for (code, range) in &mesh.parts {
            let (coat, dress) = wear(*code);
            let (pipeline, material) = match coat {
                Coat::Feather(feather, waves) => (&self.feather, Some((feather.group(), waves))),
                Coat::Grating(grating, waves) => (&self.grating, Some((grating.group(), waves))),
                Coat::Layers(layers, waves) => (&self.layers, Some((layers.group(), waves))),
                Coat::Keratin => (&self.keratin, None),
            };
            pass.set_pipeline(pipeline);
            let [waves, material] =
                material.map_or([&self.nothing; 2], |(material, waves)| [waves.group(), material]);
            for (number, group) in (0..).zip([waves, material, &self.group, &dress.group]) {
                pass.set_bind_group(number, group, &[]);
            }
            pass.draw_indexed(range.clone(), 0, 0..1);
        }
    }
}

/// What a pass over a mesh is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pass {
    /// How near it is.
    Depth,
    /// The light from what is nearest.
    Light,
}

fn pipeline(
    gpu: &Gpu,
    material: Option<&wgpu::BindGroupLayout>,
    view: &wgpu::BindGroupLayout,
    what: Pass,
    source: String,
) -> wgpu::RenderPipeline {
    let (device, is_depth) = (gpu.device(), what == Pass::Depth);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("surfaces"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let (waves, dress) = (WavesOnGpu::layout(gpu), Dress::layout(gpu));
    let none = gpu.layout("nothing", &[]);
    let all =
        [Some(material.map_or(&none, |_| &waves)), Some(material.unwrap_or(&none)), Some(view), Some(&dress)];
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("surfaces"),
        bind_group_layouts: &all,
        immediate_size: 0,
    });
    let corners = wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
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
            entry_point: Some(if is_depth { "fs_depth" } else { "fs_surface" }),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                write_mask: if is_depth { wgpu::ColorWrites::empty() } else { wgpu::ColorWrites::ALL },
                ..LIGHT.into()
            })],
        }),
        // Both sides are seen.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(is_depth),
            depth_compare: Some(if is_depth {
                wgpu::CompareFunction::Less
            } else {
                wgpu::CompareFunction::Equal
            }),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples(gpu), ..wgpu::MultisampleState::default() },
        multiview_mask: None,
        cache: None,
    })
}
