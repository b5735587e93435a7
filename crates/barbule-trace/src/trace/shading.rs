//! Uneven light and stain taken out of a picture, without taking out what is in it.
//!
//! A pixel of class k is L_k S(x, y): a level for each class and one polynomial for the light, both found in turns with the classes
//! themselves. What the classes then differ by, as where stain is uneven, is a plane for each class.

use barbule_base::{Error, Result};

use super::field::{Grey, part};
use super::fit::Normal;
use super::levels::{BINS, histogram, otsu};

/// Pixels that the light is found from.
const LOOKED_AT: usize = 12_000;
/// Turns of classes and light.
const TURNS: usize = 12;
/// Terms of a polynomial of degree three in two variables.
const TERMS: usize = 10;
/// A third class must leave at most this of the variance that two leave within them. A third class that is none cuts one
/// normal distribution into two, which leaves (π − 2)/π = 0.36 of its variance.
const THIRD: f64 = 0.25;
/// And it must lie so far from the others, a part of the distance of the brightest and the darkest, unless it is asked for.
const APART: f64 = 0.12;
/// Classes that leave more than this of the variance about smooth light alone are none: cutting normal noise in two leaves 0.36.
const MOST_LEFT: f64 = 0.25;
/// Grey levels between the darkest and the brightest class of a flattened picture.
const DARK: f64 = 40.0;
const BRIGHT: f64 = 215.0;

/// A picture with the light and the stain made even, in grey levels 0 to 255: the classes lie at `levels`.
#[derive(Debug, Clone)]
pub(super) struct Flat {
    pub(super) grey: Grey,
    /// From the brightest to the darkest.
    pub(super) levels: Vec<f64>,
    /// How many pixels have each grey level, of those far from edges.
    pub(super) counts: [u32; BINS],
}

/// A pixel that is looked at: place from −1 to 1, value.
#[derive(Debug, Clone, Copy)]
struct Seen {
    x: f64,
    y: f64,
    value: f64,
}

/// Classes and light that fit together.
#[derive(Debug, Clone)]
struct Light {
    polynomial: [f64; TERMS],
    /// From the darkest to the brightest.
    levels: Vec<f64>,
    /// A plane beside each level.
    planes: Vec<[f64; 3]>,
    /// The variance within classes, a part of all.
    within: f64,
}

/// What smooth light alone leaves: the sum of squares about a polynomial.
fn left_by_light(seen: &[Seen]) -> f64 {
    let mut normal = Normal::new(TERMS);
    seen.iter().for_each(|s| normal.add(&terms(s.x, s.y), s.value));
    let Some(polynomial) = normal.solved() else { return 0.0 };
    seen.iter().map(|s| (s.value - polynomial_at(&polynomial, s.x, s.y)).powi(2)).sum()
}

impl Light {
    /// The level of a class at a place, in even light.
    fn level(&self, class: usize, x: f64, y: f64) -> f64 {
        let [a, b, c] = self.planes[class];
        self.levels[class] + a + b * x + c * y
    }

    /// What classes and light leave: the sum of squares about the nearest level.
    fn left(&self, seen: &[Seen]) -> f64 {
        let off = |s: &Seen| {
            let light = light_at(&self.polynomial, s.x, s.y);
            let beside = |class: usize| (s.value - light * self.level(class, s.x, s.y)).powi(2);
            (0..self.levels.len()).map(beside).fold(f64::INFINITY, f64::min)
        };
        seen.iter().map(off).sum()
    }

    /// Whether the levels lie well apart.
    fn is_apart(&self) -> bool {
        let all = self.levels[self.levels.len() - 1] - self.levels[0];
        self.levels.windows(2).all(|pair| pair[1] - pair[0] > APART * all)
    }
}

