//! Feathers of a scene: what their parts are made of, and where on the vane that is something else.

use super::albedo;
use super::barbules::BarbuleClothing;
use super::detail::{Detail, DetailLevel, ViewModel};
use super::slot::Slot;
use super::surfaces::{EvenPaint, FibreDescription, FilmDescription, PigmentedKeratin, no_surface};
use crate::bsdf::{self, Region, Texture, ZonePlan};
use crate::error::shortened;
use crate::fields::{Map, Value, path_of, unknown, within};
use crate::scene::feather::{Feather, Level, VaneDisc};
use crate::scene::memory::Rami;
use crate::{Error, Result, record, variants};

/// A feather of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatherObject {
    /// Its sizes.
    pub feather: Feather,
    /// The part of it that is grown.
    pub window: VaneDisc,
    /// How finely it is made.
    pub detail: Detail,
    /// What its parts are made of.
    pub dress: Dress,
    /// Places of the vane with a dress of their own.
    pub zones: Vec<Zone>,
    /// A picture that says which zone is where.
    pub zone_map: Option<Slot<Texture>>,
    /// A picture of the vane that its fibres take their colours from.
    pub albedo: Option<Slot<Texture>>,
}

/// Down where nothing is said: grey.
const DOWN: FibreDescription = FibreDescription {
    longitudinal_roughness: 0.3,
    azimuthal_roughness: 0.4,
    scale_tilt_deg: 0.0,
    index: None,
    eumelanin: 2.0,
    pheomelanin: 0.0,
    colour: None,
    vane_colour: None,
    height_over_width: 1.0,
};

/// Keratin of pale places where nothing is said: buff.
const PALE: PigmentedKeratin = PigmentedKeratin { roughness: 0.4, index: 1.56, melanin: 0.15 };

/// A dark shaft and dark rami, where nothing is said.
const SHAFT: PigmentedKeratin = PigmentedKeratin { roughness: 0.22, index: 1.56, melanin: 4.0 };
const RAMUS: PigmentedKeratin = PigmentedKeratin { roughness: 0.25, index: 1.56, melanin: 20.0 };

variants! {
    /// What rami are made of.
    #[derive(Debug, Clone, PartialEq)]
    pub enum RamusDress by "type" {
        /// Pigmented keratin.
        "keratin": Keratin(PigmentedKeratin),
        /// A fibre of hair.
        "hair": Hair(FibreDescription),
        /// Paint.
        "diffuse": Paint(EvenPaint),
    }
}

variants! {
    /// What barbules are made of.
    #[derive(Debug, Clone, PartialEq)]
    pub enum BarbuleDress by "type" {
        /// Plates of a computed material.
        "barbule": Barbule(BarbuleClothing),
        /// Fibres without structural colour.
        "hair": Hair(FibreDescription),
        /// Plates with a film of layers.
        "film": Film(FilmDescription),
        /// Plates of paint.
        "diffuse": Paint(EvenPaint),
    }
}

record! {
    /// What the parts of a feather are made of.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Dress {
        /// The shaft: keratin.
        shaft: PigmentedKeratin = "shaft", (), or SHAFT;
        /// The rami of the barbs.
        ramus: RamusDress = "ramus", (), or RamusDress::Keratin(RAMUS);
        /// Barbules on the barbs' side that faces the feather's tip.
        distal: BarbuleDress = "distal", ();
        /// Barbules on the other side.
        proximal: BarbuleDress = "proximal", ();
        /// Barbules of pale places: keratin.
        pale: PigmentedKeratin = "pale", (), or PALE;
        /// Barbs and barbules of the downy part: fibres.
        down: FibreDescription = "down", (), or DOWN;
    }
}

