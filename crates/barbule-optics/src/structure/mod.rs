//! What a barbule is made of: sections, stacks, species and their random instances.

mod arch;
mod cast;
mod chain;
mod check;
mod closed;
mod columns;
mod contour;
mod crystal;
mod curve;
mod flat;
mod heightfield;
mod identify;
mod lattice;
mod offset;
mod outline;
mod section;
mod segment;
mod side;
mod smooth;
mod species;
mod sweep;
mod symmetry;

pub use cast::{Ray, cast};
pub use closed::{ABSORPTION, Beneath, Closed, Ends, GAP_UM, RAMP, RAMP_STEP_UM};
pub use columns::{Columns, Palette, PaletteMixture, SlotMixture};
pub use contour::Contour;
pub use crystal::{BuriedCircle, CrystalLayer, Regularity};
pub use flat::FlatStack;
pub use heightfield::{Cleaning, Fingers, Grains, Heightfield, MOST_HEIGHTS, SAMPLES};
pub use lattice::{Circle, Lattice, MOST_RODS, Placed, Rod, TOUCHING_UM};
pub use section::{
    FLAT_WIDTH_UM, Inclusion, LARGEST_COORDINATE_UM, Loop, MOST_POINTS, MaterialSource, Medium, Parts,
    Polyline, Section, Substance,
};
pub use segment::{
    Cut, CutLayer, Layers, Line, Plane, Roughness, SEGMENT_LENGTHS_UM, Sampled, Segment, SegmentGrid,
};
pub use side::Side;
pub use smooth::{FINER_THAN_LIGHT_UM, Smoothing, averaged_columns};
pub use species::{
    Bronzewing, Crystal, DEFAULT_VARIANT, GeneratorParameters, Hummingbird, LowerSide, Multilayer,
    MultilayerLayer, MultilayerSizes, RockDove, SpeciesFile, SpeciesModel, Starling, crystal_species,
    layered_species, species_name, species_names, species_toml,
};
pub use symmetry::Symmetry;

use serde_json::{Map, Value, json};

use crate::{Error, Result, identity};

/// Individuals that one campaign or mean is made of, at most.
pub const MOST_INSTANCES: usize = 10_000;

/// What a command works on: endless random individuals of a species or of a stack, or given sections.
#[derive(Debug, Clone, PartialEq)]
pub enum Structure {
    /// Random instances.
    Species(Box<SpeciesModel>),
    /// Random instances of a stack whose layers spread in thickness.
    Stack(Box<FlatStack>),
    /// Given instances, at least one.
    Sections {
        /// What they are called together.
        name: String,
        /// The instances.
        sections: Vec<Section>,
    },
    /// The lower side of another structure; [`Self::underside`] makes it.
    Below(Box<Structure>),
}

impl Structure {
    /// A built-in species, as in `starling` (its default variant) or `starling:pink`, of the built-in materials.
    ///
    /// # Errors
    /// Unknown names; the nearest is offered.
    pub fn builtin(name: &str) -> Result<Self> {
        let (species, variant) = match name.split_once(':') {
            Some((species, variant)) => (species, Some(variant)),
            None => (name, None),
        };
        let model = SpeciesModel::builtin(species, variant, crate::material::Library::builtin())?;
        Ok(Self::Species(Box::new(model)))
    }

    /// A flat barbule of a stack, as in `air/keratin:595/air` (nm), of the built-in materials.
    ///
    /// # Errors
    /// Not a stack, or an unknown medium.
    pub fn flat(stack: &str) -> Result<Self> {
        FlatStack::parse(stack, crate::material::Library::builtin())?.structure()
    }

