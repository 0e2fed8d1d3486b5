//! The operator's window without a display: what it says of a state, and what a click asks for.

use egui::accesskit::Toggled;
use egui_kittest::{
    Harness, SnapshotOptions,
    kittest::{NodeT, Queryable},
};
use projector::{
    operator::{self, Action, OperatorView, Panels, install_style, preview},
    screen::Monitor,
    state::{ConnectionId, State},
};
use shared::{
    pattern::{GridSettings, RasterSize, Rgb},
    protocol::{Command, Hello, Role, ScreenInfo, ScreenKind, VERSION, View},
};

const RASTER: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};
const CONTROLLER: ConnectionId = ConnectionId(1);

/// A window before a state, as the program runs it: what is asked for is done, and seen in the next drawing.
struct Desk {
    state: State,
    panels: Panels,
    monitors: Vec<Monitor>,
    asked: Vec<Action>,
    preview: Option<(egui::TextureHandle, u64)>,
}

impl Desk {
    fn new() -> Self {
        let screen = ScreenInfo {
            kind: ScreenKind::FullScreen,
            name: "HDMI-1".into(),
            raster: RASTER,
            problem: None,
        };
        let mut state = State::new(screen, GridSettings::default(), View::Coded);
        assert!(state.presented(1, RASTER, 1_000).is_some());
        let monitor = |name: &str, x, primary| Monitor {
            name: name.into(),
            x,
            y: 0,
            width: 1024,
            height: 768,
            refresh_hz: Some(60.0),
            primary,
        };
        Self {
            state,
            panels: Panels::default(),
            monitors: vec![monitor("eDP-1", 0, true), monitor("HDMI-1", 1024, false)],
            asked: Vec::new(),
            preview: None,
        }
    }

    fn with_acquirer(mut self) -> Self {
        let hello = Hello {
            version: VERSION,
            role: Role::Controller,
            name: "acquirer on bench-2".into(),
            take_over: false,
            token: None,
        };
        assert!(self.state.join(CONTROLLER, &hello).is_ok());
        self
    }

    fn draw(&mut self, ui: &mut egui::Ui) {
        let overview = self.state.overview();
        let serial = overview.state.shown.serial;
        let view = OperatorView {
            preview: self.small_picture(ui.ctx(), serial),
            overview,
            monitors: self.monitors.clone(),
            listening: "127.0.0.1:4460".parse().ok(),
        };
        for action in operator::ui(ui, &view, &mut self.panels) {
            if let Action::Command(command) = &action {
                self.obey(command.clone());
            }
            self.asked.push(action);
        }
    }

    fn obey(&mut self, command: Command) {
        let effects = self
            .state
            .apply(command)
            .expect("the window asks for what can be done");
        if let Some(picture) = effects.present {
            assert!(
                self.state
                    .presented(picture.serial, RASTER, 2_000)
                    .is_some()
            );
        }
    }

    fn small_picture(
        &mut self,
        context: &egui::Context,
        serial: u64,
    ) -> Option<egui::TextureHandle> {
        if self.preview.as_ref().is_none_or(|(_, of)| *of != serial) {
            let size = RasterSize {
                width: 404,
                height: 303,
            };
            let picture = preview::small(&preview::Original {
                pattern: self.state.shown().pattern.clone(),
                raster: RASTER,
                size,
            });
            let image = egui::ColorImage::from_rgb([404, 303], picture.bytes());
            let texture = context.load_texture("preview", image, egui::TextureOptions::NEAREST);
            self.preview = Some((texture, serial));
        }
        self.preview.as_ref().map(|(texture, _)| texture.clone())
    }
}

fn window(desk: Desk) -> Harness<'static, Desk> {
    sized(desk, [1080.0, 720.0], 1.0, egui::Theme::Dark)
}

fn sized(desk: Desk, size: [f32; 2], scale: f32, theme: egui::Theme) -> Harness<'static, Desk> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_pixels_per_point(scale)
        .with_theme(theme)
        .with_max_steps(16)
        .with_context_setup(install_style)
        .build_ui_state(|ui, desk: &mut Desk| desk.draw(ui), desk);
    harness.run();
    harness
}

fn click(harness: &mut Harness<'_, Desk>, role: egui::Role, name: &str) {
    harness.get_by_role_and_label(role, name).click();
    harness.run();
}

fn button(harness: &mut Harness<'_, Desk>, name: &str) {
    click(harness, egui::Role::Button, name);
}

