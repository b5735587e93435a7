//! A vane as a surface: a sheet through the barbs of one side, for feathers so far that a pixel holds several barbs.

use glam::{DVec3, Vec2};

use super::barb::Barb;
use crate::math::rng::hash;
use crate::scene::geometry::{Geometry, Mesh};

/// The barbs of a sheet, in the mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetBarbs {
    /// How many there are.
    pub count: usize,
    /// From one to the next, across, mm.
    pub spacing_mm: f64,
    /// Their length, mm.
    pub length_mm: f64,
}

/// Adds the sheet through neighbouring barbs of one side; it is open where the vane gapes. Tangents are those of the barbs;
/// texture coordinates are the place of the barb's base on the shaft and the place on the barb, mm.
///
/// What its barbs measure; nothing where there is no sheet.
pub(super) fn add<'a>(
    geometry: &mut Geometry,
    barbs: impl Iterator<Item = &'a Barb>,
    origin: DVec3,
    identity: u64,
) -> Option<SheetBarbs> {
    let (mut lengths, mut strips) = (0.0, 0);
    let mut mesh = Mesh::default();
    let mut before: Option<(&Barb, u32)> = None;
    for barb in barbs {
        let first = mesh.positions.len() as u32;
        let step = barb.length_mm / (barb.points.len() - 1) as f64;
        for (i, point) in barb.points.iter().enumerate() {
            mesh.positions.push((*point - origin).as_vec3());
            mesh.normals.push(barb.normals[i].as_vec3());
            mesh.tangents.push(barb.tangents[i].as_vec3());
            mesh.uvs.push(Vec2::new(barb.along_mm as f32, (i as f64 * step) as f32));
        }
        if let Some((last, from)) = before
            && !last.is_free[0]
        {
            lengths += 0.5 * (last.length_mm + barb.length_mm);
            strips += 1;
            let quads = 0..barb.points.len() as u32 - 1;
            mesh.triangles.extend(quads.flat_map(|i| {
                let [a, b, c, d] = [from + i, from + i + 1, first + i, first + i + 1];
                // Counter-clockwise from above on both sides of the shaft.
                if barb.side > 0.0 { [[a, b, c], [c, b, d]] } else { [[a, c, b], [c, d, b]] }
            }));
        }
        before = Some((barb, first));
    }
    if strips == 0 {
        return None;
    }
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|k| mesh.positions[k as usize].as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    let spacing = mesh.triangles.iter().map(area).sum::<f64>() / lengths;
    mesh.id = hash(identity, &[3]);
    geometry.meshes.push(mesh);
    Some(SheetBarbs {
        count: strips as usize + 1,
        spacing_mm: spacing,
        length_mm: lengths / f64::from(strips),
    })
}
