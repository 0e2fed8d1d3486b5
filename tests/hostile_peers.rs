//! Peers that are broken or mean no good, against the real projector: its picture stands, its controller is served, and
//! it takes a bounded part of the machine.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    fs,
    io::{BufRead, BufReader, ErrorKind, Read, Write},
    net::{Shutdown, TcpStream},
    path::Path,
    thread,
    time::{Duration, Instant},
};

use acquirer::projector_link::{LinkSettings, ProjectorLink};
use rig_tests::{ProjectorProgram, Usage};
use serde_json::{Value, json};
use shared::protocol::{MAX_LINE_BYTES, Role, View};

/// Far longer than anything takes; a test that waits this long has failed.
const PATIENCE: Duration = Duration::from_secs(60);
/// Memory that the projector may take more than before, whatever its peers do, in KiB.
const MORE_MEMORY_KIB: u64 = 32 * 1024;

/// A projector with a controller and a picture that must stand.
struct Stand {
    projector: ProjectorProgram,
    controller: ProjectorLink,
    serial: u64,
    before: Usage,
}

impl Stand {
    fn new() -> Self {
        let projector = ProjectorProgram::headless().unwrap();
        let settings = LinkSettings::new(projector.address(), "controller", Role::Controller);
        let controller = ProjectorLink::connect(&settings).unwrap();
        let serial = controller.show(View::Coded).unwrap().shown.serial;
        let before = projector.usage().unwrap();
        Self {
            projector,
            controller,
            serial,
            before,
        }
    }

    /// The picture stands, the controller is answered, and nothing has grown without bounds.
    #[track_caller]
    fn assert_stands(&self, most_descriptors: usize) {
        let state = self.controller.state().unwrap();
        assert_eq!(
            (state.shown.serial, &state.view),
            (self.serial, &View::Coded)
        );
        let now = self.projector.usage().unwrap();
        assert!(
            now.memory_kib < self.before.memory_kib + MORE_MEMORY_KIB,
            "{:?} then {now:?}",
            self.before
        );
        assert_eq!(now.threads, self.before.threads);
        assert!(
            now.descriptors <= self.before.descriptors + most_descriptors,
            "{:?} then {now:?}",
            self.before
        );
    }

    /// As before all of it, once the projector has noticed the ends of its connections.
    #[track_caller]
    fn assert_recovers(&self) {
        // connections are accepted in the order they came: with this one gone, nobody waits in the system's queue
        let mut last = self.stranger();
        last.shutdown(Shutdown::Write).ok();
        drain(&mut last);
        let deadline = Instant::now() + PATIENCE;
        while self.projector.usage().unwrap().descriptors > self.before.descriptors {
            assert!(Instant::now() < deadline, "connections are left");
            thread::sleep(Duration::from_millis(50));
        }
        self.assert_stands(0);
        let settings = LinkSettings::new(self.projector.address(), "guest", Role::Watcher);
        ProjectorLink::connect(&settings).unwrap();
    }

    fn stranger(&self) -> TcpStream {
        connect(self.projector.address())
    }

    /// Somebody who is let in, and what is said to him.
    fn guest(&self) -> Guest {
        self.somebody(json!({"role": "watcher"}))
    }

    fn somebody(&self, mut hello: Value) -> Guest {
        let stream = self.stranger();
        let lines = BufReader::new(stream.try_clone().unwrap());
        let mut guest = Guest { stream, lines };
        hello["type"] = "hello".into();
        hello["version"] = 1.into();
        hello["name"] = "guest".into();
        guest.say(hello.to_string().as_bytes());
        assert_eq!(guest.hear()["type"], "welcome");
        guest
    }
}

struct Guest {
    stream: TcpStream,
    lines: BufReader<TcpStream>,
}

impl Guest {
    fn say(&mut self, line: &[u8]) {
        self.stream.write_all(line).unwrap();
        self.stream.write_all(b"\n").unwrap();
    }

    /// The next reply; notices are passed over.
    fn hear(&mut self) -> Value {
        loop {
            let mut line = String::new();
            assert!(self.lines.read_line(&mut line).unwrap() > 0, "cut");
            let message: Value = serde_json::from_str(&line).unwrap();
            if !["shown", "state_changed", "controller"]
                .contains(&message["type"].as_str().unwrap())
            {
                return message;
            }
        }
    }
}

fn connect(address: &str) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_write_timeout(Some(PATIENCE)).unwrap();
    stream
}

/// Reads to the end, however it comes.
fn drain(stream: &mut TcpStream) -> usize {
    let (mut total, mut chunk) = (0, [0; 4096]);
    loop {
        match stream.read(&mut chunk) {
            Ok(0) => return total,
            Ok(count) => total += count,
            Err(error) if error.kind() == ErrorKind::ConnectionReset => return total,
            Err(error) => panic!("the connection is left open: {error}"),
        }
    }
}

