//! What birds' cones answer to, and where colours lie for them.

use crate::Result;
use crate::material::KERATIN_CLEAR_FROM_NM;
use crate::plot::{Axis, Curve, Drawing, Figure, Ink, Page, Stroke, Tetrahedron};
use crate::spectrum::Spectrum;
use crate::vision::{Eye, Tetrahedral};

/// Wavelengths that are drawn, nm.
const FROM_NM: u32 = 300;
const TO_NM: u32 = 700;

/// What stands below figures of keratin's reflectance in the ultraviolet.
pub const KERATIN_NOTE: &str = "hatched: below 350 nm keratin absorbs, by an unknown amount that is left out";

/// One thing that is seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// What it is called.
    pub name: String,
    /// Its reflectance.
    pub reflectance: Spectrum,
    /// Where it lies; of eyes with four cones.
    pub tetrahedral: Option<Tetrahedral>,
}

/// The sensitivities of an eye's cones, the double ones dashed in black.
#[must_use]
pub fn sensitivities(title: &str, eye: &Eye, page: &Page) -> Drawing {
    let mut figure = Figure::new(
        title,
        Axis::with_range("wavelength (nm)", f64::from(FROM_NM), f64::from(TO_NM)),
        Axis::with_range("answer to a quantum, 1 at the peak", 0.0, 1.05),
    );
    let points = |curve: &crate::spectrum::dense::DenseSpectrum| {
        (FROM_NM..=TO_NM).map(|nm| [f64::from(nm), curve.at(f64::from(nm))]).collect::<Vec<_>>()
    };
    for cone in &eye.cones {
        let name = format!("{}, {:.0} nm", cone.name, cone.peak_nm);
        figure.curves.push(Curve::line(name, points(&cone.sensitivity)));
    }
    if let Some(cone) = &eye.double {
        let stroke = Some(Stroke { ink: Ink::BLACK, width: 1.8, dash: vec![6.0, 3.0] });
        let name = format!("{} cones, {:.0} nm", cone.name, cone.peak_nm);
        figure.curves.push(Curve { stroke, ..Curve::line(name, points(&cone.sensitivity)) });
    }
    figure.draw_on(page)
}

/// Reflectances, and beside them where they lie in the tetrahedron of an eye with four cones. `has_guess`: whether some are of keratin
/// that is taken to be clear in the ultraviolet.
///
/// # Errors
/// None of finite reflectances.
pub fn seen(title: &str, eye: &Eye, things: &[Seen], has_guess: bool, page: &Page) -> Result<Drawing> {
    let mut figure = Figure::new("", Axis::new("wavelength (nm)"), Axis::new("reflectance"));
    for thing in things {
        let spectrum = &thing.reflectance;
        let points = spectrum.wavelengths().iter().zip(spectrum.values()).map(|(&x, &y)| [x, y]).collect();
        figure.curves.push(Curve::line(thing.name.clone(), points));
    }
    if has_guess {
        figure.hatched = Some([f64::from(FROM_NM), KERATIN_CLEAR_FROM_NM]);
        figure.footnote = Some(KERATIN_NOTE.to_owned());
    }
    let chart = figure.draw();
    let [up, short, middle, long] = &eye.cones[..] else { return Ok(page.place(chart.under(title))) };
    let points = things.iter().map(|thing| (thing.name.clone(), thing.tetrahedral.map(|place| place.xyz)));
    let corners = [up, short, middle, long].map(|cone| cone.name.clone());
    let solid = Tetrahedron { corners, points: points.collect() }.draw();
    let mut drawing = Drawing::new(solid.width + chart.width, solid.height.max(chart.height));
    let across = solid.width;
    drawing.place(solid, [0.0, 0.0]);
    drawing.place(chart, [across, 0.0]);
    Ok(page.place(drawing.under(title)))
}
