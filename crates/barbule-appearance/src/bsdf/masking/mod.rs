//! What of a vane is seen and lit: rows of barbules and of barbs that hide each other.
//!
//! Two nested problems in the plane (Padrón-Griffe et al. 2024, *A surface-based appearance model for pennaceous feathers*):
//! the barbules of one side of a barb are a row of ellipses, through whose gaps light passes; barbs are a row of ellipses
//! (rami) with two sheets (their barbules) that let as much through. Both rows are endless and straight along their axes, so
//! what hides what in space is decided in the plane across. Everything is exact: [`Row`] sorts the ends of what is projected.
//!
//! What only the camera sees is not reciprocal. [`Row::shared`] says which share of a part is seen from one direction and
//! lit from another, on whichever side, and is the same when the two are exchanged (`docs/theory/masking.md`).

mod outline;
mod row;
mod table;
#[cfg(test)]
mod tests;
mod vane;

pub use outline::Outline;
pub use row::{Row, Seen};
pub use table::{MaskingTable, PartSeen};
pub use vane::{Barbs, Barbules, LEFT, PARTS, RAMUS, RIGHT, VaneRows};
