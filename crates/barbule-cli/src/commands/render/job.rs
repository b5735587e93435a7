//! One picture: drawn, developed, written with what it says about itself.

use std::path::Path;
use std::time::Instant;

use barbule::error::shortened;
use barbule::picture::{Cleaner, Developed, Set, development};
use barbule::progress::Progress as _;
use barbule::render::checkpoint;
use barbule::render::exposure::clipped;
use barbule::render::faults::Faults;
use barbule::render::film::Film;
use barbule::render::planes::Planes;
use barbule::render::run::{Ended, Goal};
use barbule::scene::description::{ReadyScene, SceneDescription};
use barbule::{Error, Result};

use super::checkpoints::Checkpoints;
use super::noise::Noise;
use super::{Args, lamps};
use crate::common::path_json;
use crate::progress::Terminal;
use crate::provenance::Provenance;

impl Args {
    /// Draws one frame; gives its report, its exposure, and why it ended.
    pub(super) fn picture(
        &self,
        description: &ReadyScene,
        set: &Set,
        job: &Job<'_>,
        checkpoints: &Checkpoints<'_>,
        terminal: &Terminal,
    ) -> Result<(serde_json::Value, f64, Ended)> {
        let seed = self.common.seed;
        let (light, view) = (&description.light.bearing, &description.camera.bearing);
        self.common.explain(&format!(
            "light {},{}; view {},{},{}",
            light.azimuth_deg,
            light.elevation_deg,
            view.azimuth_deg,
            view.elevation_deg,
            description.camera.width_mm
        ));
        let program = env!("CARGO_PKG_VERSION");
        let name = checkpoint::name(&**description, seed, program, job.planes);
        let mut kept = checkpoints.of(job, name);
        let mut film = kept.film(job)?;
        let (parts, joined) = self.join(description, job, &mut film)?;
        let before = film.samples();
        let begun = Instant::now();
        let (mut last_seen, mut said) = (Instant::now(), false);
        let ended = set.render(description, &mut film, seed, job.goal, terminal, &mut |film| {
            kept.now_and_then(film);
            if self.preview.is_some_and(|every| last_seen.elapsed() >= every) {
                if let Err(error) = self.write_preview(description, job, film)
                    && !std::mem::replace(&mut said, true)
                {
                    self.common.say(&format!("{error}; rendering goes on without a preview"));
                }
                last_seen = Instant::now();
            }
            Ok(())
        })?;
        let seconds = begun.elapsed().as_secs_f64();
        let noise = job.goal.noise.map(|target| Noise::of(&film, target, &job.goal, ended));
        let (picture, provenance, exposure) =
            self.developed(description, job, &film, (noise.as_ref(), job.cleaner))?;
        let provenance = provenance.with("pixel_hash", picture.pixel_hash());
        if film.samples() > 0 {
            picture.write(&provenance.notes())?;
            let lamps = lamps::line(&description.told_lamps()?);
            self.common.wrote(job.file, &shown(description, job, (&film, &lamps), noise.as_ref()));
            self.write_human(description, job, &mut film)?;
            self.say_faults(&film.faults(), description);
        }
        // One picture that is done needs none; those of a sequence are done together.
        let is_stopped = ended == Ended::Stopped || terminal.is_cancelled();
        if is_stopped || ended != Ended::Done || self.frames > 1 {
            kept.at_the_end(&film);
        }
        if is_stopped {
            return Err(self.interrupted(job, &film, checkpoints));
        }
        if ended == Ended::Done {
            parts.delete(&joined.taken)?;
        }
        let (counts, paths) = (set.counts(), film.samples() - before);
        self.common.explain(&format!("{paths} paths in {seconds:.1} s"));
        let mut report = serde_json::json!({
            "output": path_json(job.file), "width": job.size[0], "height": job.size[1],
            "barbs": counts.barbs, "barbules": counts.barbules, "primitives": set.primitives(),
            "paths": paths, "seconds": seconds, "paths_per_second": paths as f64 / seconds.max(1e-9),
            "clipped": clipped(&film, exposure),
            "ended": if ended == Ended::OutOfTime { "time" } else { "done" },
            "impossible_samples": film.faults().count,
        });
        if let (Some(report), serde_json::Value::Object(notes)) = (report.as_object_mut(), provenance.json())
        {
            report.extend(notes);
            report.extend(noise.iter().flat_map(Noise::json));
            report.insert("lamps".to_owned(), lamps::json(&description.told_lamps()?));
        }
        Ok((report, exposure, ended))
    }

    /// Writes a picture as it is so far.
    fn write_preview(&self, description: &ReadyScene, job: &Job<'_>, film: &Film) -> Result<()> {
        let (picture, provenance, _) = self.developed(description, job, film, (None, None))?;
        picture.write(&provenance.with("preview", "yes").notes())
    }

    /// Says how many samples no light could make, and where the first of them was.
    pub(super) fn say_faults(&self, faults: &Faults, description: &ReadyScene) {
        let Some(first) = faults.first else { return };
        let names = description.object_names();
        let object = first.object.and_then(|object| names.get(object as usize));
        let of = object.map_or_else(|| "what is behind the scene".to_owned(), |name| shortened(name));
        let [x, y] = first.pixel;
        self.common.say(&format!(
            "{} impossible samples (not finite, or negative) are left out, the first in pixel {x},{y} of {of}: a fault of its material or of this program; please report it",
            faults.count
        ));
    }

