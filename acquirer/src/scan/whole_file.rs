//! Files that are whole or absent after a crash: written beside their name, flushed to the disk, renamed.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

use super::{Checksum, ScanError};

/// What the name of a file under way ends with.
pub(super) const UNFINISHED: &str = ".part";

/// A file under way; it takes its name when it is finished, and is removed when it never is.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    beside: PathBuf,
    file: Option<BufWriter<File>>,
    hash: Sha256,
}

impl WholeFile {
    /// Begins a file.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub fn create(path: &Path) -> Result<Self, ScanError> {
        let mut beside = path.as_os_str().to_owned();
        beside.push(UNFINISHED);
        let beside = PathBuf::from(beside);
        match File::create(&beside) {
            Ok(file) => Ok(Self {
                path: path.to_owned(),
                beside,
                file: Some(BufWriter::new(file)),
                hash: Sha256::new(),
            }),
            Err(source) => Err(file_error(path, source)),
        }
    }

    /// Brings the file to the disk, under its name; gives the checksum of what was written.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub fn finish(mut self) -> Result<Checksum, ScanError> {
        let put = |file: BufWriter<File>| {
            let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
            file.sync_all()?;
            fs::rename(&self.beside, &self.path)?;
            // the rename itself lasts only once the folder is on the disk
            sync_parent(&self.path)
        };
        match self.file.take().map(put) {
            Some(Err(source)) => {
                self.remove_unfinished();
                Err(file_error(&self.path, source))
            }
            _ => Ok(Checksum::finished(std::mem::take(&mut self.hash))),
        }
    }

    fn remove_unfinished(&self) {
        match fs::remove_file(&self.beside) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                tracing::warn!("{} is left over: {error}", self.beside.display());
            }
            _ => {}
        }
    }

    fn under_way(&mut self) -> io::Result<&mut BufWriter<File>> {
        let closed = || io::Error::other("the file was finished already");
        self.file.as_mut().ok_or_else(closed)
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.under_way()?.write(bytes)?;
        self.hash.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.under_way()?.flush()
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            // what is still in the buffer is of no use
            drop(file.into_parts());
            self.remove_unfinished();
        }
    }
}

/// Writes a file so that after a crash it is whole or absent; gives its checksum.
///
/// # Errors
/// What the system says, with the path.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<Checksum, ScanError> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes)
        .map_err(|source| file_error(path, source))?;
    file.finish()
}

/// Makes a folder and those it stands in, so that it is still there after a power cut.
///
/// # Errors
/// What the system says.
pub(crate) fn make_dir(dir: &Path) -> io::Result<()> {
    if dir.is_dir() {
        return Ok(());
    }
    if let Some(parent) = dir.parent().filter(|parent| *parent != Path::new("")) {
        make_dir(parent)?;
    }
    match fs::create_dir(dir) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => Err(error),
        _ => sync_parent(dir),
    }
}

/// Brings the names in the folder of a file to the disk.
fn sync_parent(path: &Path) -> io::Result<()> {
    match path.parent() {
        Some(parent) if parent != Path::new("") => File::open(parent)?.sync_all(),
        Some(_) => File::open(".")?.sync_all(),
        None => Ok(()),
    }
}

pub(super) fn file_error(path: &Path, source: io::Error) -> ScanError {
    ScanError::File {
        path: path.to_owned(),
        source,
    }
}
