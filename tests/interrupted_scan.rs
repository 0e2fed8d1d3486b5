//! Scans that are interrupted and go on, that are checked, and that are read twice: the program `acquirer` itself.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

use acquirer::scan::ScanFolder;
use rig_tests::{ProjectorProgram, copy_folder};
use serde_json::Value;
use shared::stage::Stage;

/// Far longer than anything takes; a test that waits this long has failed.
const PATIENCE: Duration = Duration::from_secs(120);

fn acquirer() -> Command {
    Command::new(env!("CARGO_BIN_EXE_acquirer"))
}

fn recorded() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/recorded/wall-cube")
}

/// A copy of a recorded scan.
fn copy(root: &Path, name: &str) -> PathBuf {
    let dir = root.join(name);
    copy_folder(&recorded(), &dir).unwrap();
    dir
}

/// `acquirer scan` of a replayed recording.
fn scan(projector: &ProjectorProgram, out: &Path) -> Command {
    let mut command = acquirer();
    command
        .args(["scan", "--json", "--take-over"])
        .args(["--projector", projector.address()])
        .args(["--camera", &format!("replay:{}", recorded().display())])
        .arg("--out")
        .arg(out);
    command
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file of a folder with its content.
fn contents(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(contents(&path));
        } else {
            files.insert(path.clone(), fs::read(path).unwrap());
        }
    }
    files
}

/// The results of a scan by their names.
fn results(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let results = dir.join("results");
    let named = |(path, bytes): (PathBuf, Vec<u8>)| {
        (path.strip_prefix(&results).unwrap().to_owned(), bytes)
    };
    contents(&results).into_iter().map(named).collect()
}

fn process(dir: &Path, threads: &str) {
    let output = acquirer()
        .args(["process", "--json"])
        .arg(dir)
        .env("RAYON_NUM_THREADS", threads)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", message(&output));
}

/// Kills spread over the time that reading takes.
const KILLS: u32 = 5;

#[test]
fn the_same_scan_gives_the_same_bytes_and_a_killed_reading_only_whole_files() {
    let root = tempfile::tempdir().unwrap();
    let whole = copy(root.path(), "whole");
    let begun = Instant::now();
    process(&whole, "1");
    let (time, expected) = (begun.elapsed(), results(&whole));
    assert!(expected.len() > 10);
    let dir = copy(root.path(), "killed");
    for kill in 1..=KILLS {
        let mut child = acquirer()
            .args(["process", "--json"])
            .arg(&dir)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(time * kill / KILLS);
        child.kill().unwrap();
        child.wait().unwrap();
        if !dir.join("results").exists() {
            continue;
        }
        for (file, bytes) in results(&dir) {
            let unfinished = file.extension().is_some_and(|ending| ending == "part");
            assert!(unfinished || expected[&file] == bytes, "{}", file.display());
        }
    }
    process(&dir, "3");
    let mut found = results(&dir);
    found.retain(|file, _| file.extension().is_none_or(|ending| ending != "part"));
    assert!(found.keys().eq(expected.keys()));
    let differing: Vec<_> = found.keys().filter(|k| found[*k] != expected[*k]).collect();
    assert_eq!(differing, Vec::<&PathBuf>::new());
}

#[test]
fn a_scan_killed_between_its_stages_is_resumed_with_what_it_had() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("scan");
    let projector = ProjectorProgram::headless().unwrap();
    // the command that places the object never ends by itself: the background is recorded when it runs
    let mut killed = scan(&projector, &out)
        .args(["--place-object", "sleep 300 & echo $! > placing; wait"])
        .current_dir(root.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let placing = root.path().join("placing");
    let deadline = Instant::now() + PATIENCE;
    while !fs::read_to_string(&placing).is_ok_and(|text| text.ends_with('\n')) {
        assert!(Instant::now() < deadline, "the background was not recorded");
        thread::sleep(Duration::from_millis(20));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let sleeper = fs::read_to_string(&placing).unwrap();
    Command::new("kill").arg(sleeper.trim()).status().unwrap();
    let folder = ScanFolder::open(&out).unwrap();
    assert!(folder.is_recorded(Stage::Background) && !folder.is_recorded(Stage::Object));
    let background = contents(&out.join("background"));

    let refused = scan(&projector, &out).output().unwrap();
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        message(&refused).contains("--resume"),
        "{}",
        message(&refused)
    );

    let resumed = scan(&projector, &out).arg("--resume").output().unwrap();
    assert!(resumed.status.success(), "{}", message(&resumed));
    let figures: Value = serde_json::from_slice(&resumed.stdout).unwrap();
    assert!(figures["summary"]["object"]["crossings_labelled"].as_u64() > Some(100));
    assert!(contents(&out.join("background")) == background, "kept");
    assert!(check(&out).status.success());
    // there is nothing left to record: no projector is needed
    drop(projector);
    let again = acquirer()
        .args([
            "scan",
            "--resume",
            "--json",
            "--projector",
            "127.0.0.1:1",
            "--out",
        ])
        .arg(&out)
        .output()
        .unwrap();
    assert!(again.status.success(), "{}", message(&again));
}

