//! Radiance's pictures (`.hdr`): 8 bits a component with an exponent for all three (Ward, *Real pixels*, Graphics Gems II, 1991).

use std::path::Path;

use super::image::{RgbImage, check_pixels};
use crate::error::shortened;
use crate::{Error, Result};

/// Widths that lines packed component by component may have.
const PACKED: std::ops::RangeInclusive<usize> = 8..=32_767;

/// Reads a picture in linear RGB, in which a mantissa of 128 with the exponent 129 is 1; divided by the exposures that its header names.
///
/// # Errors
/// Not such a picture, of another colour space, turned by 90°, with too many pixels, cut off or damaged; `name` is what messages call it.
pub(super) fn decode_radiance(name: &str, bytes: &[u8]) -> Result<RgbImage> {
    let Header { order, exposure, mut rest } = Header::read(name, bytes)?;
    let Order { size: [width, height], is_upwards, is_mirrored } = order;
    check_pixels(name, [width, height], bytes.len())?;
    let mut pixels = vec![[0.0; 3]; width * height];
    let mut scanline = vec![[0_u8; 4]; width];
    for row in 0..height {
        rest = unpack(rest, &mut scanline).ok_or_else(|| {
            let what = format!("is cut off or damaged in line {} of {height}", row + 1);
            Error::input(what).in_file(Path::new(name))
        })?;
        let at = if is_upwards { height - 1 - row } else { row };
        for (column, rgbe) in scanline.iter().enumerate() {
            let at = at * width + if is_mirrored { width - 1 - column } else { column };
            pixels[at] = colour(*rgbe, exposure);
        }
    }
    Ok(RgbImage { size: [width, height], pixels })
}

/// How many pixels a picture has, from its header alone; nothing where that does not say.
pub(super) fn foretell_radiance(name: &str, head: &[u8]) -> Option<usize> {
    let [width, height] = Header::read(name, head).ok()?.order.size;
    Some(width.saturating_mul(height))
}

/// What stands before the pixels.
struct Header<'a> {
    order: Order,
    /// The product of all exposures.
    exposure: f64,
    /// The pixels' bytes.
    rest: &'a [u8],
}

impl<'a> Header<'a> {
    fn read(name: &str, bytes: &'a [u8]) -> Result<Self> {
        let refuse = |what: String| Error::input(what).in_file(Path::new(name));
        let mut lines = Lines(bytes);
        if !bytes.starts_with(b"#?") {
            let what = "is no Radiance picture, which begins with #?RADIANCE or #?RGBE";
            return Err(refuse(what.into()));
        }
        let mut exposure = 1.0;
        loop {
            let line = lines.next().ok_or_else(|| refuse("has a header that does not end".into()))?;
            match line.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
                _ if line.is_empty() => break,
                Some(("FORMAT", "32-bit_rle_rgbe")) => {}
                Some(("FORMAT", other)) => {
                    return Err(refuse(format!(
                        "holds pixels of format '{}'; 32-bit_rle_rgbe is read",
                        shortened(other)
                    )));
                }
                Some(("EXPOSURE", value)) => {
                    let factor = value.parse::<f64>().ok().filter(|factor| (1e-30..=1e30).contains(factor));
                    exposure *=
                        factor.ok_or_else(|| refuse(format!("has the exposure '{}'", shortened(value))))?;
                }
                _ => {}
            }
        }
        let line = lines.next().unwrap_or_default();
        let order = Order::of(&line).ok_or_else(|| {
            refuse(format!("says '{}' in place of its size, as in -Y 512 +X 1024", shortened(&line)))
        })?;
        Ok(Self { order, exposure, rest: lines.0 })
    }
}

/// Lines of a header, and what follows them.
struct Lines<'a>(&'a [u8]);

impl Lines<'_> {
    fn next(&mut self) -> Option<String> {
        let end = self.0.iter().position(|byte| *byte == b'\n')?;
        let line = String::from_utf8_lossy(&self.0[..end]).trim_end().to_owned();
        self.0 = &self.0[end + 1..];
        Some(line)
    }
}

/// The size of a picture, and in which order its pixels are.
struct Order {
    size: [usize; 2],
    is_upwards: bool,
    is_mirrored: bool,
}

impl Order {
    /// Lines are rows: what is turned by 90° is not read.
    fn of(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [y @ ("-Y" | "+Y"), height, x @ ("+X" | "-X"), width] = words[..] else { return None };
        let side = |text: &str| text.parse::<usize>().ok().filter(|side| *side > 0);
        Some(Self { size: [side(width)?, side(height)?], is_upwards: y == "+Y", is_mirrored: x == "-X" })
    }
}

/// Reads a line of pixels; what follows it, or nothing where the bytes end or make no sense.
fn unpack<'a>(bytes: &'a [u8], line: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    let (head, mut rest) = bytes.split_first_chunk::<4>()?;
    let is_packed = PACKED.contains(&line.len()) && head[..2] == [2, 2] && head[2] < 128;
    if !is_packed {
        return unpack_whole(bytes, line);
    }
    if usize::from(u16::from_be_bytes([head[2], head[3]])) != line.len() {
        return None;
    }
    for component in 0..4 {
        let mut at = 0;
        while at < line.len() {
            let (&count, after) = rest.split_first()?;
            // Over 128 one byte many times, else so many bytes.
            let (run, repeats) =
                if count > 128 { (usize::from(count) - 128, true) } else { (usize::from(count), false) };
            let (values, after) = after.split_at_checked(if repeats { 1 } else { run })?;
            let pixels = line.get_mut(at..at + run).filter(|_| run > 0)?;
            for (pixel, value) in pixels.iter_mut().zip(values.iter().cycle()) {
                pixel[component] = *value;
            }
            (at, rest) = (at + run, after);
        }
    }
    Some(rest)
}