record! {
    /// A place of the vane with a dress of its own.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Zone {
        /// From where to where it reaches, as shares of the vane from its base (0) to its tip (1).
        along: [f64; 2] = "along", within(0, 1), or [0.0, 1.0];
        /// From where to where across: -1 is the left edge where the vane is widest, 0 the shaft, 1 the right edge.
        across: [f64; 2] = "across", within(-1, 1), or [-1.0, 1.0];
        /// A ring or disc to which it is confined.
        ring: Option<Ring> = "ring", ();
        /// Standard deviation of its border from barbule to barbule.
        edge_mm: f64 = "edge_mm", within(0, 100), or 0.0;
        /// What its rami are made of, if something else.
        ramus: Option<RamusDress> = "ramus", ();
        /// What its barbules towards the feather's tip are made of.
        distal: Option<BarbuleDress> = "distal", ();
        /// What its other barbules are made of.
        proximal: Option<BarbuleDress> = "proximal", ();
        @agree Zone::agree;
    }
}

record! {
    /// An elliptic ring on the vane.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Ring {
        /// Its middle: right of the shaft, and along it from the vane's base.
        centre_mm: [f64; 2] = "centre_mm", within(-2000, 2000);
        /// Its inner and outer half axis across the vane.
        radii_mm: [f64; 2] = "radii_mm", within(0, 2000);
        /// Length along the vane over width.
        stretch: f64 = "stretch", within(0.05, 20), or 1.0;
        /// How much wider it is on each mm towards the feather's tip, as a share.
        widening_per_mm: f64 = "widening_per_mm", within(-1, 1), or 0.0;
        /// A notch on its side towards the feather's base: depth and width; none where the depth is 0.
        notch_mm: [f64; 2] = "notch_mm", within(0, 2000), or [0.0, 1.0];
        @agree Ring::agree;
    }
}

impl Ring {
    fn agree(&self, place: &str) -> Result<()> {
        if self.notch_mm[1] <= 0.0 {
            return Err(Error::input(format!("{place}.notch_mm[1], the notch's width, is 0; give more")));
        }
        Ok(())
    }
}

impl Zone {
    fn agree(&self, place: &str) -> Result<()> {
        let ring = self.ring.map(|ring| ("ring.radii_mm", ring.radii_mm));
        for (key, [low, high]) in [("along", self.along), ("across", self.across)].into_iter().chain(ring) {
            if low >= high {
                return Err(Error::input(format!(
                    "{} is from {low} to {high}; give the smaller number first",
                    path_of(place, key)
                )));
            }
        }
        Ok(())
    }

    /// All of the vane, as the feather itself is dressed.
    pub(super) fn everywhere() -> Self {
        let (along, across) = ([0.0, 1.0], [-1.0, 1.0]);
        Self { along, across, ring: None, edge_mm: 0.0, ramus: None, distal: None, proximal: None }
    }

    /// Its barbules that wear a material.
    pub(super) fn clothing_mut(&mut self) -> impl Iterator<Item = &mut BarbuleClothing> {
        [self.distal.as_mut(), self.proximal.as_mut()]
            .into_iter()
            .flatten()
            .filter_map(BarbuleDress::clothing_mut)
    }

    /// Where it is, if no picture says so.
    fn region(&self) -> Region {
        let ring = self.ring.map(|Ring { centre_mm, radii_mm, stretch, widening_per_mm, notch_mm }| {
            bsdf::Ring { centre_mm, radii_mm, stretch, widening_per_mm, notch_mm }
        });
        Region { along: self.along, across: self.across, ring, edge_mm: self.edge_mm }
    }

    /// What it changes: the rami, the barbules on both sides.
    fn kinds(&self) -> [Option<(&'static str, &'static str)>; 3] {
        let barbules = |key, dress: &Option<BarbuleDress>| dress.as_ref().map(|of| (key, plates(of.word())));
        [
            self.ramus.as_ref().map(|of| ("ramus", of.word())),
            barbules("distal", &self.distal),
            barbules("proximal", &self.proximal),
        ]
    }
}

