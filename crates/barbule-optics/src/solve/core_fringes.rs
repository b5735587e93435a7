//! Fringes of the film that a barbule's core is, and what the mean over individuals leaves of them.
//!
//! Light that crosses the core, returns from the lower side and meets what the upper layers reflect makes fringes with a
//! period of λ²/(2 n d). They are true of one flat barbule. The mean over individuals keeps them where the model
//! makes all cores alike, and then they look like peaks of the structure.

use crate::Result;
use crate::solve::swatch::Columns;
use crate::spectrum::Wavelengths;
use crate::structure::{GeneratorParameters, Section, Structure};

/// Individuals, and points of each, that are looked at.
const INDIVIDUALS: usize = 24;
const POINTS: usize = 4;
/// Thicknesses over one period of a fringe, whose mean has none: no harmonic under this one is left.
const PHASES: usize = 4;
/// Parts of the range of wavelengths that are told apart.
const BANDS: usize = 4;
/// Fringes count from this part of the mean reflectance on. With random phases the mean keeps 1/√individuals of them.
const LEAST_PART: f64 = 0.03;
const LEAST_KEPT: f64 = 0.5;

/// Fringes of the core in the mean over individuals, where they are strongest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoreFringes {
    /// Half of what lies between their tops and their troughs, as reflectance.
    pub amplitude: f64,
    /// The same as a part of the mean reflectance there.
    pub part: f64,
    /// Which part of a single individual's fringes the mean keeps.
    pub kept: f64,
    /// About which wavelength, nm.
    pub near_nm: f64,
    /// From one fringe to the next there, nm.
    pub period_nm: f64,
}

impl CoreFringes {
    /// Whether they may be taken for peaks of the structure: they are high enough to be seen, and the mean over individuals
    /// keeps most of them.
    #[must_use]
    pub fn mislead(&self) -> bool {
        self.part >= LEAST_PART && self.kept >= LEAST_KEPT
    }
}

/// Fringes of the core in the mean over the first so many individuals of a structure, at normal incidence on flat layers as
/// those under points of the top; none of structures that have no core between two sides, or wavelengths that are too few.
///
/// # Errors
/// A section cannot be made, or a medium has no index at a wavelength.
pub fn core_fringes(
    structure: &Structure,
    seed: u64,
    individuals: usize,
    at: &Wavelengths,
) -> Result<Option<CoreFringes>> {
    let Structure::Species(model) = structure else { return Ok(None) };
    let GeneratorParameters::Multilayer(parameters) = &model.parameters else { return Ok(None) };
    let Some(core) = parameters.core_region().filter(|_| at.len() >= 2 * BANDS) else { return Ok(None) };
    let mut sums = vec![Sums::default(); at.len()];
    let count = individuals.min(INDIVIDUALS);
    for index in 0..count {
        add(&structure.instance(seed, index)?, core, at, &mut sums)?;
    }
    Ok(strongest(at, &sums, count))
}

/// Of one wavelength: reflectance as it is and with the core's phases averaged, and their squared difference, summed over
/// individuals.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    reflectance: f64,
    fringe: f64,
    fringe_squared: f64,
    /// Optical thickness of the core, nm.
    path_nm: f64,
}

/// Adds one individual.
fn add(section: &Section, core: usize, at: &Wavelengths, sums: &mut [Sums]) -> Result<()> {
    let columns = Columns::under(section, POINTS)?;
    let depths: Vec<f64> = columns
        .points
        .iter()
        .map(|point| {
            let [above, below] = [core - 1, core].map(|k| section.boundaries[k].height(point.x_um));
            1e3 * (point.z_um - 0.5 * (above + below)) * point.normal[1]
        })
        .collect();
    for (&nm, sums) in at.iter().zip(sums) {
        let [mut reflectance, mut fringe, mut path, mut found] = [0.0; 4];
        for (column, depth) in columns.at(nm)?.iter().zip(&depths) {
            let Some((layer, index)) = column.layer_at(*depth) else { continue };
            let own = column.reflectance(nm)?;
            let mut mean = 0.0;
            for phase in 0..PHASES {
                let more = phase as f64 / PHASES as f64 * nm / (2.0 * index.re.max(0.1));
                mean += column.thickened(layer, more).reflectance(nm)? / PHASES as f64;
            }
            reflectance += own;
            fringe += own - mean;
            path += index.re * column.thickness_nm(layer);
            found += 1.0;
        }
        if found > 0.0 {
            sums.reflectance += reflectance / found;
            sums.fringe += fringe / found;
            sums.fringe_squared += (fringe / found) * (fringe / found);
            sums.path_nm += path / found;
        }
    }
    Ok(())
}

