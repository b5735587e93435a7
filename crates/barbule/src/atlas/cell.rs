//! What one cell reflects, and how it looks.

use super::contents::{MEAN, NORMALIZED, PEAK, SRGB, STD, XYZ, catches};
use super::{Atlas, Plane};
use crate::Result;
use crate::brdf::encode_material;
use crate::brdf::fit::FitOptions;
use crate::campaign::Resources;
use crate::campaign::spectrum::{Collect, SpectrumRequest, spectra_by};
use crate::characterize::{Catalog, Execution, characterize};
use crate::io::sweep::SweepValues;
use crate::progress::Progress;
use crate::spectrum::Spectrum;
use crate::spectrum::look::Look;
use crate::structure::Structure;

/// The values of a cell, one for each array of the store in its order, and its material.
pub(super) struct Cell {
    pub(super) values: Vec<SweepValues>,
    pub(super) material: Option<Vec<u8>>,
}

impl Atlas {
    /// What is asked of the structure of a cell.
    pub(super) fn request(&self, structure: &Structure) -> SpectrumRequest {
        let direction = |angle: &f64| match self.plane {
            Plane::Across => (0.0, angle.to_radians()),
            Plane::Along => (angle.to_radians(), 0.0),
        };
        SpectrumRequest {
            wavelengths: self.wavelengths.clone(),
            directions: self.angles_deg.iter().map(direction).collect(),
            instances: structure.count().map_or(self.individuals, |given| given.min(self.individuals)),
            seed: self.seed,
            collect: Collect::Hemisphere,
            polarization: [0.5; 2],
        }
    }

    /// The structure of a cell; none where its sizes make none and the plan leaves such cells empty.
    ///
    /// # Errors
    /// Its sizes make no structure and the plan has no empty cells.
    pub(super) fn possible(&self, cell: usize) -> Result<Option<Structure>> {
        match self.structure(cell).and_then(|one| one.instance(self.seed, 0).map(|_| one)) {
            Ok(structure) => Ok(Some(structure)),
            Err(error) if self.may_be_empty && error.is_input() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Simulates a cell.
    ///
    /// # Errors
    /// Its sizes make no structure and the plan has no empty cells, a medium's table does not reach a wavelength, or a stop.
    pub(super) fn cell(&self, cell: usize, catalog: &Catalog, progress: &dyn Progress) -> Result<Cell> {
        let Some(structure) = self.possible(cell)? else { return Ok(self.empty()) };
        let at =
            |error: crate::Error| if error.is_interrupted() { error } else { error.at(self.words(cell)) };
        let found = spectra_by(self.width, &structure, &self.request(&structure), progress).map_err(at)?;
        let is_possible = |value: &f64| value.is_finite() && *value >= 0.0;
        if !found.mean.iter().chain(&found.std).flatten().all(is_possible) {
            let what = "came out with a reflectance that is not finite, or negative";
            return Err(crate::Error::not_settled(format!("cell {cell} ({}) {what}", self.words(cell))));
        }
        let spectrum = |mean: &Vec<f64>| Spectrum::new(self.wavelengths.clone(), mean.clone());
        let means = found.mean.iter().map(spectrum).collect::<Result<Vec<_>>>()?;
        let looks: Vec<Look> = means.iter().map(Look::of).collect();
        let mut looked = Vec::with_capacity(self.views.len());
        for (_, view) in &self.views {
            let of = |mean: &Spectrum| view.catches(mean).map(|catches| catches.cones);
            looked.push(means.iter().map(of).collect::<Result<Vec<_>>>()?.concat());
        }
        let colours = |of: &dyn Fn(&Look) -> [u8; 3]| SweepValues::Bytes(looks.iter().flat_map(of).collect());
        let value = |name: &str| match name {
            MEAN => SweepValues::Floats(found.mean.concat()),
            STD => SweepValues::Floats(found.std.concat()),
            PEAK => {
                SweepValues::Floats(looks.iter().map(|l| l.peak.map_or(f64::NAN, |peak| peak.nm)).collect())
            }
            XYZ => SweepValues::Floats(
                looks.iter().flat_map(|l| l.colour.map_or([f64::NAN; 3], |c| c.xyz)).collect(),
            ),
            SRGB => colours(&|look| look.colour.map_or([0; 3], |colour| colour.srgb())),
            NORMALIZED => colours(&|look| look.colour.map_or([0; 3], |colour| colour.srgb_normalized())),
            bird => {
                let index = (0..self.views.len()).find(|index| catches(self, *index) == bird);
                SweepValues::Floats(index.map_or_else(Vec::new, |index| looked[index].clone()))
            }
        };
        let values = self.layout.arrays.iter().map(|array| value(&array.name)).collect();
        let material = match &self.material {
            None => None,
            Some(options) => {
                let plan = options.plan(structure)?;
                let resources = Resources { width: self.width, ..Resources::default() };
                let how = Execution { resources, store: None };
                let made =
                    characterize(&plan, &FitOptions::default(), catalog, &how, progress).map_err(at)?;
                Some(encode_material(&made.material)?)
            }
        };
        Ok(Cell { values, material })
    }

    /// A cell that is no structure.
    fn empty(&self) -> Cell {
        let each = |(index, array): (usize, &crate::io::sweep::SweepArray)| {
            let count = self.layout.cell_len(index);
            if array.is_bytes {
                SweepValues::Bytes(vec![0; count])
            } else {
                SweepValues::Floats(vec![f64::NAN; count])
            }
        };
        Cell { values: self.layout.arrays.iter().enumerate().map(each).collect(), material: None }
    }
}
