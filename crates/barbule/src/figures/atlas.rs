//! The map of an atlas: colours over two of its keys, the others as small maps beside each other.

use rayon::prelude::*;

use crate::atlas::Atlas;
use crate::io::Numbers;
use crate::io::sweep::{SweepAxis, SweepStore};
use crate::plot::{Axis, Drawing, HeatMap, Page, abreast};
use crate::{Error, Result};

/// Small maps on one figure, at most.
const MOST_MAPS: usize = 36;

/// Columns or rows of values that are not at equal distances, and of maps of samples.
const FINE: usize = 240;
const SAMPLED: usize = 96;

/// How far steps may differ that count as equal, as a part.
const EQUAL: f64 = 1e-6;

/// Cells without a colour, and places without a cell.
const NO_COLOUR: [u8; 3] = [190; 3];
const NO_CELL: [u8; 3] = [255; 3];

/// The colours of all cells, as bright as a screen can show them.
pub struct AtlasColours {
    /// `[cell][angle]`; none of cells that are not there.
    pub(super) of: Vec<Option<Vec<[u8; 3]>>>,
}

impl AtlasColours {
    /// Refuses an atlas without colours.
    ///
    /// # Errors
    /// The atlas has no colours.
    pub fn check(atlas: &Atlas) -> Result<()> {
        if !atlas.has_colours() {
            return Err(Error::input(
                "the atlas has no colours, since its wavelengths are too few of what the eye sees; give wavelengths_nm from 400 to 700 nm",
            ));
        }
        Ok(())
    }

    /// Reads them from a store.
    ///
    /// # Errors
    /// The atlas has no colours.
    pub fn read(atlas: &Atlas, store: &SweepStore) -> Result<Self> {
        Self::check(atlas)?;
        let black = |values: &Vec<f64>| values.iter().all(|value| *value == 0.0);
        let of = |values: Option<Vec<f64>>| {
            // An empty cell is black in all channels; nothing that reflects is.
            let values = values.filter(|values| !black(values))?;
            Some(values.as_chunks::<3>().0.iter().map(|rgb| rgb.map(|value| value as u8)).collect())
        };
        Ok(Self { of: store.numbers("srgb_normalized")?.into_iter().map(of).collect() })
    }

    /// A cell's colour at an angle, `NO_COLOUR` where it is not there.
    pub(super) fn at(&self, cell: usize, angle: usize) -> [u8; 3] {
        let found = self.of.get(cell).and_then(Option::as_ref).and_then(|colours| colours.get(angle));
        found.copied().unwrap_or(NO_COLOUR)
    }
}

/// One map: the cell and the angle at each place, row by row from the lowest y.
pub(super) struct Panel {
    pub(super) title: String,
    pub(super) x: Span,
    pub(super) y: Span,
    pub(super) cells: Vec<Option<[usize; 2]>>,
}

/// An axis of a map.
#[derive(Clone)]
pub(super) struct Span {
    pub(super) label: String,
    pub(super) range: [f64; 2],
    /// Of each column, or row, the number of the value there.
    pub(super) at: Vec<usize>,
}

/// The maps of an atlas: over its last two keys with more than one value, for every value of the others and every angle; of one key
/// alone over it and the angle.
pub(super) fn panels(atlas: &Atlas) -> Vec<Panel> {
    let layout = atlas.layout();
    if !layout.coordinates.is_empty() {
        return sampled(atlas);
    }
    let axes = &layout.cells;
    let lengths: Vec<usize> = axes.iter().map(|axis| axis.values.len()).collect();
    let long: Vec<usize> =
        (0..axes.len()).filter(|i| lengths[*i] > 1 && axes[*i].labels.is_empty()).collect();
    let x = long.last().copied().unwrap_or(axes.len() - 1);
    let y = long.len().checked_sub(2).map(|at| long[at]);
    let others: Vec<usize> = (0..axes.len()).filter(|i| *i != x && Some(*i) != y).collect();
    let count: usize = others.iter().map(|i| lengths[*i]).product();
    let mut all = Vec::new();
    for number in 0..count {
        let mut place = vec![0; axes.len()];
        let mut rest = number;
        for i in others.iter().rev() {
            place[*i] = rest % lengths[*i];
            rest /= lengths[*i];
        }
        let words = others.iter().filter(|i| lengths[**i] > 1).map(|i| said(&axes[*i], place[*i]));
        let title = words.collect::<Vec<_>>().join(", ");
        let across = span(&axes[x]);
        let cell = |column: usize, row: Option<(usize, usize)>| {
            let mut place = place.clone();
            place[x] = column;
            if let Some((y, row)) = row {
                place[y] = row;
            }
            place.iter().zip(&lengths).fold(0, |cell, (at, length)| cell * length + at)
        };
        let Some(y) = y else {
            let up = angles(atlas);
            let row = |angle: usize| across.at.iter().map(move |column| (*column, angle));
            let places = up.at.iter().flat_map(|angle| row(*angle));
            let cells = places.map(|(column, angle)| Some([cell(column, None), angle])).collect();
            all.push(Panel { title, x: across, y: up, cells });
            continue;
        };
        for angle in 0..atlas.angles_deg().len() {
            let up = span(&axes[y]);
            let row = |row: usize| across.at.iter().map(move |column| (*column, row));
            let places = up.at.iter().flat_map(|at| row(*at));
            let cells = places.map(|(column, row)| Some([cell(column, Some((y, row))), angle])).collect();
            all.push(Panel { title: with_angle(&title, atlas, angle), x: across.clone(), y: up, cells });
        }
    }
    all
}

