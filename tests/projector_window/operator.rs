//! The operator's window on a display nobody sees, with real clicks: where to click is asked of the same window
//! drawn without a display.

use std::{
    thread,
    time::{Duration, Instant},
};

use egui_kittest::{Harness, kittest::Queryable};
use projector::{
    operator::{self, OperatorView, Panels, install_style, preview},
    screen::Monitor,
    state::Overview,
};
use shared::{
    pattern::{Pattern, Raster, RasterSize, Rgb},
    protocol::{Command, ProjectorState, ServerMessage, View},
};

use crate::{Client, Display, Projector};

const DESKTOP: RasterSize = RasterSize {
    width: 1440,
    height: 800,
};
const PATTERN: RasterSize = RasterSize {
    width: 320,
    height: 240,
};
pub(crate) const TITLE: &str = "projector - operator";
/// What the frame that draws without a display leaves free around the window, in points.
const MARGIN: f32 = 8.0;
/// Far longer than a drawing takes.
const PATIENCE: Duration = Duration::from_secs(60);

/// The operator's window drawn without a display, in the state that the projector is in.
pub(crate) struct Twin {
    harness: Harness<'static, (OperatorView, Panels)>,
}

impl Twin {
    fn new(size: RasterSize, state: ProjectorState) -> Self {
        Self::with_monitors(size, state, Vec::new())
    }

    pub(crate) fn with_monitors(
        size: RasterSize,
        state: ProjectorState,
        monitors: Vec<Monitor>,
    ) -> Self {
        let view = OperatorView {
            overview: Overview {
                state,
                members: Vec::new(),
                identifying: false,
                steps_left: 0,
                on_its_way: false,
            },
            monitors,
            listening: None,
            preview: None,
        };
        let draw = |ui: &mut egui::Ui, (view, panels): &mut (OperatorView, Panels)| {
            operator::ui(ui, view, panels);
        };
        let mut harness = Harness::builder()
            .with_size([
                size.width as f32 + 2.0 * MARGIN,
                size.height as f32 + 2.0 * MARGIN,
            ])
            .with_max_steps(16)
            .with_context_setup(install_style)
            .build_ui_state(draw, (view, Panels::default()));
        harness.run();
        Self { harness }
    }

    /// Where a part of the window lies.
    fn place(&self, role: egui::Role, name: &str) -> egui::Rect {
        in_window(self.harness.get_by_role_and_label(role, name).rect())
    }

    /// Where the part lies whose label contains some words.
    pub(crate) fn place_of(&self, words: &str) -> egui::Rect {
        in_window(self.harness.get_by_label_contains(words).rect())
    }

    fn click(&mut self, role: egui::Role, name: &str) {
        self.harness.get_by_role_and_label(role, name).click();
        self.harness.run();
    }
}

/// From the frame that draws without a display to the window itself.
fn in_window(rect: egui::Rect) -> egui::Rect {
    rect.translate(egui::Vec2::splat(-MARGIN))
}

/// Moves and clicks the mouse, or asks for windows: arguments separated by blanks.
fn xdotool(display: &Display, arguments: &str) {
    let words: Vec<&str> = arguments.split_whitespace().collect();
    display.xdotool(&words);
}

/// Waits until something is seen; `what` says what was not.
pub(crate) fn until(what: &str, mut seen: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !seen() {
        assert!(begin.elapsed() < PATIENCE, "{what}");
        thread::sleep(Duration::from_millis(100));
    }
}

/// Clicks in the operator's window.
pub(crate) fn click(display: &Display, place: egui::Rect) {
    let at = place.center();
    let (x, y) = (at.x.round(), at.y.round());
    xdotool(
        display,
        &format!("search --name ^{TITLE_PATTERN}$ mousemove --window %1 {x} {y} click 1"),
    );
}

/// A projector in a small window, the operator's window beside it.
struct Rig {
    display: Display,
    projector: Projector,
    watcher: Client,
}

