//! Which media of `--medium` a structure is made of.

use barbule::structure::{Medium, Structure, Substance};

use crate::common::Common;

/// Says which `--medium` a structure does without.
pub(crate) fn say_unused(structure: &Structure, common: &Common) {
    if common.medium.is_empty() {
        return;
    }
    // A structure without a first individual is refused where that is needed.
    let Ok(section) = structure.instance(common.seed, 0) else { return };
    let lattice = section.crystal.iter().map(|crystal| &crystal.lattice);
    let rods = lattice.flat_map(|lattice| &lattice.rods).flat_map(|rod| &rod.circles).map(|c| &c.medium);
    let media = section.all_media().flat_map(Medium::substances).chain(rods);
    let names: Vec<&str> = media
        .filter_map(|substance| match substance {
            Substance::Named(name) => Some(name.as_str()),
            Substance::Index(_) => None,
        })
        .collect();
    say_unused_of(&structure.name(), &names, common);
}

/// The same for something that is made of media with these names, or expressions of names.
pub(crate) fn say_unused_of(what: &str, media: &[&str], common: &Common) {
    for given in &common.medium {
        let name = given.split_once('=').map_or(given.as_str(), |(name, _)| name).trim();
        if !media.iter().any(|medium| is_made_of(medium, name)) {
            let (name, what) = (barbule::error::shortened(name), barbule::error::shortened(what));
            common.idle(&format!("--medium {name}"), &format!("nothing in {what} is made of it"));
        }
    }
}

/// Whether a medium, such as `keratin` or `mix(keratin,melanin,0.4)`, names another one.
fn is_made_of(medium: &str, name: &str) -> bool {
    let of_names = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
    medium == name || medium.split(|c| !of_names(c)).any(|word| word == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_medium_is_used_where_its_whole_name_stands() {
        assert!(is_made_of("keratin", "keratin") && is_made_of("mix(keratin,melanin,0.4)", "melanin"));
        assert!(is_made_of("mix(chitin.2,melanin,0.4)", "chitin.2"));
        assert!(!is_made_of("mykeratin", "keratin") && !is_made_of("keratin", "mykeratin"));
    }
}
