//! Materials and scenes as other programs read them, and how far what these make of them is from what was meant.
//!
//! Everything here makes bytes; [`io`](crate::io) writes them. A model of another program that stands for a material is evaluated here as
//! that program does it, so that its [`Deviation`] can be told before anybody renders.

mod bsdf;
mod deviation;
pub mod film;
pub mod gonio;
pub mod osl;
pub mod scene;
pub mod usd;
mod write;

pub use bsdf::{BsdfTable, Crowding, Flavour};
pub use deviation::{Deviation, Model, SpectralModel};
pub use write::{Format, Needs, Request, Source, Written, export};
