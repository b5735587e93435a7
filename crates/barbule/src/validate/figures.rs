//! Comparisons as figures: colours over the azimuth, and intensities at single wavelengths.

use super::{Comparison, Incidence};
use crate::plot::{Anchor, Axis, Curve, Drawing, Figure, Ink, Item, Picture, Stroke};
use crate::spectrum::colour::display;

/// Width and height of a strip, px.
const STRIP: [f64; 2] = [560.0, 34.0];
/// Left of the strips, and between two incidences.
const LEFT: f64 = 92.0;
const APART: f64 = 34.0;
const TOP: f64 = 46.0;
const FONT: f64 = 13.0;

impl Comparison {
    /// Every figure with its file's name.
    #[must_use]
    pub fn figures(&self) -> Vec<(String, Drawing)> {
        let mut all = vec![("colours.svg".to_owned(), self.strips())];
        let last = self.wavelengths_nm.len() - 1;
        let mut shown = vec![0, last];
        shown.dedup();
        for found in &self.incidences {
            for &w in &shown {
                let name = format!("curves-{:.0}-{}nm.svg", found.phi_deg, self.wavelengths_nm[w]);
                all.push((name, self.curves(found, w)));
            }
        }
        all
    }

    /// The colours of both simulations over the azimuth, one above the other for each incidence.
    fn strips(&self) -> Drawing {
        let each = 2.0 * STRIP[1] + 6.0 + APART;
        let height = TOP + each * self.incidences.len() as f64 + 24.0;
        let mut drawing = Drawing::new(LEFT + STRIP[0] + 28.0, height);
        let title = format!("{}: colours of the reflected light", self.name);
        drawing.text([LEFT, 22.0], FONT + 2.0, Anchor::Start, title);
        for (i, found) in self.incidences.iter().enumerate() {
            let y = TOP + each * i as f64;
            let heading = format!(
                "φ_i = {:.0}°, ΔE00 = {:.1} (all), {:.1} (over azimuths)",
                found.phi_deg, found.delta_e, found.delta_e_pattern
            );
            drawing.text([LEFT, y - 5.0], FONT - 1.0, Anchor::Start, heading);
            for (side, name) in ["fast", "full waves"].into_iter().enumerate() {
                let top = y + side as f64 * (STRIP[1] + 6.0);
                drawing.text([LEFT - 8.0, top + 0.65 * STRIP[1]], FONT, Anchor::End, name);
                drawing.items.push(Item::Picture {
                    area: [LEFT, top, STRIP[0], STRIP[1]],
                    picture: strip(&found.rgb[side]),
                });
            }
        }
        let below = TOP + each * self.incidences.len() as f64 - APART + 4.0;
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

    /// The intensities of both simulations at one wavelength.
    fn curves(&self, found: &Incidence, wavelength: usize) -> Drawing {
        let case = &found.cases[wavelength];
        let points = |values: &[f64]| -> Vec<[f64; 2]> {
            let step = 180.0 / values.len() as f64;
            values.iter().enumerate().map(|(n, value)| [(n as f64 + 0.5) * step - 90.0, *value]).collect()
        };
        let title = format!("{}, {} nm, φ_i = {:.0}°", self.name, case.wavelength_nm, found.phi_deg);
        let x = Axis::with_range("outgoing azimuth φ_o (°)", -90.0, 90.0);
        let mut figure = Figure::new(title, x, Axis::new("intensity (1/rad)"));
        figure.curves.push(Curve::line("full waves", points(&case.full)));
        figure.curves.push(Curve::line("fast", points(&case.fast)));
        figure.legend = "unpolarized".into();
        figure.footnote = Some(format!(
            "reflected: {:.4} fast, {:.4} full waves; correlation {:.3}",
            case.reflected[0],
            case.reflected[1],
            case.correlation()
        ));
        figure.draw()
    }
}

/// One row of colours.
fn strip(rgb: &[[f64; 3]]) -> Picture {
    let rgba = rgb.iter().map(|&linear| {
        let [r, g, b] = display(linear);
        [r, g, b, 255]
    });
    Picture { width: rgb.len(), height: 1, rgba: rgba.collect() }
}
