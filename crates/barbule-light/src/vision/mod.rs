//! What birds see: cones made of pigment, oil droplet and ocular media, the quanta that they catch, how well two colours are told
//! apart, and where colours lie in a tetrahedron.
//!
//! ```text
//! eye (pigment, droplet, media) ──► view (eye and light) ──► catches ──► discrimination, tetrahedron
//! ```
//!
//! `docs/theory/vision.md` has the formulas with their sources.

mod catches;
mod compared;
mod discrimination;
mod eye;
mod light;
mod pigment;
mod sensor;
mod tetrahedron;

pub use catches::{Catches, LEAST_SEEN, View};
pub use compared::{Compared, Differences};
pub use discrimination::{Noise, Reference, achromatic_difference};
pub use eye::{Cone, Eye, MOST_CONES};
pub use light::Light;
pub use pigment::{AVERAGE_HALF_NM, Droplet, ocular_media, pigment};
pub use sensor::{FalseColour, false_colour, human_beside};
pub use tetrahedron::Tetrahedral;
