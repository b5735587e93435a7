//! The fast simulation's formulas, evaluated plainly: its reference.
//!
//! One loop over points, one over azimuths, vectors in three dimensions, reflectances from [`film`](super::film), crystals
//! solved for every point. Slow on purpose: no tables, no transforms, no matrix products, no vector instructions.

use glam::DVec3;
use num_complex::Complex64;

use super::crystal::multipole::Prepared;
use super::crystal::{Cell, Multipole};
use super::film::{Polarization, reflect};
use super::surface::{Cone, FarField, Window, inverse_root, refinement};
use crate::scattering::directions::{azimuths as azimuth_grid, e1, e2, omega};
use crate::structure::{Columns, CrystalLayer, Polyline, Ray, Section, cast};
use crate::{Error, Result};

/// A complex 3-vector.
type Field = [Complex64; 3];

/// Evaluates the far field by Gauss's two-point rule on elements of at most `element_um`; arguments and result as for
/// [`surface::far_field`](super::surface::far_field).
///
/// # Errors
/// As [`cast`] and [`Section::check_lit_through_air`], or a medium's table does not reach the wavelength.
pub fn far_field(
    section: &Section,
    window: Window,
    element_um: f64,
    wavelength_nm: f64,
    theta_i: f64,
    phi_i: f64,
    azimuths: usize,
) -> Result<FarField> {
    section.check_lit_through_air()?;
    let k = std::f64::consts::TAU / (wavelength_nm * 1e-3);
    let (rays, lengths) = quadrature(section, element_um);
    let columns = cast(section, &rays)?;
    let palette = columns.palette.iter().map(|m| m.index(wavelength_nm)).collect::<Result<Vec<_>>>()?;
    let w_i = omega(theta_i, phi_i);
    let incident = [(e1(theta_i, phi_i), e2(phi_i)), (e2(phi_i), -e1(theta_i, phi_i))];
    let crystal =
        section.crystal.as_ref().map(|layer| Crystalline::new(layer, section, wavelength_nm, theta_i));
    let crystal = crystal.transpose()?;
    let mut incident_power_um = 0.0;
    // Currents with their positions, per incident polarization.
    let mut currents: [Vec<(f64, f64, Field, Field)>; 2] = Default::default();
    for (p, (ray, length)) in rays.iter().zip(&lengths).enumerate() {
        let normal = DVec3::new(ray.normal[0], 0.0, ray.normal[1]);
        let cos_alpha = normal.dot(w_i);
        if cos_alpha <= 0.0 {
            continue;
        }
        let g = match window {
            Window::Gaussian => (-(ray.x_um / (section.width_um / 4.0)).powi(2)).exp(),
            Window::None => 1.0,
        };
        incident_power_um += g * g * cos_alpha * length;
        let phase = Complex64::from_polar(g * length, -k * (w_i.x * ray.x_um + w_i.z * ray.z_um));
        if let Some(crystal) = &crystal {
            for (polarization, (e, h)) in crystal.reflect(ray, phi_i)?.into_iter().enumerate() {
                let [e, h] = [e, h].map(|field| field.map(|part| part * phase));
                currents[polarization].push((ray.x_um, ray.z_um, cross(normal, &h), cross(-normal, &e)));
            }
            continue;
        }
        let [r_s, r_p] = reflectances(&columns, &palette, p, wavelength_nm, cos_alpha)?;
        let reflected = 2.0 * cos_alpha * normal - w_i;
        let s = normal.cross(w_i).try_normalize().unwrap_or(DVec3::Y);
        for (polarization, (electric, magnetic)) in incident.iter().enumerate() {
            let (e_s, h_s) = (r_s * electric.dot(s) * phase, r_p * magnetic.dot(s) * phase);
            // E = E_s ŝ − H_s d × ŝ and H̃ = H_s ŝ + E_s d × ŝ for a wave along d.
            let across = reflected.cross(s);
            let e = sum(s, e_s, across, -h_s);
            let h = sum(s, h_s, across, e_s);
            currents[polarization].push((ray.x_um, ray.z_um, cross(normal, &h), cross(-normal, &e)));
        }
    }
    let mut fields: [[Vec<Complex64>; 2]; 2] = Default::default();
    let kappa = k * theta_i.cos();
    let j = Complex64::i();
    let factor = j / 4.0
        * (j * k)
        * (2.0 / (std::f64::consts::PI * kappa)).sqrt()
        * Complex64::from_polar(1.0, -std::f64::consts::FRAC_PI_4);
    let radius_um = rays.iter().fold(0f64, |r, ray| r.max(ray.x_um.hypot(ray.z_um)));
    let refine = refinement(&Cone::new(k, theta_i, radius_um), azimuths);
    let scale = match window {
        Window::Gaussian => inverse_root(incident_power_um),
        Window::None => 1.0,
    };
    let mut reflected = [0.0; 2];
    let step = std::f64::consts::PI / (azimuths * refine) as f64;
    for (n, phi_o) in azimuth_grid(azimuths * refine).enumerate() {
        let w_o = omega(-theta_i, phi_o);
        for ((currents, fields), reflected) in currents.iter().zip(&mut fields).zip(&mut reflected) {
            let mut electric = [Complex64::ZERO; 3];
            let mut magnetic = [Complex64::ZERO; 3];
            for (x, z, current, magnetic_current) in currents {
                let kernel = Complex64::from_polar(1.0, -kappa * (x * phi_o.sin() + z * phi_o.cos()));
                for axis in 0..3 {
                    electric[axis] += current[axis] * kernel;
                    magnetic[axis] += magnetic_current[axis] * kernel;
                }
            }
            let turned = cross(w_o, &magnetic);
            let far: Field = std::array::from_fn(|axis| factor * scale * (electric[axis] - turned[axis]));
            // The part of J̃ along ω_o has no component along e₁ or e₂.
            let components = [dot(e1(-theta_i, phi_o), &far), dot(e2(phi_o), &far)];
            *reflected += theta_i.cos() * step * (components[0].norm_sqr() + components[1].norm_sqr());
            if n % refine == refine / 2 {
                fields[0].push(components[0]);
                fields[1].push(components[1]);
            }
        }
    }
    Ok(FarField {
        phi_o: azimuth_grid(azimuths).collect(),
        fields,
        incident_power_um: (window == Window::Gaussian).then_some(incident_power_um),
        reflected,
        cos_theta: theta_i.cos(),
    })
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

/// r_s and r_p of the stack under ray `p`.
fn reflectances(
    columns: &Columns,
    palette: &[Complex64],
    p: usize,
    wavelength_nm: f64,
    cos_alpha: f64,
) -> Result<[Complex64; 2]> {
    let rays = columns.rays;
    let mut indices = vec![Complex64::ONE];
    let mut thickness_nm = Vec::new();
    for slot in 0..columns.slots {
        let m = columns.mixture[slot * rays + p];
        let (a, b) = (palette[usize::from(m.a)], palette[usize::from(m.b)]);
        indices.push(a * (1.0 - m.fraction) + b * m.fraction);
        if slot + 1 < columns.slots {
            thickness_nm.push(columns.thickness_um[slot * rays + p] * 1e3);
        }
    }
    let angle = cos_alpha.clamp(0.0, 1.0).acos();
    if !angle.is_finite() {
        return Err(Error::machine("a direction is not finite"));
    }
    Ok([
        reflect(&indices, &thickness_nm, wavelength_nm, angle, Polarization::S)?,
        reflect(&indices, &thickness_nm, wavelength_nm, angle, Polarization::P)?,
    ])
}

/// A crystal under the top at one wavelength and one θ_i, solved anew for every point.
struct Crystalline<'a> {
    layer: &'a CrystalLayer,
    prepared: Prepared,
    theta_i: f64,
    top: &'a Polyline,
    arc_um: Vec<f64>,
}

