//! A picture with a drawing over it, ready to be saved as PNG or put into the report.

use image::{Rgb as Pixel, RgbImage, imageops};

use super::drawing::{Drawing, Ink};

/// PNG files are enlarged by a whole factor until they are at least this wide, so that letters are readable.
const LEAST_WIDTH_PX: u32 = 1100;
/// Colour of letters on paper.
pub const DARK: Ink = Ink::solid([40, 44, 52]);
/// Colour of what is not measured.
pub const PALE: Ink = Ink::solid([214, 218, 224]);
/// Colour of the paper.
pub const PAPER: Ink = Ink::solid([255, 255, 255]);

/// A picture with a drawing over it.
#[derive(Debug, Clone)]
pub struct Figure {
    /// The picture; it fills the drawing's upper left corner.
    pub picture: RgbImage,
    /// Pixels of the picture for one unit of the drawing.
    pub px_per_unit: f64,
    /// Everything else; paper where the picture does not reach.
    pub drawing: Drawing,
}

impl Figure {
    /// Picture and drawing in one.
    #[must_use]
    pub fn painted(&self) -> RgbImage {
        let [width, height] = self
            .drawing
            .size()
            .map(|v| (v * self.px_per_unit).ceil() as u32);
        let enlarge = LEAST_WIDTH_PX.div_ceil(width.max(1)).clamp(1, 4);
        let mut paper =
            RgbImage::from_pixel(width * enlarge, height * enlarge, Pixel(PAPER.colour.0));
        let below = if enlarge == 1 {
            self.picture.clone()
        } else {
            let (w, h) = self.picture.dimensions();
            imageops::resize(
                &self.picture,
                w * enlarge,
                h * enlarge,
                imageops::FilterType::Triangle,
            )
        };
        imageops::replace(&mut paper, &below, 0, 0);
        self.drawing
            .paint(&mut paper, self.px_per_unit * f64::from(enlarge));
        paper
    }
}

/// A picture in shades of grey, made darker, so that colours drawn over it stand out; `light` from 0 to 1.
#[must_use]
pub fn subdued(picture: &RgbImage, light: f64) -> RgbImage {
    let mut grey = picture.clone();
    for pixel in grey.pixels_mut() {
        let [r, g, b] = pixel.0.map(f64::from);
        let level = (light * (0.299 * r + 0.587 * g + 0.114 * b)).clamp(0.0, 255.0) as u8;
        *pixel = Pixel([level; 3]);
    }
    grey
}
