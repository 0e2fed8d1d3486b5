//! Files that are whole or absent after a crash: written beside their name, flushed to the disk, renamed.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

use super::ScanError;

/// A file under way; it takes its name when it is finished.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    beside: PathBuf,
    file: BufWriter<File>,
}

impl WholeFile {
    /// Begins a file.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub fn create(path: &Path) -> Result<Self, ScanError> {
        let mut beside = path.as_os_str().to_owned();
        beside.push(".part");
        let beside = PathBuf::from(beside);
        match File::create(&beside) {
            Ok(file) => Ok(Self {
                path: path.to_owned(),
                beside,
                file: BufWriter::new(file),
            }),
            Err(source) => Err(file_error(path, source)),
        }
    }

    /// Brings the file to the disk, under its name.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub fn finish(self) -> Result<(), ScanError> {
        let Self { path, beside, file } = self;
        let put = || {
            let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
            file.sync_all()?;
            fs::rename(&beside, &path)?;
            // the rename itself lasts only once the folder is on the disk
            path.parent()
                .map_or(Ok(()), |parent| File::open(parent)?.sync_all())
        };
        put().map_err(|source| file_error(&path, source))
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Writes a file so that after a crash it is whole or absent.
///
/// # Errors
/// What the system says, with the path.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ScanError> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes)
        .map_err(|source| file_error(path, source))?;
    file.finish()
}

fn file_error(path: &Path, source: io::Error) -> ScanError {
    ScanError::File {
        path: path.to_owned(),
        source,
    }
}
