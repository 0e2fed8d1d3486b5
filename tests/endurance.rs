//! A short endurance run; `./rig endure` makes the long one.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::time::Duration;

use rig_tests::{built_program, endurance};

/// Memory that may be more at the end, in KiB. What the system's allocator keeps comes and goes by some 40 MiB; the frames
/// of the stages that are recorded meanwhile are 250 MiB and more.
const MORE_MEMORY_KIB: i64 = 96 * 1024;

#[test]
fn neither_program_takes_more_and_more_of_the_machine() {
    built_program("projector").unwrap();
    let found = endurance::run(Duration::from_secs(30), Duration::from_secs(5)).unwrap();
    assert!(found.stages > 0, "{found}");
    assert_eq!(found.missed, Vec::<String>::new());
    // four pictures at least of every stage, all of them shown
    assert!(found.pictures >= 4 * found.stages, "{found}");
    for (of, usage) in [
        (
            "projector",
            (|s| s.projector) as fn(&endurance::Sample) -> rig_tests::Usage,
        ),
        ("acquirer", |s| s.acquirer),
    ] {
        let threads = found.growth(|sample| usage(sample).threads as u64);
        let descriptors = found.growth(|sample| usage(sample).descriptors as u64);
        assert!(threads <= 0 && descriptors <= 0, "{of}: {found}");
        let memory = found.growth(|sample| usage(sample).memory_kib);
        assert!(memory < MORE_MEMORY_KIB, "{of}: {found}");
    }
    println!("{found}");
}
