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

use fearless_simd::prelude::*;

use super::points::{Optics, SlotIndex, Surface};
use crate::math::simd::{Complex, Lanes, decay, root, sin_cos};

/// Points that are reflected together; every array of a [`Surface`] is padded to a multiple of it.
pub(crate) const BLOCK: usize = 64;

/// Real numbers per point: 2 polarizations × (J_x, J_y, J_z, M_x, M_y, M_z) × (re, im).
pub(crate) const COMPONENTS: usize = 24;

/// Currents of one block, `[component][point]`.
pub(crate) type Currents = [[f64; BLOCK]; COMPONENTS];

/// Interfaces after which numerator and denominator of the reflectance are rescaled: (4·8)^24 is far from overflow.
const RESCALE_EVERY: usize = 24;

/// The incident wave in numbers that do not depend on the point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Incidence {
    sin_theta: f64,
    cos_theta: f64,
    sin_phi: f64,
    cos_phi: f64,
}

impl Incidence {
    pub(crate) fn new(theta_i: f64, phi_i: f64) -> Self {
        let (sin_theta, cos_theta) = theta_i.sin_cos();
        let (sin_phi, cos_phi) = phi_i.sin_cos();
        Self { sin_theta, cos_theta, sin_phi, cos_phi }
    }

    /// n·ω_i at a point whose tangent is (t_x, t_z), so n = (−t_z, t_x).
    pub(crate) fn cos_alpha(&self, tangent_x: f64, tangent_z: f64) -> f64 {
        self.cos_theta * (self.cos_phi * tangent_x - self.sin_phi * tangent_z)
    }
}

/// The currents g·J·dl and g·M·dl of the points `start` … `start + BLOCK`, for both incident polarizations.
///
/// `extra_phase` (rad, per point) is added to the phase of the incident wave.
#[inline(always)]
pub(crate) fn reflect_block<S: Simd>(
    simd: S,
    surface: &Surface,
    optics: &Optics,
    incidence: &Incidence,
    extra_phase: &[f64],
    start: usize,
    out: &mut Currents,
) {
    let lanes = S::f64s::LEN;
    let splat = |value: f64| S::f64s::splat(simd, value);
    let zero = splat(0.0);
    let load = |values: &[f64], at: usize| S::f64s::from_slice(simd, &values[at..at + lanes]);
    let Incidence { sin_theta, cos_theta, sin_phi, cos_phi } = *incidence;
    for offset in (0..BLOCK).step_by(lanes) {
        let at = start + offset;
        let (tangent_x, tangent_z) = (load(&surface.tangent_x, at), load(&surface.tangent_z, at));
        // ω_i in the local frame.
        let cos_alpha = (tangent_x * cos_phi - tangent_z * sin_phi) * cos_theta;
        let lit = cos_alpha.simd_gt(zero);
        let cos_alpha = cos_alpha.max(splat(1e-9));
        let omega_t = (tangent_x * sin_phi + tangent_z * cos_phi) * cos_theta;
        let omega_y = splat(sin_theta);
        let sin_squared = omega_t.mul_add(omega_t, omega_y * omega_y);
        // ŝ; at exactly normal incidence any direction does.
        let degenerate = sin_squared.simd_le(splat(1e-24));
        let length = sin_squared.max(splat(1e-24)).sqrt();
        let s_t = degenerate.select(zero, -omega_y / length);
        let s_y = degenerate.select(splat(1.0), omega_t / length);

        let (r_s, r_p) = reflectances::<S, S::f64s>(simd, surface, optics, at, cos_alpha, sin_squared);

        let path = (load(&surface.x_um, at) * sin_phi + load(&surface.z_um, at) * cos_phi) * cos_theta;
        let phase = path.mul_add(splat(-optics.k), load(extra_phase, at));
        let (sin, cos) = sin_cos::<S, S::f64s>(simd, phase);
        let weight = lit.select(load(&surface.window_length_um, at), zero);
        let wave = Complex { re: cos * weight, im: sin * weight };
        let s_wave = r_s.mul::<S>(wave);
        let p_wave = r_p.mul::<S>(wave);

        // E_s and H_s of the two incident polarizations: (a, b) and (b, −a) with a = e₁·ŝ, b = e₂·ŝ.
        let e1_t = (tangent_x * sin_phi + tangent_z * cos_phi) * -sin_theta;
        let e2_t = tangent_x * cos_phi - tangent_z * sin_phi;
        let a = e1_t.mul_add(s_t, s_y * cos_theta);
        let b = e2_t * s_t;
        for (polarization, (e_s, h_s)) in [(a, b), (b, -a)].into_iter().enumerate() {
            let electric = s_wave.scale::<S>(e_s);
            let magnetic = p_wave.scale::<S>(h_s);
            let (c_t, c_y) = (cos_alpha * s_t, cos_alpha * s_y);
            let combine = |m: S::f64s, e: S::f64s| magnetic.scale::<S>(m).add::<S>(electric.scale::<S>(e));
            let j_t = combine(-s_y, -c_t);
            let j_y = combine(s_t, -c_y);
            let m_t = combine(-c_t, s_y);
            let m_y = combine(-c_y, -s_t);
            let vectors = [
                j_t.scale::<S>(tangent_x),
                j_y,
                j_t.scale::<S>(tangent_z),
                m_t.scale::<S>(tangent_x),
                m_y,
                m_t.scale::<S>(tangent_z),
            ];
            for (component, value) in vectors.into_iter().enumerate() {
                let row = polarization * 12 + component * 2;
                value.re.store_slice(&mut out[row][offset..offset + lanes]);
                value.im.store_slice(&mut out[row + 1][offset..offset + lanes]);
            }
        }
    }
}

