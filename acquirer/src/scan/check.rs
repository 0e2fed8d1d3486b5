//! Whether a scan on disk is still what was written: every file that has a checksum is read and compared.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde::Serialize;
use shared::stage::Stage;

use super::{
    Checksum, ScanError, ScanFolder,
    finer::finer_folders,
    folder::unfinished,
    manifest::{MANIFEST, is_inside},
    write_whole,
};

/// Name of the list of checksums in a results folder, in the form that `sha256sum --check` reads.
const SUMS: &str = "SHA256SUMS";

/// What a check found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CheckedScan {
    /// Nothing is damaged or missing.
    pub intact: bool,
    /// Files that are what was written.
    pub intact_files: usize,
    /// Files that are something else, or are gone.
    pub damaged: Vec<DamagedFile>,
    /// Files that were recorded without a checksum, by an older or another program; they can be read.
    pub without_checksum: Vec<String>,
    /// Files that a crash left half written; they belong to nothing.
    pub unfinished: Vec<String>,
    /// Stages whose recording has not been finished.
    pub unrecorded: Vec<Stage>,
    /// Finer grids whose recording has not been finished in a stage whose own is.
    pub unrecorded_finer: Vec<UnrecordedFiner>,
    /// Whether results are there and were written to the end.
    pub results: bool,
}

/// A finer grid that a stage lacks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct UnrecordedFiner {
    /// The stage.
    pub stage: Stage,
    /// The number of the grid's lines.
    pub lines: usize,
}

/// A file that is not what was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct DamagedFile {
    /// Relative to the scan folder.
    pub file: String,
    /// What is wrong with it.
    pub reason: String,
}

/// Checks a scan folder and its results.
///
/// # Errors
/// A manifest that can't be read at all, a list of checksums that is none.
pub fn check_scan(dir: &Path) -> Result<CheckedScan, ScanError> {
    let folder = ScanFolder::open(dir)?;
    let mut check = Check {
        dir,
        intact: 0,
        damaged: Vec::new(),
        without_checksum: Vec::new(),
    };
    check.manifest(&folder)?;
    check.recorded(&folder);
    let sums = read_sums(&folder.results_dir().join(SUMS))?;
    for (checksum, file) in sums.iter().flatten() {
        check.file(&format!("results/{file}"), *checksum);
    }
    let unfinished = unfinished(dir)?;
    let (recorded, unrecorded): (Vec<_>, Vec<_>) = Stage::BOTH
        .into_iter()
        .partition(|stage| folder.is_recorded(*stage));
    let mut unrecorded_finer = Vec::new();
    for stage in recorded {
        let lines = folder.unrecorded_lines(stage)?.into_iter();
        unrecorded_finer.extend(lines.map(|lines| UnrecordedFiner { stage, lines }));
    }
    Ok(CheckedScan {
        intact: check.damaged.is_empty(),
        intact_files: check.intact,
        damaged: check.damaged,
        without_checksum: check.without_checksum,
        unfinished: unfinished.iter().map(|path| within(dir, path)).collect(),
        unrecorded,
        unrecorded_finer,
        results: sums.is_some(),
    })
}

/// Endings of the files that a run leaves; what else a person put there may change.
const RESULTS: [&str; 5] = ["csv", "html", "json", "ply", "png"];

fn is_result(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| RESULTS.contains(&ending))
}

/// Writes the checksums of the files in a results folder, last of all: where the list is, the results are complete.
///
/// # Errors
/// A file that can't be read or written.
pub(crate) fn write_sums(dir: &Path) -> Result<(), ScanError> {
    let mut files = Vec::new();
    let mut folders = finer_folders(dir)?;
    folders.extend([dir.to_owned(), dir.join("pictures")]);
    for folder in folders {
        let file_error = |source| ScanError::File {
            path: folder.clone(),
            source,
        };
        for entry in fs::read_dir(&folder).map_err(file_error)? {
            let path = entry.map_err(file_error)?.path();
            if path.is_file() && is_result(&path) {
                files.push(path);
            }
        }
    }
    files.sort();
    let mut list = String::new();
    for path in files {
        let checksum = Checksum::of_file(&path).map_err(|source| ScanError::File {
            path: path.clone(),
            source,
        })?;
        list.push_str(&format!("{checksum}  {}\n", within(dir, &path)));
    }
    write_whole(&dir.join(SUMS), list.as_bytes())?;
    Ok(())
}

/// The path of the list of checksums in a results folder.
pub(crate) fn sums_path(results: &Path) -> PathBuf {
    results.join(SUMS)
}

/// The list, or nothing where there is none.
fn read_sums(path: &Path) -> Result<Option<Vec<(Checksum, String)>>, ScanError> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => {
            return Err(ScanError::File {
                path: path.to_owned(),
                source,
            });
        }
    };
    let entries = text.lines().enumerate().map(|(number, line)| {
        sum(line).ok_or_else(|| ScanError::Sums {
            path: path.to_owned(),
            line: number + 1,
        })
    });
    entries.collect::<Result<_, _>>().map(Some)
}

fn sum(line: &str) -> Option<(Checksum, String)> {
    let (checksum, file) = line.split_once("  ")?;
    let checksum = checksum.parse().ok()?;
    is_inside(file).then(|| (checksum, file.to_owned()))
}

fn within(dir: &Path, path: &Path) -> String {
    let inside = path.strip_prefix(dir).unwrap_or(path);
    inside.display().to_string()
}

struct Check<'a> {
    dir: &'a Path,
    intact: usize,
    damaged: Vec<DamagedFile>,
    without_checksum: Vec<String>,
}

impl Check<'_> {
    fn manifest(&mut self, folder: &ScanFolder) -> Result<(), ScanError> {
        let path = self.dir.join(MANIFEST);
        let bytes = fs::read(&path).map_err(|source| ScanError::File { path, source })?;
        match folder.manifest().own_checksum(&bytes) {
            Some((told, found)) if told == found => self.intact += 1,
            Some(_) => self.damage(MANIFEST, "changed since it was written".to_owned()),
            None => self.without_checksum.push(MANIFEST.to_owned()),
        }
        Ok(())
    }

    fn recorded(&mut self, folder: &ScanFolder) {
        let manifest = folder.manifest();
        for (file, checksum) in manifest.sha256.iter().filter(|(file, _)| *file != MANIFEST) {
            self.file(file, *checksum);
        }
        let has_none = |file: &&String| !manifest.sha256.contains_key(*file);
        for entry in &manifest.captures {
            if has_none(&&entry.file) {
                self.unsigned(&entry.file, folder.picture(entry).map(|_| ()));
            }
        }
        if let Some(file) = manifest.calibration.as_ref().filter(has_none) {
            let path = self.dir.join(file);
            let read = fs::read(&path).map(|_| ());
            self.unsigned(
                file,
                read.map_err(|source| ScanError::File { path, source }),
            );
        }
    }

    fn file(&mut self, file: &str, expected: Checksum) {
        match Checksum::of_file(&self.dir.join(file)) {
            Ok(found) if found == expected => self.intact += 1,
            Ok(_) => self.damage(file, "changed since it was written".to_owned()),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                self.damage(file, "missing".to_owned());
            }
            Err(error) => self.damage(file, error.to_string()),
        }
    }

    fn unsigned(&mut self, file: &str, read: Result<(), ScanError>) {
        match read {
            Ok(()) => self.without_checksum.push(file.to_owned()),
            Err(error) => self.damage(file, error.to_string()),
        }
    }

    fn damage(&mut self, file: &str, reason: String) {
        self.damaged.push(DamagedFile {
            file: file.to_owned(),
            reason,
        });
    }
}
