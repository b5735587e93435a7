//! Local reflection: at each point of the top, the currents that the ideal stack under it would carry.
//!
//! With t the tangent, y the barbule's axis and n the outward normal (t, y, n right-handed), S = n × ω_i =
//! (−ω_y, ω_t) in (t, y). The s part of the incident field lies along ŝ = S/|S|; the p part has its magnetic field
//! there. The reflected currents are
//!
//! ```text
//! J =  n × H̃_r =  r_p H_s (n × ŝ) − r_s E_s cosα ŝ
//! M = −n × E_r = −r_s E_s (n × ŝ) − r_p H_s cosα ŝ,      n × ŝ = (−s_y, s_t)
//! ```

use fearless_simd::{dispatch, prelude::*};
use num_complex::Complex64;

use super::points::{Arrays, Optics, SlotMedium};
use crate::math::simd::{Complex, Lanes, Real, Width, decay, load, root, sin_cos, splat};

/// What gives the reflectances r_s and r_p of the stacks under points, as ratios of E and of H perpendicular to the
/// plane of incidence.
pub(super) trait Reflectances<T: Real> {
    /// Of the points `at` …, for light at local incidence angles α.
    fn at<S: Simd>(
        &self,
        simd: S,
        arrays: &Arrays<T>,
        at: usize,
        cos_alpha: T::Native<S>,
    ) -> [Complex<T::Native<S>>; 2];

    /// Of the same points for light from several directions.
    #[inline(always)]
    fn at_each<S: Simd, const G: usize>(
        &self,
        simd: S,
        arrays: &Arrays<T>,
        at: usize,
        cos_alpha: [T::Native<S>; G],
    ) -> [[Complex<T::Native<S>>; 2]; G] {
        let mut reflected = none(simd);
        for (reflected, cos_alpha) in reflected.iter_mut().zip(cos_alpha) {
            *reflected = self.at(simd, arrays, at, cos_alpha);
        }
        reflected
    }
}

/// No reflection, to be filled in: loops are inlined into kernels, closures over arrays not always.
#[inline(always)]
pub(super) fn none<S: Simd, V: Lanes<S>, const G: usize>(simd: S) -> [[Complex<V>; 2]; G] {
    [[Complex { re: splat(simd, 0.0), im: splat(simd, 0.0) }; 2]; G]
}

impl<T: Real> Reflectances<T> for Optics<T> {
    #[inline(always)]
    fn at<S: Simd>(
        &self,
        simd: S,
        arrays: &Arrays<T>,
        at: usize,
        cos_alpha: T::Native<S>,
    ) -> [Complex<T::Native<S>>; 2] {
        let (thickness_um, padded) = (&arrays.thickness_um, arrays.x_um.len());
        stack_reflectances::<S, T::Native<S>>(simd, thickness_um, padded, self, at, cos_alpha)
    }
}

/// Points that are reflected together; every array over the points is padded to a multiple of it.
pub(super) const BLOCK: usize = 64;

/// Real numbers per point: 2 polarizations × (J_x, J_y, J_z, M_x, M_y, M_z) × (re, im).
pub(super) const COMPONENTS: usize = 24;

/// Currents of one block, `[component][point]`.
pub(super) type Currents<T> = [[T; BLOCK]; COMPONENTS];

/// Interfaces after which numerator and denominator of the reflectance are rescaled: with magnitudes up to 20 per
/// interface, six stay within single precision.
pub(super) const RESCALE_EVERY: usize = 6;

/// r_s and r_p as numerators and denominators.
pub(super) type Fractions<V> = [(Complex<V>, Complex<V>); 2];

/// The incident wave in numbers that do not depend on the point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Incidence {
    /// φ_i, rad.
    pub(super) phi: f64,
    sin_theta: f64,
    cos_theta: f64,
    sin_phi: f64,
    cos_phi: f64,
}

impl Incidence {
    pub(super) fn new(theta_i: f64, phi_i: f64) -> Self {
        let (sin_theta, cos_theta) = theta_i.sin_cos();
        let (sin_phi, cos_phi) = phi_i.sin_cos();
        Self { phi: phi_i, sin_theta, cos_theta, sin_phi, cos_phi }
    }

    pub(super) fn sin_phi(&self) -> f64 {
        self.sin_phi
    }

    pub(super) fn cos_phi(&self) -> f64 {
        self.cos_phi
    }

    /// n·ω_i at a point whose tangent is (t_x, t_z), so n = (−t_z, t_x).
    pub(super) fn cos_alpha(&self, tangent_x: f64, tangent_z: f64) -> f64 {
        self.cos_theta * (self.cos_phi * tangent_x - self.sin_phi * tangent_z)
    }
}

