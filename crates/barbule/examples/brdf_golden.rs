//! Values of two materials by which every evaluation of BRDF tables is held: `crates/barbule/tests/it/data/brdf.json`.
//!
//! `cargo run --release -p barbule --example brdf_golden [-- FILE]`, a few CPU seconds; without a file they are printed.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what tests hold

#[path = "../tests/it/measure/golden.rs"]
mod golden;

use golden::Golden;
use serde::Serialize;

fn main() -> barbule::Result<()> {
    let text = text(&Golden::made());
    match std::env::args().nth(1) {
        Some(file) => barbule::io::write_whole(file.as_ref(), text.as_bytes()),
        None => {
            print!("{text}");
            Ok(())
        }
    }
}

/// JSON with a line for each incident direction.
fn text(golden: &Golden) -> String {
    let materials: Vec<String> = golden
        .materials
        .iter()
        .map(|material| {
            let light: Vec<String> = material.light.iter().map(json).collect();
            let (name, hash) = (json(&material.name), json(&material.hash));
            format!("{{\"name\":{name},\"hash\":{hash},\"light\":[\n{}\n]}}", light.join(",\n"))
        })
        .collect();
    let head = [
        ("origin", json(&golden.origin)),
        ("version", json(&golden.version)),
        ("wavelengths_nm", json(&golden.wavelengths_nm)),
        ("instance", json(&golden.instance)),
        ("u", json(&golden.u)),
    ];
    let head: Vec<String> = head.iter().map(|(key, value)| format!("\"{key}\":{value}")).collect();
    format!("{{{},\n\"materials\":[{}]}}\n", head.join(",\n"), materials.join(",\n"))
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap()
}
