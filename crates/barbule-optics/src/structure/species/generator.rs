//! What makes the sections of a species: a generator is a struct of parameters, which are the keys of its files.

use serde::Serialize;
use serde_json::Value;

use super::{Bronzewing, Crystal, Hummingbird, Multilayer, RockDove, Starling};
use crate::error::{did_you_mean, shortened};
use crate::fields::Fields;
use crate::identity::{Hasher, Identify};
use crate::material::Library;
use crate::math::rng::Stream;
use crate::structure::lattice::Lattice;
use crate::structure::section::Parts;
use crate::structure::{Medium, Polyline};
use crate::{Error, Result};

/// Makes random sections of its parameters.
pub(super) trait Generator {
    /// The barbule's width.
    fn width_um(&self) -> f64;
    /// Refuses parameters that contradict each other.
    fn check(&self) -> Result<()>;
    /// One random section, but for name and source.
    fn parts(&self, random: &Random, library: &Library) -> Parts;
    /// The photonic crystal under a flat top, where there is one.
    fn lattice(&self, _library: &Library) -> Option<Lattice> {
        None
    }
    /// One random section of the lower side as lit from below, where [`Self::parts`] leave it out.
    fn lower_parts(&self, _random: &Random, _library: &Library) -> Option<Parts> {
        None
    }
    /// The photonic crystal of the lower side as seen from below, under a flat top.
    fn lower_lattice(&self, _library: &Library) -> Option<Lattice> {
        None
    }
    /// Which parameters decide whether all regions find room, and how to give them more.
    fn room(&self) -> String {
        "make its parts smaller, or the barbule larger".into()
    }
    /// Whether the outline is an arch rather than a slab.
    fn is_curved(&self) -> bool {
        false
    }
    /// The media that the parameters name, each with its key.
    fn media(&self) -> Vec<(String, &str)> {
        Vec::new()
    }
}

/// A key of a generator's parameters, as files explain it.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// The key.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub about: &'static str,
    /// What it may be, as in `0.001 to 10 µm`.
    pub allowed: String,
    /// What a missing key means; `None`: it is needed.
    pub usual: Option<Value>,
}

impl Key {
    /// A number in a range; the end of its name is its unit.
    pub(super) fn number(
        name: &'static str,
        about: &'static str,
        [low, high]: [f64; 2],
        usual: Option<f64>,
    ) -> Self {
        let unit = match name.rsplit_once('_') {
            Some((_, "um")) => " µm",
            Some((_, "deg")) => "°",
            _ => "",
        };
        Self { name, about, allowed: format!("{low} to {high}{unit}"), usual: usual.map(Value::from) }
    }

    /// A text that may be left out.
    pub(super) fn text(name: &'static str, about: &'static str, allowed: &str, usual: &'static str) -> Self {
        Self { name, about, allowed: allowed.to_owned(), usual: Some(usual.into()) }
    }
}

