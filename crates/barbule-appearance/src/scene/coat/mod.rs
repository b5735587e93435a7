//! Coats: many feathers on a curved body.
//!
//! Follicles are spread over the body ([`follicles`]), each bears one of some kinds of feathers ([`kinds`]), which lie along a field of directions ([`field`]), are bent as the
//! body is ([`Coat::lay`]), and are laid from the tail to the head, each over those before it (`lay`), after Chen, Xu, Guo &
//! Shum 2002 and Streit & Heidrich 2002.

pub mod body;
pub mod field;
pub mod follicles;
pub mod kinds;
mod lay;
mod shape;

use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DVec3};

use self::body::{Body, Spot};
use self::field::{Field, Guide};
use self::follicles::{Area, Bare, Ground, Region};
use self::kinds::Kinds;
use super::feather::{Feather, Shaft, VaneDisc};
use super::geometry::Place;
use crate::math::rng::{Stream, hash};
use crate::progress::{Progress, Unobserved};
use crate::scene::go_on;
use crate::{Error, Result};

/// Most feathers.
pub const MOST_FEATHERS: usize = 50_000;
/// Share of the quill that is in the skin.
const ROOTED: f64 = 0.5;
/// Edges of a body over the feathers' length.
const EDGE: f64 = 0.1;
/// Share of its rise by which a feather bends back to the body from base to tip.
const SETTLED: f64 = 0.6;
/// How far from its own curvature, in numbers of variants, a feather's variant may be: the same one shall not stand in rows.
const MIXED: f64 = 0.3;
/// Share of their spread that barbs of the downy part keep under the feathers above.
const PRESSED: f64 = 0.25;
/// By how much a feather is lifted at most where nothing is said, rad.
pub const MOST_LIFT: f64 = 0.2;
/// Least size of a feather before a bare place, over that of its neighbours.
const SHORTEST: f64 = 0.15;
/// Names of random streams and variants.
const STAND: u64 = 0x73_7461;
const VARIANT: u64 = 0x7661_7269;

/// How feathers stand on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Coat {
    /// How many there are.
    pub number: Number,
    /// Where they grow; everywhere where nothing is said.
    pub region: Option<Region>,
    /// Places without feathers, which those about them do not reach into.
    pub bare: Vec<Bare>,
    /// Which way they lie.
    pub guides: Vec<Guide>,
    /// Angle between the skin and a feather's base, degrees, and its standard deviation.
    pub erection_deg: f64,
    /// See `erection_deg`.
    pub erection_jitter_deg: f64,
    /// Standard deviation of their turn within the skin, degrees.
    pub turn_jitter_deg: f64,
    /// Standard deviation of their size, as a share.
    pub size_jitter: f64,
    /// How many are grown of each kind; each stands at many places.
    pub variants: usize,
    /// How far over the feathers beneath one of size 1 lies, mm.
    pub clearance_mm: f64,
    /// By how much one is lifted at most for that, rad.
    pub most_lift: f64,
    /// 0: bent as the feather says; 1: bent as the body is.
    pub hug: f64,
}

/// How many feathers there are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Number {
    /// So many.
    Count(usize),
    /// So many on a cm² of the body, where guides leave them their size.
    PerCm2(f64),
}

/// One feather of a coat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    /// Its follicle.
    pub spot: Spot,
    /// From its root to its tip, in the skin.
    pub along: DVec3,
    /// Angle between that and the feather's y axis, rad.
    pub erection: f64,
    /// Factor to its lengths.
    pub scale: f64,
    /// The size that guides ask for there, without the differences between neighbours.
    pub size: f64,
    /// Which of the coat's kinds it is.
    pub kind: usize,
    /// Which of the coat's feathers it is.
    pub variant: usize,
}

/// A feather that is grown, bent as the body is at its places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {
    /// Of which kind it is.
    pub kind: usize,
    /// The feather.
    pub feather: Feather,
}

/// A coat that is laid.
#[derive(Debug, Clone)]
pub struct Laid {
    /// The body.
    pub body: Body,
    /// Area where feathers grow, mm².
    pub area_mm2: f64,
    /// Whether the body's faces looked inwards and were turned.
    pub was_inside_out: bool,
    /// The feathers that are grown, as many of each kind, in the kinds' order.
    pub variants: Vec<Variant>,
    /// All feathers.
    pub stands: Vec<Stand>,
    /// The feathers as they stood before they were lifted off each other.
    pub before: Vec<Stand>,
    /// From the undermost feather to the uppermost.
    pub order: Vec<u32>,
    shapes: Vec<shape::Shape>,
}

