//! Follicles: as many points as are asked for, spread over a surface so that none is near another.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap};

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

use super::body::{Body, Spot};
use super::field::Field;
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

/// A ball in which no feather grows: an eye, a beak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bare {
    /// Its middle, mm.
    pub position_mm: [f64; 3],
    /// Its radius, mm.
    pub radius_mm: f64,
}

impl Bare {
    fn holds(&self, point: DVec3) -> bool {
        (point - DVec3::from(self.position_mm)).length_squared() < self.radius_mm * self.radius_mm
    }

    /// How far it is from a point in a direction; none where it is not ahead.
    pub(super) fn ahead_mm(&self, point: DVec3, along: DVec3) -> Option<f64> {
        let to = DVec3::from(self.position_mm) - point;
        let ahead = to.dot(along);
        let beside = (to - along * ahead).length_squared();
        let half = self.radius_mm * self.radius_mm - beside;
        (ahead > 0.0 && half > 0.0).then(|| (ahead - half.sqrt()).max(0.0))
    }
}

/// Where feathers grow, and of which size.
#[derive(Debug, Clone, Copy)]
pub struct Ground<'a> {
    /// The body.
    pub body: &'a Body,
    /// The part of it; all where there is none.
    pub region: Option<Region>,
    /// Places without feathers.
    pub bare: &'a [Bare],
    /// Their size from place to place; the same everywhere where there is none.
    pub field: Option<&'a Field>,
}

impl Ground<'_> {
    fn holds(&self, point: DVec3) -> bool {
        self.region.is_none_or(|region| region.holds(point))
            && !self.bare.iter().any(|bare| bare.holds(point))
    }

    fn size(&self, triangle: u32, weights: [f64; 3]) -> f64 {
        self.field.map_or(1.0, |field| field.stature(self.body, triangle, weights)[0])
    }
}

/// How large the ground is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Its area, mm².
    pub mm2: f64,
    /// The same in squares of the feathers' size: that of a ground on which as many stand, all of size 1, mm².
    pub felt_mm2: f64,
}

/// Random points of a body's surface, as many on a square of the feathers' size everywhere.
struct Surface<'a> {
    ground: Ground<'a>,
    /// Felt area of the triangles up to and with each.
    areas: Vec<f64>,
}

impl<'a> Surface<'a> {
    fn new(ground: Ground<'a>) -> Self {
        let areas = (0..ground.body.triangles.len() as u32).scan(0.0, |sum, triangle| {
            let size = ground.size(triangle, [1.0 / 3.0; 3]);
            *sum += ground.body.area(triangle) / (size * size);
            Some(*sum)
        });
        Self { ground, areas: areas.collect() }
    }

    fn whole_area(&self) -> f64 {
        self.areas.last().copied().unwrap_or(0.0)
    }

    /// A random point; `None` where nothing grows.
    fn draw(&self, stream: &mut Stream) -> Option<Spot> {
        let at = stream.unit() * self.whole_area();
        let triangle = self.areas.partition_point(|&area| area <= at).min(self.areas.len() - 1);
        let (root, across) = (stream.unit().sqrt(), stream.unit());
        let weights = [1.0 - root, root * (1.0 - across), root * across];
        let body = self.ground.body;
        let is_within = self.ground.holds(body.point(triangle as u32, weights));
        is_within.then(|| body.spot(triangle as u32, weights))
    }
}

/// Area of the ground; that of a part of a body by points thrown at it.
#[must_use]
pub fn area(ground: Ground<'_>) -> Area {
    let surface = Surface::new(ground);
    let whole = surface.whole_area();
    if ground.region.is_none() && ground.bare.is_empty() && ground.field.is_none() {
        return Area { mm2: whole, felt_mm2: whole };
    }
    let mut stream = Stream::new(0, &[MEASURE]);
    let (mut within, mut squares) = (0_u32, 0.0);
    for spot in (0..THROWS).filter_map(|_| surface.draw(&mut stream)) {
        let size = ground.size(spot.triangle, spot.weights);
        (within, squares) = (within + 1, squares + size * size);
    }
    let share = |sum: f64| whole * sum / f64::from(THROWS);
    Area { mm2: share(squares), felt_mm2: share(f64::from(within)) }
}

