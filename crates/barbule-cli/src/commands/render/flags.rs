//! Values of the flags of `barbule render`, as people type them.

use std::path::Path;
use std::time::Duration;

use barbule::error::{did_you_mean, shortened};
use barbule::io::read_sensor;
use barbule::open;
use barbule::picture::Quality;
use barbule::scene::description::{
    Background, Bearing, Exposure, Motion, Moved, ToneWord, ViewModel, Waypoint, WhiteBalance,
};
use barbule::spectrum::sensor::Sensor;
use barbule::vision::Eye;
use barbule::{Error, Result};

use crate::sets;

/// From where `--view` looks, and the width in mm where it says so.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    pub(super) bearing: Bearing,
    pub(super) width_mm: Option<f64>,
}

/// Width and height, as in 1280x800.
pub(super) fn size(text: &str) -> Result<[u32; 2]> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.ok_or_else(|| {
        Error::input(format!("--size {text}: give width and height in pixels, as in 1280x800"))
    })
}

/// Azimuth and elevation of the key light.
pub(super) fn light(text: &str) -> Result<Bearing> {
    bearing("--light", text)
}

fn bearing(flag: &str, text: &str) -> Result<Bearing> {
    let [azimuth_deg, elevation_deg] = sets::parse(flag, text)?[..] else {
        return Err(Error::input(format!(
            "{flag} {}: give azimuth and elevation, as in 40,60",
            shortened(text)
        )));
    };
    Ok(Bearing { azimuth_deg, elevation_deg })
}

/// Azimuth and elevation of the camera, and perhaps a width.
pub(super) fn view(text: &str) -> Result<View> {
    view_of("--view", text)
}

fn view_of(flag: &str, text: &str) -> Result<View> {
    let numbers = sets::parse(flag, text)?;
    let ([azimuth_deg, elevation_deg] | [azimuth_deg, elevation_deg, _]) = numbers[..] else {
        return Err(Error::input(format!(
            "{flag} {}: give azimuth, elevation and perhaps the width in mm, as in 190,58,4.4",
            shortened(text)
        )));
    };
    Ok(View { bearing: Bearing { azimuth_deg, elevation_deg }, width_mm: numbers.get(2).copied() })
}

/// A time: a number with an optional unit s, m or h.
pub(super) fn duration(text: &str) -> Result<Duration> {
    time(text).map_err(|e| e.at(format!("--time {text}")))
}

/// Seconds between two previews, or a time with its unit.
pub(super) fn preview(text: &str) -> Result<Duration> {
    time(text).map_err(|e| e.at(format!("--preview {text}")))
}

fn time(text: &str) -> Result<Duration> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let unit = match &text[split..] {
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => f64::NAN,
    };
    match text[..split].trim().parse::<f64>().map(|value| value * unit) {
        Ok(seconds) if seconds > 0.0 && seconds < 1e7 => Ok(Duration::from_secs_f64(seconds)),
        _ => Err(Error::input("give a time such as 30s, 5m or 1h")),
    }
}

/// What `--exposure` says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Exposed {
    /// This, whatever the scene says.
    As(Exposure),
    /// By so many stops brighter than the scene says.
    Stops(f64),
}

impl Exposed {
    /// The exposure of a scene that has its own.
    pub(super) fn of(self, own: Exposure) -> Exposure {
        match self {
            Self::As(exposure) => exposure,
            Self::Stops(stops) => own.brighter(stops),
        }
    }
}

/// A factor, `auto` with or without stops, or stops alone, which have a sign.
pub(super) fn exposure(text: &str) -> Result<Exposed> {
    if let Some(exposure) = Exposure::of_word(text) {
        return Ok(Exposed::As(exposure));
    }
    if let Some(stops) = Exposure::stops(text) {
        return Ok(Exposed::Stops(stops));
    }
    // What has a sign is stops, be they too many, and no factor.
    match text.parse::<f64>() {
        Ok(factor) if !text.starts_with('+') && (1e-6..=1e6).contains(&factor) => {
            Ok(Exposed::As(Exposure::Factor(factor)))
        }
        _ => Err(Error::input(format!(
            "--exposure {}: give a factor from 0.000001 to 1000000, or auto, each with stops as in auto-1.5, or up to {} stops alone as in +1",
            shortened(text),
            Exposure::MOST_STOPS
        ))),
    }
}

/// `sky`, `none`, `#rrggbb` or a picture.
pub(super) fn background(text: &str) -> Result<Background> {
    Background::parse(text).map_err(|e| e.at("--background"))
}

/// Samples and noise by a word.
pub(super) fn quality(text: &str) -> Result<Quality> {
    Quality::named("--quality", text)
}

/// The curve from light to the screen.
pub(super) fn tone(text: &str) -> Result<ToneWord> {
    ToneWord::named("--tone", text)
}

/// Which light looks white.
pub(super) fn white_balance(text: &str) -> Result<WhiteBalance> {
    WhiteBalance::parse(text).map_err(|e| e.at("--white-balance"))
}

/// How barbs are seen.
pub(super) fn view_model(text: &str) -> Result<ViewModel> {
    ViewModel::named("detail.view_model", text).map_err(|e| e.at("--view-model"))
}

