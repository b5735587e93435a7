//! The font that is built in, so that pictures carry labels on machines without fonts.

use std::sync::OnceLock;

use ttf_parser::{Face, OutlineBuilder};

/// DejaVu Sans with Latin, Greek and the signs that figures need.
static FONT: &[u8] = include_bytes!("../../data/font/DejaVuSans-subset.ttf");

fn face() -> Option<&'static Face<'static>> {
    static FACE: OnceLock<Option<Face<'static>>> = OnceLock::new();
    // A test reads the built-in font; without one a figure would only lack its labels.
    FACE.get_or_init(|| Face::parse(FONT, 0).ok()).as_ref()
}

/// The width in px of a line of text whose font is `size` px high.
#[must_use]
pub fn width(text: &str, size: f64) -> f64 {
    let Some(face) = face() else { return 0.0 };
    let advance = |c| face.glyph_index(c).and_then(|g| face.glyph_hor_advance(g)).unwrap_or(0);
    let units: f64 = text.chars().map(|c| f64::from(advance(c))).sum();
    units * size / f64::from(face.units_per_em())
}

/// The outlines of a line of text that starts at the origin, y down, its font `size` px high.
pub(super) fn outline(text: &str, size: f64) -> Option<tiny_skia::Path> {
    let face = face()?;
    let mut pen = Pen {
        builder: tiny_skia::PathBuilder::new(),
        x: 0.0,
        scale: (size / f64::from(face.units_per_em())) as f32,
    };
    for c in text.chars() {
        // A letter that the font lacks shows as its empty box.
        let glyph = face.glyph_index(c).unwrap_or(ttf_parser::GlyphId(0));
        face.outline_glyph(glyph, &mut pen);
        pen.x += f32::from(face.glyph_hor_advance(glyph).unwrap_or(0)) * pen.scale;
    }
    pen.builder.finish()
}

/// Turns a glyph's outline into a path.
struct Pen {
    builder: tiny_skia::PathBuilder,
    x: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, -y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.builder.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_the_letters_that_figures_need() {
        let face = face().unwrap();
        for c in "aZ09 °±·µλφθσ−–…²₀ₛₚ→≤∞".chars() {
            assert!(face.glyph_index(c).is_some(), "{c}");
        }
        assert!(width("wide", 12.0) > width("w", 12.0));
        assert!(outline("λ", 12.0).unwrap().bounds().height() > 6.0);
    }
}
