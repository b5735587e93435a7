//! What flat layers reflect into readings, with exact derivatives.

use super::reading::{Beam, Reading};
use super::template::{Place, Template};
use super::{Model, Parameter};
use crate::film::gradient::{gradient_at, of_power};
use crate::film::{Polarization, reflect};
use crate::material::Library;
use crate::math::golden::GoldenPoints;
use crate::math::normal::quantile;
use crate::stack::{CLIP, Stack};
use crate::{Complex64, Result};

/// Individuals of a stack in which several layers spread.
const INDIVIDUALS: usize = 64;

/// One sample of a reading.
struct Sample {
    nm: f64,
    /// The reading that it belongs to.
    reading: usize,
    /// Refractive indices of all regions, where nothing changes them.
    indices: Vec<Complex64>,
}

/// A stack with unknown numbers, as its readings see it.
pub(super) struct Planar {
    template: Template,
    library: Library,
    samples: Vec<Sample>,
    /// Angle in rad and weight of each beam of each reading.
    beams: Vec<Vec<[f64; 2]>>,
    /// Thicknesses and their deviations where all sizes are 0, and their change with each size: both are linear.
    base: [Vec<f64>; 2],
    by_size: Vec<[Vec<f64>; 2]>,
    /// Individuals: weight, and each layer's deviate from its mean in standard deviations.
    individuals: Vec<(f64, Vec<f64>)>,
    moves_indices: bool,
    steps: Vec<f64>,
}

impl Planar {
    /// A template seen by these readings.
    ///
    /// # Errors
    /// A medium has no index at a wavelength, or the entry absorbs.
    pub(super) fn new(template: Template, readings: &[Reading], library: &Library) -> Result<Self> {
        // The thickest layers of the least spread, so that each size can be moved alone.
        let middle = template.sizes(|place| f64::from(u8::from(place == Place::Thickness)));
        let stack = template.stack(&middle, library)?;
        let mut samples = Vec::new();
        for (reading, of) in readings.iter().enumerate() {
            for &nm in of.nm() {
                samples.push(Sample { nm, reading, indices: stack.indices(nm)? });
            }
        }
        let beams = readings
            .iter()
            .map(|reading| reading.beams.iter().map(|beam: &Beam| [beam.angle(), beam.weight]).collect());
        let beams = beams.collect();
        let lengths = |stack: &Stack| [stack.thickness_nm().to_vec(), stack.spread_nm().to_vec()];
        let base = lengths(&stack);
        let mut by_size = Vec::new();
        for (k, p) in template.parameters.iter().enumerate() {
            let mut sizes = middle.clone();
            sizes[k] = if sizes[k] == p.high { p.low } else { p.high };
            let moved = sizes[k] - middle[k];
            let changed = lengths(&template.stack(&sizes, library)?);
            let slope = |which: usize| -> Vec<f64> {
                changed[which].iter().zip(&base[which]).map(|(a, b)| (a - b) / moved).collect()
            };
            by_size.push([slope(0), slope(1)]);
        }
        let base = [0, 1].map(|which| {
            let slopes = by_size.iter().zip(&middle);
            let at_zero = |layer: usize| {
                let known: f64 = slopes.clone().map(|(slope, size)| slope[which][layer] * size).sum();
                base[which][layer] - known
            };
            (0..base[which].len()).map(at_zero).collect::<Vec<_>>()
        });
        let mut model = Self {
            moves_indices: template.places.iter().any(|p| matches!(p, Place::Fraction | Place::Index)),
            template,
            library: library.clone(),
            samples,
            beams,
            base,
            by_size,
            individuals: Vec::new(),
            steps: Vec::new(),
        };
        model.individuals = model.drawn();
        model.steps = model.fine_steps();
        Ok(model)
    }

    /// The largest n and the shortest wavelength, which together decide how fast phases run with thickness.
    fn fastest(&self) -> f64 {
        let largest = |sample: &Sample| {
            let inner = &sample.indices[1..sample.indices.len() - 1];
            inner.iter().map(|n| n.re).fold(1.0, f64::max) / sample.nm
        };
        self.samples.iter().map(largest).fold(0.0, f64::max)
    }

