//! Barbs from afar: on each side of a barb one strip in which its barbules are not apart, for feathers of which more barbules are
//! seen than an adapter draws.
//!
//! A strip's tangents are those of the barbules that lie in it, and its places count them: each barbule is one cell. So a feather has
//! the colours and the sparkle of its barbules, but not their shapes and gaps.

use barbule_appearance::scene::feather::{BarbuleShape, tip_side};
use barbule_appearance::scene::geometry::{Geometry, Ribbon, RibbonNode};
use barbule_base::math::rng::hash;

use super::ribbon::{frame, kept, strip, strip_triangles};
use super::{Part, Shape, Vertex};

/// Adds the envelopes of the barbs on one side of the shaft (−1: left, 1: right), of every `stride`-th of their nodes. `rows`: the
/// barbules towards the feather's tip, and the others.
pub(super) fn add(
    shape: &mut Shape,
    envelopes: &Geometry,
    side: f64,
    rows: [&BarbuleShape; 2],
    stride: usize,
) {
    for ribbon in &envelopes.ribbons {
        let nodes = envelopes.nodes_of(ribbon);
        for (row, part) in rows.into_iter().zip([Part::Distal, Part::Proximal]) {
            let to_tip = tip_side(side) as f32;
            let x = if part == Part::Distal { to_tip } else { -to_tip };
            add_half(shape, ribbon, nodes, (row, part, x), stride);
        }
    }
}

/// How many triangles that are.
pub(super) fn triangles(envelopes: &Geometry, stride: usize) -> usize {
    envelopes.ribbons.iter().map(|ribbon| 2 * strip_triangles(ribbon.count as usize, stride)).sum()
}

/// Adds the half of a barb's envelope that holds one row of its barbules; `x`: the edge to which it reaches.
fn add_half(
    shape: &mut Shape,
    ribbon: &Ribbon,
    nodes: &[RibbonNode],
    (row, part, x): (&BarbuleShape, Part, f32),
    stride: usize,
) {
    let first = shape.vertices.len() as u32;
    // In the mean over a barbule's length, as its row bends from its base to its end.
    let angle = (0.5 * (row.base_angle + row.end_angle)) as f32;
    let spacing_mm = 1e-3 * row.spacing_um;
    let name = hash(ribbon.id, &[2, u64::from(part == Part::Proximal)]);
    let mut pairs = 0;
    for at in kept(nodes.len(), stride) {
        let [across, along, z] = frame(nodes, at);
        let node = &nodes[at];
        let barbule = along * angle.cos() + across * (x * angle.sin());
        let vertex = Vertex {
            swelling: row.swelling as f32,
            half_width_mm: (0.5e-3 * row.width_um) as f32,
            part: part.code(0),
            ..Vertex::at(node.point, z, barbule, name)
        };
        let count = (f64::from(node.arc) / spacing_mm).max(0.0) as f32;
        // The barb's middle and the edge, from −x to +x.
        let ends = if x > 0.0 { [0.0, x] } else { [x, 0.0] };
        for end in ends {
            let position_mm = (node.point + node.across * end).into();
            shape.push(Vertex { position_mm, place: [count, end], ..vertex });
        }
        pairs += 1;
    }
    strip(shape, first, pairs);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Naming;
    use barbule_appearance::scene::feather::{Feather, Level, VaneDisc};
    use glam::Vec3;

    #[test]
    fn barbules_lean_outwards_to_either_side_of_every_barb() {
        let feather = Feather::of_type("contour").unwrap();
        let window = VaneDisc { along_mm: 0.6 * feather.shaft.length_mm, radius_mm: Some(2.0) };
        let grown = feather.grow(window, Level::Envelopes, None, 1, 7).unwrap();
        for (envelopes, side) in grown.envelopes.iter().zip([-1.0, 1.0]) {
            assert!(!envelopes.ribbons.is_empty());
            let mut shape = Shape::new(Naming::Ribbon);
            add(&mut shape, envelopes, side, [&feather.distal, &feather.proximal], 4);
            shape.check().unwrap();
            assert_eq!(shape.triangles.len(), triangles(envelopes, 4));
            for corners in &shape.triangles {
                let [a, b, c] = corners.map(|corner| shape.vertices[corner as usize]);
                let [p, q, r] = [a, b, c].map(|v| Vec3::from(v.position_mm));
                // Upper sides face the viewer.
                assert!((q - p).cross(r - p).dot(a.normal.into()) > -1e-6);
            }
            // From the barb's middle to the edge is where its barbules lead.
            for pair in shape.vertices.chunks_exact(2) {
                let [middle, edge] =
                    if pair[0].place[1] == 0.0 { [pair[0], pair[1]] } else { [pair[1], pair[0]] };
                let outwards = Vec3::from(edge.position_mm) - Vec3::from(middle.position_mm);
                assert!(middle.place[1] == 0.0 && outwards.dot(edge.tangent.into()) > 0.0);
            }
        }
    }
}
