//! All that a BRDF evaluates, in the open: named arrays of plain numbers.
//!
//! `docs/formats/brdf-tables.md` says what each array holds and how values follow from them;
//! [`PlainBrdf`](super::PlainBrdf) does so formula by formula.

use glam::DVec3;

use super::arrays::{Arrays, TableArray};
use super::halo::MOST_HALOS;
use super::longitudinal::Longitudinal;
use super::material::{FeatherMaterial, check_sigma};
use super::noise::{Noise, Spectral};
use super::sample::Sampler;
use super::table::{Grid, Table};
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::FitKind;
use crate::scattering::statistics::Sides;
use crate::{Error, Result, words};

/// Version of the arrays and of what they mean.
pub const TABLES_VERSION: u32 = 3;

/// No tables have more nodes than this: those of a material with both grazing sides added to its axes.
const MOST_NODES: usize = 16_000_000;

/// cosφ of the flatter direction at which [`Reciprocity::Steeper`] begins to ask both tables, of 80° and 85°.
const HORIZON: [f64; 2] = [0.173_648_177_666_930_35, 0.087_155_742_747_658_17];

words! {
    /// What makes values the same when light and eye change places.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Reciprocity {
        /// Nothing: every value is from the tables of the incident direction, as it was fitted.
        #[default]
        "none": AsFitted,
        /// Each value is from the tables of whichever of both directions is steeper across the barbule, that is of smaller |φ|, where the
        /// simulation is nearer to Maxwell's equations; where the other one is within some degrees of the horizon, on the way to the
        /// geometric mean of both orders. Materials whose sides differ have the mean: at their mirror directions both tables may differ,
        /// and the lobe would have a step there.
        "steeper": Steeper,
        /// Each value is the mean of both orders, at twice the cost.
        "mean": Mean,
    }
}

impl Reciprocity {
    /// Whether the tables of the second direction are those to take: of smaller |φ|, and where both have the same, of smaller |θ|.
    #[inline(always)]
    pub(super) fn is_steeper([first, second]: [DVec3; 2]) -> bool {
        let [own, other] = [first.z * second.x.abs(), second.z * first.x.abs()];
        other > own || (other == own && second.z > first.z)
    }

    /// Of [`Steeper`](Self::Steeper): how near to the horizon the flatter of both directions is, from 0 at |φ| = 80° and less to 1 from 85° on.
    #[inline(always)]
    pub(super) fn at_horizon(directions: [DVec3; 2]) -> f64 {
        let [begins, ends] = HORIZON;
        if directions.iter().all(|w| w.z * w.z >= begins * begins * (w.x * w.x + w.z * w.z)) {
            return 0.0;
        }
        let [first, second] = directions.map(|w| w.z / (w.x * w.x + w.z * w.z).sqrt());
        ((begins - first.min(second)) / (begins - ends)).min(1.0)
    }
}

/// How a material is prepared.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// One longitudinal spread σ instead of the material's own and of its halo; what is reflected is then that of its lobes.
    pub sigma: Option<f64>,
    /// What makes values reciprocal.
    pub reciprocity: Reciprocity,
    /// The incident polarization; `None` for unpolarized light.
    pub polarization: Option<Polarization>,
}

/// What the arrays mean, and how large they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TablesHeader {
    /// [`TABLES_VERSION`] of the program that made them.
    pub version: u32,
    /// Whether shapes have the cosine.
    pub kind: FitKind,
    /// Whether light from φ_i < 0 is the mirror image.
    pub sides: Sides,
    /// The incident polarization that the values are of; `None` for unpolarized light.
    pub polarization: Option<Polarization>,
    /// What makes values reciprocal.
    pub reciprocity: Reciprocity,
    /// Longitudinal spread σ: with a halo, of the narrow part.
    pub sigma: f64,
    /// How instances differ from wavelength to wavelength.
    pub spectral: Spectral,
    /// σ of the halo's Gaussians, rising; 0 where there are fewer.
    pub halo: [f64; MOST_HALOS],
    /// Seed that instances are named with.
    pub seed: u64,
    /// Sets of nodes, 1 or 2.
    pub sets: usize,
    /// Places along cosθ_i, with the one at grazing.
    pub thetas: usize,
    /// Places along φ_i, with those at grazing.
    pub phis: usize,
    /// Wavelengths.
    pub waves: usize,
}

/// All that a [`FeatherBrdf`](super::FeatherBrdf) evaluates. Always whole and in range.
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfTables {
    pub(super) kind: FitKind,
    pub(super) polarization: Option<Polarization>,
    pub(super) reciprocity: Reciprocity,
    pub(super) grid: Grid,
    /// One, or one for each incident polarization.
    pub(super) sets: Vec<Table>,
    pub(super) longitudinal: Longitudinal,
    pub(super) sampler: Sampler,
    pub(super) noise: Noise,
}

