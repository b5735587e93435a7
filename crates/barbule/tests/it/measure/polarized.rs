//! Paths that carry polarization between bounces, beside the same paths that lose it at each: an experiment, which the
//! renderer itself does not make.
//!
//! A path starts at the camera, which sees all polarizations alike, with the row (1, 0, 0) for the Stokes parameters
//! I, Q, U of the light that comes towards it. Each scattering multiplies it by a Mueller matrix from the right, and
//! lamps and sky are unpolarized: what such light brings is the row's first number. V is left out: no surface here mixes it with the
//! others. Rows and matrices belong to axes: Q is along the axis, U half way between it and (propagation × axis).

use barbule::brdf::FeatherBrdf;
use barbule::bsdf::{Bsdf, Hit, Keratin, Side, Surface};
use barbule::render::light::Lighting;
use barbule::render::sampler::Sampler;
use barbule::render::stage::Stage;
use barbule::scene::camera::Camera;
use barbule::spectrum::dense::WAVES;
use barbule::spectrum::hero::Hero;
use barbule::spectrum::sensor::Sensor;
use glam::{DVec2, DVec3};

/// What a camera sees per I, Q and U of the light on a path.
pub(crate) type Row = [f64; 3];

/// Of I, Q and U, over the unpolarized reflectance: its first number is 1.
pub(crate) type Mueller = [[f64; 3]; 3];

/// What a barbule's upper side may do to polarization.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum BarbuleModel {
    /// What the material's tables say about both polarizations along and across the barbule, whose fields are in step (1),
    /// not correlated (0) or in opposite step (−1): every correlation lies between, and only U's part hangs on it.
    Tables {
        /// −1 to 1.
        step: f64,
    },
    /// What a smooth keratin boundary does that mirrors the light so.
    Boundary,
    /// It reflects one polarization only, across the plane of incidence: nothing polarizes more.
    Polarizer,
}

/// All that are followed at once.
pub(crate) const MODELS: [BarbuleModel; COUNT] = [
    BarbuleModel::Tables { step: 1.0 },
    BarbuleModel::Tables { step: 0.0 },
    BarbuleModel::Tables { step: -1.0 },
    BarbuleModel::Boundary,
    BarbuleModel::Polarizer,
];

const COUNT: usize = 5;

/// A polarizer over its unpolarized reflectance; the axis is the one that it reflects.
const POLARIZER: Mueller = [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0; 3]];

/// The row for light about another axis. `towards` is where the light goes; both axes are unit vectors across it.
pub(crate) fn turned([i, q, u]: Row, towards: DVec3, from: DVec3, to: DVec3) -> Row {
    let (cos, sin) = (from.dot(to), towards.cross(from).dot(to));
    let (cos2, sin2) = (cos * cos - sin * sin, 2.0 * sin * cos);
    [i, q * cos2 + u * sin2, u * cos2 - q * sin2]
}

/// The row before a scattering: row times matrix.
pub(crate) fn scattered(row: Row, by: &Mueller) -> Row {
    [0, 1, 2].map(|column| (0..3).map(|k| row[k] * by[k][column]).sum())
}

/// A smooth dielectric's mirror at this cosine, over its unpolarized reflectance; the axis is across the plane of incidence.
pub(crate) fn fresnel(cosine: f64, index: f64) -> Mueller {
    let inside = (1.0 - (1.0 - cosine * cosine) / (index * index)).max(0.0).sqrt();
    let s = (cosine - index * inside) / (cosine + index * inside);
    let p = (index * cosine - inside) / (index * cosine + inside);
    let mean = 0.5 * (s * s + p * p);
    let part = 0.5 * (s * s - p * p) / mean;
    [[1.0, part, 0.0], [part, 1.0, 0.0], [0.0, 0.0, s * p / mean]]
}

/// A barbule's matrix about its long axis. `leaving` is polarization 1's part of the light that it sends to the viewer,
/// `arriving` its part in what unpolarized light is weighed with from the other side. Both together need some light to change
/// polarization; no more than that does.
pub(crate) fn barbule(leaving: f64, arriving: f64, step: f64) -> Mueller {
    // [leaves in][arrives in] of two polarizations, which add up to 2.
    let (first, second) = (2.0 * leaving.min(arriving), 2.0 * (1.0 - leaving).min(1.0 - arriving));
    let [from_second, from_first] = [2.0 * leaving - first, 2.0 * (1.0 - leaving) - second];
    [
        [1.0, 0.5 * (first + from_first - from_second - second), 0.0],
        [2.0 * leaving - 1.0, 0.5 * (first + second - from_first - from_second), 0.0],
        [0.0, 0.0, step * (first * second).sqrt()],
    ]
}

