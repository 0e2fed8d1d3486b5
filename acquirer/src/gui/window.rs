//! What the window shows: live picture and results in the middle, the steps of a scan at the right, the rig's
//! state at the bottom.

use std::{
    path::PathBuf,
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{Receiver, SyncSender, sync_channel},
    },
    thread,
    time::Duration,
};

use eframe::egui::{self, Color32, RichText};
use shared::stage::Stage;

use super::{
    Startup,
    events::{Event, Job, LiveFrame, ReadScan, RigInfo},
    worker::{LiveSlot, Worker},
};
use crate::{
    pipeline::colour_choice::ColourSelection,
    session::{Cancel, Latency, Progress},
};

/// Jobs that can wait.
const JOBS: usize = 8;
/// Events between two repaints; the worker waits when the window is slower.
const EVENTS: usize = 64;
/// Lines of messages that are kept.
const MESSAGES: usize = 200;
/// Width of the panel with the steps, in points.
const STEPS_WIDTH: f32 = 330.0;
/// Longest time between two repaints, so that Ctrl-C ends the window without a frame or event.
const IDLE_REPAINT: Duration = Duration::from_millis(250);
const GOOD: Color32 = Color32::from_rgb(60, 160, 90);
const BAD: Color32 = Color32::from_rgb(200, 70, 60);

/// The window's state: changed here alone, by the operator and by the worker's events.
pub(super) struct Window {
    jobs: SyncSender<Job>,
    events: Receiver<Event>,
    live: LiveSlot,
    cancel: Cancel,
    rig: Result<RigInfo, String>,
    address: String,
    busy: bool,
    progress: Option<Progress>,
    latency: Option<Latency>,
    selection: Option<ColourSelection>,
    recorded: [Option<PathBuf>; 2],
    read: Option<ReadScan>,
    textures: Vec<(String, egui::TextureHandle)>,
    live_texture: Option<egui::TextureHandle>,
    live_frame: Option<LiveFrame>,
    messages: Vec<String>,
    tab: usize,
}

impl Window {
    /// Starts the worker.
    pub(super) fn new(
        startup: Startup,
        cancel: Cancel,
        context: &egui::Context,
    ) -> std::io::Result<Self> {
        let (job_sender, jobs) = sync_channel(JOBS);
        let (events_sender, events) = sync_channel(EVENTS);
        let live: LiveSlot = Arc::new(Mutex::new(None));
        let window = Self {
            jobs: job_sender,
            events,
            live: live.clone(),
            cancel: cancel.clone(),
            rig: Err("connecting".into()),
            address: startup.rig.projector.clone(),
            busy: startup.run_all,
            progress: None,
            latency: None,
            selection: None,
            recorded: [None, None],
            read: None,
            textures: Vec::new(),
            live_texture: None,
            live_frame: None,
            messages: Vec::new(),
            tab: 0,
        };
        let repaint = context.clone();
        let worker = Worker {
            startup,
            cancel,
            jobs,
            events: events_sender,
            live,
            repaint,
        };
        thread::Builder::new()
            .name("rig".into())
            .spawn(move || worker.run())?;
        Ok(window)
    }

    fn take_events(&mut self, context: &egui::Context) {
        while let Ok(event) = self.events.try_recv() {
            self.take_event(event, context);
        }
        let newest = self
            .live
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(frame) = newest {
            let size = [
                frame.picture.width() as usize,
                frame.picture.height() as usize,
            ];
            let image = egui::ColorImage::from_rgb(size, frame.picture.as_raw());
            let options = egui::TextureOptions::LINEAR;
            match &mut self.live_texture {
                Some(texture) => texture.set(image, options),
                None => self.live_texture = Some(context.load_texture("live", image, options)),
            }
            self.live_frame = Some(frame);
        }
    }

