//! Barbules coloured by photonic crystals (the feather paper's supplement, §1.5–1.7): rods of melanin under the cortex, hexagonal or rectangular,
//! solid or hollow, with or without air channels between them, below a flat top with rounded ends or an arched one.

use super::super::crystal::{CrystalLayer, Regularity};
use super::super::curve::{Roughness, grid, mean, point_count};
use super::super::lattice::{Circle, Lattice, Rod};
use super::super::outline::{arched, rounded};
use super::super::section::{Medium, Parts, Polyline, Substance};
use super::super::side::Side;
use super::generator::{Generator, Random, ordered, parts};
use crate::Result;
use crate::fields::within;
use crate::material::Library;
use crate::record;

record! {
    /// Parameters of the crystal generator.
    #[derive(Debug, Clone, PartialEq, serde::Serialize)]
    pub struct Crystal {
        /// Width of the barbule.
        width_um: f64 = "width_um", within(1, 200);
        /// Correlation length of the top's roughness.
        roughness_correlation_um: f64 = "roughness_correlation_um", within(0.05, 100);
        /// The top's roughness spans ± this.
        roughness_amplitude_um: f64 = "roughness_amplitude_um", within(0, 10);
        /// Mean thickness of a flat barbule with rounded ends; 0: an arch.
        thickness_um: f64 = "thickness_um", within(0, 50), or 0.0;
        /// An arch ends at an angle Φ of at least this.
        arc_low_deg: f64 = "arc_low_deg", within(5, 85), or 30.0;
        /// An arch ends at an angle Φ of at most this.
        arc_high_deg: f64 = "arc_high_deg", within(5, 85), or 75.0;
        /// The ends of an arch slope by an angle β of at least this.
        slope_low_deg: f64 = "slope_low_deg", within(0, 60), or 15.0;
        /// The ends of an arch slope by an angle β of at most this.
        slope_high_deg: f64 = "slope_high_deg", within(0, 60), or 27.0;
        /// Correlation length of the crystal's regularity.
        regularity_correlation_um: f64 = "regularity_correlation_um", within(0.05, 100), or 0.5;
        /// Least regularity: the part of the ideal crystal's reflected field that a place gives.
        regularity_low: f64 = "regularity_low", within(0, 1), or 1.0;
        /// Largest regularity; what comes out over 1 counts as 1.
        regularity_high: f64 = "regularity_high", within(0, 2), or 1.0;
        /// Distance of points along the top.
        point_spacing_um: f64 = "point_spacing_um", within(0.005, 1);
        /// Period across the barbule.
        period_um: f64 = "period_um", within(0.001, 10);
        /// Rows of rods.
        rows: usize = "rows", within(1, 100);
        /// Distance of rows.
        row_pitch_um: f64 = "row_pitch_um", within(0.001, 10);
        /// Shift of every other row, in periods.
        row_shift: f64 = "row_shift", within(0, 1);
        /// Keratin above the first row.
        cortex_um: f64 = "cortex_um", within(0, 10);
        /// Diameter of the rods.
        rod_diameter_um: f64 = "rod_diameter_um", within(0.001, 10);
        /// Diameter of the air inside the rods; 0: solid ones.
        core_diameter_um: f64 = "core_diameter_um", within(0, 10);
        /// Diameter of the air channels between rods, halfway between rows and columns; 0: none.
        channel_diameter_um: f64 = "channel_diameter_um", within(0, 10);
    }
}

impl Crystal {
    /// The crystal under a flat top.
    fn cells(&self, library: Library) -> Lattice {
        let circle =
            |diameter_um: f64, medium: &str| Circle { diameter_um, medium: Substance::named(medium) };
        let mut circles = vec![circle(self.rod_diameter_um, "melanin")];
        if self.core_diameter_um > 0.0 {
            circles.push(circle(self.core_diameter_um, "air"));
        }
        let mut rods = vec![Rod { x_um: 0.0, z_um: 0.0, rows: None, circles }];
        if self.channel_diameter_um > 0.0 && self.rows > 1 {
            rods.push(Rod {
                x_um: 0.5 * self.period_um,
                z_um: 0.5 * self.row_pitch_um,
                rows: Some(self.rows - 1),
                circles: vec![circle(self.channel_diameter_um, "air")],
            });
        }
        Lattice {
            period_um: self.period_um,
            host: Substance::named("keratin"),
            incidence: Substance::named("air"),
            depth_to_center_um: Lattice::depth_under_cortex(self.cortex_um, &rods[..1]),
            rows: self.rows,
            row_pitch_um: self.row_pitch_um,
            row_shift: self.row_shift,
            rods,
            library,
        }
    }
}

