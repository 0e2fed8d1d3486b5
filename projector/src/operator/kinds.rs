//! What is on the wall: a small true picture of it, and a tile for every kind of picture.

use egui::{
    Color32, CornerRadius, Rect, Response, RichText, Role, Sense, Stroke, StrokeKind, Ui, Vec2,
    WidgetInfo, emath::GuiRounding as _, pos2, vec2,
};
use shared::{
    pattern::{RasterSize, Rgb},
    protocol::View,
};

use super::{Action, OperatorView, Panels, name_of, show, style, widgets};

/// Size of a tile's picture, in points.
const TILE_PICTURE: Vec2 = vec2(58.0, 40.0);
/// Least width of a tile, in points.
const TILE_WIDTH: f32 = 92.0;
const TILE_HEIGHT: f32 = 80.0;
/// The least height that is left to the preview, in points.
const LEAST_PREVIEW: f32 = 140.0;
/// What the tiles take below the preview, in points.
const BELOW_PREVIEW: f32 = 388.0;

/// The kinds of picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Prmvs,
    TwoColour,
    Unary,
    Solid,
    Black,
    White,
    TestCard,
    Identify,
    Ramp,
}

impl Kind {
    const ALL: [Self; 9] = [
        Self::Prmvs,
        Self::TwoColour,
        Self::Unary,
        Self::Solid,
        Self::Black,
        Self::White,
        Self::TestCard,
        Self::Identify,
        Self::Ramp,
    ];

    /// The kind of a view; `None` for a grid of a client's own.
    fn of(view: &View) -> Option<Self> {
        Some(match view {
            View::Coded => Self::Prmvs,
            View::TwoColour => Self::TwoColour,
            View::Unary => Self::Unary,
            View::Solid { .. } => Self::Solid,
            View::Black => Self::Black,
            View::White => Self::White,
            View::TestCard => Self::TestCard,
            View::Identify => Self::Identify,
            View::Ramp => Self::Ramp,
            View::Grid(_) => return None,
        })
    }

    fn view(self, solid: Rgb) -> View {
        match self {
            Self::Prmvs => View::Coded,
            Self::TwoColour => View::TwoColour,
            Self::Unary => View::Unary,
            Self::Solid => View::Solid { colour: solid },
            Self::Black => View::Black,
            Self::White => View::White,
            Self::TestCard => View::TestCard,
            Self::Identify => View::Identify,
            Self::Ramp => View::Ramp,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Prmvs => "PRMVS",
            Self::TwoColour => "Two-colour",
            Self::Unary => "Unary",
            Self::Solid => "Solid",
            Self::Black => "Black",
            Self::White => "White",
            Self::TestCard => "Test card",
            Self::Identify => "Identify",
            Self::Ramp => "Ramp",
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Prmvs => "The coded grid: every small window of it tells where it is.\nKey: C",
            Self::TwoColour => {
                "As many lines in the first two colours, coded by two symbols.\nKey: 2"
            }
            Self::Unary => {
                "The same lines, all in the unary colour: geometry without labels.\nKey: U"
            }
            Self::Solid => "One of the sixteen colours all over.",
            Self::Black => "No light: the room's own.\nKey: K",
            Self::White => "All light: the scene as it is.\nKey: W",
            Self::TestCard => {
                "For focus and keystone: line pairs, chequers, circles, text, greys.\nKey: T"
            }
            Self::Identify => {
                "The monitor's name, until something else is shown.\nKey I shows it for 5 seconds"
            }
            Self::Ramp => {
                "Every byte value in every channel: nothing on the way may change one.\nKey: R"
            }
        }
    }
}

/// The preview, and the tiles below it.
pub(super) fn wall(ui: &mut Ui, view: &OperatorView, panels: &mut Panels, asked: &mut Vec<Action>) {
    widgets::card(ui, "On the wall", |ui| preview(ui, view, panels));
    widgets::card(ui, "Picture", |ui| {
        tiles(ui, view, panels, asked);
        if let View::Solid { colour } = view.overview.state.view {
            solid_colours(ui, colour, panels, asked);
        }
    });
}

