//! What went wrong and what to do, and the list of what happened.

use eframe::egui::{self, Color32, RichText, Ui};

use crate::gui::{
    events::Who,
    model::{Model, Task, Weight},
    style::{self, BAD, FAIR},
};

/// The newest warnings over the middle, until they are dismissed.
pub(in crate::gui) fn warnings(model: &mut Model, ui: &mut Ui) {
    if model.warnings.is_empty() {
        return;
    }
    let fill = FAIR.gamma_multiply(0.16);
    let frame = egui::Frame::group(ui.style()).fill(fill).inner_margin(6.0);
    frame.show(ui, |ui| {
        ui.horizontal(|ui| {
            let width = ui.available_width() - 140.0;
            ui.vertical(|ui| {
                ui.set_width(width.max(120.0));
                for warning in &model.warnings {
                    ui.horizontal_wrapped(|ui| {
                        style::lamp(ui, FAIR);
                        ui.label(warning);
                    });
                }
            });
            if ui.button("Dismiss warnings").clicked() {
                model.warnings.clear();
            }
        });
    });
    ui.add_space(4.0);
}

/// The last error over the middle, until it is dismissed.
pub(in crate::gui) fn error(model: &mut Model, ui: &mut Ui) {
    let Some(error) = model.error.clone() else {
        return;
    };
    let fill = BAD.gamma_multiply(0.22);
    let frame = egui::Frame::group(ui.style()).fill(fill).inner_margin(8.0);
    frame.show(ui, |ui| {
        ui.horizontal(|ui| {
            style::lamp(ui, BAD);
            let width = ui.available_width() - 90.0;
            ui.vertical(|ui| {
                ui.set_width(width.max(120.0));
                ui.label(&error);
            });
            if ui.button("Dismiss").clicked() {
                model.error = None;
            }
        });
    });
    ui.add_space(4.0);
}

/// What is under way, with a way to stop it.
pub(in crate::gui) fn tasks(model: &mut Model, ui: &mut Ui) {
    let [rig, files] = model.tasks.clone();
    if let Some(task) = &rig {
        bar(ui, task);
        let text = if task.stopping {
            "Stopping ..."
        } else {
            "Cancel"
        };
        let cancel = style::wide(ui, !task.stopping, text, ui.available_width());
        if cancel
            .on_hover_text("Stop what is under way (Escape)")
            .clicked()
        {
            model.stop(Who::Rig);
        }
    }
    if let Some(task) = &files {
        bar(ui, task);
        // what tells its steps can be stopped between them
        if task.progress.as_ref().is_some_and(|told| told.of > 0) {
            let text = if task.stopping {
                "Stopping the reading ..."
            } else {
                "Stop reading"
            };
            let stop = style::wide(ui, !task.stopping, text, ui.available_width());
            let hint = "Leave the scan unread after the step under way (Escape)";
            if stop.on_hover_text(hint).clicked() {
                model.stop(Who::Files);
            }
        }
    }
    if !model.is_busy(Who::Rig) && !model.is_busy(Who::Files) {
        let last = model.messages.back();
        let last = last.map_or("", |message| message.text.as_str());
        ui.add(egui::Label::new(RichText::new(last).small().weak()).truncate());
    }
}

fn bar(ui: &mut Ui, task: &Task) {
    let told = task.progress.as_ref();
    let what = told.map_or("working", |progress| progress.what.as_str());
    ui.label(RichText::new(what).small());
    match told.filter(|progress| progress.of > 0) {
        Some(progress) => {
            let share = progress.done as f32 / progress.of as f32;
            ui.add(
                egui::ProgressBar::new(share)
                    .desired_height(8.0)
                    .fill(style::ACCENT),
            );
        }
        None => {
            let seconds = task.since.elapsed().as_secs();
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(RichText::new(format!("{seconds} s")).small().weak());
            });
        }
    }
}

/// The list of what happened.
pub(in crate::gui) fn list(model: &Model, ui: &mut Ui) {
    egui::ScrollArea::vertical()
        .id_salt("messages")
        .stick_to_bottom(true)
        .auto_shrink(false)
        .show(ui, |ui| {
            for message in &model.messages {
                let text = RichText::new(&message.text).small();
                let text = match message.weight {
                    Weight::Note => text,
                    Weight::Warning => text.color(FAIR),
                    Weight::Error => text.color(BAD),
                };
                ui.add(egui::Label::new(text).wrap());
            }
            if model.messages.is_empty() {
                ui.colored_label(Color32::GRAY, "Nothing happened yet.");
            }
        });
}
