//! A material's lobes at the nodes of its tables, ready for evaluation.
//!
//! Between nodes the *values* of the lobes are mixed, never their parameters: two neighbours whose peaks lie elsewhere
//! give both peaks, each with its share, and what is reflected is the mixture of what the nodes reflect. A point in
//! (θ_i, φ_i, λ) lies in one of the six simplices of its cell (Kuhn's), so four nodes are mixed instead of eight.
//! Before, each node's lobe is turned from its own φ_i to that of the light, by the Möbius map of sinφ that takes one
//! mirror direction to the other and keeps the horizon: see [`Corner`].
//!
//! Beyond the lowest stored cosines a node is added at grazing: the shape of its neighbour, reflecting what continues the
//! two lowest nodes linearly.

use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

use super::material::{FeatherMaterial, LobeSet, ParameterSet};
use super::profile::{Areas, Part};
use super::sample::distribution;
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::Lobe;
use crate::scattering::statistics::{Axes, Sides};

/// Lobes of a node: two of the mean, then that of the steady part.
pub(super) const LOBES: usize = 3;

/// A node in one cache line: by parameter, then by lobe. A load of four at the first parameters reads one number of the
/// next parameter beside the three lobes'.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Node(pub(super) [f32; 16]);

/// Where m² begins.
pub(super) const M2: usize = 0;
/// Where sin(φ_eff/2) begins.
pub(super) const SINE: usize = 3;
/// Where cos(φ_eff/2) begins.
pub(super) const COSINE: usize = 6;
/// Where 2ρ/(π area)·m² begins, for the steady lobe with m⁶.
pub(super) const STRENGTH: usize = 9;
/// 1/l, γ, and polarization 1's fraction in the mean and in the steady part.
pub(super) const EXTRAS: usize = 12;

/// What sampling needs of a node: of each mean lobe the factor of its density and the fraction that it reflects.
#[derive(Debug, Clone, Copy)]
#[repr(align(16))]
pub(super) struct Shares(pub(super) [f32; 4]);

/// A lobe that reflects nothing is drawn from all the same, so that there is always something to draw from.
const LEAST_SHARE: f64 = 1e-9;

/// Nearer to grazing azimuths 1 − sinφ_i would lose its digits, and the turn with it.
const LEAST_COSINE: f64 = 1e-4;

/// Lookup table of one parameter set.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// Shape `[θ_i, φ_i, λ]`.
    pub(super) nodes: Vec<Node>,
    /// Shape of `nodes`.
    pub(super) shares: Vec<Shares>,
    /// ρ of the mean. Shape of `nodes`.
    reflected: Vec<f32>,
}

/// The axes of a material's tables, with the nodes that are added at grazing.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    theta: Axis,
    phi: Axis,
    /// cosθ_i that the lobes of each θ_i belong to.
    cos_theta: Vec<f64>,
    /// sinφ_i and cosφ_i that the lobes of each φ_i belong to.
    phis: Vec<[f64; 2]>,
    sides: Sides,
    wavelengths: Axis,
    /// Nodes along λ.
    waves: usize,
}

/// Rising places, found by arithmetic where they are evenly spaced.
#[derive(Debug, Clone)]
struct Axis {
    places: Vec<f64>,
    inverse_spacing: Option<f64>,
}

impl Axis {
    fn new(places: Vec<f64>) -> Self {
        let (first, last) = (places[0], places[places.len() - 1]);
        let spacing = (last - first) / (places.len().max(2) - 1) as f64;
        let even =
            places.iter().enumerate().all(|(k, p)| (first + k as f64 * spacing - p).abs() < 1e-9 * last);
        Self { places, inverse_spacing: (even && spacing > 0.0).then_some(1.0 / spacing) }
    }

    /// The place below and the share of the one above; beyond the ends those hold.
    #[inline(always)]
    fn find(&self, at: f64) -> (usize, f64) {
        let places = &self.places[..];
        if places.len() < 2 {
            return (0, 0.0);
        }
        let last = places.len() - 2;
        if let Some(inverse) = self.inverse_spacing {
            let position = ((at - places[0]) * inverse).max(0.0).min((last + 1) as f64);
            let index = (position as i32).min(last as i32);
            return (index as usize, position - f64::from(index));
        }
        let index = places.partition_point(|p| *p <= at).clamp(1, last + 1) - 1;
        let share = (at - places[index]) / (places[index + 1] - places[index]);
        (index, share.clamp(0.0, 1.0))
    }
}

