//! Feathers of species: sizes of the iridescent region of one contour feather.
//!
//! Widths of barbules are those of the simulated cross-sections (supplement of the feather-appearance paper); the
//! tilts and angles of the rock dove come from the public scene of Huang et al. 2022; lengths and spacings are
//! estimates within the ranges known for each group, chosen so that barbules of neighbouring barbs meet.

use super::{BarbShape, BarbuleShape, Disorder, Feather, ShaftShape};

/// Degrees to radians.
const DEG: f64 = std::f64::consts::PI / 180.0;

/// Differences between the parts of one feather: 3 % in length, 1.5° in the angle of barbs; 3° and 4° in the planar
/// angle and lift of barbules, 8 % in their spacing.
const DISORDER: Disorder =
    Disorder { barb: [0.03, 1.5 * DEG, 0.05], barbule: [3.0 * DEG, 4.0 * DEG, 0.08, 0.06], turn: 2.0 * DEG };

/// A contour feather's shaft.
const SHAFT: ShaftShape = ShaftShape {
    length_mm: 30.0,
    calamus: 0.12,
    radius_mm: 0.25,
    tip_radius_mm: 0.02,
    taper: 1.0,
    height: 1.0,
    bend: [0.0, 0.0],
    arch: [0.0, -25.0 * DEG],
};

const BARB: BarbShape = BarbShape {
    spacing_um: 270.0,
    angle: [60.0 * DEG, 25.0 * DEG],
    curl: 15.0 * DEG,
    camber: 0.18,
    width_um: 34.0,
    height: 1.6,
    half_width_mm: 8.0,
    outline: [0.6, 0.45],
};

const BARBULE: BarbuleShape = BarbuleShape {
    length_um: 320.0,
    width_um: 25.0,
    spacing_um: 24.0,
    angle: [42.0 * DEG, 28.0 * DEG],
    lift: [14.0 * DEG, -14.0 * DEG],
    tilt: -8.0 * DEG,
    root_tilt: 0.0,
    cell_um: 30.0,
    swelling: 2.0 * DEG,
};

/// Neck feather of a rock dove: long, twisted barbules.
#[must_use]
pub fn rock_dove() -> Feather {
    let barbule = BarbuleShape {
        length_um: 460.0,
        width_um: 40.0,
        spacing_um: 26.0,
        angle: [32.0 * DEG, 22.0 * DEG],
        tilt: -0.35,
        root_tilt: -0.5,
        cell_um: 35.0,
        ..BARBULE
    };
    Feather {
        shaft: SHAFT,
        barb: BarbShape { spacing_um: 300.0, half_width_mm: 7.0, ..BARB },
        barbule: [barbule, BarbuleShape { lift: [6.0 * DEG, -10.0 * DEG], ..barbule }],
        disorder: DISORDER,
    }
}

/// Breast feather of a starling: narrow, pointed vane.
#[must_use]
pub fn starling() -> Feather {
    let barbule = BarbuleShape { length_um: 280.0, ..BARBULE };
    Feather {
        shaft: ShaftShape { radius_mm: 0.2, ..SHAFT },
        barb: BarbShape { spacing_um: 250.0, half_width_mm: 5.0, outline: [0.5, 0.8], ..BARB },
        barbule: [barbule, BarbuleShape { lift: [8.0 * DEG, -10.0 * DEG], ..barbule }],
        disorder: DISORDER,
    }
}

/// Wing covert of a bronzewing: broad, flat plates.
#[must_use]
pub fn bronzewing() -> Feather {
    let barbule = BarbuleShape {
        length_um: 360.0,
        width_um: 40.0,
        spacing_um: 32.0,
        angle: [46.0 * DEG, 34.0 * DEG],
        tilt: -10.0 * DEG,
        cell_um: 35.0,
        ..BARBULE
    };
    Feather {
        shaft: ShaftShape { length_mm: 50.0, radius_mm: 0.35, ..SHAFT },
        barb: BarbShape { spacing_um: 280.0, half_width_mm: 13.0, ..BARB },
        barbule: [barbule, BarbuleShape { lift: [8.0 * DEG, -10.0 * DEG], ..barbule }],
        disorder: DISORDER,
    }
}

/// Gorget feather of a hummingbird: short barbules turned about their own axes like the slats of a blind.
#[must_use]
pub fn hummingbird() -> Feather {
    let barbule = BarbuleShape {
        length_um: 150.0,
        width_um: 24.0,
        spacing_um: 19.0,
        angle: [48.0 * DEG, 40.0 * DEG],
        lift: [10.0 * DEG, -6.0 * DEG],
        tilt: -32.0 * DEG,
        cell_um: 24.0,
        ..BARBULE
    };
    Feather {
        shaft: ShaftShape { length_mm: 7.0, radius_mm: 0.11, calamus: 0.1, ..SHAFT },
        barb: BarbShape {
            spacing_um: 155.0,
            half_width_mm: 2.4,
            width_um: 26.0,
            angle: [55.0 * DEG, 25.0 * DEG],
            ..BARB
        },
        barbule: [barbule, barbule],
        disorder: DISORDER,
    }
}

/// Head feather of a mallard: small, dense as velvet.
#[must_use]
pub fn mallard() -> Feather {
    let barbule = BarbuleShape {
        length_um: 330.0,
        width_um: 40.0,
        spacing_um: 28.0,
        angle: [44.0 * DEG, 34.0 * DEG],
        lift: [16.0 * DEG, -12.0 * DEG],
        ..BARBULE
    };
    Feather {
        shaft: ShaftShape { length_mm: 15.0, radius_mm: 0.14, calamus: 0.1, ..SHAFT },
        barb: BarbShape { spacing_um: 230.0, half_width_mm: 3.6, outline: [0.6, 0.5], ..BARB },
        barbule: [barbule, BarbuleShape { lift: [10.0 * DEG, -10.0 * DEG], ..barbule }],
        disorder: DISORDER,
    }
}

/// Tail feather of a magpie: long, with flat barbules.
#[must_use]
pub fn magpie() -> Feather {
    let barbule = BarbuleShape {
        length_um: 370.0,
        width_um: 40.0,
        spacing_um: 29.0,
        angle: [44.0 * DEG, 34.0 * DEG],
        tilt: -10.0 * DEG,
        ..BARBULE
    };
    Feather {
        shaft: ShaftShape { length_mm: 230.0, radius_mm: 0.6, tip_radius_mm: 0.05, ..SHAFT },
        barb: BarbShape { spacing_um: 230.0, half_width_mm: 15.0, angle: [45.0 * DEG, 30.0 * DEG], ..BARB },
        barbule: [barbule, BarbuleShape { lift: [8.0 * DEG, -10.0 * DEG], ..barbule }],
        disorder: DISORDER,
    }
}

/// The eye of a peacock's train feather: long barbules of many cells. Their arched top is part of the simulation, not of
/// the geometry.
#[must_use]
pub fn peafowl() -> Feather {
    let barbule = BarbuleShape {
        length_um: 520.0,
        width_um: 40.0,
        spacing_um: 30.0,
        angle: [42.0 * DEG, 36.0 * DEG],
        cell_um: 25.0,
        ..BARBULE
    };
    Feather {
        shaft: ShaftShape { length_mm: 120.0, radius_mm: 0.45, tip_radius_mm: 0.05, ..SHAFT },
        barb: BarbShape { spacing_um: 300.0, half_width_mm: 25.0, width_um: 40.0, ..BARB },
        barbule: [barbule, BarbuleShape { lift: [8.0 * DEG, -10.0 * DEG], ..barbule }],
        disorder: DISORDER,
    }
}
