//! The halo of a material: what segments in three dimensions send along the barbule, beside what 2.5D makes of the same
//! instances.
//!
//! A segment is straight, so that its narrow part is as wide as the window of light alone: what lies within the window's lobe
//! tells nothing of σ. What lies beyond is fitted with Gaussians of fixed widths.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Plan;
use crate::brdf::Halo;
use crate::identity::Hasher;
use crate::io::Units;
use crate::math::simd::Width;
use crate::progress::{OnlyStops, Progress, Shard};
use crate::scattering::far_field::{Illumination, Polarization, Window};
use crate::solve::cost::Cost;
use crate::solve::segment::{self, Hemisphere, SegmentAccuracy, SegmentLight};
use crate::solve::surface;
use crate::spectrum::wave_number_per_um;
use crate::structure::{Roughness, SEGMENT_LENGTHS_UM, Segment, Structure};
use crate::{Error, Result};

/// Version of what a halo is measured with: raised when its numbers change.
pub(super) const HALO_VERSION: u64 = 1;

/// σ of the Gaussians of a halo: of roughness of half a micrometre, of bodies of a micrometre, of granules.
const SIGMAS: [f64; 3] = [0.1, 0.2, 0.5];

/// Wavelengths between the campaign's ends, at most: bands of films and stacks are some of them wide.
const WAVELENGTHS: usize = 12;

/// cosθ_i and cosφ_i of the light.
const COSINES: [f64; 2] = [FRAC_1_SQRT_2, 1.0];

/// The index by which colours of films and stacks of keratin, melanin and air shift.
const INDEX: f64 = 1.6;

/// Segments that are averaged.
const INSTANCES: usize = 8;

/// Length of a segment, µm: its window's lobe is half as wide as the narrowest Gaussian.
const LENGTH_UM: f64 = 16.0;

/// Where the window's lobe ends, in its standard deviations: 5e-4 of it lie beyond.
const LOBE: f64 = 3.5;

/// Azimuths of the 2.5D far fields.
const AZIMUTHS: usize = 1440;

/// What is simulated for a halo.
#[derive(Debug, Clone)]
pub struct HaloPlan {
    structure: Structure,
    seed: u64,
    tilt: f64,
    instances: usize,
    /// nm
    wavelengths_nm: Vec<f64>,
    length_um: f64,
    roughness: Roughness,
    width: Width,
}

/// What all instances give at one wavelength under light from one direction, parts of what falls on them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Knot {
    /// Reflected in 2.5D and in three dimensions.
    reflected: [f64; 2],
    /// In each Gaussian of the halo.
    halo: [f64; SIGMAS.len()],
}

impl HaloPlan {
    /// That of a campaign: its instances and its range of wavelengths, computed with the instructions `width`, which decide roundings.
    #[must_use]
    pub fn new(plan: &Plan, width: Width) -> Self {
        let nm = plan.parameters.axes.wavelengths_nm();
        let (first, last) = (nm[0], nm[nm.len() - 1]);
        let count = nm.len().min(WAVELENGTHS);
        let at = |k: usize| first + (last - first) * k as f64 / (count.max(2) - 1) as f64;
        let [shortest, longest] = SEGMENT_LENGTHS_UM;
        Self {
            structure: plan.structure.clone(),
            seed: plan.parameters.seed,
            tilt: plan.parameters.tilt,
            instances: plan.parameters.instances.min(INSTANCES),
            wavelengths_nm: (0..count).map(at).collect(),
            length_um: LENGTH_UM.min(plan.structure.width_um()).clamp(shortest, longest),
            roughness: Roughness::default(),
            width,
        }
    }

    /// Far fields of segments in all.
    #[must_use]
    pub fn count(&self) -> usize {
        self.instances * self.wavelengths_nm.len() * COSINES.len() * COSINES.len()
    }

    /// What a material's `info` says of it.
    #[must_use]
    pub fn info(&self) -> Value {
        json!({
            "version": HALO_VERSION,
            "segments": self.instances,
            "length_um": self.length_um,
            "roughness_um": self.roughness.amplitude_um,
            "correlation_um": self.roughness.correlation_um,
        })
    }

