//! The numbers of a colour, and what is known of each.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::math::normal;
use crate::math::student::interval_95;
use crate::spectrum::Spectrum;
use crate::spectrum::colour::D65_WHITE;
use crate::spectrum::difference::{delta_e_2000, lab};
use crate::spectrum::look::Look;
use crate::spectrum::peaks::Peak;
use crate::spectrum::spread::SAME_PEAK;

/// How many numbers there are.
pub(super) const COUNT: usize = NAMES.len();
/// What they are called, as in the numbers of a colour; the last is how far the colour itself may be off.
const NAMES: [&str; 8] = [
    "peak_nm",
    "half_width_nm",
    "peak_reflectance",
    "mean_reflectance",
    "luminous_reflectance",
    "x",
    "y",
    "delta_e_2000",
];
const DELTA_E: usize = COUNT - 1;
/// How near is near enough: a spectrometer's steps, a colour that nobody tells from another; a twentieth of reflectances.
const ENOUGH: [Enough; 8] = [
    Enough::Within(2.0),
    Enough::Within(4.0),
    Enough::Part(0.05),
    Enough::Part(0.05),
    Enough::Part(0.05),
    Enough::Within(0.003),
    Enough::Within(0.003),
    Enough::Within(1.0),
];

#[derive(Debug, Clone, Copy)]
enum Enough {
    Within(f64),
    /// Of the value.
    Part(f64),
}

/// The numbers of one curve.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Numbers {
    /// In the order of [`NAMES`], but for the last.
    values: [Option<f64>; COUNT - 1],
    xyz: Option<[f64; 3]>,
}

impl Numbers {
    /// Of a curve, with the peak that is nearest to a given one.
    pub(super) fn of(curve: &Spectrum, near: Option<Peak>) -> Self {
        let look = Look::of(curve);
        let far = |peak: &Peak| near.map_or(0.0, |near| libm::log(peak.nm / near.nm).abs());
        let peaks = look.peaks.iter().filter(|_| near.is_some()).filter(|peak| far(peak) < SAME_PEAK);
        let peak = peaks.min_by(|a, b| far(a).total_cmp(&far(b)));
        let colour = look.colour.as_ref();
        let xy = |k: usize| colour.and_then(|colour| Some(colour.xy?[k]));
        Self {
            values: [
                peak.map(|peak| peak.nm),
                peak.and_then(|peak| peak.half.nm()),
                peak.map(|peak| peak.reflectance),
                Some(look.mean_reflectance),
                colour.map(|colour| colour.xyz[1]),
                xy(0),
                xy(1),
            ],
            xyz: colour.map(|colour| colour.xyz),
        }
    }

    /// How far the colours of two curves are apart.
    fn delta_e(&self, other: &Self) -> Option<f64> {
        Some(delta_e_2000(lab(self.xyz?, D65_WHITE), lab(other.xyz?, D65_WHITE)))
    }

    /// A number, or how far the colour is from another's.
    fn value(&self, which: usize, mean: &Self) -> Option<f64> {
        if which == DELTA_E { self.delta_e(mean) } else { self.values[which] }
    }
}

/// What an uncertain input contributes.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The input.
    pub name: String,
    /// The standard deviation that it makes; none where the number is lost on the way.
    pub std: Option<f64>,
}

/// What is known of a number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Known {
    /// The number, as in the numbers of colours; `delta_e_2000` is how far the colour may be from the mean's.
    #[serde(skip)]
    pub name: &'static str,
    /// That of the mean.
    pub value: f64,
    /// The 95 % interval, of individuals and uncertain inputs together.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// The standard deviation because the individuals are no others; none of one individual.
    #[serde(rename = "std_of_individuals")]
    pub of_individuals: Option<f64>,
    /// What uncertain inputs contribute.
    #[serde(rename = "std_of_uncertain", serialize_with = "parts_by_name")]
    pub parts: Vec<Part>,
    /// What is near enough: half an interval.
    pub enough: f64,
    /// How many individuals make their part of the interval that narrow; none of one individual.
    pub individuals_enough: Option<usize>,
}

