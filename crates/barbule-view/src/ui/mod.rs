//! What is drawn of the window.

mod action;
pub mod gizmos;
pub mod traced;

pub use action::Action;
