//! Rods that touch, parted: each is the disc through what is free of its outline.

use image::GrayImage;
use imageproc::distance_transform::euclidean_squared_distance_transform;

use super::fit::Normal;
use super::outline::{Outline, around};
use super::rods::{Rod, Search};

/// A disc, px.
#[derive(Debug, Clone, Copy)]
struct Disc {
    middle: [f64; 2],
    radius: f64,
}

/// Half the angle about a neighbour's direction in which an outline is not free, at least and at most: where the gap between two
/// discs is narrower than three deviations of the blur.
const NOT_FREE: [f64; 2] = [0.3, 0.65];
/// Directions of which enough must be free.
const DIRECTIONS: usize = 24;
/// A disc must follow the free outline within this part of its radius, root mean square.
const MOST_OFF: f64 = 0.08;

impl Search<'_> {
    /// The rods that a dark region consists of, if it consists of such; those that the border cuts are left out.
    pub(super) fn parted(&self, index: usize, blur: f64) -> Vec<Rod> {
        let region = &self.map.regions[index];
        let brightest = 0;
        let inside = self.map.inside(index);
        let is_air = |label: &usize| self.levels.len() == 3 && self.map.regions[*label].class == brightest;
        let is_rod = |label: usize| label == index || inside.contains(&label) && is_air(&label);
        let seeds = self.seeds(region.bounds, &is_rod);
        if seeds.len() < 2 {
            return Vec::new();
        }
        // Outlines towards what is around and towards the gaps between rods.
        let mut points: Vec<[f64; 2]> = Vec::new();
        for (other, _) in &region.neighbours {
            let class = self.map.regions[*other].class;
            if is_rod(*other) {
                continue;
            }
            let level = (self.between)(class, region.class);
            let outline = if inside.contains(other) {
                let bounds = self.map.regions[*other].bounds;
                around(self.grey, self.map, bounds, level, class < region.class, &|label| label == *other)
            } else {
                let dark = |label: usize| label == index || inside.contains(&label);
                around(self.grey, self.map, region.bounds, level, region.class < class, &dark)
            };
            points.extend(outline.into_iter().flat_map(|outline| outline.corners));
        }
        let holes: Vec<Outline> = inside
            .iter()
            .filter(|label| is_air(label))
            .filter_map(|hole| {
                let inner = &self.map.regions[*hole];
                let level = (self.between)(inner.class, region.class);
                around(self.grey, self.map, inner.bounds, level, true, &|label| label == *hole)
            })
            .map(|hole| hole.unblurred(blur))
            .collect();
        let discs = self.fitted(&seeds, &points, blur);
        discs.into_iter().map(|disc| self.rod_of(disc, &holes, blur)).collect()
    }

    fn rod_of(&self, disc: Disc, holes: &[Outline], blur: f64) -> Rod {
        let radius = (disc.radius * disc.radius + blur * blur).sqrt();
        let hole = holes.iter().find(|hole| {
            let (_, at) = hole.area_and_middle();
            (at[0] - disc.middle[0]).hypot(at[1] - disc.middle[1]) < 0.5 * radius
        });
        let turn = |i: usize| (i as f64 / 64.0 * std::f64::consts::TAU).sin_cos();
        let corners = (0..64)
            .map(turn)
            .map(|(sin, cos)| [disc.middle[0] + radius * cos, disc.middle[1] + radius * sin]);
        Rod {
            middle: disc.middle,
            diameter: 2.0 * radius,
            hollow: hole.map_or(0.0, Outline::diameter),
            outlines: std::iter::once(Outline { corners: corners.collect() }).chain(hole.cloned()).collect(),
            is_parted: true,
        }
    }

    /// The middles of discs: the places of rods that are farthest from what is none.
    fn seeds(&self, bounds: [usize; 4], is_rod: &dyn Fn(usize) -> bool) -> Vec<Disc> {
        let [left, top] = [bounds[0].saturating_sub(1), bounds[1].saturating_sub(1)];
        let [right, bottom] = [(bounds[2] + 1).min(self.map.width), (bounds[3] + 1).min(self.map.height)];
        let (width, height) = (right - left, bottom - top);
        let outside: Vec<u8> = (0..width * height)
            .map(|at| {
                let label = self.map.labels[(top + at / width) * self.map.width + left + at % width];
                if is_rod(label as usize) { 0 } else { 255 }
            })
            .collect();
        let Some(image) = GrayImage::from_raw(width as u32, height as u32, outside) else {
            return Vec::new();
        };
        let depth: Vec<f64> = euclidean_squared_distance_transform(&image).iter().map(|d| d.sqrt()).collect();
        let deepest = depth.iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
        let mut order: Vec<usize> =
            (0..depth.len()).filter(|at| depth[*at] > 0.6 * deepest && depth[*at].is_finite()).collect();
        order.sort_by(|a, b| depth[*b].total_cmp(&depth[*a]));
        let mut seeds: Vec<Disc> = Vec::new();
        for at in order {
            let middle = [(left + at % width) as f64 + 0.5, (top + at / width) as f64 + 0.5];
            let apart = |seed: &Disc| (seed.middle[0] - middle[0]).hypot(seed.middle[1] - middle[1]);
            if seeds.iter().all(|seed| apart(seed) > 1.3 * seed.radius) {
                seeds.push(Disc { middle, radius: depth[at] });
            }
        }
        seeds
    }

    /// Discs through the free parts of the outlines, of the seeds that have enough of it.
    fn fitted(&self, seeds: &[Disc], points: &[[f64; 2]], blur: f64) -> Vec<Disc> {
        let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let mut of: Vec<Vec<[f64; 2]>> = vec![Vec::new(); seeds.len()];
        for point in points {
            let gap = |seed: &Disc| distance(*point, seed.middle) - seed.radius;
            let nearest = (0..seeds.len()).min_by(|a, b| gap(&seeds[*a]).total_cmp(&gap(&seeds[*b])));
            if let Some(nearest) = nearest.filter(|n| gap(&seeds[*n]) < 0.35 * seeds[*n].radius) {
                of[nearest].push(*point);
            }
        }
        seeds
            .iter()
            .zip(of)
            .filter_map(|(seed, points)| {
                let angle = |to: [f64; 2]| (to[1] - seed.middle[1]).atan2(to[0] - seed.middle[0]);
                let beside: Vec<f64> = seeds
                    .iter()
                    .filter(|other| (0.1..2.6 * seed.radius).contains(&distance(other.middle, seed.middle)))
                    .map(|other| angle(other.middle))
                    .collect();
                let not_free =
                    (1.0 - 1.5 * blur / seed.radius).max(0.0).acos().clamp(NOT_FREE[0], NOT_FREE[1]);
                let is_free = |point: &[f64; 2]| {
                    beside.iter().all(|other| {
                        let apart = (angle(*point) - other).rem_euclid(std::f64::consts::TAU);
                        apart.min(std::f64::consts::TAU - apart) > not_free
                    })
                };
                let free: Vec<[f64; 2]> = points.into_iter().filter(is_free).collect();
                let mut seen = [false; DIRECTIONS];
                for point in &free {
                    let turn = (angle(*point) / std::f64::consts::TAU).rem_euclid(1.0);
                    seen[((turn * DIRECTIONS as f64) as usize).min(DIRECTIONS - 1)] = true;
                }
                // Three directions that surround the middle, or nearly so.
                let widest = widest_gap(&seen);
                let disc = disc_through(&free).filter(|_| widest <= DIRECTIONS / 2)?;
                let [w, h] = self.grey.size().map(|side| side as f64);
                let is_whole =
                    (0..2).all(|i| disc.middle[i] > disc.radius && disc.middle[i] + disc.radius < [w, h][i]);
                (is_whole && (0.6..1.6).contains(&(disc.radius / seed.radius))).then_some(disc)
            })
            .collect()
    }
}

