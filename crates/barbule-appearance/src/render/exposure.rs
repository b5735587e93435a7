//! Exposure by a key: as bright as a grey card, whatever the lamps' power.

use super::film::Film;

/// Linear value that the middle of a picture's brightness gets: a grey card's (Reinhard et al. 2002).
pub const KEY: f64 = 0.18;

/// Pixels darker than this share of the mean count as bright as that: black ones would have a logarithm of −∞.
const DARKEST: f64 = 1e-3;

/// The factor from radiance to linear values that brings the geometric mean of the luminances to [`KEY`], over all pixels of
/// which at least half shows an object (over all where there is none such). 1 for a black film; the same bits for the same film.
#[must_use]
pub fn by_key(film: &Film) -> f64 {
    let [width, height] = film.size();
    let places = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let luminance = |(x, y): (u32, u32)| film.xyz(x, y)[1].max(0.0);
    let shows = |&(x, y): &(u32, u32)| 2 * film.pixel(x, y).hits >= film.count(x, y).max(1);
    let mut values: Vec<f64> = places().filter(shows).map(luminance).collect();
    if values.is_empty() {
        values = places().map(luminance).collect();
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    if !(mean.is_finite() && mean > 0.0) {
        return 1.0;
    }
    let logarithm = values.iter().map(|value| libm::log(value.max(DARKEST * mean))).sum::<f64>() / count;
    (KEY / libm::exp(logarithm)).clamp(1e-6, 1e6)
}
