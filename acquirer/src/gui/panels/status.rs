//! The bar at the bottom: how the rig is.

use eframe::egui::{RichText, Ui};

use crate::gui::{
    model::Model,
    style::{self, BAD, GOOD},
};

/// Shows the bar.
pub(in crate::gui) fn show(model: &Model, ui: &mut Ui) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 7.0;
        projector(model, ui);
        camera(model, ui);
        reading(model, ui);
        if let Some(latency) = &model.latency {
            ui.separator();
            let timing = &latency.timing;
            ui.label(format!("latency {:.0} ms", timing.latency.ms))
                .on_hover_text(format!(
                    "From the projector's picture to the camera's frame; settled after {:.0} ms",
                    timing.settled_ms()
                ));
        }
        ui.separator();
        ui.label(format!("window {:.0} ms", model.repaints.last_ms()))
            .on_hover_ui(|ui| {
                ui.label(format!(
                    "Time of one repaint. {}",
                    model.repaints.sentence()
                ));
            });
    });
}

fn projector(model: &Model, ui: &mut Ui) {
    match &model.rig {
        Ok(rig) => {
            let screen = &rig.projector.screen;
            style::lamp(ui, if screen.problem.is_some() { BAD } else { GOOD });
            let grid = &rig.projector.grid.coded;
            let text = format!("projector {}", model.address);
            let label = ui.label(text).on_hover_text(format!(
                "{}, {} px, {} x {} lines. Click Identify in the source panel to see which one it is.",
                screen.name,
                screen.raster,
                grid.rows(),
                grid.columns()
            ));
            if let Some(problem) = &screen.problem {
                label.on_hover_text(problem);
                ui.colored_label(BAD, problem);
            }
        }
        Err(reason) => {
            style::lamp(ui, BAD);
            ui.colored_label(BAD, format!("no rig at {}", model.address))
                .on_hover_text(reason);
        }
    }
}

fn camera(model: &Model, ui: &mut Ui) {
    let Some(picture) = &model.live.picture else {
        return;
    };
    ui.separator();
    ui.label(format!("camera {:.1}/s", picture.rate_hz))
        .on_hover_text(format!(
            "Frames taken per second; this is frame {}",
            picture.number
        ));
    ui.separator();
    ui.label(format!("lost {}", picture.lost))
        .on_hover_text("Frames that the camera made and nobody saw, since it was opened");
}

fn reading(model: &Model, ui: &mut Ui) {
    let picture = model.live.picture.as_ref();
    if let Some(reading) = picture.and_then(|picture| picture.reading.as_ref()) {
        ui.separator();
        ui.label(format!("reading {:.1} ms", reading.ms))
            .on_hover_text("Time from the camera's frame to the decoded grid");
        ui.separator();
        let share = 100.0 * reading.crossings as f64 / reading.possible.max(1) as f64;
        let colour = style::judged(share, [90.0, 60.0]);
        ui.label(RichText::new(format!("{share:.0} % read")).color(colour))
            .on_hover_text("Crossings of the projected grid that were read in this frame");
    }
    if let Some((pixels, _)) = picture.and_then(|picture| picture.recovered.as_ref()) {
        ui.separator();
        ui.label(format!("recovered {pixels} px")).on_hover_text(
            "Pixels of the projected grid that are left when the background is removed (HIST): the thesis's figure \
             for the best colour",
        );
    }
    if let Some(scan) = &model.result {
        let times = scan
            .times
            .iter()
            .map(|time| format!("{} {:.0} ms", time.step, time.ms));
        ui.separator();
        ui.label("scan times")
            .on_hover_text(times.collect::<Vec<_>>().join("\n"));
    }
}
