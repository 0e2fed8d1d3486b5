//! Records one stage of a scan: black, white, the coded grid and the unary grid, each several times.

use serde::{Deserialize, Serialize};
use shared::{protocol::View, stage::Stage};

use super::{Cancel, Progress, Report, Rig, SessionError, Shot};
use crate::scan::{ScanFolder, Shows};

/// How often each picture is taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RecordSettings {
    /// Frames of black and of white, 1 to 100. Two or more give the noise law.
    pub references: usize,
    /// Frames of the coded and of the unary grid, 1 to 100. They are averaged.
    pub grids: usize,
}

impl Default for RecordSettings {
    fn default() -> Self {
        Self {
            references: 3,
            grids: 2,
        }
    }
}

impl RecordSettings {
    fn repeats(&self, shows: Shows) -> usize {
        let repeats = match shows {
            Shows::Prmvs | Shows::Unary => self.grids,
            Shows::Black | Shows::White | Shows::Solid(_) => self.references,
        };
        repeats.clamp(1, 100)
    }
}

/// Records one stage into the folder, in place of what it holds of that stage, which stays until the new captures are
/// on disk. What became of the latency, and how many frames the camera lost so far, is noted.
///
/// # Errors
/// As [`Rig::shoot_all`], and what the folder says; the folder holds what it held then.
pub fn record_stage(
    rig: &mut Rig,
    folder: &mut ScanFolder,
    stage: Stage,
    settings: &RecordSettings,
    cancel: &Cancel,
    report: Report,
) -> Result<(), SessionError> {
    let of = Shows::RECORDING.len();
    let shots = Shows::RECORDING.map(|shows| Shot {
        view: view_of(shows),
        shows,
        count: settings.repeats(shows),
    });
    let frames = rig.shoot_all(&shots, stage, cancel, &mut |done| {
        let what = format!("recording {stage}");
        report(Progress { what, done, of });
    })?;
    let captures = shots.iter().zip(&frames).flat_map(|(shot, frames)| {
        let pictures = frames.iter().map(|frame| &frame.picture);
        pictures.map(|picture| (shot.shows, picture))
    });
    folder.replace_stage(stage, captures)?;
    folder.note("frames_lost", &rig.camera.losses())?;
    folder.note("latency", &rig.latency)?;
    report(Progress {
        what: format!("recorded {stage}"),
        done: of,
        of,
    });
    Ok(())
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
