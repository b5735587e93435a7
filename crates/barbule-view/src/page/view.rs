//! Camera and lamp of the page, and how fingers and mice move them.

use std::f64::consts::{FRAC_PI_2, TAU};

use barbule_appearance::scene::description::ToneWord;
use glam::{DVec3, Vec3};

use crate::scene::Shape;
use crate::stage::Look;

/// Turn for a drag over one point of the screen, rad.
const PER_POINT: f64 = 0.008;
/// How far the camera is, in widths of its picture: as cameras of scenes.
const DISTANCE: f64 = 4.0;
/// The lamp's angular radius, rad: a small window's rather than the sun's, whose glints would be single pixels.
const LAMP_RADIUS: f64 = 0.08;
/// What a white surface that faces the lamp shines, and radiance of the sky.
const LAMP: f64 = 2.0;
const SKY: f32 = 0.5;
/// Linear sRGB behind everything: a grey that is dark enough for glints.
const BEHIND: [f32; 3] = [0.008, 0.008, 0.009];
/// How much wider than the shape its picture is.
const MARGIN: f64 = 1.12;
/// The picture at its narrowest and widest, in those that show the whole shape.
const ZOOM: [f64; 2] = [0.02, 2.0];

/// A direction: the azimuth from +y clockwise seen from +z, and the elevation, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// From +y, clockwise seen from +z.
    pub azimuth: f64,
    /// Over the plane z = 0.
    pub elevation: f64,
}

impl Bearing {
    /// From degrees.
    #[must_use]
    pub fn degrees(azimuth: f64, elevation: f64) -> Self {
        Self { azimuth: azimuth.to_radians(), elevation: elevation.to_radians() }
    }

    /// Unit vector.
    #[must_use]
    pub fn direction(self) -> DVec3 {
        let (sine, cosine) = self.azimuth.sin_cos();
        let (up, level) = self.elevation.sin_cos();
        DVec3::new(level * sine, level * cosine, up)
    }

    /// Of a direction.
    #[must_use]
    pub fn of(direction: DVec3) -> Self {
        let unit = direction.normalize_or(DVec3::Z);
        Self { azimuth: unit.x.atan2(unit.y).rem_euclid(TAU), elevation: unit.z.clamp(-1.0, 1.0).asin() }
    }

    fn turned(self, azimuth: f64, elevation: f64) -> Self {
        Self {
            azimuth: (self.azimuth + azimuth).rem_euclid(TAU),
            elevation: (self.elevation + elevation).clamp(-FRAC_PI_2, FRAC_PI_2),
        }
    }
}

/// How the shape is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From the shape's middle to the camera.
    pub camera: Bearing,
    /// From the shape towards the lamp, as the camera sees it: right, up, and out of the picture. It turns with the camera.
    pub lamp: DVec3,
    /// Width of the picture over that which shows all of the shape.
    pub zoom: f64,
    /// Stops of exposure.
    pub stops: f64,
    /// Whether individuals are shown, or all as the mean.
    pub individuals: bool,
}

/// A camera's axes: unit vectors to the right and upwards in its picture, and towards it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// To the right.
    pub right: DVec3,
    /// Upwards.
    pub up: DVec3,
    /// From the target to the camera.
    pub towards: DVec3,
}

impl View {
    /// The view that the page opens with.
    #[must_use]
    pub fn usual() -> Self {
        Self {
            camera: Bearing::degrees(180.0, 30.0),
            lamp: DVec3::new(-0.35, 0.5, 0.79).normalize(),
            zoom: 1.0,
            stops: 0.0,
            individuals: true,
        }
    }

    /// The camera's axes. Its upward direction is that in which +z lies.
    #[must_use]
    pub fn axes(&self) -> Axes {
        let towards = self.camera.direction();
        let (sine, cosine) = self.camera.azimuth.sin_cos();
        let right = DVec3::new(-cosine, sine, 0.0);
        Axes { right, up: towards.cross(right), towards }
    }

    /// Unit vector towards the lamp.
    #[must_use]
    pub fn to_lamp(&self) -> DVec3 {
        let Axes { right, up, towards } = self.axes();
        (right * self.lamp.x + up * self.lamp.y + towards * self.lamp.z).normalize_or(DVec3::Z)
    }

    /// The camera turned about the shape by a drag over so many points to the right and downwards: the shape follows the finger.
    #[must_use]
    pub fn orbited(self, [right, down]: [f64; 2]) -> Self {
        Self { camera: self.camera.turned(PER_POINT * right, PER_POINT * down), ..self }
    }

