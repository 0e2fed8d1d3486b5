//! `pixels`: whether each pixel of the picture is one pixel of the projector.
//!
//! Takes lines one pixel wide and as much area in lines of two pixels, gives the ratio of their light, which is 1
//! whatever the camera resolves, as light adds up. Whatever scales the picture (another resolution, a keystone
//! correction, overscan, a desktop's zoom) mixes bytes, not light: between white and black it makes 127, which is a
//! fifth of the light and not half. At a display gamma of 2.2, one-pixel lines then keep 63 % of their light, two-pixel
//! lines 81 %, and the ratio is 0.77 at any scale but 1. It fails quietly where pixels are doubled and dropped without
//! mixing, or mixed in linear light.

use shared::pattern::Axis;

use super::{Bench, Finding, Light, Measured, PICTURE_FRAMES, Pictures, patterns};
use crate::session::SessionError;

pub(super) fn examine(bench: &mut Bench, pictures: &Pictures) -> Result<Finding, SessionError> {
    let columns = ratio(bench, Axis::Column, pictures)?;
    let rows = ratio(bench, Axis::Row, pictures)?;
    let limit = 100.0 * bench.examination.limits.fine_lines;
    let measured = vec![
        Measured::new("light of 1 px columns against 2 px", 100.0 * columns, "%").at_least(limit),
        Measured::new("light of 1 px rows against 2 px", 100.0 * rows, "%").at_least(limit),
    ];
    let raster = bench.rig.projector.state()?.screen.raster;
    let good = format!(
        "fine lines keep their light ({:.0} and {:.0} %): the picture's {raster} pixels are the projector's",
        100.0 * columns,
        100.0 * rows
    );
    Ok(Finding::judged("pixels", measured, good, || {
        let which = match (columns < limit / 100.0, rows < limit / 100.0) {
            (true, true) => "the picture's width and height are",
            (true, false) => "the picture's width is",
            _ => "the picture's height is",
        };
        let says = format!(
            "{which} scaled on the way: lines of one pixel keep {:.0} % (columns) and {:.0} % (rows) of their light",
            100.0 * columns,
            100.0 * rows
        );
        let fix = format!(
            "set the projector's output to the projector's own resolution (now {raster}), the desktop's scale to 100 %, \
             and switch off keystone correction, digital zoom, overscan and sharpening in the projector's menu; move the \
             projector instead"
        );
        (says, fix)
    }))
}

/// Light of one-pixel lines against that of two-pixel lines.
fn ratio(bench: &mut Bench, axis: Axis, pictures: &Pictures) -> Result<f64, SessionError> {
    let raster = bench.rig.projector.state()?.screen.raster;
    let mut per_area = [0.0; 2];
    for (place, width_px) in [1, 2].into_iter().enumerate() {
        let (view, share) = patterns::fine_lines(axis, raster, width_px)?;
        let name = format!("lines of {width_px} px");
        let lines = bench.light(&name, view, PICTURE_FRAMES)?;
        per_area[place] = light_sum(&lines, pictures) / share;
    }
    Ok(per_area[0] / per_area[1].max(1e-9))
}

fn light_sum(picture: &Light, pictures: &Pictures) -> f64 {
    let Pictures { black, lit, .. } = pictures;
    lit.usable_pixels()
        .map(|k| f64::from(picture.brightness(k) - black.brightness(k)))
        .sum()
}
