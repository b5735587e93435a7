//! Surfaces clad in barbules that no feather grew: their texture coordinates say which barbule, which cell of it and which place
//! of that a hit lies in.

use glam::DVec3;

use super::Bsdf;
use super::feather::BarbuleSurface;
use super::hit::{Hit, OnRibbon};
use crate::math::rng::{hash, split_mix, unit_of};
use crate::spectrum::dense::Lambdas;
use crate::{Error, Result};

/// Barbules side by side on a mesh, or one along a fibre.
#[derive(Debug, Clone)]
pub struct Clad {
    barbule: BarbuleSurface,
    layout: Layout,
}

/// How barbules lie on a surface: u runs along them, v across.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// Length on the surface of a unit of u, and of one of v, mm.
    pub uv_mm: [f64; 2],
    /// Width of a barbule, mm; 0: there is one, from v = −1 to 1.
    pub width_mm: f64,
    /// Length of a barbule, mm; 0: it does not end.
    pub length_mm: f64,
    /// Length of a cell along the barbule, mm; 0: a barbule is one cell.
    pub cell_mm: f64,
    /// Cells are low arches: slope at their ends, rad. Shades only.
    pub swelling: f64,
}

impl Clad {
    /// Barbules laid like this.
    ///
    /// # Errors
    /// A length or slope that is out of range.
    pub fn new(barbule: BarbuleSurface, layout: Layout) -> Result<Self> {
        let Layout { uv_mm, width_mm, length_mm, cell_mm, swelling } = layout;
        if !uv_mm.iter().all(|length| (1e-6..=1e6).contains(length)) {
            return Err(Error::input(format!(
                "units of u and v are {} and {} mm long; give 1e-6 to 1e6 mm",
                uv_mm[0], uv_mm[1]
            )));
        }
        for (what, length) in [("width", width_mm), ("length", length_mm), ("cell", cell_mm)] {
            if length != 0.0 && !(1e-6..=1e6).contains(&length) {
                return Err(Error::input(format!(
                    "barbules have a {what} of {length} mm; give 1e-6 to 1e6 mm, or 0 for none"
                )));
            }
        }
        if !(0.0..std::f64::consts::FRAC_PI_2).contains(&swelling) {
            return Err(Error::input(format!(
                "cells swell by {} degrees; give 0 to less than 90",
                swelling.to_degrees()
            )));
        }
        Ok(Self { barbule, layout })
    }

    /// What a barbule is made of.
    #[must_use]
    pub fn barbule(&self) -> &BarbuleSurface {
        &self.barbule
    }

    /// At a hit, seen from `wo`.
    #[inline(never)] // a copy of a barbule's own would make all surfaces' binding larger
    pub(super) fn bind<'a>(&'a self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'a> {
        self.barbule.bind(&self.layout.on_barbule(hit), wo, wavelengths)
    }
}

impl Layout {
    /// The hit as one on a ribbon that lies there, whose texture coordinates are those of [`Hit::uv`] on a ribbon.
    ///
    /// Its frame has y where u grows and v does not, and the surface's shading normal. Where texture coordinates have no directions,
    /// as on fibres, it is the hit's own. A surface that is one barbule keeps its identity, and cells are counted from u = 0; of
    /// several each has its own, and begins anywhere in a cell.
    #[must_use]
    pub fn on_barbule(&self, hit: &Hit) -> Hit {
        let (frame, sign) = hit.texture_frame();
        let [along, across] = [0, 1].map(|k| hit.uv[k] * self.uv_mm[k]);
        let (number, arc) = counted(along, self.length_mm);
        let (row, x, half_width) = if self.width_mm > 0.0 {
            let (row, from) = counted(across, self.width_mm);
            (row, 2.0 * from / self.width_mm - 1.0, 0.5 * self.width_mm)
        } else {
            (0, hit.uv[1].clamp(-1.0, 1.0), self.uv_mm[1])
        };
        let is_one = self.width_mm == 0.0 && self.length_mm == 0.0;
        let id = if is_one { hit.id } else { hash(hit.id, &[row as u64, number as u64]) };
        let phase = if is_one { 0.0 } else { unit_of(split_mix(id)) };
        let place = if self.cell_mm > 0.0 { arc / self.cell_mm + phase } else { 0.5 };
        let cell = place.floor();
        let ribbon = OnRibbon {
            half_width,
            cell: cell as i64 as u64,
            place: place - cell,
            cell_length: self.cell_mm,
            ..OnRibbon::default()
        };
        let mut on = Hit {
            frame: frame.pitched(self.swelling * (1.0 - 2.0 * ribbon.place)),
            uv: [arc, sign * x],
            ribbon,
            id,
            instance: split_mix(id ^ split_mix(ribbon.cell)),
            ..*hit
        };
        on.set_footprint(hit.footprint);
        on
    }
}