    /// Simulates and fits. What is done is kept in `units`, and taken from there another time.
    ///
    /// # Errors
    /// As the solvers; a unit cannot be written; or the user cancelled.
    pub fn measure(&self, units: Option<&Units>, progress: &dyn Progress) -> Result<Halo> {
        let instances = self.segments()?;
        progress.begin("segments", self.count() as u64);
        let knots = (0..self.units())
            .map(|unit| self.kept_knot(self.light(unit), &instances, units, progress))
            .collect::<Result<Vec<_>>>()?;
        let shares = (0..SIGMAS.len()).flat_map(|part| knots.iter().map(move |knot| knot.share(part)));
        Ok(Halo {
            sigma: SIGMAS.to_vec(),
            wavelengths_nm: self.wavelengths_nm.clone(),
            cos_theta: COSINES.to_vec(),
            cos_phi: COSINES.to_vec(),
            index: INDEX,
            shares: shares.collect(),
            power: knots.iter().map(Knot::power).collect(),
        })
    }

    /// Simulates and keeps a part of what [`Self::measure`] then finds, of about equal time, whoever simulated it. What is there from before
    /// takes no time.
    ///
    /// # Errors
    /// As [`Self::measure`]; what is kept till then stays.
    pub fn measure_part(&self, shard: Shard, units: &Units, progress: &dyn Progress) -> Result<()> {
        // As many cells are in a segment as squares of wavelengths.
        let costs: Vec<f64> = (0..self.units()).map(|unit| self.light(unit).0.powi(-2)).collect();
        let mut left = shard.by_cost(&costs);
        left.retain(|unit| !self.is_done(*unit, units));
        if left.is_empty() {
            return Ok(());
        }
        let instances = self.segments()?;
        progress.begin("segments", (left.len() * self.instances) as u64);
        left.into_iter().try_for_each(|unit| {
            self.kept_knot(self.light(unit), &instances, Some(units), progress).map(|_| ())
        })
    }

    /// Units of its work, each a wavelength and a direction of the light: far fields of all segments.
    #[must_use]
    pub fn units(&self) -> usize {
        self.wavelengths_nm.len() * COSINES.len() * COSINES.len()
    }

    /// Whether a unit was kept.
    #[must_use]
    pub fn is_done(&self, unit: usize, units: &Units) -> bool {
        let light = self.light(unit);
        units.get::<Knot>(&knot_name(light), &self.identity(light)).is_some()
    }

    /// Simulates a unit and keeps it, unless it is there.
    ///
    /// # Errors
    /// As [`Self::measure`].
    pub fn run_unit(&self, unit: usize, units: &Units, progress: &dyn Progress) -> Result<()> {
        if self.is_done(unit, units) {
            return Ok(());
        }
        progress.begin("segments", self.instances as u64);
        self.kept_knot(self.light(unit), &self.segments()?, Some(units), progress).map(|_| ())
    }

    /// What a unit takes at most on so many threads: at the shortest wavelength.
    ///
    /// # Errors
    /// A segment cannot be made.
    pub fn unit_cost(&self, threads: usize) -> Result<Cost> {
        let segment = self.segment(0)?;
        let (wavelength_nm, [theta_i, phi_i]) = self.light(0);
        let light = SegmentLight { wavelength_nm, theta_i, phi_i, window_um: self.window_um(), turn: 0.0 };
        segment::cost(&segment, &light, &self.accuracy(), threads)
    }

    /// Wavelength, nm, and direction, rad, of a unit: all cosφ_i of a cosθ_i, all of these at a wavelength.
    fn light(&self, unit: usize) -> (f64, [f64; 2]) {
        let across = COSINES.len();
        let cosines = [COSINES[unit / across % across], COSINES[unit % across]];
        (self.wavelengths_nm[unit / (across * across)], cosines.map(libm::acos))
    }

    fn segments(&self) -> Result<Vec<Segment>> {
        (0..self.instances).map(|index| self.segment(index)).collect()
    }

    /// Standard deviations of the light's window, µm.
    fn window_um(&self) -> [f64; 2] {
        [0.25 * self.structure.width_um(), 0.25 * self.length_um]
    }

    /// How segments are computed.
    fn accuracy(&self) -> SegmentAccuracy {
        SegmentAccuracy { width: self.width, ..SegmentAccuracy::default() }
    }

