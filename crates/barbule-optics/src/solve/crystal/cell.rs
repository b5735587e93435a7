//! What the solvers solve: a cell and the wave that lights it, checked here for all of them.

use crate::structure::{Lattice, TOUCHING_UM};
use crate::{Complex64, Error, Result};

/// Orders that may propagate in the host; solvers take memory with their square and time with their cube.
const MOST_ORDERS: f64 = 300.0;

/// Permittivities below this count as 0.
const LEAST_EPS: f64 = 1e-12;

/// The period and what surrounds the rods: a host that fills everything below the flat surface z = 0 and goes on below
/// as a half-space, under a lossless incidence medium.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings {
    pub(super) period_um: f64,
    pub(super) incidence_eps: f64,
    pub(super) host_eps: Complex64,
}

/// A crystal at one wavelength: rods along y, periodic in x, in their [`Surroundings`].
///
/// Every cell has a meaning for every solver: [`Cell::new`] and [`Cell::from_rods`] check what all of them need.
/// What a solver cannot do beyond that stands with it.
#[derive(Debug, Clone)]
pub struct Cell {
    pub(super) period_um: f64,
    pub(super) incidence_eps: f64,
    pub(super) host_eps: Complex64,
    pub(super) rods: Vec<CellRod>,
}

/// A rod: concentric circles around one axis along y.
#[derive(Debug, Clone)]
pub struct CellRod {
    /// Position of the axis, µm; any real number, its position modulo the period counts.
    pub x_um: f64,
    /// Depth of the axis below the surface, µm; more than the radius.
    pub depth_um: f64,
    /// Outermost first, diameters strictly falling.
    pub shells: Vec<Shell>,
}

/// What lies within one circle of a rod, up to the next smaller circle.
#[derive(Debug, Clone, Copy)]
pub struct Shell {
    /// Outer diameter, µm.
    pub diameter_um: f64,
    /// Relative permittivity.
    pub eps: Complex64,
}

/// A plane wave that comes from ω_i = (cosθ sinφ, sinθ, cosθ cosφ).
#[derive(Debug, Clone, Copy)]
pub struct Incidence {
    /// Wavelength in vacuum, nm.
    pub wavelength_nm: f64,
    /// Longitudinal angle, rad, within ±π/2.
    pub theta_i: f64,
    /// Azimuth in the cross section, rad, within ±π/2.
    pub phi_i: f64,
}

impl Surroundings {
    /// A period (µm) and the relative permittivities above the surface and of the host.
    ///
    /// # Errors
    /// A period or permittivity above that is not positive, or a host that amplifies, has ε = 0 or is not finite.
    pub fn new(period_um: f64, incidence_eps: f64, host_eps: Complex64) -> Result<Self> {
        positive("period", period_um)?;
        positive("permittivity of the incidence medium", incidence_eps)?;
        passive("host", host_eps)?;
        Ok(Self { period_um, incidence_eps, host_eps })
    }

    /// Refuses wavelengths (nm) so short that more orders propagate than can be solved for.
    pub(super) fn check_orders(&self, wavelength_nm: f64) -> Result<()> {
        let index = self.host_eps.sqrt().re.max(self.incidence_eps.sqrt());
        let orders = 2.0 * self.period_um * index / (wavelength_nm * 1e-3);
        if orders > MOST_ORDERS {
            return Err(Error::input(format!(
                "lattice.period of {} µm carries {orders:.0} orders at {wavelength_nm} nm, over {MOST_ORDERS}; give a shorter period",
                self.period_um
            )));
        }
        Ok(())
    }
}

impl Cell {
    /// A lattice at one vacuum wavelength (nm).
    ///
    /// # Errors
    /// A medium has no index there, the incidence medium absorbs, the period carries too many orders, or as
    /// [`Self::from_rods`].
    pub fn new(lattice: &Lattice, wavelength_nm: f64) -> Result<Self> {
        let eps = |substance| -> Result<Complex64> {
            let index = lattice.material(substance)?.index(wavelength_nm)?;
            Ok(index * index)
        };
        let incidence = lattice.material(&lattice.incidence)?.index(wavelength_nm)?;
        if incidence.im != 0.0 || incidence.re <= 0.0 {
            return Err(Error::input(format!(
                "lattice.incidence has the index {incidence} at {wavelength_nm} nm, but light must come through a medium that does not absorb"
            )));
        }
        let surroundings =
            Surroundings::new(lattice.period_um, incidence.re * incidence.re, eps(&lattice.host)?)?;
        surroundings.check_orders(wavelength_nm)?;
        let shells = lattice
            .rods
            .iter()
            .map(|rod| {
                rod.circles
                    .iter()
                    .map(|circle| Ok(Shell { diameter_um: circle.diameter_um, eps: eps(&circle.medium)? }))
                    .collect::<Result<Vec<_>>>()
            })
            .collect::<Result<Vec<_>>>()?;
        let rods = lattice.placed().map(|placed| CellRod {
            x_um: placed.x_um,
            depth_um: placed.depth_um,
            shells: shells[placed.rod].clone(),
        });
        Self::from_rods(surroundings, rods.collect())
    }

