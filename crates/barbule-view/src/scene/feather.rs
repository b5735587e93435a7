//! A feather's own barbules, barbs and shaft, as finely as an adapter draws them.

use barbule_appearance::bsdf::Zones;
use barbule_appearance::scene::feather::{Feather, Grown, Level, VaneDisc};
use barbule_appearance::scene::geometry::Geometry;
use barbule_base::math::rng::hash;
use barbule_base::progress::Progress;
use barbule_base::{Error, Result};

use super::ribbon::{add_fibres, add_meshes, add_ribbons, meshed, strips_of};
use super::{MOST_TRIANGLES, Naming, Part, Shape, envelope};

/// A ribbon's nodes are thinned in these steps, and at last all but its ends.
const STRIDES: [usize; 4] = [1, 2, 3, usize::MAX];

/// What of a feather is shown.
#[derive(Debug, Clone, Copy)]
pub struct FeatherRequest<'a> {
    /// The feather.
    pub feather: &'a Feather,
    /// The part of it that is grown.
    pub window: VaneDisc,
    /// Its zones, where it has some; barbs that stand for their barbules show none.
    pub zones: Option<&'a Zones>,
    /// The seed of pictures, by which the renderer names its barbules.
    pub seed: u64,
    /// Most triangles; at most [`MOST_TRIANGLES`].
    pub most_triangles: usize,
}

/// How finely a feather is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeatherDetail {
    /// Every barbule, of every so many-th of its nodes. Their names are the renderer's.
    Barbules {
        /// How many nodes are gone through from one to the next; 1: all are kept.
        stride: usize,
    },
    /// Barbs, in which barbules are counted but not apart.
    Barbs {
        /// As above.
        stride: usize,
    },
}

/// The part of a feather in its window, whose middle is the origin, and how finely it is made: as the triangles allow.
///
/// # Errors
/// A feather or window out of range, one that even coarsely has more triangles, or a stop by `progress`.
pub fn feather(request: &FeatherRequest<'_>, progress: &dyn Progress) -> Result<(Shape, FeatherDetail)> {
    let FeatherRequest { feather, window, zones, seed, .. } = *request;
    let most = request.most_triangles.min(MOST_TRIANGLES);
    // As the renderer names the first feather of a scene.
    let names = (seed, hash(seed, &[1]));
    // Two triangles are the least of a barbule.
    if 2.0 * feather.barbules_in(window) <= most as f64 {
        let grown = feather.grow_watched(window, Level::Barbules, zones, names, progress)?;
        if let Some(made) = barbules(&grown, most) {
            return Ok(made);
        }
    }
    let grown = feather.grow_watched(window, Level::Envelopes, None, names, progress)?;
    barbs(feather, &grown, most).ok_or_else(|| {
        Error::input(format!(
            "the part of the feather that is shown has over {most} triangles, however coarsely; show a smaller part of it"
        ))
    })
}

/// Barbules one by one, if they fit.
fn barbules(grown: &Grown, most: usize) -> Option<(Shape, FeatherDetail)> {
    let fixed = meshed(&grown.shaft)
        + meshed(&grown.rami)
        + grown.zones.iter().map(|z| meshed(&z.rami)).sum::<usize>();
    let rows = || rows_of(grown).map(|(geometry, _)| geometry);
    let stride = STRIDES
        .into_iter()
        .find(|&stride| fixed + rows().map(|row| strips_of(row, stride)).sum::<usize>() <= most)?;
    let mut shape = Shape::new(Naming::Ribbon);
    add_meshes(&mut shape, &grown.shaft, Part::Shaft.code(0));
    add_meshes(&mut shape, &grown.rami, Part::Ramus.code(0));
    for (zone, parts) in (1..).zip(&grown.zones) {
        add_meshes(&mut shape, &parts.rami, Part::Ramus.code(zone));
    }
    for (geometry, part) in rows_of(grown) {
        add_ribbons(&mut shape, geometry, part, stride);
        add_fibres(&mut shape, geometry, part, stride);
    }
    Some((shape, FeatherDetail::Barbules { stride }))
}

/// All rows of barbules with their parts' codes.
fn rows_of(grown: &Grown) -> impl Iterator<Item = (&Geometry, u32)> {
    let [distal, proximal] = &grown.barbules;
    let of_zones = (1..).zip(&grown.zones).flat_map(|(zone, parts)| {
        let [distal, proximal] = &parts.barbules;
        [(distal, Part::Distal.code(zone)), (proximal, Part::Proximal.code(zone))]
    });
    let own = [
        (distal, Part::Distal.code(0)),
        (proximal, Part::Proximal.code(0)),
        (&grown.pale, Part::Pale.code(0)),
        (&grown.downy, Part::Down.code(0)),
    ];
    own.into_iter().chain(of_zones)
}