/// A node's direction as seen from the light's: what turns azimuths.
///
/// With x = sinφ_o, s = sinφ_i of the light and s_n, c_n of the node, x' = ((1 − s s_n) x + (s − s_n))/D, cosφ' =
/// cosφ_o c c_n/D, D = (1 − s s_n) + (s − s_n) x; so −s goes to −s_n, ±1 to themselves, and dφ'/dφ_o = c c_n/D: what a
/// lobe sends out is kept.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Corner {
    /// cosθ_i that its lobes belong to.
    pub(super) cos_theta: f64,
    /// 1 − s s_n
    pub(super) level: f64,
    /// s − s_n
    pub(super) shift: f64,
    /// c c_n
    pub(super) scale: f64,
}

/// A light's direction in the tables.
///
/// Of its cell three corners count: the one below in both axes, the next along the axis with the larger share, the one
/// above in both. Arrays are over them; their last place repeats the one before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Incident {
    /// Number of each corner's node at the shortest wavelength.
    first: [u32; 3],
    /// [`Corner::cos_theta`] and so on.
    pub(super) cos_theta: [f64; 4],
    pub(super) level: [f64; 4],
    pub(super) shift: [f64; 4],
    pub(super) scale: [f64; 4],
    /// Larger and smaller share.
    shares: [f64; 2],
    /// Whether the tables hold the mirror image: x of ω_o changes its sign.
    pub(super) mirrored: bool,
    /// sinθ_i and cosθ_i.
    pub(super) along: [f64; 2],
}

impl Incident {
    /// One of the three corners.
    pub(super) fn corner(&self, corner: u8) -> Corner {
        let k = usize::from(corner).min(2);
        Corner {
            cos_theta: self.cos_theta[k],
            level: self.level[k],
            shift: self.shift[k],
            scale: self.scale[k],
        }
    }
}

/// The four nodes that are mixed at one wavelength: the corner below, either it again or the next, either that or the
/// corner above, and the corner above.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Simplex {
    /// Numbers of the nodes.
    pub(super) at: [u32; 4],
    /// Their weights, which sum to 1.
    pub(super) weight: [f32; 4],
    /// Which corners the second and the third belong to: 0 or 1, 1 or 2.
    pub(super) middle: [u8; 2],
}

impl Simplex {
    /// Corners of the nodes.
    #[inline(always)]
    pub(super) fn corners(&self) -> [u8; 4] {
        [0, self.middle[0], self.middle[1], 2]
    }
}

impl Grid {
    pub(super) fn new(axes: &Axes) -> Self {
        let stored = axes.cos_theta();
        let theta = Axis::new([&[0.0], stored].concat());
        let cos_theta = [&stored[..1], stored].concat();
        // Rising in φ_i, with the lowest cosine's lobes again at grazing.
        let order = phi_order(axes);
        let signed = |phi: usize| (1.0 - axes.cos_phi()[axes.cosine_of(phi)]).copysign(axes.phi_i(phi));
        let mut places: Vec<f64> = order.iter().map(|phi| signed(*phi)).collect();
        let mut phis: Vec<[f64; 2]> = order
            .iter()
            .map(|phi| {
                let cosine = axes.cos_phi()[axes.cosine_of(*phi)];
                [(1.0 - cosine * cosine).max(0.0).sqrt().copysign(axes.phi_i(*phi)), cosine]
            })
            .collect();
        places.push(1.0);
        phis.push(phis[phis.len() - 1]);
        if axes.sides() == Sides::Both {
            places.insert(0, -1.0);
            phis.insert(0, phis[0]);
        }
        let waves = axes.wavelengths_nm().len();
        Self {
            theta,
            phi: Axis::new(places),
            cos_theta,
            phis,
            sides: axes.sides(),
            wavelengths: Axis::new(axes.wavelengths_nm().to_vec()),
            waves,
        }
    }

    /// ω_i in the tables; both of its x and z count, z > 0.
    #[inline(always)]
    pub(super) fn incident(&self, [x, y, z]: [f64; 3]) -> Incident {
        let cos_theta = (x * x + z * z).sqrt().max(1e-9);
        let inverse = 1.0 / cos_theta;
        let (mut sin_phi, mut cos_phi) = (x * inverse, (z * inverse).min(1.0));
        if cos_phi < LEAST_COSINE {
            (sin_phi, cos_phi) = ((1.0 - LEAST_COSINE * LEAST_COSINE).sqrt().copysign(x), LEAST_COSINE);
        }
        let mirrored = self.sides == Sides::Alike && sin_phi < 0.0;
        if mirrored {
            sin_phi = -sin_phi;
        }
        let (t, wt) = self.theta.find(cos_theta);
        let (below, wp) = self.phi.find((1.0 - cos_phi).copysign(sin_phi));
        // From the normal outwards, so that mirror images are mixed alike.
        let (p, outwards, wp) =
            if self.phi.places[below] < 0.0 { (below + 1, below, 1.0 - wp) } else { (below, below + 1, wp) };
        let (next_t, next_p) = if wt >= wp { (t + 1, p) } else { (t, outwards) };
        let (rows, columns) = ([t, next_t, t + 1, t + 1], [p, next_p, outwards, outwards]);
        let mut incident = Incident {
            first: [0; 3],
            cos_theta: [0.0; 4],
            level: [0.0; 4],
            shift: [0.0; 4],
            scale: [0.0; 4],
            shares: [wt.max(wp), wt.min(wp)],
            mirrored,
            along: [y, cos_theta],
        };
        for k in 0..4 {
            let [s_n, c_n] = self.phis[columns[k]];
            incident.cos_theta[k] = self.cos_theta[rows[k]];
            incident.level[k] = 1.0 - sin_phi * s_n;
            incident.shift[k] = sin_phi - s_n;
            incident.scale[k] = cos_phi * c_n;
        }
        for k in 0..3 {
            incident.first[k] = ((rows[k] * self.phis.len() + columns[k]) * self.waves) as u32;
        }
        incident
    }

