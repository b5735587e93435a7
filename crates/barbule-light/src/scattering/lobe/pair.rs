//! Two lobes that together stand for one mean distribution.
//!
//! One lobe cannot follow a mean intensity that has shoulders, or two modes where a colour's edge crosses it. The scales
//! of both are eliminated (the module `search`).

use std::f64::consts::PI;

use super::products::{Even, Two};
use super::search::{Least, Limits, Normal, least, of_one, of_two};
use super::{Fit, FitKind, Fitter, Lobe, SECOND_START, bounded, bounded_phi, chain, dot, unbounded};

/// A second lobe with less than this part of the energy is none.
const LEAST_ENERGY: f64 = 1e-4;

/// When searches end.
const LIMITS: Limits = Limits { error: 1e-5, step: 1e-6, evaluations: 150 };

/// Two lobes: U' = Σ `scales[k]` · shape of `lobes[k]`. Where one lobe is enough both are the same and the second's scale
/// is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The lobes; the first reflects more.
    pub lobes: [Lobe; 2],
    /// Factors on the shapes, ≥ 0.
    pub scales: [f64; 2],
}

/// A fitted pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairFit {
    /// The pair.
    pub pair: Pair,
    /// ‖U' − U‖ / ‖U‖ over the azimuths; 0 for zero input.
    pub residual: f64,
    /// Whether the least squares settled.
    pub converged: bool,
}

impl From<Fit> for PairFit {
    fn from(fit: Fit) -> Self {
        let pair = Pair { lobes: [fit.lobe; 2], scales: [fit.scale, 0.0] };
        Self { pair, residual: fit.residual, converged: fit.converged }
    }
}

impl Pair {
    /// Σ scale · shape; see [`Lobe::shape`].
    #[must_use]
    pub fn shape(&self, kind: FitKind, theta_i: f64, phi_o: f64) -> f64 {
        let part = |k: usize| self.scales[k] * self.lobes[k].shape(kind, theta_i, phi_o);
        part(0) + part(1)
    }
}

/// What of a pair is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// Widths and azimuths.
    Free,
    /// Widths alone.
    Widths,
    /// One width and azimuth: the second lobe is the first one's mirror image and as strong.
    Even,
}

impl Fitter {
    /// The best pair of lobes for `values` (U) with light from φ_i, rad.
    ///
    /// Starts are the [single fit](Self::fit) with a lobe on what it leaves, and the single lobe split into a narrower and
    /// a wider one. Towards grazing the azimuths pass over into φ_i as those of single lobes do. Never worse than the
    /// single fit where azimuths are free.
    #[must_use]
    pub fn fit_pair(&self, phi_i: f64, values: &[f64]) -> PairFit {
        let single = self.fit(phi_i, values);
        if single.scale <= 0.0 {
            return single.into();
        }
        let freedom = self.freedom(phi_i);
        if freedom <= 0.0 {
            return self.better(single, self.best_pair(Form::Widths, &splits(single.lobe), values));
        }
        let mut starts = self.beside(&single, values);
        starts.push(splits(single.lobe)[0]);
        let free = self.best_pair(Form::Free, &starts, values);
        if freedom >= 1.0 {
            return self.better(single, free);
        }
        let towards = |lobe: Lobe| Lobe { phi: bounded_phi(phi_i + freedom * (lobe.phi - phi_i)), ..lobe };
        let start = free.map_or(splits(single.lobe)[0], |fit| fit.pair.lobes.map(towards));
        self.better(single, self.best_pair(Form::Widths, &[start], values))
    }

    /// The best pair that is its own mirror image, for `values` that are: two lobes about φ = 0, or two alike on both sides
    /// of it.
    #[must_use]
    pub fn fit_even_pair(&self, values: &[f64]) -> PairFit {
        let single = self.fit_m(0.0, values);
        if single.scale <= 0.0 {
            return single.into();
        }
        let widths = self.better(single, self.best_pair(Form::Widths, &splits(single.lobe), values));
        if self.freedom(0.0) < 1.0 {
            return widths;
        }
        let peak = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
        let side = ((peak as f64 + 0.5) * self.step - 0.5 * PI).abs();
        let m = single.lobe.m;
        let starts = [(0.5 * m, side.max(0.5 * m)), (0.7 * m, m), (0.3 * m, 1.5 * m)]
            .map(|(m, phi)| Lobe { m: m.clamp(0.003, 0.95), phi: bounded_phi(phi) })
            .map(|lobe| [lobe, lobe.mirrored()]);
        match self.best_pair(Form::Even, &starts, values) {
            Some(even) if even.residual < widths.residual => even,
            _ => widths,
        }
    }

