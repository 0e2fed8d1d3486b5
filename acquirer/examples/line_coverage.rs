//! Measures how much of the grid's lines is read, in every shipped simulated room.
//!
//! ```text
//! cargo run -p acquirer --example line_coverage [-- OUT.md]
//! ```
//!
//! Each scene's camera takes the frames of a scan (3 black, 3 white, 2 coded, 2 unary, as `acquirer scan` does by
//! default) and the pipeline reads them without and with the calibration. The truth is sampled on the middle of each
//! line, every projector pixel: places that the projector lights and the camera sees, nothing in the way of either,
//! inside both pictures, crossings included. A place is covered when a point of the same line was read within 1.5
//! camera px of where it truly is. A point is wrong when what it lies on is lit by light more than a quarter of the
//! pitch from its line's middle. Of the recorded samples only vertices are known, and around which crossings both lines
//! are whole nearly half-way to the next ones; the truth there is the straight way between two such neighbours on one
//! surface, 0.45 of it from either end. The tables go to standard output or a file.

use std::{collections::HashMap, fs};

use acquirer::{
    pipeline::{
        Captures, PipelineSettings, Projected,
        dense::{DenseLine, find_dense_lines},
        read_stage,
    },
    scan::ScanFolder,
};
use anyhow::{Context, Result};
use rig_tests::{
    measure::{Repeats, SimulatedScan, in_repository, shipped_scenes},
    read_truth,
};
use shared::{
    geometry::{CameraPixel, RigCalibration},
    pattern::{Axis, GridIndex, GridSettings},
    simulation::{Scene, Space, TruthVertex},
    stage::Stage,
};

/// A place counts as covered when a point of its line lies within this, camera px.
const COVERED_PX: f64 = 1.5;
/// A point is on a wrong line beyond this share of the pitch.
const WRONG_OF_PITCH: f64 = 0.25;

/// Part of the way to the next crossing on which the lines of a clear one are known to be whole.
const WHOLE_OF_PITCH: f64 = 0.45;
/// Neighbours on one surface are so many times the typical distance apart.
const ONE_SURFACE: std::ops::Range<f64> = 0.75..1.35;

/// A place of a line that is truly there to be read.
type Place = ((Axis, u16), CameraPixel);

fn main() -> Result<()> {
    let mut table = HEADER.to_owned();
    for file in shipped_scenes()? {
        let scene = Scene::load(&file)?;
        let name = file.file_stem().context("a scene has a name")?;
        let scan = SimulatedScan::record(&scene, &GridSettings::default(), Repeats::default());
        for (stage, captures) in Stage::BOTH.into_iter().zip(&scan.stages) {
            let space = Space::new(&scene, stage);
            let figures = simulated(&scan, captures, &space)?;
            let row = format!("| {} | {stage} | {figures} |\n", name.display());
            eprint!("{row}");
            table += &row;
        }
    }
    table += RECORDED_HEADER;
    for name in ["wall-cube", "coloured-room"] {
        for stage in Stage::BOTH {
            let row = format!("| {name} | {stage} | {} |\n", recorded(name, stage)?);
            eprint!("{row}");
            table += &row;
        }
    }
    match std::env::args().nth(1) {
        Some(path) => fs::write(&path, table).with_context(|| path)?,
        None => print!("{table}"),
    }
    Ok(())
}

const HEADER: &str = "\
# How much of the lines is read

Made by `cargo run -p acquirer --example line_coverage -- tests/measured/line_coverage.md`.
Frames: 3 black, 3 white, 2 coded, 2 unary of the shipped rooms, the built-in 15 x 15 grid.
Truth: the middle of every line each projector px, where projector and camera both see it (nothing in the way,
inside both pictures), crossings included. Covered: a point read for the same line within 1.5 camera px. Wrong: lit
from more than a quarter pitch off its line. Across: RMS of the right ones across the line. The last two columns are
read with the calibration, the others without.