    /// The nodes that are mixed at this wavelength.
    #[inline(always)]
    pub(super) fn simplex(&self, incident: &Incident, wavelength_nm: f64) -> Simplex {
        let (wave, share) = self.wavelengths.find(wavelength_nm);
        let (wave, up) = (wave as u32, u32::from(self.waves > 1));
        let [larger, smaller] = incident.shares;
        // The axes are climbed in the order of their shares: λ first, second or last.
        let (first, second) = (share >= larger, share >= smaller);
        let (a, c) = (share.max(larger), share.min(smaller));
        let b = share.min(larger).max(smaller);
        let middle = [u8::from(!first), 2 - u8::from(second)];
        Simplex {
            at: [
                incident.first[0] + wave,
                incident.first[usize::from(middle[0])] + wave + up * u32::from(first),
                incident.first[usize::from(middle[1])] + wave + up * u32::from(second),
                incident.first[2] + wave + up,
            ],
            weight: [(1.0 - a) as f32, (a - b) as f32, (b - c) as f32, c as f32],
            middle,
        }
    }
}

/// Numbers of the stored φ_i in rising order of φ_i.
fn phi_order(axes: &Axes) -> Vec<usize> {
    let cosines = axes.cos_phi().len();
    // Of φ_i ≥ 0 cosines rise, so φ_i falls; of φ_i < 0 both rise.
    (cosines..axes.phis()).chain((0..cosines).rev()).collect()
}

impl Table {
    /// Prepares one set; `polarization` takes the share of one incident polarization of all values.
    pub(super) fn new(
        material: &FeatherMaterial,
        set: &ParameterSet,
        polarization: Option<Polarization>,
    ) -> Self {
        let axes = &material.axes;
        let order = phi_order(axes);
        let (waves, thetas, phis) = (axes.wavelengths_nm().len(), axes.cos_theta().len(), axes.phis());
        let areas = Areas::new(material.kind);
        let stored: Vec<(Node, Shares)> = (0..waves * thetas * phis)
            .into_par_iter()
            .map(|at| {
                let cos_theta = axes.cos_theta()[at / phis % thetas];
                Entry { material, set, at, cos_theta, polarization, areas: &areas }.node()
            })
            .collect();
        let reflected =
            |wave: usize, theta: usize, phi: usize| -> f64 { set.reflected(axes.index(wave, theta, phi)) };
        let both = axes.sides() == Sides::Both;
        let columns = phis + 1 + usize::from(both);
        let mut nodes = Vec::with_capacity((thetas + 1) * columns * waves);
        let mut shares = Vec::with_capacity(nodes.capacity());
        let mut totals = Vec::with_capacity(nodes.capacity());
        for t in 0..=thetas {
            for p in 0..columns {
                // The stored column that this one is or continues, and the one beside it.
                let place = (p as isize - isize::from(both)).clamp(0, phis as isize - 1) as usize;
                let outer = p == columns - 1 || (both && p == 0);
                let inner = if place == 0 { 1.min(phis - 1) } else { place - 1 };
                let (phi, beside) = (order[place], order[inner]);
                let theta = t.saturating_sub(1);
                for wave in 0..waves {
                    let at = axes.index(wave, theta, phi);
                    let (node, share) = stored[at];
                    let own = share_of(material, fraction(&set.fraction_1, at), polarization);
                    let mut factor = 1.0;
                    let here = reflected(wave, theta, phi);
                    if t == 0 && thetas > 1 {
                        let cosines = [axes.cos_theta()[0], axes.cos_theta()[1]];
                        factor *= continued([here, reflected(wave, 1, phi)], cosines);
                    }
                    if outer && phis > 1 {
                        let cosines = [phi, beside].map(|phi| axes.cos_phi()[axes.cosine_of(phi)]);
                        factor *= continued([here, reflected(wave, theta, beside)], cosines);
                    }
                    let factor = if here > 0.0 { factor.min(1.0 / here) } else { 1.0 };
                    nodes.push(node.times(factor as f32));
                    shares.push(share.times(factor as f32));
                    totals.push((factor * here * own) as f32);
                }
            }
        }
        Self { nodes, shares, reflected: totals }
    }
}

