//! Planar stacks of layers, and the language people write them in.
//!
//! ```text
//! stack  = item ("/" item)*               first and last item: half-spaces, without thickness
//! item   = medium [":" thickness] | count "*(" item ("/" item)* ")"
//! thickness = nm [("±" | "+-") (nm | percent "%")]      the standard deviation between individuals
//! medium = name | "mix(" medium "," medium "," fraction ["," rule] ")" | index such as 1.56+0.02j
//! ```

use std::collections::HashMap;

use crate::error::shortened;
use crate::identity::{Hasher, Identify};
use crate::material::{self, Library, Material};
use crate::math::rng::Stream;
use crate::{Complex64, Error, Result};

/// No stack has more layers than this once its repetitions are written out.
pub const MOST_LAYERS: usize = 100_000;
/// Repetitions within repetitions go no deeper than this.
pub const DEEPEST_REPETITION: usize = 32;
/// A layer thicker than this (1 m) is a slip, and its phase would have no correct digit.
const THICKEST_NM: f64 = 1e9;
/// Layers thinner than this are no layers of molecules: micrometres were meant.
const THINNEST_USUAL_NM: f64 = 1.0;
/// Random thicknesses stay within so many standard deviations of the mean.
pub const CLIP: f64 = 3.0;
/// No random layer is thinner than this part of its mean.
const LEAST_PART: f64 = 1e-3;

/// Homogeneous layers between two half-spaces; their thicknesses may differ between individuals.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// The distinct media, each with the text that names it.
    media: Vec<(String, Material)>,
    /// The medium of each region from the entry to the exit half-space, as a place in `media`.
    order: Vec<u32>,
    /// The mean thickness of each layer: two fewer than `order`.
    thickness_nm: Vec<f64>,
    /// The standard deviation of each layer's thickness between individuals.
    spread_nm: Vec<f64>,
}

/// One part of a stack as it is written: a layer, or a group of parts that repeats.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// A homogeneous layer.
    Layer {
        /// The medium's name or expression.
        medium: String,
        /// The mean thickness in nm.
        thickness_nm: f64,
        /// The standard deviation of the thickness between individuals in nm; 0: all are alike.
        spread_nm: f64,
    },
    /// Parts that follow each other `count` times.
    Repeat {
        /// How many times, at least 1.
        count: usize,
        /// The repeated parts, at least one.
        parts: Vec<Part>,
    },
}

impl Stack {
    /// Reads the stack language, for example `air/6*(melanin:99/keratin:100)/air`.
    ///
    /// # Errors
    /// Not that language, unknown media, a thickness that is missing, negative or over 1 m, over
    /// [`MOST_LAYERS`] layers, or repetitions nested over [`DEEPEST_REPETITION`] deep.
    pub fn parse(text: &str, library: &Library) -> Result<Self> {
        let items = split_items(text)?;
        let [entry, layers @ .., exit] = &items[..] else {
            return Err(Error::input(format!(
                "'{}' is no stack; write at least two media with / between them, as in air/keratin:595/air",
                shortened(text)
            )));
        };
        let mut parts = Vec::with_capacity(layers.len().min(MOST_LAYERS));
        for item in layers {
            parts.push(part(item, 0)?);
        }
        Self::from_parts(half_space(entry, "first")?, &parts, half_space(exit, "last")?, library)
    }

    /// A stack from its parts; media are names or expressions as [`material::parse`] reads them.
    ///
    /// # Errors
    /// As [`Stack::parse`].
    pub fn from_parts(entry: &str, parts: &[Part], exit: &str, library: &Library) -> Result<Self> {
        let mut builder = Builder { library, media: Vec::new(), known: HashMap::new() };
        let mut layers = Vec::new();
        let first = builder.medium(entry)?;
        builder.expand(parts, 0, &mut layers)?;
        let last = builder.medium(exit)?;
        let mut order = Vec::with_capacity(layers.len() + 2);
        order.push(first);
        order.extend(layers.iter().map(|layer| layer.medium));
        order.push(last);
        let thickness_nm = layers.iter().map(|layer| layer.thickness_nm).collect();
        let spread_nm = layers.iter().map(|layer| layer.spread_nm).collect();
        Ok(Self { media: builder.media, order, thickness_nm, spread_nm })
    }

