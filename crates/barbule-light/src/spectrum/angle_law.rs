//! How a peak moves with the angle: the law of a film or multilayer, and the line of Osorio & Ham.

use serde::Serialize;

use crate::math::student::interval_95;
use crate::{Error, Result};

/// The fewest angles that a law is fitted to: one more than it has parameters.
pub const FEWEST_ANGLES: usize = 3;

/// The least range of angles, rad: below half a degree nothing is known of a slope.
const LEAST_RANGE: f64 = 0.0087;

/// A value and its 95 % confidence interval (Student's t on residuals, to first order in the parameters).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end; none where it has no bound.
    pub high: Option<f64>,
}

/// λ = a − b E with the angle E between light and viewer (Osorio & Ham 2002, *J. exp. Biol.* 205, 2017).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Line {
    /// a, nm.
    pub a_nm: Interval,
    /// b, nm per degree of E.
    pub b_nm_per_deg: Interval,
    /// Root mean square of the residuals, nm.
    pub rmse_nm: f64,
}

/// λ(θ) = λ₀ √(1 − sin²θ/n²), fitted by least squares in λ.
///
/// θ is the angle at which the layers are lit, n the index outside of which light of θ would have the same period: of one film its own,
/// of a multilayer an average of its layers. At the normal λ₀ is 2nd over a whole or half order.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AngleLaw {
    /// How many angles it is fitted to.
    pub angles: usize,
    /// λ₀, nm.
    pub normal_nm: Interval,
    /// n; none where peaks do not move to the blue.
    pub index: Option<Interval>,
    /// Root mean square of the residuals, nm.
    pub rmse_nm: f64,
    /// The straight line through the same peaks, E = 2θ.
    pub line: Line,
    /// 1/n², which is negative where peaks move to the red.
    #[serde(skip)]
    bend: f64,
}

impl AngleLaw {
    /// Fits peaks, each with the angle θ in rad at which the layers are lit and its wavelength in nm.
    ///
    /// # Errors
    /// Fewer than [`FEWEST_ANGLES`] peaks, angles that are alike or not within ±90°, or wavelengths that are not positive.
    pub fn fit(peaks: &[(f64, f64)]) -> Result<Self> {
        if peaks.len() < FEWEST_ANGLES {
            return Err(Error::input(format!(
                "a law of peaks against angle needs {FEWEST_ANGLES} angles with a peak, here are {}; give more angles",
                peaks.len()
            )));
        }
        if let Some((angle, nm)) = peaks
            .iter()
            .find(|(angle, nm)| !(angle.abs() < std::f64::consts::FRAC_PI_2 && *nm > 0.0 && nm.is_finite()))
        {
            return Err(Error::input(format!(
                "a peak at {nm} nm and {}° fits no law of peaks against angle; wavelengths are positive, angles within ±90°",
                angle.to_degrees()
            )));
        }
        let angles = peaks.iter().map(|(angle, _)| angle.abs());
        let (least, most) = angles.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
        if most - least < LEAST_RANGE {
            return Err(Error::input(format!(
                "all peaks are at about {:.2}° to the layers, from which no law of angles follows; give angles that differ",
                most.to_degrees()
            )));
        }
        let (normal, bend, covariance) = Self::curve(peaks);
        let freedom = peaks.len() - 2;
        let t = interval_95(freedom as f64);
        let residual = |&(angle, nm): &(f64, f64)| nm - wavelength(normal, bend, angle);
        let squares: f64 = peaks.iter().map(|peak| residual(peak).powi(2)).sum();
        let variance = squares / freedom as f64;
        let [normal_error, bend_error] = covariance.map(|c| t * (variance * c).sqrt());
        let index = |bend: f64| (bend > 0.0).then(|| bend.sqrt().recip());
        Ok(Self {
            angles: peaks.len(),
            normal_nm: around(normal, normal_error),
            index: index(bend).map(|value| Interval {
                value,
                low: (bend + bend_error).sqrt().recip(),
                high: index(bend - bend_error),
            }),
            rmse_nm: (squares / peaks.len() as f64).sqrt(),
            line: Line::fit(peaks),
            bend,
        })
    }

