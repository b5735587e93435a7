//! Comparisons as figures: colours over the azimuth, spectra, and intensities at single wavelengths.

use super::ensemble::{Ensemble, azimuth_deg, pattern};
use super::numbers::{Incidence, tells_colours};
use crate::plot::{Anchor, Axis, Band, Curve, Drawing, Figure, Ink, Item, Picture, Stroke, spectra};
use crate::spectrum::Spectrum;
use crate::spectrum::colour::display;

/// Width and height of a strip, px.
const STRIP: [f64; 2] = [560.0, 34.0];
/// Height of a strip of one of several individuals.
const THIN: f64 = 9.0;
/// Between two strips of a pair, and between two incidences.
const BETWEEN: f64 = 6.0;
const APART: f64 = 34.0;
/// Left of the strips.
const LEFT: f64 = 92.0;
const TOP: f64 = 46.0;
const FONT: f64 = 13.0;

/// Both simulations, in the order of numbers and strips.
const SIDES: [&str; 2] = ["fast", "full waves"];

impl Ensemble {
    /// Every figure with its file's name.
    #[must_use]
    pub fn figures(&self) -> Vec<(String, Drawing)> {
        let mut all = Vec::new();
        if tells_colours(self.wavelengths()) {
            all.push(("colours.svg".to_owned(), self.strips()));
        }
        let nm = self.wavelengths().nm();
        let mut shown = vec![0, nm.len() - 1];
        shown.dedup();
        for (i, found) in self.means().iter().enumerate() {
            if nm.len() > 2 {
                all.push((format!("spectra-{}.svg", short(found.phi_deg)), self.spectra(i)));
            }
            for &w in &shown {
                all.push((format!("curves-{}-{}nm.svg", short(found.phi_deg), nm[w]), self.curves(i, w)));
            }
        }
        all
    }

    fn is_several(&self) -> bool {
        self.individuals.len() > 1
    }

    /// The name, and of how many individuals the mean is shown.
    fn title(&self, of: &str) -> String {
        let name = self.name();
        if self.is_several() {
            format!("{name}{of}, mean of {} individuals", self.individuals.len())
        } else {
            format!("{name}{of}")
        }
    }

    /// The colours of both simulations over the azimuth, one above the other for each incidence; under the mean of several individuals
    /// each of them.
    fn strips(&self) -> Drawing {
        let several = if self.is_several() { self.individuals.len() } else { 0 };
        let each = 2.0 * STRIP[1] + BETWEEN + several as f64 * (2.0 * THIN + BETWEEN) + APART;
        let mut drawing = Drawing::new(LEFT + STRIP[0] + 28.0, TOP);
        drawing.text([LEFT, 22.0], FONT + 2.0, Anchor::Start, self.title(": colours of the reflected light"));
        for (i, found) in self.means().iter().enumerate() {
            let y = TOP + each * i as f64;
            let spread = |of: fn(&Incidence) -> Option<f64>| {
                self.spread(i, of).map_or_else(String::new, |spread| spread.words(1.0, 1))
            };
            let ([from, to], _) = found.beam();
            let heading = format!(
                "φ_i = {:.0}° ({from:.0}° to {to:.0}°): ΔE00 = {} (all), {} (over azimuths)",
                found.phi_deg,
                spread(|one| one.delta_e),
                spread(|one| one.delta_e_pattern)
            );
            drawing.text([LEFT, y - 5.0], FONT - 1.0, Anchor::Start, heading);
            for (side, name) in SIDES.into_iter().enumerate() {
                let top = y + side as f64 * (STRIP[1] + BETWEEN);
                drawing.text([LEFT - 8.0, top + 0.65 * STRIP[1]], FONT, Anchor::End, name);
                draw_strip(&mut drawing, [top, STRIP[1]], &found.rgb[side]);
            }
            let below = y + 2.0 * STRIP[1] + 2.0 * BETWEEN;
            for (k, one) in self.individuals.iter().enumerate().take(several) {
                let top = below + k as f64 * (2.0 * THIN + BETWEEN);
                let label = format!("no. {}", one.instance);
                drawing.text([LEFT - 8.0, top + THIN + 4.0], FONT - 2.0, Anchor::End, label);
                for (side, rgb) in one.incidences[i].rgb.iter().enumerate() {
                    draw_strip(&mut drawing, [top + side as f64 * THIN, THIN], rgb);
                }
            }
        }
        let below = TOP + each * self.means().len() as f64 - APART + 4.0;
        for degrees in [-90, -60, -30, 0, 30, 60, 90] {
            let x = LEFT + STRIP[0] * (f64::from(degrees) + 90.0) / 180.0;
            drawing.line([x, below], [x, below + 5.0], Stroke::solid(Ink::BLACK, 1.0));
            drawing.text([x, below + 19.0], FONT - 1.0, Anchor::Middle, format!("{degrees}"));
        }
        let label = "outgoing azimuth φ_o (°); the brightest of the full waves is white's luminance";
        drawing.text([LEFT + 0.5 * STRIP[0], below + 38.0], FONT - 1.0, Anchor::Middle, label);
        drawing.height = below + 50.0;
        drawing
    }

