//! What single barbules do at one wavelength and direction, beside what their statistics say.

use num_complex::Complex64;

use super::covariance::Covariance;
use super::reduce::{NoiseGrid, components, widen};
use super::{Campaign, WavelengthTables};
use crate::Result;
use crate::progress::Progress;
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::{FitKind, fit};
use crate::scattering::statistics::AZIMUTHS;

/// The fields of all instances over x_o, for one wavelength, incident direction and polarization.
#[derive(Debug, Clone, PartialEq)]
pub struct Patterns {
    /// x_o = cosθ_i sinφ_o: those of the points of S.44 that lie on the cone.
    pub x: Vec<f64>,
    /// φ_o of these, rad.
    pub phi_o: Vec<f64>,
    /// The component of the field with more energy over √Φ_i, `[instance][x_o]`.
    pub fields: Vec<Vec<Complex64>>,
    /// U' of the lobe fitted to the mean intensity of the instances, at the same points.
    pub fitted: Vec<f64>,
}

impl Campaign {
    /// The fields at one wavelength for θ_i and φ_i number `theta` and `phi` of the axes.
    ///
    /// # Errors
    /// A stop by `progress`.
    pub fn patterns(
        &self,
        tables: &WavelengthTables,
        theta: usize,
        phi: usize,
        polarization: Polarization,
        progress: &dyn Progress,
    ) -> Result<Patterns> {
        let fields = self.fields(tables, theta, progress)?;
        let theta_i = fields.theta_i;
        let phi_i = self.parameters.axes.phi_i(phi);
        let grid = NoiseGrid::new(theta_i, fields.refine);
        let pair = 2 * phi + polarization.index();
        let on_grid = |component: usize| -> Vec<Vec<Complex64>> {
            (0..fields.values.len())
                .map(|instance| {
                    let parts = components(&fields, instance, pair);
                    let field = if component == 0 { parts.0 } else { parts.1 };
                    grid.points.iter().map(|point| widen(point.interpolate(field))).collect()
                })
                .collect()
        };
        let both = [on_grid(0), on_grid(1)];
        let energy = |part: &[Vec<Complex64>]| part.iter().flatten().map(Complex64::norm_sqr).sum::<f64>();
        let [first, second] = both;
        let larger = if energy(&second) > energy(&first) { second } else { first };
        let u = super::reduce::mean_intensity(&fields, pair);
        let lobe = fit(FitKind::Marginal, theta_i, phi_i, &u);
        let shape = |phi_o: f64| lobe.scale * lobe.lobe.shape(FitKind::Marginal, theta_i, phi_o);
        Ok(Patterns {
            x: grid.points.iter().map(|p| theta_i.cos() * p.phi_o.sin()).collect(),
            phi_o: grid.points.iter().map(|p| p.phi_o).collect(),
            fitted: grid.points.iter().map(|p| shape(p.phi_o).max(0.0)).collect(),
            fields: larger,
        })
    }
}

impl Patterns {
    /// r = √U' · 𝓔 of S.29, `[x_o]`.
    #[must_use]
    pub fn weighted(&self, instance: usize) -> Vec<Complex64> {
        self.fields[instance].iter().zip(&self.fitted).map(|(value, u)| value * u.sqrt()).collect()
    }

    /// The autocovariance C_m of S.30 of one instance at lags 0 … [`LAGS`](crate::scattering::statistics::LAGS) − 1, mean of the real and the imaginary part.
    #[must_use]
    pub fn autocovariance(&self, instance: usize) -> Vec<f64> {
        autocovariance(&self.weighted(instance))
    }
}

/// S.30 of values on consecutive points of S.44; zero elsewhere.
#[must_use]
pub fn autocovariance(values: &[Complex64]) -> Vec<f64> {
    let covariance = Covariance::<f64>::new(values.len());
    let mut sum = covariance.sum();
    sum.add(values.iter().copied());
    sum.mean()
}

/// Intensities of unpolarized light c₀|𝓔|²/Φ_i from the fields that a unit keeps, `[instance][AZIMUTHS]`, of φ_i number
/// `phi`.
#[must_use]
pub fn intensities(kept: &[num_complex::Complex<f32>], phi: usize, instances: usize) -> Vec<Vec<f64>> {
    (0..instances)
        .map(|instance| {
            let mut sum = vec![0.0; AZIMUTHS];
            for part in 0..4 {
                let start = ((phi * 4 + part) * instances + instance) * AZIMUTHS;
                for (sum, value) in sum.iter_mut().zip(&kept[start..start + AZIMUTHS]) {
                    *sum += 0.5 * f64::from(value.norm_sqr());
                }
            }
            sum
        })
        .collect()
}
