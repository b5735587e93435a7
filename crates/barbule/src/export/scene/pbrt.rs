//! A scene as pbrt-v4 reads it: named materials, ribbons and meshes as PLY files, curves, camera, lights and a spectral film.
//!
//! Barbules are of pbrt's material `measured`: the mean of all barbules on both sides.

use std::f64::consts::FRAC_PI_4;
use std::fmt::Write as _;
use std::path::Path;

use glam::{DMat3, DVec3};

use super::pixels::portable_floats;
use super::{Exported, NamedBytes, Part, Shape, number_of, write_all};
use crate::brdf::FeatherBrdf;
use crate::bsdf::{Keratin, Surface};
use crate::scene::camera::Projection;
use crate::scene::emission::Emission;
use crate::scene::light::{Light, Rectangle, Sphere};
use crate::scene::sky::Sky;
use crate::spectrum::dense::SHORTEST_NM;
use crate::{Error, Result};

/// Vacuum wavelengths of pbrt's spectral film, nm.
const PBRT_NM: [u32; 2] = [360, 830];
/// nm between the numbers of a spectrum.
const STEP_NM: usize = 5;
/// Channels of the spectral film.
const BUCKETS: u32 = 47;
/// Side of the sky's square picture.
const SKY_SIDE: usize = 512;

/// Makes the bytes of a BRDF's `.bsdf`, which pbrt's material `measured` reads. It is asked when all else is found to be right.
pub type MeasuredFiles<'a> = &'a mut dyn FnMut(&FeatherBrdf) -> Result<Vec<u8>>;

impl Exported {
    /// Writes a pbrt-v4 scene file, and its files into a folder beside it that is named as it is without the ending. All appear, or none.
    ///
    /// # Errors
    /// A surface or lamp that pbrt has nothing for, what `measured` refuses, or a file that cannot be written.
    pub fn write_pbrt(&self, path: &Path, measured: MeasuredFiles<'_>) -> Result<()> {
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let stem =
            stem.ok_or_else(|| Error::input("has no name; give one as in scene.pbrt").in_file(path))?;
        let (text, files) = self.for_pbrt(&stem, measured)?;
        write_all((path, text.as_bytes()), &path.with_file_name(&stem), &files)
    }

    fn for_pbrt(&self, folder: &str, measured: MeasuredFiles<'_>) -> Result<(String, Vec<NamedBytes>)> {
        let mut files = Vec::new();
        let mut text = String::new();
        for remark in self.remarks() {
            line(&mut text, format_args!("# {remark}"));
        }
        self.view(&mut text, folder);
        text.push_str("WorldBegin\n");
        let brdfs = self.brdfs();
        for number in 0..brdfs.len() {
            line(
                &mut text,
                format_args!(
                    "MakeNamedMaterial \"barbule-{number}\" \"string type\" \"measured\" \"string filename\" {}",
                    quoted(&format!("{folder}/barbule-{number}.bsdf"))
                ),
            );
        }
        for part in &self.parts {
            let material = match &part.surface {
                Surface::Barbule(barbule) => {
                    format!("barbule-{}", number_of(&brdfs, &barbule.brdf).unwrap_or_default())
                }
                other => {
                    text.push_str(&own_material(part, other)?);
                    part.name.clone()
                }
            };
            let (file, bytes) = shape_file(part);
            line(&mut text, format_args!("AttributeBegin\n  NamedMaterial {}", quoted(&material)));
            let place = quoted(&format!("{folder}/{file}"));
            match part.shape {
                Shape::Curves(_) => line(&mut text, format_args!("  Include {place}")),
                Shape::Ribbons(..) | Shape::Mesh(..) => {
                    line(&mut text, format_args!("  Shape \"plymesh\" \"string filename\" {place}"));
                }
            }
            text.push_str("AttributeEnd\n");
            files.push((file, bytes));
        }
        for lamp in &self.lamps {
            self.lamp_text(&mut text, &lamp.light)?;
        }
        if let Some(environment) = &self.environment {
            files.push(("sky.pfm".to_owned(), sky_picture(&environment.sky)));
            let place = quoted(&format!("{folder}/sky.pfm"));
            line(&mut text, format_args!("LightSource \"infinite\" \"string filename\" {place}"));
        }
        for (number, brdf) in brdfs.iter().enumerate() {
            files.push((format!("barbule-{number}.bsdf"), measured(brdf)?));
        }
        Ok((text, files))
    }

