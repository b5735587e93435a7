//! What materials read in measuring instruments: their smooth BRDF integrated over both apertures.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::brdf::{FeatherBrdf, FeatherMaterial, Options, reflected_fractions};
use crate::campaign::spectrum::{Lobes, Mount, Tilted, Vane};
use crate::instrument::Instrument;
use crate::progress::{OnlyStops, Progress};
use crate::scattering::directions::omega;
use crate::scattering::far_field::Polarization;
use crate::spectrum::Wavelengths;
use crate::{DVec3, Error, Result};

/// Distances of nodes in the middle of an aperture, rad, and their number at most: incident longitudes and azimuths, outgoing
/// longitudes and azimuths. A lobe along the barbule is 0.06 wide (σ√2), one across it 0.04 and more.
const STEPS: [(f64, usize); 4] = [(0.06, 36), (0.025, 48), (0.025, 96), (0.012, 128)];

/// Standard deviation of lobes across barbules, rad, at least.
const LOBE_ACROSS: f64 = 0.025;

/// Readings of the smooth mean of a material, `[mount][wavelength]`, beside a perfect white diffuser; of unpolarized light, or of one
/// incident polarization of a material that has them.
///
/// Barbules of the material are spread already, along their axes by its σ and about them by its campaign's tilt; those of
/// [`Mount::tilt`] come on top.
///
/// # Errors
/// A wavelength beyond the material's, a polarization that it lacks, an instrument that does not face the feather, or a stop by
/// `progress`.
pub fn of_material(
    material: &FeatherMaterial,
    wavelengths: &Wavelengths,
    mounts: &[Mount],
    polarization: Option<Polarization>,
    progress: &dyn Progress,
) -> Result<Vec<Vec<f64>>> {
    mounts.iter().try_for_each(Mount::check)?;
    let nm = wavelengths.nm();
    let nodes = material.axes.wavelengths_nm();
    let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
    if let Some(bad) = nm.iter().find(|nm| !(first..=last).contains(*nm)) {
        return Err(Error::input(format!(
            "{bad} nm is outside {first} to {last} nm, the wavelengths that the material is known at; give others, or characterize the structure at these"
        )));
    }
    let brdf = FeatherBrdf::new(&material.around(nm)?, Options { polarization, ..Options::default() })?;
    progress.begin("reading", mounts.len() as u64);
    mounts
        .iter()
        .map(|mount| {
            let found = match mount.instrument {
                Instrument::Sphere => of_sphere(&brdf, nm, mount, progress)?,
                _ => of_apertures(&brdf, nm, mount, progress)?,
            };
            progress.advance(1);
            Ok(found)
        })
        .collect()
}

fn of_sphere(brdf: &FeatherBrdf, nm: &[f64], mount: &Mount, progress: &dyn Progress) -> Result<Vec<f64>> {
    let mut sums = vec![0.0; nm.len()];
    if mount.vane.is_some() {
        return of_apertures(brdf, nm, mount, progress);
    }
    for Tilted { lit, weight, .. } in mount.tilted(lobes(brdf)) {
        let (theta, phi) = lit.direction();
        let wi = omega(theta, phi);
        if wi.z > 0.0 {
            let found = reflected_fractions(brdf, nm, wi, None, &OnlyStops(progress))?;
            sums.iter_mut().zip(found).for_each(|(sum, part)| *sum += weight * wi.z * mount.scale() * part);
        }
    }
    Ok(sums)
}

fn of_apertures(brdf: &FeatherBrdf, nm: &[f64], mount: &Mount, progress: &dyn Progress) -> Result<Vec<f64>> {
    let scale = mount.scale();
    let mut sums = vec![0.0; nm.len()];
    for tilted in mount.tilted(lobes(brdf)) {
        let [mut lit, seen] = [(tilted.lit, 0), (tilted.seen, 2)].map(|(beam, kind)| {
            nodes(beam.theta_range(), &|theta| beam.azimuths(theta), [STEPS[kind], STEPS[kind + 1]])
        });
        if matches!(mount.instrument, Instrument::Sphere) {
            let (theta, phi) = tilted.lit.direction();
            let wi = omega(theta, phi);
            lit = if wi.z > 0.0 { vec![(wi, wi.z)] } else { Vec::new() };
        }
        // In order, so that sums do not depend on threads.
        let parts: Vec<Vec<f64>> = lit
            .par_iter()
            .map(|(wi, weight)| {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                Ok(from(brdf, nm, *wi, &seen, tilted.vane.as_ref())
                    .into_iter()
                    .map(|sum| sum * weight)
                    .collect())
            })
            .collect::<Result<_>>()?;
        for part in parts {
            sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += scale * tilted.weight * part);
        }
    }
    Ok(sums)
}

