//! What is finer than light: the layers under a top as light sees them, averaged along it.
//!
//! The fast simulation takes each column under the top for itself. Where inclusions begin, end and bulge within less than a
//! wavelength, light takes them together: as [effective media](super::columns::Palette), layer by layer, in columns that are
//! means over their neighbours at the same depth.

use super::cast::{Ray, layers};
use super::columns::{Columns, Palette, SHARES, SlotMixture};
use super::section::{Polyline, Section};
use crate::material::Material;
use crate::{Error, Result};

/// The standard deviation that serves feathers, µm: λ/(2πn) at 550 nm in n = 1.5, over which a field that belongs to detail
/// finer than any wave dies away.
pub const FINER_THAN_LIGHT_UM: f64 = 0.06;

/// Standard deviations that make sense, µm.
const DEVIATIONS_UM: std::ops::RangeInclusive<f64> = 0.005..=1.0;

/// Columns that are averaged lie so many to a standard deviation: 5 nm apart where it is 0.06 µm. Four gave a row with a period of
/// eight columns a share that was off by a twelfth.
const PER_DEVIATION: f64 = 12.0;

/// The Gaussian is cut off after so many standard deviations.
const GAUSSIAN_END: f64 = 3.0;

/// Depth is cut into steps of at most this, µm: a thirtieth of the shortest wavelength in the densest usual medium. Half or twice
/// as much changes the power that a hummingbird reflects by 3e-4 of it.
const STEP_UM: f64 = 0.008;

/// Steps of which no medium's share is further than this from their mean are one layer.
const ALIKE: f64 = 0.06;

/// So many times as many layers as its section has under the median point of the top no column keeps; what is alike then means
/// more. Under ends, where normals run along layers, there would be hundreds.
const MOST_LAYERS: usize = 3;

/// Whether the layers under a top are averaged along it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Smoothing {
    /// As a given section says; species not at all.
    #[default]
    Usual,
    /// Every column for itself.
    Off,
    /// By a Gaussian of this standard deviation, µm; of inclusions alone, since boundaries from end to end stay as they are.
    Over(f64),
}

impl Smoothing {
    /// By a Gaussian of a standard deviation, µm.
    ///
    /// # Errors
    /// It is outside 0.005 to 1 µm.
    pub fn over(deviation_um: f64) -> Result<Self> {
        if DEVIATIONS_UM.contains(&deviation_um) {
            return Ok(Self::Over(deviation_um));
        }
        Err(Error::input(format!("an average over {deviation_um} µm: give 0.005 to 1 µm, or off")))
    }

    /// The standard deviation, µm, where `usual` is what a given section says.
    #[must_use]
    pub fn deviation_um(self, usual: Option<f64>) -> Option<f64> {
        match self {
            Self::Usual => usual,
            Self::Off => None,
            Self::Over(deviation_um) => Some(deviation_um),
        }
    }
}

impl From<Option<f64>> for Smoothing {
    /// As results record it.
    fn from(deviation_um: Option<f64>) -> Self {
        deviation_um.map_or(Self::Off, Self::Over)
    }
}

/// A column of the section, with its place along the top.
struct Profile {
    arc_um: f64,
    /// Of the top that it stands for.
    length_um: f64,
    /// Layers from the top down, the substrate last.
    layers: Vec<Slice>,
}

/// A layer of a column: its lower end, and its medium as parts of up to two of the palette.
struct Slice {
    to_um: f64,
    media: [(usize, f64); 2],
}

/// The layers below each ray, as [`cast`](super::cast) finds them, averaged along the top.
///
/// # Errors
/// As [`cast`](super::cast), or over 65,535 different media.
pub(super) fn averaged(section: &Section, rays: &[Ray], deviation_um: f64) -> Result<Columns> {
    let top = section.top();
    let arc_um = top.arc_um();
    let (places, lengths_um) = along(top, &arc_um, deviation_um / PER_DEVIATION);
    let under: Vec<Ray> = places.iter().map(|(_, ray)| *ray).collect();
    let exact = layers(section, &under)?;
    let profiles: Vec<Profile> = places
        .iter()
        .zip(lengths_um)
        .enumerate()
        .map(|(index, ((arc_um, _), length_um))| Profile {
            arc_um: *arc_um,
            length_um,
            layers: slices(&exact, index),
        })
        .collect();
    let mut counts: Vec<usize> = profiles.iter().map(|profile| profile.layers.len()).collect();
    counts.sort_unstable();
    let most = MOST_LAYERS * counts[counts.len() / 2];
    let materials = exact.palette.materials.clone();
    let mut mean = Mean { count: materials.len(), ..Mean::default() };
    let mut found = Vec::with_capacity(rays.len());
    for ray in rays {
        let right = top.x_um.partition_point(|&x| x <= ray.x_um).clamp(1, top.x_um.len() - 1);
        let (x0, x1) = (top.x_um[right - 1], top.x_um[right]);
        let part = (ray.x_um - x0) / (x1 - x0);
        let here_um = arc_um[right - 1] + part * (arc_um[right] - arc_um[right - 1]);
        mean.of(&profiles, here_um, deviation_um);
        found.push(mean.layers(most));
    }
    columns(materials, &found)
}

