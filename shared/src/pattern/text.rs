//! Text on the projector's cards: an 8 x 8 bitmap font, each font pixel a square of projector pixels.

use font8x8::{BASIC_FONTS, UnicodeFonts};

use super::Rgb;

/// Width and height of a letter, in font pixels.
pub(super) const GLYPH_PX: u32 = 8;

/// One line of text on a card: where it starts and how many pixels a font pixel has.
pub(super) struct Text<'a> {
    pub(super) text: &'a str,
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) scale: u32,
    pub(super) colour: Rgb,
}

impl Text<'_> {
    /// Whether a letter covers this pixel.
    pub(super) fn covers(&self, x: u32, y: u32) -> bool {
        let (Some(dx), Some(dy)) = (x.checked_sub(self.x), y.checked_sub(self.y)) else {
            return false;
        };
        let (column, row) = (dx / self.scale, dy / self.scale);
        if row >= GLYPH_PX {
            return false;
        }
        let letter = self.text.chars().nth((column / GLYPH_PX) as usize);
        let glyph = letter.and_then(|c| BASIC_FONTS.get(c).or_else(|| BASIC_FONTS.get('?')));
        glyph.is_some_and(|rows| rows[row as usize] >> (column % GLYPH_PX) & 1 == 1)
    }
}

/// Width of a line of text, in projector pixels.
pub(super) fn text_width(text: &str, scale: u32) -> u32 {
    text.chars().count() as u32 * GLYPH_PX * scale
}
