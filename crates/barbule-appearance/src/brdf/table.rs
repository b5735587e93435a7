//! A material's lobes at the nodes of its tables, ready for evaluation.
//!
//! Between nodes the *values* of the lobes are mixed, never their parameters: two neighbours whose peaks lie elsewhere
//! give both peaks, each with its share, and what is reflected is the mixture of what the nodes reflect. A point in
//! (θ_i, φ_i, λ) lies in one of the six simplices of its cell (Kuhn's), so four nodes are mixed instead of eight.
//! Before, each node's lobe is turned from its own φ_i to that of the light, by the map that takes one mirror direction to
//! the other and keeps the horizon. In τ(φ) = tan(φ/2 + π/4), which is 0 and ∞ at the horizon, it is a scaling: lobes are
//! stored as functions of τ(φ_i) τ(φ_o), which is 1 in the mirror direction, and need no turn at all.
//!
//! Beyond the lowest stored cosines a node is added at grazing: the shape of its neighbour, reflecting what continues the
//! two lowest nodes linearly.

use bytemuck::{Pod, Zeroable, cast_slice};
use fearless_simd::{Simd, f32x4, f64x8, i32x4, prelude::*};
use rayon::prelude::*;

mod axis;
mod entry;

use axis::Axis;
use entry::Entry;

use super::arrays::{Arrays, TableArray};
use super::halo::Halo;
use super::material::{FeatherMaterial, LENGTHS, ParameterSet, STEEPEST_FRACTION};
use super::profile::Areas;
use super::slope::{STEEPNESS, Slope};
use crate::Result;
use crate::scattering::far_field::Polarization;
use crate::scattering::statistics::{Axes, Sides};

/// Lobes of a node: two of the mean, then that of the steady part.
pub(super) const LOBES: usize = 3;

/// A node in one cache line: by parameter, then by lobe. A load of four at the first parameters reads one number of the
/// next parameter beside the three lobes'.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node(pub(super) [f32; 16]);

/// Where m² begins.
pub(super) const M2: usize = 0;
/// Where (1 − m²) cos²ψ begins, with tanψ = τ(−φ_eff), where the lobe's middle is.
pub(super) const REST: usize = 3;
/// Where the middle begins: τ(φ_i) τ(−φ_eff) with the node's own φ_i.
pub(super) const MIDDLE: usize = 6;
/// Where 2ρ/(π area)·m² begins, times cosψ where shapes have the cosine; of the steady part its share times m⁴.
pub(super) const STRENGTH: usize = 9;
/// 1/l, γ, and polarization 1's fraction in the mean and in the steady part.
pub(super) const EXTRAS: usize = 12;

/// Four numbers of a node. What sampling needs: of each mean lobe the factor of its density (with cosψ), and the fraction that
/// each reflects. Or the shares of the Gaussians along the barbule.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(16))]
pub(super) struct Shares(pub(super) [f32; 4]);

/// A lobe that reflects nothing is drawn from all the same, so that there is always something to draw from.
const LEAST_SHARE: f64 = 1e-9;

/// φ_i nearer to grazing count as this cosφ_i.
pub(super) const LEAST_COSINE: f64 = 1e-4;

/// φ_o nearer to grazing count as this cosφ_o.
pub(super) const LEAST_OUTGOING: f64 = 1e-8;

/// The largest number in single precision.
const LARGEST: f64 = f32::MAX as f64;

/// Ranges of a node's numbers.
const NODE_RANGES: [[f64; 2]; 16] = {
    let (m2, rest, middle, strength) = ([9e-7, 1.0], [0.0, 1.0], [1e-12, 1e12], [0.0, LARGEST]);
    let (length, share) = ([1.0 / LENGTHS.1 as f64, 1.0 / LENGTHS.0 as f64], [0.0, 1.0]);
    let slope = [-STEEPEST_FRACTION, STEEPEST_FRACTION];
    [
        m2, m2, m2, rest, rest, rest, middle, middle, middle, strength, strength, strength, length, share,
        share, slope,
    ]
};

/// Of what sampling needs of it.
const SHARE_RANGES: [[f64; 2]; 4] = [[0.0, LARGEST], [0.0, LARGEST], [1e-13, 4.0], [1e-13, 4.0]];

/// Of what it reflects: of one polarization twice as much as of unpolarized light.
const REFLECTED_RANGE: [f64; 2] = [0.0, 2.001];

