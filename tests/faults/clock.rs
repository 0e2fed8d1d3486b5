//! The clock is set while both programs run: where they could notice. `real_rig.rs` sets it, in a guest machine.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// Programs that count by the monotonic clock are not touched by a clock that is set. The wall clock is read in one place,
/// for the ten minutes of a pairing code.
#[test]
fn no_time_is_taken_from_a_clock_that_can_jump() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut readers = Vec::new();
    for crate_dir in [
        "shared/src",
        "projector/src",
        "acquirer/src",
        "acquirer/pipeline/src",
    ] {
        look_for_wall_clock(&root.join(crate_dir), &mut readers);
    }
    let names: Vec<_> = readers
        .iter()
        .map(|path| path.strip_prefix(&root).unwrap())
        .collect();
    assert_eq!(names, [Path::new("projector/src/access/mod.rs")]);
}

fn look_for_wall_clock(dir: &Path, readers: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            look_for_wall_clock(&path, readers);
        } else if fs::read_to_string(&path).is_ok_and(|text| text.contains("SystemTime")) {
            readers.push(path);
        }
    }
}
