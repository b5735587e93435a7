//! Scene files, in TOML: a whole scene, or a preset with changes.
//!
//! A file of one feather or coat says its parts at the top (`[feather]`, `[window]`, `material`, `[surfaces.shaft]` …): sugar for the first
//! of the objects.

use super::barbules::Under;
use super::coat::{CoatDescription, CoatObject};
use super::detail::Detail;
use super::dress::{Dress, FeatherObject, OF_MATERIAL, PARTS, Zone, dressed, of_parts};
use super::ground::{self, Ground};
use super::objects::{ObjectDescription, ObjectShape, Placement};
use super::slot::Slot;
use super::{SceneDescription, objects};
use crate::brdf::Reciprocity;
use crate::error::{did_you_mean, shortened};
use crate::fields::{
    FieldValue as _, Fields, Key, Map, Record as _, Text, Value, at_line, canonical, in_toml, parse_toml,
    up_to, wrong_kind,
};
use crate::scene::feather::{self, Feather, VaneDisc};
use crate::scene::preset;
use crate::{Error, Result, record};

record! {
    /// What a scene file may say beside a scene's own keys: which preset it changes, and the parts of its one feather or coat.
    #[derive(Debug, Clone, PartialEq)]
    struct LoneKeys {
        /// The preset that the file changes.
        preset: Option<String> = "preset", Text("the name of a preset");
        /// The material of the feather's barbules.
        material: Option<String> = "material", Text("a species, structure or .barbule file");
        /// What the lower sides of its barbules are made of.
        under: Under = "under", (), or Under::default();
        /// How its barbules are made to look the same when light and eye change places.
        reciprocity: Reciprocity = "reciprocity", (), or Reciprocity::Steeper;
        /// The feather: its sizes, or the name of a type.
        feather: Option<Feather> = "feather", ();
        /// Whether the feather is there; without it a scene has its other objects only.
        shows_feather: bool = "shows_feather", (), or true;
        /// The part of the feather that is grown.
        window: Option<VaneDisc> = "window", ();
        /// A matt ground beneath, on which everything throws its shadow.
        ground: Option<Ground> = "ground", ();
        /// How finely the feather is made.
        detail: Detail = "detail", (), or Detail::default();
        /// The body that the feather covers, many times, in place of standing alone.
        coat: Option<CoatDescription> = "coat", ();
        /// Places of the vane with a dress of their own.
        zones: Vec<Zone> = "zones", up_to(255), or Vec::new();
        /// A grey picture of the zones over the vane.
        zone_map: Option<Slot<crate::bsdf::Texture>> = "zone_map", Text("a grey .png");
        /// A picture of the vane that its fibres take their colours from.
        albedo: Option<Slot<crate::bsdf::Texture>> = "albedo", Text("the name of a .png, .exr or .hdr");
    }
}

/// All keys of scene files.
#[must_use]
pub fn scene_keys() -> Vec<Key> {
    let mut keys = LoneKeys::keys();
    // A coat's place stands in its own table there.
    if let Some(Key { kind: crate::fields::Kind::Table(coat), .. }) =
        keys.iter_mut().find(|key| key.name == "coat")
    {
        coat.extend(Placement::keys());
    }
    keys.extend(SceneDescription::keys());
    keys
}

impl SceneDescription {
    /// A preset by its name, or `SPECIES:VARIANT`: the species' preset with that variant's material.
    ///
    /// # Errors
    /// No such preset.
    pub fn named(name: &str) -> Result<Self> {
        let species = name.split_once(':').map_or(name, |(species, _)| species);
        let mut layer = preset_layer(species)?;
        if name.contains(':') {
            layer.insert("material".to_owned(), name.into());
        }
        of_layer(layer)
    }

    /// A scene file's text.
    ///
    /// # Errors
    /// Not TOML, an unknown key, a value that is missing, of the wrong kind or out of range.
    pub fn parse(text: &str) -> Result<Self> {
        let refuse = |error: Error| match error.to_string().contains("unknown key '") {
            true => at_line(error, text),
            false => in_toml(error, text),
        };
        let own = layer_of(text).map_err(refuse)?;
        let Some(name) = own.get("preset") else {
            return of_layer(own).map_err(|error| or_a_preset(refuse(error)));
        };
        let name =
            name.as_str().ok_or_else(|| wrong_kind(name, "preset", "a text in quotes")).map_err(refuse)?;
        let base = preset_layer(name).map_err(refuse)?;
        of_layer(over(own, base)).map_err(refuse)
    }

