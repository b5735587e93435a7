//! `form`: a body that the program makes of ellipsoids and tapering tubes.

use glam::DVec3;

use super::objects::Placement;
use crate::fields::{Several, path_of, within};
use crate::progress::Progress;
use crate::scene::form::{Form, Part};
use crate::scene::geometry::Mesh;
use crate::{Error, Result, record};

/// Most parts, and most points of a path.
const MOST_PARTS: usize = 200;
const MOST_POINTS: usize = 100;

record! {
    /// A body of parts that melt into each other.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FormDescription {
        /// The parts, each joined to those before it.
        parts: Vec<PartDescription> = "parts", Several { least: 1, most: MOST_PARTS, of: () };
        /// How far parts melt into each other that do not say so themselves.
        blend_mm: f64 = "blend_mm", within(0, 1000), or 0.0;
        /// Distance of the points that make its surface.
        resolution_mm: f64 = "resolution_mm", within(0.001, 1000), or 1.0;
        @agree FormDescription::agree;
    }
}

record! {
    /// An ellipsoid or a tube.
    #[derive(Debug, Clone, PartialEq)]
    pub struct PartDescription {
        /// Half axes of an ellipsoid.
        ellipsoid_mm: Option<[f64; 3]> = "ellipsoid_mm", within(1e-3, 1e4);
        /// In place of that, points of a tube's middle, which is smooth through them.
        path_mm: Vec<[f64; 3]> = "path_mm", Several { least: 2, most: MOST_POINTS, of: within(-1e5, 1e5) }, or Vec::new();
        /// Radius of the tube at each of them; one alone holds everywhere.
        radii_mm: Vec<f64> = "radii_mm", Several { least: 1, most: MOST_POINTS, of: within(1e-3, 1e4) }, or Vec::new();
        /// Factors to its lengths along x, y, z, before it is turned.
        stretch: [f64; 3] = "stretch", within(0.01, 100), or [1.0; 3];
        /// Turns about x, y, z, in this order.
        rotate_deg: [f64; 3] = "rotate_deg", within(-1e6, 1e6), or [0.0; 3];
        /// The move.
        translate_mm: [f64; 3] = "translate_mm", within(-1e6, 1e6), or [0.0; 3];
        /// How far it melts into the parts before it.
        blend_mm: Option<f64> = "blend_mm", within(0, 1000);
        /// Whether it stands on both sides of the plane x = 0.
        mirror: bool = "mirror", (), or false;
        /// Whether it is taken away from the parts before it.
        cut: bool = "cut", (), or false;
        @agree PartDescription::agree;
    }
}

impl PartDescription {
    fn agree(&self, place: &str) -> Result<()> {
        let (points, radii) = (self.path_mm.len(), self.radii_mm.len());
        match (&self.ellipsoid_mm, points) {
            (None, 0) => Err(Error::input(format!("{place} has no shape; give ellipsoid_mm or path_mm"))),
            (Some(_), 0) if radii == 0 => Ok(()),
            (Some(_), _) => Err(Error::input(format!(
                "{place}.ellipsoid_mm and {} are both given; leave one out",
                path_of(place, if points == 0 { "radii_mm" } else { "path_mm" })
            ))),
            (None, _) if radii == 1 || radii == points => Ok(()),
            (None, _) => Err(Error::input(format!(
                "{} has {radii} numbers for {points} points; give one, or one for each point",
                path_of(place, "radii_mm")
            ))),
        }
    }

    fn part(&self, usual_blend_mm: f64) -> Part {
        let points: Vec<DVec3> = self.path_mm.iter().copied().map(DVec3::from).collect();
        let stretch = DVec3::from(self.stretch);
        let (nodes, stretch) = match self.ellipsoid_mm {
            Some(radii) => (vec![(DVec3::ZERO, 1.0)], stretch * DVec3::from(radii)),
            None => {
                let radius = |i: usize| self.radii_mm[i.min(self.radii_mm.len() - 1)];
                let radii: Vec<f64> = (0..points.len()).map(radius).collect();
                (Part::path(&points, &radii), stretch)
            }
        };
        let placement =
            Placement { scale: 1.0, rotate_deg: self.rotate_deg, translate_mm: self.translate_mm };
        let place = placement.place(0);
        Part {
            nodes,
            stretch,
            turn: place.turn,
            shift: place.shift,
            blend_mm: self.blend_mm.unwrap_or(usual_blend_mm),
            is_mirrored: self.mirror,
            is_cut: self.cut,
        }
    }
}

