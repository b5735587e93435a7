use super::*;
use crate::brdf::Spectral;
use crate::brdf::fixtures::{example, halo};

/// A container with the given header and data.
fn container(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

/// The header of a valid file as JSON, its data, and the description.
fn open(bytes: &[u8]) -> (serde_json::Value, Vec<u8>, serde_json::Value) {
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header: serde_json::Value = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
    let description = serde_json::from_str(header["__metadata__"][ENTRY].as_str().unwrap()).unwrap();
    (header, bytes[8 + length..].to_vec(), description)
}

/// A valid file with its material changed in memory, its description by `edit`, and a checksum that matches.
fn remade(change: impl Fn(&mut Vec<u8>, &mut serde_json::Value, &mut serde_json::Value)) -> Vec<u8> {
    let (mut header, mut data, mut description) = open(&encode_material(&example(2)).unwrap());
    change(&mut data, &mut header, &mut description);
    let parsed: Option<Description> = serde_json::from_value(description.clone()).ok();
    if let Some(parsed) = parsed {
        let mut tensors: Vec<(String, Vec<u8>)> = header
            .as_object()
            .unwrap()
            .iter()
            .filter(|(name, _)| *name != "__metadata__")
            .filter_map(|(name, info)| {
                let at = |k: usize| info["data_offsets"][k].as_u64().map(|v| v as usize);
                Some((name.clone(), data.get(at(0)?..at(1)?)?.to_vec()))
            })
            .collect();
        tensors.sort();
        let bare = Description { checksum: String::new(), ..parsed };
        let sum = checksum_of(&bare, tensors.iter().map(|(n, b)| (n.as_str(), b.as_slice()))).unwrap();
        description["checksum"] = sum.into();
    }
    header["__metadata__"][ENTRY] = serde_json::to_string(&description).unwrap().into();
    container(&header.to_string(), &data)
}

fn put_double(data: &mut [u8], header: &serde_json::Value, name: &str, index: usize, value: f64) {
    let at = header[name]["data_offsets"][0].as_u64().unwrap() as usize + 8 * index;
    data[at..at + 8].copy_from_slice(&value.to_le_bytes());
}

#[test]
fn a_material_survives_its_file() {
    let mut material = example(5);
    material.info = serde_json::json!({ "species": "starling", "list": [1, 2.5, "λ"] });
    let bytes = encode_material(&material).unwrap();
    let back = decode_material(&bytes).unwrap();
    assert_eq!((&back.axes, &back.info, back.seed), (&material.axes, &material.info, material.seed));
    assert_eq!(back.noise_power, material.noise_power);
    let set_arrays = |material: &FeatherMaterial| -> Vec<Vec<f32>> {
        let mut all: Vec<_> =
            arrays(&material.sets[0]).into_iter().map(|(.., values)| values.to_vec()).collect();
        all.push(material.correlation.clone());
        all
    };
    for (a, b) in set_arrays(&back).iter().zip(set_arrays(&material)) {
        for (x, y) in a.iter().zip(&b) {
            // Half a step of the length, and of the slope of a fraction.
            assert!((x / y - 1.0).abs() < 6.5e-5 || (x - y).abs() < 6.2e-5, "{x} {y}");
        }
    }
    // What was read once is stored exactly.
    assert_eq!(encode_material(&back).unwrap(), bytes);
    let mut two = material.clone();
    two.sets[0].fraction_1.clear();
    two.sets[0].fraction_1_slope.clear();
    two.sets.push(two.sets[0].clone());
    assert_eq!(decode_material(&encode_material(&two).unwrap()).unwrap().sets.len(), 2);
    // One lobe takes less room.
    let mut one = material.clone();
    one.sets[0].mean.truncate(1);
    let single = encode_material(&one).unwrap();
    assert!(single.len() + 6 * material.axes.len() <= bytes.len() + 100);
    assert_eq!(decode_material(&single).unwrap().sets[0].mean.len(), 1);
}

#[test]
fn a_halo_survives_its_file_and_files_without_one_stay_as_they_were() {
    let material = FeatherMaterial { halo: Some(halo()), ..example(2) };
    let bytes = encode_material(&material).unwrap();
    assert_eq!(decode_material(&bytes).unwrap().halo, material.halo);
    assert_eq!(open(&bytes).2["schema"], 5);
    let plain = FeatherMaterial { spectral: Spectral::default(), ..example(2) };
    let without = encode_material(&plain).unwrap();
    assert_eq!(open(&without).2["schema"], 5);
    assert_eq!(decode_material(&without).unwrap().halo, None);
    assert_eq!(decode_material(&without).unwrap().spectral, Spectral::default());
    let back = decode_material(&encode_material(&example(2)).unwrap()).unwrap();
    assert_eq!((back.spectral, back.halo), (example(2).spectral, None));
    let mut wrong = material.clone();
    wrong.halo.as_mut().unwrap().power[1] = f32::NAN;
    assert!(encode_material(&wrong).unwrap_err().to_string().contains("halo_power[1] = NaN"));
}

#[test]
fn the_default_sampling_fits_into_600_kb() {
    let size = encode_material(&example(50)).unwrap().len();
    assert!(size < 600_000, "{size}");
}

#[test]
fn codes_keep_zero_one_and_the_ends() {
    assert_eq!(Map::Azimuth.value(Map::Azimuth.code(0.0)), 0.0);
    assert_eq!(Map::Length.value(Map::Length.code(1.0)), 1.0);
    for (map, value) in
        [(Map::Roughness, 1.0), (Map::Roughness, 0.001), (Map::Fraction, 0.0), (Map::Fraction, 1.0)]
    {
        assert!((map.value(map.code(value)) - value).abs() < 1e-9);
    }
}

/// A file whose description has another value of a key.
fn with(key: &str, value: serde_json::Value) -> Vec<u8> {
    remade(|_, _, description| description[key] = value.clone())
}

/// A file without an array: another name keeps the container valid.
fn without(name: &str) -> Vec<u8> {
    remade(|_, header, _| {
        let info = header.as_object_mut().unwrap().remove(name).unwrap();
        header["spare"] = info;
    })
}

fn with_shape(name: &str, shape: serde_json::Value) -> Vec<u8> {
    remade(|_, header, _| header[name]["shape"] = shape.clone())
}

fn with_double(name: &str, index: usize, value: f64) -> Vec<u8> {
    remade(|data, header, _| put_double(data, header, name, index, value))
}

/// The first number of an array in single precision.
fn with_single(name: &str, value: f32) -> Vec<u8> {
    with_bytes(name, &value.to_le_bytes())
}

/// The first code of an array.
fn with_code(name: &str, code: u16) -> Vec<u8> {
    with_bytes(name, &code.to_le_bytes())
}

/// The first bytes of an array.
fn with_bytes(name: &str, bytes: &[u8]) -> Vec<u8> {
    remade(|data, header, _| {
        let at = header[name]["data_offsets"][0].as_u64().unwrap() as usize;
        data[at..at + bytes.len()].copy_from_slice(bytes);
    })
}

fn flipped(good: &[u8], at: usize) -> Vec<u8> {
    let mut bytes = good.to_vec();
    bytes[at] ^= 0x10;
    bytes
}

/// Another seed, with the checksum of before.
fn edited(good: &[u8]) -> Vec<u8> {
    let mut bytes = good.to_vec();
    let at = good.windows(8).position(|w| w == b"seed\\\":1").unwrap() + 7;
    bytes[at] = b'2';
    bytes
}

/// A description of 5000 lists in each other.
fn deep() -> Vec<u8> {
    let deep = format!("{{\"schema\":5,\"info\":{}1{}}}", "[".repeat(5000), "]".repeat(5000));
    container(&serde_json::json!({"__metadata__": {ENTRY: deep}}).to_string(), &[])
}

/// What is wrong with a file; such a file, made of a good one; and what the refusal has to say.
type Malformed = (&'static str, fn(&[u8]) -> Vec<u8>, &'static str);

const MALFORMED: &[Malformed] = &[
    ("empty", |_| vec![], "not a material file"),
    ("one byte", |_| vec![1], "not a material file"),
    ("text", |_| b"hello, this is no material".to_vec(), "not a material file"),
    ("png", |_| b"\x89PNG\r\n\x1a\n0000000000000".to_vec(), "not a material file"),
    ("header too long", |_| u64::MAX.to_le_bytes().to_vec(), "not a material file"),
    ("header past the end", |_| 4096_u64.to_le_bytes().to_vec(), "not a material file"),
    ("half a file", |good| good[..good.len() / 2].to_vec(), "not a material file"),
    ("a byte short", |good| good[..good.len() - 1].to_vec(), "not a material file"),
    ("bytes appended", |good| [good, &[0; 9]].concat(), "not a material file"),
    ("empty header", |good| container("{}", &open(good).1), "not a material file"),
    ("header no JSON", |good| container("{", &open(good).1), "not a material file"),
    ("header a list", |good| container("[1]", &open(good).1), "not a material file"),
    (
        "no metadata",
        |_| container("{\"a\":{\"dtype\":\"F32\",\"shape\":[0],\"data_offsets\":[0,0]}}", &[]),
        "no entry 'barbule'",
    ),
    ("other metadata", |_| container("{\"__metadata__\":{\"format\":\"pt\"}}", &[]), "no entry 'barbule'"),
    ("description no JSON", |_| container("{\"__metadata__\":{\"barbule\":\"x\"}}", &[]), "not valid"),
    (
        "description empty",
        |_| container("{\"__metadata__\":{\"barbule\":\"{}\"}}", &[]),
        "missing field `schema`",
    ),
    ("description deep", |_| deep(), "not valid"),
    ("schema 3", |_| with("schema", 3.into()), "schema 3, but this program reads schema 5; fit it again"),
    ("schema text", |_| with("schema", "one".into()), "not valid"),
    ("schema negative", |_| with("schema", (-1).into()), "not valid"),
    (
        "no sigma",
        |_| remade(|_, _, d| drop(d.as_object_mut().unwrap().remove("sigma"))),
        "missing field `sigma`",
    ),
    ("sigma text", |_| with("sigma", "wide".into()), "not valid"),
    ("sigma zero", |_| with("sigma", 0.0.into()), "sigma is 0"),
    ("sigma large", |_| with("sigma", 3.0.into()), "sigma is 3"),
    ("sigma null", |_| with("sigma", serde_json::Value::Null), "not valid"),
    ("seed negative", |_| with("seed", (-3).into()), "not valid"),
    ("kind unknown", |_| with("kind", "ggx".into()), "'ggx'"),
    ("kind long", |_| with("kind", "x".repeat(5000).into()), "must be 'marginal' or 'cone'"),
    ("map unknown", |_| remade(|_, _, d| d["maps"]["m"] = "k".into()), "array m has another map"),
    ("no maps", |_| with("maps", serde_json::json!({})), "has another map"),
    ("seed edited", edited, "checksum"),
    ("data flipped", |good| flipped(good, good.len() - 5), "checksum"),
    ("data flipped early", |good| flipped(good, good.len() - open(good).1.len() + 3), "checksum"),
    ("no m", |_| without("m"), "array m is missing"),
    ("no share_sta", |_| without("share_sta"), "array share_sta is missing"),
    ("no fraction_1", |_| without("fraction_1"), "array fraction_1 is missing"),
    ("no wavelengths", |_| without("wavelengths_nm"), "array wavelengths_nm is missing"),
    ("no noise", |_| without("noise_power"), "array noise_power is missing"),
    ("wrong type", |_| remade(|_, h, _| h["m"]["dtype"] = "I16".into()), "array m has type I16"),
    (
        "axis of wrong type",
        |_| remade(|_, h, _| h["cos_phi"]["dtype"] = "I64".into()),
        "array cos_phi has type I64",
    ),
    ("no steepness", |_| without("steepness"), "array steepness is missing"),
    (
        "steepness of wrong type",
        |_| remade(|_, h, _| h["steepness"]["dtype"] = "I32".into()),
        "array steepness has type I32",
    ),
    ("strength flat", |_| with_shape("strength", serde_json::json!([400])), "array strength has shape"),
    ("strength nan", |_| with_single("strength", f32::NAN), "strength[0] = NaN"),
    ("strength over one", |_| with_single("strength", 1.5), "strength[0] = 1.5"),
    ("steepness negative", |_| with_single("steepness", -1.0), "steepness[0] = -1"),
    ("shape transposed", |_| with_shape("m", serde_json::json!([20, 20, 2])), "array m has shape"),
    ("shape flat", |_| with_shape("phi", serde_json::json!([800])), "array phi has shape"),
    (
        "shape huge",
        |_| with_shape("phi", serde_json::json!([1_u64 << 62, 1_u64 << 62, 4])),
        "not a material file",
    ),
    (
        "axis of two dimensions",
        |_| with_shape("cos_theta", serde_json::json!([4, 5])),
        "array cos_theta has 2 dimensions",
    ),
    ("wavelength nan", |_| with_double("wavelengths_nm", 0, f64::NAN), "wavelengths_nm[0] = NaN"),
    ("wavelength negative", |_| with_double("wavelengths_nm", 0, -400.0), "wavelengths_nm[0] = -400"),
    (
        "wavelengths fall",
        |_| with_double("wavelengths_nm", 1, 300.0),
        "wavelengths_nm[1] = 300 does not exceed",
    ),
    ("cosine zero", |_| with_double("cos_theta", 0, 0.0), "cos_theta[0] = 0"),
    ("cosine over one", |_| with_double("cos_phi", 19, 1.5), "cos_phi[19] = 1.5"),
    ("cosine infinite", |_| with_double("cos_phi", 19, f64::INFINITY), "cos_phi[19] = inf"),
    ("cosines equal", |_| with_double("cos_theta", 3, 0.15), "cos_theta[3]"),
    ("noise negative", |_| with_double("noise_power", 7, -0.1), "noise_power[7] = -0.1"),
    ("noise nan", |_| with_double("noise_power", 0, f64::NAN), "noise_power[0] = NaN"),
    ("noise without unit variance", |_| with_double("noise_power", 0, 0.4), "noise_power sums to"),
];

/// Every malformed file is refused in one sentence that names the fault.
#[test]
fn malformed_files_are_refused_by_name() {
    let good = encode_material(&example(2)).unwrap();
    for (name, make, fragment) in MALFORMED {
        let error = decode_material(&make(&good)).map(|_| ()).expect_err(name).at("bad.barbule");
        let text = error.to_string();
        assert!(error.is_input(), "{name}: {text}");
        assert!(text.contains(fragment), "{name}: '{text}' lacks '{fragment}'");
        assert!(text.len() < 600 && !text.ends_with('.') && !text.contains('\n'), "{name}: {text}");
        if let Some(array) = fragment.strip_prefix("array ").and_then(|rest| rest.split(' ').next()) {
            assert_eq!(error.key(), Some(array), "{name}");
        }
    }
}

#[test]
fn codes_at_their_ends_are_valid_values() {
    for (name, value) in [("m", 0), ("m", 65535), ("phi", 0), ("length", 0), ("share_sta", 65535)] {
        decode_material(&with_code(name, value)).unwrap();
    }
}

#[test]
fn random_damage_never_panics() {
    let good = encode_material(&example(1)).unwrap();
    let mut stream = crate::math::rng::Stream::new(4, &[]);
    for _ in 0..3000 {
        let mut bytes = good[..good.len().min(4000 + (stream.unit() * good.len() as f64) as usize)].to_vec();
        for _ in 0..1 + (stream.unit() * 4.0) as usize {
            let header_first =
                if stream.unit() < 0.7 { 1500.0_f64.min(bytes.len() as f64) } else { bytes.len() as f64 };
            let at = (stream.unit() * header_first) as usize;
            bytes[at] = stream.bits() as u8;
        }
        let _ = decode_material(&bytes);
    }
}
