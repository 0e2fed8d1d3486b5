//! The object's shape: a surface to turn, the shift map, the table; saved, opened, loaded.

use eframe::egui::{self, Rect, RichText, Ui, pos2, vec2};
use shared::stage::Stage;

use super::{live::fitted, shape, table};
use crate::gui::{
    events::FileJob,
    model::{Model, ResultView},
    open_scan::OpenScan,
    style,
};

/// Shows the result.
pub(in crate::gui) fn show(model: &mut Model, ui: &mut Ui) {
    let Some(scan) = model.result.take() else {
        ui.centered_and_justified(|ui| {
            ui.label("No result yet: record a scan in the scan panel, or load an earlier one (Load scan, above).");
        });
        return;
    };
    ui.horizontal(|ui| {
        for (view, name, hint) in [
            (
                ResultView::Surface,
                "Surface",
                "The shape, to be turned with the mouse",
            ),
            (
                ResultView::ShiftMap,
                "Shift map",
                "How far each crossing moved, over the picture",
            ),
            (
                ResultView::Table,
                "Table",
                "The same in numbers, for each vertex",
            ),
        ] {
            ui.selectable_value(&mut model.result_view, view, name)
                .on_hover_text(hint);
        }
        if model.result_view == ResultView::Surface {
            ui.separator();
            colouring(&mut model.preferences.colour_by_picture, ui);
        }
    });
    egui::Panel::bottom("result figures")
        .resizable(false)
        .show(ui, |ui| {
            ui.add_space(4.0);
            figures(&scan, ui);
            ui.add_space(2.0);
            keep(model, &scan, ui);
            ui.add_space(2.0);
        });
    match model.result_view {
        ResultView::Surface => {
            let by_picture = model.preferences.colour_by_picture;
            let pictures = (&mut model.pictures, "result surface");
            shape::show(&scan, &mut model.look, by_picture, pictures, ui);
        }
        ResultView::ShiftMap => shift_map(model, &scan, ui),
        ResultView::Table => table::show(&scan, ui),
    }
    model.result = Some(scan);
}

/// Depth or picture.
pub(super) fn colouring(by_picture: &mut bool, ui: &mut Ui) {
    ui.label(RichText::new("Coloured by").weak());
    ui.selectable_value(by_picture, false, "depth");
    ui.selectable_value(by_picture, true, "picture");
}

fn shift_map(model: &mut Model, scan: &OpenScan, ui: &mut Ui) {
    let Some(image) = &scan.shift_map else {
        ui.label("No vertex was read both without and with the object.");
        return;
    };
    let room = ui.available_rect_before_wrap();
    let texture = model.pictures.texture(ui.ctx(), "shift map", image);
    let size = image.size.map(|side| side as f32);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let target = fitted(vec2(size[0], size[1]), room);
    ui.painter_at(room)
        .image(texture.id(), target, whole, egui::Color32::WHITE);
}

/// The scan in a line of figures.
pub(super) fn figures(scan: &OpenScan, ui: &mut Ui) {
    // a figure goes to the next line as a whole
    ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(scan.name()).strong());
        for (stage, name) in [
            (Stage::Background, "without"),
            (Stage::Object, "with object"),
        ] {
            if let Some(view) = scan.stage(stage) {
                let coverage = view.quality.coverage_percent();
                ui.separator();
                style::lamp(ui, style::judged(coverage, [90.0, 60.0]));
                ui.label(format!("{name}: {coverage:.1} % read"));
            }
        }
        if let Some(shifts) = &scan.summary.shifts {
            ui.separator();
            ui.label(format!(
                "{} vertices shifted, median {:.2} px, largest {:.2} px",
                shifts.vertices, shifts.median_px, shifts.largest_px
            ));
        }
        if let Some(surface) = &scan.summary.surface {
            let [near, far] = surface.z_mm;
            ui.separator();
            ui.label(format!(
                "{} points, {near:.0} to {far:.0} mm away",
                surface.points
            ));
        }
        if let Some(difference) = &scan.summary.difference {
            ui.separator();
            ui.label(format!("object up to {:.1} mm high", difference.largest_mm));
        }
    });
    ui.style_mut().wrap_mode = None;
    for warning in &scan.summary.warnings {
        ui.colored_label(style::FAIR, warning);
    }
}

fn keep(model: &mut Model, scan: &OpenScan, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let label = ui
            .label("Save as")
            .on_hover_text("The scan is on the disk already; this makes a copy under another name");
        let edit = egui::TextEdit::singleline(&mut model.save_name).desired_width(240.0);
        ui.add(edit).labelled_by(label.id);
        let may = !model.save_name.trim().is_empty();
        let save = ui.add_enabled(may, egui::Button::new("Save"));
        if save
            .on_hover_text("Copy captures and results to this folder")
            .clicked()
        {
            let to = model.save_name.trim().into();
            let from = scan.dir.clone();
            model.ask_files(FileJob::Save { from, to });
        }
        ui.separator();
        if ui
            .button("Open folder")
            .on_hover_text(scan.dir.display().to_string())
            .clicked()
        {
            model.ask_files(FileJob::OpenOutside(scan.dir.clone()));
        }
        if ui
            .button("Open report")
            .on_hover_text("Everything in one page")
            .clicked()
        {
            model.ask_files(FileJob::OpenOutside(scan.report.clone()));
        }
    });
}
