//! Names from which individuals are drawn: on the processor as the renderer has them, and as words for shaders.

use barbule_appearance::bsdf::{Hit, Layout};
use barbule_base::math::rng::split_mix;
use glam::DVec3;

/// The low and the high word of a name.
pub(super) fn words_of(name: u64) -> [u32; 2] {
    [name as u32, (name >> 32) as u32]
}

/// The name of a shape that stands in a place: of its own and the place's.
#[must_use]
pub fn name_at(shape: u64, place: u64) -> u64 {
    split_mix(shape ^ split_mix(place))
}

/// The name from which the cell of a barbule draws its individual: `name` is the barbule's, `place` the distance along it in cells.
#[must_use]
pub fn ribbon_instance(name: u64, place: f64) -> u64 {
    split_mix(name ^ split_mix(place.floor() as u64))
}

/// The same where barbules lie side by side on a surface of this name, at texture coordinates (u, v).
#[must_use]
pub fn clad_instance(layout: &Layout, name: u64, uv: [f64; 2]) -> u64 {
    // The names follow from the coordinates alone; any frame serves.
    let hit = Hit { uv, uv_gradients: [DVec3::Y, DVec3::X], id: name, ..Hit::default() };
    layout.on_barbule(&hit).instance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_names_of_their_own_and_places_within_one_share_it() {
        assert_eq!(ribbon_instance(5, 2.1), ribbon_instance(5, 2.9));
        assert_ne!(ribbon_instance(5, 2.9), ribbon_instance(5, 3.0));
        assert_ne!(ribbon_instance(5, 2.1), ribbon_instance(6, 2.1));
        let name = 0x0123_4567_89ab_cdef;
        assert_eq!(words_of(name), [0x89ab_cdef, 0x0123_4567]);
    }
}
