//! What identifies presets.

use super::feather::{BarbShape, BarbuleShape, Disorder, Feather, ShaftShape, Window};
use super::preset::{Bearing, Preset};
use crate::identity::{Hasher, Identify};

impl Identify for Preset {
    fn feed(&self, to: &mut Hasher) {
        // The material has a hash of its own; names decide nothing.
        let Self {
            name: _,
            material: _,
            feather,
            window,
            view,
            roll,
            width_mm,
            lens,
            light,
            light_radius,
            key,
            sky,
            exposure,
            pigment,
        } = self;
        to.part("feather", feather).part("window", window).part("view", view).number("roll", *roll);
        to.number("width_mm", *width_mm).number("lens", *lens).part("light", light);
        to.number("light_radius", *light_radius).number("key", *key).number("sky", *sky);
        to.number("exposure", *exposure).numbers("pigment", pigment);
    }
}

impl Identify for Bearing {
    fn feed(&self, to: &mut Hasher) {
        let Self { azimuth, elevation } = self;
        to.numbers("degrees", &[*azimuth, *elevation]);
    }
}

impl Identify for Window {
    fn feed(&self, to: &mut Hasher) {
        let Self { along_mm, radius_mm } = self;
        to.numbers("mm", &[*along_mm, *radius_mm]);
    }
}

impl Identify for Feather {
    fn feed(&self, to: &mut Hasher) {
        let Self { shaft, barb, barbule, disorder } = self;
        to.part("shaft", shaft).part("barb", barb).list("barbule", barbule).part("disorder", disorder);
    }
}

impl Identify for ShaftShape {
    fn feed(&self, to: &mut Hasher) {
        let Self { length_mm, calamus, radius_mm, tip_radius_mm, taper, height, bend, arch } = self;
        to.numbers("shaft", &[*length_mm, *calamus, *radius_mm, *tip_radius_mm, *taper, *height]);
        to.numbers("bend", bend).numbers("arch", arch);
    }
}

impl Identify for BarbShape {
    fn feed(&self, to: &mut Hasher) {
        let Self { spacing_um, angle, curl, camber, width_um, height, half_width_mm, outline } = self;
        to.numbers("barb", &[*spacing_um, *curl, *camber, *width_um, *height, *half_width_mm]);
        to.numbers("angle", angle).numbers("outline", outline);
    }
}

impl Identify for BarbuleShape {
    fn feed(&self, to: &mut Hasher) {
        let Self { length_um, width_um, spacing_um, angle, lift, tilt, root_tilt, cell_um, swelling } = self;
        to.numbers("size", &[*length_um, *width_um, *spacing_um, *cell_um]);
        to.numbers("angle", angle).numbers("lift", lift);
        to.numbers("turn", &[*tilt, *root_tilt, *swelling]);
    }
}

impl Identify for Disorder {
    fn feed(&self, to: &mut Hasher) {
        let Self { barb, barbule, turn } = self;
        to.numbers("barb", barb).numbers("barbule", barbule).number("turn", *turn);
    }
}
