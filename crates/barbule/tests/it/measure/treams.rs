//! What the independent program `treams` says of crystals (`scripts/reference-crystals.py`): shared by the tests that hold
//! the solvers against it and the program that prints the differences.

use std::collections::BTreeMap;

use barbule::Complex64;
use barbule::solve::crystal::{
    Cell, CellRod, CrystalResponse, CrystalSolver, Incidence, Shell, Surroundings,
};
use serde_json::Value;

/// A cell, a wave and what treams says of it.
pub(crate) struct Case {
    pub(crate) cell_name: String,
    pub(crate) cell: Cell,
    pub(crate) incidence: Incidence,
    /// m and J of each propagating order, m ascending.
    orders: Vec<(i32, [[Complex64; 2]; 2])>,
    transmitted: [f64; 2],
    /// The largest change of any J or T from treams' smaller expansions.
    pub(crate) error: f64,
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn complex(value: &Value) -> Complex64 {
    Complex64::new(number(&value[0]), number(&value[1]))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

/// All cases of the stored file.
pub(crate) fn cases() -> Vec<Case> {
    let document: Value = serde_json::from_str(include_str!("../data/treams.json")).unwrap();
    list(&document["cases"]).iter().map(|case| read(case, &document["cells"])).collect()
}

fn read(case: &Value, cells: &Value) -> Case {
    let name = case["cell"].as_str().unwrap();
    let eps = |medium: &Value| match medium.as_str().unwrap() {
        "air" => Complex64::ONE,
        medium => complex(&case[medium]),
    };
    let shell = |shell: &Value| Shell { diameter_um: number(&shell[0]), eps: eps(&shell[1]) };
    let rod = |rod: &Value| CellRod {
        x_um: number(&rod["x_um"]),
        depth_um: number(&rod["depth_um"]),
        shells: list(&rod["shells"]).iter().map(shell).collect(),
    };
    let around =
        Surroundings::new(number(&cells[name]["period_um"]), 1.0, complex(&case["keratin"])).unwrap();
    let cell = Cell::from_rods(around, list(&cells[name]["rods"]).iter().map(rod).collect()).unwrap();
    let jones = |order: &Value| [0, 1].map(|out| [0, 1].map(|q| complex(&order["J"][out][q])));
    let orders = list(&case["orders"]).iter().map(|order| (number(&order["m"]) as i32, jones(order)));
    Case {
        cell_name: name.to_owned(),
        cell,
        incidence: Incidence {
            wavelength_nm: number(&case["wavelength_nm"]),
            theta_i: number(&case["theta_deg"]).to_radians(),
            phi_i: number(&case["phi_deg"]).to_radians(),
        },
        orders: orders.collect(),
        transmitted: [0, 1].map(|q| number(&case["transmitted"][q])),
        error: number(&case["error"]),
    }
}

impl Case {
    /// The largest difference of any element of any J, and of T and A, which is what treams leaves of 1.
    pub(crate) fn difference(&self, response: &CrystalResponse) -> f64 {
        assert_eq!(response.orders.len(), self.orders.len(), "{} {:?}", self.cell_name, self.incidence);
        let mut largest = 0.0_f64;
        let mut absorbed = self.transmitted.map(|transmitted| 1.0 - transmitted);
        for (order, (m, jones)) in response.orders.iter().zip(&self.orders) {
            assert_eq!(order.m, *m);
            let scale = order.phi_o.cos() / self.incidence.phi_i.cos();
            for (a, b) in order.jones.as_flattened().iter().zip(jones.as_flattened()) {
                largest = largest.max((a - b).norm());
            }
            for (q, absorbed) in absorbed.iter_mut().enumerate() {
                *absorbed -= scale * (jones[0][q].norm_sqr() + jones[1][q].norm_sqr());
            }
        }
        let [passed, taken] = [(response.transmitted, self.transmitted), (response.absorbed, absorbed)]
            .map(|(a, b)| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()));
        largest = largest.max(passed).max(taken);
        largest
    }
}

/// The largest difference by cell of a solver at the cases that are chosen.
pub(crate) fn largest(solver: &dyn CrystalSolver, chosen: impl Fn(&Case) -> bool) -> BTreeMap<String, f64> {
    let mut found = BTreeMap::new();
    for case in cases().into_iter().filter(chosen) {
        let difference = case.difference(&solver.respond(&case.cell, &case.incidence).unwrap());
        let most = found.entry(case.cell_name).or_insert(0.0_f64);
        *most = most.max(difference);
    }
    found
}

/// Whether a case is one of those that the slow solvers take.
pub(crate) fn is_at_450_nm(case: &Case) -> bool {
    case.incidence.wavelength_nm == 450.0
}
