//! What a reader can show of the frame that it read last, besides the grid itself: for a live picture.

use image::{Rgb, RgbImage};

use super::Reader;
use crate::{
    grid::DecodedGrid,
    line_light::LineLight,
    plane::Plane,
    reference::lit_mask,
    subtraction::{Subtraction, subtract_background},
};

impl Reader {
    /// The grid that was read last.
    #[must_use]
    pub fn grid(&self) -> &DecodedGrid {
        &self.grid
    }

    /// Where the projector's light reaches: 1 in the light, 0 in shadow. `None` without black and white.
    #[must_use]
    pub fn lit_mask(&self) -> Option<Plane> {
        let light = LineLight::new((&[], &self.response), &self.references)?;
        Some(lit_mask(&light, &self.settings.reference))
    }

    /// A frame without its background. `None` without black, or for a frame of another size.
    #[must_use]
    pub fn without_background(&self, frame: &RgbImage) -> Option<Subtraction> {
        subtract_background(frame, &self.references, &self.response)
    }

    /// The share of white light that arrives in the frame that was read last, as shades of grey, at the size of the
    /// references' pictures. `None` before the first frame, or without references.
    #[must_use]
    pub fn gain_picture(&self) -> Option<RgbImage> {
        let gain = &self.buffers.gain;
        let size = self.size.filter(|_| gain.gain.width() > 0)?;
        Some(RgbImage::from_fn(size.width, size.height, |x, y| {
            let share = gain.at(x as usize, y as usize).clamp(0.0, 1.0);
            Rgb([(255.0 * share) as u8; 3])
        }))
    }
}
