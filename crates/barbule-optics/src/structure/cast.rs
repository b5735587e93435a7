//! What lies below points of the top surface, along the inward normal, in the true regions.

mod hulls;

use hulls::Hulls;

use super::columns::{Columns, Palette, PaletteMixture, SlotMixture};
use super::section::{Loop, Medium, Polyline, Section, Substance};
use super::smooth::averaged;
use crate::error::shortened;
use crate::material::Material;
use crate::{Error, Result};

/// Layers thinner than this are rounding, µm: 1e-6 nm.
const NO_THICKNESS_UM: f64 = 1e-9;

/// Layers under all rays together, and slots times rays; simulations take about 40 bytes for each.
pub(super) const MOST_LAYERS: usize = 1 << 26;

/// A point on the top boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Position across the barbule.
    pub x_um: f64,
    /// Height.
    pub z_um: f64,
    /// Outward unit normal (n_x, n_z).
    pub normal: [f64; 2],
}

/// Finds the layers under each ray: distances along −normal between consecutive changes of the medium.
///
/// Exact for polylines and circles. Beyond the ends of the section the end segments' lines go on, until the ray is
/// above or below all of them. A ray ends at twice the height of the section (which only rays inclined by over 60°
/// reach, where no layered description holds): the medium there goes on as its substrate. A mixture's fraction is that
/// at the ray's own x, the point on the top, all the way down. Where the section says so ([`Section::smooth_um`]) the layers are
/// averaged along the top.
///
/// # Errors
/// The section has no boundaries, over 65,535 media, or over 67,108,864 layers under the rays together.
pub fn cast(section: &Section, rays: &[Ray]) -> Result<Columns> {
    match section.smooth_um {
        Some(deviation_um) if !section.inclusions.is_empty() && !section.boundaries.is_empty() => {
            averaged(section, rays, deviation_um)
        }
        _ => layers(section, rays),
    }
}

/// As [`cast`], every ray for itself.
pub(super) fn layers(section: &Section, rays: &[Ray]) -> Result<Columns> {
    if section.boundaries.is_empty() {
        return Err(Error::input(format!(
            "the section '{}' has no top boundary, so that nothing lies below it; add boundaries, or use the full-wave solver",
            section.name
        )));
    }
    let (palette, fillings) = palette(section)?;
    let (profiles, fillings) = parting(section, fillings);
    let hulls = Hulls::new(section);
    let mut slots = Slots::default();
    let mut found: Vec<Found> = Vec::new();
    let mut ends = Vec::with_capacity(rays.len());
    let mut state = State { limits: Limits::new(section), ..State::default() };
    for ray in rays {
        layers_below(&profiles, &hulls, ray, &mut state);
        state.emit(&fillings, profiles.len(), &mut found);
        ends.push(found.len());
        if found.len() > MOST_LAYERS {
            return Err(too_many(section, rays.len()));
        }
    }
    // The longest sequence first: most others are parts of it.
    let span = |ray: usize| if ray == 0 { 0 } else { ends[ray - 1] }..ends[ray];
    if let Some(longest) = (0..rays.len()).max_by_key(|&ray| (span(ray).len(), std::cmp::Reverse(ray))) {
        slots.place(&mut found[span(longest)], &fillings);
    }
    for ray in 0..rays.len() {
        slots.place(&mut found[span(ray)], &fillings);
    }
    let layers = slots.kinds.len();
    if (layers + 1).saturating_mul(rays.len()) > MOST_LAYERS {
        return Err(too_many(section, rays.len()));
    }
    let blank = |kind: Kind| PaletteMixture { a: kind.a, b: kind.b, fraction: 0.0 };
    // Pure media are the same under all rays; the substrates of rays may differ.
    let substrate = blank(fillings[fillings.len() - 1].kind);
    let mut mixture: Vec<SlotMixture> = slots
        .kinds
        .iter()
        .map(|&kind| match kind.a == kind.b {
            true => SlotMixture::Uniform(blank(kind)),
            false => SlotMixture::Varying(vec![blank(kind); rays.len()]),
        })
        .chain([SlotMixture::Varying(vec![substrate; rays.len()])])
        .collect();
    let mut thickness_um = vec![0.0; (layers + 1) * rays.len()];
    for (index, ray) in rays.iter().enumerate() {
        for layer in &found[span(index)] {
            let slot = layer.slot().unwrap_or(layers);
            if slot < layers {
                thickness_um[slot * rays.len() + index] = layer.thickness_um;
            }
            if let SlotMixture::Varying(row) = &mut mixture[slot] {
                let Filling { kind, mixed } = fillings[layer.filling as usize];
                let fraction = mixed.map_or(0.0, |medium| all_media(section, medium).fraction(ray.x_um));
                row[index] = PaletteMixture { fraction, ..blank(kind) };
            }
        }
    }
    let mixture = mixture.into_iter().map(|slot| slot.simplified(palette.len())).collect();
    let palette = Palette { materials: palette };
    Ok(Columns { rays: rays.len(), slots: layers + 1, thickness_um, mixture, palette })
}