    /// Given sections serve again with other heights when there are no more.
    fn segment(&self, index: usize) -> Result<Segment> {
        let given = self.structure.count().unwrap_or(usize::MAX).max(1);
        let seed = self.seed.wrapping_add((index / given) as u64);
        self.structure.segment(seed, index % given, self.length_um, self.roughness)
    }

    fn kept_knot(
        &self,
        light: (f64, [f64; 2]),
        instances: &[Segment],
        units: Option<&Units>,
        progress: &dyn Progress,
    ) -> Result<Knot> {
        let (name, identity) = (knot_name(light), self.identity(light));
        if let Some(knot) = units.and_then(|units| units.get(&name, &identity)) {
            progress.advance(instances.len() as u64);
            return Ok(knot);
        }
        let knot = self.knot(light, instances, progress)?;
        units.map_or(Ok(()), |units| units.keep(&name, &identity, &knot))?;
        Ok(knot)
    }

    fn knot(
        &self,
        (wavelength_nm, [theta_i, phi_i]): (f64, [f64; 2]),
        instances: &[Segment],
        progress: &dyn Progress,
    ) -> Result<Knot> {
        // Every other instance from the other side: structures need not be symmetric.
        let azimuth = |index: usize| if index.is_multiple_of(2) { phi_i } else { -phi_i };
        let flat = (0..instances.len())
            .into_par_iter()
            .map(|index| {
                let phi_i = azimuth(index) + self.turn(index);
                let light = Illumination { wavelength_nm, theta_i, phi_i, window: Window::Gaussian };
                let accuracy = surface::Accuracy { width: self.width, ..surface::Accuracy::default() };
                let section = &instances[index].section;
                let far =
                    surface::far_field_observed(section, &light, AZIMUTHS, &accuracy, &OnlyStops(progress))?;
                let of = |polarization| far.reflected_fraction(polarization).unwrap_or_default();
                Ok(Polarization::BOTH.map(of).iter().sum::<f64>() / 2.0)
            })
            .collect::<Result<Vec<f64>>>()?;
        let window_um = self.window_um();
        let mut rows: Vec<f64> = Vec::new();
        let mut grid = None;
        for (index, segment) in instances.iter().enumerate() {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let (phi_i, turn) = (azimuth(index), self.turn(index));
            let light = SegmentLight { wavelength_nm, theta_i, phi_i, window_um, turn };
            let far = segment::far_field(segment, &light, &self.accuracy(), &OnlyStops(progress))?;
            rows.resize(far.omega_y.len(), 0.0);
            add_rows(&far, &mut rows);
            grid = Some((far.omega_y, far.step[1]));
            progress.advance(1);
        }
        let count = instances.len() as f64;
        rows.iter_mut().for_each(|row| *row /= count);
        let (omega_y, step) = grid.unwrap_or_default();
        let deviation = 1.0 / (wave_number_per_um(wavelength_nm) * window_um[1]);
        Ok(Knot {
            reflected: [flat.iter().sum::<f64>() / count, rows.iter().sum()],
            halo: fitted(&omega_y, &rows, step, theta_i, deviation),
        })
    }

    /// The turn of an instance about y, rad: they are spread evenly.
    fn turn(&self, index: usize) -> f64 {
        if self.instances < 2 {
            return 0.0;
        }
        (2.0 * index as f64 / (self.instances - 1) as f64 - 1.0) * self.tilt
    }

    /// Of all that decides a knot's bits.
    fn identity(&self, (wavelength_nm, direction): (f64, [f64; 2])) -> String {
        let mut hasher = Hasher::new("halo");
        hasher
            .count("version", HALO_VERSION)
            .text("program", env!("CARGO_PKG_VERSION"))
            .text("simd", self.width.name())
            .text("structure", &self.structure.hash())
            .count("seed", self.seed)
            .count("instances", self.instances as u64)
            .number("tilt", self.tilt)
            .number("length_um", self.length_um)
            .number("roughness_um", self.roughness.amplitude_um)
            .numbers("correlation_um", &self.roughness.correlation_um)
            .number("wavelength_nm", wavelength_nm)
            .numbers("direction", &direction);
        hasher.hex()
    }
}

/// What a unit's file is called.
fn knot_name((nm, direction): (f64, [f64; 2])) -> String {
    let [theta, phi] = direction.map(|angle| angle.to_degrees().round());
    format!("halo-{theta}-{phi}-{nm}nm")
}

