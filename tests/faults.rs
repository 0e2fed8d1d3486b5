//! What a lab day brings: programs that end at the wrong moment, networks that are bad or cut, full disks, folders that
//! can't be written, no display, no graphics driver, desktops and monitors that go, clocks that jump. Each is recovered
//! from or ends with a message and exit code 1.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

#[allow(dead_code, reason = "there is no mouse here")]
#[path = "projector_support/display.rs"]
mod display;

#[path = "faults/clock.rs"]
mod clock;
#[path = "faults/desktop.rs"]
mod desktop;
#[path = "faults/desktop_client.rs"]
mod desktop_client;
#[path = "faults/network.rs"]
mod network;
#[path = "faults/programs.rs"]
mod programs;
#[path = "faults/storage.rs"]
mod storage;

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
    time::{Duration, Instant},
};

use rig_tests::{ProjectorProgram, built_program};
use serde_json::Value;

/// Far longer than anything takes; a test that waits this long has failed.
const PATIENCE: Duration = Duration::from_secs(120);

fn recorded() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("recorded/wall-cube")
}

/// `acquirer scan` of a replayed recording, with its secrets in `home`.
fn scan(address: &str, out: &Path, home: &Path) -> Command {
    let mut command = Command::new(built_program("acquirer").unwrap());
    command
        .args(["scan", "--json", "--projector", address])
        .args(["--camera", &format!("replay:{}", recorded().display())])
        .arg("--out")
        .arg(out)
        .env("XDG_CONFIG_HOME", home);
    command
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[track_caller]
fn assert_fails(output: &Output, why: &str) {
    assert_eq!(output.status.code(), Some(1), "{}", message(output));
    assert!(message(output).contains(why), "{}", message(output));
}

#[track_caller]
fn assert_done(output: &Output) -> Value {
    assert!(output.status.success(), "{}", message(output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Looks again and again until there is something.
#[track_caller]
fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Pairs the computer with secrets in `here` with a projector with secrets in `there`, by this address.
fn pair(projector: &ProjectorProgram, address: &str, there: &Path, here: &Path) {
    assert!(!projector.port().is_empty());
    let code = Command::new(built_program("projector").unwrap())
        .arg("pair")
        .env("XDG_CONFIG_HOME", there)
        .output()
        .unwrap();
    let code = String::from_utf8(code.stdout).unwrap();
    let paired = Command::new(built_program("acquirer").unwrap())
        .args(["pair", code.trim(), "--projector", address])
        .env("XDG_CONFIG_HOME", here)
        .output()
        .unwrap();
    assert!(paired.status.success(), "{}", message(&paired));
}
