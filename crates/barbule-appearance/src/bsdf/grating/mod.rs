//! A diffraction grating over pigment: the light that a heightfield's orders reflect, in the mean over places, and what comes
//! back diffusely from beneath.
//!
//! f = R Γ S/(λ² π s_f²)/max(1, ρ(ω_i), ρ(ω_o)) + (1 − R(θ_i))(1 − R(θ_o)) d/π
//!
//! S are the orders' powers through the window of coherence ([`crate::scattering::grating`]), a function of the frequency −(ω_i +
//! ω_o)/λ along the surface and of κ. It is a sum over the places about a frequency ([`places`]), which serves values and sampling:
//! frequencies are drawn from a place's probability and what it is spread by.
//!
//! The window is that of the surface alone, however far across it stays in step with itself. Whatever else blurs its light, lamps' discs,
//! the lens, the pixel, paths integrate over.
//!
//! ρ(ω) is what the scalar model makes of all light of one direction, which may be over 1 at grazing incidence: the quotient
//! mends that and stays reciprocal. It is never boosted where ρ < 1: the rest is in orders that do not leave.

mod places;
mod tables;
#[cfg(test)]
pub(super) mod tests;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use places::{MOST_TERMS, Places, SHARE_OF_WINDOW, of_powers};
use rayon::prelude::*;
pub use tables::GratingTables;

use super::hit::Hit;
use super::lobes::Lobes;
use super::reflectance::Reflectance;
use super::{Bsdf, Model};
use crate::fresnel::fresnel;
use crate::scattering::grating::{Coherence, Obliquity, Powers};
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::spectrum::sensor::Band;
use crate::{Error, Result};

/// Most bytes of tables and probabilities.
const MOST_BYTES: u64 = 1 << 30;
/// Window of which ρ is, µm, where the surface's own is wider: ρ is smooth over directions.
const RHO_COHERENCE_UM: f64 = 4.0;
/// Bytes of a place's probabilities.
const PER_PLACE: u64 = 8 * NODES as u64;
/// Values of κ for which orders' probabilities are kept.
const NODES: usize = 12;
/// cosθ, φ and wavelengths of the table of ρ.
const RHO: [usize; 3] = [16, 24, 6];
/// Directions lower than this are as high in ρ, where Γ diverges.
const LOWEST: f64 = 0.02;
const FORM: Obliquity = Obliquity::Kirchhoff;

/// A surface that diffracts.
#[derive(Debug, Clone)]
pub struct Grating(Arc<Tabulated>);

#[derive(Debug)]
struct Tabulated {
    index: f64,
    pigment: Reflectance,
    places: Places,
    /// What sums of powers are multiplied by besides 1/λ²: 1/(π s_f²).
    window: f64,
    densities: Vec<Density>,
    /// `[wavelength][cosθ][φ]`
    rho: Vec<f32>,
}

/// Probabilities of the places at one κ.
#[derive(Debug)]
struct Density {
    /// Of each place.
    share: Vec<f32>,
    /// Sums over the rows up to each.
    rows: Vec<f64>,
    /// Within each row, up to each place.
    columns: Vec<f32>,
}

impl Grating {
    /// Whose wavelengths its tables serve: shorter ones have orders beyond them.
    pub const BAND: Band = Band::HUMAN;

    /// - `coherence_um`: standard deviation of the window of coherence; the narrower, the wider are lobes
    /// - `index`: refractive index of the surface
    /// - `pigment`: colour of what is beneath, linear sRGB, 0 … 1
    ///
    /// # Errors
    /// A number out of range; more orders than memory should be spent on.
    pub fn new(powers: &Arc<Powers>, coherence_um: f64, index: f64, pigment: [f64; 3]) -> Result<Self> {
        if !(1.01..=4.0).contains(&index) {
            return Err(Error::input(format!("a grating's index is {index}; give 1.01 to 4")));
        }
        if !coherence_um.is_finite() || coherence_um <= 0.0 {
            return Err(Error::input(format!("a grating's coherence is {coherence_um} µm; give over 0")));
        }
        let pigment = Reflectance::of_colour(pigment).map_err(|error| error.at("a grating's pigment"))?;
        if powers.terms() > MOST_TERMS {
            return Err(Error::input(format!(
                "a grating of {} terms is too deep to be rendered; at most {MOST_TERMS} are",
                powers.terms()
            )));
        }
        let s_f = |coherence: f64| Coherence::Fixed(coherence).frequency_per_um(1.0);
        let bytes = Self::bytes(powers, coherence_um);
        if bytes > MOST_BYTES {
            return Err(Error::input(format!(
                "a grating's patch of {} × {} µm has so many orders that rendering it takes {:.1} GB; give a smaller patch",
                powers.orders().period_um[0],
                powers.orders().period_um[1],
                bytes as f64 * 1e-9
            )));
        }
        let places = Places::new(powers, of_powers(s_f(coherence_um)));
        let window = places.kept() / (PI * s_f(coherence_um).powi(2));
        let densities = (0..NODES)
            .into_par_iter()
            .map(|node| density(&places, -places.kappa_most() * node as f64 / (NODES - 1) as f64))
            .collect();
        let rho = albedos(&Places::smoothed(powers, of_powers(s_f(coherence_um.min(RHO_COHERENCE_UM)))));
        Ok(Self(Arc::new(Tabulated { index, pigment, places, window, densities, rho })))
    }

