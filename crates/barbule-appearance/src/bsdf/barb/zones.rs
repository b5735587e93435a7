//! Zones of a vane: regions of it, or the colours of a picture on it, that wear a dress of their own.
//!
//! At every level of detail a place is told by the arc length s on the shaft where its barb leaves and the arc length a on that barb.
//! In the flat vane of the zones barbs are straight, whatever befell those of the feather: they begin x₀(s) from the shaft's axis
//! at the angle φ(s) to it, so that the place lies x = x₀ + a sin φ beside the shaft and y = s + a cos φ along it.

use super::lookup::tents;
use crate::bsdf::Texture;
use crate::{Error, Result};

/// Places of the shaft for which a flat vane says how barbs leave; between them they change evenly.
pub const STATIONS: usize = 33;

/// A barb of a flat vane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StraightBarb {
    /// Distance from the shaft's axis where it begins, mm.
    pub start_mm: f64,
    /// Sine and cosine of its angle to the shaft.
    pub direction: [f64; 2],
}

/// A feather's vanes as zones see them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatVane {
    /// Arc length on the shaft where the vanes begin, mm.
    pub base_mm: f64,
    /// Their length along the shaft, mm.
    pub length_mm: f64,
    /// Largest widths left and right of the shaft, mm.
    pub half_widths_mm: [f64; 2],
    /// From where to where barbs are told, mm along the shaft from the vanes' base; before and after they are as there.
    pub stations_mm: [f64; 2],
    /// Barbs left and right of it, at even steps between these.
    pub barbs: [[StraightBarb; STATIONS]; 2],
}

/// A part of a vane: what lies within all of its limits. A limit at the end of the vane holds all that lies beyond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// From where to where along the shaft: 0 at the vane's base, 1 at its tip.
    pub along: [f64; 2],
    /// From where to where across it: −1 at the left edge where the vane is widest, 0 on the shaft, 1 at the right edge.
    pub across: [f64; 2],
    /// The ring or disc within which it lies.
    pub ring: Option<Ring>,
    /// Standard deviation of its border from barbule to barbule, mm.
    pub edge_mm: f64,
}

/// An elliptic ring about a place of the flat vane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Its middle: to the right of the shaft, and along it from the vane's base, mm.
    pub centre_mm: [f64; 2],
    /// Half its inner and outer width across the shaft, mm; a disc begins at 0.
    pub radii_mm: [f64; 2],
    /// Its length along the shaft over its width.
    pub stretch: f64,
    /// How much wider it is on each mm towards the feather's tip, as a share: hearts and eggs.
    pub widening_per_mm: f64,
    /// A notch on its side towards the feather's base: depth and width, mm; none where the depth is 0.
    pub notch_mm: [f64; 2],
}

impl Ring {
    /// A disc without notch.
    #[must_use]
    pub fn disc(centre_mm: [f64; 2], radius_mm: f64) -> Self {
        let (radii_mm, notch_mm) = ([0.0, radius_mm], [0.0, 1.0]);
        Self { centre_mm, radii_mm, stretch: 1.0, widening_per_mm: 0.0, notch_mm }
    }
}

/// How zones lie.
#[derive(Debug, Clone, PartialEq)]
pub enum ZonePlan {
    /// Regions: zone 1, 2 …, and zone 0 elsewhere. Where several hold a place the last wins.
    Regions(Vec<Region>),
    /// A grey picture over the vane whose pixels of value i (of 255) are zone i: as wide as both vanes at their widest, left to right
    /// as seen from above, as high as they are long, the tip on top.
    Picture {
        /// The picture.
        picture: Texture,
        /// Standard deviation of its borders from barbule to barbule, mm.
        edge_mm: f64,
    },
}

/// The zones of a feather's vanes.
#[derive(Debug, Clone, PartialEq)]
pub struct Zones {
    vane: FlatVane,
    plan: ZonePlan,
    count: usize,
}

impl Zones {
    /// Zones of a feather of such vanes.
    ///
    /// # Errors
    /// Limits that are not in order or not numbers, no zone beside 0, a picture that is not grey.
    pub fn new(vane: FlatVane, plan: ZonePlan) -> Result<Self> {
        let count = match &plan {
            ZonePlan::Regions(regions) => {
                for (index, region) in regions.iter().enumerate() {
                    region.check().map_err(|error| error.at(format!("zone {}", index + 1)))?;
                }
                regions.len()
            }
            ZonePlan::Picture { picture, edge_mm } => {
                check_edge(*edge_mm)?;
                picture.highest_value()?
            }
        };
        if count == 0 {
            return Err(Error::input(
                "there is no zone beside the feather's own; give one or leave zones out",
            ));
        }
        Ok(Self { vane, plan, count })
    }

