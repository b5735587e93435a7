//! The light in which birds see things, as numbers of quanta.

use crate::error::did_you_mean;
use crate::spectrum::Spectrum;
use crate::spectrum::colour::Illuminant;
use crate::spectrum::dense::DenseSpectrum;
use crate::{Error, Result};

/// A light: quanta per nm over the wavelength, in any unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// What it is called.
    pub name: String,
    /// Its quanta, 1 at 560 nm for those that are built in.
    pub quanta: DenseSpectrum,
    /// Between which wavelengths it is known, nm.
    pub known_nm: [f64; 2],
}

/// The temperature of `sky`, K.
const SKY_K: f64 = 15_000.0;

impl Light {
    /// Names and what they are.
    pub const NAMES: [(&'static str, &'static str); 7] = [
        ("D65", "average daylight (CIE)"),
        (
            "forest",
            "forest shade: daylight through leaves with some blue sky through gaps, an idealized spectrum",
        ),
        ("sky", "the blue sky without the sun: CIE daylight of 15000 K"),
        ("ideal", "as many quanta at every wavelength"),
        ("D50", "horizon light (CIE)"),
        ("A", "a tungsten lamp (CIE)"),
        ("E", "the same power at every wavelength"),
    ];

    /// The light of a name, in upper or lower case.
    ///
    /// # Errors
    /// None has it.
    pub fn named(name: &str) -> Result<Self> {
        let names = Self::NAMES.map(|(known, _)| known);
        let known = names.into_iter().find(|known| known.eq_ignore_ascii_case(name)).ok_or_else(|| {
            let short: String = name.chars().take(40).collect();
            let near = did_you_mean(&short, names);
            Error::input(format!("there is no light '{short}'{near}; known are {}", names.join(", ")))
        })?;
        let light = |quanta| Self { name: known.to_owned(), quanta, known_nm: [300.0, 830.0] };
        Ok(match known {
            "ideal" => light(DenseSpectrum::new(|_| 1.0)),
            "sky" => light(of_power(|nm| daylight(SKY_K, nm))),
            "forest" => light(of_power(forest)),
            _ => {
                let illuminant = Illuminant::named(known)?;
                light(of_power(|nm| illuminant.power(nm)))
            }
        })
    }

    /// A light whose power, or with `is_quanta` whose numbers of quanta, a table gives; 0 outside it.
    ///
    /// # Errors
    /// A value below 0, or nothing but zeros.
    pub fn of_table(name: &str, table: &Spectrum, is_quanta: bool) -> Result<Self> {
        if let Some(bad) = table.values().iter().position(|v| *v < 0.0) {
            return Err(Error::input(format!(
                "the light at {} nm is {}; give values not below 0",
                table.wavelengths()[bad],
                table.values()[bad]
            )));
        }
        if table.values().iter().all(|v| *v == 0.0) {
            return Err(Error::input("the light is 0 at all wavelengths; give one that shines"));
        }
        let (first, last) = table.wavelengths().range_nm();
        let per = |nm: f64| if is_quanta { 1.0 } else { nm / 560.0 };
        let quanta = DenseSpectrum::new(|nm| table.value(nm).unwrap_or(0.0) * per(nm));
        Ok(Self { name: name.to_owned(), quanta, known_nm: [first, last] })
    }
}

/// Power turned into quanta, of which each has the energy hc/λ; 1 at 560 nm.
fn of_power(power: impl Fn(f64) -> f64) -> DenseSpectrum {
    let middle = power(560.0);
    DenseSpectrum::new(|nm| power(nm) / middle * (nm / 560.0))
}

/// Power of the CIE's daylight of a correlated colour temperature from 7000 to 25000 K (CIE 15:2004, section 3.1; Judd, MacAdam &
/// Wyszecki 1964).
fn daylight(kelvin: f64, nm: f64) -> f64 {
    of_components(components(chromaticity(kelvin)), nm)
}