    /// λ₀, 1/n², and the diagonal of (JᵀJ)⁻¹, by Gauss–Newton steps from the line through (sin²θ, λ²), on which a perfect law lies.
    fn curve(peaks: &[(f64, f64)]) -> (f64, f64, [f64; 2]) {
        let squared = |&(angle, nm): &(f64, f64)| (angle.sin().powi(2), nm * nm);
        let (at_zero, slope, _) = line(&peaks.iter().map(squared).collect::<Vec<_>>());
        let steepest = peaks.iter().map(|(angle, _)| angle.sin().powi(2)).fold(0.0, f64::max).recip();
        // Below the steepest law, whose peak reaches 0 nm at the largest angle.
        let allowed = |bend: f64| bend.min(0.999 * steepest);
        let mut normal = at_zero.max(1.0).sqrt();
        let mut bend = allowed(-slope / (normal * normal));
        let mut covariance = [0.0; 2];
        for _ in 0..50 {
            let (mut jj, mut jr) = ([0.0; 3], [0.0; 2]);
            for &(angle, nm) in peaks {
                let s = angle.sin().powi(2);
                let root = (1.0 - bend * s).sqrt();
                let gradient = [root, -0.5 * normal * s / root];
                let residual = nm - normal * root;
                for (k, (a, b)) in [(0, 0), (0, 1), (1, 1)].into_iter().enumerate() {
                    jj[k] += gradient[a] * gradient[b];
                }
                (0..2).for_each(|k| jr[k] += gradient[k] * residual);
            }
            let determinant = jj[0] * jj[2] - jj[1] * jj[1];
            covariance = [jj[2] / determinant, jj[0] / determinant];
            let step = [
                (jj[2] * jr[0] - jj[1] * jr[1]) / determinant,
                (jj[0] * jr[1] - jj[1] * jr[0]) / determinant,
            ];
            normal += step[0];
            bend = allowed(bend + step[1]);
            if step[0].abs() < 1e-10 * normal && step[1].abs() < 1e-12 {
                break;
            }
        }
        (normal, bend, covariance)
    }

    /// The law's wavelength at an angle θ in rad, nm.
    #[must_use]
    pub fn wavelength_nm(&self, angle: f64) -> f64 {
        wavelength(self.normal_nm.value, self.bend, angle)
    }

    /// The law for people, in one line.
    #[must_use]
    pub fn words(&self) -> String {
        let index = match self.index {
            None => "no index, since the peak does not move to the blue".into(),
            Some(Interval { value, low, high }) => format!(
                "n = {value:.3} ({low:.3} to {})",
                high.map_or_else(|| "∞".into(), |high| format!("{high:.3}"))
            ),
        };
        let wide = |one: &Interval, digits: usize| {
            let high = one.high.unwrap_or(f64::INFINITY);
            format!("{:.digits$} ({:.digits$} to {high:.digits$})", one.value, one.low)
        };
        format!(
            "λ(θ) = λ₀ √(1 − sin²θ/n²): λ₀ = {} nm, {index}, RMSE {:.1} nm of {} angles; λ = a − b E: a = {} nm, b = {} nm/°, RMSE {:.1} nm",
            wide(&self.normal_nm, 1),
            self.rmse_nm,
            self.angles,
            wide(&self.line.a_nm, 1),
            wide(&self.line.b_nm_per_deg, 3),
            self.line.rmse_nm
        )
    }
}

impl Line {
    fn fit(peaks: &[(f64, f64)]) -> Self {
        let points: Vec<(f64, f64)> =
            peaks.iter().map(|(angle, nm)| (2.0 * angle.abs().to_degrees(), *nm)).collect();
        let (a, slope, covariance) = line(&points);
        let squares: f64 = points.iter().map(|(e, nm)| (nm - a - slope * e).powi(2)).sum();
        let freedom = points.len() - 2;
        let t = interval_95(freedom as f64);
        let error = |c: f64| t * (squares / freedom as f64 * c).sqrt();
        Self {
            a_nm: around(a, error(covariance[0])),
            b_nm_per_deg: around(-slope, error(covariance[1])),
            rmse_nm: (squares / points.len() as f64).sqrt(),
        }
    }
}

fn wavelength(normal_nm: f64, bend: f64, angle: f64) -> f64 {
    normal_nm * (1.0 - bend * angle.sin().powi(2)).max(0.0).sqrt()
}

