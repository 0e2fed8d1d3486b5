//! Hue, saturation and lightness as the thesis defines them (chapter 4.1.1.3.1).
//!
//! Takes three camera bytes, gives hue in radians, 0 to 2 pi (red 0, green 2 pi/3, blue 4 pi/3), saturation
//! 0 to 1, and lightness R + G + B, 0 to 765. A grey pixel has no hue and a black one no saturation either;
//! close to grey, hue is noise.

use std::f32::consts::{PI, TAU};

/// A colour as a person would describe it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hsl {
    /// Radians, 0 to 2 pi; `None` for grey.
    pub hue: Option<f32>,
    /// Share of the light that is not white, 0 to 1; 0 for black.
    pub saturation: f32,
    /// R + G + B.
    pub lightness: f32,
}

impl Hsl {
    pub(crate) fn new([r, g, b]: [u8; 3]) -> Self {
        let least = f32::from(r.min(g).min(b));
        let [r, g, b] = [r, g, b].map(f32::from);
        let lightness = r + g + b;
        let saturation = if lightness > 0.0 {
            1.0 - 3.0 * least / lightness
        } else {
            0.0
        };
        let chroma = ((r - g) * (r - g) + (r - b) * (g - b)).max(0.0).sqrt();
        let hue = (chroma > 0.0).then(|| {
            let angle = (((r - g) + (r - b)) / (2.0 * chroma))
                .clamp(-1.0, 1.0)
                .acos();
            if b > g { TAU - angle } else { angle }
        });
        Self {
            hue,
            saturation,
            lightness,
        }
    }
}

/// The smaller angle between two hues, 0 to pi.
pub(crate) fn hue_distance(a: f32, b: f32) -> f32 {
    let turn = (a - b).abs();
    // hardly ever: a remainder takes longer than all the rest
    let turn = if turn < TAU { turn } else { turn % TAU };
    if turn > PI { TAU - turn } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_six_pure_colours_stand_sixty_degrees_apart() {
        let pure = [
            [255, 0, 0],
            [255, 255, 0],
            [0, 255, 0],
            [0, 255, 255],
            [0, 0, 255],
            [255, 0, 255],
        ];
        for (k, rgb) in pure.into_iter().enumerate() {
            let hsl = Hsl::new(rgb);
            assert!(
                hue_distance(hsl.hue.unwrap(), k as f32 * PI / 3.0) < 1e-3,
                "{rgb:?}"
            );
            assert_eq!(hsl.saturation, 1.0);
        }
    }

    #[test]
    fn grey_has_no_hue_and_black_no_saturation() {
        assert_eq!(
            Hsl::new([90, 90, 90]),
            Hsl {
                hue: None,
                saturation: 0.0,
                lightness: 270.0
            }
        );
        assert_eq!(Hsl::new([0, 0, 0]).saturation, 0.0);
    }

    #[test]
    fn pink_is_less_saturated_than_red() {
        assert!(Hsl::new([255, 128, 128]).saturation < Hsl::new([255, 0, 0]).saturation);
    }
}
