//! What other programs read: whole scenes.

pub mod scene;
