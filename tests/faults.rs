//! What a lab day brings: programs that end at the wrong moment, networks that are bad or cut, full disks, folders that
//! can't be written, no display. Each is recovered from or ends with a message and exit code 1.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

use acquirer::{
    projector_link::{LinkError, LinkSettings, ProjectorLink},
    scan::ScanFolder,
};
use rig_tests::{ProjectorProgram, built_program, relay};
use serde_json::Value;
use shared::{
    protocol::{Role, View},
    stage::Stage,
};

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

/// As the controller, as soon as the place is free.
fn controller(address: &str) -> ProjectorLink {
    let settings = LinkSettings::new(address, "next", Role::Controller);
    let deadline = Instant::now() + PATIENCE;
    loop {
        match ProjectorLink::connect(&settings) {
            Ok(link) => return link,
            Err(LinkError::Taken(_)) if Instant::now() < deadline => {
                thread::sleep(Duration::from_millis(50));
            }
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn a_projector_killed_in_the_middle_of_a_scan_is_told_and_the_scan_goes_on_with_the_next() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("scan");
    let home = root.path().join("projector");
    let projector = ProjectorProgram::on_network(&home, "0").unwrap();
    let port = projector.port().to_owned();
    pair(&projector, projector.address(), &home, root.path());
    let address = projector.address().to_owned();
    // when the object is to be placed, the background is recorded
    let kill = format!("kill -9 {}", projector.process());
    let output = scan(&address, &out, root.path())
        .args(["--place-object", &kill])
        .output()
        .unwrap();
    assert_fails(&output, "the connection to the projector was lost");
    assert!(
        ScanFolder::open(&out)
            .unwrap()
            .is_recorded(Stage::Background)
    );
    let output = scan(&address, &out, root.path()).arg("--resume").output();
    assert_fails(&output.unwrap(), "no projector program listens");

    drop(projector);
    let again = ProjectorProgram::on_network(&home, &port).unwrap();
    assert_eq!(again.address(), address);
    let output = scan(&address, &out, root.path()).arg("--resume").output();
    assert_done(&output.unwrap());
    assert!(ScanFolder::open(&out).unwrap().is_recorded(Stage::Object));
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

#[test]
fn an_acquirer_killed_at_any_moment_leaves_the_picture_and_the_place() {
    let projector = ProjectorProgram::headless().unwrap();
    for moment_ms in [150, 600, 1500] {
        let mut killed = Command::new(built_program("acquirer").unwrap())
            .args(["live", "--json", "--projector", projector.address()])
            .args(["--camera", &format!("replay:{}", recorded().display())])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(Duration::from_millis(moment_ms));
        killed.kill().unwrap();
        killed.wait().unwrap();
        let link = controller(projector.address());
        let before = link.state().unwrap().shown;
        thread::sleep(Duration::from_millis(200));
        assert_eq!(link.state().unwrap().shown, before, "it stands");
        link.show(View::White).unwrap();
    }
}

#[test]
fn a_scan_over_a_network_of_200_ms_and_5_percent_loss_is_as_good() {
    let root = tempfile::tempdir().unwrap();
    let home = root.path().join("projector");
    let projector = ProjectorProgram::on_network(&home, "0").unwrap();
    let bad = relay::Network {
        delay: Duration::from_millis(100),
        loses_one_in: 20,
        retransmission: Duration::from_millis(400),
    };
    let address = relay::relay(projector.address(), bad).unwrap().to_string();
    pair(&projector, &address, &home, root.path());
    let out = root.path().join("scan");
    let figures = assert_done(&scan(&address, &out, root.path()).output().unwrap());
    // as without the network between: the frames are the same
    for stage in ["background", "object"] {
        let labelled = figures["summary"][stage]["crossings_labelled"].as_u64();
        assert!(labelled > Some(180), "{figures}");
    }
}

#[test]
fn a_disk_that_is_full_in_the_middle_is_told_and_the_scan_goes_on_when_it_is_not() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("scan");
    let projector = ProjectorProgram::headless().unwrap();
    let plain = scan(projector.address(), &out, root.path());
    let mut full = Command::new("strace");
    full.args(["-f", "-qq", "-o", "/dev/null"])
        // in the middle of the background, after the manifest and its notes
        .args([
            "-e",
            "trace=fsync",
            "-e",
            "inject=fsync:error=ENOSPC:when=30+",
        ])
        .arg(plain.get_program())
        .args(plain.get_args())
        .env("XDG_CONFIG_HOME", root.path());
    assert_fails(&full.output().unwrap(), "No space left on device");
    let folder = ScanFolder::open(&out).unwrap();
    assert!(!(folder.is_recorded(Stage::Background) && folder.is_recorded(Stage::Object)));
    let output = scan(projector.address(), &out, root.path())
        .arg("--resume")
        .output();
    assert_done(&output.unwrap());
    let check = Command::new(built_program("acquirer").unwrap())
        .arg("check")
        .arg(&out)
        .output();
    assert!(check.unwrap().status.success());
}

#[test]
fn a_folder_that_cannot_be_written_is_told_with_its_name() {
    let root = tempfile::tempdir().unwrap();
    let projector = ProjectorProgram::headless().unwrap();
    let out = Path::new("/proc/a-scan");
    let output = scan(projector.address(), out, root.path()).output();
    assert_fails(&output.unwrap(), "/proc/a-scan");
}

#[test]
fn without_a_display_both_programs_say_so() {
    for (program, arguments) in [
        (
            "projector",
            &["--windowed", "640x480", "--listen", "127.0.0.1:0"][..],
        ),
        ("acquirer", &["--camera", "sim:cube"]),
    ] {
        let projector = ProjectorProgram::headless().unwrap();
        let mut command = Command::new(built_program(program).unwrap());
        command.args(arguments);
        if program == "acquirer" {
            command.args(["--projector", projector.address()]);
        }
        let output = command
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .unwrap();
        assert_fails(&output, "DISPLAY");
    }
}

/// A computer of its own on this machine, on a cable to it; both go with this value.
struct OtherComputer {
    name: String,
    address: String,
}

impl OtherComputer {
    /// Nothing where the system lets nobody make one, which needs root.
    fn new() -> Option<Self> {
        let id = std::process::id() % 10_000;
        let this = Self {
            name: format!("rig{id}"),
            address: format!("10.231.{}.1", id % 250),
        };
        let (name, address) = (&this.name, &this.address);
        let there = format!("10.231.{}.2", id % 250);
        let made = ip(&["netns", "add", name])
            && ip(&[
                "link", "add", name, "type", "veth", "peer", "name", "eth0", "netns", name,
            ])
            && ip(&["addr", "add", &format!("{address}/24"), "dev", name])
            && ip(&["link", "set", name, "up"])
            && ip(&[
                "-n",
                name,
                "addr",
                "add",
                &format!("{there}/24"),
                "dev",
                "eth0",
            ])
            && ip(&["-n", name, "link", "set", "eth0", "up"]);
        made.then_some(this)
    }

    fn cable(&self, way: &str) {
        assert!(ip(&["link", "set", &self.name, way]));
    }
}

impl Drop for OtherComputer {
    fn drop(&mut self) {
        ip(&["link", "del", &self.name]);
        ip(&["netns", "del", &self.name]);
    }
}

fn ip(arguments: &[&str]) -> bool {
    let status = Command::new("ip")
        .args(arguments)
        .stderr(Stdio::null())
        .status();
    status
        .expect("ip can be started (apt-get install iproute2)")
        .success()
}

#[test]
fn a_controller_whose_network_is_cut_is_noticed_and_may_come_back() {
    let Some(other) = OtherComputer::new() else {
        eprintln!("SKIPPED: no network namespaces here (they need root): no cable was pulled");
        return;
    };
    let root = tempfile::tempdir().unwrap();
    let home = root.path().join("projector");
    let config = root.path().join("projector.toml");
    fs::write(&config, "[control]\non_controller_lost = \"blank\"\n").unwrap();
    let config = config.display().to_string();
    let listen = ["--listen", "0.0.0.0:0", "--config", &config];
    let projector = ProjectorProgram::run(&listen, &home).unwrap();
    let there = format!("{}:{}", other.address, projector.port());
    let here = format!("127.0.0.1:{}", projector.port());
    let [far, near] = [&there, &here].map(|_| python_pairs(&here, &home));
    // the far one shows the grid and stays
    let script = "import sys, time; sys.path.insert(0, sys.argv[1]); import client\n\
                  p = client.Projector(*sys.argv[2:]); p.ask(type='show', view={'kind': 'coded'})\n\
                  print('shown', flush=True); time.sleep(600)";
    let far_client = || {
        let mut child = Command::new("ip")
            .args(["netns", "exec", &other.name, "python3", "-c", script])
            .args([python_dir().to_str().unwrap(), &there])
            .args(&far)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let stdout = child.stdout.as_mut().unwrap();
        std::io::BufRead::read_line(&mut std::io::BufReader::new(stdout), &mut line).unwrap();
        assert_eq!(line, "shown\n");
        child
    };
    let mut first = far_client();
    let blank = || {
        let script = "import sys, json; sys.path.insert(0, sys.argv[1]); import client\n\
                      p = client.Projector(*sys.argv[2:], role='watcher')\n\
                      print(json.dumps(p.ask(type='state')['state']['blank']))";
        let output = Command::new("python3")
            .args(["-c", script, python_dir().to_str().unwrap(), &here])
            .args(&near)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", message(&output));
        output.stdout.starts_with(b"true")
    };
    assert!(!blank());
    other.cable("down");
    let deadline = Instant::now() + PATIENCE;
    while !blank() {
        assert!(
            Instant::now() < deadline,
            "the lost controller was not noticed"
        );
        thread::sleep(Duration::from_millis(500));
    }
    other.cable("up");
    let mut second = far_client();
    assert!(!blank());
    for child in [&mut first, &mut second] {
        child.kill().unwrap();
        child.wait().unwrap();
    }
}

fn python_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("python_client")
}

/// Pairs the client in Python; gives the fingerprint and the token it has then.
fn python_pairs(address: &str, home: &Path) -> [String; 2] {
    let code = Command::new(built_program("projector").unwrap())
        .arg("pair")
        .env("XDG_CONFIG_HOME", home)
        .output()
        .unwrap();
    let code = String::from_utf8(code.stdout).unwrap();
    let token = Command::new("python3")
        .arg(python_dir().join("client.py"))
        .args(["pair", code.trim(), address])
        .output()
        .unwrap();
    assert!(token.status.success(), "{}", message(&token));
    let fingerprint = code.split('/').nth(2).unwrap().to_lowercase();
    let token = String::from_utf8(token.stdout).unwrap();
    [fingerprint, token.trim().to_owned()]
}

/// Programs that count by the monotonic clock are not touched by a clock that is set. The wall clock is read in one place,
/// for the ten minutes of a pairing code.
#[test]
fn no_time_is_taken_from_a_clock_that_can_jump() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut readers = Vec::new();
    for crate_dir in [
        "shared/src",
        "projector/src",
        "acquirer/src",
        "acquirer/pipeline/src",
    ] {
        look_for_wall_clock(&root.join(crate_dir), &mut readers);
    }
    let names: Vec<_> = readers
        .iter()
        .map(|path| path.strip_prefix(&root).unwrap())
        .collect();
    assert_eq!(names, [Path::new("projector/src/access/mod.rs")]);
}

fn look_for_wall_clock(dir: &Path, readers: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            look_for_wall_clock(&path, readers);
        } else if fs::read_to_string(&path).is_ok_and(|text| text.contains("SystemTime")) {
            readers.push(path);
        }
    }
}