/// The angles of incidence as an axis; of one angle there is none.
fn angles(atlas: &Atlas) -> Span {
    let values = atlas.angles_deg();
    if values.len() < 2 {
        return Span::none();
    }
    span(&SweepAxis {
        name: "angle of incidence".into(),
        units: "degree".into(),
        meaning: String::new(),
        values: Numbers::Floats(values.to_vec()),
        labels: Vec::new(),
    })
}

/// The maps of samples: at each place along the first two keys the nearest of them, distances measured in parts of the keys' ranges.
fn sampled(atlas: &Atlas) -> Vec<Panel> {
    let layout = atlas.layout();
    let samples = layout.cells.last().map_or(1, |axis| axis.values.len());
    let patches = layout.count() / samples.max(1);
    let keys = &layout.coordinates;
    let of_key = |index: usize| match keys.get(index) {
        Some(key) => {
            let low = key.values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = key.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let range = if low < high { [low, high] } else { [low - 0.5, low + 0.5] };
            Span { label: labelled(&key.name, &key.units), range, at: (0..SAMPLED).collect() }
        }
        None => Span::none(),
    };
    let (x, y) = (of_key(0), of_key(1));
    let parts = |span: &Span, index: usize| -> Vec<f64> {
        let part = |value: f64| (value - span.range[0]) / (span.range[1] - span.range[0]);
        keys.get(index).map_or(vec![0.5; samples], |key| key.values.iter().map(|v| part(*v)).collect())
    };
    let near = nearest(&parts(&x, 0), &parts(&y, 1), x.at.len(), y.at.len());
    let mut all = Vec::new();
    for patch in 0..patches {
        for angle in 0..atlas.angles_deg().len() {
            let cells = near.iter().map(|sample| Some([patch * samples + sample, angle])).collect();
            let name = if patches > 1 { said(&layout.cells[0], patch) } else { String::new() };
            let title = with_angle(&name, atlas, angle);
            all.push(Panel { title, x: x.clone(), y: y.clone(), cells });
        }
    }
    all
}

