//! PNG and EXR.

use std::path::Path;

use exr::meta::attribute::AttributeValue;
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, Text, Vec2, WritableImage as _};

use super::write_whole;
use crate::{Error, Result};

/// Facts about a picture: name and text.
pub type Facts<'a> = [(&'a str, String)];

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
        encoder.add_itxt_chunk((*name).to_owned(), text.clone()).map_err(refuse)?;
    }
    let mut writer = encoder.write_header().map_err(refuse)?;
    writer.write_image_data(rgb).map_err(refuse)?;
    writer.finish().map_err(refuse)?;
    write_whole(path, &bytes)
}

/// One channel of an EXR.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Its name, as in `normal.X`.
    pub name: &'static str,
    /// Its values, row by row.
    pub values: ChannelValues,
}

/// Values of an EXR's channel.
#[derive(Debug, Clone)]
pub enum ChannelValues {
    /// 32-bit floats.
    Float(Vec<f32>),
    /// 32-bit unsigned integers: identities.
    Count(Vec<u32>),
}

/// Writes an EXR (ZIP compression, 32-bit channels) with text attributes.
///
/// # Errors
/// A channel of another size, or the file cannot be written.
pub fn write_exr(path: &Path, size: [u32; 2], channels: Vec<Channel>, facts: &Facts<'_>) -> Result<()> {
    let pixels = size[0] as usize * size[1] as usize;
    let mut list = SmallVec::new();
    for channel in channels {
        let samples = match channel.values {
            ChannelValues::Float(values) => FlatSamples::F32(values),
            ChannelValues::Count(values) => FlatSamples::U32(values),
        };
        if samples.len() != pixels {
            return Err(Error::input(format!(
                "channel {} has {} values for {pixels} pixels",
                channel.name,
                samples.len()
            )));
        }
        list.push(AnyChannel::new(channel.name, samples));
    }
    let mut attributes = LayerAttributes::named("barbule");
    for (name, text) in facts {
        // The format knows Latin letters only.
        let latin: String = text.chars().map(|c| if c.is_ascii() { c } else { '?' }).collect();
        if let (Some(name), Some(text)) = (Text::new_or_none(name), Text::new_or_none(&latin)) {
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