impl Stand {
    /// Where a feather stands whose window begins at [`window`]: its y along the shaft, z away from the body.
    #[must_use]
    pub fn place(&self, id: u64) -> Place {
        let (sin, cos) = (libm::sin(self.erection), libm::cos(self.erection));
        let Spot { point, normal, .. } = self.spot;
        let tip = self.along * cos + normal * sin;
        let dorsal = normal * cos - self.along * sin;
        let turn = DMat3::from_cols(tip.cross(dorsal), tip, dorsal);
        Place { scale: self.scale, turn, shift: point, id }
    }
}

/// The whole feather about the point of its quill that is at the skin's surface.
#[must_use]
pub fn window(feather: &Feather) -> VaneDisc {
    VaneDisc { along_mm: ROOTED * feather.shaft.calamus * feather.shaft.length_mm, radius_mm: None }
}

/// The seed from which one of a coat's feathers grows.
#[must_use]
pub fn seed_of(variant: usize, seed: u64) -> u64 {
    hash(seed, &[VARIANT, variant as u64])
}

/// Longest edges that a body has under feathers like these, mm.
#[must_use]
pub fn edge_mm(feathers: &[Feather]) -> f64 {
    EDGE * lengths_mm(feathers)[0]
}

/// The shortest and the longest of feathers, mm.
fn lengths_mm(feathers: &[Feather]) -> [f64; 2] {
    let lengths = || feathers.iter().map(|feather| feather.shaft.length_mm);
    [lengths().fold(f64::INFINITY, f64::min), lengths().fold(0.0, f64::max)]
}

impl Coat {
    /// Lays feathers like these on a body; the same for the same seed on any number of threads.
    ///
    /// # Errors
    /// A region that holds next to none of the body, no or too many feathers by the density, no kind of feather or one that is not
    /// there, or a feather out of range.
    pub fn lay(&self, body: Body, feathers: &[Feather], kinds: Kinds<'_>, seed: u64) -> Result<Laid> {
        self.lay_watched(body, feathers, kinds, seed, &Unobserved)
    }

