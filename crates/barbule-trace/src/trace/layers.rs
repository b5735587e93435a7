//! Layers: regions that go from one side of the picture to the other, and the boundaries between them.

use super::field::{Grey, part};
use super::fit::Normal;
use super::regions::Map;
use super::spread::Spread;

/// A layer between two boundaries.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its class, 0 the brightest.
    pub class: usize,
    /// Its thickness along its normal, px: mean and spread along the layer.
    pub thickness: Spread,
}

/// Regions from side to side, from the top down, and the boundaries between them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bands {
    /// Classes of the regions, from the top down.
    pub classes: Vec<usize>,
    /// The boundaries, one fewer: places x, y, px, from left to right.
    pub boundaries: Vec<Vec<[f64; 2]>>,
    /// What part of the picture these regions cover.
    pub covered: f64,
}

/// A picture whose layers lie level: sampled along axes turned by `turn`, radians, about the middle of `from`.
pub(super) struct Level {
    pub(super) grey: Grey,
    turn: f64,
    from: [f64; 2],
}

impl Level {
    /// A place of the turned picture in the one that it came from.
    pub(super) fn back(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [u, v] = [x - 0.5 * self.grey.width as f64, y - 0.5 * self.grey.height as f64];
        let (sin, cos) = self.turn.sin_cos();
        [0.5 * self.from[0] + cos * u - sin * v, 0.5 * self.from[1] + sin * u + cos * v]
    }
}

/// The direction of layers, radians from x towards y: across the slopes, by the mean of their tensor; and how alike they are, 0 to 1.
pub(super) fn direction(grey: &Grey) -> (f64, f64) {
    let [width, height] = grey.size();
    let step = (((width * height) as f64 / 200_000.0).sqrt() as usize).max(1);
    let mut tensor = [0.0; 3];
    for y in (1..height - 1).step_by(step) {
        for x in (1..width - 1).step_by(step) {
            let [a, b] = grey.slope(x, y);
            tensor[0] += a * a;
            tensor[1] += a * b;
            tensor[2] += b * b;
        }
    }
    let [xx, xy, yy] = tensor;
    let apart = (xx - yy).hypot(2.0 * xy);
    // The slopes' own direction is a right angle further.
    (0.5 * (-2.0 * xy).atan2(yy - xx), apart / (xx + yy).max(1e-30))
}

/// The largest level part of a picture turned by `turn`.
pub(super) fn levelled(grey: &Grey, turn: f64) -> Option<Level> {
    let [w, h] = grey.size().map(|side| side as f64);
    let (sin, cos) = (turn.sin().abs(), turn.cos());
    let (long, short) = (w.max(h), w.min(h));
    let [width, height] = if short <= 2.0 * sin * cos * long {
        let half = 0.5 * short;
        if w >= h { [half / sin, half / cos] } else { [half / cos, half / sin] }
    } else {
        let double = cos * cos - sin * sin;
        [(w * cos - h * sin) / double, (h * cos - w * sin) / double]
    };
    let (width, height) = (width.floor() as usize, height.floor() as usize);
    if width < super::field::LEAST_SIDE || height < super::field::LEAST_SIDE {
        return None;
    }
    let blank = Grey { width, height, values: Vec::new() };
    let mut level = Level { grey: blank, turn, from: [w, h] };
    let mut values = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let [u, v] = level.back([x as f64 + 0.5, y as f64 + 0.5]);
            values.push(grey.sample(u, v) as f32);
        }
    }
    level.grey.values = values;
    Some(level)
}

