//! Micrographs as grey pictures: PNG, TIFF and JPEG of whatever depth and colours.

use std::io::Cursor;
use std::path::Path;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::{ColorType, TiffError};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::image::{MOST_BITS_PER_BYTE, check_palette};
use super::read_bytes;
use crate::error::shortened;
use crate::trace::{Grey, MOST_PIXELS, check_size};
use crate::{Error, Result};

/// Parts of red, green and blue in a grey, of ITU-R BT.601: what cameras' programs take.
const GREY_OF: [f32; 3] = [0.299, 0.587, 0.114];

/// Reads a micrograph, 0 black to 1 white: grey as it is, of colours their grey; opacity is left out.
///
/// # Errors
/// Missing, over 64 MiB, no PNG, TIFF or JPEG by its first bytes, damaged, or of a size that is not traced.
pub fn read_micrograph(path: &Path) -> Result<Grey> {
    decode_micrograph(&read_bytes(path)?).map_err(|error| error.in_file(path))
}

/// As [`read_micrograph`], from the bytes of a file.
///
/// # Errors
/// As there, without the file's name.
pub fn decode_micrograph(bytes: &[u8]) -> Result<Grey> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => decode_png(bytes),
        [b'I', b'I', 42, 0, ..] | [b'M', b'M', 0, 42, ..] => decode_tiff(bytes),
        [0xff, 0xd8, 0xff, ..] => decode_jpeg(bytes),
        _ => Err(Error::input("is no PNG, TIFF or JPEG; save the micrograph as one of these")),
    }
}

/// Refuses a size that a header claims but that is not traced, or that cannot be in so many bytes.
fn check(size: [usize; 2], bytes: usize) -> Result<()> {
    check_size(size)?;
    if size[0] * size[1] > bytes.saturating_mul(MOST_BITS_PER_BYTE) {
        return Err(Error::input(format!(
            "says that it has {} × {} pixels, which cannot be in {bytes} bytes",
            size[0], size[1]
        )));
    }
    Ok(())
}

/// Greys of pixels with so many channels each, of which the last of two or four is opacity.
fn grey([width, height]: [usize; 2], channels: usize, values: impl Iterator<Item = f32>) -> Result<Grey> {
    let mut pixel = [0.0; 4];
    let mut greys = Vec::with_capacity(width * height);
    for (at, value) in values.enumerate() {
        let channel = at % channels;
        pixel[channel] = value;
        if channel + 1 == channels {
            let colours = pixel.iter().zip(GREY_OF).map(|(value, part)| value * part).sum();
            greys.push(if channels < 3 { pixel[0] } else { colours });
        }
    }
    Grey::new(width, height, greys)
}

fn decode_png(bytes: &[u8]) -> Result<Grey> {
    let refuse = |error: png::DecodingError| {
        Error::input(format!("cannot be read as a PNG ({})", shortened(&error.to_string())))
    };
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(refuse)?;
    check_palette(reader.info())?;
    let size = [reader.info().width, reader.info().height].map(|side| side as usize);
    check(size, bytes.len())?;
    let length = reader.output_buffer_size().ok_or_else(|| Error::input("is too large"))?;
    let mut buffer = vec![0; length];
    let frame = reader.next_frame(&mut buffer).map_err(refuse)?;
    let buffer = &buffer[..frame.buffer_size()];
    let channels = frame.color_type.samples();
    if frame.bit_depth == png::BitDepth::Sixteen {
        let values = buffer.as_chunks::<2>().0.iter().map(|b| f32::from(u16::from_be_bytes(*b)) / 65535.0);
        return grey(size, channels, values);
    }
    grey(size, channels, buffer.iter().map(|b| f32::from(*b) / 255.0))
}

