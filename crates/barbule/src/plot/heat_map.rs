//! A quantity over a plane, as colours with their scale.

use super::axes::{Axis, Frame, MEDIUM, SMALL, Words, high_enough, is_in_degrees, spaced, ticks};
use super::drawing::{Anchor, Drawing, Ink, Item, Picture, Stroke};
use super::page::{Page, heading_height};
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
    /// A colour for each cell in place of those of a scale, which is then not drawn; empty for none.
    pub colours: Vec<[u8; 3]>,
    /// Width and height of the map in px.
    pub size: [f64; 2],
    /// Whether the map keeps the shape of `size` on a page of any other shape: both axes are then to one scale.
    pub keeps_shape: bool,
}

/// The distance of the vertical axis's label from the map where there is room, px.
const LABEL_AT: f64 = 46.0;
/// The least width and height of the map in px; on smaller pages everything is smaller.
const LEAST: [f64; 2] = [40.0, 40.0];
/// From the map to the scale of colours, and the scale's width, px.
const BAR: [f64; 2] = [18.0, 14.0];

/// What a line of the scale's label takes, px.
const LABEL_LINE: f64 = 18.0;

/// A map, its words, and its whole width and height.
struct Layout {
    frame: Frame,
    words: Words,
    /// Least distance of the vertical axis's label.
    label_at: f64,
    size: [f64; 2],
    /// Ticks of the scale of colours, and where its label is.
    marks: Vec<(f64, String)>,
    mark_width: f64,
    label: Vec<String>,
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
            colours: Vec::new(),
            size: [420.0, 330.0],
            keeps_shape: false,
        }
    }

    /// A map of colours, `columns` in a row, the first row at the lower end of y.
    #[must_use]
    pub fn of_colours(
        title: impl Into<String>,
        x: Axis,
        y: Axis,
        columns: usize,
        colours: Vec<[u8; 3]>,
    ) -> Self {
        Self { colours, ..Self::new(title, x, y, columns, Vec::new()) }
    }

    /// Draws the map and its scale of colours, as large as `size` says.
    #[must_use]
    pub fn draw(&self) -> Drawing {
        self.draw_on(&Page::default())
    }

    /// Draws the map and its scale of colours on a page.
    #[must_use]
    pub fn draw_on(&self, page: &Page) -> Drawing {
        page.lay_out(MEDIUM, |size| self.lay_out(size))
    }

    fn layout(&self, size: Option<[f64; 2]>) -> Layout {
        let marks = |height: f64| {
            let of = |wanted| ticks(self.shown(), wanted);
            spaced(of, (height / 40.0) as usize, |ticks| high_enough(ticks, height))
        };
        let widest =
            |height: f64| marks(height).iter().map(|(_, t)| text::width(t, SMALL)).fold(0.0, f64::max);
        let label_at = if size.is_some() { 0.0 } else { LABEL_AT };
        let page_width = size.map_or(self.size[0] + 64.0 + 100.0, |[width, _]| width);
        let words = Words::new(&self.title, &self.x.label, page_width);
        let mut height = size.map_or(self.size[1], |[_, h]| (h - words.top() - words.below()).max(LEAST[1]));
        let mark_width = widest(height);
        let words = words.beside(&self.y.label, height);
        let top = words.top();
        let unit = [0.0, 1.0];
        let frame = |area: [f64; 4]| Frame {
            area,
            x: self.x.range.unwrap_or(unit),
            y: self.y.range.unwrap_or(unit),
            logarithmic: [false; 2],
            degrees: [&self.x, &self.y].map(is_in_degrees),
        };
        let left = words.left(&frame([0.0, top, self.size[0], height]), label_at);
        let label = text::wrapped(&self.label, MEDIUM, top + height + 20.0, 2);
        let right = match self.colours[..] {
            [] => BAR[0] + BAR[1] + 8.0 + mark_width + LABEL_LINE * label.len() as f64 + 12.0,
            _ => 20.0,
        };
        let mut width = size.map_or(self.size[0], |[w, _]| (w - left - right).max(LEAST[0]));
        if self.keeps_shape {
            let scale = (width / self.size[0]).min(height / self.size[1]);
            [width, height] = self.size.map(|length| length * scale);
        }
        Layout {
            frame: frame([left, top, width, height]),
            label_at,
            size: [(left + width + right).ceil(), top + height + words.below()],
            words,
            marks: marks(height),
            mark_width,
            label,
        }
    }

    fn lay_out(&self, size: Option<[f64; 2]>) -> Drawing {
        let Layout { frame, words, label_at, size, marks, mark_width, label } = self.layout(size);
        let range = self.shown();
        let [left, top, width, height] = frame.area;
        let mut drawing = Drawing::new(size[0], size[1]);
        drawing.items.push(Item::Picture { area: frame.area, picture: self.picture(range) });
        frame.outline(&mut drawing);
        words.write(&mut drawing, &frame, label_at);
        if !self.colours.is_empty() {
            return drawing;
        }
        let bar = [left + width + BAR[0], top, BAR[1], height];
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
        for (line, text) in label.into_iter().enumerate() {
            let half = 0.5 * text::width(&text, MEDIUM);
            drawing.items.push(Item::Text {
                at: [
                    right + 8.0 + mark_width + LABEL_LINE * (line + 1) as f64,
                    (top + height / 2.0).max(half + 2.0),
                ],
                size: MEDIUM,
                text,
                anchor: Anchor::Middle,
                turn: 90.0,
                ink: Ink::BLACK,
            });
        }
        drawing
    }

    /// The values of the first and last colour.
    fn shown(&self) -> [f64; 2] {
        self.range.unwrap_or_else(|| self.covered())
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
        let colour = |v: &f64| self.map.at((v - range[0]) / (range[1] - range[0]));
        let of_scale: Vec<[u8; 3]>;
        let colours = match self.colours[..] {
            [] => {
                of_scale = self.values.iter().map(colour).collect();
                &of_scale
            }
            _ => &self.colours,
        };
        let rows = colours.chunks_exact(columns);
        let height = rows.len();
        let rgba = rows.rev().flat_map(|row| row.iter().copied().map(opaque)).collect();
        Picture { width: columns, height, rgba }
    }
}

