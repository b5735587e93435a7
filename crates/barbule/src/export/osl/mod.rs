//! A material as a shader in the Open Shading Language with a table beside it, as Blender's Cycles reads them.
//!
//! A shader of this kind sees where the eye is, not where the light is: it says which rough mirrors a surface has, and Cycles lights them.
//! So a table says how bright and of which colour the mirrors are for each direction of the eye, and their roughness is the same for all.
//! What each view sees of light from everywhere is the material's own; how that is spread over the directions of light is as near as two
//! kinds of facets can be.

mod facets;
mod fit;

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

pub use facets::{Distribution, Facets};
pub use fit::Lobes;

use crate::brdf::FeatherBrdf;
use crate::progress::Progress;
use crate::scattering::directions::omega;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::{Observer, into_gamut};
use crate::{DVec3, Error, Result};
use fit::{ALPHAS, MOST_SLANT, WAVES, waves};

/// Nodes of the table: longitudes θ from 0° to 90°, of which the sign does not matter, and azimuths φ from −90° to 90°, 7.5° and 5° apart.
const THETAS: usize = 13;
const PHIS: usize = 37;

/// Nodes at 90° have what is seen here.
const GRAZING_DEG: f64 = 88.5;

/// Steps of the facets' albedos that colours are divided by.
const ALBEDO_STEPS: usize = 40;

/// Barbules of a table, at most.
pub const MOST_BARBULES: usize = 1024;

/// A material as Cycles evaluates it.
#[derive(Debug, Clone, PartialEq)]
pub struct OslMaterial {
    lobes: Lobes,
    barbules: usize,
    /// Linear sRGB that facets are multiplied with, `[1 + barbules, θ, φ]`: of the mean, then of each barbule.
    table: Vec<[f32; 3]>,
}

impl OslMaterial {
    /// Fits facets to a material and tabulates its colours, with so many barbules beside the mean; `progress` counts directions of the
    /// eye.
    ///
    /// A barbule's colour is the mean's times what it reflects in the mirror direction over what the mean does there, so that barbules
    /// differ as much as the material's do; their mean is the mean but for colours that sRGB cannot show.
    ///
    /// # Errors
    /// Over [`MOST_BARBULES`], or a stop by `progress`.
    pub fn of(brdf: &FeatherBrdf, barbules: usize, progress: &dyn Progress) -> Result<Self> {
        if barbules > MOST_BARBULES {
            return Err(Error::input(format!(
                "{barbules} barbules are over the limit of {MOST_BARBULES} of a table; take fewer"
            )));
        }
        progress.begin("table", (THETAS * PHIS) as u64);
        let lobes = fit::fitted(brdf)?;
        let nm = waves();
        let weights = Observer::default().weights(&Wavelengths::new(nm)?);
        let names: Vec<_> = (0..barbules as u64).map(|name| brdf.instance(name)).collect();
        let nodes: Vec<Vec<[f32; 3]>> = (0..THETAS * PHIS)
            .into_par_iter()
            .map(|node| {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let wi = view(node);
                let mirror = DVec3 { z: wi.z, ..-wi };
                let facets = lobes.albedo(wi, ALBEDO_STEPS);
                let albedo = nm.map(|nm| brdf.albedo(nm as f32, wi) / facets);
                let prepared = brdf.prepare(nm.map(|nm| nm as f32), wi);
                let own: Vec<[f64; WAVES]> =
                    names.iter().map(|name| prepared.eval(mirror, Some(name)).map(f64::from)).collect();
                let mean: [f64; WAVES] =
                    std::array::from_fn(|k| own.iter().map(|of| of[k]).sum::<f64>() / barbules.max(1) as f64);
                let shown = |waves: [f64; WAVES]| into_gamut(weights.linear_rgb(&waves)).map(|v| v as f32);
                let mut all = vec![shown(albedo)];
                all.extend(own.iter().map(|of| {
                    shown(std::array::from_fn(|k| {
                        albedo[k] * if mean[k] > 0.0 { of[k] / mean[k] } else { 1.0 }
                    }))
                }));
                progress.advance(1);
                Ok(all)
            })
            .collect::<Result<_>>()?;
        let table = (0..=barbules).flat_map(|row| nodes.iter().map(move |node| node[row])).collect();
        Ok(Self { lobes, barbules, table })
    }

    /// The fitted facets.
    #[must_use]
    pub fn lobes(&self) -> &Lobes {
        &self.lobes
    }

    /// Linear sRGB of f cosθ_o in 1/sr for the eye's direction `wi` and the light's, both above the horizon, as the shader has it of the
    /// mean: a perfect white has (1, 1, 1) cosθ_o/π.
    #[must_use]
    pub fn value(&self, wi: DVec3, wo: DVec3) -> [f64; 3] {
        let f = self.lobes.value(wi, wo);
        self.colour(0, wi).map(|v| v * f)
    }

