//! The field inside a crystal, for pictures.

use super::grid::Grid;
use super::medium::Medium;
use super::spectrum::Spectrum;

/// |E|² and the permittivity on the nodes of the grid, over one period.
#[derive(Debug, Clone)]
pub struct NearField {
    /// Period along x, µm; column i lies at i/`columns` of it.
    pub period_um: f64,
    /// Height of the lowest row, µm, below the surface at 0.
    pub bottom_um: f64,
    /// Height of the highest row, µm.
    pub top_um: f64,
    /// Values in a row; rows from the lowest up.
    pub columns: usize,
    /// Re ε, `[row][column]`.
    pub permittivity: Vec<f64>,
    /// |E|² over that of the incident wave, `[incident polarization][row][column]`.
    pub intensity: [Vec<f64>; 2],
}

impl NearField {
    pub(super) fn new(medium: &Medium, grid: &Grid, runs: &[Spectrum; 2]) -> Self {
        let (nx, rows) = (grid.nx, grid.near.clone());
        let place = |i: usize, k: usize| (i as f64 * grid.spacing, -grid.z(k as f64));
        let permittivity = rows.clone().flat_map(|k| {
            (0..nx).map(move |i| {
                let (x, depth) = place(i, k);
                medium.at(x, depth).re
            })
        });
        Self {
            period_um: medium.cell.period_um,
            bottom_um: grid.z(rows.start as f64),
            top_um: grid.z((rows.end - 1) as f64),
            columns: nx,
            permittivity: permittivity.collect(),
            intensity: runs.each_ref().map(|run| intensity(run, nx, rows.len())),
        }
    }
}

/// |E|² on the nodes: components that stand between nodes count with the mean of their two neighbours' squares.
fn intensity(run: &Spectrum, nx: usize, rows: usize) -> Vec<f64> {
    let [x, y, z] = &run.electric;
    let square = |component: &[crate::Complex64], i: usize, k: usize| component[i * rows + k].norm_sqr();
    (0..rows)
        .flat_map(|k| {
            (0..nx).map(move |i| {
                let (left, below) = (if i == 0 { nx - 1 } else { i - 1 }, k.saturating_sub(1));
                square(y, i, k)
                    + 0.5 * (square(x, left, k) + square(x, i, k))
                    + 0.5 * (square(z, i, below) + square(z, i, k))
            })
        })
        .collect()
}
