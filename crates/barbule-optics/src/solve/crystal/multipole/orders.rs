//! Plane waves of a grating: the Floquet orders in the host, and the flat surface that they cross.

use num_complex::Complex64;

use super::Wave;

/// An order is kept this far (over κ) from grazing the host: nearer, 1/γ would cost as many digits as the shift does.
const LEAST_GAMMA: f64 = 1e-8;

/// Orders m = first, first + 1, … in the host: e^{j(α_m x ± γ_m z)}, α_m = α₀ + 2πm/Δ, γ_m = √(κ² − α_m²).
#[derive(Debug, Clone)]
pub(super) struct Orders {
    pub(super) first: i32,
    pub(super) alpha: Vec<f64>,
    pub(super) gamma: Vec<Complex64>,
    /// e^{jζ} with α = κ cosζ, γ = κ sinζ.
    pub(super) w: Vec<Complex64>,
}

impl Orders {
    /// The orders `first ..= last` of a wave whose zeroth order has α₀.
    pub(super) fn new(wave: &Wave, alpha0: f64, period: f64, first: i32, last: i32) -> Self {
        let mut orders = Self { first, alpha: Vec::new(), gamma: Vec::new(), w: Vec::new() };
        for m in first..=last {
            let alpha = alpha0 + std::f64::consts::TAU * f64::from(m) / period;
            let mut gamma = ((wave.kappa - alpha) * (wave.kappa + alpha)).sqrt();
            if gamma.im < 0.0 || gamma.im == 0.0 && gamma.re < 0.0 {
                gamma = -gamma;
            }
            if gamma.norm() < LEAST_GAMMA * wave.kappa.norm() {
                gamma = wave.kappa * LEAST_GAMMA;
            }
            // the smaller of e^{±jζ} from the larger: no cancellation
            let toward = Complex64::i() * gamma;
            let plus = (alpha + toward) / wave.kappa;
            let minus = (alpha - toward) / wave.kappa;
            orders.alpha.push(alpha);
            orders.gamma.push(gamma);
            orders.w.push(if plus.norm_sqr() >= minus.norm_sqr() { plus } else { minus.inv() });
        }
        orders
    }

    /// How many.
    pub(super) fn len(&self) -> usize {
        self.alpha.len()
    }

    /// The part `first ..= last`.
    pub(super) fn part(&self, first: i32, last: i32) -> Self {
        let from = (first - self.first) as usize;
        let to = (last - self.first) as usize + 1;
        Self {
            first,
            alpha: self.alpha[from..to].to_vec(),
            gamma: self.gamma[from..to].to_vec(),
            w: self.w[from..to].to_vec(),
        }
    }

    /// Index of order m.
    pub(super) fn index(&self, m: i32) -> usize {
        (m - self.first) as usize
    }
}

/// A 2×2 matrix that acts on (E_y, H̃_y).
pub(super) type Pair = [[Complex64; 2]; 2];

/// Amplitudes (E_y, H̃_y) at the flat surface for one order: reflection and transmission from above and from below.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    pub(super) r: Pair,
    pub(super) t: Pair,
    pub(super) r_below: Pair,
    pub(super) t_below: Pair,
}

impl Surface {
    /// Continuity of E_y, H̃_y, E_x, H̃_x at z = 0 with E_t = (j/κ²)(k_y∇E_y − k₀ŷ×∇H̃_y),
    /// H̃_t = (j/κ²)(k_y∇H̃_y + k₀ε ŷ×∇E_y) on both sides (conical Fresnel coefficients).
    ///
    /// `gamma0` belongs to the medium above, `gamma` to the host.
    pub(super) fn new(wave: &Wave, alpha: f64, gamma0: Complex64, gamma: Complex64) -> Self {
        let (k0, above, host) = (wave.k0, wave.kappa0 * wave.kappa0, wave.kappa * wave.kappa);
        // all divided by k₀; c couples the polarizations and vanishes without contrast
        let c = wave.ky * alpha / k0 * (host - above) / (above * host);
        let (g0, g) = (gamma0 / above, gamma / host);
        let (e0, e) = (wave.eps0 * g0, wave.eps * g);
        // −c E₀ + (g₀+g) H₀ = cE + (g₀−g)H (from above) or 2gH (from below)
        // (e₀+e) E₀ + c H₀ = (e₀−e)E − cH (from above) or 2eE (from below)
        let det = -(c * c + (g0 + g) * (e0 + e));
        let solve = |first: Complex64, second: Complex64| {
            [(c * first - (g0 + g) * second) / det, (-c * second - (e0 + e) * first) / det]
        };
        let zero = Complex64::new(0.0, 0.0);
        let columns = |a: [Complex64; 2], b: [Complex64; 2]| [[a[0], b[0]], [a[1], b[1]]];
        let r = columns(solve(c, e0 - e), solve(g0 - g, -c));
        let t_below = columns(solve(zero, 2.0 * e), solve(2.0 * g, zero));
        let plus = |a: Pair, sign: f64| [[a[0][0] + sign, a[0][1]], [a[1][0], a[1][1] + sign]];
        Self { r, t: plus(r, 1.0), r_below: plus(t_below, -1.0), t_below }
    }
}

/// Power that flows down (−z) per area in one order with amplitudes (E_y, H̃_y) going down, over ½: −Re(E×H̃*)_z.
pub(super) fn flux_down(wave: &Wave, alpha: f64, gamma: Complex64, e: Complex64, h: Complex64) -> f64 {
    let kappa2 = wave.kappa * wave.kappa;
    let ex = -(wave.ky * alpha * e + wave.k0 * gamma * h) / kappa2;
    let hx = (wave.k0 * wave.eps * gamma * e - wave.ky * alpha * h) / kappa2;
    -(ex * h.conj() - e * hx.conj()).re
}