    /// The text of a scene file that needs no preset. Files are named as they are in the description.
    ///
    /// # Errors
    /// None for a description that was checked.
    pub fn to_toml(&self) -> Result<String> {
        let mut scene = Map::new();
        let lone = self.objects.first().and_then(lone_table);
        let rest = Self { objects: self.objects[usize::from(lone.is_some())..].to_vec(), ..self.clone() };
        rest.write_into(&mut scene);
        if self.lone_feather().is_none() && lone.is_none() {
            scene.insert("shows_feather".to_owned(), false.into());
        }
        for (key, value) in lone.into_iter().flatten() {
            match (scene.get_mut(&key), value) {
                (Some(Value::Object(own)), Value::Object(more)) => own.extend(more),
                (_, value) => _ = scene.insert(key, value),
            }
        }
        toml::to_string(&Value::Object(scene))
            .map_err(|error| Error::machine(format!("no scene file: {error}")))
    }
}

/// The keys of a preset's file, over those of the preset that it changes.
fn preset_layer(name: &str) -> Result<Map<String, Value>> {
    let own = layer_of(preset::toml(name)?)?;
    match own.get("preset").and_then(Value::as_str) {
        Some(base) => {
            let base = preset_layer(base)?;
            Ok(over(own, base))
        }
        None => Ok(own),
    }
}

/// A file's keys under their own names.
fn layer_of(text: &str) -> Result<Map<String, Value>> {
    let keys = scene_keys();
    let value = canonical(parse_toml(text)?, &keys, "")?;
    let known: Vec<&str> = keys.iter().map(|key| key.name).collect();
    let fields = Fields::new(&value, "", &known)?;
    // What one key says must be right where it stands, whatever a preset says of others.
    let tables = ["light", "camera", "window", "sky_image"];
    for key in keys.iter().filter(|key| tables.contains(&key.name)) {
        if let (Some(table), crate::fields::Kind::Table(inner)) = (fields.get(key.name), &key.kind) {
            let known: Vec<&str> = inner.iter().map(|key| key.name).collect();
            Fields::new(table, key.name, &known)?;
        }
    }
    if fields.get("sky").is_some() && fields.get("sky_image").is_some() {
        return Err(Error::input("sky and [sky_image] are both given; leave one out"));
    }
    match value {
        Value::Object(layer) => Ok(layer),
        other => Err(wrong_kind(&other, "the file", "a table of keys")),
    }
}

/// One file's keys, and the base's where there are none.
fn over(mut own: Map<String, Value>, mut base: Map<String, Value>) -> Map<String, Value> {
    base.remove("preset");
    if own.contains_key("sky") || own.contains_key("sky_image") {
        base.remove("sky");
        base.remove("sky_image");
    }
    ground::leave(&own, &mut base);
    // How far a window reaches is said by one of two keys.
    if let (Some(Value::Object(own)), Some(Value::Object(base))) =
        (own.get_mut("window"), base.get_mut("window"))
    {
        let shows_part = own.get("whole") == Some(&Value::Bool(false));
        if own.contains_key("radius_mm") || own.contains_key("whole") {
            base.remove("whole");
            if !shows_part {
                base.remove("radius_mm");
            }
        }
        if shows_part {
            own.remove("whole");
        }
    }
    // A coat grows on one body, and its feathers are counted in one way.
    if let (Some(Value::Object(own)), Some(Value::Object(base))) = (own.get("coat"), base.get_mut("coat")) {
        for either in [&["ellipsoid_mm", "form", "mesh"][..], &["count", "density_per_cm2"]] {
            if either.iter().any(|key| own.contains_key(*key)) {
                either.iter().for_each(|key| _ = base.remove(*key));
            }
        }
    }
    if let Some(feather) = feather::layered(own.remove("feather"), base.remove("feather")) {
        own.insert("feather".to_owned(), feather);
    }
    for (key, value) in base {
        let both = match (own.remove(&key), value) {
            (Some(own), base)
                if ["light", "camera", "window", "detail", "surfaces", "coat"].contains(&key.as_str()) =>
            {
                merged(own, base)
            }
            (Some(own), _) => own,
            (None, base) => base,
        };
        own.insert(key, both);
    }
    own
}

