//! Stacks as flat barbules: one section, or endless random ones where thicknesses spread.

use std::collections::BTreeMap;

use super::Structure;
use super::section::{MaterialSource, Section};
use crate::Result;
use crate::material::Library;
use crate::stack::Stack;

/// A planar stack that serves as a barbule, [`super::FLAT_WIDTH_UM`] wide.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatStack {
    /// What it is called.
    pub name: String,
    /// Its layers.
    pub stack: Stack,
    /// The materials that its media mean.
    pub library: Library,
    /// The user's own among them.
    pub materials: BTreeMap<String, MaterialSource>,
}

impl FlatStack {
    /// Reads the stack language; the text is the name.
    ///
    /// # Errors
    /// As [`Stack::parse`].
    pub fn parse(text: &str, library: Library) -> Result<Self> {
        let stack = Stack::parse(text, &library)?;
        Ok(Self { name: text.to_owned(), stack, library, materials: BTreeMap::new() })
    }

    /// Individual number `index` as a section.
    ///
    /// # Errors
    /// The stack is over 1 mm thick.
    pub fn section(&self, seed: u64, index: usize) -> Result<Section> {
        let mut section = if self.stack.is_random() {
            let mut section =
                Section::flat(&self.name, &self.stack.individual(seed, index), self.library.clone())?;
            section.name = format!("{} {index}", self.name);
            section.source += &format!(", seed {seed}, instance {index}");
            section
        } else {
            Section::flat(&self.name, &self.stack, self.library.clone())?
        };
        section.materials.clone_from(&self.materials);
        Ok(section)
    }

    /// The structure: random instances where thicknesses spread, else the one section.
    ///
    /// # Errors
    /// As [`Self::section`].
    pub fn structure(self) -> Result<Structure> {
        let first = self.section(0, 0)?;
        if self.stack.is_random() {
            return Ok(Structure::Stack(Box::new(self)));
        }
        Ok(Structure::Sections { name: self.name, sections: vec![first] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Structure {
        Structure::flat(text).unwrap()
    }

    #[test]
    fn a_stack_with_spread_has_endless_instances_and_one_without_is_its_section() {
        let random = read("air/keratin:200±5%/air");
        assert_eq!((random.count(), random.width_um(), random.is_curved()), (None, 25.0, false));
        let depth = |index| random.instance(1, index).unwrap().boundaries[1].z_um[0];
        assert_eq!(depth(3), depth(3));
        assert_ne!(depth(3), depth(4));
        assert!((0..50).all(|k| (depth(k) + 0.2).abs() <= 0.03 + 1e-12));
        let fixed = read("air/keratin:200/air");
        assert_eq!((fixed.count(), fixed.name()), (Some(1), "air/keratin:200/air".to_owned()));
        assert_eq!(fixed.instance(1, 0).unwrap().boundaries[1].z_um[0], -0.2);
    }

    #[test]
    fn what_is_recorded_of_a_random_stack_makes_it_again() {
        let random = read("air / 2*(melanin:99±1/mix(keratin,air,0.1):100±2%) / keratin");
        let recorded = random.description();
        let again = read(recorded["stack"].as_str().unwrap());
        assert_eq!(again.description(), recorded);
        assert_eq!(again.hash(), random.hash());
        assert_ne!(read("air/keratin:200±5%/air").hash(), read("air/keratin:200±6%/air").hash());
    }
}
