//! From a description to a scene.

use glam::{DMat3, DVec3};

use super::objects::ObjectShape;
use super::sky::{Background, SkyDescription};
use super::{ObjectDescription, ReadyScene, SceneDescription};
use crate::error::{did_you_mean, shortened};
use crate::math::rng::hash;
use crate::progress::{Progress, Unobserved};
use crate::scene::backdrop::Backdrop;
use crate::scene::camera::Camera;
use crate::scene::coat::Laid;
use crate::scene::emission::Emission;
use crate::scene::faces::outwards;
use crate::scene::feather::Counts;
use crate::scene::geometry::{Geometry, Place};
use crate::scene::light::{Lamp, Light};
use crate::scene::sky::{Environment, Sky};
use crate::scene::{Object, Scene, go_on};
use crate::spectrum::colour::decode;
use crate::{Error, Result};

/// Shares of the samples that each lamp and the sky get.
const LAMP_WEIGHT: f64 = 0.6;
const SKY_WEIGHT: f64 = 0.4;

/// Identity of the places of feathers.
const FEATHER: u64 = 0x6665_6174;

impl ReadyScene {
    /// The whole scene.
    ///
    /// # Errors
    /// A number out of range.
    pub fn scene(&self, seed: u64) -> Result<(Scene, Counts)> {
        let (objects, counts) = self.objects(seed)?;
        let environment = self.environment()?.map(|environment| self.around_objects(environment));
        Ok((Scene { objects, lamps: self.lamps()?, environment, camera: self.camera() }, counts))
    }

    /// What stands in the scene, in the order of its objects: of a feather shaft, rami and barbules, of a coat its skin and its
    /// feathers, of everything else its shape.
    ///
    /// # Errors
    /// A number out of range.
    pub fn objects(&self, seed: u64) -> Result<(Vec<Object>, Counts)> {
        self.objects_watched(seed, &Unobserved)
    }

    /// The same for who may stop it.
    ///
    /// # Errors
    /// As [`ReadyScene::objects`], or a stop by `progress`.
    pub fn objects_watched(&self, seed: u64, progress: &dyn Progress) -> Result<(Vec<Object>, Counts)> {
        let (mut all, mut counts) = (Vec::new(), Counts::default());
        // The first feather grows from the seed itself, as does a scene's only one.
        let (mut plumages, mut shapes) = (0, 0);
        for object in &self.objects {
            go_on(progress)?;
            if object.is_plumage() {
                let own_seed = if plumages == 0 { seed } else { hash(seed, &[FEATHER, plumages]) };
                let (parts, own) = object.plumage(self.camera.width_mm, (own_seed, plumages), progress)?;
                counts.barbs += own.barbs;
                counts.barbules += own.barbules;
                all.extend(parts);
                plumages += 1;
            } else {
                let name = object.surface.as_deref().unwrap_or_default();
                let surface = self.surfaces.named(&format!("the surface of {}", object.label()), name)?;
                let mut geometry = object.geometry(shapes)?;
                if object.is_clad_mesh(&self.surfaces) {
                    geometry.meshes = geometry.meshes.into_iter().map(outwards).collect();
                }
                all.push(Object { geometry, surface: surface.build(&self.surfaces)? });
                shapes += 1;
            }
        }
        Ok((all, counts))
    }

    /// The lights that shine, but the sky: the key light in daylight (D65), then the others.
    ///
    /// # Errors
    /// A spectrum that has no power that the eye sees.
    pub fn lamps(&self) -> Result<Vec<Lamp>> {
        let mut lights = Vec::new();
        if self.light.strength > 0.0 {
            lights.push(self.light.build());
        }
        for (index, light) in self.lights.iter().enumerate().filter(|(_, light)| light.strength > 0.0) {
            lights.push(light.build().map_err(|error| error.at(format!("lights[{index}]")))?);
        }
        let turn = self.turn_about_objects();
        let turned = |light| if self.turn_deg == 0.0 { light } else { Light::turned(light, turn) };
        Ok(lights.into_iter().map(|light| Lamp { light: turned(light), weight: LAMP_WEIGHT }).collect())
    }

    /// The sky about objects that are not turned: the image, or the gradient from the zenith to the horizon and below; `None`
    /// where it is dark.
    ///
    /// # Errors
    /// A sky that is nowhere bright.
    pub fn environment(&self) -> Result<Option<Environment>> {
        if self.sky.is_dark() {
            return Ok(None);
        }
        let sky = match &self.sky {
            SkyDescription::Image(image) => Sky::clone(image.file.value()?),
            SkyDescription::Gradient { zenith, horizon, below } => {
                Sky::grey(64, 32, Emission::daylight(), |d| {
                    if d.z >= 0.0 { zenith * (horizon + (1.0 - horizon) * d.z) } else { below * zenith }
                })?
            }
        };
        Ok(Some(Environment { sky, weight: SKY_WEIGHT }))
    }

