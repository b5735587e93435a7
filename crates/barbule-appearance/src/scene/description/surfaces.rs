//! `[surfaces.NAME]`: what things are made of.

use std::collections::{BTreeMap, BTreeSet};

use super::barbules::BarbuleClothing;
use super::colour::Colour;
use super::slot::Slot;
use crate::bsdf::{
    Absorption, Conductor, Dielectric, FacetRoughness, FibreIndex, Grating, Hair, HairParameters, Keratin,
    Lambertian, Measured, MeasuredTables, PhaseFilm, Pictures, Reflectance, Relief, RoughDielectric, Surface,
    SurfaceMap, Texture, ThinFilm,
};
use crate::error::{did_you_mean, shortened};
use crate::fields::{FieldValue, Kind, Map, Record, Several, Text, Value, path_of, within, wrong_kind};
use crate::identity::Hasher;
use crate::material::{Library, Table};
use crate::scattering::grating::Powers;
use crate::spectrum::colour::decode;
use crate::stack::Stack;
use crate::{Error, Result, record, variants, words};

/// Least reflectance of a colour of fibres.
const DARKEST: f64 = 0.002;

/// Most surfaces of a map: as many as an 8-bit grey tells apart.
const MOST_MAPPED: usize = 256;

/// Where nothing is said: four are 65 µm, the side of patches that heights are measured on, beyond which nothing is known of how the
/// surface goes on. Lobes are 0.22° wide at 550 nm (standard deviation), before any lamp.
const USUAL_COHERENCE_UM: f64 = 16.25;

variants! {
    /// A surface with a name.
    #[derive(Debug, Clone, PartialEq)]
    pub enum NamedSurface by "type" {
        /// Perfectly diffuse.
        "diffuse": Diffuse(Diffuse),
        /// Pigmented keratin.
        "keratin": Keratin(PigmentedKeratin),
        /// Fibres of hair.
        "hair": Hair(FibreDescription),
        /// Glass, clear or frosted.
        "dielectric": Dielectric(Glass),
        /// Rough metal.
        "conductor": Conductor(RoughMetal),
        /// Layers over a rough base.
        "film": Film(FilmDescription),
        /// A diffraction grating over pigment.
        "grating": Grating(GratingDescription),
        /// Tables of measured light.
        "measured": Measured(MeasuredFile),
        /// Others, chosen from place to place.
        "map": Map(SurfacesByPlace),
        /// Paint that is iridescent where it is blue, as a picture of 2005 had it.
        "film-2005": Film2005(FilmOf2005),
        /// Barbules of a computed material.
        "barbule": Barbule(BarbuleClothing),
    }
}

record! {
    /// Perfectly diffuse.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Diffuse {
        /// Its colour.
        colour: Colour = "colour", (), or Colour::WHITE;
        /// A picture that the colour is multiplied with.
        albedo: Option<Slot<Texture>> = "albedo", Text("the name of a .png, .exr or .hdr");
        /// A picture that is black where there are holes.
        alpha: Option<Slot<Texture>> = "alpha", Text("the name of a .png, .exr or .hdr");
        /// A picture of normals.
        normal: Option<Slot<Texture>> = "normal", Text("the name of a .png, .exr or .hdr");
        /// A picture of heights.
        bump: Option<Slot<Texture>> = "bump", Text("the name of a .png, .exr or .hdr");
        /// Height where `bump` is white.
        bump_um: Option<f64> = "bump_um", within(-1e5, 1e5);
        @agree Diffuse::agree;
    }
}

record! {
    /// Paint that is iridescent where it is blue: cos² δ of a phase that is taken twice too large.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FilmOf2005 {
        /// Thickness of the film.
        thickness_nm: f64 = "thickness_nm", within(1, 1e5), or 140.0;
        /// Its refractive index.
        index: f64 = "index", within(1.01, 3.9), or 1.54;
        @flat {
            /// The paint.
            paint: Diffuse;
        }
    }
}

record! {
    /// Paint of one colour on barbs and barbules.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct EvenPaint {
        /// Its colour.
        colour: Colour = "colour", (), or Colour::WHITE;
    }
}

record! {
    /// Keratin with pigment.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PigmentedKeratin {
        /// GGX α of the boundary.
        roughness: f64 = "roughness", within(0.02, 1);
        /// Refractive index.
        index: f64 = "index", within(1.01, 3.9);
        /// Melanin: absorption over scattering at 550 nm; 0 is white, 1 brown, 20 nearly black.
        melanin: f64 = "melanin", within(0, 1e6);
    }
}