    /// A stack from materials: `layers` are (material, thickness in nm) from the entry side.
    ///
    /// # Errors
    /// A thickness that is negative or over 1 m, or over [`MOST_LAYERS`] layers.
    pub fn new(entry: Material, layers: &[(Material, f64)], exit: Material) -> Result<Self> {
        if layers.len() > MOST_LAYERS {
            return Err(too_many());
        }
        let mut media: Vec<(String, Material)> = Vec::new();
        let mut place = |material: &Material| {
            let at = media.iter().position(|(_, known)| known == material).unwrap_or_else(|| {
                media.push((format!("medium {}", media.len() + 1), material.clone()));
                media.len() - 1
            });
            at as u32
        };
        let mut order = vec![place(&entry)];
        let mut thickness_nm = Vec::with_capacity(layers.len());
        for (i, (material, thickness)) in layers.iter().enumerate() {
            thickness_nm.push(checked_thickness(*thickness).map_err(|e| e.at(format!("layer {}", i + 1)))?);
            order.push(place(material));
        }
        order.push(place(&exit));
        let spread_nm = vec![0.0; thickness_nm.len()];
        Ok(Self { media, order, thickness_nm, spread_nm })
    }

    /// How many layers lie between the half-spaces.
    #[must_use]
    pub fn layers(&self) -> usize {
        self.thickness_nm.len()
    }

    /// The mean thickness of each layer in nm, from the entry side.
    #[must_use]
    pub fn thickness_nm(&self) -> &[f64] {
        &self.thickness_nm
    }

    /// The standard deviation of each layer's thickness between individuals in nm, from the entry side.
    #[must_use]
    pub fn spread_nm(&self) -> &[f64] {
        &self.spread_nm
    }

    /// Whether individuals differ.
    #[must_use]
    pub fn is_random(&self) -> bool {
        self.spread_nm.iter().any(|spread| *spread > 0.0)
    }

    /// The same with another mean thickness of one layer, from 0 at the entry side.
    ///
    /// # Errors
    /// The thickness is negative or over 1 m.
    ///
    /// # Panics
    /// There is no such layer.
    pub fn with_thickness(&self, layer: usize, nm: f64) -> Result<Self> {
        let mut stack = self.clone();
        stack.thickness_nm[layer] =
            checked_thickness(nm).map_err(|e| e.at(format!("layer {}", layer + 1)))?;
        Ok(stack)
    }

    /// Individual number `index`, a stack without spread: every layer's thickness is normal about its mean, within ±3
    /// standard deviations and at least a thousandth of the mean. The same seed and index give the same bits everywhere.
    #[must_use]
    pub fn individual(&self, seed: u64, index: usize) -> Self {
        let mut stream = Stream::new(seed, &[index as u64]);
        let draw = |(mean, spread): (&f64, &f64)| {
            let deviate = stream.normal().clamp(-CLIP, CLIP);
            (mean + spread * deviate).max(LEAST_PART * mean)
        };
        let thickness_nm = self.thickness_nm.iter().zip(&self.spread_nm).map(draw).collect();
        Self { thickness_nm, spread_nm: vec![0.0; self.spread_nm.len()], ..self.clone() }
    }

