//! Surfaces of several kinds, chosen from place to place by a picture.

use super::Surface;
use super::texture::{NumberMap, Texture};
use crate::{Error, Result};

/// A map of its surfaces.
#[derive(Debug, Clone)]
pub struct SurfaceMap {
    picture: NumberMap,
    surfaces: Vec<Surface>,
}

impl SurfaceMap {
    /// From a grey picture.
    ///
    /// # Errors
    /// No surface, one that is a map itself, or as [`NumberMap::new`].
    pub fn new(picture: Texture, surfaces: Vec<Surface>) -> Result<Self> {
        if surfaces.iter().any(|surface| matches!(surface, Surface::Map(_))) {
            return Err(Error::input("a map chooses among surfaces that are no maps themselves"));
        }
        Ok(Self { picture: NumberMap::new(picture, surfaces.len(), "surfaces")?, surfaces })
    }

    /// What is at texture coordinates.
    #[inline]
    pub(super) fn at(&self, uv: [f64; 2]) -> &Surface {
        &self.surfaces[self.picture.at(uv)]
    }

    /// All of them.
    pub(super) fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::bsdf::{Dielectric, Hit, Lambertian, Pictures};
    use crate::spectrum::dense::Lambdas;

    fn picture(values: &[u8]) -> Texture {
        let texels = values.iter().map(|v| [f32::from(*v) / 255.0; 3]).collect();
        Texture::new([values.len(), 1], texels).unwrap()
    }

    fn painted(grey: f64, alpha: Option<Texture>) -> Surface {
        let pictures = Pictures { alpha, ..Pictures::default() };
        Surface::Lambertian(Lambertian::painted([grey; 3], pictures).unwrap())
    }

    #[test]
    fn pixels_choose_without_passing_over() {
        let holes = Texture::new([1, 1], vec![[0.25; 3]]).unwrap();
        let surfaces = vec![painted(0.2, None), painted(0.8, None), painted(1.0, Some(holes))];
        let map = Surface::Map(SurfaceMap::new(picture(&[0, 1, 2, 1]), surfaces).unwrap());
        assert!(!map.is_opaque());
        for (u, grey, opacity) in
            [(0.1, 0.2, 1.0), (0.249, 0.2, 1.0), (0.251, 0.8, 1.0), (0.6, 1.0, 0.25), (-0.01, 0.8, 1.0)]
        {
            let hit = Hit { uv: [u, 0.5], ..Hit::default() };
            let f = map.bind(&hit, DVec3::Z, Lambdas::splat(550.0)).eval(DVec3::Z).f[0];
            assert!((f * std::f64::consts::PI - grey).abs() < 1e-9, "{u}: {f}");
            assert_eq!(map.opacity(&hit, DVec3::NEG_Z, DVec3::Z), opacity);
        }
    }

    #[test]
    fn pixels_without_a_surface_are_refused() {
        let two = || vec![painted(0.2, None), Surface::Dielectric(Dielectric::new(1.5).unwrap())];
        let message = |map: Result<SurfaceMap>| map.unwrap_err().to_string();
        assert!(
            message(SurfaceMap::new(picture(&[0, 2]), two())).contains("value 2 (of 255), but the map has 2")
        );
        let colour = Texture::new([1, 1], vec![[0.0, 0.0, 1.0 / 255.0]]).unwrap();
        assert!(message(SurfaceMap::new(colour, two())).contains("not grey"));
        let map = SurfaceMap::new(picture(&[1]), two()).unwrap();
        assert!(
            message(SurfaceMap::new(picture(&[0]), vec![Surface::Map(map)])).contains("no maps themselves")
        );
    }
}
