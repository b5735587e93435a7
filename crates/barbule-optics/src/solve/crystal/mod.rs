//! Photonic crystals of rods: periodic along x, invariant along y, a few rows deep.
//!
//! A [`Cell`] is lit by a wave ([`Incidence`]) and answers with its [`CrystalResponse`]; three independent solvers stand behind
//! one interface, [`CrystalSolver`] (the last by the feature `fdtd`):
//!
//! | solver | method | cannot do |
//! | --- | --- | --- |
//! | [`Multipole`] | cylinder multipoles, exact | rods that are no circles; within 0.00001° of the horizon in θ |
//! | [`Rcwa`] | Fourier modal method, any outline | – |
//! | [`Fdtd`] | finite differences in time | media with Re ε ≤ 0; within 0.9° of the horizon |
//!
//! Time dependence e^{−jωt}, waves e^{+jk·r}, absorbing media have Im ε > 0, H̃ = η₀H.

mod cell;
#[cfg(test)]
mod cells;
#[cfg(feature = "fdtd")]
pub mod fdtd;
pub mod multipole;
mod orders;
pub mod planar;
pub mod rcwa;
mod response;
mod solver;
mod table;
#[cfg(test)]
mod tests;

pub use cell::{Cell, CellRod, Incidence, Shell, Surroundings};
#[cfg(feature = "fdtd")]
pub use fdtd::{Fdtd, NearField};
pub use multipole::Multipole;
pub use rcwa::Rcwa;
pub use response::{CrystalResponse, Order};
pub use solver::{CrystalSolver, sweep};
pub use table::{order_series, order_series_between, order_table};
