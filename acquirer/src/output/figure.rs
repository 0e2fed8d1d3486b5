//! A picture with a drawing over it, ready to be saved as PNG or put into the report.

use image::{ImageResult, Rgb as Pixel, RgbImage, imageops};

use super::{
    data_uri::{Encoding, data_uri},
    drawing::{Drawing, Ink},
};

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
        let below = enlarged(&self.picture, enlarge);
        imageops::replace(&mut paper, &below, 0, 0);
        self.drawing
            .paint(&mut paper, self.px_per_unit * f64::from(enlarge));
        paper
    }

    /// Drawing over picture as an SVG element with everything inside.
    ///
    /// # Errors
    /// A picture that can't be encoded.
    pub(super) fn svg(&self, encoding: Encoding) -> ImageResult<String> {
        let size = [self.picture.width(), self.picture.height()];
        let [width, height] = size.map(|px| f64::from(px) / self.px_per_unit);
        let below = format!(
            "<image width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" href=\"{}\"/>",
            data_uri(&self.picture, encoding)?
        );
        Ok(self.drawing.svg("paper", &below))
    }
}

/// The picture enlarged by a whole factor, straight between the middles of its pixels.
fn enlarged(picture: &RgbImage, factor: u32) -> RgbImage {
    // the two pixels on either side of a new pixel, and the share of the second in parts of 2 x factor
    let parts = 2 * factor;
    let taps = |length: u32| -> Vec<(u32, u32, u32)> {
        (0..length * factor)
            .map(|k| {
                let place = (2 * k + 1).saturating_sub(factor);
                let low = (place / parts).min(length - 1);
                (low, (low + 1).min(length - 1), place % parts)
            })
            .collect()
    };
    let (columns, rows) = (taps(picture.width()), taps(picture.height()));
    RgbImage::from_fn(
        picture.width() * factor,
        picture.height() * factor,
        |x, y| {
            let (left, right, u) = columns[x as usize];
            let (upper, lower, v) = rows[y as usize];
            let corners = [(left, upper), (right, upper), (left, lower), (right, lower)];
            let [a, b, c, d] = corners.map(|(x, y)| picture.get_pixel(x, y).0.map(u32::from));
            Pixel([0, 1, 2].map(|k| {
                let above = a[k] * (parts - u) + b[k] * u;
                let below = c[k] * (parts - u) + d[k] * u;
                ((above * (parts - v) + below * v + parts * parts / 2) / (parts * parts)) as u8
            }))
        },
    )
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
