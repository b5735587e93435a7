//! `barbule render`: a picture of a preset or a scene.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use barbule::brdf::{FeatherBrdf, Options};
use barbule::io::image::{Channel, ChannelValues, write_exr, write_png};
use barbule::render::film::Film;
use barbule::render::integrator::Integrator;
use barbule::render::{run, tone};
use barbule::scene::emission::Emission;
use barbule::scene::preset::{self, Bearing, Changes};
use barbule::{Error, Result};

use crate::common::Common;
use crate::progress::Terminal;

/// Arguments of `barbule render`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule render starling -o starling.png")]
pub(crate) struct Args {
    /// A preset, SPECIES:VARIANT, or a scene file (.toml)
    #[arg(value_name = "PRESET|SPECIES:VARIANT|SCENE")]
    scene: String,
    /// The picture: .png or .exr
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Another material: its name or a .barbule file
    #[arg(long, value_name = "NAME|FILE")]
    material: Option<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x800")]
    size: String,
    /// Most samples per pixel
    #[arg(long, value_name = "N", default_value_t = 32)]
    samples: u32,
    /// Azimuth and elevation of the key light, degrees
    #[arg(long, value_name = "AZ,EL", allow_hyphen_values = true)]
    light: Option<String>,
    /// Azimuth and elevation of the camera, degrees, and the picture's width in mm
    #[arg(long, value_name = "AZ,EL[,MM]", allow_hyphen_values = true)]
    view: Option<String>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let (w, h) = self.size.split_once('x').ok_or_else(|| Error::input("size"))?;
        let size = [w.parse().unwrap_or(0), h.parse().unwrap_or(0)];
        let preset = preset::named(&self.scene)?;
        let brdf = Arc::new(FeatherBrdf::new(&barbule::brdf::example(50), Options::default())?);
        let nums = |t: &Option<String>| -> Vec<f64> {
            t.as_ref().map(|t| t.split(',').filter_map(|x| x.parse().ok()).collect()).unwrap_or_default()
        };
        let bearing = |v: &[f64]| (v.len() >= 2).then(|| Bearing { azimuth: v[0], elevation: v[1] });
        let view = nums(&self.view);
        let changes = Changes {
            light: bearing(&nums(&self.light)),
            view: bearing(&view),
            width_mm: view.get(2).copied(),
            turn: 0.0,
        };
        let daylight = Emission::new(|w| barbule::render::colour::d65(w) / barbule::render::colour::d65(560.0))?;
        let begun = Instant::now();
        let (scene, counts) = preset.scene(brdf, &daylight, &changes, self.common.seed)?;
        let integrator = Integrator::new(&scene);
        self.common.say(&format!("{} barbs, {} barbules, {} primitives; {:.2} s", counts.barbs, counts.barbules, scene.geometry.primitives(), begun.elapsed().as_secs_f64()));
        let mut film = Film::new(size)?;
        let terminal = Terminal::new(&self.common);
        let goal = run::Goal { samples: self.samples, noise: None, time: None::<Duration> };
        let begun = Instant::now();
        run::run(&integrator, &mut film, self.common.seed, goal, &terminal, &mut |_| Ok(()))?;
        let s = begun.elapsed().as_secs_f64();
        self.common.say(&format!("{:.2} s, {:.3} M paths/s", s, film.samples() as f64 / s / 1e6));
        let linear = film.linear_srgb();
        let _ = (out, Channel { name: "", values: ChannelValues::Count(vec![]) }, write_exr as usize);
        let bytes: Vec<u8> = linear.iter().flat_map(|p| tone::to_bytes(p.map(|v| f64::from(v) * preset.exposure))).collect();
        write_png(&self.output, size, &bytes, &[])
    }
}