/// A scene with what its surfaces do to polarization.
pub(crate) struct PolarizedScene<'a> {
    pub(crate) stage: &'a Stage,
    pub(crate) lighting: &'a Lighting,
    pub(crate) camera: &'a Camera,
    /// The barbules' BRDF for either polarization on the side of the direction that is given first.
    pub(crate) barbules: Option<[FeatherBrdf; 2]>,
    /// For each object the boundary of its keratin alone, over a black body, with its refractive index; of barbules the underside's.
    pub(crate) boundaries: Vec<(Keratin, f64)>,
    /// Most scatterings of a path.
    pub(crate) scatterings: u32,
}

/// What one sample of a pixel saw: radiances over the wavelengths' densities.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PolarizedSample {
    pub(crate) hero: Hero,
    /// With polarization lost at each scattering, as the renderer has it.
    pub(crate) depolarized: [f64; WAVES],
    /// With polarization kept, for each of [`MODELS`].
    pub(crate) polarized: [[f64; WAVES]; COUNT],
    /// The part of `depolarized` that was scattered twice or more.
    pub(crate) twice: [f64; WAVES],
    /// The part of `depolarized` that barbules' upper sides scattered twice or more.
    pub(crate) twice_by_barbules: [f64; WAVES],
}

/// A path as the renderer follows it, with its rows.
struct Path {
    origin: DVec3,
    direction: DVec3,
    weight: [f64; WAVES],
    through: [f64; WAVES],
    through_lights: [f64; WAVES],
    /// Over `weight`, for each of [`MODELS`].
    rows: [[Row; WAVES]; COUNT],
    /// Of the rows.
    axes: [DVec3; COUNT],
    scatterings: u32,
    by_barbules: u32,
}

/// What a scattering does to rows.
#[derive(Clone, Copy)]
struct Polarizer {
    matrices: [Mueller; WAVES],
    /// The axes that they belong to on either side.
    leaving: DVec3,
    arriving: DVec3,
}

