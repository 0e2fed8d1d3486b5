//! The shifts in numbers, as the thesis's Appendix C prints them.

use eframe::egui::{self, RichText, Ui};

use crate::gui::open_scan::OpenScan;

const HEADS: [(&str, f32); 7] = [
    ("Vertex", 110.0),
    ("Row", 50.0),
    ("Column", 64.0),
    ("x / px", 84.0),
    ("y / px", 84.0),
    ("Shift / px", 84.0),
    ("Depth", 84.0),
];

/// Shows the table; only the rows that are seen are made.
pub(super) fn show(scan: &OpenScan, ui: &mut Ui) {
    if scan.shifts.is_empty() {
        ui.label("No vertex was read both without and with the object.");
        return;
    }
    let line = |ui: &mut Ui, cells: [RichText; 7]| {
        ui.horizontal(|ui| {
            for ((_, width), text) in HEADS.into_iter().zip(cells) {
                let label = egui::Label::new(text).halign(egui::Align::Min).truncate();
                ui.add_sized([width, 18.0], label);
            }
        });
    };
    line(ui, HEADS.map(|(name, _)| RichText::new(name).strong()));
    ui.separator();
    egui::ScrollArea::vertical()
        .id_salt("shifts")
        .auto_shrink(false)
        .show_rows(ui, 18.0, scan.shifts.len(), |ui, range| {
            for row in &scan.shifts[range] {
                let number = |value: f64| RichText::new(format!("{value:.2}")).monospace();
                line(
                    ui,
                    [
                        RichText::new(row.corner.name()),
                        RichText::new(row.index.row.to_string()).monospace(),
                        RichText::new(row.index.column.to_string()).monospace(),
                        number(row.x_px),
                        number(row.y_px),
                        number(row.shift_px),
                        number(row.depth),
                    ],
                );
            }
        });
}
