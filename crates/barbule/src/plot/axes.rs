//! Axes: ranges, ticks, and the frame around data.

use super::drawing::{Anchor, Drawing, Ink, Item, Stroke};
use super::text;

/// Height of tick labels in px.
pub(super) const SMALL: f64 = 11.0;
/// Height of axis labels in px.
pub(super) const MEDIUM: f64 = super::page::USUAL_FONT;
/// Height of titles in px.
pub(super) const LARGE: f64 = super::page::TITLE;

/// From one line of a title or an axis label to the next, px.
const LINE: f64 = 17.0;
/// Lines of titles and of axis labels at most.
const MOST_LINES: [usize; 2] = [3, 2];
/// What titles keep free of a page's edges, px.
const EDGE: f64 = 8.0;

const GREY: Ink = Ink::of([225, 225, 225]);

/// What an axis says and covers.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit, for example `wavelength (nm)`.
    pub label: String,
    /// Exactly what is drawn, or from the data.
    pub range: Option<[f64; 2]>,
    /// Whether equal ratios are equally long; only positive values then show.
    pub logarithmic: bool,
}

impl Axis {
    /// An axis whose range follows from the data.
    #[must_use]
    pub fn new(label: impl Into<String>) -> Self {
        Self { label: label.into(), range: None, logarithmic: false }
    }

    /// An axis with an exact range.
    #[must_use]
    pub fn with_range(label: impl Into<String>, from: f64, to: f64) -> Self {
        Self { range: Some([from, to]), ..Self::new(label) }
    }

    /// A logarithmic axis whose range follows from the data.
    #[must_use]
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { logarithmic: true, ..Self::new(label) }
    }
}

/// Steps between ticks of angles in degrees.
const DEGREES: [f64; 4] = [15.0, 30.0, 45.0, 90.0];

/// The distance between ticks: 1, 2 or 5 times a power of ten, so that about `wanted` of them fit.
fn step(range: [f64; 2], wanted: usize) -> f64 {
    let rough = (range[1] - range[0]).abs() / wanted.max(1) as f64;
    let decade = 10.0_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|f| f * decade >= rough * 0.999).unwrap_or(10.0);
    factor * decade
}

/// Round numbers within a range, about `wanted` of them, with their labels.
#[must_use]
pub fn ticks(range: [f64; 2], wanted: usize) -> Vec<(f64, String)> {
    let (low, high) = (range[0].min(range[1]), range[0].max(range[1]));
    if !(high > low && (high - low).is_finite()) {
        return vec![(low, label(low, 1e-3))];
    }
    multiples([low, high], step(range, wanted))
}

/// As [`ticks`] for angles in degrees: parts of the right angle where the range is of several.
fn degree_ticks(range: [f64; 2], wanted: usize) -> Vec<(f64, String)> {
    let (low, high) = (range[0].min(range[1]), range[0].max(range[1]));
    let rough = (high - low) / wanted.max(1) as f64;
    match DEGREES.into_iter().find(|step| *step >= rough * 0.999) {
        Some(step) if rough > 0.5 * DEGREES[0] => multiples([low, high], step),
        _ => ticks(range, wanted),
    }
}

/// The multiples of a step within a range, with their labels.
fn multiples([low, high]: [f64; 2], step: f64) -> Vec<(f64, String)> {
    let first = (low / step - 1e-6).ceil();
    let last = (high / step + 1e-6).floor();
    // At most a few dozen by the choice of the step; the bound guards against ranges at the limits of f64.
    let count = ((last - first) as usize).min(100);
    (0..=count)
        .map(|i| (first + i as f64) * step)
        .filter(|at| *at >= low - 1e-6 * step && *at <= high + 1e-6 * step)
        .map(|at| (at, label(at, step)))
        .collect()
}

/// As [`ticks`] for a logarithmic axis: powers of ten, or where these are few 2 and 5 times them too, or round numbers where not
/// two of these are within the range.
fn log_ticks(range: [f64; 2], wanted: usize) -> Vec<(f64, String)> {
    let found = decade_ticks(range, wanted);
    if found.len() < 2 { ticks(range, wanted) } else { found }
}

