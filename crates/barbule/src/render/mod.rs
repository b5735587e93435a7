//! The spectral path tracer.
