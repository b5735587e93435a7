//! Colours of four cones in their tetrahedron, seen from a little above.

use super::axes::{MEDIUM, SMALL};
use super::drawing::{Anchor, Drawing, Ink, Item, Stroke};
use super::figure::sign;
use super::palette;
use super::text;

/// Width and height of the tetrahedron, px, and what is free about it.
const SIDE: f64 = 330.0;
const EDGE: f64 = 34.0;
/// From where it is seen, degrees: turned about the vertical, and above the horizon.
const TURN_DEG: f64 = 22.0;
const ABOVE_DEG: f64 = 14.0;
/// The distance of a corner from the centre.
const CORNER: f64 = 0.75;
/// From one line of the legend to the next, px.
const LINE: f64 = 18.0;
/// Letters of a name in the legend.
const WIDEST: f64 = 220.0;

/// Places in a tetrahedron whose centre is the origin and whose corners are 3/4 away from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tetrahedron {
    /// Names of the corners: up, then those of −x, y and x.
    pub corners: [String; 4],
    /// Names and places, in the looks of curves of the same numbers; none where there is no such place.
    pub points: Vec<(String, Option<[f64; 3]>)>,
}

impl Tetrahedron {
    /// Draws it: edges, those behind dashed; the centre as a cross; each point with a thin line down to the base, which shows how deep it
    /// lies, and its look in a legend.
    #[must_use]
    pub fn draw(&self) -> Drawing {
        let width = SIDE + 2.0 * EDGE;
        let mut drawing = Drawing::new(width, SIDE + 2.0 * EDGE + LINE * self.points.len() as f64);
        let scale = SIDE / (2.0 * CORNER);
        let place = |at: [f64; 3]| {
            let [across, up] = seen(at);
            [width / 2.0 + scale * across, EDGE + 0.56 * SIDE - scale * up]
        };
        let root = (CORNER * CORNER - 1.0 / 16.0_f64).sqrt();
        let turned = |angle: f64| {
            let angle = angle.to_radians();
            [root * angle.cos(), root * angle.sin(), -0.25]
        };
        let corners = [[0.0, 0.0, CORNER], turned(-150.0), turned(90.0), turned(-30.0)];
        let line = |a: usize, b: usize, dash: Vec<f64>| Item::Path {
            runs: vec![vec![place(corners[a]), place(corners[b])]],
            closed: false,
            fill: None,
            stroke: Some(Stroke { ink: Ink::of([110, 110, 110]), width: 1.0, dash }),
        };
        // The corner that lies farthest back has the hidden edges.
        let back = (1..4).min_by(|a, b| depth(corners[*a]).total_cmp(&depth(corners[*b]))).unwrap_or(1);
        for a in 0..4 {
            for b in a + 1..4 {
                let hidden = a == back || b == back;
                drawing.items.push(line(a, b, if hidden { vec![4.0, 3.0] } else { Vec::new() }));
            }
        }
        for (name, corner) in self.corners.iter().zip(corners) {
            let [x, y] = place(corner);
            let [middle_x, middle_y] = place([0.0; 3]);
            let away = ((x - middle_x).powi(2) + (y - middle_y).powi(2)).sqrt().max(1.0);
            let at = [x + 16.0 * (x - middle_x) / away, y + 16.0 * (y - middle_y) / away + 4.0];
            drawing.text(at, MEDIUM, Anchor::Middle, name.clone());
        }
        let [x, y] = place([0.0; 3]);
        let thin = Stroke::solid(Ink::BLACK, 1.0);
        drawing.line([x - 4.0, y], [x + 4.0, y], thin.clone());
        drawing.line([x, y - 4.0], [x, y + 4.0], thin);
        for (i, (_, at)) in self.points.iter().enumerate() {
            let (stroke, Some(at)) = (palette::style(i), at) else { continue };
            let faint = Stroke::solid(stroke.ink.with_opacity(0.45), 0.8);
            drawing.line(place(*at), place([at[0], at[1], -0.25]), faint);
            drawing.items.push(sign(place(*at), i, &stroke));
        }
        for (i, (name, _)) in self.points.iter().enumerate() {
            let y = SIDE + 2.0 * EDGE + LINE * i as f64;
            drawing.items.push(sign([EDGE, y - 4.0], i, &palette::style(i)));
            drawing.text([EDGE + 12.0, y], SMALL, Anchor::Start, text::cut(name, SMALL, WIDEST));
        }
        drawing
    }
}

/// Across and up, as it is seen.
fn seen([x, y, z]: [f64; 3]) -> [f64; 2] {
    let (turn, above) = (TURN_DEG.to_radians(), ABOVE_DEG.to_radians());
    let across = x * turn.cos() + y * turn.sin();
    [across, z * above.cos() - depth([x, y, z]) * above.sin()]
}

/// Towards the viewer is more.
fn depth([x, y, _]: [f64; 3]) -> f64 {
    let turn = TURN_DEG.to_radians();
    x * turn.sin() - y * turn.cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Format;

    #[test]
    fn points_have_a_legend_and_what_is_nearer_stands_lower() {
        let solid = Tetrahedron {
            corners: ["UV", "S", "M", "L"].map(str::to_owned),
            points: vec![("grey".into(), Some([0.0; 3])), ("dark".into(), None)],
        };
        let text = String::from_utf8(solid.draw().encode(Format::Svg, &[]).unwrap()).unwrap();
        assert!(text.contains(">grey<") && text.contains(">dark<") && text.contains(">UV<"));
        assert!(!text.contains("NaN"));
        assert!(seen([0.5, -0.5, -0.25])[1] < seen([-0.5, 0.5, -0.25])[1]);
    }
}
