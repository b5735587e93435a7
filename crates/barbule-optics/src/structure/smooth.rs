//! What is finer than light: the layers under a top as light sees them, averaged along it.
//!
//! The fast simulation takes each column under the top for itself. Where inclusions begin, end and bulge within less than a
//! wavelength, light takes them together: as [effective media](super::columns::SlotMixture::Effective), layer by layer, in columns that are
//! means over their neighbours at the same depth.

use super::cast::{Ray, layers};
use super::columns::{Columns, Palette, PaletteMixture, SlotMixture};
use super::section::{Polyline, Section};
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

/// Depth is first cut into steps of at most this, µm: a sixtieth of the shortest wavelength in the densest usual medium. Boundaries
/// of layers, which lie on the edges of steps, are the nearest ones moved to them.
const STEP_UM: f64 = 0.004;

/// Steps are joined to layers as long as the share of a medium that is moved, times how far, changes by less than this, µm². Where
/// k is the vacuum wave number, a reflectance changes by k² δε of it: here by 0.004 at 550 nm, of a layer of air in melanin.
const JOINED_UM2: f64 = 1.5e-5;

/// Steps whose shares differ by less than this are the same layer anyway.
const SAME: f64 = 1e-4;

/// So many times as many layers as its section has under the median point of the top no column keeps. Under ends, where normals
/// run along layers, there would be hundreds.
const MOST_LAYERS: usize = 3;

/// Columns within a stretch of so many standard deviations are cut at the same depths, so that layers change along the top as
/// little as the averages themselves.
const STRETCH: f64 = 2.5;

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

/// A layer of a column: its lower end, and its medium.
struct Slice {
    to_um: f64,
    medium: PaletteMixture,
}

/// The layers below each ray, as [`cast`](super::cast) finds them, averaged along the top.
///
/// # Errors
/// As [`cast`](super::cast).
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
    let here_um: Vec<f64> = rays.iter().map(|ray| place(top, &arc_um, ray)).collect();
    let mut order: Vec<usize> = (0..rays.len()).collect();
    order.sort_by(|a, b| here_um[*a].total_cmp(&here_um[*b]));
    let stretch = |ray: usize| (here_um[ray] / (STRETCH * deviation_um)).floor();
    let palette = exact.palette;
    let materials = palette.materials.len();
    let mut found =
        Averages { thickness_um: Vec::new(), of: vec![0; rays.len()], shares: vec![Vec::new(); rays.len()] };
    for group in order.chunk_by(|a, b| stretch(*a) == stretch(*b)) {
        let middle_um = (stretch(group[0]) + 0.5) * STRETCH * deviation_um;
        let mut cut = Cut::about(&profiles, materials, middle_um, deviation_um);
        let layers = cut.layers(middle_um, most);
        for ray in group {
            found.of[*ray] = found.thickness_um.len();
            found.shares[*ray] = cut.shares(here_um[*ray], &layers);
        }
        found.thickness_um.push(cut.thickness_um(&layers));
    }
    columns(palette, &found)
}

/// About how many columns under a top `arc_um` long are averaged; none where [`cast`](super::cast) averages nothing.
#[must_use]
pub fn averaged_columns(section: &Section, arc_um: f64) -> usize {
    let deviation_um = section.smooth_um.filter(|_| !section.inclusions.is_empty());
    deviation_um.map_or(0, |deviation_um| (arc_um * PER_DEVIATION / deviation_um).ceil() as usize)
}

/// Where along a top a ray begins, µm.
fn place(top: &Polyline, arc_um: &[f64], ray: &Ray) -> f64 {
    let right = top.x_um.partition_point(|&x| x <= ray.x_um).clamp(1, top.x_um.len() - 1);
    let (x0, x1) = (top.x_um[right - 1], top.x_um[right]);
    let part = (ray.x_um - x0) / (x1 - x0);
    arc_um[right - 1] + part * (arc_um[right] - arc_um[right - 1])
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
        slices.extend(columns.mixture[slot].at(ray).map(|medium| Slice { to_um: depth_um, medium }));
    }
    slices
}

