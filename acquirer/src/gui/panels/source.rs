//! Where pictures come from: camera, format, size, rate (the thesis's buttons D, C, F, S and its menu of sizes).

use std::collections::BTreeSet;

use eframe::egui::{self, RichText, Ui};

use crate::{
    camera::{CameraSpec, v4l2::CameraInfo},
    gui::{
        events::{FileJob, Job},
        model::{Model, Side},
        style::{self, GAP},
    },
};

/// Sizes that are offered when the camera does not tell its own.
const USUAL_SIZES: [(u32, u32); 4] = [(640, 480), (1280, 720), (1280, 960), (1920, 1080)];
/// Rates that are offered, in frames per second.
const RATES: [u32; 5] = [10, 15, 25, 30, 60];

/// Shows the panel.
pub(in crate::gui) fn show(model: &mut Model, ui: &mut Ui) {
    style::heading(
        ui,
        "Camera and rig",
        "Where pictures come from, and how the rig is.",
    );
    camera(model, ui);
    ui.add_space(GAP);
    about(model, ui);
}

/// What to do next, below the panel and always in sight.
pub(in crate::gui) fn next(model: &mut Model, ui: &mut Ui) {
    if style::primary(ui, model.rig.is_ok(), "Next: colours").clicked() {
        model.side = Side::Colours;
    }
}

fn camera(model: &mut Model, ui: &mut Ui) {
    let before = model.source.clone();
    ui.label(RichText::new("Camera").strong());
    let chosen = name(model);
    let hint = "The source of pictures (D): a webcam, a simulated room, or a recorded scan";
    let combo = egui::ComboBox::from_id_salt("camera")
        .selected_text(chosen)
        .width(ui.available_width() - 8.0)
        .show_ui(ui, |ui| cameras(model, ui));
    combo.response.on_hover_text(hint);
    let is_device = matches!(model.source.camera, None | Some(CameraSpec::Device(_)));
    ui.add_enabled_ui(is_device, |ui| format(model, ui));
    if !is_device {
        let text = "A simulated room and a recording have their own size and rate.";
        ui.label(RichText::new(text).small().weak());
    }
    ui.horizontal(|ui| {
        if ui
            .button("Look again")
            .on_hover_text("Look for cameras and scans again")
            .clicked()
        {
            model.ask_files(FileJob::FindSources);
        }
        let identify = ui.add_enabled(model.is_ready(), egui::Button::new("Identify"));
        let hint =
            "The projector shows for five seconds which one it is, with a frame that must be sharp";
        if identify.on_hover_text(hint).clicked() {
            model.ask(Job::Identify);
        }
    });
    if before != model.source {
        model.open_source();
    }
}

fn name(model: &Model) -> String {
    match &model.source.camera {
        Some(CameraSpec::Device(path)) => {
            match model.sources.camera(model.source.camera.as_ref()) {
                Some(info) => format!("{} ({})", info.name, path.display()),
                None => path.display().to_string(),
            }
        }
        Some(CameraSpec::Simulated(room)) => format!("Simulated room: {room}"),
        Some(CameraSpec::Replay(dir)) => format!("Recording: {}", dir.display()),
        None => "The first camera that is plugged in".to_owned(),
    }
}

fn cameras(model: &mut Model, ui: &mut Ui) {
    let camera = &mut model.source.camera;
    ui.label(RichText::new("Cameras").small().weak());
    for info in &model.sources.cameras {
        let spec = CameraSpec::Device(info.path.clone());
        let text = format!("{} ({})", info.name, info.path.display());
        let response = ui.selectable_value(camera, Some(spec), text);
        if let Some(problem) = &info.problem {
            response.on_hover_text(problem);
        }
    }
    if model.sources.cameras.is_empty() {
        ui.label("none is plugged in");
    }
    ui.separator();
    ui.label(RichText::new("Simulated rooms").small().weak());
    for room in &model.sources.rooms {
        let spec = CameraSpec::Simulated(room.clone());
        ui.selectable_value(camera, Some(spec), room);
    }
    if !model.sources.scans.is_empty() {
        ui.separator();
        ui.label(RichText::new("Recordings").small().weak());
        for dir in model.sources.scans.iter().take(12) {
            let spec = CameraSpec::Replay(dir.clone());
            ui.selectable_value(camera, Some(spec), dir.display().to_string());
        }
    }
}

