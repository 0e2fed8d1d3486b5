//! The short simulation sweep: hardly any label is wrong, and most of what can be seen is read. And the largest grids.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use rig_tests::measure::{Sweep, run_sweep};

/// Most wrong labels allowed, as a share of all reported vertices, in percent.
const MOST_WRONG_PERCENT: f64 = 0.05;
/// Least share of the clear crossings' vertices read right, in percent.
const LEAST_COVERAGE_PERCENT: f64 = 85.0;

#[test]
fn over_the_short_sweep_hardly_any_label_is_wrong_and_most_crossings_are_read() {
    let table = run_sweep(&Sweep::shipped().unwrap(), true, None, |_| ()).unwrap();
    println!("{table}");
    let (plain, calibrated) = table.overall();
    assert!(table.rows.len() >= 6);
    for sum in [plain, calibrated] {
        assert!(sum.wrong_percent() <= MOST_WRONG_PERCENT, "{table}");
        assert!(sum.coverage_percent() >= LEAST_COVERAGE_PERCENT, "{table}");
    }
}

#[test]
fn grids_of_127_and_255_lines_are_read_without_a_wrong_label() {
    /// Colour is only half as fine as the picture in a webcam's frames, and many lines leave few pixels to each.
    const LEAST_READ_PERCENT: f64 = 45.0;
    let mut sweep = Sweep::shipped().unwrap();
    sweep.groups.iter_mut().for_each(|group| {
        group
            .conditions
            .retain(|c| c.name.contains("127 x 127") || c.name.contains("127 x 255"));
    });
    let table = run_sweep(&sweep, false, None, |_| ()).unwrap();
    assert_eq!(table.rows.len(), 2);
    for row in table.rows {
        assert!(row.plain.wrong_percent() <= MOST_WRONG_PERCENT, "{row:?}");
        let read = row.plain.coverage_percent();
        assert!(read >= LEAST_READ_PERCENT, "{row:?}");
    }
}
