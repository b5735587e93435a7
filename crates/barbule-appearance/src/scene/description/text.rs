//! A description as the text of a scene file: read again it is the same scene, to the bit.

use serde_json::{Map, Value, json};

use super::{
    Background, FibreDescription, LightColour, LightDescription, LightShape, ObjectDescription,
    PigmentedKeratin, SceneDescription, SkyDescription, View, ViewProjection,
};
use crate::{Error, Result};

impl SceneDescription {
    /// The text of a scene file that needs no preset. Files are named as they are in the description.
    ///
    /// # Errors
    /// None for a description that was checked.
    pub fn to_toml(&self) -> Result<String> {
        let mut scene = Map::new();
        let mut put = |key: &str, value: Value| scene.insert(key.to_owned(), value);
        if !self.material.is_empty() {
            put("material", self.material.as_str().into());
        }
        put("exposure", self.exposure.map_or("auto".into(), Value::from));
        put("scatterings", self.scatterings.into());
        if let Some(size) = self.size {
            put("size", json!(size));
        }
        if self.turn_deg != 0.0 {
            put("turn_deg", self.turn_deg.into());
        }
        match &self.sky {
            SkyDescription::Gradient { zenith, horizon, below } => {
                put("sky", (*zenith).into());
                put("sky_horizon", (*horizon).into());
                put("sky_below", (*below).into())
            }
            SkyDescription::Image(image) => put(
                "sky_image",
                json!({"file": image.file, "strength": image.strength, "turn_deg": image.turn_deg}),
            ),
        };
        match &self.background {
            Background::Sky => None,
            Background::None => put("background", "none".into()),
            Background::Colour(colour) => put("background", json!({"colour": colour})),
            Background::Picture { file, .. } => put("background", json!({"file": file})),
        };
        let light = &self.light;
        put(
            "light",
            json!({
                "azimuth_deg": light.bearing.azimuth_deg,
                "elevation_deg": light.bearing.elevation_deg,
                "radius_deg": light.radius_deg,
                "strength": light.strength,
            }),
        );
        if !self.lights.is_empty() {
            put("lights", self.lights.iter().map(LightDescription::table).collect());
        }
        put("camera", self.camera.table());
        put(
            "window",
            match self.window.radius_mm {
                Some(radius) => json!({"along_mm": self.window.along_mm, "radius_mm": radius}),
                None => json!({"along_mm": self.window.along_mm, "whole": true}),
            },
        );
        if let Some(detail) = self.detail.table() {
            put("detail", detail);
        }
        let surfaces = &self.surfaces;
        let mut parts = json!({
            "shaft": surfaces.shaft.table(),
            "ramus": surfaces.ramus.table(),
            "underside": surfaces.underside.table(),
        });
        if let Value::Object(parts) = &mut parts {
            let fibres = [("hair", &surfaces.hair), ("barbule", &surfaces.barbule)];
            let fibres = fibres
                .into_iter()
                .filter_map(|(name, fibre)| Some((name.to_owned(), fibre.as_ref()?.table())));
            parts.extend(fibres);
            parts.insert("pale".to_owned(), surfaces.pale.table());
            parts.insert("down".to_owned(), surfaces.down.table());
            parts.extend(self.named_surfaces.iter().map(|(name, surface)| (name.clone(), surface.table())));
        }
        put("surfaces", parts);
        put("feather", self.feather.table());
        if !self.shows_feather {
            put("shows_feather", false.into());
        }
        if let Some(coat) = &self.coat {
            put("coat", coat.table());
        }
        if !self.objects.is_empty() {
            put("objects", self.objects.iter().map(ObjectDescription::table).collect());
        }
        toml::to_string(&Value::Object(scene))
            .map_err(|error| Error::machine(format!("no scene file: {error}")))
    }
}

/// A table without the keys that have no value.
fn table<const N: usize>(entries: [(&str, Option<Value>); N]) -> Value {
    let given = entries.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?)));
    Value::Object(given.collect())
}

impl View {
    fn table(&self) -> Value {
        let orthographic = self.projection == ViewProjection::Orthographic;
        table([
            ("azimuth_deg", Some(self.bearing.azimuth_deg.into())),
            ("elevation_deg", Some(self.bearing.elevation_deg.into())),
            ("roll_deg", Some(self.roll_deg.into())),
            ("width_mm", Some(self.width_mm.into())),
            ("lens", Some(self.lens.into())),
            ("projection", orthographic.then(|| "orthographic".into())),
            ("position_mm", self.position.map(|position| json!(position))),
            ("target_mm", (self.target != [0.0; 3]).then(|| json!(self.target))),
            ("focal_length_mm", self.focal_length_mm.map(Value::from)),
            ("focus_distance_mm", self.focus_distance_mm.map(Value::from)),
            ("f_number", self.f_number.map(Value::from)),
        ])
    }
}

impl PigmentedKeratin {
    pub(super) fn table(&self) -> Value {
        json!({"roughness": self.roughness, "index": self.index, "melanin": self.melanin})
    }
}

impl FibreDescription {
    pub(super) fn table(&self) -> Value {
        table([
            ("longitudinal_roughness", Some(self.longitudinal_roughness.into())),
            ("azimuthal_roughness", Some(self.azimuthal_roughness.into())),
            ("scale_tilt_deg", Some(self.scale_tilt_deg.into())),
            ("index", self.index.map(Value::from)),
            ("eumelanin", Some(self.eumelanin.into())),
            ("pheomelanin", Some(self.pheomelanin.into())),
            ("height_over_width", Some(self.height_over_width.into())),
        ])
    }
}

