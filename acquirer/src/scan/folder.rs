//! The scan folder on disk: `scan.json` and one PNG per capture.
//!
//! Every file is whole or absent after a crash, and a picture is there before the manifest names it: a crash leaves
//! either the whole capture or none of it. A stage that is recorded again gets files of other names, and the manifest
//! goes over from the old ones to the new ones at once.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs, io,
    path::{Path, PathBuf},
};

use image::RgbImage;
use serde::Serialize;
use shared::{geometry::RigCalibration, pattern::RasterSize, stage::Stage};

use super::{
    CaptureEntry, FORMAT, ScanError, ScanManifest, Shows,
    finer::{finer_folders, forget_finer},
    manifest::{MANIFEST, write_json},
    picture::{check_size, read_picture, write_picture},
    whole_file::UNFINISHED,
    write_whole,
};
use crate::pipeline::{Captures, Projected, colour_choice::ColourSelection};

/// Name of the file that says how the grid's colours were chosen.
const SELECTION: &str = "colours.json";

/// A scan on disk.
#[derive(Debug, Clone)]
pub struct ScanFolder {
    dir: PathBuf,
    manifest: ScanManifest,
}

impl ScanFolder {
    /// Starts a scan without captures in a folder that is made if need be.
    ///
    /// # Errors
    /// [`ScanError::Exists`] where a scan is already, or a file error.
    pub fn create(
        dir: &Path,
        projected: &Projected,
        camera: RasterSize,
    ) -> Result<Self, ScanError> {
        if dir.join(MANIFEST).exists() {
            return Err(ScanError::Exists(dir.to_owned()));
        }
        make_dir(dir)?;
        let manifest = ScanManifest {
            format: FORMAT,
            pattern: projected.pattern.clone(),
            projector: projected.raster,
            camera,
            captures: Vec::new(),
            calibration: None,
            sha256: BTreeMap::new(),
            extra: serde_json::Map::new(),
        };
        let mut folder = Self {
            dir: dir.to_owned(),
            manifest: manifest.clone(),
        };
        folder.take_over(manifest)?;
        Ok(folder)
    }

    /// Reads the manifest of an existing scan; the pictures are read when asked for.
    ///
    /// # Errors
    /// A manifest that is missing, broken, of another format, or that names files outside the folder.
    pub fn open(dir: &Path) -> Result<Self, ScanError> {
        Ok(Self {
            dir: dir.to_owned(),
            manifest: ScanManifest::read(&dir.join(MANIFEST))?,
        })
    }

    /// The folder.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// What `scan.json` says.
    #[must_use]
    pub fn manifest(&self) -> &ScanManifest {
        &self.manifest
    }

    /// What was projected.
    #[must_use]
    pub fn projected(&self) -> Projected {
        Projected {
            pattern: self.manifest.pattern.clone(),
            raster: self.manifest.projector,
        }
    }

    /// The path of the calibration file, if the scan has one.
    #[must_use]
    pub fn calibration_path(&self) -> Option<PathBuf> {
        self.manifest
            .calibration
            .as_ref()
            .map(|file| self.dir.join(file))
    }

    /// Where results go.
    #[must_use]
    pub fn results_dir(&self) -> PathBuf {
        self.dir.join("results")
    }

    /// Whether every kind of picture of a full recording is there of this stage.
    #[must_use]
    pub fn is_recorded(&self, stage: Stage) -> bool {
        let has = |shows: &Shows| self.manifest.captures_of(stage, *shows).next().is_some();
        Shows::RECORDING.iter().all(has)
    }

    /// Adds a capture: the picture is on disk before the manifest names it.
    ///
    /// # Errors
    /// A file error, or a picture of another size than the camera's; the scan is as it was then.
    pub fn add_capture(
        &mut self,
        stage: Stage,
        shows: Shows,
        picture: &RgbImage,
    ) -> Result<(), ScanError> {
        let mut next = self.manifest.clone();
        let taken = &mut self.names();
        self.put_capture(&mut next, taken, (stage, shows), picture)?;
        self.take_over(next)
    }

    /// Puts new captures in the place of all that the scan holds of one stage, at once: until the last of them is on
    /// disk the scan has the old ones. The old pictures stay in the folder until their names are used again.
    ///
    /// # Errors
    /// As [`Self::add_capture`].
    pub fn replace_stage<'a>(
        &mut self,
        stage: Stage,
        captures: impl IntoIterator<Item = (Shows, &'a RgbImage)>,
    ) -> Result<(), ScanError> {
        let mut next = self.manifest.clone();
        let mut taken = self.names();
        next.forget(stage);
        forget_finer(&mut next, &self.dir.join(MANIFEST), stage)?;
        for (shows, picture) in captures {
            self.put_capture(&mut next, &mut taken, (stage, shows), picture)?;
        }
        self.take_over(next)
    }

    /// The names of pictures that the manifest on disk tells of.
    fn names(&self) -> BTreeSet<String> {
        let captures = self.manifest.captures.iter();
        captures.map(|capture| capture.file.clone()).collect()
    }

    /// Writes a picture under a name that nobody needs any more, and enters it.
    fn put_capture(
        &self,
        manifest: &mut ScanManifest,
        taken: &mut BTreeSet<String>,
        (stage, shows): (Stage, Shows),
        picture: &RgbImage,
    ) -> Result<(), ScanError> {
        let numbered = |number| format!("{stage}/{}-{number:02}.png", shows.stem());
        let mut names = (0..).map(numbered);
        let Some(file) = names.find(|name| !taken.contains(name)) else {
            unreachable!("there are more numbers than captures");
        };
        let path = self.dir.join(&file);
        check_size(&path, picture, self.manifest.camera)?;
        make_dir(&self.dir.join(stage.name()))?;
        let checksum = write_picture(&path, picture)?;
        taken.insert(file.clone());
        manifest.sha256.insert(file.clone(), checksum);
        manifest.captures.push(CaptureEntry { stage, shows, file });
        Ok(())
    }

