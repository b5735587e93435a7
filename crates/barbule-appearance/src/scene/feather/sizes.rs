//! Sizes of a feather: what they mean, the keys under which files give them, and their ranges.
//!
//! Files have degrees, memory radians; all other units are the same in both.

use std::f64::consts::PI;

use serde_json::Value;

use crate::bsdf::Pattern;
use crate::fields::Fields;
use crate::{Error, Result};

/// A quantity that is the same in files and in memory.
const PLAIN: f64 = 1.0;
/// Radians in a degree: degrees in files, radians in memory.
const DEGREES: f64 = PI / 180.0;

/// A table of sizes: a struct with one number a key, each with its key in files, unit and range there, and what it is where a file
/// leaves it out; without such it is needed.
macro_rules! sizes {
    ($(#[$about:meta])* $name:ident {
        $($(#[$doc:meta])* $field:ident: $key:literal in $unit:ident, $low:literal to $high:literal $(else $usual:literal)?;)*
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
        pub struct $name { $($(#[$doc])* pub $field: f64,)* }

        impl $name {
            /// Reads a table; what it leaves out is as `usual`, where there is such.
            fn read(table: &Value, place: &str, usual: Option<&Self>) -> Result<Self> {
                let fields = Fields::new(table, place, &[$($key),*])?;
                Ok(Self {
                    $($field: match usual {
                        Some(usual) if fields.get($key).is_none() => usual.$field,
                        $(_ if fields.get($key).is_none() => $usual * $unit,)?
                        _ => fields.number_within($key, $low as f64, $high as f64)? * $unit,
                    },)*
                })
            }

            /// The table that is read as these very sizes.
            fn table(&self) -> Value {
                Value::Object([$(($key.to_owned(), in_file(self.$field, $unit).into()),)*].into_iter().collect())
            }

            /// Refuses the first size out of its range.
            fn check(&self, place: &str) -> Result<()> {
                $(within(self.$field, $unit, ($low as f64, $high as f64), place, $key)?;)*
                Ok(())
            }
        }
    };
}

/// The number with the fewest digits that is read as this value.
fn in_file(value: f64, unit: f64) -> f64 {
    let exact = value / unit;
    let read = |number: &f64| number * unit == value;
    let rounded = (1..=15).filter_map(|digits| format!("{exact:.digits$e}").parse::<f64>().ok());
    rounded.chain([exact, exact.next_up(), exact.next_down()]).find(read).unwrap_or(exact)
}

fn within(value: f64, unit: f64, (low, high): (f64, f64), place: &str, key: &str) -> Result<()> {
    if (low * unit..=high * unit).contains(&value) {
        return Ok(());
    }
    Err(Error::input(format!("{place}.{key} is {}, outside {low} to {high}", value / unit)))
}

sizes! {
    /// The shaft of a feather. The centre line bends by angles that are quadratic in the arc length.
    ShaftShape {
        /// Length of the whole shaft, mm.
        length_mm: "length_mm" in PLAIN, 0.5 to 2000;
        /// Share of the length that bears no barbs (the quill).
        calamus: "calamus_share" in PLAIN, 0 to 0.95;
        /// Radius at the base, mm.
        radius_mm: "radius_mm" in PLAIN, 0.001 to 20;
        /// Radius at the tip, mm.
        tip_radius_mm: "tip_radius_mm" in PLAIN, 0.0001 to 20;
        /// Exponent of the taper.
        taper: "taper" in PLAIN, 0 to 10;
        /// Height over width of the cross-section.
        height: "height_over_width" in PLAIN, 0.05 to 20;
        /// Bend in the vane's plane at the tip, the part linear in the arc length, rad.
        bend: "bend_deg" in DEGREES, -360 to 360;
        /// The part quadratic in the arc length, rad.
        bend_quadratic: "bend_quadratic_deg" in DEGREES, -360 to 360;
        /// Bend towards the dorsal side at the tip, the part linear in the arc length, rad.
        arch: "arch_deg" in DEGREES, -360 to 360;
        /// The part quadratic in the arc length, rad.
        arch_quadratic: "arch_quadratic_deg" in DEGREES, -360 to 360;
    }
}

sizes! {
    /// The barbs of a feather.
    BarbShape {
        /// Distance between neighbours, perpendicular to them, µm.
        spacing_um: "spacing_um" in PLAIN, 5 to 10000;
        /// Angle to the shaft at the vane's base, rad.
        base_angle: "base_angle_deg" in DEGREES, 1 to 89;
        /// Angle to the shaft at the vane's tip, rad.
        tip_angle: "tip_angle_deg" in DEGREES, 1 to 89;
        /// How much a barb turns towards the feather's tip from its base to its end, rad.
        curl: "curl_deg" in DEGREES, -180 to 180;
        /// Sag of the vane at its edge over its half width.
        camber: "camber" in PLAIN, -5 to 5;
        /// Width of the ramus at its base, µm.
        width_um: "ramus_width_um" in PLAIN, 0.5 to 1000;
        /// Height over width of the ramus.
        height: "ramus_height_over_width" in PLAIN, 0.05 to 20;
        /// Half width of the vane, mm.
        half_width_mm: "vane_half_width_mm" in PLAIN, 0.05 to 500;
        /// Exponent a of the outline w(t) = W (t/t_m)^a ((1 − t)/(1 − t_m))^b, t_m = a/(a + b).
        outline_base: "outline_base" in PLAIN, 0.01 to 10;
        /// Exponent b of the outline.
        outline_tip: "outline_tip" in PLAIN, 0.01 to 10;
    }
}

sizes! {
    /// The barbules on one side of the barbs.
    BarbuleShape {
        /// Length in the middle of a barb, µm.
        length_um: "length_um" in PLAIN, 5 to 10000;
        /// Full width, µm.
        width_um: "width_um" in PLAIN, 0.5 to 1000;
        /// Distance between neighbours along the ramus, µm.
        spacing_um: "spacing_um" in PLAIN, 1 to 10000;
        /// Angle to the barb at the barbule's base, rad.
        base_angle: "base_angle_deg" in DEGREES, 0 to 180;
        /// Angle to the barb at the barbule's end, rad.
        end_angle: "end_angle_deg" in DEGREES, 0 to 180;
        /// Elevation over the vane at the base, rad.
        base_lift: "base_lift_deg" in DEGREES, -80 to 80;
        /// Elevation over the vane at the end, rad.
        end_lift: "end_lift_deg" in DEGREES, -80 to 80;
        /// Turn about its own axis, rad: positive turns the upper side towards the barb's tip.
        tilt: "tilt_deg" in DEGREES, -180 to 180;
        /// Further turn at the root, gone after a tenth of the length, rad.
        root_tilt: "root_tilt_deg" in DEGREES, -180 to 180;
        /// Length of a cell, µm: structure is constant within it; 0: a barbule is one cell.
        cell_um: "cell_um" in PLAIN, 0 to 10000;
        /// Swelling of cells, low arches along the barbule: slope at their ends, rad.
        swelling: "swelling_deg" in DEGREES, 0 to 45;
        /// Length of the dark wall between two cells, µm.
        wall_um: "wall_um" in PLAIN, 0 to 1000 else 0.0;
        /// Slope of the arched cross-section's normal at its edge towards −x, rad; flat where both are 0.
        arch_low: "arch_low_deg" in DEGREES, -90 to 90 else 0.0;
        /// At its edge towards +x, rad.
        arch_high: "arch_high_deg" in DEGREES, -90 to 90 else 0.0;
    }
}

sizes! {
    /// Random differences between the parts of one feather: standard deviations.
    Disorder {
        /// Of the barbs' lengths, as a share.
        barb_length: "barb_length_share" in PLAIN, 0 to 1;
        /// Of the barbs' angles, rad.
        barb_angle: "barb_angle_deg" in DEGREES, 0 to 45;
        /// Of the barbs' places, as a share of their spacing.
        barb_spacing: "barb_spacing_share" in PLAIN, 0 to 1;
        /// Of the barbules' angles to the barb, rad.
        barbule_angle: "barbule_angle_deg" in DEGREES, 0 to 45;
        /// Of the barbules' lifts, rad.
        barbule_lift: "barbule_lift_deg" in DEGREES, 0 to 45;
        /// Of the barbules' places, as a share of their spacing.
        barbule_spacing: "barbule_spacing_share" in PLAIN, 0 to 1;
        /// Of the barbules' lengths, as a share.
        barbule_length: "barbule_length_share" in PLAIN, 0 to 1;
        /// Turn of a barbule about its own axis, rad, beyond what its material holds.
        barbule_turn: "barbule_turn_deg" in DEGREES, 0 to 45;
        /// Of the nanostructure's size from cell to cell of a barbule, as a share.
        cell_size: "cell_size_share" in PLAIN, 0 to 0.3 else 0.0;
        /// Of the nanostructure's size from barbule to barbule, as a share.
        barbule_size: "barbule_size_share" in PLAIN, 0 to 0.3 else 0.0;
    }
}

sizes! {
    /// Where the vane has pigment and structure. A place's coordinate is where its barb leaves the shaft, from the base, and so much more
    /// as bars lean along the barbs.
    PatternShape {
        /// Distance between dark bars, mm; 0: there are none.
        bar_spacing_mm: "bar_spacing_mm" in PLAIN, 0 to 1000 else 0.0;
        /// Share of it that is dark.
        bar_dark: "bar_dark_share" in PLAIN, 0 to 1 else 0.5;
        /// How far the coordinate grows on a mm along a barb.
        bar_lean: "bar_lean" in PLAIN, -5 to 5 else 0.0;
        /// Coordinate at which a pale tip begins, mm; 0: there is none.
        pale_tip_from_mm: "pale_tip_from_mm" in PLAIN, 0 to 5000 else 0.0;
        /// Standard deviation of the edges between dark and pale, mm.
        edge_mm: "edge_mm" in PLAIN, 0 to 100 else 0.1;
        /// Pigment of pale places over that of dark ones.
        pale_pigment: "pale_pigment" in PLAIN, 0 to 1 else 0.05;
    }
}

/// A whole feather.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Feather {
    /// The shaft.
    pub shaft: ShaftShape,
    /// The barbs.
    pub barbs: BarbShape,
    /// Barbules on the barbs' side that faces the feather's tip.
    pub distal: BarbuleShape,
    /// Barbules on the other side.
    pub proximal: BarbuleShape,
    /// Random differences.
    pub disorder: Disorder,
    /// Where it is dark.
    pub pattern: PatternShape,
}

impl Feather {
    /// Reads the table `[feather]` of a preset, scene or species. `[feather.proximal]` may leave out what is as in
    /// `[feather.distal]`, and some keys have usual values; every other key is needed.
    ///
    /// # Errors
    /// An unknown or missing key, or a size out of its range; the message names the key.
    pub fn read(table: &Value) -> Result<Self> {
        let fields =
            Fields::new(table, "feather", &["shaft", "barbs", "distal", "proximal", "disorder", "pattern"])?;
        let need = |key: &str| fields.need(key, &format!("the table [feather.{key}]"));
        let distal = BarbuleShape::read(need("distal")?, "feather.distal", None)?;
        let proximal = match fields.get("proximal") {
            Some(table) => BarbuleShape::read(table, "feather.proximal", Some(&distal))?,
            None => distal,
        };
        Ok(Self {
            shaft: ShaftShape::read(need("shaft")?, "feather.shaft", None)?,
            barbs: BarbShape::read(need("barbs")?, "feather.barbs", None)?,
            distal,
            proximal,
            disorder: Disorder::read(need("disorder")?, "feather.disorder", None)?,
            pattern: {
                let none = serde_json::json!({});
                PatternShape::read(fields.get("pattern").unwrap_or(&none), "feather.pattern", None)?
            },
        })
    }

    /// The table `[feather]` that is read as this very feather.
    #[must_use]
    pub fn table(&self) -> Value {
        serde_json::json!({
            "shaft": self.shaft.table(),
            "barbs": self.barbs.table(),
            "distal": self.distal.table(),
            "proximal": self.proximal.table(),
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
        self.disorder.check("feather.disorder")?;
        self.pattern.check("feather.pattern")
    }
}

impl PatternShape {
    /// The pattern; nothing where all is dark.
    #[must_use]
    pub fn pattern(&self) -> Option<Pattern> {
        let has_tip = self.pale_tip_from_mm > 0.0;
        (has_tip || self.bar_spacing_mm > 0.0).then(|| Pattern {
            spacing: self.bar_spacing_mm,
            dark_share: self.bar_dark,
            lean: self.bar_lean,
            tip: if has_tip { self.pale_tip_from_mm } else { f64::INFINITY },
            edge: self.edge_mm,
            pale: self.pale_pigment,
        })
    }
}
