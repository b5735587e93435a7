//! Cells that tests of the solvers share.

use super::{Cell, CellRod, CrystalResponse, CrystalSolver, Incidence, Multipole, Shell, Surroundings};
use crate::Complex64;
use crate::material::Material;

/// ε of keratin at a wavelength, nm.
pub(crate) fn keratin(wavelength_nm: f64) -> Complex64 {
    permittivity(&Material::keratin(), wavelength_nm)
}

/// ε of melanin at a wavelength, nm.
pub(crate) fn melanin(wavelength_nm: f64) -> Complex64 {
    permittivity(&Material::melanin(), wavelength_nm)
}

fn permittivity(of: &Material, wavelength_nm: f64) -> Complex64 {
    let n = of.index(wavelength_nm).expect("an index");
    n * n
}

/// A rod of shells (diameter, ε), outermost first.
pub(crate) fn rod(x_um: f64, depth_um: f64, shells: &[(f64, Complex64)]) -> CellRod {
    let shells = shells.iter().map(|&(diameter_um, eps)| Shell { diameter_um, eps }).collect();
    CellRod { x_um, depth_um, shells }
}

/// Rods in keratin under air.
pub(crate) fn in_keratin(period_um: f64, wavelength_nm: f64, rods: Vec<CellRod>) -> Cell {
    let surroundings = Surroundings::new(period_um, 1.0, keratin(wavelength_nm)).expect("surroundings");
    Cell::from_rods(surroundings, rods).expect("a cell")
}

/// Mallard lime: solid rods in six rows, apart.
pub(crate) fn mallard(wavelength_nm: f64) -> Cell {
    let row =
        |i: usize| rod((i % 2) as f64 * 0.1, 0.345 + 0.18 * i as f64, &[(0.13, melanin(wavelength_nm))]);
    in_keratin(0.2, wavelength_nm, (0..6).map(row).collect())
}

/// Magpie violet: hollow rods in three rows, touching.
pub(crate) fn magpie(wavelength_nm: f64) -> Cell {
    let shells = [(0.18, melanin(wavelength_nm)), (0.09, Complex64::from(1.0))];
    let row = |i: usize| rod((i % 2) as f64 * 0.09, 0.22 + 0.15588 * i as f64, &shells);
    in_keratin(0.18, wavelength_nm, (0..3).map(row).collect())
}

/// Peafowl yellow: rows of rods with air channels between.
pub(crate) fn peafowl(wavelength_nm: f64) -> Cell {
    let solid = |i: usize| rod(0.0, 0.15 + 0.19 * i as f64, &[(0.12, melanin(wavelength_nm))]);
    let channel = |i: usize| rod(0.08, 0.245 + 0.19 * i as f64, &[(0.055, Complex64::from(1.0))]);
    in_keratin(0.16, wavelength_nm, (0..6).map(solid).chain((0..5).map(channel)).collect())
}

/// Points (λ in nm, θ_i, φ_i in degrees) at which the other solvers are compared with multipoles; two orders leave most
/// crystals from the sixth to the eighth.
const WAVES: [[f64; 3]; 9] = [
    [500.0, 0.0, 0.0],
    [450.0, 20.0, 30.0],
    [600.0, -35.0, 55.0],
    [400.0, 60.0, -40.0],
    [550.0, 10.0, 80.0],
    [330.0, 0.0, 60.0],
    [330.0, 15.0, -75.0],
    [305.0, 5.0, 70.0],
    [694.0, 45.0, 10.0],
];

/// A cell, a wave and what multipoles say, which share no code with the other solvers but the orders' numbers.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) cell: Cell,
    pub(crate) incidence: Incidence,
    exact: CrystalResponse,
}

/// All crystals at all points.
pub(crate) fn cases() -> Vec<Case> {
    let crystals = [("mallard", mallard as fn(f64) -> Cell), ("magpie", magpie), ("peafowl", peafowl)];
    let case = |name, make: fn(f64) -> Cell, [wavelength_nm, theta, phi]: [f64; 3]| {
        let incidence = Incidence { wavelength_nm, theta_i: theta.to_radians(), phi_i: phi.to_radians() };
        let cell = make(wavelength_nm);
        let exact = Multipole::default().respond(&cell, &incidence).expect("a response");
        Case { name, cell, incidence, exact }
    };
    crystals.into_iter().flat_map(|(name, make)| WAVES.map(|wave| case(name, make, wave))).collect()
}

impl Case {
    /// Largest differences of a response from the multipoles': of J, and of R, T and A.
    pub(crate) fn differences(&self, response: &CrystalResponse) -> (f64, f64) {
        let exact = &self.exact;
        assert_eq!(exact.orders.len(), response.orders.len(), "{} {:?}", self.name, self.incidence);
        let (mut amplitude, mut power) = (0.0_f64, response.distance(exact, self.incidence.phi_i));
        for (a, b) in exact.orders.iter().zip(&response.orders) {
            assert_eq!(a.m, b.m);
            for (a, b) in a.jones.as_flattened().iter().zip(b.jones.as_flattened()) {
                amplitude = amplitude.max((a - b).norm());
            }
        }
        for q in 0..2 {
            power = power.max((response.transmitted[q] - exact.transmitted[q]).abs());
            power = power.max((response.absorbed[q] - exact.absorbed[q]).abs());
        }
        (amplitude, power)
    }
}
