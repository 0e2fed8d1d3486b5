//! From the frames of a trial to the sets of four in order; its time is measured by the benchmark `colour_choice`.

use shared::pattern::Rgb;

use super::{
    ColourTrial, Shots,
    noise::NoiseLaw,
    responses::Responses,
    samples::Places,
    separability::{Predicted, predict},
    sets::{Set, rank},
};

/// The sets of colours in order, and what the order rests on.
pub(super) struct Judged {
    pub noise: NoiseLaw,
    pub responses: Responses,
    pub predicted: Predicted,
    /// All sets of four, best first; never empty with four colours or more.
    pub ranking: Vec<Set>,
    /// Whether projected light was seen; else all is predicted for a grey wall.
    pub measured: bool,
    /// Share of the places where some channel is clipped.
    pub clipped: f64,
}

impl Judged {
    pub(super) fn new(trial: &ColourTrial, shots: &[Shots<'_>]) -> Self {
        let colours: Vec<Rgb> = shots.iter().map(|shot| shot.entry.colour).collect();
        let places = Places::new(trial, shots);
        let noise = NoiseLaw::new(trial);
        let responses = Responses::new(&places, &colours, noise);
        let seen = predict(&places, &responses, noise).filter(|_| responses.measured);
        let measured = seen.is_some();
        let predicted = seen.unwrap_or_else(|| {
            let nominal = Responses::nominal(&colours);
            let mut predicted =
                predict(&Places::grey_wall(), &nominal, NoiseLaw::COMMON).unwrap_or_default();
            predicted.tiles.fill(None);
            predicted.lit.fill(0.0);
            predicted
        });
        Self {
            noise,
            responses,
            ranking: rank(&predicted.separability),
            predicted,
            measured,
            clipped: places.clipped_share(),
        }
    }
}
