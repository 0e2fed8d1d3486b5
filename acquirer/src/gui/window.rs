//! The window: events in, panels out, and how long that takes.

use std::{
    path::PathBuf,
    sync::mpsc::sync_channel,
    thread,
    time::{Duration, Instant},
};

use eframe::egui::{self, Ui};

use super::{
    Startup,
    events::FileJob,
    keys,
    live_picture::LivePlace,
    model::{Model, Ports, Side, Tab},
    panels::{
        colours, compare, help, live, messages, result, scan, source, status, steps, toolbar,
    },
    preferences::Preferences,
    sources::Source,
    style::{self, SIDE_WIDTH},
    waker::Waker,
    worker::{FileWorker, RigWorker, Teller},
};
use crate::{cli::open_rig, session::Cancel};

/// Names the file that gets a list of what stands in the window.
const WIDGETS: &str = "ACQUIRER_WIDGETS";
/// Jobs that can wait.
const JOBS: usize = 8;
/// Events between two repaints; the threads wait when the window is slower.
const EVENTS: usize = 64;
/// Longest time between two repaints, so that Ctrl-C ends the window without a frame or event.
const IDLE_REPAINT: Duration = Duration::from_secs(1);

/// The window with the file that its settings are kept in.
pub(super) struct Window {
    model: Model,
    cancel: Cancel,
    kept_in: Option<PathBuf>,
}

impl Window {
    /// Starts the two threads.
    pub(super) fn new(
        startup: Startup,
        (preferences, told): (Preferences, Option<String>),
        cancel: Cancel,
        created: &eframe::CreationContext<'_>,
    ) -> std::io::Result<Self> {
        let context = &created.egui_ctx;
        style::apply(context);
        look::widget_list::start_if_wanted(context, WIDGETS);
        let (job_sender, jobs) = sync_channel(JOBS);
        let (file_sender, file_jobs) = sync_channel(JOBS);
        let (events_sender, events) = sync_channel(EVENTS);
        let live = LivePlace::default();
        let source = first_source(&startup, &preferences);
        let kept_in = startup.remember.clone();
        let teller = Teller {
            events: events_sender,
            waker: Waker::of(created),
        };
        let ports = Ports {
            jobs: job_sender,
            files: file_sender,
            events,
            live: live.clone(),
            cancel: cancel.clone(),
            cancel_files: cancel.beside(),
            log: startup.log.clone(),
        };
        let places = (startup.rig.projector.clone(), startup.out.clone());
        let mut model = Model::new(ports, preferences, source.clone(), places, startup.run_all);
        model.error = told;
        let files = FileWorker {
            config: startup.config.clone(),
            out: startup.out.clone(),
            cancel: model.ports.cancel_files.clone(),
            jobs: file_jobs,
            teller: teller.clone(),
        };
        let rig = RigWorker {
            open: Box::new(open_rig),
            rig: startup.rig,
            source,
            config: startup.config,
            out: startup.out,
            calibration: startup.calibration,
            read_live: model.wanted_reading(),
            cancel: cancel.clone(),
            jobs,
            live,
            teller,
        };
        let start = |name: &str| thread::Builder::new().name(name.into());
        start("rig").spawn(move || rig.run())?;
        start("files").spawn(move || files.run())?;
        model.ask_files(FileJob::FindSources);
        Ok(Self {
            model,
            cancel,
            kept_in,
        })
    }
}

/// The camera of the command line, else the one that was used last, else the first that is plugged in.
fn first_source(startup: &Startup, preferences: &Preferences) -> Source {
    let remembered = preferences.camera.parse().ok();
    let settings = preferences.camera_settings.clone();
    Source {
        camera: startup.rig.camera.clone().or(remembered),
        settings: settings.unwrap_or_else(|| startup.config.camera.clone()),
    }
}

/// All panels of the window.
pub(super) fn show(model: &mut Model, ui: &mut Ui) {
    let context = ui.ctx().clone();
    context.set_theme(egui::ThemePreference::from(model.preferences.theme));
    keys::handle(model, &context);
    egui::Panel::top("toolbar").show(ui, |ui| {
        ui.add_space(4.0);
        toolbar::show(model, ui);
        ui.add_space(4.0);
    });
    egui::Panel::bottom("status").show(ui, |ui| status::show(model, ui));
    if model.show_messages {
        egui::Panel::bottom("messages")
            .resizable(true)
            .default_size(110.0)
            .show(ui, |ui| messages::list(model, ui));
    }
    egui::Panel::right("side")
        .resizable(false)
        .exact_size(SIDE_WIDTH)
        .show(ui, |ui| side(model, ui));
    egui::CentralPanel::default().show(ui, |ui| {
        messages::error(model, ui);
        messages::warnings(model, ui);
        match model.tab {
            Tab::Live => live::show(model, ui),
            Tab::Steps => steps::show(model, ui),
            Tab::Result => result::show(model, ui),
            Tab::Compare => compare::show(model, ui),
        }
    });
    help::show(model, &context);
    model.pictures.forget_unused();
}

fn side(model: &mut Model, ui: &mut Ui) {
    model.controls.are_shown = false;
    ui.add_space(6.0);
    ui.columns(3, |columns| {
        let sides = [
            (Side::Source, "Source", "Camera and rig (F2)"),
            (Side::Colours, "Colours", "Pick the grid's colours (F3)"),
            (Side::Scan, "Scan", "Record and judge (F4)"),
        ];
        for (ui, (side, name, hint)) in columns.iter_mut().zip(sides) {
            ui.vertical_centered_justified(|ui| {
                ui.selectable_value(&mut model.side, side, name)
                    .on_hover_text(hint);
            });
        }
    });
    ui.separator();
    egui::Panel::bottom("tasks")
        .resizable(false)
        .show(ui, |ui| {
            ui.add_space(4.0);
            messages::tasks(model, ui);
            ui.add_space(4.0);
        });
    if model.side != Side::Scan {
        egui::Panel::bottom("next").resizable(false).show(ui, |ui| {
            ui.add_space(6.0);
            match model.side {
                Side::Source => source::next(model, ui),
                Side::Colours => colours::next(model, ui),
                Side::Scan => {}
            }
            ui.add_space(6.0);
        });
    }
    egui::ScrollArea::vertical()
        .id_salt(("side", model.side as u8))
        .auto_shrink(false)
        .show(ui, |ui| match model.side {
            Side::Source => source::show(model, ui),
            Side::Colours => colours::show(model, ui),
            Side::Scan => scan::show(model, ui),
        });
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        let begun = Instant::now();
        let context = ui.ctx().clone();
        self.model.take_events();
        if self.cancel.is_quitting() {
            context.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        context.request_repaint_after(IDLE_REPAINT);
        context.set_zoom_factor(self.model.preferences.zoom);
        show(&mut self.model, ui);
        let inside = ui.max_rect().size();
        self.model.preferences.window = [inside.x, inside.y];
        let ms = |seconds: f32| 1000.0 * seconds;
        let whole = frame.info().cpu_usage.unwrap_or(0.0);
        let own = begun.elapsed().as_secs_f32();
        self.model.repaints.count(ms(own), ms(whole));
    }

    fn on_exit(&mut self) {
        tracing::info!("{}", self.model.repaints.sentence());
        let camera = self.model.source.camera.as_ref();
        let preferences = &mut self.model.preferences;
        preferences.camera = camera.map_or_else(String::new, ToString::to_string);
        preferences.camera_settings = Some(self.model.source.settings.clone());
        if let Some(path) = &self.kept_in
            && let Err(error) = preferences.save(path)
        {
            tracing::warn!("{error}");
        }
        self.cancel.quit();
    }
}
