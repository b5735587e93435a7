//! Values for pictures of a BRDF: outgoing hemispheres in colour.

use glam::DVec3;
use rayon::prelude::*;

use super::evaluate::FeatherBrdf;
use crate::Result;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::Observer;

/// Wavelengths that a colour is made of, a multiple of four.
const SAMPLES: usize = 32;

/// Linear sRGB of f over the hemisphere of outgoing directions seen from above: ω_o = (x, y, √(1−x²−y²)) with x to the
/// right and y up, `size` × `size` pixels from the upper left corner, `None` outside the unit circle. A perfect white
/// diffuser has 1/π.
///
/// # Errors
/// None for a prepared BRDF; wavelengths that the progress does not accept would be refused.
pub fn hemisphere(
    brdf: &FeatherBrdf,
    wi: DVec3,
    instance: Option<u64>,
    size: usize,
) -> Result<Vec<Option<[f64; 3]>>> {
    let (first, last) = brdf.wavelength_range_nm();
    let step = (last - first).max(1.0) / (SAMPLES - 1) as f64;
    let nm: Vec<f64> = (0..SAMPLES).map(|k| first + k as f64 * step).collect();
    let weights = Observer::default().weights(&Wavelengths::new(nm.clone())?);
    let fours: Vec<[f32; 4]> =
        nm.as_chunks::<4>().0.iter().map(|four| four.map(|value| value as f32)).collect();
    let prepared: Vec<_> = fours.iter().map(|&four| brdf.prepare(four, wi)).collect();
    let instance = instance.map(|name| brdf.instance(name));
    let centre = 0.5 * size as f64;
    Ok((0..size * size)
        .into_par_iter()
        .map(|at| {
            let x = ((at % size) as f64 + 0.5 - centre) / centre;
            let y = -((at / size) as f64 + 0.5 - centre) / centre;
            let z2 = 1.0 - x * x - y * y;
            (z2 > 0.0).then(|| {
                let wo = DVec3::new(x, y, z2.sqrt());
                let mut samples = [0.0; SAMPLES];
                for (out, prepared) in samples.as_chunks_mut::<4>().0.iter_mut().zip(&prepared) {
                    *out = prepared.eval(wo, instance.as_ref()).map(f64::from);
                }
                weights.linear_rgb(&samples)
            })
        })
        .collect())
}

/// The directions above the centres of `size` × `size` cells over the hemisphere seen from above, those inside the unit
/// circle: row by row from y = −1 up, x rising within a row, as x = (2i + 1)/size − 1.
#[must_use]
pub fn projected_grid(size: usize) -> Vec<DVec3> {
    let centre = |k: usize| (2 * k + 1) as f64 / size as f64 - 1.0;
    let cells = (0..size).flat_map(|row| (0..size).map(move |column| (centre(column), centre(row))));
    cells
        .filter(|(x, y)| x * x + y * y < 1.0)
        .map(|(x, y)| DVec3::new(x, y, (1.0 - x * x - y * y).sqrt()))
        .collect()
}