/// Exactly `count` points of a ground of `area`, by removing from five times as many random ones again and again that
/// which has most others near it (sample elimination; Yuksel 2015, Computer Graphics Forum 34(2)); near is told in the feathers' size,
/// so that there are as many on its square everywhere.
///
/// # Errors
/// A ground that is next to none of the surface, or a stop by `progress`.
pub fn scattered(
    ground: Ground<'_>,
    area: Area,
    count: usize,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Vec<Spot>> {
    let surface = Surface::new(ground);
    let refuse = |share: f64| {
        Err(Error::input(format!(
            "coat.within_mm and coat.bare leave hardly any of the body's surface (about {:.3} %); give a box that holds {} % of it at least",
            100.0 * share,
            100.0 * LEAST_SHARE
        )))
    };
    // What is known of the area is uncertain; half of the least is certainly too little.
    let share = area.felt_mm2 / surface.whole_area();
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
    let sizes: Vec<f64> = spots.iter().map(|spot| ground.size(spot.triangle, spot.weights)).collect();
    let kept = eliminated((&spots, &sizes), area.felt_mm2, count, progress)?;
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
fn eliminated(
    (spots, sizes): (&[Spot], &[f64]),
    area: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Vec<bool>> {
    let reach = widest_spacing(area, count);
    // Yuksel's limit, by which no pair weighs much more than others: β = 0.65, γ = 1.5.
    let least = reach * (1.0 - libm::pow(count as f64 / spots.len() as f64, 1.5)) * 0.65;
    let pairs = neighbours((spots, sizes), reach, progress)?;
    let weight = |a: u32, b: u32| {
        let size = 0.5 * (sizes[a as usize] + sizes[b as usize]);
        let distance = (spots[a as usize].point - spots[b as usize].point).length() / size;
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

/// Of each point those that are nearer than `reach`, times the mean of their sizes, on the same side of the body. Sizes are looked through
/// by octaves: the smaller one of two looks for the larger one in cubes as large as that asks for, so that small ones never meet a
/// crowd.
///
/// # Errors
/// A stop by `progress`.
fn neighbours(
    (spots, sizes): (&[Spot], &[f64]),
    reach: f64,
    progress: &dyn Progress,
) -> Result<Vec<Vec<u32>>> {
    let octave = |size: f64| libm::floor(libm::log2(size)) as i32;
    let mut members: BTreeMap<i32, (Vec<u32>, f64)> = BTreeMap::new();
    for (index, &size) in (0_u32..).zip(sizes) {
        let (own, largest) = members.entry(octave(size)).or_default();
        own.push(index);
        *largest = largest.max(size);
    }
    let grids: Vec<(i32, Near)> = members
        .into_iter()
        .map(|(octave, (own, largest))| {
            let points = own.iter().map(|&index| (index, spots[index as usize].point));
            (octave, Near::of(points, reach * largest))
        })
        .collect();
    let of = |(a, spot): (u32, &Spot)| {
        go_on(progress)?;
        let own = octave(sizes[a as usize]);
        let (mut alike, mut larger) = (Vec::new(), Vec::new());
        for (octave, near) in grids.iter().filter(|(octave, _)| *octave >= own) {
            near.visit(spot.point, |b| {
                let other = &spots[b as usize];
                let within = reach * 0.5 * (sizes[a as usize] + sizes[b as usize]);
                let is_near = (other.point - spot.point).length_squared() < within * within;
                if a != b && is_near && other.normal.dot(spot.normal) > 0.0 {
                    if *octave == own { alike.push(b) } else { larger.push(b) }
                }
            });
        }
        Ok((alike, larger))
    };
    let found: Vec<(Vec<u32>, Vec<u32>)> =
        (0..spots.len() as u32).into_par_iter().zip(spots).map(of).collect::<Result<_>>()?;
    let (mut all, larger): (Vec<Vec<u32>>, Vec<Vec<u32>>) = found.into_iter().unzip();
    for (a, larger) in (0_u32..).zip(larger) {
        for &b in &larger {
            all[b as usize].push(a);
        }
        all[a as usize].extend(larger);
    }
    Ok(all)
}

/// Points in cubes of a size, to be found again.
pub(super) struct Near {
    cells: HashMap<I64Vec3, Vec<u32>>,
    size: f64,
}

impl Near {
    /// Points by their number, in cubes of this size.
    pub(super) fn new(points: impl Iterator<Item = DVec3>, size: f64) -> Self {
        Self::of((0_u32..).zip(points), size)
    }

    fn of(points: impl Iterator<Item = (u32, DVec3)>, size: f64) -> Self {
        let mut cells: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
        for (index, point) in points {
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
    use crate::scene::coat::field::Guide;
    use crate::scene::geometry::Place;

    fn ground(body: &Body) -> Ground<'_> {
        Ground { body, region: None, bare: &[], field: None }
    }

    /// Feathers of a third of the size on one side: nine times as many there, none in a bare place, and nowhere a gap wider than the
    /// local spacing; the same on any number of threads.
    #[test]
    fn density_goes_with_the_square_of_the_size() {
        let body = Body::ellipsoid([30.0, 50.0, 30.0], &Place::HERE, 1.5);
        let guide = |y: f64, size: f64| Guide { position_mm: [0.0, y, 0.0], size, ..Guide::PLAIN };
        let guides = [guide(50.0, 1.0 / 3.0), guide(-50.0, 1.0)];
        // Both hold as far as the middle, where sizes change within an edge.
        let field = Field::new(&body, &guides, (300.0, 8.0), &Unobserved).unwrap();
        let bare = [Bare { position_mm: [30.0, 0.0, 0.0], radius_mm: 9.0 }];
        let ground = Ground { bare: &bare, field: Some(&field), ..ground(&body) };
        let found = area(ground);
        let whole = area(super::tests::ground(&body)).mm2;
        // Of the sphere's cap of 9 mm about a pole π 81 mm².
        assert!((found.mm2 / (whole - PI * 81.0) - 1.0).abs() < 0.02, "{found:?} {whole}");
        assert!((found.felt_mm2 / found.mm2 / 5.0 - 1.0).abs() < 0.03, "{found:?}");
        let scatter = || scattered(ground, found, 2500, 3, &Unobserved).unwrap();
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let spots = scatter();
        assert_eq!(spots, one.install(scatter));
        let middle = DVec3::from(bare[0].position_mm);
        assert!(spots.iter().all(|spot| (spot.point - middle).length() >= 9.0));
        // Far from where the sizes change and from the bare place, on both sides alike.
        let count = |sign: f64| spots.iter().filter(|spot| sign * spot.point.y > 12.0).count() as f64;
        let ratio = count(1.0) / count(-1.0);
        assert!((ratio / 9.0 - 1.0).abs() < 0.1, "{ratio}");
        let widest = widest_spacing(found.felt_mm2, 2500);
        let surface = Surface::new(ground);
        let mut stream = Stream::new(9, &[]);
        let hole = (0..4000).filter_map(|_| surface.draw(&mut stream)).map(|from| {
            let size = ground.size(from.triangle, from.weights);
            spots.iter().map(|spot| (spot.point - from.point).length() / size).fold(f64::MAX, f64::min)
        });
        let hole = hole.fold(0.0, f64::max) / widest;
        assert!(hole < 1.25, "{hole}");
    }

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
        let ground = ground(&body);
        let whole = area(ground);
        for count in [1, 7, 600] {
            assert_eq!(scattered(ground, whole, count, 3, &Unobserved).unwrap().len(), count);
        }
        let spots = scattered(ground, whole, 600, 3, &Unobserved).unwrap();
        let widest = widest_spacing(whole.mm2, 600);
        let apart = nearest(&spots);
        let least = apart.iter().fold(f64::MAX, |a, b| a.min(*b)) / widest;
        let mean = apart.iter().sum::<f64>() / 600.0 / widest;
        assert!(least > 0.6 && mean > 0.75, "{least} {mean}");
        let surface = Surface::new(ground);
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
        let upper = Ground { region: Some(half), ..ground(&body) };
        let found = area(upper);
        assert!((found.mm2 / (2.0 * PI * 400.0) - 1.0).abs() < 0.02, "{found:?}");
        let spots = scattered(upper, found, 100, 1, &Unobserved).unwrap();
        assert!(spots.len() == 100 && spots.iter().all(|spot| spot.point.z >= 0.0));
        let beside = Region { low: [30.0; 3], high: [40.0; 3] };
        let nowhere = Ground { region: Some(beside), ..upper };
        assert_eq!(area(nowhere), Area { mm2: 0.0, felt_mm2: 0.0 });
        let refused = scattered(nowhere, area(nowhere), 10, 1, &Unobserved).unwrap_err().to_string();
        assert!(refused.starts_with("coat.within_mm and coat.bare leave hardly any"), "{refused}");
        // What holds far too little is known before any of 250 million points is thrown.
        let (whole, watched) = (area(ground(&body)).mm2, Shared::default());
        let little = Area { mm2: 4e-4 * whole, felt_mm2: 4e-4 * whole };
        let refused = scattered(upper, little, 50_000, 1, &watched).unwrap_err().to_string();
        assert!(refused.contains("(about 0.040 %); give a box that holds 0.1 % of it at least"), "{refused}");
        assert_eq!(watched.snapshot().stage, 0);
    }
}
