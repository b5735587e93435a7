//! Figures of sections, spectra and materials.

mod angle_law;
mod atlas;
mod atlas_page;
mod diffraction;
mod far_fields;
mod inverse;
mod lobes;
mod section;
mod segment;
mod simulated;
mod spectrum;
mod values;
mod vision;

pub use angle_law::{FollowedPeaks, angle_law};
pub use atlas::{AtlasColours, atlas_map};
pub use atlas_page::{atlas_page, claim_atlas_page, write_atlas_page};
pub use diffraction::{DIRECTIONS, Pattern, diffraction, diffraction_spectrum};
pub use far_fields::{check_far_fields, far_fields};
pub use inverse::inverse;
pub use lobes::{Hemispheres, ParameterMaps, tiled, title};
pub(crate) use section::scale_bar_of;
pub use section::{section, shade};
pub use segment::segment;
pub use simulated::{FieldPatterns, FitCurves, InstancePatterns, NoiseCurves, statistics_of_fits};
pub use spectrum::{Simulated, spectra};
pub use values::{hemisphere_maps, marginals};
pub use vision::{KERATIN_NOTE, Seen, seen, sensitivities};

/// A structure's name as a heading says it: the only variant of a species goes without its name.
#[must_use]
pub fn heading(name: &str) -> String {
    name.replace(":default", "")
}

/// The places of the first, the middle and the last of so many wavelengths.
fn three(count: usize) -> Vec<usize> {
    let mut waves = vec![0, count / 2, count - 1];
    waves.dedup();
    waves
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_read_as_one_would_say_them() {
        assert_eq!(heading("tree-swallow:default"), "tree-swallow");
        assert_eq!(heading("starling:pink 3"), "starling:pink 3");
    }
}
