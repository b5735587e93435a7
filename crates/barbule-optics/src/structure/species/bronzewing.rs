//! The common bronzewing (the feather paper's supplement, §1.3): a stack of melanosome chains under the top and another over the bottom.

use super::super::chain::chain;
use super::super::curve::Roughness;
use super::super::outline::rounded;
use super::super::section::{Medium, Parts, Polyline};
use super::generator::{Generator, Random, ordered, parts};
use super::starling::mixture;
use crate::fields::within;
use crate::material::Library;
use crate::record;

/// How far chains go on past the ends before they are cut, µm for each row.
const PAST_ENDS_UM: f64 = 1.0;

/// The barbule's thickness is two cortices and this many times the height of one stack.
const STACKS: f64 = 4.5;

record! {
    /// Parameters of the bronzewing generator.
    #[derive(Debug, Clone, PartialEq, serde::Serialize)]
    pub struct Bronzewing {
        /// Width of the barbule.
        width_um: f64 = "width_um", within(1, 200);
        /// Melanosome layers in each stack.
        rows: usize = "rows", within(1, 40);
        /// Correlation length of the outline's roughness.
        roughness_correlation_um: f64 = "roughness_correlation_um", within(0.05, 100);
        /// The outline's roughness spans ± this.
        roughness_amplitude_um: f64 = "roughness_amplitude_um", within(0, 10);
        /// Keratin between the surface and the first layer.
        cortex_um: f64 = "cortex_um", within(0.001, 10);
        /// Mean diameter of the melanosomes.
        melanosome_diameter_um: f64 = "melanosome_diameter_um", within(0.02, 5);
        /// Diameters are D·U(1−this, 1+this).
        melanosome_spread: f64 = "melanosome_spread", within(0, 0.5);
        /// Keratin between layers: the period is the diameter plus this.
        spacing_um: f64 = "spacing_um", within(0.001, 5);
        /// Correlation length of the melanin fraction between the stacks.
        core_correlation_um: f64 = "core_correlation_um", within(0.05, 100);
        /// Least melanin fraction between the stacks.
        core_fraction_low: f64 = "core_fraction_low", within(0, 1);
        /// Largest melanin fraction between the stacks.
        core_fraction_high: f64 = "core_fraction_high", within(0, 1);
        /// Distance of points along the shapes.
        point_spacing_um: f64 = "point_spacing_um", within(0.005, 1);
    }
}

impl Generator for Bronzewing {
    fn width_um(&self) -> f64 {
        self.width_um
    }

    fn is_alike_below(&self) -> bool {
        true
    }

    fn check(&self) -> crate::Result<()> {
        ordered("core_fraction_low", self.core_fraction_low, "core_fraction_high", self.core_fraction_high)?;
        let room = self.spacing_um - self.melanosome_spread * self.melanosome_diameter_um;
        if room <= 0.0 {
            return Err(crate::Error::input(format!(
                "parameters.spacing_um is {}, so that melanosomes that are larger by melanosome_spread touch those of the next layer; make it over {}",
                self.spacing_um,
                self.melanosome_spread * self.melanosome_diameter_um
            )));
        }
        Ok(())
    }

    fn room(&self) -> String {
        format!(
            "layers are spacing_um apart, less melanosome_spread × melanosome_diameter_um, and {} rows bend over a roughness of roughness_amplitude_um; make spacing_um larger or these smaller",
            self.rows
        )
    }

    fn parts(&self, random: &Random, _library: &Library) -> Parts {
        let (width, spacing) = (self.width_um, self.point_spacing_um);
        let period = self.melanosome_diameter_um + self.spacing_um;
        let thickness = 2.0 * self.cortex_um + STACKS * self.rows as f64 * period;
        let roughness = Roughness::symmetric(self.roughness_correlation_um, self.roughness_amplitude_um);
        let (top, bottom) = rounded(&mut random.stream(0), width, thickness, roughness, spacing);
        let upper = self.stack(random, 1, &top);
        let lower = self.stack(random, 2, &bottom.flipped());
        let core = Roughness {
            correlation_um: self.core_correlation_um,
            low: self.core_fraction_low,
            high: self.core_fraction_high,
        };
        let (keratin, melanin) = (Medium::named("keratin"), Medium::named("melanin"));
        let mut media = vec![Medium::named("air"), keratin.clone()];
        let layers = |media: &mut Vec<Medium>| {
            for row in 0..self.rows {
                media.push(melanin.clone());
                if row + 1 < self.rows {
                    media.push(keratin.clone());
                }
            }
        };
        layers(&mut media);
        media.push(mixture(&mut random.stream(3), core, width, spacing));
        layers(&mut media);
        media.extend([keratin.clone(), Medium::named("air")]);
        let mut boundaries = vec![top];
        boundaries.extend(upper);
        boundaries.extend(lower.iter().rev().map(Polyline::flipped));
        boundaries.push(bottom);
        parts(width, boundaries, media)
    }
}

impl Bronzewing {
    /// The boundaries of a stack under a surface, from the top down.
    fn stack(&self, random: &Random, purpose: u64, surface: &Polyline) -> Vec<Polyline> {
        let (diameter, rows) = (self.melanosome_diameter_um, self.rows);
        let mut boundaries = Vec::with_capacity(2 * rows);
        for row in 0..rows {
            let depth = self.cortex_um + 0.5 * diameter + row as f64 * (diameter + self.spacing_um);
            let guide = surface.extended(PAST_ENDS_UM * rows as f64 + depth).below(|_| depth);
            let stream = &mut random.part(purpose, row);
            let (upper, lower) =
                chain(stream, &guide, diameter, self.melanosome_spread, self.point_spacing_um);
            boundaries.extend([upper.cut(self.width_um), lower.cut(self.width_um)]);
        }
        boundaries
    }
}
