//! Birds that see and the light in which they do, as people type them.

use std::path::Path;

use barbule_birds::EYES;

use super::{Opening, is_built_in, structure};
use crate::campaign::spectrum::{Collect, SpectrumRequest, spectra_and_individuals};
use crate::error::{did_you_mean, shortened};
use crate::io::measured::{Scale, read_measured};
use crate::io::{InputKind, kind_of, read_eye};
use crate::progress::Progress;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::vision::{Eye, Light};
use crate::{Error, Result};

/// What stands before a file of a light in quanta.
const QUANTA: &str = "quanta:";

/// The names of the eyes that are built in.
pub fn eye_names() -> impl Iterator<Item = &'static str> + Clone {
    EYES.iter().map(|(name, _, _)| *name)
}

/// An eye by its name or another that people use for the bird, or from a file ([`read_eye`]). Names come before files.
///
/// # Errors
/// There is neither, or the file is no eye.
pub fn eye(text: &str) -> Result<Eye> {
    let plain = text.trim().to_lowercase().replace([' ', '_'], "-");
    let is_it = |(name, also, _): &&barbule_birds::Eye| *name == plain || also.contains(&plain.as_str());
    if let Some((name, _, table)) = EYES.iter().find(is_it) {
        return Eye::parse(table, name);
    }
    let path = Path::new(text);
    if path.exists() {
        return read_eye(path);
    }
    let names: Vec<&str> = eye_names().collect();
    let also = EYES.iter().flat_map(|(_, also, _)| also.iter().copied());
    let near = did_you_mean(&plain.chars().take(200).collect::<String>(), names.iter().copied().chain(also));
    Err(Error::input(format!(
        "there is no eye '{}'{near}; give {}, or a file of one (.toml, .csv)",
        shortened(text),
        names.join(", ")
    )))
}

/// A light by its name ([`Light::NAMES`]), or from a file of power per nm, or of quanta per nm with `quanta:` before it, read as
/// measured spectra are.
///
/// # Errors
/// There is neither, or the file is no light.
pub fn light(text: &str) -> Result<Light> {
    let (file, is_quanta) = text.strip_prefix(QUANTA).map_or((text, false), |file| (file, true));
    let named = Light::named(text);
    if named.is_ok() || !(is_quanta || Path::new(file).exists()) {
        return named.map_err(|error| error.followed_by(", or give a file of wavelengths in nm and power"));
    }
    let table = read_measured(Path::new(file), None, Some(Scale::Power))?;
    if let [first, second, ..] = &table.samples[..] {
        return Err(Error::input(format!(
            "'{}' and '{}' are {} lights; leave one of them in the file",
            first.name,
            second.name,
            if table.samples.len() == 2 { "two" } else { "two of several" }
        ))
        .at(file));
    }
    let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
    Light::of_table(&name, &table.mean, is_quanta).map_err(|error| error.at(file))
}

/// How structures are simulated where what is seen is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// At which wavelengths.
    pub wavelengths: Wavelengths,
    /// Angle of incidence across the barbule, radians.
    pub angle: f64,
    /// Random individuals.
    pub instances: usize,
}

/// A thing that is seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Thing {
    /// What people call it.
    pub name: String,
    /// The mean over individuals or samples, or one sample.
    pub reflectance: Spectrum,
    /// How a measurement was read.
    pub reading: Option<String>,
    /// Whether keratin in it is taken to be clear in the ultraviolet, where it is not.
    pub has_guess: bool,
}

