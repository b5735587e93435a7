//! Drawings as pixels.

use tiny_skia::{
    FillRule, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, PixmapPaint, StrokeDash, Transform,
};

use super::drawing::{Drawing, Ink, Item, Picture, Stroke};
use super::text;
use crate::{Error, Result};

/// A px is 1/96 inch.
const PX_PER_METRE: f64 = 96.0 / 0.0254;
/// The largest picture is this many pixels wide or high.
const LARGEST: f64 = 16384.0;

pub(super) fn write(drawing: &Drawing, notes: &[(&str, &str)]) -> Result<Vec<u8>> {
    let scale = drawing.resolution;
    // Rounding is no pixel more.
    let pixels = |length: f64| (length * scale - 1e-6).ceil();
    let (width, height) = (pixels(drawing.width), pixels(drawing.height));
    let page =
        (width <= LARGEST && height <= LARGEST).then(|| Pixmap::new(width as u32, height as u32)).flatten();
    let Some(mut page) = page else {
        return Err(Error::input(format!(
            "a picture of {width} by {height} pixels is too large; write the figure as .svg or .pdf, or smaller"
        )));
    };
    page.fill(tiny_skia::Color::WHITE);
    items(&mut page, &drawing.items, scale, None);
    // The page is opaque, so its colours are not premultiplied by anything but 1.
    let rgb: Vec<u8> = page.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let per_metre = Some((scale * PX_PER_METRE).round() as u32);
    encode(page.width() as usize, page.height() as usize, png::ColorType::Rgb, &rgb, per_metre, notes)
}

/// A PNG of sRGB pixels from the upper left corner, with `notes` (name, text) in it.
///
/// # Errors
/// No pixels, or not `width·height` of them.
pub fn encode_png(width: usize, height: usize, rgb: &[[u8; 3]], notes: &[(&str, &str)]) -> Result<Vec<u8>> {
    encode(width, height, png::ColorType::Rgb, rgb.as_flattened(), None, notes)
}

pub(super) fn encode_picture(picture: &Picture) -> Vec<u8> {
    // A picture without pixels shows nothing.
    encode(picture.width, picture.height, png::ColorType::Rgba, picture.rgba.as_flattened(), None, &[])
        .unwrap_or_default()
}

fn encode(
    width: usize,
    height: usize,
    colour: png::ColorType,
    data: &[u8],
    per_metre: Option<u32>,
    notes: &[(&str, &str)],
) -> Result<Vec<u8>> {
    let refuse = |e: png::EncodingError| Error::machine(format!("no PNG of {width} by {height} pixels: {e}"));
    let size = |n: usize| u32::try_from(n).unwrap_or(0);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size(width), size(height));
    encoder.set_color(colour);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_pixel_dims(per_metre.map(|n| png::PixelDimensions {
        xppu: n,
        yppu: n,
        unit: png::Unit::Meter,
    }));
    for (name, text) in notes {
        encoder.add_itxt_chunk((*name).to_owned(), (*text).to_owned()).map_err(refuse)?;
    }
    let mut writer = encoder.write_header().map_err(refuse)?;
    writer.write_image_data(data).map_err(refuse)?;
    writer.finish().map_err(refuse)?;
    Ok(bytes)
}

fn items(page: &mut Pixmap, list: &[Item], factor: f64, mask: Option<&Mask>) {
    let scale = Transform::from_scale(factor as f32, factor as f32);
    for item in list {
        match item {
            Item::Path { runs, closed, fill, stroke } => {
                if let Some(path) = path(runs, *closed) {
                    draw(page, &path, *fill, stroke.as_ref(), scale, mask);
                }
            }
            Item::Circle { center, radius, fill, stroke } => {
                let circle = PathBuilder::from_circle(center[0] as f32, center[1] as f32, *radius as f32);
                if let Some(path) = circle {
                    draw(page, &path, *fill, stroke.as_ref(), scale, mask);
                }
            }
            Item::Text { at, size, text, anchor, turn, ink } => {
                let transform = Transform::from_translate(-anchor.before(text, *size) as f32, 0.0)
                    .post_rotate(-*turn as f32)
                    .post_translate(at[0] as f32, at[1] as f32)
                    .post_concat(scale);
                if let Some(path) = text::outline(text, *size) {
                    page.fill_path(&path, &paint(*ink), FillRule::Winding, transform, mask);
                }
            }
            Item::Picture { area, picture } => stretched(page, area.map(|v| v * factor), picture, mask),
            Item::Clip { area, items: inner } => {
                let [x, y, w, h] = area.map(|v| v as f32);
                let rectangle = tiny_skia::Rect::from_xywh(x, y, w, h);
                let (Some(rectangle), Some(mut mask)) = (rectangle, Mask::new(page.width(), page.height()))
                else {
                    continue;
                };
                mask.fill_path(&PathBuilder::from_rect(rectangle), FillRule::Winding, true, scale);
                items(page, inner, factor, Some(&mask));
            }
        }
    }
}

