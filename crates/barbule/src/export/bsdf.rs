//! Materials as RGL `.bsdf` files, which Mitsuba and pbrt read without any code of ours.
//!
//! Such a file holds values where its own warp puts them ([`measured`](crate::bsdf::measured)). A barbule's light is a narrow line: a warp that
//! follows it has no values on its flanks, where it is linear between far too few, and is off by a tenth at any size. So values crowd about a line
//! that is two or three times as wide, over a tail and an even share. How wide, and how fine the axes are, is searched for each
//! material by measuring what a reader would make of the file.

use crate::brdf::FeatherBrdf;
use crate::bsdf::measured::{Channels, Resolution, Rgl, RglArrays, of_barbule, of_file, tabulate};
use crate::progress::Progress;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::{Illuminant, Observer};
use crate::{DVec3, Error, Result};

use super::{Deviation, Model};

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flavour {
    /// Values over wavelengths.
    Spectral,
    /// Values of linear sRGB in daylight (D65); what that cannot show is cut off.
    Rgb,
}

/// A material as a `.bsdf`.
#[derive(Debug, Clone)]
pub struct BsdfTable {
    /// What is written.
    pub arrays: RglArrays,
    /// How far what is read from it is from the material.
    pub deviation: Deviation,
    /// How fine it is.
    pub resolution: Resolution,
    /// Where its values lie close.
    pub crowding: Crowding,
}

/// Where values lie close: a distribution of half vectors about the barbule's line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crowding {
    /// Spread along the barbule: of the half vector's component h along it, exp(−h²/σ²).
    pub sigma: f64,
    /// Share of those that spread more, and how far.
    pub tail: [f64; 2],
    /// m² of slopes across it.
    pub m2: f64,
    /// Share that is even over the hemisphere.
    pub even: f64,
}

/// Steps of the axes of a file: one of each.
const THETAS: [usize; 7] = [8, 12, 16, 20, 24, 32, 40];
const PHIS: [usize; 7] = [9, 13, 17, 25, 33, 49, 65];
const VALUES: [usize; 7] = [20, 24, 32, 40, 48, 64, 96];
const STEPS_NM: [f64; 5] = [40.0, 20.0, 10.0, 5.0, 2.5];
const NORMALS: [[usize; 2]; 3] = [[64, 32], [128, 48], [256, 64]];

/// Steps of what values crowd by.
const SIGMAS: [f64; 6] = [0.06, 0.08, 0.1, 0.12, 0.15, 0.2];
const TAILS: [f64; 6] = [0.0, 0.1, 0.2, 0.3, 0.5, 0.7];
const TAIL_SIGMAS: [f64; 5] = [0.2, 0.3, 0.4, 0.6, 0.9];
const M2S: [f64; 9] = [0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3];
const EVENS: [f64; 5] = [0.005, 0.02, 0.05, 0.1, 0.2];

/// Most tables that are tried.
const MOST_TRIED: usize = 120;
/// A finer axis is taken where the error falls by this share at least.
const GAIN: f64 = 0.003;
/// Shortest and longest wavelength that readers ask for, nm.
const READ_NM: [f64; 2] = [360.0, 830.0];
/// Wavelengths that colours are made of.
const COLOUR_NM: usize = 32;

impl BsdfTable {
    /// Values of each pair of directions: wavelengths, or red, green and blue.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.arrays.values.len() / self.arrays.luminance.len()
    }

    /// The nearest to the material that was found among files of at most so many bytes. The same each time; a minute at 100 MB.
    ///
    /// # Errors
    /// Too few bytes for the coarsest; interruption.
    pub fn of(
        brdf: &FeatherBrdf,
        flavour: Flavour,
        most_bytes: usize,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let mut search = Search { brdf, flavour, progress, tried: 0, best: None };
        // Axes as steps: θ, φ, values, wavelengths, normals.
        let mut axes = [0; 5];
        let mut crowd = [2, 2, 1, 4, 1];
        if search.bytes(axes) > most_bytes {
            return Err(Error::input(format!(
                "a .bsdf takes {:.0} MB at least; {:.0} were allowed",
                (search.bytes(axes) as f64 * 1e-6).ceil(),
                most_bytes as f64 * 1e-6
            )));
        }
        progress.begin("tables tried", MOST_TRIED as u64);
        // Where values crowd is found at a middling size.
        let middling = search.largest_below([2, 1, 2, 1, 0], most_bytes);
        search.climb(middling, &mut crowd)?;
        axes = search.refine(axes, crowd, most_bytes)?;
        search.climb(axes, &mut crowd)?;
        let (arrays, resolution, crowding) = match search.best.take() {
            Some(Best { arrays, resolution, crowding, .. }) => (arrays, resolution, crowding),
            None => return Err(Error::interrupted()),
        };
        let rgl = Rgl::new(arrays.clone())?;
        let deviation = with_model(&rgl, |model| Deviation::of(model, brdf))?;
        Ok(Self { arrays, deviation, resolution, crowding })
    }
}