/// Of κ, g and 1/l of achromatic instances.
const SLOPE_RANGES: [[f64; 2]; 3] =
    [[STEEPNESS.0 as f64, STEEPNESS.1 as f64], [0.0, 1.0], [1.0 / LENGTHS.1 as f64, 1.0 / LENGTHS.0 as f64]];

/// Lookup table of one parameter set.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    /// Shape `[θ_i, φ_i, λ]`.
    pub(super) nodes: Vec<Node>,
    /// Shape of `nodes`.
    pub(super) shares: Vec<Shares>,
    /// ρ of the mean. Shape of `nodes`.
    reflected: Vec<f32>,
}

/// The axes of a material's tables, with the nodes that are added at grazing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    theta: Axis,
    phi: Axis,
    /// cosθ_i that the lobes of each θ_i belong to.
    cos_theta: Vec<f32>,
    /// τ(φ_i) that the lobes of each φ_i belong to.
    tangents: Vec<f32>,
    /// Of each θ_i and φ_i. Shape `[θ_i, φ_i]`.
    slopes: Vec<Slope>,
    sides: Sides,
    wavelengths: Axis,
    /// Nodes along λ.
    waves: usize,
}

/// τ(φ) = tan(φ/2 + π/4) = (1 + sinφ)/cosφ of an azimuth's sine and cosine times anything positive, and that factor: as
/// numerator and denominator, without cancellation.
#[inline(always)]
pub(super) fn tangent(sine: f64, cosine: f64, factor: f64) -> [f64; 2] {
    let sum = factor + sine.abs();
    if sine < 0.0 { [cosine, sum] } else { [sum, cosine] }
}

/// The corners of a light's cell that count: the one below in both axes, the next along the axis with the larger share, the
/// one above in both. Arrays are over them; their last place repeats the one before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corners {
    /// Number of each corner's node at the shortest wavelength.
    pub(super) first: [u32; 3],
    /// cosθ_i that each corner's lobes belong to.
    pub(super) cos_theta: [f32; 4],
    /// τ(φ_i) that they belong to.
    pub(super) tangents: [f32; 4],
    /// Larger and smaller share.
    pub(super) shares: [f64; 2],
    /// How slopes tell.
    pub(super) slope: Slope,
}

/// A light's direction in the tables.
#[derive(Debug, Clone, Copy)]
pub(super) struct Incident {
    pub(super) corners: Corners,
    /// Whether the tables hold the mirror image: x of ω_o changes its sign.
    pub(super) mirrored: bool,
    /// [`tangent`] of the light's own φ_i.
    pub(super) tangent: [f64; 2],
    /// sinθ_i and cosθ_i.
    pub(super) along: [f64; 2],
}

/// Where eight lights lie in the tables: along both axes the place below and the share of the one above, and cosθ_i.
pub(super) struct Places {
    pub(super) theta: [(usize, f64); 8],
    pub(super) phi: [(usize, f64); 8],
    pub(super) cos_theta: [f64; 8],
}

impl Incident {
    /// cosθ and τ(φ) of one of the three corners.
    pub(super) fn corner(&self, corner: u8) -> [f64; 2] {
        let k = usize::from(corner).min(2);
        [self.corners.cos_theta[k], self.corners.tangents[k]].map(f64::from)
    }

