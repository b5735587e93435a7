//! The colour of a barbule seen along its normals: a quick look, not a simulation.

use crate::film::{Polarization, reflect};
use crate::material::Material;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::structure::{Columns as RayColumns, Ray, Section, cast};
use crate::{Complex64, Result};

/// Layers under one point, from the entry medium to the substrate: indices, and thicknesses in nm.
#[derive(Debug, Default)]
pub(super) struct Column {
    indices: Vec<Complex64>,
    thickness_nm: Vec<f64>,
}

impl Column {
    /// What flat layers like these reflect at normal incidence.
    pub(super) fn reflectance(&self, nm: f64) -> Result<f64> {
        Ok(reflect(&self.indices, &self.thickness_nm, nm, 0.0, Polarization::S)?.norm_sqr())
    }

    /// The same with a layer that is so much thicker.
    pub(super) fn thickened(&self, layer: usize, more_nm: f64) -> Self {
        let mut thickness_nm = self.thickness_nm.clone();
        thickness_nm[layer] += more_nm;
        Self { indices: self.indices.clone(), thickness_nm }
    }

    /// The thickness of a layer, nm.
    pub(super) fn thickness_nm(&self, layer: usize) -> f64 {
        self.thickness_nm[layer]
    }

    /// The layer at a depth in nm, and its index; none in the substrate.
    pub(super) fn layer_at(&self, depth_nm: f64) -> Option<(usize, Complex64)> {
        let mut below = 0.0;
        let layer = self.thickness_nm.iter().position(|thickness| {
            below += thickness;
            below > depth_nm
        })?;
        Some((layer, self.indices[layer + 1]))
    }
}

/// What lies under points of a section's top, along its normals.
pub(super) struct Columns {
    /// The points.
    pub(super) points: Vec<Ray>,
    below: RayColumns,
    entry: Option<Material>,
}

impl Columns {
    /// Under `points` points of the top.
    pub(super) fn under(section: &Section, points: usize) -> Result<Self> {
        let top = section.top();
        let points: Vec<Ray> = (0..points)
            .filter_map(|k| {
                let i = k * top.x_um.len().saturating_sub(1) / points;
                let (dx, dz) = (top.x_um.get(i + 1)? - top.x_um[i], top.z_um.get(i + 1)? - top.z_um[i]);
                let length = libm::hypot(dx, dz);
                let (x_um, z_um) = (top.x_um[i] + 0.5 * dx, top.z_um[i] + 0.5 * dz);
                Some(Ray { x_um, z_um, normal: [-dz / length, dx / length] })
            })
            .collect();
        let below = cast(section, &points)?;
        let outside = section.media.iter().take(1).flat_map(|medium| medium.substances().next());
        let entry = outside.map(|substance| section.material(substance)).next().transpose()?;
        Ok(Self { points, below, entry })
    }

    /// The column of each point at a wavelength.
    pub(super) fn at(&self, nm: f64) -> Result<Vec<Column>> {
        let below = &self.below;
        let palette = below.palette.indices(nm)?;
        let entry = self.entry.as_ref().map_or(Ok(1.0.into()), |material| material.index(nm))?;
        let column = |ray: usize| {
            let mut column = Column::default();
            column.indices.push(entry);
            for slot in 0..below.slots {
                let place = slot * below.rays + ray;
                let thickness = below.thickness_um[place];
                let last = slot + 1 == below.slots;
                if thickness > 0.0 || last {
                    column.indices.push(below.mixture[slot].index(ray, &palette));
                }
                if thickness > 0.0 && !last {
                    column.thickness_nm.push(thickness * 1e3);
                }
            }
            column
        };
        Ok((0..below.rays).map(column).collect())
    }
}

/// The mean over `points` points of the top of what flat layers like those under each would reflect at normal
/// incidence. Incoherent: the shape of the surface plays no part.
///
/// # Errors
/// The section has no top boundary, its first medium absorbs, or a medium has no index at a wavelength.
pub fn normal_reflectance(section: &Section, points: usize, at: &Wavelengths) -> Result<Spectrum> {
    let columns = Columns::under(section, points)?;
    let mut values = Vec::with_capacity(at.len());
    for &nm in at.nm() {
        let columns = columns.at(nm)?;
        let mut sum = 0.0;
        for column in &columns {
            sum += column.reflectance(nm)?;
        }
        values.push(sum / columns.len().max(1) as f64);
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
