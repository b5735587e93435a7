//! Tracing a micrograph: light made even, classes of grey, regions, outlines between pixels, and what they are.
//!
//! Lengths are px of the picture, x to the right and y down; classes count from the brightest.

mod bar;
mod drawn;
mod field;
mod fit;
mod lattice;
mod layers;
mod levels;
mod outline;
mod parted;
mod regions;
mod rods;
mod shading;
mod spread;
#[cfg(test)]
mod tests;

pub use bar::{Bar, scale_bar};
pub use drawn::{Micrograph, Rods, Shape};
pub use field::{Grey, LEAST_SIDE, MOST_PIXELS, check_size};
pub use lattice::Lattice;
pub use layers::{Bands, Layer};
pub use levels::BINS;
pub use outline::Outline;
pub use rods::Rod;
pub use spread::Spread;

use barbule_base::{Error, Result};
use regions::Map;
use rods::Search;
use shading::Flat;

/// What a picture is traced as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Rods on a lattice.
    Lattice,
    /// Layers from side to side.
    Layers,
    /// Whatever is there, as outlines.
    Section,
}

/// What can be chosen.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// How many classes of grey there are, 2 or 3; else the picture decides.
    pub classes: Option<usize>,
    /// Thresholds between the classes in grey levels 0 to 255 of the flattened picture, one fewer than classes; else in the middle
    /// between the classes.
    pub thresholds: Option<Vec<f64>>,
    /// What to trace; else the picture decides.
    pub kind: Option<Kind>,
}

/// What a picture shows.
#[derive(Debug, Clone)]
pub struct Traced {
    /// The picture with even light and stain, smoothed, in grey levels 0 to 255.
    pub flat: Grey,
    /// Grey levels of the classes, from bright to dark.
    pub levels: Vec<f64>,
    /// Grey levels between them, from bright to dark.
    pub thresholds: Vec<f64>,
    /// How many of the pixels away from edges have each grey level.
    pub counts: Vec<u32>,
    /// Standard deviation of the Gaussian that blurs the picture's edges, px, without what smoothing adds.
    pub blur: f64,
    /// Standard deviation of the noise, a part of white.
    pub noise: f64,
    /// What it was traced as.
    pub kind: Kind,
    /// Rods that are wholly in the picture.
    pub rods: Vec<Rod>,
    /// The lattice that they stand on.
    pub lattice: Option<Lattice>,
    /// Classes around the rods and in them.
    pub around_rods: [usize; 2],
    /// Distance of the first row's upper edge from the boundary above it, px, where there is one.
    pub cortex: Option<Spread>,
    /// Regions from side to side.
    pub bands: Bands,
    /// Layers between them.
    pub layers: Vec<Layer>,
    /// By how much the layers are turned, degrees, from the picture's x towards its lower edge.
    pub turn_deg: f64,
    /// Regions that touch no border, with their classes.
    pub inclusions: Vec<(usize, Outline)>,
    /// How many regions the border cuts, beside those from side to side: these are not measured.
    pub cut: usize,
}

/// What lies in each region is looked for among all.
const MOST_REGIONS: usize = 10_000;
/// Layers cover at least this part of the picture.
const LAYERED: f64 = 0.85;
/// Layers lie within this angle of the picture's x, radians.
const MOST_TILT: f64 = 0.45;
/// Less than this is not turned away, radians: the slope is then seen to by the normal alone.
const LEAST_TILT: f64 = 0.004;

