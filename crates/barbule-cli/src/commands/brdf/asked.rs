//! Directions and instances as they are typed.

use barbule::error::shortened;
use barbule::scattering::directions::omega;
use barbule::{DVec3, Error, Result};

use crate::sets;

/// Most instances of one run.
const MOST_INSTANCES: u64 = 100_000;

/// θ and φ in degrees.
pub(super) type Direction = [f64; 2];

/// Wavelengths in nm, rising.
#[derive(Debug, Clone)]
pub(super) struct Wavelengths(pub(super) Vec<f64>);

/// Names of barbules, in the order typed.
#[derive(Debug, Clone)]
pub(super) struct Instances(pub(super) Vec<u64>);

pub(super) fn wavelengths(text: &str) -> Result<Wavelengths> {
    sets::wavelengths_of("--wavelength", text).map(Wavelengths)
}

pub(super) fn direction(flag: &str, text: &str) -> Result<Direction> {
    match text.split(',').collect::<Vec<_>>()[..] {
        [theta, phi] => Ok([sets::angle(flag, theta)?, sets::angle(flag, phi)?]),
        _ => Err(Error::input(format!("{flag} {}: write THETA,PHI in degrees, as in 0,30", shortened(text)))),
    }
}

pub(super) fn place(text: &str) -> Result<f64> {
    let refuse = || {
        Error::input(format!(
            "--place {}: write a number from -1 to 1, as x goes across the barbule",
            shortened(text)
        ))
    };
    text.trim().parse::<f64>().ok().filter(|x| (-1.0..=1.0).contains(x)).ok_or_else(refuse)
}

/// A set of whole numbers: of 64 bits, none of which a floating-point number would keep.
pub(super) fn instances(text: &str) -> Result<Instances> {
    let refuse = || {
        Error::input(format!(
            "--instance {}: write whole numbers from 0 to 2⁶⁴ − 1, as in 3, 0,5,9 or 0:59:1 (start:stop:step, stop included)",
            shortened(text)
        ))
    };
    let too_many = || Error::input(format!("--instance: over {MOST_INSTANCES} instances; give fewer"));
    let mut names = Vec::new();
    for part in text.split(',') {
        let numbers = part.split(':').map(|t| t.trim().parse::<u64>().ok()).collect::<Option<Vec<_>>>();
        match numbers.ok_or_else(refuse)?[..] {
            [name] => names.push(name),
            [start, stop, step] if step > 0 && stop >= start => {
                let count = (stop - start) / step;
                if count >= MOST_INSTANCES {
                    return Err(too_many());
                }
                names.extend((0..=count).map(|k| start + k * step));
            }
            _ => return Err(refuse()),
        }
        if names.len() as u64 > MOST_INSTANCES {
            return Err(too_many());
        }
    }
    Ok(Instances(names))
}

pub(super) fn towards([theta, phi]: Direction) -> DVec3 {
    omega(theta.to_radians(), phi.to_radians())
}

/// θ and φ in degrees.
pub(super) fn angles_of(w: &DVec3) -> Direction {
    [w.y.clamp(-1.0, 1.0).asin().to_degrees(), w.x.atan2(w.z).to_degrees()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_instances_keep_all_their_bits() {
        let read = |text| instances(text).map(|Instances(names)| names);
        assert_eq!(read("7").unwrap(), [7]);
        assert_eq!(read("0:6:3,18446744073709551615").unwrap(), [0, 3, 6, u64::MAX]);
        assert_eq!(read("18446744073709551614:18446744073709551615:1").unwrap(), [u64::MAX - 1, u64::MAX]);
        for bad in ["", "-1", "1.5", "1:2", "2:1:1", "0:5:0", "x", "18446744073709551616"] {
            assert!(read(bad).unwrap_err().to_string().contains("0:59:1"), "{bad}");
        }
        assert!(read("0:100000:1").unwrap_err().to_string().contains("over 100000 instances"));
    }
}
