//! Hummingbirds (the feather paper's supplement, §1.4, figure 8): layers of pancake melanosomes, each with a row of air bubbles.

use std::f64::consts::PI;

use super::super::curve::{Roughness, grid, point_count};
use super::super::section::{Inclusion, Loop, Medium, Parts, Polyline};
use super::super::smooth::FINER_THAN_LIGHT_UM;
use super::generator::{Generator, Random, parts};
use crate::fields::within;
use crate::material::Library;
use crate::math::rng::Stream;
use crate::{Error, Result, record};

/// The ends' rounding takes at most this part of the thickness from above and from below.
const LARGEST_ROUNDING: f64 = 0.45;

/// Between the melanosomes' ends and the rounded ends of the barbule, beside the cortex, µm.
const CLEARANCE_UM: f64 = 0.02;

/// Segments of a melanosome's rounded end, and the fewest of the upper or lower half of a bubble.
const CAP_SEGMENTS: usize = 8;
const FEWEST_SEGMENTS: usize = 4;

/// Bubbles' necks are this part of the smaller half-height: as in chains, a third of the height on either side.
pub(in crate::structure) const NECK: f64 = 2.0 / 3.0;

/// The random stream of the layers.
const LAYERS: u64 = 0;

/// More bubbles than this would be over the limit of points anyway.
const MOST_BUBBLES: f64 = 1e5;

record! {
    /// Parameters of the hummingbird generator.
    #[derive(Debug, Clone, PartialEq, serde::Serialize)]
    pub struct Hummingbird {
        /// Width of the barbule.
        width_um: f64 = "width_um", within(1, 200);
        /// Layers of melanosomes.
        layers: usize = "layers", within(1, 60);
        /// Correlation length of the top's roughness.
        roughness_correlation_um: f64 = "roughness_correlation_um", within(0.05, 100);
        /// The top's roughness spans ± this.
        roughness_amplitude_um: f64 = "roughness_amplitude_um", within(0, 10);
        /// Correlation length of the bottom's roughness against the top.
        bottom_correlation_um: f64 = "bottom_correlation_um", within(0.05, 100);
        /// The bottom's roughness against the top spans ± this.
        bottom_amplitude_um: f64 = "bottom_amplitude_um", within(0, 10);
        /// Radius of the circles that round the ends.
        end_radius_um: f64 = "end_radius_um", within(0, 10);
        /// Keratin over the first layer and under the last.
        cortex_um: f64 = "cortex_um", within(0.001, 5);
        /// Melanin over and under the air of a melanosome.
        wall_um: f64 = "wall_um", within(0.002, 2);
        /// Thickness of the air in a melanosome.
        air_um: f64 = "air_um", within(0.005, 5);
        /// Thickness of the air in the topmost layer.
        air_first_um: f64 = "air_first_um", within(0.005, 5);
        /// The second layer's air is this part of the first's and the rest of the others'.
        air_second_share: f64 = "air_second_share", within(0, 1);
        /// The other layers' air is `air_um`·U(1−this, 1+this).
        air_spread: f64 = "air_spread", within(0, 0.9);
        /// Keratin between layers.
        gap_um: f64 = "gap_um", within(0.002, 5);
        /// Factor of the gap under the first layer.
        gap_first: f64 = "gap_first", within(0.1, 10);
        /// Factor of the gap under the second layer.
        gap_second: f64 = "gap_second", within(0.1, 10);
        /// The other gaps are `gap_um`·U(1−this, 1+this).
        gap_spread: f64 = "gap_spread", within(0, 0.9);
        /// Mean length of a melanosome.
        melanosome_length_um: f64 = "melanosome_length_um", within(0.05, 100);
        /// Lengths are U(1−this, 1+this) of the mean, then rescaled to the coverage.
        melanosome_length_spread: f64 = "melanosome_length_spread", within(0, 0.9);
        /// Part of the topmost layer's length that melanosomes cover.
        coverage_first: f64 = "coverage_first", within(0.05, 0.99);
        /// Part of the other layers' length that melanosomes cover.
        coverage: f64 = "coverage", within(0.05, 0.99);
        /// Mean length of a bubble in units of the air's thickness.
        bubble_aspect: f64 = "bubble_aspect", within(0.1, 100);
        /// Bubbles' lengths are U(1−this, 1+this) of the mean, then rescaled to fill the melanosome.
        bubble_length_spread: f64 = "bubble_length_spread", within(0, 0.9);
        /// Bubbles' heights are the air's thickness + U(−this, this).
        bubble_height_spread_um: f64 = "bubble_height_spread_um", within(0, 1);
        /// Between neighbouring bubbles.
        membrane_um: f64 = "membrane_um", within(0, 1);
        /// Distance of points along the shapes.
        point_spacing_um: f64 = "point_spacing_um", within(0.005, 1);
    }
}

