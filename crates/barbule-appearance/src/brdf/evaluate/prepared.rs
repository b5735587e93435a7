//! A material in one light: what is the same for every direction in which it is looked at.

use glam::DVec3;

use super::super::noise::Draw;
use super::super::sample::direction;
use super::super::table::{Incident, Table};
use super::{FeatherBrdf, is_above};

/// A [`FeatherBrdf`] at N wavelengths and one incident direction; N is a multiple of four.
#[derive(Debug, Clone, Copy)]
pub struct PreparedBrdf<'a, const N: usize = 4> {
    pub(super) brdf: &'a FeatherBrdf,
    pub(super) wavelengths_nm: [f32; N],
    pub(super) wi: DVec3,
    pub(super) incident: Incident,
}

impl<const N: usize> PreparedBrdf<'_, N> {
    /// f in 1/sr without the cosine; see [`FeatherBrdf::eval`]. `instance` is what [`FeatherBrdf::instance`] gives.
    #[must_use]
    #[inline]
    pub fn eval(&self, wo: DVec3, instance: Option<&Draw>) -> [f32; N] {
        let mut values = [0.0; N];
        if is_above(self.wi) && is_above(wo) {
            let (waves, directions) = (&self.wavelengths_nm, [self.wi, wo]);
            self.brdf.add_both_ways(waves, directions, Some(&self.incident), instance, &mut values);
        }
        values
    }

    /// See [`FeatherBrdf::sample`]; `lane` chooses the wavelength.
    #[must_use]
    pub fn sample(&self, lane: usize, u: [f64; 2]) -> Option<(DVec3, f64)> {
        let outgoing = self.direction(lane, u)?;
        Some((outgoing, self.pdf(lane, outgoing)))
    }

    /// [`sample`](Self::sample) without the density.
    #[must_use]
    pub fn direction(&self, lane: usize, u: [f64; 2]) -> Option<DVec3> {
        if !is_above(self.wi) {
            return None;
        }
        let (incident, tables) = (&self.incident, &self.brdf.tables.sets);
        let simplex = self.brdf.tables.grid.simplex(incident, f64::from(self.wavelengths_nm[lane]));
        let share = |table: &Table, k: usize, lobe: usize| {
            f64::from(simplex.weight[k]) * f64::from(table.shares[simplex.at[k] as usize].0[2 + lobe])
        };
        let mut total = 0.0;
        for table in tables {
            for k in 0..4 {
                total += share(table, k, 0) + share(table, k, 1);
            }
        }
        // Walk through the lobes until their shares reach u; what remains is uniform again.
        let mut rest = u[0] * total;
        let (mut chosen, mut left) = ((0, 0, 0), 0.5);
        'found: for (number, table) in tables.iter().enumerate() {
            for k in 0..4 {
                for lobe in 0..2 {
                    let own = share(table, k, lobe);
                    if own > 0.0 {
                        chosen = (number, k, lobe);
                        left = (rest / own).min(1.0 - f64::EPSILON);
                        if rest < own {
                            break 'found;
                        }
                    }
                    rest -= own;
                }
            }
        }
        let (table, k, lobe) = chosen;
        let node = &tables[table].nodes[simplex.at[k] as usize];
        let [_, own] = incident.corner(simplex.corners()[k]);
        let azimuth = self.brdf.tables.sampler.azimuth(node, lobe, incident, own, u[1]);
        let longitudinal = &self.brdf.tables.longitudinal;
        let inclination = longitudinal.draw(&longitudinal.mixed(&simplex), incident.along, left);
        let outgoing = direction(incident, azimuth, inclination);
        is_above(outgoing).then_some(outgoing)
    }

    /// See [`FeatherBrdf::pdf`]; `lane` chooses the wavelength.
    #[must_use]
    pub fn pdf(&self, lane: usize, wo: DVec3) -> f64 {
        self.pdfs(wo)[lane]
    }

    /// See [`FeatherBrdf::pdfs`].
    #[must_use]
    #[inline]
    pub fn pdfs(&self, wo: DVec3) -> [f64; N] {
        let mut densities = [0.0; N];
        if is_above(self.wi) && is_above(wo) {
            self.brdf.densities(&self.wavelengths_nm, &self.incident, wo, &mut densities);
        }
        densities
    }
}