    /// What is behind everything.
    ///
    /// # Errors
    /// None for a scene of which everything is read.
    pub fn backdrop(&self) -> Result<Backdrop> {
        Ok(match &self.background {
            Background::Sky => Backdrop::Sky,
            Background::None => Backdrop::None,
            Background::Colour(colour) => Backdrop::Colour(colour.map(decode)),
            Background::Gradient(colours) => Backdrop::Gradient(colours.clone()),
            Background::Picture(slot) => Backdrop::Picture(slot.value()?.as_ref().clone()),
        })
    }
}

impl SceneDescription {
    /// Its coats as they are laid.
    ///
    /// # Errors
    /// A number out of range, a mesh that is not read, or that bears no coat.
    pub fn laid_coats(&self, seed: u64) -> Result<Vec<Laid>> {
        self.check()?;
        let coats = self.objects.iter().filter_map(|object| match &object.shape {
            ObjectShape::Coat(of) => Some((of, &object.place)),
            _ => None,
        });
        coats.map(|(of, place)| of.laid(place, seed)).collect()
    }

    /// The sky as the turned objects see it.
    #[must_use]
    pub fn around_objects(&self, environment: Environment) -> Environment {
        if self.turn_deg == 0.0 {
            return environment;
        }
        Environment { sky: environment.sky.rotated(self.turn_about_objects()), ..environment }
    }

    /// Directions of the scene as the turned objects see them: everything else turns the other way.
    fn turn_about_objects(&self) -> DMat3 {
        let upright = self.upright_camera();
        let ahead = (upright.target - upright.eye).normalize_or(DVec3::NEG_Z);
        let up = (upright.up - ahead * ahead.dot(upright.up)).normalize_or(DVec3::Z);
        DMat3::from_axis_angle(up, -self.turn_deg.to_radians())
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let camera = self.upright_camera();
        if self.turn_deg == 0.0 {
            return camera;
        }
        let turn = self.turn_about_objects();
        Camera { eye: turn * camera.eye, target: turn * camera.target, up: turn * camera.up, ..camera }
    }

    /// The camera about objects that are not turned.
    fn upright_camera(&self) -> Camera {
        let camera = self.camera.camera();
        match self.frame_of("camera.about", self.camera.about.as_deref()) {
            Ok(Some(frame)) => Camera {
                eye: frame.turn * camera.eye + frame.shift,
                target: frame.turn * camera.target + frame.shift,
                up: frame.turn * camera.up,
                ..camera
            },
            Ok(None) | Err(_) => camera,
        }
    }

    /// Where the first instance of an object stands, if one is named; its size does not count.
    ///
    /// # Errors
    /// There is no object of this name; the nearest is offered.
    pub(super) fn frame_of(&self, key: &str, name: Option<&str>) -> Result<Option<Place>> {
        let Some(name) = name else { return Ok(None) };
        let object = self.objects.iter().find(|object| object.label() == name).ok_or_else(|| {
            let near = did_you_mean(name, self.objects.iter().map(ObjectDescription::label));
            Error::input(format!("{key} is '{}'{near}; there is no object of this name", shortened(name)))
        })?;
        Ok(object.placements().first().map(|placement| placement.place(0)))
    }

    /// Names of the parts that [`ReadyScene::objects`] gives, in their order. Parts of a feather or coat with a name of its own begin with
    /// it.
    #[must_use]
    pub fn object_names(&self) -> Vec<String> {
        let names = self.objects.iter().flat_map(|object| {
            let parts = match &object.shape {
                ObjectShape::Feather(of) => of.part_names(object.width_on_it(self.camera.width_mm)),
                ObjectShape::Coat(of) => of.part_names(object.width_on_it(self.camera.width_mm)),
                ObjectShape::Row(of) => of.part_names(object.width_on_it(self.camera.width_mm)),
                _ => return vec![object.label().to_owned()],
            };
            match object.label() {
                "feather" | "coat" | "row" => parts,
                label => parts.into_iter().map(|part| format!("{label} {part}")).collect::<Vec<_>>(),
            }
        });
        names.collect()
    }
}

impl ObjectDescription {
    /// How wide a picture is on an object, in its own lengths, where it is largest.
    pub(super) fn width_on_it(&self, width_mm: f64) -> f64 {
        let largest = self.placements().iter().map(|place| place.scale).fold(0.0, f64::max);
        if largest == 1.0 { width_mm } else { width_mm / largest }
    }

