//! Follicles: as many points as are asked for, spread over a surface so that none is near another.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

use super::body::{Body, Spot};
use crate::math::rng::Stream;
use crate::progress::Progress;
use crate::scene::go_on;
use crate::{Error, Result};

/// Random points for each that stays.
const CANDIDATES: usize = 5;
/// Points thrown at a surface by which the area within a box is known.
const THROWS: u32 = 40_000;
/// Least share of a surface that a region may hold: so many points are thrown for each candidate at most.
const LEAST_SHARE: f64 = 1e-3;
const THROWN: usize = 1000;
/// Points that are thrown between two looks at whether to stop.
const AT_ONCE: usize = 1 << 14;
/// Names of random streams.
const MEASURE: u64 = 0x61_7265;
const DRAW: u64 = 0x64_7261;

/// The part of a body where feathers grow: a box, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Its least coordinates.
    pub low: [f64; 3],
    /// Its largest.
    pub high: [f64; 3],
}

impl Region {
    fn holds(&self, point: DVec3) -> bool {
        (point.cmpge(self.low.into()) & point.cmple(self.high.into())).all()
    }
}

/// Uniform random points of a body's surface, within a region where there is one.
struct Surface<'a> {
    body: &'a Body,
    /// Area of the triangles up to and with each.
    areas: Vec<f64>,
    region: Option<Region>,
}

impl<'a> Surface<'a> {
    fn new(body: &'a Body, region: Option<Region>) -> Self {
        let areas = (0..body.triangles.len() as u32).scan(0.0, |sum, triangle| {
            *sum += body.area(triangle);
            Some(*sum)
        });
        Self { body, areas: areas.collect(), region }
    }

    fn whole_area(&self) -> f64 {
        self.areas.last().copied().unwrap_or(0.0)
    }

    /// A random point; `None` where it is outside the region.
    fn draw(&self, stream: &mut Stream) -> Option<Spot> {
        let at = stream.unit() * self.whole_area();
        let triangle = self.areas.partition_point(|&area| area <= at).min(self.areas.len() - 1);
        let (root, across) = (stream.unit().sqrt(), stream.unit());
        let weights = [1.0 - root, root * (1.0 - across), root * across];
        let is_within = |region: Region| region.holds(self.body.point(triangle as u32, weights));
        self.region.is_none_or(is_within).then(|| self.body.spot(triangle as u32, weights))
    }
}

/// Area of a body's surface, mm²; that within a region by points thrown at it.
#[must_use]
pub fn area(body: &Body, region: Option<Region>) -> f64 {
    let surface = Surface::new(body, region);
    if region.is_none() {
        return surface.whole_area();
    }
    let mut stream = Stream::new(0, &[MEASURE]);
    let within = (0..THROWS).filter(|_| surface.draw(&mut stream).is_some()).count();
    surface.whole_area() * within as f64 / f64::from(THROWS)
}

