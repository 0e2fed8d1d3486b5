//! Masked thresholds: which foreground pixels carry the projected colour (thesis, chapters 4.2.1 and 4.3).
//!
//! Takes a frame and its foreground mask. [`recover_grid`] gives the pixels of a grid in one colour: the
//! histogram of that colour's light, over the pixels under the mask alone, is cut by Otsu's method.
//! [`find_colours`] gives each pixel of a recovered coded grid the number of its colour: the hue histogram
//! under the mask has a peak for each projected colour, and is cut at the lowest place between neighbouring
//! peaks. Sources: the thesis; N. Otsu, "A threshold selection method from gray-level histograms"
//! (1979). One threshold serves the whole picture, so dark or strongly coloured surfaces fail quietly.

use std::f32::consts::TAU;

use image::RgbImage;
use rayon::prelude::*;
use shared::pattern::Rgb;

use super::{
    background::Background,
    hsl::{Hsl, hue_distance},
};

/// Bins of a hue histogram: two degrees each.
pub(crate) const HUE_BINS: usize = 180;
/// Bins of a light histogram.
const LIGHT_BINS: usize = 256;
/// Share of the mean light above Otsu's cut that a pixel must have. Otsu cuts a histogram with one peak
/// through its middle; this keeps the dim half of a grid on a scene without other foreground.
const LEAST_SHARE_OF_BRIGHT: f32 = 0.4;
/// Least saturation of a colour that has a hue worth the name.
const COLOURED: f32 = 0.15;
/// Farthest a peak may stand from the projected hue, in bins: 30 degrees.
const PEAK_REACH: usize = 15;

/// The pixels of a grid in one colour.
#[derive(Debug, Clone)]
pub(crate) struct RecoveredGrid {
    /// Light of the projected colour above the background, 0 where nothing was recovered; camera bytes.
    pub light: Vec<f32>,
    /// How many pixels were recovered: the thesis's score of a colour.
    pub count: usize,
    /// The threshold found, in camera bytes.
    pub threshold: f32,
}

impl RecoveredGrid {
    /// Whether the grid covers this pixel.
    pub(crate) fn covers(&self, at: usize) -> bool {
        self.light[at] > 0.0
    }
}

/// Whether a projected colour has a hue of its own.
pub(crate) fn has_hue(colour: Rgb) -> bool {
    Hsl::new(colour.0).saturation >= COLOURED
}

/// The pixels under the mask that carry light of the grid's colour.
pub(crate) fn recover_grid(
    frame: &RgbImage,
    background: Option<&Background>,
    mask: &[bool],
    colour: Rgb,
) -> RecoveredGrid {
    let drive = colour.fractions();
    let total: f64 = drive.iter().sum::<f64>().max(1e-6);
    let weights = drive.map(|share| (share / total) as f32);
    let light_at = |(at, bytes): (usize, &[u8])| {
        if !mask[at] {
            return 0.0;
        }
        let dark = background.map_or([0.0; 3], |background| background.mean(at));
        let light: f32 = (0..3)
            .map(|c| weights[c] * (f32::from(bytes[c]) - dark[c]))
            .sum();
        light.max(0.0)
    };
    let mut light: Vec<f32> = frame
        .as_raw()
        .par_chunks_exact(3)
        .enumerate()
        .map(light_at)
        .collect();
    let threshold = light_threshold(&light, background);
    for value in light.iter_mut().filter(|value| **value < threshold) {
        *value = 0.0;
    }
    let count = light.iter().filter(|value| **value > 0.0).count();
    RecoveredGrid {
        light,
        count,
        threshold,
    }
}

fn light_threshold(light: &[f32], background: Option<&Background>) -> f32 {
    let mut histogram = [0_u32; LIGHT_BINS];
    for value in light.iter().filter(|value| **value > 0.0) {
        histogram[(*value as usize).min(LIGHT_BINS - 1)] += 1;
    }
    // light is a weighted mean of three channels, lightness their sum
    let noise = background.map_or(1.0, |background| background.lightness_sigma());
    let (cut, bright) = otsu(&histogram);
    cut.min(LEAST_SHARE_OF_BRIGHT * bright).max(noise).max(1.0)
}

/// The cut that parts a histogram best, and the mean of the part above it, both in bins.
fn otsu(histogram: &[u32]) -> (f32, f32) {
    let weighted = |(bin, count): (usize, &u32)| (bin as f64 + 0.5) * f64::from(*count);
    let total: f64 = histogram.iter().map(|count| f64::from(*count)).sum();
    let sum: f64 = histogram.iter().enumerate().map(weighted).sum();
    let (mut below, mut sum_below) = (0.0, 0.0);
    let (mut best, mut found) = (0.0, (0.0, 0.0));
    for (bin, count) in histogram.iter().enumerate() {
        below += f64::from(*count);
        sum_below += weighted((bin, count));
        let above = total - below;
        if below == 0.0 || above == 0.0 {
            continue;
        }
        let (low, high) = (sum_below / below, (sum - sum_below) / above);
        let between = below * above * (high - low) * (high - low);
        if between > best {
            (best, found) = (between, ((bin + 1) as f32, high as f32));
        }
    }
    found
}

