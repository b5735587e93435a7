//! Atlases: sweeps over the sizes of a species or a stack, into one store of spectra, colours and materials.
//!
//! A [`Plan`] is what a file says; an [`Atlas`] is a plan whose names are opened and whose cells are known. [`run`] computes the
//! units of work that a store lacks, [`foretell`] what that takes, [`schedule`](Schedule) how it goes on many workers.
//!
//! ```
//! use barbule::Unobserved;
//! use barbule::atlas::{Atlas, Plan, run};
//! use barbule::math::simd::Width;
//! use barbule::open::Opening;
//! use barbule::progress::Shard;
//!
//! # fn main() -> barbule::Result<()> {
//! let plan = Plan::parse(
//!     "barbule = 1
//!      name = 'films'
//!      structure = 'air/keratin:300/melanin'
//!      [[vary]]
//!      key = 'layer1'
//!      values = '200:400:100'",
//! )?;
//! let atlas = Atlas::new(&plan, ".".as_ref(), &Opening::default(), Width::best(), &Unobserved)?;
//! # let folder = tempfile::tempdir().unwrap();
//! let store = atlas.create(&folder.path().join("films.zarr"))?;
//! run(&atlas, &store, &atlas.units(Shard::WHOLE), &Unobserved)?;
//! let mean = store.numbers("mean")?;
//! assert_eq!((mean.len(), mean[0].as_ref().unwrap().len()), (3, 50));
//! # Ok(())
//! # }
//! ```

mod cell;
mod contents;
mod design;
mod foretell;
mod plan;
mod run;
mod schedule;
mod steps;
mod subject;
#[cfg(test)]
mod tests;

use std::path::Path;

use rayon::prelude::*;
use serde_json::Value;

pub use foretell::{Forecast, foretell, foretell_by, memory_bytes};
pub use plan::{Impossible, Materials, Patch, Plan, Plane, Vary};
pub use run::{Outcome, run};
pub use schedule::{Faults, Schedule};
pub use steps::{Counted, Steps};

use self::contents::Contents;
use self::design::Design;
use self::plan::placed;
use self::subject::Subject;
use crate::characterize::{CampaignOptions, outside_wavelengths};
use crate::io::sweep::{SweepLayout, SweepStore};
use crate::math::simd::Width;
use crate::open::{Opening, eye, light};
use crate::progress::{Progress, Shard};
use crate::spectrum::look::Look;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::structure::Structure;
use crate::vision::View;
use crate::{Error, Result};

/// Angles of incidence, degrees: all below. And how many there are, at most.
const GRAZING_DEG: f64 = 90.0;
const MOST_ANGLES: usize = 1_000;

/// A plan whose names are opened and whose cells are known.
pub struct Atlas {
    name: String,
    /// Patches by their names; without patches one without a name.
    subjects: Vec<(String, Subject)>,
    design: Design,
    wavelengths: Wavelengths,
    angles_deg: Vec<f64>,
    plane: Plane,
    individuals: usize,
    seed: u64,
    views: Vec<(String, View)>,
    /// Whether the wavelengths are enough of what the eye sees.
    has_colours: bool,
    material: Option<CampaignOptions>,
    may_be_empty: bool,
    width: Width,
    layout: SweepLayout,
}

