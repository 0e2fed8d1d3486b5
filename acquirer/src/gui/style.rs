//! How the window looks: spacing, colours, and the few widgets that several panels share.

use eframe::egui::{
    self, Color32, CornerRadius, FontFamily, FontId, Response, RichText, Sense, Stroke, TextStyle,
    Ui, Vec2, vec2,
};
use shared::pattern::Rgb;

/// Width of the panel with the steps, in points.
pub(super) const SIDE_WIDTH: f32 = 352.0;
/// Space between groups of a panel, in points.
pub(super) const GAP: f32 = 10.0;
/// Something is as it should be.
pub(super) const GOOD: Color32 = Color32::from_rgb(46, 160, 98);
/// Something is worth a look.
pub(super) const FAIR: Color32 = Color32::from_rgb(214, 148, 38);
/// Something is wrong.
pub(super) const BAD: Color32 = Color32::from_rgb(214, 72, 62);
/// What is to be done next.
pub(super) const ACCENT: Color32 = Color32::from_rgb(28, 116, 190);
/// Behind pictures, in both themes: colours are judged against dark.
pub(super) const MAT: Color32 = Color32::from_gray(18);

/// Sets the look of the whole window, for both themes.
pub(super) fn apply(context: &egui::Context) {
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
        for widget in [
            &mut style.visuals.widgets.noninteractive,
            &mut style.visuals.widgets.inactive,
            &mut style.visuals.widgets.hovered,
            &mut style.visuals.widgets.active,
            &mut style.visuals.widgets.open,
        ] {
            widget.corner_radius = CornerRadius::same(5);
        }
        style.visuals.selection.bg_fill = ACCENT;
        style.visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
        style.visuals.hyperlink_color = ACCENT;
        // the usual themes print their text in middle grey
        let ink = if style.visuals.dark_mode { 212 } else { 32 };
        style.visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(ink);
        style.visuals.widgets.inactive.fg_stroke.color = Color32::from_gray(ink);
    });
}

/// A colour of the pattern on the screen.
pub(super) fn colour32(colour: Rgb) -> Color32 {
    let [r, g, b] = colour.0;
    Color32::from_rgb(r, g, b)
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
        .rect_filled(rect, CornerRadius::same(3), colour32(colour));
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
