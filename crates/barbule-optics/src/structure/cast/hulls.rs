//! The crossings of rays with closed loops.

use super::super::section::{Loop, Section};
use super::{Change, Ray};

/// Columns hold about this many pieces: fewer, and inclined rays visit too many; more, and each tests too many.
const PIECES_PER_COLUMN: usize = 128;

/// The closed loops, sorted into columns along x.
pub(super) struct Hulls<'a> {
    pub(super) nested: Vec<(u32, Option<usize>)>,
    /// Column by column, so that a ray reads them in one go; a piece is in each column that it reaches.
    pieces: Vec<Piece<'a>>,
    /// Start of each column in `pieces`.
    starts: Vec<u32>,
    left: f64,
    per_column: f64,
    low: f64,
    high: f64,
}

/// An edge of a polygon or a whole circle.
#[derive(Clone, Copy)]
enum Piece<'a> {
    Edge { id: u32, from: [f64; 2], to: [f64; 2] },
    Circle { id: u32, shape: &'a Loop },
}

impl Piece<'_> {
    fn extent(&self) -> [f64; 4] {
        match self {
            Self::Edge { from, to, .. } => {
                [from[0].min(to[0]), from[0].max(to[0]), from[1].min(to[1]), from[1].max(to[1])]
            }
            Self::Circle { shape: Loop::Circle { x_um, z_um, radius_um }, .. } => {
                [x_um - radius_um, x_um + radius_um, z_um - radius_um, z_um + radius_um]
            }
            Self::Circle { .. } => [0.0; 4],
        }
    }
}

impl<'a> Hulls<'a> {
    pub(super) fn new(section: &'a Section) -> Self {
        let mut pieces = Vec::new();
        for (id, nested) in section.nesting.loops.iter().enumerate() {
            let id = id as u32;
            match nested.shape(&section.inclusions) {
                Loop::Polygon(corners) => {
                    let point = |i: usize| [corners.x_um[i], corners.z_um[i]];
                    let count = corners.x_um.len();
                    pieces.extend((0..count).map(|i| Piece::Edge {
                        id,
                        from: point(i),
                        to: point((i + 1) % count),
                    }));
                }
                shape @ Loop::Circle { .. } => pieces.push(Piece::Circle { id, shape }),
            }
        }
        let nested = section.nesting.loops.iter().map(|n| (n.depth, n.shows)).collect();
        let mut all = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        for piece in &pieces {
            let [x0, x1, z0, z1] = piece.extent();
            all = [all[0].min(x0), all[1].max(x1), all[2].min(z0), all[3].max(z1)];
        }
        let count = (pieces.len() / PIECES_PER_COLUMN).clamp(1, 65536);
        let per_column = (all[1] - all[0]) / count as f64;
        let mut hulls = Self {
            nested,
            pieces,
            starts: vec![0; count + 1],
            left: all[0],
            per_column,
            low: all[2],
            high: all[3],
        };
        if hulls.pieces.is_empty() {
            return hulls;
        }
        let ranges: Vec<(usize, usize)> = hulls
            .pieces
            .iter()
            .map(|piece| {
                let extent = piece.extent();
                (hulls.column(extent[0]), hulls.column(extent[1]))
            })
            .collect();
        for &(from, to) in &ranges {
            for column in from..=to {
                hulls.starts[column + 1] += 1;
            }
        }
        for column in 0..count {
            hulls.starts[column + 1] += hulls.starts[column];
        }
        let mut members = vec![0; hulls.starts[count] as usize];
        let mut next = hulls.starts.clone();
        for (piece, &(from, to)) in ranges.iter().enumerate() {
            for place in &mut next[from..=to] {
                members[*place as usize] = piece;
                *place += 1;
            }
        }
        hulls.pieces = members.into_iter().map(|piece| hulls.pieces[piece]).collect();
        hulls
    }

    fn column(&self, x: f64) -> usize {
        // A cast of a negative number gives 0.
        (((x - self.left) / self.per_column) as usize).min(self.starts.len() - 2)
    }

    /// Adds the crossings of a ray with all loops. Each piece counts in one column only: that of the crossing.
    pub(super) fn cross(&self, ray: &Ray, direction: [f64; 2], out: &mut Vec<(f64, Change)>) {
        if self.pieces.is_empty() {
            return;
        }
        let [dx, dz] = direction;
        let enough = |from: f64, to: f64, start: f64, rate: f64| {
            if rate == 0.0 { f64::INFINITY } else { ((from - start) / rate).max((to - start) / rate) }
        };
        let right = self.left + self.per_column * (self.starts.len() - 1) as f64;
        let end = enough(self.low, self.high, ray.z_um, dz).min(enough(self.left, right, ray.x_um, dx));
        if end < 0.0 {
            return;
        }
        let end_x = if dx == 0.0 { ray.x_um } else { ray.x_um + end * dx };
        let (first, last) = (self.column(ray.x_um.min(end_x)), self.column(ray.x_um.max(end_x)));
        let mut emit = |column: usize, t: f64, extent: [f64; 4], id: u32| {
            let (from, to) = (self.column(extent[0]).max(first), self.column(extent[1]).min(last));
            let own = self.column(ray.x_um + t * dx);
            if t > 0.0 && from <= to && own.clamp(from, to) == column {
                out.push((t, Change::Loop(id)));
            }
        };
        for column in first..=last {
            let (from, to) = (self.starts[column] as usize, self.starts[column + 1] as usize);
            for piece in &self.pieces[from..to] {
                match piece {
                    Piece::Edge { id, from, to } => {
                        let side = |p: &[f64; 2]| dx * (p[1] - ray.z_um) - dz * (p[0] - ray.x_um);
                        let (a, b) = (side(from), side(to));
                        if (a > 0.0) == (b > 0.0) {
                            continue;
                        }
                        let along = |p: &[f64; 2]| dx * (p[0] - ray.x_um) + dz * (p[1] - ray.z_um);
                        let (s, e) = (along(from), along(to));
                        emit(column, s + (e - s) * (a / (a - b)), piece.extent(), *id);
                    }
                    Piece::Circle { id, shape: Loop::Circle { x_um, z_um, radius_um } } => {
                        let (cx, cz) = (x_um - ray.x_um, z_um - ray.z_um);
                        let (along, across) = (dx * cx + dz * cz, dx * cz - dz * cx);
                        let half = radius_um * radius_um - across * across;
                        if half > 0.0 {
                            let half = half.sqrt();
                            emit(column, along - half, piece.extent(), *id);
                            emit(column, along + half, piece.extent(), *id);
                        }
                    }
                    Piece::Circle { .. } => {}
                }
            }
        }
    }
}
