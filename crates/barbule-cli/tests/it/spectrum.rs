//! `barbule spectrum` as people and scripts use it: colours in numbers, measurements, several structures.

use std::path::Path;

use serde_json::Value;

use crate::common::{Ends as _, Ran, program};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A simulation of a moment.
const QUICK: &[&str] = &["--instances", "3", "--wavelengths", "400:700:10"];

/// Runs the program in a folder, with a cache of its own.
fn run_in(folder: &Path, words: &[&str]) -> Ran {
    program().current_dir(folder).args(words).arg("--cache").arg(folder.join("cache")).ran()
}

fn example(name: &str) -> String {
    format!("{ROOT}/examples/measured/{name}")
}

/// What the words print, on standard output and on standard error.
fn succeed(folder: &Path, words: &[&str]) -> (String, String) {
    let (code, out, message) = run_in(folder, words);
    assert_eq!(code, 0, "{words:?}: {message}");
    (out, message)
}

fn json(folder: &Path, words: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, &[words, &["--json", "--quiet"]].concat()).0).unwrap()
}

#[test]
fn colours_are_printed_and_documented_for_each_angle() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&["spectrum", "starling", "--angle", "0,30"], QUICK].concat();
    let (out, message) = succeed(folder.path(), &words);
    assert_eq!(out.lines().count(), 2, "{out}");
    assert!(out.starts_with("starling:green, φ = 0°: peak 5") && out.contains("sRGB #"), "{out}");
    // What lies outside 400 to 700 nm does not matter; what lies below 415 nm does.
    assert!(!message.contains("held outside"), "{message}");
    let short = ["spectrum", "starling", "--instances", "1", "--wavelengths", "415:700:5"];
    let (_, message) = succeed(folder.path(), &short);
    assert!(message.contains("from 415 to 700 nm; its end values are held outside, where "), "{message}");
    let document = json(folder.path(), &words);
    for key in ["angle_deg", "wavelength_nm", "mean", "std", "instances", "standard_error", "look"] {
        assert!(!document[key].is_null(), "{key}");
    }
    let look = &document["look"][1];
    for key in
        ["peak_nm", "half_width_nm", "half_level", "mean_reflectance", "saturation", "hue_nm", "x", "Y"]
    {
        assert!(look[key].is_f64(), "{key}: {look}");
    }
    assert!(look["srgb"].as_str().unwrap().starts_with('#') && look["srgb_normalized"].is_string());
    let number = |key: &str, at: usize| document[key][0][at].as_f64().unwrap();
    assert!((number("standard_error", 7) - number("std", 7) / 3f64.sqrt()).abs() < 1e-15);
    let alone = json(folder.path(), &["spectrum", "air/keratin:300/air", "--wavelengths", "400:700:10"]);
    assert!(alone["standard_error"].is_null() && alone["instances"] == 1);
}

#[test]
fn every_kind_of_measurement_is_read_said_and_compared() {
    let folder = tempfile::tempdir().unwrap();
    for (file, said) in [
        (
            "starling-back.csv",
            "semicolons, decimal commas; wavelengths from 'wl' (300–700 nm); 3 samples, 'back_1', 'back_2' and 'back_3'; percent",
        ),
        (
            "from-r.csv",
            "commas; row numbers left out; wavelengths from 'wl' (300–700 nm); 1 sample, 'synthetic1'",
        ),
        ("spectrometer.txt", "spectrometer text, tabs; wavelengths from column 1"),
        ("starling.jdx", "JCAMP-DX"),
    ] {
        let file = example(file);
        let words = [&["spectrum", "starling", "--measured", &file], QUICK].concat();
        let (out, message) = succeed(folder.path(), &words);
        assert!(message.lines().any(|line| line.contains(said)), "{message}");
        for part in ["against", "shift", "half width", "RMSE", "best scale", "ΔE00", "ΔE*ab"] {
            assert!(out.contains(part), "{part}: {out}");
        }
        let document = json(folder.path(), &words);
        let comparison = &document["comparison"][0];
        assert!((comparison["scale"].as_f64().unwrap() - 1.0).abs() < 0.1, "{comparison}");
        assert!(comparison["rmse_scaled"].as_f64() <= comparison["rmse"].as_f64());
        assert!(comparison["delta_e_2000"].as_f64().unwrap() < 8.0 && comparison["points"] == 31);
        assert!(document["measured"]["reading"].as_str().unwrap().contains(said));
        assert!(document["measured"]["look"]["peak_nm"].is_f64());
    }
}

