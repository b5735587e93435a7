//! Any target of `barbule-fuzz` under libFuzzer; `BARBULE_FUZZ_TARGET` names it. A broken law is a panic.
#![no_main]

use std::sync::OnceLock;

use barbule_fuzz::memory::Counting;
use barbule_fuzz::{Seen, Target, examine, find};
use libfuzzer_sys::{Corpus, fuzz_target};

#[global_allocator]
static MEMORY: Counting = Counting;

fn target() -> &'static Target {
    static TARGET: OnceLock<&'static Target> = OnceLock::new();
    TARGET.get_or_init(|| {
        let name = std::env::var("BARBULE_FUZZ_TARGET").unwrap_or_default();
        let target = find(&name).unwrap_or_else(|| panic!("BARBULE_FUZZ_TARGET is '{name}', which is no target"));
        // What is made once is made before memory is counted; no seed of a folder that is elsewhere is needed for it.
        for seed in target.seeds().iter().take(4) {
            let _ = (examine(target, seed), examine(target, seed));
        }
        target
    })
}

fuzz_target!(init: { let _ = target(); }, |bytes: &[u8]| -> Corpus {
    match examine(target(), bytes) {
        Ok(Seen::Accepted | Seen::Refused) => Corpus::Keep,
        Err(broken) => panic!("{broken}"),
    }
});
