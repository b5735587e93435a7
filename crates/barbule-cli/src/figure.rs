//! The figure of a command: where to, its title, its size, its words.

use std::path::{Path, PathBuf};

use barbule::error::shortened;
use barbule::plot::{Format, Page};
use barbule::{Error, Result};

use crate::common::Common;

/// Flags of every command that draws a figure.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct FigureArgs {
    /// Draw a figure: .svg, .pdf or .png
    #[arg(short, long, value_name = "FIG")]
    pub output: Option<PathBuf>,
    /// Title of the figure, '' for none [default: what it shows]
    #[arg(long, value_name = "TEXT", requires = "output", help_heading = FIGURE, value_parser = title)]
    pub title: Option<String>,
    /// Width and height of the figure, as in 85x60mm, 3.3x2.5in or 1200x800px
    #[arg(long, value_name = "WxH", requires = "output", help_heading = FIGURE, value_parser = size)]
    pub figure_size: Option<Size>,
    /// Size of the font of axis labels in points [default: follows the figure's width]
    #[arg(long, value_name = "PT", requires = "output", help_heading = FIGURE, value_parser = font_size)]
    pub font_size: Option<f64>,
    /// Pixels per inch of a PNG [default: 192]
    #[arg(long, value_name = "DPI", requires = "output", help_heading = FIGURE, value_parser = dpi)]
    pub figure_dpi: Option<f64>,
}

const FIGURE: &str = "Figure";

/// Letters of a title: what no figure has room for takes long to set.
const LONGEST_TITLE: usize = 500;

fn title(text: &str) -> Result<String> {
    match text.chars().count() {
        0..=LONGEST_TITLE => Ok(text.to_owned()),
        count => Err(Error::input(format!("a title of {count} letters; give at most {LONGEST_TITLE}"))),
    }
}

/// px in an inch, a point and a millimetre.
const INCH: f64 = 96.0;
const POINT: f64 = INCH / 72.0;
const MILLIMETRE: f64 = INCH / 25.4;

/// The least and the largest side of a figure, px: 20 mm and 2 m.
const SIDES: [f64; 2] = [20.0 * MILLIMETRE, 2000.0 * MILLIMETRE];

/// Width and height of a figure as they are given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    sides: [f64; 2],
    /// px of 1/96 inch in a unit; none for pixels, which are those of the file.
    unit: Option<f64>,
}

impl FigureArgs {
    /// The title to draw: the one given, else `usual`.
    #[must_use]
    pub fn title(&self, usual: impl Into<String>) -> String {
        self.title.clone().unwrap_or_else(|| usual.into())
    }

    /// The page to draw on.
    ///
    /// # Errors
    /// A side is under 20 mm or over 2 m.
    pub fn page(&self) -> Result<Page> {
        let png = self.output.as_deref().is_some_and(|path| Format::of(path).is_ok_and(|f| f == Format::Png));
        let usual = Page::default();
        let resolution = self.figure_dpi.map_or(usual.resolution, |dpi| dpi / INCH);
        let font = self.font_size.map(|points| points * POINT);
        let Some(Size { sides, unit }) = self.figure_size else {
            return Ok(Page { font, resolution, ..usual });
        };
        let pixel = if png { 1.0 / resolution } else { 1.0 };
        let size = sides.map(|side| side * unit.unwrap_or(pixel));
        if size.iter().any(|side| !(SIDES[0] * 0.999..=SIDES[1] * 1.001).contains(side)) {
            let [w, h] = size.map(|side| side / MILLIMETRE);
            return Err(Error::input(format!(
                "--figure-size: {w:.0} by {h:.0} mm; give 20 to 2000 mm for each side"
            )));
        }
        Ok(Page { size: Some(size), font, resolution })
    }

    /// Refuses, before any work, a figure that could not be written or whose page cannot be, and says which flags change
    /// nothing.
    ///
    /// # Errors
    /// As above.
    pub fn check(&self, common: &Common) -> Result<()> {
        let Some(path) = &self.output else { return Ok(()) };
        let format = Format::of(path)?;
        barbule::io::check_writable(path)?;
        self.page()?;
        if self.figure_dpi.is_some() && format != Format::Png {
            common.idle("--figure-dpi", "a figure of vectors has no pixels");
        }
        Ok(())
    }

    /// As [`FigureArgs::check`] for a figure that can only be drawn larger or smaller as a whole.
    ///
    /// # Errors
    /// As there.
    pub fn check_rigid(&self, common: &Common) -> Result<()> {
        self.check(common)?;
        if self.figure_size.is_some() && self.font_size.is_some() {
            common.idle("--font-size", "the words of this figure follow from its size");
        }
        Ok(())
    }

