//! `acquirer draw`: a shift table as a 3-D view.

use anyhow::{Context, bail};

use super::args::DrawArgs;
use crate::output::{
    relief::{Colouring, Viewpoint, draw_relief},
    shift_table::{read_appendix_c, read_shift_table},
};

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