    /// What both reflect at each wavelength, with the spread of individuals.
    fn spectra(&self, incidence: usize) -> Drawing {
        let found = &self.means()[incidence];
        let band = |side: usize| {
            let std = (0..self.wavelengths().len())
                .map(|w| self.spread_at(incidence, w, |case| case.reflected[side])?.std)
                .collect();
            // The wavelengths have as many values.
            let mean = Spectrum::new(self.wavelengths().clone(), found.reflected(side)).ok()?;
            Some(Band { name: SIDES[side].into(), mean, std, peak: None })
        };
        // Full waves below, as in all figures.
        let bands: Vec<Band> = [1, 0].into_iter().filter_map(band).collect();
        let ([from, to], _) = found.beam();
        let of = format!(", φ_i = {:.0}°", found.phi_deg);
        let mut figure = spectra(&self.title(&of), &bands, &[]);
        figure.y.label = "reflected part of the light".into();
        figure.footnote = Some(format!(
            "light from {from:.0}° to {to:.0}°; power error {} %",
            self.spread(incidence, |one| Some(one.mean_power_error()))
                .map_or_else(String::new, |spread| spread.words(1e2, 1))
        ));
        figure.draw()
    }

    /// The intensities of both simulations at one wavelength.
    fn curves(&self, incidence: usize, wavelength: usize) -> Drawing {
        let found = &self.means()[incidence];
        let case = &found.cases[wavelength];
        let curve = |side: usize| {
            let values = pattern(case, side);
            let points = values.iter().enumerate().map(|(n, value)| [azimuth_deg(n, values.len()), *value]);
            Curve {
                spread: self.pattern_std(incidence, wavelength, side),
                ..Curve::line(SIDES[side], points.collect())
            }
        };
        let of = format!(", {} nm, φ_i = {:.0}°", case.wavelength_nm, found.phi_deg);
        let x = Axis::with_range("outgoing azimuth φ_o (°)", -90.0, 90.0);
        let mut figure = Figure::new(self.title(&of), x, Axis::new("intensity (1/rad)"));
        figure.curves = vec![curve(1), curve(0)];
        figure.legend =
            if self.is_several() { "unpolarized, mean ± 1 std".into() } else { "unpolarized".into() };
        let words = |of: &dyn Fn(&super::Case) -> f64, decimals: usize| {
            let spread = self.spread_at(incidence, wavelength, of);
            spread.map_or_else(String::new, |spread| spread.words(1.0, decimals))
        };
        figure.footnote = Some(format!(
            "reflected: {} fast, {} full waves; correlation {}",
            words(&|case| case.reflected[0], 4),
            words(&|case| case.reflected[1], 4),
            words(&super::Case::correlation, 3)
        ));
        figure.draw()
    }
}

/// Degrees in a file's name, without what radians add.
fn short(degrees: f64) -> f64 {
    (1e6 * degrees).round() / 1e6
}

/// One row of colours, from a height on and so high.
fn draw_strip(drawing: &mut Drawing, [top, height]: [f64; 2], rgb: &[[f64; 3]]) {
    let rgba = rgb.iter().map(|&linear| {
        let [r, g, b] = display(linear);
        [r, g, b, 255]
    });
    let picture = Picture { width: rgb.len(), height: 1, rgba: rgba.collect() };
    drawing.items.push(Item::Picture { area: [LEFT, top, STRIP[0], height], picture });
}