fn last_command(harness: &Harness<'_, Desk>) -> Command {
    match harness.state().asked.last() {
        Some(Action::Command(command)) => command.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_kind_of_picture_is_a_click_away() {
    let mut window = window(Desk::new());
    let red = Rgb([255, 0, 0]);
    for (name, view) in [
        ("Two-colour", View::TwoColour),
        ("Unary", View::Unary),
        ("Solid", View::Solid { colour: red }),
        ("Black", View::Black),
        ("White", View::White),
        ("Test card", View::TestCard),
        ("Ramp", View::Ramp),
        ("PRMVS", View::Coded),
    ] {
        button(&mut window, name);
        assert_eq!(window.state().state.report().view, view);
        let tile = window.get_by_role_and_label(egui::Role::Button, name);
        assert_eq!(
            tile.accesskit_node().toggled(),
            Some(Toggled::True),
            "{name}"
        );
    }
}

#[test]
fn each_of_the_four_colours_and_the_unary_colour_is_one_of_sixteen() {
    let mut window = window(Desk::new());
    for (menu, colour) in [
        ("First colour", "azure"),
        ("Second colour", "cyan"),
        ("Third colour", "pale blue"),
        ("Fourth colour", "orange"),
        ("Unary colour", "rose"),
    ] {
        click(&mut window, egui::Role::ComboBox, menu);
        button(&mut window, colour);
    }
    let grid = window.state().state.report().grid;
    let chosen: Vec<String> = grid.coded.colours().iter().map(Rgb::to_string).collect();
    assert_eq!(chosen, ["#0080ff", "#00ffff", "#8080ff", "#ff8000"]);
    assert_eq!(grid.unary.to_string(), "#ff0080");
}

#[test]
fn rows_and_columns_are_chosen_from_the_five_numbers() {
    let mut window = window(Desk::new());
    click(&mut window, egui::Role::ComboBox, "Rows");
    for number in ["15", "31", "63", "127", "255"] {
        window.get_by_role_and_label(egui::Role::Button, number);
    }
    button(&mut window, "63");
    click(&mut window, egui::Role::ComboBox, "Columns");
    button(&mut window, "127");
    let (rows, columns) = (63, 127);
    assert_eq!(last_command(&window), Command::SetLines { rows, columns });
    assert!(
        window
            .query_by_label_contains("127 columns are too many for the camera")
            .is_some()
    );
}

#[test]
fn what_a_client_sets_is_what_the_window_says() {
    let mut window = window(Desk::new().with_acquirer());
    assert!(
        window
            .query_by_label("acquirer on bench-2 controls")
            .is_some()
    );
    let commands = [
        Command::SetLines {
            rows: 31,
            columns: 15,
        },
        Command::SetWidths {
            row_width_px: 3,
            column_width_px: 9,
        },
        Command::Show { view: View::White },
    ];
    for command in commands {
        let effects = window.state_mut().state.request(CONTROLLER, command);
        let picture = effects.expect("it may").present;
        if let Some(picture) = picture {
            let shown = window
                .state_mut()
                .state
                .presented(picture.serial, RASTER, 3_000);
            assert!(shown.is_some());
        }
    }
    window.run();
    let value = |role, name: &str| window.get_by_role_and_label(role, name).value();
    assert_eq!(value(egui::Role::ComboBox, "Rows").as_deref(), Some("31"));
    assert_eq!(
        value(egui::Role::SpinButton, "Column width").as_deref(),
        Some("9 px")
    );
    let tile = window.get_by_role_and_label(egui::Role::Button, "White");
    assert_eq!(tile.accesskit_node().toggled(), Some(Toggled::True));
    assert!(window.query_by_label("Preview: Solid white").is_some());
    assert!(window.state().asked.is_empty(), "to look is not to ask");
}

#[test]
fn blanking_and_moving_to_another_monitor_are_asked_for_once() {
    let mut window = window(Desk::new());
    button(&mut window, "Blank");
    assert!(window.state().state.report().blank);
    button(&mut window, "Show again");
    assert!(!window.state().state.report().blank);
    window.get_by_label_contains("eDP-1").click();
    window.run();
    assert_eq!(
        window.state().asked.last(),
        Some(&Action::MoveTo("eDP-1".into()))
    );
    let before = window.state().asked.len();
    window.get_by_label_contains("HDMI-1 1024").click();
    window.run();
    assert_eq!(
        window.state().asked.len(),
        before,
        "the picture is there already"
    );
}

#[test]
fn doubtful_grids_are_warned_of() {
    let mut window = window(Desk::new());
    let red = Rgb([255, 0, 0]);
    for command in [
        Command::SetWidths {
            row_width_px: 60,
            column_width_px: 1,
        },
        Command::SetColours {
            colours: vec![red, Rgb([0, 255, 0]), red, Rgb::WHITE],
            unary: red,
        },
    ] {
        window.state_mut().obey(command);
    }
    window.run();
    for part in ["touch", "too thin", "are both red"] {
        assert!(
            window.query_all_by_label_contains(part).next().is_some(),
            "{part}"
        );
    }
}

#[test]
fn it_looks_as_it_did_in_dark_and_in_light() {
    let mut dark = window(Desk::new().with_acquirer());
    dark.snapshot_options("operator_dark", &tolerant());
    let mut desk = Desk::new();
    desk.obey(Command::Show {
        view: View::TestCard,
    });
    let mut light = sized(desk, [640.0, 360.0], 2.0, egui::Theme::Light);
    light.snapshot_options("operator_light_small", &tolerant());
    let mut results = dark.take_snapshot_results();
    results.extend_harness(&mut light);
    results.unwrap();
}

/// Another version of the software driver may round a few edges of letters otherwise.
fn tolerant() -> SnapshotOptions {
    SnapshotOptions::new().threshold(1.0).max_failed_pixels(600)
}

#[test]
fn warnings_of_the_log_are_shown_until_they_are_dismissed() {
    let mut window = window(Desk::new());
    let told = "a connection was not accepted: too many open files";
    let panels = &mut window.state_mut().panels;
    panels.warn(vec![told.into(), "another".into(), told.into()]);
    window.run();
    let shown = window.get_by_label("A connection was not accepted: too many open files");
    assert!(shown.rect().is_positive());
    button(&mut window, "Dismiss");
    assert!(window.query_by_label("Warnings").is_none());
}
