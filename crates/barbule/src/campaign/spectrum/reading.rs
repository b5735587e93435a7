//! What structures read in measuring instruments: their far fields integrated over both apertures.
//!
//! A barbule keeps light of longitude θ on its specular cone, so its BRDF is a delta in θ and a reading is
//!
//! ```text
//! π/(P_i P_o) ∫∫ cos²θ cosφ_i [ cosθ ∫ U(θ, φ_i; φ_o) dφ_o ] dφ_i dθ,
//! ```
//!
//! θ over what the lamp's aperture and the mirrored one of the detector share, φ_i over the lamp's and φ_o over the detector's range of
//! azimuths there, P their projected solid angles.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::mount::{Lobes, Mount, Tilted, Vane};
use super::*;
use crate::film::{Polarization, reflect};
use crate::instrument::Instrument;
use crate::material::Material;
use crate::structure::{FLAT_WIDTH_UM, Medium, Section};

/// The distance of incident azimuths, rad: far fields of barbules are wider, about λ/(πW/4) = 1.5° and more.
const AZIMUTH_STEP: f64 = 0.022;

/// Barbules are the same along their axes, and across them no lobe is narrower than a flat one's, λ/2W.
const LOBES: Lobes = Lobes { along: [0.0; 2], across: 0.01 };

/// The distance of incident longitudes, rad, in the middle of an aperture.
const LONGITUDE_STEP: f64 = 0.09;

/// Outgoing azimuths over which neighbours hide alike, rad.
const HIDING_STEP: f64 = 0.05;

/// Azimuths of the far field in half a cone, at least, and by how much they are made finer at most for it.
const CELLS_OF_A_CONE: f64 = 4.0;
const MOST_REFINED: usize = 24;

/// Longitudes of one instrument, at most.
const MOST_LONGITUDES: usize = 64;

/// What readings are asked of.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingRequest {
    /// Vacuum wavelengths.
    pub wavelengths: Wavelengths,
    /// Feathers under instruments, one for each row of the result.
    pub mounts: Vec<Mount>,
    /// Number of instances.
    pub instances: usize,
    /// Seed of the instances.
    pub seed: u64,
    /// Weights of the two incident polarizations; they sum to 1.
    pub polarization: [f64; 2],
}

/// Readings beside a perfect white diffuser, mean and spread and one by one; instances in parallel.
///
/// What is flat and [`FLAT_WIDTH_UM`] wide is a planar stack, and mirrors: unpolarized light on it is taken exactly
/// ([`Instrument::planar`]), without the diffraction of a strip so wide.
///
/// # Errors
/// An instrument does not face the feather, an instance cannot be made, a table does not reach a wavelength, or the user cancelled.
pub fn readings_and_individuals(
    structure: &Structure,
    request: &ReadingRequest,
    progress: &dyn Progress,
) -> Result<(Spectra, Individuals)> {
    request.mounts.iter().try_for_each(Mount::check)?;
    let columns = request.wavelengths.len();
    progress.begin("simulating", (request.instances * columns) as u64);
    let exact = request.polarization == [0.5; 2]
        && request.mounts.iter().all(Mount::is_flat)
        && Planar::of(&structure.instance(request.seed, 0)?)?.is_some();
    let fractions = if exact {
        let instances = (0..request.instances).into_par_iter();
        instances.map(|instance| of_planar(structure, request, instance, progress)).collect::<Result<_>>()?
    } else {
        let plan = Plan::new(&request.mounts);
        let crystal = structure
            .lattice()
            .map(|lattice| super::crystal(&lattice, &plan.as_spectrum(request), progress))
            .transpose()?;
        let instances = (0..request.instances).into_par_iter();
        let one = |instance| of_barbule(structure, request, &plan, crystal.as_ref(), instance, progress);
        instances.map(one).collect::<Result<_>>()?
    };
    let individuals = Individuals { fractions, wavelengths: columns };
    let (mean, std) = moments(&individuals, request.mounts.len());
    let mirror = request.mounts.iter().map(|mount| {
        let (theta, phi) = mount.incidence();
        // The plane waves of planar stacks know no edge.
        let of = |&nm: &f64| if exact { 1.0 } else { mirror_fraction(structure.width_um(), nm, theta, phi) };
        request.wavelengths.iter().map(of).collect()
    });
    Ok((Spectra { mean, std, mirror: mirror.collect(), beside_white: true }, individuals))
}

