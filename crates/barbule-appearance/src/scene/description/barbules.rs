//! What barbules wear: a computed material above, and another one or keratin below.

use std::sync::Arc;

use super::slot::Slot;
use super::surfaces::PigmentedKeratin;
use crate::brdf::{FeatherBrdf, Reciprocity};
use crate::bsdf::{BarbuleSurface, Cells, Clad, Layout};
use crate::fields::{FieldValue, Kind, Text, Value, within, wrong_kind};
use crate::identity::Hasher;
use crate::{Result, record};

/// Keratin of barbules where nothing is said: nearly black.
const UNDERSIDE: PigmentedKeratin = PigmentedKeratin { roughness: 0.35, index: 1.56, melanin: 20.0 };

record! {
    /// Barbules of a computed material: those of a feather, or what a mesh or curve with texture coordinates wears.
    #[derive(Debug, Clone, PartialEq)]
    pub struct BarbuleClothing {
        /// What their upper sides are made of.
        material: Slot<FeatherBrdf> = "material", Text("a species, structure or .barbule file");
        /// What their lower sides are made of: default, the lower sides of the material's own barbules where these are known and keratin
        /// elsewhere; keratin; or another material.
        under: Under = "under", (), or Under::default();
        /// Keratin of lower sides that are made of it, and of the walls between cells.
        underside: PigmentedKeratin = "underside", (), or UNDERSIDE;
        /// What makes them show the same when light and eye change places: steeper, each value is that of the tables of whichever direction
        /// is steeper across the barbule; mean, of both, which takes longer; none, the tables of the eye's side.
        reciprocity: Reciprocity = "reciprocity", (), or Reciprocity::Steeper;
        /// On a mesh: lengths along and across barbules on which a texture coordinate grows by 1.
        uv_mm: [f64; 2] = "uv_mm", within(1e-4, 1e5), or [1.0, 1.0];
        /// On a mesh: width of a barbule; 0: one from v = -1 to 1.
        width_um: f64 = "width_um", within(0, 1000), or 0.0;
        /// On a mesh: length of a barbule; 0: they have no ends.
        length_um: f64 = "length_um", within(0, 10000), or 0.0;
        /// On a mesh: length of a cell; 0: a barbule is one cell.
        cell_um: f64 = "cell_um", within(0, 10000), or 0.0;
    }
}

/// What the lower sides of barbules are made of.
#[derive(Debug, Clone, PartialEq)]
pub enum Under {
    /// The lower sides of the material's own barbules where these are known, keratin elsewhere; which of both whoever reads materials
    /// says. Its name is no one's.
    Own(Slot<LowerSide>),
    /// Keratin.
    Keratin,
    /// Another material, as lit from its upper side.
    Material(Slot<FeatherBrdf>),
}

/// The lower side of a material's own barbules: its BRDF, or `None` where it is keratin.
#[derive(Debug, Clone)]
pub struct LowerSide(pub Option<Arc<FeatherBrdf>>);

impl Default for Under {
    fn default() -> Self {
        Self::Own(Slot::new(Self::DEFAULT))
    }
}

impl Under {
    const DEFAULT: &str = "default";
    /// The word for keratin, and what stands for the hash of its BRDF.
    pub const KERATIN: &str = "keratin";

    /// As files say it: `default`, `keratin` or the name of a material.
    #[must_use]
    pub fn named(name: &str) -> Self {
        match name {
            Self::DEFAULT => Self::default(),
            Self::KERATIN => Self::Keratin,
            material => Self::Material(Slot::new(material)),
        }
    }

    /// Whether it is what holds where nothing is said.
    pub(super) fn is_default(&self) -> bool {
        matches!(self, Self::Own(_))
    }

    fn name(&self) -> &str {
        match self {
            Self::Own(_) => Self::DEFAULT,
            Self::Keratin => Self::KERATIN,
            Self::Material(slot) => &slot.name,
        }
    }

    fn is_read(&self) -> bool {
        match self {
            Self::Own(slot) => slot.is_read(),
            Self::Keratin => true,
            Self::Material(slot) => slot.is_read(),
        }
    }

    /// The BRDF of lower sides, where they have one.
    fn brdf(&self) -> Result<Option<Arc<FeatherBrdf>>> {
        Ok(match self {
            Self::Own(slot) => slot.value()?.0.clone(),
            Self::Keratin => None,
            Self::Material(slot) => Some(slot.value()?.clone()),
        })
    }
}

impl FieldValue for Under {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        value.as_str().map(Self::named).ok_or_else(|| wrong_kind(value, path, "a text in quotes"))
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        Some(self.name().into())
    }

    fn check_value(&self, _: &str, (): &()) -> Result<()> {
        Ok(())
    }

    /// What was read, however it was named.
    fn feed_value(&self, key: &str, to: &mut Hasher) {
        let hash = match self {
            Self::Own(slot) => slot.hash(),
            Self::Keratin => "",
            Self::Material(slot) => slot.hash(),
        };
        to.text(key, if hash.is_empty() { self.name() } else { hash });
    }

    fn kind((): &()) -> Kind {
        Kind::Text("default, keratin, or a species, structure or .barbule file")
    }
}

impl BarbuleClothing {
    /// Barbules of this material where nothing else is said.
    #[must_use]
    pub fn of(material: &str) -> Self {
        Self {
            material: Slot::new(material),
            under: Under::default(),
            underside: UNDERSIDE,
            reciprocity: Reciprocity::Steeper,
            uv_mm: [1.0; 2],
            width_um: 0.0,
            length_um: 0.0,
            cell_um: 0.0,
        }
    }

    /// The surface of barbules that differ from place to place like this.
    pub(super) fn barbules(&self, cells: Cells) -> Result<BarbuleSurface> {
        self.surface(cells, self.under.brdf()?)
    }

    fn surface(&self, cells: Cells, below: Option<Arc<FeatherBrdf>>) -> Result<BarbuleSurface> {
        Ok(BarbuleSurface {
            brdf: self.reciprocal(self.material.value()?),
            instances: true,
            below: below.map(|brdf| self.reciprocal(&brdf)),
            under: self.underside.build()?,
            cells,
            opacity: 1.0,
        })
    }

    fn reciprocal(&self, brdf: &FeatherBrdf) -> Arc<FeatherBrdf> {
        Arc::new(brdf.reciprocal_by(self.reciprocity))
    }

    /// What a mesh or curve wears. Lower sides that no light reaches were not read.
    pub(super) fn clad(&self) -> Result<Clad> {
        let [width_mm, length_mm, cell_mm] =
            [self.width_um, self.length_um, self.cell_um].map(|um| 1e-3 * um);
        let layout = Layout { uv_mm: self.uv_mm, width_mm, length_mm, cell_mm, swelling: 0.0 };
        let below = if self.under.is_read() { self.under.brdf()? } else { None };
        Clad::new(self.surface(Cells::default(), below)?, layout)
    }
}
