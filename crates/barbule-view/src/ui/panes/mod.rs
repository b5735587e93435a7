//! The linked views: sliders of the structure, its reflectance, its colour against the angle, its lobe, its section, and how it
//! differs from what is pinned.
//!
//! Each is a function that draws into an `egui::Ui`, reads what is open and what has been computed of it, remembers in [`Memory`] what
//! concerns the drawing alone, and pushes what people do there as [`Action`](super::Action)s.

mod angles;
mod comparison;
mod layers;
mod lobe;
mod section;
mod seen;
mod sliders;
mod spectrum;
mod style;
#[cfg(test)]
mod tests;
mod words;

pub use angles::angles;
pub use comparison::comparison;
pub use lobe::lobe;
pub use section::section;
pub use sliders::sliders;
pub use spectrum::spectrum;

/// What the views remember from one frame to the next: what they have made of results, and where they were touched.
#[derive(Default)]
pub struct Memory {
    viewer: seen::Eyes,
    seen: [seen::Kept; 2],
    along: [angles::Kept; 2],
    measured: spectrum::Kept,
    compared: comparison::Kept,
    sliders: sliders::Kept,
    lobe: lobe::Kept,
    section: section::Kept,
}

impl Memory {
    /// The direction on the lobe that people keep looking at, as a place of its disc; none: the mirror's.
    #[must_use]
    pub fn kept_direction(&self) -> Option<[f64; 2]> {
        self.lobe.place
    }
}

/// Something that is made anew only where what it is made of has changed.
struct Once<K, V>(Option<(K, V)>);

impl<K, V> Default for Once<K, V> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq + Clone, V> Once<K, V> {
    fn of(&mut self, key: &K, make: impl FnOnce(&K) -> V) -> &V {
        if self.0.as_ref().is_some_and(|(known, _)| known != key) {
            self.0 = None;
        }
        let (_, value) = self.0.get_or_insert_with(|| (key.clone(), make(key)));
        value
    }
}
