//! The cross-section of a shaft: round in the quill, then a flattening superellipse with a groove along its underside.

use std::f64::consts::TAU;

use glam::DVec2;

use super::{ShaftShape, smoothstep};
use crate::math::rng::Stream;

/// Half the width of the groove over the shaft's half width.
const GROOVE_WIDTH: f64 = 0.4;
/// Step of the differences that normals are made of, rad.
const STEP: f64 = 1e-3;

/// A cross-section: a closed curve about the axis, x to the right, y dorsal, mm.
pub(super) struct Section<'a> {
    radius: f64,
    height: f64,
    lower: f64,
    exponent: f64,
    groove: f64,
    along: f64,
    ridges: &'a Ridges,
}

impl<'a> Section<'a> {
    /// The section at a share of the shaft's length where half the width is `radius`, mm.
    pub(super) fn new(shape: &ShaftShape, ridges: &'a Ridges, along: f64, radius: f64) -> Self {
        let t = ((along - shape.calamus) / (1.0 - shape.calamus)).clamp(0.0, 1.0);
        // Full shape is reached in the first fifth of the vane; the height goes on to change to the tip.
        let begun = smoothstep(t / 0.2);
        Self {
            radius,
            height: shape.height_at(along),
            lower: 1.0 + (shape.ventral_height - 1.0) * begun,
            exponent: 2.0 + (shape.squareness - 2.0) * begun,
            groove: shape.groove * begun,
            along,
            ridges,
        }
    }

    /// The point in a direction from the axis, an angle from the right towards the dorsal side, rad.
    fn point(&self, angle: f64) -> DVec2 {
        let direction = DVec2::new(libm::cos(angle), libm::sin(angle));
        let height = self.height * if direction.y < 0.0 { self.lower } else { 1.0 };
        let part = |x: f64| libm::pow(x.abs(), self.exponent);
        let reach = libm::pow(part(direction.x) + part(direction.y / height), -1.0 / self.exponent);
        let place = direction * (reach * (1.0 + self.ridges.height(angle, self.along)));
        let near = place.x / GROOVE_WIDTH;
        let groove = if direction.y < 0.0 { self.groove * libm::exp(-near * near) } else { 0.0 };
        let depth = groove * height * self.lower * libm::pow(-direction.y.min(0.0), 2.0);
        self.radius * DVec2::new(place.x, place.y + depth)
    }

    /// The point and the outward normal there.
    pub(super) fn at(&self, angle: f64) -> (DVec2, DVec2) {
        let along = self.point(angle + STEP) - self.point(angle - STEP);
        (self.point(angle), DVec2::new(along.y, -along.x).normalize_or(DVec2::X))
    }
}

impl ShaftShape {
    /// Height over width of the cross-section at a share of the length: that of the quill, then linear to the tip's.
    pub(super) fn height_at(&self, along: f64) -> f64 {
        let t = ((along - self.calamus) / (1.0 - self.calamus)).clamp(0.0, 1.0);
        self.height + (self.tip_height - self.height) * t
    }
}

/// Fine ridges along a shaft: waves around it of random phase that drift slowly along it.
pub(super) struct Ridges {
    /// Waves around the shaft, height over the radius, phase, phase over the shaft's length.
    waves: [(f64, f64, f64, f64); 5],
}

impl Ridges {
    pub(super) fn new(identity: u64) -> Self {
        let mut stream = Stream::new(identity, &[0, 1]);
        let waves = [9.0, 14.0, 21.0, 27.0, 33.0].map(|count| {
            let drift = stream.uniform(-3.0, 3.0);
            (count, 0.06 / count * stream.uniform(0.6, 1.4), TAU * stream.unit(), TAU * drift)
        });
        Self { waves }
    }

    /// Height over the radius.
    fn height(&self, angle: f64, along: f64) -> f64 {
        let wave = |&(count, size, phase, drift): &(f64, f64, f64, f64)| {
            size * libm::sin(count * angle + phase + drift * along)
        };
        self.waves.iter().map(wave).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::feather::Feather;

    const SMOOTH: Ridges = Ridges { waves: [(9.0, 0.0, 0.0, 0.0); 5] };

    #[test]
    fn a_quill_is_round_and_a_rachis_flat_with_a_groove_below() {
        let mut shape = Feather::of_type("primary").unwrap().shaft;
        shape.height = 1.0;
        shape.squareness = 3.0;
        shape.groove = 0.2;
        shape.tip_height = 0.5;
        let quill = Section::new(&shape, &SMOOTH, 0.5 * shape.calamus, 1.5);
        for i in 0..32 {
            let angle = TAU * f64::from(i) / 32.0;
            let (point, normal) = quill.at(angle);
            assert!((point.length() - 1.5).abs() < 1e-12);
            assert!((normal - point / 1.5).length() < 1e-5, "{point} {normal}");
        }
        let tip = Section::new(&shape, &SMOOTH, 0.999, 1.0);
        let [right, up, down] = [0.0, 0.25, 0.75].map(|turn| tip.at(TAU * turn).0);
        assert!((right.x - 1.0).abs() < 1e-12 && (up.y - 0.5).abs() < 1e-2, "{right} {up}");
        // A fifth of the depth of the underside is cut out in its middle, beside it nothing.
        let depth = -down.y / (0.5 * shape.ventral_height);
        assert!((0.7..0.95).contains(&depth), "{depth}");
        // Squarer than an ellipse: fuller at 45°.
        let corner = tip.at(TAU / 8.0).0;
        assert!(corner.x * corner.x + corner.y * corner.y / 0.25 > 1.1);
    }
}
