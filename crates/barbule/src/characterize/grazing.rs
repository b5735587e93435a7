//! The nodes of a campaign that lie so near grazing incidence that the simulation does not hold.

use crate::brdf::fit::GrazingDirection;
use crate::scattering::statistics::Axes;
use crate::solve::surface::{LARGEST_MIRROR_ERROR, mirror_fraction};

/// The directions at which a flat perfect mirror `width_um` wide would be off by more than
/// [`LARGEST_MIRROR_ERROR`], with what it would reflect where it is furthest off.
pub(super) fn grazing(axes: &Axes, width_um: f64) -> Vec<GrazingDirection> {
    let mut found = Vec::new();
    for theta in 0..axes.cos_theta().len() {
        for phi in 0..axes.phis() {
            let (theta_i, phi_i) = (axes.theta_i(theta), axes.phi_i(phi));
            let off: Vec<f64> = axes
                .wavelengths_nm()
                .iter()
                .map(|&nm| mirror_fraction(width_um, nm, theta_i, phi_i))
                .filter(|mirror| (mirror - 1.0).abs() > LARGEST_MIRROR_ERROR)
                .collect();
            let furthest = off.iter().copied().max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()));
            if let Some(mirror_fraction) = furthest {
                found.push(GrazingDirection {
                    theta_deg: theta_i.to_degrees(),
                    phi_deg: phi_i.to_degrees(),
                    wavelengths: off.len(),
                    mirror_fraction,
                });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Wavelengths;

    #[test]
    fn the_default_grid_is_flagged_where_light_grazes_and_nowhere_else() {
        let steps: Vec<f64> = (1..=20).map(|i| f64::from(i) / 20.0).collect();
        let axes = Axes::new(&Wavelengths::new([400.0, 694.0]).unwrap(), steps.clone(), steps).unwrap();
        let found = grazing(&axes, 25.0);
        let at = |theta: f64, phi: f64| {
            found.iter().find(|g| (g.theta_deg - theta).abs() < 0.1 && (g.phi_deg - phi).abs() < 0.1)
        };
        let first = at(0.0, 87.13).unwrap();
        assert!(first.wavelengths == 2 && (0.6..0.8).contains(&first.mirror_fraction), "{first:?}");
        assert!(at(0.0, 0.0).is_none() && at(0.0, 60.0).is_none() && at(60.0, 0.0).is_none());
        // 20 by 20 directions, of which most hold.
        assert!((20..150).contains(&found.len()), "{}", found.len());
    }
}