/// Averages under rays.
struct Averages {
    /// Of each stretch of the top, layers from the top down but for the substrate.
    thickness_um: Vec<Vec<f64>>,
    /// The stretch of each ray.
    of: Vec<usize>,
    /// Of each ray, `[layer][material]`, the substrate last.
    shares: Vec<Vec<f32>>,
}

/// The columns about a stretch of the top, cut at the same depths.
struct Cut<'a> {
    profiles: &'a [Profile],
    deviation_um: f64,
    materials: usize,
    /// Edges of steps from 0 down; the last step goes on for ever.
    edges_um: Vec<f64>,
    /// `[profile][material][step]`
    parts: Vec<f32>,
    /// The mean of columns, `[material][step]`.
    mean: Vec<f32>,
}

impl<'a> Cut<'a> {
    /// About the middle of a stretch, as far as its averages reach.
    fn about(all: &'a [Profile], materials: usize, middle_um: f64, deviation_um: f64) -> Self {
        let profiles = near(all, middle_um, (GAUSSIAN_END + 0.5 * STRETCH) * deviation_um);
        let bottom_um = |p: &Profile| match p.layers[..] {
            [.., ref last, _] => last.to_um,
            _ => 0.0,
        };
        let deepest_um = profiles.iter().map(bottom_um).fold(0.0, f64::max);
        let middle = profiles.partition_point(|p| p.arc_um < middle_um).min(profiles.len() - 1);
        let edges_um = edges(&profiles[middle], deepest_um);
        let steps = edges_um.len();
        let mut parts = vec![0.0; profiles.len() * materials * steps];
        for (profile, parts) in profiles.iter().zip(parts.chunks_exact_mut(materials * steps)) {
            profile.cut(&edges_um, parts);
        }
        let mean = vec![0.0; materials * steps];
        Self { profiles, deviation_um, materials, edges_um, parts, mean }
    }

    /// Averages the columns about a place by a Gaussian.
    fn average(&mut self, here_um: f64) {
        let near = near(self.profiles, here_um, GAUSSIAN_END * self.deviation_um);
        let first = self.profiles.partition_point(|p| p.arc_um < near[0].arc_um);
        let weight = |p: &Profile| {
            let away = (p.arc_um - here_um) / self.deviation_um;
            p.length_um * libm::exp(-0.5 * away * away)
        };
        let whole: f64 = near.iter().map(weight).sum();
        self.mean.fill(0.0);
        let rows = self.parts.chunks_exact(self.mean.len()).skip(first);
        for (profile, row) in near.iter().zip(rows) {
            let weight = (weight(profile) / whole) as f32;
            self.mean.iter_mut().zip(row).for_each(|(sum, part)| *sum += weight * part);
        }
    }

    /// The layers into which steps are joined, at most `most`, as the end of each; the substrate is the last step alone.
    fn layers(&mut self, middle_um: f64, most: usize) -> Vec<usize> {
        self.average(middle_um);
        let steps = self.edges_um.len();
        let mut joined = Joined::default();
        for step in 0..steps - 1 {
            let shares = (0..self.materials).map(|m| f64::from(self.mean[m * steps + step])).collect();
            joined.push(step + 1, self.edges_um[step + 1] - self.edges_um[step], shares);
        }
        joined.join(most);
        joined.ends
    }

    /// The thickness of each of these layers, µm.
    fn thickness_um(&self, layers: &[usize]) -> Vec<f64> {
        let starts = std::iter::once(&0).chain(layers);
        layers.iter().zip(starts).map(|(end, start)| self.edges_um[*end] - self.edges_um[*start]).collect()
    }

