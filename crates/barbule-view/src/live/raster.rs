//! A section as pixels, to scale: each column of them is cut through the section exactly, so that layers thinner than a pixel keep
//! their part of its colour.
//!
//! Media have the shades of figures. Air, keratin and melanin differ in lightness; every other medium is hatched too, so that nobody
//! needs to see hues.

use barbule::figures::shade;
use barbule::structure::{Loop, Medium, Polyline, Section, Substance};

/// Columns of a pixel.
const COLUMNS: usize = 2;
/// Media that a legend names; further ones are drawn as the last.
const MOST_MEDIA: usize = 24;
/// Hatches repeat after so many pixels, and are so many wide.
const HATCH_PX: usize = 8;
const HATCH_WIDE_PX: usize = 2;
/// What hatching takes from a shade or gives to it.
const HATCH_PART: f32 = 0.35;
/// What is shown below a crystal, as a part of its depth.
const BELOW_CRYSTAL: f64 = 0.15;
/// Flat layers are shown at least so tall, µm.
const LEAST_LAYERS_UM: f64 = 0.2;
/// A flat section is shown so tall at least, as a part of its width.
const LEAST_TALL: f64 = 0.04;

/// How a medium is hatched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hatch {
    /// Not at all.
    Plain,
    /// By lines that rise to the right.
    Rising,
    /// By lines that fall to the right.
    Falling,
    /// By level lines.
    Level,
    /// By dots.
    Dotted,
}

impl Hatch {
    /// The hatches of media that are not told by lightness alone, in the order in which they are given out.
    const ORDER: [Self; 4] = [Self::Rising, Self::Falling, Self::Level, Self::Dotted];

    /// Whether it marks a pixel.
    #[must_use]
    pub fn marks(self, column: usize, row: usize) -> bool {
        let within = |k: usize| k % HATCH_PX < HATCH_WIDE_PX;
        match self {
            Self::Plain => false,
            Self::Rising => within(column + row),
            Self::Falling => within(column + HATCH_PX - row % HATCH_PX),
            Self::Level => within(row),
            Self::Dotted => within(column) && within(row),
        }
    }
}

/// A medium in a legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its words.
    pub label: String,
    /// sRGB where a mixture has least of its second medium, and where it has most.
    pub shades: [[u8; 3]; 2],
    /// How it is hatched.
    pub hatch: Hatch,
}

/// What media look like.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Legend {
    /// Every medium once.
    pub entries: Vec<Entry>,
    media: Vec<Medium>,
}

impl Legend {
    /// The media of sections, in the order in which they first come; the same medium looks the same in all of them.
    pub fn of<'a>(sections: impl IntoIterator<Item = &'a Section>) -> Self {
        let mut legend = Self::default();
        for section in sections {
            section.all_media().for_each(|medium| legend.add(medium));
            let rods = section.crystal.iter().flat_map(|crystal| &crystal.lattice.rods);
            for circle in rods.flat_map(|rod| &rod.circles) {
                legend.add(&Medium::Pure(circle.medium.clone()));
            }
        }
        legend
    }

    fn add(&mut self, medium: &Medium) {
        if self.media.len() >= MOST_MEDIA || self.place(medium).is_some() {
            return;
        }
        let hatched = self.entries.iter().filter(|entry| entry.hatch != Hatch::Plain).count();
        let hatch = if is_told_by_lightness(medium) {
            Hatch::Plain
        } else {
            Hatch::ORDER[hatched % Hatch::ORDER.len()]
        };
        let (label, shades) = described(medium);
        if self.entries.iter().any(|entry| entry.label == label) {
            return;
        }
        self.entries.push(Entry { label, shades, hatch });
        self.media.push(medium.clone());
    }

    /// Which entry a medium has: mixtures that read alike share one.
    fn place(&self, medium: &Medium) -> Option<usize> {
        let own = self.media.iter().position(|known| known == medium);
        own.or_else(|| {
            let (label, _) = described(medium);
            self.entries.iter().position(|entry| entry.label == label)
        })
    }

    fn hatch(&self, medium: &Medium) -> Hatch {
        self.place(medium).map_or(Hatch::Plain, |place| self.entries[place].hatch)
    }
}

fn is_told_by_lightness(medium: &Medium) -> bool {
    let is_grey = |name: &str| ["air", "keratin", "melanin"].contains(&name);
    matches!(medium, Medium::Pure(Substance::Named(name)) if is_grey(name))
}

