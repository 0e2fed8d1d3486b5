//! What a scan leaves behind in `DIR/results/`: tables, a point cloud, pictures, a report, a summary.
//!
//! Takes the scan folder and the pipeline's result. Every file is written whole or not at all, and the same scan
//! gives the same bytes: no file holds a time or a path. Files of an earlier run that this one does not make are
//! removed, so that everything in the folder belongs together. `SHA256SUMS` comes last, after `summary.json`: where it
//! is, the run was finished. Pictures are large: captures are read from the folder when they are wanted, figures are drawn one at a
//! time, and the report is written piece by piece.

pub mod colour_map;
mod data_uri;
pub mod drawing;
pub mod error;
pub mod figure;
mod figures;
pub mod finer;
pub mod maps;
pub mod ply;
pub mod relief;
mod report;
pub mod response;
pub mod shift_table;
pub mod stage_picture;
pub mod summary;
pub mod tables;

use std::{
    collections::BTreeSet,
    fs, io,
    path::{Path, PathBuf},
};

use shared::stage::Stage;

pub use error::OutputError;
use figures::Figures;
use shift_table::{ShiftRow, write_shift_table};
pub use stage_picture::EncodedPicture;
pub use summary::Summary;

use crate::{
    pipeline::{colour_choice::ColourSelection, result::ScanResult},
    scan::{ScanFolder, sums_path, write_json, write_sums, write_whole},
};

/// Where the results of a scan went.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResultPaths {
    /// The folder that holds everything.
    pub dir: PathBuf,
    /// `vertices.csv`.
    pub vertices: PathBuf,
    /// `shifts.csv`.
    pub shifts: PathBuf,
    /// `points.ply`, with a calibration.
    pub cloud: Option<PathBuf>,
    /// `points.csv`, with a calibration.
    pub points: Option<PathBuf>,
    /// The folder of the pictures.
    pub pictures: PathBuf,
    /// `report.html`, all pictures inside.
    pub report: PathBuf,
    /// `summary.json`.
    pub summary: PathBuf,
}

/// Writes the results of a scan into its `results` folder.
///
/// `stage_pictures` are the pipeline's own of both stages, in the order of [`shared::stage::Stage::BOTH`]; `selection` is
/// how the grid's colours were chosen, if they were chosen for this scene.
///
/// # Errors
/// [`OutputError`] with the path: a folder or file that can't be written, a full disk, a capture that can't be read.
pub fn write_results(
    folder: &ScanFolder,
    stage_pictures: &[Vec<EncodedPicture>; 2],
    result: &ScanResult,
    selection: Option<&ColourSelection>,
) -> Result<ResultPaths, OutputError> {
    let dir = folder.results_dir();
    let file = |name: &str| dir.join(name);
    let pictures_dir = file("pictures");
    make_dir(&pictures_dir)?;
    let summary_path = file("summary.json");
    remove_outdated(&sums_path(&dir))?;
    remove_outdated(&summary_path)?;

    let vertices = file("vertices.csv");
    write_whole(&vertices, tables::vertex_table(result).as_bytes())?;
    let shifts = file("shifts.csv");
    let rows: Vec<ShiftRow> = result.shifts.iter().map(ShiftRow::from).collect();
    write_shift_table(&shifts, &rows)?;
    for (name, table) in [
        ("lines.csv", tables::line_table(result)),
        ("line_shifts.csv", tables::line_shift_table(result)),
        ("shift_quality.csv", tables::shift_quality_table(result)),
    ] {
        write_whole(&file(name), table.as_bytes())?;
    }
    finer::write_finer(&dir, result, folder.manifest().calibration.is_some())?;
    let points = write_points(&dir, folder, result)?;

    let summary = Summary::of(folder, result);
    for picture in stage_pictures.iter().flatten() {
        write_whole(&pictures_dir.join(&picture.file), &picture.png)?;
    }
    let figures = Figures::write(folder, result, &pictures_dir)?;
    let stage_files = stage_pictures.iter().flatten().map(|p| p.file.clone());
    remove_others(&pictures_dir, &figures.files().chain(stage_files).collect())?;
    let report_path = file("report.html");
    let content = report::Content {
        folder,
        summary: &summary,
        figures: &figures,
        stage_pictures,
        selection,
    };
    report::write(&report_path, &content)?;
    write_json(&summary_path, &summary)?;
    write_sums(&dir)?;
    let (points, cloud) = points.unzip();
    Ok(ResultPaths {
        dir,
        vertices,
        shifts,
        cloud,
        points,
        pictures: pictures_dir,
        report: report_path,
        summary: summary_path,
    })
}

/// Writes the points of both stages and their difference when the scan is calibrated, else removes old ones.
fn write_points(
    dir: &Path,
    folder: &ScanFolder,
    result: &ScanResult,
) -> Result<Option<(PathBuf, PathBuf)>, OutputError> {
    let (table, cloud) = (dir.join("points.csv"), dir.join("points.ply"));
    let (background, difference) = (dir.join("background.ply"), dir.join("difference.csv"));
    let Some(calibration) = &folder.manifest().calibration else {
        for path in [&table, &cloud, &background, &difference] {
            remove_outdated(path)?;
        }
        return Ok(None);
    };
    write_whole(&table, tables::point_table(&result.surface).as_bytes())?;
    let base = &folder.manifest().pattern.coded;
    let lines = base.rows().max(base.columns());
    for (path, stage) in [(&background, Stage::Background), (&cloud, Stage::Object)] {
        let clouds = finer::clouds(result, lines, stage);
        write_whole(path, &ply::point_cloud(&clouds, calibration))?;
    }
    write_whole(&difference, tables::difference_table(result).as_bytes())?;
    Ok(Some((table, cloud)))
}

/// Removes the pictures of an earlier run, which showed something else.
fn remove_others(dir: &Path, written: &BTreeSet<String>) -> Result<(), OutputError> {
    let folder_error = |source| OutputError::Folder {
        path: dir.to_owned(),
        source,
    };
    for entry in fs::read_dir(dir).map_err(folder_error)? {
        let path = entry.map_err(folder_error)?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        if name.is_some_and(|name| name.ends_with(".png") && !written.contains(name)) {
            remove_outdated(&path)?;
        }
    }
    Ok(())
}

fn make_dir(dir: &Path) -> Result<(), OutputError> {
    crate::scan::make_dir(dir).map_err(|source| OutputError::Folder {
        path: dir.to_owned(),
        source,
    })
}

/// Removes a file of an earlier run, if there is one.
fn remove_outdated(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => Err(OutputError::Outdated {
            path: path.to_owned(),
            source,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
