//! Windows onto sections: what is shown of them, to scale.

use barbule::structure::{Polyline, Section};

/// What is shown below a crystal, as a part of its depth.
const BELOW_CRYSTAL: f64 = 0.15;
/// Flat layers are shown at least so tall, µm.
const LEAST_LAYERS_UM: f64 = 0.2;
/// A flat section is shown so tall at least, as a part of its width.
const LEAST_TALL: f64 = 0.04;
/// What is looked at from near is so wide: a part of the section, and no more than this, µm.
const NEAR_PART: f64 = 0.2;
const NEAR_UM: f64 = 4.0;

/// A part of the plane of a section, µm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Its left end.
    pub left: f64,
    /// Its right end.
    pub right: f64,
    /// Its lower end.
    pub bottom: f64,
    /// Its upper end.
    pub top: f64,
}

impl Window {
    /// Its width and height, µm.
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        [self.right - self.left, self.top - self.bottom]
    }

    /// The least window of this shape (width over height) about the same middle that holds it and a margin, a part of it.
    #[must_use]
    pub fn fitted(&self, shape: f64, margin: f64) -> Self {
        let [wide, tall] = self.size().map(|length| length * (1.0 + 2.0 * margin));
        let tall = tall.max(wide / shape);
        self.about([0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top)], [tall * shape, tall])
    }

    /// It with another shape (width over height), about the same middle and as wide.
    #[must_use]
    pub fn shaped(&self, shape: f64) -> Self {
        let wide = self.size()[0];
        self.about([0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top)], [wide, wide / shape])
    }

    fn about(&self, [x, z]: [f64; 2], [wide, tall]: [f64; 2]) -> Self {
        Self { left: x - 0.5 * wide, right: x + 0.5 * wide, bottom: z - 0.5 * tall, top: z + 0.5 * tall }
    }

    /// It made larger by a factor about one of its places, each part of it from its upper left corner.
    #[must_use]
    pub fn zoomed(&self, factor: f64, [across, down]: [f64; 2]) -> Self {
        let [wide, tall] = self.size();
        let (x, z) = (self.left + across * wide, self.top - down * tall);
        Self {
            left: x - across * wide * factor,
            right: x + (1.0 - across) * wide * factor,
            bottom: z - (1.0 - down) * tall * factor,
            top: z + down * tall * factor,
        }
    }

    /// It moved by parts of its width to the right and of its height downwards.
    #[must_use]
    pub fn moved(&self, [across, down]: [f64; 2]) -> Self {
        let [wide, tall] = self.size();
        let (x, z) = (across * wide, -down * tall);
        Self { left: self.left + x, right: self.right + x, bottom: self.bottom + z, top: self.top + z }
    }
}

/// What a section takes up, µm; of a crystal the rods that hang on its top as well.
#[must_use]
pub fn extent(section: &Section) -> Window {
    let mut all = Window {
        left: f64::INFINITY,
        right: f64::NEG_INFINITY,
        bottom: f64::INFINITY,
        top: f64::NEG_INFINITY,
    };
    let mut cover = |curve: &Polyline| {
        for (&x, &z) in curve.x_um.iter().zip(&curve.z_um) {
            (all.left, all.right) = (all.left.min(x), all.right.max(x));
            (all.bottom, all.top) = (all.bottom.min(z), all.top.max(z));
        }
    };
    section.boundaries.iter().for_each(&mut cover);
    section.inclusions.iter().for_each(|inclusion| cover(&inclusion.outline.corners()));
    let deep = section.crystal.as_ref().map_or(0.0, |crystal| crystal.lattice.bottom_um());
    all.bottom -= deep * (1.0 + BELOW_CRYSTAL);
    let least = LEAST_TALL * (all.right - all.left);
    if all.top - all.bottom < least {
        (all.bottom, all.top) = (all.bottom - least, all.top + least);
    }
    all
}

/// What is shown of a section at first, in a window of this shape (width over height): all of it, or of flat layers, which go on to
/// both sides, all of these.
#[must_use]
pub fn first_window(section: &Section, shape: f64) -> Window {
    let is_flat = |curve: &Polyline| curve.z_um.iter().all(|z| *z == curve.z_um[0]);
    let all_flat = section.boundaries.iter().all(is_flat) && !section.boundaries.is_empty();
    if !all_flat || section.crystal.is_some() || !section.inclusions.is_empty() {
        return extent(section).fitted(shape, 0.02);
    }
    let heights = || section.boundaries.iter().map(|curve| curve.z_um[0]);
    let (bottom, top) =
        (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    let tall = (top - bottom).max(LEAST_LAYERS_UM);
    let middle = 0.5 * (bottom + top);
    let layers = Window { left: 0.0, right: 0.0, bottom: middle - 0.5 * tall, top: middle + 0.5 * tall };
    layers.fitted(shape, 0.15)
}

/// What is shown of a section from near: its layers or rods under the middle of the top.
#[must_use]
pub fn near_window(section: &Section, shape: f64) -> Window {
    let all = first_window(section, shape);
    let whole = extent(section);
    let top = section.top();
    if top.x_um.is_empty() {
        return all;
    }
    let wide = (NEAR_PART * (whole.right - whole.left)).min(NEAR_UM).min(all.size()[0]);
    let x = 0.5 * (whole.left + whole.right);
    let tall = wide / shape;
    let high = top.height(x) + 0.1 * tall;
    Window { left: x - 0.5 * wide, right: x + 0.5 * wide, bottom: high - tall, top: high }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::structure::Structure;

    const WINDOW: Window = Window { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };

    fn flat(text: &str) -> Section {
        Structure::flat(text).unwrap().instance(1, 0).unwrap()
    }

    #[test]
    fn windows_are_zoomed_about_a_place_and_moved() {
        let zoomed = WINDOW.zoomed(0.5, [0.25, 0.5]);
        assert_eq!((zoomed.left, zoomed.right), (-0.75, 0.25));
        assert_eq!((zoomed.bottom, zoomed.top), (-0.5, 0.5));
        let moved = WINDOW.moved([0.5, 0.25]);
        assert_eq!((moved.left, moved.right, moved.bottom, moved.top), (0.0, 2.0, -1.5, 0.5));
        let layers = first_window(&flat("air/keratin:500/melanin:500/air"), 2.0);
        assert!((layers.size()[1] - 1.3).abs() < 1e-9 && (layers.size()[0] - 2.6).abs() < 1e-9);
        assert!((layers.top - 0.15).abs() < 1e-9, "{layers:?}");
        assert!((first_window(&flat("air/keratin"), 2.0).size()[1] - 0.26).abs() < 1e-9);
        let near = near_window(&flat("air/keratin:500/melanin:500/air"), 2.0);
        assert!(near.size()[0] <= 2.6 + 1e-9 && near.top > 0.0 && near.bottom < -0.5);
        let starling = Structure::builtin("starling").unwrap().instance(1, 0).unwrap();
        assert!(first_window(&starling, 2.0).size()[0] > starling.width_um);
        let near = near_window(&starling, 2.0);
        assert!(near.size()[0] < 5.1 && (near.size()[0] / near.size()[1] - 2.0).abs() < 1e-9, "{near:?}");
        let shaped = WINDOW.shaped(4.0);
        assert_eq!((shaped.size(), shaped.top), ([2.0, 0.5], 0.25));
        let fitted = WINDOW.fitted(4.0, 0.0);
        assert_eq!((fitted.size(), fitted.top), ([8.0, 2.0], 1.0));
    }
}