/// The boundaries at which the medium changes, with the fillings of inclusions and then of the layers between these.
fn parting(section: &Section, fillings: Vec<Filling>) -> (Vec<Profile<'_>>, Vec<Filling>) {
    let first = section.inclusions.len();
    let parts = |index: &usize| fillings[first + index] != fillings[first + index + 1];
    let kept: Vec<usize> =
        (0..section.boundaries.len()).filter(|index| *index == 0 || parts(index)).collect();
    let profiles = kept.iter().map(|&index| Profile::new(&section.boundaries[index])).collect();
    let below = kept.iter().map(|index| fillings[first + index + 1]);
    let all = fillings[..=first].iter().copied().chain(below).collect();
    (profiles, all)
}

fn too_many(section: &Section, rays: usize) -> Error {
    Error::input(format!(
        "the section '{}' has over {MOST_LAYERS} layers under {rays} places of its top, more than can be simulated; \
         give fewer layers or inclusions, or a narrower section",
        shortened(&section.name)
    ))
}

/// Two palette entries, equal for a pure medium.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Kind {
    a: u16,
    b: u16,
}

/// What the layer under a boundary, or an inclusion, is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Filling {
    kind: Kind,
    /// The medium, where its fraction varies.
    mixed: Option<usize>,
}

/// A medium by number: inclusions first, then from the top down.
fn all_media(section: &Section, index: usize) -> &Medium {
    let inclusions = section.inclusions.len();
    if index < inclusions { &section.inclusions[index].medium } else { &section.media[index - inclusions] }
}

/// The distinct materials, and the filling of each inclusion and then of each layer.
fn palette(section: &Section) -> Result<(Vec<Material>, Vec<Filling>)> {
    let mut substances: Vec<&Substance> = Vec::new();
    let mut entry = |substance| -> Result<u16> {
        let at = substances.iter().position(|known| *known == substance).unwrap_or_else(|| {
            substances.push(substance);
            substances.len() - 1
        });
        u16::try_from(at).map_err(|_| Error::input("the section has over 65535 different media".to_owned()))
    };
    let mut fillings = Vec::new();
    for index in 0..section.inclusions.len() + section.media.len() {
        fillings.push(match all_media(section, index) {
            Medium::Pure(substance) => {
                let a = entry(substance)?;
                Filling { kind: Kind { a, b: a }, mixed: None }
            }
            Medium::Mixture { first, second, .. } => {
                Filling { kind: Kind { a: entry(first)?, b: entry(second)? }, mixed: Some(index) }
            }
        });
    }
    let materials = substances.into_iter().map(|s| section.material(s)).collect::<Result<Vec<_>>>()?;
    Ok((materials, fillings))
}

