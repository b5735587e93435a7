//! For tests: where the words of a drawing stand.

use super::drawing::{Drawing, Item};
use super::text;

/// Left, top, right, bottom of each text of a drawing, px.
fn places(drawing: &Drawing) -> Vec<(String, [f64; 4])> {
    let place = |item: &Item| {
        let Item::Text { at: [x, y], size, text, anchor, turn, .. } = item else { return None };
        let (width, before) = (text::width(text, *size), anchor.before(text, *size));
        // Letters without their ascenders and descenders.
        let (above, below) = (0.72 * size, 0.05 * size);
        let area = if *turn == 0.0 {
            [x - before, y - above, x - before + width, y + below]
        } else {
            [x - above, y + before - width, x + below, y + before]
        };
        Some((text.clone(), area))
    };
    drawing.items.iter().filter_map(place).collect()
}

/// Holds that all words stand on the page and apart from each other.
pub(super) fn assert_words_stand_apart(drawing: &Drawing, what: &str) {
    let places = places(drawing);
    assert!(!places.is_empty());
    for (i, (text, [left, top, right, bottom])) in places.iter().enumerate() {
        let on_page =
            *left >= -0.5 && *top >= -0.5 && *right <= drawing.width + 0.5 && *bottom <= drawing.height + 0.5;
        assert!(on_page, "{what}: '{text}' leaves the page: {:?}", places[i].1);
        for (other, [l, t, r, b]) in &places[..i] {
            let apart = right <= l || r <= left || bottom <= t || b <= top;
            assert!(apart, "{what}: '{text}' and '{other}' overlap");
        }
    }
}
