//! Evaluation of a feather material: what renderers call.

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use std::f64::consts::PI;

use super::integral::Quadrature;
use super::material::{Material, check_sigma};
use super::noise::{Draw, Noise};
use super::sample::SampledLobe;
use super::table::{self, LARGEST_SINE, STATIONARY, Table, WIDTH, effective};
use crate::Result;

/// How a material is prepared.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Longitudinal spread σ instead of the material's own.
    pub sigma: Option<f64>,
    /// Whether values are symmetrized, (f(ω_i, ω_o) + f(ω_o, ω_i))/2, at twice the cost.
    pub reciprocal: bool,
    /// Which incident light.
    pub polarization: Polarization,
}

/// Incident polarization.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Polarization {
    /// Unpolarized light.
    #[default]
    Mean,
    /// E along e₁.
    First,
    /// E along e₂.
    Second,
}

/// A feather material that is ready for evaluation. Shared between threads; nothing in it changes.
#[derive(Debug, Clone)]
pub struct FeatherBrdf {
    tables: Vec<Table>,
    noise: Noise,
    sigma: f64,
    options: Options,
    level: Level,
    range_nm: (f64, f64),
}

/// The mean lobes of four wavelengths, then the stationary ones.
type Lanes = [f32; 8];

/// Lobe parameters of one set at four wavelengths and one incident direction.
#[derive(Debug, Clone, Copy)]
struct Lobes {
    m2: Lanes,
    /// x and z of ω_eff.
    x: Lanes,
    z: Lanes,
    amplitude: Lanes,
    inverse_length: [f32; 4],
}

/// A [`FeatherBrdf`] at four wavelengths and one incident direction.
#[derive(Debug, Clone, Copy)]
pub struct Prepared<'a> {
    brdf: &'a FeatherBrdf,
    wavelengths_nm: [f32; 4],
    incident: DVec3,
    /// One or two of them count: `brdf.tables.len()`.
    sets: [Lobes; 2],
}

impl FeatherBrdf {
    /// Checks the material, extends and refines its tables and draws its noise: about a second per two million nodes.
    ///
    /// # Errors
    /// A material that fails [`Material::check`], or σ out of range.
    pub fn new(material: &Material, options: Options) -> Result<Self> {
        material.check()?;
        let sigma = options.sigma.unwrap_or(material.sigma);
        check_sigma(sigma)?;
        let only = match options.polarization {
            Polarization::Second if material.sets.len() == 2 => &material.sets[1..],
            Polarization::First if material.sets.len() == 2 => &material.sets[..1],
            _ => &material.sets[..],
        };
        let waves = &material.axes.wavelengths_nm;
        Ok(Self {
            tables: only.iter().map(|set| Table::new(material, set, sigma, options.polarization)).collect(),
            noise: Noise::new(&material.noise_power, material.seed),
            sigma,
            options,
            level: eight_lanes(),
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
        let prepared = self.prepare(wavelengths_nm, wi);
        std::array::from_fn(|lane| prepared.pdf(lane, wo))
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
        let quadrature = Quadrature::new();
        let sum: f64 = self
            .parameters(wavelength_nm, wi)
            .map(|(p, incident)| {
                let m = f64::from(p[table::M]);
                let integral = quadrature.scaled_integral(m, incident, self.sigma);
                f64::from(p[table::STRENGTH]) * integral / incident.z
            })
            .sum();
        sum / self.tables.len() as f64
    }

    /// Prepares and evaluates in one piece of code, compiled for each width of vector registers.
    #[inline(always)]
    fn eval_wide<S: Simd>(
        &self,
        _simd: S,
        wavelengths_nm: [f32; 4],
        wi: DVec3,
        wo: DVec3,
        draw: Option<&Draw>,
    ) -> [f32; 4] {
        let forward = self.prepare_inline(wavelengths_nm, wi).forward(wo, draw);
        if !self.options.reciprocal {
            return forward;
        }
        let backward = self.prepare_inline(wavelengths_nm, wo).forward(wi, draw);
        std::array::from_fn(|lane| 0.5 * (forward[lane] + backward[lane]))
    }

    #[inline(always)]
    fn prepare_wide<S: Simd>(&self, _simd: S, wavelengths_nm: [f32; 4], wi: DVec3) -> Prepared<'_> {
        self.prepare_inline(wavelengths_nm, wi)
    }

    /// Everything about four wavelengths and one incident direction, to be used with many outgoing ones.
    #[must_use]
    pub fn prepare(&self, wavelengths_nm: [f32; 4], wi: DVec3) -> Prepared<'_> {
        dispatch!(self.level, simd => self.prepare_wide(simd, wavelengths_nm, wi))
    }

