//! Which four of sixteen colours: measured on the scene, chosen with the reason, changed by hand if one wants.

use eframe::egui::{self, CornerRadius, Rect, RichText, Sense, Ui, pos2, vec2};
use shared::pattern::{Palette, Rgb};

use crate::gui::{
    events::Job,
    model::{Colours, Model, Side},
    style::{self, GAP},
};

/// Height of a colour's bar with its name, in points.
const BAR_HEIGHT: f32 = 15.0;
const PLACES: [&str; 4] = ["First", "Second", "Third", "Fourth"];

/// Shows the panel.
pub(in crate::gui) fn show(model: &mut Model, ui: &mut Ui) {
    style::heading(
        ui,
        "Colours of the grid",
        "All are shown on the scene; the four told apart best draw the grid.",
    );
    let ready = model.is_ready();
    let first = model.colours.measured.is_none();
    let text = if first {
        "Measure all sixteen"
    } else {
        "Measure again"
    };
    let pick = if first {
        style::primary(ui, ready, text)
    } else {
        style::wide(ui, ready, text, ui.available_width())
    };
    if pick
        .on_hover_text("Shows each colour for a moment, without an object in the scene (P)")
        .clicked()
    {
        model.ask(Job::PickColours { apply: false });
    }
    ui.add_space(4.0);
    ui.scope(|ui| bars(&model.colours, ui));
    ui.add_space(GAP);
    choice(&mut model.colours, ui);
    reasons(&model.colours, ui);
}

/// What to do next, below the panel and always in sight: send the choice, then go on to the scan.
pub(in crate::gui) fn next(model: &mut Model, ui: &mut Ui) {
    cost(&mut model.colours, ui);
    let may_apply = model.may_apply();
    let there = model.colours.measured.is_some() && model.is_ready() && model.are_colours_there();
    if !there {
        let apply = style::primary(ui, may_apply, "Apply to the projector");
        let hint =
            "The projector's grid takes these colours (A). A scan begun in other colours is ended.";
        if apply.on_hover_text(hint).clicked() {
            model.apply_colours();
        }
        return;
    }
    ui.horizontal(|ui| {
        style::lamp(ui, style::GOOD);
        ui.label("The projector shows these colours.");
    });
    if style::primary(ui, true, "Next: scan").clicked() {
        model.side = Side::Scan;
    }
}

/// A bar for each colour, as long as the pixels that were recovered of it.
fn bars(colours: &Colours, ui: &mut Ui) {
    let measured = colours.measured.as_ref();
    let most = measured
        .and_then(|m| m.colours.iter().map(|c| c.recovered_px).max())
        .unwrap_or(1)
        .max(1);
    ui.spacing_mut().item_spacing.y = 1.0;
    ui.spacing_mut().interact_size.y = BAR_HEIGHT;
    for entry in colours.palette.colours() {
        let score = measured.and_then(|m| m.colours.iter().find(|c| c.colour == entry.colour));
        let place = colours.best.iter().position(|&c| c == entry.colour);
        let share = score.map(|score| score.recovered_px as f32 / most as f32);
        let response = ui.horizontal(|ui| {
            let name = RichText::new(&entry.name).small();
            let name = if place.is_some() { name.strong() } else { name };
            let left = egui::Layout::left_to_right(egui::Align::Center);
            ui.allocate_ui_with_layout(vec2(92.0, BAR_HEIGHT), left, |ui| {
                ui.set_min_width(92.0);
                ui.add(egui::Label::new(name).truncate());
            });
            let width = (ui.available_width() - 92.0).max(40.0);
            bar(ui, entry.colour, share, width);
            let mut mark = place.map_or(String::new(), |k| PLACES[k].to_lowercase());
            if entry.colour == colours.unary {
                mark = if mark.is_empty() {
                    "unary".into()
                } else {
                    format!("{mark}, unary")
                };
            }
            ui.label(RichText::new(mark).small());
        });
        if let Some(score) = score {
            response.response.on_hover_text(format!(
                "{} pixels recovered, {:.0} % of what the grid should cover; lines in this colour alone are placed to \
                 {:.3} px",
                score.recovered_px,
                100.0 * score.share_of_expected,
                score.line_error_px
            ));
        }
    }
}

