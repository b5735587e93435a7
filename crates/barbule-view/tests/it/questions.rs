//! A graphics adapter and shaders to ask, where there are any.

use barbule_appearance::brdf::BrdfTables;
use barbule_light::spectrum::colour::Observer;
use barbule_view::gpu::{Answer, Api, Feather, Gpu, PackedTables, Probe, Question, Waves, WavesOnGpu};

/// Shaders on one adapter.
pub(crate) struct Shaders {
    pub(crate) gpu: Gpu,
    probe: Probe,
}

/// A material in the shaders' hands.
pub(crate) struct Loaded {
    pub(crate) waves: Waves,
    on_gpu: WavesOnGpu,
    feather: Feather,
}

impl Shaders {
    /// Those of every interface that this machine has; where there is none, the test is skipped and says so.
    pub(crate) fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for api in [Api::Vulkan, Api::OpenGl] {
            match Gpu::new(Some(api)) {
                Ok(gpu) => {
                    let probe = Probe::new(&gpu).unwrap();
                    all.push(Self { gpu, probe });
                }
                Err(error) => println!("skipped with {api:?}: {error}"),
            }
        }
        all
    }

    pub(crate) fn load(&self, tables: &BrdfTables, waves: usize) -> Loaded {
        let packed = PackedTables::new(tables, self.gpu.most_texels_along()).unwrap();
        let waves = Waves::new(packed.wavelengths_nm(), Observer::default(), waves).unwrap();
        Loaded {
            on_gpu: WavesOnGpu::new(&self.gpu, &waves),
            feather: Feather::new(&self.gpu, &packed).unwrap(),
            waves,
        }
    }

    pub(crate) fn ask(&self, loaded: &Loaded, questions: &[Question]) -> Vec<Answer> {
        let answers = self.probe.ask(&self.gpu, &loaded.on_gpu, &loaded.feather, questions).unwrap();
        assert_eq!(answers.len(), questions.len());
        answers
    }
}