/// One layer of melanosomes.
pub(in crate::structure) struct Stacked {
    /// Thickness of the air.
    pub(in crate::structure) air_um: f64,
    /// Of the middle, below the top.
    pub(in crate::structure) depth_um: f64,
}

impl Generator for Hummingbird {
    fn width_um(&self) -> f64 {
        self.width_um
    }

    fn smooth_um(&self) -> Option<f64> {
        Some(FINER_THAN_LIGHT_UM)
    }

    fn check(&self) -> Result<()> {
        let bubble = self.air_um.min(self.air_first_um) * self.bubble_aspect + self.membrane_um;
        let bubbles = self.width_um * self.layers as f64 / bubble;
        if bubbles > MOST_BUBBLES {
            return Err(Error::input(format!(
                "parameters: about {bubbles:.0} bubbles, over the limit of {MOST_BUBBLES}; make bubbles longer, or the barbule narrower"
            )));
        }
        let inset = self.end_radius_um.min(0.25 * self.width_um) + self.cortex_um + CLEARANCE_UM;
        if self.width_um - 2.0 * inset < self.melanosome_length_um {
            return Err(Error::input(format!(
                "parameters.width_um is {}, too narrow for one melanosome between its rounded ends",
                self.width_um
            )));
        }
        let outer = self.air_um.max(self.air_first_um) * (1.0 + self.air_spread) + 2.0 * self.wall_um;
        let shortest = self.melanosome_length_um * (1.0 - self.melanosome_length_spread);
        if shortest < 0.5 * outer {
            return Err(Error::input(format!(
                "parameters.melanosome_length_um: the shortest melanosome, {shortest:.3} µm, is under half as long as thick ({outer:.3} µm)"
            )));
        }
        Ok(())
    }

    fn room(&self) -> String {
        format!(
            "{} layers are gap_um apart, less air_spread × air_um and bubble_height_spread_um, between a top and a bottom that differ by bottom_amplitude_um; make gap_um or cortex_um larger, or these smaller",
            self.layers
        )
    }

    fn parts(&self, random: &Random, _library: &Library) -> Parts {
        let (width, spacing) = (self.width_um, self.point_spacing_um);
        let (layers, thickness) = self.layers(&mut random.stream(LAYERS));
        let count = point_count(width, spacing);
        let step = width / (count - 1) as f64;
        let x_um = grid(width, count);
        let roughness = Roughness::symmetric(self.roughness_correlation_um, self.roughness_amplitude_um);
        let z_top = roughness.along(&mut random.stream(1), count, step);
        let bottom = Roughness::symmetric(self.bottom_correlation_um, self.bottom_amplitude_um);
        let z_bottom: Vec<f64> = bottom
            .along(&mut random.stream(2), count, step)
            .iter()
            .zip(&z_top)
            .map(|(rough, top)| top - thickness + rough)
            .collect();
        let radius = self.end_radius(thickness);
        let top = Polyline { x_um: x_um.clone(), z_um: z_top };
        let bottom = Polyline { x_um: x_um.clone(), z_um: z_bottom };
        let mut inclusions = Vec::new();
        for (index, layer) in layers.iter().enumerate() {
            let weight = layer.depth_um / thickness;
            let z_um =
                top.z_um.iter().zip(&bottom.z_um).map(|(t, b)| t * (1.0 - weight) + b * weight).collect();
            let guide = Polyline { x_um: x_um.clone(), z_um };
            self.melanosomes(&mut random.part(3, index), index, layer, thickness, guide, &mut inclusions);
        }
        let named = Medium::named;
        let boundaries =
            vec![rounded_ends(&top, radius, -1.0, spacing), rounded_ends(&bottom, radius, 1.0, spacing)];
        Parts { inclusions, ..parts(width, boundaries, vec![named("air"), named("keratin"), named("air")]) }
    }
}

