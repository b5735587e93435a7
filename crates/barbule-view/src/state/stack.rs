//! A stack with thicknesses of one's own: every number of its text is a slider.
//!
//! Numbers stand in the text where the stack language has them: thicknesses behind `:`, their deviations behind `±` or `+-`, counts
//! before `*(`, and the third part of mixtures. A repetition's numbers are one slider for all of its layers.

use std::collections::BTreeMap;

use barbule::error::shortened;
use barbule::fields::shown;
use barbule::material::Library;
use barbule::stack::Stack;
use barbule::structure::{FlatStack, MaterialSource, Structure};
use barbule::{Error, Result};

use super::slider::Slider;
use super::species::unknown;

/// Thicknesses go so far, nm, or to this multiple of what they were at first.
const THICK_NM: f64 = 1000.0;
const TIMES: f64 = 4.0;
/// Deviations in percent go so far.
const MOST_PERCENT: f64 = 33.0;
/// Repetitions go so far, or to the same multiple.
const MOST_COUNT: f64 = 40.0;

/// A stack, and what was moved in it.
#[derive(Debug, Clone)]
pub struct StackSizes {
    /// What it is called: its text as it was typed, or the name of its file.
    name: String,
    library: Library,
    materials: BTreeMap<String, MaterialSource>,
    /// The text between the numbers, one more than there are numbers.
    texts: Vec<String>,
    places: Vec<Place>,
    moved: BTreeMap<String, f64>,
    /// As it is.
    stack: Stack,
}

/// A number of the text.
#[derive(Debug, Clone, PartialEq)]
struct Place {
    what: What,
    /// The medium that it is of; of a count the text that repeats.
    of: String,
    /// The thickness that a deviation is of, nm.
    beside: f64,
    value: f64,
}

/// What a number is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    Thickness,
    Spread,
    SpreadPercent,
    Count,
    Fraction,
}

impl What {
    /// The name of its key, to which its place among its like is added.
    fn key(self) -> &'static str {
        match self {
            Self::Thickness => "thickness_nm",
            Self::Spread => "spread_nm",
            Self::SpreadPercent => "spread_percent",
            Self::Count => "count",
            Self::Fraction => "fraction",
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::Thickness | Self::Spread => "nm",
            Self::SpreadPercent => "%",
            Self::Count | Self::Fraction => "",
        }
    }
}

impl StackSizes {
    /// A stack of the stack language, of these media.
    ///
    /// # Errors
    /// As [`Stack::parse`].
    pub fn of_text(text: &str, library: Library) -> Result<Self> {
        let flat = FlatStack::parse(text, library)?;
        Self::of(flat, text)
    }

    /// A stack that was read from a file; repetitions are written out.
    ///
    /// # Errors
    /// None of a stack that was read.
    pub fn of_flat(flat: FlatStack) -> Result<Self> {
        let text = flat.stack.text();
        Self::of(flat, &text)
    }

