//! Records numbered captures through the public interface of the scan folder, and says on standard output what is
//! recorded: a program to be killed at any moment.
//!
//! `capture_recorder DIR STEPS`: `capture K` is said once capture K is recorded, `stage G` once the object stage has
//! been replaced by its generation G. It goes on where an earlier run ended.

use std::{io::Write, path::Path};

use acquirer::{
    pipeline::Projected,
    scan::{ScanFolder, Shows},
};
use anyhow::Context;
use rig_tests::numbered::{self, SIZE};
use shared::{pattern::GridSettings, stage::Stage};

/// A stage is replaced after so many captures.
const CAPTURES_PER_STAGE: u32 = 4;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let dir = arguments.next().context("which folder?")?;
    let steps: u32 = arguments.next().context("how many steps?")?.parse()?;
    let mut folder = open(Path::new(&dir))?;
    folder.remove_unfinished()?;
    let mut number = numbered::captures(&folder)?.len() as u32;
    let mut generation = numbered::generation(&folder)?;
    for _ in 0..steps {
        let picture = numbered::picture(number);
        folder.add_capture(Stage::Background, Shows::Prmvs, &picture)?;
        say(&format!("capture {number}"))?;
        number += 1;
        if number.is_multiple_of(CAPTURES_PER_STAGE) {
            generation += 1;
            let picture = numbered::picture(generation);
            let stage = Shows::RECORDING.map(|shows| (shows, &picture));
            folder.replace_stage(Stage::Object, stage)?;
            say(&format!("stage {generation}"))?;
        }
    }
    Ok(())
}

fn open(dir: &Path) -> anyhow::Result<ScanFolder> {
    if dir.join("scan.json").exists() {
        return Ok(ScanFolder::open(dir)?);
    }
    let projected = Projected {
        pattern: GridSettings::default(),
        raster: SIZE,
    };
    Ok(ScanFolder::create(dir, &projected, SIZE)?)
}

fn say(what: &str) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{what}")?;
    Ok(stdout.flush()?)
}
