//! Drawings as SVG.

use std::fmt::Write as _;

use base64::prelude::{BASE64_STANDARD, Engine as _};

use super::drawing::{Anchor, Drawing, Ink, Item, Stroke};
use super::raster::encode_picture;

pub(super) fn write(drawing: &Drawing, notes: &[(&str, &str)]) -> String {
    let (w, h) = (Number(drawing.width), Number(drawing.height));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" font-family=\"DejaVu Sans, Verdana, sans-serif\">\n"
    );
    // Writing to a String cannot fail, here and below.
    if !notes.is_empty() {
        out.push_str("<desc>");
        for (name, text) in notes {
            let _ = write!(out, "{}: {}; ", escaped(name), escaped(text));
        }
        out.push_str("</desc>\n");
    }
    let _ = writeln!(out, "<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>");
    let mut clips = 0;
    items(&mut out, &drawing.items, &mut clips);
    out.push_str("</svg>\n");
    out
}

fn items(out: &mut String, list: &[Item], clips: &mut usize) {
    for item in list {
        match item {
            Item::Path { runs, closed, fill, stroke } => {
                out.push_str("<path d=\"");
                for run in runs {
                    for (i, [x, y]) in run.iter().enumerate() {
                        let _ =
                            write!(out, "{}{} {}", if i == 0 { 'M' } else { 'L' }, Number(*x), Number(*y));
                    }
                    if *closed {
                        out.push('Z');
                    }
                }
                out.push('"');
                look(out, *fill, stroke.as_ref());
                out.push_str(" fill-rule=\"evenodd\"/>\n");
            }
            Item::Circle { center, radius, fill, stroke } => {
                let (x, y, r) = (Number(center[0]), Number(center[1]), Number(*radius));
                let _ = write!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"");
                look(out, *fill, stroke.as_ref());
                out.push_str("/>\n");
            }
            Item::Text { at, size, text, anchor, turn, ink } => {
                let (x, y) = (Number(at[0]), Number(at[1]));
                let anchor = match anchor {
                    Anchor::Start => "start",
                    Anchor::Middle => "middle",
                    Anchor::End => "end",
                };
                let _ = write!(
                    out,
                    "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\"",
                    Number(*size)
                );
                if *turn != 0.0 {
                    let _ = write!(out, " transform=\"rotate({} {x} {y})\"", Number(-turn));
                }
                look(out, Some(*ink), None);
                let _ = writeln!(out, ">{}</text>", escaped(text));
            }
            Item::Picture { area, picture } => {
                let [x, y, w, h] = area.map(Number);
                let _ = writeln!(
                    out,
                    "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>",
                    BASE64_STANDARD.encode(encode_picture(picture))
                );
            }
            Item::Clip { area, items: inner } => {
                let [x, y, w, h] = area.map(Number);
                let id = *clips;
                *clips += 1;
                let _ = writeln!(
                    out,
                    "<clipPath id=\"c{id}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>\n<g clip-path=\"url(#c{id})\">"
                );
                items(out, inner, clips);
                out.push_str("</g>\n");
            }
        }
    }
}

fn look(out: &mut String, fill: Option<Ink>, stroke: Option<&Stroke>) {
    match fill {
        Some(ink) => {
            let _ = write!(out, " fill=\"{}\"", hex(ink.rgb));
            if ink.opacity < 1.0 {
                let _ = write!(out, " fill-opacity=\"{}\"", Number(ink.opacity));
            }
        }
        None => out.push_str(" fill=\"none\""),
    }
    let Some(stroke) = stroke else { return };
    let _ = write!(out, " stroke=\"{}\" stroke-width=\"{}\"", hex(stroke.ink.rgb), Number(stroke.width));
    if stroke.ink.opacity < 1.0 {
        let _ = write!(out, " stroke-opacity=\"{}\"", Number(stroke.ink.opacity));
    }
    if !stroke.dash.is_empty() {
        let dash: Vec<_> = stroke.dash.iter().map(|d| Number(*d).to_string()).collect();
        let _ = write!(out, " stroke-dasharray=\"{}\"", dash.join(" "));
    }
    out.push_str(" stroke-linejoin=\"round\"");
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A number with at most three decimals.
struct Number(f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.3}", self.0);
        f.write_str(text.trim_end_matches('0').trim_end_matches('.'))
    }
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_users_cannot_become_markup() {
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.text([0.0, 0.0], 10.0, Anchor::Start, "<script>&\"");
        let svg = write(&drawing, &[("command", "a <b>")]);
        assert!(
            svg.contains("&lt;script&gt;&amp;&quot;") && !svg.contains("<script>") && !svg.contains("<b>")
        );
    }
}
