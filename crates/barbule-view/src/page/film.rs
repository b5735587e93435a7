//! Films whose thickness is a slider: their stack, their spectrum and their colour by angle, exactly and at once.

use barbule_base::progress::Unobserved;
use barbule_light::film::sweep;
use barbule_light::material::Library;
use barbule_light::spectrum::Wavelengths;
use barbule_light::spectrum::colour::Observer;
use barbule_light::stack::Stack;

use super::spectrum::Curve;
use crate::Result;
use crate::gpu::Reflected;

/// Wavelengths of the picture's table, nm: first, last and step. Lines of a micrometre of keratin are ten times as wide.
const TABLE_NM: [f64; 3] = [388.0, 724.0, 8.0];
/// The same of the curve.
const CURVE_NM: [f64; 3] = [300.0, 800.0, 2.0];
/// Steps of the cosine in the picture's table.
const COSINES: usize = 64;
/// Angles of the strip of colours, from 0° on, °.
pub const STRIP_DEG: [f64; 18] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0, 80.0, 85.0,
];

/// What the film is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Keratin on melanin, as the cortex of a dove's or a grackle's barbule.
    Cortex,
    /// Water in air.
    Soap,
    /// Five layers of keratin, air between them, on melanin.
    Layers,
}

impl Kind {
    /// All of them, in the order of the page.
    pub const ALL: [Self; 3] = [Self::Cortex, Self::Soap, Self::Layers];

    /// What its button says.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Cortex => "Cortex",
            Self::Soap => "Soap film",
            Self::Layers => "Five layers",
        }
    }

    /// What one looks at, in a sentence or two.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Cortex => {
                "A film of keratin on melanin, as under the surface of a dove's barbule. Thicker films show the higher orders, whose colours change faster with the angle."
            }
            Self::Soap => {
                "Water in air: what is reflected from both its faces cancels where the film is thin, so the thinnest is dark."
            }
            Self::Layers => {
                "Five layers of keratin with air between them: five times the same colour add up to a mirror of one hue, which turns to blue at the rim."
            }
        }
    }
}

/// A film and its sizes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    /// What it is made of.
    pub kind: Kind,
    /// Thickness of the film, or of each layer, nm.
    pub thickness_nm: f64,
    /// Thickness of the air between layers, nm.
    pub gap_nm: f64,
}

impl Default for Film {
    fn default() -> Self {
        Self { kind: Kind::Cortex, thickness_nm: 330.0, gap_nm: 90.0 }
    }
}

/// What a film's picture and its plots are made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Looked {
    /// For the picture: by wavelength and angle.
    pub reflected: Reflected,
    /// Reflectance of unpolarized light at the chosen angle.
    pub curve: Curve,
    /// Linear sRGB of what it reflects of white light at [`STRIP_DEG`].
    pub strip: Vec<[f64; 3]>,
}

impl Film {
    /// The thicknesses that the sliders reach, nm.
    pub const RANGE_NM: [f64; 2] = [10.0, 1000.0];
    /// Those of layers and of the air between them, nm.
    pub const LAYER_RANGE_NM: [f64; 2] = [20.0, 250.0];

    /// The same kind of film at another time: its usual thickness.
    #[must_use]
    pub fn of_kind(kind: Kind) -> Self {
        let thickness_nm = match kind {
            Kind::Cortex => 330.0,
            Kind::Soap => 420.0,
            Kind::Layers => 85.0,
        };
        Self { kind, thickness_nm, ..Self::default() }
    }

    /// The stack in the language of `barbule film`.
    #[must_use]
    pub fn text(&self) -> String {
        let [thickness, gap] = [self.thickness_nm, self.gap_nm].map(|nm| nm.round());
        match self.kind {
            Kind::Cortex => format!("air/keratin:{thickness}/melanin"),
            Kind::Soap => format!("air/1.333:{thickness}/air"),
            Kind::Layers => format!("air/5*(keratin:{thickness}/air:{gap})/melanin"),
        }
    }

    /// Works it out, at an angle of incidence (rad, under π/2).
    ///
    /// # Errors
    /// A thickness out of range, or an angle of π/2 and more.
    pub fn look(&self, library: &Library, angle: f64) -> Result<Looked> {
        let stack = Stack::parse(&self.text(), library)?;
        let at = steps(TABLE_NM)?;
        let angles = Reflected::angles(COSINES);
        let by_angle = sweep(&stack, &at, &angles, &Unobserved)?.unpolarized();
        let waves = at.len();
        let values = (0..waves)
            .flat_map(|wave| by_angle.iter().skip(wave).step_by(waves).map(|value| *value as f32))
            .collect();
        let of_curve = steps(CURVE_NM)?;
        let curve = sweep(&stack, &of_curve, &[angle], &Unobserved)?.unpolarized();
        let colours = Observer::default().weights(&of_curve);
        let strip: Vec<f64> = STRIP_DEG.iter().map(|degrees| degrees.to_radians()).collect();
        let strip = sweep(&stack, &of_curve, &strip, &Unobserved)?.unpolarized();
        Ok(Looked {
            reflected: Reflected { nm: at.nm().to_vec(), steps: COSINES, values },
            curve: Curve { nm: of_curve.nm().to_vec(), rgb: colours.linear_rgb(&curve), values: curve },
            strip: strip.chunks_exact(of_curve.len()).map(|values| colours.linear_rgb(values)).collect(),
        })
    }
}

/// Wavelengths from a first to a last one.
fn steps([first, last, step]: [f64; 3]) -> Result<Wavelengths> {
    let count = ((last - first) / step).round() as usize;
    Wavelengths::new((0..=count).map(|k| first + k as f64 * step).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule_light::film::{Polarization, response};

    /// Tables, curve and strip are of the film itself.
    #[test]
    fn films_are_worked_out_exactly() {
        let library = Library::builtin();
        for kind in Kind::ALL {
            let film = Film::of_kind(kind);
            let found = film.look(&library, 0.5).unwrap();
            let stack = Stack::parse(&film.text(), &library).unwrap();
            let both = |nm: f64, angle: f64| {
                let of = |p| response(&stack, nm, angle, p).unwrap().reflected;
                0.5 * (of(Polarization::S) + of(Polarization::P))
            };
            assert!((found.curve.values[100] - both(500.0, 0.5)).abs() < 1e-12);
            let table = &found.reflected;
            let place = 14 * (table.steps + 1) + 48;
            let expected = both(table.nm[14], (48.0_f64 / 64.0).acos());
            assert!((f64::from(table.values[place]) - expected).abs() < 1e-6);
            assert_eq!((found.strip.len(), table.values.len()), (STRIP_DEG.len(), table.nm.len() * 65));
        }
    }

    /// A soap film far thinner than a wave is dark; a film without thickness is what it lies on.
    #[test]
    fn thin_films_are_dark() {
        let film = Film { thickness_nm: 10.0, ..Film::of_kind(Kind::Soap) };
        let found = film.look(&Library::builtin(), 0.0).unwrap();
        assert!(found.curve.values.iter().all(|r| *r < 0.02));
    }

    #[test]
    fn the_text_is_the_stack_language() {
        let film = Film { kind: Kind::Layers, thickness_nm: 84.6, gap_nm: 90.0 };
        assert_eq!(film.text(), "air/5*(keratin:85/air:90)/melanin");
    }
}
