//! How something is looked at: on which shape, by whom, under which light, from where.
//!
//! Bearings are as in scene files: azimuths from +y, a feather's tip, clockwise seen from +z; elevations over the plane z = 0.
//! They are degrees here, as people read and type them; [`Light::direction`] and [`Camera::frame`] have unit vectors.

use barbule::fields::{FieldValue, Kind, Text, Value, within, wrong_kind};
use barbule::identity::Hasher;
use barbule::open;
use barbule::scene::description::Bearing;
use barbule::{DVec3, Result};
use barbule_base::{record, words};

words! {
    /// What a material or grating is shown on.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Mode {
        /// A ball.
        "sphere": Sphere,
        /// A bent piece of a vane of barbules side by side.
        "vane": Vane,
        /// A feather with its barbs and barbules.
        #[default]
        "feather": Feather,
        /// The scales of a snake.
        "snake": Snake,
        /// The preset that suits it, by samples of the renderer.
        "scene": Scene,
    }
}

words! {
    /// Whether barbules differ.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Shown {
        /// All are the mean over individuals.
        "mean": Mean,
        /// Each cell is an individual of its own, with its glints.
        #[default]
        "individuals": Individuals,
    }
}

/// Who sees: people, or a bird whose cones are shown in false colours.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Seer {
    /// People.
    #[default]
    People,
    /// A bird by the name of its eye.
    Bird(String),
}

impl Seer {
    const PEOPLE: &str = "human";
    const BIRD: &str = "bird:";

    /// By the word that commands have for it: `human`, or `bird:NAME` with the name of a built-in eye or the file of one.
    ///
    /// # Errors
    /// There is no such eye; the nearest is offered.
    pub fn named(word: &str) -> Result<Self> {
        match word.strip_prefix(Self::BIRD) {
            None if word == Self::PEOPLE => Ok(Self::People),
            // A bare name of an eye is one too; what it is not is refused with all that there are.
            name => {
                let name = name.unwrap_or(word);
                open::eye(name).map(|_| Self::Bird(name.to_owned()))
            }
        }
    }

    /// The word that commands have for it.
    #[must_use]
    pub fn word(&self) -> String {
        match self {
            Self::People => Self::PEOPLE.to_owned(),
            Self::Bird(name) => format!("{}{name}", Self::BIRD),
        }
    }
}

impl FieldValue for Seer {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        let word = value.as_str().ok_or_else(|| wrong_kind(value, path, "a text in quotes"))?;
        Self::named(word).map_err(|error| error.at(path))
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        Some(self.word().into())
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        Self::named(&self.word()).map(|_| ()).map_err(|error| error.at(path))
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.text(key, &self.word());
    }

    fn kind((): &()) -> Kind {
        Kind::Text("human, or bird:NAME with the name of an eye or the file of one")
    }
}

/// The widest picture and the narrowest, mm: as of scenes.
const WIDTH_MM: [f64; 2] = [0.05, 2000.0];
/// A turn of a camera or a light may be written as several rounds.
const ROUNDS_DEG: f64 = 3600.0;

record! {
    /// The light: a disc at infinity in daylight, and a sky that is everywhere alike.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Light {
        /// Where it stands: azimuth from the feather's tip, clockwise.
        azimuth_deg: f64 = "azimuth_deg", within(-ROUNDS_DEG, ROUNDS_DEG), or 340.0;
        /// Its elevation over the vane.
        elevation_deg: f64 = "elevation_deg", within(-90, 90), or 50.0;
        /// Its angular radius.
        radius_deg: f64 = "radius_deg", within(0.1, 60), or 2.5;
        /// Irradiance over that of a sky of radiance 1.
        strength: f64 = "strength", within(0, 100), or 2.0;
        /// Radiance of the sky.
        sky: f64 = "sky", within(0, 100), or 0.3;
    }
}

record! {
    /// The camera: it looks at a target from a bearing.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Camera {
        /// Where it stands, seen from its target: azimuth from the feather's tip, clockwise.
        azimuth_deg: f64 = "azimuth_deg", within(-ROUNDS_DEG, ROUNDS_DEG), or 180.0;
        /// Its elevation over the vane.
        elevation_deg: f64 = "elevation_deg", within(-90, 90), or 60.0;
        /// Width of the picture at the target.
        width_mm: f64 = "width_mm", within(WIDTH_MM[0], WIDTH_MM[1]), or 30.0;
        /// What it looks at.
        target_mm: [f64; 3] = "target_mm", within(-1e5, 1e5), or [0.0; 3];
    }
}

