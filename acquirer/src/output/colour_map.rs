//! A number as a colour, and the bar that says which colour is which number.
//!
//! The map is viridis (N. Smith and S. van der Walt, matplotlib 1.5, CC0): equal steps look equal, it survives
//! grey-scale printing, and people with any colour vision can read it.

use super::{
    drawing::{Anchor, Drawing, Ink, Text},
    figure::DARK,
};

/// Viridis at nine even places; between them it is straight to within what an eye can tell.
const VIRIDIS: [[u8; 3]; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2d, 0x7b],
    [0x3b, 0x52, 0x8b],
    [0x2c, 0x72, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x28, 0xae, 0x80],
    [0x5e, 0xc9, 0x62],
    [0xad, 0xdc, 0x30],
    [0xfd, 0xe7, 0x25],
];

/// The colour of a share of the scale, 0 (dark blue) to 1 (yellow); what is beyond takes the end's colour.
#[must_use]
pub fn viridis(share: f64) -> [u8; 3] {
    let share = if share.is_nan() { 0.0 } else { share };
    let place = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let low = (place as usize).min(VIRIDIS.len() - 2);
    let part = place - low as f64;
    let (a, b) = (VIRIDIS[low], VIRIDIS[low + 1]);
    [0, 1, 2].map(|c| (f64::from(a[c]) * (1.0 - part) + f64::from(b[c]) * part).round() as u8)
}

/// A range of numbers that colours stand for.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// The number that has the first colour.
    pub low: f64,
    /// The number that has the last colour; above `low`.
    pub high: f64,
    /// What the numbers are, with their unit, for example `z / mm`.
    pub name: String,
    /// Small numbers are yellow, large ones dark blue.
    pub reversed: bool,
}

impl Scale {
    /// The scale that covers all finite numbers given, but not the outermost `outliers` (a share, 0 to 0.5) on
    /// either side. Without numbers, 0 to 1.
    #[must_use]
    pub fn covering(values: impl Iterator<Item = f64>, outliers: f64, name: &str) -> Self {
        let [low, high] = spread(values, outliers).unwrap_or([0.0, 1.0]);
        let widening = if high - low > 1e-9 * low.abs().max(1e-6) {
            0.0
        } else {
            low.abs().max(1.0) * 0.01
        };
        Self {
            low: low - widening,
            high: high + widening,
            name: name.to_owned(),
            reversed: false,
        }
    }

    /// The same scale with the colours turned round.
    #[must_use]
    pub fn turned(self) -> Self {
        Self {
            reversed: !self.reversed,
            ..self
        }
    }

    /// The colour of a number.
    #[must_use]
    pub fn colour(&self, value: f64) -> [u8; 3] {
        let share = (value - self.low) / (self.high - self.low);
        viridis(if self.reversed { 1.0 - share } else { share })
    }

    /// Draws the name, the bar and its ticks into a frame (left, top, width, height in the drawing's units);
    /// `unit` of them are a line's width.
    pub fn draw(&self, drawing: &mut Drawing, [left, top, width, height]: [f64; 4], unit: f64) {
        const STEPS: usize = 64;
        let text = |at, text, anchor| Text {
            at,
            text,
            size: 14.0 * unit,
            anchor,
            ink: DARK,
            halo: None,
        };
        let name_at = [left + width / 2.0, top + 8.0 * unit];
        drawing.text(text(name_at, self.name.clone(), Anchor::Middle));
        let (x, y) = (left + 0.2 * width, top + 26.0 * unit);
        let (w, h) = (20.0 * unit, height - 26.0 * unit);
        for step in 0..STEPS {
            let share = step as f64 / STEPS as f64;
            let step_top = y + h * share;
            let value = self.high - (share + 0.5 / STEPS as f64) * (self.high - self.low);
            let ink = Ink::solid(self.colour(value));
            // each step reaches below the next one, so that no seam shows
            let reach = (2.0 * h / STEPS as f64).min(y + h - step_top);
            drawing.rectangle([x, step_top], [w, reach], ink);
        }
        let corners = [[x, y], [x + w, y], [x + w, y + h], [x, y + h], [x, y]];
        drawing.stroke(corners, unit, DARK);
        for tick in ticks(self.low, self.high, 6) {
            let at = y + h * (self.high - tick) / (self.high - self.low);
            drawing.stroke([[x + w, at], [x + w + 4.0 * unit, at]], unit, DARK);
            let label = tick_label(tick, self.high - self.low);
            drawing.text(text([x + w + 7.0 * unit, at], label, Anchor::Start));
        }
    }
}

/// The smallest and largest of the finite numbers, leaving out a share of them at either end.
#[must_use]
pub fn spread(values: impl Iterator<Item = f64>, outliers: f64) -> Option<[f64; 2]> {
    let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let skip = (values.len() as f64 * outliers.clamp(0.0, 0.49)) as usize;
    Some([*values.get(skip)?, values[values.len() - 1 - skip]])
}

/// About `count` round numbers between two numbers, in rising order.
#[must_use]
pub fn ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let range = high - low;
    if !(range.is_finite() && range > 0.0 && low.abs().max(high.abs()) / range < 1e9) {
        return Vec::new();
    }
    let step = round_step(range / count.max(1) as f64);
    let first = (low / step).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

/// A tick with as many digits as its step needs.
#[must_use]
pub fn tick_label(tick: f64, range: f64) -> String {
    let digits = (1.0 - (range / 4.0).log10()).ceil().clamp(0.0, 6.0) as usize;
    let text = format!("{tick:.digits$}");
    let short = if digits > 0 {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    if short == "-0" { "0" } else { short }.to_owned()
}

/// The smallest of 1, 2, 5, 10 times a power of ten that is at least `wanted`.
fn round_step(wanted: f64) -> f64 {
    let power = 10_f64.powf(wanted.log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|f| f * power >= wanted * 0.999)
        .unwrap_or(10.0);
    factor * power
}