    /// τ(φ_i) τ(φ_o) of an azimuth's sine and cosine times the same factor, and that cosine, both kept off the horizon so far
    /// that nothing overflows in single precision.
    #[inline(always)]
    pub(super) fn product(&self, sine: f64, cosine: f64, factor: f64) -> (f64, f64) {
        let cosine = cosine.max(LEAST_OUTGOING * factor);
        let [above, below] = tangent(if self.mirrored { -sine } else { sine }, cosine, factor);
        (self.tangent[0] * above / (self.tangent[1] * below), cosine)
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
    pub(super) fn new(material: &FeatherMaterial) -> Self {
        let axes = &material.axes;
        let stored = axes.cos_theta();
        let theta = Axis::new([&[0.0], stored].concat());
        let cos_theta = [&stored[..1], stored].concat().iter().map(|cosine| *cosine as f32).collect();
        // Rising in φ_i, with the lowest cosine's lobes again at grazing.
        let order = phi_order(axes);
        let signed = |phi: usize| (1.0 - axes.cos_phi()[axes.cosine_of(phi)]).copysign(axes.phi_i(phi));
        let mut places: Vec<f64> = order.iter().map(|phi| signed(*phi)).collect();
        let mut tangents: Vec<f32> = order
            .iter()
            .map(|phi| {
                let cosine = axes.cos_phi()[axes.cosine_of(*phi)];
                let sine = (1.0 - cosine * cosine).max(0.0).sqrt().copysign(axes.phi_i(*phi));
                let [above, below] = tangent(sine, cosine, 1.0);
                (above / below) as f32
            })
            .collect();
        places.push(1.0);
        tangents.push(tangents[tangents.len() - 1]);
        if axes.sides() == Sides::Both {
            places.insert(0, -1.0);
            tangents.insert(0, tangents[0]);
        }
        let waves = axes.wavelengths_nm().len();
        let columns = columns(&order, axes);
        let slopes = (0..=stored.len())
            .flat_map(|row| {
                let first = row.saturating_sub(1) * axes.phis();
                columns.iter().map(move |phi| material.slope(first + phi))
            })
            .collect();
        Self {
            slopes,
            theta,
            phi: Axis::new(places),
            cos_theta,
            tangents,
            sides: axes.sides(),
            wavelengths: Axis::new(axes.wavelengths_nm().to_vec()),
            waves,
        }
    }

    /// Numbers of θ_i, φ_i and λ.
    pub(super) fn sizes(&self) -> [usize; 3] {
        [self.cos_theta.len(), self.tangents.len(), self.waves]
    }

    pub(super) fn sides(&self) -> Sides {
        self.sides
    }

    /// Shortest and longest wavelength, nm.
    pub(super) fn wavelength_range_nm(&self) -> (f64, f64) {
        let places = &self.wavelengths.places;
        (places[0], places[places.len() - 1])
    }

    pub(super) fn arrays(&self) -> Vec<TableArray<'_>> {
        let [thetas, phis, waves] = self.sizes();
        vec![
            TableArray::new("wavelengths_nm", &[waves], &self.wavelengths.places),
            TableArray::new("theta", &[thetas], &self.theta.places),
            TableArray::new("phi", &[phis], &self.phi.places),
            TableArray::new("cos_theta", &[thetas], &self.cos_theta),
            TableArray::new("tangents", &[phis], &self.tangents),
            TableArray::new("slopes", &[thetas, phis, 3], cast_slice::<Slope, f64>(&self.slopes)),
        ]
    }

    pub(super) fn from_arrays(from: Arrays<'_>, sides: Sides, sizes: [usize; 3]) -> Result<Self> {
        let [thetas, phis, waves] = sizes;
        let axis = |name, count, range| Ok(Axis::new(from.rising(name, count, range)?.to_vec()));
        let slopes = from.get::<f64>("slopes", &[thetas, phis, 3], &SLOPE_RANGES)?.as_chunks().0;
        let slope = |&[steepness, strength, achromatic_inverse_length]: &[f64; 3]| Slope {
            steepness,
            strength,
            achromatic_inverse_length,
        };
        Ok(Self {
            theta: axis("theta", thetas, [0.0, 1.0])?,
            phi: axis("phi", phis, [-1.0, 1.0])?,
            cos_theta: from.get("cos_theta", &[thetas], &[[1e-7, 1.0]])?.to_vec(),
            tangents: from.get("tangents", &[phis], &[[1e-7, 1e7]])?.to_vec(),
            slopes: slopes.iter().map(slope).collect(),
            sides,
            wavelengths: axis("wavelengths_nm", waves, [100.0, 20_000.0])?,
            waves,
        })
    }

    /// The shares of the Gaussians along the barbule at the nodes, the narrow one first.
    pub(super) fn shares(&self, halo: &Halo) -> Vec<Shares> {
        let mut shares = Vec::with_capacity(self.cos_theta.len() * self.tangents.len() * self.waves);
        for cos_theta in &self.theta.places {
            for place in &self.phi.places {
                for nm in &self.wavelengths.places {
                    let [a, b, c] = halo.at(*nm, *cos_theta, 1.0 - place.abs()).shares;
                    let narrow = (1.0 - a - b - c).clamp(0.0, 1.0);
                    shares.push(Shares([narrow, a, b, c].map(|share| share as f32)));
                }
            }
        }
        shares
    }

    /// ω_i in the tables; both of its x and z count, z > 0.
    #[inline(always)]
    pub(super) fn incident(&self, [x, y, z]: [f64; 3]) -> Incident {
        let cos_theta = (x * x + z * z).sqrt().max(1e-9);
        let cos_phi = (z / cos_theta).min(1.0);
        let mirrored = self.sides == Sides::Alike && x < 0.0;
        let sine = if mirrored { -x } else { x };
        let place = (1.0 - cos_phi).copysign(sine);
        Incident {
            corners: self.corners(self.theta.find(cos_theta), self.phi.find(place)),
            mirrored,
            tangent: tangent(sine, z.max(LEAST_COSINE * cos_theta), cos_theta),
            along: [y, cos_theta],
        }
    }