record! {
    /// Everything about how something is looked at.
    #[derive(Debug, Clone, PartialEq)]
    pub struct View {
        /// What it is shown on.
        mode: Mode = "mode", (), or Mode::default();
        /// Who sees: people or a bird.
        eye: Seer = "eye", (), or Seer::default();
        /// Whether barbules differ.
        shown: Shown = "shown", (), or Shown::default();
        /// Which individual is computed and drawn alone.
        individual: usize = "individual", within(0, 9999), or 0;
        /// The angle of incidence of spectra, across the barbule.
        angle_deg: f64 = "angle_deg", within(-85, 85), or 0.0;
        /// The wavelength at which lobes are drawn.
        wavelength_nm: f64 = "wavelength_nm", within(300, 830), or 550.0;
        /// The preset whose light and ground it stands in; its own where nothing is said.
        preset: Option<String> = "preset", Text("the name of a preset");
        /// The light.
        light: Light = "light", (), or Light::usual();
        /// The camera.
        camera: Camera = "camera", (), or Camera::usual();
    }
}

/// Where a camera is, and the axes of its picture: unit vectors to the right, upwards, and from the target to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// What it looks at, mm.
    pub target_mm: DVec3,
    /// To the right in the picture.
    pub right: DVec3,
    /// Upwards in the picture.
    pub up: DVec3,
    /// From the target towards the camera.
    pub towards: DVec3,
}

impl Light {
    /// The light of a window that was just opened.
    #[must_use]
    pub fn usual() -> Self {
        Self { azimuth_deg: 340.0, elevation_deg: 50.0, radius_deg: 2.5, strength: 2.0, sky: 0.3 }
    }

    /// Unit vector towards it.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        bearing(self.azimuth_deg, self.elevation_deg).direction()
    }

    /// The light turned by so many degrees clockwise seen from +z and so many upwards; it stops at the zenith and the nadir.
    #[must_use]
    pub fn moved(self, [azimuth_deg, elevation_deg]: [f64; 2]) -> Self {
        Self {
            azimuth_deg: wrapped(self.azimuth_deg + azimuth_deg),
            elevation_deg: (self.elevation_deg + elevation_deg).clamp(-90.0, 90.0),
            ..self
        }
    }
}

impl Camera {
    /// How far it stands from its target, over the width of the picture there: as far as cameras of scenes do.
    pub const DISTANCE: f64 = 4.0;

    /// The camera of a window that was just opened.
    #[must_use]
    pub fn usual() -> Self {
        Self { azimuth_deg: 180.0, elevation_deg: 60.0, width_mm: 30.0, target_mm: [0.0; 3] }
    }

    /// Its axes. The picture's upward direction is that in which +z lies, and straight from above where the camera's azimuth points
    /// away from it.
    #[must_use]
    pub fn frame(&self) -> Frame {
        let towards = bearing(self.azimuth_deg, self.elevation_deg).direction();
        let (sine, cosine) = self.azimuth_deg.to_radians().sin_cos();
        // Seen from the camera's azimuth, right is where azimuths rise less than a right angle before it.
        let right = DVec3::new(-cosine, sine, 0.0);
        Frame { target_mm: self.target_mm.into(), right, up: towards.cross(right), towards }
    }

    /// The camera turned about its target by so many degrees clockwise seen from +z and so many upwards.
    #[must_use]
    pub fn orbited(self, [azimuth_deg, elevation_deg]: [f64; 2]) -> Self {
        Self {
            azimuth_deg: wrapped(self.azimuth_deg + azimuth_deg),
            elevation_deg: (self.elevation_deg + elevation_deg).clamp(-90.0, 90.0),
            ..self
        }
    }

    /// The picture wider by a factor, within what cameras may show.
    #[must_use]
    pub fn zoomed(self, factor: f64) -> Self {
        Self { width_mm: (self.width_mm * factor).clamp(WIDTH_MM[0], WIDTH_MM[1]), ..self }
    }

    /// What is shown moved by these parts of the picture's width, to the right and upwards.
    #[must_use]
    pub fn panned(self, [right, up]: [f64; 2]) -> Self {
        let frame = self.frame();
        let target = frame.target_mm - (frame.right * right + frame.up * up) * self.width_mm;
        Self { target_mm: target.clamp(DVec3::splat(-1e5), DVec3::splat(1e5)).into(), ..self }
    }
}