/// Adds the light of each row of directions, in parts of what falls on the segment.
fn add_rows(far: &Hemisphere, rows: &mut [f64]) {
    let columns = far.columns();
    for (at, (value, angle)) in far.intensity().iter().zip(far.solid_angles()).enumerate() {
        rows[at / columns] += value * angle;
    }
}

impl Knot {
    /// The share of a Gaussian in what is reflected.
    fn share(&self, part: usize) -> f32 {
        let [_, reflected] = self.reflected;
        // No more than all of it.
        let whole = reflected.max(self.halo.iter().sum()).max(f64::MIN_POSITIVE);
        (self.halo[part] / whole) as f32
    }

    /// What three dimensions reflect over what 2.5D does, within what a material takes.
    fn power(&self) -> f32 {
        let [flat, segments] = self.reflected;
        if flat > 0.0 { (segments / flat).clamp(0.25, 3.0) as f32 } else { 1.0 }
    }
}

/// The light in each Gaussian of the halo: the least squares, none negative, over the rows beyond the window's lobe, by what they
/// hold. `deviation` is the lobe's, in ω_y.
fn fitted(omega_y: &[f64], rows: &[f64], step: f64, theta_i: f64, deviation: f64) -> [f64; SIGMAS.len()] {
    let mirror = -theta_i.sin();
    let shape = |sigma: f64| -> Vec<f64> {
        let t = |y: &f64| (0.5 * (theta_i + y.clamp(-1.0, 1.0).asin())).sin();
        let values: Vec<f64> = omega_y.iter().map(|y| (-(t(y) / sigma).powi(2)).exp()).collect();
        // Per unit of ω_y the spread is E/Q.
        let whole = values.iter().sum::<f64>();
        values.into_iter().map(|value| value / whole).collect()
    };
    let shapes = SIGMAS.map(shape);
    // Rows at the mirror's ω_y weigh no more than those far off that carry as much.
    let beyond: Vec<usize> =
        (0..rows.len()).filter(|row| (omega_y[*row] - mirror).abs() > LOBE * deviation).collect();
    let mean = beyond.iter().map(|row| rows[*row]).sum::<f64>() / beyond.len().max(1) as f64;
    if mean <= 0.0 || step <= 0.0 {
        return [0.0; SIGMAS.len()];
    }
    let mut normal = [[0.0; 3]; 3];
    let (mut right, mut whole) = ([0.0; 3], 0.0);
    for &row in &beyond {
        let weight = 1.0 / (rows[row] + 0.1 * mean);
        whole += weight * rows[row] * rows[row];
        for i in 0..3 {
            right[i] += weight * shapes[i][row] * rows[row];
            for j in 0..3 {
                normal[i][j] += weight * shapes[i][row] * shapes[j][row];
            }
        }
    }
    // Of every choice of Gaussians the best one that has none negative.
    let mut best = ([0.0; 3], whole);
    for chosen in 1_u8..8 {
        let Some(found) = solved(normal, right, chosen) else { continue };
        let error = whole - (0..3).map(|i| found[i] * right[i]).sum::<f64>();
        if found.iter().all(|value| *value >= 0.0) && error < best.1 {
            best = (found, error);
        }
    }
    best.0
}

