//! The hues of the projected grid: what the thesis's button HIST shows.

use std::f32::consts::TAU;

use eframe::egui::{
    self, Align2, Color32, FontId, Rect, RichText, Sense, Ui, ecolor::Hsva, pos2, vec2,
};

use crate::gui::model::Model;

/// Shows the bars, from red round to red.
pub(super) fn show(model: &Model, ui: &mut Ui) {
    let recovered = model
        .live
        .picture
        .as_ref()
        .and_then(|p| p.recovered.as_ref());
    let Some((pixels, hues)) = recovered else {
        ui.add_space(6.0);
        ui.label(
            RichText::new(
                "The histogram needs the background: switch on Read, so that black and white are recorded.",
            )
            .weak(),
        );
        return;
    };
    ui.label(
        RichText::new(format!(
            "Hues of {pixels} recovered pixels of the projected grid"
        ))
        .small()
        .weak(),
    );
    let room = vec2(ui.available_width(), ui.available_height() - 2.0);
    let (rect, response) = ui.allocate_exact_size(room, Sense::hover());
    let most = hues.iter().copied().max().unwrap_or(0).max(1) as f32;
    let bars = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - 16.0));
    let width = bars.width() / hues.len().max(1) as f32;
    for (k, &count) in hues.iter().enumerate() {
        let hue = (k as f32 + 0.5) / hues.len() as f32;
        let left = bars.left() + k as f32 * width;
        let top = bars.bottom() - bars.height() * count as f32 / most;
        let bar = Rect::from_min_max(pos2(left, top), pos2(left + width - 1.0, bars.bottom()));
        let colour = Color32::from(Hsva::new(hue, 0.9, 0.9, 1.0));
        ui.painter()
            .rect_filled(bar, egui::CornerRadius::ZERO, colour);
    }
    let line = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter().hline(bars.x_range(), bars.bottom(), line);
    let ink = ui.visuals().weak_text_color();
    for (degrees, name) in [
        (0, "red"),
        (60, "yellow"),
        (120, "green"),
        (180, "cyan"),
        (240, "blue"),
        (300, "magenta"),
    ] {
        let share = degrees as f32 / 360.0;
        let at = pos2(bars.left() + share * bars.width(), rect.bottom());
        ui.painter().text(
            at,
            Align2::LEFT_BOTTOM,
            name,
            FontId::proportional(11.0),
            ink,
        );
    }
    if let Some(at) = response.hover_pos() {
        let share = ((at.x - bars.left()) / bars.width()).clamp(0.0, 0.999);
        let bin = (share * hues.len() as f32) as usize;
        let count = hues.get(bin).copied().unwrap_or(0);
        response.on_hover_text(format!(
            "hue {:.0} degrees: {count} pixels",
            (share * TAU).to_degrees()
        ));
    }
}