impl Rig {
    fn start() -> Self {
        let display = Display::start(DESKTOP);
        let projector = Projector::start("--windowed 320x240 --operator", &display.environment());
        xdotool(
            &display,
            &format!("search --sync --name ^{TITLE_PATTERN}$ windowmove --sync 340 10"),
        );
        let watcher = projector.watcher();
        Self {
            display,
            projector,
            watcher,
        }
    }

    fn twin(&mut self) -> Twin {
        let size = self.display.window(TITLE).size();
        Twin::new(size, self.watcher.state())
    }

    /// Clicks in the operator's window.
    fn click(&self, place: egui::Rect) {
        click(&self.display, place);
    }

    /// Waits until a part of the operator's window has a pixel of this colour.
    fn wait_for(&self, place: egui::Rect, colour: Rgb) {
        let (x, y) = (place.min.x as u32, place.min.y as u32);
        let size = RasterSize {
            width: place.width() as u32,
            height: place.height() as u32,
        };
        let has = |part: &Raster| part.bytes().chunks(3).any(|pixel| pixel == colour.0);
        until(&format!("no {colour} at {place:?}"), || {
            has(&cut(&self.display.window(TITLE), x, y, size))
        });
    }

    /// Waits until another picture is on the wall, and compares the wall with it.
    fn wall(&mut self) -> Pattern {
        let shown = loop {
            if let ServerMessage::Shown(shown) = self.watcher.next().expect("the projector goes on")
            {
                break shown;
            }
        };
        let expected = shown.pattern.raster(PATTERN);
        assert!(
            self.display.window("projector") == expected,
            "{:?}",
            shown.pattern
        );
        shown.pattern
    }
}

/// The title as a search pattern without spaces.
pub(crate) const TITLE_PATTERN: &str = "projector.-.operator";

#[test]
fn a_click_changes_the_wall_and_every_client_is_told() {
    let mut rig = Rig::start();
    let twin = rig.twin();
    rig.click(twin.place(egui::Role::Button, "White"));
    assert_eq!(rig.wall(), Pattern::WHITE);
    assert_eq!(rig.watcher.state().view, View::White);

    rig.click(twin.place(egui::Role::Button, "PRMVS"));
    rig.wall();
    let mut twin = rig.twin();
    rig.click(twin.place(egui::Role::ComboBox, "Second colour"));
    twin.click(egui::Role::ComboBox, "Second colour");
    let azure = twin.place(egui::Role::Button, "azure");
    rig.wait_for(azure, Rgb([0, 128, 255]));
    rig.click(azure);
    let Pattern::Grid(grid) = rig.wall() else {
        panic!("a grid")
    };
    assert_eq!(grid.colours()[1], Rgb([0, 128, 255]));
    assert_eq!(rig.watcher.state().grid.coded, grid);
}

#[test]
fn what_a_client_sets_is_drawn_in_the_window() {
    let mut rig = Rig::start();
    let mut client = rig.projector.controller();
    let twin = rig.twin();
    client.change(Command::SetLines {
        rows: 31,
        columns: 15,
    });
    for view in [
        View::Coded,
        View::TestCard,
        View::Solid {
            colour: Rgb([1, 128, 254]),
        },
    ] {
        let shown = client.show(view);
        let size = twin.harness.state().1.preview_px();
        let expected = preview::small(&preview::Original {
            pattern: shown.pattern,
            raster: shown.raster,
            size,
        });
        // the preview stands where it stood for the first picture
        let place = twin.place(egui::Role::Image, "Preview: Identify card");
        let (x, y) = (place.min.x.round() as u32, place.min.y.round() as u32);
        until("the preview is another picture", || {
            cut(&rig.display.window(TITLE), x, y, size) == expected
        });
    }
}

pub(crate) fn cut(picture: &Raster, x: u32, y: u32, size: RasterSize) -> Raster {
    Raster::from_fn(size, |dx, dy| picture.pixel(x + dx, y + dy))
}
