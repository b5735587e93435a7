//! Whole atlases: the same bits for any parts and interruptions.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::Unobserved;

const SMALL: &str = "barbule = 1
name = 'small'
structure = 'starling'
wavelengths_nm = '400:700:100'
angles_deg = [0, 30]
individuals = 2
unit_cells = 2

[[vary]]
key = 'cortex_um'
values = '0.3:0.5:0.1'

[[vary]]
key = 'melanosome_diameter_um'
values = [0.2, 0.25, 0.3]
";

fn atlas(text: &str) -> Result<Atlas> {
    let plan = Plan::parse(text)?;
    Atlas::new(&plan, Path::new("."), &Opening::default(), Width::best(), &Unobserved)
}

fn bytes_of(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(path) = open.pop() {
        for entry in std::fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// Stops after so many cells.
struct Stops(AtomicUsize);

impl Progress for Stops {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, steps: u64) {
        let left = self.0.load(Ordering::SeqCst);
        self.0.store(left.saturating_sub(steps as usize), Ordering::SeqCst);
    }
    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::SeqCst) == 0
    }
}

#[test]
fn parts_in_any_order_stops_and_repairs_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let atlas = atlas(SMALL).unwrap();
    assert_eq!(
        (atlas.cells(), atlas.layout().units(), atlas.units(Shard::new(1, 4).unwrap())),
        (9, 6, vec![1, 5])
    );
    let whole = atlas.create(&path("whole.zarr")).unwrap();
    let outcome = run(&atlas, &whole, &atlas.units(Shard::WHOLE), &Unobserved).unwrap();
    assert_eq!((outcome.computed, outcome.found, outcome.seconds.len()), (6, 0, 6));
    let expected = bytes_of(&path("whole.zarr"));
    assert!(!expected.keys().any(|name| name.starts_with('.')), "{:?}", expected.keys());

    let parts = atlas.create(&path("parts.zarr")).unwrap();
    for part in [2, 0] {
        run(&atlas, &parts, &atlas.units(Shard::new(part, 3).unwrap()), &Unobserved).unwrap();
    }
    assert_eq!((parts.status().done, parts.seconds().len()), (4, 4));
    let again = run(&atlas, &parts, &atlas.units(Shard::WHOLE), &Unobserved).unwrap();
    assert_eq!((again.computed, again.found), (2, 4));
    assert_eq!(bytes_of(&path("parts.zarr")), expected);

    let stopped = atlas.create(&path("stopped.zarr")).unwrap();
    let error = run(&atlas, &stopped, &atlas.units(Shard::WHOLE), &Stops(AtomicUsize::new(5))).unwrap_err();
    assert!(error.is_interrupted() && stopped.status().done < 6);
    run(&atlas, &stopped, &atlas.units(Shard::WHOLE), &Unobserved).unwrap();
    assert_eq!(bytes_of(&path("stopped.zarr")), expected);

    let file = path("parts.zarr").join("mean/c.1.0.0.0");
    let mut bad = std::fs::read(&file).unwrap();
    bad[5] ^= 1;
    std::fs::write(&file, bad).unwrap();
    assert_eq!(parts.status().damaged, 1);
    assert_eq!(run(&atlas, &parts, &atlas.units(Shard::WHOLE), &Unobserved).unwrap().repaired, 1);
    assert_eq!(bytes_of(&path("parts.zarr")), expected);
}

#[test]
fn cells_are_the_spectra_of_their_structures() {
    use crate::campaign::spectrum::spectra;
    let folder = tempfile::tempdir().unwrap();
    let atlas = atlas(SMALL).unwrap();
    let store = atlas.create(&folder.path().join("s.zarr")).unwrap();
    run(&atlas, &store, &atlas.units(Shard::WHOLE), &Unobserved).unwrap();
    let (mean, srgb) = (store.numbers("mean").unwrap(), store.numbers("srgb").unwrap());
    for cell in [0, 5, 8] {
        let structure = atlas.structure(cell).unwrap();
        let alone = spectra(&structure, &atlas.request(&structure), &Unobserved).unwrap();
        assert_eq!(mean[cell].as_ref().unwrap(), &alone.mean.concat());
        assert_eq!(srgb[cell].as_ref().unwrap().len(), 6);
    }
    assert_eq!(atlas.words(5), "cortex_um 0.4, melanosome_diameter_um 0.3");
    assert!(store.numbers("means").unwrap_err().to_string().contains("no array 'means'"));
}

