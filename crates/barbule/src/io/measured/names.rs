//! What a column of a measured table is by its name.

use super::Unit;

/// What a column is by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Where the values lie.
    Position(Unit),
    /// A reflectance, by its name.
    Reflectance,
    /// A mean: of the samples beside it where it is their mean in numbers, or else a sample.
    Mean,
    /// What spectrometers' own files hold beside: counts, dark, reference, and other quantities than reflectance.
    Raw,
    /// A spread, a bound, an angle, a number of birds or another thing that is no sample.
    Beside,
    /// Anything else: the name of a sample.
    Sample,
}

const POSITIONS: [&str; 10] =
    ["wl", "wvl", "wave", "wavelength", "wavelengths", "lambda", "λ", "nm", "nanometers", "nanometres"];
const MICROMETRES: [&str; 7] = ["um", "µm", "μm", "micron", "microns", "micrometers", "micrometres"];
const WAVE_NUMBERS: [&str; 4] = ["wavenumber", "wavenumbers", "cm⁻¹", "kayser"];
/// Each alone says reflectance, whatever stands beside it.
const REFLECTANCES: [&str; 7] =
    ["refl", "reflectance", "reflectances", "reflection", "reflectivity", "reflektanz", "processed"];
/// A reflectance when nothing else stands beside.
const SHORT_REFLECTANCES: [&str; 6] = ["r", "%r", "r%", "%", "percent", "pct"];
/// The words of means, of all samples when no sample's name stands beside.
const MEANS: [&str; 9] =
    ["mean", "means", "avg", "average", "averaged", "median", "mittelwert", "mittel", "moyenne"];
/// No reflectance when nothing else stands beside: a sample may be a white throat.
const RAW: [&str; 19] = [
    "dark",
    "dunkel",
    "reference",
    "referenz",
    "ref",
    "white",
    "standard",
    "counts",
    "count",
    "scope",
    "raw",
    "intensity",
    "irradiance",
    "radiance",
    "background",
    "trans",
    "abs",
    "od",
    "%",
];
/// Those of them that a lamp has.
const LIGHT: [&str; 5] = ["counts", "count", "intensity", "irradiance", "radiance"];
/// Beginnings of words for other quantities than reflectance, whatever stands beside.
const QUANTITIES: [&str; 5] = ["transmi", "absorb", "absorp", "extin", "kubelka"];
/// Spreads, first or last in a name.
const SPREADS: [&str; 26] = [
    "sd",
    "std",
    "stdev",
    "stddev",
    "stabw",
    "se",
    "sem",
    "stderr",
    "err",
    "error",
    "var",
    "variance",
    "cv",
    "ci",
    "uncertainty",
    "deviation",
    "deviations",
    "standarddeviation",
    "abweichung",
    "standardabweichung",
    "standardfehler",
    "stdabw",
    "écart",
    "ecart",
    "desviación",
    "desviacion",
];
/// Two words that make a spread beside each other, anywhere in a name: one of the first and one of the second.
const SPREAD_PAIRS: [([&str; 2], [&str; 2]); 4] = [
    (["standard", "std"], ["deviation", "dev"]),
    (["standard", "st"], ["error", "dev"]),
    (["écart", "ecart"], ["type", "types"]),
    (["desviación", "desviacion"], ["estándar", "estandar"]),
];
/// What is counted under `n`.
const COUNTED: [&str; 8] =
    ["samples", "birds", "individuals", "specimens", "spectra", "measurements", "replicates", "feathers"];
/// Bounds of a band about a mean.
const BOUNDS: [&str; 12] =
    ["lower", "upper", "lwr", "upr", "lcl", "ucl", "lci", "uci", "min", "max", "minimum", "maximum"];
/// What may stand beside a bound.
const BESIDE_BOUNDS: [&str; 6] = ["conf", "confidence", "limit", "bound", "cl", "ci"];
/// Other columns than samples when nothing else stands beside.
const BESIDE: [&str; 24] = [
    "angle",
    "theta",
    "phi",
    "deg",
    "temperature",
    "temp",
    "time",
    "date",
    "year",
    "day",
    "n",
    "no",
    "nr",
    "num",
    "number",
    "id",
    "ids",
    "age",
    "row",
    "index",
    "obs",
    "size",
    "weight",
    "mass",
];

/// The words of a name in lower case.
pub(super) fn words(name: &str) -> Vec<String> {
    let word = |c: char| c.is_alphanumeric() || c == '%' || c == '⁻';
    name.split(|c| !word(c)).filter(|w| !w.is_empty()).map(str::to_lowercase).collect()
}

