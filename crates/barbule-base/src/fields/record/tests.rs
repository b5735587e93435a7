//! Records, words and variants: read, written, refused, hashed.

use std::f64::consts::PI;

use serde_json::json;

use super::*;
use crate::fields::{Several, Text, degrees, within};
use crate::identity::Hasher;

crate::words! {
    /// A colour.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    enum Hue {
        /// Red.
        "red": Red,
        /// Green.
        "green": Green,
    }
}

crate::record! {
    /// Where.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Spot {
        /// The place, mm.
        at_mm: [f64; 3] = "at_mm", within(-10, 10), or [0.0; 3];
    }
}

crate::record! {
    /// All kinds of keys.
    #[derive(Debug, Clone, PartialEq)]
    struct Thing {
        /// Thickness, µm.
        thickness_um: f64 = "thickness_um", within(0.001, 10);
        /// How often.
        count: usize = "count", within(1, 9), or 3;
        /// Turn, rad.
        turn: f64 = "turn_deg" | "turn", degrees(-360, 360), or 0.0;
        /// Hue.
        hue: Hue = "hue", (), or Hue::Red;
        /// Whether.
        on: Option<bool> = "on", ();
        /// Names.
        names: Vec<String> = "names", Several { least: 0, most: 2, of: Text("a name") }, or Vec::new();
        @flat {
            /// Where it is.
            spot: Spot;
        }
        @agree Thing::agree;
    }
}

impl Thing {
    fn agree(&self, place: &str) -> Result<()> {
        if self.count == 7 { Err(Error::input(format!("{place}: seven is unlucky"))) } else { Ok(()) }
    }
}

crate::variants! {
    /// One or the other.
    #[derive(Debug, Clone, PartialEq)]
    enum Either by "type" {
        /// A spot.
        "spot": Spot(Spot),
        /// A thing.
        "thing": Thing(Thing),
    }
}

fn refusal(table: Value) -> String {
    Thing::read(&table, "thing").unwrap_err().to_string()
}

#[test]
fn what_is_left_out_is_usual_and_what_is_written_is_read_again() {
    let bare = Thing::read(&json!({"thickness_um": 0.5}), "thing").unwrap();
    assert_eq!(
        (bare.count, bare.turn, bare.hue, bare.on, bare.spot.at_mm),
        (3, 0.0, Hue::Red, None, [0.0; 3])
    );
    let given = json!({"thickness_um": 0.5, "count": 4, "turn_deg": 90, "hue": "green", "on": false,
                       "names": ["a", "b"], "at_mm": [1, 2, 3]});
    let thing = Thing::read(&given, "thing").unwrap();
    assert_eq!((thing.turn, thing.hue, thing.spot.at_mm), (0.5 * PI, Hue::Green, [1.0, 2.0, 3.0]));
    assert_eq!(Thing::read(&thing.table(), "thing").unwrap(), thing);
    // Degrees are written as round as they were.
    let tilted = Thing { turn: 27.3_f64.to_radians(), ..thing };
    assert_eq!(tilted.table()["turn_deg"], 27.3);
}

#[test]
fn what_is_wrong_is_refused_by_its_key() {
    assert_eq!(refusal(json!({})), "thing.thickness_um is missing; give a number from 0.001 to 10");
    assert_eq!(
        refusal(json!({"thickness_um": 500})),
        "thing.thickness_um is 500, outside 0.001 to 10; did you mean 0.5 (500 nm)?"
    );
    let with = |key: &str, value: Value| {
        let mut table = json!({"thickness_um": 1});
        table[key] = value;
        refusal(table)
    };
    assert_eq!(with("count", json!(2.5)), "thing.count is 2.5, but must be a whole number");
    assert_eq!(with("turn_deg", json!(400)), "thing.turn_deg is 400, outside -360 to 360");
    assert!(with("hue", json!("gren")).contains("did you mean 'green'"));
    assert!(with("on", json!(1)).contains("thing.on is the number 1, but must be true or false"));
    assert!(with("names", json!(["a", "b", "c"])).contains("3 are over the limit of 2"));
    assert!(
        with("at_mm", json!([1, 2])).contains("thing.at_mm has 2 numbers; give three numbers from -10 to 10")
    );
    assert!(with("at_mm", json!([1, 2, 30])).contains("thing.at_mm[2] is 30"));
    assert!(with("coutn", json!(1)).contains("did you mean 'count'"));
    assert_eq!(with("count", json!(7)), "thing: seven is unlucky");
    let thing = Thing { count: 12, ..Thing::read(&json!({"thickness_um": 1}), "").unwrap() };
    assert_eq!(thing.check("a").unwrap_err().to_string(), "a.count is 12, outside 1 to 9");
}

#[test]
fn a_word_chooses_which_keys_there_are() {
    let read = |table: Value| Either::read(&table, "it");
    let spot = read(json!({"type": "spot", "at_mm": [0, 0, 1]})).unwrap();
    assert_eq!((spot.word(), read(spot.table()).unwrap()), ("spot", spot.clone()));
    let message = |table| read(table).unwrap_err().to_string();
    assert_eq!(message(json!({"at_mm": [0, 0, 1]})), "it.type is missing; give one of spot, thing");
    assert!(message(json!({"type": "spto"})).contains("did you mean 'spot'"));
    assert!(message(json!({"type": "spot", "count": 3})).contains("it: unknown key 'count'"));
}

#[test]
fn everything_that_decides_is_hashed() {
    let hash = |thing: &Thing| {
        let mut hasher = Hasher::new("thing");
        thing.feed_fields(&mut hasher);
        hasher.hex()
    };
    let thing = Thing::read(&json!({"thickness_um": 0.5}), "thing").unwrap();
    let others = [
        Thing { count: 4, ..thing.clone() },
        Thing { hue: Hue::Green, ..thing.clone() },
        Thing { on: Some(false), ..thing.clone() },
        Thing { names: vec![String::new()], ..thing.clone() },
        Thing { spot: Spot { at_mm: [0.0, 0.0, 1.0] }, ..thing.clone() },
    ];
    let mut all: Vec<String> = others.iter().chain([&thing]).map(hash).collect();
    all.sort();
    all.dedup();
    assert_eq!(all.len(), 6);
}
