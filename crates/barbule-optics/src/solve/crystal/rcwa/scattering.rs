//! Scattering matrices between planes in the reference medium, and their product.

use crate::Complex64;
use crate::math::dense::Dense;

/// How waves in the reference medium leave a part of the stack: `down` goes down, `up` goes up.
///
/// Waves are the tangential E of the orders, all E_x, then all E_y, so a mirror image in z swaps the two sides alone.
#[derive(Debug, Clone)]
pub(super) struct Scattering {
    /// From above back up.
    pub top: Dense,
    /// From below back down.
    pub bottom: Dense,
    /// From above to below.
    pub down: Dense,
    /// From below to above.
    pub up: Dense,
}

/// The waves between two parts from those that enter the pair: down = `from_top`·(down above) + `from_bottom`·(up
/// below), at the plane where the parts meet.
#[derive(Debug, Clone)]
pub(super) struct Join {
    pub from_top: Dense,
    pub from_bottom: Dense,
}

impl Scattering {
    /// The same part mirrored in z.
    pub(super) fn flipped(self) -> Self {
        Self { top: self.bottom, bottom: self.top, down: self.up, up: self.down }
    }

    /// The same part moved along x by `shift` periods: order m gains e^{−2πjm·shift} over what it came from.
    pub(super) fn shifted(&self, shift: f64) -> Self {
        let phases = phases(self.top.rows() / 2, shift);
        let back: Vec<Complex64> = phases.iter().map(Complex64::conj).collect();
        let moved = |matrix: &Dense| matrix.scaled(&phases, &back);
        Self {
            top: moved(&self.top),
            bottom: moved(&self.bottom),
            down: moved(&self.down),
            up: moved(&self.up),
        }
    }

    /// This part above another: Redheffer's star product. Only decaying waves enter it.
    pub(super) fn above(&self, lower: &Self) -> (Self, Join) {
        let mut echo = self.bottom.times(&lower.top);
        echo.one_less();
        let echo = echo.factor();
        let (mut from_top, mut from_bottom) = (self.down.clone(), self.bottom.times(&lower.up));
        echo.solve(&mut from_top);
        echo.solve(&mut from_bottom);
        let up_from_bottom = lower.top.times(&from_bottom).plus(&lower.up);
        let pair = Self {
            top: self.top.plus(&self.up.times(&lower.top.times(&from_top))),
            bottom: lower.bottom.plus(&lower.down.times(&from_bottom)),
            down: lower.down.times(&from_top),
            up: self.up.times(&up_from_bottom),
        };
        (pair, Join { from_top, from_bottom })
    }
}

/// e^{−2πjm·shift} of `orders` orders about m = 0, for E_x and again for E_y.
pub(super) fn phases(orders: usize, shift: f64) -> Vec<Complex64> {
    let half = (orders / 2) as f64;
    (0..2 * orders)
        .map(|i| Complex64::from_polar(1.0, -std::f64::consts::TAU * ((i % orders) as f64 - half) * shift))
        .collect()
}
