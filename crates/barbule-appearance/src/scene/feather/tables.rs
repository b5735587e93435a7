//! The table `[feather]` of files: a type's sizes, and over them whatever the file gives.

use serde_json::Value;

use super::sizes::{BarbShape, BarbuleShape, Disorder, DownyShape, PatternShape, ShaftShape, SplitShape};
use super::types;
use crate::error::{did_you_mean, shortened};
use crate::fields::Fields;
use crate::{Error, Result};

/// The type of a feather of which nothing is said.
const USUAL_TYPE: &str = "contour";

/// Keys of `[feather.barbs]` that mean both vanes.
const BOTH_VANES: [(&str, [&str; 2]); 3] = [
    ("vane_half_width_mm", ["leading_half_width_mm", "trailing_half_width_mm"]),
    ("base_angle_deg", ["leading_base_angle_deg", "trailing_base_angle_deg"]),
    ("tip_angle_deg", ["leading_tip_angle_deg", "trailing_tip_angle_deg"]),
];

/// Which side of the shaft the leading vane is on, seen from the dorsal side with the tip upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum LeadingSide {
    /// Left, as in a right wing.
    Left,
    /// Right, as in a left wing.
    Right,
}

impl LeadingSide {
    const ALL: [(&'static str, Self); 2] = [("left", Self::Left), ("right", Self::Right)];

    /// −1: left, 1: right.
    #[must_use]
    pub fn sign(self) -> f64 {
        if self == Self::Left { -1.0 } else { 1.0 }
    }
}

/// A whole feather.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Feather {
    /// Where the leading vane is.
    pub leading: LeadingSide,
    /// The shaft.
    pub shaft: ShaftShape,
    /// The barbs.
    pub barbs: BarbShape,
    /// Barbules on the barbs' side that faces the feather's tip.
    pub distal: BarbuleShape,
    /// Barbules on the other side.
    pub proximal: BarbuleShape,
    /// The downy part.
    pub downy: DownyShape,
    /// Where the vane gapes.
    pub splits: SplitShape,
    /// Random differences.
    pub disorder: Disorder,
    /// Where it is dark.
    pub pattern: PatternShape,
}

/// Tables of a feather, in the order of its parts.
const TABLES: [&str; 8] = ["shaft", "barbs", "distal", "proximal", "downy", "splits", "disorder", "pattern"];

impl Feather {
    /// A feather by the name of a type or of a bird's feather that is shipped.
    ///
    /// # Errors
    /// There is none of this name; the message offers the nearest.
    pub fn of_type(name: &str) -> Result<Self> {
        Self::read(&serde_json::json!({ "type": name }))
    }

    /// Reads the table `[feather]` of a preset, scene or species: what it leaves out is as in its `type`, a contour feather's
    /// where none is said; what neither gives of `[feather.proximal]` is as in `[feather.distal]`.
    ///
    /// # Errors
    /// An unknown key or type, a key for both vanes beside one of either, or a size out of its range; the message names the
    /// key.
    pub fn read(table: &Value) -> Result<Self> {
        let known: Vec<&str> = ["type", "leading"].into_iter().chain(TABLES).collect();
        let fields = Fields::new(table, "feather", &known)?;
        for key in TABLES {
            if let Some(part) = fields.get(key) {
                let path = fields.path(key);
                Fields::new(part, &path, &keys_of(key))?;
            }
        }
        let own = both_vanes(table)?;
        let kind = fields.text("type")?.unwrap_or(USUAL_TYPE);
        let usual = types::table(kind).ok_or_else(|| {
            let near = did_you_mean(kind, types::names());
            let known = types::names().collect::<Vec<_>>().join(", ");
            Error::input(format!("feather.type is '{}'{near} (known are {known})", shortened(kind)))
        })??;
        Self::of_tables(&over(own, usual))
    }

    /// Reads tables of which all keys are given, proximal barbules' aside.
    fn of_tables(table: &Value) -> Result<Self> {
        let fields = Fields::new(table, "feather", &[&["type", "leading"], TABLES.as_slice()].concat())?;
        let need = |key: &str| fields.need(key, &format!("the table [feather.{key}]"));
        let distal = BarbuleShape::read(need("distal")?, "feather.distal", None)?;
        let proximal = match fields.get("proximal") {
            Some(table) => BarbuleShape::read(table, "feather.proximal", Some(&distal))?,
            None => distal,
        };
        let side = fields.text("leading")?.unwrap_or("left");
        let found = LeadingSide::ALL.iter().find(|(name, _)| *name == side);
        let leading = found.map(|(_, side)| *side).ok_or_else(|| {
            Error::input(format!("feather.leading is '{}'; give left or right", shortened(side)))
        })?;
        Ok(Self {
            leading,
            shaft: ShaftShape::read(need("shaft")?, "feather.shaft", None)?,
            barbs: BarbShape::read(need("barbs")?, "feather.barbs", None)?,
            distal,
            proximal,
            downy: DownyShape::read(need("downy")?, "feather.downy", None)?,
            splits: SplitShape::read(need("splits")?, "feather.splits", None)?,
            disorder: Disorder::read(need("disorder")?, "feather.disorder", None)?,
            pattern: PatternShape::read(need("pattern")?, "feather.pattern", None)?,
        })
    }

