//! The fast simulation's formulas, evaluated plainly: its reference.
//!
//! One loop over points, one over azimuths, vectors in three dimensions, reflectances from [`film`](crate::film), crystals
//! solved for every point. Slow on purpose: no tables, no transforms, no matrix products, no vector instructions.

use glam::DVec3;
use num_complex::Complex64;

use super::beam;
use super::crystal::Cell;
use super::crystal::multipole::PreparedCell;
use super::far_fields::{OneByOne, Prepared, SectionSolver};
use super::surface::{FINE_ELEMENT_UM, solver};
use crate::film::{Polarization, reflect};
use crate::progress::{OnlyStops, Progress, Unobserved};
use crate::scattering::directions::{e1, e2, omega};
use crate::scattering::far_field::{Azimuths, FarField, Illumination, Window, coefficients, refinement};
use crate::structure::{Columns, CrystalLayer, Polyline, Ray, Section, cast};
use crate::{Error, Result};

/// A complex 3-vector.
type Field = [Complex64; 3];

/// E and H̃ at a point.
type Wave = (Field, Field);

/// The far field of a section on so many azimuths of the upper half, by Gauss's two-point rule on elements of at most
/// `element_um`: what [`surface::far_field`](super::surface::far_field) computes too.
///
/// # Errors
/// As [`cast`], [`Section::check_lit_through_air`] and [`Section::check_nothing_above_top`]; a medium's table does not reach the
/// wavelength, or a crystal cannot be solved.
pub fn far_field(
    section: &Section,
    illumination: &Illumination,
    azimuths: usize,
    element_um: f64,
) -> Result<FarField> {
    far_field_observed(section, illumination, azimuths, element_um, Shadows::Ignored, &Unobserved)
}

/// This evaluation as a solver of sections.
#[derive(Debug, Clone, Copy)]
pub struct Direct {
    /// Longest element, µm.
    pub element_um: f64,
    /// Whether the top stands in its own light.
    pub shadows: Shadows,
}

impl Default for Direct {
    fn default() -> Self {
        Self { element_um: FINE_ELEMENT_UM, shadows: Shadows::Ignored }
    }
}

impl SectionSolver for Direct {
    fn prepare<'a>(&self, section: &'a Section) -> Result<Box<dyn Prepared + 'a>> {
        let Self { element_um, shadows } = *self;
        let far_field =
            move |section: &Section, light: &Illumination, azimuths: usize, progress: &dyn Progress| {
                far_field_observed(section, light, azimuths, element_um, shadows, progress)
            };
        Ok(Box::new(OneByOne { section, element_um, far_field }))
    }
}

/// Whether the top stands in its own light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shadows {
    /// Every point that faces the light is lit, and what leaves it is seen from everywhere.
    Ignored,
    /// No light comes or leaves through the top itself: a point neither is lit from nor sends towards directions that other
    /// points of the top hide.
    Cast,
}

/// As [`far_field`], watched by `progress`.
///
/// # Errors
/// As [`far_field`], or the user cancelled.
pub fn far_field_observed(
    section: &Section,
    illumination: &Illumination,
    azimuths: usize,
    element_um: f64,
    shadows: Shadows,
    progress: &dyn Progress,
) -> Result<FarField> {
    if illumination.window == Window::Beam {
        return beam::far_field(section, illumination, azimuths, &|wave, azimuths| {
            far_field_observed(section, wave, azimuths, element_um, shadows, &OnlyStops(progress))
        });
    }
    section.check_lit_through_air()?;
    section.check_nothing_above_top()?;
    let lit = illuminate(section, element_um, illumination, shadows, progress)?;
    radiate(&lit, illumination, azimuths, progress)
}

/// The top of a section under light.
struct Lit {
    /// Per incident polarization.
    currents: [Vec<Current>; 2],
    incident_power_um: f64,
    /// Largest distance of a point from the origin.
    radius_um: f64,
}