/// A word without the number behind it, as in `sd2`; a single letter keeps its number, since n1 is a sample.
fn unnumbered(word: &str) -> &str {
    let bare = word.trim_end_matches(|c: char| c.is_ascii_digit());
    if bare.chars().count() > 1 { bare } else { word }
}

fn is_number(word: &str) -> bool {
    word.trim_matches('%').chars().all(|c| c.is_ascii_digit())
}

/// The unit of a column whose name says that it is a wavelength or a wave number; none of another.
pub(in crate::io) fn position_unit(name: &str) -> Option<Unit> {
    let words = words(name);
    let has = |known: &[&str]| words.iter().any(|word| known.contains(&word.as_str()));
    let all_are = |known: &[&[&str]]| words.iter().all(|w| known.iter().any(|k| k.contains(&w.as_str())));
    let inverse = name.to_lowercase().replace(' ', "");
    if has(&WAVE_NUMBERS) || ["1/cm", "cm-1", "cm^-1"].iter().any(|unit| inverse.contains(unit)) {
        return Some(Unit::PerCentimetre);
    }
    if words.is_empty() || !all_are(&[&POSITIONS, &MICROMETRES, &["in", "vacuum", "air", "x"]]) {
        return None;
    }
    if has(&MICROMETRES) {
        return Some(Unit::Micrometres);
    }
    has(&POSITIONS).then_some(Unit::Nanometres)
}

/// The unit of a column that is called a wavelength with a number behind it, as `wl2`, `wl.1` or `Wavelength (nm).1`.
pub(super) fn numbered_position_unit(name: &str) -> Option<Unit> {
    let bare = name.trim_end().trim_end_matches(|c: char| c.is_ascii_digit());
    let bare = bare.trim_end_matches(['.', '_', '-', ' ']);
    if bare.len() < name.trim_end().len() { position_unit(bare) } else { None }
}

/// Whether a name says percent.
pub(super) fn says_percent(name: &str) -> bool {
    name.contains('%') || words(name).iter().any(|w| ["percent", "percentage", "pct"].contains(&w.as_str()))
}

/// The letter of transmittance or absorbance that is all of a name, as of `T`, `%T` or `A (%)`.
fn quantity_letter(words: &[String]) -> Option<&str> {
    let mut letters = words.iter().map(|word| word.trim_matches('%')).filter(|word| !word.is_empty());
    match (letters.next(), letters.next()) {
        (Some(letter @ ("t" | "a")), None) => Some(letter),
        _ => None,
    }
}

/// Whether a name or a unit is that of another quantity than reflectance.
pub(super) fn is_other_quantity(name: &str) -> bool {
    let words = words(name);
    let begins =
        |word: &String| QUANTITIES.iter().any(|quantity| word.trim_matches('%').starts_with(quantity));
    let is_raw = |word: &String| RAW.contains(&unnumbered(word.trim_start_matches('%')));
    let is_word = |word: &&String| !is_number(word);
    let raw = words.iter().any(|w| is_word(&w)) && words.iter().filter(is_word).all(is_raw);
    words.iter().any(begins)
        || raw
        || is_logarithm(name)
        || quantity_letter(&words).is_some() && name.contains('%')
}

/// Whether a name is that of light itself, as a lamp has it.
pub(super) fn is_light(name: &str) -> bool {
    words(name).iter().filter(|word| !is_number(word)).all(|word| LIGHT.contains(&unnumbered(word)))
}

/// Whether a name is a logarithm's, as `log(1/R)`.
fn is_logarithm(name: &str) -> bool {
    name.contains('(') && words(name).iter().any(|word| ["log", "log10", "ln"].contains(&word.as_str()))
}

/// A name without what stands in brackets.
fn unbracketed(name: &str) -> String {
    let mut depth = 0_usize;
    let mut outside = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '(' | '[' | '{' => {
                depth += 1;
                outside.push(' ');
            }
            ')' | ']' | '}' => depth = depth.saturating_sub(1),
            _ if depth == 0 => outside.push(c),
            _ => {}
        }
    }
    outside
}

