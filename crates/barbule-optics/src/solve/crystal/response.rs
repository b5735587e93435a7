//! What the solvers answer: the orders that leave, and where the rest of the power goes.

use crate::scattering::orders::Jones;

/// A propagating reflected order.
#[derive(Debug, Clone, Copy)]
pub struct Order {
    /// Its number: sinφ_o = −sinφ_i + mλ/(Δ n cosθ_i).
    pub m: i32,
    /// Its azimuth, rad.
    pub phi_o: f64,
    /// `[out][in]` along e₁, e₂ of the outgoing and of the incident direction.
    pub jones: Jones,
}

/// What becomes of a plane wave of unit amplitude.
#[derive(Debug, Clone)]
pub struct CrystalResponse {
    /// Propagating reflected orders, m ascending.
    pub orders: Vec<Order>,
    /// Power that flows down through the plane at the lowest rods' lower edge (the surface where there are none) over
    /// incident power, per incident polarization. An absorbing host takes all of it further down.
    pub transmitted: [f64; 2],
    /// Power absorbed above that plane over incident power, per incident polarization: by the rods, and by the host
    /// between and above them where it absorbs. It is summed from the fields, so that R + T + A = 1 is a check; in
    /// an absorbing host multipoles alone give 1 − R − T.
    pub absorbed: [f64; 2],
    /// The solver's own estimate of the error of R, the largest over orders and polarizations; `None` if it was not
    /// asked for one.
    pub convergence: Option<f64>,
}

impl Order {
    /// Power of this order over incident power, by incident polarization, for light from azimuth `phi_i` (rad).
    #[must_use]
    pub fn reflectance(&self, phi_i: f64) -> [f64; 2] {
        let [first, second] = &self.jones;
        [0, 1].map(|q| (first[q].norm_sqr() + second[q].norm_sqr()) * self.phi_o.cos() / phi_i.cos())
    }
}

impl CrystalResponse {
    /// Power of all reflected orders over incident power, by incident polarization.
    #[must_use]
    pub fn reflectance(&self, phi_i: f64) -> [f64; 2] {
        self.orders.iter().fold([0.0; 2], |[a, b], order| {
            let [first, second] = order.reflectance(phi_i);
            [a + first, b + second]
        })
    }

    /// The larger |R + T + A − 1| of both polarizations.
    #[must_use]
    pub fn imbalance(&self, phi_i: f64) -> f64 {
        let reflected = self.reflectance(phi_i);
        [0, 1]
            .map(|q| (reflected[q] + self.transmitted[q] + self.absorbed[q] - 1.0).abs())
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// The largest difference of an order's reflectance from that of another response to the same wave.
    #[must_use]
    pub fn distance(&self, other: &Self, phi_i: f64) -> f64 {
        let pairs = self.orders.iter().zip(&other.orders);
        pairs
            .flat_map(|(a, b)| {
                let (a, b) = (a.reflectance(phi_i), b.reflectance(phi_i));
                [(a[0] - b[0]).abs(), (a[1] - b[1]).abs()]
            })
            .fold(0.0, f64::max)
    }
}