    /// The parts of a feather or a coat in its places; `index`: its own among such objects.
    fn plumage(
        &self,
        width_mm: f64,
        (seed, index): (u64, u64),
        progress: &dyn Progress,
    ) -> Result<(Vec<Object>, Counts)> {
        let width_mm = self.width_on_it(width_mm);
        match &self.shape {
            ObjectShape::Feather(of) => {
                let (parts, counts) = of.parts(width_mm, seed, progress)?;
                let places = self.placements();
                if index == 0 && places == [super::Placement::HERE] {
                    return Ok((parts, counts));
                }
                let identity = |instance: usize| hash(FEATHER, &[index, instance as u64]);
                let places: Vec<Place> =
                    places.iter().enumerate().map(|(i, place)| place.place(identity(i))).collect();
                let many = places.len();
                let counts = Counts { barbs: counts.barbs * many, barbules: counts.barbules * many };
                let placed = |part: Object| Object { geometry: part.geometry.placed_at(&places), ..part };
                Ok((parts.into_iter().map(placed).collect(), counts))
            }
            ObjectShape::Coat(of) => of.parts(&self.place, width_mm, seed, progress),
            ObjectShape::Row(of) => of.parts(self.placements(), width_mm, (seed, index), progress),
            _ => Ok((Vec::new(), Counts::default())),
        }
    }
}

