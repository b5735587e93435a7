//! Exposure by what a picture shows: as bright as a grey card, whatever the lamps' power, but not so bright that highlights are lost.

use super::film::Film;
use crate::spectrum::colour::rgb_from_xyz;

/// Linear value that the middle of a picture's brightness gets: a grey card's (Reinhard et al. 2002).
pub const KEY: f64 = 0.18;

/// Largest of R, G and B after exposure from which on the tone curve shows little but white: it is at 0.988 there.
pub const WHITE: f64 = 2.0;

/// Share of what is shown that may be brighter than [`WHITE`].
const HIGHLIGHTS: f64 = 0.01;

/// By how much highlights darken a picture at most: three stops, beyond which a dark thing with a bright glint would be black.
const MOST_DARKER: f64 = 8.0;

/// Pixels darker than this share of the mean count as bright as that: black ones would have a logarithm of −∞.
const DARKEST: f64 = 1e-3;

/// The factor from radiance to linear values that brings the geometric mean of the luminances to [`KEY`], over all pixels of
/// which at least half shows an object (over all where there is none such); less, by three stops at most, where more than a hundredth of
/// them would be brighter than [`WHITE`]. 1 for a black film; the same bits for the same film.
#[must_use]
pub fn automatic(film: &Film) -> f64 {
    let shown = shown(film);
    balanced(
        shown.iter().map(|xyz| xyz[1].max(0.0)).collect(),
        shown.iter().copied().map(brightest).collect(),
    )
}

/// Share of the same pixels that are brighter than [`WHITE`] at this exposure, 0 … 1.
#[must_use]
pub fn clipped(film: &Film, exposure: f64) -> f64 {
    let shown = shown(film);
    let count = shown.iter().filter(|xyz| brightest(**xyz) * exposure > WHITE).count();
    count as f64 / shown.len().max(1) as f64
}

/// CIE XYZ of the pixels that count.
fn shown(film: &Film) -> Vec<[f64; 3]> {
    let [width, height] = film.size();
    let places = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let is_object = |&(x, y): &(u32, u32)| 2 * film.pixel(x, y).hits >= film.count(x, y).max(1);
    let xyz = |(x, y): (u32, u32)| film.xyz(x, y);
    let objects: Vec<[f64; 3]> = places().filter(is_object).map(xyz).collect();
    if objects.is_empty() { places().map(xyz).collect() } else { objects }
}

/// The largest component in linear sRGB.
fn brightest(xyz: [f64; 3]) -> f64 {
    rgb_from_xyz(xyz).into_iter().fold(0.0, f64::max)
}

/// As [`automatic`], from luminances and largest components in linear sRGB of the same pixels; 1 where there are none.
#[must_use]
pub fn balanced(luminances: Vec<f64>, mut largest: Vec<f64>) -> f64 {
    let count = luminances.len() as f64;
    let mean = luminances.iter().sum::<f64>() / count;
    if !(mean.is_finite() && mean > 0.0) || largest.is_empty() {
        return 1.0;
    }
    let logarithm = luminances.iter().map(|value| libm::log(value.max(DARKEST * mean))).sum::<f64>() / count;
    let by_key = KEY / libm::exp(logarithm);
    let over = (HIGHLIGHTS * count) as usize;
    let last = largest.len() - 1 - over.min(largest.len() - 1);
    let highlight = *largest.select_nth_unstable_by(last, f64::total_cmp).1;
    let exposure =
        if by_key * highlight > WHITE { (WHITE / highlight).max(by_key / MOST_DARKER) } else { by_key };
    exposure.clamp(1e-6, 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exposed(values: &[f64]) -> f64 {
        balanced(values.to_vec(), values.to_vec())
    }

    #[test]
    fn even_pictures_are_as_bright_as_a_grey_card() {
        let even: Vec<f64> = (0..1000).map(|k| if k % 2 == 0 { 0.5 } else { 2.0 }).collect();
        assert!((exposed(&even) - KEY).abs() < 1e-12);
        assert_eq!(exposed(&[0.0; 10]), 1.0);
        assert_eq!(exposed(&[f64::NAN; 10]), 1.0);
    }

    /// Of a dark thing with highlights a hundredth stays brighter than white, where by the key alone a fiftieth was, or it is three stops
    /// darker.
    #[test]
    fn highlights_hold_a_picture_back_by_three_stops_at_most() {
        let dark = |highlight: f64, share: usize| -> Vec<f64> {
            (0..1000)
                .map(|k| if k % 1000 < share { highlight * (1.0 + 1e-4 * k as f64) } else { 0.02 })
                .collect()
        };
        let by_key = exposed(&dark(0.02, 20));
        assert!((by_key - 9.0).abs() < 0.1);
        let bright = |values: &[f64], exposure: f64| values.iter().filter(|v| **v * exposure > WHITE).count();
        let glossy = dark(0.5, 20);
        let exposure = exposed(&glossy);
        assert!(exposure < 0.6 * by_key && exposure > by_key / MOST_DARKER, "{exposure}");
        // The one at the border may be either.
        assert!((10..=11).contains(&bright(&glossy, exposure)) && bright(&glossy, by_key) == 20);
        // A few glints change nothing.
        assert!((exposed(&dark(5.0, 5)) / by_key - 1.0).abs() < 0.05);
        let glaring = dark(50.0, 20);
        let alone = KEY / libm::exp(glaring.iter().map(|v| libm::log(*v)).sum::<f64>() / 1000.0);
        assert!((exposed(&glaring) * MOST_DARKER / alone - 1.0).abs() < 1e-9);
    }
}