/// The strongest fringes among the parts of the range.
fn strongest(at: &Wavelengths, sums: &[Sums], individuals: usize) -> Option<CoreFringes> {
    let many = individuals as f64;
    let bands = (0..BANDS).filter_map(|band| {
        let part = band * at.len() / BANDS..(band + 1) * at.len() / BANDS;
        let mean = |value: &dyn Fn(&Sums) -> f64| {
            sums[part.clone()].iter().map(value).sum::<f64>() / part.len() as f64
        };
        // √2 times the root of the mean square of a cosine is its height.
        let amplitude = (2.0 * mean(&|s| (s.fringe / many) * (s.fringe / many))).sqrt();
        let single = (2.0 * mean(&|s| s.fringe_squared / many)).sqrt();
        let (reflectance, path_nm) = (mean(&|s| s.reflectance / many), mean(&|s| s.path_nm / many));
        let near_nm = at[part.start + part.len() / 2];
        (single > 0.0 && reflectance > 0.0 && path_nm > 0.0).then(|| CoreFringes {
            amplitude,
            part: amplitude / reflectance,
            kept: amplitude / single,
            near_nm,
            period_nm: near_nm * near_nm / (2.0 * path_nm),
        })
    });
    bands.reduce(|best, band| if band.part > best.part { band } else { best })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::film::{self, Polarization};
    use crate::material::Library;
    use crate::stack::Stack;
    use crate::structure::SpeciesModel;

    /// A film of keratin over melanin and a core of 2 µm.
    fn structure(lower: &str, core_spread: Option<f64>) -> Structure {
        let mut parameters = json!({
            "generator": "multilayer", "width_um": 20.0, "cortex_um": 0.28, "lower": lower, "core_um": 2.0, "spread": 0.05,
            "layers": [{ "medium": "melanin", "thickness_um": 0.1 }], "point_spacing_um": 0.2,
        });
        if let Some(spread) = core_spread {
            parameters["core_spread"] = spread.into();
        }
        let model =
            SpeciesModel::from_parameters("mine", "default", &parameters, Library::builtin()).unwrap();
        Structure::Species(Box::new(model))
    }

    fn found(lower: &str, core_spread: Option<f64>) -> Option<CoreFringes> {
        let at = Wavelengths::new((0..61).map(|i| 400.0 + 5.0 * f64::from(i)).collect::<Vec<_>>()).unwrap();
        core_fringes(&structure(lower, core_spread), 1, 50, &at).unwrap()
    }

    #[test]
    fn cores_that_are_alike_keep_their_fringes_and_a_spread_takes_them_out() {
        let alike = found("plain", None).unwrap();
        assert!(alike.mislead() && alike.part > 0.1 && alike.kept > 0.7, "{alike:?}");
        // The core and the cortex under it are one film of 2.28 µm of keratin, of index 1.545 at 660 nm.
        let period = alike.near_nm * alike.near_nm / (2.0 * 1.545 * 2280.0);
        assert!((alike.period_nm / period - 1.0).abs() < 0.03, "{alike:?} {period}");
        let spread = found("plain", Some(0.1)).unwrap();
        assert!(!spread.mislead() && spread.amplitude < 0.4 * alike.amplitude, "{spread:?}");
        assert_eq!(found("none", None), None);
        assert_eq!(
            core_fringes(&Structure::builtin("starling").unwrap(), 1, 5, &Wavelengths::usual()).unwrap(),
            None
        );
    }

    /// The transfer matrix of the flat mean as the second method: half of what lies between the highest and the lowest
    /// reflectance as the core's thickness runs through a fringe.
    #[test]
    fn the_amplitude_is_that_of_the_flat_film() {
        let at = Wavelengths::new((0..76).map(|i| 500.0 + 4.0 * f64::from(i)).collect::<Vec<_>>()).unwrap();
        let mut parameters = serde_json::to_value(match structure("plain", None) {
            Structure::Species(model) => model.parameters,
            other => panic!("{other:?}"),
        })
        .unwrap();
        parameters["spread"] = 0.0.into();
        parameters["layers"][0]["spread"] = 0.0.into();
        let model =
            SpeciesModel::from_parameters("mine", "default", &parameters, Library::builtin()).unwrap();
        let fringes = core_fringes(&Structure::Species(Box::new(model)), 1, 3, &at).unwrap().unwrap();
        let reflected = |more: f64| {
            let stack = format!("air/keratin:280/melanin:100/keratin:{}/keratin:280/air", 2000.0 + more);
            let stack = Stack::parse(&stack, &Library::builtin()).unwrap();
            film::response(&stack, fringes.near_nm, 0.0, Polarization::S).unwrap().reflected
        };
        let all = (0..80).map(|k| reflected(f64::from(k) * 2.5));
        let (low, high) = all.fold((1.0f64, 0.0f64), |(low, high), r| (low.min(r), high.max(r)));
        assert!((fringes.amplitude / (0.5 * (high - low)) - 1.0).abs() < 0.2, "{fringes:?} {low} {high}");
        assert!((fringes.kept - 1.0).abs() < 1e-9, "{fringes:?}");
    }
}
