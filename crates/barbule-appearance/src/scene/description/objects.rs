//! `[[objects]]`: what stands in a scene.

use glam::{DMat3, DVec3};

use super::barbules::Under;
use super::coat::{CoatDescription, CoatObject};
use super::detail::Detail;
use super::dress::{Dress, FeatherObject, Zone};
use super::form::FormDescription;
use super::ground::GROUND;
use super::row::{RowDescription, RowFeather, RowObject};
use super::shapes::{MOST_SEGMENTS, grow, rectangle, sphere, upwards};
use super::slot::Slot;
use super::surfaces::Surfaces;
use crate::brdf::Reciprocity;
use crate::bsdf::Texture;
use crate::fields::{Fields, Key, Map, Record, Several, Text, Value, up_to, within};
use crate::identity::Hasher;
use crate::math::rng::hash;
use crate::progress::Unobserved;
use crate::scene::feather::{Feather, VaneDisc};
use crate::scene::geometry::{Geometry, Mesh, Place};
use crate::scene::snake::Snake;
use crate::scene::spline::{Basis, ControlCurve};
use crate::{Error, Result, record};

/// Most objects, and most instances of one.
pub(super) const MOST_OBJECTS: usize = 1000;
const MOST_INSTANCES: usize = 100_000;

/// Most points of a snake's line.
const MOST_POINTS: usize = 1000;

/// Most zones of a feather: as many as an 8-bit grey tells apart, but for the feather's own dress.
pub(super) const MOST_ZONES: usize = 255;

record! {
    /// Something that stands in a scene, once or several times.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ObjectDescription {
        /// What mattes call it; its surface's name where nothing is said.
        name: Option<String> = "name", Text("a name of your own");
        /// The table [surfaces.NAME] of a shape that is no feather.
        surface: Option<String> = "surface", Text("the name of a table [surfaces.NAME]");
        /// Places at which the same shape stands, instead of its one place.
        instances: Vec<Placement> = "instances", Several { least: 1, most: MOST_INSTANCES, of: () }, or Vec::new();
        @flat {
            /// Its shape.
            shape: ObjectShape;
            /// Where it stands.
            place: Placement;
        }
        @agree ObjectDescription::agree;
    }
}

record! {
    /// Where an object stands: scaled, then turned about x, y and z in this order, then moved.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Placement {
        /// Factor to all lengths.
        scale: f64 = "scale", within(1e-6, 1e6), or 1.0;
        /// Turns about x, y, z, counter-clockwise seen from the axis' tip.
        rotate_deg: [f64; 3] = "rotate_deg", within(-1e6, 1e6), or [0.0; 3];
        /// The move.
        translate_mm: [f64; 3] = "translate_mm", within(-1e6, 1e6), or [0.0; 3];
    }
}

