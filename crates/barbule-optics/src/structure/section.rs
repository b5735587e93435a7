//! One barbule's cross section: open boundaries from the top down, the media between them, and closed inclusions.
//!
//! A [`Section`] is valid by construction: what [`Section::new`] refuses, solvers need not look for.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::check;
use super::crystal::{self, CrystalLayer};
use super::lattice::Lattice;
use crate::error::shortened;
use crate::material::{Library, Material};
use crate::stack::Stack;
use crate::{Complex64, Error, Result};

/// No coordinate of a section is larger than this.
pub const LARGEST_COORDINATE_UM: f64 = 1000.0;

/// The width of a planar stack as a section.
pub const FLAT_WIDTH_UM: f64 = 25.0;

/// No section has more points than this.
pub const MOST_POINTS: usize = 1_000_000;

/// Points that a circle counts for, and that stand for it where polygons are needed.
const CIRCLE_POINTS: usize = 64;

/// An open curve along the barbule: x increases strictly.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Polyline {
    /// Positions across the barbule.
    pub x_um: Vec<f64>,
    /// Heights.
    pub z_um: Vec<f64>,
}

impl Polyline {
    /// Height at `x_um`, linear between points; beyond the ends the end segments' lines go on.
    #[must_use]
    pub fn height(&self, x_um: f64) -> f64 {
        let last = self.x_um.len() - 1;
        let right = self.x_um.partition_point(|&x| x <= x_um).clamp(1, last);
        let (x0, x1) = (self.x_um[right - 1], self.x_um[right]);
        let (z0, z1) = (self.z_um[right - 1], self.z_um[right]);
        z0 + (z1 - z0) * ((x_um - x0) / (x1 - x0))
    }
}

/// A medium without position dependence, by name or by index.
#[derive(Debug, Clone, PartialEq)]
pub enum Substance {
    /// A name of the section's library, or an expression such as `mix(keratin,melanin,0.4)`.
    Named(String),
    /// A complex index, the same at every wavelength.
    Index(Complex64),
}

impl Substance {
    /// A named substance.
    #[must_use]
    pub fn named(name: &str) -> Self {
        Self::Named(name.to_owned())
    }

    /// Its words in legends.
    #[must_use]
    pub fn label(&self) -> String {
        match self {
            Self::Named(name) => name.clone(),
            Self::Index(n) if n.im == 0.0 => format!("n = {}", n.re),
            Self::Index(n) => format!("n = {}+{}j", n.re, n.im),
        }
    }
}

/// What fills a region.
#[derive(Debug, Clone, PartialEq)]
pub enum Medium {
    /// The same everywhere.
    Pure(Substance),
    /// A mixture whose volume fraction of `second` varies along x.
    Mixture {
        /// The medium where the fraction is 0.
        first: Substance,
        /// The medium where the fraction is 1.
        second: Substance,
        /// Positions, increasing strictly.
        x_um: Vec<f64>,
        /// Fraction at each position, 0 to 1; linear between, constant beyond the ends.
        fraction: Vec<f64>,
    },
}

impl Medium {
    /// A pure medium by name.
    #[must_use]
    pub fn named(name: &str) -> Self {
        Self::Pure(Substance::named(name))
    }

    /// The fraction of the second substance at `x_um`; 0 for a pure medium.
    #[must_use]
    pub fn fraction(&self, x_um: f64) -> f64 {
        let Self::Mixture { x_um: xs, fraction, .. } = self else { return 0.0 };
        profile(xs, fraction, x_um)
    }

    /// Its substances: one, or two for a mixture.
    pub fn substances(&self) -> impl Iterator<Item = &Substance> {
        match self {
            Self::Pure(substance) => [Some(substance), None],
            Self::Mixture { first, second, .. } => [Some(first), Some(second)],
        }
        .into_iter()
        .flatten()
    }
}

/// A closed curve.
#[derive(Debug, Clone, PartialEq)]
pub enum Loop {
    /// Corners in order, either sense of rotation; the last joins the first.
    Polygon(Polyline),
    /// A circle, exact for rays.
    Circle {
        /// Centre across the barbule.
        x_um: f64,
        /// Centre's height.
        z_um: f64,
        /// Radius.
        radius_um: f64,
    },
}

