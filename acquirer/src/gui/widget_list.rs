//! A list of what stands where in the window, for scripts that click: tests of the real window, and the pictures in
//! the README.
//!
//! With the variable `ACQUIRER_WIDGETS=FILE` the window writes FILE anew, a few times a second: one JSON array of
//! widgets with their label, their middle in pixels of the window's inside, and whether they can be used.

use std::{
    env, fs,
    path::PathBuf,
    time::{Duration, Instant},
};

use eframe::egui::{
    self, FullOutput,
    accesskit::{Node, Role},
    plugin::Plugin,
};
use serde::Serialize;

/// Time between two lists.
const PERIOD: Duration = Duration::from_millis(200);
const VARIABLE: &str = "ACQUIRER_WIDGETS";

#[derive(Debug, Serialize)]
struct Listed {
    label: String,
    x: f64,
    y: f64,
    enabled: bool,
}

/// Writes the list.
struct WidgetList {
    file: PathBuf,
    written: Option<Instant>,
}

/// Starts writing the list if the variable asks for it.
pub(super) fn start_if_wanted(context: &egui::Context) {
    if let Some(file) = env::var_os(VARIABLE) {
        context.add_plugin(WidgetList {
            file: file.into(),
            written: None,
        });
    }
}

impl Plugin for WidgetList {
    fn debug_name(&self) -> &'static str {
        "widget list"
    }

    fn on_begin_pass(&mut self, ui: &mut egui::Ui) {
        ui.ctx().enable_accesskit();
    }

    fn output_hook(&mut self, context: &egui::Context, output: &mut FullOutput) {
        let Some(tree) = &output.platform_output.accesskit_update else {
            return;
        };
        if self.written.is_some_and(|at| at.elapsed() < PERIOD) {
            return;
        }
        self.written = Some(Instant::now());
        let scale = f64::from(context.pixels_per_point());
        let listed = tree
            .nodes
            .iter()
            .filter_map(|(_, node)| listed(node, scale));
        let listed: Vec<Listed> = listed.collect();
        let json = serde_json::to_vec(&listed).unwrap_or_default();
        // a reader sees the old list or the new one; whether it outlasts a power cut does not matter
        let beside = self.file.with_extension("part");
        let put = fs::write(&beside, &json).and_then(|()| fs::rename(&beside, &self.file));
        if let Err(error) = put {
            tracing::warn!("{VARIABLE}: {error}");
        }
    }
}

fn listed(node: &Node, scale: f64) -> Option<Listed> {
    let text = match node.role() {
        Role::Label => node.value(),
        _ => node.label(),
    };
    let bounds = node.bounds()?;
    Some(Listed {
        label: text.filter(|text| !text.is_empty())?.to_owned(),
        x: scale * (bounds.x0 + bounds.x1) / 2.0,
        y: scale * (bounds.y0 + bounds.y1) / 2.0,
        enabled: !node.is_disabled(),
    })
}
