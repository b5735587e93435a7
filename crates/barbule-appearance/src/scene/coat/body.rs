//! The body under a coat: a closed or open mesh whose corners are shared, fine enough for its feathers.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec2};

use crate::scene::faces::{Facing, Welded, has_area};
use crate::scene::geometry::{Mesh, Place};
use crate::{Error, Result};

/// Most triangles of a body.
pub const MOST_TRIANGLES: usize = 200_000;

/// A point of a body's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Where it is, mm.
    pub point: DVec3,
    /// The smoothed outward normal there.
    pub normal: DVec3,
    /// The triangle it lies in.
    pub triangle: u32,
    /// Weights of the triangle's corners; their sum is 1.
    pub weights: [f64; 3],
}

/// A body's surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Body {
    /// Corners, mm.
    pub points: Vec<DVec3>,
    /// Outward normals there, the mean over the triangles by their angles.
    pub normals: Vec<DVec3>,
    /// Corners of each triangle; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Neighbours of each corner: those of corner `i` stand from `first[i]` to `first[i + 1]`.
    neighbours: Vec<u32>,
    first_neighbour: Vec<u32>,
    /// Triangles of each corner, in the same way.
    around: Vec<u32>,
    first_around: Vec<u32>,
    chart: Chart,
    /// Whether faces of closed parts of it looked inwards, so that they were turned.
    pub was_inside_out: bool,
}

/// Where a body's texture coordinates come from.
#[derive(Debug, Clone, Default, PartialEq)]
enum Chart {
    #[default]
    None,
    /// Of an ellipsoid in its place.
    Ellipsoid { radii: DVec3, place: Place },
    /// Of the corners of the triangles from which these were made by dividing each into four so many times.
    Corners { uvs: Vec<[Vec2; 3]>, divisions: u32 },
}

impl Body {
    /// An ellipsoid in its place: an icosahedron whose triangles are divided until their edges are `edge_mm` long at most,
    /// as far as a body may have triangles.
    #[must_use]
    pub fn ellipsoid(radii_mm: [f64; 3], place: &Place, edge_mm: f64) -> Self {
        let radii = DVec3::from(radii_mm);
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        let mut points: Vec<DVec3> = (0..12)
            .map(|i| {
                let [a, b] = [1.0 - 2.0 * f64::from(i & 1), golden * (1.0 - f64::from(i & 2))];
                match i / 4 {
                    0 => DVec3::new(0.0, a, b),
                    1 => DVec3::new(a, b, 0.0),
                    _ => DVec3::new(b, 0.0, a),
                }
            })
            .collect();
        let mut triangles = Vec::new();
        for i in 0..12_u32 {
            for j in i + 1..12 {
                for k in j + 1..12 {
                    let [p, q, r] = [i, j, k].map(|corner| points[corner as usize]);
                    let is_edge = |a: DVec3, b: DVec3| (a - b).length() < 2.1;
                    if is_edge(p, q) && is_edge(q, r) && is_edge(p, r) {
                        let outwards = (q - p).cross(r - p).dot(p) > 0.0;
                        triangles.push(if outwards { [i, j, k] } else { [i, k, j] });
                    }
                }
            }
        }
        points.iter_mut().for_each(|point| *point = point.normalize() * radii);
        let onto = |point: DVec3| (point / radii).normalize() * radii;
        refine(&mut points, &mut triangles, edge_mm / place.scale, onto);
        points.iter_mut().for_each(|point| *point = place.point(*point));
        Self { chart: Chart::Ellipsoid { radii, place: *place }, ..Self::of(points, triangles) }
    }