    #[inline(always)]
    fn prepare_inline(&self, wavelengths_nm: [f32; 4], wi: DVec3) -> Prepared<'_> {
        let mut sets = [Lobes::NONE; 2];
        if wi.z > 0.0 {
            for (lobes, table) in sets.iter_mut().zip(&self.tables) {
                *lobes = self.lobes(table, wavelengths_nm, wi);
            }
        }
        Prepared { brdf: self, wavelengths_nm, incident: wi, sets }
    }

    #[inline(always)]
    fn lobes(&self, table: &Table, wavelengths_nm: [f32; 4], wi: DVec3) -> Lobes {
        let (x, z) = (wi.x as f32, wi.z as f32);
        let cos_theta = (x * x + z * z).sqrt().max(1e-6);
        let inverse = 1.0 / cos_theta;
        let sin_phi = x * inverse;
        let cell = table.cell(cos_theta, z * inverse);
        // Plain loops here and below: closures would not be compiled for the wider registers.
        let mut rows = [[0.0; WIDTH]; 4];
        for lane in 0..4 {
            rows[lane] = table.lookup(&cell, table.place(wavelengths_nm[lane]));
        }
        let mut lobes = Lobes::NONE;
        // f̂ = ρ m/(2σ√π J) · D₁ D₂ · 2/(z + root): all constant factors.
        let factor = (1.0 / (self.sigma * PI.sqrt() * PI)) as f32;
        for lane in 0..8 {
            let row = &rows[lane % 4];
            let base = if lane < 4 { 0 } else { STATIONARY };
            let m = row[base + table::M];
            let sine = (row[base + table::TILT] * sin_phi).clamp(-LARGEST_SINE, LARGEST_SINE);
            lobes.m2[lane] = m * m;
            lobes.x[lane] = cos_theta * sine;
            lobes.z[lane] = cos_theta * (1.0 - sine * sine).sqrt();
            lobes.amplitude[lane] = factor * row[base + table::STRENGTH] * m * m * m / lobes.z[lane];
        }
        for (lane, row) in rows.iter().enumerate() {
            lobes.inverse_length[lane] = row[table::INVERSE_LENGTH];
        }
        lobes
    }

    /// Parameters and ω_eff of each set.
    fn parameters(&self, wavelength_nm: f32, wi: DVec3) -> impl Iterator<Item = ([f32; WIDTH], DVec3)> + '_ {
        self.tables.iter().map(move |table| {
            let cos_theta = wi.x.hypot(wi.z).max(1e-6);
            let cos_phi = wi.z / cos_theta;
            let cell = table.cell(cos_theta as f32, cos_phi as f32);
            let p = table.lookup(&cell, table.place(wavelength_nm));
            let mut incident = effective(cos_theta, cos_phi, f64::from(p[table::TILT]));
            incident.x = incident.x.copysign(wi.x * incident.x);
            incident.y = wi.y;
            (p, incident)
        })
    }
}

impl Lobes {
    const NONE: Self =
        Self { m2: [1.0; 8], x: [0.0; 8], z: [1.0; 8], amplitude: [0.0; 8], inverse_length: [1.0; 4] };

    /// f̂ and s ≤ f̂.
    #[inline(always)]
    fn values(&self, sin_theta: f32, wo: [f32; 3], inverse_sigma2: f32) -> ([f32; 4], [f32; 4]) {
        let [x, y, z] = wo;
        let sy2 = (sin_theta + y) * (sin_theta + y);
        let slope = 1.0 - z * z;
        let mut values = [0.0; 8];
        for (lane, value) in values.iter_mut().enumerate() {
            let (sx, sz) = (self.x[lane] + x, self.z[lane] + z);
            let (sx2, m2) = (sx * sx, self.m2[lane]);
            let n2 = sx2 + sy2 + sz * sz;
            // D₁ = m² n⁴ / (π (m² n² + (1−m²) s_x²)²) with s = ω_eff + ω_o, n = |s|.
            let q = m2 * n2 + (1.0 - m2) * sx2;
            let root = z + (z * z + m2 * slope).sqrt();
            let spread = exp_of_negative(sy2 * inverse_sigma2 / n2);
            *value = self.amplitude[lane] * spread * (n2 * n2) / (q * q * root);
        }
        let (mut mean, mut stationary) = ([0.0; 4], [0.0; 4]);
        for lane in 0..4 {
            mean[lane] = values[lane];
            stationary[lane] = values[lane + 4].min(values[lane]);
        }
        (mean, stationary)
    }
}

/// The instructions for eight lanes of f32. Wider registers only add traffic between loops of eight.
fn eight_lanes() -> Level {
    let best = Level::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = best.as_avx2() {
        return Level::Avx2(avx2);
    }
    best
}

