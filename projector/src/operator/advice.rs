//! What is doubtful about the grid: lines that touch, colours that are alike, lines too fine for the camera.

use egui::{ComboBox, RichText, Ui};
use shared::pattern::{CameraScale, GridSettings, Palette, RasterSize};

use super::{OperatorView, Panels, widgets};

/// Sizes of usual cameras' pictures.
pub(super) const CAMERAS: [RasterSize; 3] = [
    RasterSize {
        width: 640,
        height: 480,
    },
    RasterSize {
        width: 1280,
        height: 720,
    },
    RasterSize {
        width: 1920,
        height: 1080,
    },
];

/// The card with the warnings.
pub(super) fn card(ui: &mut Ui, view: &OperatorView, panels: &mut Panels) {
    let state = &view.overview.state;
    widgets::card(ui, "Check", |ui| {
        let error = ui.visuals().error_fg_color;
        if let Some(problem) = &state.screen.problem {
            widgets::dotted(ui, error, sentence(problem));
        }
        let warnings = warnings(&state.grid, state.screen.raster, panels);
        for warning in &warnings {
            let warn = ui.visuals().warn_fg_color;
            widgets::dotted(ui, warn, RichText::new(sentence(warning)).color(warn));
        }
        if warnings.is_empty() {
            let good = ui.visuals().weak_text_color();
            widgets::dotted(
                ui,
                good,
                "The lines are apart, and the camera can tell them apart.",
            );
        }
        ui.horizontal(|ui| {
            let label = ui.label(RichText::new("For a camera of").weak());
            let camera = &mut panels.camera;
            ComboBox::from_id_salt("camera")
                .selected_text(camera.to_string())
                .show_ui(ui, |ui| {
                    for size in CAMERAS {
                        ui.selectable_value(camera, size, size.to_string());
                    }
                })
                .response
                .labelled_by(label.id)
                .on_hover_text("Size of the camera's picture, if the projector's just fills it.");
        });
    });
}

/// The card with what the log warned of; none without warnings.
pub(super) fn log(ui: &mut Ui, panels: &mut Panels) {
    if panels.warnings.is_empty() {
        return;
    }
    widgets::card(ui, "Warnings", |ui| {
        let warn = ui.visuals().warn_fg_color;
        for warning in &panels.warnings {
            widgets::dotted(ui, warn, sentence(warning));
        }
        if ui.button("Dismiss").clicked() {
            panels.warnings.clear();
        }
    });
}

fn warnings(settings: &GridSettings, raster: RasterSize, panels: &Panels) -> Vec<String> {
    let grid = &settings.coded;
    let scale = CameraScale::filling(raster, panels.camera);
    let mut warnings = alike(settings, &panels.palette);
    warnings.extend(grid.warnings(raster));
    warnings.extend(grid.camera_warnings(raster, scale));
    warnings
}

/// Two symbols in one colour cannot be told apart.
fn alike(settings: &GridSettings, palette: &Palette) -> Vec<String> {
    let colours = settings.coded.colours();
    let twice = |k: &usize| colours[..*k].contains(&colours[*k]);
    let text = |k: usize| {
        let first = colours
            .iter()
            .position(|colour| *colour == colours[k])
            .unwrap_or(0);
        let name = palette.name_of(colours[k]);
        format!(
            "colours {} and {} are both {name}: the code cannot be read",
            first + 1,
            k + 1
        )
    };
    (0..colours.len()).filter(twice).map(text).collect()
}

fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).collect()
}