    /// What stands before the world: camera, film, sampler, integrator.
    fn view(&self, text: &mut String, folder: &str) {
        let camera = &self.camera;
        let [width, height] = self.options.size;
        let distance = (camera.target - camera.eye).length();
        let numbers = [camera.eye, camera.target, camera.up].map(numbers).join("  ");
        // pbrt's cameras are left-handed.
        line(text, format_args!("Scale -1 1 1\nLookAt {numbers}"));
        let tall = f64::from(height) / f64::from(width);
        match camera.projection {
            Projection::Orthographic => {
                let (x, y) = (0.5 * camera.width_mm, 0.5 * camera.width_mm * tall);
                line(
                    text,
                    format_args!("Camera \"orthographic\" \"float screenwindow\" [ {} {x} {} {y} ]", -x, -y),
                );
            }
            Projection::Perspective { lens_radius } => {
                // The angle is that of the shorter side.
                let half = 0.5 * camera.width_mm * tall.min(1.0);
                let fov = 2.0 * libm::atan2(half, distance).to_degrees();
                line(
                    text,
                    format_args!(
                        "Camera \"perspective\" \"float fov\" {fov} \"float lensradius\" {lens_radius} \"float focaldistance\" {distance}"
                    ),
                );
            }
        }
        let [low, high] = PBRT_NM;
        let picture = quoted(&format!("{folder}.exr"));
        line(
            text,
            format_args!(
                "Film \"spectral\" \"integer xresolution\" {width} \"integer yresolution\" {height} \"string filename\" {picture} \
                 \"integer nbuckets\" {BUCKETS} \"float lambdamin\" {low} \"float lambdamax\" {high}"
            ),
        );
        line(text, format_args!("PixelFilter \"triangle\" \"float xradius\" 1 \"float yradius\" 1"));
        line(text, format_args!("Sampler \"independent\" \"integer pixelsamples\" {}", self.options.samples));
        line(text, format_args!("Integrator \"path\" \"integer maxdepth\" {}", self.scatterings));
    }

    fn lamp_text(&self, text: &mut String, light: &Light) -> Result<()> {
        let behind;
        let emission = if let Light::Sun(sun) = light {
            behind = self.sun_and_sky(sun)?;
            &behind
        } else {
            light.emission()
        };
        let (spectrum, scale) = (spectrum(emission.spectrum().values()), brightness(emission));
        let area =
            format!("  AreaLightSource \"diffuse\" \"spectrum L\" [{spectrum} ] \"float scale\" {scale}\n");
        match light {
            Light::Sun(sun) => {
                let (direction, [distance, radius]) = (sun.direction, self.disc_mm(sun));
                let x = direction.any_orthonormal_vector();
                let turn = DMat3::from_cols(x, x.cross(direction), -direction);
                let place = transform(turn, direction * distance);
                line(
                    text,
                    format_args!(
                        "AttributeBegin\n  {place}\n{area}  Shape \"disk\" \"float radius\" {radius}\nAttributeEnd"
                    ),
                );
            }
            Light::Sphere(Sphere { centre, radius, .. }) => {
                let place = numbers(*centre);
                line(
                    text,
                    format_args!(
                        "AttributeBegin\n  Translate {place}\n{area}  Shape \"sphere\" \"float radius\" {radius}\nAttributeEnd"
                    ),
                );
            }
            Light::Rectangle(Rectangle { corner, edge_u, edge_v, .. }) => {
                let corners =
                    [*corner, *corner + *edge_u, *corner + *edge_u + *edge_v, *corner + *edge_v].map(numbers);
                line(
                    text,
                    format_args!(
                        "AttributeBegin\n{area}  Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 0 2 3 ] \"point3 P\" [ {} ]\nAttributeEnd",
                        corners.join("  ")
                    ),
                );
            }
            Light::Point(lamp) => line(
                text,
                format_args!(
                    "LightSource \"point\" \"point3 from\" [ {} ] \"spectrum I\" [{spectrum} ] \"float scale\" {scale}",
                    numbers(lamp.position)
                ),
            ),
            Light::Spot(_) => {
                return Err(Error::input(
                    "spots are not written for pbrt, whose own fade in another way; leave them out",
                ));
            }
        }
        Ok(())
    }
}

