//! The network is bad, or is cut; the projector is found on it.

use std::{
    fs,
    net::{TcpListener, TcpStream},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::atomic::{AtomicU32, Ordering},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use rig_tests::{
    ProjectorProgram, built_program,
    guest::{Device, Guest},
};
use serde_json::Value;

use super::{PATIENCE, assert_done, assert_fails, message, pair, scan, until};

/// A bad network to a projector on this machine: a guest stands between, whose kernel delays and loses packets.
struct BadNetwork {
    /// The projector's address beyond it.
    address: String,
    /// Stays up until this is closed.
    held: TcpStream,
    guest: JoinHandle<anyhow::Result<String>>,
}

impl BadNetwork {
    /// All that goes either way comes so much later, and of its packets so many are lost, in the words of tc.
    fn to(projector: &ProjectorProgram, delay: &str, loss: &str) -> Self {
        let up = TcpListener::bind("127.0.0.1:0").unwrap();
        up.set_nonblocking(true).unwrap();
        let (up_at, free) = (port(&up), TcpListener::bind("127.0.0.1:0").unwrap());
        let here = port(&free);
        drop(free);
        let script = format!(
            "bad-network {delay} {loss}; nc -ll -p 5000 -e nc 10.0.2.2 {} & nc 10.0.2.2 {up_at} </dev/null; \
             /bin/tc -s qdisc show dev eth0",
            projector.port()
        );
        let guest = Guest::with(Device::None)
            .program("/usr/sbin/tc")
            .forward(here, 5000);
        let guest = thread::spawn(move || guest.run(&script));
        let held = until("the guest does not come up", || {
            if guest.is_finished() {
                return Some(None);
            }
            up.accept().ok().map(|(held, _)| Some(held))
        });
        let Some(held) = held else {
            panic!("the guest has gone: {:?}", guest.join());
        };
        Self {
            address: format!("127.0.0.1:{here}"),
            held,
            guest,
        }
    }

    /// Takes it down; gives how many packets it has lost.
    fn end(self) -> u32 {
        drop(self.held);
        let said = self.guest.join().unwrap().unwrap();
        let lost = said.split("(dropped ").nth(1).unwrap();
        lost.split(',').next().unwrap().parse().unwrap()
    }
}

fn port(listener: &TcpListener) -> u16 {
    listener.local_addr().unwrap().port()
}

#[test]
fn a_scan_over_a_network_of_200_ms_and_5_percent_loss_is_as_good() {
    let root = tempfile::tempdir().unwrap();
    let home = root.path().join("projector");
    let projector = ProjectorProgram::on_network(&home, "0").unwrap();
    let network = BadNetwork::to(&projector, "200ms", "5%");
    pair(&projector, &network.address, &home, root.path());
    let out = root.path().join("scan");
    let scan = scan(&network.address, &out, root.path()).output().unwrap();
    let figures = assert_done(&scan);
    // as without the network between: the frames are the same
    for stage in ["background", "object"] {
        let labelled = figures["summary"][stage]["crossings_labelled"].as_u64();
        assert!(labelled > Some(180), "{figures}");
    }
    let lost = network.end();
    assert!(lost > 0, "no packet was lost: the network was not bad");
    println!("{lost} packets were lost");
}

/// A computer of its own on this machine, on a cable to it; both go with this value.
struct OtherComputer {
    name: String,
    address: String,
}

impl OtherComputer {
    /// Nothing where the system lets nobody make one, which needs root.
    fn new() -> Option<Self> {
        // tests run side by side, in this program and in others
        static MADE: AtomicU32 = AtomicU32::new(0);
        let (id, number) = (
            std::process::id() % 10_000,
            MADE.fetch_add(1, Ordering::Relaxed),
        );
        let net = format!("10.{}.{}", 231 + number, id % 250);
        let this = Self {
            name: format!("rig{id}-{number}"),
            address: format!("{net}.1"),
        };
        let (name, address) = (&this.name, &this.address);
        let there = format!("{net}.2");
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
            && ip(&["-n", name, "link", "set", "eth0", "up"])
            && ip(&["-n", name, "link", "set", "lo", "up"]);
        made.then_some(this)
    }

    fn cable(&self, way: &str) {
        assert!(ip(&["link", "set", &self.name, way]));
    }

    /// A command as it is run there.
    fn runs(&self, command: &Command) -> Command {
        let mut there = Command::new("ip");
        there
            .args(["netns", "exec", &self.name])
            .arg(command.get_program())
            .args(command.get_args());
        let set = command.get_envs();
        there.envs(set.filter_map(|(name, value)| Some((name, value?))));
        there
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

#[test]
fn a_paired_projector_is_found_on_the_cable_by_itself() {
    let Some(other) = OtherComputer::new() else {
        eprintln!(
            "SKIPPED: no network namespaces here (they need root): no projector was looked for"
        );
        return;
    };
    let root = tempfile::tempdir().unwrap();
    let home = root.path().join("projector");
    let projector = ProjectorProgram::on_network(&home, "0").unwrap();
    let address = format!("{}:{}", other.address, projector.port());
    let mut find = Command::new(built_program("acquirer").unwrap());
    find.args(["find", "--json"])
        .env("XDG_CONFIG_HOME", root.path());
    let mut find = other.runs(&find);
    // others may be there, of other tests
    let mut found = || {
        until("the projector does not announce itself", || {
            let output = find.output().unwrap();
            let list: Value = serde_json::from_slice(&output.stdout).ok()?;
            let mut list = list["projectors"].as_array().unwrap().clone().into_iter();
            list.find(|found| found["address"] == address.as_str())
        })
    };
    assert_eq!(found()["paired"], false);
    let automatic = |out: &str| {
        let out = root.path().join(out);
        let scan = scan("auto", &out, root.path());
        other.runs(&scan).output().unwrap()
    };
    assert_fails(&automatic("unpaired"), &format!("at {address}"));

    // paired by an address that it has for itself alone
    pair(&projector, projector.address(), &home, root.path());
    let named = found();
    assert_eq!(named["paired"], true);
    assert_eq!(named["version"], env!("CARGO_PKG_VERSION"));
    assert_done(&automatic("scan"));

    other.cable("down");
    let output = find.output().unwrap();
    assert_fails(&output, "no projector announces itself");
    assert_fails(&automatic("away"), "no projector announces itself");
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