    fn of(flat: FlatStack, text: &str) -> Result<Self> {
        let FlatStack { name, stack, library, materials } = flat;
        let (texts, places) = split(text);
        let made = Self { name, library, materials, texts, places, moved: BTreeMap::new(), stack };
        // What is written with the numbers that were read must be the stack that was read.
        let again = Stack::parse(&made.text(), &made.library)?;
        if again != made.stack {
            return Err(Error::machine(format!("{}: is not read as it is written", shortened(&made.name))));
        }
        Ok(made)
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it names media that its own file brings.
    #[must_use]
    pub fn has_own_media(&self) -> bool {
        !self.materials.is_empty()
    }

    /// The stack as it is.
    #[must_use]
    pub fn stack(&self) -> &Stack {
        &self.stack
    }

    /// Its text as it is, with repetitions as they were written.
    #[must_use]
    pub fn text(&self) -> String {
        self.text_with(&self.moved)
    }

    fn text_with(&self, moved: &BTreeMap<String, f64>) -> String {
        let mut text = self.texts[0].clone();
        for ((place, key), rest) in self.places.iter().zip(self.keys()).zip(&self.texts[1..]) {
            text += &shown(moved.get(&key).copied().unwrap_or(place.value));
            text += rest;
        }
        text
    }

    /// The key of each number: what it is, and which of its like.
    fn keys(&self) -> impl Iterator<Item = String> {
        let like = |index: usize| {
            self.places[..index]
                .iter()
                .filter(|place| place.what.key() == self.places[index].what.key())
                .count()
        };
        (0..self.places.len()).map(move |index| format!("{}[{}]", self.places[index].what.key(), like(index)))
    }

    /// What was moved: values by the keys of their sliders.
    #[must_use]
    pub fn moved(&self) -> &BTreeMap<String, f64> {
        &self.moved
    }

    /// Every number of the stack, from the entry side.
    #[must_use]
    pub fn sliders(&self) -> Vec<Slider> {
        let mut layer = 0;
        let sliders = self.places.iter().zip(self.keys()).map(|(place, key)| {
            layer += usize::from(place.what == What::Thickness);
            place.slider(key.clone(), layer, self.moved.get(&key).copied())
        });
        sliders.collect()
    }

    /// Puts numbers in the place of those that were moved before; all others are as they were at first.
    ///
    /// # Errors
    /// There is no such number (the nearest is offered), or they make no stack; then nothing has changed.
    pub fn put(&mut self, moved: &BTreeMap<String, f64>) -> Result<()> {
        let known: Vec<String> = self.keys().collect();
        if let Some(key) = moved.keys().find(|key| !known.contains(key)) {
            return Err(unknown(&shortened(&self.name), key, &known));
        }
        for (slider, value) in self.sliders().iter().filter_map(|s| Some((s, *moved.get(&s.key)?))) {
            let [low, high] = slider.range;
            if !(low..=high).contains(&value) || (slider.whole && value.fract() != 0.0) {
                let whole = if slider.whole { "a whole number " } else { "" };
                return Err(Error::input(format!(
                    "{} of {} is {}; give {whole}from {} to {}",
                    slider.key,
                    shortened(&self.name),
                    slider.words(value),
                    shown(low),
                    slider.words(high)
                )));
            }
        }
        let stack = Stack::parse(&self.text_with(moved), &self.library)?;
        let places = self.places.iter().zip(&known);
        let kept = places.filter_map(|(place, key)| {
            moved.get(key).filter(|value| **value != place.value).map(|value| (key.clone(), *value))
        });
        self.moved = kept.collect();
        self.stack = stack;
        Ok(())
    }

    /// The stack as a flat barbule.
    ///
    /// # Errors
    /// It is over 1 mm thick.
    pub fn structure(&self) -> Result<Structure> {
        let name = if self.moved.is_empty() { self.name.clone() } else { self.text() };
        let (library, materials) = (self.library.clone(), self.materials.clone());
        FlatStack { name, stack: self.stack.clone(), library, materials }.structure()
    }
}

impl Place {
    fn slider(&self, key: String, layer: usize, moved: Option<f64>) -> Slider {
        let of = shortened(&self.of);
        let (name, about, range) = match self.what {
            What::Thickness => (
                format!("{layer}: {of}"),
                format!("Thickness of {of}, layer {layer} as the stack is written."),
                [0.0, THICK_NM.max(TIMES * self.value)],
            ),
            What::Spread | What::SpreadPercent => (
                format!("{layer}: {of} ±"),
                format!("Standard deviation of this thickness between individuals, layer {layer}."),
                [0.0, if self.what == What::Spread { self.beside } else { MOST_PERCENT.max(self.value) }],
            ),
            What::Count => (
                format!("times {of}"),
                format!("How often {of} follows itself."),
                [1.0, MOST_COUNT.max(TIMES * self.value)],
            ),
            What::Fraction => {
                (format!("part in {of}"), format!("The part that the second medium has in {of}."), [0.0, 1.0])
            }
        };
        Slider {
            key,
            name,
            about,
            unit: self.what.unit(),
            range,
            whole: self.what == What::Count,
            default: self.value,
            value: moved.unwrap_or(self.value),
        }
    }
}

/// What brackets are open, while a text is read.
enum Open {
    /// Those of a mixture, which began there, and how many commas it had.
    Mixture { from: usize, commas: usize },
    /// Those of a repetition or of anything else.
    Other,
}

/// A text's numbers that stand where the stack language has some, and what is between them.
fn split(text: &str) -> (Vec<String>, Vec<Place>) {
    let mut found: Vec<(usize, usize, Place)> = Vec::new();
    let (mut open, mut item) = (Vec::new(), 0);
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let after = at + c.len_utf8();
        let rest = &text[after..];
        let mut add = |what, of: &str, beside, from: usize, to: usize| {
            if let Ok(value) = text[from..to].parse::<f64>() {
                found.push((from, to, Place { what, of: of.trim().to_owned(), beside, value }));
            }
        };
        match c {
            '/' => item = after,
            '(' => {
                let before = text[item..at].trim_end();
                if before.ends_with("mix") {
                    open.push(Open::Mixture { from: item + before.len() - "mix".len(), commas: 0 });
                } else {
                    if let Some(count) = before.strip_suffix('*') {
                        let from = item + count.len() - count.trim_start().len();
                        let inside = closing(rest).map_or(rest, |end| &rest[..end]);
                        add(What::Count, inside, 0.0, from, from + count.trim().len());
                    }
                    open.push(Open::Other);
                    item = after;
                }
            }
            ')' => {
                open.pop();
            }
            ',' => {
                if let Some(Open::Mixture { from, commas }) = open.last_mut() {
                    *commas += 1;
                    if let (2, Some((start, end))) = (*commas, number(text, after)) {
                        let to = closing(rest).map_or(text.len(), |end| after + end + 1);
                        add(What::Fraction, &text[*from..to], 0.0, start, end);
                    }
                }
            }
            ':' => {
                if let Some((start, end)) = number(text, after) {
                    add(What::Thickness, &text[item..at], 0.0, start, end);
                    let medium = text[item..at].to_owned();
                    let thickness = text[start..end].parse().unwrap_or_default();
                    if let Some((start, end)) = deviation(text, end) {
                        let is_percent = text[end..].trim_start().starts_with('%');
                        let what = if is_percent { What::SpreadPercent } else { What::Spread };
                        add(what, &medium, thickness, start, end);
                    }
                }
            }
            _ => {}
        }
        at = after;
    }
    found.sort_by_key(|(from, ..)| *from);
    let (mut texts, mut done) = (Vec::new(), 0);
    for (from, to, _) in &found {
        texts.push(text[done..*from].to_owned());
        done = *to;
    }
    texts.push(text[done..].to_owned());
    (texts, found.into_iter().map(|(.., place)| place).collect())
}