/// A medium's words, and its shades where a mixture has least and most of its second medium.
fn described(medium: &Medium) -> (String, [[u8; 3]; 2]) {
    match medium {
        Medium::Pure(substance) => (substance.label(), [shade(substance); 2]),
        Medium::Mixture { first, second, fraction, .. } => {
            let low = fraction.iter().copied().fold(1.0, f64::min);
            let high = fraction.iter().copied().fold(0.0, f64::max);
            let label = format!(
                "{} with {:.0} to {:.0} % {}",
                first.label(),
                100.0 * low,
                100.0 * high,
                second.label()
            );
            (label, [low, high].map(|part| blend(shade(first), shade(second), part)))
        }
    }
}

fn blend(a: [u8; 3], b: [u8; 3], part: f64) -> [u8; 3] {
    std::array::from_fn(|k| (f64::from(a[k]) * (1.0 - part) + f64::from(b[k]) * part).round() as u8)
}

/// A part of the plane of a section, µm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Its left end.
    pub left: f64,
    /// Its right end.
    pub right: f64,
    /// Its lower end.
    pub bottom: f64,
    /// Its upper end.
    pub top: f64,
}

impl Window {
    /// Its width and height, µm.
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        [self.right - self.left, self.top - self.bottom]
    }

    /// The least window of this shape (width over height) about the same middle that holds it and a margin, a part of it.
    #[must_use]
    pub fn fitted(&self, shape: f64, margin: f64) -> Self {
        let [wide, tall] = self.size().map(|length| length * (1.0 + 2.0 * margin));
        let tall = tall.max(wide / shape);
        self.about([0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top)], [tall * shape, tall])
    }

    /// It with another shape (width over height), about the same middle and as wide.
    #[must_use]
    pub fn shaped(&self, shape: f64) -> Self {
        let wide = self.size()[0];
        self.about([0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top)], [wide, wide / shape])
    }

    fn about(&self, [x, z]: [f64; 2], [wide, tall]: [f64; 2]) -> Self {
        Self { left: x - 0.5 * wide, right: x + 0.5 * wide, bottom: z - 0.5 * tall, top: z + 0.5 * tall }
    }

    /// It made larger by a factor about one of its places, each part of it from its upper left corner.
    #[must_use]
    pub fn zoomed(&self, factor: f64, [across, down]: [f64; 2]) -> Self {
        let [wide, tall] = self.size();
        let (x, z) = (self.left + across * wide, self.top - down * tall);
        Self {
            left: x - across * wide * factor,
            right: x + (1.0 - across) * wide * factor,
            bottom: z - (1.0 - down) * tall * factor,
            top: z + down * tall * factor,
        }
    }

    /// It moved by parts of its width to the right and of its height downwards.
    #[must_use]
    pub fn moved(&self, [across, down]: [f64; 2]) -> Self {
        let [wide, tall] = self.size();
        let (x, z) = (across * wide, -down * tall);
        Self { left: self.left + x, right: self.right + x, bottom: self.bottom + z, top: self.top + z }
    }
}

/// What a section takes up, µm; of a crystal the rods that hang on its top as well.
#[must_use]
pub fn extent(section: &Section) -> Window {
    let mut all = Window {
        left: f64::INFINITY,
        right: f64::NEG_INFINITY,
        bottom: f64::INFINITY,
        top: f64::NEG_INFINITY,
    };
    let mut cover = |curve: &Polyline| {
        for (&x, &z) in curve.x_um.iter().zip(&curve.z_um) {
            (all.left, all.right) = (all.left.min(x), all.right.max(x));
            (all.bottom, all.top) = (all.bottom.min(z), all.top.max(z));
        }
    };
    section.boundaries.iter().for_each(&mut cover);
    section.inclusions.iter().for_each(|inclusion| cover(&inclusion.outline.corners()));
    let deep = section.crystal.as_ref().map_or(0.0, |crystal| crystal.lattice.bottom_um());
    all.bottom -= deep * (1.0 + BELOW_CRYSTAL);
    let least = LEAST_TALL * (all.right - all.left);
    if all.top - all.bottom < least {
        (all.bottom, all.top) = (all.bottom - least, all.top + least);
    }
    all
}

