use super::*;
use crate::structure::{SpeciesModel, species_names};

const GOOD: &str = r#"{"barbule": 1, "units": "um", "width": 2.0, "name": "a",
  "boundaries": [{"x": [-1, 0, 1], "z": [0, 0, 0]}, {"x": [-1, 0, 1], "z": [-1, -1, -1]}],
  "media": ["air", "keratin", {"mix": ["keratin", "melanin"], "x": [-1, 1], "fraction": [0.1, 0.9]}],
  "inclusions": [{"x": [-0.5, 0.5, 0.5, -0.5], "z": [-0.2, -0.2, -0.8, -0.8], "medium": "melanin",
                  "holes": [{"circle": {"x": 0.0, "z": -0.5, "radius": 0.2}}]},
                 {"circle": {"x": 0.0, "z": -0.5, "radius": 0.1}, "medium": {"index": [1.5, 0.1]}}],
  "source": "a test"}"#;

fn parse(text: &str) -> Result<Section> {
    parse_section(text, Path::new("."), &Library::builtin())
}

#[test]
fn a_section_with_everything_is_read_and_nesting_follows_containment() {
    let section = parse(GOOD).unwrap();
    let at = |x, z| section.medium_at(x, z).substances().next().unwrap().label();
    assert_eq!(at(0.0, 1.0), "air");
    assert_eq!(at(-0.8, -0.5), "keratin");
    assert_eq!(at(0.3, -0.5), "melanin");
    // The hole shows the keratin around its inclusion, and holds an inclusion of its own.
    assert_eq!(at(0.15, -0.5), "keratin");
    assert_eq!(at(0.0, -0.5), "n = 1.5+0.1j");
    assert!((section.media[2].fraction(0.5) - 0.7).abs() < 1e-15);
}

#[test]
fn rays_see_holes_and_what_is_in_them() {
    use crate::structure::{Ray, cast};
    let section = parse(GOOD).unwrap();
    let columns = cast(&section, &[Ray { x_um: 0.0, z_um: 0.0, normal: [0.0, 1.0] }]).unwrap();
    let layers: Vec<f64> = columns.thickness_um[..columns.slots - 1].to_vec();
    let expected = [0.2, 0.1, 0.1, 0.2, 0.1, 0.1, 0.2];
    assert_eq!(layers.len(), expected.len());
    assert!(layers.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{layers:?}");
}

#[test]
fn inclusions_alone_make_a_section_without_a_top() {
    let text = r#"{"barbule": 1, "units": "um", "inclusions": [{"circle": {"x": 1, "z": 0, "radius": 0.5}, "medium": "melanin"}]}"#;
    let section = parse(text).unwrap();
    assert_eq!((section.width_um, section.media.len()), (1.0, 1));
    assert!(crate::structure::cast(&section, &[]).unwrap_err().to_string().contains("no top boundary"));
}

#[test]
fn written_sections_come_back_to_the_same_bits() {
    for name in species_names() {
        let section = SpeciesModel::builtin(name, None, Library::builtin()).unwrap().section(3, 1).unwrap();
        assert_eq!(parse(&section_json(&section).to_string()).unwrap(), section, "{name}");
    }
    let section = parse(GOOD).unwrap();
    assert_eq!(parse(&section_json(&section).to_string()).unwrap(), section);
}

#[test]
fn users_materials_are_found_beside_the_file_and_kept_in_what_is_written() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("chitin.csv"), "300,1.6\n830,1.55\n").unwrap();
    let text = GOOD
        .replace("\"width\"", "\"materials\": {\"chitin\": \"chitin.csv\", \"glass\": [1.5, 0.0]}, \"width\"")
        .replace("\"keratin\", {", "\"chitin\", {");
    let path = folder.path().join("a.json");
    std::fs::write(&path, text).unwrap();
    let section = read_section(&path, &Library::builtin()).unwrap();
    let other = tempfile::tempdir().unwrap();
    let copy = other.path().join("b.json");
    write_section(&copy, &section).unwrap();
    assert_eq!(read_section(&copy, &Library::builtin()).unwrap(), section);
}

