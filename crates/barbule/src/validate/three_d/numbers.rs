//! What differs between invariant barbules and segments, in numbers.

use std::f64::consts::{FRAC_PI_2, PI};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Comparison, between};
use crate::solve::segment::Hemisphere;
use crate::spectrum::colour::{Illuminant, Observer};
use crate::spectrum::difference::{delta_e_2000, lab};

/// Moments of where light goes, over all instances.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// Φ_r/Φ_i.
    pub reflected: f64,
    /// Mean of ω_x, and its standard deviation.
    pub across: [f64; 2],
    /// Mean of ω_y + ω_iy, and its standard deviation; 0 in 2.5D.
    pub along: [f64; 2],
}

/// The longitudinal spread, in the σ of exp(−t²/σ²) with t ≈ (ω_y + ω_iy)/2.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Sigma {
    /// What the window along y makes alone.
    pub window: f64,
    /// From the second moment, the window taken off.
    pub second_moment: f64,
    /// The part of the light that leaves farther from the mirror's ω_y than three standard deviations of the window.
    pub beyond: f64,
}

/// One wavelength and direction.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// θ_i and φ_i, degrees.
    pub direction_deg: [f64; 2],
    /// Of the 2.5D simulation.
    pub flat: Moments,
    /// Of the segments.
    pub segments: Moments,
    /// Of the segments.
    pub sigma: Sigma,
    /// Lags at which the covariance of one instance's intensities has fallen to 1/e: across by 2.5D, across and along by
    /// segments, in ω_x and ω_y.
    pub correlation: [f64; 3],
    /// ω_x of the segments' grid, and the light per unit of ω_x there: 2.5D, segments.
    pub over_x: Vec<[f64; 3]>,
    /// ω_y + ω_iy of the segments' grid, and the light per unit of it: as the 2.5D BRDF assumes, segments.
    pub over_y: Vec<[f64; 3]>,
}

/// How far the window alone reaches along y, in standard deviations: 0.3 % of it lie beyond.
pub(super) const BEYOND: f64 = 3.0;

/// Sums over instances, whose far fields share one grid of directions.
pub(super) struct Tally {
    theta_i: f64,
    k: f64,
    sigma: f64,
    instances: f64,
    step: [f64; 2],
    /// ω_x of the columns, ω_y + ω_iy of the rows.
    x: Vec<f64>,
    u: Vec<f64>,
    /// ∫ I, ∫ I ω_x, ∫ I ω_x²: 2.5D, segments.
    across: [[f64; 3]; 2],
    /// Light of each column: 2.5D, segments.
    columns: [Vec<f64>; 2],
    /// Light of each row of the segments'.
    rows: Vec<f64>,
}

impl Tally {
    /// Nothing yet, on the grid of a far field.
    pub(super) fn new(far: &Hemisphere, theta_i: f64, k: f64, sigma: f64) -> Self {
        Self {
            theta_i,
            k,
            sigma,
            instances: 0.0,
            step: far.step,
            x: (0..far.columns()).map(|column| far.omega_x(column)).collect(),
            u: far.omega_y.iter().map(|y| y + theta_i.sin()).collect(),
            across: [[0.0; 3]; 2],
            columns: [vec![0.0; far.columns()], vec![0.0; far.columns()]],
            rows: vec![0.0; far.omega_y.len()],
        }
    }

    /// Adds the far fields of an instance that is turned by `turn`: its segment's, and that of 2.5D (1/rad over its azimuths).
    pub(super) fn add(&mut self, far: &Hemisphere, intensity: &[f64], flat: &[f64], turn: f64) {
        self.instances += 1.0;
        let columns = self.x.len();
        for (index, (value, angle)) in intensity.iter().zip(far.solid_angles()).enumerate() {
            let light = value * angle;
            self.across(1, self.x[index % columns], light);
            self.columns[1][index % columns] += light;
            self.rows[index / columns] += light;
        }
        let (step, cosine) = (PI / flat.len() as f64, self.theta_i.cos());
        let x = |edge: f64| cosine * (edge * step - FRAC_PI_2 - turn).clamp(-FRAC_PI_2, FRAC_PI_2).sin();
        for (n, value) in flat.iter().enumerate() {
            let (from, to, light) = (x(n as f64), x(n as f64 + 1.0), value * step);
            if to > from {
                self.across(0, x(n as f64 + 0.5), light);
                // Columns are wider than azimuths' steps, but not by whole numbers.
                let place = |x: f64| (x - self.x[0]) / self.step[0] + 0.5;
                spread(&mut self.columns[0], place(from), place(to), light);
            }
        }
    }

