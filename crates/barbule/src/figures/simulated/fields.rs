//! A single barbule's field over x_o.

use serde::Serialize;

use super::super::three;
use super::ghost;
use crate::Result;
use crate::brdf::{FeatherBrdf, FeatherMaterial, Options, marginals};
use crate::characterize::Barbules;
use crate::plot::{Axis, Curve, Drawing, Figure, style};
use crate::progress::{Progress, Unobserved};
use crate::scattering::directions::omega;
use crate::scattering::far_field::Polarization;
use crate::scattering::statistics::Axes;
use crate::spectrum::Wavelengths;

/// φ_i of the patterns at the shortest wavelength, degrees; their cosines rise.
const ANGLES: [f64; 3] = [40.0, 20.0, 0.0];

/// The real part R of the field of barbule 0 in polarization 1 over x_o = cosθ_i sinφ_o at θ_i = 0, 1/√rad.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FieldPatterns {
    /// The shortest wavelength at φ_i = 0°, 20°, 40°.
    pub oblique: Vec<FieldPattern>,
    /// φ_i = 0 at up to three wavelengths.
    pub normal: Vec<FieldPattern>,
    /// At the shortest wavelength and φ_i = 0, weighted for its autocovariance: r = √U′ R, 1/rad.
    pub weighted: Vec<f64>,
}

/// One pattern.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FieldPattern {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// φ_i, degrees.
    pub phi_in_deg: f64,
    /// Outgoing x.
    pub x_out: Vec<f64>,
    /// R, 1/√rad.
    pub r: Vec<f64>,
}

impl FieldPatterns {
    /// Simulates them.
    ///
    /// # Errors
    /// As [`Barbules::campaign`].
    pub fn new(material: &FeatherMaterial, barbules: &Barbules, progress: &dyn Progress) -> Result<Self> {
        let waves = three(material.axes.wavelengths_nm().len());
        let nm: Vec<f64> = waves.iter().map(|k| material.axes.wavelengths_nm()[*k]).collect();
        let cos_phi = ANGLES.iter().map(|a| a.to_radians().cos()).collect();
        let axes = Axes::new(&Wavelengths::new(nm.clone())?, vec![1.0], cos_phi)?;
        let campaign = barbules.campaign(axes, Some(1), false, progress)?;
        let mut found = Self { oblique: Vec::new(), normal: Vec::new(), weighted: Vec::new() };
        for (wave, wavelength_nm) in nm.into_iter().enumerate() {
            let tables = campaign.tables(wave, progress)?;
            for (phi, phi_in_deg) in ANGLES.into_iter().enumerate().rev() {
                if wave > 0 && phi_in_deg > 0.0 {
                    continue;
                }
                let mut patterns = campaign.patterns(&tables, 0, phi, Polarization::First, progress)?;
                let pattern = FieldPattern {
                    wavelength_nm,
                    phi_in_deg,
                    x_out: patterns.x.clone(),
                    r: patterns.fields[0].iter().map(|field| field.re).collect(),
                };
                if phi_in_deg == 0.0 {
                    if wave == 0 {
                        // One barbule's own intensity is no lobe: the weight is the material's.
                        let brdf = FeatherBrdf::new(&material.around(&[wavelength_nm])?, Options::default())?;
                        let normal = omega(0.0, 0.0);
                        let mut fitted =
                            marginals(&brdf, &[wavelength_nm], normal, &patterns.phi_o, None, &Unobserved)?;
                        patterns.fitted = fitted.remove(0).f;
                        found.weighted = patterns.weighted(0).iter().map(|field| field.re).collect();
                    }
                    found.normal.push(pattern.clone());
                }
                if wave == 0 {
                    found.oblique.push(pattern);
                }
            }
        }
        Ok(found)
    }

    /// Left the incident angles, right the wavelengths, grey the first pattern shifted or stretched; below R as it is and
    /// weighted.
    #[must_use]
    pub fn draw(&self) -> Vec<Drawing> {
        let first = &self.normal[0];
        let shortest = first.wavelength_nm;
        let left = self.oblique.iter().map(|pattern| {
            let angle = pattern.phi_in_deg;
            let title = format!("{shortest:.0} nm, φ_i = {angle:.0}°");
            if angle == 0.0 {
                return panel(title, "R (1/√rad)", first.curve("simulated", |x| x), None);
            }
            let moved = first.curve("φ_i = 0°, shifted", |x| x - angle.to_radians().sin());
            let title = format!("{title}: the pattern shifts by −Δx_i");
            panel(title, "R (1/√rad)", pattern.curve("simulated", |x| x), Some(moved))
        });
        let right = self.normal.iter().map(|pattern| {
            let ratio = pattern.wavelength_nm / shortest;
            let title = format!("{:.0} nm, φ_i = 0°", pattern.wavelength_nm);
            if ratio == 1.0 {
                return panel(title, "R (1/√rad)", pattern.curve("simulated", |x| x), None);
            }
            let stretched = first.curve("shortest λ, stretched", |x| x * ratio);
            let title = format!("{title}: the pattern stretches with λ");
            panel(title, "R (1/√rad)", pattern.curve("simulated", |x| x), Some(stretched))
        });
        let title = format!("the field R, {shortest:.0} nm, φ_i = 0°");
        let plain = panel(title, "R (1/√rad)", first.curve("simulated", |x| x), None);
        let weighted = FieldPattern { r: self.weighted.clone(), ..first.clone() };
        let title = "weighted for its autocovariance, r = √U′ R".to_owned();
        let below = panel(title, "r (1/rad)", weighted.curve("simulated", |x| x), None);
        // A material of fewer wavelengths leaves places empty.
        let right = right.chain(std::iter::repeat_with(|| Drawing::new(0.0, 0.0)));
        left.zip(right).flat_map(|(a, b)| [a, b]).chain([plain, below]).collect()
    }
}

impl FieldPattern {
    fn curve(&self, name: &str, place: impl Fn(f64) -> f64) -> Curve {
        let points = self.x_out.iter().zip(&self.r).map(|(x, r)| [place(*x), *r]);
        Curve::line(name, points.collect())
    }
}

fn panel(title: String, label: &str, own: Curve, below: Option<Curve>) -> Drawing {
    let mut figure = Figure::new(title, Axis::with_range("x_o", -1.0, 1.0), Axis::new(label));
    figure.size = [520.0, 150.0];
    figure.curves.extend(below.map(|curve| Curve { stroke: ghost(), ..curve }));
    figure.curves.push(Curve { stroke: Some(style(0)), ..own });
    figure.draw()
}
