//! The figures of a scan: each is drawn once, saved as PNG, and kept as SVG for the report.
//!
//! Takes captures and results, gives the decoded grid of each stage, shifts, depth, the object's height over the
//! background, and the surface from the side. With a surface in mm depth and 3-D view are in mm, else they show the
//! relative depth of the shift table. Nothing is drawn of what was not measured.

use std::path::{Path, PathBuf};

use image::RgbImage;
use shared::stage::Stage;

use super::{
    OutputError,
    data_uri::Encoding,
    figure::Figure,
    finer,
    maps::{height_map, label_map, relative_depth_map, shift_map, surface_depth_map},
    relief::{Colouring, Viewpoint, draw_relief, draw_surface},
    shift_table::ShiftRow,
};
use crate::{
    pipeline::{
        grid::DecodedGrid,
        result::{FinerScan, ScanResult},
    },
    scan::{ScanFolder, Shows, write_picture},
};

/// What the camera saw, to be drawn over, in the order of preference: the scene in full light.
const SCENE: [Shows; 3] = [Shows::White, Shows::Unary, Shows::Prmvs];
/// The same: the grid.
const GRID: [Shows; 2] = [Shows::Unary, Shows::Prmvs];

/// A figure that was saved, with what it shows.
#[derive(Debug)]
pub(super) struct SavedFigure {
    pub(super) caption: &'static str,
    /// An SVG element with everything inside.
    pub(super) svg: String,
    file: String,
}

/// All figures of a scan.
#[derive(Debug, Default)]
pub(super) struct Figures {
    /// The decoded grids, background first.
    pub(super) labels: Vec<SavedFigure>,
    /// The decoded finer grids with the object, coarse before fine.
    pub(super) finer: Vec<SavedFigure>,
    /// Shifts, depth and height over the camera's picture.
    pub(super) maps: Vec<SavedFigure>,
    /// The surface seen from the side.
    pub(super) views: Vec<SavedFigure>,
}

impl Figures {
    /// Draws everything that was measured, one figure at a time, and writes each as PNG into a folder that exists.
    ///
    /// # Errors
    /// [`OutputError`] with the path.
    pub(super) fn write(
        folder: &ScanFolder,
        result: &ScanResult,
        dir: &Path,
    ) -> Result<Self, OutputError> {
        let mut figures = Self::default();
        let drawer = Drawer {
            folder,
            result,
            dir,
        };
        for stage in Stage::BOTH {
            figures.labels.extend(drawer.labels(stage)?);
        }
        for scan in &result.finer {
            figures.finer.extend(drawer.finer_labels(scan)?);
        }
        let scene = first_of(folder, Stage::Object, &SCENE)?;
        figures.maps = drawer.maps(scene.as_ref())?;
        figures.views = drawer.views(scene.as_ref())?;
        Ok(figures)
    }

    /// The names of the files that were written.
    pub(super) fn files(&self) -> impl Iterator<Item = String> {
        let groups = [&self.labels, &self.finer, &self.maps, &self.views];
        let all = groups.into_iter().flatten();
        all.map(|figure| figure.file.clone())
    }
}

/// The scene of a stage as the camera saw it, for drawing over it.
///
/// # Errors
/// A capture that can't be read.
pub(super) fn scene_of(folder: &ScanFolder, stage: Stage) -> Result<Option<RgbImage>, OutputError> {
    first_of(folder, stage, &SCENE)
}

fn first_of(
    folder: &ScanFolder,
    stage: Stage,
    kinds: &[Shows],
) -> Result<Option<RgbImage>, OutputError> {
    for &shows in kinds {
        if let Some(picture) = folder.first_capture(stage, shows)? {
            return Ok(Some(picture));
        }
    }
    Ok(None)
}

/// Draws figures of a result and saves them.
struct Drawer<'a> {
    folder: &'a ScanFolder,
    result: &'a ScanResult,
    dir: &'a Path,
}

