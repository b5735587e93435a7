//! Classes of pixels, cleaned, and the connected regions that they form.

use image::{GrayImage, Luma};
use imageproc::distance_transform::Norm;
use imageproc::morphology::open;
use imageproc::region_labelling::{Connectivity, connected_components};

use super::field::{Grey, part};
use super::shading::Flat;

/// A connected region of one class.
#[derive(Debug, Clone)]
pub(super) struct Region {
    /// 0 is the brightest.
    pub(super) class: usize,
    /// px.
    pub(super) area: usize,
    /// Left, top, right, bottom, the last two beyond it.
    pub(super) bounds: [usize; 4],
    /// Whether it touches the left, upper, right, lower border.
    pub(super) border: [bool; 4],
    /// Mean place, px.
    pub(super) middle: [f64; 2],
    /// Neighbours and how many sides of pixels they share, the longest first.
    pub(super) neighbours: Vec<(usize, usize)>,
}

impl Region {
    pub(super) fn touches_border(&self) -> bool {
        self.border.contains(&true)
    }
}

/// The regions of a picture: `labels` has for each pixel the index of its region.
#[derive(Debug, Clone)]
pub(super) struct Map {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) labels: Vec<u32>,
    pub(super) regions: Vec<Region>,
}

/// Classes of pixels by thresholds from bright to dark.
pub(super) fn classes(grey: &Grey, thresholds: &[f64]) -> Vec<u8> {
    let class = |value: f32| thresholds.iter().filter(|t| f64::from(value) < **t).count() as u8;
    grey.values.iter().map(|value| class(*value)).collect()
}

/// The standard deviation of the Gaussian that edges are blurred by, px: from the steepest slopes, each with the height of its own
/// step. Good to a tenth or so.
pub(super) fn edge_blur(flat: &Flat) -> f64 {
    let grey = &flat.grey;
    let [width, height] = grey.size();
    let step = ((width * height) / 300_000 + 1).max(1);
    let places = || (0..width * height).step_by(step).map(|at| (at % width, at / width));
    let slope = |(x, y): (usize, usize)| {
        let [a, b] = grey.slope(x, y);
        a.hypot(b)
    };
    let mut slopes: Vec<f64> = places().map(slope).collect();
    let steep = 0.6 * part(&mut slopes, 0.995);
    let mut found: Vec<f64> = Vec::new();
    for (x, y) in places().filter(|place| slope(*place) > steep).take(4000) {
        let [a, b] = grey.slope(x, y);
        let length = a.hypot(b);
        let along = |d: f64| grey.sample(x as f64 + 0.5 + d * a / length, y as f64 + 0.5 + d * b / length);
        let end = |sign: f64| {
            let (mut last, mut d) = (along(0.0), 0.0);
            while d < 16.0 {
                d += 1.0;
                let next = along(sign * d);
                if (next - last) * sign <= 0.02 * length {
                    break;
                }
                last = next;
            }
            last
        };
        let height = end(1.0) - end(-1.0);
        // A pixel on the flank only: the steepest slope of a step is that of its middle.
        let middle = along(0.0) - end(-1.0);
        if (0.3..0.7).contains(&(middle / height)) {
            found.push(height / (length * (2.0 * std::f64::consts::PI).sqrt()));
        }
    }
    if found.is_empty() { 1.0 } else { part(&mut found, 0.4).clamp(0.3, 12.0) }
}

/// Where the brightest and the darkest of three classes meet, the blur makes a seam of the middle one: it is divided between the two.
pub(super) fn without_seams(classes: &mut [u8], flat: &Flat, blur: f64) {
    if flat.levels.len() != 3 {
        return;
    }
    let [width, height] = flat.grey.size();
    let middle: Vec<u8> = classes.iter().map(|class| if *class == 1 { 255 } else { 0 }).collect();
    let Some(image) = GrayImage::from_raw(width as u32, height as u32, middle) else { return };
    // A seam is up to 1.6 deviations wide.
    let radius = (1.0 * blur + 0.5).ceil().clamp(1.0, 30.0) as u8;
    let wide = open(&image, Norm::L2, radius);
    let thin: Vec<u8> = image
        .iter()
        .zip(wide.iter())
        .map(|(all, wide)| if *all > 0 && *wide == 0 { 255 } else { 0 })
        .collect();
    let Some(thin) = GrayImage::from_raw(width as u32, height as u32, thin) else { return };
    let labels = connected_components(&thin, Connectivity::Four, Luma([0]));
    let count = labels.iter().max().map_or(0, |most| *most as usize + 1);
    // Sides that each thin part shares with the bright and the dark class.
    let mut sides = vec![[0_usize; 2]; count];
    each_side(width, height, |a, b| {
        for (from, to) in [(a, b), (b, a)] {
            let label = labels.as_raw()[from] as usize;
            if label > 0 && classes[to] != 1 {
                sides[label][usize::from(classes[to] == 2)] += 1;
            }
        }
    });
    let half = 0.5 * (flat.levels[0] + flat.levels[2]);
    for (at, label) in labels.iter().enumerate() {
        let [bright, dark] = sides[*label as usize];
        // A seam has one on each side.
        if *label > 0 && 4 * bright.min(dark) >= bright.max(dark) && bright.min(dark) > 0 {
            classes[at] = if f64::from(flat.grey.values[at]) < half { 2 } else { 0 };
        }
    }
}

