//! Stacks with places for numbers that are to be found: `air/keratin:?/air`, `air/5*(melanin:40..200/keratin:?)/mix(keratin,air,?)`.
//!
//! Where the stack language has a thickness, the deviation of one after `±`, the fraction of a mixture or a medium, `?` or `LOW..HIGH` may
//! stand. What stands inside a repetition is one number for all of its layers.

use super::Parameter;
use crate::error::shortened;
use crate::material::Library;
use crate::stack::Stack;
use crate::{Error, Result};

/// What a place holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Thickness,
    Spread,
    Fraction,
    Index,
}

impl Place {
    /// What `?` means, beside the range of thicknesses.
    fn usual(self, thickness_nm: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Thickness => thickness_nm,
            Self::Spread => [0.0, 60.0],
            Self::Fraction => [0.0, 1.0],
            Self::Index => [1.3, 1.8],
        }
    }

    /// What the stack language takes there.
    fn allowed(self) -> [f64; 2] {
        match self {
            Self::Thickness | Self::Spread => [0.0, 100_000.0],
            Self::Fraction => [0.0, 1.0],
            Self::Index => [1.0, 5.0],
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::Thickness | Self::Spread => "nm",
            Self::Fraction | Self::Index => "",
        }
    }
}

/// A stack whose numbers are partly unknown.
#[derive(Debug, Clone)]
pub(super) struct Template {
    /// The text between the places, one more than there are places.
    texts: Vec<String>,
    pub(super) places: Vec<Place>,
    pub(super) parameters: Vec<Parameter>,
}

impl Template {
    /// Reads a stack with places; `usual_nm` is the range of a thickness that is only `?`.
    ///
    /// # Errors
    /// No place, too many of them, a range that falls or is out of what is allowed, or no stack once numbers stand in their places.
    pub(super) fn parse(text: &str, usual_nm: [f64; 2], library: &Library) -> Result<Self> {
        let mut template = Self { texts: Vec::new(), places: Vec::new(), parameters: Vec::new() };
        let mut done = 0;
        let mut media = Vec::new();
        for (from, to, before) in words(text) {
            let word = &text[from..to];
            let Some(place) = place_of(before, word) else { continue };
            if text[..from].trim().is_empty() {
                return Err(Error::input(format!(
                    "{}: the first medium is the one that the light comes through and must be known; name it, as in air/keratin:?/air",
                    shortened(text)
                )));
            }
            let [low, high] = range_of(word, place, usual_nm).map_err(|e| e.at(shortened(text)))?;
            // No deviation is larger than the thickness.
            let thinnest = template.parameters.last().filter(|_| before == '±' && follows(&text[done..from]));
            let high = match thinnest {
                Some(thickness) if word == "?" => high.min(thickness.low),
                _ => high,
            };
            template.texts.push(text[done..from].to_owned());
            done = to;
            media.push(medium_before(&text[..from]));
            template.places.push(place);
            template.parameters.push(Parameter { name: String::new(), unit: place.unit().into(), low, high });
        }
        template.texts.push(text[done..].to_owned());
        if template.places.is_empty() {
            return Err(Error::input(format!(
                "{}: nothing in it is to be found; write ? or LOW..HIGH in place of a number, as in air/keratin:?/air or air/keratin:200..900/melanin",
                shortened(text)
            )));
        }
        if template.places.len() > super::MOST_PARAMETERS {
            return Err(Error::input(format!(
                "{}: {} numbers are to be found, over the limit of {}; what a spectrum says does not decide as many",
                shortened(text),
                template.places.len(),
                super::MOST_PARAMETERS
            )));
        }
        template.name(&media);
        // In the middle, at both ends, and with the widest spread of the thinnest layers, so that whatever is wrong is said before any work.
        for part in [0.5, 0.0, 1.0] {
            template.stack(&template.sizes(|_| part), library)?;
        }
        template.stack(&template.sizes(|place| f64::from(u8::from(place == Place::Spread))), library)?;
        Ok(template)
    }

    /// Names the places by what they are and, where several are alike, by their media.
    fn name(&mut self, media: &[String]) {
        for (k, (&place, medium)) in self.places.iter().zip(media).enumerate() {
            let alone = self.places.iter().filter(|other| **other == place).count() == 1;
            let name = match (place, alone) {
                (Place::Thickness, true) => "thickness_nm".to_owned(),
                (Place::Spread, true) => "spread_nm".to_owned(),
                (Place::Fraction, true) => "fraction".to_owned(),
                (Place::Index, true) => "index".to_owned(),
                (Place::Thickness, false) => format!("{medium}_nm"),
                (Place::Spread, false) => format!("{medium}_spread_nm"),
                (Place::Fraction, false) => "fraction".to_owned(),
                (Place::Index, false) => "index".to_owned(),
            };
            let stem = name.clone();
            let taken = |name: &str, done: &[Parameter]| done.iter().any(|p| p.name == name);
            let numbered = (2..).map(|n| match stem.strip_suffix("_nm") {
                Some(medium) => format!("{medium}_{n}_nm"),
                None => format!("{stem}_{n}"),
            });
            let done = &self.parameters[..k];
            let free = std::iter::once(name).chain(numbered).find(|name| !taken(name, done));
            self.parameters[k].name = free.unwrap_or_default();
        }
    }

    /// Sizes at these parts of their ranges.
    pub(super) fn sizes(&self, part: impl Fn(Place) -> f64) -> Vec<f64> {
        let at = |(place, p): (&Place, &Parameter)| p.low + part(*place) * (p.high - p.low);
        self.places.iter().zip(&self.parameters).map(at).collect()
    }

