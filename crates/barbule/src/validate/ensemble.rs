//! Several individuals by both simulations: means and spreads, in numbers and tables.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::numbers::{Case, Comparison, Incidence, tells_colours};
use super::spread::Spread;
use crate::spectrum::peaks::{Origin, highest, peaks};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::structure::Ends;
use crate::{Error, Result};

/// Individuals of one structure, each by both simulations, under the same light.
#[derive(Debug, Clone, PartialEq)]
pub struct Ensemble {
    /// At least one.
    pub individuals: Vec<Comparison>,
    /// Their vacuum wavelengths.
    wavelengths: Wavelengths,
    /// The mean over individuals, by incidence: patterns and powers are means, colours and errors are of these.
    means: Vec<Incidence>,
}

impl Ensemble {
    /// Of comparisons under the same light.
    ///
    /// # Errors
    /// None are given, or their wavelengths, incidences or azimuths differ.
    pub fn new(individuals: Vec<Comparison>) -> Result<Self> {
        let Some(first) = individuals.first() else {
            return Err(Error::input("no individuals are compared; give at least one"));
        };
        let shape = |one: &Comparison| -> Vec<(f64, Vec<usize>)> {
            let lengths = |found: &Incidence| found.cases.iter().map(|case| case.full.len()).collect();
            one.incidences.iter().map(|found| (found.phi_deg, lengths(found))).collect()
        };
        let same =
            |one: &Comparison| one.wavelengths_nm == first.wavelengths_nm && shape(one) == shape(first);
        if !individuals.iter().all(same) {
            return Err(Error::input("individuals are compared under different light; give all the same"));
        }
        let wavelengths = Wavelengths::new(first.wavelengths_nm.clone())?;
        let mean = |i: usize| {
            let mean = |w: usize| {
                let others = individuals[1..].iter().map(|one| &one.incidences[i].cases[w]);
                mean_case(&first.incidences[i].cases[w], others)
            };
            let cases = (0..wavelengths.len()).map(mean).collect();
            Incidence::new(first.incidences[i].phi_deg, cases, &wavelengths)
        };
        let means = (0..first.incidences.len()).map(mean).collect();
        Ok(Self { individuals, wavelengths, means })
    }

    /// The words that all names of the individuals begin with: without their numbers.
    pub(super) fn name(&self) -> String {
        let words = |one: &Comparison| one.name.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let mut common = words(self.first());
        for one in &self.individuals {
            let same = common.iter().zip(words(one)).take_while(|(a, b)| *a == b).count();
            common.truncate(same);
        }
        common.join(" ")
    }

    /// The mean over individuals, by incidence.
    #[must_use]
    pub fn means(&self) -> &[Incidence] {
        &self.means
    }

    pub(super) fn first(&self) -> &Comparison {
        &self.individuals[0]
    }

    pub(super) fn wavelengths(&self) -> &Wavelengths {
        &self.wavelengths
    }

    /// Of a value of each individual at one incidence; `None` where none has it.
    pub(super) fn spread(&self, incidence: usize, of: impl Fn(&Incidence) -> Option<f64>) -> Option<Spread> {
        let values: Vec<f64> =
            self.individuals.iter().filter_map(|one| of(&one.incidences[incidence])).collect();
        Spread::of(&values)
    }

    /// Of a value of each individual at one incidence and wavelength.
    pub(super) fn spread_at(
        &self,
        incidence: usize,
        wavelength: usize,
        of: impl Fn(&Case) -> f64,
    ) -> Option<Spread> {
        self.spread(incidence, |found| Some(of(&found.cases[wavelength])))
    }

    /// Of the standard deviation over individuals of a pattern (fast 0, full 1) at each azimuth.
    pub(super) fn pattern_std(&self, incidence: usize, wavelength: usize, side: usize) -> Option<Vec<f64>> {
        let patterns: Vec<&[f64]> = (self.individuals.iter())
            .map(|one| pattern(&one.incidences[incidence].cases[wavelength], side))
            .collect();
        (0..patterns[0].len())
            .map(|at| Spread::of(&patterns.iter().map(|values| values[at]).collect::<Vec<_>>())?.std)
            .collect()
    }

    /// The place of the highest inner peak of what an individual reflects, nm.
    fn peak_nm(&self, found: &Incidence, side: usize) -> Option<f64> {
        if !tells_colours(&self.wavelengths) {
            return None;
        }
        let spectrum = Spectrum::new(self.wavelengths.clone(), found.reflected(side)).ok()?;
        highest(&peaks(&spectrum, Origin::Computed, None), None).map(|peak| peak.nm)
    }