/// At the middle of each place of a map, row by row from the lowest y, the number of the nearest of some points, which lie between
/// 0 and 1; of equals the first.
fn nearest(x: &[f64], y: &[f64], columns: usize, rows: usize) -> Vec<usize> {
    let middle = |place: usize, count: usize| (place as f64 + 0.5) / count as f64;
    let one = |place: usize| {
        let at = [middle(place % columns, columns), middle(place / columns, rows)];
        let distance = |point: &usize| (x[*point] - at[0]).powi(2) + (y[*point] - at[1]).powi(2);
        (0..x.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    };
    (0..columns * rows).into_par_iter().map(one).collect()
}

/// A map's title with its angle, where there are several.
fn with_angle(title: &str, atlas: &Atlas, angle: usize) -> String {
    if atlas.angles_deg().len() < 2 {
        return title.to_owned();
    }
    let angle = format!("{}°", atlas.angles_deg()[angle]);
    if title.is_empty() { angle } else { format!("{title}, {angle}") }
}

/// The value of an axis in words.
fn said(axis: &SweepAxis, at: usize) -> String {
    match axis.labels.get(at) {
        Some(label) => label.clone(),
        None => format!("{} {}", axis.name, numbers(axis)[at]),
    }
}

fn numbers(axis: &SweepAxis) -> Vec<f64> {
    match &axis.values {
        Numbers::Floats(values) => values.clone(),
        Numbers::Counts(counts) => counts.iter().map(|count| *count as f64).collect(),
    }
}

/// `cortex (µm)` of the key `cortex_um`.
fn labelled(name: &str, units: &str) -> String {
    let plain = |end: &str| name.strip_suffix(end).unwrap_or(name).replace('_', " ");
    match units {
        "um" => format!("{} (µm)", plain("_um")),
        "degree" => format!("{} (°)", plain("_deg")),
        "" => plain(""),
        units => format!("{} ({units})", plain(&format!("_{units}"))),
    }
}

impl Span {
    /// What there is no axis of.
    fn none() -> Self {
        Self { label: String::new(), range: [0.0, 1.0], at: vec![0] }
    }
}

/// An axis with its cells' edges half-way between values: as many places as values where these are at equal distances, else so
/// many that each value has its share.
fn span(axis: &SweepAxis) -> Span {
    let values = numbers(axis);
    let label = labelled(&axis.name, &axis.units);
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let sorted: Vec<f64> = order.iter().map(|i| values[*i]).collect();
    let [first, .., last] = sorted[..] else {
        let value = sorted.first().copied().unwrap_or(0.0);
        return Span { label, range: [value - 0.5, value + 0.5], at: order };
    };
    let steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (low, high) = (first - 0.5 * steps[0], last + 0.5 * steps[steps.len() - 1]);
    let mean = (last - first) / steps.len() as f64;
    if steps.iter().all(|step| (step - mean).abs() <= EQUAL * mean) {
        return Span { label, range: [low, high], at: order };
    }
    let place = |i: usize| {
        let value = low + (i as f64 + 0.5) / FINE as f64 * (high - low);
        order[sorted.windows(2).filter(|pair| 0.5 * (pair[0] + pair[1]) <= value).count()]
    };
    Span { label, range: [low, high], at: (0..FINE).map(place).collect() }
}

/// Draws the map on a page; of very many small maps the first.
///
/// # Errors
/// The atlas has no cell.
pub fn atlas_map(title: &str, atlas: &Atlas, colours: &AtlasColours, page: &Page) -> Result<Drawing> {
    let panels = panels(atlas);
    let count = panels.len();
    let map = |panel: &Panel| {
        let colour = |at: &Option<[usize; 2]>| at.map_or(NO_CELL, |[cell, angle]| colours.at(cell, angle));
        let axis = |span: &Span| Axis::with_range(span.label.clone(), span.range[0], span.range[1]);
        let title = if count == 1 { title.to_owned() } else { panel.title.clone() };
        let all = panel.cells.iter().map(colour).collect();
        HeatMap::of_colours(title, axis(&panel.x), axis(&panel.y), panel.x.at.len(), all)
    };
    let maps: Vec<HeatMap> = panels.iter().take(MOST_MAPS).map(map).collect();
    match &maps[..] {
        [] => Err(Error::input("the atlas has no cell to draw")),
        [one] => Ok(one.draw_on(page)),
        several => {
            let more = if count > MOST_MAPS {
                format!(" (the first {MOST_MAPS} of {count} maps)")
            } else {
                String::new()
            };
            Ok(abreast(&format!("{title}{more}"), several, page))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(values: &[f64]) -> SweepAxis {
        SweepAxis {
            name: "cortex_um".into(),
            units: "um".into(),
            meaning: String::new(),
            values: Numbers::Floats(values.to_vec()),
            labels: Vec::new(),
        }
    }

    #[test]
    fn edges_lie_half_way_between_values() {
        let even = span(&axis(&[0.3, 0.1, 0.2]));
        assert_eq!((even.label.as_str(), &even.at), ("cortex (µm)", &vec![1, 2, 0]));
        assert!((even.range[0] - 0.05).abs() < 1e-12 && (even.range[1] - 0.35).abs() < 1e-12);
        let uneven = span(&axis(&[1.0, 2.0, 4.0]));
        assert_eq!((uneven.range, uneven.at.len()), ([0.5, 5.0], FINE));
        // 1 from 0.5 to 1.5, 2 to 3, 4 to 5.
        let share = |value: usize| uneven.at.iter().filter(|at| **at == value).count() as f64 / FINE as f64;
        for (value, width) in [(0, 1.0), (1, 1.5), (2, 2.0)] {
            assert!((share(value) - width / 4.5).abs() < 0.01, "{value}");
        }
        assert_eq!(span(&axis(&[2.0])).range, [1.5, 2.5]);
    }
    #[test]
    fn every_place_has_the_nearest_point() {
        // One in the middle of the lower left quarter, one at the upper right.
        assert_eq!(nearest(&[0.25, 1.0], &[0.25, 1.0], 2, 2), [0, 0, 0, 1]);
        assert_eq!(nearest(&[0.1, 0.9], &[0.5, 0.5], 4, 1), [0, 0, 1, 1]);
    }
}