    /// Instance number `index`. The same seed and index give the same bits everywhere.
    ///
    /// # Errors
    /// There is no such instance, or a user's species whose regions do not fit.
    pub fn instance(&self, seed: u64, index: usize) -> Result<Section> {
        let section = match self {
            Self::Species(model) => model.section(seed, index),
            Self::Stack(flat) => flat.section(seed, index),
            Self::Sections { name, sections } => sections.get(index).cloned().ok_or_else(|| {
                Error::input(format!(
                    "{name} has instances 0 to {}, so there is no instance {index}",
                    sections.len().saturating_sub(1)
                ))
            }),
            Self::Below(upper) => {
                let mut section = match &**upper {
                    Self::Species(model) => model.underside(seed, index)?,
                    other => other.instance(seed, index)?.underside()?,
                };
                section.name += Side::BELOW;
                section.source += ", its lower side";
                Ok(section)
            }
        }?;
        match self {
            Self::Sections { .. } => Ok(section),
            _ => Ok(Section { smooth_um: self.smooth_um(), ..section }),
        }
    }

    /// The same structure with what is finer than light averaged so: of species and of sections with inclusions, since nothing
    /// else has any. One place decides for all simulations; [`Smoothing::Usual`] leaves given sections as they are.
    #[must_use]
    pub fn smoothed(self, smoothing: Smoothing) -> Self {
        match self {
            Self::Species(model) => Self::Species(Box::new(SpeciesModel { smoothing, ..*model })),
            Self::Sections { name, mut sections } => {
                let any = sections.iter().any(|section| !section.inclusions.is_empty());
                for section in &mut sections {
                    section.smooth_um = smoothing.deviation_um(section.smooth_um).filter(|_| any);
                }
                Self::Sections { name, sections }
            }
            Self::Below(upper) => Self::Below(Box::new(upper.smoothed(smoothing))),
            stack @ Self::Stack(_) => stack,
        }
    }

    /// The standard deviation, µm, over which simulations average inclusions along the top; `None`: not at all.
    #[must_use]
    pub fn smooth_um(&self) -> Option<f64> {
        match self {
            Self::Species(model) => model.smooth_um(),
            Self::Stack(_) => None,
            Self::Sections { sections, .. } => sections.first().and_then(|section| section.smooth_um),
            Self::Below(upper) => upper.smooth_um(),
        }
    }

    /// The lower side, lit from below: each individual turned by 180° about its long axis. A species' photonic crystal hangs
    /// under its lower outline, too. Turned twice it is the structure itself.
    ///
    /// # Errors
    /// An individual has no lower side that light comes to through air ([`Section::underside`]).
    pub fn underside(self) -> Result<Self> {
        let below = match self {
            Self::Below(upper) => return Ok(*upper),
            upper => Self::Below(Box::new(upper)),
        };
        for index in 0..below.count().unwrap_or(1) {
            below.instance(0, index)?;
        }
        Ok(below)
    }

    /// What is described: the structure itself, or of a lower side the structure whose it is.
    #[must_use]
    pub fn upper(&self) -> &Self {
        match self {
            Self::Below(upper) => upper,
            upper => upper,
        }
    }

    /// Which side of what is described is lit.
    #[must_use]
    pub fn side(&self) -> Side {
        if matches!(self, Self::Below(_)) { Side::Below } else { Side::Above }
    }