#[test]
fn a_named_column_is_one_sample_and_a_figure_shows_all() {
    let folder = tempfile::tempdir().unwrap();
    let file = example("starling-back.csv");
    let words = [&["spectrum", "starling", "--measured", &file], QUICK].concat();
    for column in ["back_2", "3"] {
        let document = json(folder.path(), &[&words[..], &["--column", column]].concat());
        assert_eq!(document["measured"]["samples"], serde_json::json!(["back_2"]));
        assert!(document["measured"]["std"].is_null());
    }
    let (_, message) = succeed(folder.path(), &[&words[..], &["-o", "m.svg"]].concat());
    assert!(message.contains("wrote m.svg: reflectance of starling:green at 1 angle, and what was measured"));
    let svg = std::fs::read_to_string(folder.path().join("m.svg")).unwrap();
    assert!(svg.contains("measured, mean of 3") && svg.contains("true, normalized"));
}

/// The highest peak jumps to the ultraviolet order at 30° or 45°; the film's peak moves by its law λ ∝ √(n² − sin²φ), n = 1.56, within
/// 4 % for rough barbules.
#[test]
fn the_peak_of_a_series_stays_in_its_order_and_what_is_higher_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let words =
        ["spectrum", "starling", "--angle", "0:60:15", "--wavelengths", "300:700:4", "--instances", "8"];
    let document = json(folder.path(), &words);
    let looks = document["look"].as_array().unwrap();
    let number = |look: &Value, key: &str| look[key].as_f64().unwrap();
    let inside =
        |angle: usize| (1.56f64 * 1.56 - (15.0 * angle as f64).to_radians().sin().powi(2)).sqrt() / 1.56;
    for (angle, look) in looks.iter().enumerate() {
        let expected = number(&looks[0], "peak_nm") * inside(angle);
        assert!((number(look, "peak_nm") / expected - 1.0).abs() < 0.04, "{angle}: {look}");
        if angle != 2 {
            assert_eq!(look["highest_is_another_order"], angle > 2, "{angle}: {look}");
        }
        let peaks = look["peaks"].as_array().unwrap();
        assert!(peaks.iter().any(|peak| peak["nm"] == look["peak_nm"] && peak["half_level"].is_f64()));
    }
    assert!(number(&looks[3], "highest_nm") < 350.0);
    let note = document["order_notes"][0].as_str().unwrap();
    assert!(
        note.starts_with("from ") && note.contains("° the highest peak is of another order: 3"),
        "{note}"
    );
    let (out, message) =
        succeed(folder.path(), &[&words[..], &["--summary", "s.csv", "-o", "s.svg"]].concat());
    assert!(
        message.contains(note) && out.lines().nth(3).unwrap().contains("of another order a higher one at 33")
    );
    let table = std::fs::read_to_string(folder.path().join("s.csv")).unwrap();
    let column = |name: &str, row: usize| {
        let at = table.lines().next().unwrap().split(',').position(|column| column == name).unwrap();
        table.lines().nth(row).unwrap().split(',').nth(at).unwrap().to_owned()
    };
    assert_eq!(column("peak_nm", 4), number(&looks[3], "peak_nm").to_string());
    assert_eq!(
        (column("highest_is_another_order", 4), column("highest_is_another_order", 1)),
        ("true".into(), "false".into())
    );
    let figure = std::fs::read_to_string(folder.path().join("s.svg")).unwrap();
    assert!(figure.contains("signs: the peak that is followed through the angles"));
    let violet = json(folder.path(), &[&words[..], &["--peak-range", "300:400"]].concat());
    assert!(
        (340.0..380.0).contains(&number(&violet["look"][0], "peak_nm")),
        "{}",
        violet["look"][0]["peak_nm"]
    );
}

