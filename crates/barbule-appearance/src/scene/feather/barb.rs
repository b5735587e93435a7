//! Barbs in space: their curves and their rami.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec2};

use super::eye::Sway;
use super::loose::Loose;
use super::outline::Vane;
use super::row::{FlatBarb, PATH_STEPS, Row};
use super::shaft::{Shaft, Station, tube_triangles};
use super::{BarbShape, Feather, Grown, SplitShape, VaneDisc, split};
use crate::Result;
use crate::bsdf::{Mark, Markings, RAMUS_DEPTH, ramus_taper};
use crate::math::rng::hash;
use crate::progress::Progress;
use crate::scene::geometry::{CurveNode, Geometry, Mesh};
use crate::scene::go_on;

/// Steps of a barb's curve.
const STEPS: usize = 24;
/// Corners of the surface around a ramus.
const AROUND: usize = 8;
/// Where barbs leave the shaft, over half its height.
const BASE_HEIGHT: f64 = 0.3;

/// One barb: a curve with the vane's normal along it.
#[derive(Debug, Clone)]
pub struct Barb {
    /// Points at equal steps of the arc length, mm.
    pub points: Vec<DVec3>,
    /// Unit tangents there.
    pub tangents: Vec<DVec3>,
    /// Unit normals of the vane there.
    pub normals: Vec<DVec3>,
    /// Length, mm.
    pub length_mm: f64,
    /// −1: left of the shaft, 1: right, seen from the dorsal side.
    pub side: f64,
    /// Identity.
    pub id: u64,
    /// Half the width of the ramus at the base, mm.
    pub radius_mm: f64,
    /// The vane it belongs to.
    pub vane: Vane,
    /// Arc length of its base on the shaft, mm.
    pub along_mm: f64,
    /// Whether it is downy: no hooks hold it, and its barbules are those of [`Feather::downy`].
    pub is_loose: bool,
    /// Whether it belongs to the tuft at the vane's tip.
    pub is_tuft: bool,
    /// Whether nothing holds its distal and its proximal barbules: it is loose, or the vane gapes there.
    pub is_free: [bool; 2],
    /// Up to where on it neighbours hold it, mm; infinite where it has no free end beyond an eye.
    pub hooked_mm: f64,
    /// How much shorter barbules are at its free end, as a share.
    pub thinning: f64,
}

/// All barbs of one side whose bases can reach into a window; seed and identity name the draws.
///
/// # Errors
/// A stop by `progress`.
pub(super) fn along(
    feather: &Feather,
    shaft: &Shaft,
    side: f64,
    window: VaneDisc,
    (seed, identity): (u64, u64),
    progress: &dyn Progress,
) -> Result<Vec<Barb>> {
    let flat = laid_out(feather, shaft, side, (seed, identity), progress)?;
    let reaches = |barb: &&FlatBarb| {
        window.radius_mm.is_none_or(|radius| {
            barb.along > window.along_mm - barb.length - radius && barb.along < window.along_mm + 1.2 * radius
        })
    };
    let raised = |barb: &FlatBarb| {
        go_on(progress)?;
        Ok(raised(feather, shaft, side, barb))
    };
    flat.iter().filter(reaches).map(raised).collect()
}

/// The barbs of one side in the plane of the vane, after all that befell them.
///
/// # Errors
/// A stop by `progress`.
pub(super) fn laid_out(
    feather: &Feather,
    shaft: &Shaft,
    side: f64,
    (seed, identity): (u64, u64),
    progress: &dyn Progress,
) -> Result<Vec<FlatBarb>> {
    let vane = feather.vane_at(side);
    // Draws belong to the vane, not to the side: a feather of the other wing is the mirror image.
    let name = hash(seed, &[identity, u64::from(vane == Vane::Leading)]);
    let mut barbs = Row { feather, shaft, vane, name }.barbs(progress)?;
    split::open(feather, &mut barbs, SplitShape::name(name));
    split::clump(&feather.disorder, &mut barbs);
    Ok(barbs)
}

/// A barb on the curved vane, at equal steps of its arc length in space.
fn raised(feather: &Feather, shaft: &Shaft, side: f64, flat: &FlatBarb) -> Barb {
    let vane = feather.vane_at(side);
    let base = shaft.at(flat.along);
    let loose = Loose::new(&feather.downy, flat, &base, side);
    let sway = Sway::new(&feather.eye, flat, &base, side);
    let path: Vec<DVec3> = (0..=PATH_STEPS)
        .map(|i| {
            let u = i as f64 / PATH_STEPS as f64;
            let point = on_vane(feather, shaft, side, vane, flat.path[i], flat.under * u * u);
            match (&loose, &sway) {
                (Some(loose), _) => loose.moved(point, u, &base),
                (None, Some(sway)) => sway.moved(point, u * flat.length),
                (None, None) => point,
            }
        })
        .collect();
    let (points, length_mm) = evenly(&path);
    let tangents: Vec<DVec3> = (0..=STEPS)
        .map(|i| (points[(i + 1).min(STEPS)] - points[i.saturating_sub(1)]).normalize_or(base.tip))
        .collect();
    let width = if loose.is_some() { feather.downy.ramus_width_um } else { feather.barbs.width_um };
    let normals = match loose {
        Some(_) => carried(base.normal, &tangents),
        None => {
            let normal =
                |i: usize| vane_normal(feather, shaft, side, vane, flat.path[i * PATH_STEPS / STEPS]);
            tangents.iter().enumerate().map(|(i, t)| across(normal(i), *t)).collect()
        }
    };
    Barb {
        points,
        tangents,
        normals,
        length_mm,
        side,
        id: flat.id,
        radius_mm: 0.5e-3 * width,
        vane,
        along_mm: flat.along,
        is_loose: flat.looseness > 0.0,
        is_tuft: flat.is_tuft,
        is_free: flat.is_free,
        hooked_mm: flat.hooked_mm,
        thinning: feather.eye.thinning,
    }
}

