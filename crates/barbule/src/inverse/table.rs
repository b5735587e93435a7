//! Simulated spectra between sizes at which they are simulated: tensor products of Chebyshev polynomials in the sizes.

use super::{Model, Parameter};
use crate::Result;
use crate::math::chebyshev;
use crate::progress::{Part, Progress};

/// Makes spectra of sizes: the values at all samples of all readings.
pub(super) trait Simulator: Sync {
    /// What is simulated for these sizes, at every sample of every reading.
    fn simulate(&self, sizes: &[f64], progress: &dyn Progress) -> Result<Vec<f64>>;
}

/// Spectra as polynomials of the sizes in a box.
pub(super) struct Table {
    parameters: Vec<Parameter>,
    nodes: usize,
    /// `[term of the first size][term of the second] … [sample]`
    coefficients: Vec<f64>,
    samples: usize,
}

impl Table {
    /// Simulates `nodes` values of each size, all combinations, each a part of the work.
    ///
    /// # Errors
    /// As the simulation, or the user cancelled.
    pub(super) fn new<'p>(
        simulator: &dyn Simulator,
        parameters: Vec<Parameter>,
        nodes: usize,
        part: &dyn Fn() -> Part<'p>,
    ) -> Result<Self> {
        let at: Vec<f64> = chebyshev::nodes(nodes).collect();
        let count = nodes.pow(parameters.len() as u32);
        let mut values = Vec::new();
        for combination in 0..count {
            let mut rest = combination;
            let mut sizes = vec![0.0; parameters.len()];
            for (size, p) in sizes.iter_mut().zip(&parameters).rev() {
                *size = p.low + (p.high - p.low) * 0.5 * (at[rest % nodes] + 1.0);
                rest /= nodes;
            }
            values.extend(simulator.simulate(&sizes, &part())?);
        }
        let samples = values.len() / count;
        let mut row = values.len();
        for _ in &parameters {
            // Blocks of this size's nodes, one after the other for each combination of the sizes before it.
            let block = row;
            row /= nodes;
            values =
                values.chunks_exact(block).flat_map(|block| chebyshev::coefficients(block, row)).collect();
        }
        Ok(Self { parameters, nodes, coefficients: values, samples })
    }

    /// The polynomials T_k of a size and their derivatives by it.
    fn polynomials(&self, size: f64, p: &Parameter) -> [Vec<f64>; 2] {
        let half = 0.5 * (p.high - p.low);
        let x = (size - p.low) / half - 1.0;
        let mut first = vec![1.0, x];
        let mut second = vec![1.0, 2.0 * x];
        for k in 2..self.nodes {
            first.push(2.0 * x * first[k - 1] - first[k - 2]);
            second.push(2.0 * x * second[k - 1] - second[k - 2]);
        }
        let slope = |k: usize| if k == 0 { 0.0 } else { k as f64 * second[k - 1] / half };
        let slopes = (0..self.nodes).map(slope).collect();
        first.truncate(self.nodes);
        [first, slopes]
    }

    /// The sum of all terms, those of each size taken from `factors`.
    fn sum(&self, factors: &[&[f64]], values: &mut [f64]) {
        values.fill(0.0);
        for (term, row) in self.coefficients.chunks_exact(self.samples).enumerate() {
            let mut rest = term;
            let mut weight = 1.0;
            for factor in factors.iter().rev() {
                weight *= factor[rest % self.nodes];
                rest /= self.nodes;
            }
            values.iter_mut().zip(row).for_each(|(value, coefficient)| *value += weight * coefficient);
        }
    }
}

impl Model for Table {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn steps(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| (p.high - p.low) / (4 * self.nodes) as f64).collect()
    }

    fn values(&self, sizes: &[f64], values: &mut [f64]) -> Result<()> {
        let all: Vec<_> = sizes.iter().zip(&self.parameters).map(|(s, p)| self.polynomials(*s, p)).collect();
        let factors: Vec<&[f64]> = all.iter().map(|[first, _]| &first[..]).collect();
        self.sum(&factors, values);
        Ok(())
    }

    fn slopes(&self, sizes: &[f64], values: &mut [f64], slopes: &mut [Vec<f64>]) -> Result<()> {
        let all: Vec<_> = sizes.iter().zip(&self.parameters).map(|(s, p)| self.polynomials(*s, p)).collect();
        let mut factors: Vec<&[f64]> = all.iter().map(|[first, _]| &first[..]).collect();
        self.sum(&factors, values);
        for (k, slope) in slopes.iter_mut().enumerate() {
            factors[k] = &all[k][1];
            self.sum(&factors, slope);
            factors[k] = &all[k][0];
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unobserved;
    use crate::progress::Several;

    struct Formula;

    fn exact(sizes: &[f64]) -> [f64; 2] {
        [(3.0 * sizes[0]).sin() * (1.0 + sizes[1]), (sizes[1] - sizes[0]).exp()]
    }

    impl Simulator for Formula {
        fn simulate(&self, sizes: &[f64], _: &dyn Progress) -> Result<Vec<f64>> {
            Ok(exact(sizes).to_vec())
        }
    }

    #[test]
    fn tables_have_the_values_and_slopes_of_what_they_were_made_of() {
        let size = |low, high| Parameter { name: "x".into(), unit: String::new(), low, high };
        let stage = Several::begin(&Unobserved, "", 144);
        let sizes = vec![size(0.2, 1.0), size(-1.0, 0.5)];
        let table = Table::new(&Formula, sizes, 12, &|| stage.part()).unwrap();
        for at in [[0.3, -0.9], [0.77, 0.1], [1.0, 0.5]] {
            let (mut values, mut slopes) = (vec![0.0; 2], vec![vec![0.0; 2]; 2]);
            table.slopes(&at, &mut values, &mut slopes).unwrap();
            let mut alone = vec![0.0; 2];
            table.values(&at, &mut alone).unwrap();
            assert_eq!(values, alone);
            for sample in 0..2 {
                assert!((values[sample] - exact(&at)[sample]).abs() < 1e-9);
                for axis in 0..2 {
                    let step = 1e-5;
                    let moved = |sign: f64| {
                        let mut to = at;
                        to[axis] += sign * step;
                        exact(&to)[sample]
                    };
                    let slope = (moved(1.0) - moved(-1.0)) / (2.0 * step);
                    assert!((slopes[axis][sample] - slope).abs() < 1e-7, "{axis} {sample}");
                }
            }
        }
    }
}
