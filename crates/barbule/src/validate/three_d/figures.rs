//! Invariant barbules and segments as pictures: hemispheres in colour, and what goes across and along.

use super::{Comparison, Found, PIXELS};
use crate::plot::{Anchor, Axis, Curve, Drawing, Figure, Item, Picture};
use crate::spectrum::colour::{Illuminant, Observer, Weights, display, luminance};

/// Size of a hemisphere on the page, px.
const SIZE: f64 = 150.0;
const APART: f64 = 8.0;
const LEFT: f64 = 150.0;
const TOP: f64 = 62.0;
const FONT: f64 = 13.0;

/// Marginals along y are drawn so far.
const ALONG: f64 = 0.4;

/// The part of pixels that may be brighter than white.
const BRIGHTER: f64 = 0.002;

impl Comparison {
    /// Every figure with its file's name.
    #[must_use]
    pub fn figures(&self) -> Vec<(String, Drawing)> {
        let mut all = vec![("hemispheres.svg".to_owned(), self.hemispheres())];
        let middle = self.plan.wavelengths.len() / 2;
        for found in &self.found {
            let found = &found[middle];
            let [theta, phi] = found.direction_deg;
            all.push((format!("across-{theta:.0}-{phi:.0}.svg"), self.across(found)));
            all.push((format!("along-{theta:.0}-{phi:.0}.svg"), self.along(found)));
        }
        all
    }

    /// Rows of simulations and columns of directions; the smooth ones share an exposure in each column, and so do the
    /// instances.
    fn hemispheres(&self) -> Drawing {
        let weights = Observer::under(Illuminant::D65).weights(&self.plan.wavelengths);
        let mean = format!("mean of {}", self.plan.instances);
        let mut drawing = Drawing::new(LEFT + self.pictures.len() as f64 * (SIZE + APART) + APART, 0.0);
        let title = format!("{}: f over outgoing directions, x right, y up", self.plan.structure.name());
        drawing.text([APART, 22.0], FONT + 2.0, Anchor::Start, title);
        let mut rows = 0;
        for (column, pictures) in self.pictures.iter().enumerate() {
            let x = LEFT + column as f64 * (SIZE + APART);
            let [theta, phi] = self.plan.direction_deg(column);
            let heading = format!("θ {theta:.0}°, φ {phi:.0}°");
            drawing.text([x + 0.5 * SIZE, TOP - 8.0], FONT - 1.0, Anchor::Middle, heading);
            let shown = [
                ("2.5D BRDF, smooth".to_owned(), &pictures.brdf[0], false),
                (format!("2.5D, {mean}"), &pictures.flat[0], false),
                (format!("3D, {mean}"), &pictures.segments[0], false),
                ("2.5D BRDF, instance".to_owned(), &pictures.brdf[1], true),
                ("2.5D, instance 0".to_owned(), &pictures.flat[1], true),
                ("3D, instance 0".to_owned(), &pictures.segments[1], true),
            ];
            let exposures =
                [&pictures.segments[0], &pictures.segments[1]].map(|kind| exposure(&weights, kind));
            let kept: Vec<_> = shown.iter().filter(|(_, values, _)| !values.is_empty()).collect();
            rows = kept.len();
            for (row, (name, values, is_instance)) in kept.into_iter().enumerate() {
                let y = TOP + row as f64 * (SIZE + APART);
                if column == 0 {
                    drawing.text([LEFT - 8.0, y + 0.5 * SIZE], FONT - 1.0, Anchor::End, name.clone());
                }
                let exposure = exposures[usize::from(*is_instance)];
                let rgba = (0..PIXELS * PIXELS).map(|at| {
                    // Pictures begin at the top.
                    let at = (PIXELS - 1 - at / PIXELS) * PIXELS + at % PIXELS;
                    if !is_inside(at) {
                        return [0; 4];
                    }
                    let [r, g, b] = display(colour(&weights, values, at).map(|value| value * exposure));
                    [r, g, b, 255]
                });
                let picture = Picture { width: PIXELS, height: PIXELS, rgba: rgba.collect() };
                drawing.items.push(Item::Picture { area: [x, y, SIZE, SIZE], picture });
            }
        }
        drawing.height = TOP + rows as f64 * (SIZE + APART) + APART;
        drawing
    }

