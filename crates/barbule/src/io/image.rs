//! PNG and EXR: pictures are written, skies and backgrounds are read, these from Radiance files too.

use std::path::Path;

use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, MetaData,
    ReadChannels as _, ReadLayers as _, SmallVec, Text, Vec2, WritableImage as _, read,
};

use super::assets::ending;
use super::radiance::{decode_radiance, foretell_radiance};
use super::{read_bytes, write_whole};
use crate::spectrum::colour::decode;
use crate::{Error, Result};

/// Facts about a picture: name and text.
pub type Facts<'a> = [(&'a str, &'a str)];

/// Writes an 8-bit PNG with text chunks, RGB or RGBA.
///
/// # Errors
/// `pixels` is not width × height × 3 or 4 bytes, or the file cannot be written.
pub fn write_png(
    path: &Path,
    size: [u32; 2],
    pixels: &[u8],
    has_alpha: bool,
    facts: &Facts<'_>,
) -> Result<()> {
    let bytes = encode_png(size, pixels, has_alpha, facts).map_err(|error| error.in_file(path))?;
    write_whole(path, &bytes)
}

/// The bytes of such a PNG.
///
/// # Errors
/// `pixels` is not width × height × 3 or 4 bytes.
pub fn encode_png(size: [u32; 2], pixels: &[u8], has_alpha: bool, facts: &Facts<'_>) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(if has_alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let refuse = |e: png::EncodingError| Error::machine(format!("no PNG ({e})"));
    for (name, text) in facts {
        encoder.add_itxt_chunk((*name).to_owned(), (*text).to_owned()).map_err(refuse)?;
    }
    let mut writer = encoder.write_header().map_err(refuse)?;
    writer.write_image_data(pixels).map_err(refuse)?;
    writer.finish().map_err(refuse)?;
    Ok(bytes)
}

/// Writes an EXR, see [`encode_exr`].
///
/// # Errors
/// A plane of another size, or the file cannot be written.
pub fn write_exr(
    path: &Path,
    size: [u32; 2],
    floats: Vec<(&str, Vec<f32>)>,
    counts: Vec<(&str, Vec<u32>)>,
    facts: &Facts<'_>,
    others: &Facts<'_>,
) -> Result<()> {
    let bytes = encode_exr(size, floats, counts, facts, others).map_err(|error| error.in_file(path))?;
    write_whole(path, &bytes)
}

