//! The scan folder on disk: `scan.json` and one PNG per capture.
//!
//! Every file is whole or absent after a crash, and a picture is there before the manifest names it: a crash leaves
//! either the whole capture or none of it.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use image::RgbImage;
use serde::Serialize;
use shared::{geometry::RigCalibration, pattern::RasterSize, stage::Stage};

use super::{
    CaptureEntry, FORMAT, ScanError, ScanManifest, Shows,
    manifest::write_json,
    picture::{check_size, read_picture, write_picture},
    write_whole,
};
use crate::pipeline::{Captures, Projected, colour_choice::ColourSelection};

/// Name of the manifest in a scan folder.
const MANIFEST: &str = "scan.json";
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
            extra: serde_json::Map::new(),
        };
        let folder = Self {
            dir: dir.to_owned(),
            manifest,
        };
        folder.save_manifest()?;
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

    /// Adds a capture: the picture is on disk before the manifest names it.
    ///
    /// # Errors
    /// A file error, or a picture of another size than the camera's.
    pub fn add_capture(
        &mut self,
        stage: Stage,
        shows: Shows,
        picture: &RgbImage,
    ) -> Result<(), ScanError> {
        let number = self.manifest.captures_of(stage, shows).count();
        let file = format!("{stage}/{}-{number:02}.png", shows.stem());
        let path = self.dir.join(&file);
        check_size(&path, picture, self.manifest.camera)?;
        make_dir(&self.dir.join(stage.name()))?;
        write_picture(&path, picture)?;
        self.manifest
            .captures
            .push(CaptureEntry { stage, shows, file });
        self.save_manifest()
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
        self.manifest.extra.insert(key.to_owned(), value);
        self.save_manifest()
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
        write_whole(&path, json.as_bytes())?;
        self.manifest.calibration = Some(NAME.to_owned());
        self.save_manifest()
    }

    /// Keeps how the grid's colours were chosen, in a file of its own.
    ///
    /// # Errors
    /// A file error.
    pub fn set_selection(&self, selection: &ColourSelection) -> Result<(), ScanError> {
        write_json(&self.dir.join(SELECTION), selection)
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

    /// Forgets the captures of one stage, so that it can be recorded again. Their pictures stay until
    /// they are overwritten.
    ///
    /// # Errors
    /// A file error.
    pub fn retake(&mut self, stage: Stage) -> Result<(), ScanError> {
        self.manifest
            .captures
            .retain(|capture| capture.stage != stage);
        self.save_manifest()
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

    fn save_manifest(&self) -> Result<(), ScanError> {
        self.manifest.write(&self.dir.join(MANIFEST))
    }
}

pub(super) fn make_dir(dir: &Path) -> Result<(), ScanError> {
    fs::create_dir_all(dir).map_err(|source| ScanError::File {
        path: dir.to_owned(),
        source,
    })
}
