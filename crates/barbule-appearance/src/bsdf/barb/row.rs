//! The form of a row of barbules, whether each is a ribbon or they are only looked up: how they lie along a barb.

use std::f64::consts::PI;

use glam::DVec3;

/// Barbules on one side of a barb. Lengths are mm, angles rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Length in the middle of a barb.
    pub length: f64,
    /// Half the width where it is largest.
    pub half_width: f64,
    /// Distance between neighbours along the ramus.
    pub spacing: f64,
    /// Angle to the barb at the base and at the end.
    pub angle: [f64; 2],
    /// Elevation over the vane at the base and at the end.
    pub lift: [f64; 2],
    /// Turn about its own axis: positive turns the upper side towards the barb's tip.
    pub tilt: f64,
    /// Further turn at the root, gone after a tenth of the length.
    pub root_tilt: f64,
    /// Length of a cell; 0: a barbule is one cell.
    pub cell: f64,
    /// Swelling of cells, low arches along the barbule: slope at their ends.
    pub swelling: f64,
    /// Standard deviations between barbules.
    pub disorder: RowDisorder,
}

/// Standard deviations between the barbules of a row.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RowDisorder {
    /// Of the angle to the barb, rad.
    pub angle: f64,
    /// Of the lift, rad.
    pub lift: f64,
    /// Of the place, as a share of the spacing.
    pub spacing: f64,
    /// Of the length, as a share.
    pub length: f64,
    /// Of the turn about the own axis, rad.
    pub turn: f64,
}

impl Row {
    /// Angle to the barb at a share t of the barbule's length, rad.
    #[inline]
    #[must_use]
    pub fn angle_at(&self, t: f64) -> f64 {
        mix(self.angle, t)
    }

    /// Elevation over the vane there, rad.
    #[inline]
    #[must_use]
    pub fn lift_at(&self, t: f64) -> f64 {
        mix(self.lift, t)
    }

    /// Share of the disorder of lifts by which a barbule there is bent beside being turned.
    #[inline]
    #[must_use]
    pub fn bow_at(&self, t: f64) -> f64 {
        0.5 * (2.0 * t - 1.0)
    }

    /// Turn about the own axis there, rad.
    #[inline]
    #[must_use]
    pub fn tilt_at(&self, t: f64) -> f64 {
        self.tilt + self.root_tilt * (1.0 - 10.0 * t).max(0.0)
    }

    /// Half the width there, mm: narrower at the root, then full, then a thin end.
    #[inline]
    #[must_use]
    pub fn half_width_at(&self, t: f64) -> f64 {
        let root = 0.65 + 0.35 * (t / 0.12).min(1.0);
        let end = if t < 0.6 { 1.0 } else { 1.0 - 0.8 * libm::pow((t - 0.6) / 0.4, 1.5) };
        self.half_width * root * end
    }

    /// Length at a share of the barb's, mm: shorter where the barb begins and near its end.
    #[inline]
    #[must_use]
    pub fn length_at(&self, share: f64) -> f64 {
        let middle = 0.75 + 0.25 * libm::sin(PI * libm::pow(share.clamp(0.0, 1.0), 0.7));
        self.length * middle * ((1.0 - share) / 0.15).clamp(0.15, 1.0)
    }

    /// How far a barbule reaches from the ramus, over its length, at each of the shares k/(N − 1): to the side, along the barb
    /// and up.
    pub(super) fn path<const N: usize>(&self) -> [[f64; 3]; N] {
        let mut path = [[0.0; 3]; N];
        let step = 1.0 / (N - 1) as f64;
        for k in 1..N {
            let t = (k as f64 - 0.5) * step;
            let (angle, lift) = (self.angle_at(t), self.lift_at(t));
            let level = step * libm::cos(lift);
            let [side, along, up] = path[k - 1];
            path[k] = [
                side + level * libm::sin(angle),
                along + level * libm::cos(angle),
                up + step * libm::sin(lift),
            ];
        }
        path
    }

    /// How far it reaches to the side over its length.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.path::<33>()[32][0]
    }
}

#[inline]
fn mix([base, end]: [f64; 2], t: f64) -> f64 {
    base + (end - base) * t
}

/// Three unit vectors at right angles of a barbule that makes an angle with the barb and is lifted over the vane: its direction,
/// and across it ahead, in the vane's plane towards the barb's tip, and up. `sideways` points from the barb to its side.
#[inline]
#[must_use]
pub fn axes([tangent, sideways, normal]: [DVec3; 3], angle: f64, lift: f64) -> [DVec3; 3] {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let (rise, level) = (libm::sin(lift), libm::cos(lift));
    let planar = tangent * cos + sideways * sin;
    [planar * level + normal * rise, tangent * sin - sideways * cos, normal * level - planar * rise]
}

/// Half the width of a ramus at a share of its length over that at its base.
#[inline]
#[must_use]
pub fn ramus_taper(share: f64) -> f64 {
    1.0 - 0.75 * libm::pow(share.clamp(0.0, 1.0), 1.2)
}
