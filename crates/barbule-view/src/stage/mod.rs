//! One shape in what it wears, under a lamp and an even sky: drawn onto a film in turns of wavelengths, of places within pixels and of
//! places on the lamp, whose mean the film shows. So the first frame is there at once, and a picture at rest gets better for a while.

mod look;
mod show;

use std::collections::BTreeMap;
use std::sync::Arc;

use barbule_appearance::bsdf;
use barbule_appearance::render::exposure::balanced;
use barbule_light::spectrum::Wavelengths;
use barbule_light::spectrum::colour::luminance;
use glam::Vec2;

pub use look::Look;
pub use show::{Coat, Show, Wear};

use crate::gpu::{
    self, Cells, Developer, Dress, Feather, Film, Gpu, Grating, Layers, LoadedFilm, MOST_WAVES, Mesh,
    PackedGrating, PackedLayers, PackedTables, Sight, Surfaces, Trim, Waves, WavesOnGpu,
};
use crate::scene::{Naming, Shape};
use crate::{Error, Result};

/// Wavelengths of a frame where the processor draws it, and where a graphics card does.
const WAVES: [usize; 2] = [6, MOST_WAVES];
/// How much coarser pictures are while they move, likewise.
const COARSE: [u32; 2] = [3, 1];
/// Frames of a picture at rest at least: places within a pixel, and on the lamp.
const LEAST_FRAMES: u32 = 16;
/// Columns or rows of the meter's picture.
const METER: f64 = 96.0;

/// Draws a shape.
#[derive(Debug)]
pub struct Stage {
    gpu: Gpu,
    surfaces: Surfaces,
    developer: Developer,
    /// Of pictures at rest, and of such as move.
    films: [Option<(Film, LoadedFilm)>; 2],
    /// Which of them is shown.
    shown: usize,
    /// Pixels along and down of a picture at rest for one of a picture that moves.
    coarse: u32,
    act: Option<Act>,
    look: Option<Look>,
    size: [u32; 2],
    frames: u32,
    most_waves: usize,
    /// Stops that the meter says; nothing until it was asked.
    metered: Option<f32>,
}

/// What is on the stage.
#[derive(Debug)]
struct Act {
    mesh: Mesh,
    radius_mm: f64,
    cells: Cells,
    parts: BTreeMap<u32, usize>,
    wears: Vec<Worn>,
    bytes: u64,
    turns: u32,
}

/// What a part wears, on the graphics card.
#[derive(Debug)]
struct Worn {
    coat: OnGpu,
    waves: Vec<WavesOnGpu>,
    most_waves: usize,
    dress: Dress,
}

#[derive(Debug, Clone)]
enum OnGpu {
    Feather(Feather),
    Grating(Grating),
    Layers(Layers),
    Keratin,
}

impl Worn {
    fn coat(&self, frame: u32) -> gpu::Coat<'_> {
        let Some(waves) = self.waves.get(frame as usize % self.waves.len().max(1)) else {
            return gpu::Coat::Keratin;
        };
        match &self.coat {
            OnGpu::Feather(feather) => gpu::Coat::Feather(feather, waves),
            OnGpu::Grating(grating) => gpu::Coat::Grating(grating, waves),
            OnGpu::Layers(layers) => gpu::Coat::Layers(layers, waves),
            OnGpu::Keratin => gpu::Coat::Keratin,
        }
    }
}

impl Stage {
    /// An empty stage, shown in passes onto targets of a format.
    ///
    /// # Errors
    /// The driver refuses a shader.
    pub fn new(gpu: Gpu, target: wgpu::TextureFormat) -> Result<Self> {
        let surfaces = Surfaces::new(&gpu)?;
        let developer = Developer::new(&gpu, target)?;
        let most_waves = WAVES[usize::from(!gpu.is_software())];
        let coarse = COARSE[usize::from(!gpu.is_software())];
        Ok(Self {
            gpu,
            surfaces,
            developer,
            films: [None, None],
            shown: 0,
            coarse,
            act: None,
            look: None,
            size: [0; 2],
            frames: 0,
            most_waves,
            metered: None,
        })
    }

