//! The scene that the renderer draws of what the window shows, and the files that it names.

use std::path::Path;

use barbule::error::shortened;
use barbule::fields::{Record as _, Value};
use barbule::open::{self, Opening};
use barbule::progress::Progress;
use barbule::scene::description::{
    Background, Bearing, Exposure, KeyLight, SceneDescription, SkyDescription, Tone, ToneWord,
    View as SceneView,
};
use barbule::structure::Side;
use barbule::{Error, Result};
use serde_json::json;

use super::subject::{Grating, Subject, What};
use super::view::{Camera, Light, Mode, View};
use crate::scene::{BARBULE_LAYOUT, Bend, SPHERE_MM, vane_obj};

/// Up to this elevation +z is upwards in the picture; above it the direction in the vane that points away from the camera is, which
/// there is the same.
const STEEP_DEG: f64 = 60.0;
/// The file of the bent piece of a vane.
const VANE_FILE: &str = "vane.obj";
/// Behind balls and vanes.
const BEHIND: &str = "#26282b";
/// The same behind feathers, sRGB.
const BEHIND_SRGB: [f64; 3] = [38.0 / 255.0, 40.0 / 255.0, 43.0 / 255.0];
/// What is beneath a grating and of what its surface is.
const PIGMENT: &str = "#20140d";
const GRATING_INDEX: f64 = 1.55;
/// The preset of the snake, and the name of its skin.
const SNAKE: &str = "snake";
const SKIN: &str = "skin";

/// A file that something else names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NeededFile {
    /// Its name, in the folder of what names it.
    pub name: String,
    /// What is in it.
    pub text: String,
}

/// A name under which commands and scenes find a structure, with the file that it needs where something was moved in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedStructure {
    /// What is typed.
    pub name: String,
    /// The file, which lies in the working folder.
    pub file: Option<NeededFile>,
}

impl Subject {
    /// What is typed for this structure or material as it is; none of gratings and scenes.
    ///
    /// # Errors
    /// Something was moved that has no file to stand in.
    pub fn typed(&self) -> Result<Option<NamedStructure>> {
        let side = if self.side() == Side::Below { Side::BELOW } else { "" };
        let as_typed = || Ok(Some(NamedStructure { name: self.text().to_owned(), file: None }));
        match self.what() {
            What::Grating(_) | What::Scene(_) => Ok(None),
            What::Species(sizes) | What::Material(_, Some(sizes)) if self.is_moved() => {
                let name = format!("my-{}.toml", plain(&sizes.original().name));
                let file = NeededFile { name: name.clone(), text: sizes.file_text()? };
                Ok(Some(NamedStructure { name: name + side, file: Some(file) }))
            }
            What::Stack(sizes) if self.is_moved() => {
                if sizes.has_own_media() {
                    return Err(Error::input(format!(
                        "{} has media of its own, which no command knows beside its file; change the file",
                        shortened(self.text())
                    )));
                }
                Ok(Some(NamedStructure { name: sizes.text() + side, file: None }))
            }
            _ => as_typed(),
        }
    }

    /// The scene that shows it as a view does, for the renderer, and the files that it names.
    ///
    /// # Errors
    /// It cannot be shown so; as [`Subject::typed`] and [`open::description`].
    pub fn scene(
        &self,
        view: &View,
        opening: &Opening,
        progress: &dyn Progress,
    ) -> Result<(SceneDescription, Vec<NeededFile>)> {
        if !self.modes().contains(&view.mode) {
            let known: Vec<&str> = self.modes().iter().map(|mode| mode.word()).collect();
            return Err(Error::input(format!(
                "a {} is not shown as a {}; choose {}",
                self.kind(),
                view.mode.word(),
                known.join(", ")
            )));
        }
        let typed = self.typed()?;
        let mut files: Vec<NeededFile> = typed.iter().filter_map(|typed| typed.file.clone()).collect();
        let scene = match view.mode {
            Mode::Sphere => {
                object(&json!({ "sphere_mm": SPHERE_MM }), self.skin(&typed, sphere_uv())?, view)?
            }
            Mode::Vane => {
                files.push(NeededFile { name: VANE_FILE.into(), text: vane_obj(&Bend::USUAL)? });
                let [width, length] = Bend::USUAL.size_mm;
                object(&json!({ "mesh": VANE_FILE }), self.skin(&typed, [length, width])?, view)?
            }
            Mode::Snake => self.on_the_snake(view)?,
            Mode::Feather | Mode::Scene => self.in_a_preset(typed.as_ref(), view, opening, progress)?,
        };
        Ok((scene, files))
    }

