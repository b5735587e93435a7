//! Feathers, lights and cameras.
