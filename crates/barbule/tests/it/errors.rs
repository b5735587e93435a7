//! Errors of users' files know where they are, beside their sentences.

use std::path::Path;

use barbule::io::measured::read_measured;
use barbule::io::tables::read_index_table;
use barbule::io::{
    read_lattice, read_material, read_section, read_shown, read_species, read_stack, read_text,
};
use barbule::material::Library;
use barbule::structure::species_toml;
use barbule::{Error, Result, SceneDescription};

const SECTION: &str = r#"{"barbule": 1, "units": "um", "media": ["air", "keratin"],
 "boundaries": [{"x": [-5, 5], "z": [0, 0]},
                {"x": [-5, 5], "zz": [1, 1]}]}"#;

const LATTICE: &str = "[lattice]\nperiod = 0.2\ncortex = 0.1\n[[lattice.rod]]\ncircles = [{ diameter = 'x', medium = 'melanin' }]\n";

/// The error of a reader on a text in a file of this name.
fn refused<T>(name: &str, text: impl AsRef<[u8]>, read: impl Fn(&Path) -> Result<T>) -> Error {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let error = read(&path).err().unwrap();
    assert_eq!(error.file(), Some(path.as_path()), "{error}");
    assert!(error.to_string().starts_with(&format!("{}: ", path.display())), "{error}");
    error
}

fn place(error: &Error) -> (Option<&str>, Option<usize>, Option<usize>) {
    (error.key(), error.line(), error.column())
}

fn scene(path: &Path) -> Result<SceneDescription> {
    SceneDescription::parse(&read_text(path)?).map_err(|error| error.in_file(path))
}

#[test]
fn files_keys_lines_and_columns_are_known() {
    let media = Library::builtin();
    let starling = species_toml("starling").unwrap();
    let species = |path: &Path| read_species(path, None, &media);

    let error = refused("s.toml", "preset = \"starling\"\n[camera]\nf_nmber = 2\n", scene);
    assert_eq!(place(&error), (Some("camera.f_nmber"), Some(3), Some(1)), "{error}");
    let error =
        refused("s.toml", "preset = \"starling\"\n[light]\nradius_deg = 1\nelevation_deg = 100\n", scene);
    assert_eq!(place(&error), (Some("light.elevation_deg"), Some(4), Some(1)), "{error}");
    let error = refused("s.toml", "preset = \"starling\"\n\n  size = [1, \"a\"]", scene);
    assert_eq!(place(&error), (Some("size[1]"), Some(3), Some(14)), "{error}");

    let error = refused("a.toml", starling.replacen("width_um =", "  widht_um =", 1), species);
    assert_eq!(place(&error), (Some("parameters.widht_um"), Some(13), Some(3)), "{error}");
    let error = refused("a.toml", starling.replace("cortex_um = 0.440", "cortex_um = 440"), species);
    assert_eq!(place(&error), (Some("variants[7].cortex_um"), Some(55), Some(1)), "{error}");
    let error =
        refused("a.toml", starling.replace("core_fraction_low = 0.3", "core_fraction_low = 0.9"), species);
    assert_eq!(place(&error), (Some("parameters.core_fraction_low"), Some(20), Some(1)), "{error}");
    let error = refused("a.toml", format!("{starling}\n[feather]\ntype = 3\n"), read_shown);
    assert_eq!(error.key(), Some("feather.type"), "{error}");

    let stack = |path: &Path| read_stack(path, &media);
    let error =
        refused("b.toml", "entry = \"air\"\nexit = \"air\"\nlayers = [\n { medum = \"air\" }]", stack);
    assert_eq!(place(&error), (Some("layers[0].medum"), Some(4), Some(4)), "{error}");
    let error =
        refused("b.toml", "entry = \"air\"\nexit = \"air\"\nlayers = [\n { medium = \"air\" }]", stack);
    assert_eq!(place(&error), (Some("layers[0]"), Some(4), Some(2)), "{error}");

    let section = |path: &Path| read_section(path, &media);
    let error = refused("c.json", SECTION, section);
    assert_eq!(place(&error), (Some("boundaries[1].zz"), Some(3), Some(32)), "{error}");
    let error = refused("c.json", SECTION.replace("\"zz\": [1, 1]", "\"z\": [1, null]"), section);
    assert_eq!(place(&error), (Some("boundaries[1].z[1]"), Some(3), Some(41)), "{error}");
    let error = refused("c.json", SECTION.replace("\"units\"", "units"), section);
    assert_eq!(place(&error), (None, Some(1), Some(16)), "{error}");

    for (name, text) in [("d.toml", LATTICE.to_owned()), ("d.json", lattice_json())] {
        let error = refused(name, text, |path| read_lattice(path, &media));
        assert_eq!(error.key(), Some("lattice.rod[0].circles[0].diameter"), "{error}");
        assert_eq!(error.line(), Some(if name.ends_with("toml") { 5 } else { 1 }), "{error}");
    }
}

fn lattice_json() -> String {
    barbule::fields::parse_toml(LATTICE).unwrap().to_string()
}

#[test]
fn tables_know_the_line_and_every_file_its_name() {
    let error = refused("n.csv", "nm,n\n400,1.5\n500,x\n", read_index_table);
    assert_eq!(place(&error), (None, Some(3), None), "{error}");
    let error = refused("m.csv", "nm,R\n400,0.5\n500,0.4\n450,0.1\n", |path| read_measured(path, None, None));
    assert_eq!(place(&error), (None, Some(4), None), "{error}");
    // What a structure's file names is about the file that is named.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("q.csv"), "400,1.5\n500,x\n").unwrap();
    let stack = folder.path().join("b.toml");
    std::fs::write(&stack, "stack = \"air/q:5/air\"\n[materials]\nq = \"q.csv\"\n").unwrap();
    let error = read_stack(&stack, &Library::builtin()).unwrap_err();
    assert_eq!(
        (error.file(), error.line()),
        (Some(folder.path().join("q.csv").as_path()), Some(2)),
        "{error}"
    );

    let shipped = barbule_birds::material("starling-green").unwrap();
    let error = refused("m.barbule", &shipped[..shipped.len() / 2], read_material);
    assert_eq!(place(&error), (None, None, None), "{error}");
}
