//! A list of what stands where in a window, for scripts that click: tests of the real windows, and the pictures in
//! the README.
//!
//! Where the named variable holds a file's path, the window writes that file anew whenever it was drawn and something
//! in it has changed: one JSON array of widgets with their label, their middle in pixels of the window's inside, and
//! whether they can be used.

use std::{env, fs, path::PathBuf};

use egui::{
    Context, FullOutput, Ui,
    accesskit::{Node, Role},
    plugin::Plugin,
};
use serde::Serialize;

/// A widget as it stands in the list.
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
    /// What was written last.
    written: Vec<u8>,
}

/// Starts writing the list of a window if the environment variable of this name asks for it.
pub fn start_if_wanted(context: &Context, variable: &str) {
    if let Some(file) = env::var_os(variable) {
        context.add_plugin(WidgetList {
            file: file.into(),
            written: Vec::new(),
        });
    }
}

impl Plugin for WidgetList {
    fn debug_name(&self) -> &'static str {
        "widget list"
    }

    fn on_begin_pass(&mut self, ui: &mut Ui) {
        ui.ctx().enable_accesskit();
    }

    fn output_hook(&mut self, context: &Context, output: &mut FullOutput) {
        let Some(tree) = &output.platform_output.accesskit_update else {
            return;
        };
        let scale = f64::from(context.pixels_per_point());
        let nodes = tree.nodes.iter();
        let listed: Vec<Listed> = nodes.filter_map(|(_, node)| listed(node, scale)).collect();
        let json = serde_json::to_vec(&listed).unwrap_or_default();
        if json == self.written {
            return;
        }
        // a reader sees the old list or the new one; whether it outlasts a power cut does not matter
        let beside = self.file.with_extension("part");
        match fs::write(&beside, &json).and_then(|()| fs::rename(&beside, &self.file)) {
            Ok(()) => self.written = json,
            Err(error) => tracing::warn!("{}: {error}", self.file.display()),
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
