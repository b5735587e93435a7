//! The ground of a scene file: what it stands for, and when a preset's is left.

use super::colour::Colour;
use super::{LightShape, ObjectDescription, SceneDescription};
use crate::fields::{Map, Record as _, Value, within, wrong_kind};
use crate::{Error, Result, record};

record! {
    /// A matt square beneath a scene, in the plane z = −`below_mm`: sugar for a rectangle among the objects and its surface, both named ground.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(super) struct Ground {
        /// How far beneath the plane z = 0, the vane of a feather, it lies.
        below_mm: f64 = "below_mm", within(1e-3, 1e4), or 5.0;
        /// By how much it falls off towards the shaft's tip, about the origin's x: most feathers bend away from their window's plane.
        tilt_deg: f64 = "tilt_deg", within(-60, 60), or 0.0;
        /// What a screen shows of it in even daylight.
        colour: Colour = "colour", (), or Colour([0.5; 3]);
        /// Its sides.
        size_mm: f64 = "size_mm", within(1e-2, 1e5), or 1000.0;
    }
}

/// Its name as an object and as a surface.
pub(super) const GROUND: &str = "ground";

/// Whether a file changes what lies on the ground of the preset that it changes: another shape would stick in it, a body or other objects
/// stand elsewhere, a camera beneath would see nothing else, and a
/// background would not be seen.
fn leaves_ground(own: &Map<String, Value>) -> bool {
    let inner = |table: &str, key: &str| own.get(table).and_then(|table| table.get(key));
    let is_beneath =
        inner("camera", "elevation_deg").and_then(Value::as_f64).is_some_and(|angle| angle < 0.0);
    ["coat", "objects", "shows_feather", "background"].iter().any(|key| own.contains_key(*key))
        || inner("surfaces", GROUND).is_some()
        || own.get("feather").is_some_and(Value::is_string)
        || ["type", "shaft"].iter().any(|key| inner("feather", key).is_some())
        || inner("camera", "position_mm").is_some()
        || is_beneath
}

/// Takes the ground out of a preset's keys, where a file over them leaves it.
pub(super) fn leave(own: &Map<String, Value>, base: &mut Map<String, Value>) {
    if !base.contains_key(GROUND) || !leaves_ground(own) {
        return;
    }
    base.remove(GROUND);
    // Lamps that stand about what lay there would stand in what is there now.
    if let Some(Value::Array(lights)) = base.get_mut("lights") {
        lights.retain(|light| light.get("type").and_then(Value::as_str) == Some("sun"));
    }
}

impl SceneDescription {
    /// Takes its ground away, with the lamps that stand about what lay there: all but suns. A scene without a ground stays as it is.
    pub fn leave_ground(&mut self) {
        if self.objects.iter().any(ObjectDescription::is_ground) {
            self.objects.retain(|object| !object.is_ground());
            self.lights.retain(|light| matches!(light.shape, LightShape::Sun(_)));
        }
    }
}

