//! Wave solvers: each takes a structure and gives scattered fields.
pub mod film;
