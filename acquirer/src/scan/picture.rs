//! Pictures on disk: read with bounds on their size, written as PNG, whole or not at all.

use std::path::Path;

use image::{RgbImage, codecs::png::PngEncoder};
use shared::pattern::RasterSize;

use super::{Checksum, ScanError, WholeFile};

/// Largest width or height of a picture that is read, in pixels.
const MAX_SIDE_PX: u32 = 16_384;

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

/// Writes a picture as PNG; gives the file's checksum.
///
/// # Errors
/// What the system says, with the path.
pub fn write_picture(path: &Path, picture: &RgbImage) -> Result<Checksum, ScanError> {
    let mut file = WholeFile::create(path)?;
    let encoded = picture.write_with_encoder(PngEncoder::new(&mut file));
    encoded.map_err(|source| ScanError::Picture {
        path: path.to_owned(),
        source,
    })?;
    file.finish()
}

/// Checks that a picture is of the camera's size.
///
/// # Errors
/// [`ScanError::Size`] with the picture's path.
pub(super) fn check_size(
    path: &Path,
    picture: &RgbImage,
    expected: RasterSize,
) -> Result<(), ScanError> {
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
