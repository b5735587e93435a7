//! Pictures of a surface's relief, which shades it and leaves its shape.

use glam::DVec3;

use super::frame::Frame;
use super::hit::Hit;
use super::texture::Texture;

/// How a surface's shading normal leans from place to place.
#[derive(Debug, Clone)]
pub enum Relief {
    /// Normals about the shading frame, from −1 … 1 in 0 … 1: x to the right of the picture, y upwards, z out of the surface.
    Normals(Texture),
    /// Heights over the surface, the picture's mean.
    Heights {
        /// The picture.
        picture: Texture,
        /// Height where it is white, mm; black is 0.
        white_mm: f64,
    },
}

impl Relief {
    /// A hit with the shading normal that it has here. The normal of a height h over a surface with the normal n is n − ∇h
    /// (Blinn, *Simulation of wrinkled surfaces*, SIGGRAPH 1978).
    #[inline]
    pub(super) fn bent(&self, hit: &Hit) -> Hit {
        let z = hit.frame.z;
        let normal = match self {
            Self::Normals(picture) => {
                hit.frame.to_world(DVec3::from(picture.at(hit.uv)) * 2.0 - DVec3::ONE).normalize_or(z)
            }
            Self::Heights { picture, white_mm } => {
                let [along_u, along_v] = picture.slopes(hit.uv);
                let gradient = (hit.uv_gradients[0] * along_u + hit.uv_gradients[1] * along_v) * *white_mm;
                (z - (gradient - z * z.dot(gradient))).normalize()
            }
        };
        Hit { frame: Frame::new(normal, hit.frame.y), ..*hit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heights that rise evenly lean the normal by their angle, whichever way the texture lies on the surface.
    #[test]
    fn an_even_slope_leans_the_normal_by_its_angle() {
        let ramp: Vec<[f32; 3]> = (0..64).map(|i| [i as f32 / 64.0; 3]).collect();
        let picture = Texture::new([64, 1], ramp).unwrap();
        // A picture 2 mm wide that rises by 1.5 mm.
        let relief = Relief::Heights { picture, white_mm: 1.5 };
        for (u, v) in [(DVec3::X, DVec3::Y), (DVec3::NEG_Y, DVec3::X), (DVec3::new(0.6, 0.8, 0.0), DVec3::Y)]
        {
            let hit = Hit { uv: [0.4, 0.3], uv_gradients: [u * 0.5, v * 0.5], ..Hit::default() };
            let expected = (DVec3::Z - 0.75 * u).normalize();
            assert!((relief.bent(&hit).frame.z - expected).length() < 1e-6);
        }
        let flat = Hit { uv: [0.4, 0.3], ..Hit::default() };
        assert_eq!(relief.bent(&flat).frame.z, DVec3::Z);
    }
}
