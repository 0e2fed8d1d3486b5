//! The steps of the reading side by side: what each makes of one picture, and what a crossing means.

use eframe::egui::{self, Rect, RichText, Sense, Ui, pos2, vec2};
use shared::stage::Stage;

use super::{crossing, live::fitted, overlay};
use crate::gui::{model::Model, open_scan::StageView, preferences::Overlays, style::MAT};

/// Farthest click from a crossing, in camera pixels.
const REACH_PX: f32 = 40.0;

/// Shows the view.
pub(in crate::gui) fn show(model: &mut Model, ui: &mut Ui) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Picture").weak());
        for (stage, name) in [
            (Stage::Background, "Without object"),
            (Stage::Object, "With object"),
        ] {
            if ui
                .selectable_label(model.steps.stage == stage, name)
                .clicked()
            {
                model.steps.stage = stage;
                model.steps.crossing = None;
            }
        }
        if model.steps.enlarged.is_some() && ui.button("All side by side").clicked() {
            model.steps.enlarged = None;
        }
    });
    let Some(view) = model.shown_stage().cloned() else {
        ui.centered_and_justified(|ui| {
            ui.label("Nothing recorded yet: record the scene in the scan panel, or load an earlier scan.");
        });
        return;
    };
    if let Some(crossing) = model
        .steps
        .crossing
        .and_then(|k| view.grid.crossings.get(k))
    {
        let crossing = crossing.clone();
        egui::Panel::bottom("crossing")
            .exact_size(196.0)
            .show(ui, |ui| crossing::show(model, &view, &crossing, ui));
    }
    // the last place is the decoded grid over the capture
    let count = view.steps.len() + 1;
    match model.steps.enlarged.filter(|&k| k < count) {
        Some(k) => {
            let room = ui.available_rect_before_wrap();
            step(model, &view, k, room, ui);
        }
        None => side_by_side(model, &view, count, ui),
    }
}

fn side_by_side(model: &mut Model, view: &StageView, count: usize, ui: &mut Ui) {
    let room = ui.available_rect_before_wrap();
    let columns = if room.width() > 1.1 * room.height() {
        3
    } else {
        2
    }
    .min(count);
    let rows = count.div_ceil(columns.max(1));
    let cell = vec2(
        room.width() / columns as f32,
        room.height() / rows.max(1) as f32,
    );
    for k in 0..count {
        let corner = room.min + vec2((k % columns) as f32 * cell.x, (k / columns) as f32 * cell.y);
        step(
            model,
            view,
            k,
            Rect::from_min_size(corner, cell).shrink(3.0),
            ui,
        );
    }
}

/// One product with what is seen on it. The decoded grid takes clicks on crossings, the others become large.
fn step(model: &mut Model, view: &StageView, k: usize, room: Rect, ui: &mut Ui) {
    let is_grid = k >= view.steps.len();
    let caption = match view.steps.get(k) {
        Some((caption, _)) => caption.clone(),
        None => "Decoded grid: click a crossing to see its window and its place in the sequence."
            .to_owned(),
    };
    let Some((_, image)) = view.steps.get(if is_grid { 0 } else { k }) else {
        return;
    };
    let text = Rect::from_min_size(room.min, vec2(room.width(), 34.0));
    let below = Rect::from_min_max(pos2(room.left(), text.bottom()), room.max);
    ui.scope_builder(egui::UiBuilder::new().max_rect(text), |ui| {
        ui.add(egui::Label::new(RichText::new(format!("{}  {caption}", k + 1)).small()).wrap());
    });
    ui.painter()
        .rect_filled(below, egui::CornerRadius::same(4), MAT);
    let size = image.size.map(|side| side as f32);
    let target = fitted(vec2(size[0], size[1]), below.shrink(2.0));
    let scale = target.width() * ui.pixels_per_point() / size[0].max(1.0);
    let shown = (format!("step {k}"), image, scale);
    let texture = model.pictures.reduced(ui.ctx(), &shown.0, shown.1, shown.2);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let painter = ui.painter_at(below);
    painter.image(texture.id(), target, whole, egui::Color32::WHITE);
    let response = ui.interact(below, ui.scope_id().with(("step", k)), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, caption.clone()));
    if !is_grid {
        if response.on_hover_text("Click to enlarge").clicked() {
            model.steps.enlarged = Some(k).filter(|_| model.steps.enlarged.is_none());
        }
        return;
    }
    let place = overlay::Place::new(target, vec2(size[0], size[1]));
    overlay::draw(&painter, &view.overlay, place, Overlays::default());
    let selected = model
        .steps
        .crossing
        .and_then(|k| view.overlay.labels.get(k));
    if let Some((at, _)) = selected {
        for (width, colour) in [(5.0, egui::Color32::BLACK), (2.5, egui::Color32::WHITE)] {
            let stroke = egui::Stroke::new(width, colour);
            painter.circle_stroke(place.at(*at), 11.0, stroke);
        }
    }
    let pointed = response
        .interact_pointer_pos()
        .filter(|_| response.clicked());
    if let Some(at) = pointed {
        model.steps.crossing = nearest(view, place.pixel(at));
    }
    if response.double_clicked() {
        model.steps.enlarged = Some(k).filter(|_| model.steps.enlarged.is_none());
    }
}

/// The labelled crossing that is nearest, if it is near.
fn nearest(view: &StageView, at: [f32; 2]) -> Option<usize> {
    let distance = |p: [f32; 2]| (p[0] - at[0]).hypot(p[1] - at[1]);
    let labels = view.overlay.labels.iter().enumerate();
    let (k, (place, _)) = labels.min_by(|a, b| distance(a.1.0).total_cmp(&distance(b.1.0)))?;
    (distance(*place) < REACH_PX).then_some(k)
}