/// A table with the keys of both; where both have one that is no table, this one's value holds.
fn merged(own: Value, base: Value) -> Value {
    match (own, base) {
        (Value::Object(own), Value::Object(mut base)) => {
            for (key, value) in own {
                let both = match base.remove(&key) {
                    Some(base) => merged(value, base),
                    None => value,
                };
                base.insert(key, both);
            }
            Value::Object(base)
        }
        (own, _) => own,
    }
}

/// The scene of a file's keys.
fn of_layer(mut layer: Map<String, Value>) -> Result<SceneDescription> {
    layer.remove("preset");
    ground::spread(&mut layer)?;
    let named = match layer.get("surfaces") {
        Some(Value::Object(tables)) => tables.clone(),
        _ => Map::new(),
    };
    refuse_misspelt_parts(&named)?;
    let lone = take_lone(&mut layer, &named)?;
    if let Some(Value::Array(list)) = layer.get("objects") {
        let one = |(i, object): (usize, &Value)| dressed(object, &named, &format!("objects[{i}]"));
        let objects = list.iter().enumerate().map(one).collect::<Result<Vec<_>>>()?;
        layer.insert("objects".to_owned(), objects.into());
    }
    let mut scene = SceneDescription::read(&Value::Object(layer), "")?;
    scene.objects.splice(0..0, lone);
    scene.frame_of("camera.about", scene.camera.about.as_deref())?;
    if scene.objects.len() > objects::MOST_OBJECTS {
        return Err(Error::input(format!("objects: over the limit of {}", objects::MOST_OBJECTS)));
    }
    Ok(scene)
}

/// Refuses tables that are no surfaces of their own and have nearly the name of a feather's part.
fn refuse_misspelt_parts(surfaces: &Map<String, Value>) -> Result<()> {
    let is_typed = |table: &Value| table.get("type").is_some();
    for (name, _) in
        surfaces.iter().filter(|(name, table)| !PARTS.contains(&name.as_str()) && !is_typed(table))
    {
        let near = did_you_mean(name, PARTS);
        if !near.is_empty() {
            let name = shortened(name);
            return Err(Error::input(format!(
                "surfaces.{name} has no type and is no part of a feather{near}"
            )));
        }
    }
    Ok(())
}

/// Takes the parts of a lone feather or coat out of a file's keys.
fn take_lone(
    layer: &mut Map<String, Value>,
    named: &Map<String, Value>,
) -> Result<Option<ObjectDescription>> {
    let parts = match layer.get_mut("surfaces") {
        Some(Value::Object(tables)) => {
            let is_part = |name: &str, table: &Value| PARTS.contains(&name) && table.get("type").is_none();
            let names: Vec<String> = tables
                .iter()
                .filter(|(name, table)| is_part(name, table))
                .map(|(name, _)| name.clone())
                .collect();
            names.into_iter().filter_map(|name| Some((name.clone(), tables.remove(&name)?))).collect()
        }
        _ => Map::new(),
    };
    let mut take = |key: &str| layer.remove(key);
    let of_material = OF_MATERIAL.into_iter().filter_map(|key| Some((key.to_owned(), take(key)?)));
    let of_material: Map<String, Value> = of_material.collect();
    let (feather, coat) = (take("feather"), take("coat"));
    let (window, detail) = (take("window"), take("detail"));
    let (zones, zone_map, albedo) = (take("zones"), take("zone_map"), take("albedo"));
    let shows =
        take("shows_feather").map_or(Ok(true), |value| bool::of_value(&value, "shows_feather", &()))?;
    if !shows {
        return match coat {
            Some(_) => {
                Err(Error::input("shows_feather is false, but [coat] is made of the feather; leave one out"))
            }
            None => Ok(None),
        };
    }
    if of_material.is_empty() && feather.is_none() && coat.is_none() && parts.is_empty() {
        return Ok(None);
    }
    let feather = Feather::read(&feather.unwrap_or_else(|| Value::Object(Map::new())), "feather")?;
    let detail = detail.map_or(Ok(Detail::default()), |table| Detail::read(&table, "detail"))?;
    let ramus = if parts.contains_key("hair") { "surfaces.hair" } else { "surfaces.ramus" };
    let dress = Dress::read(&of_parts(of_material, parts)?, "surfaces").map_err(|e| of_sides(e, ramus))?;
    if let Some(coat) = coat {
        let (coat, place) = placed(coat)?;
        let coat = dressed(&serde_json::json!({ "coat": coat }), named, "")?;
        let coat = CoatDescription::read(&coat["coat"], "coat")?;
        let of = CoatObject { coat, feather, detail, dress };
        of.agree("")?;
        return Ok(Some(ObjectDescription {
            place,
            ..ObjectDescription::here("coat", ObjectShape::Coat(Box::new(of)))
        }));
    }
    let window = window.map_or(Ok(VaneDisc::WHOLE), |table| VaneDisc::read(&table, "window"))?;
    let mut zoned = Map::new();
    zoned.extend(zones.map(|zones| ("zones".to_owned(), zones)));
    zoned.extend(zone_map.map(|map| ("zone_map".to_owned(), map)));
    zoned.extend(albedo.map(|picture| ("albedo".to_owned(), picture)));
    let zoned = dressed(&Value::Object(zoned), named, "")?;
    let fields = Fields::new(&zoned, "", &["zones", "zone_map", "albedo"])?;
    let zones =
        fields.get("zones").map_or(Ok(Vec::new()), |zones| Vec::of_value(zones, "zones", &up_to(255)))?;
    let zone_map = fields.text("zone_map")?.map(Slot::new);
    let albedo = fields.text("albedo")?.map(Slot::new);
    let of = FeatherObject { feather, window, detail, dress, zones, zone_map, albedo };
    of.agree("")?;
    Ok(Some(ObjectDescription::here("feather", ObjectShape::Feather(Box::new(of)))))
}