/// The shape of an object about its own origin.
#[derive(Debug, Clone, PartialEq)]
pub enum ObjectShape {
    /// A sphere.
    Sphere {
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// A rectangle in the plane z = 0 that faces +z.
    Rectangle {
        /// Along x and y, mm.
        size_mm: [f64; 2],
    },
    /// The scales of a snake's body.
    Snake(SnakeShape),
    /// A body that the program makes.
    Form(Box<FormDescription>),
    /// A mesh from a file, in mm.
    Mesh(Slot<Mesh>),
    /// Round curves from a file, in mm.
    Curves {
        /// The file.
        file: Slot<Vec<ControlCurve>>,
        /// How its control points make curves.
        basis: Basis,
    },
    /// A feather.
    Feather(Box<FeatherObject>),
    /// Many feathers on a body.
    Coat(Box<CoatObject>),
    /// Feathers side by side.
    Row(Box<RowObject>),
}

record! {
    /// The scales of a snake's body.
    #[derive(Debug, Clone, PartialEq)]
    pub struct SnakeShape {
        /// Points that guide its middle line, from the neck to the tail.
        path_mm: Vec<[f64; 3]> = "path_mm", Several { least: 2, most: MOST_POINTS, of: within(-1e5, 1e5) };
        /// Radius of the middle.
        radius_mm: f64 = "radius_mm", within(0.1, 1000);
        /// Rows of dorsal scales, odd.
        rows: usize = "rows", within(5, 61), or 15;
        /// How strongly scales are keeled.
        keel: f64 = "keel", within(0, 1), or 0.0;
        @agree SnakeShape::agree;
    }
}

record! {
    /// The keys of shapes as files have them: one of the first nine says which shape it is.
    #[derive(Debug, Clone, PartialEq)]
    struct ShapeKeys {
        /// A sphere of this radius.
        sphere_mm: Option<f64> = "sphere_mm", within(1e-3, 1e5);
        /// A rectangle in the plane z = 0 that faces +z: its sides along x and y.
        rectangle_mm: Option<[f64; 2]> = "rectangle_mm", within(1e-3, 1e5);
        /// The scales of a snake's body.
        snake: Option<SnakeShape> = "snake", ();
        /// A body of ellipsoids and tubes that melt into each other.
        form: Option<FormDescription> = "form", ();
        /// A mesh, in mm.
        mesh: Option<Slot<Mesh>> = "mesh", Text("the name of a .ply, .obj, .gltf or .glb");
        /// Round curves, in mm.
        curves: Option<Slot<Vec<ControlCurve>>> = "curves", Text("the name of a file of curves");
        /// A feather: its sizes, or the name of a type.
        feather: Option<Feather> = "feather", ();
        /// Many feathers on a body, like `feather`.
        coat: Option<CoatDescription> = "coat", ();
        /// Feathers side by side, like `feather`: a tail, or rows of a wing.
        row: Option<RowDescription> = "row", ();
        /// How control points make curves; a B-spline where nothing is said.
        basis: Option<Basis> = "basis", ();
        /// The part of the feather that is grown; all of it where nothing is said.
        window: Option<VaneDisc> = "window", ();
        /// How finely a feather is made.
        detail: Detail = "detail", (), or Detail::default();
        /// What a feather's barbules are made of on both sides of its barbs, where its dress does not say.
        material: Option<String> = "material", Text("a species, structure or .barbule file");
        /// What the lower sides of a feather's barbules are made of, where its dress does not say; `default` where that does not either.
        under: Option<Under> = "under", ();
        /// How they are made to look the same when light and eye change places, where its dress does not say; `steeper` where that does not either.
        reciprocity: Option<Reciprocity> = "reciprocity", ();
        /// What the parts of a feather are made of.
        dress: Option<Dress> = "dress", ();
        /// Places of the vane with a dress of their own; the last one that holds a place is its zone.
        zones: Vec<Zone> = "zones", up_to(MOST_ZONES), or Vec::new();
        /// A grey picture over the vane, its left edge at the left and its tip above: pixels of value i (of 255) are the i-th zone.
        zone_map: Option<Slot<Texture>> = "zone_map", Text("a grey .png");
        /// A picture of the vane, its left edge at the left and its tip above, that its fibres take their colours from.
        albedo: Option<Slot<Texture>> = "albedo", Text("the name of a .png, .exr or .hdr");
    }
}

/// The keys of which one says what shape an object is.
const SHAPES: [&str; 9] =
    ["sphere_mm", "rectangle_mm", "snake", "form", "mesh", "curves", "feather", "coat", "row"];

/// Keys of feathers, coats and rows, of feathers and rows, and of feathers alone, with who has them.
const OF_PLUMAGE: [(&str, &[&str], &str); 3] = [
    ("feather, coat or row", &["feather", "coat", "row"], "detail material under reciprocity dress"),
    ("feather or row", &["feather", "row"], "zones zone_map albedo"),
    ("feather", &["feather"], "window"),
];

impl ObjectShape {
    fn keys_of(&self) -> ShapeKeys {
        let none = ShapeKeys {
            sphere_mm: None,
            rectangle_mm: None,
            snake: None,
            form: None,
            mesh: None,
            curves: None,
            feather: None,
            coat: None,
            row: None,
            basis: None,
            window: None,
            detail: Detail::default(),
            material: None,
            under: None,
            reciprocity: None,
            dress: None,
            zones: Vec::new(),
            zone_map: None,
            albedo: None,
        };
        match self {
            Self::Sphere { radius_mm } => ShapeKeys { sphere_mm: Some(*radius_mm), ..none },
            Self::Rectangle { size_mm } => ShapeKeys { rectangle_mm: Some(*size_mm), ..none },
            Self::Snake(snake) => ShapeKeys { snake: Some(snake.clone()), ..none },
            Self::Form(form) => ShapeKeys { form: Some((**form).clone()), ..none },
            Self::Mesh(file) => ShapeKeys { mesh: Some(file.clone()), ..none },
            Self::Curves { file, basis } => {
                ShapeKeys { curves: Some(file.clone()), basis: Some(*basis), ..none }
            }
            Self::Feather(of) => {
                let FeatherObject { feather, window, detail, dress, zones, zone_map, albedo } =
                    (**of).clone();
                let dress = Some(dress);
                ShapeKeys {
                    feather: Some(feather),
                    window: Some(window),
                    detail,
                    dress,
                    zones,
                    zone_map,
                    albedo,
                    ..none
                }
            }
            Self::Coat(of) => {
                let CoatObject { coat, feather, detail, dress } = (**of).clone();
                ShapeKeys { coat: Some(coat), feather: Some(feather), detail, dress: Some(dress), ..none }
            }
            Self::Row(of) => {
                let RowObject { row, first, detail } = (**of).clone();
                let RowFeather { feather, dress, zones, zone_map, albedo } = first;
                let (row, feather, dress) = (Some(row), Some(feather), Some(dress));
                ShapeKeys { row, feather, detail, dress, zones, zone_map, albedo, ..none }
            }
        }
    }

