//! Light in linear sRGB, and its development: `shaders/develop.wgsl`.

use barbule_appearance::scene::description::ToneWord;
use bytemuck::{Pod, Zeroable};
use half::f16;

use super::device::{Gpu, NUMBERS, UNIFORM, texture_type};
use super::offscreen::read_texture;
use super::shaders::{DEVELOP, TONE};
use crate::{Error, Result};

/// Samples of a pixel: of a graphics card, and of a processor, whose pictures are smooth only once they rest.
const SAMPLES: [u32; 2] = [4, 1];
/// What light is kept as: half precision, premultiplied by how much of the pixel is covered.
pub(super) const LIGHT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// What depths are kept as.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth24Plus;

/// Samples of a pixel on an adapter.
pub(super) fn samples(gpu: &Gpu) -> u32 {
    SAMPLES[usize::from(gpu.is_software())]
}

/// A picture before its development.
#[derive(Debug, Clone)]
pub struct Film {
    samples: Option<wgpu::TextureView>,
    light: wgpu::TextureView,
    resolved: wgpu::Texture,
    mean: wgpu::TextureView,
    depth: wgpu::TextureView,
    size: [u32; 2],
}

impl Film {
    /// A film of this many columns and rows.
    ///
    /// # Errors
    /// It is larger than the adapter's textures, or the adapter does not draw with half precision and four samples.
    pub fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<Self> {
        let most = gpu.most_texels_along();
        if width == 0 || height == 0 || width > most || height > most {
            return Err(Error::input(format!(
                "the picture has {width} × {height} pixels; give 1 to {most} columns and rows, which is what {gpu} has"
            )));
        }
        gpu.checked("the film", || {
            let texture = |label: &str, format, sample_count, usage| {
                gpu.device().create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                    view_formats: &[],
                })
            };
            let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
            let (none, read) = (wgpu::TextureUsages::empty(), wgpu::TextureUsages::TEXTURE_BINDING);
            let count = samples(gpu);
            let resolved = texture("light", LIGHT, 1, read | wgpu::TextureUsages::COPY_SRC);
            Self {
                samples: (count > 1).then(|| view(&texture("samples", LIGHT, count, none))),
                light: view(&resolved),
                resolved,
                mean: view(&texture("mean", LIGHT, 1, read)),
                depth: view(&texture("depth", DEPTH, count, none)),
                size: [width, height],
            }
        })
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The newest frame: linear sRGB times the share of the pixel that is covered, and that share, row by row. Waits for what was drawn.
    ///
    /// # Errors
    /// The adapter was lost, or has too little memory.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>> {
        let bytes = read_texture(gpu, &self.resolved)?;
        let number = |bytes: &[u8; 2]| f16::from_le_bytes(*bytes).to_f32();
        Ok(bytes.as_chunks().0.as_chunks().0.iter().map(|four| four.each_ref().map(number)).collect())
    }

    /// A pass over the film, which is empty before it.
    pub(super) fn begin<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::RenderPass<'a> {
        let colour = wgpu::RenderPassColorAttachment {
            view: self.samples.as_ref().unwrap_or(&self.light),
            depth_slice: None,
            resolve_target: self.samples.as_ref().map(|_| &self.light),
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: if self.samples.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store },
            },
        };
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(1.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("surfaces"),
            color_attachments: &[Some(colour)],
            depth_stencil_attachment: Some(depth),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}

/// How light is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Stops: each doubles the light.
    pub stops: f32,
    /// The curve.
    pub tone: ToneWord,
    /// Linear sRGB on the screen behind what is drawn.
    pub behind: [f32; 3],
}

/// `Develop` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct DevelopUniform {
    how: [f32; 4],
    behind: [f32; 4],
}

/// A film in a developer.
#[derive(Debug, Clone)]
pub struct LoadedFilm {
    frame: wgpu::BindGroup,
    mean: wgpu::BindGroup,
    target: wgpu::TextureView,
}

/// Develops films, which show the mean of several frames.
#[derive(Debug, Clone)]
pub struct Developer {
    pipeline: wgpu::RenderPipeline,
    /// The first frame in the place of the mean, and the next ones into it.
    first: wgpu::RenderPipeline,
    gather: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    uniform: wgpu::Buffer,
    encodes: bool,
}

impl Developer {
    /// For pictures of a format: where it is one of sRGB, the target applies the transfer curve itself.
    ///
    /// # Errors
    /// The driver refuses the shader.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Result<Self> {
        let layout = gpu.layout("develop", &[UNIFORM, texture_type(NUMBERS)]);
        let of = |entry: &str, format: wgpu::TextureFormat, blend: Option<wgpu::BlendState>| {
            let target = wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL };
            gpu.checked("the shader of the film", || pipeline(gpu, &layout, entry, target))
        };
        let mean = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::Constant,
            dst_factor: wgpu::BlendFactor::OneMinusConstant,
            operation: wgpu::BlendOperation::Add,
        };
        let pipeline = of("fs_develop", format, None)?;
        let first = of("fs_gather", LIGHT, None)?;
        let gather = of("fs_gather", LIGHT, Some(wgpu::BlendState { color: mean, alpha: mean }))?;
        let uniform = gpu.uniform("develop", bytemuck::bytes_of(&DevelopUniform::zeroed()));
        Ok(Self { pipeline, first, gather, layout, uniform, encodes: format.is_srgb() })
    }

    /// The film as groups to be bound; for as long as this film is shown.
    #[must_use]
    pub fn load(&self, gpu: &Gpu, film: &Film) -> LoadedFilm {
        let group = |label: &str, view: &wgpu::TextureView| {
            let picture = wgpu::BindingResource::TextureView(view);
            gpu.bound(label, &self.layout, &[self.uniform.as_entire_binding(), picture])
        };
        LoadedFilm {
            frame: group("frame", &film.light),
            mean: group("mean", &film.mean),
            target: film.mean.clone(),
        }
    }

    /// Takes the newest frame into the mean of all since the film was last begun anew; `frames` are they with it.
    pub fn gather(&self, encoder: &mut wgpu::CommandEncoder, film: &LoadedFilm, frames: u32) {
        let attachment = wgpu::RenderPassColorAttachment {
            view: &film.target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("gather"),
            color_attachments: &[Some(attachment)],
            ..wgpu::RenderPassDescriptor::default()
        });
        let share = 1.0 / f64::from(frames.max(1));
        pass.set_pipeline(if frames <= 1 { &self.first } else { &self.gather });
        pass.set_blend_constant(wgpu::Color { r: share, g: share, b: share, a: share });
        pass.set_bind_group(0, &film.frame, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Another exposure, from the next frame on.
    pub fn expose(&self, gpu: &Gpu, exposure: &Exposure) {
        let is_film = f32::from(u8::from(exposure.tone == ToneWord::Filmic));
        let encodes = f32::from(u8::from(self.encodes));
        let [r, g, b] = exposure.behind;
        let uniform =
            DevelopUniform { how: [exposure.stops.exp2(), is_film, encodes, 0.0], behind: [r, g, b, 0.0] };
        gpu.queue().write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
    }

    /// Shows a loaded film in a pass, over all of its viewport.
    pub fn develop(&self, pass: &mut wgpu::RenderPass<'_>, film: &LoadedFilm) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &film.mean, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn pipeline(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    entry: &str,
    target: wgpu::ColorTargetState,
) -> wgpu::RenderPipeline {
    let device = gpu.device();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("develop"),
        source: wgpu::ShaderSource::Wgsl([TONE, DEVELOP].concat().into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("develop"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("develop"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs_develop"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(target)],
        }),
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        multiview_mask: None,
        cache: None,
    })
}
