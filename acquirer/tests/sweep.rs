//! The short simulation sweep: hardly any label is wrong, and most of what can be seen is read.

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