impl Hummingbird {
    /// The first three layers of the same hummingbird with mean values in place of random ones, for sketches.
    #[must_use]
    pub fn without_randomness(&self) -> Self {
        let width_um = 2.0 * self.melanosome_length_um + 2.0 * self.cortex_um + 4.0 * CLEARANCE_UM;
        Self {
            width_um: width_um.clamp(1.0, 200.0),
            layers: self.layers.min(3),
            roughness_amplitude_um: 0.0,
            bottom_amplitude_um: 0.0,
            end_radius_um: 0.0,
            air_spread: 0.0,
            gap_spread: 0.0,
            melanosome_length_spread: 0.0,
            bubble_length_spread: 0.0,
            bubble_height_spread_um: 0.0,
            point_spacing_um: self.point_spacing_um.min(0.01),
            ..self.clone()
        }
    }

    /// The layers of an instance from the top down, and the barbule's thickness, µm.
    pub(in crate::structure) fn stacked(&self, seed: u64, index: usize) -> (Vec<Stacked>, f64) {
        self.layers(&mut Random { seed, instance: index as u64 }.stream(LAYERS))
    }

    /// The radius that rounds the ends of a barbule of this thickness.
    fn end_radius(&self, thickness: f64) -> f64 {
        self.end_radius_um.min(LARGEST_ROUNDING * thickness).min(0.25 * self.width_um)
    }

    /// The layers from the top down, and the barbule's thickness.
    fn layers(&self, stream: &mut Stream) -> (Vec<Stacked>, f64) {
        let mut layers = Vec::with_capacity(self.layers);
        let mut depth = self.cortex_um;
        for index in 0..self.layers {
            let vary = |stream: &mut Stream, spread: f64| stream.uniform(1.0 - spread, 1.0 + spread);
            let regular = self.air_um * vary(stream, self.air_spread);
            let air = match index {
                0 => self.air_first_um,
                1 => self.air_second_share * self.air_first_um + (1.0 - self.air_second_share) * self.air_um,
                _ => regular,
            };
            let outer = air + 2.0 * self.wall_um;
            layers.push(Stacked { air_um: air, depth_um: depth + 0.5 * outer });
            let factor = vary(stream, self.gap_spread);
            let gap = match index {
                0 => self.gap_um * self.gap_first,
                1 => self.gap_um * self.gap_second,
                _ => self.gap_um * factor,
            };
            depth += outer + if index + 1 < self.layers { gap } else { self.cortex_um };
        }
        (layers, depth)
    }

    /// The melanosomes of one layer and the voids in them.
    fn melanosomes(
        &self,
        stream: &mut Stream,
        index: usize,
        layer: &Stacked,
        thickness: f64,
        guide: Polyline,
        into: &mut Vec<Inclusion>,
    ) {
        let half = 0.5 * layer.air_um + self.wall_um;
        let radius = self.end_radius(thickness);
        // Where the rounding of the ends leaves the cortex over (or under) the layer.
        let room =
            (layer.depth_um.min(thickness - layer.depth_um) - half - self.cortex_um).clamp(0.0, radius);
        let inset = radius - libm::sqrt(radius * radius - (radius - room) * (radius - room));
        let inset = inset + self.cortex_um + CLEARANCE_UM;
        let path = Path::new(guide);
        let (start, end) =
            (path.length_at(inset - 0.5 * self.width_um), path.length_at(0.5 * self.width_um - inset));
        let length = end - start;
        let coverage = if index == 0 { self.coverage_first } else { self.coverage };
        let count = (coverage * length / self.melanosome_length_um).round().max(1.0) as usize;
        let lengths = shares(stream, count, self.melanosome_length_spread, coverage * length);
        let gap = (1.0 - coverage) * length / count as f64;
        let mut at = start + 0.5 * gap;
        for long in lengths {
            let outline = self.pancake(&path, at, long, half);
            let void = self.void(stream, &path, at, long, layer.air_um);
            into.push(Inclusion { outline, medium: Medium::named("melanin"), holes: Vec::new() });
            into.push(Inclusion { outline: void, medium: Medium::named("air"), holes: Vec::new() });
            at += long + gap;
        }
    }