    /// Distances of the sizes over which no fringe passes unseen: a sixteenth of a wavelength of phase, shared by the layers that a
    /// size belongs to.
    fn fine_steps(&self) -> Vec<f64> {
        let places = self.template.places.iter().zip(&self.template.parameters).zip(&self.by_size);
        places
            .map(|((place, p), slope)| match place {
                Place::Thickness => {
                    let layers = slope[0].iter().sum::<f64>().clamp(1.0, 2.0);
                    1.0 / (16.0 * self.fastest() * layers)
                }
                Place::Spread | Place::Fraction | Place::Index => (p.high - p.low) / 6.0,
            })
            .collect()
    }

    /// The individuals that stand for all: one where nothing spreads, equidistant ones of one layer, which converges geometrically,
    /// and those of a low-discrepancy sequence of several.
    fn drawn(&self) -> Vec<(f64, Vec<f64>)> {
        let highest: Vec<f64> = self.template.parameters.iter().map(|p| p.high).collect();
        let [_, widest] = self.lengths(&highest);
        let spreading: Vec<usize> = (0..widest.len()).filter(|&layer| widest[layer] > 0.0).collect();
        let of = |deviates: &dyn Fn(usize) -> f64| {
            let mut all = vec![0.0; widest.len()];
            spreading.iter().enumerate().for_each(|(axis, &layer)| all[layer] = deviates(axis));
            all
        };
        match spreading[..] {
            [] => vec![(1.0, vec![0.0; widest.len()])],
            [layer] => {
                // |R| of one layer has the period of its double phase; aliases of the sum lie far out in the Gaussian.
                let turns = 4.0 * std::f64::consts::PI * self.fastest() * widest[layer];
                let half = (CLIP / (std::f64::consts::TAU / (turns + 4.0)).min(0.5)).ceil();
                let places = (-(half as i32)..=half as i32).map(|k| f64::from(k) * CLIP / half);
                let weighed: Vec<(f64, f64)> = places.map(|u| ((-0.5 * u * u).exp(), u)).collect();
                let whole: f64 = weighed.iter().map(|(weight, _)| weight).sum();
                weighed.into_iter().map(|(weight, u)| (weight / whole, of(&|_| u))).collect()
            }
            [..] => {
                let points = GoldenPoints::new(spreading.len());
                let deviate = |k: usize, axis: usize| {
                    quantile(points.at(k, axis).clamp(1e-6, 1.0 - 1e-6)).clamp(-CLIP, CLIP)
                };
                let weight = 1.0 / INDIVIDUALS as f64;
                (0..INDIVIDUALS).map(|k| (weight, of(&|axis| deviate(k, axis)))).collect()
            }
        }
    }

    /// Thicknesses and their deviations.
    fn lengths(&self, sizes: &[f64]) -> [Vec<f64>; 2] {
        [0, 1].map(|which| {
            let mut all = self.base[which].clone();
            for (slope, size) in self.by_size.iter().zip(sizes) {
                all.iter_mut().zip(&slope[which]).for_each(|(length, slope)| *length += slope * size);
            }
            all.iter_mut().for_each(|length| *length = length.max(0.0));
            all
        })
    }

    /// Thicknesses of every individual.
    fn thicknesses(&self, sizes: &[f64]) -> Vec<Vec<f64>> {
        let [mean, deviation] = self.lengths(sizes);
        let layers = || mean.iter().zip(&deviation);
        let one = |deviates: &Vec<f64>| {
            layers().zip(deviates).map(|((mean, deviation), u)| (mean + deviation * u).max(0.0)).collect()
        };
        self.individuals.iter().map(|(_, deviates)| one(deviates)).collect()
    }

    /// The stack of these sizes where they move indices.
    fn moved(&self, sizes: &[f64]) -> Result<Option<Stack>> {
        self.moves_indices.then(|| self.template.stack(sizes, &self.library)).transpose()
    }

