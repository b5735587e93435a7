//! A material beside the barbules that it was simulated from: fits, fields, noise, instances.

mod fields;
mod fits;
mod instances;
mod noise;

pub use fields::FieldPatterns;
pub use fits::{FitCurves, statistics_of_fits};
pub use instances::InstancePatterns;
pub use noise::NoiseCurves;

use crate::plot::{Ink, Stroke};

/// What U and V are, and the squared modulus of a field over √Φ_i.
const PER_RADIAN: &str = "c₀|E|²/Φ_i (1/rad)";

fn nearest(values: &[f64], wanted: f64) -> usize {
    let apart = |k: &usize| (values[*k] - wanted).abs();
    (0..values.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0)
}

/// A faint line for what another panel shows.
fn ghost() -> Option<Stroke> {
    Some(Stroke::solid(Ink::of([150, 150, 150]), 2.4))
}
