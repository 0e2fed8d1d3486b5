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
    output::tables::{point_table, vertex_table},
    pipeline::{PipelineSettings, find_surface, read_stage, result::ScanResult},
    process::read_calibration,
    scan::{ScanFolder, write_picture},
};
use anyhow::{Context, Result, bail};
use shared::stage::Stage;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, settings) = match arguments.as_slice() {
        [folder] => (folder, PipelineSettings::default()),
        [folder, file] => (folder, toml::from_str(&fs::read_to_string(file)?)?),
        _ => bail!("give a scan folder and, if you like, a file of settings"),
    };
    let folder = ScanFolder::open(Path::new(folder))?;
    let calibration = folder.calibration_path();
    let calibration = calibration
        .map(|path| read_calibration(&path))
        .transpose()?;
    let results = folder.results_dir();
    fs::create_dir_all(&results)?;
    let projected = folder.projected();
    let mut result = ScanResult::default();
    for stage in Stage::BOTH {
        let captures = folder.captures(stage)?;
        let started = std::time::Instant::now();
        let reading = read_stage(&captures, &projected, calibration.as_ref(), &settings)
            .with_context(|| format!("stage {stage}"))?;
        let took = started.elapsed();
        println!(
            "{stage}: {} crossings read in {:.1} ms, dropped {:?}",
            reading.grid.crossings.len(),
            took.as_secs_f64() * 1e3,
            reading.grid.dropped_by_reason()
        );
        for picture in &reading.pictures {
            let file = format!("{stage}-{}.png", picture.name);
            write_picture(&results.join(file), &picture.picture)?;
        }
        if let (Stage::Object, Some(calibration)) = (stage, &calibration) {
            let points = find_surface(&reading, &captures, &projected, calibration);
            fs::write(results.join("points.csv"), point_table(&points))?;
        }
        match stage {
            Stage::Background => result.background = Some(reading),
            Stage::Object => result.object = Some(reading),
        }
    }
    fs::write(results.join("vertices.csv"), vertex_table(&result))?;
    Ok(())
}
