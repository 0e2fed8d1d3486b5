//! Finer grids of a scan: extra captures beside the base grid's, under the key `finer` of `scan.json`.
//!
//! `"finer": [{"pattern": {...}, "captures": [{"stage", "shows": "prmvs" or "unary", "file"}, ...]}, ...]`, coarse
//! before fine. Programs that do not know the key read the base grid as ever.

use std::{
    fs,
    path::{Path, PathBuf},
};

use image::RgbImage;
use serde::{Deserialize, Serialize};
use shared::{
    pattern::{Axis, GridSettings},
    stage::Stage,
};

use super::{
    CaptureEntry, ScanError, ScanFolder, ScanManifest, Shows,
    folder::make_dir,
    manifest::{MANIFEST, is_inside},
    picture::{check_size, write_picture},
};
use crate::pipeline::{Captures, Projected};

/// The key of the manifest.
pub(crate) const FINER_KEY: &str = "finer";
/// Beginning of the names of folders, before the larger number of lines.
pub(crate) const PREFIX: &str = "finer-";

/// A finer grid and its captures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FinerGrid {
    /// The grid and its unary colour.
    pub pattern: GridSettings,
    /// Its captures; black and white are those of the base grid.
    pub captures: Vec<CaptureEntry>,
}

impl FinerGrid {
    /// The larger number of its lines, which names its files.
    #[must_use]
    pub fn lines(&self) -> usize {
        lines(&self.pattern)
    }
}

fn lines(pattern: &GridSettings) -> usize {
    let [rows, columns] = Axis::BOTH.map(|axis| pattern.coded.lines(axis));
    rows.max(columns)
}

impl ScanFolder {
    /// The finer grids, coarse before fine; none in most scans.
    ///
    /// # Errors
    /// An entry that is not what the format asks for, or names files outside of the folder.
    pub fn finer(&self) -> Result<Vec<FinerGrid>, ScanError> {
        finer_of(self.manifest(), &self.dir().join(MANIFEST))
    }

    /// What was projected of a finer grid.
    #[must_use]
    pub fn projected_finer(&self, grid: &FinerGrid) -> Projected {
        Projected {
            pattern: grid.pattern.clone(),
            raster: self.manifest().projector,
        }
    }

    /// The captures of a finer grid in one stage, with the stage's black and white.
    ///
    /// # Errors
    /// A picture that is missing, broken, or not of the camera's size.
    pub fn finer_captures(&self, grid: &FinerGrid, stage: Stage) -> Result<Captures, ScanError> {
        let mut captures = Captures::default();
        let base = self.manifest().captures.iter();
        let references = base.filter(|entry| matches!(entry.shows, Shows::Black | Shows::White));
        for entry in references.chain(&grid.captures) {
            let kind = match entry.shows {
                Shows::Black => &mut captures.black,
                Shows::White => &mut captures.white,
                Shows::Prmvs => &mut captures.prmvs,
                Shows::Unary => &mut captures.unary,
                Shows::Solid(_) => continue,
            };
            if entry.stage == stage {
                kind.push(self.picture(entry)?);
            }
        }
        Ok(captures)
    }

    /// The first picture of a finer grid in one stage, of these kinds in the order of preference.
    ///
    /// # Errors
    /// As [`Self::finer_captures`].
    pub fn first_finer_capture(
        &self,
        pattern: &GridSettings,
        stage: Stage,
        kinds: &[Shows],
    ) -> Result<Option<RgbImage>, ScanError> {
        let grids = self.finer()?;
        let captures = grids
            .iter()
            .filter(|grid| grid.pattern == *pattern)
            .flat_map(|grid| &grid.captures);
        let mut wanted = kinds.iter().filter_map(|&shows| {
            let mut captures = captures.clone();
            captures.find(|entry| entry.stage == stage && entry.shows == shows)
        });
        wanted.next().map(|entry| self.picture(entry)).transpose()
    }

    /// Adds a capture of a finer grid: the picture is on disk before the manifest names it.
    ///
    /// # Errors
    /// A file error, or a picture of another size than the camera's.
    pub fn add_finer_capture(
        &mut self,
        pattern: &GridSettings,
        stage: Stage,
        shows: Shows,
        picture: &RgbImage,
    ) -> Result<(), ScanError> {
        let mut next = self.manifest().clone();
        let mut grids = self.finer()?;
        let at = match grids.iter().position(|grid| grid.pattern == *pattern) {
            Some(at) => at,
            None => {
                grids.push(FinerGrid {
                    pattern: pattern.clone(),
                    captures: Vec::new(),
                });
                grids.len() - 1
            }
        };
        let known = grids[at].captures.iter();
        let number = known
            .filter(|c| c.stage == stage && c.shows == shows)
            .count();
        let folder = format!("{PREFIX}{}/{stage}", lines(pattern));
        let file = format!("{folder}/{}-{number:02}.png", shows.stem());
        let path = self.dir().join(&file);
        check_size(&path, picture, self.manifest().camera)?;
        make_dir(&self.dir().join(&folder))?;
        let checksum = write_picture(&path, picture)?;
        next.sha256.insert(file.clone(), checksum);
        grids[at].captures.push(CaptureEntry { stage, shows, file });
        set_finer(&mut next, &self.dir().join(MANIFEST), &grids)?;
        self.take_over(next)
    }

