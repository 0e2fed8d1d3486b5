//! The pictures of a scan, drawn once for the PNG files and the report.
//!
//! Takes captures and results, gives figures: the decoded grid of each stage, shifts, depth, the surface from the
//! side, and the pipeline's own stage pictures. With a surface in mm depth and 3-D view are in mm, else they show
//! the relative depth of the shift table. Nothing is drawn of what was not measured.

use std::{collections::BTreeSet, fs, io::Cursor, path::Path};

use image::{ImageFormat, RgbImage};
use rayon::prelude::*;
use shared::stage::Stage;

use super::{
    OutputError,
    figure::Figure,
    finer,
    maps::{label_map, relative_depth_map, shift_map, surface_depth_map},
    relief::{Colouring, Viewpoint, draw_relief, draw_surface},
    shift_table::ShiftRow,
};
use crate::{
    pipeline::{
        Captures, StagePicture,
        result::{FinerScan, ScanResult},
    },
    scan::{ScanFolder, write_whole},
};

/// A figure with the name of its file and what it shows.
#[derive(Debug, Clone)]
pub(super) struct Named {
    pub(super) name: &'static str,
    pub(super) caption: &'static str,
    pub(super) figure: Figure,
}

/// All pictures of a scan.
#[derive(Debug)]
pub(super) struct Pictures<'a> {
    /// The decoded grids, background first.
    pub(super) labels: Vec<Named>,
    /// Shifts and depth over the camera's picture.
    pub(super) maps: Vec<Named>,
    /// The surface seen from the side.
    pub(super) views: Vec<Named>,
    /// The finer grids with the object, with the names of their files.
    pub(super) finer: Vec<(String, Figure)>,
    /// The pipeline's own pictures.
    pub(super) stages: Vec<(Stage, &'a [StagePicture])>,
}

impl<'a> Pictures<'a> {
    /// Draws everything that was measured.
    pub(super) fn of(
        folder: &ScanFolder,
        captures: [&Captures; 2],
        result: &'a ScanResult,
    ) -> Self {
        let size = folder.manifest().camera;
        let dark = RgbImage::new(size.width.min(16_384), size.height.min(16_384));
        let labels = Stage::BOTH
            .into_iter()
            .zip(captures)
            .filter_map(|(stage, captures)| {
                let seen = captures.unary.first().or(captures.prmvs.first());
                let picture = seen.unwrap_or(&dark);
                let grid = &result.stage(stage)?.grid;
                let figure = label_map(grid, &folder.manifest().pattern.coded, picture);
                Some(labels_named(stage, figure))
            })
            .collect();
        let object = captures[1];
        let scene = [&object.white, &object.unary, &object.prmvs]
            .into_iter()
            .find_map(|kind| kind.first());
        Self {
            labels,
            maps: maps(result, scene.unwrap_or(&dark)),
            views: views(result, scene),
            finer: result.finer.iter().filter_map(finer_labels).collect(),
            stages: Stage::BOTH
                .into_iter()
                .filter_map(|stage| Some((stage, result.stage(stage)?.pictures.as_slice())))
                .collect(),
        }
    }

    /// Writes every picture as PNG into a folder that exists, and removes other PNG files from it.
    ///
    /// # Errors
    /// [`OutputError`] with the path.
    pub(super) fn save(&self, dir: &Path) -> Result<(), OutputError> {
        let figures = self.labels.iter().chain(&self.maps).chain(&self.views);
        let figures = figures.map(|named| (format!("{}.png", named.name), &named.figure));
        let finer = self.finer.iter();
        let figures: Vec<_> = figures
            .chain(finer.map(|(name, figure)| (format!("{name}.png"), figure)))
            .collect();
        let pictures: Vec<_> = self.stages.iter().flat_map(stage_files).collect();
        figures
            .par_iter()
            .try_for_each(|(file, figure)| save_png(&dir.join(file), &figure.painted()))?;
        pictures
            .par_iter()
            .try_for_each(|(file, picture)| save_png(&dir.join(file), picture))?;
        let figures = figures.into_iter().map(|(file, _)| file);
        let written = figures
            .chain(pictures.into_iter().map(|(file, _)| file))
            .collect();
        remove_others(dir, &written)
    }
}

