//! What is shown, and when it is told.

use shared::{
    pattern::{Pattern, Rgb},
    protocol::{Command, ControllerChange, ErrorCode, SequenceStep, ServerMessage, View},
};

use crate::{configured, headless};

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
    let steps = views.clone().map(|view| SequenceStep {
        view,
        hold_ms: 100.0,
    });
    let reply = client.ask(Command::ShowSequence {
        steps: steps.into(),
        begin_ns: None,
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
fn a_sequence_begins_when_the_projectors_clock_says_so() {
    let projector = headless();
    let mut client = projector.controller();
    let ServerMessage::Pong { clock_ns, .. } = client.ask(Command::Ping) else {
        panic!("no pong");
    };
    let begin_at = |begin_ns| Command::ShowSequence {
        steps: vec![SequenceStep {
            view: View::White,
            hold_ms: 33.4,
        }],
        begin_ns: Some(begin_ns),
    };
    // whoever waits for an hour, or for ever, has mistaken another clock for this one
    for begin_ns in [clock_ns + 3_600_000_000_000, u64::MAX] {
        let ServerMessage::Error { code, message, .. } = client.ask(begin_at(begin_ns)) else {
            panic!("{begin_ns} was taken");
        };
        assert_eq!(code, ErrorCode::Invalid);
        assert!(message.contains("within 60 s"), "{message}");
    }
    let begin_ns = clock_ns + 400_000_000;
    let reply = client.ask(begin_at(begin_ns));
    assert!(matches!(reply, ServerMessage::Noted { .. }), "{reply:?}");
    assert_ne!(client.state().shown.pattern, Pattern::WHITE, "not yet");
    let shown = loop {
        if let Some(ServerMessage::Shown(shown)) = client.next() {
            break shown;
        }
    };
    assert_eq!(shown.pattern, Pattern::WHITE);
    assert!(
        shown.presented_ns >= begin_ns,
        "{} ns early",
        begin_ns - shown.presented_ns
    );
    // a time that is over means now; another picture ends what waits
    client.ask(begin_at(begin_ns + 59_000_000_000));
    client.show(View::Black);
    client.ask(begin_at(1));
    loop {
        if let Some(ServerMessage::Shown(shown)) = client.next()
            && shown.pattern == Pattern::WHITE
        {
            break;
        }
    }
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
