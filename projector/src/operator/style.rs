//! The frames of the operator's window.

use egui::{CornerRadius, Frame, Margin, Stroke, Ui};

/// The strip at the top.
pub(super) fn bar(ui: &Ui) -> Frame {
    Frame::new()
        .fill(ui.visuals().faint_bg_color)
        .inner_margin(Margin::symmetric(14, 9))
}

/// A column of groups.
pub(super) fn column(ui: &Ui) -> Frame {
    Frame::new()
        .fill(ui.visuals().panel_fill)
        .inner_margin(Margin::same(8))
}

/// A group of settings.
pub(super) fn card(ui: &Ui) -> Frame {
    Frame::new()
        .fill(ui.visuals().faint_bg_color)
        .stroke(ui.visuals().widgets.noninteractive.bg_stroke)
        .corner_radius(CornerRadius::same(8))
        .inner_margin(Margin::symmetric(14, 11))
}

/// The line around what is chosen.
pub(super) fn chosen(ui: &Ui, is: bool) -> Stroke {
    if is {
        Stroke::new(2.0, ui.visuals().selection.bg_fill)
    } else {
        ui.visuals().widgets.noninteractive.bg_stroke
    }
}
