//! Which four of sixteen colours this scene lets the camera tell apart, and which single colour draws the
//! best unary grid.
//!
//! Takes frames of the scene under black, white, and the unary grid in each colour of the palette. Gives a
//! [`ColourSelection`]: the choice, the scores behind it and plain reasons. Two scores stand side by side:
//! the thesis's (how many grid pixels of each colour survive, chapter 4.2) and a joint one, the expected share
//! of line pixels whose colour is mistaken or that are not seen at all in a coded frame without a unary one, predicted
//! for every set of four from the measured light, noise and colour response (`separability`). The joint one decides,
//! because four colours that each survive can still be neighbours in hue.
//!
//! It fails quietly when the scene changes between the shots, or when the shots show something other than
//! the grid in the colours they name.

mod thin;

mod samples;

mod noise;

mod responses;

mod distances;

mod visibility;

mod histograms;

mod separability;

mod sets;

mod judge;

mod recovery;

mod reasons;

mod select;

mod cost;

use image::RgbImage;
use serde::{Deserialize, Serialize};
use shared::pattern::{Axis, NamedColour, PALETTE_SIZE, RasterSize, Rgb};

use super::{PipelineError, Projected, check_sizes};
use judge::Judged;
use recovery::recover;
use select::Evidence;
use thin::ThinTrial;

/// Width and height of the scene in tiles, for scores by region.
pub const TILES: (usize, usize) = (4, 3);
/// Bins of [`ColourScore::hue_histogram`] over the whole circle.
pub const HISTOGRAM_BINS: usize = 64;

/// Frames of one scene under different light. Sizes must agree; `black` and `white` may be empty.
#[derive(Debug, Clone, Default)]
pub struct ColourTrial {
    /// The projector showed black.
    pub black: Vec<RgbImage>,
    /// The projector showed white all over.
    pub white: Vec<RgbImage>,
    /// The projector showed the unary grid in this colour. A colour may come several times.
    pub shots: Vec<(NamedColour, RgbImage)>,
}

impl ColourTrial {
    fn named(&self) -> impl Iterator<Item = (String, &RgbImage)> {
        let black = self.black.iter().map(|frame| ("black".to_owned(), frame));
        let white = self.white.iter().map(|frame| ("white".to_owned(), frame));
        let shots = self
            .shots
            .iter()
            .map(|(entry, frame)| (entry.name.clone(), frame));
        black.chain(white).chain(shots)
    }
}

/// The choice, and what it rests on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ColourSelection {
    /// The four grid colours in the order of symbols 0, 1, w, w2.
    pub best: [Rgb; 4],
    /// The colour of the unary grid.
    pub unary: Rgb,
    /// Expected share of line pixels of `best` that are read as another of the four, or, in a coded frame that stands
    /// alone, as no line.
    pub expected_error: f64,
    /// `false` when no projected light was seen: the choice is then the one for a grey wall.
    pub measured: bool,
    /// Whether `best` differs from the colours that were in use.
    pub changed: bool,
    /// Every colour that was tried, in the order of the shots; other tables count in this order.
    pub colours: Vec<ColourScore>,
    /// How well each pair of colours is told apart.
    pub separability: Separability,
    /// The best few sets, best first.
    pub ranking: Vec<ColourSet>,
    /// What the thesis would choose: the four colours with the most recovered pixels.
    pub thesis_choice: ColourSet,
    /// The colours that were in use, when all of them were tried.
    pub current: Option<ColourSet>,
    /// The scene in tiles, row by row from the upper left, [`TILES`] of them.
    pub tiles: Vec<TileScore>,
    /// Why these four and this unary colour, in plain sentences.
    pub reasons: Vec<String>,
}

/// One colour on this scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ColourScore {
    /// Name in the palette.
    pub name: String,
    /// Projector drive values.
    pub colour: Rgb,
    /// The thesis's score: grid pixels left after background removal and masked threshold, estimated from a
    /// lattice of some 4000 pixels.
    pub recovered_px: usize,
    /// `recovered_px` of the pixels that the grid should cover where the projector reaches, 0 to about 1.
    pub share_of_expected: f64,
    /// Hues of the recovered pixels, from red round to red, [`HISTOGRAM_BINS`] bins.
    pub hue_histogram: Vec<u32>,
    /// Camera light per channel under this colour, as a share of that under white.
    pub response: [f64; 3],
    /// Predicted error of a line's middle for a unary grid in this colour, camera px RMS, at most 1.
    pub line_error_px: f64,
}