/// Puts the ground of a file's keys among its objects and surfaces.
pub(super) fn spread(layer: &mut Map<String, Value>) -> Result<()> {
    let Some(table) = layer.remove(GROUND) else { return Ok(()) };
    let Ground { below_mm, tilt_deg, colour, size_mm } = Ground::read(&table, GROUND)?;
    let object = serde_json::json!({
        "name": GROUND, "surface": GROUND, "rectangle_mm": [size_mm, size_mm],
        "rotate_deg": [-tilt_deg, 0.0, 0.0], "translate_mm": [0.0, 0.0, -below_mm]
    });
    match layer.entry("objects").or_insert_with(|| Value::Array(Vec::new())) {
        Value::Array(objects) => objects.push(object),
        other => return Err(wrong_kind(other, "objects", "a list of tables")),
    }
    let surface = serde_json::json!({ "type": "diffuse", "colour": colour.0 });
    match layer.entry("surfaces").or_insert_with(|| Value::Object(Map::new())) {
        Value::Object(surfaces) if surfaces.contains_key(GROUND) => {
            Err(Error::input("ground and [surfaces.ground] are both given; leave one out"))
        }
        Value::Object(surfaces) => {
            surfaces.insert(GROUND.to_owned(), surface);
            Ok(())
        }
        other => Err(wrong_kind(other, "surfaces", "a table of tables")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::Background;
    use crate::scene::description::objects::ObjectShape;

    #[test]
    fn a_ground_is_a_rectangle_and_a_gradient_is_behind() {
        let text = "preset = 'starling'\nground = { below_mm = 2, colour = '#808080' }\nbackground = { gradient = ['#000000', '#ffffff'] }\n";
        let scene = SceneDescription::parse(text).unwrap();
        let ground = scene.objects.last().unwrap();
        assert_eq!((ground.label(), ground.place.translate_mm), ("ground", [0.0, 0.0, -2.0]));
        assert_eq!(ground.shape, ObjectShape::Rectangle { size_mm: [1000.0; 2] });
        assert_eq!(scene.background, Background::Gradient(vec![[0.0; 3], [1.0; 3]]));
        assert_eq!(SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(), scene);
        let refused = |text: &str| {
            SceneDescription::parse(&format!("preset = 'starling'\n{text}")).unwrap_err().to_string()
        };
        assert!(refused("ground = { belw_mm = 2 }").contains("did you mean 'below_mm'"));
        assert!(
            refused("ground = {}\n[surfaces.ground]\ntype = 'diffuse'\ncolour = '#ffffff'")
                .contains("both given")
        );
        assert!(refused("background = { gradient = ['#000000'] }").contains("background.gradient"));
        assert!(
            refused("background = { gradient = ['#000', '#fff'], colour = '#ffffff' }")
                .contains("background")
        );
    }

    /// A preset's ground goes, with the lamps that stand about it, where what lies on it is another; small changes leave it.
    #[test]
    fn a_presets_ground_goes_with_what_lies_on_it() {
        let parsed =
            |text: &str| SceneDescription::parse(&format!("preset = 'starling-feather'\n{text}")).unwrap();
        let has_ground = |scene: &SceneDescription| scene.objects.iter().any(ObjectDescription::is_ground);
        let whole = SceneDescription::named("starling-feather").unwrap();
        assert!(has_ground(&whole) && whole.lights.len() == 2);
        for kept in ["", "exposure = 1", "[feather.distal]\ntilt_deg = -20", "[camera]\nelevation_deg = 40"] {
            let scene = parsed(kept);
            assert!(has_ground(&scene) && scene.lights == whole.lights, "{kept}");
        }
        for gone in [
            "background = 'none'",
            "feather = 'tail'",
            "[feather.shaft]\nlength_mm = 40",
            "[camera]\nelevation_deg = -60",
            "[coat]\nellipsoid_mm = [9, 9, 9]\ncount = 3",
            "shows_feather = false\n[surfaces.a]\ntype = 'diffuse'\n[[objects]]\nsphere_mm = 1\nsurface = 'a'",
        ] {
            let scene = parsed(gone);
            assert!(!has_ground(&scene) && scene.lights == whole.lights[1..], "{gone}");
        }
        let own = parsed("ground = { below_mm = 9, tilt_deg = 10 }\n[feather.shaft]\nlength_mm = 40");
        let ground = own.objects.iter().find(|object| object.is_ground()).unwrap();
        assert_eq!((ground.place.translate_mm[2], ground.place.rotate_deg[0]), (-9.0, -10.0));
        let mut from_beneath = whole.clone();
        from_beneath.camera.bearing.elevation_deg = -60.0;
        from_beneath.uncover();
        assert!(!has_ground(&from_beneath) && from_beneath.objects.len() + 1 == whole.objects.len());
        assert_eq!(from_beneath.lights, whole.lights[1..]);
        let mut from_above = whole.clone();
        from_above.uncover();
        assert_eq!(from_above, whole);
    }
}