    /// The shares of the materials in these layers under a place, `[layer][material]`, then in the substrate.
    fn shares(&mut self, here_um: f64, layers: &[usize]) -> Vec<f32> {
        self.average(here_um);
        let steps = self.edges_um.len();
        let mut shares = Vec::with_capacity((layers.len() + 1) * self.materials);
        let mut start = 0;
        for end in layers {
            let whole = self.edges_um[*end] - self.edges_um[start];
            for row in self.mean.chunks_exact(steps) {
                let of = |step: usize| f64::from(row[step]) * (self.edges_um[step + 1] - self.edges_um[step]);
                shares.push(((start..*end).map(of).sum::<f64>() / whole) as f32);
            }
            start = *end;
        }
        shares.extend(self.mean.chunks_exact(steps).map(|row| row[steps - 1]));
        for shares in shares.chunks_exact_mut(self.materials) {
            whole(shares);
        }
        shares
    }
}

/// Makes one material of what is but for rounding.
fn whole(shares: &mut [f32]) {
    if let Some(at) = shares.iter().position(|share| *share > 1.0 - 1e-5) {
        shares.fill(0.0);
        shares[at] = 1.0;
    }
}

/// The columns within a distance of a place, at least one.
fn near(profiles: &[Profile], here_um: f64, reach_um: f64) -> &[Profile] {
    let first = profiles.partition_point(|p| p.arc_um < here_um - reach_um).min(profiles.len() - 1);
    let end = profiles.partition_point(|p| p.arc_um <= here_um + reach_um).max(first + 1);
    &profiles[first..end]
}

/// The edges of steps down to a depth, where a column's layers are between two of them.
fn edges(middle: &Profile, deepest_um: f64) -> Vec<f64> {
    let count = (deepest_um / STEP_UM).ceil() as usize;
    let mut edges_um: Vec<f64> = (0..=count).map(|k| deepest_um * (k as f64 / count.max(1) as f64)).collect();
    let mut free = 1;
    for slice in &middle.layers {
        let nearest = (slice.to_um / deepest_um * count as f64).round();
        // Not the last one, below which there is nothing but the substrate.
        let nearest = (nearest.max(free as f64)) as usize;
        if nearest >= count {
            break;
        }
        if slice.to_um > edges_um[nearest - 1] && slice.to_um < edges_um[nearest + 1] {
            edges_um[nearest] = slice.to_um;
            free = nearest + 1;
        }
    }
    edges_um
}

impl Profile {
    /// The part of each material in each step, `[material][step]`; the last step is below everything.
    fn cut(&self, edges_um: &[f64], parts: &mut [f32]) {
        let steps = edges_um.len();
        let mut put = |step: usize, slice: &Slice, part: f64| {
            let PaletteMixture { a, b, fraction } = slice.medium;
            for (material, share) in [(a, 1.0 - fraction), (b, fraction)] {
                parts[usize::from(material) * steps + step] += (part * share) as f32;
            }
        };
        let (mut step, mut from_um) = (0, 0.0);
        for slice in &self.layers {
            while step + 1 < steps {
                let to_um = slice.to_um.min(edges_um[step + 1]);
                put(step, slice, (to_um - from_um) / (edges_um[step + 1] - edges_um[step]));
                from_um = to_um;
                if to_um < edges_um[step + 1] {
                    break;
                }
                step += 1;
            }
        }
        if let Some(substrate) = self.layers.last() {
            put(steps - 1, substrate, 1.0);
        }
    }
}

/// Neighbouring steps of depth that are joined where that changes least.
#[derive(Default)]
struct Joined {
    ends: Vec<usize>,
    thickness_um: Vec<f64>,
    shares: Vec<Vec<f64>>,
}

impl Joined {
    /// Adds the next step, to the layer above it where both are the same.
    fn push(&mut self, end: usize, thickness_um: f64, shares: Vec<f64>) {
        let is_same = self.shares.last().is_some_and(|above| change(above, &shares) < SAME);
        self.ends.push(end);
        self.thickness_um.push(thickness_um);
        self.shares.push(shares);
        if is_same {
            self.unite(self.ends.len() - 2);
        }
    }

