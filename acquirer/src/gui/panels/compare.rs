//! Two scans side by side, seen from the same place.

use std::path::PathBuf;

use eframe::egui::{self, RichText, Ui};
use shared::stage::Stage;

use super::{result, shape};
use crate::gui::{
    events::{FileJob, Place},
    model::{Model, Tab},
    open_scan::OpenScan,
};

/// Scans that are offered.
const OFFERED: usize = 10;

/// Shows both.
pub(in crate::gui) fn show(model: &mut Model, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let menu = ui.menu_button("Choose the left scan", |ui| {
            chosen(model, ui, Place::Result);
        });
        if menu.response.clicked() {
            model.ask_files(FileJob::FindSources);
        }
        let menu = ui.menu_button("Choose the right scan", |ui| {
            chosen(model, ui, Place::Beside);
        });
        if menu.response.clicked() {
            model.ask_files(FileJob::FindSources);
        }
        ui.separator();
        result::colouring(&mut model.preferences.colour_by_picture, ui);
    });
    let (left, right) = (model.result.take(), model.beside.take());
    egui::Panel::bottom("compared figures")
        .resizable(false)
        .show(ui, |ui| {
            ui.add_space(4.0);
            table(&[left.as_ref(), right.as_ref()], ui);
            ui.add_space(2.0);
        });
    let room = ui.available_rect_before_wrap();
    let halves = room.split_left_right_at_fraction(0.5);
    for (k, (half, scan)) in [halves.0, halves.1]
        .into_iter()
        .zip([&left, &right])
        .enumerate()
    {
        let half = egui::UiBuilder::new().max_rect(half.shrink2(egui::vec2(3.0, 0.0)));
        ui.scope_builder(half, |ui| match scan {
            Some(scan) => {
                ui.label(RichText::new(scan.dir.display().to_string()).strong());
                let by_picture = model.preferences.colour_by_picture;
                let pictures = (&mut model.pictures, ["left surface", "right surface"][k]);
                shape::show(scan, &mut model.look, by_picture, pictures, ui);
            }
            None => {
                ui.centered_and_justified(|ui| ui.label("No scan is chosen."));
            }
        });
    }
    (model.result, model.beside) = (left, right);
}

fn chosen(model: &mut Model, ui: &mut Ui, place: Place) {
    ui.set_min_width(280.0);
    if let Some((dir, _)) = choose_scan(model, ui) {
        model.ask_files(FileJob::Read(dir, place));
        model.tab = Tab::Compare;
        ui.close();
    }
}

/// Lets the operator choose a scan from those that lie near, or by its path.
pub(super) fn choose_scan(model: &mut Model, ui: &mut Ui) -> Option<(PathBuf, Place)> {
    let mut chosen = None;
    ui.label(RichText::new("Scans here, the newest first").small().weak());
    for dir in model.sources.scans.iter().take(OFFERED) {
        if ui.button(dir.display().to_string()).clicked() {
            chosen = Some((dir.clone(), Place::Result));
        }
    }
    if model.sources.scans.is_empty() {
        ui.label("none yet");
    }
    ui.separator();
    ui.horizontal(|ui| {
        let label = ui.label("Folder");
        let edit = egui::TextEdit::singleline(&mut model.load_name).hint_text("another one");
        ui.add(edit.desired_width(150.0)).labelled_by(label.id);
        let may = !model.load_name.trim().is_empty();
        if ui.add_enabled(may, egui::Button::new("Load")).clicked() {
            chosen = Some((model.load_name.trim().into(), Place::Result));
        }
    });
    chosen
}

/// The figures of both, line by line.
fn table(scans: &[Option<&OpenScan>; 2], ui: &mut Ui) {
    let figures = scans.map(|scan| scan.map(figures));
    egui::Grid::new("compared")
        .num_columns(3)
        .spacing([24.0, 3.0])
        .striped(true)
        .show(ui, |ui| {
            ui.label("");
            for scan in scans {
                let name = scan.map_or_else(|| "-".to_owned(), OpenScan::name);
                ui.label(RichText::new(name).strong());
            }
            ui.end_row();
            for (k, name) in FIGURES.into_iter().enumerate() {
                ui.label(RichText::new(name).weak());
                for scan in &figures {
                    ui.label(scan.as_ref().map_or("-", |scan| &scan[k]));
                }
                ui.end_row();
            }
        });
}

const FIGURES: [&str; 6] = [
    "Read without object",
    "Read with object",
    "Vertices shifted",
    "Largest shift",
    "Surface points",
    "Object's height",
];

fn figures(scan: &OpenScan) -> [String; 6] {
    let none = || "-".to_owned();
    let read = |stage| {
        scan.stage(stage).map_or_else(none, |view| {
            let quality = &view.quality;
            format!(
                "{:.1} % of {}",
                quality.coverage_percent(),
                quality.possible
            )
        })
    };
    let summary = &scan.summary;
    let shifts = summary.shifts.as_ref();
    let difference = summary.difference.as_ref();
    [
        read(Stage::Background),
        read(Stage::Object),
        shifts.map_or_else(none, |s| s.vertices.to_string()),
        shifts.map_or_else(none, |s| format!("{:.2} px", s.largest_px)),
        summary
            .surface
            .as_ref()
            .map_or_else(none, |s| s.points.to_string()),
        difference.map_or_else(none, |d| format!("{:.1} mm", d.largest_mm)),
    ]
}