record! {
    /// A fibre of the hair model; where nothing is said a ramus without pigment.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct FibreDescription {
        /// How far lobes spread along the fibre.
        longitudinal_roughness: f64 = "longitudinal_roughness", within(0.02, 1), or 0.3;
        /// How far they spread around it.
        azimuthal_roughness: f64 = "azimuthal_roughness", within(0.02, 1), or 0.4;
        /// By how much scales stand off it.
        scale_tilt_deg: f64 = "scale_tilt_deg", within(-20, 20), or 0.0;
        /// Refractive index; that of feather keratin at each wavelength where there is none.
        index: Option<f64> = "index", within(1.01, 3.9);
        /// Concentration of eumelanin: 0.3 is blond, 1.3 brown, 8 black.
        eumelanin: f64 = "eumelanin", within(0, 1e3), or 0.0;
        /// Concentration of pheomelanin.
        pheomelanin: f64 = "pheomelanin", within(0, 1e3), or 0.0;
        /// In place of both, what colour a mass of such fibres has.
        colour: Option<Colour> = "colour", ();
        /// In place of that, what a closed vane of such fibres has on white in even light.
        vane_colour: Option<Colour> = "vane_colour", ();
        /// Height of the section, along the vane's normal, over its width.
        height_over_width: f64 = "height_over_width", within(0.1, 10), or 1.0;
        @agree FibreDescription::agree;
    }
}

record! {
    /// Glass.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Glass {
        /// Refractive index.
        index: f64 = "index", within(1.01, 3.9);
        /// GGX α; smooth where there is none.
        roughness: Option<FacetRoughness> = "roughness", ();
    }
}

words! {
    /// Metals whose index is known.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Metal {
        /// Copper by Johnson & Christy.
        "copper": Copper,
        /// Gold by the same.
        "gold": Gold,
        /// Silver by the same.
        "silver": Silver,
        /// Aluminium by Rakić.
        "aluminium": Aluminium,
    }
}

record! {
    /// Rough metal.
    #[derive(Debug, Clone, PartialEq)]
    pub struct RoughMetal {
        /// GGX α.
        roughness: FacetRoughness = "roughness", ();
        /// What it is.
        metal: Option<Metal> = "metal", ();
        /// n of its index n + ik at all wavelengths.
        index: Option<f64> = "index", within(0.001, 100);
        /// k of its index.
        absorption: Option<f64> = "absorption", within(0, 100);
        @agree RoughMetal::agree;
    }
}

record! {
    /// Layers over a rough base.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FilmDescription {
        /// The layers from outside, in the language of stacks.
        stack: String = "stack", Text("layers such as air/keratin:400/melanin");
        /// GGX α.
        roughness: FacetRoughness = "roughness", ();
        /// Colour of a diffuse body beneath.
        colour: Option<Colour> = "colour", ();
        @agree FilmDescription::agree;
    }
}

record! {
    /// A grating of a scene.
    #[derive(Debug, Clone, PartialEq)]
    pub struct GratingDescription {
        /// A built-in sample whose heights it has.
        sample: Option<Slot<Powers>> = "sample", Text("the name of a sample");
        /// A file whose orders it has.
        file: Option<Slot<Powers>> = "file", Text("the name of a .grating");
        /// Colour of what is beneath.
        pigment: Colour = "pigment", (), or Colour::BLACK;
        /// Refractive index.
        index: f64 = "index", within(1.01, 3.9), or 1.5;
        /// Standard deviation of the window of coherence.
        coherence_um: f64 = "coherence_um", within(0.5, 1000), or USUAL_COHERENCE_UM;
        @agree GratingDescription::agree;
    }
}

record! {
    /// A measured material.
    #[derive(Debug, Clone, PartialEq)]
    pub struct MeasuredFile {
        /// The file of its tables.
        file: Slot<MeasuredTables> = "file", Text("the name of an RGL .bsdf or a MERL .binary");
    }
}