    /// A film as the picture that it is so far, what it says about itself, and its exposure.
    fn developed<'a>(
        &self,
        description: &ReadyScene,
        job: &Job<'a>,
        film: &Film,
        (noise, cleaner): (Option<&Noise>, Option<&Cleaner>),
    ) -> Result<(Developed<'a>, Provenance, f64)> {
        let mut development = development(description, film)?;
        development.keeps_gamut = self.keep_gamut;
        development.denoised = cleaner.map(|cleaner| cleaner.clean(film)).transpose()?;
        let exposure = development.exposure;
        let picture = Developed::new(job.file, film, &development, &description.object_names())?;
        let provenance = self.provenance(description, job, film, exposure);
        let provenance = match noise {
            Some(noise) => provenance.with("noise", noise.to_string()),
            None => provenance,
        };
        let provenance = match cleaner {
            Some(cleaner) => provenance.with("denoised_by", cleaner.name()),
            None => provenance,
        };
        let provenance = provenance.with("lamps", lamps::words(&description.told_lamps()?));
        Ok((picture, provenance, exposure))
    }

    /// Where the work was when Ctrl-C ended it, and how it goes on.
    fn interrupted(&self, job: &Job<'_>, film: &Film, checkpoints: &Checkpoints<'_>) -> Error {
        let pixels = f64::from(job.size[0]) * f64::from(job.size[1]);
        let samples = film.samples() as f64 / pixels;
        if samples == 0.0 {
            return Error::interrupted_after("no sample is done, nothing is written");
        }
        let (most, file) = (job.goal.samples, job.file.display());
        let next = match (self.resume, checkpoints.lack_one()) {
            (true, false) => "the same command goes on",
            (true, true) => "there is no checkpoint to go on from",
            (false, _) => "with --resume it could go on",
        };
        Error::interrupted_after(format!(
            "{samples:.1} of {most} samples done; {file} shows what is done; {next}"
        ))
    }

    /// What a picture says about itself.
    pub(super) fn provenance(
        &self,
        description: &SceneDescription,
        job: &Job<'_>,
        film: &Film,
        exposure: f64,
    ) -> Provenance {
        let (light, view) = (&description.light.bearing, &description.camera.bearing);
        let width_mm = description.camera.width_mm;
        let provenance = Provenance::new(&self.common)
            .with("material", job.wardrobe.names.join(", "))
            .with("material_hash", job.wardrobe.hash())
            .with("samples", format!("{:.1}", job.samples(film)))
            .with("light", format!("{},{}", light.azimuth_deg, light.elevation_deg))
            .with("view", format!("{},{},{width_mm}", view.azimuth_deg, view.elevation_deg))
            .with("exposure", exposure.to_string())
            .with("exposure_by", if description.exposure.factor().is_some() { "factor" } else { "key" })
            .with("tone", description.tone.0.word())
            .with("white_balance", description.white_balance.to_string());
        let provenance = match self.quality {
            Some(quality) => provenance.with("quality", quality.word()),
            None => provenance,
        };
        let provenance = self.say_sensor(provenance, &job.planes.sensor);
        match job.wardrobe.thinned {
            Some(every) => provenance.with("thinned", every.to_string()),
            None => provenance,
        }
    }
}

/// What a picture shows, in a line.
fn shown(
    description: &SceneDescription,
    job: &Job<'_>,
    (film, lamps): (&Film, &str),
    noise: Option<&Noise>,
) -> String {
    let mut parts = Vec::new();
    if !job.wardrobe.names.is_empty() {
        let thinned = if job.wardrobe.thinned.is_some() { " (thinned)" } else { "" };
        parts.push(format!("{}{thinned}", job.wardrobe.names.join(", ")));
    }
    // A key light that does not shine stands nowhere.
    if description.light.strength > 0.0 {
        let light = &description.light.bearing;
        parts.push(format!("light {},{}", light.azimuth_deg, light.elevation_deg));
    }
    let [width, height] = job.size;
    parts.push(format!("{width} x {height} pixels, {:.1} samples each", job.samples(film)));
    parts.extend(noise.map(|noise| format!("noise {noise}")));
    parts.extend(job.cleaner.map(|cleaner| format!("denoised by {}", cleaner.name())));
    parts.push(lamps.to_owned());
    parts.join(", ")
}

/// The materials that a scene's barbules wear.
#[derive(Debug, Default)]
pub(super) struct Wardrobe {
    pub(super) names: Vec<String>,
    /// BLAKE3 of their bytes.
    pub(super) hashes: Vec<String>,
    /// Where one was simulated as a quick look: every how many-th wavelength and direction was, at most.
    pub(super) thinned: Option<usize>,
}

impl Wardrobe {
    /// What names all of them.
    fn hash(&self) -> String {
        if self.hashes.is_empty() { "none".to_owned() } else { self.hashes.join(", ") }
    }
}

/// One picture to be made.
pub(super) struct Job<'a> {
    pub(super) file: &'a Path,
    /// What people see goes here.
    pub(super) human: Option<&'a Path>,
    pub(super) size: [u32; 2],
    pub(super) goal: Goal,
    /// What the barbules wear.
    pub(super) wardrobe: &'a Wardrobe,
    /// What the film keeps.
    pub(super) planes: &'a Planes,
    /// What takes its noise away at the end.
    pub(super) cleaner: Option<&'a Cleaner>,
}

impl Job<'_> {
    /// Samples per pixel, in the mean.
    fn samples(&self, film: &Film) -> f64 {
        film.samples() as f64 / (f64::from(self.size[0]) * f64::from(self.size[1]))
    }
}