| scene | stage | places both see | rows covered % | columns covered % | all covered % | points read | wrong % | across px | calibrated: covered % | wrong % |
|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";

const RECORDED_HEADER: &str = "
The recorded samples. Truth there is vertices only, and which crossings are clear: both lines whole nearly half-way to
the next ones. Places: each camera px of the straight way between two clear neighbours of one surface (at 0.75 to 1.35
of the typical distance), 0.45 of it from either end. What lies beyond clear crossings is not known and not counted.

| sample | stage | places | covered % | calibrated: covered % |
|---|---|---:|---:|---:|
";

/// The decoded lines' unbroken pieces.
fn read(
    captures: &Captures,
    projected: &Projected,
    calibration: Option<&RigCalibration>,
) -> Result<Vec<DenseLine>> {
    let settings = PipelineSettings {
        pictures: false,
        ..PipelineSettings::default()
    };
    let reading = read_stage(captures, projected, calibration, &settings)?;
    Ok(find_dense_lines(&reading.grid))
}

fn simulated(scan: &SimulatedScan, captures: &Captures, space: &Space) -> Result<String> {
    let projected = &scan.projected;
    let truth = space.line_truth(&projected.pattern.coded, projected.raster);
    let truth: Vec<Place> = truth.iter().map(|s| ((s.axis, s.line), s.camera)).collect();
    let plain = read(captures, projected, None)?;
    let calibrated = read(captures, projected, Some(&scan.calibration))?;
    let (points, wrong, across) = errors(&plain, space, projected);
    let (_, calibrated_wrong, _) = errors(&calibrated, space, projected);
    Ok(format!(
        "{} | {:.2} | {:.2} | {:.2} | {points} | {wrong:.2} | {across:.3} | {:.2} | {calibrated_wrong:.2}",
        truth.len(),
        covered_percent(&plain, &truth, Some(Axis::Row)),
        covered_percent(&plain, &truth, Some(Axis::Column)),
        covered_percent(&plain, &truth, None),
        covered_percent(&calibrated, &truth, None),
    ))
}

fn recorded(name: &str, stage: Stage) -> Result<String> {
    let folder = in_repository("tests/recorded").join(name);
    let truth = read_truth(&folder.join("truth.csv"))?;
    let places = known_places(&truth, stage);
    let folder = ScanFolder::open(&folder)?;
    let calibration = folder.calibration_path().context("no calibration")?;
    let calibration = RigCalibration::from_json(&fs::read(calibration)?)?;
    let (captures, projected) = (folder.captures(stage)?, folder.projected());
    let plain = read(&captures, &projected, None)?;
    let calibrated = read(&captures, &projected, Some(&calibration))?;
    Ok(format!(
        "{} | {:.2} | {:.2}",
        places.len(),
        covered_percent(&plain, &places, None),
        covered_percent(&calibrated, &places, None),
    ))
}

/// Places on the straight way between clear crossings that are neighbours on one surface.
fn known_places(truth: &[TruthVertex], stage: Stage) -> Vec<Place> {
    let mut corners: HashMap<GridIndex, Vec<&TruthVertex>> = HashMap::new();
    for vertex in truth.iter().filter(|v| v.stage == stage && v.clear) {
        corners.entry(vertex.index).or_default().push(vertex);
    }
    let middle = |index: GridIndex| {
        let corners = corners.get(&index).filter(|all| all.len() == 4)?;
        let mean = |of: fn(&TruthVertex) -> f64| corners.iter().map(|v| of(v)).sum::<f64>() / 4.0;
        Some((mean(|v| v.camera.x), mean(|v| v.camera.y)))
    };
    let mut places = Vec::new();
    for axis in Axis::BOTH {
        let next = |index: GridIndex| match axis {
            Axis::Row => GridIndex {
                column: index.column + 1,
                ..index
            },
            Axis::Column => GridIndex {
                row: index.row + 1,
                ..index
            },
        };
        let pairs = corners.keys().filter_map(|&index| {
            let (a, b) = (middle(index)?, middle(next(index))?);
            Some((index.line(axis), a, b, (b.0 - a.0).hypot(b.1 - a.1)))
        });
        let pairs: Vec<_> = pairs.collect();
        let mut gaps: Vec<f64> = pairs.iter().map(|pair| pair.3).collect();
        gaps.sort_by(f64::total_cmp);
        let typical = gaps.get(gaps.len() / 2).copied().unwrap_or(1.0);
        for (line, a, b, gap) in pairs {
            if !ONE_SURFACE.contains(&(gap / typical)) {
                continue;
            }
            let shares = (0..=gap as usize).map(|k| k as f64 / gap);
            let known = shares.filter(|s| s.min(1.0 - s) <= WHOLE_OF_PITCH);
            let at = |s: f64| CameraPixel::new(a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1));
            places.extend(known.map(|s| ((axis, line), at(s))));
        }
    }
    places
}