record! {
    /// Several surfaces by the places that a picture says.
    #[derive(Debug, Clone, PartialEq)]
    pub struct SurfacesByPlace {
        /// A grey picture: pixels of value i (of 255) are the i-th surface.
        file: Slot<Texture> = "file", Text("a grey .png");
        /// Names of tables [surfaces.NAME].
        surfaces: Vec<String> = "surfaces",
            Several { least: 1, most: MOST_MAPPED, of: Text("the name of a table [surfaces.NAME]") };
    }
}

/// One number for both, or two: along and across.
impl FieldValue for FacetRoughness {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        let range = within(0.02, 1);
        let [along, across] = match value {
            Value::Array(values) if values.len() != 2 => {
                return Err(Error::input(format!(
                    "{path}: give one number or two (along, across), each 0.02 to 1"
                )));
            }
            Value::Array(_) => <[f64; 2]>::of_value(value, path, &range)?,
            one => [f64::of_value(one, path, &range)?; 2],
        };
        Ok(Self { along, across })
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        Some(vec![self.along, self.across].into())
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        [self.along, self.across].check_value(path, &within(0.02, 1))
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.numbers(key, &[self.along, self.across]);
    }

    fn kind((): &()) -> Kind {
        let one = Kind::Number { low: 0.02, high: 1.0, whole: false };
        Kind::Either(vec![one.clone(), Kind::List { of: Box::new(one), least: 2, most: 2 }])
    }
}

impl Diffuse {
    fn agree(&self, place: &str) -> Result<()> {
        let both = |one: &str, other: &str| {
            Err(Error::input(format!("{place}.{one} and {place}.{other} are both given; leave one out")))
        };
        match (&self.normal, &self.bump, self.bump_um) {
            (Some(_), Some(_), _) => both("normal", "bump"),
            (_, None, Some(_)) => {
                Err(Error::input(format!("{place}.bump_um is given, but there is no picture {place}.bump")))
            }
            (_, Some(_), None) => {
                Err(Error::input(format!("{place}.bump_um is missing; give a number from -100000 to 100000")))
            }
            _ => Ok(()),
        }
    }

    fn build(&self) -> Result<Lambertian> {
        let read = |slot: &Option<Slot<Texture>>| {
            slot.as_ref().map(|slot| slot.value().map(|texture| Texture::clone(texture))).transpose()
        };
        let white_mm = self.bump_um.unwrap_or_default() * 1e-3;
        let heights = read(&self.bump)?.map(|picture| Relief::Heights { picture, white_mm });
        let relief = read(&self.normal)?.map(Relief::Normals).or(heights);
        let pictures = Pictures { albedo: read(&self.albedo)?, alpha: read(&self.alpha)?, relief };
        Lambertian::painted(self.colour.0.map(decode), pictures)
    }
}

impl EvenPaint {
    pub(super) fn build(&self) -> Result<Lambertian> {
        Lambertian::painted(self.colour.0.map(decode), Pictures::default())
    }
}

impl PigmentedKeratin {
    pub(super) fn build(&self) -> Result<Keratin> {
        Keratin::new(self.roughness, self.index, Reflectance::melanin(self.melanin)?)
    }
}

/// Fibres over a place of a vane where no feather is known: those of contour feathers.
const USUAL_COVER: f64 = 1.2;

impl FibreDescription {
    fn agree(&self, place: &str) -> Result<()> {
        let given = [
            ("colour", self.colour.is_some()),
            ("vane_colour", self.vane_colour.is_some()),
            ("eumelanin", self.eumelanin > 0.0),
            ("pheomelanin", self.pheomelanin > 0.0),
        ];
        let given: Vec<&str> = given.iter().filter(|(_, is_given)| *is_given).map(|(key, _)| *key).collect();
        if given.len() > 1 && given[0] != "eumelanin" {
            return Err(Error::input(format!(
                "{} is given beside {}; give one colour, or pigments",
                path_of(place, given[0]),
                given[1]
            )));
        }
        Ok(())
    }

    /// The same of the colour of a closed vane in place of what else colours it.
    pub(super) fn with_vane_colour(&self, colour: Colour) -> Self {
        Self { colour: None, vane_colour: Some(colour), eumelanin: 0.0, pheomelanin: 0.0, ..*self }
    }

    pub(super) fn build(&self) -> Result<Hair> {
        self.build_on(USUAL_COVER)
    }

