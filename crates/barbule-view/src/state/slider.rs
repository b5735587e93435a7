//! Sliders: numbers of a structure that people move, with what they are, their ranges and their units.

use barbule::fields::shown;

/// From this ratio of its ends on a range is easier to move in by factors than by differences.
const DECADES: f64 = 30.0;
/// The usual range reaches from and to these parts of what the number is at first.
const USUAL_PARTS: [f64; 2] = [0.5, 2.0];

/// A number of a structure that people move.
#[derive(Debug, Clone, PartialEq)]
pub struct Slider {
    /// Where it stands: a key of a species' file, as in `cortex_um` or `layers[1].thickness_um`, or a place of a stack's text, as in
    /// `thickness_nm[0]`.
    pub key: String,
    /// What people call it, in a few words.
    pub name: String,
    /// What it is, in a sentence.
    pub about: String,
    /// Its unit as people read it; empty for a plain number.
    pub unit: &'static str,
    /// The least and the greatest that it may be.
    pub range: [f64; 2],
    /// Whether it must be whole.
    pub whole: bool,
    /// What it is where nobody moved it.
    pub default: f64,
    /// What it is.
    pub value: f64,
}

impl Slider {
    /// Whether it is not where it was at first.
    #[must_use]
    pub fn is_moved(&self) -> bool {
        self.value != self.default
    }

    /// The part of the range in which the number is usually looked for: from half to double of what it was at first, and with its
    /// value in it. All of the range where it was 0.
    #[must_use]
    pub fn usual(&self) -> [f64; 2] {
        let [least, greatest] = self.range;
        if self.default == 0.0 {
            return self.range;
        }
        let ends = USUAL_PARTS.map(|part| part * self.default);
        let (mut low, mut high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        if self.whole {
            (low, high) = (low.floor(), (high.ceil()).max(self.default + 1.0));
        }
        [low.min(self.value).max(least), high.max(self.value).min(greatest)]
    }

    /// Whether it is moved in by factors: its whole range spans decades.
    #[must_use]
    pub fn is_logarithmic(&self) -> bool {
        self.range[0] > 0.0 && self.range[1] > DECADES * self.range[0]
    }

    /// A value with its unit, as in `0.3 µm` or `12°`.
    #[must_use]
    pub fn words(&self, value: f64) -> String {
        let number = shown(value);
        match self.unit {
            "" => number,
            "°" | "%" => format!("{number}{}", self.unit),
            unit => format!("{number} {unit}"),
        }
    }
}

/// A key's name in words, without the unit at its end: `melanosome_diameter_um` is `melanosome diameter`.
#[must_use]
pub fn spoken(key: &str) -> String {
    const UNITS: [&str; 4] = ["_um", "_nm", "_mm", "_deg"];
    let plain = UNITS.iter().find_map(|unit| key.strip_suffix(unit)).unwrap_or(key);
    plain.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slider(default: f64, range: [f64; 2], whole: bool) -> Slider {
        Slider {
            key: "a_um".into(),
            name: "a".into(),
            about: "A.".into(),
            unit: "µm",
            range,
            whole,
            default,
            value: default,
        }
    }

    #[test]
    fn the_usual_range_is_about_the_first_value_and_within_the_whole_one() {
        let of = |default, range| slider(default, range, false).usual();
        assert_eq!(of(0.3, [0.001, 10.0]), [0.15, 0.6]);
        assert_eq!(of(6.0, [0.001, 10.0]), [3.0, 10.0]);
        assert_eq!(of(-10.0, [-60.0, 60.0]), [-20.0, -5.0]);
        assert_eq!(of(0.0, [-60.0, 60.0]), [-60.0, 60.0]);
        let moved = Slider { value: 5.0, ..slider(0.3, [0.001, 10.0], false) };
        assert_eq!((moved.usual(), moved.is_moved()), ([0.15, 5.0], true));
        assert_eq!(slider(1.0, [1.0, 100.0], true).usual(), [1.0, 2.0]);
    }

    #[test]
    fn ranges_of_decades_are_moved_in_by_factors() {
        assert!(slider(0.3, [0.001, 10.0], false).is_logarithmic());
        assert!(!slider(0.3, [0.0, 10.0], false).is_logarithmic());
        assert!(!slider(3.0, [1.0, 10.0], false).is_logarithmic());
    }

    #[test]
    fn names_and_values_are_for_people() {
        assert_eq!(spoken("melanosome_diameter_um"), "melanosome diameter");
        assert_eq!([spoken("rows"), spoken("fold_deg")], ["rows", "fold"]);
        let length = slider(0.3, [0.0, 1.0], false);
        assert_eq!(length.words(0.25), "0.25 µm");
        assert_eq!(Slider { unit: "°", ..length.clone() }.words(12.0), "12°");
        assert_eq!(Slider { unit: "", ..length }.words(3.0), "3");
    }
}
