//! The equations of a section at one wavelength and θ_i, element by element.

use rayon::prelude::*;

use super::incidence::Incidence;
use super::kernel::{Block, Kernel};

use super::mesh::Mesh;
use super::near::Near;
use super::outgoing::Fields;
use super::shape::Chord;
use crate::math::dense::Dense;
use crate::math::hierarchical::Blocks;
use crate::progress::Progress;
use crate::{Complex64, Error, Result};

/// Which unknowns belong together: at θ_i = 0 the field along the barbule is E_y with H̃_t or H̃_y with E_t, never both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coupled {
    /// E_y and H̃_t.
    ElectricAlong,
    /// H̃_y and E_t.
    MagneticAlong,
    /// All four.
    All,
}

impl Coupled {
    /// The components, by their places in blocks.
    pub(super) fn components(self) -> &'static [usize] {
        match self {
            Self::ElectricAlong => &[0, 1],
            Self::MagneticAlong => &[2, 3],
            Self::All => &[0, 1, 2, 3],
        }
    }

    /// Fields at all nodes from these unknowns.
    pub(super) fn fields(self, unknowns: &[Complex64]) -> Fields {
        let components = self.components();
        let field = |values: &[Complex64]| {
            let mut field = [Complex64::ZERO; 4];
            for (value, &component) in values.iter().zip(components) {
                field[component] = *value;
            }
            field
        };
        unknowns.chunks_exact(components.len()).map(field).collect()
    }
}

/// The equations of some components, weighted for sums of squares to be integrals over boundaries.
pub(super) struct Weighted<'a> {
    pub(super) operator: &'a Operator,
    pub(super) coupled: Coupled,
}

impl Weighted<'_> {
    /// √ of each unknown's part of a boundary's length: unknowns times these are unknowns of the weighted equations.
    pub(super) fn roots(&self) -> Vec<f64> {
        let components = self.coupled.components().len();
        let nodes = self.operator.mesh.nodes.iter();
        nodes.flat_map(|node| std::iter::repeat_n(node.weight_um.sqrt(), components)).collect()
    }
}

impl Weighted<'_> {
    /// How far A x is from b at most at so many nodes spread over all, against the largest b of each column.
    pub(super) fn residual(&self, x: &Dense, b: &Dense, samples: usize) -> f64 {
        let components = self.components();
        let nodes = self.operator.mesh.nodes.len();
        let step = (nodes / samples).max(1);
        let largest = |k: usize| b.column(k).iter().map(|value| value.norm()).fold(0.0, f64::max);
        let largest: Vec<f64> = (0..b.columns()).map(largest).collect();
        let targets: Vec<usize> = (0..nodes).step_by(step).collect();
        let errors = targets.par_iter().map(|&target| {
            let mut sums = vec![Complex64::ZERO; components * b.columns()];
            let mut block = vec![Complex64::ZERO; components * components];
            for source in 0..nodes {
                if !self.block(target, source, &mut block) {
                    continue;
                }
                for (k, sums) in sums.chunks_exact_mut(components).enumerate() {
                    let x = &x.column(k)[source * components..][..components];
                    for (sum, row) in sums.iter_mut().zip(block.chunks_exact(components)) {
                        *sum += row.iter().zip(x).map(|(a, x)| a * x).sum::<Complex64>();
                    }
                }
            }
            let mut worst = 0.0_f64;
            for (k, sums) in sums.chunks_exact(components).enumerate() {
                let b = &b.column(k)[target * components..][..components];
                let error = sums.iter().zip(b).map(|(sum, b)| (sum - b).norm()).fold(0.0, f64::max);
                worst = worst.max(error / largest[k]);
            }
            worst
        });
        errors.collect::<Vec<_>>().into_iter().fold(0.0, f64::max)
    }
}

