//! A camera's JPEG frames, checked before they are believed.
//!
//! libjpeg gives a picture for half a file (the rest grey), scrambles a file of another size and
//! unwinds on garbage. So the begin and end marks and the size in the frame header are checked
//! first (ITU-T T.81, annex B), and the decoder runs behind a guard. Damage inside the
//! entropy-coded data can still pass as a picture with a smeared block.

use std::panic::{AssertUnwindSafe, catch_unwind};

use image::RgbImage;

use super::pixels::Damage;

const START_OF_IMAGE: [u8; 2] = [0xff, 0xd8];
const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
const START_OF_SCAN: u8 = 0xda;

fn damage(reason: impl Into<String>) -> Damage {
    Damage::Jpeg(reason.into())
}

/// The JPEG file at the start of a buffer, without what stands behind its end mark, if it is whole
/// and of this size.
pub(super) fn whole_file(bytes: &[u8], width: u32, height: u32) -> Result<&[u8], Damage> {
    if !bytes.starts_with(&START_OF_IMAGE) {
        return Err(damage("no start mark"));
    }
    let end = bytes.windows(2).rposition(|pair| pair == END_OF_IMAGE);
    let file = &bytes[..end.ok_or_else(|| damage("no end mark, the frame was cut"))? + 2];
    match frame_size(file) {
        Some(size) if size == (width, height) => Ok(file),
        Some((w, h)) => Err(damage(format!("{w}x{h} where {width}x{height} was agreed"))),
        None => Err(damage("no frame header")),
    }
}

/// Width and height from the frame header (SOF), which stands before the first scan.
fn frame_size(file: &[u8]) -> Option<(u32, u32)> {
    let mut rest = file.get(2..)?;
    loop {
        if *rest.first()? != 0xff {
            return None;
        }
        let marker = *rest.get(1)?;
        if marker == 0xff {
            rest = &rest[1..]; // fill byte
            continue;
        }
        let length = usize::from(u16::from_be_bytes([*rest.get(2)?, *rest.get(3)?]));
        match marker {
            // SOF0 to SOF15, less DHT (c4), JPG (c8) and DAC (cc)
            0xc0..=0xcf if !matches!(marker, 0xc4 | 0xc8 | 0xcc) => {
                let size = rest.get(5..9)?;
                let pair = |at: usize| u32::from(u16::from_be_bytes([size[at], size[at + 1]]));
                return Some((pair(2), pair(0)));
            }
            START_OF_SCAN => return None,
            _ => rest = rest.get(2 + length.max(2)..)?,
        }
    }
}

/// The picture of a checked file.
pub(super) fn decode(file: &[u8], width: u32, height: u32) -> Result<RgbImage, Damage> {
    // libjpeg reports errors by unwinding; the decoder owns nothing of ours that could be left half
    // written.
    let outcome = catch_unwind(AssertUnwindSafe(|| -> std::io::Result<Vec<u8>> {
        let mut picture = mozjpeg::Decompress::new_mem(file)?.rgb()?;
        let rgb: Vec<u8> = picture.read_scanlines()?;
        picture.finish()?;
        Ok(rgb)
    }));
    let rgb = match outcome {
        Ok(Ok(rgb)) => rgb,
        Ok(Err(error)) => return Err(damage(error.to_string())),
        Err(panic) => {
            return Err(damage(
                panic
                    .downcast::<String>()
                    .map_or_else(|_| "decoder gave up".into(), |text| *text),
            ));
        }
    };
    if rgb.len() != width as usize * height as usize * 3 {
        return Err(damage("the decoder gave another size"));
    }
    RgbImage::from_raw(width, height, rgb).ok_or_else(|| damage("the decoder gave another size"))
}

#[cfg(test)]
mod tests {
    use image::codecs::jpeg::JpegEncoder;
    use proptest::prelude::*;

    use super::*;

    /// A flat picture as JPEG.
    fn jpeg_of(width: u32, height: u32, colour: [u8; 3]) -> Vec<u8> {
        let mut file = Vec::new();
        let picture = RgbImage::from_pixel(width, height, image::Rgb(colour));
        JpegEncoder::new_with_quality(&mut file, 95)
            .encode_image(&picture)
            .unwrap();
        file
    }

    #[test]
    fn a_whole_file_is_cut_from_its_stale_tail_and_decoded() {
        let mut buffer = jpeg_of(64, 48, [200, 40, 90]);
        let length = buffer.len();
        buffer.extend([0; 5000]);
        let file = whole_file(&buffer, 64, 48).unwrap();
        assert_eq!(file.len(), length);
        let picture = decode(file, 64, 48).unwrap();
        let pixel = picture.get_pixel(30, 20).0;
        assert!(
            pixel
                .iter()
                .zip([200, 40, 90])
                .all(|(a, b)| a.abs_diff(b) <= 4),
            "{pixel:?}"
        );
    }

    #[test]
    fn a_cut_file_is_refused_although_the_decoder_would_take_it() {
        let file = jpeg_of(64, 48, [200, 40, 90]);
        let cut = &file[..file.len() * 43 / 100];
        assert!(
            matches!(whole_file(cut, 64, 48), Err(Damage::Jpeg(reason)) if reason.contains("cut"))
        );
    }

    #[test]
    fn a_file_of_another_size_is_refused() {
        let file = jpeg_of(32, 48, [1, 2, 3]);
        assert!(
            matches!(whole_file(&file, 64, 48), Err(Damage::Jpeg(reason)) if reason.contains("32x48"))
        );
    }

    #[test]
    fn garbage_behind_good_marks_is_damage_and_no_panic() {
        let mut file = jpeg_of(64, 48, [9, 9, 9]);
        let tables = file
            .windows(2)
            .position(|pair| pair == [0xff, 0xc4])
            .unwrap();
        file[tables + 4..tables + 40].fill(0xee); // the Huffman tables
        assert!(whole_file(&file, 64, 48).is_ok());
        assert!(matches!(decode(&file, 64, 48), Err(Damage::Jpeg(_))));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn no_change_of_bytes_can_panic(changes in proptest::collection::vec((any::<u16>(), any::<u8>()), 1..40)) {
            let mut file = jpeg_of(24, 16, [120, 60, 200]);
            for (place, value) in changes {
                let place = usize::from(place) % file.len();
                file[place] = value;
            }
            if let Ok(file) = whole_file(&file, 24, 16)
                && let Ok(picture) = decode(file, 24, 16)
            {
                prop_assert_eq!(picture.dimensions(), (24, 16));
            }
        }
    }
}