impl LightDescription {
    fn table(&self) -> Value {
        let shape = match self.shape {
            LightShape::Sun { bearing, radius_deg } => json!({
                "type": "sun",
                "azimuth_deg": bearing.azimuth_deg,
                "elevation_deg": bearing.elevation_deg,
                "radius_deg": radius_deg,
            }),
            LightShape::Point { position } => json!({"type": "point", "position_mm": position}),
            LightShape::Spot { position, target, cone_deg, edge_deg } => json!({
                "type": "spot",
                "position_mm": position,
                "target_mm": target,
                "cone_deg": cone_deg,
                "edge_deg": edge_deg,
            }),
            LightShape::Sphere { position, radius_mm } => {
                json!({"type": "sphere", "position_mm": position, "radius_mm": radius_mm})
            }
            LightShape::Rectangle { position, target, size_mm } => json!({
                "type": "rectangle",
                "position_mm": position,
                "target_mm": target,
                "size_mm": size_mm,
            }),
        };
        let colour = match &self.colour {
            LightColour::Illuminant(name) => ("illuminant", json!(name)),
            LightColour::Rgb(rgb) => ("colour", json!(rgb)),
            LightColour::Table { file, .. } => ("spectrum", json!(file)),
        };
        let mut light = shape;
        if let Value::Object(light) = &mut light {
            light.insert(colour.0.to_owned(), colour.1);
            light.insert("strength".to_owned(), self.strength.into());
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;

    #[test]
    fn a_scene_comes_back_from_its_text() {
        for name in preset::names() {
            let scene = SceneDescription::named(name).unwrap();
            let text = scene.to_toml().unwrap();
            assert_eq!(SceneDescription::parse(&text).unwrap(), scene, "{text}");
            // Round numbers stay round.
            assert!(text.contains("base_angle_deg") && !text.contains("0000000"), "{text}");
        }
        let text = "preset = 'magpie'\nexposure = 'auto'\nsize = [40, 20]\nturn = 12.5\n[background]\nfile = 'wall.png'\n\
                    [sky_image]\nfile = 'sky.exr'\n[surfaces.hair]\neumelanin = 0.3\nheight_over_width = 2.5\n\
                    [camera]\nprojection = 'orthographic'\ntarget_mm = [0.5, 0, 0]\nposition_mm = [0, 1, 9]\n\
                    [[lights]]\ntype = 'sun'\nazimuth_deg = 10\nelevation_deg = 30\nstrength = 1\nspectrum = 'lamp.csv'\n\
                    [[lights]]\ntype = 'point'\nposition_mm = [1, 2, 3]\nstrength = 1\ncolour = '#ffa040'\n\
                    [[lights]]\ntype = 'spot'\nposition_mm = [1, 2, 3]\ncone_deg = 20\nstrength = 1\n\
                    [[lights]]\ntype = 'sphere'\nazimuth_deg = 1\nelevation_deg = 2\ndistance_mm = 30\nradius_mm = 2\nstrength = 1\n\
                    [[lights]]\ntype = 'rectangle'\nposition_mm = [1, 2, 3]\nsize_mm = [1, 2]\nstrength = 1\n";
        let text = format!(
            "shows_feather = false\n{text}[surfaces.glass]\ntype = 'dielectric'\nindex = 1.3\n\
             [surfaces.red]\ntype = 'diffuse'\ncolour = '#ff8000'\nalbedo = 'a.png'\nalpha = 'b.exr'\nnormal = 'c.png'\n\
             [surfaces.horn]\ntype = 'keratin'\nroughness = 0.2\nindex = 1.5\nmelanin = 3\n[surfaces.fur]\ntype = 'hair'\n\
             [[objects]]\nname = 'ball'\nsphere_mm = 2.5\nsurface = 'glass'\nrotate_deg = [1, 2, 3]\n\
             [[objects]]\nmesh = 'a.ply'\nsurface = 'red'\ninstances = [{{scale = 2}}, {{translate_mm = [1, 2, 3]}}]\n\
             [[objects]]\nrectangle_mm = [1, 2]\nsurface = 'horn'\n\
             [surfaces.pan]\ntype = 'conductor'\nroughness = 0.1\nmetal = 'copper'\n\
             [surfaces.steel]\ntype = 'conductor'\nroughness = [0.1, 0.3]\nindex = 2.5\nabsorption = 3.4\n\
             [[objects]]\ncurves = 'a.txt'\nsurface = 'pan'\n\
             [[objects]]\ncurves = 'b.txt'\nbasis = 'linear'\nsurface = 'steel'\n"
        );
        let scene = SceneDescription::parse(&text).unwrap();
        assert_eq!(SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(), scene);
        let mut focused = SceneDescription::named("starling").unwrap();
        focused.camera.focus_distance_mm = Some(14.0);
        focused.camera.focal_length_mm = Some(85.0);
        focused.camera.f_number = Some(11.0);
        focused.window.radius_mm = None;
        focused.sky = SkyDescription::Gradient { zenith: 0.5, horizon: 1.0, below: 1.0 };
        assert_eq!(SceneDescription::parse(&focused.to_toml().unwrap()).unwrap(), focused);
    }
}
