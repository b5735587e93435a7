//! The scenes on which the renderer is measured against others: a feather of B-spline curves from near and from afar, and
//! a square of hair, of metal and of a barbule's tables, under a coloured sky with a bright patch and one lamp.
//!
//! What other renderers read of them is in cm with +y up: curve files and the numbers below. Here they stand in mm with +z
//! up.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use barbule::Result;
use barbule::brdf::FeatherBrdf;
use barbule::bsdf::{
    Absorption, BarbuleSurface, Cells, Conductor, FacetRoughness, FibreIndex, Hair, HairParameters, Keratin,
    Reflectance, Surface,
};
use barbule::math::rng::Stream;
use barbule::scene::camera::{Camera, Projection};
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{CurveNode, Geometry, Mesh};
use barbule::scene::light::{Lamp, Light, Rectangle};
use barbule::scene::sky::{Environment, Sky};
use barbule::scene::spline::{Basis, ControlCurve};
use barbule::scene::{Object, Scene};

/// A feather of control points in cm, as curve files hold it.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveFeather {
    /// The shaft, then the barbs.
    pub barbs: Vec<ControlCurve>,
    /// The barbules.
    pub barbules: Vec<ControlCurve>,
}

/// Barbs on each side.
const BARBS: u32 = 300;
/// Barbules of each barb.
const BARBULES: u32 = 100;
/// Length of the shaft, cm.
const SHAFT_CM: f64 = 10.0;
/// Control points of a barb.
const POINTS_OF_BARB: u32 = 8;

impl CurveFeather {
    /// A feather 10 cm long: a shaft, 300 barbs on each side, 100 barbules on each barb; the same on every machine.
    #[must_use]
    pub fn new() -> Self {
        let mut feather = Self { barbs: vec![shaft()], barbules: Vec::new() };
        let mut stream = Stream::new(7, &[]);
        for side in [-1.0, 1.0] {
            for index in 0..BARBS {
                let place = f64::from(index) / f64::from(BARBS);
                let angle = (42.0 + 1.8 * stream.normal()).to_radians();
                let barb = barb(side, place, angle, 0.01 * stream.normal());
                for number in 0..BARBULES {
                    feather.barbules.push(barbule(&barb, side, angle, number, &mut stream));
                }
                feather.barbs.push(barb);
            }
        }
        feather
    }
}

impl Default for CurveFeather {
    fn default() -> Self {
        Self::new()
    }
}

fn shaft() -> ControlCurve {
    let point = |k: u32| {
        let t = f64::from(k) / 11.0;
        [0.0, -1.0 + (SHAFT_CM + 1.0) * t, 0.15 * libm::sin(2.0 * t), 0.1 - 0.085 * t]
    };
    (0..12).map(point).collect()
}

/// A barb at `place` (0 … 1 from base to tip), which leaves the shaft at `angle`; `lift` in cm.
fn barb(side: f64, place: f64, angle: f64, lift: f64) -> ControlCurve {
    let base = 0.4 + (SHAFT_CM - 0.5) * place;
    let width = libm::pow(libm::sin(PI * (0.12 + 0.88 * (1.0 - place)).min(1.0)).max(0.0), 0.6);
    let length = 2.2 * width + 0.15;
    let point = |k: u32| {
        let t = f64::from(k) / f64::from(POINTS_OF_BARB - 1);
        let y = base + length * t * libm::cos(angle) * (0.9 + 0.25 * t);
        let z = 0.15 * libm::sin(2.0 * (base + 1.0) / (SHAFT_CM + 1.0)) + 0.12 * t * t + lift;
        [side * length * t * libm::sin(angle), y, z, 0.006 * (1.0 - 0.6 * t)]
    };
    (0..POINTS_OF_BARB).map(point).collect()
}

/// Barbules stand on both sides of their barb in turn, bend down a little and are 0.45 mm long with a radius of 9 µm.
fn barbule(barb: &ControlCurve, side: f64, angle: f64, number: u32, stream: &mut Stream) -> ControlCurve {
    let at = (f64::from(number) + 0.5) / f64::from(BARBULES) * f64::from(POINTS_OF_BARB - 1);
    let from = DVec3::from_slice(&barb[at as usize]);
    let base = from.lerp(DVec3::from_slice(&barb[(at as usize + 1).min(barb.len() - 1)]), at.fract());
    let along = DVec3::new(side * libm::sin(angle), libm::cos(angle), 0.0);
    let turn = if number.is_multiple_of(2) { -1.0 } else { 1.0 };
    let across = DVec3::new(-along.y, along.x, 0.0) * turn;
    let direction = (0.75 * across + 0.65 * along + DVec3::Z * (0.15 * stream.normal())).normalize();
    let length = 0.045 * (1.0 + 0.15 * stream.normal());
    let point = |k: u32| {
        let t = f64::from(k) / 3.0;
        let p = base + direction * (t * length) - DVec3::Z * (0.008 * t * t);
        [p.x, p.y, p.z, 0.0009]
    };
    (0..4).map(point).collect()
}

