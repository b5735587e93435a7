//! Stores of sweeps by themselves.

use std::fs;

use serde_json::json;

use super::super::arrays::Numbers;
use super::*;

fn layout() -> SweepLayout {
    let axis = |name: &str, values: Vec<f64>| SweepAxis {
        name: name.into(),
        units: "um".into(),
        meaning: "test".into(),
        values: Numbers::Floats(values),
        labels: Vec::new(),
    };
    let array = |name: &str, is_bytes| SweepArray {
        name: name.into(),
        units: String::new(),
        meaning: "test".into(),
        along: vec!["wavelength".into()],
        is_bytes,
    };
    SweepLayout {
        name: "test".into(),
        width: "scalar".into(),
        cells: vec![axis("a_um", vec![1.0, 2.0, 3.0]), axis("b_um", vec![1.0, 2.0, 3.0, 4.0, 5.0])],
        block: vec![2, 2],
        further: vec![axis("wavelength", vec![400.0, 500.0])],
        coordinates: Vec::new(),
        arrays: vec![array("mean", false), array("colour", true)],
        with_materials: false,
        description: json!({"seed": 1}),
    }
}

fn unit(layout: &SweepLayout, unit: usize) -> SweepUnit {
    let cells: Vec<usize> = layout.cells_of(unit).into_iter().flatten().collect();
    let values =
        |f: &dyn Fn(usize) -> f64| cells.iter().flat_map(|cell| [f(*cell), f(*cell) + 0.5]).collect();
    let bytes = cells.iter().flat_map(|cell| [*cell as u8, 0]).collect();
    SweepUnit {
        values: vec![SweepValues::Floats(values(&|cell| cell as f64)), SweepValues::Bytes(bytes)],
        materials: Vec::new(),
    }
}

fn message<T>(result: Result<T>) -> String {
    result.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn every_cell_is_in_one_unit() {
    let layout = layout();
    assert_eq!((layout.count(), layout.units()), (15, 6));
    let mut all: Vec<usize> = (0..6).flat_map(|unit| layout.cells_of(unit)).flatten().collect();
    all.sort_unstable();
    assert_eq!(all, (0..15).collect::<Vec<_>>());
    assert_eq!(layout.cells_of(5), [Some(14), None, None, None]);
    assert_eq!(layout.place_of(14), [2, 4]);
}

#[test]
fn units_come_back_and_damage_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    let store = SweepStore::create(&path, layout()).unwrap();
    for number in 0..6 {
        assert!(!store.is_done(number));
        store.write(number, &unit(store.layout(), number), 0.25).unwrap();
    }
    assert_eq!((store.seconds(), store.status()), (vec![0.25; 6], Status { units: 6, done: 6, damaged: 0 }));
    store.end_writing();
    assert!(store.seconds().is_empty() && !path.join(TIMES).exists());
    let mean = store.numbers("mean").unwrap();
    assert!((0..15).all(|cell| mean[cell] == Some(vec![cell as f64, cell as f64 + 0.5])));
    // Whole files in each other's places.
    let files = ["mean/c.0.0.0", "mean/c.0.1.0"].map(|name| path.join(name));
    let bytes = files.clone().map(|file| fs::read(file).unwrap());
    fs::write(&files[0], &bytes[1]).unwrap();
    fs::write(&files[1], &bytes[0]).unwrap();
    assert_eq!(store.status().damaged, 2);
    fs::write(&files[0], &bytes[0]).unwrap();
    fs::write(&files[1], &bytes[1]).unwrap();
    assert_eq!(store.status().damaged, 0);
    fs::File::create(&files[0]).unwrap().set_len(1 << 40).unwrap();
    assert!(store.read(0).is_none());
}

#[test]
fn coordinates_are_restored_and_other_stores_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    let store = SweepStore::create(&path, layout()).unwrap();
    for name in ["a_um/c.0", "mean/zarr.json", "digest/zarr.json"] {
        let file = path.join(name);
        let before = fs::read(&file).unwrap();
        fs::remove_file(&file).unwrap();
        store.prepare_writing().unwrap();
        assert_eq!(fs::read(&file).unwrap(), before);
        fs::write(&file, b"{}").unwrap();
        store.prepare_writing().unwrap();
        assert_eq!(fs::read(&file).unwrap(), before);
    }
    assert_eq!(
        (SweepStore::width_of(&path).as_deref(), SweepStore::width_of(folder.path())),
        (Some("scalar"), None)
    );
    let damaged = fs::read_to_string(path.join("zarr.json")).unwrap();
    let lines = "x\\n".repeat(5000);
    fs::write(path.join("zarr.json"), damaged.replace("\"scalar\"", &format!("\"{lines}\""))).unwrap();
    let long = message(SweepStore::open(&path, layout()));
    assert!(long.len() < 600 && !long.contains('\n'), "{long}");
    fs::write(path.join("zarr.json"), damaged).unwrap();
    let other = SweepLayout { description: json!({"seed": 2}), ..layout() };
    assert!(message(SweepStore::create(&path, other)).contains("sweep.seed: 1 there, 2 here"));
    let wider = SweepLayout { width: "wide".into(), ..layout() };
    assert!(message(SweepStore::create(&path, wider)).contains("computed with scalar instructions"));
    assert!(
        message(crate::io::store::Store::open(&path)).contains("is an atlas, not the store of a campaign")
    );
    assert!(message(SweepStore::create(&path.join("inner.zarr"), layout())).contains("inside another store"));
    assert!(message(SweepStore::open(&folder.path().join("none.zarr"), layout())).contains("no such store"));
}

#[test]
fn layouts_that_no_store_can_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    let mut twice = layout();
    twice.arrays[0].name = "a_um".into();
    assert!(
        message(SweepStore::create(&path, twice)).contains("two things in the store would be called 'a_um'")
    );
    let mut many = layout();
    many.cells[0].values = Numbers::Counts((0..300_000).collect());
    assert!(message(SweepStore::create(&path, many)).contains("1500000 cells"));
    let mut none = layout();
    none.cells[0].values = Numbers::Floats(Vec::new());
    assert!(message(SweepStore::create(&path, none)).contains("the sweep has 0 cells"));
    assert!(!path.exists());
}

#[test]
fn values_that_are_not_finite_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let store = SweepStore::create(&folder.path().join("s.zarr"), layout()).unwrap();
    let mut bad = unit(store.layout(), 0);
    bad.values[0] = SweepValues::Floats(vec![f64::INFINITY; 8]);
    assert!(store.write(0, &bad, 0.0).unwrap_err().is_not_settled());
    bad.values[0] = SweepValues::Floats(vec![0.0; 7]);
    assert!(message(store.write(0, &bad, 0.0)).contains("other values of 'mean'"));
}