impl FormDescription {
    fn agree(&self, place: &str) -> Result<()> {
        if self.parts.first().is_some_and(|part| part.cut) {
            return Err(Error::input(format!(
                "{}.cut is true, but the first part has nothing before it; begin with one that is not cut",
                path_of(place, "parts[0]")
            )));
        }
        self.form().check().map_err(|error| error.at(place))
    }

    /// The body as signed distances.
    #[must_use]
    pub fn form(&self) -> Form {
        let parts = self.parts.iter().map(|part| part.part(self.blend_mm)).collect();
        Form { parts, resolution_mm: self.resolution_mm }
    }

    /// Its surface.
    ///
    /// # Errors
    /// Nothing of it is left, or a stop by `progress`.
    pub fn mesh(&self, progress: &dyn Progress) -> Result<Mesh> {
        self.form().mesh(progress)
    }

    /// Vertices and triangles at most, and bytes of the grid that they are found on.
    pub(super) fn size(&self) -> ([f64; 2], f64) {
        let form = self.form();
        let triangles = form.triangles();
        ([0.5 * triangles, triangles], 8.0 * form.cells().iter().product::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::description::{ObjectShape, SceneDescription};
    use crate::{Result, progress::Unobserved};

    fn scene(form: &str) -> Result<SceneDescription> {
        SceneDescription::parse(&format!(
            "preset = 'starling'\nshows_feather = false\n[surfaces.white]\ntype = 'diffuse'\n\
             [[objects]]\nsurface = 'white'\nform = {form}"
        ))
    }

    /// An ellipsoid and a tube become a closed mesh in the scene's lengths, and come back from their text.
    #[test]
    fn forms_are_objects() {
        let text = "{resolution_mm = 0.5, blend_mm = 2, parts = [{ellipsoid_mm = [4, 6, 4], translate_mm = [0, 2, 0]}, \
                    {path_mm = [[0, 6, 0], [0, 12, 3]], radii_mm = [2, 1], blend_mm = 3}, {ellipsoid_mm = [1, 1, 1], \
                    translate_mm = [3, 3, 2], mirror = true, cut = true}]}";
        let scene = scene(text).unwrap();
        assert_eq!(SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(), scene);
        let ObjectShape::Form(form) = &scene.objects[0].shape else { panic!() };
        let mesh = form.mesh(&Unobserved).unwrap();
        let highest = mesh.positions.iter().map(|p| p.y).fold(f32::MIN, f32::max);
        assert!((highest - 13.0).abs() < 0.05, "{highest}");
        let ([vertices, triangles], _) = form.size();
        assert!(vertices > mesh.positions.len() as f64 && triangles > mesh.triangles.len() as f64);
        assert_eq!(scene.objects[0].geometry(0).unwrap().meshes[0].triangles.len(), mesh.triangles.len());
    }

    #[test]
    fn bad_forms_are_refused_by_key() {
        let message = |form: &str| scene(form).unwrap_err().to_string();
        assert!(message("{parts = []}").contains("objects[0].form.parts: give 1 to 200"));
        assert!(
            message("{parts = [{}]}").contains("form.parts[0] has no shape; give ellipsoid_mm or path_mm")
        );
        assert!(
            message("{parts = [{ellipsoid_mm = [1, 1, 1], path_mm = [[0, 0, 0], [1, 0, 0]]}]}")
                .contains("parts[0].ellipsoid_mm and objects[0].form.parts[0].path_mm are both given")
        );
        assert!(
            message("{parts = [{path_mm = [[0, 0, 0], [1, 0, 0], [2, 0, 0]], radii_mm = [1, 2]}]}")
                .contains("radii_mm has 2 numbers for 3 points")
        );
        assert!(message("{parts = [{ellipsoid_mm = [1, 1, 1], cut = true}]}").contains("nothing before it"));
        assert!(
            message("{resolution_mm = 0.001, parts = [{ellipsoid_mm = [9, 9, 9]}]}")
                .contains("objects[0].form: resolution_mm of 0.001 makes a grid")
        );
        assert!(message("{parts = [{elipsoid_mm = [1, 1, 1]}]}").contains("did you mean 'ellipsoid_mm'"));
    }
}