/// Whether a name is that of a spread, as `sd 2`, `back SD (n=5)`, `Standard deviation of R` or `back range`.
fn is_spread(name: &str) -> bool {
    let is_pair = |pair: &[String]| {
        SPREAD_PAIRS.iter().any(|(first, second)| {
            first.contains(&pair[0].as_str()) && second.contains(&unnumbered(&pair[1]))
        })
    };
    let says = |words: &[String]| {
        [words.first(), words.last()].into_iter().flatten().any(|word| SPREADS.contains(&unnumbered(word)))
            || words.windows(2).any(is_pair)
    };
    let without_percent = |name: &str| {
        let mut words = words(name);
        words.retain(|word| word != "%");
        words
    };
    let bare = without_percent(&unbracketed(name));
    // A range finch is a sample, and so is a finch (home range).
    let is_range = bare.last().is_some_and(|word| unnumbered(word) == "range");
    is_range || says(&bare) || says(&without_percent(name))
}

/// Whether a name is that of a number of samples, as `N (birds)`, `n samples` or `number of birds`.
fn is_number_of_samples(name: &str) -> bool {
    let is_counted = |word: &String| COUNTED.contains(&word.as_str());
    let says = match &words(name)[..] {
        [n, what] => n == "n" && is_counted(what),
        [number, of, what] => {
            ["n", "no", "nr", "num", "number"].contains(&number.as_str()) && of == "of" && is_counted(what)
        }
        _ => false,
    };
    says || words(&unbracketed(name)) == ["n"]
}

/// What a column is by its name alone.
pub(super) fn role(name: &str) -> Role {
    if let Some(unit) = position_unit(name) {
        return Role::Position(unit);
    }
    let words = words(name);
    let is = |word: &String, known: &[&str]| known.contains(&word.as_str());
    let any = |known: &[&str]| words.iter().any(|word| is(word, known));
    let all = |known: &[&[&str]]| words.iter().all(|word| known.iter().any(|known| is(word, known)));
    let some = |known: &[&str]| any(known) && all(&[known]);
    let is_bound = |word: &String| {
        let bare = unnumbered(word);
        BOUNDS.contains(&bare) || BESIDE_BOUNDS.contains(&bare) || is_number(word)
    };
    let is_mean =
        |word: &String| [&MEANS[..], &REFLECTANCES, &SHORT_REFLECTANCES].iter().any(|known| is(word, known));
    let has_bound = words.iter().any(|word| BOUNDS.contains(&unnumbered(word)));
    match () {
        () if is_spread(name) || is_number_of_samples(name) => Role::Beside,
        () if some(&BESIDE) => Role::Beside,
        () if has_bound && words.iter().all(|word| is_bound(word) || is_mean(word)) => Role::Beside,
        () if any(&MEANS) && words.iter().all(is_mean) => Role::Mean,
        () if is_logarithm(name) => Role::Raw,
        () if any(&REFLECTANCES) || some(&SHORT_REFLECTANCES) => Role::Reflectance,
        () if is_other_quantity(name) => Role::Raw,
        () => Role::Sample,
    }
}

/// Names `T` and `A` mean transmittance and absorbance, unless they stand among other single letters; small ones only
/// where nothing else is a sample.
pub(super) fn is_bare_quantity(name: &str, other_samples: &[&str]) -> bool {
    let all = words(name);
    let Some(letter) = quantity_letter(&all) else { return false };
    let single = |other: &&&str| words(other).first().is_some_and(|word| word.chars().count() == 1);
    let labels = other_samples.iter().filter(single).any(|other| quantity_letter(&words(other)).is_none());
    let others = other_samples.iter().any(|other| quantity_letter(&words(other)).is_none());
    !labels && (!others || !name.contains(letter))
}

/// Words that say that the number behind them is an angle.
const ANGLES: [&str; 6] = ["angle", "angles", "theta", "phi", "incidence", "tilt"];
/// Words that say that the number before them is one.
const DEGREES: [&str; 4] = ["deg", "degree", "degrees", "°"];

/// Whether a column of numbers holds the angle at which each line was measured.
pub(super) fn is_angle(name: &str) -> bool {
    let words = words(name);
    let known = |word: &String| {
        ANGLES.contains(&word.as_str())
            || DEGREES.contains(&word.as_str())
            || ["i", "of"].contains(&word.as_str())
    };
    words.iter().any(|word| ANGLES.contains(&word.as_str())) && words.iter().all(known)
}

