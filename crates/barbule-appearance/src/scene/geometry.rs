//! Shapes of an object: triangle meshes, ribbons (barbules) and round curves (fibres).
//!
//! Lengths are mm. Single precision: a scene of a few mm resolves a nanometre, and memory stays small. Every shape
//! carries an identity from which instances of a material are drawn.

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec2, Vec3};

use super::window::Window;
use crate::math::rng::split_mix;
use crate::{Error, Result};

/// Most places of shapes that repeat in objects that stand in several places: each takes a quarter of a kilobyte.
const MOST_PLACES: usize = 10_000_000;

/// A triangle mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Positions, mm.
    pub positions: Vec<Vec3>,
    /// Unit normals, one a position, or none: then faces are flat.
    pub normals: Vec<Vec3>,
    /// Unit tangents (the fibre's or barb's long axis), one a position, or none.
    pub tangents: Vec<Vec3>,
    /// Texture coordinates, one a position, or none.
    pub uvs: Vec<Vec2>,
    /// Corners of each triangle; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Identity of the object.
    pub id: u64,
}

/// One point of a ribbon's middle line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RibbonNode {
    /// On the middle line, mm.
    pub point: Vec3,
    /// From the middle line to the +x edge: half the width times the unit vector across, mm.
    pub across: Vec3,
    /// Arc length from the ribbon's base, mm.
    pub arc: f32,
}

/// A flat, bent, tapering ribbon: one barbule, or the envelope of a barb with its barbules. Flat across; the curvature
/// across a barbule is in its BRDF.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ribbon {
    /// First of its nodes in [`Geometry::ribbon_nodes`].
    pub first: u32,
    /// Number of nodes, at least 2.
    pub count: u32,
    /// Identity of the barbule.
    pub id: u64,
    /// Length of a cell along the barbule, mm: structure is constant within it.
    pub cell: f32,
    /// Where in its first cell the barbule begins, as a fraction of a cell.
    pub phase: f32,
    /// Cells are low arches: slope at their ends, rad. Shades only; the ribbon itself is smooth.
    pub swelling: f32,
    /// Of a barb: arc length of its base on the shaft, mm.
    pub station: f32,
}

impl RibbonNode {
    /// The ribbon's direction at the `i`-th of its nodes, not normalized: the mean of the segments beside it, so that frames turn smoothly;
    /// at the ends they go on turning.
    #[inline]
    #[must_use]
    pub fn tangent(nodes: &[Self], i: usize) -> Vec3 {
        let last = nodes.len() - 2;
        let segment = |i: usize| (nodes[i + 1].point - nodes[i].point).normalize_or(Vec3::Y);
        match i {
            0 => segment(0) * 1.5 - segment(1.min(last)) * 0.5,
            i if i > last => segment(last) * 1.5 - segment(last.saturating_sub(1)) * 0.5,
            i => (segment(i - 1) + segment(i)) * 0.5,
        }
    }
}

/// One point of a round curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CurveNode {
    /// On the axis, mm.
    pub point: Vec3,
    /// Radius, mm.
    pub radius: f32,
    /// Unit normal of the vane here; zero for a fibre of no vane.
    pub vane_normal: Vec3,
}

/// A round, tapering fibre of conical segments.
#[derive(Debug, Clone, Copy)]
pub struct Curve {
    /// First of its nodes in [`Geometry::curve_nodes`].
    pub first: u32,
    /// Number of nodes, at least 2.
    pub count: u32,
    /// Identity of the fibre.
    pub id: u64,
}

/// Where an object stands: scaled, turned, moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Factor to all lengths; over 0.
    pub scale: f64,
    /// The turn.
    pub turn: DMat3,
    /// The move, mm.
    pub shift: DVec3,
    /// Identity of the instance; shapes there have identities made of theirs and this.
    pub id: u64,
}

impl Place {
    /// Where it was made.
    pub const HERE: Self = Self { scale: 1.0, turn: DMat3::IDENTITY, shift: DVec3::ZERO, id: 0 };