impl Geometry {
    /// The same at several places; where it stands at places of its own, at those of each.
    pub(super) fn placed_at(self, places: &[Place]) -> Self {
        let all = match self.places.is_empty() {
            true => places.to_vec(),
            false => places.iter().flat_map(|outer| self.places.iter().map(|own| own.then(outer))).collect(),
        };
        Self { places: all, ..self }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec2;

    use super::*;
    use crate::brdf::fixtures::example;
    use crate::brdf::{FeatherBrdf, Options};
    use crate::scene::camera::Projection;

    fn starling(text: &str) -> SceneDescription {
        SceneDescription::parse(&format!("preset = 'starling'\n{text}")).unwrap()
    }

    fn ready(scene: SceneDescription) -> ReadyScene {
        let brdf = FeatherBrdf::new(&example(3), Options::default()).unwrap();
        scene.wearing(Arc::new(brdf)).unwrap()
    }

    /// Where the eye of a camera without a lens is and what is in focus decides nothing about the picture.
    #[test]
    fn focus_moves_no_ray_and_positions_take_the_place_of_bearings() {
        let base = starling("[camera]\nlens = 0.0").camera();
        let ray = |camera: &Camera, x: f64| camera.ray(DVec2::new(x, 0.3), DVec2::ZERO, [40, 30]);
        let near = starling("[camera]\nlens = 0.0\nfocus_distance_mm = 9.0").camera();
        for x in [0.0, 0.4, 1.0] {
            assert!((ray(&base, x).direction - ray(&near, x).direction).length() < 1e-12);
        }
        let sharp = starling("[camera]\nlens = 0.1\nfocus_distance_mm = 9.0").camera();
        // All rays of a pixel meet 9 mm ahead of the lens.
        let meets = |lens: DVec2| {
            let ray = sharp.ray(DVec2::new(0.2, 0.8), lens, [40, 30]);
            let ahead = (base.target - base.eye).normalize();
            ray.origin + ray.direction * (9.0 / ray.direction.dot(ahead))
        };
        assert!((meets(DVec2::new(0.1, 0.9)) - meets(DVec2::new(0.8, 0.3))).length() < 1e-9);
        let eye = base.eye;
        let distance = |camera: &Camera| (camera.eye - camera.target).length();
        let text =
            format!("[camera]\nlens = 0.0\nazimuth = 3.0\nposition_mm = [{}, {}, {}]", eye.x, eye.y, eye.z);
        assert!((starling(&text).camera().eye - eye).length() < 1e-12);
        let wide =
            starling("[camera]\nposition_mm = [0, 0, 10]\ntarget_mm = [1, 0, 0]\nfocal_length_mm = 36")
                .camera();
        assert!((wide.width_mm - f64::sqrt(101.0)).abs() < 1e-12 && wide.target == DVec3::X);
        let flat = starling("[camera]\nprojection = 'orthographic'").camera();
        assert_eq!(flat.projection, Projection::Orthographic);
        // Life size at f/4: the lens is 2 f away and has the radius f/8.
        let lens = starling("[camera]\nwidth_mm = 36\nf_number = 4").camera();
        let Projection::Perspective { lens_radius } = lens.projection else { panic!("{lens:?}") };
        assert!((lens_radius / distance(&lens) - 0.0625).abs() < 1e-12);
        let tele = starling("[camera]\nfocal_length_mm = 288").camera();
        assert!((distance(&tele) / distance(&base) - 2.0).abs() < 1e-12);
    }

    /// A turned feather is the same scene seen from elsewhere: light and camera keep their angle, and the picture its upward axis.
    #[test]
    fn a_turned_feather_keeps_camera_and_light_together() {
        let text = "[[lights]]\ntype = 'spot'\nposition_mm = [3, 4, 5]\ntarget_mm = [0, 0, 1]\ncone_deg = 20\nstrength = 1";
        let (still, turned) = (ready(starling(text)), ready(starling(&format!("turn_deg = 50.0\n{text}"))));
        let places = |scene: &ReadyScene| {
            let lamps = scene.lamps().unwrap();
            let (Light::Sun(sun), Light::Spot(spot)) = (&lamps[0].light, &lamps[1].light) else { panic!() };
            [scene.camera().eye, sun.direction, spot.position, spot.axis]
        };
        let (before, after) = (places(&still), places(&turned));
        for i in 0..4 {
            for j in 0..4 {
                assert!((before[i].dot(before[j]) - after[i].dot(after[j])).abs() < 1e-9, "{i} {j}");
            }
            assert!((before[i] - after[i]).length() > 0.05);
        }
        // The picture's upward direction stays where it is in the feather.
        let upright = |camera: &Camera| {
            let ahead = (camera.target - camera.eye).normalize();
            (camera.up - ahead * ahead.dot(camera.up)).normalize()
        };
        let (up, up_turned) = (upright(&still.camera()), upright(&turned.camera()));
        assert!((up - up_turned).length() < 1e-12);
        let angle = before[0].reject_from(up).angle_between(after[0].reject_from(up));
        assert!((angle.to_degrees() - 50.0).abs() < 1e-9);
        let sky = turned.around_objects(turned.environment().unwrap().unwrap()).sky;
        assert!((sky.rotation() * before[1] - after[1]).length() < 1e-12);
    }

    /// The upward direction of a camera may be any axis, and its frame that of an object.
    #[test]
    fn cameras_have_an_upward_axis_and_stand_about_objects() {
        let up = |text: &str| starling(&format!("[camera]\nazimuth = 90\nelevation = 0\n{text}")).camera();
        let camera = up("up = 'z'\nroll = 0");
        assert!((camera.up - DVec3::Z).length() < 1e-12);
        // Clockwise by a quarter, seen from +x: the picture's upward direction is to its right, which is +y.
        let rolled = up("up = 'z'\nroll = 90");
        assert!((rolled.up - DVec3::Y).length() < 1e-12, "{:?}", rolled.up);
        assert!((up("up = [0, 0, 3]\nroll = 0").up - DVec3::Z).length() < 1e-12);
        let turned = "up = 'z'\nroll = 0\nabout = 'ball'\n[[objects]]\nname = 'ball'\nsphere_mm = 1\nsurface = 'white'\n\
                      rotate_deg = [0, 90, 0]\ntranslate_mm = [1, 2, 3]\n[surfaces.white]\ntype = 'diffuse'";
        let about = up(turned);
        let target = starling("").camera().target;
        assert!((about.up - DVec3::X).length() < 1e-12);
        assert!(
            (about.target - (DVec3::new(target.z, target.y, -target.x) + DVec3::new(1.0, 2.0, 3.0))).length()
                < 1e-12
        );
        let none =
            SceneDescription::parse("preset = 'starling'\n[camera]\nabout = 'bal'").unwrap_err().to_string();
        assert!(none.contains("camera.about is 'bal'"), "{none}");
        // The feather of a file is an object as well.
        let feather = SceneDescription::parse("preset = 'starling'\n[camera]\nabout = 'feather'").unwrap();
        assert_eq!(feather.camera.about.as_deref(), Some("feather"));
    }

    #[test]
    fn scenes_that_lack_what_they_name_are_not_ready() {
        let text = "[background]\nfile = 'wall.png'\n[[lights]]\ntype = 'point'\nposition_mm = [0, 0, 5]\nstrength = 1\nspectrum = 'lamp.csv'";
        let lacking = ReadyScene::new(starling(text)).unwrap_err().to_string();
        assert_eq!(lacking, "lights[0].spectrum is not read");
        let lacking = ReadyScene::new(starling("[background]\nfile = 'wall.png'")).unwrap_err().to_string();
        assert_eq!(lacking, "background is not read");
        let lacking = ReadyScene::new(starling("")).unwrap_err().to_string();
        assert_eq!(lacking, "material is not read");
    }
}
