//! Reflectance spectra with the colours that they are.

use super::axes::{Axis, covering};
use super::figure::{Curve, Figure};
use crate::spectrum::Spectrum;
use crate::spectrum::colour::{Observer, display, held};

/// A mean spectrum with the spread of the individuals behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// What the legend says.
    pub name: String,
    /// Mean reflectance.
    pub mean: Spectrum,
    /// One standard deviation, one number per wavelength of the mean; drawn as a band of twice this height.
    pub std: Option<Vec<f64>>,
}

/// A chart of reflectance spectra: each with its band, and its own colour under D65 as a swatch in the legend.
/// `measured` spectra (name, values) are drawn as points.
#[must_use]
pub fn spectra(title: &str, bands: &[Band], measured: &[(String, Spectrum)]) -> Figure {
    let mut figure = Figure::new(title, Axis::new("wavelength (nm)"), Axis::new("reflectance"));
    let observer = Observer::default();
    let points = |s: &Spectrum| s.wavelengths().iter().zip(s.values()).map(|(&x, &y)| [x, y]).collect();
    for band in bands {
        let mut curve = Curve::line(band.name.clone(), points(&band.mean));
        curve.spread.clone_from(&band.std);
        curve.swatch = Some(display(observer.linear_rgb(&band.mean)));
        figure.curves.push(curve);
    }
    for (name, spectrum) in measured {
        let mut curve = Curve::points(name.clone(), points(spectrum));
        curve.swatch = Some(display(observer.linear_rgb(spectrum)));
        figure.curves.push(curve);
    }
    // A band may reach below zero where individuals differ much, but reflectance does not.
    if figure.curves.iter().flat_map(|c| &c.points).all(|p| p[1] >= 0.0) {
        let tops = figure.curves.iter().flat_map(|c| {
            let spread = |i: usize| c.spread.as_ref().and_then(|s| s.get(i)).copied().unwrap_or(0.0);
            c.points.iter().enumerate().map(move |(i, p)| p[1] + spread(i))
        });
        figure.y.range = Some([0.0, covering(tops.chain([0.0]))[1]]);
    }
    figure.legend = if bands.iter().any(|b| b.std.is_some()) {
        "mean ± 1 std, colour under D65".into()
    } else {
        "colour under D65".into()
    };
    figure.footnote = bands.iter().find_map(|b| held(b.mean.wavelengths()));
    figure
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Wavelengths;

    #[test]
    fn swatches_are_the_spectras_own_colours() {
        let at = Wavelengths::usual();
        let white = Spectrum::new(at.clone(), vec![1.0; 50]).unwrap();
        let red = Spectrum::new(at.clone(), at.iter().map(|w| if *w > 600.0 { 0.8 } else { 0.0 }).collect())
            .unwrap();
        let bands = [Band { name: "white".into(), mean: white, std: Some(vec![0.1; 50]) }];
        let figure = spectra("t", &bands, &[("red".into(), red)]);
        assert_eq!(figure.curves[0].swatch, Some([255; 3]));
        let [r, g, b] = figure.curves[1].swatch.unwrap();
        assert!(r > 150 && g < 100 && b < 50);
        assert!(figure.footnote.unwrap().contains("held"));
        assert_eq!(figure.y.range.unwrap()[0], 0.0);
    }
}
