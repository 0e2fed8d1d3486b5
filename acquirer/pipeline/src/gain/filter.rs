//! The matched filter over the channels, for the widest registers that the processor has.
//!
//! Each value has its own order of operations, and none is fused with another: the width of the registers does not
//! change a bit.

use pulp::{Simd, WithSimd};
use shared::pattern::MAX_COLOURS;

use super::GainSettings;
use crate::line_light::LineLight;

/// Errors of red, green and blue relative to each other: a colour mosaic samples green twice as densely.
const BAYER_ERROR: [f64; 3] = [1.0, 0.5, 1.0];

/// Steps of the gain between 0 and 1: far finer than noise, and coarse enough that sums over any kernel used on
/// it stay exact in 24 bits.
const STEPS: f32 = 2048.0;
/// Adding and taking away this rounds to whole steps.
pub(super) const ROUNDS: f32 = 1.5 * (1 << 23) as f32 / STEPS;
/// Gains beyond are no light of a line but a reference that does not fit.
const GAIN_RANGE: [f32; 2] = [-0.5, 1.5];

/// The matched filter over the channels.
#[derive(Debug, Clone)]
pub struct GainFilter {
    colours: LineColours,
    shrink: f32,
    channels: [ChannelError; 3],
}

/// The colours that a line may have.
#[derive(Debug, Clone)]
struct LineColours {
    /// Linear responses of the colours, and their squares.
    all: [[[f32; 3]; 2]; MAX_COLOURS],
    count: usize,
    /// When all are colours of whole channels, as in most grids: bit k is set when there is one of the channels that
    /// the bits of k name.
    whole: Option<u8>,
}

impl LineColours {
    fn new(colours: &[[f32; 3]]) -> Self {
        const WHITE: &[[f32; 3]] = &[[1.0; 3]];
        let colours = if colours.is_empty() { WHITE } else { colours };
        let channels = |colour: &[f32; 3]| {
            let whole = colour.iter().all(|&v| v == 0.0 || v == 1.0);
            let bits = (0..3).map(|c| u8::from(colour[c] == 1.0) << c);
            whole.then(|| 1 << bits.sum::<u8>())
        };
        let sets: Option<u8> = colours
            .iter()
            .try_fold(0, |sets, c| Some(sets | channels(c)?));
        let mut all = [[[0.0; 3]; 2]; MAX_COLOURS];
        for (place, &colour) in all.iter_mut().zip(colours) {
            *place = [colour, colour.map(|v| v * v)];
        }
        Self {
            all,
            count: colours.len().min(MAX_COLOURS),
            // black has no gain
            whole: sets.filter(|sets| sets & 1 == 0),
        }
    }
}

/// What becomes of light and its error in the mean over some pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mean {
    /// From the sum of lights to their mean.
    share: f32,
    channels: [ChannelError; 3],
}

/// The squared error of one channel's light above black, for a capture of half of white's light:
/// `floor + of_black K + of_white s + of_square s^2`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChannelError {
    floor: f32,
    of_black: f32,
    of_white: f32,
    of_square: f32,
}

impl ChannelError {
    /// For channel `c` with the noise law `floor + growth x light`; black was captured 1 / `black_share` times.
    pub(crate) fn new(
        c: usize,
        (floor, growth): (f32, f32),
        black_share: f32,
        settings: &GainSettings,
    ) -> Self {
        Self {
            floor: floor * (1.0 + black_share),
            of_black: growth * (1.0 + black_share),
            of_white: 0.5 * growth,
            of_square: (BAYER_ERROR[c] * settings.channel_error).powi(2) as f32,
        }
    }

    /// Where black gives `k` and white adds `s`.
    #[inline(always)]
    pub(crate) fn squared(&self, k: f32, s: f32) -> f32 {
        self.floor + self.of_black * k + (self.of_white + self.of_square * s) * s
    }
}

impl GainFilter {
    /// The filter for lines of these colours (linear, 0 to 1 per channel); none are taken for white.
    #[must_use]
    pub fn new(light: &LineLight<'_>, colours: &[[f32; 3]], settings: &GainSettings) -> Self {
        let [_, black_share] = light.shares();
        let noise = light.noise;
        Self {
            colours: LineColours::new(colours),
            shrink: settings.shrink.max(1e-6) as f32,
            channels: std::array::from_fn(|c| {
                ChannelError::new(c, (noise.floor[c], noise.growth[c]), black_share, settings)
            }),
        }
    }