    /// The one shape that keys say.
    fn of_keys(keys: ShapeKeys, fields: &Fields<'_>) -> Result<Self> {
        let given: Vec<&str> = SHAPES.into_iter().filter(|key| fields.get(key).is_some()).collect();
        // A coat or row may say its feather beside it.
        let beside: Vec<&str> = given.iter().copied().filter(|key| *key != "feather").collect();
        let shape = beside.first().or(given.first()).copied().unwrap_or_default();
        for (who, shapes, keys) in OF_PLUMAGE.into_iter().filter(|_| beside.len() < 2) {
            let is_given = |key: &&str| fields.get(key).is_some();
            if let (false, Some(key)) = (shapes.contains(&shape), keys.split(' ').find(is_given)) {
                return Err(Error::input(format!(
                    "{} is given, but the object is no {who}; leave it out",
                    fields.path(key)
                )));
            }
        }
        if keys.basis.is_some() && keys.curves.is_none() {
            return Err(Error::input(format!("{} is given, but there are no curves", fields.path("basis"))));
        }
        let dress = |dress: Option<Dress>| dress.ok_or_else(|| Dress::missing(&fields.path("material")));
        match (&given[..], keys) {
            (["sphere_mm"], ShapeKeys { sphere_mm: Some(radius_mm), .. }) => Ok(Self::Sphere { radius_mm }),
            (["rectangle_mm"], ShapeKeys { rectangle_mm: Some(size_mm), .. }) => {
                Ok(Self::Rectangle { size_mm })
            }
            (["snake"], ShapeKeys { snake: Some(snake), .. }) => Ok(Self::Snake(snake)),
            (["form"], ShapeKeys { form: Some(form), .. }) => Ok(Self::Form(Box::new(form))),
            (["mesh"], ShapeKeys { mesh: Some(file), .. }) => Ok(Self::Mesh(file)),
            (["curves"], ShapeKeys { curves: Some(file), basis, .. }) => {
                Ok(Self::Curves { file, basis: basis.unwrap_or(Basis::BSpline) })
            }
            (
                ["feather"],
                ShapeKeys {
                    feather: Some(feather), window, detail, dress: of, zones, zone_map, albedo, ..
                },
            ) => {
                let window = window.unwrap_or(VaneDisc::WHOLE);
                let dress = dress(of)?;
                let of = FeatherObject { feather, window, detail, dress, zones, zone_map, albedo };
                of.agree(fields.place())?;
                Ok(Self::Feather(Box::new(of)))
            }
            (
                ["feather", "coat"] | ["coat"],
                ShapeKeys { coat: Some(coat), feather, detail, dress: of, .. },
            ) => {
                let feather = feather.map_or_else(|| Feather::of_type("contour"), Ok)?;
                let of = CoatObject { coat, feather, detail, dress: dress(of)? };
                of.agree(fields.place())?;
                Ok(Self::Coat(Box::new(of)))
            }
            (
                ["feather", "row"] | ["row"],
                ShapeKeys { row: Some(row), feather, detail, dress: of, zones, zone_map, albedo, .. },
            ) => {
                let feather = feather.map_or_else(|| Feather::of_type("covert"), Ok)?;
                let first = RowFeather { feather, dress: dress(of)?, zones, zone_map, albedo };
                let of = RowObject { row, first, detail };
                of.agree(fields.place())?;
                Ok(Self::Row(Box::new(of)))
            }
            _ => Err(Error::input(format!(
                "{} has {} shapes; give one of {}",
                fields.place(),
                given.len(),
                SHAPES.join(", ")
            ))),
        }
    }
}

impl Record for ObjectShape {
    fn keys() -> Vec<Key> {
        ShapeKeys::keys()
    }

