//! The camera's response from the solid colours that a scan holds.
//!
//! Takes the folder, gives the measured curve or why there is none. Pictures are read one by one and let go, so that
//! a ramp costs no memory.

use shared::{pattern::Rgb, stage::Stage};

use super::{ScanError, ScanFolder, Shows};
use crate::pipeline::response::{MeasuredResponse, NoMeasurement, SolidCaptures, measure_response};

/// Measures the response with the captures of all stages that have solid colours; `None` when none has.
///
/// # Errors
/// A picture that can't be read.
pub fn measure_scan_response(
    folder: &ScanFolder,
) -> Result<Option<Result<MeasuredResponse, NoMeasurement>>, ScanError> {
    let mut scenes = Vec::new();
    for stage in Stage::BOTH {
        let entries = || {
            let all = folder.manifest().captures.iter();
            all.filter(move |entry| entry.stage == stage)
        };
        if !entries().any(|entry| matches!(entry.shows, Shows::Solid(_))) {
            continue;
        }
        let mut solids = SolidCaptures::default();
        for entry in entries() {
            let colour = match entry.shows {
                Shows::Black => Rgb::BLACK,
                Shows::White => Rgb::WHITE,
                Shows::Solid(colour) => colour,
                Shows::Prmvs | Shows::Unary => continue,
            };
            solids.add(colour, &folder.picture(entry)?);
        }
        scenes.push(solids);
    }
    Ok((!scenes.is_empty()).then(|| measure_response(&scenes)))
}
