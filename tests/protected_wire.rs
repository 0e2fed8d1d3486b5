//! A projector on a network: TLS, pairing by code, revocation, and a client that nobody here wrote with our crates.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    fs,
    io::{BufRead, BufReader, Write},
    net::TcpStream,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::{Command, Output},
    thread,
    time::{Duration, Instant},
};

use acquirer::cli::code_in;
use image::{RgbImage, imageops};
use rig_tests::{ProjectorProgram, built_program};
use serde_json::Value;
use shared::{
    pattern::{Pattern, RasterSize},
    protocol::PairingCode,
};

/// Far longer than anything takes; a test that waits this long has failed.
const PATIENCE: Duration = Duration::from_secs(60);

/// A projector on all networks, and the computer of a client.
struct Bench {
    root: tempfile::TempDir,
    projector: ProjectorProgram,
}

impl Bench {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let projector = ProjectorProgram::on_network(&root.path().join("there"), "0").unwrap();
        Self { root, projector }
    }

    /// The projector program ends, and that of a computer begins on the same port.
    fn restarted(self, computer: &str) -> Self {
        let Self { root, projector } = self;
        let port = projector.port().to_owned();
        drop(projector);
        let home = root.path().join(computer);
        let projector = ProjectorProgram::on_network(&home, &port).unwrap();
        Self { root, projector }
    }

    fn home(&self, computer: &str) -> PathBuf {
        self.root.path().join(computer)
    }

    /// Runs a program with the secrets of one computer.
    fn run(&self, computer: &str, program: &str, arguments: &[&str]) -> Output {
        Command::new(built_program(program).unwrap())
            .args(arguments)
            .env("XDG_CONFIG_HOME", self.home(computer))
            .current_dir(self.root.path())
            .output()
            .unwrap()
    }

    /// A new pairing code.
    fn code(&self) -> String {
        let output = self.run("there", "projector", &["pair"]);
        assert!(output.status.success(), "{}", message(&output));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    fn pair(&self, computer: &str, code: &str) -> Output {
        let address = self.projector.address();
        self.run(
            computer,
            "acquirer",
            &["pair", code, "--projector", address],
        )
    }

    /// Something short that needs the projector's consent: a line of live reading.
    fn look(&self, computer: &str) -> Output {
        let recorded = Path::new(env!("CARGO_MANIFEST_DIR")).join("recorded/wall-cube");
        let camera = format!("replay:{}", recorded.display());
        let address = self.projector.address();
        let arguments = [
            "live",
            "--frames",
            "1",
            "--take-over",
            "--projector",
            address,
        ];
        self.run(
            computer,
            "acquirer",
            &[&arguments[..], &["--camera", &camera]].concat(),
        )
    }
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[track_caller]
fn assert_done(output: &Output) {
    assert!(output.status.success(), "{}", message(output));
}

#[track_caller]
fn assert_refused(output: &Output, why: &str) {
    assert_eq!(output.status.code(), Some(1), "{}", message(output));
    assert!(message(output).contains(why), "{}", message(output));
}

#[test]
fn a_client_is_let_in_once_paired_and_not_any_more_once_revoked() {
    let bench = Bench::new();
    assert_refused(&bench.look("here"), "acquirer pair CODE");
    let code = bench.code();
    assert_done(&bench.pair("here", &code));
    assert_done(&bench.look("here"));
    // the code was good once
    assert_refused(&bench.pair("elsewhere", &code), "was used");
    assert_refused(&bench.look("elsewhere"), "acquirer pair CODE");
    // remembered over a restart of the projector
    let bench = bench.restarted("there");
    assert_done(&bench.look("here"));
    let listed = bench.run("there", "projector", &["pairings", "--json"]);
    let listed: Value = serde_json::from_slice(&listed.stdout).unwrap();
    let name = listed["pairings"][0]["name"].as_str().unwrap().to_owned();
    assert!(name.starts_with("acquirer on "), "{name}");
    assert_done(&bench.run("there", "projector", &["revoke", &name]));
    assert_refused(&bench.look("here"), "revoked");
}

#[test]
fn a_connection_ends_when_its_pairing_is_revoked() {
    let bench = Bench::new();
    let (token, fingerprint) = python_pairs(&bench);
    // a client that stays: it reads lines until there are none
    let script = "import sys; sys.path.insert(0, sys.argv[1]); import client\n\
                  p = client.Projector(*sys.argv[2:]); print('in', flush=True)\n\
                  while True: p.receive()";
    let mut stays = Command::new("python3")
        .args(["-c", script, python_dir().to_str().unwrap()])
        .args([bench.projector.address(), &fingerprint, &token])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = String::new();
    let mut stdout = BufReader::new(stays.stdout.take().unwrap());
    stdout.read_line(&mut first).unwrap();
    assert_eq!(first, "in\n");
    assert_done(&bench.run("there", "projector", &["revoke", "--all"]));
    let output = stays.wait_with_output().unwrap();
    assert_refused(&output, "revoked");
}

#[test]
fn a_projector_with_another_certificate_is_told_nothing() {
    let bench = Bench::new();
    assert_done(&bench.pair("here", &bench.code()));
    let bench = bench.restarted("stranger");
    assert_refused(&bench.look("here"), "certificate is another one");
}

#[test]
fn secrets_are_readable_by_their_owner_alone() {
    let bench = Bench::new();
    assert_done(&bench.pair("here", &bench.code()));
    let mut seen = 0;
    for (computer, program) in [("there", "projector"), ("here", "acquirer")] {
        let dir = bench.home(computer).join("colour-grid").join(program);
        assert_eq!(
            fs::metadata(&dir).unwrap().permissions().mode() & 0o777,
            0o700
        );
        for file in fs::read_dir(&dir).unwrap() {
            let mode = file.unwrap().metadata().unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
            seen += 1;
        }
    }
    assert!(seen >= 5, "{seen} files");
}

#[test]
fn who_does_not_speak_tls_is_told_what_to_do() {
    let bench = Bench::new();
    let mut plain = TcpStream::connect(bench.projector.address()).unwrap();
    plain.set_read_timeout(Some(PATIENCE)).unwrap();
    plain.write_all(b"{\"type\":\"hello\"}\n").unwrap();
    let mut line = String::new();
    BufReader::new(plain).read_line(&mut line).unwrap();
    let error: Value = serde_json::from_str(&line).unwrap();
    assert_eq!(error["code"], "token");
    assert!(
        error["message"]
            .as_str()
            .unwrap()
            .contains("projector pair")
    );
}

#[test]
fn the_code_on_the_wall_is_read_through_the_camera() {
    let bench = Bench::new();
    let text = bench.code();
    let size = RasterSize {
        width: 1024,
        height: 768,
    };
    let wall = Pattern::PairingCode { text: text.clone() }.raster(size);
    let wall = RgbImage::from_raw(size.width, size.height, wall.into_bytes()).unwrap();
    // as a camera sees it: smaller, out of focus, not black and white
    let seen = imageops::blur(
        &imageops::resize(&wall, 640, 480, imageops::FilterType::Triangle),
        1.0,
    );
    let mut frame = RgbImage::from_pixel(800, 600, image::Rgb([40, 30, 25]));
    imageops::overlay(&mut frame, &seen, 90, 70);
    frame.pixels_mut().for_each(|pixel| {
        pixel.0 = pixel.0.map(|value| 30 + value / 2);
    });
    assert_eq!(code_in(&frame), Some(text.parse::<PairingCode>().unwrap()));
    let recording = bench.root.path().join("wall");
    fs::create_dir(&recording).unwrap();
    frame.save(recording.join("0.png")).unwrap();
    let camera = format!("replay:{}", recording.display());
    let arguments = [
        "pair",
        "--camera",
        &camera,
        "--projector",
        bench.projector.address(),
    ];
    assert_done(&bench.run("here", "acquirer", &arguments));
    assert_done(&bench.look("here"));
}

fn python_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("python_client")
}

