//! The rules of the protocol, without a socket and a window.

use shared::{
    pattern::{GridSettings, Pattern, RasterSize, Rgb},
    protocol::{
        Command, ErrorCode, Hello, MAX_STEPS, Role, ScreenInfo, ScreenKind, Selection,
        SequenceStep, VERSION, View,
    },
};

use super::{ConnectionId, Effects, State};

const SIZE: RasterSize = RasterSize {
    width: 64,
    height: 48,
};
const FIRST: ConnectionId = ConnectionId(1);
const SECOND: ConnectionId = ConnectionId(2);

fn screen(raster: RasterSize) -> ScreenInfo {
    ScreenInfo {
        kind: ScreenKind::Headless,
        name: "test".into(),
        raster,
        problem: None,
    }
}

/// A state whose first picture is presented and whose controller is `FIRST`.
fn controlled() -> State {
    let mut state = State::new(screen(SIZE), GridSettings::default(), View::Black);
    assert!(state.presented(1, SIZE, 100).is_some());
    assert_eq!(
        state.join(FIRST, &hello(Role::Controller, false)).ok(),
        Some(Role::Controller)
    );
    state
}

fn hello(role: Role, take_over: bool) -> Hello {
    Hello {
        version: VERSION,
        role,
        name: "bench".into(),
        take_over,
        token: None,
    }
}

fn show(view: View) -> Command {
    Command::Show { view }
}

fn pattern_of(effects: &Effects) -> Option<&Pattern> {
    effects.present.as_ref().map(|picture| &picture.pattern)
}

#[test]
fn another_picture_gets_the_next_serial_and_the_same_picture_keeps_its_own() {
    let mut state = controlled();
    let coded = state.request(FIRST, show(View::Coded)).unwrap();
    assert_eq!(coded.present.map(|picture| picture.serial), Some(2));
    assert!(state.presented(2, SIZE, 200).is_some());
    assert_eq!(
        state.request(FIRST, show(View::Coded)).unwrap(),
        Effects::default()
    );
    assert_eq!((state.shown().serial, state.shown().presented_ns), (2, 200));
}

#[test]
fn black_as_a_view_and_as_a_solid_colour_are_the_same_picture() {
    let mut state = controlled();
    let effects = state
        .request(FIRST, show(View::Solid { colour: Rgb::BLACK }))
        .unwrap();
    assert_eq!(
        effects,
        Effects {
            changed: true,
            ..Effects::default()
        }
    );
}

#[test]
fn settings_change_the_picture_only_when_it_is_made_of_them() {
    let mut state = controlled();
    let widths = Command::SetWidths {
        row_width_px: 1,
        column_width_px: 2,
    };
    let hidden = state.request(FIRST, widths).unwrap();
    assert!(hidden.changed && hidden.present.is_none());
    let shown = state.request(FIRST, show(View::Unary)).unwrap();
    assert_eq!(
        pattern_of(&shown),
        Some(&state.report().grid.unary_grid().into())
    );
    let lines = state
        .request(
            FIRST,
            Command::SetLines {
                rows: 31,
                columns: 63,
            },
        )
        .unwrap();
    let Some(Pattern::Grid(grid)) = pattern_of(&lines) else {
        panic!("{lines:?}")
    };
    assert_eq!(
        (grid.rows(), grid.columns(), grid.is_unary()),
        (31, 63, true)
    );
}

#[test]
fn the_operator_sees_who_is_connected_and_who_controls() {
    let mut state = controlled();
    let watcher = Hello {
        name: "onlooker".into(),
        ..hello(Role::Watcher, false)
    };
    assert!(state.join(SECOND, &watcher).is_ok());
    let members = |state: &State| -> Vec<(String, Role)> {
        let members = state.overview().members.into_iter();
        members.map(|member| (member.name, member.role)).collect()
    };
    let (bench, onlooker) = ("bench".to_owned(), "onlooker".to_owned());
    assert_eq!(
        members(&state),
        [
            (bench.clone(), Role::Controller),
            (onlooker.clone(), Role::Watcher)
        ]
    );
    assert!(
        state
            .join(ConnectionId(3), &hello(Role::Controller, true))
            .is_ok()
    );
    state.leave(SECOND);
    assert_eq!(
        members(&state),
        [(bench.clone(), Role::Watcher), (bench, Role::Controller)]
    );
}

#[test]
fn the_two_colour_view_and_the_test_card_are_pictures_of_their_own() {
    let mut state = controlled();
    let two = state.request(FIRST, show(View::TwoColour)).unwrap();
    let Some(Pattern::Grid(grid)) = pattern_of(&two) else {
        panic!("{two:?}")
    };
    assert_eq!(grid.colours(), &state.report().grid.coded.colours()[..2]);
    let widths = Command::SetWidths {
        row_width_px: 1,
        column_width_px: 2,
    };
    assert!(state.request(FIRST, widths).unwrap().present.is_some());
    assert!(state.overview().on_its_way);
    let card = state.request(FIRST, show(View::TestCard)).unwrap();
    assert_eq!(pattern_of(&card), Some(&Pattern::TestCard));
}