/// Places along a top at most `step_um` apart, with the length that each stands for.
fn along(top: &Polyline, arc_um: &[f64], step_um: f64) -> (Vec<(f64, Ray)>, Vec<f64>) {
    let (mut places, mut lengths_um) = (Vec::new(), Vec::new());
    for (i, (x, z)) in top.x_um.windows(2).zip(top.z_um.windows(2)).enumerate() {
        let (dx, dz) = (x[1] - x[0], z[1] - z[0]);
        let length = arc_um[i + 1] - arc_um[i];
        let count = (length / step_um).ceil().max(1.0);
        for k in 0..count as usize {
            let t = (k as f64 + 0.5) / count;
            let ray = Ray { x_um: x[0] + t * dx, z_um: z[0] + t * dz, normal: [-dz / length, dx / length] };
            places.push((arc_um[i] + t * length, ray));
            lengths_um.push(length / count);
        }
    }
    (places, lengths_um)
}

/// The layers of one ray of columns.
fn slices(columns: &Columns, ray: usize) -> Vec<Slice> {
    let mut depth_um = 0.0;
    let mut slices = Vec::new();
    for slot in 0..columns.slots {
        let last = slot + 1 == columns.slots;
        let thickness_um = columns.thickness_um[slot * columns.rays + ray];
        if thickness_um <= 0.0 && !last {
            continue;
        }
        depth_um = if last { f64::INFINITY } else { depth_um + thickness_um };
        let mixture = columns.mixture[slot].at(ray);
        let media = [(mixture.a, 1.0 - mixture.fraction), (mixture.b, mixture.fraction)];
        slices.push(Slice { to_um: depth_um, media: media.map(|(at, part)| (usize::from(at), part)) });
    }
    slices
}

/// One layer of a column: thickness, and the share of each material in [`SHARES`]ths.
type Averaged = (f64, Vec<u8>);

/// The mean of columns beside each other.
#[derive(Default)]
struct Mean {
    /// Materials.
    count: usize,
    /// `[step of depth][material]`; the last step goes on for ever.
    shares: Vec<f64>,
}

impl Mean {
    /// Over the columns about a place, by a Gaussian.
    fn of(&mut self, profiles: &[Profile], here_um: f64, deviation_um: f64) {
        let reach_um = GAUSSIAN_END * deviation_um;
        let first = profiles.partition_point(|p| p.arc_um < here_um - reach_um).min(profiles.len() - 1);
        let end = profiles.partition_point(|p| p.arc_um <= here_um + reach_um).max(first + 1);
        let near = &profiles[first..end];
        let bottom_um = |p: &Profile| match p.layers[..] {
            [.., ref last, _] => last.to_um,
            _ => 0.0,
        };
        let deepest_um = near.iter().map(bottom_um).fold(0.0, f64::max);
        let steps = (deepest_um / STEP_UM).ceil() as usize + 1;
        self.shares.clear();
        self.shares.resize(steps * self.count, 0.0);
        let weight = |p: &Profile| {
            let away = (p.arc_um - here_um) / deviation_um;
            p.length_um * libm::exp(-0.5 * away * away)
        };
        let whole: f64 = near.iter().map(weight).sum();
        for profile in near {
            self.add(profile, weight(profile) / whole);
        }
    }

    fn add(&mut self, profile: &Profile, weight: f64) {
        let steps = self.shares.len() / self.count;
        let mut from = 0.0_f64;
        for slice in &profile.layers {
            let to = (slice.to_um / STEP_UM).min(steps as f64);
            let mut step = from as usize;
            while step < steps && (step as f64) < to {
                let part = to.min(step as f64 + 1.0) - from.max(step as f64);
                for (medium, share) in slice.media {
                    self.shares[step * self.count + medium] += weight * part * share;
                }
                step += 1;
            }
            from = to;
        }
    }

    /// The steps as at most `most` layers, the substrate last.
    fn layers(&self, most: usize) -> Vec<Averaged> {
        let mut alike = ALIKE;
        loop {
            let layers = self.alike(alike);
            if layers.len() <= most || alike >= 1.0 {
                return layers;
            }
            alike *= 2.0;
        }
    }

