//! A material's BRDF over the hemisphere, and its parameters.

use serde::Serialize;

use crate::Result;
use crate::brdf::pictures::hemisphere;
use crate::brdf::{FeatherBrdf, FeatherMaterial, Options, lobe_integral};
use crate::error::shortened;
use crate::plot::{Anchor, Axis, Drawing, HeatMap, Item, Map, Picture};
use crate::scattering::directions::omega;
use crate::scattering::lobe::Lobe;
use crate::spectrum::colour::{display, luminance};

/// Incident directions of the hemispheres, θ_i and φ_i in degrees.
const INCIDENT: [(f64, f64); 7] =
    [(0.0, 0.0), (0.0, 30.0), (0.0, 60.0), (0.0, 80.0), (40.0, 0.0), (40.0, 40.0), (70.0, 0.0)];

/// Size of a hemisphere on the page.
const SIZE: f64 = 120.0;

/// Species and variant as the material's maker recorded them, or the name of what is no species, and whether its campaign was thinned.
#[must_use]
pub fn title(material: &FeatherMaterial) -> String {
    let word = |key: &str| material.info.get(key).and_then(|v| v.as_str()).unwrap_or_default();
    let thinned = if material.info["campaign"]["thinned"].is_number() { "(thinned)" } else { "" };
    // Stacks and given sections are no species.
    let name = if word("species").is_empty() { shortened(word("name")) } else { word("species").to_owned() };
    [name.as_str(), word("variant"), thinned]
        .into_iter()
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// f in colour over the outgoing hemisphere seen from above, of the smooth mean and of instances.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hemispheres {
    /// θ_i of each incident direction, degrees.
    pub theta_in_deg: Vec<f64>,
    /// φ_i of each incident direction, degrees.
    pub phi_in_deg: Vec<f64>,
    /// x of ω_o at the centres of the pixels of a row.
    pub x_out: Vec<f64>,
    /// y of ω_o at the rows, falling: the first is the uppermost.
    pub y_out: Vec<f64>,
    /// Linear sRGB of the mean, `[incident][y][x]`; a perfect white diffuser has 1/π, `None` lies outside the hemisphere.
    pub mean: Vec<Vec<Vec<Rgb>>>,
    /// The same of instances 0, 1 …, `[instance][incident][y][x]`.
    pub instances: Vec<Vec<Vec<Vec<Rgb>>>>,
}

/// Linear sRGB.
type Rgb = Option<[f32; 3]>;

impl Hemispheres {
    /// `pixels` × `pixels` to each hemisphere.
    ///
    /// # Errors
    /// The material fails its checks.
    pub fn new(material: &FeatherMaterial, instances: usize, pixels: usize) -> Result<Self> {
        let brdf = FeatherBrdf::new(material, Options::default())?;
        let of = |instance: Option<u64>| -> Result<Vec<Vec<Vec<Rgb>>>> {
            let one = |(theta, phi): (f64, f64)| {
                let wi = omega(theta.to_radians(), phi.to_radians());
                let single = |rgb: [f64; 3]| rgb.map(|v| v as f32);
                let values = hemisphere(&brdf, wi, instance, pixels)?;
                Ok(values.chunks(pixels).map(|row| row.iter().map(|v| v.map(single)).collect()).collect())
            };
            INCIDENT.into_iter().map(one).collect()
        };
        let centre = |k: usize| (2 * k + 1) as f64 / pixels as f64 - 1.0;
        let x_out: Vec<f64> = (0..pixels).map(centre).collect();
        Ok(Self {
            theta_in_deg: INCIDENT.iter().map(|(theta, _)| *theta).collect(),
            phi_in_deg: INCIDENT.iter().map(|(_, phi)| *phi).collect(),
            y_out: x_out.iter().rev().copied().collect(),
            x_out,
            mean: of(None)?,
            instances: (0..instances).map(|k| of(Some(k as u64))).collect::<Result<_>>()?,
        })
    }

    /// Rows of the mean and the instances, columns of incident directions, with one exposure per column.
    #[must_use]
    pub fn draw(&self, title: &str) -> Drawing {
        let (left, top) = (86.0, 52.0);
        let rows = self.instances.len() + 1;
        let width = left + self.mean.len() as f64 * (SIZE + 8.0) + 8.0;
        let mut drawing = Drawing::new(width, top + rows as f64 * (SIZE + 8.0) + 8.0);
        let title = format!("{title}: f over outgoing directions, x right, y up");
        drawing.text([8.0, 18.0], 14.0, Anchor::Start, title.trim_start_matches(": ").to_owned());
        for (column, mean) in self.mean.iter().enumerate() {
            let x = left + column as f64 * (SIZE + 8.0);
            let (theta, phi) = (self.theta_in_deg[column], self.phi_in_deg[column]);
            drawing.text([x + SIZE / 2.0, top - 8.0], 11.0, Anchor::Middle, format!("θ {theta}°, φ {phi}°"));
            let lit = |rgb: &[f32; 3]| luminance(rgb.map(f64::from));
            let brightest = mean.iter().flatten().flatten().map(lit).fold(0.0, f64::max);
            let exposure = if brightest > 0.0 { 0.8 / brightest } else { 0.0 };
            let below = self.instances.iter().map(|instance| &instance[column]);
            for (row, values) in std::iter::once(mean).chain(below).enumerate() {
                let y = top + row as f64 * (SIZE + 8.0);
                let rgba = values.iter().flatten().map(|value| pixel(*value, exposure)).collect();
                let picture = Picture { width: self.x_out.len(), height: self.y_out.len(), rgba };
                drawing.items.push(Item::Picture { area: [x, y, SIZE, SIZE], picture });
            }
        }
        for row in 0..rows {
            let y = top + row as f64 * (SIZE + 8.0) + SIZE / 2.0;
            let text =
                row.checked_sub(1).map_or("mean".to_owned(), |instance| format!("instance {instance}"));
            drawing.text([left - 8.0, y], 11.0, Anchor::End, text);
        }
        drawing
    }
}

