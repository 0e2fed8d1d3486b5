//! The network is bad, or is cut.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use rig_tests::{ProjectorProgram, built_program, relay};

use super::{PATIENCE, assert_done, message, pair, scan};

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