/// The bytes of an EXR (ZIP compression) with named planes of 32-bit floats and of 32-bit integers, and text attributes: facts with
/// `barbule_` before their names, others as they are.
///
/// # Errors
/// A plane of another size.
pub fn encode_exr(
    size: [u32; 2],
    floats: Vec<(&str, Vec<f32>)>,
    counts: Vec<(&str, Vec<u32>)>,
    facts: &Facts<'_>,
    others: &Facts<'_>,
) -> Result<Vec<u8>> {
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
    // The format keeps names such as `version` for itself, and knows Latin letters only.
    let facts = facts.iter().map(|(name, text)| (format!("barbule_{name}"), *text));
    for (name, text) in facts.chain(others.iter().map(|(name, text)| ((*name).to_owned(), *text))) {
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
        .map_err(|e| Error::machine(format!("no EXR ({e})")))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// Brings the attributes in the header of an EXR of one part into the order of their names. The library writes those of
/// its users in the order of a hash map, which is another one in every run.
fn sort_attributes(bytes: &mut [u8]) {
    /// Magic number and version.
    const HEAD: usize = 8;
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut at = HEAD;
    // Name and type end with a zero; the length of the value and the value follow. An empty name ends the header.
    while let Some(length) = bytes.get(at..).and_then(attribute_length) {
        attributes.push(&bytes[at..at + length]);
        at += length;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    bytes[HEAD..HEAD + sorted.len()].copy_from_slice(&sorted);
}

/// Bytes of the attribute that these begin with; `None` where there is none.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let text = |from: usize| bytes.get(from..)?.iter().position(|byte| *byte == 0);
    let name = text(0).filter(|length| *length > 0)?;
    let value = name + 1 + text(name + 1)? + 1;
    let length = u32::from_le_bytes(*bytes.get(value..)?.first_chunk()?) as usize;
    let end = value.checked_add(4)?.checked_add(length)?;
    (end <= bytes.len()).then_some(end)
}

/// A picture in linear RGB.
#[derive(Debug, Clone, PartialEq)]
pub struct RgbImage {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Row by row from the top.
    pub pixels: Vec<[f32; 3]>,
}

/// Largest picture that is read: 4096 × 2048 pixels, as much as a sky needs. What packs 8 pixels into a byte is packed no better
/// than a sky of one colour.
const MOST_PIXELS: usize = 4096 * 2048;

/// Compression never gains more than this; a header that claims more pixels per byte of file is not believed.
const MOST_PIXELS_PER_BYTE: usize = 1100;

/// The same of pixels that may be of one bit: deflate's limit is 1032 bytes from one.
pub(super) const MOST_BITS_PER_BYTE: usize = 8 * 1032;

/// What the values of a picture mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    /// Colours: those of a PNG are a screen's.
    Colour,
    /// Numbers, 0 … 1 in a PNG.
    Number,
}

/// Reads a picture, colours in linear sRGB, and whether it is one of radiance: an EXR or a Radiance file, or a PNG, whose 1 is a screen's
/// white. Alpha is left out.
///
/// # Errors
/// As [`read_exr`]; or none of these.
pub fn read_picture(path: &Path, meaning: Meaning) -> Result<(RgbImage, bool)> {
    let name = path.display().to_string();
    check_ending(&name)?;
    decode_picture(&name, &read_bytes(path)?, meaning)
}

/// Reads a picture's bytes by the ending of its name, which is what messages call it; see [`read_picture`].
///
/// # Errors
/// As there.
pub fn decode_picture(name: &str, bytes: &[u8], meaning: Meaning) -> Result<(RgbImage, bool)> {
    check_ending(name)?;
    match ending(name).as_str() {
        "exr" => Ok((decode_exr(name, bytes)?, true)),
        "hdr" => Ok((decode_radiance(name, bytes)?, true)),
        _ => Ok((decode_png(name, bytes, meaning)?, false)),
    }
}

/// How many pixels a picture says that it has, by the ending of its name and its first bytes; `None` where it is no such
/// picture or says more than is read.
#[must_use]
pub fn foretell_picture(name: &str, head: &[u8]) -> Option<usize> {
    let sizes = if ending(name) == "exr" {
        let headers = MetaData::read_from_buffered(head, false).ok()?.headers;
        headers.iter().map(|header| header.layer_size.area()).max()
    } else if ending(name) == "hdr" {
        foretell_radiance(name, head)
    } else {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(head));
        let info = decoder.read_header_info().ok()?;
        Some((info.width as usize).saturating_mul(info.height as usize))
    };
    sizes.filter(|pixels| *pixels <= MOST_PIXELS)
}

/// Refuses a name that no picture that can be read has.
pub(crate) fn check_ending(name: &str) -> Result<()> {
    match ending(name).as_str() {
        "exr" | "hdr" | "png" => Ok(()),
        _ => Err(Error::input("pictures are read from .png, .exr or .hdr").in_file(Path::new(name))),
    }
}

