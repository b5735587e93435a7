//! The shapes of a multilayer.

use super::super::super::curve::{Roughness, grid, mean, point_count};
use super::super::super::offset::under;
use super::super::super::section::{Medium, Parts, Polyline, Substance};
use super::super::generator::{Random, parts};
use super::{LowerSide, Multilayer, MultilayerLayer};
use crate::math::rng::Stream;
use crate::stack::CLIP;

/// No layer is anywhere thinner than this part of its mean, and no core than this part of `core_um`.
const LEAST_PART: f64 = 0.1;
/// Over this width, at the ends of `layered_width_um`, layers fade into their mean.
const FADE_UM: f64 = 0.2;

/// Purposes of random streams; those of the lower side come one later.
const TOP: u64 = 0;
const BOTTOM: u64 = 1;
const BETWEEN: u64 = 2;
const WITHIN: u64 = 3;
const WAVINESS: u64 = 5;
const ROUGHNESS: u64 = 7;
const CORE: u64 = 9;

impl Multilayer {
    /// One random section, but for name and source.
    pub(super) fn build(&self, random: &Random) -> Parts {
        let shape = self.shape();
        let top = self.rough(random, TOP, shape.clone());
        let layers = self.written_out();
        let mut boundaries = vec![top];
        boundaries.extend(self.stack(random, 0, &boundaries[0], &layers));
        let mut media = vec![Medium::named(&self.outside)];
        media.extend(self.media_of(&layers));
        media.push(Medium::named(&self.core));
        let lower = match self.lower {
            LowerSide::None => return parts(self.sizes.width_um, boundaries, media),
            LowerSide::Plain => layers.into_iter().filter(|(place, _)| *place == 0).collect(),
            LowerSide::Mirrored => layers,
        };
        let thickness = self.thickness_um(random, [&self.written_out(), &lower]);
        let bottom = under(&shape, &vec![thickness; shape.x_um.len()]);
        let bottom = self.rough(random, BOTTOM, bottom).flipped();
        let mut below = vec![bottom];
        below.extend(self.stack(random, 1, &below[0], &lower));
        let mut below: Vec<Polyline> = below.iter().rev().map(Polyline::flipped).collect();
        self.make_room(&boundaries[boundaries.len() - 1], &mut below);
        boundaries.extend(below);
        media.extend(self.media_of(&lower).into_iter().rev());
        media.push(Medium::named(&self.outside));
        parts(self.sizes.width_um, boundaries, media)
    }

    /// From the top to the bottom of an individual with layers on both sides of the core, without roughness.
    fn thickness_um(&self, random: &Random, sides: [&[(usize, MultilayerLayer)]; 2]) -> f64 {
        let Some(spread) = self.core_spread else {
            let [upper, lower] =
                sides.map(|layers| layers.iter().map(|(_, layer)| layer.thickness_um).sum::<f64>());
            return upper + self.sizes.core_um + lower;
        };
        let core = 1.0 + spread * deviate(&mut random.stream(CORE));
        let own = |side: u64, layers: &[(usize, MultilayerLayer)]| -> f64 {
            let thick = layers.iter().enumerate().map(|(written, (place, layer))| {
                layer.thickness_um * self.relative_thickness(random, side, written, *place, layer)
            });
            thick.sum()
        };
        own(0, sides[0]) + self.sizes.core_um * core.max(LEAST_PART) + own(1, sides[1])
    }

    /// How thick a layer is in an individual, as a part of its mean. What individuals differ by is common to all repetitions
    /// and to both sides.
    fn relative_thickness(
        &self,
        random: &Random,
        side: u64,
        written: usize,
        place: usize,
        layer: &MultilayerLayer,
    ) -> f64 {
        let between = layer.spread * deviate(&mut random.part(BETWEEN, place));
        let within = layer.spread_within * deviate(&mut random.part(WITHIN + side, written));
        1.0 + between + within
    }

    /// The cortex, where there is one, and the layers, with the place of each in its group.
    fn written_out(&self) -> Vec<(usize, MultilayerLayer)> {
        let cortex = (self.sizes.cortex_um > 0.0).then(|| MultilayerLayer {
            medium: self.cortex_medium.clone(),
            thickness_um: self.sizes.cortex_um,
            spread: self.sizes.spread,
            spread_within: 0.0,
            waviness: self.sizes.waviness,
        });
        let group = || self.layers.iter().cloned().enumerate().map(|(place, layer)| (place + 1, layer));
        cortex
            .into_iter()
            .map(|layer| (0, layer))
            .chain((0..self.sizes.repeats).flat_map(|_| group()))
            .collect()
    }

    /// The top without roughness.
    pub(super) fn shape(&self) -> Polyline {
        let x_um = grid(self.sizes.width_um, point_count(self.sizes.width_um, self.sizes.point_spacing_um));
        let mut z_um: Vec<f64> = x_um.iter().map(|&x| self.arch(x) + self.fold(x)).collect();
        let shift = mean(&z_um);
        z_um.iter_mut().for_each(|z| *z -= shift);
        Polyline { x_um, z_um }
    }

    /// Height of the circle through the middle and the ends.
    fn arch(&self, x: f64) -> f64 {
        let (sagitta, half) = (self.sizes.sagitta_um.abs(), 0.5 * self.sizes.width_um);
        if sagitta == 0.0 {
            return 0.0;
        }
        let radius = 0.5 * (half * half / sagitta + sagitta);
        // R − √(R² − x²) without the loss of digits of a nearly flat circle.
        -(x * x / (radius + libm::sqrt(radius * radius - x * x))).copysign(self.sizes.sagitta_um)
    }