/// r_s and r_p of the stacks under the points `at` …, as ratios of E and of H perpendicular to the plane of incidence.
///
/// The recursion of the theory page, from the substrate up, kept as numerator and denominator so that an interface
/// costs no division: Γ = N/D → (a D + b N e)/(b D + a N e) with r = a/b and e the round trip through the layer below.
#[inline(always)]
fn reflectances<S: Simd, V: Lanes<S>>(
    simd: S,
    surface: &Surface,
    optics: &Optics,
    at: usize,
    cos_alpha: V,
    sin_squared: V,
) -> (Complex<V>, Complex<V>) {
    let lanes = V::LEN;
    let splat = |value: f64| V::splat(simd, value);
    let permittivity = |slot: usize| match &optics.slots[slot] {
        SlotIndex::Uniform(value) => Complex { re: splat(value.re), im: splat(value.im) },
        SlotIndex::Varying { re, im } => Complex {
            re: V::from_slice(simd, &re[at..at + lanes]),
            im: V::from_slice(simd, &im[at..at + lanes]),
        },
    };
    let transverse = |eps: Complex<V>| root::<S, V>(simd, Complex { re: eps.re - sin_squared, im: eps.im });
    let air = (Complex { re: splat(1.0), im: splat(0.0) }, Complex { re: cos_alpha, im: splat(0.0) });

    let last = surface.slots - 1;
    let mut below_eps = permittivity(last);
    let mut below_q = transverse(below_eps);
    let zero = Complex { re: splat(0.0), im: splat(0.0) };
    let (mut s_top, mut s_bottom) = (zero, Complex { re: splat(1.0), im: splat(0.0) });
    let (mut p_top, mut p_bottom) = (s_top, s_bottom);
    for interface in (0..=last).rev() {
        let (eps, q) = if interface == 0 {
            air
        } else {
            let eps = permittivity(interface - 1);
            (eps, transverse(eps))
        };
        if interface < last {
            // The layer just below this interface.
            let thickness = V::from_slice(simd, surface.thickness(interface, at, lanes));
            let twice = thickness * (2.0 * optics.k);
            let (sin, cos) = sin_cos::<S, V>(simd, below_q.re * twice);
            let size = decay::<S, V>(simd, below_q.im * twice);
            let trip = Complex { re: cos * size, im: sin * size };
            s_top = s_top.mul::<S>(trip);
            p_top = p_top.mul::<S>(trip);
        }
        let (a, b) = (q.sub::<S>(below_q), q.add::<S>(below_q));
        (s_top, s_bottom) = (
            a.mul_add::<S>(s_bottom, b.mul::<S>(s_top)),
            b.mul_add::<S>(s_bottom, a.mul::<S>(s_top)),
        );
        let (x, y) = (below_eps.mul::<S>(q), eps.mul::<S>(below_q));
        let (a, b) = (x.sub::<S>(y), x.add::<S>(y));
        (p_top, p_bottom) = (
            a.mul_add::<S>(p_bottom, b.mul::<S>(p_top)),
            b.mul_add::<S>(p_bottom, a.mul::<S>(p_top)),
        );
        if interface % RESCALE_EVERY == 1 {
            for (top, bottom) in [(&mut s_top, &mut s_bottom), (&mut p_top, &mut p_bottom)] {
                let size = splat(1.0) / bottom.re.abs().max(bottom.im.abs());
                *top = top.scale::<S>(size);
                *bottom = bottom.scale::<S>(size);
            }
        }
        (below_eps, below_q) = (eps, q);
    }
    (s_top.div::<S>(s_bottom), p_top.div::<S>(p_bottom))
}
