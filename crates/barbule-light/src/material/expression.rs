//! Media as people write them: a name, `mix(a, b, fraction[, rule])`, or an index such as `1.56+0.02j`.

use super::{Library, Material, Rule};
use crate::error::shortened;
use crate::{Complex64, Error, Result};

/// Reads one medium.
///
/// - a name of the library
/// - `mix(a,b,0.4)`: 40 % of the volume is b; a fourth word names the [`Rule`]
/// - a bare index: `1.5`, `1.56+0.02j`
///
/// # Errors
/// Not such an expression, an unknown name, a fraction outside 0 to 1, gain, or mixtures nested over 16 deep.
pub fn parse(text: &str, library: &Library) -> Result<Material> {
    medium(text.trim(), library, 0)
}

fn medium(text: &str, library: &Library, depth: usize) -> Result<Material> {
    let text = text.trim();
    if depth > 16 {
        return Err(Error::input("mixtures are nested more than 16 deep"));
    }
    if text.is_empty() {
        return Err(Error::input(
            "a medium is missing; write a name such as keratin, or an index such as 1.5",
        ));
    }
    if let Some(rest) = text.strip_prefix("mix").map(str::trim_start).filter(|r| r.starts_with('(')) {
        let Some(inside) = rest.strip_prefix('(').and_then(|r| r.strip_suffix(')')) else {
            return Err(Error::input(format!("'{}': the closing bracket is missing", shortened(text))));
        };
        return mixture(text, inside, library, depth);
    }
    if text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.')) {
        return Material::constant(index(text)?);
    }
    if !is_name(text) {
        return Err(Error::input(format!(
            "'{}' is not a medium; write a name, mix(keratin,melanin,0.4) or an index such as 1.56+0.02j",
            shortened(text)
        )));
    }
    library.get(text).cloned()
}

fn mixture(text: &str, inside: &str, library: &Library, depth: usize) -> Result<Material> {
    let parts = split_top(inside);
    let (a, b, fraction, rule) = match parts[..] {
        [a, b, fraction] => (a, b, fraction, Rule::Linear),
        [a, b, fraction, rule] => (a, b, fraction, Rule::named(rule.trim())?),
        _ => {
            return Err(Error::input(format!(
                "'{}': a mixture is mix(medium,medium,fraction), with the rule as an optional fourth word",
                shortened(text)
            )));
        }
    };
    let fraction = fraction.trim().parse::<f64>().map_err(|_| {
        Error::input(format!("'{}': the fraction '{}' is not a number", shortened(text), shortened(fraction)))
    })?;
    Material::mixture(medium(a, library, depth + 1)?, medium(b, library, depth + 1)?, fraction, rule)
}

/// Splits at the commas that are outside brackets.
fn split_top(text: &str) -> Vec<&str> {
    let mut depth = 0_i32;
    text.split(|c: char| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == ',' && depth == 0
    })
    .collect()
}

/// A complex number `a`, `a+bj`, `a-bj` or `bj`.
fn index(text: &str) -> Result<Complex64> {
    let refuse = || {
        Error::input(format!("'{}' is not an index; write for example 1.5 or 1.56+0.02j", shortened(text)))
    };
    let number = |t: &str| {
        let plain = t.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b'e' | b'E'));
        t.parse::<f64>().ok().filter(|_| plain).ok_or_else(refuse)
    };
    let Some(body) = text.strip_suffix('j') else { return Ok(number(text)?.into()) };
    // The sign between the parts: the last one that neither starts the text nor belongs to an exponent.
    let bytes = body.as_bytes();
    let split = (1..bytes.len())
        .rev()
        .find(|&i| matches!(bytes[i], b'+' | b'-') && !matches!(bytes[i - 1], b'e' | b'E'));
    match split {
        Some(at) => Ok(Complex64::new(number(body[..at].trim())?, number(body[at..].trim())?)),
        None => Ok(Complex64::new(0.0, number(body)?)),
    }
}

/// Whether a word can name a medium.
pub(super) fn is_name(text: &str) -> bool {
    let mut letters = text.chars();
    letters.next().is_some_and(char::is_alphabetic)
        && letters.all(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | '.'))
        && text.chars().count() <= 64
        && text != "mix"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_500(text: &str) -> Complex64 {
        parse(text, &Library::builtin()).unwrap().index(500.0).unwrap()
    }

    fn refused(text: &str) -> String {
        let error = parse(text, &Library::builtin()).unwrap_err();
        assert!(error.is_input());
        assert!(error.to_string().len() < 600, "{error}");
        error.to_string()
    }

    #[test]
    fn the_three_forms_are_read() {
        assert_eq!(at_500("1.56+0.02j"), Complex64::new(1.56, 0.02));
        assert_eq!(at_500("1.5"), Complex64::new(1.5, 0.0));
        assert_eq!(at_500("1.5e0+2e-3j"), Complex64::new(1.5, 2e-3));
        assert_eq!(at_500("3j"), Complex64::new(0.0, 3.0));
        let (k, m) = (at_500("keratin"), at_500("melanin"));
        assert!((at_500("mix(keratin, melanin, 0.4)") - (k * 0.6 + m * 0.4)).norm() < 1e-15);
        let nested = at_500("mix(mix(keratin,air,0.5),melanin,0.5)");
        assert!((nested - ((k + 1.0) * 0.25 + m * 0.5)).norm() < 1e-15);
        assert!(at_500("mix(keratin,melanin,0.4,bruggeman)") != at_500("mix(keratin,melanin,0.4)"));
    }

    #[test]
    fn what_is_wrong_is_said() {
        assert!(refused("").contains("missing"));
        assert!(refused("keratine").contains("did you mean 'keratin'"));
        assert!(refused("1.5-0.1j").contains("gain"));
        assert!(refused("1.5+0.1i").contains("is not an index"));
        assert!(refused("-1.5").contains("not usable"));
        assert!(refused("mix(keratin,melanin)").contains("a mixture is mix("));
        assert!(refused("mix(keratin,melanin,2)").contains("outside 0 to 1"));
        assert!(refused("mix(keratin,melanin,x)").contains("fraction 'x'"));
        assert!(refused("mix(keratin,melanin,0.5,cubic)").contains("no mixing rule 'cubic'"));
        assert!(refused("mix(keratin,melanin,0.5").contains("closing bracket"));
        assert!(refused("$$$").contains("is not a medium"));
        assert!(refused("1e999").contains("not usable"));
        assert!(refused(&("mix(".repeat(100_000))).contains("closing bracket"));
        let deep = format!("{}air{}", "mix(".repeat(100), ",air,0.5)".repeat(100));
        assert!(refused(&deep).contains("nested more than 16"));
    }
}
