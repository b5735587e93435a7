//! Means over individuals.

use serde_json::{Value, json};

/// A mean over individuals and how far these lie about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// The mean.
    pub mean: f64,
    /// The standard deviation of one individual; `None` of a single one.
    pub std: Option<f64>,
}

impl Spread {
    /// Of one value for each individual; `None` without any.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let count = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Some(Self { mean, std: (values.len() > 1).then(|| (squares / (count - 1.0)).sqrt()) })
    }

    /// `mean ± std`, times a factor.
    #[must_use]
    pub fn words(&self, factor: f64, decimals: usize) -> String {
        let Self { mean, std } = self;
        let mean = format!("{:.decimals$}", factor * mean);
        std.map_or_else(|| mean.clone(), |std| format!("{mean} ± {:.decimals$}", factor * std))
    }

    pub(super) fn json(self) -> Value {
        json!({"mean": self.mean, "std": self.std})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_are_those_of_individuals() {
        assert_eq!(Spread::of(&[]), None);
        assert_eq!(Spread::of(&[2.0]), Some(Spread { mean: 2.0, std: None }));
        let three = Spread::of(&[1.0, 2.0, 3.0]).unwrap();
        assert_eq!((three.mean, three.std), (2.0, Some(1.0)));
        assert_eq!(three.words(100.0, 1), "200.0 ± 100.0");
    }
}
