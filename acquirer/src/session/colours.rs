//! Shows every colour of the palette on the scene and picks the four that are read best.

use image::RgbImage;
use shared::{
    pattern::{GridSettings, Palette, Rgb},
    protocol::{ColourScore, MAX_CANDIDATES, MAX_TEXT_CHARS, Selection, View},
    stage::Stage,
};

use super::{Cancel, Progress, Report, Rig, SessionError, Shot, tagging::outstanding_order};
use crate::{
    pipeline::{
        Projected,
        colour_choice::{ColourSelection, ColourTrial, choose_colours},
    },
    scan::Shows,
};

/// Frames of black and of white: two give the noise.
const REFERENCES: usize = 2;

/// The frames of a trial and what was chosen from them.
pub struct ColourTrialResult {
    /// What the camera saw of each colour.
    pub trial: ColourTrial,
    /// The choice, with its reasons.
    pub selection: ColourSelection,
}

/// Shows black, white and the unary grid in every colour of the palette, and chooses.
///
/// `current` is the choice in use, kept unless another is clearly better.
///
/// # Errors
/// As [`Rig::shoot_all`], and what the choice says of the frames.
pub fn try_colours(
    rig: &mut Rig,
    palette: &Palette,
    projected: &Projected,
    current: Option<[Rgb; 4]>,
    cancel: &Cancel,
    report: Report,
) -> Result<ColourTrialResult, SessionError> {
    let of = palette.colours().len() + 2;
    let mut step = |what: &str, done| {
        report(Progress {
            what: format!("trying colours: {what}"),
            done,
            of,
        });
    };
    let colours: Vec<Rgb> = palette.colours().iter().map(|c| c.colour).collect();
    let order = outstanding_order(&colours);
    let references = [Shows::Black, Shows::White].map(|shows| (shows, REFERENCES));
    let trial = order.iter().map(|&k| (Shows::Solid(colours[k]), 1));
    let shots: Vec<Shot> = references
        .into_iter()
        .chain(trial)
        .map(|(shows, count)| Shot {
            view: trial_view(shows, projected),
            shows,
            count,
        })
        .collect();
    let frames = rig.shoot_all(&shots, Stage::Background, cancel, &mut |done| {
        step(&format!("{done} recorded"), done);
    })?;
    let mut pictures = frames.into_iter().map(|frames| {
        let pictures = frames.into_iter().map(|frame| frame.picture);
        pictures.collect::<Vec<_>>()
    });
    let black = pictures.next().unwrap_or_default();
    let white = pictures.next().unwrap_or_default();
    let mut taken: Vec<(usize, RgbImage)> = order.into_iter().zip(pictures.flatten()).collect();
    taken.sort_by_key(|(place, _)| *place);
    let shots = taken
        .into_iter()
        .map(|(place, picture)| (palette.colours()[place].clone(), picture))
        .collect();
    step("choosing", of);
    let trial = ColourTrial {
        black,
        white,
        shots,
    };
    let selection = choose_colours(&trial, projected, current)?;
    Ok(ColourTrialResult { trial, selection })
}

/// What is projected in the trial: colours as unary grids.
fn trial_view(shows: Shows, projected: &Projected) -> View {
    match shows {
        Shows::Black => View::Black,
        Shows::White => View::White,
        Shows::Prmvs => View::Coded,
        Shows::Unary => View::Unary,
        Shows::Solid(colour) => View::Grid(projected.pattern.coded.unary(colour)),
    }
}

/// Sends a choice to the projector: its grid takes the colours, and everybody connected sees the scores.
///
/// # Errors
/// What the projector answers.
pub fn apply_selection(
    rig: &mut Rig,
    selection: &ColourSelection,
) -> Result<GridSettings, SessionError> {
    rig.projector
        .set_colours(&selection.best, selection.unary)?;
    rig.projector.report_selection(for_the_wire(selection))?;
    Ok(rig.projector.state()?.grid)
}

fn for_the_wire(selection: &ColourSelection) -> Selection {
    let candidates = selection.colours.iter().map(|entry| ColourScore {
        colour: entry.colour,
        score: entry.recovered_px as f64,
    });
    Selection {
        colours: selection.best.to_vec(),
        unary: selection.unary,
        score: 1.0 - selection.expected_error,
        candidates: candidates.take(MAX_CANDIDATES).collect(),
        reason: selection
            .reasons
            .join(" ")
            .chars()
            .take(MAX_TEXT_CHARS)
            .collect(),
    }
}