/// How well colours are told apart, averaged over the scene; rows and columns count as
/// [`ColourSelection::colours`] does.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Separability {
    /// Probability that a pixel of one is nearer to the other, 0 to 0.5; 0 on the diagonal.
    pub error: Vec<Vec<f64>>,
    /// Mahalanobis distance that nine tenths of the surface exceed, in standard deviations.
    pub distance: Vec<Vec<f64>>,
    /// Probability that a line of the colour is not seen in a coded frame that stands alone, 0 to 1.
    pub dark_error: Vec<f64>,
    /// Distance of its lines from no line that nine tenths of the surface exceed: twice the standard deviations above
    /// the line finder's limit; 0 where they stay below it.
    pub dark_distance: Vec<f64>,
}

/// Four colours and how well they do together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ColourSet {
    /// The colours in symbol order.
    pub colours: [Rgb; 4],
    /// Their names.
    pub names: [String; 4],
    /// Expected share of line pixels read wrongly, 0 to about 1.
    pub expected_error: f64,
    /// Least of the six distances between them and the four to no line, for nine tenths of the surface.
    pub least_distance: f64,
}

/// One tile of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TileScore {
    /// Left edge, camera px.
    pub x_px: u32,
    /// Upper edge, camera px.
    pub y_px: u32,
    /// Width, camera px.
    pub width_px: u32,
    /// Height, camera px.
    pub height_px: u32,
    /// Share of the tile that projected light reaches.
    pub lit: f64,
    /// Expected error of the chosen four here; `None` where no light arrives.
    pub expected_error: Option<f64>,
    /// For each colour the probability that its line is seen here; empty where no light arrives.
    pub seen: Vec<f64>,
}

/// The frames of one colour.
struct Shots<'a> {
    entry: &'a NamedColour,
    frames: Vec<&'a RgbImage>,
}

/// Chooses the grid colours and the unary colour for the scene in the frames.
///
/// `current` is the set in use: it stays unless the best one is better by a fifth. Colours after the
/// sixteenth are left out.
///
/// # Errors
/// [`PipelineError::TooFewColours`] with shots of fewer than four colours, and frames without pixels or of
/// different sizes.
pub fn choose_colours(
    trial: &ColourTrial,
    projected: &Projected,
    current: Option<[Rgb; 4]>,
) -> Result<ColourSelection, PipelineError> {
    let shots = shots_by_colour(trial)?;
    check_sizes(trial.named())?;
    let thinned = ThinTrial::new(trial, &shots);
    let colours: Vec<Rgb> = shots.iter().map(|shot| shot.entry.colour).collect();
    let evidence = Evidence {
        trial,
        judged: Judged::new(&thinned, &colours, line_px(&shots, projected)),
        recovered: recover(&thinned, &colours),
        shots,
    };
    Ok(evidence.select(&projected.pattern.coded, projected.raster, current))
}

/// Width of the coded grid's narrower lines in camera px, as if the camera saw the projector's picture and no more.
fn line_px(shots: &[Shots<'_>], projected: &Projected) -> f64 {
    let (width, height) = shots[0].frames[0].dimensions();
    let RasterSize {
        width: across,
        height: down,
    } = projected.raster;
    let across = f64::from(width) / f64::from(across.max(1));
    let down = f64::from(height) / f64::from(down.max(1));
    let grid = &projected.pattern.coded;
    let narrower = Axis::BOTH.map(|axis| grid.width_px(axis)).into_iter().min();
    f64::from(narrower.unwrap_or(1)) * across.min(down)
}

fn shots_by_colour(trial: &ColourTrial) -> Result<Vec<Shots<'_>>, PipelineError> {
    let mut shots: Vec<Shots<'_>> = Vec::new();
    for (entry, frame) in &trial.shots {
        match shots.iter_mut().find(|s| s.entry.colour == entry.colour) {
            Some(known) => known.frames.push(frame),
            None => shots.push(Shots {
                entry,
                frames: vec![frame],
            }),
        }
    }
    shots.truncate(PALETTE_SIZE);
    if shots.len() < 4 {
        return Err(PipelineError::TooFewColours { found: shots.len() });
    }
    Ok(shots)
}