fn decade_ticks(range: [f64; 2], wanted: usize) -> Vec<(f64, String)> {
    let [low, high] = [range[0].min(range[1]), range[0].max(range[1])].map(f64::log10);
    if !(high > low && (high - low).is_finite()) {
        return ticks(range, wanted);
    }
    let factors: &[f64] = if high - low < 2.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let every = ((high - low) / wanted.max(1) as f64).ceil().max(1.0) as usize;
    (low.floor() as i32..=high.ceil() as i32)
        .step_by(every)
        .flat_map(|decade| factors.iter().map(move |factor| factor * 10.0_f64.powi(decade)))
        .filter(|at| (low - 1e-6..=high + 1e-6).contains(&at.log10()))
        .map(|at| {
            let plain = (1e-2..1e5).contains(&at);
            (at, if plain { label(at, at) } else { format!("{at:.0e}").replace('-', "−") })
        })
        .collect()
}

fn label(value: f64, step: f64) -> String {
    let value = if value.abs() < step * 1e-6 { 0.0 } else { value };
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.1e}").replace('-', "−");
    }
    let decimals = (-step.log10().floor()).clamp(0.0, 8.0) as usize;
    format!("{value:.decimals$}").replace('-', "−")
}

/// Values below zero by less than this part of a tick's step begin the axis themselves, and not the next tick: most of the
/// step would be empty.
const LITTLE_BELOW: f64 = 0.25;

/// A range that covers all `values` and ends on ticks; from 0 when they are positive and reach far towards it, and from the
/// lowest of them where they reach a little below.
pub(super) fn covering(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|v| v.is_finite()) {
        low = low.min(value);
        high = high.max(value);
    }
    if low > high {
        return [0.0, 1.0];
    }
    if low >= 0.0 && low < 0.6 * high {
        low = 0.0;
    }
    // Rounding noise about a constant is no variation.
    if high - low <= 1e-12 * high.abs().max(1e-12) {
        let half = if high == 0.0 { 0.5 } else { 0.1 * high.abs() };
        (low, high) = (low - half, high + half);
    }
    let step = step([low, high], 5);
    let little = low < -1e-6 * step && low > -LITTLE_BELOW * step && high > 0.0;
    let from = if little { 1.2 * low } else { (low / step + 1e-6).floor() * step };
    [from, (high / step - 1e-6).ceil() * step]
}

/// As [`covering`] for a logarithmic axis: whole powers of ten about the positive values.
pub(super) fn log_covering(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values
        .filter(|v| v.is_finite() && *v > 0.0)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), v| {
            (low.min(v.log10()), high.max(v.log10()))
        });
    if low.is_infinite() {
        return [1.0, 10.0];
    }
    let (low, high) = ((low + 1e-6).floor(), (high - 1e-6).ceil());
    [low, high.max(low + 1.0)].map(|decade| 10.0_f64.powf(decade))
}

/// A rectangle of the page and what it shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// x, y, width, height on the page.
    pub(super) area: [f64; 4],
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
    /// Whether x and y are logarithmic.
    pub(super) logarithmic: [bool; 2],
    /// Whether x and y are angles in degrees.
    pub(super) degrees: [bool; 2],
}

impl Frame {
    /// A point of the data on the page; not finite where a logarithm is not.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, width, height] = self.area;
        let part = |v: f64, range: [f64; 2], logarithmic: bool| {
            let [v, from, to] = [v, range[0], range[1]].map(|v| if logarithmic { v.log10() } else { v });
            (v - from) / (to - from)
        };
        let [log_x, log_y] = self.logarithmic;
        [left + width * part(x, self.x, log_x), top + height * (1.0 - part(y, self.y, log_y))]
    }

    /// Grid lines, to be drawn below the data.
    pub(super) fn grid(&self, drawing: &mut Drawing) {
        let [left, top, width, height] = self.area;
        let line = Stroke::solid(GREY, 0.7);
        for (at, _) in self.x_ticks() {
            let [x, _] = self.place([at, self.y[0]]);
            drawing.line([x, top], [x, top + height], line.clone());
        }
        for (at, _) in self.y_ticks() {
            let [_, y] = self.place([self.x[0], at]);
            drawing.line([left, y], [left + width, y], line.clone());
        }
    }

    /// The box and ticks, to be drawn above the data.
    pub(super) fn outline(&self, drawing: &mut Drawing) {
        let [left, top, _, height] = self.area;
        let line = Stroke::solid(Ink::BLACK, 1.0);
        drawing.rectangle(self.area, None, Some(line.clone()));
        for (at, text) in self.x_ticks() {
            let [x, _] = self.place([at, self.y[0]]);
            drawing.line([x, top + height], [x, top + height + 4.0], line.clone());
            drawing.text([x, top + height + 16.0], SMALL, Anchor::Middle, text);
        }
        for (at, text) in self.y_ticks() {
            let [_, y] = self.place([self.x[0], at]);
            drawing.line([left - 4.0, y], [left, y], line.clone());
            drawing.text([left - 7.0, y + 4.0], SMALL, Anchor::End, text);
        }
    }

    /// As many ticks as leave their labels apart.
    fn x_ticks(&self) -> Vec<(f64, String)> {
        let width = self.area[2];
        let apart = |ticks: &[(f64, String)]| {
            ticks.iter().map(|(_, label)| text::width(label, SMALL) + 8.0).sum::<f64>() <= width + 30.0
        };
        spaced(|wanted| self.ticks(0, wanted), (width / 60.0) as usize, apart)
    }

    fn y_ticks(&self) -> Vec<(f64, String)> {
        let height = self.area[3];
        spaced(
            |wanted| self.ticks(1, wanted),
            ((height / 45.0) as usize).max(5),
            |ticks| high_enough(ticks, height),
        )
    }

    /// About `wanted` ticks of x (`axis` 0) or y (1).
    fn ticks(&self, axis: usize, wanted: usize) -> Vec<(f64, String)> {
        let range = [self.x, self.y][axis];
        match (self.logarithmic[axis], self.degrees[axis]) {
            (true, _) => log_ticks(range, wanted),
            (false, true) => degree_ticks(range, wanted),
            (false, false) => ticks(range, wanted),
        }
    }
}

