//! What is said to be true of a scan.

use super::{BOX, grid, plain_room};
use shared::{
    pattern::Corner,
    simulation::{Space, write_truth_csv},
    stage::Stage,
};

#[test]
fn truth_agrees_with_the_calibration_and_with_what_the_camera_sees() {
    let scene = plain_room(
        "distortion = [-0.1, 0.03, 0.001, 0.0, 0.0]",
        "distortion = [0.05, 0.0, 0.0, 0.0, 0.0]",
        BOX,
    );
    let (size, rig) = (scene.projector_size(), scene.calibration());
    let grid = grid(6);
    for stage in Stage::BOTH {
        let room = Space::new(&scene, stage);
        let truth = room.truth(&grid, size);
        assert!(truth.len() > 600, "{stage}: {} vertices", truth.len());
        for vertex in &truth {
            let expected = grid.vertex(vertex.index, vertex.corner, size);
            let found = rig.projector_pixel(&vertex.point_mm).unwrap();
            assert!((found.x - expected.x).hypot(found.y - expected.y) < 1e-6);
            let seen = rig.camera_pixel(&vertex.point_mm).unwrap();
            assert!((seen.x - vertex.camera.x).hypot(seen.y - vertex.camera.y) < 1e-9);
            if vertex.clear {
                let lit_by = room.projector_at(vertex.camera).unwrap();
                assert!((lit_by.x - expected.x).hypot(lit_by.y - expected.y) < 1e-6);
                assert!(
                    (12.0..25.0).contains(&vertex.pitch_px),
                    "pitch {}",
                    vertex.pitch_px
                );
            }
        }
    }
}

#[test]
fn crossings_on_an_edge_or_in_shadow_are_not_clear() {
    let scene = plain_room("", "", BOX);
    let size = scene.projector_size();
    let grid = grid(6);
    let clear = |stage| {
        let truth = Space::new(&scene, stage).truth(&grid, size);
        let clear: Vec<_> = truth.iter().filter(|v| v.clear).copied().collect();
        assert_eq!(clear.len() % 4, 0, "a clear crossing has all four vertices");
        clear
    };
    let (before, after) = (clear(Stage::Background), clear(Stage::Object));
    assert!(
        after.len() < before.len(),
        "{} / {}",
        after.len(),
        before.len()
    );
    for vertex in &after {
        let p = vertex.point_mm;
        let on_front = (p.z - 800.0).abs() < 1e-6 && p.x.abs() < 96.0 && p.y.abs() < 96.0;
        let on_wall = (p.z - 1000.0).abs() < 1e-6;
        let on_side = (p.x.abs() - 100.0).abs() < 1e-6 || (p.y.abs() - 100.0).abs() < 1e-6;
        assert!(on_front || on_wall || on_side, "clear at {p}");
    }
    assert!(after.iter().filter(|v| v.point_mm.z < 801.0).count() >= 4 * 4);
}

#[test]
fn truth_is_written_as_the_table_that_scoring_reads() {
    let scene = plain_room("", "", "");
    let truth = Space::new(&scene, Stage::Background).truth(&grid(6), scene.projector_size());
    let mut table = Vec::new();
    write_truth_csv(&truth, &mut table).unwrap();
    let table = String::from_utf8(table).unwrap();
    let mut lines = table.lines();
    let header = "stage,row,column,vertex,x_px,y_px,x_mm,y_mm,z_mm,clear,pitch_px";
    assert_eq!(lines.next(), Some(header));
    let first: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(first.len(), 11);
    assert_eq!(first[0], "background");
    assert!(Corner::ALL.iter().any(|corner| corner.name() == first[3]));
    assert_eq!(table.lines().count(), truth.len() + 1);
}
