//! How wide the lines are, and how finely the picture must be looked at.
//!
//! A box of width w under a Gaussian second derivative of standard deviation s, times s^2, is strongest at
//! s = w/2 (T. Lindeberg, "Edge detection and ridge detection with automatic scale selection", 1998). The gain
//! along a few stripes of the picture suffices; for each doubling of the width it is halved in resolution. Many
//! different widths in one picture give a middle one.

use pulp::NullaryFnOnce;
use shared::pattern::Axis;

use super::{LineScale, LineSettings, Sampling};
use crate::{
    channels::MOST_BIN,
    gain::{Band, GainFilter, ProfileBuffers, find_profile},
    line_light::LineLight,
    wide::wide,
};

/// From one scale to the next.
const STEP: f64 = 1.25;
/// Stripes looked at per family, spread over the picture.
const STRIPES: usize = 6;
/// Their thickness, in camera pixels.
const THICK_PX: usize = 2;
/// Widest line that is looked for before the resolution is halved, in the profile's pixels.
const WIDEST: f64 = 4.8;
/// Weaker ridges are not counted: a full line's is about 0.46 at its own scale, and in the dark noise makes
/// many of some 0.1.
const LEAST_RIDGE: f32 = 0.2;
/// Stronger ones count no more than this: single pixels that are wrong must not outvote the lines.
const MOST_RIDGE: f32 = 0.6;

/// Lines are left so many pixels wide when the picture's resolution is reduced.
const WIDTH_LEFT: f64 = 3.2;
/// Samples that must be left on the arm of a crossing.
const ARM_SAMPLES: f64 = 6.0;
/// What is left out of an arm beside the edge of the line that crosses, in camera pixels.
const ARM_MARGIN_PX: f64 = 1.5;

/// What the scale search keeps between frames.
#[derive(Debug, Default)]
pub(super) struct ScaleBuffers {
    profiles: ProfileBuffers,
    profile: Vec<f32>,
    ridge: Vec<f32>,
    scales: Vec<Scale>,
}

/// One width that is tried.
#[derive(Debug, Default)]
struct Scale {
    width_px: f64,
    /// How often the profile is halved for it.
    halvings: usize,
    kernel: Vec<f32>,
    votes: f64,
}

/// Finds the widths of the lines and the sampling that suits them. `pitch_widths` are the pattern's pitches of
/// rows and columns in widths of their lines.
pub(super) fn find_scale(
    (light, filter): (&LineLight<'_>, &GainFilter),
    pitch_widths: [f64; 2],
    settings: &LineSettings,
    buffers: &mut ScaleBuffers,
) -> LineScale {
    let widths_px = Axis::BOTH.map(|family| line_width((light, filter), family, settings, buffers));
    let narrowest = widths_px[0].min(widths_px[1]);
    let arm = |k: usize| 0.5 * (pitch_widths[k] - 1.0) * widths_px[k] - ARM_MARGIN_PX;
    let most_spacing = arm(0).min(arm(1)) / ARM_SAMPLES;
    let most_bin = settings.coarsest_px.clamp(1, MOST_BIN);
    let bin = ((narrowest / WIDTH_LEFT).min(most_spacing) as usize).clamp(1, most_bin);
    let most_step = settings.step_px.clamp(1, 4);
    let step = ((most_spacing / bin as f64) as usize).clamp(1, most_step);
    LineScale {
        widths_px,
        sampling: Sampling { bin, step },
    }
}

/// The typical width of one family's lines across x (steep lines) or y (flat ones), in camera pixels, within the
/// settings' range.
fn line_width(
    (light, filter): (&LineLight<'_>, &GainFilter),
    family: Axis,
    settings: &LineSettings,
    buffers: &mut ScaleBuffers,
) -> f64 {
    let narrowest = settings.narrowest_px.clamp(1.6, 64.0);
    let widest = settings.widest_px.clamp(narrowest, 64.0);
    let (width, height) = (light.width(), light.height());
    if width < 2 * THICK_PX || height < 2 * THICK_PX {
        return narrowest;
    }
    prepare(&mut buffers.scales, narrowest, widest);
    let length = match family {
        Axis::Row => width,
        Axis::Column => height,
    };
    for k in 0..STRIPES {
        let band = Band {
            family,
            at: (2 * k + 1) * (length - THICK_PX) / (2 * STRIPES),
            thick: THICK_PX,
        };
        let profile = (&mut buffers.profiles, &mut buffers.profile);
        find_profile(light, filter, band, profile);
        wide(ProfileVotes {
            profile: &mut buffers.profile,
            ridge: &mut buffers.ridge,
            scales: &mut buffers.scales,
        });
    }
    refine(&buffers.scales)
}

/// The scales between two widths, without votes.
fn prepare(scales: &mut Vec<Scale>, narrowest: f64, widest: f64) {
    let count = ((widest / narrowest).ln() / STEP.ln()).ceil() as usize + 1;
    let fits = scales.len() == count && scales[0].width_px == narrowest;
    if !fits {
        *scales = (0..count as i32)
            .map(|k| {
                let width_px = narrowest * STEP.powi(k);
                let halvings = (width_px / WIDEST).log2().ceil().max(0.0) as usize;
                let sigma = 0.5 * width_px / (1 << halvings) as f64;
                Scale {
                    width_px,
                    halvings,
                    kernel: ridge_kernel(sigma),
                    votes: 0.0,
                }
            })
            .collect();
    }
    scales.iter_mut().for_each(|scale| scale.votes = 0.0);
}

/// -s^2 times a Gaussian's second derivative, without mean: element k is at offset k from the middle.
fn ridge_kernel(sigma: f64) -> Vec<f32> {
    let radius = (3.0 * sigma).ceil() as usize;
    let gauss = |k: usize| (-0.5 * (k as f64 / sigma).powi(2)).exp();
    let second = |k: usize| 1.0 - (k as f64 / sigma).powi(2);
    let both_sides = |of: &dyn Fn(usize) -> f64| of(0) + 2.0 * (1..=radius).map(of).sum::<f64>();
    let total = both_sides(&gauss);
    // what sampling leaves of the kernel's sum would let a flat picture look like a line
    let rest = both_sides(&|k| second(k) * gauss(k)) / total;
    (0..=radius)
        .map(|k| ((second(k) - rest) * gauss(k) / total) as f32)
        .collect()
}

/// The votes of one stripe for each scale.
struct ProfileVotes<'a> {
    profile: &'a mut Vec<f32>,
    ridge: &'a mut Vec<f32>,
    scales: &'a mut [Scale],
}

impl NullaryFnOnce for ProfileVotes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut halvings = 0;
        for scale in self.scales {
            while halvings < scale.halvings {
                halve(self.profile);
                halvings += 1;
            }
            convolve(self.profile, &scale.kernel, self.ridge);
            scale.votes += strongest(self.ridge);
        }
    }
}

