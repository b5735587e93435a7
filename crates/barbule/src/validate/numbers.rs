//! What differs between two simulations, in numbers.

use serde_json::{Value, json};

use crate::solve::IncidentRange;
use crate::solve::far_fields::Effort;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::{Illuminant, Observer, held};
use crate::spectrum::difference::{delta_e_2000, lab};
use crate::structure::Ends;

/// Beyond this light leaves near the horizon, where single reflections are not enough, degrees.
const UPWARD_DEG: f64 = 75.0;

/// Colours are told where no two wavelengths lie farther apart than this, nm: bands of films and crystals are some 50 nm wide and more.
const COLOUR_STEP_NM: f64 = 25.0;

/// Whether what is known at wavelengths makes a colour: they cover what is seen, and lie close enough.
#[must_use]
pub fn tells_colours(wavelengths: &Wavelengths) -> bool {
    let is_close = wavelengths.nm().windows(2).all(|pair| pair[1] - pair[0] <= COLOUR_STEP_NM);
    is_close && held(wavelengths).is_none()
}

/// One wavelength and incidence by both simulations; powers are parts of the incident power.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Unpolarized radiant intensity over the upper half, 1/rad, by the fast simulation.
    pub fast: Vec<f64>,
    /// The same by full waves.
    pub full: Vec<f64>,
    /// What leaves into the upper half: fast, full.
    pub reflected: [f64; 2],
    /// The same by the fast simulation under its own window, which lies on the top: a part of what falls through that.
    pub windowed: f64,
    /// What absorbing regions take, by full waves.
    pub absorbed: f64,
    /// What leaves in all directions but for the light itself, by full waves.
    pub scattered: f64,
    /// From where the light comes.
    pub range: IncidentRange,
    /// What the full waves took: all incidences of a wavelength share it.
    pub effort: Effort,
}

/// One incidence at all wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Incidence {
    /// φ_i, degrees.
    pub phi_deg: f64,
    /// By wavelength.
    pub cases: Vec<Case>,
    /// ΔE00 of the colours of all that is reflected; `None` where wavelengths do not tell ([`tells_colours`]).
    pub delta_e: Option<f64>,
    /// ΔE00 of the colours at each azimuth, weighted by luminance; the brightest of the full waves is white's.
    pub delta_e_pattern: Option<f64>,
    /// Linear sRGB at each azimuth: fast, full.
    pub rgb: [Vec<[f64; 3]>; 2],
}

/// Both simulations of one section.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// What was simulated.
    pub name: String,
    /// Which individual, from 0.
    pub instance: usize,
    /// Its width.
    pub width_um: f64,
    /// How its layers end; `None` for crystals and sections of closed regions.
    pub ends: Option<Ends>,
    /// How it was closed.
    pub changes: Vec<String>,
    /// Vacuum wavelengths.
    pub wavelengths_nm: Vec<f64>,
    /// Nodes per wavelength of the full waves.
    pub elements_per_wavelength: f64,
    /// Wall time of the fast simulation for all of it.
    pub fast_seconds: f64,
    /// Whether the fast simulation's formulas had the top in its own light.
    pub has_shadows: bool,
    /// Over which standard deviation it averaged inclusions along the top, µm.
    pub smooth_um: Option<f64>,
    /// Memory that the fast simulation takes for one illumination at most, bytes.
    pub fast_bytes: u64,
    /// By incidence.
    pub incidences: Vec<Incidence>,
}

impl Case {
    /// How much more the fast simulation reflects, as a part of what the full waves do.
    #[must_use]
    pub fn power_error(&self) -> f64 {
        self.reflected[0] / self.reflected[1] - 1.0
    }

    /// What leaves within 75° of the z axis, by the patterns: fast, full.
    #[must_use]
    pub fn upward(&self) -> [f64; 2] {
        [&self.fast, &self.full].map(|pattern| {
            let step = 180.0 / pattern.len() as f64;
            let phi_deg = |n: usize| (n as f64 + 0.5) * step - 90.0;
            let values = pattern.iter().enumerate().filter(|(n, _)| phi_deg(*n).abs() < UPWARD_DEG);
            values.map(|(_, value)| value * step.to_radians()).sum()
        })
    }

