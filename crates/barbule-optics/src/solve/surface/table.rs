//! Reflectances of every point of a surface at one wavelength and all angles, as Chebyshev series in cosα.
//!
//! A campaign lights each point from hundreds of directions, while a stack's reflectance varies with the angle only as
//! fast as the phases of its layers. As a function of cosα it is analytic on the whole of \[0, 1\], grazing incidence
//! included (in sin²α it is not: the cosine in air is its root), so a Chebyshev series converges geometrically once it
//! follows those phases.

use fearless_simd::{dispatch, prelude::*};

use super::batch::unless_cancelled;
use super::points::{Arrays, Optics, Points, SlotMedium};
use super::rays::{AtAngle, Media, Rays, SERIES};
use super::reflection::{BLOCK, Reflectances, none};
use crate::Result;
use crate::math::chebyshev;
use crate::math::simd::{Complex, Real, Width, load, splat};
use crate::progress::Progress;

/// Centre and half of the range of cosα, from [`Real::GRAZING`] to 1.
const CENTRE: f64 = 0.5 * (1.0 + <f32 as Real>::GRAZING);
const HALF: f64 = 0.5 * (1.0 - <f32 as Real>::GRAZING);

/// What a block's series leave out, at most.
const TOLERANCE: f32 = 3e-5;

/// Longer series are no gain; such blocks are reflected from anew.
const MOST_TERMS: usize = 256;

/// Reflectances of a surface at one wavelength.
pub(super) struct ReflectanceTable {
    /// For blocks without series.
    optics: Optics<f32>,
    /// First coefficient of each block and number of its terms; none where the block has no series.
    blocks: Vec<(usize, usize)>,
    /// `[block][term][series][point]`
    coefficients: Vec<f32>,
}

/// One coefficient of each series at each point of a block.
type Term = [f32; SERIES * BLOCK];

impl ReflectanceTable {
    /// Tabulates the reflectances of a surface's points from the rays under its elements.
    ///
    /// # Errors
    /// A table of a medium does not reach the wavelength, or a stop by `progress`.
    pub(super) fn new(
        width: Width,
        points: &Points,
        rays: &Rays,
        wavelength_nm: f64,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let media = rays.media(wavelength_nm)?;
        let optics = points.optics(wavelength_nm)?;
        let mut table = Self { optics, blocks: Vec::new(), coefficients: Vec::new() };
        let (mut angles, mut samples, mut terms) = (Vec::new(), Vec::new(), Vec::new());
        // Neighbours need about as many terms as each other.
        let mut expected = table.expected_terms(&points.single, points.count / 2 / BLOCK * BLOCK);
        for start in (0..points.padded()).step_by(BLOCK) {
            unless_cancelled(progress)?;
            let begin = table.coefficients.len();
            let mut count = expected;
            while count <= MOST_TERMS {
                if angles.len() != count {
                    angles = nodes(count).map(|cos_alpha| AtAngle::new(rays, &media, cos_alpha)).collect();
                }
                dispatch!(width.0, simd => sample_block(simd, rays, &media, start, &angles, &mut samples));
                dispatch!(width.0, simd => transform(simd, &samples, &mut terms));
                if let Some(kept) = needed(&terms) {
                    table.coefficients.extend(terms[..kept].as_flattened());
                    expected = (kept + 4).next_multiple_of(2);
                    break;
                }
                count = (count + count / 2).next_multiple_of(4);
            }
            table.blocks.push((begin, (table.coefficients.len() - begin) / (SERIES * BLOCK)));
        }
        table.coefficients.shrink_to_fit();
        Ok(table)
    }

    /// Bytes that the series take.
    pub(super) fn bytes(&self) -> usize {
        self.coefficients.len() * size_of::<f32>()
    }

    /// A guess of the terms that a block needs: the phase that its layers gain between normal and grazing incidence,
    /// as far down as light gets, times a factor, and some more for the decay that follows.
    fn expected_terms(&self, arrays: &Arrays<f32>, start: usize) -> usize {
        let padded = arrays.x_um.len();
        let phase = |at: usize| {
            let (mut phase, mut depth) = (0.0, 0.0);
            for (slot, medium) in self.optics.slots.iter().enumerate().rev().skip(1).rev() {
                let contrast = match medium {
                    SlotMedium::Uniform(value) => *value,
                    SlotMedium::Varying { re, im } => {
                        num_complex::Complex64::new(f64::from(re[at]), f64::from(im[at]))
                    }
                };
                let twice = 2.0 * self.optics.k * f64::from(arrays.thickness_um[slot * padded + at]);
                let (steep, grazing) = ((contrast + 1.0).sqrt(), contrast.sqrt());
                phase += twice * (steep.re - grazing.re).abs() * f64::exp(-depth);
                depth += twice * steep.im;
            }
            phase
        };
        let longest = (start..start + BLOCK).step_by(16).map(phase).fold(0.0, f64::max);
        // The bound keeps the cast and the doublings sane for media of any index.
        ((0.75 * longest).min(1e4) as usize + 20).next_multiple_of(4)
    }
}

