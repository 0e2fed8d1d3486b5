//! A frame without its background: what the projector's light adds to the scene (the thesis's button SUB, chapter
//! 4.1), how many pixels of it there are, and their hues (its button HIST).
//!
//! Takes a frame and the references of its scene, gives a picture that is black where no line is. A pixel counts as
//! recovered when some channel stands out of the light under black by five standard deviations, and by a share of what
//! white adds there. Without white, faint halos beside the lines count too.

use std::f32::consts::TAU;

use image::RgbImage;

use super::{reference::References, response::Response, thesis::hsl::Hsl};

/// Standard deviations by which a line must stand out of the light under black.
const LEAST_SIGMA: f32 = 5.0;
/// Share of what white adds that a line must add: half of it is the edge of a line, halos stay below.
const LEAST_SHARE: f32 = 0.3;
/// Bins of the hues' histogram over the whole circle.
pub const HUE_BINS: usize = 64;
/// Steps of linear light in the table that goes back to bytes.
const LIGHT_STEPS: usize = 4096;

/// A frame without its background.
#[derive(Debug, Clone, Default)]
pub struct Subtraction {
    /// The light that was added, black elsewhere.
    pub picture: RgbImage,
    /// Pixels with added light.
    pub recovered_px: usize,
    /// Their hues, from red round to red, [`HUE_BINS`] bins; pixels without a hue are not in it.
    pub hues: Vec<u32>,
}

/// Takes the light under black out of a frame. `None` without black, or when the sizes differ.
#[must_use]
pub fn subtract_background(
    frame: &RgbImage,
    references: &References,
    response: &Response,
) -> Option<Subtraction> {
    let black = references.black.as_ref()?;
    let size = [frame.width() as usize, frame.height() as usize];
    if size != [black.width(), black.height()] {
        return None;
    }
    let bytes = byte_table(response);
    let mut found = Subtraction {
        picture: RgbImage::new(frame.width(), frame.height()),
        recovered_px: 0,
        hues: vec![0; HUE_BINS],
    };
    let pixels = frame.as_raw().chunks_exact(3);
    let shown = found.picture.chunks_exact_mut(3);
    for (at, (pixel, shown)) in pixels.zip(shown).enumerate() {
        let lights: [[f32; 2]; 3] = std::array::from_fn(|c| {
            let dark = black.channels[c].values()[at].max(0.0);
            [response.linear(pixel[c]), dark]
        });
        let added = lights.map(|[light, dark]| (light - dark).max(0.0));
        let is_line = (0..3).any(|c| {
            let [light, dark] = lights[c];
            let noise = &references.noise;
            let variance = noise.variance(c, dark) + noise.variance(c, light);
            let white = references.white.as_ref();
            let share = white.map_or(0.0, |white| LEAST_SHARE * white[c].values()[at]);
            added[c] > share && added[c] * added[c] > LEAST_SIGMA * LEAST_SIGMA * variance
        });
        if is_line {
            let line = added.map(|light| bytes[(light * (LIGHT_STEPS - 1) as f32) as usize]);
            shown.copy_from_slice(&line);
            found.recovered_px += 1;
            if let Some(hue) = Hsl::new(line).hue {
                found.hues[((hue / TAU * HUE_BINS as f32) as usize).min(HUE_BINS - 1)] += 1;
            }
        }
    }
    Some(found)
}

/// The byte whose light is nearest, for even steps of linear light.
fn byte_table(response: &Response) -> Vec<u8> {
    let mut byte = 0_u8;
    (0..LIGHT_STEPS)
        .map(|step| {
            let light = step as f32 / (LIGHT_STEPS - 1) as f32;
            while byte < 255
                && (response.linear(byte + 1) - light).abs()
                    <= (response.linear(byte) - light).abs()
            {
                byte += 1;
            }
            byte
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use image::Rgb;

    use super::*;
    use crate::{reference::find_references, settings::PipelineSettings};

    fn scene(line: [u8; 3]) -> RgbImage {
        RgbImage::from_fn(64, 48, |x, _| {
            if x % 16 < 4 {
                Rgb(line)
            } else {
                Rgb([60, 70, 50])
            }
        })
    }

    #[test]
    fn only_the_lines_are_left_in_the_colour_that_was_added() {
        let settings = PipelineSettings::default();
        let response = Response::new(&settings.response);
        let dark = RgbImage::from_pixel(64, 48, Rgb([60, 70, 50]));
        let white = RgbImage::from_pixel(64, 48, Rgb([220, 220, 220]));
        let references = find_references(&[dark], &[white], &response, &settings.reference);
        let found = subtract_background(&scene([60, 200, 50]), &references, &response).unwrap();
        assert_eq!(found.recovered_px, 64 * 48 / 4);
        let line = found.picture.get_pixel(1, 1).0;
        assert!(line[1] > 150 && line[0] < 20 && line[2] < 20, "{line:?}");
        assert_eq!(found.picture.get_pixel(8, 8).0, [0; 3]);
        let green = HUE_BINS / 3;
        assert_eq!(found.hues[green - 1..=green + 1].iter().sum::<u32>(), 768);
    }

    #[test]
    fn a_frame_of_another_size_or_without_black_gives_nothing() {
        let settings = PipelineSettings::default();
        let response = Response::new(&settings.response);
        let none = find_references(&[], &[], &response, &settings.reference);
        assert!(subtract_background(&scene([200; 3]), &none, &response).is_none());
        let dark = [RgbImage::new(32, 24)];
        let small = find_references(&dark, &[], &response, &settings.reference);
        assert!(subtract_background(&scene([200; 3]), &small, &response).is_none());
    }
}