    /// Everything but the patterns: of one individual its numbers, of several means and spreads, and the numbers of each.
    #[must_use]
    pub fn numbers(&self) -> Value {
        let first = self.first();
        if self.individuals.len() == 1 {
            return first.numbers();
        }
        let sum = |of: fn(&Comparison) -> f64| self.individuals.iter().map(of).sum::<f64>();
        let (fast, full) = (sum(|one| one.fast_seconds), sum(Comparison::full_seconds));
        json!({
            "structure": self.name(),
            "count": self.individuals.len(),
            "width_um": first.width_um,
            "ends": first.ends.map(Ends::name),
            "wavelengths_nm": first.wavelengths_nm,
            "elements_per_wavelength": first.elements_per_wavelength,
            "shadowing": first.has_shadows,
            "smooth_um": first.smooth_um,
            "fast_seconds": fast,
            "full_wave_seconds": full,
            "speed_ratio": full / fast,
            "incidences": (0..self.means.len()).map(|i| self.incidence(i)).collect::<Vec<_>>(),
            "individuals": self.individuals.iter().map(Comparison::numbers).collect::<Vec<_>>(),
        })
    }

    fn incidence(&self, i: usize) -> Value {
        let mean = &self.means[i];
        let (range_deg, beyond) = mean.beam();
        let json = |spread: Option<Spread>| spread.map_or(Value::Null, Spread::json);
        let of = |value: &dyn Fn(&Incidence) -> Option<f64>| json(self.spread(i, value));
        let delta_e = self.spread(i, |found| found.delta_e);
        let wavelength = |w: usize| {
            let at = |value: &dyn Fn(&Case) -> f64| json(self.spread_at(i, w, value));
            json!({
                "wavelength_nm": self.wavelengths.nm()[w],
                "fast": at(&|case| case.reflected[0]),
                "full": at(&|case| case.reflected[1]),
                "power_error": at(&Case::power_error),
                "power_error_of_means": mean.cases[w].power_error(),
                "pattern_correlation": at(&Case::correlation),
                "pattern_rms": at(&Case::rms),
            })
        };
        json!({
            "phi_deg": mean.phi_deg,
            "beam_range_deg": range_deg,
            "beyond_horizon": beyond,
            "fast": of(&|found| Some(found.mean(|case| case.reflected[0]))),
            "full": of(&|found| Some(found.mean(|case| case.reflected[1]))),
            "power_error": of(&|found| Some(found.mean_power_error())),
            "power_error_of_means": mean.mean_power_error(),
            "power_error_within_75_deg": of(&|found| Some(found.mean_upward_error())),
            "pattern_correlation": of(&|found| Some(found.mean(Case::correlation))),
            "pattern_rms": of(&|found| Some(found.mean(Case::rms))),
            "delta_e": delta_e.map(|spread| spread.mean),
            "delta_e_std": delta_e.and_then(|spread| spread.std),
            "delta_e_of_means": mean.delta_e,
            "delta_e_patterns": of(&|found| found.delta_e_pattern),
            "delta_e_of_mean_patterns": mean.delta_e_pattern,
            "peak_nm_fast": of(&|found| self.peak_nm(found, 0)),
            "peak_nm_full": of(&|found| self.peak_nm(found, 1)),
            "peak_nm_of_means": {"fast": self.peak_nm(mean, 0), "full": self.peak_nm(mean, 1)},
            "wavelengths": (0..self.wavelengths.len()).map(wavelength).collect::<Vec<_>>(),
        })
    }