    /// The stacks with one size a little less and a little more, and the distance, for each size that moves indices.
    fn neighbours(&self, sizes: &[f64]) -> Result<Vec<Option<(Stack, Stack, f64)>>> {
        let both = |(k, place): (usize, &Place)| {
            if !matches!(place, Place::Fraction | Place::Index) {
                return Ok(None);
            }
            let p = &self.template.parameters[k];
            let step = 1e-4 * (p.high - p.low);
            let (less, more) = ((sizes[k] - step).max(p.low), (sizes[k] + step).min(p.high));
            let with = |size: f64| {
                let mut sizes = sizes.to_vec();
                sizes[k] = size;
                self.template.stack(&sizes, &self.library)
            };
            Ok(Some((with(less)?, with(more)?, more - less)))
        };
        self.template.places.iter().enumerate().map(both).collect()
    }
}

impl Model for Planar {
    fn parameters(&self) -> &[Parameter] {
        &self.template.parameters
    }

    fn steps(&self) -> Vec<f64> {
        self.steps.clone()
    }

    fn values(&self, sizes: &[f64], values: &mut [f64]) -> Result<()> {
        let (thicknesses, moved) = (self.thicknesses(sizes), self.moved(sizes)?);
        for (value, sample) in values.iter_mut().zip(&self.samples) {
            let own = moved.as_ref().map(|stack| stack.indices(sample.nm)).transpose()?;
            let indices = own.as_ref().unwrap_or(&sample.indices);
            *value = 0.0;
            for ((part, _), thickness) in self.individuals.iter().zip(&thicknesses) {
                for [angle, weight] in &self.beams[sample.reading] {
                    for polarization in Polarization::BOTH {
                        let r = reflect(indices, thickness, sample.nm, *angle, polarization)?;
                        *value += 0.5 * part * weight * r.norm_sqr();
                    }
                }
            }
        }
        Ok(())
    }

    fn slopes(&self, sizes: &[f64], values: &mut [f64], slopes: &mut [Vec<f64>]) -> Result<()> {
        let (thicknesses, moved) = (self.thicknesses(sizes), self.moved(sizes)?);
        let neighbours = self.neighbours(sizes)?;
        for (i, sample) in self.samples.iter().enumerate() {
            let own = moved.as_ref().map(|stack| stack.indices(sample.nm)).transpose()?;
            let indices = own.as_ref().unwrap_or(&sample.indices);
            let index_slopes = neighbours.iter().map(|pair| index_slope(pair.as_ref(), sample.nm));
            let index_slopes = index_slopes.collect::<Result<Vec<_>>>()?;
            values[i] = 0.0;
            slopes.iter_mut().for_each(|slope| slope[i] = 0.0);
            for ((part, deviates), thickness) in self.individuals.iter().zip(&thicknesses) {
                for [angle, weight] in &self.beams[sample.reading] {
                    for polarization in Polarization::BOTH {
                        let found = gradient_at(indices, thickness, sample.nm, *angle, polarization)?;
                        let part = 0.5 * part * weight;
                        values[i] += part * found.r.norm_sqr();
                        for (k, slope) in slopes.iter_mut().enumerate() {
                            let [mean, deviation] = &self.by_size[k];
                            let layers = mean.iter().zip(deviation).zip(deviates).zip(&found.by_thickness);
                            let mut change: Complex64 =
                                layers.map(|(((mean, deviation), u), by)| by * (mean + deviation * u)).sum();
                            if let Some(by_size) = &index_slopes[k] {
                                change += by_size
                                    .iter()
                                    .zip(&found.by_index)
                                    .map(|(n, by)| n * by)
                                    .sum::<Complex64>();
                            }
                            slope[i] += part * of_power(found.r, change);
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// How the indices of all layers and of the exit change with a size, by the difference of two stacks: mixtures are smooth in
/// their fraction, whatever their rule.
fn index_slope(pair: Option<&(Stack, Stack, f64)>, nm: f64) -> Result<Option<Vec<Complex64>>> {
    let Some((less, more, step)) = pair else { return Ok(None) };
    let (less, more) = (less.indices(nm)?, more.indices(nm)?);
    Ok(Some(less.iter().zip(&more).skip(1).map(|(less, more)| (more - less) / *step).collect()))
}
