//! What an atlas will take: time, files, bytes and memory, before its first unit.
//!
//! A few cells are tried with a few wavelengths and individuals, spectra and material each as they are computed then. Wavelengths are
//! tried in the middles of equal parts of them all, so that shorter ones, which take longer, weigh as much as they will.

use std::time::Duration;

use super::Atlas;
use crate::campaign::spectrum::{SpectrumRequest, spectra_by};
use crate::campaign::{
    Allowance, Campaign, CampaignParameters, Demand, Keep, Resources, Results, orders, spectrum_bytes,
    statistics,
};
use crate::characterize::CampaignOptions;
use crate::clock;
use crate::progress::{OnlyStops, Progress};
use crate::spectrum::Wavelengths;
use crate::structure::Structure;
use crate::{Error, Result};

/// Cells that are tried, spread over all, where nobody asks for more.
const TRIED: usize = 9;

/// Of so many cells one is tried at most, so that a forecast is a small part of the work.
const WORTH: usize = 4;

/// Wavelengths at which they are, at least, and seconds that a trial takes before it is believed.
const FEW_WAVELENGTHS: usize = 2;
const ENOUGH_S: f64 = 0.04;

/// Cells of a unit run side by side, and one that waits for its individuals may begin another.
const SIDE_BY_SIDE: usize = 2;

/// What a material has in a file for each wavelength and direction, and at all, bytes: those that ship have 27.
const MATERIAL_NODE_BYTES: usize = 27;
const MATERIAL_BYTES: usize = 5_000;

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
    /// Seconds on these that each of the cells takes that were tried: spectra and material.
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

/// Tries a few cells at a few wavelengths with a few individuals, on all threads of this pool; of small atlases fewer.
///
/// # Errors
/// A cell cannot be simulated, or a stop.
pub fn foretell(atlas: &Atlas, progress: &dyn Progress) -> Result<Forecast> {
    foretell_by(atlas, TRIED.min(atlas.cells().div_ceil(WORTH)), progress)
}

/// As [`foretell`], by so many cells.
///
/// # Errors
/// As [`foretell`].
pub fn foretell_by(atlas: &Atlas, tried: usize, progress: &dyn Progress) -> Result<Forecast> {
    let (cells, cores) = (atlas.cells(), rayon::current_num_threads());
    let tried = middles(cells, tried.max(1));
    progress.begin("trying a few structures", tried.len() as u64);
    let quiet = OnlyStops(progress);
    let mut cell_seconds = Vec::with_capacity(tried.len());
    let mut largest = Largest::default();
    for cell in tried {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        // A cell that is no structure takes no time, and there are others like it.
        let mut seconds = 0.0;
        if let Some(structure) = atlas.possible(cell)? {
            let request = atlas.request(&structure);
            seconds = spectra_seconds(atlas, &structure, &request, cores, &quiet)?;
            if let Some(options) = &atlas.material {
                seconds += material_seconds(atlas, options, &structure, cores, &quiet)?;
            }
            largest.look(atlas, structure)?;
        }
        cell_seconds.push(seconds);
        progress.advance(1);
    }
    let mean = cell_seconds.iter().sum::<f64>() / cell_seconds.len() as f64;
    let layout = atlas.layout();
    Ok(Forecast {
        cells,
        units: layout.units(),
        files: layout.files(),
        bytes: layout.bytes() + (largest.material_bytes() * cells) as u64,
        memory_bytes: largest.bytes(atlas, &quiet)?,
        cores,
        seconds: mean * cells as f64,
        cell_seconds,
    })
}

/// What a process takes in memory that computes an atlas on all threads of this pool, bytes, from a few cells. Hardly anything is simulated.
///
/// # Errors
/// A cell cannot be made, or a stop.
pub fn memory_bytes(atlas: &Atlas, progress: &dyn Progress) -> Result<u64> {
    let mut largest = Largest::default();
    for cell in middles(atlas.cells(), TRIED) {
        if let Some(structure) = atlas.possible(cell)? {
            largest.look(atlas, structure)?;
        }
    }
    largest.bytes(atlas, &OnlyStops(progress))
}

/// So many numbers below `count`, in the middles of as many equal parts; all of them where there are no more.
fn middles(count: usize, parts: usize) -> Vec<usize> {
    let parts = parts.min(count);
    (0..parts).map(|part| (2 * part + 1) * count / (2 * parts)).collect()
}

/// The cells that take most memory.
#[derive(Default)]
struct Largest {
    spectra: u64,
    /// The bound of the material's campaign, and its structure.
    material: Option<(u64, Structure)>,
    /// Wavelengths and directions of a material.
    nodes: usize,
}

impl Largest {
    fn look(&mut self, atlas: &Atlas, structure: Structure) -> Result<()> {
        self.spectra = self.spectra.max(spectrum_bytes(&structure, &atlas.request(&structure))?);
        let Some(options) = &atlas.material else { return Ok(()) };
        let plan = options.plan(structure)?;
        let bound = Demand::bound(&plan.structure, &plan.parameters, Keep::Statistics, Results::Gathered)?;
        let bound = bound.bytes(usize::MAX);
        self.nodes = plan.parameters.axes.len();
        if self.material.as_ref().is_none_or(|(most, _)| bound > *most) {
            self.material = Some((bound, plan.structure));
        }
        Ok(())
    }