/// Calls with the indices of each two pixels that share a side.
fn each_side(width: usize, height: usize, mut call: impl FnMut(usize, usize)) {
    for at in 0..width * height {
        if at % width + 1 < width {
            call(at, at + 1);
        }
        if at + width < width * height {
            call(at, at + width);
        }
    }
}

impl Map {
    /// The connected regions of classes, of which those under `least` px go to the neighbour with which they share most.
    pub(super) fn of(classes: &mut [u8], [width, height]: [usize; 2], least: usize) -> Self {
        let mut map = Self::labelled(classes, [width, height]);
        for _ in 0..3 {
            let specks: Vec<Option<usize>> = map
                .regions
                .iter()
                .map(|region| {
                    let home = region.neighbours.first().filter(|_| region.area < least);
                    home.map(|(home, _)| map.regions[*home].class)
                })
                .collect();
            if specks.iter().all(Option::is_none) {
                break;
            }
            for (class, label) in classes.iter_mut().zip(&map.labels) {
                if let Some(home) = specks[*label as usize] {
                    *class = home as u8;
                }
            }
            map = Self::labelled(classes, [width, height]);
        }
        map
    }

    fn labelled(classes: &[u8], [width, height]: [usize; 2]) -> Self {
        let shown: Vec<u8> = classes.iter().map(|class| class + 1).collect();
        let labels: Vec<u32> = GrayImage::from_raw(width as u32, height as u32, shown)
            .map(|image| connected_components(&image, Connectivity::Four, Luma([0])).into_raw())
            .unwrap_or_default();
        // Labels begin with 1, since no pixel is background.
        let labels: Vec<u32> = labels.into_iter().map(|label| label.saturating_sub(1)).collect();
        let count = labels.iter().max().map_or(0, |most| *most as usize + 1);
        let blank = Region {
            class: 0,
            area: 0,
            bounds: [width, height, 0, 0],
            border: [false; 4],
            middle: [0.0; 2],
            neighbours: Vec::new(),
        };
        let mut regions = vec![blank; count];
        for (at, label) in labels.iter().enumerate() {
            let region = &mut regions[*label as usize];
            let [x, y] = [at % width, at / width];
            region.class = usize::from(classes[at]);
            region.area += 1;
            let [left, top, right, bottom] = region.bounds;
            region.bounds = [left.min(x), top.min(y), right.max(x + 1), bottom.max(y + 1)];
            region.middle[0] += x as f64 + 0.5;
            region.middle[1] += y as f64 + 0.5;
        }
        for region in &mut regions {
            region.middle = region.middle.map(|sum| sum / region.area as f64);
            let [left, top, right, bottom] = region.bounds;
            region.border = [left == 0, top == 0, right == width, bottom == height];
        }
        let mut shared = std::collections::BTreeMap::<(u32, u32), usize>::new();
        each_side(width, height, |a, b| {
            let (a, b) = (labels[a], labels[b]);
            if a != b {
                *shared.entry((a.min(b), a.max(b))).or_default() += 1;
            }
        });
        for ((a, b), sides) in shared {
            regions[a as usize].neighbours.push((b as usize, sides));
            regions[b as usize].neighbours.push((a as usize, sides));
        }
        regions.iter_mut().for_each(|r| r.neighbours.sort_by_key(|(_, sides)| std::cmp::Reverse(*sides)));
        Self { width, height, labels, regions }
    }

    /// The regions that lie inside a region: those that reach the border of the picture through it alone.
    pub(super) fn inside(&self, region: usize) -> Vec<usize> {
        let mut is_outside = vec![false; self.regions.len()];
        let mut open: Vec<usize> = (0..self.regions.len())
            .filter(|other| *other != region && self.regions[*other].touches_border())
            .collect();
        while let Some(next) = open.pop() {
            if !std::mem::replace(&mut is_outside[next], true) {
                let around = self.regions[next].neighbours.iter().map(|(other, _)| *other);
                open.extend(around.filter(|other| *other != region && !is_outside[*other]));
            }
        }
        (0..self.regions.len()).filter(|other| *other != region && !is_outside[*other]).collect()
    }
}