/// The most directions in a row without a point.
fn widest_gap(seen: &[bool; DIRECTIONS]) -> usize {
    let (mut widest, mut gap) = (0, 0);
    for seen in seen.iter().chain(seen) {
        gap = if *seen { 0 } else { gap + 1 };
        widest = widest.max(gap);
    }
    widest
}

/// The circle that fits points best in the sense of I. Kåsa (IEEE Transactions on Instrumentation and Measurement 25, 8, 1976).
fn disc_through(points: &[[f64; 2]]) -> Option<Disc> {
    if points.len() < 12 {
        return None;
    }
    let n = points.len() as f64;
    let mean = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / n);
    let mut normal = Normal::new(3);
    for p in points {
        let [x, y] = [p[0] - mean[0], p[1] - mean[1]];
        normal.add(&[2.0 * x, 2.0 * y, 1.0], x * x + y * y);
    }
    let [a, b, c] = normal.solved()?.try_into().ok()?;
    let radius: f64 = (c + a * a + b * b).sqrt();
    let middle = [mean[0] + a, mean[1] + b];
    let off =
        points.iter().map(|p| ((p[0] - middle[0]).hypot(p[1] - middle[1]) - radius).powi(2)).sum::<f64>() / n;
    (off.sqrt() < MOST_OFF * radius).then_some(Disc { middle, radius })
}
