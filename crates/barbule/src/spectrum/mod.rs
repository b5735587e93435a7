//! Wavelengths, spectra and colour.