impl PolarizedScene<'_> {
    /// One sample of a pixel, from the same random numbers as the renderer's.
    pub(crate) fn sample(&self, pixel: [u32; 2], size: [u32; 2], sample: u64, seed: u64) -> PolarizedSample {
        let index = u64::from(pixel[1]) * u64::from(size[0]) + u64::from(pixel[0]);
        let mut sampler = Sampler::new(index, sample, seed);
        let [x, y, lens_u, lens_v] = sampler.next4();
        let hero = Sensor::human().density().draw(sampler.next4()[0]);
        let place = |k: usize, offset: f64| (f64::from(pixel[k]) + offset) / f64::from(size[k]);
        let ray = self.camera.ray(DVec2::new(place(0, x), place(1, y)), DVec2::new(lens_u, lens_v), size);
        let mut path = Path {
            origin: ray.origin,
            direction: ray.direction,
            weight: [1.0; WAVES],
            through: [1.0; WAVES],
            through_lights: [0.0; WAVES],
            rows: [[[1.0, 0.0, 0.0]; WAVES]; COUNT],
            axes: [ray.direction.any_orthonormal_vector(); COUNT],
            scatterings: 0,
            by_barbules: 0,
        };
        let nothing = [0.0; WAVES];
        let mut seen = PolarizedSample {
            hero,
            depolarized: nothing,
            polarized: [nothing; COUNT],
            twice: nothing,
            twice_by_barbules: nothing,
        };
        while self.step(&mut path, &mut sampler, &mut seen) {}
        seen
    }

    /// Follows the path to its next scattering; `false` when it ends.
    fn step(&self, path: &mut Path, sampler: &mut Sampler, seen: &mut PolarizedSample) -> bool {
        let nearest = self.stage.nearest_mm();
        let from = if path.scatterings > 0 { nearest } else { 0.0 };
        let Some(hit) = self.stage.hit(path.origin, path.direction, from, f64::INFINITY) else {
            self.escape(path, seen);
            return false;
        };
        if path.scatterings == self.scatterings {
            return false;
        }
        let wo = -path.direction;
        let bsdf = self.stage.surface(&hit).bind(&hit, wo, seen.hero.wavelengths);
        let [u, v, component, roulette] = sampler.next4();
        for draw in 0..self.lighting.draws() {
            let [choice, light_u, light_v, _] = sampler.next4();
            let light = self.lighting.choose(draw, choice);
            self.light(path, &hit, &bsdf, light, DVec2::new(light_u, light_v), seen);
        }
        let Some(drawn) = bsdf.sample([u, v, component]) else { return false };
        let evaluation = drawn.evaluation;
        self.polarize(path, &hit, &evaluation.f, drawn.wi, seen);
        let pdf = evaluation.pdf[0];
        path.through_lights = path.through.map(|t| t / pdf);
        for k in 0..WAVES {
            path.weight[k] *= evaluation.f[k] * evaluation.cosine / pdf;
            path.through[k] *= evaluation.pdf[k] / pdf;
        }
        path.origin = hit.position;
        path.direction = drawn.wi;
        let weight = path.weight.iter().copied().fold(0.0, f64::max) / mean(&path.through);
        let keep = (weight / 0.3).min(1.0);
        path.weight = path.weight.map(|w| w / keep);
        roulette < keep
    }

    /// Takes the path's rows over a scattering towards the light in `wi`.
    fn polarize(&self, path: &mut Path, hit: &Hit, f: &[f64; WAVES], wi: DVec3, seen: &PolarizedSample) {
        let wo = -path.direction;
        let side = hit.side(wo);
        let barbule = match (self.stage.surface(hit), &self.barbules) {
            (Surface::Barbule(surface), Some(barbules)) if side.is_upper => {
                Some((barbules, surface.instances.then_some(hit.instance)))
            }
            _ => None,
        };
        let polarizers = match barbule {
            Some((barbules, instance)) => {
                let parts = parts(barbules, instance, &side, wi, seen);
                MODELS.map(|model| match model {
                    BarbuleModel::Tables { step } => along_barbule(&parts, step, &side, [wo, wi]),
                    BarbuleModel::Boundary => {
                        let index = self.boundaries[hit.object as usize].1;
                        across_plane(fresnel(half_cosine(wo, wi), index), [1.0; WAVES], [wo, wi])
                    }
                    BarbuleModel::Polarizer => across_plane(POLARIZER, [1.0; WAVES], [wo, wi]),
                })
            }
            None => [self.boundary(hit, &side, f, [wo, wi], seen); COUNT],
        };
        for ((rows, axis), polarizer) in path.rows.iter_mut().zip(&mut path.axes).zip(polarizers) {
            for (row, matrix) in rows.iter_mut().zip(&polarizer.matrices) {
                *row = scattered(turned(*row, wo, *axis, polarizer.leaving), matrix);
            }
            *axis = polarizer.arriving;
        }
        path.scatterings += 1;
        path.by_barbules += u32::from(barbule.is_some());
    }

    /// Keratin: its boundary polarizes, what its body scatters has lost all polarization.
    fn boundary(
        &self,
        hit: &Hit,
        side: &Side,
        f: &[f64; WAVES],
        [wo, wi]: [DVec3; 2],
        seen: &PolarizedSample,
    ) -> Polarizer {
        let (boundary, index) = &self.boundaries[hit.object as usize];
        let (gloss, _) = boundary.eval(side.wo, side.frame.to_local(wi), seen.hero.wavelengths);
        let shares = std::array::from_fn(|k| if f[k] > 0.0 { (gloss[k] / f[k]).min(1.0) } else { 0.0 });
        across_plane(fresnel(half_cosine(wo, wi), *index), shares, [wo, wi])
    }

    fn escape(&self, path: &Path, seen: &mut PolarizedSample) {
        let mut found = Vec::new();
        self.lighting.escaped(path.direction, seen.hero.wavelengths, |radiance, far| {
            let mut density = mean(&path.through);
            if path.scatterings > 0 {
                density += mean(&path.through_lights) * self.lighting.far_pdf(far, path.direction);
            }
            found.push((radiance, density));
        });
        for (radiance, density) in found {
            add(path, radiance.map(|r| r / density), seen);
        }
    }

    fn light(
        &self,
        path: &Path,
        hit: &Hit,
        bsdf: &Bsdf<'_>,
        light: usize,
        u: DVec2,
        seen: &mut PolarizedSample,
    ) {
        let Some(sample) = self.lighting.sample(light, hit.position, u, seen.hero.wavelengths) else {
            return;
        };
        let evaluation = bsdf.eval(sample.direction);
        let nearest = self.stage.nearest_mm();
        if evaluation.f == [0.0; WAVES]
            || self.stage.is_blocked(hit.position, sample.direction, nearest, sample.distance - nearest)
        {
            return;
        }
        let mut end = Path { ..*path };
        self.polarize(&mut end, hit, &evaluation.f, sample.direction, seen);
        let densities: [f64; WAVES] =
            std::array::from_fn(|k| path.through[k] * (1.0 + evaluation.pdf[k] / sample.pdf));
        let share = evaluation.cosine / sample.pdf / mean(&densities);
        add(&end, std::array::from_fn(|k| sample.radiance[k] * evaluation.f[k] * share), seen);
    }
}

