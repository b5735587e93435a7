//! JPEG and WebP: pictures for pages and mail.

use std::path::Path;

use image_webp::WebPEncoder;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

use super::image::Facts;
use super::write_whole;
use crate::error::visible;
use crate::{Error, Result};

/// Of 100: differences are hardly seen, and colours are kept at full resolution, since feathers have theirs in fine lines.
const JPEG_QUALITY: u8 = 92;

/// Bytes of facts at most, since a JPEG keeps them in one segment.
const MOST_FACTS: usize = 60_000;

/// The tag of what a picture shows, and its type: bytes of text that end in a zero.
const IMAGE_DESCRIPTION: u16 = 0x010e;
const ASCII: u16 = 2;

/// Writes an 8-bit RGB picture as JPEG, of quality 92 with colours at full resolution; facts as lines of the EXIF image description.
///
/// # Errors
/// `pixels` is not width × height × 3 bytes, or the file cannot be written.
pub fn write_jpeg(path: &Path, size: [u32; 2], pixels: &[u8], facts: &Facts<'_>) -> Result<()> {
    let refuse = |what: String| Error::machine(format!("no JPEG ({what})")).in_file(path);
    let [Ok(width), Ok(height)] = size.map(u16::try_from) else {
        return Err(refuse(format!("{} x {} pixels are too many", size[0], size[1])));
    };
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, JPEG_QUALITY);
    encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
    let written = encoder
        .add_exif_metadata(&description(facts))
        .and_then(|()| encoder.encode(pixels, width, height, ColorType::Rgb));
    written.map_err(|error| refuse(error.to_string()))?;
    write_whole(path, &bytes)
}

/// Writes an 8-bit picture, RGB or RGBA, as WebP without loss; facts as of [`write_jpeg`].
///
/// # Errors
/// `pixels` is not width × height × 3 or 4 bytes, or the file cannot be written.
pub fn write_webp(
    path: &Path,
    size: [u32; 2],
    pixels: &[u8],
    has_alpha: bool,
    facts: &Facts<'_>,
) -> Result<()> {
    let refuse = |what: String| Error::machine(format!("no WebP ({what})")).in_file(path);
    let (kind, channels) =
        if has_alpha { (image_webp::ColorType::Rgba8, 4) } else { (image_webp::ColorType::Rgb8, 3) };
    if pixels.len() != size[0] as usize * size[1] as usize * channels {
        return Err(refuse(format!("{} bytes for {} x {} pixels", pixels.len(), size[0], size[1])));
    }
    let mut bytes = Vec::new();
    let mut encoder = WebPEncoder::new(&mut bytes);
    encoder.set_exif_metadata(description(facts));
    encoder.encode(pixels, size[0], size[1], kind).map_err(|error| refuse(error.to_string()))?;
    write_whole(path, &bytes)
}

/// Facts as EXIF: one directory of a TIFF with one entry, the image description, in lines of `name: text`.
fn description(facts: &Facts<'_>) -> Vec<u8> {
    let plain = |text: &str| text.chars().map(visible).collect::<String>();
    let mut text: String =
        facts.iter().map(|(name, text)| format!("{}: {}\n", plain(name), plain(text))).collect();
    text.truncate(text.floor_char_boundary(MOST_FACTS));
    // A text of up to four bytes would stand in the entry itself.
    let text = format!("{text:4}\0").into_bytes();
    let mut bytes = b"II*\0".to_vec();
    bytes.extend(8_u32.to_le_bytes()); // where the directory is
    bytes.extend(1_u16.to_le_bytes()); // entries
    bytes.extend(IMAGE_DESCRIPTION.to_le_bytes());
    bytes.extend(ASCII.to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(26_u32.to_le_bytes()); // where the text is
    bytes.extend(0_u32.to_le_bytes()); // no further directory
    bytes.extend(text);
    bytes
}

#[cfg(test)]
mod tests {
    use image_webp::WebPDecoder;
    use zune_jpeg::JpegDecoder;
    use zune_jpeg::zune_core::bytestream::ZCursor;

    use super::*;

    /// Soft colours that JPEG can hold.
    fn pixels(channels: usize) -> Vec<u8> {
        let place = |i: usize| [i / channels % 40, i / channels / 40];
        (0..40 * 24 * channels)
            .map(|i| (place(i)[0] * 4 + place(i)[1] * 2 + 20 * (i % channels)) as u8)
            .collect()
    }

    const FACTS: &Facts<'_> = &[("seed", "7"), ("command", "barbule render\n\u{1b}x -o ä.jpg")];

    #[test]
    fn jpegs_come_back_nearly_and_say_how_they_were_made() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        write_jpeg(&path, [40, 24], &pixels(3), FACTS).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let mut decoder = JpegDecoder::new(ZCursor::new(&bytes));
        let back = decoder.decode().unwrap();
        assert_eq!(decoder.dimensions(), Some((40, 24)));
        let far = back.iter().zip(pixels(3)).map(|(a, b)| a.abs_diff(b)).max().unwrap();
        assert!(back.len() == 40 * 24 * 3 && far <= 12, "{far}");
        let exif = decoder.exif().unwrap();
        assert!(
            exif.starts_with(b"II*\0")
                && exif.ends_with("seed: 7\ncommand: barbule render  x -o ä.jpg\n\0".as_bytes())
        );
        assert!(write_jpeg(&path, [40, 25], &pixels(3), FACTS).unwrap_err().to_string().contains("no JPEG"));
        // What is too long for a segment loses its end.
        write_jpeg(&path, [40, 24], &pixels(3), &[("command", &"ä".repeat(50_000))]).unwrap();
    }

    #[test]
    fn webps_come_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.webp");
        for has_alpha in [false, true] {
            let pixels = pixels(if has_alpha { 4 } else { 3 });
            write_webp(&path, [40, 24], &pixels, has_alpha, FACTS).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            let mut decoder = WebPDecoder::new(std::io::Cursor::new(&bytes)).unwrap();
            assert_eq!((decoder.dimensions(), decoder.has_alpha()), ((40, 24), has_alpha));
            let mut back = vec![0; decoder.output_buffer_size().unwrap()];
            decoder.read_image(&mut back).unwrap();
            assert_eq!(back, pixels);
            let exif = decoder.exif_metadata().unwrap().unwrap();
            assert!(String::from_utf8_lossy(&exif).contains("seed: 7\ncommand: barbule render"));
        }
        assert!(
            write_webp(&path, [41, 24], &pixels(3), false, FACTS)
                .unwrap_err()
                .to_string()
                .contains("no WebP")
        );
    }
}
