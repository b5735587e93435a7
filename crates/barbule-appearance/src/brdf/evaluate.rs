//! Evaluation of a feather material: what renderers call.

use fearless_simd::{Level, Simd, dispatch, f32x4, prelude::*};
use glam::DVec3;
use std::f64::consts::PI;

use super::exact::{Lobe, Lobes};
use super::integral::Fine;
use super::lanes::{LobeLanes, StoredLobes};
use super::material::{FeatherMaterial, check_sigma};
use super::noise::{Draw, Noise};
use super::sample::{HalfVectors, SampledLobe};
use super::table::Table;
use crate::Result;
use crate::scattering::far_field::Polarization;

/// How a material is prepared.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Longitudinal spread σ instead of the material's own.
    pub sigma: Option<f64>,
    /// Whether values are symmetrized, (f(ω_i, ω_o) + f(ω_o, ω_i))/2, at twice the cost.
    pub reciprocal: bool,
    /// The incident polarization; `None` for unpolarized light.
    pub polarization: Option<Polarization>,
}

/// A feather material that is ready for evaluation. Shared between threads; nothing in it changes.
#[derive(Debug, Clone)]
pub struct FeatherBrdf {
    pub(super) tables: Vec<Table>,
    noise: Noise,
    sigma: f64,
    half_vectors: HalfVectors,
    factors: Factors,
    pub(super) options: Options,
    level: Level,
    range_nm: (f64, f64),
}

/// Constants of σ.
#[derive(Debug, Clone, Copy)]
struct Factors {
    /// 1/(σ π^{3/2})
    amplitude: f32,
    /// 1/σ²
    inverse_sigma2: f32,
    /// 1/(σ√π erf(1/σ))
    density: f32,
}

/// A [`FeatherBrdf`] at four wavelengths and one incident direction.
#[derive(Debug, Clone, Copy)]
pub struct PreparedBrdf<'a> {
    brdf: &'a FeatherBrdf,
    wavelengths_nm: [f32; 4],
    incident: DVec3,
    /// One or two of them count: `brdf.tables.len()`.
    sets: [StoredLobes; 2],
}

impl FeatherBrdf {
    /// Checks the material, extends and refines its tables and draws its noise: about a second per two million nodes.
    ///
    /// # Errors
    /// A material that fails [`FeatherMaterial::check`], or σ out of range.
    pub fn new(material: &FeatherMaterial, options: Options) -> Result<Self> {
        material.check()?;
        let sigma = options.sigma.unwrap_or(material.sigma);
        check_sigma(sigma)?;
        let only = match options.polarization {
            Some(Polarization::Second) if material.sets.len() == 2 => &material.sets[1..],
            Some(Polarization::First) if material.sets.len() == 2 => &material.sets[..1],
            _ => &material.sets[..],
        };
        let waves = material.axes.wavelengths_nm();
        Ok(Self {
            tables: only.iter().map(|set| Table::new(material, set, sigma, options.polarization)).collect(),
            noise: Noise::new(&material.noise_power, material.seed),
            sigma,
            half_vectors: HalfVectors::new(sigma),
            factors: Factors {
                amplitude: (1.0 / (sigma * PI.sqrt() * PI)) as f32,
                inverse_sigma2: (1.0 / (sigma * sigma)) as f32,
                density: (1.0 / (sigma * PI.sqrt() * libm::erf(1.0 / sigma))) as f32,
            },
            options,
            level: Level::new(),
            range_nm: (waves[0], waves[waves.len() - 1]),
        })
    }

