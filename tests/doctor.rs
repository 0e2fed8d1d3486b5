//! `acquirer doctor` in simulated rooms, by the real programs on the real wire: each fault gives its finding and no
//! other, mild ones and the shipped rooms give none.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    fs,
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    path::{Path, PathBuf},
    process::{Command, Output},
    sync::{Mutex, PoisonError},
    thread,
    time::Duration,
};

use rig_tests::{ProjectorProgram, copy_folder};
use serde_json::Value;

/// One rig at a time: a simulated camera wants a processor of its own, as a real one would have.
static RIG: Mutex<()> = Mutex::new(());

/// How often a busy computer is asked, and what the doctor says of it.
const TRIES: usize = 3;
const TOO_BUSY: &str = "this computer is too busy";

/// The shipped scenes in a folder of their own, where one can be changed.
struct Scenes(tempfile::TempDir);

impl Scenes {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/scenes");
        copy_folder(&shipped, dir.path()).unwrap();
        Self(dir)
    }

    /// A scene with some keys of its tables changed or added: (table, key, value). At half its rate, so that a busy
    /// machine can follow, and no whole part of the mains' or a colour wheel's.
    fn with(&self, scene: &str, changes: &[(&str, &str, &str)]) -> PathBuf {
        let path = self.0.path().join(format!("{scene}.toml"));
        let mut table: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
        let rate = ("camera", "frame_rate_hz", "13.7");
        for (part, key, value) in [&[rate], changes].concat() {
            let value: toml::Table = format!("value = {value}").parse().unwrap();
            let part = table.entry(part).or_insert(toml::Table::new().into());
            let part = part.as_table_mut().unwrap();
            part.insert(key.into(), value["value"].clone());
        }
        let changed = self.0.path().join("changed.toml");
        fs::write(&changed, table.to_string()).unwrap();
        changed
    }
}

fn doctor(projector: &str, camera: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_acquirer"))
        .args(["doctor", "--json", "--projector", projector])
        .args(["--camera", camera])
        .output()
        .unwrap()
}

/// What the doctor finds, and its exit code. A computer that is busy with other things is asked again for what it could
/// not see in time.
fn examine(scene: &Path) -> (Value, Option<i32>) {
    let _rig = RIG.lock().unwrap_or_else(PoisonError::into_inner);
    let mut tries = (0..TRIES).map(|_| examine_once(scene));
    let busy = |(diagnosis, _): &(Value, Option<i32>)| diagnosis.to_string().contains(TOO_BUSY);
    tries
        .find(|found| !busy(found))
        .unwrap_or_else(|| examine_once(scene))
}

fn examine_once(scene: &Path) -> (Value, Option<i32>) {
    let projector = ProjectorProgram::headless().unwrap();
    let output = doctor(projector.address(), &format!("sim:{}", scene.display()));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let diagnosis = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{message}"));
    (diagnosis, output.status.code())
}

/// Asserts that a changed room gives one finding, which says and advises certain words.
fn finds(scene: &str, changes: &[(&str, &str, &str)], (finding, words): (&str, &[&str])) {
    let scenes = Scenes::new();
    let (diagnosis, code) = examine(&scenes.with(scene, changes));
    expect(&diagnosis, (finding, words));
    assert_eq!(code, Some(1));
}

fn expect(diagnosis: &Value, (finding, words): (&str, &[&str])) {
    assert_eq!(
        diagnosis["bad"],
        serde_json::json!([finding]),
        "{diagnosis:#}"
    );
    assert_eq!(diagnosis["well"], false);
    let findings = diagnosis["findings"].as_array().unwrap();
    let found = findings.iter().find(|found| found["name"] == finding);
    let found = found.unwrap();
    let text = format!("{} {}", found["says"], found["fix"]);
    for word in words {
        assert!(text.contains(word), "{word}: {text}");
    }
}

fn is_well(scene: &str, changes: &[(&str, &str, &str)]) {
    let scenes = Scenes::new();
    let (diagnosis, code) = examine(&scenes.with(scene, changes));
    let findings = diagnosis["findings"].as_array().unwrap();
    let busy = |finding: &Value| finding["says"].as_str().unwrap().contains(TOO_BUSY);
    let good = findings
        .iter()
        .all(|finding| finding["state"] == "good" || busy(finding));
    assert!(good && findings.len() == 10, "{scene}: {diagnosis:#}");
    assert_eq!(code, Some(0), "{scene}");
}