    /// Its own preset, or that of the view, from where and in which light the view has it. As a feather it is lit by one light and an
    /// even sky alone; as a scene only the key light and the camera are moved.
    fn in_a_preset(
        &self,
        typed: Option<&NamedStructure>,
        view: &View,
        opening: &Opening,
        progress: &dyn Progress,
    ) -> Result<SceneDescription> {
        let mut scene = match (&view.preset, self.what()) {
            (Some(preset), _) => SceneDescription::named(preset).map_err(|error| error.at("preset"))?,
            (None, What::Scene(scene)) => scene.as_ref().clone(),
            (None, _) => open::description(self.text(), opening, progress)?,
        };
        if let Some(typed) = typed {
            scene.set_material(&typed.name);
        }
        let bearing =
            Bearing { azimuth_deg: view.light.azimuth_deg, elevation_deg: view.light.elevation_deg };
        if view.mode == Mode::Feather {
            scene.lights.clear();
            scene.light =
                KeyLight { radius_deg: view.light.radius_deg, strength: view.light.strength, bearing };
            scene.sky = SkyDescription::Gradient { zenith: view.light.sky, horizon: 1.0, below: 1.0 };
            scene.camera = SceneView::read(&camera_table(&view.camera), "camera")?;
            // As the window shows it: by itself, on film, exposed by what it shows.
            scene.leave_ground();
            scene.background = Background::Colour(BEHIND_SRGB);
            (scene.exposure, scene.tone) = (Exposure::AUTO, Tone(ToneWord::Filmic));
        } else {
            scene.light.bearing = bearing;
            scene.light.radius_deg = view.light.radius_deg;
            let Camera { azimuth_deg, elevation_deg, width_mm, target_mm } = view.camera;
            scene.camera.bearing = Bearing { azimuth_deg, elevation_deg };
            (scene.camera.width_mm, scene.camera.target) = (width_mm, target_mm);
        }
        scene.check()?;
        Ok(scene)
    }

    /// The table of what balls and vanes are made of; `uv_mm`: what a unit of their texture coordinates is.
    fn skin(&self, typed: &Option<NamedStructure>, uv_mm: [f64; 2]) -> Result<Value> {
        match (typed, self.what()) {
            (Some(typed), _) => {
                let [width_um, length_um, cell_um] =
                    [BARBULE_LAYOUT.width_mm, BARBULE_LAYOUT.length_mm, BARBULE_LAYOUT.cell_mm]
                        .map(|mm| 1e3 * mm);
                Ok(json!({
                    "type": "barbule", "material": typed.name, "uv_mm": uv_mm,
                    "width_um": width_um, "length_um": length_um, "cell_um": cell_um,
                }))
            }
            (None, What::Grating(grating)) => Ok(self.grating(grating)),
            (None, _) => Err(Error::input(format!("a {} clads no surface", self.kind()))),
        }
    }

    fn grating(&self, grating: &Grating) -> Value {
        let mut table = json!({ "type": "grating", "pigment": PIGMENT, "index": GRATING_INDEX });
        match grating {
            Grating::File(_) => table["file"] = self.text().into(),
            Grating::Sample(name) => table["sample"] = (*name).into(),
        }
        table
    }

    fn on_the_snake(&self, view: &View) -> Result<SceneDescription> {
        let What::Grating(grating) = self.what() else {
            return Err(Error::input(format!("a {} is not shown on a snake", self.kind())));
        };
        let text = json!({
            "preset": SNAKE,
            "surfaces": { SKIN: self.grating(grating) },
            "light": light_table(&view.light),
            "camera": camera_table(&view.camera),
            "sky": view.light.sky,
            "exposure": "auto",
            "tone": "filmic",
        });
        parsed(&text)
    }
}

/// One object of one surface in a view's light.
fn object(shape: &Value, skin: Value, view: &View) -> Result<SceneDescription> {
    let mut object = json!({ "name": "object", "surface": SKIN });
    if let (Some(object), Some(shape)) = (object.as_object_mut(), shape.as_object()) {
        object.extend(shape.clone());
    }
    parsed(&json!({
        "shows_feather": false,
        "exposure": "auto",
        "tone": "filmic",
        "sky": view.light.sky,
        "sky_horizon": 1.0,
        "sky_below": 1.0,
        "background": { "colour": BEHIND },
        "light": light_table(&view.light),
        "camera": camera_table(&view.camera),
        "surfaces": { SKIN: skin },
        "objects": [object],
    }))
}

fn parsed(table: &Value) -> Result<SceneDescription> {
    let text = toml::to_string(table).map_err(|error| Error::machine(format!("no scene file: {error}")))?;
    SceneDescription::parse(&text)
}

/// What a unit of u and v is on the ball, mm: its parallels at the equator, and its meridians.
fn sphere_uv() -> [f64; 2] {
    [std::f64::consts::TAU * SPHERE_MM, std::f64::consts::PI * SPHERE_MM]
}

fn light_table(light: &Light) -> Value {
    json!({
        "azimuth_deg": light.azimuth_deg, "elevation_deg": light.elevation_deg,
        "radius_deg": light.radius_deg, "strength": light.strength,
    })
}

/// A camera as scene files have it: the same axes, whatever its elevation.
fn camera_table(camera: &Camera) -> Value {
    let Camera { azimuth_deg, elevation_deg, width_mm, target_mm } = *camera;
    let mut table = json!({
        "azimuth_deg": azimuth_deg, "elevation_deg": elevation_deg, "width_mm": width_mm, "target_mm": target_mm,
    });
    if elevation_deg.abs() <= STEEP_DEG {
        table["up"] = "z".into();
    } else {
        let away = if elevation_deg > 0.0 { 180.0 } else { 0.0 };
        table["roll_deg"] = (azimuth_deg + away).rem_euclid(360.0).into();
    }
    table
}

