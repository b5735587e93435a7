//! A feather's vane as a few hundred points: what others must not sink into.

use glam::DVec3;

use super::body::Body;
use super::follicles::Near;
use super::{Stand, window};
use crate::Result;
use crate::math::rng::hash;
use crate::progress::Progress;
use crate::scene::feather::{Barb, Feather};

/// Stations along the shaft whose points must be free, as shares of its length (Chen et al. 2002 have five points).
const STATIONS: [f64; 5] = [0.3, 0.5, 0.7, 0.85, 0.98];
/// On the barbs there, as shares of their length.
const ON_BARBS: [f64; 2] = [0.5, 0.92];
/// Points by which a coat is measured: every so many.
const MEASURED: usize = 5;
/// Beyond this length of the line, over the feather's, nothing lies on it.
const HIGHEST: f64 = 0.3;

/// Points of a feather, in its own place: the origin is its follicle.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// On the shaft and the vane, as dense as the cells that they are counted in.
    pub(super) surface: Vec<DVec3>,
    /// Those that must be free.
    pub(super) tests: Vec<DVec3>,
    /// The vane between barbs.
    triangles: Vec<[DVec3; 3]>,
    low: DVec3,
    high: DVec3,
}

impl Shape {
    /// The shape of the feather that grows from a seed as those of scenes do; `step_mm`: distance of its points.
    ///
    /// # Errors
    /// A feather out of range, or a stop by `progress`.
    pub(super) fn new(feather: &Feather, seed: u64, step_mm: f64, progress: &dyn Progress) -> Result<Self> {
        let window = window(feather);
        let (shaft, barbs) = feather.barbs_within(window, (seed, hash(seed, &[1])), progress)?;
        let origin = shaft.at(window.along_mm).point;
        let length = feather.shaft.length_mm;
        let steps = (length / step_mm).ceil() as u32;
        let on_shaft = |share: f64| shaft.at(share * length).point - origin;
        let from = feather.shaft.calamus;
        let mut surface: Vec<DVec3> =
            (0..=steps).map(|i| on_shaft(from + (1.0 - from) * f64::from(i) / f64::from(steps))).collect();
        let mut tests: Vec<DVec3> = STATIONS.map(on_shaft).to_vec();
        let mut triangles = Vec::new();
        for side in [-1.0, 1.0] {
            let vane: Vec<&Barb> = barbs.iter().filter(|b| b.side == side && !b.is_loose).collect();
            for share in STATIONS {
                let far = |barb: &&&Barb| (barb.along_mm - share * length).abs();
                if let Some(barb) = vane.iter().min_by(|a, b| far(a).total_cmp(&far(b))) {
                    let last = (barb.points.len() - 1) as f64;
                    tests.extend(ON_BARBS.map(|at| barb.points[(at * last).round() as usize] - origin));
                }
            }
            let rows = rows(&vane, step_mm, origin);
            for pair in rows.windows(2) {
                triangles.extend((1..pair[0].len()).flat_map(|i| {
                    let [a, b, c, d] = [pair[0][i - 1], pair[0][i], pair[1][i - 1], pair[1][i]];
                    [[a, b, c], [c, b, d]]
                }));
            }
            surface.extend(rows.into_iter().flatten());
        }
        let low = surface.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
        let high = surface.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
        Ok(Self { surface, tests, triangles, low, high })
    }

    /// Whether a line from a point meets the vane within a length.
    fn is_met(&self, from: DVec3, along: DVec3, length: f64) -> bool {
        let (a, b) = (from, from + along * length);
        if a.max(b).cmplt(self.low).any() || a.min(b).cmpgt(self.high).any() {
            return false;
        }
        self.triangles.iter().any(|&[p, q, r]| {
            // Möller & Trumbore 1997.
            let (to_q, to_r) = (q - p, r - p);
            let across = along.cross(to_r);
            let volume = across.dot(to_q);
            let off = from - p;
            let u = off.dot(across) / volume;
            if !(0.0..=1.0).contains(&u) {
                return false;
            }
            let turned = off.cross(to_q);
            let (v, t) = (along.dot(turned) / volume, to_r.dot(turned) / volume);
            v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < length
        })
    }
}

/// Points of barbs that stand `step_mm` apart, as many on each.
fn rows(vane: &[&Barb], step_mm: f64, origin: DVec3) -> Vec<Vec<DVec3>> {
    let longest = vane.iter().map(|barb| barb.length_mm).fold(0.0, f64::max);
    let columns = ((longest / step_mm).ceil() as usize).clamp(1, 24);
    let mut last = f64::NEG_INFINITY;
    let mut rows = Vec::new();
    for (index, barb) in vane.iter().enumerate() {
        if barb.along_mm - last < step_mm && index + 1 < vane.len() {
            continue;
        }
        last = barb.along_mm;
        let steps = barb.points.len() - 1;
        rows.push((0..=columns).map(|i| barb.points[i * steps / columns] - origin).collect());
    }
    rows
}

/// Share of the feathers' points from which a line away from the body meets a feather that lies beneath, or that are in the
/// body.
pub(super) fn buried(body: &Body, stands: &[Stand], order: &[u32], shapes: &[Shape]) -> f64 {
    let mut rank = vec![0; stands.len()];
    (0_u32..).zip(order).for_each(|(place, &index)| rank[index as usize] = place);
    let reach = |shape: &Shape| shape.low.abs().max(shape.high.abs()).length();
    let longest = shapes.iter().map(reach).fold(0.0, f64::max);
    let largest = stands.iter().map(|stand| stand.scale).fold(0.0, f64::max);
    let near = Near::new(stands.iter().map(|stand| stand.spot.point), 2.0 * longest * largest);
    let places: Vec<_> = stands.iter().map(|stand| stand.place(0)).collect();
    let (mut points, mut under) = (0_usize, 0_usize);
    for (index, stand) in stands.iter().enumerate() {
        let mut beneath = Vec::new();
        near.visit(stand.spot.point, |other| {
            if rank[other as usize] < rank[index] {
                beneath.push(other as usize);
            }
        });
        let mut start = body.triangles[stand.spot.triangle as usize][0];
        for point in shapes[stand.variant].surface.iter().skip(index % MEASURED).step_by(MEASURED) {
            let at = places[index].point(*point);
            let foot = body.foot(at, start);
            start = body.triangles[foot.triangle as usize][0];
            points += 1;
            let is_in_body = (at - foot.point).dot(foot.normal) < 0.0;
            let is_under = |other: &usize| {
                let (place, shape) = (&places[*other], &shapes[stands[*other].variant]);
                let from = place.point_back(at);
                shape.is_met(from, place.direction_back(foot.normal), HIGHEST * longest)
            };
            under += usize::from(is_in_body || beneath.iter().any(is_under));
        }
    }
    under as f64 / points.max(1) as f64
}
