//! A barb with barbules that are not there: one ribbon as wide as both rows reach, on which every hit is looked up as the ramus,
//! a barbule or a gap.
//!
//! What is met is shaded as if it were there, in its own frame: rami and plain barbules as fibres or keratin, iridescent ones as
//! plates with their own instances (Baron et al. 2021; the geometric term is `docs/theory/substructure.md`). The form of the
//! rows is that of ribbons that are grown one by one, so both look the same.

mod lookup;
mod markings;
mod pattern;
mod row;
#[cfg(test)]
mod tests;
mod zones;

use glam::DVec3;

pub use markings::{Mark, Markings, ZoneDress};
pub use pattern::Pattern;
pub use row::{Row, RowDisorder, axes, ramus_taper};
pub use zones::{FlatVane, Region, Ring, STATIONS, StraightBarb, ZonePlan, Zones};

use self::lookup::{Barbule, Blind, Lookup, Met, Place};
use super::Bsdf;
use super::feather::BarbuleSurface;
use super::frame::Frame;
use super::hair::{FibreSection, Hair};
use super::hit::{Hit, OnRibbon};
use super::keratin::Keratin;
use super::lambertian::Lambertian;
use super::thin_film::ThinFilm;
use crate::Result;
use crate::math::rng::hash;
use crate::spectrum::dense::Lambdas;

/// What a substructure is made of.
#[derive(Debug, Clone)]
pub enum Substance {
    /// An iridescent plate.
    Plate(BarbuleSurface),
    /// Keratin: a tube that no light passes, or a plate of it.
    Keratin(Keratin),
    /// A plate with a film of layers on it.
    Film(ThinFilm),
    /// Paint: a tube or a plate.
    Paint(Lambertian),
    /// A fibre that light passes.
    Fibre(Hair),
}

impl Substance {
    /// What shape it has, as part of a sentence.
    fn shape(&self) -> &'static str {
        match self {
            Self::Plate(_) | Self::Film(_) | Self::Paint(_) => "plates",
            Self::Keratin(_) => "keratin",
            Self::Fibre(_) => "fibres",
        }
    }

    /// Height over width of a fibre's section; nothing of what is none.
    fn roundness(&self) -> Option<f64> {
        match self {
            Self::Plate(_) | Self::Keratin(_) | Self::Film(_) | Self::Paint(_) => None,
            Self::Fibre(hair) => Some(hair.height_over_width()),
        }
    }
}

/// How barbs are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BarbModel {
    /// As one fibre each, as wide as the envelope.
    Fibre,
    /// As rami with rows of barbules.
    Substructure,
}

/// The ramus within a barb's envelope.
#[derive(Debug, Clone)]
pub struct Ramus {
    /// What it is made of.
    pub substance: Substance,
    /// Half its width at the base, mm.
    pub half_width: f64,
    /// Height over width of one that is no fibre.
    pub height: f64,
}

/// A barb with its barbules: the surface of a ribbon whose cell is the whole barb.
#[derive(Debug, Clone)]
pub struct BarbSurface {
    model: BarbModel,
    ramus: Ramus,
    /// Towards the feather's tip, and the other.
    rows: [(Lookup, Substance); 2],
    /// On which side of the ribbon the feather's tip lies: ±1 of x.
    tip: f64,
    dress: Dress,
}

/// What differs from place to place of a vane's barbs.
#[derive(Debug, Clone)]
pub struct Dress {
    /// Where.
    pub markings: Markings,
    /// What the markings' zones wear, from zone 1.
    pub zones: Vec<ZoneDress>,
    /// What plates are where there is no pigment.
    pub pale: Keratin,
}

/// What a ray met within the envelope.
#[allow(clippy::large_enum_variant)] // lives on the stack for one hit
enum Part {
    /// The offset from its middle over half its silhouette.
    Ramus(f64),
    /// Of which row.
    Barbule(usize, Met),
}

/// The slats that shade a barbule, and the plane across it.
pub(super) struct Shade {
    blind: Blind,
    ahead: DVec3,
    up: DVec3,
}

impl Shade {
    /// Whether neighbours stand between the hit and a direction.
    #[inline]
    pub(super) fn hides(&self, wi: DVec3) -> bool {
        self.blind.is_shaded([self.ahead.dot(wi), self.up.dot(wi)])
    }
}

impl BarbSurface {
    /// `rows`: the barbules towards the feather's tip and the others; `tip`: ±1, on which side of the ribbon the feather's tip
    /// lies.
    ///
    /// # Errors
    /// Zones that have no dress, or one of other kinds of substances ([`Markings::check`]).
    pub fn new(
        model: BarbModel,
        ramus: Ramus,
        rows: [(Row, Substance); 2],
        tip: f64,
        dress: Dress,
    ) -> Result<Self> {
        dress.markings.check(&dress.zones, [&ramus.substance, &rows[0].1, &rows[1].1])?;
        let rows = rows.map(|(row, substance)| {
            let round = substance.roundness();
            (Lookup::new(row, round), substance)
        });
        Ok(Self { model, ramus, rows, tip, dress })
    }

