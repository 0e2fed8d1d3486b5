//! A camera's response from solid colours that the projector showed on a scene that stood still.
//!
//! Takes the even blocks seen under black, white, greys, the three primaries and their pairs; gives the curve from
//! bytes to linear light with its residual.
//!
//! What makes it identifiable. A ramp of greys alone tells the curve only together with the projector's: light
//! K + w h(v) is linear in an unknown w for each block and an unknown h for each grey, and where K is small any power
//! of the light fits as well (M. Grossberg and S. Nayar, "What can be known about the radiometric response from
//! images?", 2002). Superposition settles that without the projector's curve: red and green light together with black
//! is as much as red plus green, whatever either is, so g(yellow) + g(black) = g(red) + g(green), linear in the inverse
//! response g (flux addition, as photodetectors are tested: L. Coslovi and F. Righini, "Fast determination of the
//! nonlinearity of photodetectors", 1980). Only pairs of primaries are added up, never all three to white, because
//! colour wheels with a clear segment make white brighter than its parts. Where the camera separates colours so well
//! that a pair says nothing, the ramp's level rests on a projector of gamma 2.2, weakly assumed.
//!
//! A constant added to g cancels in every equation: it shows only between black and the darkest byte seen, and cancels
//! in the light of a line above black, too.
//!
//! Method: the power of the sRGB curve that fits best, then a smooth spline on it; least squares over all equations, in
//! byte values, with weights from the slope of the curve and against outliers, and the ramp's unknowns eliminated
//! (Gauss-Newton). Brighter bytes than any in the captures follow the power. A camera whose exposure changes between
//! captures, or a scene that moves, does not add up and is refused.

use shared::pattern::Rgb;
use thiserror::Error;

use super::{
    curve::{KNOTS, ResponseCurve},
    equations::{Group, Kind, groups},
    fit::Fit,
    solids::{PRIMARIES, SolidCaptures},
};

/// A measured response.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredResponse {
    /// The curve.
    pub curve: ResponseCurve,
    /// By how much what was seen misses adding up, root mean square, byte values.
    pub residual_levels: f64,
    /// The same with the sRGB curve.
    pub srgb_residual_levels: f64,
    /// Whether the sRGB curve explains what was seen as well, and is kept.
    pub is_srgb: bool,
    /// Light of white above black over that of the three primaries together; 1 where the projector adds up.
    pub white_over_primaries: f64,
    /// Equations between blocks that the curve was fitted to.
    pub equations: usize,
}

/// Why no curve was measured.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NoMeasurement {
    /// Black, white, three greys, the primaries and their pairs must be there.
    #[error(
        "solid colours were recorded, but not all that are needed: black, white, three greys, red, green, blue \
         and their pairs"
    )]
    Incomplete,
    /// The pictures hold too few even places that are neither dark nor cut off.
    #[error(
        "only {0} places of the scene are evenly lit and neither dark nor clipped under all solid colours: too few \
         to measure the camera's response"
    )]
    TooFewPlaces(usize),
    /// No curve makes light add up.
    #[error(
        "the camera's pictures of solid colours do not add up ({levels:.1} grey levels) whatever its response: fix \
         exposure and white balance, and keep the scene still; the sRGB curve was used"
    )]
    DoesNotAddUp {
        /// Residual of the best curve, byte values.
        levels: f64,
    },
}

/// Fewest equations of pairs, and of greys.
const FEWEST: usize = 150;
/// Largest residual of a curve that is used, byte values: what noise and compression leave in a block is below 1.
const MOST_RESIDUAL: f64 = 1.5;
/// A residual larger by less than this is as good: the simpler curve stays.
const AS_GOOD: f64 = 1.1;

/// Measures the response from what was seen of solid colours in one or more scenes.
///
/// # Errors
/// What is missing, or that no curve fits.
pub fn measure_response(scenes: &[SolidCaptures]) -> Result<MeasuredResponse, NoMeasurement> {
    let mut groups: Vec<Group> = scenes.iter().filter_map(groups).flatten().collect();
    if groups.is_empty() {
        return Err(NoMeasurement::Incomplete);
    }
    let count = |pair: bool| -> usize {
        let of_kind = groups
            .iter()
            .filter(|g| matches!(g.kind, Kind::Pair) == pair);
        of_kind.map(|group| group.bytes.len()).sum()
    };
    let (pairs, greys) = (count(true), count(false));
    if pairs.min(greys) < FEWEST {
        return Err(NoMeasurement::TooFewPlaces(pairs.min(greys)));
    }
    let mut fit = Fit::new();
    fit.settle_shares(&mut groups);
    let srgb_residual_levels = fit.residual(&groups);
    fit.take_best_power(&mut groups);
    let curve = fit.refine(&mut groups);
    let residual_levels = fit.residual(&groups);
    if residual_levels > MOST_RESIDUAL {
        return Err(NoMeasurement::DoesNotAddUp {
            levels: residual_levels,
        });
    }
    let is_srgb = srgb_residual_levels < AS_GOOD * residual_levels;
    if is_srgb {
        fit.take([0.0; KNOTS]);
    }
    Ok(MeasuredResponse {
        curve: if is_srgb {
            ResponseCurve::srgb()
        } else {
            curve
        },
        is_srgb,
        residual_levels,
        srgb_residual_levels,
        white_over_primaries: white_over_primaries(&fit, scenes),
        equations: pairs + greys,
    })
}

/// How much brighter white is than the sum of its primaries, over all blocks.
fn white_over_primaries(fit: &Fit, scenes: &[SolidCaptures]) -> f64 {
    let (mut whole, mut parts) = (0.0, 0.0);
    for solids in scenes {
        let [black, white] = [Rgb::BLACK, Rgb::WHITE].map(|colour| solids.means(colour));
        let (Some(black), Some(white)) = (black, white) else {
            continue;
        };
        let primaries: Vec<_> = PRIMARIES.iter().filter_map(|&c| solids.means(c)).collect();
        for (at, c) in (0..black.len().min(white.len())).flat_map(|at| [(at, 0), (at, 1), (at, 2)])
        {
            let light = |blocks: &[[f32; 3]]| {
                let byte = blocks.get(at).map_or(f32::NAN, |block| block[c]);
                fit.light(f64::from(byte))
            };
            let dark = light(&black);
            let sum: f64 = primaries.iter().map(|blocks| light(blocks) - dark).sum();
            let all = light(&white) - dark;
            if (sum + all).is_finite() {
                whole += all;
                parts += sum;
            }
        }
    }
    if parts > 0.0 { whole / parts } else { 1.0 }
}