/// Names of the finer grids' pictures that the manifest tells of.
fn finer_pictures(dir: &Path) -> Vec<String> {
    // until there is a manifest there is none
    let Ok(folder) = ScanFolder::open(dir) else {
        return Vec::new();
    };
    let grids = folder.finer().unwrap();
    let captures = grids.iter().flat_map(|grid| &grid.captures);
    captures.map(|capture| capture.file.clone()).collect()
}

#[test]
fn a_scan_killed_in_the_middle_of_a_finer_grid_is_resumed_with_all_of_it() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("scan");
    let projector = ProjectorProgram::headless().unwrap();
    let scan = || {
        let mut command = acquirer();
        command
            .args(["scan", "--json", "--take-over", "--camera", "sim:cube"])
            .args(["--projector", projector.address(), "--out"])
            .arg(&out);
        command
    };
    let mut killed = scan()
        .args(["--densify", "31"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + PATIENCE;
    while finer_pictures(&out).is_empty() {
        assert!(Instant::now() < deadline, "no finer grid was recorded");
        thread::sleep(Duration::from_millis(2));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let before = finer_pictures(&out);
    let folder = ScanFolder::open(&out).unwrap();
    assert!(folder.is_recorded(Stage::Background) && !folder.is_recorded(Stage::Object));
    let background = contents(&out.join("background"));
    let lacking = |dir: &Path| {
        let found: Value = serde_json::from_slice(&check(dir).stdout).unwrap();
        found["unrecorded_finer"].clone()
    };
    let expected = serde_json::json!([{"stage": "background", "lines": 31}]);
    assert_eq!(lacking(&out), expected);

    // the lines are those that it was begun with
    let resumed = scan().arg("--resume").output().unwrap();
    assert!(resumed.status.success(), "{}", message(&resumed));
    assert!(contents(&out.join("background")) == background, "kept");
    let mut expected: Vec<String> = Vec::new();
    for stage in Stage::BOTH {
        for picture in ["prmvs-00", "prmvs-01", "unary-00", "unary-01"] {
            expected.push(format!("finer-31/{stage}/{picture}.png"));
        }
    }
    assert_eq!(finer_pictures(&out), expected);
    assert!(before.len() < expected.len() / 2, "killed after {before:?}");
    assert!(out.join("results/finer-31/vertices.csv").is_file());
    assert!(check(&out).status.success());
    assert_eq!(lacking(&out), serde_json::json!([]));
}

fn check(dir: &Path) -> Output {
    acquirer()
        .args(["check", "--json"])
        .arg(dir)
        .output()
        .unwrap()
}

/// What `acquirer check` says of a scan that is not intact.
fn damage(dir: &Path) -> BTreeMap<String, String> {
    let output = check(dir);
    assert_eq!(output.status.code(), Some(1), "{}", message(&output));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["intact"], false);
    let damaged = found["damaged"].as_array().unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let entries = damaged
        .iter()
        .map(|damaged| (text(&damaged["file"]), text(&damaged["reason"])));
    entries.collect()
}

#[test]
fn a_check_names_every_file_that_is_damaged_or_missing() {
    let root = tempfile::tempdir().unwrap();
    let dir = root.path().join("scan");
    let projector = ProjectorProgram::headless().unwrap();
    let output = scan(&projector, &dir).output().unwrap();
    assert!(output.status.success(), "{}", message(&output));
    let intact = check(&dir);
    assert!(intact.status.success(), "{}", message(&intact));
    let found: Value = serde_json::from_slice(&intact.stdout).unwrap();
    assert!(found["intact_files"].as_u64() > Some(30), "{found}");
    assert_eq!(
        (&found["intact"], &found["results"]),
        (&true.into(), &true.into())
    );

    // one bit, one file gone, one digit of the manifest, one result
    let picture = dir.join("object/prmvs-00.png");
    let mut bytes = fs::read(&picture).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&picture, bytes).unwrap();
    fs::remove_file(dir.join("background/white-01.png")).unwrap();
    let manifest = fs::read_to_string(dir.join("scan.json")).unwrap();
    let changed = manifest.replacen("\"row_width_px\": 6", "\"row_width_px\": 7", 1);
    assert_ne!(manifest, changed);
    fs::write(dir.join("scan.json"), changed).unwrap();
    let table = dir.join("results/vertices.csv");
    let text = fs::read_to_string(&table).unwrap();
    fs::write(&table, &text[..text.len() / 2]).unwrap();
    let damage = damage(&dir);
    let files: Vec<_> = damage.keys().map(String::as_str).collect();
    assert_eq!(
        files,
        [
            "background/white-01.png",
            "object/prmvs-00.png",
            "results/vertices.csv",
            "scan.json"
        ]
    );
    assert_eq!(damage["background/white-01.png"], "missing");
}

#[test]
fn a_scan_of_another_program_is_checked_by_reading_its_pictures() {
    let root = tempfile::tempdir().unwrap();
    let dir = copy(root.path(), "scan");
    let output = check(&dir);
    assert!(output.status.success(), "{}", message(&output));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(!found["without_checksum"].as_array().unwrap().is_empty());
    let picture = fs::read_dir(dir.join("object")).unwrap().next().unwrap();
    let picture = picture.unwrap().path();
    fs::write(&picture, b"no picture").unwrap();
    assert_eq!(damage(&dir).len(), 1);
}
