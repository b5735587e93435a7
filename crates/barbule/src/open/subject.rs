//! What sizes are to be found of, as people type it.

use std::path::Path;

use super::{Opening, is_built_in, unknown};
use crate::error::{did_you_mean, shortened};
use crate::inverse::{FILM, FILM_NM, LAYER_NM, Open, Simulation, Subject, Target};
use crate::io::{InputKind, kind_of, read_lattice, read_species_file};
use crate::material::Library;
use crate::structure::{SpeciesFile, species_names};
use crate::{Error, Result};

/// A model by its name, `film`, `multilayer`, `lattice`, `SPECIES[:VARIANT]`, or the file of a species or of a lattice. `stack` is that of
/// films and multilayers, with `?` or `LOW..HIGH` in place of what is to be found; `open` are the sizes of the others.
///
/// # Errors
/// An unknown model; a stack where there is none, or open sizes of one; a file that is missing or of another kind.
pub fn target(
    model: &str,
    stack: Option<&str>,
    open: Vec<Open>,
    simulation: Simulation,
    opening: &Opening,
) -> Result<Target> {
    let library = opening.media.library();
    let usual = match model {
        "film" => Some((stack.unwrap_or(FILM), FILM_NM)),
        "multilayer" => {
            let text = stack.ok_or_else(|| {
                Error::input(
                    "a multilayer needs a stack; give one with ? for what is to be found, as in 'air/keratin:5/6*(melanin:?/keratin:?)/keratin'",
                )
                .naming(&["stack"])
            })?;
            Some((text, LAYER_NM))
        }
        _ => None,
    };
    if let Some((text, usual_nm)) = usual {
        if !open.is_empty() {
            return Err(Error::input(
                "open sizes are those of species and lattices; in a stack write ? or LOW..HIGH where a number is to be found",
            ));
        }
        return Ok(Target::Stack { text: text.to_owned(), usual_nm, library: Box::new(library.clone()) });
    }
    if stack.is_some() {
        return Err(Error::input(format!(
            "a stack is for the models film and multilayer, not for {}; leave it out",
            shortened(model)
        )));
    }
    Ok(Target::Structure { subject: subject(model, library)?, open, simulation })
}

/// A species by its name or file, with the file that its sizes can be written into; or a lattice, by `lattice` or its file.
///
/// # Errors
/// Neither is called so; the file is missing, of another kind or damaged.
pub fn subject(model: &str, library: &Library) -> Result<Subject> {
    if model == "lattice" {
        // Solid rods of melanin in keratin, as those of ducks.
        let (file, model) = species(SpeciesFile::builtin("mallard")?, None, library.clone())?;
        return model
            .lattice()
            .map(|lattice| Subject::Lattice(Box::new(lattice)))
            .ok_or_else(|| Error::machine(format!("{} has no lattice", file.name)));
    }
    let of = |(file, model)| Subject::Species { file: Box::new(file), model: Box::new(model) };
    let (name, variant) =
        model.split_once(':').map_or((model, None), |(name, variant)| (name, Some(variant)));
    if is_built_in(model) {
        return species(SpeciesFile::builtin(name)?, variant, library.clone()).map(of);
    }
    let is_toml = |text: &str| text.to_lowercase().ends_with(".toml");
    let (path, variant) = match model.rsplit_once(':').filter(|(path, _)| is_toml(path)) {
        Some((path, variant)) => (Path::new(path), Some(variant)),
        None => (Path::new(model), None),
    };
    if !is_toml(&path.to_string_lossy()) {
        let known = ["film", "multilayer", "lattice"].into_iter().chain(species_names());
        return Err(Error::input(format!(
            "there is no model '{}'{}; give film, multilayer, lattice, a species, or the .toml file of a species or lattice",
            shortened(model),
            did_you_mean(model, known)
        )));
    }
    if !path.exists() {
        return Err(unknown::no_file(model));
    }
    match kind_of(path)? {
        InputKind::Lattice => Ok(Subject::Lattice(Box::new(read_lattice(path, library)?))),
        InputKind::Stack => Err(Error::input(
            "is a stack; give it as text, with ? where a number is to be found, and the model film or multilayer",
        )
        .of_file(path)
        .at(path.display())),
        _ => {
            let (file, library) = read_species_file(path, library)?;
            species(file, variant, library).map(of).map_err(|error| error.in_file(path))
        }
    }
}

fn species(
    file: SpeciesFile,
    variant: Option<&str>,
    library: Library,
) -> Result<(SpeciesFile, crate::structure::SpeciesModel)> {
    let model = file.model(variant, library)?;
    Ok((file, model))
}
