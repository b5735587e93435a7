//! What a current at one point makes at another: the kernels of Müller's equations.

use super::green::{Green, Radial};
use super::mesh::{Boundary, Mesh};
use super::shape::{Chord, Point};
use crate::{Complex64, Result};
use std::f64::consts::FRAC_1_PI;

/// Unknowns of a node, and its equations, in this order: E_y, H̃_t, H̃_y, E_t.
pub(super) const COMPONENTS: usize = 4;

/// What the unknowns of a source add to the equations at a target: `[equation][unknown]`.
pub(super) type Block = [[Complex64; COMPONENTS]; COMPONENTS];

/// The regions' waves.
#[derive(Debug, Clone)]
pub(super) struct Kernel {
    /// Vacuum wave number and its part along the barbule, rad/µm.
    k: f64,
    k_y: f64,
    /// Of each region: Green's function and ε.
    regions: Vec<(Green, Complex64)>,
    boundaries: Vec<Boundary>,
}

/// Sums over the regions that two boundaries share, with the sign of the source's normal in each.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// Σ ± G, Σ ± εG, Σ ± κ²G.
    value: Complex64,
    value_epsilon: Complex64,
    value_kappa: Complex64,
    /// Σ ± G′/r, Σ ± εG′/r.
    slope: Complex64,
    slope_epsilon: Complex64,
}

impl Sums {
    fn add(&mut self, sign: f64, radial: Radial, pole: f64, kappa_squared: Complex64, epsilon: Complex64) {
        let (value, slope) = (sign * radial.value, sign * radial.slope);
        self.value += value;
        self.value_epsilon += epsilon * value;
        self.value_kappa += kappa_squared * value;
        self.slope += slope;
        self.slope_epsilon += epsilon * (slope - sign * pole);
    }
}

impl Kernel {
    /// For light of this wave number (rad/µm) and its part along the barbule.
    ///
    /// # Errors
    /// The Hankel functions are out of range.
    pub(super) fn new(mesh: &Mesh, k: f64, k_y: f64) -> Result<Self> {
        let region = |r: usize| {
            let epsilon = mesh.epsilon(r);
            let kappa = (k * k * epsilon - k_y * k_y).sqrt();
            // The root with Im κ ≥ 0; −0 would choose the other one.
            let kappa = if kappa.im < 0.0 { -kappa } else { kappa };
            Ok((Green::new(kappa)?, epsilon))
        };
        let regions = (0..mesh.indices.len()).map(region).collect::<Result<_>>()?;
        Ok(Self { k, k_y, regions, boundaries: mesh.boundaries.clone() })
    }

    /// Whether any region touches both boundaries.
    pub(super) fn are_coupled(&self, target: usize, source: usize) -> bool {
        let (a, b) = (self.boundaries[target], self.boundaries[source]);
        target == source || a.outside == b.outside || a.outside == b.inside || a.inside == b.outside
    }

    /// What multiplies the fields themselves in Müller's equations: (ε_out + ε_in)/2 for E; 1 for H̃.
    pub(super) fn mean_epsilon(&self, boundary: usize) -> Complex64 {
        let Boundary { outside, inside } = self.boundaries[boundary];
        0.5 * (self.regions[outside].1 + self.regions[inside].1)
    }

    fn sums(&self, target: usize, source: usize, r_um: f64) -> Option<Sums> {
        let (a, b) = (self.boundaries[target], self.boundaries[source]);
        let mut sums = Sums::default();
        let pole = 0.5 * FRAC_1_PI / (r_um * r_um);
        let mut add = |region: usize, sign: f64| {
            let (green, epsilon) = &self.regions[region];
            sums.add(sign, green.at(r_um), pole, green.kappa_squared(), *epsilon);
        };
        if target == source {
            add(b.outside, 1.0);
            add(b.inside, -1.0);
            return Some(sums);
        }
        // The currents' normals lead out of the source's inside.
        let (region, sign) = if a.outside == b.outside || a.inside == b.outside {
            (b.outside, 1.0)
        } else if a.outside == b.inside {
            (b.inside, -1.0)
        } else {
            return None;
        };
        add(region, sign);
        sums.slope -= sign * pole;
        Some(sums)
    }

    /// The kernel of the equations at `target`, which stands on boundary `a`, from a `source` on boundary `b`; `None` where
    /// no region touches both. The E equations are divided by (ε_out + ε_in)/2.
    ///
    /// With X = J or M along t′ and y, d = ρ − ρ′, q = G′/r (S.53 for fields ∝ e^{jk_y y}):
    /// 𝓛 = ∫GX + ∇∇·∫GX/k_r², 𝓚 = ∇ × ∫GX; J = n × H̃, M = −n × E.
    pub(super) fn block(
        &self,
        (a, target): (usize, &Point),
        (b, source): (usize, &Point),
        chord: &Chord,
    ) -> Option<Block> {
        let [dx, dz] = chord.way;
        let r = (dx * dx + dz * dz).sqrt();
        let sums = self.sums(a, b, r)?;
        let [t, u] = [target.tangent, source.tangent];
        let m = source.normal();
        let (td, ud) = (t[0] * dx + t[1] * dz, u[0] * dx + u[1] * dz);
        let (nd, md) = (chord.target_normal, chord.source_normal);
        let (tu, tm) = (t[0] * u[0] + t[1] * u[1], t[0] * m[0] + t[1] * m[1]);
        let cosines = td * ud / (r * r);
        let j = Complex64::i();
        let (k, k_y) = (self.k, self.k_y);
        let l_tt = sums.value_epsilon * tu
            + (sums.slope * (tu - 2.0 * cosines) - sums.value_kappa * cosines) / (k * k);
        let l_yy = sums.value_kappa / (k * k);
        let along = j * (k_y / (k * k)) * sums.slope;
        let (l_yt, l_ty) = (along * ud, along * td);
        let jk = j * k;
        let slope_e = sums.slope_epsilon;
        let over = self.mean_epsilon(a).inv();
        let turned = -j * k_y * tm;
        let zero = Complex64::ZERO;
        Some([
            [slope_e * md * over, -jk * l_yy * over, jk * l_yt * over, zero],
            [-jk * l_tt, sums.slope * nd, turned * sums.value, jk * l_ty],
            [-jk * l_yt, zero, sums.slope * md, jk * l_yy],
            [turned * sums.value_epsilon * over, -jk * l_ty * over, jk * l_tt * over, slope_e * nd * over],
        ])
    }
}