fn format(model: &mut Model, ui: &mut Ui) {
    let info = model.sources.camera(model.source.camera.as_ref());
    let (formats, sizes) = (
        pixel_formats(info),
        sizes(info, &model.source.settings.pixel_format),
    );
    let settings = &mut model.source.settings;
    egui::Grid::new("format").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label("Format").on_hover_text(
            "How frames are packed on the cable (C and F). Uncompressed ones keep colours apart best.",
        );
        let shown = if settings.pixel_format.is_empty() {
            "the best there is"
        } else {
            &settings.pixel_format
        };
        let combo = egui::ComboBox::from_id_salt("pixel format")
            .selected_text(shown.to_owned())
            .show_ui(ui, |ui| {
                let format = &mut settings.pixel_format;
                ui.selectable_value(format, String::new(), "the best there is");
                for (code, words) in formats {
                    ui.selectable_value(format, code.clone(), format!("{code}  {words}"));
                }
            });
        combo.response.labelled_by(label.id);
        ui.end_row();
        let label = ui.label("Image size").on_hover_text("Pixels of the camera's picture");
        let mut size = (settings.width, settings.height);
        let combo = egui::ComboBox::from_id_salt("size")
            .selected_text(format!("{} x {}", size.0, size.1))
            .show_ui(ui, |ui| {
                for choice in sizes {
                    ui.selectable_value(&mut size, choice, format!("{} x {}", choice.0, choice.1));
                }
            });
        combo.response.labelled_by(label.id);
        (settings.width, settings.height) = size;
        ui.end_row();
        let label = ui.label("At most").on_hover_text("The fastest rate that is taken");
        let combo = egui::ComboBox::from_id_salt("rate")
            .selected_text(format!("{} per second", settings.max_rate))
            .show_ui(ui, |ui| {
                for rate in RATES {
                    let text = format!("{rate} per second");
                    ui.selectable_value(&mut settings.max_rate, f64::from(rate), text);
                }
            });
        combo.response.labelled_by(label.id);
        ui.end_row();
    });
}

fn pixel_formats(info: Option<&CameraInfo>) -> Vec<(String, String)> {
    let formats = info.into_iter().flat_map(|info| &info.formats);
    formats
        .filter(|format| format.usable)
        .map(|format| (format.fourcc.clone(), format.description.clone()))
        .collect()
}

fn sizes(info: Option<&CameraInfo>, format: &str) -> Vec<(u32, u32)> {
    let formats = info.into_iter().flat_map(|info| &info.formats);
    let own: BTreeSet<(u32, u32)> = formats
        .filter(|f| f.usable && (format.is_empty() || f.fourcc == format))
        .flat_map(|f| f.sizes.iter().map(|size| (size.width, size.height)))
        .collect();
    if own.is_empty() {
        USUAL_SIZES.to_vec()
    } else {
        own.into_iter().collect()
    }
}

/// What is connected.
fn about(model: &Model, ui: &mut Ui) {
    let Ok(rig) = &model.rig else {
        return;
    };
    let screen = &rig.projector.screen;
    let grid = &rig.projector.grid;
    style::card(ui, |ui| {
        egui::Grid::new("about")
            .num_columns(2)
            .spacing([12.0, 4.0])
            .show(ui, |ui| {
                style::row(ui, "Pictures", &rig.format);
                style::row(
                    ui,
                    "Projector",
                    format!("{} ({})", screen.name, screen.raster),
                );
                let (rows, columns) = (grid.coded.rows(), grid.coded.columns());
                style::row(ui, "Lines", format!("{rows} rows, {columns} columns"));
                ui.label(RichText::new("Drawn in").weak());
                ui.horizontal(|ui| {
                    for &colour in grid.coded.colours() {
                        style::swatch(ui, colour, egui::vec2(18.0, 14.0));
                    }
                    ui.label(RichText::new("unary").weak());
                    style::swatch(ui, grid.unary, egui::vec2(18.0, 14.0));
                });
                ui.end_row();
            });
        let camera_px = rig.size;
        for warning in warnings(rig, camera_px) {
            ui.colored_label(style::FAIR, warning);
        }
    });
}

fn warnings(rig: &crate::gui::events::RigInfo, [width, height]: [u32; 2]) -> Vec<String> {
    use shared::pattern::{CameraScale, RasterSize};
    let (grid, raster) = (&rig.projector.grid.coded, rig.projector.screen.raster);
    let mut warnings = grid.warnings(raster);
    let scale = CameraScale::filling(raster, RasterSize { width, height });
    warnings.extend(grid.camera_warnings(raster, scale));
    warnings
}
