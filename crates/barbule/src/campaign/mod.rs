//! Many illuminations of many instances: from a structure to the statistics that its BRDF is made of.
//!
//! A unit of work is one (λ, θ_i): all φ_i, polarizations and instances. Its fields stay in memory, their statistics
//! are formed in instance order (so that bits do not depend on threads), and the fields are dropped.

mod reduce;
mod run;
pub mod single;
pub mod spectrum;

pub use run::{Outcome, run, statistics};

use std::sync::Arc;

use num_complex::Complex;
use rayon::prelude::*;

use crate::math::rng::Stream;
use crate::math::simd::Width;
use crate::observer::Observer;
use crate::scattering::directions::AZIMUTH_MARGIN;
use crate::scattering::statistics::{AZIMUTHS, Axes, Unit};
use crate::solve::surface::{
    CAMPAIGN_ELEMENT_UM, Cone, Nodes, Surface, Window, Workspace, inverse_root, refinement,
};
use crate::structure::Structure;
use crate::{Error, Result};

/// Stream path of the permutation that spreads tilts over instances.
const TILT_STREAM: u64 = 0x7469_6c74;

/// What a campaign simulates.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// Wavelengths and directions.
    pub axes: Axes,
    /// Number of instances M.
    pub instances: usize,
    /// Seed of instances and tilts.
    pub seed: u64,
    /// Largest tilt of an instance about y, rad.
    pub tilt: f64,
}

impl Parameters {
    /// The tilt δ_m of each instance, rad: (−1 + 2π(m)/(M−1))·tilt with π a random permutation of 0 … M − 1.
    #[must_use]
    pub fn tilts(&self) -> Vec<f64> {
        let order = Stream::new(self.seed, &[TILT_STREAM]).permutation(self.instances);
        let last = self.instances.saturating_sub(1).max(1) as f64;
        if self.instances == 1 {
            return vec![0.0];
        }
        order.into_iter().map(|rank| (2.0 * rank as f64 / last - 1.0) * self.tilt).collect()
    }
}

/// A structure's instances, prepared for any unit of work.
pub struct Campaign {
    parameters: Parameters,
    surfaces: Vec<Arc<Surface>>,
    tilts: Vec<f64>,
    width: Width,
}

/// Fields of one unit: `[instance][φ_i][polarization][e₁, e₂][azimuth with margins]`, over √Φ_i.
pub(crate) struct Fields {
    pub(crate) values: Vec<Vec<Complex<f32>>>,
    /// Values per (φ_i, polarization, component).
    pub(crate) points: usize,
    /// How many times finer than [`AZIMUTHS`] the azimuths are.
    pub(crate) refine: usize,
}

impl Campaign {
    /// Generates the instances and casts their layers; a single given section serves all instances, which then differ
    /// by their tilts only.
    ///
    /// # Errors
    /// An instance cannot be made, or a medium's table does not cover the wavelengths.
    pub fn new(
        structure: &Structure,
        parameters: Parameters,
        width: Width,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let distinct = if structure.count() == Some(1) { 1 } else { parameters.instances };
        observer.begin("preparing instances", distinct as u64);
        let mut surfaces = (0..distinct)
            .into_par_iter()
            .map(|instance| {
                if observer.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let section = structure.instance(parameters.seed, instance)?;
                let surface = Surface::new(&section, CAMPAIGN_ELEMENT_UM, Window::Gaussian)?;
                observer.advance(1);
                Ok(Arc::new(surface))
            })
            .collect::<Result<Vec<_>>>()?;
        if let [only] = &surfaces[..] {
            surfaces = vec![only.clone(); parameters.instances];
        }
        if let (Some(surface), Some(first), Some(last)) =
            (surfaces.first(), parameters.axes.wavelengths_nm.first(), parameters.axes.wavelengths_nm.last())
        {
            // Tables that do not reach are refused before any work.
            surface.optics::<f32>(*first)?;
            surface.optics::<f32>(*last)?;
        }
        let tilts = parameters.tilts();
        Ok(Self { parameters, surfaces, tilts, width })
    }

