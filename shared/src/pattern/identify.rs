//! The card that tells a person which output this is, which way up it stands, and that its pixels are
//! shown one to one: a one-pixel frame on the outermost pixels, a one-pixel checkerboard in the middle of
//! each side (it turns grey or shows bands when something scales the picture), named corners, and a label.

use super::{
    Raster, RasterSize, Rgb,
    text::{GLYPH_PX, Text, text_width},
};

const FIELD: Rgb = Rgb([16, 32, 64]);
const LABEL: Rgb = Rgb::WHITE;
const NOTE: Rgb = Rgb([160, 200, 255]);

/// Draws the card.
pub(super) fn raster(label: &str, size: RasterSize) -> Raster {
    let label: String = label.chars().take(40).collect();
    let size_text = size.to_string();
    let fit = |text: &str, share: f64| {
        let room = f64::from(size.width) * share;
        ((room / f64::from(text_width(text, 1).max(1))) as u32).clamp(1, size.height / 64 + 1)
    };
    let centred = |text: &str, scale: u32| size.width.saturating_sub(text_width(text, scale)) / 2;
    let (big, small) = (fit(&label, 0.8), fit("UPPER LEFT", 0.16));
    let margin = 2 * GLYPH_PX * small;
    let right = |text: &str| size.width.saturating_sub(text_width(text, small) + margin);
    let bottom = size.height.saturating_sub(GLYPH_PX * small + margin);
    let middle = size.height / 2;
    let (top_name, side_name) = ("UPPER LEFT", "UPPER RIGHT");
    let note = "pixels are 1:1 where the edge squares look finely chequered";
    let note_scale = fit(note, 0.7).min(small);
    let texts = [
        Text {
            text: &label,
            x: centred(&label, big),
            y: middle.saturating_sub(GLYPH_PX * big),
            scale: big,
            colour: LABEL,
        },
        Text {
            text: &size_text,
            x: centred(&size_text, small),
            y: middle + GLYPH_PX * small,
            scale: small,
            colour: NOTE,
        },
        Text {
            text: note,
            x: centred(note, note_scale),
            y: middle + 3 * GLYPH_PX * small,
            scale: note_scale,
            colour: NOTE,
        },
        Text {
            text: top_name,
            x: margin,
            y: margin,
            scale: small,
            colour: NOTE,
        },
        Text {
            text: side_name,
            x: right(side_name),
            y: margin,
            scale: small,
            colour: NOTE,
        },
        Text {
            text: "LOWER LEFT",
            x: margin,
            y: bottom,
            scale: small,
            colour: NOTE,
        },
        Text {
            text: "LOWER RIGHT",
            x: right("LOWER RIGHT"),
            y: bottom,
            scale: small,
            colour: NOTE,
        },
    ];
    Raster::from_fn(size, |x, y| {
        if x == 0 || y == 0 || x + 1 == size.width || y + 1 == size.height {
            return Rgb::WHITE;
        }
        if in_checker(x, y, size) {
            return if (x + y) % 2 == 0 {
                Rgb::WHITE
            } else {
                Rgb::BLACK
            };
        }
        texts
            .iter()
            .find(|text| text.covers(x, y))
            .map_or(FIELD, |text| text.colour)
    })
}

/// Whether a pixel lies in one of the four chequered squares, in the middle of each side.
fn in_checker(x: u32, y: u32, size: RasterSize) -> bool {
    let side = (size.width.min(size.height) / 12).max(4);
    let near = |position: u32, length: u32| position.abs_diff(length / 2) < side / 2;
    let at_end = |position: u32, length: u32| {
        (4..4 + side).contains(&position) || (4..4 + side).contains(&(length - 1 - position))
    };
    (near(x, size.width) && at_end(y, size.height))
        || (near(y, size.height) && at_end(x, size.width))
}