/// Points under light from one direction.
#[derive(Clone, Copy)]
pub(super) struct Lit<'a, T> {
    pub(super) arrays: &'a Arrays<T>,
    /// Height of each point over the place from which its current radiates.
    pub(super) rise_um: &'a [T],
    /// Vacuum wave number, rad/µm.
    pub(super) k: f64,
    pub(super) incidence: Incidence,
}

/// Directions whose reflectances are read from tables together: what a table says of points is then loaded once for all.
pub(super) const TOGETHER: usize = 4;

/// The currents g·J·dl and g·M·dl of the stacks under the points `start` … `start + BLOCK`, for both incident
/// polarizations, under light from each of some directions.
///
/// The rise counts as a phase for light to the mirror direction φ_o = −φ_i.
#[inline(always)]
pub(super) fn reflect_block<S: Simd, T: Real, const G: usize>(
    simd: S,
    lights: &[Lit<'_, T>; G],
    reflectances: &impl Reflectances<T>,
    start: usize,
    out: &mut [Currents<T>; G],
) {
    let arrays = lights[0].arrays;
    let lanes = T::Native::<S>::LEN;
    for offset in (0..BLOCK).step_by(lanes) {
        let at = start + offset;
        let mut cosines = [splat::<S, T::Native<S>>(simd, 0.0); G];
        for (cosine, lit) in cosines.iter_mut().zip(lights) {
            *cosine =
                cos_alpha(simd, arrays, at, &lit.incidence).max(splat::<S, T::Native<S>>(simd, T::GRAZING));
        }
        let reflected = reflectances.at_each(simd, arrays, at, cosines);
        for ((lit, reflected), out) in lights.iter().zip(reflected).zip(&mut *out) {
            reflect(simd, lit, reflected, at, offset, out);
        }
    }
}

/// n·ω_i of the points `at` ….
#[inline(always)]
fn cos_alpha<S: Simd, T: Real>(
    simd: S,
    arrays: &Arrays<T>,
    at: usize,
    incidence: &Incidence,
) -> T::Native<S> {
    let tangent_x: T::Native<S> = load(simd, &arrays.tangent_x, at);
    let tangent_z: T::Native<S> = load(simd, &arrays.tangent_z, at);
    let [sin_phi, cos_phi, cos_theta]: [T::Native<S>; 3] =
        [incidence.sin_phi, incidence.cos_phi, incidence.cos_theta].map(|value| splat(simd, value));
    (tangent_x * cos_phi - tangent_z * sin_phi) * cos_theta
}

/// The currents of the points `at` … with these reflectances, which stand from `offset` on in their block.
#[inline(always)]
fn reflect<S: Simd, T: Real>(
    simd: S,
    lit: &Lit<'_, T>,
    [r_s, r_p]: [Complex<T::Native<S>>; 2],
    at: usize,
    offset: usize,
    out: &mut Currents<T>,
) {
    let Lit { arrays, rise_um, k, incidence } = *lit;
    let lanes = T::Native::<S>::LEN;
    let zero: T::Native<S> = splat(simd, 0.0);
    let sin_theta: T::Native<S> = splat(simd, incidence.sin_theta);
    let cos_theta: T::Native<S> = splat(simd, incidence.cos_theta);
    let sin_phi: T::Native<S> = splat(simd, incidence.sin_phi);
    let cos_phi: T::Native<S> = splat(simd, incidence.cos_phi);
    let backward: T::Native<S> = splat(simd, -k);
    let tangent_x: T::Native<S> = load(simd, &arrays.tangent_x, at);
    let tangent_z: T::Native<S> = load(simd, &arrays.tangent_z, at);
    // ω_i in the local frame.
    let cos_alpha = cos_alpha(simd, arrays, at, &incidence);
    let lit = cos_alpha.simd_gt(zero);
    let cos_alpha = cos_alpha.max(splat::<S, T::Native<S>>(simd, T::GRAZING));
    let omega_t = (tangent_x * sin_phi + tangent_z * cos_phi) * cos_theta;
    let omega_y = sin_theta;
    let sin_squared = omega_t.mul_add(omega_t, omega_y * omega_y);
    // ŝ; at exactly normal incidence any direction does.
    let least: T::Native<S> = splat(simd, 1e-24);
    let degenerate = sin_squared.simd_le(least);
    let length = sin_squared.max(least).sqrt();
    let s_t = degenerate.select(zero, -omega_y / length);
    let s_y = degenerate.select(splat(simd, 1.0), omega_t / length);

    let x: T::Native<S> = load(simd, &arrays.x_um, at);
    let z: T::Native<S> = load(simd, &arrays.z_um, at);
    let path = (x * sin_phi + z * cos_phi) * cos_theta;
    let rise: T::Native<S> = load(simd, rise_um, at);
    let phase = rise.mul_add(cos_theta * cos_phi, path) * backward;
    let (sin, cos) = sin_cos::<S, T::Native<S>>(simd, phase);
    let weight = lit.select(load(simd, &arrays.window_length_um, at), zero);
    let wave = Complex { re: cos * weight, im: sin * weight };
    let s_wave = r_s.times::<S>(wave);
    let p_wave = r_p.times::<S>(wave);

    // E_s and H_s of the two incident polarizations: (a, b) and (b, −a) with a = e₁·ŝ, b = e₂·ŝ.
    let e1_t = (tangent_x * sin_phi + tangent_z * cos_phi) * (-sin_theta);
    let e2_t = tangent_x * cos_phi - tangent_z * sin_phi;
    let a = e1_t.mul_add(s_t, s_y * cos_theta);
    let b = e2_t * s_t;
    let (c_t, c_y) = (cos_alpha * s_t, cos_alpha * s_y);
    let (first, second) = out.split_at_mut(COMPONENTS / 2);
    for (rows, e_s, h_s) in [(first, a, b), (second, b, -a)] {
        let electric = s_wave.scale::<S>(e_s);
        let magnetic = p_wave.scale::<S>(h_s);
        let j_t = weighted::<S, T::Native<S>>(magnetic, -s_y, electric, -c_t);
        let j_y = weighted::<S, T::Native<S>>(magnetic, s_t, electric, -c_y);
        let m_t = weighted::<S, T::Native<S>>(magnetic, -c_t, electric, s_y);
        let m_y = weighted::<S, T::Native<S>>(magnetic, -c_y, electric, -s_t);
        let vectors = [
            j_t.scale::<S>(tangent_x),
            j_y,
            j_t.scale::<S>(tangent_z),
            m_t.scale::<S>(tangent_x),
            m_y,
            m_t.scale::<S>(tangent_z),
        ];
        for (pair, value) in rows.chunks_exact_mut(2).zip(vectors) {
            value.re.store_slice(&mut pair[0][offset..offset + lanes]);
            value.im.store_slice(&mut pair[1][offset..offset + lanes]);
        }
    }
}

/// x·a + y·b for real a and b.
#[inline(always)]
fn weighted<S: Simd, V: Lanes<S>>(x: Complex<V>, a: V, y: Complex<V>, b: V) -> Complex<V> {
    x.scale::<S>(a).plus::<S>(y.scale::<S>(b))
}

/// Adds r_s and r_p (re, im of each) of stacks at cosines of their local angles of incidence to `out`; `thickness_um` is
/// `[slot][point]`, and points fill whole vectors of [`LANES`].
pub(in crate::solve) fn add_reflectances(
    width: Width,
    optics: &Optics<f64>,
    thickness_um: &[f64],
    cos_alpha: &[f64],
    out: &mut [Vec<f64>; 4],
) {
    dispatch!(width.0, simd => add_reflectances_of(simd, optics, thickness_um, cos_alpha, out));
}

/// The widest vector of double precision.
pub(in crate::solve) const LANES: usize = 8;

#[inline(always)]
fn add_reflectances_of<S: Simd>(
    simd: S,
    optics: &Optics<f64>,
    thickness_um: &[f64],
    cos_alpha: &[f64],
    out: &mut [Vec<f64>; 4],
) {
    let lanes = S::f64s::LEN;
    let [s_re, s_im, p_re, p_im] = out;
    for at in (0..cos_alpha.len()).step_by(lanes) {
        let cosine = load::<S, S::f64s>(simd, cos_alpha, at).max(splat::<S, S::f64s>(simd, f64::GRAZING));
        let [r_s, r_p] =
            stack_reflectances::<S, S::f64s>(simd, thickness_um, cos_alpha.len(), optics, at, cosine);
        (load::<S, S::f64s>(simd, s_re, at) + r_s.re).store_slice(&mut s_re[at..at + lanes]);
        (load::<S, S::f64s>(simd, s_im, at) + r_s.im).store_slice(&mut s_im[at..at + lanes]);
        (load::<S, S::f64s>(simd, p_re, at) + r_p.re).store_slice(&mut p_re[at..at + lanes]);
        (load::<S, S::f64s>(simd, p_im, at) + r_p.im).store_slice(&mut p_im[at..at + lanes]);
    }
}

/// The permittivity and q = √(ε − sin²α) of a medium given as ε − 1, so that nothing cancels in air at grazing angles.
#[inline(always)]
pub(super) fn layer<S: Simd, V: Lanes<S>>(
    simd: S,
    contrast: Complex<V>,
    cos_squared: V,
) -> (Complex<V>, Complex<V>) {
    let eps = Complex { re: contrast.re + splat::<S, V>(simd, 1.0), im: contrast.im };
    (eps, root::<S, V>(simd, Complex { re: contrast.re + cos_squared, im: contrast.im }))
}

/// ε − 1 of a slot at the points `at` ….
#[inline(always)]
fn contrast<S: Simd, V: Lanes<S>>(simd: S, slot: &SlotMedium<V::Element>, at: usize) -> Complex<V> {
    match slot {
        SlotMedium::Uniform(value) => Complex { re: splat(simd, value.re), im: splat(simd, value.im) },
        SlotMedium::Varying { re, im } => Complex { re: load(simd, re, at), im: load(simd, im, at) },
    }
}

/// r_s and r_p of the stacks under the points `at` …; `thickness_um` is `[slot][padded]`.
///
/// The recursion of the theory page, from the substrate up, kept as numerator and denominator so that an interface
/// costs no division: Γ = N/D → (a D + b N e)/(b D + a N e) with r = a/b and e the round trip through the layer below.
#[inline(always)]
fn stack_reflectances<S: Simd, V: Lanes<S>>(
    simd: S,
    thickness_um: &[V::Element],
    padded: usize,
    optics: &Optics<V::Element>,
    at: usize,
    cos_alpha: V,
) -> [Complex<V>; 2] {
    let one: V = splat(simd, 1.0);
    let zero: V = splat(simd, 0.0);
    let last = optics.slots.len() - 1;
    let twice_k: V = splat(simd, 2.0 * optics.k);
    let cos_squared = cos_alpha * cos_alpha;
    let air = (Complex { re: one, im: zero }, Complex { re: cos_alpha, im: zero });
    let (mut below_eps, mut below_q) = layer(simd, contrast(simd, &optics.slots[last], at), cos_squared);
    let mut fractions = [(Complex { re: zero, im: zero }, Complex { re: one, im: zero }); 2];
    for interface in (0..=last).rev() {
        let (eps, q) = if interface == 0 {
            air
        } else {
            layer(simd, contrast(simd, &optics.slots[interface - 1], at), cos_squared)
        };
        if interface < last {
            // The layer just below this interface.
            let twice = load::<S, V>(simd, thickness_um, interface * padded + at) * twice_k;
            let trip = round_trip::<S, V>(simd, below_q, twice);
            for (top, _) in &mut fractions {
                *top = top.times::<S>(trip);
            }
        }
        cross::<S, V>((eps, q), (below_eps, below_q), &mut fractions);
        if interface % RESCALE_EVERY == 1 {
            rescale::<S, V>(simd, &mut fractions);
        }
        (below_eps, below_q) = (eps, q);
    }
    reflectances_of::<S, V>(fractions)
}

/// The same ε and q in every lane.
#[inline(always)]
pub(super) fn lanes<S: Simd, V: Lanes<S>>(
    simd: S,
    (eps, q): (Complex64, Complex64),
) -> (Complex<V>, Complex<V>) {
    (
        Complex { re: splat(simd, eps.re), im: splat(simd, eps.im) },
        Complex { re: splat(simd, q.re), im: splat(simd, q.im) },
    )
}

/// e^{2jkqd}, with 2kd given.
#[inline(always)]
fn round_trip<S: Simd, V: Lanes<S>>(simd: S, q: Complex<V>, twice: V) -> Complex<V> {
    let (sin, cos) = sin_cos::<S, V>(simd, q.re * twice);
    let size = decay::<S, V>(simd, q.im * twice);
    Complex { re: cos * size, im: sin * size }
}

/// Takes the fractions of r_s and r_p through the interface between two media.
#[inline(always)]
pub(super) fn cross<S: Simd, V: Lanes<S>>(
    (eps, q): (Complex<V>, Complex<V>),
    (below_eps, below_q): (Complex<V>, Complex<V>),
    fractions: &mut Fractions<V>,
) {
    let (x, y) = (below_eps.times::<S>(q), eps.times::<S>(below_q));
    let pairs = [(q.minus::<S>(below_q), q.plus::<S>(below_q)), (x.minus::<S>(y), x.plus::<S>(y))];
    for ((top, bottom), (a, b)) in fractions.iter_mut().zip(pairs) {
        (*top, *bottom) =
            (a.mul_add::<S>(*bottom, b.times::<S>(*top)), b.mul_add::<S>(*bottom, a.times::<S>(*top)));
    }
}

/// Brings the denominators of fractions near 1.
#[inline(always)]
pub(super) fn rescale<S: Simd, V: Lanes<S>>(simd: S, fractions: &mut Fractions<V>) {
    for (top, bottom) in fractions {
        let size = splat::<S, V>(simd, 1.0) / bottom.re.abs().max(bottom.im.abs());
        (*top, *bottom) = (top.scale::<S>(size), bottom.scale::<S>(size));
    }
}

#[inline(always)]
pub(super) fn reflectances_of<S: Simd, V: Lanes<S>>(
    [(s_top, s_bottom), (p_top, p_bottom)]: Fractions<V>,
) -> [Complex<V>; 2] {
    [s_top.over::<S>(s_bottom), p_top.over::<S>(p_bottom)]
}
