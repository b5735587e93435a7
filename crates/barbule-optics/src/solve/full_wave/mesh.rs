//! Boundaries as panels with nodes.

use std::f64::consts::TAU;

use super::shape::{Point, Shape};
use crate::math::quadrature::gauss_legendre;
use crate::math::spline::Spline;
use crate::structure::{Contour, Loop, Medium, Polyline, Section};
use crate::{Complex64, Error, Result};

/// Most nodes of one panel.
pub(super) const MOST_NODES: usize = 8;

/// Least nodes of a panel, and of one on a circle.
const LEAST_NODES: usize = 2;
const LEAST_ARC_NODES: usize = 5;

/// Least panels of a circle.
const LEAST_ARCS: usize = 3;

/// No mesh has many more panels than this.
const MOST_PANELS: usize = 1_000_000;

/// A panel is at most so many times longer than its distance to another boundary.
const LENGTH_PER_GAP: f64 = 2.0;

/// Panels are not made shorter than this for the sake of gaps, µm.
const SHORTEST_UM: f64 = 2e-4;

/// Corners are samples of a smooth curve where they turn by less than this, between edges of like length …
const SMOOTH_RAD: f64 = 0.3;
const LIKE_LENGTHS: f64 = 3.0;

/// … or turn by less than this and leave the curve by less than so many µm: the height of an arc over its chord.
const FINE_RAD: f64 = 0.8;
const FINE_SAGITTA_UM: f64 = 1e-3;

/// Corners closer to the one before are left out, µm.
const SAME_UM: f64 = 2e-4;

/// Most of its way that a smooth panel turns, rad.
const TURN_OF_PANEL: f64 = 1.2;

/// Least nodes of a smooth panel.
const LEAST_SMOOTH_NODES: usize = 4;

/// At corners that turn by more than this fields are singular: the nodes of their panels, at least so many, crowd to them.
const SHARP_RAD: f64 = 0.6;
const NODES_AT_CORNERS: usize = 6;
const NODES_AT_FINE_CORNERS: usize = 5;

/// How long such a panel is at most, in distances of nodes elsewhere.
const CORNER_LENGTH: f64 = 4.0;

/// A closed curve between two regions; its normal leads out of the inner one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Boundary {
    /// The region around it.
    pub(super) outside: usize,
    /// The region in it.
    pub(super) inside: usize,
}

/// A piece of a boundary with the nodes of a Gauss–Legendre rule.
#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    pub(super) shape: Shape,
    pub(super) boundary: usize,
    /// Its first node.
    pub(super) first: usize,
    /// How many it has.
    pub(super) nodes: usize,
    pub(super) length_um: f64,
}

/// A node of a panel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) point: Point,
    pub(super) boundary: usize,
    /// Its part of the boundary's length, µm.
    pub(super) weight_um: f64,
}

/// All boundaries of a section as panels, and the indices of the regions: number 0 is the outside.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    pub(super) boundaries: Vec<Boundary>,
    pub(super) panels: Vec<Panel>,
    pub(super) nodes: Vec<Node>,
    /// Complex index of each region.
    pub(super) indices: Vec<Complex64>,
}

impl Mesh {
    /// Panels so short that each wavelength in the denser medium has so many nodes.
    ///
    /// # Errors
    /// Open boundaries or a crystal, media that vary inside a region, circles that touch other curves, or an index that is
    /// not known at the wavelength.
    pub(super) fn new(section: &Section, wavelength_nm: f64, elements_per_wavelength: f64) -> Result<Self> {
        if !section.boundaries.is_empty() || section.crystal.is_some() {
            return Err(Error::input(
                "full waves are computed for sections of closed regions; close this section first",
            ));
        }
        section.check_lit_through_air()?;
        let contours = section.contours();
        check_circles(&contours)?;
        let mut indices = vec![index(section, &section.media[0], wavelength_nm, "media[0]")?];
        for contour in &contours {
            indices.push(index(section, contour.medium, wavelength_nm, &contour.place)?);
        }
        let boundaries: Vec<Boundary> = contours
            .iter()
            .enumerate()
            .map(|(l, contour)| Boundary { outside: contour.parent.map_or(0, |p| p + 1), inside: l + 1 })
            .collect();
        let mut pieces = Vec::new();
        for (l, (contour, boundary)) in contours.iter().zip(&boundaries).enumerate() {
            let n = indices[boundary.outside].norm().max(indices[boundary.inside].norm());
            let density_um = elements_per_wavelength * n / (wavelength_nm * 1e-3);
            pieces.extend(
                outline(contour.outline, density_um).into_iter().map(|piece| Piece { boundary: l, ..piece }),
            );
        }
        let pieces = resolve_gaps(pieces)?;
        let mut mesh =
            Self { boundaries, panels: Vec::with_capacity(pieces.len()), nodes: Vec::new(), indices };
        let rules: Vec<Vec<(f64, f64)>> = (0..=MOST_NODES).map(gauss_legendre).collect();
        for piece in pieces {
            mesh.push(&piece, &rules[piece.nodes]);
        }
        Ok(mesh)
    }