impl Drawer<'_> {
    fn labels(&self, stage: Stage) -> Result<Option<SavedFigure>, OutputError> {
        let Some(reading) = self.result.stage(stage) else {
            return Ok(None);
        };
        let picture = self.or_dark(first_of(self.folder, stage, &GRID)?);
        let grid = &self.folder.manifest().pattern.coded;
        let figure = label_map(&reading.grid, grid, &picture);
        let (name, caption) = match stage {
            Stage::Background => (
                "labels-background",
                "Before: the decoded grid without the object.",
            ),
            Stage::Object => ("labels-object", "After: the decoded grid with the object."),
        };
        self.save((name, caption), &figure, Encoding::Jpeg)
            .map(Some)
    }

    fn finer_labels(&self, scan: &FinerScan) -> Result<Option<SavedFigure>, OutputError> {
        let Some(reading) = &scan.result.object else {
            return Ok(None);
        };
        let seen = self
            .folder
            .first_finer_capture(&scan.pattern, Stage::Object, &GRID)?;
        let figure = label_map(&reading.grid, &scan.pattern.coded, &self.or_dark(seen));
        let name = format!("labels-object-{}", finer::name(scan));
        let caption =
            "A finer grid with the object, decoded beside the known places of the coarser ones.";
        self.save((&name, caption), &figure, Encoding::Jpeg)
            .map(Some)
    }

    fn maps(&self, scene: Option<&RgbImage>) -> Result<Vec<SavedFigure>, OutputError> {
        let result = self.result;
        let scene = &self.or_dark(scene.cloned());
        let mut maps = Vec::new();
        let mut save = |named, figure: Figure| {
            maps.push(self.save(named, &figure, Encoding::Png)?);
            Ok::<_, OutputError>(())
        };
        if !result.shifts.is_empty() {
            let caption =
                "How far each crossing moved in the camera's picture when the object was put in.";
            save(("shift-map", caption), shift_map(&result.shifts, scene))?;
        }
        if let Some(grid) = self.surface_grid() {
            let caption = "Distance along the camera's axis. Cells with a missing crossing or a cut stay open.";
            let map = surface_depth_map(&result.surface, grid, scene);
            save(("depth-map", caption), map)?;
        } else if !result.shifts.is_empty() {
            let caption = "Relative depth. Cells with a missing crossing or a cut stay open.";
            let map = relative_depth_map(&self.shift_rows(), scene);
            save(("depth-map", caption), map)?;
        }
        if let Some(grid) = self
            .object_grid()
            .filter(|_| !result.differences.is_empty())
        {
            let caption = "How far the object stands out of the background, along the projector's rays. Cells \
                           with a crossing that is missing in either stage, or with a cut, stay open.";
            let map = height_map(&result.differences, grid, scene);
            save(("difference-map", caption), map)?;
        }
        Ok(maps)
    }

    fn views(&self, scene: Option<&RgbImage>) -> Result<Vec<SavedFigure>, OutputError> {
        let result = self.result;
        if result.surface.is_empty() && result.shifts.is_empty() {
            return Ok(Vec::new());
        }
        let from = Viewpoint::default();
        let draw = |colouring: Colouring<'_>| match self.surface_grid() {
            Some(grid) => draw_surface(&result.surface, grid, from, colouring),
            None => draw_relief(&self.shift_rows(), from, colouring),
        };
        let by_depth = (
            "view-depth",
            "The surface from the right and above, coloured by depth. Dots are measured points.",
        );
        let mut views = vec![self.save(by_depth, &draw(Colouring::Depth), Encoding::Png)?];
        if let Some(scene) = scene {
            let by_picture = (
                "view-picture",
                "The same surface in the colours that the camera sees.",
            );
            let figure = draw(Colouring::Picture(scene));
            views.push(self.save(by_picture, &figure, Encoding::Png)?);
        }
        Ok(views)
    }

    fn object_grid(&self) -> Option<&DecodedGrid> {
        self.result.object.as_ref().map(|object| &object.grid)
    }

    /// The object's grid, when there is a surface in mm.
    fn surface_grid(&self) -> Option<&DecodedGrid> {
        self.object_grid()
            .filter(|_| !self.result.surface.is_empty())
    }

    fn shift_rows(&self) -> Vec<ShiftRow> {
        self.result.shifts.iter().map(ShiftRow::from).collect()
    }

    /// A picture, or darkness of the camera's size where none was captured.
    fn or_dark(&self, picture: Option<RgbImage>) -> RgbImage {
        let size = self.folder.manifest().camera;
        picture.unwrap_or_else(|| RgbImage::new(size.width.min(16_384), size.height.min(16_384)))
    }

    fn save(
        &self,
        (name, caption): (&str, &'static str),
        figure: &Figure,
        encoding: Encoding,
    ) -> Result<SavedFigure, OutputError> {
        let file = format!("{name}.png");
        let path: PathBuf = self.dir.join(&file);
        write_picture(&path, &figure.painted())?;
        let svg = figure.svg(encoding);
        Ok(SavedFigure {
            caption,
            svg: svg.map_err(|source| OutputError::picture(&path, source))?,
            file,
        })
    }
}
