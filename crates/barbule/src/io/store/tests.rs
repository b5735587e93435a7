//! Stores that somebody else wrote or changed.

use std::fs;

use super::*;
use crate::io::hash_bytes;
use crate::spectrum::Wavelengths;

fn axes() -> Axes {
    Axes::new(&Wavelengths::new([450.0, 550.0]).unwrap(), vec![0.5, 1.0], vec![0.25, 0.75]).unwrap()
}

fn unit(shift: f32) -> Unit {
    let singles = |n: usize| (0..n).map(|k| k as f32 + shift).collect();
    let doubles = |n: usize| (0..n).map(|k| k as f64 - f64::from(shift)).collect();
    Unit {
        u: singles(2 * 2 * 400),
        v: singles(2 * 2 * 400),
        autocovariance: singles(2 * 2 * 512),
        reflected: doubles(4),
        reflected_std: doubles(4),
        pattern_correlation: doubles(2),
        contrast: doubles(2),
        fields: (0..2 * 2 * 2 * 3 * 400).map(|k| Complex::new(k as f32, shift)).collect(),
    }
}

fn create(path: &Path) -> Result<Store> {
    Store::create(path, &axes(), 3, "nobody", &json!({"seed": 1}), &[550.0], "scalar")
}

fn message<T>(result: Result<T>) -> String {
    result.err().map(|e| e.to_string()).unwrap_or_default()
}

/// Puts other values into a store's attributes and makes its checksum fit them.
fn forge(path: &Path, change: impl Fn(&mut Value)) {
    let file = path.join("zarr.json");
    let mut group: Value = serde_json::from_str(&read_text(&file).unwrap()).unwrap();
    change(&mut group["attributes"]);
    let mut covered = group["attributes"].clone();
    covered.as_object_mut().unwrap().remove("campaign_hash");
    covered.sort_all_objects();
    group["attributes"]["campaign_hash"] = json!(hash_bytes(covered.to_string().as_bytes()));
    fs::write(file, group.to_string()).unwrap();
}

#[test]
fn units_come_back_with_their_fields() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    let store = create(&path).unwrap();
    for (k, (w, t)) in store.units().enumerate() {
        assert!(!store.is_done(w, t) && store.read(w, t).is_none());
        store.write(w, t, &unit(k as f32)).unwrap();
    }
    let store = create(&path).unwrap();
    assert_eq!(store.status(), Status { units: 4, done: 4, damaged: 0 });
    let back = store.read(1, 0).unwrap();
    assert_eq!(Unit { fields: store.fields(1, 0).unwrap(), ..back }, unit(2.0));
    assert!(store.fields(0, 0).is_none() && !store.keeps(0) && store.keeps(1) && !store.keeps(2));
    assert_eq!(store.statistics().unwrap().u.len(), 4 * 1600);
    // A file per array and unit, of exactly its values and a checksum.
    let sizes: Vec<u64> =
        ["u/c.1.0.0.0.0", "contrast/c.1.0.0"].map(|f| fs::metadata(path.join(f)).unwrap().len()).to_vec();
    assert_eq!(sizes, [4 * 1600 + 4, 8 * 2 + 4]);
}

#[test]
fn chunks_of_a_wrong_length_are_damaged_however_long() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    let store = create(&path).unwrap();
    store.write(0, 0, &unit(0.0)).unwrap();
    let file = path.join("u/c.0.0.0.0.0");
    let good = fs::read(&file).unwrap();
    let longer = [&good[..], &[0; 8]].concat();
    for bad in [&good[..good.len() - 1], &good[4..], &longer, b""] {
        fs::write(&file, bad).unwrap();
        assert!(store.read(0, 0).is_none() && store.status().damaged == 1);
    }
    // A terabyte that is not there.
    fs::File::create(&file).unwrap().set_len(1 << 40).unwrap();
    assert!(store.read(0, 0).is_none());
    fs::remove_file(&file).unwrap();
    fs::create_dir(&file).unwrap();
    assert!(store.read(0, 0).is_none());
    fs::remove_dir(&file).unwrap();
    fs::write(&file, good).unwrap();
    assert!(store.is_whole(0, 0));
}

#[test]
fn axes_that_are_not_the_campaigns_are_refused() {
    type Change = fn(&mut Value);
    let changes: [(Change, &str); 4] = [
        (|a| a["wavelengths_nm"] = json!([450.0, 550.0, 551.0]), "wavelengths_nm"),
        (|a| a["cos_theta_i"] = json!([0.5]), "cos_theta_i"),
        (|a| a["cos_phi_i"] = json!([0.25, 0.75, 1.0]), "cos_phi_i"),
        (|a| a["instances"] = json!(4), "instances"),
    ];
    for (change, key) in changes {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.zarr");
        create(&path).unwrap();
        forge(&path, change);
        // Its arrays fit it: the whole store is of these axes.
        let forged: Value = serde_json::from_str(&read_text(&path.join("zarr.json")).unwrap()).unwrap();
        let (_, arrays) = Attributes::read(&forged["attributes"]).unwrap();
        for array in arrays.all() {
            fs::write(path.join(array.name).join("zarr.json"), array.metadata().to_string()).unwrap();
        }
        let store = Store::open(&path).unwrap();
        let text = message(create(&path));
        assert!(text.contains(&format!("made with other parameters ({key}: ")), "{text}");
        assert!(message(store.check_belongs(&axes(), 3)).contains("than the campaign"));
        // What is asked beyond the axes is not there, and units of other axes are not written.
        assert!(store.read(7, 7).is_none() && store.fields(7, 7).is_none());
        if key == "cos_phi_i" {
            assert!(message(store.write(0, 0, &unit(0.0))).contains("1600 values cannot be a chunk"));
        }
    }
}

/// Made by the version before chunks were left uncompressed: `simulate air/keratin:300/air --wavelengths 450
/// --directions 2x2 --instances 3`.
#[test]
fn stores_of_compressed_chunks_are_read_but_not_continued() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/data/compressed-store"));
    let store = Store::open(path).unwrap();
    assert_eq!(store.status(), Status { units: 2, done: 2, damaged: 0 });
    let statistics = store.statistics().unwrap();
    // As Python's zarr reads them.
    let sum = |values: &[f32]| values.iter().copied().map(f64::from).sum::<f64>();
    let sums = [sum(&statistics.u), sum(&statistics.v), sum(&statistics.autocovariance)];
    for (sum, expected) in
        sums.iter().zip([452.035_715_303_633_4, 209.927_489_370_452_2, 1.092_194_639_304_311])
    {
        assert!((sum - expected).abs() < 1e-9, "{sum} {expected}");
    }
    let reflected = statistics.reflected.iter().sum::<f64>();
    assert!((reflected - 1.993_333_806_245_226).abs() < 1e-14, "{reflected}");
    let again = Store::create(path, store.axes(), 3, store.name(), store.description(), &[], store.width());
    assert!(message(again).contains("read but not continued; give another name"));
}
