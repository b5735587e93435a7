//! Heightfields as they are named on a command line: a sample or a file.

use barbule::error::{did_you_mean, shortened};
use barbule::structure::{Heightfield, SAMPLES};
use barbule::{Error, Result};

/// Which heights.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct HeightsArgs {
    /// Measured heights, or a sample: elaphe, xenopeltis, blazed, sinusoid
    #[arg(value_name = "HEIGHTS|SAMPLE")]
    heights: String,
}

impl HeightsArgs {
    /// The heights and what they are called.
    pub(crate) fn read(&self, seed: u64) -> Result<(Heightfield, String)> {
        if let Some(sample) = Heightfield::sample(&self.heights, seed) {
            return Ok((sample?, self.heights.clone()));
        }
        let near = did_you_mean(&self.heights, SAMPLES);
        Err(Error::input(format!("{}: no such file or sample{near}", shortened(&self.heights))))
    }
}
