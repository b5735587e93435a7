//! From a description to a scene.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::{
    Background, Bearing, FibreDescription, Metal, NamedSurface, PigmentedKeratin, SceneDescription,
    SkyDescription, TextureFile, ViewProjection,
};
use crate::brdf::FeatherBrdf;
use crate::bsdf::{
    Absorption, Conductor, Dielectric, FacetRoughness, FibreIndex, Hair, HairParameters, Keratin, Lambertian,
    Pictures, Reflectance, Relief, RoughDielectric, Surface, SurfaceMap, ThinFilm,
};
use crate::material::Library;
use crate::scene::backdrop::Backdrop;
use crate::scene::camera::{Camera, Projection, direction};
use crate::scene::emission::Emission;
use crate::scene::feather::Counts;
use crate::scene::light::{Lamp, Light, Sun, disc_radiance};
use crate::scene::sky::{Environment, Sky};
use crate::scene::{Object, Scene};
use crate::spectrum::colour::decode;
use crate::stack::Stack;
use crate::{Error, Result};

/// Shares of the samples that each lamp and the sky get.
const LAMP_WEIGHT: f64 = 0.6;
const SKY_WEIGHT: f64 = 0.4;

/// Where nothing is said: four times as far as the picture is wide.
const USUAL_FOCAL_LENGTH_MM: f64 = 144.0;

/// Width of the film that focal lengths are told for, mm.
const FILM_MM: f64 = 36.0;

impl SceneDescription {
    /// The whole scene under the description's own sky.
    ///
    /// # Errors
    /// A number out of range, a file that is not read, or a sky that is an image: give it to
    /// [`SceneDescription::environment`].
    pub fn scene(&self, brdf: impl Into<Option<Arc<FeatherBrdf>>>, seed: u64) -> Result<(Scene, Counts)> {
        let (objects, counts) = self.objects(brdf, seed)?;
        let environment = self.environment(None)?.map(|environment| self.around_feather(environment));
        Ok((Scene { objects, lamps: self.lamps()?, environment, camera: self.camera() }, counts))
    }

    /// The feather: shaft, rami, barbules, or a coat's skin and its feathers; then the other objects. A feather of plain barbules needs no material.
    ///
    /// # Errors
    /// A number out of range, or a file that is not read.
    pub fn objects(
        &self,
        brdf: impl Into<Option<Arc<FeatherBrdf>>>,
        seed: u64,
    ) -> Result<(Vec<Object>, Counts)> {
        self.check()?;
        let (mut objects, counts) = match &self.coat {
            Some(coat) => self.coat_parts(coat, brdf.into(), seed)?,
            None if self.shows_feather => self.feather_parts(brdf.into(), seed)?,
            None => (Vec::new(), Counts::default()),
        };
        for (index, object) in self.objects.iter().enumerate() {
            let surface = self.named_surfaces.get(&object.surface).ok_or_else(|| {
                Error::input(format!("objects[{index}]: there is no surface '{}'", object.surface))
            })?;
            objects.push(Object {
                geometry: object.geometry(index)?,
                surface: surface.build(&self.named_surfaces)?,
            });
        }
        Ok((objects, counts))
    }

    /// The lights that shine, but the sky: the key light in daylight (D65), then the others.
    ///
    /// # Errors
    /// A spectrum that is not read, or has no power that the eye sees.
    pub fn lamps(&self) -> Result<Vec<Lamp>> {
        let mut lights = Vec::new();
        if self.light.strength > 0.0 {
            let radius = self.light.radius_deg.to_radians();
            lights.push(Light::Sun(Sun {
                direction: self.light.bearing.direction(),
                cos_radius: radius.cos(),
                emission: Emission::daylight().scaled(disc_radiance(radius, self.light.strength)),
            }));
        }
        for (index, light) in self.lights.iter().enumerate().filter(|(_, light)| light.strength > 0.0) {
            lights.push(light.build().map_err(|error| error.at(format!("lights[{index}]")))?);
        }
        let turn = self.turn_about_feather();
        let turned = |light| if self.turn_deg == 0.0 { light } else { Light::turned(light, turn) };
        Ok(lights.into_iter().map(|light| Lamp { light: turned(light), weight: LAMP_WEIGHT }).collect())
    }

    /// The sky as the turned feather sees it.
    #[must_use]
    pub fn around_feather(&self, environment: Environment) -> Environment {
        if self.turn_deg == 0.0 {
            return environment;
        }
        Environment { sky: environment.sky.rotated(self.turn_about_feather()), ..environment }
    }

