//! A scan copied to another folder.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use super::{
    ScanError, WholeFile,
    folder::make_dir,
    manifest::MANIFEST,
    whole_file::{UNFINISHED, file_error},
};

/// Copies a scan with its results, every file whole and flushed and the manifest last: a folder that a crash or a full
/// disk leaves half copied is no scan, and the next copy to the same name goes on with it.
///
/// # Errors
/// [`ScanError::Exists`] where a scan is already; a file that can't be read or written.
pub fn copy_scan(from: &Path, to: &Path) -> Result<(), ScanError> {
    if to.join(MANIFEST).exists() {
        return Err(ScanError::Exists(to.to_owned()));
    }
    let manifest = from.join(MANIFEST);
    let mut files = Vec::new();
    files_below(from, &mut files)?;
    files.sort_by_key(|file| *file == manifest);
    for file in files {
        let target = to.join(file.strip_prefix(from).unwrap_or(&file));
        if let Some(dir) = target.parent() {
            make_dir(dir)?;
        }
        copy_file(&file, &target)?;
    }
    Ok(())
}

fn copy_file(from: &Path, to: &Path) -> Result<(), ScanError> {
    let mut source = File::open(from).map_err(|source| file_error(from, source))?;
    let mut target = WholeFile::create(to)?;
    io::copy(&mut source, &mut target).map_err(|source| file_error(to, source))?;
    target.finish().map(|_| ())
}

/// All files of a folder and those in it, but for what a crash left half written.
fn files_below(dir: &Path, files: &mut Vec<PathBuf>) -> Result<(), ScanError> {
    let failed = |source| file_error(dir, source);
    for entry in fs::read_dir(dir).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() {
            files_below(&path, files)?;
        } else if !path.to_string_lossy().ends_with(UNFINISHED) {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(root: &Path) -> PathBuf {
        let from = root.join("cup");
        fs::create_dir_all(from.join("object")).unwrap();
        fs::write(from.join(MANIFEST), "{}").unwrap();
        fs::write(from.join("object/white-00.png"), "picture").unwrap();
        fs::write(from.join("object/white-01.png.part"), "pic").unwrap();
        from
    }

    #[test]
    fn a_scan_is_copied_whole_and_never_over_another() {
        let dir = tempfile::tempdir().unwrap();
        let (from, to) = (scan(dir.path()), dir.path().join("kept/cup"));
        copy_scan(&from, &to).unwrap();
        let copied = fs::read_to_string(to.join("object/white-00.png")).unwrap();
        assert_eq!(copied, "picture");
        assert!(to.join(MANIFEST).exists() && !to.join("object/white-01.png.part").exists());
        let again = copy_scan(&from, &to).unwrap_err();
        assert!(matches!(again, ScanError::Exists(_)), "{again}");
    }

    #[test]
    fn what_could_not_be_copied_whole_is_no_scan_and_the_next_copy_goes_on() {
        let dir = tempfile::tempdir().unwrap();
        let (from, to) = (scan(dir.path()), dir.path().join("kept"));
        // a folder stands where a picture should go
        let blocked = to.join("object/white-00.png");
        fs::create_dir_all(&blocked).unwrap();
        let error = copy_scan(&from, &to).unwrap_err().to_string();
        assert!(error.contains("white-00.png"), "{error}");
        assert!(!to.join(MANIFEST).exists());
        fs::remove_dir(&blocked).unwrap();
        copy_scan(&from, &to).unwrap();
        assert!(to.join(MANIFEST).exists());
    }
}