impl Generator for Crystal {
    fn width_um(&self) -> f64 {
        self.width_um
    }

    fn check(&self) -> Result<()> {
        ordered("arc_low_deg", self.arc_low_deg, "arc_high_deg", self.arc_high_deg)?;
        ordered("slope_low_deg", self.slope_low_deg, "slope_high_deg", self.slope_high_deg)?;
        ordered("regularity_low", self.regularity_low, "regularity_high", self.regularity_high)?;
        self.cells(Library::builtin()).check()
    }

    fn parts(&self, random: &Random, library: &Library) -> Parts {
        let top = self.outline(random, Side::Above);
        self.under(top, random, Side::Above, self.cells(library.clone()))
    }

    /// The same crystal hangs under the bottom of a flat barbule. An arch has no thickness: its bottom is as bent as its top,
    /// with a roughness of its own.
    fn lower_parts(&self, random: &Random, library: &Library) -> Option<Parts> {
        let mut top = self.outline(random, Side::Below).turned(0.0);
        let height = mean(&top.z_um);
        top.z_um.iter_mut().for_each(|z| *z -= height);
        Some(self.under(top, random, Side::Below, self.lower_cells(library.clone())))
    }

    fn lattice(&self, library: &Library) -> Option<Lattice> {
        Some(self.cells(library.clone()))
    }

    fn lower_lattice(&self, library: &Library) -> Option<Lattice> {
        Some(self.lower_cells(library.clone()))
    }

    fn is_curved(&self) -> bool {
        self.thickness_um == 0.0
    }
}

impl Crystal {
    /// The crystal as seen from below: the mirror image of the upper one, turned about y.
    fn lower_cells(&self, library: Library) -> Lattice {
        let shift = if (2.0 * self.row_shift).fract() == 0.0 { self.row_shift } else { 1.0 - self.row_shift };
        Lattice { row_shift: shift, ..self.cells(library) }
    }

    /// A random top or bottom.
    fn outline(&self, random: &Random, side: Side) -> Polyline {
        let roughness = Roughness::symmetric(self.roughness_correlation_um, self.roughness_amplitude_um);
        let (width, spacing) = (self.width_um, self.point_spacing_um);
        let mut shape = random.stream(0);
        if self.is_curved() {
            let arc = shape.uniform(self.arc_low_deg, self.arc_high_deg).to_radians();
            let tan_beta = libm::tan(shape.uniform(self.slope_low_deg, self.slope_high_deg).to_radians());
            let mut rough = random.stream(if side == Side::Above { 1 } else { 4 });
            return arched(&mut rough, width, arc, tan_beta, roughness, spacing, 0.0);
        }
        let (top, bottom) = rounded(&mut shape, width, self.thickness_um, roughness, spacing);
        if side == Side::Above { top } else { bottom }
    }

    /// A crystal under a top, from a random place of its period on.
    fn under(&self, top: Polyline, random: &Random, side: Side, lattice: Lattice) -> Parts {
        let (width, spacing) = (self.width_um, self.point_spacing_um);
        let [places, regularities] = if side == Side::Above { [2, 3] } else { [5, 6] };
        let regularity = (self.regularity_low < 1.0).then(|| {
            let profile = Roughness {
                correlation_um: self.regularity_correlation_um,
                low: self.regularity_low,
                high: self.regularity_high,
            };
            let count = point_count(width, spacing);
            let value = profile.along(&mut random.stream(regularities), count, width / (count - 1) as f64);
            Regularity { x_um: grid(width, count), value: value.into_iter().map(|v| v.min(1.0)).collect() }
        });
        let crystal = CrystalLayer {
            lattice,
            offset_um: random.stream(places).uniform(0.0, self.period_um),
            regularity,
        };
        let media = vec![Medium::named("air"), Medium::named("keratin")];
        Parts { crystal: Some(crystal), ..parts(width, vec![top], media) }
    }
}