    /// Directions of the scene as the turned feather sees them: everything else turns the other way.
    fn turn_about_feather(&self) -> DMat3 {
        let upright = self.upright_camera();
        let ahead = (upright.target - upright.eye).normalize_or(DVec3::NEG_Z);
        let up = (upright.up - ahead * ahead.dot(upright.up)).normalize_or(DVec3::Z);
        DMat3::from_axis_angle(up, -self.turn_deg.to_radians())
    }

    /// The sky about a feather that is not turned: that of `image`, or the description's gradient, from the zenith to the
    /// horizon and below; `None` where it is dark.
    ///
    /// # Errors
    /// A description that needs an image.
    pub fn environment(&self, image: Option<Sky>) -> Result<Option<Environment>> {
        let sky = match (image, &self.sky) {
            (Some(sky), _) => sky,
            (None, _) if self.is_sky_dark() => return Ok(None),
            (None, SkyDescription::Gradient { zenith, horizon, below }) => {
                Sky::grey(64, 32, Emission::daylight(), |d| {
                    if d.z >= 0.0 { zenith * (horizon + (1.0 - horizon) * d.z) } else { below * zenith }
                })?
            }
            (None, SkyDescription::Image(image)) => {
                return Err(Error::input(format!(
                    "the sky is the image '{}', which is not read",
                    image.file
                )));
            }
        };
        Ok(Some(Environment { sky, weight: SKY_WEIGHT }))
    }

    /// Whether nothing comes from the sky.
    #[must_use]
    pub fn is_sky_dark(&self) -> bool {
        let strength = match &self.sky {
            SkyDescription::Gradient { zenith, .. } => *zenith,
            SkyDescription::Image(image) => image.strength,
        };
        strength <= 0.0
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let camera = self.upright_camera();
        if self.turn_deg == 0.0 {
            return camera;
        }
        let turn = self.turn_about_feather();
        Camera { eye: turn * camera.eye, target: turn * camera.target, up: turn * camera.up, ..camera }
    }

    /// The camera about a feather that is not turned. What is in focus need not be what it looks at: then the same picture is that of
    /// the plane in focus.
    fn upright_camera(&self) -> Camera {
        let view = &self.camera;
        let target = DVec3::from(view.target);
        let (eye, width_mm) = match view.position {
            None => {
                let distance =
                    view.focal_length_mm.unwrap_or(USUAL_FOCAL_LENGTH_MM) / FILM_MM * view.width_mm;
                (target + view.bearing.direction() * distance, view.width_mm)
            }
            Some(position) => {
                let eye = DVec3::from(position);
                let width = |focal: f64| FILM_MM / focal * (eye - target).length();
                (eye, view.focal_length_mm.map_or(view.width_mm, width))
            }
        };
        let distance = (eye - target).length();
        let roll = view.roll_deg.to_radians();
        let up = DVec3::new(roll.sin(), roll.cos(), 0.0);
        let towards = (eye - target) / distance;
        // Straight along the picture's own upward direction the vane's normal is upwards.
        let up = if towards.cross(up).length() < 1e-3 { DVec3::Z } else { up };
        let projection = match view.projection {
            ViewProjection::Perspective => {
                // A thin lens of focal length f stands f (1 + 1/m) before what it magnifies by m; its radius is f/2N.
                let magnification = FILM_MM / width_mm;
                let of = |f_number: f64| 0.5 * magnification / (f_number * (1.0 + magnification));
                Projection::Perspective { lens_radius: view.f_number.map_or(view.lens, of) * distance }
            }
            ViewProjection::Orthographic => Projection::Orthographic,
        };
        let camera = Camera { eye, target, up, width_mm, projection };
        match view.focus_distance_mm {
            None => camera,
            Some(focus) => {
                Camera { target: eye - towards * focus, width_mm: width_mm * focus / distance, ..camera }
            }
        }
    }

    /// What is behind the feather.
    ///
    /// # Errors
    /// A picture that is not read.
    pub fn backdrop(&self) -> Result<Backdrop> {
        match &self.background {
            Background::Sky => Ok(Backdrop::Sky),
            Background::None => Ok(Backdrop::None),
            Background::Colour(colour) => Ok(Backdrop::Colour(colour.map(decode))),
            Background::Picture { picture: picture @ Backdrop::Picture(_), .. } => Ok(picture.clone()),
            Background::Picture { file, .. } => {
                Err(Error::input(format!("the background '{file}' is not read")))
            }
        }
    }

    /// Names of the parts that [`SceneDescription::objects`] gives, in their order.
    #[must_use]
    pub fn object_names(&self) -> Vec<String> {
        let parts = match &self.coat {
            Some(coat) => self.coat_names(coat),
            None if self.shows_feather => self.part_names(),
            None => Vec::new(),
        };
        (parts.into_iter())
            .map(str::to_owned)
            .chain(self.objects.iter().map(|object| object.name.clone()))
            .collect()
    }
}

