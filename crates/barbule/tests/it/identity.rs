//! Identities are what they were when files were written.

use barbule::Complex64;
use barbule::identity;
use barbule::io::{decode_material, parse_section, read_lattice};
use barbule::material::{Library, Table};
use barbule::render::checkpoint;
use barbule::render::planes::Planes;
use barbule::stack::Stack;
use barbule::structure::{Section, SpeciesModel, Structure, species_names};

fn with_chitin() -> Library {
    let rows = [(300.0, 1.5, 0.0), (450.5, 1.52, 0.001), (830.0, 1.48, 0.0)];
    let rows = rows.map(|(nm, n, k)| (nm, Complex64::new(n, k)));
    let mut library = Library::builtin();
    library.insert_table("chitin", Table::new("chitin.csv", &rows).unwrap()).unwrap();
    library
}

fn stack() -> Section {
    let text = "air/mix(keratin,melanin,0.25,bruggeman):120/1.56+0.02j:80/chitin:300/air";
    Section::flat(text, &Stack::parse(text, &with_chitin()).unwrap(), with_chitin()).unwrap()
}

fn lattice() -> barbule::structure::Lattice {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/lattices/square-holes.toml");
    read_lattice(path.as_ref(), &Library::builtin()).unwrap()
}

fn granules() -> Section {
    let text = include_str!("../../../../examples/granules.json");
    parse_section(text, "granules.json".as_ref(), &Library::builtin()).unwrap()
}

/// An instance as it comes back from a file.
fn instance(species: &str) -> Section {
    SpeciesModel::builtin(species, None, Library::builtin()).unwrap().section(1, 1).unwrap()
}

fn model(species: &str) -> Structure {
    Structure::Species(Box::new(SpeciesModel::builtin(species, None, Library::builtin()).unwrap()))
}

#[test]
fn what_ships_is_recognised_by_what_it_recorded_when_it_was_made() {
    for (stem, bytes) in barbule_birds::materials() {
        let recorded = &decode_material(bytes).unwrap().info["campaign"]["structure"];
        let text = |key: &str| recorded[key].as_str().unwrap();
        let model =
            SpeciesModel::builtin(text("species"), Some(text("variant")), Library::builtin()).unwrap();
        let upper = Structure::Species(Box::new(model));
        let structure = if stem.ends_with("-below") { upper.underside().unwrap() } else { upper };
        assert_eq!(structure.description(), *recorded, "{stem}");
    }
}

#[test]
fn identities_stay_what_they_are() {
    let library = with_chitin();
    let mut found: Vec<(String, String)> = Vec::new();
    let mut add = |name: &str, hash: String| found.push((name.to_owned(), hash[..16].to_owned()));
    species_names().for_each(|species| add(species, model(species).hash()));
    add("stack", identity::hash("section", &stack()));
    add("granules", identity::hash("section", &granules()));
    add("curved crystal", identity::hash("section", &instance("magpie")));
    add("lattice", lattice().hash());
    add("table", identity::hash("material", library.get("chitin").unwrap()));
    let name = checkpoint::name(library.get("chitin").unwrap(), 1, "0.1.0", &Planes::default());
    add("checkpoint", name.iter().map(|byte| format!("{byte:02x}")).collect());
    let found: Vec<(&str, &str)> = found.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    assert_eq!(
        found,
        [
            ("rock-dove", "5ecc5588a7126a92"),
            ("starling", "ecf98d19e538f965"),
            ("bronzewing", "b426f2a1fb3ae362"),
            ("hummingbird", "815bdcd9f7692f2f"),
            ("mallard", "8c1e4134067c452a"),
            ("magpie", "be1c9067c95c843b"),
            ("peafowl", "e8b1a749c342605d"),
            ("stack", "849f3aaf7f1c9343"),
            ("granules", "cf80b2a3cafec3c9"),
            ("curved crystal", "a5f14a203906b847"),
            ("lattice", "e597d260f809822d"),
            ("table", "41da704f7c7b2660"),
            ("checkpoint", "3b63214dbc8ce13a"),
        ]
    );
}

#[test]
fn only_what_decides_the_light_counts() {
    let mut renamed = stack();
    (renamed.name, renamed.source) = ("another".into(), "elsewhere".into());
    assert_eq!(identity::hash("section", &renamed), identity::hash("section", &stack()));
    let mut deeper = stack();
    deeper.boundaries[1].z_um[0] -= 1e-9;
    assert_ne!(identity::hash("section", &deeper), identity::hash("section", &stack()));
    let mut other = lattice();
    other.rods[0].circles[0].diameter_um *= 1.001;
    assert_ne!(other.hash(), lattice().hash());
}
