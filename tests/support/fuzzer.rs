//! `fuzzer TARGET|all SECONDS`: feeds broken input to what reads bytes from outside; inputs that break something are
//! kept in `tests/fuzz/found`, those that got further than others in `tests/fuzz/corpus`. `fuzzer seeds TARGET FOLDER`
//! writes the valid inputs that a target begins with.

use std::{
    fs,
    path::Path,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use acquirer::scan::Checksum;
use anyhow::{Context, bail};
use rig_tests::fuzz::{Target, run};

/// Most inputs of one run that are kept, and the most bytes of one.
const KEEP: usize = 12;
const KEEP_BYTES: usize = 4096;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().context("which target, or all?")?;
    if name == "seeds" {
        let name = arguments.next().context("seeds of which target?")?;
        let folder = arguments.next().context("into which folder?")?;
        return write_seeds(&name, Path::new(&folder));
    }
    let seconds = arguments.next().context("how many seconds?")?.parse()?;
    let seed = SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos() as u64;
    let mut failures = 0;
    for target in Target::ALL {
        if name != "all" && name != target.name() {
            continue;
        }
        let found = run(target, Duration::from_secs(seconds), seed)?;
        println!(
            "| {} | {seconds} | {} | {} | {} |",
            target.name(),
            found.inputs,
            found.corpus.len(),
            found.failures.len()
        );
        let small = found.corpus.iter().filter(|input| input.len() < KEEP_BYTES);
        for input in small.take(KEEP) {
            keep("corpus", target, input)?;
        }
        for (input, what) in found.failures.iter().take(KEEP) {
            eprintln!(
                "{}: {what}: {}",
                target.name(),
                keep("found", target, input)?
            );
        }
        failures += found.failures.len();
    }
    if failures > 0 {
        bail!("{failures} inputs broke something");
    }
    Ok(())
}

fn write_seeds(name: &str, folder: &Path) -> anyhow::Result<()> {
    let target = Target::ALL.iter().find(|target| target.name() == name);
    let target = target.with_context(|| format!("no target {name}"))?;
    for (number, seed) in target.seeds().iter().enumerate() {
        fs::write(folder.join(format!("seed-{number:02}")), seed)?;
    }
    Ok(())
}

fn keep(folder: &str, target: Target, input: &[u8]) -> anyhow::Result<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    let dir = root.join(folder).join(target.name());
    fs::create_dir_all(&dir)?;
    let path = dir.join(&Checksum::of(input).to_string()[..16]);
    fs::write(&path, input)?;
    Ok(path.display().to_string())
}