/// x and y of that daylight.
fn chromaticity(kelvin: f64) -> [f64; 2] {
    let t = 1000.0 / kelvin;
    let x = 0.237_040 + t * (0.247_48 + t * (1.9018 - t * 2.0064));
    [x, -3.0 * x * x + 2.87 * x - 0.275]
}

/// How much of its two main variations the daylight of a chromaticity has; rounded as the CIE does.
fn components([x, y]: [f64; 2]) -> [f64; 2] {
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let first = (-1.3515 - 1.7703 * x + 5.9114 * y) / m;
    let second = (0.0300 - 31.4424 * x + 30.0717 * y) / m;
    [first, second].map(|part| (1000.0 * part).round() / 1000.0)
}

/// Power of daylight: the mean of measurements and its two main variations.
fn of_components([first, second]: [f64; 2], nm: f64) -> f64 {
    let at = ((nm - 300.0) / 10.0).clamp(0.0, 53.0);
    let low = (at as usize).min(52);
    let value = |[mean, one, other]: [f64; 3]| mean + first * one + second * other;
    let [before, after] = [value(DAYLIGHT[low]), value(DAYLIGHT[low + 1])];
    before + (after - before) * (at - low as f64)
}

/// An idealized forest shade: a little sky through gaps, and daylight that leaves let through. Leaves are greenest at 550 nm and darkest
/// near 675, where chlorophyll absorbs, as the light below broad-leaved trees was measured (Federer & Tanner 1966, *Ecology* 47,
/// 555); Endler (1993, *Ecol. Monogr.* 63, 1) calls it yellow-green.
fn forest(nm: f64) -> f64 {
    let square = |x: f64| x * x;
    let width = if nm < 550.0 { 35.0 } else { 70.0 };
    let red_edge = 0.4 / (1.0 + libm::exp((715.0 - nm) / 7.0));
    let leaf = 0.01 + 0.09 * libm::exp(-square((nm - 550.0) / width)) + red_edge;
    let leaf = if nm < 400.0 { 0.01 * (nm - 300.0) / 100.0 } else { leaf };
    0.02 * daylight(SKY_K, nm) + 0.98 * leaf * Illuminant::D65.power(nm)
}

