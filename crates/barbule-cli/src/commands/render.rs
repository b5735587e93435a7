//! `barbule render`: a picture of a preset or a scene.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use barbule::brdf::{FeatherBrdf, Options};
use barbule::characterize::thinned;
use barbule::io::image::{RgbImage, read_exr};
use barbule::io::{check_writable, hash_file, read_at_most, write_whole};
use barbule::picture::{Developed, Set, bytes_needed, check_kind};
use barbule::progress::Progress as _;
use barbule::render::checkpoint;
use barbule::render::film::{Film, check_size};
use barbule::render::run::{Ended, Goal};
use barbule::scene::description::{Bearing, SceneDescription, SkyDescription, SkyImage};
use barbule::scene::sky::Sky;
use barbule::{Error, Result};

use crate::common::{Common, path_json, print_json};
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::sets;
use crate::{materials, scene_arg};

/// Arguments of `barbule render`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule render starling -o starling.png\n  \
    barbule render my-bird.toml -o my-bird.png")]
pub(crate) struct Args {
    #[arg(value_name = "PRESET|SPECIES:VARIANT|SCENE", help = scene_arg::HELP)]
    scene: String,
    /// The picture: .png or .exr
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Another material than the scene's
    #[arg(long, value_name = "NAME|FILE|STRUCTURE", long_help = materials::HELP)]
    material: Option<String>,
    /// Width and height in pixels [default: 1280x800]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Most samples per pixel [default: 16; 4096 with --noise or --time]
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
    /// Stop after this time, as in 30s, 5m or 1h
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time: Option<Duration>,
    /// Stop where the noise is below this many percent of the brightness
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    noise: Option<f64>,
    /// Azimuth and elevation of the key light, degrees
    #[arg(long, value_name = "AZ,EL", allow_hyphen_values = true, value_parser = light)]
    light: Option<Bearing>,
    /// Azimuth and elevation of the camera, degrees, and the width of the picture in mm
    #[arg(long, value_name = "AZ,EL[,MM]", allow_hyphen_values = true, value_parser = view)]
    view: Option<View>,
    /// This many pictures F-0000, F-0001 … with the light going round
    #[arg(long, value_name = "N", default_value_t = 1)]
    frames: u32,
    /// Go on from F.checkpoint if it is there, and keep one
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    common: Common,
}

/// From where `--view` looks, and the width in mm where it says so.
#[derive(Debug, Clone, Copy)]
struct View {
    bearing: Bearing,
    width_mm: Option<f64>,
}