    /// What the file of a material has, bytes.
    fn material_bytes(&self) -> usize {
        if self.nodes == 0 { 0 } else { MATERIAL_BYTES + MATERIAL_NODE_BYTES * self.nodes }
    }

    /// What a process takes: a cell's material comes after its spectra. A bound says too much, so one campaign is looked at closely.
    fn bytes(self, atlas: &Atlas, progress: &dyn Progress) -> Result<u64> {
        let unit_cells: usize = atlas.layout().block.iter().product();
        let spectra = self.spectra.saturating_mul(SIDE_BY_SIDE.min(unit_cells) as u64);
        let (Some(options), Some((_, structure))) = (&atlas.material, self.material) else {
            return Ok(spectra);
        };
        let plan = options.plan(structure)?;
        let (keep, results) = (Keep::Statistics, Results::Gathered);
        let demand =
            Demand::predict(&plan.structure, &plan.parameters, keep, results, Allowance::UNKNOWN, progress)?;
        Ok(spectra.max(demand.bytes(usize::MAX)))
    }
}

/// Seconds of a cell's spectra on all cores, from a part of its wavelengths and individuals.
fn spectra_seconds(
    atlas: &Atlas,
    structure: &Structure,
    request: &SpectrumRequest,
    cores: usize,
    progress: &dyn Progress,
) -> Result<f64> {
    let nm = request.wavelengths.nm();
    let (all, round) = (request.instances, cores.min(request.instances));
    let time = |count: usize, instances: usize| -> Result<f64> {
        let few: Vec<f64> = middles(nm.len(), count).into_iter().map(|i| nm[i]).collect();
        let wavelengths = Wavelengths::new(few)?;
        let request = SpectrumRequest { wavelengths, instances, ..request.clone() };
        let began = clock::system();
        spectra_by(atlas.width, structure, &request, progress)?;
        Ok(since(began))
    };
    // The first use of anything pays for what is made once.
    time(1, round)?;
    let mut few = FEW_WAVELENGTHS.min(nm.len());
    let (few_s, more, more_s) = loop {
        let more = (2 * few).min(nm.len());
        let (few_s, more_s) = (time(few, round)?, time(more, round)?);
        if more_s >= ENOUGH_S || more == nm.len() {
            break (few_s, more, more_s);
        }
        few = more;
    };
    let each = if more > few { (more_s - few_s).max(0.0) / (more - few) as f64 } else { 0.0 };
    let whole = more_s + each * (nm.len() - more) as f64;
    let rounds = all as f64 / round as f64;
    if structure.lattice().is_none() {
        // A cell with fewer individuals than cores leaves the others to its neighbours.
        return Ok(whole * rounds * round as f64 / cores as f64);
    }
    // The orders of a crystal are solved once for all individuals, on all cores: what one more round takes is not theirs.
    let own = match all.min(2 * round) - round {
        0 => 0.0,
        further => (time(few, round + further)? - few_s).max(0.0) * round as f64 / further as f64,
    };
    let own = own * nm.len() as f64 / few as f64;
    Ok(whole + own * (rounds - 1.0))
}

/// Seconds of a cell's material on all cores, from a campaign of a few of its wavelengths and individuals.
fn material_seconds(
    atlas: &Atlas,
    options: &CampaignOptions,
    structure: &Structure,
    cores: usize,
    progress: &dyn Progress,
) -> Result<f64> {
    let whole = options.plan(structure.clone())?;
    let (axes, instances) = (&whole.parameters.axes, whole.parameters.instances);
    let nm = axes.wavelengths_nm();
    let chosen: Vec<f64> = middles(nm.len(), FEW_WAVELENGTHS).into_iter().map(|i| nm[i]).collect();
    let round = cores.min(instances);
    let tried = CampaignOptions {
        wavelengths_nm: chosen.clone(),
        instances: Some(round),
        directions: options.directions.map(|count| count.div_ceil(options.thin.unwrap_or(1)).max(2)),
        thin: None,
        ..options.clone()
    };
    let plan = tried.plan(structure.clone())?;
    let parameters = CampaignParameters { places: whole.parameters.places, ..plan.parameters };
    let resources = Resources { width: atlas.width, ..Resources::default() };
    let [wavelengths, rounds] = [nm.len() as f64 / chosen.len() as f64, instances as f64 / round as f64];
    let began = clock::system();
    let solved = orders(structure, &parameters.axes, progress)?;
    let orders_s = since(began);
    let began = clock::system();
    let campaign = Campaign::with_orders(structure, parameters, solved, &resources, progress)?;
    let preparing_s = since(began);
    let began = clock::system();
    statistics(&campaign, progress)?;
    let simulating_s = since(began);
    Ok(orders_s * wavelengths
        + preparing_s * rounds
        + simulating_s * rounds * wavelengths
        + whole.fit_seconds() / cores as f64)
}

fn since(began: Duration) -> f64 {
    (clock::system() - began).as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::middles;

    #[test]
    fn middles_are_spread_evenly() {
        assert_eq!(middles(100, 2), [25, 75]);
        assert_eq!(middles(5, 5), [0, 1, 2, 3, 4]);
        assert_eq!(middles(2, 9), [0, 1]);
        assert_eq!(middles(9, 3), [1, 4, 7]);
    }
}
