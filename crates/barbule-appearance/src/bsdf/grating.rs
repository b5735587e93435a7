//! A diffraction grating over pigment: the light that a heightfield's orders reflect, in the mean over places, and what comes
//! back diffusely from beneath.
//!
//! f = R Γ S/(λ² π s_f²)/max(1, ρ(ω_i), ρ(ω_o)) + (1 − R(θ_i))(1 − R(θ_o)) d/π
//!
//! S are the orders' powers through the window of coherence ([`crate::scattering::grating`]), a function of the frequency −(ω_i +
//! ω_o)/λ along the surface and of κ. It is tabulated over frequencies and bilinear between, so that one look-up serves
//! values and sampling: a bilinear function is a sum of tents, and frequencies are drawn from a node's probability and its tent.
//! ρ(ω) is what the scalar model makes of all light of one direction, which may be over 1 at grazing incidence: the quotient
//! mends that and stays reciprocal. It is never boosted where ρ < 1: the rest is in orders that do not leave.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
use std::sync::Arc;

use glam::DVec3;

use super::hit::Hit;
use super::lobes::Lobes;
use super::reflectance::Reflectance;
use super::{Bsdf, Model};
use crate::fresnel::fresnel;
use crate::scattering::grating::{Coherence, Obliquity, Powers};
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::spectrum::sensor::Band;
use crate::{Error, Result};

/// Windows reach so many standard deviations.
const REACH: f64 = 4.5;
/// Frequencies of the table are so far apart, in standard deviations of the window on powers.
const STEP: f64 = 1.0;
/// Most places of the table along an axis.
const MOST_PLACES: usize = 1201;
/// Most terms over κ.
const MOST_TERMS: usize = 64;
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
    s_f: f64,
    /// Distance of frequencies, 1/µm.
    step: f64,
    /// Places on either side of frequency 0.
    most: [usize; 2],
    kappa_most: f64,
    terms: usize,
    /// S as Chebyshev series over κ, `[fy][fx][term]`.
    series: Vec<f32>,
    densities: Vec<Density>,
    /// `[wavelength][cosθ][φ]`
    rho: Vec<f32>,
}

/// Probabilities of the table's places at one κ.
#[derive(Debug)]
struct Density {
    /// Of each place.
    share: Vec<f32>,
    /// Sums over the rows up to each.
    rows: Vec<f64>,
    /// Within each row, up to each place.
    columns: Vec<f32>,
}

/// The places about a frequency and their weights.
#[derive(Clone, Copy)]
struct Taps {
    places: [usize; 4],
    weights: [f32; 4],
}

impl Grating {
    /// Whose wavelengths its tables serve: shorter ones have orders beyond them.
    pub const BAND: Band = Band::HUMAN;

