//! The thesis's method beside ours, on every shipped scene and both recorded samples: `tests/measured/methods.md`.
//!
//! ```text
//! cargo run -p acquirer --example methods -- [--print]
//! ```
//!
//! Takes the captures of each stage, reads them by both methods without a calibration, and gives coverage, wrong
//! labels, RMS and the CPU time of the reading, all threads together (the shortest of three). `--print` writes no file.

use std::{fmt::Write, fs, path::Path};

use acquirer::{
    pipeline::{Captures, Method, Projected},
    scan::ScanFolder,
};
use anyhow::{Context, Result};
use rig_tests::{
    measure::{Reading, Repeats, SimulatedScan, Sum, in_repository, shipped_scenes},
    read_truth,
};
use shared::{
    pattern::GridSettings,
    simulation::{Scene, TruthVertex},
    stage::Stage,
};

/// How often a stage is read for its time.
const RUNS: usize = 3;

/// Captures with their truth.
struct Case {
    name: String,
    projected: Projected,
    stages: [Captures; 2],
    truth: Vec<TruthVertex>,
}

fn main() -> Result<()> {
    let mut table = String::from(
        "# The thesis's method beside ours\n\n\
         Written by `cargo run -p acquirer --example methods`. Time is CPU time of reading one stage in ms, \
         all threads together. The last five columns are the thesis's method.\n\n\
         | scene | stage | clear crossings | coverage % | wrong labels | wrong % | RMS px | ms | \
         thesis: coverage % | wrong labels | wrong % | RMS px | ms |\n\
         |---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for case in cases()? {
        eprintln!("{}", case.name);
        for (stage, captures) in Stage::BOTH.into_iter().zip(&case.stages) {
            let (ours, ours_ms) = read(&case, captures, stage, Method::Likelihood)?;
            let (thesis, thesis_ms) = read(&case, captures, stage, Method::Thesis)?;
            let cells = thesis.cells();
            let (_, thesis) = cells.split_once(" | ").context("cells")?;
            let ours = ours.cells();
            let name = &case.name;
            writeln!(
                table,
                "| {name} | {stage} | {ours} | {ours_ms:.1} | {thesis} | {thesis_ms:.1} |"
            )?;
        }
    }
    if std::env::args().any(|argument| argument == "--print") {
        print!("{table}");
    } else {
        fs::write(in_repository("tests/measured/methods.md"), table)?;
    }
    Ok(())
}

/// Score and shortest CPU time, ms.
fn read(case: &Case, captures: &Captures, stage: Stage, method: Method) -> Result<(Sum, f64)> {
    let reading = Reading {
        projected: &case.projected,
        calibration: None,
        method,
    };
    let (mut sum, mut shortest) = (Sum::default(), f64::INFINITY);
    for _ in 0..RUNS {
        let (score, took) = reading.score(captures, &case.truth, stage)?;
        sum = Sum::default();
        sum.add(&score);
        shortest = shortest.min(took.as_secs_f64() * 1e3);
    }
    Ok((sum, shortest))
}

fn cases() -> Result<Vec<Case>> {
    let mut cases = shipped_scenes()?
        .iter()
        .map(|path| simulated(path))
        .collect::<Result<Vec<_>>>()?;
    for name in ["wall-cube", "coloured-room"] {
        cases.push(recorded(name)?);
    }
    Ok(cases)
}

fn simulated(path: &Path) -> Result<Case> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    eprintln!("rendering {name}");
    let pattern = GridSettings::default();
    let scan = SimulatedScan::record(&Scene::load(path)?, &pattern, Repeats::default());
    Ok(Case {
        name: name.into_owned(),
        projected: scan.projected,
        stages: scan.stages,
        truth: scan.truth,
    })
}

fn recorded(name: &str) -> Result<Case> {
    let folder = in_repository("tests/recorded").join(name);
    let scan = ScanFolder::open(&folder)?;
    Ok(Case {
        name: format!("recorded {name}"),
        projected: scan.projected(),
        stages: [
            scan.captures(Stage::Background)?,
            scan.captures(Stage::Object)?,
        ],
        truth: read_truth(&folder.join("truth.csv"))?,
    })
}