    /// Where eight lights lie, as of [`Grid::incident`].
    #[inline(always)]
    pub(super) fn places<S: Simd>(&self, simd: S, [x, _, z]: &[[f64; 8]; 3]) -> Places {
        let (x, z) = (f64x8::from_slice(simd, x), f64x8::from_slice(simd, z));
        let one = f64x8::splat(simd, 1.0);
        let cos_theta = (x * x + z * z).sqrt().max(1e-9);
        let cos_phi = (z / cos_theta).min(1.0);
        let place = (one - cos_phi).copysign(if self.sides == Sides::Alike { one } else { x });
        Places {
            theta: self.theta.find_eight(cos_theta),
            phi: self.phi.find_eight(place),
            cos_theta: cos_theta.into(),
        }
    }

    /// The corners about a place along each axis.
    #[inline(always)]
    pub(super) fn corners(&self, (t, wt): (usize, f64), (below, wp): (usize, f64)) -> Corners {
        // From the normal outwards, so that mirror images are mixed alike.
        let (p, outwards, wp) =
            if self.phi.places[below] < 0.0 { (below + 1, below, 1.0 - wp) } else { (below, below + 1, wp) };
        let columns = self.tangents.len();
        let cell = |row: usize, column: usize| row * columns + column;
        let up = wt >= wp;
        let [near, far] = [self.cos_theta[t], self.cos_theta[t + 1]];
        let [inner, outer] = [self.tangents[p], self.tangents[outwards]];
        let cells = [cell(t, p), if up { cell(t + 1, p) } else { cell(t, outwards) }, cell(t + 1, outwards)];
        let node = |cell: usize| (cell * self.waves) as u32;
        let (larger, smaller) = (wt.max(wp), wt.min(wp));
        let [one, two, three] = [self.slopes[cells[0]], self.slopes[cells[1]], self.slopes[cells[2]]];
        let mixed = |a: f64, b: f64, c: f64| (1.0 - larger) * a + (larger - smaller) * b + smaller * c;
        let slope = Slope {
            steepness: mixed(one.steepness, two.steepness, three.steepness),
            strength: mixed(one.strength, two.strength, three.strength),
            achromatic_inverse_length: mixed(
                one.achromatic_inverse_length,
                two.achromatic_inverse_length,
                three.achromatic_inverse_length,
            ),
        };
        Corners {
            first: [node(cells[0]), node(cells[1]), node(cells[2])],
            cos_theta: [near, if up { far } else { near }, far, far],
            tangents: [inner, if up { inner } else { outer }, outer, outer],
            shares: [larger, smaller],
            slope,
        }
    }

    /// The nodes that are mixed at this wavelength.
    #[inline(always)]
    pub(super) fn simplex(&self, incident: &Incident, wavelength_nm: f64) -> Simplex {
        let (wave, share) = self.wavelengths.find(wavelength_nm);
        let (wave, up) = (wave as u32, self.next_wave());
        let Corners { first: corners, shares: [larger, smaller], .. } = incident.corners;
        // The axes are climbed in the order of their shares: λ first, second or last.
        let (first, second) = (share >= larger, share >= smaller);
        let (a, c) = (share.max(larger), share.min(smaller));
        let b = share.min(larger).max(smaller);
        let middle = [u8::from(!first), 2 - u8::from(second)];
        Simplex {
            at: [
                corners[0] + wave,
                corners[usize::from(middle[0])] + wave + up * u32::from(first),
                corners[usize::from(middle[1])] + wave + up * u32::from(second),
                corners[2] + wave + up,
            ],
            weight: [(1.0 - a) as f32, (a - b) as f32, (b - c) as f32, c as f32],
            middle,
        }
    }
}