/// The colour of each pixel of a recovered coded grid.
#[derive(Debug, Clone)]
pub(crate) struct ColourMap {
    /// Width of the picture in pixels.
    pub width: usize,
    /// Number of the projected colour, row by row; `None` off the grid and where hue and saturation fit none.
    pub classes: Vec<Option<u8>>,
    /// Whether the grid was recovered at all, row by row.
    pub covered: Vec<bool>,
}

impl ColourMap {
    /// The colour's number at a pixel; `None` outside of the picture as well.
    pub(crate) fn at(&self, x: usize, y: usize) -> Option<u8> {
        if x >= self.width {
            return None;
        }
        self.classes.get(y * self.width + x).copied().flatten()
    }
}

/// Cuts the hue histogram under the grid between its colours' peaks.
pub(crate) fn find_colours(frame: &RgbImage, grid: &RecoveredGrid, colours: &[Rgb]) -> ColourMap {
    let hsl: Vec<Option<Hsl>> = frame
        .as_raw()
        .par_chunks_exact(3)
        .enumerate()
        .map(|(at, bytes)| {
            grid.covers(at)
                .then(|| Hsl::new([bytes[0], bytes[1], bytes[2]]))
        })
        .collect();
    let grey_below = saturation_cut(&hsl, colours);
    let coloured = |hsl: &Hsl| hsl.saturation >= grey_below;
    let histogram = hue_histogram(hsl.iter().flatten().filter(|hsl| coloured(hsl)).copied());
    let of_bin = classes_of_hue(&histogram, colours);
    let grey = colours.iter().position(|colour| !has_hue(*colour));
    let class = |hsl: &Hsl| {
        if !coloured(hsl) {
            return grey.map(|k| k as u8);
        }
        hsl.hue.and_then(|hue| of_bin[hue_bin(hue)])
    };
    let classes = hsl.iter().map(|h| h.as_ref().and_then(class)).collect();
    ColourMap {
        width: frame.width() as usize,
        classes,
        covered: hsl.iter().map(Option::is_some).collect(),
    }
}

/// The bin of a hue.
pub(crate) fn hue_bin(hue: f32) -> usize {
    ((hue / TAU * HUE_BINS as f32) as usize).min(HUE_BINS - 1)
}

/// How often each hue occurs.
pub(crate) fn hue_histogram(pixels: impl Iterator<Item = Hsl>) -> [u32; HUE_BINS] {
    let mut histogram = [0; HUE_BINS];
    for hue in pixels.filter_map(|hsl| hsl.hue) {
        histogram[hue_bin(hue)] += 1;
    }
    histogram
}

/// Below this saturation a pixel counts as white; 0 when no projected colour is.
fn saturation_cut(hsl: &[Option<Hsl>], colours: &[Rgb]) -> f32 {
    if colours.iter().all(|colour| has_hue(*colour)) {
        return 0.0;
    }
    let mut histogram = [0; 100];
    for pixel in hsl.iter().flatten() {
        histogram[((pixel.saturation * 100.0) as usize).min(99)] += 1;
    }
    otsu(&histogram).0 / 100.0
}

/// The colour that each hue bin stands for.
fn classes_of_hue(histogram: &[u32; HUE_BINS], colours: &[Rgb]) -> [Option<u8>; HUE_BINS] {
    let smooth = smoothed(histogram);
    let mut peaks: Vec<(usize, u8)> = Vec::new();
    for (k, colour) in colours.iter().enumerate() {
        if let Some(hue) = Hsl::new(colour.0).hue.filter(|_| has_hue(*colour)) {
            peaks.push((peak_near(&smooth, hue_bin(hue), colours), k as u8));
        }
    }
    peaks.sort_unstable();
    let mut classes = [None; HUE_BINS];
    for (n, &(from, class)) in peaks.iter().enumerate() {
        let (next, next_class) = peaks[(n + 1) % peaks.len()];
        let span = (next + HUE_BINS - from - 1) % HUE_BINS + 1;
        let valley = lowest_between(&smooth, from, span);
        for step in 0..span {
            let owner = if step <= valley { class } else { next_class };
            classes[(from + step) % HUE_BINS] = Some(owner);
        }
    }
    classes
}