    /// The adapter.
    #[must_use]
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Wavelengths of a frame at most, from 2 to [`MOST_WAVES`]: fewer, and frames are sooner there. For what is put on from then on.
    pub fn limit_waves(&mut self, most: usize) {
        self.most_waves = most.clamp(2, MOST_WAVES);
    }

    /// Pictures that move are so much coarser than at rest, 1 for not at all; a processor that draws takes 3.
    pub fn coarsen(&mut self, by: u32) {
        self.coarse = by.max(1);
    }

    /// How much coarser they are.
    #[must_use]
    pub fn coarse(&self) -> u32 {
        self.coarse
    }

    /// Puts another shape and what it wears on.
    ///
    /// # Errors
    /// More than the adapter holds, a shape that is none, or a part that is of nothing; then what was there stays.
    pub fn put(&mut self, show: &Show) -> Result<()> {
        let act = Act::new(&self.gpu, show, self.most_waves)?;
        // Colours of one shape are compared in one exposure.
        if !self.act.as_ref().is_some_and(|before| before.is_shaped_as(&act)) {
            self.metered = None;
        }
        self.act = Some(act);
        self.frames = 0;
        self.look = None;
        Ok(())
    }

    /// Whether anything is on.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.act.is_none()
    }

    /// Draws a frame onto a film of this size, where the look is another or a further frame makes the picture better. Whether one more would.
    ///
    /// # Errors
    /// A size that the adapter does not have.
    pub fn draw(&mut self, size: [u32; 2], look: &Look) -> Result<bool> {
        if self.metered.is_none() {
            self.metered = Some(self.meter(size, look)?);
        }
        let Some(act) = &self.act else { return Ok(false) };
        let most = act.turns.max(LEAST_FRAMES).next_multiple_of(act.turns);
        let is_same = self.look.as_ref().is_some_and(|last| last.is_lit_as(look)) && self.size == size;
        self.developer.expose(&self.gpu, &look.exposure(self.metered.unwrap_or(0.0)));
        if is_same && self.frames >= most {
            return Ok(false);
        }
        let is_coarse = !is_same && self.coarse > 1;
        if !is_same || self.shown == 1 {
            self.frames = 0;
        }
        self.shown = usize::from(is_coarse);
        let by = if is_coarse { self.coarse } else { 1 };
        let pixels = size.map(|side| side.div_ceil(by));
        let place = &mut self.films[self.shown];
        if place.as_ref().is_none_or(|(film, _)| film.size() != pixels) {
            let film = Film::new(&self.gpu, pixels)?;
            let loaded = self.developer.load(&self.gpu, &film);
            *place = Some((film, loaded));
        }
        let Some((film, loaded)) = &self.films[self.shown] else { return Ok(false) };
        let mut encoder =
            self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.frame(&mut encoder, act, film, look, self.frames);
        self.developer.gather(&mut encoder, loaded, self.frames + 1);
        self.gpu.queue().submit([encoder.finish()]);
        self.frames += 1;
        (self.look, self.size) = (Some(look.clone()), size);
        Ok(is_coarse || self.frames < most)
    }

    /// Draws one frame onto a film.
    fn frame(&self, encoder: &mut wgpu::CommandEncoder, act: &Act, film: &Film, look: &Look, number: u32) {
        let jitter = Jitter::of(number, film.size());
        self.surfaces.look(&self.gpu, &look.view(film.size(), &jitter, act.radius_mm, act.cells));
        let wear = |code: u32| {
            let worn = &act.wears[act.parts.get(&code).copied().unwrap_or(0)];
            (worn.coat(number), &worn.dress)
        };
        self.surfaces.draw(encoder, film, &act.mesh, wear);
    }

    /// The exposure that the renderer's automatic one gives a small picture of the same, stops. 0 in browsers, where nobody waits for
    /// what was drawn.
    fn meter(&self, [width, height]: [u32; 2], look: &Look) -> Result<f32> {
        let Some(act) = self.act.as_ref().filter(|_| !cfg!(target_arch = "wasm32")) else { return Ok(0.0) };
        let scale = METER / f64::from(width.max(height).max(1));
        let film =
            Film::new(&self.gpu, [width, height].map(|side| ((f64::from(side) * scale) as u32).max(1)))?;
        let mut encoder =
            self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.frame(&mut encoder, act, &film, look, 0);
        self.gpu.queue().submit([encoder.finish()]);
        let covered: Vec<[f64; 3]> = film
            .read(&self.gpu)?
            .iter()
            .filter(|pixel| pixel[3] > 0.5)
            .map(|[r, g, b, share]| [r / share, g / share, b / share].map(f64::from))
            .collect();
        if covered.is_empty() {
            return Ok(0.0);
        }
        let luminances = covered.iter().map(|rgb| luminance(*rgb).max(0.0)).collect();
        let largest = covered.iter().map(|rgb| rgb.iter().copied().fold(0.0, f64::max)).collect();
        Ok(balanced(luminances, largest).log2() as f32)
    }

    /// Shows the film over a pass's viewport.
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some((_, loaded)) = &self.films[self.shown] {
            self.developer.develop(pass, loaded);
        }
    }

    /// At how many wavelengths a frame is drawn, where that is most.
    #[must_use]
    pub fn waves_of_a_frame(&self) -> usize {
        let of = |act: &Act| act.wears.iter().map(|worn| worn.most_waves).max().unwrap_or(0);
        self.act.as_ref().map_or(0, of)
    }

    /// Memory of tables and meshes on the adapter, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.act.as_ref().map_or(0, |act| act.bytes)
    }
}

