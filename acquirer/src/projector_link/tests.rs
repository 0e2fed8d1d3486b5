//! The link against a scripted peer on a real socket: half lines, garbage, refusals, and peers that
//! vanish.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use shared::protocol::{ErrorCode, Role, View};

use super::{LinkError, LinkSettings, Notice, ProjectorLink};

const STATE: &str = r##"{"screen":{"kind":"headless","name":"headless","raster":{"width":640,"height":480}},"grid":{"rows":15,"columns":15,"row_width_px":6,"column_width_px":6,"colours":["#ff0000","#ffff00","#ff00ff","#00ff00"],"unary":"#ffffff"},"view":{"kind":"black"},"blank":false,"shown":{"serial":1,"pattern":{"kind":"solid","colour":"#000000"},"raster":{"width":640,"height":480},"presented_ns":1000}}"##;

fn picture(serial: u64) -> String {
    format!(
        r##""serial":{serial},"pattern":{{"kind":"solid","colour":"#ffffff"}},"raster":{{"width":640,"height":480}},"presented_ns":{}"##,
        serial * 1000
    )
}

/// The peer's end of the connection.
struct Peer {
    lines: BufReader<TcpStream>,
}

impl Peer {
    fn send(&mut self, bytes: impl AsRef<[u8]>) {
        self.lines.get_mut().write_all(bytes.as_ref()).unwrap();
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        self.lines.read_line(&mut line).unwrap();
        line
    }

    fn welcome(&mut self) {
        assert!(self.line().contains("\"hello\""));
        self.send(format!(
            "{{\"type\":\"welcome\",\"version\":1,\"role\":\"controller\",\"state\":{STATE}}}\n"
        ));
    }

    /// The number of the request that comes next.
    fn request(&mut self) -> u64 {
        let line = self.line();
        serde_json::from_str::<serde_json::Value>(&line).unwrap()["id"]
            .as_u64()
            .unwrap()
    }
}

/// Runs a link against a peer that follows a script, once per connection.
fn against<T>(script: impl Fn(Peer) + Send + 'static, link: impl FnOnce(LinkSettings) -> T) -> T {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            script(Peer {
                lines: BufReader::new(stream.unwrap()),
            });
        }
    });
    link(LinkSettings::new(&address, "test", Role::Controller))
}

fn connect(settings: &LinkSettings) -> ProjectorLink {
    ProjectorLink::connect(settings).unwrap()
}

#[test]
fn a_picture_is_presented_although_the_reply_comes_in_pieces_behind_garbage() {
    let script = |mut peer: Peer| {
        peer.welcome();
        let id = peer.request();
        peer.send("\n\u{1}garbage\n{\"type\":\"new_kind_of_notice\"}\n[1]\n");
        peer.send(format!(
            "{{\"type\":\"shown\",{}}}\n{{\"type\":\"done\",\"id\":{id}",
            picture(7)
        ));
        std::thread::sleep(Duration::from_millis(30));
        peer.send(format!(",{}}}\n", picture(7)));
        peer.line(); // until the link closes
    };
    against(script, |settings| {
        let link = connect(&settings);
        assert_eq!(link.first_state().screen.name, "headless");
        let presented = link.show(View::White).unwrap();
        assert_eq!(
            (presented.shown.serial, presented.shown.presented_ns),
            (7, 7000)
        );
        assert!(presented.round_trip() >= Duration::from_millis(30));
        let Some(Notice::Shown { shown, received_at }) =
            link.next_notice(Duration::from_secs(5)).unwrap()
        else {
            panic!("no notice")
        };
        assert_eq!(shown.serial, 7);
        assert!(presented.requested_at <= received_at && received_at <= presented.replied_at);
        assert_eq!(link.next_notice(Duration::ZERO).unwrap(), None);
    });
}

#[test]
fn replies_find_their_callers_whatever_their_order() {
    let script = |mut peer: Peer| {
        peer.welcome();
        let (first, second) = (peer.request(), peer.request());
        for id in [second, first] {
            peer.send(format!(
                "{{\"type\":\"done\",\"id\":{id},{}}}\n",
                picture(100 + id)
            ));
        }
        peer.line();
    };
    against(script, |settings| {
        let link = connect(&settings);
        std::thread::scope(|threads| {
            let calls =
                [0, 1].map(|_| threads.spawn(|| link.show(View::White).unwrap().shown.serial));
            let mut serials = calls.map(|call| call.join().unwrap());
            serials.sort_unstable();
            assert_eq!(serials, [101, 102]);
        });
    });
}

