//! `barbule bench render`: figures, curve files out and in again, and files that are refused.

use serde_json::Value;

use crate::common::{json, printed, run, succeed};

fn refused(arguments: &[&str]) -> String {
    let (code, _, message) = run(arguments);
    assert_eq!(code, 2, "{message}");
    assert_eq!(message.trim().lines().count(), 1, "{message}");
    message
}

const SMALL: [&str; 8] = ["bench", "render", "--side", "24", "--samples", "4", "--runs", "1"];

#[test]
fn every_scene_has_its_figures() {
    let arguments = [&SMALL[..], &["--json", "conductor", "hair"]].concat();
    let found: Value = json(&arguments);
    let scenes = found["scenes"].as_array().unwrap();
    assert_eq!(scenes.len(), 2);
    for scene in scenes {
        let figure = |name: &str| scene[name].as_f64().unwrap();
        assert!(figure("paths_per_cpu_second") > 0.0 && figure("rays_per_path") > 1.0, "{scene}");
        assert!(figure("shadow_rays_per_path") > 0.0 && figure("hierarchy_bytes") > 0.0, "{scene}");
        assert!(scene["mean_rgb"].as_array().unwrap().iter().all(|v| v.as_f64().unwrap() > 0.05), "{scene}");
    }
    let table = printed(&[&SMALL[..], &["conductor"]].concat());
    assert!(table.lines().last().unwrap().starts_with("quad, conductor"), "{table}");
}

#[test]
fn curve_files_are_written_and_read_and_broken_ones_refused() {
    let folder = tempfile::tempdir().unwrap();
    let curves = folder.path().join("curves");
    let path = curves.to_str().unwrap();
    succeed(&["bench", "render", "--write-curves", path, "--quiet"]);
    let own = printed(&[&SMALL[..], &["full", "--json"]].concat());
    let read = printed(&[&SMALL[..], &["full", "--json", "--curves", path]].concat());
    let mean = |text: &str| serde_json::from_str::<Value>(text).unwrap()["scenes"][0]["mean_rgb"][1].as_f64();
    // Six digits of the coordinates are kept: some rays at edges pass on the other side.
    assert!((mean(&own).unwrap() / mean(&read).unwrap() - 1.0).abs() < 0.02);
    let barbs = curves.join("feather_barbs.txt");
    std::fs::write(&barbs, "0 0 0 1\n1 0 0\n").unwrap();
    let message = refused(&["bench", "render", "full", "--curves", path]);
    assert!(message.contains("feather_barbs.txt: line 2: is not four numbers"), "{message}");
    std::fs::remove_file(&barbs).unwrap();
    assert!(refused(&["bench", "render", "full", "--curves", path]).contains("no such file"));
    let nowhere = folder.path().join("nowhere");
    assert!(refused(&["bench", "render", "--curves", nowhere.to_str().unwrap()]).contains("no such folder"));
}