    /// What is simulated.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The fields of one (λ, θ_i).
    pub(crate) fn fields(&self, wavelength: usize, theta: usize) -> Result<(Fields, Cone)> {
        let axes = &self.parameters.axes;
        let wavelength_nm = axes.wavelengths_nm[wavelength];
        let theta_i = axes.cos_theta[theta].clamp(0.0, 1.0).acos();
        let phi_i: Vec<f64> = axes.cos_phi.iter().map(|c| c.clamp(0.0, 1.0).acos()).collect();
        let radius = self.surfaces.iter().fold(0f64, |r, surface| r.max(surface.radius_um));
        let k = std::f64::consts::TAU / (wavelength_nm * 1e-3);
        let cone = Cone::new(k, theta_i, radius);
        let refine = refinement(&cone, AZIMUTHS);
        let values = self
            .surfaces
            .par_iter()
            .zip(&self.tilts)
            .map_init(
                || (Workspace::<f32>::new(self.width), Vec::new(), Vec::new(), Vec::new()),
                |(workspace, coefficients, circle, scratch), (surface, &tilt)| {
                    let optics = surface.optics(wavelength_nm)?;
                    let nodes = Nodes::equidistant(surface, cone.kappa);
                    let turned: Vec<f64> = phi_i.iter().map(|phi| phi + tilt).collect();
                    let scales: Vec<f64> = turned
                        .iter()
                        .map(|&phi| inverse_root(surface.incident_power_um(theta_i, phi)))
                        .collect();
                    workspace.far_fields(surface, &optics, &nodes, &cone, &turned, &scales, coefficients);
                    let synthesis = workspace.synthesis(&cone, AZIMUTHS * refine, AZIMUTH_MARGIN);
                    let points = synthesis.points();
                    let mut fields = vec![Complex::new(0.0, 0.0); coefficients.len() / cone.angles * points];
                    for (component, out) in
                        coefficients.chunks_exact(cone.angles).zip(fields.chunks_exact_mut(points))
                    {
                        synthesis.evaluate(component, tilt, circle, scratch, out);
                        hide_below_horizon(out, tilt, refine);
                    }
                    Ok(fields)
                },
            )
            .collect::<Result<Vec<_>>>()?;
        let points = AZIMUTHS * refine + 2 * AZIMUTH_MARGIN;
        Ok((Fields { values, points, refine }, cone))
    }

    /// The statistics of one (λ, θ_i), with the fields themselves if they are to be kept.
    ///
    /// # Errors
    /// A medium's table does not reach the wavelength.
    pub fn unit(&self, wavelength: usize, theta: usize, keep_fields: bool) -> Result<Unit> {
        let (fields, cone) = self.fields(wavelength, theta)?;
        let mut unit = reduce::unit(&self.parameters.axes, &fields, cone.theta_i);
        if keep_fields {
            unit.fields = reduce::kept(&fields, self.parameters.axes.cos_phi.len());
        }
        Ok(unit)
    }
}

/// Zeroes what a tilted instance would send below its own horizon.
fn hide_below_horizon(out: &mut [Complex<f32>], tilt: f64, refine: usize) {
    let step = std::f64::consts::PI / (AZIMUTHS * refine) as f64;
    for (n, value) in out.iter_mut().enumerate() {
        let phi_o = (n as f64 - AZIMUTH_MARGIN as f64 + 0.5) * step - std::f64::consts::FRAC_PI_2;
        // Margins keep the formal continuation, which interpolation near the horizon needs.
        if phi_o.abs() < std::f64::consts::FRAC_PI_2 && (phi_o + tilt).abs() > std::f64::consts::FRAC_PI_2 {
            *value = Complex::new(0.0, 0.0);
        }
    }
}