    /// What all light from everywhere becomes for an eye in the direction `wi`, linear sRGB; `row` 0 is the mean, others are barbules.
    ///
    /// # Panics
    /// A row past the table.
    #[must_use]
    pub fn albedo(&self, row: usize, wi: DVec3) -> [f64; 3] {
        let facets = self.lobes.albedo(wi, ALBEDO_STEPS);
        self.colour(row, wi).map(|v| v * facets)
    }

    /// The table between its nodes, linear in both angles.
    fn colour(&self, row: usize, wi: DVec3) -> [f64; 3] {
        let theta = libm::asin(wi.y.clamp(-1.0, 1.0)).abs() / FRAC_PI_2 * (THETAS - 1) as f64;
        let phi = (libm::atan2(wi.x, wi.z) / PI + 0.5) * (PHIS - 1) as f64;
        let place = |at: f64, count: usize| {
            let low = (at as usize).min(count - 2);
            (low, at - low as f64)
        };
        let ((t, along), (p, across)) = (place(theta, THETAS), place(phi, PHIS));
        let at = |t: usize, p: usize| self.table[(row * THETAS + t) * PHIS + p].map(f64::from);
        let mix = |a: [f64; 3], b: [f64; 3], part: f64| -> [f64; 3] {
            std::array::from_fn(|c| a[c] + part * (b[c] - a[c]))
        };
        mix(mix(at(t, p), at(t, p + 1), across), mix(at(t + 1, p), at(t + 1, p + 1), across), along)
    }

    /// Width and height of the table, and its planes R, G, B, row by row from the top, for
    /// [`io::image::write_exr`](crate::io::image::write_exr).
    #[must_use]
    pub fn planes(&self) -> ([u32; 2], Vec<(&'static str, Vec<f32>)>) {
        let plane = |c: usize| self.table.iter().map(|rgb| rgb[c]).collect();
        let size = [PHIS as u32, (THETAS * (1 + self.barbules)) as u32];
        (size, vec![("R", plane(0)), ("G", plane(1)), ("B", plane(2))])
    }

    /// The shader's text. `table` is the name of the table's file as the shader opens it unless told otherwise; `notes` say what made it.
    #[must_use]
    pub fn shader(&self, table: &str, notes: &[(&str, &str)]) -> String {
        let notes: String = notes
            .iter()
            .map(|(name, text)| format!("// {name}: {}\n", text.replace(['\n', '\r'], " ")))
            .collect();
        let table = table.replace('\\', "/").replace('"', "");
        let [first, second] = self.lobes.facets;
        let share = self.lobes.share;
        let barbules = self.barbules;
        let closure = |facets: Facets| {
            format!(
                "microfacet(\"{}\", N, Y, min({:.5} * along, {most}), min({:.5} * across, {most}), 0.0, 0)",
                facets.distribution.name(),
                facets.along,
                facets.across,
                most = ALPHAS[1],
            )
        };
        let (phis, rows) = (PHIS, 1 + barbules);
        // Without barbules there is none to look up.
        let contrast = if barbules > 0 { 1 } else { 0 };
        format!(
            r#"// Barbules of a simulated feather: colours for each direction of the eye from a table, two kinds of facets.
{notes}shader barbule(
    string Table = "{table}",
    // Along the barbules: link the node Tangent (UV map, u along them).
    vector Tangent = vector(0, 0, 0),
    // Where on the surface, in cells of barbules: link Texture Coordinate's UV.
    vector UV = vector(0, 0, 0),
    float CellsAlong = 30,
    float CellsAcross = 60,
    // How much cells differ: 1 as under a lamp that is a point, 0 not at all. Wide lamps and skies even barbules out.
    float Contrast = {contrast},
    output closure color BSDF = 0)
{{
    vector Y = Tangent;
    if (dot(Y, Y) == 0) {{ Y = dPdu; }}
    Y = normalize(Y - dot(Y, N) * N);
    vector X = cross(Y, N);
    vector eye = I;
    if (dot(eye, N) < 0) {{ eye = -eye; }}
    float theta = abs(asin(clamp(dot(eye, Y), -1.0, 1.0)));
    float phi = atan2(dot(eye, X), max(dot(eye, N), 1e-6));
    float column = (0.5 + (phi / M_PI + 0.5) * {last_phi}) / {phis};
    float line = (0.5 + theta / M_PI_2 * {last_theta}) / {height};
    color shown = texture(Table, column, line, 0.0, 0.0, 0.0, 0.0, "wrap", "clamp", "interp", "linear");
    if (Contrast > 0) {{
        float drawn = cellnoise(floor(UV[0] * CellsAlong), floor(UV[1] * CellsAcross));
        float row = 1 + min(floor(drawn * {barbules}), {barbules} - 1);
        color own = texture(Table, column, line + row * {share_of_row:.9}, 0.0, 0.0, 0.0, 0.0, "wrap", "clamp", "interp", "linear");
        shown += Contrast * (own - shown);
    }}
    float slant = min(1.0 / max(cos(phi), 1e-6), {MOST_SLANT});
    float along = pow(slant, {power_along:.4});
    float across = pow(slant, {power_across:.4});
    BSDF = shown * ({left:.5} * {one} + {share:.5} * {other});
}}
"#,
            last_phi = phis - 1,
            last_theta = THETAS - 1,
            height = THETAS * rows,
            share_of_row = 1.0 / rows as f64,
            left = 1.0 - share,
            power_along = self.lobes.growth[0],
            power_across = self.lobes.growth[1],
            one = closure(first),
            other = closure(second),
        )
    }
}

/// Roughness r of one rough mirror that stands for a material where a format has no more, α being r²: the geometric mean of
/// the facets of most light.
///
/// # Errors
/// None with the wavelengths that are taken.
pub fn even_roughness(brdf: &FeatherBrdf) -> Result<f64> {
    let Facets { along, across, .. } = fit::fitted(brdf)?.facets[0];
    Ok((along * across).powf(0.25))
}

/// The eye's direction of a node.
fn view(node: usize) -> DVec3 {
    let most = GRAZING_DEG.to_radians();
    let theta = FRAC_PI_2 * (node / PHIS) as f64 / (THETAS - 1) as f64;
    let phi = PI * ((node % PHIS) as f64 / (PHIS - 1) as f64 - 0.5);
    omega(theta.min(most), phi.clamp(-most, most))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Options;
    use crate::brdf::fixtures::example;
    use crate::export::{Deviation, Model};
    use crate::progress::Unobserved;

    fn made(barbules: usize) -> (FeatherBrdf, OslMaterial) {
        let brdf = FeatherBrdf::new(&example(8), Options::default()).unwrap();
        let osl = OslMaterial::of(&brdf, barbules, &Unobserved).unwrap();
        (brdf, osl)
    }

    /// Light from everywhere has the material's own colour, at nodes and between them.
    #[test]
    fn albedos_are_the_materials_own() {
        let (brdf, osl) = made(0);
        let nm = waves();
        let weights = Observer::default().weights(&Wavelengths::new(nm).unwrap());
        for (theta, phi, allowed) in
            [(0.0, 0.0, 1e-5), (30.0, -45.0, 1e-5), (15.0, 60.0, 1e-5), (40.0, 52.0, 0.02)]
        {
            let wi = omega(f64::to_radians(theta), f64::to_radians(phi));
            let expected = into_gamut(weights.linear_rgb(&nm.map(|nm| brdf.albedo(nm as f32, wi))));
            let found = osl.albedo(0, wi);
            for c in 0..3 {
                assert!(
                    (found[c] - expected[c]).abs() < allowed * expected[1],
                    "{theta} {phi}: {found:?} {expected:?}"
                );
            }
        }
    }

    /// Barbules are the mean in the mean, and differ as the material's do in the mirror direction.
    #[test]
    fn barbules_differ_as_the_materials_do() {
        let (brdf, osl) = made(200);
        let wi = omega(0.2, 0.3);
        let mirror = DVec3 { z: wi.z, ..-wi };
        let rows: Vec<f64> = (1..=200).map(|row| osl.albedo(row, wi)[1]).collect();
        let mean = rows.iter().sum::<f64>() / 200.0;
        assert!((mean / osl.albedo(0, wi)[1] - 1.0).abs() < 0.02, "{mean}");
        let contrast = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt() / mean
        };
        let own: Vec<f64> =
            (0..200).map(|name| f64::from(brdf.eval([540.0; 4], wi, mirror, Some(name))[0])).collect();
        let (table, material) = (contrast(&rows), contrast(&own));
        // The eye's green is a band of waves, over which single ones even out a little.
        assert!(table > 0.6 * material && table < 1.1 * material, "{table} {material}");
    }