/// exp(−u) for u ≥ 0, relative error 3e-7; zero (below 1e-37) for large u.
#[inline]
fn exp_of_negative(u: f32) -> f32 {
    // Adding this rounds to an integer and leaves it in the low bits.
    const MAGIC: f32 = 12_582_912.0;
    let y = (u * -std::f32::consts::LOG2_E).max(-125.0);
    let shifted = y + MAGIC;
    let f = (y - (shifted - MAGIC)) * std::f32::consts::LN_2;
    let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    let series =
        1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f / 720.0)))));
    if u > 86.0 { 0.0 } else { series * power }
}

impl Prepared<'_> {
    /// f in 1/sr without the cosine; see [`FeatherBrdf::eval`].
    #[must_use]
    pub fn eval(&self, wo: DVec3, instance: Option<u64>) -> [f32; 4] {
        let draw = instance.map(|instance| self.brdf.noise.draw(instance));
        dispatch!(self.brdf.level, simd => self.eval_wide(simd, wo, draw.as_ref()))
    }

    #[inline(always)]
    fn eval_wide<S: Simd>(&self, _simd: S, wo: DVec3, draw: Option<&Draw>) -> [f32; 4] {
        let forward = self.forward(wo, draw);
        if !self.brdf.options.reciprocal {
            return forward;
        }
        let backward = self.brdf.prepare_inline(self.wavelengths_nm, wo).forward(self.incident, draw);
        std::array::from_fn(|lane| 0.5 * (forward[lane] + backward[lane]))
    }

    #[inline(always)]
    fn forward(&self, wo: DVec3, draw: Option<&Draw>) -> [f32; 4] {
        if !(self.incident.z > 0.0 && wo.z > 0.0) {
            return [0.0; 4];
        }
        let outgoing = [wo.x as f32, wo.y as f32, wo.z as f32];
        let inverse_sigma2 = (1.0 / (self.brdf.sigma * self.brdf.sigma)) as f32;
        let sets = &self.sets[..self.brdf.tables.len()];
        let x = (self.incident.x + wo.x) as f32;
        let mut sum = [0.0; 4];
        for lobes in sets {
            let (mean, stationary) = lobes.values(self.incident.y as f32, outgoing, inverse_sigma2);
            match draw {
                None => {
                    for lane in 0..4 {
                        sum[lane] += mean[lane];
                    }
                }
                Some(draw) => {
                    let mut places = lobes.inverse_length;
                    for place in &mut places {
                        *place *= x;
                    }
                    let [qr, qi] = self.brdf.noise.at_four(draw, places);
                    for lane in 0..4 {
                        let spread = (0.5 * (mean[lane] - stationary[lane])).sqrt();
                        let (r, i) = (spread * qr[lane] + stationary[lane].sqrt(), spread * qi[lane]);
                        sum[lane] += r * r + i * i;
                    }
                }
            }
        }
        let factor = if sets.len() == 2 { 0.5 } else { 1.0 };
        for value in &mut sum {
            *value *= factor;
        }
        sum
    }

    /// See [`FeatherBrdf::sample`]; `lane` chooses the wavelength.
    #[must_use]
    pub fn sample(&self, lane: usize, mut u: [f64; 2]) -> Option<(DVec3, f64)> {
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
        let (outgoing, _) = self.lobe(set, lane).sample(u);
        (outgoing.z > 0.0).then(|| (outgoing, self.pdf(lane, outgoing)))
    }

    /// See [`FeatherBrdf::pdf`]; `lane` chooses the wavelength.
    #[must_use]
    pub fn pdf(&self, lane: usize, wo: DVec3) -> f64 {
        if !(self.incident.z > 0.0 && wo.z > 0.0) {
            return 0.0;
        }
        let share = self.first_share(lane);
        let first = self.lobe(0, lane).pdf(wo);
        if share >= 1.0 { first } else { share * first + (1.0 - share) * self.lobe(1, lane).pdf(wo) }
    }

    /// Probability of drawing from the first set.
    fn first_share(&self, lane: usize) -> f64 {
        if self.brdf.tables.len() == 1 {
            return 1.0;
        }
        let [a, b] = [0, 1].map(|set| self.weight(set, lane));
        a / (a + b)
    }

    /// Roughly the reflected fraction of a set.
    fn weight(&self, set: usize, lane: usize) -> f64 {
        let lobes = &self.sets[set];
        let m2 = f64::from(lobes.m2[lane]);
        f64::from(lobes.amplitude[lane] * lobes.z[lane]) / (m2 * m2.sqrt()) + 1e-9
    }

    fn lobe(&self, set: usize, lane: usize) -> SampledLobe {
        let lobes = &self.sets[set];
        SampledLobe {
            m: f64::from(lobes.m2[lane]).sqrt(),
            incident: DVec3::new(f64::from(lobes.x[lane]), self.incident.y, f64::from(lobes.z[lane]))
                .normalize(),
            sigma: self.brdf.sigma,
        }
    }
}
