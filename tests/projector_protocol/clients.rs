//! Who connects: controllers, watchers, strangers, those that vanish.

use shared::{
    pattern::{Pattern, Rgb},
    protocol::{
        ColourScore, Command, ControllerChange, ErrorCode, MAX_CANDIDATES, MAX_LINE_BYTES,
        MAX_TEXT_CHARS, Role, ScreenKind, Selection, ServerMessage, View,
    },
};

use crate::{SIZE, configured, error_of, headless, projector_support::Client};

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
    let mut third = Client::connect(projector.address());
    let (code, _, message) = error_of(third.hello(Role::Watcher, "third", false));
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
