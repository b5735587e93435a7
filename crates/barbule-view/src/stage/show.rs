//! What is put on a stage.

use std::collections::BTreeMap;
use std::sync::Arc;

use barbule_appearance::brdf::FeatherBrdf;
use barbule_appearance::bsdf::{self, Keratin, Reflectance};

use crate::Result;
use crate::gpu::{Reflected, Sight};
use crate::scene::Shape;

/// A shape and what its parts wear.
#[derive(Debug, Clone)]
pub struct Show {
    /// The shape.
    pub shape: Shape,
    /// What parts wear, by their codes ([`Part::code`](crate::scene::Part::code)).
    pub wears: BTreeMap<u32, Wear>,
    /// What all others wear.
    pub rest: Wear,
    /// Who sees it.
    pub sight: Sight,
}

/// What a part is made of.
#[derive(Debug, Clone)]
pub struct Wear {
    /// Its upper side.
    pub coat: Coat,
    /// How barbules differ from place to place.
    pub cells: bsdf::Cells,
    /// Its underside, the walls between its cells, and all of it where it has no coat.
    pub keratin: Keratin,
}

/// What an upper side is made of.
#[derive(Debug, Clone)]
pub enum Coat {
    /// Barbules with their tables.
    Feather(Arc<FeatherBrdf>),
    /// A grating.
    Grating(Arc<bsdf::Grating>),
    /// Layers of which it is known what they reflect, on facets of a GGX α.
    Layers {
        /// What they reflect.
        reflected: Arc<Reflected>,
        /// 0.02 to 1.
        roughness: f64,
    },
    /// Keratin alone.
    Keratin,
}

impl Wear {
    /// Dark keratin, as barbules are beneath.
    ///
    /// # Errors
    /// None: its numbers are in range.
    pub fn dark() -> Result<Self> {
        let keratin = Keratin::new(0.3, 1.56, Reflectance::of_colour([0.02, 0.016, 0.013])?)?;
        Ok(Self { coat: Coat::Keratin, cells: bsdf::Cells::default(), keratin })
    }

    /// A coat over dark keratin.
    ///
    /// # Errors
    /// As [`Wear::dark`].
    pub fn over_dark(coat: Coat) -> Result<Self> {
        Ok(Self { coat, ..Self::dark()? })
    }
}