/// A measurement that differs from the model by a slope alone has another highest peak and no shift.
#[test]
fn the_shift_against_a_measurement_is_that_of_the_peak_that_corresponds() {
    let folder = tempfile::tempdir().unwrap();
    let words =
        ["spectrum", "air/keratin:300/melanin:400/mix(keratin,melanin,0.3)", "--wavelengths", "300:700:4"];
    let model = json(folder.path(), &words);
    let mut table = "wl,R\n".to_owned();
    for (nm, value) in
        model["wavelength_nm"].as_array().unwrap().iter().zip(model["mean"][0].as_array().unwrap())
    {
        let (nm, value) = (nm.as_f64().unwrap(), value.as_f64().unwrap());
        table += &format!("{nm},{}\n", value * (1.0 + 0.3 * (nm - 440.0) / 100.0));
    }
    std::fs::write(folder.path().join("m.csv"), table).unwrap();
    let words = [&words[..], &["--measured", "m.csv"]].concat();
    let document = json(folder.path(), &words);
    let (comparison, look) = (&document["comparison"][0], &document["look"][0]);
    assert!(look["peak_nm"].as_f64().unwrap() < 340.0, "{look}");
    assert!((490.0..530.0).contains(&comparison["measured_peak_nm"].as_f64().unwrap()), "{comparison}");
    assert!(comparison["peak_shift_nm"].as_f64().unwrap().abs() < 10.0, "{comparison}");
    assert!(comparison["correlation"].as_f64().unwrap() > 0.6 && comparison["shift_note"].is_null());
    let (out, _) = succeed(folder.path(), &words);
    assert!(out.contains("(its highest, 3") && out.contains("is of another order), measured 5"), "{out}");
}

/// Two birds at two angles: what was measured stands beside what is simulated at the same angle, with the spread of both.
#[test]
fn individuals_and_angles_are_compared_each_with_its_own() {
    let folder = tempfile::tempdir().unwrap();
    // Thicker by 2 and 4 %: 290 and 295.7 nm in place of 284.3.
    let stack = |nm: f64| format!("air/keratin:{nm}±3/air");
    let wavelengths = ["--wavelengths", "400:700:5"];
    std::fs::create_dir(folder.path().join("birds")).unwrap();
    for (bird, nm) in [("a", 290.0), ("b", 295.7)] {
        for angle in [0, 40] {
            let words = ["spectrum", &stack(nm), "--angle", &angle.to_string(), "--instances", "4"];
            let found = json(folder.path(), &[&words[..], &wavelengths].concat());
            let values =
                found["wavelength_nm"].as_array().unwrap().iter().zip(found["mean"][0].as_array().unwrap());
            let lines: String = values.map(|(nm, value)| format!("{nm},{value}\n")).collect();
            let path = folder.path().join(format!("birds/{bird}_{angle}deg.csv"));
            std::fs::write(path, format!("wl,R\n{lines}")).unwrap();
        }
    }
    let model = stack(284.3);
    let words = [&["spectrum", &model, "--instances", "4", "--measured", "birds"], &wavelengths[..]].concat();
    let found = json(folder.path(), &words);
    assert_eq!(found["angle_deg"], serde_json::json!([0.0, 40.0]));
    let at = &found["measured"]["angles"][1];
    assert_eq!(
        (&at["angle_deg"], &at["samples"]),
        (&40.0.into(), &serde_json::json!(["a_40deg", "b_40deg"]))
    );
    for comparison in found["comparison"].as_array().unwrap() {
        let number = |key: &str| comparison[key].as_f64().unwrap();
        assert_eq!(
            (comparison["cause"].as_str(), comparison["measured_individuals"].as_u64()),
            (Some("shift"), Some(2))
        );
        // The mean of both is 3 % thicker, and keratin's index falls a little with the wavelength.
        assert!((number("cause_shift") - 0.03).abs() < 0.006 && number("explained") > 0.9, "{comparison}");
        assert!(
            number("peak_shift_low_nm") < number("peak_shift_nm") && number("measured_peak_std_nm") > 3.0
        );
    }
    let (out, message) = succeed(folder.path(), &[&words[..], &["-o", "f.svg", "--csv", "t.csv"]].concat());
    assert!(
        out.contains("a shift by +") && out.contains("thicker layers") && out.contains("95 %: "),
        "{out}"
    );
    assert!(!message.contains("-v says"), "{message}");
    let svg = std::fs::read_to_string(folder.path().join("f.svg")).unwrap();
    assert!(svg.contains("rows of signs: measured"));
    // One angle of those measured, and one that was not.
    let one = [&words[..], &["--angle", "40,60", "--summary", "s.csv"]].concat();
    let found = json(folder.path(), &one);
    assert!(found["comparison"][0].is_object() && found["comparison"][1].is_null());
    let summary = std::fs::read_to_string(folder.path().join("s.csv")).unwrap();
    let cells: Vec<usize> = summary.lines().map(|line| line.split(',').count()).collect();
    assert!(cells.iter().all(|count| *count == cells[0]), "{cells:?}");
    let (code, _, message) = run_in(folder.path(), &[&words[..], &["--angle", "60"]].concat());
    assert!(code == 2 && message.contains("which was at 0°, 40°; leave --angle out"), "{message}");
}

