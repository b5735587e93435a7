//! Tables of colour over (u, v): a grating's light once its wavelengths are summed.
//!
//! XYZ = R Γ Σ_p b_p(w) I_p(u, v), with b_p = w^p in Taylor's series (Dhillon et al. 2014) and, better conditioned, Chebyshev polynomials
//! of w + 1 over all w ∈ \[−2, 0\]. Tables lie on a grid that is finest at u = v = 0, where a mirror's narrow lobe is:
//! u = 2 sgn(t)|t|^e of even steps in t, with cubics in t between (Catmull–Rom's, through the values of four places along
//! either axis): of a grating's smooth dispersion they leave a tenth of the error of straight lines.

use glam::DVec3;

use super::powers::MOST_TERMS;
use super::{Setup, q};
use crate::{Error, Result};

/// The largest side of tables.
pub const GREATEST_SIZE: usize = 4001;
/// Most tables.
pub const MOST_TABLES: usize = MOST_TERMS;
/// Most numbers, 4 GiB.
const MOST_VALUES: usize = 1 << 30;

/// Which functions of w the tables go with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// (w/2)^p, p = 0 … 2 `orders`: Taylor's series, each table 2^p times that of w^p.
    Taylor {
        /// Order N of the series of the amplitude.
        orders: usize,
    },
    /// T_p(w + 1), p < `terms`.
    Chebyshev {
        /// How many.
        terms: usize,
    },
}

impl Basis {
    /// How many tables.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Taylor { orders } => orders.saturating_mul(2).saturating_add(1),
            Self::Chebyshev { terms } => terms,
        }
    }

    /// The functions at w.
    fn at(self, w: f64) -> [f64; MOST_TABLES] {
        let mut values = [0.0; MOST_TABLES];
        let (mut before, mut now) = (w + 1.0, 1.0);
        for value in &mut values[..self.count()] {
            *value = now;
            match self {
                Self::Taylor { .. } => now *= 0.5 * w,
                Self::Chebyshev { .. } => (before, now) = (now, 2.0 * (w + 1.0) * now - before),
            }
        }
        values
    }
}

/// Where tables have values: u and v of each of `size` steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableGrid {
    /// Steps along either axis, odd.
    pub size: usize,
    /// e of u = 2 sgn(t)|t|^e.
    pub exponent: f64,
}

/// Places about a point along either axis.
const ABOUT: usize = 4;

/// The places about a point of a grid, and what each counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// `[u, v]` of each.
    pub places: [[usize; 2]; ABOUT * ABOUT],
    /// Sum 1.
    pub weights: [f64; ABOUT * ABOUT],
}

impl TableGrid {
    /// 501 steps, u = 2 t³.
    pub const USUAL: Self = Self { size: 501, exponent: 3.0 };

    /// Refuses grids that make no sense.
    ///
    /// # Errors
    /// An even, small or great size, an exponent below 1 or over 9.
    pub fn check(&self) -> Result<()> {
        if self.size.is_multiple_of(2) || !(3..=GREATEST_SIZE).contains(&self.size) {
            return Err(Error::input(format!(
                "tables of side {}: give an odd number from 3 to {GREATEST_SIZE}",
                self.size
            )));
        }
        if !(1.0..=9.0).contains(&self.exponent) {
            return Err(Error::input(format!(
                "the exponent of tables' steps is {}; give 1 to 9",
                self.exponent
            )));
        }
        Ok(())
    }

    /// u (or v) of a step.
    #[must_use]
    pub fn coordinate(&self, step: usize) -> f64 {
        let t = 2.0 * step as f64 / (self.size - 1) as f64 - 1.0;
        2.0 * t.signum() * libm::pow(t.abs(), self.exponent)
    }