/// The material's narrowest lobes, for [`Mount::tilted`].
fn lobes(brdf: &FeatherBrdf) -> Lobes {
    let widest = brdf.halo_sigmas().iter().fold(brdf.sigma(), |widest, sigma| widest.max(*sigma));
    Lobes { along: [brdf.sigma(), widest], across: LOBE_ACROSS }
}

/// ∫ f cosθ_o dω_o over the nodes, for each wavelength.
fn from(brdf: &FeatherBrdf, nm: &[f64], wi: DVec3, seen: &[(DVec3, f64)], vane: Option<&Vane>) -> Vec<f64> {
    let fours = nm.len().div_ceil(4);
    let four = |k: usize| std::array::from_fn(|j| nm[(4 * k + j).min(nm.len() - 1)] as f32);
    let pairs: Vec<[DVec3; 2]> = seen.iter().map(|(wo, _)| [wi, *wo]).collect();
    let asked: Vec<[f32; 4]> = (0..pairs.len()).flat_map(|_| (0..fours).map(four)).collect();
    let mut values = vec![[0.0; 4]; asked.len()];
    brdf.eval_all(&pairs, &asked, None, &mut values);
    let mut sums = vec![0.0; nm.len()];
    let azimuth = |w: &DVec3| w.x.atan2(w.z);
    for (values, (wo, weight)) in values.chunks_exact(fours).zip(seen) {
        let weight = weight * vane.map_or(1.0, |vane| vane.shared(azimuth(&wi), azimuth(wo)));
        for (sum, value) in sums.iter_mut().zip(values.as_flattened()) {
            *sum += weight * f64::from(*value);
        }
    }
    sums
}

/// Directions inside a cone and their ∫ cosθ dω: longitudes middle − reach cos u, evenly over u, and even azimuths.
fn nodes(
    [from, to]: [f64; 2],
    azimuths: &dyn Fn(f64) -> Option<[f64; 2]>,
    [longitudes, across]: [(f64, usize); 2],
) -> Vec<(DVec3, f64)> {
    let (middle, reach) = (0.5 * (from + to), 0.5 * (to - from));
    let count = ((2.0 * reach / longitudes.0).ceil() as usize).clamp(8, longitudes.1);
    let mut nodes = Vec::new();
    for j in 0..count {
        let u = PI * (j as f64 + 0.5) / count as f64;
        let theta = middle - reach * u.cos();
        let Some([left, right]) = azimuths(theta) else { continue };
        let cells = (((right - left) / across.0).ceil() as usize).clamp(4, across.1);
        let step = (right - left) / cells as f64;
        let weight = reach * u.sin() * PI / count as f64 * theta.cos().powi(2) * step;
        for cell in 0..cells {
            let phi = left + (cell as f64 + 0.5) * step;
            nodes.push((omega(theta, phi), weight * phi.cos()));
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = 1/π sent through the same nodes reads 1: their weights are the projected solid angles.
    #[test]
    fn a_perfect_white_reads_one() {
        for (instrument, turned_deg) in [
            ("probe:10", 0.0),
            ("probe:45", 30.0),
            ("arms:40,20,15", 5.0),
            ("microscope:0.6", 0.0),
            ("probe:90", 0.0),
        ] {
            for along in [false, true] {
                let mount = Mount {
                    instrument: Instrument::parse(instrument).unwrap(),
                    turned: f64::to_radians(turned_deg),
                    along,
                    about_normal: 0.3,
                    tilt: [0.0; 2],
                    vane: None,
                };
                let one = mount.tilted(Lobes { along: [0.0; 2], across: LOBE_ACROSS })[0];
                let area = |beam: crate::campaign::spectrum::Beam, kind| {
                    let all = nodes(
                        beam.theta_range(),
                        &|theta| beam.azimuths(theta),
                        [STEPS[kind], STEPS[kind + 1]],
                    );
                    all.iter().map(|node| node.1).sum::<f64>()
                };
                let white = mount.scale() * area(one.lit, 0) * area(one.seen, 2) / PI;
                // Cones that the horizon cuts are the worst.
                assert!((white - 1.0).abs() < 2e-3, "{instrument} at {turned_deg}°: {white}");
            }
        }
    }
}
