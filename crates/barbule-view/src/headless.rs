//! Pictures, and times of frames, without a window, on any adapter.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use barbule::io::image::write_png;
use barbule::{Picture, PictureOptions, Unobserved};

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
/// Frames that are timed, and by how many degrees the lamp turns from one to the next, so that each is a new picture.
const FRAMES: u32 = 60;
const TURN_DEG: f64 = 1.0;

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

/// Times frames of a lamp that turns, and says what they take: lines of words.
///
/// # Errors
/// As [`screenshot`]; and a scene, which is drawn by the renderer.
pub fn bench(request: &Request) -> Result<String> {
    let Request { state, size, .. } = request;
    if state.view().mode == Mode::Scene {
        return Err(Error::input(
            "a scene is drawn by the renderer, whose times `barbule bench render` says; give another --mode",
        ));
    }
    let begun = Instant::now();
    let show = shown(state)?;
    let made = begun.elapsed();
    let gpu = Gpu::new(None)?;
    let mut stage = Stage::new(gpu, FORMAT)?;
    let compiled = begun.elapsed() - made;
    stage.put(&show)?;
    let target = Target::new(stage.gpu(), *size, FORMAT)?;
    let mut seen = look(state.view());
    stage.draw(*size, &seen)?;
    pixels(&stage, &target)?;
    let first = begun.elapsed();
    let mut took = Vec::new();
    for turn in 1..=request.frames.unwrap_or(FRAMES) {
        let light = state.view().light.moved([TURN_DEG * f64::from(turn), 0.0]);
        seen.to_lamp = light.direction();
        let start = Instant::now();
        stage.draw(*size, &seen)?;
        target.draw(stage.gpu(), |pass| stage.paint(pass))?;
        stage.gpu().wait()?;
        took.push(start.elapsed());
    }
    let start = Instant::now();
    let mut refined = 1;
    while stage.draw(*size, &seen)? {
        refined += 1;
    }
    stage.gpu().wait()?;
    let rest = start.elapsed();
    took.sort();
    let mean = took.iter().sum::<Duration>() / took.len().max(1) as u32;
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let mut text = String::new();
    let mut line = |name: &str, words: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<10} {words}");
    };
    let software = if stage.gpu().is_software() { ", in software" } else { "" };
    let [width, height] = size;
    line("adapter", format!("{}{software}", stage.gpu()));
    let mode = state.view().mode.word();
    line(
        "picture",
        format!(
            "{} as {mode}, {width} x {height}, {} triangles",
            state.subject().title(),
            show.shape.triangles.len()
        ),
    );
    line(
        "start-up",
        format!(
            "{:.0} ms to the first picture: {:.0} for shape and material, {:.0} for adapter and shaders, {:.0} for tables and frame",
            ms(first),
            ms(made),
            ms(compiled),
            ms(first - made - compiled)
        ),
    );
    line(
        "frames",
        format!(
            "{:.1} fps, {:.1} ms a frame ({:.1} to {:.1}) of {} wavelengths each",
            1.0 / mean.as_secs_f64().max(1e-9),
            ms(mean),
            ms(took[0]),
            ms(took[took.len() - 1]),
            stage.waves_of_a_frame()
        ),
    );
    line(
        "at rest",
        format!(
            "{refined} frames more, {:.0} ms, until all wavelengths, the lamp's disc and the pixels' areas are through",
            ms(rest)
        ),
    );
    line("memory", format!("{:.1} MB of tables and mesh on the adapter", stage.bytes() as f64 / 1e6));
    Ok(text.trim_end().to_owned())
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
