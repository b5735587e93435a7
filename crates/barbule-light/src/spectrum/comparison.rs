//! A simulated reflectance held against a measured one, in numbers.

use serde::ser::{Serialize, Serializer};

use super::Spectrum;
use super::colour::Observer;
use super::difference::{delta_e_76, delta_e_2000, lab};
use super::fields::{Field, Fields};
use super::look::Look;
use super::orders::{ANY_STRETCH, Correspondence, LEAST_CORRELATION, Lost, corresponding};
use super::peaks::{Origin, Peak};
use super::residual::Residual;
use super::spread::{Moments, Spread};
use crate::{Error, Result};

/// How far two reflectances agree over the wavelengths that both have.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The common range, nm.
    pub range_nm: [f64; 2],
    /// How many wavelengths of the simulation lie in it; differences are taken there.
    pub points: usize,
    /// The simulated curve over the common range; its peak is the one that corresponds to the measured one, if there is one.
    pub simulated: Look,
    /// The measured curve over the common range.
    pub measured: Look,
    /// Which simulated peak the measured one corresponds to; none where none is measured.
    pub correspondence: Option<Correspondence>,
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
    /// What the difference looks like; none where there is none, or too few wavelengths.
    pub residual: Option<Residual>,
    /// How individuals differ: the simulated ones, and the measured samples; of one there is no spread.
    pub spread: [Option<Spread>; 2],
}