/// The equivalent currents J dl and M dl of one point.
struct Current {
    x_um: f64,
    z_um: f64,
    electric: Field,
    magnetic: Field,
    sky: Sky,
}

/// What a point sees of the sky: the steepest lines dz/|dx| from it to the top on its left and on its right.
#[derive(Debug, Clone, Copy)]
struct Sky([f64; 2]);

impl Sky {
    /// Not infinite, so that it is nothing at φ = 0.
    const OPEN: Self = Self([f64::MIN; 2]);

    fn shows(self, phi: f64) -> bool {
        let (sin, cos) = phi.sin_cos();
        cos > self.0[usize::from(sin > 0.0)] * sin.abs()
    }
}

/// The sky over each point of a top from left to right: the tangents to the hull of what is beside it.
fn skies(rays: &[Ray]) -> Vec<Sky> {
    let mut skies = vec![Sky::OPEN; rays.len()];
    let mut look = |side: usize, order: &mut dyn Iterator<Item = usize>| {
        let slope = |from: usize, to: usize| {
            (rays[to].z_um - rays[from].z_um) / (rays[to].x_um - rays[from].x_um).abs()
        };
        let mut hull: Vec<usize> = Vec::new();
        for here in order {
            while let [.., second, first] = hull[..]
                && slope(here, second) >= slope(here, first)
            {
                hull.pop();
            }
            if let Some(&highest) = hull.last() {
                skies[here].0[side] = slope(here, highest);
            }
            hull.push(here);
        }
    };
    look(0, &mut (0..rays.len()));
    look(1, &mut (0..rays.len()).rev());
    skies
}

/// The currents that the top carries: at each lit point those of the wave that the stack or crystal under it reflects.
fn illuminate(
    section: &Section,
    element_um: f64,
    illumination: &Illumination,
    shadows: Shadows,
    progress: &dyn Progress,
) -> Result<Lit> {
    let Illumination { wavelength_nm, theta_i, phi_i, window } = *illumination;
    let k = illumination.wave_number_per_um();
    let (rays, lengths_um) = quadrature(section, element_um);
    let stacks = Stacks::new(section, &rays, wavelength_nm)?;
    let crystal =
        section.crystal.as_ref().map(|layer| Crystalline::new(layer, section, wavelength_nm, theta_i));
    let crystal = crystal.transpose()?;
    let w_i = omega(theta_i, phi_i);
    let skies = match shadows {
        Shadows::Ignored => vec![Sky::OPEN; rays.len()],
        Shadows::Cast => skies(&rays),
    };
    let mut lit = Lit { currents: Default::default(), incident_power_um: 0.0, radius_um: 0.0 };
    progress.begin("reflecting", rays.len() as u64);
    for (p, (ray, length)) in rays.iter().zip(&lengths_um).enumerate() {
        step(progress)?;
        lit.radius_um = lit.radius_um.max(ray.x_um.hypot(ray.z_um));
        let normal = DVec3::new(ray.normal[0], 0.0, ray.normal[1]);
        let cos_alpha = normal.dot(w_i);
        if cos_alpha <= 0.0 {
            continue;
        }
        let g = window.at(ray.x_um, section.width_um);
        lit.incident_power_um += g * g * cos_alpha * length;
        if !skies[p].shows(phi_i) {
            continue;
        }
        let phase = Complex64::from_polar(g * length, -k * (w_i.x * ray.x_um + w_i.z * ray.z_um));
        let reflected = match &crystal {
            Some(crystal) => crystal.reflect(ray, phi_i, phase)?,
            None => stacks.reflect(p, normal, illumination, phase)?,
        };
        for (currents, (e, h)) in lit.currents.iter_mut().zip(reflected) {
            let (electric, magnetic) = (cross(normal, &h), cross(-normal, &e));
            currents.push(Current { x_um: ray.x_um, z_um: ray.z_um, electric, magnetic, sky: skies[p] });
        }
    }
    Ok(lit)
}

