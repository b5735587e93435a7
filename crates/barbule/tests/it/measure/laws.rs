//! What a spectrometer behind a camera reads of rendered feathers, as they are turned in fixed light: the set-up of Osorio & Ham 2002.

use barbule::open::{Opening, scene};
use barbule::picture::Set;
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::planes::{Bands, Planes};
use barbule::render::run::Goal;
use barbule::scene::description::{ReadyScene, SceneDescription};
use barbule::spectrum::colour::Illuminant;
use barbule::spectrum::sensor::Sensor;
use barbule::spectrum::{Spectrum, Wavelengths};
use glam::{DMat3, DVec3};

/// Middles of the bands in which radiance is kept, nm: 400 to 690.
const BANDS: u32 = 30;
/// Pixels along a side of the patch.
const SIDE: u32 = 32;

/// How light, viewer and feather stand to each other. The camera looks along the vane's normal until the feather is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    /// Angle between light and viewer, degrees.
    pub(crate) between_deg: f64,
    /// Turn of the feather about the picture's upward direction, towards the light where it has the sign of `between_deg`.
    pub(crate) turn_deg: f64,
    /// Direction of the vane that is upwards in the picture, from the shaft's tip.
    pub(crate) roll_deg: f64,
}

/// A feather that is grown once and looked at in many poses, over the patch that its preset looks at.
pub(crate) struct Patch {
    set: Set,
    scene: ReadyScene,
    preset: String,
    width_mm: f64,
}

impl Patch {
    /// A patch of a preset's feather, `width_mm` wide.
    pub(crate) fn of(preset: &str, width_mm: f64) -> Self {
        let scene = scene(preset, &Opening::default(), &Unobserved).unwrap();
        let set = Set::new(&scene, 1, &Unobserved).unwrap();
        Self { set, scene, preset: preset.to_owned(), width_mm }
    }

    /// Its radiance under a small lamp of the same power at all wavelengths, in units of the picture's; of all of it, or of what the
    /// object `part` mostly fills.
    pub(crate) fn lit(&self, pose: Pose, part: Option<&str>, samples: u32) -> Spectrum {
        let lamp = format!(
            "[[lights]]\ntype = 'sun'\nilluminant = 'E'\nradius_deg = 2.0\nstrength = 1.0\nazimuth_deg = {}\nelevation_deg = {}\n",
            pose.roll_deg + 90.0,
            90.0 - pose.between_deg
        );
        self.seen(pose, "sky = 0.0", &lamp, part, samples)
    }

    /// The same lit from everywhere, over the sky's daylight.
    pub(crate) fn under_sky(&self, pose: Pose, samples: u32) -> Spectrum {
        let sky = "lights = []\nsky = 1.0\nsky_horizon = 1.0\nsky_below = 1.0";
        let seen = self.seen(pose, sky, "", None, samples);
        let values = seen.wavelengths().nm().iter().zip(seen.values());
        let over = values.map(|(nm, value)| value / daylight(*nm)).collect();
        Spectrum::new(seen.wavelengths().clone(), over).unwrap()
    }

    /// Poses at an angle between light and viewer in which the feather shows at least half of its most, of turns by 5° about the
    /// axes of `rolls_deg`.
    pub(crate) fn beam(&self, between_deg: f64, rolls_deg: &[f64], samples: u32) -> Vec<Pose> {
        let turns = (-9..=13).map(|k| 5.0 * f64::from(k));
        let poses: Vec<_> = rolls_deg
            .iter()
            .flat_map(|&roll_deg| turns.clone().map(move |turn_deg| Pose { between_deg, turn_deg, roll_deg }))
            .collect();
        let heights: Vec<_> = poses.iter().map(|&pose| height(&self.lit(pose, None, samples))).collect();
        let most = heights.iter().copied().fold(0.0, f64::max);
        poses
            .into_iter()
            .zip(heights)
            .filter(|(_, height)| *height >= 0.5 * most)
            .map(|(pose, _)| pose)
            .collect()
    }

    fn seen(&self, pose: Pose, sky: &str, lamp: &str, part: Option<&str>, samples: u32) -> Spectrum {
        let scene = self.posed(pose, sky, lamp);
        let nm: Vec<f64> = (0..BANDS).map(|k| 400.0 + 10.0 * f64::from(k)).collect();
        let sensor = Sensor::default();
        let spectral = Bands::new(&nm, sensor.band()).unwrap();
        let planes = Planes { sensor, spectral, compositing: part.is_some() };
        let mut film = Film::with([SIDE; 2], planes).unwrap();
        self.set.render(&scene, &mut film, 1, Goal::samples(samples), &Unobserved, &mut |_| Ok(())).unwrap();
        let object = part.map(|part| scene.object_names().iter().position(|name| name == part).unwrap());
        let counts = |(x, y): &(u32, u32)| {
            let first = film.compositing(*x, *y).and_then(|c| c.covers.iter().max_by_key(|cover| cover.hits));
            object.is_none_or(|object| {
                first.is_some_and(|cover| cover.id != 0 && cover.object as usize == object)
            })
        };
        let pixels = (0..SIDE * SIDE).map(|at| (at % SIDE, at / SIDE)).filter(counts);
        let pixels: Vec<_> = pixels.map(|(x, y)| film.spectrum(x, y)).collect();
        let mean = |band: usize| pixels.iter().map(|pixel| pixel[band]).sum::<f64>() / pixels.len() as f64;
        Spectrum::new(Wavelengths::new(nm).unwrap(), (0..BANDS as usize).map(mean).collect()).unwrap()
    }

