//! Reads a scan folder with the built-in settings and writes its tables: the pipeline without the program.
//!
//! ```text
//! cargo run -p acquirer --example read_scan -- SCAN_FOLDER [SETTINGS.toml]
//! ```
//!
//! Writes `results/vertices.csv` and, with a calibration, `results/points.csv`; the stages' pictures go to
//! `results/<stage>-<name>.png`.

use std::{fs, path::Path};

use acquirer::{
    pipeline::{self, PipelineSettings, grid::DecodedGrid, surface::SurfacePoint},
    scan::ScanFolder,
};
use anyhow::{Context, Result, bail};
use shared::{geometry::RigCalibration, pattern::Corner, stage::Stage};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, settings) = match arguments.as_slice() {
        [folder] => (folder, PipelineSettings::default()),
        [folder, file] => (folder, toml::from_str(&fs::read_to_string(file)?)?),
        _ => bail!("give a scan folder and, if you like, a file of settings"),
    };
    let folder = ScanFolder::open(Path::new(folder))?;
    let calibration = match folder.calibration_path() {
        Some(path) => Some(RigCalibration::from_json(&fs::read(path)?)?),
        None => None,
    };
    let results = folder.results_dir();
    fs::create_dir_all(&results)?;
    let projected = folder.projected();
    let mut vertices = csv::Writer::from_path(results.join("vertices.csv"))?;
    vertices.write_record([
        "stage",
        "row",
        "column",
        "vertex",
        "x_px",
        "y_px",
        "confidence",
    ])?;
    for stage in [Stage::Background, Stage::Object] {
        let captures = folder.captures(stage)?;
        let started = std::time::Instant::now();
        let reading = pipeline::read_stage(&captures, &projected, calibration.as_ref(), &settings)
            .with_context(|| format!("stage {stage}"))?;
        let took = started.elapsed();
        println!(
            "{stage}: {} crossings read in {:.1} ms, dropped {:?}",
            reading.grid.crossings.len(),
            took.as_secs_f64() * 1e3,
            reading.grid.dropped_by_reason()
        );
        write_vertices(&mut vertices, stage, &reading.grid)?;
        for picture in &reading.pictures {
            let file = format!("{stage}-{}.png", picture.name);
            picture.picture.save(results.join(file))?;
        }
        if let (Stage::Object, Some(calibration)) = (stage, &calibration) {
            let points = pipeline::find_surface(&reading, &captures, &projected, calibration);
            write_points(&results.join("points.csv"), &points)?;
        }
    }
    vertices.flush()?;
    Ok(())
}

fn write_vertices(out: &mut csv::Writer<fs::File>, stage: Stage, grid: &DecodedGrid) -> Result<()> {
    for crossing in &grid.crossings {
        for (corner, at) in Corner::ALL.into_iter().zip(crossing.vertices) {
            out.write_record([
                stage.to_string(),
                crossing.index.row.to_string(),
                crossing.index.column.to_string(),
                corner.to_string(),
                format!("{:.4}", at.x),
                format!("{:.4}", at.y),
                format!("{:.4}", crossing.confidence),
            ])?;
        }
    }
    Ok(())
}

fn write_points(path: &Path, points: &[SurfacePoint]) -> Result<()> {
    let mut out = csv::Writer::from_path(path)?;
    out.write_record([
        "row",
        "column",
        "vertex",
        "x_mm",
        "y_mm",
        "z_mm",
        "confidence",
    ])?;
    let number = |line: Option<u16>| line.map_or_else(String::new, |line| line.to_string());
    for point in points {
        out.write_record([
            number(point.row),
            number(point.column),
            point
                .corner
                .map_or_else(String::new, |corner| corner.to_string()),
            format!("{:.4}", point.position_mm[0]),
            format!("{:.4}", point.position_mm[1]),
            format!("{:.4}", point.position_mm[2]),
            format!("{:.4}", point.confidence),
        ])?;
    }
    out.flush()?;
    Ok(())
}