/// Whether labels of ticks stand apart on a vertical axis.
pub(super) fn high_enough(ticks: &[(f64, String)], height: f64) -> bool {
    ticks.len() as f64 * (SMALL + 3.0) <= height + SMALL
}

/// About `wanted` ticks, or fewer where they would not stand apart; two where they can be had at all.
pub(super) fn spaced(
    of: impl Fn(usize) -> Vec<(f64, String)>,
    wanted: usize,
    apart: impl Fn(&[(f64, String)]) -> bool,
) -> Vec<(f64, String)> {
    let fewer = (1..=wanted.max(2)).rev().map(&of).find(|ticks| apart(ticks));
    match fewer {
        Some(ticks) if ticks.len() > 1 => ticks,
        found => {
            let more = (2..=12).map(&of).find(|ticks| ticks.len() > 1 && apart(ticks));
            more.or(found).unwrap_or_else(|| of(1))
        }
    }
}

/// Whether an axis shows degrees.
pub(super) fn is_in_degrees(axis: &Axis) -> bool {
    axis.label.ends_with("(°)")
}

/// The words around a plane, broken into lines that fit.
pub(super) struct Words {
    title: Vec<String>,
    x: Vec<String>,
    y: Vec<String>,
}

impl Words {
    /// Of a page that is `width` px wide; [`Words::beside`] adds the vertical axis.
    pub(super) fn new(title: &str, x: &str, width: f64) -> Self {
        let free = width - 2.0 * EDGE;
        Self {
            title: text::wrapped(title, LARGE, free, MOST_LINES[0]),
            x: text::wrapped(x, MEDIUM, free, MOST_LINES[1]),
            y: Vec::new(),
        }
    }

    /// With the vertical axis's label, of a plane that is `height` px high.
    pub(super) fn beside(mut self, y: &str, height: f64) -> Self {
        self.y = text::wrapped(y, MEDIUM, height + self.top(), MOST_LINES[1]);
        self
    }

    /// What stands above the plane.
    pub(super) fn top(&self) -> f64 {
        16.0 + 18.0 * self.title.len() as f64
    }

    /// What stands below the plane.
    pub(super) fn below(&self) -> f64 {
        46.0 + LINE * self.x.len().saturating_sub(1) as f64
    }

    /// What stands left of the plane, whose axis label is at least `least` px away from it.
    pub(super) fn left(&self, frame: &Frame, least: f64) -> f64 {
        self.label_at(frame, least) + 18.0
    }

    /// From the plane to the last line of the vertical axis's label.
    fn label_at(&self, frame: &Frame, least: f64) -> f64 {
        let widest = frame.y_ticks().iter().map(|(_, t)| text::width(t, SMALL)).fold(0.0, f64::max);
        (widest + 16.0).max(least) + LINE * self.y.len().saturating_sub(1) as f64
    }