    /// The lamp moved by the same drag.
    #[must_use]
    pub fn relit(self, [right, down]: [f64; 2]) -> Self {
        let moved = self.lamp + PER_POINT * DVec3::new(right, -down, 0.0);
        self.lit_from([moved.x, moved.y])
    }

    /// The lamp over a place of the disc on which the hemisphere about the camera is seen from above: to the right and up, 1 its rim.
    #[must_use]
    pub fn lit_from(self, [right, up]: [f64; 2]) -> Self {
        let radius = right.hypot(up);
        // Not quite to the rim: from there nothing that is seen would be lit.
        let scale = if radius > 0.98 { 0.98 / radius } else { 1.0 };
        let (x, y) = (right * scale, up * scale);
        Self { lamp: DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()), ..self }
    }

    /// Nearer (under 1) or further.
    #[must_use]
    pub fn zoomed(self, factor: f64) -> Self {
        Self { zoom: (self.zoom * factor).clamp(ZOOM[0], ZOOM[1]), ..self }
    }

    /// Look of a shape in a picture of this many columns and rows.
    #[must_use]
    pub fn look(&self, extent: Extent, [width, height]: [u32; 2]) -> Look {
        let Axes { up, towards, .. } = self.axes();
        // The shape fits both ways.
        let wide = (f64::from(width) / f64::from(height.max(1))).max(1.0);
        Look {
            target_mm: extent.middle,
            up,
            towards,
            width_mm: 2.0 * extent.radius * MARGIN * self.zoom * wide,
            distance: DISTANCE,
            to_lamp: self.to_lamp(),
            lamp_radius: LAMP_RADIUS,
            lamp: LAMP,
            sky: [SKY; 3],
            contrast: f32::from(u8::from(self.individuals)),
            stops: self.stops as f32,
            tone: ToneWord::Filmic,
            behind: BEHIND,
        }
    }
}

/// Where a shape is, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// The middle of its bounds.
    pub middle: DVec3,
    /// How far it reaches from there.
    pub radius: f64,
}

impl Extent {
    /// Of a shape; of one without corners a millimetre.
    #[must_use]
    pub fn of(shape: &Shape) -> Self {
        let Some([low, high]) = shape.bounds_mm() else {
            return Self { middle: DVec3::ZERO, radius: 1.0 };
        };
        let middle = 0.5 * (low + high);
        let reach = |vertex: &crate::scene::Vertex| Vec3::from(vertex.position_mm).distance(middle);
        let radius = shape.vertices.iter().map(reach).fold(0.0, f32::max);
        Self { middle: middle.as_dvec3(), radius: f64::from(radius.max(1e-3)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::sphere;

    #[test]
    fn axes_are_right_handed_and_bearings_are_those_of_directions() {
        for (azimuth, elevation) in [(0.0, 0.0), (90.0, 30.0), (200.0, -60.0), (180.0, 90.0)] {
            let view = View { camera: Bearing::degrees(azimuth, elevation), ..View::usual() };
            let Axes { right, up, towards } = view.axes();
            assert!(right.cross(up).distance(towards) < 1e-12 && up.z >= -1e-12);
            let again = Bearing::of(towards).direction();
            assert!(again.distance(towards) < 1e-12);
        }
    }

    /// The lamp stays where it is for the eye, and within the half that lights what is seen.
    #[test]
    fn the_lamp_turns_with_the_camera_and_stays_before_the_shape() {
        let view = View::usual();
        let turned = view.orbited([300.0, -80.0]);
        let seen = |view: &View| {
            let Axes { right, up, towards } = view.axes();
            DVec3::new(view.to_lamp().dot(right), view.to_lamp().dot(up), view.to_lamp().dot(towards))
        };
        assert!(seen(&view).distance(seen(&turned)) < 1e-12);
        let beyond = view.relit([1e4, -1e4]);
        assert!(beyond.lamp.z > 0.0 && (beyond.lamp.length() - 1.0).abs() < 1e-12);
        assert!(beyond.lamp.x > 0.5 && beyond.lamp.y > 0.5);
    }

    #[test]
    fn all_of_the_shape_is_in_the_picture() {
        let extent = Extent::of(&sphere().unwrap());
        assert!((extent.radius - 1.0).abs() < 1e-6);
        for size in [[200, 100], [100, 200], [100, 100]] {
            let look = View::usual().look(extent, size);
            let clip = look.clip_from_scene(size, 1.0);
            for place in [look.up, -look.up, look.up.cross(look.towards), DVec3::ZERO] {
                let at = clip.project_point3(place.as_vec3());
                assert!(at.x.abs() < 1.0 && at.y.abs() < 1.0, "{size:?} {at}");
            }
        }
        assert_eq!(View::usual().zoomed(1e9).zoom, ZOOM[1]);
    }
}
