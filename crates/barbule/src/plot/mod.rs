//! Figures from data: SVG, PDF and PNG.
//!
//! [`Figure`] draws curves, [`HeatMap`] a quantity over a plane, [`spectra`] reflectance spectra with their colours.
//! Each makes a [`Drawing`] of a few primitives, which other figures may compose themselves, as large as a [`Page`] asks for;
//! a drawing becomes bytes in a [`Format`] chosen by a file's extension. PDF and PNG need no system font: a small one is
//! built in ([`text`]).

mod axes;
mod drawing;
mod figure;
mod heat_map;
mod legend;
mod page;
mod palette;
mod pdf;
#[cfg(test)]
mod places;
mod raster;
mod spectra;
mod svg;
mod tetrahedron;
pub mod text;

pub use axes::{Axis, ticks};
pub use drawing::{Anchor, Drawing, Ink, Item, Picture, Stroke};
pub use figure::{Curve, Figure, Mark};
pub use heat_map::{HeatMap, abreast};
pub use page::Page;
pub use palette::{Map, PALETTE, style};
pub use raster::encode_png;
pub use spectra::{Band, MeasuredBand, spectra};
pub use tetrahedron::Tetrahedron;

use std::path::Path;

use crate::{Error, Result};

/// What a figure's file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Vector graphics whose words use the reader's fonts.
    Svg,
    /// Vector graphics with their font inside.
    Pdf,
    /// Pixels, as many as the drawing's resolution says.
    Png,
}

impl Format {
    /// The format of a file name.
    ///
    /// # Errors
    /// The extension is none of svg, pdf and png.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("pdf") => Ok(Self::Pdf),
            Some("png") => Ok(Self::Png),
            _ => Err(Error::input(format!(
                "{}: figures are written as .svg, .pdf or .png; end the name with one of these",
                path.display()
            ))),
        }
    }
}

impl Drawing {
    /// The bytes of a file. `notes` (name, text) travel inside: version, command, seed and the like.
    ///
    /// # Errors
    /// A PNG would be larger than 16384 pixels on a side.
    pub fn encode(&self, format: Format, notes: &[(&str, &str)]) -> Result<Vec<u8>> {
        match format {
            Format::Svg => Ok(svg::write(self, notes).into_bytes()),
            Format::Pdf => Ok(pdf::write(self, notes)),
            Format::Png => raster::write(self, notes),
        }
    }
}