    /// The pair if it brings something, else the single lobe.
    fn better(&self, single: Fit, pair: Option<PairFit>) -> PairFit {
        match pair {
            Some(pair) if pair.residual < single.residual && pair.pair.scales[1] > 0.0 => pair,
            _ => single.into(),
        }
    }

    /// The single lobe with a narrow and with a wide one where it leaves most.
    fn beside(&self, single: &Fit, values: &[f64]) -> Vec<[Lobe; 2]> {
        let shape = self.values(single.lobe);
        let rest: Vec<f64> = values.iter().zip(&shape).map(|(v, s)| v - single.scale * s).collect();
        let smooth = smoothed(&rest);
        let mut best = (0.0, 0..0);
        for run in smooth.chunk_by(|a, b| (*a > 0.0) == (*b > 0.0)) {
            let area = run.iter().sum::<f64>();
            if area > best.0 {
                // Runs are parts of one slice: their places are the differences of their addresses.
                let from = (run.as_ptr() as usize - smooth.as_ptr() as usize) / size_of::<f64>();
                best = (area, from..from + run.len());
            }
        }
        let (area, run) = best;
        if area <= 0.0 {
            return Vec::new();
        }
        let azimuth = |k: usize| (k as f64 + 0.5) * self.step - 0.5 * PI;
        let centroid = run.clone().map(|k| azimuth(k) * smooth[k]).sum::<f64>() / area;
        let peak = run.map(|k| smooth[k]).fold(f64::MIN_POSITIVE, f64::max);
        // The area under D₁ against φ_o is π m times its peak.
        let width = area * self.step / peak / PI;
        let lobe = |factor: f64| Lobe { m: (factor * width).clamp(0.003, 0.95), phi: bounded_phi(-centroid) };
        [0.6, 1.8].map(|factor| [single.lobe, lobe(factor)]).to_vec()
    }

    /// Refines the two best starts, and where both fit badly the next too.
    fn best_pair(&self, form: Form, starts: &[[Lobe; 2]], values: &[f64]) -> Option<PairFit> {
        let problem = Problem::new(self, form, values);
        let mut ranked: Vec<(f64, [Lobe; 2])> =
            starts.iter().map(|&start| (problem.error(start), start)).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<PairFit> = None;
        for (tried, (_, start)) in ranked.into_iter().enumerate() {
            if tried >= 2 && best.is_some_and(|fit| fit.residual < SECOND_START) {
                break;
            }
            let fit = problem.refined(start);
            if best.is_none_or(|best| fit.residual < best.residual) {
                best = Some(fit);
            }
        }
        best
    }
}

/// A lobe split into a narrower and a wider one.
fn splits(lobe: Lobe) -> [[Lobe; 2]; 2] {
    let scaled = |factor: f64| Lobe { m: (factor * lobe.m).clamp(0.002, 0.98), ..lobe };
    [(0.5, 2.0), (0.9, 4.0)].map(|(a, b)| [scaled(a), scaled(b)])
}

/// Running means of seven.
fn smoothed(values: &[f64]) -> Vec<f64> {
    let count = values.len();
    let window = |k: usize| &values[k.saturating_sub(3)..(k + 4).min(count)];
    (0..count).map(|k| window(k).iter().sum::<f64>() / window(k).len() as f64).collect()
}

/// Least squares over the unbounded parameters (t, u) of two lobes, or of one whose mirror image is the other.
struct Problem<'a> {
    fitter: &'a Fitter,
    form: Form,
    values: Vec<f64>,
    total: f64,
}

impl<'a> Problem<'a> {
    fn new(fitter: &'a Fitter, form: Form, values: &[f64]) -> Self {
        let values = fitter.azimuths.padded(values.iter().copied());
        let total = dot(&values, &values);
        Self { fitter, form, values, total }
    }

