//! What can be chosen: materials, and what they are shown on.

use std::collections::BTreeMap;
use std::sync::Arc;

use barbule_appearance::brdf::FeatherBrdf;
use barbule_appearance::bsdf;
use barbule_appearance::scene::feather::{Feather, VaneDisc};
use barbule_base::progress::Unobserved;

use crate::Result;
use crate::gpu::{Reflected, Sight};
use crate::scene::{Bend, FeatherRequest, MOST_TRIANGLES, Part, Shape, feather, snake, sphere, vane};
use crate::stage::{Coat, Show, Wear};

/// GGX α of films' surfaces: highlights are as wide as a hand at arm's length.
const FILM_ROUGHNESS: f64 = 0.22;
/// The piece of a feather that is shown: how far from its base, as a share of its length, and its radius, mm.
const PIECE: [f64; 2] = [0.6, 1.1];

/// A material that ships, fetched when it is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bird {
    /// Its file, beside the page.
    pub file: &'static str,
    /// What its button says.
    pub label: &'static str,
    /// What one looks at.
    pub about: &'static str,
}

/// The materials, the first of which the page opens with.
pub const BIRDS: [Bird; 6] = [
    Bird {
        file: "starling-green.barbule",
        label: "Starling",
        about: "Barbules of a starling: a film of keratin over a layer of melanin rods, simulated as waves. Every cell is an individual with edges of its own, so single ones glint.",
    },
    Bird {
        file: "rock-dove-purple.barbule",
        label: "Rock dove",
        about: "Barbules of a dove's neck: under 0.6 µm of keratin over melanin granules, purple turns to green as the angle grows.",
    },
    Bird {
        file: "hummingbird-anna.barbule",
        label: "Hummingbird",
        about: "Barbules of Anna's hummingbird: melanin platelets full of air in some fifteen layers, which are a mirror of one colour.",
    },
    Bird {
        file: "mallard-lime.barbule",
        label: "Mallard",
        about: "Barbules of a mallard's head: rods of melanin in a hexagonal lattice, a photonic crystal of a few layers.",
    },
    Bird {
        file: "peafowl-scaled-blue.barbule",
        label: "Peafowl",
        about: "Barbules of a peacock: melanin rods in a square lattice. A few nanometres between them are the step from blue to green.",
    },
    Bird {
        file: "magpie-violet.barbule",
        label: "Magpie",
        about: "Barbules of a magpie's tail: hollow melanin rods in a lattice, darker and narrower in colour than the starling's.",
    },
];

/// What is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// One of [`BIRDS`].
    Bird(usize),
    /// A film.
    Film,
    /// A grating.
    Ridges,
}

impl Choice {
    /// All of them, in the order of the page.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..BIRDS.len()).map(Self::Bird).chain([Self::Film, Self::Ridges])
    }

    /// What its button says.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Bird(number) => BIRDS.get(number).map_or("", |bird| bird.label),
            Self::Film => "Thin film",
            Self::Ridges => "Grating",
        }
    }

    /// What it can be shown on, the usual one first.
    #[must_use]
    pub fn solids(self) -> &'static [Solid] {
        match self {
            Self::Bird(_) | Self::Film => &[Solid::Ball, Solid::Vane, Solid::Feather],
            Self::Ridges => &[Solid::Ball, Solid::Vane, Solid::Snake],
        }
    }

    /// Stops of exposure at which it looks right under the page's lamp; of a bird until its material is there.
    #[must_use]
    pub fn stops(self) -> f64 {
        match self {
            Self::Bird(_) => 1.0,
            Self::Film => 1.8,
            Self::Ridges => 0.8,
        }
    }
}

/// What it is shown on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solid {
    /// A ball, on which one sees all angles at once.
    Ball,
    /// A bent piece of a vane.
    Vane,
    /// A piece of a feather, its barbs and barbules.
    Feather,
    /// A snake.
    Snake,
}

impl Solid {
    /// What its button says.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Ball => "Ball",
            Self::Vane => "Vane",
            Self::Feather => "Feather",
            Self::Snake => "Snake",
        }
    }

    /// Its mesh.
    ///
    /// # Errors
    /// None, as long as there is a feather of the type `contour`.
    pub fn shape(self) -> Result<Shape> {
        match self {
            Self::Ball => sphere(),
            Self::Vane => vane(&Bend::USUAL),
            Self::Snake => snake(),
            Self::Feather => {
                let of = Feather::of_type("contour")?;
                let [share, radius] = PIECE;
                let window = VaneDisc { along_mm: share * of.shaft.length_mm, radius_mm: Some(radius) };
                let request = FeatherRequest {
                    feather: &of,
                    window,
                    zones: None,
                    seed: 1,
                    most_triangles: MOST_TRIANGLES,
                };
                Ok(feather(&request, &Unobserved)?.0)
            }
        }
    }
}

/// A coat of the page.
#[derive(Debug, Clone)]
pub enum Worn {
    /// Barbules.
    Bird(Arc<FeatherBrdf>),
    /// A film.
    Film(Arc<Reflected>),
    /// A grating.
    Ridges(Arc<bsdf::Grating>),
}

/// The shape in a coat, where it is one of barbules or of the whole surface.
///
/// # Errors
/// None: the keratin's numbers are in range.
pub fn show(shape: &Shape, worn: &Worn) -> Result<Show> {
    let coat = match worn {
        Worn::Bird(brdf) => Coat::Feather(Arc::clone(brdf)),
        Worn::Film(reflected) => Coat::Layers { reflected: Arc::clone(reflected), roughness: FILM_ROUGHNESS },
        Worn::Ridges(grating) => Coat::Grating(Arc::clone(grating)),
    };
    let wear = Wear::over_dark(coat)?;
    let clad = [Part::Distal, Part::Proximal, Part::Grating];
    let wears: BTreeMap<u32, Wear> = clad.iter().map(|part| (part.code(0), wear.clone())).collect();
    Ok(Show { shape: shape.clone(), wears, rest: Wear::dark()?, sight: Sight::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files that the page asks for are those that ship, and everything can be shown on what is offered for it.
    #[test]
    fn every_choice_is_there() {
        let shipped: Vec<String> =
            barbule_birds::materials().map(|(name, _)| format!("{name}.barbule")).collect();
        for bird in BIRDS {
            assert!(shipped.iter().any(|file| file == bird.file), "{}", bird.file);
        }
        for choice in Choice::all() {
            assert!(!choice.label().is_empty() && choice.solids().contains(&Solid::Ball));
        }
        for solid in [Solid::Ball, Solid::Vane, Solid::Feather, Solid::Snake] {
            let shape = solid.shape().unwrap();
            shape.check().unwrap();
            let worn = Worn::Ridges(Arc::new(super::super::grating::Ridges::default().surface().unwrap()));
            assert_eq!(show(&shape, &worn).unwrap().wears.len(), 3, "{}", solid.label());
        }
    }
}
