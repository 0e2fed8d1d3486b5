//! `acquirer check`: whether a scan is still what was recorded.

use std::path::PathBuf;

use anyhow::bail;

use crate::scan::{CheckedScan, check_scan};

/// `acquirer check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer check cup
  acquirer check cup --json

Exit code 1 when a file is damaged or missing.")]
pub(super) struct CheckArgs {
    /// Scan folder, with scan.json in it.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &CheckArgs) -> anyhow::Result<()> {
    let checked = check_scan(&args.dir)?;
    if args.json {
        println!("{}", serde_json::to_string(&checked)?);
    } else {
        print!("{}", text(&checked));
    }
    if !checked.intact {
        bail!(
            "{}: {} damaged or missing; take these files from a copy, or record the scan again",
            args.dir.display(),
            checked.damaged.len()
        );
    }
    Ok(())
}

fn text(checked: &CheckedScan) -> String {
    let mut text = format!("{:<22}{} files\n", "intact", checked.intact_files);
    let mut line = |name: &str, value: &str| text.push_str(&format!("{name:<22}{value}\n"));
    for damaged in &checked.damaged {
        line("DAMAGED", &format!("{}: {}", damaged.file, damaged.reason));
    }
    for file in &checked.without_checksum {
        line("without checksum", file);
    }
    for file in &checked.unfinished {
        line("left half written", &format!("{file} (belongs to nothing)"));
    }
    for stage in &checked.unrecorded {
        line(
            "not recorded",
            &format!("{stage} (`acquirer scan --resume` does it)"),
        );
    }
    for finer in &checked.unrecorded_finer {
        line(
            "not recorded",
            &format!(
                "{} lines, {} (`acquirer scan --resume` does it)",
                finer.lines, finer.stage
            ),
        );
    }
    let results = match checked.results {
        true => "complete",
        false => "none, or not written to the end (`acquirer process` makes them)",
    };
    line("results", results);
    text
}
