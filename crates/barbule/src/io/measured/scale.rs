//! Percent or parts of 1, for each sample; and what is no reflectance in either.

use super::columns::shortened_list;
use super::{Found, Scale};
use crate::error::counted;
use crate::{Error, Result};

/// A reflectance above this is percent.
pub(super) const PERCENT_ABOVE: f64 = 1.5;
/// A value above this is a detector's count.
const COUNTS_ABOVE: f64 = 1000.0;
/// A part of 1 above this is no reflectance, unless the user or a name says in which unit it is: gloss beside a white that
/// scatters reaches above 1.
const DOUBTED_ABOVE: f64 = 3.0;
/// Samples of one kind differ at most so much in the mean of their spectra.
const MOST_APART: f64 = 20.0;
/// So many samples are named, in so many characters.
const MOST_NAMED: usize = 6;
const LONGEST_NAMES: usize = 100;
/// As percent alone columns may differ so much, from black to white, before another reading is looked for.
const MOST_APART_IN_PERCENT: f64 = 60.0;

/// How a table's samples are read.
enum Reading {
    /// All in the same unit.
    All { percent: bool, why: String },
    /// Each in its own: whether it is percent.
    Each(Vec<bool>),
}

impl Found {
    /// Settles percent or parts of 1, and says which.
    pub(super) fn scale(&mut self, given: Option<Scale>) -> Result<Vec<String>> {
        if given == Some(Scale::Power) {
            return Ok(Vec::new());
        }
        self.check_counts()?;
        let mut said = Vec::new();
        if given.is_none() {
            said.extend(self.leave_out_constants());
        }
        let reading = match given {
            Some(scale) => Reading::All { percent: scale == Scale::Percent, why: String::new() },
            None => self.reading()?,
        };
        said.push(self.counted_samples(&reading));
        let largest = self.largest().into_iter().fold(f64::NEG_INFINITY, f64::max);
        let percent = match reading {
            Reading::All { percent: true, why } => {
                said.push(format!("percent divided by 100{why}"));
                vec![true; self.samples.len()]
            }
            Reading::All { percent: false, .. } => {
                said.push(format!("values to {} taken as parts of 1", rounded(largest)));
                vec![false; self.samples.len()]
            }
            Reading::Each(percent) => {
                said.push(format!(
                    "{} percent divided by 100, {} taken as parts of 1",
                    self.listed(&percent, true),
                    self.listed(&percent, false)
                ));
                percent
            }
        };
        for ((_, values), _) in self.samples.iter_mut().zip(&percent).filter(|(_, percent)| **percent) {
            values.iter_mut().for_each(|value| *value /= 100.0);
        }
        self.check_levels(given.is_some(), &percent)?;
        Ok(said)
    }

    fn largest(&self) -> Vec<f64> {
        let of = |values: &Vec<f64>| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.samples.iter().map(|(_, values)| of(values)).collect()
    }

    /// The mean height of each sample, without sign.
    fn levels(&self) -> Vec<f64> {
        let of = |values: &Vec<f64>| values.iter().map(|v| v.abs()).sum::<f64>() / values.len() as f64;
        self.samples.iter().map(|(_, values)| of(values)).collect()
    }

    fn label(&self, sample: usize) -> String {
        match self.samples[sample].0.as_str() {
            "" => format!("sample {}", sample + 1),
            name => format!("'{name}'"),
        }
    }

    /// How many samples there are, and which, if they are few and are not named by their units anyway.
    fn counted_samples(&self, reading: &Reading) -> String {
        let number = counted(self.samples.len(), "sample");
        let names: Vec<String> = self
            .samples
            .iter()
            .filter(|(name, _)| !name.is_empty())
            .map(|(name, _)| format!("'{name}'"))
            .collect();
        if names.len() < self.samples.len() || names.len() > MOST_NAMED {
            return number;
        }
        match (&names[..], reading) {
            ([one], _) => format!("{number}, {one}"),
            ([others @ .., last], Reading::All { .. }) => {
                let list = format!("{} and {last}", others.join(", "));
                if list.chars().count() > LONGEST_NAMES { number } else { format!("{number}, {list}") }
            }
            _ => number,
        }
    }

    /// The samples that are percent, or those that are not.
    fn listed(&self, percent: &[bool], wanted: bool) -> String {
        let of: Vec<String> =
            (0..percent.len()).filter(|&i| percent[i] == wanted).map(|i| self.label(i)).collect();
        match &of[..] {
            many if many.len() > 8 => counted(many.len(), "sample"),
            few => shortened_list(few),
        }
    }

    fn check_counts(&self) -> Result<()> {
        let values = || self.samples.iter().flat_map(|(_, values)| values).copied();
        let largest = values().fold(f64::NEG_INFINITY, f64::max);
        let lowest = values().fold(f64::INFINITY, f64::min);
        let extreme = if -lowest > largest { lowest } else { largest };
        if extreme.abs() > COUNTS_ABOVE {
            return Err(Error::input(format!(
                "the values reach {extreme}, which is no reflectance (are these counts?); give reflectance as parts of 1 or in percent"
            )));
        }
        if -lowest > largest {
            return Err(Error::input(format!(
                "the values go from {lowest} to {largest}, mostly below zero, which is no reflectance; check the dark measurement"
            )));
        }
        Ok(())
    }

