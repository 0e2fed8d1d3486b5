//! Where the picture goes and who may change it.

use egui::{Button, RichText, Ui, vec2};
use shared::protocol::{Role, ScreenKind};

use super::{Action, OperatorView, widgets};
use crate::screen::Monitor;

/// The card with the monitors.
pub(super) fn monitors(ui: &mut Ui, view: &OperatorView, asked: &mut Vec<Action>) {
    let screen = &view.overview.state.screen;
    widgets::card(ui, "Monitor", |ui| {
        for monitor in &view.monitors {
            let chosen = screen.kind == ScreenKind::FullScreen && screen.name == monitor.name;
            let button = Button::selectable(
                chosen,
                (
                    monitor.name.as_str(),
                    egui::Atom::grow(),
                    RichText::new(describe(monitor)).small(),
                ),
            );
            let wide = button.min_size(vec2(ui.available_width(), 0.0));
            let hint = "Fills this monitor with the picture.";
            if ui.add(wide).on_hover_text(hint).clicked() && !chosen {
                asked.push(Action::MoveTo(monitor.name.clone()));
            }
        }
        if screen.kind == ScreenKind::Window {
            ui.label(
                RichText::new("The picture is in a window: click a monitor to fill it.").weak(),
            );
        }
    });
}

fn describe(monitor: &Monitor) -> String {
    let rate = monitor
        .refresh_hz
        .map(|rate| format!(" · {rate:.0} Hz"))
        .unwrap_or_default();
    let primary = if monitor.primary { " · primary" } else { "" };
    format!("{}x{}{rate}{primary}", monitor.width, monitor.height)
}

/// The card with the programs that are connected.
pub(super) fn people(ui: &mut Ui, view: &OperatorView) {
    let overview = &view.overview;
    widgets::card(ui, "Connected", |ui| {
        for member in &overview.members {
            let (colour, what) = match member.role {
                Role::Controller => (ui.visuals().selection.bg_fill, "controls"),
                Role::Watcher => (ui.visuals().weak_text_color(), "watches"),
            };
            widgets::dotted(ui, colour, format!("{} {what}", member.name));
        }
        if overview.members.is_empty() {
            ui.label("Nobody.");
        }
        if overview.state.controller.is_none() {
            ui.label(
                RichText::new("Nobody controls: the picture stays until you change it.").weak(),
            );
        }
        if let Some(address) = view.listening {
            ui.label(RichText::new(format!("Commands are taken on {address}.")).weak());
        }
    });
}