fn sequence(views: &[View]) -> Command {
    let steps = views.iter().map(|view| SequenceStep {
        view: view.clone(),
        hold_ms: 50.0,
    });
    Command::ShowSequence {
        steps: steps.collect(),
        begin_ns: None,
    }
}

#[test]
fn a_sequence_gives_each_step_its_own_picture_and_tells_the_state_at_its_end() {
    let mut state = controlled();
    let views = [View::Black, View::White, View::White];
    let mut effects = state.request(FIRST, sequence(&views)).unwrap();
    for (k, view) in views.iter().enumerate() {
        let last = k + 1 == views.len();
        assert_eq!(
            effects.present.as_ref().map(|picture| picture.serial),
            Some(k as u64 + 2)
        );
        assert_eq!(&state.report().view, view);
        assert_eq!((effects.changed, state.has_steps()), (last, !last));
        assert_eq!(
            effects.next_step_in.map(|hold| hold.as_millis()),
            (!last).then_some(50)
        );
        effects = state.next_step();
    }
    assert_eq!(effects, Effects::default());
}

#[test]
fn another_picture_another_controller_or_none_ends_a_sequence() {
    let ends: [fn(&mut State); 4] = [
        |state| drop(state.request(FIRST, show(View::Coded))),
        |state| drop(state.apply(Command::Blank { on: true })),
        |state| drop(state.join(SECOND, &hello(Role::Controller, true))),
        |state| drop(state.leave(FIRST)),
    ];
    for end in ends {
        let mut state = controlled();
        let running = state.request(FIRST, sequence(&[View::White, View::Unary]));
        assert!(running.is_ok() && state.has_steps());
        end(&mut state);
        assert_eq!(state.next_step(), Effects::default());
    }
}

#[test]
fn a_sequence_without_steps_with_too_many_or_without_time_is_refused() {
    let mut state = controlled();
    let timeless = Command::ShowSequence {
        steps: vec![SequenceStep {
            view: View::White,
            hold_ms: 0.0,
        }],
        begin_ns: None,
    };
    for command in [
        sequence(&[]),
        sequence(&vec![View::White; MAX_STEPS + 1]),
        timeless,
    ] {
        let refusal = state.request(FIRST, command).unwrap_err();
        assert_eq!(refusal.code(), ErrorCode::Invalid);
        assert_eq!(state.picture().serial, 1);
    }
}

#[test]
fn a_refused_change_leaves_everything_as_it_was() {
    let mut state = controlled();
    let before = state.report();
    let bad = [
        Command::SetWidths {
            row_width_px: 0,
            column_width_px: 2,
        },
        Command::SetLines {
            rows: 16,
            columns: 15,
        },
        Command::SetColours {
            colours: vec![Rgb::WHITE; 3],
            unary: Rgb::WHITE,
        },
        Command::Identify { seconds: 0 },
        Command::Identify { seconds: 61 },
    ];
    for command in bad {
        assert_eq!(
            state.request(FIRST, command).unwrap_err().code(),
            ErrorCode::Invalid
        );
        assert_eq!(state.report(), before);
    }
}

#[test]
fn blanking_remembers_the_view_and_show_ends_it() {
    let mut state = controlled();
    assert!(
        state
            .request(FIRST, show(View::White))
            .unwrap()
            .present
            .is_some()
    );
    let dark = state.request(FIRST, Command::Blank { on: true }).unwrap();
    assert_eq!(pattern_of(&dark), Some(&Pattern::BLACK));
    assert_eq!(state.report().view, View::White);
    let back = state.request(FIRST, Command::Blank { on: false }).unwrap();
    assert_eq!(pattern_of(&back), Some(&Pattern::WHITE));
    assert!(
        state
            .request(FIRST, Command::Blank { on: true })
            .unwrap()
            .present
            .is_some()
    );
    let ramp = state.request(FIRST, show(View::Ramp)).unwrap();
    assert_eq!(pattern_of(&ramp), Some(&Pattern::Ramp));
    assert!(!state.report().blank);
}

#[test]
fn the_identify_card_ends_after_its_time_or_at_the_next_request() {
    let mut state = controlled();
    let card = state
        .request(FIRST, Command::Identify { seconds: 3 })
        .unwrap();
    assert_eq!(
        pattern_of(&card),
        Some(&Pattern::Identify {
            label: "test".into()
        })
    );
    assert_eq!(card.identify_for.map(|time| time.as_secs()), Some(3));
    assert_eq!(pattern_of(&state.end_identify()), Some(&Pattern::BLACK));
    assert!(
        state
            .request(FIRST, Command::Identify { seconds: 3 })
            .unwrap()
            .present
            .is_some()
    );
    let white = state.request(FIRST, show(View::White)).unwrap();
    assert_eq!(pattern_of(&white), Some(&Pattern::WHITE));
    assert!(!state.is_identifying());
}

