//! Times of frames.

use std::io::{IsTerminal as _, Write as _};
use std::time::{Duration, Instant};

use super::{FORMAT, pixels, shown};
use crate::arguments::Request;
use crate::gpu::{Gpu, Target};
use crate::show::look;
use crate::stage::{Look, Stage};
use crate::state::Mode;
use crate::{Error, Result};

/// Frames that are timed, and by how many degrees the lamp turns from one to the next, so that each is a new picture.
const FRAMES: u32 = 60;
const TURN_DEG: f64 = 1.0;

/// A stage whose lamp turns.
struct Turning<'a> {
    request: &'a Request,
    stage: Stage,
    target: Target,
    seen: Look,
    turned_deg: f64,
}

/// Times of frames, rising.
struct Times(Vec<Duration>);

impl Turning<'_> {
    /// Frames one after the other, each done before the next begins.
    fn timed(&mut self) -> Result<Times> {
        let Request { state, size, frames, .. } = self.request;
        let (mut times, count) = (Vec::new(), frames.unwrap_or(FRAMES));
        let begun = Instant::now();
        for frame in 0..count {
            show_left(frame, count, begun.elapsed());
            self.turned_deg += TURN_DEG;
            self.seen.to_lamp = state.view().light.moved([self.turned_deg, 0.0]).direction();
            let start = Instant::now();
            self.stage.draw(*size, &self.seen)?;
            self.target.draw(self.stage.gpu(), |pass| self.stage.paint(pass))?;
            self.stage.gpu().wait()?;
            times.push(start.elapsed());
        }
        show_left(count, count, begun.elapsed());
        times.sort();
        Ok(Times(times))
    }

    /// How many frames more a picture takes that rests, and how long.
    fn rested(&mut self) -> Result<(u32, Duration)> {
        let (start, mut frames) = (Instant::now(), 1);
        while self.stage.draw(self.request.size, &self.seen)? {
            frames += 1;
        }
        self.stage.gpu().wait()?;
        Ok((frames, start.elapsed()))
    }
}

/// Says on a terminal how many frames are timed, once that takes long.
fn show_left(done: u32, all: u32, elapsed: Duration) {
    let mut terminal = std::io::stderr();
    if done == 0 || elapsed < Duration::from_secs(2) || !terminal.is_terminal() {
        return;
    }
    let left = elapsed.as_secs_f64() / f64::from(done) * f64::from(all - done);
    let line = if done < all { format!("frame {done} of {all}, {left:.0} s left") } else { String::new() };
    // Back to the start of the line, and clear what is behind the new words.
    let _ = write!(terminal, "\r{line}\x1b[K");
}

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(times) = self;
        let mean = times.iter().sum::<Duration>() / times.len().max(1) as u32;
        let [least, most] = [times.first(), times.last()].map(|time| ms(time.copied().unwrap_or_default()));
        let fps = 1.0 / mean.as_secs_f64().max(1e-9);
        write!(f, "{fps:.1} fps, {:.1} ms a frame ({least:.1} to {most:.1})", ms(mean))
    }
}

fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

/// Times frames of a lamp that turns, and says what they take: lines of words.
///
/// # Errors
/// As [`super::screenshot`]; and a scene, which is drawn by the renderer.
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
    let seen = look(state.view());
    stage.draw(*size, &seen)?;
    pixels(&stage, &target)?;
    let first = begun.elapsed();
    let coarse = stage.coarse();
    let mut turning = Turning { request, stage, target, seen, turned_deg: 0.0 };
    let moving = turning.timed()?;
    turning.stage.coarsen(1);
    let whole = if coarse > 1 { Some(turning.timed()?) } else { None };
    let (refined, rest) = turning.rested()?;
    let stage = &turning.stage;
    let software = if stage.gpu().is_software() { ", in software" } else { "" };
    let [width, height] = size;
    let (title, mode, triangles) =
        (state.subject().title(), state.view().mode.word(), show.shape.triangles.len());
    let mut lines = vec![
        ("adapter", format!("{}{software}", stage.gpu())),
        ("picture", format!("{title} as {mode}, {width} x {height}, {triangles} triangles")),
        (
            "start-up",
            format!(
                "{:.0} ms to the first picture: {:.0} for shape and material, {:.0} for adapter and shaders, {:.0} for tables and frame",
                ms(first),
                ms(made),
                ms(compiled),
                ms(first - made - compiled)
            ),
        ),
        (
            "frames",
            format!("{} of {} wavelengths each", whole.as_ref().unwrap_or(&moving), stage.waves_of_a_frame()),
        ),
    ];
    if whole.is_some() {
        let [width, height] = size.map(|side| side.div_ceil(coarse));
        lines.push((
            "moving",
            format!("{moving}, drawn as {width} x {height} on this adapter while it moves"),
        ));
    }
    lines.push(("at rest", format!(
        "{refined} frames more, {:.0} ms, until all wavelengths, the lamp's disc and the pixels' areas are through",
        ms(rest)
    )));
    lines.push(("memory", format!("{:.1} MB of tables and mesh on the adapter", stage.bytes() as f64 / 1e6)));
    Ok(lines.iter().map(|(name, words)| format!("{name:<10} {words}")).collect::<Vec<_>>().join("\n"))
}
