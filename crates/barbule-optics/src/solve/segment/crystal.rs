//! Local reflection by a photonic crystal whose rods follow the top along y.
//!
//! In the frame (t, y′, n) of a point, with y′ along the rods and n the outward normal, light has a longitudinal angle θ′ and
//! an azimuth φ′ of its own, and the crystal is the ideal flat one. Its orders are solved at a few θ′ over the range that the
//! top's slopes along y give, and interpolated between them.

use glam::DVec3;
use num_complex::Complex64;

use super::{COMPONENTS, Currents, Incidence, Place};
use crate::Result;
use crate::progress::Progress;
use crate::scattering::directions::{e1, e2};
use crate::scattering::orders::JONES;
use crate::solve::surface::{CrystalOrders, series};
use crate::structure::{CrystalLayer, Line, Sampled, Segment, SegmentGrid};

/// Nodes over θ′, where it varies.
const NODES: usize = 5;

/// Slopes along y beyond so many standard deviations are taken at the end of the range.
const STEEPEST: f64 = 4.5;

pub(super) struct Crystal<'a> {
    layer: &'a CrystalLayer,
    grid: SegmentGrid,
    /// Arc length of the section's top at each of its points, and at x = 0 plus the lattice's offset.
    arc_um: Vec<f64>,
    origin_um: f64,
    segment: &'a Segment,
    /// sinθ′ of the nodes, and orders there.
    nodes: Vec<(f64, CrystalOrders<f64>)>,
}

/// Directions of a place's own frame.
struct Frame {
    tangent: DVec3,
    axis: DVec3,
    normal: DVec3,
}

impl Frame {
    fn new(normal: DVec3) -> Self {
        // The tangent of the line along y that the surface holds.
        let axis = DVec3::new(0.0, normal.z, -normal.y).normalize();
        Self { tangent: axis.cross(normal), axis, normal }
    }

    fn local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.tangent), v.dot(self.axis), v.dot(self.normal))
    }
}

impl<'a> Crystal<'a> {
    pub(super) fn new(
        segment: &'a Segment,
        layer: &'a CrystalLayer,
        sampled: &Sampled<'_>,
        wavelength_nm: f64,
        incidence: &Incidence,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let top = segment.section.top();
        let arc_um = top.arc_um();
        let roughness = segment.roughness;
        let slope = [0, 1].map(|axis| STEEPEST * roughness.amplitude_um / roughness.correlation_um[axis]);
        let sin = incidence.omega.y;
        // ω_i·y′ with a slope of ±slope.
        let reach = slope[1] * (1.0 - sin * sin).max(0.0).sqrt();
        let (low, high) = ((sin - reach).max(-0.9995), (sin + reach).min(0.9995));
        let count = if reach > 0.0 { NODES } else { 1 };
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut line = Line::default();
        for column in 0..sampled.grid.cells[0] {
            sampled.line(column, &mut line);
            let turn = line.slope.atan();
            least = least.min(turn);
            most = most.max(turn);
        }
        let phi_i = incidence.omega.x.atan2(incidence.omega.z);
        // A slope along y turns azimuths too, in the second order.
        let spread = slope[0].atan() + 2.0 * slope[1] * slope[1];
        let phi = [phi_i + least - spread, phi_i + most + spread];
        let depth_um = layer.lattice.bottom_um();
        let node = |index: usize| -> Result<(f64, CrystalOrders<f64>)> {
            let turn = std::f64::consts::PI * (index as f64 + 0.5) / count as f64;
            let at = f64::midpoint(low, high) + 0.5 * (high - low) * if count > 1 { turn.cos() } else { 0.0 };
            let series = series(&layer.lattice, wavelength_nm, at.asin(), phi, progress)?;
            Ok((at, CrystalOrders::new(&series, at.asin(), depth_um)))
        };
        Ok(Self {
            layer,
            grid: sampled.grid,
            origin_um: top.arc_at_zero(&arc_um) + layer.offset_um,
            arc_um,
            segment,
            nodes: (0..count).map(node).collect::<Result<_>>()?,
        })
    }

