//! A graphics adapter and a shader to ask, where there are any.

use barbule_appearance::brdf::BrdfTables;
use barbule_appearance::bsdf;
use barbule_light::spectrum::Wavelengths;
use barbule_view::gpu::{
    Api, Feather, Gpu, Grating, Layers, PackedGrating, PackedLayers, PackedTables, Probe, Question, Shader,
    Sight, Waves, WavesOnGpu,
};

/// A shader on one adapter.
pub(crate) struct Asking {
    pub(crate) gpu: Gpu,
    probe: Probe,
}

/// A material in the shader's hands.
pub(crate) struct Loaded {
    pub(crate) waves: Waves,
    on_gpu: WavesOnGpu,
    material: wgpu::BindGroup,
}

impl Asking {
    /// The shader by every interface that this machine has; where there is none, the test is skipped and says so.
    pub(crate) fn all(shader: Shader) -> Vec<Self> {
        let mut all = Vec::new();
        for api in [Api::Vulkan, Api::OpenGl] {
            match Gpu::new(Some(api)) {
                Ok(gpu) => {
                    let probe = Probe::new(&gpu, shader).unwrap();
                    all.push(Self { gpu, probe });
                }
                Err(error) => println!("skipped with {api:?}: {error}"),
            }
        }
        all
    }

    /// A feather's tables and as many of their wavelengths.
    pub(crate) fn feather(&self, tables: &BrdfTables, waves: usize) -> Loaded {
        let packed = PackedTables::new(tables, self.gpu.most_texels_along()).unwrap();
        let waves = Waves::new(packed.wavelengths_nm(), &Sight::default(), waves).unwrap();
        let material = Feather::new(&self.gpu, &packed).unwrap().group().clone();
        Loaded { on_gpu: WavesOnGpu::new(&self.gpu, &waves), waves, material }
    }

    /// A grating's, and as many of the usual wavelengths.
    pub(crate) fn grating(&self, grating: &bsdf::Grating, waves: usize) -> Loaded {
        let packed = PackedGrating::new(grating, self.gpu.most_texels_along()).unwrap();
        let waves = Waves::new(Wavelengths::usual().nm(), &Sight::default(), waves).unwrap();
        let material = Grating::new(&self.gpu, &packed).unwrap().group().clone();
        Loaded { on_gpu: WavesOnGpu::new(&self.gpu, &waves), waves, material }
    }

    /// Layers', at as many of their wavelengths.
    pub(crate) fn layers(&self, packed: &PackedLayers, waves: usize) -> Loaded {
        let waves = Waves::new(packed.wavelengths_nm(), &Sight::default(), waves).unwrap();
        let material = Layers::new(&self.gpu, packed).unwrap().group().clone();
        Loaded { on_gpu: WavesOnGpu::new(&self.gpu, &waves), waves, material }
    }

    pub(crate) fn ask(&self, loaded: &Loaded, questions: &[Question]) -> Vec<[f64; 3]> {
        self.ask_bound(&[loaded.on_gpu.group(), &loaded.material], questions)
    }

    /// With these groups bound.
    pub(crate) fn ask_bound(&self, bound: &[&wgpu::BindGroup], questions: &[Question]) -> Vec<[f64; 3]> {
        let answers = self.probe.ask(&self.gpu, bound, questions).unwrap();
        assert_eq!(answers.len(), questions.len());
        answers
    }
}