    /// The equations of an even pair, and the scale of both lobes.
    fn even_at(&self, [t, u]: [f64; 2]) -> (Normal<2>, [f64; 1]) {
        let Fitter { azimuths, kind, .. } = self.fitter;
        let products = azimuths.products(*kind, &Even(bounded(t, u)), [&self.values[..]]);
        of_one(&products, chain(t, u, true), self.total)
    }

    /// The equations of any other pair, and its scales.
    fn at(&self, [t1, u1, t2, u2]: [f64; 4]) -> (Normal<4>, [f64; 2]) {
        let Fitter { azimuths, kind, .. } = self.fitter;
        let lobes = [bounded(t1, u1), bounded(t2, u2)];
        let products = azimuths.products(*kind, &Two(lobes), [&self.values[..]]);
        let chains = [chain(t1, u1, self.free_phi()), chain(t2, u2, self.free_phi())];
        of_two(&products, chains, self.total)
    }

    fn free_phi(&self) -> bool {
        self.form != Form::Widths
    }

    fn parameters(&self, [first, second]: [Lobe; 2]) -> [f64; 4] {
        let [[t1, u1], [t2, u2]] = [first, second].map(|lobe| unbounded(lobe, self.free_phi()));
        [t1, u1, t2, u2]
    }

    /// The squared error of a start.
    fn error(&self, start: [Lobe; 2]) -> f64 {
        match self.form {
            Form::Even => self.even_at(unbounded(start[0], true)).0.error,
            Form::Free | Form::Widths => self.at(self.parameters(start)).0.error,
        }
    }