/// Intervals hold what the same structure has of other individuals, and grow with what is uncertain.
#[test]
fn intervals_say_how_sure_a_colour_is() {
    let folder = tempfile::tempdir().unwrap();
    let words = [
        "spectrum",
        "air/keratin:260±3%/air",
        "--instances",
        "12",
        "--wavelengths",
        "400:700:5",
        "--intervals",
    ];
    let of = |more: &[&str]| json(folder.path(), &[&words[..], more].concat())["intervals"][0].clone();
    let (alone, both) = (of(&[]), of(&["--uncertain", "keratin=1%", "--uncertain", "layer1=2%"]));
    let width = |found: &Value, name: &str| {
        let number = &found["numbers"][name];
        let of = |key: &str| number[key].as_f64().unwrap();
        assert!(of("low") <= of("value") && of("value") <= of("high"), "{number}");
        of("high") - of("low")
    };
    for name in ["peak_nm", "peak_reflectance", "delta_e_2000", "x"] {
        assert!(width(&both, name) > 1.02 * width(&alone, name), "{name}: {alone} {both}");
    }
    let peak = &both["numbers"]["peak_nm"];
    assert!(peak["std_of_uncertain"]["keratin"].as_f64().unwrap() > 3.0, "{peak}");
    assert!(peak["individuals_enough"].as_u64().unwrap() >= 2);
    let other = json(folder.path(), &[&words[..], &["--seed", "2"]].concat());
    let elsewhere = other["intervals"][0]["numbers"]["peak_nm"]["value"].as_f64().unwrap();
    let [low, high] = ["low", "high"].map(|end| alone["numbers"]["peak_nm"][end].as_f64().unwrap());
    // Two means of 12: the difference has √2 of an interval's error.
    let half = 0.5 * (high - low) * 2f64.sqrt();
    assert!((elsewhere - 0.5 * (low + high)).abs() < 1.6 * half, "{elsewhere}: {low} {high}");
    let (out, _) = succeed(folder.path(), &[&words[..], &["--uncertain", "layer1=2%"]].concat());
    assert!(out.contains("95 % (of the mean of 12 individuals): peak") && out.contains("layer1"), "{out}");
    let (code, _, message) = run_in(folder.path(), &[&words[..6], &["--uncertain", "layer1=2%"]].concat());
    assert!(code == 2 && message.contains("--intervals"), "{message}");
}

