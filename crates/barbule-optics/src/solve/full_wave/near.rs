//! Integrals over panels that are near to a target: kernels vary there faster than a panel's own rule follows.

use rayon::prelude::*;

use super::kernel::{Block, COMPONENTS, Kernel};
use super::mesh::{MOST_NODES, Mesh, Panel};
use super::shape::{Chord, Point};
use crate::Complex64;
use crate::math::quadrature::gauss_legendre;

/// Up to which distance, in lengths of a panel with so many nodes, its own rule does not do.
const NEAR: [f64; MOST_NODES + 1] = [0.0, 6.0, 4.0, 2.5, 1.8, 1.5, 1.3, 1.2, 1.0];

/// Nodes of the rule of one part of a panel.
const PART_NODES: usize = 10;

/// Nodes of the rule on either side of a target on the panel, and the power by which they crowd to it: with it, logarithms
/// are integrated to 1e-12.
const SIDE_NODES: usize = 14;
const CROWDING: i32 = 5;

/// Parts that a panel is halved into towards a target at most: it then is 1e-9 of its length away.
const MOST_HALVINGS: usize = 30;

/// Blocks between targets and the nodes of panels near to them.
#[derive(Debug, Clone)]
pub(super) struct Near {
    /// Of each target, its near panels by number, each with a block for each of its nodes.
    targets: Vec<Vec<(u32, Vec<Block>)>>,
}

impl Near {
    pub(super) fn new(mesh: &Mesh, kernel: &Kernel) -> Self {
        let quadrature = Quadrature::new();
        let finder = Finder::new(mesh);
        let targets = (0..mesh.nodes.len())
            .into_par_iter()
            .map(|target| {
                let node = &mesh.nodes[target];
                let mut panels = finder.panels(mesh, node.point.at);
                panels.retain(|&p| kernel.are_coupled(node.boundary, mesh.panels[p].boundary));
                panels
                    .into_iter()
                    .map(|p| (p as u32, quadrature.blocks(mesh, kernel, target, &mesh.panels[p])))
                    .collect()
            })
            .collect();
        Self { targets }
    }

    /// The near panels of a target, rising, with their blocks.
    pub(super) fn of(&self, target: usize) -> &[(u32, Vec<Block>)] {
        &self.targets[target]
    }
}

/// Panels in the order of their places across.
struct Finder {
    by_x: Vec<(f64, usize)>,
    reach_um: f64,
}

impl Finder {
    fn new(mesh: &Mesh) -> Self {
        let mut by_x: Vec<(f64, usize)> =
            mesh.panels.iter().enumerate().map(|(p, panel)| (panel.shape.point(0.0).at[0], p)).collect();
        by_x.sort_by(|a, b| a.0.total_cmp(&b.0));
        let reach_um =
            mesh.panels.iter().map(|panel| (0.5 + NEAR[panel.nodes]) * panel.length_um).fold(0.0, f64::max);
        Self { by_x, reach_um }
    }

    fn panels(&self, mesh: &Mesh, at: [f64; 2]) -> Vec<usize> {
        let first = self.by_x.partition_point(|&(x, _)| x < at[0] - self.reach_um);
        let around = self.by_x[first..].iter().take_while(|&&(x, _)| x <= at[0] + self.reach_um);
        let mut found: Vec<usize> = around
            .map(|&(_, p)| p)
            .filter(|&p| {
                let panel = &mesh.panels[p];
                let middle = panel.shape.point(0.0).at;
                let near = NEAR[panel.nodes] * panel.length_um;
                let apart = libm::hypot(middle[0] - at[0], middle[1] - at[1]);
                apart < near + 0.5 * panel.length_um && panel.shape.nearest(at).1 < near
            })
            .collect();
        found.sort_unstable();
        found
    }
}

/// Rules and what interpolation needs.
struct Quadrature {
    part: Vec<(f64, f64)>,
    side: Vec<(f64, f64)>,
    /// Nodes on \[−1, 1\] and barycentric weights, by the number of nodes.
    lagrange: Vec<Vec<(f64, f64)>>,
}

