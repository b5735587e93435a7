//! A measure and how much it varies.

/// Mean and standard deviation of a measure over what has it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spread {
    /// The mean.
    pub mean: f64,
    /// The standard deviation, of n − 1; 0 of one alone.
    pub std: f64,
}

impl Spread {
    /// Of values; of none 0.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        if values.is_empty() {
            return Self::default();
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        Self { mean, std: (squares / (values.len() - 1).max(1) as f64).sqrt() }
    }

    /// Both times a factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { mean: self.mean * factor, std: self.std * factor }
    }
}
