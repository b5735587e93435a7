//! How the reflected amplitude changes with each thickness and index of a stack, exactly, at about three times the cost of the
//! amplitude itself.
//!
//! The fields at the top are a product of one matrix per layer and the fields at the exit. With the part of the product above a
//! layer as a row and that below it as a column, every derivative is row · dM · column. The reflected amplitude does not
//! depend on the size of the fields, so each matrix may have the scale that keeps it finite.

use num_complex::Complex;
use rayon::prelude::*;

use super::{Entry, Polarization, check_balance, entry, power_of_two, resonance};
use crate::progress::Progress;
use crate::spectrum::Wavelengths;
use crate::stack::Stack;
use crate::{Complex64, Error, Result};

/// The reflected amplitude and its derivatives. It is holomorphic in every index n + jk: a change dn + j dk of one changes it by
/// `by_index` · (dn + j dk).
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// Reflected over incident amplitude, as [`super::FilmResponse::r`].
    pub r: Complex64,
    /// dr/d(thickness) of each layer from the entry side, 1/nm.
    pub by_thickness: Vec<Complex64>,
    /// dr/d(index) of each layer and, last, of the exit medium.
    pub by_index: Vec<Complex64>,
}

/// What a change of `r` by `by` changes |r|² by.
#[must_use]
pub fn of_power(r: Complex64, by: Complex64) -> f64 {
    2.0 * (r.re * by.re + r.im * by.im)
}

/// The gradient of a stack at one wavelength (nm), angle (rad) and polarization.
///
/// # Errors
/// As [`super::response`].
pub fn gradient(
    stack: &Stack,
    wavelength_nm: f64,
    angle: f64,
    polarization: Polarization,
) -> Result<Gradient> {
    let indices = stack.indices(wavelength_nm)?;
    gradient_at(&indices, stack.thickness_nm(), wavelength_nm, angle, polarization)
}

/// As [`gradient`], from the refractive `indices` of all regions (entry, layers, exit) at this wavelength.
///
/// # Errors
/// As [`super::response_at`].
pub fn gradient_at(
    indices: &[Complex64],
    thickness_nm: &[f64],
    wavelength_nm: f64,
    angle: f64,
    polarization: Polarization,
) -> Result<Gradient> {
    let entry = entry(indices, thickness_nm, wavelength_nm, angle, polarization)?;
    let layers = thickness_nm.len();
    let steps: Vec<Step> =
        (0..layers).map(|layer| Step::new(&entry, indices[layer + 1], thickness_nm[layer])).collect();
    // Under each layer, from the last one up, then at the top.
    let mut column = Scaled::new([Complex64::new(1.0, 0.0), entry.admittance(indices[layers + 1])]);
    let mut below = vec![column; layers];
    for (step, below) in steps.iter().zip(&mut below).rev() {
        *below = column;
        column = column.then(|fields| step.matrix.times(fields));
    }
    let ([f, g], y) = (column.pair, entry.y);
    let incident = f * y + g;
    let r = (f * y - g) / incident;
    if !r.is_finite() {
        return Err(resonance(wavelength_nm));
    }
    check_balance([r.norm_sqr(), 0.0], wavelength_nm, angle, polarization)?;
    // dr = 2y (g df − f dg)/(yf + g)²
    let factor = Complex64::from(2.0 * y) / (incident * incident);
    let mut row = Scaled { pair: [g * factor, -f * factor], doublings: -column.doublings }.balanced();
    let mut found = Gradient { r, by_thickness: Vec::new(), by_index: Vec::new() };
    for (step, below) in steps.iter().zip(&below) {
        found.by_thickness.push(row.dot(&step.by_thickness, below));
        found.by_index.push(row.dot(&step.by_index, below));
        row = row.then(|fields| step.matrix.transposed().times(fields));
    }
    found.by_index.push(row.pair[1] * by_exit(&entry, indices[layers + 1]) * row.power());
    Ok(found)
}