/// The type of barbules, that of plates for all that are plates: zones may mix these.
fn plates(word: &'static str) -> &'static str {
    if matches!(word, "film" | "diffuse") { "barbule" } else { word }
}

impl FeatherObject {
    /// Refuses a map without zones and, where barbs are envelopes on which parts are looked up, zones that change what parts are and not only
    /// what they are made of.
    pub(super) fn agree(&self, place: &str) -> Result<()> {
        let is_looked_up =
            self.detail.level == DetailLevel::Envelopes || self.detail.view_model != ViewModel::Grown;
        let looked_up = if is_looked_up { &self.zones[..] } else { &[] };
        let own =
            [self.dress.ramus.word(), plates(self.dress.distal.word()), plates(self.dress.proximal.word())];
        for (i, zone) in looked_up.iter().enumerate() {
            for ((key, kind), own) in
                zone.kinds().into_iter().zip(own).filter_map(|(of, own)| Some((of?, own)))
            {
                if kind != own {
                    return Err(Error::input(format!(
                        "{}[{i}].{key} is of type '{kind}', but the feather's own is '{own}', which envelopes cannot mix; give the same type or another detail.level",
                        path_of(place, "zones")
                    )));
                }
            }
        }
        if self.zone_map.is_some() && self.zones.is_empty() {
            return Err(Error::input(format!(
                "{} is given, but there are no zones",
                path_of(place, "zone_map")
            )));
        }
        self.agree_on_albedo(place)
    }
}

impl FeatherObject {
    /// The same with the places of its zones, and not what they wear, in a mirror: left is right.
    ///
    /// # Errors
    /// A map that is not read.
    pub(super) fn with_zones_mirrored(mut self) -> Result<Self> {
        for zone in &mut self.zones {
            let [low, high] = zone.across;
            zone.across = [-high, -low];
            if let Some(ring) = &mut zone.ring {
                ring.centre_mm[0] = -ring.centre_mm[0];
            }
        }
        for map in self.zone_map.iter_mut().chain(&mut self.albedo) {
            let (mirrored, hash) = (map.value()?.mirrored(), format!("{} mirrored", map.hash()));
            map.fill(mirrored, hash);
        }
        Ok(self)
    }

    /// Memory that it takes while it grows and its hierarchy is built, bytes, at most and about; `width_mm`: of the picture, on it.
    pub(super) fn bytes(&self, width_mm: f64) -> f64 {
        let copies = if self.detail.view_model == ViewModel::Both { 2.0 } else { 1.0 };
        copies * self.feather.bytes(self.window, self.level(width_mm), self.rami(), self.layers())
    }

    /// Places of stretches of its barbules, where these repeat.
    pub(super) fn places(&self, width_mm: f64) -> f64 {
        if self.level(width_mm) == Level::Barbs { self.feather.places_in(self.window) } else { 0.0 }
    }

    /// How much of that is for what its vanes show, where they are sheets.
    pub(super) fn shown_bytes(&self, width_mm: f64) -> f64 {
        match self.level(width_mm) {
            Level::Vane => self.feather.shown_bytes(self.rami(), self.layers()),
            _ => 0.0,
        }
    }

    /// How many zones it has, or will have by its picture.
    pub(super) fn zone_count(&self) -> usize {
        self.albedo.as_ref().map_or(self.zones.len(), albedo::zones)
    }

    fn rami(&self) -> Rami {
        if matches!(self.dress.ramus, RamusDress::Hair(_)) { Rami::Fibres } else { Rami::Meshes }
    }

    /// Sorts of places that its vanes show.
    fn layers(&self) -> usize {
        1 + self.zone_count() + usize::from(self.feather.pattern.pattern().is_some())
    }

    /// Where its zones lie; nothing where there are none.
    ///
    /// # Errors
    /// A picture of zones that is not read, or has others.
    pub fn zone_plan(&self) -> Result<Option<ZonePlan>> {
        if self.zones.is_empty() {
            return Ok(None);
        }
        let Some(map) = &self.zone_map else {
            return Ok(Some(ZonePlan::Regions(self.zones.iter().map(Zone::region).collect())));
        };
        let picture = Texture::clone(map.value()?);
        let highest = picture.highest_value().map_err(|error| error.at(&map.name))?;
        if highest != self.zones.len() {
            return Err(Error::input(format!(
                "{}: has pixels of values 0 to {highest} (of 255), but there are {} zones",
                map.name,
                self.zones.len()
            )));
        }
        let edge_mm = self.zones.iter().map(|zone| zone.edge_mm).fold(0.0, f64::max);
        Ok(Some(ZonePlan::Picture { picture, edge_mm }))
    }
}

impl BarbuleDress {
    fn clothing_mut(&mut self) -> Option<&mut BarbuleClothing> {
        match self {
            Self::Barbule(of) => Some(of),
            Self::Hair(_) | Self::Film(_) | Self::Paint(_) => None,
        }
    }
}

impl Dress {
    /// The usual dark parts, with barbules of a material on both sides of the barbs.
    #[must_use]
    pub fn of(material: &str) -> Self {
        let barbules = BarbuleDress::Barbule(BarbuleClothing::of(material));
        Self {
            shaft: SHAFT,
            ramus: RamusDress::Keratin(RAMUS),
            distal: barbules.clone(),
            proximal: barbules,
            pale: PALE,
            down: DOWN,
        }
    }

    /// The name of its barbules' material, if they have one.
    #[must_use]
    pub fn material(&self) -> Option<&str> {
        [&self.distal, &self.proximal].into_iter().find_map(|of| match of {
            BarbuleDress::Barbule(of) => Some(of.material.name.as_str()),
            BarbuleDress::Hair(_) | BarbuleDress::Film(_) | BarbuleDress::Paint(_) => None,
        })
    }

    /// Its barbules that wear a material.
    pub(super) fn clothing_mut(&mut self) -> impl Iterator<Item = &mut BarbuleClothing> {
        [&mut self.distal, &mut self.proximal].into_iter().filter_map(BarbuleDress::clothing_mut)
    }

    pub(super) fn missing(path: &str) -> Error {
        Error::input(format!(
            "{path} is missing; give a species, structure or .barbule file, or what the barbules are made of"
        ))
    }

    /// The tables `[surfaces.shaft]` … of a lone feather's file and its keys of the barbules' material, where these can say it.
    pub(super) fn as_parts(&self) -> Option<(Map<String, Value>, Map<String, Value>)> {
        // What a lone feather's file cannot say stands in the dress of an object.
        if self.distal != self.proximal || matches!(self.ramus, RamusDress::Paint(_)) {
            return None;
        }
        let Value::Object(mut parts) = crate::fields::Record::table(self) else { return None };
        let mut of = |key: &str| parts.remove(key);
        let (ramus, barbule) = (of("ramus"), of("distal"));
        of("proximal");
        let plain = |table: Option<Value>| match table {
            Some(Value::Object(mut table)) => {
                table.remove("type");
                Some(Value::Object(table))
            }
            other => other,
        };
        let key = if matches!(self.ramus, RamusDress::Hair(_)) { "hair" } else { "ramus" };
        parts.extend(plain(ramus).map(|table| (key.to_owned(), table)));
        match &self.distal {
            BarbuleDress::Hair(_) => {
                parts.extend(plain(barbule).map(|table| ("barbule".to_owned(), table)));
                Some((Map::new(), parts))
            }
            BarbuleDress::Film(_) | BarbuleDress::Paint(_) => None,
            BarbuleDress::Barbule(of) => {
                let BarbuleClothing { uv_mm, width_um, length_um, cell_um, .. } =
                    BarbuleClothing::of(&of.material.name);
                if of.uv_mm != uv_mm
                    || [of.width_um, of.length_um, of.cell_um] != [width_um, length_um, cell_um]
                {
                    return None;
                }
                parts.insert("underside".to_owned(), crate::fields::Record::table(&of.underside));
                let Value::Object(mut keys) = crate::fields::Record::table(of) else { return None };
                keys.retain(|key, _| OF_MATERIAL.contains(&key.as_str()));
                let usual = BarbuleClothing::of("");
                if of.under.is_default() {
                    keys.remove("under");
                }
                if of.reciprocity == usual.reciprocity {
                    keys.remove("reciprocity");
                }
                Some((keys, parts))
            }
        }
    }
}

/// Keys that beside the parts of a feather are those of all its barbules that wear a material.
pub(super) const OF_MATERIAL: [&str; 3] = ["material", "under", "reciprocity"];

/// The parts of a feather that `[surfaces]` of a lone feather's file names.
pub(super) const PARTS: [&str; 7] = ["shaft", "ramus", "underside", "hair", "barbule", "pale", "down"];

/// The dress that a lone feather's keys [`OF_MATERIAL`] and `[surfaces.shaft]` … say, as the table `dress`.
///
/// # Errors
/// There is neither a material nor plain barbules.
pub(super) fn of_parts(of_material: Map<String, Value>, mut parts: Map<String, Value>) -> Result<Value> {
    let mut typed = |key: &str, kind: &str| {
        let mut table = parts.remove(key)?;
        if let Value::Object(table) = &mut table {
            table.insert("type".to_owned(), kind.into());
        }
        Some(table)
    };
    let (hair, keratin, barbule) =
        (typed("hair", "hair"), typed("ramus", "keratin"), typed("barbule", "hair"));
    let underside = parts.remove("underside");
    let barbules = match barbule {
        Some(barbule) => barbule,
        None if of_material.contains_key("material") => {
            let mut table = of_material;
            table.insert("type".to_owned(), "barbule".into());
            table.extend(underside.map(|underside| ("underside".to_owned(), underside)));
            Value::Object(table)
        }
        None => return Err(Dress::missing("material")),
    };
    parts.extend(hair.or(keratin).map(|ramus| ("ramus".to_owned(), ramus)));
    parts.insert("distal".to_owned(), barbules.clone());
    parts.insert("proximal".to_owned(), barbules);
    Ok(Value::Object(parts))
}

/// An object's table in which names of surfaces in its dress and zones are those surfaces, and its `material` is that of its barbules.
///
/// # Errors
/// There is no surface of a name, or it is of a type that the part cannot have.
pub(super) fn dressed(object: &Value, surfaces: &Map<String, Value>, place: &str) -> Result<Value> {
    let Value::Object(object) = object else { return Ok(object.clone()) };
    let mut object = object.clone();
    let is_plumage = ["feather", "coat", "row"].into_iter().any(|key| object.contains_key(key));
    // What is no plumage refuses such keys as those that it does not know.
    if is_plumage && let Some(dress) = dress_of(&object, "dress", surfaces, place)? {
        object.retain(|key, _| !OF_MATERIAL.contains(&key.as_str()));
        object.insert("dress".to_owned(), dress);
    }
    if let Some(Value::Array(zones)) = object.get("zones") {
        let path = path_of(place, "zones");
        let zones =
            zones.iter().enumerate().map(|(i, zone)| with_names(zone, surfaces, &format!("{path}[{i}]")));
        let zones = zones.collect::<Result<Vec<_>>>()?;
        object.insert("zones".to_owned(), zones.into());
    }
    for shape in ["coat", "row"] {
        let Some(Value::Array(kinds)) = object.get(shape).and_then(|of| of.get("feathers")) else { continue };
        let path = format!("{}.feathers", path_of(place, shape));
        let kinds =
            kinds.iter().enumerate().map(|(i, kind)| dressed(kind, surfaces, &format!("{path}[{i}]")));
        let kinds = kinds.collect::<Result<Vec<_>>>()?;
        if let Some(Value::Object(of)) = object.get_mut(shape) {
            of.insert("feathers".to_owned(), kinds.into());
        }
    }
    Ok(Value::Object(object))
}

/// The table under `key` with the keys [`OF_MATERIAL`] and names written out; nothing where neither it nor such a key is given.
fn dress_of(
    object: &Map<String, Value>,
    key: &str,
    surfaces: &Map<String, Value>,
    place: &str,
) -> Result<Option<Value>> {
    let of_material =
        OF_MATERIAL.into_iter().filter_map(|key| Some((key.to_owned(), object.get(key)?.clone())));
    let of_material: Map<String, Value> = of_material.collect();
    let mut table = match object.get(key) {
        None if of_material.is_empty() => return Ok(None),
        None => Map::new(),
        Some(Value::Object(table)) => table.clone(),
        Some(other) => return Ok(Some(other.clone())),
    };
    table.extend(of_material);
    with_names(&Value::Object(table), surfaces, &path_of(place, key)).map(Some)
}

/// Which types of surfaces a part may have, and whether that is said in its table.
const TYPES: [(&str, &[&str], bool); 6] = [
    ("shaft", &["keratin"], false),
    ("ramus", &["keratin", "hair", "diffuse"], true),
    ("distal", &["barbule", "hair", "film", "diffuse"], true),
    ("proximal", &["barbule", "hair", "film", "diffuse"], true),
    ("pale", &["keratin"], false),
    ("down", &["hair"], false),
];

/// A dress's or zone's table in which names are the surfaces, and the keys [`OF_MATERIAL`] those of its barbules: `material` is what those
/// are made of that are not given, the others are said of all that do not say it themselves.
fn with_names(table: &Value, surfaces: &Map<String, Value>, place: &str) -> Result<Value> {
    let Value::Object(table) = table else { return Ok(table.clone()) };
    let mut table = table.clone();
    let of_material: Vec<(&str, Value)> =
        OF_MATERIAL.into_iter().filter_map(|key| Some((key, table.remove(key)?))).collect();
    if let Some((_, material)) = of_material.iter().find(|(key, _)| *key == "material") {
        let barbules = serde_json::json!({"type": "barbule", "material": material});
        for side in ["distal", "proximal"] {
            table.entry(side).or_insert_with(|| barbules.clone());
        }
    }
    for (part, types, is_said) in TYPES {
        let Some(value) = table.get_mut(part) else { continue };
        let path = path_of(place, part);
        if let Value::String(name) = value {
            let named = surfaces.get(name.as_str()).filter(|surface| surface.get("type").is_some());
            let known = surfaces.keys().map(String::as_str);
            *value = named.cloned().ok_or_else(|| no_surface(&path, name, known))?;
            let kind = value.get("type").and_then(Value::as_str).unwrap_or_default();
            if !types.contains(&kind) {
                let kind = shortened(kind);
                return Err(Error::input(format!(
                    "{path} is a surface of type '{kind}'; give one of type {}",
                    types.join(" or ")
                )));
            }
        }
        if let Value::Object(of) = value {
            match of.get("type").and_then(Value::as_str) {
                Some(kind) if !types.contains(&kind) => {
                    return Err(unknown(&format!("{path}.type"), kind, types));
                }
                Some(_) if !is_said => _ = of.remove("type"),
                // The first type is the usual one.
                None if is_said => _ = of.insert("type".to_owned(), types[0].into()),
                _ => {}
            }
        }
    }
    for (key, value) in of_material.iter().filter(|(key, _)| *key != "material") {
        let mut is_worn = false;
        for side in ["distal", "proximal"] {
            let Some(Value::Object(of)) = table.get_mut(side) else { continue };
            if of.get("type").is_some_and(|kind| kind == "barbule") {
                of.entry(*key).or_insert_with(|| value.clone());
                is_worn = true;
            }
        }
        if !is_worn {
            let path = path_of(place, key);
            return Err(Error::input(format!(
                "{path} is given, but no barbules of a material; give one, too"
            )));
        }
    }
    Ok(Value::Object(table))
}
