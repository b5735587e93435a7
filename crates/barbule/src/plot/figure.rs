//! Line charts.

use super::axes::{Axis, Frame, LARGE, MEDIUM, SMALL, covering, log_covering};
use super::drawing::{Anchor, Drawing, Ink, Item, Stroke};
use super::{palette, text};

/// Usual width and height of the plotted area in px.
const SIZE: [f64; 2] = [520.0, 330.0];
/// Curves that the legend names; more are counted.
const MOST_NAMED: usize = 18;
/// From one swatch of the legend to the next in px.
const SWATCH_STEP: f64 = 20.0;

/// How a curve's points are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mark {
    /// A line through them (a dot where a point stands alone).
    #[default]
    Line,
    /// A sign at each.
    Points,
    /// A line and signs.
    Both,
}

/// One curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// What the legend says; a curve without a name is not in it.
    pub name: String,
    /// (x, y); a y that is not finite, or not positive on a logarithmic axis, interrupts the line.
    pub points: Vec<[f64; 2]>,
    /// Half the height of a band about the line, one number per point.
    pub spread: Option<Vec<f64>>,
    /// Line or signs.
    pub mark: Mark,
    /// Colours that the legend shows beside the name.
    pub swatches: Vec<[u8; 3]>,
    /// The look, in place of the next of the palette.
    pub stroke: Option<Stroke>,
}

impl Curve {
    /// A line through points.
    #[must_use]
    pub fn line(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, ..Self::default() }
    }

    /// Signs at points.
    #[must_use]
    pub fn points(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, mark: Mark::Points, ..Self::default() }
    }
}

/// A chart of curves over common axes, with a legend at its right.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Above the chart.
    pub title: String,
    /// The horizontal axis; its range is that of the data unless given.
    pub x: Axis,
    /// The vertical axis; its range ends on ticks unless given.
    pub y: Axis,
    /// The curves, the first at the bottom.
    pub curves: Vec<Curve>,
    /// Above the legend.
    pub legend: String,
    /// Small print below.
    pub footnote: Option<String>,
    /// Width and height of the plane in px.
    pub size: [f64; 2],
}

impl Figure {
    /// A chart without curves.
    #[must_use]
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            curves: Vec::new(),
            legend: String::new(),
            footnote: None,
            size: SIZE,
        }
    }

    /// Draws the chart.
    #[must_use]
    pub fn draw(&self) -> Drawing {
        let [plane_width, plane_height] = self.size;
        let swatches = self.curves.iter().map(|c| c.swatches.len()).max().unwrap_or(0);
        let sample = 36.0 + SWATCH_STEP * swatches as f64;
        let longest = self
            .named()
            .take(MOST_NAMED)
            .map(|(_, c)| text::width(&c.name, SMALL) + sample)
            .fold(text::width(&self.legend, SMALL), f64::max);
        let has_legend = self.curves.len() > 1 || swatches > 0 || !self.legend.is_empty();
        let legend_width = if has_legend { longest + 24.0 } else { 20.0 };
        let below = if self.footnote.is_some() { 62.0 } else { 46.0 };
        let (left, top) = (64.0, if self.title.is_empty() { 16.0 } else { 34.0 });
        let title_width = 2.0 * (text::width(&self.title, LARGE) / 2.0 - plane_width / 2.0);
        let note_width = self.footnote.as_ref().map_or(0.0, |note| text::width(note, SMALL));
        let width = (left + plane_width + legend_width.max(title_width)).max(left + note_width + 16.0);
        let mut drawing = Drawing::new(width.ceil(), top + plane_height + below);
        let frame = self.frame([left, top, plane_width, plane_height]);
        frame.grid(&mut drawing);
        let mut items = Vec::new();
        for (i, curve) in self.curves.iter().enumerate() {
            band(&mut items, &frame, curve, &self.stroke(i));
        }
        for (i, curve) in self.curves.iter().enumerate() {
            trace(&mut items, &frame, curve, &self.stroke(i), i);
        }
        drawing.items.push(Item::Clip { area: frame.area, items });
        frame.outline(&mut drawing, &self.x.label, &self.y.label, &self.title);
        if has_legend {
            self.legend_at(&mut drawing, [left + plane_width + 14.0, top + 10.0], sample);
        }
        if let Some(note) = &self.footnote {
            drawing.text([left, top + plane_height + 54.0], SMALL, Anchor::Start, note.clone());
        }
        drawing
    }

    /// The curves of the legend with their places.
    fn named(&self) -> impl Iterator<Item = (usize, &Curve)> {
        self.curves.iter().enumerate().filter(|(_, curve)| !curve.name.is_empty())
    }

    fn stroke(&self, i: usize) -> Stroke {
        self.curves[i].stroke.clone().unwrap_or_else(|| palette::style(i))
    }

    fn frame(&self, area: [f64; 4]) -> Frame {
        let shows = |x: &f64| x.is_finite() && (*x > 0.0 || !self.x.logarithmic);
        let xs = self.curves.iter().flat_map(|c| c.points.iter().map(|p| p[0])).filter(shows);
        let (low, high) = xs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let x = match self.x.range {
            Some(range) => range,
            None if low < high => [low, high],
            None if low == high && self.x.logarithmic => [0.5 * low, 2.0 * low],
            None if low == high => [low - 1.0, low + 1.0],
            None if self.x.logarithmic => [1.0, 10.0],
            None => [0.0, 1.0],
        };
        let ys = self.curves.iter().flat_map(|curve| {
            curve.points.iter().enumerate().flat_map(move |(i, p)| {
                let spread = curve.spread.as_ref().and_then(|s| s.get(i)).copied().unwrap_or(0.0);
                [p[1] - spread, p[1] + spread]
            })
        });
        let logarithmic = [self.x.logarithmic, self.y.logarithmic];
        let y = self.y.range.unwrap_or_else(|| if logarithmic[1] { log_covering(ys) } else { covering(ys) });
        Frame { area, x, y, logarithmic }
    }

    fn legend_at(&self, drawing: &mut Drawing, [x, mut y]: [f64; 2], sample: f64) {
        if !self.legend.is_empty() {
            drawing.text([x, y], SMALL, Anchor::Start, self.legend.clone());
            y += 18.0;
        }
        for (i, curve) in self.named().take(MOST_NAMED) {
            let stroke = self.stroke(i);
            if curve.mark != Mark::Line {
                drawing.items.push(sign([x + 14.0, y - 4.0], i, &stroke));
            }
            if curve.mark != Mark::Points {
                drawing.line([x, y - 4.0], [x + 28.0, y - 4.0], stroke);
            }
            for (k, rgb) in curve.swatches.iter().enumerate() {
                let edge = Some(Stroke::solid(Ink::of([120, 120, 120]), 0.7));
                let left = x + 34.0 + SWATCH_STEP * k as f64;
                drawing.rectangle([left, y - 11.0, 14.0, 14.0], Some(Ink::of(*rgb)), edge);
            }
            drawing.text([x + sample, y], SMALL, Anchor::Start, curve.name.clone());
            y += 17.0;
        }
        let named = self.named().count();
        if named > MOST_NAMED {
            let more = format!("and {} more", named - MOST_NAMED);
            drawing.text([x, y], MEDIUM, Anchor::Start, more);
        }
    }
}

