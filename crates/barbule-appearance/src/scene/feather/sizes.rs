//! Sizes of a feather: what they mean, the keys under which files give them, and their ranges.
//!
//! Files have degrees, memory radians; all other units are the same in both.

use crate::bsdf::Pattern;
use crate::fields::{degrees, within};
use crate::record;

record! {
    /// The shaft of a feather. The centre line bends by angles that are quadratic in the arc length.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ShaftShape {
        /// Length of the whole shaft, mm.
        length_mm: f64 = "length_mm", within(0.5, 2000);
        /// Share of the length that bears no barbs (the quill).
        calamus: f64 = "calamus_share", within(0, 0.95);
        /// Radius at the base, mm.
        radius_mm: f64 = "radius_mm", within(0.001, 20);
        /// Radius at the tip, mm.
        tip_radius_mm: f64 = "tip_radius_mm", within(0.0001, 20);
        /// Exponent of the taper.
        taper: f64 = "taper", within(0, 10);
        /// Height over width of the quill's cross-section.
        height: f64 = "height_over_width", within(0.05, 20);
        /// Height over width at the tip; between them it changes evenly.
        tip_height: f64 = "tip_height_over_width", within(0.05, 20);
        /// Exponent of the rachis' superelliptic cross-section: 2 is an ellipse, more is squarer. The quill is elliptic.
        squareness: f64 = "superellipse", within(1, 10);
        /// Height of the rachis' lower half over that of its upper half.
        ventral_height: f64 = "ventral_height_share", within(0.05, 5);
        /// Depth of the groove along the rachis' underside over the height of its lower half.
        groove: f64 = "groove_share", within(0, 0.9);
        /// Radius of the opening at the quill's end (umbilicus) over that of the quill.
        umbilicus: f64 = "umbilicus_share", within(0.05, 1);
        /// Bend in the vane's plane at the tip, the part linear in the arc length, rad.
        bend: f64 = "bend_deg", degrees(-360, 360);
        /// The part quadratic in the arc length, rad.
        bend_quadratic: f64 = "bend_quadratic_deg", degrees(-360, 360);
        /// Bend towards the dorsal side at the tip, the part linear in the arc length, rad.
        arch: f64 = "arch_deg", degrees(-360, 360);
        /// The part quadratic in the arc length, rad.
        arch_quadratic: f64 = "arch_quadratic_deg", degrees(-360, 360);
        /// Turn of the vane about the shaft at the tip, positive where it raises the right vane, rad.
        torsion: f64 = "torsion_deg", degrees(-360, 360);
    }
}

record! {
    /// The barbs of a feather.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct BarbShape {
        /// Distance between neighbours, perpendicular to them, µm.
        spacing_um: f64 = "spacing_um", within(5, 10000);
        /// Angle of the leading vane's barbs to the shaft at the vane's base, rad.
        leading_base_angle: f64 = "leading_base_angle_deg", degrees(1, 89);
        /// That at the vane's tip, rad.
        leading_tip_angle: f64 = "leading_tip_angle_deg", degrees(1, 89);
        /// Angle of the trailing vane's barbs to the shaft at the vane's base, rad.
        trailing_base_angle: f64 = "trailing_base_angle_deg", degrees(1, 89);
        /// That at the vane's tip, rad.
        trailing_tip_angle: f64 = "trailing_tip_angle_deg", degrees(1, 89);
        /// How much a barb turns towards the feather's tip from its base to its end, rad.
        curl: f64 = "curl_deg", degrees(-180, 180);
        /// Sag of the vane at its edge over its half width.
        camber: f64 = "camber", within(-5, 5);
        /// Elevation of the vanes over the plane of the shaft, positive for a V seen from the tip, rad.
        dihedral: f64 = "dihedral_deg", degrees(-60, 60);
        /// Width of the ramus at its base, µm.
        width_um: f64 = "ramus_width_um", within(0.5, 1000);
        /// Height over width of the ramus.
        height: f64 = "ramus_height_over_width", within(0.05, 20);
        /// Largest width of the leading vane, mm.
        leading_half_width_mm: f64 = "leading_half_width_mm", within(0.05, 500);
        /// Largest width of the trailing vane, mm.
        trailing_half_width_mm: f64 = "trailing_half_width_mm", within(0.05, 500);
        /// Exponent a of the outline w(t) = W (t/t_m)^a ((1 − t)/(1 − t_m))^b, t_m = a/(a + b).
        outline_base: f64 = "outline_base", within(0.01, 10);
        /// Exponent b of the outline.
        outline_tip: f64 = "outline_tip", within(0.01, 10);
        /// Share of the leading vane's width that its emargination cuts away towards the tip.
        emargination: f64 = "emargination_share", within(0, 0.95);
        /// Where that begins, as a share of the vane's length.
        emargination_start: f64 = "emargination_start", within(0, 1);
        /// Share of the vane, at its tip, whose barbs are a tuft along the shaft.
        tuft: f64 = "tuft_share", within(0, 0.3);
    }
}