    /// Memory that [`Self::new`] takes beside the powers, bytes.
    #[must_use]
    pub fn bytes(powers: &Powers, coherence_um: f64) -> u64 {
        let s_f = Coherence::Fixed(coherence_um).frequency_per_um(1.0);
        let [places, tables] = Places::foretell(powers, of_powers(s_f));
        tables + PER_PLACE * places
    }

    /// At a hit, seen from `wo`.
    #[inline(always)]
    pub(super) fn bind(&self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'_> {
        let side = hit.side(wo);
        let grating = &*self.0;
        let nm = wavelengths.nm();
        let cos_o = side.wo.z.max(0.0);
        let reflectance_o = fresnel(cos_o, grating.index);
        let pigment = grating.pigment.at_each(wavelengths);
        let diffuse = (1.0 - reflectance_o) * grating.pigment.mean();
        let bound = Bound {
            grating,
            um: nm.map(|nm| nm * 1e-3),
            reflectance_o,
            pigment,
            rho_o: nm.map(|nm| grating.rho_at(nm, side.wo)),
            diffuse_share: (diffuse / (diffuse + reflectance_o)).clamp(0.1, 0.9),
            nodes: nm.map(|nm| grating.node(-2.0 * cos_o * TAU / (nm * 1e-3))),
        };
        Bsdf::new(Model::Grating(bound), side)
    }
}

fn density(places: &Places, kappa: f64) -> Density {
    let basis = places.basis(kappa);
    let columns = places.columns();
    let mut share: Vec<f32> = (0..columns * places.rows()).map(|place| places.power(place, &basis)).collect();
    let all: f64 = share.iter().map(|v| f64::from(*v)).sum();
    let scale = if all > 0.0 { 1.0 / all } else { 0.0 };
    share.iter_mut().for_each(|v| *v = (f64::from(*v) * scale) as f32);
    let (mut rows, mut cumulative) = (Vec::new(), Vec::with_capacity(share.len()));
    let mut before = 0.0;
    for row in share.chunks_exact(columns) {
        let whole: f64 = row.iter().map(|v| f64::from(*v)).sum();
        let mut sum = 0.0;
        for value in row {
            sum += f64::from(*value);
            cumulative.push((sum / whole.max(1e-300)) as f32);
        }
        before += whole;
        rows.push(before);
    }
    Density { share, rows, columns: cumulative }
}

/// ρ over the wavelengths, cosθ and φ of its table.
fn albedos(table: &Places) -> Vec<f32> {
    let [cosines, azimuths, waves] = RHO;
    let one = |i: usize| {
        let cos_i = rho_cosine(i / azimuths % cosines);
        let sin_i = (1.0 - cos_i * cos_i).max(0.0).sqrt();
        let phi = TAU * (i % azimuths) as f64 / azimuths as f64;
        let w_i = DVec3::new(sin_i * libm::cos(phi), sin_i * libm::sin(phi), cos_i);
        albedo(table, 1e-3 * rho_nm(i / azimuths / cosines), w_i) as f32
    };
    (0..waves * cosines * azimuths).into_par_iter().map(one).collect()
}

/// ρ of a direction at a wavelength, µm: Σ Γ S step²/(π s_f²) over all places of a table whose light leaves.
fn albedo(table: &Places, um: f64, w_i: DVec3) -> f64 {
    let step = table.step[0];
    let low = LOWEST * LOWEST;
    // Places along an axis whose direction cosine −w − um·f is within ± reach.
    let within = |axis: usize, w: f64, reach: f64| {
        let most = table.most[axis] as f64;
        let at = |cosine: f64| (-(w + cosine) / (um * step) + most).clamp(0.0, 2.0 * most);
        at(reach).ceil() as usize..=at(-reach).floor() as usize
    };
    let mut sum = 0.0;
    for j in within(1, w_i.y, 1.0) {
        let y = -w_i.y - um * (j as f64 - table.most[1] as f64) * step;
        for i in within(0, w_i.x, (1.0 - y * y).max(0.0).sqrt()) {
            let x = -w_i.x - um * (i as f64 - table.most[0] as f64) * step;
            let up = 1.0 - x * x - y * y;
            if up <= low {
                continue;
            }
            let w_o = DVec3::new(x, y, up.sqrt());
            let kappa = -TAU * (w_o.z + w_i.z) / um;
            let power = table.power(j * table.columns() + i, &table.basis(kappa));
            sum += FORM.weight(w_i, w_o) * f64::from(power);
        }
    }
    sum * SHARE_OF_WINDOW
}

impl Tabulated {
    /// The node nearest to κ.
    #[inline]
    fn node(&self, kappa: f64) -> usize {
        ((-kappa / self.places.kappa_most() * (NODES - 1) as f64).round().max(0.0) as usize).min(NODES - 1)
    }