impl Loop {
    /// A polygon of these corners.
    #[must_use]
    pub fn polygon(x_um: Vec<f64>, z_um: Vec<f64>) -> Self {
        Self::Polygon(Polyline { x_um, z_um })
    }

    /// How many points it counts for.
    #[must_use]
    pub fn points(&self) -> usize {
        match self {
            Self::Polygon(corners) => corners.x_um.len(),
            Self::Circle { .. } => CIRCLE_POINTS,
        }
    }

    /// Its corners; a circle is sampled by 64 of them.
    #[must_use]
    pub fn corners(&self) -> Polyline {
        match self {
            Self::Polygon(corners) => corners.clone(),
            Self::Circle { x_um, z_um, radius_um } => {
                let angle = |i| std::f64::consts::TAU * i as f64 / CIRCLE_POINTS as f64;
                Polyline {
                    x_um: (0..CIRCLE_POINTS).map(|i| x_um + radius_um * libm::cos(angle(i))).collect(),
                    z_um: (0..CIRCLE_POINTS).map(|i| z_um + radius_um * libm::sin(angle(i))).collect(),
                }
            }
        }
    }
}

/// A closed region inside the section, in any depth of containment.
#[derive(Debug, Clone, PartialEq)]
pub struct Inclusion {
    /// Its outline.
    pub outline: Loop,
    /// What fills it.
    pub medium: Medium,
    /// Loops directly inside it in which the medium around the inclusion shows again.
    pub holes: Vec<Loop>,
}

/// Where a user's material came from, so that a written section finds it again.
#[derive(Debug, Clone, PartialEq)]
pub enum MaterialSource {
    /// A table of n and k.
    File(PathBuf),
    /// A constant index.
    Index(Complex64),
}

/// The parts of a section before they are checked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parts {
    /// What it is called.
    pub name: String,
    /// The barbule's width; `None`: the inclusions' bounding box (only without boundaries).
    pub width_um: Option<f64>,
    /// Open curves from the top down.
    pub boundaries: Vec<Polyline>,
    /// What lies above, between and below the boundaries: one more than these.
    pub media: Vec<Medium>,
    /// Closed regions.
    pub inclusions: Vec<Inclusion>,
    /// A photonic crystal under the top, which is then the only boundary.
    pub crystal: Option<CrystalLayer>,
    /// Where it came from.
    pub source: String,
}

/// How far the middle of a top may lie from x = 0, as a part of its width: windows and beams stand at x = 0.
const OFF_CENTRE: f64 = 1e-2;

impl Parts {
    /// Moved along x so that the middle of the top is at 0, unless it is nearly there.
    ///
    /// # Errors
    /// A crystal under such a top: its place is told along the top from x = 0.
    fn centred(mut self) -> Result<Self> {
        let Some(Polyline { x_um, .. }) = self.boundaries.first() else { return Ok(self) };
        let (left, right) = (x_um[0], x_um[x_um.len() - 1]);
        let middle = 0.5 * (left + right);
        if middle.abs() <= OFF_CENTRE * (right - left) {
            return Ok(self);
        }
        if self.crystal.is_some() {
            return refuse(format!(
                "boundaries[0] runs from x = {left} to {right} µm; over a lattice move it so that its middle is at x = 0"
            ));
        }
        let moved = |xs: &mut Vec<f64>| xs.iter_mut().for_each(|x| *x -= middle);
        let moved_loop = |one: &mut Loop| match one {
            Loop::Polygon(corners) => moved(&mut corners.x_um),
            Loop::Circle { x_um, .. } => *x_um -= middle,
        };
        self.boundaries.iter_mut().for_each(|boundary| moved(&mut boundary.x_um));
        for inclusion in &mut self.inclusions {
            moved_loop(&mut inclusion.outline);
            inclusion.holes.iter_mut().for_each(moved_loop);
        }
        let media =
            self.media.iter_mut().chain(self.inclusions.iter_mut().map(|inclusion| &mut inclusion.medium));
        for medium in media {
            if let Medium::Mixture { x_um, .. } = medium {
                moved(x_um);
            }
        }
        Ok(self)
    }
}

