//! The table `[feather]` of files: a type's sizes, and over them whatever the file gives.

use std::borrow::Cow;

use super::sizes::{
    BarbShape, BarbuleShape, Disorder, DownyShape, EyeShape, PatternShape, ShaftShape, SplitShape,
};
use super::types;
use crate::error::{did_you_mean, shortened};
use crate::fields::{Fields, Key, Kind, Map, Record, Text, Value, path_of};
use crate::{Error, Result, record, words};

/// The type of a feather of which nothing is said.
const USUAL_TYPE: &str = "contour";

/// Keys of `[feather.barbs]` that mean both vanes.
const BOTH_VANES: [(&str, [&str; 2]); 3] = [
    ("vane_half_width_mm", ["leading_half_width_mm", "trailing_half_width_mm"]),
    ("base_angle_deg", ["leading_base_angle_deg", "trailing_base_angle_deg"]),
    ("tip_angle_deg", ["leading_tip_angle_deg", "trailing_tip_angle_deg"]),
];

words! {
    /// Which side of the shaft the leading vane is on, seen from the dorsal side with the tip upwards.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum LeadingSide {
        /// Left, as in a right wing.
        "left": Left,
        /// Right, as in a left wing.
        "right": Right,
    }
}

impl LeadingSide {
    /// −1: left, 1: right.
    #[must_use]
    pub fn sign(self) -> f64 {
        if self == Self::Left { -1.0 } else { 1.0 }
    }
}

record! {
    /// A whole feather. Of a file's table it reads what that leaves out from the feather's `type`, a contour feather's where none is said;
    /// what neither gives of the proximal barbules is as for the distal ones.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Feather {
        /// Where the leading vane is.
        leading: LeadingSide = "leading", (), or LeadingSide::Left;
        /// The shaft.
        shaft: ShaftShape = "shaft", ();
        /// The barbs.
        barbs: BarbShape = "barbs", ();
        /// Barbules on the barbs' side that faces the feather's tip.
        distal: BarbuleShape = "distal", ();
        /// Barbules on the other side; what is left out is as for the distal ones.
        proximal: BarbuleShape = "proximal", ();
        /// The downy part.
        downy: DownyShape = "downy", ();
        /// Where the vane gapes.
        splits: SplitShape = "splits", ();
        /// Random differences.
        disorder: Disorder = "disorder", ();
        /// Where it is dark.
        pattern: PatternShape = "pattern", ();
        /// An eye near the tip, with loose barbs below it.
        eye: EyeShape = "eye", ();
        @prepare written_out, short_keys;
    }
}

/// Tables of a feather, in the order of its parts.
const TABLES: [&str; 9] =
    ["shaft", "barbs", "distal", "proximal", "downy", "splits", "disorder", "pattern", "eye"];

impl Feather {
    /// A feather by the name of a type or of a bird's feather that is shipped.
    ///
    /// # Errors
    /// There is none of this name; the message offers the nearest.
    pub fn of_type(name: &str) -> Result<Self> {
        Self::read(&serde_json::json!({ "type": name }), "feather")
    }

    /// Refuses sizes that make no feather.
    ///
    /// # Errors
    /// The first size out of its range, by its key in files.
    pub fn check(&self) -> Result<()> {
        Record::check(self, "feather")
    }
}

/// The key of a feather's type.
fn short_keys() -> Vec<Key> {
    let about =
        "Whose sizes are taken where the tables give none: a type or a bird's feather that is shipped";
    vec![Key::new::<String>("type", &[], about, &Text("the name of a type"), Some(USUAL_TYPE.to_owned()))]
}

/// A feather's table in which every size is given, or the name of a type.
fn written_out<'a>(table: &'a Value, place: &str) -> Result<Cow<'a, Value>> {
    if let Value::String(kind) = table {
        return written_out(&serde_json::json!({ "type": kind }), place).map(Cow::into_owned).map(Cow::Owned);
    }
    let known: Vec<&str> = ["type", "leading"].into_iter().chain(TABLES).collect();
    let fields = Fields::new(table, place, &known)?;
    for key in TABLES {
        if let Some(part) = fields.get(key) {
            let path = fields.path(key);
            Fields::new(part, &path, &keys_of(key))?;
        }
    }
    let mut own = both_vanes(table, place)?;
    if let Value::Object(own) = &mut own {
        own.remove("type");
    }
    let kind = fields.text("type")?.unwrap_or(USUAL_TYPE);
    let usual = types::table(kind).ok_or_else(|| {
        let near = did_you_mean(kind, types::names());
        let known = types::names().collect::<Vec<_>>().join(", ");
        Error::input(format!("{} is '{}'{near} (known are {known})", fields.path("type"), shortened(kind)))
    })??;
    let mut all = over(own, usual);
    if let Value::Object(tables) = &mut all
        && let Some(distal) = tables.get("distal").cloned()
    {
        let proximal = tables.remove("proximal").unwrap_or_else(|| Value::Object(Map::new()));
        tables.insert("proximal".to_owned(), over(proximal, distal));
    }
    Ok(Cow::Owned(all))
}

/// One file's table over another's, as a scene's over its preset's: a type begins anew, and a key for both vanes takes the
/// place of those for either.
#[must_use]
pub(in crate::scene) fn layered(own: Option<Value>, base: Option<Value>) -> Option<Value> {
    match (own, base) {
        // A type's name, or a table with one, is a feather of its own.
        (Some(own), Some(base)) if own.is_object() && own.get("type").is_none() => {
            // A base that is in error is refused where it is read.
            let base = both_vanes(&base, "feather").unwrap_or(base);
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
fn both_vanes(table: &Value, place: &str) -> Result<Value> {
    let Some(given) = table.get("barbs") else { return Ok(table.clone()) };
    let barbs_path = path_of(place, "barbs");
    let fields = Fields::new(given, &barbs_path, &keys_of("barbs"))?;
    let mut table = table.clone();
    let Some(Value::Object(barbs)) = table.get_mut("barbs") else { return Ok(table) };
    for (both, either) in BOTH_VANES {
        let Some(value) = barbs.get(both).cloned() else { continue };
        if let Some(one) = either.iter().find(|key| barbs.contains_key(**key)) {
            return Err(Error::input(format!(
                "{barbs_path}.{both} is of both vanes, and {barbs_path}.{one} is given too; leave one out"
            )));
        }
        // Its range is that of either, but a refusal names the key that was written.
        if let Some(Kind::Number { low, high, .. }) =
            BarbShape::keys().into_iter().find(|key| key.name == either[0]).map(|key| key.kind)
        {
            fields.number_within(both, low, high)?;
        }
        barbs.remove(both);
        barbs.extend(either.map(|key| (key.to_owned(), value.clone())));
    }
    Ok(table)
}

/// The keys that a table may have.
fn keys_of(table: &str) -> Vec<&'static str> {
    let keys = match table {
        "shaft" => ShaftShape::keys(),
        "barbs" => BarbShape::keys(),
        "distal" | "proximal" => BarbuleShape::keys(),
        "downy" => DownyShape::keys(),
        "splits" => SplitShape::keys(),
        "pattern" => PatternShape::keys(),
        "eye" => EyeShape::keys(),
        _ => Disorder::keys(),
    };
    let also = BOTH_VANES.iter().map(|(both, _)| *both).filter(|_| table == "barbs");
    keys.iter().map(|key| key.name).chain(also).collect()
}