    /// The cell of a point within ±2.
    #[must_use]
    pub fn cell(&self, u: f64, v: f64) -> Cell {
        let place = |x: f64| {
            let t = x.signum() * libm::pow((0.5 * x.abs()).min(1.0), 1.0 / self.exponent);
            let along = 0.5 * (t + 1.0) * (self.size - 1) as f64;
            let low = (along as usize).min(self.size - 2);
            (low, along - low as f64)
        };
        let ((i, a), (j, b)) = (place(u), place(v));
        let (across, along) = (catmull_rom(a), catmull_rom(b));
        let step = |low: usize, k: usize| (low + k).saturating_sub(1).min(self.size - 1);
        Cell {
            places: std::array::from_fn(|n| [step(i, n % ABOUT), step(j, n / ABOUT)]),
            weights: std::array::from_fn(|n| across[n % ABOUT] * along[n / ABOUT]),
        }
    }
}

/// Weights of the values at −1, 0, 1 and 2 for a place between 0 and 1.
fn catmull_rom(a: f64) -> [f64; ABOUT] {
    let (a2, a3) = (a * a, a * a * a);
    [
        0.5 * (2.0 * a2 - a - a3),
        0.5 * (2.0 - 5.0 * a2 + 3.0 * a3),
        0.5 * (a + 4.0 * a2 - 3.0 * a3),
        0.5 * (a3 - a2),
    ]
}

/// Colour tables of a grating.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    grid: TableGrid,
    basis: Basis,
    setup: Setup,
    /// `[v][u][table][X, Y, Z]`
    values: Vec<f32>,
}

impl Tables {
    /// From values `[v][u][table][X, Y, Z]`, those of a setup.
    ///
    /// # Errors
    /// Counts that do not fit each other or are too great, a grid or a setup out of range, numbers that are not finite.
    pub fn new(grid: TableGrid, basis: Basis, setup: Setup, values: Vec<f32>) -> Result<Self> {
        grid.check()?;
        setup.check()?;
        check_size(grid, basis)?;
        if values.len() != grid.size * grid.size * basis.count() * 3 {
            return Err(Error::input(format!(
                "{} numbers do not fit {} tables of {size} × {size} colours",
                values.len(),
                basis.count(),
                size = grid.size
            )));
        }
        if let Some(bad) = values.iter().position(|value| !value.is_finite()) {
            return Err(Error::input(format!("number {bad} of a grating's tables is not finite")));
        }
        Ok(Self { grid, basis, setup, values })
    }

    /// Their grid.
    #[must_use]
    pub fn grid(&self) -> TableGrid {
        self.grid
    }

    /// Their functions of w.
    #[must_use]
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// What they were made for.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// `[v][u][table][X, Y, Z]`
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// X, Y, Z of f for light from `w_i` towards `w_o`: a perfect mirror's f of 1/sr at all wavelengths has Y = 1.
    #[must_use]
    pub fn xyz(&self, w_i: DVec3, w_o: DVec3) -> [f64; 3] {
        let q = q(w_i, w_o);
        let cell = self.grid.cell(q.x, q.y);
        let row = self.basis.count() * 3;
        let texels = cell.places.iter().map(|[i, j]| &self.values[(j * self.grid.size + i) * row..][..row]);
        interpolated(self.basis, &self.setup, w_i, w_o, &cell, texels)
    }
}

/// Refuses tables that would take too much.
///
/// # Errors
/// Too many tables, or too large ones.
pub fn check_size(grid: TableGrid, basis: Basis) -> Result<()> {
    let is_fit = (1..=MOST_TABLES).contains(&basis.count());
    if !is_fit || grid.size * grid.size * basis.count() * 3 > MOST_VALUES {
        return Err(Error::input(format!(
            "{} tables of {size} × {size} colours are too many; at most {MOST_TABLES} and {} GiB are made",
            basis.count(),
            MOST_VALUES >> 28,
            size = grid.size
        )));
    }
    Ok(())
}

