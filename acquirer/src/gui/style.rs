//! How the window looks: spacing, colours, and the few widgets that several panels share.

use eframe::egui::{
    self, Color32, CornerRadius, FontFamily, FontId, Response, RichText, Sense, Stroke, TextStyle,
    Ui, Vec2, vec2,
};
pub(super) use look::style::{ACCENT, BAD, FAIR, GOOD, MAT, screen_colour};
use shared::pattern::Rgb;

/// Width of the panel with the steps, in points.
pub(super) const SIDE_WIDTH: f32 = 352.0;
/// Space between groups of a panel, in points.
pub(super) const GAP: f32 = 10.0;
/// Sets the look of the whole window, for both themes: that of both programs, with somewhat smaller type, for this
/// window holds more.
pub(super) fn apply(context: &egui::Context) {
    look::style::install(context);
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(8.0, 6.0);
        style.spacing.button_padding = vec2(10.0, 5.0);
        style.spacing.interact_size.y = 24.0;
        style.spacing.slider_width = 140.0;
        let font = |size| FontId::new(size, FontFamily::Proportional);
        style.text_styles.insert(TextStyle::Heading, font(17.0));
        style.text_styles.insert(TextStyle::Body, font(13.5));
        style.text_styles.insert(TextStyle::Button, font(13.5));
        style.text_styles.insert(TextStyle::Small, font(11.5));
    });
}

/// The button for what is to be done next.
pub(super) fn primary(ui: &mut Ui, enabled: bool, text: &str) -> Response {
    let text = RichText::new(text).strong();
    let button = if enabled {
        egui::Button::new(text.color(Color32::WHITE)).fill(ACCENT)
    } else {
        egui::Button::new(text)
    };
    sized(ui, enabled, button, vec2(ui.available_width(), 32.0))
}

/// A button for a step of several: the one that comes next stands out.
pub(super) fn step(ui: &mut Ui, enabled: bool, text: &str, is_next: bool) -> Response {
    if is_next {
        return primary(ui, enabled, text);
    }
    sized(
        ui,
        enabled,
        egui::Button::new(text),
        vec2(ui.available_width(), 32.0),
    )
}

/// The button for what is to be done next, as wide as a share of the room.
pub(super) fn wide_primary(ui: &mut Ui, text: &str, width: f32) -> Response {
    let text = RichText::new(text).strong().color(Color32::WHITE);
    sized(
        ui,
        true,
        egui::Button::new(text).fill(ACCENT),
        vec2(width, 27.0),
    )
}

/// An ordinary button that is as wide as a share of the room.
pub(super) fn wide(ui: &mut Ui, enabled: bool, text: &str, width: f32) -> Response {
    sized(ui, enabled, egui::Button::new(text), vec2(width, 27.0))
}

fn sized(ui: &mut Ui, enabled: bool, button: egui::Button<'_>, size: Vec2) -> Response {
    let shown = ui.add_enabled_ui(enabled, |ui| ui.add_sized(size, button));
    shown.inner
}

/// Half of a row, for two buttons side by side.
pub(super) fn half(ui: &Ui) -> f32 {
    0.5 * (ui.available_width() - ui.spacing().item_spacing.x)
}

/// A heading with a sentence that explains.
pub(super) fn heading(ui: &mut Ui, title: &str, explanation: &str) {
    ui.heading(title);
    if !explanation.is_empty() {
        ui.label(RichText::new(explanation).small().weak());
    }
    ui.add_space(2.0);
}

/// A small filled circle: how something is.
pub(super) fn lamp(ui: &mut Ui, colour: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 14.0), Sense::hover());
    ui.painter().circle_filled(rect.center(), 4.5, colour);
}

/// A patch of a colour.
pub(super) fn swatch(ui: &mut Ui, colour: Rgb, size: Vec2) -> Response {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let rim = ui.visuals().widgets.noninteractive.bg_stroke.color;
    ui.painter()
        .rect_filled(rect, CornerRadius::same(3), screen_colour(colour));
    ui.painter().rect_stroke(
        rect,
        CornerRadius::same(3),
        Stroke::new(1.0, rim),
        egui::StrokeKind::Inside,
    );
    response
}

/// A frame round things that belong together.
pub(super) fn card<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    let frame = egui::Frame::group(ui.style())
        .inner_margin(8.0)
        .fill(ui.visuals().faint_bg_color);
    let shown = frame.show(ui, |ui| {
        ui.set_width(ui.available_width());
        add(ui)
    });
    shown.inner
}

/// A name and its value in a two-column grid.
pub(super) fn row(ui: &mut Ui, name: &str, value: impl Into<egui::WidgetText>) {
    ui.label(RichText::new(name).weak());
    ui.label(value);
    ui.end_row();
}

/// Good from the first limit on, fair from the second.
pub(super) fn judged(percent: f64, [good, fair]: [f64; 2]) -> Color32 {
    if percent >= good {
        GOOD
    } else if percent >= fair {
        FAIR
    } else {
        BAD
    }
}
