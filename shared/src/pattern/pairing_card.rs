//! The card that shows a pairing code as a QR code, for the camera or a telephone.

use qrcode::{Color, EcLevel, QrCode};

use super::{Raster, RasterSize, Rgb};

/// Width of the white margin that readers need, in modules.
const MARGIN: u32 = 4;

/// Draws the code as large as whole pixels a module allow, dark on white, in the middle; white alone where it does not
/// fit.
pub(super) fn raster(text: &str, size: RasterSize) -> Raster {
    let code = QrCode::with_error_correction_level(text, EcLevel::M).ok();
    let code = code.map(|code| (code.width() as u32, code.to_colors()));
    Raster::from_fn(size, |x, y| {
        let dark = code
            .as_ref()
            .is_some_and(|(width, modules)| is_dark(*width, modules, size, [x, y]));
        if dark { Rgb::BLACK } else { Rgb::WHITE }
    })
}

fn is_dark(width: u32, modules: &[Color], size: RasterSize, [x, y]: [u32; 2]) -> bool {
    let side = width + 2 * MARGIN;
    let scale = size.width.min(size.height) / side;
    if scale == 0 {
        return false;
    }
    let module = |position: u32, length: u32| {
        let start = (length - scale * width) / 2;
        let inside = position.checked_sub(start)? / scale;
        (inside < width).then_some(inside)
    };
    match (module(x, size.width), module(y, size.height)) {
        (Some(column), Some(row)) => modules[(row * width + column) as usize] == Color::Dark,
        _ => false,
    }
}
