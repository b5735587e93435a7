//! A simulated reflectance held against a measured one, in numbers.

use serde::ser::{Serialize, Serializer};

use super::Spectrum;
use super::colour::Observer;
use super::difference::{delta_e_76, delta_e_2000, lab};
use super::fields::{Field, Fields};
use super::look::Look;
use crate::{Error, Result};

/// How far two reflectances agree over the wavelengths that both have.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The common range, nm.
    pub range_nm: [f64; 2],
    /// How many wavelengths of the simulation lie in it; differences are taken there.
    pub points: usize,
    /// The simulated curve over the common range.
    pub simulated: Look,
    /// The measured curve over the common range.
    pub measured: Look,
    /// Root mean square of simulated − measured.
    pub rmse: f64,
    /// What the simulation must be multiplied by for the least squares; none where it is zero throughout.
    pub scale: Option<f64>,
    /// Root mean square of scale · simulated − measured.
    pub rmse_scaled: Option<f64>,
    /// CIEDE2000 between the colours under D65 at their true luminance over the common range; none where that
    /// range is too short for a colour.
    pub delta_e_2000: Option<f64>,
    /// ΔE*ab of 1976 between the same colours.
    pub delta_e_76: Option<f64>,
}

impl Comparison {
    /// Compares over the common range, at the wavelengths of the simulation; the measurement is linear between its
    /// samples.
    ///
    /// # Errors
    /// Fewer than two wavelengths of the simulation lie within those of the measurement.
    pub fn of(simulated: &Spectrum, measured: &Spectrum) -> Result<Self> {
        let (from, to) = measured.wavelengths().range_nm();
        let pairs: Vec<[f64; 2]> = simulated
            .wavelengths()
            .iter()
            .zip(simulated.values())
            .filter_map(|(&nm, &value)| measured.value(nm).map(|m| [value, m]))
            .collect();
        let both = measured
            .within(simulated.wavelengths().range_nm().into())
            .zip(simulated.within([from, to]))
            .filter(|_| pairs.len() > 1);
        let Some((measured, simulated)) = both else {
            let (first, last) = simulated.wavelengths().range_nm();
            return Err(Error::input(format!(
                "the measurement from {from} to {to} nm and the simulation from {first} to {last} nm have {} wavelengths in common; give `wavelengths` that lie within the measurement",
                pairs.len()
            ))
            .naming(&["wavelengths"]));
        };
        let rms = |scale: f64| {
            let squares: f64 = pairs.iter().map(|[s, m]| (scale * s - m).powi(2)).sum();
            (squares / pairs.len() as f64).sqrt()
        };
        let products = |a: usize, b: usize| pairs.iter().map(|pair| pair[a] * pair[b]).sum::<f64>();
        let scale = Some(products(0, 1) / products(0, 0)).filter(|scale| scale.is_finite());
        let looks = [&simulated, &measured].map(Look::of);
        let labs = looks[0].colour.zip(looks[1].colour).map(|(s, m)| {
            let white = white();
            (lab(s.xyz, white), lab(m.xyz, white))
        });
        let (first, last) = simulated.wavelengths().range_nm();
        let [simulated, measured] = looks;
        Ok(Self {
            range_nm: [first, last],
            points: pairs.len(),
            simulated,
            measured,
            rmse: rms(1.0),
            scale,
            rmse_scaled: scale.map(rms),
            delta_e_2000: labs.map(|(s, m)| delta_e_2000(s, m)),
            delta_e_76: labs.map(|(s, m)| delta_e_76(s, m)),
        })
    }

    /// Peak of the simulation − peak of the measurement, nm; none where either has no peak.
    #[must_use]
    pub fn peak_shift_nm(&self) -> Option<f64> {
        Some(self.simulated.peak?.nm - self.measured.peak?.nm)
    }

    /// Every number by its name, in the order of tables. `common_from_nm`, `common_to_nm`: the common range, to which
    /// all the others belong. `simulated_…` and `measured_…`: as the names of [`Look::fields`].
    #[must_use]
    pub fn fields(&self) -> Fields {
        let number = |value: Option<f64>| Field::number(value);
        let (s, m) = (&self.simulated, &self.measured);
        let (s_half, m_half) = (s.half_width, m.half_width);
        Fields(vec![
            ("common_from_nm", number(Some(self.range_nm[0]))),
            ("common_to_nm", number(Some(self.range_nm[1]))),
            ("points", Field::Count(self.points)),
            ("simulated_peak_nm", number(s.peak.map(|p| p.nm))),
            ("simulated_peak_reflectance", number(s.peak.map(|p| p.reflectance))),
            ("simulated_half_level", number(s_half.map(|h| h.level))),
            ("simulated_half_width_nm", number(s_half.map(|h| h.nm()))),
            ("measured_peak_nm", number(m.peak.map(|p| p.nm))),
            ("measured_peak_reflectance", number(m.peak.map(|p| p.reflectance))),
            ("measured_half_level", number(m_half.map(|h| h.level))),
            ("measured_half_width_nm", number(m_half.map(|h| h.nm()))),
            ("peak_shift_nm", number(self.peak_shift_nm())),
            ("rmse", number(Some(self.rmse))),
            ("scale", number(self.scale)),
            ("rmse_scaled", number(self.rmse_scaled)),
            ("delta_e_2000", number(self.delta_e_2000)),
            ("delta_e_76", number(self.delta_e_76)),
        ])
    }

