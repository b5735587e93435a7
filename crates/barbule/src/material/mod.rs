//! Refractive indices of media against wavelength.
