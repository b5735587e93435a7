//! Stores that somebody else wrote or changed.

use std::fs;

use super::*;
use crate::io::hash_bytes;
use crate::io::zarr::DataType;
use crate::scattering::statistics::Sides;
use crate::spectrum::Wavelengths;

fn axes() -> Axes {
    Axes::new(&Wavelengths::new([450.0, 550.0]).unwrap(), vec![0.5, 1.0], vec![0.25, 0.75]).unwrap()
}

fn unit(shift: f32) -> UnitStatistics {
    let singles = |n: usize| (0..n).map(|k| k as f32 + shift).collect();
    let doubles = |n: usize| (0..n).map(|k| 9.0 + k as f64 - f64::from(shift)).collect();
    UnitStatistics {
        u: singles(2 * 2 * 400),
        v: singles(2 * 2 * 400),
        autocovariance: singles(2 * 2 * 512),
        reflected: doubles(4),
        reflected_std: doubles(4),
        pattern_correlation: doubles(2),
        unpolarized_contrast: doubles(2),
        contrast: singles(2 * 2 * 400),
        glints: singles(2 * 5 * 3),
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
    assert_eq!(UnitStatistics { fields: store.fields(1, 0).unwrap(), ..back }, unit(2.0));
    assert!(store.fields(0, 0).is_none() && !store.keeps(0) && store.keeps(1) && !store.keeps(2));
    assert_eq!(store.statistics().unwrap().u.len(), 4 * 1600);
    // A file per array and unit, of exactly its values and a checksum.
    let files = ["u/c.1.0.0.0.0", "unpolarized_contrast/c.1.0.0", "digest/c.1.0.0"];
    let sizes = files.map(|f| fs::metadata(path.join(f)).unwrap().len());
    assert_eq!(sizes, [4 * 1600 + 4, 8 * 2 + 4, 8 * 10 + 4]);
}

#[test]
fn both_signs_of_phi_come_back_and_are_another_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    let both = axes().with_sides(Sides::Both);
    let create_both =
        |path: &Path| Store::create(path, &both, 3, "nobody", &json!({"seed": 1}), &[], "scalar");
    let store = create_both(&path).unwrap();
    let [right, left] = [unit(1.0), unit(2.0)];
    let wide = UnitStatistics {
        u: [right.u, left.u].concat(),
        v: [right.v, left.v].concat(),
        autocovariance: [right.autocovariance, left.autocovariance].concat(),
        reflected: [right.reflected, left.reflected].concat(),
        reflected_std: [right.reflected_std, left.reflected_std].concat(),
        pattern_correlation: [right.pattern_correlation, left.pattern_correlation].concat(),
        unpolarized_contrast: [right.unpolarized_contrast, left.unpolarized_contrast].concat(),
        contrast: [right.contrast, left.contrast].concat(),
        glints: [right.glints, left.glints].concat(),
        fields: Vec::new(),
    };
    for (w, t) in store.units() {
        store.write(w, t, &wide).unwrap();
    }
    let store = Store::open(&path).unwrap();
    assert_eq!((store.axes(), store.axes().phis()), (&both, 4));
    assert_eq!(store.statistics().unwrap().u[..3200], wide.u[..]);
    assert!(store.check_belongs(&axes(), 3).is_err());
    assert!(message(store.write(0, 0, &unit(0.0))).contains("1600 values cannot be a chunk"));
    let alike = folder.path().join("t.zarr");
    Store::create(&alike, &axes(), 3, "nobody", &json!({"seed": 1}), &[], "scalar").unwrap();
    let text = message(create_both(&alike));
    assert!(text.contains("sides: \"alike\" there, \"both\" here"), "{text}");
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

/// Gives a chunk other bytes with a checksum that fits.
fn seal(file: &Path, change: impl Fn(&mut Vec<u8>)) {
    let array = Array { data_type: DataType::UInt64, ..create_array() };
    let mut bytes = fs::read(file).unwrap();
    bytes.truncate(bytes.len() - 4);
    change(&mut bytes);
    let words: Vec<u64> = bytes.as_chunks::<8>().0.iter().map(|b| u64::from_le_bytes(*b)).collect();
    let shape = vec![words.len()];
    let array = Array { chunk_shape: shape.clone(), shape, ..array };
    fs::write(file, array.encode(&words).unwrap()).unwrap();
}

fn create_array() -> Array {
    Array {
        name: "a",
        data_type: DataType::UInt64,
        shape: Vec::new(),
        chunk_shape: Vec::new(),
        dimension_names: Vec::new(),
        units: "",
        meaning: "",
    }
}

#[test]
fn chunks_of_other_units_and_campaigns_are_damaged_though_their_checksums_hold() {
    let folder = tempfile::tempdir().unwrap();
    let (path, other) = (folder.path().join("s.zarr"), folder.path().join("t.zarr"));
    let store = create(&path).unwrap();
    let elsewhere =
        Store::create(&other, &axes(), 3, "other", &json!({"seed": 2}), &[550.0], "scalar").unwrap();
    for (k, (w, t)) in store.units().enumerate() {
        store.write(w, t, &unit(k as f32)).unwrap();
        elsewhere.write(w, t, &unit(k as f32)).unwrap();
    }
    let all = |name: &str| {
        store.units().map(|(w, t)| path.join(format!("{name}/c.{w}.{t}.0.0.0"))).collect::<Vec<_>>()
    };
    for files in [all("u"), all("v"), all("autocovariance")] {
        let (a, b) = (fs::read(&files[0]).unwrap(), fs::read(&files[1]).unwrap());
        fs::write(&files[0], &b).unwrap();
        fs::write(&files[1], &a).unwrap();
        assert_eq!(store.status().damaged, 2);
        fs::write(&files[0], a).unwrap();
        fs::write(&files[1], b).unwrap();
        assert_eq!(store.status().damaged, 0);
    }
    // Fields of another unit.
    fs::copy(path.join("fields/c.0.0.0.0.0.0.0"), path.join("fields/c.0.1.0.0.0.0.0")).unwrap();
    assert_eq!(store.status().damaged, 1);
    assert!(store.fields(1, 0).is_some() && store.fields(1, 1).is_none());
    store.write(1, 1, &unit(3.0)).unwrap();
    // A whole unit of another campaign with the same numbers.
    for array in store.arrays.unit.iter().chain([&store.arrays.digest]) {
        let key = array.chunk_path(&[0, 0]);
        fs::copy(other.join(&key), path.join(&key)).unwrap();
    }
    assert!(store.is_done(0, 0) && store.read(0, 0).is_none());
    assert_eq!(store.status(), Status { units: 4, done: 3, damaged: 1 });
}

#[test]
fn values_that_no_reflection_has_are_not_read_and_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    let store = create(&path).unwrap();
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        let mut broken = unit(0.0);
        broken.u[7] = bad;
        let error = store.write(0, 0, &broken).unwrap_err();
        assert!(error.is_not_settled() && error.to_string().contains("450 nm and cosθ = 0.5"), "{error}");
    }
    assert_eq!(fs::read_dir(path.join("u")).unwrap().count(), 1);
    // As somebody would write it who makes checksums and digests fit.
    for bad in [f32::NAN, -1.0] {
        store.write(0, 0, &unit(0.0)).unwrap();
        let file = path.join("u/c.0.0.0.0.0");
        seal(&file, |bytes| bytes[..4].copy_from_slice(&bad.to_le_bytes()));
        let digest = store.digest_of("u/c.0.0.0.0.0", &fs::read(&file).unwrap());
        seal(&path.join("digest/c.0.0.0"), |bytes| bytes[..8].copy_from_slice(&digest.to_le_bytes()));
        assert_eq!(store.digest([0, 0]).unwrap()[0], digest);
        assert!(store.is_done(0, 0) && store.read(0, 0).is_none(), "{bad}");
    }
    // What nothing reflects has no contrast.
    let mut dark = unit(0.0);
    dark.unpolarized_contrast.fill(f64::NAN);
    dark.pattern_correlation.fill(f64::NAN);
    store.write(0, 0, &dark).unwrap();
    assert!(store.read(0, 0).is_some());
}