    /// The correlation of both patterns.
    #[must_use]
    pub fn correlation(&self) -> f64 {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (a, b) = (mean(&self.fast), mean(&self.full));
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            self.fast.iter().zip(&self.full).map(|(x, y)| of(x - a, y - b)).sum()
        };
        sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
    }

    /// Root mean square of the difference of both patterns over that of the full waves'.
    #[must_use]
    pub fn rms(&self) -> f64 {
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
        let apart = square(&mut self.fast.iter().zip(&self.full).map(|(x, y)| x - y));
        (apart / square(&mut self.full.iter().copied())).sqrt()
    }
}

impl Incidence {
    /// From the cases of one incidence, in the order of the wavelengths.
    #[must_use]
    pub fn new(phi_deg: f64, cases: Vec<Case>, wavelengths: &Wavelengths) -> Self {
        let weights = Observer::under(Illuminant::D65).weights(wavelengths);
        let white = weights.xyz(&vec![1.0; wavelengths.len()]);
        let colour = |xyz: [f64; 3]| lab(xyz, white);
        let reflected = |side: usize| -> Vec<f64> { cases.iter().map(|case| case.reflected[side]).collect() };
        let delta_e = delta_e_2000(colour(weights.xyz(&reflected(0))), colour(weights.xyz(&reflected(1))));
        let azimuths = cases.first().map_or(0, |case| case.full.len());
        let samples = |side: usize, at: usize| -> Vec<f64> {
            cases.iter().map(|case| if side == 0 { case.fast[at] } else { case.full[at] }).collect()
        };
        let xyz: Vec<[[f64; 3]; 2]> =
            (0..azimuths).map(|at| [0, 1].map(|side| weights.xyz(&samples(side, at)))).collect();
        let brightest = xyz.iter().map(|both| both[1][1]).fold(0.0, f64::max);
        let scale = 1.0 / brightest.max(f64::MIN_POSITIVE);
        let (mut sum, mut weight) = (0.0_f64, 0.0_f64);
        for both in &xyz {
            let [fast, full] = both.map(|xyz| colour(xyz.map(|value| value * scale)));
            sum += both[1][1] * delta_e_2000(fast, full);
            weight += both[1][1];
        }
        let rgb = [0, 1].map(|side| {
            (0..azimuths)
                .map(|at| weights.linear_rgb(&samples(side, at)).map(|value| value * scale))
                .collect()
        });
        let told = |value: f64| tells_colours(wavelengths).then_some(value);
        let delta_e_pattern = told(sum / weight.max(f64::MIN_POSITIVE));
        Self { phi_deg, cases, delta_e: told(delta_e), delta_e_pattern, rgb }
    }

    /// The widest range of azimuths that light of a wavelength comes from, degrees, and the largest part beyond the horizon: those of the
    /// longest wavelength.
    #[must_use]
    pub fn beam(&self) -> ([f64; 2], f64) {
        let ranges = || self.cases.iter().map(|case| case.range);
        let from = ranges().map(|range| range.phi_i[0]).fold(f64::INFINITY, f64::min);
        let to = ranges().map(|range| range.phi_i[1]).fold(f64::NEG_INFINITY, f64::max);
        let beyond = ranges().map(|range| range.beyond_horizon).fold(0.0, f64::max);
        ([from, to].map(f64::to_degrees), beyond)
    }

    /// By wavelength what is reflected: fast (0) or full (1).
    #[must_use]
    pub fn reflected(&self, side: usize) -> Vec<f64> {
        self.cases.iter().map(|case| case.reflected[side]).collect()
    }

    /// How much more the fast simulation reflects of all wavelengths together, as a part of what the full waves do: dark
    /// wavelengths, at which both reflect little, count little.
    #[must_use]
    pub fn mean_power_error(&self) -> f64 {
        self.mean(|case| case.reflected[0]) / self.mean(|case| case.reflected[1]) - 1.0
    }

    /// The same of what leaves within 75° of the z axis.
    #[must_use]
    pub fn mean_upward_error(&self) -> f64 {
        self.mean(|case| case.upward()[0]) / self.mean(|case| case.upward()[1]) - 1.0
    }

