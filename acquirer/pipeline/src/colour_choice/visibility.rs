//! How surely a line of each colour is seen at all in a coded frame that stands alone.
//!
//! Takes places, gives for each colour and place how far the line rises above the limit at which the line finder
//! begins a track, in standard deviations: the gain of such a line (`gain`), the least strength of a ridge (`lines`)
//! and the noise of both, at the shipped settings. Below 0 the line is lost more often than not. A unary frame beside
//! the coded one would show lines that are lost here; it is not always there, and without it the dimmest of the four
//! colours decides. Taken for a line of its full width: at places where lines are broken it fails quietly.

use super::{
    distances::{LANES, LIGHT_ERROR},
    noise::NoiseLaw,
    responses::Responses,
    samples::{Place, linear},
};
use crate::{
    gain::{ChannelError, GainSettings},
    lines::{FULL_STRENGTH, LineSettings, RidgeLimit},
};
use shared::pattern::{PALETTE_SIZE, Rgb};

/// What the line finder asks of a line, in units of gain: 1 is full white light.
pub(super) struct Visibility {
    /// Linear light of the colours as projected, which the finder's matched filter takes for granted.
    nominal: Vec<[f32; 3]>,
    errors: [ChannelError; 3],
    limit: RidgeLimit,
    shrink: f32,
    /// Share of the brightest lines around that a line must have.
    share_of_local: f32,
    /// Share of a frame's variance that the mean of the black frames adds.
    black_share: f32,
}

impl Visibility {
    /// For lines of this width in camera px, read with as many black frames as the trial has.
    pub(super) fn new(colours: &[Rgb], line_px: f64, blacks: usize, noise: NoiseLaw) -> Self {
        let (gain, lines) = (GainSettings::default(), LineSettings::default());
        let black_share = 1.0 / blacks.max(1) as f32;
        let law = (noise.read as f32, noise.shot as f32);
        let width_px = line_px.clamp(lines.narrowest_px, lines.widest_px);
        let shrink = gain.shrink as f32;
        Self {
            nominal: colours.iter().map(|colour| colour.0.map(linear)).collect(),
            errors: std::array::from_fn(|c| ChannelError::new(c, law, black_share, &gain)),
            limit: RidgeLimit::new(width_px, lines.step_px, shrink, &lines),
            shrink,
            share_of_local: lines.share_of_local as f32,
            black_share,
        }
    }

    /// Standard deviations above the limit, by colour, for up to [`LANES`] places; beyond these, of no meaning.
    #[inline(always)]
    pub(super) fn margins(
        &self,
        places: &[&Place],
        responses: &Responses,
        noise: NoiseLaw,
    ) -> [[f32; LANES]; PALETTE_SIZE] {
        let mut margins = [[0.0; LANES]; PALETTE_SIZE];
        let light = Light::new(places, &self.errors);
        let colours = self.nominal.iter().zip(&responses.r);
        for (margins, (nominal, r)) in margins.iter_mut().zip(colours) {
            let (mut power, mut signal, mut variance) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for c in 0..3 {
                let (dark, white, weight) = (&light.dark[c], &light.white[c], &light.weight[c]);
                for n in 0..LANES {
                    let weight = nominal[c] * weight[n];
                    let line = responses.line_level * r[c] * white[n];
                    power[n] += weight * nominal[c] * white[n];
                    signal[n] += weight * line;
                    let own = noise.read as f32 * (1.0 + self.black_share)
                        + noise.shot as f32 * (dark[n] * (1.0 + self.black_share) + line);
                    let falsified = LIGHT_ERROR * line;
                    variance[n] +=
                        weight * weight * (responses.excess * own + falsified * falsified);
                }
            }
            for n in 0..LANES {
                let pull = 1.0 / (power[n] + self.shrink);
                let local = self.share_of_local * responses.line_level;
                let least = (self.limit.strength(power[n]) / FULL_STRENGTH).max(local);
                let noise = self.limit.smoothing / FULL_STRENGTH * variance[n].sqrt() * pull;
                margins[n] = (signal[n] * pull - least) / noise.max(f32::MIN_POSITIVE);
            }
        }
        margins
    }
}

/// One number for each channel and place.
type Channels = [[f32; LANES]; 3];

/// The light of some places, side by side in memory.
struct Light {
    dark: Channels,
    white: Channels,
    /// White over the squared error of a line there: what the matched filter gives a channel.
    weight: Channels,
}

impl Light {
    #[inline(always)]
    fn new(places: &[&Place], errors: &[ChannelError; 3]) -> Self {
        let mut light = Self {
            dark: [[0.0; LANES]; 3],
            white: [[0.0; LANES]; 3],
            weight: [[0.0; LANES]; 3],
        };
        for (n, place) in places.iter().enumerate() {
            for (c, error) in errors.iter().enumerate() {
                let (dark, white) = (place.dark[c].max(0.0), place.white[c].max(0.0));
                light.dark[c][n] = dark;
                light.white[c][n] = white;
                light.weight[c][n] = white / error.squared(dark, white);
            }
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::Places;
    use super::*;

    const COLOURS: [Rgb; 3] = [Rgb::WHITE, Rgb([0, 0, 255]), Rgb([0, 0, 0])];

    /// Margins of white, blue and black lines on a surface under white light of this strength.
    fn margins(white: [f32; 3], line_px: f64) -> [f32; 3] {
        let place = Place {
            white,
            ..Places::grey_wall().places[0]
        };
        let (noise, responses) = (NoiseLaw::COMMON, Responses::nominal(&COLOURS));
        let visibility = Visibility::new(&COLOURS, line_px, 2, noise);
        let margins = visibility.margins(&[&place], &responses, noise);
        [0, 1, 2].map(|k| margins[k][0])
    }

    #[test]
    fn a_line_is_lost_where_the_surface_swallows_its_colour() {
        let [white, blue, black] = margins([0.3; 3], 4.0);
        assert!(
            white > 3.0 && blue > 1.0 && black < -3.0,
            "{white} {blue} {black}"
        );
        let [white, blue, _] = margins([0.3, 0.3, 0.005], 4.0);
        assert!(white > 3.0 && blue < 0.0, "{white} {blue}");
    }

    #[test]
    fn wider_lines_and_more_light_are_seen_better() {
        let blue = |white: [f32; 3], line_px: f64| margins(white, line_px)[1];
        assert!(blue([0.3; 3], 8.0) > blue([0.3; 3], 3.0));
        assert!(blue([0.3; 3], 4.0) > blue([0.02; 3], 4.0));
    }

    #[test]
    fn without_projected_light_nothing_is_seen() {
        for margin in margins([0.0; 3], 4.0) {
            assert!(margin < -8.0, "{margin}");
        }
    }
}