/// Exactly `count` points of a surface of `area` mm², by removing from five times as many random ones again and again that
/// which has most others near it (sample elimination; Yuksel 2015, Computer Graphics Forum 34(2)).
///
/// # Errors
/// A region that holds next to none of the surface, or a stop by `progress`.
pub fn scattered(
    body: &Body,
    region: Option<Region>,
    area: f64,
    count: usize,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Vec<Spot>> {
    let surface = Surface::new(body, region);
    let refuse = |share: f64| {
        Err(Error::input(format!(
            "coat.within_mm holds hardly any of the body's surface (about {:.3} %); give a box that holds {} % of it at least",
            100.0 * share,
            100.0 * LEAST_SHARE
        )))
    };
    // What is known of the area is uncertain; half of the least is certainly too little.
    let share = area / surface.whole_area();
    if share.is_nan() || share < 0.5 * LEAST_SHARE {
        return refuse(share.max(0.0));
    }
    let (wanted, mut thrown) = (CANDIDATES * count, 0);
    let mut stream = Stream::new(seed, &[DRAW]);
    let mut spots = Vec::with_capacity(wanted);
    progress.begin("spreading the coat's follicles", wanted as u64);
    while spots.len() < wanted {
        if thrown >= THROWN * wanted {
            return refuse(spots.len() as f64 / thrown as f64);
        }
        go_on(progress)?;
        let before = spots.len();
        for _ in 0..AT_ONCE.min(THROWN * wanted - thrown) {
            thrown += 1;
            spots.extend(surface.draw(&mut stream));
            if spots.len() == wanted {
                break;
            }
        }
        progress.advance((spots.len() - before) as u64);
    }
    let kept = eliminated(&spots, area, count, progress)?;
    Ok(spots.into_iter().zip(kept).filter_map(|(spot, is_kept)| is_kept.then_some(spot)).collect())
}

/// The largest distance that all of `count` points on a plane of this area can have from their neighbours, mm.
#[must_use]
pub fn widest_spacing(area: f64, count: usize) -> f64 {
    2.0 * (area / (2.0 * 3.0_f64.sqrt() * count as f64)).sqrt()
}

/// Which of the points stay.
///
/// # Errors
/// A stop by `progress`.
fn eliminated(spots: &[Spot], area: f64, count: usize, progress: &dyn Progress) -> Result<Vec<bool>> {
    let reach = widest_spacing(area, count);
    // Yuksel's limit, by which no pair weighs much more than others: β = 0.65, γ = 1.5.
    let least = reach * (1.0 - libm::pow(count as f64 / spots.len() as f64, 1.5)) * 0.65;
    let pairs = neighbours(spots, reach, progress)?;
    let weight = |a: u32, b: u32| {
        let distance = (spots[a as usize].point - spots[b as usize].point).length();
        libm::pow(1.0 - distance.max(least).min(reach) / reach, 8.0)
    };
    let mut weights: Vec<f64> =
        (0_u32..).zip(&pairs).map(|(a, near)| near.iter().map(|&b| weight(a, b)).sum()).collect();
    // Weights are positive, so that their bits are ordered as they are.
    let mut heap: BinaryHeap<(u64, Reverse<u32>)> =
        (0_u32..).zip(&weights).map(|(a, w)| (w.to_bits(), Reverse(a))).collect();
    let mut is_kept = vec![true; spots.len()];
    let mut left = spots.len();
    progress.begin("thinning the coat's follicles", (left - count) as u64);
    while left > count
        && let Some((bits, Reverse(a))) = heap.pop()
    {
        if !is_kept[a as usize] || bits != weights[a as usize].to_bits() {
            continue;
        }
        go_on(progress)?;
        progress.advance(1);
        is_kept[a as usize] = false;
        left -= 1;
        for &b in pairs[a as usize].iter().filter(|&&b| is_kept[b as usize]) {
            weights[b as usize] = (weights[b as usize] - weight(a, b)).max(0.0);
            heap.push((weights[b as usize].to_bits(), Reverse(b)));
        }
    }
    Ok(is_kept)
}

/// Of each point those that are nearer than `reach` on the same side of the body.
///
/// # Errors
/// A stop by `progress`.
fn neighbours(spots: &[Spot], reach: f64, progress: &dyn Progress) -> Result<Vec<Vec<u32>>> {
    let near = Near::new(spots.iter().map(|spot| spot.point), reach);
    let of = |(a, spot): (u32, &Spot)| {
        go_on(progress)?;
        let mut found = Vec::new();
        near.visit(spot.point, |b| {
            let other = &spots[b as usize];
            let is_near = (other.point - spot.point).length_squared() < reach * reach;
            if a != b && is_near && other.normal.dot(spot.normal) > 0.0 {
                found.push(b);
            }
        });
        Ok(found)
    };
    (0..spots.len() as u32).into_par_iter().zip(spots).map(of).collect()
}

/// Points in cubes of a size, to be found again.
pub(super) struct Near {
    cells: HashMap<I64Vec3, Vec<u32>>,
    size: f64,
}

impl Near {
    /// Points by their number, in cubes of this size.
    pub(super) fn new(points: impl Iterator<Item = DVec3>, size: f64) -> Self {
        let mut cells: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
        for (index, point) in (0_u32..).zip(points) {
            cells.entry((point / size).floor().as_i64vec3()).or_default().push(index);
        }
        Self { cells, size }
    }

    /// Calls with every point of the cube about a point and of those around it, always in the same order.
    pub(super) fn visit(&self, point: DVec3, mut found: impl FnMut(u32)) {
        let middle = (point / self.size).floor().as_i64vec3();
        for k in 0..27 {
            let step = I64Vec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
            if let Some(cell) = self.cells.get(&(middle + step)) {
                cell.iter().for_each(|&index| found(index));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::progress::{Shared, Unobserved};
    use crate::scene::geometry::Place;

    fn nearest(spots: &[Spot]) -> Vec<f64> {
        let of = |(i, spot): (usize, &Spot)| {
            let others = spots.iter().enumerate().filter(|(j, _)| *j != i);
            others.map(|(_, other)| (other.point - spot.point).length()).fold(f64::MAX, f64::min)
        };
        spots.iter().enumerate().map(of).collect()
    }

    /// As many as are asked for; no two nearer than 0.6 of what the densest packing allows (random ones: 0.02), and no bald
    /// patch: from nowhere it is farther to the next than 1.3 of that (random ones: 2 and more).
    #[test]
    fn points_are_apart_and_everywhere() {
        let body = Body::ellipsoid([30.0, 50.0, 30.0], &Place::HERE, 3.0);
        let whole = area(&body, None);
        for count in [1, 7, 600] {
            assert_eq!(scattered(&body, None, whole, count, 3, &Unobserved).unwrap().len(), count);
        }
        let spots = scattered(&body, None, whole, 600, 3, &Unobserved).unwrap();
        let widest = widest_spacing(whole, 600);
        let apart = nearest(&spots);
        let least = apart.iter().fold(f64::MAX, |a, b| a.min(*b)) / widest;
        let mean = apart.iter().sum::<f64>() / 600.0 / widest;
        assert!(least > 0.6 && mean > 0.75, "{least} {mean}");
        let surface = Surface::new(&body, None);
        let mut stream = Stream::new(9, &[]);
        let hole = (0..4000)
            .filter_map(|_| surface.draw(&mut stream))
            .map(|from| spots.iter().map(|spot| (spot.point - from.point).length()).fold(f64::MAX, f64::min));
        let hole = hole.fold(0.0, f64::max) / widest;
        assert!(hole < 1.0, "{hole}");
        let random: Vec<Spot> = (0..600).filter_map(|_| surface.draw(&mut stream)).collect();
        assert!(nearest(&random).iter().fold(f64::MAX, |a, b| a.min(*b)) < 0.2 * widest);
    }

    /// A hemisphere's area is half of the sphere's, and points stay in it; a box beside the body is refused.
    #[test]
    fn a_region_holds_its_points() {
        let body = Body::ellipsoid([20.0; 3], &Place::HERE, 2.0);
        let half = Region { low: [-30.0, -30.0, 0.0], high: [30.0; 3] };
        let found = area(&body, Some(half));
        assert!((found / (2.0 * PI * 400.0) - 1.0).abs() < 0.02, "{found}");
        let spots = scattered(&body, Some(half), found, 100, 1, &Unobserved).unwrap();
        assert!(spots.len() == 100 && spots.iter().all(|spot| spot.point.z >= 0.0));
        let beside = Region { low: [30.0; 3], high: [40.0; 3] };
        assert_eq!(area(&body, Some(beside)), 0.0);
        let refused = scattered(&body, Some(beside), 0.0, 10, 1, &Unobserved).unwrap_err().to_string();
        assert!(refused.starts_with("coat.within_mm holds hardly any"), "{refused}");
        // What holds far too little is known before any of 250 million points is thrown.
        let (whole, watched) = (area(&body, None), Shared::default());
        let refused =
            scattered(&body, Some(half), 4e-4 * whole, 50_000, 1, &watched).unwrap_err().to_string();
        assert!(refused.contains("(about 0.040 %); give a box that holds 0.1 % of it at least"), "{refused}");
        assert_eq!(watched.snapshot().stage, 0);
    }
}
