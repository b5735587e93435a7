//! A small picture against a stored one: whatever changes what is seen, on purpose or not, shows here.
//!
//! After an intended change the example `reference_picture` makes the stored one again.

use barbule::io::image::read_exr;

use crate::measure::picture::{SAMPLES, SIZE, picture, reference};

/// Side of the blocks that are compared, pixels.
const BLOCK: u32 = 8;

/// Blocks differ by their noise alone: the variance of the new picture plus the reference's, which has 16 times the
/// samples. Colour is compared over the whole picture.
#[test]
fn the_picture_is_the_stored_one_but_for_noise() {
    let film = picture(SAMPLES[0], 2);
    let stored = read_exr(&reference()).unwrap();
    assert_eq!(stored.size, SIZE.map(|s| s as usize));
    let rgb = film.linear_srgb();
    let luminance =
        |p: [f32; 3]| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
    let share = 1.0 + f64::from(SAMPLES[0]) / f64::from(SAMPLES[1]);
    let (mut squares, mut largest, mut blocks) = (0.0, 0.0_f64, 0.0);
    let (mut total, mut total_variance) = (0.0, 0.0);
    for top in (0..SIZE[1]).step_by(BLOCK as usize) {
        for left in (0..SIZE[0]).step_by(BLOCK as usize) {
            let (mut difference, mut variance) = (0.0, 0.0);
            for (x, y) in (top..top + BLOCK).flat_map(|y| (left..left + BLOCK).map(move |x| (x, y))) {
                let at = (y * SIZE[0] + x) as usize;
                difference += luminance(rgb[at]) - luminance(stored.pixels[at]);
                // Neighbours share samples: what counts for a block is what its pixels drew.
                variance += share * film.pixel(x, y).variance(film.count(x, y));
            }
            let deviation = difference / variance.sqrt();
            squares += deviation * deviation;
            largest = largest.max(deviation.abs());
            blocks += 1.0;
            total += difference;
            total_variance += variance;
        }
    }
    let spread = f64::sqrt(squares / blocks);
    let whole = total / total_variance.sqrt();
    assert!(spread < 1.4 && largest < 5.0 && whole.abs() < 4.0, "{spread} {largest} {whole}");
    let mean = |pixels: &[[f32; 3]], k: usize| -> f64 { pixels.iter().map(|p| f64::from(p[k])).sum() };
    for k in 0..3 {
        let ratio = mean(&rgb, k) / mean(&stored.pixels, k);
        assert!((ratio - 1.0).abs() < 0.02, "channel {k}: {ratio}");
    }
}