    /// The stack in its language, repetitions written out; what [`Stack::parse`] reads as the same stack.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = self.medium(0).to_owned();
        for (layer, (thickness, spread)) in self.thickness_nm.iter().zip(&self.spread_nm).enumerate() {
            text += &format!("/{}:{thickness}", self.medium(layer + 1));
            if *spread > 0.0 {
                text += &format!("±{spread}");
            }
        }
        text + "/" + self.medium(self.layers() + 1)
    }

    /// What is doubtful about the stack, in one sentence: a layer under 1 nm, where micrometres may have been meant.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        let thin = |nm: &f64| *nm > 0.0 && *nm < THINNEST_USUAL_NM;
        let layer = self.thickness_nm.iter().position(thin)?;
        let (nm, medium) = (self.thickness_nm[layer], shortened(self.medium(layer + 1)));
        // `:?` writes what is very small with an exponent.
        let said = format!("{medium}:{nm:?} is {nm:?} nm thick; thicknesses are in nm");
        // Rounded, since 1000 times a decimal fraction need not be a whole number.
        let in_um = (nm * 1e9).round() / 1e6;
        Some(if in_um < THINNEST_USUAL_NM { said } else { format!("{said}: did you mean {in_um}?") })
    }

    /// The text that names the medium of a region: 0 is the entry half-space, `layers() + 1` the exit.
    #[must_use]
    pub fn medium(&self, region: usize) -> &str {
        &self.media[self.order[region] as usize].0
    }

    /// The refractive index of every region at a wavelength in nm, from the entry to the exit half-space.
    ///
    /// # Errors
    /// A medium has no index at this wavelength, or the entry medium absorbs.
    pub fn indices(&self, wavelength_nm: f64) -> Result<Vec<Complex64>> {
        let mut of_media = Vec::with_capacity(self.media.len());
        for (name, material) in &self.media {
            of_media.push(material.index(wavelength_nm).map_err(|e| e.at(shortened(name)))?);
        }
        let entry = of_media[self.order[0] as usize];
        if entry.im != 0.0 || entry.re == 0.0 {
            return Err(Error::input(format!(
                "the first medium '{}' absorbs (k = {} at {wavelength_nm} nm), so reflectance is undefined there; start the stack with a lossless medium",
                shortened(self.medium(0)),
                entry.im
            )));
        }
        Ok(self.order.iter().map(|&medium| of_media[medium as usize]).collect())
    }
}

impl Identify for Stack {
    fn feed(&self, to: &mut Hasher) {
        let Self { media, order, thickness_nm, spread_nm } = self;
        to.list("regions", order.iter().map(|&place| &media[place as usize].1))
            .numbers("thickness_nm", thickness_nm)
            .numbers("spread_nm", spread_nm);
    }
}

/// A layer as it is written out.
#[derive(Debug, Clone, Copy)]
struct Written {
    medium: u32,
    thickness_nm: f64,
    spread_nm: f64,
}

struct Builder<'a> {
    library: &'a Library,
    media: Vec<(String, Material)>,
    known: HashMap<String, u32>,
}

impl Builder<'_> {
    fn medium(&mut self, text: &str) -> Result<u32> {
        let text = text.trim();
        if let Some(&place) = self.known.get(text) {
            return Ok(place);
        }
        let material = material::parse(text, self.library)?;
        let place = self.media.len() as u32;
        self.media.push((text.to_owned(), material));
        self.known.insert(text.to_owned(), place);
        Ok(place)
    }

    /// Writes parts out as layers at the end of `into`.
    fn expand(&mut self, parts: &[Part], depth: usize, into: &mut Vec<Written>) -> Result<()> {
        if depth > DEEPEST_REPETITION {
            return Err(too_deep());
        }
        for part in parts {
            match part {
                Part::Layer { medium, thickness_nm, spread_nm } => {
                    if into.len() >= MOST_LAYERS {
                        return Err(too_many());
                    }
                    let place = |e: Error| e.at(format!("layer {} ({})", into.len() + 1, shortened(medium)));
                    let thickness_nm = checked_thickness(*thickness_nm).map_err(place)?;
                    let spread_nm = checked_spread(*spread_nm, thickness_nm).map_err(place)?;
                    into.push(Written { medium: self.medium(medium)?, thickness_nm, spread_nm });
                }
                Part::Repeat { count, parts } => {
                    if *count == 0 || parts.is_empty() {
                        return Err(Error::input(
                            "a repetition needs a count of 1 or more and a layer in it",
                        ));
                    }
                    let start = into.len();
                    self.expand(parts, depth + 1, into)?;
                    let once = into.len() - start;
                    if once.saturating_mul(*count).saturating_add(start) > MOST_LAYERS {
                        return Err(too_many());
                    }
                    for _ in 1..*count {
                        into.extend_from_within(start..start + once);
                    }
                }
            }
        }
        Ok(())
    }
}

