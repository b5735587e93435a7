//! Heights as grey pictures: PNG, and TIFF of whole numbers or floats.

use std::io::{BufRead, Cursor, Read, Seek};

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::{Raw, Scale, count};
use crate::error::shortened;
use crate::io::image::MOST_BITS_PER_BYTE;
use crate::structure::MOST_HEIGHTS;
use crate::{Error, Result};

/// Refuses a size that a header claims but that cannot be in so many bytes.
pub(super) fn check(cells: [usize; 2], bytes: usize) -> Result<usize> {
    let heights = count(cells)?;
    if heights > bytes.saturating_mul(MOST_BITS_PER_BYTE) {
        return Err(Error::input(format!(
            "says that it has {} × {} pixels, which cannot be in {bytes} bytes",
            cells[0], cells[1]
        )));
    }
    Ok(heights)
}

fn refuse_png(error: png::DecodingError) -> Error {
    Error::input(format!("cannot be read as a PNG ({})", shortened(&error.to_string())))
}

fn refuse_tiff(error: TiffError) -> Error {
    Error::input(format!("cannot be read as a TIFF ({})", shortened(&error.to_string())))
}

/// Bytes of the pixels as they are decoded, and how many there are.
pub(super) fn head_of_png(file: impl BufRead + Seek) -> Result<(u64, usize)> {
    let mut decoder = png::Decoder::new(file);
    let info = decoder.read_header_info().map_err(refuse_png)?;
    let heights = count([info.width, info.height].map(|side| side as usize))?;
    let width = if info.bit_depth == png::BitDepth::Sixteen { 2 } else { 1 };
    Ok((heights as u64 * width, heights))
}

/// The same of a TIFF.
pub(super) fn head_of_tiff(file: impl Read + Seek) -> Result<(u64, usize)> {
    let mut decoder = Decoder::new(file).map_err(refuse_tiff)?;
    let (width, height) = decoder.dimensions().map_err(refuse_tiff)?;
    let heights = count([width as usize, height as usize])?;
    let depth = match decoder.colortype().map_err(refuse_tiff)? {
        // Floats of full width are the numbers themselves.
        ColorType::Gray(depth) if depth < 64 => u64::from(depth.div_ceil(8)),
        _ => 0,
    };
    Ok((heights as u64 * depth, heights))
}

pub(super) fn read_png(bytes: &[u8]) -> Result<Raw> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(refuse_png)?;
    let info = reader.info();
    let cells = [info.width, info.height].map(|side| side as usize);
    if info.color_type != png::ColorType::Grayscale || info.trns.is_some() {
        return Err(Error::input("is a PNG with colours or transparency; give one of grey alone"));
    }
    check(cells, bytes.len())?;
    let length = reader.output_buffer_size().ok_or_else(|| Error::input("is too large"))?;
    let mut buffer = vec![0; length];
    let frame = reader.next_frame(&mut buffer).map_err(refuse_png)?;
    let buffer = &buffer[..frame.buffer_size()];
    let values: Vec<f64> = match frame.bit_depth {
        png::BitDepth::Sixteen => {
            buffer.as_chunks::<2>().0.iter().map(|b| f64::from(u16::from_be_bytes(*b)) / 65535.0).collect()
        }
        _ => buffer.iter().map(|b| f64::from(*b) / 255.0).collect(),
    };
    Ok(Raw { cells, values, is_picture: true, scale: Scale::Range, size_um: None })
}

pub(super) fn read_tiff(bytes: &[u8]) -> Result<Raw> {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MOST_HEIGHTS * size_of::<f64>();
    limits.intermediate_buffer_size = MOST_HEIGHTS * size_of::<f64>();
    limits.ifd_value_size = 1 << 24;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(refuse_tiff)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(refuse_tiff)?;
    let cells = [width as usize, height as usize];
    match decoder.colortype().map_err(refuse_tiff)? {
        ColorType::Gray(8 | 16 | 32 | 64) => {}
        other => {
            return Err(Error::input(format!(
                "is a TIFF of {}; give one of grey alone with 8 bits or more",
                shortened(&format!("{other:?}"))
            )));
        }
    }
    let heights = check(cells, bytes.len())?;
    let is_there = |decoder: &mut Decoder<_>, tags: &[Tag]| {
        tags.iter()
            .try_fold(false, |found, tag| Ok(found || decoder.find_tag(*tag).map_err(refuse_tiff)?.is_some()))
    };
    // What is left out of the two is another picture.
    let tiles = [Tag::TileWidth, Tag::TileLength, Tag::TileOffsets, Tag::TileByteCounts];
    if is_there(&mut decoder, &tiles)? && is_there(&mut decoder, &[Tag::StripOffsets, Tag::StripByteCounts])?
    {
        return Err(Error::input("is a TIFF with tiles beside strips; write it with one of the two"));
    }
    // 0 where white is: what that makes of floats nobody says.
    let is_inverted =
        decoder.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(refuse_tiff)? == Some(0);
    let whole = |value: f64, most: f64| value / most;
    let (values, scale): (Vec<f64>, Scale) = match decoder.read_image().map_err(refuse_tiff)? {
        DecodingResult::U8(values) => {
            (values.into_iter().map(|v| whole(v.into(), 255.0)).collect(), Scale::Range)
        }
        DecodingResult::U16(values) => {
            (values.into_iter().map(|v| whole(v.into(), 65535.0)).collect(), Scale::Range)
        }
        DecodingResult::F32(values) => (values.into_iter().map(f64::from).collect(), Scale::Unit(None)),
        DecodingResult::F64(values) => (values, Scale::Unit(None)),
        _ => {
            return Err(Error::input(
                "is a TIFF of another kind of numbers than is read; give 8 or 16 bits without sign, or floats",
            ));
        }
    };
    if is_inverted && scale != Scale::Range {
        return Err(Error::input("is a TIFF of floats whose white is 0; write it with black as 0"));
    }
    if values.len() != heights {
        return Err(Error::input(format!(
            "holds {} heights, but says {} × {}",
            values.len(),
            cells[0],
            cells[1]
        )));
    }
    Ok(Raw { cells, values, is_picture: true, scale, size_um: None })
}
