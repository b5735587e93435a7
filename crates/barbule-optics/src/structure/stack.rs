//! Planar stacks of layers, and the language people write them in.
//!
//! ```text
//! stack  = item ("/" item)*               first and last item: half-spaces, without thickness
//! item   = medium [":" thickness in nm] | count "*(" item ("/" item)* ")"
//! medium = name | "mix(" medium "," medium "," fraction ["," rule] ")" | index such as 1.56+0.02j
//! ```

use std::collections::HashMap;

use crate::error::shortened;
use crate::material::{self, Library, Material};
use crate::{Complex64, Error, Result};

/// No stack has more layers than this once its repetitions are written out.
pub const MOST_LAYERS: usize = 100_000;
/// Repetitions within repetitions go no deeper than this.
pub const DEEPEST_REPETITION: usize = 32;
/// A layer thicker than this (1 m) is a slip, and its phase would have no correct digit.
const THICKEST_NM: f64 = 1e9;

/// Homogeneous layers between two half-spaces.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// The distinct media, each with the text that names it.
    media: Vec<(String, Material)>,
    /// The medium of each region from the entry to the exit half-space, as a place in `media`.
    order: Vec<u32>,
    /// The thickness of each layer: two fewer than `order`.
    thickness_nm: Vec<f64>,
}

/// One part of a stack as it is written: a layer, or a group of parts that repeats.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// A homogeneous layer.
    Layer {
        /// The medium's name or expression.
        medium: String,
        /// The thickness in nm.
        thickness_nm: f64,
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
        order.extend(layers.iter().map(|(medium, _)| *medium));
        order.push(last);
        let thickness_nm = layers.into_iter().map(|(_, thickness)| thickness).collect();
        Ok(Self { media: builder.media, order, thickness_nm })
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
        Ok(Self { media, order, thickness_nm })
    }

    /// How many layers lie between the half-spaces.
    #[must_use]
    pub fn layers(&self) -> usize {
        self.thickness_nm.len()
    }

    /// The thickness of each layer in nm, from the entry side.
    #[must_use]
    pub fn thickness_nm(&self) -> &[f64] {
        &self.thickness_nm
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
    fn expand(&mut self, parts: &[Part], depth: usize, into: &mut Vec<(u32, f64)>) -> Result<()> {
        if depth > DEEPEST_REPETITION {
            return Err(too_deep());
        }
        for part in parts {
            match part {
                Part::Layer { medium, thickness_nm } => {
                    if into.len() >= MOST_LAYERS {
                        return Err(too_many());
                    }
                    let place = |e: Error| e.at(format!("layer {} ({})", into.len() + 1, shortened(medium)));
                    let thickness = checked_thickness(*thickness_nm).map_err(place)?;
                    into.push((self.medium(medium)?, thickness));
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
    let thickness_nm = thickness.trim().parse::<f64>().map_err(|_| {
        Error::input(format!(
            "'{}': '{}' is not a thickness in nm, as in keratin:595",
            shortened(item),
            shortened(thickness)
        ))
    })?;
    Ok(Part::Layer { medium: medium.trim().to_owned(), thickness_nm })
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
        ] {
            let message = refused(text);
            assert!(message.contains(part), "{text}: {message}");
        }
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
