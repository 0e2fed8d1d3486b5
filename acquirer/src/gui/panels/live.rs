//! The live picture with what lies over it, and the switches for both.

use eframe::egui::{self, Rect, RichText, Sense, Ui, Vec2, pos2, vec2};

use super::{histogram, overlay};
use crate::{
    gui::{events::FileJob, model::Model, style},
    session::LiveMode,
};

/// Shows switches and picture.
pub(in crate::gui) fn show(model: &mut Model, ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| switches(model, ui));
    ui.add_space(2.0);
    if model.preferences.histogram {
        egui::Panel::bottom("histogram")
            .exact_size(112.0)
            .show(ui, |ui| histogram::show(model, ui));
    }
    let room = ui.available_rect_before_wrap();
    ui.painter()
        .rect_filled(room, egui::CornerRadius::same(4), style::MAT);
    let Some(picture) = model.live.picture.clone() else {
        nothing(model, ui, room);
        return;
    };
    let [width, height] = picture.image.size.map(|side| side as f32);
    let target = fitted(vec2(width, height), room);
    let response = ui.interact(room, ui.scope_id().with("live picture"), Sense::hover());
    let texture = model.pictures.texture(ui.ctx(), "live", &picture.image);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let painter = ui.painter_at(room);
    painter.image(texture.id(), target, whole, egui::Color32::WHITE);
    if let Some(marks) = &picture.marks {
        let texture = model.pictures.texture(ui.ctx(), "live marks", marks);
        painter.image(texture.id(), target, whole, egui::Color32::WHITE);
    }
    if let Some(reading) = &picture.reading {
        let place = overlay::Place::new(target, vec2(width, height));
        overlay::draw(
            &painter,
            &reading.overlay,
            place,
            model.preferences.overlays,
        );
        overlay::legend(&painter, room, reading, model.preferences.overlays);
    }
    let described = describe(model);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, described.clone()));
}

/// The picture in words, for those who do not see it.
fn describe(model: &Model) -> String {
    let reading = model.live.picture.as_ref().and_then(|p| p.reading.as_ref());
    match reading {
        Some(reading) => format!(
            "live picture, {}: {} of {} crossings read",
            words(reading.mode),
            reading.crossings,
            reading.possible
        ),
        None => "live picture".to_owned(),
    }
}

/// The largest place for a picture in a room.
pub(super) fn fitted(size: Vec2, room: Rect) -> Rect {
    let scale = (room.width() / size.x).min(room.height() / size.y);
    Rect::from_center_size(room.center(), size * scale.max(0.0))
}

fn switches(model: &mut Model, ui: &mut Ui) {
    ui.spacing_mut().button_padding.x = 7.0;
    ui.spacing_mut().item_spacing.x = 4.0;
    let mut update = !model.live.frozen;
    ui.toggle_value(&mut update, "Update")
        .on_hover_text("Show every new picture, or hold this one (U)");
    model.live.frozen = !update;
    let mut read = model.preferences.read_live;
    let toggled = ui.toggle_value(&mut read, "Read").on_hover_text(
        "Read the coded grid in every frame (R). Black and white are recorded first; the grid stays on the wall.",
    );
    if toggled.changed() {
        model.set_read_live(read);
    }
    mode(model, ui);
    ui.separator();
    let preferences = &mut model.preferences;
    ui.selectable_value(&mut preferences.after, false, "Before")
        .on_hover_text("The camera's picture before processing (ONE, key O)");
    ui.selectable_value(&mut preferences.after, true, "After")
        .on_hover_text("The picture after processing (ONE, key O). While frames are read.");
    ui.toggle_value(&mut preferences.subtract, "No background").on_hover_text(
        "Processing leaves the projected grid alone (SUB, key B). Off: the share of white light that arrives.",
    );
    ui.toggle_value(&mut preferences.histogram, "Histogram")
        .on_hover_text(
            "Hues of the projected grid, and its recovered pixels in the status bar (HIST, key H)",
        );
    ui.separator();
    ui.label(RichText::new("Overlay").weak());
    let overlays = &mut preferences.overlays;
    for (on, name, hint) in [
        (
            &mut overlays.grid,
            "Grid",
            "The lines that were read, in their projected colours (G)",
        ),
        (
            &mut overlays.labels,
            "Labels",
            "Row and column at each crossing (L)",
        ),
        (
            &mut overlays.holes,
            "Holes",
            "Crossings without a label, coloured by the reason (X)",
        ),
        (
            &mut overlays.clipping,
            "Clipping",
            "Too bright is red, black is blue (C)",
        ),
        (
            &mut overlays.shadow,
            "Shadow",
            "Where the projector's light does not reach (M)",
        ),
    ] {
        ui.toggle_value(on, name).on_hover_text(hint);
    }
}

/// The ways of live reading, each with what it is for.
const MODES: [(LiveMode, &str, &str); 3] = [
    (
        LiveMode::Dynamic,
        "moving",
        "Dynamic: the coded grid stays on the wall, and every frame is read by itself",
    ),
    (
        LiveMode::Static,
        "still",
        "Static: nothing moves; four frames of the coded grid are averaged, the unary grid gives the geometry",
    ),
    (
        LiveMode::Tracking,
        "tracking",
        "Tracking: things move slowly; the unary grid stays on the wall, crossings keep their labels, and the coded \
         grid is shown now and then",
    ),
];

/// The word for a way of live reading.
fn words(mode: LiveMode) -> &'static str {
    let known = MODES.iter().find(|(known, ..)| *known == mode);
    known.map_or("", |(_, word, _)| word)
}

/// How frames are read live.
fn mode(model: &mut Model, ui: &mut Ui) {
    let before = model.preferences.live_mode;
    let mut chosen = before;
    let combo = egui::ComboBox::from_id_salt("live mode")
        .selected_text(words(before))
        .width(78.0)
        .show_ui(ui, |ui| {
            for (mode, name, hint) in MODES {
                ui.selectable_value(&mut chosen, mode, name)
                    .on_hover_text(hint);
            }
        });
    let response = combo
        .response
        .on_hover_text("What the scene does while frames are read");
    let named = format!("The scene is: {}", words(before));
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::ComboBox, ui.is_enabled(), named.clone())
    });
    if chosen != before {
        model.set_live_mode(chosen);
    }
}

/// Where a picture should be and is not: why, and what to do.
fn nothing(model: &mut Model, ui: &mut Ui, room: Rect) {
    let column = Rect::from_center_size(room.center(), vec2(room.width().min(460.0), 170.0));
    ui.scope_builder(egui::UiBuilder::new().max_rect(column), |ui| {
        ui.visuals_mut().override_text_color = Some(egui::Color32::from_gray(225));
        ui.vertical_centered(|ui| match model.rig.clone() {
            Ok(rig) => {
                ui.spinner();
                ui.label("Waiting for the first picture of");
                ui.label(rig.camera);
            }
            Err(reason) => {
                ui.label(RichText::new("No live picture").heading());
                ui.label(&reason);
                ui.label(
                    RichText::new(
                        "Start the projector program, or choose a camera at the right; it is tried again every two \
                         seconds.",
                    )
                    .weak(),
                );
                if ui.button("Look for cameras again").clicked() {
                    model.ask_files(FileJob::FindSources);
                }
            }
        });
    });
}
