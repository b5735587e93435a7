//! Scattering matrices between planes in the reference medium, and their product.

use faer::prelude::Solve;
use faer::{Mat, c64};

/// How waves in the reference medium leave a part of the stack: `down` goes down, `up` goes up.
///
/// Waves are the tangential E of the orders, all E_x, then all E_y, so a mirror image in z swaps the two sides alone.
#[derive(Debug, Clone)]
pub(super) struct Scattering {
    /// From above back up.
    pub top: Mat<c64>,
    /// From below back down.
    pub bottom: Mat<c64>,
    /// From above to below.
    pub down: Mat<c64>,
    /// From below to above.
    pub up: Mat<c64>,
}

/// The waves between two parts from those that enter the pair: down = `from_top`·(down above) + `from_bottom`·(up
/// below), at the plane where the parts meet.
#[derive(Debug, Clone)]
pub(super) struct Join {
    pub from_top: Mat<c64>,
    pub from_bottom: Mat<c64>,
}

impl Scattering {
    /// The same part mirrored in z.
    pub(super) fn flipped(self) -> Self {
        Self { top: self.bottom, bottom: self.top, down: self.up, up: self.down }
    }

    /// The same part moved along x by `shift` periods: order m gains e^{−2πjm·shift} over what it came from.
    pub(super) fn shifted(&self, shift: f64) -> Self {
        let phases = phases(self.top.nrows() / 2, shift);
        let moved = |matrix: &Mat<c64>| {
            Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| phases[i] * matrix[(i, j)] * phases[j].conj())
        };
        Self {
            top: moved(&self.top),
            bottom: moved(&self.bottom),
            down: moved(&self.down),
            up: moved(&self.up),
        }
    }

    /// This part above another: Redheffer's star product. Only decaying waves enter it.
    pub(super) fn above(&self, lower: &Self) -> (Self, Join) {
        let size = self.top.nrows();
        let bounce = &self.bottom * &lower.top;
        let echo = Mat::from_fn(size, size, |i, j| c64::from(f64::from(u8::from(i == j))) - bounce[(i, j)]);
        let echo = echo.partial_piv_lu();
        let from_top = echo.solve(&self.down);
        let from_bottom = echo.solve(&self.bottom * &lower.up);
        let up_from_bottom = &lower.top * &from_bottom + &lower.up;
        let pair = Self {
            top: &self.top + &self.up * (&lower.top * &from_top),
            bottom: &lower.bottom + &lower.down * &from_bottom,
            down: &lower.down * &from_top,
            up: &self.up * up_from_bottom,
        };
        (pair, Join { from_top, from_bottom })
    }
}

/// e^{−2πjm·shift} of `orders` orders about m = 0, for E_x and again for E_y.
pub(super) fn phases(orders: usize, shift: f64) -> Vec<c64> {
    let half = (orders / 2) as f64;
    (0..2 * orders)
        .map(|i| c64::from_polar(1.0, -std::f64::consts::TAU * ((i % orders) as f64 - half) * shift))
        .collect()
}