impl Blocks for Weighted<'_> {
    fn components(&self) -> usize {
        self.coupled.components().len()
    }

    fn places(&self) -> Vec<[f64; 2]> {
        self.operator.mesh.nodes.iter().map(|node| node.point.at).collect()
    }

    fn group(&self, node: usize) -> usize {
        self.operator.mesh.nodes[node].boundary
    }

    fn block(&self, target: usize, source: usize, block: &mut [Complex64]) -> bool {
        let Some(all) = self.operator.block(target, source) else { return false };
        let nodes = &self.operator.mesh.nodes;
        let weight = (nodes[target].weight_um / nodes[source].weight_um).sqrt();
        let components = self.coupled.components();
        for (row, &equation) in block.chunks_exact_mut(components.len()).zip(components) {
            for (value, &unknown) in row.iter_mut().zip(components) {
                *value = weight * all[equation][unknown];
            }
        }
        true
    }
}

/// Müller's equations over a mesh: unknowns are the fields at its nodes, node by node.
pub(super) struct Operator {
    pub(super) mesh: Mesh,
    pub(super) kernel: Kernel,
    near: Near,
    /// The panel of each node.
    panel_of: Vec<u32>,
}

impl Operator {
    pub(super) fn new(mesh: Mesh, kernel: Kernel) -> Self {
        let near = Near::new(&mesh, &kernel);
        let panels = mesh.panels.iter().enumerate();
        let panel_of = panels.flat_map(|(p, panel)| std::iter::repeat_n(p as u32, panel.nodes)).collect();
        Self { mesh, kernel, near, panel_of }
    }

    /// The block of a target and a source node; `None` where no region touches both.
    pub(super) fn block(&self, target: usize, source: usize) -> Option<Block> {
        let panel = self.panel_of[source];
        let near = self.near.of(target);
        let mut block = match near.binary_search_by_key(&panel, |(p, _)| *p) {
            Ok(at) => near[at].1[source - self.mesh.panels[panel as usize].first],
            Err(_) => self.far(target, source)?,
        };
        if target == source {
            // Fields at a boundary: half from either side, with the weights of the equations.
            for (component, row) in block.iter_mut().enumerate() {
                row[component] += 1.0;
            }
        }
        Some(block)
    }

    fn far(&self, target: usize, source: usize) -> Option<Block> {
        let (a, b) = (&self.mesh.nodes[target], &self.mesh.nodes[source]);
        let chord = Chord::between(&a.point, &b.point);
        let mut block = self.kernel.block((a.boundary, &a.point), (b.boundary, &b.point), &chord)?;
        for value in block.iter_mut().flatten() {
            *value *= b.weight_um;
        }
        Some(block)
    }

    /// All of them as a matrix of `nodes × components` unknowns, node by node.
    ///
    /// # Errors
    /// The user cancelled.
    pub(super) fn matrix(&self, coupled: Coupled, progress: &dyn Progress) -> Result<Dense> {
        let components = coupled.components();
        let nodes = self.mesh.nodes.len();
        let size = nodes * components.len();
        let mut matrix = Dense::zeros(size, size);
        let columns = matrix.elements_mut().par_chunks_mut(size * components.len());
        columns.enumerate().try_for_each(|(source, columns)| {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            for target in 0..nodes {
                let Some(block) = self.block(target, source) else { continue };
                self.store(&block, components, columns, target, size);
            }
            progress.advance(1);
            Ok(())
        })?;
        Ok(matrix)
    }

    fn store(
        &self,
        block: &Block,
        components: &[usize],
        columns: &mut [Complex64],
        target: usize,
        size: usize,
    ) {
        for (column, &unknown) in columns.chunks_exact_mut(size).zip(components) {
            let place = &mut column[target * components.len()..][..components.len()];
            for (element, &equation) in place.iter_mut().zip(components) {
                *element = block[equation][unknown];
            }
        }
    }

    /// The light in the equations of the outside's boundaries.
    pub(super) fn right_side(&self, coupled: Coupled, light: &Incidence, right: &mut [Complex64]) {
        let components = coupled.components();
        right.par_chunks_mut(components.len()).zip(&self.mesh.nodes).for_each(|(place, node)| {
            if self.mesh.boundaries[node.boundary].outside != 0 {
                return;
            }
            // ε of the outside is 1.
            let over = self.kernel.mean_epsilon(node.boundary).inv();
            let weights = [over, Complex64::ONE, Complex64::ONE, over];
            let field = light.at(&node.point);
            for (value, &component) in place.iter_mut().zip(components) {
                *value = field[component] * weights[component];
            }
        });
    }
}
