//! A quantity over a plane, as colours with their scale.

use super::axes::{Axis, Frame, MEDIUM, SMALL, ticks};
use super::drawing::{Anchor, Drawing, Ink, Item, Picture, Stroke};
use super::palette::Map;
use super::text;

/// Values on a grid of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Above the map.
    pub title: String,
    /// The horizontal axis; its range is that of the cells' outer edges, 0 to 1 unless given.
    pub x: Axis,
    /// The vertical axis, likewise.
    pub y: Axis,
    /// How many cells there are in a row.
    pub columns: usize,
    /// The values row by row; the first row is at the lower end of y. NaN is drawn grey.
    pub values: Vec<f64>,
    /// Quantity and unit of the values.
    pub label: String,
    /// The values of the first and last colour, or the smallest and largest value.
    pub range: Option<[f64; 2]>,
    /// The colours.
    pub map: Map,
    /// Width and height of the map in px.
    pub size: [f64; 2],
}

impl HeatMap {
    /// A map of `values`, `columns` in a row, with colours from the smallest to the largest.
    #[must_use]
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, columns: usize, values: Vec<f64>) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            columns,
            values,
            label: String::new(),
            range: None,
            map: Map::default(),
            size: [420.0, 330.0],
        }
    }

    /// Draws the map and its scale of colours.
    #[must_use]
    pub fn draw(&self) -> Drawing {
        let range = self.range.unwrap_or_else(|| self.covered());
        let (left, top) = (64.0, if self.title.is_empty() { 16.0 } else { 34.0 });
        let [width, height] = self.size;
        let marks = ticks(range, (height / 40.0) as usize);
        let widest = marks.iter().map(|(_, t)| text::width(t, SMALL)).fold(0.0, f64::max);
        let bar = [left + width + 18.0, top, 14.0, height];
        let label_at = bar[0] + bar[2] + 8.0 + widest + 18.0;
        let mut drawing = Drawing::new((label_at + 12.0).ceil(), top + height + 46.0);
        let unit = [0.0, 1.0];
        let frame = Frame {
            area: [left, top, width, height],
            x: self.x.range.unwrap_or(unit),
            y: self.y.range.unwrap_or(unit),
            logarithmic: [false; 2],
        };
        drawing.items.push(Item::Picture { area: frame.area, picture: self.picture(range) });
        frame.outline(&mut drawing, &self.x.label, &self.y.label, &self.title);
        let steps = (0..256).rev().map(|i| opaque(self.map.at(f64::from(i) / 255.0))).collect();
        drawing
            .items
            .push(Item::Picture { area: bar, picture: Picture { width: 1, height: 256, rgba: steps } });
        let line = Stroke::solid(Ink::BLACK, 1.0);
        drawing.rectangle(bar, None, Some(line.clone()));
        let right = bar[0] + bar[2];
        for (at, text) in marks {
            let y = top + height * (1.0 - (at - range[0]) / (range[1] - range[0]));
            drawing.line([right, y], [right + 4.0, y], line.clone());
            drawing.text([right + 7.0, y + 4.0], SMALL, Anchor::Start, text);
        }
        drawing.items.push(Item::Text {
            at: [label_at, top + height / 2.0],
            size: MEDIUM,
            text: self.label.clone(),
            anchor: Anchor::Middle,
            turn: 90.0,
            ink: Ink::BLACK,
        });
        drawing
    }

    fn covered(&self) -> [f64; 2] {
        let finite = self.values.iter().copied().filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low < high {
            [low, high]
        } else if low == high {
            [low, low + low.abs().max(1.0)]
        } else {
            [0.0, 1.0]
        }
    }

    fn picture(&self, range: [f64; 2]) -> Picture {
        let columns = self.columns.max(1);
        let rows: Vec<_> = self.values.chunks_exact(columns).collect();
        let colour = |v: &f64| opaque(self.map.at((v - range[0]) / (range[1] - range[0])));
        let rgba = rows.iter().rev().flat_map(|row| row.iter().map(colour)).collect();
        Picture { width: columns, height: rows.len(), rgba }
    }
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Format;

    #[test]
    fn the_first_row_is_at_the_bottom_and_nan_is_grey() {
        let map = HeatMap::new("", Axis::new("x"), Axis::new("y"), 2, vec![0.0, 1.0, f64::NAN, 0.5]);
        let picture = map.picture([0.0, 1.0]);
        assert_eq!((picture.width, picture.height), (2, 2));
        assert_eq!(picture.rgba[0], [128, 128, 128, 255]);
        assert_eq!(picture.rgba[2], opaque(Map::Viridis.at(0.0)));
        assert_eq!(picture.rgba[3], opaque(Map::Viridis.at(1.0)));
    }

    #[test]
    fn maps_without_finite_values_are_drawn() {
        for values in [vec![], vec![f64::NAN; 4], vec![3.0; 4]] {
            let map = HeatMap::new("t", Axis::new("x"), Axis::new("y"), 2, values);
            map.draw().encode(Format::Png, &[]).unwrap();
            let svg = String::from_utf8(map.draw().encode(Format::Svg, &[]).unwrap()).unwrap();
            assert!(!svg.contains("NaN"));
        }
    }
}