impl Bands {
    /// The regions that touch both sides, and their boundaries; `between` is the grey between two classes.
    pub(super) fn of(grey: &Grey, map: &Map, between: &dyn Fn(usize, usize) -> f64) -> Self {
        let mut spanning: Vec<usize> = (0..map.regions.len())
            .filter(|r| map.regions[*r].border[0] && map.regions[*r].border[2])
            .collect();
        spanning.sort_by(|a, b| map.regions[*a].middle[1].total_cmp(&map.regions[*b].middle[1]));
        let area: usize = spanning.iter().map(|r| map.regions[*r].area).sum();
        let boundaries = spanning
            .windows(2)
            .map(|pair| {
                let level = between(map.regions[pair[0]].class, map.regions[pair[1]].class);
                boundary(grey, map, [pair[0], pair[1]], level)
            })
            .collect();
        Self {
            classes: spanning.iter().map(|r| map.regions[*r].class).collect(),
            boundaries,
            covered: area as f64 / map.labels.len() as f64,
        }
    }

    /// The layers between boundaries: all regions but the first and the last.
    pub(super) fn layers(&self) -> Option<Vec<Layer>> {
        let inner = self.classes.get(1..self.classes.len().checked_sub(1)?)?;
        inner
            .iter()
            .zip(self.boundaries.windows(2))
            .map(|(class, pair)| Some(Layer { class: *class, thickness: thickness(&pair[0], &pair[1])? }))
            .collect()
    }
}

/// Where the grey crosses a level between two regions, in each column in which they meet.
fn boundary(grey: &Grey, map: &Map, [upper, lower]: [usize; 2], level: f64) -> Vec<[f64; 2]> {
    let label = |x: usize, y: usize| map.labels[y * map.width + x] as usize;
    let mut places = Vec::new();
    for x in 0..map.width {
        let meets = |y: usize| label(x, y) == upper && label(x, y + 1) == lower;
        let Some(row) = (0..map.height - 1).find(|y| meets(*y)) else { continue };
        let sign = (grey.at(x, (row + 3).min(map.height - 1)) - grey.at(x, row.saturating_sub(2))).signum();
        let crosses = |y: usize| {
            let [a, b] = [y, y + 1].map(|y| sign * (grey.at(x, y) - level));
            (a <= 0.0 && b > 0.0).then(|| y as f64 + 0.5 + a / (a - b))
        };
        let near = row.saturating_sub(2)..(row + 3).min(map.height - 1);
        let middle = row as f64 + 1.0;
        let at = near.filter_map(crosses).min_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()));
        places.extend(at.map(|y| [x as f64 + 0.5, y]));
    }
    smoothed(&places)
}

/// A running mean over seven columns, fewer at the ends: the blur keeps finer waves from the picture anyway.
fn smoothed(places: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const HALF: usize = 3;
    let n = places.len();
    (0..n)
        .map(|i| {
            let half = HALF.min(i).min(n - 1 - i);
            let near = &places[i - half..=i + half];
            [places[i][0], near.iter().map(|p| p[1]).sum::<f64>() / near.len() as f64]
        })
        .collect()
}

/// The thickness between two boundaries along the normal of the curve in their middle, which a parabola follows.
fn thickness(upper: &[[f64; 2]], lower: &[[f64; 2]]) -> Option<Spread> {
    let of_lower: std::collections::BTreeMap<u64, f64> = lower.iter().map(|[x, y]| (*x as u64, *y)).collect();
    let columns: Vec<[f64; 3]> =
        upper.iter().filter_map(|[x, y]| of_lower.get(&(*x as u64)).map(|below| [*x, *y, *below])).collect();
    if columns.len() < 8 {
        return None;
    }
    let width = columns[columns.len() - 1][0];
    let mut normal = Normal::new(3);
    for [x, above, below] in &columns {
        let u = x / width;
        normal.add(&[1.0, u, u * u], 0.5 * (above + below));
    }
    let [_, b, c] = normal.solved()?.try_into().ok()?;
    let along: Vec<f64> = columns
        .iter()
        .map(|[x, above, below]| {
            let slope: f64 = (b + 2.0 * c * x / width) / width;
            (below - above) / (1.0 + slope * slope).sqrt()
        })
        .collect();
    // What noise or a speck throws far off is left out.
    let middle = part(&mut along.clone(), 0.5);
    let kept: Vec<f64> = along.into_iter().filter(|t| (t - middle).abs() < 0.5 * middle).collect();
    (!kept.is_empty()).then(|| Spread::of(&kept))
}