    fn push(&mut self, piece: &Piece, rule: &[(f64, f64)]) {
        let length_um = piece.shape.length_um();
        self.panels.push(Panel {
            shape: piece.shape,
            boundary: piece.boundary,
            first: self.nodes.len(),
            nodes: piece.nodes,
            length_um,
        });
        self.nodes.extend(rule.iter().map(|&(t, weight)| Node {
            point: piece.shape.point(2.0 * t - 1.0),
            boundary: piece.boundary,
            weight_um: 2.0 * weight * piece.shape.speed_um(2.0 * t - 1.0),
        }));
    }

    /// ε = n² of a region.
    pub(super) fn epsilon(&self, region: usize) -> Complex64 {
        self.indices[region] * self.indices[region]
    }

    /// Largest distance of a node from the origin, µm.
    pub(super) fn radius_um(&self) -> f64 {
        self.nodes.iter().map(|node| libm::hypot(node.point.at[0], node.point.at[1])).fold(0.0, f64::max)
    }
}

/// The index of a medium that must be the same everywhere.
fn index(section: &Section, medium: &Medium, wavelength_nm: f64, place: &str) -> Result<Complex64> {
    match medium {
        Medium::Pure(substance) => section.material(substance)?.index(wavelength_nm),
        Medium::Mixture { .. } => Err(Error::input(format!(
            "{place}: its medium varies along x, but full waves need the same medium in all of a region; give one of constant fraction"
        ))),
    }
}

/// How near a circle's line may come to another line, µm.
const LEAST_GAP_UM: f64 = 1e-7;

/// A circle, or an edge of a polygon, where it lies along x.
struct Span {
    left_um: f64,
    right_um: f64,
    contour: usize,
    line: Line,
}

/// What is swept over.
#[derive(Clone, Copy)]
enum Line {
    Circle { centre: [f64; 2], radius_um: f64 },
    Edge { from: [f64; 2], to: [f64; 2] },
}

