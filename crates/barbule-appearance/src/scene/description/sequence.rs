//! Sequences of frames: light, camera or feather move on arcs and paths, everything else stands still.

use super::{Bearing, SceneDescription};
use crate::{Error, Result, words};

words! {
    /// What moves in a sequence.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Moved {
        /// The key light.
        "light": Light,
        /// The camera.
        "camera": Camera,
        /// The feather, about the picture's upward direction.
        "feather": Feather,
    }
}

/// How it moves.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// At constant elevation over so many degrees of azimuth, half of them to either side of where it stands in the scene; 360 is a whole
    /// turn from there.
    Arc(f64),
    /// Straight in azimuth and elevation from each of these to the next, two at least.
    Path(Vec<Waypoint>),
}

/// A point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Where what moves stands.
    pub bearing: Bearing,
    /// Of a camera: how wide the picture is there, mm, as the scene has it where there is none. In between its logarithm goes straight, as
    /// zooms do.
    pub width_mm: Option<f64>,
}

/// The arc of the key light where nothing is said: the barbules that shine at the scene's own light shine in all of it.
pub const USUAL_ARC_DEG: f64 = 40.0;

/// Widest arc, degrees.
const MOST_ARC_DEG: f64 = 3600.0;

impl SceneDescription {
    /// The frames of a sequence: this scene with what moves in its place.
    ///
    /// # Errors
    /// An arc over ten turns, a path of one point or of a feather, an elevation out of range, or a key light that does not shine.
    pub fn frames(&self, moves: &[(Moved, Motion)], count: u32) -> Result<Vec<Self>> {
        if self.light.strength <= 0.0 && moves.iter().any(|(moved, _)| *moved == Moved::Light) {
            return Err(Error::input(
                "the key light does not shine, so it cannot move; give light.strength over 0",
            ));
        }
        let frame = |index: u32| {
            let mut scene = self.clone();
            for (moved, motion) in moves {
                motion.move_in(&mut scene, *moved, index, count)?;
            }
            scene.check()?;
            Ok(scene)
        };
        (0..count).map(frame).collect()
    }
}