impl Atlas {
    /// Opens what a plan names, files from `folder`, and refuses it before any work where a cell makes no structure.
    ///
    /// # Errors
    /// A structure, bird or light that is not found; a key that a structure does not have, or a value out of its range; sizes that
    /// make no structure, unless the plan leaves such cells empty; wavelengths or angles that cannot be simulated; too many cells.
    pub fn new(
        plan: &Plan,
        folder: &Path,
        opening: &Opening,
        width: Width,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let subjects = subjects(plan, folder, opening, progress)?;
        let design = Design::new(plan, &subjects, opening.seed)?;
        let wavelengths = wavelengths(&plan.wavelengths_nm, "wavelengths_nm")?;
        let angles_deg = plan.angles_deg.values("angles_deg")?;
        if let Some(bad) = angles_deg.iter().find(|angle| angle.abs() >= GRAZING_DEG) {
            return Err(Error::input(format!("angles_deg has {bad}; give angles between -90 and 90"))
                .about("angles_deg"));
        }
        if angles_deg.len() > MOST_ANGLES {
            let count = angles_deg.len();
            return Err(Error::input(format!(
                "angles_deg has {count} values, over {MOST_ANGLES}; give fewer"
            ))
            .about("angles_deg"));
        }
        let views = views(plan, folder, &wavelengths)?;
        let black = Spectrum::new(wavelengths.clone(), vec![0.0; wavelengths.len()])?;
        let material = plan.material.as_ref().map(|material| campaign(material, opening.seed)).transpose()?;
        let mut atlas = Self {
            name: plan.name.clone(),
            has_colours: Look::of(&black).colour.is_some(),
            subjects,
            design,
            wavelengths,
            angles_deg,
            plane: plan.plane,
            individuals: plan.individuals,
            seed: opening.seed,
            views,
            material,
            may_be_empty: plan.impossible == Impossible::Empty,
            width,
            layout: SweepLayout {
                name: plan.name.clone(),
                width: width.name().to_owned(),
                cells: Vec::new(),
                block: Vec::new(),
                further: Vec::new(),
                coordinates: Vec::new(),
                arrays: Vec::new(),
                with_materials: false,
                description: Value::Null,
            },
        };
        atlas.layout = Contents::of(&atlas, plan)?.layout();
        if !atlas.may_be_empty {
            atlas.check_cells(progress)?;
        }
        Ok(atlas)
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What its store is made of.
    #[must_use]
    pub fn layout(&self) -> &SweepLayout {
        &self.layout
    }

    /// All cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.layout.count()
    }

    /// Whether each cell has a colour.
    #[must_use]
    pub fn has_colours(&self) -> bool {
        self.has_colours
    }

    /// The wavelengths of the spectra.
    #[must_use]
    pub fn wavelengths(&self) -> &Wavelengths {
        &self.wavelengths
    }

    /// The angles of incidence, degrees.
    #[must_use]
    pub fn angles_deg(&self) -> &[f64] {
        &self.angles_deg
    }

    /// Creates its store, or opens the one that is there to go on.
    ///
    /// # Errors
    /// As [`SweepStore::create`].
    pub fn create(&self, path: &Path) -> Result<SweepStore> {
        SweepStore::create(path, self.layout.clone())
    }

    /// Opens its store.
    ///
    /// # Errors
    /// As [`SweepStore::open`].
    pub fn open(&self, path: &Path) -> Result<SweepStore> {
        SweepStore::open(path, self.layout.clone())
    }

    /// The units of work of one of several parts: every so manieth, so that all parts take about as long.
    #[must_use]
    pub fn units(&self, shard: Shard) -> Vec<usize> {
        shard.every(self.layout.units()).collect()
    }

    /// The sizes of a cell by their keys, in the order of the plan.
    ///
    /// # Panics
    /// There is no such cell.
    #[must_use]
    pub fn sizes(&self, cell: usize) -> Vec<(String, f64)> {
        let (_, place) = self.place(cell);
        self.design.sizes(&place)
    }

    /// A cell in words, as in `gorget, cortex_um 0.3, gap_um 0.06`.
    #[must_use]
    pub fn words(&self, cell: usize) -> String {
        let (patch, _) = self.place(cell);
        let name = Some(self.subjects[patch].0.clone()).filter(|name| !name.is_empty());
        let sizes = self.sizes(cell).into_iter().map(|(key, size)| format!("{key} {size}"));
        name.into_iter().chain(sizes).collect::<Vec<_>>().join(", ")
    }

    /// The structure of a cell.
    ///
    /// # Errors
    /// Its sizes make none.
    pub fn structure(&self, cell: usize) -> Result<Structure> {
        self.subject(cell).and_then(|subject| subject.structure())
    }

    /// The text of the file of a cell's structure.
    ///
    /// # Errors
    /// Its sizes make no structure.
    pub fn toml(&self, cell: usize) -> Result<String> {
        self.subject(cell)?.toml()
    }

    /// The patch of a cell, and its place along the axes of keys.
    fn place(&self, cell: usize) -> (usize, Vec<usize>) {
        let mut place = self.layout.place_of(cell);
        let patch = if self.has_patches() { place.remove(0) } else { 0 };
        (patch, place)
    }