fn too_many() -> Error {
    Error::input(format!("the stack has over {MOST_LAYERS} layers; use fewer repetitions"))
}

fn too_deep() -> Error {
    Error::input(format!("repetitions are nested more than {DEEPEST_REPETITION} deep"))
}

fn checked_thickness(thickness_nm: f64) -> Result<f64> {
    if (0.0..=THICKEST_NM).contains(&thickness_nm) {
        return Ok(thickness_nm);
    }
    Err(Error::input(format!("the thickness {thickness_nm} nm is not usable; give 0 to {THICKEST_NM} nm")))
}

fn checked_spread(spread_nm: f64, thickness_nm: f64) -> Result<f64> {
    if (0.0..=thickness_nm).contains(&spread_nm) {
        return Ok(spread_nm);
    }
    Err(Error::input(format!(
        "the spread of {spread_nm} nm is not usable; it is a standard deviation, from 0 to the thickness, {thickness_nm} nm"
    )))
}

/// Splits at the slashes outside brackets.
fn split_items(text: &str) -> Result<Vec<&str>> {
    let mut items = Vec::new();
    let (mut depth, mut start) = (0_usize, 0);
    for (at, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' if depth == 0 => {
                return Err(Error::input(format!(
                    "'{}': a bracket is closed that was never opened",
                    shortened(text)
                )));
            }
            ')' => depth -= 1,
            '/' if depth == 0 => {
                items.push(&text[start..at]);
                start = at + 1;
            }
            _ => {}
        }
        if items.len() > MOST_LAYERS + 2 {
            return Err(too_many());
        }
    }
    if depth > 0 {
        return Err(Error::input(format!("'{}': a bracket is not closed", shortened(text))));
    }
    items.push(&text[start..]);
    Ok(items)
}

/// Reads a layer or a repetition.
fn part(item: &str, depth: usize) -> Result<Part> {
    if depth > DEEPEST_REPETITION {
        return Err(too_deep());
    }
    let item = item.trim();
    if let Some((count, rest)) = item.split_once('*') {
        return repetition(item, count.trim(), rest.trim(), depth);
    }
    if item.is_empty() {
        return Err(Error::input("a medium is missing between two /; leave one of them out"));
    }
    let Some((medium, thickness)) = item.rsplit_once(':') else {
        return Err(Error::input(format!(
            "'{}' needs a thickness in nm, as in keratin:595; only the first and the last medium have none",
            shortened(item)
        )));
    };
    let (thickness_nm, spread_nm) = spread_thickness(thickness).ok_or_else(|| {
        Error::input(format!(
            "'{}': '{}' is not a thickness in nm, as in keratin:595, or with its standard deviation keratin:595±5% or keratin:595+-30",
            shortened(item),
            shortened(thickness)
        ))
    })?;
    Ok(Part::Layer { medium: medium.trim().to_owned(), thickness_nm, spread_nm })
}

/// A thickness in nm and its standard deviation in nm, as in `200`, `200±5%`, `200+-10`.
fn spread_thickness(text: &str) -> Option<(f64, f64)> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let Some((thickness, spread)) = text.split_once('±').or_else(|| text.split_once("+-")) else {
        return Some((number(text)?, 0.0));
    };
    let thickness_nm = number(thickness)?;
    let spread_nm = match spread.trim().strip_suffix('%') {
        Some(percent) => thickness_nm * (number(percent)? / 100.0),
        None => number(spread)?,
    };
    Some((thickness_nm, spread_nm))
}

