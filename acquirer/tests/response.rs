//! A scan of a camera without a tone curve, from the folder to the results.

#![allow(
    clippy::unwrap_used,
    reason = "a step that fails in a helper fails its test"
)]

use std::path::Path;

use acquirer::{
    config::Config,
    pipeline::response::{ResponseCurve, ramp_colours},
    process::{Processed, process_scan},
    scan::{ScanFolder, Shows},
    score::score_stage,
};
use rig_tests::measure::{Condition, Repeats, SimulatedScan};
use shared::{
    pattern::{GridSettings, Pattern},
    simulation::{Room, Scene},
    stage::Stage,
};

/// Saves a scan of the coloured room through such a camera; `with_ramp` adds the solid colours.
fn record(dir: &Path, with_ramp: bool) -> SimulatedScan {
    let linear = "name = \"\"\n[set]\n\"camera.tone_curve\" = \"linear\"";
    let condition: Condition = toml::from_str(linear).unwrap();
    let scene = condition
        .scene("coloured-room", &toml::Table::new())
        .unwrap();
    let scan = SimulatedScan::record(&scene, &GridSettings::default(), Repeats::default());
    scan.save(dir).unwrap();
    if with_ramp {
        add_ramp(dir, &scene);
    }
    scan
}

fn add_ramp(dir: &Path, scene: &Scene) {
    let mut folder = ScanFolder::open(dir).unwrap();
    for stage in Stage::BOTH {
        let room = Room::new(scene, stage);
        for (k, colour) in ramp_colours().into_iter().enumerate() {
            let picture = (Pattern::Solid { colour }).raster(scene.projector_size());
            let frame = room.render(&scene.project(&picture), 100 + k as u64);
            folder
                .add_capture(stage, Shows::Solid(colour), &frame)
                .unwrap();
        }
    }
}

fn process(dir: &Path) -> (Processed, serde_json::Value) {
    let processed = process_scan(&ScanFolder::open(dir).unwrap(), &Config::default()).unwrap();
    let summary = std::fs::read(&processed.paths.summary).unwrap();
    (processed, serde_json::from_slice(&summary).unwrap())
}

#[test]
fn a_ramp_in_the_scan_folder_is_measured_used_and_told_and_improves_the_reading() {
    let dir = tempfile::tempdir().unwrap();
    let [plain, ramp] = ["plain", "ramp"].map(|name| dir.path().join(name));
    let scan = record(&plain, false);
    record(&ramp, true);
    let (assumed, assumed_summary) = process(&plain);
    let (measured, summary) = process(&ramp);

    assert_eq!(assumed_summary["response"]["curve"], "srgb");
    assert_eq!(summary["response"]["curve"], "measured");
    assert!(summary["response"]["residual_levels"].as_f64().unwrap() < 1.0);
    let used = &summary["settings"]["response"]["curve"];
    let used: ResponseCurve = serde_json::from_value(used.clone()).unwrap();
    let middle = used.table()[128];
    assert!((middle - 0.5).abs() < 0.02, "byte 128 is {middle} of white");
    let report = std::fs::read_to_string(&measured.paths.report).unwrap();
    assert!(report.contains("id=\"response\""));

    let rms = |processed: &Processed| {
        let object = processed.result.object.as_ref().unwrap();
        let read: Vec<_> = object.grid.vertices().collect();
        let score = score_stage(&scan.truth, &read, Stage::Object);
        assert_eq!(score.wrong, 0);
        score.rms_px.unwrap()
    };
    let (with, without) = (rms(&measured), rms(&assumed));
    assert!(
        with < 0.9 * without,
        "{with} px against {without} px with sRGB"
    );
}