    /// For the mean over so many pixels of so many frames. The noise averages out, other errors do not.
    pub(super) fn mean_of(&self, frames: usize, pixels: usize) -> Mean {
        let share = 1.0 / pixels.max(1) as f32;
        Mean {
            share: share / frames.max(1) as f32,
            channels: self.channels.map(|error| ChannelError {
                floor: share * error.floor,
                of_black: share * error.of_black,
                of_white: share * error.of_white,
                of_square: error.of_square,
            }),
        }
    }

    /// Gain and power where the lights' sums, black and white light are these.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, mean: &Mean, inputs: Inputs<S::f32s>) -> (S::f32s, S::f32s) {
        let share = simd.splat_f32s(mean.share);
        let shrink = simd.splat_f32s(self.shrink);
        let (mut squared, mut signals, mut powers) = ([share; 3], [share; 3], [share; 3]);
        for (c, squared) in squared.iter_mut().enumerate() {
            let error = mean.channels[c];
            let (black, white) = (inputs.blacks[c], inputs.whites[c]);
            let of_square = simd.mul_f32s(simd.splat_f32s(error.of_square), white);
            let of_white = simd.add_f32s(simd.splat_f32s(error.of_white), of_square);
            let of_black = simd.mul_f32s(simd.splat_f32s(error.of_black), black);
            let of_black = simd.add_f32s(simd.splat_f32s(error.floor), of_black);
            *squared = simd.add_f32s(of_black, simd.mul_f32s(of_white, white));
        }
        // one division is dearer than what saves two
        let first = simd.mul_f32s(squared[0], squared[1]);
        let inverse = simd.div_f32s(simd.splat_f32s(1.0), simd.mul_f32s(first, squared[2]));
        let of_both = simd.mul_f32s(inverse, squared[2]);
        let inverses = [
            simd.mul_f32s(of_both, squared[1]),
            simd.mul_f32s(of_both, squared[0]),
            simd.mul_f32s(inverse, first),
        ];
        for c in 0..3 {
            let weight = simd.mul_f32s(inputs.whites[c], inverses[c]);
            let above = simd.sub_f32s(simd.mul_f32s(share, inputs.sums[c]), inputs.blacks[c]);
            signals[c] = simd.mul_f32s(above, weight);
            powers[c] = simd.mul_f32s(inputs.whites[c], weight);
        }
        let mut best = Best {
            // whatever comes first is better
            signal: simd.splat_f32s(-1.0),
            power: simd.splat_f32s(0.0),
        };
        if let Some(sets) = self.colours.whole {
            best.of_whole(simd, signals, powers, (sets, shrink));
        } else {
            for &[colour, squares] in &self.colours.all[..self.colours.count] {
                let power = simd.add_f32s(weighted(simd, powers, squares), shrink);
                best.take(simd, weighted(simd, signals, colour), power);
            }
        }
        let Best {
            signal: best,
            power: best_power,
        } = best;
        let gain = simd.div_f32s(best, best_power);
        let gain = simd.min_f32s(gain, simd.splat_f32s(GAIN_RANGE[1]));
        let gain = simd.max_f32s(gain, simd.splat_f32s(GAIN_RANGE[0]));
        let rounds = simd.splat_f32s(ROUNDS);
        let rounded = simd.sub_f32s(simd.add_f32s(gain, rounds), rounds);
        (rounded, simd.sub_f32s(best_power, shrink))
    }
}

/// Signal and power of the colour with the most gain, `signal / power`.
struct Best<V> {
    signal: V,
    power: V,
}

// no closures: what they call would not be compiled for wide registers
impl<V: Copy> Best<V> {
    #[inline(always)]
    fn take<S: Simd<f32s = V>>(&mut self, simd: S, signal: V, power: V) {
        let gains = simd.mul_f32s(signal, self.power);
        let better = simd.greater_than_f32s(gains, simd.mul_f32s(self.signal, power));
        self.signal = select(simd, better, signal, self.signal);
        self.power = select(simd, better, power, self.power);
    }