/// A coat's table without its body's place, and that place.
fn placed(coat: Value) -> Result<(Value, Placement)> {
    let Value::Object(mut coat) = coat else { return Err(wrong_kind(&coat, "coat", "a table of keys")) };
    let keys: Vec<&str> = Placement::keys().iter().map(|key| key.name).collect();
    let place: Map<String, Value> =
        keys.into_iter().filter_map(|key| Some((key.to_owned(), coat.remove(key)?))).collect();
    Ok((Value::Object(coat), Placement::read(&Value::Object(place), "coat")?))
}

/// The same error with the path of the table in which a lone feather's file says it; `ramus` is that of its rami.
fn of_sides(error: Error, ramus: &str) -> Error {
    let text = error.to_string();
    let text = text
        .replace("surfaces.distal.underside", "surfaces.underside")
        .replace("surfaces.distal.under ", "under ")
        .replace("surfaces.distal.reciprocity", "reciprocity")
        .replace("surfaces.distal", "surfaces.barbule")
        .replace("surfaces.ramus", ramus);
    Error::input(text)
}

/// The keys at the top of a file that say an object; nothing where they cannot.
fn lone_table(object: &ObjectDescription) -> Option<Map<String, Value>> {
    if !object.stands_at_top() {
        return None;
    }
    let (dress, mut table) = match &object.shape {
        ObjectShape::Feather(of) => {
            let mut table = Map::new();
            table.insert("window".to_owned(), of.window.table());
            table.extend(of.zones.to_value(&up_to(255)).map(|zones| ("zones".to_owned(), zones)));
            let pictures = [("zone_map", &of.zone_map), ("albedo", &of.albedo)];
            let named = pictures.into_iter().filter_map(|(key, slot)| Some((key, slot.as_ref()?)));
            table.extend(named.map(|(key, slot)| (key.to_owned(), slot.name.as_str().into())));
            table.insert("feather".to_owned(), of.feather.table());
            table.insert("detail".to_owned(), of.detail.table());
            (&of.dress, table)
        }
        ObjectShape::Coat(of) => {
            let mut coat = Map::new();
            of.coat.write_into(&mut coat);
            object.place.write_into(&mut coat);
            let mut table = Map::new();
            table.insert("coat".to_owned(), Value::Object(coat));
            table.insert("feather".to_owned(), of.feather.table());
            table.insert("detail".to_owned(), of.detail.table());
            (&of.dress, table)
        }
        _ => return None,
    };
    let (of_material, parts) = dress.as_parts()?;
    table.extend(of_material);
    table.insert("surfaces".to_owned(), Value::Object(parts));
    Some(table)
}

/// A missing key may be a preset's.
fn or_a_preset(error: Error) -> Error {
    if error.to_string().contains(" is missing; give") {
        return error.followed_by(", or preset = \"starling\" to change a preset");
    }
    error
}

#[cfg(test)]
mod tests;
