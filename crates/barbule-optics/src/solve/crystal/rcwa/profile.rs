//! From outlines of rods to slices with vertical walls.
//!
//! A slice is a piecewise constant permittivity along x; the width of each outline in it is the mean over the slice's
//! depth (circles and ellipses, exactly) or that at its middle (polygons; the mean where edges do not end in the
//! slice), so the area of the cross section is kept and the staircase errs in the second order.

use std::f64::consts::PI;

use crate::Complex64;
use crate::solve::crystal::Cell;

/// Depths nearer than this, µm, are one.
const SAME_DEPTH_UM: f64 = 1e-9;
/// Places along x nearer than this, of the period, are one.
const SAME_PLACE: f64 = 1e-12;

/// The outline of a body in the x–z plane.
#[derive(Debug, Clone)]
pub enum Outline {
    /// An upright ellipse about the origin; a circle where both are the same.
    Ellipse {
        /// Full width along x, µm.
        width_um: f64,
        /// Full height along z, µm.
        height_um: f64,
    },
    /// A closed polygon of points (x, depth), µm, relative to the body's origin; by the even–odd rule.
    Polygon(Vec<[f64; 2]>),
}

/// A body of one permittivity; later bodies replace earlier ones where they overlap.
#[derive(Debug, Clone)]
pub struct Body {
    /// Position of the origin of the outline, µm.
    pub x_um: f64,
    /// Its depth below the surface, µm.
    pub depth_um: f64,
    /// The shape.
    pub outline: Outline,
    /// Relative permittivity.
    pub eps: Complex64,
}

/// The rods of a cell as bodies: every shell a circle, outer ones first.
#[must_use]
pub fn bodies(cell: &Cell) -> Vec<Body> {
    let circle = |rod: &crate::solve::crystal::CellRod, shell: &crate::solve::crystal::Shell| Body {
        x_um: rod.x_um,
        depth_um: rod.depth_um,
        outline: Outline::Ellipse { width_um: shell.diameter_um, height_um: shell.diameter_um },
        eps: shell.eps,
    };
    cell.rods.iter().flat_map(|rod| rod.shells.iter().map(move |shell| circle(rod, shell))).collect()
}

impl Outline {
    /// Least and greatest depth relative to the origin, µm.
    pub fn extent(&self) -> (f64, f64) {
        match self {
            Self::Ellipse { height_um, .. } => (-height_um / 2.0, height_um / 2.0),
            Self::Polygon(points) => points
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[1]), high.max(p[1]))),
        }
    }

    /// Depths relative to the origin at which slices end, of about `slices` slices.
    ///
    /// Those of an ellipse are even in angle: narrow where its width changes fast. Those of a polygon are its turning
    /// points and level edges, and even steps between where an edge slants.
    fn cuts(&self, slices: usize) -> Vec<f64> {
        match self {
            Self::Ellipse { height_um, .. } => {
                let angle = PI / slices as f64;
                (0..=slices).map(|i| -height_um / 2.0 * (angle * i as f64).cos()).collect()
            }
            Self::Polygon(points) => polygon_cuts(points, slices),
        }
    }

    /// Spans along x relative to the origin, µm, that stand for the outline between two depths.
    fn spans(&self, from: f64, to: f64) -> Vec<(f64, f64)> {
        match self {
            Self::Ellipse { width_um, height_um } => {
                let radius = height_um / 2.0;
                let area = |z: f64| {
                    let u = (z / radius).clamp(-1.0, 1.0);
                    u * (1.0 - u * u).sqrt() + u.asin()
                };
                let half = width_um / 4.0 * radius * (area(to) - area(from)) / (to - from);
                if half > 0.0 { vec![(-half, half)] } else { Vec::new() }
            }
            Self::Polygon(points) => {
                let z = (from + to) / 2.0;
                let mut crossings: Vec<f64> = edges(points)
                    .filter(|(p, q)| (p[1] <= z) != (q[1] <= z))
                    .map(|(p, q)| p[0] + (z - p[1]) / (q[1] - p[1]) * (q[0] - p[0]))
                    .collect();
                crossings.sort_by(f64::total_cmp);
                crossings.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect()
            }
        }
    }
}

fn edges(points: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    (0..points.len()).map(|i| (points[i], points[(i + 1) % points.len()]))
}

fn polygon_cuts(points: &[[f64; 2]], slices: usize) -> Vec<f64> {
    let count = points.len();
    let mut turns: Vec<f64> = (0..count)
        .filter(|&i| {
            let (before, here, after) = (points[(i + count - 1) % count], points[i], points[(i + 1) % count]);
            (here[1] - before[1]) * (after[1] - here[1]) <= 0.0
        })
        .map(|i| points[i][1])
        .collect();
    turns.sort_by(f64::total_cmp);
    turns.dedup_by(|a, b| (*a - *b).abs() < SAME_DEPTH_UM);
    let Some((&top, &bottom)) = turns.first().zip(turns.last()) else { return turns };
    let mut cuts = turns.clone();
    for pair in turns.windows(2) {
        let slants = edges(points).any(|(p, q)| {
            p[0] != q[0]
                && p[1].min(q[1]) < pair[1] - SAME_DEPTH_UM
                && p[1].max(q[1]) > pair[0] + SAME_DEPTH_UM
        });
        if slants {
            let steps = ((pair[1] - pair[0]) / (bottom - top) * slices as f64).ceil().max(1.0) as usize;
            cuts.extend((1..steps).map(|i| pair[0] + (pair[1] - pair[0]) * i as f64 / steps as f64));
        }
    }
    cuts
}

