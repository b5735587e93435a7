//! The one place that knows all that can lie under a top.

use fearless_simd::dispatch;

use super::crystal::CrystalOrders;
use super::points::Optics;
use super::reflection::{Currents, Lit, reflect_block};
use super::scalar::Scalar;
use crate::math::simd::Width;

/// What reflects under a barbule's top at one wavelength.
pub(super) enum Reflector<T: Scalar> {
    /// The stacks under the points, reflected from anew at each angle.
    Stacks(Optics<T>),
    /// Their reflectances, tabulated for all angles.
    Tabulated(T::Table),
    /// A photonic crystal at one θ_i.
    Crystal(CrystalOrders<T>),
}

impl<T: Scalar> Reflector<T> {
    /// The currents g·J·dl and g·M·dl of the points `start` … `start + BLOCK`, for both incident polarizations, under light
    /// from each of some directions, times the phase of the rise towards where each point sends its light.
    pub(super) fn currents<const G: usize>(
        &self,
        width: Width,
        lights: &[Lit<'_, T>; G],
        start: usize,
        out: &mut [Currents<T>; G],
    ) {
        match self {
            Self::Tabulated(table) => {
                dispatch!(width.0, simd => reflect_block(simd, lights, table, start, out));
            }
            Self::Stacks(optics) => {
                for (lit, out) in lights.iter().zip(out.as_chunks_mut::<1>().0) {
                    let lit = std::array::from_ref(lit);
                    dispatch!(width.0, simd => reflect_block(simd, lit, optics, start, out));
                }
            }
            Self::Crystal(orders) => {
                for (lit, out) in lights.iter().zip(out) {
                    dispatch!(width.0, simd => orders.reflect_block(simd, lit, start, out));
                }
            }
        }
    }
}