#[test]
fn a_folder_holds_the_instances_of_one_structure() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["b", "a"] {
        std::fs::write(
            folder.path().join(format!("{name}.json")),
            GOOD.replace("\"a\"", &format!("\"{name}\"")),
        )
        .unwrap();
    }
    let names: Vec<String> =
        read_sections(folder.path(), &Library::builtin()).unwrap().into_iter().map(|s| s.name).collect();
    assert_eq!(names, ["a", "b"]);
    let wide = GOOD.replace("\"width\": 2.0", "\"width\": 4.0").replace("[-1, 0, 1]", "[-2, 0, 2]");
    std::fs::write(folder.path().join("c.json"), wide).unwrap();
    let message = read_sections(folder.path(), &Library::builtin()).unwrap_err().to_string();
    assert!(message.contains("must have one width"), "{message}");
}

/// What is replaced in the good section, by what, and what the refusal must say.
const BAD: &[(&str, &str, &str)] = &[
    ("\"barbule\": 1,", "", "barbule is missing"),
    ("\"barbule\": 1,", "\"barbule\": 2,", "reads format 1 only"),
    ("\"barbule\": 1,", "\"barbule\": \"1\",", "barbule is the text '1', but must be a number"),
    ("\"units\": \"um\",", "", "units is missing"),
    ("\"units\": \"um\"", "\"units\": \"nm\"", "units is 'nm'"),
    ("\"units\": \"um\"", "\"units\": 1", "units is the number 1, but must be a text"),
    ("\"width\"", "\"widht\"", "unknown key 'widht', did you mean 'width'?"),
    ("\"width\": 2.0", "\"width\": 0", "width is 0 µm"),
    ("\"width\": 2.0", "\"width\": -2", "width is -2 µm"),
    ("\"width\": 2.0", "\"width\": 5000", "at most 2000"),
    ("\"width\": 2.0", "\"width\": 25.0", "boundaries[0] spans 2 µm"),
    ("\"width\": 2.0,", "", "width is missing"),
    ("\"width\": 2.0", "\"width\": null", "width is not a finite number"),
    ("\"name\": \"a\"", "\"name\": []", "name is a list"),
    ("\"name\": \"a\"", "\"lattice\": {}", "lattice.rod is missing"),
    ("\"name\": \"a\"", "\"name\": \"a\" \"b\"", "is not JSON"),
    (
        "\"x\": [-1, 0, 1], \"z\": [0, 0, 0]",
        "\"x\": [-1, 1], \"z\": [0, 0]",
        "boundaries[0] has 2 points, fewer than 3",
    ),
    ("\"z\": [0, 0, 0]", "\"z\": [0, 0]", "boundaries[0]: x has 3 values and z 2"),
    ("\"z\": [0, 0, 0]", "\"y\": [0, 0, 0]", "boundaries[0]: unknown key 'y'"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, NaN, 0]", "has no NaN"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, 1e999, 0]", "is not JSON"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, \"1\", 0]", "boundaries[0].z[1] is the text '1'"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, 2000, 0]", "boundaries[0].z[1] is 2000 µm, outside"),
    ("\"z\": [0, 0, 0]", "\"z\": 0", "boundaries[0].z is the number 0, but must be a list"),
    ("\"z\": [0, 0, 0]}", "\"z\": [0, 0, 0]", "is not JSON"),
    (
        "[{\"x\": [-1, 0, 1], \"z\": [0, 0, 0]}",
        "[{\"x\": [-1, 1, 0], \"z\": [0, 0, 0]}",
        "boundaries[0].x[2] is 0 after 1",
    ),
    ("[{\"x\": [-1, 0, 1], \"z\": [0, 0, 0]}", "[{\"x\": [-1, -1, 1], \"z\": [0, 0, 0]}", "x must increase"),
    ("[{\"x\": [-1, 0, 1], \"z\": [0, 0, 0]}", "[3", "boundaries[0] is the number 3, but must be a table"),
    ("[{\"x\": [-1, 0, 1], \"z\": [0, 0, 0]}", "[{\"z\": [0, 0, 0]}", "boundaries[0].x is missing"),
    (
        "\"z\": [-1, -1, -1]",
        "\"z\": [-1, 1, -1]",
        "boundaries[1] crosses boundaries[0] at x = -0.5000, z = 0.0000 µm",
    ),
    ("\"z\": [-1, -1, -1]", "\"z\": [1, 1, 1]", "boundaries[1] lies above boundaries[0]"),
    ("\"media\"", "\"medai\"", "did you mean 'media'"),
    ("\"air\", \"keratin\",", "\"air\",", "one more medium than boundaries"),
    (
        "\"air\", \"keratin\",",
        "\"air\", \"keratine\",",
        "media[1]: there is no medium 'keratine', did you mean 'keratin'?",
    ),
    ("\"air\", \"keratin\",", "\"air\", 7,", "media[1] must be a medium"),
    ("\"air\", \"keratin\",", "\"air\", {\"index\": [1.5]},", "media[1].index has 1 numbers"),
    ("\"air\", \"keratin\",", "\"air\", {\"index\": [1.5, -1]},", "media[1]: the index 1.5-1j has gain"),
    (
        "\"air\", \"keratin\",",
        "\"air\", {\"idnex\": [1.5, 0]},",
        "unknown key 'idnex', did you mean 'index'?",
    ),
    ("\"fraction\": [0.1, 0.9]", "\"fraction\": [0.1, 1.9]", "media[2].fraction[1] is 1.9, outside 0 to 1"),
    ("\"fraction\": [0.1, 0.9]", "\"fraction\": [0.1]", "media[2]: x has 2 values and fraction 1"),
    (
        "\"x\": [-1, 1], \"fraction\": [0.1, 0.9]",
        "\"x\": [], \"fraction\": []",
        "media[2]: x and fraction are empty",
    ),
    ("\"x\": [-1, 1], \"fraction\"", "\"x\": [1, -1], \"fraction\"", "media[2].x[1] is -1 after 1"),
    ("\"x\": [-1, 1], \"fraction\"", "\"fraction\"", "media[2].x is missing"),
    ("\"mix\": [\"keratin\", \"melanin\"]", "\"mix\": [\"keratin\"]", "media[2].mix must list two media"),
    ("\"mix\": [\"keratin\", \"melanin\"]", "\"mix\": [\"keratin\", \"melanni\"]", "did you mean 'melanin'"),
    ("\"medium\": \"melanin\",", "", "inclusions[0].medium is missing"),
    ("\"medium\": \"melanin\"", "\"medium\": \"melanosome\"", "inclusions[0].medium: there is no medium"),
    (
        "\"x\": [-0.5, 0.5, 0.5, -0.5], \"z\": [-0.2, -0.2, -0.8, -0.8]",
        "\"x\": [0, 1], \"z\": [-0.2, -0.2]",
        "inclusions[0] has 2 points, fewer than 3",
    ),
    (
        "\"x\": [-0.5, 0.5, 0.5, -0.5]",
        "\"x\": [-0.5, 0.5, -0.5, 0.5]",
        "inclusions[0] crosses or touches itself at x = 0.0000, z = -0.5000",
    ),
    (
        "\"x\": [-0.5, 0.5, 0.5, -0.5]",
        "\"x\": [0.1, 0.1, 0.1, 0.1]",
        "inclusions[0] crosses or touches itself",
    ),
    (
        "\"z\": [-0.2, -0.2, -0.8, -0.8]",
        "\"z\": [0.2, -0.2, -0.8, -0.8]",
        "inclusions[0] crosses or touches boundaries[0] at x = ",
    ),
    (
        "\"z\": [-0.2, -0.2, -0.8, -0.8]",
        "\"z\": [-0.2, -0.2, -0.8, -1.0]",
        "inclusions[0] crosses or touches boundaries[1] at x = -0.5000",
    ),
    (
        "\"x\": [-0.5, 0.5, 0.5, -0.5]",
        "\"x\": [-0.5, 1.5, 0.5, -0.5]",
        "inclusions[0] reaches x = 1.5000 µm, past the end",
    ),
    ("\"x\": [-0.5, 0.5, 0.5, -0.5]", "\"x\": [-0.5, 0.5, 0.5]", "inclusions[0]: x has 3 values and z 4"),
    ("\"radius\": 0.2", "\"radius\": 0.3", "inclusions[0] and inclusions[0].holes[0] cross or touch"),
    ("\"radius\": 0.2", "\"radius\": 0", "inclusions[0].holes[0].circle.radius is 0 µm"),
    ("\"radius\": 0.2", "\"raduis\": 0.2", "did you mean 'radius'"),
    (
        "\"x\": 0.0, \"z\": -0.5, \"radius\": 0.2",
        "\"x\": 0.7, \"z\": -0.5, \"radius\": 0.1",
        "holes[0] does not lie directly inside its inclusion",
    ),
    ("\"radius\": 0.1", "\"radius\": 0.2", "cross or touch at x ="),
    ("\"radius\": 0.1}", "\"radius\": 0.1}, \"x\": [1, 2, 3]", "inclusions[1].circle stands beside x or z"),
    (
        "{\"circle\": {\"x\": 0.0, \"z\": -0.5, \"radius\": 0.1}, \"medium\"",
        "{\"medium\"",
        "inclusions[1].x is missing",
    ),
    ("\"holes\": [", "\"holes\": [7, ", "inclusions[0].holes[0] is the number 7"),
    ("\"source\": \"a test\"", "\"materials\": {\"air\": 3}", "materials.air must be the name of a file"),
    ("\"source\": \"a test\"", "\"materials\": {\"a b\": [1, 0]}", "cannot name a medium"),
    ("\"source\": \"a test\"", "\"materials\": {\"gold\": \"no-such.csv\"}", "no such file"),
    ("\"source\": \"a test\"", "\"materials\": []", "materials must be a table"),
];