    /// The barb's direction, the direction across it and the vane's normal.
    #[inline]
    fn axes(&self, hit: &Hit) -> [DVec3; 3] {
        let Frame { x, y, z } = hit.frame;
        [y, x, z]
    }

    /// What a ray to a viewer meets; `None` is a gap.
    #[inline(never)]
    fn meet(&self, hit: &Hit, wo: DVec3) -> Option<Part> {
        if self.model == BarbModel::Fibre {
            return Some(Part::Ramus(hit.uv[1] * hit.frame.z.dot(wo).signum()));
        }
        let [tangent, across, normal] = self.axes(hit);
        let on = &hit.ribbon;
        let x = hit.uv[1] * on.half_width;
        let half_width = self.ramus.half_width * ramus_taper(hit.uv[0] / on.cell_length);
        let (dx, dz) = (wo.dot(across), wo.dot(normal));
        let length = (dx * dx + dz * dz).sqrt().max(f64::MIN_POSITIVE);
        // An ellipse whose middle lies a little below the plane of the barbules.
        let height = self.ramus.substance.roundness().unwrap_or(self.ramus.height);
        let silhouette = half_width * (dz * dz + height * height * dx * dx).sqrt() / length;
        let offset = (x * dz + RAMUS_DEPTH * half_width * height * dx) / (length * silhouette);
        if offset.abs() <= 1.0 && hit.uv[0] <= on.cell_length {
            return Some(Part::Ramus(offset));
        }
        let side = x.signum();
        let which = usize::from(side != self.tip);
        let sideways = across * side;
        let place = Place {
            side: x.abs() - RAMUS_ROOT * half_width,
            along: hit.uv[0],
            barb: on.cell_length,
            lean: [side * dx, wo.dot(tangent)]
                .map(|v| (v / dz.abs().max(LEAST_RISE)).clamp(-MOST_LEAN, MOST_LEAN) * dz.signum()),
            name: hash(hit.id, &[2, which as u64]),
        };
        let (lookup, _) = &self.rows[which];
        let met = lookup.meet(place, |angle, lift| {
            let [_, ahead, up] = axes([tangent, sideways, normal], angle, lift);
            [ahead.dot(wo), up.dot(wo)]
        })?;
        Some(Part::Barbule(which, met))
    }