fn bar(ui: &mut Ui, colour: Rgb, share: Option<f32>, width: f32) {
    let (rect, response) = ui.allocate_exact_size(vec2(width, 12.0), Sense::hover());
    let rounding = CornerRadius::same(2);
    let visuals = ui.visuals();
    ui.painter()
        .rect_filled(rect, rounding, visuals.extreme_bg_color);
    if let Some(share) = share {
        let grown = Rect::from_min_max(
            rect.min,
            pos2(
                rect.left() + rect.width() * share.clamp(0.0, 1.0),
                rect.bottom(),
            ),
        );
        ui.painter()
            .rect_filled(grown, rounding, style::screen_colour(colour));
    }
    let rim = egui::Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color);
    ui.painter()
        .rect_stroke(rect, rounding, rim, egui::StrokeKind::Inside);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(
            egui::Role::ProgressIndicator,
            true,
            match share {
                Some(share) => format!("{:.0} % of the best", 100.0 * share),
                None => "not measured".to_owned(),
            },
        )
    });
}

/// The four colours and the unary one, each to be changed.
fn choice(colours: &mut Colours, ui: &mut Ui) {
    let before = (colours.best, colours.unary);
    egui::Grid::new("choice")
        .num_columns(6)
        .min_col_width(0.0)
        .spacing([6.0, 3.0])
        .show(ui, |ui| {
            for (k, place) in PLACES.into_iter().enumerate() {
                menu(ui, place, &mut colours.best[k], &colours.palette);
                if k % 2 == 1 {
                    ui.end_row();
                }
            }
            menu(ui, "Unary", &mut colours.unary, &colours.palette);
        });
    if before != (colours.best, colours.unary) {
        colours.overridden = true;
    }
}

/// A menu of the sixteen colours.
fn menu(ui: &mut Ui, name: &str, colour: &mut Rgb, palette: &Palette) {
    let label = ui.label(name);
    style::swatch(ui, *colour, vec2(16.0, 18.0));
    let combo = egui::ComboBox::from_id_salt(name)
        .selected_text(palette.name_of(*colour))
        .width(82.0)
        .show_ui(ui, |ui| {
            for entry in palette.colours() {
                ui.horizontal(|ui| {
                    style::swatch(ui, entry.colour, vec2(22.0, 16.0));
                    ui.selectable_value(colour, entry.colour, &entry.name);
                });
            }
        });
    combo.response.labelled_by(label.id);
}

/// What the choice is expected to give, beside the best one.
fn cost(colours: &mut Colours, ui: &mut Ui) {
    let Some(measured) = colours.measured.as_ref().filter(|_| colours.complete) else {
        if colours.measured.is_none() {
            let text = "Not measured yet: these are the projector's own colours.";
            ui.label(RichText::new(text).small().weak());
        }
        return;
    };
    let percent = |error: f64| format!("{:.2} %", 100.0 * error);
    let best = percent(measured.expected_error);
    match measured.set_of(colours.best) {
        None => {
            ui.colored_label(style::BAD, "Choose four different colours.");
        }
        Some(set) => {
            let (label, colour) = if !colours.overridden {
                (
                    format!("Expected to be misread: {best} of the line pixels."),
                    style::GOOD,
                )
            } else {
                let error = percent(set.expected_error);
                let dearer = set.expected_error > 1.2 * measured.expected_error + 1e-6;
                let colour = if dearer { style::FAIR } else { style::GOOD };
                (
                    format!("By hand: {error} of the line pixels misread, the best set {best}."),
                    colour,
                )
            };
            ui.colored_label(colour, label);
        }
    }
    let placed = |colour: Rgb| {
        let entry = measured.colours.iter().find(|entry| entry.colour == colour);
        entry.map(|entry| entry.line_error_px)
    };
    if let (Some(own), Some(of_best)) = (placed(colours.unary), placed(measured.unary))
        && colours.unary != measured.unary
    {
        let text = format!("Unary: lines placed to {own:.3} px, with the best to {of_best:.3} px.");
        ui.colored_label(style::FAIR, text);
    }
    if colours.overridden && ui.button("Back to the best").clicked() {
        colours.best = measured.best;
        colours.unary = measured.unary;
        colours.overridden = false;
    }
}

fn reasons(colours: &Colours, ui: &mut Ui) {
    let Some(measured) = colours.measured.as_ref().filter(|_| colours.complete) else {
        return;
    };
    ui.add_space(4.0);
    egui::CollapsingHeader::new("Why these")
        .default_open(true)
        .show(ui, |ui| {
            for reason in &measured.reasons {
                ui.label(RichText::new(reason).small());
            }
            let thesis = &measured.thesis_choice;
            ui.label(RichText::new(format!(
            "The most recovered pixels alone, as in the thesis, would take {}: {:.1} % misread.",
            thesis.names.join(", "),
            100.0 * thesis.expected_error
        )).small().weak());
        });
}
