//! A window under test, and what its threads would tell it.

use std::sync::mpsc::{Receiver, sync_channel};

use egui_kittest::{Harness, SnapshotOptions, kittest::Queryable};
use image::{Rgb as Pixel, RgbImage};
use rig_tests::measure::{Repeats, SimulatedScan};
use shared::{
    pattern::{GridSettings, Palette, RasterSize, Rgb},
    protocol::{ProjectorState, ScreenInfo, ScreenKind, Shown, View},
    simulation::Scene,
};

use crate::gui::{
    events::{Event, FileJob, Job, RigInfo},
    live_picture::LivePlace,
    model::{Model, Ports},
    preferences::{Preferences, Theme},
    sources::Source,
    style, window,
};
use crate::{
    camera::{CameraSettings, load_scene},
    pipeline::{
        Projected,
        colour_choice::{ColourSelection, ColourTrial, choose_colours},
    },
    session::Cancel,
};

pub(super) const RASTER: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};

/// The window, and what it has asked for.
pub(super) struct Tested {
    pub(super) harness: Harness<'static, Model>,
    pub(super) jobs: Receiver<Job>,
    pub(super) files: Receiver<FileJob>,
    pub(super) cancel: Cancel,
}

impl Tested {
    pub(super) fn new(theme: Theme) -> Self {
        let (job_sender, jobs) = sync_channel(8);
        let (file_sender, files) = sync_channel(8);
        let (_, events) = sync_channel(1);
        let cancel = Cancel::default();
        let ports = Ports {
            jobs: job_sender,
            files: file_sender,
            events,
            live: LivePlace::default(),
            cancel: cancel.clone(),
        };
        let preferences = Preferences {
            theme,
            ..Preferences::default()
        };
        let source = Source {
            camera: None,
            settings: CameraSettings::default(),
        };
        let places = ("bench:4460".to_owned(), "scan".into());
        let model = Model::new(ports, preferences, source, places, false);
        let harness = Harness::builder()
            .with_size([1280.0, 720.0])
            .with_context_setup(style::apply)
            .build_ui_state(|ui, model: &mut Model| window::show(model, ui), model);
        Self {
            harness,
            jobs,
            files,
            cancel,
        }
    }

    pub(super) fn tell(&mut self, event: Event) {
        self.harness.state_mut().take_event(event);
        self.harness.run_steps(3);
    }

    pub(super) fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).scroll_to_me();
        self.harness.run_steps(3);
        self.harness.get_by_label(label).click();
        self.harness.run_steps(3);
    }

    pub(super) fn connected() -> Self {
        let mut tested = Self::new(Theme::Dark);
        tested.tell(Event::Connected(Box::new(rig())));
        tested
    }

    pub(super) fn says(&self, text: &str) -> bool {
        let mut found = self.harness.query_all_by_label_contains(text);
        found.next().is_some()
    }
}

pub(super) fn rig() -> RigInfo {
    let grid = GridSettings::default();
    RigInfo {
        camera: "a webcam (uvcvideo)".into(),
        source: Source {
            camera: None,
            settings: CameraSettings::default(),
        },
        format: "640x480 YUYV at 30 frames per second".into(),
        size: [640, 480],
        projector: ProjectorState {
            screen: ScreenInfo {
                kind: ScreenKind::FullScreen,
                name: "HDMI-1".into(),
                raster: RASTER,
                problem: None,
            },
            shown: Shown {
                serial: 1,
                pattern: grid.coded.clone().into(),
                raster: RASTER,
                presented_ns: 0,
            },
            grid,
            view: View::Coded,
            blank: false,
            controller: Some("acquirer".into()),
            selection: None,
        },
    }
}

/// A grey wall under each colour of the palette.
pub(super) fn measured() -> ColourSelection {
    let wall = |colour: Rgb| {
        RgbImage::from_fn(160, 120, |x, y| {
            let on_line = x % 20 < 5 || y % 20 < 5;
            let noise = ((x * 7919 + y * 104_729) % 5) as u8;
            Pixel(
                colour
                    .0
                    .map(|c| 20 + noise + if on_line { c / 2 } else { 0 }),
            )
        })
    };
    let full = |light: u8| RgbImage::from_pixel(160, 120, Pixel([light; 3]));
    let palette = Palette::default();
    let shots = palette.colours().iter();
    let trial = ColourTrial {
        black: vec![full(22), full(23)],
        white: vec![full(150), full(151)],
        shots: shots
            .map(|entry| (entry.clone(), wall(entry.colour)))
            .collect(),
    };
    let projected = Projected {
        pattern: GridSettings::default(),
        raster: RASTER,
    };
    choose_colours(&trial, &projected, None).unwrap()
}

/// A scan of the simulated cube on disk.
pub(super) fn cube_scan() -> tempfile::TempDir {
    let scene: Scene = load_scene("cube").unwrap();
    let repeats = Repeats {
        references: 2,
        coded: 1,
        unary: 1,
    };
    let scan = SimulatedScan::record(&scene, &GridSettings::default(), repeats);
    let dir = tempfile::tempdir().unwrap();
    scan.save(&dir.path().join("cube")).unwrap();
    dir
}

fn snapshots() -> SnapshotOptions {
    // letters of another driver differ in their edges
    SnapshotOptions::new()
        .output_path("../tests/snapshots")
        .threshold(1.6)
        .max_failed_pixels(400_usize)
}

/// Compares with the snapshot of this name.
pub(super) fn looks_as_before(mut tested: Tested, name: &str) -> Tested {
    tested.harness.run_steps(2);
    tested.harness.snapshot_options(name, &snapshots());
    tested
}