fn band(items: &mut Vec<Item>, frame: &Frame, curve: &Curve, stroke: &Stroke) {
    let Some(spread) = &curve.spread else { return };
    let known: Vec<_> = curve
        .points
        .iter()
        .zip(spread)
        .filter(|(p, s)| p[0].is_finite() && (p[1] + **s).is_finite())
        .collect();
    let upper = known.iter().map(|(p, s)| frame.place([p[0], p[1] + **s]));
    let lower = known.iter().rev().map(|(p, s)| frame.place([p[0], p[1] - **s]));
    let fill = Some(stroke.ink.with_opacity(0.18));
    items.push(Item::Path { runs: vec![upper.chain(lower).collect()], closed: true, fill, stroke: None });
}

fn trace(items: &mut Vec<Item>, frame: &Frame, curve: &Curve, stroke: &Stroke, i: usize) {
    let finite = |p: &[f64; 2]| frame.place(*p).iter().all(|at| at.is_finite());
    if curve.mark != Mark::Line {
        items.extend(curve.points.iter().filter(|p| finite(p)).map(|p| sign(frame.place(*p), i, stroke)));
    }
    if curve.mark == Mark::Points {
        return;
    }
    let mut runs = Vec::new();
    for run in curve.points.split(|p| !finite(p)).filter(|run| !run.is_empty()) {
        let placed: Vec<_> = run.iter().map(|p| frame.place(*p)).collect();
        match placed[..] {
            [alone] => items.push(sign(alone, i, stroke)),
            _ => runs.push(placed),
        }
    }
    items.push(Item::Path { runs, closed: false, fill: None, stroke: Some(stroke.clone()) });
}

/// A sign whose shape belongs to curve `i`.
fn sign([x, y]: [f64; 2], i: usize, stroke: &Stroke) -> Item {
    let r = 3.2;
    let polygon = |points: &[[f64; 2]]| Item::Path {
        runs: vec![points.iter().map(|[a, b]| [x + a * r, y + b * r]).collect()],
        closed: true,
        fill: Some(stroke.ink),
        stroke: None,
    };
    match i % 4 {
        0 => Item::Circle { center: [x, y], radius: r, fill: Some(stroke.ink), stroke: None },
        1 => polygon(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
        2 => polygon(&[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]]),
        _ => polygon(&[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Format;

    #[test]
    fn axes_say_quantity_and_unit_and_curves_are_named() {
        let mut figure = Figure::new("film", Axis::new("wavelength (nm)"), Axis::new("reflectance"));
        figure
            .curves
            .push(Curve::line("0°", vec![[400.0, 0.1], [500.0, f64::NAN], [600.0, 0.3], [700.0, 0.2]]));
        figure.curves.push(Curve::points("measured", vec![[400.0, 0.1]]));
        let svg = String::from_utf8(figure.draw().encode(Format::Svg, &[]).unwrap()).unwrap();
        for part in ["wavelength (nm)", "reflectance", "0°", "measured", ">400<", ">700<"] {
            assert!(svg.contains(part), "{part}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn logarithmic_charts_leave_out_what_is_not_positive() {
        let mut figure = Figure::new("", Axis::logarithmic("N"), Axis::logarithmic("error"));
        let points = vec![[0.0, 1.0], [50.0, 1e-3], [100.0, 0.0], [200.0, 1e-5]];
        figure.curves.push(Curve { mark: Mark::Both, ..Curve::line("one", points) });
        let svg = String::from_utf8(figure.draw().encode(Format::Svg, &[]).unwrap()).unwrap();
        assert!(svg.contains(">1e−4<") && !svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn empty_and_single_point_charts_are_drawn() {
        let mut figure = Figure::new("", Axis::new("x"), Axis::new("y"));
        figure.draw().encode(Format::Png, &[]).unwrap();
        figure.curves.push(Curve::line("one", vec![[500.0, 0.0]]));
        let svg = String::from_utf8(figure.draw().encode(Format::Svg, &[]).unwrap()).unwrap();
        assert!(svg.contains("<circle") && !svg.contains("NaN"));
    }
}