/// Circles are exact here, and only polygons where the section was checked: they must not touch what they did not then. A sweep
/// along x compares each with what lies at the same x.
fn check_circles(contours: &[Contour<'_>]) -> Result<()> {
    let mut spans = Vec::new();
    for (contour, curve) in contours.iter().enumerate() {
        match *curve.outline {
            Loop::Circle { x_um, z_um, radius_um } => spans.push(Span {
                left_um: x_um - radius_um - LEAST_GAP_UM,
                right_um: x_um + radius_um + LEAST_GAP_UM,
                contour,
                line: Line::Circle { centre: [x_um, z_um], radius_um },
            }),
            Loop::Polygon(ref corners) => {
                let count = corners.x_um.len();
                let corner = |i: usize| [corners.x_um[i % count], corners.z_um[i % count]];
                spans.extend((0..count).map(|i| {
                    let (from, to) = (corner(i), corner(i + 1));
                    Span {
                        left_um: from[0].min(to[0]),
                        right_um: from[0].max(to[0]),
                        contour,
                        line: Line::Edge { from, to },
                    }
                }));
            }
        }
    }
    spans.sort_by(|a, b| a.left_um.total_cmp(&b.left_um).then(a.contour.cmp(&b.contour)));
    let mut open: Vec<&Span> = Vec::new();
    for span in &spans {
        open.retain(|other| other.right_um >= span.left_um);
        for other in &open {
            let Some([x, z]) = span.line.touches(other.line) else { continue };
            let first = &contours[span.contour.min(other.contour)].place;
            let second = &contours[span.contour.max(other.contour)].place;
            return Err(Error::input(format!(
                "{first} and {second} cross or touch near x = {x:.4}, z = {z:.4} µm; move them apart or nest one in the other"
            )));
        }
        open.push(span);
    }
    Ok(())
}

impl Line {
    /// The centre of the circle of the two that the other one crosses or touches; edges were compared before.
    fn touches(self, other: Self) -> Option<[f64; 2]> {
        match (self, other) {
            (Self::Circle { centre, radius_um }, Self::Circle { centre: [x, z], radius_um: r }) => {
                let apart = libm::hypot(centre[0] - x, centre[1] - z);
                let is_clear =
                    apart > radius_um + r + LEAST_GAP_UM || apart < (radius_um - r).abs() - LEAST_GAP_UM;
                (!is_clear).then_some(centre)
            }
            (Self::Circle { centre, radius_um }, Self::Edge { from, to })
            | (Self::Edge { from, to }, Self::Circle { centre, radius_um }) => {
                let nearest = Shape::Line { from, to }.nearest(centre).1;
                let far = |corner: [f64; 2]| libm::hypot(corner[0] - centre[0], corner[1] - centre[1]);
                let farthest = far(from).max(far(to));
                // All of the edge outside, or all of it inside.
                let is_clear = nearest > radius_um + LEAST_GAP_UM || farthest < radius_um - LEAST_GAP_UM;
                (!is_clear).then_some(centre)
            }
            (Self::Edge { .. }, Self::Edge { .. }) => None,
        }
    }
}

/// A panel before nodes are placed.
#[derive(Debug, Clone, Copy)]
struct Piece {
    shape: Shape,
    boundary: usize,
    nodes: usize,
}

/// A closed curve as panels, clockwise with x to the right and z up, so that normals lead outwards.
fn outline(shape: &Loop, density_um: f64) -> Vec<Piece> {
    match *shape {
        Loop::Circle { x_um, z_um, radius_um } => {
            let wanted = TAU * radius_um * density_um;
            let count = LEAST_ARCS.max((wanted / MOST_NODES as f64).ceil() as usize);
            let nodes = LEAST_ARC_NODES.max((wanted / count as f64).ceil() as usize);
            let turn = |k: usize| TAU * k as f64 / count as f64;
            let arc = |k| Shape::Arc { centre: [x_um, z_um], radius_um, turn: [turn(k), turn(k + 1)] };
            (0..count).map(|k| Piece { shape: arc(k), boundary: 0, nodes }).collect()
        }
        Loop::Polygon(ref corners) => polygon(corners, density_um),
    }
}

/// A polygon's corner.
#[derive(Debug, Clone, Copy)]
struct Corner {
    at: [f64; 2],
    /// By how much the outline turns here, rad.
    turn: f64,
    is_smooth: bool,
}

/// A polygon as panels: smooth curves through the corners that are samples of one, straight edges elsewhere.
fn polygon(corners: &Polyline, density_um: f64) -> Vec<Piece> {
    let corners = clockwise(corners);
    let count = corners.len();
    let Some(start) = corners.iter().position(|corner| !corner.is_smooth) else {
        let points = corners.iter().chain(&corners[..1]).map(|corner| corner.at).collect();
        return smooth(points, true, [false; 2], density_um);
    };
    let mut pieces = Vec::new();
    let mut from = start;
    while from < start + count {
        let mut to = from + 1;
        while corners[to % count].is_smooth {
            to += 1;
        }
        let points: Vec<[f64; 2]> = (from..=to).map(|i| corners[i % count].at).collect();
        let sharp = [from, to].map(|i| corners[i % count].turn.abs() > SHARP_RAD);
        pieces.extend(smooth(points, false, sharp, density_um));
        from = to;
    }
    pieces
}

/// Panels of a curve through points; of a straight edge if there are two.
fn smooth(points: Vec<[f64; 2]>, closed: bool, sharp: [bool; 2], density_um: f64) -> Vec<Piece> {
    let turns: Vec<f64> = points.windows(3).map(|p| turn(p[0], p[1], p[2]).abs()).collect();
    let ends = [points[0], points[points.len() - 1]];
    let Some(spline) = Spline::new(points, closed) else {
        let edge = Shape::Line { from: ends[0], to: ends[1] };
        let wanted = edge.length_um() * density_um;
        let parts = (wanted / MOST_NODES as f64).ceil().max(1.0) as usize;
        let nodes = LEAST_NODES.max((wanted / parts as f64).ceil() as usize);
        let mut rest = edge;
        let mut panels = Vec::new();
        for left in (2..=parts).rev() {
            let [panel, more] = rest.part(1.0 / left as f64);
            panels.push(panel);
            rest = more;
        }
        panels.push(rest);
        return graded(panels.into_iter().map(|shape| Piece { shape, boundary: 0, nodes }).collect(), sharp);
    };
    // Panels end where a sum of lengths and turns, of the points so far, passes whole numbers.
    let t = spline.parameters();
    let mut demand = vec![0.0];
    for i in 1..t.len() {
        let bend = 0.5 * (turns.get(i.wrapping_sub(2)).unwrap_or(&0.0) + turns.get(i - 1).unwrap_or(&0.0));
        let here = ((t[i] - t[i - 1]) * density_um / MOST_NODES as f64).max(bend / TURN_OF_PANEL);
        demand.push(demand[i - 1] + here);
    }
    let total = demand[demand.len() - 1];
    let count = (if closed { LEAST_ARCS as f64 } else { 1.0 }).max(total.ceil()) as usize;
    let parameter = |part: f64| {
        let goal = total * part;
        let right = demand.partition_point(|&d| d <= goal).clamp(1, t.len() - 1);
        let step = demand[right] - demand[right - 1];
        t[right - 1] + (t[right] - t[right - 1]) * ((goal - demand[right - 1]) / step).clamp(0.0, 1.0)
    };
    let pieces = (0..count).map(|k| {
        let [from, to] = [k, k + 1].map(|k| parameter(k as f64 / count as f64));
        let shape = Shape::smooth(|t| spline.at(t), from, to);
        let nodes = (shape.length_um() * density_um).ceil() as usize;
        Piece { shape, boundary: 0, nodes: nodes.clamp(LEAST_SMOOTH_NODES, MOST_NODES) }
    });
    graded(pieces.collect(), sharp)
}

/// Crowds the first and the last panel to sharp ends.
fn graded(mut pieces: Vec<Piece>, sharp: [bool; 2]) -> Vec<Piece> {
    if pieces.len() == 1 && sharp == [true; 2] {
        pieces = pieces[0].shape.split().map(|shape| Piece { shape, ..pieces[0] }).to_vec();
    }
    if sharp[0] {
        let [corner, rest] = at_corner(pieces.remove(0), true);
        pieces.splice(0..0, corner.into_iter().chain(rest));
    }
    if let Some(last) = pieces.pop_if(|_| sharp[1]) {
        let [corner, rest] = at_corner(last, false);
        pieces.extend(rest.into_iter().chain(corner));
    }
    pieces
}

/// The part of a panel at a corner, crowded to it, and what is left: crowding thins the nodes out at its other end.
fn at_corner(piece: Piece, at_start: bool) -> [Option<Piece>; 2] {
    // Pieces that are short against the wavelength make little of their corner's field.
    let least = if piece.nodes <= LEAST_SMOOTH_NODES { NODES_AT_FINE_CORNERS } else { NODES_AT_CORNERS };
    let crowded =
        |shape: Shape| Piece { shape: shape.crowded(at_start), nodes: piece.nodes.max(least), ..piece };
    if piece.nodes <= NODES_AT_CORNERS {
        return [Some(crowded(piece.shape)), None];
    }
    let part = CORNER_LENGTH / piece.nodes as f64;
    let [a, b] = piece.shape.part(if at_start { part } else { 1.0 - part });
    let (corner, rest) = if at_start { (a, b) } else { (b, a) };
    let corner = Piece { nodes: NODES_AT_CORNERS, ..crowded(corner) };
    let nodes = LEAST_SMOOTH_NODES.max(piece.nodes - CORNER_LENGTH as usize);
    [Some(corner), Some(Piece { shape: rest, nodes, ..piece })]
}

/// The angle by which the way from `a` over `b` to `c` turns, rad.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let (ux, uz, vx, vz) = (b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]);
    libm::atan2(ux * vz - uz * vx, ux * vx + uz * vz)
}