/// Adds unpolarized radiance at the end of a path.
fn add(path: &Path, radiance: [f64; WAVES], seen: &mut PolarizedSample) {
    for k in 0..WAVES {
        let value = path.weight[k] * radiance[k] / seen.hero.pdf[k];
        seen.depolarized[k] += value;
        for (sum, rows) in seen.polarized.iter_mut().zip(&path.rows) {
            sum[k] += value * rows[k][0];
        }
        if path.scatterings > 1 {
            seen.twice[k] += value;
        }
        if path.by_barbules > 1 {
            seen.twice_by_barbules[k] += value;
        }
    }
}

/// Polarization 1's parts at each wavelength, in what a barbule sends to the viewer and in what comes from the light.
fn parts(
    barbules: &[FeatherBrdf; 2],
    instance: Option<u64>,
    side: &Side,
    wi: DVec3,
    seen: &PolarizedSample,
) -> [[f64; WAVES]; 2] {
    let (wo, wi) = (side.wo, side.frame.to_local(wi));
    // The tables know it on the side of the first direction, which they call the incident one.
    [[wo, wi], [wi, wo]].map(|[first, second]| {
        let nm = seen.hero.wavelengths.single_nm();
        let [one, two] = barbules.each_ref().map(|brdf| brdf.eval(nm, first, second, instance));
        std::array::from_fn(|k| {
            let both = one[k] + two[k];
            if both > 0.0 { f64::from(one[k] / both) } else { 0.5 }
        })
    })
}

fn along_barbule(
    [leaving, arriving]: &[[f64; WAVES]; 2],
    step: f64,
    side: &Side,
    [wo, wi]: [DVec3; 2],
) -> Polarizer {
    let matrices = std::array::from_fn(|k| barbule(leaving[k], arriving[k], step));
    Polarizer { matrices, leaving: across(side.frame.y, wo), arriving: across(side.frame.y, wi) }
}

/// A mirror about the normal of the plane of incidence, for a share of the light; the rest has lost its polarization.
fn across_plane(mirror: Mueller, shares: [f64; WAVES], [wo, wi]: [DVec3; 2]) -> Polarizer {
    let matrices = shares.map(|share| {
        let mut matrix = mirror.map(|row| row.map(|value| share * value));
        matrix[0][0] = 1.0;
        matrix
    });
    let axis = wo.cross(wi).normalize_or(wo.any_orthonormal_vector());
    Polarizer { matrices, leaving: axis, arriving: axis }
}

/// Cosine of the angle at which a mirror turns light from one direction into the other.
fn half_cosine(wo: DVec3, wi: DVec3) -> f64 {
    (0.5 * (1.0 + wo.dot(wi))).max(0.0).sqrt()
}

/// The unit vector across `direction` that is nearest to `axis`.
fn across(axis: DVec3, direction: DVec3) -> DVec3 {
    (axis - direction * axis.dot(direction)).normalize_or(direction.any_orthonormal_vector())
}

fn mean(values: &[f64; WAVES]) -> f64 {
    values.iter().sum::<f64>() / WAVES as f64
}
