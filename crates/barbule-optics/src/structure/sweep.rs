//! Crossings and containment of many loops in O(n log n) with exact arithmetic.
//!
//! Shamos and Hoey's sweep (1976): segments are kept in the order in which a line moving along x meets them, and only
//! neighbours can be the first to cross. Coordinates are rounded to 2⁻³⁶ µm (1.5e-11 µm), so that every predicate is
//! exact in integers: 1000 µm is 2⁴⁶ units and a product of differences fits in 128 bits with room.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Bound;

use super::section::Polyline;

const UNITS_PER_UM: f64 = (1_u64 << 36) as f64;

/// Whose segment it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Owner {
    Boundary(usize),
    Loop(usize),
}

/// Two segments that must not meet and do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Conflict {
    pub(super) a: Owner,
    pub(super) b: Owner,
    pub(super) x_um: f64,
    pub(super) z_um: f64,
}

type Point = (i64, i64);

/// A segment from its lexicographically smaller end to the other.
#[derive(Debug, Clone, Copy)]
struct Segment {
    left: Point,
    right: Point,
    owner: Owner,
    /// Place along its curve, and how many segments the curve has.
    place: u32,
    of: u32,
    /// Whether the curve runs from left to right here.
    forward: bool,
    id: u32,
}

fn orientation(a: Point, b: Point, c: Point) -> i128 {
    let product = |p: i64, q: i64| i128::from(p) * i128::from(q);
    product(b.0 - a.0, c.1 - a.1) - product(b.1 - a.1, c.0 - a.0)
}

impl Segment {
    /// Whether two segments follow each other on one curve.
    fn adjoins(&self, other: &Self) -> bool {
        self.owner == other.owner
            && (self.place.abs_diff(other.place) == 1 || self.place.abs_diff(other.place) + 1 == self.of)
    }

    /// Whether they share a point that they may not share.
    fn conflicts(&self, other: &Self) -> bool {
        if matches!((self.owner, other.owner), (Owner::Boundary(_), Owner::Boundary(_)))
            || self.adjoins(other)
        {
            return false;
        }
        let (a, b, c, d) = (self.left, self.right, other.left, other.right);
        let (abc, abd) = (orientation(a, b, c).signum(), orientation(a, b, d).signum());
        let (cda, cdb) = (orientation(c, d, a).signum(), orientation(c, d, b).signum());
        if abc == 0 && abd == 0 {
            // On one line: the ends are in lexicographic order.
            return a.max(c) <= b.min(d);
        }
        abc * abd <= 0 && cda * cdb <= 0
    }

    fn meeting(&self, other: &Self) -> Conflict {
        let um = |p: Point| (p.0 as f64 / UNITS_PER_UM, p.1 as f64 / UNITS_PER_UM);
        let ((ax, az), (bx, bz)) = (um(self.left), um(self.right));
        let ((cx, cz), (dx, dz)) = (um(other.left), um(other.right));
        let determinant = (bx - ax) * (dz - cz) - (bz - az) * (dx - cx);
        let (x_um, z_um) = if determinant == 0.0 {
            um(self.left.max(other.left))
        } else {
            let t = (((cx - ax) * (dz - cz) - (cz - az) * (dx - cx)) / determinant).clamp(0.0, 1.0);
            (ax + t * (bx - ax), az + t * (bz - az))
        };
        Conflict { a: self.owner, b: other.owner, x_um, z_um }
    }
}

/// From the bottom up, where both are met by the sweeping line.
impl Ord for Segment {
    fn cmp(&self, other: &Self) -> Ordering {
        if self.id == other.id {
            return Ordering::Equal;
        }
        if let (Owner::Boundary(a), Owner::Boundary(b)) = (self.owner, other.owner) {
            // Boundaries are in order already, and may touch.
            return b.cmp(&a).then(self.id.cmp(&other.id));
        }
        let side = |base: &Self, of: &Self| {
            let first = orientation(base.left, base.right, of.left);
            if first == 0 { orientation(base.left, base.right, of.right) } else { first }
        };
        let order =
            if self.left <= other.left { 0.cmp(&side(self, other)) } else { side(other, self).cmp(&0) };
        order.then(self.id.cmp(&other.id))
    }
}

