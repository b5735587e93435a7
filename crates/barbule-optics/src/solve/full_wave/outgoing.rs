//! What the fields on the boundaries send away, and what they carry into absorbing regions.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::DVec3;
use rayon::prelude::*;

use super::mesh::Mesh;
use crate::Complex64;
use crate::scattering::directions::{e1, e2, omega};

/// Azimuths that one task radiates to.
const TASK: usize = 16;

/// Fields at all nodes: E_y, H̃_t, H̃_y, E_t.
pub(super) type Fields = Vec<[Complex64; 4]>;

/// 𝓔₁ and 𝓔₂ of scattered fields for unit |E|, √µm, at each azimuth for each of `fields`: `[field][e₁, e₂][azimuth]`, from the
/// currents on the boundaries of the outside, by the fast simulation's formula.
pub(super) fn radiate(
    mesh: &Mesh,
    fields: &[Fields],
    (k, theta_i): (f64, f64),
    phi_o: &[f64],
) -> Vec<[Vec<Complex64>; 2]> {
    let kappa = k * theta_i.cos();
    let j = Complex64::i();
    let factor = j / 4.0 * (j * k) * (2.0 / (PI * kappa)).sqrt() * Complex64::from_polar(1.0, -FRAC_PI_4);
    let outer: Vec<usize> =
        (0..mesh.nodes.len()).filter(|&i| mesh.boundaries[mesh.nodes[i].boundary].outside == 0).collect();
    let at_azimuth = |&phi: &f64| -> Vec<[Complex64; 2]> {
        let (w_o, first, second) = (omega(-theta_i, phi), e1(-theta_i, phi), e2(phi));
        let (sin, cos) = libm::sincos(phi);
        let mut sums = vec![[Complex64::ZERO; 2]; fields.len()];
        for &i in &outer {
            let node = &mesh.nodes[i];
            let [x, z] = node.point.at;
            let (s, c) = libm::sincos(-kappa * (x * sin + z * cos));
            let kernel = Complex64::new(c, s) * node.weight_um;
            let tangent = DVec3::new(node.point.tangent[0], 0.0, node.point.tangent[1]);
            // (J − ω × M)·e = J·e − M·(e × ω).
            let parts = [first, second].map(|e| {
                let turned = e.cross(w_o);
                [e.dot(tangent), e.y, turned.dot(tangent), turned.y]
            });
            for (sum, field) in sums.iter_mut().zip(fields) {
                let [e_y, h_t, h_y, e_t] = field[i];
                // J = n × H̃ and M = −n × E.
                let (j_t, j_y, m_t, m_y) = (-h_y, h_t, e_y, -e_t);
                for (sum, [jt, jy, mt, my]) in sum.iter_mut().zip(parts) {
                    *sum += kernel * (j_t * jt + j_y * jy - m_t * mt - m_y * my);
                }
            }
        }
        sums.into_iter().map(|sum| sum.map(|value| factor * value)).collect()
    };
    let rows: Vec<Vec<[Complex64; 2]>> = phi_o.par_iter().with_min_len(TASK).map(at_azimuth).collect();
    (0..fields.len())
        .map(|f| [0, 1].map(|component| rows.iter().map(|row| row[f][component]).collect()))
        .collect()
}

/// The power that flows into absorbing regions, µm for unit |E|: −Re ∮ n·(E × H̃*) dl around each.
pub(super) fn absorbed_um(mesh: &Mesh, fields: &Fields) -> f64 {
    let absorbs = |region: usize| mesh.indices[region].im > 0.0;
    let flow = |(node, [e_y, h_t, h_y, e_t]): (&super::mesh::Node, &[Complex64; 4])| {
        let boundary = mesh.boundaries[node.boundary];
        let outward = (e_t * h_y.conj() - e_y * h_t.conj()).re * node.weight_um;
        let sides =
            f64::from(u8::from(absorbs(boundary.inside))) - f64::from(u8::from(absorbs(boundary.outside)));
        -sides * outward
    };
    mesh.nodes.iter().zip(fields).map(flow).sum()
}