    /// The feather as it stands in other light before another camera.
    fn posed(&self, Pose { turn_deg, roll_deg, .. }: Pose, sky: &str, lamp: &str) -> ReadyScene {
        let [x, y, z] = self.scene.camera.target;
        let camera = format!(
            "projection = 'orthographic'\nazimuth_deg = 0.0\nelevation_deg = 90.0\nroll_deg = {roll_deg}\nwidth_mm = {}\nlens = 0.0\ntarget_mm = [{x}, {y}, {z}]",
            self.width_mm
        );
        let text = format!(
            "preset = '{}'\nturn_deg = {turn_deg}\nbackground = 'none'\n{sky}\n[light]\nstrength = 0.0\n[camera]\n{camera}\n{lamp}",
            self.preset
        );
        let mut posed = SceneDescription::parse(&text).unwrap();
        posed.objects.clone_from(&self.scene.objects);
        posed.surfaces.clone_from(&self.scene.surfaces);
        ReadyScene::new(posed).unwrap()
    }
}

/// Daylight's mean power in the band about a wavelength, of any unit.
fn daylight(nm: f64) -> f64 {
    let weights = (-9..=9).map(|k| (nm + f64::from(k), 10.0 - f64::from(k).abs()));
    weights.map(|(nm, weight)| weight * Illuminant::D65.power(nm)).sum()
}

/// The highest value of a spectrum.
pub(crate) fn height(spectrum: &Spectrum) -> f64 {
    spectrum.values().iter().copied().fold(0.0, f64::max)
}

/// Where the highest peak within a range is, nm: the top of the parabola of least squares through the bands within 60 nm of the middle of
/// what is over nine tenths of its height. Peaks are broad, and each band is noisy.
pub(crate) fn peak_nm(spectrum: &Spectrum, [low, high]: [f64; 2]) -> f64 {
    let points = || spectrum.wavelengths().nm().iter().copied().zip(spectrum.values().iter().copied());
    let inside = || points().filter(|(nm, _)| (low..=high).contains(nm));
    let most = inside().map(|(_, value)| value).fold(0.0, f64::max);
    let (sum, count) = inside()
        .filter(|(_, value)| *value >= 0.9 * most)
        .fold((0.0, 0.0), |(sum, count), (nm, _)| (sum + nm, count + 1.0));
    let middle = sum / count;
    let near: Vec<_> =
        points().map(|(nm, value)| ((nm - middle) / 60.0, value)).filter(|(at, _)| at.abs() <= 1.0).collect();
    // Moments of the bands, which need not stand evenly about the middle.
    let moment = |power: i32| near.iter().map(|(at, _)| at.powi(power)).sum::<f64>();
    let product = |power: i32| near.iter().map(|(at, value)| at.powi(power) * value).sum::<f64>();
    let matrix = DMat3::from_cols_array_2d(&std::array::from_fn(|row| {
        std::array::from_fn(|column| moment((row + column) as i32))
    }));
    let fit = matrix.inverse() * DVec3::new(product(0), product(1), product(2));
    middle - 60.0 * 0.5 * fit.y / fit.z
}

/// (max − min)/(max + min): how deep a spectrum is modulated.
pub(crate) fn modulation(spectrum: &Spectrum) -> f64 {
    let least = spectrum.values().iter().copied().fold(f64::INFINITY, f64::min);
    (height(spectrum) - least) / (height(spectrum) + least)
}

/// The two parts of least squares of a spectrum: how much it has of the shape of `beam`, and how high the rest is, alike at all
/// wavelengths.
pub(crate) fn beam_and_white(spectrum: &Spectrum, beam: &Spectrum) -> [f64; 2] {
    let count = beam.values().len() as f64;
    let [mean, mean_beam] = [spectrum, beam].map(|s| s.values().iter().sum::<f64>() / count);
    let (mut product, mut square) = (0.0, 0.0);
    for (value, shape) in spectrum.values().iter().zip(beam.values()) {
        product += (value - mean) * (shape - mean_beam);
        square += (shape - mean_beam).powi(2);
    }
    [product / square, mean - product / square * mean_beam]
}
