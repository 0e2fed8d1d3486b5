//! `scan.json`: pattern, raster, camera size, and the captures.

use std::{
    fs,
    path::{Component, Path},
};

use serde::{Deserialize, Serialize};
use shared::{
    pattern::{GridSettings, RasterSize},
    stage::Stage,
};

use super::{ScanError, Shows, write_whole};

/// The version of the folder's layout that this program writes and reads.
pub const FORMAT: u32 = 1;

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

impl ScanManifest {
    /// Reads and checks a manifest.
    ///
    /// # Errors
    /// A file that is missing, broken, of another format, or that names files outside its folder.
    pub(super) fn read(path: &Path) -> Result<Self, ScanError> {
        let bytes = fs::read(path).map_err(|source| ScanError::File {
            path: path.to_owned(),
            source,
        })?;
        let manifest: Self = serde_json::from_slice(&bytes).map_err(|source| ScanError::Json {
            path: path.to_owned(),
            source,
        })?;
        if manifest.format != FORMAT {
            return Err(ScanError::Format {
                path: path.to_owned(),
                found: manifest.format,
            });
        }
        let captures = manifest.captures.iter().map(|capture| &capture.file);
        let mut files = captures.chain(&manifest.calibration);
        if let Some(file) = files.find(|file| !is_inside(file)) {
            return Err(ScanError::Outside {
                path: path.to_owned(),
                file: file.clone(),
            });
        }
        Ok(manifest)
    }

    /// Writes the manifest, whole or not at all.
    ///
    /// # Errors
    /// A file error.
    pub(super) fn write(&self, path: &Path) -> Result<(), ScanError> {
        write_json(path, self)
    }

    /// The captures of one stage that show one thing, in the order of recording.
    pub fn captures_of(&self, stage: Stage, shows: Shows) -> impl Iterator<Item = &CaptureEntry> {
        let mine = move |c: &&CaptureEntry| c.stage == stage && c.shows == shows;
        self.captures.iter().filter(mine)
    }
}

/// Writes a value as indented JSON with a line feed at its end, whole or not at all.
///
/// # Errors
/// A file error.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), ScanError> {
    let mut json = serde_json::to_vec_pretty(value).map_err(|source| ScanError::Json {
        path: path.to_owned(),
        source,
    })?;
    json.push(b'\n');
    write_whole(path, &json)
}

/// Whether a path stays in the folder that it is relative to.
pub(super) fn is_inside(file: &str) -> bool {
    let path = Path::new(file);
    !file.is_empty()
        && path
            .components()
            .all(|part| matches!(part, Component::Normal(_)))
}