    /// A point of the object in the scene.
    #[inline]
    #[must_use]
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.turn * (point * self.scale) + self.shift
    }

    /// A point of the scene in the object.
    #[inline]
    #[must_use]
    pub fn point_back(&self, point: DVec3) -> DVec3 {
        self.turn.transpose() * (point - self.shift) / self.scale
    }

    /// A direction of the object in the scene.
    #[inline]
    #[must_use]
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.turn * direction
    }

    /// A direction of the scene in the object.
    #[inline]
    #[must_use]
    pub fn direction_back(&self, direction: DVec3) -> DVec3 {
        self.turn.transpose() * direction
    }

    /// This place within an object that stands in another: first here, then there.
    #[must_use]
    pub fn then(&self, outer: &Self) -> Self {
        Self {
            scale: self.scale * outer.scale,
            turn: outer.turn * self.turn,
            shift: outer.point(self.shift),
            id: split_mix(self.id ^ split_mix(outer.id)),
        }
    }

    /// The box about a box of the object.
    #[must_use]
    pub fn bounds(&self, [low, high]: [Vec3; 2]) -> [Vec3; 2] {
        let corners = (0..8).map(|k| {
            let pick = |bit: u32, low: f32, high: f32| if k >> bit & 1 == 0 { low } else { high };
            let corner = Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z));
            self.point(corner.as_dvec3()).as_vec3()
        });
        let empty = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        corners.fold(empty, |[low, high], corner| [low.min(corner), high.max(corner)])
    }
}

/// All shapes of an object.
#[derive(Debug, Clone, Default)]
pub struct Geometry {
    /// Triangle meshes.
    pub meshes: Vec<Mesh>,
    /// Ribbons.
    pub ribbons: Vec<Ribbon>,
    /// Points of all ribbons.
    pub ribbon_nodes: Vec<RibbonNode>,
    /// Round curves.
    pub curves: Vec<Curve>,
    /// Points of all curves.
    pub curve_nodes: Vec<CurveNode>,
    /// Where all of this stands, once for each; where it was made, if there are none.
    pub places: Vec<Place>,
    /// More shapes, each in places of its own, which are places within this object.
    pub repeated: Vec<Self>,
    /// What its meshes show in place of their own surface.
    pub window: Option<Arc<Window>>,
}

impl Geometry {
    /// Adds a ribbon through these nodes (`first` and `count` are set here). Fewer than two nodes add nothing.
    pub fn add_ribbon(&mut self, nodes: &[RibbonNode], ribbon: Ribbon) {
        if nodes.len() < 2 {
            return;
        }
        let first = self.ribbon_nodes.len() as u32;
        self.ribbon_nodes.extend_from_slice(nodes);
        self.ribbons.push(Ribbon { first, count: nodes.len() as u32, ..ribbon });
    }

    /// Adds a round curve. Fewer than two nodes add nothing.
    pub fn add_curve(&mut self, nodes: &[CurveNode], id: u64) {
        if nodes.len() < 2 {
            return;
        }
        let first = self.curve_nodes.len() as u32;
        self.curve_nodes.extend_from_slice(nodes);
        self.curves.push(Curve { first, count: nodes.len() as u32, id });
    }

    /// The same with round curves in place of ribbons: as wide, with the normals of the ribbons' upper sides as the vane's.
    #[must_use]
    pub fn ribbons_as_curves(mut self) -> Self {
        let ribbons = std::mem::take(&mut self.ribbons);
        let nodes = std::mem::take(&mut self.ribbon_nodes);
        for ribbon in ribbons {
            let own = &nodes[ribbon.first as usize..(ribbon.first + ribbon.count) as usize];
            let curve: Vec<CurveNode> = (0..own.len())
                .map(|i| {
                    let along = own[(i + 1).min(own.len() - 1)].point - own[i.saturating_sub(1)].point;
                    let vane_normal = own[i].across.cross(along).normalize_or(Vec3::Z);
                    CurveNode { point: own[i].point, radius: own[i].across.length(), vane_normal }
                })
                .collect();
            self.add_curve(&curve, ribbon.id);
        }
        self.repeated = self.repeated.into_iter().map(Self::ribbons_as_curves).collect();
        self
    }

