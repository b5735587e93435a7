//! Far fields against the outgoing azimuth.

use crate::plot::{Axis, Curve, Drawing, Figure, HeatMap, Page};
use crate::scattering::far_field::{Azimuths, FarField, IncidentLight, Polarization};
use crate::solve::far_fields::{Illuminations, Scattered};
use crate::{Error, Result};

/// More far fields than this are no longer told apart as curves.
const MOST_CURVES: usize = 12;

/// Rows and columns of a map.
const CELLS: [usize; 2] = [480, 330];

/// The axis that changes: its label and its values.
struct Varied {
    label: &'static str,
    values: Vec<f64>,
}

/// Refuses, before any work, what would be neither curves nor a map.
///
/// # Errors
/// More than 12 far fields that differ in more than one of wavelength, θ_i and φ_i.
pub fn check_far_fields(illuminations: &Illuminations) -> Result<()> {
    let count = illuminations.count();
    if count > MOST_CURVES && varied(illuminations).len() > 1 {
        return Err(Error::input(format!(
            "{count} far fields that differ in more than one of wavelength, theta and phi cannot be drawn together; \
             vary one of them, or give at most {MOST_CURVES} in all"
        )));
    }
    Ok(())
}

/// Curves of the intensity against the azimuth: of one far field both polarizations, of several their mean; of many along
/// one axis a map.
///
/// # Errors
/// As [`check_far_fields`].
pub fn far_fields(
    title: &str,
    illuminations: &Illuminations,
    found: &[Scattered],
    page: &Page,
) -> Result<Drawing> {
    check_far_fields(illuminations)?;
    let quantity = match found.first().map(|found| found.far.light) {
        Some(IncidentLight::PlaneWave) => "differential scattering width (µm/rad)",
        _ => "intensity (1/rad)",
    };
    let azimuth = Axis::new("outgoing azimuth φ_o (°)");
    let axes = varied(illuminations);
    if let (true, [axis]) = (found.len() > MOST_CURVES, &axes[..]) {
        return Ok(map(title, azimuth, axis, quantity, found).draw_on(page));
    }
    let mut chart = Figure::new(title, azimuth, Axis::new(quantity));
    if let [Scattered { far, .. }] = found {
        for (polarization, name) in Polarization::BOTH.into_iter().zip(["polarization 1", "polarization 2"]) {
            chart.curves.push(Curve::line(name, points(far, &far.per_radian(polarization))));
        }
        return Ok(chart.draw_on(page));
    }
    for (Scattered { far, .. }, light) in found.iter().zip(illuminations.iter()) {
        let words = axes.iter().map(|axis| match axis.label {
            WAVELENGTH => format!("{} nm", short(light.wavelength_nm)),
            THETA => format!("θ_i = {}°", short(light.theta_i.to_degrees())),
            _ => format!("φ_i = {}°", short(light.phi_i.to_degrees())),
        });
        let name = words.collect::<Vec<_>>().join(", ");
        chart.curves.push(Curve::line(name, points(far, &unpolarized(far))));
    }
    chart.legend = "unpolarized".into();
    Ok(chart.draw_on(page))
}

const WAVELENGTH: &str = "wavelength in vacuum (nm)";
const THETA: &str = "longitudinal angle of incidence θ_i (°)";
const PHI: &str = "azimuth of incidence φ_i (°)";

/// The axes with more than one value.
fn varied(illuminations: &Illuminations) -> Vec<Varied> {
    let degrees = |angles: &[f64]| angles.iter().map(|angle| angle.to_degrees()).collect::<Vec<_>>();
    let all = [
        Varied { label: WAVELENGTH, values: illuminations.wavelengths_nm.clone() },
        Varied { label: THETA, values: degrees(&illuminations.theta_i) },
        Varied { label: PHI, values: degrees(&illuminations.phi_i) },
    ];
    all.into_iter().filter(|axis| axis.values.len() > 1).collect()
}

