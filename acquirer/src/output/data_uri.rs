//! Pictures as text inside of a page: `data:image/png;base64,...`.

use std::io::{BufWriter, Write};

use base64::{
    engine::general_purpose::STANDARD,
    write::{EncoderStringWriter, EncoderWriter},
};
use image::{
    ImageResult, RgbImage,
    codecs::{jpeg::JpegEncoder, png::PngEncoder},
};

/// Quality of embedded photographs: without visible blocks round thin coloured lines.
const JPEG_QUALITY: u8 = 90;

/// How a picture is embedded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// For photographs.
    Jpeg,
    /// For pictures with flat colours.
    Png,
}

impl Encoding {
    fn prefix(self) -> &'static str {
        match self {
            Self::Jpeg => "data:image/jpeg;base64,",
            Self::Png => "data:image/png;base64,",
        }
    }

    fn encode(self, picture: &RgbImage, out: &mut impl Write) -> ImageResult<()> {
        // the JPEG encoder writes byte by byte
        let mut out = BufWriter::new(out);
        match self {
            Self::Jpeg => {
                let encoder = JpegEncoder::new_with_quality(&mut out, JPEG_QUALITY);
                picture.write_with_encoder(encoder)?;
            }
            Self::Png => picture.write_with_encoder(PngEncoder::new(&mut out))?,
        }
        Ok(out.flush()?)
    }
}

/// A picture as the address of itself.
///
/// # Errors
/// A picture without pixels, or one that is too large for its encoding.
pub(super) fn data_uri(picture: &RgbImage, encoding: Encoding) -> ImageResult<String> {
    let text = encoding.prefix().to_owned();
    let mut base64 = EncoderStringWriter::from_consumer(text, &STANDARD);
    encoding.encode(picture, &mut base64)?;
    Ok(base64.into_inner())
}

/// Writes a picture as the address of itself, piece by piece.
///
/// # Errors
/// As [`data_uri`], and what the writer says.
pub(super) fn write_data_uri(
    picture: &RgbImage,
    encoding: Encoding,
    out: &mut impl Write,
) -> ImageResult<()> {
    out.write_all(encoding.prefix().as_bytes())?;
    let mut base64 = EncoderWriter::new(out, &STANDARD);
    encoding.encode(picture, &mut base64)?;
    base64.finish()?;
    Ok(())
}
