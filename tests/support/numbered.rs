//! Pictures that tell their own number, so that a capture on disk can be told from any other.

use acquirer::scan::{ScanFolder, Shows};
use image::{Rgb, RgbImage};
use shared::{pattern::RasterSize, stage::Stage};

/// Their size in pixels: large enough for a file of several blocks.
pub const SIZE: RasterSize = RasterSize {
    width: 64,
    height: 48,
};

/// The picture of a number: that number's bytes, and a texture of it that does not compress to nothing.
#[must_use]
pub fn picture(number: u32) -> RgbImage {
    RgbImage::from_fn(SIZE.width, SIZE.height, |x, y| {
        let mixed = (x + SIZE.width * y)
            .wrapping_mul(2_654_435_761)
            .wrapping_add(number.wrapping_mul(40_503));
        let [a, b, c, _] = (mixed ^ (mixed >> 15)).to_le_bytes();
        match (x, y) {
            (0, 0) => {
                let [low, middle, high, _] = number.to_le_bytes();
                Rgb([low, middle, high])
            }
            _ => Rgb([a, b, c]),
        }
    })
}

/// The number of a picture, checked pixel for pixel.
fn number(found: &RgbImage) -> anyhow::Result<u32> {
    let Rgb([low, middle, high]) = *found.get_pixel(0, 0);
    let number = u32::from_le_bytes([low, middle, high, 0]);
    anyhow::ensure!(*found == picture(number), "not the picture of {number}");
    Ok(number)
}

/// The numbers of the background's captures, read from disk in the order of recording.
///
/// # Errors
/// A picture that can't be read or is none of ours.
pub fn captures(folder: &ScanFolder) -> anyhow::Result<Vec<u32>> {
    let captures = folder
        .manifest()
        .captures_of(Stage::Background, Shows::Prmvs);
    captures
        .map(|entry| number(&folder.picture(entry)?))
        .collect()
}

/// The generation of the object stage, 0 before it is recorded; the pictures of one stage have the same one.
///
/// # Errors
/// A picture that can't be read or is none of ours, or a stage that is a mixture.
pub fn generation(folder: &ScanFolder) -> anyhow::Result<u32> {
    let mut found = None;
    let entries = folder.manifest().captures.iter();
    for entry in entries.filter(|entry| entry.stage == Stage::Object) {
        let this = number(&folder.picture(entry)?)?;
        anyhow::ensure!(
            *found.get_or_insert(this) == this,
            "a stage of two recordings"
        );
    }
    Ok(found.unwrap_or(0))
}