/// What is shown of a section at first, in a window of this shape (width over height): all of it, or of flat layers, which go on to
/// both sides, all of these.
#[must_use]
pub fn first_window(section: &Section, shape: f64) -> Window {
    let is_flat = |curve: &Polyline| curve.z_um.iter().all(|z| *z == curve.z_um[0]);
    let all_flat = section.boundaries.iter().all(is_flat) && !section.boundaries.is_empty();
    if !all_flat || section.crystal.is_some() || !section.inclusions.is_empty() {
        return extent(section).fitted(shape, 0.02);
    }
    let heights = || section.boundaries.iter().map(|curve| curve.z_um[0]);
    let (bottom, top) =
        (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    let tall = (top - bottom).max(LEAST_LAYERS_UM);
    let middle = 0.5 * (bottom + top);
    let layers = Window { left: 0.0, right: 0.0, bottom: middle - 0.5 * tall, top: middle + 0.5 * tall };
    layers.fitted(shape, 0.15)
}

/// Pixels of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    /// Columns and rows.
    pub size: [usize; 2],
    /// sRGB. Shape: `[row, column, 3]` from the upper left.
    pub rgb: Vec<u8>,
}

/// How something is painted at one place across.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Paint {
    rgb: [f32; 3],
    hatch: Hatch,
}

impl Paint {
    fn at(self, column: usize, row: usize) -> [f32; 3] {
        if !self.hatch.marks(column, row) {
            return self.rgb;
        }
        // Dark shades are hatched by lighter lines.
        let light = self.rgb.iter().sum::<f32>() > 1.2 * 255.0;
        self.rgb.map(|c| c + HATCH_PART * if light { -c } else { 255.0 - c })
    }
}

/// From a height downwards, as far as the next one.
#[derive(Debug, Clone, Copy)]
struct Run {
    top: f64,
    paint: Paint,
}

/// A closed region, with what cuts it: circles exactly, everything else by its corners.
struct Region<'a> {
    outline: Outline,
    medium: &'a Medium,
    hatch: Hatch,
}

enum Outline {
    Circle { x: f64, z: f64, radius: f64 },
    Loops(Vec<Polyline>),
}

impl Outline {
    /// Left and right ends, µm.
    fn ends(&self) -> [f64; 2] {
        match self {
            Self::Circle { x, radius, .. } => [x - radius, x + radius],
            Self::Loops(loops) => {
                let each = loops.iter().flat_map(|one| &one.x_um);
                each.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)])
            }
        }
    }

    /// The heights at which a line upwards at x goes in and out, falling.
    fn crossings(&self, at: f64) -> Vec<f64> {
        match self {
            Self::Circle { x, z, radius } => {
                let half = (radius * radius - (at - x) * (at - x)).max(0.0).sqrt();
                vec![z + half, z - half]
            }
            Self::Loops(loops) => {
                let mut heights = Vec::new();
                for Polyline { x_um, z_um } in loops {
                    for k in 0..x_um.len() {
                        let next = (k + 1) % x_um.len();
                        // One end counts and the other does not, so that corners count once.
                        if (x_um[k] <= at) != (x_um[next] <= at) {
                            let part = (at - x_um[k]) / (x_um[next] - x_um[k]);
                            heights.push(z_um[k] + part * (z_um[next] - z_um[k]));
                        }
                    }
                }
                heights.sort_by(|a, b| b.total_cmp(a));
                heights
            }
        }
    }
}

/// Draws a window of a section.
#[must_use]
pub fn raster(section: &Section, legend: &Legend, window: &Window, size: [usize; 2]) -> Raster {
    let [columns, rows] = size;
    let crystal: Vec<(Outline, Medium)> = rods(section);
    let regions = regions(section, &crystal, legend);
    let step = window.size()[0] / (columns * COLUMNS) as f64;
    // Which regions each column cuts, in the order in which they are painted.
    let mut cuts: Vec<Vec<usize>> = vec![Vec::new(); columns * COLUMNS];
    for (index, region) in regions.iter().enumerate() {
        let [from, to] = region.outline.ends().map(|x| (x - window.left) / step);
        let first = from.floor().max(0.0) as usize;
        let last = to.ceil().clamp(0.0, cuts.len() as f64) as usize;
        cuts.iter_mut().take(last).skip(first).for_each(|cut| cut.push(index));
    }
    let hatches: Vec<Hatch> = section.media.iter().map(|medium| legend.hatch(medium)).collect();
    let mut rgb = vec![0; 3 * columns * rows];
    let mut sums = vec![[0.0_f32; 3]; rows];
    for column in 0..columns {
        sums.fill([0.0; 3]);
        for part in 0..COLUMNS {
            let place = column * COLUMNS + part;
            let x = window.left + (place as f64 + 0.5) * step;
            let mut runs = layers(section, &hatches, x);
            for region in cuts[place].iter().map(|index| &regions[*index]) {
                let paint = paint(region.medium, region.hatch, x);
                for pair in region.outline.crossings(x).chunks_exact(2) {
                    cover(&mut runs, [pair[0], pair[1]], paint);
                }
            }
            add(&mut sums, &runs, window, column);
        }
        for (row, sum) in sums.iter().enumerate() {
            let pixel = sum.map(|channel| (channel / COLUMNS as f32).round() as u8);
            rgb[3 * (row * columns + column)..][..3].copy_from_slice(&pixel);
        }
    }
    Raster { size, rgb }
}