/// Which of the pieces of a length a place lies in, and how far from its beginning; all is one piece where they have none.
#[inline]
fn counted(place: f64, length: f64) -> (i64, f64) {
    if length == 0.0 {
        return (0, place);
    }
    let number = (place / length).floor();
    (number as i64, place - number * length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Frame;
    use crate::bsdf::tests::barbule;

    const LAYOUT: Layout =
        Layout { uv_mm: [8.0, 4.0], width_mm: 0.5, length_mm: 2.0, cell_mm: 0.25, swelling: 0.0 };

    fn at(uv: [f64; 2]) -> Hit {
        Hit { uv, uv_gradients: [DVec3::Y / 8.0, DVec3::X / 4.0], id: 9, ..Hit::default() }
    }

    /// Rows of half a millimetre and barbules of two, also beyond u = 0 and v = 0; what lies in one has its identity.
    #[test]
    fn barbules_are_counted_along_and_across() {
        let on = LAYOUT.on_barbule(&at([0.3, 0.35]));
        // 2.4 mm along, 1.4 mm across.
        assert!((on.uv[0] - 0.4).abs() < 1e-12 && (on.uv[1] - 0.6).abs() < 1e-12, "{:?}", on.uv);
        let same = LAYOUT.on_barbule(&at([0.49, 0.26]));
        assert_eq!(on.id, same.id);
        for other in [[0.3, 0.38], [0.24, 0.35], [-0.2, 0.35], [0.3, -0.35]] {
            assert_ne!(LAYOUT.on_barbule(&at(other)).id, on.id, "{other:?}");
        }
        let below = LAYOUT.on_barbule(&at([-0.05, -0.1]));
        assert!((below.uv[0] - 1.6).abs() < 1e-12 && (below.uv[1] + 0.6).abs() < 1e-12, "{:?}", below.uv);
        let mut cells: Vec<u64> = (0..2000)
            .map(|k| LAYOUT.on_barbule(&at([0.25 + 0.25 * f64::from(k) / 2000.0, 0.35])).instance)
            .collect();
        cells.dedup();
        // Eight cells of a quarter of a millimetre; a barbule begins anywhere in one.
        assert_eq!(cells.len(), 9);
        assert_eq!((on.ribbon.cell_length, on.ribbon.half_width), (0.25, 0.25));
    }

    /// Frames stay right-handed where v grows to the left; places across are those of the frame, not of v.
    #[test]
    fn mirrored_coordinates_keep_the_frame() {
        let slanting = DVec3::new(0.3, 0.9, 0.0);
        for [u, v] in [[DVec3::Y, DVec3::X], [DVec3::Y, DVec3::NEG_X], [slanting, DVec3::NEG_X]] {
            let hit = Hit { uv: [0.0, 0.1], uv_gradients: [u, v], ..Hit::default() };
            let on = Layout { width_mm: 0.0, ..LAYOUT }.on_barbule(&hit);
            let Frame { x, y, z } = on.frame;
            assert!((x.cross(y) - z).length() < 1e-12 && z == DVec3::Z);
            assert!(y.dot(u) > 0.0 && y.dot(v).abs() < 1e-12);
            assert_eq!(on.uv[1], 0.1 * v.dot(x).signum());
        }
        let degenerate = Hit { uv_gradients: [DVec3::Y; 2], ..Hit::default() };
        assert_eq!(LAYOUT.on_barbule(&degenerate).frame.y, LAYOUT.on_barbule(&Hit::default()).frame.y);
    }

    /// Of a footprint that holds several cells the mean is seen.
    #[test]
    fn contrast_is_that_of_the_barbules_lengths() {
        let hit = Hit { footprint: 0.5, ..at([0.1, 0.1]) };
        // Two barbules of half a millimetre by four cells of a quarter.
        assert!((LAYOUT.on_barbule(&hit).ribbon.contrast - 8.0_f64.sqrt().recip()).abs() < 1e-12);
    }

    #[test]
    fn layouts_out_of_range_are_refused() {
        let message = |layout| Clad::new(barbule(), layout).unwrap_err().to_string();
        assert!(message(Layout { uv_mm: [0.0, 1.0], ..LAYOUT }).contains("units of u and v are 0 and 1 mm"));
        assert!(message(Layout { cell_mm: -1.0, ..LAYOUT }).contains("a cell of -1 mm"));
        assert!(message(Layout { width_mm: f64::NAN, ..LAYOUT }).contains("a width of NaN mm"));
        assert!(message(Layout { swelling: 2.0, ..LAYOUT }).contains("give 0 to less than 90"));
    }
}
