//! Barbules coloured by photonic crystals (seed, §1.5–1.7): rods of melanin under the cortex, hexagonal or rectangular,
//! solid or hollow, with or without air channels between them.

use super::super::lattice::{Circle, Lattice, Rod};
use super::super::section::Substance;
use super::parameters;
use crate::Result;
use crate::material::Library;

parameters! {
    /// Parameters of the crystal generator.
    Crystal {
        /// Width of the barbule.
        width_um: f64 = 1 to 200,
        /// Correlation length of the top's roughness.
        roughness_correlation_um: f64 = 0.05 to 100,
        /// The top's roughness spans ± this.
        roughness_amplitude_um: f64 = 0 to 10,
        /// Distance of points along the top.
        point_spacing_um: f64 = 0.005 to 1,
        /// Period across the barbule.
        period_um: f64 = 0.001 to 10,
        /// Rows of rods.
        rows: usize = 1 to 100,
        /// Distance of rows.
        row_pitch_um: f64 = 0.001 to 10,
        /// Shift of every other row, in periods.
        row_shift: f64 = 0 to 1,
        /// Keratin above the first row.
        cortex_um: f64 = 0 to 10,
        /// Diameter of the rods.
        rod_diameter_um: f64 = 0.001 to 10,
        /// Diameter of the air inside the rods; 0: solid ones.
        core_diameter_um: f64 = 0 to 10,
        /// Diameter of the air channels between rods, halfway between rows and columns; 0: none.
        channel_diameter_um: f64 = 0 to 10,
    }
}

impl Crystal {
    /// The crystal under a flat top.
    pub(super) fn lattice(&self, library: Library) -> Lattice {
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

    pub(super) fn check(&self) -> Result<()> {
        self.lattice(Library::builtin()).check()
    }
}
