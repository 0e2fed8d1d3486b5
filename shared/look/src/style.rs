//! The style of both windows, in light and in dark: quiet greys, so that the only colours are those on the wall, one
//! accent for what is chosen or to be done next, and three lamps.

use egui::{
    Color32, Context, CornerRadius, FontFamily, FontId, Stroke, Style, TextStyle, Theme, vec2,
};
use shared::pattern::Rgb;

/// What is chosen, or to be done next; in both themes.
pub const ACCENT: Color32 = Color32::from_rgb(38, 118, 214);
/// Something is as it should be.
pub const GOOD: Color32 = Color32::from_rgb(46, 160, 98);
/// Something is worth a look.
pub const FAIR: Color32 = Color32::from_rgb(214, 148, 38);
/// Something is wrong.
pub const BAD: Color32 = Color32::from_rgb(214, 72, 62);
/// Behind pictures, in both themes: colours are judged against dark.
pub const MAT: Color32 = Color32::from_gray(18);
/// Roundness of buttons, in points.
const RADIUS: CornerRadius = CornerRadius::same(6);

/// Sets the look of both themes.
pub fn install(context: &Context) {
    context.style_mut_of(Theme::Dark, dark);
    context.style_mut_of(Theme::Light, light);
}

/// A colour of the pattern as the monitor shows it.
#[must_use]
pub fn screen_colour(Rgb([red, green, blue]): Rgb) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

fn dark(style: &mut Style) {
    both(style);
    let visuals = &mut style.visuals;
    visuals.panel_fill = Color32::from_gray(24);
    visuals.window_fill = Color32::from_gray(34);
    visuals.faint_bg_color = Color32::from_gray(33);
    visuals.extreme_bg_color = Color32::from_gray(14);
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(52));
    visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, Color32::from_gray(205));
    visuals.widgets.inactive.weak_bg_fill = Color32::from_gray(50);
    visuals.warn_fg_color = Color32::from_rgb(250, 176, 66);
    visuals.error_fg_color = Color32::from_rgb(255, 110, 100);
}

fn light(style: &mut Style) {
    both(style);
    let visuals = &mut style.visuals;
    visuals.panel_fill = Color32::from_gray(240);
    visuals.window_fill = Color32::WHITE;
    visuals.faint_bg_color = Color32::WHITE;
    visuals.extreme_bg_color = Color32::from_gray(228);
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(216));
    visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, Color32::from_gray(40));
    visuals.widgets.inactive.weak_bg_fill = Color32::from_gray(230);
    visuals.warn_fg_color = Color32::from_rgb(158, 92, 0);
    visuals.error_fg_color = Color32::from_rgb(188, 32, 24);
}

fn both(style: &mut Style) {
    let font = |size| FontId::new(size, FontFamily::Proportional);
    style.text_styles = [
        (TextStyle::Small, font(12.0)),
        (TextStyle::Body, font(14.0)),
        (TextStyle::Button, font(14.0)),
        (TextStyle::Heading, font(19.0)),
        (
            TextStyle::Monospace,
            FontId::new(13.0, FontFamily::Monospace),
        ),
    ]
    .into();
    style.spacing.item_spacing = vec2(8.0, 8.0);
    style.spacing.button_padding = vec2(10.0, 4.0);
    style.spacing.interact_size.y = 26.0;
    style.spacing.combo_height = 460.0;
    style.visuals.selection.bg_fill = ACCENT;
    style.visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
    style.visuals.hyperlink_color = ACCENT;
    for widget in [
        &mut style.visuals.widgets.noninteractive,
        &mut style.visuals.widgets.inactive,
        &mut style.visuals.widgets.hovered,
        &mut style.visuals.widgets.active,
        &mut style.visuals.widgets.open,
    ] {
        widget.corner_radius = RADIUS;
    }
}
