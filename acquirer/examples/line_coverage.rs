//! Measures how much of the grid's lines is read, in every shipped simulated room.
//!
//! ```text
//! cargo run -p acquirer --example line_coverage [-- OUT.md]
//! ```
//!
//! Each scene's camera takes the frames of a scan (3 black, 3 white, 2 coded, 2 unary, as `acquirer scan` does by
//! default) and the pipeline reads them without a calibration. The truth is sampled on the middle of each line,
//! every projector pixel: places that the projector lights and the camera sees, nothing in the way of either, inside
//! both pictures, crossings included. A place is covered when a point of the same line was read within 1.5 camera
//! px of where it truly is. A point is wrong when what it lies on is lit by light more than a quarter of the pitch
//! from its line's middle. The table goes to standard output or a file.

use std::{collections::HashMap, fs};

use acquirer::pipeline::{
    Captures, PipelineSettings, Projected,
    dense::{DenseLine, find_dense_lines},
    read_stage,
};
use anyhow::{Context, Result};
use rig_tests::measure::shipped_scenes;
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, GridSettings, Pattern},
    simulation::{Room, Scene, Space},
    stage::Stage,
};

/// A place counts as covered when a point of its line lies within this, camera px.
const COVERED_PX: f64 = 1.5;
/// A point is on a wrong line beyond this share of the pitch.
const WRONG_OF_PITCH: f64 = 0.25;

fn main() -> Result<()> {
    let mut rows = String::new();
    for file in shipped_scenes()? {
        let scene = Scene::load(&file)?;
        let name = file.file_stem().context("a scene has a name")?;
        for stage in Stage::BOTH {
            let figures = measure(&scene, stage)?;
            let row = format!("| {} | {stage} | {figures} |\n", name.display());
            eprint!("{row}");
            rows += &row;
        }
    }
    let table = format!("{HEADER}{rows}");
    match std::env::args().nth(1) {
        Some(path) => fs::write(&path, table).with_context(|| path)?,
        None => print!("{table}"),
    }
    Ok(())
}

const HEADER: &str = "\
# How much of the lines is read

Made by `cargo run -p acquirer --example line_coverage -- tests/measured/line_coverage.md`.
Frames: 3 black, 3 white, 2 coded, 2 unary of the shipped rooms, the built-in 15 x 15 grid, no calibration.
Truth: the middle of every line each projector px, where projector and camera both see it (nothing in the way,
inside both pictures), crossings included. Covered: a point read for the same line within 1.5 camera px. Wrong: lit
from more than a quarter pitch off its line. Across: RMS of the right ones across the line.

| scene | stage | places both see | rows covered % | columns covered % | all covered % | points read | wrong % | across px |
|---|---|---:|---:|---:|---:|---:|---:|---:|
";

fn measure(scene: &Scene, stage: Stage) -> Result<String> {
    let room = Room::new(scene, stage);
    let pattern = GridSettings::default();
    let projected = Projected {
        pattern,
        raster: scene.projector_size(),
    };
    let captures = shoot(scene, &room, &projected.pattern);
    let settings = PipelineSettings {
        pictures: false,
        ..PipelineSettings::default()
    };
    let reading = read_stage(&captures, &projected, None, &settings)?;
    let lines = find_dense_lines(&reading.grid);
    let truth = room
        .space()
        .line_truth(&projected.pattern.coded, projected.raster);
    let near = Near::new(&lines);
    let share = |axis: Option<Axis>| {
        let of_axis = || truth.iter().filter(|s| axis.is_none_or(|a| a == s.axis));
        let covered = of_axis().filter(|s| near.has((s.axis, s.line), s.camera));
        100.0 * covered.count() as f64 / of_axis().count().max(1) as f64
    };
    let (points, wrong, across) = errors(&lines, room.space(), &projected);
    Ok(format!(
        "{} | {:.2} | {:.2} | {:.2} | {points} | {wrong:.2} | {across:.3}",
        truth.len(),
        share(Some(Axis::Row)),
        share(Some(Axis::Column)),
        share(None)
    ))
}

fn shoot(scene: &Scene, room: &Room, pattern: &GridSettings) -> Captures {
    let mut number = 0;
    let mut shoot = |pattern: &Pattern, count: usize| {
        let light = scene.project(&pattern.raster(scene.projector_size()));
        let frames = (0..count).map(|_| {
            number += 1;
            room.render(&light, number)
        });
        frames.collect()
    };
    Captures {
        black: shoot(&Pattern::BLACK, 3),
        white: shoot(&Pattern::WHITE, 3),
        prmvs: shoot(&pattern.coded.clone().into(), 2),
        unary: shoot(&pattern.coded.unary(pattern.unary).into(), 2),
    }
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
