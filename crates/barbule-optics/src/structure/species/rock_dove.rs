//! The rock dove (the feather paper's supplement, §1.1): a keratin cortex with air on both sides, arched, melanin granules inside.

use super::super::curve::{Roughness, grid, point_count};
use super::super::outline::arched;
use super::super::section::{Medium, Parts, Polyline, Substance};
use super::generator::{Generator, Random, ordered, parts};
use crate::fields::within;
use crate::material::Library;
use crate::record;

record! {
    /// Parameters of the rock dove generator.
    #[derive(Debug, Clone, PartialEq, serde::Serialize)]
    pub struct RockDove {
        /// Width of the barbule.
        width_um: f64 = "width_um", within(1, 200);
        /// Mean distance of the top and the lower inner cortex.
        thickness_um: f64 = "thickness_um", within(0.1, 50);
        /// The arc ends at an angle Φ of at least this.
        arc_low_deg: f64 = "arc_low_deg", within(5, 85);
        /// The arc ends at an angle Φ of at most this.
        arc_high_deg: f64 = "arc_high_deg", within(5, 85);
        /// The ends slope by an angle β of at least this.
        slope_low_deg: f64 = "slope_low_deg", within(0, 60);
        /// The ends slope by an angle β of at most this.
        slope_high_deg: f64 = "slope_high_deg", within(0, 60);
        /// Correlation length of the top's roughness.
        roughness_correlation_um: f64 = "roughness_correlation_um", within(0.05, 100);
        /// The top's roughness spans ± this.
        roughness_amplitude_um: f64 = "roughness_amplitude_um", within(0, 10);
        /// Thickness of the keratin cortex, top and bottom.
        cortex_um: f64 = "cortex_um", within(0.001, 10);
        /// Correlation length of the air gap under the cortex.
        gap_correlation_um: f64 = "gap_correlation_um", within(0.05, 100);
        /// Least air gap.
        gap_low_um: f64 = "gap_low_um", within(0, 10);
        /// Largest air gap.
        gap_high_um: f64 = "gap_high_um", within(0, 10);
        /// Correlation length of the melanin fraction inside.
        melanin_correlation_um: f64 = "melanin_correlation_um", within(0.05, 100);
        /// Least melanin fraction.
        melanin_low: f64 = "melanin_low", within(0, 1);
        /// Largest melanin fraction.
        melanin_high: f64 = "melanin_high", within(0, 1);
        /// tanβ of the lower cortex is this times the top's.
        lower_slope: f64 = "lower_slope", within(0, 2);
        /// Correlation length of the lower cortex's roughness.
        lower_roughness_correlation_um: f64 = "lower_roughness_correlation_um", within(0.05, 100);
        /// The lower cortex's roughness spans ± this.
        lower_roughness_amplitude_um: f64 = "lower_roughness_amplitude_um", within(0, 10);
        /// Distance of points along the shapes.
        point_spacing_um: f64 = "point_spacing_um", within(0.005, 1);
    }
}

impl Generator for RockDove {
    fn width_um(&self) -> f64 {
        self.width_um
    }

    fn check(&self) -> crate::Result<()> {
        ordered("arc_low_deg", self.arc_low_deg, "arc_high_deg", self.arc_high_deg)?;
        ordered("slope_low_deg", self.slope_low_deg, "slope_high_deg", self.slope_high_deg)?;
        ordered("gap_low_um", self.gap_low_um, "gap_high_um", self.gap_high_um)?;
        ordered("melanin_low", self.melanin_low, "melanin_high", self.melanin_high)
    }

    fn room(&self) -> String {
        "thickness_um must hold cortex_um, gap_high_um, roughness_amplitude_um and lower_roughness_amplitude_um; make it larger or these smaller".into()
    }

    fn parts(&self, random: &Random, _library: &Library) -> Parts {
        let (width, spacing) = (self.width_um, self.point_spacing_um);
        let mut shape = random.stream(0);
        let mut arc = || shape.uniform(self.arc_low_deg, self.arc_high_deg).to_radians();
        let (upper_arc, lower_arc) = (arc(), arc());
        let tan_beta = libm::tan(shape.uniform(self.slope_low_deg, self.slope_high_deg).to_radians());
        let roughness = Roughness::symmetric(self.roughness_correlation_um, self.roughness_amplitude_um);
        let top = arched(&mut random.stream(1), width, upper_arc, tan_beta, roughness, spacing, 0.0);
        let lower =
            Roughness::symmetric(self.lower_roughness_correlation_um, self.lower_roughness_amplitude_um);
        let lower_slope = tan_beta * self.lower_slope;
        let lower_inner =
            arched(&mut random.stream(2), width, lower_arc, lower_slope, lower, spacing, -self.thickness_um);
        let cortex = |outside: &Polyline| {
            outside.extended(1.0 + 2.0 * self.cortex_um).below(|_| self.cortex_um).cut(width)
        };
        let (inner, lower_outer) = (cortex(&top), cortex(&lower_inner));
        let gap = Roughness {
            correlation_um: self.gap_correlation_um,
            low: self.gap_low_um,
            high: self.gap_high_um,
        };
        let count = inner.x_um.len();
        let step = width / (count - 1) as f64;
        let gaps = gap.along(&mut random.stream(3), count, step);
        // The line's two extra points take the gap of the ends.
        let inside =
            inner.extended(1.0 + 2.0 * self.gap_high_um).below(|i| gaps[i.clamp(1, count) - 1]).cut(width);
        let count = point_count(width, spacing);
        let melanin = Roughness {
            correlation_um: self.melanin_correlation_um,
            low: self.melanin_low,
            high: self.melanin_high,
        };
        let filling = Medium::Mixture {
            first: Substance::named("air"),
            second: Substance::named("melanin"),
            x_um: grid(width, count),
            fraction: melanin.along(&mut random.stream(4), count, width / (count - 1) as f64),
        };
        let named = Medium::named;
        parts(
            width,
            vec![top, inner, inside, lower_inner, lower_outer],
            vec![named("air"), named("keratin"), named("air"), filling, named("keratin"), named("air")],
        )
    }

    fn is_curved(&self) -> bool {
        true
    }
}
