//! Pictures that are looked at while they are made, and that go on where they were left.

use serde_json::Value;

use crate::common::{Ends as _, said_by};
use crate::render::{QUICK, barbule, report};

/// Previews change nothing about the picture, nor does the size of rounds.
#[test]
fn a_previewed_picture_has_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let plain = report(folder.path(), &["starling", "-o", "a.png"]);
    let previewed = report(folder.path(), &["starling", "-o", "b.png", "--preview=0.000001s"]);
    assert_eq!(plain["pixel_hash"], previewed["pixel_hash"]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

/// A time that is over at once ends it after a sample of each pixel. What is done needs no checkpoint any more.
#[test]
fn a_resumed_picture_has_the_same_bits_and_leaves_no_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, more: &[&str]| {
        let arguments = ["starling", "--resume", "-o", name];
        report(folder.path(), &[&arguments[..], more].concat())
    };
    let is_kept = |name: &str| folder.path().join(format!("{name}.checkpoint")).exists();
    let begun = render("a.png", &["--time", "0.001s"]);
    assert_eq!((&begun["ended"], &begun["samples"]), (&"time".into(), &"1.0".into()));
    assert!(is_kept("a.png"));
    // Another light is another picture.
    let other = [&["starling", "--resume", "-o", "a.png", "--light=1,50"][..], QUICK].concat();
    let refused = barbule(folder.path(), &other).ends(2);
    assert!(said_by(&refused).contains("another picture"));
    let (resumed, whole) = (render("a.png", &[]), render("b.png", &[]));
    assert_eq!((&resumed["pixel_hash"], &resumed["ended"]), (&whole["pixel_hash"], &"done".into()));
    assert!(resumed["paths"].as_u64() < whole["paths"].as_u64());
    assert!(!is_kept("a.png") && !is_kept("b.png"));
}

/// Frames that are done keep theirs until all are: the sequence goes on after them.
#[test]
fn a_sequence_keeps_checkpoints_until_all_its_frames_are_done() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["starling", "--resume", "--frames", "2", "-o", "f.png", "--json"];
    let render = |more: &[&str]| {
        let run = barbule(folder.path(), &[&arguments[..], QUICK, more].concat()).ends(0);
        serde_json::from_slice::<Value>(&run.stdout).unwrap()
    };
    let count = || std::fs::read_dir(folder.path()).unwrap().count();
    render(&["--time", "0.001s"]);
    assert_eq!(count(), 4);
    let done = render(&[]);
    assert_eq!(count(), 2);
    assert_eq!(done[1]["paths"], 3 * 48 * 30);
}