/// The far field of currents: E = (j/4)·jk·√(2/(πκ))·e^{−jπ/4}·[(1 − ωωᵀ)J̃ − ω × M̃] with J̃ and M̃ the currents' sums
/// over e^{−jκ(x sinφ + z cosφ)}.
fn radiate(
    lit: &Lit,
    illumination: &Illumination,
    azimuths: usize,
    progress: &dyn Progress,
) -> Result<FarField> {
    let theta_i = illumination.theta_i;
    let k = illumination.wave_number_per_um();
    let kappa = k * theta_i.cos();
    let j = Complex64::i();
    let factor = j / 4.0
        * (j * k)
        * (2.0 / (std::f64::consts::PI * kappa)).sqrt()
        * Complex64::from_polar(1.0, -std::f64::consts::FRAC_PI_4);
    let light = illumination.window.light(lit.incident_power_um);
    let scale = light.scale();
    let mut amplitudes: [[Vec<Complex64>; 2]; 2] = Default::default();
    let mut radiated = [0.0; 2];
    let refine = refinement(coefficients(kappa, lit.radius_um), azimuths);
    let fine = Azimuths::UpperHalf(azimuths * refine);
    progress.begin("radiating", (azimuths * refine) as u64);
    for (n, phi_o) in fine.phi_o().into_iter().enumerate() {
        step(progress)?;
        let w_o = omega(-theta_i, phi_o);
        for ((currents, amplitudes), radiated) in lit.currents.iter().zip(&mut amplitudes).zip(&mut radiated)
        {
            let mut electric = [Complex64::ZERO; 3];
            let mut magnetic = [Complex64::ZERO; 3];
            for current in currents.iter().filter(|current| current.sky.shows(phi_o)) {
                let path = current.x_um * phi_o.sin() + current.z_um * phi_o.cos();
                let kernel = Complex64::from_polar(1.0, -kappa * path);
                for axis in 0..3 {
                    electric[axis] += current.electric[axis] * kernel;
                    magnetic[axis] += current.magnetic[axis] * kernel;
                }
            }
            let turned = cross(w_o, &magnetic);
            let far: Field = std::array::from_fn(|axis| factor * scale * (electric[axis] - turned[axis]));
            // The part of J̃ along ω_o has no component along e₁ or e₂.
            let components = [dot(e1(-theta_i, phi_o), &far), dot(e2(phi_o), &far)];
            *radiated += theta_i.cos() * fine.step() * (components[0].norm_sqr() + components[1].norm_sqr());
            if n % refine == refine / 2 {
                amplitudes[0].push(components[0]);
                amplitudes[1].push(components[1]);
            }
        }
    }
    Ok(FarField { light, theta_i, azimuths: Azimuths::UpperHalf(azimuths), amplitudes, radiated })
}

/// One step more, or an error once the user cancelled.
fn step(progress: &dyn Progress) -> Result<()> {
    progress.advance(1);
    if progress.is_cancelled() { Err(Error::interrupted()) } else { Ok(()) }
}

/// Gauss points on the straight pieces of the top, with their lengths.
fn quadrature(section: &Section, element_um: f64) -> (Vec<Ray>, Vec<f64>) {
    let top = section.top();
    let (mut rays, mut lengths) = (Vec::new(), Vec::new());
    for (x, z) in top.x_um.windows(2).zip(top.z_um.windows(2)) {
        let (dx, dz) = (x[1] - x[0], z[1] - z[0]);
        let length = dx.hypot(dz);
        let elements = (length / element_um).ceil().max(1.0);
        for element in 0..elements as usize {
            for side in [-0.5, 0.5] {
                let t = (element as f64 + 0.5 + side / 3f64.sqrt()) / elements;
                rays.push(Ray {
                    x_um: x[0] + t * dx,
                    z_um: z[0] + t * dz,
                    normal: [-dz / length, dx / length],
                });
                lengths.push(length / (2.0 * elements));
            }
        }
    }
    (rays, lengths)
}