    /// At a hit, seen from `wo`. Gaps are never asked: they have no opacity.
    #[inline(never)] // much code, for few of a picture's surfaces
    pub(super) fn bind<'a>(&'a self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'a> {
        match self.meet(hit, wo) {
            Some(Part::Barbule(which, met)) => self.bind_barbule(which, &met, hit, wo, wavelengths),
            Some(Part::Ramus(offset)) => self.bind_ramus(offset, hit, wo, wavelengths),
            None => self.bind_ramus(0.0, hit, wo, wavelengths),
        }
    }

    #[inline(never)]
    fn bind_ramus<'a>(&'a self, offset: f64, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'a> {
        let [tangent, _, normal] = self.axes(hit);
        let met = || on_fibre(hit, tangent, offset, wo);
        let mark = self.mark(hit, hit.uv[0], hit.id);
        let zone = self.zone(mark).and_then(|zone| zone.ramus.as_ref());
        match zone.unwrap_or(&self.ramus.substance) {
            Substance::Plate(plate) => plate.bind(&met(), wo, wavelengths),
            Substance::Keratin(keratin) => keratin.bind(&met(), wo, wavelengths),
            Substance::Film(film) => film.bind(&met(), wo, wavelengths),
            Substance::Paint(paint) => paint.bind(&met(), wo, wavelengths),
            Substance::Fibre(hair) => {
                let pigment = self.pigment(mark);
                let section = FibreSection { axis: tangent, up: normal, offset: -offset, pigment };
                hair.bind_section(&section, wo, wavelengths)
            }
        }
    }

    /// What marks a part of this name, so far along the barb.
    #[inline]
    fn mark(&self, hit: &Hit, arc: f64, name: u64) -> Mark {
        // The feather's tip lies to the left of a right barb.
        self.dress.markings.at(-self.tip, hit.ribbon.station, arc, name)
    }

    /// What a zone beside the feather's own wears there.
    #[inline]
    fn zone(&self, mark: Mark) -> Option<&ZoneDress> {
        mark.zone().checked_sub(1).map(|zone| &self.dress.zones[zone])
    }

    /// Pigment over that of dark places.
    #[inline]
    fn pigment(&self, mark: Mark) -> f64 {
        match self.dress.markings.pattern {
            Some(pattern) if mark == Mark::Pale => pattern.pale,
            Some(_) | None => 1.0,
        }
    }

    #[inline(never)]
    fn bind_barbule<'a>(
        &'a self,
        which: usize,
        met: &Met,
        hit: &Hit,
        wo: DVec3,
        wavelengths: Lambdas,
    ) -> Bsdf<'a> {
        let (lookup, substance) = &self.rows[which];
        let Met { barbule: met, blind } = met;
        let [tangent, across, normal] = self.axes(hit);
        let side = if which == 0 { self.tip } else { -self.tip };
        let [along, ahead, up] = axes([tangent, across * side, normal], met.angle, met.lift);
        let plate = up * libm::cos(met.tilt) + ahead * libm::sin(met.tilt);
        let frame = Frame { x: along.cross(plate), y: along, z: plate };
        let (ribbon, instance) = lookup.grain(hit, met);
        let frame = frame.pitched(lookup.row.swelling * (1.0 - 2.0 * ribbon.place));
        let place = Hit {
            normal: plate,
            vane_normal: normal,
            frame,
            // The frame's x is ahead on one side of the barb and back on the other.
            uv: [met.t * met.length, -side * met.across],
            ribbon,
            id: met.id,
            instance,
            ..*hit
        };
        let mark = self.mark(hit, hit.uv[0], met.id);
        let zone = self.zone(mark).and_then(|zone| zone.barbules[which].as_ref());
        let bsdf = match zone.unwrap_or(substance) {
            Substance::Plate(_) | Substance::Film(_) | Substance::Paint(_) if mark == Mark::Pale => {
                self.dress.pale.bind(&place, wo, wavelengths)
            }
            Substance::Plate(surface) => surface.bind(&place, wo, wavelengths),
            Substance::Keratin(keratin) => keratin.bind(&place, wo, wavelengths),
            Substance::Film(film) => film.bind(&place, wo, wavelengths),
            Substance::Paint(paint) => paint.bind(&place, wo, wavelengths),
            Substance::Fibre(hair) => {
                let pigment = self.pigment(mark);
                let section = FibreSection { axis: along, up: plate, offset: side * met.across, pigment };
                hair.bind_section(&section, wo, wavelengths)
            }
        };
        bsdf.shaded(Shade { blind: *blind, ahead, up })
    }

    /// See [`super::Surface::opacity`]: 0 in gaps. The ray may come from either end.
    #[inline(never)]
    pub(super) fn opacity(&self, hit: &Hit, wo: DVec3) -> f64 {
        if self.meet(hit, wo).is_some() { 1.0 } else { 0.0 }
    }
}

/// How deep below the plane of the barbules a ramus has its middle, over half its height.
pub const RAMUS_DEPTH: f64 = 0.45;

/// Viewers' directions that lean more over the vane than this, or rise less, do not look further below barbules.
const MOST_LEAN: f64 = 3.0;
const LEAST_RISE: f64 = 0.05;

/// Where barbules are rooted in a ramus, over half its width.
pub const RAMUS_ROOT: f64 = 0.8;

/// The hit on a round tube about this axis that a viewer's ray meets so far from the middle.
#[inline]
fn on_fibre(hit: &Hit, axis: DVec3, offset: f64, wo: DVec3) -> Hit {
    let towards = (wo - axis * axis.dot(wo)).normalize_or(hit.frame.z);
    let normal = towards * (1.0 - offset * offset).max(0.0).sqrt() - axis.cross(towards) * offset;
    Hit { normal, frame: Frame { x: axis.cross(normal), y: axis, z: normal }, ..*hit }
}

impl Lookup {
    /// The cell that was met, its place in it and its instance. Where the footprint holds several cells, they are one of
    /// less contrast.
    #[inline]
    fn grain(&self, hit: &Hit, met: &Barbule) -> (OnRibbon, u64) {
        let row = &self.row;
        let has_cells = row.cell > 0.0;
        // Cells begin anywhere in a barbule.
        let phase = (met.id >> 40) as f64 / (1u64 << 24) as f64;
        let place = if has_cells { met.t * met.length / row.cell + phase } else { 0.5 };
        let cell = place.floor();
        let diameter = 2.0 * hit.footprint;
        let doublings = |size: f64| libm::log2((diameter / size).max(1.0)) as u32;
        let across = doublings(row.spacing * libm::sin(met.angle));
        let along = doublings(if has_cells { row.cell } else { met.length });
        let instance = if across + along == 0 {
            hash(met.id, &[cell as u64])
        } else {
            let row = hash(hit.id, &[u64::from(across), u64::from(along)]);
            hash(row, &[(met.index >> across) as u64, cell as u64 >> along])
        };
        let ribbon = OnRibbon {
            half_width: met.half_width,
            cell: cell as u64,
            place: place - cell,
            cell_length: row.cell,
            station: hit.ribbon.station,
            contrast: libm::exp2(-0.5 * f64::from(across + along)),
        };
        (ribbon, instance)
    }
}