    fn alike(&self, tolerance: f64) -> Vec<Averaged> {
        let mut layers: Vec<Averaged> = Vec::new();
        let (mut sums, mut count) = (vec![0.0; self.count], 0.0);
        let mut put = |sums: &mut [f64], count: &mut f64| {
            if *count > 0.0 {
                let mean: Vec<f64> = sums.iter().map(|sum| sum / *count).collect();
                layers.push((*count * STEP_UM, in_shares(&mean)));
            }
            sums.fill(0.0);
            *count = 0.0;
        };
        let steps = self.shares.len() / self.count;
        for (step, shares) in self.shares.chunks_exact(self.count).enumerate() {
            let is_one =
                shares.iter().zip(&sums).all(|(share, sum)| (share * count - sum).abs() <= tolerance * count);
            // The last goes on for ever and is mixed with nothing.
            if !is_one || step + 1 == steps {
                put(&mut sums, &mut count);
            }
            sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share);
            count += 1.0;
        }
        put(&mut sums, &mut count);
        layers
    }
}

/// Shares that sum to 1 in [`SHARES`]ths, which do too: rounding goes to the largest.
fn in_shares(shares: &[f64]) -> Vec<u8> {
    let whole = f64::from(SHARES);
    let mut parts: Vec<i32> = shares.iter().map(|share| (whole * share).round() as i32).collect();
    let rest = i32::from(SHARES) - parts.iter().sum::<i32>();
    if let Some(largest) = parts.iter_mut().max() {
        *largest += rest;
    }
    parts.into_iter().map(|part| part.clamp(0, i32::from(SHARES)) as u8).collect()
}

/// Columns of layers from the top down: slot k holds each ray's k-th layer, the last slot the substrates.
fn columns(materials: Vec<Material>, found: &[Vec<Averaged>]) -> Result<Columns> {
    let rays = found.len();
    let slots = found.iter().map(Vec::len).max().unwrap_or(1);
    if slots.saturating_mul(rays) > super::cast::MOST_LAYERS {
        return Err(Error::input(format!(
            "averages along the top have {slots} layers under {rays} places, more than can be simulated; turn them off, or \
             give a narrower section"
        )));
    }
    let mut palette = Palette::of(materials);
    let mut entries = vec![vec![0_u16; rays]; slots];
    let mut thickness_um = vec![0.0; slots * rays];
    for (ray, layers) in found.iter().enumerate() {
        let Some((substrate, inner)) = layers.split_last() else { continue };
        let substrate = palette.entry(&substrate.1)?;
        for (slot, row) in entries.iter_mut().enumerate() {
            row[ray] = match inner.get(slot).filter(|_| slot + 1 < slots) {
                Some((thickness, shares)) => {
                    thickness_um[slot * rays + ray] = *thickness;
                    palette.entry(shares)?
                }
                None => substrate,
            };
        }
    }
    let mixture = entries.into_iter().map(|row| SlotMixture::Entries(row).simplified()).collect();
    Ok(Columns { rays, slots, thickness_um, mixture, palette })
}

#[cfg(test)]
mod tests {
    use super::super::cast::cast;
    use super::super::{Inclusion, Loop, Medium, Parts, Structure};
    use super::*;
    use crate::material::Library;

    fn over(section: &Section, deviation_um: f64) -> Section {
        Section { smooth_um: Some(deviation_um), ..section.clone() }
    }

    fn across(section: &Section, within_um: f64) -> Vec<Ray> {
        let top = section.top();
        let at = |i: i32| within_um * (f64::from(i) / 10.0);
        (-10..=10).map(|i| Ray { x_um: at(i), z_um: top.height(at(i)), normal: [0.0, 1.0] }).collect()
    }

    fn film(thickness_um: f64, inclusions: Vec<Inclusion>) -> Section {
        let line = |z_um: f64| Polyline { x_um: vec![-4.0, 0.0, 4.0], z_um: vec![z_um; 3] };
        let parts = Parts {
            name: "film".into(),
            width_um: Some(8.0),
            boundaries: vec![line(0.0), line(-thickness_um)],
            media: ["air", "keratin", "air"].map(Medium::named).to_vec(),
            inclusions,
            ..Parts::default()
        };
        Section::new(parts, Library::builtin()).unwrap()
    }

    fn slab(x: [f64; 2], z: [f64; 2], medium: &str) -> Inclusion {
        let outline = Loop::polygon(vec![x[0], x[1], x[1], x[0]], vec![z[0], z[0], z[1], z[1]]);
        Inclusion { outline, medium: Medium::named(medium), holes: Vec::new() }
    }

    /// Thickness (µm) and index of each layer under a ray.
    fn column(columns: &Columns, ray: usize) -> Vec<(f64, crate::Complex64)> {
        let indices = columns.palette.indices(550.0).unwrap();
        let thickness = |slot: usize| columns.thickness_um[slot * columns.rays + ray];
        let inner = (0..columns.slots).filter(|slot| thickness(*slot) > 0.0 || slot + 1 == columns.slots);
        inner.map(|slot| (thickness(slot), columns.mixture[slot].at(ray).index(&indices))).collect()
    }