/// One of the scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BenchScene {
    /// The feather from 2 cm away: barbules fill the picture.
    Close,
    /// The whole feather, small in the picture.
    Full,
    /// A square of hair's scattering.
    HairQuad,
    /// A square of brushed copper.
    ConductorQuad,
    /// A square of a barbule's tables.
    TableQuad,
}

impl BenchScene {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Close, Self::Full, Self::HairQuad, Self::ConductorQuad, Self::TableQuad];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Close => "feather, close",
            Self::Full => "feather, full",
            Self::HairQuad => "quad, hair",
            Self::ConductorQuad => "quad, conductor",
            Self::TableQuad => "quad, table",
        }
    }

    /// The scene; `feather` where it shows one, and `tables`, which are asked for only where it has them.
    ///
    /// # Errors
    /// What `tables` says; all else that it is made of is in range.
    pub fn scene(
        self,
        feather: &CurveFeather,
        tables: impl FnOnce() -> Result<Arc<FeatherBrdf>>,
    ) -> Result<Scene> {
        let objects = match self {
            Self::Close | Self::Full => {
                let mut geometry = Geometry::default();
                for (id, curve) in (1_u64..).zip(feather.barbs.iter().chain(&feather.barbules)) {
                    let points: Vec<CurveNode> = curve.iter().map(node).collect();
                    geometry.add_control_curve(&points, Basis::BSpline, id);
                }
                vec![Object { geometry, surface: hair()? }]
            }
            Self::HairQuad => vec![Object { geometry: square(), surface: hair()? }],
            Self::ConductorQuad => {
                vec![Object {
                    geometry: square(),
                    surface: Surface::Conductor(Conductor::copper(FacetRoughness {
                        across: 0.3,
                        along: 0.1,
                    })?),
                }]
            }
            Self::TableQuad => {
                let under = Keratin::new(0.3, 1.56, Reflectance::melanin(2.0)?)?;
                let brdf = tables()?;
                let surface = BarbuleSurface {
                    brdf,
                    instances: false,
                    below: None,
                    under,
                    cells: Cells::default(),
                    opacity: 1.0,
                };
                vec![Object { geometry: square(), surface: Surface::Barbule(surface) }]
            }
        };
        Ok(Scene { objects, lamps: vec![lamp()], environment: Some(environment()?), camera: self.camera() })
    }

    fn camera(self) -> Camera {
        let (eye, target) = match self {
            Self::Close => (DVec3::new(1.0, 4.9, 1.7), DVec3::new(0.8, 5.0, 0.15)),
            _ => (DVec3::new(0.0, 4.6, 21.0), DVec3::new(0.0, 4.6, 0.0)),
        };
        let (eye, target) = (place(eye), place(target));
        // 32° from the left edge to the right one.
        let width_mm = 2.0 * (target - eye).length() * libm::tan((0.5 * 32.0_f64).to_radians());
        let projection = Projection::Perspective { lens_radius: 0.0 };
        Camera { eye, target, up: turned(DVec3::Y), width_mm, projection }
    }
}

/// From cm with +y up to mm with +z up.
fn place(point: DVec3) -> DVec3 {
    10.0 * turned(point)
}

fn turned(v: DVec3) -> DVec3 {
    DVec3::new(v.x, -v.z, v.y)
}

fn node(point: &[f64; 4]) -> CurveNode {
    let [x, y, z, radius] = *point;
    CurveNode {
        point: place(DVec3::new(x, y, z)).as_vec3(),
        radius: (10.0 * radius) as f32,
        ..CurveNode::default()
    }
}

/// Human hair of brown pigment, scales of 2°.
fn hair() -> Result<Surface> {
    Ok(Surface::Hair(Hair::new(HairParameters {
        longitudinal_roughness: 0.25,
        azimuthal_roughness: 0.3,
        scale_tilt: 2.0_f64.to_radians(),
        index: FibreIndex::Constant(1.55),
        absorption: Absorption::pigments(0.6, 0.1)?,
        height_over_width: 1.0,
    })?))
}