#[test]
fn a_second_controller_is_refused_with_the_name_unless_it_takes_over() {
    let mut state = controlled();
    let refusal = state
        .join(SECOND, &hello(Role::Controller, false))
        .unwrap_err();
    assert_eq!(refusal.code(), ErrorCode::ControllerTaken);
    assert!(refusal.to_string().contains("bench"), "{refusal}");
    assert!(state.join(SECOND, &hello(Role::Controller, true)).is_ok());
    let refusal = state.request(FIRST, show(View::White)).unwrap_err();
    assert_eq!(refusal.code(), ErrorCode::NotController);
    assert_eq!(state.leave(FIRST), None, "it is a watcher by now");
    assert_eq!(state.leave(SECOND).as_deref(), Some("bench"));
}

#[test]
fn a_watcher_may_ask_but_not_decide() {
    let mut state = controlled();
    assert_eq!(
        state.join(SECOND, &hello(Role::Watcher, false)).ok(),
        Some(Role::Watcher)
    );
    assert_eq!(
        state.request(SECOND, Command::State),
        Ok(Effects::default())
    );
    for command in [
        show(View::White),
        Command::Blank { on: true },
        Command::Identify { seconds: 1 },
    ] {
        assert_eq!(
            state.request(SECOND, command).unwrap_err().code(),
            ErrorCode::NotController
        );
    }
}

#[test]
fn another_version_and_a_useless_name_are_refused() {
    let mut state = controlled();
    let later = Hello {
        version: VERSION + 1,
        ..hello(Role::Watcher, false)
    };
    assert_eq!(
        state.join(SECOND, &later).unwrap_err().code(),
        ErrorCode::Version
    );
    for name in [String::new(), "x".repeat(1001)] {
        let odd = Hello {
            name,
            ..hello(Role::Watcher, false)
        };
        assert_eq!(
            state.join(SECOND, &odd).unwrap_err().code(),
            ErrorCode::Invalid
        );
    }
}

#[test]
fn a_selection_is_kept_for_everybody_and_changes_no_picture() {
    let mut state = controlled();
    let selection = Selection {
        colours: vec![Rgb::WHITE; 4],
        unary: Rgb::WHITE,
        score: 1.5,
        candidates: vec![],
        reason: "bright".into(),
    };
    let report = Command::ReportSelection {
        selection: selection.clone(),
    };
    let effects = state.request(FIRST, report).unwrap();
    assert_eq!(
        effects,
        Effects {
            changed: true,
            ..Effects::default()
        }
    );
    assert_eq!(state.report().selection, Some(selection.clone()));
    let wordy = Selection {
        reason: "x".repeat(1001),
        ..selection
    };
    assert!(
        state
            .request(FIRST, Command::ReportSelection { selection: wordy })
            .is_err()
    );
}

#[test]
fn a_screen_of_another_size_needs_another_picture() {
    let mut state = controlled();
    assert_eq!(state.screen_changed(screen(SIZE)), Effects::default());
    let larger = RasterSize { width: 128, ..SIZE };
    let effects = state.screen_changed(screen(larger));
    assert!(effects.changed);
    assert_eq!(
        effects.present.as_ref().map(|picture| picture.serial),
        Some(2)
    );
    assert_eq!(
        state.presented(2, larger, 300).map(|shown| shown.raster),
        Some(larger)
    );
}

#[test]
fn reports_about_superseded_pictures_are_ignored() {
    let mut state = controlled();
    assert!(
        state
            .request(FIRST, show(View::White))
            .unwrap()
            .present
            .is_some()
    );
    assert!(
        state
            .request(FIRST, show(View::Ramp))
            .unwrap()
            .present
            .is_some()
    );
    assert_eq!(state.presented(2, SIZE, 200), None);
    assert_eq!(
        state.presented(3, SIZE, 300).map(|shown| shown.serial),
        Some(3)
    );
    assert_eq!(state.presented(3, SIZE, 400), None, "told already");
}

#[test]
fn a_lost_controller_may_darken_the_picture() {
    let mut state = controlled();
    assert!(
        state
            .request(FIRST, show(View::White))
            .unwrap()
            .present
            .is_some()
    );
    assert_eq!(state.leave(FIRST).as_deref(), Some("bench"));
    assert_eq!(
        pattern_of(&state.blank_for_lost_controller()),
        Some(&Pattern::BLACK)
    );
    assert_eq!(state.controller_name(), None);
}
