//! How a stage is looked at.

use barbule_appearance::scene::description::ToneWord;
use glam::{DMat3, DVec3, Mat4, Vec3};

use super::Jitter;
use crate::gpu::{Cells, Exposure, Eye, View};

/// Camera, light and exposure.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// What the camera looks at, mm.
    pub target_mm: DVec3,
    /// Unit vector upwards in its picture.
    pub up: DVec3,
    /// Unit vector from the target towards it.
    pub towards: DVec3,
    /// Width of the picture at the target, mm.
    pub width_mm: f64,
    /// How far the camera is from its target, in such widths.
    pub distance: f64,
    /// Unit vector towards the lamp.
    pub to_lamp: DVec3,
    /// The lamp's angular radius, rad.
    pub lamp_radius: f64,
    /// What a white surface that faces the lamp shines.
    pub lamp: f64,
    /// Linear sRGB of the sky's radiance.
    pub sky: [f32; 3],
    /// Share of the contrast of individuals that is shown: 0 for the smooth mean, 1 for all.
    pub contrast: f32,
    /// Stops of exposure beside what the stage's meter says: each doubles the light.
    pub stops: f32,
    /// The curve.
    pub tone: ToneWord,
    /// Linear sRGB on the screen behind everything.
    pub behind: [f32; 3],
}

impl Look {
    /// How the film is shown; `metered` stops are the meter's.
    pub(super) fn exposure(&self, metered: f32) -> Exposure {
        Exposure { stops: self.stops + metered, tone: self.tone, behind: self.behind }
    }

    /// Whether a film of another look is one of this too, however it is shown.
    pub(super) fn is_lit_as(&self, other: &Self) -> bool {
        let shown =
            |look: &Self| Self { stops: 0.0, tone: ToneWord::Plain, behind: [0.0; 3], ..look.clone() };
        shown(self) == shown(other)
    }

    /// From the scene, mm, to the picture of this many columns and rows; `radius_mm`: how far the scene reaches from the origin.
    #[must_use]
    pub fn clip_from_scene(&self, [width, height]: [u32; 2], radius_mm: f64) -> Mat4 {
        let eye = self.eye_mm();
        let turn = DMat3::from_cols(self.up.cross(self.towards), self.up, self.towards).transpose();
        let view = Mat4::from_mat3(turn.as_mat3()) * Mat4::from_translation(-eye.as_vec3());
        let away = self.distance * self.width_mm;
        let far = eye.length() + radius_mm;
        let near = (eye.length() - radius_mm).max(0.05 * away);
        // The half width at the distance of 1.
        let half = 0.5 / self.distance;
        let scale = near * half;
        let tall = scale * f64::from(height) / f64::from(width.max(1));
        let [x, y] = [scale, tall].map(|v| v as f32);
        let (near, far) = (near as f32, (far.max(1.01 * near)) as f32);
        frustum(x, y, near, far) * view
    }

    /// Where the camera is, mm.
    #[must_use]
    pub fn eye_mm(&self) -> DVec3 {
        self.target_mm + self.towards * (self.distance * self.width_mm)
    }

    pub(super) fn view(&self, size: [u32; 2], jitter: &Jitter, radius_mm: f64, cells: Cells) -> View {
        // Before the division by w, which it so outlasts.
        let shift = Mat4::from_translation(Vec3::new(jitter.clip.x, jitter.clip.y, 0.0));
        let lamp = self.to_lamp.normalize_or(DVec3::Z);
        let (across, along) = lamp.any_orthonormal_pair();
        let [x, y] = jitter.lamp.as_dvec2().to_array();
        let to_lamp = lamp + (across * x + along * y) * self.lamp_radius.sin();
        View {
            clip_from_scene: shift * self.clip_from_scene(size, radius_mm),
            eye: Eye::At(self.eye_mm().as_vec3()),
            to_lamp: to_lamp.normalize().as_vec3(),
            lamp: self.lamp as f32,
            sky: self.sky,
            contrast: self.contrast,
            cells,
        }
    }
}

/// A symmetric frustum with depths from 0 to 1, for cameras that look along −z.
fn frustum(x: f32, y: f32, near: f32, far: f32) -> Mat4 {
    let depth = far / (near - far);
    Mat4::from_cols_array(&[
        near / x,
        0.0,
        0.0,
        0.0,
        0.0,
        near / y,
        0.0,
        0.0,
        0.0,
        0.0,
        depth,
        -1.0,
        0.0,
        0.0,
        near * depth,
        0.0,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look() -> Look {
        Look {
            target_mm: DVec3::new(1.0, 2.0, 0.0),
            up: DVec3::Y,
            towards: DVec3::Z,
            width_mm: 10.0,
            distance: 4.0,
            to_lamp: DVec3::Z,
            lamp_radius: 0.1,
            lamp: 1.0,
            sky: [0.1; 3],
            contrast: 1.0,
            stops: 0.0,
            tone: ToneWord::Filmic,
            behind: [0.0; 3],
        }
    }

    /// The picture is as wide at the target as it says, its upper edge as far as its shape has it, and depths are within 0 and 1.
    #[test]
    fn what_is_at_the_edges_lands_on_the_edges() {
        let clip = look().clip_from_scene([200, 100], 20.0);
        for (place, x, y) in [([1.0, 2.0], 0.0, 0.0), ([6.0, 2.0], 1.0, 0.0), ([1.0, 4.5], 0.0, 1.0)] {
            let at = clip.project_point3(Vec3::new(place[0], place[1], 0.0));
            assert!((at.x - x).abs() < 1e-5 && (at.y - y).abs() < 1e-5 && (0.0..1.0).contains(&at.z), "{at}");
        }
        let jitter = Jitter { clip: glam::Vec2::new(0.01, -0.02), lamp: glam::Vec2::ZERO };
        let moved = look().view([200, 100], &jitter, 20.0, Cells::OfRibbons).clip_from_scene;
        let at = moved.project_point3(Vec3::new(1.0, 2.0, 3.0));
        assert!((at.x - 0.01).abs() < 1e-5 && (at.y + 0.02).abs() < 1e-5, "{at}");
    }

    #[test]
    fn the_exposure_is_not_part_of_the_film() {
        let brighter = Look { stops: 1.0, tone: ToneWord::Plain, ..look() };
        assert!(look().is_lit_as(&brighter));
        assert!(!look().is_lit_as(&Look { lamp: 2.0, ..look() }));
    }
}
