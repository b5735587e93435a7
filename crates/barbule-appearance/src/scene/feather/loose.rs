//! Loose barbs: where nothing hooks them together they leave the vane's plane and wave.

use std::f64::consts::TAU;

use glam::DVec3;

use super::row::FlatBarb;
use super::shaft::Station;
use super::{BarbuleShape, DownyShape, noise};
use crate::math::rng::{Stream, hash};

/// How a loose barb leaves its place in the vane.
pub(super) struct Loose {
    roll: f64,
    amplitude: f64,
    wavelength: f64,
    name: u64,
    /// Two directions across the barb at its base.
    across: [DVec3; 2],
}

impl Loose {
    /// A barb that leaves the shaft at `base`; nothing where hooks hold it.
    pub(super) fn new(shape: &DownyShape, barb: &FlatBarb, base: &Station, side: f64) -> Option<Self> {
        if barb.looseness <= 0.0 {
            return None;
        }
        let mut stream = Stream::new(barb.id, &[5]);
        // All about the shaft, the roll of a normal deviation is as good as any other.
        let roll =
            if shape.spread >= TAU / 4.0 { TAU * stream.unit() } else { shape.spread * stream.normal() };
        let along = base.right * (side * libm::sin(barb.angle)) + base.tip * libm::cos(barb.angle);
        let flat = base.normal.cross(along);
        Some(Self {
            roll: side * roll * barb.looseness,
            amplitude: shape.wave * barb.length * barb.looseness,
            wavelength: shape.wavelength,
            name: hash(barb.id, &[6]),
            across: [base.normal, flat.normalize_or(base.right) * side],
        })
    }

    /// Where a point of the vane at a share u of the barb goes: turned about the shaft, and waved.
    pub(super) fn moved(&self, point: DVec3, u: f64, base: &Station) -> DVec3 {
        let turn = |v: DVec3| {
            let along = base.tip * v.dot(base.tip);
            let around = v - along;
            let roll = self.roll;
            along + around * libm::cos(roll) + base.tip.cross(around) * libm::sin(roll)
        };
        let offset = turn(point - base.point);
        let wave = |k: u64| {
            noise::smooth(hash(self.name, &[k]), u / self.wavelength + 7.0)
                - noise::smooth(hash(self.name, &[k]), 7.0)
        };
        // Stiff at the base.
        let size = self.amplitude * libm::pow(u, 0.8);
        base.point + offset + turn(self.across[0] * (size * wave(0)) + self.across[1] * (size * wave(1)))
    }
}

impl DownyShape {
    /// The barbules of loose barbs, as those of the vane are described: thin threads in the plane of the barb.
    #[must_use]
    pub fn barbules(&self) -> BarbuleShape {
        BarbuleShape {
            length_um: self.length_um,
            width_um: self.width_um,
            spacing_um: self.spacing_um,
            base_angle: self.angle,
            end_angle: 0.6 * self.angle,
            base_lift: 0.0,
            end_lift: 0.0,
            tilt: 0.0,
            root_tilt: 0.0,
            cell_um: self.node_um,
            swelling: 0.0,
            wall_um: 0.0,
            arch_low: 0.0,
            arch_high: 0.0,
        }
    }
}