/// How often a checkpoint is written.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(15);

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let description = self.description()?;
        let size = self.size.or(description.size).unwrap_or([1280, 800]);
        let goal = self.goal()?;
        if !(1..=9999).contains(&self.frames) {
            return Err(Error::input(format!("--frames {}: give 1 to 9999", self.frames)));
        }
        check_size(size)?;
        let [width, height] = size;
        let what = format!("a picture of {width}x{height} pixels");
        self.common.allowance().check(&what, bytes_needed(size), "a smaller --size")?;
        let files: Vec<PathBuf> = (0..self.frames).map(|frame| self.file(frame)).collect();
        files.iter().try_for_each(|file| {
            check_kind(file).map_err(|e| e.at("-o")).and_then(|()| check_writable(file))
        })?;
        let image = match &description.sky {
            SkyDescription::Image(image) if image.strength > 0.0 => Some(self.sky(image)?),
            SkyDescription::Image(_) | SkyDescription::Gradient(_) => None,
        };
        let (sky, sky_name) = image.unzip();
        let (material, hash) = materials::find(&description.material, &self.common)?;
        let thinned = thinned(&material);
        if let Some(every) = thinned {
            self.common.say(&format!(
                "the material is thinned, a quick look: every {every} wavelengths and directions, {} instances",
                material.info["campaign"]["instances"]
            ));
        }
        let brdf = Arc::new(FeatherBrdf::new(&material, Options::default())?);
        let terminal = Terminal::new(&self.common).keeping_what_is_done();
        let set = self.set(&description, brdf, sky)?;
        let mut reports = Vec::new();
        for (frame, file) in files.iter().enumerate() {
            let mut description = description.clone();
            description.light.bearing.azimuth_deg += 360.0 * frame as f64 / f64::from(self.frames);
            let job = Job { file, size, goal, hash: &hash, thinned, sky_name: sky_name.as_deref() };
            reports.push(self.picture(&description, &set, &job, &terminal)?);
        }
        if self.common.json {
            print_json(out, &reports)?;
        }
        Ok(())
    }

    /// The scene with the changes that the flags ask for.
    fn description(&self) -> Result<SceneDescription> {
        let mut description = scene_arg::parse(&self.scene, &self.common)?;
        if let Some(material) = &self.material {
            description.material.clone_from(material);
        }
        if let Some(bearing) = self.light {
            description.light.bearing = bearing;
            description.check().map_err(|e| e.at("--light"))?;
        }
        if let Some(View { bearing, width_mm }) = self.view {
            description.camera.bearing = bearing;
            description.camera.width_mm = width_mm.unwrap_or(description.camera.width_mm);
            description.check().map_err(|e| e.at("--view"))?;
        }
        if description.is_lit_from_behind() {
            self.common.say(&format!(
                "the key light stands at elevation {} degrees, behind the vane as the camera sees it: only the sky lights the barbules' upper sides",
                description.light.bearing.elevation_deg
            ));
        }
        Ok(description)
    }

    /// A scene's image of the sky, and a name that changes with it.
    fn sky(&self, image: &SkyImage) -> Result<(Sky, String)> {
        let path = Path::new(&self.scene).with_file_name(&image.file);
        let RgbImage { size: [width, height], pixels } = read_exr(&path)?;
        let sky = Sky::image(width, height, pixels, image.strength, image.turn_deg)
            .map_err(|e| e.at(path.display()))?;
        Ok((sky, format!("{} {} {}", hash_file(&path)?, image.strength, image.turn_deg)))
    }

    fn goal(&self) -> Result<Goal> {
        if let Some(noise) = self.noise
            && !(noise > 0.0 && noise <= 100.0)
        {
            return Err(Error::input(format!("--noise {noise}: give percent, over 0 and up to 100")));
        }
        let open_ended = self.time.is_some() || self.noise.is_some();
        let samples = self.samples.unwrap_or(if open_ended { 4096 } else { 16 });
        if !(1..=1 << 24).contains(&samples) {
            return Err(Error::input(format!("--samples {samples}: give 1 to 16777216")));
        }
        Ok(Goal { samples, noise: self.noise.map(|percent| percent / 100.0), time: self.time })
    }

    /// The file of a frame: `F.png`, or `F-0007.png` in a sequence.
    fn file(&self, frame: u32) -> PathBuf {
        if self.frames == 1 {
            return self.output.clone();
        }
        let part = |s: Option<&std::ffi::OsStr>| s.unwrap_or_default().to_string_lossy().into_owned();
        let name = format!("{}-{frame:04}.{}", part(self.output.file_stem()), part(self.output.extension()));
        self.output.with_file_name(name)
    }

    /// What all frames share: the feather with its hierarchy, and the sky.
    fn set(&self, description: &SceneDescription, brdf: Arc<FeatherBrdf>, sky: Option<Sky>) -> Result<Set> {
        let begun = Instant::now();
        let set = Set::new(description, brdf, sky, self.common.seed)?;
        let counts = set.counts();
        self.common.explain(&format!(
            "{} barbs, {} barbules, {} primitives; ready in {:.2} s",
            counts.barbs,
            counts.barbules,
            set.primitives(),
            begun.elapsed().as_secs_f64()
        ));
        Ok(set)
    }

    fn picture(
        &self,
        description: &SceneDescription,
        set: &Set,
        job: &Job<'_>,
        terminal: &Terminal,
    ) -> Result<serde_json::Value> {
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
        let name = checkpoint::name(description, job.hash, seed, program, job.sky_name.unwrap_or_default());
        let kept = job.checkpoint();
        let mut film = if self.resume && kept.exists() {
            let bytes = read_at_most(&kept, checkpoint::bytes(job.size))?;
            checkpoint::read(&bytes, &name, job.size).map_err(|e| e.at(kept.display()))?
        } else {
            Film::new(job.size)?
        };
        let before = film.samples();
        let begun = Instant::now();
        let mut last = Instant::now();
        // A picture is worth more than what it could go on from: a full disk does not end it.
        let keep = |film: &Film| write_whole(&kept, &checkpoint::write(film, &name));
        let mut said = false;
        let ended = set.render(description, &mut film, seed, job.goal, terminal, &mut |film| {
            if self.resume && last.elapsed() > CHECKPOINT_EVERY {
                if let Err(error) = keep(film)
                    && !std::mem::replace(&mut said, true)
                {
                    self.common.say(&format!("{error}; rendering goes on without it"));
                }
                last = Instant::now();
            }
            Ok(())
        })?;
        let seconds = begun.elapsed().as_secs_f64();
        let picture = Developed::new(job.file, &film, description.exposure)?;
        let provenance = self.provenance(description, job, &film).with("pixel_hash", picture.pixel_hash());
        if film.samples() > 0 {
            picture.write(&provenance.notes())?;
            self.common.wrote(job.file, &shown(description, job, &film));
        }
        if self.resume {
            let written = if film.samples() > 0 { "; the picture itself is written" } else { "" };
            keep(&film).map_err(|error| error.followed_by(written))?;
        }
        if ended == Ended::Stopped || terminal.is_cancelled() {
            return Err(self.interrupted(job, &film));
        }
        let (counts, paths) = (set.counts(), film.samples() - before);
        self.common.explain(&format!("{paths} paths in {seconds:.1} s"));
        let mut report = serde_json::json!({
            "output": path_json(job.file), "width": job.size[0], "height": job.size[1],
            "barbs": counts.barbs, "barbules": counts.barbules, "primitives": set.primitives(),
            "paths": paths, "seconds": seconds, "paths_per_second": paths as f64 / seconds.max(1e-9),
            "ended": if ended == Ended::OutOfTime { "time" } else { "done" },
        });
        if let (Some(report), serde_json::Value::Object(notes)) = (report.as_object_mut(), provenance.json())
        {
            report.extend(notes);
        }
        Ok(report)
    }

    /// Where the work was when Ctrl-C ended it, and how it goes on.
    fn interrupted(&self, job: &Job<'_>, film: &Film) -> Error {
        let pixels = f64::from(job.size[0]) * f64::from(job.size[1]);
        let samples = film.samples() as f64 / pixels;
        if samples == 0.0 {
            return Error::interrupted_after("no sample is done, nothing is written");
        }
        let (most, file) = (job.goal.samples, job.file.display());
        let next = if self.resume { "the same command goes on" } else { "with --resume it could go on" };
        Error::interrupted_after(format!(
            "{samples:.1} of {most} samples done; {file} shows what is done; {next}"
        ))
    }

    /// What a picture says about itself.
    fn provenance(&self, description: &SceneDescription, job: &Job<'_>, film: &Film) -> Provenance {
        let (light, view) = (&description.light.bearing, &description.camera.bearing);
        let width_mm = description.camera.width_mm;
        let provenance = Provenance::new(&self.common)
            .with("material", &description.material)
            .with("material_hash", job.hash)
            .with("samples", format!("{:.1}", job.samples(film)))
            .with("light", format!("{},{}", light.azimuth_deg, light.elevation_deg))
            .with("view", format!("{},{},{width_mm}", view.azimuth_deg, view.elevation_deg))
            .with("exposure", description.exposure.to_string());
        match job.thinned {
            Some(every) => provenance.with("thinned", every.to_string()),
            None => provenance,
        }
    }
}

