//! Stacks of one film as glTF and OpenPBR have them, and how far their formulas are from the exact film.
//!
//! Both formats know a film by one index and one thickness, in air, on a base without absorption. Dispersion is lost, and so is the base's
//! absorption, of which the strength of its boundary is kept.

mod gltf;
mod materialx;
mod models;

use crate::film::sweep;
use crate::material::Material;
use crate::progress::Unobserved;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::{Observer, xyz_from_rgb};
use crate::spectrum::difference::{delta_e_2000, lab};
use crate::stack::Stack;
use crate::{Complex64, Error, Result};

use super::Deviation;

/// Where indices are taken: about where the eye sees best, nm.
const CHOSEN_NM: f64 = 550.0;

/// Absorption of the last medium from which on nothing is seen through it: a millimetre then passes less than 1e-9 of green light.
const OPAQUE: f64 = 1e-3;

/// Angles at which colours are compared, degrees.
pub const ANGLES_DEG: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];

/// One film in air, as pictures' formats have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OneFilm {
    /// Refractive index of the film, at 550 nm.
    pub index: f64,
    /// Its thickness, nm: the mean one where thicknesses spread.
    pub thickness_nm: f64,
    /// Index of a base without absorption whose boundary with the film reflects as much at 550 nm, at least 1.
    pub base_index: f64,
    /// Whether light passes the base.
    pub is_clear: bool,
    /// Whether the film absorbs, which is left out.
    pub absorbs: bool,
    /// Whether the base's boundary reflects more than the index of 1 that it has.
    pub is_cut: bool,
}

/// A format that has films.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilmFormat {
    /// glTF 2.0 with `KHR_materials_iridescence`.
    Gltf,
    /// A MaterialX document with OpenPBR's surface.
    OpenPbr,
}

/// How a film's colours in a format differ from the exact ones at one angle, in D65, a perfect mirror being white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmDeviation {
    /// From the normal, degrees.
    pub angle_deg: f64,
    /// ΔE00 of the format's own formula.
    pub delta_e: f64,
    /// ΔE00 of exact waves with the same constant indices: what the format's numbers lose, apart from its formula.
    pub delta_e_of_indices: f64,
    /// Linear sRGB of the exact film.
    pub exact: [f64; 3],
    /// Linear sRGB of the format's formula.
    pub format: [f64; 3],
}

impl OneFilm {
    /// The film of a stack.
    ///
    /// # Errors
    /// Another number of layers than one, a first medium that is not air, or a film whose index at 550 nm is unknown or below 1.
    pub fn of(stack: &Stack) -> Result<Self> {
        let route = "take Mitsuba's BSDF barbule_film, which has any layers";
        if stack.layers() != 1 {
            return Err(Error::input(format!(
                "the stack has {}, but films of glTF and OpenPBR are one layer; {route}",
                crate::error::counted(stack.layers(), "layer")
            )));
        }
        let indices = stack.indices(CHOSEN_NM)?;
        let [outside, film, base] = indices[..] else {
            return Err(Error::machine("a stack of one layer has not three media"));
        };
        if (outside.re - 1.0).abs() > 1e-3 {
            return Err(Error::input(format!(
                "the stack begins in a medium of index {}, but films of glTF and OpenPBR lie in air; {route}",
                outside.re
            )));
        }
        if film.re < 1.0 {
            return Err(Error::input(format!(
                "the film's index at {CHOSEN_NM} nm is {}, but glTF and OpenPBR have films of 1 and more; {route}",
                film.re
            )));
        }
        let base_index = as_strong(film.re, base);
        Ok(Self {
            index: film.re,
            thickness_nm: stack.thickness_nm()[0],
            base_index: base_index.max(1.0),
            is_clear: base.im < OPAQUE,
            absorbs: film.im >= OPAQUE,
            is_cut: base_index < 1.0 - 1e-6,
        })
    }

    /// Linear sRGB that a format's formula has for light from the normal's angle with this cosine.
    #[must_use]
    pub fn rgb(&self, format: FilmFormat, cosine: f64) -> [f64; 3] {
        match format {
            FilmFormat::Gltf => models::gltf(self, cosine),
            FilmFormat::OpenPbr => models::openpbr(self, cosine),
        }
    }

    /// The bytes of a file with this film: a sphere that wears it as glTF, or a MaterialX document; `notes` say what made it.
    ///
    /// # Errors
    /// None: what is written is always JSON.
    pub fn encode(&self, format: FilmFormat, name: &str, notes: &[(&str, &str)]) -> Result<Vec<u8>> {
        match format {
            FilmFormat::Gltf => gltf::encoded(self, name, notes),
            FilmFormat::OpenPbr => Ok(materialx::encoded(self, name, notes)),
        }
    }

