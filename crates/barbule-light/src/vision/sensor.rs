//! Birds' eyes as sensors of pictures, in false colours, with the human eye beside them in the same film.

use crate::error::{did_you_mean, shortened};
use crate::spectrum::colour::{Illuminant, xyz_from_rgb};
use crate::spectrum::dense::DenseSpectrum;
use crate::spectrum::sensor::{Band, Curve, MOST_CHANNELS, Sensor};
use crate::{Error, Result};

use super::{Cone, Eye};

/// The wavelengths of pictures that birds see, nm: those of the human eye and the ultraviolet.
const BAND_NM: [u32; 2] = [300, 720];

/// Which cones a screen's red, green and blue show: each the mean of one or several.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FalseColour([Vec<usize>; 3]);

impl FalseColour {
    /// What shows an eye's cones unless another is asked for: of four red, green and blue are long, middle and short, and the
    /// ultraviolet is added as magenta; of fewer the longest is red and the shortest blue.
    #[must_use]
    pub fn usual(eye: &Eye) -> Self {
        let last = eye.cones.len() - 1;
        Self(match last {
            0 => [vec![0], vec![0], vec![0]],
            1 => [vec![1], vec![0, 1], vec![0]],
            2 => [vec![2], vec![1], vec![0]],
            _ => [vec![last, 0], vec![last - 1], vec![last - 2, 0]],
        })
    }

    /// Reads `L,M,S`, or with several cones for a colour `L+UV,M,S+UV`.
    ///
    /// # Errors
    /// Not three parts, or a cone that the eye has not.
    pub fn parse(text: &str, eye: &Eye) -> Result<Self> {
        let names: Vec<&str> = eye.cones.iter().map(|cone| cone.name.as_str()).collect();
        let place = |name: &str| {
            let name = name.trim();
            names.iter().position(|known| known.eq_ignore_ascii_case(name)).ok_or_else(|| {
                let short = shortened(name);
                let near = did_you_mean(&short, names.iter().copied());
                Error::input(format!(
                    "{} has no cone '{short}'{near}; it has {}",
                    shortened(&eye.name),
                    names.join(", ")
                ))
            })
        };
        let parts: Vec<&str> = text.split(',').collect();
        let [r, g, b] = parts[..] else {
            return Err(Error::input(format!(
                "'{}' names {} colours; give the cones of red, green and blue, as in {}",
                shortened(text),
                parts.len(),
                Self::usual(eye).words(eye)
            )));
        };
        let of = |part: &str| part.split('+').map(place).collect::<Result<Vec<_>>>();
        Ok(Self([of(r)?, of(g)?, of(b)?]))
    }

    /// As it is typed.
    #[must_use]
    pub fn words(&self, eye: &Eye) -> String {
        let part = |cones: &Vec<usize>| {
            cones.iter().map(|k| eye.cones[*k].name.as_str()).collect::<Vec<_>>().join("+")
        };
        self.0.each_ref().map(part).join(",")
    }
}

/// A sensor with the channels of an eye's cones, the double ones among them where there is room, and of the human eye: X, Y, Z. Cones answer
/// to quanta, and daylight (D65, 1 at 560 nm) is 1 for each. On a screen it shows the cones in false colours, white as white.
///
/// # Errors
/// More cones than a sensor has channels beside the human eye's.
pub fn false_colour(eye: &Eye, colours: &FalseColour) -> Result<Sensor> {
    let channels = channels(eye)?;
    let human = channels.len() - 3;
    let mut rows: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; human + 3]);
    for (primary, cones) in colours.0.iter().enumerate() {
        let mut rgb = [0.0; 3];
        rgb[primary] = 1.0;
        let xyz = xyz_from_rgb(rgb);
        for cone in cones {
            for (row, value) in rows.iter_mut().zip(xyz) {
                row[*cone] += value / cones.len() as f64;
            }
        }
    }
    sensor(eye, channels)?.with_xyz(&rows)
}

/// The sensor of [`false_colour`] that shows on a screen what people see: the same channels, and so the same film.
///
/// # Errors
/// As there.
pub fn human_beside(eye: &Eye) -> Result<Sensor> {
    let channels = channels(eye)?;
    let human = channels.len() - 3;
    let rows = std::array::from_fn(|k| {
        let mut row = vec![0.0; human + 3];
        row[human + k] = 1.0;
        row
    });
    sensor(eye, channels)?.with_xyz(&rows)
}

fn sensor(eye: &Eye, channels: Vec<Curve>) -> Result<Sensor> {
    Sensor::new(&eye.name, Band::new(BAND_NM[0], BAND_NM[1])?, channels)
}