impl Quadrature {
    fn new() -> Self {
        let lagrange = (0..=MOST_NODES).map(|count| {
            let nodes: Vec<f64> = gauss_legendre(count).iter().map(|(t, _)| 2.0 * t - 1.0).collect();
            let weight = |i: usize| -> f64 {
                let others = nodes.iter().enumerate().filter(|&(k, _)| k != i);
                others.map(|(_, x)| nodes[i] - x).product::<f64>().recip()
            };
            nodes.iter().enumerate().map(|(i, &x)| (x, weight(i))).collect()
        });
        let lagrange = lagrange.collect();
        Self { part: gauss_legendre(PART_NODES), side: gauss_legendre(SIDE_NODES), lagrange }
    }

    /// ∫ kernel × Lagrange polynomial over a panel, for each of its nodes.
    fn blocks(&self, mesh: &Mesh, kernel: &Kernel, target: usize, panel: &Panel) -> Vec<Block> {
        let node = &mesh.nodes[target];
        let mut sum = Sum {
            kernel,
            target: node.point,
            boundary: node.boundary,
            panel,
            lagrange: &self.lagrange[panel.nodes],
            blocks: vec![[[Complex64::ZERO; COMPONENTS]; COMPONENTS]; panel.nodes],
        };
        if (panel.first..panel.first + panel.nodes).contains(&target) {
            let s0 = self.lagrange[panel.nodes][target - panel.first].0;
            for end in [-1.0, 1.0] {
                for &(t, weight) in &self.side {
                    let crowded = t.powi(CROWDING);
                    let stretch = f64::from(CROWDING) * t.powi(CROWDING - 1) * f64::abs(end - s0);
                    let s: f64 = s0 + (end - s0) * crowded;
                    sum.add(s, weight * stretch, &panel.shape.chord(s0, s));
                }
            }
            return sum.blocks;
        }
        let (s0, distance) = panel.shape.nearest(node.point.at);
        for end in [-1.0, 1.0] {
            let span: f64 = end - s0;
            let (mut from, mut halvings) = (1.0, 0);
            // Halves towards the nearest point, until they are as short as the target is far.
            while from * span.abs() * 0.5 * panel.length_um > distance && halvings < MOST_HALVINGS {
                self.part(&mut sum, s0 + 0.5 * from * span, s0 + from * span);
                from *= 0.5;
                halvings += 1;
            }
            if span != 0.0 {
                self.part(&mut sum, s0, s0 + from * span);
            }
        }
        sum.blocks
    }

    fn part(&self, sum: &mut Sum<'_>, from: f64, to: f64) {
        for &(t, weight) in &self.part {
            let s = from + t * (to - from);
            let chord = Chord::between(&sum.target, &sum.panel.shape.point(s));
            sum.add(s, weight * (to - from).abs(), &chord);
        }
    }
}

/// Blocks under construction.
struct Sum<'a> {
    kernel: &'a Kernel,
    target: Point,
    boundary: usize,
    panel: &'a Panel,
    lagrange: &'a [(f64, f64)],
    blocks: Vec<Block>,
}

impl Sum<'_> {
    /// Adds the kernel at parameter `s`, which stands for `weight` of \[−1, 1\].
    fn add(&mut self, s: f64, weight: f64, chord: &Chord) {
        let source = self.panel.shape.point(s);
        let Some(block) =
            self.kernel.block((self.boundary, &self.target), (self.panel.boundary, &source), chord)
        else {
            return;
        };
        // Barycentric interpolation; a point on a node takes that node alone.
        let exact = self.lagrange.iter().position(|&(x, _)| x == s);
        let total: f64 = self.lagrange.iter().map(|&(x, w)| w / (s - x)).sum();
        // Fields times the length of s are smooth even next to corners.
        for (i, (sum, &(x, w))) in self.blocks.iter_mut().zip(self.lagrange).enumerate() {
            let part = match exact {
                Some(node) => f64::from(u8::from(node == i)),
                None => w / (s - x) / total,
            };
            let length = weight * self.panel.shape.speed_um(x);
            for (sum, row) in sum.iter_mut().zip(&block) {
                for (sum, value) in sum.iter_mut().zip(row) {
                    *sum += length * part * value;
                }
            }
        }
    }
}
