//! How good a picture is to be, in a word.

use crate::render::run::ROUND;

barbule_base::words! {
    /// Samples and noise of a picture by a word; size and light stay the scene's.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Quality {
        /// To see what is where: 8 samples per pixel.
        "draft": Draft,
        /// To work with: noise below 4 %, of at most 512 samples.
        "good": Good,
        /// To show: noise below 1 %, of at most 16384 samples.
        "final": Final,
    }
}

impl Quality {
    /// Most samples per pixel.
    #[must_use]
    pub fn samples(self) -> u32 {
        match self {
            Self::Draft => ROUND,
            Self::Good => 512,
            Self::Final => 16_384,
        }
    }

    /// As [`Goal::noise`](crate::render::run::Goal::noise).
    #[must_use]
    pub fn noise(self) -> Option<f64> {
        match self {
            Self::Draft => None,
            Self::Good => Some(0.04),
            Self::Final => Some(0.01),
        }
    }

    /// The same for who gives some of it: samples that are given are the most, noise that is given holds, and samples alone are the whole goal.
    #[must_use]
    pub fn with(self, samples: Option<u32>, noise: Option<f64>) -> (u32, Option<f64>) {
        match (samples, noise) {
            (Some(samples), noise) => (samples, noise),
            (None, Some(noise)) => (self.samples().max(4096), Some(noise)),
            (None, None) => (self.samples(), self.noise()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_holds() {
        assert_eq!(Quality::Good.with(None, None), (512, Some(0.04)));
        assert_eq!(Quality::Final.with(Some(32), None), (32, None));
        assert_eq!(Quality::Draft.with(None, Some(0.02)), (4096, Some(0.02)));
        assert_eq!(Quality::Final.with(Some(64), Some(0.3)), (64, Some(0.3)));
        assert!(Quality::named("quality", "fnal").unwrap_err().to_string().contains("did you mean 'final'"));
    }
}