fn preview(ui: &mut Ui, view: &OperatorView, panels: &mut Panels) {
    let overview = &view.overview;
    let shown = &overview.state.shown;
    let room = vec2(
        ui.available_width(),
        (panels.height - BELOW_PREVIEW).max(LEAST_PREVIEW),
    );
    let raster = shown.raster;
    let aspect = raster.width as f32 / raster.height.max(1) as f32;
    let width = room.x.min(room.y * aspect);
    let scale = ui.pixels_per_point();
    let pixels = |points: f32| (points * scale).round().max(1.0);
    let (width_px, height_px) = (pixels(width), pixels(width / aspect));
    panels.preview_px = RasterSize {
        width: width_px as u32,
        height: height_px as u32,
    };
    let size = vec2(width_px, height_px) / scale;
    let name = name_of(&shown.pattern, &panels.palette);
    ui.vertical_centered(|ui| {
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        // On whole pixels, so that its pixels are the monitor's.
        let rect = rect.translate(rect.min.round_to_pixels(scale) - rect.min);
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("Preview: {name}")));
        let painter = ui.painter();
        painter.rect_filled(rect, CornerRadius::ZERO, Color32::BLACK);
        if let Some(texture) = &view.preview {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture.id(), rect, whole, Color32::WHITE);
        }
        let line = ui.visuals().widgets.noninteractive.bg_stroke;
        painter.rect_stroke(rect, CornerRadius::ZERO, line, StrokeKind::Outside);
    });
    ui.horizontal_wrapped(|ui| {
        ui.label(name);
        ui.label(RichText::new(standing(view)).weak());
    });
}

/// How the picture stands: on its way, blanked, in a sequence, or there.
fn standing(view: &OperatorView) -> String {
    let overview = &view.overview;
    if overview.steps_left > 0 {
        return format!("in a sequence, {} more to come", overview.steps_left);
    }
    if overview.on_its_way {
        return "the next one is on its way".to_owned();
    }
    if overview.identifying {
        return "for some seconds".to_owned();
    }
    if overview.state.blank {
        return "blanked: Show again brings the picture back".to_owned();
    }
    let serial = overview.state.shown.serial;
    match Kind::of(&overview.state.view) {
        Some(_) => format!("picture {serial}"),
        None => format!("picture {serial}, a grid of the client's own"),
    }
}

fn tiles(ui: &mut Ui, view: &OperatorView, panels: &mut Panels, asked: &mut Vec<Action>) {
    let current = Kind::of(&view.overview.state.view);
    let gap = ui.spacing().item_spacing.x;
    let room = ui.available_width();
    let columns = (((room + gap) / (TILE_WIDTH + gap)) as usize).clamp(1, Kind::ALL.len());
    // as even as it goes: 9 tiles in 5 columns are 5 and 4
    let columns = Kind::ALL.len().div_ceil(Kind::ALL.len().div_ceil(columns));
    let width = (room - gap * (columns - 1) as f32) / columns as f32;
    for row in Kind::ALL.chunks(columns) {
        ui.horizontal(|ui| {
            for &kind in row {
                let tile = tile(ui, kind, width, current == Some(kind), view, panels);
                if tile.on_hover_text(kind.hint()).clicked() {
                    asked.push(show(kind.view(panels.solid)));
                }
            }
        });
    }
}

fn tile(
    ui: &mut Ui,
    kind: Kind,
    width: f32,
    chosen: bool,
    view: &OperatorView,
    panels: &Panels,
) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(width, TILE_HEIGHT), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, chosen, kind.name()));
    let visuals = ui.style().interact(&response);
    let line = if response.has_focus() {
        visuals.bg_stroke
    } else {
        style::chosen(ui, chosen)
    };
    ui.painter().rect(
        rect,
        CornerRadius::same(6),
        visuals.weak_bg_fill,
        line,
        StrokeKind::Inside,
    );
    let at = pos2(rect.center().x - TILE_PICTURE.x / 2.0, rect.top() + 10.0);
    small_picture(
        ui,
        Rect::from_min_size(at, TILE_PICTURE),
        kind,
        view,
        panels.solid,
    );
    let font = egui::TextStyle::Button.resolve(ui.style());
    let below = pos2(rect.center().x, rect.bottom() - 16.0);
    ui.painter().text(
        below,
        egui::Align2::CENTER_CENTER,
        kind.name(),
        font,
        visuals.text_color(),
    );
    response
}