    /// Makes one layer of number `at` and the next.
    fn unite(&mut self, at: usize) {
        let (one, other) = (self.thickness_um[at], self.thickness_um.remove(at + 1));
        let below = self.shares.remove(at + 1);
        for (share, below) in self.shares[at].iter_mut().zip(below) {
            *share = (*share * one + below * other) / (one + other);
        }
        self.thickness_um[at] = one + other;
        self.ends.remove(at);
    }

    /// The moment that uniting number `at` and the next moves, µm².
    fn moved_um2(&self, at: usize) -> f64 {
        change(&self.shares[at], &self.shares[at + 1]) * self.thickness_um[at] * self.thickness_um[at + 1]
    }

    /// Unites what changes least, as long as it is little or there are over `most`.
    fn join(&mut self, most: usize) {
        let mut moved: Vec<f64> = (1..self.ends.len()).map(|below| self.moved_um2(below - 1)).collect();
        while let Some(at) = (0..moved.len()).min_by(|a, b| moved[*a].total_cmp(&moved[*b])) {
            if moved[at] > JOINED_UM2 && self.ends.len() <= most {
                break;
            }
            self.unite(at);
            moved.remove(at);
            for pair in at.saturating_sub(1)..(at + 1).min(moved.len()) {
                moved[pair] = self.moved_um2(pair);
            }
        }
    }
}

/// The largest difference of a share.
fn change(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}

/// Columns of layers from the top down: slot k holds each ray's k-th layer, the last slot the substrates.
fn columns(palette: Palette, found: &Averages) -> Result<Columns> {
    let rays = found.of.len();
    let slots = found.thickness_um.iter().map(Vec::len).max().unwrap_or(0) + 1;
    if slots.saturating_mul(rays) > super::cast::MOST_LAYERS {
        return Err(Error::input(format!(
            "averages along the top have {slots} layers under {rays} places, more than can be simulated; turn them off, or \
             give a narrower section"
        )));
    }
    let materials = palette.materials.len();
    let mut thickness_um = vec![0.0; slots * rays];
    let mixture = |slot: usize| {
        let mut all = Vec::with_capacity(rays * materials);
        for (of, shares) in found.of.iter().zip(&found.shares) {
            // What a ray lacks is as its substrate.
            let layers = found.thickness_um[*of].len();
            let layer = if slot + 1 < slots { slot.min(layers) } else { layers };
            all.extend(&shares[layer * materials..(layer + 1) * materials]);
        }
        SlotMixture::Effective(all).simplified(materials)
    };
    let mixture = (0..slots).map(mixture).collect();
    for (ray, of) in found.of.iter().enumerate() {
        for (slot, thickness) in found.thickness_um[*of].iter().enumerate() {
            thickness_um[slot * rays + ray] = *thickness;
        }
    }
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
        inner.map(|slot| (thickness(slot), columns.mixture[slot].index(ray, &indices))).collect()
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
    fn species_are_averaged_by_default_or_where_somebody_asks_for_it() {
        let builtin = |name: &str| Structure::builtin(name).unwrap();
        for name in crate::structure::species_names() {
            // Of the shipped species, one has bubbles finer than light.
            let averaged = (name == "hummingbird").then_some(FINER_THAN_LIGHT_UM);
            assert_eq!(builtin(name).smooth_um(), averaged, "{name}");
            assert_eq!(builtin(name).instance(1, 0).unwrap().smooth_um, averaged, "{name}");
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
        let indices = columns.palette.indices(400.0).unwrap();
        for slot in &columns.mixture {
            if let SlotMixture::Effective(shares) = slot {
                let mut each = shares.chunks_exact(indices.len());
                assert!(each.all(|shares| (shares.iter().sum::<f32>() - 1.0).abs() < 1e-5));
            }
            for ray in 0..columns.rays {
                let index = slot.index(ray, &indices);
                assert!(index.im >= 0.0 && (1.0..2.0).contains(&index.re), "{index}");
            }
        }
    }
}