    fn title(&self, found: &Found) -> String {
        let [theta, phi] = found.direction_deg;
        format!(
            "{}, {} nm, θ_i = {theta:.0}°, φ_i = {phi:.0}°",
            self.plan.structure.name(),
            found.wavelength_nm
        )
    }

    fn across(&self, found: &Found) -> Drawing {
        let axis = Axis::with_range("x of ω_o", -1.0, 1.0);
        let mut figure = Figure::new(self.title(found), axis, Axis::new("light per unit of x"));
        figure.curves.push(Curve::line("3D", curve(&found.over_x, 2)));
        figure.curves.push(Curve::line("2.5D", curve(&found.over_x, 1)));
        figure.legend = format!("mean of {}", self.plan.instances);
        figure.footnote = Some(format!(
            "reflected: {:.4} 2.5D, {:.4} 3D; widths {:.4} and {:.4}",
            found.flat.reflected, found.segments.reflected, found.flat.across[1], found.segments.across[1]
        ));
        figure.draw()
    }

    fn along(&self, found: &Found) -> Drawing {
        let axis = Axis::with_range("y of ω_o + y of ω_i", -ALONG, ALONG);
        let mut figure = Figure::new(self.title(found), axis, Axis::logarithmic("light per unit of y"));
        let shown: Vec<[f64; 3]> = found.over_y.iter().filter(|row| row[0].abs() <= ALONG).copied().collect();
        figure.curves.push(Curve::line("3D", curve(&shown, 2)));
        let brightest = shown.iter().map(|row| row[2]).fold(0.0, f64::max);
        let [low, high] = [1e-4, 2.0].map(|part| part * brightest);
        let cut = |[u, value]: [f64; 2]| [u, if value < low { f64::NAN } else { value }];
        let assumed = curve(&shown, 1).into_iter().map(cut).collect();
        figure.curves.push(Curve::line(format!("2.5D, σ = {}", self.sigma), assumed));
        figure.y.range = Some([low, high]);
        figure.legend = format!("mean of {}", self.plan.instances);
        figure.footnote = Some(format!(
            "σ of 3D by the second moment: {:.4}; the window alone {:.4}; {:.1} % of the light lie beyond it",
            found.sigma.second_moment,
            found.sigma.window,
            1e2 * found.sigma.beyond
        ));
        figure.draw()
    }
}

fn curve(rows: &[[f64; 3]], side: usize) -> Vec<[f64; 2]> {
    rows.iter().map(|row| [row[0], row[side]]).collect()
}

fn is_inside(at: usize) -> bool {
    let centre = |k: usize| (2 * k + 1) as f64 / PIXELS as f64 - 1.0;
    centre(at % PIXELS).hypot(centre(at / PIXELS)) < 1.0
}

/// Linear sRGB of a pixel.
fn colour(weights: &Weights, values: &[Vec<f64>], at: usize) -> [f64; 3] {
    weights.linear_rgb(&values.iter().map(|row| row[at]).collect::<Vec<_>>())
}

/// The exposure with which but a few pixels of a picture are below white.
fn exposure(weights: &Weights, values: &[Vec<f64>]) -> f64 {
    let inside = (0..PIXELS * PIXELS).filter(|at| is_inside(*at));
    let mut all: Vec<f64> = inside.map(|at| luminance(colour(weights, values, at))).collect();
    all.sort_by(f64::total_cmp);
    let white = all[((1.0 - BRIGHTER) * all.len() as f64) as usize];
    if white > 0.0 { 0.9 / white } else { 1.0 }
}
