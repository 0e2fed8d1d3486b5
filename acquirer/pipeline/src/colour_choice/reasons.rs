//! Why these four: the choice put into plain sentences with figures.

use super::{
    ColourScore, ColourSelection, ColourSet, TileScore,
    noise::NoiseLaw,
    sets::{SAFE_DISTANCE, WORTH_CHANGING},
};

/// What the sentences are about, beside the selection itself.
pub(super) struct Grounds<'a> {
    /// The choice with all its scores.
    pub selection: &'a ColourSelection,
    /// The chosen set.
    pub chosen: &'a ColourSet,
    /// The two of the chosen four that are hardest to tell apart, with their error.
    pub hardest: (&'a str, &'a str, f64),
    /// The one of the chosen four whose lines are lost most often, and how often.
    pub dimmest: (&'a str, f64),
    /// The noise law.
    pub noise: NoiseLaw,
    /// Whether there were black frames, and white frames.
    pub references: (bool, bool),
    /// Share of the places where a channel is clipped.
    pub clipped: f64,
}

/// The sentences, the most important first.
pub(super) fn sentences(grounds: &Grounds<'_>) -> Vec<String> {
    let selection = grounds.selection;
    if !selection.measured {
        return vec![
            "No projected light came back, so nothing could be measured on this scene.".to_owned(),
            format!(
                "{} are the best four for a grey wall; check that the projector is on, in focus and in \
                 the camera's view, then try again.",
                list(&grounds.chosen.names)
            ),
        ];
    }
    let mut sentences = vec![choice(grounds), hardest(grounds), dimmest(grounds)];
    sentences.extend(runner_up(grounds));
    sentences.extend(in_use(grounds));
    sentences.push(thesis(grounds));
    sentences.push(unary(selection));
    sentences.extend(worst_tile(selection));
    sentences.extend(doubts(grounds));
    sentences
}

fn choice(grounds: &Grounds<'_>) -> String {
    format!(
        "{} are expected to be read wrongly on {} of the line pixels of this scene.",
        list(&grounds.chosen.names),
        percent(grounds.chosen.expected_error)
    )
}

fn hardest(grounds: &Grounds<'_>) -> String {
    let (a, b, error) = grounds.hardest;
    let distance = grounds.chosen.least_distance;
    let verdict = if distance > SAFE_DISTANCE {
        format!("more than the {SAFE_DISTANCE} that are safe")
    } else {
        format!("less than the {SAFE_DISTANCE} that would be safe")
    };
    format!(
        "The hardest two of them are {a} and {b}: one is taken for the other on {} of the pixels; on nine \
         tenths of the surface the four, and their lines from no line, stand at least {distance:.1} standard deviations \
         apart, {verdict}.",
        percent(error)
    )
}

fn dimmest(grounds: &Grounds<'_>) -> String {
    let (name, lost) = grounds.dimmest;
    format!(
        "In a coded frame without a unary one beside it, {name} is seen least of the four: {} of its lines' pixels are \
         expected lost.",
        percent(lost)
    )
}

fn runner_up(grounds: &Grounds<'_>) -> Option<String> {
    let ranking = &grounds.selection.ranking;
    let other = ranking
        .iter()
        .find(|set| !has_the_colours_of(set, grounds.chosen))?;
    Some(format!(
        "The nearest other set, {}, comes to {}.",
        list(&other.names),
        percent(other.expected_error)
    ))
}

/// Whether two sets hold the same colours, in whatever order.
fn has_the_colours_of(set: &ColourSet, other: &ColourSet) -> bool {
    set.names.iter().all(|name| other.names.contains(name))
}

fn in_use(grounds: &Grounds<'_>) -> Option<String> {
    let current = grounds.selection.current.as_ref()?;
    let error = percent(current.expected_error);
    Some(if grounds.selection.changed {
        format!(
            "The colours in use so far, {}, come to {error}.",
            list(&current.names)
        )
    } else {
        format!(
            "They are the colours in use, and stay unless another set is better by more than {:.0} % and by \
             more than anyone would notice.",
            100.0 * WORTH_CHANGING
        )
    })
}

fn thesis(grounds: &Grounds<'_>) -> String {
    let thesis = &grounds.selection.thesis_choice;
    format!(
        "By the number of recovered grid pixels alone, as in the thesis, one would take {}, which comes to \
         {}.",
        list(&thesis.names),
        percent(thesis.expected_error)
    )
}

fn unary(selection: &ColourSelection) -> String {
    let mut colours: Vec<&ColourScore> = selection.colours.iter().collect();
    colours.sort_by(|a, b| a.line_error_px.total_cmp(&b.line_error_px));
    let chosen = colours.iter().find(|c| c.colour == selection.unary);
    let next = colours.iter().find(|c| c.colour != selection.unary);
    match (chosen, next) {
        (Some(chosen), Some(next)) => format!(
            "The unary grid is {}: its lines should be found to {:.3} px, those of {}, the next best, to \
             {:.3} px.",
            chosen.name, chosen.line_error_px, next.name, next.line_error_px
        ),
        _ => String::new(),
    }
}

fn worst_tile(selection: &ColourSelection) -> Option<String> {
    let error = |tile: &TileScore| tile.expected_error.unwrap_or(0.0);
    let worst = selection
        .tiles
        .iter()
        .max_by(|a, b| error(a).total_cmp(&error(b)))?;
    (error(worst) > 2.0 * selection.expected_error && error(worst) > 1e-3).then(|| {
        format!(
            "It is hardest between x {} and {} px, y {} and {} px, where {} of the pixels are expected \
             wrong.",
            worst.x_px,
            worst.x_px + worst.width_px,
            worst.y_px,
            worst.y_px + worst.height_px,
            percent(error(worst))
        )
    })
}

fn doubts(grounds: &Grounds<'_>) -> Vec<String> {
    let mut doubts = Vec::new();
    let tiles = &grounds.selection.tiles;
    let lit = tiles.iter().map(|tile| tile.lit).sum::<f64>() / tiles.len().max(1) as f64;
    if grounds.references.1 && lit < 0.5 {
        doubts.push(format!(
            "Only {:.0} % of the camera's picture gets projected light; the figures are for that part.",
            100.0 * lit
        ));
    }
    if grounds.clipped > 0.05 {
        doubts.push(format!(
            "{:.0} % of the picture is overexposed in some channel, which was left out there; a shorter exposure \
             would help.",
            100.0 * grounds.clipped
        ));
    }
    match grounds.references {
        (false, _) => doubts.push(
            "There was no black frame; the darkest of the shots stood in for the room's light."
                .to_owned(),
        ),
        (_, false) => doubts.push(
            "There was no white frame; only the places on the grid's lines were judged.".to_owned(),
        ),
        _ => {}
    }
    if !grounds.noise.measured {
        doubts.push(
            "There were no repeated frames to measure the noise on; a common webcam's was assumed."
                .to_owned(),
        );
    }
    doubts
}

fn list(names: &[String; 4]) -> String {
    let [a, b, c, d] = names;
    format!("{a}, {b}, {c} and {d}")
}

/// A probability for people: no more figures than it is worth.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 0.01 {
        "less than 0.01 %".to_owned()
    } else if percent < 1.0 {
        format!("{percent:.2} %")
    } else {
        format!("{percent:.1} %")
    }
}