fn around(value: f64, error: f64) -> Interval {
    Interval { value, low: value - error, high: Some(value + error) }
}

/// The line of least squares: its value at zero, its slope, and the factors on the residual variance of both.
fn line(points: &[(f64, f64)]) -> (f64, f64, [f64; 2]) {
    let count = points.len() as f64;
    let mean = points.iter().map(|p| p.0).sum::<f64>() / count;
    let height = points.iter().map(|p| p.1).sum::<f64>() / count;
    let spread: f64 = points.iter().map(|p| (p.0 - mean).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - mean) * (p.1 - height)).sum::<f64>() / spread;
    (height - slope * mean, slope, [1.0 / count + mean * mean / spread, 1.0 / spread])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Stream;

    fn peaks_of(n: f64, normal_nm: f64, degrees: &[f64]) -> Vec<(f64, f64)> {
        let of = |deg: &f64| {
            let angle = deg.to_radians();
            (angle, normal_nm * (1.0 - (angle.sin() / n).powi(2)).sqrt())
        };
        degrees.iter().map(of).collect()
    }

    #[test]
    fn a_perfect_law_is_found_again() {
        let law = AngleLaw::fit(&peaks_of(1.53, 640.0, &[0.0, 20.0, 40.0, 60.0])).unwrap();
        let index = law.index.unwrap();
        assert!((law.normal_nm.value - 640.0).abs() < 1e-8 && (index.value - 1.53).abs() < 1e-9, "{law:?}");
        assert!(law.rmse_nm < 1e-8 && law.line.rmse_nm > 1.0 && law.line.b_nm_per_deg.value > 0.5);
        assert!(
            (law.wavelength_nm(0.5) - 640.0 * (1.0 - (0.5_f64.sin() / 1.53).powi(2)).sqrt()).abs() < 1e-8
        );
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let mut stream = Stream::new(3, &[]);
        let (trials, mut held) = (2000, [0; 4]);
        for _ in 0..trials {
            let mut peaks = peaks_of(1.5, 600.0, &[0.0, 15.0, 30.0, 45.0, 60.0]);
            peaks.iter_mut().for_each(|peak| peak.1 += 2.0 * stream.normal());
            let law = AngleLaw::fit(&peaks).unwrap();
            let mut line: Vec<(f64, f64)> =
                [0.0_f64, 10.0, 20.0, 30.0].iter().map(|e| (e.to_radians() / 2.0, 700.0 - 1.2 * e)).collect();
            line.iter_mut().for_each(|peak| peak.1 += 2.0 * stream.normal());
            let line = AngleLaw::fit(&line).unwrap().line;
            let inside =
                |one: Interval, truth: f64| one.low <= truth && one.high.is_none_or(|high| truth <= high);
            for (count, (one, truth)) in held.iter_mut().zip([
                (law.normal_nm, 600.0),
                (law.index.unwrap(), 1.5),
                (line.a_nm, 700.0),
                (line.b_nm_per_deg, 1.2),
            ]) {
                *count += usize::from(inside(one, truth));
            }
        }
        // 95 % ± 3 standard deviations of 2000 trials, 1.5 %.
        assert!(
            held.iter().all(|count| (0.935..0.965).contains(&(*count as f64 / f64::from(trials)))),
            "{held:?}"
        );
    }

    #[test]
    fn peaks_that_move_to_the_red_have_no_index_and_what_is_no_series_is_refused() {
        let red = [(0.0, 500.0), (0.3, 510.0), (0.6, 530.0)];
        let law = AngleLaw::fit(&red).unwrap();
        assert!(law.index.is_none() && law.words().contains("does not move to the blue"), "{}", law.words());
        for (bad, part) in [
            (&[(0.0, 500.0), (0.5, 490.0)][..], "needs 3 angles"),
            (&[(0.1, 500.0), (-0.1, 490.0), (0.1, 495.0)], "all peaks are at about 5.73°"),
            (&[(0.1, 500.0), (0.2, f64::NAN), (0.3, 495.0)], "fits no law"),
            (&[(0.1, 500.0), (1.6, 480.0), (0.3, 495.0)], "fits no law"),
        ] {
            let error = AngleLaw::fit(bad).unwrap_err();
            assert!(error.is_input() && error.to_string().contains(part), "{error}");
        }
    }
}
