//! Meshes whose sides count, since feathers or barbules grow on one of them: which way their faces look.

use super::objects::{ObjectDescription, ObjectShape};
use super::surfaces::{NamedSurface, Surfaces, SurfacesByPlace};
use super::{SceneDescription, Slot};
use crate::scene::faces::Facing;
use crate::scene::geometry::Mesh;

/// What is said about a mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// A sentence that begins with the mesh's file.
    pub sentence: String,
    /// Whether the mesh is probably meant otherwise than it is taken.
    pub is_doubt: bool,
}

impl SceneDescription {
    /// What is to be said about the meshes, as far as they are read, that bear a coat or barbules: that their faces were turned, and on
    /// which side of an open one things grow.
    #[must_use]
    pub fn remarks_on_sides(&self) -> Vec<Remark> {
        self.objects.iter().filter_map(|object| object.remark(&self.surfaces)).collect()
    }
}

impl ObjectDescription {
    /// Whether it is a mesh that wears barbules, which have an upper and a lower side.
    pub(super) fn is_clad_mesh(&self, surfaces: &Surfaces) -> bool {
        let clad = |name: &str| matches!(surfaces.0.get(name), Some(NamedSurface::Barbule(_)));
        let named = self.surface.as_deref().unwrap_or_default();
        matches!(self.shape, ObjectShape::Mesh(_))
            && match surfaces.0.get(named) {
                Some(NamedSurface::Map(SurfacesByPlace { surfaces, .. })) => {
                    surfaces.iter().any(|name| clad(name))
                }
                _ => clad(named),
            }
    }

    fn remark(&self, surfaces: &Surfaces) -> Option<Remark> {
        let said = |slot: &Slot<Mesh>, sentence: &str, is_doubt: bool| {
            Some(Remark { sentence: format!("{}: {sentence}", slot.name), is_doubt })
        };
        let facing = |slot: &Slot<Mesh>| slot.get().map(Facing::of_mesh);
        match &self.shape {
            ObjectShape::Coat(of) => {
                let slot = of.coat.mesh.as_ref()?;
                let other_side = of.coat.other_side;
                let Facing { is_open, is_hollow, .. } =
                    facing(slot).filter(|facing| facing.is_open || other_side || facing.is_inside_out())?;
                match (is_open, other_side, is_hollow) {
                    (false, false, _) => said(
                        slot,
                        "its faces look inwards; they are turned, and feathers grow outwards",
                        false,
                    ),
                    (false, true, _) => said(
                        slot,
                        "is closed, so that feathers grow outwards and coat.other_side has no effect",
                        true,
                    ),
                    (true, false, true) => said(
                        slot,
                        "is open, and feathers grow out of its hollow side, to which its faces look; coat.other_side = true takes the other one",
                        true,
                    ),
                    (true, ..) => said(
                        slot,
                        "is open, so that it has no inside: feathers grow on the side to which its faces look, or on the other one by coat.other_side",
                        false,
                    ),
                }
            }
            ObjectShape::Mesh(slot) if self.is_clad_mesh(surfaces) => {
                let facing = facing(slot)?;
                match (facing.is_inside_out(), facing.is_hollow) {
                    (_, true) => said(
                        slot,
                        "is open, and its barbules show their upper sides on the hollow side, to which its faces look; turn the faces round if that is not meant",
                        true,
                    ),
                    (true, _) => said(
                        slot,
                        "its faces look inwards; they are turned, and barbules show their upper sides outside",
                        false,
                    ),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// A tetrahedron with a corner at the origin; without its last face, that opposite to the origin, it is a bowl.
    fn mesh(faces: usize, looks_inwards: bool) -> Mesh {
        let positions = vec![Vec3::ZERO, Vec3::X * 20.0, Vec3::Y * 20.0, Vec3::Z * 20.0];
        let mut triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        triangles.truncate(faces);
        if looks_inwards {
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        Mesh { positions, triangles, ..Mesh::default() }
    }

    fn remarks(text: &str, mesh: Mesh) -> Vec<(String, bool)> {
        let mut scene = SceneDescription::parse(text).unwrap();
        for object in &mut scene.objects {
            match &mut object.shape {
                ObjectShape::Mesh(slot) => slot.fill(mesh.clone(), "hash".into()),
                ObjectShape::Coat(of) => {
                    of.coat.mesh.iter_mut().for_each(|slot| slot.fill(mesh.clone(), "hash".into()));
                }
                _ => {}
            }
        }
        scene.remarks_on_sides().into_iter().map(|remark| (remark.sentence, remark.is_doubt)).collect()
    }

    #[test]
    fn sides_of_coated_and_clad_meshes_are_told_and_open_ones_that_look_inwards_doubted() {
        let coat = "preset = 'starling'\n[coat]\nmesh = 'b.ply'\ncount = 5\n";
        let turned = format!("{coat}other_side = true\n");
        let clad = "preset = 'starling'\nshows_feather = false\n[[objects]]\nmesh = 'b.ply'\nsurface = 'plates'\n\
                    [surfaces.plates]\ntype = 'barbule'\nmaterial = 'starling'\n";
        let plain = clad.replace("type = 'barbule'\nmaterial = 'starling'", "type = 'diffuse'");
        for (text, faces, inwards, expected) in [
            (coat, 4, false, None),
            (coat, 4, true, Some(("faces look inwards; they are turned, and feathers", false))),
            (coat, 3, false, Some(("is open, so that it has no inside", false))),
            (coat, 3, true, Some(("its hollow side, to which its faces look; coat.other_side = true", true))),
            (&turned, 3, true, Some(("is open, so that it has no inside", false))),
            (&turned, 4, true, Some(("coat.other_side has no effect", true))),
            (clad, 4, false, None),
            (clad, 4, true, Some(("barbules show their upper sides outside", false))),
            (clad, 3, false, None),
            (clad, 3, true, Some(("show their upper sides on the hollow side", true))),
            (&plain, 4, true, None),
        ] {
            let found = remarks(text, mesh(faces, inwards));
            match (&found[..], expected) {
                ([], None) => {}
                ([(sentence, is_doubt)], Some((part, doubt))) => {
                    assert!(sentence.starts_with("b.ply: ") && sentence.contains(part), "{sentence}");
                    assert_eq!(*is_doubt, doubt, "{sentence}");
                }
                _ => panic!("{text} {faces} {inwards}: {found:?}"),
            }
        }
    }
}