/// One layer under one ray: as small as can be, since there are millions.
#[derive(Debug, Clone, Copy)]
struct Found {
    filling: u32,
    slot: u32,
    thickness_um: f64,
}

impl Found {
    const NO_SLOT: u32 = u32::MAX;

    /// The slot; the substrate has none.
    fn slot(&self) -> Option<usize> {
        (self.slot != Self::NO_SLOT).then_some(self.slot as usize)
    }
}

/// The kinds of the shared slots, grown as rays need it.
#[derive(Debug, Default)]
struct Slots {
    kinds: Vec<Kind>,
}

impl Slots {
    /// Puts each layer of a ray (its last is the substrate) into the first free slot of its kind.
    fn place(&mut self, ray: &mut [Found], fillings: &[Filling]) {
        let mut next = 0;
        let layers = ray.len().saturating_sub(1);
        for layer in &mut ray[..layers] {
            let kind = fillings[layer.filling as usize].kind;
            let slot = (next..self.kinds.len()).find(|&slot| self.kinds[slot] == kind).unwrap_or_else(|| {
                self.kinds.push(kind);
                self.kinds.len() - 1
            });
            layer.slot = slot as u32;
            next = slot + 1;
        }
    }
}

/// What a crossing changes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    /// The ray goes below a boundary.
    Below,
    /// The ray comes above a boundary.
    Above,
    /// The ray goes into or out of a loop.
    Loop(u32),
}

/// Where rays end.
#[derive(Debug, Clone, Copy, Default)]
struct Limits {
    longest: f64,
    left: f64,
    right: f64,
}

impl Limits {
    fn new(section: &Section) -> Self {
        let boundaries = section.boundaries.iter().flat_map(|boundary| &boundary.z_um);
        let loops = section.inclusions.iter().flat_map(|inclusion| match &inclusion.outline {
            Loop::Polygon(corners) => corners.z_um.clone(),
            Loop::Circle { z_um, radius_um, .. } => vec![z_um - radius_um, z_um + radius_um],
        });
        let heights = boundaries.copied().chain(loops);
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        let xs = &section.top().x_um;
        Self { longest: 2.0 * (high - low), left: xs[0], right: xs[xs.len() - 1] }
    }

    /// The parameter at which a ray leaves the section's extent in x.
    fn leaves(&self, ray: &Ray) -> f64 {
        let dx = -ray.normal[0];
        let end = if dx > 0.0 { self.right } else { self.left };
        if dx == 0.0 { f64::INFINITY } else { (end - ray.x_um) / dx }
    }
}

/// Buffers of one ray.
#[derive(Debug, Default)]
struct State {
    limits: Limits,
    /// Where the current ray leaves the section's extent in x.
    leaves: f64,
    /// Boundaries above the start.
    above: usize,
    crossings: Vec<(f64, Change)>,
    /// (depth, loop, filling if not the layers') of the loops that hold the current point.
    inside: Vec<(u32, u32, Option<usize>)>,
    /// Per loop: its depth and the inclusion that shows in it.
    nested: Vec<(u32, Option<usize>)>,
}