impl Reflectances<f32> for ReflectanceTable {
    #[inline(always)]
    fn at<S: Simd>(
        &self,
        simd: S,
        arrays: &Arrays<f32>,
        at: usize,
        cos_alpha: S::f32s,
    ) -> [Complex<S::f32s>; 2] {
        let [reflected] = self.at_each(simd, arrays, at, [cos_alpha]);
        reflected
    }

    #[inline(always)]
    fn at_each<S: Simd, const G: usize>(
        &self,
        simd: S,
        arrays: &Arrays<f32>,
        at: usize,
        cos_alpha: [S::f32s; G],
    ) -> [[Complex<S::f32s>; 2]; G] {
        let (block, offset) = (at / BLOCK, at % BLOCK);
        let (begin, terms) = self.blocks[block];
        let series = self.coefficients[begin..begin + terms * SERIES * BLOCK].as_chunks().0;
        if terms > 0 && S::f32s::LEN >= 16 {
            return sums(simd, series, offset, cos_alpha);
        }
        let mut reflected = none(simd);
        for (reflected, cos_alpha) in reflected.iter_mut().zip(cos_alpha) {
            if terms == 0 {
                *reflected = self.optics.at(simd, arrays, at, cos_alpha);
            } else {
                // Narrower registers are too few for the sums of several directions.
                [*reflected] = sums(simd, series, offset, [cos_alpha]);
            }
        }
        reflected
    }
}

/// The series of the points from `offset` on, summed for light from several directions.
#[inline(always)]
fn sums<S: Simd, const G: usize>(
    simd: S,
    series: &[Term],
    offset: usize,
    cos_alpha: [S::f32s; G],
) -> [[Complex<S::f32s>; 2]; G] {
    let (centre, scale) = (splat::<S, S::f32s>(simd, CENTRE), splat::<S, S::f32s>(simd, HALF.recip()));
    let mut before = cos_alpha;
    for value in &mut before {
        *value = (*value - centre) * scale;
    }
    let mut twice = before;
    for value in &mut twice {
        *value = *value + *value;
    }
    let mut now = [splat::<S, S::f32s>(simd, 1.0); G];
    let mut sums = [[splat::<S, S::f32s>(simd, 0.0); SERIES]; G];
    for term in series {
        for index in 0..SERIES {
            let coefficients: S::f32s = load(simd, term, index * BLOCK + offset);
            for (sums, now) in sums.iter_mut().zip(&now) {
                sums[index] = coefficients.mul_add(*now, sums[index]);
            }
        }
        for ((before, now), twice) in before.iter_mut().zip(&mut now).zip(&twice) {
            (*before, *now) = (*now, twice.mul_sub(*now, *before));
        }
    }
    let mut reflected = none(simd);
    for ([r_s, r_p], [s_re, s_im, p_re, p_im]) in reflected.iter_mut().zip(sums) {
        (*r_s, *r_p) = (Complex { re: s_re, im: s_im }, Complex { re: p_re, im: p_im });
    }
    reflected
}

/// The Chebyshev nodes of cosα.
fn nodes(count: usize) -> impl Iterator<Item = f64> {
    chebyshev::nodes(count).map(|x| CENTRE + HALF * x)
}

/// Reflectances of a block's points at the Chebyshev nodes.
#[inline(always)]
fn sample_block<S: Simd>(
    simd: S,
    rays: &Rays,
    media: &Media,
    start: usize,
    angles: &[AtAngle],
    samples: &mut Vec<Term>,
) {
    samples.clear();
    samples.resize(angles.len(), [0.0; SERIES * BLOCK]);
    let (mut trips, mut below) = (Vec::new(), [[0f32; BLOCK]; SERIES]);
    // As many blocks of rays as an element has parts; past the last there are only points without weight.
    let first = start / BLOCK * rays.parts();
    for block in first..(first + rays.parts()).min(rays.blocks()) {
        for (angle, sample) in angles.iter().zip(&mut *samples) {
            rays.reflect(simd, media, angle, block, &mut trips, &mut below);
            add_to_points(rays.weights(), block - first, &below, sample);
        }
    }
}

