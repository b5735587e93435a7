//! What was traced, drawn over the picture that it was traced from.

use super::TracedImage;
use crate::figures::scale_bar_of;
use crate::plot::{Anchor, Axis, Curve, Drawing, Figure, Ink, Item, Page, Picture, Stroke, text};
use crate::trace::{BINS, Bar, Grey, Kind, LEAST_SIDE, Spread};

/// Width of the page and of the picture on it, px.
const PAGE: f64 = 1000.0;
const PICTURE: f64 = 600.0;
const MARGIN: f64 = 24.0;
const FONT: f64 = 14.0;
const LINE: f64 = 20.0;
/// The picture is drawn with at most this many pixels a side.
const MOST_SHOWN: usize = 900;
/// Inks of outlines: of the darkest class, of what is in it, of boundaries. Light enough for black, dark enough for white.
const OUTER: Ink = Ink::of([230, 90, 20]);
const INNER: Ink = Ink::of([0, 150, 220]);
const LIMIT: Ink = Ink::of([20, 160, 70]);
const AXIS: Ink = Ink::of([200, 40, 160]);

impl TracedImage {
    /// The flattened picture with outlines, rows or layers over it; the histogram with the thresholds; the measures. `bar` is the scale bar
    /// that the scale was taken from, and the picture with it: the part that was cut off is drawn below.
    #[must_use]
    pub fn figure(&self, title: &str, page: &Page, bar: Option<(&Grey, Bar)>) -> Drawing {
        page.lay_out(FONT, |_| self.drawn(title, bar))
    }

    fn drawn(&self, title: &str, bar: Option<(&Grey, Bar)>) -> Drawing {
        let [width, height] = self.traced.flat.size().map(|side| side as f64);
        let scale = (PICTURE / width).min(1.1 * PICTURE / height);
        let title = text::wrapped(title, 18.0, PAGE - 2.0 * MARGIN, 2);
        let top = 20.0 + 24.0 * title.len() as f64;
        let area = [MARGIN, top, width * scale, height * scale];
        let beside = area[0] + area[2] + 30.0;
        let chart = self.histogram().draw_on(&Page::sized(PAGE - MARGIN - beside, 280.0));
        let words: Vec<String> = self
            .words(bar)
            .iter()
            .flat_map(|line| text::wrapped(line, FONT, PAGE - MARGIN - beside, 4))
            .collect();
        let under = top + chart.height + 14.0;
        let strip = bar.and_then(|(picture, bar)| strip_of(picture, bar));
        let strip_at = top + area[3] + 52.0;
        let strip_height = strip.as_ref().map_or(0.0, |(strip, _)| strip.size()[1] as f64 * scale + 40.0);
        let bottom = (strip_at + 8.0 + strip_height).max(under + LINE * (words.len() as f64 + 1.0));
        let mut drawing = Drawing::new(PAGE, bottom);
        for (line, words) in title.into_iter().enumerate() {
            drawing.text([MARGIN, 26.0 + 24.0 * line as f64], 18.0, Anchor::Start, words);
        }
        drawing.items.push(Item::Picture { area, picture: shown(&self.traced.flat, 1.0) });
        let items = self.outlines(|p: &[f64; 2]| [area[0] + p[0] * scale, area[1] + p[1] * scale]);
        drawing.items.push(Item::Clip { area, items });
        drawing.rectangle(area, None, Some(Stroke::solid(Ink::BLACK, 1.0)));
        scale_bar_of(&mut drawing, area, scale / (self.nm_per_px * 1e-3));
        if let Some((strip, bar)) = strip {
            let [wide, tall] = strip.size().map(|side| side as f64 * scale);
            let area = [MARGIN, strip_at, wide, tall];
            drawing.items.push(Item::Picture { area, picture: shown(&strip, 255.0) });
            let [left, upper, right, lower] = bar.map(|side| side as f64 * scale);
            let around =
                [MARGIN + left - 3.0, strip_at + upper - 3.0, right - left + 6.0, lower - upper + 6.0];
            drawing.rectangle(around, None, Some(Stroke::solid(OUTER, 2.0)));
            drawing.text(
                [MARGIN, strip_at + tall + 20.0],
                FONT,
                Anchor::Start,
                "not measured; outlined: the scale bar that was found",
            );
        }
        drawing.place(chart, [beside, top]);
        for (line, words) in words.into_iter().enumerate() {
            drawing.text([beside, under + LINE * (line + 1) as f64], FONT, Anchor::Start, words);
        }
        drawing
    }

