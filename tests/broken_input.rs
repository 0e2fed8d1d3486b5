//! Everything that reads bytes from outside ends soon and without a panic, whatever they are: the kept inputs, and new
//! ones for a moment. `./rig fuzz` does it for long.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::time::Duration;

use rig_tests::fuzz::{Target, feed, kept, run};

#[test]
fn inputs_that_are_kept_break_nothing() {
    let dir = tempfile::tempdir().unwrap();
    for target in Target::ALL {
        for folder in ["corpus", "found"] {
            for (path, input) in kept(target, folder) {
                let fed = feed(target, &input, dir.path());
                assert!(fed.is_ok(), "{}: {fed:?}", path.display());
            }
        }
    }
}

#[test]
fn new_inputs_break_nothing() {
    for target in Target::ALL {
        let found = run(target, Duration::from_secs(2), 0x5eed).unwrap();
        assert!(found.inputs > 0);
        let failures: Vec<_> = found
            .failures
            .iter()
            .map(|(input, what)| (what, String::from_utf8_lossy(input)))
            .collect();
        assert!(failures.is_empty(), "{}: {failures:?}", target.name());
    }
}
