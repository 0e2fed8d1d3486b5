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

/// Colours that are shown in one go when the choice so far is asked for.
const AT_ONCE: usize = 4;

/// What a trial of colours needs to know.
#[derive(Debug, Clone, Copy)]
pub struct ColourTrialOrder<'a> {
    /// The colours to try.
    pub palette: &'a Palette,
    /// The grid that is projected.
    pub projected: &'a Projected,
    /// The choice in use, kept unless another is clearly better.
    pub current: Option<[Rgb; 4]>,
}

/// Is told what the colours that were measured so far would give.
pub type OnMeasured<'a> = &'a mut dyn FnMut(ColourSelection);

/// The frames of a trial and what was chosen from them.
pub struct ColourTrialResult {
    /// What the camera saw of each colour.
    pub trial: ColourTrial,
    /// The choice, with its reasons.
    pub selection: ColourSelection,
}

/// Shows black, white and the unary grid in every colour of the palette, and chooses.
///
/// With `measured` the colours are shown a few at a time, and it is told the choice among those so far.
///
/// # Errors
/// As [`Rig::shoot_all`], and what the choice says of the frames.
pub fn try_colours(
    rig: &mut Rig,
    order: &ColourTrialOrder<'_>,
    cancel: &Cancel,
    report: Report,
    mut measured: Option<OnMeasured>,
) -> Result<ColourTrialResult, SessionError> {
    let ColourTrialOrder {
        palette,
        projected,
        current,
    } = *order;
    let of = palette.colours().len() + 2;
    let mut step = |what: &str, done| {
        report(Progress {
            what: format!("trying colours: {what}"),
            done,
            of,
        });
    };
    let colours: Vec<Rgb> = palette.colours().iter().map(|c| c.colour).collect();
    let shot = |(shows, count)| Shot {
        view: trial_view(shows, projected),
        shows,
        count,
    };
    let order = outstanding_order(&colours);
    let at_once = if measured.is_some() {
        AT_ONCE
    } else {
        order.len().max(1)
    };
    let mut trial = ColourTrial::default();
    let mut taken: Vec<(usize, RgbImage)> = Vec::new();
    for (round, places) in order.chunks(at_once).enumerate() {
        let references = [Shows::Black, Shows::White].map(|shows| (shows, REFERENCES));
        let references = references.into_iter().filter(|_| round == 0);
        let tried = places.iter().map(|&k| (Shows::Solid(colours[k]), 1));
        let shots: Vec<Shot> = references.chain(tried).map(shot).collect();
        let before = taken.len() + usize::from(round > 0) * 2;
        let frames = rig.shoot_all(&shots, Stage::Background, cancel, &mut |done| {
            step(&format!("{} recorded", before + done), before + done);
        })?;
        let mut pictures = frames.into_iter().map(|frames| {
            let pictures = frames.into_iter().map(|frame| frame.picture);
            pictures.collect::<Vec<_>>()
        });
        if round == 0 {
            trial.black = pictures.next().unwrap_or_default();
            trial.white = pictures.next().unwrap_or_default();
        }
        taken.extend(places.iter().copied().zip(pictures.flatten()));
        taken.sort_by_key(|(place, _)| *place);
        trial.shots = taken
            .iter()
            .map(|(place, picture)| (palette.colours()[*place].clone(), picture.clone()))
            .collect();
        if let Some(measured) = &mut measured
            && taken.len() < colours.len()
        {
            measured(choose_colours(&trial, projected, None)?);
        }
    }
    step("choosing", of);
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