/// A number without the rounding of radians.
fn short(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn unpolarized(far: &FarField) -> Vec<f64> {
    let [first, second] = Polarization::BOTH.map(|p| far.per_radian(p));
    first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b)).collect()
}

fn points(far: &FarField, values: &[f64]) -> Vec<[f64; 2]> {
    far.azimuths.phi_o().iter().zip(values).map(|(phi, &value)| [phi.to_degrees(), value]).collect()
}

/// The mean of both polarizations over the azimuth and one axis; each cell shows the nearest far field.
fn map(title: &str, azimuth: Axis, axis: &Varied, quantity: &str, found: &[Scattered]) -> HeatMap {
    let mut order: Vec<usize> = (0..axis.values.len()).collect();
    order.sort_by(|a, b| axis.values[*a].total_cmp(&axis.values[*b]));
    let sorted: Vec<f64> = order.iter().map(|at| axis.values[*at]).collect();
    let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
    let rows: Vec<Vec<f64>> = found.iter().map(|found| unpolarized(&found.far)).collect();
    let mut values = Vec::with_capacity(CELLS[0] * CELLS[1]);
    for j in 0..CELLS[1] {
        let at = low + (high - low) * (j as f64 + 0.5) / CELLS[1] as f64;
        let after = sorted.partition_point(|value| *value < at).min(sorted.len() - 1);
        let nearest =
            if after > 0 && at - sorted[after - 1] < sorted[after] - at { after - 1 } else { after };
        let row = &rows[order[nearest]];
        values.extend((0..CELLS[0]).map(|i| row[i * row.len() / CELLS[0]]));
    }
    let end = match found.first().map(|found| found.far.azimuths) {
        Some(Azimuths::FullCircle(_)) => 180.0,
        _ => 90.0,
    };
    let azimuth = Axis::with_range(azimuth.label, -end, end);
    let mut map = HeatMap::new(title, azimuth, Axis::with_range(axis.label, low, high), CELLS[0], values);
    map.label = format!("{quantity}, unpolarized");
    map
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Format;
    use crate::progress::Unobserved;
    use crate::scattering::far_field::Window;
    use crate::solve::FAST;
    use crate::solve::far_fields::Settings;
    use crate::structure::Structure;

    fn drawn(wavelengths: usize, phi_i: &[f64], window: Window) -> Result<String> {
        let sweep = Illuminations {
            wavelengths_nm: (0..wavelengths).map(|i| 400.0 + 10.0 * i as f64).collect(),
            theta_i: vec![0.0],
            phi_i: phi_i.to_vec(),
            window,
        };
        check_far_fields(&sweep)?;
        let section = Structure::flat("air/keratin:300/air").unwrap().instance(1, 0).unwrap();
        let solver = (FAST.solver)(&Settings::default());
        let found = solver.prepare(&section).unwrap().scatter(&sweep, 40, &Unobserved).unwrap();
        let bytes = far_fields("a title", &sweep, &found, &Page::default())?.encode(Format::Svg, &[])?;
        Ok(String::from_utf8(bytes).unwrap())
    }

    #[test]
    fn few_are_curves_with_their_names_and_many_along_one_axis_a_map() {
        let one = drawn(1, &[0.0], Window::Gaussian).unwrap();
        assert!(one.contains("polarization 2") && one.contains("intensity (1/rad)"), "{one}");
        let some = drawn(2, &[0.0, 0.5235987755982988], Window::PlaneWave).unwrap();
        assert!(
            some.contains("410 nm, φ_i = 30°") && some.contains("differential scattering width (µm/rad)")
        );
        let many = drawn(20, &[0.0], Window::Gaussian).unwrap();
        assert!(
            many.contains("wavelength in vacuum (nm)") && many.contains("intensity (1/rad), unpolarized")
        );
        let error = drawn(20, &[0.0, 0.5], Window::Gaussian).unwrap_err();
        assert!(error.is_input() && error.to_string().starts_with("40 far fields"), "{error}");
    }
}
