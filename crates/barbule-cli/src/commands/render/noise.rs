//! Whether a picture came as far as `--noise` asks, and why not.

use std::fmt;

use barbule::render::film::Film;
use barbule::render::run::{Ended, Goal};
use serde_json::{Value, json};

/// How noisy a picture is that was to be less noisy than a target.
pub(super) struct Noise {
    /// Of the tile that has most of it; unknown where one has less than two samples.
    noise: Option<f64>,
    target: f64,
    /// Why it is over the target.
    cause: String,
}

impl Noise {
    /// Of a film whose tiles were to be below `target`.
    pub(super) fn of(film: &Film, target: f64, goal: &Goal, ended: Ended) -> Self {
        let cause = match ended {
            Ended::Done => format!("all {} samples are taken", goal.samples),
            Ended::OutOfTime => "time is up".to_owned(),
            Ended::Stopped => "interrupted".to_owned(),
        };
        Self { noise: film.noise(), target, cause }
    }

    fn is_reached(&self) -> bool {
        self.noise.is_some_and(|noise| noise < self.target)
    }

    /// As it was given, without the digits by which 3 % as a share of 1 is not 3.
    fn target_percent(&self) -> f64 {
        (1e11 * self.target).round() / 1e9
    }

    /// The same for programs.
    pub(super) fn json(&self) -> [(String, Value); 3] {
        [
            ("noise_percent".to_owned(), json!(self.noise.map(|noise| 100.0 * noise))),
            ("noise_target_percent".to_owned(), json!(self.target_percent())),
            ("noise_reached".to_owned(), json!(self.is_reached())),
        ]
    }
}

impl fmt::Display for Noise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.noise {
            Some(noise) => write!(f, "{:.2} %", 100.0 * noise)?,
            None => write!(f, "unknown")?,
        }
        write!(f, ", target {} % ", self.target_percent())?;
        if self.is_reached() { write!(f, "reached") } else { write!(f, "not reached: {}", self.cause) }
    }
}
