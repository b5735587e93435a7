//! What identifies structures: everything that decides what they scatter, and nothing else.
//!
//! Media are fed as the materials that they mean, so that neither their names nor their files matter.

use super::section::material;
use super::{
    Circle, CrystalLayer, Inclusion, Lattice, Loop, Medium, Placed, Polyline, Regularity, Rod, Section,
    SpeciesModel, Substance,
};
use crate::identity::{Hasher, Identify};
use crate::material::Library;

/// A value whose names mean materials of a library.
struct In<'a, T>(&'a T, &'a Library);

impl Identify for In<'_, Substance> {
    fn feed(&self, to: &mut Hasher) {
        match (material(self.0, self.1), self.0) {
            (Ok(material), _) => to.part("material", &material),
            // Never in what has passed its checks.
            (Err(_), Substance::Named(name)) => to.text("unknown", name),
            (Err(_), Substance::Index(index)) => to.numbers("unusable", &[index.re, index.im]),
        };
    }
}

impl Identify for In<'_, Medium> {
    fn feed(&self, to: &mut Hasher) {
        let Self(medium, library) = self;
        match medium {
            Medium::Pure(substance) => to.part("pure", &In(substance, library)),
            Medium::Mixture { first, second, x_um, fraction } => to
                .part("first", &In(first, library))
                .part("second", &In(second, library))
                .numbers("x_um", x_um)
                .numbers("fraction", fraction),
        };
    }
}

impl Identify for Polyline {
    fn feed(&self, to: &mut Hasher) {
        let Self { x_um, z_um } = self;
        to.numbers("x_um", x_um).numbers("z_um", z_um);
    }
}

impl Identify for Loop {
    fn feed(&self, to: &mut Hasher) {
        match self {
            Self::Polygon(corners) => to.part("polygon", corners),
            Self::Circle { x_um, z_um, radius_um } => to.numbers("circle", &[*x_um, *z_um, *radius_um]),
        };
    }
}

impl Identify for In<'_, Inclusion> {
    fn feed(&self, to: &mut Hasher) {
        let Self(Inclusion { outline, medium, holes }, library) = self;
        to.part("outline", outline).part("medium", &In(medium, library)).list("holes", holes);
    }
}

impl Identify for Regularity {
    fn feed(&self, to: &mut Hasher) {
        let Self { x_um, value } = self;
        to.numbers("x_um", x_um).numbers("value", value);
    }
}

impl Identify for CrystalLayer {
    fn feed(&self, to: &mut Hasher) {
        let Self { lattice, offset_um, regularity } = self;
        to.part("lattice", lattice).number("offset_um", *offset_um).list("regularity", regularity.as_slice());
    }
}

impl Identify for Section {
    fn feed(&self, to: &mut Hasher) {
        let Self {
            name: _,
            width_um,
            boundaries,
            media,
            inclusions,
            crystal,
            source: _,
            library,
            materials: _,
            // How it is simulated, which campaigns record beside it.
            smooth_um: _,
            nesting: _,
        } = self;
        to.number("width_um", *width_um)
            .list("boundaries", boundaries)
            .list("media", media.iter().map(|medium| In(medium, library)))
            .list("inclusions", inclusions.iter().map(|inclusion| In(inclusion, library)))
            .list("crystal", crystal.as_slice());
    }
}

impl Identify for Lattice {
    fn feed(&self, to: &mut Hasher) {
        // Rows count by where their rods are.
        let Self {
            period_um,
            host,
            incidence,
            depth_to_center_um: _,
            rows: _,
            row_pitch_um: _,
            row_shift: _,
            rods,
            library,
        } = self;
        to.number("period_um", *period_um)
            .part("host", &In(host, library))
            .part("incidence", &In(incidence, library))
            .list("rods", rods.iter().map(|rod| In(rod, library)))
            .list("places", self.placed().collect::<Vec<_>>());
    }
}

impl Identify for In<'_, Rod> {
    fn feed(&self, to: &mut Hasher) {
        let Self(Rod { x_um: _, z_um: _, rows: _, circles }, library) = self;
        to.list("circles", circles.iter().map(|circle| In(circle, library)));
    }
}

impl Identify for In<'_, Circle> {
    fn feed(&self, to: &mut Hasher) {
        let Self(Circle { diameter_um, medium }, library) = self;
        to.number("diameter_um", *diameter_um).part("medium", &In(medium, library));
    }
}

impl Identify for Placed {
    fn feed(&self, to: &mut Hasher) {
        let Self { rod, row: _, x_um, depth_um } = self;
        to.count("rod", *rod as u64).numbers("at_um", &[*x_um, *depth_um]);
    }
}

impl Identify for SpeciesModel {
    fn feed(&self, to: &mut Hasher) {
        // How it is simulated is recorded beside it.
        let Self { name, variant, latin: _, coloration: _, parameters, library, smoothing: _ } = self;
        let media: Vec<Substance> = self.media().map(Substance::named).collect();
        to.text("species", name)
            .text("variant", variant)
            .part("parameters", parameters)
            .list("media", media.iter().map(|medium| In(medium, library)));
    }
}