/// A name as a file's: letters, digits and - alone.
fn plain(name: &str) -> String {
    let stem =
        Path::new(name).file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let plain: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).take(60).collect();
    let plain = plain.trim_matches('-').trim_start_matches("my-").to_owned();
    if plain.is_empty() { "structure".into() } else { plain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::{DVec3, Unobserved};
    use std::collections::BTreeMap;

    fn opened(text: &str) -> Subject {
        Subject::open(text, &Opening::default(), &Unobserved).unwrap()
    }

    fn shown(subject: &Subject, view: &View) -> (SceneDescription, Vec<NeededFile>) {
        subject.scene(view, &Opening::default(), &Unobserved).unwrap()
    }

    /// The renderer's camera has the axes of the window's, stands as far away, and so shows the same.
    #[test]
    fn the_renderers_camera_is_the_windows() {
        let subject = opened("starling");
        for (azimuth_deg, elevation_deg) in
            [(180.0, 90.0), (180.0, 61.0), (77.0, 30.0), (300.0, 0.0), (20.0, -40.0), (250.0, -75.0)]
        {
            let camera = Camera { azimuth_deg, elevation_deg, width_mm: 3.0, target_mm: [0.5, 1.0, 0.2] };
            for mode in [Mode::Sphere, Mode::Feather] {
                let view = View { mode, camera, ..View::default() };
                let (scene, _) = shown(&subject, &view);
                let (made, own) = (scene.camera(), camera.frame());
                let back = made.eye - made.target;
                assert!((back.length() - Camera::DISTANCE * 3.0).abs() < 1e-9);
                let towards = back.normalize();
                let right = (-towards).cross(made.up).normalize();
                assert!(towards.distance(own.towards) < 1e-9 && made.target.distance(own.target_mm) < 1e-12);
                assert!(
                    right.distance(own.right) < 1e-9,
                    "{azimuth_deg} {elevation_deg}: {right} {}",
                    own.right
                );
            }
        }
    }

    #[test]
    fn every_mode_of_every_kind_is_a_scene_with_the_views_light() {
        for text in [
            "starling",
            "air/keratin:300/melanin",
            "xenopeltis",
            "starling-feather",
            "rock-dove:forest (below)",
        ] {
            let subject = opened(text);
            for &mode in subject.modes() {
                let light = Light { azimuth_deg: 90.0, elevation_deg: 0.0, ..Light::usual() };
                let view = View { mode, light, ..View::default() };
                let (scene, files) = shown(&subject, &view);
                assert!(scene.light.bearing.direction().distance(DVec3::X) < 1e-12, "{text} {mode:?}");
                assert_eq!(files.iter().any(|file| file.name == VANE_FILE), mode == Mode::Vane);
                // Its file is read as it.
                assert_eq!(
                    SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(),
                    scene,
                    "{text} {mode:?}"
                );
            }
        }
    }

    #[test]
    fn what_is_worn_is_what_is_open_with_what_was_moved() {
        let mut subject = opened("starling:pink");
        let view = View { mode: Mode::Feather, ..View::default() };
        assert_eq!(shown(&subject, &view).0.material(), Some("starling:pink"));
        subject.put(&BTreeMap::from([("cortex_um".to_owned(), 0.2)])).unwrap();
        let (scene, files) = shown(&subject, &view);
        assert_eq!(scene.material(), Some("my-starling.toml"));
        assert!(files[0].name == "my-starling.toml" && files[0].text.contains("cortex_um = 0.2"));
        let dressed = View { preset: Some("magpie".into()), ..view.clone() };
        assert_eq!(shown(&subject, &dressed).0.material(), Some("my-starling.toml"));
        let mut stack = opened("air/keratin:300/melanin");
        stack.put(&BTreeMap::from([("thickness_nm[0]".to_owned(), 250.0)])).unwrap();
        assert_eq!(stack.typed().unwrap().unwrap().name, "air/keratin:250/melanin");
        assert_eq!(opened("rock-dove (below)").typed().unwrap().unwrap().name, "rock-dove (below)");
        for (subject, view, words) in [
            (opened("snake"), view, "a scene is not shown as a feather; choose scene"),
            (
                opened("starling"),
                View { mode: Mode::Snake, ..View::default() },
                "a species is not shown as a snake; choose sphere",
            ),
            (
                opened("starling"),
                View { preset: Some("magpy".into()), ..View::default() },
                "preset: there is no preset 'magpy', did you mean 'magpie'?",
            ),
        ] {
            let refused = subject.scene(&view, &Opening::default(), &Unobserved).unwrap_err().to_string();
            assert!(refused.contains(words), "{refused}");
        }
    }

    #[test]
    fn names_of_files_are_plain() {
        assert_eq!(
            (plain("a/b c.toml"), plain("my-starling"), plain("//")),
            ("b-c".into(), "starling".into(), "structure".into())
        );
    }
}
