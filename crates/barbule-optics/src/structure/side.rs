//! The two sides of a barbule. The lower one is lit from below, which is the barbule turned upside down, by 180° about its
//! long axis, and lit from above: x → −x, z → −z.

use super::curve::mean;
use super::section::{Inclusion, Loop, Medium, Parts, Polyline, Section};
use crate::error::shortened;
use crate::{Error, Result};

/// Ends of curves that differ by less count as the same.
const ALIKE_UM: f64 = 1e-9;

/// A side of a barbule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// The upper one, which sections have on top.
    #[default]
    Above,
    /// The lower one.
    Below,
}

impl Side {
    /// What the names of lower sides end in, as in `mallard:lime (below)`.
    pub const BELOW: &str = " (below)";
}

impl Section {
    /// The section turned upside down. Heights are such that the new top has the mean height of the old one; so turned
    /// twice it is itself, but for rounding.
    ///
    /// # Errors
    /// There is no lower side that light comes to through air: the medium under the last boundary is none of index 1, or a
    /// photonic crystal hangs in a host that goes on below.
    pub fn underside(&self) -> Result<Self> {
        let refuse = |why: String| {
            Err(Error::input(format!("{}: its lower side cannot be lit, since {why}", shortened(&self.name))))
        };
        if let Some(crystal) = &self.crystal {
            let host = crystal.lattice.host.label();
            return refuse(format!("under its photonic crystal the {host} goes on without end"));
        }
        let parts = Parts {
            name: self.name.clone(),
            width_um: Some(self.width_um),
            boundaries: self.boundaries.clone(),
            media: self.media.clone(),
            inclusions: self.inclusions.clone(),
            crystal: None,
            source: self.source.clone(),
        };
        let mut turned = Self::new(parts.turned(), self.library.clone())?;
        turned.materials.clone_from(&self.materials);
        if turned.check_lit_through_air().is_err() {
            let below = self.media.last().and_then(|medium| medium.substances().next());
            let below = below.map_or_else(String::new, super::Substance::label);
            return refuse(format!("{below} goes on under it; let the last medium be the built-in air"));
        }
        Ok(turned)
    }
}

impl Parts {
    /// The parts turned by 180° about an axis along y at half the height between the first and the last boundary. A
    /// crystal is left as it is.
    #[must_use]
    pub(super) fn turned(mut self) -> Self {
        if let [top, .., bottom] = &mut self.boundaries[..] {
            bottom.span(top);
        }
        let height = |boundary: Option<&Polyline>| boundary.map_or(0.0, |b| mean(&b.z_um));
        let sum_um = match &self.boundaries[..] {
            [] => 0.0,
            [.., last] => height(self.boundaries.first()) + height(Some(last)),
        };
        let inclusion = |inclusion: Inclusion| Inclusion {
            outline: inclusion.outline.turned(sum_um),
            medium: inclusion.medium.mirrored(),
            holes: inclusion.holes.into_iter().map(|hole| hole.turned(sum_um)).collect(),
        };
        Self {
            boundaries: self.boundaries.iter().rev().map(|b| b.turned(sum_um)).collect(),
            media: self.media.iter().rev().map(Medium::mirrored).collect(),
            inclusions: self.inclusions.into_iter().map(inclusion).collect(),
            ..self
        }
    }
}

impl Polyline {
    /// Begins and ends where another curve does: beyond the ends the end segments' lines go on.
    fn span(&mut self, other: &Self) {
        let ends = |curve: &Self| [curve.x_um[0], curve.x_um[curve.x_um.len() - 1]];
        let ([left, right], mine) = (ends(other), ends(self));
        if (mine[0] - left).abs() <= ALIKE_UM && (mine[1] - right).abs() <= ALIKE_UM {
            return;
        }
        let within = self.x_um.iter().copied().filter(|x| *x > left && *x < right);
        let mut x_um: Vec<f64> = [left].into_iter().chain(within).chain([right]).collect();
        if x_um.len() < 3 {
            x_um.insert(1, 0.5 * (left + right));
        }
        *self = Self { z_um: x_um.iter().map(|x| self.height(*x)).collect(), x_um };
    }

    /// The open curve turned by 180° about y at x = 0 and half of `sum_um`.
    #[must_use]
    pub(super) fn turned(&self, sum_um: f64) -> Self {
        Self {
            x_um: self.x_um.iter().rev().map(|x| -x).collect(),
            z_um: self.z_um.iter().rev().map(|z| sum_um - z).collect(),
        }
    }
}

impl Loop {
    fn turned(self, sum_um: f64) -> Self {
        match self {
            Self::Polygon(corners) => Self::Polygon(corners.turned(sum_um)),
            Self::Circle { x_um, z_um, radius_um } => {
                Self::Circle { x_um: -x_um, z_um: sum_um - z_um, radius_um }
            }
        }
    }
}

impl Medium {
    /// The medium with x → −x.
    #[must_use]
    pub(super) fn mirrored(&self) -> Self {
        let Self::Mixture { first, second, x_um, fraction } = self else { return self.clone() };
        Self::Mixture {
            first: first.clone(),
            second: second.clone(),
            x_um: x_um.iter().rev().map(|x| -x).collect(),
            fraction: fraction.iter().rev().copied().collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;

    #[test]
    fn a_bottom_that_is_shorter_or_longer_than_the_top_becomes_as_wide() {
        let line = |x_um: [f64; 3], z: f64| Polyline { x_um: x_um.to_vec(), z_um: vec![z, z, z + 0.5] };
        for bottom in [[-3.0, 0.0, 2.0], [-7.0, -6.0, 6.0]] {
            let parts = Parts {
                width_um: Some(10.0),
                boundaries: vec![line([-5.0, 0.0, 5.0], 0.0), line(bottom, -2.0)],
                media: ["air", "keratin", "air"].map(Medium::named).to_vec(),
                ..Parts::default()
            };
            let section = Section::new(parts, Library::builtin()).unwrap();
            let turned = section.underside().unwrap();
            let x_um = &turned.top().x_um;
            assert_eq!((x_um[0], x_um[x_um.len() - 1]), (-5.0, 5.0));
            // What was under a point is over the place to which it turns.
            let sum = turned.top().height(0.0) + section.boundaries[1].height(0.0);
            for x in [-4.5, 0.0, 1.0, 4.0] {
                let [before, after] = [section.boundaries[1].height(x), turned.top().height(-x)];
                assert!((sum - before - after).abs() < 1e-12, "{x}: {before} {after}");
            }
        }
    }
}