    /// A melanosome with rounded ends along a path.
    fn pancake(&self, path: &Path, start: f64, length: f64, half: f64) -> Loop {
        let cap = half.min(0.45 * length);
        let straight = length - 2.0 * cap;
        let steps = point_count(straight, self.point_spacing_um) - 1;
        let mut outline = Outline::new(path);
        for i in 0..=steps {
            outline.push(start + cap + straight * i as f64 / steps as f64, half);
        }
        let turn = |i: usize| 0.5 * PI - PI * i as f64 / CAP_SEGMENTS as f64;
        for i in 1..CAP_SEGMENTS {
            outline.push(start + length - cap + cap * libm::cos(turn(i)), half * libm::sin(turn(i)));
        }
        for i in (0..=steps).rev() {
            outline.push(start + cap + straight * i as f64 / steps as f64, -half);
        }
        for i in 1..CAP_SEGMENTS {
            outline.push(start + cap - cap * libm::cos(turn(i)), -half * libm::sin(turn(i)));
        }
        outline.close()
    }

    /// The row of bubbles of one melanosome, joined by necks into one scalloped void.
    fn void(&self, stream: &mut Stream, path: &Path, start: f64, length: f64, air: f64) -> Loop {
        // Short melanosomes keep some air whatever their walls.
        let wall = self.wall_um.min(0.2 * length);
        let inner = length - 2.0 * wall;
        let mean = air * self.bubble_aspect;
        let count = ((inner + self.membrane_um) / (mean + self.membrane_um)).round().max(1.0);
        let membrane = if count > 1.0 { self.membrane_um.min(0.5 * inner / (count - 1.0)) } else { 0.0 };
        let lengths =
            shares(stream, count as usize, self.bubble_length_spread, inner - (count - 1.0) * membrane);
        let heights: Vec<f64> = lengths
            .iter()
            .map(|_| {
                let spread = self.bubble_height_spread_um.min(0.5 * air);
                0.5 * (air + stream.uniform(-spread, spread))
            })
            .collect();
        // (centre, half-length, half-height, angle at the left neck, angle at the right neck)
        let mut at = start + wall;
        let mut bubbles = Vec::with_capacity(lengths.len());
        for (i, &long) in lengths.iter().enumerate() {
            let neck = |other: Option<&f64>| {
                other.map_or(0.0, |b| libm::asin(NECK * b.min(heights[i]) / heights[i]))
            };
            let left = neck(if i == 0 { None } else { heights.get(i - 1) });
            bubbles.push((at + 0.5 * long, 0.5 * long, heights[i], PI - left, neck(heights.get(i + 1))));
            at += long + membrane;
        }
        let mut outline = Outline::new(path);
        let segments = |a: f64| ((PI * a / self.point_spacing_um).ceil() as usize).max(FEWEST_SEGMENTS);
        for &(centre, a, b, from, to) in &bubbles {
            let count = segments(a);
            for i in 0..=count {
                let angle = from + (to - from) * i as f64 / count as f64;
                outline.push(centre + a * libm::cos(angle), b * libm::sin(angle));
            }
        }
        for (index, &(centre, a, b, from, to)) in bubbles.iter().enumerate().rev() {
            let count = segments(a);
            // The row's two end points are on the axis: they are there already.
            let first = usize::from(index + 1 == bubbles.len());
            let last = count - usize::from(index == 0);
            for i in first..=last {
                let angle = to + (from - to) * i as f64 / count as f64;
                outline.push(centre + a * libm::cos(angle), -b * libm::sin(angle));
            }
        }
        outline.close()
    }
}

