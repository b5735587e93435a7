//! Whether a structure reflects light from its left as from its right: campaigns simulate φ_i ≥ 0 alone, and materials
//! take both sides alike.

use num_complex::Complex;

use super::spectrum::{Collect, SpectrumRequest, fractions};
use crate::Result;
use crate::progress::Progress;
use crate::spectrum::Wavelengths;
use crate::structure::Structure;

/// Azimuths at which both sides are lit, degrees.
const PHI_DEG: [f64; 3] = [15.0, 30.0, 60.0];

/// Instances that are lit, at most.
const MOST_INSTANCES: usize = 8;

/// Sides that differ by less than this part of what they reflect count as alike.
const SLIGHT: f64 = 0.05;

/// Differences of means that are below so many standard errors count as chance. Of 27 comparisons of eight individuals
/// (Student's t with seven degrees of freedom) one in twenty sets has one beyond.
const STANDARD_ERRORS: f64 = 5.0;

/// Where nothing is reflected nothing differs.
const DARK: f64 = 1e-4;

/// How much both sides of a structure differ, where they differ most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asymmetry {
    /// The difference of what both sides reflect, in all or beyond or short of the mirror direction, as a part of what
    /// they reflect in the mean.
    pub part: f64,
    /// Whether it is more than a twentieth and more than chance.
    pub is_certain: bool,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// φ_i of the right side, degrees.
    pub phi_deg: f64,
    /// Mean reflected fraction of light from φ_i and from −φ_i.
    pub reflected: [f64; 2],
    /// The part of it that leaves beyond the mirror direction, towards the horizon.
    pub beyond: [f64; 2],
}

/// What one wavelength and azimuth say.
struct Look {
    wavelength_nm: f64,
    phi_deg: f64,
    /// Means over instances, `[side][all, beyond]`.
    means: [[f64; 2]; 2],
    /// Right less left over what both reflect in the mean, `[instance][all, beyond, short]`.
    differences: Vec<[f64; 3]>,
}

/// Compares both sides of up to eight instances at θ_i = 0; `None` where a structure cannot differ but by chance.
///
/// # Errors
/// As [`spectra`](super::spectrum::spectra).
pub fn asymmetry(
    structure: &Structure,
    seed: u64,
    instances: usize,
    wavelengths_nm: &[f64],
    progress: &dyn Progress,
) -> Result<Option<Asymmetry>> {
    if !structure.can_be_one_sided() {
        return Ok(None);
    }
    let last = wavelengths_nm.len().saturating_sub(1);
    let mut nm: Vec<f64> =
        [0, last / 2, last].iter().filter_map(|&w| wavelengths_nm.get(w).copied()).collect();
    nm.dedup();
    let request = SpectrumRequest {
        wavelengths: Wavelengths::new(nm)?,
        directions: PHI_DEG
            .iter()
            .flat_map(|phi| [(0.0, phi.to_radians()), (0.0, -phi.to_radians())])
            .collect(),
        instances: instances.min(MOST_INSTANCES).min(structure.count().unwrap_or(usize::MAX)),
        seed,
        collect: Collect::Hemisphere,
        polarization: [0.5, 0.5],
    };
    let both = |field: &[Complex<f32>], (_, phi_i): (f64, f64)| all_and_beyond(field, phi_i);
    let fractions = fractions(structure, &request, &both, progress)?;
    Ok(worst(&looks(&request, &fractions)))
}

/// ∫|E|² dφ_o over all azimuths and over those beyond the mirror direction.
fn all_and_beyond(field: &[Complex<f32>], phi_i: f64) -> [f64; 2] {
    let step = std::f64::consts::PI / field.len() as f64;
    field.iter().enumerate().fold([0.0; 2], |[all, beyond], (n, value)| {
        let power = f64::from(value.norm_sqr()) * step;
        // How far the azimuth's cell lies beyond the mirror direction −φ_i.
        let middle = (n as f64 + 0.5) * step - std::f64::consts::FRAC_PI_2;
        let over = -phi_i.signum() * (middle + phi_i);
        [all + power, beyond + power * (over / step + 0.5).clamp(0.0, 1.0)]
    })
}

/// `fractions` are `[instance][direction · wavelength][all, beyond]`, directions in pairs.
fn looks(request: &SpectrumRequest, fractions: &[Vec<[f64; 2]>]) -> Vec<Look> {
    let columns = request.wavelengths.len();
    let count = fractions.len() as f64;
    let mut looks = Vec::new();
    for (pair, &phi_deg) in PHI_DEG.iter().enumerate() {
        for (column, &wavelength_nm) in request.wavelengths.iter().enumerate() {
            let at = |side: usize| (2 * pair + side) * columns + column;
            let means = [0, 1].map(|side| {
                [0, 1].map(|k| fractions.iter().map(|own| own[at(side)][k]).sum::<f64>() / count)
            });
            let reflected = 0.5 * (means[0][0] + means[1][0]);
            if reflected < DARK {
                continue;
            }
            let difference = |own: &Vec<[f64; 2]>| {
                let [all, beyond] = [0, 1].map(|k| (own[at(0)][k] - own[at(1)][k]) / reflected);
                [all, beyond, all - beyond]
            };
            let differences = fractions.iter().map(difference).collect();
            looks.push(Look { wavelength_nm, phi_deg, means, differences });
        }
    }
    looks
}