/// Bytes that readings take, foretold as those of spectra.
///
/// # Errors
/// As [`spectrum_bytes`](super::super::spectrum_bytes).
pub fn reading_bytes(structure: &Structure, request: &ReadingRequest) -> Result<u64> {
    let plan = Plan::new(&request.mounts);
    super::super::spectrum_bytes(structure, &plan.as_spectrum(request))
}

/// The directions that light comes from, by the specular cones on which it leaves.
struct Plan {
    cones: Vec<Lit>,
    /// How much finer outgoing azimuths are than those of spectra, so that cones are a few of them wide.
    refinement: usize,
}

/// Light of one |θ|: what falls in at −θ leaves as its mirror image.
#[derive(Default)]
struct Lit {
    theta: f64,
    phis: Vec<f64>,
    /// For each azimuth, what is collected of its light.
    terms: Vec<Vec<Term>>,
}

/// A range of outgoing azimuths that a row of the result collects.
struct Term {
    row: usize,
    range: [f64; 2],
    weight: f64,
}

impl Term {
    /// What neighbours in the vane leave of a range of light from φ_i, in steps.
    fn hidden(self, vane: Option<&Vane>, phi_i: f64, terms: &mut Vec<Self>) {
        let Self { row, range: [from, to], weight } = self;
        let Some(vane) = vane else { return terms.push(self) };
        let cells = ((to - from) / HIDING_STEP).ceil() as usize;
        let step = (to - from) / cells as f64;
        for cell in 0..cells {
            let range = [from + cell as f64 * step, from + (cell + 1) as f64 * step];
            let weight = weight * vane.shared(phi_i, 0.5 * (range[0] + range[1]));
            if weight > 0.0 {
                terms.push(Self { row, range, weight });
            }
        }
    }
}

impl Plan {
    fn new(mounts: &[Mount]) -> Self {
        let mut cones = BTreeMap::new();
        for (row, mount) in mounts.iter().enumerate() {
            if matches!(mount.instrument, Instrument::Sphere) {
                add_sphere(&mut cones, row, mount);
            } else {
                add_apertures(&mut cones, row, mount);
            }
        }
        let apertures = mounts.iter().flat_map(|mount| mount.instrument.apertures(mount.turned));
        // A sphere lights along its axis.
        let halves = apertures.map(|one| one.half).filter(|half| *half > 0.0);
        let cells = halves.fold(PI, f64::min) / (PI / AZIMUTHS as f64);
        let refinement = ((CELLS_OF_A_CONE / cells).ceil() as usize).clamp(1, MOST_REFINED);
        Self { cones: cones.into_values().collect(), refinement }
    }

    /// A request of spectra with as many directions and the same longitudes: for memory and crystals.
    fn as_spectrum(&self, request: &ReadingRequest) -> SpectrumRequest {
        let most = self.cones.iter().map(|cone| cone.phis.len()).max().unwrap_or(1).max(request.mounts.len());
        let thetas = self.cones.iter().map(|cone| cone.theta).chain(self.cones.is_empty().then_some(0.0));
        let mut directions: Vec<(f64, f64)> = thetas.map(|theta| (theta, 0.0)).collect();
        directions.resize(most.max(directions.len()), directions[0]);
        SpectrumRequest {
            wavelengths: request.wavelengths.clone(),
            directions,
            instances: request.instances,
            seed: request.seed,
            collect: Collect::Hemisphere,
            polarization: request.polarization,
        }
    }
}

/// Light from (θ, φ) of which `ranges` with their weights are collected.
fn add(cones: &mut BTreeMap<u64, Lit>, [theta, phi]: [f64; 2], terms: Vec<Term>) {
    // Nodes at θ and −θ are the same cone; to 1e-12, since they come out of sums.
    let theta = (theta.abs() * 1e12).round() * 1e-12;
    let cone = cones.entry(theta.to_bits()).or_default();
    cone.theta = theta;
    match cone.phis.iter().position(|have| *have == phi) {
        Some(at) => cone.terms[at].extend(terms),
        None => {
            cone.phis.push(phi);
            cone.terms.push(terms);
        }
    }
}

fn add_sphere(cones: &mut BTreeMap<u64, Lit>, row: usize, mount: &Mount) {
    for Tilted { lit, weight, vane, .. } in mount.tilted(LOBES) {
        let (theta, phi) = lit.direction();
        let cosine = theta.cos() * phi.cos();
        if cosine > 0.0 && phi.abs() < 0.5 * PI {
            let term = Term { row, range: [-0.5 * PI, 0.5 * PI], weight: weight * cosine * mount.scale() };
            let mut terms = Vec::new();
            term.hidden(vane.as_ref(), phi, &mut terms);
            add(cones, [theta, phi], terms);
        }
    }
}

