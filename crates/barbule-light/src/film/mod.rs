//! Planar multilayers, exactly: reflection, transmission and what each layer absorbs.
//!
//! Exact for flat, infinitely wide layers at any angle, and so the reference for the other solvers. Nothing grows
//! exponentially: the tangential fields are carried from the exit to the entry, each layer's step divided by the
//! decay of the wave in it.
//!
//! Amplitudes of s belong to E, those of p to H̃, both perpendicular to the plane of incidence, so at normal
//! incidence r_p = −r_s.

mod ensemble;
pub mod gradient;
mod sweep;

pub use ensemble::{Deviations, Ensemble, ensemble};
pub use sweep::{FilmTables, Sweep, bytes, sweep};

use crate::stack::Stack;
use crate::{Complex64, Error, Result};

/// Which field is perpendicular to the plane of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarization {
    /// E is perpendicular to it.
    S,
    /// H̃ is perpendicular to it.
    P,
}

impl Polarization {
    /// s, then p.
    pub const BOTH: [Self; 2] = [Self::S, Self::P];
}

/// What becomes of one plane wave of unit power.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmResponse {
    /// Reflected over incident amplitude (s: of E, p: of H̃).
    pub r: Complex64,
    /// Transmitted over incident amplitude (s: of E, p: of H̃) at the last interface.
    pub t: Complex64,
    /// The reflected part of the power along z, |r|².
    pub reflected: f64,
    /// The part that enters the exit medium.
    pub transmitted: f64,
    /// The part absorbed in all layers: the sum of `absorbed_per_layer`.
    pub absorbed: f64,
    /// The part absorbed in each layer from the entry side, the power that enters it minus the power that leaves.
    pub absorbed_per_layer: Vec<f64>,
}

/// The response of a stack at one wavelength (nm), angle (rad) and polarization.
///
/// `angle` is in the entry medium, from the normal; its sign does not matter.
///
/// # Errors
/// |angle| ≥ π/2, an absorbing entry medium, a medium without an index at this wavelength, gain, an exact
/// resonance of lossless media, where the response is infinite, or numbers that give more than all light.
pub fn response(
    stack: &Stack,
    wavelength_nm: f64,
    angle: f64,
    polarization: Polarization,
) -> Result<FilmResponse> {
    let indices = stack.indices(wavelength_nm)?;
    response_at(&indices, stack.thickness_nm(), wavelength_nm, angle, polarization)
}

/// As [`response`], from the refractive `indices` of all regions (entry, layers, exit) at this wavelength.
///
/// # Errors
/// As [`response`], or the numbers of indices and thicknesses do not fit.
pub fn response_at(
    indices: &[Complex64],
    thickness_nm: &[f64],
    wavelength_nm: f64,
    angle: f64,
    polarization: Polarization,
) -> Result<FilmResponse> {
    let entry = entry(indices, thickness_nm, wavelength_nm, angle, polarization)?;
    let layers = thickness_nm.len();
    let mut fields = Fields::at_exit(entry.admittance(indices[layers + 1]));
    let transmitted = fields.flux();
    // Power that flows down through the top of each layer, with its scale, until the incident power is known.
    let mut flux = vec![(0.0, Scale::default()); layers];
    for layer in (0..layers).rev() {
        fields.climb(&entry, indices[layer + 1], thickness_nm[layer]);
        flux[layer] = (fields.flux(), fields.scale);
    }
    let (r, incident) = fields.split(&entry);
    let per_incident =
        |flux: f64, scale: Scale| flux * scale.power_below(fields.scale) / (entry.y * incident.norm_sqr());
    let mut below = per_incident(transmitted, Scale::default());
    let transmitted = below;
    let mut absorbed_per_layer = vec![0.0; layers];
    for layer in (0..layers).rev() {
        let above = per_incident(flux[layer].0, flux[layer].1);
        absorbed_per_layer[layer] = above - below;
        below = above;
    }
    let t = fields.scale.amplitude_below() / incident;
    let result = FilmResponse {
        r,
        t,
        reflected: r.norm_sqr(),
        transmitted,
        absorbed: absorbed_per_layer.iter().sum(),
        absorbed_per_layer,
    };
    if !(result.r.is_finite() && result.transmitted.is_finite() && result.absorbed.is_finite()) {
        return Err(resonance(wavelength_nm));
    }
    check_balance([result.reflected, result.transmitted], wavelength_nm, angle, polarization)?;
    Ok(result)
}