/// The stacks under all points at one wavelength.
struct Stacks {
    columns: Columns,
    /// Indices of the columns' palette.
    palette: Vec<Complex64>,
    wavelength_nm: f64,
}

impl Stacks {
    fn new(section: &Section, rays: &[Ray], wavelength_nm: f64) -> Result<Self> {
        let columns = cast(section, rays)?;
        let palette = columns.palette.indices(wavelength_nm)?;
        Ok(Self { columns, palette, wavelength_nm })
    }

    /// The reflected waves at point `p`, for incident fields along e₁ and e₂ of this phase there.
    fn reflect(
        &self,
        p: usize,
        normal: DVec3,
        illumination: &Illumination,
        phase: Complex64,
    ) -> Result<[Wave; 2]> {
        let Illumination { theta_i, phi_i, .. } = *illumination;
        let (w_i, e1, e2) = (omega(theta_i, phi_i), e1(theta_i, phi_i), e2(phi_i));
        let cos_alpha = normal.dot(w_i);
        let [r_s, r_p] = self.reflectances(p, cos_alpha)?;
        let reflected = 2.0 * cos_alpha * normal - w_i;
        let s = normal.cross(w_i).try_normalize().unwrap_or(DVec3::Y);
        Ok([(e1, e2), (e2, -e1)].map(|(electric, magnetic)| {
            let (e_s, h_s) = (r_s * electric.dot(s) * phase, r_p * magnetic.dot(s) * phase);
            // E = E_s ŝ − H_s d × ŝ and H̃ = H_s ŝ + E_s d × ŝ for a wave along d.
            let across = reflected.cross(s);
            (sum(s, e_s, across, -h_s), sum(s, h_s, across, e_s))
        }))
    }

    /// r_s and r_p of the stack under point `p`.
    fn reflectances(&self, p: usize, cos_alpha: f64) -> Result<[Complex64; 2]> {
        let Columns { rays, slots, .. } = self.columns;
        let mut indices = vec![Complex64::ONE];
        let mut thickness_nm = Vec::new();
        for slot in 0..slots {
            indices.push(self.columns.mixture[slot].index(p, &self.palette));
            if slot + 1 < slots {
                thickness_nm.push(self.columns.thickness_um[slot * rays + p] * 1e3);
            }
        }
        let angle = cos_alpha.clamp(0.0, 1.0).acos();
        if !angle.is_finite() {
            return Err(Error::machine("a direction is not finite"));
        }
        Ok([
            reflect(&indices, &thickness_nm, self.wavelength_nm, angle, Polarization::S)?,
            reflect(&indices, &thickness_nm, self.wavelength_nm, angle, Polarization::P)?,
        ])
    }
}

/// A crystal under the top at one wavelength and one θ_i, solved anew for every point.
struct Crystalline<'a> {
    layer: &'a CrystalLayer,
    prepared: PreparedCell,
    theta_i: f64,
    top: &'a Polyline,
    arc_um: Vec<f64>,
}

impl<'a> Crystalline<'a> {
    fn new(layer: &'a CrystalLayer, section: &'a Section, wavelength_nm: f64, theta_i: f64) -> Result<Self> {
        let cell = Cell::new(&layer.lattice, wavelength_nm)?;
        let prepared = solver().prepare(&cell, wavelength_nm, theta_i)?;
        let top = section.top();
        Ok(Self { layer, prepared, theta_i, top, arc_um: top.arc_um() })
    }