    /// The deviation is told by the same evaluation as the tests: no light too much, and colours near.
    #[test]
    fn no_light_is_too_much_and_colours_are_near() {
        let (brdf, osl) = made(0);
        let value = |wi: DVec3, wo: DVec3| osl.value(wi, wo);
        let found = Deviation::of(&Model::Rgb(&value), &brdf).unwrap();
        assert!(found.bias.abs() < 0.03 && found.delta_e < 3.0, "{found:?} {:?}", osl.lobes);
        assert!(found.relative_l1 < 0.5, "{found:?} {:?}", osl.lobes);
    }

    #[test]
    fn shaders_name_their_table_and_nothing_of_the_language() {
        let (_, osl) = made(2);
        let text = osl.shader("a \"b\".exr", &[("material", "x\ny")]);
        assert!(text.contains("string Table = \"a b.exr\"") && text.contains("// material: x y\n"), "{text}");
        assert_eq!(text.matches('{').count(), text.matches('}').count());
        assert_eq!(text.matches("microfacet(").count(), 2);
        let ([width, height], planes) = osl.planes();
        assert!(planes.len() == 3 && planes[0].1.len() == (width * height) as usize);
        assert!(text.contains(&format!("/ {height};")));
        assert!(
            OslMaterial::of(&made(0).0, 2000, &Unobserved).unwrap_err().to_string().contains("limit of 1024")
        );
    }
}