/// The largest difference that is certain, or else the largest at all.
fn worst(looks: &[Look]) -> Option<Asymmetry> {
    let mean = |look: &Look, k: usize| {
        look.differences.iter().map(|d| d[k]).sum::<f64>() / look.differences.len() as f64
    };
    let variance = |look: &Look, k: usize| {
        let (mean, count) = (mean(look, k), look.differences.len() as f64);
        let squares = look.differences.iter().map(|d| (d[k] - mean).powi(2)).sum::<f64>();
        squares / (count - 1.0).max(1.0) / count
    };
    // Few instances know little of their spread, which is about that at the other angles and wavelengths.
    let usual = [0, 1, 2]
        .map(|k| looks.iter().map(|look| variance(look, k)).sum::<f64>() / looks.len().max(1) as f64);
    let found = looks.iter().flat_map(|look| {
        [0, 1, 2].map(|k| {
            let part = mean(look, k).abs();
            let error = variance(look, k).max(usual[k]).sqrt();
            (part, part > SLIGHT && part > STANDARD_ERRORS * error, look)
        })
    });
    let (part, is_certain, look) = found.max_by(|a, b| a.1.cmp(&b.1).then(a.0.total_cmp(&b.0)))?;
    Some(Asymmetry {
        part,
        is_certain,
        wavelength_nm: look.wavelength_nm,
        phi_deg: look.phi_deg,
        reflected: look.means.map(|[all, _]| all),
        beyond: look.means.map(|[all, beyond]| if all > 0.0 { beyond / all } else { 0.0 }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;
    use crate::progress::Unobserved;
    use crate::structure::{Medium, Parts, Polyline, Section};

    /// A keratin film whose sides slope by `left` and `right`, with a ridge between.
    fn ridge(left: f64, right: f64) -> Structure {
        let top = |depth: f64| Polyline {
            x_um: vec![-10.0, 0.0, 10.0],
            z_um: vec![-10.0 * left - depth, -depth, -10.0 * right - depth],
        };
        let parts = Parts {
            name: "ridge".into(),
            width_um: Some(20.0),
            boundaries: vec![top(0.0), top(0.3)],
            media: ["air", "keratin", "air"].map(Medium::named).to_vec(),
            ..Parts::default()
        };
        let section = Section::new(parts, Library::builtin()).unwrap();
        Structure::Sections { name: "ridge".into(), sections: vec![section] }
    }

    fn found(structure: &Structure, instances: usize) -> Option<Asymmetry> {
        asymmetry(structure, 1, instances, &[400.0, 550.0, 694.0], &Unobserved).unwrap()
    }

    #[test]
    fn a_slanted_film_is_one_sided_and_an_even_ridge_is_not() {
        let even = found(&ridge(0.15, 0.15), 1).unwrap();
        assert!(!even.is_certain && even.part < 1e-4, "{even:?}");
        let slanted = found(&ridge(-0.3, 0.3), 1).unwrap();
        assert!(slanted.is_certain && slanted.part > 0.3, "{slanted:?}");
        assert!(slanted.reflected[0] != slanted.reflected[1]);
        // The other way round the sides change places.
        let other = found(&ridge(0.3, -0.3), 1).unwrap();
        assert!((other.reflected[0] - slanted.reflected[1]).abs() < 1e-5, "{other:?}");
        assert!((other.part - slanted.part).abs() < 1e-4);
    }

    #[test]
    fn a_lobe_that_leans_is_seen_where_as_much_is_reflected() {
        let leaning = found(&ridge(-0.02, 0.02), 1).unwrap();
        assert!(leaning.is_certain, "{leaning:?}");
        let [right, left] = leaning.reflected;
        let (all, lobe) = ((right / left - 1.0).abs(), (leaning.beyond[0] - leaning.beyond[1]).abs());
        assert!(lobe > 0.2 && all < 0.5 * leaning.part, "{leaning:?}");
    }

    #[test]
    fn individuals_of_a_species_differ_by_chance_alone() {
        assert_eq!(found(&Structure::builtin("starling").unwrap(), 8), None);
        for seed in 1..4 {
            let species = Structure::builtin("rock-dove").unwrap();
            let sections = (0..8).map(|k| species.instance(seed, k).unwrap()).collect();
            let given = Structure::Sections { name: "given".into(), sections };
            let found = found(&given, 8).unwrap();
            assert!(!found.is_certain, "{seed}: {found:?}");
        }
    }
}
