//! `acquirer process`: reads a recorded scan again.

use std::path::PathBuf;

use anyhow::Context;
use serde_json::json;
use shared::stage::Stage;

use super::args::{ConfigArgs, ReadingArgs};
use crate::{
    output::Summary,
    process::{Processed, process_scan, read_calibration},
    scan::ScanFolder,
};

/// `acquirer process`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer process cup
  acquirer process cup --json
  acquirer process cup --method thesis --calibration rig.json")]
pub(super) struct ProcessArgs {
    /// Scan folder, with scan.json in it.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// How to read.
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Calibration of the rig, instead of the scan's own.
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// Settings.
    #[command(flatten)]
    pub config: ConfigArgs,
}

pub(super) fn run(args: &ProcessArgs) -> anyhow::Result<()> {
    let config = args.reading.config(&args.config)?;
    let mut folder = ScanFolder::open(&args.dir)?;
    if let Some(path) = &args.calibration {
        folder.set_calibration(&read_calibration(path)?)?;
    }
    let processed = process_scan(&folder, &config)?;
    print(&folder, &processed, args.reading.json)
}

/// Prints the figures of a processed scan: for people, or as one JSON object.
pub(super) fn print(folder: &ScanFolder, processed: &Processed, json: bool) -> anyhow::Result<()> {
    let object = figures(folder, processed)?;
    if json {
        println!("{object}");
    } else {
        print!("{}", figures_text(folder, processed));
    }
    Ok(())
}

/// The figures as JSON: the summary, the paths and the times.
pub(super) fn figures(
    folder: &ScanFolder,
    processed: &Processed,
) -> anyhow::Result<serde_json::Value> {
    let summary = serde_json::to_value(Summary::of(folder, &processed.result))
        .context("the summary can't be written as JSON")?;
    Ok(json!({
        "scan": folder.dir(),
        "results": processed.paths.dir,
        "report": processed.paths.report,
        "summary": summary,
        "times": processed.times,
    }))
}

/// The figures of a processed scan for people, a line each.
#[must_use]
pub fn figures_text(folder: &ScanFolder, processed: &Processed) -> String {
    let summary = Summary::of(folder, &processed.result);
    let mut text = String::new();
    let mut line = |name: &str, value: String| text.push_str(&format!("{name:<22}{value}\n"));
    line("scan", folder.dir().display().to_string());
    line("method", summary.method.name().to_owned());
    for stage in Stage::BOTH {
        let Some(figures) = summary.stage(stage) else {
            continue;
        };
        let dropped = figures.dropped.iter().filter(|(_, count)| **count > 0);
        let reasons: Vec<_> = dropped.map(|(reason, n)| format!("{n} {reason}")).collect();
        line(
            &format!("{stage} crossings"),
            format!(
                "{} of {} labelled ({:.1} %), dropped: {}",
                figures.crossings_labelled,
                figures.crossings_possible,
                figures.coverage_percent,
                if reasons.is_empty() {
                    "none".to_owned()
                } else {
                    reasons.join(", ")
                },
            ),
        );
    }
    if let Some(shifts) = &summary.shifts {
        let range = format!(
            "median {:.2} px, largest {:.2} px",
            shifts.median_px, shifts.largest_px
        );
        line("shift", format!("{} vertices, {range}", shifts.vertices));
    }
    if let Some(surface) = &summary.surface {
        let [near, far] = surface.z_mm;
        line(
            "surface",
            format!(
                "{} points, {near:.1} to {far:.1} mm from the camera",
                surface.points
            ),
        );
    }
    if let Some(shifts) = &summary.line_shifts {
        let across = shifts.across_rms_px.map_or(String::new(), |px| {
            format!(
                ", error across {px:.3} px, {} vertices rejected",
                shifts.rejected_vertices
            )
        });
        line("line shift", format!("{} points{across}", shifts.points));
    }
    if let Some(difference) = &summary.difference {
        line(
            "difference",
            format!(
                "{} points, up to {:.1} mm",
                difference.points, difference.largest_mm
            ),
        );
    }
    for finer in &summary.finer {
        let [rows, columns] = finer.lines;
        let labelled =
            Stage::BOTH.map(|stage| finer.stage(stage).map_or(0, |f| f.crossings_labelled));
        line(
            &format!("finer {rows} x {columns}"),
            format!(
                "{} and {} crossings labelled, {} points",
                labelled[0], labelled[1], finer.points
            ),
        );
    }
    if let Some(response) = &summary.response {
        let residual = response.residual_levels.zip(response.srgb_residual_levels);
        let residual = residual.map_or(String::new(), |(levels, srgb)| {
            format!(": solid colours add up to {levels:.2} byte values (sRGB: {srgb:.2})")
        });
        line(
            "camera response",
            format!("{}{residual}", response.curve.words()),
        );
    }
    for warning in &summary.warnings {
        line("warning", warning.clone());
    }
    let times = processed
        .times
        .iter()
        .map(|time| format!("{} {:.0} ms", time.step, time.ms));
    line("time", times.collect::<Vec<_>>().join(", "));
    line("report", processed.paths.report.display().to_string());
    text
}
