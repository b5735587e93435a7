//! A campaign's speed in figures, from a sample of its units.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

use barbule::campaign::{Campaign, CampaignParameters, Keep, Resources, orders, places, sides};
use barbule::math::simd::Width;
use barbule::progress::{Progress, Unobserved};
use barbule::scattering::far_field::{Illumination, Window};
use barbule::scattering::statistics::{AZIMUTHS, Axes};
use barbule::solve::direct;
use barbule::solve::surface::{FINE_ELEMENT_UM, Stages};
use barbule::spectrum::Wavelengths;
use barbule::structure::Structure;
use barbule::{Error, Result};

/// Wavelengths of the sample, nm: the middles of four equal parts of 400 to 694.
const SAMPLE_NM: [f64; 4] = [437.0, 510.0, 584.0, 657.0];

/// cosθ_i of the sample: the middles of four equal parts.
const SAMPLE_COS_THETA: [f64; 4] = [0.15, 0.4, 0.65, 0.9];

/// Wavelengths, θ_i, φ_i and instances of a full campaign.
const FULL: [usize; 4] = [50, 20, 20, 50];

/// What a campaign costs on one core, in CPU seconds, so that other work on the machine does not count.
#[derive(Debug, Clone)]
pub struct CampaignFigures {
    /// Rays under each element; `None` over a crystal.
    pub rays: Option<usize>,
    /// Preparing one instance.
    pub instance_seconds: f64,
    /// The reflectance tables of one wavelength, all instances, or the orders of a crystal, all θ_i.
    pub table_seconds: f64,
    /// Bytes of these tables.
    pub table_bytes: usize,
    /// One unit (λ, θ_i): 20 φ_i (39 of both signs), 2 polarizations, all instances, with its statistics.
    pub unit_seconds: f64,
    /// Illuminations of a full campaign.
    pub illuminations: usize,
    /// CPU seconds of a full campaign.
    pub full_seconds: f64,
    /// Seconds per stage of the fields of one instance in one unit, the table's share of a unit first.
    pub stages: Vec<(&'static str, f64)>,
    /// How many times longer the plain evaluation takes per illumination.
    pub plain_ratio: f64,
}

impl CampaignFigures {
    /// Illuminations per CPU second in a full campaign.
    #[must_use]
    pub fn illuminations_per_second(&self) -> f64 {
        self.illuminations as f64 / self.full_seconds
    }
}

/// Measures a sample of units on one thread; both signs of φ_i where the structure is not its own mirror image.
///
/// # Errors
/// An instance cannot be made, a medium's table does not cover 400 to 700 nm, or the user cancelled.
pub fn measure(
    structure: &Structure,
    seed: u64,
    width: Width,
    progress: &dyn Progress,
) -> Result<CampaignFigures> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .map_err(|e| Error::machine(format!("no thread for the benchmark: {e}")))?;
    pool.install(|| sample(structure, seed, width, progress))
}

fn sample(
    structure: &Structure,
    seed: u64,
    width: Width,
    progress: &dyn Progress,
) -> Result<CampaignFigures> {
    let [wavelengths, thetas, phis, instances] = FULL;
    let cos_phi: Vec<f64> = (1..=phis).map(|i| i as f64 / phis as f64).collect();
    let axes = Axes::new(&Wavelengths::new(SAMPLE_NM)?, SAMPLE_COS_THETA.to_vec(), cos_phi)?;
    let axes = axes.with_sides(sides(&structure.symmetry()));
    let phis = axes.phis();
    let phi_i: Vec<f64> = (0..phis).map(|phi| axes.phi_i(phi)).collect();
    let theta_i = axes.theta_i(2);
    let (tilt, places) = (2f64.to_radians(), places(structure, instances));
    let parameters = CampaignParameters { axes, instances, seed, tilt, mirror: false, places };
    progress.begin("measuring", (SAMPLE_NM.len() * SAMPLE_COS_THETA.len()) as u64);
    let begun = ProcessTime::now();
    let orders = orders(structure, &parameters.axes, &Unobserved)?;
    // Those of the sampled θ_i stand for all.
    let mut tables = begun.elapsed() * (thetas / SAMPLE_COS_THETA.len()) as u32;
    let begun = ProcessTime::now();
    let resources = Resources { width, ..Resources::default() };
    let campaign = Campaign::with_orders(structure, parameters, orders, &resources, &Unobserved)?;
    let preparing = begun.elapsed();
    let (mut units, mut table_bytes) = (Duration::ZERO, 0);
    for index in 0..SAMPLE_NM.len() {
        let begun = ProcessTime::now();
        let shared = campaign.tables(index, progress)?;
        tables += begun.elapsed();
        table_bytes = table_bytes.max(shared.bytes());
        for theta in 0..SAMPLE_COS_THETA.len() {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let begun = ProcessTime::now();
            std::hint::black_box(campaign.unit(&shared, theta, Keep::Statistics, progress)?);
            units += begun.elapsed();
            progress.advance(1);
        }
    }
    let section = structure.instance(seed, 0)?;
    // Tables serve all θ_i of a wavelength, a crystal's orders all instances.
    let parts = campaign.ray_parts();
    let shared_by = if parts.is_some() { thetas } else { instances };
    let barbule = Stages::new(&section, parts.unwrap_or(1))?;
    let mut stages = stage_seconds(barbule, SAMPLE_NM[1], theta_i, &phi_i)?;
    stages[0].1 /= shared_by as f64;
    let fields: f64 = stages.iter().map(|(_, seconds)| seconds).sum();
    let begun = ProcessTime::now();
    let illumination =
        Illumination { wavelength_nm: SAMPLE_NM[1], theta_i, phi_i: phi_i[10], window: Window::Gaussian };
    direct::far_field(&section, &illumination, AZIMUTHS, FINE_ELEMENT_UM)?;
    let plain = begun.elapsed().as_secs_f64();
    let table_seconds = tables.as_secs_f64() / SAMPLE_NM.len() as f64;
    let unit_seconds = units.as_secs_f64() / (SAMPLE_NM.len() * SAMPLE_COS_THETA.len()) as f64;
    Ok(CampaignFigures {
        rays: parts.map(|parts| 2 * parts),
        instance_seconds: preparing.as_secs_f64() / instances as f64,
        table_seconds,
        table_bytes,
        unit_seconds,
        illuminations: wavelengths * thetas * phis * instances * 2,
        full_seconds: preparing.as_secs_f64()
            + wavelengths as f64 * (table_seconds + thetas as f64 * unit_seconds),
        stages,
        plain_ratio: plain * phi_i.len() as f64 / fields,
    })
}

/// How often stages are timed; the least time of each counts.
const REPEATS: usize = 5;

/// Seconds of each stage of a batch.
fn stage_seconds(
    mut barbule: Stages,
    wavelength_nm: f64,
    theta_i: f64,
    phi_i: &[f64],
) -> Result<Vec<(&'static str, f64)>> {
    let mut best: Vec<(&'static str, f64)> = Vec::new();
    for _ in 0..REPEATS {
        let (mut clock, mut stages) = (Instant::now(), Vec::new());
        barbule.run(wavelength_nm, theta_i, phi_i, &mut |name| {
            stages.push((name, clock.elapsed().as_secs_f64()));
            clock = Instant::now();
        })?;
        if best.is_empty() {
            best = stages;
        } else {
            best.iter_mut().zip(stages).for_each(|(kept, new)| kept.1 = kept.1.min(new.1));
        }
    }
    Ok(best)
}