    /// All reflected orders at a point, for incident fields along e₁ and e₂ of this phase there.
    fn reflect(&self, ray: &Ray, phi_i: f64, phase: Complex64) -> Result<[Wave; 2]> {
        let [across, up] = ray.normal;
        // The normal's angle against z, clockwise: azimuths in the frame of the top are larger by the slope.
        let slope = (-across).atan2(up);
        let right = self.top.x_um.partition_point(|&x| x <= ray.x_um).clamp(1, self.top.x_um.len() - 1);
        let along = (ray.x_um - self.top.x_um[right - 1]).hypot(ray.z_um - self.top.z_um[right - 1]);
        let s = self.arc_um[right - 1] + along - self.top.arc_at_zero(&self.arc_um) - self.layer.offset_um;
        let regularity = self.layer.regularity.as_ref().map_or(1.0, |regularity| regularity.at(ray.x_um));
        let mut fields = [([Complex64::ZERO; 3], [Complex64::ZERO; 3]); 2];
        for order in self.prepared.respond(phi_i + slope)?.orders {
            let turn = std::f64::consts::TAU * f64::from(order.m) * s / self.layer.lattice.period_um;
            let place = Complex64::from_polar(regularity, turn);
            let phi_o = order.phi_o - slope;
            let (w_o, e1, e2) = (omega(-self.theta_i, phi_o), e1(-self.theta_i, phi_o), e2(phi_o));
            for (q, (electric, magnetic)) in fields.iter_mut().enumerate() {
                let e = sum(e1, order.jones[0][q] * place, e2, order.jones[1][q] * place);
                let turned = cross(w_o, &e);
                for axis in 0..3 {
                    electric[axis] += e[axis];
                    magnetic[axis] += turned[axis];
                }
            }
        }
        Ok(fields.map(|(e, h)| (e.map(|part| part * phase), h.map(|part| part * phase))))
    }
}

fn sum(u: DVec3, a: Complex64, v: DVec3, b: Complex64) -> Field {
    [a * u.x + b * v.x, a * u.y + b * v.y, a * u.z + b * v.z]
}

fn cross(u: DVec3, f: &Field) -> Field {
    [f[2] * u.y - f[1] * u.z, f[0] * u.z - f[2] * u.x, f[1] * u.x - f[0] * u.y]
}

fn dot(u: DVec3, f: &Field) -> Complex64 {
    f[0] * u.x + f[1] * u.y + f[2] * u.z
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rays(height: impl Fn(f64) -> f64) -> Vec<Ray> {
        let ray = |i: i32| {
            let x_um = 0.02 * f64::from(i) - 4.0;
            Ray { x_um, z_um: height(x_um), normal: [0.0, 1.0] }
        };
        (0..=400).map(ray).collect()
    }

    #[test]
    fn the_sky_over_a_point_ends_at_the_highest_line_to_another() {
        let rays = rays(|x| 0.3 * (2.0 * x).sin() + 0.1 * (7.3 * x).cos());
        for (ray, Sky(found)) in rays.iter().zip(skies(&rays)) {
            let Sky(mut steepest) = Sky::OPEN;
            for other in rays.iter().filter(|other| other.x_um != ray.x_um) {
                let slope = (other.z_um - ray.z_um) / (other.x_um - ray.x_um).abs();
                let side = usize::from(other.x_um > ray.x_um);
                steepest[side] = steepest[side].max(slope);
            }
            assert_eq!(found, steepest);
        }
    }

    #[test]
    fn an_arch_hides_only_what_lies_behind_its_own_tangent() {
        let rays = rays(|x| -0.05 * x * x);
        // The ends see nothing of the arch on one side.
        for (ray, sky) in rays.iter().zip(skies(&rays)).skip(1).take(rays.len() - 2) {
            // The tangent's slope, to half a step.
            let slope = -0.1 * ray.x_um;
            for phi in [-1.4, -0.9, 0.0, 0.8, 1.3_f64] {
                let above = phi.cos() - slope * phi.sin();
                if above.abs() > 0.01 {
                    assert_eq!(sky.shows(phi), above > 0.0, "{} {phi}", ray.x_um);
                }
            }
        }
    }
}