/// Maps beside each other, or below each other where they are larger so, under a heading.
#[must_use]
pub fn abreast(heading: &str, maps: &[HeatMap], page: &Page) -> Drawing {
    page.lay_out(MEDIUM, |size| {
        let drawn: Vec<Drawing> = match size {
            None => maps.iter().map(|map| map.lay_out(None)).collect(),
            Some([width, height]) => {
                let cell = best_cell(maps, [width, height - heading_height(heading, width)]);
                maps.iter().map(|map| map.draw_on(&Page::part(cell))).collect()
            }
        };
        let width = size.map_or_else(|| drawn.iter().map(|d| d.width).sum::<f64>(), |[width, _]| width);
        let mut drawing = Drawing::new(width, 0.0);
        let (mut x, mut y, mut row) = (0.0, 0.0, 0.0_f64);
        for panel in drawn {
            if x > 0.0 && x + panel.width > width + 1e-6 {
                (x, y, row) = (0.0, y + row, 0.0);
            }
            let next = x + panel.width;
            row = row.max(panel.height);
            drawing.place(panel, [x, y]);
            x = next;
        }
        drawing.height = y + row;
        drawing.under(heading)
    })
}

/// The part of a page for each map, of the arrangement in which the smallest map is largest.
fn best_cell(maps: &[HeatMap], [width, height]: [f64; 2]) -> [f64; 2] {
    let cell = |columns: usize| [width / columns as f64, height / maps.len().div_ceil(columns) as f64];
    let smallest = |columns: usize| {
        let area = |map: &HeatMap| {
            let [_, _, w, h] = map.layout(Some(cell(columns))).frame.area;
            w * h
        };
        maps.iter().map(area).fold(f64::INFINITY, f64::min)
    };
    let best = (1..=maps.len()).max_by(|a, b| smallest(*a).total_cmp(&smallest(*b))).unwrap_or(1);
    cell(best)
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Format;
    use crate::plot::places::assert_words_stand_apart;

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
    fn words_of_maps_of_any_size_stand_on_the_page_and_apart() {
        for (width, height) in [(85.0, 60.0), (85.0, 110.0), (170.0, 60.0), (300.0, 200.0)] {
            for panels in 1..=3 {
                let maps: Vec<HeatMap> = (0..panels)
                    .map(|panel| {
                        let x = Axis::with_range("wavelength in vacuum (nm)", 300.0, 830.0);
                        let y = Axis::with_range("φ_i (°)", -90.0, 90.0);
                        let values = vec![0.0, 0.5, 0.7, 0.96];
                        let mut map = HeatMap::new(format!("polarization {}", panel + 1), x, y, 2, values);
                        map.label = "reflectance, all orders".into();
                        map.keeps_shape = panels == 3;
                        map
                    })
                    .collect();
                let px = 96.0 / 25.4;
                let drawing =
                    abreast("mallard:green, θ_i = 20°", &maps, &Page::sized(width * px, height * px));
                assert_words_stand_apart(&drawing, &format!("{width} x {height} mm, {panels} maps"));
            }
        }
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