    /// The mean over wavelengths.
    pub(super) fn mean(&self, of: impl Fn(&Case) -> f64) -> f64 {
        self.cases.iter().map(of).sum::<f64>() / self.cases.len() as f64
    }
}

impl Comparison {
    /// Wall time of the full waves.
    #[must_use]
    pub fn full_seconds(&self) -> f64 {
        let Some(first) = self.incidences.first() else { return 0.0 };
        first.cases.iter().map(|case| case.effort.seconds).sum()
    }

    /// Everything but the patterns.
    #[must_use]
    pub fn numbers(&self) -> Value {
        let case = |case: &Case| {
            json!({
                "wavelength_nm": case.wavelength_nm,
                "reflected_fast": case.reflected[0],
                "reflected_fast_window_on_top": case.windowed,
                "reflected_full_wave": case.reflected[1],
                "absorbed_full_wave": case.absorbed,
                "scattered_full_wave": case.scattered,
                "power_error": case.power_error(),
                "power_error_within_75_deg": case.upward()[0] / case.upward()[1] - 1.0,
                "pattern_correlation": case.correlation(),
                "pattern_rms": case.rms(),
                "beam_range_deg": case.range.phi_i.map(f64::to_degrees),
                "beyond_horizon": case.range.beyond_horizon,
                "unknowns": case.effort.unknowns,
                "full_wave_seconds": case.effort.seconds,
                "full_wave_bytes": case.effort.memory_bytes,
            })
        };
        let incidence = |found: &Incidence| {
            let (range_deg, beyond) = found.beam();
            json!({
                "phi_deg": found.phi_deg,
                "beam_range_deg": range_deg,
                "beyond_horizon": beyond,
                "fast": {"mean": found.mean(|case| case.reflected[0]), "std": null},
                "full": {"mean": found.mean(|case| case.reflected[1]), "std": null},
                "delta_e": found.delta_e,
                "delta_e_patterns": found.delta_e_pattern,
                "mean_power_error": found.mean_power_error(),
                "mean_power_error_within_75_deg": found.mean_upward_error(),
                "mean_pattern_correlation": found.mean(Case::correlation),
                "mean_pattern_rms": found.mean(Case::rms),
                "wavelengths": found.cases.iter().map(case).collect::<Vec<_>>(),
            })
        };
        json!({
            "structure": self.name,
            "instance": self.instance,
            "width_um": self.width_um,
            "ends": self.ends.map(Ends::name),
            "changes": self.changes,
            "elements_per_wavelength": self.elements_per_wavelength,
            "shadowing": self.has_shadows,
            "smooth_um": self.smooth_um,
            "fast_seconds": self.fast_seconds,
            "fast_bytes": self.fast_bytes,
            "full_wave_seconds": self.full_seconds(),
            "speed_ratio": self.full_seconds() / self.fast_seconds,
            "incidences": self.incidences.iter().map(incidence).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(wavelength_nm: f64, fast: Vec<f64>, full: Vec<f64>, reflected: [f64; 2]) -> Case {
        let effort = Effort { unknowns: 8, elements_per_wavelength: 10.0, seconds: 2.0, memory_bytes: 100 };
        let windowed = reflected[0];
        let range = IncidentRange { phi_i: [-0.1, 0.1], beyond_horizon: 0.0 };
        Case { wavelength_nm, fast, full, reflected, windowed, absorbed: 0.1, scattered: 0.9, range, effort }
    }

    #[test]
    fn equal_patterns_differ_by_nothing_and_twice_the_light_by_all_of_it() {
        let pattern = vec![0.1, 0.4, 0.2, 0.05];
        let same = case(500.0, pattern.clone(), pattern.clone(), [0.3, 0.3]);
        assert!(same.power_error() == 0.0 && same.rms() == 0.0 && (same.correlation() - 1.0).abs() < 1e-15);
        let double = pattern.iter().map(|x| 2.0 * x).collect();
        let twice = case(500.0, double, pattern.clone(), [0.6, 0.3]);
        assert!((twice.power_error() - 1.0).abs() < 1e-15 && (twice.rms() - 1.0).abs() < 1e-15);
        assert!((twice.correlation() - 1.0).abs() < 1e-12);
        // Azimuths ±22.5° and ±67.5°, each a quarter of the half circle.
        assert!((twice.upward()[1] - 0.25 * std::f64::consts::PI * 0.75).abs() < 1e-12);
        assert!((twice.upward()[0] - 2.0 * twice.upward()[1]).abs() < 1e-12);
        let horizon = case(500.0, vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], vec![0.1; 8], [0.1, 0.1]);
        assert_eq!(horizon.upward()[0], 0.0);
        let turned = case(500.0, pattern.iter().rev().copied().collect(), pattern, [0.3, 0.3]);
        assert!(turned.correlation() < 0.5);
    }

    #[test]
    fn dark_wavelengths_count_little_in_the_mean_error() {
        let wavelengths = Wavelengths::new(vec![450.0, 650.0]).unwrap();
        let flat = vec![1.0; 3];
        let cases = [(450.0, [0.02, 0.01]), (650.0, [0.49, 0.49])];
        let cases = cases.map(|(nm, reflected)| case(nm, flat.clone(), flat.clone(), reflected)).to_vec();
        let error = Incidence::new(0.0, cases, &wavelengths).mean_power_error();
        assert!((error - 0.02).abs() < 1e-12, "{error}");
    }

    #[test]
    fn colours_differ_where_spectra_do() {
        let wavelengths =
            Wavelengths::new((0..13).map(|i| 400.0 + 24.5 * f64::from(i)).collect::<Vec<_>>()).unwrap();
        let flat = |level: f64| vec![level; 3];
        // Levels at 400, 500, 600 and 700 nm, linear between.
        let at = |levels: [f64; 4], nm: f64| {
            let place = (nm - 400.0) / 100.0;
            let left = (place as usize).min(2);
            levels[left] + (place - left as f64) * (levels[left + 1] - levels[left])
        };
        let cases = |fast: [f64; 4], full: [f64; 4]| -> Vec<Case> {
            let case = |nm: &f64| {
                let (a, b) = (at(fast, *nm), at(full, *nm));
                case(*nm, flat(a), flat(b), [a, b])
            };
            wavelengths.nm().iter().map(case).collect()
        };
        let full = [0.2, 0.5, 0.3, 0.1];
        let same = Incidence::new(0.0, cases(full, full), &wavelengths);
        assert!(same.delta_e == Some(0.0) && same.delta_e_pattern == Some(0.0) && same.rgb[0] == same.rgb[1]);
        let other = Incidence::new(0.0, cases([0.2, 0.2, 0.6, 0.1], full), &wavelengths);
        assert!(other.delta_e.unwrap() > 20.0 && other.delta_e_pattern.unwrap() > 20.0);
        let greenest = |rgb: [f64; 3]| rgb[1] > rgb[0] && rgb[1] > rgb[2];
        assert!(greenest(other.rgb[1][0]) && !greenest(other.rgb[0][0]));
    }

    /// Three wavelengths make a blue mallard magenta: no colour is told of them, nor of a part of the spectrum.
    #[test]
    fn few_wavelengths_tell_no_colours() {
        let told = |nm: &[f64]| tells_colours(&Wavelengths::new(nm.to_vec()).unwrap());
        let steps = |first: f64, step: f64, count: u32| -> Vec<f64> {
            (0..count).map(|i| first + step * f64::from(i)).collect()
        };
        assert!(told(&steps(400.0, 24.5, 13)) && told(&steps(400.0, 12.0, 25)));
        assert!(
            !told(&[400.0, 550.0, 694.0]) && !told(&steps(400.0, 42.0, 8)) && !told(&steps(400.0, 12.0, 15))
        );
        let cases = vec![
            case(400.0, vec![0.1], vec![0.2], [0.1, 0.2]),
            case(694.0, vec![0.1], vec![0.1], [0.1, 0.1]),
        ];
        let found = Incidence::new(0.0, cases, &Wavelengths::new(vec![400.0, 694.0]).unwrap());
        assert_eq!((found.delta_e, found.delta_e_pattern), (None, None));
    }
}
