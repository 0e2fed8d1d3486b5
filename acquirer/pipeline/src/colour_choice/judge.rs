//! From the thinned frames of a trial to the sets of four in order.

use shared::pattern::Rgb;

use super::{
    histograms::Optics,
    noise::NoiseLaw,
    responses::Responses,
    samples::Places,
    separability::{Predicted, predict},
    sets::{Set, rank},
    thin::ThinTrial,
    visibility::Visibility,
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
    /// `line_px` is the width of the coded grid's lines in camera px.
    pub(super) fn new(trial: &ThinTrial, colours: &[Rgb], line_px: f64) -> Self {
        let places = Places::new(trial);
        let noise = NoiseLaw::new(trial);
        let responses = Responses::new(&places, colours, noise);
        let predict = |places: &Places, responses: &Responses, noise: NoiseLaw| {
            let optics = Optics {
                responses,
                noise,
                visibility: &Visibility::new(colours, line_px, trial.black.len(), noise),
            };
            predict(places, optics)
        };
        let seen = predict(&places, &responses, noise).filter(|_| responses.measured);
        let measured = seen.is_some();
        let predicted = seen.unwrap_or_else(|| {
            let nominal = Responses::nominal(colours);
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
