//! The scan folder on disk: `scan.json` and one PNG per capture.
//!
//! Every file is written beside its name, flushed to the disk and renamed, the picture before the
//! manifest that names it, so that a crash leaves either the whole capture or none of it.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::{Component, Path, PathBuf},
};

use image::{ImageFormat, RgbImage};
use serde::{Deserialize, Serialize};
use shared::{
    pattern::{GridSettings, PatternError, RasterSize, Rgb},
    stage::Stage,
};
use thiserror::Error;

use crate::pipeline::{Captures, Projected};

/// The version of the folder's layout that this program writes and reads.
pub const FORMAT: u32 = 1;
/// Name of the manifest in a scan folder.
const MANIFEST: &str = "scan.json";
/// Largest width or height of a capture that is read, in pixels.
const MAX_SIDE_PX: u32 = 16_384;

/// Why a scan folder can't be read or written.
#[derive(Debug, Error)]
pub enum ScanError {
    /// A file that can't be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A manifest that is not what the format asks for.
    #[error("{path}: {source}")]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// Written by a newer program.
    #[error("{path}: format {found}, but this program reads format {FORMAT}; use a newer acquirer")]
    Format {
        /// The manifest.
        path: PathBuf,
        /// The format it says.
        found: u32,
    },
    /// A picture that can't be decoded or encoded.
    #[error("{path}: {source}")]
    Picture {
        /// The picture.
        path: PathBuf,
        /// What is wrong with it.
        source: image::ImageError,
    },
    /// A picture that is not of the camera's size.
    #[error("{path}: {found} px, but scan.json says that the camera gives {expected} px")]
    Size {
        /// The picture.
        path: PathBuf,
        /// Its size.
        found: RasterSize,
        /// The size in the manifest.
        expected: RasterSize,
    },
    /// A manifest entry that points outside of the folder.
    #[error("{path}: capture file {file:?} must be a relative path inside the scan folder")]
    Outside {
        /// The manifest.
        path: PathBuf,
        /// The path it gives.
        file: String,
    },
    /// A folder that already holds a scan.
    #[error("{0} already holds a scan; choose another folder or remove it")]
    Exists(PathBuf),
}

/// What the projector showed during a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Shows {
    /// Black.
    Black,
    /// White.
    White,
    /// The coded grid.
    Prmvs,
    /// The single-colour grid.
    Unary,
    /// A solid colour.
    Solid(Rgb),
}

impl Shows {
    /// The four kinds of a full recording, in recording order.
    pub const RECORDING: [Self; 4] = [Self::Black, Self::White, Self::Prmvs, Self::Unary];

    /// The word in file names: the kind, or the colour's six digits.
    #[must_use]
    pub fn stem(self) -> String {
        String::from(self).trim_start_matches('#').to_owned()
    }
}

impl From<Shows> for String {
    fn from(shows: Shows) -> Self {
        match shows {
            Shows::Black => "black".into(),
            Shows::White => "white".into(),
            Shows::Prmvs => "prmvs".into(),
            Shows::Unary => "unary".into(),
            Shows::Solid(colour) => colour.to_string(),
        }
    }
}

impl TryFrom<String> for Shows {
    type Error = PatternError;

    fn try_from(text: String) -> Result<Self, PatternError> {
        Ok(match text.as_str() {
            "black" => Self::Black,
            "white" => Self::White,
            "prmvs" => Self::Prmvs,
            "unary" => Self::Unary,
            colour => Self::Solid(colour.parse()?),
        })
    }
}

/// One capture in the manifest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaptureEntry {
    /// Without or with the object.
    pub stage: Stage,
    /// What was projected.
    pub shows: Shows,
    /// Picture file, relative to the folder, with forward slashes.
    pub file: String,
}