    /// A fibre of a vane with so many fibres over a place.
    pub(super) fn build_on(&self, cover: f64) -> Result<Hair> {
        Hair::new(HairParameters {
            longitudinal_roughness: self.longitudinal_roughness,
            azimuthal_roughness: self.azimuthal_roughness,
            scale_tilt: self.scale_tilt_deg.to_radians(),
            index: self.fibre_index(),
            absorption: self.absorption(cover)?,
            height_over_width: self.height_over_width,
        })
    }

    fn fibre_index(&self) -> FibreIndex {
        self.index.map_or(FibreIndex::Keratin, FibreIndex::Constant)
    }

    /// A mass of fibres is at least [`DARKEST`]: nothing that absorbs everything has a depth.
    pub(super) fn absorption(&self, cover: f64) -> Result<Absorption> {
        match (self.vane_colour, self.colour) {
            (Some(vane), _) => {
                Absorption::of_vane(&Reflectance::of_colour(vane.0.map(decode))?, cover, self.fibre_index())
            }
            (None, Some(mass)) => {
                let light = mass.0.map(|value| decode(value).max(DARKEST));
                Absorption::of_reflectance(&Reflectance::of_colour(light)?, self.azimuthal_roughness)
            }
            (None, None) => Absorption::pigments(self.eumelanin, self.pheomelanin),
        }
    }
}

impl RoughMetal {
    fn agree(&self, place: &str) -> Result<()> {
        let constant = self.index.is_some() || self.absorption.is_some();
        if self.metal.is_some() == constant {
            let has = if constant { "a metal and an index" } else { "no metal" };
            let known: Vec<&str> = Metal::ALL.iter().map(|(word, _)| *word).collect();
            return Err(Error::input(format!(
                "{place} has {has}; give either metal ({}) or index and absorption (n and k)",
                known.join(", ")
            )));
        }
        for (key, value) in [("index", self.index), ("absorption", self.absorption)] {
            if constant && value.is_none() {
                return Err(Error::input(format!("{place}.{key} is missing; give n and k")));
            }
        }
        Ok(())
    }

    fn build(&self) -> Result<Conductor> {
        match (self.metal, self.index.zip(self.absorption)) {
            (Some(metal), _) => {
                let table = match metal {
                    Metal::Copper => Table::copper(),
                    Metal::Gold => Table::gold(),
                    Metal::Silver => Table::silver(),
                    Metal::Aluminium => Table::aluminium(),
                };
                Conductor::of_table(self.roughness, &table)
            }
            (None, constant) => {
                let (index, absorption) = constant.unwrap_or_default();
                Conductor::new(self.roughness, |_| [index, absorption])
            }
        }
    }
}

impl FilmDescription {
    fn agree(&self, place: &str) -> Result<()> {
        let stack = Stack::parse(&self.stack, &Library::builtin());
        stack.map(|_| ()).map_err(|error| error.at(path_of(place, "stack")))
    }

    pub(super) fn build(&self) -> Result<ThinFilm> {
        let body = self.colour.map(|colour| Reflectance::of_colour(colour.0.map(decode))).transpose()?;
        ThinFilm::new(&Stack::parse(&self.stack, &Library::builtin())?, self.roughness, body)
    }
}

impl GratingDescription {
    fn agree(&self, place: &str) -> Result<()> {
        if self.sample.is_some() != self.file.is_some() {
            return Ok(());
        }
        let has = if self.file.is_some() { "two" } else { "no" };
        Err(Error::input(format!("{place} has {has} heights; give either sample or file")))
    }

    /// The powers of its orders.
    pub(super) fn powers(&self) -> Option<&Slot<Powers>> {
        self.sample.as_ref().or(self.file.as_ref())
    }

    fn build(&self) -> Result<Grating> {
        let powers = self.powers().ok_or_else(|| Error::input("a grating has no heights"))?;
        Grating::new(powers.value()?, self.coherence_um, self.index, self.pigment.0.map(decode))
    }
}