fn path(runs: &[Vec<[f64; 2]>], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for run in runs {
        for (i, [x, y]) in run.iter().enumerate() {
            if i == 0 {
                builder.move_to(*x as f32, *y as f32);
            } else {
                builder.line_to(*x as f32, *y as f32);
            }
        }
        if closed {
            builder.close();
        }
    }
    builder.finish()
}

fn paint(ink: Ink) -> Paint<'static> {
    let [r, g, b] = ink.rgb;
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(r, g, b, (ink.opacity.clamp(0.0, 1.0) * 255.0).round() as u8);
    paint
}

fn draw(
    page: &mut Pixmap,
    path: &Path,
    fill: Option<Ink>,
    stroke: Option<&Stroke>,
    at: Transform,
    mask: Option<&Mask>,
) {
    if let Some(ink) = fill {
        page.fill_path(path, &paint(ink), FillRule::EvenOdd, at, mask);
    }
    if let Some(stroke) = stroke {
        let look = tiny_skia::Stroke {
            width: stroke.width as f32,
            line_join: LineJoin::Round,
            dash: StrokeDash::new(stroke.dash.iter().map(|d| *d as f32).collect(), 0.0),
            ..tiny_skia::Stroke::default()
        };
        page.stroke_path(path, &paint(stroke.ink), &look, at, mask);
    }
}

/// Pixels over a rectangle of the page, each as a block without smoothing.
fn stretched(page: &mut Pixmap, area: [f64; 4], picture: &Picture, mask: Option<&Mask>) {
    let size = |n: usize| u32::try_from(n).unwrap_or(0);
    let Some(mut pixels) = Pixmap::new(size(picture.width), size(picture.height)) else { return };
    for (pixel, [r, g, b, a]) in pixels.pixels_mut().iter_mut().zip(&picture.rgba) {
        *pixel = tiny_skia::ColorU8::from_rgba(*r, *g, *b, *a).premultiply();
    }
    let [x, y, w, h] = area;
    let transform =
        Transform::from_scale((w / picture.width as f64) as f32, (h / picture.height as f64) as f32)
            .post_translate(x as f32, y as f32);
    page.draw_pixmap(0, 0, pixels.as_ref(), &PixmapPaint::default(), transform, mask);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_keep_their_colours_and_carry_their_notes() {
        let mut drawing = Drawing::new(4.0, 4.0);
        let rgba = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 9, 9, 255]];
        drawing.items.push(Item::Picture {
            area: [0.0, 0.0, 4.0, 4.0],
            picture: Picture { width: 2, height: 2, rgba },
        });
        let bytes = write(&drawing, &[("command", "barbule film")]).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (8, 8));
        assert_eq!((&pixels[..3], &pixels[21..24]), (&[255, 0, 0][..], &[0, 255, 0][..]));
        assert_eq!((&pixels[24 * 7..24 * 7 + 3], &pixels[189..]), (&[0, 0, 255][..], &[9, 9, 9][..]));
        assert_eq!(reader.info().utf8_text[0].keyword, "command");
        // 192 pixels per inch.
        assert_eq!(reader.info().pixel_dims.unwrap().xppu, 7559);
    }

    #[test]
    fn pictures_that_are_too_large_are_refused() {
        assert!(write(&Drawing::new(1e6, 10.0), &[]).unwrap_err().to_string().contains("too large"));
    }
}
