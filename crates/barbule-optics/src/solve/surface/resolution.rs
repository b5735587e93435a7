//! How finely the structure under a campaign's points must be sampled.

use num_complex::Complex;

use super::CAMPAIGN_ELEMENT_UM;
use super::batch::{Batch, Buffers, unless_cancelled};
use super::cone::Cone;
use super::points::Points;
use super::rays::Rays;
use super::reflector::Reflector;
use super::table::ReflectanceTable;
use crate::Result;
use crate::math::simd::Width;
use crate::progress::Progress;
use crate::scattering::far_field::{IncidentLight, Window};
use crate::structure::Section;

/// Change of a field (relative L2) under halving from which on rays are dense enough. What is left is a third of it,
/// and other instances and directions have up to thrice as much.
const SETTLED: f64 = 6.0e-4;

/// The most parts that elements are cut into for rays.
pub const MOST_RAY_PARTS: usize = 8;

/// The parts into which elements must be cut for rays under all of some sections at a vacuum wavelength (nm) and normal
/// incidence. Averages along the top vary no faster than their Gaussian, which points follow by themselves: one part.
///
/// # Errors
/// A section cannot be prepared, a medium's table does not reach, or the user cancelled.
#[inline(never)]
pub fn ray_parts(
    sections: &[Section],
    wavelength_nm: f64,
    width: Width,
    progress: &dyn Progress,
) -> Result<usize> {
    let mut parts = 1;
    for section in sections.iter().filter(|section| section.smooth_um.is_none()) {
        let points = Points::new(section, CAMPAIGN_ELEMENT_UM, Window::Gaussian)?;
        let field = |parts: usize| -> Result<Vec<Complex<f32>>> {
            let rays = match parts {
                1 => Rays::under(&points, 1),
                _ => Rays::cast(section, CAMPAIGN_ELEMENT_UM, parts, None)?,
            };
            let table = ReflectanceTable::new(width, &points, &rays, wavelength_nm, progress)?;
            let cone = Cone::new(wavelength_nm, 0.0, points.radius_um);
            let batch = Batch { cone: &cone, phi_i: &[0.0], lights: &[IncidentLight::PlaneWave] };
            let mut buffers = Buffers::new(width);
            buffers.radiate(&points, &Reflector::Tabulated(table), &batch, &mut |_| {
                unless_cancelled(progress)
            })?;
            Ok(buffers.coefficients)
        };
        let mut coarse = field(parts)?;
        while parts < MOST_RAY_PARTS {
            unless_cancelled(progress)?;
            let fine = field(2 * parts)?;
            let change: f64 = coarse.iter().zip(&fine).map(|(a, b)| f64::from((a - b).norm_sqr())).sum();
            let whole: f64 = fine.iter().map(|v| f64::from(v.norm_sqr())).sum();
            if change <= SETTLED * SETTLED * whole {
                break;
            }
            parts *= 2;
            coarse = fine;
        }
    }
    Ok(parts)
}
