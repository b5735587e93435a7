//! `[camera]`: where the camera stands, and what it shows.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::Bearing;
use crate::fields::{FieldValue, Kind, Text, Value, within, wrong_kind};
use crate::identity::Hasher;
use crate::scene::camera::{Camera, Projection};
use crate::{Error, Result, record, words};

/// Where nothing is said: four times as far as the picture is wide.
const USUAL_FOCAL_LENGTH_MM: f64 = 144.0;

/// Width of the film that focal lengths are told for, mm.
const FILM_MM: f64 = 36.0;

words! {
    /// How a camera projects.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ViewProjection {
        /// Through an eye.
        "perspective": Perspective,
        /// Along parallel rays.
        "orthographic": Orthographic,
    }
}

record! {
    /// A camera; where nothing else is said it looks at the origin.
    #[derive(Debug, Clone, PartialEq)]
    pub struct View {
        /// How it projects.
        projection: ViewProjection = "projection", (), or ViewProjection::Perspective;
        /// The object in whose frame bearing, position and target are told; the scene's where nothing is said.
        about: Option<String> = "about", Text("the name of an object");
        /// Where it stands in place of its bearing, mm.
        position: Option<[f64; 3]> = "position_mm", within(-1e6, 1e6);
        /// What it looks at, mm.
        target: [f64; 3] = "target_mm", within(-1e6, 1e6), or [0.0; 3];
        /// Focal length over a film of 36 mm: how far it stands for the picture's width; from a position, how wide the picture is.
        focal_length_mm: Option<f64> = "focal_length_mm", within(5, 5000);
        /// How far what is sharp lies from it; its target where nothing is said.
        focus_distance_mm: Option<f64> = "focus_distance_mm", within(1e-3, 1e5);
        /// Direction that is upwards in the picture, as "z", "-x" or three numbers; the shaft's tip (y) where nothing is said.
        up: Option<Up> = "up", ();
        /// Turn of the upward direction, clockwise: in the plane z = 0 from the shaft's tip; where `up` is given, in the picture.
        roll_deg: f64 = "roll_deg" | "roll", within(-360, 360), or 0.0;
        /// Width of the picture in the plane of focus.
        width_mm: f64 = "width_mm", within(0.05, 2000);
        /// Radius of the lens over its distance: 0 is sharp everywhere.
        lens: f64 = "lens", within(0, 0.2), or 0.0;
        /// f-number of a lens before a film of 36 mm, in place of that.
        f_number: Option<f64> = "f_number", within(1, 1000);
        @flat {
            /// Where it stands, seen from its target.
            bearing: Bearing;
        }
        @agree View::agree;
    }
}

/// A direction of the scene: a unit vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Up(pub [f64; 3]);

/// The axes by their words.
const AXES: &[(&str, [f64; 3])] = &[
    ("x", [1.0, 0.0, 0.0]),
    ("y", [0.0, 1.0, 0.0]),
    ("z", [0.0, 0.0, 1.0]),
    ("-x", [-1.0, 0.0, 0.0]),
    ("-y", [0.0, -1.0, 0.0]),
    ("-z", [0.0, 0.0, -1.0]),
];

/// A vector of length 1 as it is, so that what is printed is read as the same bits; another brought to it.
fn unit(given: DVec3) -> DVec3 {
    if (given.length_squared() - 1.0).abs() < 4.0 * f64::EPSILON { given } else { given.normalize_or_zero() }
}

impl FieldValue for Up {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        let given = match value {
            Value::String(word) => crate::fields::one_of(path, word, AXES)?,
            Value::Array(_) => <[f64; 3]>::of_value(value, path, &within(-1e6, 1e6))?,
            other => return Err(wrong_kind(other, path, "an axis as in \"z\", or three numbers")),
        };
        let up = Self(unit(given.into()).into());
        up.check_value(path, &()).map(|()| up)
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        let word = AXES.iter().find(|(_, axis)| *axis == self.0).map(|(word, _)| Value::from(*word));
        Some(word.unwrap_or_else(|| self.0.to_vec().into()))
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        if DVec3::from(self.0).length() > 0.5 {
            return Ok(());
        }
        Err(Error::input(format!("{path} has no length; give a direction, as in \"z\"")))
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.numbers(key, &self.0);
    }

    fn kind((): &()) -> Kind {
        let axis = Kind::Number { low: -1e6, high: 1e6, whole: false };
        Kind::Either(vec![
            Kind::Word(AXES.iter().map(|(word, _)| *word).collect()),
            Kind::List { of: Box::new(axis), least: 3, most: 3 },
        ])
    }
}

