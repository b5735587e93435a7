//! Axes of tables.

use fearless_simd::{Simd, f64x8, prelude::*};

/// Rising places, found by arithmetic where they are evenly spaced.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) places: Vec<f64>,
    pub(super) inverse_spacing: Option<f64>,
}

impl Axis {
    pub(super) fn new(places: Vec<f64>) -> Self {
        let (first, last) = (places[0], places[places.len() - 1]);
        let spacing = (last - first) / (places.len().max(2) - 1) as f64;
        let even =
            places.iter().enumerate().all(|(k, p)| (first + k as f64 * spacing - p).abs() < 1e-9 * last);
        Self { places, inverse_spacing: (even && spacing > 0.0).then_some(1.0 / spacing) }
    }

    /// The place below and the share of the one above; beyond the ends those hold.
    #[inline(always)]
    pub(super) fn find(&self, at: f64) -> (usize, f64) {
        let places = &self.places[..];
        if places.len() < 2 {
            return (0, 0.0);
        }
        let last = places.len() - 2;
        if let Some(inverse) = self.inverse_spacing {
            let position = ((at - places[0]) * inverse).max(0.0).min((last + 1) as f64);
            let index = (position as i32).min(last as i32);
            return (index as usize, position - f64::from(index));
        }
        let index = places.partition_point(|p| *p <= at).clamp(1, last + 1) - 1;
        let share = (at - places[index]) / (places[index + 1] - places[index]);
        (index, share.clamp(0.0, 1.0))
    }

    /// [`find`](Self::find) for eight.
    #[inline(always)]
    pub(super) fn find_eight<S: Simd>(&self, at: f64x8<S>) -> [(usize, f64); 8] {
        let Some(inverse) = self.inverse_spacing else {
            let at: [f64; 8] = at.into();
            return at.map(|at| self.find(at));
        };
        let last = (self.places.len() - 2) as f64;
        let position = ((at - self.places[0]) * inverse).max(0.0).min(last + 1.0);
        let index = position.floor().min(last);
        let (index, share): ([f64; 8], [f64; 8]) = (index.into(), (position - index).into());
        std::array::from_fn(|k| (index[k] as i32 as usize, share[k]))
    }
}
