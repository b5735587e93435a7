//! A film as a picture: bytes for a PNG, channels for an EXR.

use std::sync::Arc;

use super::cryptomatte::{By, matte};
use super::film::Film;
use super::planes::Channel;
use super::tone;
use crate::scene::backdrop::{Backdrop, gradient};
use crate::scene::description::ToneWord;
use crate::spectrum::colour::{into_gamut, rgb_from_xyz};
use crate::spectrum::sensor::Sensor;

/// How a film becomes a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Development {
    /// Factor from radiance to linear values.
    pub exposure: f64,
    /// What stands behind the scene. The film must have been made without a sky unless it is the sky.
    pub backdrop: Backdrop,
    /// Whether an EXR's R, G and B stay negative where a colour lies outside sRGB.
    pub keeps_gamut: bool,
    /// The curve from linear values to the screen's.
    pub tone: ToneWord,
    /// What linear sRGB is multiplied with before exposure so that another light than daylight looks white; an EXR stays as it is.
    pub balance: Option<[[f64; 3]; 3]>,
    /// CIE XYZ of the pixels, row by row, in place of the film's own: what is left of it without noise.
    pub denoised: Option<Arc<[[f32; 3]]>>,
}

impl Development {
    /// With this exposure, in front of the sky.
    #[must_use]
    pub fn exposed(exposure: f64) -> Self {
        Self {
            exposure,
            backdrop: Backdrop::Sky,
            keeps_gamut: false,
            tone: ToneWord::Plain,
            balance: None,
            denoised: None,
        }
    }

    /// CIE XYZ of a pixel, without its noise where that was taken away.
    fn xyz(&self, film: &Film, x: u32, y: u32) -> [f64; 3] {
        match &self.denoised {
            Some(pixels) => pixels[y as usize * film.size()[0] as usize + x as usize].map(f64::from),
            None => film.xyz(x, y),
        }
    }

    /// Linear sRGB as its light is to look.
    fn balanced(&self, rgb: [f64; 3]) -> [f64; 3] {
        match &self.balance {
            Some(matrix) => matrix.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]),
            None => rgb,
        }
    }

    /// Linear sRGB (1 is the screen's white) behind a pixel after exposure and tone curve; nothing where the film has its
    /// own background or shows none.
    fn shown_behind(&self, x: u32, y: u32, size: [u32; 2]) -> Option<[f64; 3]> {
        match &self.backdrop {
            Backdrop::Sky | Backdrop::None => None,
            Backdrop::Colour(colour) => Some(*colour),
            Backdrop::Gradient(colours) => Some(gradient(colours, y, size[1])),
            Backdrop::Picture(picture) => {
                let linear = picture.behind(x, y, size);
                let is_radiance = picture.is_radiance();
                Some(if is_radiance {
                    tone::shown(self.tone, self.balanced(linear).map(|v| v * self.exposure))
                } else {
                    linear
                })
            }
        }
    }

    /// The same as radiance, before exposure.
    fn radiance_behind(&self, x: u32, y: u32, size: [u32; 2]) -> Option<[f64; 3]> {
        match &self.backdrop {
            Backdrop::Sky | Backdrop::None => None,
            Backdrop::Colour(colour) => Some(colour.map(|v| v / self.exposure)),
            Backdrop::Gradient(colours) => Some(gradient(colours, y, size[1]).map(|v| v / self.exposure)),
            Backdrop::Picture(picture) => {
                let scale = if picture.is_radiance() { 1.0 } else { 1.0 / self.exposure };
                Some(picture.behind(x, y, size).map(|v| v * scale))
            }
        }
    }
}

/// 8-bit pixels, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bytes {
    /// RGB, or RGBA (alpha last, not multiplied into the colours).
    pub values: Vec<u8>,
    /// Whether there is alpha.
    pub has_alpha: bool,
}

/// A film in 8 bits, after exposure and the tone curve of [`tone`]; with alpha where nothing stands behind.
#[must_use]
pub fn bytes(film: &Film, development: &Development) -> Bytes {
    let size = film.size();
    let has_alpha = development.backdrop == Backdrop::None;
    let mut values = Vec::with_capacity(size[0] as usize * size[1] as usize * if has_alpha { 4 } else { 3 });
    for (x, y) in places(size) {
        // As radiance is summed up, in single precision.
        let rgb = rgb_from_xyz(development.xyz(film, x, y)).map(|v| f64::from(v as f32));
        let rgb = development.balanced(rgb).map(|v| v * development.exposure);
        let alpha = film.alpha(x, y).clamp(0.0, 1.0);
        let full = if alpha > 0.0 { rgb.map(|v| v / alpha) } else { rgb };
        match development.shown_behind(x, y, size) {
            Some(behind) => {
                let front = tone::shown(development.tone, full);
                let mixed = std::array::from_fn(|k| front[k] * alpha + behind[k] * (1.0 - alpha));
                values.extend(tone::encoded(mixed));
            }
            None if has_alpha => {
                values.extend(tone::to_bytes(development.tone, full));
                values.push((255.0 * alpha + 0.5) as u8);
            }
            None => values.extend(tone::to_bytes(development.tone, rgb)),
        }
    }
    Bytes { values, has_alpha }
}

/// Depth of what is nowhere, mm, as other renderers have it.
pub const FAR_MM: f64 = 1e10;

