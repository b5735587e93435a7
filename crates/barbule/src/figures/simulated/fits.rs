//! Simulated and fitted U and V.

use serde::Serialize;

use super::super::three;
use super::{PER_RADIAN, nearest};
use crate::Result;
use crate::brdf::{FeatherBrdf, FeatherMaterial, Options, marginals};
use crate::campaign::statistics;
use crate::characterize::Barbules;
use crate::plot::{Axis, Curve, Drawing, Figure};
use crate::progress::{Progress, Unobserved};
use crate::scattering::directions::{azimuths, omega};
use crate::scattering::statistics::{AZIMUTHS, Axes, Statistics};
use crate::spectrum::Wavelengths;

/// φ_i of the fits by their places on the axes: those nearest to 70° and 0°.
fn fitted_phis(axes: &Axes) -> Vec<usize> {
    let mut phis = vec![nearest(axes.cos_phi(), 70.0_f64.to_radians().cos()), nearest(axes.cos_phi(), 1.0)];
    phis.dedup();
    phis
}

/// The statistics that [`FitCurves`] draws, of a material whose store is gone: simulated again.
///
/// # Errors
/// As [`Barbules::campaign`].
pub fn statistics_of_fits(
    material: &FeatherMaterial,
    barbules: &Barbules,
    progress: &dyn Progress,
) -> Result<Statistics> {
    let from = &material.axes;
    let nm: Vec<f64> =
        three(from.wavelengths_nm().len()).into_iter().map(|k| from.wavelengths_nm()[k]).collect();
    let cos_theta = vec![from.cos_theta()[from.cos_theta().len() - 1]];
    let cos_phi = fitted_phis(from).iter().map(|k| from.cos_phi()[*k]).collect();
    let axes = Axes::new(&Wavelengths::new(nm)?, cos_theta, cos_phi)?;
    statistics(&barbules.campaign(axes, None, true, progress)?, progress)
}

/// Simulated and fitted U and V over φ_o at one wavelength and incident direction, 1/rad, mean over the polarizations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitCurves {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// θ_i, degrees.
    pub theta_in_deg: f64,
    /// φ_i, degrees.
    pub phi_in_deg: f64,
    /// φ_o of the curves, degrees.
    pub phi_out_deg: Vec<f64>,
    /// Mean intensity U.
    pub u_simulated: Vec<f64>,
    /// U′ of the fitted lobe.
    pub u_fitted: Vec<f64>,
    /// Intensity V of the mean field.
    pub v_simulated: Vec<f64>,
    /// The steady part s, fitted to V or to more.
    pub s_fitted: Vec<f64>,
}

impl FitCurves {
    /// At θ_i nearest to 0 and φ_i nearest to 0° and 70°, at three wavelengths.
    ///
    /// # Errors
    /// The material cannot be prepared.
    pub fn of(material: &FeatherMaterial, statistics: &Statistics) -> Result<Vec<Self>> {
        let axes = &material.axes;
        let brdf = FeatherBrdf::new(material, Options::default())?;
        let theta = axes.cos_theta().len() - 1;
        let found = &statistics.axes;
        let at = |wave: usize, phi: usize| {
            let place = found.index(
                nearest(found.wavelengths_nm(), axes.wavelengths_nm()[wave]),
                nearest(found.cos_theta(), axes.cos_theta()[theta]),
                nearest(found.cos_phi(), axes.cos_phi()[phi]),
            );
            let wi = omega(axes.theta_i(theta), axes.phi_i(phi));
            let phi_out: Vec<f64> = azimuths(AZIMUTHS).collect();
            let fitted =
                marginals(&brdf, &[axes.wavelengths_nm()[wave]], wi, &phi_out, None, &Unobserved)?.remove(0);
            Ok(Self {
                wavelength_nm: axes.wavelengths_nm()[wave],
                theta_in_deg: axes.theta_i(theta).to_degrees(),
                phi_in_deg: axes.phi_i(phi).to_degrees(),
                phi_out_deg: azimuths(AZIMUTHS).map(f64::to_degrees).collect(),
                u_simulated: mean_over_polarizations(&statistics.u, place),
                u_fitted: fitted.f,
                v_simulated: mean_over_polarizations(&statistics.v, place),
                s_fitted: fitted.steady,
            })
        };
        let phis = fitted_phis(axes);
        three(axes.wavelengths_nm().len())
            .iter()
            .flat_map(|&wave| phis.iter().rev().map(move |&phi| (wave, phi)))
            .map(|(w, p)| at(w, p))
            .collect()
    }

    /// The four curves.
    #[must_use]
    pub fn draw(&self) -> Drawing {
        let title = format!(
            "{:.0} nm, θ_i = {:.0}°, φ_i = {:.0}°",
            self.wavelength_nm, self.theta_in_deg, self.phi_in_deg
        );
        let mut figure = Figure::new(title, Axis::with_range("φ_o (°)", -90.0, 90.0), Axis::new(PER_RADIAN));
        figure.size = [420.0, 230.0];
        for (name, values) in [
            ("U (simulated)", &self.u_simulated),
            ("U′ (fitted)", &self.u_fitted),
            ("V (simulated)", &self.v_simulated),
            ("s (steady part)", &self.s_fitted),
        ] {
            let points = self.phi_out_deg.iter().zip(values).map(|(x, y)| [*x, *y]);
            figure.curves.push(Curve::line(name, points.collect()));
        }
        figure.draw()
    }
}

fn mean_over_polarizations(array: &[f32], node: usize) -> Vec<f64> {
    let part = |p: usize| &array[(node * 2 + p) * AZIMUTHS..][..AZIMUTHS];
    part(0).iter().zip(part(1)).map(|(a, b)| 0.5 * f64::from(a + b)).collect()
}
