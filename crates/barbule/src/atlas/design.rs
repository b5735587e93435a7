//! Which cells an atlas has: a full grid, or a Latin hypercube.

use super::plan::{Plan, Vary};
use super::subject::{Size, Subject};
use crate::io::sweep::MOST_CELLS;
use crate::math::rng::Stream;
use crate::math::steps::rounded;
use crate::{Error, Result};

/// The name under which the random streams of samples are drawn.
const PURPOSE: u64 = 0x6174_6c61_7330_0001;

/// Digits of a drawn size after its first.
const DIGITS: usize = 6;

/// A key with its values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Swept {
    pub(super) key: String,
    pub(super) size: Size,
    /// Of a grid along its own axis, else of each sample.
    pub(super) values: Vec<f64>,
}

/// The cells of a patch.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Design {
    /// Every value of each key with every of the others, the last key fastest.
    Grid(Vec<Swept>),
    /// So many draws.
    Samples { count: usize, keys: Vec<Swept> },
}

impl Design {
    /// The cells that a plan asks for; sizes are those of `subjects`, which all have the keys.
    ///
    /// # Errors
    /// A key that a subject does not have, a value out of its range, or too many cells.
    pub(super) fn new(plan: &Plan, subjects: &[(String, Subject)], seed: u64) -> Result<Self> {
        let mut keys = Vec::with_capacity(plan.vary.len());
        for (index, vary) in plan.vary.iter().enumerate() {
            let at = |error: Error| error.at(format!("vary[{index}].key"));
            let mut sizes = subjects.iter().map(|(_, subject)| subject.size(&vary.key));
            let first = sizes.next().ok_or_else(|| Error::input("there is no structure"))?.map_err(at)?;
            sizes.try_for_each(|size| size.map(drop)).map_err(at)?;
            let values = match plan.samples {
                None => vary.values.values(&format!("vary[{index}].values"))?,
                Some(count) => drawn(vary, index, &first, count, seed)?,
            };
            let place = format!("vary[{index}].values");
            if let Some(bad) = values.iter().find(|value| !(first.range[0]..=first.range[1]).contains(*value))
            {
                let [low, high] = first.range;
                return Err(Error::input(format!("{place}: {} is {bad}, outside {low} to {high}", vary.key))
                    .about(place));
            }
            if let Some(bad) = values.iter().find(|value| first.whole && value.fract() != 0.0) {
                return Err(Error::input(format!(
                    "{place}: {} is {bad}, but must be a whole number",
                    vary.key
                ))
                .about(place));
            }
            keys.push(Swept { key: vary.key.clone(), size: first, values });
        }
        let design = match plan.samples {
            None => Self::Grid(keys),
            Some(count) => Self::Samples { count, keys },
        };
        let cells =
            design.lengths().into_iter().try_fold(subjects.len(), usize::checked_mul).unwrap_or(usize::MAX);
        if cells > MOST_CELLS {
            return Err(Error::input(format!(
                "the plan has {cells} cells, over the limit of {MOST_CELLS}; give fewer values, or `samples`"
            )));
        }
        Ok(design)
    }

    /// The lengths of its axes.
    pub(super) fn lengths(&self) -> Vec<usize> {
        match self {
            Self::Grid(keys) => keys.iter().map(|key| key.values.len()).collect(),
            Self::Samples { count, .. } => vec![*count],
        }
    }

    /// The sizes at a place along the axes.
    pub(super) fn sizes(&self, place: &[usize]) -> Vec<(String, f64)> {
        match self {
            Self::Grid(keys) => {
                keys.iter().zip(place).map(|(key, at)| (key.key.clone(), key.values[*at])).collect()
            }
            Self::Samples { keys, .. } => {
                keys.iter().map(|key| (key.key.clone(), key.values[place[0]])).collect()
            }
        }
    }

    /// The keys.
    #[cfg(test)]
    fn keys(&self) -> &[Swept] {
        match self {
            Self::Grid(keys) | Self::Samples { keys, .. } => keys,
        }
    }
}

/// One value for each sample: in each of as many equal parts of the range lies one, at random, and which sample has which part is
/// random for each key (McKay, Beckman & Conover 1979, *Technometrics* 21, 239).
fn drawn(vary: &Vary, index: usize, size: &Size, count: usize, seed: u64) -> Result<Vec<f64>> {
    let mut stream = Stream::new(seed, &[PURPOSE, index as u64]);
    let parts = stream.permutation(count);
    let path = format!("vary[{index}].values");
    let one = |part: usize| {
        let at = (part as f64 + stream.unit()) / count as f64;
        let value = vary.values.drawn(at, &path)?;
        // No structure is known to more digits.
        Ok(if size.whole { value.round() } else { rounded(value, DIGITS) })
    };
    parts.into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unobserved;
    use crate::open::Opening;

    fn design(text: &str) -> Result<Design> {
        let plan = Plan::parse(&format!("barbule = 1\nname = 'x'\nstructure = 'starling'\n{text}"))?;
        let subject = Subject::open("starling", &Opening::default(), &Unobserved)?;
        Design::new(&plan, &[(String::new(), subject)], 1)
    }

    fn vary(key: &str, values: &str) -> String {
        format!("[[vary]]\nkey = '{key}'\nvalues = {values}\n")
    }

    #[test]
    fn a_grid_has_every_value_with_every_other() {
        let text = vary("cortex_um", "[0.3, 0.4]") + &vary("melanosome_diameter_um", "[0.2, 0.25, 0.3]");
        let design = design(&text).unwrap();
        assert_eq!(design.lengths(), [2, 3]);
        let sizes = design.sizes(&[1, 2]);
        assert_eq!(sizes, [("cortex_um".to_owned(), 0.4), ("melanosome_diameter_um".to_owned(), 0.3)]);
    }

    #[test]
    fn each_part_of_each_range_has_one_sample() {
        let text = format!(
            "samples = 40\n{}{}",
            vary("cortex_um", "'0.2:0.6'"),
            vary("core_fraction_high", "'0.5:0.9'")
        );
        let design = design(&text).unwrap();
        for (key, low) in design.keys().iter().zip([0.2, 0.5]) {
            let mut parts: Vec<usize> =
                key.values.iter().map(|v| ((v - low) / 0.4 * 40.0) as usize).collect();
            assert!(key.values.iter().all(|v| v.to_string().len() < 10), "{:?}", key.values);
            assert!(!parts.is_sorted(), "{}", key.key);
            parts.sort_unstable();
            assert_eq!(parts, (0..40).collect::<Vec<_>>(), "{}", key.key);
        }
        assert_eq!(design, super::tests::design(&text).unwrap());
    }

    #[test]
    fn keys_and_values_that_a_structure_cannot_have_are_refused() {
        for (text, part) in [
            (
                vary("cortex", "[0.3]"),
                "vary[0].key: starling:green has no size 'cortex', did you mean 'cortex_um'?",
            ),
            (vary("cortex_um", "[0.3, 300]"), "cortex_um is 300, outside 0.001 to 10"),
            (vary("cortex_um", "'0.1:0.2'"), "says no values"),
            (
                vary("cortex_um", "'0.1:1:0.001'") + &vary("core_fraction_high", "'0.31:0.99:0.0001'"),
                "cells, over the limit of 1000000",
            ),
        ] {
            let message = design(&text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
