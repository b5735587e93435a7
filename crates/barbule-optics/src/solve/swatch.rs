//! The colour of a barbule seen along its normals: a quick look, not a simulation.

use crate::film::{Polarization, reflect};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::structure::{Ray, Section, cast};
use crate::{Complex64, Result};

/// Layers under one point, from the entry medium to the substrate: indices, and thicknesses in nm.
#[derive(Debug, Default)]
struct Column {
    indices: Vec<Complex64>,
    thickness_nm: Vec<f64>,
}

/// The mean over `points` points of the top of what flat layers like those under each would reflect at normal
/// incidence. Incoherent: the shape of the surface plays no part.
///
/// # Errors
/// The section has no top boundary, its first medium absorbs, or a medium has no index at a wavelength.
pub fn normal_reflectance(section: &Section, points: usize, at: &Wavelengths) -> Result<Spectrum> {
    let top = section.top();
    let rays: Vec<Ray> = (0..points)
        .filter_map(|k| {
            let i = k * top.x_um.len().saturating_sub(1) / points;
            let (dx, dz) = (top.x_um.get(i + 1)? - top.x_um[i], top.z_um.get(i + 1)? - top.z_um[i]);
            let length = libm::hypot(dx, dz);
            let (x_um, z_um) = (top.x_um[i] + 0.5 * dx, top.z_um[i] + 0.5 * dz);
            Some(Ray { x_um, z_um, normal: [-dz / length, dx / length] })
        })
        .collect();
    let columns = cast(section, &rays)?;
    let outside = section.media.iter().take(1).flat_map(|medium| medium.substances().next());
    let outside = outside.map(|substance| section.material(substance)).next().transpose()?;
    let mut values = Vec::with_capacity(at.len());
    for &nm in at.nm() {
        let palette =
            columns.palette.iter().map(|material| material.index(nm)).collect::<Result<Vec<_>>>()?;
        let entry = outside.as_ref().map_or(Ok(1.0.into()), |material| material.index(nm))?;
        let mut sum = 0.0;
        for ray in 0..columns.rays {
            let mut column = Column::default();
            column.indices.push(entry);
            for slot in 0..columns.slots {
                let place = slot * columns.rays + ray;
                let (mixture, thickness) = (columns.mixture[slot].at(ray), columns.thickness_um[place]);
                let last = slot + 1 == columns.slots;
                if thickness > 0.0 || last {
                    let (a, b) = (palette[usize::from(mixture.a)], palette[usize::from(mixture.b)]);
                    column.indices.push(a * (1.0 - mixture.fraction) + b * mixture.fraction);
                }
                if thickness > 0.0 && !last {
                    column.thickness_nm.push(thickness * 1e3);
                }
            }
            sum += reflect(&column.indices, &column.thickness_nm, nm, 0.0, Polarization::S)?.norm_sqr();
        }
        values.push(sum / columns.rays.max(1) as f64);
    }
    Spectrum::new(at.clone(), values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film;
    use crate::material::Library;
    use crate::stack::Stack;

    #[test]
    fn a_flat_section_reflects_as_its_stack() {
        let text = "air/keratin:400/melanin:100/mix(keratin,melanin,0.3)";
        let stack = Stack::parse(text, &Library::builtin()).unwrap();
        let section = Section::flat(text, &stack, Library::builtin()).unwrap();
        let at = Wavelengths::new(vec![450.0, 600.0]).unwrap();
        let found = normal_reflectance(&section, 5, &at).unwrap();
        for (&nm, value) in at.nm().iter().zip(found.values()) {
            let exact = film::response(&stack, nm, 0.0, Polarization::S).unwrap().reflected;
            assert!((value - exact).abs() < 1e-12, "{value} {exact}");
        }
    }
}