/// The chosen unknowns of symmetric positive equations, the others 0; none where these are singular.
fn solved(normal: [[f64; 3]; 3], right: [f64; 3], chosen: u8) -> Option<[f64; 3]> {
    let is_chosen = |i: usize| chosen >> i & 1 == 1;
    let kept = |i: usize, j: usize| match (is_chosen(i) && is_chosen(j), i == j) {
        (true, _) => normal[i][j],
        (false, true) => 1.0,
        (false, false) => 0.0,
    };
    let matrix = DMat3::from_cols_array_2d(&[0, 1, 2].map(|i| [0, 1, 2].map(|j| kept(i, j))));
    let right = [0, 1, 2].map(|i| if is_chosen(i) { right[i] } else { 0.0 });
    (matrix.determinant() > 1e-12).then(|| (matrix.inverse() * DVec3::from_array(right)).to_array())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterize::CampaignOptions;
    use crate::progress::Unobserved;

    /// A made-up row of light: two of the Gaussians come back, the narrow one with the 5e-4 of the window's lobe that lie beyond
    /// its end and what that makes under it, 1.2e-3.
    #[test]
    fn a_known_halo_is_fitted() {
        for theta_i in [0.0, 0.6] {
            let (step, deviation) = (0.004, 0.02);
            let omega_y: Vec<f64> = (-249..250).map(|row| step * f64::from(row)).collect();
            let density = |y: f64, sigma: f64| {
                let t = (0.5 * (theta_i + y.asin())).sin();
                (-(t / sigma).powi(2)).exp()
            };
            let whole = |sigma: f64| omega_y.iter().map(|y| density(*y, sigma)).sum::<f64>();
            let of = |y: f64| {
                let u = (y + theta_i.sin()) / deviation;
                (-0.5 * u * u).exp() * step / (deviation * std::f64::consts::TAU.sqrt())
                    + 0.05 * density(y, SIGMAS[0]) / whole(SIGMAS[0])
                    + 0.2 * density(y, SIGMAS[2]) / whole(SIGMAS[2])
            };
            let rows: Vec<f64> = omega_y.iter().map(|y| of(*y)).collect();
            let [a, b, c] = fitted(&omega_y, &rows, step, theta_i, deviation);
            assert!(
                (a - 0.05).abs() < 1.5e-3 && b < 1e-3 && (c - 0.2).abs() < 1e-3,
                "{theta_i}: {a} {b} {c}"
            );
        }
    }

    fn small(structure: Structure) -> HaloPlan {
        let options = CampaignOptions {
            wavelengths_nm: vec![550.0],
            directions: [2, 2],
            instances: Some(4),
            tilt_deg: 0.0,
            ..CampaignOptions::default()
        };
        HaloPlan { length_um: 12.0, ..HaloPlan::new(&options.plan(structure).unwrap(), Width::best()) }
    }

    /// A flat mirror, melanin that light does not pass: heights of rms A far below the wavelength take the part (2k A z)² out of the mirror's line (perturbation of the
    /// first order) and lose next to nothing; a smooth one sends nothing off it.
    #[test]
    fn a_rough_mirror_has_the_halo_of_perturbation_theory() {
        let mirror = Structure::flat("air/melanin:3000/air").unwrap();
        let plan = small(mirror);
        let halo = plan.measure(None, &Unobserved).unwrap();
        halo.check().unwrap();
        let rough = halo.at(550.0, 1.0, 1.0);
        let share = rough.shares.iter().sum::<f64>();
        let expected = (2.0 * wave_number_per_um(550.0) * plan.roughness.amplitude_um).powi(2);
        // Of first order in (2k A)² = 0.05, and four segments: 12 % less is found.
        assert!((share / expected - 1.0).abs() < 0.15, "{share} {expected}");
        assert!((rough.power - 1.0).abs() < 0.05, "{}", rough.power);
        let smooth = HaloPlan { roughness: Roughness::NONE, ..plan }.measure(None, &Unobserved).unwrap();
        let smooth = smooth.at(550.0, 1.0, 1.0);
        assert!(smooth.shares.iter().sum::<f64>() < 2e-3, "{smooth:?}");
        assert!((smooth.power - 1.0).abs() < 0.01, "{smooth:?}");
    }

    #[test]
    fn a_halo_goes_on_from_what_was_kept_to_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let units = Units::new(folder.path());
        let plan = HaloPlan { instances: 1, ..small(Structure::flat("air/keratin:300/air").unwrap()) };
        let first = plan.measure(Some(&units), &Unobserved).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
        assert_eq!(plan.measure(Some(&units), &Unobserved).unwrap(), first);
        assert_eq!(plan.measure(None, &Unobserved).unwrap(), first);
    }

    #[test]
    fn instructions_are_part_of_a_unit_and_decide_roundings_alone() {
        let folder = tempfile::tempdir().unwrap();
        let units = Units::new(folder.path());
        let best = HaloPlan { instances: 1, ..small(Structure::flat("air/keratin:300/air").unwrap()) };
        let scalar = HaloPlan { width: Width::scalar(), ..best.clone() };
        best.run_unit(0, &units, &Unobserved).unwrap();
        if best.width.name() != scalar.width.name() {
            assert!(best.is_done(0, &units) && !scalar.is_done(0, &units));
        }
        let [a, b] = [&best, &scalar].map(|plan| plan.measure(None, &Unobserved).unwrap().power[0]);
        assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
    }
}