    /// f in 1/sr at four wavelengths, without the cosine; zero unless both directions have z > 0.
    ///
    /// `instance` names a barbule, whose speckle is a draw of its own; without one the smooth mean is returned.
    #[must_use]
    pub fn eval(&self, wavelengths_nm: [f32; 4], wi: DVec3, wo: DVec3, instance: Option<u64>) -> [f32; 4] {
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return [0.0; 4];
        }
        let draw = instance.map(|instance| self.noise.draw(instance));
        dispatch!(self.level, simd => self.eval_wide(simd, wavelengths_nm, wi, wo, draw.as_ref()))
    }

    /// An outgoing direction drawn from the mean lobe at this wavelength, with its density per sr; none where the draw
    /// falls below the horizon (weight 0, not to be repeated).
    #[must_use]
    pub fn sample(&self, wavelength_nm: f32, wi: DVec3, u: [f64; 2]) -> Option<(DVec3, f64)> {
        self.prepare([wavelength_nm; 4], wi).sample(0, u)
    }

    /// Density of [`sample`](Self::sample) per sr; zero below the horizon.
    #[must_use]
    pub fn pdf(&self, wavelength_nm: f32, wi: DVec3, wo: DVec3) -> f64 {
        self.prepare([wavelength_nm; 4], wi).pdf(0, wo)
    }

    /// The densities at four wavelengths, for spectral multiple importance sampling.
    #[must_use]
    pub fn pdf4(&self, wavelengths_nm: [f32; 4], wi: DVec3, wo: DVec3) -> [f64; 4] {
        self.prepare(wavelengths_nm, wi).pdf4(wo)
    }

    /// Shortest and longest wavelength of the tables, nm; beyond them the end values hold.
    #[must_use]
    pub fn wavelength_range_nm(&self) -> (f64, f64) {
        self.range_nm
    }

    /// The longitudinal spread in use.
    #[must_use]
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// The noise in use.
    #[must_use]
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// ∫ f (z·ω_o) dω_o of the smooth mean (before any symmetrization), by quadrature.
    #[must_use]
    pub fn albedo(&self, wavelength_nm: f32, wi: DVec3) -> f64 {
        if wi.z <= 0.0 || wi.z.is_nan() {
            return 0.0;
        }
        let quadrature = Fine::new();
        let exact = self.exact(f64::from(wavelength_nm), wi);
        let reflected = |Lobes { mean: Lobe { m, incident, strength }, .. }: &Lobes| {
            strength * quadrature.scaled_integral(*m, *incident, self.sigma) / incident.z
        };
        exact.sets.iter().map(reflected).sum::<f64>() / exact.sets.len() as f64
    }

    /// Prepares and evaluates without a detour through memory.
    #[inline(always)]
    fn eval_wide<S: Simd>(
        &self,
        simd: S,
        wavelengths_nm: [f32; 4],
        wi: DVec3,
        wo: DVec3,
        draw: Option<&Draw>,
    ) -> [f32; 4] {
        let mut sum = self.one_way(simd, wavelengths_nm, wi, wo, draw);
        let mut share = if self.tables.len() == 2 { 0.5 } else { 1.0 };
        if self.options.reciprocal {
            sum += self.one_way(simd, wavelengths_nm, wo, wi, draw);
            share *= 0.5;
        }
        (sum * share).into()
    }

    /// The sum over the sets.
    #[inline(always)]
    fn one_way<S: Simd>(
        &self,
        simd: S,
        wavelengths_nm: [f32; 4],
        wi: DVec3,
        wo: DVec3,
        draw: Option<&Draw>,
    ) -> f32x4<S> {
        let mut sum = f32x4::splat(simd, 0.0);
        for table in &self.tables {
            let lobes = LobeLanes::new(simd, table, wavelengths_nm, single(wi), self.factors.amplitude);
            sum += self.value(simd, lobes, wi, wo, draw);
        }
        sum
    }

    /// f of one set.
    #[inline(always)]
    fn value<S: Simd>(
        &self,
        simd: S,
        lobes: LobeLanes<S>,
        wi: DVec3,
        wo: DVec3,
        draw: Option<&Draw>,
    ) -> f32x4<S> {
        let (mean, stationary) = lobes.values(simd, wi.y as f32, single(wo), self.factors.inverse_sigma2);
        let Some(draw) = draw else { return mean };
        let [qr, qi] = self.noise.at_four(simd, draw, lobes.inverse_length * (wi.x + wo.x) as f32);
        let spread = ((mean - stationary) * 0.5).sqrt();
        let (r, i) = (spread.mul_add(qr, stationary.sqrt()), spread * qi);
        r.mul_add(r, i * i)
    }

    /// Everything about four wavelengths and one incident direction, to be used with many outgoing ones.
    #[must_use]
    pub fn prepare(&self, wavelengths_nm: [f32; 4], wi: DVec3) -> PreparedBrdf<'_> {
        let mut sets = [StoredLobes::NONE; 2];
        if wi.z > 0.0 {
            dispatch!(self.level, simd => self.prepare_wide(simd, wavelengths_nm, wi, &mut sets));
        }
        PreparedBrdf { brdf: self, wavelengths_nm, incident: wi, sets }
    }

    #[inline(always)]
    fn prepare_wide<S: Simd>(
        &self,
        simd: S,
        wavelengths_nm: [f32; 4],
        wi: DVec3,
        sets: &mut [StoredLobes; 2],
    ) {
        for (lobes, table) in sets.iter_mut().zip(&self.tables) {
            *lobes = LobeLanes::new(simd, table, wavelengths_nm, single(wi), self.factors.amplitude).store();
        }
    }
}

