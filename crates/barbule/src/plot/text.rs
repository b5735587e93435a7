//! The font that is built in, so that pictures carry labels on machines without fonts.

use std::sync::OnceLock;

use ttf_parser::{Face, OutlineBuilder};

/// DejaVu Sans with Latin, Greek and the signs that figures need.
pub(super) static FONT: &[u8] = include_bytes!("../../data/font/DejaVuSans-subset.ttf");

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

/// The letters of a text with their signs in the font; a letter that the font lacks has its empty box, number 0.
pub(super) fn glyphs(text: &str) -> impl Iterator<Item = (char, u16)> + '_ {
    text.chars().map(|c| (c, face().and_then(|f| f.glyph_index(c)).map_or(0, |g| g.0)))
}

/// What a page that embeds the font says about it, in thousandths of its height.
pub(super) struct Metrics {
    /// Widths of all signs.
    pub(super) advances: Vec<f32>,
    /// Left, bottom, right, top of all signs.
    pub(super) bounds: [f32; 4],
    pub(super) ascent: f32,
    pub(super) descent: f32,
    /// Height of capital letters.
    pub(super) capitals: f32,
}

pub(super) fn metrics() -> Metrics {
    let Some(face) = face() else {
        return Metrics { advances: Vec::new(), bounds: [0.0; 4], ascent: 0.0, descent: 0.0, capitals: 0.0 };
    };
    let thousandths = |units: i16| f32::from(units) * 1000.0 / f32::from(face.units_per_em());
    let advance = |glyph| face.glyph_hor_advance(ttf_parser::GlyphId(glyph)).unwrap_or(0);
    let bounds = face.global_bounding_box();
    Metrics {
        advances: (0..face.number_of_glyphs())
            .map(|glyph| f32::from(advance(glyph)) * 1000.0 / f32::from(face.units_per_em()))
            .collect(),
        bounds: [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max].map(thousandths),
        ascent: thousandths(face.ascender()),
        descent: thousandths(face.descender()),
        capitals: thousandths(face.capital_height().unwrap_or(face.ascender())),
    }
}

/// A text in lines of at most `most` that are no wider than `width` px, its font `size` px high: broken behind spaces, `/`
/// and `,`; what does not fit is cut, with an ellipsis.
#[must_use]
pub fn wrapped(text: &str, size: f64, width: f64, most: usize) -> Vec<String> {
    let fits = |line: &str| self::width(line.trim_end(), size) <= width;
    let mut lines = vec![String::new()];
    for word in text.split_inclusive([' ', '/', ',']) {
        let last = lines.len() - 1;
        let longer = format!("{}{word}", lines[last]);
        if lines[last].is_empty() || fits(&longer) || lines.len() == most.max(1) {
            lines[last] = longer;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines.iter().map(|line| cut(line.trim(), size, width)).filter(|line| !line.is_empty()).collect()
}

/// A line cut to a width in px, with an ellipsis where something is missing.
#[must_use]
pub fn cut(line: &str, size: f64, width: f64) -> String {
    if self::width(line, size) <= width {
        return line.to_owned();
    }
    let mut short: String = line.to_owned();
    while short.pop().is_some() && self::width(&short, size) + self::width("…", size) > width {}
    format!("{}…", short.trim_end())
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

    #[test]
    fn long_texts_are_broken_or_cut_and_never_wider_than_asked() {
        let stack = "air/6*(melanin:99/keratin:100)/keratin";
        assert_eq!(wrapped(stack, 12.0, 1e3, 2), [stack]);
        let lines = wrapped(stack, 12.0, 130.0, 3);
        assert_eq!(lines.concat(), stack);
        assert!(lines.len() > 1 && lines.iter().all(|line| width(line, 12.0) <= 130.0), "{lines:?}");
        let short = wrapped(stack, 12.0, 90.0, 2);
        assert!(short.len() == 2 && short[1].ends_with('…') && width(&short[1], 12.0) <= 90.0, "{short:?}");
        assert!(wrapped("", 12.0, 90.0, 2).is_empty());
        assert_eq!(cut("word", 12.0, 1.0), "…");
    }
}