    fn read_fields(fields: &Fields<'_>) -> Result<Self> {
        Self::of_keys(ShapeKeys::read_fields(fields)?, fields)
    }

    fn check_given(fields: &Fields<'_>) -> Result<()> {
        ShapeKeys::check_given(fields)
    }

    fn write_into(&self, table: &mut Map<String, Value>) {
        self.keys_of().write_into(table);
        if !matches!(self, Self::Feather(_) | Self::Coat(_) | Self::Row(_)) {
            table.remove("detail");
        }
    }

    fn check(&self, place: &str) -> Result<()> {
        match self {
            Self::Coat(coat) => coat.agree(place)?,
            Self::Row(row) => row.agree(place)?,
            _ => {}
        }
        self.keys_of().check(place)
    }

    fn feed_fields(&self, to: &mut Hasher) {
        self.keys_of().feed_fields(to);
    }
}

impl SnakeShape {
    fn agree(&self, place: &str) -> Result<()> {
        if self.rows % 2 != 1 {
            return Err(Error::input(format!("{place}.rows is {}; give an odd number", self.rows)));
        }
        if self.snake().size()[1] > MOST_SEGMENTS {
            return Err(Error::input(format!(
                "{place} has too many scales for its length; give a greater radius_mm or fewer rows"
            )));
        }
        Ok(())
    }

    pub(super) fn snake(&self) -> Snake {
        let path_mm = self.path_mm.iter().copied().map(DVec3::from_array).collect();
        Snake { path_mm, radius_mm: self.radius_mm, rows: self.rows, keel: self.keel }
    }
}

impl ObjectDescription {
    /// Something that stands where it was made.
    #[must_use]
    pub fn here(name: &str, shape: ObjectShape) -> Self {
        let name = Some(name.to_owned());
        Self { name, surface: None, instances: Vec::new(), shape, place: Placement::HERE }
    }

    /// Whether it is the ground of a scene, which stands for its key `ground`.
    #[must_use]
    pub fn is_ground(&self) -> bool {
        matches!(self.shape, ObjectShape::Rectangle { .. }) && self.label() == GROUND
    }

    /// What mattes call it.
    #[must_use]
    pub fn label(&self) -> &str {
        let kind = match &self.shape {
            ObjectShape::Feather(_) => "feather",
            ObjectShape::Coat(_) => "coat",
            ObjectShape::Row(_) => "row",
            _ => "",
        };
        self.name.as_deref().or(self.surface.as_deref()).unwrap_or(kind)
    }

    /// Whether the top of a scene file may say it: its one feather or coat.
    pub(super) fn stands_at_top(&self) -> bool {
        let is_named = |name: &str| self.name.as_deref() == Some(name) && self.instances.is_empty();
        match &self.shape {
            ObjectShape::Feather(_) => is_named("feather") && self.place == Placement::HERE,
            ObjectShape::Coat(_) => is_named("coat"),
            _ => false,
        }
    }

    /// Whether it is a feather, a coat or a row, whose parts have surfaces of their own.
    #[must_use]
    pub fn is_plumage(&self) -> bool {
        matches!(self.shape, ObjectShape::Feather(_) | ObjectShape::Coat(_) | ObjectShape::Row(_))
    }

    /// Where it stands, once for each.
    #[must_use]
    pub fn placements(&self) -> &[Placement] {
        if self.instances.is_empty() { std::slice::from_ref(&self.place) } else { &self.instances }
    }