/// The rods of a crystal under a section's top, each from its outermost shell inwards.
fn rods(section: &Section) -> Vec<(Outline, Medium)> {
    let of = |crystal: &barbule::structure::CrystalLayer| {
        let medium = |rod: usize, circle: usize| crystal.lattice.rods[rod].circles[circle].medium.clone();
        let circles = crystal.circles(section.top()).into_iter();
        let each = circles.map(|c| {
            let outline = Outline::Circle { x: c.x_um, z: c.z_um, radius: c.radius_um };
            (outline, Medium::Pure(medium(c.rod, c.circle)))
        });
        each.collect::<Vec<_>>()
    };
    section.crystal.as_ref().map(of).unwrap_or_default()
}

/// What lies in a section, in the order in which it is painted: what holds others before them.
fn regions<'a>(section: &'a Section, crystal: &'a [(Outline, Medium)], legend: &Legend) -> Vec<Region<'a>> {
    let mut regions: Vec<Region<'a>> = section
        .inclusions
        .iter()
        .map(|inclusion| {
            let outline = match (&inclusion.outline, inclusion.holes.is_empty()) {
                (Loop::Circle { x_um, z_um, radius_um }, true) => {
                    Outline::Circle { x: *x_um, z: *z_um, radius: *radius_um }
                }
                (outline, _) => {
                    let all = std::iter::once(outline).chain(&inclusion.holes);
                    Outline::Loops(all.map(Loop::corners).collect())
                }
            };
            Region { outline, medium: &inclusion.medium, hatch: legend.hatch(&inclusion.medium) }
        })
        .collect();
    let wide = |region: &Region<'_>| {
        let [left, right] = region.outline.ends();
        right - left
    };
    regions.sort_by(|a, b| wide(b).total_cmp(&wide(a)));
    regions.extend(crystal.iter().map(|(outline, medium)| Region {
        outline: match outline {
            Outline::Circle { x, z, radius } => Outline::Circle { x: *x, z: *z, radius: *radius },
            Outline::Loops(loops) => Outline::Loops(loops.clone()),
        },
        medium,
        hatch: legend.hatch(medium),
    }));
    regions
}

fn paint(medium: &Medium, hatch: Hatch, x: f64) -> Paint {
    let rgb = match medium {
        Medium::Pure(substance) => shade(substance),
        Medium::Mixture { first, second, .. } => blend(shade(first), shade(second), medium.fraction(x)),
    };
    Paint { rgb: rgb.map(f32::from), hatch }
}

/// What a line down at x meets of the layers.
fn layers(section: &Section, hatches: &[Hatch], x: f64) -> Vec<Run> {
    let mut runs = vec![Run { top: f64::INFINITY, paint: paint(&section.media[0], hatches[0], x) }];
    for (index, boundary) in section.boundaries.iter().enumerate() {
        let ends = [boundary.x_um[0], boundary.x_um[boundary.x_um.len() - 1]];
        if (ends[0]..=ends[1]).contains(&x) {
            let below = paint(&section.media[index + 1], hatches[index + 1], x);
            cover(&mut runs, [boundary.height(x), f64::NEG_INFINITY], below);
        }
    }
    runs
}

/// Paints over everything between two heights.
fn cover(runs: &mut Vec<Run>, [high, low]: [f64; 2], paint: Paint) {
    if high.is_nan() || low.is_nan() || high <= low {
        return;
    }
    let first = runs.partition_point(|run| run.top > high);
    let after = runs.partition_point(|run| run.top > low);
    // The first run begins above everything, so there is one over any height.
    let below = runs[after - 1].paint;
    let goes_on = low > f64::NEG_INFINITY && runs.get(after).is_none_or(|run| run.top < low);
    let tail = goes_on.then_some(Run { top: low, paint: below });
    runs.splice(first..after, std::iter::once(Run { top: high, paint }).chain(tail));
}