impl Motion {
    fn move_in(&self, scene: &mut SceneDescription, moved: Moved, index: u32, count: u32) -> Result<()> {
        match self {
            Self::Arc(degrees) if degrees.abs() <= MOST_ARC_DEG => {
                // Whole turns end where they began: the frame after the last is the first.
                let is_loop = degrees.abs() >= 360.0;
                let steps = if is_loop { count } else { count.saturating_sub(1).max(1) };
                let start = if is_loop || count == 1 { 0.0 } else { -0.5 };
                let turn = degrees * (f64::from(index) / f64::from(steps) + start);
                match moved {
                    Moved::Light => scene.light.bearing.azimuth_deg += turn,
                    Moved::Camera => scene.camera.bearing.azimuth_deg += turn,
                    Moved::Feather => scene.turn_deg += turn,
                }
                Ok(())
            }
            Self::Arc(degrees) => {
                Err(Error::input(format!("an arc of {degrees} degrees; give at most {MOST_ARC_DEG}")))
            }
            Self::Path(points) => {
                if moved == Moved::Feather {
                    return Err(Error::input(
                        "a feather turns on an arc, not on a path; give feather=DEGREES",
                    ));
                }
                if moved == Moved::Light && points.iter().any(|point| point.width_mm.is_some()) {
                    return Err(Error::input("only the camera's path has widths; give light=AZ,EL/AZ,EL"));
                }
                let [.., _, _] = points[..] else {
                    return Err(Error::input("a path needs two points or more"));
                };
                let legs = (points.len() - 1) as f64;
                let along = legs * f64::from(index) / f64::from(count.saturating_sub(1).max(1));
                let leg = (along as usize).min(points.len() - 2);
                let (from, to, part) = (points[leg], points[leg + 1], along - leg as f64);
                let between = |a: f64, b: f64| a + (b - a) * part;
                let [a, b] = [from, to].map(|point| point.bearing);
                let bearing = Bearing {
                    azimuth_deg: between(a.azimuth_deg, b.azimuth_deg),
                    elevation_deg: between(a.elevation_deg, b.elevation_deg),
                };
                if moved == Moved::Light {
                    scene.light.bearing = bearing;
                } else {
                    scene.camera.bearing = bearing;
                    let [a, b] = [from, to].map(|point| point.width_mm.unwrap_or(scene.camera.width_mm));
                    // Widths that are none are refused with the frame.
                    scene.camera.width_mm = if a == b { a } else { a * libm::pow(b / a, part) };
                }
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever its preset's light and camera are.
    fn starling() -> SceneDescription {
        let text = "preset = 'starling'\n[light]\nazimuth_deg = 20\nelevation_deg = 62\n[camera]\nazimuth_deg = 190\n\
                    elevation_deg = 60\nroll_deg = -35";
        SceneDescription::parse(text).unwrap()
    }

    #[test]
    fn arcs_swing_about_the_scenes_own_light_and_whole_turns_close() {
        let azimuths = |arc: f64, count: u32| -> Vec<f64> {
            let frames = starling().frames(&[(Moved::Light, Motion::Arc(arc))], count).unwrap();
            frames.iter().map(|frame| frame.light.bearing.azimuth_deg).collect()
        };
        assert_eq!(azimuths(40.0, 5), [0.0, 10.0, 20.0, 30.0, 40.0]);
        assert_eq!(azimuths(40.0, 1), [20.0]);
        assert_eq!(azimuths(-360.0, 4), [20.0, -70.0, -160.0, -250.0]);
        let scene = starling();
        let usual = scene.frames(&[(Moved::Light, Motion::Arc(USUAL_ARC_DEG))], 4).unwrap();
        assert!(usual.iter().all(|frame| !frame.is_lit_from_behind()));
    }

    #[test]
    fn paths_pass_through_their_points_and_moves_go_together() {
        let point = |azimuth_deg, elevation_deg| Bearing { azimuth_deg, elevation_deg };
        let stop = |bearing, width_mm| Waypoint { bearing, width_mm };
        let path = Motion::Path(vec![
            stop(point(0.0, 50.0), None),
            stop(point(90.0, 60.0), Some(60.0)),
            stop(point(90.0, 80.0), Some(0.6)),
        ]);
        let moves = [(Moved::Camera, path), (Moved::Feather, Motion::Arc(20.0))];
        let frames = starling().frames(&moves, 5).unwrap();
        let found: Vec<_> = frames.iter().map(|f| (f.camera.bearing, f.turn_deg)).collect();
        assert_eq!(found[0], (point(0.0, 50.0), -10.0));
        assert_eq!(found[1], (point(45.0, 55.0), -5.0));
        assert_eq!(found[2], (point(90.0, 60.0), 0.0));
        assert_eq!(found[4], (point(90.0, 80.0), 10.0));
        assert_eq!(frames[4].light, starling().light);
        assert_eq!(frames[0].camera.width_mm, starling().camera.width_mm);
        assert_eq!([2, 4].map(|k: usize| frames[k].camera.width_mm), [60.0, 0.6]);
        assert!((frames[3].camera.width_mm - 6.0).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_move_is_refused() {
        let refused = |scene: &SceneDescription, moved, motion| {
            scene.frames(&[(moved, motion)], 3).unwrap_err().to_string()
        };
        let scene = starling();
        assert!(refused(&scene, Moved::Light, Motion::Arc(f64::NAN)).contains("at most 3600"));
        let stop = |elevation_deg, width_mm| Waypoint {
            bearing: Bearing { azimuth_deg: 0.0, elevation_deg },
            width_mm,
        };
        let one = vec![stop(50.0, None)];
        assert!(refused(&scene, Moved::Light, Motion::Path(one.clone())).contains("two points"));
        assert!(refused(&scene, Moved::Feather, Motion::Path(one)).contains("on an arc"));
        let wide = vec![stop(50.0, Some(3.0)); 2];
        assert!(refused(&scene, Moved::Light, Motion::Path(wide)).contains("only the camera's"));
        let none = vec![stop(50.0, Some(0.0)), stop(50.0, None)];
        assert!(refused(&scene, Moved::Camera, Motion::Path(none)).contains("camera.width_mm"));
        let over = vec![stop(120.0, None); 2];
        assert!(refused(&scene, Moved::Camera, Motion::Path(over)).contains("camera.elevation_deg is 120"));
        let mut dark = scene;
        dark.light.strength = 0.0;
        assert!(refused(&dark, Moved::Light, Motion::Arc(10.0)).contains("does not shine"));
    }
}
