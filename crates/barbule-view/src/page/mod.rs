//! The viewer in a browser: a few materials, films whose thickness is a slider, and a grating, on one canvas.
//!
//! ```text
//! start (browsers alone) ──► app ──► controls ──► choice, film, grating, view, spectrum
//! ```
//!
//! All but `start` compiles and is tested on the desk too. What the page needs of its browser is a [`Surroundings`]. Materials are the
//! files that ship, fetched when they are chosen; their tables are made here, films and gratings are worked out here, and the picture is
//! the desk's: [`stage`](crate::stage).

mod app;
mod choice;
mod controls;
mod fetch;
mod film;
mod grating;
mod picture;
mod spectrum;
#[cfg(all(target_arch = "wasm32", feature = "page"))]
mod start;
mod view;

pub use app::Page;
pub use choice::{BIRDS, Bird, Choice, Solid, Worn, show};
pub use fetch::{Fetched, Surroundings};
pub use film::{Film, Kind, Looked, STRIP_DEG};
pub use grating::Ridges;
pub use spectrum::{Axis, Curve, on_screen};
#[cfg(all(target_arch = "wasm32", feature = "page"))]
pub use start::start;
pub use view::{Axes, Bearing, Extent, View};