/// A tile's picture: not to scale, in the colours that would be shown.
fn small_picture(ui: &Ui, rect: Rect, kind: Kind, view: &OperatorView, solid: Rgb) {
    let grid = &view.overview.state.grid;
    let painter = ui.painter().with_clip_rect(rect);
    let fill = |colour: Color32| painter.rect_filled(rect, CornerRadius::ZERO, colour);
    let colours = grid.coded.colours();
    let lines = |count: usize| {
        fill(Color32::BLACK);
        let colour = |k: usize| {
            if count == 1 {
                grid.unary
            } else {
                colours[k % count.min(colours.len())]
            }
        };
        for k in 0..3 {
            let y = rect.top() + rect.height() * (k as f32 + 0.5) / 3.0;
            painter.hline(
                rect.x_range(),
                y,
                Stroke::new(3.0, widgets::screen_colour(colour(k + 1))),
            );
        }
        for k in 0..4 {
            let x = rect.left() + rect.width() * (k as f32 + 0.5) / 4.0;
            painter.vline(
                x,
                rect.y_range(),
                Stroke::new(3.0, widgets::screen_colour(colour(k))),
            );
        }
    };
    let white = Stroke::new(1.0, Color32::WHITE);
    match kind {
        Kind::Prmvs => lines(colours.len().max(2)),
        Kind::TwoColour => lines(2),
        Kind::Unary => lines(1),
        Kind::Solid => drop(fill(widgets::screen_colour(solid))),
        Kind::Black => drop(fill(Color32::BLACK)),
        Kind::White => drop(fill(Color32::WHITE)),
        Kind::TestCard => {
            fill(Color32::BLACK);
            painter.circle_stroke(rect.center(), rect.height() * 0.42, white);
            painter.hline(rect.x_range(), rect.center().y, white);
            painter.vline(rect.center().x, rect.y_range(), white);
        }
        Kind::Identify => {
            fill(Color32::from_rgb(16, 32, 64));
            let font = egui::FontId::proportional(18.0);
            painter.text(
                rect.center(),
                egui::Align2::CENTER_CENTER,
                "ABC",
                font,
                Color32::WHITE,
            );
        }
        Kind::Ramp => {
            let steps = 16;
            for k in 0..steps {
                let part = rect.width() / steps as f32;
                let left = rect.left() + part * k as f32;
                let strip =
                    Rect::from_min_size(pos2(left, rect.top()), vec2(part + 0.5, rect.height()));
                let value = (k * 255 / (steps - 1)) as u8;
                painter.rect_filled(
                    strip,
                    CornerRadius::ZERO,
                    Color32::from_rgb(value, 255 - value, value),
                );
            }
        }
    }
    painter.rect_stroke(
        rect,
        CornerRadius::ZERO,
        style::chosen(ui, false),
        StrokeKind::Inside,
    );
}

fn solid_colours(ui: &mut Ui, current: Rgb, panels: &mut Panels, asked: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        for entry in panels.palette.colours().to_vec() {
            let (rect, response) = ui.allocate_exact_size(vec2(28.0, 24.0), Sense::click());
            let chosen = entry.colour == current;
            let name = format!("Solid {}", entry.name);
            response.widget_info(|| WidgetInfo::selected(Role::Button, true, chosen, &name));
            let line = style::chosen(ui, chosen);
            let fill = widgets::screen_colour(entry.colour);
            ui.painter()
                .rect(rect, CornerRadius::same(4), fill, line, StrokeKind::Inside);
            if response.on_hover_text(&entry.name).clicked() {
                panels.solid = entry.colour;
                asked.push(show(View::Solid {
                    colour: entry.colour,
                }));
            }
        }
    });
}