    /// A mesh in its place: corners at the same point are made one, and flat triangles are divided until their edges are
    /// `edge_mm` long at most, as far as a body may have triangles. Faces of closed parts that look inwards are turned; what is open has
    /// no inside.
    ///
    /// # Errors
    /// No triangle with an area, too many, or a broken mesh.
    pub fn mesh(mesh: &Mesh, place: &Place, edge_mm: f64) -> Result<Self> {
        if mesh.triangles.len() > MOST_TRIANGLES {
            return Err(Error::input(format!(
                "the body has {} triangles, over the limit of {MOST_TRIANGLES}; give a coarser mesh",
                mesh.triangles.len()
            )));
        }
        let positions: Vec<DVec3> = mesh.positions.iter().map(|p| place.point(p.as_dvec3())).collect();
        let corners = mesh.triangles.iter().flatten();
        if positions.iter().any(|p| !p.is_finite())
            || corners.into_iter().any(|&c| c as usize >= positions.len())
        {
            return Err(Error::input("the body's mesh has a corner that does not exist or is not finite"));
        }
        let Welded { mut points, of: welded, step } = Welded::of(&positions);
        let uv = |corner: u32| mesh.uvs.get(corner as usize).copied().unwrap_or_default();
        let (mut triangles, mut uvs): (Vec<[u32; 3]>, Vec<[Vec2; 3]>) = mesh
            .triangles
            .iter()
            .map(|corners| (corners.map(|corner| welded[corner as usize]), corners.map(uv)))
            .filter(|(corners, _)| has_area(&points, *corners, step))
            .unzip();
        if triangles.is_empty() {
            return Err(Error::input("the body has no triangle with an area; give another mesh"));
        }
        let facing = Facing::of(&points, &triangles);
        let was_inside_out = facing.is_inside_out();
        for ((corners, uvs), _) in
            triangles.iter_mut().zip(&mut uvs).zip(&facing.is_turned).filter(|(_, turned)| **turned)
        {
            corners.swap(1, 2);
            uvs.swap(1, 2);
        }
        let divisions = refine(&mut points, &mut triangles, edge_mm, |point| point);
        let chart = if mesh.uvs.is_empty() { Chart::None } else { Chart::Corners { uvs, divisions } };
        Ok(Self { chart, was_inside_out, ..Self::of(points, triangles) })
    }