    /// A stack of these numbers.
    fn stack(&self) -> Result<Stack> {
        let constant = |n: f64| Material::constant(Complex64::new(n, 0.0));
        Stack::new(constant(1.0)?, &[(constant(self.index)?, self.thickness_nm)], constant(self.base_index)?)
    }

    /// Holds a format's film against the exact stack at [`ANGLES_DEG`], and all angles together: a [`Deviation`] of linear sRGB over these
    /// angles, each as much as the hemisphere has of it in projection.
    ///
    /// # Errors
    /// A medium without an index from 400 to 700 nm.
    pub fn compare(&self, stack: &Stack, format: FilmFormat) -> Result<(Vec<FilmDeviation>, Deviation)> {
        let exact = colours(stack)?;
        let constant = colours(&self.stack()?)?;
        let white = xyz_from_rgb([1.0; 3]);
        let seen = |rgb: [f64; 3]| lab(xyz_from_rgb(rgb), white);
        let rows: Vec<FilmDeviation> = ANGLES_DEG
            .iter()
            .zip(exact.iter().zip(constant))
            .map(|(&angle_deg, (&exact, constant))| {
                let format = self.rgb(format, libm::cos(angle_deg.to_radians()));
                FilmDeviation {
                    angle_deg,
                    delta_e: delta_e_2000(seen(format), seen(exact)),
                    delta_e_of_indices: delta_e_2000(seen(constant), seen(exact)),
                    exact,
                    format,
                }
            })
            .collect();
        let (mut off, mut more, mut all) = (0.0, 0.0, 0.0);
        for row in &rows {
            // Of the normal as much as of its half of the first step.
            let weight = libm::sin(2.0 * row.angle_deg.max(3.75).to_radians());
            for (format, exact) in row.format.iter().zip(row.exact) {
                off += weight * (format - exact).abs();
                more += weight * (format - exact);
                all += weight * exact;
            }
        }
        let delta_e = rows.iter().map(|row| row.delta_e).sum::<f64>() / rows.len() as f64;
        Ok((rows, Deviation { relative_l1: off / all, bias: more / all, delta_e }))
    }
}

/// Index of a base without absorption whose boundary with the film reflects as much as that with `base` does.
fn as_strong(film: f64, base: Complex64) -> f64 {
    let amplitude = ((base - film) / (base + film)).norm();
    let [more, less] = [1.0 + amplitude, 1.0 - amplitude];
    // The sign of the amplitude is that of |base|² − film²: a metal is the denser one.
    if base.norm() >= film { film * more / less } else { film * less / more }
}

/// Linear sRGB of unpolarized light that a stack reflects at [`ANGLES_DEG`].
fn colours(stack: &Stack) -> Result<Vec<[f64; 3]>> {
    let at = Wavelengths::new((0..=60).map(|k| 400.0 + 5.0 * f64::from(k)).collect::<Vec<f64>>())?;
    let weights = Observer::default().weights(&at);
    let reflected = sweep(stack, &at, &ANGLES_DEG.map(f64::to_radians), &Unobserved)?.unpolarized();
    Ok(reflected.chunks(at.len()).map(|row| weights.linear_rgb(row)).collect())
}

