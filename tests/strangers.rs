//! Strangers who knock without end keep nobody out who is paired, and take nothing from who is in.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    collections::VecDeque,
    fs,
    net::{IpAddr, Ipv4Addr, SocketAddr},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::atomic::{AtomicBool, AtomicUsize, Ordering},
    thread,
    time::Duration,
};

use rig_tests::{ProjectorProgram, built_program};
use socket2::{Domain, Socket, Type};

/// Where the strangers come from; the others come from 127.0.0.1.
const STRANGERS: IpAddr = IpAddr::V4(Ipv4Addr::new(127, 0, 0, 2));
/// Connections that they hold, of those that they are let.
const HELD: usize = 200;

/// Says hello, asks for the state, and prints a line; then again for each line that it is given.
const CLIENT: &str = "import sys; sys.path.insert(0, sys.argv[1]); import client\n\
                      p = client.Projector(*sys.argv[3:], role=sys.argv[2])\n\
                      for line in sys.stdin:\n    print(p.ask(type='state')['type'], flush=True)";

fn python_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("python_client")
}

/// A client that is paired.
struct Paired {
    child: Child,
}

impl Paired {
    fn begin(address: &str, [fingerprint, token]: &[String; 2], role: &str) -> Self {
        let child = Command::new("python3")
            .args(["-c", CLIENT, &python_dir().display().to_string(), role])
            .args([address, fingerprint, token])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        Self { child }
    }

    /// Asks once more, or for the first time.
    #[track_caller]
    fn assert_served(&mut self) {
        use std::io::{BufRead, BufReader, Write};
        self.child.stdin.as_mut().unwrap().write_all(b"\n").unwrap();
        let mut line = String::new();
        let stdout = self.child.stdout.as_mut().unwrap();
        BufReader::new(stdout).read_line(&mut line).unwrap();
        assert_eq!(line, "state\n");
    }
}

impl Drop for Paired {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

/// Pairs the client in Python; gives the fingerprint and the token it has then.
fn pair(address: &str, home: &Path) -> [String; 2] {
    let told = |command: &mut Command| {
        let output = command.output().unwrap();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    let projector = built_program("projector").unwrap();
    let code = told(
        Command::new(projector)
            .arg("pair")
            .env("XDG_CONFIG_HOME", home),
    );
    let client = python_dir().join("client.py");
    let token = told(
        Command::new("python3")
            .arg(client)
            .args(["pair", &code, address]),
    );
    let fingerprint = code.split('/').nth(2).unwrap().to_lowercase();
    [fingerprint, token]
}

/// Knocks again and again: silent ones, half a TLS record, and what is no TLS at all.
fn knock(projector: SocketAddr, knocked: &AtomicUsize, enough: &AtomicBool) {
    let mut held = VecDeque::new();
    while !enough.load(Ordering::Relaxed) {
        let socket = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
        socket.bind(&SocketAddr::new(STRANGERS, 0).into()).unwrap();
        if socket.connect(&projector.into()).is_ok() {
            let number = knocked.fetch_add(1, Ordering::Relaxed);
            let says = [&b""[..], &[0x16, 3, 1, 2], b"GET / HTTP/1.1\r\n\r\n"][number % 3];
            // it may be cut already
            socket.send(says).ok();
            held.push_back(socket);
        }
        if held.len() > HELD {
            held.pop_front();
        }
        thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn who_is_paired_comes_in_at_once_and_stays_while_strangers_knock() {
    let root = tempfile::tempdir().unwrap();
    let config = root.path().join("projector.toml");
    fs::write(&config, "[control]\nmax_connections = 4\n").unwrap();
    let config = config.display().to_string();
    let listen = ["--listen", "0.0.0.0:0", "--config", &config];
    let projector = ProjectorProgram::run(&listen, root.path()).unwrap();
    let here = format!("127.0.0.1:{}", projector.port());
    let secrets = pair(&here, root.path());
    let mut inside = Paired::begin(&here, &secrets, "controller");
    inside.assert_served();
    let before = projector.usage().unwrap();

    let (knocked, enough) = (AtomicUsize::new(0), AtomicBool::new(false));
    let address: SocketAddr = here.parse().unwrap();
    thread::scope(|scope| {
        scope.spawn(|| knock(address, &knocked, &enough));
        while knocked.load(Ordering::Relaxed) < HELD {
            thread::yield_now();
        }
        let mut descriptors = 0;
        for _ in 0..5 {
            Paired::begin(&here, &secrets, "watcher").assert_served();
            inside.assert_served();
            descriptors = descriptors.max(projector.usage().unwrap().descriptors);
        }
        enough.store(true, Ordering::Relaxed);
        println!(
            "{} knocked, {descriptors} descriptors at most",
            knocked.load(Ordering::Relaxed)
        );
        assert!(
            descriptors < before.descriptors + 32,
            "{descriptors}, {before:?} before"
        );
    });
}