/// A point of the vane's plane on the vane itself: beside the shaft's station there, sunk by the camber, raised by the dihedral.
fn on_vane(feather: &Feather, shaft: &Shaft, side: f64, vane: Vane, at: DVec2, under: f64) -> DVec3 {
    let shape = &feather.barbs;
    let Station { point, right, normal, .. } = shaft.at(at.y);
    let half = shape.half_width_mm(vane);
    let start = BASE_HEIGHT * shaft.radius(at.y) * shaft.height(at.y);
    let z = start + libm::tan(shape.dihedral) * at.x - shape.camber * at.x * at.x / half - under;
    point + right * (side * at.x) + normal * z
}

/// The normal of the vane there: what its camber and dihedral make of the shaft's.
fn vane_normal(feather: &Feather, shaft: &Shaft, side: f64, vane: Vane, at: DVec2) -> DVec3 {
    let along = |step: DVec2| {
        let place = |at: DVec2| on_vane(feather, shaft, side, vane, at, 0.0);
        place(at + step) - place(at - step)
    };
    (along(DVec2::X * NORMAL_STEP_MM).cross(along(DVec2::Y * NORMAL_STEP_MM)) * side)
        .normalize_or(shaft.at(at.y).normal)
}

/// Step of the differences that give normals, mm.
const NORMAL_STEP_MM: f64 = 0.02;

/// The part of a normal across a tangent.
fn across(normal: DVec3, tangent: DVec3) -> DVec3 {
    (normal - tangent * tangent.dot(normal)).normalize_or(normal)
}

/// A normal carried along a curve without turning about it.
fn carried(normal: DVec3, tangents: &[DVec3]) -> Vec<DVec3> {
    let begin = across(normal, tangents[0]);
    let mut at =
        if begin.dot(tangents[0]).abs() < 0.5 { begin } else { tangents[0].any_orthonormal_vector() };
    tangents
        .iter()
        .map(|tangent| {
            at = across(at, *tangent);
            at
        })
        .collect()
}

/// A path's points at equal steps of its arc length, and that length.
fn evenly(path: &[DVec3]) -> (Vec<DVec3>, f64) {
    let mut arcs = vec![0.0];
    for pair in path.windows(2) {
        arcs.push(arcs[arcs.len() - 1] + (pair[1] - pair[0]).length());
    }
    let length = arcs[arcs.len() - 1];
    let mut segment = 0;
    let points = (0..=STEPS)
        .map(|i| {
            let arc = length * i as f64 / STEPS as f64;
            while segment + 2 < path.len() && arcs[segment + 1] < arc {
                segment += 1;
            }
            let step = arcs[segment + 1] - arcs[segment];
            let rest = if step > 0.0 { ((arc - arcs[segment]) / step).min(1.0) } else { 0.0 };
            path[segment].lerp(path[segment + 1], rest)
        })
        .collect();
    (points, length)
}

impl Barb {
    /// A straight one of the closed vane along y, from a place in the plane z = 0; z is the vane's normal.
    pub(super) fn straight(from: DVec3, length_mm: f64, side: f64, radius_mm: f64, id: u64) -> Self {
        Self {
            points: (0..=STEPS).map(|i| from + DVec3::Y * (length_mm * i as f64 / STEPS as f64)).collect(),
            tangents: vec![DVec3::Y; STEPS + 1],
            normals: vec![DVec3::Z; STEPS + 1],
            length_mm,
            side,
            id,
            radius_mm,
            vane: Vane::Trailing,
            along_mm: 0.0,
            is_loose: false,
            is_tuft: false,
            is_free: [false; 2],
            hooked_mm: f64::INFINITY,
            thinning: 0.0,
        }
    }

    /// Whether any of it lies in the window.
    #[must_use]
    pub fn is_within(&self, origin: DVec3, window: VaneDisc) -> bool {
        self.points.iter().any(|p| window.holds(*p - origin))
    }

