//! What pictures say of their lamps.

use barbule::scene::description::ToldLamp;
use serde_json::{Value, json};

/// Each lamp with its colour and temperature, as in `light D65 6504 K, lights[0] A 2856 K`.
pub(super) fn words(lamps: &[ToldLamp]) -> String {
    let told = lamps.iter().map(|lamp| format!("{} {}", lamp.name, colour(lamp)));
    told.collect::<Vec<_>>().join(", ")
}

/// The colours alone, each once, as in `lit by D65 6504 K and A 2856 K`.
pub(super) fn line(lamps: &[ToldLamp]) -> String {
    let mut colours: Vec<String> = Vec::new();
    for colour in lamps.iter().map(colour) {
        if !colours.contains(&colour) {
            colours.push(colour);
        }
    }
    format!("lit by {}", colours.join(" and "))
}

fn colour(lamp: &ToldLamp) -> String {
    match lamp.cct_k {
        Some(kelvin) => format!("{} {kelvin:.0} K", lamp.illuminant),
        None => lamp.illuminant.clone(),
    }
}

/// The same for programs.
pub(super) fn json(lamps: &[ToldLamp]) -> Value {
    let one = |lamp: &ToldLamp| json!({ "name": lamp.name, "illuminant": lamp.illuminant, "cct_k": lamp.cct_k.map(f64::round) });
    lamps.iter().map(one).collect()
}
