//! Envelopes: a ribbon about each barb as wide as its barbules reach, for barbules that are looked up instead of grown.

use glam::DVec3;

use super::barb::Barb;
use crate::bsdf::Row;
use crate::scene::geometry::{Geometry, Ribbon, RibbonNode};

/// How far above the other row of the next barb the row towards the feather's tip lies, mm: hooks hold it there.
const OVERLAP_MM: f64 = 0.01;

/// By how much the ribbons of barbs `spacing_mm` apart are turned about the barbs, so that each lies over the next, rad.
#[must_use]
pub(super) fn roll(spacing_mm: f64) -> f64 {
    libm::atan2(OVERLAP_MM, spacing_mm)
}

/// On which side of the ribbon of a barb the feather's tip lies: ±1 of the ribbon's x.
#[must_use]
pub fn tip_side(barb_side: f64) -> f64 {
    -barb_side
}

/// Adds the ribbon of a barb. Its cell is the barb.
pub(super) fn add(geometry: &mut Geometry, barb: &Barb, rows: &[Row; 2], roll: f64, origin: DVec3) {
    // Barbules of the barb's end reach beyond it.
    let longest = rows.iter().map(|row| row.length * (1.0 + 2.0 * row.disorder.length)).fold(0.0, f64::max);
    let ahead =
        longest * rows.iter().map(|row| libm::cos(row.angle[0].min(row.angle[1]))).fold(0.0, f64::max);
    let ahead = (END_SHARE * ahead).min(0.25 * barb.length_mm);
    let sin = libm::sin(roll * tip_side(barb.side));
    let cos = (1.0 - sin * sin).sqrt();
    let steps = barb.points.len() - 1;
    let node = |point: DVec3, [tangent, normal]: [DVec3; 2], arc: f64| {
        let share = arc / barb.length_mm;
        let reach = |row: &Row| {
            // A barbule that is here is rooted up to its own length before.
            let root = share - row.length * libm::cos(row.angle[0]) / barb.length_mm;
            row.length_at(share.min(1.0)).max(row.length_at(root))
                * (1.0 + 2.5 * row.disorder.length)
                * row.reach()
        };
        let half_width = barb.half_width(share) + reach(&rows[0]).max(reach(&rows[1]));
        let across = tangent.cross(normal) * cos + normal * sin;
        RibbonNode {
            point: (point - origin).as_vec3(),
            across: (across * half_width).as_vec3(),
            arc: arc as f32,
        }
    };
    let mut nodes: Vec<RibbonNode> = (0..=steps)
        .map(|i| {
            node(
                barb.points[i],
                [barb.tangents[i], barb.normals[i]],
                barb.length_mm * i as f64 / steps as f64,
            )
        })
        .collect();
    let (end, direction) = (barb.points[steps], [barb.tangents[steps], barb.normals[steps]]);
    nodes.push(node(end + direction[0] * ahead, direction, barb.length_mm + ahead));
    let ribbon = Ribbon {
        id: barb.id,
        cell: barb.length_mm as f32,
        station: barb.along_mm as f32,
        ..Ribbon::default()
    };
    geometry.add_ribbon(&nodes, ribbon);
}

/// Length over the largest of barbules at the very end of a barb, with room.
const END_SHARE: f64 = 0.6;
