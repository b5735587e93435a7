//! The recipe of the simulation, once: what reflects → nodes → scales → currents and far fields → azimuths.

use num_complex::Complex;

use super::barbule::{Barbule, Underside};
use super::cone::Cone;
use super::points::Points;
use super::radiation::Lap;
use super::radiation::Radiator;
use super::reflector::Reflector;
use super::scalar::Scalar;
use super::synthesis::{Grid, Synthesis};
use crate::math::simd::Width;
use crate::progress::Progress;
use crate::scattering::far_field::IncidentLight;
use crate::{Error, Result};

/// Light from several azimuths on one cone.
#[derive(Debug, Clone, Copy)]
pub struct Batch<'a> {
    /// The cone.
    pub cone: &'a Cone,
    /// Azimuths of incidence, rad.
    pub phi_i: &'a [f64],
    /// The light from each azimuth; amplitudes belong to it. A beam's power is [`Barbule::incident_power_um`].
    pub lights: &'a [IncidentLight],
}

/// Buffers of one thread of a campaign.
pub struct Workspace(Buffers<f32>);

impl Workspace {
    /// Empty buffers; they grow to what is asked of them and are then reused.
    #[must_use]
    pub fn new(width: Width) -> Self {
        Self(Buffers::new(width))
    }

    /// The far fields of one barbule on a grid of azimuths, over √Φ_i, in single precision:
    /// `[phi_i][incident polarization][e₁, e₂][azimuth]`.
    ///
    /// # Errors
    /// A stop by `progress`.
    // Never inlined, so that no other crate compiles the kernels once more.
    #[inline(never)]
    pub fn scatter(
        &mut self,
        barbule: &Barbule,
        underside: &Underside,
        batch: &Batch<'_>,
        grid: Grid,
        progress: &dyn Progress,
    ) -> Result<Vec<Complex<f32>>> {
        let mut fields = Vec::new();
        self.0.radiate(&barbule.points, &underside.0, batch, &mut |_| unless_cancelled(progress))?;
        self.0.synthesize(batch.cone, grid, &mut fields);
        Ok(fields)
    }
}

/// An error once the user cancelled.
pub(super) fn unless_cancelled(progress: &dyn Progress) -> Result<()> {
    if progress.is_cancelled() { Err(Error::interrupted()) } else { Ok(()) }
}

/// What the recipe needs beside its arguments.
pub(super) struct Buffers<T: Scalar> {
    radiator: Radiator<T>,
    /// Fourier coefficients of the last batch, `[phi_i][incident polarization][e₁, e₂][order]`.
    pub(super) coefficients: Vec<Complex<T>>,
    circle: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
}

impl<T: Scalar> Buffers<T> {
    pub(super) fn new(width: Width) -> Self {
        let radiator = Radiator::new(width);
        Self { radiator, coefficients: Vec::new(), circle: Vec::new(), scratch: Vec::new() }
    }

    /// Forms the Fourier coefficients of a batch's far fields, calling `lap` with its name after each stage.
    ///
    /// # Errors
    /// That of `lap`.
    pub(super) fn radiate(
        &mut self,
        points: &Points,
        reflector: &Reflector<T>,
        batch: &Batch<'_>,
        lap: &mut Lap<'_>,
    ) -> Result<()> {
        let Batch { cone, phi_i, lights } = *batch;
        let nodes = T::nodes(points, cone.kappa);
        let scales: Vec<f64> = lights.iter().map(|light| light.scale()).collect();
        lap("nodes and powers")?;
        self.radiator.far_fields(points, reflector, &nodes, cone, phi_i, &scales, &mut self.coefficients, lap)
    }

    /// Evaluates the last batch on a grid, `[phi_i][incident polarization][e₁, e₂][azimuth]`.
    pub(super) fn synthesize(&mut self, cone: &Cone, grid: Grid, fields: &mut Vec<Complex<T>>) {
        let synthesis = Synthesis::new(&mut self.radiator.plans, cone, grid);
        let components = self.coefficients.chunks_exact(cone.angles);
        let zero = Complex { re: T::of(0.0), im: T::of(0.0) };
        fields.resize(components.len() * grid.points(), zero);
        for (component, out) in components.zip(fields.chunks_exact_mut(grid.points())) {
            synthesis.evaluate(component, &mut self.circle, &mut self.scratch, out);
        }
    }
}