    /// The best of the colours of whole channels, which need no multiplications.
    #[inline(always)]
    fn of_whole<S: Simd<f32s = V>>(
        &mut self,
        simd: S,
        [red, green, blue]: [V; 3],
        [red_power, green_power, blue_power]: [V; 3],
        (sets, shrink): (u8, V),
    ) {
        let powers = [
            simd.add_f32s(red_power, shrink),
            simd.add_f32s(green_power, shrink),
            simd.add_f32s(blue_power, shrink),
        ];
        let has = |set: u8| sets >> set & 1 == 1;
        if has(0b001) {
            self.take(simd, red, powers[0]);
        }
        if has(0b010) {
            self.take(simd, green, powers[1]);
        }
        if has(0b100) {
            self.take(simd, blue, powers[2]);
        }
        let (yellow, power) = (
            simd.add_f32s(red, green),
            simd.add_f32s(powers[0], green_power),
        );
        if has(0b011) {
            self.take(simd, yellow, power);
        }
        if has(0b111) {
            self.take(
                simd,
                simd.add_f32s(yellow, blue),
                simd.add_f32s(power, blue_power),
            );
        }
        if has(0b101) {
            self.take(
                simd,
                simd.add_f32s(red, blue),
                simd.add_f32s(powers[0], blue_power),
            );
        }
        if has(0b110) {
            self.take(
                simd,
                simd.add_f32s(green, blue),
                simd.add_f32s(powers[1], blue_power),
            );
        }
    }
}

/// As pulp's own, which is not always inlined and then not compiled for wide registers.
#[inline(always)]
fn select<S: Simd>(simd: S, mask: S::m32s, if_true: S::f32s, if_false: S::f32s) -> S::f32s {
    let (if_true, if_false) = (pulp::cast(if_true), pulp::cast(if_false));
    pulp::cast(simd.select_u32s(mask, if_true, if_false))
}

#[inline(always)]
fn weighted<S: Simd>(simd: S, values: [S::f32s; 3], weights: [f32; 3]) -> S::f32s {
    let red = simd.mul_f32s(values[0], simd.splat_f32s(weights[0]));
    let green = simd.mul_f32s(values[1], simd.splat_f32s(weights[1]));
    let blue = simd.mul_f32s(values[2], simd.splat_f32s(weights[2]));
    simd.add_f32s(simd.add_f32s(red, green), blue)
}

/// Values of red, green and blue.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inputs<V> {
    /// Sums of light.
    pub(super) sums: [V; 3],
    /// Light under black projection.
    pub(super) blacks: [V; 3],
    /// Light that white adds.
    pub(super) whites: [V; 3],
}

/// One row's way through the filter; all slices have the same length.
pub(super) struct RowFilter<'a> {
    pub(super) filter: &'a GainFilter,
    pub(super) mean: Mean,
    pub(super) inputs: Inputs<&'a [f32]>,
    pub(super) gain: &'a mut [f32],
    pub(super) power: &'a mut [f32],
}

impl WithSimd for RowFilter<'_> {
    type Output = ();

    // no closures: what they call would not be compiled for wide registers
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (gains, gain_rest) = S::as_mut_simd_f32s(self.gain);
        let (powers, power_rest) = S::as_mut_simd_f32s(self.power);
        let Inputs {
            sums: [s0, s1, s2],
            blacks: [b0, b1, b2],
            whites: [w0, w1, w2],
        } = self.inputs;
        let (s0, s1, s2) = (
            S::as_simd_f32s(s0),
            S::as_simd_f32s(s1),
            S::as_simd_f32s(s2),
        );
        let (b0, b1, b2) = (
            S::as_simd_f32s(b0),
            S::as_simd_f32s(b1),
            S::as_simd_f32s(b2),
        );
        let (w0, w1, w2) = (
            S::as_simd_f32s(w0),
            S::as_simd_f32s(w1),
            S::as_simd_f32s(w2),
        );
        let sums = s0.0.iter().zip(s1.0).zip(s2.0);
        let blacks = b0.0.iter().zip(b1.0).zip(b2.0);
        let whites = w0.0.iter().zip(w1.0).zip(w2.0);
        let outputs = gains.iter_mut().zip(powers);
        for (((s, b), w), (gain, power)) in sums.zip(blacks).zip(whites).zip(outputs) {
            let inputs = Inputs {
                sums: [*s.0.0, *s.0.1, *s.1],
                blacks: [*b.0.0, *b.0.1, *b.1],
                whites: [*w.0.0, *w.0.1, *w.1],
            };
            (*gain, *power) = self.filter.at(simd, &self.mean, inputs);
        }
        let rest = |row: &[f32]| simd.partial_load_f32s(row);
        let inputs = Inputs {
            sums: [rest(s0.1), rest(s1.1), rest(s2.1)],
            blacks: [rest(b0.1), rest(b1.1), rest(b2.1)],
            whites: [rest(w0.1), rest(w1.1), rest(w2.1)],
        };
        let (gain, power) = self.filter.at(simd, &self.mean, inputs);
        simd.partial_store_f32s(gain_rest, gain);
        simd.partial_store_f32s(power_rest, power);
    }
}