/// Traces a picture.
///
/// # Errors
/// No classes of grey; thresholds that are out of order or leave a class empty; nothing of the kind that is asked for.
pub fn trace(picture: &Grey, options: &Options) -> Result<Traced> {
    let classes = check(options)?;
    let noise = picture.noise();
    let smoothing = smoothing_of(picture, noise);
    let flat = shading::flatten(&picture.smoothed(smoothing), classes)?;
    let thresholds = match &options.thresholds {
        Some(thresholds) => thresholds.clone(),
        None => flat.levels.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect(),
    };
    let blur = regions::edge_blur(&flat);
    let work = Work { flat: &flat, thresholds: &thresholds, blur };
    let mut traced = Traced {
        flat: flat.grey.clone(),
        levels: flat.levels.clone(),
        thresholds: thresholds.clone(),
        counts: flat.counts.to_vec(),
        blur,
        noise,
        kind: Kind::Section,
        rods: Vec::new(),
        lattice: None,
        around_rods: [0; 2],
        cortex: None,
        bands: Bands::default(),
        layers: Vec::new(),
        turn_deg: 0.0,
        inclusions: Vec::new(),
        cut: 0,
    };
    let has_layers = options.kind.is_none_or(|kind| kind == Kind::Layers) && work.layers(&mut traced)?;
    if !has_layers {
        work.regions(&mut traced, options.kind)?;
    }
    traced.kind = decided(&traced, has_layers, options.kind)?;
    traced.blur = (traced.blur * traced.blur - smoothing * smoothing).max(0.0).sqrt();
    Ok(traced)
}

/// The number of classes that is asked for, checked against the thresholds.
fn check(options: &Options) -> Result<Option<usize>> {
    let named = |what: String| Error::input(what).naming(&["classes", "thresholds"]);
    if let Some(count) = options.classes.filter(|count| !(2..=3).contains(count)) {
        return Err(named(format!("`classes` is {count}; give 2 or 3")));
    }
    let Some(thresholds) = &options.thresholds else { return Ok(options.classes) };
    let count = thresholds.len() + 1;
    let falls = thresholds.windows(2).all(|pair| pair[0] > pair[1]);
    if !(2..=3).contains(&count) || !falls || thresholds.iter().any(|t| !(1.0..=254.0).contains(t)) {
        return Err(named(
            "`thresholds`: give one or two grey levels from 1 to 254 of the flattened picture, the brighter first".into(),
        ));
    }
    match options.classes {
        Some(classes) if classes != count => Err(named(format!(
            "`thresholds` has {}, but {classes} classes have {} between them",
            thresholds.len(),
            classes - 1
        ))),
        _ => Ok(Some(count)),
    }
}

/// How much a picture is smoothed, px: as little as its noise allows.
fn smoothing_of(picture: &Grey, noise: f64) -> f64 {
    let mut values: Vec<f64> = picture.values.iter().step_by(7).map(|v| f64::from(*v)).collect();
    let contrast = field::part(&mut values, 0.98) - field::part(&mut values, 0.02);
    // Smoothing by s px takes noise down to 1/(2 √π s) of it: three hundredths of the contrast are left.
    (noise / contrast.max(1e-9) / (0.03 * 2.0 * std::f64::consts::PI.sqrt())).clamp(0.7, 2.5)
}

/// What the steps share.
struct Work<'a> {
    flat: &'a Flat,
    thresholds: &'a [f64],
    blur: f64,
}

