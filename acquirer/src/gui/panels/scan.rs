//! A scan: without the object, with it, each judged before it is kept; then the next object, or another scan.

use eframe::egui::{self, RichText, Sense, Ui, vec2};
use shared::stage::Stage;

use super::overlay;
use crate::{
    gui::{
        events::{FileJob, Job, Place, Who},
        live_picture::hole_colour,
        model::{Model, Tab},
        open_scan::Quality,
        style::{self, GAP, GOOD},
    },
    output::maps::reason_words,
};

/// Shows the panel.
pub(in crate::gui) fn show(model: &mut Model, ui: &mut Ui) {
    style::heading(
        ui,
        "Record a scan",
        "The scene without and with an object; what moved is its shape.",
    );
    stage(model, Stage::Background, ui);
    ui.add_space(GAP);
    stage(model, Stage::Object, ui);
    ui.add_space(GAP);
    finish(model, ui);
    ui.add_space(GAP);
    more(model, ui);
}

/// What is to be done next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    Record(Stage),
    Keep(Stage),
    Compute,
    Nothing,
}

fn next(model: &Model) -> Next {
    for (stage, slot) in Stage::BOTH.into_iter().zip(&model.scan.stages) {
        if !slot.recorded {
            return Next::Record(stage);
        }
        if !slot.accepted {
            return Next::Keep(stage);
        }
    }
    if is_computed(model) {
        Next::Nothing
    } else {
        Next::Compute
    }
}

/// Whether the result is that of the scan at hand.
fn is_computed(model: &Model) -> bool {
    let result = model.result.as_ref();
    result.is_some_and(|scan| Some(&scan.dir) == model.scan.dir.as_ref())
}

struct Words {
    title: &'static str,
    record: &'static str,
    hint: &'static str,
}

fn words(stage: Stage) -> Words {
    match stage {
        Stage::Background => Words {
            title: "1  Without object",
            record: "Record without object",
            hint: "The scene as it is (F). Nothing may move while it is recorded.",
        },
        Stage::Object => Words {
            title: "2  With object",
            record: "Record with object",
            hint: "Put the object in first (S). Camera and projector must not move.",
        },
    }
}

fn stage(model: &mut Model, stage: Stage, ui: &mut Ui) {
    let words = words(stage);
    let slot = &model.scan.stages[usize::from(stage == Stage::Object)];
    let (recorded, accepted) = (slot.recorded, slot.accepted);
    let next = next(model);
    let quality = slot.view.as_ref().map(|view| view.quality.clone());
    ui.horizontal(|ui| {
        ui.label(RichText::new(words.title).strong());
        if accepted {
            style::lamp(ui, GOOD);
            ui.label(RichText::new("kept").small());
        }
        if quality.is_some() {
            let right = egui::Layout::right_to_left(egui::Align::Center);
            ui.with_layout(right, |ui| {
                if ui
                    .link("See the steps")
                    .on_hover_text("Look at what every step made of it")
                    .clicked()
                {
                    model.steps.stage = stage;
                    model.tab = Tab::Steps;
                }
            });
        }
    });
    if !recorded {
        let may = model.may_record(stage);
        let is_next = next == Next::Record(stage);
        if style::step(ui, may, words.record, is_next)
            .on_hover_text(words.hint)
            .clicked()
        {
            model.record(stage);
        }
        return;
    }
    style::card(ui, |ui| match &quality {
        Some(quality) => show_quality(ui, quality),
        None => {
            ui.label("Reading the captures ...");
        }
    });
    ui.horizontal(|ui| {
        let half = style::half(ui);
        let text = if accepted { "Kept" } else { "Keep" };
        let may_keep = quality.is_some() && !accepted;
        let keep = match next == Next::Keep(stage) && may_keep {
            true => style::wide_primary(ui, text, half),
            false => style::wide(ui, may_keep, text, half),
        };
        if keep.on_hover_text("Go on with these captures").clicked() {
            accept(model, stage);
        }
        let retake = style::wide(ui, model.may_record(stage), "Retake", half);
        if retake
            .on_hover_text("Record this stage again, in place of what is there")
            .clicked()
        {
            model.record(stage);
        }
    });
}

