//! Speed in figures, as ratios from one run: what `barbule bench` prints, and the scenes that other renderers are measured
//! on.

pub mod brdf;
pub mod campaign;
pub mod crystal;
pub mod render;
pub mod scenes;
