//! Far fields of segments, kept as they come, and what all instances of one direction and wavelength give together.

use serde::{Deserialize, Serialize};

use super::{Found, Plan, USUAL_SIGMA};
use crate::Result;
use crate::identity::Hasher;
use crate::io::Units;
use crate::progress::{OnlyStops, Progress};
use crate::solve::cost::Cost;
use crate::solve::segment::{self, Hemisphere, SegmentLight};
use crate::structure::Segment;
use crate::validate::{Compared, Comparing};

/// What one wavelength and direction give.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Cell {
    pub(super) found: Found,
    /// Pictures of the mean and of one instance.
    pub(super) flat: [Vec<f64>; 2],
    pub(super) segments: [Vec<f64>; 2],
    /// Wall time of both simulations.
    pub(super) seconds: [f64; 2],
}

/// The far field of one segment.
pub(super) struct Scattered {
    /// Its directions; of a kept one without the amplitudes, of which nothing but the intensity is asked.
    pub(super) far: Hemisphere,
    pub(super) intensity: Vec<f64>,
    /// Wall time.
    pub(super) seconds: f64,
}

/// The same as it is kept.
#[derive(Serialize, Deserialize)]
struct KeptSegment {
    step: [f64; 2],
    reach: usize,
    omega_y: Vec<f64>,
    incident_um2: f64,
    intensity: Vec<f64>,
    seconds: f64,
}

impl From<&Scattered> for KeptSegment {
    fn from(Scattered { far, intensity, seconds }: &Scattered) -> Self {
        let Hemisphere { step, reach, omega_y, amplitudes: _, incident_um2 } = far;
        Self {
            step: *step,
            reach: *reach,
            omega_y: omega_y.clone(),
            incident_um2: *incident_um2,
            intensity: intensity.clone(),
            seconds: *seconds,
        }
    }
}

impl KeptSegment {
    /// `None` where the numbers of directions and intensities do not fit.
    fn scattered(self) -> Option<Scattered> {
        let Self { step, reach, omega_y, incident_um2, intensity, seconds } = self;
        let far = Hemisphere { step, reach, omega_y, amplitudes: Default::default(), incident_um2 };
        (intensity.len() == far.columns() * far.omega_y.len()).then_some(Scattered {
            far,
            intensity,
            seconds,
        })
    }
}

impl Comparing for Plan {
    fn what(&self) -> &'static str {
        "far fields"
    }

    fn units(&self) -> usize {
        self.count()
    }

    fn missing(&self, some: &[usize], kept: &Units) -> Vec<usize> {
        let mut left = Vec::new();
        // What is kept of all instances together is looked for once.
        for cell in some.chunk_by(|a, b| a / self.instances == b / self.instances) {
            let (direction, nm, _) = self.place(cell[0]);
            if self.kept_cell(kept, direction, nm, self.sigma()).is_none() {
                let is_missing = |unit: &usize| {
                    let (_, _, index) = self.place(*unit);
                    self.kept(kept, &self.light(nm, direction, index), index).is_none()
                };
                left.extend(cell.iter().copied().filter(is_missing));
            }
        }
        left
    }

    fn costs(&self, threads: usize, _progress: &dyn Progress) -> Result<Vec<Cost>> {
        // All instances are as large.
        let segment = self.segment(0)?;
        let each = (0..self.units()).step_by(self.instances).map(|unit| {
            let (direction, nm, _) = self.place(unit);
            let cost = segment::cost(&segment, &self.light(nm, direction, 0), &self.accuracy(), threads)?;
            Ok(vec![cost; self.instances])
        });
        Ok(each.collect::<Result<Vec<_>>>()?.concat())
    }

    fn keep(&self, unit: usize, kept: &Units, progress: &dyn Progress) -> Result<()> {
        if self.missing(&[unit], kept).is_empty() {
            return Ok(());
        }
        let (direction, nm, index) = self.place(unit);
        let light = self.light(nm, direction, index);
        self.scattered(&self.segment(index)?, &light, index, Some(kept), progress).map(|_| ())
    }

    fn finish(&self, kept: Option<&Units>, progress: &dyn Progress) -> Result<Compared> {
        let found = self.run(kept, progress)?;
        Ok(Compared {
            name: self.structure.name(),
            numbers: found.numbers(),
            figures: found.figures(),
            tables: Vec::new(),
            table: found.table(),
        })
    }
}

impl Plan {
    /// The direction of the light (θ_i and φ_i, rad), the wavelength (nm) and the instance of a unit: all instances of a wavelength follow
    /// one another, and all wavelengths of a direction.
    fn place(&self, unit: usize) -> ([f64; 2], f64, usize) {
        let (cell, index) = (unit / self.instances, unit % self.instances);
        let count = self.wavelengths.len();
        (self.directions[cell / count], self.wavelengths.nm()[cell % count], index)
    }