fn decode_tiff(bytes: &[u8]) -> Result<Grey> {
    let refuse = |error: TiffError| {
        Error::input(format!("cannot be read as a TIFF ({})", shortened(&error.to_string())))
    };
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MOST_PIXELS * 4 * size_of::<f32>();
    limits.intermediate_buffer_size = MOST_PIXELS * 4 * size_of::<f32>();
    limits.ifd_value_size = 1 << 24;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(refuse)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(refuse)?;
    let size = [width as usize, height as usize];
    check(size, bytes.len())?;
    let other = || {
        Error::input(
            "is a TIFF of another kind than is read; save it as grey or RGB with 8 or 16 bits, or grey floats",
        )
    };
    let channels = match decoder.colortype().map_err(refuse)? {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        _ => return Err(other()),
    };
    // Where the file says that white is 0, the decoder has turned the values round already.
    let values: Vec<f32> = match decoder.read_image().map_err(refuse)? {
        DecodingResult::U8(values) => values.into_iter().map(|v| f32::from(v) / 255.0).collect(),
        DecodingResult::U16(values) => values.into_iter().map(|v| f32::from(v) / 65535.0).collect(),
        DecodingResult::F32(values) => over_their_range(values),
        _ => return Err(other()),
    };
    if values.len() != size[0] * size[1] * channels {
        return Err(Error::input(format!(
            "holds {} values, but says {} × {} pixels of {channels}",
            values.len(),
            size[0],
            size[1]
        )));
    }
    grey(size, channels, values.into_iter())
}

/// Floats in whatever unit, from 0 for the least to 1 for the largest.
fn over_their_range(values: Vec<f32>) -> Vec<f32> {
    let (low, high) = values.iter().fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let range = (high - low).max(f32::MIN_POSITIVE);
    values.into_iter().map(|value| (value - low) / range).collect()
}