impl Act {
    fn new(gpu: &Gpu, show: &Show, most_waves: usize) -> Result<Self> {
        let mesh = Mesh::new(gpu, &show.shape)?;
        let mut loader =
            Loader { gpu, sight: &show.sight, most_waves, feathers: Vec::new(), bytes: mesh.bytes() };
        let mut wears = vec![loader.worn(&show.rest)?];
        let mut parts = BTreeMap::new();
        for (code, wear) in &show.wears {
            parts.insert(*code, wears.len());
            wears.push(loader.worn(wear)?);
        }
        let turns = wears.iter().map(|worn| worn.waves.len() as u32).max().unwrap_or(1).max(1);
        let cells = match show.shape.naming {
            Naming::Ribbon | Naming::Plain => Cells::OfRibbons,
            Naming::Clad(layout) => Cells::Clad(layout),
        };
        let (radius_mm, bytes) = (radius_mm(&show.shape), loader.bytes);
        Ok(Self { radius_mm, mesh, cells, parts, wears, bytes, turns })
    }

    fn is_shaped_as(&self, other: &Self) -> bool {
        (self.radius_mm, self.mesh.bytes()) == (other.radius_mm, other.mesh.bytes())
    }
}

/// How far from the origin a shape reaches, mm.
fn radius_mm(shape: &Shape) -> f64 {
    let reach = |vertex: &crate::scene::Vertex| glam::Vec3::from(vertex.position_mm).length();
    f64::from(shape.vertices.iter().map(reach).fold(0.0, f32::max))
}

/// Uploads what parts wear; a material that several wear once.
struct Loader<'a> {
    gpu: &'a Gpu,
    sight: &'a Sight,
    most_waves: usize,
    feathers: Vec<(*const (), Feather, Vec<f64>)>,
    bytes: u64,
}