/// Adds what the rays of block `part` contribute to the points of a block.
#[inline(always)]
fn add_to_points(weights: &[Vec<f32>; 2], part: usize, rays: &[[f32; BLOCK]; SERIES], points: &mut Term) {
    let [left, right] = weights;
    let elements = BLOCK / left.len();
    for (row, points) in rays.iter().zip(points.as_chunks_mut::<BLOCK>().0) {
        let points = points[2 * elements * part..].as_chunks_mut::<2>().0;
        for (rays, point) in row.chunks_exact(left.len()).zip(points) {
            for ((value, a), b) in rays.iter().zip(left).zip(right) {
                point[0] += a * value;
                point[1] += b * value;
            }
        }
    }
}

/// Chebyshev coefficients from values at the nodes: c_k = (2 − δ_k0)/n Σ_j f_j cos(πk(j + ½)/n).
#[inline(always)]
fn transform<S: Simd>(simd: S, samples: &[Term], terms: &mut Vec<Term>) {
    let count = samples.len();
    terms.clear();
    terms.resize(count, [0.0; SERIES * BLOCK]);
    let cosines = chebyshev::cosines(count);
    for (k, term) in terms.iter_mut().enumerate() {
        let scale = if k == 0 { 1.0 } else { 2.0 } / count as f64;
        // A few registers of sums at a time.
        for group in (0..SERIES * BLOCK).step_by(4 * S::f32s::LEN) {
            let mut sums = [splat::<S, S::f32s>(simd, 0.0); 4];
            for (j, sample) in samples.iter().enumerate() {
                let weight: S::f32s = splat(simd, cosines[k * (2 * j + 1) % (4 * count)] * scale);
                for (index, sum) in sums.iter_mut().enumerate() {
                    *sum =
                        load::<S, S::f32s>(simd, sample, group + index * S::f32s::LEN).mul_add(weight, *sum);
                }
            }
            for (index, sum) in sums.into_iter().enumerate() {
                let from = group + index * S::f32s::LEN;
                sum.store_slice(&mut term[from..from + S::f32s::LEN]);
            }
        }
    }
}

/// How many terms to keep so that what is left out stays below the tolerance at every point, or `None` if the series
/// has not converged (or is not finite).
fn needed(terms: &[Term]) -> Option<usize> {
    let largest = |term: &Term| {
        term.iter().fold(0f32, |m, c| if c.is_finite() { m.max(c.abs()) } else { f32::INFINITY })
    };
    chebyshev::needed(terms.iter().map(largest), TOLERANCE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;
    use crate::progress::Unobserved;
    use crate::solve::surface::Window;
    use crate::structure::SpeciesModel;

    /// r_s and r_p of every point at one angle, `[point][r_s, r_p][re, im]`.
    #[inline(always)]
    fn evaluate<S: Simd>(
        simd: S,
        from: &impl Reflectances<f32>,
        arrays: &Arrays<f32>,
        cos_alpha: f64,
    ) -> Vec<[f32; SERIES]> {
        let mut values = Vec::new();
        for at in (0..arrays.x_um.len()).step_by(S::f32s::LEN) {
            let [s, p] = from.at(simd, arrays, at, splat(simd, cos_alpha));
            values.extend((0..S::f32s::LEN).map(|i| [s.re[i], s.im[i], p.re[i], p.im[i]]));
        }
        values
    }

    #[test]
    fn series_give_what_the_stacks_give_at_any_angle() {
        for species in ["rock-dove", "starling", "bronzewing", "hummingbird"] {
            let model = SpeciesModel::builtin(species, None, Library::builtin()).unwrap();
            let section = model.section(1, 0).unwrap();
            let points = Points::new(&section, 0.1, Window::Gaussian).unwrap();
            // One ray per point: nothing is averaged.
            let rays = Rays::cast(&section, 0.1, 1, None).unwrap();
            let table = ReflectanceTable::new(Width::best(), &points, &rays, 437.0, &Unobserved).unwrap();
            let optics = points.optics::<f32>(437.0).unwrap();
            for cos_alpha in [0.0015, 0.01, 0.1, 0.3, 0.55, 0.8, 0.97, 1.0] {
                let arrays = &points.single;
                let series = dispatch!(Width::best().0, simd => evaluate(simd, &table, arrays, cos_alpha));
                let exact = dispatch!(Width::best().0, simd => evaluate(simd, &optics, arrays, cos_alpha));
                let worst = series[..points.count]
                    .iter()
                    .flatten()
                    .zip(exact.iter().flatten())
                    .fold(0f32, |worst, (a, b)| worst.max((a - b).abs()));
                // What series leave out, and the rounding of single precision on both sides.
                assert!(worst < 1e-4, "{species} {cos_alpha}: {worst}");
            }
        }
    }
}