/// Reads a PNG of any kind.
fn decode_png(name: &str, bytes: &[u8], meaning: Meaning) -> Result<RgbImage> {
    let refuse = |what: &str| Error::input(what).in_file(Path::new(name));
    let sentence = |error: png::DecodingError| {
        let text: String = error.to_string().chars().take(200).collect();
        refuse(&format!("cannot be read as a PNG ({text})"))
    };
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(sentence)?;
    check_palette(reader.info()).map_err(|error| error.in_file(Path::new(name)))?;
    let size = [reader.info().width, reader.info().height].map(|side| side as usize);
    check_pixels(name, size, bytes.len())?;
    let length = reader.output_buffer_size().ok_or_else(|| refuse("is too large"))?;
    let mut values = vec![0; length];
    let frame = reader.next_frame(&mut values).map_err(sentence)?;
    let value = |v: f64| if meaning == Meaning::Colour { decode(v) } else { v };
    let table: Vec<f32> = (0..=255).map(|v| value(f64::from(v) / 255.0) as f32).collect();
    let channels = frame.color_type.samples();
    let pixels = values[..frame.buffer_size()].chunks_exact(channels).map(|pixel| {
        let colour = if channels < 3 { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] };
        colour.map(|v| table[usize::from(v)])
    });
    Ok(RgbImage { size, pixels: pixels.collect() })
}

/// Refuses a palette that is no list of at most 256 colours: the library that expands it reads beyond it.
pub(super) fn check_palette(info: &png::Info<'_>) -> Result<()> {
    let bytes = info.palette.as_deref().map_or(0, <[u8]>::len);
    if bytes.is_multiple_of(3) && bytes <= 3 * 256 {
        return Ok(());
    }
    Err(Error::input(format!(
        "is a damaged PNG: its palette has {bytes} bytes, not three for each of at most 256 colours"
    )))
}

/// Refuses a header that claims too much.
pub(super) fn check_pixels(name: &str, [width, height]: [usize; 2], bytes: usize) -> Result<()> {
    let pixels = width.saturating_mul(height);
    if pixels > MOST_PIXELS || pixels > bytes.saturating_mul(MOST_PIXELS_PER_BYTE) {
        return Err(Error::input(format!(
            "says that it has {width} x {height} pixels; give a picture of at most {MOST_PIXELS}, as 4096 x 2048 has"
        ))
        .in_file(Path::new(name)));
    }
    Ok(())
}

/// Reads planes R, G and B of the first layer of an EXR that has them.
///
/// # Errors
/// Missing, over 64 MiB, not an EXR, without these planes, or over 4096 × 2048 pixels.
pub fn read_exr(path: &Path) -> Result<RgbImage> {
    decode_exr(&path.display().to_string(), &read_bytes(path)?)
}

