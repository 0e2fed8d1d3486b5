//! The program `projector` without a window: what it says over TCP, on the command line, and at its end.

mod projector_support;

use projector_support::{Client, Projector};
use shared::{
    pattern::{Grid, Pattern, RasterSize, Rgb},
    protocol::{
        ColourScore, Command, ControllerChange, ErrorCode, MAX_CANDIDATES, MAX_LINE_BYTES,
        MAX_TEXT_CHARS, Role, ScreenKind, Selection, SequenceStep, ServerMessage, View,
    },
};

/// Runs the program to its end, without a display.
fn run(arguments: &str) -> std::process::Output {
    projector_support::run(arguments, &[])
}

const SIZE: RasterSize = RasterSize {
    width: 64,
    height: 48,
};

fn headless() -> Projector {
    Projector::start("--headless 64x48", &[])
}

/// Starts a headless projector with this configuration file.
fn configured(config: &str) -> Projector {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("projector.toml");
    std::fs::write(&file, config).expect("a writable folder");
    Projector::start(
        &format!("--headless 64x48 --config {}", file.display()),
        &[],
    )
}

fn error_of(message: Option<ServerMessage>) -> (ErrorCode, Option<u64>, String) {
    match message {
        Some(ServerMessage::Error { id, code, message }) => (code, id, message),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_client_is_welcomed_with_the_whole_state() {
    let projector = headless();
    let mut client = Client::connect(projector.address());
    let welcome = client.hello(Role::Controller, "bench", false);
    let Some(ServerMessage::Welcome {
        version,
        role,
        state,
    }) = welcome
    else {
        panic!("{welcome:?}")
    };
    assert_eq!((version, role), (1, Role::Controller));
    assert_eq!(
        (state.screen.kind, state.screen.raster),
        (ScreenKind::Headless, SIZE)
    );
    assert_eq!((state.shown.serial, state.shown.raster), (1, SIZE));
    assert_eq!(state.controller.as_deref(), Some("bench"));
}

#[test]
fn the_reply_comes_when_the_picture_is_presented() {
    let projector = headless();
    let mut client = projector.controller();
    let mut last = client.state().shown;
    for view in [
        View::Coded,
        View::Unary,
        View::White,
        View::Ramp,
        View::Identify,
        View::Black,
    ] {
        let before_ns = client.clock_ns();
        let shown = client.show(view);
        let after_ns = client.clock_ns();
        assert_eq!(shown.serial, last.serial + 1);
        assert!(before_ns < shown.presented_ns && shown.presented_ns < after_ns);
        assert!(
            client
                .notices
                .contains(&ServerMessage::Shown(shown.clone())),
            "told before the reply"
        );
        assert_eq!(client.state().shown, shown);
        last = shown;
    }
}

#[test]
fn the_same_picture_again_is_answered_with_its_own_serial_and_time() {
    let projector = headless();
    let mut client = projector.controller();
    let first = client.show(View::White);
    assert_eq!(client.show(View::Solid { colour: Rgb::WHITE }), first);
}

#[test]
fn requests_sent_at_once_are_done_in_their_order() {
    let projector = headless();
    let mut client = projector.controller();
    let views = [View::White, View::Black, View::Coded, View::Unary];
    let ids: Vec<u64> = views.map(|view| client.send(Command::Show { view })).into();
    let mut done = Vec::new();
    while done.len() < ids.len() {
        if let Some(ServerMessage::Done { id, shown }) = client.next() {
            done.push((id, shown.serial));
        }
    }
    assert_eq!(
        done,
        (2..)
            .zip(ids)
            .map(|(serial, id)| (id, serial))
            .collect::<Vec<_>>()
    );
}

#[test]
fn a_sequence_is_noted_at_once_and_shown_in_its_time_without_further_requests() {
    let projector = headless();
    let mut client = projector.controller();
    let views = [View::White, View::White, View::Coded, View::Black];
    let steps = views
        .clone()
        .map(|view| SequenceStep { view, hold_ms: 100 });
    let reply = client.ask(Command::ShowSequence {
        steps: steps.into(),
    });
    assert!(matches!(reply, ServerMessage::Noted { .. }), "{reply:?}");
    let shown_yet = |notice: &ServerMessage| matches!(notice, ServerMessage::Shown(_));
    let early = client.notices.iter().any(shown_yet);
    assert!(!early, "{:?}", client.notices);
    let mut shown = Vec::new();
    while shown.len() < views.len() {
        if let Some(ServerMessage::Shown(picture)) = client.next() {
            shown.push(picture);
        }
    }
    assert_eq!(
        shown.iter().map(|s| s.serial).collect::<Vec<_>>(),
        [2, 3, 4, 5]
    );
    assert_eq!(shown[1].pattern, Pattern::WHITE);
    let took_ms = (shown[3].presented_ns - shown[0].presented_ns) / 1_000_000;
    assert!(
        (270..1000).contains(&took_ms),
        "{took_ms} ms for three steps"
    );
}

#[test]
fn a_second_controller_is_refused_with_the_name_of_the_first() {
    let projector = headless();
    let mut first = projector.controller();
    let mut second = Client::connect(projector.address());
    let (code, _, message) = error_of(second.hello(Role::Controller, "late", false));
    assert_eq!(code, ErrorCode::ControllerTaken);
    assert!(message.contains("test controller"), "{message}");
    assert_eq!(second.next(), None, "the connection is closed");
    first.show(View::White);
}

#[test]
fn a_controller_that_takes_over_makes_the_first_a_watcher() {
    let projector = headless();
    let mut first = projector.controller();
    let mut second = Client::connect(projector.address());
    let welcome = second.hello(Role::Controller, "late", true);
    assert!(
        matches!(welcome, Some(ServerMessage::Welcome { .. })),
        "{welcome:?}"
    );
    let shown = second.show(View::White);
    let reply = first.ask(Command::Show { view: View::Black });
    assert_eq!(error_of(Some(reply)).0, ErrorCode::NotController);
    let joined = ServerMessage::Controller {
        change: ControllerChange::Joined,
        name: "late".to_owned(),
    };
    assert!(first.notices.contains(&joined), "{:?}", first.notices);
    assert!(first.notices.contains(&ServerMessage::Shown(shown)));
}

#[test]
fn a_watcher_gets_every_notice_and_decides_nothing() {
    let projector = headless();
    let mut watcher = projector.watcher();
    let mut controller = projector.controller();
    let shown = controller.show(View::Coded);
    controller.change(Command::SetWidths {
        row_width_px: 2,
        column_width_px: 3,
    });
    let state = controller.state();
    drop(controller);
    let mut notices = Vec::new();
    let left = ServerMessage::Controller {
        change: ControllerChange::Left,
        name: "test controller".to_owned(),
    };
    while notices.last() != Some(&left) {
        notices.push(watcher.next().unwrap());
    }
    assert!(notices.contains(&ServerMessage::Shown(shown)));
    assert!(notices.contains(&ServerMessage::Shown(state.shown.clone())));
    assert!(notices.contains(&ServerMessage::StateChanged { state }));
    let reply = watcher.ask(Command::Blank { on: true });
    assert_eq!(error_of(Some(reply)).0, ErrorCode::NotController);
}

#[test]
fn another_version_is_refused_clearly_and_the_connection_closed() {
    let projector = headless();
    let mut client = Client::connect(projector.address());
    client.send_bytes(
        b"{\"type\":\"hello\",\"version\":2,\"role\":\"watcher\",\"name\":\"new\",\"plus\":1}\n",
    );
    let (code, _, message) = error_of(client.next());
    assert_eq!(code, ErrorCode::Version);
    assert!(
        message.contains("version 1") && message.contains("version 2"),
        "{message}"
    );
    assert_eq!(client.next(), None);
}

#[test]
fn whoever_does_not_say_hello_first_is_refused() {
    let projector = headless();
    for (line, expected) in [
        ("{\"id\":9,\"type\":\"state\"}\n", ErrorCode::Hello),
        ("GET / HTTP/1.1\n", ErrorCode::Malformed),
        ("{\"type\":\"hello\"}\n", ErrorCode::Invalid),
    ] {
        let mut client = Client::connect(projector.address());
        client.send_bytes(line.as_bytes());
        assert_eq!(error_of(client.next()).0, expected, "{line}");
        assert_eq!(client.next(), None, "{line}");
    }
}

#[test]
fn garbage_is_answered_and_the_connection_goes_on() {
    let projector = headless();
    let mut client = projector.watcher();
    let long = "x".repeat(3 * MAX_LINE_BYTES);
    for (line, code, id) in [
        ("\u{0}\u{1}garbage", ErrorCode::Malformed, None),
        (long.as_str(), ErrorCode::TooLong, None),
        (
            "{\"id\":77,\"type\":\"explode\"}",
            ErrorCode::UnknownType,
            Some(77),
        ),
        (
            "{\"id\":78,\"type\":\"show\",\"view\":{}}",
            ErrorCode::Invalid,
            Some(78),
        ),
        (
            "{\"type\":\"hello\",\"version\":1,\"role\":\"watcher\",\"name\":\"b\"}",
            ErrorCode::Hello,
            None,
        ),
    ] {
        client.send_bytes(format!("{line}\n").as_bytes());
        let (got, got_id, _) = error_of(client.next());
        assert_eq!((got, got_id), (code, id));
    }
    client.send_bytes(b"\xff\xff\n");
    assert_eq!(error_of(client.next()).0, ErrorCode::Malformed);
    assert_eq!(client.state().screen.raster, SIZE);
}

#[test]
fn a_line_may_come_in_pieces() {
    let projector = headless();
    let mut client = projector.watcher();
    for byte in b"{\"id\":5,\"type\":\"ping\"}\n" {
        client.send_bytes(&[*byte]);
    }
    assert!(matches!(
        client.next(),
        Some(ServerMessage::Pong { id: 5, .. })
    ));
}

#[test]
fn clients_that_vanish_in_the_middle_leave_the_projector_working() {
    let projector = headless();
    for k in 0..20 {
        let mut client = Client::connect(projector.address());
        if k % 2 == 0 {
            client.hello(Role::Controller, "brief", true);
            client.send(Command::Show { view: View::White });
        }
        client.send_bytes(b"{\"id\":1,\"type\":\"sh");
    }
    let mut client = Client::connect(projector.address());
    let welcome = client.hello(Role::Controller, "lasting", true);
    assert!(
        matches!(welcome, Some(ServerMessage::Welcome { .. })),
        "{welcome:?}"
    );
    assert_eq!(client.show(View::Ramp).pattern, Pattern::Ramp);
}

#[test]
fn a_watcher_that_does_not_read_is_cut_and_nobody_waits_for_it() {
    let projector = headless();
    let mut sleeper = projector.watcher();
    let mut controller = projector.controller();
    let candidate = ColourScore {
        colour: Rgb::WHITE,
        score: 1.0,
    };
    let selection = Selection {
        colours: vec![Rgb::WHITE; 4],
        unary: Rgb::WHITE,
        score: 1.0,
        candidates: vec![candidate; MAX_CANDIDATES],
        // six bytes each when written
        reason: "\0".repeat(MAX_TEXT_CHARS),
    };
    // 9 kB each: more than the system buffers on both sides hold.
    let reports = 1500;
    for _ in 0..reports {
        let reply = controller.ask(Command::ReportSelection {
            selection: selection.clone(),
        });
        assert!(matches!(reply, ServerMessage::Noted { .. }), "{reply:?}");
        controller.notices.clear();
    }
    let heard = std::iter::from_fn(|| sleeper.next())
        .take(reports + 1)
        .count();
    assert!(
        heard < reports,
        "the connection ended after {heard} notices"
    );
}

#[test]
fn more_connections_than_allowed_are_refused_until_one_ends() {
    let projector = configured("[control]\nmax_connections = 2\n");
    let first = projector.watcher();
    let mut second = projector.watcher();
    let (code, _, message) = error_of(Client::connect(projector.address()).next());
    assert_eq!(code, ErrorCode::Full);
    assert!(message.contains('2'), "{message}");
    second.state();
    drop(first);
    // The place is free once the projector has seen the end of the first.
    let mut answers = std::iter::repeat_with(|| {
        Client::connect(projector.address()).hello(Role::Watcher, "next", false)
    });
    assert!(answers.any(|answer| matches!(answer, Some(ServerMessage::Welcome { .. }))));
}

#[test]
fn a_lost_controller_leaves_the_picture_or_blanks_it_as_configured() {
    for (config, blank) in [("keep", false), ("blank", true)] {
        let projector = configured(&format!("[control]\non_controller_lost = \"{config}\"\n"));
        let mut watcher = projector.watcher();
        let mut controller = projector.controller();
        controller.show(View::White);
        drop(controller);
        let left = |message: &ServerMessage| {
            matches!(
                message,
                ServerMessage::Controller {
                    change: ControllerChange::Left,
                    ..
                }
            )
        };
        while !left(&watcher.next().unwrap()) {}
        let expected = if blank {
            Pattern::BLACK
        } else {
            Pattern::WHITE
        };
        assert_eq!(watcher.state().shown.pattern, expected);
    }
}

#[test]
fn the_identify_card_goes_away_by_itself() {
    let projector = headless();
    let mut controller = projector.controller();
    controller.show(View::White);
    let card = controller.change(Command::Identify { seconds: 1 });
    assert_eq!(
        card.pattern,
        Pattern::Identify {
            label: "headless".to_owned()
        }
    );
    controller.notices.clear();
    let Some(ServerMessage::Shown(shown)) = controller.next() else {
        panic!("no notice")
    };
    assert_eq!(shown.pattern, Pattern::WHITE);
}

#[test]
fn signals_end_it_cleanly_after_one_line_on_standard_output() {
    for signal in ["TERM", "INT"] {
        let projector = headless();
        let mut client = projector.controller();
        projector.signal(signal);
        while client.next().is_some() {}
        let (status, rest) = projector.ended();
        assert_eq!((status.code(), rest.as_str()), (Some(0), ""), "{signal}");
    }
}

#[test]
fn failures_exit_with_1_and_wrong_use_with_2() {
    let projector = headless();
    let taken = run(&format!(
        "--headless 64x48 --listen {}",
        projector.address()
    ));
    let without_display = run("--listen 127.0.0.1:0");
    for (output, code, hint) in [
        (taken, 1, "--listen"),
        (without_display, 1, "--headless"),
        (run("screens"), 1, "--headless"),
        (
            run("--headless 64x48 --config /nonexistent.toml"),
            1,
            "/nonexistent.toml",
        ),
        (run("--headless 64"), 2, "WIDTHxHEIGHT"),
        (run("--headless 64x48 --windowed 64x48"), 2, "--windowed"),
    ] {
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{text}");
        assert!(text.contains(hint), "{text}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn render_writes_what_would_be_shown() {
    let folder = tempfile::tempdir().unwrap();
    let four = ["#ff0000", "#ffff00", "#ff00ff", "#00ff00"].map(|text| text.parse().unwrap());
    let grid = Grid::coded(15, 31, 2, 3, &four).unwrap();
    let object = serde_json::to_string(&grid).unwrap();
    let unary: Rgb = "#0080ff".parse().unwrap();
    let settings = object.replacen('{', "{\"unary\":\"#0080ff\",", 1);
    let as_toml = "kind = \"solid\"\ncolour = \"#8000ff\"\n";
    let cases = [
        ("grid.json", object.clone(), "", Pattern::from(grid.clone())),
        (
            "pattern.json",
            object.replacen('{', "{\"kind\":\"grid\",", 1),
            "",
            grid.clone().into(),
        ),
        (
            "scan.json",
            format!("{{\"format\":1,\"pattern\":{settings}}}"),
            "",
            grid.clone().into(),
        ),
        (
            "twin.json",
            settings.clone(),
            "--unary",
            grid.unary(unary).into(),
        ),
        (
            "ramp.json",
            "{\"kind\":\"ramp\"}".to_owned(),
            "",
            Pattern::Ramp,
        ),
        (
            "solid.toml",
            as_toml.to_owned(),
            "",
            Pattern::try_from("#8000ff").unwrap(),
        ),
    ];
    for (name, text, option, pattern) in cases {
        let (file, out) = (
            folder.path().join(name),
            folder.path().join(format!("{name}.png")),
        );
        std::fs::write(&file, text).unwrap();
        let (file, out_name) = (file.display(), out.display());
        let output = run(&format!(
            "render --pattern {file} --size 200x150 {option} {out_name}"
        ));
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let picture = image::open(&out).unwrap().to_rgb8();
        let expected = pattern.raster(RasterSize {
            width: 200,
            height: 150,
        });
        assert_eq!(picture.dimensions(), (200, 150));
        assert!(picture.as_raw() == expected.bytes(), "{name}");
    }
    let nothing = folder.path().join("nothing.json");
    std::fs::write(&nothing, "{\"format\":1}").unwrap();
    let output = run(&format!(
        "render --pattern {} --size 8x8 /dev/null",
        nothing.display()
    ));
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("colours"));
}