#[test]
fn bad_sections_are_refused_each_with_its_place_and_remedy() {
    for (good, bad, expected) in BAD {
        assert!(GOOD.contains(good), "{good}");
        let error = parse(&GOOD.replacen(good, bad, 1)).expect_err(bad);
        let message = error.to_string();
        assert!(error.is_input() && message.contains(expected), "{bad}\n{message}\nexpected: {expected}");
        assert!(message.len() < 600 && !message.ends_with('.') && !message.contains('\n'), "{message}");
    }
    for text in ["", "null", "[]", "{}", "7", "{\"barbule\": 1, \"units\": \"um\"}"] {
        assert!(parse(text).unwrap_err().is_input(), "{text}");
    }
    assert!(parse(&"[".repeat(100_000)).unwrap_err().to_string().contains("not JSON"));
    assert!(parse(&"[0,".repeat(6_000_000)).unwrap_err().to_string().contains("1000000 points"));
}

#[test]
fn a_million_points_are_checked_in_seconds_and_more_are_refused() {
    let comb = |count: usize| {
        let x: Vec<f64> = (0..count).map(|i| i as f64 * 1e-3 / count as f64 * 1e3).collect();
        let z: Vec<f64> = (0..count).map(|i| if i % 2 == 0 { 0.0 } else { 0.3 }).collect();
        let outline = Loop::polygon(
            x.iter().copied().chain([1.0, 0.0]).collect(),
            z.iter().copied().chain([-1.0, -1.0]).collect(),
        );
        let inclusions = vec![Inclusion { outline, medium: Medium::named("melanin"), holes: Vec::new() }];
        Parts { media: vec![Medium::named("air")], inclusions, ..Parts::default() }
    };
    Section::new(comb(200_000), Library::builtin()).unwrap();
    let message = Section::new(comb(1_000_000), Library::builtin()).unwrap_err().to_string();
    assert!(message.contains("over the limit of 1000000"), "{message}");
}

