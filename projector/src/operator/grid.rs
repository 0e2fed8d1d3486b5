//! The grid: its colours, how many lines, how wide.

use egui::{DragValue, Grid, Ui};
use shared::{
    pattern::{Axis, GridSettings, LINE_COUNTS, MAX_WIDTH_PX, Rgb},
    protocol::Command,
};

use super::{Action, OperatorView, Panels, widgets};

const ORDINALS: [&str; 4] = [
    "First colour",
    "Second colour",
    "Third colour",
    "Fourth colour",
];

/// The card with the settings of the grid.
pub(super) fn card(ui: &mut Ui, view: &OperatorView, panels: &mut Panels, asked: &mut Vec<Action>) {
    let settings = &view.overview.state.grid;
    widgets::card(ui, "Grid", |ui| {
        Grid::new("colours")
            .num_columns(2)
            .show(ui, |ui| colours(ui, settings, panels, asked));
        ui.separator();
        Grid::new("lines")
            .num_columns(4)
            .show(ui, |ui| lines(ui, settings, panels, asked));
    });
}

fn colours(ui: &mut Ui, settings: &GridSettings, panels: &Panels, asked: &mut Vec<Action>) {
    let coded = settings.coded.colours();
    for (k, &colour) in coded.iter().enumerate() {
        let name = ORDINALS
            .get(k)
            .map_or_else(|| format!("Colour {}", k + 1), |&name| name.into());
        let label = ui.label(name);
        if let Some(chosen) = widgets::colour_menu(ui, &label, colour, &panels.palette) {
            let mut colours = coded.to_vec();
            colours[k] = chosen;
            asked.push(set_colours(colours, settings.unary));
        }
        ui.end_row();
    }
    let label = ui.label("Unary colour");
    if let Some(chosen) = widgets::colour_menu(ui, &label, settings.unary, &panels.palette) {
        asked.push(set_colours(coded.to_vec(), chosen));
    }
    ui.end_row();
}

fn set_colours(colours: Vec<Rgb>, unary: Rgb) -> Action {
    Action::Command(Command::SetColours { colours, unary })
}

fn lines(ui: &mut Ui, settings: &GridSettings, panels: &mut Panels, asked: &mut Vec<Action>) {
    let grid = &settings.coded;
    let (mut rows, mut columns) = (grid.rows(), grid.columns());
    let now = [grid.width_px(Axis::Row), grid.width_px(Axis::Column)];
    let mut widths = panels.widths.unwrap_or(now);
    let mut busy = false;
    for (k, (name, width_name)) in [("Rows", "Row width"), ("Columns", "Column width")]
        .into_iter()
        .enumerate()
    {
        let count = if k == 0 { &mut rows } else { &mut columns };
        let label = ui.label(name).id;
        if let Some(chosen) = widgets::number_menu(ui, label, *count, &LINE_COUNTS) {
            *count = chosen;
        }
        let label = ui.label(width_name).id;
        let value = DragValue::new(&mut widths[k])
            .range(1..=MAX_WIDTH_PX)
            .speed(0.1)
            .suffix(" px");
        let response = ui.add(value).labelled_by(label);
        busy |= response.dragged() || response.has_focus();
        response.on_hover_text("Width of a line in projector pixels. Drag, or click and type.");
        ui.end_row();
    }
    if (rows, columns) != (grid.rows(), grid.columns()) {
        asked.push(Action::Command(Command::SetLines { rows, columns }));
    }
    if widths != panels.widths.unwrap_or(now) {
        let [row_width_px, column_width_px] = widths;
        asked.push(Action::Command(Command::SetWidths {
            row_width_px,
            column_width_px,
        }));
    }
    panels.widths = busy.then_some(widths);
}