impl Crowding {
    fn of([sigma, tail, tail_sigma, m2, even]: [usize; 5]) -> Self {
        Self {
            sigma: SIGMAS[sigma],
            tail: [TAILS[tail], TAIL_SIGMAS[tail_sigma]],
            m2: M2S[m2],
            even: EVENS[even],
        }
    }

    /// D(m) of a half vector in the file's frame, 1/sr.
    fn density(&self, m: DVec3) -> f64 {
        let Self { sigma, tail: [tail, wide], m2, even } = *self;
        let across = m2 / (std::f64::consts::PI * (m2 + (1.0 - m2) * m.y * m.y).powi(2));
        let spread = |sigma: f64| libm::exp(-(m.x / sigma).powi(2)) / (sigma * std::f64::consts::PI.sqrt());
        let along = (1.0 - tail) * spread(sigma) + tail * spread(wide);
        (1.0 - even) * 2.0 * across * along + even / std::f64::consts::PI
    }
}

/// How many steps there are of what values crowd by, and of the axes.
const CROWD_STEPS: [usize; 5] = [SIGMAS.len(), TAILS.len(), TAIL_SIGMAS.len(), M2S.len(), EVENS.len()];
const AXIS_STEPS: [usize; 5] = [THETAS.len(), PHIS.len(), VALUES.len(), STEPS_NM.len(), NORMALS.len()];

struct Search<'a> {
    brdf: &'a FeatherBrdf,
    flavour: Flavour,
    progress: &'a dyn Progress,
    tried: usize,
    /// Of the finest axes so far.
    best: Option<Best>,
}

struct Best {
    arrays: RglArrays,
    resolution: Resolution,
    crowding: Crowding,
    relative_l1: f64,
}

impl Search<'_> {
    fn nm(&self, axes: [usize; 5]) -> Vec<f64> {
        let (low, high) = self.brdf.wavelength_range_nm();
        let (low, high) = (low.max(READ_NM[0]), high.min(READ_NM[1]));
        let gaps = ((high - low) / STEPS_NM[axes[3]]).round().max(1.0);
        (0..=gaps as usize).map(|k| low + (high - low) * k as f64 / gaps).collect()
    }

    fn channels(&self, axes: [usize; 5]) -> usize {
        match self.flavour {
            Flavour::Spectral => self.nm(axes).len(),
            Flavour::Rgb => 3,
        }
    }

    fn bytes(&self, axes: [usize; 5]) -> usize {
        resolution(axes).bytes(self.channels(axes))
    }

    /// These axes, each coarser by as many steps as it takes.
    fn largest_below(&self, mut axes: [usize; 5], most_bytes: usize) -> [usize; 5] {
        while self.bytes(axes) > most_bytes {
            axes = axes.map(|step| step.saturating_sub(1));
        }
        axes
    }

    /// The error of a table; the table is kept if it is the best of the last axes that were asked for.
    fn error(&mut self, axes: [usize; 5], crowd: [usize; 5]) -> Result<f64> {
        if self.progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        self.tried += 1;
        self.progress.advance(1);
        let (resolution, crowding) = (resolution(axes), Crowding::of(crowd));
        let arrays = match self.flavour {
            Flavour::Spectral => spectral(self.brdf, &self.nm(axes), &resolution, crowding),
            Flavour::Rgb => colours(self.brdf, &resolution, crowding),
        }?;
        let rgl = Rgl::new(arrays.clone())?;
        let relative_l1 = with_model(&rgl, |model| Deviation::relative_l1_of(model, self.brdf))?;
        let of_these = self.best.as_ref().filter(|best| best.resolution == resolution);
        if of_these.is_none_or(|best| relative_l1 < best.relative_l1) {
            self.best = Some(Best { arrays, resolution, crowding, relative_l1 });
        }
        Ok(relative_l1)
    }

    /// Steps of what values crowd by, one at a time, as long as one helps.
    fn climb(&mut self, axes: [usize; 5], crowd: &mut [usize; 5]) -> Result<()> {
        let mut least = self.error(axes, *crowd)?;
        let mut seen = vec![*crowd];
        loop {
            let before = *crowd;
            for (k, up) in (0..crowd.len()).flat_map(|k| [(k, true), (k, false)]) {
                let mut next = *crowd;
                next[k] = if up { next[k] + 1 } else { next[k].wrapping_sub(1) };
                if next[k] >= CROWD_STEPS[k] || seen.contains(&next) || self.tried >= MOST_TRIED {
                    continue;
                }
                seen.push(next);
                let error = self.error(axes, next)?;
                if error < least {
                    (least, *crowd) = (error, next);
                }
            }
            if *crowd == before {
                return Ok(());
            }
        }
    }

    /// Axes made finer, each time the one that helps most for its bytes, as long as the bytes last.
    fn refine(&mut self, mut axes: [usize; 5], crowd: [usize; 5], most_bytes: usize) -> Result<[usize; 5]> {
        let mut least = self.error(axes, crowd)?;
        loop {
            let mut found: Option<(f64, [usize; 5], f64)> = None;
            for k in 0..axes.len() {
                let mut next = axes;
                next[k] += 1;
                let is_colour_step = self.flavour == Flavour::Rgb && k == 3;
                if next[k] >= AXIS_STEPS[k]
                    || is_colour_step
                    || self.bytes(next) > most_bytes
                    || self.tried >= MOST_TRIED
                {
                    continue;
                }
                let error = self.error(next, crowd)?;
                let more = (self.bytes(next) as f64 / self.bytes(axes) as f64).ln();
                let gain = (least / error).ln();
                if gain > GAIN && found.is_none_or(|(best, ..)| gain / more > best) {
                    found = Some((gain / more, next, error));
                }
            }
            let Some((_, next, error)) = found else { return Ok(axes) };
            (axes, least) = (next, error);
        }
    }
}