    fn across(&mut self, side: usize, x: f64, light: f64) {
        for (power, sum) in self.across[side].iter_mut().enumerate() {
            *sum += light * x.powi(power as i32);
        }
    }

    pub(super) fn found(
        self,
        wavelength_nm: f64,
        direction: [f64; 2],
        window_um: [f64; 2],
        correlations: &Correlations,
    ) -> Found {
        let count = self.instances;
        let moments = |side: usize, along: [f64; 2]| {
            let [whole, first, second] = self.across[side];
            let mean = first / whole;
            Moments {
                reflected: whole / count,
                across: [mean, (second / whole - mean * mean).max(0.0).sqrt()],
                along,
            }
        };
        let light = self.across[1][0];
        let moment = |of: &dyn Fn(f64) -> f64| {
            self.u.iter().zip(&self.rows).map(|(u, light)| of(*u) * light).sum::<f64>() / light
        };
        let mean = moment(&|u| u);
        let variance = (moment(&|u| u * u) - mean * mean).max(0.0);
        let of_window = 1.0 / (self.k * window_um[1]);
        // u is 2t cosθ, and exp(−t²/σ²) has the standard deviation σ/√2.
        let scale = std::f64::consts::FRAC_1_SQRT_2 / self.theta_i.cos();
        let per_x = count * self.step[0];
        let columns = self.x.iter().zip(self.columns[0].iter().zip(&self.columns[1]));
        let assumed = self.assumed(self.across[0][0] / count);
        let rows = self.u.iter().zip(assumed.iter().zip(&self.rows));
        Found {
            wavelength_nm,
            direction_deg: direction.map(f64::to_degrees),
            flat: moments(0, [0.0; 2]),
            segments: moments(1, [mean, variance.sqrt()]),
            sigma: Sigma {
                window: scale * of_window,
                second_moment: scale * (variance - of_window * of_window).max(0.0).sqrt(),
                beyond: moment(&|u| if u.abs() > BEYOND * of_window { 1.0 } else { 0.0 }),
            },
            correlation: correlations.lags(),
            over_x: columns.map(|(x, (flat, segments))| [*x, flat / per_x, segments / per_x]).collect(),
            over_y: rows
                .map(|(u, (assumed, light))| [*u, *assumed, light / (count * self.step[1])])
                .collect(),
        }
    }

    /// What the BRDF's exp(−t²/σ²) makes of all that is reflected, per unit of ω_y, at each row.
    fn assumed(&self, reflected: f64) -> Vec<f64> {
        let value = |u: &f64| {
            let t = (0.5 * (self.theta_i + (u - self.theta_i.sin()).clamp(-1.0, 1.0).asin())).sin();
            (-(t / self.sigma).powi(2)).exp()
        };
        let values: Vec<f64> = self.u.iter().map(value).collect();
        let whole = values.iter().sum::<f64>() * self.step[1];
        values.iter().map(|value| value * reflected / whole).collect()
    }
}

/// Adds a sum to the bins between two places, in parts of their overlap with it.
fn spread(bins: &mut [f64], from: f64, to: f64, sum: f64) {
    let first = from.floor().max(0.0) as usize;
    for (bin, value) in bins.iter_mut().enumerate().skip(first) {
        let overlap = (bin as f64 + 1.0).min(to) - (bin as f64).max(from);
        if overlap <= 0.0 {
            break;
        }
        *value += sum * overlap / (to - from);
    }
}

/// Covariances of the intensities of single instances, less the mean of all.
pub(super) struct Correlations {
    /// ω_y of the mirror.
    mirror_y: f64,
    /// The mirror's rows of segments, with what lies beside them along y; the 2.5D far fields over ω_x.
    patterns: Vec<[Pattern; 2]>,
    steps: [f64; 2],
}

/// Intensities `[row][column]`.
#[derive(Default, Clone)]
struct Pattern {
    columns: usize,
    values: Vec<f64>,
}

/// How far on either side of the mirror's rows tell the covariance along y.
const BESIDE: f64 = 0.12;