    /// Where the figure goes, if one is asked for.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.output.as_deref()
    }
}

/// Width and height with a unit: mm, cm, in, pt or px.
fn size(text: &str) -> Result<Size> {
    let refused = || {
        Error::input(format!(
            "--figure-size {}: give width and height with a unit, as in 85x60mm, 3.3x2.5in or 1200x800px",
            shortened(text)
        ))
    };
    let lower = text.trim().to_lowercase();
    let split = lower.trim_end_matches(|c: char| c.is_ascii_alphabetic()).len();
    let (numbers, unit) = lower.split_at(split);
    let unit = match unit {
        "mm" => Some(MILLIMETRE),
        "cm" => Some(10.0 * MILLIMETRE),
        "in" => Some(INCH),
        "pt" => Some(POINT),
        "px" => None,
        _ => return Err(refused()),
    };
    let side = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    let (width, height) = numbers.split_once('x').ok_or_else(refused)?;
    // 85mmx60mm says it twice.
    let width = width.trim().trim_end_matches(|c: char| c.is_ascii_alphabetic());
    Ok(Size { sides: [side(width).ok_or_else(refused)?, side(height).ok_or_else(refused)?], unit })
}

/// A number of points, from 3 to 72.
fn font_size(text: &str) -> Result<f64> {
    within(text.trim().trim_end_matches("pt"), 3.0, 72.0).ok_or_else(|| {
        Error::input(format!("--font-size {}: give points from 3 to 72, as in 8", shortened(text)))
    })
}

fn dpi(text: &str) -> Result<f64> {
    within(text, 36.0, 2400.0).ok_or_else(|| {
        Error::input(format!(
            "--figure-dpi {}: give pixels per inch from 36 to 2400, as in 300",
            shortened(text)
        ))
    })
}

fn within(text: &str, least: f64, most: f64) -> Option<f64> {
    text.trim().parse().ok().filter(|value: &f64| (least..=most).contains(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(output: &str, size_text: &str, dpi: Option<f64>) -> Page {
        let figure_size = Some(size(size_text).unwrap());
        FigureArgs { output: Some(output.into()), figure_size, figure_dpi: dpi, ..FigureArgs::default() }
            .page()
            .unwrap()
    }

    #[test]
    fn titles_have_room() {
        assert_eq!(title("θ_i").unwrap(), "θ_i");
        let said = title(&"θ".repeat(501)).unwrap_err().to_string();
        assert_eq!(said, "a title of 501 letters; give at most 500");
    }

    #[test]
    fn sizes_are_lengths_and_pixels_are_those_of_the_file() {
        let close = |page: Page, [w, h]: [f64; 2]| {
            let [a, b] = page.size.unwrap();
            assert!((a - w).abs() < 1e-9 && (b - h).abs() < 1e-9, "{a} {b}");
        };
        close(page("a.pdf", "25.4x50.8mm", None), [96.0, 192.0]);
        close(page("a.svg", "2.54x5.08cm", None), [96.0, 192.0]);
        close(page("a.png", "1x2in", None), [96.0, 192.0]);
        close(page("a.png", "25.4mm x 50.8mm", None), [96.0, 192.0]);
        close(page("a.png", "72X144pt", None), [96.0, 192.0]);
        close(page("a.svg", "600x400px", None), [600.0, 400.0]);
        // A PNG of so many pixels.
        close(page("a.png", "600x400px", None), [300.0, 200.0]);
        close(page("a.png", "600x400px", Some(96.0)), [600.0, 400.0]);
        assert_eq!(page("a.png", "85x60mm", Some(300.0)).resolution, 3.125);
    }

    #[test]
    fn what_is_no_size_is_refused_with_an_example() {
        for bad in
            ["", "85x60", "85mm", "axbmm", "85x60furlongs", "-85x60mm", "0x60mm", "infx60mm", "85x60x3mm"]
        {
            let error = size(bad).unwrap_err();
            assert!(error.is_input() && error.to_string().contains("85x60mm"), "{bad}: {error}");
        }
        let tiny = FigureArgs { figure_size: Some(size("5x60mm").unwrap()), ..FigureArgs::default() };
        assert!(tiny.page().unwrap_err().to_string().contains("5 by 60 mm; give 20 to 2000 mm"));
        assert!(font_size("2").is_err() && font_size("nan").is_err() && dpi("1e9").is_err());
        assert_eq!((font_size("8pt").unwrap(), dpi("300").unwrap()), (8.0, 300.0));
    }
}