/// A barbule's cross section that has passed every check.
///
/// The medium of a point is that of the innermost inclusion that holds it, else `media[k]` with k the number of
/// boundaries above the point.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Section {
    /// What it is called.
    pub name: String,
    /// The barbule's width.
    pub width_um: f64,
    /// Open curves from the top down; none in a section of inclusions alone.
    pub boundaries: Vec<Polyline>,
    /// What lies above, between and below the boundaries: one more than these.
    pub media: Vec<Medium>,
    /// Closed regions.
    pub inclusions: Vec<Inclusion>,
    /// A photonic crystal under the top, which is then the only boundary.
    pub crystal: Option<CrystalLayer>,
    /// Where it came from.
    pub source: String,
    /// The materials that names mean.
    pub library: Library,
    /// The user's own among them.
    pub materials: BTreeMap<String, MaterialSource>,
    /// The standard deviation, µm, over which the fast simulation averages inclusions along the top; `None`: not at all. Full
    /// waves need none.
    pub smooth_um: Option<f64>,
    pub(super) nesting: check::Nesting,
}

impl Section {
    /// Checks the parts of a section whose media are found in `library`.
    ///
    /// # Errors
    /// Anything that `docs/formats/section.md` lists; the message starts with the field and its index.
    pub fn new(parts: Parts, library: Library) -> Result<Self> {
        let nesting = check::check(&parts, &library)?;
        crystal::check(&parts)?;
        let parts = parts.centred()?;
        let width_um = match parts.width_um {
            Some(width) => width,
            None => check::bounding_width(&parts.inclusions),
        };
        let Parts { name, boundaries, media, inclusions, crystal, source, .. } = parts;
        let materials = BTreeMap::new();
        Ok(Self {
            name,
            width_um,
            boundaries,
            media,
            inclusions,
            crystal,
            source,
            library,
            materials,
            smooth_um: None,
            nesting,
        })
    }

    /// A planar stack as a flat section, [`FLAT_WIDTH_UM`] wide.
    ///
    /// # Errors
    /// The stack is over 1 mm thick, or names media that `library` does not have.
    pub fn flat(name: &str, stack: &Stack, library: Library) -> Result<Self> {
        let half = 0.5 * FLAT_WIDTH_UM;
        let mut height = 0.0;
        let mut boundaries = Vec::with_capacity(stack.layers() + 1);
        for layer in 0..=stack.layers() {
            boundaries.push(Polyline { x_um: vec![-half, 0.0, half], z_um: vec![height; 3] });
            height -= stack.thickness_nm().get(layer).map_or(0.0, |nm| nm * 1e-3);
        }
        let media = (0..stack.layers() + 2).map(|region| Medium::named(stack.medium(region))).collect();
        let source = format!("stack {}", shortened(name));
        let (name, width_um) = (name.to_owned(), Some(FLAT_WIDTH_UM));
        Self::new(Parts { name, width_um, boundaries, media, source, ..Parts::default() }, library)
    }

    /// A photonic crystal under a flat top, [`FLAT_WIDTH_UM`] wide.
    ///
    /// # Errors
    /// As [`Lattice::check`].
    pub fn flat_crystal(name: &str, lattice: Lattice) -> Result<Self> {
        let half = 0.5 * FLAT_WIDTH_UM;
        let library = lattice.library.clone();
        let parts = Parts {
            name: name.to_owned(),
            width_um: Some(FLAT_WIDTH_UM),
            boundaries: vec![Polyline { x_um: vec![-half, 0.0, half], z_um: vec![0.0; 3] }],
            media: [&lattice.incidence, &lattice.host].map(|medium| Medium::Pure(medium.clone())).to_vec(),
            crystal: Some(CrystalLayer { lattice, offset_um: 0.0, regularity: None }),
            source: format!("lattice {}", shortened(name)),
            ..Parts::default()
        };
        Self::new(parts, library)
    }