const CRYSTAL: &str = r#"{"barbule": 1, "units": "um", "width": 2.0, "name": "a",
  "boundaries": [{"x": [-1, 0, 1], "z": [0, 0.1, 0]}],
  "lattice": {"period": 0.2, "cortex": 0.1, "rod": [{"circles": [{"diameter": 0.1, "medium": "melanin"}]}],
              "offset": 0.05, "regularity": {"x": [-1, 1], "value": [0.2, 0.6]}}}"#;

#[test]
fn a_section_may_have_a_lattice_under_its_top() {
    let section = parse(CRYSTAL).unwrap();
    let crystal = section.crystal.as_ref().unwrap();
    assert_eq!((crystal.offset_um, crystal.lattice.rows), (0.05, 1));
    assert_eq!(crystal.regularity.as_ref().unwrap().at(0.5), 0.5);
    assert_eq!(section.media, [Medium::named("air"), Medium::named("keratin")]);
    assert_eq!(parse(&section_json(&section).to_string()).unwrap(), section);
    // One rod for each period of the arc length, on the normal below the top.
    let circles = crystal.circles(section.top());
    assert_eq!(circles.len(), 10);
    let nearest = circles.iter().min_by(|a, b| a.x_um.abs().total_cmp(&b.x_um.abs())).unwrap();
    let slope = 0.1f64.atan();
    let along = [0.05 * slope.cos(), 0.1 - 0.05 * slope.sin()];
    let expected = [along[0] - 0.15 * slope.sin(), along[1] - 0.15 * slope.cos()];
    assert!((nearest.x_um - expected[0]).hypot(nearest.z_um - expected[1]) < 1e-12, "{nearest:?}");
}