impl View {
    /// Refuses a camera that stands in its target, and a focus of one that has none.
    fn agree(&self, place: &str) -> Result<()> {
        if let Some(position) = self.position
            && position.iter().zip(self.target).all(|(a, b)| (a - b).abs() < 1e-3)
        {
            return Err(Error::input(format!(
                "{place}.position_mm and {place}.target_mm are the same place; give the camera another one"
            )));
        }
        // A preset's own lens is left aside, since whoever changes its projection does not say it.
        let of_focus =
            [("focus_distance_mm", self.focus_distance_mm.is_some()), ("f_number", self.f_number.is_some())];
        if self.projection == ViewProjection::Orthographic
            && let Some((key, _)) = of_focus.iter().find(|(_, is_given)| *is_given)
        {
            return Err(Error::input(format!(
                "{place}.{key} is given, but an orthographic camera is sharp everywhere; leave it out"
            )));
        }
        Ok(())
    }

    /// The camera in the frame that it is told in. What is in focus need not be what it looks at: then the same picture is that of the
    /// plane in focus.
    pub(super) fn camera(&self) -> Camera {
        let target = DVec3::from(self.target);
        let (eye, width_mm) = match self.position {
            None => {
                let distance =
                    self.focal_length_mm.unwrap_or(USUAL_FOCAL_LENGTH_MM) / FILM_MM * self.width_mm;
                (target + self.bearing.direction() * distance, self.width_mm)
            }
            Some(position) => {
                let eye = DVec3::from(position);
                let width = |focal: f64| FILM_MM / focal * (eye - target).length();
                (eye, self.focal_length_mm.map_or(self.width_mm, width))
            }
        };
        let distance = (eye - target).length();
        let towards = (eye - target) / distance;
        let up = self.upwards(towards);
        let projection = match self.projection {
            ViewProjection::Perspective => {
                // A thin lens of focal length f stands f (1 + 1/m) before what it magnifies by m; its radius is f/2N.
                let magnification = FILM_MM / width_mm;
                let of = |f_number: f64| 0.5 * magnification / (f_number * (1.0 + magnification));
                Projection::Perspective { lens_radius: self.f_number.map_or(self.lens, of) * distance }
            }
            ViewProjection::Orthographic => Projection::Orthographic,
        };
        let camera = Camera { eye, target, up, width_mm, projection };
        match self.focus_distance_mm {
            None => camera,
            Some(focus) => {
                Camera { target: eye - towards * focus, width_mm: width_mm * focus / distance, ..camera }
            }
        }
    }

    /// The direction that is upwards in the picture; `towards` points from the target to the eye.
    fn upwards(&self, towards: DVec3) -> DVec3 {
        let roll = self.roll_deg.to_radians();
        match self.up {
            None => {
                let up = DVec3::new(roll.sin(), roll.cos(), 0.0);
                // Straight along the picture's own upward direction the vane's normal is upwards.
                if towards.cross(up).length() < 1e-3 { DVec3::Z } else { up }
            }
            Some(Up(up)) => {
                let up = DVec3::from(up);
                let up = if towards.cross(up).length() < 1e-3 { up.any_orthonormal_vector() } else { up };
                // Seen from the eye, clockwise is about the line of sight.
                DMat3::from_axis_angle(-towards, roll.rem_euclid(TAU)) * up
            }
        }
    }
}

impl Bearing {
    /// Unit vector towards it.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        crate::scene::camera::direction(self.azimuth_deg.to_radians(), self.elevation_deg.to_radians())
    }
}