    /// What a start is refined to.
    fn refined(&self, start: [Lobe; 2]) -> PairFit {
        if self.form == Form::Even {
            let found = least(unbounded(start[0], true), LIMITS, |place| self.even_at(place));
            let Least { parameters: [t, u], error, with: [scale], converged } = found;
            let lobe = bounded(t, u);
            let pair = Pair { lobes: [lobe, lobe.mirrored()], scales: [scale; 2] };
            return PairFit { pair, residual: error.sqrt(), converged };
        }
        let found = least(self.parameters(start), LIMITS, |place| self.at(place));
        let Least { parameters: [t1, u1, t2, u2], error, with: scales, converged } = found;
        let lobes = [bounded(t1, u1), bounded(t2, u2)];
        let energy = [0, 1].map(|k| scales[k] * self.fitter.values(lobes[k]).iter().sum::<f64>());
        let order = if energy[0] >= energy[1] { [0, 1] } else { [1, 0] };
        let (mut lobes, mut scales) = (order.map(|k| lobes[k]), order.map(|k| scales[k]));
        if energy[order[1]] < LEAST_ENERGY * energy[order[0]] {
            (lobes[1], scales[1]) = (lobes[0], 0.0);
        }
        PairFit { pair: Pair { lobes, scales }, residual: error.sqrt(), converged }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::directions;
    use crate::scattering::lobe::search::tests::gradients_match;

    fn values(kind: FitKind, theta: f64, pair: &Pair, count: usize) -> Vec<f64> {
        directions::azimuths(count).map(|phi| pair.shape(kind, theta, phi)).collect()
    }

    #[test]
    fn a_pair_is_found_again_from_its_own_values() {
        for kind in [FitKind::Marginal, FitKind::Cone] {
            for (first, second, scales) in [
                ((0.05, 0.3), (0.2, 0.1), [1.0, 2.0]),
                ((0.1, 0.5), (0.1, -0.2), [1.0, 0.4]),
                ((0.04, -0.6), (0.15, -0.6), [1.0, 1.5]),
                ((0.3, 0.9), (0.05, 0.2), [1.0, 0.05]),
            ] {
                let lobe = |(m, phi)| Lobe { m, phi };
                let pair = Pair { lobes: [lobe(first), lobe(second)], scales };
                let fit = Fitter::new(kind, 0.5, 400).fit_pair(0.3, &values(kind, 0.5, &pair, 400));
                assert!(fit.converged && fit.residual < 2e-3, "{pair:?} {fit:?}");
                let near = |a: Lobe, b: Lobe| (a.m / b.m - 1.0).abs() < 0.02 && (a.phi - b.phi).abs() < 5e-3;
                let [a, b] = fit.pair.lobes;
                assert!(
                    (near(a, pair.lobes[0]) && near(b, pair.lobes[1]))
                        || (near(b, pair.lobes[0]) && near(a, pair.lobes[1])),
                    "{pair:?} {fit:?}"
                );
            }
        }
    }

    #[test]
    fn one_lobe_stays_one() {
        let pair = Pair { lobes: [Lobe { m: 0.1, phi: 0.4 }; 2], scales: [0.7, 0.0] };
        let fit = Fitter::new(FitKind::Marginal, 0.2, 400)
            .fit_pair(0.4, &values(FitKind::Marginal, 0.2, &pair, 400));
        assert!(fit.residual < 1e-4, "{fit:?}");
        let area = |lobe: Lobe, scale: f64| scale * lobe.m;
        let [first, second] = [0, 1].map(|k| area(fit.pair.lobes[k], fit.pair.scales[k]));
        assert!(second < 1e-3 * first || (fit.pair.lobes[1].m - 0.1).abs() < 1e-3, "{fit:?}");
    }

    #[test]
    fn even_values_leave_even_pairs() {
        let fitter = Fitter::new(FitKind::Marginal, 0.3, 400);
        let lobe = |m, phi| Lobe { m, phi };
        for pair in [
            Pair { lobes: [lobe(0.05, 0.0), lobe(0.3, 0.0)], scales: [1.0, 1.0] },
            Pair { lobes: [lobe(0.08, 0.2), lobe(0.08, -0.2)], scales: [0.6, 0.6] },
        ] {
            let fit = fitter.fit_even_pair(&values(FitKind::Marginal, 0.3, &pair, 400));
            assert!(fit.residual < 1e-3, "{pair:?} {fit:?}");
            let [a, b] = fit.pair.lobes;
            assert!((a.phi + b.phi).abs() < 1e-12, "{fit:?}");
        }
    }

    #[test]
    fn input_without_light_does_not_fail() {
        let fitter = Fitter::new(FitKind::Marginal, 0.3, 400);
        for values in [vec![0.0; 400], vec![-1.0; 400], vec![f64::NAN; 400], vec![], vec![1e-300; 400]] {
            for fit in [fitter.fit_pair(0.4, &values), fitter.fit_even_pair(&values)] {
                assert!(fit.pair.scales.iter().all(|s| *s >= 0.0), "{fit:?}");
                assert!(fit.pair.lobes.iter().all(|l| l.phi.is_finite() && l.m <= 1.0), "{fit:?}");
            }
        }
    }

    #[test]
    fn towards_grazing_both_azimuths_become_the_incident_one() {
        let theta = 0.3_f64;
        let pair =
            Pair { lobes: [Lobe { m: 0.05, phi: 0.9 }, Lobe { m: 0.3, phi: 1.1 }], scales: [1.0, 1.0] };
        for cosine in [0.03, 0.05] {
            let phi_i = (cosine / theta.cos()).acos();
            let values = values(FitKind::Marginal, theta, &pair, 400);
            let fit = Fitter::new(FitKind::Marginal, theta, 400).fit_pair(phi_i, &values);
            assert!(fit.pair.lobes.iter().all(|lobe| (lobe.phi - phi_i).abs() < 1e-6), "{fit:?}");
        }
    }

    /// Kaufman's Jacobian gives the exact gradient of the squared error, though not the exact Jacobian.
    #[test]
    fn gradients_match_differences() {
        let pair =
            Pair { lobes: [Lobe { m: 0.2, phi: 0.3 }, Lobe { m: 0.1, phi: -0.3 }], scales: [0.7, 0.3] };
        for (kind, form) in
            [(FitKind::Marginal, Form::Free), (FitKind::Cone, Form::Free), (FitKind::Marginal, Form::Even)]
        {
            let fitter = Fitter::new(kind, 0.4, 50);
            let values = values(kind, 0.4, &pair, 50);
            let start = [Lobe { m: 0.15, phi: 0.2 }, Lobe { m: 0.12, phi: -0.2 }];
            let problem = Problem::new(&fitter, form, &values);
            if form == Form::Even {
                gradients_match(unbounded(start[0], true), 1e-7, |place| problem.even_at(place));
            } else {
                gradients_match(problem.parameters(start), 1e-7, |place| problem.at(place));
            }
        }
    }
}