#[test]
fn the_cube_room_is_well() {
    is_well("cube", &[]);
}

#[test]
fn the_coloured_room_is_well() {
    is_well("coloured-room", &[]);
}

#[test]
fn the_cylinder_room_is_well() {
    is_well("cylinder", &[]);
}

#[test]
fn the_dark_cloth_room_is_well() {
    is_well("dark-cloth", &[]);
}

#[test]
fn the_figure_room_is_well() {
    is_well("figure", &[]);
}

#[test]
fn the_glossy_mug_room_is_well() {
    is_well("glossy-mug", &[]);
}

#[test]
fn the_two_boxes_room_is_well() {
    is_well("two-boxes", &[]);
}

/// A little of everything: below each limit, all together.
#[test]
fn mild_faults_are_none() {
    is_well(
        "cube",
        &[
            ("projector", "blur_px", "1.2"),
            ("camera", "blur_px", "0.8"),
            ("camera", "exposure", "1.3"),
            ("projector", "display_latency_ms", "90.0"),
            // a busy machine that runs the test adds its own
            ("projector", "display_jitter_ms", "12.0"),
            ("ambient", "level", "0.1"),
            ("faults", "lamp_flicker", "0.3"),
            ("faults", "lamp_flicker_hz", "120.0"),
            ("faults", "lost_share", "0.01"),
            ("camera", "readout_ms", "50.0"),
            ("faults", "delivered_rate_hz", "13.3"),
        ],
    );
}

/// Automatics that can be held are held.
#[test]
fn automatics_that_obey_are_none() {
    is_well(
        "cube",
        &[
            ("camera", "auto_exposure", "true"),
            ("camera", "auto_white_balance", "true"),
        ],
    );
}

#[test]
fn automatic_exposure_that_cannot_be_held_is_found() {
    finds(
        "cube",
        &[
            ("camera", "auto_exposure", "true"),
            ("faults", "no_controls", "true"),
        ],
        ("automatics", &["automatic exposure", "cameras --controls"]),
    );
}

#[test]
fn automatic_white_balance_that_cannot_be_held_is_found() {
    finds(
        "cube",
        &[
            ("camera", "auto_white_balance", "true"),
            ("ambient", "colour", "\"#ff8040\""),
            ("ambient", "level", "0.3"),
            ("faults", "no_controls", "true"),
        ],
        ("automatics", &["white balance"]),
    );
}

/// An exposure of whole swings hides them, however strong they are.
#[test]
fn flicker_that_the_exposure_hides_is_none() {
    is_well(
        "cube",
        &[
            ("ambient", "level", "0.3"),
            ("camera", "exposure_ms", "50.0"),
            ("camera", "readout_ms", "15.0"),
            ("faults", "lamp_flicker", "1.0"),
            ("faults", "lamp_flicker_hz", "100.0"),
            ("faults", "colour_wheel_hz", "120.0"),
        ],
    );
}

#[test]
fn another_lit_output_is_found() {
    finds(
        "cube",
        &[("faults", "other_output", "\"#c0d0e0\"")],
        ("screen", &["lit scene", "another output", "--screen"]),
    );
}

#[test]
fn a_dark_output_is_found() {
    finds(
        "cube",
        &[
            ("faults", "other_output", "\"#000000\""),
            ("ambient", "level", "0.02"),
        ],
        ("screen", &["next to no light"]),
    );
}

#[test]
fn a_picture_scaled_down_is_found() {
    finds(
        "cube",
        &[("faults", "picture_scale", "[0.9, 0.9]")],
        ("pixels", &["width and height", "1024x768"]),
    );
}

#[test]
fn overscan_in_one_direction_is_found() {
    finds(
        "coloured-room",
        &[("faults", "picture_scale", "[1.04, 1.0]")],
        ("pixels", &["width is scaled", "overscan"]),
    );
}

#[test]
fn a_keystone_correction_is_found() {
    finds(
        "two-boxes",
        &[("faults", "keystone", "0.08")],
        ("pixels", &["keystone"]),
    );
}

