//! What makes the sections of a species: a generator is a struct of parameters, which are the keys of its files.

use serde::Serialize;

use super::{Bronzewing, Crystal, Hummingbird, Multilayer, RockDove, Starling};
use crate::error::{did_you_mean, shortened};
use crate::fields::{Fed, Fields, Key, Record};
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
    /// Whether the lower side, lit from below, is as random as the upper one: the same in the mean and in all statistics.
    fn is_alike_below(&self) -> bool {
        false
    }
    /// Which parameters decide whether all regions find room, and how to give them more.
    fn room(&self) -> String {
        "make its parts smaller, or the barbule larger".into()
    }
    /// Whether the outline is an arch rather than a slab.
    fn is_curved(&self) -> bool {
        false
    }
    /// The standard deviation, µm, over which simulations average inclusions along the top unless somebody says otherwise; `None`:
    /// there are none that are finer than light.
    fn smooth_um(&self) -> Option<f64> {
        None
    }
    /// The media that the parameters name, each with its key.
    fn media(&self) -> Vec<(String, &str)> {
        Vec::new()
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
            /// The names of all generators.
            pub const GENERATORS: &[&str] = NAMES;

            /// The keys of a generator's parameters, in the order of its files.
            ///
            /// # Errors
            /// There is no such generator; the nearest is offered.
            pub fn keys(generator: &str) -> Result<Vec<Key>> {
                match generator {
                    $($name => Ok(<$kind as Record>::keys()),)*
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
                    $($name => <$kind as Record>::check_given(fields),)*
                    other => Err(unknown(other)),
                }
            }

            /// Reads and checks the parameters of a generator.
            pub(super) fn read(generator: &str, fields: &Fields<'_>) -> Result<Self> {
                let parameters = match generator {
                    $($name => Self::$kind(<$kind as Record>::read_fields(fields)?),)*
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
                match self { $(Self::$kind(parameters) => to.part($name, &Fed(parameters)),)* };
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