/// In single precision.
#[inline(always)]
fn single(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

impl PreparedBrdf<'_> {
    /// f in 1/sr without the cosine; see [`FeatherBrdf::eval`].
    #[must_use]
    pub fn eval(&self, wo: DVec3, instance: Option<u64>) -> [f32; 4] {
        if !(self.incident.z > 0.0 && wo.z > 0.0) {
            return [0.0; 4];
        }
        let draw = instance.map(|instance| self.brdf.noise.draw(instance));
        dispatch!(self.brdf.level, simd => self.eval_wide(simd, wo, draw.as_ref()))
    }

    #[inline(always)]
    fn eval_wide<S: Simd>(&self, simd: S, wo: DVec3, draw: Option<&Draw>) -> [f32; 4] {
        let brdf = self.brdf;
        let mut sum = f32x4::splat(simd, 0.0);
        for lobes in &self.sets[..brdf.tables.len()] {
            sum += brdf.value(simd, lobes.load(simd), self.incident, wo, draw);
        }
        let mut share = if brdf.tables.len() == 2 { 0.5 } else { 1.0 };
        if brdf.options.reciprocal {
            sum += brdf.one_way(simd, self.wavelengths_nm, wo, self.incident, draw);
            share *= 0.5;
        }
        (sum * share).into()
    }

    /// See [`FeatherBrdf::sample`]; `lane` chooses the wavelength.
    #[must_use]
    pub fn sample(&self, lane: usize, u: [f64; 2]) -> Option<(DVec3, f64)> {
        let outgoing = self.direction(lane, u)?;
        Some((outgoing, self.pdf(lane, outgoing)))
    }

    /// [`sample`](Self::sample) without the density.
    #[must_use]
    pub fn direction(&self, lane: usize, mut u: [f64; 2]) -> Option<DVec3> {
        if self.incident.z <= 0.0 || self.incident.z.is_nan() {
            return None;
        }
        let share = self.first_share(lane);
        let set = if u[0] < share {
            u[0] /= share;
            0
        } else {
            u[0] = (u[0] - share) / (1.0 - share);
            1
        };
        let lobes = &self.sets[set];
        let lobe = SampledLobe {
            m: f64::from(lobes.m2[lane]).sqrt(),
            incident: DVec3::new(f64::from(lobes.x[lane]), self.incident.y, f64::from(lobes.z[lane]))
                .normalize(),
        };
        let outgoing = lobe.sample(&self.brdf.half_vectors, u);
        (outgoing.z > 0.0).then_some(outgoing)
    }

    /// See [`FeatherBrdf::pdf`]; `lane` chooses the wavelength.
    #[must_use]
    pub fn pdf(&self, lane: usize, wo: DVec3) -> f64 {
        self.pdf4(wo)[lane]
    }

    /// See [`FeatherBrdf::pdf4`].
    #[must_use]
    pub fn pdf4(&self, wo: DVec3) -> [f64; 4] {
        if !(self.incident.z > 0.0 && wo.z > 0.0) {
            return [0.0; 4];
        }
        dispatch!(self.brdf.level, simd => self.pdf_wide(simd, wo)).map(f64::from)
    }

    #[inline(always)]
    fn pdf_wide<S: Simd>(&self, simd: S, wo: DVec3) -> [f32; 4] {
        let (y, out) = (self.incident.y as f32, single(wo));
        let Factors { inverse_sigma2, density, .. } = self.brdf.factors;
        let first = self.sets[0].load(simd);
        let first_density = first.densities(simd, y, out, inverse_sigma2, density);
        if self.brdf.tables.len() == 1 {
            return first_density.into();
        }
        let second = self.sets[1].load(simd);
        let second_density = second.densities(simd, y, out, inverse_sigma2, density);
        let (a, b) = (first.weights(), second.weights());
        ((a * first_density + b * second_density) / (a + b)).into()
    }

    /// Probability of drawing from the first set.
    fn first_share(&self, lane: usize) -> f64 {
        if self.brdf.tables.len() == 1 {
            return 1.0;
        }
        let [a, b] = dispatch!(self.brdf.level, simd => self.weights(simd));
        f64::from(a[lane] / (a[lane] + b[lane]))
    }

    #[inline(always)]
    fn weights<S: Simd>(&self, simd: S) -> [[f32; 4]; 2] {
        [self.sets[0].load(simd).weights().into(), self.sets[1].load(simd).weights().into()]
    }
}

#[cfg(test)]
mod tests;