    /// Lagrange's weights of the nodes.
    fn weights(&self, sin_theta: f64) -> [f64; NODES] {
        let mut weights = [0.0; NODES];
        for (i, (at, _)) in self.nodes.iter().enumerate() {
            let others = self.nodes.iter().enumerate().filter(|(j, _)| *j != i);
            weights[i] = others.map(|(_, (other, _))| (sin_theta - other) / (at - other)).product();
        }
        weights
    }

    /// The part of its period at which a line lies in the lattice, in turns.
    fn turns(&self, x_um: f64) -> f64 {
        let top = self.segment.section.top();
        let right = top.x_um.partition_point(|&x| x <= x_um).clamp(1, top.x_um.len() - 1);
        let t = (x_um - top.x_um[right - 1]) / (top.x_um[right] - top.x_um[right - 1]);
        let arc = self.arc_um[right - 1] + t * (self.arc_um[right] - self.arc_um[right - 1]);
        ((arc - self.origin_um) / self.layer.lattice.period_um).rem_euclid(1.0)
    }

    pub(super) fn currents(&self, incidence: &Incidence, line: &Line, out: &mut Currents) -> f64 {
        let area_um2 = self.grid.step_um[0] * self.grid.step_um[1];
        let regularity = self.layer.regularity.as_ref().map_or(1.0, |regularity| regularity.at(line.x_um));
        let turns = self.turns(line.x_um);
        let mut power = 0.0;
        for component in out.iter_mut().flatten() {
            component.fill(Complex64::ZERO);
        }
        for row in 0..self.grid.cells[1] {
            let y_um = self.grid.centre_um(1, row);
            let Some(place) = Place::new(incidence, line, row, y_um, area_um2) else { continue };
            power += place.power(area_um2);
            self.reflect(incidence, &place, regularity, turns, &mut |q, currents| {
                for (component, value) in out[q].iter_mut().zip(currents) {
                    component[row] += value;
                }
            });
        }
        power
    }

    /// Calls `add` with the currents of each order for each incident polarization.
    fn reflect(
        &self,
        incidence: &Incidence,
        place: &Place,
        regularity: f64,
        turns: f64,
        add: &mut impl FnMut(usize, [Complex64; COMPONENTS]),
    ) {
        let frame = Frame::new(place.normal);
        let towards = frame.local(incidence.omega);
        let (theta, phi) = (towards.y.clamp(-1.0, 1.0).asin(), towards.x.atan2(towards.z));
        let (sin_theta, cos_theta) = theta.sin_cos();
        let (along_e1, along_e2) = (e1(theta, phi), e2(phi));
        let incident = incidence.electric.map(|electric| {
            let electric = frame.local(electric);
            [electric.dot(along_e1), electric.dot(along_e2)]
        });
        let weights = self.weights(sin_theta);
        for (weight, (_, orders)) in weights.iter().zip(&self.nodes) {
            orders.each(phi, |m, step, jones: [f64; JONES]| {
                let sin_o = (f64::from(m) * step - phi.sin()).clamp(-1.0, 1.0);
                let cos_o = (1.0 - sin_o * sin_o).sqrt();
                let lattice =
                    Complex64::from_polar(weight * regularity, std::f64::consts::TAU * f64::from(m) * turns);
                let wave = place.wave * lattice;
                let at = |element: usize| Complex64::new(jones[2 * element], jones[2 * element + 1]) * wave;
                for (q, [first, second]) in incident.into_iter().enumerate() {
                    let a = at(0) * first + at(1) * second;
                    let b = at(2) * first + at(3) * second;
                    let (j_t, j_y) = (-b * cos_theta, b * (sin_theta * sin_o) - a * cos_o);
                    let (m_t, m_y) = (a * cos_theta, -a * (sin_theta * sin_o) - b * cos_o);
                    let vector = |t: Complex64, y: Complex64, axis: usize| {
                        t * frame.tangent[axis] + y * frame.axis[axis]
                    };
                    add(
                        q,
                        std::array::from_fn(|c| match c {
                            0..3 => vector(j_t, j_y, c),
                            _ => vector(m_t, m_y, c - 3),
                        }),
                    );
                }
            });
        }
    }
}