    fn has_patches(&self) -> bool {
        self.subjects.iter().any(|(name, _)| !name.is_empty())
    }

    fn subject(&self, cell: usize) -> Result<Subject> {
        let (patch, place) = self.place(cell);
        let subject = self.subjects[patch].1.with(&self.design.sizes(&place));
        subject.map_err(|error| error.at(self.words(cell)))
    }

    /// Refuses the first cell whose sizes make no structure.
    fn check_cells(&self, progress: &dyn Progress) -> Result<()> {
        let cells = self.cells();
        progress.begin("checking structures", cells as u64);
        let one = |cell: usize| {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let made = self.structure(cell).and_then(|structure| structure.instance(self.seed, 0).map(drop));
            progress.advance(1);
            made.map_err(|error| {
                let about = format!("cell {cell} ({})", self.words(cell));
                error.at(about).followed_by("; give other values, or impossible = \"empty\"")
            })
        };
        // The first of all, whichever thread finds its own sooner.
        (0..cells).into_par_iter().find_map_first(|cell| one(cell).err()).map_or(Ok(()), Err)
    }
}

fn subjects(
    plan: &Plan,
    folder: &Path,
    opening: &Opening,
    progress: &dyn Progress,
) -> Result<Vec<(String, Subject)>> {
    let one = |(index, patch): (usize, Patch)| {
        let key = |name: &str| {
            if patch.name.is_empty() { name.to_owned() } else { format!("patches[{index}].{name}") }
        };
        let text = patch.structure.as_ref().or(plan.structure.as_ref());
        let text = text.ok_or_else(|| Error::input(format!("{} is missing", key("structure"))))?;
        let from = if patch.structure.is_some() { key("structure") } else { "structure".to_owned() };
        let subject = Subject::open(&placed(text, folder), opening, progress).map_err(|e| e.at(from))?;
        let fixed: Vec<(String, f64)> = patch.set.0.iter().map(|(key, size)| (key.clone(), *size)).collect();
        for (name, _) in &fixed {
            subject.size(name).map_err(|e| e.at(key("set")))?;
        }
        let subject =
            if fixed.is_empty() { subject } else { subject.with(&fixed).map_err(|e| e.at(key("set")))? };
        Ok((patch.name.clone(), subject))
    };
    plan.all_patches().into_iter().enumerate().map(one).collect()
}

/// Wavelengths that can be simulated.
fn wavelengths(steps: &Steps, key: &str) -> Result<Wavelengths> {
    let mut nm = steps.values(key)?;
    nm.sort_by(f64::total_cmp);
    if let Some(outside) = nm.iter().find_map(|nm| outside_wavelengths(*nm)) {
        return Err(Error::input(format!("{key}: {outside}")).about(key));
    }
    Wavelengths::new(nm)
}

/// The birds that look, each of which must see enough within the wavelengths.
fn views(plan: &Plan, folder: &Path, wavelengths: &Wavelengths) -> Result<Vec<(String, View)>> {
    let of = |name: &String| -> Result<(String, View)> {
        let view = View::new(eye(&placed(name, folder))?, light(&placed(&plan.illuminant, folder))?)?;
        view.check("the reflectance", wavelengths.range_nm().into())
            .map_err(|error| error.followed_by("; birds see from 300 nm: wavelengths_nm = \"300:700:4\""))?;
        Ok((name.clone(), view))
    };
    let at = |index: usize, error: Error| error.at(format!("birds[{index}]"));
    plan.birds.iter().enumerate().map(|(index, name)| of(name).map_err(|error| at(index, error))).collect()
}

/// The campaign of a cell's material.
fn campaign(material: &Materials, seed: u64) -> Result<CampaignOptions> {
    let usual = CampaignOptions::default();
    let wavelengths_nm = match &material.wavelengths_nm {
        Some(steps) => wavelengths(steps, "material.wavelengths_nm")?.nm().to_vec(),
        None => usual.wavelengths_nm.clone(),
    };
    let options = CampaignOptions {
        wavelengths_nm,
        directions: material.directions,
        instances: material.individuals,
        tilt_deg: material.tilt_deg,
        polarized: material.polarized,
        thin: material.thin,
        seed,
        ..usual
    };
    options.check().map_err(|error| error.at("material"))?;
    Ok(options)
}
