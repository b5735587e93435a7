//! A section as closed curves, each between two regions.

use super::section::{Loop, Medium, Section};

/// One closed curve of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour<'a> {
    /// Where it stands in the section, as `inclusions[3].holes[0]`.
    pub place: String,
    /// The curve.
    pub outline: &'a Loop,
    /// The innermost contour around it; `None`: the layers', or the outside.
    pub parent: Option<usize>,
    /// What lies directly inside it.
    pub medium: &'a Medium,
}

impl Section {
    /// All closed curves; parents are numbers in this list.
    #[must_use]
    pub fn contours(&self) -> Vec<Contour<'_>> {
        let contour = |nested: &super::check::Nested| Contour {
            place: nested.hole.map_or_else(
                || format!("inclusions[{}]", nested.inclusion),
                |hole| format!("inclusions[{}].holes[{hole}]", nested.inclusion),
            ),
            outline: nested.shape(&self.inclusions),
            parent: nested.parent,
            // A hole of an outermost inclusion shows the first medium.
            medium: nested.shows.map_or(&self.media[0], |inclusion| &self.inclusions[inclusion].medium),
        };
        self.nesting.loops.iter().map(contour).collect()
    }
}