/// The corners, clockwise with x to the right and z up.
fn clockwise(corners: &Polyline) -> Vec<Corner> {
    let every = || corners.x_um.iter().zip(&corners.z_um).map(|(&x, &z)| [x, z]);
    let mut all: Vec<[f64; 2]> = Vec::with_capacity(corners.x_um.len());
    let are_same = |p: &[f64; 2], q: &[f64; 2]| libm::hypot(p[0] - q[0], p[1] - q[1]) < SAME_UM;
    for point in every() {
        if !all.last().is_some_and(|last| are_same(last, &point)) {
            all.push(point);
        }
    }
    if all.len() > 1 && are_same(&all[0], &all[all.len() - 1]) {
        all.pop();
    }
    if all.len() < 3 {
        all = every().collect();
    }
    let count = all.len();
    let area: f64 = (0..count)
        .map(|i| {
            let (a, b) = (all[i], all[(i + 1) % count]);
            a[0] * b[1] - b[0] * a[1]
        })
        .sum();
    if area > 0.0 {
        all.reverse();
    }
    let corner = |i: usize| {
        let (a, b, c) = (all[(i + count - 1) % count], all[i], all[(i + 1) % count]);
        let lengths = [libm::hypot(b[0] - a[0], b[1] - a[1]), libm::hypot(c[0] - b[0], c[1] - b[1])];
        let like = lengths[0] < LIKE_LENGTHS * lengths[1] && lengths[1] < LIKE_LENGTHS * lengths[0];
        let turn = turn(a, b, c);
        let sagitta_um = 0.125 * lengths[0].max(lengths[1]) * turn.abs();
        let is_fine = turn.abs() < FINE_RAD && sagitta_um < FINE_SAGITTA_UM;
        Corner { at: b, turn, is_smooth: is_fine || (turn.abs() < SMOOTH_RAD && like) }
    };
    (0..count).map(corner).collect()
}

