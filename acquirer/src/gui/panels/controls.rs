//! The camera's controls with their ranges, the thesis's source settings (S): each can be set, all automatics locked, and
//! the exposure brought to where white just does not clip.

use eframe::egui::{self, RichText, Role, Ui, WidgetInfo, vec2};

use crate::{
    camera::{ControlInfo, ControlKind},
    gui::{
        events::Job,
        model::Model,
        style::{self, FAIR},
    },
};

/// Widths of the two columns' parts, in points.
const NAME_WIDTH: f32 = 126.0;
const SLIDER_WIDTH: f32 = 88.0;

/// Shows the panel; it is closed at first.
pub(super) fn show(model: &mut Model, ui: &mut Ui) {
    if model.rig.is_err() {
        return;
    }
    let header = egui::CollapsingHeader::new(RichText::new("Source settings").strong());
    let shown = header
        .default_open(false)
        .show_unindented(ui, |ui| panel(model, ui));
    model.controls.are_shown = shown.body_returned.is_some();
    let hint = "Exposure, gain, white balance and whatever else this camera lets one set";
    shown.header_response.on_hover_text(hint);
}

fn panel(model: &mut Model, ui: &mut Ui) {
    let controls = match &model.controls.list {
        Ok(controls) if controls.is_empty() => {
            ui.label("This source has no controls.");
            return;
        }
        Ok(controls) => controls.clone(),
        Err(reason) => {
            ui.colored_label(FAIR, reason);
            return;
        }
    };
    buttons(model, ui);
    let ready = model.is_ready();
    egui::Grid::new("controls")
        .num_columns(2)
        .spacing([8.0, 5.0])
        .striped(true)
        .show(ui, |ui| {
            for control in &controls {
                ui.add_enabled_ui(ready, |ui| name(control, ui));
                let free = ready && !control.inactive && !control.read_only;
                let set = ui
                    .add_enabled_ui(free, |ui| value(model, control, ui))
                    .inner;
                if let Some(value) = set {
                    set_to(model, control.id, value);
                }
                ui.end_row();
            }
        });
}

/// Asks for a value, and shows it until the camera has told what it took.
fn set_to(model: &mut Model, id: u32, value: i64) {
    model.ask(Job::SetControl(id, value));
    let list = model.controls.list.iter_mut().flatten();
    for control in list.filter(|control| control.id == id) {
        control.value = Some(value);
    }
}

fn buttons(model: &mut Model, ui: &mut Ui) {
    let ready = model.is_ready();
    ui.horizontal(|ui| {
        let half = style::half(ui);
        let lock = style::wide(ui, ready, "Lock all", half);
        let hint = "Every automatic (exposure, gain, white balance, focus) stands still where it is now, so that the \
                    same light gives the same bytes";
        if lock.on_hover_text(hint).clicked() {
            model.ask(Job::LockAutomatics);
        }
        let expose = style::wide(ui, ready, "Set the exposure", half);
        let hint = "Shows white, and sets the exposure so that the brightest parts of the scene just do not clip, in \
                    whole periods of the projector. Have the brightest object in the scene when you do it.";
        if expose.on_hover_text(hint).clicked() {
            model.ask(Job::SetExposure);
        }
    });
}

/// The camera's word for a control; everything else about it is in the tooltip.
fn name(control: &ControlInfo, ui: &mut Ui) {
    let now = control
        .value
        .map_or_else(|| "not known".to_owned(), |now| control.value_text(now));
    let mut told = format!(
        "{}\n{}\nnow {now}, usually {}",
        control.key,
        control.range_text(),
        control.value_text(control.default)
    );
    if control.read_only {
        told += "\nit can only be read";
    } else if control.inactive {
        told += "\nan automatic has it in hand: switch that off, or lock all";
    }
    let left = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(vec2(NAME_WIDTH, 20.0), left, |ui| {
        ui.set_min_width(NAME_WIDTH);
        let text = RichText::new(&control.name).small();
        ui.add(egui::Label::new(text).truncate())
            .on_hover_text(told);
    });
}

/// The control's value to be changed; gives what it is to be set to.
fn value(model: &mut Model, control: &ControlInfo, ui: &mut Ui) -> Option<i64> {
    let Some(now) = control.value else {
        ui.label(RichText::new("can't be read").small());
        return None;
    };
    match &control.kind {
        ControlKind::Switch => {
            let mut on = now != 0;
            let switch = ui.checkbox(&mut on, "");
            let changed = switch.changed();
            let words = format!("{} on or off", control.name);
            switch
                .widget_info(|| WidgetInfo::selected(Role::CheckBox, ui.is_enabled(), on, &words));
            changed.then_some(i64::from(on))
        }
        ControlKind::Menu { items } => {
            let mut chosen = now;
            egui::ComboBox::from_id_salt(("control", control.id))
                .selected_text(control.value_text(now))
                .width(ui.available_width() - 8.0)
                .show_ui(ui, |ui| {
                    for item in items {
                        ui.selectable_value(&mut chosen, item.value, &item.name);
                    }
                });
            Some(chosen).filter(|&chosen| chosen != now)
        }
        ControlKind::Number { least, most, .. } => number(model, control, (*least, *most, now), ui),
    }
}

/// A slider with the number beside it; the value goes to the camera when the mouse lets go.
fn number(
    model: &mut Model,
    control: &ControlInfo,
    (least, most, now): (i64, i64, i64),
    ui: &mut Ui,
) -> Option<i64> {
    let moving = model.controls.moving.filter(|(id, _)| *id == control.id);
    let mut value = moving.map_or(now, |(_, value)| value);
    let response = ui
        .horizontal(|ui| {
            ui.spacing_mut().slider_width = SLIDER_WIDTH;
            let slider = egui::Slider::new(&mut value, least..=most).update_while_editing(false);
            let response = ui.add(slider.logarithmic(most - least > 2000 && least >= 0));
            let usual = control.default;
            let back = ui.add_enabled(
                now != usual,
                egui::Button::new(RichText::new("reset").small()).frame(false),
            );
            if back
                .on_hover_text(format!("back to {}", control.value_text(usual)))
                .clicked()
            {
                return Err(usual);
            }
            Ok(response)
        })
        .inner;
    let response = match response {
        Ok(response) => response,
        Err(usual) => return Some(usual),
    };
    let value = control.nearest(value);
    if response.dragged() {
        model.controls.moving = Some((control.id, value));
        return None;
    }
    if moving.is_some() {
        model.controls.moving = None;
    }
    let given = response.drag_stopped() || response.changed();
    Some(value).filter(|&value| given && value != now)
}