/// sRGB and opacity; outside the hemisphere nothing.
fn pixel(value: Rgb, exposure: f64) -> [u8; 4] {
    value.map_or([0; 4], |rgb| {
        let [r, g, b] = display(rgb.map(|v| f64::from(v) * exposure));
        [r, g, b, 255]
    })
}

/// The parameters of the larger mean lobes at every wavelength, each `[wavelength][theta_in][phi_in]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterMaps {
    /// The wavelengths, nm.
    pub wavelength_nm: Vec<f64>,
    /// cosθ_i of the rows, rising.
    pub cos_theta_in: Vec<f64>,
    /// cosφ_i of the columns, rising.
    pub cos_phi_in: Vec<f64>,
    /// Roughness m_eff.
    pub m: Vec<Vec<Vec<f64>>>,
    /// φ_eff − φ_i, degrees.
    pub phi_shift_deg: Vec<Vec<Vec<f64>>>,
    /// F_eff.
    pub f: Vec<Vec<Vec<f64>>>,
    /// What the second lobe reflects, as a part of what both do.
    pub second: Vec<Vec<Vec<f64>>>,
}

impl ParameterMaps {
    /// Of a material; of one with separate polarizations those of the first.
    ///
    /// # Errors
    /// σ or a lobe of the material is out of range.
    pub fn new(material: &FeatherMaterial) -> Result<Self> {
        let axes = &material.axes;
        let set = &material.sets[0];
        let lobe = &set.mean[0];
        let map = |value: &dyn Fn(usize, usize, usize) -> Result<f64>| -> Result<Vec<Vec<Vec<f64>>>> {
            let row =
                |wave, theta| (0..axes.cos_phi().len()).map(move |phi| value(wave, theta, phi)).collect();
            let layer = |wave| (0..axes.cos_theta().len()).map(|theta| row(wave, theta)).collect();
            (0..axes.wavelengths_nm().len()).map(layer).collect()
        };
        let shape = |at: usize| Lobe { m: f64::from(lobe.m[at]), phi: f64::from(lobe.phi[at]) };
        Ok(Self {
            wavelength_nm: axes.wavelengths_nm().to_vec(),
            cos_theta_in: axes.cos_theta().to_vec(),
            cos_phi_in: axes.cos_phi().to_vec(),
            m: map(&|w, t, p| Ok(shape(axes.index(w, t, p)).m))?,
            phi_shift_deg: map(&|w, t, p| Ok((shape(axes.index(w, t, p)).phi - axes.phi_i(p)).to_degrees()))?,
            f: map(&|w, t, p| {
                let at = axes.index(w, t, p);
                let integral = lobe_integral(shape(at), axes.theta_i(t), material.sigma)?;
                Ok(f64::from(lobe.reflected[at]) / integral)
            })?,
            second: map(&|w, t, p| {
                let at = axes.index(w, t, p);
                let second = set.mean.get(1).map_or(0.0, |lobe| f64::from(lobe.reflected[at]));
                Ok(second / set.reflected(at).max(f64::MIN_POSITIVE))
            })?,
        })
    }

    /// Rows of the shortest, the middle and the longest wavelength, columns of parameters.
    #[must_use]
    pub fn draw(&self) -> Vec<Drawing> {
        let flat = |map: &[Vec<f64>]| -> Vec<f64> { map.iter().flatten().copied().collect() };
        let axis = |label: &str, cosines: &[f64]| {
            Axis::with_range(label, cosines[0], cosines.last().copied().unwrap_or(1.0))
        };
        let mut maps = Vec::new();
        for wave in super::three(self.wavelength_nm.len()) {
            let nm = self.wavelength_nm[wave];
            let f = flat(&self.f[wave]).into_iter().map(|f| f.max(1e-6).log10()).collect();
            for (label, values) in [
                ("m_eff", flat(&self.m[wave])),
                ("φ_eff − φ_i (°)", flat(&self.phi_shift_deg[wave])),
                ("log₁₀ F_eff", f),
                ("second lobe ρ₂/ρ", flat(&self.second[wave])),
            ] {
                let signed = values.iter().any(|v| *v < 0.0) && label.contains('°');
                let largest = values.iter().fold(0.1, |a: f64, v| a.max(v.abs()));
                let mut map = HeatMap::new(
                    format!("{label}, {nm:.0} nm"),
                    axis("cosφ_i", &self.cos_phi_in),
                    axis("cosθ_i", &self.cos_theta_in),
                    self.cos_phi_in.len(),
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
        maps
    }
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::brdf::fixtures::example;

    #[test]
    fn titles_name_species_and_whatever_else_was_simulated() {
        for (info, expected) in [
            (json!({"species": "starling", "variant": "green", "name": "starling:green"}), "starling green"),
            (json!({"species": "", "name": "air/keratin:300/air"}), "air/keratin:300/air"),
            (json!({"name": "mine.json", "campaign": {"thinned": 3}}), "mine.json (thinned)"),
            (json!({}), ""),
        ] {
            assert_eq!(title(&FeatherMaterial { info, ..example(3) }), expected);
        }
    }
}