/// Halves panels until none is long against its distance to another boundary, or to another stretch of its own that it
/// turns its back to.
fn resolve_gaps(mut pieces: Vec<Piece>) -> Result<Vec<Piece>> {
    loop {
        let close = long_against_gaps(&pieces);
        if close.iter().all(|&split| !split) {
            return Ok(pieces);
        }
        if pieces.len() > MOST_PANELS {
            return Err(Error::input(format!(
                "boundaries come so close to each other that over {MOST_PANELS} panels are needed; move them apart"
            )));
        }
        let halves = pieces.iter().zip(&close).flat_map(|(piece, &split)| {
            let [a, b] = piece.shape.split();
            let parts = if split { vec![a, b] } else { vec![piece.shape] };
            parts.into_iter().map(|shape| Piece { shape, ..*piece })
        });
        pieces = halves.collect();
    }
}

fn long_against_gaps(pieces: &[Piece]) -> Vec<bool> {
    /// What is looked at of a panel.
    struct Seen {
        middle: Point,
        half_um: f64,
        samples: [[f64; 2]; 5],
    }
    let seen: Vec<Seen> = pieces
        .iter()
        .map(|piece| Seen {
            middle: piece.shape.point(0.0),
            half_um: 0.5 * piece.shape.length_um(),
            samples: [-1.0, -0.5, 0.0, 0.5, 1.0].map(|s| piece.shape.point(s).at),
        })
        .collect();
    let mut by_x: Vec<usize> = (0..pieces.len()).collect();
    by_x.sort_by(|&a, &b| seen[a].middle.at[0].total_cmp(&seen[b].middle.at[0]));
    let longest = seen.iter().map(|seen| seen.half_um).fold(0.0, f64::max);
    let mut close = vec![false; pieces.len()];
    for (place, &a) in by_x.iter().enumerate() {
        for &b in &by_x[place + 1..] {
            let reach = seen[a].half_um + seen[b].half_um;
            let dx = seen[b].middle.at[0] - seen[a].middle.at[0];
            if dx > 2.0 * (seen[a].half_um + longest) {
                break;
            }
            let dz = seen[b].middle.at[1] - seen[a].middle.at[1];
            if libm::hypot(dx, dz) > 2.0 * reach {
                continue;
            }
            let [n, m] = [seen[a].middle.normal(), seen[b].middle.normal()];
            if pieces[a].boundary == pieces[b].boundary && n[0] * m[0] + n[1] * m[1] > -0.3 {
                continue;
            }
            let to = |shape: &Shape, samples: &[[f64; 2]; 5]| {
                samples.iter().map(|&at| shape.nearest(at).1).fold(f64::INFINITY, f64::min)
            };
            let gap = to(&pieces[a].shape, &seen[b].samples).min(to(&pieces[b].shape, &seen[a].samples));
            for piece in [a, b] {
                let length = 2.0 * seen[piece].half_um;
                close[piece] |= length > LENGTH_PER_GAP * gap && length > SHORTEST_UM;
            }
        }
    }
    close
}
