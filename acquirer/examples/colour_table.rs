//! The chosen colours beside a fixed set and the thesis's choice, on every shipped scene: `tests/measured/colours.md`.
//!
//! ```text
//! cargo run -p acquirer --example colour_table -- [--print]
//! ```
//!
//! For each scene with its object the sixteen colours are shown and judged as `acquirer colours` does. Then the scene
//! is recorded with the chosen four, with red, yellow, magenta and green, and with the four colours of which most
//! grid pixels are recovered (the thesis's rule), and read with the true calibration: as a scan, one coded and one
//! unary frame, and from the coded frame alone, where every line must be seen in its own colour. Four frames of
//! different noise are read one by one.

use std::{fmt::Write, fs};

use acquirer::pipeline::{
    Method, Projected,
    colour_choice::{ColourSelection, ColourSet, choose_colours},
};
use anyhow::{Context, Result};
use rig_tests::measure::{
    Reading, Repeats, SimulatedScan, Sum, colour_trial, in_repository, shipped_scenes,
};
use shared::{
    pattern::{Axis, Grid, GridSettings, Rgb},
    simulation::Scene,
    stage::Stage,
};

/// Coded frames of each set and stage; each is read for itself, so that one frame's noise says little.
const FRAMES: usize = 4;

/// What one would take without looking at the scene.
const FIXED: [Rgb; 4] = [
    Rgb([255, 0, 0]),
    Rgb([255, 255, 0]),
    Rgb([255, 0, 255]),
    Rgb([0, 255, 0]),
];

fn main() -> Result<()> {
    let mut table = String::from(
        "# The chosen colours beside others\n\n\
         Written by `cargo run -p acquirer --example colour_table`. Expected: share of line pixels that will be \
         mistaken or not seen in a coded frame alone, as predicted from the sixteen shots. Scan: coverage of the clear \
         crossings with one coded and one unary frame; alone: with the coded frame alone; wrong: wrong labels in both. \
         All are of four frames with and four without the object, read one by one. Fixed: red, yellow, magenta, green. \
         Thesis: the four colours with most recovered pixels.\n\n\
         | scene | chosen | expected % | scan % | alone % | wrong | fixed: expected % | scan % | alone % | wrong | \
         thesis: expected % | scan % | alone % | wrong |\n\
         |---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for path in shipped_scenes()? {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        eprintln!("{name}");
        let scene = Scene::load(&path)?;
        let selection = choose(&scene)?;
        let chosen = cells(&scene, selection.best, selection.expected_error)?;
        let fixed = selection
            .current
            .as_ref()
            .context("the fixed set was tried")?;
        let fixed = cells(&scene, FIXED, fixed.expected_error)?;
        let ColourSet {
            colours,
            expected_error,
            ..
        } = selection.thesis_choice;
        let thesis = cells(&scene, colours, expected_error)?;
        let names = names(&selection).join(", ");
        writeln!(
            table,
            "| {name} | {names} | {chosen} | {fixed} | {thesis} |"
        )?;
    }
    if std::env::args().any(|argument| argument == "--print") {
        print!("{table}");
    } else {
        fs::write(in_repository("tests/measured/colours.md"), table)?;
    }
    Ok(())
}

/// The choice on the scene with its object, the fixed set being in use.
fn choose(scene: &Scene) -> Result<ColourSelection> {
    let projected = Projected {
        pattern: GridSettings::default(),
        raster: scene.projector_size(),
    };
    let trial = colour_trial(scene, Stage::Object, &projected.pattern.coded);
    Ok(choose_colours(&trial, &projected, Some(FIXED))?)
}

/// Expected error, coverage of a scan and of the coded frame alone, and wrong labels of one set.
fn cells(scene: &Scene, colours: [Rgb; 4], expected: f64) -> Result<String> {
    let shipped = GridSettings::default().coded;
    let [rows, columns] = Axis::BOTH.map(|axis| shipped.lines(axis));
    let [row_px, column_px] = Axis::BOTH.map(|axis| shipped.width_px(axis));
    let pattern = GridSettings {
        coded: Grid::coded(rows, columns, row_px, column_px, &colours)?,
        unary: Rgb::WHITE,
    };
    let repeats = Repeats {
        references: 2,
        coded: FRAMES,
        unary: FRAMES,
    };
    let scan = SimulatedScan::record(scene, &pattern, repeats);
    let (mut with_unary, mut alone) = (Sum::default(), Sum::default());
    for frame in 0..FRAMES {
        with_unary.join(&read(&scan, frame, true)?);
        alone.join(&read(&scan, frame, false)?);
    }
    Ok(format!(
        "{:.3} | {:.1} | {:.1} | {}",
        100.0 * expected,
        with_unary.coverage_percent(),
        alone.coverage_percent(),
        with_unary.wrong + alone.wrong
    ))
}

/// The scores of both stages, read from one of the coded frames.
fn read(scan: &SimulatedScan, frame: usize, with_unary: bool) -> Result<Sum> {
    let reading = Reading {
        projected: &scan.projected,
        calibration: Some(&scan.calibration),
        method: Method::Likelihood,
    };
    let mut sum = Sum::default();
    for (stage, captures) in Stage::BOTH.into_iter().zip(&scan.stages) {
        let mut captures = captures.clone();
        captures.prmvs = vec![captures.prmvs.swap_remove(frame)];
        captures.unary = match with_unary {
            true => vec![captures.unary.swap_remove(frame)],
            false => Vec::new(),
        };
        let (score, _) = reading.score(&captures, &scan.truth, stage)?;
        sum.add(&score);
    }
    Ok(sum)
}

fn names(selection: &ColourSelection) -> Vec<String> {
    let name = |colour: &Rgb| {
        let known = selection
            .colours
            .iter()
            .find(|score| score.colour == *colour);
        known.map_or_else(|| colour.to_string(), |score| score.name.clone())
    };
    selection.best.iter().map(name).collect()
}