/// Where a number begins and ends that follows a place of a text, perhaps after blanks.
fn number(text: &str, from: usize) -> Option<(usize, usize)> {
    let rest = &text[from..];
    let start = from + rest.len() - rest.trim_start().len();
    let mut end = start;
    for (offset, c) in text[start..].char_indices() {
        let is_sign = matches!(c, '+' | '-') && text[start..start + offset].ends_with(['e', 'E']);
        let is_exponent = matches!(c, 'e' | 'E') && offset > 0;
        if !(c.is_ascii_digit() || c == '.' || is_sign || is_exponent) {
            break;
        }
        end = start + offset + c.len_utf8();
    }
    (end > start).then_some((start, end))
}

/// The number behind `±` or `+-` that follows a place of a text.
fn deviation(text: &str, from: usize) -> Option<(usize, usize)> {
    let rest = &text[from..];
    let blank = rest.len() - rest.trim_start().len();
    let sign = ["±", "+-"].into_iter().find(|sign| rest.trim_start().starts_with(sign))?;
    number(text, from + blank + sign.len())
}

/// How far the bracket lies that closes one which is open before a text.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' if depth == 0 => return Some(at),
            ')' => depth -= 1,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(text: &str) -> StackSizes {
        StackSizes::of_text(text, Library::builtin()).unwrap()
    }

    fn keys(sizes: &StackSizes) -> Vec<(String, f64)> {
        sizes.sliders().into_iter().map(|slider| (slider.key, slider.value)).collect()
    }

    #[test]
    fn every_number_of_a_stack_is_a_slider() {
        let sizes =
            opened("air / 6*( melanin:99±5% / mix(keratin,air,0.25): 100 +- 3 ) /1.56+0.02j:30/keratin");
        let expected = [
            ("count[0]", 6.0),
            ("thickness_nm[0]", 99.0),
            ("spread_percent[0]", 5.0),
            ("fraction[0]", 0.25),
            ("thickness_nm[1]", 100.0),
            ("spread_nm[0]", 3.0),
            ("thickness_nm[2]", 30.0),
        ];
        assert_eq!(keys(&sizes), expected.map(|(key, value)| (key.to_owned(), value)));
        let sliders = sizes.sliders();
        assert_eq!(
            (sliders[1].name.as_str(), sliders[1].unit, sliders[1].range),
            ("1: melanin", "nm", [0.0, 1000.0])
        );
        assert_eq!(sliders[4].name, "2: mix(keratin,air,0.25)");
        assert_eq!((sliders[5].range, sliders[5].unit), ([0.0, 100.0], "nm"));
        assert!(sliders[0].whole && sliders[0].range == [1.0, 40.0]);
        assert_eq!(keys(&opened("air/keratin")), []);
        assert_eq!(keys(&opened("air/keratin:1.5e2/air"))[0].1, 150.0);
        let nested = opened("air/2*(3*(1.5:10/keratin:20)/mix(mix(keratin,air,0.5),melanin,0.1):30)/1.5");
        let expected = [
            ("count[0]", 2.0),
            ("count[1]", 3.0),
            ("thickness_nm[0]", 10.0),
            ("thickness_nm[1]", 20.0),
            ("fraction[0]", 0.5),
            ("fraction[1]", 0.1),
            ("thickness_nm[2]", 30.0),
        ];
        assert_eq!(keys(&nested), expected.map(|(key, value)| (key.to_owned(), value)));
    }

    #[test]
    fn moved_numbers_make_another_stack_whose_text_is_read_as_it() {
        let mut sizes = opened("air/6*(melanin:99/keratin:100)/keratin");
        let moved = BTreeMap::from([("count[0]".to_owned(), 4.0), ("thickness_nm[1]".to_owned(), 120.5)]);
        sizes.put(&moved).unwrap();
        assert_eq!(sizes.text(), "air/4*(melanin:99/keratin:120.5)/keratin");
        assert_eq!((sizes.stack().layers(), sizes.stack().thickness_nm()[7]), (8, 120.5));
        assert_eq!(sizes.structure().unwrap().name(), sizes.text());
        assert_eq!(sizes.moved(), &moved);
        // Back where it was nothing is moved.
        sizes.put(&BTreeMap::from([("thickness_nm[1]".to_owned(), 100.0)])).unwrap();
        assert!(sizes.moved().is_empty());
        assert_eq!(sizes.text(), "air/6*(melanin:99/keratin:100)/keratin");
    }

    #[test]
    fn what_is_no_number_of_the_stack_is_refused_and_changes_nothing() {
        let mut sizes = opened("air/3*(melanin:99±5/keratin:100)/keratin");
        let before = sizes.text();
        for (key, value, words) in [
            ("thicknes_nm[0]", 50.0, "has no size 'thicknes_nm[0]', did you mean 'thickness_nm[0]'?"),
            (
                "thickness_nm[0]",
                -5.0,
                "thickness_nm[0] of air/3*(melanin:99±5/keratin:100)/keratin is -5 nm; give from 0 to 1000 nm",
            ),
            (
                "count[0]",
                2.5,
                "count[0] of air/3*(melanin:99±5/keratin:100)/keratin is 2.5; give a whole number from 1 to 40",
            ),
            ("thickness_nm[0]", f64::NAN, "is NaN nm; give"),
            // Thinner than its own deviation.
            ("thickness_nm[0]", 2.0, "the spread of 5 nm is not usable"),
        ] {
            let refused = sizes.put(&BTreeMap::from([(key.to_owned(), value)])).unwrap_err();
            assert!(refused.is_input() && refused.to_string().contains(words), "{refused}");
            assert_eq!((sizes.text(), sizes.moved().len()), (before.clone(), 0));
        }
    }
}