    fn take_event(&mut self, event: Event, context: &egui::Context) {
        match event {
            Event::Connected(info) => {
                self.say(format!("connected: {}", info.camera));
                self.rig = Ok(*info);
            }
            Event::Disconnected(reason) => {
                if self.rig.as_ref().err() != Some(&reason) {
                    self.say(reason.clone());
                }
                self.rig = Err(reason);
                self.busy = false;
            }
            Event::Progress(progress) => self.progress = Some(progress),
            Event::Latency(latency) => {
                self.say(format!(
                    "latency {:.0} ms, at most {:.0} ms",
                    latency.timing.latency.ms,
                    latency.timing.settled_ms()
                ));
                self.latency = Some(latency);
            }
            Event::Colours(selection) => {
                for reason in &selection.reasons {
                    self.say(reason.clone());
                }
                self.selection = Some(*selection);
                self.recorded = [None, None];
            }
            Event::Recorded(stage, dir) => {
                self.say(format!("{stage} recorded into {}", dir.display()));
                self.recorded[usize::from(stage == Stage::Object)] = Some(dir);
            }
            Event::Read(read) => self.show_read(*read, context),
            Event::NewScan => {
                self.recorded = [None, None];
                self.say("a new scan begins".into());
            }
            Event::Failed(reason) => {
                self.say(reason);
                self.progress = None;
            }
            Event::Idle => {
                self.busy = false;
                self.progress = None;
            }
        }
    }

    fn show_read(&mut self, read: ReadScan, context: &egui::Context) {
        for line in &read.figures {
            self.say(line.clone());
        }
        let load = |(caption, picture): &(String, image::RgbImage)| {
            let size = [picture.width() as usize, picture.height() as usize];
            let image = egui::ColorImage::from_rgb(size, picture.as_raw());
            (
                caption.clone(),
                context.load_texture(caption, image, egui::TextureOptions::LINEAR),
            )
        };
        self.textures = read.pictures.iter().map(load).collect();
        self.tab = self.textures.len();
        self.read = Some(read);
    }

    fn say(&mut self, message: String) {
        self.messages.push(message);
        let excess = self.messages.len().saturating_sub(MESSAGES);
        self.messages.drain(..excess);
    }

    fn ask(&mut self, job: Job) {
        self.busy = self.jobs.try_send(job).is_ok() || self.busy;
    }

    fn steps(&mut self, ui: &mut egui::Ui) {
        ui.add_space(4.0);
        ui.heading("Scan");
        let ready = self.rig.is_ok() && !self.busy;
        let [before, after] = self.recorded.clone().map(|dir| dir.is_some());
        let steps = [
            (
                Job::PickColours,
                "1  Pick colours",
                "Shows all sixteen colours on the scene and takes the best four.",
                true,
                self.selection.is_some(),
            ),
            (
                Job::Record(Stage::Background),
                "2  Record without object",
                "The scene as it is (the thesis's button F).",
                true,
                before,
            ),
            (
                Job::Record(Stage::Object),
                "3  Record with object",
                "Put the object in first (the thesis's button S).",
                before,
                after,
            ),
            (
                Job::Read,
                "4  Read the scan",
                "Labels, shifts, surface, report.",
                before || after,
                self.read.is_some(),
            ),
        ];
        for (job, label, hint, possible, done) in steps {
            ui.horizontal(|ui| {
                let button = egui::Button::new(label).min_size(egui::vec2(210.0, 30.0));
                if ui
                    .add_enabled(ready && possible, button)
                    .on_hover_text(hint)
                    .clicked()
                {
                    self.ask(job);
                }
                if done {
                    ui.colored_label(GOOD, "done");
                }
            });
        }
        ui.horizontal(|ui| {
            if ui
                .add_enabled(ready && before, egui::Button::new("New scan"))
                .clicked()
            {
                self.ask(Job::NewScan);
            }
            if ui
                .add_enabled(self.busy, egui::Button::new("Cancel"))
                .clicked()
            {
                self.cancel.cancel();
            }
        });
        if let Some(progress) = &self.progress {
            let share = progress.done as f32 / progress.of.max(1) as f32;
            ui.add(egui::ProgressBar::new(share).text(&progress.what));
        }
        ui.separator();
        self.colours(ui);
    }

