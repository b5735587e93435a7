//! What an atlas will take: time, files, bytes and memory, before its first unit.

use std::time::Duration;

use super::Atlas;
use crate::campaign::spectrum::{SpectrumRequest, spectra_by};
use crate::campaign::{Demand, Keep, Results, spectrum_bytes};
use crate::clock;
use crate::progress::{OnlyStops, Progress};
use crate::spectrum::Wavelengths;
use crate::structure::Structure;
use crate::{Error, Result};

/// Cells that are tried, spread over all.
const TRIED: usize = 5;

/// Wavelengths at which they are.
const FEW_WAVELENGTHS: usize = 3;

/// Cells of a unit run side by side, and one that waits for its individuals may begin another.
const SIDE_BY_SIDE: u64 = 2;

/// What a material has in a file for each wavelength and direction, and at all, bytes: those that ship have 27.
const MATERIAL_NODE_BYTES: usize = 27;
const MATERIAL_BYTES: usize = 20_000;

/// What an atlas will take.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecast {
    /// Structures.
    pub cells: usize,
    /// Units of work.
    pub units: usize,
    /// Files of the finished store.
    pub files: usize,
    /// Bytes of the finished store.
    pub bytes: u64,
    /// Memory of one process, bytes.
    pub memory_bytes: u64,
    /// Cores that the times below are for.
    pub cores: usize,
    /// Seconds that each of the cells took that were tried, as a whole one would: spectra, and what its material will take.
    pub cell_seconds: Vec<f64>,
    /// Seconds of everything on so many cores.
    pub seconds: f64,
}

impl Forecast {
    /// Hours of one core that everything takes.
    #[must_use]
    pub fn core_hours(&self) -> f64 {
        self.seconds * self.cores as f64 / 3600.0
    }
}

/// Tries a few cells at a few wavelengths with a few individuals, on all threads of this pool.
///
/// # Errors
/// None of the cells that are tried is a structure, one cannot be simulated, or a stop.
pub fn foretell(atlas: &Atlas, progress: &dyn Progress) -> Result<Forecast> {
    let (cells, cores) = (atlas.cells(), rayon::current_num_threads());
    let mut tried: Vec<usize> = (0..TRIED).map(|i| i * (cells - 1) / (TRIED - 1)).collect();
    tried.dedup();
    progress.begin("trying a few structures", tried.len() as u64);
    let quiet = OnlyStops(progress);
    let (mut cell_seconds, mut memory_bytes, mut material_bytes) = (Vec::new(), 0, 0);
    for cell in tried {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let made = atlas.structure(cell).and_then(|one| one.instance(atlas.seed, 0).map(|_| one));
        let structure = match made {
            Ok(structure) => structure,
            Err(error) if atlas.may_be_empty && error.is_input() => continue,
            Err(error) => return Err(error),
        };
        let request = atlas.request(&structure);
        let own = spectrum_bytes(&structure, &request)?;
        let mut seconds = seconds_of(atlas, &structure, &request, cores, &quiet)?;
        let mut memory = own.saturating_mul(SIDE_BY_SIDE);
        if let Some(options) = &atlas.material {
            let plan = options.plan(structure)?;
            seconds += plan.seconds(cores);
            let demand =
                Demand::bound(&plan.structure, &plan.parameters, Keep::Statistics, Results::Gathered)?;
            memory = memory.saturating_add(demand.bytes(demand.most_units.min(cores)));
            material_bytes = MATERIAL_BYTES + MATERIAL_NODE_BYTES * plan.parameters.axes.len();
        }
        memory_bytes = memory_bytes.max(memory);
        cell_seconds.push(seconds);
        progress.advance(1);
    }
    if cell_seconds.is_empty() {
        return Err(Error::input("none of the cells that were tried is a structure; give other values"));
    }
    let mean = cell_seconds.iter().sum::<f64>() / cell_seconds.len() as f64;
    let layout = atlas.layout();
    Ok(Forecast {
        cells,
        units: layout.units(),
        files: layout.files(),
        bytes: (layout.bytes() + material_bytes * cells) as u64,
        memory_bytes,
        cores,
        seconds: mean * cells as f64,
        cell_seconds,
    })
}

/// Seconds of a cell's spectra on all cores, from a part of its wavelengths and individuals. What all individuals share (the
/// orders of a crystal) is told from what each takes by two rounds on all cores against one.
fn seconds_of(
    atlas: &Atlas,
    structure: &Structure,
    request: &SpectrumRequest,
    cores: usize,
    progress: &dyn Progress,
) -> Result<f64> {
    let nm = request.wavelengths.nm();
    let few: Vec<f64> = match nm.len() {
        0..=FEW_WAVELENGTHS => nm.to_vec(),
        count => [0, count / 2, count - 1].map(|i| nm[i]).to_vec(),
    };
    let part = |wavelengths: &[f64], instances: usize| -> Result<f64> {
        let request = SpectrumRequest {
            wavelengths: Wavelengths::new(wavelengths.to_vec())?,
            instances,
            ..request.clone()
        };
        let began = clock::system();
        spectra_by(atlas.width, structure, &request, progress)?;
        Ok(since(began))
    };
    let (all, round) = (request.instances, cores.min(request.instances));
    let twice = (2 * round).min(all);
    // The first use of anything pays for what is made once.
    part(&few[..1], round)?;
    let of_rounds = |wavelengths: &[f64]| -> Result<f64> {
        let one = part(wavelengths, round)?;
        if twice == round {
            return Ok(one);
        }
        let each = (part(wavelengths, twice)? - one).max(0.0) / (twice - round) as f64;
        Ok((one - each * round as f64).max(0.0) + each * all as f64)
    };
    let (single, several) = (of_rounds(&few[..1])?, of_rounds(&few)?);
    let seconds = if few.len() < 2 {
        single
    } else {
        let each = (several - single).max(0.0) / (few.len() - 1) as f64;
        (single - each).max(0.0) + each * nm.len() as f64
    };
    // A cell with fewer individuals than cores leaves the others to its neighbours.
    Ok(seconds * round as f64 / cores as f64)
}

fn since(began: Duration) -> f64 {
    (clock::system() - began).as_secs_f64()
}