    /// ρ of a direction over the surface, between the table's values.
    #[inline]
    fn rho_at(&self, nm: f64, w: DVec3) -> f64 {
        let [cosines, azimuths, waves] = RHO;
        let place = |part: f64, count: usize| {
            let at = part.clamp(0.0, 1.0) * (count - 1) as f64;
            let low = (at as usize).min(count - 2);
            (low, at - low as f64)
        };
        let (wave, a) = place((nm - Grating::BAND.low_nm()) / Grating::BAND.width_nm(), waves);
        let (cosine, b) = place((w.z.max(LOWEST) - LOWEST).sqrt() / (1.0 - LOWEST).sqrt(), cosines);
        let turn = libm::atan2(w.y, w.x).rem_euclid(TAU) / TAU * azimuths as f64;
        let (azimuth, c) = (turn as usize % azimuths, turn - turn.floor());
        let value = |i: usize, j: usize, k: usize| {
            f64::from(self.rho[((wave + i) * cosines + cosine + j) * azimuths + (azimuth + k) % azimuths])
        };
        let between = |i: usize, j: usize| value(i, j, 0) * (1.0 - c) + value(i, j, 1) * c;
        let of_wave = |i: usize| between(i, 0) * (1.0 - b) + between(i, 1) * b;
        of_wave(0) * (1.0 - a) + of_wave(1) * a
    }
}

/// Wavelengths of the table of ρ.
fn rho_nm(wave: usize) -> f64 {
    Grating::BAND.low_nm() + Grating::BAND.width_nm() * wave as f64 / (RHO[2] - 1) as f64
}

/// Cosines of the table of ρ, closest at grazing incidence.
fn rho_cosine(place: usize) -> f64 {
    let part = place as f64 / (RHO[0] - 1) as f64;
    LOWEST + (1.0 - LOWEST) * part * part
}

/// A grating at the wavelengths of a path, seen from one direction.
pub(super) struct Bound<'a> {
    grating: &'a Tabulated,
    um: [f64; WAVES],
    reflectance_o: f64,
    pigment: [f64; WAVES],
    rho_o: [f64; WAVES],
    /// Share of the samples that are diffuse.
    diffuse_share: f64,
    /// Which densities samples are drawn from.
    nodes: [usize; WAVES],
}

impl Bound<'_> {
    #[inline(always)]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::REFLECTION.and(Lobes::GLOSSY)
    }

    #[inline(never)] // one copy for all callers, which are inlined into one function
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        let grating = self.grating;
        let half = (wi + wo).normalize();
        let reflected = fresnel(wi.dot(half), grating.index) * FORM.weight(wi, wo) * grating.window;
        let through = (1.0 - fresnel(wi.z, grating.index)) * (1.0 - self.reflectance_o) / PI;
        let mut f = self.pigment.map(|d| through * d);
        let mut pdf = [self.diffuse_share * wi.z / PI; WAVES];
        for k in 0..WAVES {
            let um = self.um[k];
            let share = &grating.densities[self.nodes[k]].share;
            let frequency = [-(wi.x + wo.x) / um, -(wi.y + wo.y) / um];
            let kappa = -TAU * (wi.z + wo.z) / um;
            let Some([power, density]) = grating.places.sums(frequency, kappa, share) else { continue };
            let safe = grating.rho_at(1e3 * um, wi).max(self.rho_o[k]).max(1.0);
            f[k] += reflected * f64::from(power) / (um * um * safe);
            // Of direction cosines λ f, of which a solid angle is 1/cosθ_i times as much.
            let area = um * um * grating.places.area();
            pdf[k] += (1.0 - self.diffuse_share) * f64::from(density) / area * wi.z;
        }
        (f, pdf)
    }

    #[inline(never)]
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        if u[2] < self.diffuse_share {
            let (sine, azimuth) = (u[0].sqrt(), TAU * u[1]);
            let z = (1.0 - u[0]).max(0.0).sqrt();
            return Some((DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), z), self.lobes()));
        }
        let grating = self.grating;
        let density = &grating.densities[self.nodes[0]];
        let columns = grating.places.columns();
        // A row, then a place in it; what is left of each number says where about the place.
        let whole = *density.rows.last()?;
        let row = density.rows.partition_point(|sum| *sum <= u[0] * whole).min(density.rows.len() - 1);
        let before = if row == 0 { 0.0 } else { density.rows[row - 1] };
        let left_y = (u[0] * whole - before) / (density.rows[row] - before).max(1e-300);
        let line = &density.columns[row * columns..][..columns];
        let column = line.partition_point(|sum| f64::from(*sum) <= u[1]).min(columns - 1);
        let before = if column == 0 { 0.0 } else { f64::from(line[column - 1]) };
        let left_x = (u[1] - before) / (f64::from(line[column]) - before).max(1e-300);
        let left = [left_x, left_y].map(|left| left.clamp(0.0, 1.0));
        let [fx, fy] = grating.places.about([column, row], left)?;
        let (x, y) = (-wo.x - self.um[0] * fx, -wo.y - self.um[0] * fy);
        let up = 1.0 - x * x - y * y;
        (up > 0.0).then(|| (DVec3::new(x, y, up.sqrt()), self.lobes()))
    }
}