    /// How many there are beside zone 0.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The zone of a barbule or a piece of ramus of this name, on a barb left (−1) or right (1) of the shaft that leaves it at
    /// `station_mm`, and `arc_mm` along it.
    #[inline]
    #[must_use]
    pub fn at(&self, side: f64, station_mm: f64, arc_mm: f64, name: u64) -> usize {
        let place = self.vane.place(side, station_mm, arc_mm);
        let strays = tents(name ^ 0x4f1b_bcdc_bfa5_3e0b);
        let strayed = |edge_mm: f64| [0, 1].map(|k| place[k] + edge_mm * strays[k]);
        match &self.plan {
            ZonePlan::Regions(regions) => {
                let holds = |region: &Region| region.holds(&self.vane, strayed(region.edge_mm));
                regions.iter().rposition(holds).map_or(0, |index| index + 1)
            }
            ZonePlan::Picture { picture, edge_mm } => {
                let [along, across] = self.vane.shares(strayed(*edge_mm));
                // Pictures repeat; this one ends.
                picture.value_at([0.5 * (across + 1.0), along].map(|at| at.clamp(RIM, 1.0 - RIM)))
            }
        }
    }
}

/// As near to the rim of a picture as its texels are asked for, over its size.
const RIM: f64 = 1e-9;

impl FlatVane {
    /// A place of the flat vane: to the right of the shaft, and along it from the vane's base, mm.
    #[inline]
    fn place(&self, side: f64, station_mm: f64, arc_mm: f64) -> [f64; 2] {
        let barbs = &self.barbs[usize::from(side > 0.0)];
        let from_base = station_mm - self.base_mm;
        let [first, last] = self.stations_mm;
        let at = ((from_base - first) / (last - first)).clamp(0.0, 1.0) * (STATIONS - 1) as f64;
        let index = (at as usize).min(STATIONS - 2);
        let (before, after, rest) = (&barbs[index], &barbs[index + 1], at - index as f64);
        let mix = |a: f64, b: f64| a + (b - a) * rest;
        let [sin, cos] = [0, 1].map(|k| mix(before.direction[k], after.direction[k]));
        [side * (mix(before.start_mm, after.start_mm) + arc_mm * sin), from_base + arc_mm * cos]
    }

    /// Shares of the vane along and across it, as [`Region`] has them.
    #[inline]
    fn shares(&self, [right_mm, along_mm]: [f64; 2]) -> [f64; 2] {
        let half_width = self.half_widths_mm[usize::from(right_mm > 0.0)];
        [(along_mm / self.length_mm).clamp(0.0, 1.0), (right_mm / half_width).clamp(-1.0, 1.0)]
    }
}

impl Region {
    #[inline]
    fn holds(&self, vane: &FlatVane, place: [f64; 2]) -> bool {
        let [along, across] = vane.shares(place);
        let within = |[low, high]: [f64; 2], at: f64| low <= at && at <= high;
        within(self.along, along)
            && within(self.across, across)
            && self.ring.is_none_or(|ring| within(ring.radii_mm, ring.radius(place)))
    }

    fn check(&self) -> Result<()> {
        let Self { along, across, ring, edge_mm } = self;
        check_range("along", *along, [0.0, 1.0])?;
        check_range("across", *across, [-1.0, 1.0])?;
        check_edge(*edge_mm)?;
        let Some(Ring { centre_mm, radii_mm, stretch, widening_per_mm, notch_mm: [depth, width] }) = ring
        else {
            return Ok(());
        };
        if !(widening_per_mm.abs() <= 1.0 && (0.0..=MOST_MM).contains(depth) && *width > 0.0) {
            return Err(Error::input(format!(
                "widening_per_mm is {widening_per_mm} and notch_mm [{depth}, {width}]; give -1 to 1, a depth of 0 or more and a width over 0"
            )));
        }
        check_range("radii_mm", *radii_mm, [0.0, MOST_MM])?;
        if !centre_mm.iter().all(|at| at.abs() <= MOST_MM) {
            let [right, along] = centre_mm;
            return Err(Error::input(format!(
                "centre_mm is [{right}, {along}]; give mm right of the shaft and along it"
            )));
        }
        if !(LEAST_STRETCH..=1.0 / LEAST_STRETCH).contains(stretch) {
            return Err(Error::input(format!(
                "stretch is {stretch}, outside {LEAST_STRETCH} to {}",
                1.0 / LEAST_STRETCH
            )));
        }
        Ok(())
    }
}

/// Nothing of a feather is larger, mm.
const MOST_MM: f64 = 2000.0;
/// Rings are at most so much wider than long, and so much longer than wide.
const LEAST_STRETCH: f64 = 0.01;
/// A ring that narrows towards one side is at least so wide there, over its width in the middle.
const LEAST_WIDE: f64 = 0.2;