/// The pictures of one stage with the names of their files.
fn stage_files<'a>(
    (stage, pictures): &(Stage, &'a [StagePicture]),
) -> impl Iterator<Item = (String, &'a RgbImage)> {
    let stage = *stage;
    pictures.iter().enumerate().map(move |(k, picture)| {
        let file = format!("{stage}-{:02}-{}.png", k + 1, picture.name);
        (file, &picture.picture)
    })
}

fn labels_named(stage: Stage, figure: Figure) -> Named {
    match stage {
        Stage::Background => Named {
            name: "labels-background",
            caption: "Before: the decoded grid without the object.",
            figure,
        },
        Stage::Object => Named {
            name: "labels-object",
            caption: "After: the decoded grid with the object.",
            figure,
        },
    }
}

/// The decoded finer grid over its own picture.
fn finer_labels(scan: &FinerScan) -> Option<(String, Figure)> {
    let grid = &scan.result.object.as_ref()?.grid;
    let figure = label_map(grid, &scan.pattern.coded, scan.seen.as_ref()?);
    Some((format!("labels-object-{}", finer::name(scan)), figure))
}

fn rows(result: &ScanResult) -> Vec<ShiftRow> {
    result.shifts.iter().map(ShiftRow::from).collect()
}

fn maps(result: &ScanResult, scene: &RgbImage) -> Vec<Named> {
    let mut maps = Vec::new();
    if !result.shifts.is_empty() {
        maps.push(Named {
            name: "shift-map",
            caption: "How far each crossing moved in the camera's picture when the object was put in.",
            figure: shift_map(&result.shifts, scene),
        });
    }
    let grid = result.object.as_ref().map(|object| &object.grid);
    if let Some(grid) = grid.filter(|_| !result.surface.is_empty()) {
        maps.push(Named {
            name: "depth-map",
            caption: "Distance along the camera's axis. Cells with a missing crossing or a cut stay open.",
            figure: surface_depth_map(&result.surface, grid, scene),
        });
    } else if !result.shifts.is_empty() {
        maps.push(Named {
            name: "depth-map",
            caption: "Relative depth. Cells with a missing crossing or a cut stay open.",
            figure: relative_depth_map(&rows(result), scene),
        });
    }
    maps
}

fn views(result: &ScanResult, scene: Option<&RgbImage>) -> Vec<Named> {
    let from = Viewpoint::default();
    let grid = result.object.as_ref().map(|object| &object.grid);
    let draw = |colouring: Colouring<'_>| match grid {
        Some(grid) if !result.surface.is_empty() => {
            draw_surface(&result.surface, grid, from, colouring)
        }
        _ => draw_relief(&rows(result), from, colouring),
    };
    if result.surface.is_empty() && result.shifts.is_empty() {
        return Vec::new();
    }
    let by_depth = Named {
        name: "view-depth",
        caption: "The surface from the right and above, coloured by depth. Dots are measured points.",
        figure: draw(Colouring::Depth),
    };
    let by_picture = scene.map(|scene| Named {
        name: "view-picture",
        caption: "The same surface in the colours that the camera sees.",
        figure: draw(Colouring::Picture(scene)),
    });
    [Some(by_depth), by_picture].into_iter().flatten().collect()
}

fn save_png(path: &Path, picture: &RgbImage) -> Result<(), OutputError> {
    let mut png = Cursor::new(Vec::new());
    picture
        .write_to(&mut png, ImageFormat::Png)
        .map_err(|source| OutputError::Picture {
            path: path.to_owned(),
            source,
        })?;
    Ok(write_whole(path, png.get_ref())?)
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
            super::remove_outdated(&path)?;
        }
    }
    Ok(())
}
