//! Records one stage of a scan: black, white, the coded grid and the unary grid, each several times, and
//! the solid colours that tell the camera's response once each; then finer grids, if they are asked for.

use serde::{Deserialize, Serialize};
use shared::{protocol::View, stage::Stage};

use super::{
    Cancel, Progress, Report, Rig, SessionError, Shot,
    finer::{finer_patterns, lacking, record_finer},
};
use crate::{
    camera::Frame,
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

    fn shot(&self, shows: Shows) -> Shot {
        Shot {
            view: view_of(shows),
            shows,
            count: self.repeats(shows),
        }
    }
}

/// The settings of a scan that was begun, for going on with it: numbers of lines of finer grids that are not given are
/// those that it was begun with.
#[must_use]
pub fn resumed_settings(folder: &ScanFolder, given: &RecordSettings) -> RecordSettings {
    let mut settings = given.clone();
    if settings.densify.is_empty() {
        settings.densify = folder.noted_lines();
    }
    settings
}

/// Whether a stage lacks captures that the settings ask for.
///
/// # Errors
/// A finer grid that there is not, a folder whose finer grids can't be told.
pub fn is_lacking(
    folder: &ScanFolder,
    stage: Stage,
    settings: &RecordSettings,
) -> Result<bool, SessionError> {
    let finer = finer_patterns(&folder.projected(), settings)?;
    Ok(!folder.is_recorded(stage) || !lacking(folder, &finer, (stage, settings))?.is_empty())
}

/// Records what a stage lacks: all of it, or the finer grids that a recording did not come to.
///
/// # Errors
/// As [`record_stage`].
pub fn complete_stage(
    rig: &mut Rig,
    folder: &mut ScanFolder,
    stage: Stage,
    settings: &RecordSettings,
    cancel: &Cancel,
    report: Report,
) -> Result<(), SessionError> {
    if !folder.is_recorded(stage) {
        return record_stage(rig, folder, stage, settings, cancel, report);
    }
    let finer = finer_patterns(&folder.projected(), settings)?;
    let finer = lacking(folder, &finer, (stage, settings))?;
    let of = 2 * finer.len();
    let what = format!("recording the finer grids of {stage}");
    let mut tell = |done| {
        let what = what.clone();
        report(Progress { what, done, of });
    };
    record_finer((rig, folder), &finer, (stage, settings), cancel, &mut tell)
}

/// Records one stage into the folder, in place of what it holds of that stage, which stays until the new captures are
/// on disk. What became of the latency, and how many frames the camera lost so far, is noted. Solid colours that can't
/// be told apart are left out with a warning. Finer grids come last.
///
/// # Errors
/// As [`Rig::shoot_all`], and what the folder says; the folder holds what it held then, or the new stage without all
/// of its finer grids.
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
    let ramp = ramp(rig, stage, settings);
    let base = Shows::RECORDING.len() + ramp.len();
    let of = base + 2 * finer.len();
    let mut tell = |done| {
        let what = match done == of {
            true => format!("recorded {stage}"),
            false => format!("recording {stage}"),
        };
        report(Progress { what, done, of });
    };
    let mut shoot = |kinds: &[Shows], before: usize| {
        let shots: Vec<Shot> = kinds.iter().map(|&shows| settings.shot(shows)).collect();
        let frames = rig.shoot_all(&shots, stage, cancel, &mut |done| tell(before + done))?;
        let kinds = kinds.iter().copied();
        Ok(kinds.zip(frames).collect::<Vec<(Shows, Vec<Frame>)>>())
    };
    let mut shot = shoot(&Shows::RECORDING, 0)?;
    match shoot(&ramp, Shows::RECORDING.len()) {
        Err(SessionError::NotTold { views }) => tracing::warn!(
            "the frames of some solid colours could not be told apart ({views}): the camera's response is not measured \
             in this stage"
        ),
        other => shot.extend(other?),
    }
    let captures = shot.iter().flat_map(|(shows, frames)| {
        let pictures = frames.iter().map(|frame| &frame.picture);
        pictures.map(|picture| (*shows, picture))
    });
    folder.replace_stage(stage, captures)?;
    drop(shot);
    let what = (stage, settings);
    record_finer((rig, folder), &finer, what, cancel, &mut |done| {
        tell(base + done);
    })?;
    folder.note("frames_lost", &rig.camera.losses())?;
    folder.note("latency", &rig.latency)?;
    tell(of);
    Ok(())
}

/// The solid colours to record. A recording that is played again and has none goes without.
fn ramp(rig: &Rig, stage: Stage, settings: &RecordSettings) -> Vec<Shows> {
    let ramp: Vec<Shows> = ramp_colours().into_iter().map(Shows::Solid).collect();
    let is_there = ramp.iter().all(|&shows| rig.camera.has(shows, stage));
    if settings.ramp && is_there {
        ramp
    } else {
        Vec::new()
    }
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
