//! From the bytes a camera sends to an RGB picture.
//!
//! Takes one buffer and its [`Layout`], gives sRGB bytes of exactly the layout's size, or the
//! [`Damage`]. YUV is converted by ITU-R BT.601 (2011, section 2.5), which the USB Video Class
//! names as its default (UVC 1.5, section 3.9.2.6), in limited range (16 to 235) unless the driver
//! says full; chroma is repeated, not interpolated. It fails quietly for a camera that sends BT.709
//! or full range without saying so: colours then shift by a few per cent.

use std::num::NonZeroUsize;

use image::RgbImage;
use thiserror::Error;

use super::PixelFormat;
use super::jpeg;

/// How a buffer is to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Format of the pixels.
    pub(super) format: PixelFormat,
    /// Width in pixels.
    pub(super) width: u32,
    /// Height in pixels.
    pub(super) height: u32,
    /// Bytes from one row to the next, as the driver says; 0 for rows without padding.
    pub(super) stride: usize,
    /// Whether luma spans 0 to 255 instead of 16 to 235.
    pub(super) full_range: bool,
}

/// Why a buffer holds no picture.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(super) enum Damage {
    /// Fewer bytes than the picture needs.
    #[error("{got} bytes where the picture needs {needed}")]
    TooShort {
        /// Bytes in the buffer.
        got: usize,
        /// Bytes of a whole picture.
        needed: usize,
    },
    /// The driver says so.
    #[error("{0}")]
    Marked(String),
    /// Not a whole JPEG file of the agreed size.
    #[error("broken JPEG: {0}")]
    Jpeg(String),
}

impl Layout {
    /// Bytes from one row to the next: the driver's figure where it is possible.
    fn row_bytes(&self) -> NonZeroUsize {
        let pixel_bytes = match self.format {
            PixelFormat::Yuyv => 2,
            PixelFormat::Rgb | PixelFormat::Bgr => 3,
            PixelFormat::Nv12 | PixelFormat::Grey | PixelFormat::Mjpeg => 1,
        };
        let least = self.width as usize * pixel_bytes;
        NonZeroUsize::new(self.stride.max(least)).unwrap_or(NonZeroUsize::MIN)
    }

    /// Bytes of a whole picture; nothing for JPEG, whose files differ in length.
    fn picture_bytes(&self) -> Option<usize> {
        let rows = self.height as usize;
        match self.format {
            PixelFormat::Mjpeg => None,
            PixelFormat::Nv12 => Some(self.row_bytes().get() * (rows + rows.div_ceil(2))),
            _ => Some(self.row_bytes().get() * rows),
        }
    }

    /// The part of a buffer that belongs to this picture: drivers hand out whole pages, with the
    /// previous frame's tail.
    pub(super) fn trim<'a>(&self, bytes: &'a [u8]) -> Result<&'a [u8], Damage> {
        match self.picture_bytes() {
            None => jpeg::whole_file(bytes, self.width, self.height),
            Some(needed) => bytes.get(..needed).ok_or(Damage::TooShort {
                got: bytes.len(),
                needed,
            }),
        }
    }

    /// The picture in a buffer.
    pub(super) fn decode(&self, bytes: &[u8]) -> Result<RgbImage, Damage> {
        let bytes = self.trim(bytes)?;
        let (width, height) = (self.width as usize, self.height as usize);
        let mut rgb = vec![0; width * height * 3];
        let lines = bytes.chunks_exact(self.row_bytes().get());
        let rows = rgb.chunks_exact_mut((width * 3).max(1)).zip(lines);
        match self.format {
            PixelFormat::Mjpeg => return jpeg::decode(bytes, self.width, self.height),
            PixelFormat::Rgb => {
                rows.for_each(|(row, line)| row.copy_from_slice(&line[..width * 3]));
            }
            PixelFormat::Bgr => rows.for_each(|(row, line)| swap_red_and_blue(row, line)),
            PixelFormat::Grey => rows.for_each(|(row, line)| repeat_grey(row, line)),
            PixelFormat::Yuyv => rows.for_each(|(row, line)| self.yuyv_row(row, line)),
            PixelFormat::Nv12 => {
                let (luma, chroma) = bytes.split_at(self.row_bytes().get() * height);
                let chroma: Vec<_> = chroma.chunks_exact(self.row_bytes().get()).collect();
                let luma = luma.chunks_exact(self.row_bytes().get());
                for (index, (row, line)) in rgb
                    .chunks_exact_mut((width * 3).max(1))
                    .zip(luma)
                    .enumerate()
                {
                    self.nv12_row(row, line, chroma[index / 2]);
                }
            }
        }
        // The vector was made for exactly this size.
        RgbImage::from_raw(self.width, self.height, rgb).ok_or(Damage::TooShort {
            got: bytes.len(),
            needed: width * height * 3,
        })
    }

    fn yuyv_row(&self, row: &mut [u8], line: &[u8]) {
        for (pair, bytes) in row.chunks_mut(6).zip(line.chunks_exact(4)) {
            let [luma_left, u, luma_right, v] = [bytes[0], bytes[1], bytes[2], bytes[3]];
            for (pixel, luma) in pair.chunks_exact_mut(3).zip([luma_left, luma_right]) {
                pixel.copy_from_slice(&rgb_from_yuv(luma, u, v, self.full_range));
            }
        }
    }

    fn nv12_row(&self, row: &mut [u8], luma: &[u8], chroma: &[u8]) {
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let pair = x / 2 * 2;
            // An odd width leaves the last pixel with half a pair: neutral chroma.
            let (u, v) = (
                chroma.get(pair).unwrap_or(&128),
                chroma.get(pair + 1).unwrap_or(&128),
            );
            pixel.copy_from_slice(&rgb_from_yuv(luma[x], *u, *v, self.full_range));
        }
    }
}