fn decode_exr(name: &str, bytes: &[u8]) -> Result<RgbImage> {
    let refuse = |what: String| Error::input(what).in_file(Path::new(name));
    let sentence = |error: exr::error::Error| {
        let text: String = error.to_string().chars().take(200).collect();
        refuse(format!("cannot be read as an EXR with planes R, G and B ({text})"))
    };
    let headers = MetaData::read_from_buffered(bytes, false).map_err(sentence)?.headers;
    for header in &headers {
        check_pixels(name, [header.layer_size.0, header.layer_size.1], bytes.len())?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| RgbImage { size: [size.0, size.1], pixels: vec![[0.0; 3]; size.area()] },
            |image, at, (r, g, b): (f32, f32, f32)| image.pixels[at.1 * image.size[0] + at.0] = [r, g, b],
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(sentence)?;
    Ok(image.layer_data.channel_data.pixels)
}

/// The checksum of a chunk of a PNG, its name included.
#[cfg(test)]
pub(super) fn png_sum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |s, _| s >> 1 ^ if s & 1 == 1 { 0xedb8_8320 } else { 0 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back_and_what_is_none_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sky.exr");
        let plane = |k: usize| (0..12).map(|i| (i * 3 + k) as f32).collect::<Vec<f32>>();
        let planes = vec![("R", plane(0)), ("G", plane(1)), ("B", plane(2)), ("depth.Z", plane(0))];
        write_exr(&path, [4, 3], planes, vec![("id.N", vec![1; 12])], &[], &[]).unwrap();
        let image = read_exr(&path).unwrap();
        assert_eq!(image.size, [4, 3]);
        assert_eq!(image.pixels[5], [15.0, 16.0, 17.0]);
        let message = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let message = read_exr(&path).unwrap_err().to_string();
            assert!(message.contains("sky.exr") && message.len() < 600, "{message}");
            message
        };
        let whole = std::fs::read(&path).unwrap();
        assert!(message(b"no picture").contains("cannot be read as an EXR"));
        for cut in (0..whole.len()).step_by(37) {
            message(&whole[..cut]);
        }
        write_exr(&path, [4, 3], vec![("Y", plane(0))], vec![], &[], &[]).unwrap();
        assert!(message(&std::fs::read(&path).unwrap()).contains("R, G and B"));
        assert!(read_exr(&folder.path().join("none.exr")).is_err());
    }

    #[test]
    fn the_same_picture_is_the_same_bytes_every_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let facts = ["command", "version", "seed", "material", "light"].map(|name| (name, name));
        let plane = |k: usize| (0..12).map(|i| (i * 3 + k) as f32).collect::<Vec<f32>>();
        let made = || {
            let planes = vec![("R", plane(0)), ("G", plane(1)), ("B", plane(2))];
            write_exr(&path, [4, 3], planes, vec![], &facts, &[("spectralLayoutVersion", "1.0")]).unwrap();
            std::fs::read(&path).unwrap()
        };
        let first = made();
        assert!((0..20).all(|_| made() == first));
        assert_eq!(read_exr(&path).unwrap().pixels[5], [15.0, 16.0, 17.0]);
        let header = MetaData::read_from_buffered(&first[..], false).unwrap().headers.remove(0);
        for (name, text) in facts {
            let name = Text::new_or_none(format!("barbule_{name}")).unwrap();
            let value = AttributeValue::Text(Text::new_or_none(text).unwrap());
            assert_eq!(header.own_attributes.other.get(&name), Some(&value));
        }
        assert!(first.windows(21).any(|word| word == b"spectralLayoutVersion"));
    }

    #[test]
    fn pngs_come_back_as_linear_light_and_damaged_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wall.png");
        for has_alpha in [false, true] {
            let pixel: &[u8] = if has_alpha { &[255, 0, 128, 9] } else { &[255, 0, 128] };
            write_png(&path, [3, 2], &pixel.repeat(6), has_alpha, &[]).unwrap();
            let (image, is_radiance) = read_picture(&path, Meaning::Colour).unwrap();
            assert_eq!((image.size, image.pixels.len(), is_radiance), ([3, 2], 6, false));
            assert!((image.pixels[5][2] - 0.215_86).abs() < 1e-5 && image.pixels[5][..2] == [1.0, 0.0]);
            let (numbers, _) = read_picture(&path, Meaning::Number).unwrap();
            assert_eq!(numbers.pixels[5], [1.0, 0.0, (128.0_f64 / 255.0) as f32]);
        }
        let whole = std::fs::read(&path).unwrap();
        let message = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read_picture(&path, Meaning::Colour).unwrap_err().to_string()
        };
        assert!(message(b"no picture").contains("cannot be read as a PNG"));
        for cut in 0..whole.len() - 12 {
            assert!(message(&whole[..cut]).contains("wall.png"));
        }
        // A header of 60000 x 60000 pixels, its checksum made right.
        let mut wide = whole.clone();
        for at in [16, 20] {
            wide[at..at + 4].copy_from_slice(&60_000_u32.to_be_bytes());
        }
        let sum = png_sum(&wide[12..29]);
        wide[29..33].copy_from_slice(&sum.to_be_bytes());
        assert!(message(&wide).contains("60000 x 60000"));
        assert!(
            read_picture(&folder.path().join("wall.jpg"), Meaning::Colour)
                .unwrap_err()
                .to_string()
                .contains(".png, .exr or .hdr")
        );
    }

    #[test]
    fn too_many_pixels_are_refused_before_they_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wide.exr");
        let size = [5000, 2000];
        let plane = vec![0.0; 10_000_000];
        let planes = vec![("R", plane.clone()), ("G", plane.clone()), ("B", plane)];
        write_exr(&path, size, planes, vec![], &[], &[]).unwrap();
        assert!(read_exr(&path).unwrap_err().to_string().contains("5000 x 2000"));
    }
}