#[test]
fn what_does_not_go_with_a_lattice_is_refused() {
    let second = r#"[{"x": [-1, 0, 1], "z": [0, 0.1, 0]}, {"x": [-1, 0, 1], "z": [-2, -2, -2]}]"#;
    for (from, to, said) in [
        (r#""offset": 0.05"#, r#""ofset": 0.05"#, "did you mean 'offset'"),
        ("[0.2, 0.6]", "[0.2]", "has 2 x but 1 values"),
        ("[0.2, 0.6]", "[0.2, 1.6]", "regularity.value[1] is 1.6"),
        ("\"x\": [-1, 1]", "\"x\": [1, 1]", "regularity.x[1] is not larger"),
        (r#""cortex": 0.1"#, r#""cortex": 0.1, "host": "keratine""#, "did you mean 'keratin'"),
        (r#"[{"x": [-1, 0, 1], "z": [0, 0.1, 0]}]"#, second, "media is missing"),
        (r#""name": "a""#, r#""media": ["air", "melanin"]"#, "the lattice's own, [air, keratin]"),
        (r#""diameter": 0.1"#, r#""diameter": 0.3"#, "wider than the period"),
    ] {
        assert!(CRYSTAL.contains(from), "{from}");
        let error = parse(&CRYSTAL.replace(from, to)).unwrap_err();
        assert!(error.is_input() && error.to_string().contains(said), "{to}: {error}");
    }
}

#[test]
fn instances_of_one_structure_have_one_lattice() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.json"), CRYSTAL).unwrap();
    std::fs::write(folder.path().join("b.json"), CRYSTAL).unwrap();
    assert_eq!(read_sections(folder.path(), &Library::builtin()).unwrap().len(), 2);
    std::fs::write(folder.path().join("b.json"), CRYSTAL.replace("0.2,", "0.21,")).unwrap();
    let error = read_sections(folder.path(), &Library::builtin()).unwrap_err();
    assert!(error.to_string().contains("b has another lattice than a"), "{error}");
}