/// X, Y, Z from the tables' values `[table][X, Y, Z]` at the places of a cell; not below 0, which cubics may be beside a peak.
#[must_use]
pub fn interpolated<'a>(
    basis: Basis,
    setup: &Setup,
    w_i: DVec3,
    w_o: DVec3,
    cell: &Cell,
    texels: impl Iterator<Item = &'a [f32]>,
) -> [f64; 3] {
    let factor = setup.of_directions(w_i, w_o);
    let functions = basis.at(q(w_i, w_o).z);
    let mut xyz = [0.0; 3];
    for (weight, texel) in cell.weights.iter().zip(texels) {
        for (function, value) in functions.iter().zip(texel.as_chunks::<3>().0) {
            for (sum, value) in xyz.iter_mut().zip(value) {
                *sum += factor * weight * function * f64::from(*value);
            }
        }
    }
    xyz.map(|v| v.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_finest_in_the_middle_and_cubic_between() {
        let grid = TableGrid { size: 11, exponent: 3.0 };
        assert_eq!([0, 5, 10].map(|i| grid.coordinate(i)), [-2.0, 0.0, 2.0]);
        for (u, v) in [(-0.3, 0.3), (0.0, 0.0), (0.01, 0.8)] {
            let cell = grid.cell(u, v);
            assert!((cell.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // Parabolas of t are given back.
            let t = |x: f64| {
                let t = x.signum() * (0.5 * x.abs()).powf(1.0 / 3.0);
                t - 0.7 * t * t
            };
            for (axis, wanted) in [u, v].into_iter().enumerate() {
                let found: f64 = cell
                    .places
                    .iter()
                    .zip(cell.weights)
                    .map(|(place, weight)| weight * t(grid.coordinate(place[axis])))
                    .sum();
                assert!((found - t(wanted)).abs() < 1e-12, "{u} {v}");
            }
        }
    }

    /// The same cubic of w, −w³, in both bases.
    #[test]
    fn both_bases_are_polynomials_of_w() {
        let grid = TableGrid { size: 3, exponent: 1.0 };
        let setup = Setup { obliquity: super::super::Obliquity::Radiance, ..Setup::default() };
        let tables = |basis: Basis, coefficients: &[f32]| {
            let texel: Vec<f32> = coefficients.iter().flat_map(|c| [-c, -2.0 * c, 0.0]).collect();
            Tables::new(grid, basis, setup, texel.repeat(9)).unwrap()
        };
        // w³: (w/2)³·8, and with x = w + 1, (x − 1)³ = x³ − 3x² + 3x − 1 = (T₃ + 3T₁)/4 − 3(T₂ + 1)/2 + 3T₁ − 1.
        let taylor = tables(Basis::Taylor { orders: 2 }, &[0.0, 0.0, 0.0, 8.0, 0.0]);
        let chebyshev = tables(Basis::Chebyshev { terms: 4 }, &[-2.5, 3.75, -1.5, 0.25]);
        let w_i = DVec3::new(0.3, 0.0, 1.0).normalize();
        for x in [-0.8, 0.0, 0.6] {
            let w_o = DVec3::new(x, 0.1, 0.7).normalize();
            let expected = -setup.of_directions(w_i, w_o) * q(w_i, w_o).z.powi(3);
            for found in [taylor.xyz(w_i, w_o), chebyshev.xyz(w_i, w_o)] {
                assert!((found[0] / expected - 1.0).abs() < 1e-6, "{found:?} {expected}");
                assert!((found[1] - 2.0 * found[0]).abs() < 1e-9 && found[2] == 0.0);
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let basis = Basis::Chebyshev { terms: 2 };
        let grid = TableGrid { size: 3, exponent: 3.0 };
        let new = |grid, basis, count| Tables::new(grid, basis, Setup::default(), vec![0.0; count]);
        assert!(new(grid, basis, 54).is_ok());
        assert!(new(grid, basis, 53).is_err());
        assert!(new(TableGrid { size: 4, ..grid }, basis, 96).is_err());
        assert!(new(TableGrid { exponent: 0.0, ..grid }, basis, 54).is_err());
        assert!(new(grid, Basis::Taylor { orders: 1 << 40 }, 54).is_err());
    }
}