/// Permittivity along one period: pieces (length of the period, ε), the first of which begins at `shift`.
#[derive(Debug, Clone)]
pub struct Slice {
    /// How thick it is.
    pub thickness_um: f64,
    /// Length (of the period) and permittivity of each piece.
    pub pieces: Vec<(f64, Complex64)>,
    /// Where the first piece begins, of the period.
    pub shift: f64,
}

impl Slice {
    /// What two slices share that differ in position alone, rounded.
    pub fn key(&self) -> (i64, Vec<[i64; 3]>) {
        ((self.thickness_um * 1e10).round() as i64, self.pieces.iter().map(piece_key).collect())
    }

    /// Whether one permittivity fills it.
    pub fn is_uniform(&self, eps: Complex64) -> bool {
        self.pieces.len() == 1 && self.pieces[0].1 == eps
    }
}

fn piece_key(piece: &(f64, Complex64)) -> [i64; 3] {
    [piece.0 * 1e10, piece.1.re * 1e12, piece.1.im * 1e12].map(|value| value.round() as i64)
}

/// The slices from the highest outline's upper edge (returned as a depth, µm) to the lowest one's lower edge.
pub fn slices(bodies: &[Body], period_um: f64, host_eps: Complex64, per_rod: usize) -> (f64, Vec<Slice>) {
    let height = |body: &Body| {
        let (top, bottom) = body.outline.extent();
        bottom - top
    };
    let greatest = bodies.iter().map(height).fold(0.0, f64::max);
    let mut cuts: Vec<f64> = bodies
        .iter()
        .flat_map(|body| {
            // Smaller outlines get their share, an even number that keeps their symmetry.
            let share = height(body) / greatest * per_rod as f64 / 2.0;
            let count = 2 * (share.round().max(1.0) as usize);
            body.outline.cuts(count).into_iter().map(|z| body.depth_um + z)
        })
        .collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| (*a - *b).abs() < SAME_DEPTH_UM);
    let mut slices: Vec<Slice> = Vec::new();
    for pair in cuts.windows(2) {
        let slice = slice_between(bodies, period_um, host_eps, pair[0], pair[1]);
        match slices.last_mut() {
            Some(last) if last.key().1 == slice.key().1 && (last.shift - slice.shift).abs() < SAME_PLACE => {
                last.thickness_um += slice.thickness_um;
            }
            _ => slices.push(slice),
        }
    }
    (cuts.first().copied().unwrap_or(0.0), slices)
}

fn slice_between(bodies: &[Body], period_um: f64, host_eps: Complex64, top: f64, bottom: f64) -> Slice {
    // Spans of the period, begin in [0, 1), length at most 1.
    let mut spans: Vec<(f64, f64, Complex64)> = Vec::new();
    for body in bodies {
        let (low, high) = body.outline.extent();
        let middle = (top + bottom) / 2.0 - body.depth_um;
        if middle <= low || middle >= high {
            continue;
        }
        for (x0, x1) in body.outline.spans(top - body.depth_um, bottom - body.depth_um) {
            let begin = ((body.x_um + x0) / period_um).rem_euclid(1.0);
            spans.push((begin, ((x1 - x0) / period_um).min(1.0), body.eps));
        }
    }
    let mut edges: Vec<f64> =
        spans.iter().flat_map(|&(begin, length, _)| [begin, (begin + length).rem_euclid(1.0)]).collect();
    edges.sort_by(f64::total_cmp);
    edges.dedup_by(|a, b| (*a - *b).abs() < SAME_PLACE);
    let at = |x: f64| {
        let inside = |&&(begin, length, _): &&(f64, f64, Complex64)| (x - begin).rem_euclid(1.0) < length;
        spans.iter().rev().find(inside).map_or(host_eps, |span| span.2)
    };
    // (begin, length, ε), neighbours of the same ε joined across the wrap too.
    let mut pieces: Vec<(f64, f64, Complex64)> = Vec::new();
    for (i, &begin) in edges.iter().enumerate() {
        let end = if i + 1 < edges.len() { edges[i + 1] } else { edges[0] + 1.0 };
        let eps = at(((begin + end) / 2.0).rem_euclid(1.0));
        match pieces.last_mut() {
            Some(last) if last.2 == eps => last.1 += end - begin,
            _ => pieces.push((begin, end - begin, eps)),
        }
    }
    if pieces.len() > 1 && pieces[0].2 == pieces[pieces.len() - 1].2 {
        let last = pieces.remove(pieces.len() - 1);
        pieces[0] = (last.0, pieces[0].1 + last.1, last.2);
    }
    if pieces.len() <= 1 {
        let eps = pieces.first().map_or(host_eps, |piece| piece.2);
        return Slice { thickness_um: bottom - top, pieces: vec![(1.0, eps)], shift: 0.0 };
    }
    canonical(bottom - top, &pieces)
}

/// Rotates the period so that slices that differ in position alone have the same pieces.
fn canonical(thickness_um: f64, pieces: &[(f64, f64, Complex64)]) -> Slice {
    let rotation = |start: usize| {
        (0..pieces.len()).map(move |i| pieces[(start + i) % pieces.len()]).map(|piece| (piece.1, piece.2))
    };
    let key = |start: &usize| rotation(*start).map(|piece| piece_key(&piece)).collect::<Vec<_>>();
    let start = (0..pieces.len()).min_by_key(key).unwrap_or(0);
    Slice { thickness_um, pieces: rotation(start).collect(), shift: pieces[start].0 }
}