/// Gradients at every wavelength and angle (rad), in parallel over wavelengths: `[wavelength][angle][polarization]`, s before p.
///
/// # Errors
/// As [`gradient`], or the user cancelled.
pub fn gradients(
    stack: &Stack,
    at: &Wavelengths,
    angle: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<Vec<[Gradient; 2]>>> {
    progress.begin("derivatives", at.len() as u64);
    let column = |&nm: &f64| {
        let indices = stack.indices(nm)?;
        let mut column = Vec::with_capacity(angle.len());
        for &angle in angle {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let of = |polarization| gradient_at(&indices, stack.thickness_nm(), nm, angle, polarization);
            column.push([of(Polarization::S)?, of(Polarization::P)?]);
        }
        progress.advance(1);
        Ok(column)
    };
    at.par_iter().map(column).collect()
}

/// dY/dn of the exit.
fn by_exit(entry: &Entry, n: Complex64) -> Complex64 {
    let q = entry.q(n);
    match entry.polarization {
        Polarization::S => n / q,
        Polarization::P => (q * n).inv() - q * 2.0 / (n * n * n),
    }
}

/// Two numbers times a power of two.
#[derive(Debug, Clone, Copy)]
struct Scaled {
    pair: [Complex64; 2],
    doublings: i32,
}

impl Scaled {
    fn new(pair: [Complex64; 2]) -> Self {
        Self { pair, doublings: 0 }
    }

    fn then(self, change: impl Fn([Complex64; 2]) -> [Complex64; 2]) -> Self {
        Self { pair: change(self.pair), ..self }.balanced()
    }

    fn balanced(self) -> Self {
        let size: f64 = self.pair.iter().map(Complex::norm_sqr).sum();
        if !(size > 0.0 && size.is_finite()) || (1e-60..1e60).contains(&size) {
            return self;
        }
        let up = (size.log2() / 2.0) as i32;
        let factor = power_of_two(-i64::from(up));
        Self { pair: self.pair.map(|value| value * factor), doublings: self.doublings + up }
    }

    fn power(&self) -> f64 {
        power_of_two(i64::from(self.doublings))
    }

    /// row · matrix · column.
    fn dot(&self, matrix: &Matrix, column: &Self) -> Complex64 {
        let [f, g] = matrix.times(column.pair);
        let both = i64::from(self.doublings) + i64::from(column.doublings);
        (self.pair[0] * f + self.pair[1] * g) * power_of_two(both)
    }
}

/// Rows of a matrix.
#[derive(Debug, Clone, Copy)]
struct Matrix([[Complex64; 2]; 2]);

impl Matrix {
    fn times(&self, [f, g]: [Complex64; 2]) -> [Complex64; 2] {
        self.0.map(|[a, b]| a * f + b * g)
    }

    fn transposed(&self) -> Self {
        let Self([[a, b], [c, d]]) = *self;
        Self([[a, c], [b, d]])
    }
}

/// A layer's matrix from the fields at its bottom to those at its top, and its derivatives, all at one scale.
struct Step {
    matrix: Matrix,
    by_thickness: Matrix,
    by_index: Matrix,
}

/// cosδ, −j sinδ/q and −j q sinδ, maybe all times exp(jδ): of q for s, of what it becomes with n for p.
#[derive(Debug, Clone, Copy)]
struct Terms {
    cosine: Complex64,
    over: Complex64,
    times: Complex64,
}

/// Below this |δ| the terms are taken as series in q², which do not lose their digits where q is 0.
const SMALL: f64 = 0.1;

impl Step {
    fn new(entry: &Entry, n: Complex64, thickness_nm: f64) -> Self {
        let (q, depth) = (entry.q(n), entry.k * thickness_nm);
        let [at, by_depth, by_q_squared] =
            if (q * depth).norm() < SMALL { near(q * q, depth) } else { far(q, depth) };
        let admitted = |Terms { cosine, over, times }: Terms| {
            let [over, times] = match entry.polarization {
                Polarization::S => [over, times],
                Polarization::P => [over * n * n, times / (n * n)],
            };
            Matrix([[cosine, over], [times, cosine]])
        };
        let scaled = |terms: Terms, factor: Complex64| Terms {
            cosine: terms.cosine * factor,
            over: terms.over * factor,
            times: terms.times * factor,
        };
        // q² = n² − (n₀ sinα₀)²
        let Matrix(mut by_index) = admitted(scaled(by_q_squared, n * 2.0));
        if entry.polarization == Polarization::P {
            by_index[0][1] += at.over * n * 2.0;
            by_index[1][0] -= at.times * 2.0 / (n * n * n);
        }
        Self {
            matrix: admitted(at),
            by_thickness: admitted(scaled(by_depth, entry.k.into())),
            by_index: Matrix(by_index),
        }
    }
}

/// The terms times exp(jδ), and their derivatives by depth D and by q², δ = qD. The derivatives of the common factor are left
/// out, as no ratio of fields depends on it.
fn far(q: Complex64, depth: f64) -> [Terms; 3] {
    let j = Complex64::i();
    let turn = (j * q * (2.0 * depth)).exp();
    let (kept, lost) = ((turn + 1.0) * 0.5, (-turn + 1.0) * 0.5);
    let by_depth = j * q * turn;
    let by_q = j * depth * turn;
    let per_q_squared = (q * 2.0).inv();
    [
        Terms { cosine: kept, over: lost / q, times: lost * q },
        Terms { cosine: by_depth, over: -by_depth / q, times: -by_depth * q },
        Terms {
            cosine: by_q * per_q_squared,
            over: (-by_q / q - lost / (q * q)) * per_q_squared,
            times: (-by_q * q + lost) * per_q_squared,
        },
    ]
}

/// The terms themselves, and their derivatives by depth D and by u = q², as series in x = D²u, |x| < 0.01.
fn near(u: Complex64, depth: f64) -> [Terms; 3] {
    let minus_j = Complex64::new(0.0, -1.0);
    let x = u * depth * depth;
    let zero = Complex64::default();
    let (mut cosine, mut sinc, mut by_cosine, mut by_sinc) = (zero, zero, zero, zero);
    // (−x)^i/(2i)! and (−x)^i/(2i + 1)!, and the sums of their derivatives by x.
    let mut power = Complex64::from(1.0);
    let mut factorial = 1.0;
    for i in 0..8_u32 {
        let (even, odd) = (factorial, factorial * f64::from(2 * i + 1));
        let next = factorial * f64::from((2 * i + 1) * (2 * i + 2));
        cosine += power / even;
        sinc += power / odd;
        // d(−x)^{i+1}/dx = −(i + 1)(−x)^i
        let slope = -power * f64::from(i + 1);
        by_cosine += slope / next;
        by_sinc += slope / (next * f64::from(2 * i + 3));
        power *= -x;
        factorial = next;
    }
    let squared = depth * depth;
    [
        Terms { cosine, over: minus_j * sinc * depth, times: minus_j * sinc * depth * u },
        Terms { cosine: -sinc * depth * u, over: minus_j * cosine, times: minus_j * cosine * u },
        Terms {
            cosine: by_cosine * squared,
            over: minus_j * by_sinc * squared * depth,
            times: minus_j * (sinc + by_sinc * x) * depth,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::reflect;

    /// Central differences of [`reflect`] by the thickness and by n at `place`.
    fn differences(
        indices: &[Complex64],
        thickness: &[f64],
        at: (f64, f64, Polarization),
        place: usize,
    ) -> (Option<Complex64>, Complex64) {
        let (nm, angle, polarization) = at;
        let r = |indices: &[Complex64], thickness: &[f64]| {
            reflect(indices, thickness, nm, angle, polarization).unwrap()
        };
        let by_thickness = (place < thickness.len()).then(|| {
            let step = 1e-3;
            let moved = |by: f64| {
                let mut other = thickness.to_vec();
                other[place] += by;
                r(indices, &other)
            };
            (moved(step) - moved(-step)) / (2.0 * step)
        });
        let step = 1e-6;
        let moved = |by: Complex64| {
            let mut other = indices.to_vec();
            other[place + 1] += by;
            r(&other, thickness)
        };
        let along_n = (moved(step.into()) - moved((-step).into())) / (2.0 * step);
        (by_thickness, along_n)
    }

    fn check(indices: &[Complex64], thickness: &[f64], nm: f64, angle: f64, tolerance: f64) {
        for polarization in Polarization::BOTH {
            let found = gradient_at(indices, thickness, nm, angle, polarization).unwrap();
            let r = reflect(indices, thickness, nm, angle, polarization).unwrap();
            assert!((found.r - r).norm() < 1e-12, "{} {r}", found.r);
            assert_eq!(
                (found.by_thickness.len(), found.by_index.len()),
                (thickness.len(), thickness.len() + 1)
            );
            for place in 0..=thickness.len() {
                let (by_thickness, by_index) =
                    differences(indices, thickness, (nm, angle, polarization), place);
                let near = |found: Complex64, expected: Complex64| {
                    assert!(
                        (found - expected).norm() < tolerance * (1.0 + expected.norm()),
                        "{polarization:?}, place {place}, {angle}: {found} {expected}"
                    );
                };
                near(found.by_index[place], by_index);
                // By k, towards absorption alone, since gain is refused: one-sided, of second order.
                let step = 1e-5;
                let moved = |steps: f64| {
                    let mut other = indices.to_vec();
                    other[place + 1] += c(0.0, steps * step);
                    reflect(&other, thickness, nm, angle, polarization).unwrap()
                };
                let by_k = (moved(1.0) * 4.0 - moved(2.0) - r * 3.0) / (2.0 * step);
                let found_by_k = found.by_index[place] * Complex64::i();
                // Where a wave begins to decay the third derivative is large.
                assert!(
                    (found_by_k - by_k).norm() < 1e2 * tolerance * (1.0 + by_k.norm()),
                    "{polarization:?}, place {place}, {angle}, by k: {found_by_k} {by_k}"
                );
                if let Some(expected) = by_thickness {
                    near(found.by_thickness[place], expected);
                }
            }
        }
    }

    fn c(re: f64, im: f64) -> Complex64 {
        Complex64::new(re, im)
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let indices = [c(1.0, 0.0), c(1.55, 0.0), c(1.7, 0.08), c(1.0, 0.0), c(1.74, 0.03), c(1.55, 0.1)];
        for angle in [0.0, 0.3, 0.9, 1.4] {
            check(&indices, &[320.0, 90.0, 150.0, 8.0], 500.0, angle, 1e-7);
        }
    }

    /// At the critical angle of a gap of air, where q is 0, and beyond it, where waves decay.
    #[test]
    fn derivatives_hold_where_waves_begin_to_decay() {
        let indices = [c(1.55, 0.0), c(1.0, 0.0), c(1.55, 0.0), c(1.7, 0.1)];
        let critical = (1.0_f64 / 1.55).asin();
        for angle in [critical - 1e-3, critical - 1e-8, critical, critical + 1e-8, critical + 1e-3, 1.2] {
            check(&indices, &[400.0, 100.0], 500.0, angle, 1e-6);
        }
    }

    /// Through a hundred micrometres of pigment nothing of what lies below is seen, and nothing overflows; a mirror of hundreds of
    /// layers scales its fields many times.
    #[test]
    fn thick_and_many_layers_keep_their_digits() {
        let dark = [c(1.0, 0.0), c(1.5, 0.0), c(1.8, 0.5), c(1.3, 0.0), c(2.0, 0.0)];
        let found = gradient_at(&dark, &[200.0, 100_000.0, 50.0], 500.0, 0.4, Polarization::P).unwrap();
        assert!(found.by_thickness[2].norm() < 1e-17, "{}", found.by_thickness[2]);
        assert!(found.by_thickness[0].norm() > 1e-4 && found.by_index[1].norm() > 1e-2);
        check(&dark, &[200.0, 100_000.0, 50.0], 500.0, 0.4, 1e-7);
        let pair = [c(1.4, 0.001), c(1.8, 0.0)];
        let mirror: Vec<Complex64> =
            std::iter::once(c(1.0, 0.0)).chain((0..600).map(|i| pair[i % 2])).chain([c(1.5, 0.0)]).collect();
        check(&mirror, &[80.0; 600], 500.0, 0.5, 1e-6);
        check(&[c(1.0, 0.0), c(1.5, 0.2)], &[], 500.0, 0.5, 1e-7);
    }

    /// Of a film without absorption dR/dd is 0 where reflectance turns: at odd quarters of a wave.
    #[test]
    fn a_quarter_wave_film_does_not_change() {
        let indices = [c(1.0, 0.0), c(1.5, 0.0), c(1.0, 0.0)];
        let found = gradient_at(&indices, &[500.0 / 6.0], 500.0, 0.0, Polarization::S).unwrap();
        assert!(of_power(found.r, found.by_thickness[0]).abs() < 1e-15);
        // Around it R = 4 R₁ sin²(2πnd/λ)/(1 + …): it rises before.
        let before = gradient_at(&indices, &[60.0], 500.0, 0.0, Polarization::S).unwrap();
        assert!(of_power(before.r, before.by_thickness[0]) > 1e-3);
    }
}
