//! Pictures, and times of frames, without a window, on any adapter.

mod bench;

use barbule::io::image::write_png;
use barbule::{Picture, PictureOptions, Unobserved};

pub use bench::bench;

use crate::arguments::Request;
use crate::gpu::{Gpu, Target};
use crate::live::{MaterialFound, MaterialJob, ShowJob, material, show};
use crate::show::look;
use crate::stage::{Show, Stage};
use crate::state::{Mode, State};
use crate::{Error, Result};

/// What is drawn into.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Frames of a picture at most; the stage wants fewer.
const MOST_FRAMES: u32 = 4096;
/// Samples of a scene's picture.
const SAMPLES: u32 = 16;

/// Draws a picture and writes it: of a stage its frames until more would not make it better, of a scene the renderer's.
///
/// # Errors
/// No adapter, nothing to be drawn, or a file that cannot be written.
pub fn screenshot(request: &Request) -> Result<()> {
    let Request { state, size, file, .. } = request;
    let Some(file) = file else { return Err(Error::input("--screenshot names no file")) };
    if state.view().mode == Mode::Scene {
        let scene = ShowJob::of(state, None)?.scene(&Unobserved)?;
        let samples = request.frames.unwrap_or(SAMPLES);
        let options = PictureOptions { size: *size, samples, ..PictureOptions::default() };
        return Picture::of(&scene, &options, &Unobserved)?.save(file);
    }
    let gpu = Gpu::new(None)?;
    let mut stage = Stage::new(gpu, FORMAT)?;
    stage.coarsen(1);
    stage.put(&shown(state)?)?;
    let look = look(state.view());
    for _ in 0..request.frames.unwrap_or(MOST_FRAMES) {
        if !stage.draw(*size, &look)? {
            break;
        }
    }
    let target = Target::new(stage.gpu(), *size, FORMAT)?;
    let pixels = pixels(&stage, &target)?;
    let title = state.subject().title();
    let software = format!("barbule-view {}", env!("CARGO_PKG_VERSION"));
    write_png(file, *size, &pixels, false, &[("Software", &software), ("Title", &title)])
}

/// What a stage shows of a state: in its material where there is one, else in what is known of its mean.
fn shown(state: &State) -> Result<Show> {
    let mut found: Option<MaterialFound> = None;
    if let Some(structure) = state.structure()?.filter(|_| state.subject().stack().is_none()) {
        // What is not there is not made: that takes minutes.
        let opening = barbule::open::Opening { may_compute: false, ..state.opening().clone() };
        material(&MaterialJob { structure, opening, whole: false }, &Unobserved, &mut |made| {
            found = Some(made)
        })?;
    }
    let mut last = None;
    show(&ShowJob::of(state, found.as_ref())?, &Unobserved, &mut |made| last = Some(made))?;
    last.ok_or_else(|| Error::machine("there is nothing to be shown"))
}

/// The picture's bytes, row by row: red, green, blue.
fn pixels(stage: &Stage, target: &Target) -> Result<Vec<u8>> {
    target.draw(stage.gpu(), |pass| stage.paint(pass))?;
    let bytes = target.read(stage.gpu())?;
    Ok(bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect())
}