    /// σ of the BRDF that pictures are compared with.
    pub(super) fn sigma(&self) -> f64 {
        self.material.as_deref().map_or(USUAL_SIGMA, |material| material.sigma)
    }

    /// The far field of one segment, kept or new.
    pub(super) fn scattered(
        &self,
        segment: &Segment,
        light: &SegmentLight,
        index: usize,
        units: Option<&Units>,
        progress: &dyn Progress,
    ) -> Result<Scattered> {
        if let Some(kept) = units.and_then(|units| self.kept(units, light, index)) {
            return Ok(kept);
        }
        let begun = (self.clock)();
        let far = segment::far_field(segment, light, &self.accuracy(), &OnlyStops(progress))?;
        let seconds = ((self.clock)() - begun).as_secs_f64();
        let found = Scattered { intensity: far.intensity(), far, seconds };
        if let Some(units) = units {
            units.keep(
                &segment_name(light, index),
                &self.identity(light, index),
                &KeptSegment::from(&found),
            )?;
        }
        Ok(found)
    }

    fn kept(&self, units: &Units, light: &SegmentLight, index: usize) -> Option<Scattered> {
        units.get::<KeptSegment>(&segment_name(light, index), &self.identity(light, index))?.scattered()
    }

    /// What all instances gave at one wavelength under light from one direction, where it was kept.
    pub(super) fn kept_cell(
        &self,
        units: &Units,
        direction: [f64; 2],
        wavelength_nm: f64,
        sigma: f64,
    ) -> Option<Cell> {
        let light = self.light(wavelength_nm, direction, 0);
        units.get(&cell_name(&light), &self.cell_identity(&light, sigma))
    }

    /// Keeps that in place of the single far fields.
    pub(super) fn keep_cell(
        &self,
        units: &Units,
        direction: [f64; 2],
        wavelength_nm: f64,
        sigma: f64,
        cell: &Cell,
    ) -> Result<()> {
        let light = self.light(wavelength_nm, direction, 0);
        units.keep(&cell_name(&light), &self.cell_identity(&light, sigma), cell)?;
        for index in 0..self.instances {
            let light = self.light(wavelength_nm, direction, index);
            units.forget(&segment_name(&light, index), &self.identity(&light, index));
        }
        Ok(())
    }

    /// Of all that decides the bits of a segment's far field: what it is made from, the light and the program.
    fn identity(&self, light: &SegmentLight, index: usize) -> String {
        let SegmentLight { wavelength_nm, theta_i, phi_i, window_um, turn } = *light;
        let mut hasher = self.hasher("segment");
        hasher
            .count("instance", index as u64)
            .number("wavelength_nm", wavelength_nm)
            .numbers("direction", &[theta_i, phi_i])
            .numbers("window_um", &window_um)
            .number("turn", turn);
        hasher.hex()
    }

    fn cell_identity(&self, light: &SegmentLight, sigma: f64) -> String {
        let SegmentLight { wavelength_nm, theta_i, phi_i, window_um, turn: _ } = *light;
        let mut hasher = self.hasher("segments");
        hasher
            .count("instances", self.instances as u64)
            .number("tilt", self.tilt)
            .number("sigma", sigma)
            .number("wavelength_nm", wavelength_nm)
            .numbers("direction", &[theta_i, phi_i])
            .numbers("window_um", &window_um);
        hasher.hex()
    }

    fn hasher(&self, kind: &str) -> Hasher {
        let mut hasher = Hasher::new(kind);
        hasher
            .text("program", env!("CARGO_PKG_VERSION"))
            .text("simd", self.width.name())
            .text("structure", &self.structure.hash())
            .count("seed", self.seed)
            .number("length_um", self.length_um)
            .number("roughness_um", self.roughness.amplitude_um)
            .numbers("correlation_um", &self.roughness.correlation_um);
        hasher
    }
}

fn cell_name(light: &SegmentLight) -> String {
    let [theta, phi] = [light.theta_i, light.phi_i].map(|angle| angle.to_degrees().round());
    format!("segments-{theta}-{phi}-{}nm", light.wavelength_nm)
}

