//! Single grids of 15, 31 and 63 lines beside progressive density, on every shipped scene: `tests/measured/density.md`.
//!
//! ```text
//! cargo run -p acquirer --example density_table -- [--print]
//! ```
//!
//! Each grid is recorded in the simulated room and read without a calibration: alone, and after the coarser ones with
//! their help. A point is a point of a decoded line; it is right where its light truly comes from within a quarter of
//! the pitch of that line. The scene's share is that of blocks of 8 x 8 camera pixels, lit by the projector, that hold
//! at least one right point.

use std::{collections::HashSet, fmt::Write, fs};

use acquirer::{
    pipeline::{
        Captures, PipelineSettings, Projected, StageReading,
        dense::find_dense_lines,
        densify::{KnownPlaces, finer_pattern, read_finer},
        read_stage,
    },
    score::score_stage,
};
use anyhow::Result;
use rig_tests::measure::{Repeats, SimulatedScan, in_repository, shipped_scenes};
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, GridSettings},
    simulation::{Room, Scene},
    stage::Stage,
};

/// Numbers of lines: the base grid's, and finer ones.
const LINES: [usize; 3] = [15, 31, 63];
/// Side of a block of the scene, camera px.
const BLOCK: u32 = 8;

fn main() -> Result<()> {
    let mut table = String::from(
        "# Progressive density\n\n\
         Written by `cargo run -p acquirer --example density_table`. Points of decoded lines, share of the lit scene \
         with a right point in each 8 x 8 px, and wrong vertex labels: grids of 15, 31 and 63 lines each read alone, and \
         read one after the other, each with the help of the coarser ones. No calibration.\n\n\
         | scene | stage | 15 alone: points | scene % | wrong | 31 alone: points | scene % | wrong | \
         63 alone: points | scene % | wrong | 15, 31: points | scene % | wrong | 15, 31, 63: points | scene % | wrong |\n\
         |---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for path in shipped_scenes()? {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let scene = Scene::load(&path)?;
        let grids = record(&scene)?;
        for (k, stage) in Stage::BOTH.into_iter().enumerate() {
            eprintln!("{name}, {stage}");
            let room = Room::new(&scene, stage);
            writeln!(
                table,
                "| {name} | {stage} | {} |",
                row(&room, &grids, k, stage)?
            )?;
        }
    }
    if std::env::args().any(|argument| argument == "--print") {
        print!("{table}");
    } else {
        fs::write(in_repository("tests/measured/density.md"), table)?;
    }
    Ok(())
}

fn record(scene: &Scene) -> Result<Vec<SimulatedScan>> {
    let base = GridSettings::default();
    let raster = scene.projector_size();
    let scans = LINES.map(|lines| {
        let pattern = finer_pattern(&base, lines, raster)?;
        Ok(SimulatedScan::record(scene, &pattern, Repeats::default()))
    });
    scans.into_iter().collect()
}

/// What was read of one or more grids.
#[derive(Default)]
struct Found {
    points: usize,
    covered: HashSet<(u32, u32)>,
    wrong: usize,
}

impl Found {
    fn add(&mut self, reading: &StageReading, scan: &SimulatedScan, room: &Room, stage: Stage) {
        let read: Vec<_> = reading.grid.vertices().collect();
        self.wrong += score_stage(&scan.truth, &read, stage).wrong;
        let grid = &scan.projected.pattern.coded;
        let raster = scan.projected.raster;
        for line in find_dense_lines(&reading.grid) {
            let centre_px = grid
                .line(line.axis, usize::from(line.line), raster)
                .centre_px();
            let near_px = 0.25 * grid.pitch_px(line.axis, raster);
            self.points += line.points.len();
            for point in &line.points {
                let at = room
                    .projector_at(point.position)
                    .map(|from| match line.axis {
                        Axis::Row => from.y,
                        Axis::Column => from.x,
                    });
                if at.is_some_and(|at| (at - centre_px).abs() < near_px) {
                    self.covered.insert(block(point.position));
                }
            }
        }
    }

    fn cells(&self, lit: usize) -> String {
        let share = 100.0 * self.covered.len() as f64 / lit.max(1) as f64;
        format!("{} | {share:.1} | {}", self.points, self.wrong)
    }
}

fn block(at: CameraPixel) -> (u32, u32) {
    (at.x as u32 / BLOCK, at.y as u32 / BLOCK)
}

fn row(room: &Room, grids: &[SimulatedScan], k: usize, stage: Stage) -> Result<String> {
    let lit = lit_blocks(room, &grids[0].stages[k]);
    let settings = PipelineSettings {
        pictures: false,
        ..PipelineSettings::default()
    };
    let mut cells = Vec::new();
    for scan in grids {
        let mut found = Found::default();
        let reading = read_stage(&scan.stages[k], &scan.projected, None, &settings)?;
        found.add(&reading, scan, room, stage);
        cells.push(found.cells(lit));
    }
    let (mut together, mut known) = (Found::default(), KnownPlaces::default());
    for (n, scan) in grids.iter().enumerate() {
        let projected: &Projected = &scan.projected;
        let mut captures = scan.stages[k].clone();
        let reading = read_finer(&mut captures, projected, None, &settings, known.clone())?;
        known = known.with(KnownPlaces::of(&reading.grid, projected));
        together.add(&reading, scan, room, stage);
        if n > 0 {
            cells.push(together.cells(lit));
        }
    }
    Ok(cells.join(" | "))
}

/// Blocks whose middle the projector lights.
fn lit_blocks(room: &Room, captures: &Captures) -> usize {
    let size = captures
        .prmvs
        .first()
        .map_or((0, 0), |frame| frame.dimensions());
    let middle = |k: u32| f64::from(k * BLOCK) + 0.5 * f64::from(BLOCK);
    let blocks = (0..size.1 / BLOCK).flat_map(|y| (0..size.0 / BLOCK).map(move |x| (x, y)));
    blocks
        .filter(|&(x, y)| {
            room.projector_at(CameraPixel::new(middle(x), middle(y)))
                .is_some()
        })
        .count()
}
