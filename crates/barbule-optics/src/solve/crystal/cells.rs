//! Cells that tests of the solvers share.

use super::{Cell, Rod, Shell};
use crate::Complex64;

/// ε of keratin at a wavelength, nm.
pub(crate) fn keratin(wavelength_nm: f64) -> Complex64 {
    Complex64::from((1.532 + 5890.0 / wavelength_nm.powi(2)).powi(2))
}

/// ε of melanin at a wavelength, nm.
pub(crate) fn melanin(wavelength_nm: f64) -> Complex64 {
    let n = Complex64::new(1.648 + 23700.0 / wavelength_nm.powi(2), 0.56 * (-wavelength_nm / 270.0).exp());
    n * n
}

/// A rod of shells (diameter, ε), outermost first.
pub(crate) fn rod(x_um: f64, depth_um: f64, shells: &[(f64, Complex64)]) -> Rod {
    let shells = shells.iter().map(|&(diameter_um, eps)| Shell { diameter_um, eps }).collect();
    Rod { x_um, depth_um, shells }
}

/// Rods in keratin under air.
pub(crate) fn in_keratin(period_um: f64, wavelength_nm: f64, rods: Vec<Rod>) -> Cell {
    Cell { period_um, incidence_eps: 1.0, host_eps: keratin(wavelength_nm), rods }
}

/// Mallard lime: solid rods in six rows, apart.
pub(crate) fn mallard(wavelength_nm: f64) -> Cell {
    let row =
        |i: usize| rod((i % 2) as f64 * 0.1, 0.345 + 0.18 * i as f64, &[(0.13, melanin(wavelength_nm))]);
    in_keratin(0.2, wavelength_nm, (0..6).map(row).collect())
}

/// Magpie violet: hollow rods in three rows, touching.
pub(crate) fn magpie(wavelength_nm: f64) -> Cell {
    let shells = [(0.18, melanin(wavelength_nm)), (0.09, Complex64::from(1.0))];
    let row = |i: usize| rod((i % 2) as f64 * 0.09, 0.22 + 0.15588 * i as f64, &shells);
    in_keratin(0.18, wavelength_nm, (0..3).map(row).collect())
}

/// Peafowl yellow: rows of rods with air channels between.
pub(crate) fn peafowl(wavelength_nm: f64) -> Cell {
    let solid = |i: usize| rod(0.0, 0.15 + 0.19 * i as f64, &[(0.12, melanin(wavelength_nm))]);
    let channel = |i: usize| rod(0.08, 0.245 + 0.19 * i as f64, &[(0.055, Complex64::from(1.0))]);
    in_keratin(0.16, wavelength_nm, (0..6).map(solid).chain((0..5).map(channel)).collect())
}
