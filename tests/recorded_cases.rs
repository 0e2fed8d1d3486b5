//! Recorded scenes with known truth, read by the real program. The pictures were rendered by a path tracer that
//! knows nothing of this project; see tests/recorded/README.md.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use acquirer::score::{StageScore, score_stage};
use rig_tests::{copy_folder, read_truth, read_vertices};
use shared::stage::Stage;

/// What is asked of a case in both stages.
struct Limits {
    coverage_percent: f64,
    wrong_percent: f64,
    rms_px: f64,
}

fn recorded(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../tests/recorded")
        .join(name)
}

fn process(dir: &Path, more: &[&str]) -> serde_json::Value {
    let mut program = Command::new(env!("CARGO_BIN_EXE_acquirer"));
    figures(program.arg("process").arg(dir).arg("--json").args(more))
}

/// What a run of the program printed.
fn figures(program: &mut Command) -> serde_json::Value {
    let output = program.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).expect("one JSON object on standard output")
}

fn scores(name: &str, more: &[&str]) -> (tempfile::TempDir, Vec<StageScore>) {
    let dir = tempfile::tempdir().unwrap();
    copy_folder(&recorded(name), dir.path()).unwrap();
    process(dir.path(), more);
    let truth = read_truth(&dir.path().join("truth.csv")).unwrap();
    let scores = Stage::BOTH.map(|stage| {
        let read = read_vertices(&dir.path().join("results"), stage).unwrap();
        score_stage(&truth, &read, stage)
    });
    for score in &scores {
        println!(
            "{name} {} {}: {}",
            more.join(" "),
            score.stage,
            score.sentence()
        );
    }
    (dir, scores.into())
}

fn assert_within(scores: &[StageScore], limits: &Limits) {
    for score in scores {
        let told = score.sentence();
        assert!(
            score.coverage_percent >= limits.coverage_percent,
            "{}: {told}",
            score.stage
        );
        assert!(
            score.wrong_percent <= limits.wrong_percent,
            "{}: {told}",
            score.stage
        );
        assert!(
            score.rms_px.is_some_and(|rms| rms <= limits.rms_px),
            "{}: {told}",
            score.stage
        );
    }
}

#[test]
fn the_grey_wall_and_white_cube_are_read() {
    let limits = Limits {
        coverage_percent: 95.0,
        wrong_percent: 0.5,
        rms_px: 0.3,
    };
    assert_within(&scores("wall-cube", &[]).1, &limits);
}

#[test]
fn the_coloured_room_is_read() {
    let limits = Limits {
        coverage_percent: 85.0,
        wrong_percent: 0.5,
        rms_px: 0.4,
    };
    assert_within(&scores("coloured-room", &[]).1, &limits);
}

#[test]
fn our_method_reads_more_than_the_thesis_and_fewer_labels_are_wrong() {
    for name in ["wall-cube", "coloured-room"] {
        let ours = scores(name, &[]).1;
        let thesis = scores(name, &["--method", "thesis"]).1;
        for (ours, thesis) in ours.iter().zip(&thesis) {
            assert!(
                ours.coverage_percent > thesis.coverage_percent,
                "{name}: {}",
                thesis.sentence()
            );
            assert!(ours.wrong <= thesis.wrong, "{name}: {}", ours.sentence());
        }
    }
}

#[test]
fn the_same_scan_processed_twice_gives_identical_files_on_any_number_of_threads() {
    let read_on = |threads: &str| {
        let dir = tempfile::tempdir().unwrap();
        copy_folder(&recorded("wall-cube"), dir.path()).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_acquirer"));
        program.env("RAYON_NUM_THREADS", threads);
        figures(program.args(["process", "--json"]).arg(dir.path()));
        dir
    };
    let dirs = ["1", "3"].map(read_on);
    let [first, second] = dirs.each_ref().map(|dir| dir.path().join("results"));
    let files = files_below(&first);
    assert_eq!(files, files_below(&second));
    assert!(files.len() >= 20, "{files:?}");
    for file in files {
        let bytes = |results: &Path| fs::read(results.join(&file)).unwrap();
        assert!(
            bytes(&first) == bytes(&second),
            "{} differs",
            file.display()
        );
    }
}

/// All files in a folder and its folders, relative to it, sorted.
fn files_below(dir: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(dir).unwrap().map(Result::unwrap) {
        let name = PathBuf::from(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            files.extend(
                files_below(&entry.path())
                    .iter()
                    .map(|file| name.join(file)),
            );
        } else {
            files.push(name);
        }
    }
    files.sort();
    files
}

#[test]
fn a_calibrated_scan_gives_points_on_the_true_surface() {
    let (dir, _) = scores("wall-cube", &[]);
    let truth = read_truth(&dir.path().join("truth.csv")).unwrap();
    let mut table = csv::Reader::from_path(dir.path().join("results/points.csv")).unwrap();
    assert_eq!(
        table.headers().unwrap(),
        &[
            "row",
            "column",
            "vertex",
            "x_mm",
            "y_mm",
            "z_mm",
            "confidence"
        ][..]
    );
    let mut errors = Vec::new();
    for row in table
        .records()
        .map(Result::unwrap)
        .filter(|row| !row[2].is_empty())
    {
        let own = truth.iter().find(|vertex| {
            vertex.stage == Stage::Object
                && vertex.clear
                && vertex.index.row.to_string() == row[0]
                && vertex.index.column.to_string() == row[1]
                && vertex.corner.name() == &row[2]
        });
        if let Some(own) = own {
            errors.push((row[5].parse::<f64>().unwrap() - own.point_mm.z) / own.point_mm.z);
        }
    }
    assert!(errors.len() > 500, "{} vertices", errors.len());
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!(
        rms < 0.005,
        "depth RMS is {:.3} % of the distance",
        100.0 * rms
    );
}

#[test]
fn a_broken_folder_is_refused_with_the_reason() {
    let run = |dir: &Path| {
        let output = Command::new(env!("CARGO_BIN_EXE_acquirer"))
            .arg("process")
            .arg(dir)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap()
    };
    let dir = tempfile::tempdir().unwrap();
    assert!(run(dir.path()).contains("scan.json"));
    fs::write(
        dir.path().join("scan.json"),
        "{\"format\": 1,\n \"pattern\": 3}",
    )
    .unwrap();
    assert!(run(dir.path()).contains("line 2"), "{}", run(dir.path()));
    copy_folder(&recorded("wall-cube"), dir.path()).unwrap();
    fs::write(
        dir.path().join("object/prmvs-00.png"),
        b"\x89PNG\r\n\x1a\nnot really",
    )
    .unwrap();
    assert!(run(dir.path()).contains("prmvs-00.png"));
}

#[test]
fn wrong_use_ends_with_code_two() {
    for arguments in [
        &["process"][..],
        &["scan"],
        &["process", "x", "--method", "magic"],
        &["fly"],
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_acquirer"))
            .args(arguments)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}