    fn of(points: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let mut normals = vec![DVec3::ZERO; points.len()];
        let mut edges = Vec::with_capacity(6 * triangles.len());
        let mut corners = Vec::with_capacity(3 * triangles.len());
        for (index, triangle) in (0_u32..).zip(&triangles) {
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|i| triangle[(k + i) % 3]);
                let (to_b, to_c) =
                    (points[b as usize] - points[a as usize], points[c as usize] - points[a as usize]);
                let cross = to_b.cross(to_c);
                let angle = libm::atan2(cross.length(), to_b.dot(to_c));
                normals[a as usize] += cross.normalize_or_zero() * angle;
                edges.extend([(a, b), (a, c)]);
                corners.push((a, index));
            }
        }
        normals.iter_mut().for_each(|normal| *normal = normal.normalize_or(DVec3::Z));
        edges.sort_unstable();
        edges.dedup();
        corners.sort_unstable();
        let (first_neighbour, neighbours) = rows(points.len(), &edges);
        let (first_around, around) = rows(points.len(), &corners);
        Self {
            points,
            normals,
            triangles,
            neighbours,
            first_neighbour,
            around,
            first_around,
            ..Self::default()
        }
    }

    /// Texture coordinates: the mesh's; of an ellipsoid, as of a sphere, u goes round from +y clockwise seen from +z, and v from the lower
    /// pole to the upper one. None where the mesh has none.
    #[must_use]
    pub fn uv(&self, spot: &Spot) -> Option<[f64; 2]> {
        match &self.chart {
            Chart::None => None,
            Chart::Ellipsoid { radii, place } => {
                let DVec3 { x, y, z } = (place.point_back(spot.point) / *radii).normalize_or(DVec3::Z);
                let turns = libm::atan2(x, y) / TAU;
                Some([turns - turns.floor(), 1.0 - libm::acos(z) / PI])
            }
            Chart::Corners { uvs, divisions } => {
                let divided = (spot.triangle as usize, spot.weights);
                let (triangle, weights) = (0..*divisions).fold(divided, |part, _| undivided(part));
                let uv: DVec2 = uvs[triangle].iter().zip(weights).map(|(uv, w)| uv.as_dvec2() * w).sum();
                Some([uv.x, uv.y])
            }
        }
    }

    /// Corners that share an edge with this one.
    #[must_use]
    pub fn neighbours(&self, corner: u32) -> &[u32] {
        let i = corner as usize;
        &self.neighbours[self.first_neighbour[i] as usize..self.first_neighbour[i + 1] as usize]
    }

    /// Triangles with this corner.
    #[must_use]
    pub fn triangles_at(&self, corner: u32) -> &[u32] {
        let i = corner as usize;
        &self.around[self.first_around[i] as usize..self.first_around[i + 1] as usize]
    }

    /// Corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|corner| self.points[corner as usize])
    }

    /// A point of a triangle by the weights of its corners.
    #[must_use]
    pub fn spot(&self, triangle: u32, weights: [f64; 3]) -> Spot {
        let corners = self.triangles[triangle as usize];
        let normal = blend(&self.normals, corners, weights).normalize_or(self.normals[corners[0] as usize]);
        Spot { point: self.point(triangle, weights), normal, triangle, weights }
    }

    /// The same, its place alone, mm.
    #[must_use]
    pub fn point(&self, triangle: u32, weights: [f64; 3]) -> DVec3 {
        blend(&self.points, self.triangles[triangle as usize], weights)
    }

    /// The surface's nearest point to `point` among those that a walk from corner to nearer corner leads to; for points
    /// beside the surface where it starts that is the nearest of all.
    #[must_use]
    pub fn foot(&self, point: DVec3, start: u32) -> Spot {
        let far = |corner: u32| (self.points[corner as usize] - point).length_squared();
        let (mut at, mut distance) = (start, far(start));
        loop {
            let next = self.neighbours(at).iter().map(|&corner| (far(corner), corner));
            let nearest = next.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            match nearest {
                Some((closer, corner)) if closer < distance => (at, distance) = (corner, closer),
                _ => break,
            }
        }
        let nearest = self.triangles_at(at).iter().map(|&triangle| {
            let (weights, squared) = nearest_in(self.corners(triangle), point);
            (squared, triangle, weights)
        });
        let best = nearest.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (_, triangle, weights) = best.unwrap_or((0.0, 0, [1.0, 0.0, 0.0]));
        self.spot(triangle, weights)
    }

    /// Area of a triangle, mm².
    #[must_use]
    pub fn area(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// The mesh with its smooth normals.
    #[must_use]
    pub fn skin(&self, id: u64) -> Mesh {
        Mesh {
            positions: self.points.iter().map(|p| p.as_vec3()).collect(),
            normals: self.normals.iter().map(|n| n.as_vec3()).collect(),
            triangles: self.triangles.clone(),
            id,
            ..Mesh::default()
        }
    }
}

/// What lies between the values at corners by their weights.
fn blend(of: &[DVec3], corners: [u32; 3], weights: [f64; 3]) -> DVec3 {
    (0..3).map(|k| of[corners[k] as usize] * weights[k]).sum()
}

/// Rows of sorted pairs: where each row begins, and all second numbers.
fn rows(count: usize, pairs: &[(u32, u32)]) -> (Vec<u32>, Vec<u32>) {
    let mut first = vec![0; count + 1];
    pairs.iter().for_each(|(row, _)| first[*row as usize + 1] += 1);
    for i in 0..count {
        first[i + 1] += first[i];
    }
    (first, pairs.iter().map(|(_, value)| *value).collect())
}

/// The triangle that a division by [`refine`] made this one from, and the weights of its corners.
fn undivided((triangle, [a, b, c]): (usize, [f64; 3])) -> (usize, [f64; 3]) {
    let weights = match triangle % 4 {
        0 => [a + 0.5 * (b + c), 0.5 * b, 0.5 * c],
        1 => [0.5 * a, b + 0.5 * (a + c), 0.5 * c],
        2 => [0.5 * a, 0.5 * b, c + 0.5 * (a + b)],
        _ => [0.5 * (a + c), 0.5 * (a + b), 0.5 * (b + c)],
    };
    (triangle / 4, weights)
}