#[cfg(test)]
impl OneFilm {
    /// A film on a base, neither of which absorbs.
    fn clear(index: f64, thickness_nm: f64, base_index: f64) -> Self {
        Self { index, thickness_nm, base_index, is_clear: true, absorbs: false, is_cut: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;

    fn stack(text: &str) -> Stack {
        Stack::parse(text, &Library::builtin()).unwrap()
    }

    #[test]
    fn a_film_is_mapped_with_its_base() {
        let dove = OneFilm::of(&stack("air/keratin:595/air")).unwrap();
        assert!((dove.index - 1.5515).abs() < 2e-4 && dove.thickness_nm == 595.0 && dove.is_clear);
        assert!((dove.base_index - 1.0).abs() < 1e-12);
        let over_melanin = OneFilm::of(&stack("air/keratin:300/melanin")).unwrap();
        let melanin = Material::melanin().index(550.0).unwrap();
        assert!(!over_melanin.is_clear && over_melanin.base_index > melanin.re, "{over_melanin:?}");
        let strength = |base: Complex64| ((base - over_melanin.index) / (base + over_melanin.index)).norm();
        assert!((strength(over_melanin.base_index.into()) - strength(melanin)).abs() < 1e-12);
        assert!(!over_melanin.absorbs && !over_melanin.is_cut);
        let [absorbing, over_less] =
            ["air/melanin:300/air", "air/keratin:300/0.9"].map(|text| OneFilm::of(&stack(text)).unwrap());
        assert!(absorbing.absorbs && over_less.is_cut && over_less.base_index == 1.0);
    }

    /// A metal, whose index has a small real part, is the denser medium: what its film reflects is kept.
    #[test]
    fn films_on_metals_reflect_as_much_as_metals() {
        // What is left is one index for all wavelengths: of gold, that it is no gold below 500 nm.
        for (metal, reached) in [("silver", 0.004), ("aluminium", 0.005), ("gold", 0.062)] {
            let stack = stack(&format!("air/keratin:300/{metal}"));
            let film = OneFilm::of(&stack).unwrap();
            for format in [FilmFormat::Gltf, FilmFormat::OpenPbr] {
                let (_, Deviation { relative_l1, bias, .. }) = film.compare(&stack, format).unwrap();
                println!("{metal} {format:?}: {relative_l1:.3} {bias:.3}");
                assert!(bias.abs() < reached, "{metal} {format:?}: {relative_l1} {bias}");
            }
        }
    }

    #[test]
    fn other_stacks_are_refused_with_a_way_out() {
        for (text, word) in [
            ("air/melanin:99/keratin:100/air", "2 layers"),
            ("air/keratin", "0 layers"),
            ("1.33/keratin:300/air", "lie in air"),
            ("air/0.5:300/air", "index at 550 nm is 0.5"),
        ] {
            let message = OneFilm::of(&stack(text)).unwrap_err().to_string();
            assert!(message.contains(word) && message.contains("barbule_film"), "{message}");
        }
    }

    /// Where a film is too thin to interfere, each formula has what the bare boundary reflects, but for the tint that the extension's
    /// white of equal energy has in sRGB; where it is so thick that colours vanish, the mean over the phases.
    #[test]
    fn formulas_are_right_in_their_limits() {
        for format in [FilmFormat::Gltf, FilmFormat::OpenPbr] {
            let thin = OneFilm::clear(1.5, 1e-6, 2.0);
            let bare: f64 = (1.0_f64 / 3.0).powi(2);
            for v in thin.rgb(format, 1.0) {
                assert!((v - bare).abs() < 0.02, "{format:?}: {v} {bare}");
            }
            let thick = OneFilm::clear(1.5, 1e5, 1.0);
            let once: f64 = (0.5_f64 / 2.5).powi(2);
            let mean = once + (1.0 - once).powi(2) * once / (1.0 - once * once);
            // The extension's guard makes air a medium of index 1.02.
            for v in thick.rgb(format, 1.0) {
                assert!((v - mean).abs() < 4e-3, "{format:?}: {v} {mean}");
            }
        }
    }

    /// With constant indices and without a format's formula nothing is lost but dispersion; the formulas are as far off as
    /// docs/guide/export.md says.
    #[test]
    fn colours_are_near_the_exact_film_where_the_formula_is() {
        let constant = stack("air/1.56:300/air");
        for format in [FilmFormat::Gltf, FilmFormat::OpenPbr] {
            let film = OneFilm::of(&constant).unwrap();
            let (rows, whole) = film.compare(&constant, format).unwrap();
            assert_eq!(rows.len(), ANGLES_DEG.len());
            for row in &rows {
                assert!(row.delta_e_of_indices < 1e-9, "{row:?}");
                assert!(row.delta_e < 40.0 && row.exact.iter().all(|v| v.is_finite()), "{row:?}");
            }
            assert!(whole.relative_l1 < 0.6 && whole.bias.abs() <= whole.relative_l1, "{whole:?}");
        }
    }

    #[test]
    fn files_hold_the_film() {
        let film = OneFilm::of(&stack("air/keratin:595/air")).unwrap();
        let notes = [("command", "barbule export 'air/keratin:595/air' --to gltf <&>\"")];
        let bytes = film.encode(FilmFormat::Gltf, "air/keratin:595/air", &notes).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        let material = &json["materials"][0];
        assert_eq!(material["extensions"]["KHR_materials_iridescence"]["iridescenceThicknessMaximum"], 595.0);
        assert_eq!(json["extensionsUsed"].as_array().unwrap().len(), 3);
        let text = String::from_utf8(film.encode(FilmFormat::OpenPbr, "film", &notes).unwrap()).unwrap();
        assert!(
            text.contains("<open_pbr_surface")
                && text.contains("\"thin_film_thickness\" type=\"float\" value=\"0.595\"")
        );
        // Free text stands in attributes, where it is escaped.
        assert!(text.contains("&lt;&amp;&gt;&quot;") && !text.contains("<&>"), "{text}");
    }
}