/// Barbs alone, if they fit.
fn barbs(feather: &Feather, grown: &Grown, most: usize) -> Option<(Shape, FeatherDetail)> {
    let downy = || grown.downy_envelopes.iter();
    let fixed = meshed(&grown.shaft);
    let count = |stride| {
        fixed
            + grown.envelopes.iter().map(|sides| envelope::triangles(sides, stride)).sum::<usize>()
            + downy().map(|sides| strips_of(sides, stride)).sum::<usize>()
    };
    // A barb has dozens of nodes.
    let stride = [1, 2, 4, 8, 16, usize::MAX].into_iter().find(|&stride| count(stride) <= most)?;
    let mut shape = Shape::new(Naming::Ribbon);
    add_meshes(&mut shape, &grown.shaft, Part::Shaft.code(0));
    for (sides, side) in grown.envelopes.iter().zip([-1.0, 1.0]) {
        envelope::add(&mut shape, sides, side, [&feather.distal, &feather.proximal], stride);
    }
    for sides in downy() {
        add_ribbons(&mut shape, sides, Part::Down.code(0), stride);
    }
    Some((shape, FeatherDetail::Barbs { stride }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::names::{ribbon_instance, words_of};
    use barbule_base::progress::{Shared, Unobserved};
    use std::collections::BTreeSet;

    fn request(feather: &Feather, radius_mm: Option<f64>) -> FeatherRequest<'_> {
        let window = VaneDisc { along_mm: 0.6 * feather.shaft.length_mm, radius_mm };
        FeatherRequest { feather, window, zones: None, seed: 1, most_triangles: MOST_TRIANGLES }
    }

    /// Every barbule that the renderer grows is there under its name, each cell with the name of its individual.
    #[test]
    fn barbules_have_the_renderers_names() {
        let feather = Feather::of_type("contour").unwrap();
        let request = request(&feather, Some(1.0));
        let (shape, detail) = super::feather(&request, &Unobserved).unwrap();
        shape.check().unwrap();
        assert_eq!(detail, FeatherDetail::Barbules { stride: 1 });
        let grown = feather.grow(request.window, Level::Barbules, None, 1, hash(1, &[1])).unwrap();
        let names = |part: Part| -> BTreeSet<[u32; 2]> {
            let of_part = shape.vertices.iter().filter(|vertex| vertex.part == part.code(0));
            of_part.map(|vertex| vertex.name).collect()
        };
        for (part, row) in [Part::Distal, Part::Proximal].into_iter().zip(&grown.barbules) {
            assert!(!row.ribbons.is_empty());
            assert_eq!(names(part), row.ribbons.iter().map(|ribbon| words_of(ribbon.id)).collect());
        }
        // A point half-way along a barbule lies in the cell that a ray would find there.
        let row = &grown.barbules[0];
        let ribbon = &row.ribbons[row.ribbons.len() / 2];
        let nodes = row.nodes_of(ribbon);
        let own: Vec<_> = shape.vertices.iter().filter(|vertex| vertex.name == words_of(ribbon.id)).collect();
        assert_eq!(own.len(), 2 * nodes.len());
        let (node, vertex) = (&nodes[3], own[6]);
        let place = f64::from(node.arc) / f64::from(ribbon.cell) + f64::from(ribbon.phase);
        assert!((f64::from(vertex.place[0]) - place).abs() < 1e-5);
        assert_eq!(ribbon_instance(ribbon.id, f64::from(vertex.place[0])), ribbon_instance(ribbon.id, place));
    }

    #[test]
    fn larger_parts_are_drawn_more_coarsely_and_never_with_too_many_triangles() {
        let feather = Feather::of_type("contour").unwrap();
        let mut details = Vec::new();
        for (radius, most) in
            [(Some(1.0), 300_000), (Some(1.0), 100_000), (Some(1.0), 30_000), (None, 300_000)]
        {
            let request = FeatherRequest { most_triangles: most, ..request(&feather, radius) };
            let (shape, detail) = super::feather(&request, &Unobserved).unwrap();
            shape.check().unwrap();
            assert!(shape.triangles.len() <= most, "{} of {most}", shape.triangles.len());
            details.push(detail);
        }
        assert_eq!(details[0], FeatherDetail::Barbules { stride: 1 });
        assert!(matches!(details[3], FeatherDetail::Barbs { .. }), "{details:?}");
        let few = FeatherRequest { most_triangles: 10, ..request(&feather, Some(1.0)) };
        let refused = super::feather(&few, &Unobserved).unwrap_err().to_string();
        assert!(
            refused.contains("over 10 triangles") && refused.contains("show a smaller part"),
            "{refused}"
        );
    }

    #[test]
    fn whoever_watches_stops_the_growing() {
        let feather = Feather::of_type("contour").unwrap();
        let progress = Shared::default();
        progress.cancel();
        assert!(super::feather(&request(&feather, None), &progress).unwrap_err().is_interrupted());
    }
}