    /// How many instances there are; `None`: endlessly many random ones.
    #[must_use]
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::Species(_) | Self::Stack(_) => None,
            Self::Sections { sections, .. } => Some(sections.len()),
            Self::Below(upper) => upper.count(),
        }
    }

    /// What it is called; lower sides end in ` (below)`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Species(model) => model.title(),
            Self::Stack(flat) => flat.name.clone(),
            Self::Sections { name, .. } => name.clone(),
            Self::Below(upper) => upper.name() + Side::BELOW,
        }
    }

    /// The photonic crystal under the top, where there is one; all given sections have the same.
    #[must_use]
    pub fn lattice(&self) -> Option<Lattice> {
        match self {
            Self::Species(model) => model.lattice(),
            Self::Stack(_) => None,
            Self::Sections { sections, .. } => {
                sections.first().and_then(|s| s.crystal.as_ref()).map(|c| c.lattice.clone())
            }
            Self::Below(upper) => match &**upper {
                Self::Species(model) => model.lower_lattice(),
                // Others have no lower side where they have a crystal.
                _ => None,
            },
        }
    }

    /// The width of a barbule; of given instances, the first one's.
    #[must_use]
    pub fn width_um(&self) -> f64 {
        match self {
            Self::Species(model) => model.width_um(),
            Self::Stack(_) => FLAT_WIDTH_UM,
            Self::Sections { sections, .. } => sections.first().map_or(0.0, |section| section.width_um),
            Self::Below(upper) => upper.width_um(),
        }
    }

    /// Whether the barbule is an arch rather than flat.
    #[must_use]
    pub fn is_curved(&self) -> bool {
        match self {
            Self::Species(model) => model.is_curved(),
            Self::Stack(_) => false,
            Self::Sections { sections, .. } => {
                sections.first().is_some_and(|section| arch::is_arch(section.top()))
            }
            Self::Below(upper) => upper.is_curved(),
        }
    }

    /// Whether the individuals are, each or in the mean, their own mirror images about the middle plane. Random layers are in
    /// the mean; crystals by their lattice; given sections where each is.
    #[must_use]
    pub fn symmetry(&self) -> Symmetry {
        let one_sided = |what: String| Symmetry::OneSided(format!("{what} is not its own mirror image"));
        match self {
            Self::Species(model) if model.lattice().is_some_and(|lattice| !lattice.is_mirrored()) => {
                one_sided(format!("the lattice of {}", model.title()))
            }
            Self::Species(_) | Self::Stack(_) => Symmetry::Mirrored,
            Self::Sections { name, sections } => {
                match sections.iter().position(|section| !section.is_mirrored()) {
                    None => Symmetry::Mirrored,
                    Some(_) if sections.len() == 1 => one_sided(name.clone()),
                    Some(at) => one_sided(format!("section {at} of {name}")),
                }
            }
            Self::Below(upper) => upper.symmetry(),
        }
    }

    /// Everything that decides the instances, for the metadata of results: generator parameters or sections, the hashes
    /// of their materials, and `identity`, the version of these hashes.
    #[must_use]
    pub fn description(&self) -> Value {
        match self {
            Self::Species(model) => {
                let hash = |name: &str| {
                    let material = crate::material::parse(name, &model.library).ok()?;
                    Some((name.to_owned(), identity::hash("material", &material).into()))
                };
                let materials: Map<String, Value> = model.media().filter_map(hash).collect();
                json!({
                    "identity": identity::VERSION,
                    "species": model.name,
                    "variant": model.variant,
                    "parameters": model.parameters,
                    "materials": materials,
                })
            }
            // The text alone makes it again; the hash holds its media.
            Self::Stack(flat) => json!({
                "identity": identity::VERSION,
                "stack": flat.stack.text(),
                "hashes": [identity::hash("stack", &flat.stack)],
            }),
            // Not their name, which is how somebody spelled a path.
            Self::Sections { name: _, sections } => json!({
                "identity": identity::VERSION,
                "width_um": self.width_um(),
                "hashes": sections.iter().map(|s| identity::hash("section", s)).collect::<Vec<_>>(),
            }),
            Self::Below(upper) => below(upper.description()),
        }
    }

    /// The identity of everything that decides the instances, BLAKE3 in hexadecimal.
    #[must_use]
    pub fn hash(&self) -> String {
        match self {
            Self::Species(model) => identity::hash("species", &**model),
            Self::Stack(flat) => identity::hash("stack", &flat.stack),
            Self::Sections { name: _, sections } => {
                identity::Hasher::new("sections").list("sections", sections).hex()
            }
            Self::Below(upper) => identity::Hasher::new("below").text("structure", &upper.hash()).hex(),
        }
    }
}

/// The description of a lower side.
fn below(mut upper: Value) -> Value {
    if let Value::Object(fields) = &mut upper {
        fields.insert("side".into(), "below".into());
    }
    upper
}