/// 10 cm wide, its fibres' axes across the picture: along the first direction of its texture, as others have it.
fn square() -> Geometry {
    let corner = |x: f64, y: f64| place(DVec3::new(x, y, 0.0)).as_vec3();
    let mesh = Mesh {
        positions: vec![corner(-5.0, -0.4), corner(5.0, -0.4), corner(5.0, 9.6), corner(-5.0, 9.6)],
        tangents: vec![Vec3::X; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        id: 1,
        ..Mesh::default()
    };
    Geometry { meshes: vec![mesh], ..Geometry::default() }
}

/// A square of 3 cm that faces the feather's middle, of daylight.
fn lamp() -> Lamp {
    let (from, to) = (DVec3::new(6.0, 12.0, 14.0), DVec3::new(0.0, 5.0, 0.0));
    let ahead = (to - from).normalize();
    let left = DVec3::Y.cross(ahead).normalize();
    let up = ahead.cross(left);
    let corner = place(from - 1.5 * (left + up));
    Lamp {
        light: Light::Rectangle(Rectangle {
            corner,
            edge_u: place(3.0 * left),
            edge_v: place(3.0 * up),
            emission: Emission::daylight().scaled(25.0),
        }),
        weight: 1.0,
    }
}

/// Rows and columns of the sky.
const SKY: [usize; 2] = [64, 128];

/// Linear sRGB of the sky at a node of its map: blue above, brown below, a patch of white.
#[must_use]
pub fn sky_node(row: usize, column: usize) -> [f64; 3] {
    if (8..14).contains(&row) && (20..32).contains(&column) {
        return [12.0; 3];
    }
    let t = row as f64 / (SKY[0] - 1) as f64;
    [(0.25, 0.12), (0.35, 0.1), (0.6, 0.08)].map(|(above, below)| above * (1.0 - t) + below * t)
}

/// The sky of the scenes. Others interpolate between nodes, whose first row stands at the zenith and whose last at the
/// nadir; here every texel has the mean of that.
fn environment() -> Result<Environment> {
    let [height, width] = SKY;
    let fine = 8;
    let mut texels = Vec::with_capacity(width * height);
    for row in 0..height {
        for column in 0..width {
            let mut sum = DVec3::ZERO;
            let mut weight = 0.0;
            for step in 0..fine * fine {
                let part = |k: usize| (k as f64 + 0.5) / fine as f64;
                let polar = (row as f64 + part(step / fine)) / height as f64;
                let v = polar * (height - 1) as f64;
                let u = (column as f64 + part(step % fine) - 0.5).rem_euclid(width as f64);
                let at = |i: usize, j: usize| DVec3::from_array(sky_node(i, j % width));
                let (i, j) = ((v as usize).min(height - 2), u as usize);
                let value = at(i, j).lerp(at(i, j + 1), u.fract()) * (1.0 - (v - i as f64))
                    + at(i + 1, j).lerp(at(i + 1, j + 1), u.fract()) * (v - i as f64);
                let solid = libm::sin(PI * polar);
                sum += value * solid;
                weight += solid;
            }
            texels.push((sum / weight).as_vec3().to_array());
        }
    }
    Ok(Environment { sky: Sky::image(width, height, texels, 1.0, 0.0)?, weight: 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::brdf::Options;
    use barbule::brdf::fixtures::example;

    #[test]
    fn the_feather_is_as_large_as_it_says() {
        let feather = CurveFeather::new();
        assert_eq!((feather.barbs.len(), feather.barbules.len()), (601, 60_000));
        assert!(feather.barbules.iter().all(|curve| curve.len() == 4));
        let tip = feather.barbs.iter().flatten().map(|point| point[1]).fold(f64::MIN, f64::max);
        assert!((10.0..12.0).contains(&tip), "{tip}");
        assert_eq!(feather, CurveFeather::default());
    }

    #[test]
    fn every_scene_is_made_and_its_lamp_looks_at_it() {
        let mut feather = CurveFeather::new();
        feather.barbules.truncate(10);
        let tables = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
        for scene in BenchScene::ALL {
            let scene = scene.scene(&feather, || Ok(tables.clone())).unwrap();
            let Light::Rectangle(lamp) = &scene.lamps[0].light else { panic!("a rectangle") };
            let middle = lamp.corner + 0.5 * (lamp.edge_u + lamp.edge_v);
            let ahead = lamp.edge_u.cross(lamp.edge_v).normalize();
            let target = place(DVec3::new(0.0, 5.0, 0.0));
            assert!((ahead - (target - middle).normalize()).length() < 1e-12);
            assert!((lamp.edge_u.length() - 30.0).abs() < 1e-12);
            assert!(scene.objects[0].geometry.check().is_ok());
        }
    }

    /// The patch's light is that of the interpolated map: its nodes' area, 6 rows and 12 columns of it.
    #[test]
    fn the_sky_keeps_the_light_of_its_nodes() {
        let sky = environment().unwrap().sky;
        let texels = sky.texels();
        let patch: f64 = texels
            .iter()
            .enumerate()
            .map(|(i, texel)| f64::from(texel[0]) * libm::sin(PI * ((i / SKY[1]) as f64 + 0.5) / 64.0))
            .sum();
        let nodes: f64 = (0..SKY[0] * SKY[1])
            .map(|i| {
                sky_node(i / SKY[1], i % SKY[1])[0] * libm::sin(PI * (i / SKY[1]) as f64 / 63.0) * 64.0 / 63.0
            })
            .sum();
        assert!((patch / nodes - 1.0).abs() < 1e-3, "{patch} {nodes}");
    }
}