/// Numbers under their names.
pub(super) fn by_name<S: Serializer>(all: &[Known], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(all.len()))?;
    all.iter().try_for_each(|known| map.serialize_entry(known.name, known))?;
    map.end()
}

/// Standard deviations under the names of what makes them.
fn parts_by_name<S: Serializer>(all: &[Part], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(all.len()))?;
    all.iter().try_for_each(|part| map.serialize_entry(&part.name, &part.std))?;
    map.end()
}

/// What intervals of few individuals are wider by than percentiles of means of individuals that are drawn again.
struct Few {
    /// Means of n drawn from the same n vary by their variance's n−1 of n alone.
    drawn: f64,
    /// How much they vary is not known well itself: Student's t over a normal distribution's.
    unknown: f64,
}

impl Few {
    fn of(individuals: usize) -> Self {
        if individuals < 2 {
            return Self { drawn: 1.0, unknown: 1.0 };
        }
        let others = (individuals - 1) as f64;
        Self {
            drawn: (individuals as f64 / others).sqrt(),
            unknown: interval_95(others) / normal::quantile(0.975),
        }
    }
}

impl Known {
    /// Of the mean's numbers, those of the drawn means, and those of the curves with an input moved up and down; none where the
    /// mean has no such number, or where it is lost in more than a tenth of the draws.
    pub(super) fn of(
        which: usize,
        mean: &Numbers,
        drawn: &[Numbers],
        names: &[&str],
        moved: &[[Numbers; 2]],
        individuals: usize,
    ) -> Option<Self> {
        let value = mean.value(which, mean)?;
        let mut all: Vec<f64> = drawn.iter().filter_map(|one| one.value(which, mean)).collect();
        if 10 * all.len() < 9 * drawn.len() {
            return None;
        }
        all.sort_by(f64::total_cmp);
        let quantile = |part: f64| {
            let at = part * (all.len() - 1) as f64;
            let (below, rest) = (at.floor() as usize, at.fract());
            all[below] + rest * (all[(below + 1).min(all.len() - 1)] - all[below])
        };
        let is_distance = which == DELTA_E;
        let few = Few::of(individuals);
        let [down, up] = match (all.is_empty(), is_distance) {
            (true, _) => [0.0; 2],
            (_, true) => [0.0, few.drawn * quantile(0.95)],
            (_, false) => {
                [value - quantile(0.025), quantile(0.975) - value].map(|side| few.drawn * side.max(0.0))
            }
        };
        let parts: Vec<Part> = names
            .iter()
            .zip(moved)
            .map(|(name, [a, b])| {
                let values = a.value(which, mean).zip(b.value(which, mean));
                let std = values.map(|(a, b)| if is_distance { 0.5 * (a + b) } else { 0.5 * (a - b).abs() });
                Part { name: (*name).to_owned(), std }
            })
            .collect();
        let squares: f64 = parts.iter().filter_map(|part| part.std).map(|std| std * std).sum();
        let half = normal::quantile(0.975) * squares.sqrt();
        let enough = match ENOUGH[which] {
            Enough::Within(enough) => enough,
            Enough::Part(part) => part * value.abs(),
        };
        // Errors of means fall with the root of how many there are.
        let ratio = 0.5 * (down + up) / enough * if is_distance { 2.0 } else { 1.0 };
        let needed = (individuals as f64 * ratio * ratio).ceil().max(2.0);
        let deviation = || {
            let count = all.len() as f64;
            let centre = all.iter().sum::<f64>() / count;
            few.drawn * (all.iter().map(|v| (v - centre) * (v - centre)).sum::<f64>() / (count - 1.0)).sqrt()
        };
        let [down, up] = [down, up].map(|side| few.unknown * side);
        Some(Self {
            name: NAMES[which],
            value,
            low: if is_distance { 0.0 } else { value - down.hypot(half) },
            high: value + up.hypot(half),
            of_individuals: (!all.is_empty()).then(deviation),
            parts,
            enough,
            individuals_enough: (!all.is_empty() && needed.is_finite()).then_some(needed as usize),
        })
    }
}
