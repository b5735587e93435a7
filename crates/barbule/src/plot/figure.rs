//! Line charts.

use super::axes::{Axis, Frame, MEDIUM, SMALL, Words, covering, is_in_degrees, log_covering};
use super::drawing::{Anchor, Drawing, Ink, Item, Stroke};
use super::legend::Legend;
use super::{Page, palette, text};

/// Usual width and height of the plotted area in px.
const SIZE: [f64; 2] = [520.0, 330.0];
/// The distance of the vertical axis's label from the plane where there is room, px: charts in a column have common edges.
const LABEL_AT: f64 = 46.0;
/// The least width and height of the plane in px; on smaller pages everything is smaller.
const LEAST: [f64; 2] = [70.0, 50.0];
/// From one line of small print to the next, px.
const NOTE_LINE: f64 = 16.0;

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
    /// A range of x that is hatched: what is drawn there is doubtful.
    pub hatched: Option<[f64; 2]>,
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
            hatched: None,
            size: SIZE,
        }
    }

    /// Draws the chart as large as its plane asks for.
    #[must_use]
    pub fn draw(&self) -> Drawing {
        self.draw_on(&Page::default())
    }

    /// Draws the chart on a page.
    #[must_use]
    pub fn draw_on(&self, page: &Page) -> Drawing {
        page.lay_out(MEDIUM, |size| self.lay_out(size))
    }

    fn lay_out(&self, size: Option<[f64; 2]>) -> Drawing {
        let legend = Legend::of(self, size);
        let least = if size.is_some() { 0.0 } else { LABEL_AT };
        let right = if legend.is_beside() { legend.width() } else { 20.0 };
        let page_width = size.map_or(LABEL_AT + 18.0 + self.size[0] + right, |[width, _]| width);
        let words = Words::new(&self.title, &self.x.label, page_width);
        let note = self.footnote.as_deref().unwrap_or("");
        // Without a page's size notes begin below the plane.
        let indent = if size.is_some() { 0.0 } else { LABEL_AT };
        let note = text::wrapped(note, SMALL, page_width - 32.0 - indent, 4);
        let legend_height = if legend.is_beside() { 0.0 } else { legend.height() };
        let below = words.below() + legend_height + NOTE_LINE * note.len() as f64;
        let plane_height = size.map_or(self.size[1], |[_, h]| (h - words.top() - below).max(LEAST[1]));
        let words = words.beside(&self.y.label, plane_height);
        let top = words.top();
        let left = words.left(&self.frame([0.0, top, self.size[0], plane_height]), least);
        let plane_width = size.map_or(self.size[0], |[w, _]| (w - left - right).max(LEAST[0]));
        let mut drawing = Drawing::new((left + plane_width + right).ceil(), top + plane_height + below);
        let frame = self.frame([left, top, plane_width, plane_height]);
        frame.grid(&mut drawing);
        let mut items = self.hatched.map_or_else(Vec::new, |range| hatching(&frame, range));
        for (i, curve) in self.curves.iter().enumerate() {
            band(&mut items, &frame, curve, &self.stroke(i));
        }
        for (i, curve) in self.curves.iter().enumerate() {
            trace(&mut items, &frame, curve, &self.stroke(i), i);
        }
        drawing.items.push(Item::Clip { area: frame.area, items });
        frame.outline(&mut drawing);
        words.write(&mut drawing, &frame, least);
        let under = top + plane_height + words.below();
        if legend.is_beside() {
            legend.draw(&mut drawing, self, [left + plane_width + 14.0, top + 10.0]);
        } else {
            legend.draw(&mut drawing, self, [16.0, under + 6.0]);
        }
        for (line, text) in note.into_iter().enumerate() {
            let y = under + legend_height + 8.0 + NOTE_LINE * line as f64;
            drawing.text([if size.is_some() { 16.0 } else { left }, y], SMALL, Anchor::Start, text);
        }
        drawing
    }

    /// The curves of the legend with their places.
    pub(super) fn named(&self) -> impl Iterator<Item = (usize, &Curve)> {
        self.curves.iter().enumerate().filter(|(_, curve)| !curve.name.is_empty())
    }

    /// The look of curve `i`.
    pub(super) fn stroke(&self, i: usize) -> Stroke {
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
        Frame { area, x, y, logarithmic, degrees: [&self.x, &self.y].map(is_in_degrees) }
    }
}

/// From one line of a hatching to the next, px.
const HATCH: f64 = 7.0;

/// Slanting lines over a range of x.
fn hatching(frame: &Frame, range: [f64; 2]) -> Vec<Item> {
    let [_, top, _, height] = frame.area;
    let [left, right] = range.map(|x| frame.place([x.clamp(frame.x[0], frame.x[1]), frame.y[0]])[0]);
    if right - left < 1.0 {
        return Vec::new();
    }
    let stroke = Stroke::solid(Ink::of([150, 150, 150]), 0.7);
    let count = ((right - left + height) / HATCH) as usize;
    let from = |i: usize| left - height + HATCH * i as f64;
    let runs = (0..=count).map(|i| vec![[from(i), top + height], [from(i) + height, top]]).collect();
    let lines = Item::Path { runs, closed: false, fill: None, stroke: Some(stroke) };
    vec![Item::Clip { area: [left, top, right - left, height], items: vec![lines] }]
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
pub(super) fn sign([x, y]: [f64; 2], i: usize, stroke: &Stroke) -> Item {
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
    use crate::plot::places::assert_words_stand_apart;

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
    fn words_of_charts_of_any_size_stand_on_the_page_and_apart() {
        let names = ["0°", "θ_i = 60°, air/6*(melanin:99/keratin:100)/keratin", "measured, mean of 12"];
        for (width, height) in
            [(85.0, 60.0), (60.0, 60.0), (170.0, 110.0), (400.0, 90.0), (180.0, 240.0), (600.0, 400.0)]
        {
            for curves in [1, 3, 8, 40] {
                let mut figure = Figure::new(
                    "air/6*(melanin:99/keratin:100)/keratin, collected within 5° of the mirror direction",
                    Axis::new("wavelength in vacuum (nm)"),
                    Axis::new("reflectance, unpolarized"),
                );
                figure.legend = "mean ± 1 std; colour under D65: true, normalized".into();
                figure.footnote = Some(
                    "below 380 nm and above 780 nm the eye sees nothing; the colour is that of the rest"
                        .into(),
                );
                for i in 0..curves {
                    let points = vec![[300.0, 0.0], [830.0, 1e-5 * f64::from(i + 1)]];
                    figure.curves.push(Curve {
                        swatches: vec![[255, 0, 0], [0, 255, 0]],
                        ..Curve::line(names[i as usize % 3], points)
                    });
                }
                let px = 96.0 / 25.4;
                let drawing = figure.draw_on(&Page::sized(width * px, height * px));
                let what = format!("{width} x {height} mm, {curves} curves");
                assert_words_stand_apart(&drawing, &what);
                assert!(
                    (drawing.width / px - width).abs() < 1e-9 && (drawing.height / px - height).abs() < 1e-9
                );
            }
        }
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