impl Loader<'_> {
    fn worn(&mut self, wear: &Wear) -> Result<Worn> {
        let trim = Trim { cells: wear.cells, keratin: &wear.keratin };
        let dress = Dress::new(self.gpu, &trim, self.sight)?;
        let rows = self.gpu.most_texels_along();
        let (coat, nm) = match &wear.coat {
            Coat::Feather(brdf) => {
                let (feather, nm) = self.feather(brdf, rows)?;
                (OnGpu::Feather(feather), nm)
            }
            Coat::Grating(grating) => {
                let packed = PackedGrating::new(grating, rows)?;
                self.bytes += packed.bytes() as u64;
                (OnGpu::Grating(Grating::new(self.gpu, &packed)?), grating_nm())
            }
            Coat::Layers { reflected, roughness } => {
                let packed = PackedLayers::new(reflected, *roughness)?;
                self.bytes += packed.bytes() as u64;
                (OnGpu::Layers(Layers::new(self.gpu, &packed)?), reflected.nm.clone())
            }
            Coat::Keratin => {
                return Ok(Worn { coat: OnGpu::Keratin, waves: Vec::new(), most_waves: 0, dress });
            }
        };
        let turns = Waves::turns(&nm, self.sight, self.most_waves)?;
        let most_waves = turns.iter().map(|waves| waves.nm().len()).max().unwrap_or(0);
        let waves = turns.iter().map(|waves| WavesOnGpu::new(self.gpu, waves)).collect();
        Ok(Worn { coat, waves, most_waves, dress })
    }

    fn feather(
        &mut self,
        brdf: &Arc<barbule_appearance::brdf::FeatherBrdf>,
        rows: u32,
    ) -> Result<(Feather, Vec<f64>)> {
        let place = Arc::as_ptr(brdf).cast();
        if let Some((_, feather, nm)) = self.feathers.iter().find(|(other, ..)| *other == place) {
            return Ok((feather.clone(), nm.clone()));
        }
        let packed = PackedTables::new(brdf.tables(), rows)?;
        if packed.wavelengths_nm().is_empty() {
            return Err(Error::input("the material has no wavelengths; make it again"));
        }
        self.bytes += packed.bytes() as u64;
        let feather = Feather::new(self.gpu, &packed)?;
        let nm = packed.wavelengths_nm().to_vec();
        self.feathers.push((place, feather.clone(), nm.clone()));
        Ok((feather, nm))
    }
}

/// At which wavelengths gratings are drawn, nm: their tables serve any within their band.
fn grating_nm() -> Vec<f64> {
    let band = bsdf::Grating::BAND;
    Wavelengths::usual().nm().iter().copied().filter(|nm| band.contains(*nm)).collect()
}

/// Where within a pixel, and where on the lamp, a frame is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Jitter {
    /// In clip coordinates.
    clip: Vec2,
    /// On the unit disc.
    lamp: Vec2,
}

impl Jitter {
    /// The first frame is in the middle of both; the others go through Halton's points.
    fn of(frame: u32, [width, height]: [u32; 2]) -> Self {
        let [x, y, r, turn] = [2, 3, 5, 7].map(|base| radical_inverse(frame, base));
        let pixel = Vec2::new(2.0 / width as f32, 2.0 / height as f32);
        if frame == 0 {
            return Self { clip: Vec2::ZERO, lamp: Vec2::ZERO };
        }
        let lamp = r.sqrt() * Vec2::from_angle(std::f32::consts::TAU * turn);
        Self { clip: pixel * (Vec2::new(x, y) - 0.5), lamp }
    }
}

/// The digits of a number behind the point, in reverse.
fn radical_inverse(mut number: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= base as f32;
        value += digit * (number % base) as f32;
        number /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_is_even_and_begins_in_the_middle() {
        assert_eq!(Jitter::of(0, [10, 10]), Jitter { clip: Vec2::ZERO, lamp: Vec2::ZERO });
        let all: Vec<Jitter> = (1..=256).map(|frame| Jitter::of(frame, [2, 2])).collect();
        let mean = all.iter().map(|j| j.clip + j.lamp).sum::<Vec2>() / 256.0;
        assert!(mean.length() < 0.02, "{mean}");
        assert!(all.iter().all(|j| j.lamp.length() <= 1.0 && j.clip.abs().max_element() <= 0.5));
        assert_eq!(
            [radical_inverse(1, 2), radical_inverse(6, 2), radical_inverse(5, 3)],
            [0.5, 0.375, 7.0 / 9.0]
        );
    }
}
