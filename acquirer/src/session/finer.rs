//! Records finer grids of one stage, after the base grid.

use shared::{
    pattern::{GridSettings, PatternError},
    protocol::View,
    stage::Stage,
};

use super::{Cancel, RecordSettings, Rig, SessionError, Shot};
use crate::{
    pipeline::{Projected, densify::finer_pattern},
    scan::{ScanError, ScanFolder, Shows},
};

/// The finer grids that the settings ask for, coarse before fine. Counts that the base grid has already are left out.
///
/// # Errors
/// A line count other than 15, 31, 63, 127 or 255.
pub(super) fn finer_patterns(
    base: &Projected,
    settings: &RecordSettings,
) -> Result<Vec<GridSettings>, PatternError> {
    let mut counts = settings.densify.clone();
    counts.sort_unstable();
    counts.dedup();
    let patterns = counts
        .into_iter()
        .map(|lines| finer_pattern(&base.pattern, lines, base.raster));
    let mut patterns: Vec<GridSettings> = patterns.collect::<Result<_, _>>()?;
    patterns.retain(|pattern| *pattern != base.pattern);
    Ok(patterns)
}

/// Those of some finer grids of which a stage has not all captures that the settings ask for.
///
/// # Errors
/// A folder whose finer grids can't be told.
pub(super) fn lacking(
    folder: &ScanFolder,
    patterns: &[GridSettings],
    (stage, settings): (Stage, &RecordSettings),
) -> Result<Vec<GridSettings>, ScanError> {
    let mut lacking = Vec::new();
    for pattern in patterns {
        if !folder.has_finer(pattern, stage, settings.repeats(Shows::Prmvs))? {
            lacking.push(pattern.clone());
        }
    }
    Ok(lacking)
}

/// Records coded and unary pictures of finer grids into the folder, in place of what it holds of them in that stage.
/// `done` is told how many pictures are finished.
///
/// # Errors
/// As [`Rig::shoot_all`], and what the folder says; captures already written stay.
pub(super) fn record_finer(
    (rig, folder): (&mut Rig, &mut ScanFolder),
    patterns: &[GridSettings],
    (stage, settings): (Stage, &RecordSettings),
    cancel: &Cancel,
    done: &mut dyn FnMut(usize),
) -> Result<(), SessionError> {
    for (k, pattern) in patterns.iter().enumerate() {
        let grids = [
            (Shows::Prmvs, pattern.coded.clone()),
            (Shows::Unary, pattern.unary_grid()),
        ];
        let shots = grids.map(|(shows, grid)| Shot {
            view: View::Grid(grid),
            shows,
            count: settings.repeats(shows),
        });
        let before = shots.len() * k;
        let frames = rig.shoot_all(&shots, stage, cancel, &mut |shown| done(before + shown))?;
        // not before there is something to take their place
        folder.forget_finer_captures(pattern, stage)?;
        for (shot, frames) in shots.iter().zip(frames) {
            for frame in frames {
                folder.add_finer_capture(pattern, stage, shot.shows, &frame.picture)?;
            }
        }
    }
    Ok(())
}