/// What a picture shows, in a line.
fn shown(description: &SceneDescription, job: &Job<'_>, film: &Film) -> String {
    let light = &description.light.bearing;
    format!(
        "{}{}, light {},{}, {} x {} pixels, {:.1} samples each",
        description.material,
        if job.thinned.is_some() { " (thinned)" } else { "" },
        light.azimuth_deg,
        light.elevation_deg,
        job.size[0],
        job.size[1],
        job.samples(film)
    )
}

/// One picture to be made.
struct Job<'a> {
    file: &'a Path,
    size: [u32; 2],
    goal: Goal,
    hash: &'a str,
    /// Of a material that was simulated as a quick look: every how many-th wavelength and direction was.
    thinned: Option<usize>,
    /// Of an image in place of the plain sky, a name that changes with it.
    sky_name: Option<&'a str>,
}

impl Job<'_> {
    /// Samples per pixel, in the mean.
    fn samples(&self, film: &Film) -> f64 {
        film.samples() as f64 / (f64::from(self.size[0]) * f64::from(self.size[1]))
    }

    fn checkpoint(&self) -> PathBuf {
        let mut name = self.file.as_os_str().to_owned();
        name.push(".checkpoint");
        name.into()
    }
}

/// Width and height, as in 1280x800.
fn size(text: &str) -> Result<[u32; 2]> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.ok_or_else(|| {
        Error::input(format!("--size {text}: give width and height in pixels, as in 1280x800"))
    })
}

/// Azimuth and elevation of the key light.
fn light(text: &str) -> Result<Bearing> {
    let [azimuth_deg, elevation_deg] = sets::parse("--light", text)?[..] else {
        return Err(Error::input(format!("--light {text}: give azimuth and elevation, as in 40,60")));
    };
    Ok(Bearing { azimuth_deg, elevation_deg })
}

/// Azimuth and elevation of the camera, and perhaps a width.
fn view(text: &str) -> Result<View> {
    let numbers = sets::parse("--view", text)?;
    let ([azimuth_deg, elevation_deg] | [azimuth_deg, elevation_deg, _]) = numbers[..] else {
        return Err(Error::input(format!(
            "--view {text}: give azimuth, elevation and perhaps the width in mm, as in 190,58,4.4"
        )));
    };
    Ok(View { bearing: Bearing { azimuth_deg, elevation_deg }, width_mm: numbers.get(2).copied() })
}

/// A time: a number with an optional unit s, m or h.
fn duration(text: &str) -> Result<Duration> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let unit = match &text[split..] {
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => f64::NAN,
    };
    match text[..split].trim().parse::<f64>().map(|value| value * unit) {
        Ok(seconds) if seconds > 0.0 && seconds < 1e7 => Ok(Duration::from_secs_f64(seconds)),
        _ => Err(Error::input(format!("--time {text}: give a time such as 30s, 5m or 1h"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_their_units() {
        assert_eq!(duration("30s").unwrap(), Duration::from_secs(30));
        assert_eq!(duration("1.5m").unwrap(), Duration::from_secs(90));
        for bad in ["", "s", "-3s", "0", "5d", "inf"] {
            assert!(duration(bad).unwrap_err().is_input(), "{bad}");
        }
    }
}