fn repetition(item: &str, count: &str, rest: &str, depth: usize) -> Result<Part> {
    let refuse =
        |why: &str| Error::input(format!("'{}': {why}, as in 6*(melanin:99/keratin:100)", shortened(item)));
    let inside = rest
        .strip_prefix('(')
        .and_then(|r| r.strip_suffix(')'))
        .ok_or_else(|| refuse("what repeats stands in brackets"))?;
    let count = count.parse::<usize>().map_err(|_| refuse("a repetition starts with a whole number"))?;
    if count == 0 || count > MOST_LAYERS {
        return Err(refuse(&format!("the count of a repetition is 1 to {MOST_LAYERS}")));
    }
    if inside.trim().is_empty() {
        return Err(refuse("nothing repeats"));
    }
    let mut parts = Vec::new();
    for inner in split_items(inside)? {
        parts.push(part(inner, depth + 1)?);
    }
    Ok(Part::Repeat { count, parts })
}

/// The medium of the first or last item, which has no thickness.
fn half_space<'a>(item: &'a str, which: &str) -> Result<&'a str> {
    let item = item.trim();
    if item.contains(':') || item.contains('*') {
        return Err(Error::input(format!(
            "the {which} medium '{}' is a half-space without thickness or repetition; write for example air",
            shortened(item)
        )));
    }
    Ok(item)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Stack> {
        Stack::parse(text, &Library::builtin())
    }

    fn refused(text: &str) -> String {
        let error = read(text).unwrap_err();
        assert!(error.is_input());
        assert!(error.to_string().len() < 600, "{error}");
        error.to_string()
    }

    #[test]
    fn layers_repetitions_mixtures_and_indices_are_read() {
        let stack = read("air/6*(melanin:99/keratin:100)/mix(keratin,melanin,0.4)").unwrap();
        assert_eq!(stack.layers(), 12);
        assert_eq!(stack.thickness_nm()[10..], [99.0, 100.0]);
        assert_eq!((stack.medium(0), stack.medium(1)), ("air", "melanin"));
        assert_eq!(stack.medium(13), "mix(keratin,melanin,0.4)");
        let nested = read("air / 2*( 3*(1.5:10 / keratin:20) / 1.56+0.02j:30 ) / 1.5").unwrap();
        assert_eq!(nested.layers(), 14);
        assert_eq!(nested.indices(500.0).unwrap()[7], Complex64::new(1.56, 0.02));
        assert_eq!(read("air/keratin").unwrap().layers(), 0);
        assert_eq!(read("air/mix(mix(keratin,air,0.5),melanin,0.1):5/air").unwrap().layers(), 1);
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, part) in [
            ("", "at least two media"),
            ("air", "at least two media"),
            ("air/", "a medium is missing"),
            ("/air", "a medium is missing"),
            ("air//air", "a medium is missing"),
            ("air/keratin/air", "needs a thickness"),
            ("air/:5/air", "a medium is missing"),
            ("air/keratin:thick/air", "is not a thickness"),
            ("air/keratin:-5/air", "layer 1 (keratin): the thickness -5 nm"),
            ("air/keratin:nan/air", "not usable"),
            ("air/keratin:inf/air", "not usable"),
            ("air/keratine:5/air", "did you mean 'keratin'"),
            ("air:5/keratin", "the first medium 'air:5'"),
            ("air/keratin:5", "the last medium"),
            ("air/6*(keratin:5)", "the last medium"),
            ("air/0*(keratin:5)/air", "1 to 100000"),
            ("air/x*(keratin:5)/air", "whole number"),
            ("air/6*keratin:5/air", "in brackets"),
            ("air/6*()/air", "nothing repeats"),
            ("air/6*(keratin:5/air", "not closed"),
            ("air/keratin:5)/air", "never opened"),
            ("air/100000*(keratin:5/air:5)/air", "over 100000 layers"),
            ("air/1.5-0.1j:5/air", "gain"),
            ("air/keratin:5±/air", "is not a thickness"),
            ("air/keratin:5±x%/air", "keratin:595±5%"),
            ("air/keratin:5±-1%/air", "layer 1 (keratin): the spread of -0.05 nm"),
            ("air/keratin:5±6/air", "from 0 to the thickness, 5 nm"),
            ("air/keratin:5±nan/air", "the spread of NaN nm"),
        ] {
            let message = refused(text);
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn spreads_are_read_in_percent_and_nm_and_written_out_again() {
        for text in ["air/keratin:200±5%/air", "air/keratin:200+-5%/air", "air/ keratin : 200 ± 10 /air"] {
            let stack = read(text).unwrap();
            assert_eq!((stack.thickness_nm(), stack.spread_nm()), (&[200.0][..], &[10.0][..]), "{text}");
            assert!(stack.is_random());
            assert_eq!(stack.text(), "air/keratin:200±10/air");
            assert_eq!(read(&stack.text()).unwrap().spread_nm(), stack.spread_nm());
        }
        let stack = read("air/2*(melanin:99±1/1.56+0.02j:100)/keratin").unwrap();
        assert_eq!(stack.spread_nm(), [1.0, 0.0, 1.0, 0.0]);
        assert_eq!(stack.text(), "air/melanin:99±1/1.56+0.02j:100/melanin:99±1/1.56+0.02j:100/keratin");
        assert!(!read("air/keratin:200±0%/air").unwrap().is_random());
    }

    #[test]
    fn individuals_have_the_mean_and_the_spread_that_were_asked_for() {
        let stack = read("air/2*(keratin:200±5%/melanin:80)/air").unwrap();
        let count = 4000;
        let drawn: Vec<Stack> = (0..count).map(|k| stack.individual(3, k)).collect();
        assert_eq!(drawn[7], stack.individual(3, 7));
        assert_ne!(drawn[7], stack.individual(4, 7));
        assert!(drawn.iter().all(|one| one.thickness_nm()[1] == 80.0 && !one.is_random()));
        let mean_of = |of: &dyn Fn(&Stack) -> f64| drawn.iter().map(of).sum::<f64>() / count as f64;
        let [first, second] = [0, 2].map(|layer| move |one: &Stack| one.thickness_nm()[layer] - 200.0);
        // Standard errors: 10/√4000 = 0.16 of the mean, 1.1 % of the deviation (which clipping takes down by 1.3 %).
        assert!(mean_of(&first).abs() < 0.7);
        let deviation = mean_of(&|one| first(one).powi(2)).sqrt();
        assert!((deviation / 9.92 - 1.0).abs() < 0.05, "{deviation}");
        let correlation = mean_of(&|one| first(one) * second(one)) / 100.0;
        assert!(correlation.abs() < 0.07, "layers of a repetition are drawn apart: {correlation}");
        assert!(drawn.iter().all(|one| first(one).abs() <= 30.0 + 1e-12));
        let wide = read("air/keratin:200±100%/air").unwrap();
        assert!((0..300).all(|k| wide.individual(1, k).thickness_nm()[0] >= 0.2));
    }

    #[test]
    fn layers_under_a_nanometre_are_doubted() {
        let doubt = read("air/keratin:0.2/air").unwrap().doubt().unwrap();
        assert_eq!(doubt, "keratin:0.2 is 0.2 nm thick; thicknesses are in nm: did you mean 200?");
        let doubt = read("air/keratin:1e-320/air").unwrap().doubt().unwrap();
        assert_eq!(doubt, "keratin:1e-320 is 1e-320 nm thick; thicknesses are in nm");
        assert_eq!(read("air/keratin:1/melanin:0/air").unwrap().doubt(), None);
    }

    #[test]
    fn explosions_are_refused_before_they_happen() {
        let bomb = format!("air/{}keratin:1{}/air", "99999*(".repeat(20), ")".repeat(20));
        assert!(refused(&bomb).contains("over 100000"));
        let deep = format!("air/{}keratin:1{}/air", "1*(".repeat(40), ")".repeat(40));
        assert!(refused(&deep).contains("more than 32 deep"));
        refused(&"air/(".repeat(100_000));
        assert!(refused(&format!("air{}/air", "/keratin:1".repeat(100_001))).contains("over 100000"));
        assert_eq!(read("air/100000*(keratin:1)/air").unwrap().layers(), MOST_LAYERS);
    }

    #[test]
    fn an_absorbing_entry_is_refused_where_it_absorbs() {
        let message = read("melanin/keratin").unwrap().indices(500.0).unwrap_err().to_string();
        assert!(message.contains("first medium 'melanin' absorbs"), "{message}");
    }
}
