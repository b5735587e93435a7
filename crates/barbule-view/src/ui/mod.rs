//! The window: egui over what is open, what has been computed of it, and what is drawn.

mod action;
pub mod panes;
mod results;

pub use action::Action;
pub use results::{Of, Results};
