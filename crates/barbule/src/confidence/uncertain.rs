//! Inputs that are not known exactly.

use std::collections::BTreeMap;

use crate::error::{did_you_mean, shortened};
use crate::open::{Opening, stack, structure};
use crate::progress::Unobserved;
use crate::stack::Stack;
use crate::structure::{FlatStack, SpeciesModel, Structure};
use crate::{Error, Result};

/// A standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Amount {
    /// In the unit of what it is of: nm of layers, of species the unit of their key, 1 of indices.
    Absolute(f64),
    /// As a part of what it is of.
    Part(f64),
}

/// An input and its standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertain {
    /// A medium, whose index n it is; a key of a species; `layer1` and so on of a stack.
    pub name: String,
    /// By how much it may be off.
    pub amount: Amount,
}

/// A structure with one input moved.
pub(super) struct Moved(pub(super) Structure);

impl Uncertain {
    /// Reads `NAME=STD` or `NAME=STD%`.
    ///
    /// # Errors
    /// Neither, or a deviation that is no number over 0.
    pub fn parse(text: &str) -> Result<Self> {
        let found = text.split_once('=').and_then(|(name, amount)| {
            let (number, percent) = match amount.trim().strip_suffix('%') {
                Some(number) => (number, true),
                None => (amount, false),
            };
            let value = number.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0)?;
            let amount = if percent { Amount::Part(0.01 * value) } else { Amount::Absolute(value) };
            let name = name.trim();
            (!name.is_empty()).then(|| Self { name: name.to_owned(), amount })
        });
        found.ok_or_else(|| {
            Error::input(format!(
                "'{}' is no uncertain input; write NAME=STD or NAME=STD% with a standard deviation over 0, as in keratin=0.005 or cortex_um=2%",
                shortened(text)
            ))
        })
    }

    /// By how much a value is moved.
    fn of(&self, value: f64) -> f64 {
        match self.amount {
            Amount::Absolute(std) => std,
            Amount::Part(part) => part * value.abs(),
        }
    }

    /// What `text` names with this input moved by so many standard deviations.
    pub(super) fn moved(&self, text: &str, opening: &Opening, by: f64) -> Result<Moved> {
        let moved = if opening.media.library().names().any(|name| name == self.name) {
            self.medium_moved(text, opening, by)
        } else {
            self.size_moved(structure(text, opening, &Unobserved)?, text, opening, by)
        };
        moved.map(Moved).map_err(|error| error.at(format!("uncertain {}", shortened(&self.name))))
    }

    /// With another index of a medium.
    fn medium_moved(&self, text: &str, opening: &Opening, by: f64) -> Result<Structure> {
        /// Where indices are what people mean by one number, nm.
        const AT_NM: f64 = 550.0;
        let mut opening = opening.clone();
        let n = opening.media.library().get(&self.name)?.index(AT_NM)?.re;
        opening.media.shift(&self.name, by * self.of(n))?;
        structure(text, &opening, &Unobserved)
    }

    /// With another size.
    fn size_moved(&self, structure: Structure, text: &str, opening: &Opening, by: f64) -> Result<Structure> {
        match structure {
            Structure::Below(upper) => self.size_moved(*upper, text, opening, by)?.underside(),
            Structure::Species(model) => {
                self.of_species(&model, by).map(|model| Structure::Species(model.into()))
            }
            Structure::Stack(flat) => {
                let stack = self.of_stack(&flat.stack, by)?;
                FlatStack { stack, ..*flat }.structure()
            }
            // A stack that is the same in all individuals.
            Structure::Sections { name, .. } => {
                let library = opening.media.library();
                let Ok(stack) = stack(text, library) else {
                    return Err(Error::input(format!(
                        "{} has no sizes with names; there only media are uncertain",
                        shortened(&name)
                    )));
                };
                let stack = self.of_stack(&stack, by)?;
                FlatStack { name, stack, library: library.clone(), materials: BTreeMap::new() }.structure()
            }
        }
    }

    fn of_species(&self, model: &SpeciesModel, by: f64) -> Result<SpeciesModel> {
        let parameters = serde_json::to_value(&model.parameters)
            .map_err(|error| Error::machine(format!("parameters cannot be written: {error}")))?;
        let numbers = parameters.as_object().into_iter().flatten().filter(|(_, value)| value.is_f64());
        let names: Vec<&str> = numbers.map(|(name, _)| name.as_str()).collect();
        let Some(value) = parameters.get(&self.name).and_then(serde_json::Value::as_f64) else {
            return Err(Error::input(format!(
                "{} has no such size{} (media: keratin, melanin …; sizes: {})",
                model.title(),
                did_you_mean(&self.name, names.iter().copied()),
                shortened(&names.join(", "))
            )));
        };
        model.with_parameters(&[(&self.name, (value + by * self.of(value)).into())])
    }

    fn of_stack(&self, stack: &Stack, by: f64) -> Result<Stack> {
        let layers = stack.layers();
        let layer = self.name.strip_prefix("layer").and_then(|number| number.parse::<usize>().ok());
        let Some(layer) = layer.filter(|layer| (1..=layers).contains(layer)) else {
            return Err(Error::input(format!(
                "is neither a medium nor a layer of the stack; its layers are layer1 to layer{layers}"
            )));
        };
        let nm = stack.thickness_nm()[layer - 1];
        stack.with_thickness(layer - 1, nm + by * self.of(nm))
    }
}
