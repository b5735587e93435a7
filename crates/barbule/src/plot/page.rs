//! How large a figure is, and how large its words are.

use super::drawing::{Anchor, Drawing};
use super::text;

/// Pixels of a PNG for each px unless a figure asks for others.
pub(super) const RESOLUTION: f64 = 2.0;

/// Height of the font of axis labels in px; ticks and titles are in proportion.
pub(super) const USUAL_FONT: f64 = 12.5;

/// Height of the font of titles, and from one line of a heading over several figures to the next, px.
pub(super) const TITLE: f64 = 14.0;
const HEADING_LINE: f64 = 22.0;

/// The width in px whose words are usually that large.
const USUAL_WIDTH: f64 = 600.0;

/// A figure's page. Lengths are in px of 1/96 inch, as in SVG.
///
/// Words (and with them lines and signs) are laid out at one size and then scaled, so that a figure of a column's width has
/// the proportions of a large one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Page {
    /// Width and height, or as large as the content asks for.
    pub size: Option<[f64; 2]>,
    /// Height of the font of axis labels; unless given 12.5, and on a page of given size larger with the root of its
    /// width.
    pub font: Option<f64>,
    /// Pixels of a PNG for each px.
    pub resolution: f64,
}

impl Default for Page {
    fn default() -> Self {
        Self { size: None, font: None, resolution: RESOLUTION }
    }
}

impl Page {
    /// A page of this size whose words follow from its width.
    #[must_use]
    pub fn sized(width: f64, height: f64) -> Self {
        Self { size: Some([width, height]), ..Self::default() }
    }

    /// Height of the font of axis labels, px.
    fn words(&self) -> f64 {
        let usual = |[width, _]: [f64; 2]| USUAL_FONT * (width / USUAL_WIDTH).sqrt().clamp(0.7, 1.6);
        self.font.unwrap_or_else(|| self.size.map_or(USUAL_FONT, usual))
    }

    /// Draws with words `font` px high what is then scaled to this page's words. `draw` is told the page's width and
    /// height in its own px, where they are given; what is larger all the same is made smaller.
    pub fn lay_out(&self, font: f64, draw: impl FnOnce(Option<[f64; 2]>) -> Drawing) -> Drawing {
        let usual = self.size.is_none() && self.font.is_none();
        let scale = if usual { 1.0 } else { self.words() / font };
        let drawing = draw(self.size.map(|size| size.map(|length| length / scale))).scaled(scale);
        let page = match self.size {
            Some(size) => fitted(drawing, size),
            None => drawing,
        };
        Drawing { resolution: self.resolution, ..page }
    }

    /// A drawing that cannot be laid out otherwise, as large as this page allows; its words are as large as `font` asks
    /// for only where no size is given.
    #[must_use]
    pub fn place(&self, drawing: Drawing) -> Drawing {
        let page = match self.size {
            Some(size @ [width, height]) => {
                let scale = (width / drawing.width).min(height / drawing.height);
                fitted(drawing.scaled(scale), size)
            }
            None => drawing.scaled(self.words() / USUAL_FONT),
        };
        Drawing { resolution: self.resolution, ..page }
    }

    /// The same page for a part of it, in units of a drawing.
    pub(super) fn part(size: [f64; 2]) -> Self {
        Self { size: Some(size), font: Some(USUAL_FONT), resolution: RESOLUTION }
    }
}

impl Drawing {
    /// The same under a heading; without words as it was.
    #[must_use]
    pub fn under(self, heading: &str) -> Self {
        let lines = heading_lines(heading, self.width);
        if lines.is_empty() {
            return self;
        }
        let above = heading_height(heading, self.width);
        let mut page = Self::new(self.width, self.height + above);
        for (line, text) in lines.into_iter().enumerate() {
            page.text([self.width / 2.0, 18.0 + HEADING_LINE * line as f64], TITLE, Anchor::Middle, text);
        }
        page.place(self, [0.0, above]);
        page
    }
}

fn heading_lines(heading: &str, width: f64) -> Vec<String> {
    text::wrapped(heading, TITLE, width - 16.0, 3)
}

/// What [`Drawing::under`] adds to a drawing that is `width` px wide.
pub(super) fn heading_height(heading: &str, width: f64) -> f64 {
    HEADING_LINE * heading_lines(heading, width).len() as f64
}

/// A drawing in the middle of a page, smaller where it would not fit.
fn fitted(drawing: Drawing, [width, height]: [f64; 2]) -> Drawing {
    let scale = (width / drawing.width).min(height / drawing.height);
    // Rounding is no reason to shrink.
    let drawing = if scale < 1.0 - 1e-9 { drawing.scaled(scale) } else { drawing };
    let mut page = Drawing::new(width, height);
    let at = [0.5 * (width - drawing.width), 0.5 * (height - drawing.height)].map(|v| v.max(0.0));
    page.place(drawing, at);
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Anchor, Item};

    fn word(font: f64) -> Drawing {
        let mut drawing = Drawing::new(100.0, 50.0);
        drawing.text([10.0, 20.0], font, Anchor::Start, "word");
        drawing
    }

    fn size_and_place(drawing: &Drawing) -> (f64, [f64; 2]) {
        let Item::Text { at, size, .. } = &drawing.items[0] else { panic!() };
        (*size, *at)
    }

    #[test]
    fn words_are_as_large_as_asked_for_on_a_page_of_any_size() {
        let page = Page { size: Some([300.0, 200.0]), font: Some(10.0), resolution: 3.0 };
        let drawing = page.lay_out(20.0, |size| {
            assert_eq!(size, Some([600.0, 400.0]));
            Drawing { width: 600.0, height: 400.0, ..word(20.0) }
        });
        assert_eq!((drawing.width, drawing.height, drawing.resolution), (300.0, 200.0, 3.0));
        assert_eq!(size_and_place(&drawing), (10.0, [5.0, 10.0]));
        let larger = Page { font: Some(25.0), ..Page::default() }.place(word(12.5));
        assert_eq!((larger.width, size_and_place(&larger)), (200.0, (25.0, [20.0, 40.0])));
    }

    #[test]
    fn what_has_a_shape_of_its_own_stands_in_the_middle_of_the_page() {
        let drawing = Page::sized(100.0, 100.0).place(word(12.5));
        assert_eq!((drawing.width, drawing.height), (100.0, 100.0));
        assert_eq!(size_and_place(&drawing), (12.5, [10.0, 45.0]));
        let small = Page::sized(50.0, 100.0).place(word(12.5));
        assert_eq!(size_and_place(&small), (6.25, [5.0, 47.5]));
    }

    #[test]
    fn a_heading_stands_above_and_none_changes_nothing() {
        let drawing = word(12.5).under("heading");
        assert_eq!((drawing.width, drawing.height), (100.0, 72.0));
        assert_eq!(drawing.items[0], Drawing { items: Vec::new(), ..word(1.0) }.under("heading").items[0]);
        assert_eq!(word(12.5).under(""), word(12.5));
    }

    #[test]
    fn words_grow_less_than_the_page() {
        let words = |width: f64| Page::sized(width, 300.0).words();
        assert_eq!(words(600.0), 12.5);
        assert!((words(1200.0) - 12.5 * 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((words(100.0), words(1e4)), (12.5 * 0.7, 20.0));
    }
}