#[test]
fn a_thousand_connections_take_no_more_than_the_places_there_are() {
    let stand = Stand::new();
    let mut crowd = Vec::new();
    for _ in 0..1000 {
        crowd.push(stand.stranger());
    }
    // as many wait to be let in as may, and one who comes while another leaves
    stand.assert_stands(17);
    drop(crowd);
    stand.assert_recovers();
}

#[test]
fn who_says_nothing_or_drips_a_hello_is_cut_in_time() {
    let stand = Stand::new();
    let begun = Instant::now();
    let mut silent = stand.stranger();
    let mut dripping = stand.stranger();
    let drips = thread::spawn(move || {
        // a byte at a time, for ever, if it were let
        let hello = br#"{"type":"hello","version":1,"role":"controller","take_over":true,"name":""#;
        let bytes = hello.iter().copied().chain(std::iter::repeat(b'x'));
        for byte in bytes {
            if dripping.write_all(&[byte]).is_err() || begun.elapsed() > PATIENCE {
                break;
            }
            thread::sleep(Duration::from_millis(200));
        }
        begun.elapsed()
    });
    assert!(drain(&mut silent) > 0, "it is told why");
    assert!(drips.join().unwrap() < PATIENCE, "the drip was let go on");
    stand.assert_recovers();
}

#[test]
fn half_open_connections_free_their_places() {
    let stand = Stand::new();
    let mut half_open: Vec<_> = (0..7).map(|_| stand.stranger()).collect();
    for stream in &mut half_open {
        stream.write_all(b"{\"type\":\"hel").unwrap();
    }
    for stream in &mut half_open {
        drain(stream);
    }
    stand.assert_recovers();
}

