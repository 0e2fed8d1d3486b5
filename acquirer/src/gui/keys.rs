//! Keys that do what buttons do.

use eframe::egui::{self, Key, Modifiers};
use shared::stage::Stage;

use super::{
    events::Job,
    model::{Model, Side, Tab},
};

/// What a key does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Action {
    Tab(Tab),
    Side(Side),
    Update,
    After,
    Subtract,
    Histogram,
    Grid,
    Labels,
    Holes,
    Clipping,
    Shadow,
    ReadLive,
    Pick,
    Apply,
    Record(Stage),
    Cancel,
    Help,
}

/// A key, what it is called, what it does, and in which words.
pub(super) struct Shortcut {
    /// The key; none needs another held down.
    pub(super) key: Key,
    /// What it does.
    pub(super) action: Action,
    /// The same for people.
    pub(super) words: &'static str,
}

const fn shortcut(key: Key, action: Action, words: &'static str) -> Shortcut {
    Shortcut { key, action, words }
}

/// All keys, as the help shows them.
pub(super) const SHORTCUTS: [Shortcut; 23] = [
    shortcut(Key::Num1, Action::Tab(Tab::Live), "live picture"),
    shortcut(Key::Num2, Action::Tab(Tab::Steps), "steps of the reading"),
    shortcut(Key::Num3, Action::Tab(Tab::Result), "result"),
    shortcut(Key::Num4, Action::Tab(Tab::Compare), "compare two scans"),
    shortcut(Key::F2, Action::Side(Side::Source), "source panel"),
    shortcut(Key::F3, Action::Side(Side::Colours), "colours panel"),
    shortcut(Key::F4, Action::Side(Side::Scan), "scan panel"),
    shortcut(Key::U, Action::Update, "live update on or off (U)"),
    shortcut(
        Key::O,
        Action::After,
        "picture before or after processing (ONE)",
    ),
    shortcut(Key::B, Action::Subtract, "background removal (SUB)"),
    shortcut(Key::H, Action::Histogram, "histogram of hues (HIST)"),
    shortcut(Key::R, Action::ReadLive, "read every frame, or stop"),
    shortcut(Key::G, Action::Grid, "overlay: recovered grid"),
    shortcut(Key::L, Action::Labels, "overlay: labels"),
    shortcut(Key::X, Action::Holes, "overlay: holes"),
    shortcut(Key::C, Action::Clipping, "overlay: clipping and black"),
    shortcut(Key::M, Action::Shadow, "overlay: shadow mask"),
    shortcut(Key::P, Action::Pick, "pick the colours"),
    shortcut(Key::A, Action::Apply, "apply the colours"),
    shortcut(
        Key::F,
        Action::Record(Stage::Background),
        "record without object (F)",
    ),
    shortcut(
        Key::S,
        Action::Record(Stage::Object),
        "record with object (S)",
    ),
    shortcut(Key::Escape, Action::Cancel, "cancel what is under way"),
    shortcut(Key::F1, Action::Help, "this help"),
];

/// Does what the pressed keys ask for, unless something is being written.
pub(super) fn handle(model: &mut Model, context: &egui::Context) {
    if context.egui_wants_keyboard_input() {
        return;
    }
    for shortcut in &SHORTCUTS {
        let pressed = context.input_mut(|input| match shortcut.action {
            // menus close by it as well
            Action::Cancel => input.key_pressed(shortcut.key),
            _ => input.consume_key(Modifiers::NONE, shortcut.key),
        });
        if pressed {
            act(model, shortcut.action);
        }
    }
}

fn act(model: &mut Model, action: Action) {
    let preferences = &mut model.preferences;
    let overlays = &mut preferences.overlays;
    let turn = |switch: &mut bool| *switch = !*switch;
    match action {
        Action::Tab(tab) => model.tab = tab,
        Action::Side(side) => model.side = side,
        Action::Update => turn(&mut model.live.frozen),
        Action::After => turn(&mut preferences.after),
        Action::Subtract => turn(&mut preferences.subtract),
        Action::Histogram => turn(&mut preferences.histogram),
        Action::Grid => turn(&mut overlays.grid),
        Action::Labels => turn(&mut overlays.labels),
        Action::Holes => turn(&mut overlays.holes),
        Action::Clipping => turn(&mut overlays.clipping),
        Action::Shadow => turn(&mut overlays.shadow),
        Action::ReadLive => model.set_read_live(!model.preferences.read_live),
        Action::Pick => model.ask_if_ready(Job::PickColours { apply: false }),
        Action::Apply => model.apply_colours(),
        Action::Record(stage) => model.record(stage),
        Action::Cancel => model.cancel(),
        Action::Help => turn(&mut model.show_help),
    }
}
