//! What a crossing's label rests on: its window of rows and columns, their symbols, and the window's place in the
//! sequence.

use eframe::egui::{self, CornerRadius, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};
use shared::{
    pattern::{Axis, Grid},
    sequence::{Alphabet, window_order},
};

use super::live::fitted;
use crate::{
    gui::{
        model::Model,
        open_scan::StageView,
        style::{self, MAT},
    },
    pipeline::grid::DecodedCrossing,
};

/// Side of the piece of the picture that is shown, in camera pixels.
const PIECE_PX: f32 = 90.0;

/// Shows what is known of a crossing.
pub(super) fn show(model: &mut Model, view: &StageView, crossing: &DecodedCrossing, ui: &mut Ui) {
    ui.horizontal_top(|ui| {
        piece(model, view, crossing, ui);
        ui.vertical(|ui| {
            let index = crossing.index;
            ui.horizontal(|ui| {
                ui.label(
                    RichText::new(format!("Row {}, column {}", index.row, index.column)).heading(),
                );
                ui.label(
                    RichText::new(format!(
                        "at {:.2}, {:.2} px; label right with probability {:.4}",
                        crossing.centre.x, crossing.centre.y, crossing.confidence
                    ))
                    .small()
                    .weak(),
                );
                if ui.button("Close").clicked() {
                    model.steps.crossing = None;
                }
            });
            for axis in Axis::BOTH {
                sequence(&view.pattern.coded, axis, usize::from(index.line(axis)), ui);
            }
        });
    });
}

/// The picture around the crossing, enlarged.
fn piece(model: &mut Model, view: &StageView, crossing: &DecodedCrossing, ui: &mut Ui) {
    let side = ui.available_height().min(180.0);
    let (rect, _) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    ui.painter().rect_filled(rect, CornerRadius::same(4), MAT);
    let Some((_, image)) = view.steps.first() else {
        return;
    };
    let texture = model.pictures.texture(ui.ctx(), "crossing", image);
    let [width, height] = image.size.map(|side| side as f32);
    let (x, y) = (crossing.centre.x as f32, crossing.centre.y as f32);
    let half = PIECE_PX / 2.0;
    let seen = Rect::from_min_max(
        pos2((x - half) / width, (y - half) / height),
        pos2((x + half) / width, (y + half) / height),
    );
    let target = fitted(vec2(1.0, 1.0), rect);
    ui.painter()
        .image(texture.id(), target, seen, egui::Color32::WHITE);
    let scale = target.width() / PIECE_PX;
    for vertex in crossing.vertices {
        let at = target.center() + scale * vec2(vertex.x as f32 - x, vertex.y as f32 - y);
        ui.painter().circle(
            at,
            3.0,
            egui::Color32::WHITE,
            Stroke::new(1.5, style::ACCENT),
        );
    }
}

/// The whole sequence of one direction with the window that holds the line.
fn sequence(grid: &Grid, axis: Axis, line: usize, ui: &mut Ui) {
    let symbols = grid.symbols(axis);
    let alphabet = if grid.colours().len() == 2 {
        Alphabet::Two
    } else {
        Alphabet::Four
    };
    let order = window_order(alphabet, symbols.len()).unwrap_or(1);
    let start = line.min(symbols.len().saturating_sub(order));
    let window = &symbols[start..(start + order).min(symbols.len())];
    let read: Vec<String> = window.iter().map(ToString::to_string).collect();
    let name = match axis {
        Axis::Row => "rows",
        Axis::Column => "columns",
    };
    ui.label(RichText::new(format!(
        "{name} {start} to {}: symbols {}. This window of {order} occurs once in the sequence, at place {start}.",
        start + window.len().saturating_sub(1),
        read.join(" ")
    )).small());
    let width = (ui.available_width() - 8.0).max(60.0);
    let (rect, _) = ui.allocate_exact_size(vec2(width, 20.0), Sense::hover());
    let step = (rect.width() / symbols.len().max(1) as f32).min(26.0);
    for k in 0..symbols.len() {
        let left = rect.left() + k as f32 * step;
        let cell = Rect::from_min_max(
            pos2(left, rect.top() + 3.0),
            pos2(left + step - 1.0, rect.bottom() - 3.0),
        );
        if let Some(colour) = grid.line_colour(axis, k) {
            ui.painter()
                .rect_filled(cell, CornerRadius::same(2), style::screen_colour(colour));
        }
    }
    let left = rect.left() + start as f32 * step - 1.5;
    let frame = Rect::from_min_max(
        pos2(left, rect.top()),
        pos2(left + window.len() as f32 * step + 2.0, rect.bottom()),
    );
    let ink = ui.visuals().strong_text_color();
    ui.painter().rect_stroke(
        frame,
        CornerRadius::same(3),
        Stroke::new(2.0, ink),
        egui::StrokeKind::Inside,
    );
}