    /// - `coherence_um`: standard deviation of the window of coherence; the narrower, the wider are lobes
    /// - `index`: refractive index of the surface
    /// - `pigment`: colour of what is beneath, linear sRGB, 0 … 1
    ///
    /// # Errors
    /// A number out of range; a coherence too wide for the table.
    pub fn new(powers: &Powers, coherence_um: f64, index: f64, pigment: [f64; 3]) -> Result<Self> {
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
        let s_f = Coherence::Fixed(coherence_um).frequency_per_um(1.0);
        let deviation = s_f * FRAC_1_SQRT_2;
        let step = STEP * deviation;
        let orders = powers.orders();
        let most = [0, 1].map(|axis| {
            let far = orders.most[axis] as f64 / orders.period_um[axis] + REACH * deviation;
            (far.min(2e3 / Self::BAND.low_nm()) / step).ceil() as usize
        });
        if most.iter().any(|most| 2 * most + 1 > MOST_PLACES) {
            return Err(Error::input(format!(
                "a grating's coherence is {coherence_um} µm, too wide for its patch to be rendered; give at most {:.1}",
                coherence_um * (MOST_PLACES / 2) as f64 / most[0].max(most[1]) as f64
            )));
        }
        let mut made = Tabulated {
            index,
            pigment,
            s_f,
            step,
            most,
            kappa_most: powers.kappa_most(),
            terms: powers.terms(),
            series: through_window(powers, most, step, deviation),
            densities: Vec::new(),
            rho: Vec::new(),
        };
        made.densities = (0..NODES).map(|node| made.density(made.node_kappa(node))).collect();
        made.rho = made.albedos();
        Ok(Self(Arc::new(made)))
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

/// Powers through the window at each place of the table, `[fy][fx][term]`. The table's tents widen what they interpolate by
/// step²/6, which the window is narrower for; each order keeps its integral 2πσ².
fn through_window(powers: &Powers, most: [usize; 2], step: f64, deviation: f64) -> Vec<f32> {
    let narrow = (deviation * deviation - step * step / 6.0).sqrt();
    let orders = powers.orders();
    let (terms, [columns, rows]) = (powers.terms(), orders.counts());
    // Orders about a place along an axis, and their weights.
    let window = |axis: usize, place: usize| {
        let f = (place as f64 - most[axis] as f64) * step;
        let (side, highest) = (orders.period_um[axis], orders.most[axis] as f64);
        let low = ((f - REACH * narrow) * side).ceil().max(-highest);
        let high = ((f + REACH * narrow) * side).floor().min(highest);
        let count = (high - low + 1.0).max(0.0) as usize;
        let weight = move |i: usize| {
            let away = (f - (low + i as f64) / side) / narrow;
            (deviation / narrow * libm::exp(-0.5 * away * away)) as f32
        };
        let first = if count > 0 { (low + highest) as usize } else { 0 };
        (0..count).map(move |i| (first + i, weight(i)))
    };
    let [across, along] = most.map(|most| 2 * most + 1);
    let mut series = vec![0.0; across * along * terms];
    let mut line = vec![0.0; columns * terms];
    for (fy, row) in series.chunks_exact_mut(across * terms).enumerate() {
        line.fill(0.0);
        for (jy, weight) in window(1, fy).filter(|(jy, _)| *jy < rows) {
            let orders = &powers.series()[jy * columns * terms..][..columns * terms];
            line.iter_mut().zip(orders).for_each(|(sum, value)| *sum += weight * value);
        }
        for (fx, place) in row.chunks_exact_mut(terms).enumerate() {
            for (jx, weight) in window(0, fx) {
                let order = &line[jx * terms..][..terms];
                place.iter_mut().zip(order).for_each(|(sum, value)| *sum += weight * value);
            }
        }
    }
    series
}

impl Tabulated {
    fn columns(&self) -> usize {
        2 * self.most[0] + 1
    }

    fn node_kappa(&self, node: usize) -> f64 {
        -self.kappa_most * node as f64 / (NODES - 1) as f64
    }

    /// The node nearest to κ.
    #[inline]
    fn node(&self, kappa: f64) -> usize {
        ((-kappa / self.kappa_most * (NODES - 1) as f64).round().max(0.0) as usize).min(NODES - 1)
    }

    #[inline]
    fn basis(&self, kappa: f64) -> [f32; MOST_TERMS] {
        let x = ((2.0 * kappa / self.kappa_most + 1.0).clamp(-1.0, 1.0)) as f32;
        let mut basis = [0.0; MOST_TERMS];
        let (mut before, mut now) = (x, 1.0);
        for term in &mut basis[..self.terms] {
            *term = now;
            (before, now) = (now, 2.0 * x * now - before);
        }
        basis
    }

    #[inline]
    fn sum(&self, place: usize, basis: &[f32; MOST_TERMS]) -> f32 {
        let series = &self.series[place * self.terms..][..self.terms];
        series.iter().zip(basis).map(|(c, t)| c * t).sum::<f32>().max(0.0)
    }

    /// Places about a frequency, 1/µm; those beyond the table count nothing.
    #[inline]
    fn taps(&self, f: [f64; 2]) -> Option<Taps> {
        let at = [0, 1].map(|axis| f[axis] / self.step + self.most[axis] as f64);
        let low = at.map(f64::floor);
        let last = self.most.map(|most| 2.0 * most as f64);
        if (0..2).any(|axis| low[axis] < -1.0 || low[axis] > last[axis]) {
            return None;
        }
        let part = [at[0] - low[0], at[1] - low[1]];
        let mut taps = Taps { places: [0; 4], weights: [0.0; 4] };
        for k in 0..4 {
            let [i, j] = [low[0] + (k & 1) as f64, low[1] + (k >> 1) as f64];
            if (0.0..=last[0]).contains(&i) && (0.0..=last[1]).contains(&j) {
                let weight = |axis: usize, upper: bool| if upper { part[axis] } else { 1.0 - part[axis] };
                taps.places[k] = j as usize * self.columns() + i as usize;
                taps.weights[k] = (weight(0, k & 1 == 1) * weight(1, k >> 1 == 1)) as f32;
            }
        }
        Some(taps)
    }

    fn density(&self, kappa: f64) -> Density {
        let basis = self.basis(kappa);
        let columns = self.columns();
        let mut share: Vec<f32> =
            (0..self.series.len() / self.terms).map(|place| self.sum(place, &basis)).collect();
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

    /// ρ over the wavelengths, cosθ and φ of its table: Σ Γ S step²/(π s_f²) over all places whose light leaves.
    fn albedos(&self) -> Vec<f32> {
        let [cosines, azimuths, waves] = RHO;
        let columns = self.columns();
        let area = self.step * self.step / (PI * self.s_f * self.s_f);
        let mut rho = Vec::with_capacity(waves * cosines * azimuths);
        for wave in 0..waves {
            let um = 1e-3 * rho_nm(wave);
            for c in 0..cosines {
                let cos_i = rho_cosine(c);
                let sin_i = (1.0 - cos_i * cos_i).max(0.0).sqrt();
                for a in 0..azimuths {
                    let phi = TAU * a as f64 / azimuths as f64;
                    let w_i = DVec3::new(sin_i * libm::cos(phi), sin_i * libm::sin(phi), cos_i);
                    let mut sum = 0.0;
                    for j in 0..=2 * self.most[1] {
                        let y = -w_i.y - um * (j as f64 - self.most[1] as f64) * self.step;
                        for i in 0..columns {
                            let x = -w_i.x - um * (i as f64 - self.most[0] as f64) * self.step;
                            let up = 1.0 - x * x - y * y;
                            if up <= LOWEST * LOWEST {
                                continue;
                            }
                            let w_o = DVec3::new(x, y, up.sqrt());
                            let kappa = -TAU * (w_o.z + w_i.z) / um;
                            let power = self.sum(j * columns + i, &self.basis(kappa));
                            sum += FORM.weight(w_i, w_o) * f64::from(power) * area;
                        }
                    }
                    rho.push(sum as f32);
                }
            }
        }
        rho
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
        let reflected = fresnel(wi.dot(half), grating.index) * FORM.weight(wi, wo);
        let through = (1.0 - fresnel(wi.z, grating.index)) * (1.0 - self.reflectance_o) / PI;
        let window = PI * grating.s_f * grating.s_f;
        let mut f = self.pigment.map(|d| through * d);
        let mut pdf = [self.diffuse_share * wi.z / PI; WAVES];
        for k in 0..WAVES {
            let um = self.um[k];
            let Some(taps) = grating.taps([-(wi.x + wo.x) / um, -(wi.y + wo.y) / um]) else { continue };
            let basis = grating.basis(-TAU * (wi.z + wo.z) / um);
            let share = &grating.densities[self.nodes[k]].share;
            let (mut power, mut density) = (0.0, 0.0);
            for (place, weight) in taps.places.into_iter().zip(taps.weights).filter(|(_, w)| *w > 0.0) {
                power += weight * grating.sum(place, &basis);
                density += weight * share[place];
            }
            let safe = grating.rho_at(1e3 * um, wi).max(self.rho_o[k]).max(1.0);
            f[k] += reflected * f64::from(power) / (um * um * window * safe);
            // Of direction cosines λ f, of which a solid angle is 1/cosθ_i times as much.
            let area = (um * grating.step).powi(2);
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
        let columns = grating.columns();
        // A row, then a place in it; what is left of each number is the place within the tents.
        let whole = *density.rows.last()?;
        let row = density.rows.partition_point(|sum| *sum <= u[0] * whole).min(density.rows.len() - 1);
        let before = if row == 0 { 0.0 } else { density.rows[row - 1] };
        let left_y = (u[0] * whole - before) / (density.rows[row] - before).max(1e-300);
        let line = &density.columns[row * columns..][..columns];
        let column = line.partition_point(|sum| f64::from(*sum) <= u[1]).min(columns - 1);
        let before = if column == 0 { 0.0 } else { f64::from(line[column - 1]) };
        let left_x = (u[1] - before) / (f64::from(line[column]) - before).max(1e-300);
        let frequency = |axis: usize, place: usize, left: f64| {
            (place as f64 - grating.most[axis] as f64 + tent(left.clamp(0.0, 1.0))) * grating.step
        };
        let x = -wo.x - self.um[0] * frequency(0, column, left_x);
        let y = -wo.y - self.um[0] * frequency(1, row, left_y);
        let up = 1.0 - x * x - y * y;
        (up > 0.0).then(|| (DVec3::new(x, y, up.sqrt()), self.lobes()))
    }
}

/// −1 … 1 with the density 1 − |t| from a uniform number.
fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).max(0.0).sqrt() }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::math::rng::Stream;
    use crate::scattering::grating::Orders;

    /// Orders along x and y by their powers, a period of 2 µm.
    fn powers(of: impl Fn(i64, i64) -> f32) -> Powers {
        let orders = Orders { most: [6, 6], period_um: [2.0, 2.0] };
        let series = (-6..=6).flat_map(|j| (-6..=6).map(move |i| (i, j))).flat_map(|(i, j)| {
            // A quarter of it changes with κ.
            [0.75 * of(i, j), 0.25 * of(i, j)]
        });
        Powers::new(orders, 2.0 * TAU / 0.38, 2, series.collect()).unwrap()
    }

    pub(in crate::bsdf) fn grating() -> Grating {
        let share = |i: i64, j: i64| match (i, j) {
            (0, 0) => 0.4,
            (1, 0) => 0.3,
            (0, -1 | 1) => 0.1,
            _ => 0.0,
        };
        Grating::new(&powers(share), 2.0, 1.5, [0.2, 0.1, 0.3]).unwrap()
    }

    fn mirror(coherence: f64) -> Grating {
        let orders = Orders { most: [0, 0], period_um: [2.0, 2.0] };
        let powers = Powers::new(orders, 2.0 * TAU / 0.38, 1, vec![1.0]).unwrap();
        Grating::new(&powers, coherence, 1.5, [0.0; 3]).unwrap()
    }

    /// ∫ f cosθ_i dω_i at the first wavelength over a square of direction cosines.
    fn energy(surface: &Grating, wo: DVec3, nm: f64, about: [f64; 2], half: f64) -> f64 {
        let bsdf = surface.bind(&Hit::default(), wo, Lambdas::splat(nm));
        let steps = 300;
        let step = 2.0 * half / f64::from(steps);
        let mut sum = 0.0;
        for i in 0..steps {
            for j in 0..steps {
                let at = |i: i32, middle: f64| middle + (f64::from(i) + 0.5) * step - half;
                let (x, y) = (at(i, about[0]), at(j, about[1]));
                let up = 1.0 - x * x - y * y;
                if up > 0.0 {
                    sum += bsdf.eval(DVec3::new(x, y, up.sqrt())).f[0] * step * step;
                }
            }
        }
        sum
    }

    #[test]
    fn a_flat_one_is_a_mirror_with_a_lobe() {
        for nm in [420.0, 650.0] {
            for polar in [0.0, 0.6, 1.0_f64] {
                let wo = DVec3::new(polar.sin() * 0.6, polar.sin() * 0.8, polar.cos());
                let found = energy(&mirror(8.0), wo, nm, [-wo.x, -wo.y], 0.12);
                assert!((found / fresnel(wo.z, 1.5) - 1.0).abs() < 3e-3, "{nm} {polar}: {found}");
            }
        }
    }

    /// In its standard deviation λ s_f/√2 too.
    #[test]
    fn lobes_are_as_wide_as_the_coherence_says() {
        let (nm, coherence) = (500.0, 8.0);
        let surface = mirror(coherence);
        let bsdf = surface.bind(&Hit::default(), DVec3::Z, Lambdas::splat(nm));
        let (mut whole, mut second) = (0.0, 0.0);
        for i in -400..=400 {
            let x = 2e-4 * f64::from(i);
            let f = bsdf.eval(DVec3::new(x, 0.0, (1.0 - x * x).sqrt())).f[0];
            whole += f;
            second += f * x * x;
        }
        let expected = 0.5 / (TAU * coherence) * FRAC_1_SQRT_2;
        assert!(((second / whole).sqrt() / expected - 1.0).abs() < 0.01);
    }

    /// Sampled energies are those of the integral, and orders are where the grating equation says.
    #[test]
    fn orders_leave_where_the_grating_equation_says() {
        let surface = grating();
        let wo = DVec3::new(0.3, 0.0, (1.0_f64 - 0.09).sqrt());
        let nm = 600.0;
        let bsdf = surface.bind(&Hit::default(), wo, Lambdas::splat(nm));
        let at = |x: f64, y: f64| bsdf.eval(DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())).f[0];
        // ω_i,x = −ω_o,x − j λ/T.
        let order = at(-0.3 - 0.3, 0.0);
        assert!(order > 10.0 * at(-0.3 + 0.3, 0.0) && at(-0.3, 0.3) > 5.0 * at(-0.3 - 0.15, 0.15));
        let mut stream = Stream::new(4, &[]);
        let mut sum = 0.0;
        for _ in 0..40_000 {
            if let Some(sample) = bsdf.sample([stream.unit(), stream.unit(), stream.unit()]) {
                sum += sample.evaluation.f[0] * sample.evaluation.cosine / sample.evaluation.pdf[0] / 4e4;
            }
        }
        let whole = energy(&surface, wo, nm, [0.0; 2], 1.0);
        assert!((sum / whole - 1.0).abs() < 0.01, "{sum} {whole}");
    }

    #[test]
    fn what_cannot_be_tabulated_is_refused() {
        let powers = powers(|_, _| 0.1);
        assert!(Grating::new(&powers, 1e4, 1.5, [0.0; 3]).unwrap_err().to_string().contains("give at most"));
        assert!(Grating::new(&powers, 0.0, 1.5, [0.0; 3]).is_err());
        assert!(Grating::new(&powers, 4.0, 1.0, [0.0; 3]).is_err());
        assert!(Grating::new(&powers, 4.0, 1.5, [0.0, 2.0, 0.0]).is_err());
    }
}