record! {
    /// An eye, as on a peafowl's train: a zipped disc near the tip, and barbs that stand apart below it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct EyeShape {
        /// Length of the shaft, up to its tip, from which the barbs of the eye leave (0: there is no eye), mm.
        length_mm: f64 = "length_mm", within(0, 2000);
        /// How far its middle lies before the shaft's tip, mm.
        middle_mm: f64 = "middle_mm", within(-500, 500);
        /// Half its width, mm.
        half_width_mm: f64 = "half_width_mm", within(0.05, 500);
        /// Half its length along the shaft, mm.
        half_length_mm: f64 = "half_length_mm", within(0.05, 500);
        /// How far its barbs reach beyond it, mm.
        fringe_mm: f64 = "fringe_mm", within(0, 500);
        /// Length of the shaft over which barbs come to stand apart, mm.
        border_mm: f64 = "border_mm", within(0.1, 2000);
        /// Distance between neighbours below it, perpendicular to them, µm.
        loose_spacing_um: f64 = "loose_spacing_um", within(5, 50000);
        /// Length of the barbs below it, mm.
        loose_length_mm: f64 = "loose_length_mm", within(0.05, 500);
        /// How much a barb below it turns back, away from the feather's tip, from its base to its end, rad.
        hang: f64 = "hang_deg", degrees(-180, 180);
        /// Standard deviation of the angle by which free barbs leave the vane's plane, rad.
        spread: f64 = "spread_deg", degrees(0, 60);
        /// How far free barbs wave, over their length.
        wave: f64 = "wave_share", within(0, 1);
        /// Length of the waves, mm.
        wavelength_mm: f64 = "wavelength_mm", within(0.1, 1000);
        /// How much shorter barbules are at the ends of free barbs than where these are hooked, as a share.
        thinning: f64 = "thinning_share", within(0, 0.95);
    }
}

record! {
    /// The barbules on one side of the barbs.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct BarbuleShape {
        /// Length in the middle of a barb, µm.
        length_um: f64 = "length_um", within(5, 10000);
        /// Full width, µm.
        width_um: f64 = "width_um", within(0.5, 1000);
        /// Distance between neighbours along the ramus, µm.
        spacing_um: f64 = "spacing_um", within(1, 10000);
        /// Angle to the barb at the barbule's base, rad.
        base_angle: f64 = "base_angle_deg", degrees(0, 180);
        /// Angle to the barb at the barbule's end, rad.
        end_angle: f64 = "end_angle_deg", degrees(0, 180);
        /// Elevation over the vane at the base, rad.
        base_lift: f64 = "base_lift_deg", degrees(-80, 80);
        /// Elevation over the vane at the end, rad.
        end_lift: f64 = "end_lift_deg", degrees(-80, 80);
        /// Turn about its own axis, positive where it turns the upper side towards the barb's tip, rad.
        tilt: f64 = "tilt_deg", degrees(-180, 180);
        /// Further turn at the root, gone after a tenth of the length, rad.
        root_tilt: f64 = "root_tilt_deg", degrees(-180, 180);
        /// Length of a cell, within which the structure is the same (0: a barbule is one cell), µm.
        cell_um: f64 = "cell_um", within(0, 10000);
        /// Swelling of cells, low arches along the barbule: slope at their ends, rad.
        swelling: f64 = "swelling_deg", degrees(0, 45);
        /// Length of the dark wall between two cells, µm.
        wall_um: f64 = "wall_um", within(0, 1000);
        /// Slope of the arched cross-section's normal at its edge towards −x (flat where both are 0), rad.
        arch_low: f64 = "arch_low_deg", degrees(-90, 90);
        /// At its edge towards +x, rad.
        arch_high: f64 = "arch_high_deg", degrees(-90, 90);
    }
}

