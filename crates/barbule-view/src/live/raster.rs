//! A section as pixels, to scale: each column of them is cut through the section exactly, so that layers thinner than a pixel keep
//! their part of its colour.

use barbule::figures::shade;
use barbule::structure::{CrystalLayer, Loop, Medium, Polyline, Section};

use super::media::{Hatch, Legend, blend};
use super::window::Window;

/// Columns of a pixel.
const COLUMNS: usize = 2;
/// What hatching takes from a shade, or of what is missing to white it gives to it.
const HATCH_PART: f32 = 0.35;

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
    /// How it is hatched, and whether by darker lines.
    hatch: (Hatch, bool),
}

impl Paint {
    fn at(self, column: usize, row: usize) -> [f32; 3] {
        let (hatch, dark_lines) = self.hatch;
        if !hatch.marks(column, row) {
            return self.rgb;
        }
        self.rgb.map(|c| c + HATCH_PART * if dark_lines { -c } else { 255.0 - c })
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
    hatch: (Hatch, bool),
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
    let hatches: Vec<(Hatch, bool)> = section.media.iter().map(|medium| legend.hatch(medium)).collect();
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
    let of = |crystal: &CrystalLayer| {
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

fn paint(medium: &Medium, hatch: (Hatch, bool), x: f64) -> Paint {
    let rgb = match medium {
        Medium::Pure(substance) => shade(substance),
        Medium::Mixture { first, second, .. } => blend(shade(first), shade(second), medium.fraction(x)),
    };
    Paint { rgb: rgb.map(f32::from), hatch }
}

/// What a line down at x meets of the layers.
fn layers(section: &Section, hatches: &[(Hatch, bool)], x: f64) -> Vec<Run> {
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
    use crate::live::extent;
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
            // Rods are smaller than these pixels, and so make them grey.
            let dark = drawn.rgb.chunks_exact(3).filter(|p| p[0] < 190).count();
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
    }

    #[test]
    fn what_covers_leaves_the_rest_as_it_was() {
        let paint = |grey: f32| Paint { rgb: [grey; 3], hatch: (Hatch::Plain, true) };
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
