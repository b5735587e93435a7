//! The surface of a signed distance as a closed mesh: one point in each cell that it crosses, a quadrangle about each edge of the grid
//! that it crosses (surface nets; Gibson 1998, *Constrained elastic surface nets*), the points then moved onto it along its slope.

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

use super::Form;
use crate::progress::Progress;
use crate::scene::geometry::Mesh;
use crate::scene::go_on;
use crate::{Error, Result};

/// Most cells of a grid.
pub const MOST_CELLS: f64 = 3e7;
/// Steps by which points are moved onto the surface, and how far at most, over the resolution.
const SETTLES: u32 = 3;
const FARTHEST: f64 = 0.45;
/// A cell without a point.
const NONE: u32 = u32::MAX;

/// The corners of a grid of cubes.
struct Grid {
    low: DVec3,
    size: f64,
    /// Corners along x, y and z.
    counts: [usize; 3],
    /// Distances there: x runs fastest.
    values: Vec<f32>,
}

impl Grid {
    fn of(form: &Form, progress: &dyn Progress) -> Result<Self> {
        let (size, low) = (form.resolution_mm, form.bounds()[0]);
        let counts = form.cells().map(|cells| cells as usize + 1);
        let [nx, ny, nz] = counts;
        let mut values = vec![0.0_f32; nx * ny * nz];
        progress.begin("making a body", nz as u64);
        values.par_chunks_mut(nx * ny).enumerate().try_for_each(|(k, layer)| {
            go_on(progress)?;
            for (at, value) in layer.iter_mut().enumerate() {
                let corner = DVec3::new((at % nx) as f64, (at / nx) as f64, k as f64);
                *value = form.distance(low + corner * size) as f32;
            }
            progress.advance(1);
            Ok(())
        })?;
        Ok(Self { low, size, counts, values })
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.counts[1] + j) * self.counts[0] + i
    }

    fn is_inside(&self, corner: [usize; 3]) -> bool {
        self.values[self.index(corner)] < 0.0
    }

    /// The mean of where a cell's edges cross the surface; none where they do not.
    fn crossing(&self, cell: [usize; 3]) -> Option<DVec3> {
        let corner = |n: usize| [cell[0] + (n & 1), cell[1] + (n >> 1 & 1), cell[2] + (n >> 2)];
        let value = |n: usize| f64::from(self.values[self.index(corner(n))]);
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for n in 0..8_usize {
            for axis in (0..3).filter(|axis| n >> axis & 1 == 0) {
                let (a, b) = (value(n), value(n | 1 << axis));
                if (a < 0.0) != (b < 0.0) {
                    let from = DVec3::from_array(corner(n).map(|at| at as f64));
                    let mut step = DVec3::ZERO;
                    step[axis] = a / (a - b);
                    (sum, count) = (sum + from + step, count + 1.0);
                }
            }
        }
        (count > 0.0).then(|| self.low + sum / count * self.size)
    }
}

pub(super) fn mesh(form: &Form, progress: &dyn Progress) -> Result<Mesh> {
    let grid = Grid::of(form, progress)?;
    let [nx, ny, nz] = grid.counts;
    let cells = [nx - 1, ny - 1, nz - 1];
    let mut points = Vec::new();
    let mut point_of = vec![NONE; cells.iter().product()];
    for (at, own) in point_of.iter_mut().enumerate() {
        let cell = [at % cells[0], at / cells[0] % cells[1], at / (cells[0] * cells[1])];
        if let Some(point) = grid.crossing(cell) {
            *own = points.len() as u32;
            points.push(point);
        }
    }
    if points.is_empty() {
        return Err(Error::input(
            "nothing of the form is seen at its resolution_mm; give a finer one, or larger parts",
        ));
    }
    go_on(progress)?;
    let settled: Vec<(DVec3, DVec3)> = points.par_iter().map(|&point| settle(form, point)).collect();
    let of_cell = |cell: I64Vec3| {
        let [i, j, k] = cell.to_array().map(|at| at as usize);
        point_of[(k * cells[1] + j) * cells[0] + i]
    };
    let mut triangles = Vec::with_capacity(2 * points.len());
    for at in 0..grid.values.len() {
        let corner = [at % nx, at / nx % ny, at / (nx * ny)];
        for axis in 0..3 {
            let mut next = corner;
            next[axis] += 1;
            // Nothing reaches the border of the grid.
            let is_within = (0..3).all(|k| corner[k] > 0 || k == axis) && next[axis] < grid.counts[axis];
            if !is_within || grid.is_inside(corner) == grid.is_inside(next) {
                continue;
            }
            let [mut u, mut v] = [I64Vec3::ZERO; 2];
            (u[(axis + 1) % 3], v[(axis + 2) % 3]) = (1, 1);
            let own = I64Vec3::from_array(corner.map(|at| at as i64));
            let around = [own - u - v, own - v, own, own - u].map(of_cell);
            let quad =
                if grid.is_inside(corner) { around } else { [around[3], around[2], around[1], around[0]] };
            triangles.extend(halves(quad, &settled));
        }
    }
    Ok(Mesh {
        positions: settled.iter().map(|(point, _)| point.as_vec3()).collect(),
        normals: settled.iter().map(|(_, normal)| normal.as_vec3()).collect(),
        triangles,
        ..Mesh::default()
    })
}

/// A point moved onto the surface, not out of its cell, and the normal there.
fn settle(form: &Form, start: DVec3) -> (DVec3, DVec3) {
    let most = FARTHEST * form.resolution_mm;
    let mut point = start;
    for _ in 0..SETTLES {
        let step = form.outwards(point) * -form.distance(point);
        point = start + (point + step - start).clamp_length_max(most);
    }
    (point, form.outwards(point))
}

/// A quadrangle divided along its shorter diagonal.
fn halves([a, b, c, d]: [u32; 4], points: &[(DVec3, DVec3)]) -> [[u32; 3]; 2] {
    let far = |p: u32, q: u32| points[p as usize].0.distance_squared(points[q as usize].0);
    if far(a, c) <= far(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}
