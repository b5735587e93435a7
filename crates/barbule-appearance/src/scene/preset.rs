//! Scenes that need no file of the user's: close-ups of feathers and whole ones, and gratings, as the texts of their scene files.

use barbule_birds::BIRDS;

use crate::error::{did_you_mean, shortened};
use crate::{Error, Result};

/// Those of no bird.
const GRATINGS: [(&str, &str); 2] = [
    ("snake", include_str!("presets/snake.toml")),
    ("diffraction-bench", include_str!("presets/diffraction-bench.toml")),
];

/// Close-ups, then whole feathers, then many feathers and birds, then feathers without structural colour, then gratings.
fn presets() -> impl Iterator<Item = (&'static str, &'static str)> + Clone {
    let close_ups = BIRDS.iter().filter_map(|bird| Some((bird.name, bird.scene?)));
    let feathers = BIRDS.iter().filter_map(|bird| Some((bird.feather_name, bird.feather?)));
    let wings = BIRDS.iter().filter_map(|bird| Some((bird.name, bird.wing?)));
    let birds = BIRDS.iter().flat_map(|bird| bird.presets.iter().copied());
    close_ups.chain(feathers).chain(birds).chain(wings).chain(GRATINGS)
}

/// The presets' names.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    presets().map(|(name, _)| name)
}

/// A preset's scene file.
///
/// # Errors
/// There is none of this name; the message offers the nearest.
pub fn toml(name: &str) -> Result<&'static str> {
    presets().find(|(known, _)| *known == name).map(|(_, text)| text).ok_or_else(|| {
        let known = names().collect::<Vec<_>>().join(", ");
        let near = did_you_mean(name, names());
        Error::input(format!("there is no preset '{}'{near} (known are {known})", shortened(name)))
    })
}

/// Presets that exist by several models, with their names: that of 2005, of films, and that of the preset itself, the last.
const MODELS: [(&str, [&str; 3]); 1] = [("peacock", ["film-2005", "film", "barbule"])];

/// The models of all presets that have several.
pub fn models() -> impl Iterator<Item = &'static str> + Clone {
    MODELS.into_iter().flat_map(|(_, models)| models)
}

/// The name of the preset that shows a scene by one of its models.
///
/// # Errors
/// No preset of this name has models, or not this one.
pub fn by_model(scene: &str, model: &str) -> Result<String> {
    let Some((name, models)) = MODELS.into_iter().find(|(name, _)| *name == scene) else {
        let known = MODELS.map(|(name, models)| format!("{name} ({})", models.join(", "))).join(", ");
        return Err(Error::input(format!(
            "'{}' has no models; the presets that have are {known}",
            shortened(scene)
        )));
    };
    match models.into_iter().find(|known| *known == model) {
        Some(known) if known == models[2] => Ok(name.to_owned()),
        Some(known) => Ok(format!("{name}-{known}")),
        None => {
            let (near, known) = (did_you_mean(model, models), models.join(", "));
            Err(Error::input(format!("{name} has no model '{}'{near} (known are {known})", shortened(model))))
        }
    }
}

/// What a preset shows: the first sentence of its file's first comment.
///
/// # Errors
/// As [`toml()`].
pub fn about(name: &str) -> Result<String> {
    let comment: Vec<&str> =
        toml(name)?.lines().map_while(|line| line.strip_prefix('#')).map(str::trim).collect();
    let comment = comment.join(" ");
    Ok(comment.split_inclusive(". ").next().unwrap_or_default().trim_end_matches(['.', ' ']).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_says_what_it_shows_in_a_line() {
        for name in names() {
            let about = about(name).unwrap();
            assert!((20..=200).contains(&about.len()) && !about.contains('\n'), "{name}: {about}");
        }
        assert_eq!(
            about("starling-feather").unwrap(),
            "A starling's breast feather, whole: lanceolate, glossy, with a buff tip"
        );
        assert!(about("starlin").unwrap_err().to_string().contains("did you mean 'starling'"));
    }
}