fn add_apertures(cones: &mut BTreeMap<u64, Lit>, row: usize, mount: &Mount) {
    let (tilted, scale) = (mount.tilted(LOBES), mount.scale());
    let shared = |one: &Tilted| {
        let ([a, b], [c, d]) = (one.lit.theta_range(), one.seen.theta_range());
        [a.max(-d), b.min(-c)]
    };
    let ranges = tilted.iter().map(shared).filter(|[from, to]| from < to);
    let all = ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
    // Nothing that is lit on a specular cone is seen on it.
    let Some([from, to]) = all else { return };
    let (middle, reach) = (0.5 * (from + to), 0.5 * (to - from));
    // Widths end as square roots, which θ = middle − reach cos u makes smooth.
    let count = 2 * ((reach / LONGITUDE_STEP).ceil() as usize + 1).clamp(3, MOST_LONGITUDES / 2);
    for j in 0..count {
        let u = PI * (j as f64 + 0.5) / count as f64;
        let theta = middle - reach * u.cos();
        let longitude = reach * u.sin() * PI / count as f64 * theta.cos().powi(2);
        let parts: Vec<([f64; 2], Term, Option<Vane>)> = tilted
            .iter()
            .filter_map(|one| {
                let lit = one.lit.azimuths(theta)?;
                let range = one.seen.azimuths(-theta)?;
                Some((lit, Term { row, range, weight: one.weight * longitude * scale }, one.vane))
            })
            .collect();
        let lit = parts.iter().map(|part| part.0).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        let Some([from, to]) = lit else { continue };
        let cells = (((to - from) / AZIMUTH_STEP).ceil() as usize).max(4);
        let step = (to - from) / cells as f64;
        for cell in 0..cells {
            let (left, right) = (from + cell as f64 * step, from + (cell + 1) as f64 * step);
            let phi = 0.5 * (left + right);
            let mut terms = Vec::new();
            for ([a, b], term, vane) in &parts {
                let inside = right.min(*b) - left.max(*a);
                if inside > 1e-12 {
                    let weight = term.weight * inside * phi.cos();
                    Term { row, range: term.range, weight }.hidden(vane.as_ref(), phi, &mut terms);
                }
            }
            add(cones, [theta, phi], terms);
        }
    }
}

/// Readings of one instance from its far fields, `[row · wavelength]`.
fn of_barbule(
    structure: &Structure,
    request: &ReadingRequest,
    plan: &Plan,
    crystal: Option<&Crystal>,
    instance: usize,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let section = structure.instance(request.seed, instance)?;
    let barbule = Barbule::new(&section, ELEMENT_UM, window(structure))?;
    let columns = request.wavelengths.len();
    let mut result = vec![0.0; request.mounts.len() * columns];
    let mut workspace = Workspace::new(Width::best());
    let mut sums = Vec::new();
    for (column, &wavelength_nm) in request.wavelengths.iter().enumerate() {
        let stacks = barbule.stacks(wavelength_nm)?;
        for lit in &plan.cones {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let theta_i = lit.theta;
            let cone = Cone::around(std::slice::from_ref(&barbule), wavelength_nm, theta_i);
            let orders = crystal.map(|crystal| {
                let theta = crystal.orders.cos_theta.partition_point(|&c| c < theta_i.cos());
                crystal.underside(column, theta, theta_i)
            });
            let underside = orders.as_ref().unwrap_or(&stacks);
            let refinement = cone.refinement(AZIMUTHS) * plan.refinement;
            let grid = Grid { azimuths: AZIMUTHS * refinement, margin: 0, shift: 0.0 };
            let batches = lit.phis.chunks(DIRECTIONS_AT_ONCE).zip(lit.terms.chunks(DIRECTIONS_AT_ONCE));
            for (phis, terms) in batches {
                let beam =
                    |&phi: &f64| IncidentLight::Beam { power_um: barbule.incident_power_um(theta_i, phi) };
                let lights: Vec<IncidentLight> = phis.iter().map(beam).collect();
                let batch = Batch { cone: &cone, phi_i: phis, lights: &lights };
                let fields = workspace.scatter(&barbule, underside, &batch, grid, progress)?;
                for (fields, terms) in fields.chunks_exact(4 * grid.points()).zip(terms) {
                    accumulate(fields, request.polarization, &mut sums);
                    for Term { row, range: [from, to], weight } in terms {
                        let part = up_to(&sums, *to) - up_to(&sums, *from);
                        result[row * columns + column] += weight * theta_i.cos() * part;
                    }
                }
            }
        }
        progress.advance(1);
    }
    Ok(result)
}