#[test]
fn the_order_of_keys_in_a_description_does_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    create(&path).unwrap();
    let file = path.join("zarr.json");
    let mut group: Value = serde_json::from_str(&read_text(&file).unwrap()).unwrap();
    let before = group.to_string();
    group.sort_all_objects();
    assert_ne!(group.to_string(), before);
    fs::write(file, group.to_string()).unwrap();
    Store::open(&path).unwrap();
    create(&path).unwrap();
}

#[test]
fn every_dimension_but_that_of_digests_has_its_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    let store = create(&path).unwrap();
    let named: Vec<&str> = store.arrays.all().flat_map(|array| array.dimension_names.clone()).collect();
    for name in named.into_iter().filter(|name| *name != "array") {
        assert!(path.join(name).join("c.0").is_file(), "{name}");
    }
    let numbers = |name: &str| {
        let bytes = fs::read(path.join(name).join("c.0")).unwrap();
        let words = bytes[..bytes.len() - 4].as_chunks::<8>().0;
        words.iter().map(|b| f64::from_le_bytes(*b)).collect::<Vec<f64>>()
    };
    assert_eq!(numbers("wavelength"), [450.0, 550.0]);
    assert_eq!(numbers("kept_wavelength"), [550.0]);
    let theta = numbers("theta_i");
    assert!((theta[0] - 60.0).abs() < 1e-12 && theta[1] == 0.0, "{theta:?}");
    let azimuth = numbers("azimuth");
    assert!((azimuth[0] + 89.775).abs() < 1e-12 && (azimuth[399] - 89.775).abs() < 1e-12);
    assert_eq!((numbers("lag")[1], numbers("lag").len()), (2.0 / 1024.0, 512));
    // Somebody changed one and lost another: they say what the attributes say again when the store is continued.
    let files = ["wavelength/c.0", "lag/c.0"].map(|name| path.join(name));
    let before = files.clone().map(|file| fs::read(file).unwrap());
    assert!(store.damaged_coordinates().is_empty());
    let mut flipped = before[0].clone();
    flipped[3] ^= 1;
    fs::write(&files[0], flipped).unwrap();
    fs::remove_file(&files[1]).unwrap();
    assert_eq!(Store::open(&path).unwrap().damaged_coordinates(), ["wavelength", "lag"]);
    store.prepare_writing().unwrap();
    assert_eq!(files.map(|file| fs::read(file).unwrap()), before);
    assert!(store.damaged_coordinates().is_empty());
    assert!(!path.join(".aside").exists());
}

