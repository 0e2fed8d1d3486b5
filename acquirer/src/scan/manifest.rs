//! `scan.json`: pattern, raster, camera size, and the captures.

use std::{
    collections::BTreeMap,
    fs,
    path::{Component, Path},
};

use serde::{Deserialize, Serialize};
use shared::{
    pattern::{GridSettings, RasterSize},
    stage::Stage,
};

use super::{Checksum, ScanError, Shows, write_whole};

/// The version of the folder's layout that this program writes and reads.
pub const FORMAT: u32 = 1;

/// Name of the manifest in a scan folder.
pub(super) const MANIFEST: &str = "scan.json";

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
    /// SHA-256 of the recorded files by their names, and of this one: its own is made with zeros in the place of its
    /// digits.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sha256: BTreeMap<String, Checksum>,
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
        let mut files = captures
            .chain(&manifest.calibration)
            .chain(manifest.sha256.keys());
        if let Some(file) = files.find(|file| !is_inside(file)) {
            return Err(ScanError::Outside {
                path: path.to_owned(),
                file: file.clone(),
            });
        }
        Ok(manifest)
    }

    /// Writes the manifest with its own checksum, whole or not at all.
    ///
    /// # Errors
    /// A file error.
    pub(super) fn write(&mut self, path: &Path) -> Result<(), ScanError> {
        self.sha256.insert(MANIFEST.to_owned(), Checksum::ZERO);
        let unsigned = json(path, self)?;
        self.sha256
            .insert(MANIFEST.to_owned(), Checksum::of(&unsigned));
        write_whole(path, &json(path, self)?)?;
        Ok(())
    }

    /// The checksum that a manifest's bytes should hold of themselves.
    pub(super) fn own_checksum(&self, bytes: &[u8]) -> Option<(Checksum, Checksum)> {
        let told = *self.sha256.get(MANIFEST)?;
        let text = std::str::from_utf8(bytes).ok()?;
        let unsigned = text.replacen(&told.to_string(), &Checksum::ZERO.to_string(), 1);
        Some((told, Checksum::of(unsigned.as_bytes())))
    }

    /// Takes the captures of one stage out, and their checksums.
    pub(super) fn forget(&mut self, stage: Stage) {
        self.captures.retain(|capture| {
            let stays = capture.stage != stage;
            if !stays {
                self.sha256.remove(&capture.file);
            }
            stays
        });
    }

    /// The captures of one stage that show one thing, in the order of recording.
    pub fn captures_of(&self, stage: Stage, shows: Shows) -> impl Iterator<Item = &CaptureEntry> {
        let mine = move |c: &&CaptureEntry| c.stage == stage && c.shows == shows;
        self.captures.iter().filter(mine)
    }
}

/// Writes a value as indented JSON with a line feed at its end, whole or not at all; gives the file's checksum.
///
/// # Errors
/// A file error.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<Checksum, ScanError> {
    write_whole(path, &json(path, value)?)
}

fn json(path: &Path, value: &impl Serialize) -> Result<Vec<u8>, ScanError> {
    let mut json = serde_json::to_vec_pretty(value).map_err(|source| ScanError::Json {
        path: path.to_owned(),
        source,
    })?;
    json.push(b'\n');
    Ok(json)
}

/// Whether a name of a file stays inside its folder.
pub(super) fn is_inside(file: &str) -> bool {
    let path = Path::new(file);
    !file.is_empty()
        && path
            .components()
            .all(|part| matches!(part, Component::Normal(_)))
}