record! {
    /// The plumulaceous part: barbs that no hooks hold together, with long thin barbules.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DownyShape {
        /// Share of the vane, from its base, that is downy.
        share: f64 = "share", within(0, 1);
        /// Standard deviation of the angle by which barbs leave the vane's plane, rad.
        spread: f64 = "spread_deg", degrees(0, 180);
        /// How far the barbs wave, over their length.
        wave: f64 = "wave_share", within(0, 1);
        /// Length of the waves over that of the barbs.
        wavelength: f64 = "wavelength_share", within(0.02, 10);
        /// Length of the barbs (0: they end on the vane's outline), mm.
        barb_length_mm: f64 = "barb_length_mm", within(0, 500);
        /// Width of the ramus at its base, µm.
        ramus_width_um: f64 = "ramus_width_um", within(0.5, 1000);
        /// Length of a barbule in the middle of a barb, µm.
        length_um: f64 = "barbule_length_um", within(5, 10000);
        /// Its width, µm.
        width_um: f64 = "barbule_width_um", within(0.5, 1000);
        /// Distance between barbules along the ramus, µm.
        spacing_um: f64 = "barbule_spacing_um", within(1, 10000);
        /// Angle of the barbules to the barb, rad.
        angle: f64 = "barbule_angle_deg", degrees(0, 180);
        /// Distance between the nodes of a barbule, µm.
        node_um: f64 = "node_spacing_um", within(0, 10000);
    }
}

record! {
    /// Splits: places where neighbouring barbs have come unhooked and the vane gapes.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SplitShape {
        /// Mean number in both vanes; their true number is Poisson's.
        count: f64 = "mean_count", within(0, 100);
        /// By how much the barbs at a split turn away from it at their ends, rad.
        opening: f64 = "opening_deg", degrees(0, 60);
        /// Number of barbs over which the turn decays, at least; more where barbs would cross.
        reach: f64 = "reach_barbs", within(1, 1000);
    }
}

record! {
    /// Random differences between the parts of one feather: standard deviations.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Disorder {
        /// Of the barbs' lengths, as a share.
        barb_length: f64 = "barb_length_share", within(0, 1);
        /// Of the barbs' angles, which drift along the shaft since hooks hold neighbours together, rad.
        barb_angle: f64 = "barb_angle_deg", degrees(0, 45);
        /// Number of barbs over which it drifts.
        barb_coherence: f64 = "barb_coherence", within(1, 1000);
        /// Of a slow wave along each barb, rad.
        barb_wave: f64 = "barb_wave_deg", degrees(0, 45);
        /// Of the barbs' ends, as a share of the barbs' spacing.
        barb_end: f64 = "barb_end_share", within(0, 100);
        /// Wear: most of a barb's length that is lost, as a share.
        wear: f64 = "wear_share", within(0, 0.9);
        /// How far ends of barbs are drawn together in clumps, as wet ones are: 0 not at all, 1 into one point.
        clump: f64 = "clump_share", within(0, 1);
        /// Number of barbs in a clump.
        clump_barbs: f64 = "clump_barbs", within(1, 1000);
        /// Of the barbs' places, as a share of their spacing.
        barb_spacing: f64 = "barb_spacing_share", within(0, 1);
        /// Of the barbules' angles to the barb, rad.
        barbule_angle: f64 = "barbule_angle_deg", degrees(0, 45);
        /// Of the barbules' lifts, rad.
        barbule_lift: f64 = "barbule_lift_deg", degrees(0, 45);
        /// Of the barbules' places, as a share of their spacing.
        barbule_spacing: f64 = "barbule_spacing_share", within(0, 1);
        /// Of the barbules' lengths, as a share.
        barbule_length: f64 = "barbule_length_share", within(0, 1);
        /// Turn of a barbule about its own axis beyond what its material holds, rad.
        barbule_turn: f64 = "barbule_turn_deg", degrees(0, 45);
        /// Of the nanostructure's size from cell to cell of a barbule, as a share.
        cell_size: f64 = "cell_size_share", within(0, 0.3);
        /// Of the nanostructure's size from barbule to barbule, as a share.
        barbule_size: f64 = "barbule_size_share", within(0, 0.3);
    }
}

record! {
    /// Where the vane has pigment and structure. A place's coordinate is where its barb leaves the shaft, from the base, and so much more
    /// as bars lean along the barbs.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PatternShape {
        /// Distance between dark bars (0: there are none), mm.
        bar_spacing_mm: f64 = "bar_spacing_mm", within(0, 1000);
        /// Share of it that is dark.
        bar_dark: f64 = "bar_dark_share", within(0, 1);
        /// How far the coordinate grows on a mm along a barb.
        bar_lean: f64 = "bar_lean", within(-5, 5);
        /// Coordinate at which a pale tip begins (0: there is none), mm.
        pale_tip_from_mm: f64 = "pale_tip_from_mm", within(0, 5000);
        /// Standard deviation of the edges between dark and pale, mm.
        edge_mm: f64 = "edge_mm", within(0, 100);
        /// Pigment of pale places over that of dark ones.
        pale_pigment: f64 = "pale_pigment", within(0, 1);
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