fn resolution([theta, phi, values, _, normals]: [usize; 5]) -> Resolution {
    Resolution { thetas: THETAS[theta], phis: PHIS[phi], values: VALUES[values], normals: NORMALS[normals] }
}

/// A material's arrays over wavelengths.
fn spectral(
    brdf: &FeatherBrdf,
    nm: &[f64],
    resolution: &Resolution,
    crowding: Crowding,
) -> Result<RglArrays> {
    let channels = Channels::Wavelengths(nm.iter().map(|v| *v as f32).collect());
    let values = |w: DVec3, wo: DVec3, to: &mut [f64]| values(brdf, nm, [w, wo], to);
    tabulate(resolution, channels, &|m| crowding.density(m), &values)
}

/// The same of R, G and B.
fn colours(brdf: &FeatherBrdf, resolution: &Resolution, crowding: Crowding) -> Result<RglArrays> {
    let (low, high) = brdf.wavelength_range_nm();
    let (low, high) = (low.max(READ_NM[0]), high.min(READ_NM[1]));
    let nm: [f64; COLOUR_NM] =
        std::array::from_fn(|k| low + (high - low) * k as f64 / (COLOUR_NM - 1) as f64);
    let weights = Observer::under(Illuminant::D65).weights(&Wavelengths::new(nm)?);
    let values = |w: DVec3, wo: DVec3, to: &mut [f64]| {
        let mut seen = [0.0; COLOUR_NM];
        values(brdf, &nm, [w, wo], &mut seen);
        to.copy_from_slice(&weights.linear_rgb(&seen).map(|value| value.max(0.0)));
    };
    tabulate(resolution, Channels::Rgb, &|m| crowding.density(m), &values)
}

/// f cosθ_o in the file's frame.
fn values(brdf: &FeatherBrdf, nm: &[f64], [w, wo]: [DVec3; 2], to: &mut [f64]) {
    const LANES: usize = 8;
    for (to, nm) in to.chunks_mut(LANES).zip(nm.chunks(LANES)) {
        let eight = std::array::from_fn::<f32, LANES, _>(|k| nm[k.min(nm.len() - 1)] as f32);
        let f = brdf.eval(eight, of_barbule(w), of_barbule(wo), None);
        to.iter_mut().zip(f).for_each(|(to, f)| *to = f64::from(f) * wo.z);
    }
}