/// The things of a text: those of a measured file (its mean, or with `each_sample` every sample by itself), or else of a structure.
///
/// # Errors
/// As [`read_measured`], [`structure`] or the simulation.
pub fn things(
    text: &str,
    each_sample: bool,
    simulation: &Simulation,
    opening: &Opening,
    progress: &dyn Progress,
) -> Result<Vec<Thing>> {
    let path = Path::new(text);
    if !is_built_in(text) && path.is_file() && kind_of(path)? == InputKind::Other {
        let found = read_measured(path, None, None)?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let thing = |name, reflectance| Thing {
            name,
            reflectance,
            reading: Some(found.reading.clone()),
            has_guess: false,
        };
        let samples =
            || found.samples.iter().map(|s| thing(format!("{stem} {}", s.name), s.spectrum.clone()));
        return Ok(if each_sample { samples().collect() } else { vec![thing(stem, found.mean.clone())] });
    }
    let structure = structure(text, opening, progress)?;
    let at = &simulation.wavelengths;
    let request = SpectrumRequest {
        wavelengths: at.clone(),
        directions: vec![(0.0, simulation.angle)],
        instances: structure.count().map_or(simulation.instances, |given| given.min(simulation.instances)),
        seed: opening.seed,
        collect: Collect::Hemisphere,
        polarization: [0.5; 2],
    };
    let (found, _) = spectra_and_individuals(&structure, &request, progress)?;
    Ok(vec![Thing {
        name: shortened(text),
        reflectance: Spectrum::new(at.clone(), found.mean[0].clone())?,
        reading: None,
        has_guess: opening.media.guesses_in(&structure, opening.seed, at.range_nm().0),
    }])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::View;

    #[test]
    fn built_in_eyes_peak_where_it_is_published() {
        let peaks = |name: &str| eye(name).unwrap().cones.iter().map(|c| c.peak_nm).collect::<Vec<_>>();
        for (name, published) in [
            // Of pavo's data on the starling.
            ("starling", [368.0, 454.0, 546.0, 606.0]),
            // Hart 2002, abstract.
            ("peafowl", [432.0, 477.0, 537.0, 605.0]),
            // The formulas with the same numbers in another program (NumPy); the longest in Hart et al. 2000: 563 + "some 40 nm".
            ("blue-tit", [375.0, 459.0, 537.0, 603.0]),
        ] {
            for (found, published) in peaks(name).into_iter().zip(published) {
                assert!((found - published).abs() <= 5.0, "{name}: {found} {published}");
            }
        }
        assert_eq!(peaks("Sturnus vulgaris"), peaks("star"));
    }

    #[test]
    fn every_eye_says_where_its_numbers_come_from_and_sees_in_every_light() {
        for name in eye_names() {
            let eye = eye(name).unwrap();
            assert!(eye.cones.len() == 4 && eye.double.is_some() && eye.sources.len() == 4, "{name}");
            assert!(eye.all_cones().all(|cone| !cone.source.is_empty()), "{name}");
            let spans = eye.cones.windows(2).map(|pair| pair[1].peak_nm - pair[0].peak_nm);
            assert!(spans.into_iter().all(|span| span > 40.0), "{name}");
            for (light, _) in Light::NAMES {
                let [low, high] = View::new(eye.clone(), Light::named(light).unwrap()).unwrap().needed_nm();
                assert!(low >= 300.0 && high <= 700.0, "{name} {light}: {low} {high}");
            }
        }
    }

    #[test]
    fn lights_come_from_files_of_power_and_of_quanta() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lamp.csv").to_string_lossy().into_owned();
        std::fs::write(&path, "wl,power\n300,2\n560,2\n830,2\n").unwrap();
        assert_eq!(light(&path).unwrap().quanta.at(700.0), 2.5);
        assert_eq!(light(&format!("quanta:{path}")).unwrap().quanta.at(700.0), 2.0);
        for name in ["irradiance", "Radiance", "counts", "intensity 1"] {
            std::fs::write(&path, format!("wl,{name}\n300,2\n560,2\n830,2\n")).unwrap();
            assert_eq!(light(&path).unwrap().quanta.at(700.0), 2.5, "{name}");
        }
        std::fs::write(&path, "wl,lamp1,lamp2\n300,2,1\n560,2,1\n830,2,1\n").unwrap();
        let message = light(&path).unwrap_err().to_string();
        assert!(message.contains("lamp.csv: 'lamp1' and 'lamp2' are two lights; leave one"), "{message}");
        assert_eq!(light("d65").unwrap().name, "D65");
        let message = light("forrest").unwrap_err().to_string();
        assert!(
            message.contains("did you mean 'forest'?") && message.contains("or give a file"),
            "{message}"
        );
        assert!(light("quanta:none.csv").unwrap_err().is_input());
        let message = eye("starlin").unwrap_err().to_string();
        assert!(message.contains("did you mean 'starling'?") && message.contains("average-uvs"), "{message}");
    }
}
