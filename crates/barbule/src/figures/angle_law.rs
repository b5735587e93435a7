//! Peaks against the angle, and the laws that they follow.

use crate::plot::{Axis, Curve, Drawing, Figure, Page, Stroke, style};
use crate::spectrum::angle_law::AngleLaw;

/// Points of a drawn law.
const POINTS: usize = 61;

/// The followed peaks of one structure.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowedPeaks {
    /// What the legend calls it.
    pub name: String,
    /// The angle θ at which the layers are lit, rad, and the wavelength, nm.
    pub peaks: Vec<(f64, f64)>,
    /// The law that they follow.
    pub law: AngleLaw,
}

/// Peaks as signs, the law of layers as a line and the straight line as dashes, over θ in degrees.
#[must_use]
pub fn angle_law(title: &str, all: &[FollowedPeaks], page: &Page) -> Drawing {
    let mut figure =
        Figure::new(title, Axis::new("angle to the layers θ = E/2 (°)"), Axis::new("peak wavelength (nm)"));
    let end = |one: &FollowedPeaks| one.peaks.iter().map(|peak| peak.0.abs()).fold(0.0, f64::max);
    for (k, one) in all.iter().enumerate() {
        let stroke = style(k);
        let dashed = Stroke { dash: vec![2.0, 3.0], width: 1.0, ..stroke.clone() };
        let angles = || (0..POINTS).map(|i| end(one) * i as f64 / (POINTS - 1) as f64);
        let index = one.law.index.map_or_else(String::new, |n| format!(", n = {:.2}", n.value));
        let name = format!("{}: λ₀ = {:.0} nm{index}", one.name, one.law.normal_nm.value);
        let law = angles().map(|angle| [angle.to_degrees(), one.law.wavelength_nm(angle)]).collect();
        let line = angles().map(|angle| {
            let line = &one.law.line;
            let degrees = angle.to_degrees();
            [degrees, line.a_nm.value - line.b_nm_per_deg.value * 2.0 * degrees]
        });
        let peaks = one.peaks.iter().map(|(angle, nm)| [angle.abs().to_degrees(), *nm]).collect();
        figure.curves.push(Curve { stroke: Some(stroke.clone()), ..Curve::line(name, law) });
        figure.curves.push(Curve { stroke: Some(dashed), ..Curve::line("", line.collect()) });
        figure.curves.push(Curve { stroke: Some(stroke), ..Curve::points("", peaks) });
    }
    figure.footnote = Some("lines: λ₀ √(1 − sin²θ/n²); dots: a − b E; signs: the followed peaks".into());
    figure.draw_on(page)
}