    /// Keeps a value beside the contract's keys, for example the settings of the recording.
    ///
    /// # Errors
    /// A file error, or a value that is no JSON.
    pub fn note(&mut self, key: &str, value: &impl Serialize) -> Result<(), ScanError> {
        let value = serde_json::to_value(value).map_err(|source| ScanError::Json {
            path: self.dir.join(MANIFEST),
            source,
        })?;
        let mut next = self.manifest.clone();
        next.extra.insert(key.to_owned(), value);
        self.take_over(next)
    }

    /// Adds a calibration file to the scan.
    ///
    /// # Errors
    /// A file error, or a calibration that can't be.
    pub fn set_calibration(&mut self, calibration: &RigCalibration) -> Result<(), ScanError> {
        const NAME: &str = "calibration.json";
        let path = self.dir.join(NAME);
        let json = calibration.to_json();
        let json = json.map_err(|source| ScanError::Calibration {
            path: path.clone(),
            source,
        })?;
        let checksum = write_whole(&path, json.as_bytes())?;
        let mut next = self.manifest.clone();
        next.calibration = Some(NAME.to_owned());
        next.sha256.insert(NAME.to_owned(), checksum);
        self.take_over(next)
    }

    /// Keeps how the grid's colours were chosen, in a file of its own.
    ///
    /// # Errors
    /// A file error.
    pub fn set_selection(&mut self, selection: &ColourSelection) -> Result<(), ScanError> {
        let checksum = write_json(&self.dir.join(SELECTION), selection)?;
        let mut next = self.manifest.clone();
        next.sha256.insert(SELECTION.to_owned(), checksum);
        self.take_over(next)
    }

    /// How the grid's colours were chosen, if they were chosen for this scan.
    ///
    /// # Errors
    /// A file that can't be read or is no choice of colours.
    pub fn selection(&self) -> Result<Option<ColourSelection>, ScanError> {
        let path = self.dir.join(SELECTION);
        match fs::read(&path) {
            Ok(bytes) => match serde_json::from_slice(&bytes) {
                Ok(selection) => Ok(Some(selection)),
                Err(source) => Err(ScanError::Json { path, source }),
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(ScanError::File { path, source }),
        }
    }

    /// Reads the pictures of one stage.
    ///
    /// # Errors
    /// A picture that is missing, broken, or not of the camera's size.
    pub fn captures(&self, stage: Stage) -> Result<Captures, ScanError> {
        let mut captures = Captures::default();
        for entry in self
            .manifest
            .captures
            .iter()
            .filter(|entry| entry.stage == stage)
        {
            let kind = match entry.shows {
                Shows::Black => &mut captures.black,
                Shows::White => &mut captures.white,
                Shows::Prmvs => &mut captures.prmvs,
                Shows::Unary => &mut captures.unary,
                // read by themselves, see `measure_scan_response`
                Shows::Solid(_) => continue,
            };
            kind.push(self.picture(entry)?);
        }
        Ok(captures)
    }

    /// Reads the first picture of a stage that shows one thing; `None` when it was not recorded.
    ///
    /// # Errors
    /// As [`Self::captures`].
    pub fn first_capture(&self, stage: Stage, shows: Shows) -> Result<Option<RgbImage>, ScanError> {
        let entry = self.manifest.captures_of(stage, shows).next();
        entry.map(|entry| self.picture(entry)).transpose()
    }

    /// Reads one picture.
    ///
    /// # Errors
    /// A picture that is missing, broken, or not of the camera's size.
    pub fn picture(&self, entry: &CaptureEntry) -> Result<RgbImage, ScanError> {
        let path = self.dir.join(&entry.file);
        let picture = read_picture(&path)?;
        check_size(&path, &picture, self.manifest.camera)?;
        Ok(picture)
    }

    /// Removes what a crash left half written.
    ///
    /// # Errors
    /// A folder that can't be listed, a file that can't be removed.
    pub fn remove_unfinished(&self) -> Result<(), ScanError> {
        for path in unfinished(&self.dir)? {
            fs::remove_file(&path).map_err(|source| ScanError::File { path, source })?;
        }
        Ok(())
    }

    /// Writes a manifest, which counts from then on.
    pub(super) fn take_over(&mut self, mut next: ScanManifest) -> Result<(), ScanError> {
        next.write(&self.dir.join(MANIFEST))?;
        self.manifest = next;
        Ok(())
    }
}

/// The files that a crash left half written in the folder and in those of the stages and of finer grids.
pub(super) fn unfinished(dir: &Path) -> Result<Vec<PathBuf>, ScanError> {
    let stages = |dir: PathBuf| Stage::BOTH.map(|stage| dir.join(stage.name()));
    let finer = finer_folders(dir)?.into_iter().flat_map(stages);
    let dirs = std::iter::once(dir.to_owned()).chain(stages(dir.to_owned()));
    let mut found = Vec::new();
    for dir in dirs.chain(finer) {
        let entries = match fs::read_dir(&dir) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(source) => return Err(ScanError::File { path: dir, source }),
        };
        let paths = entries.flatten().map(|entry| entry.path());
        found.extend(paths.filter(|path| path.to_string_lossy().ends_with(UNFINISHED)));
    }
    found.sort();
    Ok(found)
}

pub(super) fn make_dir(dir: &Path) -> Result<(), ScanError> {
    super::make_dir(dir).map_err(|source| ScanError::File {
        path: dir.to_owned(),
        source,
    })
}