#[test]
fn a_refusal_is_told_and_the_connection_stays() {
    let script = |mut peer: Peer| {
        peer.welcome();
        let id = peer.request();
        peer.send(format!("{{\"type\":\"error\",\"id\":{id},\"code\":\"not_presented\",\"message\":\"covered\"}}\n"));
        let id = peer.request();
        peer.send(format!(
            "{{\"type\":\"pong\",\"id\":{id},\"clock_ns\":5}}\n"
        ));
        peer.line();
    };
    against(script, |settings| {
        let link = connect(&settings);
        let error = link.show(View::Coded).unwrap_err();
        assert_eq!(
            error,
            LinkError::Denied {
                code: ErrorCode::NotPresented,
                message: "covered".into()
            }
        );
        let ping = link.ping().unwrap();
        assert_eq!(ping.offset.uncertainty, ping.round_trip / 2);
    });
}

#[test]
fn a_peer_that_vanishes_ends_the_waiting_call_and_the_notices() {
    let script = |mut peer: Peer| {
        peer.welcome();
        peer.request(); // and gone
    };
    against(script, |settings| {
        let mut link = connect(&settings);
        assert!(matches!(link.show(View::White), Err(LinkError::Lost(_))));
        assert!(matches!(
            link.next_notice(Duration::from_secs(5)),
            Err(LinkError::Lost(_))
        ));
        assert!(matches!(link.state(), Err(LinkError::Lost(_))));
        link.reconnect().unwrap();
        assert_eq!(link.next_notice(Duration::ZERO).unwrap(), None);
    });
}

#[test]
fn a_silent_peer_costs_the_time_limit_and_a_late_reply_does_no_harm() {
    let script = |mut peer: Peer| {
        peer.welcome();
        let late = peer.request();
        let id = peer.request();
        peer.send(format!(
            "{{\"type\":\"done\",\"id\":{late},{}}}\n",
            picture(2)
        ));
        peer.send(format!(
            "{{\"type\":\"done\",\"id\":{id},{}}}\n",
            picture(3)
        ));
        peer.line();
    };
    against(script, |settings| {
        let link = connect(&LinkSettings {
            reply_timeout: Duration::from_millis(300),
            ..settings
        });
        let waited = Duration::from_millis(300);
        assert_eq!(link.show(View::White), Err(LinkError::NoReply { waited }));
        assert_eq!(link.show(View::White).unwrap().shown.serial, 3);
    });
}

#[test]
fn the_first_words_are_checked() {
    type Check = fn(&LinkError) -> bool;
    let answers: [(&str, Check); 6] = [
        (
            "{\"type\":\"error\",\"code\":\"controller_taken\",\"message\":\"by bench-1\"}\n",
            |error| *error == LinkError::Taken("by bench-1".into()),
        ),
        (
            "{\"type\":\"error\",\"code\":\"version\",\"message\":\"version 9\"}\n",
            |error| *error == LinkError::Version("version 9".into()),
        ),
        (
            "HTTP/1.1 400 Bad Request\r\nServer: x\r\nConnection: close\r\n",
            |error| matches!(error, LinkError::NotAProjector { .. }),
        ),
        ("{\"type\":\"noted\",\"id\":1}\n", |error| {
            matches!(error, LinkError::NotAProjector { .. })
        }),
        (
            "",
            |error| matches!(error, LinkError::NotAProjector { reason, .. } if reason.contains("without a word")),
        ),
        ("{\"type\":\"welcome\",", |error| {
            matches!(error, LinkError::NotAProjector { .. })
        }),
    ];
    for (answer, expected) in answers {
        let script = move |mut peer: Peer| {
            peer.line();
            peer.send(answer);
        };
        let error = against(script, |settings| {
            ProjectorLink::connect(&settings).unwrap_err()
        });
        assert!(expected(&error), "{answer}: {error:?}");
    }
}

#[test]
fn nobody_there_is_told_with_what_to_do() {
    let free = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .to_string();
    let error =
        ProjectorLink::connect(&LinkSettings::new(&free, "test", Role::Watcher)).unwrap_err();
    assert!(error.to_string().contains("start `projector`"), "{error}");
    for address in ["", "a b:1", "127.0.0.1:notaport", "127.0.0.1:99999"] {
        let settings = LinkSettings::new(address, "test", Role::Watcher);
        let error = ProjectorLink::connect(&settings).unwrap_err();
        assert!(
            matches!(error, LinkError::Address { .. }),
            "{address}: {error:?}"
        );
    }
}

#[test]
fn a_projector_that_starts_late_is_waited_for() {
    let address = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let server = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(150));
        let (stream, _) = TcpListener::bind(address).unwrap().accept().unwrap();
        Peer {
            lines: BufReader::new(stream),
        }
        .welcome();
    });
    let settings = LinkSettings::new(&address.to_string(), "test", Role::Controller);
    ProjectorLink::connect_within(&settings, Duration::from_secs(20)).unwrap();
    server.join().unwrap();
}