/// The CIE's components S₀, S₁, S₂ of daylight at 300, 310 … 830 nm (CIE 15, table T.2).
const DAYLIGHT: [[f64; 3]; 54] = [
    [0.04, 0.02, 0.0],
    [6.0, 4.5, 2.0],
    [29.6, 22.4, 4.0],
    [55.3, 42.0, 8.5],
    [57.3, 40.6, 7.8],
    [61.8, 41.6, 6.7],
    [61.5, 38.0, 5.3],
    [68.8, 42.4, 6.1],
    [63.4, 38.5, 3.0],
    [65.8, 35.0, 1.2],
    [94.8, 43.4, -1.1],
    [104.8, 46.3, -0.5],
    [105.9, 43.9, -0.7],
    [96.8, 37.1, -1.2],
    [113.9, 36.7, -2.6],
    [125.6, 35.9, -2.9],
    [125.5, 32.6, -2.8],
    [121.3, 27.9, -2.6],
    [121.3, 24.3, -2.6],
    [113.5, 20.1, -1.8],
    [113.1, 16.2, -1.5],
    [110.8, 13.2, -1.3],
    [106.5, 8.6, -1.2],
    [108.8, 6.1, -1.0],
    [105.3, 4.2, -0.5],
    [104.4, 1.9, -0.3],
    [100.0, 0.0, 0.0],
    [96.0, -1.6, 0.2],
    [95.1, -3.5, 0.5],
    [89.1, -3.5, 2.1],
    [90.5, -5.8, 3.2],
    [90.3, -7.2, 4.1],
    [88.4, -8.6, 4.7],
    [84.0, -9.5, 5.1],
    [85.1, -10.9, 6.7],
    [81.9, -10.7, 7.3],
    [82.6, -12.0, 8.6],
    [84.9, -14.0, 9.8],
    [81.3, -13.6, 10.2],
    [71.9, -12.0, 8.3],
    [74.3, -13.3, 9.6],
    [76.4, -12.9, 8.5],
    [63.3, -10.6, 7.0],
    [71.7, -11.6, 7.6],
    [77.0, -12.2, 8.0],
    [65.2, -10.2, 6.7],
    [47.7, -7.8, 5.2],
    [68.6, -11.2, 7.4],
    [65.0, -10.4, 6.8],
    [66.0, -10.6, 7.0],
    [61.0, -9.7, 6.4],
    [53.3, -8.3, 5.5],
    [58.9, -9.3, 6.1],
    [61.9, -9.8, 6.5],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The CIE's own tables of D50 and D65 follow from the components: every number of the 54 rows enters twice.
    #[test]
    fn daylight_of_two_chromaticities_is_the_cies_own() {
        let [first, second] = components([0.312_713, 0.329_118]);
        assert!((first + 0.296).abs() < 0.01 && (second + 0.688).abs() < 0.01, "{first} {second}");
        for (parts, illuminant) in [([-1.040, 0.367], Illuminant::D50), ([-0.296, -0.688], Illuminant::D65)] {
            for row in 0..54 {
                let nm = 300.0 + 10.0 * f64::from(row);
                let (found, expected) = (of_components(parts, nm), illuminant.power(nm));
                assert!((found - expected).abs() < 0.06, "{illuminant:?} {nm}: {found} {expected}");
            }
        }
    }

    #[test]
    fn bluer_daylight_has_more_ultraviolet_and_its_chromaticity() {
        // The published chromaticity of 7000 K, where another law begins.
        let [x, y] = chromaticity(7000.0);
        assert!((x - 0.3054).abs() < 1e-4 && (y - 0.3216).abs() < 1e-4, "{x} {y}");
        let [sky, day] = ["sky", "D65"].map(|name| Light::named(name).unwrap().quanta);
        assert!(sky.at(360.0) > 1.5 * day.at(360.0) && sky.at(650.0) < day.at(650.0));
        assert!((sky.at(560.0) - 1.0).abs() < 1e-12 && (day.at(560.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn forests_are_green_with_a_gap_where_chlorophyll_absorbs() {
        let energy: Vec<(f64, f64)> = (400..=690).map(|nm| (f64::from(nm), forest(f64::from(nm)))).collect();
        let top = energy.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0;
        let bottom = energy.iter().filter(|(nm, _)| *nm > top).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0;
        assert!((540.0..=560.0).contains(&top), "{top}");
        assert!((665.0..=690.0).contains(&bottom), "{bottom}");
        assert!(forest(740.0) > forest(550.0));
    }

    #[test]
    fn tables_of_power_become_quanta_and_bad_ones_are_refused() {
        let at = crate::spectrum::Wavelengths::new([400.0, 560.0, 700.0]).unwrap();
        let table = |values: [f64; 3]| Spectrum::new(at.clone(), values.to_vec()).unwrap();
        let lamp = Light::of_table("lamp", &table([2.0, 2.0, 2.0]), false).unwrap();
        assert_eq!((lamp.quanta.at(560.0), lamp.quanta.at(700.0), lamp.quanta.at(399.0)), (2.0, 2.5, 0.0));
        let quanta = Light::of_table("lamp", &table([2.0, 2.0, 2.0]), true).unwrap();
        assert_eq!((quanta.quanta.at(700.0), quanta.known_nm), (2.0, [400.0, 700.0]));
        assert!(
            Light::of_table("x", &table([1.0, -1.0, 0.0]), false)
                .unwrap_err()
                .to_string()
                .contains("at 560 nm is -1")
        );
        assert!(Light::of_table("x", &table([0.0; 3]), false).is_err());
        assert!(Light::named("forrest").unwrap_err().to_string().contains("did you mean 'forest'?"));
    }
}
