//! What sizes and rates a driver enumerates, and which of its modes to take.
//!
//! Takes V4L2's discrete or stepwise answers, gives plain lists; takes these and the wishes, gives
//! one mode.

use v4l::frameinterval::{FrameInterval, FrameIntervalEnum};
use v4l::framesize::{FrameSize, FrameSizeEnum, Stepwise};

use super::FormatInfo;
use crate::camera::{CameraSettings, CaptureFormat, PixelFormat, Rate};

/// Sizes that a range is represented by, besides its ends.
const USUAL_SIZES: [(u32, u32); 8] = [
    (320, 240),
    (640, 360),
    (640, 480),
    (800, 600),
    (1024, 768),
    (1280, 720),
    (1280, 960),
    (1920, 1080),
];

/// Rates that a range is represented by, besides its ends.
const USUAL_RATES: [u32; 8] = [5, 10, 15, 20, 25, 30, 50, 60];

/// Drivers round the time between frames: 30 per second comes as 10000000/333333 too.
const RATE_ERROR: f64 = 0.001;

/// Sizes as (width, height), largest first.
pub(super) fn sizes(enumerated: Vec<FrameSize>) -> Vec<(u32, u32)> {
    let mut sizes: Vec<_> = enumerated
        .into_iter()
        .flat_map(|size| match size.size {
            FrameSizeEnum::Discrete(size) => vec![(size.width, size.height)],
            FrameSizeEnum::Stepwise(range) => sizes_in(&range),
        })
        .filter(|(width, height)| *width > 0 && *height > 0)
        .collect();
    sizes.sort_unstable_by_key(|&(width, height)| {
        std::cmp::Reverse((u64::from(width) * u64::from(height), width))
    });
    sizes.dedup();
    sizes
}

fn sizes_in(range: &Stepwise) -> Vec<(u32, u32)> {
    let fits = |value: u32, min: u32, max: u32, step: u32| {
        (min..=max).contains(&value) && (value - min).checked_rem(step).unwrap_or(0) == 0
    };
    let usual = USUAL_SIZES.into_iter().filter(|&(width, height)| {
        fits(width, range.min_width, range.max_width, range.step_width)
            && fits(
                height,
                range.min_height,
                range.max_height,
                range.step_height,
            )
    });
    usual
        .chain([
            (range.min_width, range.min_height),
            (range.max_width, range.max_height),
        ])
        .collect()
}

/// Rates, fastest first.
pub(super) fn rates(enumerated: &[FrameInterval]) -> Vec<Rate> {
    let mut rates: Vec<Rate> = enumerated
        .iter()
        .flat_map(|interval| match &interval.interval {
            FrameIntervalEnum::Discrete(period) => {
                vec![Rate::new(period.denominator, period.numerator)]
            }
            FrameIntervalEnum::Stepwise(range) => {
                let slowest = Rate::new(range.max.denominator, range.max.numerator);
                let fastest = Rate::new(range.min.denominator, range.min.numerator);
                let inside = |rate: &Rate| {
                    slowest.is_some_and(|end| end.hz() < rate.hz())
                        && fastest.is_some_and(|end| rate.hz() < end.hz())
                };
                let usual = USUAL_RATES
                    .map(Rate::per_second)
                    .into_iter()
                    .filter(inside)
                    .map(Some);
                usual.chain([slowest, fastest]).collect()
            }
        })
        .flatten()
        .collect();
    rates.sort_by(|a, b| b.hz().total_cmp(&a.hz()));
    rates.dedup();
    rates
}

/// The mode to take: the size nearest to the wish, colour before grey, the highest rate up to the
/// limit, and at an equal rate the format that loses least. Nothing when no format can be decoded.
pub(super) fn choose(formats: &[FormatInfo], wish: &CameraSettings) -> Option<CaptureFormat> {
    candidates(formats, wish).min_by_key(|mode| {
        let distance = mode.width.abs_diff(wish.width) + mode.height.abs_diff(wish.height);
        let rate = whole(mode.rate);
        let (too_fast, slowness) = if mode.rate.hz() <= wish.max_rate * (1.0 + RATE_ERROR) {
            (0, u32::MAX - rate)
        } else {
            (1, rate)
        };
        let order = PixelFormat::ALL
            .iter()
            .position(|format| *format == mode.pixels);
        (
            distance,
            mode.pixels == PixelFormat::Grey,
            too_fast,
            slowness,
            order,
        )
    })
}

fn candidates(
    formats: &[FormatInfo],
    wish: &CameraSettings,
) -> impl Iterator<Item = CaptureFormat> {
    formats
        .iter()
        .filter(|format| wish.pixel_format.is_empty() || wish.pixel_format == format.fourcc)
        .filter_map(|format| Some((PixelFormat::from_fourcc(&format.fourcc)?, format)))
        .flat_map(|(pixels, format)| format.sizes.iter().map(move |size| (pixels, size)))
        .flat_map(|(pixels, size)| {
            // A driver that does not tell its rates gets the wish and answers with what it does.
            let asked = Rate::near(wish.max_rate);
            let rates = if size.rates.is_empty() {
                vec![asked]
            } else {
                size.rates.clone()
            };
            rates.into_iter().map(move |rate| CaptureFormat {
                width: size.width,
                height: size.height,
                rate,
                pixels,
            })
        })
}

