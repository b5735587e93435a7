//! Values of the shaders one by one: each pixel of a picture answers one question.

use glam::DVec3;

use super::colour::WavesOnGpu;
use super::device::{Gpu, NUMBERS, texture_type};
use super::offscreen::Target;
use super::shaders;
use super::tables::{Feather, WIDTH};
use crate::Result;

/// Questions of a row.
const COLUMNS: u32 = WIDTH / 2;

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Question {
    /// [`Answer::values`] at a wavelength, nm, in vacuum; of an instance or of the smooth mean.
    Values {
        /// Vacuum wavelength, nm.
        wavelength_nm: f32,
        /// Towards the light.
        wi: DVec3,
        /// Towards the eye.
        wo: DVec3,
        /// Which barbule; none for the smooth mean.
        instance: Option<u64>,
    },
    /// Linear sRGB of f, 1/sr, at the picture's wavelengths.
    Colour {
        /// Towards the light.
        wi: DVec3,
        /// Towards the eye.
        wo: DVec3,
        /// Which barbule; none for the smooth mean.
        instance: Option<u64>,
    },
    /// What a screen shows of a colour, both in linear sRGB.
    Tone {
        /// The colour after exposure.
        rgb: [f32; 3],
        /// By the film's curve rather than the plain one.
        is_film: bool,
    },
}

/// Three numbers of a shader.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer([f32; 3]);

impl Answer {
    /// f and its steady part, 1/sr, and what is reflected of all light from ω_i.
    #[must_use]
    pub fn values(self) -> [f64; 3] {
        self.0.map(f64::from)
    }

    /// Of questions about colours: linear sRGB.
    #[must_use]
    pub fn rgb(self) -> [f64; 3] {
        self.values()
    }
}

/// The shaders, ready to be asked.
#[derive(Debug, Clone)]
pub struct Probe {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
}

impl Probe {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// The driver refuses them.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let layout = gpu
            .layout("questions", &[texture_type(NUMBERS), texture_type(wgpu::TextureSampleType::Uint)]);
        let source = [shaders::FEATHER, shaders::COLOUR, shaders::TONE, shaders::PROBE].concat();
        let pipeline = gpu.checked("the shader of a feather's values", || {
            let device = gpu.device();
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("probe"),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            let groups = [WavesOnGpu::layout(gpu), Feather::layout(gpu), layout.clone()];
            let groups: Vec<_> = groups.iter().map(Some).collect();
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("probe"),
                bind_group_layouts: &groups,
                immediate_size: 0,
            });
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("probe"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vs_probe"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fs_probe"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(wgpu::TextureFormat::Rgba32Float.into())],
                }),
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                multiview_mask: None,
                cache: None,
            })
        })?;
        Ok(Self { pipeline, layout })
    }

    /// The answers, in the order of the questions. Directions are rounded to single precision before anything else.
    ///
    /// # Errors
    /// The adapter was lost, or has too few texels for so many questions.
    pub fn ask(
        &self,
        gpu: &Gpu,
        waves: &WavesOnGpu,
        feather: &Feather,
        questions: &[Question],
    ) -> Result<Vec<Answer>> {
        if questions.is_empty() {
            return Ok(Vec::new());
        }
        let rows = questions.len().div_ceil(COLUMNS as usize) as u32;
        let target = Target::new(gpu, [COLUMNS, rows], wgpu::TextureFormat::Rgba32Float)?;
        let directions: Vec<[f32; 4]> = questions.iter().flat_map(|question| question.texels()).collect();
        let names: Vec<[u32; 4]> = questions.iter().map(Question::name).collect();
        let group = gpu.checked("the questions", || {
            let float = wgpu::TextureFormat::Rgba32Float;
            let directions = gpu.texture("directions", float, WIDTH, &directions);
            let names = gpu.texture("names", wgpu::TextureFormat::Rgba32Uint, COLUMNS, &names);
            gpu.bound("questions", &self.layout, &[
                wgpu::BindingResource::TextureView(&directions),
                wgpu::BindingResource::TextureView(&names),
            ])
        })?;
        target.draw(gpu, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, waves.group(), &[]);
            pass.set_bind_group(1, feather.group(), &[]);
            pass.set_bind_group(2, &group, &[]);
            pass.draw(0..3, 0..1);
        })?;
        let bytes = target.read(gpu)?;
        let answer = |texel: &[u8; 16]| {
            let [a, b, c, _] = bytemuck::pod_read_unaligned::<[f32; 4]>(texel);
            Answer([a, b, c])
        };
        Ok(bytes.as_chunks().0.iter().take(questions.len()).map(answer).collect())
    }
}

impl Question {
    fn texels(&self) -> [[f32; 4]; 2] {
        let texel = |w: &DVec3, last: f32| {
            let [x, y, z] = w.to_array().map(|v| v as f32);
            [x, y, z, last]
        };
        match self {
            Self::Values { wavelength_nm, wi, wo, .. } => [texel(wi, *wavelength_nm), texel(wo, 0.0)],
            Self::Colour { wi, wo, .. } => [texel(wi, 0.0), texel(wo, 0.0)],
            Self::Tone { rgb: [r, g, b], is_film } => {
                [[*r, *g, *b, 0.0], [f32::from(u8::from(*is_film)), 0.0, 0.0, 0.0]]
            }
        }
    }

    /// The instance's name in two words, whether there is one, and what is asked.
    fn name(&self) -> [u32; 4] {
        let words = |instance: &Option<u64>, kind: u32| match instance {
            Some(name) => [*name as u32, (name >> 32) as u32, 1, kind],
            None => [0, 0, 0, kind],
        };
        match self {
            Self::Values { instance, .. } => words(instance, 0),
            Self::Colour { instance, .. } => words(instance, 1),
            Self::Tone { .. } => [0, 0, 0, 2],
        }
    }
}