impl Grid {
    /// The wavelength's node below and the share of the next, as of [`Grid::simplex`].
    #[inline(always)]
    pub(super) fn waves_at<S: Simd>(&self, simd: S, wavelengths_nm: &[f32; 4]) -> (i32x4<S>, f32x4<S>) {
        let Axis { places, inverse_spacing } = &self.wavelengths;
        let Some(inverse) = inverse_spacing else {
            let mut found = ([0; 4], [0.0; 4]);
            for (k, nm) in wavelengths_nm.iter().enumerate() {
                let (index, share) = self.wavelengths.find(f64::from(*nm));
                (found.0[k], found.1[k]) = (index as i32, share as f32);
            }
            return (i32x4::simd_from(simd, found.0), f32x4::simd_from(simd, found.1));
        };
        let nm = f32x4::from_slice(simd, wavelengths_nm);
        let last = self.waves as i32 - 2;
        let position = ((nm - places[0] as f32) * *inverse as f32).max(0.0).min((last + 1) as f32);
        let index = position.to_int::<i32x4<S>>().min(last);
        (index, position - f32x4::float_from(index))
    }

    /// From a node to that of the next wavelength.
    #[inline(always)]
    pub(super) fn next_wave(&self) -> u32 {
        u32::from(self.waves > 1)
    }
}

/// Numbers of the stored φ_i in rising order of φ_i.
fn phi_order(axes: &Axes) -> Vec<usize> {
    let cosines = axes.cos_phi().len();
    // Of φ_i ≥ 0 cosines rise, so φ_i falls; of φ_i < 0 both rise.
    (cosines..axes.phis()).chain((0..cosines).rev()).collect()
}

/// Numbers of the stored φ_i of all columns, those that are added at grazing too: they continue the next one.
fn columns(order: &[usize], axes: &Axes) -> Vec<usize> {
    let (first, last) = (order[0], order[order.len() - 1]);
    let before = (axes.sides() == Sides::Both).then_some(first);
    before.into_iter().chain(order.iter().copied()).chain([last]).collect()
}

impl Table {
    /// Prepares one set; of unpolarized light `polarization` says whose part of it `reflected` is.
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
                let phi_i = axes.phi_i(at % phis);
                Entry { material, set, at, cos_theta, phi_i, areas: &areas }.node()
            })
            .collect();
        let reflected =
            |wave: usize, theta: usize, phi: usize| -> f64 { set.reflected(axes.index(wave, theta, phi)) };
        let energies: Vec<f64> = match polarization {
            Some(polarization) if material.sets.len() == 1 => (0..waves * thetas * phis)
                .into_par_iter()
                .map(|at| {
                    let (cos_theta, phi_i) = (axes.cos_theta()[at / phis % thetas], axes.phi_i(at % phis));
                    let first = Entry { material, set, at, cos_theta, phi_i, areas: &areas }.first_energy();
                    2.0 * if polarization == Polarization::First { first } else { 1.0 - first }
                })
                .collect(),
            _ => Vec::new(),
        };
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
                    let own = energies.get(at).copied().unwrap_or(1.0);
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
    /// The arrays of this set; `prefix` stands before their names.
    pub(super) fn arrays(&self, prefix: &str, sizes: [usize; 3]) -> [TableArray<'_>; 3] {
        let [thetas, phis, waves] = sizes;
        let of_nodes = |width: usize| [thetas, phis, waves, width];
        [
            TableArray::new(format!("{prefix}nodes"), &of_nodes(16), cast_slice::<Node, f32>(&self.nodes)),
            TableArray::new(format!("{prefix}shares"), &of_nodes(4), cast_slice::<Shares, f32>(&self.shares)),
            TableArray::new(format!("{prefix}reflected"), &sizes, &self.reflected),
        ]
    }

    pub(super) fn from_arrays(from: Arrays<'_>, prefix: &str, sizes: [usize; 3]) -> Result<Self> {
        let [thetas, phis, waves] = sizes;
        let get = |name: &str, shape: &[usize], ranges: &[[f64; 2]]| {
            from.get::<f32>(&format!("{prefix}{name}"), shape, ranges)
        };
        let nodes = get("nodes", &[thetas, phis, waves, 16], &NODE_RANGES)?;
        let shares = get("shares", &[thetas, phis, waves, 4], &SHARE_RANGES)?;
        Ok(Self {
            nodes: nodes.as_chunks().0.iter().map(|node| Node(*node)).collect(),
            shares: shares.as_chunks().0.iter().map(|shares| Shares(*shares)).collect(),
            reflected: get("reflected", &sizes, &[REFLECTED_RANGE])?.to_vec(),
        })
    }

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
    /// Reflects so many times as much, of which the same part is steady.
    fn times(mut self, factor: f32) -> Self {
        self.0[STRENGTH..STRENGTH + LOBES - 1].iter_mut().for_each(|strength| *strength *= factor);
        self
    }
}

impl Shares {
    fn times(self, factor: f32) -> Self {
        Self(self.0.map(|share| share * factor.max(1e-3)))
    }
}
