//! Which of several feathers grows from a follicle.

use glam::DVec3;

use super::body::{Body, Spot};
use super::field::Guide;
use crate::bsdf::NumberMap;
use crate::math::rng::{hash, unit_of};
use crate::{Error, Result};

/// Name of random draws.
const KIND: u64 = 0x6b_696e;

/// What says which of a coat's feathers grows where.
#[derive(Debug, Clone, Copy)]
pub enum Kinds<'a> {
    /// The nearest guide by the straight distance, as guides' directions are spread. Over a band of this width along the border
    /// between two kinds, mm, follicles bear either, the more of one the nearer its guide.
    Guides {
        /// 0: a sharp border.
        mix_mm: f64,
    },
    /// A map at the body's texture coordinates; an ellipsoid's are those of [`Body::uv`].
    Map(&'a NumberMap),
}

impl Kinds<'_> {
    /// The kinds of follicles, of `count` that there are.
    ///
    /// # Errors
    /// A kind that there is not; a map on a body without texture coordinates.
    pub(super) fn of(
        &self,
        body: &Body,
        spots: &[Spot],
        guides: &[Guide],
        count: usize,
        seed: u64,
    ) -> Result<Vec<usize>> {
        match self {
            Self::Guides { mix_mm } => {
                if let Some((index, guide)) = guides.iter().enumerate().find(|(_, guide)| guide.kind >= count)
                {
                    return Err(Error::input(format!(
                        "coat.guides[{index}].kind is {}, but the coat has {count} kinds of feathers, from 0",
                        guide.kind
                    )));
                }
                let draw = |index: u64| unit_of(hash(seed, &[KIND, index]));
                Ok((0..)
                    .zip(spots)
                    .map(|(i, spot)| nearest(spot.point, guides, count, *mix_mm, draw(i)))
                    .collect())
            }
            Self::Map(map) => spots.iter().map(|spot| mapped(map, body, spot, count)).collect(),
        }
    }
}

fn mapped(map: &NumberMap, body: &Body, spot: &Spot, count: usize) -> Result<usize> {
    let uv = body.uv(spot).ok_or_else(|| {
        Error::input("the coat's map needs texture coordinates, but the body's mesh has none; give guides in its place")
    })?;
    match map.at(uv) {
        kind if kind < count => Ok(kind),
        kind => Err(Error::input(format!(
            "the coat's map has a pixel of value {kind} (of 255), but the coat has {count} kinds of feathers, from 0"
        ))),
    }
}

/// The kind of the nearest guide; of those that are less than `mix_mm` farther than it `draw`, uniform, chooses, with weights that
/// fall to nothing there. Across a straight border that is a band `mix_mm` wide, since distances differ by twice that to the border.
fn nearest(point: DVec3, guides: &[Guide], count: usize, mix_mm: f64, draw: f64) -> usize {
    let mut distances = vec![f64::INFINITY; count];
    for guide in guides {
        let distance = (point - DVec3::from(guide.position_mm)).length();
        distances[guide.kind] = distances[guide.kind].min(distance);
    }
    let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
    if least == f64::INFINITY {
        return 0;
    }
    let weights = || distances.iter().map(|distance| (least + mix_mm - distance).max(0.0));
    let mut left = draw * weights().sum::<f64>();
    let chosen = weights().position(|weight| {
        left -= weight;
        left < 0.0
    });
    // Without a band no weight is over 0.
    chosen.or_else(|| distances.iter().position(|distance| *distance == least)).unwrap_or(0)
}
