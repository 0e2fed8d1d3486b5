//! The simulation sweep: records every condition in the simulated room, reads it, and gives the figures.

use std::{fmt, path::Path};

use acquirer::pipeline::Method;
use shared::stage::Stage;

use super::{
    conditions::{Condition, Group, Sweep},
    reading::{Reading, Sum},
    simulated::SimulatedScan,
};

/// A condition is kept for looking at when it reads less than this share of the clear crossings, in percent.
const LOW_COVERAGE_PERCENT: f64 = 80.0;

/// The figures of one condition in one scene, both stages together.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What is varied.
    pub group: String,
    /// Its value.
    pub condition: String,
    /// In which scene.
    pub scene: String,
    /// Read without a calibration.
    pub plain: Sum,
    /// Read with the true calibration, which adds the epipolar check.
    pub calibrated: Sum,
}

impl Row {
    /// Whether a label is wrong or much is missing.
    #[must_use]
    pub fn fails(&self) -> bool {
        self.plain.wrong + self.calibrated.wrong > 0
            || self.plain.coverage_percent() < LOW_COVERAGE_PERCENT
    }
}

/// All rows of a sweep; `Display` gives the Markdown table.
#[derive(Debug, Clone, Default)]
pub struct SweepTable {
    /// One row for each condition and scene.
    pub rows: Vec<Row>,
}

impl SweepTable {
    /// All conditions together: without and with the calibration.
    #[must_use]
    pub fn overall(&self) -> (Sum, Sum) {
        let mut sums = (Sum::default(), Sum::default());
        for row in &self.rows {
            sums.0.join(&row.plain);
            sums.1.join(&row.calibrated);
        }
        sums
    }
}

impl fmt::Display for SweepTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let headings = "clear crossings | coverage % | wrong labels | wrong % | RMS px";
        writeln!(
            f,
            "| varied | value | scene | {headings} | with calibration: coverage % | wrong labels |"
        )?;
        writeln!(f, "|---|---|---|--:|--:|--:|--:|--:|--:|--:|")?;
        let line = |f: &mut fmt::Formatter<'_>, names: &str, plain: &Sum, calibrated: &Sum| {
            let (coverage, wrong) = (calibrated.coverage_percent(), calibrated.wrong);
            writeln!(
                f,
                "| {names} | {} | {coverage:.1} | {wrong} |",
                plain.cells()
            )
        };
        for row in &self.rows {
            let names = format!("{} | {} | {}", row.group, row.condition, row.scene);
            line(f, &names, &row.plain, &row.calibrated)?;
        }
        let (plain, calibrated) = self.overall();
        line(f, "**overall** | | ", &plain, &calibrated)?;
        let (plain, calibrated) = (&plain, &calibrated);
        writeln!(
            f,
            "\nOverall {} of {} reported vertices have a wrong label, {:.4} %; with the calibration {} of {}, {:.4} %.",
            plain.wrong,
            plain.reported,
            plain.wrong_percent(),
            calibrated.wrong,
            calibrated.reported,
            calibrated.wrong_percent(),
        )
    }
}

/// Runs the sweep, or its short form.
///
/// `keep` is a folder that gets the scans of failing conditions; `tell` is called with every finished row.
///
/// # Errors
/// A condition that makes no sense, or a file that can't be written.
pub fn run_sweep(
    sweep: &Sweep,
    quick: bool,
    keep: Option<&Path>,
    mut tell: impl FnMut(&Row),
) -> anyhow::Result<SweepTable> {
    let mut table = SweepTable::default();
    for group in &sweep.groups {
        let wanted = group.conditions.iter().filter(|c| c.quick || !quick);
        for condition in wanted {
            for scene in &group.scenes {
                let row = run_condition(group, condition, scene, keep)?;
                tell(&row);
                table.rows.push(row);
            }
        }
    }
    Ok(table)
}

fn run_condition(
    group: &Group,
    condition: &Condition,
    scene: &str,
    keep: Option<&Path>,
) -> anyhow::Result<Row> {
    let room = condition.scene(scene, &group.set)?;
    let scan = SimulatedScan::record(&room, &condition.grid()?, condition.repeats());
    let row = Row {
        group: group.name.clone(),
        condition: condition.name.clone(),
        scene: scene.to_owned(),
        plain: read(&scan, false)?,
        calibrated: read(&scan, true)?,
    };
    if let Some(keep) = keep.filter(|_| row.fails()) {
        scan.save(&keep.join(folder_name(&row)))?;
    }
    Ok(row)
}

fn read(scan: &SimulatedScan, calibrated: bool) -> anyhow::Result<Sum> {
    let reading = Reading {
        projected: &scan.projected,
        calibration: calibrated.then_some(&scan.calibration),
        method: Method::Likelihood,
    };
    let mut sum = Sum::default();
    for (stage, captures) in Stage::BOTH.into_iter().zip(&scan.stages) {
        sum.add(&reading.score(captures, &scan.truth, stage)?.0);
    }
    Ok(sum)
}

/// A file name of letters, digits and dashes.
fn folder_name(row: &Row) -> String {
    let name = format!("{}-{}-{}", row.group, row.condition, row.scene);
    let safe = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    name.chars().map(safe).collect()
}
