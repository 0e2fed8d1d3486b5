//! Records one stage of a scan: black, white, the coded grid and the unary grid, each several times, and
//! the solid colours that tell the camera's response once each; then finer grids, if they are asked for.

use serde::{Deserialize, Serialize};
use shared::{protocol::View, stage::Stage};

use super::{
    Cancel, Progress, Report, Rig, SessionError,
    finer::{finer_patterns, record_finer},
};
use crate::{
    pipeline::response::ramp_colours,
    scan::{ScanFolder, Shows},
};

/// How often each picture is taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RecordSettings {
    /// Frames of black and of white, 1 to 100. Two or more give the noise law.
    pub references: usize,
    /// Frames of the coded and of the unary grid, 1 to 100. They are averaged.
    pub grids: usize,
    /// Whether eleven solid colours are recorded too: they tell the camera's response.
    pub ramp: bool,
    /// Numbers of lines of finer grids (31, 63, 127, 255) that are recorded after the base grid and read with its help.
    pub densify: Vec<usize>,
}

impl Default for RecordSettings {
    fn default() -> Self {
        Self {
            references: 3,
            grids: 2,
            ramp: true,
            densify: Vec::new(),
        }
    }
}

impl RecordSettings {
    pub(super) fn repeats(&self, shows: Shows) -> usize {
        let repeats = match shows {
            Shows::Prmvs | Shows::Unary => self.grids,
            Shows::Black | Shows::White => self.references,
            Shows::Solid(_) => 1, // many places of one frame are averaged
        };
        repeats.clamp(1, 100)
    }
}

/// Records one stage into the folder, in place of what it holds of that stage. A capture is on disk before the
/// next is taken.
///
/// # Errors
/// As [`Rig::shoot`], and what the folder says; captures already written stay.
pub fn record_stage(
    rig: &mut Rig,
    folder: &mut ScanFolder,
    stage: Stage,
    settings: &RecordSettings,
    cancel: &Cancel,
    report: Report,
) -> Result<(), SessionError> {
    let finer = match rig.camera.follows_projector() {
        true => finer_patterns(&folder.projected(), settings)?,
        false => Vec::new(),
    };
    folder.retake(stage)?;
    let pictures = pictures(rig, stage, settings);
    let of = pictures.len();
    for (done, shows) in pictures.into_iter().enumerate() {
        let what = format!("recording {stage}: {}", String::from(shows));
        report(Progress { what, done, of });
        let frames = rig.shoot(
            view_of(shows),
            settings.repeats(shows),
            stage,
            shows,
            cancel,
        )?;
        for frame in frames {
            folder.add_capture(stage, shows, &frame.picture)?;
        }
    }
    let what = (stage, settings);
    record_finer((rig, folder), &finer, what, cancel, report)?;
    report(Progress {
        what: format!("recorded {stage}"),
        done: of,
        of,
    });
    Ok(())
}

/// What is recorded of a stage. A recording that is played again and has no ramp goes without.
fn pictures(rig: &Rig, stage: Stage, settings: &RecordSettings) -> Vec<Shows> {
    let mut pictures = Shows::RECORDING.to_vec();
    let ramp: Vec<Shows> = ramp_colours().into_iter().map(Shows::Solid).collect();
    let is_there = ramp.iter().all(|&shows| rig.camera.has(shows, stage));
    if settings.ramp && is_there {
        pictures.extend(ramp);
    }
    pictures
}

fn view_of(shows: Shows) -> View {
    match shows {
        Shows::Black => View::Black,
        Shows::White => View::White,
        Shows::Prmvs => View::Coded,
        Shows::Unary => View::Unary,
        Shows::Solid(colour) => View::Solid { colour },
    }
}
