//! One individual: its section to scale, its colour along the normal, and what it scatters.

use barbule::progress::Progress;
use barbule::scattering::far_field::{Illumination, Polarization, Window};
use barbule::solve::crystal::{Multipole, sweep};
use barbule::solve::surface::{Accuracy, far_field_observed};
use barbule::solve::swatch::normal_reflectance;
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::structure::{Section, Structure};
use barbule::{Error, Result};

/// Points of the top whose layers' colours are averaged.
const POINTS: usize = 120;
/// Outgoing azimuths over the upper half.
const AZIMUTHS: usize = 400;

/// One individual of a structure.
#[derive(Debug, Clone)]
pub struct IndividualJob {
    /// The structure.
    pub structure: Structure,
    /// Its individuals' seed.
    pub seed: u64,
    /// Which of them, from 0.
    pub index: usize,
    /// Wavelengths of its colour along the normal.
    pub at: Wavelengths,
    /// The wavelength of what it scatters, nm; none: that is not asked for.
    pub wavelength_nm: Option<f64>,
    /// Where the light comes from: along and across the barbule (θ_i, φ_i), rad.
    pub incident: [f64; 2],
}

/// What was found of it.
#[derive(Debug, Clone)]
pub struct Individual {
    /// Its section.
    pub section: Section,
    /// What flat layers like those under each point of it reflect along the normal, in the mean; of a crystal, the ideal one.
    pub reflected: Spectrum,
    /// What it scatters.
    pub lobe: Option<Lobe>,
}

/// Light scattered over the azimuths above a barbule.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobe {
    /// The wavelength, nm.
    pub wavelength_nm: f64,
    /// Outgoing azimuths, rad, rising.
    pub azimuth: Vec<f64>,
    /// Radiant intensity of unpolarized light over the incident power, rad⁻¹. Shape: `[azimuth]`.
    pub intensity: Vec<f64>,
    /// The part of the light that is scattered upwards.
    pub reflected: f64,
}

/// Makes an individual: tells its section and colour at once, then what it scatters too.
///
/// # Errors
/// There is no such individual, a medium has no index at a wavelength, a section that is closed, or a stop by `progress`.
pub fn individual(
    job: &IndividualJob,
    progress: &dyn Progress,
    found: &mut dyn FnMut(Individual),
) -> Result<()> {
    let section = job.structure.instance(job.seed, job.index)?;
    unless_cancelled(progress)?;
    let reflected = colour(job, &section, progress)?;
    let mut made = Individual { section, reflected, lobe: None };
    let Some(wavelength_nm) = job.wavelength_nm else {
        found(made);
        return Ok(());
    };
    found(made.clone());
    unless_cancelled(progress)?;
    made.lobe = Some(lobe(&made.section, wavelength_nm, job.incident, progress)?);
    found(made);
    Ok(())
}

fn unless_cancelled(progress: &dyn Progress) -> Result<()> {
    if progress.is_cancelled() { Err(Error::interrupted()) } else { Ok(()) }
}

fn colour(job: &IndividualJob, section: &Section, progress: &dyn Progress) -> Result<Spectrum> {
    let Some(lattice) = job.structure.lattice() else {
        if section.boundaries.is_empty() {
            return Err(Error::input(format!(
                "{} has no top boundary, so it has no colour along its normal",
                job.structure.name()
            )));
        }
        return normal_reflectance(section, POINTS, &job.at);
    };
    let both = sweep(&Multipole::default(), &lattice, job.at.nm(), 0.0, &[0.0], progress)?;
    Spectrum::new(job.at.clone(), both.into_iter().map(|[s, p]| 0.5 * (s + p)).collect())
}

/// What a section scatters of light through a window as wide as usual.
fn lobe(
    section: &Section,
    wavelength_nm: f64,
    [theta_i, phi_i]: [f64; 2],
    progress: &dyn Progress,
) -> Result<Lobe> {
    let light = Illumination { wavelength_nm, theta_i, phi_i, window: Window::Gaussian };
    let far = far_field_observed(section, &light, AZIMUTHS, &Accuracy::default(), progress)?;
    let [first, second] = Polarization::BOTH.map(|polarization| far.per_radian(polarization));
    let reflected = Polarization::BOTH.map(|p| far.reflected_fraction(p).unwrap_or_default());
    Ok(Lobe {
        wavelength_nm,
        azimuth: far.azimuths.phi_o(),
        intensity: first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b)).collect(),
        reflected: 0.5 * (reflected[0] + reflected[1]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;
    use barbule::progress::Shared;
    use barbule::solve::surface::far_field;

    fn job(name: &str) -> IndividualJob {
        IndividualJob {
            structure: Structure::builtin(name).unwrap(),
            seed: 1,
            index: 3,
            at: Wavelengths::new([450.0, 550.0, 650.0]).unwrap(),
            wavelength_nm: Some(550.0),
            incident: [0.0, 0.4],
        }
    }

    fn all(job: &IndividualJob) -> Vec<Individual> {
        let mut found = Vec::new();
        individual(job, &Unobserved, &mut |one| found.push(one)).unwrap();
        found
    }

    /// The numbers are those of the library's own functions.
    #[test]
    fn an_individual_is_the_librarys() {
        let job = job("starling");
        let [first, second] = &all(&job)[..] else { panic!() };
        assert!(first.lobe.is_none());
        let section = job.structure.instance(1, 3).unwrap();
        assert_eq!(second.section, section);
        assert_eq!(second.reflected, normal_reflectance(&section, POINTS, &job.at).unwrap());
        let light = Illumination { wavelength_nm: 550.0, theta_i: 0.0, phi_i: 0.4, window: Window::Gaussian };
        let far = far_field(&section, &light, AZIMUTHS, &Accuracy::default()).unwrap();
        let lobe = second.lobe.as_ref().unwrap();
        let [a, b] = Polarization::BOTH.map(|p| far.intensity(p).unwrap());
        assert_eq!(lobe.intensity[99], 0.5 * (a[99] + b[99]));
        let step = std::f64::consts::PI / AZIMUTHS as f64;
        let sum: f64 = lobe.intensity.iter().sum::<f64>() * step;
        assert!((sum / lobe.reflected - 1.0).abs() < 0.02, "{sum} {}", lobe.reflected);
        // Mirrored light leaves to the other side.
        let brightest =
            (0..AZIMUTHS).max_by(|&i, &j| lobe.intensity[i].total_cmp(&lobe.intensity[j])).unwrap();
        assert!((lobe.azimuth[brightest] + 0.4).abs() < 0.3, "{}", lobe.azimuth[brightest]);
    }

    #[test]
    fn crystals_have_the_colour_of_their_lattice() {
        let job = IndividualJob { wavelength_nm: None, ..job("magpie") };
        let [one] = &all(&job)[..] else { panic!() };
        let lattice = job.structure.lattice().unwrap();
        let both = sweep(&Multipole::default(), &lattice, job.at.nm(), 0.0, &[0.0], &Unobserved).unwrap();
        assert_eq!(one.reflected.values()[1], 0.5 * (both[1][0] + both[1][1]));
    }

    #[test]
    fn what_is_not_there_is_refused_and_what_is_not_wanted_stops() {
        let one =
            IndividualJob { structure: Structure::flat("air/keratin:300/air").unwrap(), ..job("starling") };
        let refused = individual(&one, &Unobserved, &mut |_| {}).unwrap_err().to_string();
        assert!(refused.contains("there is no instance 3"), "{refused}");
        let progress = Shared::default();
        progress.cancel();
        assert!(individual(&job("starling"), &progress, &mut |_| {}).unwrap_err().is_interrupted());
    }
}