impl Work<'_> {
    /// The grey level between two classes: the threshold of neighbours, the middle of others.
    fn between(&self, a: usize, b: usize) -> f64 {
        if a.abs_diff(b) == 1 {
            self.thresholds[a.min(b)]
        } else {
            0.5 * (self.flat.levels[a] + self.flat.levels[b])
        }
    }

    /// The regions of a flattened picture.
    ///
    /// # Errors
    /// There are too many.
    fn map(&self, flat: &Flat) -> Result<Map> {
        let mut classes = regions::classes(&flat.grey, self.thresholds);
        regions::without_seams(&mut classes, flat, self.blur);
        let least = (std::f64::consts::PI * (1.5 * self.blur + 1.0).powi(2)).ceil() as usize;
        let map = Map::of(&mut classes, flat.grey.size(), least);
        if map.regions.len() > MOST_REGIONS {
            return Err(Error::input(format!(
                "falls into {} regions at these thresholds; at most {MOST_REGIONS} are traced: give a part of it by `crop`, or other `thresholds`",
                map.regions.len()
            ))
            .naming(&["crop", "thresholds"]));
        }
        Ok(map)
    }

    /// Looks for layers; says whether there are any.
    fn layers(&self, traced: &mut Traced) -> Result<bool> {
        let (turn, _) = layers::direction(&self.flat.grey);
        if turn.abs() > MOST_TILT {
            return Ok(false);
        }
        let turn = if turn.abs() < LEAST_TILT { 0.0 } else { turn };
        let Some(level) = layers::levelled(&self.flat.grey, turn) else { return Ok(false) };
        let flat = Flat { grey: level.grey.clone(), ..self.flat.clone() };
        let map = self.map(&flat)?;
        let mut bands = Bands::of(&flat.grey, &map, &|a, b| self.between(a, b));
        if bands.classes.len() < 3 || bands.covered < LAYERED {
            return Ok(false);
        }
        let Some(layers) = bands.layers() else { return Ok(false) };
        for boundary in &mut bands.boundaries {
            boundary.iter_mut().for_each(|place| *place = level.back(*place));
        }
        traced.turn_deg = turn.to_degrees();
        traced.layers = layers;
        traced.bands = bands;
        Ok(true)
    }

    /// Rods, their lattice, and everything else as outlines.
    fn regions(&self, traced: &mut Traced, kind: Option<Kind>) -> Result<()> {
        let grey = &self.flat.grey;
        let map = self.map(self.flat)?;
        if map.regions.len() < 2 {
            return Err(Error::input(
                "is of one class of grey between its thresholds; set them by `thresholds`, or give a picture with more contrast",
            )
            .naming(&["thresholds"]));
        }
        let between = |a: usize, b: usize| self.between(a, b);
        let search =
            Search { grey, map: &map, levels: &self.flat.levels, between: &between, blur: self.blur };
        let found = search.rods();
        traced.rods = found.rods;
        traced.around_rods = found.around;
        traced.blur = found.blur;
        traced.bands = Bands::of(grey, &map, &between);
        if kind != Some(Kind::Section) {
            traced.lattice = lattice::lattice_of(&traced.rods);
        }
        traced.cortex = cortex(traced);
        let spans = |region: &regions::Region| region.border[0] && region.border[2];
        traced.cut = map.regions.iter().filter(|r| r.touches_border() && !spans(r)).count();
        for (index, region) in map.regions.iter().enumerate().filter(|(_, r)| !r.touches_border()) {
            if let Some((outline, _)) = search.outlines(index) {
                traced.inclusions.push((region.class, outline.unblurred(found.blur)));
            }
        }
        Ok(())
    }
}

/// The host above the first row, where a boundary lies above it.
fn cortex(traced: &Traced) -> Option<Spread> {
    let lattice = traced.lattice.as_ref()?;
    let top = traced.bands.boundaries.first().filter(|_| traced.bands.classes[1] == traced.around_rods[0])?;
    let [first, last] = lattice.ends[0];
    let (sin, cos) = lattice.turn_deg.to_radians().sin_cos();
    let depth = |p: [f64; 2]| cos * p[1] - sin * p[0];
    let row = 0.5 * (depth(first) + depth(last));
    let under = |p: &&[f64; 2]| (first[0]..=last[0]).contains(&p[0]);
    let depths: Vec<f64> =
        top.iter().filter(under).map(|p| row - 0.5 * lattice.diameter.mean - depth(*p)).collect();
    let found = Spread::of(&depths);
    (!depths.is_empty() && found.mean > 0.0).then_some(found)
}

/// What the picture is, or what it is asked to be.
fn decided(traced: &Traced, has_layers: bool, asked: Option<Kind>) -> Result<Kind> {
    let refuse = |what: String| Err(Error::input(what).naming(&["kind", "thresholds"]));
    match asked {
        Some(Kind::Layers) if !has_layers => refuse(
            "shows no layers: fewer than three regions go from its left to its right side and cover it; turn the picture so that they do, or set `thresholds`".into(),
        ),
        Some(Kind::Lattice) if traced.lattice.is_none() => refuse(format!(
            "shows no lattice: {} of the darkest class lie wholly in it, and they stand on no rows of even steps; six rods are needed; set `thresholds` or trace it as a section",
            barbule_base::error::counted(traced.rods.len(), "rod")
        )),
        Some(kind) => Ok(kind),
        None if has_layers => Ok(Kind::Layers),
        None if traced.lattice.is_some() => Ok(Kind::Lattice),
        None => Ok(Kind::Section),
    }
}
