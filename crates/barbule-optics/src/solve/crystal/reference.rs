//! Comparison with kept values of cylinder multipoles, which share no code with these solvers.

use super::cells::{magpie, mallard, peafowl};
use super::{Cell, Incidence, Response};
use crate::Complex64;

/// A kept case.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) cell: Cell,
    pub(crate) incidence: Incidence,
    /// m and J of each order.
    pub(crate) orders: Vec<(i32, [[Complex64; 2]; 2])>,
    pub(crate) reflected: Vec<[f64; 2]>,
    pub(crate) transmitted: [f64; 2],
    pub(crate) absorbed: [f64; 2],
}

/// All kept cases.
pub(crate) fn cases() -> Vec<Case> {
    let text = include_str!("../../../tests/data/crystals.json");
    let values: serde_json::Value = serde_json::from_str(text).expect("JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let pair = |value: &serde_json::Value| [number(&value[0]), number(&value[1])];
    let list = values["cases"].as_array().expect("a list");
    list.iter()
        .map(|case| {
            let name = case["cell"].as_str().expect("a name").to_owned();
            let wavelength_nm = number(&case["wavelength_nm"]);
            let cell = match name.as_str() {
                "mallard" => mallard(wavelength_nm),
                "magpie" => magpie(wavelength_nm),
                _ => peafowl(wavelength_nm),
            };
            let incidence = Incidence {
                wavelength_nm,
                theta_i: number(&case["theta_i_rad"]),
                phi_i: number(&case["phi_i_rad"]),
            };
            let orders = case["orders"].as_array().expect("orders");
            let jones = |order: &serde_json::Value| {
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| {
                        let [re, im] = pair(&order["J"][i][j]);
                        Complex64::new(re, im)
                    })
                })
            };
            Case {
                name,
                cell,
                incidence,
                orders: orders.iter().map(|o| (number(&o["m"]) as i32, jones(o))).collect(),
                reflected: orders.iter().map(|o| pair(&o["R"])).collect(),
                transmitted: pair(&case["T"]),
                absorbed: pair(&case["A"]),
            }
        })
        .collect()
}

/// Largest differences of a response from a kept one: of J, and of R, T and A.
pub(crate) fn differences(case: &Case, response: &Response) -> (f64, f64) {
    assert_eq!(case.orders.len(), response.orders.len(), "{} {:?}", case.name, case.incidence);
    let (mut amplitude, mut power) = (0.0_f64, 0.0_f64);
    for ((m, jones), (order, reflected)) in
        case.orders.iter().zip(response.orders.iter().zip(&case.reflected))
    {
        assert_eq!(*m, order.m);
        let scale = order.phi_o.cos() / case.incidence.phi_i.cos();
        for q in 0..2 {
            let column = [order.jones[0][q], order.jones[1][q]];
            power = power.max((scale * (column[0].norm_sqr() + column[1].norm_sqr()) - reflected[q]).abs());
            amplitude = amplitude.max((column[0] - jones[0][q]).norm()).max((column[1] - jones[1][q]).norm());
        }
    }
    for q in 0..2 {
        power = power.max((response.transmitted[q] - case.transmitted[q]).abs());
        power = power.max((response.absorbed[q] - case.absorbed[q]).abs());
    }
    (amplitude, power)
}
