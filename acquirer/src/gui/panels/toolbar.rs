//! The bar at the top: what fills the middle, and how the window looks.

use eframe::egui::{self, RichText, Ui};

use crate::gui::{
    events::FileJob,
    model::{Model, Tab},
    preferences::Theme,
};

const TABS: [(Tab, &str, &str); 4] = [
    (Tab::Live, "Live", "What the camera sees now (key 1)"),
    (
        Tab::Steps,
        "Steps",
        "What every step of the reading makes of a picture (key 2)",
    ),
    (Tab::Result, "Result", "The object's shape (key 3)"),
    (Tab::Compare, "Compare", "Two scans side by side (key 4)"),
];

/// Shows the bar.
pub(in crate::gui) fn show(model: &mut Model, ui: &mut Ui) {
    ui.horizontal(|ui| {
        for (tab, name, hint) in TABS {
            let text = RichText::new(name).size(15.0);
            ui.selectable_value(&mut model.tab, tab, text)
                .on_hover_text(hint);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let help = ui.toggle_value(&mut model.show_help, "Help");
            help.on_hover_text("The way through a scan, and all keys (F1)");
            ui.menu_button("View", |ui| view_menu(model, ui))
                .response
                .on_hover_text("Light or dark, size of everything");
            load_menu(model, ui);
        });
    });
}

fn view_menu(model: &mut Model, ui: &mut Ui) {
    ui.label(RichText::new("Theme").weak());
    let theme = &mut model.preferences.theme;
    ui.radio_value(theme, Theme::System, "As the desktop");
    ui.radio_value(theme, Theme::Light, "Light");
    ui.radio_value(theme, Theme::Dark, "Dark");
    ui.separator();
    ui.label(RichText::new("Size of everything").weak());
    for (percent, zoom) in [(75, 0.75), (100, 1.0), (125, 1.25), (150, 1.5), (200, 2.0)] {
        let current = &mut model.preferences.zoom;
        ui.radio_value(current, zoom, format!("{percent} %"));
    }
    ui.separator();
    ui.checkbox(&mut model.show_messages, "Messages");
}

/// Loads an earlier scan, as the result or beside it.
fn load_menu(model: &mut Model, ui: &mut Ui) {
    let menu = ui.menu_button("Load scan", |ui| {
        ui.set_min_width(280.0);
        if let Some((dir, place)) = super::compare::choose_scan(model, ui) {
            model.ask_files(FileJob::Read(dir, place));
            ui.close();
        }
    });
    if menu.response.clicked() {
        model.ask_files(FileJob::FindSources);
    }
    menu.response
        .on_hover_text("Read an earlier scan and show it");
}
