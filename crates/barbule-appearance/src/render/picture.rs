//! A film as a picture: bytes for a PNG, channels for an EXR.

use super::film::Film;
use super::tone;

/// 8-bit RGB, row by row, after exposure and the tone curve of [`tone`].
#[must_use]
pub fn bytes(film: &Film, exposure: f64) -> Vec<u8> {
    film.linear_srgb().iter().flat_map(|rgb| tone::to_bytes(rgb.map(|v| f64::from(v) * exposure))).collect()
}

/// One plane of a picture, with its name in an EXR.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane<T> {
    /// Name, as in `normal.X`.
    pub name: &'static str,
    /// Values, row by row.
    pub values: Vec<T>,
}

/// Linear sRGB (without exposure), normal, depth in mm, variance of the luminance's mean and sample count; then the
/// identities of barbules, barbs and shaft.
#[must_use]
pub fn planes(film: &Film) -> (Vec<Plane<f32>>, Plane<u32>) {
    let [width, height] = film.size();
    let places: Vec<(u32, u32)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
    let rgb = film.linear_srgb();
    let mut planes: Vec<Plane<f32>> = ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(k, name)| Plane { name, values: rgb.iter().map(|p| p[k]).collect() })
        .collect();
    let mut add = |name: &'static str, value: &dyn Fn(u32, u32) -> f64| {
        planes.push(Plane { name, values: places.iter().map(|&(x, y)| value(x, y) as f32).collect() });
    };
    let hits = |x, y| f64::from(film.pixel(x, y).hits.max(1));
    for (k, name) in ["normal.X", "normal.Y", "normal.Z"].into_iter().enumerate() {
        add(name, &|x, y| film.pixel(x, y).normal[k] / hits(x, y));
    }
    add("depth.Z", &|x, y| film.pixel(x, y).depth / hits(x, y));
    add("variance.Y", &|x, y| film.variance(x, y));
    add("samples.N", &|x, y| f64::from(film.count(x, y)));
    let ids = places.iter().map(|&(x, y)| film.pixel(x, y).id).collect();
    (planes, Plane { name: "barbule.ID", values: ids })
}