#[test]
fn what_killed_creators_leave_is_swept_though_the_store_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    create(&path).unwrap();
    fs::create_dir_all(folder.path().join(".s.zarr.new-dead/u")).unwrap();
    fs::create_dir(folder.path().join(".other.zarr.new-dead")).unwrap();
    let store = create(&path).unwrap();
    store.prepare_writing().unwrap();
    store.end_writing();
    let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, [".other.zarr.new-dead", "s.zarr"]);
}

#[test]
fn places_where_no_store_can_be_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.zarr");
    create(&path).unwrap();
    for (place, part) in [
        (PathBuf::from("."), "give one, as in S.zarr"),
        (folder.path().join(".."), "give one, as in S.zarr"),
        (path.join("inner.zarr"), "inside another campaign store"),
        (path.join("u"), "inside another campaign store"),
        (folder.path().join("no/s.zarr"), "does not exist"),
    ] {
        let text = message(create(&place));
        assert!(text.contains(part), "{}: {text}", place.display());
    }
    #[cfg(unix)]
    {
        let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, folder.path().join(name)).unwrap();
        fs::create_dir(folder.path().join("empty")).unwrap();
        link("empty", "to-empty");
        link("new.zarr", "to-new");
        for (name, real) in [("to-empty", "empty"), ("to-new", "new.zarr")] {
            create(&folder.path().join(name)).unwrap();
            assert!(folder.path().join(real).join("zarr.json").is_file(), "{name}");
            assert!(fs::symlink_metadata(folder.path().join(name)).unwrap().is_symlink());
        }
    }
}
