//! A film's response as a figure.

use barbule::film::Sweep;
use barbule::plot::{Axis, Curve, Drawing, Figure, HeatMap, Page};

use super::Found;

/// A part of the power with its standard deviation between individuals. Shape: `[angle][wavelength]`.
#[derive(Clone, Copy)]
struct Quantity<'a> {
    name: &'static str,
    mean: &'a [f64],
    std: Option<&'a [f64]>,
}

impl<'a> Quantity<'a> {
    fn new(name: &'static str, mean: &'a [f64], std: Option<&'a [f64]>) -> Self {
        Self { name, mean, std }
    }

    /// Its curve over places `at` of the tables, of the given x.
    fn curve(&self, name: String, at: &[(f64, usize)]) -> Curve {
        let mut curve = Curve::line(name, at.iter().map(|&(x, i)| [x, self.mean[i]]).collect());
        curve.spread = self.std.map(|std| at.iter().map(|&(_, i)| std[i]).collect());
        curve
    }
}

/// Reflected, transmitted and absorbed parts, each of s and p.
fn quantities(found: &Found) -> [Quantity<'_>; 6] {
    let [s, p] = &found.mean.polarization;
    let std = found.spread.as_ref().map(|spread| &spread.std);
    [
        Quantity::new("R, s", &s.reflected, std.map(|[s, _]| &s.reflected[..])),
        Quantity::new("R, p", &p.reflected, std.map(|[_, p]| &p.reflected[..])),
        Quantity::new("T, s", &s.transmitted, std.map(|[s, _]| &s.transmitted[..])),
        Quantity::new("T, p", &p.transmitted, std.map(|[_, p]| &p.transmitted[..])),
        Quantity::new("A, s", &s.absorbed, std.map(|[s, _]| &s.absorbed[..])),
        Quantity::new("A, p", &p.absorbed, std.map(|[_, p]| &p.absorbed[..])),
    ]
}

/// Curves against wavelength, or against angle at one wavelength, or a map when there are many angles; with bands of the
/// standard deviation where thicknesses spread.
pub(super) fn figure(title: &str, found: &Found, page: &Page) -> Drawing {
    let Found { mean, angle_deg, spread } = found;
    let columns = mean.at.len();
    let of_individuals = spread.as_ref().map(|s| format!("mean ± 1 std of {}", s.individuals));
    let legend =
        |text: String| [Some(text), of_individuals.clone()].into_iter().flatten().collect::<Vec<_>>();
    if columns > 1 && angle_deg.len() > 16 {
        return map(title, mean, angle_deg).draw_on(page);
    }
    let parts = quantities(found);
    let mut chart =
        Figure::new(title, Axis::new("wavelength in vacuum (nm)"), Axis::new("part of the power"));
    if columns == 1 && angle_deg.len() > 1 {
        chart.x.label = "angle from the normal (°)".into();
        let mut at: Vec<_> = angle_deg.iter().copied().zip(0..).collect();
        at.sort_by(|a, b| a.0.total_cmp(&b.0));
        chart.curves.extend(parts.iter().map(|part| part.curve(part.name.into(), &at)));
        chart.legend = legend(format!("{} nm", mean.at[0])).join(", ");
        return chart.draw_on(page);
    }
    let row = |a: usize| -> Vec<_> { mean.at.iter().copied().zip(a * columns..).collect() };
    let unpolarized = mean.unpolarized();
    match angle_deg[..] {
        [angle] => {
            let normal = angle == 0.0;
            for part in parts.iter().step_by(if normal { 2 } else { 1 }) {
                let name = if normal { &part.name[..1] } else { part.name };
                chart.curves.push(part.curve(name.into(), &row(0)));
            }
            chart.legend = legend(format!("{angle}°")).join(", ");
        }
        [_, _] | [_, _, _] | [_, _, _, _] => {
            chart.y.label = "reflectance".into();
            for (a, angle) in angle_deg.iter().enumerate() {
                let curve =
                    |part: &Quantity<'_>, name: &str| part.curve(format!("{angle}°, {name}"), &row(a));
                chart.curves.extend([curve(&parts[0], "s"), curve(&parts[1], "p")]);
            }
            chart.legend = of_individuals.unwrap_or_default();
        }
        _ => {
            chart.y.label = "reflectance, unpolarized".into();
            let std = spread.as_ref().map(|spread| &spread.unpolarized[..]);
            let all = Quantity { name: "R", mean: &unpolarized, std };
            chart.curves.extend(
                angle_deg.iter().enumerate().map(|(a, angle)| all.curve(format!("{angle}°"), &row(a))),
            );
            chart.legend = of_individuals.unwrap_or_default();
        }
    }
    if spread.is_some() {
        // A band may reach below zero, but no part of the power does.
        let tops = chart.curves.iter().flat_map(|curve| {
            let std = curve.spread.iter().flatten();
            curve.points.iter().zip(std).map(|(point, std)| point[1] + std)
        });
        let top = tops.fold(0.0, f64::max);
        chart.y.range = Some([0.0, ((10.0 * top).ceil() / 10.0).max(0.1)]);
    }
    chart.draw_on(page)
}

/// Unpolarized reflectance against wavelength and angle; each cell shows the nearest computed point.
fn map(title: &str, found: &Sweep, angle_deg: &[f64]) -> HeatMap {
    const CELLS: [usize; 2] = [420, 330];
    let columns = found.at.len();
    let mean = found.unpolarized();
    let mut order: Vec<usize> = (0..angle_deg.len()).collect();
    order.sort_by(|a, b| angle_deg[*a].total_cmp(&angle_deg[*b]));
    let angles: Vec<f64> = order.iter().map(|a| angle_deg[*a]).collect();
    let (low, high) = (angles[0], angles[angles.len() - 1]);
    let (first, last) = found.at.range_nm();
    let nearest = |sorted: &[f64], value: f64| {
        let after = sorted.partition_point(|v| *v < value).min(sorted.len() - 1);
        if after > 0 && value - sorted[after - 1] < sorted[after] - value { after - 1 } else { after }
    };
    let middle =
        |i: usize, cells: usize, from: f64, to: f64| from + (to - from) * (i as f64 + 0.5) / cells as f64;
    let across: Vec<usize> =
        (0..CELLS[0]).map(|i| nearest(&found.at, middle(i, CELLS[0], first, last))).collect();
    let mut values = Vec::with_capacity(CELLS[0] * CELLS[1]);
    for j in 0..CELLS[1] {
        let row = order[nearest(&angles, middle(j, CELLS[1], low, high))] * columns;
        values.extend(across.iter().map(|column| mean[row + column]));
    }
    let x = Axis::with_range("wavelength in vacuum (nm)", first, last);
    let y = Axis::with_range("angle from the normal (°)", low, high);
    let mut map = HeatMap::new(title, x, y, CELLS[0], values);
    map.label = "reflectance, unpolarized".into();
    map
}