impl Correlations {
    pub(super) fn new(theta_i: f64) -> Self {
        Self { mirror_y: -theta_i.sin(), patterns: Vec::new(), steps: [0.0; 2] }
    }

    pub(super) fn add(&mut self, far: &Hemisphere, intensity: &[f64], flat: &[f64], turn: f64) {
        let columns = far.columns();
        let from_mirror = |row: &usize| (far.omega_y[*row] - self.mirror_y).abs();
        let rows = 0..far.omega_y.len();
        let centre = rows.min_by(|a, b| from_mirror(a).total_cmp(&from_mirror(b))).unwrap_or_default();
        let beside = (BESIDE / far.step[1]) as usize;
        let rows = centre.saturating_sub(beside)..(centre + beside + 1).min(far.omega_y.len());
        let values = intensity[rows.start * columns..rows.end * columns].to_vec();
        // The 2.5D far field at the same ω_x.
        let cosine = (1.0 - far.omega_y[centre].powi(2)).sqrt();
        let at = |column: usize| {
            let sine = far.omega_x(column) / cosine;
            if sine.abs() < 1.0 { between(flat, sine.asin() + turn) } else { 0.0 }
        };
        let flat = Pattern { columns, values: (0..columns).map(at).collect() };
        self.patterns.push([flat, Pattern { columns, values }]);
        self.steps = far.step;
    }

    /// As [`Found::correlation`].
    fn lags(&self) -> [f64; 3] {
        let across = |which: usize| self.lag(which, true) * self.steps[0];
        [across(0), across(1), self.lag(1, false) * self.steps[1]]
    }

    /// The lag, in steps, at which the covariance along rows or columns has fallen to 1/e.
    fn lag(&self, which: usize, is_across: bool) -> f64 {
        let Some(first) = self.patterns.first() else { return 0.0 };
        let (columns, length) = (first[which].columns, first[which].values.len());
        let count = self.patterns.len() as f64;
        let mean: Vec<f64> = (0..length)
            .map(|i| {
                self.patterns.iter().map(|p| p[which].values.get(i).unwrap_or(&0.0)).sum::<f64>() / count
            })
            .collect();
        let rows = length / columns;
        let covariance = |lag: usize| -> f64 {
            let mut sum = 0.0;
            for pattern in &self.patterns {
                let off = |row: usize, column: usize| {
                    let at = row * columns + column;
                    pattern[which].values[at] - mean[at]
                };
                let [last_row, last_column] =
                    if is_across { [rows, columns - lag] } else { [rows - lag, columns] };
                for row in 0..last_row {
                    for column in 0..last_column {
                        let other = if is_across { off(row, column + lag) } else { off(row + lag, column) };
                        sum += off(row, column) * other;
                    }
                }
            }
            sum
        };
        let whole = covariance(0);
        let most = if is_across { columns / 2 } else { rows / 2 };
        let mut last = 1.0;
        for lag in 1..most {
            let now = covariance(lag) / whole.max(f64::MIN_POSITIVE);
            let target = (-1.0_f64).exp();
            if now < target {
                return (lag - 1) as f64 + (last - target) / (last - now);
            }
            last = now;
        }
        most as f64
    }
}

impl Comparison {
    /// ΔE00 of the colours of all that is reflected: 2.5D against segments.
    #[must_use]
    pub fn delta_e(&self, direction: usize) -> f64 {
        let of = |of: fn(&Found) -> f64| self.found[direction].iter().map(of).collect::<Vec<_>>();
        self.difference(&of(|f| f.flat.reflected), &of(|f| f.segments.reflected))
    }

    /// ΔE00 of two reflected fractions at the wavelengths.
    pub(super) fn difference(&self, one: &[f64], other: &[f64]) -> f64 {
        let wavelengths = &self.plan.wavelengths;
        let weights = Observer::under(Illuminant::D65).weights(wavelengths);
        let white = weights.xyz(&vec![1.0; wavelengths.len()]);
        let [one, other] = [one, other].map(|reflected| lab(weights.xyz(reflected), white));
        delta_e_2000(one, other)
    }