/// All crossings of a ray in order.
fn layers_below(profiles: &[Profile<'_>], hulls: &Hulls<'_>, ray: &Ray, state: &mut State) {
    let direction = [-ray.normal[0], -ray.normal[1]];
    state.crossings.clear();
    state.leaves = state.limits.leaves(ray);
    state.above = 1;
    for (index, profile) in profiles.iter().enumerate() {
        let below = profile.cross(ray, direction, index == 0, &mut state.crossings);
        if index > 0 {
            state.above += usize::from(below);
        }
    }
    if state.nested.len() != hulls.nested.len() {
        state.nested.clone_from(&hulls.nested);
    }
    hulls.cross(ray, direction, &mut state.crossings);
    state.crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
}

impl State {
    /// Turns crossings into layers, the substrate last, merging what has no thickness or the same medium.
    fn emit(&mut self, fillings: &[Filling], boundaries: usize, into: &mut Vec<Found>) {
        let inclusions = fillings.len() - boundaries - 1;
        let start = into.len();
        let mut above = self.above as isize;
        self.inside.clear();
        let (mut from, mut index) = (0.0, 0);
        loop {
            let last = self.crossings.get(index).is_none_or(|&(t, _)| {
                let outside = above <= 0 || above >= boundaries as isize;
                t > self.limits.longest || (outside && t > self.leaves)
            });
            let to = if last { f64::INFINITY } else { self.crossings[index].0.max(from) };
            if to - from > NO_THICKNESS_UM {
                let deepest = self.inside.iter().max_by_key(|entry| entry.0).and_then(|entry| entry.2);
                let layer = above.clamp(0, boundaries as isize) as usize;
                let filling = deepest.unwrap_or(inclusions + layer);
                match into[start..].last_mut() {
                    Some(before) if fillings[before.filling as usize] == fillings[filling] => {
                        before.thickness_um += to - from;
                    }
                    _ => into.push(Found {
                        filling: filling as u32,
                        slot: Found::NO_SLOT,
                        thickness_um: to - from,
                    }),
                }
                from = to;
            }
            if last {
                break;
            }
            match self.crossings[index].1 {
                Change::Below => above += 1,
                Change::Above => above -= 1,
                Change::Loop(id) => match self.inside.iter().position(|entry| entry.1 == id) {
                    Some(at) => {
                        self.inside.swap_remove(at);
                    }
                    None => {
                        let (depth, shows) = self.nested[id as usize];
                        self.inside.push((depth, id, shows));
                    }
                },
            }
            index += 1;
        }
    }
}

/// A boundary with what lets a search along it stop early.
struct Profile<'a> {
    curve: &'a Polyline,
    /// Lowest and highest z of the points before and including each.
    low_before: Vec<f64>,
    high_before: Vec<f64>,
    /// The same of the points from each on.
    low_after: Vec<f64>,
    high_after: Vec<f64>,
    /// Slopes of the first and the last segment.
    end_slopes: [f64; 2],
    /// The first segment that reaches into each of as many equal stretches as there are segments.
    stretches: Vec<u32>,
    per_stretch: f64,
}

impl<'a> Profile<'a> {
    fn new(curve: &'a Polyline) -> Self {
        let scan = |start: f64, pick: fn(f64, f64) -> f64, backwards: bool| -> Vec<f64> {
            let mut best = start;
            let mut out = vec![0.0; curve.z_um.len()];
            let count = out.len();
            for step in 0..count {
                let i = if backwards { count - 1 - step } else { step };
                best = pick(best, curve.z_um[i]);
                out[i] = best;
            }
            out
        };
        let last = curve.x_um.len() - 1;
        let slope = |i: usize| (curve.z_um[i + 1] - curve.z_um[i]) / (curve.x_um[i + 1] - curve.x_um[i]);
        let xs = &curve.x_um;
        let per_stretch = (xs[last] - xs[0]) / last as f64;
        let mut segment = 0;
        let stretches = (0..last)
            .map(|stretch| {
                let start = xs[0] + per_stretch * stretch as f64;
                while segment + 1 < last && xs[segment + 1] <= start {
                    segment += 1;
                }
                segment as u32
            })
            .collect();
        Self {
            curve,
            stretches,
            per_stretch,
            end_slopes: [slope(0), slope(last - 1)],
            low_before: scan(f64::INFINITY, f64::min, false),
            high_before: scan(f64::NEG_INFINITY, f64::max, false),
            low_after: scan(f64::INFINITY, f64::min, true),
            high_after: scan(f64::NEG_INFINITY, f64::max, true),
        }
    }

