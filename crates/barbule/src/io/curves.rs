//! Curve files: a control point a line, `x y z radius`, and a blank line between curves, as other renderers read them.

use std::fmt::Write as _;
use std::path::Path;

use super::whole::read_at_most;
use crate::scene::spline::{Basis, ControlCurve};
use crate::{Error, Result};

/// The largest curve file: 128 MiB, about 4 million points; the shortest lines become six times their bytes.
pub const LARGEST_CURVES: u64 = 128 << 20;

/// Largest modulus of a coordinate.
const FARTHEST: f64 = 1e9;

/// Reads a file of round curves; coordinates and radii stay in the file's unit.
///
/// # Errors
/// The file cannot be read or is over 128 MiB; a line is not four finite numbers with a radius over 0; a curve has fewer
/// points than its basis needs; there is none. The message names the line.
pub fn read_curves(path: &Path, basis: Basis) -> Result<Vec<ControlCurve>> {
    decode_curves(&path.display().to_string(), &read_at_most(path, LARGEST_CURVES)?, basis)
}

/// About how many control points such a file of so many bytes has, by its first lines.
#[must_use]
pub fn foretell_curves(head: &[u8], length: u64) -> f64 {
    let lines = head.split(|byte| *byte == b'\n').filter(|line| !line.trim_ascii().is_empty()).count();
    lines as f64 * length as f64 / head.len().max(1) as f64
}

/// Reads the bytes of such a file; `name` is what messages call it.
///
/// # Errors
/// As [`read_curves`].
pub fn decode_curves(name: &str, bytes: &[u8], basis: Basis) -> Result<Vec<ControlCurve>> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| Error::input("is not UTF-8 text; save it as UTF-8").in_file(Path::new(name)))?;
    parse_curves(name, text, basis).map_err(|error| error.of_file(Path::new(name)))
}

/// Reads the text of such a file; `name` is what messages call it.
///
/// # Errors
/// As [`read_curves`].
pub fn parse_curves(name: &str, text: &str, basis: Basis) -> Result<Vec<ControlCurve>> {
    let mut curves = Vec::new();
    let mut points = ControlCurve::new();
    let least = basis.least_points();
    let mut close = |points: &mut ControlCurve, line: usize| {
        if points.is_empty() {
            return Ok(());
        }
        if points.len() < least {
            return Err(Error::input(format!(
                "{name}: the curve that ends before line {line} has {} points, but needs {least}",
                points.len()
            )));
        }
        curves.push(std::mem::take(points));
        Ok(())
    };
    let mut last = 0;
    for (line, words) in (1..).zip(text.lines().map(str::trim)) {
        last = line;
        if words.is_empty() {
            close(&mut points, line)?;
        } else {
            points.push(point(words).map_err(|error| error.in_line(line).at(name))?);
        }
    }
    close(&mut points, last + 1)?;
    if curves.is_empty() {
        return Err(Error::input(format!("{name}: has no curve; give lines of x y z radius")));
    }
    Ok(curves)
}

fn point(words: &str) -> Result<[f64; 4]> {
    let mut numbers = [0.0; 4];
    let mut given = words.split_ascii_whitespace();
    for number in &mut numbers {
        let value = given.next().and_then(|word| word.parse::<f64>().ok()).filter(|v| v.abs() <= FARTHEST);
        *number = value.ok_or_else(|| {
            Error::input("is not four numbers x y z radius, each finite and of modulus up to 1e9")
        })?;
    }
    if given.next().is_some() {
        return Err(Error::input("has over four numbers, but a point is x y z radius"));
    }
    if numbers[3] <= 0.0 {
        return Err(Error::input(format!("has a radius of {}, but it must be over 0", numbers[3])));
    }
    Ok(numbers)
}

/// The text of a curve file, with six digits of each number.
#[must_use]
pub fn curves_text(curves: &[ControlCurve]) -> String {
    let mut text = String::new();
    for curve in curves {
        for [x, y, z, radius] in curve {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{x:.6} {y:.6} {z:.6} {radius:.6}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = "0 0 0 0.1\n1 0 0 0.1\n\n\n0 1 0 0.2\n1 1 0 0.2\n2 1 0 1e-1";

    #[test]
    fn curves_come_back_from_their_text() {
        let curves = parse_curves("a.txt", TWO, Basis::Linear).unwrap();
        assert_eq!(curves.iter().map(Vec::len).collect::<Vec<_>>(), [2, 3]);
        assert_eq!(curves[1][2], [2.0, 1.0, 0.0, 0.1]);
        assert_eq!(parse_curves("b.txt", &curves_text(&curves), Basis::Linear).unwrap(), curves);
    }

    #[test]
    fn faults_are_named_by_their_line() {
        let refused = |text: &str, basis| parse_curves("a.txt", text, basis).unwrap_err().to_string();
        assert!(refused(TWO, Basis::BSpline).contains("ends before line 3 has 2 points, but needs 4"));
        for (text, what) in [
            ("0 0 0 0.1\n1 0 0", "line 2: is not four numbers"),
            ("0 0 0 nan\n1 0 0 1", "line 1: is not four numbers"),
            ("0 0 0 1e300\n1 0 0 1", "line 1: is not four numbers"),
            ("0 0 0 1 7\n1 0 0 1", "line 1: has over four numbers"),
            ("0 0 0 -1\n1 0 0 1", "line 1: has a radius of -1"),
            ("0 0 0 0\n1 0 0 1", "line 1: has a radius of 0"),
            ("0 0 0 1", "ends before line 2 has 1 points"),
            (" \n\n", "has no curve"),
            ("", "has no curve"),
        ] {
            let message = refused(text, Basis::Linear);
            assert!(message.starts_with("a.txt: ") && message.contains(what), "{message}");
        }
    }

    #[test]
    fn files_that_are_no_text_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
        assert!(read_curves(&path, Basis::Linear).unwrap_err().to_string().contains("not UTF-8"));
        assert!(read_curves(&folder.path().join("b"), Basis::Linear).unwrap_err().is_input());
    }
}