/// Cones, then X, Y and Z.
fn channels(eye: &Eye) -> Result<Vec<Curve>> {
    let most = MOST_CHANNELS - 3;
    if eye.cones.len() > most {
        return Err(Error::input(format!(
            "{} has {} classes of cones; pictures show up to {most} beside the human eye",
            shortened(&eye.name),
            eye.cones.len()
        )));
    }
    let band = Band::new(BAND_NM[0], BAND_NM[1])?;
    let cones = eye.all_cones().take(most).map(|cone| response(cone, band));
    let human = Sensor::human();
    let eye_of_people = human.channels().iter().map(|curve| Curve {
        name: curve.name.clone(),
        response: DenseSpectrum::new(|nm| curve.response.at(nm) * share_of_people(nm)),
    });
    Ok(cones.chain(eye_of_people).collect())
}

/// 1 within the band of the human eye and 0 outside. Where it begins, one half, as integrals over that band alone count it; where it ends,
/// so does the band of these pictures.
fn share_of_people(nm: f64) -> f64 {
    if nm == Band::HUMAN.low_nm() { 0.5 } else { f64::from(u8::from(Band::HUMAN.contains(nm))) }
}

fn response(cone: &Cone, band: Band) -> Curve {
    let quanta = DenseSpectrum::new(|nm| cone.sensitivity.at(nm) * nm);
    let daylight =
        DenseSpectrum::new(|nm| quanta.at(nm) * Illuminant::D65.power(nm) / Illuminant::D65.power(560.0));
    Curve { name: cone.name.clone(), response: quanta.scaled(1.0 / band.integral(&daylight)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity::hash;

    const FOUR: &str = "[[cones]]\nname = 'UV'\npigment_nm = 362\n[[cones]]\nname = 'S'\npigment_nm = 449\n\
         [[cones]]\nname = 'M'\npigment_nm = 504\n[[cones]]\nname = 'L'\npigment_nm = 563\n[double]\npigment_nm = 563\n";

    fn eye() -> Eye {
        Eye::parse(FOUR, "four").unwrap()
    }

    fn daylight(sensor: &Sensor) -> [f64; MOST_CHANNELS] {
        let mut seen = [0.0; MOST_CHANNELS];
        for (value, curve) in seen.iter_mut().zip(sensor.channels()) {
            let light =
                |nm: f64| curve.response.at(nm) * Illuminant::D65.power(nm) / Illuminant::D65.power(560.0);
            *value = sensor.band().integral(&DenseSpectrum::new(light));
        }
        seen
    }

    #[test]
    fn daylight_is_one_for_each_cone_and_white_in_both_pictures() {
        let eye = eye();
        let bird = false_colour(&eye, &FalseColour::usual(&eye)).unwrap();
        let people = human_beside(&eye).unwrap();
        let seen = daylight(&bird);
        assert!(seen[..5].iter().all(|q| (q - 1.0).abs() < 1e-12), "{seen:?}");
        let white = xyz_from_rgb([1.0; 3]);
        for sensor in [&bird, &people] {
            for (value, expected) in sensor.xyz(&seen).into_iter().zip(white) {
                assert!((value / expected - 1.0).abs() < 1e-9, "{value} {expected}");
            }
        }
        let names: Vec<_> = bird.channels().iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["UV", "S", "M", "L", "double", "X", "Y", "Z"]);
        // One film serves both.
        assert_eq!(hash("sensor", &bird), hash("sensor", &people));
    }

    #[test]
    fn ultraviolet_is_magenta_unless_told_otherwise() {
        let eye = eye();
        let rgb = |colours: &FalseColour, cones: [f64; 4]| {
            let mut seen = [0.0; MOST_CHANNELS];
            seen[..4].copy_from_slice(&cones);
            crate::spectrum::colour::rgb_from_xyz(false_colour(&eye, colours).unwrap().xyz(&seen))
        };
        let close = |found: [f64; 3], expected: [f64; 3]| {
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6)
        };
        let usual = FalseColour::usual(&eye);
        assert!(close(rgb(&usual, [1.0, 0.0, 0.0, 0.0]), [0.5, 0.0, 0.5]));
        assert_eq!(usual.words(&eye), "L+UV,M,S+UV");
        let own = FalseColour::parse("m, s,UV", &eye).unwrap();
        assert!(close(rgb(&own, [0.1, 0.2, 0.3, 0.4]), [0.3, 0.2, 0.1]));
        let refused = |text: &str| FalseColour::parse(text, &eye).unwrap_err().to_string();
        assert!(
            refused("L,M").contains("names 2 colours") && refused("L,M,U").contains("it has UV, S, M, L")
        );
    }

    #[test]
    fn eyes_with_fewer_and_more_cones() {
        let with = |count: usize| {
            let cone = |k: usize| format!("[[cones]]\nname = 'c{k}'\npigment_nm = {}\n", 350 + 30 * k);
            Eye::parse(&(0..count).map(cone).collect::<String>(), "x").unwrap()
        };
        for count in 1..=5 {
            let eye = with(count);
            assert_eq!(false_colour(&eye, &FalseColour::usual(&eye)).unwrap().channels().len(), count + 3);
        }
        assert!(human_beside(&with(6)).unwrap_err().to_string().contains("up to 5 beside the human eye"));
    }
}
