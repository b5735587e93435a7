//! A material's BRDF over the hemisphere, and its parameters.

use crate::Result;
use crate::brdf::pictures::hemisphere;
use crate::brdf::{FeatherBrdf, FeatherMaterial, Options, lobe_integral};
use crate::plot::{Anchor, Axis, Drawing, HeatMap, Item, Map, Picture};
use crate::scattering::directions::omega;
use crate::scattering::lobe::Lobe;
use crate::spectrum::colour::{display, luminance};

/// Incident directions of the hemispheres, θ_i and φ_i in degrees.
const INCIDENT: [(f64, f64); 7] =
    [(0.0, 0.0), (0.0, 30.0), (0.0, 60.0), (0.0, 80.0), (40.0, 0.0), (40.0, 40.0), (70.0, 0.0)];

/// Pixels across a hemisphere, and its size on the page.
const PIXELS: usize = 240;
const SIZE: f64 = 120.0;

/// Species and variant as the material's maker recorded them.
#[must_use]
pub fn title(material: &FeatherMaterial) -> String {
    let word = |key: &str| material.info.get(key).and_then(|v| v.as_str()).unwrap_or("").to_owned();
    format!("{} {}", word("species"), word("variant")).trim().to_owned()
}

/// The smooth lobe and instances (rows) for incident directions (columns), with one exposure per column.
///
/// # Errors
/// The material fails its checks.
pub fn hemispheres(material: &FeatherMaterial, instances: usize) -> Result<Drawing> {
    let brdf = FeatherBrdf::new(material, Options::default())?;
    let (left, top) = (86.0, 52.0);
    let rows = instances + 1;
    let width = left + INCIDENT.len() as f64 * (SIZE + 8.0) + 8.0;
    let mut drawing = Drawing::new(width, top + rows as f64 * (SIZE + 8.0) + 8.0);
    let title = format!("{}: f over outgoing directions, x right, y up", title(material));
    drawing.text([8.0, 18.0], 14.0, Anchor::Start, title.trim_start_matches(": ").to_owned());
    for (column, (theta, phi)) in INCIDENT.into_iter().enumerate() {
        let x = left + column as f64 * (SIZE + 8.0);
        let wi = omega(theta.to_radians(), phi.to_radians());
        drawing.text([x + SIZE / 2.0, top - 8.0], 11.0, Anchor::Middle, format!("θ {theta}°, φ {phi}°"));
        let smooth = hemisphere(&brdf, wi, None, PIXELS)?;
        let brightest = smooth.iter().flatten().map(|rgb| luminance(*rgb)).fold(0.0, f64::max);
        let exposure = if brightest > 0.0 { 0.8 / brightest } else { 0.0 };
        for row in 0..rows {
            let y = top + row as f64 * (SIZE + 8.0);
            let values =
                if row == 0 { smooth.clone() } else { hemisphere(&brdf, wi, Some(row as u64), PIXELS)? };
            let rgba = values.iter().map(|value| pixel(*value, exposure)).collect();
            let picture = Picture { width: PIXELS, height: PIXELS, rgba };
            drawing.items.push(Item::Picture { area: [x, y, SIZE, SIZE], picture });
        }
    }
    for row in 0..rows {
        let y = top + row as f64 * (SIZE + 8.0) + SIZE / 2.0;
        let text = if row == 0 { "mean".to_owned() } else { format!("instance {row}") };
        drawing.text([left - 8.0, y], 11.0, Anchor::End, text);
    }
    Ok(drawing)
}

/// sRGB and opacity; outside the hemisphere nothing.
fn pixel(value: Option<[f64; 3]>, exposure: f64) -> [u8; 4] {
    value.map_or([0; 4], |rgb| {
        let [r, g, b] = display(rgb.map(|v| v * exposure));
        [r, g, b, 255]
    })
}

/// Maps of the parameters at the shortest, the middle and the longest wavelength.
///
/// # Errors
/// σ or a lobe of the material is out of range.
pub fn parameters(material: &FeatherMaterial) -> Result<Vec<Drawing>> {
    let axes = &material.axes;
    let waves = super::three(axes);
    let columns = axes.cos_phi().len();
    let per_wave = axes.cos_theta().len() * columns;
    let mut maps = Vec::new();
    for &wave in &waves {
        let lobe = &material.sets[0].mean;
        let nm = axes.wavelengths_nm()[wave];
        let node = |at: usize| {
            let (theta, phi_i) = (axes.theta_i(at / columns), axes.phi_i(at % columns));
            let shape = Lobe {
                m: f64::from(lobe.m[wave * per_wave + at]),
                phi: f64::from(lobe.phi[wave * per_wave + at]),
            };
            (theta, phi_i, shape, f64::from(lobe.reflected[wave * per_wave + at]))
        };
        let m = (0..per_wave).map(|at| node(at).2.m).collect();
        let phi = (0..per_wave)
            .map(|at| {
                let (_, phi_i, shape, _) = node(at);
                (shape.phi - phi_i).to_degrees()
            })
            .collect();
        let f = (0..per_wave)
            .map(|at| {
                let (theta, _, shape, reflected) = node(at);
                Ok((reflected / lobe_integral(shape, theta, material.sigma)?).max(1e-6).log10())
            })
            .collect::<Result<Vec<f64>>>()?;
        for (label, values) in [("m_eff", m), ("φ_eff − φ_i (°)", phi), ("log₁₀ F_eff", f)] {
            let signed = values.iter().any(|v| *v < 0.0) && label.contains('°');
            let largest = values.iter().fold(0.1, |a: f64, v| a.max(v.abs()));
            let mut map = HeatMap::new(
                format!("{label}, {nm:.0} nm"),
                Axis::with_range("cosφ_i", axes.cos_phi()[0], axes.cos_phi()[columns - 1]),
                Axis::with_range("cosθ_i", axes.cos_theta()[0], axes.cos_theta()[axes.cos_theta().len() - 1]),
                columns,
                values,
            );
            map.size = [240.0, 240.0];
            if signed {
                // White where the lobe's azimuth is the mirror direction's.
                (map.map, map.range) = (Map::Diverging, Some([-largest, largest]));
            }
            maps.push(map.draw());
        }
    }
    Ok(maps)
}

/// Drawings in rows of `columns`, under a title.
#[must_use]
pub fn tiled(drawings: Vec<Drawing>, columns: usize, heading: &str) -> Drawing {
    let width = drawings.iter().map(|d| d.width).fold(0.0, f64::max);
    let height = drawings.iter().map(|d| d.height).fold(0.0, f64::max);
    let rows = drawings.len().div_ceil(columns);
    let mut page = Drawing::new(width * columns as f64, 28.0 + height * rows as f64);
    page.text([8.0, 18.0], 14.0, Anchor::Start, heading);
    for (k, drawing) in drawings.into_iter().enumerate() {
        page.place(drawing, [(k % columns) as f64 * width, 28.0 + (k / columns) as f64 * height]);
    }
    page
}
