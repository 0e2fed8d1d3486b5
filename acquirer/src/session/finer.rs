//! Records finer grids of one stage, after the base grid.

use shared::{
    pattern::{GridSettings, PatternError},
    protocol::View,
    stage::Stage,
};

use super::{Cancel, Progress, RecordSettings, Report, Rig, SessionError};
use crate::{
    pipeline::{Projected, densify::finer_pattern},
    scan::{ScanFolder, Shows},
};

/// The finer grids that the settings ask for, coarse before fine. Counts that the base grid has already are left out.
///
/// # Errors
/// A line count other than 15, 31, 63, 127 or 255.
pub fn finer_patterns(
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

/// Records coded and unary pictures of finer grids into the folder, in place of what it holds of that stage.
pub(super) fn record_finer(
    (rig, folder): (&mut Rig, &mut ScanFolder),
    patterns: &[GridSettings],
    (stage, settings): (Stage, &RecordSettings),
    cancel: &Cancel,
    report: Report,
) -> Result<(), SessionError> {
    folder.retake_finer(stage)?;
    let of = 2 * patterns.len();
    let mut done = 0;
    for pattern in patterns {
        for (shows, grid) in [
            (Shows::Prmvs, pattern.coded.clone()),
            (Shows::Unary, pattern.unary_grid()),
        ] {
            let lines = pattern.coded.rows().max(pattern.coded.columns());
            let what = format!("recording {stage}: {}, {lines} lines", String::from(shows));
            report(Progress { what, done, of });
            done += 1;
            let view = View::Grid(grid);
            let frames = rig.shoot(view, settings.repeats(shows), stage, shows, cancel)?;
            for frame in frames {
                folder.add_finer_capture(pattern, stage, shows, &frame.picture)?;
            }
        }
    }
    Ok(())
}