    /// Everything but the pictures.
    #[must_use]
    pub fn numbers(&self) -> Value {
        let moments = |m: &Moments| {
            json!({
                "reflected": m.reflected,
                "across_mean": m.across[0], "across_deviation": m.across[1],
                "along_mean": m.along[0], "along_deviation": m.along[1],
            })
        };
        let found = |f: &Found| {
            json!({
                "wavelength_nm": f.wavelength_nm,
                "two_and_a_half_d": moments(&f.flat),
                "three_d": moments(&f.segments),
                "power_error": f.flat.reflected / f.segments.reflected - 1.0,
                "sigma_window": f.sigma.window,
                "sigma_second_moment": f.sigma.second_moment,
                "beyond_window": f.sigma.beyond,
                "correlation_across_two_and_a_half_d": f.correlation[0],
                "correlation_across_three_d": f.correlation[1],
                "correlation_along_three_d": f.correlation[2],
                "with_halo": self.with_halo(f).map(|with| json!({
                    "reflected": with.reflected,
                    "power_error": with.reflected / f.segments.reflected - 1.0,
                    "beyond_window": with.beyond,
                })),
            })
        };
        let direction = |(index, all): (usize, &Vec<Found>)| {
            let [theta, phi] = self.plan.direction_deg(index);
            json!({
                "theta_deg": theta, "phi_deg": phi,
                "delta_e_2000": self.delta_e(index),
                "delta_e_2000_with_halo": self.delta_e_with_halo(index),
                "wavelengths": all.iter().map(found).collect::<Vec<_>>(),
            })
        };
        json!({
            "structure": self.plan.structure.name(),
            "instances": self.plan.instances,
            "width_um": self.plan.structure.width_um(),
            "length_um": self.plan.length_um,
            "roughness_um": self.plan.roughness.amplitude_um,
            "correlation_um": self.plan.roughness.correlation_um,
            "tilt_deg": self.plan.tilt.to_degrees(),
            "brdf_sigma": self.sigma,
            "two_and_a_half_d_seconds": self.seconds[0],
            "three_d_seconds": self.seconds[1],
            "directions": self.found.iter().enumerate().map(direction).collect::<Vec<_>>(),
        })
    }

