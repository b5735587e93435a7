//! PNG and EXR.

use std::path::Path;

use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, Text, Vec2,
    WritableImage as _,
};

use super::write_whole;
use crate::{Error, Result};

/// Facts about a picture: name and text.
pub type Facts<'a> = [(&'a str, &'a str)];

/// Writes an 8-bit RGB PNG with text chunks.
///
/// # Errors
/// `rgb` is not width × height × 3 bytes, or the file cannot be written.
pub fn write_png(path: &Path, size: [u32; 2], rgb: &[u8], facts: &Facts<'_>) -> Result<()> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let refuse = |e: png::EncodingError| Error::machine(format!("{}: no PNG ({e})", path.display()));
    for (name, text) in facts {
        encoder.add_itxt_chunk((*name).to_owned(), (*text).to_owned()).map_err(refuse)?;
    }
    let mut writer = encoder.write_header().map_err(refuse)?;
    writer.write_image_data(rgb).map_err(refuse)?;
    writer.finish().map_err(refuse)?;
    write_whole(path, &bytes)
}

/// Writes an EXR (ZIP compression) with named planes of 32-bit floats and of 32-bit integers, and text attributes.
///
/// # Errors
/// A plane of another size, or the file cannot be written.
pub fn write_exr(
    path: &Path,
    size: [u32; 2],
    floats: Vec<(&str, Vec<f32>)>,
    counts: Vec<(&str, Vec<u32>)>,
    facts: &Facts<'_>,
) -> Result<()> {
    let pixels = size[0] as usize * size[1] as usize;
    let floats = floats.into_iter().map(|(name, values)| (name, FlatSamples::F32(values)));
    let counts = counts.into_iter().map(|(name, values)| (name, FlatSamples::U32(values)));
    let mut list = SmallVec::new();
    for (name, samples) in floats.chain(counts) {
        if samples.len() != pixels {
            return Err(Error::input(format!(
                "plane {name} has {} values for {pixels} pixels",
                samples.len()
            )));
        }
        list.push(AnyChannel::new(name, samples));
    }
    let mut attributes = LayerAttributes::named("barbule");
    for (name, text) in facts {
        // The format keeps names such as `version` for itself, and knows Latin letters only.
        let name = format!("barbule_{name}");
        let latin: String = text.chars().map(|c| if c.is_ascii() { c } else { '?' }).collect();
        if let (Some(name), Some(text)) = (Text::new_or_none(&name), Text::new_or_none(&latin)) {
            attributes.other.insert(name, AttributeValue::Text(text));
        }
    }
    let layer = Layer::new(
        Vec2(size[0] as usize, size[1] as usize),
        attributes,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list),
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| Error::machine(format!("{}: no EXR ({e})", path.display())))?;
    write_whole(path, bytes.get_ref())
}
