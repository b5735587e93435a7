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

/// A table of sizes: a struct with one number a key, each with its key in files, unit and range there.
macro_rules! sizes {
    ($(#[$about:meta])* $name:ident {
        $($(#[$doc:meta])* $field:ident: $key:literal in $unit:ident, $low:literal to $high:literal;)*
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
        pub struct $name { $($(#[$doc])* pub $field: f64,)* }

        impl $name {
            /// The keys in files with their least and largest values there.
            pub(super) const RANGES: &[(&str, [f64; 2])] = &[$(($key, [$low as f64, $high as f64])),*];

            /// The keys in files.
            pub(super) fn keys() -> Vec<&'static str> {
                Self::RANGES.iter().map(|(key, _)| *key).collect()
            }

            /// Reads a table; what it leaves out is as `usual`, where there is such.
            pub(super) fn read(table: &Value, place: &str, usual: Option<&Self>) -> Result<Self> {
                let fields = Fields::new(table, place, &Self::keys())?;
                Ok(Self {
                    $($field: match usual {
                        Some(usual) if fields.get($key).is_none() => usual.$field,
                        _ => fields.number_within($key, $low as f64, $high as f64)? * $unit,
                    },)*
                })
            }

            /// The table that is read as these very sizes.
            pub(super) fn table(&self) -> Value {
                Value::Object([$(($key.to_owned(), in_file(self.$field, $unit).into()),)*].into_iter().collect())
            }

            /// Refuses the first size out of its range.
            pub(super) fn check(&self, place: &str) -> Result<()> {
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
        /// Height over width of the quill's cross-section.
        height: "height_over_width" in PLAIN, 0.05 to 20;
        /// Height over width at the tip; between them it changes evenly.
        tip_height: "tip_height_over_width" in PLAIN, 0.05 to 20;
        /// Exponent of the rachis' superelliptic cross-section: 2 is an ellipse, more is squarer. The quill is elliptic.
        squareness: "superellipse" in PLAIN, 1 to 10;
        /// Height of the rachis' lower half over that of its upper half.
        ventral_height: "ventral_height_share" in PLAIN, 0.05 to 5;
        /// Depth of the groove along the rachis' underside over the height of its lower half.
        groove: "groove_share" in PLAIN, 0 to 0.9;
        /// Radius of the opening at the quill's end (umbilicus) over that of the quill.
        umbilicus: "umbilicus_share" in PLAIN, 0.05 to 1;
        /// Bend in the vane's plane at the tip, the part linear in the arc length, rad.
        bend: "bend_deg" in DEGREES, -360 to 360;
        /// The part quadratic in the arc length, rad.
        bend_quadratic: "bend_quadratic_deg" in DEGREES, -360 to 360;
        /// Bend towards the dorsal side at the tip, the part linear in the arc length, rad.
        arch: "arch_deg" in DEGREES, -360 to 360;
        /// The part quadratic in the arc length, rad.
        arch_quadratic: "arch_quadratic_deg" in DEGREES, -360 to 360;
        /// Turn of the vane about the shaft at the tip, rad: positive raises the right vane.
        torsion: "torsion_deg" in DEGREES, -360 to 360;
    }
}

sizes! {
    /// The barbs of a feather.
    BarbShape {
        /// Distance between neighbours, perpendicular to them, µm.
        spacing_um: "spacing_um" in PLAIN, 5 to 10000;
        /// Angle of the leading vane's barbs to the shaft at the vane's base, rad.
        leading_base_angle: "leading_base_angle_deg" in DEGREES, 1 to 89;
        /// That at the vane's tip, rad.
        leading_tip_angle: "leading_tip_angle_deg" in DEGREES, 1 to 89;
        /// Angle of the trailing vane's barbs to the shaft at the vane's base, rad.
        trailing_base_angle: "trailing_base_angle_deg" in DEGREES, 1 to 89;
        /// That at the vane's tip, rad.
        trailing_tip_angle: "trailing_tip_angle_deg" in DEGREES, 1 to 89;
        /// How much a barb turns towards the feather's tip from its base to its end, rad.
        curl: "curl_deg" in DEGREES, -180 to 180;
        /// Sag of the vane at its edge over its half width.
        camber: "camber" in PLAIN, -5 to 5;
        /// Elevation of the vanes over the plane of the shaft, rad: positive is a V seen from the tip.
        dihedral: "dihedral_deg" in DEGREES, -60 to 60;
        /// Width of the ramus at its base, µm.
        width_um: "ramus_width_um" in PLAIN, 0.5 to 1000;
        /// Height over width of the ramus.
        height: "ramus_height_over_width" in PLAIN, 0.05 to 20;
        /// Largest width of the leading vane, mm.
        leading_half_width_mm: "leading_half_width_mm" in PLAIN, 0.05 to 500;
        /// Largest width of the trailing vane, mm.
        trailing_half_width_mm: "trailing_half_width_mm" in PLAIN, 0.05 to 500;
        /// Exponent a of the outline w(t) = W (t/t_m)^a ((1 − t)/(1 − t_m))^b, t_m = a/(a + b).
        outline_base: "outline_base" in PLAIN, 0.01 to 10;
        /// Exponent b of the outline.
        outline_tip: "outline_tip" in PLAIN, 0.01 to 10;
        /// Share of the leading vane's width that its emargination cuts away towards the tip.
        emargination: "emargination_share" in PLAIN, 0 to 0.95;
        /// Where that begins, as a share of the vane's length.
        emargination_start: "emargination_start" in PLAIN, 0 to 1;
        /// Share of the vane, at its tip, whose barbs are a tuft along the shaft.
        tuft: "tuft_share" in PLAIN, 0 to 0.3;
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
        wall_um: "wall_um" in PLAIN, 0 to 1000;
        /// Slope of the arched cross-section's normal at its edge towards −x, rad; flat where both are 0.
        arch_low: "arch_low_deg" in DEGREES, -90 to 90;
        /// At its edge towards +x, rad.
        arch_high: "arch_high_deg" in DEGREES, -90 to 90;
    }
}

sizes! {
    /// The plumulaceous part: barbs that no hooks hold together, with long thin barbules.
    DownyShape {
        /// Share of the vane, from its base, that is downy.
        share: "share" in PLAIN, 0 to 1;
        /// Standard deviation of the angle by which barbs leave the vane's plane, rad.
        spread: "spread_deg" in DEGREES, 0 to 180;
        /// How far the barbs wave, over their length.
        wave: "wave_share" in PLAIN, 0 to 1;
        /// Length of the waves over that of the barbs.
        wavelength: "wavelength_share" in PLAIN, 0.02 to 10;
        /// Length of the barbs, mm; 0: they end on the vane's outline.
        barb_length_mm: "barb_length_mm" in PLAIN, 0 to 500;
        /// Width of the ramus at its base, µm.
        ramus_width_um: "ramus_width_um" in PLAIN, 0.5 to 1000;
        /// Length of a barbule in the middle of a barb, µm.
        length_um: "barbule_length_um" in PLAIN, 5 to 10000;
        /// Its width, µm.
        width_um: "barbule_width_um" in PLAIN, 0.5 to 1000;
        /// Distance between barbules along the ramus, µm.
        spacing_um: "barbule_spacing_um" in PLAIN, 1 to 10000;
        /// Angle of the barbules to the barb, rad.
        angle: "barbule_angle_deg" in DEGREES, 0 to 180;
        /// Distance between the nodes of a barbule, µm.
        node_um: "node_spacing_um" in PLAIN, 0 to 10000;
    }
}

sizes! {
    /// Splits: places where neighbouring barbs have come unhooked and the vane gapes.
    SplitShape {
        /// Mean number in both vanes; their true number is Poisson's.
        count: "mean_count" in PLAIN, 0 to 100;
        /// By how much the barbs at a split turn away from it at their ends, rad.
        opening: "opening_deg" in DEGREES, 0 to 60;
        /// Number of barbs over which the turn decays, at least; more where barbs would cross.
        reach: "reach_barbs" in PLAIN, 1 to 1000;
    }
}

sizes! {
    /// Random differences between the parts of one feather: standard deviations.
    Disorder {
        /// Of the barbs' lengths, as a share.
        barb_length: "barb_length_share" in PLAIN, 0 to 1;
        /// Of the barbs' angles, rad: hooks hold neighbours together, so that the angle drifts along the shaft.
        barb_angle: "barb_angle_deg" in DEGREES, 0 to 45;
        /// Number of barbs over which it drifts.
        barb_coherence: "barb_coherence" in PLAIN, 1 to 1000;
        /// Of a slow wave along each barb, rad.
        barb_wave: "barb_wave_deg" in DEGREES, 0 to 45;
        /// Of the barbs' ends, as a share of the barbs' spacing.
        barb_end: "barb_end_share" in PLAIN, 0 to 100;
        /// Wear: most of a barb's length that is lost, as a share.
        wear: "wear_share" in PLAIN, 0 to 0.9;
        /// How far ends of barbs are drawn together in clumps, as wet ones are: 0 not at all, 1 into one point.
        clump: "clump_share" in PLAIN, 0 to 1;
        /// Number of barbs in a clump.
        clump_barbs: "clump_barbs" in PLAIN, 1 to 1000;
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
        cell_size: "cell_size_share" in PLAIN, 0 to 0.3;
        /// Of the nanostructure's size from barbule to barbule, as a share.
        barbule_size: "barbule_size_share" in PLAIN, 0 to 0.3;
    }
}

sizes! {
    /// Where the vane has pigment and structure. A place's coordinate is where its barb leaves the shaft, from the base, and so much more
    /// as bars lean along the barbs.
    PatternShape {
        /// Distance between dark bars, mm; 0: there are none.
        bar_spacing_mm: "bar_spacing_mm" in PLAIN, 0 to 1000;
        /// Share of it that is dark.
        bar_dark: "bar_dark_share" in PLAIN, 0 to 1;
        /// How far the coordinate grows on a mm along a barb.
        bar_lean: "bar_lean" in PLAIN, -5 to 5;
        /// Coordinate at which a pale tip begins, mm; 0: there is none.
        pale_tip_from_mm: "pale_tip_from_mm" in PLAIN, 0 to 5000;
        /// Standard deviation of the edges between dark and pale, mm.
        edge_mm: "edge_mm" in PLAIN, 0 to 100;
        /// Pigment of pale places over that of dark ones.
        pale_pigment: "pale_pigment" in PLAIN, 0 to 1;
    }
}

impl PatternShape {
    /// The pattern; nothing where all is dark.
    #[must_use]
    pub fn pattern(&self) -> Option<Pattern> {
        let has_tip = self.pale_tip_from_mm > 0.0;
        (has_tip || self.bar_spacing_mm > 0.0).then_some(Pattern {
            spacing: self.bar_spacing_mm,
            dark_share: self.bar_dark,
            lean: self.bar_lean,
            tip: if has_tip { self.pale_tip_from_mm } else { f64::INFINITY },
            edge: self.edge_mm,
            pale: self.pale_pigment,
        })
    }
}