impl NamedSurface {
    /// The surface; `all`: those that a map chooses among.
    pub(super) fn build(&self, all: &Surfaces) -> Result<Surface> {
        Ok(match self {
            Self::Diffuse(of) => Surface::Lambertian(of.build()?),
            Self::Keratin(of) => Surface::Keratin(of.build()?),
            Self::Hair(of) => Surface::Hair(of.build()?),
            Self::Dielectric(Glass { index, roughness: None }) => {
                Surface::Dielectric(Dielectric::new(*index)?)
            }
            Self::Dielectric(Glass { index, roughness: Some(roughness) }) => {
                Surface::RoughDielectric(RoughDielectric::new(*roughness, *index)?)
            }
            Self::Film(of) => Surface::ThinFilm(of.build()?),
            Self::Conductor(of) => Surface::Conductor(of.build()?),
            Self::Grating(of) => Surface::Grating(of.build()?),
            Self::Measured(of) => Surface::Measured(Measured::new(of.file.value()?.clone())),
            Self::Map(SurfacesByPlace { file, surfaces }) => {
                let one = |name: &String| match all.0.get(name) {
                    Some(Self::Map(_)) | None => {
                        Err(Error::input(format!("a map has no surface '{name}' to choose")))
                    }
                    Some(surface) => surface.build(all),
                };
                let surfaces = surfaces.iter().map(one).collect::<Result<_>>()?;
                let map = SurfaceMap::new(Texture::clone(file.value()?), surfaces);
                Surface::Map(map.map_err(|error| error.at(&file.name))?)
            }
            Self::Film2005(FilmOf2005 { thickness_nm, index, paint }) => {
                Surface::Lambertian(paint.build()?.iridescent(PhaseFilm::new(*thickness_nm, *index)?))
            }
            Self::Barbule(of) => Surface::Clad(Box::new(of.clad()?)),
        })
    }
}

/// The tables `[surfaces.NAME]`, by their names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surfaces(pub BTreeMap<String, NamedSurface>);

impl Surfaces {
    /// The surface of a name; `path` is the key that names it.
    ///
    /// # Errors
    /// There is none of this name; the nearest is offered.
    pub fn named(&self, path: &str, name: &str) -> Result<&NamedSurface> {
        self.0.get(name).ok_or_else(|| no_surface(path, name, self.0.keys().map(String::as_str)))
    }

    /// The names of those that these name, themselves or through a map.
    pub(super) fn used_by<'a>(&'a self, names: impl Iterator<Item = &'a str>) -> BTreeSet<&'a str> {
        let mut used: BTreeSet<&str> = names.collect();
        let maps = used.iter().filter_map(|name| match self.0.get(*name) {
            Some(NamedSurface::Map(map)) => Some(&map.surfaces),
            _ => None,
        });
        let through: Vec<&str> = maps.flatten().map(String::as_str).collect();
        used.extend(through);
        used
    }

    /// Refuses a map of surfaces that do not exist or are maps themselves.
    fn check_maps(&self, place: &str) -> Result<()> {
        for (map, surface) in &self.0 {
            let NamedSurface::Map(SurfacesByPlace { surfaces, .. }) = surface else { continue };
            for (i, name) in surfaces.iter().enumerate() {
                let path = format!("{}.surfaces[{i}]", path_of(place, &shortened(map)));
                if let NamedSurface::Map(_) = self.named(&path, name)? {
                    let name = shortened(name);
                    return Err(Error::input(format!(
                        "{path} is the map '{name}'; give surfaces that are no maps"
                    )));
                }
            }
        }
        Ok(())
    }
}

/// The refusal of a name that no surface has.
pub(super) fn no_surface<'a>(path: &str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Error {
    let near = did_you_mean(name, known);
    let name = shortened(name);
    Error::input(format!("{path} is '{name}'{near}; there is no table [surfaces.{name}] with a type"))
}

impl FieldValue for Surfaces {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        let Value::Object(tables) = value else { return Err(wrong_kind(value, path, "a table of tables")) };
        let read = |(name, table): (&String, &Value)| {
            Ok((name.clone(), NamedSurface::read(table, &path_of(path, &shortened(name)))?))
        };
        let all = Self(tables.iter().map(read).collect::<Result<_>>()?);
        all.check_maps(path).map(|()| all)
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        let tables: Map<String, Value> =
            self.0.iter().map(|(name, surface)| (name.clone(), surface.table())).collect();
        (!tables.is_empty()).then_some(Value::Object(tables))
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        self.0.iter().try_for_each(|(name, surface)| surface.check(&path_of(path, &shortened(name))))?;
        self.check_maps(path)
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.count(key, self.0.len() as u64);
        for (name, surface) in &self.0 {
            to.text(key, name);
            surface.feed_fields(to);
        }
    }

    fn kind((): &()) -> Kind {
        Kind::Named(Box::new(Kind::Table(NamedSurface::keys())))
    }
}

#[cfg(test)]
mod tests;