    /// Leaves out what has the same number in every line, too large for parts of 1, beside samples in parts of 1: a number
    /// of birds, an age.
    fn leave_out_constants(&mut self) -> Option<String> {
        let largest = self.largest();
        let is_part = |i: usize| largest[i] <= PERCENT_ABOVE;
        let is_constant = |i: usize| {
            let values = &self.samples[i].1;
            !is_part(i) && values.len() > 2 && values.iter().all(|value| *value == values[0])
        };
        let constant: Vec<usize> = (0..largest.len()).filter(|&i| is_constant(i)).collect();
        if constant.is_empty() || !(0..largest.len()).any(is_part) {
            return None;
        }
        let names: Vec<String> = constant.iter().map(|&i| self.label(i)).collect();
        let said = format!("{} left out, the same number in every line", shortened_list(&names));
        let kept: Vec<bool> = (0..largest.len()).map(|i| !constant.contains(&i)).collect();
        let mut of_samples = kept.iter();
        self.samples.retain(|_| of_samples.next().is_some_and(|kept| *kept));
        let mut of_percent = kept.iter();
        self.percent.retain(|_| of_percent.next().is_some_and(|kept| *kept));
        Some(said)
    }

    /// Which samples are percent, where nobody says so for all.
    fn reading(&self) -> Result<Reading> {
        let largest = self.largest();
        let percent: Vec<bool> = largest
            .iter()
            .zip(&self.percent)
            .map(|(largest, said)| *said || *largest > PERCENT_ABOVE)
            .collect();
        let all = |percent: bool| {
            let reached = largest.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let is_said = self.percent.iter().any(|said| *said);
            let why = if percent && !is_said {
                format!(", since they reach {}", rounded(reached))
            } else {
                String::new()
            };
            Ok(Reading::All { percent, why })
        };
        if percent.iter().all(|each| *each == percent[0]) {
            return all(percent[0]);
        }
        let levels = self.levels();
        let scaled: Vec<f64> = levels
            .iter()
            .zip(&percent)
            .map(|(level, percent)| if *percent { level / 100.0 } else { *level })
            .collect();
        let parts_are_parts = (0..percent.len()).all(|i| percent[i] || largest[i] <= 1.0);
        let each = parts_are_parts && apart(&scaled) <= MOST_APART;
        // Names and cells that say percent for all that are leave no doubt about the others.
        let is_said = (0..percent.len()).all(|i| percent[i] == self.percent[i]);
        let is_all_percent = apart(&levels) <= MOST_APART_IN_PERCENT;
        match (each, is_all_percent) {
            (true, all_percent) if is_said || !all_percent => Ok(Reading::Each(percent)),
            (false, true) if !is_said => all(true),
            (false, false) => Err(self.too_far_apart(&scaled)),
            _ => {
                let highest = |wanted: bool| {
                    let of = (0..percent.len()).filter(|&i| percent[i] == wanted);
                    of.map(|i| largest[i]).fold(f64::NEG_INFINITY, f64::max)
                };
                Err(Error::input(format!(
                    "{} may be percent (to {}) beside {} in parts of 1 (to {}), or all percent; write % into the name of each column that is in percent, or name one with `column`",
                    self.listed(&percent, true),
                    rounded(highest(true)),
                    self.listed(&percent, false),
                    rounded(highest(false))
                ))
                .naming(&["column"]))
            }
        }
    }

    /// A second doubt, once all is in parts of 1.
    fn check_levels(&self, is_given: bool, percent: &[bool]) -> Result<()> {
        let bright = self
            .largest()
            .into_iter()
            .enumerate()
            .find(|&(i, largest)| largest > DOUBTED_ABOVE && !is_given && !self.percent[i]);
        if let Some((i, largest)) = bright {
            let still = if percent[i] { "still reaches" } else { "reaches" };
            let after = if percent[i] { " after the division by 100" } else { "" };
            return Err(Error::input(format!(
                "{} {still} {}{after}, which is no reflectance; leave the column out, write % into its name if it is one, or name another with `column`",
                self.label(i),
                rounded(largest)
            ))
            .naming(&["column"]));
        }
        let levels = self.levels();
        if apart(&levels) > MOST_APART { Err(self.too_far_apart(&levels)) } else { Ok(()) }
    }

    /// The refusal of samples that are not of one kind: the one that is farthest from the middle one.
    fn too_far_apart(&self, levels: &[f64]) -> Error {
        let mut order: Vec<usize> = (0..levels.len()).filter(|&i| levels[i] > 0.0).collect();
        order.sort_by(|&a, &b| levels[a].total_cmp(&levels[b]));
        let middle = order[order.len() / 2];
        let ratio = |i: usize| (levels[i] / levels[middle]).max(levels[middle] / levels[i]);
        let [low, high] = [order[0], order[order.len() - 1]];
        let [odd, other] = if ratio(low) > ratio(high) { [low, high] } else { [high, low] };
        let other = if order.len() > 2 { middle } else { other };
        let times = (levels[odd] / levels[other]).max(levels[other] / levels[odd]);
        let brighter = if levels[odd] > levels[other] { "higher" } else { "lower" };
        Error::input(format!(
            "{} is {times:.0} times {brighter} than {} in the mean, so that they are no samples of one kind; leave the column out, or name one with `column`",
            self.label(odd),
            self.label(other)
        ))
        .naming(&["column"])
    }
}

/// The highest over the lowest of levels; what is zero throughout does not count.
fn apart(levels: &[f64]) -> f64 {
    let known = || levels.iter().copied().filter(|level| *level > 0.0);
    let (low, high) = (known().fold(f64::INFINITY, f64::min), known().fold(0.0, f64::max));
    if high > 0.0 { high / low } else { 1.0 }
}

/// Four digits are enough for a sentence.
fn rounded(value: f64) -> f64 {
    let unit = 10f64.powf(value.abs().max(1e-9).log10().floor() - 3.0);
    let short = (value / unit).round() * unit;
    format!("{short:.9}").parse().unwrap_or(short)
}