/// The angle in degrees that a name says, as `30deg`, `bird 2, 30°`, `theta_15` or `angle=-12.5`; none where it says none, or two.
pub(super) fn angle_in(name: &str) -> Option<f64> {
    let parts = parts(&name.to_lowercase());
    let is = |part: Option<&Part>, known: &[&str]| matches!(part, Some(Part::Word(w)) if known.contains(&w.as_str()));
    let mut found = parts.iter().enumerate().filter_map(|(i, part)| {
        let Part::Number(value) = part else { return None };
        let before = i.checked_sub(1).and_then(|i| parts.get(i));
        // theta_i 30
        let before = if is(before, &["i"]) { i.checked_sub(2).and_then(|i| parts.get(i)) } else { before };
        (is(parts.get(i + 1), &DEGREES) || is(before, &ANGLES)).then_some(*value)
    });
    match (found.next(), found.next()) {
        (Some(angle), None) => Some(angle),
        _ => None,
    }
}

/// A run of letters, or a number.
#[derive(Debug, PartialEq)]
enum Part {
    Word(String),
    Number(f64),
}

/// The words and numbers of a name; a `-` is a sign only where nothing but a blank, a `=`, a `(` or the beginning stands before it.
fn parts(name: &str) -> Vec<Part> {
    let chars: Vec<char> = name.chars().collect();
    let mut parts = Vec::new();
    let mut at = 0;
    while at < chars.len() {
        let start = at;
        let run =
            |at: usize, holds: fn(char) -> bool| at + chars[at..].iter().take_while(|c| holds(**c)).count();
        if chars[at].is_ascii_digit() {
            at = run(at, |c| c.is_ascii_digit());
            if chars.get(at) == Some(&'.') && chars.get(at + 1).is_some_and(char::is_ascii_digit) {
                at = run(at + 1, |c| c.is_ascii_digit());
            }
            let is_sign = start > 0
                && chars[start - 1] == '-'
                && (start == 1 || matches!(chars[start - 2], ' ' | '=' | '(' | '@'));
            let text: String = chars[start..at].iter().collect();
            if let Ok(value) = text.parse::<f64>() {
                parts.push(Part::Number(if is_sign { -value } else { value }));
            }
        } else if chars[at].is_alphabetic() || chars[at] == '°' {
            at = if chars[at] == '°' { at + 1 } else { run(at, char::is_alphabetic) };
            parts.push(Part::Word(chars[start..at].iter().collect()));
        } else {
            at += 1;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_are_whole_words_and_names_of_birds_are_none() {
        for spread in [
            "Standard Deviation",
            "St. Dev.",
            "back Std. Dev.",
            "Standard deviation (%)",
            "StandardDeviation",
            "Deviation",
            "belly deviation",
            "Standard Error of the Mean",
            "Standardabweichung",
            "Abweichung [%]",
            "écart type",
            "ÉCART-TYPE",
            "ecart type",
            "Desviación estándar",
            "dorso desviacion estándar",
            "male SD (n=5)",
            "male SD %",
            "Range",
            "back range (max-min)",
            "range2",
            "N samples",
            "n (birds)",
            "Number of birds",
            "sd",
            "back_sd2",
        ] {
            assert_eq!(role(spread), Role::Beside, "{spread}");
        }
        for sample in [
            "range finch",
            "orange",
            "Orange back",
            "grouse (home range)",
            "St Kilda wren",
            "standard morph",
            "type 2",
            "deviant",
            "n1",
            "samples",
            "Back Mean",
            "male mean (n=5)",
            "(",
            ")(",
            "",
        ] {
            assert_eq!(role(sample), Role::Sample, "{sample}");
        }
        assert_eq!(role("Mean Reflectance (%)"), Role::Mean);
    }

    #[test]
    fn names_say_their_angles() {
        for (name, angle) in [
            ("30deg", Some(30.0)),
            ("30°", Some(30.0)),
            ("bird 2, 12.5 deg", Some(12.5)),
            ("teal_45degrees", Some(45.0)),
            ("theta_15", Some(15.0)),
            ("theta_i=20", Some(20.0)),
            ("Angle-30", Some(30.0)),
            ("angle -30", Some(-30.0)),
            ("phi=-7.5", Some(-7.5)),
            ("-30deg", Some(-30.0)),
            ("K12 -30deg", Some(-30.0)),
            ("bird-30deg", Some(30.0)),
            ("bird30", None),
            ("degree", None),
            ("deg 30", None),
            ("10deg 20deg", None),
            ("R", None),
            ("2024-07-30", None),
        ] {
            assert_eq!(angle_in(name), angle, "{name}");
        }
        assert!(is_angle("angle_deg") && is_angle("theta_i") && is_angle("Angle of incidence"));
        assert!(!is_angle("deg") && !is_angle("angle 30") && !is_angle("bird"));
    }
}
