//! What was measured, drawn over the camera's picture: labels, shifts, depth, height.
//!
//! # Conventions
//! One unit of a drawing is a camera pixel. Marks and letters are sized for a picture 640 px wide and grow with
//! wider ones (`unit`).

mod depth_map;

mod label_map;

mod shift_map;

pub use depth_map::{height_map, relative_depth_map, surface_depth_map};
pub use label_map::{label_map, reason_colour, reason_words};
pub use shift_map::shift_map;

use image::RgbImage;

use super::{
    colour_map::Scale,
    drawing::{Drawing, Ink},
    figure::PAPER,
};

/// Width of the strip for a colour bar, in units of a picture 640 px wide.
const BAR_STRIP: f64 = 92.0;

/// The size of a mark of one pixel on a picture 640 px wide.
fn unit(picture: &RgbImage) -> f64 {
    f64::from(picture.width()) / 640.0
}

/// A drawing over a picture with a strip of paper on its right that holds a colour bar.
fn with_bar(picture: &RgbImage, scale: &Scale) -> Drawing {
    let unit = unit(picture);
    let (width, height) = (f64::from(picture.width()), f64::from(picture.height()));
    let mut drawing = Drawing::new(width + BAR_STRIP * unit, height);
    drawing.rectangle([width, 0.0], [BAR_STRIP * unit, height], PAPER);
    let frame = [width, 0.12 * height, BAR_STRIP * unit, 0.76 * height];
    scale.draw(&mut drawing, frame, 0.68 * unit);
    drawing
}

/// A dark rim round light letters.
const RIM: Ink = Ink::solid([16, 18, 22]).faded(0.75);
