//! The way through a scan in a few sentences, and all keys.

use eframe::egui::{self, RichText};

use crate::gui::{keys::SHORTCUTS, model::Model};

const STEPS: [(&str, &str); 5] = [
    (
        "Source",
        "Choose camera and size. The picture should hold the whole lit scene, and nothing should be clipped.",
    ),
    (
        "Colours",
        "Measure all sixteen on the scene, and apply the best four.",
    ),
    (
        "Without object",
        "Record the scene as it is, look at its quality, keep it or take it again.",
    ),
    (
        "With object",
        "Put the object in and record again; keep it, and the shape is computed.",
    ),
    (
        "Result",
        "Turn the shape with the mouse, look at the table, save the scan, load others to compare.",
    ),
];

/// Shows the help over everything.
pub(in crate::gui) fn show(model: &mut Model, context: &egui::Context) {
    if !model.show_help {
        return;
    }
    let shown = egui::Modal::new(egui::Id::unique("help")).show(context, |ui| {
        ui.set_width(620.0);
        ui.heading("From start to a saved scan");
        for (k, (name, text)) in STEPS.iter().enumerate() {
            ui.label(RichText::new(format!("{}  {name}", k + 1)).strong());
            ui.label(*text);
        }
        ui.separator();
        ui.heading("Keys");
        let half = SHORTCUTS.len().div_ceil(2);
        ui.columns(2, |columns| {
            for (column, keys) in columns.iter_mut().zip(SHORTCUTS.chunks(half)) {
                egui::Grid::new(("keys", keys[0].words))
                    .num_columns(2)
                    .show(column, |ui| {
                        for shortcut in keys {
                            ui.monospace(shortcut.key.name());
                            ui.label(shortcut.words);
                            ui.end_row();
                        }
                    });
            }
        });
        ui.separator();
        ui.button("Close").clicked()
    });
    if shown.inner || shown.should_close() {
        model.show_help = false;
    }
}