    /// The stack's text with these numbers.
    pub(super) fn text(&self, sizes: &[f64]) -> String {
        let numbers = sizes.iter().map(f64::to_string).chain([String::new()]);
        self.texts.iter().zip(numbers).map(|(text, number)| format!("{text}{number}")).collect()
    }

    /// The stack with these numbers.
    pub(super) fn stack(&self, sizes: &[f64], library: &Library) -> Result<Stack> {
        Stack::parse(&self.text(sizes), library)
    }
}

/// Words of a stack's text with their places and what stands before each: `:`, `±`, `,`, or else a slash or bracket.
fn words(text: &str) -> Vec<(usize, usize, char)> {
    let mut words = Vec::new();
    let (mut start, mut before) = (None::<usize>, '/');
    let mut letters = text.char_indices().peekable();
    while let Some((at, letter)) = letters.next() {
        let after = letters.peek().map(|(_, next)| *next);
        let spread = letter == '±' || (letter == '+' && after == Some('-'));
        if spread || letter.is_whitespace() || "/:,()*%".contains(letter) {
            if let Some(from) = start.take() {
                words.push((from, at, before));
            }
            if !letter.is_whitespace() {
                before = if spread { '±' } else { letter };
            }
            if letter == '+' {
                letters.next();
            }
        } else {
            start.get_or_insert(at);
        }
    }
    words.extend(start.map(|from| (from, text.len(), before)));
    words
}

/// Whether nothing but the sign of a deviation stands between a thickness and what follows.
fn follows(between: &str) -> bool {
    matches!(between.trim(), "±" | "+-")
}

fn place_of(before: char, word: &str) -> Option<Place> {
    if word != "?" && !word.contains("..") {
        return None;
    }
    Some(match before {
        ':' => Place::Thickness,
        '±' => Place::Spread,
        ',' => Place::Fraction,
        _ => Place::Index,
    })
}

fn range_of(word: &str, place: Place, usual_nm: [f64; 2]) -> Result<[f64; 2]> {
    let Some((low, high)) = word.split_once("..") else { return Ok(place.usual(usual_nm)) };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    let [least, most] = place.allowed();
    match (number(low), number(high)) {
        (Some(low), Some(high)) if low < high && low >= least && high <= most => Ok([low, high]),
        _ => Err(Error::input(format!(
            "'{}' is not a range; write LOW..HIGH within {least} to {most}, the lower number first, as in 200..900",
            shortened(word)
        ))),
    }
}

/// What the layer before a colon is made of, as a part of a name.
fn medium_before(text: &str) -> String {
    let item = text.rsplit(['/', '(']).next().unwrap_or_default();
    let medium = item.split(':').next().unwrap_or_default();
    let name: String =
        medium.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '-').take(24).collect();
    if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) { "layer".into() } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Template> {
        Template::parse(text, [50.0, 3000.0], &Library::builtin())
    }

    fn names(text: &str) -> Vec<String> {
        read(text).unwrap().parameters.iter().map(|p| p.name.clone()).collect()
    }

    #[test]
    fn places_are_found_and_named() {
        assert_eq!(names("air/keratin:?/air"), ["thickness_nm"]);
        assert_eq!(names("air/keratin: 200..900 +- ? /melanin"), ["thickness_nm", "spread_nm"]);
        assert_eq!(
            names("air/keratin:?±?/melanin:50..100±5%/air"),
            ["keratin_nm", "spread_nm", "melanin_nm"]
        );
        assert_eq!(
            names("air/5*(melanin:?/keratin:?/melanin:?)/air"),
            ["melanin_nm", "keratin_nm", "melanin_2_nm"]
        );
        assert_eq!(names("air/mix(keratin,air,?):?/1.4..1.7"), ["fraction", "thickness_nm", "index"]);
        assert_eq!(
            names("air/1.5..1.6:?/1.5+0.1j:?/1.2..1.3"),
            ["index", "layer_nm", "layer_2_nm", "index_2"]
        );
        let template = read("air/keratin:200..900±?/mix(keratin,air,0.1..0.2)").unwrap();
        let range = |k: usize| [template.parameters[k].low, template.parameters[k].high];
        assert_eq!([range(0), range(1), range(2)], [[200.0, 900.0], [0.0, 60.0], [0.1, 0.2]]);
        assert_eq!(read("air/keratin:? ± ?/air").unwrap().parameters[1].high, 50.0);
        assert_eq!(template.text(&[321.5, 12.0, 0.15]), "air/keratin:321.5±12/mix(keratin,air,0.15)");
    }

    #[test]
    fn what_is_no_template_is_refused() {
        for (text, part) in [
            ("air/keratin:300/air", "nothing in it is to be found"),
            ("air/keratin:900..200/air", "'900..200' is not a range"),
            ("air/keratin:-5..200/air", "is not a range"),
            ("air/keratin:a..b/air", "is not a range"),
            ("air/mix(keratin,air,0.5..2):300/air", "within 0 to 1"),
            ("air/keratine:?/air", "did you mean 'keratin'"),
            ("air/7*(1:?/1:?/1:?/1:?/1:?/1:?/1:?)/air", "7 numbers are to be found"),
            ("?/keratin:?/air", "the first medium"),
            ("air/keratin:20..50±0..30/air", "the spread of 30 nm"),
            ("air/keratin:?", "half-space without thickness"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(part) && message.len() < 600, "{text}: {message}");
        }
    }
}
