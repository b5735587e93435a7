//! The photonic crystal under all barbules of a structure.

use crate::scattering::orders::OrderTable;
use crate::scattering::statistics::Axes;
use crate::solve::surface::Underside;
use crate::structure::Lattice;
use crate::{Error, Result};

/// A crystal's orders at several wavelengths and θ_i, and its depth.
pub(super) struct Crystal {
    pub(super) orders: OrderTable,
    depth_um: f64,
}

impl Crystal {
    /// A lattice whose orders are those of a campaign's axes.
    pub(super) fn new(orders: OrderTable, lattice: &Lattice, axes: &Axes) -> Result<Self> {
        if orders.wavelengths_nm != axes.wavelengths_nm() || orders.cos_theta != axes.cos_theta() {
            return Err(Error::machine("the orders of the crystal belong to other axes"));
        }
        Ok(Self::of(orders, lattice))
    }

    /// A lattice with its orders.
    pub(super) fn of(orders: OrderTable, lattice: &Lattice) -> Self {
        Self { orders, depth_um: lattice.bottom_um() }
    }

    /// What reflects under the tops at a wavelength and a θ_i by their numbers; `theta_i` is that angle, rad.
    pub(super) fn underside(&self, wavelength: usize, theta: usize, theta_i: f64) -> Underside {
        Underside::crystal(self.orders.at(wavelength, theta), theta_i, self.depth_um)
    }
}
