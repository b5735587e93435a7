//! The European starling (the feather paper's supplement, §1.2): a keratin film over a chain of melanosomes, and its mirror image at the bottom.

use super::super::chain::chain;
use super::super::curve::{Roughness, grid, point_count};
use super::super::outline::rounded;
use super::super::section::{Medium, Parts, Polyline, Substance};
use super::generator::{Generator, Random, ordered, parts};
use crate::fields::within;
use crate::material::Library;
use crate::math::rng::Stream;
use crate::record;

/// How far chains go on past the ends before they are cut, µm.
const PAST_ENDS_UM: f64 = 2.0;

record! {
    /// Parameters of the starling generator.
    #[derive(Debug, Clone, PartialEq, serde::Serialize)]
    pub struct Starling {
        /// Width of the barbule.
        width_um: f64 = "width_um", within(1, 200);
        /// Mean distance of top and bottom.
        thickness_um: f64 = "thickness_um", within(0.1, 50);
        /// Correlation length of the outline's roughness.
        roughness_correlation_um: f64 = "roughness_correlation_um", within(0.05, 100);
        /// The outline's roughness spans ± this.
        roughness_amplitude_um: f64 = "roughness_amplitude_um", within(0, 10);
        /// Keratin between the surface and the melanosomes.
        cortex_um: f64 = "cortex_um", within(0.001, 10);
        /// Mean diameter of the melanosomes.
        melanosome_diameter_um: f64 = "melanosome_diameter_um", within(0.02, 5);
        /// Diameters are D·U(1−this, 1+this).
        melanosome_spread: f64 = "melanosome_spread", within(0, 0.5);
        /// Correlation length of the melanin fraction between the chains.
        core_correlation_um: f64 = "core_correlation_um", within(0.05, 100);
        /// Least melanin fraction between the chains.
        core_fraction_low: f64 = "core_fraction_low", within(0, 1);
        /// Largest melanin fraction between the chains.
        core_fraction_high: f64 = "core_fraction_high", within(0, 1);
        /// Distance of points along the shapes.
        point_spacing_um: f64 = "point_spacing_um", within(0.005, 1);
    }
}

impl Generator for Starling {
    fn width_um(&self) -> f64 {
        self.width_um
    }

    fn is_alike_below(&self) -> bool {
        true
    }

    fn check(&self) -> crate::Result<()> {
        ordered("core_fraction_low", self.core_fraction_low, "core_fraction_high", self.core_fraction_high)
    }

    fn room(&self) -> String {
        "thickness_um must hold cortex_um and melanosome_diameter_um twice, the outline's roughness_amplitude_um too; make it larger or these smaller".into()
    }

    fn parts(&self, random: &Random, _library: &Library) -> Parts {
        let roughness = Roughness::symmetric(self.roughness_correlation_um, self.roughness_amplitude_um);
        let spacing = self.point_spacing_um;
        let (top, bottom) =
            rounded(&mut random.stream(0), self.width_um, self.thickness_um, roughness, spacing);
        let (upper, lower) = self.layer(&mut random.stream(1), &top);
        let (mirrored_upper, mirrored_lower) = self.layer(&mut random.stream(2), &bottom.flipped());
        let core = Roughness {
            correlation_um: self.core_correlation_um,
            low: self.core_fraction_low,
            high: self.core_fraction_high,
        };
        let core = mixture(&mut random.stream(3), core, self.width_um, spacing);
        let named = Medium::named;
        parts(
            self.width_um,
            vec![top, upper, lower, mirrored_lower.flipped(), mirrored_upper.flipped(), bottom],
            vec![
                named("air"),
                named("keratin"),
                named("melanin"),
                core,
                named("melanin"),
                named("keratin"),
                named("air"),
            ],
        )
    }
}

impl Starling {
    /// The two boundaries of the chain under a surface.
    fn layer(&self, stream: &mut Stream, surface: &Polyline) -> (Polyline, Polyline) {
        let depth = self.cortex_um + 0.5 * self.melanosome_diameter_um;
        let guide = surface.extended(PAST_ENDS_UM + depth).below(|_| depth);
        let (upper, lower) =
            chain(stream, &guide, self.melanosome_diameter_um, self.melanosome_spread, self.point_spacing_um);
        (upper.cut(self.width_um), lower.cut(self.width_um))
    }
}

/// Keratin and melanin in a fraction that varies along the barbule.
pub(super) fn mixture(stream: &mut Stream, fraction: Roughness, width: f64, spacing: f64) -> Medium {
    let count = point_count(width, spacing);
    let x_um = grid(width, count);
    let step = width / (count - 1) as f64;
    let fraction = fraction.along(stream, count, step);
    Medium::Mixture {
        first: Substance::named("keratin"),
        second: Substance::named("melanin"),
        x_um,
        fraction,
    }
}
