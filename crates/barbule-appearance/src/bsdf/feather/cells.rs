//! How a barbule differs from place to place: cells of their own size of nanostructure, walls between them, and the arch of its
//! cross-section.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::DVec3;

use crate::bsdf::hit::Hit;
use crate::math::rng::split_mix;

/// What differs from cell to cell. The default is a flat barbule of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cells {
    /// Standard deviation of the nanostructure's size from cell to cell of a barbule, as a share: films are thicker by it,
    /// lattices wider.
    pub size: f64,
    /// The same from barbule to barbule.
    pub barbule_size: f64,
    /// Length of the wall between two cells, mm: dark keratin.
    pub wall_mm: f64,
    /// Where a cross-section is an arch, which place of it mirrors what.
    pub arch: Option<Arch>,
}

impl Cells {
    /// Factor to the size of the nanostructure at a hit. Maxwell's equations know no length: what is larger by a factor
    /// scatters longer waves the same way (dispersion aside).
    #[inline]
    pub(super) fn size(&self, hit: &Hit) -> f64 {
        if self.size == 0.0 && self.barbule_size == 0.0 {
            return 1.0;
        }
        1.0 + self.size * bell(hit.instance) + self.barbule_size * bell(hit.id)
    }

    /// Whether a hit lies on a wall.
    #[inline]
    pub(super) fn is_wall(&self, hit: &Hit) -> bool {
        let on = &hit.ribbon;
        let from_wall = on.place.min(1.0 - on.place) * on.cell_length;
        on.cell_length > 0.0 && from_wall < 0.5 * self.wall_mm
    }
}

/// A number of mean 0 and deviation 1 that a name stands for, within ±3.5: the sum of four uniform ones.
#[inline]
fn bell(name: u64) -> f64 {
    let bits = split_mix(name ^ 0x5bd1_e995_7b11_c3a1);
    let sum = (0..4).map(|k| (bits >> (16 * k) & 0xffff) as f64).sum::<f64>();
    // Four uniform numbers of 2¹⁶ values have a mean of 2 (2¹⁶ − 1) and a variance of (2³² − 1)/3.
    (sum - 131_070.0) * (3.0_f64 / 4_294_967_295.0).sqrt()
}

/// The arch of a cross-section: a circle's, from one edge to the other.
///
/// The tabulated BRDF is that of the whole section. Where a picture resolves the section's width, light between two directions
/// comes from the place whose normal is half-way between them; the BRDF is multiplied by how much of it comes from the hit.
/// Over the width that has a mean of 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arch {
    /// Slope of the normal at the edge towards −x, rad: positive leans to +x.
    pub low: f64,
    /// At the edge towards +x.
    pub high: f64,
    /// Deviation of the places that mirror one pair of directions, over half the width: about √(λR) of the arch's radius R, for
    /// light bends at less.
    pub blur: f64,
}

impl Arch {
    /// The arch of a width, µm, whose edges' normals lean so, rad; none where they lean alike, which is flat.
    #[must_use]
    pub fn between([first, second]: [f64; 2], width_um: f64) -> Option<Self> {
        let (low, high) = (first.min(second), first.max(second));
        let half_width_um = 0.5 * width_um;
        let radius_um = 2.0 * half_width_um / (libm::sin(high) - libm::sin(low)).max(LEAST_ARCH);
        let blur = (GREEN_UM * radius_um).sqrt() / half_width_um;
        (high - low > LEAST_ARCH).then_some(Self { low, high, blur })
    }

    /// How much of the light between two directions comes from the place x, −1 … 1 across, over the mean of the width.
    #[must_use]
    pub fn share(self, x: f64, wo: DVec3, wi: DVec3) -> f64 {
        OnArch { arch: self, x, blur: self.blur }.share(wo, wi)
    }

    #[inline]
    pub(super) fn at(self, hit: &Hit) -> OnArch {
        let half_width = hit.ribbon.half_width;
        let footprint = if half_width > 0.0 { hit.footprint / half_width } else { f64::INFINITY };
        OnArch { arch: self, x: hit.uv[1], blur: self.blur.hypot(footprint) }
    }
}

