//! Values of the shaders one by one: each pixel of a picture answers one question.

use glam::DVec3;

use super::colour::WavesOnGpu;
use super::device::{Gpu, NUMBERS, texture_type};
use super::grating::Grating;
use super::layers::Layers;
use super::offscreen::Target;
use super::shaders::{FEATHER, GRATING, LAYERS, TONE, WAVES};
use super::tables::{Feather, WIDTH};
use crate::Result;

/// Questions of a row.
const COLUMNS: u32 = WIDTH / 2;

/// The bits of an answer's numbers: not every adapter draws into single precision.
const ANSWERS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// Which shader is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shader {
    /// A feather's; bound are its wavelengths and its tables.
    Feather,
    /// A grating's; bound are its wavelengths and its tables.
    Grating,
    /// Layers'; bound are their wavelengths and their tables. Wavelengths of questions are numbers in the tables.
    Layers,
    /// The screen's tones; nothing is bound.
    Tone,
}

/// What is asked, and what the three numbers of the answer are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Question {
    /// f, 1/sr, of a feather its steady part, 1/sr, and what is reflected of all light from ω_i.
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

/// A shader, ready to be asked.
#[derive(Debug, Clone)]
pub struct Probe {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
}

impl Shader {
    /// All of its source.
    fn source(self) -> String {
        let probe = include_str!("shaders/probe.wgsl");
        match self {
            Self::Feather => [WAVES, FEATHER, probe, include_str!("shaders/probe_feather.wgsl")].concat(),
            Self::Grating => [WAVES, GRATING, probe, include_str!("shaders/probe_grating.wgsl")].concat(),
            Self::Layers => [WAVES, LAYERS, probe, include_str!("shaders/probe_layers.wgsl")].concat(),
            Self::Tone => [TONE, probe, include_str!("shaders/probe_tone.wgsl")].concat(),
        }
    }

    /// What it binds before the questions.
    fn layouts(self, gpu: &Gpu) -> [Option<wgpu::BindGroupLayout>; 2] {
        match self {
            Self::Feather => [Some(WavesOnGpu::layout(gpu)), Some(Feather::layout(gpu))],
            Self::Grating => [Some(WavesOnGpu::layout(gpu)), Some(Grating::layout(gpu))],
            Self::Layers => [Some(WavesOnGpu::layout(gpu)), Some(Layers::layout(gpu))],
            Self::Tone => [None, None],
        }
    }
}

impl Probe {
    /// Compiles a shader.
    ///
    /// # Errors
    /// The driver refuses it.
    pub fn new(gpu: &Gpu, shader: Shader) -> Result<Self> {
        let questions = [texture_type(NUMBERS), texture_type(wgpu::TextureSampleType::Uint)];
        let layout = gpu.layout("questions", &questions);
        let [first, second] = shader.layouts(gpu);
        let pipeline = gpu.checked("a shader", || {
            let device = gpu.device();
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("probe"),
                source: wgpu::ShaderSource::Wgsl(shader.source().into()),
            });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("probe"),
                bind_group_layouts: &[first.as_ref(), second.as_ref(), Some(&layout)],
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
                    targets: &[Some(ANSWERS.into())],
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

    /// The answers, in the order of the questions. Directions are rounded to single precision before anything else. `bound`
    /// are the groups that the shader needs, as [`Shader`] says.
    ///
    /// # Errors
    /// The adapter was lost, or has too few texels for so many questions.
    pub fn ask(
        &self,
        gpu: &Gpu,
        bound: &[&wgpu::BindGroup],
        questions: &[Question],
    ) -> Result<Vec<[f64; 3]>> {
        if questions.is_empty() {
            return Ok(Vec::new());
        }
        let rows = questions.len().div_ceil(COLUMNS as usize) as u32;
        let target = Target::new(gpu, [COLUMNS, rows], ANSWERS)?;
        let directions: Vec<[f32; 4]> = questions.iter().flat_map(Question::texels).collect();
        let names: Vec<[u32; 4]> = questions.iter().map(Question::name).collect();
        let group = gpu.checked("the questions", || {
            let format = wgpu::TextureFormat::Rgba32Float;
            let directions = gpu.texture("directions", format, WIDTH, &directions);
            let names = gpu.texture("names", wgpu::TextureFormat::Rgba32Uint, COLUMNS, &names);
            let both = [&directions, &names].map(wgpu::BindingResource::TextureView);
            gpu.bound("questions", &self.layout, &both)
        })?;
        target.draw(gpu, |pass| {
            pass.set_pipeline(&self.pipeline);
            for (number, group) in (0..).zip(bound) {
                pass.set_bind_group(number, *group, &[]);
            }
            pass.set_bind_group(2, &group, &[]);
            pass.draw(0..3, 0..1);
        })?;
        let bytes = target.read(gpu)?;
        let answer = |texel: &[u8; 16]| {
            let [a, b, c, _] = bytemuck::pod_read_unaligned::<[f32; 4]>(texel);
            [a, b, c].map(f64::from)
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

    /// The instance's name in two words, whether there is one, and whether a colour is asked.
    fn name(&self) -> [u32; 4] {
        let words = |instance: &Option<u64>, is_colour: u32| match instance {
            Some(name) => [*name as u32, (name >> 32) as u32, 1, is_colour],
            None => [0, 0, 0, is_colour],
        };
        match self {
            Self::Values { instance, .. } => words(instance, 0),
            Self::Colour { instance, .. } => words(instance, 1),
            Self::Tone { .. } => [0; 4],
        }
    }
}