/// ∫ U dφ_o from −90° to the edge of each cell of the azimuths; `fields` is `[incident polarization][e₁, e₂][azimuth]`.
fn accumulate(fields: &[Complex<f32>], polarization: [f64; 2], sums: &mut Vec<f64>) {
    let points = fields.len() / 4;
    let step = PI / points as f64;
    sums.clear();
    sums.push(0.0);
    let mut sum = 0.0;
    for at in 0..points {
        let power = |k: usize| f64::from(fields[k * points + at].norm_sqr());
        let both = polarization[0] * (power(0) + power(1)) + polarization[1] * (power(2) + power(3));
        sum += step * both;
        sums.push(sum);
    }
}

/// The sum up to an azimuth: within cells a cubic whose slopes at their edges are means of both sides, so that apertures may be
/// narrower than cells.
fn up_to(sums: &[f64], phi: f64) -> f64 {
    let cells = sums.len() - 1;
    let place = ((phi / PI + 0.5) * cells as f64).clamp(0.0, cells as f64);
    let cell = (place as usize).min(cells - 1);
    let t = place - cell as f64;
    let rise = |cell: usize| sums[cell + 1] - sums[cell];
    let slope = |edge: usize| 0.5 * (rise(edge.saturating_sub(1)) + rise(edge.min(cells - 1)));
    let (whole, left, right) = (rise(cell), slope(cell), slope(cell + 1));
    // Hermite's cubic from 0 to the cell's whole.
    let (square, cube) = (t * t, t * t * t);
    sums[cell]
        + whole * (3.0 * square - 2.0 * cube)
        + left * (cube - 2.0 * square + t)
        + right * (cube - square)
}

/// A planar stack: the materials of all regions and the thicknesses of the layers.
struct Planar {
    media: Vec<Material>,
    thickness_nm: Vec<f64>,
}

impl Planar {
    /// The stack that a section is, if it is as wide as one, and flat.
    fn of(section: &Section) -> Result<Option<Self>> {
        let heights: Option<Vec<f64>> = section
            .boundaries
            .iter()
            .map(|line| line.z_um.iter().all(|z| *z == line.z_um[0]).then_some(line.z_um[0]))
            .collect();
        let (Some(heights), None, true) = (heights, &section.crystal, section.inclusions.is_empty()) else {
            return Ok(None);
        };
        if section.width_um != FLAT_WIDTH_UM || heights.is_empty() {
            return Ok(None);
        }
        let mut media = Vec::with_capacity(section.media.len());
        for medium in &section.media {
            let Medium::Pure(substance) = medium else { return Ok(None) };
            media.push(section.material(substance)?);
        }
        let thickness_nm = heights.windows(2).map(|pair| 1e3 * (pair[0] - pair[1])).collect();
        Ok(Some(Self { media, thickness_nm }))
    }
}

/// Readings of a planar stack, `[row · wavelength]`.
fn of_planar(
    structure: &Structure,
    request: &ReadingRequest,
    instance: usize,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let name = || Error::machine("an individual of a planar stack is not planar");
    let planar = Planar::of(&structure.instance(request.seed, instance)?)?.ok_or_else(name)?;
    let columns = request.wavelengths.len();
    let mut result = vec![0.0; request.mounts.len() * columns];
    let waves = planar.thickness_nm.iter().sum::<f64>() / request.wavelengths.range_nm().0;
    let nodes: Vec<_> =
        request.mounts.iter().map(|mount| mount.instrument.planar(mount.turned, waves)).collect();
    for (column, &nm) in request.wavelengths.iter().enumerate() {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let indices = planar.media.iter().map(|medium| medium.index(nm)).collect::<Result<Vec<_>>>()?;
        for (row, nodes) in nodes.iter().enumerate() {
            for node in nodes {
                for polarization in Polarization::BOTH {
                    let r = reflect(&indices, &planar.thickness_nm, nm, node.angle, polarization)?;
                    result[row * columns + column] += 0.5 * node.weight * r.norm_sqr();
                }
            }
        }
        progress.advance(1);
    }
    Ok(result)
}