    fn colours(&self, ui: &mut egui::Ui) {
        ui.heading("Colours");
        let Some(selection) = &self.selection else {
            ui.weak("Not picked yet: the projector's own are used.");
            return;
        };
        let most = selection
            .colours
            .iter()
            .map(|c| c.recovered_px)
            .max()
            .unwrap_or(1)
            .max(1);
        egui::Grid::new("colours")
            .num_columns(3)
            .spacing([8.0, 2.0])
            .show(ui, |ui| {
                for entry in &selection.colours {
                    let [r, g, b] = entry.colour.0;
                    let place = selection.best.iter().position(|&c| c == entry.colour);
                    let mut name = RichText::new(&entry.name);
                    if place.is_some() {
                        name = name.strong();
                    }
                    ui.label(name);
                    let share = entry.recovered_px as f32 / most as f32;
                    let bar = egui::ProgressBar::new(share)
                        .desired_width(130.0)
                        .desired_height(10.0);
                    ui.add(bar.fill(Color32::from_rgb(r, g, b)))
                        .on_hover_text(format!("{} pixels recovered", entry.recovered_px));
                    let unary = if entry.colour == selection.unary {
                        "unary"
                    } else {
                        ""
                    };
                    ui.label(match place {
                        Some(k) => format!("colour {} {unary}", k + 1),
                        None => unary.to_owned(),
                    });
                    ui.end_row();
                }
            });
    }

    fn picture(&mut self, ui: &mut egui::Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.selectable_value(&mut self.tab, 0, "live");
            for (k, (caption, _)) in self.textures.iter().enumerate() {
                ui.selectable_value(&mut self.tab, k + 1, caption);
            }
        });
        let texture = match self.tab.checked_sub(1) {
            None => self.live_texture.as_ref(),
            Some(k) => self.textures.get(k).map(|(_, texture)| texture),
        };
        match texture {
            Some(texture) => {
                let room = ui.available_size();
                let size = texture.size_vec2();
                let scale = (room.x / size.x).min(room.y / size.y).max(0.01);
                ui.centered_and_justified(|ui| {
                    ui.add(
                        egui::Image::new((texture.id(), size * scale)).alt_text("camera picture"),
                    );
                });
            }
            None => {
                ui.centered_and_justified(|ui| match &self.rig {
                    Ok(_) => ui.label("waiting for the first frame"),
                    Err(reason) => ui.colored_label(BAD, reason),
                });
            }
        }
    }

    fn status(&self, ui: &mut egui::Ui) {
        ui.horizontal_wrapped(|ui| {
            match &self.rig {
                Ok(info) => {
                    let screen = &info.projector.screen;
                    ui.colored_label(
                        GOOD,
                        format!("projector {} ({})", self.address, screen.raster),
                    );
                    ui.separator();
                    ui.label(&info.camera);
                }
                Err(_) => {
                    ui.colored_label(BAD, format!("projector {}: not connected", self.address));
                }
            }
            if let Some(frame) = &self.live_frame {
                ui.separator();
                ui.label(format!(
                    "frame {}, {:.1} taken per second, {} passed over",
                    frame.number, frame.rate_hz, frame.lost
                ));
            }
            if let Some(latency) = &self.latency {
                ui.separator();
                ui.label(format!("latency {:.0} ms", latency.timing.latency.ms));
            }
            if let Some(read) = &self.read {
                ui.separator();
                ui.label(format!("report: {}", read.report.display()));
            }
        });
    }
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.take_events(&context);
        if self.cancel.is_quitting() {
            context.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        context.request_repaint_after(IDLE_REPAINT);
        egui::Panel::bottom("status").show(ui, |ui| self.status(ui));
        egui::Panel::right("steps")
            .exact_size(STEPS_WIDTH)
            .show(ui, |ui| {
                egui::ScrollArea::vertical()
                    .id_salt("steps")
                    .show(ui, |ui| self.steps(ui));
            });
        egui::Panel::bottom("messages")
            .resizable(true)
            .default_size(120.0)
            .show(ui, |ui| {
                egui::ScrollArea::vertical()
                    .id_salt("messages")
                    .stick_to_bottom(true)
                    .show(ui, |ui| {
                        for message in &self.messages {
                            ui.add(egui::Label::new(RichText::new(message)).wrap());
                        }
                        ui.allocate_space(egui::vec2(ui.available_width(), 0.0));
                    });
            });
        egui::CentralPanel::default().show(ui, |ui| self.picture(ui));
    }

    fn on_exit(&mut self) {
        self.cancel.quit();
    }
}
