//! The whole rig in simulated rooms: the real programs, the real wire, against the simulation's truth.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    fs,
    io::{BufRead, BufReader},
    path::Path,
    process::{Command, Stdio},
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use acquirer::projector_link::{LinkError, LinkSettings, ProjectorLink};
use rig_tests::ProjectorProgram;
use serde_json::Value;
use shared::protocol::Role;

/// One rig at a time: a simulated camera wants a processor of its own, as a real one would have.
static RIG: Mutex<()> = Mutex::new(());

fn demo(scene: &str, more: &[&str]) -> (tempfile::TempDir, Value) {
    let _rig = RIG.lock().unwrap_or_else(PoisonError::into_inner);
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("scan");
    let output = Command::new(env!("CARGO_BIN_EXE_acquirer"))
        .args(["demo", "--json", "--scene", scene, "--out"])
        .arg(&out)
        .args(more)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    (
        dir,
        serde_json::from_slice(&output.stdout).expect("one JSON object on standard output"),
    )
}

/// The scan's figures against the simulation's truth, and what the folder must hold.
fn check(scene: &str, least_coverage_percent: f64) {
    let (dir, figures) = demo(scene, &[]);
    let truth = figures["truth"].as_array().unwrap();
    assert_eq!(truth.len(), 2, "both stages are scored");
    for stage in truth {
        assert_eq!(stage["wrong"], 0, "{scene}: {stage}");
        let coverage = stage["coverage_percent"].as_f64().unwrap();
        assert!(coverage >= least_coverage_percent, "{scene}: {stage}");
    }
    let response = &figures["summary"]["response"];
    assert_eq!(response["curve"], "srgb", "{scene}: {response}");
    let residual = response["residual_levels"].as_f64().unwrap();
    assert!(residual < 1.0, "{scene}: {response}");
    let colours = figures["colours"]["best"].as_array().unwrap();
    assert_eq!(colours.len(), 4);
    let manifest = fs::read(dir.path().join("scan/scan.json")).unwrap();
    let manifest: Value = serde_json::from_slice(&manifest).unwrap();
    let latency_ms = manifest["latency"]["latency"]["ms"].as_f64();
    assert!(
        latency_ms.is_some_and(|ms| (45.0..110.0).contains(&ms)),
        "the room's display lags 60 ms, and the wire and the machine add some: {}",
        manifest["latency"]
    );
    assert!(manifest["latency"]["checked_changes"].as_u64() > Some(4));
    assert_eq!(
        manifest["pattern"]["colours"], figures["colours"]["best"],
        "the grid took the choice"
    );
    for part in ["jitter", "readout", "exposure", "change"] {
        let ms = &manifest["latency"][part];
        assert!(
            ms["ms"].is_number() && ms["uncertainty_ms"].is_number(),
            "{part}"
        );
    }
    assert!(manifest["latency"]["clock_uncertainty_ms"].is_number());
    for noted in ["latency", "camera_name", "settings", "frames_lost"] {
        assert!(!manifest[noted].is_null(), "{noted} stands in scan.json");
    }
    for file in [
        "report.html",
        "vertices.csv",
        "shifts.csv",
        "points.ply",
        "summary.json",
    ] {
        assert!(
            dir.path().join("scan/results").join(file).exists(),
            "{file}"
        );
    }
}

#[test]
fn the_demo_reads_the_cube_without_a_wrong_label() {
    check("cube", 90.0);
}

#[test]
fn the_demo_reads_the_cylinder_without_a_wrong_label() {
    check("cylinder", 90.0);
}

#[test]
fn the_demo_reads_the_coloured_room_without_a_wrong_label() {
    check("coloured-room", 75.0);
}

#[test]
fn the_demo_densifies_the_cylinder() {
    let (dir, figures) = demo("cylinder", &["--densify", "31"]);
    let finer = &figures["summary"]["finer"][0];
    assert_eq!(finer["lines"], serde_json::json!([31, 31]));
    let base = figures["summary"]["object"]["crossings_labelled"].as_u64();
    let labelled = finer["object"]["crossings_labelled"].as_u64();
    assert!(labelled > base.map(|n| 3 * n), "{finer}");
    let results = dir.path().join("scan/results");
    assert!(results.join("finer-31/vertices.csv").exists());
    assert!(results.join("pictures/labels-object-finer-31.png").exists());
}

#[test]
fn a_grid_that_there_is_not_is_wrong_use() {
    let output = Command::new(env!("CARGO_BIN_EXE_acquirer"))
        .args(["demo", "--densify", "32"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("[31, 63, 127, 255]"), "{message}");
}

#[test]
fn a_recording_replayed_gives_the_same_captures_and_labels() {
    let (dir, figures) = demo("cube", &[]);
    let scan = dir.path().join("scan");
    let again = dir.path().join("again");
    let _rig = RIG.lock().unwrap_or_else(PoisonError::into_inner);
    let projector = ProjectorProgram::headless().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_acquirer"))
        .args(["scan", "--json", "--projector", projector.address()])
        .args(["--camera", &format!("replay:{}", scan.display())])
        .arg("--calibration")
        .arg(scan.join("calibration.json"))
        .arg("--out")
        .arg(&again)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let replayed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        replayed["summary"]["object"]["crossings_labelled"],
        figures["summary"]["object"]["crossings_labelled"]
    );
    let bytes = |dir: &Path| fs::read(dir.join("object/unary-00.png")).unwrap();
    assert!(bytes(&scan) == bytes(&again));
}

