//! From the picture of a section to what is in it: classes of grey, outlines, lattices of rods, layers.
//!
//! Pixels go in and numbers come out; nothing here opens files or prints. `docs/guide/trace.md` has the method.

pub mod trace;