    /// The table `[feather]` that is read as this very feather.
    #[must_use]
    pub fn table(&self) -> Value {
        let side = LeadingSide::ALL.iter().find(|(_, side)| *side == self.leading).map(|(name, _)| *name);
        serde_json::json!({
            "leading": side,
            "shaft": self.shaft.table(),
            "barbs": self.barbs.table(),
            "distal": self.distal.table(),
            "proximal": self.proximal.table(),
            "downy": self.downy.table(),
            "splits": self.splits.table(),
            "disorder": self.disorder.table(),
            "pattern": self.pattern.table(),
        })
    }

    /// Refuses sizes that make no feather.
    ///
    /// # Errors
    /// The first size out of its range, by its key in files.
    pub fn check(&self) -> Result<()> {
        self.shaft.check("feather.shaft")?;
        self.barbs.check("feather.barbs")?;
        self.distal.check("feather.distal")?;
        self.proximal.check("feather.proximal")?;
        self.downy.check("feather.downy")?;
        self.splits.check("feather.splits")?;
        self.disorder.check("feather.disorder")?;
        self.pattern.check("feather.pattern")
    }
}

/// One file's table over another's, as a scene's over its preset's: a type begins anew, and a key for both vanes takes the
/// place of those for either.
#[must_use]
pub(in crate::scene) fn layered(own: Option<Value>, base: Option<Value>) -> Option<Value> {
    match (own, base) {
        (Some(own), Some(base)) if own.get("type").is_none() => {
            // A base that is in error is refused where it is read.
            let base = both_vanes(&base).unwrap_or(base);
            Some(over(own, base))
        }
        (own, base) => own.or(base),
    }
}

/// `own` over `base`, table by table.
fn over(own: Value, base: Value) -> Value {
    let (Value::Object(own), Value::Object(mut base)) = (own, base) else { return Value::Null };
    for (key, value) in own {
        let merged = match (value, base.remove(&key)) {
            (Value::Object(own), Some(Value::Object(mut base))) => {
                for (both, either) in BOTH_VANES {
                    if own.contains_key(both) {
                        either.iter().for_each(|key| drop(base.remove(*key)));
                    }
                }
                base.extend(own);
                Value::Object(base)
            }
            (value, _) => value,
        };
        base.insert(key, merged);
    }
    Value::Object(base)
}

/// A table in which keys for both vanes are written out for either.
fn both_vanes(table: &Value) -> Result<Value> {
    let Some(given) = table.get("barbs") else { return Ok(table.clone()) };
    let fields = Fields::new(given, "feather.barbs", &keys_of("barbs"))?;
    let mut table = table.clone();
    let Some(Value::Object(barbs)) = table.get_mut("barbs") else { return Ok(table) };
    for (both, either) in BOTH_VANES {
        let Some(value) = barbs.get(both).cloned() else { continue };
        if let Some(one) = either.iter().find(|key| barbs.contains_key(**key)) {
            return Err(Error::input(format!(
                "feather.barbs.{both} is of both vanes, and feather.barbs.{one} is given too; leave one out"
            )));
        }
        // Its range is that of either, but a refusal names the key that was written.
        if let Some((_, [low, high])) = BarbShape::RANGES.iter().find(|(key, _)| *key == either[0]) {
            fields.number_within(both, *low, *high)?;
        }
        barbs.remove(both);
        barbs.extend(either.map(|key| (key.to_owned(), value.clone())));
    }
    Ok(table)
}

/// The keys that a table may have.
fn keys_of(table: &str) -> Vec<&'static str> {
    match table {
        "shaft" => ShaftShape::keys(),
        "barbs" => BarbShape::keys().into_iter().chain(BOTH_VANES.map(|(both, _)| both)).collect(),
        "distal" | "proximal" => BarbuleShape::keys(),
        "downy" => DownyShape::keys(),
        "splits" => SplitShape::keys(),
        "pattern" => PatternShape::keys(),
        _ => Disorder::keys(),
    }
}