/// The generators: their names in files, which are those of [`GeneratorParameters`]' variants in lower case, and their parameters.
macro_rules! generators {
    ($($name:literal: $(#[doc = $about:literal])* $kind:ident,)*) => {
        /// The parameters of one species and variant, by generator.
        #[derive(Debug, Clone, PartialEq, Serialize)]
        #[serde(tag = "generator", rename_all = "kebab-case")]
        pub enum GeneratorParameters { $($(#[doc = $about])* $kind($kind),)* }

        /// The names of all generators.
        const NAMES: &[&str] = &[$($name),*];

        impl GeneratorParameters {
            /// The keys of a generator's parameters, in the order of its files.
            ///
            /// # Errors
            /// There is no such generator; the nearest is offered.
            pub fn keys(generator: &str) -> Result<Vec<Key>> {
                match generator {
                    $($name => Ok($kind::keys()),)*
                    other => Err(unknown(other)),
                }
            }

            /// What a generator makes, in a sentence.
            ///
            /// # Errors
            /// As [`Self::keys`].
            pub fn about(generator: &str) -> Result<&'static str> {
                match generator {
                    $($name => Ok(concat!($($about),*).trim()),)*
                    other => Err(unknown(other)),
                }
            }

            /// Checks each parameter that a table gives against its range.
            pub(super) fn check_given(generator: &str, fields: &Fields<'_>) -> Result<()> {
                match generator {
                    $($name => $kind::check_given(fields),)*
                    other => Err(unknown(other)),
                }
            }

            /// Reads and checks the parameters of a generator.
            pub(super) fn read(generator: &str, fields: &Fields<'_>) -> Result<Self> {
                let parameters = match generator {
                    $($name => Self::$kind($kind::read(fields)?),)*
                    other => return Err(unknown(other)),
                };
                parameters.generator().check()?;
                Ok(parameters)
            }

            pub(super) fn generator(&self) -> &dyn Generator {
                match self { $(Self::$kind(parameters) => parameters,)* }
            }
        }

        impl Identify for GeneratorParameters {
            fn feed(&self, to: &mut Hasher) {
                match self { $(Self::$kind(parameters) => to.part($name, parameters),)* };
            }
        }
    };
}

generators! {
    "rock-dove":
        /// A keratin cortex between air outside and inside.
        RockDove,
    "starling":
        /// A keratin film over a layer of melanosomes.
        Starling,
    "bronzewing":
        /// Two stacks of melanosome layers.
        Bronzewing,
    "hummingbird":
        /// Layers of air-filled pancake melanosomes.
        Hummingbird,
    "crystal":
        /// A photonic crystal of melanosomes.
        Crystal,
    "multilayer":
        /// Layers of any media in any number.
        Multilayer,
}

/// The names in words: a, b or c.
pub(super) fn generator_names() -> String {
    let [others @ .., last] = NAMES else { return String::new() };
    format!("{} or {last}", others.join(", "))
}

fn unknown(generator: &str) -> Error {
    let near = did_you_mean(generator, NAMES.iter().copied());
    let help = if near.is_empty() { format!("; known are {}", NAMES.join(", ")) } else { near };
    Error::input(format!("generator: there is no '{}'{help}", shortened(generator)))
}

/// Reads the values of one generator's parameters.
pub(super) trait Parameter: Sized {
    fn read(fields: &Fields<'_>, key: &str, low: f64, high: f64) -> Result<Self>;
}

impl Parameter for f64 {
    fn read(fields: &Fields<'_>, key: &str, low: f64, high: f64) -> Result<Self> {
        fields.number_within(key, low, high)
    }
}

impl Parameter for usize {
    fn read(fields: &Fields<'_>, key: &str, low: f64, high: f64) -> Result<Self> {
        fields.count_within(key, low as usize, high as usize)
    }
}

/// A generator's parameters: a struct whose fields are the keys of its species files, with their ranges, and for keys that
/// may be left out what they then are.
macro_rules! parameters {
    ($(#[$about:meta])* $name:ident {
        $($(#[doc = $doc:literal])* $field:ident: $kind:ty = $low:literal to $high:literal $(or $usual:literal)?,)*
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize)]
        pub struct $name { $($(#[doc = $doc])* pub $field: $kind,)* }

        impl $name {
            pub(super) fn keys() -> Vec<$crate::structure::species::Key> {
                vec![$($crate::structure::species::Key::number(
                    stringify!($field),
                    concat!($($doc),*).trim(),
                    [f64::from($low), f64::from($high)],
                    <[f64]>::first(&[$(f64::from($usual))?]).copied(),
                )),*]
            }

            pub(super) fn check_given(fields: &$crate::fields::Fields<'_>) -> $crate::Result<()> {
                use $crate::structure::species::generator::Parameter;
                $(if fields.get(stringify!($field)).is_some() {
                    <$kind as Parameter>::read(
                        fields, stringify!($field), f64::from($low), f64::from($high))?;
                })*
                Ok(())
            }

            pub(super) fn read(fields: &$crate::fields::Fields<'_>) -> $crate::Result<Self> {
                Ok(Self {
                    $($field: match (<[$kind]>::first(&[$($usual)?]), fields.get(stringify!($field))) {
                        (Some(&usual), None) => usual,
                        _ => $crate::structure::species::generator::Parameter::read(
                            fields, stringify!($field), f64::from($low), f64::from($high))?,
                    },)*
                })
            }
        }

        impl $crate::identity::Identify for $name {
            fn feed(&self, to: &mut $crate::identity::Hasher) {
                // The keys of species files, which stay.
                $(to.number(stringify!($field), self.$field as f64);)*
            }
        }
    };
}
pub(super) use parameters;

/// Refuses a range whose low end is above its high end.
pub(super) fn ordered(low_key: &str, low: f64, high_key: &str, high: f64) -> Result<()> {
    if low <= high {
        return Ok(());
    }
    Err(Error::input(format!("parameters.{low_key} is {low}, above {high_key}, {high}; swap them")))
}

/// The random streams of one instance: one for each purpose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Random {
    pub(super) seed: u64,
    pub(super) instance: u64,
}

impl Random {
    pub(super) fn stream(&self, purpose: u64) -> Stream {
        Stream::new(self.seed, &[self.instance, purpose])
    }

    pub(super) fn part(&self, purpose: u64, part: usize) -> Stream {
        Stream::new(self.seed, &[self.instance, purpose, part as u64])
    }
}

/// What a generator leaves to the caller: name and source.
pub(super) fn parts(width_um: f64, boundaries: Vec<Polyline>, media: Vec<Medium>) -> Parts {
    Parts { width_um: Some(width_um), boundaries, media, ..Parts::default() }
}