    fn agree(&self, place: &str) -> Result<()> {
        if !self.instances.is_empty() && self.place != Placement::HERE {
            return Err(Error::input(format!(
                "{place} has instances and a place of its own; give scale, rotate_deg and translate_mm in the instances"
            )));
        }
        let path = crate::fields::path_of(place, "surface");
        match (self.is_plumage(), &self.surface) {
            (true, Some(_)) => Err(Error::input(format!(
                "{path} is given, but the object is a feather, coat or row; give its dress"
            ))),
            (false, None) => {
                Err(Error::input(format!("{path} is missing; give the name of a table [surfaces.NAME]")))
            }
            _ => Ok(()),
        }
    }

    /// Refuses a surface that does not exist.
    pub(super) fn check_surface(&self, place: &str, surfaces: &Surfaces) -> Result<()> {
        match &self.surface {
            Some(name) => surfaces.named(&format!("{place}.surface"), name).map(|_| ()),
            None => Ok(()),
        }
    }

    /// The shape of what is no feather, and where it stands; `index`: its own among such objects.
    ///
    /// # Errors
    /// A mesh or curves that are not read; curves of too many segments; a feather or coat.
    pub fn geometry(&self, index: usize) -> Result<Geometry> {
        let identity = |instance: usize| hash(0x006f_626a, &[index as u64, instance as u64]);
        let places =
            self.placements().iter().enumerate().map(|(i, place)| place.place(identity(i))).collect();
        let made;
        let mesh = match &self.shape {
            ObjectShape::Sphere { radius_mm } => {
                made = sphere(*radius_mm);
                &made
            }
            ObjectShape::Rectangle { size_mm } => {
                made = rectangle(*size_mm);
                &made
            }
            ObjectShape::Snake(snake) => {
                let meshes = vec![Mesh { id: identity(0), ..snake.snake().mesh(identity(0)) }];
                return Ok(Geometry { meshes, places, ..Geometry::default() });
            }
            ObjectShape::Form(form) => {
                made = form.mesh(&Unobserved)?;
                &made
            }
            ObjectShape::Mesh(file) => file.value()?.as_ref(),
            ObjectShape::Curves { file, basis } => {
                let grown = grow(file.value()?, *basis, identity(0)).map_err(|error| error.at(&file.name))?;
                return Ok(Geometry { places, ..grown });
            }
            ObjectShape::Feather(_) | ObjectShape::Coat(_) | ObjectShape::Row(_) => {
                return Err(Error::input(format!("the object '{}' has more than one shape", self.label())));
            }
        };
        let mesh = Mesh { tangents: upwards(mesh), id: identity(0), ..mesh.clone() };
        Ok(Geometry { meshes: vec![mesh], places, ..Geometry::default() })
    }
}

impl Placement {
    /// Where a shape is made.
    pub const HERE: Self = Self { scale: 1.0, rotate_deg: [0.0; 3], translate_mm: [0.0; 3] };

