//! What barbules look like in the preview of USD.

use super::osl::{Distribution, Facets, even_roughness};
use crate::brdf::FeatherBrdf;
use crate::io::UsdLook;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::{Observer, into_gamut};
use crate::{DVec3, Result};

/// The preview of a material with this name and BLAKE3: the colour of all light that it reflects to an eye over it, and the roughness of
/// its narrow part, the same in all directions. Angles, speckle and the lobe's shape are lost.
///
/// # Errors
/// None with the wavelengths that are taken.
pub fn look(brdf: &FeatherBrdf, material: &str, material_hash: &str) -> Result<UsdLook> {
    let nm: Vec<f64> = (0..=30).map(|k| 400.0 + 10.0 * f64::from(k)).collect();
    let reflected: Vec<f64> = nm.iter().map(|nm| brdf.albedo(*nm as f32, DVec3::Z)).collect();
    let weights = Observer::default().weights(&Wavelengths::new(nm)?);
    Ok(UsdLook {
        colour: into_gamut(weights.linear_rgb(&reflected)).map(|v| v.min(1.0)),
        roughness: even_roughness(brdf)?,
        material: material.to_owned(),
        material_hash: material_hash.to_owned(),
    })
}

/// Linear sRGB of f cosθ_o in 1/sr as a program draws the preview: a metal of GGX facets, whose colour grows to white at grazing incidence
/// by Schlick's formula.
#[must_use]
pub fn value(look: &UsdLook, wi: DVec3, wo: DVec3) -> [f64; 3] {
    let alpha = look.roughness * look.roughness;
    let facets = Facets { distribution: Distribution::Ggx, along: alpha, across: alpha };
    let grazing = (1.0 - wi.dot((wi + wo).normalize()).clamp(0.0, 1.0)).powi(5);
    let shape = facets.value(wi, wo);
    look.colour.map(|colour| (colour + (1.0 - colour) * grazing) * shape)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Options;
    use crate::brdf::fixtures::example;

    #[test]
    fn the_preview_is_green_and_neither_smooth_nor_dull() {
        let brdf = FeatherBrdf::new(&example(8), Options::default()).unwrap();
        let look = look(&brdf, "example", "00").unwrap();
        let [r, g, b] = look.colour;
        assert!(g > r && g > b && g < 0.4, "{look:?}");
        assert!((0.15..0.6).contains(&look.roughness), "{look:?}");
    }
}
