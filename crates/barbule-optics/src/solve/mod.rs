//! Wave solvers: each takes a structure and gives scattered fields.

mod beam;
pub mod core_fringes;
pub mod cost;
pub mod crystal;
pub mod diffraction;
pub mod direct;
pub mod far_fields;
#[cfg(feature = "full-waves")]
pub mod full_wave;
pub mod segment;
pub mod surface;
pub mod swatch;

pub use beam::{IncidentRange, incident_range, width_within_um};
use direct::{Direct, Shadows};
use far_fields::Method;
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

/// [`full_wave`], where the feature `full-waves` is on.
#[cfg(feature = "full-waves")]
pub const FULL_WAVE: Method = Method {
    name: "full-wave",
    about: "Maxwell's equations, exact up to discretization: boundary elements",
    noun: "full wave",
    smaller: "a narrower section, a longer wavelength, or fewer elements",
    is_exact: true,
    solver: |settings| Box::new(full_wave::FullWave::new(settings)),
};

/// All solvers of sections.
pub const METHODS: &[Method] = &[
    FAST,
    DIRECT,
    SHADOWED,
    #[cfg(feature = "full-waves")]
    FULL_WAVE,
];

/// The solver of sections of this name.
#[must_use]
pub fn method(name: &str) -> Option<Method> {
    METHODS.iter().copied().find(|method| method.name == name)
}