impl BrdfTables {
    /// Checks the material, integrates the lobes of its nodes and draws its noise: about a second per million nodes.
    ///
    /// # Errors
    /// A material that fails [`FeatherMaterial::check`], or σ out of range.
    pub fn new(material: &FeatherMaterial, options: Options) -> Result<Self> {
        material.check()?;
        let sigma = options.sigma.unwrap_or(material.sigma);
        check_sigma(sigma)?;
        let halo = material.halo.as_ref().filter(|_| options.sigma.is_none());
        let powered = halo.map(|halo| material.with_power(halo));
        let material = powered.as_ref().unwrap_or(material);
        let only = match options.polarization {
            Some(Polarization::Second) if material.sets.len() == 2 => &material.sets[1..],
            Some(Polarization::First) if material.sets.len() == 2 => &material.sets[..1],
            _ => &material.sets[..],
        };
        let grid = Grid::new(material);
        let longitudinal = match halo {
            Some(halo) => {
                let sigmas = std::iter::once(sigma).chain(halo.sigma.iter().copied()).collect();
                Longitudinal::new(sigmas, grid.shares(halo))
            }
            None => Longitudinal::new(vec![sigma], Vec::new()),
        };
        Ok(Self {
            kind: material.kind,
            polarization: options.polarization,
            reciprocity: options.reciprocity,
            sets: only.iter().map(|set| Table::new(material, set, options.polarization)).collect(),
            grid,
            longitudinal,
            sampler: Sampler::new(),
            noise: material.noise(),
        })
    }

    /// What the arrays mean.
    #[must_use]
    pub fn header(&self) -> TablesHeader {
        let [thetas, phis, waves] = self.grid.sizes();
        TablesHeader {
            version: TABLES_VERSION,
            kind: self.kind,
            sides: self.grid.sides(),
            polarization: self.polarization,
            reciprocity: self.reciprocity,
            sigma: self.longitudinal.sigma(),
            halo: self.longitudinal.halo(),
            spectral: self.noise.spectral(),
            seed: self.noise.seed(),
            sets: self.sets.len(),
            thetas,
            phis,
            waves,
        }
    }

    /// The arrays, always in the same order.
    #[must_use]
    pub fn arrays(&self) -> Vec<TableArray<'_>> {
        let mut all = self.grid.arrays();
        for (number, set) in self.sets.iter().enumerate() {
            all.extend(set.arrays(&prefix(number, self.sets.len()), self.grid.sizes()));
        }
        all.extend(self.longitudinal.arrays(self.grid.sizes()));
        all.push(self.sampler.array());
        all.extend(self.noise.arrays());
        all
    }

    /// Whose pattern a set's instances show: one polarization's, or both, summed by their fractions.
    #[inline(always)]
    pub(super) fn polarization_of(&self, set: usize) -> Option<Polarization> {
        match (self.polarization, self.sets.len(), set) {
            (Some(polarization), ..) => Some(polarization),
            (None, 1, _) => None,
            (None, _, 0) => Some(Polarization::First),
            (None, ..) => Some(Polarization::Second),
        }
    }

    /// Tables from arrays as [`arrays`](Self::arrays) gives them, in any order.
    ///
    /// # Errors
    /// Another version; an array that is missing, or whose type, shape or numbers no material has.
    pub fn from_arrays(header: &TablesHeader, arrays: &[TableArray<'_>]) -> Result<Self> {
        check_header(header)?;
        let sizes = [header.thetas, header.phis, header.waves];
        let from = Arrays::new(arrays);
        let set = |number: usize| Table::from_arrays(from, &prefix(number, header.sets), sizes);
        Ok(Self {
            kind: header.kind,
            polarization: header.polarization,
            reciprocity: header.reciprocity,
            grid: Grid::from_arrays(from, header.sides, sizes)?,
            sets: (0..header.sets).map(set).collect::<Result<_>>()?,
            longitudinal: Longitudinal::from_arrays(from, header.sigma, header.halo, sizes)?,
            sampler: Sampler::from_arrays(from)?,
            noise: Noise::from_arrays(from, header.spectral, header.seed)?,
        })
    }
}

/// What stands before the names of a set's arrays.
fn prefix(set: usize, sets: usize) -> String {
    if sets == 1 { String::new() } else { format!("p{}.", set + 1) }
}