/// The planes of a picture, and what their readers must know.
#[derive(Debug, Clone, PartialEq)]
pub struct Planes {
    /// All but identities.
    pub floats: Vec<Channel<f32>>,
    /// Identities of barbules, barbs and shaft.
    pub identities: Channel<u32>,
    /// Names and texts that compositors look for in the header.
    pub attributes: Vec<(String, String)>,
}

/// Linear sRGB and XYZ (both without exposure, multiplied with alpha), alpha, normal, depth in mm, variance of the luminance's
/// mean, sample count and identities; where the film keeps them albedo, mattes and spectral bands. Of other sensors than the human
/// eye their channels in place of XYZ, and sRGB where they have colours. Without noise are sRGB alone; what it was taken from stands beside it. `objects`: names of the scene's objects.
#[must_use]
pub fn planes(film: &Film, development: &Development, objects: &[String]) -> Planes {
    let (size, sensor) = (film.size(), &film.planes().sensor);
    let mut floats = Vec::new();
    let mut add = |names: &[&str], values: &dyn Fn(u32, u32) -> Vec<f64>| {
        let mut planes: Vec<Channel<f32>> =
            names.iter().map(|name| Channel { name: (*name).to_owned(), values: Vec::new() }).collect();
        for (x, y) in places(size) {
            for (plane, value) in planes.iter_mut().zip(values(x, y)) {
                plane.values.push(value as f32);
            }
        }
        floats.append(&mut planes);
    };
    let own: Vec<String> = sensor.channels().iter().map(|curve| channel_name(sensor, &curve.name)).collect();
    let own: Vec<&str> = own.iter().map(String::as_str).collect();
    let inside = |rgb| if development.keeps_gamut { rgb } else { into_gamut(rgb) };
    let colours = |x, y| {
        let (rgb, alpha) = (inside(rgb_from_xyz(development.xyz(film, x, y))), film.alpha(x, y));
        match development.radiance_behind(x, y, size) {
            Some(behind) => (0..3).map(|k| rgb[k] + behind[k] * (1.0 - alpha)).chain([1.0]).collect(),
            None => rgb.into_iter().chain([alpha]).collect(),
        }
    };
    if sensor.has_colours() {
        add(&["R", "G", "B", "A"], &colours);
    } else {
        add(&["A"], &|x, y| vec![film.alpha(x, y)]);
    }
    if development.denoised.is_some() {
        add(&["noisy.R", "noisy.G", "noisy.B"], &|x, y| inside(rgb_from_xyz(film.xyz(x, y))).into());
    }
    add(&own, &|x, y| film.channels(x, y));
    let hits = |x, y| f64::from(film.pixel(x, y).hits.max(1));
    add(&["normal.X", "normal.Y", "normal.Z"], &|x, y| {
        film.pixel(x, y).normal.map(|sum| sum / hits(x, y)).into()
    });
    add(&["depth.Z"], &|x, y| {
        let pixel = film.pixel(x, y);
        vec![if pixel.hits > 0 { pixel.depth / hits(x, y) } else { FAR_MM }]
    });
    add(&[if sensor.is_human() { "variance.Y" } else { "variance.mean" }], &|x, y| vec![film.variance(x, y)]);
    add(&["samples.N"], &|x, y| vec![f64::from(film.count(x, y))]);
    if film.planes().compositing {
        let albedo = |x, y| film.albedo(x, y).unwrap_or_default();
        if sensor.is_human() {
            add(&["albedo.R", "albedo.G", "albedo.B"], &|x, y| match albedo(x, y)[..] {
                [x, y, z] => into_gamut(rgb_from_xyz([x, y, z])).into(),
                _ => vec![0.0; 3],
            });
        } else {
            let names: Vec<String> = own.iter().map(|name| name.replacen("CH", "albedo", 1)).collect();
            add(&names.iter().map(String::as_str).collect::<Vec<_>>(), &albedo);
        }
    }
    let bands = film.planes().spectral.nm();
    let names: Vec<String> = bands.iter().map(|nm| band_name(*nm)).collect();
    add(&names.iter().map(String::as_str).collect::<Vec<_>>(), &|x, y| film.spectrum(x, y));
    let mut attributes = Vec::new();
    if film.planes().compositing {
        for (by, layer) in [(By::Shape, "CryptoObject"), (By::Object, "CryptoMaterial")] {
            let matte = matte(film, objects, by, layer);
            floats.extend(matte.planes);
            attributes.extend(matte.attributes);
        }
    }
    if !bands.is_empty() {
        attributes.push(("spectralLayoutVersion".to_owned(), "1.0".to_owned()));
        attributes.push(("emissiveUnits".to_owned(), "relative".to_owned()));
    }
    let values = places(size).map(|(x, y)| film.pixel(x, y).id).collect();
    Planes { floats, identities: Channel { name: "barbule.ID".to_owned(), values }, attributes }
}

/// The name of a sensor's channel as a plane.
fn channel_name(sensor: &Sensor, channel: &str) -> String {
    format!("{}.{channel}", if sensor.is_human() { "XYZ" } else { "CH" })
}

/// The name of a spectral plane: unpolarized radiance, as in `S0.452,5nm` (Fichet et al. 2021; points would part layers).
fn band_name(nm: f64) -> String {
    format!("S0.{}nm", format!("{nm:?}").replace('.', ","))
}

fn places([width, height]: [u32; 2]) -> impl Iterator<Item = (u32, u32)> {
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}