    /// A table for people.
    #[must_use]
    pub fn table(&self) -> String {
        let first = self.first();
        let ends = first.ends.map_or_else(String::new, |ends| format!(", ends {}", ends.name()));
        let several = if self.individuals.len() > 1 {
            format!(", mean ± standard deviation of {} individuals", self.individuals.len())
        } else {
            String::new()
        };
        let heads = [
            "φ_i (°)",
            "beam (°)",
            "beyond",
            "fast",
            "full",
            "power error",
            "within 75°",
            "correlation",
            "RMS",
            "ΔE00",
            "of patterns",
        ];
        let mut rows: Vec<Vec<String>> = vec![heads.map(str::to_owned).to_vec()];
        for (i, mean) in self.means.iter().enumerate() {
            let of = |value: &dyn Fn(&Incidence) -> Option<f64>, factor: f64, decimals: usize| {
                self.spread(i, value).map_or_else(|| "–".to_owned(), |spread| spread.words(factor, decimals))
            };
            let signed = |text: String| if text.starts_with('-') { text } else { format!("+{text}") };
            let ([from, to], beyond) = mean.beam();
            rows.push(vec![
                format!("{:.0}", mean.phi_deg),
                format!("{from:.0} to {to:.0}"),
                format!("{:.1} %", 1e2 * beyond),
                of(&|found| Some(found.mean(|case| case.reflected[0])), 1.0, 4),
                of(&|found| Some(found.mean(|case| case.reflected[1])), 1.0, 4),
                signed(of(&|found| Some(found.mean_power_error()), 1e2, 1)) + " %",
                signed(of(&|found| Some(found.mean_upward_error()), 1e2, 1)) + " %",
                of(&|found| Some(found.mean(Case::correlation)), 1.0, 3),
                of(&|found| Some(found.mean(Case::rms)), 1.0, 3),
                of(&|found| found.delta_e, 1.0, 1),
                of(&|found| found.delta_e_pattern, 1.0, 1),
            ]);
        }
        let mut text = format!(
            "{}, {} µm wide{ends}, {} wavelengths{several}\n",
            self.name(),
            first.width_um,
            self.wavelengths.len()
        );
        let widths: Vec<usize> = (0..heads.len())
            .map(|c| rows.iter().map(|row| row[c].chars().count()).max().unwrap_or(0))
            .collect();
        for row in rows {
            let cells: Vec<String> =
                row.iter().zip(&widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
            text += &format!("{}\n", cells.join("  "));
        }
        if !tells_colours(&self.wavelengths) {
            text +=
                "no colours: these need wavelengths from 400 to 694 nm, no two farther apart than 25 nm\n";
        }
        let cases = self.individuals.iter().flat_map(|one| &one.incidences).flat_map(|found| &found.cases);
        let unknowns = cases.map(|case| case.effort.unknowns).max();
        let fast: f64 = self.individuals.iter().map(|one| one.fast_seconds).sum();
        let full: f64 = self.individuals.iter().map(Comparison::full_seconds).sum();
        let _ = write!(
            text,
            "fast {fast:.2} s, full waves {full:.1} s ({} unknowns at most): {:.0} times",
            unknowns.unwrap_or(0),
            full / fast
        );
        text
    }

    /// Every individual, incidence and wavelength in a line.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "individual,phi_deg,wavelength_nm,beam_from_deg,beam_to_deg,beyond_horizon,reflected_fast,reflected_full_wave,\
             within_75_deg_fast,within_75_deg_full_wave,absorbed_full_wave,scattered_full_wave,pattern_correlation,pattern_rms,\
             unknowns,full_wave_seconds,full_wave_bytes\n",
        );
        for one in &self.individuals {
            for found in &one.incidences {
                for case in &found.cases {
                    let [from, to] = case.range.phi_i.map(f64::to_degrees);
                    let [fast, full] = case.upward();
                    let _ = writeln!(
                        text,
                        "{},{},{},{from},{to},{},{},{},{fast},{full},{},{},{},{},{},{},{}",
                        one.instance,
                        found.phi_deg,
                        case.wavelength_nm,
                        case.range.beyond_horizon,
                        case.reflected[0],
                        case.reflected[1],
                        case.absorbed,
                        case.scattered,
                        case.correlation(),
                        case.rms(),
                        case.effort.unknowns,
                        case.effort.seconds,
                        case.effort.memory_bytes
                    );
                }
            }
        }
        text
    }

    /// Means and standard deviations of the patterns, 1/rad: an azimuth of an incidence and wavelength in a line.
    #[must_use]
    pub fn patterns_csv(&self) -> String {
        let mut text = String::from(
            "phi_deg,wavelength_nm,azimuth_deg,fast_mean,fast_std,full_wave_mean,full_wave_std\n",
        );
        for (i, mean) in self.means.iter().enumerate() {
            for (w, case) in mean.cases.iter().enumerate() {
                let spreads = [0, 1].map(|side| self.pattern_std(i, w, side));
                let std = |side: usize, at: usize| {
                    spreads[side].as_ref().map_or_else(String::new, |values| values[at].to_string())
                };
                for (at, (fast, full)) in case.fast.iter().zip(&case.full).enumerate() {
                    let azimuth_deg = azimuth_deg(at, case.full.len());
                    let _ = writeln!(
                        text,
                        "{},{},{azimuth_deg},{fast},{},{full},{}",
                        mean.phi_deg,
                        case.wavelength_nm,
                        std(0, at),
                        std(1, at)
                    );
                }
            }
        }
        text
    }
}

/// The outgoing azimuth of a value of a pattern, degrees.
pub(super) fn azimuth_deg(at: usize, count: usize) -> f64 {
    (at as f64 + 0.5) * 180.0 / count as f64 - 90.0
}

/// A pattern: fast (0) or full (1).
pub(super) fn pattern(case: &Case, side: usize) -> &[f64] {
    if side == 0 { &case.fast } else { &case.full }
}

/// The mean over individuals; what the full waves took is the sum, of unknowns and bytes the most.
fn mean_case<'a>(first: &Case, others: impl Iterator<Item = &'a Case>) -> Case {
    let (mut sum, mut count) = (first.clone(), 1.0);
    for case in others {
        let add = |into: &mut [f64], from: &[f64]| into.iter_mut().zip(from).for_each(|(a, b)| *a += b);
        add(&mut sum.fast, &case.fast);
        add(&mut sum.full, &case.full);
        add(&mut sum.reflected, &case.reflected);
        sum.windowed += case.windowed;
        sum.absorbed += case.absorbed;
        sum.scattered += case.scattered;
        sum.effort.seconds += case.effort.seconds;
        sum.effort.unknowns = sum.effort.unknowns.max(case.effort.unknowns);
        sum.effort.memory_bytes = sum.effort.memory_bytes.max(case.effort.memory_bytes);
        count += 1.0;
    }
    let Case { fast, full, reflected, windowed, absorbed, scattered, .. } = &mut sum;
    for value in fast.iter_mut().chain(full).chain(reflected).chain([windowed, absorbed, scattered]) {
        *value /= count;
    }
    sum
}
