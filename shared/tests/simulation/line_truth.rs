//! What is said to be true of the lines of a scan.

use super::{BOX, grid, plain_room};
use shared::{
    pattern::Axis,
    simulation::{LineSample, Space},
    stage::Stage,
};

#[test]
fn line_truth_agrees_with_the_calibration_and_with_what_the_camera_sees() {
    let scene = plain_room(
        "distortion = [-0.1, 0.03, 0.001, 0.0, 0.0]",
        "distortion = [0.05, 0.0, 0.0, 0.0, 0.0]",
        BOX,
    );
    let (size, rig, grid) = (scene.projector_size(), scene.calibration(), grid(6));
    for stage in Stage::BOTH {
        let room = Space::new(&scene, stage);
        let truth = room.line_truth(&grid, size);
        assert!(truth.len() > 5000, "{stage}: {} places", truth.len());
        for sample in &truth {
            let across = grid.line(sample.axis, sample.line.into(), size).centre_px();
            let expected = match sample.axis {
                Axis::Row => [sample.along_px, across],
                Axis::Column => [across, sample.along_px],
            };
            let lit_by = rig.projector_pixel(&sample.point_mm).unwrap();
            assert!((lit_by.x - expected[0]).hypot(lit_by.y - expected[1]) < 1e-6);
            let seen = rig.camera_pixel(&sample.point_mm).unwrap();
            assert!((seen.x - sample.camera.x).hypot(seen.y - sample.camera.y) < 1e-9);
            let inside = (0.0..=320.0).contains(&seen.x) && (0.0..=240.0).contains(&seen.y);
            assert!(inside, "outside of the picture: {seen:?}");
            // looking back along the camera's ray meets the same light
            let back = room.projector_at(sample.camera).unwrap();
            assert!((back.x - expected[0]).hypot(back.y - expected[1]) < 1e-6);
        }
    }
}

/// The runs of neighbouring projector pixels along one line, as their lengths.
fn runs(truth: &[LineSample], axis: Axis, line: u16) -> Vec<usize> {
    let own = truth.iter().filter(|s| (s.axis, s.line) == (axis, line));
    let places: Vec<f64> = own.map(|s| s.along_px).collect();
    let pieces = places.chunk_by(|a, b| (b - a - 1.0).abs() < 1e-9);
    pieces.map(<[f64]>::len).collect()
}

#[test]
fn an_object_breaks_the_lines_that_pass_its_edge_and_leaves_a_shadow_out() {
    let scene = plain_room("", "", BOX);
    let (size, grid) = (scene.projector_size(), grid(6));
    let [before, after] =
        Stage::BOTH.map(|stage| Space::new(&scene, stage).line_truth(&grid, size));
    assert!(
        after.len() < before.len(),
        "{} {}",
        before.len(),
        after.len()
    );
    for line in 0..15 {
        assert!(
            runs(&before, Axis::Row, line).len() <= 1,
            "nothing breaks row {line}"
        );
    }
    let broken = (0..15).filter(|&line| runs(&after, Axis::Row, line).len() > 1);
    assert!(
        broken.count() >= 4,
        "the box stands in the way of several rows"
    );
    for sample in &after {
        let p = sample.point_mm;
        let on_box = p.z < 1000.0 - 1e-6;
        assert!((p.z - 1000.0).abs() < 1e-6 || on_box);
        if on_box {
            assert!(p.x.abs() < 100.0 + 1e-6 && p.y.abs() < 100.0 + 1e-6 && p.z > 800.0 - 1e-6);
        }
    }
}

#[test]
fn lines_come_rows_first_then_by_number_then_along() {
    let scene = plain_room("", "", "");
    let truth = Space::new(&scene, Stage::Background).line_truth(&grid(6), scene.projector_size());
    let order = |s: &LineSample| (s.axis == Axis::Column, s.line);
    for pair in truth.windows(2) {
        let [a, b] = [&pair[0], &pair[1]];
        assert!(order(a) < order(b) || (order(a) == order(b) && a.along_px < b.along_px));
        assert_eq!(a.along_px.fract(), 0.5, "the middle of a projector pixel");
    }
}
