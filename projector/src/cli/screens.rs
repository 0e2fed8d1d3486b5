//! `projector screens`: lists the monitors.

use std::{fmt::Write as _, io::Write as _};

use anyhow::Context;
use serde::Serialize;

use crate::screen::{self, Monitor};

#[derive(Serialize)]
struct Listing {
    screens: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    #[serde(flatten)]
    monitor: Monitor,
    /// It gets the picture unless `--screen` names another.
    chosen: bool,
}

pub(super) fn run(json: bool) -> anyhow::Result<()> {
    let (monitors, chosen) = screen::list_monitors()?;
    let listed = |(k, monitor)| Listed {
        monitor,
        chosen: chosen == Some(k),
    };
    let listing = Listing {
        screens: monitors.into_iter().enumerate().map(listed).collect(),
    };
    let text = if json {
        serde_json::to_string(&listing)? + "\n"
    } else {
        table(&listing)
    };
    std::io::stdout()
        .write_all(text.as_bytes())
        .context("cannot write to standard output")
}

fn table(listing: &Listing) -> String {
    if listing.screens.is_empty() {
        return "no monitor\n".to_owned();
    }
    let mut text = String::new();
    for Listed { monitor, chosen } in &listing.screens {
        let size = format!("{}x{}", monitor.width, monitor.height);
        let place = format!("at {},{}", monitor.x, monitor.y);
        let rate = monitor
            .refresh_hz
            .map_or_else(String::new, |rate| format!("{rate:.2} Hz"));
        let notes = [(monitor.primary, "primary"), (*chosen, "gets the picture")];
        let notes: Vec<_> = notes
            .iter()
            .filter(|(is, _)| *is)
            .map(|(_, note)| *note)
            .collect();
        let notes = notes.join(", ");
        // Writing to a String cannot fail.
        writeln!(
            text,
            "{:12} {size:10} {place:14} {rate:10} {notes}",
            monitor.name
        )
        .ok();
    }
    text
}