    /// The same for who may stop it.
    ///
    /// # Errors
    /// As [`Coat::lay`], or a stop by `progress`.
    pub fn lay_watched(
        &self,
        body: Body,
        feathers: &[Feather],
        kinds: Kinds<'_>,
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<Laid> {
        if feathers.is_empty() {
            return Err(Error::input("the coat has no feather; give one kind at least"));
        }
        let [_, longest] = lengths_mm(feathers);
        let field = Field::new(&body, &self.guides, (0.5 * longest, self.erection_deg), progress)?;
        let varies = self.sizes() != [1.0; 2];
        let ground =
            Ground { body: &body, region: self.region, bare: &self.bare, field: varies.then_some(&field) };
        let area = follicles::area(ground);
        let spots = follicles::scattered(ground, area, self.count(area)?, seed, progress)?;
        let kinds = kinds.of(&body, &spots, &self.guides, feathers.len(), seed)?;
        let mut stands = self.stands(&body, &field, (&spots, &kinds), feathers, seed);
        let variants = self.bent(&body, &mut stands, feathers, seed, progress)?;
        // A bent feather has turned from its y axis by the point where it leaves the skin.
        stands.iter_mut().for_each(|stand| stand.erection -= heading(&variants[stand.variant].feather));
        let cell_mm = self.cell_mm(feathers);
        // Points of the largest feathers stand as dense as cells.
        let step_mm = cell_mm / self.sizes()[1];
        let shapes = variants
            .iter()
            .enumerate()
            .map(|(variant, Variant { feather, .. })| {
                shape::Shape::new(feather, seed_of(variant, seed), step_mm, progress)
            })
            .collect::<Result<Vec<_>>>()?;
        let before = stands.clone();
        let order = lay::order(&stands, longest, progress)?;
        let lifting = lay::Lifting { cell_mm, clearance_mm: self.clearance_mm, most: self.most_lift };
        lay::lift(&body, &mut stands, (&order, &shapes), lifting, progress)?;
        let was_inside_out = body.was_inside_out;
        Ok(Laid { body, area_mm2: area.mm2, was_inside_out, variants, stands, before, order, shapes })
    }

    /// The least and the largest size that guides ask for, 1 among them.
    #[must_use]
    pub fn sizes(&self) -> [f64; 2] {
        let all = || self.guides.iter().map(|guide| guide.size);
        [all().fold(1.0, f64::min), all().fold(1.0, f64::max)]
    }

    /// Longest edges that a body has under its feathers, mm.
    #[must_use]
    pub fn edge_mm(&self, feathers: &[Feather]) -> f64 {
        edge_mm(feathers) * self.sizes()[0]
    }

    fn cell_mm(&self, feathers: &[Feather]) -> f64 {
        let ([shortest, longest], [least, largest]) = (lengths_mm(feathers), self.sizes());
        lay::cell_mm([shortest * least, longest * largest])
    }

    fn count(&self, area: Area) -> Result<usize> {
        match self.number {
            Number::Count(count) => Ok(count),
            Number::PerCm2(density) => {
                let count = (0.01 * area.felt_mm2 * density).round();
                if !(1.0..=MOST_FEATHERS as f64).contains(&count) {
                    return Err(Error::input(format!(
                        "coat.density_per_cm2 makes {count} feathers on {:.4} cm², but there must be 1 to {MOST_FEATHERS}; \
                         give another density",
                        0.01 * area.mm2
                    )));
                }
                Ok(count as usize)
            }
        }
    }

    /// A feather at each follicle, as if it were alone.
    fn stands(
        &self,
        body: &Body,
        field: &Field,
        (spots, kinds): (&[Spot], &[usize]),
        feathers: &[Feather],
        seed: u64,
    ) -> Vec<Stand> {
        let stand = |(index, (spot, &kind)): (u64, (&Spot, &usize))| {
            let mut stream = Stream::new(seed, &[STAND, index]);
            let mut jitter = |spread: f64| spread * stream.normal().clamp(-2.5, 2.5);
            let along = field.at(body, spot);
            let turn = jitter(self.turn_jitter_deg).to_radians();
            let along = along * libm::cos(turn) + spot.normal.cross(along) * libm::sin(turn);
            let [size, erection_deg] = field.stature(body, spot.triangle, spot.weights);
            let erection = (erection_deg + jitter(self.erection_jitter_deg)).max(0.0).to_radians();
            let scale = size * (1.0 + jitter(self.size_jitter)).max(0.2);
            let scale = scale.min(self.room(spot, along, &feathers[kind])).max(SHORTEST * size);
            Stand { spot: *spot, along, erection, scale, size, kind, variant: 0 }
        };
        (0..).zip(spots.iter().zip(kinds)).map(stand).collect()
    }

    /// The size at which a feather's tip reaches the next bare place ahead of it.
    fn room(&self, spot: &Spot, along: DVec3, feather: &Feather) -> f64 {
        let length = feather.shaft.length_mm - window(feather).along_mm;
        let ahead = self.bare.iter().filter_map(|bare| bare.ahead_mm(spot.point, along));
        ahead.fold(f64::INFINITY, f64::min) / length
    }

    /// The variants of all kinds, each bent as the body is where it stands; which one each feather is is set here.
    fn bent(
        &self,
        body: &Body,
        stands: &mut [Stand],
        feathers: &[Feather],
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<Vec<Variant>> {
        let mut stream = Stream::new(seed, &[VARIANT]);
        let mut variants = Vec::with_capacity(feathers.len() * self.variants);
        for (kind, feather) in feathers.iter().enumerate() {
            go_on(progress)?;
            let mut own: Vec<&mut Stand> = stands.iter_mut().filter(|stand| stand.kind == kind).collect();
            let bent = self.bent_of_kind(body, &mut own, feather, &mut stream);
            own.iter_mut().for_each(|stand| stand.variant += variants.len());
            variants.extend(bent.into_iter().map(|feather| Variant { kind, feather }));
        }
        Ok(variants)
    }

    /// Those of one kind, counted from 0.
    fn bent_of_kind(
        &self,
        body: &Body,
        stands: &mut [&mut Stand],
        feather: &Feather,
        stream: &mut Stream,
    ) -> Vec<Feather> {
        let width = feather.barbs.leading_half_width_mm.max(feather.barbs.trailing_half_width_mm);
        let length = feather.shaft.length_mm;
        let bends: Vec<[f64; 2]> = stands
            .iter()
            .map(|stand| {
                let across = stand.spot.normal.cross(stand.along);
                let sideways = [-1.0, 1.0].map(|side| curvature(body, stand, across * side, width));
                let along = curvature(body, stand, stand.along, 0.5 * length * stand.scale);
                [along * length * stand.scale, 0.5 * (sideways[0] + sideways[1]) * width * stand.scale]
            })
            .collect();
        let mut ranked: Vec<usize> = (0..stands.len()).collect();
        ranked.sort_by(|&a, &b| bends[a][0].total_cmp(&bends[b][0]).then(a.cmp(&b)));
        let variants = self.variants;
        let mut sums = vec![([0.0; 2], 0.0); variants];
        for (rank, &index) in ranked.iter().enumerate() {
            let own = (rank as f64 + 0.5) / stands.len() as f64 * variants as f64;
            let variant = (own + stream.uniform(-MIXED, MIXED)).clamp(0.0, variants as f64 - 1.0) as usize;
            stands[index].variant = variant;
            let ([along, across], count) = &mut sums[variant];
            (*along, *across, *count) = (*along + bends[index][0], *across + bends[index][1], *count + 1.0);
        }
        let of = |([along, across], count): ([f64; 2], f64)| {
            let most = |angle: f64| (angle / f64::max(count, 1.0)).clamp(-FRAC_PI_2, FRAC_PI_2);
            self.hugging(feather, most(along), most(across))
        };
        sums.into_iter().map(of).collect()
    }

    /// A feather over a body that bends by these angles along the feather and over half its width, rad.
    fn hugging(&self, feather: &Feather, along: f64, across: f64) -> Feather {
        let mut bent = *feather;
        let mix = |own: f64, body: f64| own + self.hug * (body - own);
        let rise = SETTLED * self.erection_deg.to_radians();
        bent.shaft.arch = mix(feather.shaft.arch, -along);
        bent.shaft.arch_quadratic = mix(feather.shaft.arch_quadratic, -rise);
        bent.barbs.camber = mix(feather.barbs.camber, 0.5 * across);
        bent.downy.spread = mix(feather.downy.spread, PRESSED * feather.downy.spread);
        bent
    }
}

/// Angle over its y axis at which a feather leaves the skin, rad.
fn heading(feather: &Feather) -> f64 {
    let tip = Shaft::new(&feather.shaft).at(window(feather).along_mm).tip;
    libm::atan2(tip.z, tip.y)
}

/// Curvature of the body from a follicle in a direction over a length, 1/mm; positive where it is convex.
fn curvature(body: &Body, stand: &Stand, direction: DVec3, length: f64) -> f64 {
    let Spot { point, normal, triangle, .. } = stand.spot;
    let there = body.foot(point + direction * length, body.triangles[triangle as usize][0]).normal;
    libm::tan(libm::atan2(there.dot(direction), there.dot(normal).max(1e-3)).clamp(-1.4, 1.4)) / length
}

impl Laid {
    /// Area of all vanes over that of the body: how many feathers lie over each other.
    #[must_use]
    pub fn layers(&self) -> f64 {
        let vanes: Vec<f64> = self.variants.iter().map(|variant| variant.feather.vane_area()).collect();
        let all: f64 = self.stands.iter().map(|s| s.scale * s.scale * vanes[s.variant]).sum();
        all / self.area_mm2
    }

    /// Rijke's overlap: the feathers' mean length times the root of their density.
    #[must_use]
    pub fn overlap(&self) -> f64 {
        let count = self.stands.len() as f64;
        let lengths: f64 =
            self.stands.iter().map(|s| s.scale * self.variants[s.variant].feather.shaft.length_mm).sum();
        lengths / count * (count / self.area_mm2).sqrt()
    }

    /// Share of points on the feathers that are under the surface of a feather beneath or in the body, before the feathers
    /// were lifted, and now: straight lines away from the body are held against the vanes as they were grown.
    #[must_use]
    pub fn buried(&self) -> [f64; 2] {
        [&self.before, &self.stands]
            .map(|stands| shape::buried(&self.body, stands, &self.order, &self.shapes))
    }
}

#[cfg(test)]
mod tests;
