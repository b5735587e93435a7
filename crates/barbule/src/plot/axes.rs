//! Axes: ranges, ticks, and the frame around data.

use super::drawing::{Anchor, Drawing, Ink, Item, Stroke};

/// Height of tick labels in px.
pub(super) const SMALL: f64 = 11.0;
/// Height of axis labels in px.
pub(super) const MEDIUM: f64 = 12.5;
/// Height of titles in px.
pub(super) const LARGE: f64 = 14.0;

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
    let step = step(range, wanted);
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

/// As [`ticks`] for a logarithmic axis: powers of ten, or where these are few 2 and 5 times them too.
fn log_ticks(range: [f64; 2], wanted: usize) -> Vec<(f64, String)> {
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

/// A range that covers all `values` and ends on ticks; from 0 when they are positive and reach far towards it.
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
    [(low / step + 1e-6).floor() * step, (high / step - 1e-6).ceil() * step]
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

    /// The box, ticks and labels, to be drawn above the data.
    pub(super) fn outline(&self, drawing: &mut Drawing, x_label: &str, y_label: &str, title: &str) {
        let [left, top, width, height] = self.area;
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
        drawing.text([left + width / 2.0, top + height + 35.0], MEDIUM, Anchor::Middle, x_label);
        drawing.items.push(Item::Text {
            at: [left - 46.0, top + height / 2.0],
            size: MEDIUM,
            text: y_label.to_owned(),
            anchor: Anchor::Middle,
            turn: 90.0,
            ink: Ink::BLACK,
        });
        drawing.text([left + width / 2.0, top - 10.0], LARGE, Anchor::Middle, title);
    }

    fn x_ticks(&self) -> Vec<(f64, String)> {
        let wanted = (self.area[2] / 60.0) as usize;
        if self.logarithmic[0] { log_ticks(self.x, wanted) } else { ticks(self.x, wanted) }
    }

    fn y_ticks(&self) -> Vec<(f64, String)> {
        let wanted = ((self.area[3] / 45.0) as usize).max(5);
        if self.logarithmic[1] { log_ticks(self.y, wanted) } else { ticks(self.y, wanted) }
    }
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
        assert_eq!(labels([1e-12, 1.0], 5).len(), 5);
        assert_eq!(log_covering([0.0, 3e-4, f64::NAN, 0.02].into_iter()), [1e-4, 0.1]);
        assert_eq!(log_covering([10.0].into_iter()), [10.0, 100.0]);
        assert_eq!(log_covering([-1.0].into_iter()), [1.0, 10.0]);
        let frame = Frame {
            area: [0.0, 0.0, 100.0, 100.0],
            x: [1.0, 100.0],
            y: [1.0, 100.0],
            logarithmic: [true; 2],
        };
        assert_eq!(frame.place([10.0, 100.0]), [50.0, 0.0]);
        assert!(!frame.place([0.0, 1.0])[0].is_finite());
    }

    #[test]
    fn ranges_cover_the_data_and_end_on_ticks() {
        let of = |v: &[f64]| covering(v.iter().copied());
        assert_eq!(of(&[0.03, 0.41]), [0.0, 0.5]);
        assert_eq!(of(&[]), [0.0, 1.0]);
        assert_eq!(of(&[f64::NAN]), [0.0, 1.0]);
        let flat = of(&[1.0, 1.0]);
        assert!(flat[0] < 1.0 && flat[1] > 1.0);
        let zero = of(&[0.0, 0.0]);
        assert!(zero[0] < 0.0 && zero[1] > 0.0);
    }
}
