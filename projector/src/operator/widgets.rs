//! Parts that several cards are made of.

use egui::{
    Atom, Button, Color32, ComboBox, CornerRadius, Grid, Id, Rect, Response, RichText, Role,
    Stroke, StrokeKind, Theme, Ui, WidgetInfo, vec2,
};
pub(super) use look::style::screen_colour;
use shared::pattern::{Palette, Rgb};

use super::style;

/// Side of a colour's square beside its name, in points.
const SWATCH: f32 = 16.0;

/// A group of settings under a heading, as wide as there is room.
pub(super) fn card(ui: &mut Ui, heading: &str, content: impl FnOnce(&mut Ui)) {
    style::card(ui).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.label(RichText::new(heading).strong());
        content(ui);
    });
}

/// A square of a colour, to stand before its name.
pub(super) fn swatch(colour: Rgb) -> Atom<'static> {
    Atom::paint(vec2(SWATCH, SWATCH), move |ui, args| {
        let line = ui.visuals().widgets.noninteractive.bg_stroke;
        let painter = ui.painter();
        painter.rect(
            args.rect,
            CornerRadius::same(3),
            screen_colour(colour),
            line,
            StrokeKind::Inside,
        );
    })
}

/// A menu of the palette's colours beside the label of this id; gives the colour that was clicked.
pub(super) fn colour_menu(
    ui: &mut Ui,
    label: &Response,
    current: Rgb,
    palette: &Palette,
) -> Option<Rgb> {
    let mut chosen = None;
    ComboBox::from_id_salt(label.id)
        .width(150.0)
        .selected_text((swatch(current), palette.name_of(current)))
        .show_ui(ui, |ui| {
            let (left, right) = palette.colours().split_at(palette.colours().len() / 2);
            Grid::new("palette").num_columns(2).show(ui, |ui| {
                for entry in left.iter().zip(right).flat_map(|(one, other)| [one, other]) {
                    let item = (swatch(entry.colour), entry.name.as_str(), Atom::grow());
                    let button = Button::selectable(entry.colour == current, item);
                    if ui.add(button.min_size(vec2(116.0, 0.0))).clicked() {
                        chosen = Some(entry.colour);
                    }
                    if right.contains(entry) {
                        ui.end_row();
                    }
                }
            });
        })
        .response
        .labelled_by(label.id);
    chosen.filter(|&colour| colour != current)
}

/// A menu of numbers beside the label of this id; gives the number that was clicked.
pub(super) fn number_menu(
    ui: &mut Ui,
    label: Id,
    current: usize,
    numbers: &[usize],
) -> Option<usize> {
    let mut chosen = None;
    ComboBox::from_id_salt(label)
        .width(64.0)
        .selected_text(current.to_string())
        .show_ui(ui, |ui| {
            for &number in numbers {
                if ui
                    .selectable_label(number == current, number.to_string())
                    .clicked()
                {
                    chosen = Some(number);
                }
            }
        })
        .response
        .labelled_by(label);
    chosen.filter(|&number| number != current)
}

/// A button that stays down while something is on.
pub(super) fn switch(ui: &mut Ui, text: &str, on: bool) -> Response {
    ui.add(Button::new(text).selected(on))
}

/// A button that changes between light and dark.
pub(super) fn theme_button(ui: &mut Ui) {
    let icon = Atom::paint(vec2(SWATCH, SWATCH), |ui, args| {
        let (middle, colour) = (args.rect.center(), args.fallback_text_color);
        let painter = ui.painter();
        painter.circle_stroke(middle, 6.0, Stroke::new(1.5, colour));
        let half = Rect::from_min_max(args.rect.center_top(), args.rect.right_bottom());
        painter
            .with_clip_rect(half)
            .circle_filled(middle, 6.0, colour);
    });
    let response = ui.add(Button::new(icon)).on_hover_text("Light or dark");
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Light or dark"));
    if response.clicked() {
        let other = match ui.ctx().theme() {
            Theme::Dark => Theme::Light,
            Theme::Light => Theme::Dark,
        };
        ui.ctx().set_theme(other);
    }
}

/// A coloured dot before a line of text.
pub(super) fn dotted(ui: &mut Ui, colour: Color32, text: impl Into<RichText>) {
    ui.horizontal_top(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(10.0, 19.0), egui::Sense::hover());
        ui.painter().circle_filled(rect.center(), 4.0, colour);
        ui.add(egui::Label::new(text.into()).wrap());
    });
}
