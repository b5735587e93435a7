//! What the curves of a chart are, beside it or below.

use super::axes::SMALL;
use super::drawing::{Anchor, Drawing, Ink, Stroke};
use super::figure::{Curve, Figure, Mark, sign};
use super::text;

/// Curves that a legend names; more are counted.
const MOST_NAMED: usize = 18;
/// From one swatch to the next, px.
const SWATCH_STEP: f64 = 20.0;
/// From one line to the next, and what a line of the heading takes, px.
const LINE: f64 = 17.0;
const HEADING: f64 = 18.0;
/// A heading that is no wider is not broken, px.
const NARROW_HEADING: f64 = 150.0;
/// The largest part of a page's width that a legend beside the plane takes, and of its height one below.
const LARGEST: [f64; 2] = [0.4, 0.35];
/// What is kept free beside the columns of a legend below, px.
const EDGES: f64 = 32.0;
/// Height of the words around a plane, about, px.
const AROUND: f64 = 80.0;

/// The legend of a chart and where it stands.
pub(super) struct Legend {
    heading: Vec<String>,
    /// The first named curves by their places, with names short enough for their column.
    names: Vec<(usize, String)>,
    /// How many curves are not named.
    more: usize,
    /// Width of the lines and signs before the names.
    sample: f64,
    /// 0 beside the plane, else how many names stand abreast below it.
    columns: usize,
}

impl Legend {
    /// The legend of a chart on a page of this size: beside the plane where there is room, else below.
    pub(super) fn of(figure: &Figure, size: Option<[f64; 2]>) -> Self {
        let swatches = figure.curves.iter().map(|c| c.swatches.len()).max().unwrap_or(0);
        let wanted = figure.curves.len() > 1 || swatches > 0 || !figure.legend.is_empty();
        let most = if wanted { MOST_NAMED } else { 0 };
        let names: Vec<_> = figure.named().take(most).map(|(i, curve)| (i, curve.name.clone())).collect();
        let mut legend = Self {
            heading: Vec::new(),
            more: if wanted { figure.named().count() - names.len() } else { 0 },
            names,
            sample: 36.0 + SWATCH_STEP * swatches as f64,
            columns: 0,
        };
        legend.heading =
            text::wrapped(&figure.legend, SMALL, (legend.widest() + legend.sample).max(NARROW_HEADING), 3);
        let Some([width, height]) = size.filter(|_| wanted) else { return legend };
        if legend.width() > LARGEST[0] * width || legend.height() > height - AROUND {
            legend.put_below(&figure.legend, [width, height]);
        }
        legend
    }

    /// Stands below the plane, with as many names as leave room for it.
    fn put_below(&mut self, heading: &str, [width, height]: [f64; 2]) {
        let free = (width - EDGES).max(self.sample + 20.0);
        self.columns =
            ((free / (self.widest() + self.sample + 14.0)) as usize).clamp(1, self.names.len().max(1));
        let room = free / self.columns as f64 - self.sample - 4.0;
        for (_, name) in &mut self.names {
            *name = text::cut(name, SMALL, room);
        }
        self.heading = text::wrapped(heading, SMALL, free, 2);
        while self.height() > LARGEST[1] * height && self.names.len() > 1 {
            self.names.pop();
            self.more += 1;
        }
    }

    /// Whether it stands beside the plane.
    pub(super) fn is_beside(&self) -> bool {
        self.columns == 0
    }

    fn widest(&self) -> f64 {
        self.names.iter().map(|(_, name)| text::width(name, SMALL)).fold(0.0, f64::max)
    }

    /// Its width beside the plane, with the space before it, px.
    pub(super) fn width(&self) -> f64 {
        if self.names.is_empty() && self.heading.is_empty() {
            return 20.0;
        }
        let heading = self.heading.iter().map(|line| text::width(line, SMALL)).fold(0.0, f64::max);
        (self.widest() + self.sample).max(heading) + 24.0
    }

    /// Its height, px.
    pub(super) fn height(&self) -> f64 {
        let heading = HEADING * self.heading.len() as f64;
        let lines = (self.names.len() + usize::from(self.more > 0)).div_ceil(self.columns.max(1));
        heading + LINE * lines as f64
    }

    /// Draws it; the first line of words stands on `at`.
    pub(super) fn draw(&self, drawing: &mut Drawing, figure: &Figure, [left, mut top]: [f64; 2]) {
        for line in &self.heading {
            drawing.text([left, top], SMALL, Anchor::Start, line.clone());
            top += HEADING;
        }
        let columns = self.columns.max(1);
        let apart = (drawing.width - EDGES) / columns as f64;
        let place = |i: usize| [left + apart * (i % columns) as f64, top + LINE * (i / columns) as f64];
        for (k, (i, name)) in self.names.iter().enumerate() {
            let at @ [x, y] = place(k);
            sample(drawing, &figure.curves[*i], &figure.stroke(*i), *i, at);
            drawing.text([x + self.sample, y], SMALL, Anchor::Start, name.clone());
        }
        if self.more > 0 {
            let words = format!("and {} more", self.more);
            drawing.text(place(self.names.len()), SMALL, Anchor::Start, words);
        }
    }
}

/// What curve `i` looks like, and its colours.
fn sample(drawing: &mut Drawing, curve: &Curve, stroke: &Stroke, i: usize, [x, y]: [f64; 2]) {
    if curve.mark != Mark::Line {
        drawing.items.push(sign([x + 14.0, y - 4.0], i, stroke));
    }
    if curve.mark != Mark::Points {
        drawing.line([x, y - 4.0], [x + 28.0, y - 4.0], stroke.clone());
    }
    for (k, rgb) in curve.swatches.iter().enumerate() {
        let edge = Some(Stroke::solid(Ink::of([120, 120, 120]), 0.7));
        let left = x + 34.0 + SWATCH_STEP * k as f64;
        drawing.rectangle([left, y - 11.0, 14.0, 14.0], Some(Ink::of(*rgb)), edge);
    }
}