/// The lines of `acquirer live` in the simulated cube room.
fn live_lines(mode: &[&str]) -> Vec<Value> {
    live_output(&[&["--frames", "8"], mode].concat()).0
}

/// The lines, and all that is logged.
fn live_output(arguments: &[&str]) -> (Vec<Value>, String) {
    let _rig = RIG.lock().unwrap_or_else(PoisonError::into_inner);
    let projector = ProjectorProgram::headless().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_acquirer"))
        .args(["live", "--json", "--camera", "sim:cube"])
        .args(["--projector", projector.address()])
        .args(arguments)
        .env("RUST_LOG", "acquirer=debug")
        .output()
        .unwrap();
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{log}");
    let lines = String::from_utf8(output.stdout).unwrap();
    let lines = lines
        .lines()
        .map(|line| serde_json::from_str(line).unwrap());
    (lines.collect(), log)
}

#[test]
fn live_reading_checks_the_latency_as_often_as_told_and_reads_on() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("acquirer.toml");
    fs::write(&config, "[latency]\ncheck_every_s = 0.3\n").unwrap();
    let config = config.to_str().unwrap();
    let often = ["--mode", "dynamic", "--frames", "40", "--config", config];
    let (lines, log) = live_output(&often);
    assert_eq!(lines.len(), 40);
    for line in &lines {
        assert_eq!(line["pattern"], "coded", "black is not told: {line}");
    }
    let began = log.find("Latency {").unwrap_or_else(|| panic!("{log}"));
    // a recording of the references, then the checks
    let checks = log[began..].matches("changes came").count();
    assert!(checks >= 3, "{log}");
}

#[test]
fn live_reading_prints_one_line_per_frame_and_ends_after_the_frames_asked_for() {
    let lines = live_lines(&["--mode", "dynamic"]);
    assert_eq!(lines.len(), 8);
    let numbers: Vec<_> = lines.iter().map(|line| line["frame"].as_u64()).collect();
    assert!(numbers.is_sorted(), "{numbers:?}");
    for line in &lines {
        assert_eq!(line["pattern"], "coded", "{line}");
        assert!(line["crossings"].as_u64() > Some(150), "{line}");
        assert!(line["ms"].as_f64() > Some(0.0) && line["reasons"].is_object());
    }
}

#[test]
fn live_tracking_carries_labels_on_the_unary_grid_and_refreshes_them() {
    let lines = live_lines(&["--mode", "tracking", "--refresh", "3"]);
    let shows = |pattern: &str| {
        lines
            .iter()
            .filter(|line| line["pattern"] == pattern)
            .count()
    };
    assert!(shows("unary") >= 4 && shows("coded") >= 1, "{lines:?}");
    for line in lines.iter().filter(|line| line["pattern"] != "mixed") {
        assert!(line["crossings"].as_u64() > Some(150), "{line}");
    }
}

#[test]
fn live_static_averages_frames_and_reads_as_many_crossings() {
    let lines = live_lines(&["--mode", "static", "--average", "3"]);
    assert_eq!(lines.len(), 8);
    for line in &lines {
        assert_eq!(line["pattern"], "coded", "{line}");
        assert!(line["crossings"].as_u64() > Some(150), "{line}");
    }
}

#[test]
fn live_reading_ends_on_ctrl_c_with_0_and_whole_lines_and_leaves_the_projector_to_others() {
    let _rig = RIG.lock().unwrap_or_else(PoisonError::into_inner);
    let projector = ProjectorProgram::headless().unwrap();
    let mut live = Command::new(env!("CARGO_BIN_EXE_acquirer"))
        .args(["live", "--json", "--camera", "sim:cube"])
        .args(["--projector", projector.address()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(live.stdout.take().unwrap()).lines();
    let mut read: Vec<String> = lines.by_ref().take(3).map(Result::unwrap).collect();
    let process = live.id().to_string();
    let signal = Command::new("kill").args(["-s", "INT", &process]).status();
    assert!(signal.unwrap().success());
    read.extend(lines.map(Result::unwrap));
    let output = live.wait_with_output().unwrap();
    let messages = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{messages}");
    assert!(messages.contains("latency") && messages.contains("jitter"));
    for line in &read {
        let line: Value = serde_json::from_str(line).unwrap();
        for key in ["frame", "time_s", "pattern", "crossings", "reasons", "ms"] {
            assert!(!line[key].is_null(), "{key}: {line}");
        }
    }
    let next = LinkSettings::new(projector.address(), "the next one", Role::Controller);
    let deadline = Instant::now() + Duration::from_secs(20);
    while let Err(error) = ProjectorLink::connect(&next) {
        // the projector learns of the end a moment later
        let taken = matches!(error, LinkError::Taken(_));
        assert!(taken && Instant::now() < deadline, "{error}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn an_unknown_scene_is_refused_with_the_ones_there_are() {
    let output = Command::new(env!("CARGO_BIN_EXE_acquirer"))
        .args(["demo", "--scene", "atlantis"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("atlantis") && message.contains("cylinder"),
        "{message}"
    );
}