    fn outlines(&self, place: impl Fn(&[f64; 2]) -> [f64; 2]) -> Vec<Item> {
        let traced = &self.traced;
        let line = |points: &[[f64; 2]], closed: bool, stroke: Stroke| Item::Path {
            runs: vec![points.iter().map(&place).collect()],
            closed,
            fill: None,
            stroke: Some(stroke),
        };
        let dashed = |ink: Ink| Stroke { dash: vec![7.0, 4.0], ..Stroke::solid(ink, 1.8) };
        let mut items = Vec::new();
        if traced.kind == Kind::Section {
            let dark = self.media.len() - 1;
            items.extend(traced.inclusions.iter().map(|(class, outline)| {
                let stroke = if *class == dark { Stroke::solid(OUTER, 1.8) } else { dashed(INNER) };
                line(&outline.corners, true, stroke)
            }));
        }
        if traced.kind == Kind::Lattice {
            for rod in &traced.rods {
                for (index, outline) in rod.outlines.iter().enumerate() {
                    let stroke = if index == 0 { Stroke::solid(OUTER, 1.8) } else { dashed(INNER) };
                    items.push(line(&outline.corners, true, stroke));
                }
            }
            let dotted = Stroke { dash: vec![2.0, 3.0], ..Stroke::solid(AXIS, 1.4) };
            let ends = traced.lattice.iter().flat_map(|lattice| &lattice.ends);
            items.extend(ends.map(|ends| line(ends, false, dotted.clone())));
        }
        items.extend(
            traced.bands.boundaries.iter().map(|boundary| line(boundary, false, Stroke::solid(LIMIT, 2.0))),
        );
        items
    }

    /// How many pixels have each grey, and the thresholds.
    fn histogram(&self) -> Figure {
        let counts = &self.traced.counts;
        let all = f64::from(counts.iter().sum::<u32>()).max(1.0);
        let mut figure = Figure::new(
            "",
            Axis::with_range("grey level, flattened", 0.0, BINS as f64),
            Axis::new("pixels (%)"),
        );
        let points: Vec<[f64; 2]> = counts
            .iter()
            .enumerate()
            .map(|(bin, n)| [bin as f64 + 0.5, 100.0 * f64::from(*n) / all])
            .collect();
        let most = points.iter().map(|p| p[1]).fold(0.0, f64::max);
        figure.curves.push(Curve::line("pixels away from edges", points));
        for (index, threshold) in self.traced.thresholds.iter().enumerate() {
            let name = format!("{threshold:.0}: {} | {}", self.media[index + 1], self.media[index]);
            let dash = vec![[6.0, 4.0], [2.0, 3.0]][index % 2].to_vec();
            let stroke = Some(Stroke { dash, ..Stroke::solid([OUTER, INNER][index % 2], 1.8) });
            figure
                .curves
                .push(Curve { stroke, ..Curve::line(name, vec![[*threshold, 0.0], [*threshold, most]]) });
        }
        figure
    }

    /// The measures in words.
    fn words(&self, bar: Option<(&Grey, Bar)>) -> Vec<String> {
        let nm = |name: &str, spread: Spread| format!("{name}: {:.1} ± {:.1} nm", spread.mean, spread.std);
        let mut words = vec![format!("1 px = {:.4} nm", self.nm_per_px)];
        if let Some((_, bar)) = bar {
            words.push(format!("scale bar found: {:.1} px", bar.length));
        }
        match (self.traced.kind, &self.traced.lattice) {
            (Kind::Lattice, Some(lattice)) => {
                words.push(format!("{} rods in {} rows", self.traced.rods.len(), lattice.rows));
                words.push(nm("period", self.nm(lattice.period)));
                if lattice.rows > 1 {
                    words.push(nm("row pitch", self.nm(lattice.row_pitch)));
                    words.push(format!(
                        "row shift: {:.3} ± {:.3}",
                        lattice.row_shift.mean, lattice.row_shift.std
                    ));
                }
                words.push(nm("diameter", self.nm(lattice.diameter)));
                if lattice.hollow.mean > 0.0 {
                    words.push(nm("hollow", self.nm(lattice.hollow)));
                }
                words.extend(self.traced.cortex.map(|cortex| nm("cortex", self.nm(cortex))));
            }
            (Kind::Layers, _) => {
                words.extend(self.layers_nm().take(24).map(|(medium, thickness)| nm(medium, thickness)));
            }
            _ => words.push(format!("{} regions wholly inside", self.traced.inclusions.len())),
        }
        if self.traced.kind != Kind::Section {
            words.push("± one standard deviation".into());
        }
        words
    }
}

/// The part of a picture that was cut off with its scale bar, and the bar's bounds in it.
fn strip_of(picture: &Grey, bar: Bar) -> Option<(Grey, [usize; 4])> {
    let [width, height] = picture.size();
    let [left, top, right, bottom] = bar.bounds;
    let (from, to) = if bar.free[0] == 0 { (bar.free[1], height) } else { (0, bar.free[0]) };
    // A strip is at least as high as a picture must be.
    let from = from.min(to.saturating_sub(LEAST_SIDE));
    let strip = picture.part([0, from, width, (to - from).max(LEAST_SIDE)]).ok()?;
    Some((strip, [left, top - from, right, bottom - from]))
}

/// A picture in greys, means of pixels where it is large; `white` brings its values to 0 … 255.
fn shown(grey: &Grey, white: f32) -> Picture {
    let [width, height] = grey.size();
    let step = width.max(height).div_ceil(MOST_SHOWN);
    let (columns, rows) = (width / step, height / step);
    let mut rgba = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let of_line = |y: usize| {
                let from = (row * step + y) * width + column * step;
                grey.values()[from..from + step].iter().sum::<f32>()
            };
            let value = white * (0..step).map(of_line).sum::<f32>() / (step * step) as f32;
            let value = value.round().clamp(0.0, 255.0) as u8;
            rgba.push([value, value, value, 255]);
        }
    }
    Picture { width: columns, height: rows, rgba }
}