/// Frames per second to the nearest whole number: 29.97 counts as 30.
pub(super) fn whole(rate: Rate) -> u32 {
    let (numerator, denominator) = rate.fraction();
    u32::try_from((u64::from(numerator) + u64::from(denominator) / 2) / u64::from(denominator))
        .unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::v4l2::SizeInfo;

    /// Width, height and the rates as fractions.
    type Offer<'a> = (u32, u32, &'a [(u32, u32)]);

    fn offer(fourcc: &str, sizes: &[Offer<'_>]) -> FormatInfo {
        let size = |&(width, height, rates): &Offer<'_>| SizeInfo {
            width,
            height,
            rates: rates
                .iter()
                .map(|&(n, d)| Rate::new(n, d).unwrap())
                .collect(),
        };
        let sizes = sizes.iter().map(size).collect();
        FormatInfo {
            fourcc: fourcc.into(),
            description: String::new(),
            usable: true,
            sizes,
        }
    }

    fn chosen(formats: &[FormatInfo], wish: &CameraSettings) -> String {
        choose(formats, wish).map_or_else(|| "none".into(), |mode| mode.to_string())
    }

    #[test]
    fn at_an_equal_rate_uncompressed_wins_and_otherwise_the_rate() {
        let wish = CameraSettings::default();
        let mjpeg = offer("MJPG", &[(640, 480, &[(30, 1)])]);
        let ntsc = offer("YUYV", &[(640, 480, &[(30_000, 1001), (15, 1)])]);
        assert_eq!(
            chosen(&[mjpeg.clone(), ntsc], &wish),
            "640x480 YUYV at 30000/1001 frames per second"
        );
        let slow = offer("YUYV", &[(640, 480, &[(15, 1)])]);
        assert_eq!(
            chosen(&[mjpeg, slow], &wish),
            "640x480 MJPG at 30 frames per second"
        );
    }

    #[test]
    fn the_nearest_size_and_the_highest_rate_up_to_the_limit_are_taken() {
        let wish = CameraSettings {
            max_rate: 30.0,
            ..CameraSettings::default()
        };
        let formats = [offer(
            "YUYV",
            &[
                (3840, 2160, &[(2, 1)]),
                (640, 360, &[(60, 1), (25, 2), (40, 1)]),
                (320, 180, &[(30, 1)]),
            ],
        )];
        assert_eq!(
            chosen(&formats, &wish),
            "640x360 YUYV at 25/2 frames per second"
        );
        let only_fast = [offer("YUYV", &[(640, 480, &[(90, 1), (60, 1)])])];
        assert_eq!(
            chosen(&only_fast, &wish),
            "640x480 YUYV at 60 frames per second"
        );
    }

    #[test]
    fn a_fractional_limit_takes_that_rate() {
        let wish = CameraSettings {
            max_rate: 12.5,
            ..CameraSettings::default()
        };
        let rates = [(30, 1), (25, 2), (10, 1)];
        let formats = [offer("YUYV", &[(640, 480, &rates)])];
        assert_eq!(
            chosen(&formats, &wish),
            "640x480 YUYV at 25/2 frames per second"
        );
        let rounded = [offer(
            "YUYV",
            &[(640, 480, &[(10_000_000, 333_333), (15, 1)])],
        )];
        assert_eq!(
            chosen(&rounded, &CameraSettings::default()),
            "640x480 YUYV at 10000000/333333 frames per second"
        );
    }

    #[test]
    fn grey_is_taken_only_when_there_is_no_colour() {
        let grey = offer("GREY", &[(640, 480, &[(30, 1)])]);
        let colour = offer("MJPG", &[(640, 480, &[(10, 1)])]);
        let wish = CameraSettings::default();
        assert_eq!(
            chosen(&[grey.clone(), colour], &wish),
            "640x480 MJPG at 10 frames per second"
        );
        assert_eq!(
            chosen(&[grey], &wish),
            "640x480 GREY at 30 frames per second"
        );
        assert_eq!(
            chosen(&[offer("H264", &[(640, 480, &[(30, 1)])])], &wish),
            "none"
        );
    }

    #[test]
    fn a_wished_format_is_the_only_one_looked_at_and_unknown_rates_are_asked_for() {
        let wish = CameraSettings {
            pixel_format: "NV12".into(),
            max_rate: 20.0,
            ..CameraSettings::default()
        };
        let formats = [
            offer("YUYV", &[(640, 480, &[(20, 1)])]),
            offer("NV12", &[(640, 480, &[])]),
        ];
        assert_eq!(
            chosen(&formats, &wish),
            "640x480 NV12 at 20 frames per second"
        );
    }

    #[test]
    fn a_range_of_sizes_gives_its_ends_and_the_usual_ones_inside() {
        let range = Stepwise {
            min_width: 48,
            max_width: 1000,
            step_width: 16,
            min_height: 32,
            max_height: 700,
            step_height: 0,
        };
        assert_eq!(
            sizes_in(&range),
            [
                (320, 240),
                (640, 360),
                (640, 480),
                (800, 600),
                (48, 32),
                (1000, 700)
            ]
        );
    }
}
