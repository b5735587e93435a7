//! Coats and barbules on meshes whose faces look inwards.

use std::path::Path;

use serde_json::Value;

use crate::common::{MADE_UP, program, said_by, write_made_up};

/// What a run says, and the hash of its pixels.
fn drawn(folder: &Path, scene: &str) -> (String, String) {
    write_made_up();
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    let output = program()
        .args(["render", "scene.toml", "-o", "a.png", "--size", "40x30", "--samples", "4", "--json", "-v"])
        .current_dir(folder)
        .output()
        .unwrap();
    let said = said_by(&output);
    assert!(output.status.success(), "{said}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    (said, report[0]["pixel_hash"].as_str().unwrap().to_owned())
}

/// An octahedron of 20 mm with texture coordinates, or some of its faces; or all of them the other way round.
fn octahedron(faces: usize, is_inside_out: bool) -> String {
    let mut text = String::new();
    for corner in ["20 0 0", "0 20 0", "-20 0 0", "0 -20 0", "0 0 20", "0 0 -20"] {
        text += &format!("v {corner}\n");
    }
    for place in ["0 0", "1 0", "0.5 1"] {
        text += &format!("vt {place}\n");
    }
    let around = [[1, 2], [2, 3], [3, 4], [4, 1]];
    let all = around.map(|[a, b]| [a, b, 5]).into_iter().chain(around.map(|[a, b]| [b, a, 6]));
    for [a, b, c] in all.take(faces) {
        text +=
            &if is_inside_out { format!("f {a}/1 {c}/3 {b}/2\n") } else { format!("f {a}/1 {b}/2 {c}/3\n") };
    }
    text
}

const COAT: &str = "preset = 'starling-feather'\nshows_feather = false\nexposure = 0.4\n[camera]\nwidth_mm = 110\ntarget_mm = [0, 0, 0]\n\
    [[objects]]\nfeather = 'contour'\nmaterial = 'M'\ndetail = { level = 'envelopes' }\ncoat = { mesh = 'body.obj', count = 60 }\n\
    [objects.dress]\nshaft = { roughness = 0.3, index = 1.56, melanin = 0.2 }\n";

const CLAD: &str = "preset = 'starling'\nshows_feather = false\nexposure = 0.4\n[camera]\nwidth_mm = 60\ntarget_mm = [0, 0, 0]\n\
    [[objects]]\nmesh = 'body.obj'\nsurface = 'plates'\n[surfaces.plates]\ntype = 'barbule'\nmaterial = 'M'\nuv_mm = [20, 20]\nwidth_um = 400\n";

/// The same picture, to the bit, whichever way round the faces of a closed mesh are, also of a coat with a dress of its own.
#[test]
fn coats_and_barbules_stand_outside_whichever_way_faces_look() {
    let folder = tempfile::tempdir().unwrap();
    for (scene, part) in [(COAT, "feathers grow outwards"), (CLAD, "barbules show their upper sides outside")]
    {
        let scene = scene.replace('M', MADE_UP);
        let draw = |is_inside_out| {
            std::fs::write(folder.path().join("body.obj"), octahedron(8, is_inside_out)).unwrap();
            drawn(folder.path(), &scene)
        };
        let ((silent, right), (said, turned)) = (draw(false), draw(true));
        assert_eq!(right, turned, "{said}");
        assert!(
            !silent.contains("body.obj")
                && said.contains("body.obj: its faces look inwards")
                && said.contains(part),
            "{said}"
        );
    }
}

/// Half of it is a bowl, of which nobody knows which side is meant; a key takes the other one.
#[test]
fn of_open_meshes_the_side_is_said_and_can_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let scene = COAT.replace('M', MADE_UP);
    let draw = |is_inside_out, scene: &str| {
        std::fs::write(folder.path().join("body.obj"), octahedron(4, is_inside_out)).unwrap();
        drawn(folder.path(), scene)
    };
    let ((said, dome), (doubt, bowl)) = (draw(false, &scene), draw(true, &scene));
    assert_ne!(dome, bowl);
    assert!(said.contains("is open, so that it has no inside"), "{said}");
    assert!(doubt.contains("its hollow side, to which its faces look; coat.other_side = true"), "{doubt}");
    let other = scene.replace("count = 60", "count = 60, other_side = true");
    assert_eq!(draw(true, &other).1, dome);
}