/// Who sees a picture.
#[derive(Debug, Clone)]
pub(super) enum Seer {
    /// A person, or the channels of a file.
    Sensor(Sensor),
    /// A bird.
    Bird(Box<Eye>),
}

/// `human`, `bird:` and a bird, or a file of curves.
pub(super) fn sensor(text: &str) -> Result<Seer> {
    if text == super::HUMAN {
        return Ok(Seer::Sensor(Sensor::human()));
    }
    if let Some(bird) = text.strip_prefix("bird:") {
        return open::eye(bird).map(|eye| Seer::Bird(Box::new(eye))).map_err(|e| e.at("--sensor"));
    }
    let path = Path::new(text);
    if !path.exists() {
        let near = did_you_mean(text, [super::HUMAN]);
        return Err(Error::input(format!(
            "--sensor {}: give human, bird:NAME, or a file of curves (.csv or .toml) that is there{near}",
            shortened(text)
        )));
    }
    read_sensor(path).map(Seer::Sensor).map_err(|e| e.at("--sensor"))
}

/// What moves on an arc, as in `light=40`.
pub(super) fn arc(text: &str) -> Result<(Moved, Motion)> {
    let (moved, degrees) = moved("--arc", text, "camera=60")?;
    match sets::parse("--arc", degrees)?[..] {
        [degrees] => Ok((moved, Motion::Arc(degrees))),
        _ => Err(Error::input(format!("--arc {}: give degrees, as in camera=60", shortened(text)))),
    }
}

/// What moves on a path, as in `light=20,60/40,50`, or `camera=190,60,30/190,60,2` with the picture's width.
pub(super) fn path(text: &str) -> Result<(Moved, Motion)> {
    let (moved, points) = moved("--path", text, "light=20,60/80,45")?;
    // Two numbers, and a third of a camera.
    let stop = |point: &str| {
        if point.split(',').count() < 3 {
            return Ok(Waypoint { bearing: bearing("--path", point)?, width_mm: None });
        }
        let View { bearing, width_mm } = view_of("--path", point)?;
        Ok(Waypoint { bearing, width_mm })
    };
    Ok((moved, Motion::Path(points.split('/').map(stop).collect::<Result<Vec<_>>>()?)))
}

fn moved<'a>(flag: &str, text: &'a str, example: &str) -> Result<(Moved, &'a str)> {
    let (name, rest) = text.split_once('=').unwrap_or((text, ""));
    let found = Moved::ALL.iter().find(|(known, _)| *known == name);
    match found {
        Some((_, moved)) if !rest.is_empty() => Ok((*moved, rest)),
        Some(_) => Err(Error::input(format!("{flag} {}: write it as in {example}", shortened(text)))),
        None => {
            let near = did_you_mean(name, Moved::ALL.iter().map(|(known, _)| *known));
            Err(Error::input(format!(
                "{flag} {}: what moves is light, camera or feather{near}, as in {example}",
                shortened(text)
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_their_units() {
        assert_eq!(duration("30s").unwrap(), Duration::from_secs(30));
        assert_eq!(duration("1.5m").unwrap(), Duration::from_secs(90));
        for bad in ["", "s", "-3s", "0", "5d", "inf"] {
            assert!(duration(bad).unwrap_err().is_input(), "{bad}");
        }
    }

    #[test]
    fn exposures_are_factors_auto_or_stops() {
        let of = |text: &str, own| exposure(text).unwrap().of(own);
        let half = Exposure::Factor(0.5);
        assert_eq!(of("auto", half), Exposure::AUTO);
        assert_eq!(of("auto-1.5", half), Exposure::Auto { stops: -1.5 });
        assert_eq!(of("2", half), Exposure::Factor(2.0));
        assert_eq!([of("+1", half), of("-2", half)], [1.0, 0.125].map(Exposure::Factor));
        assert_eq!(of("+1", Exposure::Auto { stops: -1.5 }), Exposure::Auto { stops: -0.5 });
        for bad in ["0", "auto1", "auto-", "auto+nan", "-99", "+inf", "autos", "+", "nan"] {
            assert!(exposure(bad).unwrap_err().to_string().contains("give a factor"), "{bad}");
        }
    }

    #[test]
    fn motions_are_read_and_refused_with_an_example() {
        assert_eq!(arc("camera=-30").unwrap(), (Moved::Camera, Motion::Arc(-30.0)));
        let (moved, Motion::Path(points)) = path("light=0,50/90,60/1,2").unwrap() else { panic!() };
        assert_eq!((moved, points.len()), (Moved::Light, 3));
        let (_, Motion::Path(zoom)) = path("camera=0,50,30/0,50,2/0,50").unwrap() else { panic!() };
        assert_eq!([0, 1, 2].map(|k: usize| zoom[k].width_mm), [Some(30.0), Some(2.0), None]);
        assert!(arc("lihgt=3").unwrap_err().to_string().contains("did you mean 'light'"));
        assert!(arc("light").unwrap_err().to_string().contains("as in camera=60"));
        assert!(arc("light=1,2").unwrap_err().to_string().contains("give degrees"));
        assert!(path("light=1").unwrap_err().to_string().contains("azimuth and elevation"));
    }
}