    /// A table for people: means over the wavelengths.
    #[must_use]
    pub fn table(&self) -> String {
        let plan = &self.plan;
        let mut text = format!(
            "{}, {} segments of {} µm, {} wavelengths\n{:>12}  {:>8}  {:>8}  {:>7}  {:>8}  {:>8}  {:>8}  {:>8}  {:>6}\n",
            plan.structure.name(),
            plan.instances,
            plan.length_um,
            plan.wavelengths.len(),
            "θ_i, φ_i (°)",
            "2.5D",
            "3D",
            "error",
            "x width",
            "of 3D",
            "σ",
            "beyond",
            "ΔE00"
        );
        for (index, all) in self.found.iter().enumerate() {
            let mean = |of: &dyn Fn(&Found) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
            let [flat, segments] = [mean(&|f| f.flat.reflected), mean(&|f| f.segments.reflected)];
            let [theta, phi] = plan.direction_deg(index);
            text += &format!(
                "{:>12}  {flat:>8.4}  {segments:>8.4}  {:>+5.1} %  {:>8.4}  {:>8.4}  {:>8.4}  {:>6.1} %  {:>6.1}\n",
                format!("{theta:.0}, {phi:.0}"),
                1e2 * (flat / segments - 1.0),
                mean(&|f| f.flat.across[1]),
                mean(&|f| f.segments.across[1]),
                mean(&|f| f.sigma.second_moment),
                1e2 * mean(&|f| f.sigma.beyond),
                self.delta_e(index)
            );
            text += &self.halo_line(index).unwrap_or_default();
        }
        let [flat, segments] = self.seconds;
        text + &format!("the BRDF's σ is {}; 2.5D took {flat:.1} s, 3D {segments:.1} s", self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field that is a normal distribution along y has the σ that it was made with, and its window is taken off.
    #[test]
    fn a_known_spread_is_measured() {
        let (k, window_um, theta) = (2.0 * std::f64::consts::PI / 0.5, 8.0, 0.0_f64);
        let sigma: f64 = 0.03;
        // exp(−u²/(4σ²)) of the barbule by exp(−(k w u)²/2) of the window: their convolution.
        let variance = 2.0 * sigma * sigma + (k * window_um).powi(-2);
        let far = Hemisphere {
            step: [0.05, 0.002],
            reach: 2,
            omega_y: (-150..=150).map(|row| 0.002 * f64::from(row)).collect(),
            amplitudes: Default::default(),
            incident_um2: 1.0,
        };
        let along = |y: f64| (-y * y / (2.0 * variance)).exp();
        let intensity: Vec<f64> =
            far.omega_y.iter().flat_map(|&y| [0.0, 0.5, 1.0, 0.5, 0.0].map(|x| x * along(y))).collect();
        let flat = [0.1; 180];
        let mut tally = Tally::new(&far, theta, k, 0.04);
        tally.add(&far, &intensity, &flat, 0.0);
        let mut correlations = Correlations::new(theta);
        correlations.add(&far, &intensity, &flat, 0.0);
        let found = tally.found(500.0, [0.0, 0.0], [5.0, window_um], &correlations);
        assert!((found.sigma.second_moment / sigma - 1.0).abs() < 0.01, "{:?}", found.sigma);
        assert!((found.sigma.window * k * window_um * 2f64.sqrt() - 1.0).abs() < 1e-12);
        assert!(found.segments.across[0].abs() < 1e-12 && found.segments.along[0].abs() < 1e-12);
        // The marginals hold all of the light.
        let total =
            |rows: &[[f64; 3]], side: usize, step: f64| rows.iter().map(|row| row[side]).sum::<f64>() * step;
        for (sum, expected) in [
            (total(&found.over_x, 2, 0.05), found.segments.reflected),
            (total(&found.over_y, 2, 0.002), found.segments.reflected),
            (total(&found.over_y, 1, 0.002), found.flat.reflected),
        ] {
            assert!((sum / expected - 1.0).abs() < 1e-9, "{sum} {expected}");
        }
    }

    /// An intensity that is the same at all azimuths has 1/cosφ of it per unit of ω_x, without a comb of the grid.
    #[test]
    fn marginals_are_as_smooth_as_what_they_are_of() {
        let far = Hemisphere {
            step: [0.0173, 0.5],
            reach: 57,
            omega_y: vec![-0.5, 0.0, 0.5],
            amplitudes: Default::default(),
            incident_um2: 1.0,
        };
        let intensity = vec![1.0; 3 * far.columns()];
        let mut tally = Tally::new(&far, 0.0, 12.0, 0.04);
        tally.add(&far, &intensity, &[0.25; 1440], 0.03);
        let mut correlations = Correlations::new(0.0);
        correlations.add(&far, &intensity, &[0.25; 1440], 0.03);
        let found = tally.found(500.0, [0.0, 0.0], [5.0, 5.0], &correlations);
        for [x, flat, _] in found.over_x.iter().filter(|row| row[0].abs() < 0.8) {
            // A column's mean: the middle's value and h²/24 of the second derivative; 2.4e-5 is reached at the edge.
            let squared = 1.0 - x * x;
            let bend = (1.0 + 2.0 * x * x) / (squared * squared) * 0.0173 * 0.0173 / 24.0;
            let expected = 0.25 / squared.sqrt() * (1.0 + bend);
            assert!((flat / expected - 1.0).abs() < 4e-5, "{x}: {flat} {expected}");
        }
    }

    #[test]
    fn speckles_as_wide_as_three_steps_are_found_so() {
        let columns = 400;
        let mut correlations = Correlations::new(0.0);
        let far = Hemisphere {
            step: [0.005, 0.5],
            reach: 199,
            omega_y: vec![-0.5, 0.0, 0.5],
            amplitudes: Default::default(),
            incident_um2: 1.0,
        };
        let mut state = 1_u64;
        for _ in 0..60 {
            let white: Vec<f64> = (0..columns + 20)
                .map(|_| {
                    state = crate::math::rng::split_mix(state);
                    crate::math::rng::unit_of(state) - 0.5
                })
                .collect();
            // Smoothed by exp(−i²/(2·3²)): a correlation of exp(−lag²/(4·3²)), 1/e at 6.
            let smooth = |at: usize| -> f64 {
                (0..20).map(|i| white[at + i] * (-(i as f64 - 9.5).powi(2) / 18.0).exp()).sum()
            };
            let row: Vec<f64> = (0..far.columns()).map(smooth).collect();
            correlations.add(&far, &[row.clone(), row.clone(), row].concat(), &[1.0; 180], 0.0);
        }
        let lags = correlations.lags();
        assert!((lags[1] / 0.005 - 6.0).abs() < 0.5, "{lags:?}");
    }
}
