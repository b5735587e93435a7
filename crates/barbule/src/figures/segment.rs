//! Segments in three dimensions: a cut across and a cut along, to scale, as in the supplement's figure 49.

use super::section::{FONT, HEADING, MARGIN, blend, legend, scale_bar_of, shade};
use crate::Result;
use crate::plot::{Anchor, Drawing, Ink, Item, Page, Picture, Stroke, text};
use crate::structure::{Cut, CutLayer, Plane, Segment};

/// Width of the page and of a cut's picture, px.
const PAGE: f64 = 1000.0;
/// Points of a picture across, and for each point of the page.
const POINTS: usize = 1400;
/// Zooms show so much, µm.
const ZOOM_UM: f64 = 5.0;
/// What of a barbule is shown below its top, as a part of a cut's extent, at most.
const DEEPEST: f64 = 0.5;

/// One cut on the page.
struct Shown {
    heading: String,
    cut: Cut,
    /// Lowest and highest z, µm.
    between: [f64; 2],
    wide: f64,
}

/// Draws both cuts of a segment, each whole and its middle, with the media's legend.
///
/// # Errors
/// As [`Segment::cut`].
pub fn segment(segment: &Segment, title: &str, page: &Page) -> Result<Drawing> {
    let zoom_um = ZOOM_UM.min(segment.length_um).min(segment.section.width_um);
    let wide = PAGE - 2.0 * MARGIN;
    let half = 0.5 * (wide - MARGIN);
    let asked = [
        ("Across the barbule: x and z at y = 0", Plane::Across, segment.section.width_um, wide),
        ("Along it: y and z at x = 0", Plane::Along, segment.length_um, wide),
        ("Across, the middle", Plane::Across, zoom_um, half),
        ("Along, the middle", Plane::Along, zoom_um, half),
    ];
    let shown: Vec<Shown> = asked
        .into_iter()
        .map(|(heading, plane, extent, wide)| {
            let cut = segment.cut(plane, extent, POINTS)?;
            Ok(Shown { heading: heading.to_owned(), between: between(&cut, extent), cut, wide })
        })
        .collect::<Result<_>>()?;
    Ok(page.lay_out(FONT, |_| lay_out(segment, title, &shown)))
}

/// Lowest and highest z that a cut shows.
fn between(cut: &Cut, extent: f64) -> [f64; 2] {
    let high = cut.top_um.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = cut.top_um.iter().copied().fold(f64::INFINITY, f64::min);
    let depth = |layers: &Vec<CutLayer>| layers.iter().map(|layer| layer.height_um).sum::<f64>();
    let deepest = cut.layers.iter().map(depth).fold(0.0, f64::max).min(DEEPEST * extent);
    let pad = 0.02 * extent;
    [low - deepest - pad, high + pad]
}

fn lay_out(segment: &Segment, title: &str, shown: &[Shown]) -> Drawing {
    let wide = PAGE - 2.0 * MARGIN;
    let title = text::wrapped(title, HEADING, wide, 3);
    let mut drawing = Drawing::new(PAGE, 0.0);
    for (line, text) in title.iter().enumerate() {
        drawing.text([MARGIN, 32.0 + 22.0 * line as f64], HEADING, Anchor::Start, text.clone());
    }
    let mut y = 20.0 + 24.0 * title.len() as f64;
    let (mut x, mut tallest) = (MARGIN, 0.0_f64);
    for cut in shown {
        if x + cut.wide > PAGE - MARGIN + 1.0 {
            (x, y, tallest) = (MARGIN, y + tallest, 0.0);
        }
        tallest = tallest.max(picture(&mut drawing, cut, [x, y]));
        x += cut.wide + MARGIN;
    }
    let legend = legend(&segment.section, wide);
    drawing.height = y + tallest + legend.height + 20.0;
    drawing.place(legend, [MARGIN, y + tallest + 5.0]);
    drawing
}

/// Draws a cut under its heading and returns the height that all of it takes.
fn picture(drawing: &mut Drawing, shown: &Shown, [x, y]: [f64; 2]) -> f64 {
    let Shown { heading, cut, between: [low, high], wide } = shown;
    let columns = cut.layers.len();
    let rows = ((high - low) / cut.step_um).ceil().max(1.0) as usize;
    let mut rgba = vec![[255; 4]; columns * rows];
    for (column, layers) in cut.layers.iter().enumerate() {
        let mut edges = layers.iter().scan(cut.top_um[column], |z, layer| {
            *z -= layer.height_um;
            Some((*z, layer))
        });
        let mut layer = edges.next();
        for row in 0..rows {
            let z = high - (row as f64 + 0.5) * cut.step_um;
            if z > cut.top_um[column] {
                continue;
            }
            while layer.is_some_and(|(bottom, _)| z < bottom) {
                let next = edges.next();
                if next.is_none() {
                    break;
                }
                layer = next;
            }
            let Some((_, CutLayer { media: (a, b, fraction), .. })) = layer else { continue };
            let [r, g, b] = blend(shade(a), shade(b), *fraction);
            rgba[row * columns + column] = [r, g, b, 255];
        }
    }
    let scale = wide / (columns as f64 * cut.step_um);
    let area = [x, y + 26.0, *wide, rows as f64 * cut.step_um * scale];
    drawing.text([x, y + 18.0], FONT, Anchor::Start, heading.clone());
    drawing.items.push(Item::Picture { area, picture: Picture { width: columns, height: rows, rgba } });
    drawing.rectangle(area, None, Some(Stroke::solid(Ink::of([120, 120, 120]), 1.0)));
    scale_bar_of(drawing, area, scale);
    area[3] + 80.0
}