impl Comparison {
    /// Compares over the common range, at the wavelengths of the simulation; the measurement is linear between its
    /// samples. The measured peak is the highest, within a range in nm if one is given, and the simulated one that which
    /// corresponds to it: where the stretch that makes the curves most alike puts it.
    ///
    /// # Errors
    /// Fewer than two wavelengths of the simulation lie within those of the measurement.
    pub fn of(simulated: &Spectrum, measured: &Spectrum, peak_range_nm: Option<[f64; 2]>) -> Result<Self> {
        let (from, to) = measured.wavelengths().range_nm();
        let pairs: Vec<[f64; 2]> = simulated
            .wavelengths()
            .iter()
            .zip(simulated.values())
            .filter_map(|(&nm, &value)| measured.value(nm).map(|m| [value, m]))
            .collect();
        let residual = Residual::of(simulated, measured);
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
        let both = [(&simulated, Origin::Computed), (&measured, Origin::Measured)];
        let mut looks = both.map(|(curve, origin)| Look::with_peak_in(curve, origin, peak_range_nm));
        let correspondence = looks[1]
            .peak
            .map(|peak| corresponding(&measured, peak.nm, &simulated, &looks[0].peaks, ANY_STRETCH));
        if let Some(peak) =
            correspondence.filter(|found| found.rival.is_none()).and_then(|found| found.peak.ok())
        {
            looks[0].peak = Some(peak);
        }
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
            correspondence,
            rmse: rms(1.0),
            scale,
            rmse_scaled: scale.map(rms),
            delta_e_2000: labs.map(|(s, m)| delta_e_2000(s, m)),
            delta_e_76: labs.map(|(s, m)| delta_e_76(s, m)),
            residual,
            spread: [None, None],
        })
    }

    /// The same with how the individuals of both differ, of whose means the comparison is: of each the peak that is nearest to the mean's.
    #[must_use]
    pub fn with_individuals(self, simulated: &[Spectrum], measured: &[Spectrum]) -> Self {
        let of = |curves: &[Spectrum], origin: Origin, look: &Look| {
            let within: Vec<Spectrum> =
                curves.iter().filter_map(|curve| curve.within(self.range_nm)).collect();
            Spread::of(&within, origin, look.peak)
        };
        let spread = [
            of(simulated, Origin::Computed, &self.simulated),
            of(measured, Origin::Measured, &self.measured),
        ];
        Self { spread, ..self }
    }

    /// The 95 % interval of the shift of the peak, nm, from how the individuals of both differ (Welch's t); none where one of the
    /// two has no spread.
    #[must_use]
    pub fn peak_shift_interval_nm(&self) -> Option<[f64; 2]> {
        let [simulated, measured] = [self.spread[0]?.peak_nm?, self.spread[1]?.peak_nm?];
        let shift = self.peak_shift_nm()?;
        let half = simulated.difference_half_width(&measured)?;
        Some([shift - half, shift + half])
    }

    /// The simulated peak that corresponds to the measured one, and that one.
    fn pair(&self) -> Option<[Peak; 2]> {
        let found = self.correspondence.filter(|found| found.rival.is_none())?;
        Some([found.peak.ok()?, self.measured.peak?])
    }

    /// The simulated peak that corresponds to the measured one − the measured peak, nm; none where either has no peak or
    /// none corresponds.
    #[must_use]
    pub fn peak_shift_nm(&self) -> Option<f64> {
        self.pair().map(|[simulated, measured]| simulated.nm - measured.nm)
    }

    /// Why there is no shift though both have a peak.
    fn no_shift(&self) -> Option<String> {
        let found = self.correspondence?;
        self.simulated.peak?;
        if let (Ok(peak), Some(rival)) = (found.peak, found.rival) {
            return Some(format!(
                "two stretches of wavelengths make the curves about as alike, and the measured peak corresponds to {:.0} or to {:.0} nm",
                peak.nm, rival.nm
            ));
        }
        Some(match found.peak.err()? {
            Lost::Outside(nm) => {
                format!("the measured peak corresponds to one near {nm:.0} nm, outside the common range")
            }
            Lost::Gone(nm) => format!("the measured peak corresponds to {nm:.0} nm, where none is simulated"),
            Lost::Unlike(Some(correlation)) => format!(
                "at no stretch of wavelengths up to 30 % are the curves alike: correlation {correlation:.2}, under {LEAST_CORRELATION}"
            ),
            Lost::Unlike(None) => "the curves have too little in common to say which peaks correspond".into(),
        })
    }

    /// Every number by its name, in the order of tables. `common_from_nm`, `common_to_nm`: the common range, to which
    /// all the others belong. `simulated_…` and `measured_…`: as the names of [`Look::fields`]. `stretch`: the factor on the
    /// wavelengths of the measurement that makes the curves most alike, `correlation`: how alike; `shift_note`: why there is no
    /// `peak_shift_nm`.
    #[must_use]
    pub fn fields(&self) -> Fields {
        let number = |value: Option<f64>| Field::number(value);
        let (s, m) = (&self.simulated, &self.measured);
        let (s_half, m_half) = (s.peak.map(|p| p.half), m.peak.map(|p| p.half));
        let stretch = self.correspondence.and_then(|found| found.stretch);
        let interval = self.peak_shift_interval_nm();
        let std = |whose: usize, what: fn(&Spread) -> Option<Moments>| {
            number(self.spread[whose].as_ref().and_then(what).map(|moments| moments.std))
        };
        let residual = self.residual.as_ref();
        let change = residual.map(|residual| residual.change);
        Fields(vec![
            ("common_from_nm", number(Some(self.range_nm[0]))),
            ("common_to_nm", number(Some(self.range_nm[1]))),
            ("points", Field::Count(self.points)),
            ("simulated_peak_nm", number(s.peak.map(|p| p.nm))),
            ("simulated_peak_reflectance", number(s.peak.map(|p| p.reflectance))),
            ("simulated_half_level", number(s_half.map(|h| h.level))),
            ("simulated_half_width_nm", number(s_half.and_then(|h| h.nm()))),
            ("measured_peak_nm", number(m.peak.map(|p| p.nm))),
            ("measured_peak_reflectance", number(m.peak.map(|p| p.reflectance))),
            ("measured_half_level", number(m_half.map(|h| h.level))),
            ("measured_half_width_nm", number(m_half.and_then(|h| h.nm()))),
            ("peak_shift_nm", number(self.peak_shift_nm())),
            ("peak_shift_low_nm", number(interval.map(|i| i[0]))),
            ("peak_shift_high_nm", number(interval.map(|i| i[1]))),
            ("simulated_individuals", Field::Count(self.spread[0].map_or(0, |s| s.count))),
            ("simulated_peak_std_nm", std(0, |s| s.peak_nm)),
            ("simulated_half_width_std_nm", std(0, |s| s.half_width_nm)),
            ("simulated_peak_reflectance_std", std(0, |s| s.peak_reflectance)),
            ("measured_individuals", Field::Count(self.spread[1].map_or(0, |s| s.count))),
            ("measured_peak_std_nm", std(1, |s| s.peak_nm)),
            ("measured_half_width_std_nm", std(1, |s| s.half_width_nm)),
            ("measured_peak_reflectance_std", std(1, |s| s.peak_reflectance)),
            ("stretch", number(stretch.map(|stretch| stretch.factor))),
            ("correlation", number(stretch.map(|stretch| stretch.correlation))),
            ("rmse", number(Some(self.rmse))),
            ("scale", number(self.scale)),
            ("rmse_scaled", number(self.rmse_scaled)),
            ("delta_e_2000", number(self.delta_e_2000)),
            ("delta_e_76", number(self.delta_e_76)),
            ("cause", Field::Word(residual.and_then(Residual::cause).map(str::to_owned))),
            ("explained", number(residual.map(|r| r.explained))),
            ("cause_shift", number(change.map(|c| c.shift))),
            ("cause_level", number(change.map(|c| c.level))),
            ("cause_broadening_nm", number(change.map(|c| c.broadening_nm))),
            ("cause_offset", number(change.map(|c| c.offset))),
            ("cause_note", Field::Note(residual.map(Residual::words))),
            ("shift_note", Field::Note(self.no_shift())),
        ])
    }

    /// One line for people.
    #[must_use]
    pub fn words(&self) -> String {
        let [from, to] = self.range_nm;
        let mut parts = vec![format!("{} wavelengths from {from} to {to} nm", self.points)];
        parts.push(match (self.simulated.peak, self.measured.peak) {
            (Some(s), Some(m)) => {
                let shift = match self.no_shift() {
                    Some(why) => format!("no shift, since {why}"),
                    None => match self.peak_shift_interval_nm() {
                        Some([low, high]) => {
                            format!("shift {:+.0} nm, 95 %: {low:+.0} to {high:+.0}", s.nm - m.nm)
                        }
                        None => format!("shift {:+.0} nm", s.nm - m.nm),
                    },
                };
                let higher = self.simulated.highest.filter(|_| self.simulated.highest_is_another());
                let other = higher.map_or_else(String::new, |higher| {
                    format!(" (its highest, {:.0} nm, is of another order)", higher.nm)
                });
                format!("peak {:.0} nm{other}, measured {:.0} nm ({shift})", s.nm, m.nm)
            }
            (None, Some(m)) => format!("no peak, measured {:.0} nm", m.nm),
            (Some(s), None) => format!("peak {:.0} nm, none measured", s.nm),
            (None, None) => "no peak in either".into(),
        });
        let halves = [self.simulated.peak, self.measured.peak].map(|peak| peak.map(|peak| peak.half));
        if let [Some(s), Some(m)] = halves
            && let (Some(s_nm), Some(m_nm)) = (s.nm(), m.nm())
        {
            parts.push(format!(
                "half width {s_nm:.0} nm at {:.1} %, measured {m_nm:.0} nm at {:.1} %",
                100.0 * s.level,
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
        parts.extend(self.residual.as_ref().map(|residual| format!("hint: {}", residual.words())));
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
        let found =
            Comparison::of(&bell(&coarse, 530.0, 40.0, 0.2), &bell(&fine, 530.0, 40.0, 0.2), None).unwrap();
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
        let found = Comparison::of(&simulated, &measured, None).unwrap();
        let squares: f64 = simulated.values().iter().map(|v| 0.25 * v * v).sum();
        assert!((found.rmse - (squares / 101.0).sqrt()).abs() < 1e-12);
        assert!((found.scale.unwrap() - 0.5).abs() < 1e-12 && found.rmse_scaled.unwrap() < 1e-12);
        // Half the light at the same chromaticity: a* and b* shrink with L*.
        assert!(found.delta_e_2000.unwrap() > 5.0 && found.delta_e_76.unwrap() > 5.0);
        let moved = Comparison::of(&simulated, &bell(&nm, 520.0, 30.0, 0.2), None).unwrap();
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
        assert!((Look::with_peak_in(&measured, Origin::Measured, None).peak.unwrap().nm - 350.0).abs() < 1.0);
        assert!(Comparison::of(&simulated, &measured, None).unwrap().peak_shift_nm().unwrap().abs() < 1.0);
    }

    /// Violet and green orders: one is higher in the model and the other in the feather, which is 2 % thicker.
    #[test]
    fn the_shift_is_that_of_the_peak_that_corresponds() {
        let nm = steps(300, 700, 4);
        let two = |factor: f64, violet: f64, green: f64| {
            let (a, b) = (bell(&nm, 345.0 * factor, 18.0, violet), bell(&nm, 520.0 * factor, 35.0, green));
            let sum = a.values().iter().zip(b.values()).map(|(a, b)| a + b).collect();
            Spectrum::new(a.wavelengths().clone(), sum).unwrap()
        };
        let (model, feather) = (two(1.0, 0.21, 0.2), two(1.02, 0.2, 0.21));
        let found = Comparison::of(&model, &feather, None).unwrap();
        assert!((found.peak_shift_nm().unwrap() + 10.4).abs() < 1.0, "{found:?}");
        assert!(
            (found.simulated.peak.unwrap().nm - 520.0).abs() < 1.0 && found.simulated.highest_is_another()
        );
        let words = found.words();
        assert!(
            words.contains(
                "peak 520 nm (its highest, 345 nm, is of another order), measured 530 nm (shift -10 nm)"
            ),
            "{words}"
        );
        let stretch = found.correspondence.unwrap().stretch.unwrap();
        assert!((stretch.factor * 1.02 - 1.0).abs() < 0.005 && stretch.correlation > 0.98, "{stretch:?}");
        let violet = Comparison::of(&model, &feather, Some([300.0, 400.0])).unwrap();
        assert!((violet.peak_shift_nm().unwrap() + 6.9).abs() < 1.0, "{violet:?}");
    }

    #[test]
    fn no_shift_is_claimed_between_curves_that_are_not_alike_or_a_peak_that_is_not_there() {
        let nm = steps(300, 700, 4);
        let (violet, red) = (bell(&nm, 330.0, 12.0, 0.2), bell(&nm, 650.0, 12.0, 0.2));
        let found = Comparison::of(&violet, &red, None).unwrap();
        assert_eq!(found.peak_shift_nm(), None);
        assert!(found.words().contains("no shift, since "), "{}", found.words());
        assert!(found.words().contains("peak 330 nm, measured 650 nm (no shift"), "{}", found.words());
        let cells = found.fields().csv_cells();
        assert_eq!(cells.split(',').nth(11), Some(""), "{cells}");
    }

    #[test]
    fn no_shift_is_claimed_where_two_stretches_are_as_good() {
        let nm = steps(300, 830, 4);
        let measured = bell(&nm, 500.0, 25.0, 0.2);
        // Two orders, as far above as below.
        let orders = bell(&nm, 500.0 / 1.12, 25.0 / 1.12, 0.2);
        let twin = bell(&nm, 500.0 * 1.12, 25.0 * 1.12, 0.2);
        let sum = orders.values().iter().zip(twin.values()).map(|(a, b)| a + b).collect();
        let both = Spectrum::new(Wavelengths::new(nm.clone()).unwrap(), sum).unwrap();
        let found = Comparison::of(&both, &measured, None).unwrap();
        assert_eq!(found.peak_shift_nm(), None);
        let words = found.words();
        assert!(
            words.contains("no shift, since two stretches") && words.contains("560 or to 446"),
            "{words}"
        );
        // One of them alone is claimed.
        for (simulated, shift) in [(&orders, -54.0), (&twin, 60.0)] {
            let found = Comparison::of(simulated, &measured, None).unwrap();
            assert!((found.peak_shift_nm().unwrap() - shift).abs() < 2.0, "{}", found.words());
        }
    }

    #[test]
    fn too_little_in_common_is_refused_and_short_ranges_have_no_colour() {
        let simulated = bell(&steps(400, 700, 4), 540.0, 30.0, 0.2);
        for far in [steps(300, 400, 5), steps(300, 390, 5), steps(750, 800, 5)] {
            let error = Comparison::of(&simulated, &bell(&far, 350.0, 20.0, 0.5), None).unwrap_err();
            assert!(error.is_input() && error.to_string().contains("in common"), "{error}");
        }
        let short = Comparison::of(&simulated, &bell(&steps(500, 600, 5), 540.0, 30.0, 0.2), None).unwrap();
        assert_eq!((short.delta_e_2000, short.points), (None, 26));
        assert!(short.words().contains("no ΔE"));
    }
}