fn check_header(header: &TablesHeader) -> Result<()> {
    let TablesHeader { version, sets, thetas, phis, waves, .. } = *header;
    if version != TABLES_VERSION {
        return Err(Error::input(format!(
            "the tables have version {version}, but this program reads version {TABLES_VERSION}; make them again from the material"
        )));
    }
    check_sigma(header.sigma)?;
    header.spectral.check()?;
    if sets == 2 && header.polarization.is_some() {
        return Err(Error::input("the tables have 2 sets, but one polarization has only its own"));
    }
    let nodes = thetas.checked_mul(phis).and_then(|cells| cells.checked_mul(waves));
    let fit = (1..=2).contains(&sets) && thetas > 1 && phis > 1 && waves > 0;
    if !fit || nodes.is_none_or(|nodes| nodes > MOST_NODES) {
        return Err(Error::input(format!(
            "the tables have {sets} sets of {thetas} × {phis} × {waves} nodes, but 1 or 2 sets of 2 × 2 × 1 to {MOST_NODES} nodes are possible"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;
    use crate::brdf::arrays::Numbers;
    use crate::brdf::fixtures::{example, halo};

    fn tables() -> BrdfTables {
        BrdfTables::new(&example(3), Options::default()).unwrap()
    }

    #[test]
    fn tables_are_what_their_arrays_are() {
        for options in [
            Options::default(),
            Options {
                sigma: Some(0.1),
                reciprocity: Reciprocity::Mean,
                polarization: Some(Polarization::Second),
            },
        ] {
            let halo = options.sigma.is_none().then(halo);
            let tables = BrdfTables::new(&FeatherMaterial { halo, ..example(3) }, options).unwrap();
            let mut arrays = tables.arrays();
            for array in &arrays {
                let count = match &array.numbers {
                    Numbers::F64(v) => v.len(),
                    Numbers::F32(v) => v.len(),
                    Numbers::I16(v) => v.len(),
                };
                assert_eq!(count, array.shape.iter().product::<usize>(), "{}", array.name);
            }
            arrays.reverse();
            assert_eq!(BrdfTables::from_arrays(&tables.header(), &arrays).unwrap(), tables);
        }
    }

    /// Another σ stands for the narrow part, the halo and its power.
    #[test]
    fn a_sigma_of_the_users_takes_the_halos_place() {
        let material = FeatherMaterial { halo: Some(halo()), ..example(3) };
        let options = Options { sigma: Some(material.sigma), ..Options::default() };
        assert_eq!(BrdfTables::new(&material, options).unwrap(), tables());
    }

    #[test]
    fn what_no_material_has_is_refused() {
        let tables = tables();
        let header = tables.header();
        let refused = |header: TablesHeader, arrays: &[TableArray<'_>]| {
            BrdfTables::from_arrays(&header, arrays).unwrap_err().to_string()
        };
        for (header, expected) in [
            (TablesHeader { version: 1, ..header }, "version 1, but this program reads version 3"),
            (TablesHeader { sigma: f64::NAN, ..header }, "sigma is NaN"),
            (
                TablesHeader { spectral: Spectral { achromatic: 1.5, ..header.spectral }, ..header },
                "achromatic is 1.5",
            ),
            (
                TablesHeader { halo: [0.2, 0.0, 0.3], ..header },
                "the halo of the tables has σ [0.2, 0.0, 0.3]",
            ),
            (TablesHeader { halo: [0.9, 0.0, 0.0], ..header }, "from 0.002 to 0.6"),
            (
                TablesHeader { halo: [0.2, 0.0, 0.0], ..header },
                "inverse_q has 4097 numbers and not the shape",
            ),
            (TablesHeader { sets: 0, ..header }, "0 sets"),
            (
                TablesHeader { sets: 2, polarization: Some(Polarization::First), ..header },
                "2 sets, but one polarization",
            ),
            (TablesHeader { thetas: usize::MAX, ..header }, "1 or 2 sets of"),
            (TablesHeader { waves: 4, ..header }, "wavelengths_nm has 3 numbers and not the shape [4]"),
            (TablesHeader { sets: 2, ..header }, "p1.nodes is missing"),
        ] {
            let found = refused(header, &tables.arrays());
            assert!(found.contains(expected), "{found}");
        }
        for number in 0..tables.arrays().len() {
            let mut arrays = tables.arrays();
            let name = arrays.remove(number).name;
            assert!(refused(header, &arrays).contains(&format!("array {name} is missing")));
            let mut arrays = tables.arrays();
            arrays[number].numbers = Numbers::I16(Cow::Owned(vec![0; 7]));
            let found = refused(header, &arrays);
            assert!(found.contains(&format!("array {name} has ")), "{found}");
            let mut arrays = tables.arrays();
            let expected = match &mut arrays[number].numbers {
                Numbers::F64(values) => {
                    values.to_mut()[0] = f64::NAN;
                    format!("{name}[0] = NaN is not in")
                }
                Numbers::F32(values) => {
                    values.to_mut()[1] = f32::INFINITY;
                    format!("{name}[1] = inf is not in")
                }
                // Any code is one.
                Numbers::I16(_) => continue,
            };
            let found = refused(header, &arrays);
            assert!(found.contains(&expected), "{found}");
        }
        let mut arrays = tables.arrays();
        let Numbers::F64(waves) = &mut arrays[0].numbers else { panic!("wavelengths first") };
        waves.to_mut().swap(0, 1);
        assert!(refused(header, &arrays).contains("wavelengths_nm[1] does not exceed"));
    }
}
