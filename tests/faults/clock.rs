//! The clock is set while both programs run.

use std::{
    fs,
    path::{Path, PathBuf},
};

use rig_tests::{
    built_program,
    guest::{Device, Guest, section},
};

use super::recorded;

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

/// Hours by which the guest's clock is set forwards and back, five times a second.
const HOURS: u32 = 7;

#[test]
fn a_clock_that_jumps_by_hours_disturbs_neither_program() {
    let script = format!(
        r#"projector --headless 1024x768 --listen 127.0.0.1:4460 >/tmp/projector 2>&1 & projector=$!
while ! grep -q listening /tmp/projector && kill -0 $projector; do sleep 0.2; done
(step={HOURS}
while date -s "@$(($(date +%s) + step * 3600))"; do step=$((-step)); sleep 0.2; done) >/tmp/jumps 2>&1 & jumping=$!
acquirer scan --json --projector 127.0.0.1:4460 --camera replay:/wall-cube --out /tmp/scan >/tmp/figures 2>/tmp/log
code=$?
kill $jumping
echo "== jumps"; wc -l </tmp/jumps
echo "== scan"; cat /tmp/figures /tmp/log /tmp/projector
acquirer check /tmp/scan && exit $code"#
    );
    let output = Guest::with(Device::Vivid)
        .program(built_program("projector").unwrap())
        .program(built_program("acquirer").unwrap())
        .file(recorded())
        .run(&script)
        .unwrap_or_else(|error| panic!("{error:#}"));
    let jumps = section(&output, "jumps")[0].as_u64();
    assert!(jumps > Some(20), "{output}");
    let figures = &section(&output, "scan")[0];
    for stage in ["background", "object"] {
        let labelled = figures["summary"][stage]["crossings_labelled"].as_u64();
        assert!(labelled > Some(180), "{output}");
    }
}