impl Bearing {
    /// Unit vector towards it.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        direction(self.azimuth_deg.to_radians(), self.elevation_deg.to_radians())
    }
}

impl NamedSurface {
    /// The surface; `all`: those that a map chooses among.
    fn build(&self, all: &BTreeMap<String, Self>) -> Result<Surface> {
        Ok(match self {
            Self::Diffuse { colour, pictures, bump_um } => {
                let read = |key: &str| pictures.get(key).map(TextureFile::read).transpose();
                let white_mm = bump_um.unwrap_or_default() * 1e-3;
                let heights = read("bump")?.map(|picture| Relief::Heights { picture, white_mm });
                let relief = read("normal")?.map(Relief::Normals).or(heights);
                let pictures = Pictures { albedo: read("albedo")?, alpha: read("alpha")?, relief };
                Surface::Lambertian(Lambertian::painted(colour.map(decode), pictures)?)
            }
            Self::Keratin(of) => Surface::Keratin(keratin(of)?),
            Self::Hair(of) => Surface::Hair(hair(of)?),
            Self::Dielectric { index, roughness: None } => Surface::Dielectric(Dielectric::new(*index)?),
            Self::Dielectric { index, roughness: Some([along, across]) } => {
                let roughness = FacetRoughness { along: *along, across: *across };
                Surface::RoughDielectric(RoughDielectric::new(roughness, *index)?)
            }
            Self::Conductor { roughness: [along, across], metal } => {
                let roughness = FacetRoughness { along: *along, across: *across };
                Surface::Conductor(match *metal {
                    Metal::Copper => Conductor::copper(roughness)?,
                    Metal::Constant { index, absorption } => {
                        Conductor::new(roughness, |_| [index, absorption])?
                    }
                })
            }
            Self::Film { stack, roughness: [along, across], colour } => {
                let body = colour.map(|c| Reflectance::of_colour(c.map(decode))).transpose()?;
                let stack = Stack::parse(stack, &Library::builtin())?;
                let roughness = FacetRoughness { along: *along, across: *across };
                Surface::ThinFilm(ThinFilm::new(&stack, roughness, body)?)
            }
            Self::Grating(of) => Surface::Grating(of.build()?),
            Self::Map { picture, surfaces } => {
                let one = |name: &String| match all.get(name) {
                    Some(Self::Map { .. }) | None => {
                        Err(Error::input(format!("a map has no surface '{name}' to choose")))
                    }
                    Some(surface) => surface.build(all),
                };
                let surfaces = surfaces.iter().map(one).collect::<Result<_>>()?;
                let map = SurfaceMap::new(picture.read()?, surfaces);
                Surface::Map(map.map_err(|error| error.at(&picture.file))?)
            }
        })
    }
}

pub(super) fn keratin(of: &PigmentedKeratin) -> Result<Keratin> {
    Keratin::new(of.roughness, of.index, Reflectance::melanin(of.melanin)?)
}

pub(super) fn hair(of: &FibreDescription) -> Result<Hair> {
    Hair::new(HairParameters {
        longitudinal_roughness: of.longitudinal_roughness,
        azimuthal_roughness: of.azimuthal_roughness,
        scale_tilt: of.scale_tilt_deg.to_radians(),
        index: of.index.map_or(FibreIndex::Keratin, FibreIndex::Constant),
        absorption: Absorption::pigments(of.eumelanin, of.pheomelanin)?,
        height_over_width: of.height_over_width,
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn starling(text: &str) -> SceneDescription {
        SceneDescription::parse(&format!("preset = 'starling'\n{text}")).unwrap()
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
        let (still, turned) = (starling(text), starling(&format!("turn_deg = 50.0\n{text}")));
        let places = |scene: &SceneDescription| {
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
        let sky = turned.around_feather(turned.environment(None).unwrap().unwrap()).sky;
        assert!((sky.rotation() * before[1] - after[1]).length() < 1e-12);
    }

    #[test]
    fn lights_and_backgrounds_that_are_not_read_are_refused() {
        let scene = starling(
            "[background]\nfile = 'wall.png'\n[[lights]]\ntype = 'point'\nposition_mm = [0, 0, 5]\nstrength = 1\nspectrum = 'lamp.csv'",
        );
        assert!(
            scene.lamps().unwrap_err().to_string().contains("lights[0]: the spectrum 'lamp.csv' is not read")
        );
        assert!(scene.backdrop().unwrap_err().to_string().contains("'wall.png' is not read"));
    }
}