/// Only the reflected amplitude, without allocation; arguments as for [`response_at`].
///
/// # Errors
/// As [`response_at`].
pub fn reflect(
    indices: &[Complex64],
    thickness_nm: &[f64],
    wavelength_nm: f64,
    angle: f64,
    polarization: Polarization,
) -> Result<Complex64> {
    let entry = entry(indices, thickness_nm, wavelength_nm, angle, polarization)?;
    let layers = thickness_nm.len();
    let mut fields = Fields::at_exit(entry.admittance(indices[layers + 1]));
    for layer in (0..layers).rev() {
        fields.climb(&entry, indices[layer + 1], thickness_nm[layer]);
    }
    let (r, _) = fields.split(&entry);
    if !r.is_finite() {
        return Err(resonance(wavelength_nm));
    }
    check_balance([r.norm_sqr(), 0.0], wavelength_nm, angle, polarization)?;
    Ok(r)
}

/// The cosine times the index, q = n·cosα, in a medium of index `n` for a wave that comes from a medium of real index `entry`, where its
/// q² is `entry_q_squared`: Re q ≥ 0 and Im q ≥ 0.
///
/// q² = (n − n₀)(n + n₀) + (n₀ cosα₀)² keeps the digits that n² − (n₀ sinα₀)² loses near grazing.
fn normal_index(n: Complex64, entry: f64, entry_q_squared: f64) -> Complex64 {
    let squared = (n - entry) * (n + entry) + entry_q_squared;
    // A lossless evanescent wave decays: rounding must not turn its root around.
    let im = if squared.im > 0.0 { squared.im } else { 0.0 };
    upper_root(squared.re, im)
}

/// The square root of re + j·im with im ≥ 0, both parts ≥ 0 and correct to the last digits.
fn upper_root(re: f64, im: f64) -> Complex64 {
    let size = ((re.hypot(im) + re.abs()) / 2.0).sqrt();
    if size == 0.0 {
        Complex64::new(0.0, 0.0)
    } else if re >= 0.0 {
        Complex64::new(size, im / (2.0 * size))
    } else {
        Complex64::new(im / (2.0 * size), size)
    }
}

/// exp(z) − 1 without loss of digits near 0.
fn exp_m1(z: Complex64) -> Complex64 {
    let half = (z.im / 2.0).sin();
    let grown = z.re.exp();
    Complex64::new(z.re.exp_m1() - 2.0 * grown * half * half, grown * z.im.sin())
}

/// By how much parts of the power may be below 0 or above 1: a hundred times what extreme stacks of passive media were seen to be off
/// (n from 0.05 to 4, k to 60, layers to 100 µm, angles to 89.999999°).
const MOST_GAIN: f64 = 1e-5;

/// Refuses more light than falls in, or less than none, which no media without gain can make.
fn check_balance(
    [reflected, transmitted]: [f64; 2],
    wavelength_nm: f64,
    angle: f64,
    polarization: Polarization,
) -> Result<()> {
    let parts = [reflected, transmitted, reflected + transmitted];
    if parts.iter().all(|part| (-MOST_GAIN..=1.0 + MOST_GAIN).contains(part)) {
        return Ok(());
    }
    let name = match polarization {
        Polarization::S => "s",
        Polarization::P => "p",
    };
    Err(Error::not_settled(format!(
        "at {wavelength_nm} nm and {}° the stack reflects {reflected:.6} and transmits {transmitted:.6} of {name}-polarized light, which passive media cannot: the numbers of this stack are beyond what can be computed",
        angle.to_degrees()
    )))
}

fn resonance(wavelength_nm: f64) -> Error {
    Error::not_settled(format!(
        "the stack resonates without loss at {wavelength_nm} nm and this angle, so its response is infinite; change the angle or give a medium some absorption"
    ))
}

/// What all layers need to know of the incident wave.
struct Entry {
    index: f64,
    q_squared: f64,
    /// Admittance of the incident wave.
    y: f64,
    /// 2π/λ in 1/nm.
    k: f64,
    polarization: Polarization,
}

fn entry(
    indices: &[Complex64],
    thickness_nm: &[f64],
    wavelength_nm: f64,
    angle: f64,
    polarization: Polarization,
) -> Result<Entry> {
    if indices.len() != thickness_nm.len() + 2 {
        return Err(Error::input(format!(
            "{} indices do not fit {} layers and two half-spaces",
            indices.len(),
            thickness_nm.len()
        )));
    }
    if let Some(bad) = indices.iter().find(|n| n.im < 0.0) {
        return Err(Error::input(format!(
            "the index {bad} has gain, k = {}; absorbing media have k > 0 here",
            bad.im
        )));
    }
    if angle.is_nan() || angle.abs() >= std::f64::consts::FRAC_PI_2 {
        return Err(Error::input(format!(
            "the angle {}° is at or past grazing; give one between -90 and 90",
            angle.to_degrees()
        )));
    }
    let n = indices[0];
    if n.im != 0.0 || n.re.is_nan() || n.re <= 0.0 {
        return Err(Error::input(format!(
            "the entry medium has the index {n}, but it must be real and positive for reflectance to be defined"
        )));
    }
    let q = n.re * angle.cos();
    let y = match polarization {
        Polarization::S => q,
        Polarization::P => q / (n.re * n.re),
    };
    Ok(Entry { index: n.re, q_squared: q * q, y, k: std::f64::consts::TAU / wavelength_nm, polarization })
}