    /// Where shapes that repeat in it stand in the scene: each of their places in each of the object's.
    #[must_use]
    pub fn places_of<'a>(&'a self, repeated: &'a Self) -> Box<dyn Iterator<Item = Place> + 'a> {
        match (&self.places[..], &repeated.places[..]) {
            (own, []) => Box::new(own.iter().copied()),
            ([], inner) => Box::new(inner.iter().copied()),
            (own, inner) => {
                Box::new(own.iter().flat_map(|outer| inner.iter().map(|place| place.then(outer))))
            }
        }
    }

    /// How many ribbons stand there.
    #[must_use]
    pub fn ribbon_count(&self) -> usize {
        let repeated = self.repeated.iter().map(Self::ribbon_count).sum::<usize>();
        (self.ribbons.len() + repeated) * self.places.len().max(1)
    }

    /// The nodes of a ribbon.
    #[must_use]
    pub fn nodes_of(&self, ribbon: &Ribbon) -> &[RibbonNode] {
        &self.ribbon_nodes[ribbon.first as usize..(ribbon.first + ribbon.count) as usize]
    }

    /// Number of primitives that rays are tested against.
    #[must_use]
    pub fn primitives(&self) -> usize {
        self.meshes.iter().map(|m| m.triangles.len()).sum::<usize>() + self.ribbon_nodes.len()
            - self.ribbons.len()
            + self.curve_nodes.len()
            - self.curves.len()
            + self.repeated.iter().map(Self::primitives).sum::<usize>()
    }

    /// The nodes of a curve.
    #[must_use]
    pub fn nodes_of_curve(&self, curve: &Curve) -> &[CurveNode] {
        &self.curve_nodes[curve.first as usize..(curve.first + curve.count) as usize]
    }