    /// One line for people.
    #[must_use]
    pub fn words(&self) -> String {
        let [from, to] = self.range_nm;
        let mut parts = vec![format!("{} wavelengths from {from} to {to} nm", self.points)];
        parts.push(match (self.simulated.peak, self.measured.peak) {
            (Some(s), Some(m)) => {
                format!("peak {:.0} nm, measured {:.0} nm (shift {:+.0} nm)", s.nm, m.nm, s.nm - m.nm)
            }
            (None, Some(m)) => format!("no peak, measured {:.0} nm", m.nm),
            (Some(s), None) => format!("peak {:.0} nm, none measured", s.nm),
            (None, None) => "no peak in either".into(),
        });
        if let (Some(s), Some(m)) = (self.simulated.half_width, self.measured.half_width) {
            parts.push(format!(
                "half width {:.0} nm at {:.1} %, measured {:.0} nm at {:.1} %",
                s.nm(),
                100.0 * s.level,
                m.nm(),
                100.0 * m.level
            ));
        }
        parts.push(format!("RMSE {:.4}", self.rmse));
        if let (Some(scale), Some(rmse)) = (self.scale, self.rmse_scaled) {
            parts.push(format!("best scale {scale:.3} (RMSE {rmse:.4})"));
        }
        match (self.delta_e_2000, self.delta_e_76) {
            (Some(new), Some(old)) => parts.push(format!("ΔE00 {new:.1} (CIEDE2000), ΔE*ab {old:.1} (1976)")),
            _ => parts.push("no ΔE, since the common range is too short for a colour".into()),
        }
        parts.join(", ")
    }
}

impl Serialize for Comparison {
    /// The names and values of [`Comparison::fields`]; null where there is no such number.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.fields().serialize(serializer)
    }
}

/// X, Y, Z of a perfect white under D65.
fn white() -> [f64; 3] {
    let weights = Observer::default().weights(&super::Wavelengths::usual());
    weights.xyz(&[1.0; 50])
}

#[cfg(test)]
mod tests {
    use super::super::Wavelengths;
    use super::*;

    fn bell(nm: &[f64], at: f64, width: f64, height: f64) -> Spectrum {
        let value = |x: &f64| 0.04 + height * (-0.5 * ((x - at) / width).powi(2)).exp();
        Spectrum::new(Wavelengths::new(nm).unwrap(), nm.iter().map(value).collect()).unwrap()
    }

    fn steps(first: u32, last: u32, step: usize) -> Vec<f64> {
        (first..=last).step_by(step).map(f64::from).collect()
    }

    #[test]
    fn a_spectrum_agrees_with_itself_whatever_the_sampling() {
        let (fine, coarse) = (steps(300, 700, 1), steps(400, 694, 6));
        let found = Comparison::of(&bell(&coarse, 530.0, 40.0, 0.2), &bell(&fine, 530.0, 40.0, 0.2)).unwrap();
        assert_eq!((found.range_nm, found.points), ([400.0, 694.0], 50));
        assert!(found.rmse < 1e-12 && (found.scale.unwrap() - 1.0).abs() < 1e-12, "{found:?}");
        assert!(found.peak_shift_nm().unwrap().abs() < 0.1 && found.delta_e_2000.unwrap() < 0.2, "{found:?}");
    }

    #[test]
    fn shifts_scales_and_distances_are_those_that_were_put_in() {
        let nm = steps(380, 780, 4);
        let simulated = bell(&nm, 540.0, 30.0, 0.2);
        let half = simulated.values().iter().map(|v| 0.5 * v).collect();
        let measured = Spectrum::new(simulated.wavelengths().clone(), half).unwrap();
        let found = Comparison::of(&simulated, &measured).unwrap();
        let squares: f64 = simulated.values().iter().map(|v| 0.25 * v * v).sum();
        assert!((found.rmse - (squares / 101.0).sqrt()).abs() < 1e-12);
        assert!((found.scale.unwrap() - 0.5).abs() < 1e-12 && found.rmse_scaled.unwrap() < 1e-12);
        // Half the light at the same chromaticity: a* and b* shrink with L*.
        assert!(found.delta_e_2000.unwrap() > 5.0 && found.delta_e_76.unwrap() > 5.0);
        let moved = Comparison::of(&simulated, &bell(&nm, 520.0, 30.0, 0.2)).unwrap();
        assert!((moved.peak_shift_nm().unwrap() - 20.0).abs() < 0.1);
        assert!(moved.words().contains("(shift +20 nm)"), "{}", moved.words());
    }

    #[test]
    fn peaks_outside_the_common_range_are_not_compared() {
        let simulated = bell(&steps(400, 700, 4), 540.0, 30.0, 0.2);
        let nm = steps(300, 700, 2);
        let ultraviolet = bell(&nm, 350.0, 20.0, 0.5);
        let green = bell(&nm, 540.0, 30.0, 0.2);
        let both = ultraviolet.values().iter().zip(green.values()).map(|(a, b)| a + b);
        let measured = Spectrum::new(Wavelengths::new(nm.clone()).unwrap(), both.collect()).unwrap();
        assert!((Look::of(&measured).peak.unwrap().nm - 350.0).abs() < 1.0);
        assert!(Comparison::of(&simulated, &measured).unwrap().peak_shift_nm().unwrap().abs() < 1.0);
    }

    #[test]
    fn too_little_in_common_is_refused_and_short_ranges_have_no_colour() {
        let simulated = bell(&steps(400, 700, 4), 540.0, 30.0, 0.2);
        for far in [steps(300, 400, 5), steps(300, 390, 5), steps(750, 800, 5)] {
            let error = Comparison::of(&simulated, &bell(&far, 350.0, 20.0, 0.5)).unwrap_err();
            assert!(error.is_input() && error.to_string().contains("in common"), "{error}");
        }
        let short = Comparison::of(&simulated, &bell(&steps(500, 600, 5), 540.0, 30.0, 0.2)).unwrap();
        assert_eq!((short.delta_e_2000, short.points), (None, 26));
        assert!(short.words().contains("no ΔE"));
    }
}