impl Entry {
    fn q(&self, n: Complex64) -> Complex64 {
        normal_index(n, self.index, self.q_squared)
    }

    /// Tangential partner field over the perpendicular one of a wave that goes down: q for s, q/n² for p.
    fn admittance(&self, n: Complex64) -> Complex64 {
        match self.polarization {
            Polarization::S => self.q(n),
            Polarization::P => self.q(n) / (n * n),
        }
    }
}

/// By how much stored fields are smaller than true ones: exp(−j·phase)·2^doublings.
#[derive(Debug, Clone, Copy, Default)]
struct Scale {
    phase: Complex64,
    doublings: i32,
}

impl Scale {
    /// The power of this scale in units of the power of a scale further up, at most about 1.
    fn power_below(self, above: Self) -> f64 {
        let decay = (2.0 * (self.phase.im - above.phase.im)).exp();
        decay * power_of_two(2 * i64::from(self.doublings) - 2 * i64::from(above.doublings))
    }

    /// One over this scale, exp(+j·phase)·2^(−doublings).
    fn amplitude_below(self) -> Complex64 {
        Complex64::from_polar((-self.phase.im).exp(), self.phase.re)
            * power_of_two(-i64::from(self.doublings))
    }
}

fn power_of_two(exponent: i64) -> f64 {
    2.0_f64.powi(exponent.clamp(-2000, 1000) as i32)
}

/// The tangential fields on one plane, in units in which the field at the exit is 1.
struct Fields {
    /// E for s, H̃ for p, perpendicular to the plane of incidence.
    f: Complex64,
    /// The other field's tangential part, so that Re(f* g) is the power that flows down.
    g: Complex64,
    scale: Scale,
}

impl Fields {
    fn at_exit(admittance: Complex64) -> Self {
        Self { f: Complex64::new(1.0, 0.0), g: admittance, scale: Scale::default() }
    }

    fn flux(&self) -> f64 {
        self.f.re * self.g.re + self.f.im * self.g.im
    }

    /// From the bottom of a layer to its top.
    fn climb(&mut self, entry: &Entry, n: Complex64, thickness_nm: f64) {
        let q = entry.q(n);
        let depth = entry.k * thickness_nm;
        let delta = q * depth;
        // 1 − exp(2jδ), and the same over q, which stays finite at the critical angle where q = 0.
        let lost = -exp_m1(Complex64::new(-2.0 * delta.im, 2.0 * delta.re));
        let lost_per_q = if q.norm_sqr() > 1e-200 { lost / q } else { Complex64::new(0.0, -2.0 * depth) };
        let (times_y, over_y) = match entry.polarization {
            Polarization::S => (lost * q, lost_per_q),
            Polarization::P => (lost * q / (n * n), lost_per_q * n * n),
        };
        let kept = Complex64::new(2.0, 0.0) - lost;
        let f = (kept * self.f + over_y * self.g) * 0.5;
        let g = (kept * self.g + times_y * self.f) * 0.5;
        (self.f, self.g) = (f, g);
        self.scale.phase += delta;
        let size = f.norm_sqr() + g.norm_sqr();
        if !(1e-60..1e60).contains(&size) && size > 0.0 {
            let down = (size.log2() / 2.0) as i32;
            let factor = power_of_two(-i64::from(down));
            self.f *= factor;
            self.g *= factor;
            self.scale.doublings += down;
        }
    }

    /// The reflected over the incident amplitude, and the stored incident amplitude.
    fn split(&self, entry: &Entry) -> (Complex64, Complex64) {
        let partner = self.g / entry.y;
        ((self.f - partner) / (self.f + partner), (self.f + partner) * 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_that_no_passive_stack_has_are_refused() {
        let checked = |parts| check_balance(parts, 500.0, 0.3, Polarization::S);
        for fine in [[0.0, 1.0], [1.0, 0.0], [0.4, 0.3], [1.0 + 1e-7, -1e-7]] {
            checked(fine).unwrap();
        }
        for bad in [[1.1, 0.0], [0.6, 0.6], [-0.1, 0.5], [0.5, -0.1], [f64::NAN, 0.0]] {
            let message = checked(bad).unwrap_err().to_string();
            assert!(message.contains("passive media cannot") && message.contains("at 500 nm"), "{message}");
        }
    }
}
