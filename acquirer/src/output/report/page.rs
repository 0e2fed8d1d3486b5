//! The page under way: text and pictures go to the disk as they come, so that it is never in memory as a whole.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use image::RgbImage;

use crate::{
    output::{
        OutputError,
        data_uri::{Encoding, write_data_uri},
    },
    scan::{ScanError, WholeFile},
};

/// An HTML file that takes its name when it is finished.
#[derive(Debug)]
pub(super) struct Page {
    path: PathBuf,
    file: WholeFile,
}

impl Page {
    /// Begins a page.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub(super) fn create(path: &Path) -> Result<Self, OutputError> {
        Ok(Self {
            path: path.to_owned(),
            file: WholeFile::create(path)?,
        })
    }

    /// Adds text as it is.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub(super) fn text(&mut self, text: &str) -> Result<(), OutputError> {
        let written = self.file.write_all(text.as_bytes());
        written.map_err(|source| {
            OutputError::File(ScanError::File {
                path: self.path.clone(),
                source,
            })
        })
    }

    /// Adds a photograph as the address of itself.
    ///
    /// # Errors
    /// A picture that can't be encoded, or what the system says, with the path.
    pub(super) fn photograph(&mut self, picture: &RgbImage) -> Result<(), OutputError> {
        write_data_uri(picture, Encoding::Jpeg, &mut self.file)
            .map_err(|source| OutputError::picture(&self.path, source))
    }

    /// Brings the page to the disk, under its name.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub(super) fn finish(self) -> Result<(), OutputError> {
        self.file.finish()?;
        Ok(())
    }
}
