//! What the library's arguments are called on a command line.

use barbule::Error;

/// Arguments as the library's messages name them, and their flags.
const FLAGS: [(&str, &str); 29] = [
    ("cache", "--cache"),
    ("classes", "--classes"),
    ("column", "--column"),
    ("correlation_um", "--correlation"),
    ("cortex_nm", "--cortex"),
    ("crop", "--crop"),
    ("denoise", "--denoise"),
    ("directions", "--directions"),
    ("elements", "--elements"),
    ("instances", "--instances"),
    ("instrument", "--instrument"),
    ("kind", "--as"),
    ("layers", "--layers"),
    ("length_um", "--length"),
    ("media", "--medium"),
    ("memory", "--memory"),
    ("nm_per_px", "--scale"),
    ("phi_deg", "--phi"),
    ("pitch_um", "--pitch"),
    ("range_nm", "--range"),
    ("range_um", "--range"),
    ("roughness_um", "--roughness"),
    ("stack", "--stack"),
    ("threads", "--threads"),
    ("thresholds", "--thresholds"),
    ("unit", "--unit"),
    ("wavelengths", "--wavelengths"),
    ("width", "--simd"),
    ("width_um", "--width"),
];

/// An error's sentence in the words of the command line.
pub(crate) fn spoken(error: &Error) -> String {
    error.calling(|argument| {
        let known = FLAGS.iter().find(|(name, _)| *name == argument);
        known.map_or(argument, |(_, flag)| flag).to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_argument_that_the_library_names_has_a_flag_that_there_is() {
        let texts = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
        let lists = texts.iter().flat_map(|text| text.split(".naming(&[").skip(1));
        let named: BTreeSet<&str> = lists
            .flat_map(|rest| rest[..rest.find(']').unwrap()].split(", "))
            .map(|name| name.trim_matches('"'))
            .collect();
        assert_eq!(Vec::from_iter(named), FLAGS.map(|(name, _)| name));
        let command = crate::command();
        let flags: Vec<_> = command
            .get_subcommands()
            .flat_map(clap::Command::get_arguments)
            .filter_map(|argument| Some(format!("--{}", argument.get_long()?)))
            .collect();
        for (name, flag) in FLAGS {
            assert!(flags.iter().any(|known| known == flag), "{name} has no flag {flag}");
        }
    }

    /// The library's sources below a folder: neither programs nor tests, nor where `naming` itself is.
    fn sources(folder: &Path) -> Vec<String> {
        let mut texts = Vec::new();
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let is_library = !["barbule-cli", "tests", "error.rs"].iter().any(|name| path.ends_with(name));
            if path.is_dir() && is_library {
                texts.extend(sources(&path));
            } else if path.extension().is_some_and(|end| end == "rs") && is_library {
                texts.push(std::fs::read_to_string(path).unwrap());
            }
        }
        texts
    }
}