/// Writing to a String cannot fail.
fn line(text: &mut String, of: std::fmt::Arguments<'_>) {
    let _ = writeln!(text, "{of}");
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

fn numbers(v: DVec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

/// A transformation column by column.
fn transform(turn: DMat3, origin: DVec3) -> String {
    let column = |v: DVec3, last: u32| format!("{} {last}", numbers(v));
    let columns = [column(turn.x_axis, 0), column(turn.y_axis, 0), column(turn.z_axis, 0), column(origin, 1)];
    format!("Transform [ {} ]", columns.join("  "))
}

/// Pairs of wavelengths and values, each with a space before it.
fn spectrum(values: &[f64]) -> String {
    let [low, high] = PBRT_NM;
    let pairs = (low..=high).step_by(STEP_NM);
    pairs.map(|nm| format!(" {nm} {:e}", values[(f64::from(nm) - SHORTEST_NM) as usize] as f32)).collect()
}

/// pbrt brings every light to the same luminance before it scales it; daylight of radiance 1 has 1.
fn brightness(emission: &Emission) -> f64 {
    emission.luminance() / Emission::daylight().luminance()
}

fn own_material(part: &Part, surface: &Surface) -> Result<String> {
    let name = quoted(&part.name);
    let coated = |keratin: &Keratin| {
        let (roughness, index) = (keratin.roughness(), keratin.index());
        format!(
            "MakeNamedMaterial {name} \"string type\" \"coateddiffuse\" \"spectrum reflectance\" [{} ] \"float roughness\" {roughness} \
             \"bool remaproughness\" false \"float eta\" {index}\n",
            spectrum(keratin.body().values())
        )
    };
    let diffuse = |values: &[f64]| {
        format!(
            "MakeNamedMaterial {name} \"string type\" \"diffuse\" \"spectrum reflectance\" [{} ]\n",
            spectrum(values)
        )
    };
    let refuse = || {
        Error::input(format!("'{}' is of a surface that pbrt has nothing for; leave this part out", part.of))
    };
    match surface {
        Surface::Keratin(keratin) => Ok(coated(keratin)),
        Surface::Lambertian(surface) => surface.even().map(|even| diffuse(even.values())).ok_or_else(refuse),
        _ => Err(refuse()),
    }
}

fn shape_file(part: &Part) -> NamedBytes {
    match &part.shape {
        Shape::Ribbons(_, ply) | Shape::Mesh(_, ply) => (format!("{}.ply", part.name), ply.clone()),
        Shape::Curves(curves) => (format!("{}.pbrt", part.name), curve_lines(curves).into_bytes()),
    }
}

/// Each straight segment as a Bézier curve, which is all that pbrt has.
fn curve_lines(curves: &[Vec<[f32; 4]>]) -> String {
    let mut text = String::new();
    for pair in curves.iter().flat_map(|curve| curve.windows(2)) {
        let [from, to] = [pair[0], pair[1]];
        let at = |t: f32| [0, 1, 2].map(|k| format!("{}", from[k] + (to[k] - from[k]) * t)).join(" ");
        let points = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(at).join("  ");
        line(
            &mut text,
            format_args!(
                "Shape \"curve\" \"string type\" \"cylinder\" \"point3 P\" [ {points} ] \"float width0\" {} \"float width1\" {}",
                2.0 * from[3],
                2.0 * to[3]
            ),
        );
    }
    text
}

/// The sky on the square of equal areas (Clarberg 2008) that pbrt's environments have.
fn sky_picture(sky: &Sky) -> Vec<u8> {
    let [width, _] = sky.size();
    let is_grey = sky.basis().len() == 1;
    portable_floats([SKY_SIDE; 2], |x, y| {
        let at = |k: usize| 2.0 * (k as f64 + 0.5) / SKY_SIDE as f64 - 1.0;
        let (row, column) = sky.texel(on_sphere(at(x), at(y)));
        let texel = sky.texels()[row * width + column];
        if is_grey { [texel[0]; 3] } else { texel }
    })
}

/// The direction of a point of that square, both coordinates −1 … 1.
fn on_sphere(u: f64, v: f64) -> DVec3 {
    let signed = 1.0 - (u.abs() + v.abs());
    let r = 1.0 - signed.abs();
    let phi = if r == 0.0 { FRAC_PI_4 } else { ((v.abs() - u.abs()) / r + 1.0) * FRAC_PI_4 };
    let across = r * (2.0 - r * r).max(0.0).sqrt();
    DVec3::new(phi.cos().copysign(u) * across, phi.sin().copysign(v) * across, (1.0 - r * r).copysign(signed))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit vectors, the zenith in the middle, and as many above the horizon as below.
    #[test]
    fn the_square_is_the_sphere_in_equal_areas() {
        assert!((on_sphere(0.0, 0.0) - DVec3::Z).length() < 1e-12);
        let side = 64;
        let at = |k: i32| 2.0 * (f64::from(k) + 0.5) / f64::from(side) - 1.0;
        let mut sum = DVec3::ZERO;
        let mut high = 0;
        for i in 0..side * side {
            let w = on_sphere(at(i % side), at(i / side));
            assert!((w.length() - 1.0).abs() < 1e-12);
            sum += w;
            high += i32::from(w.z > 0.5);
        }
        assert!(sum.length() < 1e-9);
        assert!((f64::from(high) / f64::from(side * side) - 0.25).abs() < 0.01);
    }
}
