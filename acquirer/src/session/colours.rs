//! Shows every colour of the palette on the scene and picks the four that are read best.

use shared::{
    pattern::{GridSettings, Palette, Rgb},
    protocol::{ColourScore, MAX_CANDIDATES, MAX_TEXT_CHARS, Selection, View},
    stage::Stage,
};

use super::{Cancel, Progress, Report, Rig, SessionError};
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
/// As [`Rig::shoot`], and what the choice says of the frames.
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
    let stage = Stage::Background;
    let pictures = |rig: &mut Rig, view, count, shows| {
        let frames = rig.shoot(view, count, stage, shows, cancel)?;
        Ok::<_, SessionError>(
            frames
                .into_iter()
                .map(|frame| frame.picture)
                .collect::<Vec<_>>(),
        )
    };
    step("black", 0);
    let black = pictures(rig, View::Black, REFERENCES, Shows::Black)?;
    step("white", 1);
    let white = pictures(rig, View::White, REFERENCES, Shows::White)?;
    let mut shots = Vec::with_capacity(palette.colours().len());
    for (k, entry) in palette.colours().iter().enumerate() {
        step(&entry.name, k + 2);
        let view = View::Grid(projected.pattern.coded.unary(entry.colour));
        let frames = pictures(rig, view, 1, Shows::Solid(entry.colour))?;
        shots.extend(frames.into_iter().map(|picture| (entry.clone(), picture)));
    }
    step("choosing", of);
    let trial = ColourTrial {
        black,
        white,
        shots,
    };
    let selection = choose_colours(&trial, projected, current)?;
    Ok(ColourTrialResult { trial, selection })
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