    /// The top boundary; empty in a section of inclusions alone.
    #[must_use]
    pub fn top(&self) -> &Polyline {
        static NONE: Polyline = Polyline { x_um: Vec::new(), z_um: Vec::new() };
        self.boundaries.first().unwrap_or(&NONE)
    }

    /// The material of a substance of this section.
    ///
    /// # Errors
    /// A name that the library does not have; never for the section's own media.
    pub fn material(&self, substance: &Substance) -> Result<Material> {
        material(substance, &self.library)
    }

    /// Refuses a section whose light would not come through air, which simulations take for granted.
    ///
    /// # Errors
    /// The first medium has an index other than 1 (by over 1e-3) at 550 nm, or varies along x.
    pub fn check_lit_through_air(&self) -> Result<()> {
        let index = match self.media.first() {
            Some(Medium::Pure(above)) => self.material(above)?.index(550.0)?,
            _ => Complex64::ZERO,
        };
        if (index - 1.0).norm() <= 1e-3 {
            return Ok(());
        }
        let above = self.media.first().and_then(|medium| medium.substances().next());
        let above = above.map_or_else(String::new, Substance::label);
        let found = if index == Complex64::ZERO {
            "which varies along x".to_owned()
        } else {
            format!("of index {:.4} + {:.4}i at 550 nm", index.re, index.im)
        };
        refuse(format!(
            "the light comes through {above}, {found}, but barbules are simulated in air, of index 1; let the first medium be the built-in air"
        ))
    }

    /// Refuses inclusions above the top for simulations that take the top for what light meets first.
    ///
    /// # Errors
    /// The first inclusion that lies above the top.
    pub fn check_nothing_above_top(&self) -> Result<()> {
        let is_above = |inclusion: &Inclusion| {
            // No loop crosses a boundary: one point of it decides.
            let (x_um, z_um) = match &inclusion.outline {
                Loop::Polygon(corners) => (corners.x_um[0], corners.z_um[0]),
                Loop::Circle { x_um, z_um, .. } => (*x_um, *z_um),
            };
            self.boundaries.first().is_some_and(|top| z_um > top.height(x_um))
        };
        match self.inclusions.iter().position(is_above) {
            None => Ok(()),
            Some(index) => refuse(format!(
                "inclusions[{index}] lies above the top, where only full waves see it; use these, leave it out, or draw the top above it"
            )),
        }
    }

    /// Every medium: between boundaries, then of the inclusions; the rods of a crystal have theirs in its lattice.
    pub fn all_media(&self) -> impl Iterator<Item = &Medium> {
        self.media.iter().chain(self.inclusions.iter().map(|i| &i.medium))
    }

    /// The medium of a point: slow, for pictures and tests.
    #[must_use]
    pub fn medium_at(&self, x_um: f64, z_um: f64) -> &Medium {
        match self.nesting.innermost(self, x_um, z_um) {
            Some(inclusion) => &self.inclusions[inclusion].medium,
            None => &self.media[self.boundaries.iter().filter(|b| b.height(x_um) > z_um).count()],
        }
    }
}

/// Values over increasing positions: linear between them, constant beyond the ends.
pub(super) fn profile(x_um: &[f64], values: &[f64], at_um: f64) -> f64 {
    let right = x_um.partition_point(|&x| x <= at_um);
    if right == 0 {
        return values[0];
    }
    if right == x_um.len() {
        return values[right - 1];
    }
    let part = (at_um - x_um[right - 1]) / (x_um[right] - x_um[right - 1]);
    values[right - 1] + (values[right] - values[right - 1]) * part
}

pub(super) fn material(substance: &Substance, library: &Library) -> Result<Material> {
    match substance {
        Substance::Named(name) => crate::material::parse(name, library),
        Substance::Index(index) => Material::constant(*index),
    }
}

/// An input error at a field.
pub(super) fn refuse<T>(message: String) -> Result<T> {
    Err(Error::input(message))
}