/// The histogram averaged over 5 bins, all the way round.
fn smoothed(histogram: &[u32; HUE_BINS]) -> [u32; HUE_BINS] {
    std::array::from_fn(|bin| {
        (0..5)
            .map(|k| histogram[(bin + HUE_BINS + k - 2) % HUE_BINS])
            .sum()
    })
}

/// The highest bin within reach of a projected hue that is nearer to it than to any other colour's.
fn peak_near(smooth: &[u32; HUE_BINS], nominal: usize, colours: &[Rgb]) -> usize {
    let hue_of = |bin: usize| (bin as f32 + 0.5) * TAU / HUE_BINS as f32;
    let own = |bin: usize| {
        let distance = hue_distance(hue_of(bin), hue_of(nominal));
        let others = colours.iter().filter_map(|c| Hsl::new(c.0).hue);
        others
            .into_iter()
            .all(|other| hue_distance(hue_of(bin), other) + 1e-3 >= distance)
    };
    (0..=2 * PEAK_REACH)
        .map(|k| (nominal + HUE_BINS + k - PEAK_REACH) % HUE_BINS)
        .filter(|&bin| own(bin) || bin == nominal)
        .max_by_key(|&bin| (smooth[bin], bin == nominal))
        .unwrap_or(nominal)
}

/// How many steps above `from` the histogram is lowest, within a span; the middle of a flat valley.
fn lowest_between(smooth: &[u32; HUE_BINS], from: usize, span: usize) -> usize {
    let value = |step: usize| smooth[(from + step) % HUE_BINS];
    let lowest = (0..span).map(value).min().unwrap_or(0);
    let flat: Vec<usize> = (0..span).filter(|&step| value(step) == lowest).collect();
    flat.get(flat.len() / 2).copied().unwrap_or(span / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLOURS: [Rgb; 4] = [
        Rgb([255, 0, 0]),
        Rgb([255, 255, 0]),
        Rgb([255, 0, 255]),
        Rgb([0, 255, 0]),
    ];

    fn bars(colours: &[[u8; 3]]) -> RgbImage {
        RgbImage::from_fn(40, 10, |x, _| {
            image::Rgb(colours[x as usize * colours.len() / 40])
        })
    }

    fn classes(colours: &[[u8; 3]], projected: &[Rgb]) -> Vec<Option<u8>> {
        let frame = bars(colours);
        let grid = recover_grid(&frame, None, &[true; 400], Rgb::WHITE);
        find_colours(&frame, &grid, projected).classes
    }

    #[test]
    fn colours_that_the_camera_tints_are_told_apart() {
        let seen = [[180, 40, 30], [170, 140, 40], [160, 40, 130], [60, 150, 40]];
        let found = classes(&seen, &COLOURS);
        assert_eq!(
            [5, 15, 25, 35].map(|x| found[x]),
            [Some(0), Some(1), Some(2), Some(3)]
        );
    }

    #[test]
    fn white_among_the_colours_is_found_by_its_saturation() {
        let projected = [
            Rgb([255, 0, 0]),
            Rgb::WHITE,
            Rgb([0, 255, 0]),
            Rgb([0, 0, 255]),
        ];
        let seen = [[180, 40, 30], [170, 160, 150], [50, 150, 60], [40, 50, 160]];
        let found = classes(&seen, &projected);
        assert_eq!(
            [5, 15, 25, 35].map(|x| found[x]),
            [Some(0), Some(1), Some(2), Some(3)]
        );
    }

    #[test]
    fn a_threshold_under_the_mask_leaves_the_dim_half_of_a_grid_alone() {
        let frame = bars(&[[60, 0, 0], [100, 0, 0]]);
        let grid = recover_grid(&frame, None, &[true; 400], Rgb([255, 0, 0]));
        assert_eq!(grid.count, 400);
        let noise = bars(&[[5, 0, 0], [100, 0, 0]]);
        let grid = recover_grid(&noise, None, &[true; 400], Rgb([255, 0, 0]));
        assert_eq!(grid.count, 200);
    }

    #[test]
    fn a_dark_frame_and_a_black_colour_recover_nothing() {
        let frame = RgbImage::new(40, 10);
        for colour in [Rgb::BLACK, Rgb::WHITE] {
            assert_eq!(recover_grid(&frame, None, &[true; 400], colour).count, 0);
        }
        assert!(classes(&[[0; 3]], &COLOURS).iter().all(Option::is_none));
    }

    #[test]
    fn colours_of_one_hue_do_not_panic() {
        let same = [Rgb([255, 0, 0]); 4];
        let _classes = classes(&[[180, 40, 30], [170, 140, 40]], &same);
        let _classes = classes(&[[180, 40, 30]], &[Rgb([9, 9, 9])]);
    }
}