impl Default for View {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            eye: Seer::default(),
            shown: Shown::default(),
            individual: 0,
            angle_deg: 0.0,
            wavelength_nm: 550.0,
            preset: None,
            light: Light::usual(),
            camera: Camera::usual(),
        }
    }
}

fn bearing(azimuth_deg: f64, elevation_deg: f64) -> Bearing {
    Bearing { azimuth_deg, elevation_deg }
}

/// The same direction from 0 to under 360 degrees.
fn wrapped(degrees: f64) -> f64 {
    let round = degrees.rem_euclid(360.0);
    if round == 360.0 { 0.0 } else { round }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::fields::Record as _;

    fn near(a: DVec3, b: [f64; 3]) -> bool {
        a.distance(b.into()) < 1e-12
    }

    #[test]
    fn bearings_are_those_of_scenes() {
        let light = Light { azimuth_deg: 90.0, elevation_deg: 0.0, ..Light::usual() };
        assert!(near(light.direction(), [1.0, 0.0, 0.0]));
        let above = light.moved([0.0, 200.0]);
        assert!(near(above.direction(), [0.0, 0.0, 1.0]) && above.elevation_deg == 90.0);
        assert_eq!(light.moved([-100.0, 0.0]).azimuth_deg, 350.0);
        assert_eq!(light.moved([270.0, 0.0]).azimuth_deg, 0.0);
    }

    /// From the feather's base the tip is upwards and +x to the right, also from straight above.
    #[test]
    fn a_cameras_axes_are_right_handed_and_turn_with_it() {
        for elevation_deg in [0.0, 30.0, 90.0, -20.0] {
            for azimuth_deg in [0.0, 45.0, 180.0, 300.0] {
                let camera = Camera { azimuth_deg, elevation_deg, ..Camera::usual() };
                let Frame { right, up, towards, .. } = camera.frame();
                assert!(near(right.cross(up), towards.into()), "{azimuth_deg} {elevation_deg}");
                assert!(up.z >= -1e-12 && (up.length() - 1.0).abs() < 1e-12);
            }
        }
        let above = Camera { azimuth_deg: 180.0, elevation_deg: 90.0, ..Camera::usual() }.frame();
        assert!(near(above.right, [1.0, 0.0, 0.0]) && near(above.up, [0.0, 1.0, 0.0]));
    }

    #[test]
    fn mouse_and_wheel_move_the_camera_within_its_limits() {
        let camera = Camera { azimuth_deg: 180.0, elevation_deg: 90.0, width_mm: 10.0, ..Camera::usual() };
        assert_eq!(camera.zoomed(1e9).width_mm, 2000.0);
        assert_eq!(camera.zoomed(1e-9).width_mm, 0.05);
        // What was at the middle is a tenth of the picture further to the right: the target is to the left of it.
        assert!(near(DVec3::from(camera.panned([0.1, 0.0]).target_mm), [-1.0, 0.0, 0.0]));
        assert!(near(DVec3::from(camera.panned([0.0, 0.2]).target_mm), [0.0, -2.0, 0.0]));
        let turned = camera.orbited([30.0, -100.0]);
        assert_eq!((turned.azimuth_deg, turned.elevation_deg), (210.0, -10.0));
    }

    #[test]
    fn views_are_written_and_read_as_they_are() {
        let view = View {
            mode: Mode::Vane,
            eye: Seer::named("bird:starling").unwrap(),
            individual: 7,
            preset: Some("magpie".into()),
            ..View::default()
        };
        assert_eq!(View::read(&view.table(), "").unwrap(), view);
        assert_eq!(View::read(&serde_json::json!({}), "").unwrap(), View::default());
        for (given, words) in [
            (serde_json::json!({"mode": "spher"}), "mode is 'spher', did you mean 'sphere'?"),
            (serde_json::json!({"eye": "bird:starlin"}), "did you mean 'starling'?"),
            (serde_json::json!({"eye": 3}), "eye is the number 3, but must be a text in quotes"),
            (
                serde_json::json!({"light": {"azimuth": 3}}),
                "light: unknown key 'azimuth', did you mean 'azimuth_deg'?",
            ),
            (serde_json::json!({"camera": {"width_mm": 0}}), "camera.width_mm is 0, outside 0.05 to 2000"),
            (serde_json::json!({"individual": 1.5}), "individual is 1.5, but must be a whole number"),
        ] {
            let refused = View::read(&given, "").unwrap_err().to_string();
            assert!(refused.contains(words), "{refused}");
        }
    }
}