/// The same of pixels one after the other: three ones say how often the one before is repeated, in digits of 256 where several follow.
fn unpack_whole<'a>(mut bytes: &'a [u8], line: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    let (mut at, mut digit) = (0, 0);
    while at < line.len() {
        let (&pixel, rest) = bytes.split_first_chunk::<4>()?;
        bytes = rest;
        if pixel[..3] == [1; 3] {
            let before = *line[..at].last()?;
            let count = usize::from(pixel[3]).checked_shl(digit)?;
            line.get_mut(at..at.checked_add(count)?)?.fill(before);
            (at, digit) = (at + count, digit + 8);
        } else {
            line[at] = pixel;
            (at, digit) = (at + 1, 0);
        }
    }
    Some(bytes)
}

/// Linear RGB.
fn colour([r, g, b, exponent]: [u8; 4], exposure: f64) -> [f32; 3] {
    if exponent == 0 {
        return [0.0; 3];
    }
    // A mantissa is a fraction of 256, the exponent stands 128 over its own.
    let scale = libm::exp2(f64::from(exponent) - 136.0) / exposure;
    [r, g, b].map(|mantissa| (f64::from(mantissa) * scale) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(header: &str, data: &[u8]) -> Result<RgbImage> {
        decode_radiance("sky.hdr", &[header.as_bytes(), data].concat())
    }

    const HEAD: &str = "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n\n";

    /// Ten pixels: red of 1, then a ramp of green, in runs and bytes, component by component.
    fn packed() -> Vec<u8> {
        let mut bytes = vec![2, 2, 0, 10];
        bytes.extend([128 + 10, 128]);
        bytes.push(10);
        bytes.extend((0..10).map(|i| i * 16));
        bytes.extend([128 + 4, 0, 6, 0, 0, 0, 0, 0, 0]);
        bytes.extend([128 + 10, 129]);
        bytes
    }

    #[test]
    fn packed_and_plain_lines_come_out_as_radiance() {
        let image = decode(&format!("{HEAD}-Y 2 +X 10\n"), &[packed(), packed()].concat()).unwrap();
        assert_eq!((image.size, image.pixels.len()), ([10, 2], 20));
        assert_eq!(image.pixels[13], [1.0, 0.375, 0.0]);
        // Narrow lines are plain; a run of the older kind repeats the pixel before, 2 + 256 · 0 times.
        let plain = [[128, 64, 0, 130], [1, 1, 1, 2], [1, 1, 1, 0], [0, 0, 0, 0]].concat();
        let image = decode(&format!("{HEAD}-Y 1 +X 4\n"), &plain).unwrap();
        assert_eq!(image.pixels, [[2.0, 1.0, 0.0], [2.0, 1.0, 0.0], [2.0, 1.0, 0.0], [0.0; 3]]);
        // The brightest is still a number; exposures divide.
        let bright =
            decode("#?RGBE\nEXPOSURE=2\nEXPOSURE= 4\n\n-Y 1 +X 2\n", &[255, 0, 0, 255, 128, 128, 128, 129])
                .unwrap();
        assert!(bright.pixels[0][0].is_finite() && bright.pixels[0][0] > 1e37);
        assert_eq!(bright.pixels[1], [0.125; 3]);
    }

    #[test]
    fn the_order_of_rows_and_columns_is_the_headers() {
        let four = [[128, 0, 0, 129], [0, 128, 0, 129], [0, 0, 128, 129], [128, 128, 128, 129]].concat();
        let order = |size: &str| decode(&format!("{HEAD}{size}\n"), &four).unwrap().pixels;
        let usual = order("-Y 2 +X 2");
        let [a, b, c, d] = usual[..] else { panic!() };
        assert_eq!(order("+Y 2 +X 2"), [c, d, a, b]);
        assert_eq!(order("-Y 2 -X 2"), [b, a, d, c]);
    }

    #[test]
    fn bad_files_are_refused_in_a_sentence() {
        let whole = [format!("{HEAD}-Y 2 +X 10\n").into_bytes(), packed(), packed()].concat();
        for cut in 0..whole.len() {
            let error = decode_radiance("sky.hdr", &whole[..cut]).unwrap_err();
            assert!(error.is_input() && error.to_string().starts_with("sky.hdr: "), "{error}");
        }
        let message = |header: &str, data: &[u8]| decode(header, data).unwrap_err().to_string();
        assert!(message("hello", b"").contains("begins with #?RADIANCE"));
        assert!(message("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n", b"").contains("format '32-bit_rle_xyze'"));
        assert!(message("#?RADIANCE\nEXPOSURE=-1\n\n", b"").contains("the exposure '-1'"));
        for size in ["+X 2 -Y 2", "-Y 0 +X 2", "-Y 2 +X", ""] {
            assert!(message(&format!("{HEAD}{size}\n"), &[0; 99]).contains("as in -Y 512 +X 1024"), "{size}");
        }
        assert!(message(&format!("{HEAD}-Y 99999 +X 99999\n"), &[0; 99]).contains("99999 x 99999"));
        // A line longer than it says, one of another width, a run of nothing, a repeat of nothing.
        for bad in [vec![2, 2, 0, 10, 128 + 11, 1], vec![2, 2, 0, 11], vec![2, 2, 0, 10, 0], vec![1, 1, 1, 5]]
        {
            let bad = [bad, vec![0; 99]].concat();
            assert!(message(&format!("{HEAD}-Y 1 +X 10\n"), &bad).contains("damaged in line 1 of 1"));
        }
    }
}