#[test]
fn another_plan_or_width_does_not_go_on_with_a_store() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    atlas(SMALL).unwrap().create(&path).unwrap();
    atlas(SMALL).unwrap().open(&path).unwrap();
    for (from, to, part) in [
        ("individuals = 2", "individuals = 3", "sweep.plan.individuals: 2 there, 3 here"),
        ("'0.3:0.5:0.1'", "'0.3:0.6:0.1'", "made by another plan"),
        ("unit_cells = 2", "unit_cells = 3", "unit_cells: [1,2] there, [1,3] here"),
        ("structure = 'starling'", "structure = 'starling:pink'\n", "made by another plan"),
    ] {
        let other = atlas(&SMALL.replace(from, to)).unwrap();
        let message = other.create(&path).map(drop).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
    let plan = Plan::parse(SMALL).unwrap();
    let scalar =
        Atlas::new(&plan, Path::new("."), &Opening::default(), Width::scalar(), &Unobserved).unwrap();
    if Width::best().name() != "scalar" {
        let error = scalar.create(&path).map(drop).unwrap_err();
        assert_eq!(error.arguments(), ["width"]);
    }
}

#[test]
fn cells_that_are_no_structure_are_refused_or_empty() {
    // Cores must not fill more than their highest part.
    let text = SMALL
        .replace("melanosome_diameter_um", "core_fraction_high")
        .replace("[0.2, 0.25, 0.3]", "[0.2, 0.7]");
    let message = atlas(&text).map(drop).unwrap_err().to_string();
    assert!(
        message.contains("core_fraction_high 0.2") && message.contains("impossible = \"empty\""),
        "{message}"
    );
    let folder = tempfile::tempdir().unwrap();
    let empty = atlas(&text.replace("unit_cells", "impossible = 'empty'\nunit_cells")).unwrap();
    let store = empty.create(&folder.path().join("s.zarr")).unwrap();
    run(&empty, &store, &empty.units(Shard::WHOLE), &Unobserved).unwrap();
    let mean = store.numbers("mean").unwrap();
    assert!(mean[0].as_ref().unwrap()[0].is_nan() && mean[1].as_ref().unwrap()[0] > 0.0);
    assert_eq!(store.status().done, empty.layout().units());
}

#[test]
fn a_forecast_counts_the_files_that_are_then_there() {
    let folder = tempfile::tempdir().unwrap();
    let atlas = atlas(SMALL).unwrap();
    let forecast = foretell(&atlas, &Unobserved).unwrap();
    assert!(
        forecast.seconds > 0.0 && forecast.memory_bytes > 0 && forecast.core_hours() > 0.0,
        "{forecast:?}"
    );
    let store = atlas.create(&folder.path().join("s.zarr")).unwrap();
    run(&atlas, &store, &atlas.units(Shard::WHOLE), &Unobserved).unwrap();
    assert_eq!(bytes_of(&folder.path().join("s.zarr")).len(), forecast.files);
    assert_eq!(store.bytes(), forecast.bytes);
}

#[test]
fn patches_have_every_cell_and_birds_look_at_each() {
    let text = "barbule = 1
name = 'two patches'
samples = 3
wavelengths_nm = '300:700:50'
individuals = 1
birds = ['starling']

[[patches]]
name = 'thin'
structure = 'air/keratin:200/melanin:300/air'

[[patches]]
name = 'thick'
structure = 'air/keratin:200/melanin:300/air'
[patches.set]
layer2 = 600

[[vary]]
key = 'layer1'
values = '200:400'
";
    let folder = tempfile::tempdir().unwrap();
    let atlas = atlas(text).unwrap();
    let store = atlas.create(&folder.path().join("s.zarr")).unwrap();
    run(&atlas, &store, &atlas.units(Shard::WHOLE), &Unobserved).unwrap();
    let catches = store.numbers("catches_starling").unwrap();
    assert_eq!((catches.len(), catches[0].as_ref().unwrap().len()), (6, 4));
    assert!(atlas.words(4).starts_with("thick, layer1 "));
    assert!(atlas.toml(4).unwrap().contains("melanin:600"));
    let group: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("s.zarr/zarr.json")).unwrap()).unwrap();
    assert_eq!(group["attributes"]["labels"]["patch"], serde_json::json!(["thin", "thick"]));
    assert_eq!(group["attributes"]["coordinates"], "layer1");
    let layer = &group["consolidated_metadata"]["metadata"]["layer1"];
    assert_eq!(
        (&layer["attributes"]["units"], &layer["dimension_names"][0]),
        (&"nm".into(), &"sample".into())
    );
}
