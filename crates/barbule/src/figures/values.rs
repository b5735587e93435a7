//! Values of a BRDF: over the hemisphere, and over the outgoing azimuth.

use super::lobes::tiled;
use crate::brdf::pictures::projected_grid;
use crate::plot::{Axis, Curve, Drawing, Figure, HeatMap};

/// Maps of f, each with its own scale: `f[wavelength][wo]` on [`projected_grid`] of `size`.
#[must_use]
pub fn hemisphere_maps(title: &str, size: usize, wavelengths_nm: &[f64], f: &[Vec<f64>]) -> Drawing {
    let cell = |x: f64| (0.5 * (x + 1.0) * size as f64) as usize;
    let cells: Vec<usize> = projected_grid(size).iter().map(|wo| cell(wo.y) * size + cell(wo.x)).collect();
    let map = |(nm, f): (&f64, &Vec<f64>)| {
        let mut values = vec![f64::NAN; size * size];
        for (cell, value) in cells.iter().zip(f) {
            values[*cell] = *value;
        }
        let (x, y) = (Axis::with_range("x of ω_o", -1.0, 1.0), Axis::with_range("y of ω_o", -1.0, 1.0));
        let mut map = HeatMap::new(format!("{nm} nm"), x, y, size, values);
        (map.label, map.size) = ("f (1/sr)".into(), [300.0, 300.0]);
        map.draw()
    };
    let maps: Vec<Drawing> = wavelengths_nm.iter().zip(f).map(map).collect();
    let columns = maps.len().min(3);
    tiled(maps, columns, title)
}

/// Curves of `marginal[wavelength][phi_o]` over φ_o.
#[must_use]
pub fn marginals(title: &str, wavelengths_nm: &[f64], phi_o_deg: &[f64], marginal: &[Vec<f64>]) -> Drawing {
    let mut figure = Figure::new(
        title,
        Axis::with_range("φ_o (°)", -90.0, 90.0),
        Axis::new("∫ f cosφ_o cos²θ_o dθ_o / cosθ_i (1/rad)"),
    );
    for (nm, row) in wavelengths_nm.iter().zip(marginal) {
        let points = phi_o_deg.iter().zip(row).map(|(phi, value)| [*phi, *value]);
        figure.curves.push(Curve::line(format!("{nm} nm"), points.collect()));
    }
    figure.draw()
}