    /// Every rod of every row of one period; none leaves the flat surface.
    ///
    /// # Errors
    /// Rods without shells, at no place, of diameters that do not fall, of media that amplify or are not finite, that
    /// reach the surface, or that overlap by more than [`TOUCHING_UM`].
    pub fn from_rods(surroundings: Surroundings, rods: Vec<CellRod>) -> Result<Self> {
        let Surroundings { period_um, incidence_eps, host_eps } = surroundings;
        for (index, rod) in rods.iter().enumerate() {
            rod.check().map_err(|error| error.at(format!("rod {index}")))?;
        }
        let cell = Self { period_um, incidence_eps, host_eps, rods };
        cell.check_overlap()?;
        Ok(cell)
    }

    /// The same without its rods.
    #[must_use]
    pub fn surroundings(&self) -> Surroundings {
        let Self { period_um, incidence_eps, host_eps, .. } = *self;
        Surroundings { period_um, incidence_eps, host_eps }
    }

    /// Relative permittivity between and below the rods.
    #[must_use]
    pub fn host_eps(&self) -> Complex64 {
        self.host_eps
    }

    /// Every rod of every row of one period.
    #[must_use]
    pub fn rods(&self) -> &[CellRod] {
        &self.rods
    }

    /// Least distance between two rods' axes over all periods, µm.
    pub(super) fn distance_um(&self, a: &CellRod, b: &CellRod) -> f64 {
        let dx = a.x_um - b.x_um;
        (dx - (dx / self.period_um).round() * self.period_um).hypot(a.depth_um - b.depth_um)
    }

    fn check_overlap(&self) -> Result<()> {
        let slack = TOUCHING_UM + 1e-9 * self.period_um;
        for (index, rod) in self.rods.iter().enumerate() {
            let place = |error: Error| error.at(format!("rod {index}"));
            if 2.0 * rod.radius_um() > self.period_um + slack {
                return Err(place(Error::input(format!(
                    "it is {} µm wide, wider than the period of {} µm, so it overlaps itself; make it smaller",
                    2.0 * rod.radius_um(),
                    self.period_um
                ))));
            }
            for (before, other) in self.rods[..index].iter().enumerate() {
                let overlap = rod.radius_um() + other.radius_um() - self.distance_um(rod, other);
                if overlap > slack {
                    return Err(place(Error::input(format!(
                        "it overlaps rod {before} by {overlap:.5} µm; move them apart or make them smaller"
                    ))));
                }
            }
        }
        Ok(())
    }
}

impl CellRod {
    /// Radius of the outermost circle, µm.
    pub(super) fn radius_um(&self) -> f64 {
        self.shells[0].diameter_um * 0.5
    }

    /// Refuses a rod that has no meaning or sticks out of the surface.
    fn check(&self) -> Result<()> {
        positive("depth", self.depth_um)?;
        if !self.x_um.is_finite() || self.shells.is_empty() {
            return Err(Error::input("it needs a finite position and at least one shell"));
        }
        let mut outer = f64::INFINITY;
        for shell in &self.shells {
            positive("diameter", shell.diameter_um)?;
            passive("shell", shell.eps)?;
            if shell.diameter_um >= outer {
                return Err(Error::input(format!(
                    "its shells must be given outermost first, but {} follows {outer}",
                    shell.diameter_um
                )));
            }
            outer = shell.diameter_um;
        }
        if self.radius_um() >= self.depth_um {
            return Err(Error::input(format!(
                "its radius {} µm reaches the surface from a depth of {} µm; bury it deeper",
                self.radius_um(),
                self.depth_um
            )));
        }
        Ok(())
    }
}

impl Incidence {
    /// Refuses what is no wave that comes down on `surroundings`, for every solver alike.
    pub(super) fn check(&self, surroundings: &Surroundings) -> Result<()> {
        check_wavelength(surroundings, self.wavelength_nm)?;
        check_angle("theta", self.theta_i)?;
        check_angle("phi", self.phi_i)
    }
}

/// Refuses wavelengths (nm) that are none or too short for the period.
pub(super) fn check_wavelength(surroundings: &Surroundings, wavelength_nm: f64) -> Result<()> {
    positive("wavelength", wavelength_nm)?;
    surroundings.check_orders(wavelength_nm)
}

