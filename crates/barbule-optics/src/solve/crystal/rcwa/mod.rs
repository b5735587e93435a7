//! Rigorous coupled-wave analysis (Fourier modal method) of gratings of any outline, in conical mount.
//!
//! The cross section is cut into slices with vertical walls ([`profile`]); each slice's fields are expanded in its own
//! modes (`modes`), and slices are joined by scattering matrices (`scattering`, `stack`). At Rayleigh anomalies (an
//! order exactly at grazing above or below) |q| is held at 1e-7; nothing else is nudged.

mod modes;
pub mod profile;
mod scattering;
mod stack;
#[cfg(test)]
mod tests;

use super::cell::{passive, positive};
use super::orders::DiffractionOrders;
use super::{Cell, CrystalResponse, CrystalSolver, Incidence, Surroundings};
use crate::math::dense::Dense;
use crate::{Complex64, Error, Result};
use modes::Harmonics;
use profile::{Body, Outline, bodies};
use stack::Stack;

/// The solver and its accuracy.
#[derive(Debug, Clone, Copy)]
pub struct Rcwa {
    /// Orders −orders … orders are kept.
    pub orders: usize,
    /// Slices per rod (per greatest height of a body), rounded to an even number.
    pub slices: usize,
    /// Whether [`CrystalResponse::convergence`] is found, by further runs with a half and a quarter of the orders and slices. Halving
    /// doubles an error that falls as 1/orders, so either run's difference from the next tells it; the larger counts, since
    /// at metal rods one of them may be small by chance.
    pub estimate: bool,
}

impl Default for Rcwa {
    fn default() -> Self {
        Self { orders: 20, slices: 24, estimate: true }
    }
}

impl CrystalSolver for Rcwa {
    fn respond(&self, cell: &Cell, incidence: &Incidence) -> Result<CrystalResponse> {
        self.respond_to(&cell.surroundings(), &bodies(cell), incidence)
    }
}

impl Rcwa {
    /// The response of bodies of any outline.
    ///
    /// # Errors
    /// Media, bodies or waves that have no meaning, or eigenvalues that were not found.
    pub fn respond_to(
        &self,
        surroundings: &Surroundings,
        bodies: &[Body],
        incidence: &Incidence,
    ) -> Result<CrystalResponse> {
        check_bodies(bodies)?;
        let period_um = surroundings.period_um;
        let diffraction = DiffractionOrders::new(surroundings, incidence)?;
        if self.orders == 0 || self.slices == 0 {
            return Err(Error::input("RCWA needs at least one order to each side and one slice per rod"));
        }
        let mut response = self.solve(&diffraction, period_um, bodies)?;
        if self.estimate {
            let part = |by: usize| {
                let coarse =
                    Self { orders: self.orders.div_ceil(by), slices: self.slices.div_ceil(by), ..*self };
                coarse.solve(&diffraction, period_um, bodies)
            };
            let (half, quarter) = (part(2)?, part(4)?);
            let last = diffraction.difference(&response, &half);
            let before = diffraction.difference(&half, &quarter);
            response.convergence = Some(last.max(0.5 * before));
        }
        Ok(response)
    }

    fn solve(
        &self,
        diffraction: &DiffractionOrders,
        period_um: f64,
        bodies: &[Body],
    ) -> Result<CrystalResponse> {
        let propagating = diffraction.propagating();
        let reach = propagating.iter().map(|m| m.abs()).max().unwrap_or(0);
        let limit = reach.max(i32::try_from(self.orders).unwrap_or(i32::MAX));
        let harmonics = Harmonics::new(diffraction, limit);
        let stack = Stack::solve(&harmonics, bodies, period_um, diffraction.host_eps, self.slices)?;
        let surface = Surface::new(diffraction, &harmonics);
        let count = harmonics.len();
        let size = 2 * count;
        let under = stack.reflection();
        let mut echo = Dense::from_fn(size, size, |i, j| {
            (0..2)
                .map(|part| surface.bottom[i % count][i / count][part] * under[(i % count + part * count, j)])
                .sum()
        });
        echo.one_less();
        let zeroth = limit as usize;
        let entering = Dense::from_fn(size, 2, |i, polarization| {
            let wave = diffraction.incident(polarization);
            let [e, h] = surface.down[zeroth][i / count];
            if i % count == zeroth { e * wave[0] + h * wave[1] } else { Complex64::ZERO }
        });
        let down = echo.under(entering);
        let up = under.times(&down);
        let reflected = |m: i32, polarization: usize| -> [Complex64; 2] {
            let order = (m + limit) as usize;
            let wave = diffraction.incident(polarization);
            std::array::from_fn(|field| {
                let through = &surface.up[order][field];
                let direct = &surface.top[order][field];
                let own = if m == 0 { direct[0] * wave[0] + direct[1] * wave[1] } else { Complex64::ZERO };
                own + through[0] * up[(order, polarization)] + through[1] * up[(order + count, polarization)]
            })
        };
        let orders = propagating
            .iter()
            .map(|&m| diffraction.order(m, std::array::from_fn(|polarization| reflected(m, polarization))))
            .collect();
        let (mut transmitted, mut absorbed) = ([0.0; 2], [0.0; 2]);
        // Power along −z of both incident polarizations: n cosθ cosφ.
        let incident = diffraction.q_above(0).re;
        for polarization in 0..2 {
            let budget = stack.budget(&harmonics, down.column(polarization));
            absorbed[polarization] = budget.absorbed / incident;
            transmitted[polarization] = budget.transmitted / incident;
        }
        Ok(CrystalResponse { orders, transmitted, absorbed, convergence: None })
    }
}

