//! `acquirer draw`: a shift table as a 3-D view.

use std::path::PathBuf;

use anyhow::{Context, bail};

use crate::output::{
    relief::{Colouring, Viewpoint, draw_relief},
    shift_table::{read_appendix_c, read_shift_table},
};

/// `acquirer draw`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer draw cup/results/shifts.csv cup.png
  acquirer draw tests/recorded/appendix-c.csv cube.png --object cube")]
pub(super) struct DrawArgs {
    /// shifts.csv of a scan, or a table in the form of the thesis's Appendix C.
    #[arg(value_name = "TABLE")]
    pub table: PathBuf,
    /// Picture to write (PNG).
    #[arg(value_name = "OUT")]
    pub out: PathBuf,
    /// Which object of the table, where it holds several.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
}

pub(super) fn run(args: &DrawArgs) -> anyhow::Result<()> {
    let rows = match &args.object {
        Some(object) => read_appendix_c(&args.table, object)?,
        None => read_shift_table(&args.table)?,
    };
    if rows.is_empty() {
        bail!(
            "{}: no vertices{}",
            args.table.display(),
            match &args.object {
                Some(name) => format!(" of {name:?}"),
                None => String::new(),
            }
        );
    }
    let picture = draw_relief(&rows, Viewpoint::default(), Colouring::Depth).painted();
    picture
        .save(&args.out)
        .with_context(|| args.out.display().to_string())?;
    println!("{}: {} vertices", args.out.display(), rows.len());
    Ok(())
}