fn python(arguments: &[&str]) -> Output {
    let script = python_dir().join("client.py");
    let output = Command::new("python3").arg(script).args(arguments).output();
    output.unwrap()
}

/// Pairs the client in Python; gives its token and the projector's fingerprint.
fn python_pairs(bench: &Bench) -> (String, String) {
    let code = bench.code();
    let output = python(&["pair", &code, bench.projector.address()]);
    assert_done(&output);
    let token = String::from_utf8(output.stdout).unwrap().trim().to_owned();
    let code: PairingCode = code.parse().unwrap();
    (token, code.fingerprint.to_string())
}

#[test]
fn a_client_in_pythons_standard_library_pairs_shows_a_grid_and_reads_the_state() {
    let bench = Bench::new();
    let (token, fingerprint) = python_pairs(&bench);
    let address = bench.projector.address();
    let output = python(&["grid", address, &fingerprint, &token]);
    assert_done(&output);
    let state: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(state["shown"]["pattern"]["rows"], 31);
    assert_eq!(state["controller"], "python");

    let wrong = token.chars().rev().collect::<String>();
    assert_refused(&python(&["grid", address, &fingerprint, &wrong]), "token");
    assert_refused(
        &python(&["grid", address, &fingerprint, "no token"]),
        "token",
    );
    let zeros = "0".repeat(64);
    assert_refused(&python(&["grid", address, &zeros, &token]), "certificate");
}

#[test]
fn a_code_is_shown_on_the_wall_until_it_is_used() {
    let bench = Bench::new();
    let (token, fingerprint) = python_pairs(&bench);
    let code = bench.code();
    let script = "import sys, json; sys.path.insert(0, sys.argv[1]); import client\n\
                  p = client.Projector(*sys.argv[2:]); print(json.dumps(p.ask(type='state')))";
    let shown = || {
        let output = Command::new("python3")
            .args(["-c", script, python_dir().to_str().unwrap()])
            .args([bench.projector.address(), &fingerprint, &token])
            .output()
            .unwrap();
        assert_done(&output);
        let state: Value = serde_json::from_slice(&output.stdout).unwrap();
        state["state"]["shown"]["pattern"].clone()
    };
    let wait_for = |wanted: &dyn Fn(&Value) -> bool| {
        let deadline = Instant::now() + PATIENCE;
        while !wanted(&shown()) {
            assert!(Instant::now() < deadline, "{}", shown());
            thread::sleep(Duration::from_millis(200));
        }
    };
    wait_for(&|pattern| pattern["text"] == code.as_str());
    assert_done(&bench.pair("here", &code));
    wait_for(&|pattern| pattern["kind"] == "identify");
}