fn terms(x: f64, y: f64) -> [f64; TERMS] {
    [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
}

fn polynomial_at(polynomial: &[f64], x: f64, y: f64) -> f64 {
    terms(x, y).iter().zip(polynomial).map(|(t, p)| t * p).sum()
}

/// The light, whose mean is 1; light that falls to a twentieth of it is no light.
fn light_at(polynomial: &[f64; TERMS], x: f64, y: f64) -> f64 {
    polynomial_at(polynomial, x, y).max(0.05)
}

/// Flattens a smoothed picture. `classes` is how many there are, 2 or 3, if it is known.
pub(super) fn flatten(smooth: &Grey, classes: Option<usize>) -> Result<Flat> {
    let seen = looked_at(smooth);
    let best_of = |classes: usize| {
        let starts = starts(&seen);
        let tried = starts.iter().filter_map(|start| settled(&seen, *start, classes));
        tried.min_by(|a, b| a.within.total_cmp(&b.within)).map(|light| with_planes(light, &seen))
    };
    let no_classes = || {
        Error::input(
            "has no two classes of grey: no threshold divides its pixels into brighter and darker ones; give a picture with more contrast",
        )
    };
    let light = match classes {
        Some(classes) => best_of(classes),
        None => match (best_of(2), best_of(3)) {
            (Some(two), Some(three)) if three.within >= THIRD * two.within || !three.is_apart() => Some(two),
            (two, three) => three.or(two),
        },
    };
    let light =
        light.filter(|light| light.left(&seen) < MOST_LEFT * left_by_light(&seen)).ok_or_else(no_classes)?;
    Ok(flattened(smooth, &light, &seen))
}

/// Pixels on a grid that lie away from edges, where the blur mixes classes.
fn looked_at(smooth: &Grey) -> Vec<Seen> {
    let [width, height] = smooth.size();
    // Twice as many, of which the flatter half is taken.
    let step = (((width * height) as f64 / (2.0 * LOOKED_AT as f64)).sqrt()).max(1.0);
    let places = |count: usize| {
        (0..).map(move |i| ((f64::from(i) + 0.5) * step) as usize).take_while(move |at| *at < count)
    };
    let mut all = Vec::new();
    for y in places(height) {
        for x in places(width) {
            let [a, b] = smooth.slope(x, y);
            let place = |at: usize, count: usize| 2.0 * (at as f64 + 0.5) / count as f64 - 1.0;
            all.push((a.hypot(b), Seen { x: place(x, width), y: place(y, height), value: smooth.at(x, y) }));
        }
    }
    let mut slopes: Vec<f64> = all.iter().map(|(slope, _)| *slope).collect();
    // Slopes of light and stain are no edges.
    let flattest = part(&mut slopes, 0.55).max(0.08 * part(&mut slopes, 0.98));
    all.into_iter().filter(|(slope, _)| *slope <= flattest).map(|(_, seen)| seen).collect()
}

/// Guesses of the light: even; the picture's own trend; that of its bright and its dark parts.
fn starts(seen: &[Seen]) -> Vec<[f64; TERMS]> {
    let mut even = [0.0; TERMS];
    even[0] = 1.0;
    let mut all = vec![even];
    let fitted = |chosen: &mut dyn Iterator<Item = Seen>, count: usize| -> Option<[f64; TERMS]> {
        let mut normal = Normal::new(count);
        let mut n = 0;
        for seen in chosen {
            normal.add(&terms(seen.x, seen.y)[..count], seen.value);
            n += 1;
        }
        if n < 4 * count {
            return None;
        }
        let mut polynomial = [0.0; TERMS];
        polynomial[..count].copy_from_slice(&normal.solved()?);
        Some(polynomial)
    };
    all.extend(fitted(&mut seen.iter().copied(), 3));
    all.extend(fitted(&mut seen.iter().copied(), 6));
    // The brightest and the darkest fifth of each of 5 × 5 parts.
    for is_bright in [true, false] {
        let mut cells: Vec<Vec<Seen>> = vec![Vec::new(); 25];
        for one in seen {
            let cell = |at: f64| (((at + 1.0) * 2.5) as usize).min(4);
            cells[5 * cell(one.y) + cell(one.x)].push(*one);
        }
        let mut chosen = Vec::new();
        for mut cell in cells {
            cell.sort_by(|a, b| a.value.total_cmp(&b.value));
            let fifth = cell.len() / 5;
            chosen.extend_from_slice(if is_bright { &cell[cell.len() - fifth..] } else { &cell[..fifth] });
        }
        all.extend(fitted(&mut chosen.iter().copied(), 3));
        all.extend(fitted(&mut chosen.iter().copied(), 6));
    }
    all
}

/// Classes and light in turns from a guess of the light.
fn settled(seen: &[Seen], start: [f64; TERMS], classes: usize) -> Option<Light> {
    let mut polynomial = start;
    let mut light = None;
    let mut even = vec![0.0; seen.len()];
    for turn in 0..TURNS {
        let sum: f64 = seen.iter().map(|s| polynomial_at(&polynomial, s.x, s.y)).sum();
        let mean = sum / seen.len().max(1) as f64;
        if mean <= 0.0 {
            return None;
        }
        polynomial.iter_mut().for_each(|p| *p /= mean);
        for (even, s) in even.iter_mut().zip(seen) {
            *even = s.value / light_at(&polynomial, s.x, s.y);
        }
        let (of, levels, within) = classed(&even, classes)?;
        light = Some(Light { polynomial, planes: vec![[0.0; 3]; classes], within, levels: levels.clone() });
        // A plane first: what the classes are is not yet known well.
        let count = if turn < 3 { 3 } else { TERMS };
        let mut normal = Normal::new(count);
        let strongest = levels.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for (s, class) in seen.iter().zip(&of) {
            let level = levels[*class] / strongest;
            let row = terms(s.x, s.y).map(|t| t * level);
            normal.add(&row[..count], s.value / strongest);
        }
        // Higher terms are small unless the picture says otherwise.
        for term in 1..count {
            normal.hold(term, 0.0, 1e-4 * seen.len() as f64);
        }
        polynomial = [0.0; TERMS];
        polynomial[..count].copy_from_slice(&normal.solved()?);
    }
    light
}

/// The class of each value, from the darkest; the classes' levels; the variance that is left within them, a part of all.
fn classed(values: &[f64], classes: usize) -> Option<(Vec<usize>, Vec<f64>, f64)> {
    let mut sorted = values.to_vec();
    let ends = [part(&mut sorted, 0.002), part(&mut sorted, 0.998)];
    if ends[1] - ends[0] <= 1e-6 {
        return None;
    }
    let counts = histogram(values.iter().copied(), ends);
    let edges: Vec<f64> = otsu(&counts, classes)
        .into_iter()
        .map(|bin| ends[0] + (ends[1] - ends[0]) * bin as f64 / BINS as f64)
        .collect();
    let of: Vec<usize> = values.iter().map(|v| edges.iter().filter(|edge| v >= edge).count()).collect();
    let mut sums = vec![[0.0; 2]; classes];
    for (value, class) in values.iter().zip(&of) {
        sums[*class][0] += 1.0;
        sums[*class][1] += value;
    }
    if sums.iter().any(|[n, _]| *n < 0.005 * values.len() as f64) {
        return None;
    }
    let levels: Vec<f64> = sums.iter().map(|[n, sum]| sum / n).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let within: f64 = values.iter().zip(&of).map(|(v, c)| (v - levels[*c]).powi(2)).sum();
    let all: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    Some((of, levels, within / all))
}

/// Adds what each class differs by from the common light, where that leaves the classes well apart.
fn with_planes(light: Light, seen: &[Seen]) -> Light {
    let even: Vec<f64> = seen.iter().map(|s| s.value / light_at(&light.polynomial, s.x, s.y)).collect();
    let Some((of, ..)) = classed(&even, light.levels.len()) else { return light };
    let gap = light.levels.windows(2).map(|l| l[1] - l[0]).fold(f64::INFINITY, f64::min);
    let planes: Vec<[f64; 3]> = (0..light.levels.len())
        .map(|class| {
            let mut normal = Normal::new(3);
            let mut count = 0.0;
            for ((s, value), _) in seen.iter().zip(&even).zip(&of).filter(|(_, c)| **c == class) {
                // What a class has at its edges with others counts less.
                let off = (value - light.levels[class]) / gap;
                let weight = (1.0 / (1.0 + 16.0 * off * off)).sqrt();
                normal.add(&[weight, weight * s.x, weight * s.y], weight * (value - light.levels[class]));
                count += 1.0;
            }
            (1..3).for_each(|term| normal.hold(term, 0.0, 0.01 * count + 1.0));
            normal.solved().map_or([0.0; 3], |p| [p[0], p[1], p[2]])
        })
        .collect();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
    let tilted = Light { planes, ..light.clone() };
    let apart = corners.iter().all(|[x, y]| {
        (1..light.levels.len()).all(|c| {
            tilted.level(c, *x, *y) - tilted.level(c - 1, *x, *y)
                > 0.3 * (light.levels[c] - light.levels[c - 1])
        })
    });
    if apart {
        let mean = even.iter().sum::<f64>() / even.len() as f64;
        let all: f64 = even.iter().map(|value| (value - mean).powi(2)).sum();
        let left = seen
            .iter()
            .zip(&even)
            .zip(&of)
            .map(|((s, value), class)| (value - tilted.level(*class, s.x, s.y)).powi(2));
        let within = left.sum::<f64>() / all;
        return Light { within, ..tilted };
    }
    light
}

/// Every pixel on the scale on which each class has one level: linear between the classes' levels at its place.
fn flattened(smooth: &Grey, light: &Light, seen: &[Seen]) -> Flat {
    let (first, last) = (light.levels[0], light.levels[light.levels.len() - 1]);
    let goal: Vec<f64> =
        light.levels.iter().map(|l| DARK + (BRIGHT - DARK) * (l - first) / (last - first)).collect();
    let even = |value: f64, x: f64, y: f64| {
        let value = value / light_at(&light.polynomial, x, y);
        let here = |class: usize| light.level(class, x, y);
        // The pair of levels about the value; beyond the ends the line of the outer pair goes on.
        let upper = (1..goal.len() - 1).find(|class| value < here(*class)).unwrap_or(goal.len() - 1);
        let (low, high) = (here(upper - 1), here(upper));
        goal[upper - 1] + (goal[upper] - goal[upper - 1]) * (value - low) / (high - low)
    };
    let [width, height] = smooth.size();
    let place = |at: usize, count: usize| 2.0 * (at as f64 + 0.5) / count as f64 - 1.0;
    let mut values = Vec::with_capacity(width * height);
    for y in 0..height {
        let v = place(y, height);
        values.extend((0..width).map(|x| even(smooth.at(x, y), place(x, width), v) as f32));
    }
    let counts = histogram(seen.iter().map(|s| even(s.value, s.x, s.y)), [0.0, 256.0]);
    Flat { grey: Grey { width, height, values }, levels: goal.into_iter().rev().collect(), counts }
}