/// A place of an arch.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnArch {
    arch: Arch,
    /// −1 … 1 across.
    x: f64,
    /// With the ray's footprint.
    blur: f64,
}

impl OnArch {
    /// How much of the light between two directions comes from here, over the mean of the width.
    #[inline]
    pub(super) fn share(&self, wo: DVec3, wi: DVec3) -> f64 {
        if self.blur > MOST_BLUR {
            return 1.0;
        }
        let half = wo + wi;
        let [low, high] = [self.arch.low, self.arch.high].map(libm::sin);
        let across = (half.x * half.x + half.z * half.z).sqrt().max(f64::MIN_POSITIVE);
        // Directions that no place mirrors are those of diffraction at the nearer edge.
        let mirror = ((2.0 * half.x / across - low - high) / (high - low)).clamp(-1.0, 1.0);
        let below = |x: f64| 0.5 * libm::erfc((mirror - x) / self.blur * FRAC_1_SQRT_2);
        let mean = 0.5 * (below(1.0) - below(-1.0));
        let d = (self.x - mirror) / self.blur;
        libm::exp(-0.5 * d * d) / (self.blur * (2.0 * PI).sqrt() * mean)
    }
}

/// Less of a slope between the edges is flat.
const LEAST_ARCH: f64 = 1e-3;

/// The wavelength that blurs arches.
const GREEN_UM: f64 = 0.55;

/// Over this blur the width is even within a few percent.
const MOST_BLUR: f64 = 3.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::OnRibbon;

    #[test]
    fn sizes_have_their_deviation_and_walls_their_share() {
        let cells = Cells { size: 0.05, wall_mm: 0.003, ..Cells::default() };
        let (mut sum, mut squares, mut walls) = (0.0, 0.0, 0);
        let count = 40_000;
        for n in 0..count {
            let place = (f64::from(n) + 0.5) / f64::from(count);
            let ribbon = OnRibbon { place, cell_length: 0.03, ..OnRibbon::default() };
            let hit = Hit { instance: split_mix(n as u64), ribbon, ..Hit::default() };
            let size = cells.size(&hit) - 1.0;
            sum += size;
            squares += size * size;
            walls += u32::from(cells.is_wall(&hit));
        }
        let n = f64::from(count);
        assert!((sum / n).abs() < 1e-3 && ((squares / n).sqrt() / 0.05 - 1.0).abs() < 0.01);
        assert!((f64::from(walls) / n - 0.1).abs() < 1e-3);
    }

    /// The mean over the width is the whole section's, and the brightest place is the one that mirrors.
    #[test]
    fn an_arch_shares_out_its_light_and_keeps_it() {
        let arch = Arch { low: -0.9, high: 0.7, blur: 0.15 };
        for (wo, wi) in [(0.1, 0.4), (-0.8, -0.3), (0.9, 1.2), (-1.4, 0.2)] {
            let direction = |a: f64| DVec3::new(a.sin() * 0.9, (0.19f64).sqrt(), a.cos() * 0.9);
            let (wo, wi) = (direction(wo), direction(wi));
            for footprint in [0.0, 0.004, 0.03] {
                let steps = 4000;
                let (mut mean, mut best) = (0.0, (0.0, 0.0));
                for i in 0..steps {
                    let x = 2.0 * (f64::from(i) + 0.5) / f64::from(steps) - 1.0;
                    let ribbon = OnRibbon { half_width: 0.02, ..OnRibbon::default() };
                    let on = arch.at(&Hit { uv: [0.0, x], footprint, ribbon, ..Hit::default() });
                    let share = on.share(wo, wi);
                    mean += share / f64::from(steps);
                    if share > best.1 {
                        best = (x, share);
                    }
                }
                assert!((mean - 1.0).abs() < 1e-5, "{footprint}: {mean}");
                let normal = (wo + wi) / (wo + wi).x.hypot((wo + wi).z);
                let x =
                    (2.0 * normal.x - arch.low.sin() - arch.high.sin()) / (arch.high.sin() - arch.low.sin());
                assert!((best.0 - x.clamp(-1.0, 1.0)).abs() < 1e-3, "{best:?} {x}");
            }
        }
    }
}
