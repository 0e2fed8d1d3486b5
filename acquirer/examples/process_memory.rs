//! Peak memory of `acquirer process`, at three camera sizes: `tests/measured/memory.md`.
//!
//! ```text
//! cargo run -p acquirer --example process_memory -- [--print]
//! ```
//!
//! Records scans of the box before the wall in the simulated room (3 black, 3 white, 2 coded, 2 unary of each stage,
//! as `acquirer scan` does by default), lets the program itself read each with and without its calibration, and asks
//! the kernel for the most memory that it ever had resident (`getrusage`). `--print` writes no file.

use std::{
    env,
    fmt::Write as _,
    fs,
    path::Path,
    process::{Command, Stdio},
};

use anyhow::{Context, Result, ensure};
use nix::sys::resource::{UsageWho, getrusage};
use rig_tests::{
    guest::built_program,
    measure::{Repeats, SimulatedScan, in_repository},
};

/// The camera sizes, in px.
const SIZES: [(u32, u32); 3] = [(640, 480), (1280, 720), (1920, 1080)];
/// Makes this program the parent of one measured run, so that the kernel's figure for all its children is that run's.
const ONE_RUN: &str = "--one-run";

fn main() -> Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    match &arguments[..] {
        [first, scan] if first == ONE_RUN => return one_run(Path::new(scan)),
        _ => {}
    }
    let mut table = String::from(HEADER);
    for size in SIZES {
        let dir = tempfile::tempdir()?;
        let scan = dir.path().join("scan");
        eprintln!("rendering {}x{}", size.0, size.1);
        SimulatedScan::of_camera(size, Repeats::default())?.save(&scan)?;
        let with = peak_mib(&scan)?;
        forget_calibration(&scan)?;
        let without = peak_mib(&scan)?;
        writeln!(table, "| {}x{} | {without} | {with} |", size.0, size.1)?;
    }
    if arguments.iter().any(|argument| argument == "--print") {
        print!("{table}");
    } else {
        fs::write(in_repository("tests/measured/memory.md"), table)?;
    }
    Ok(())
}

const HEADER: &str = "\
# Peak memory of `acquirer process`

Written by `cargo run -p acquirer --example process_memory`. Scans of 3 black, 3 white, 2 coded, 2 unary of both
stages of the simulated box before the wall, read with `acquirer process DIR --json`: all tables, pictures and the
report are written. The most that the program ever had resident, as the kernel counts it, its code included.

| camera | without calibration MiB | with calibration MiB |
|---|--:|--:|
";

/// Peak resident memory of reading a scan, MiB, in a process that has no other children.
fn peak_mib(scan: &Path) -> Result<String> {
    let parent = Command::new(env::current_exe()?)
        .arg(ONE_RUN)
        .arg(scan)
        .output()?;
    ensure!(
        parent.status.success(),
        "{}",
        String::from_utf8_lossy(&parent.stderr)
    );
    Ok(String::from_utf8(parent.stdout)?.trim().to_owned())
}

/// Reads a scan with the program and prints its peak.
fn one_run(scan: &Path) -> Result<()> {
    let status = Command::new(built_program("acquirer")?)
        .args(["process", "--json"])
        .arg(scan)
        .stdout(Stdio::null())
        .status()?;
    ensure!(status.success(), "acquirer process ended with {status}");
    let kib = getrusage(UsageWho::RUSAGE_CHILDREN)?.max_rss();
    println!("{:.0}", kib as f64 / 1024.0);
    Ok(())
}

/// Takes the calibration out of a scan's manifest.
fn forget_calibration(scan: &Path) -> Result<()> {
    let manifest = scan.join("scan.json");
    let mut json: serde_json::Value = serde_json::from_slice(&fs::read(&manifest)?)?;
    let entries = json.as_object_mut().context("a manifest is an object")?;
    entries.remove("calibration");
    Ok(fs::write(manifest, serde_json::to_vec_pretty(&json)?)?)
}