/// Share of the places, of one direction or all, that a point of the same line is near to, in %.
fn covered_percent(lines: &[DenseLine], truth: &[Place], axis: Option<Axis>) -> f64 {
    let near = Near::new(lines);
    let of_axis = || {
        truth
            .iter()
            .filter(|(line, _)| axis.is_none_or(|a| a == line.0))
    };
    let covered = of_axis().filter(|&&(line, at)| near.has(line, at));
    100.0 * covered.count() as f64 / of_axis().count().max(1) as f64
}

/// Read points by line and whole pixel.
struct Near {
    points: HashMap<(Axis, u16, i64, i64), Vec<CameraPixel>>,
}

impl Near {
    fn new(lines: &[DenseLine]) -> Self {
        let mut points: HashMap<_, Vec<CameraPixel>> = HashMap::new();
        for line in lines {
            for point in &line.points {
                let p = point.position;
                let key = (line.axis, line.line, p.x.floor() as i64, p.y.floor() as i64);
                points.entry(key).or_default().push(p);
            }
        }
        Self { points }
    }

    fn has(&self, (axis, line): (Axis, u16), at: CameraPixel) -> bool {
        let (x, y) = (at.x.floor() as i64, at.y.floor() as i64);
        (-2..=2).any(|dx| {
            (-2..=2).any(|dy| {
                let found = self.points.get(&(axis, line, x + dx, y + dy));
                found.is_some_and(|all| {
                    all.iter()
                        .any(|p| (p.x - at.x).hypot(p.y - at.y) <= COVERED_PX)
                })
            })
        })
    }
}

/// Number of points, share on wrong lines in %, RMS across the others in camera px.
fn errors(lines: &[DenseLine], space: &Space, projected: &Projected) -> (usize, f64, f64) {
    let grid = &projected.pattern.coded;
    let (mut points, mut wrong, mut sum) = (0usize, 0usize, 0.0);
    for line in lines {
        let centre = grid
            .line(line.axis, line.line.into(), projected.raster)
            .centre_px();
        let pitch = grid.pitch_px(line.axis, projected.raster);
        let at = |p: CameraPixel| {
            space.projector_at(p).map(|light| match line.axis {
                Axis::Row => light.y,
                Axis::Column => light.x,
            })
        };
        for point in &line.points {
            points += 1;
            let p = point.position;
            let Some(light) = at(p).filter(|l| (l - centre).abs() <= WRONG_OF_PITCH * pitch) else {
                wrong += 1;
                continue;
            };
            // how many projector px one camera px is, in the direction in which it is most
            let change = |dx, dy| at(CameraPixel::new(p.x + dx, p.y + dy)).map(|v| v - light);
            let slope = change(0.5, 0.0)
                .unwrap_or(0.0)
                .hypot(change(0.0, 0.5).unwrap_or(0.0))
                * 2.0;
            sum += ((light - centre) / slope.max(0.2)).powi(2);
        }
    }
    let right = (points - wrong).max(1);
    (
        points,
        100.0 * wrong as f64 / points.max(1) as f64,
        (sum / right as f64).sqrt(),
    )
}