impl Table {
    /// What the mean lobes of a node reflect.
    pub(super) fn reflected(&self, at: u32) -> f64 {
        f64::from(self.reflected[at as usize])
    }
}

/// What the straight line through two reflected fractions at these cosines says at cosine 0, over the first of them.
fn continued([here, beside]: [f64; 2], [cosine, next]: [f64; 2]) -> f64 {
    if here <= 0.0 || next <= cosine {
        return 1.0;
    }
    ((here - (beside - here) * cosine / (next - cosine)) / here).max(0.0)
}

impl Node {
    /// Reflects so many times as much.
    fn times(mut self, factor: f32) -> Self {
        self.0[STRENGTH..STRENGTH + LOBES].iter_mut().for_each(|strength| *strength *= factor);
        self
    }
}

impl Shares {
    fn times(self, factor: f32) -> Self {
        Self(self.0.map(|share| share * factor.max(1e-3)))
    }
}

/// One node of a set.
struct Entry<'a> {
    material: &'a FeatherMaterial,
    set: &'a ParameterSet,
    at: usize,
    cos_theta: f64,
    polarization: Option<Polarization>,
    areas: &'a Areas,
}

impl Entry<'_> {
    fn node(&self) -> (Node, Shares) {
        let Self { material, set, at, .. } = *self;
        let mut node = Node([0.0; 16]);
        let mut shares = Shares([0.0; 4]);
        let fractions = [fraction(&set.fraction_1, at), fraction(&set.steady_fraction_1, at)];
        let share = fractions.map(|first| share_of(material, first, self.polarization));
        for number in 0..LOBES {
            let part = if number + 1 == LOBES { Part::Steady } else { Part::Mean };
            let (lobes, share): (Option<&LobeSet>, f64) = match part {
                Part::Steady => (Some(&set.steady), share[1]),
                Part::Mean => (set.mean.get(number), share[0]),
            };
            let (lobe, reflected) = lobes.map_or((Lobe { m: 1.0, phi: 0.0 }, 0.0), |lobes| {
                let lobe = Lobe { m: f64::from(lobes.m[at]), phi: bounded(lobes.phi[at]) };
                (lobe, share * f64::from(lobes.reflected[at]))
            });
            let m2 = lobe.m * lobe.m;
            let (sine, cosine) = libm::sincos(0.5 * lobe.phi);
            let power = if part == Part::Steady { m2 * m2 * m2 } else { m2 };
            let strength = 2.0 / PI * power * reflected / self.areas.area(part, lobe, self.cos_theta);
            for (first, value) in [(M2, m2), (SINE, sine), (COSINE, cosine), (STRENGTH, strength)] {
                node.0[first + number] = value as f32;
            }
            if part == Part::Mean {
                let rest = (1.0 - m2).max(1e-12);
                let a = (m2 / rest).sqrt();
                let [first, last] = [-FRAC_PI_2, FRAC_PI_2]
                    .map(|phi_o| distribution(libm::sin(0.5 * (phi_o + lobe.phi)) / a));
                let drawn = reflected.max(LEAST_SHARE);
                shares.0[number] = (drawn * a.powi(3) * rest * rest / (PI * (last - first))) as f32;
                shares.0[2 + number] = drawn as f32;
            }
        }
        let extras = [
            1.0 / f64::from(set.length[at]),
            f64::from(material.correlation[at]),
            fractions[0],
            fractions[1],
        ];
        for (slot, extra) in node.0[EXTRAS..].iter_mut().zip(extras) {
            *slot = extra as f32;
        }
        (node, shares)
    }
}

/// Polarization 1's part of the energy; one half in a set of one polarization, which does not ask.
fn fraction(fractions: &[f32], at: usize) -> f64 {
    fractions.get(at).map_or(0.5, |&f| f64::from(f))
}

/// The values of one polarization over those of unpolarized light.
fn share_of(material: &FeatherMaterial, first: f64, polarization: Option<Polarization>) -> f64 {
    match polarization {
        Some(Polarization::First) if material.sets.len() == 1 => 2.0 * first,
        Some(Polarization::Second) if material.sets.len() == 1 => 2.0 - 2.0 * first,
        _ => 1.0,
    }
}

/// φ_eff stays above the horizon.
fn bounded(phi: f32) -> f64 {
    let largest = FRAC_PI_2 - 1e-4;
    f64::from(phi).clamp(-largest, largest)
}