fn segment_name(light: &SegmentLight, index: usize) -> String {
    format!("{}-{index}", cell_name(light))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::math::simd::Width;
    use crate::progress::{NO_CLOCK, Shard, Unobserved};
    use crate::structure::Structure;
    use crate::validate::three_d::SegmentOptions;
    use crate::validate::work::tests::files;

    /// Asks to stop after so many steps.
    struct StopsAfter(u64, AtomicU64);

    impl Progress for StopsAfter {
        fn begin(&self, _label: &str, _total: u64) {}
        fn advance(&self, steps: u64) {
            self.1.fetch_add(steps, Ordering::Relaxed);
        }
        fn is_cancelled(&self) -> bool {
            self.1.load(Ordering::Relaxed) >= self.0
        }
    }

    /// Two wavelengths of one direction.
    fn small(instances: usize, width: Width) -> Plan {
        let options = SegmentOptions {
            wavelengths_nm: Some(vec![600.0, 650.0]),
            instances: Some(instances),
            length_um: Some(6.0),
            ..SegmentOptions::default()
        };
        let structure = Structure::flat("air/keratin:300±5%/melanin:300/air").unwrap();
        let plan = options.plan(structure, None, width, NO_CLOCK).unwrap();
        Plan { directions: vec![[0.0, 0.3]], ..plan }
    }

    #[test]
    fn a_stopped_comparison_goes_on_to_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let units = Units::new(folder.path());
        let plan = small(3, Width::best());
        // The BRDF contains it.
        assert_eq!(plan.tilt, crate::characterize::CampaignOptions::default().tilt_deg.to_radians());
        let stopped = plan.run(Some(&units), &StopsAfter(5, AtomicU64::new(0)));
        assert!(stopped.unwrap_err().is_interrupted());
        // One wavelength whole, and two of three segments of the other.
        assert_eq!(plan.done(&units), 5);
        let other = Plan { seed: 2, ..plan.clone() };
        assert_eq!(other.done(&units), 0);
        let (resumed, fresh) =
            (plan.run(Some(&units), &Unobserved).unwrap(), plan.run(None, &Unobserved).unwrap());
        assert_eq!(resumed.found, fresh.found);
        assert!(resumed.pictures[0].flat == fresh.pictures[0].flat);
        assert!(resumed.pictures[0].segments == fresh.pictures[0].segments);
        assert_eq!((plan.done(&units), std::fs::read_dir(folder.path()).unwrap().count()), (6, 2));
    }

    /// Whoever computes a unit, and in whatever order, it is the same file; and so is what all of them give together.
    #[test]
    fn parts_units_and_one_run_keep_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let [parts, units, whole] =
            ["parts", "units", "whole"].map(|name| (folder.path().join(name), small(2, Width::best())));
        let kept = |(path, _): &(std::path::PathBuf, Plan)| Units::new(path);
        for number in [1, 0] {
            let own = parts.1.part(Shard::new(number, 2).unwrap(), &Unobserved).unwrap();
            parts.1.run_units(&own, &kept(&parts), &Unobserved).unwrap();
            assert_eq!((own.len(), parts.1.missing(&own, &kept(&parts)).len()), (2, 0));
        }
        for unit in (0..4).rev() {
            units.1.run_unit(unit, &kept(&units), &Unobserved).unwrap();
            assert_eq!(units.1.missing(&[0, 1, 2, 3], &kept(&units)), (0..unit).collect::<Vec<_>>());
        }
        assert_eq!(files(&parts.0).len(), 4);
        assert!(files(&parts.0) == files(&units.0));
        let found =
            [&parts, &units, &whole].map(|one| one.1.finish(Some(&kept(one)), &Unobserved).unwrap().numbers);
        assert!(found[0] == found[1] && found[1] == found[2]);
        assert_eq!(files(&whole.0).len(), 2);
        assert!(files(&parts.0) == files(&whole.0) && files(&units.0) == files(&whole.0));
        assert!(units.1.run_unit(4, &kept(&units), &Unobserved).unwrap_err().is_input());
    }

    /// What other instructions computed is another unit, at most roundings away.
    #[test]
    fn instructions_are_part_of_a_unit() {
        let folder = tempfile::tempdir().unwrap();
        let units = Units::new(folder.path());
        let [best, scalar] = [Width::best(), Width::scalar()].map(|width| small(1, width));
        best.run_unit(0, &units, &Unobserved).unwrap();
        assert!(best.missing(&[0], &units).is_empty());
        if best.width.name() == scalar.width.name() {
            return;
        }
        assert_eq!(scalar.missing(&[0], &units), [0]);
        scalar.run_unit(0, &units, &Unobserved).unwrap();
        let light = best.light(600.0, best.directions[0], 0);
        let [a, b] = [&best, &scalar].map(|plan| plan.kept(&units, &light, 0).unwrap().intensity);
        let most = a.iter().fold(0.0_f64, |most, value| most.max(*value));
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0_f64, f64::max);
        assert!(most > 0.0 && apart < 1e-4 * most, "{apart} of {most}");
    }
}
