//! Directions, orders of crystals, far fields, their statistics and the lobe that is fitted to them, and gratings.

pub mod directions;
pub mod far_field;
pub mod grating;
pub mod lobe;
pub mod orders;
pub mod statistics;
