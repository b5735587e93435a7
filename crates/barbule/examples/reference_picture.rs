//! Makes the stored picture of the tests again, after an intended change of what is seen.
//!
//! `target/release/examples/reference_picture` (after `cargo build --release --workspace --examples`).

#![allow(clippy::unwrap_used)] // a program over what tests hold

#[path = "../tests/it/measure/picture.rs"]
mod picture;

use barbule::io::image::write_exr;
use picture::{SAMPLES, SIZE, picture, reference};

fn main() -> barbule::Result<()> {
    let film = picture(SAMPLES[1], 1);
    let rgb = film.linear_srgb();
    let plane = |k: usize| rgb.iter().map(|p| p[k]).collect::<Vec<f32>>();
    write_exr(&reference(), SIZE, vec![("R", plane(0)), ("G", plane(1)), ("B", plane(2))], vec![], &[], &[])
}
