//! Past findings stay mended, and every target has something to begin with.

use barbule_fuzz::{Seen, all, examine, find, past};

#[test]
fn what_once_broke_a_law_keeps_it_now() {
    let mut broken = Vec::new();
    for name in past::folders("past") {
        let target = find(&name).unwrap_or_else(|| panic!("past/{name} is of no target"));
        for (file, bytes) in past::files("past", &name) {
            if let Err(why) = examine(target, &bytes) {
                broken.push(format!("past/{name}/{file}: {why}"));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn every_target_has_seeds_that_keep_its_laws_and_are_accepted() {
    for name in past::folders("seeds") {
        assert!(find(&name).is_some(), "seeds/{name} are of no target");
    }
    for target in all() {
        let mut accepted = 0;
        for (number, seed) in target.seeds().iter().enumerate() {
            let seen =
                examine(target, seed).unwrap_or_else(|why| panic!("{}, seed {number}: {why}", target.name));
            accepted += usize::from(seen == Seen::Accepted);
        }
        assert!(accepted > 0, "{}: no seed is accepted", target.name);
    }
}

#[test]
fn names_are_each_targets_own() {
    let names: Vec<&str> = all().iter().map(|target| target.name).collect();
    assert!(names.windows(2).all(|pair| pair[0] < pair[1]), "{names:?}");
}