fn check_range(key: &str, [low, high]: [f64; 2], [least, most]: [f64; 2]) -> Result<()> {
    if least <= low && low < high && high <= most {
        return Ok(());
    }
    Err(Error::input(format!(
        "{key} is [{low}, {high}]; give two numbers of {least} to {most}, the smaller first"
    )))
}

fn check_edge(edge_mm: f64) -> Result<()> {
    if (0.0..=MOST_MM).contains(&edge_mm) {
        return Ok(());
    }
    Err(Error::input(format!("edge_mm is {edge_mm}, outside 0 to {MOST_MM}")))
}

impl Ring {
    /// Distance of a place from its middle, as rings count that are so wide there, mm: ρ = √((x/(1 + g y))² + (y/s)²) + n e^(−(x/w)²), the
    /// last towards the base alone, where it sets in over n.
    #[inline]
    #[must_use]
    pub fn radius(&self, place: [f64; 2]) -> f64 {
        let [right, along] = [0, 1].map(|k| place[k] - self.centre_mm[k]);
        let wide = right / (1.0 + self.widening_per_mm * along).max(LEAST_WIDE);
        let high = along / self.stretch;
        let radius = (wide * wide + high * high).sqrt();
        let [depth, width] = self.notch_mm;
        if depth <= 0.0 || along >= 0.0 {
            return radius;
        }
        let at = right / width;
        radius + depth * (-along / depth).min(1.0) * libm::exp(-at * at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 100 mm of vane from 10 mm of the shaft on, 10 mm wide on the left and 20 mm on the right; barbs at a right angle left, at 45° right.
    fn vane() -> FlatVane {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let left = StraightBarb { start_mm: 1.0, direction: [1.0, 0.0] };
        let right = StraightBarb { start_mm: 0.0, direction: [half, half] };
        let barbs = [[left; STATIONS], [right; STATIONS]];
        FlatVane {
            base_mm: 10.0,
            length_mm: 100.0,
            stations_mm: [0.0, 100.0],
            half_widths_mm: [10.0, 20.0],
            barbs,
        }
    }

    const ALL: Region = Region { along: [0.0, 1.0], across: [-1.0, 1.0], ring: None, edge_mm: 0.0 };

    fn zones(regions: &[Region]) -> Zones {
        Zones::new(vane(), ZonePlan::Regions(regions.to_vec())).unwrap()
    }

    #[test]
    fn places_lie_where_straight_barbs_lead() {
        let diagonal = 8.0 * 2.0_f64.sqrt();
        for (side, station, arc, expected) in [
            (-1.0, 35.0, 4.0, [-5.0, 25.0]),
            (1.0, 35.0, diagonal, [8.0, 33.0]),
            (1.0, 10.0, 0.0, [0.0, 0.0]),
        ] {
            let place = vane().place(side, station, arc);
            assert!((0..2).all(|k| (place[k] - expected[k]).abs() < 1e-12), "{place:?} {expected:?}");
        }
        // Halfway between two stations barbs stand halfway.
        let mut bent = vane();
        bent.barbs[0][1].direction = [0.8, 0.6];
        let [right, along] = bent.place(-1.0, 10.0 + 0.5 * 100.0 / 32.0, 10.0);
        assert!((right + 10.0).abs() < 1e-12 && (along - 1.5625 - 3.0).abs() < 1e-12, "{right} {along}");
    }

    #[test]
    fn bands_and_rings_hold_what_lies_in_them_and_the_last_wins() {
        let disc = Ring { stretch: 2.0, ..Ring::disc([-5.0, 40.0], 2.0) };
        let ring = Ring { radii_mm: [2.0, 3.0], ..disc };
        let zones = zones(&[
            Region { along: [0.2, 0.6], ..ALL },
            Region { across: [0.5, 1.0], ..ALL },
            Region { ring: Some(ring), ..ALL },
            Region { ring: Some(disc), ..ALL },
            Region { along: [0.9, 1.0], across: [-1.0, 0.0], ..ALL },
        ]);
        assert_eq!(zones.count(), 5);
        let diagonal = 2.0_f64.sqrt();
        for (side, station, arc, expected) in [
            (-1.0, 29.9, 4.0, 0),
            (-1.0, 30.1, 4.0, 1),
            (-1.0, 69.9, 4.0, 1),
            (-1.0, 70.1, 4.0, 0),
            // Right, 9.9 and 10.1 mm of 20, along the vane at 0.5.
            (1.0, 50.1, 9.9 * diagonal, 1),
            (1.0, 49.9, 10.1 * diagonal, 2),
            // Beyond the right edge is still the edge.
            (1.0, 30.0, 30.0 * diagonal, 2),
            // In the middle, and 3.9 and 4.1 mm from it along the shaft, 1.9 and 2.1 across.
            (-1.0, 50.0, 4.0, 4),
            (-1.0, 53.9, 4.0, 4),
            (-1.0, 54.1, 4.0, 3),
            (-1.0, 44.1, 4.0, 3),
            (-1.0, 43.9, 4.0, 1),
            (-1.0, 50.0, 5.9, 4),
            (-1.0, 50.0, 6.1, 3),
            (-1.0, 50.0, 7.1, 1),
            // Past the tip.
            (-1.0, 111.0, 4.0, 5),
            (1.0, 111.0, 4.0, 0),
        ] {
            for name in [1, 2, 3] {
                assert_eq!(zones.at(side, station, arc, name), expected, "{side} {station} {arc}");
            }
        }
    }

    /// Of the places at d from a straight border as many lie beyond as draws exceed d, whichever way it runs.
    #[test]
    fn borders_stray_from_name_to_name() {
        let along = zones(&[Region { along: [0.0, 0.5], edge_mm: 0.4, ..ALL }]);
        let across = zones(&[Region { across: [-0.5, 1.0], edge_mm: 0.4, ..ALL }]);
        let count = 200_000;
        for (shift, beyond) in [(0.0, 0.5), (0.4, 0.175_085), (-0.4, 0.824_915), (1.0, 0.0)] {
            let share = |zones: &Zones, station: f64, arc: f64| {
                let inside =
                    |name: &u64| zones.at(-1.0, station, arc, crate::math::rng::split_mix(*name)) == 1;
                (0..count).filter(inside).count() as f64 / count as f64
            };
            for found in [share(&along, 60.0 + shift, 3.0), share(&across, 30.0, 4.0 + shift)] {
                // Sums of two uniform numbers of deviation 1 exceed d < √6 with (1 − d/√6)²/2.
                assert!((found - beyond).abs() < 0.004, "{shift}: {found} {beyond}");
            }
        }
    }

    #[test]
    fn pictures_lie_upright_on_the_vane() {
        let texels = [1_u8, 2, 3, 0, 0, 4].map(|value| [f32::from(value) / 255.0; 3]).to_vec();
        let picture = Texture::new([3, 2], texels).unwrap();
        let zones = Zones::new(vane(), ZonePlan::Picture { picture: picture.clone(), edge_mm: 0.0 }).unwrap();
        assert_eq!(zones.count(), 4);
        let diagonal = 2.0_f64.sqrt();
        for (side, station, arc, expected) in [
            (-1.0, 100.0, 8.0, 1),
            (-1.0, 100.0, 20.0, 1),
            (-1.0, 61.0, 1.0, 2),
            (-1.0, 59.0, 1.0, 0),
            (1.0, 100.0, 15.0 * diagonal, 3),
            (1.0, 20.0, 15.0 * diagonal, 4),
            (1.0, 20.0, 30.0 * diagonal, 4),
            (-1.0, 0.0, 9.0, 0),
        ] {
            assert_eq!(zones.at(side, station, arc, 1), expected, "{side} {station} {arc}");
        }
        let blank = Texture::new([1, 1], vec![[0.0; 3]]).unwrap();
        let error = |picture| {
            Zones::new(vane(), ZonePlan::Picture { picture, edge_mm: 0.0 }).unwrap_err().to_string()
        };
        assert!(error(blank).contains("no zone beside the feather's own"));
        assert!(error(Texture::new([1, 1], vec![[0.0, 0.1, 0.0]]).unwrap()).contains("not grey"));
    }

    #[test]
    fn limits_out_of_order_are_refused() {
        let ring = Ring::disc([0.0; 2], 2.0);
        let of_ring = |ring| Region { ring: Some(ring), ..ALL };
        for (region, expected) in [
            (Region { along: [0.5, 0.5], ..ALL }, "zone 2: along is [0.5, 0.5]"),
            (Region { across: [-1.5, 0.0], ..ALL }, "across is [-1.5, 0]"),
            (Region { edge_mm: f64::NAN, ..ALL }, "edge_mm is NaN"),
            (of_ring(Ring { radii_mm: [-1.0, 2.0], ..ring }), "radii_mm is [-1, 2]"),
            (of_ring(Ring { centre_mm: [f64::NAN, 0.0], ..ring }), "centre_mm is [NaN, 0]"),
            (of_ring(Ring { stretch: 0.0, ..ring }), "stretch is 0, outside 0.01 to 100"),
        ] {
            let error = Zones::new(vane(), ZonePlan::Regions(vec![ALL, region])).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        assert!(Zones::new(vane(), ZonePlan::Regions(Vec::new())).is_err());
    }
}