impl<'a> Crystalline<'a> {
    fn new(layer: &'a CrystalLayer, section: &'a Section, wavelength_nm: f64, theta_i: f64) -> Result<Self> {
        let cell = Cell::new(&layer.lattice, wavelength_nm)?;
        let prepared = Multipole::default().prepare(&cell, wavelength_nm, theta_i)?;
        let top = section.top();
        Ok(Self { layer, prepared, theta_i, top, arc_um: top.arc_um() })
    }

    /// E and H̃ of all reflected orders at a point, for incident fields along e₁ and e₂ with phase 0 there.
    fn reflect(&self, ray: &Ray, phi_i: f64) -> Result<[(Field, Field); 2]> {
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
            let phase = Complex64::from_polar(regularity, turn);
            let phi_o = order.phi_o - slope;
            let (w_o, e1, e2) = (omega(-self.theta_i, phi_o), e1(-self.theta_i, phi_o), e2(phi_o));
            for (q, (electric, magnetic)) in fields.iter_mut().enumerate() {
                let e = sum(e1, order.jones[0][q] * phase, e2, order.jones[1][q] * phase);
                let turned = cross(w_o, &e);
                for axis in 0..3 {
                    electric[axis] += e[axis];
                    magnetic[axis] += turned[axis];
                }
            }
        }
        Ok(fields)
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