/// `scan.json`. Unknown keys are kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScanManifest {
    /// Version of the layout: [`FORMAT`].
    pub format: u32,
    /// The coded grid and its unary colour.
    pub pattern: GridSettings,
    /// The projector's raster.
    pub projector: RasterSize,
    /// Size of the captures.
    pub camera: RasterSize,
    /// The captures in the order of recording.
    pub captures: Vec<CaptureEntry>,
    /// Calibration file, relative to the folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<String>,
    /// Everything else.
    #[serde(flatten)]
    pub extra: serde_json::Map<String, serde_json::Value>,
}

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
        let path = dir.join(MANIFEST);
        let bytes = fs::read(&path).map_err(|source| ScanError::File {
            path: path.clone(),
            source,
        })?;
        let manifest: ScanManifest =
            serde_json::from_slice(&bytes).map_err(|source| ScanError::Manifest {
                path: path.clone(),
                source,
            })?;
        if manifest.format != FORMAT {
            return Err(ScanError::Format {
                path,
                found: manifest.format,
            });
        }
        let files = manifest
            .captures
            .iter()
            .map(|c| &c.file)
            .chain(&manifest.calibration);
        if let Some(file) = files.into_iter().find(|file| !is_inside(file)) {
            return Err(ScanError::Outside {
                path,
                file: file.clone(),
            });
        }
        Ok(Self {
            dir: dir.to_owned(),
            manifest,
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
        let known = &self.manifest.captures;
        let number = known
            .iter()
            .filter(|c| c.stage == stage && c.shows == shows)
            .count();
        let file = format!("{stage}/{}-{number:02}.png", shows.stem());
        let path = self.dir.join(&file);
        check_size(&path, picture, self.manifest.camera)?;
        make_dir(&self.dir.join(stage.name()))?;
        let mut png = io::Cursor::new(Vec::new());
        picture
            .write_to(&mut png, ImageFormat::Png)
            .map_err(|source| ScanError::Picture {
                path: path.clone(),
                source,
            })?;
        write_whole(&path, png.get_ref())?;
        self.manifest
            .captures
            .push(CaptureEntry { stage, shows, file });
        self.save_manifest()
    }

    /// Keeps a value beside the contract's keys, for example the settings of the recording.
    ///
    /// # Errors
    /// A file error.
    pub fn note(&mut self, key: &str, value: serde_json::Value) -> Result<(), ScanError> {
        self.manifest.extra.insert(key.to_owned(), value);
        self.save_manifest()
    }

    /// Adds a calibration file to the scan.
    ///
    /// # Errors
    /// A file error.
    pub fn set_calibration(&mut self, json: &str) -> Result<(), ScanError> {
        const NAME: &str = "calibration.json";
        write_whole(&self.dir.join(NAME), json.as_bytes())?;
        self.manifest.calibration = Some(NAME.to_owned());
        self.save_manifest()
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
        let path = self.dir.join(MANIFEST);
        let mut json =
            serde_json::to_vec_pretty(&self.manifest).map_err(|source| ScanError::Manifest {
                path: path.clone(),
                source,
            })?;
        json.push(b'\n');
        write_whole(&path, &json)
    }
}

/// Reads a PNG or JPEG picture as 8-bit RGB, with bounds on its size so that a hostile file can't fill the
/// memory.
///
/// # Errors
/// A file that is missing, broken, or larger than 16384 pixels on a side.
pub fn read_picture(path: &Path) -> Result<RgbImage, ScanError> {
    let file_error = |source| ScanError::File {
        path: path.to_owned(),
        source,
    };
    let picture_error = |source| ScanError::Picture {
        path: path.to_owned(),
        source,
    };
    let mut reader = image::ImageReader::open(path)
        .map_err(file_error)?
        .with_guessed_format()
        .map_err(file_error)?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE_PX);
    limits.max_image_height = Some(MAX_SIDE_PX);
    reader.limits(limits);
    Ok(reader.decode().map_err(picture_error)?.into_rgb8())
}

/// Writes a file so that after a crash it is whole or absent: beside its name, flushed, renamed.
///
/// # Errors
/// What the system says, with the path.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ScanError> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let beside = PathBuf::from(beside);
    let write = || {
        let mut file = File::create(&beside)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&beside, path)?;
        // the rename itself lasts only once the folder is on the disk
        path.parent()
            .map_or(Ok(()), |parent| File::open(parent)?.sync_all())
    };
    write().map_err(|source| ScanError::File {
        path: path.to_owned(),
        source,
    })
}

fn make_dir(dir: &Path) -> Result<(), ScanError> {
    fs::create_dir_all(dir).map_err(|source| ScanError::File {
        path: dir.to_owned(),
        source,
    })
}

fn check_size(path: &Path, picture: &RgbImage, expected: RasterSize) -> Result<(), ScanError> {
    let found = RasterSize {
        width: picture.width(),
        height: picture.height(),
    };
    if found == expected {
        Ok(())
    } else {
        Err(ScanError::Size {
            path: path.to_owned(),
            found,
            expected,
        })
    }
}

pub(super) fn is_inside(file: &str) -> bool {
    let path = Path::new(file);
    !file.is_empty()
        && path
            .components()
            .all(|part| matches!(part, Component::Normal(_)))
}
