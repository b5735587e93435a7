//! `[detail]`: how finely a feather is made, and how its barbs are seen.

use serde::Serialize;
use serde_json::{Value, json};

use super::SceneDescription;
use super::kinds::unknown;
use crate::fields::Fields;
use crate::scene::feather::Level;
use crate::{Error, Result};

/// How finely a feather is made, and how its barbs are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Detail {
    /// Which parts stand there one by one.
    pub level: DetailLevel,
    /// How barbs are seen.
    pub view_model: ViewModel,
}

/// Which parts of a feather stand there one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum DetailLevel {
    /// As fine as the picture shows.
    #[default]
    Auto,
    /// This.
    Fixed(Level),
}

/// How barbs are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum ViewModel {
    /// As they grew, at the scene's level.
    #[default]
    Grown,
    /// As rami with barbules that are looked up on envelopes.
    Substructure,
    /// As one fibre each.
    Fibre,
    /// Both, side by side.
    Both,
}

const LEVELS: [(&str, DetailLevel); 5] = [
    ("auto", DetailLevel::Auto),
    ("barbules", DetailLevel::Fixed(Level::Barbules)),
    ("barbs", DetailLevel::Fixed(Level::Barbs)),
    ("vane", DetailLevel::Fixed(Level::Vane)),
    ("envelopes", DetailLevel::Fixed(Level::Envelopes)),
];

/// The finest pixel that is thought of, as a share of a picture's width.
const PIXEL: f64 = 1e-3;

/// Pixels as wide as this share of the distance between barbules show none.
const RESOLVES: f64 = 0.7;

/// Pixels as wide as this many barbs show a surface.
const BARBS: f64 = 3.0;

/// More barbules than this repeat.
const MOST_GROWN: f64 = 1.5e6;

impl ViewModel {
    /// All with their names.
    pub const ALL: [(&'static str, Self); 4] = [
        ("grown", Self::Grown),
        ("substructure", Self::Substructure),
        ("fibre", Self::Fibre),
        ("both", Self::Both),
    ];

    /// By its name.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn named(name: &str) -> Result<Self> {
        one_of("detail.view_model", name, &Self::ALL)
    }
}

impl Detail {
    pub(super) fn read(table: &Value) -> Result<Self> {
        let fields = Fields::new(table, "detail", &["level", "view_model"])?;
        let level = fields.text("level")?.map(level).transpose()?;
        let view_model = fields.text("view_model")?.map(ViewModel::named).transpose()?;
        Ok(Self { level: level.unwrap_or_default(), view_model: view_model.unwrap_or_default() })
    }

    /// The table that is read as this; nothing where all is as usual.
    pub(super) fn table(self) -> Option<Value> {
        let name = |known: &[(&'static str, ViewModel)]| {
            known.iter().find(|(_, m)| *m == self.view_model).map(|k| k.0)
        };
        let level = LEVELS.iter().find(|(_, level)| *level == self.level).map(|(name, _)| *name);
        (self != Self::default()).then(|| json!({"level": level, "view_model": name(&ViewModel::ALL)}))
    }
}

fn level(name: &str) -> Result<DetailLevel> {
    if name == "masked" {
        return Err(Error::input(
            "detail.level 'masked' is no longer drawn, as its light was off by up to a factor 2.7; give \"vane\", the same surface with the light of its barbules",
        ));
    }
    one_of("detail.level", name, &LEVELS)
}

fn one_of<T: Copy>(key: &str, name: &str, known: &[(&'static str, T)]) -> Result<T> {
    let found = known.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    found.ok_or_else(|| unknown(key, name, &known.iter().map(|(known, _)| *known).collect::<Vec<_>>()))
}

impl SceneDescription {
    /// How finely the feather is made: as the scene says, or as fine as a picture of a thousand pixels shows.
    #[must_use]
    pub fn level(&self) -> Level {
        match self.detail.level {
            _ if self.detail.view_model != ViewModel::Grown => Level::Envelopes,
            DetailLevel::Fixed(level) => level,
            DetailLevel::Auto => {
                let finest = self.feather.distal.spacing_um.min(self.feather.proximal.spacing_um);
                let is_resolved = PIXEL * self.camera.width_mm < RESOLVES * 1e-3 * finest;
                let many = self.feather.barbules_in(self.window) > MOST_GROWN;
                let shows_barbs = PIXEL * self.camera.width_mm < 1e-3 * BARBS * self.feather.barbs.spacing_um;
                match (is_resolved && !many, shows_barbs) {
                    (true, _) => Level::Barbules,
                    (false, true) => Level::Barbs,
                    (false, false) => Level::Vane,
                }
            }
        }
    }
}