    /// Height of the fold: level in the middle, then a circle, then a line.
    fn fold(&self, x: f64) -> f64 {
        let slope = self.sizes.fold_deg.abs().to_radians();
        let past = (x.abs() - 0.5 * self.sizes.fold_flat_um).max(0.0);
        let radius = self.sizes.fold_radius_um;
        let round = radius * libm::sin(slope);
        let fall = if past < round {
            past * past / (radius + libm::sqrt(radius * radius - past * past))
        } else {
            radius * (1.0 - libm::cos(slope)) + (past - round) * libm::tan(slope)
        };
        if self.sizes.fold_deg < 0.0 { fall } else { -fall }
    }

    /// A surface with its roughness.
    fn rough(&self, random: &Random, purpose: u64, mut surface: Polyline) -> Polyline {
        let roughness =
            Roughness::symmetric(self.sizes.roughness_correlation_um, self.sizes.roughness_amplitude_um);
        let profile = self.profile(roughness, &mut random.stream(purpose));
        surface.z_um.iter_mut().zip(profile).for_each(|(z, rough)| *z += rough);
        surface
    }

    /// A rough profile at the points of all boundaries; zero where it has no height.
    fn profile(&self, roughness: Roughness, stream: &mut Stream) -> Vec<f64> {
        let count = point_count(self.sizes.width_um, self.sizes.point_spacing_um);
        if roughness.high == 0.0 {
            return vec![0.0; count];
        }
        roughness.along(stream, count, self.sizes.width_um / (count - 1) as f64)
    }

    /// The boundaries under a surface, one under each layer; `side` is 0 for the upper stack and 1 for the lower one.
    fn stack(
        &self,
        random: &Random,
        side: u64,
        surface: &Polyline,
        layers: &[(usize, MultilayerLayer)],
    ) -> Vec<Polyline> {
        let mut boundaries: Vec<Polyline> = Vec::with_capacity(layers.len());
        // By how much roughness has moved the last boundary up.
        let mut above = vec![0.0; surface.x_um.len()];
        for (written, (place, layer)) in layers.iter().enumerate() {
            let part = self.relative_thickness(random, side, written, *place, layer);
            let waviness = Roughness::symmetric(self.sizes.waviness_correlation_um, layer.waviness);
            let waviness = self.profile(waviness, &mut random.part(WAVINESS + side, written));
            let rough = Roughness::symmetric(
                self.sizes.layer_roughness_correlation_um,
                self.sizes.layer_roughness_um,
            );
            let rough = self.profile(rough, &mut random.part(ROUGHNESS + side, written));
            let depth: Vec<f64> = rough
                .iter()
                .zip(&waviness)
                .zip(&mut above)
                .map(|((rough, waviness), above)| {
                    let smooth = layer.thickness_um * part * (1.0 + waviness);
                    // A boundary's own roughness moves it and not those below.
                    let depth = (smooth + *above - rough).max(LEAST_PART * layer.thickness_um);
                    *above += smooth - depth;
                    depth
                })
                .collect();
            boundaries.push(under(boundaries.last().unwrap_or(surface), &depth));
        }
        boundaries
    }

    /// The media of the layers from the top down, which fade into their mean beyond `layered_width_um`.
    fn media_of(&self, layers: &[(usize, MultilayerLayer)]) -> Vec<Medium> {
        let fades = self.sizes.layered_width_um < self.sizes.width_um;
        let Some([first, second]) = self.two_media().filter(|_| fades) else {
            return layers.iter().map(|(_, layer)| Medium::named(&layer.medium)).collect();
        };
        let thickness = |name: Option<&str>| {
            let counts = |layer: &&MultilayerLayer| name.is_none_or(|name| layer.medium == name);
            self.layers.iter().filter(counts).map(|layer| layer.thickness_um).sum::<f64>()
        };
        let beyond = thickness(Some(second)) / thickness(None);
        let (inner, outer) =
            (0.5 * (self.sizes.layered_width_um - FADE_UM), 0.5 * (self.sizes.layered_width_um + FADE_UM));
        let faded = |layer: &MultilayerLayer| {
            let own = if layer.medium == second { 1.0 } else { 0.0 };
            Medium::Mixture {
                first: Substance::named(first),
                second: Substance::named(second),
                x_um: vec![-outer, -inner, inner, outer],
                fraction: vec![beyond, own, own, beyond],
            }
        };
        layers
            .iter()
            .map(|(place, layer)| if *place == 0 { Medium::named(&layer.medium) } else { faded(layer) })
            .collect()
    }

    /// The two media of the layers, where they are two.
    pub(super) fn two_media(&self) -> Option<[&str; 2]> {
        let first = &self.layers.first()?.medium;
        let second = &self.layers.iter().find(|layer| layer.medium != *first)?.medium;
        let two = self.layers.iter().all(|layer| layer.medium == *first || layer.medium == *second);
        two.then_some([first, second])
    }

    /// Moves the lower side down until the core is nowhere thinner than it may be.
    fn make_room(&self, upper: &Polyline, below: &mut [Polyline]) {
        let gaps = upper.z_um.iter().zip(&below[0].z_um).map(|(above, under)| above - under);
        let least = gaps.fold(f64::INFINITY, f64::min);
        let missing = (LEAST_PART * self.sizes.core_um - least).max(0.0);
        for boundary in below {
            boundary.z_um.iter_mut().for_each(|z| *z -= missing);
        }
    }
}

/// A standard normal deviation, clipped.
fn deviate(stream: &mut Stream) -> f64 {
    stream.normal().clamp(-CLIP, CLIP)
}