fn decode_jpeg(bytes: &[u8]) -> Result<Grey> {
    let refuse = |error: zune_jpeg::errors::DecodeErrors| {
        Error::input(format!("cannot be read as a JPEG ({})", shortened(&error.to_string())))
    };
    let options = DecoderOptions::new_safe().jpeg_set_out_colorspace(ColorSpace::Luma).set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(refuse)?;
    let (width, height) = decoder.dimensions().ok_or_else(|| Error::input("is a JPEG without a size"))?;
    check([width, height], bytes.len())?;
    let values = decoder.decode().map_err(refuse)?;
    grey([width, height], 1, values.into_iter().map(|v| f32::from(v) / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(colour: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 40, 32);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    /// A picture of 40 × 32 whose pixel p has the grey (p mod 200)/255.
    fn ramp() -> impl Iterator<Item = u8> {
        (0..40 * 32).map(|p| (p % 200) as u8)
    }

    fn holds(picture: &Grey, error: f32) {
        assert_eq!(picture.size(), [40, 32]);
        for (value, expected) in picture.values().iter().zip(ramp()) {
            assert!((value - f32::from(expected) / 255.0).abs() < error, "{value} {expected}");
        }
    }

    #[test]
    fn pictures_of_any_depth_and_colours_are_the_same_grey() {
        let grey: Vec<u8> = ramp().collect();
        let rgba: Vec<u8> = ramp().flat_map(|v| [v, v, v, 7]).collect();
        let deep: Vec<u8> = ramp().flat_map(|v| [v, v]).collect();
        holds(
            &decode_micrograph(&encoded(png::ColorType::Grayscale, png::BitDepth::Eight, &grey)).unwrap(),
            1e-6,
        );
        holds(&decode_micrograph(&encoded(png::ColorType::Rgba, png::BitDepth::Eight, &rgba)).unwrap(), 1e-6);
        holds(
            &decode_micrograph(&encoded(png::ColorType::Grayscale, png::BitDepth::Sixteen, &deep)).unwrap(),
            1e-6,
        );
        let mut tiff = Cursor::new(Vec::new());
        let wide: Vec<u16> = ramp().flat_map(|v| [u16::from(v) * 257; 3]).collect();
        tiff::encoder::TiffEncoder::new(&mut tiff)
            .unwrap()
            .write_image::<tiff::encoder::colortype::RGB16>(40, 32, &wide)
            .unwrap();
        holds(&decode_micrograph(tiff.get_ref()).unwrap(), 1e-6);
        let mut jpeg = Vec::new();
        jpeg_encoder::Encoder::new(&mut jpeg, 100)
            .encode(&grey, 40, 32, jpeg_encoder::ColorType::Luma)
            .unwrap();
        holds(&decode_micrograph(&jpeg).unwrap(), 0.02);
        // Cut anywhere, nothing panics, and what is refused says what the file was taken for.
        for bytes in [encoded(png::ColorType::Rgba, png::BitDepth::Eight, &rgba), tiff.into_inner(), jpeg] {
            for cut in (0..bytes.len()).step_by(97) {
                if let Err(error) = decode_micrograph(&bytes[..cut]) {
                    assert!(error.is_input() && error.to_string().len() < 600);
                }
            }
        }
        assert!(decode_micrograph(b"GIF89a").unwrap_err().to_string().contains("PNG, TIFF or JPEG"));
    }

    /// A TIFF of 40 × 32 greys in one strip, little-endian; of floats where they have 32 bits. `photometric`: whether 0 is white (0) or black (1).
    fn tiff_of(bits: u32, photometric: u32, data: &[u8]) -> Vec<u8> {
        let format = if bits == 32 { 3 } else { 1 };
        let entries: [(u16, u32); 10] = [
            (256, 40),
            (257, 32),
            (258, bits),
            (259, 1),
            (262, photometric),
            // Behind the header of 8 bytes, a count, the entries and the place of the next directory.
            (273, 8 + 2 + 10 * 12 + 4),
            (277, 1),
            (278, 32),
            (279, data.len() as u32),
            (339, format),
        ];
        let mut bytes = b"II*\0\x08\0\0\0\x0a\0".to_vec();
        for (tag, value) in entries {
            bytes.extend_from_slice(&tag.to_le_bytes());
            // One number of two bytes.
            bytes.extend_from_slice(&[3, 0, 1, 0, 0, 0]);
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        bytes.extend_from_slice(&[0; 4]);
        bytes.extend_from_slice(data);
        bytes
    }

    #[test]
    fn white_is_white_whether_it_is_zero_or_not() {
        for photometric in [0, 1] {
            let is_white_zero = photometric == 0;
            let byte = |v: u8| if is_white_zero { 255 - v } else { v };
            let bytes: Vec<u8> = ramp().map(byte).collect();
            holds(&decode_micrograph(&tiff_of(8, photometric, &bytes)).unwrap(), 1e-6);
            let words: Vec<u8> = ramp().flat_map(|v| (u16::from(byte(v)) * 257).to_le_bytes()).collect();
            holds(&decode_micrograph(&tiff_of(16, photometric, &words)).unwrap(), 1e-6);
            // Floats go over their range, which is that of 0 to 199 here.
            let float = |v: u8| if is_white_zero { 1.0 - f32::from(v) / 255.0 } else { f32::from(v) / 255.0 };
            let floats: Vec<u8> = ramp().flat_map(|v| float(v).to_le_bytes()).collect();
            let picture = decode_micrograph(&tiff_of(32, photometric, &floats)).unwrap();
            for (value, expected) in picture.values().iter().zip(ramp()) {
                assert!((value - f32::from(expected) / 199.0).abs() < 1e-5, "{value} {expected}");
            }
        }
    }

    #[test]
    fn sizes_are_refused_before_anything_is_unpacked() {
        let mut bytes = encoded(png::ColorType::Grayscale, png::BitDepth::Eight, &vec![0; 40 * 32]);
        for (width, words) in [(8_u32, "8 × 32"), (60_000, "60000 × 32, which"), (4_000_000, "at most")] {
            bytes[16..20].copy_from_slice(&width.to_be_bytes());
            let sum = super::super::image::png_sum(&bytes[12..29]);
            bytes[29..33].copy_from_slice(&sum.to_be_bytes());
            let words = words.replace(", which", " pixels, which");
            assert!(decode_micrograph(&bytes).unwrap_err().to_string().contains(&words));
        }
    }
}