fn swap_red_and_blue(row: &mut [u8], line: &[u8]) {
    for (pixel, bytes) in row.chunks_exact_mut(3).zip(line.chunks_exact(3)) {
        pixel.copy_from_slice(&[bytes[2], bytes[1], bytes[0]]);
    }
}

fn repeat_grey(row: &mut [u8], line: &[u8]) {
    for (pixel, luma) in row.chunks_exact_mut(3).zip(line) {
        pixel.fill(*luma);
    }
}

/// BT.601 in 8-bit fixed point, rounded; the error is at most one step of 255.
fn rgb_from_yuv(luma: u8, u: u8, v: u8, full_range: bool) -> [u8; 3] {
    let (luma, u, v) = (i32::from(luma), i32::from(u) - 128, i32::from(v) - 128);
    let (scaled, red_v, green_u, green_v, blue_u) = if full_range {
        (256 * luma, 359, 88, 183, 454)
    } else {
        (298 * (luma - 16), 409, 100, 208, 516)
    };
    [red_v * v, -green_u * u - green_v * v, blue_u * u]
        .map(|chroma| u8::try_from(((scaled + chroma + 128) >> 8).clamp(0, 255)).unwrap_or(u8::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn layout(format: PixelFormat, width: u32, height: u32) -> Layout {
        Layout {
            format,
            width,
            height,
            stride: 0,
            full_range: false,
        }
    }

    fn pixels(picture: &RgbImage) -> Vec<[u8; 3]> {
        picture.pixels().map(|pixel| pixel.0).collect()
    }

    #[test]
    fn limited_range_black_and_white_span_the_whole_byte() {
        let picture = layout(PixelFormat::Yuyv, 2, 1)
            .decode(&[16, 128, 235, 128])
            .unwrap();
        assert_eq!(pixels(&picture), [[0, 0, 0], [255, 255, 255]]);
        let full = Layout {
            full_range: true,
            ..layout(PixelFormat::Yuyv, 2, 1)
        };
        assert_eq!(
            pixels(&full.decode(&[16, 128, 235, 128]).unwrap()),
            [[16; 3], [235; 3]]
        );
    }

    #[test]
    fn the_primaries_of_bt601_come_back() {
        // 75 % bars would hide clipping; these are the 100 % bars of BT.601, luma then U then V.
        for (yuv, rgb) in [
            ([81, 90, 240], [255, 0, 0]),
            ([145, 54, 34], [0, 255, 0]),
            ([41, 240, 110], [0, 0, 255]),
        ] {
            let got = rgb_from_yuv(yuv[0], yuv[1], yuv[2], false);
            assert!(
                got.iter().zip(rgb).all(|(a, b)| a.abs_diff(b) <= 2),
                "{yuv:?} gave {got:?}"
            );
        }
    }

    #[test]
    fn nv12_shares_one_chroma_pair_among_four_pixels() {
        let bytes = [
            81, 81, 16, 16, 81, 81, 16, 16, /* chroma */ 90, 240, 128, 128,
        ];
        let picture = layout(PixelFormat::Nv12, 4, 2).decode(&bytes).unwrap();
        let red = picture.get_pixel(0, 0).0;
        assert!(red[0] > 250 && red[1] < 5 && red[2] < 5);
        assert_eq!(picture.get_pixel(1, 1).0, red);
        assert_eq!(picture.get_pixel(3, 1).0, [0, 0, 0]);
    }

    #[test]
    fn padded_rows_and_a_stale_tail_are_left_out() {
        let padded = Layout {
            stride: 8,
            ..layout(PixelFormat::Bgr, 2, 2)
        };
        let bytes = [
            3, 2, 1, 6, 5, 4, 99, 99, 9, 8, 7, 12, 11, 10, 99, 99, 77, 77, 77,
        ];
        let picture = padded.decode(&bytes).unwrap();
        assert_eq!(picture.into_raw(), (1..=12).collect::<Vec<u8>>());
    }

    #[test]
    fn a_short_buffer_is_damage() {
        let damage = layout(PixelFormat::Yuyv, 640, 480)
            .decode(&[0; 1000])
            .unwrap_err();
        assert_eq!(
            damage,
            Damage::TooShort {
                got: 1000,
                needed: 614_400
            }
        );
    }

    proptest! {
        #[test]
        fn no_bytes_and_no_size_can_panic(
            format in proptest::sample::select(PixelFormat::ALL.to_vec()),
            width in 0_u32..9, height in 0_u32..9, stride in 0_usize..40,
            bytes in proptest::collection::vec(any::<u8>(), 0..600),
        ) {
            let layout = Layout { format, width, height, stride, full_range: false };
            if let Ok(picture) = layout.decode(&bytes) {
                prop_assert_eq!(picture.dimensions(), (width, height));
            }
        }
    }
}
