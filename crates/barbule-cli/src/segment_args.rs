//! The flags of segments in three dimensions.

use barbule::structure::{Roughness, SEGMENT_LENGTHS_UM, Segment, Structure};
use barbule::{Error, Result};
use serde_json::{Value, json};

/// How long and how rough segments are.
#[derive(Debug, clap::Args)]
pub(crate) struct SegmentArgs {
    /// Length of a segment in µm [default: the barbule's width]
    #[arg(long, value_name = "UM", value_parser = length)]
    length: Option<f64>,
    /// Standard deviation of each boundary's height in a segment, µm [default: 0.01]
    #[arg(long, value_name = "UM")]
    roughness: Option<f64>,
    /// Correlation lengths of these heights across and along, µm; one number for both [default: 0.5]
    #[arg(long, value_name = "X,Y", value_parser = correlation)]
    correlation: Option<Correlation>,
}

/// Along x and y, µm.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Correlation([f64; 2]);

fn length(text: &str) -> std::result::Result<f64, String> {
    let [shortest, longest] = SEGMENT_LENGTHS_UM;
    let number = text.parse::<f64>().ok().filter(|length| (shortest..=longest).contains(length));
    number.ok_or_else(|| format!("{text} is not a length from {shortest} to {longest} µm"))
}

fn correlation(text: &str) -> std::result::Result<Correlation, String> {
    let wrong = || format!("{text} is not one or two lengths in µm, as in 0.5 or 0.5,2");
    let numbers = text.split(',').map(|word| word.trim().parse::<f64>().map_err(|_| wrong()));
    match numbers.collect::<std::result::Result<Vec<f64>, String>>()?[..] {
        [both] => Ok(Correlation([both, both])),
        [x, y] => Ok(Correlation([x, y])),
        _ => Err(wrong()),
    }
}

impl SegmentArgs {
    /// Refuses the flags where there are no segments.
    ///
    /// # Errors
    /// One is given.
    pub(crate) fn check_unused(&self) -> Result<()> {
        let given = [
            ("--length", self.length.is_some()),
            ("--roughness", self.roughness.is_some()),
            ("--correlation", self.correlation.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((flag, _)) => {
                Err(Error::input(format!("{flag} is of segments; give it with --three-d, or leave it out")))
            }
            None => Ok(()),
        }
    }

    /// The roughness, none where segments shall be invariant along y.
    ///
    /// # Errors
    /// A number is out of range.
    pub(crate) fn roughness(&self, is_invariant: bool) -> Result<Roughness> {
        let usual = Roughness::default();
        let given = Roughness {
            amplitude_um: self.roughness.unwrap_or(usual.amplitude_um),
            correlation_um: self.correlation.map_or(usual.correlation_um, |Correlation(lengths)| lengths),
        };
        given.check().map_err(|error| error.at("--roughness, --correlation"))?;
        Ok(if is_invariant { Roughness::NONE } else { given })
    }

    /// The length that is asked for, µm.
    pub(crate) fn length_asked_um(&self) -> Option<f64> {
        self.length
    }

    /// How long segments of a structure are, µm.
    pub(crate) fn length_um(&self, structure: &Structure) -> f64 {
        let [shortest, longest] = SEGMENT_LENGTHS_UM;
        self.length.unwrap_or_else(|| structure.width_um().clamp(shortest, longest))
    }
}

/// What a segment is beside its section.
pub(crate) fn json_of(segment: &Segment) -> Value {
    json!({
        "length_um": segment.length_um,
        "roughness_um": segment.roughness.amplitude_um,
        "correlation_um": segment.roughness.correlation_um,
    })
}
