//! Sweeps conditions in the simulated room and writes the table `tests/measured/sweep.md`.
//!
//! ```text
//! cargo run -p acquirer --example sweep -- [--quick] [--only GROUP] [--keep FOLDER] [--out FILE]
//! ```
//!
//! The conditions stand in `tests/measured/sweep.toml`. `--quick` takes a handful of them, `--only` one group, and
//! both print the table unless `--out` is given. `--keep` saves the scans with a wrong label or low coverage.

use std::{fs, path::PathBuf};

use anyhow::Result;
use clap::Parser;
use rig_tests::measure::{Row, Sweep, SweepTable, in_repository, run_sweep};

/// Sweeps conditions in the simulated room.
#[derive(Parser)]
struct Arguments {
    /// Only a handful of conditions.
    #[arg(long)]
    quick: bool,
    /// Only the groups whose name contains this.
    #[arg(long)]
    only: Option<String>,
    /// Folder for the scans of failing conditions.
    #[arg(long)]
    keep: Option<PathBuf>,
    /// The table's file; as a rule `tests/measured/sweep.md`.
    #[arg(long)]
    out: Option<PathBuf>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut sweep = Sweep::shipped()?;
    if let Some(only) = &arguments.only {
        sweep.groups.retain(|group| group.name.contains(only));
    }
    let table = run_sweep(&sweep, arguments.quick, arguments.keep.as_deref(), tell)?;
    let whole = !arguments.quick && arguments.only.is_none();
    let usual = whole.then(|| in_repository("tests/measured/sweep.md"));
    match arguments.out.or(usual) {
        Some(file) => fs::write(file, page(&table))?,
        None => print!("{table}"),
    }
    Ok(())
}

fn tell(row: &Row) {
    let mark = if row.fails() { "FAILS" } else { "" };
    eprintln!(
        "{} | {} | {}: {} | calibrated {:.1} | {} {mark}",
        row.group,
        row.condition,
        row.scene,
        row.plain.cells(),
        row.calibrated.coverage_percent(),
        row.calibrated.wrong,
    );
}

/// The table with what a reader must know.
fn page(table: &SweepTable) -> String {
    format!(
        "# The simulation sweep\n\n\
         Written by `cargo run -p acquirer --example sweep`; the conditions stand in `sweep.toml`. Each row is one scan of \
         a shipped scene, both stages together, with the keys changed that the value names. Coverage is the share of \
         the vertices of crossings seen whole and unbroken that were read right; RMS is the distance of these from \
         the truth.\n\n{table}"
    )
}
