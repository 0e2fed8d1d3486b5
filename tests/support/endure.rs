//! `endure MINUTES FILE`: a long run of both programs in simulation; its figures go into a file.

use std::{path::Path, time::Duration};

use anyhow::Context;
use rig_tests::endurance;

/// Samples of a run.
const SAMPLES: u32 = 24;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let minutes: f64 = arguments.next().context("how many minutes?")?.parse()?;
    let file = arguments.next().context("which file?")?;
    let time = Duration::try_from_secs_f64(60.0 * minutes)?;
    let found = endurance::run(time, time / SAMPLES)?;
    found.write(Path::new(&file))?;
    print!("{found}");
    Ok(())
}
