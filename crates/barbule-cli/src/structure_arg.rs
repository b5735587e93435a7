//! STRUCTURE as people type it: what is said about it, and its lit side.

use std::path::Path;

use barbule::error::shortened;
use barbule::io::{InputKind, kind_of};
use barbule::open;
use barbule::structure::{Lattice, Section, Side, Smoothing, Structure};
use barbule::{Error, Result};
use clap::ValueEnum;

use crate::common::Common;
use crate::progress::Doubts;
use crate::provenance::quoted;

/// What every STRUCTURE argument says in `--help`.
pub const HELP: &str = "A stack as in 'air/keratin:595/air', SPECIES[:VARIANT], a section .json, a species or lattice .toml, or a folder of sections; with ' (below)' behind it its lower side";

/// Which side of the barbules is lit, and how what is finer than light is taken.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct SideArg {
    /// The side that is lit: below is each barbule turned upside down, by 180° about its long axis
    #[arg(long, value_enum, default_value_t = Lit::Above)]
    side: Lit,
    #[arg(long, value_name = "UM", value_parser = smoothing, help = SMOOTH)]
    smooth: Option<Smoothing>,
}

/// What `--smooth` says in `--help`.
pub(crate) const SMOOTH: &str = "Average inclusions along the top by a Gaussian of this standard deviation, µm, or off: what is finer than light becomes an effective medium [default: 0.06 for hummingbirds, else off]";

/// Reads what `--smooth` is given.
pub(crate) fn smoothing(text: &str) -> std::result::Result<Smoothing, String> {
    if text == "off" {
        return Ok(Smoothing::Off);
    }
    let deviation_um = text.parse().map_err(|_| format!("{text} is neither a length in µm nor off"))?;
    Smoothing::over(deviation_um).map_err(|error| error.to_string())
}

/// Sides of barbules.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Lit {
    /// The upper one
    Above,
    /// The lower one
    Below,
}

impl SideArg {
    /// Opens a structure as [`parse`] does, as it is lit, and says where there is nothing to average.
    ///
    /// # Errors
    /// As [`parse`] and [`of`](Self::of).
    pub(crate) fn open(self, text: &str, common: &Common) -> Result<Structure> {
        let structure = parse(text, common)?;
        let has_inclusions = |section: Section| !section.inclusions.is_empty();
        if self.smooth.is_some() && !structure.instance(common.seed, 0).is_ok_and(has_inclusions) {
            common.idle("--smooth", &format!("{} has no inclusions", structure.name()));
        }
        self.of(structure)
    }

    /// The structure as it is lit.
    ///
    /// # Errors
    /// It has no lower side that can be simulated.
    pub(crate) fn of(self, structure: Structure) -> Result<Structure> {
        let structure = self.smooth.into_iter().fold(structure, Structure::smoothed);
        match self.side {
            Lit::Above => Ok(structure),
            Lit::Below => structure.underside().map_err(|error| error.at("--side below")),
        }
    }

    /// Refuses or says what a material cannot follow, which is of one side and of what it was made of.
    ///
    /// # Errors
    /// The lower side of a material's file.
    pub(crate) fn of_material(self, common: &Common) -> Result<()> {
        if self.side == Lit::Below {
            return Err(Error::input(
                "--side below: a material file is of the side that it was made of; give the file of the lower side, or the structure",
            ));
        }
        if self.smooth.is_some() {
            common.idle("--smooth", "a material is of the inclusions that it was made of");
        }
        Ok(())
    }

    /// Whether an average along the top is asked for.
    pub(crate) fn is_smoothed(self) -> bool {
        matches!(self.smooth, Some(Smoothing::Over(_)))
    }
}

/// Opens a structure as [`open::structure`] does, and says what is doubtful in it and which `--medium` it does without.
///
/// # Errors
/// As [`open::structure`].
pub fn parse(text: &str, common: &Common) -> Result<Structure> {
    let opening = common.opening()?;
    let structure =
        open::structure(text, &opening, &Doubts(common)).map_err(|error| with_advice(error, text))?;
    common.say_unused(&structure.name(), &opening.media.unused_in(&structure, common.seed));
    Ok(structure)
}

/// What to do with a file that is something else than a structure.
pub(crate) fn with_advice(error: Error, text: &str) -> Error {
    let text = text.strip_suffix(Side::BELOW).unwrap_or(text);
    let file = quoted(&shortened(text));
    match kind_of(Path::new(text)) {
        _ if open::is_built_in(text) => error,
        Ok(InputKind::Material) => error.followed_by("; render and lobes take it"),
        Ok(InputKind::Scene) => {
            error.followed_by(&format!("; draw it with `barbule render {file} -o picture.png`"))
        }
        Ok(InputKind::Store) => {
            error.followed_by(&format!("; make its material with `barbule fit {file} -o material.barbule`"))
        }
        _ => error,
    }
}

/// Opens a photonic crystal, as [`parse`] a structure: that of any structure that has one.
///
/// # Errors
/// As [`parse`], or a structure that is no photonic crystal.
pub(crate) fn lattice(text: &str, common: &Common) -> Result<Lattice> {
    open::lattice_of(&parse(text, common)?)
}