    /// The segment over x; the outermost ones go on past the ends.
    fn segment(&self, x: f64) -> usize {
        let xs = &self.curve.x_um;
        // A cast of a negative number gives 0.
        let stretch = (((x - xs[0]) / self.per_stretch) as usize).min(self.stretches.len() - 1);
        let mut i = self.stretches[stretch] as usize;
        while i + 2 < xs.len() && xs[i + 1] <= x {
            i += 1;
        }
        while i > 0 && xs[i] > x {
            i -= 1;
        }
        i
    }

    /// Adds the crossings of a ray; returns whether the ray starts below the boundary (on it counts as below).
    ///
    /// The boundary is a function of x, so a ray is below it or above it at each of its points: the sign of
    /// z_ray − z_boundary is followed from segment to segment.
    fn cross(&self, ray: &Ray, direction: [f64; 2], on_it: bool, out: &mut Vec<(f64, Change)>) -> bool {
        let (xs, zs) = (&self.curve.x_um, &self.curve.z_um);
        let last = xs.len() - 1;
        let [dx, dz] = direction;
        let line = |i: usize, x: f64| zs[i] + (zs[i + 1] - zs[i]) * ((x - xs[i]) / (xs[i + 1] - xs[i]));
        // Nothing happens above the highest point, as long as that stretch is within the section.
        let highest = self.high_after[0];
        let skip = if !on_it && dz < 0.0 && ray.z_um > highest { (ray.z_um - highest) / -dz } else { 0.0 };
        let x = ray.x_um + skip * dx;
        let skips = skip > 0.0 && ray.x_um.min(x) >= xs[0] && ray.x_um.max(x) <= xs[last];
        let (x, mut reached) = if skips { (x, skip) } else { (ray.x_um, 0.0) };
        let mut i = self.segment(x);
        // Height over the boundary at the parameter reached.
        let mut over = if on_it { 0.0 } else { ray.z_um + reached * dz - line(i, x) };
        if skips {
            over = over.max(f64::MIN_POSITIVE);
        }
        let starts_below = over <= 0.0;
        let mut below = starts_below;
        let mut emit = |t: f64, below: bool| out.push((t, if below { Change::Below } else { Change::Above }));
        let right = dx > 0.0;
        let per_dx = 1.0 / dx;
        loop {
            let vertex = if right { i + 1 } else { i };
            let outermost = dx == 0.0 || vertex == if right { last } else { 0 };
            let t_end =
                if outermost { f64::INFINITY } else { ((xs[vertex] - ray.x_um) * per_dx).max(reached) };
            if t_end == f64::INFINITY {
                // One line from here on: at most one crossing.
                let rate = dz - (zs[i + 1] - zs[i]) / (xs[i + 1] - xs[i]) * dx;
                let t = reached - over / rate;
                let comes = if below { rate > 0.0 } else { rate < 0.0 };
                if comes && t.is_finite() && (t > reached || over != 0.0) {
                    emit(t.max(reached), !below);
                }
                return starts_below;
            }
            let height = ray.z_um + t_end * dz;
            let end_over = height - zs[vertex];
            // At the point where it starts on the top the ray goes inwards; rounding must not bring it out again.
            let now_below = if on_it && below { end_over <= NO_THICKNESS_UM } else { end_over <= 0.0 };
            if now_below != below {
                let part = if over == end_over { 0.0 } else { (over / (over - end_over)).clamp(0.0, 1.0) };
                emit(reached + (t_end - reached) * part, now_below);
                below = now_below;
            }
            (over, reached) = (end_over, t_end);
            let (low, high, end_slope) = if right {
                (self.low_after[vertex], self.high_after[vertex], self.end_slopes[1])
            } else {
                (self.low_before[vertex], self.high_before[vertex], self.end_slopes[0])
            };
            // Past the last vertex the end line may still catch up with the ray.
            let rate = dz - end_slope * dx;
            let stays_below = below && dz <= 0.0 && height < low && rate <= 0.0;
            if stays_below || (!below && dz >= 0.0 && height > high && rate >= 0.0) {
                return starts_below;
            }
            i = if right { i + 1 } else { i - 1 };
        }
    }
}