fn accept(model: &mut Model, stage: Stage) {
    model.scan.stages[usize::from(stage == Stage::Object)].accepted = true;
    if stage == Stage::Object {
        read(model);
    }
}

fn read(model: &mut Model) {
    if let Some(dir) = model.scan.dir.clone() {
        model.ask_files(FileJob::Read(dir, Place::Result));
    }
}

/// What one should know before one keeps the captures.
fn show_quality(ui: &mut Ui, quality: &Quality) {
    let coverage = quality.coverage_percent();
    ui.horizontal(|ui| {
        style::lamp(ui, style::judged(coverage, [90.0, 60.0]));
        ui.label(RichText::new(format!("{coverage:.1} % of the crossings read")).strong());
        let of = format!("{} of {}", quality.labelled, quality.possible);
        ui.label(RichText::new(of).small().weak());
    });
    ui.spacing_mut().item_spacing.y = 2.0;
    ui.spacing_mut().interact_size.y = 16.0;
    for (&reason, count) in &quality.holes {
        ui.horizontal(|ui| {
            let (place, _) = ui.allocate_exact_size(vec2(10.0, 14.0), Sense::hover());
            overlay::cross(ui.painter(), place.center(), hole_colour(reason));
            ui.label(RichText::new(format!("{count} {}", reason_words(reason))).small());
        });
    }
    let unseen = quality.unseen();
    if unseen > 0 {
        ui.horizontal(|ui| {
            style::lamp(ui, ui.visuals().weak_text_color());
            ui.label(RichText::new(format!("{unseen} not in sight")).small())
                .on_hover_text(
                    "Outside the picture, hidden, or so weak that no line was found there",
                );
        });
    }
    let clipped = quality.clipped_percent;
    let colour = style::judged(100.0 - clipped, [98.0, 90.0]);
    ui.horizontal(|ui| {
        style::lamp(ui, colour);
        ui.label(RichText::new(format!("{clipped:.1} % of the pixels clipped")).small());
    });
    if let Some(advice) = advice(quality) {
        ui.label(RichText::new(advice).small().italics());
    }
}

/// What to do about a stage that is not good.
fn advice(quality: &Quality) -> Option<&'static str> {
    if quality.clipped_percent > 5.0 {
        return Some("Too bright: shorten the exposure, or dim the projector, and take it again.");
    }
    (quality.coverage_percent() < 60.0).then_some(
        "Little was read: keep the scene still, dim the room, measure the colours on this scene, or use wider lines.",
    )
}

fn finish(model: &mut Model, ui: &mut Ui) {
    let any = model.scan.stages.iter().any(|slot| slot.recorded);
    ui.label(RichText::new("3  Shape").strong());
    let may = any && !model.is_busy(Who::Files) && !model.is_busy(Who::Rig);
    let text = if is_computed(model) {
        "Compute the shape again"
    } else {
        "Compute the shape"
    };
    let hint = "Labels, shifts, surface and report, written beside the captures";
    let is_next = next(model) == Next::Compute;
    let compute = style::step(ui, may, text, is_next);
    if compute.on_hover_text(hint).clicked() {
        read(model);
    }
}

fn more(model: &mut Model, ui: &mut Ui) {
    let ready = model.is_ready() && model.scan.stages[0].recorded;
    ui.horizontal(|ui| {
        let half = style::half(ui);
        let next = style::wide(ui, ready, "Next object", half);
        let hint = "Another object in front of the same background, in a folder of its own";
        if next.on_hover_text(hint).clicked() {
            model.ask(Job::NextObject);
        }
        let new = style::wide(ui, ready, "New scan", half);
        if new
            .on_hover_text("Begin anew, with another background")
            .clicked()
        {
            model.ask(Job::NewScan);
        }
    });
    let dir = model.scan.dir.as_ref().unwrap_or(&model.out);
    let verb = if model.scan.dir.is_some() {
        "Recorded into"
    } else {
        "Will be recorded into"
    };
    ui.label(
        RichText::new(format!("{verb} {}", dir.display()))
            .small()
            .weak(),
    );
    if model.scan.objects > 0 {
        let text = format!(
            "Object {} in front of this background",
            model.scan.objects + 1
        );
        ui.label(RichText::new(text).small().weak());
    }
}