/// Divides every triangle into four, which stand in its place, until no edge is longer than `edge_mm`, or they would be too many;
/// how many times.
fn refine(
    points: &mut Vec<DVec3>,
    triangles: &mut Vec<[u32; 3]>,
    edge_mm: f64,
    onto: impl Fn(DVec3) -> DVec3,
) -> u32 {
    let longest = |points: &[DVec3], triangles: &[[u32; 3]]| {
        let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        edges.map(|[a, b]| (points[a as usize] - points[b as usize]).length()).fold(0.0, f64::max)
    };
    let mut divisions = 0;
    while 4 * triangles.len() <= MOST_TRIANGLES && longest(points, triangles) > edge_mm {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push(onto(0.5 * (points[a as usize] + points[b as usize])));
                points.len() as u32 - 1
            })
        };
        let divided = triangles.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        *triangles = divided.collect();
        divisions += 1;
    }
    divisions
}

/// The nearest point of a triangle: its corners' weights, and the distance squared. The regions about corners, edges and the
/// face in turn [Ericson 2005, Real-Time Collision Detection, §5.1.5].
fn nearest_in([a, b, c]: [DVec3; 3], point: DVec3) -> ([f64; 3], f64) {
    let (ab, ac) = (b - a, c - a);
    let of = |corner: DVec3| [ab.dot(point - corner), ac.dot(point - corner)];
    let ([d1, d2], [d3, d4], [d5, d6]) = (of(a), of(b), of(c));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let weights = if d1 <= 0.0 && d2 <= 0.0 {
        [1.0, 0.0, 0.0]
    } else if d3 >= 0.0 && d4 <= d3 {
        [0.0, 1.0, 0.0]
    } else if d6 >= 0.0 && d5 <= d6 {
        [0.0, 0.0, 1.0]
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        [1.0 - t, t, 0.0]
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        [1.0 - t, 0.0, t]
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        [0.0, 1.0 - t, t]
    } else {
        let whole = va + vb + vc;
        [va / whole, vb / whole, vc / whole]
    };
    let nearest = a * weights[0] + b * weights[1] + c * weights[2];
    (weights, (point - nearest).length_squared())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::rng::Stream;

    /// A sphere's area, its normals and the nearest points on it, of which all are known.
    #[test]
    fn a_sphere_is_one() {
        let body = Body::ellipsoid([10.0; 3], &Place::HERE, 0.5);
        let area: f64 = (0..body.triangles.len() as u32).map(|t| body.area(t)).sum();
        assert!((area / (400.0 * PI) - 1.0).abs() < 1e-3, "{area}");
        assert_eq!(body.points.len() + body.triangles.len(), 3 * body.triangles.len() / 2 + 2);
        let mut stream = Stream::new(5, &[]);
        for _ in 0..300 {
            let direction = DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize();
            let height = stream.uniform(-2.0, 4.0);
            let foot = body.foot(direction * (10.0 + height), 7);
            // Facets of edges up to 0.5 mm lean by up to 0.025 from the sphere, over 4 mm.
            assert!((foot.point - 10.0 * direction).length() < 0.1, "{foot:?}");
            assert!(foot.normal.dot(direction) > 0.9999);
        }
    }

    /// A square of two triangles with corners of their own is one surface, and becomes fine.
    #[test]
    fn corners_are_welded_and_edges_halved() {
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        let positions = vec![
            corner(0.0, 0.0),
            corner(8.0, 0.0),
            corner(8.0, 8.0),
            corner(0.0, 0.0),
            corner(8.0, 8.0),
            corner(0.0, 8.0),
        ];
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [3, 4, 5], [0, 0, 1]], ..Mesh::default() };
        let body = Body::mesh(&mesh, &Place { scale: 0.5, ..Place::HERE }, 1.0).unwrap();
        // Edges of 4 and 5.7 mm are divided by 8.
        assert_eq!((body.triangles.len(), body.points.len()), (128, 81));
        assert!(body.normals.iter().all(|n| (*n - DVec3::Z).length() < 1e-12));
        let foot = body.foot(DVec3::new(1.3, 2.2, 0.7), 0);
        assert!((foot.point - DVec3::new(1.3, 2.2, 0.0)).length() < 1e-12);
        // Beside the surface its edge is nearest.
        assert!(
            (body.foot(DVec3::new(-1.0, 2.2, 0.7), 0).point - DVec3::new(0.0, 2.2, 0.0)).length() < 1e-12
        );
        let none = Mesh { triangles: vec![[0, 0, 1]], ..mesh.clone() };
        assert!(
            Body::mesh(&none, &Place::HERE, 1.0)
                .unwrap_err()
                .to_string()
                .contains("no triangle with an area")
        );
        let broken = Mesh { triangles: vec![[0, 1, 9]], ..mesh };
        assert!(Body::mesh(&broken, &Place::HERE, 1.0).unwrap_err().to_string().contains("does not exist"));
    }

    /// A tetrahedron about the point (1, 1, 1), with texture coordinates x and y of its corners.
    fn tetrahedron(triangles: Vec<[u32; 3]>) -> Mesh {
        let positions = vec![Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 4.0, Vec3::Z * 4.0];
        let uvs = positions.iter().map(|p| Vec2::new(p.x, p.y)).collect();
        Mesh { positions, uvs, triangles, ..Mesh::default() }
    }

    /// What is inside out looks outwards, if it is closed; what is not has no inside.
    #[test]
    fn faces_of_closed_meshes_look_outwards() {
        let outwards = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let inwards: Vec<[u32; 3]> = outwards.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let body =
            |triangles: &[[u32; 3]]| Body::mesh(&tetrahedron(triangles.to_vec()), &Place::HERE, 0.6).unwrap();
        let (right, turned) = (body(&outwards), body(&inwards));
        assert!(!right.was_inside_out && turned.was_inside_out);
        for body in [&right, &turned] {
            assert!(body.points.iter().zip(&body.normals).all(|(p, n)| n.dot(*p - DVec3::ONE) > 0.0));
        }
        let open = body(&inwards[1..]);
        assert!(!open.was_inside_out);
        let spots = (0..open.triangles.len() as u32).map(|t| open.spot(t, [1.0 / 3.0; 3]));
        // Its face at x = 0 still looks to +x.
        assert!(spots.filter(|spot| spot.point.x < 1e-9).all(|spot| spot.normal.x > 0.0));
        // One triangle the other way round.
        let mixed = body(&[inwards[0], inwards[1], inwards[2], outwards[3]]);
        assert!(mixed.was_inside_out && mixed == turned);
    }

    /// Texture coordinates that are linear in the place stay so however finely triangles are divided; an ellipsoid's are a sphere's.
    #[test]
    fn texture_coordinates_stay_with_their_places() {
        let triangles = vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        let body = Body::mesh(&tetrahedron(triangles), &Place::HERE, 0.3).unwrap();
        let mut stream = Stream::new(6, &[]);
        for triangle in 0..body.triangles.len() as u32 {
            let (a, b) = (stream.unit(), stream.unit());
            let spot = body.spot(triangle, [a, (1.0 - a) * b, (1.0 - a) * (1.0 - b)]);
            let [u, v] = body.uv(&spot).unwrap();
            assert!((u - spot.point.x).abs() + (v - spot.point.y).abs() < 1e-12);
        }
        let place = Place { scale: 2.0, shift: DVec3::new(5.0, 0.0, 0.0), ..Place::HERE };
        let egg = Body::ellipsoid([10.0, 30.0, 20.0], &place, 1.0);
        let uv = |direction: DVec3| {
            let point = direction.normalize() * DVec3::new(20.0, 60.0, 40.0) + place.shift;
            egg.uv(&Spot { point, ..egg.spot(0, [1.0, 0.0, 0.0]) }).unwrap()
        };
        for (direction, expected) in [
            (DVec3::Y, [0.0, 0.5]),
            (DVec3::X, [0.25, 0.5]),
            (DVec3::NEG_X, [0.75, 0.5]),
            (DVec3::new(0.0, -1.0, 1.0), [0.5, 0.75]),
        ] {
            let found = uv(direction);
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{direction} {found:?}");
        }
        let bare = Mesh { uvs: Vec::new(), ..tetrahedron(vec![[0, 1, 2]]) };
        let bare = Body::mesh(&bare, &Place::HERE, 1.0).unwrap();
        assert_eq!(bare.uv(&bare.spot(0, [1.0, 0.0, 0.0])), None);
    }
}