#[test]
fn several_structures_make_one_summary_one_table_and_one_figure() {
    let folder = tempfile::tempdir().unwrap();
    let stack = "air/mix(keratin,melanin,0.4):300/air";
    let file = example("from-r.csv");
    let words =
        [&["spectrum", "starling", "rock-dove", stack, "--angles", "0,20", "--measured", &file], QUICK]
            .concat();
    let outputs = ["--summary", "s.csv", "--csv", "t.csv", "-o", "f.svg"];
    let (out, message) = succeed(folder.path(), &[&words[..], &outputs].concat());
    assert_eq!(out.lines().count(), 12, "a colour and a comparison for each: {out}");
    assert_eq!(message.matches("wrote ").count(), 3, "{message}");
    assert!(message.contains("--instances 3, but there is 1 section"), "{message}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let summary = read("s.csv");
    let rows: Vec<&str> = summary.lines().collect();
    assert!(rows[0].starts_with("structure,angle_deg,instances,from_nm,to_nm,peak_nm,peak_reflectance,"));
    assert!(rows[0].contains(",rmse,scale,rmse_scaled,delta_e_2000,delta_e_76,cause,explained,"));
    assert_eq!(rows.len(), 7);
    assert!(rows[1].starts_with("starling,0,3,400,700,") && rows[4].starts_with("rock-dove,20,3,"));
    assert!(rows[6].starts_with("\"air/mix(keratin,melanin,0.4):300/air\",20,1,"));
    let cells = rows[0].split(',').count();
    assert!(rows[1..5].iter().all(|row| row.split(',').count() == cells), "{summary}");
    let table = read("t.csv");
    assert!(table.starts_with(
        "structure,angle_deg,wavelength_nm,mean,std,measured_mean,measured_std\nstarling,0,400,"
    ));
    assert_eq!(table.lines().count(), 1 + 3 * 2 * 31);
    assert!(read("f.svg").contains("rock-dove, φ = 20°"));
    let document = json(folder.path(), &words);
    assert_eq!(document["structures"].as_array().unwrap().len(), 3);
    assert_eq!(document["structures"][2]["instances"], 1);
    // Alone or among others, a structure has the same numbers.
    let alone = json(folder.path(), &[&["spectrum", "rock-dove", "--angle", "0,20"], QUICK].concat());
    assert_eq!(alone["mean"], document["structures"][1]["mean"]);
}

#[test]
fn both_spellings_of_flags_are_one_and_one_instance_is_no_plural() {
    let folder = tempfile::tempdir().unwrap();
    let one = ["spectrum", "starling", "--instances", "1", "--angle", "10", "--wavelengths", "500:560:20"];
    let other = ["spectrum", "starling", "--instances", "1", "--angles", "10", "--wavelength", "500:560:20"];
    assert_eq!(json(folder.path(), &one), json(folder.path(), &other));
    succeed(folder.path(), &[&one[..], &["-o", "f.svg"]].concat());
    let svg = std::fs::read_to_string(folder.path().join("f.svg")).unwrap();
    assert!(svg.contains("starling:green, 1 instance<"), "{svg}");
}

#[test]
fn what_cannot_be_is_refused_before_any_work_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let outside = tempfile::tempdir().unwrap();
    let path = |name: &str| outside.path().join(name).to_string_lossy().into_owned();
    let write = |name: &str, text: &str| {
        std::fs::write(path(name), text).unwrap();
        path(name)
    };
    let two = write("two.csv", "wl,R,depth\n400,0.1,3\n700,0.3,3\n");
    let huge = write("huge.csv", "wl,R\n400,1e300\n700,0.3\n");
    let negative = write("negative.csv", "wl,R\n400,-0.4\n700,0.3\n");
    let red = write("red.csv", "wl,R\n720,0.1\n800,0.3\n");
    let sheet = write("sheet.csv", "PK\u{3}\u{4}");
    let good = example("from-r.csv");
    let many: Vec<&str> =
        std::iter::once("spectrum").chain(["starling"; 19]).chain(["-o", "f.png"]).collect();
    let cases: Vec<(Vec<&str>, &str)> = vec![
        (vec!["--csv", "-"], "--csv -: name a file; --json prints the numbers"),
        (
            vec!["--peak-range", "700:400"],
            "--peak-range 700:400: write FROM:TO in nm with FROM below TO, as in 400:700",
        ),
        (vec!["--peak-range", "blue"], "write FROM:TO in nm"),
        (
            vec!["--peak-range", "300:350"],
            "--peak-range 300:350: none of the wavelengths from 400 to 694 nm lies within",
        ),
        (
            vec!["--wavelengths", "280:700:4"],
            "280 nm is outside 300 to 830 nm: the formula of keratin's index begins there",
        ),
        (vec!["--csv", "t.xlsx"], "tables are written as CSV, not as .xlsx"),
        (vec!["--summary", "t.json"], "--summary t.json"),
        (vec!["--summary", "t.csv", "--csv", "t.csv"], "give two names"),
        (vec!["--column", "a"], "--measured"),
        (vec!["--measured", &good, "--column", "swallow"], "there is no such column"),
        (
            vec!["--measured", &two],
            "'R', 'depth' are not all reflectances by their names; name one with --column",
        ),
        (vec!["--measured", &huge], "which is no reflectance"),
        (vec!["--measured", &negative], "mostly below zero"),
        (vec!["--measured", &red], "have 0 wavelengths in common"),
        (vec!["--measured", &good, "--wavelengths", "500"], "have 1 wavelengths in common"),
        (vec!["--measured", &sheet], "save the sheet as CSV"),
        (vec!["--measured", &good, "--measured-unit", "counts"], "--measured-unit"),
    ];
    let all = cases.iter().map(|(more, part)| ([&["spectrum", "starling"], &more[..]].concat(), *part));
    for (words, expected) in all.chain([(many, "19 curves of 19 structures do not fit one figure")]) {
        let (code, out, message) = run_in(folder.path(), &words);
        assert_eq!(code, 2, "{words:?}: {message}");
        assert!(message.contains(expected), "{words:?}: {message}");
        assert!(message.trim().chars().count() < 700 && out.is_empty(), "{words:?}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// A table as rows of cells, with the names of its columns.
fn table(folder: &Path, name: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let mut rows = text.lines().map(|row| row.split(',').map(str::to_owned).collect::<Vec<_>>());
    let names = rows.next().unwrap();
    let rows: Vec<_> = rows.collect();
    assert!(rows.iter().all(|row| row.len() == names.len()), "{text}");
    (names, rows)
}

#[test]
fn tables_hold_individuals_errors_and_what_was_measured() {
    let folder = tempfile::tempdir().unwrap();
    let file = example("starling-back.csv");
    let words = [&["spectrum", "starling", "--angle", "0,30", "--measured", &file], QUICK].concat();
    let document = json(folder.path(), &[&words[..], &["--csv", "w.csv", "--individuals"]].concat());
    let (names, rows) = table(folder.path(), "w.csv");
    assert_eq!(
        names.join(","),
        "angle_deg,wavelength_nm,mean,std,standard_error,individual_1,individual_2,individual_3,measured_mean,measured_std,measured_1,measured_2,measured_3"
    );
    assert_eq!(rows.len(), 62);
    let number = |row: &[String], at: usize| row[at].parse::<f64>().unwrap();
    for (w, row) in rows[31..].iter().enumerate() {
        let of: Vec<f64> = (5..8).map(|i| number(row, i)).collect();
        let mean = of.iter().sum::<f64>() / 3.0;
        let std = (of.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 2.0).sqrt();
        assert!((number(row, 2) - mean).abs() < 1e-12 && (number(row, 3) - std).abs() < 1e-12, "{row:?}");
        assert!((number(row, 4) - std / 3f64.sqrt()).abs() < 1e-12, "{row:?}");
        assert_eq!(document["individuals"][1][2][w], number(row, 7));
        let measured = (10..13).map(|i| number(row, i)).sum::<f64>() / 3.0;
        assert!((number(row, 8) - measured).abs() < 1e-12, "{row:?}");
    }
    succeed(
        folder.path(),
        &[&words[..], &["--csv", "t.csv", "--individuals", "--csv-layout", "tidy"]].concat(),
    );
    let (names, tidy) = table(folder.path(), "t.csv");
    assert_eq!(
        names.join(","),
        "structure,angle_deg,source,curve,sample,wavelength_nm,reflectance,std,standard_error"
    );
    let of = |source: &str, curve: &str| -> Vec<&Vec<String>> {
        tidy.iter().filter(|row| row[2] == source && row[3] == curve).collect()
    };
    assert_eq!(of("simulated", "individual").len(), 2 * 3 * 31);
    let means = of("simulated", "mean");
    assert_eq!(means.len(), 62);
    for (row, wide) in means.iter().zip(&rows) {
        assert_eq!(
            [&row[1], &row[5], &row[6], &row[7], &row[8]],
            [&wide[0], &wide[1], &wide[2], &wide[3], &wide[4]]
        );
    }
    let measured = of("measured", "individual");
    assert_eq!((measured.len(), measured[0][4].as_str(), of("measured", "mean").len()), (243, "back_1", 81));
    // Without flags the table is as it was; with a measurement its mean stands beside.
    succeed(folder.path(), &[&words[..4], QUICK, &["--csv", "p.csv"]].concat());
    assert_eq!(table(folder.path(), "p.csv").0.join(","), "angle_deg,wavelength_nm,mean,std");
    succeed(folder.path(), &[&words[..], &["--csv", "m.csv"]].concat());
    assert!(table(folder.path(), "m.csv").0.join(",").ends_with(",mean,std,measured_mean,measured_std"));
    for (more, part) in [
        (&["--individuals"][..], "--individuals: give --csv F or --json, which hold them"),
        (&["--csv-layout", "tidy"], "--csv"),
    ] {
        let (code, _, message) = run_in(folder.path(), &[&["spectrum", "starling"], more].concat());
        assert!(code == 2 && message.contains(part), "{message}");
    }
}

/// A table that is written can be read back as a measurement: all individuals, by their numbers.
#[test]
fn a_tidy_table_of_individuals_is_a_measurement_again() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&["spectrum", "starling"], QUICK].concat();
    let first = json(
        folder.path(),
        &[&words[..], &["--csv", "t.csv", "--csv-layout", "tidy", "--individuals"]].concat(),
    );
    let text = std::fs::read_to_string(folder.path().join("t.csv")).unwrap();
    let of = |line: &&str| line.starts_with("structure") || line.contains(",individual,");
    let kept: Vec<&str> = text.lines().filter(of).collect();
    std::fs::write(folder.path().join("back.csv"), kept.join("\n")).unwrap();
    let again = json(folder.path(), &[&words[..], &["--measured", "back.csv"]].concat());
    assert_eq!(again["measured"]["samples"], serde_json::json!(["1", "2", "3"]));
    let values = |document: &Value| -> Vec<f64> { serde_json::from_value(document.clone()).unwrap() };
    for (a, b) in values(&again["measured"]["mean"]).iter().zip(values(&first["mean"][0])) {
        assert!((a - b).abs() < 1e-12);
    }
}

#[test]
fn grazing_angles_are_flagged_wherever_their_numbers_stand() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&["spectrum", "starling", "--angle", "0,85", "--summary", "s.csv"], QUICK].concat();
    let (out, message) = succeed(folder.path(), &words);
    let lines: Vec<&str> = out.lines().collect();
    assert!(!lines[0].contains("flagged") && lines[1].contains(", flagged: off by over 3 % at "), "{out}");
    assert!(message.contains("values are flagged"), "{message}");
    let (names, rows) = table(folder.path(), "s.csv");
    let at = names.iter().position(|name| name == "flagged_wavelengths").unwrap();
    let counts: Vec<usize> = rows.iter().map(|row| row[at].parse().unwrap()).collect();
    assert!(counts[0] == 0 && counts[1] > 10, "{counts:?}");
    assert!(lines[1].ends_with(&format!("at {} of 31 wavelengths", counts[1])), "{out}");
}

#[test]
fn samples_of_a_long_table_are_named_like_columns() {
    let folder = tempfile::tempdir().unwrap();
    let rows = (0..41).flat_map(|i| {
        let nm = 400 + i * 8;
        ["left", "right"].map(|sample| format!("{nm},{sample},{:.4}", 0.04 + 0.0001 * f64::from(i)))
    });
    let text = format!("wl,sample,R\n{}\n", rows.collect::<Vec<_>>().join("\n"));
    std::fs::write(folder.path().join("long.csv"), text).unwrap();
    let words = [&["spectrum", "starling", "--measured", "long.csv"], QUICK].concat();
    let (_, message) = succeed(folder.path(), &words);
    assert!(message.contains("a line for each wavelength and sample, told apart by 'sample'"), "{message}");
    let one = json(folder.path(), &[&words[..], &["--column", "right"]].concat());
    assert_eq!(one["measured"]["samples"], serde_json::json!(["right"]));
    let (code, _, message) = run_in(folder.path(), &[&words[..], &["--column", "rigth"]].concat());
    assert!(
        code == 2 && message.contains("--column rigth: there is no such sample, did you mean 'right'?"),
        "{message}"
    );
}