/// Refuses angles (rad) at or past grazing.
pub(super) fn check_angle(name: &str, angle: f64) -> Result<()> {
    if angle.abs() < std::f64::consts::FRAC_PI_2 {
        return Ok(());
    }
    Err(Error::input(format!(
        "{name} is {}°, at or past grazing; give an angle between -90 and 90",
        angle.to_degrees()
    )))
}

/// Refuses all but positive finite numbers.
pub(super) fn positive(name: &str, value: f64) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::input(format!("the {name} is {value}, but it must be a positive number")))
}

/// Refuses media that are not finite, amplify, or have ε = 0.
pub(super) fn passive(name: &str, eps: Complex64) -> Result<()> {
    if eps.is_finite() && eps.im >= 0.0 && eps.norm() > LEAST_EPS {
        return Ok(());
    }
    Err(Error::input(format!(
        "the {name}'s relative permittivity is {eps}, but it must be finite, not 0, and have an imaginary part of at least 0"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::crystal::cells::{keratin, magpie, mallard};
    use crate::solve::crystal::{CrystalSolver, Fdtd, Multipole, Rcwa};

    fn refusal<T: std::fmt::Debug>(result: Result<T>) -> String {
        let error = result.unwrap_err();
        assert!(error.is_input(), "{error}");
        error.to_string()
    }

    #[test]
    fn cells_without_a_meaning_are_refused_once_for_all_solvers() {
        let host = keratin(500.0);
        let with = |change: &dyn Fn(&mut Vec<CellRod>)| {
            let mut rods = mallard(500.0).rods;
            change(&mut rods);
            refusal(Cell::from_rods(mallard(500.0).surroundings(), rods))
        };
        let amplifying = Complex64::new(2.0, -0.1);
        assert!(refusal(Surroundings::new(0.0, 1.0, host)).contains("the period is 0"));
        assert!(refusal(Surroundings::new(0.2, f64::NAN, host)).contains("incidence medium is NaN"));
        assert!(refusal(Surroundings::new(0.2, 1.0, amplifying)).contains("host's relative permittivity"));
        assert!(refusal(Surroundings::new(0.2, 1.0, Complex64::ZERO)).contains("not 0"));
        assert!(with(&|rods| rods[0].shells[0].eps = amplifying).contains("rod 0: the shell's"));
        assert!(with(&|rods| rods[1].depth_um = 0.05).contains("rod 1: its radius 0.065"));
        assert!(with(&|rods| rods[1].depth_um = -0.05).contains("the depth is -0.05"));
        assert!(with(&|rods| rods[2].x_um = f64::INFINITY).contains("finite position"));
        assert!(with(&|rods| rods[2].shells.clear()).contains("at least one shell"));
        assert!(
            with(&|rods| rods[2].depth_um = rods[0].depth_um).contains("rod 2: it overlaps rod 0 by 0.13")
        );
        assert!(with(&|rods| rods[5].shells[0].diameter_um = 0.3).contains("wider than the period"));
        let inside_out = |rods: &mut Vec<CellRod>| {
            let wider = Shell { diameter_um: 0.14, eps: host };
            rods[0].shells.push(wider);
        };
        assert!(with(&inside_out).contains("outermost first"));
        // Rods may touch, with the overlap that lattices may have.
        let mut touching = magpie(500.0);
        touching.rods[0].shells[0].diameter_um = 0.18 + 0.5 * TOUCHING_UM;
        Cell::from_rods(touching.surroundings(), touching.rods).unwrap();
    }

    #[test]
    fn every_solver_refuses_the_same_waves_with_the_same_words() {
        let solvers: [&dyn CrystalSolver; 3] = [&Multipole::default(), &Rcwa::default(), &Fdtd::default()];
        let cell = mallard(500.0);
        let right = std::f64::consts::FRAC_PI_2;
        for (wavelength_nm, theta_i, phi_i, said) in [
            (f64::NAN, 0.0, 0.0, "the wavelength is NaN"),
            (-500.0, 0.0, 0.0, "the wavelength is -500"),
            (1.0, 0.0, 0.0, "orders at 1 nm, over 300"),
            (500.0, right, 0.0, "theta is 90°, at or past grazing"),
            (500.0, 0.0, -right, "phi is -90°, at or past grazing"),
            (500.0, 0.0, f64::NAN, "phi is NaN°"),
        ] {
            let wave = Incidence { wavelength_nm, theta_i, phi_i };
            let texts = solvers.map(|solver| refusal(solver.respond(&cell, &wave)));
            assert!(texts[0].contains(said), "{texts:?}");
            assert!(texts.iter().all(|text| *text == texts[0]), "{texts:?}");
        }
    }
}