    #[test]
    fn boundaries_that_go_on_keep_every_bit() {
        for name in ["starling", "bronzewing"] {
            let section = Structure::builtin(name).unwrap().instance(1, 0).unwrap();
            let rays = across(&section, 8.0);
            assert_eq!(cast(&section, &rays).unwrap(), cast(&over(&section, 0.1), &rays).unwrap());
        }
    }

    #[test]
    fn a_layer_that_goes_on_changes_nothing() {
        let section = film(0.64, vec![slab([-3.9, 3.9], [-0.08, -0.24], "melanin")]);
        let rays = across(&section, 3.0);
        let (exact, mean) = (cast(&section, &rays).unwrap(), cast(&over(&section, 0.06), &rays).unwrap());
        for ray in 0..rays.len() {
            let (exact, mean) = (column(&exact, ray), column(&mean, ray));
            assert_eq!(exact.len(), mean.len());
            for ((thick, index), (also, other)) in exact.iter().zip(&mean) {
                assert!((thick - also).abs() < 1e-12 && (index - other).norm() < 1e-12, "{thick} {also}");
            }
        }
    }

    #[test]
    fn a_row_becomes_a_layer_of_its_share() {
        let rods = (0..60).map(|i| -3.6 + 0.12 * f64::from(i));
        let row: Vec<Inclusion> = rods.map(|x| slab([x, x + 0.09], [-0.08, -0.16], "air")).collect();
        let section = film(0.4, row);
        let rays = across(&section, 2.0);
        let mean = cast(&over(&section, 0.06), &rays).unwrap();
        let keratin = crate::Complex64::from(1.532 + 5890.0 / (550.0 * 550.0));
        let epsilon = keratin * keratin;
        let (along, inverse) = (0.75 + 0.25 * epsilon, 0.75 + 0.25 / epsilon);
        let expected = (along * (along / inverse).sqrt()).sqrt().sqrt();
        for ray in 0..rays.len() {
            let column = column(&mean, ray);
            assert_eq!(column.len(), 4, "{column:?}");
            assert!((column[1].0 - 0.08).abs() < 1e-12);
            // e^{−(2π·0.06/0.12)²/2} of the row is left, 0.7 % of it.
            assert!((column[1].1 - expected).norm() < 6e-3, "{} {expected}", column[1].1);
        }
    }

    #[test]
    fn species_are_averaged_where_somebody_asks_for_it() {
        let builtin = |name: &str| Structure::builtin(name).unwrap();
        for name in crate::structure::species_names() {
            assert_eq!(builtin(name).smooth_um(), None, "{name}");
            assert_eq!(builtin(name).instance(1, 0).unwrap().smooth_um, None, "{name}");
        }
        let bird = builtin("hummingbird").smoothed(Smoothing::Over(FINER_THAN_LIGHT_UM));
        assert_eq!(bird.clone().underside().unwrap().instance(1, 0).unwrap().smooth_um, bird.smooth_um());
        let off = bird.clone().smoothed(Smoothing::Off);
        assert_eq!((off.smooth_um(), off.instance(1, 0).unwrap().smooth_um), (None, None));
        // What is simulated is told apart beside the structure, whose identity stays.
        assert_eq!((off.hash(), off.description()), (bird.hash(), bird.description()));
        let sections = |inclusions: Vec<Inclusion>| Structure::Sections {
            name: "films".into(),
            sections: vec![film(0.4, inclusions)],
        };
        let asked = Smoothing::over(0.1).unwrap();
        assert_eq!(sections(Vec::new()).smoothed(asked).smooth_um(), None);
        let row = sections(vec![slab([-1.0, 1.0], [-0.1, -0.2], "air")]);
        assert_eq!((row.smooth_um(), row.smoothed(asked).smooth_um()), (None, Some(0.1)));
        assert!(Smoothing::over(2.0).is_err() && Smoothing::over(f64::NAN).is_err());
    }

    #[test]
    fn averages_do_not_gain_and_shares_are_whole() {
        let bird = Structure::builtin("hummingbird").unwrap();
        let section = bird.smoothed(Smoothing::Over(FINER_THAN_LIGHT_UM)).instance(1, 0).unwrap();
        let columns = cast(&section, &across(&section, 15.0)).unwrap();
        assert!(
            columns.palette.indices(400.0).unwrap().iter().all(|n| n.im >= 0.0 && (1.0..2.0).contains(&n.re))
        );
        let sum = |shares: &[f64]| in_shares(shares).iter().map(|s| u32::from(*s)).sum::<u32>();
        assert_eq!((sum(&[0.333, 0.333, 0.334]), sum(&[0.5, 0.5]), sum(&[1.0])), (128, 128, 128));
    }
}