    /// Smallest and largest coordinates of all points in all places, mm; nothing where there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let both = |[low, high]: [Vec3; 2], [a, b]: [Vec3; 2]| [low.min(a), high.max(b)];
        let repeated = self.repeated.iter().filter_map(Self::bounds);
        let within = self.own_bounds().into_iter().chain(repeated).reduce(both)?;
        Some(self.places.iter().map(|place| place.bounds(within)).reduce(both).unwrap_or(within))
    }

    /// The same where it was made, of what is not repeated.
    #[must_use]
    pub fn own_bounds(&self) -> Option<[Vec3; 2]> {
        let points = (self.meshes.iter().flat_map(|m| &m.positions))
            .chain(self.ribbon_nodes.iter().map(|n| &n.point))
            .chain(self.curve_nodes.iter().map(|n| &n.point));
        points.fold(None, |bounds: Option<[Vec3; 2]>, &point| {
            let [low, high] = bounds.unwrap_or([point; 2]);
            Some([low.min(point), high.max(point)])
        })
    }

    /// The largest half width of a ribbon or curve: so far shapes reach beyond the box about their points, mm.
    #[must_use]
    pub fn widest(&self) -> f32 {
        let curves = self.curve_nodes.iter().map(|node| node.radius);
        let ribbons = self.ribbon_nodes.iter().map(|node| node.across.length());
        curves.chain(ribbons).chain(self.repeated.iter().map(Self::widest)).fold(0.0, f32::max)
    }

    /// Refuses what would break the renderer: corners that do not exist, numbers that are not finite.
    ///
    /// # Errors
    /// The first such fault.
    pub fn check(&self) -> Result<()> {
        for (index, mesh) in self.meshes.iter().enumerate() {
            let refuse = |what: &str| Err(Error::input(format!("mesh {index}: {what}")));
            let count = mesh.positions.len();
            if mesh.triangles.iter().flatten().any(|&corner| corner as usize >= count) {
                return refuse("a triangle has a corner that does not exist");
            }
            let whole = |length: usize| length == 0 || length == count;
            if !(whole(mesh.normals.len()) && whole(mesh.tangents.len()) && whole(mesh.uvs.len())) {
                return refuse("normals, tangents and texture coordinates must be as many as positions");
            }
            if !mesh.positions.iter().all(|p| p.is_finite()) {
                return refuse("a position is not finite");
            }
        }
        self.repeated.iter().try_for_each(Self::check)?;
        if self.repeated.iter().any(|repeated| !repeated.repeated.is_empty()) {
            return Err(Error::input("shapes that repeat have shapes that repeat in them"));
        }
        let inner: usize = self.repeated.iter().map(|repeated| repeated.places.len()).sum();
        let all = inner.saturating_mul(self.places.len());
        if all > MOST_PLACES {
            return Err(Error::input(format!(
                "{inner} places of shapes that repeat stand in {} places each, {all} together, over the limit of {MOST_PLACES}; \
                 give fewer of either",
                self.places.len()
            )));
        }
        let finite = self.ribbon_nodes.iter().all(|n| n.point.is_finite() && n.across.is_finite())
            && self.curve_nodes.iter().all(|n| n.point.is_finite() && n.radius.is_finite());
        if finite {
            return Ok(());
        }
        Err(Error::input("a ribbon or curve has a point that is not finite"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place within another is both one after the other; of many within many too many are refused.
    #[test]
    fn places_stand_within_places() {
        let place = |angle: f64, scale: f64, id: u64| {
            let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle);
            Place { scale, turn, shift: DVec3::new(angle, 2.0, -scale), id }
        };
        let (inner, outer) = (place(0.7, 0.5, 3), place(-1.9, 3.0, 4));
        let both = inner.then(&outer);
        let point = DVec3::new(0.3, -1.2, 2.5);
        assert!((both.point(point) - outer.point(inner.point(point))).length() < 1e-12);
        assert!((both.point_back(both.point(point)) - point).length() < 1e-12);
        assert_ne!(both.id, outer.then(&inner).id);
        let node = |x: f32| CurveNode { point: Vec3::new(x, 0.0, 0.0), radius: 0.1, ..CurveNode::default() };
        let mut shape = Geometry { places: vec![inner; 4000], ..Geometry::default() };
        shape.add_curve(&[node(0.0), node(1.0)], 0);
        let object = |count: usize| Geometry {
            places: vec![outer; count],
            repeated: vec![shape.clone()],
            ..Geometry::default()
        };
        let (two, many) = (object(2), object(2501));
        assert!(two.check().is_ok() && two.places_of(&shape).count() == 8000);
        let [low, high] = two.bounds().unwrap();
        let end = both.point(DVec3::X).as_vec3();
        assert!(low.cmple(end + 1e-5).all() && high.cmpge(end - 1e-5).all(), "{low} {high} {end}");
        assert!(many.check().unwrap_err().to_string().contains("10004000 together, over the limit"));
        let nested = Geometry { repeated: vec![two], ..Geometry::default() };
        assert!(nested.check().unwrap_err().to_string().contains("repeat in them"));
    }

    #[test]
    fn missing_corners_and_points_that_are_not_finite_are_refused() {
        let mesh = Mesh { positions: vec![Vec3::ZERO; 3], triangles: vec![[0, 1, 3]], ..Mesh::default() };
        let geometry = Geometry { meshes: vec![mesh], ..Geometry::default() };
        assert!(geometry.check().unwrap_err().to_string().contains("corner that does not exist"));
        let mut geometry = Geometry::default();
        let node = |x: f32| CurveNode { point: Vec3::new(x, 0.0, 0.0), radius: 0.1, ..CurveNode::default() };
        assert_eq!(geometry.bounds(), None);
        geometry.add_curve(&[node(0.0), node(1.0)], 0);
        assert!(geometry.check().is_ok());
        assert_eq!((geometry.primitives(), geometry.bounds()), (1, Some([Vec3::ZERO, Vec3::X])));
        geometry.add_curve(&[node(0.0), node(f32::NAN)], 0);
        assert!(geometry.check().is_err());
    }
}