/// `count` random parts U(1−spread, 1+spread), rescaled to their sum.
fn shares(stream: &mut Stream, count: usize, spread: f64, sum: f64) -> Vec<f64> {
    let mut parts: Vec<f64> = (0..count).map(|_| stream.uniform(1.0 - spread, 1.0 + spread)).collect();
    let scale = sum / parts.iter().sum::<f64>();
    parts.iter_mut().for_each(|part| *part *= scale);
    parts
}

/// A surface whose last `radius` at each end turns inwards on a circle; `inwards` is the sign of z that leads there.
fn rounded_ends(surface: &Polyline, radius: f64, inwards: f64, spacing: f64) -> Polyline {
    let last = surface.x_um.len() - 1;
    let (left, right) = (surface.x_um[0], surface.x_um[last]);
    if radius < 1e-6 {
        return surface.clone();
    }
    let count = point_count(0.5 * PI * radius, spacing);
    let mut curve = Polyline::default();
    let mut push = |x: f64, turn: f64| {
        curve.x_um.push(x);
        curve.z_um.push(surface.height(x) + inwards * (radius - radius * turn));
    };
    let angle = |i: usize| 0.5 * PI * i as f64 / count as f64;
    for i in 0..count {
        push(left + radius * (1.0 - libm::cos(angle(i))), libm::sin(angle(i)));
    }
    for &x in surface.x_um.iter().filter(|&&x| x > left + radius && x < right - radius) {
        push(x, 1.0);
    }
    for i in (0..count).rev() {
        push(right - radius * (1.0 - libm::cos(angle(i))), libm::sin(angle(i)));
    }
    curve
}

/// A curve with its arc length and smooth directions.
struct Path {
    curve: Polyline,
    lengths: Vec<f64>,
    normals: Vec<[f64; 2]>,
}

impl Path {
    fn new(curve: Polyline) -> Self {
        let mut lengths = vec![0.0; curve.x_um.len()];
        for i in 1..lengths.len() {
            let (dx, dz) = (curve.x_um[i] - curve.x_um[i - 1], curve.z_um[i] - curve.z_um[i - 1]);
            lengths[i] = lengths[i - 1] + libm::hypot(dx, dz);
        }
        let normals = curve.normals();
        Self { curve, lengths, normals }
    }

    /// Arc length at x.
    fn length_at(&self, x: f64) -> f64 {
        let xs = &self.curve.x_um;
        let right = xs.partition_point(|&at| at <= x).clamp(1, xs.len() - 1);
        let t = (x - xs[right - 1]) / (xs[right] - xs[right - 1]);
        self.lengths[right - 1] + t * (self.lengths[right] - self.lengths[right - 1])
    }

    /// The point `above` the curve at an arc length.
    fn point(&self, length: f64, above: f64) -> [f64; 2] {
        let right = self.lengths.partition_point(|&at| at <= length).clamp(1, self.lengths.len() - 1);
        let left = right - 1;
        let t = (length - self.lengths[left]) / (self.lengths[right] - self.lengths[left]);
        let mix = |a: f64, b: f64| a + t * (b - a);
        let nx = mix(self.normals[left][0], self.normals[right][0]);
        let nz = mix(self.normals[left][1], self.normals[right][1]);
        let scale = above / libm::hypot(nx, nz);
        [
            mix(self.curve.x_um[left], self.curve.x_um[right]) + scale * nx,
            mix(self.curve.z_um[left], self.curve.z_um[right]) + scale * nz,
        ]
    }
}

/// Collects the corners of a loop given along and above a path.
struct Outline<'a> {
    path: &'a Path,
    corners: Polyline,
}

impl<'a> Outline<'a> {
    fn new(path: &'a Path) -> Self {
        Self { path, corners: Polyline::default() }
    }

    fn push(&mut self, along: f64, above: f64) {
        let [x, z] = self.path.point(along, above);
        self.corners.x_um.push(x);
        self.corners.z_um.push(z);
    }

    fn close(self) -> Loop {
        Loop::Polygon(self.corners)
    }
}