#[test]
fn lines_that_are_wrong_in_any_way_are_refused_one_by_one() {
    let stand = Stand::new();
    // as the controller, who may do everything that is not wrong
    let mut guest = stand.somebody(json!({"role": "controller", "take_over": true}));
    let deep = format!("{}1{}", "[".repeat(30_000), "]".repeat(30_000));
    let deep_keys = format!("{}1{}", r#"{"type":"#.repeat(5000), "}".repeat(5000));
    let grid = |change: &str| {
        format!(
            r##"{{"id":1,"type":"show","view":{{"kind":"grid","rows":15,"columns":15,"row_width_px":6,"column_width_px":6,"colours":["#ff0000"],{change}}}}}"##
        )
    };
    let lines: Vec<Vec<u8>> = [
        "x",
        "{",
        "[]",
        "null",
        "1e400",
        "\"hello\"",
        "{}",
        "\u{feff}{}",
        "{\"type\":5}",
        "{\"type\":\"sing\"}",
        "{\"type\":\"ping\"}",
        "{\"type\":\"ping\",\"id\":-1}",
        "{\"type\":\"ping\",\"id\":1e30}",
        "{\"type\":\"ping\",\"id\":\"1\"}",
        "{\"type\":\"ping\",\"id\":18446744073709551616}",
        "{\"type\":\"show\",\"id\":1}",
        "{\"type\":\"show\",\"id\":1,\"view\":7}",
        "{\"type\":\"show\",\"id\":1,\"view\":{\"kind\":[]}}",
        "{\"type\":\"set_lines\",\"id\":1,\"rows\":1000000000,\"columns\":15}",
        "{\"type\":\"set_lines\",\"id\":1,\"rows\":1e9,\"columns\":15}",
        "{\"type\":\"set_widths\",\"id\":1,\"row_width_px\":60000,\"column_width_px\":60000}",
        "{\"type\":\"set_widths\",\"id\":1,\"row_width_px\":4294967296,\"column_width_px\":1}",
        "{\"type\":\"set_colours\",\"id\":1,\"colours\":[\"#xyzxyz\"],\"unary\":\"\"}",
        "{\"type\":\"identify\",\"id\":1,\"seconds\":4294967295}",
        "{\"type\":\"show_sequence\",\"id\":1,\"steps\":[]}",
        "{\"type\":\"hello\",\"version\":1,\"role\":\"controller\",\"name\":\"again\"}",
        "{\"type\":\"blank\",\"id\":1,\"on\":\"yes\"}",
        "\u{0}\u{0}\u{0}",
        &deep,
        &deep_keys,
        &grid("\"rows\":1000000000"),
        &grid("\"row_width_px\":60000"),
        &grid("\"row_symbols\":[99999],\"column_symbols\":[0]"),
        &grid("\"row_symbols\":[],\"column_symbols\":[]"),
    ]
    .into_iter()
    .map(|line| line.as_bytes().to_vec())
    .chain([
        b"\xff\xfe\xfd".to_vec(),
        b"{\"type\":\"\xc3\x28\"}".to_vec(),
        vec![b'x'; MAX_LINE_BYTES + 1],
        [
            b"{\"id\":1,\"type\":\"".as_slice(),
            &vec![b'y'; MAX_LINE_BYTES],
        ]
        .concat(),
    ])
    .collect();
    for line in &lines {
        guest.say(line);
        let reply = guest.hear();
        let shown = String::from_utf8_lossy(&line[..line.len().min(120)]);
        assert_eq!(reply["type"], "error", "{shown}: {reply}");
        assert!(reply.to_string().len() < 2000, "a long echo of {shown}");
    }
    stand.assert_stands(1);
    println!("{} wrong lines refused", lines.len());
}

#[test]
fn a_watcher_changes_nothing_whatever_it_asks_for() {
    let stand = Stand::new();
    let mut guest = stand.guest();
    for request in [
        json!({"type": "show", "view": {"kind": "white"}}),
        json!({"type": "show_sequence", "steps": [{"view": {"kind": "white"}, "hold_ms": 10}]}),
        json!({"type": "set_colours", "colours": ["#000001", "#000002", "#000003", "#000004"], "unary": "#000005"}),
        json!({"type": "set_widths", "row_width_px": 1, "column_width_px": 1}),
        json!({"type": "set_lines", "rows": 31, "columns": 31}),
        json!({"type": "identify", "seconds": 5}),
        json!({"type": "blank", "on": true}),
        json!({"type": "report_selection", "selection": {"colours": [], "unary": "#ffffff", "score": 1.0,
               "candidates": [], "reason": "mine"}}),
    ] {
        let mut request = request;
        request["id"] = 1.into();
        guest.say(request.to_string().as_bytes());
        let reply = guest.hear();
        assert_eq!(reply["code"], "not_controller", "{request}: {reply}");
    }
    stand.assert_stands(1);
}

#[test]
fn floods_are_bounded_and_delay_nobody_for_long() {
    let stand = Stand::new();
    // one endless line, another that asks and never reads, and one that connects and goes
    let mut endless = stand.guest().stream;
    let endless = thread::spawn(move || {
        let piece = vec![b'z'; 1 << 16];
        (0..1024)
            .take_while(|_| endless.write_all(&piece).is_ok())
            .count()
    });
    let mut greedy = stand.guest().stream;
    let greedy = thread::spawn(move || {
        greedy
            .set_write_timeout(Some(Duration::from_secs(10)))
            .unwrap();
        let pings = "{\"id\":1,\"type\":\"state\"}\n".repeat(1000);
        (0..2000)
            .take_while(|_| greedy.write_all(pings.as_bytes()).is_ok())
            .count()
    });
    let address = stand.projector.address().to_owned();
    let restless = thread::spawn(move || {
        (0..500)
            .filter(|_| TcpStream::connect(&address).is_ok())
            .count()
    });
    let mut slowest = Duration::ZERO;
    while !(endless.is_finished() && greedy.is_finished() && restless.is_finished()) {
        slowest = slowest.max(stand.controller.ping().unwrap().round_trip);
        thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(
        endless.join().unwrap(),
        1024,
        "64 MiB of one line were skipped"
    );
    assert!(greedy.join().unwrap() < 2000, "who does not read is cut");
    assert!(restless.join().unwrap() > 0);
    stand.assert_recovers();
    println!("slowest reply to the controller meanwhile: {slowest:?}");
}

#[test]
fn a_protected_port_stands_what_is_no_tls_and_what_stops_half_way() {
    let home = tempfile::tempdir().unwrap();
    let projector = ProjectorProgram::on_network(home.path(), "0").unwrap();
    let before = projector.usage().unwrap();
    let record = |length: u16, content: &[u8]| {
        let [high, low] = length.to_be_bytes();
        [&[0x16, 3, 1, high, low][..], content].concat()
    };
    let openings = [
        vec![],
        b"GET / HTTP/1.1\r\n\r\n".to_vec(),
        vec![0; 4096],
        vec![0xff; 4096],
        record(0xffff, &[1; 4096]),
        record(
            16,
            &[1, 0xff, 0xff, 0xff, 3, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
        ),
        record(512, b"\x01\x00"),
        vec![0x16],
    ];
    for round in 0..4 {
        let mut streams: Vec<_> = openings
            .iter()
            .map(|bytes| {
                let mut stream = connect(projector.address());
                // who was refused may have been cut already
                stream.write_all(bytes).ok();
                stream
            })
            .collect();
        if round == 3 {
            streams.iter_mut().for_each(|stream| {
                drain(stream);
            });
        }
    }
    let deadline = Instant::now() + PATIENCE;
    while projector.usage().unwrap().descriptors > before.descriptors {
        assert!(Instant::now() < deadline, "connections are left");
        thread::sleep(Duration::from_millis(50));
    }
    let after = projector.usage().unwrap();
    assert!(after.memory_kib < before.memory_kib + MORE_MEMORY_KIB);
    assert_eq!(after.threads, before.threads);
    assert!(
        fs::read_dir(home.path().join("colour-grid/projector"))
            .unwrap()
            .count()
            >= 3
    );
    assert!(
        Path::new("/proc")
            .join(projector.process().to_string())
            .exists()
    );
}
