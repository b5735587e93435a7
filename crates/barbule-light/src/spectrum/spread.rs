//! How individuals differ in what their spectra look like.

use crate::math::student::interval_95;

use super::Spectrum;
use super::look::Look;
use super::peaks::{Origin, Peak};

/// Mean and standard deviation of a number over individuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// How many individuals have such a number.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation.
    pub std: f64,
}

impl Moments {
    /// Of at least two values; none of fewer.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        if values.len() < 2 {
            return None;
        }
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        Some(Self { count: values.len(), mean, std: (squares / (count - 1.0)).sqrt() })
    }

    /// The squared standard error of the mean.
    fn error_squared(&self) -> f64 {
        self.std * self.std / self.count as f64
    }

    /// Half the 95 % interval of the mean.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        interval_95(self.count as f64 - 1.0) * self.error_squared().sqrt()
    }

    /// Half the 95 % interval of the difference of two means whose variances may differ (Welch 1947); none where neither varies.
    #[must_use]
    pub fn difference_half_width(&self, other: &Self) -> Option<f64> {
        let [a, b] = [self, other].map(Self::error_squared);
        let degrees =
            (a + b) * (a + b) / (a * a / (self.count as f64 - 1.0) + b * b / (other.count as f64 - 1.0));
        degrees.is_finite().then(|| interval_95(degrees) * (a + b).sqrt())
    }
}

/// How individuals differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// How many there are.
    pub count: usize,
    /// Wavelength of the peak, nm.
    pub peak_nm: Option<Moments>,
    /// Full width at half maximum, nm.
    pub half_width_nm: Option<Moments>,
    /// Reflectance at the peak.
    pub peak_reflectance: Option<Moments>,
    /// Mean reflectance over the wavelengths.
    pub mean_reflectance: Option<Moments>,
}

/// A peak further from the mean curve's, in ln λ, is of another order.
pub const SAME_PEAK: f64 = 0.15;

impl Spread {
    /// Over individuals, of each the peak that is nearest to `peak`, the mean curve's; none of fewer than two.
    #[must_use]
    pub fn of(individuals: &[Spectrum], origin: Origin, peak: Option<Peak>) -> Option<Self> {
        if individuals.len() < 2 {
            return None;
        }
        let looks: Vec<Look> = individuals.iter().map(|one| Look::with_peak_in(one, origin, None)).collect();
        let peaks: Vec<Peak> = peak.map_or_else(Vec::new, |mean| {
            let far = |peak: &Peak| libm::log(peak.nm / mean.nm).abs();
            let nearest = |look: &Look| {
                look.peaks
                    .iter()
                    .copied()
                    .filter(|peak| far(peak) < SAME_PEAK)
                    .min_by(|a, b| far(a).total_cmp(&far(b)))
            };
            looks.iter().filter_map(nearest).collect()
        });
        let of = |value: fn(&Peak) -> Option<f64>| {
            Moments::of(&peaks.iter().filter_map(value).collect::<Vec<_>>())
        };
        Some(Self {
            count: individuals.len(),
            peak_nm: of(|peak| Some(peak.nm)),
            half_width_nm: of(|peak| peak.half.nm()),
            peak_reflectance: of(|peak| Some(peak.reflectance)),
            mean_reflectance: Moments::of(
                &looks.iter().map(|look| look.mean_reflectance).collect::<Vec<_>>(),
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Wavelengths;
    use super::*;

    #[test]
    fn individuals_have_the_spread_that_was_put_in() {
        let nm: Vec<f64> = (300..=700).step_by(2).map(f64::from).collect();
        let bell = |at: f64| {
            // A second order far away must not be taken.
            let value = |x: &f64| {
                0.05 + 0.2 * (-0.5 * ((x - at) / 30.0).powi(2)).exp()
                    + 0.3 * (-0.5 * ((x - 0.66 * at) / 15.0).powi(2)).exp()
            };
            Spectrum::new(Wavelengths::new(nm.clone()).unwrap(), nm.iter().map(value).collect()).unwrap()
        };
        let all = [bell(530.0), bell(540.0), bell(550.0)];
        let peak = Look::of(&all[1]).peaks.iter().copied().find(|p| p.nm > 500.0).unwrap();
        let spread = Spread::of(&all, Origin::Computed, Some(peak)).unwrap();
        let moments = spread.peak_nm.unwrap();
        assert!((moments.mean - 540.0).abs() < 0.2 && (moments.std - 10.0).abs() < 0.2, "{moments:?}");
        // t of 2 degrees of freedom is 4.303.
        assert!(
            (moments.half_width() - 4.303 * 10.0 / 3.0_f64.sqrt()).abs() < 0.6,
            "{}",
            moments.half_width()
        );
        assert_eq!(Spread::of(&all[..1], Origin::Computed, Some(peak)), None);
        assert_eq!(Spread::of(&all, Origin::Computed, None).unwrap().peak_nm, None);
    }

    #[test]
    fn differences_have_welchs_interval() {
        // Welch's textbook case: n 10 and 20, s 2 and 3: 27.6 degrees of freedom.
        let (a, b) = (Moments { count: 10, mean: 0.0, std: 2.0 }, Moments { count: 20, mean: 1.0, std: 3.0 });
        let error = (0.4_f64 + 0.45).sqrt();
        let degrees = 0.85_f64.powi(2) / (0.16 / 9.0 + 0.2025 / 19.0);
        let half = a.difference_half_width(&b).unwrap();
        assert!((half - interval_95(degrees) * error).abs() < 1e-12 && (half - 1.893).abs() < 0.01, "{half}");
    }
}