fn check_bodies(bodies: &[Body]) -> Result<()> {
    for (index, body) in bodies.iter().enumerate() {
        let place = |error: Error| error.at(format!("body {index}"));
        passive("body", body.eps).map_err(place)?;
        if !body.x_um.is_finite() || !body.depth_um.is_finite() {
            return Err(place(Error::input("its position is not a number")));
        }
        match &body.outline {
            Outline::Ellipse { width_um, height_um } => {
                positive("width", *width_um).map_err(place)?;
                positive("height", *height_um).map_err(place)?;
            }
            Outline::Polygon(points) => {
                if points.len() < 3 || points.iter().flatten().any(|value| !value.is_finite()) {
                    return Err(place(Error::input("its outline needs three points or more, all finite")));
                }
            }
        }
        let (top, bottom) = body.outline.extent();
        if body.depth_um + top < 0.0 || top >= bottom {
            return Err(place(Error::input(format!(
                "it reaches from {} to {} µm below the surface; it must have a height and lie below the surface",
                body.depth_um + top,
                body.depth_um + bottom
            ))));
        }
    }
    Ok(())
}

/// The flat surface between the incidence medium (waves as (E_y, H̃_y)) and the reference medium (as (E_x, E_y)), per order.
struct Surface {
    /// From above back up.
    top: Vec<[[Complex64; 2]; 2]>,
    /// From below back down.
    bottom: Vec<[[Complex64; 2]; 2]>,
    /// From above to below.
    down: Vec<[[Complex64; 2]; 2]>,
    /// From below to above.
    up: Vec<[[Complex64; 2]; 2]>,
}

impl Surface {
    fn new(diffraction: &DiffractionOrders, harmonics: &Harmonics) -> Self {
        let mut surface = Self { top: vec![], bottom: vec![], down: vec![], up: vec![] };
        let (eps, kappa, b) = (diffraction.n * diffraction.n, diffraction.kappa(), diffraction.b);
        for order in 0..harmonics.len() {
            let m = order as i32 - harmonics.limit;
            let ba = Complex64::from(b * diffraction.a(m) / kappa);
            let q = diffraction.q_above(m) / kappa;
            let v = harmonics.admittance(order);
            // Rows E_x, E_y, H_x, H_y of waves that leave: above (E_y, H_y), below (E_x, E_y).
            let (one, zero) = (Complex64::ONE, Complex64::ZERO);
            let leaving = [
                [-ba, q, -one, zero],
                [one, zero, zero, -one],
                [-eps * q, -ba, v[0][0], v[0][1]],
                [zero, one, v[1][0], v[1][1]],
            ];
            let arriving = [
                [ba, q, one, zero],
                [-one, zero, zero, one],
                [-eps * q, ba, v[0][0], v[0][1]],
                [zero, -one, v[1][0], v[1][1]],
            ];
            let leaving = Dense::from_fn(4, 4, |i, j| leaving[i][j]);
            let s = leaving.under(Dense::from_fn(4, 4, |i, j| arriving[i][j]));
            let block = |row: usize, column: usize| {
                [[s[(row, column)], s[(row, column + 1)]], [s[(row + 1, column)], s[(row + 1, column + 1)]]]
            };
            surface.top.push(block(0, 0));
            surface.up.push(block(0, 2));
            surface.down.push(block(2, 0));
            surface.bottom.push(block(2, 2));
        }
        surface
    }
}
