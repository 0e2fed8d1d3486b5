//! The program `projector` with its real window, on a display nobody sees: every pixel of a screenshot is
//! compared with the pattern's definition.

mod projector_support;

#[path = "projector_support/display.rs"]
mod display;

#[path = "projector_window/operator.rs"]
mod operator;

#[path = "projector_window/monitors.rs"]
mod monitors;

use display::Display;
use projector_support::{Client, Projector, run};
use shared::{
    pattern::{Grid, Pattern, Raster, RasterSize, Rgb},
    protocol::{Command, ScreenKind, ServerMessage, View},
};

const SIZE: RasterSize = RasterSize {
    width: 400,
    height: 300,
};

fn rgb(text: &str) -> Rgb {
    text.parse().expect("#rrggbb")
}

fn four() -> [Rgb; 4] {
    // Other values than 0 and 255 too: a window that converts to sRGB would change these.
    ["#ff0000", "#80ff01", "#017fff", "#fefdfc"].map(rgb)
}

fn assert_same(got: &Raster, expected: &Raster, what: &str) {
    assert_eq!(got.size(), expected.size(), "{what}");
    let pixels = |raster: &Raster| {
        raster
            .bytes()
            .chunks(3)
            .map(<[u8]>::to_vec)
            .collect::<Vec<_>>()
    };
    let (got_pixels, expected_pixels) = (pixels(got), pixels(expected));
    let pairs = got_pixels.iter().zip(&expected_pixels);
    let different = pairs.clone().filter(|(a, b)| a != b).count();
    let first = pairs.enumerate().find(|(_, (a, b))| a != b);
    assert_eq!(
        different, 0,
        "{what}: pixels differ, the first is {first:?}"
    );
}

/// Grids of every kind.
fn grids() -> Vec<Grid> {
    let coded = |rows, columns, row_px, column_px, colours: &[Rgb]| {
        Grid::coded(rows, columns, row_px, column_px, colours).expect("a grid")
    };
    let explicit = r##"{"row_width_px":4,"column_width_px":7,"colours":["#102030","#ff8000","#00ff80"],
        "row_symbols":[0,1,2,1],"column_symbols":[2,0,1,1,0]}"##;
    let prmvs = coded(15, 15, 6, 6, &four());
    vec![
        prmvs.unary(rgb("#204060")),
        prmvs,
        coded(31, 63, 3, 2, &four()),
        // lines wider than their pitch
        coded(15, 63, 30, 9, &four()),
        coded(127, 255, 1, 1, &["#ff0000", "#0000ff"].map(rgb)),
        serde_json::from_str(explicit).expect("a grid"),
    ]
}

/// Shows a view and compares what is on the screen with what the reply says is shown.
fn check(client: &mut Client, screenshot: impl Fn() -> Raster, view: View, expected: &Pattern) {
    let asked_ns = client.clock_ns();
    let shown = client.show(view);
    assert_eq!((&shown.pattern, shown.raster), (expected, SIZE));
    assert!(asked_ns < shown.presented_ns && shown.presented_ns < client.clock_ns());
    assert_same(
        &screenshot(),
        &expected.raster(SIZE),
        &format!("{expected:?}"),
    );
}

fn check_all(client: &mut Client, name: &str, screenshot: impl Fn() -> Raster) {
    for grid in grids() {
        check(client, &screenshot, View::Grid(grid.clone()), &grid.into());
    }
    let colour = rgb("#0180fe");
    let card = Pattern::Identify {
        label: name.to_owned(),
    };
    for (view, pattern) in [
        (View::Solid { colour }, Pattern::Solid { colour }),
        (View::White, Pattern::WHITE),
        (View::Black, Pattern::BLACK),
        (View::Ramp, Pattern::Ramp),
        (View::Identify, card),
    ] {
        check(client, &screenshot, view, &pattern);
    }
}

#[test]
fn full_screen_shows_every_pattern_pixel_for_pixel() {
    let display = Display::start(SIZE);
    let projector = Projector::start("", &display.environment());
    let mut client = projector.controller();
    let screen = client.state().screen;
    assert_eq!(
        (screen.kind, screen.raster, screen.problem),
        (ScreenKind::FullScreen, SIZE, None)
    );
    check_all(&mut client, &screen.name, || display.screenshot());
}

#[test]
fn a_window_shows_every_pattern_pixel_for_pixel() {
    let display = Display::start(RasterSize {
        width: 640,
        height: 480,
    });
    let projector = Projector::start("--windowed 400x300", &display.environment());
    let mut client = projector.controller();
    let screen = client.state().screen;
    assert_eq!(
        (screen.kind, screen.raster, screen.problem),
        (ScreenKind::Window, SIZE, None)
    );
    check_all(&mut client, &screen.name, || display.window("projector"));
}

#[test]
fn changed_settings_are_on_the_screen_when_the_reply_comes() {
    let display = Display::start(SIZE);
    let projector = Projector::start("", &display.environment());
    let mut client = projector.controller();
    let mut watcher = projector.watcher();
    client.show(View::Coded);
    let mut all_shown = Vec::new();
    for command in [
        Command::SetLines {
            rows: 31,
            columns: 15,
        },
        Command::SetWidths {
            row_width_px: 1,
            column_width_px: 9,
        },
        Command::SetColours {
            colours: four().to_vec(),
            unary: Rgb::WHITE,
        },
        Command::Blank { on: true },
        Command::Blank { on: false },
    ] {
        let shown = client.change(command);
        assert_same(
            &display.screenshot(),
            &shown.pattern.raster(SIZE),
            &format!("{shown:?}"),
        );
        all_shown.push(ServerMessage::Shown(shown));
    }
    watcher.state();
    watcher
        .notices
        .retain(|notice| matches!(notice, ServerMessage::Shown(_)));
    assert_eq!(watcher.notices.split_off(1), all_shown);
    let grid = Grid::coded(31, 15, 1, 9, &four()).unwrap();
    assert_eq!(client.state().shown.pattern, grid.into());
}

#[test]
fn a_signal_closes_the_window_and_the_program_ends_with_0() {
    let display = Display::start(SIZE);
    let projector = Projector::start("", &display.environment());
    projector.signal("TERM");
    let (status, rest) = projector.ended();
    assert_eq!((status.code(), rest.as_str()), (Some(0), ""));
}

#[test]
fn an_unknown_monitor_is_refused_with_the_names_there_are() {
    let display = Display::start(SIZE);
    let environment = display.environment();
    let listed = run("screens --json", &environment);
    let listed: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
    let [screen] = listed["screens"].as_array().unwrap().as_slice() else {
        panic!("{listed}")
    };
    assert_eq!(
        (&screen["width"], &screen["height"]),
        (&400.into(), &300.into())
    );
    assert_eq!(screen["chosen"], true);
    let refused = run("--screen Nowhere-1 --listen 127.0.0.1:0", &environment);
    let text = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(1), "{text}");
    assert!(
        text.contains("Nowhere-1") && text.contains(screen["name"].as_str().unwrap()),
        "{text}"
    );
}
