//! What is fitted to one light.

use super::steady::Steady;
use crate::scattering::lobe::PairFit;

/// The fits of one (λ, ω_i).
pub(super) struct FittedNode {
    pub(super) mean: PairFit,
    /// Part of the first lobe in what is reflected.
    pub(super) first: f64,
    /// At most 1.
    pub(super) reflected: f64,
    /// What was simulated.
    pub(super) simulated: f64,
    pub(super) steady: Steady,
    /// Part of the mean field's intensity V in what was simulated.
    pub(super) coherent: f64,
    /// Polarization 1's part in the mirror direction, and its slope.
    pub(super) fraction_1: [f64; 2],
}
