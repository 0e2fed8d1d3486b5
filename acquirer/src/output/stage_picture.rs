//! The pipeline's own pictures between reading and writing: as PNG, a few percent of their size in memory.

use std::path::Path;

use image::{ImageFormat, ImageResult, RgbImage, codecs::png::PngEncoder};
use rayon::prelude::*;
use shared::stage::Stage;

use super::OutputError;
use crate::pipeline::StagePicture;

/// One of the pipeline's pictures, encoded.
#[derive(Debug, Clone)]
pub struct EncodedPicture {
    /// Name of its file, for example `object-02-gain.png`.
    pub file: String,
    /// What is seen in it.
    pub caption: String,
    /// The file's bytes.
    pub png: Vec<u8>,
}

impl EncodedPicture {
    /// Encodes the pictures of one stage, and lets go of each.
    ///
    /// # Errors
    /// A picture that can't be encoded.
    pub fn of_stage(stage: Stage, pictures: Vec<StagePicture>) -> Result<Vec<Self>, OutputError> {
        let numbered = pictures.into_par_iter().enumerate();
        let encoded = numbered.map(|(k, picture)| {
            let file = format!("{stage}-{:02}-{}.png", k + 1, picture.name);
            let mut png = Vec::new();
            let done = picture
                .picture
                .write_with_encoder(PngEncoder::new(&mut png));
            done.map_err(|source| OutputError::picture(Path::new(&file), source))?;
            Ok(Self {
                file,
                caption: picture.caption,
                png,
            })
        });
        encoded.collect()
    }

    /// The picture itself.
    ///
    /// # Errors
    /// Bytes that are no PNG.
    pub(super) fn decode(&self) -> ImageResult<RgbImage> {
        let picture = image::load_from_memory_with_format(&self.png, ImageFormat::Png)?;
        Ok(picture.into_rgb8())
    }
}