#[inline(always)]
fn halve(profile: &mut Vec<f32>) {
    let half = profile.len() / 2;
    for k in 0..half {
        profile[k] = 0.5 * (profile[2 * k] + profile[2 * k + 1]);
    }
    profile.truncate(half);
}

/// The even kernel over the profile's inside.
#[inline(always)]
fn convolve(profile: &[f32], kernel: &[f32], out: &mut Vec<f32>) {
    let radius = kernel.len() - 1;
    out.clear();
    let Some(inside) = profile.len().checked_sub(2 * radius) else {
        return;
    };
    out.extend(
        profile[radius..][..inside]
            .iter()
            .map(|value| kernel[0] * value),
    );
    for (k, &weight) in kernel.iter().enumerate().skip(1) {
        let (before, after) = (&profile[radius - k..], &profile[radius + k..]);
        let pairs = out.iter_mut().zip(before).zip(after);
        pairs.for_each(|((sum, a), b)| *sum += weight * (a + b));
    }
}

/// Sum of the cubes of the local maxima, so that many weak ones (noise) count less than lines.
#[inline(always)]
fn strongest(ridge: &[f32]) -> f64 {
    const LANES: usize = 8; // sums side by side, so that they can be added up in one go
    let mut sums = [0.0f32; LANES];
    for first in (0..ridge.len().saturating_sub(LANES + 1)).step_by(LANES) {
        let three = [0, 1, 2].map(|shift| ridge[first + shift..][..LANES].try_into());
        let [Ok(before), Ok(here), Ok(after)]: [Result<&[f32; LANES], _>; 3] = three else {
            continue;
        };
        for lane in 0..LANES {
            let h = here[lane];
            let over = u32::from(h > LEAST_RIDGE);
            let peak = over & u32::from(h >= before[lane]) & u32::from(h > after[lane]);
            let h = h.min(MOST_RIDGE) * peak as f32;
            sums[lane] += h * h * h;
        }
    }
    sums.iter().map(|&sum| f64::from(sum)).sum()
}

/// The maximum of the votes, between the scales by a parabola.
fn refine(scales: &[Scale]) -> f64 {
    let votes = |k: usize| scales[k].votes;
    let best = (0..scales.len()).fold(0, |best, k| if votes(k) > votes(best) { k } else { best });
    let width_px = scales[best].width_px;
    if best == 0 || best + 1 == scales.len() {
        return width_px;
    }
    let (a, b, c) = (votes(best - 1), votes(best), votes(best + 1));
    let bend = a - 2.0 * b + c;
    let offset = if bend < 0.0 {
        (0.5 * (a - c) / bend).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    width_px * STEP.powf(offset)
}