/// Adds a column's runs to its pixels, by the part of each pixel that they fill.
fn add(sums: &mut [[f32; 3]], runs: &[Run], window: &Window, column: usize) {
    let rows = sums.len() as f64;
    let per_row = rows / window.size()[1];
    let row_of = |z: f64| ((window.top - z) * per_row).clamp(0.0, rows);
    for (index, run) in runs.iter().enumerate() {
        let from = row_of(run.top);
        let to = runs.get(index + 1).map_or(rows, |next| row_of(next.top));
        let mut row = from.floor() as usize;
        while row < sums.len() && (row as f64) < to {
            let part = (to.min(row as f64 + 1.0) - from.max(row as f64)) as f32;
            let rgb = run.paint.at(column, row);
            for (sum, channel) in sums[row].iter_mut().zip(rgb) {
                *sum += part * channel;
            }
            row += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::material::Library;
    use barbule::structure::{Inclusion, Parts, Structure};

    fn flat(text: &str) -> Section {
        Structure::flat(text).unwrap().instance(1, 0).unwrap()
    }

    fn pixel(raster: &Raster, column: usize, row: usize) -> [u8; 3] {
        let from = 3 * (row * raster.size[0] + column);
        raster.rgb[from..from + 3].try_into().unwrap()
    }

    const WINDOW: Window = Window { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };

    #[test]
    fn layers_are_drawn_where_they_are_and_thin_ones_keep_their_part() {
        // Over four rows of 0.5 µm: air, air, then 0.25 µm of keratin over melanin.
        let section = flat("air/keratin:250/melanin");
        let legend = Legend::of([&section]);
        let drawn = raster(&section, &legend, &WINDOW, [3, 4]);
        let half = ((205.0 + 20.0) / 2.0_f32).round() as u8;
        let column: Vec<u8> = (0..4).map(|row| pixel(&drawn, 1, row)[0]).collect();
        assert_eq!(column, [255, 255, half, 20]);
        let labels: Vec<&str> = legend.entries.iter().map(|entry| entry.label.as_str()).collect();
        assert_eq!(labels, ["air", "keratin", "melanin"]);
        assert!(legend.entries.iter().all(|entry| entry.hatch == Hatch::Plain));
    }

    /// A ring of melanin about a hole, and a circle within that hole, as points of the section themselves say.
    #[test]
    fn inclusions_are_drawn_as_the_section_has_them() {
        let ring = |r: f64| Loop::Circle { x_um: 0.1, z_um: -0.05, radius_um: r };
        let named = |outline: Loop, name: &str, holes: Vec<Loop>| Inclusion {
            outline,
            medium: Medium::named(name),
            holes,
        };
        let line = |z: f64| Polyline { x_um: vec![-0.9, 0.0, 0.9], z_um: vec![z; 3] };
        let parts = Parts {
            name: "ring".into(),
            width_um: Some(1.8),
            boundaries: vec![line(0.95), line(-0.95)],
            media: ["air", "keratin", "air"].map(Medium::named).to_vec(),
            inclusions: vec![
                named(ring(0.2), "melanin", vec![]),
                named(ring(0.8), "melanin", vec![ring(0.5)]),
            ],
            ..Parts::default()
        };
        let section = Section::new(parts, Library::builtin()).unwrap();
        let legend = Legend::of([&section]);
        let side = 40;
        let drawn = raster(&section, &legend, &WINDOW, [side, side]);
        let mut compared = 0;
        for row in 0..side {
            for column in 0..side {
                let at = |k: usize| 2.0 * (k as f64 + 0.5) / side as f64 - 1.0;
                let (x, z) = (at(column), -at(row));
                let names: Vec<_> = [-0.03, 0.0, 0.03]
                    .iter()
                    .flat_map(|dx| [-0.03, 0.0, 0.03].map(|dz| section.medium_at(x + dx, z + dz)))
                    .collect();
                // Within one medium all around, and above the barbule.
                if x.abs() < 0.85 && names.iter().all(|name| *name == names[0]) {
                    let Medium::Pure(substance) = names[0] else { panic!() };
                    assert_eq!(pixel(&drawn, column, row), shade(substance), "{x} {z}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 900, "{compared}");
        // Beside the barbule there is what is above it.
        assert_eq!(pixel(&drawn, 0, 20), [255; 3]);
    }

    #[test]
    fn crystals_and_birds_are_drawn_whole() {
        for name in ["magpie", "starling", "hummingbird", "peafowl"] {
            let section = Structure::builtin(name).unwrap().instance(1, 3).unwrap();
            let window = extent(&section).fitted(2.0, 0.02);
            let [wide, tall] = window.size();
            assert!((wide / tall - 2.0).abs() < 1e-9, "{name}");
            let legend = Legend::of([&section]);
            let drawn = raster(&section, &legend, &window, [64, 32]);
            let dark = drawn.rgb.chunks_exact(3).filter(|p| p[0] < 120).count();
            let light = drawn.rgb.chunks_exact(3).filter(|p| p[0] > 240).count();
            assert!(dark > 50 && light > 50, "{name}: {dark} {light}");
        }
    }

    #[test]
    fn other_media_are_hatched_and_look_alike_in_all_sections() {
        let (one, two) = (flat("air/1.7:400/keratin"), flat("air/1.3:300/1.7:200/keratin"));
        let legend = Legend::of([&one, &two]);
        let hatch = |label: &str| legend.entries.iter().find(|e| e.label == label).map(|e| e.hatch);
        assert_eq!((hatch("1.7"), hatch("1.3")), (Some(Hatch::Rising), Some(Hatch::Falling)));
        let window = Window { left: 0.0, right: 0.4, bottom: -0.4, top: 0.0 };
        let drawn = raster(&one, &legend, &window, [16, 16]);
        let shades: std::collections::BTreeSet<_> = drawn.rgb.chunks_exact(3).collect();
        assert_eq!(shades.len(), 2, "a shade and its hatching");
        for hatch in [Hatch::Rising, Hatch::Falling, Hatch::Level, Hatch::Dotted] {
            let marked =
                (0..16).flat_map(|c| (0..16).map(move |r| (c, r))).filter(|(c, r)| hatch.marks(*c, *r));
            let count = marked.count();
            assert!((16..=64).contains(&count), "{hatch:?} {count}");
        }
    }

    #[test]
    fn windows_are_zoomed_about_a_place_and_moved() {
        let zoomed = WINDOW.zoomed(0.5, [0.25, 0.5]);
        assert_eq!((zoomed.left, zoomed.right), (-0.75, 0.25));
        assert_eq!((zoomed.bottom, zoomed.top), (-0.5, 0.5));
        let moved = WINDOW.moved([0.5, 0.25]);
        assert_eq!((moved.left, moved.right, moved.bottom, moved.top), (0.0, 2.0, -1.5, 0.5));
        let layers = first_window(&flat("air/keratin:500/melanin:500/air"), 2.0);
        assert!((layers.size()[1] - 1.3).abs() < 1e-9 && (layers.size()[0] - 2.6).abs() < 1e-9);
        assert!((layers.top - 0.15).abs() < 1e-9, "{layers:?}");
        assert!((first_window(&flat("air/keratin"), 2.0).size()[1] - 0.26).abs() < 1e-9);
        let starling = Structure::builtin("starling").unwrap().instance(1, 0).unwrap();
        assert!(first_window(&starling, 2.0).size()[0] > starling.width_um);
        let shaped = WINDOW.shaped(4.0);
        assert_eq!((shaped.size(), shaped.top), ([2.0, 0.5], 0.25));
        let fitted = WINDOW.fitted(4.0, 0.0);
        assert_eq!((fitted.size(), fitted.top), ([8.0, 2.0], 1.0));
    }

    #[test]
    fn what_covers_leaves_the_rest_as_it_was() {
        let paint = |grey: f32| Paint { rgb: [grey; 3], hatch: Hatch::Plain };
        let mut runs = vec![Run { top: f64::INFINITY, paint: paint(0.0) }];
        cover(&mut runs, [1.0, -1.0], paint(1.0));
        cover(&mut runs, [0.5, 0.0], paint(2.0));
        cover(&mut runs, [0.0, -1.0], paint(3.0));
        cover(&mut runs, [2.0, 2.0], paint(9.0));
        let found: Vec<(f64, f32)> = runs.iter().map(|run| (run.top, run.paint.rgb[0])).collect();
        assert_eq!(found, [(f64::INFINITY, 0.0), (1.0, 1.0), (0.5, 2.0), (0.0, 3.0), (-1.0, 0.0)]);
        cover(&mut runs, [f64::INFINITY, f64::NEG_INFINITY], paint(4.0));
        assert_eq!((runs.len(), runs[0].paint.rgb[0]), (1, 4.0));
    }
}