/// What a reader makes of a file, as a model.
fn with_model<T>(rgl: &Rgl, ask: impl FnOnce(&Model<'_>) -> T) -> T {
    let spectral = |nm: &[f64], view: DVec3, light: DVec3| {
        let mut found = vec![0.0; nm.len()];
        rgl.values(&rgl.incident(of_file(view)), of_file(light), nm, &mut found);
        found
    };
    let rgb = |view: DVec3, light: DVec3| {
        let mut found = [0.0; 3];
        rgl.values(&rgl.incident(of_file(view)), of_file(light), &[], &mut found);
        found
    };
    match rgl.channels() {
        Channels::Wavelengths(_) => ask(&Model::Spectral(&spectral)),
        Channels::Rgb => ask(&Model::Rgb(&rgb)),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::Unobserved;
    use crate::brdf::Options;
    use crate::bsdf::{
        BarbuleSurface, Cells, Clad, Frame, Hit, Keratin, Layout, Measured, MeasuredTables, Reflectance,
        Surface,
    };
    use crate::characterize::Catalog;
    use crate::math::rng::Stream;
    use crate::spectrum::dense::Lambdas;
    use crate::structure::Structure;

    fn brdf(name: &str) -> FeatherBrdf {
        let found = Catalog::default().shipped(&Structure::builtin(name).unwrap()).unwrap().unwrap();
        FeatherBrdf::new(&found.material, Options::default()).unwrap()
    }

    /// Within its bytes and as near as is said of small files; on a surface whose texture lies askew what was exported shines where barbules do, to the side to which they do.
    #[test]
    fn a_measured_surface_is_the_barbules_that_it_was_made_of() {
        let brdf = brdf("mallard");
        let table = BsdfTable::of(&brdf, Flavour::Spectral, 8_000_000, &Unobserved).unwrap();
        assert!(table.resolution.bytes(table.channels()) <= 8_000_000, "{:?}", table.resolution);
        let Deviation { relative_l1, bias, delta_e } = table.deviation;
        assert!(relative_l1 < 0.1 && bias.abs() < 0.02 && delta_e < 2.0, "{:?}", table.deviation);
        let measured = MeasuredTables::Rgl(Box::new(Rgl::new(table.arrays).unwrap()));
        let measured = Surface::Measured(Measured::new(Arc::new(measured)));
        let barbules = BarbuleSurface {
            brdf: Arc::new(brdf),
            instances: false,
            below: None,
            under: Keratin::new(0.3, 1.56, Reflectance::melanin(20.0).unwrap()).unwrap(),
            cells: Cells::default(),
            opacity: 1.0,
        };
        let layout = Layout { uv_mm: [1.0; 2], width_mm: 0.0, length_mm: 0.0, cell_mm: 0.0, swelling: 0.0 };
        let barbules = Surface::Clad(Box::new(Clad::new(barbules, layout).unwrap()));
        let normal = DVec3::new(0.2, -0.3, 0.9).normalize();
        let frame = Frame::new(normal, DVec3::new(0.5, 1.0, 0.1));
        let uv_gradients = [frame.x * 0.4 + frame.y, frame.x];
        let hit = Hit { normal, vane_normal: normal, frame, uv_gradients, ..Hit::default() };
        let path = Lambdas::new([550.0, 610.0, 470.0, 510.0, 403.0, 431.0, 650.0, 690.0]);
        let mut random = Stream::new(3, &[]);
        let (mut off, mut all) = (0.0, 0.0);
        for _ in 0..3000 {
            let view = DVec3::new(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), 0.7).normalize();
            let wo = hit.frame.to_world(view);
            let own = barbules.bind(&hit, wo, path);
            let u = [random.unit(), random.unit(), random.unit()];
            let Some(sample) = own.sample(u) else { continue };
            let density = sample.evaluation.pdf[0];
            let other = measured.bind(&hit, wo, path).eval(sample.wi);
            for (a, b) in sample.evaluation.f.iter().zip(other.f) {
                off += (a - b).abs() * other.cosine / density;
                all += a * other.cosine / density;
            }
        }
        assert!(off / all < 0.1, "off by {}", off / all);
    }

    #[test]
    fn too_small_files_are_refused() {
        let refused = BsdfTable::of(&brdf("starling"), Flavour::Spectral, 100_000, &Unobserved).unwrap_err();
        assert!(refused.to_string().contains("MB at least"), "{refused}");
    }
}