    /// Point, tangent and normal at an arc length, mm.
    #[must_use]
    pub fn at(&self, along_mm: f64) -> (DVec3, DVec3, DVec3) {
        let position = (along_mm / self.length_mm).clamp(0.0, 1.0) * STEPS as f64;
        let index = (position as usize).min(STEPS - 1);
        let rest = position - index as f64;
        let mix = |v: &[DVec3]| v[index].lerp(v[index + 1], rest);
        (mix(&self.points), mix(&self.tangents).normalize(), mix(&self.normals).normalize())
    }

    /// Length of its barbules at an arc length, mm, over that where it is hooked.
    pub(super) fn fullness(&self, along_mm: f64) -> f64 {
        if along_mm <= self.hooked_mm || self.length_mm <= self.hooked_mm {
            return 1.0;
        }
        1.0 - self.thinning * ((along_mm - self.hooked_mm) / (self.length_mm - self.hooked_mm)).min(1.0)
    }

    /// Half the width of the ramus at a share of its length, mm.
    #[must_use]
    pub fn half_width(&self, share: f64) -> f64 {
        self.radius_mm * ramus_taper(share)
    }

    /// The ramus as a round fibre of its width.
    #[must_use]
    pub fn nodes(&self, origin: DVec3) -> Vec<CurveNode> {
        let node = |ring: usize| {
            let half = self.half_width(ring as f64 / STEPS as f64);
            let centre = self.points[ring] - self.normals[ring] * (RAMUS_DEPTH * half);
            CurveNode {
                point: (centre - origin).as_vec3(),
                radius: half as f32,
                vane_normal: self.normals[ring].as_vec3(),
            }
        };
        (0..=STEPS).map(node).collect()
    }

    /// Adds the ramus as a round fibre of its width.
    pub(super) fn fibre(&self, geometry: &mut Geometry, origin: DVec3) {
        geometry.add_curve(&self.nodes(origin), self.id);
    }

    /// What marks a part of it of this name, so far along it, mm. Down has no markings.
    pub(super) fn mark(&self, markings: &Markings, along_mm: f64, name: u64) -> Mark {
        if self.is_loose {
            return Mark::Zone(0);
        }
        markings.at(self.side, self.along_mm, along_mm, name)
    }

    /// What marks the pieces of its ramus.
    pub(super) fn marks(&self, markings: &Markings) -> [Mark; STEPS] {
        std::array::from_fn(|segment| {
            let along = (segment as f64 + 0.5) / STEPS as f64 * self.length_mm;
            self.mark(markings, along, hash(self.id, &[segment as u64]))
        })
    }

    /// Adds the ramus to the round fibres, apart by marks.
    pub(super) fn parted(&self, grown: &mut Grown, marks: &[Mark; STEPS], origin: DVec3) {
        let nodes = self.nodes(origin);
        let mut first = 0;
        for run in marks.chunk_by(|a, b| a == b) {
            grown.fibres_at(run[0]).add_curve(&nodes[first..=first + run.len()], self.id);
            first += run.len();
        }
    }

    /// Adds the ramus to the rami, apart by zones.
    pub(super) fn meshes(&self, grown: &mut Grown, shape: &BarbShape, marks: &[Mark; STEPS], origin: DVec3) {
        let mesh = self.mesh(shape, origin);
        let zones = marks.map(Mark::zone);
        if zones.iter().all(|zone| *zone == zones[0]) {
            grown.rami_at(zones[0]).meshes.push(mesh);
            return;
        }
        let mut triangles: BTreeMap<usize, Vec<[u32; 3]>> = BTreeMap::new();
        for (zone, piece) in zones.into_iter().zip(mesh.triangles.chunks(mesh.triangles.len() / STEPS)) {
            triangles.entry(zone).or_default().extend_from_slice(piece);
        }
        for (zone, triangles) in triangles {
            grown.rami_at(zone).meshes.push(Mesh { triangles, ..mesh.clone() });
        }
    }

    /// The ramus: a tube taller than wide, piece by piece from its base.
    fn mesh(&self, shape: &BarbShape, origin: DVec3) -> Mesh {
        let mut mesh = Mesh { id: self.id, ..Mesh::default() };
        for ring in 0..=STEPS {
            let share = ring as f64 / STEPS as f64;
            let (tangent, normal) = (self.tangents[ring], self.normals[ring]);
            let across = tangent.cross(normal);
            let half = self.half_width(share);
            // The ridge stands up from the plane of the barbules and its keel hangs below it.
            let centre = self.points[ring] - normal * (RAMUS_DEPTH * half * shape.height);
            for corner in 0..AROUND {
                let angle = TAU * corner as f64 / AROUND as f64;
                let (cos, sin) = (libm::cos(angle), libm::sin(angle));
                let place = across * (half * cos) + normal * (half * shape.height * sin);
                mesh.positions.push((centre + place - origin).as_vec3());
                let outward = across * cos + normal * (sin / shape.height);
                mesh.normals.push(outward.normalize().as_vec3());
                mesh.tangents.push(tangent.as_vec3());
                mesh.uvs.push(Vec2::new(angle as f32, (share * self.length_mm) as f32));
            }
        }
        mesh.triangles = tube_triangles(STEPS, AROUND);
        mesh
    }
}