#[test]
fn a_projector_out_of_focus_is_found_by_the_scenes_own_edges() {
    finds(
        "coloured-room",
        &[("projector", "blur_px", "4.0")],
        ("focus", &["the projector is out of focus", "focus ring"]),
    );
}

#[test]
fn a_camera_out_of_focus_is_found_by_the_scenes_own_edges() {
    finds(
        "coloured-room",
        &[("camera", "blur_px", "2.5")],
        ("focus", &["the camera is out of focus"]),
    );
}

#[test]
fn clipped_white_is_found() {
    finds(
        "figure",
        &[("camera", "exposure", "3.0")],
        ("exposure", &["clipped", "halve"]),
    );
}

#[test]
fn a_dark_scene_is_found() {
    finds(
        "cube",
        &[("camera", "exposure", "0.1")],
        ("exposure", &["dark", "times longer"]),
    );
}

#[test]
fn a_lamp_on_50_hz_mains_is_found() {
    finds(
        "cube",
        &[
            ("ambient", "level", "0.2"),
            ("camera", "exposure_ms", "4.0"),
            ("faults", "lamp_flicker", "0.5"),
        ],
        ("mains_flicker", &["100 times a second", "10.0 ms"]),
    );
}

#[test]
fn a_lamp_on_60_hz_mains_is_found() {
    finds(
        "cylinder",
        &[
            ("ambient", "level", "0.2"),
            ("camera", "exposure_ms", "5.0"),
            ("faults", "lamp_flicker", "0.5"),
            ("faults", "lamp_flicker_hz", "120.0"),
        ],
        ("mains_flicker", &["120 times a second", "8.3 ms"]),
    );
}

#[test]
fn a_colour_wheel_is_found() {
    finds(
        "cube",
        &[("faults", "colour_wheel_hz", "120.0")],
        ("colour_wheel", &["one after the other", "16.7 ms"]),
    );
}

#[test]
fn a_long_latency_is_found() {
    finds(
        "cube",
        &[("projector", "display_latency_ms", "300.0")],
        ("latency", &["only", "game"]),
    );
}

/// With the read-out of a camera of this rate: a change that one frame in two shows would not tell its own length.
#[test]
fn a_wide_jitter_is_found() {
    finds(
        "cube",
        &[
            ("projector", "display_latency_ms", "10.0"),
            ("projector", "display_jitter_ms", "90.0"),
            ("camera", "readout_ms", "50.0"),
            ("camera", "exposure_ms", "20.0"),
        ],
        ("latency", &["varies"]),
    );
}

#[test]
fn lost_frames_are_found() {
    finds(
        "cube",
        &[("faults", "lost_share", "0.2")],
        ("frames", &["get lost", "USB"]),
    );
}

#[test]
fn a_rate_below_the_cameras_own_is_found() {
    finds(
        "cube",
        &[("faults", "delivered_rate_hz", "9.0")],
        ("frames", &["9.0 frames per second", "13.7 were set"]),
    );
}

/// Passes bytes on, each way with a delay; stops with either end.
fn slow_proxy(to: String, delay: Duration) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        for client in listener.incoming().flatten() {
            let Ok(server) = TcpStream::connect(&to) else {
                return;
            };
            for (mut from, mut to) in [
                (client.try_clone().unwrap(), server.try_clone().unwrap()),
                (server, client),
            ] {
                thread::spawn(move || {
                    let mut bytes = [0; 4096];
                    while let Ok(count @ 1..) = from.read(&mut bytes) {
                        thread::sleep(delay);
                        if to.write_all(&bytes[..count]).is_err() {
                            return;
                        }
                    }
                });
            }
        }
    });
    address
}

#[test]
fn a_slow_network_is_found() {
    let scenes = Scenes::new();
    let scene = scenes.with("cube", &[]);
    let _rig = RIG.lock().unwrap_or_else(PoisonError::into_inner);
    let projector = ProjectorProgram::headless().unwrap();
    let proxy = slow_proxy(projector.address().into(), Duration::from_millis(20));
    let output = doctor(&proxy, &format!("sim:{}", scene.display()));
    let diagnosis = serde_json::from_slice(&output.stdout).unwrap();
    expect(&diagnosis, ("network", &["known to", "cable"]));
}

#[test]
fn a_recording_is_wrong_use() {
    let output = doctor("127.0.0.1:1", "replay:scan");
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("recording"), "{message}");
}
