//! Wave solvers: each takes a structure and gives scattered fields.

mod beam;
pub mod core_fringes;
pub mod cost;
pub mod crystal;
pub mod diffraction;
pub mod direct;
pub mod far_fields;
pub mod full_wave;
pub mod segment;
pub mod surface;
pub mod swatch;

use direct::{Direct, Shadows};
use far_fields::Method;
use full_wave::FullWave;
use surface::Fast;

/// What makes the formulas along a top smaller.
const SMALLER_TOP: &str = "fewer layers, a narrower section, fewer azimuths or threads";

/// [`surface`].
pub const FAST: Method = Method {
    name: "fast",
    about: "The fast 2.5D simulation",
    noun: "far field",
    smaller: SMALLER_TOP,
    is_exact: false,
    solver: |_| Box::new(Fast::default()),
};

/// [`direct`], the plain reference.
pub const DIRECT: Method = Method {
    name: "direct",
    about: "The same formulas, evaluated plainly",
    solver: |_| Box::new(Direct { shadows: Shadows::Ignored, ..Direct::default() }),
    ..FAST
};

/// The same with [`Shadows::Cast`].
pub const SHADOWED: Method = Method {
    name: "shadowed",
    about: "Plainly, with the top in its own light",
    solver: |_| Box::new(Direct { shadows: Shadows::Cast, ..Direct::default() }),
    ..FAST
};

/// [`full_wave`].
pub const FULL_WAVE: Method = Method {
    name: "full-wave",
    about: "Maxwell's equations, exact up to discretization: boundary elements",
    noun: "full wave",
    smaller: "a narrower section, a longer wavelength, or fewer elements",
    is_exact: true,
    solver: |settings| Box::new(FullWave::new(settings)),
};

/// All solvers of sections.
pub const METHODS: [Method; 4] = [FAST, DIRECT, SHADOWED, FULL_WAVE];

/// The solver of sections of this name.
#[must_use]
pub fn method(name: &str) -> Option<Method> {
    METHODS.into_iter().find(|method| method.name == name)
}
