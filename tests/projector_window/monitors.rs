//! A desktop with two monitors: the picture on the one, the operator's window on the other.

use projector::screen::Monitor;
use shared::{
    pattern::{Raster, RasterSize},
    protocol::{ProjectorState, ScreenKind, View},
};

use crate::{
    Client, Display, Projector,
    operator::{TITLE, TITLE_PATTERN, Twin, click, cut, until},
};

const LEFT: RasterSize = RasterSize {
    width: 1280,
    height: 960,
};
const RIGHT: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};

/// The part of the desktop that a monitor shows.
fn seen(display: &Display, x: u32, size: RasterSize) -> Raster {
    cut(&display.screenshot(), x, 0, size)
}

/// Where the operator's window begins and ends on the desktop, in pixels from the left.
fn operator(display: &Display) -> (u32, u32) {
    let search = ["search", "--sync", "--name", TITLE_PATTERN];
    let id = display.xdotool(&search);
    let geometry = display.xdotool(&["getwindowgeometry", "--shell", &id]);
    let number = |key: &str| -> u32 {
        let value = geometry.lines().find_map(|line| line.strip_prefix(key));
        let value = value.and_then(|value| value.strip_prefix('='));
        value
            .and_then(|value| value.parse().ok())
            .expect("a number")
    };
    (number("X"), number("X") + number("WIDTH"))
}

/// Waits until the projector fills the monitor of this name; gives its state then.
fn moved(watcher: &mut Client, name: &str) -> ProjectorState {
    let mut state = watcher.state();
    until(&format!("the picture is not on {name}"), || {
        state = watcher.state();
        state.screen.name == name && state.screen.raster == state.shown.raster
    });
    state
}

/// Waits until a monitor shows exactly the projector's picture.
fn fills(display: &Display, state: &ProjectorState, (x, size): (u32, RasterSize)) {
    let expected = state.shown.pattern.raster(size);
    until(&format!("another picture than {:?}", state.shown), || {
        seen(display, x, size) == expected
    });
}

#[test]
fn the_picture_fills_the_second_monitor_and_the_operator_has_the_first() {
    let display = Display::with_two_monitors([LEFT, RIGHT]);
    let projector = Projector::start("", &display.environment());
    let mut controller = projector.controller();
    let screen = controller.state().screen;
    assert_eq!(screen.kind, ScreenKind::FullScreen);
    assert_eq!((screen.name.as_str(), screen.raster), ("DUMMY1", RIGHT));
    let (begin, end) = operator(&display);
    assert!(begin < end && end <= LEFT.width, "{begin} to {end}");
    for view in [View::White, View::TestCard, View::Coded] {
        controller.show(view);
        fills(&display, &controller.state(), (LEFT.width, RIGHT));
    }
}

#[test]
fn a_click_on_a_monitor_takes_the_picture_there_and_the_operators_window_out_of_its_way() {
    let display = Display::with_two_monitors([LEFT, RIGHT]);
    let projector = Projector::start("", &display.environment());
    let mut watcher = projector.watcher();
    let state = moved(&mut watcher, "DUMMY1");
    operator(&display);
    let monitor = |name: &str, x, size: RasterSize, primary| Monitor {
        name: name.into(),
        x,
        y: 0,
        width: size.width,
        height: size.height,
        refresh_hz: Some(60.0),
        primary,
    };
    let monitors = vec![
        monitor("DUMMY0", 0, LEFT, true),
        monitor("DUMMY1", LEFT.width as i32, RIGHT, false),
    ];
    let twin = Twin::with_monitors(display.window(TITLE).size(), state, monitors);
    click(&display, twin.place_of("DUMMY0"));
    let state = moved(&mut watcher, "DUMMY0");
    fills(&display, &state, (0, LEFT));
    let (begin, _) = operator(&display);
    assert!(
        begin >= LEFT.width,
        "the operator's window covers the picture"
    );
}

#[test]
fn a_monitor_that_is_unplugged_beside_another_is_told_and_filled_again_when_it_is_back() {
    let display = Display::with_two_monitors([LEFT, RIGHT]);
    let projector = Projector::start("", &display.environment());
    let mut watcher = projector.watcher();
    let state = moved(&mut watcher, "DUMMY1");
    fills(&display, &state, (LEFT.width, RIGHT));
    display.xrandr(&["--output", "DUMMY1", "--off"]);
    until("the missing monitor is not told", || {
        watcher.state().screen.problem.is_some()
    });
    let mode = RIGHT.to_string();
    display.xrandr(&[
        "--output",
        "DUMMY1",
        "--mode",
        &mode,
        "--right-of",
        "DUMMY0",
    ]);
    until("it is back, and that is not seen", || {
        watcher.state().screen.problem.is_none()
    });
    let state = moved(&mut watcher, "DUMMY1");
    fills(&display, &state, (LEFT.width, RIGHT));
}
