//! Numbers of `docs/guide/export.md` that programs of others gave, or that take long: they are those of the files that were kept, and of today.

use barbule::brdf::{FeatherBrdf, Options};
use barbule::characterize::Catalog;
use barbule::export::film::{FilmFormat, OneFilm};
use barbule::export::osl::OslMaterial;
use barbule::export::{Deviation, Model};
use barbule::material::Library;
use barbule::{DVec3, Stack, Structure, Unobserved};
use serde_json::Value;

fn page() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guide/export.md")).unwrap()
}

fn kept(name: &str) -> Value {
    let path = format!("{}/../../docs/figures/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The cells of the row that begins with a word, of the tables of a section.
fn cells<'a>(page: &'a str, section: &str, first: &str) -> Vec<&'a str> {
    let (_, section) = page.split_once(&format!("\n## {section}\n")).unwrap();
    let row = section.lines().find(|line| line.starts_with(&format!("| {first} |"))).unwrap();
    row.trim_matches('|').split('|').map(str::trim).collect()
}

#[test]
fn the_page_has_what_blender_drew() {
    let (page, look) = (page(), kept("blender-starling.json"));
    let list = |key: &str| -> Vec<String> {
        look[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap().to_string()).collect()
    };
    for text in [
        list("own_rgb").join(", "),
        list("blender_rgb").join(", "),
        look["delta_e_76_mean"].to_string(),
        look["delta_e_76_worst"].to_string(),
        format!("Blender {}", look["blender"].as_str().unwrap()),
        format!("In {} blocks", look["blocks"]),
        format!("{} samples", look["samples"]),
    ] {
        assert!(page.contains(&text), "{text}");
    }
    let contrast = list("contrast");
    assert!(page.contains(&format!("is {} here and {} there", contrast[0], contrast[1])));
    // The two programs show about the same light.
    let sums = ["own_rgb", "blender_rgb"]
        .map(|key| look[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).sum::<f64>());
    assert!((sums[1] / sums[0] - 1.0).abs() < 0.1, "{sums:?}");
}

#[test]
fn others_validators_had_nothing_to_say() {
    let files = kept("validated-exports.json");
    let files = files.as_array().unwrap();
    assert_eq!(files.len(), 3);
    for file in files {
        assert_eq!(file["complaints"].as_array().unwrap().len(), 0, "{file}");
    }
    assert_eq!(files[0]["curves"], 140 + 54_790);
}

#[test]
fn the_shader_of_a_starling_is_as_far_off_as_the_page_says() {
    let found = Catalog::default().shipped(&Structure::builtin("starling").unwrap()).unwrap().unwrap();
    let brdf = FeatherBrdf::new(&found.material, Options::default()).unwrap();
    let osl = OslMaterial::of(&brdf, 0, &Unobserved).unwrap();
    let value = |wi: DVec3, wo: DVec3| osl.value(wi, wo);
    let deviation = Deviation::of(&Model::Rgb(&value), &brdf).unwrap();
    let page = page();
    let row = cells(&page, "Blender", "starling");
    assert_eq!(row[1], format!("{:.0} %", 100.0 * deviation.relative_l1));
    assert_eq!(row[2], format!("{:+.1} %", 100.0 * deviation.bias));
    assert_eq!(row[3], format!("{:.2}", deviation.delta_e));
}

#[test]
fn films_are_as_far_off_as_the_page_says() {
    let page = page();
    let stack = Stack::parse("air/keratin:595/air", &Library::builtin()).unwrap();
    let (rows, _) = OneFilm::of(&stack).unwrap().compare(&stack, FilmFormat::Gltf).unwrap();
    let expected: Vec<String> =
        rows.iter().map(|row| format!("{:.1} ({:.1})", row.delta_e, row.delta_e_of_indices)).collect();
    assert_eq!(cells(&page, "Thin films: glTF and OpenPBR", "`air/keratin:595/air`")[2..], expected);
}
