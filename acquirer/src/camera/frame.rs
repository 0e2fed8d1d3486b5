//! A frame and the words that describe its source: pixel format, rate, losses.

use std::fmt;
use std::time::Duration;

use image::RgbImage;
use serde::{Serialize, Serializer};

/// One picture of the scene.
#[derive(Clone, Debug)]
pub struct Frame {
    /// sRGB bytes as the camera gives them, not linearised.
    pub picture: RgbImage,
    /// Counts what the camera made since it was opened, from 0; a gap is a loss.
    pub number: u64,
    /// The driver's stamp on the monotonic clock: the end of exposure, or earlier within it, never
    /// before its begin.
    pub captured_at: Duration,
    /// Frames that the camera made between the previous one given and this one, and that nobody
    /// saw.
    pub dropped: u64,
}

/// Frames that the camera made and nobody saw, counted since the camera was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Losses {
    /// Gaps in the driver's numbers: the bus or the driver lost them.
    pub by_driver: u64,
    /// Arrived with an error mark, too short, or as broken JPEG.
    pub damaged: u64,
    /// A newer frame came before anybody asked.
    pub overtaken: u64,
}

/// How the bytes of a frame are laid out when they leave the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PixelFormat {
    /// Packed 4:2:2, 2 bytes a pixel.
    Yuyv,
    /// One plane of luma, one of interleaved chroma at half size, 1.5 bytes a pixel.
    Nv12,
    /// Red, green, blue, 3 bytes a pixel.
    Rgb,
    /// Blue, green, red, 3 bytes a pixel.
    Bgr,
    /// A JPEG file per frame.
    Mjpeg,
    /// Luma alone, 1 byte a pixel; such a camera cannot tell the grid's colours apart.
    Grey,
}

impl PixelFormat {
    /// Every format that can be decoded, best first: uncompressed colour, then JPEG, then grey.
    pub const ALL: [Self; 6] = [
        Self::Yuyv,
        Self::Nv12,
        Self::Rgb,
        Self::Bgr,
        Self::Mjpeg,
        Self::Grey,
    ];

    /// V4L2's four-character code.
    #[must_use]
    pub const fn fourcc(self) -> &'static str {
        match self {
            Self::Yuyv => "YUYV",
            Self::Nv12 => "NV12",
            Self::Rgb => "RGB3",
            Self::Bgr => "BGR3",
            Self::Mjpeg => "MJPG",
            Self::Grey => "GREY",
        }
    }

    /// The format of a four-character code, or nothing when it cannot be decoded.
    #[must_use]
    pub fn from_fourcc(code: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.fourcc() == code)
    }
}

impl fmt::Display for PixelFormat {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.fourcc())
    }
}

/// Frames per second as an exact fraction, since 30000/1001 is not 30.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    numerator: u32,
    denominator: u32,
}

impl Rate {
    /// `numerator / denominator` frames per second; nothing when either is zero.
    #[must_use]
    pub const fn new(numerator: u32, denominator: u32) -> Option<Self> {
        if numerator == 0 || denominator == 0 {
            None
        } else {
            Some(Self {
                numerator,
                denominator,
            })
        }
    }

    /// A whole number of frames per second; 0 counts as 1.
    #[must_use]
    pub const fn per_second(frames: u32) -> Self {
        Self {
            numerator: if frames == 0 { 1 } else { frames },
            denominator: 1,
        }
    }

    /// The rate of this many frames per second to a thousandth, at least one in a thousand seconds.
    #[must_use]
    pub fn near(hz: f64) -> Self {
        let milli_hz = (hz * 1000.0).round().clamp(1.0, f64::from(u32::MAX)) as u32;
        if milli_hz.is_multiple_of(1000) {
            Self::per_second(milli_hz / 1000)
        } else {
            Self {
                numerator: milli_hz,
                denominator: 1000,
            }
        }
    }

    /// Frames per second.
    #[must_use]
    pub fn hz(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    /// Time from one frame to the next.
    #[must_use]
    pub fn interval(self) -> Duration {
        Duration::from_secs_f64(f64::from(self.denominator) / f64::from(self.numerator))
    }

    /// Numerator and denominator of the frames per second.
    #[must_use]
    pub const fn fraction(self) -> (u32, u32) {
        (self.numerator, self.denominator)
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.denominator == 1 {
            write!(out, "{}", self.numerator)
        } else {
            write!(out, "{}/{}", self.numerator, self.denominator)
        }
    }
}

impl Serialize for Rate {
    /// As text, `30` or `30000/1001`, so that nothing is rounded.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// What a source delivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CaptureFormat {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Frames per second as set; a camera in poor light may give fewer.
    pub rate: Rate,
    /// Layout of the bytes before they were decoded.
    pub pixels: PixelFormat,
}

impl fmt::Display for CaptureFormat {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{}x{} {} at {} frames per second",
            self.width, self.height, self.pixels, self.rate
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fractional_rate_is_kept_exactly() {
        let ntsc = Rate::new(30_000, 1001).unwrap();
        assert_eq!(ntsc.to_string(), "30000/1001");
        assert_eq!(serde_json::to_string(&ntsc).unwrap(), "\"30000/1001\"");
        assert_eq!(ntsc.interval().as_micros(), 33_366);
        assert_eq!(Rate::per_second(25).to_string(), "25");
        assert_eq!(Rate::new(0, 1), None);
        assert_eq!(Rate::new(1, 0), None);
    }

    #[test]
    fn a_rate_near_a_number_is_whole_where_it_can_be() {
        assert_eq!(Rate::near(1.0 / (1.0 / 30.0)).to_string(), "30");
        assert_eq!(Rate::near(12.5).to_string(), "12500/1000");
        assert_eq!(Rate::near(0.0).to_string(), "1/1000");
    }

    #[test]
    fn every_format_is_found_by_its_code() {
        for format in PixelFormat::ALL {
            assert_eq!(PixelFormat::from_fourcc(format.fourcc()), Some(format));
        }
        assert_eq!(PixelFormat::from_fourcc("H264"), None);
    }
}
