//! The operator's window: what is on the wall, with everything to change it.
//!
//! ```text
//! state --overview--> OperatorView --ui()--> light on the operator's monitor
//!       <--command--                 <-click-
//! ```
//!
//! [`ui`] draws what the state says and gives back what the operator asks for; it changes nothing itself, so the
//! window, the keys and the network all meet in the state. It knows no window system: `screen` brings it to a
//! monitor, the tests to a picture.

pub mod preview;

mod kinds;

mod grid;

mod advice;

mod place;

mod widgets;

mod style;

pub use look::style::install as install_style;

use std::net::SocketAddr;

use egui::{Align, CentralPanel, Layout, Panel, RichText, ScrollArea, TextureHandle, Ui, vec2};
use shared::{
    pattern::{Palette, Pattern, RasterSize, Rgb},
    protocol::{Command, View},
};

use crate::{screen::Monitor, state::Overview};

/// Least width for two columns side by side, in points; a narrower window has one.
const TWO_COLUMNS: f32 = 720.0;
/// Width of the column with the settings, in points.
const SETTINGS_WIDTH: f32 = 380.0;
/// Seconds for which the card is shown that tells which monitor is the projector.
const IDENTIFY_S: u32 = 5;

/// Everything the window shows.
#[derive(Clone)]
pub struct OperatorView {
    /// The state of the projector.
    pub overview: Overview,
    /// The monitors there are.
    pub monitors: Vec<Monitor>,
    /// Where commands are taken from the network.
    pub listening: Option<SocketAddr>,
    /// The picture on the wall, made small.
    pub preview: Option<TextureHandle>,
}

/// What the operator asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// A change of the state, the same that a key or a client may ask for.
    Command(Command),
    /// The picture is to fill the monitor of this name.
    MoveTo(String),
    /// The program is to end.
    End,
}

/// What the window remembers by itself: nothing of it is on the wall.
#[derive(Debug, Clone)]
pub struct Panels {
    palette: Palette,
    /// The camera that warnings are judged for.
    camera: RasterSize,
    /// The colour that the solid picture gets.
    solid: Rgb,
    /// Line widths while they are being dragged: row, column.
    widths: Option<[u32; 2]>,
    /// Size of the preview in physical pixels.
    preview_px: RasterSize,
    /// Height of all that is drawn, in points.
    height: f32,
}

impl Default for Panels {
    fn default() -> Self {
        Self {
            palette: Palette::default(),
            camera: advice::CAMERAS[0],
            solid: Rgb([255, 0, 0]),
            widths: None,
            preview_px: RasterSize {
                width: 1,
                height: 1,
            },
            height: 0.0,
        }
    }
}

impl Panels {
    /// The size that the preview is to have so that its pixels are the monitor's, in physical pixels.
    #[must_use]
    pub fn preview_px(&self) -> RasterSize {
        self.preview_px
    }
}

/// Draws the window and gives what the operator asks for, in order.
pub fn ui(ui: &mut Ui, view: &OperatorView, panels: &mut Panels) -> Vec<Action> {
    let mut asked = Vec::new();
    panels.height = ui.available_height();
    Panel::top("bar")
        .frame(style::bar(ui))
        .show(ui, |ui| bar(ui, view, &mut asked));
    if ui.available_width() < TWO_COLUMNS {
        CentralPanel::default()
            .frame(style::column(ui))
            .show(ui, |ui| {
                ScrollArea::vertical().show(ui, |ui| {
                    kinds::wall(ui, view, panels, &mut asked);
                    settings(ui, view, panels, &mut asked);
                });
            });
        return asked;
    }
    Panel::right("settings")
        .exact_size(SETTINGS_WIDTH)
        .resizable(false)
        .show_separator_line(false)
        .frame(style::column(ui))
        .show(ui, |ui| {
            ScrollArea::vertical().show(ui, |ui| settings(ui, view, panels, &mut asked));
        });
    CentralPanel::default()
        .frame(style::column(ui))
        .show(ui, |ui| {
            ScrollArea::vertical().show(ui, |ui| kinds::wall(ui, view, panels, &mut asked));
        });
    asked
}

fn settings(ui: &mut Ui, view: &OperatorView, panels: &mut Panels, asked: &mut Vec<Action>) {
    grid::card(ui, view, panels, asked);
    advice::card(ui, view, panels);
    place::monitors(ui, view, asked);
    place::people(ui, view);
}

/// What is shown where, and the switches that concern all of it.
fn bar(ui: &mut Ui, view: &OperatorView, asked: &mut Vec<Action>) {
    let state = &view.overview.state;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing = vec2(10.0, 0.0);
        ui.label(RichText::new("Projector").heading());
        ui.label(RichText::new(format!("{} · {}", state.screen.name, state.screen.raster)).weak());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let end = ui
                .button("End")
                .on_hover_text("Ends the program.\nKey in the picture: Escape");
            if end.clicked() {
                asked.push(Action::End);
            }
            widgets::theme_button(ui);
            ui.separator();
            let text = if state.blank { "Show again" } else { "Blank" };
            let hint = "Turns the picture black, and back to what was shown.\nKey: B";
            if widgets::switch(ui, text, state.blank)
                .on_hover_text(hint)
                .clicked()
            {
                asked.push(Action::Command(Command::Blank { on: !state.blank }));
            }
            let hint = format!("Shows for {IDENTIFY_S} seconds which monitor this is.\nKey: I");
            if ui.button("Identify").on_hover_text(hint).clicked() {
                let seconds = IDENTIFY_S;
                asked.push(Action::Command(Command::Identify { seconds }));
            }
        });
    });
}

/// What a picture is called on the wall.
fn name_of(pattern: &Pattern, palette: &Palette) -> String {
    match pattern {
        Pattern::Grid(grid) => {
            let kind = match grid.colours().len() {
                1 => "Unary grid",
                2 => "Two-colour grid",
                4 => "PRMVS grid",
                _ => "Grid",
            };
            format!("{kind}, {} rows, {} columns", grid.rows(), grid.columns())
        }
        Pattern::Solid { colour: Rgb::BLACK } => "Black".to_owned(),
        Pattern::Solid { colour } => format!("Solid {}", palette.name_of(*colour)),
        Pattern::Ramp => "Ramp of all byte values".to_owned(),
        Pattern::TestCard => "Test card".to_owned(),
        Pattern::Identify { .. } => "Identify card".to_owned(),
        Pattern::PairingCode { .. } => "Pairing code".to_owned(),
    }
}

/// A view as a command.
fn show(view: View) -> Action {
    Action::Command(Command::Show { view })
}
