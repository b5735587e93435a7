//! What a fit is asked for: the same on the command line and from Python.

use super::outcome::{Outcome, comments};
use super::structure::{FittedStructure, Simulation, fit_structure};
use super::subject::{Open, Subject};
use super::template::Template;
use super::{Reading, Settings, fit_stack};
use crate::error::shortened;
use crate::instrument::Instrument;
use crate::material::Library;
use crate::progress::Progress;
use crate::{Error, Result};

/// The stack of a film unless another is given, and where its thickness is looked for, nm.
pub const FILM: &str = "air/keratin:?/air";
/// Where the thickness of a film is looked for, nm.
pub const FILM_NM: [f64; 2] = [50.0, 3000.0];
/// Where the thickness of one of several layers is looked for, nm.
pub const LAYER_NM: [f64; 2] = [20.0, 500.0];

/// What is to be found.
#[derive(Debug, Clone)]
pub enum Target {
    /// Open numbers of a stack of flat layers.
    Stack {
        /// The stack with places, as in `air/keratin:?/air`.
        text: String,
        /// Where a thickness that is only `?` is looked for, nm.
        usual_nm: [f64; 2],
        /// What its media mean.
        library: Box<Library>,
    },
    /// Sizes of a species or a lattice.
    Structure {
        /// The species or lattice.
        subject: Subject,
        /// The open sizes; empty: those that set its colour most.
        open: Vec<Open>,
        /// How its spectra are simulated.
        simulation: Simulation,
    },
}

impl Target {
    /// Refuses an instrument where its reading does not follow from what flat layers reflect.
    ///
    /// # Errors
    /// It is a species or a lattice.
    pub fn check_instrument(&self, instrument: Option<&Instrument>) -> Result<()> {
        match self {
            Self::Structure { subject, .. } if instrument.is_some() => Err(Error::input(format!(
                "an instrument is for films and multilayers, but {} is not made of flat layers alone; leave it out, and the level free",
                shortened(&subject.name())
            ))
            .naming(&["instrument"])),
            _ => Ok(()),
        }
    }

    /// All layers together of the thickest stack that is looked at, nm; 0 of what is no stack.
    ///
    /// # Errors
    /// It is no stack with open numbers.
    pub fn thickest_nm(&self) -> Result<f64> {
        let Self::Stack { text, usual_nm, library } = self else { return Ok(0.0) };
        let template = Template::parse(text, *usual_nm, library)?;
        Ok(template.stack(&template.sizes(|_| 1.0), library)?.thickness_nm().iter().sum())
    }

    /// Fits it to readings.
    ///
    /// # Errors
    /// As [`fit_stack`] and [`fit_structure`].
    pub fn fit(&self, readings: &[Reading], settings: &Settings, progress: &dyn Progress) -> Result<Outcome> {
        match self {
            Self::Stack { text, usual_nm, library } => {
                progress.begin("fitting", 1);
                let found = fit_stack(text, *usual_nm, library, readings, settings)?;
                progress.advance(1);
                let stack = toml::Value::from(found.text(&found.fit.solutions[0]));
                let toml = format!("{}stack = {stack}\n", comments(&found.fit));
                Ok(Outcome { toml, fit: found.fit, tables: None })
            }
            Self::Structure { subject, open, simulation } => {
                let found = fit_structure(subject, open, simulation, readings, settings, progress)?;
                let FittedStructure { fit, best, table_error, simulated } = found;
                let toml = format!("{}{}", comments(&fit), best.toml()?);
                Ok(Outcome { fit, toml, tables: Some((table_error, simulated)) })
            }
        }
    }
}