    /// The numbers of lines of the finer grids that the recording was begun for, as far as its settings were noted.
    #[must_use]
    pub fn noted_lines(&self) -> Vec<usize> {
        let record = |settings: &serde_json::Value| settings.get("record")?.get("densify").cloned();
        let noted = self.manifest().extra.get("settings").and_then(record);
        let lines = noted.and_then(|noted| serde_json::from_value(noted).ok());
        lines.unwrap_or_default()
    }

    /// The finer grids that the recording was begun for and of which a recorded stage has not as many captures as of
    /// the base grid, by their numbers of lines.
    ///
    /// # Errors
    /// As [`Self::finer`].
    pub fn unrecorded_lines(&self, stage: Stage) -> Result<Vec<usize>, ScanError> {
        let repeats = self.manifest().captures_of(stage, Shows::Prmvs).count();
        let base = lines(&self.manifest().pattern);
        let grids = self.finer()?;
        let mut unrecorded = Vec::new();
        for wanted in self.noted_lines().into_iter().filter(|&k| k != base) {
            let recorded = match grids.iter().find(|grid| grid.lines() == wanted) {
                Some(grid) => self.has_finer(&grid.pattern, stage, repeats)?,
                None => false,
            };
            if !recorded {
                unrecorded.push(wanted);
            }
        }
        Ok(unrecorded)
    }

    /// Whether a finer grid has so many captures of each kind in one stage.
    ///
    /// # Errors
    /// As [`Self::finer`].
    pub fn has_finer(
        &self,
        pattern: &GridSettings,
        stage: Stage,
        repeats: usize,
    ) -> Result<bool, ScanError> {
        let grids = self.finer()?;
        let grid = grids.iter().find(|grid| grid.pattern == *pattern);
        let count = |shows| {
            let captures = grid.iter().flat_map(|grid| &grid.captures);
            captures
                .filter(|c| c.stage == stage && c.shows == shows)
                .count()
        };
        Ok([Shows::Prmvs, Shows::Unary]
            .into_iter()
            .all(|shows| count(shows) >= repeats))
    }

    /// Forgets the captures of a finer grid in one stage, of which a recording was cut off. Their files stay until
    /// their names are used again.
    ///
    /// # Errors
    /// A file error; the scan is as it was then.
    pub fn forget_finer_captures(
        &mut self,
        pattern: &GridSettings,
        stage: Stage,
    ) -> Result<(), ScanError> {
        let mut next = self.manifest().clone();
        let path = self.dir().join(MANIFEST);
        forget(&mut next, &path, |grid| grid.pattern == *pattern, stage)?;
        if next == *self.manifest() {
            return Ok(());
        }
        self.take_over(next)
    }
}

/// Takes the finer captures of one stage out of a manifest, and their checksums.
///
/// # Errors
/// As [`ScanFolder::finer`]; `path` is the manifest's.
pub(super) fn forget_finer(
    manifest: &mut ScanManifest,
    path: &Path,
    stage: Stage,
) -> Result<(), ScanError> {
    forget(manifest, path, |_| true, stage)
}

/// The same for some of the finer grids.
fn forget(
    manifest: &mut ScanManifest,
    path: &Path,
    which: impl Fn(&FinerGrid) -> bool,
    stage: Stage,
) -> Result<(), ScanError> {
    let mut grids = finer_of(manifest, path)?;
    for grid in grids.iter_mut().filter(|grid| which(grid)) {
        let gone = grid
            .captures
            .iter()
            .filter(|capture| capture.stage == stage);
        for capture in gone {
            manifest.sha256.remove(&capture.file);
        }
        grid.captures.retain(|capture| capture.stage != stage);
    }
    grids.retain(|grid| !grid.captures.is_empty());
    set_finer(manifest, path, &grids)
}

fn set_finer(
    manifest: &mut ScanManifest,
    path: &Path,
    grids: &[FinerGrid],
) -> Result<(), ScanError> {
    if grids.is_empty() {
        manifest.extra.remove(FINER_KEY);
        return Ok(());
    }
    let value = serde_json::to_value(grids).map_err(|source| ScanError::Json {
        path: path.to_owned(),
        source,
    })?;
    manifest.extra.insert(FINER_KEY.to_owned(), value);
    Ok(())
}

fn finer_of(manifest: &ScanManifest, path: &Path) -> Result<Vec<FinerGrid>, ScanError> {
    let Some(value) = manifest.extra.get(FINER_KEY) else {
        return Ok(Vec::new());
    };
    let grids: Result<Vec<FinerGrid>, _> = serde_json::from_value(value.clone());
    let mut grids = grids.map_err(|source| ScanError::Json {
        path: path.to_owned(),
        source,
    })?;
    let mut files = grids.iter().flat_map(|grid| &grid.captures);
    if let Some(capture) = files.find(|capture| !is_inside(&capture.file)) {
        return Err(ScanError::Outside {
            path: path.to_owned(),
            file: capture.file.clone(),
        });
    }
    grids.sort_by_key(FinerGrid::lines);
    Ok(grids)
}

/// The folders of finer grids in a scan folder or in its results.
///
/// # Errors
/// A folder that can't be listed.
pub(crate) fn finer_folders(dir: &Path) -> Result<Vec<PathBuf>, ScanError> {
    let file_error = |source| ScanError::File {
        path: dir.to_owned(),
        source,
    };
    let mut folders = Vec::new();
    for entry in fs::read_dir(dir).map_err(file_error)? {
        let path = entry.map_err(file_error)?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        let lines = name.and_then(|name| name.strip_prefix(PREFIX));
        if lines.is_some_and(|lines| lines.parse::<usize>().is_ok()) && path.is_dir() {
            folders.push(path);
        }
    }
    folders.sort();
    Ok(folders)
}