    /// Writes them around the plane.
    pub(super) fn write(&self, drawing: &mut Drawing, frame: &Frame, least: f64) {
        let [left, top, width, height] = frame.area;
        for (line, text) in self.x.iter().enumerate() {
            centred(drawing, left + width / 2.0, top + height + 35.0 + LINE * line as f64, MEDIUM, text);
        }
        let label_at = left - self.label_at(frame, least);
        for (line, text) in self.y.iter().enumerate() {
            // A label that is longer than the plane keeps on the page.
            let half = 0.5 * text::width(text, MEDIUM);
            drawing.items.push(Item::Text {
                at: [label_at + LINE * line as f64, (top + height / 2.0).max(half + 2.0)],
                size: MEDIUM,
                text: text.clone(),
                anchor: Anchor::Middle,
                turn: 90.0,
                ink: Ink::BLACK,
            });
        }
        for (line, text) in self.title.iter().rev().enumerate() {
            centred(drawing, left + width / 2.0, top - 10.0 - 18.0 * line as f64, LARGE, text);
        }
    }
}

/// A text centred at an x as far as the page's edges allow.
fn centred(drawing: &mut Drawing, x: f64, y: f64, size: f64, text: &str) {
    let half = 0.5 * text::width(text, size);
    let most = (drawing.width - EDGE - half).max(half);
    drawing.text([x.clamp((EDGE + half).min(most), most), y], size, Anchor::Middle, text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let found = ticks([400.0, 694.0], 6);
        let labels: Vec<_> = found.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(labels, ["400", "450", "500", "550", "600", "650"]);
        assert_eq!(ticks([0.0, 0.3], 3)[1].1, "0.1");
        assert_eq!(ticks([-90.0, 90.0], 4)[0].1, "−50");
        assert!(ticks([1.0, 1.0], 5).len() == 1 && ticks([0.0, f64::INFINITY], 5).len() == 1);
    }

    #[test]
    fn logarithmic_axes_have_decades() {
        let labels =
            |range, wanted| log_ticks(range, wanted).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(labels([1e-4, 1.0], 5), ["1e−4", "1e−3", "0.01", "0.1", "1"]);
        assert_eq!(labels([50.0, 200.0], 5), ["50", "100", "200"]);
        // Neither 20,000 nor 50,000 is within.
        assert_eq!(labels([21_680.0, 35_496.0], 3), ["25000", "30000", "35000"]);
        assert_eq!(labels([1e-12, 1.0], 5).len(), 5);
        assert_eq!(log_covering([0.0, 3e-4, f64::NAN, 0.02].into_iter()), [1e-4, 0.1]);
        assert_eq!(log_covering([10.0].into_iter()), [10.0, 100.0]);
        assert_eq!(log_covering([-1.0].into_iter()), [1.0, 10.0]);
        let frame = Frame {
            area: [0.0, 0.0, 100.0, 100.0],
            x: [1.0, 100.0],
            y: [1.0, 100.0],
            logarithmic: [true; 2],
            degrees: [false; 2],
        };
        assert_eq!(frame.place([10.0, 100.0]), [50.0, 0.0]);
        assert!(!frame.place([0.0, 1.0])[0].is_finite());
    }

    #[test]
    fn angles_have_parts_of_the_right_angle_and_small_planes_at_least_two_ticks() {
        let labels =
            |range, wanted| degree_ticks(range, wanted).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(labels([-90.0, 90.0], 5), ["−90", "−45", "0", "45", "90"]);
        assert_eq!(labels([-90.0, 90.0], 6), ["−90", "−60", "−30", "0", "30", "60", "90"]);
        assert_eq!(labels([0.0, 10.0], 5), ["0", "2", "4", "6", "8", "10"]);
        let of = |wanted| ticks([0.0, 0.96], wanted);
        let found = |height| spaced(of, 5, |ticks| high_enough(ticks, height));
        assert_eq!(found(200.0).len(), 5);
        let labels: Vec<_> = found(30.0).into_iter().map(|(_, text)| text).collect();
        assert_eq!(labels, ["0.0", "0.5"]);
    }

    #[test]
    fn ranges_cover_the_data_and_end_on_ticks() {
        let of = |v: &[f64]| covering(v.iter().copied());
        assert_eq!(of(&[0.03, 0.41]), [0.0, 0.5]);
        assert_eq!(of(&[]), [0.0, 1.0]);
        assert_eq!(of(&[f64::NAN]), [0.0, 1.0]);
        // A little below zero takes no whole step, much does.
        let [from, to] = of(&[-0.004, 0.36]);
        assert!((-0.006..-0.004).contains(&from) && (to - 0.4).abs() < 1e-12, "{from} {to}");
        assert_eq!(of(&[-0.04, 0.36])[0], -0.1);
        assert_eq!(of(&[-1e-12, 0.36])[0], 0.0);
        let flat = of(&[1.0, 1.0]);
        assert!(flat[0] < 1.0 && flat[1] > 1.0);
        let zero = of(&[0.0, 0.0]);
        assert!(zero[0] < 0.0 && zero[1] > 0.0);
    }
}