impl PartialOrd for Segment {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Segment {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for Segment {}

fn rounded(curve: &Polyline) -> Vec<Point> {
    let unit = |v: f64| (v * UNITS_PER_UM).round() as i64;
    let mut points: Vec<Point> =
        curve.x_um.iter().zip(&curve.z_um).map(|(&x, &z)| (unit(x), unit(z))).collect();
    points.dedup();
    points
}

fn push(segments: &mut Vec<Segment>, from: Point, to: Point, owner: Owner, place: usize, of: usize) {
    let forward = from < to;
    let (left, right) = if forward { (from, to) } else { (to, from) };
    let id = segments.len() as u32;
    segments.push(Segment { left, right, owner, place: place as u32, of: of as u32, forward, id });
}

/// Which loop lies directly in which (`None`: in no loop), or the first conflict from the left.
///
/// Boundaries must be in order from the top down (they may touch); loops of one point or a line are conflicts.
pub(super) fn nesting(boundaries: &[Polyline], loops: &[Polyline]) -> Result<Vec<Option<usize>>, Conflict> {
    let mut segments = Vec::new();
    for (index, boundary) in boundaries.iter().enumerate() {
        let points = rounded(boundary);
        for (place, pair) in points.windows(2).enumerate() {
            // Boundaries may follow the one before: no wrap, so more segments than there are.
            push(&mut segments, pair[0], pair[1], Owner::Boundary(index), place, points.len() + 1);
        }
    }
    let mut counterclockwise = Vec::with_capacity(loops.len());
    for (index, shape) in loops.iter().enumerate() {
        counterclockwise.push(add_loop(&mut segments, shape, index)?);
    }
    let mut events: Vec<(Point, bool, u32)> = Vec::with_capacity(2 * segments.len());
    for segment in &segments {
        // `false` before `true`: at one point segments begin before others end, so that touching is seen.
        events.push((segment.left, false, segment.id));
        events.push((segment.right, true, segment.id));
    }
    events.sort_unstable();
    let mut active: BTreeSet<Segment> = BTreeSet::new();
    let mut parents: Vec<Option<usize>> = vec![None; loops.len()];
    let mut seen = vec![false; loops.len()];
    for (_, ends, id) in events {
        let segment = segments[id as usize];
        let (below, above) = neighbours(&active, &segment);
        if ends {
            active.remove(&segment);
            if let (Some(a), Some(b)) = (below, above)
                && a.conflicts(&b)
            {
                return Err(a.meeting(&b));
            }
            continue;
        }
        for near in [below, above].into_iter().flatten() {
            if near.conflicts(&segment) {
                return Err(near.meeting(&segment));
            }
        }
        if let Owner::Loop(index) = segment.owner
            && !std::mem::replace(&mut seen[index], true)
            && let Some(Segment { owner: Owner::Loop(other), forward, .. }) = below
        {
            // A counterclockwise loop has its inside on the left of its run, which is above where it runs right.
            let inside = forward == counterclockwise[other];
            parents[index] = if inside { Some(other) } else { parents[other] };
        }
        active.insert(segment);
    }
    Ok(parents)
}

fn neighbours(active: &BTreeSet<Segment>, segment: &Segment) -> (Option<Segment>, Option<Segment>) {
    let below = active.range((Bound::Unbounded, Bound::Excluded(*segment))).next_back().copied();
    let above = active.range((Bound::Excluded(*segment), Bound::Unbounded)).next().copied();
    (below, above)
}

/// Adds a loop's segments; returns whether it runs counterclockwise.
fn add_loop(segments: &mut Vec<Segment>, shape: &Polyline, index: usize) -> Result<bool, Conflict> {
    let mut points = rounded(shape);
    if points.len() > 1 && points[0] == points[points.len() - 1] {
        points.pop();
    }
    let count = points.len();
    let degenerate = |p: Point| Conflict {
        a: Owner::Loop(index),
        b: Owner::Loop(index),
        x_um: p.0 as f64 / UNITS_PER_UM,
        z_um: p.1 as f64 / UNITS_PER_UM,
    };
    if count < 3 {
        return Err(degenerate(points[0]));
    }
    let mut area = 0_i128;
    for place in 0..count {
        let (p, q, r) = (points[place], points[(place + 1) % count], points[(place + 2) % count]);
        area += i128::from(p.0) * i128::from(q.1) - i128::from(p.1) * i128::from(q.0);
        let dot =
            i128::from(p.0 - q.0) * i128::from(r.0 - q.0) + i128::from(p.1 - q.1) * i128::from(r.1 - q.1);
        if orientation(p, q, r) == 0 && dot > 0 {
            // A spike: the outline runs back on itself.
            return Err(degenerate(q));
        }
        push(segments, p, q, Owner::Loop(index), place, count);
    }
    Ok(area > 0)
}
