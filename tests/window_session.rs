//! A whole session by the mouse alone: both programs with their real windows, real clicks, from the sixteen colours to
//! a saved scan, which the product's own readers then read.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

#[allow(dead_code, reason = "other tests look at the whole display")]
#[path = "projector_support/display.rs"]
mod display;

#[path = "window_session/desk.rs"]
mod desk;

use std::path::Path;

use acquirer::{
    camera::load_scene,
    projector_link::{LinkSettings, ProjectorLink},
    scan::{ScanFolder, check_scan},
    score::score_stage,
};
use desk::{Desk, WALL, Window};
use rig_tests::read_vertices;
use serde_json::Value;
use shared::{
    pattern::{GridSettings, Pattern},
    protocol::{Role, View},
    simulation::Room,
    stage::Stage,
};

#[test]
fn a_session_by_mouse_alone_ends_in_a_saved_scan() {
    let home = tempfile::tempdir().unwrap();
    let desk = Desk::new(home.path());
    let operator = desk.operator();
    let acquirer = desk.acquirer();
    acquirer.wait("the rig", |w| w.says("camera ") && w.says("1024x768"));
    let wall = Wall::of(&desk);
    let before = wall.grid();

    controls(&acquirer);
    operator.click("White", |_| wall.view() == View::White);
    operator.click("PRMVS", |_| wall.view() == View::Coded);
    live(&acquirer, &wall);
    colours(&acquirer);
    let applied = wall.grid();
    assert_ne!(applied, before, "the cube's room takes other colours");
    scan(&acquirer);
    crossing(&acquirer);
    acquirer.click("Result", |w| w.says("Save as"));
    acquirer.click("Save", |w| w.says("saved as"));

    saved(&home.path().join("cube-kept"), &applied);
    operator.click("PRMVS", |_| wall.view() == View::Coded);
    operator.picture("operator");
    let grid = Pattern::from(applied.coded).raster(WALL);
    let seen = desk.display.window("projector");
    assert!(seen == grid, "the wall shows the grid of the scan");
}

/// What the projector says of itself to somebody who watches.
struct Wall(ProjectorLink);

impl Wall {
    fn of(desk: &Desk) -> Self {
        let settings = LinkSettings::new(&desk.address, "somebody who watches", Role::Watcher);
        Self(ProjectorLink::connect(&settings).unwrap())
    }

    fn grid(&self) -> GridSettings {
        self.0.state().unwrap().grid
    }

    fn view(&self) -> View {
        self.0.state().unwrap().view
    }
}

/// Locks the camera's automatics, and sets the exposure to the white-lit scene.
fn controls(window: &Window<'_>) {
    window.click("Source settings", |w| w.says("exposure time absolute"));
    window.click("Lock all", |w| w.says("locked: "));
    window.click("Set the exposure", |w| {
        w.says("the white-lit scene reaches byte")
    });
    window.picture("settings");
    window.click("Source settings", |w| !w.says("Lock all"));
}

/// Reads the grid in every frame, in each of the three ways, and stops that again.
fn live(window: &Window<'_>, wall: &Wall) {
    window.click("Read", |w| w.says("crossings read"));
    window.picture("live");
    for (now, other, view) in [
        ("moving", "still", View::Coded),
        ("still", "tracking", View::Unary),
        ("tracking", "moving", View::Coded),
    ] {
        let read = format!("live picture, {other}: ");
        window.click(&format!("The scene is: {now}"), |w| w.find(other).is_some());
        window.click(other, |w| w.says(&read) && wall.view() == view);
    }
    window.click("Read", |w| !w.says("crossings read"));
}

/// Measures all colours and applies the best.
fn colours(window: &Window<'_>) {
    window.click("Colours", |w| w.says("Measure all sixteen"));
    window.click("Measure all sixteen", |w| w.says("Cancel"));
    window.wait("the choice", |w| w.says("Expected to be misread"));
    window.click("Apply to the projector", |w| {
        w.says("The projector shows these colours")
    });
    window.picture("colours");
}

/// Records both stages and keeps them, which computes the shape.
fn scan(window: &Window<'_>) {
    window.click("Scan", |w| w.says("Record without object"));
    for (record, kept) in [("Record without object", 1), ("Record with object", 2)] {
        window.click(record, |w| w.says("Cancel") || w.says("Keep"));
        window.wait("the quality", |w| w.count("Keep") > 0);
        window.picture("scan");
        window.click("Keep", move |w| w.count("Kept") == kept);
    }
    window.wait("the result", |w| w.says("vertices shifted"));
    window.picture("result");
}

/// Clicks the crossing in the middle of the decoded grid.
fn crossing(window: &Window<'_>) {
    window.click("Steps", |w| w.says("Decoded grid"));
    window.click("Decoded grid", |w| {
        w.says("occurs once in the sequence") && w.says("Row ")
    });
    window.picture("steps");
}

/// What the product's own readers make of the saved scan.
fn saved(dir: &Path, applied: &GridSettings) {
    let folder = ScanFolder::open(dir).unwrap();
    assert_eq!(folder.projected().pattern, *applied);
    let selection = folder.selection().unwrap().expect("it was recorded");
    assert_eq!(selection.best, applied.coded.colours());
    let check = check_scan(dir).unwrap();
    assert!(check.intact && check.results, "{check:?}");
    assert!(check.unrecorded.is_empty(), "{check:?}");
    assert!(dir.join("results/report.html").is_file());
    let summary = std::fs::read(dir.join("results/summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    assert!(summary["shifts"]["vertices"].as_u64() > Some(100));
    let scene = load_scene("cube").unwrap();
    for stage in Stage::BOTH {
        let truth = Room::new(&scene, stage).truth(&applied.coded, WALL);
        let read = read_vertices(&dir.join("results"), stage).unwrap();
        let score = score_stage(&truth, &read, stage);
        assert!(score.coverage_percent > 90.0, "{}", score.sentence());
        assert_eq!(score.wrong, 0, "{}", score.sentence());
    }
}
