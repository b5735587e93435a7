//! Reflectance spectra with the colours that they are.

use super::axes::{Axis, covering};
use super::drawing::{Ink, Stroke};
use super::figure::{Curve, Figure};
use crate::spectrum::Spectrum;
use crate::spectrum::look::Look;
use crate::spectrum::peaks::Peak;

/// A mean spectrum with the spread of the individuals behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// What the legend says.
    pub name: String,
    /// Mean reflectance.
    pub mean: Spectrum,
    /// One standard deviation, one number per wavelength of the mean; drawn as a band of twice this height.
    pub std: Option<Vec<f64>>,
    /// A peak to be marked: of a series of angles the one that is followed.
    pub peak: Option<Peak>,
}

/// A measured spectrum: a mean, and the samples behind it when there are several.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredBand {
    /// Mean and spread.
    pub band: Band,
    /// The single samples, drawn as thin lines; empty when there is one.
    pub samples: Vec<Spectrum>,
    /// The band that it was measured for, whose colour it takes where there are several measurements.
    pub beside: Option<usize>,
}

/// Signs of a measured spectrum, at most: more would run into each other.
const MOST_SIGNS: usize = 30;

/// A chart of reflectance spectra: each with its band, and with its own colour under D65 as two swatches in the
/// legend, at its true luminance and as bright as a screen can show it. A measured spectrum is dashed and black; several are signs, each in the
/// colour of the band that it belongs to, and not named again.
#[must_use]
pub fn spectra(title: &str, bands: &[Band], measured: &[MeasuredBand]) -> Figure {
    let mut figure = Figure::new(title, Axis::new("wavelength (nm)"), Axis::new("reflectance"));
    let points = |s: &Spectrum| -> Vec<[f64; 2]> {
        s.wavelengths().iter().zip(s.values()).map(|(&x, &y)| [x, y]).collect()
    };
    let curve = |band: &Band| {
        let look = Look::of(&band.mean);
        Curve {
            spread: band.std.clone(),
            swatches: look.colour.map_or_else(Vec::new, |c| vec![c.srgb(), c.srgb_normalized()]),
            ..Curve::line(band.name.clone(), points(&band.mean))
        }
    };
    figure.curves.extend(bands.iter().map(curve));
    let several = measured.len() > 1;
    for one in measured {
        let beside = one.beside.filter(|i| several && *i < bands.len());
        let ink = beside.map_or(Ink::BLACK, |i| figure.stroke(i).ink);
        let thin = Stroke::solid(ink.with_opacity(0.6), 0.7);
        let sample = |s: &Spectrum| Curve { stroke: Some(thin.clone()), ..Curve::line("", points(s)) };
        figure.curves.extend(one.samples.iter().map(sample));
        figure.curves.push(if beside.is_some() {
            let every = one.band.mean.wavelengths().len().div_ceil(MOST_SIGNS);
            let some = points(&one.band.mean).into_iter().step_by(every).collect();
            Curve { stroke: Some(Stroke::solid(ink, 1.0)), ..Curve::points("", some) }
        } else {
            let dashed = Stroke { ink, width: 1.8, dash: vec![6.0, 3.0] };
            Curve { stroke: Some(dashed), ..curve(&one.band) }
        });
    }
    // Without names, so that the legend has none of them, and last, so that all curves keep their looks.
    for (i, peak) in bands.iter().enumerate().filter_map(|(i, band)| Some((i, band.peak?))) {
        let stroke = Some(figure.stroke(i));
        figure.curves.push(Curve { stroke, ..Curve::points("", vec![[peak.nm, peak.reflectance]]) });
    }
    // A band may reach below zero where individuals differ much, but reflectance does not.
    if figure.curves.iter().flat_map(|c| &c.points).all(|p| p[1] >= 0.0) {
        let tops = figure.curves.iter().flat_map(|c| {
            let spread = |i: usize| c.spread.as_ref().and_then(|s| s.get(i)).copied().unwrap_or(0.0);
            c.points.iter().enumerate().map(move |(i, p)| p[1] + spread(i))
        });
        figure.y.range = Some([0.0, covering(tops.chain([0.0]))[1]]);
    }
    let spread = bands.iter().chain(measured.iter().map(|m| &m.band)).any(|b| b.std.is_some());
    figure.legend = match (spread, figure.curves.iter().any(|c| !c.swatches.is_empty())) {
        (true, true) => "mean ± 1 std; colour under D65: true, normalized",
        (true, false) => "mean ± 1 std",
        (false, true) => "colour under D65: true, normalized",
        (false, false) => "",
    }
    .into();
    let signs = bands.iter().any(|band| band.peak.is_some());
    let signs = signs.then(|| "signs: the peak that is followed through the angles, of one order".to_owned());
    let beside =
        several.then(|| "rows of signs: measured, in the colour of the curve beside them".to_owned());
    let notes: Vec<String> = bands
        .iter()
        .find_map(|b| Look::of(&b.mean).colour_note)
        .into_iter()
        .chain(signs)
        .chain(beside)
        .collect();
    figure.footnote = Some(notes.join("; ")).filter(|note| !note.is_empty());
    figure
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Wavelengths;

    fn flat(value: f64) -> Spectrum {
        Spectrum::new(Wavelengths::usual(), vec![value; 50]).unwrap()
    }

    #[test]
    fn swatches_are_the_spectras_own_colours_as_they_are_and_brightened() {
        let at = Wavelengths::usual();
        let red = at.iter().map(|w| if *w > 600.0 { 0.2 } else { 0.0 }).collect();
        let bands = [
            Band { name: "white".into(), mean: flat(1.0), std: Some(vec![0.1; 50]), peak: None },
            Band { name: "red".into(), mean: Spectrum::new(at, red).unwrap(), std: None, peak: None },
        ];
        let figure = spectra("t", &bands, &[]);
        assert_eq!(figure.curves[0].swatches[0], [255; 3]);
        let [[r, g, b], [brighter, ..]] = figure.curves[1].swatches[..] else { panic!() };
        assert!(r > 60 && g < 60 && b < 50 && brighter > 230, "{r} {g} {b} {brighter}");
        assert!(figure.footnote.is_none() && figure.legend.contains("true, normalized"));
        assert_eq!(figure.y.range.unwrap()[0], 0.0);
    }

    #[test]
    fn peaks_of_a_series_are_signs_in_the_looks_of_their_curves() {
        let band = |at: f64, peak: bool| {
            let bell = |nm: &f64| 0.1 + 0.2 * (-0.5 * ((nm - at) / 30.0).powi(2)).exp();
            let mean =
                Spectrum::new(Wavelengths::usual(), Wavelengths::usual().iter().map(bell).collect()).unwrap();
            let found = Look::of(&mean).peak.filter(|_| peak);
            Band { name: format!("{at}"), mean, std: None, peak: found }
        };
        let figure = spectra("t", &[band(480.0, false), band(530.0, true)], &[]);
        assert_eq!(figure.curves.len(), 3);
        let sign = &figure.curves[2];
        assert!((sign.points[0][0] - 530.0).abs() < 0.5 && (sign.points[0][1] - 0.3).abs() < 1e-3);
        assert_eq!((sign.name.as_str(), sign.stroke.clone()), ("", Some(figure.stroke(1))));
        assert!(figure.footnote.unwrap().starts_with("signs: the peak that is followed"));
    }

    #[test]
    fn measured_samples_are_thin_lines_without_names_under_a_dashed_mean() {
        let band = Band { name: "measured".into(), mean: flat(0.3), std: Some(vec![0.1; 50]), peak: None };
        let measured = MeasuredBand { band, samples: vec![flat(0.2), flat(0.4)], beside: None };
        let simulated = Band { name: "simulated".into(), mean: flat(0.3), std: None, peak: None };
        let figure = spectra("t", &[simulated], &[measured]);
        let names: Vec<_> = figure.curves.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["simulated", "", "", "measured"]);
        assert!(figure.curves[1].stroke.as_ref().unwrap().width < 1.0);
        assert!(!figure.curves[3].stroke.as_ref().unwrap().dash.is_empty());
        let svg = figure.draw().encode(crate::plot::Format::Svg, &[]).unwrap();
        assert!(String::from_utf8(svg).unwrap().contains("measured"));
    }

    #[test]
    fn several_measurements_are_signs_in_the_colours_of_their_curves() {
        let band =
            |name: &str, value: f64| Band { name: name.into(), mean: flat(value), std: None, peak: None };
        let simulated = [band("0°", 0.3), band("30°", 0.5)];
        let measured = [0, 1].map(|i| MeasuredBand {
            band: band("measured", 0.2),
            samples: Vec::new(),
            beside: Some(i),
        });
        let figure = spectra("t", &simulated, &measured);
        for i in [0, 1] {
            let curve = &figure.curves[2 + i];
            assert_eq!((figure.stroke(2 + i).ink, curve.name.as_str()), (figure.stroke(i).ink, ""));
            assert!(curve.points.len() <= MOST_SIGNS && curve.points.len() > 10);
        }
        assert!(figure.footnote.unwrap().contains("rows of signs: measured"));
    }
}