    pub(super) fn place(&self, id: u64) -> Place {
        let [x, y, z] = self.rotate_deg.map(f64::to_radians);
        let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        Place { scale: self.scale, turn, shift: self.translate_mm.into(), id }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::fields::{FieldValue as _, up_to};

    fn objects(text: &str) -> Result<Vec<ObjectDescription>> {
        let surfaces = serde_json::json!({"white": {"type": "dielectric", "index": 1.5}});
        let table: Value = toml::from_str(text).unwrap();
        let surfaces = Surfaces::of_value(&surfaces, "surfaces", &()).unwrap();
        let objects = Vec::<ObjectDescription>::of_value(&table["objects"], "objects", &up_to(MOST_OBJECTS))?;
        objects
            .iter()
            .enumerate()
            .try_for_each(|(i, one)| one.check_surface(&format!("objects[{i}]"), &surfaces))?;
        Ok(objects)
    }

    #[test]
    fn instances_are_scaled_turned_and_moved_in_this_order() {
        let text = "[[objects]]\nrectangle_mm = [2, 4]\nsurface = 'white'\n\
                    instances = [{}, {scale = 3, rotate_deg = [90, 0, 90], translate_mm = [0, 0, 5]}]";
        let geometry = objects(text).unwrap()[0].geometry(4).unwrap();
        let corner = geometry.meshes[0].positions[2].as_dvec3();
        assert_eq!(geometry.places[0].point(corner), DVec3::new(1.0, 2.0, 0.0));
        // (3, 6, 0) → about x (3, 0, 6) → about z (0, 3, 6) → moved.
        let place = geometry.places[1];
        assert!((place.point(corner) - DVec3::new(0.0, 3.0, 11.0)).length() < 1e-12);
        assert!((place.point_back(place.point(corner)) - corner).length() < 1e-12);
        assert_ne!(geometry.places[0].id, place.id);
        // A texture's upward direction turns with the shape: y → z → z.
        let upwards = geometry.meshes[0].tangents[0].as_dvec3();
        assert!(
            (upwards - DVec3::Y).length() < 1e-6 && (place.direction(upwards) - DVec3::Z).length() < 1e-6
        );
    }

    /// In mm where the file says so; what is not read, or too many segments, is refused.
    #[test]
    fn curves_stand_where_their_points_are() {
        let mut object =
            objects("[[objects]]\ncurves = 'a.txt'\nbasis = 'linear'\nsurface = 'white'\nscale = 2")
                .unwrap()
                .remove(0);
        assert!(object.geometry(0).unwrap_err().to_string().contains("'a.txt' is not read"));
        let mut fill = |points: Vec<[f64; 4]>| {
            let ObjectShape::Curves { file, .. } = &mut object.shape else { panic!() };
            file.fill(vec![points.clone(), points], "hash".into());
            object.geometry(0)
        };
        let geometry = fill(vec![[1.0, 2.0, 3.0, 0.5], [1.0, 2.0, 4.0, 0.25]]).unwrap();
        assert_eq!(geometry.curves.len(), 2);
        assert_ne!(geometry.curves[0].id, geometry.curves[1].id);
        let end = geometry.curve_nodes[3];
        assert_eq!((end.point, end.radius), (Vec3::new(1.0, 2.0, 4.0), 0.25));
        assert_eq!(geometry.places[0].point(end.point.as_dvec3()), DVec3::new(2.0, 4.0, 8.0));
        let message = fill(vec![[0.0, 0.0, 0.0, 1.0]; MOST_SEGMENTS / 2 + 2]).unwrap_err().to_string();
        assert!(message.starts_with("a.txt: its curves need over 5000000 segments"), "{message}");
    }

    #[test]
    fn bad_objects_are_refused_by_key() {
        let message = |text: &str| objects(&format!("[[objects]]\n{text}")).unwrap_err().to_string();
        assert!(message("surface = 'white'").contains("objects[0] has 0 shapes"));
        assert!(message("sphere_mm = 1\nmesh = 'a.ply'\nsurface = 'white'").contains("has 2 shapes"));
        assert!(message("sphere_mm = 0\nsurface = 'white'").contains("objects[0].sphere_mm is 0, outside"));
        assert!(message("sphere_mm = 1").contains("surface is missing"));
        assert!(message("sphere_mm = 1\nsurface = 'whit'").contains("did you mean 'white'"));
        assert!(message("sphre_mm = 1\nsurface = 'white'").contains("did you mean 'sphere_mm'"));
        assert!(
            message("curves = 'a.txt'\nbasis = 'bsplin'\nsurface = 'white'")
                .contains("did you mean 'bspline'")
        );
        assert!(message("curve = 'a.txt'\nsurface = 'white'").contains("did you mean 'curves'"));
        assert!(
            message("sphere_mm = 1\nbasis = 'linear'\nsurface = 'white'").contains("there are no curves")
        );
        assert!(message("rectangle_mm = [1]\nsurface = 'white'").contains("two numbers"));
        assert!(message("sphere_mm = 1\nsurface = 'white'\ninstances = []").contains("1 to 100000"));
        assert!(
            message("sphere_mm = 1\nsurface = 'white'\nscale = 2\ninstances = [{}]")
                .contains("a place of its own")
        );
        assert!(
            message("sphere_mm = 1\nsurface = 'white'\ninstances = [{scale = 0}]")
                .contains("instances[0].scale")
        );
        assert!(message("sphere_mm = 1\nsurface = 'white'\ntranslate_mm = [1, 2]").contains("three numbers"));
    }
}
