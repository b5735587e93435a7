//! Samples that no light can make: not finite, or negative beyond rounding. They are left out of the picture and counted, with the
//! place of the first, since each is a fault of a material, a light or this program.

use super::integrator::FirstHit;
use crate::spectrum::dense::WAVES;

/// How far below zero a sample may be by rounding: of its own largest value, and at all (white under daylight has about 1).
const ROUNDING: f64 = 1e-6;
const ROUNDING_AT_ALL: f64 = 1e-9;

/// Where an impossible sample was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// Column and row of the pixel.
    pub pixel: [u32; 2],
    /// Number of the sample in it.
    pub sample: u32,
    /// Index of the object that it saw first, as of the scene's names of objects; `None` where it saw none.
    pub object: Option<u32>,
}

/// The impossible samples of a picture or a part of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Faults {
    /// How many.
    pub count: u64,
    /// The first by sample, row and column, however the work was divided.
    pub first: Option<Fault>,
}

impl Fault {
    pub(super) fn new(pixel: [u32; 2], sample: u32, first: &FirstHit) -> Self {
        Self { pixel, sample, object: (first.id != 0).then_some(first.object) }
    }

    fn order(&self) -> (u32, u32, u32) {
        (self.sample, self.pixel[1], self.pixel[0])
    }
}

impl Faults {
    pub(super) fn add(&mut self, fault: Fault) {
        *self = self.with(&Self { count: 1, first: Some(fault) });
    }

    /// Those of two parts together.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let first = self.first.into_iter().chain(other.first).min_by_key(Fault::order);
        Self { count: self.count + other.count, first }
    }
}

/// Whether light can have this radiance.
#[inline(always)]
pub(super) fn is_possible(radiance: &[f64; WAVES]) -> bool {
    let largest = radiance.iter().fold(0.0, |largest, value| f64::max(largest, value.abs()));
    let least = -(ROUNDING_AT_ALL + ROUNDING * largest);
    // Comparisons with NaN are false.
    largest < f64::INFINITY && radiance.iter().all(|value| *value >= least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_finite_and_not_negative_but_for_rounding() {
        let with = |value: f64| {
            let mut radiance = [1.0; WAVES];
            radiance[3] = value;
            is_possible(&radiance)
        };
        assert!(with(0.0) && with(-0.0) && with(1e12) && with(-1e-12));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e-3] {
            assert!(!with(bad), "{bad}");
        }
    }

    #[test]
    fn the_first_is_the_same_however_faults_come_together() {
        let fault = |pixel, sample| Fault { pixel, sample, object: None };
        let all = [fault([5, 2], 1), fault([9, 1], 0), fault([3, 1], 0), fault([0, 0], 7)];
        let sum = |order: &[usize]| {
            let mut faults = Faults::default();
            order.iter().for_each(|at| faults.add(all[*at]));
            faults
        };
        assert_eq!(sum(&[0, 1, 2, 3]), Faults { count: 4, first: Some(all[2]) });
        assert_eq!(sum(&[3, 2, 1, 0]), sum(&[0, 1, 2, 3]));
    }
}
