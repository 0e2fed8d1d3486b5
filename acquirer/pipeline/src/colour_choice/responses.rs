//! How the camera sees each projected colour, as a share of white per channel.
//!
//! Takes the places of a trial, gives one 3-vector r for each colour: light under the colour over light
//! under white, on the lines of the grid. Crosstalk between projector and camera is in r, the surface is
//! not (D. Caspi, N. Kiryati, J. Shamir, "Range imaging with adaptive color structured light", 1998).
//! Also gives how much of full white reaches the middle of a line, and by how much the residuals exceed the
//! noise law: surfaces with colours of their own, compression, movement.

use shared::pattern::Rgb;

use super::{
    noise::NoiseLaw,
    samples::{Place, Places, linear},
};

/// A place shows a line when it has this share of the line light of the brightest places.
const ON_LINE: f32 = 0.6;
/// Standard deviations of white light over dark below which the projector does not reach a place.
const REACH_SIGMAS: f32 = 6.0;
/// Least number of places from which responses are measured.
const ENOUGH: usize = 50;

/// What each colour of the trial does in this camera.
#[derive(Debug, Clone)]
pub(super) struct Responses {
    /// Light under each colour as a share of that under white, per channel.
    pub r: Vec<[f32; 3]>,
    /// Share of full white at the middle of a line, 0 to 1.
    pub line_level: f32,
    /// Variance of the residuals over the predicted one, at least 1.
    pub excess: f32,
    /// Whether they were measured; else they are the nominal colours.
    pub measured: bool,
}

impl Responses {
    pub(super) fn new(places: &Places, colours: &[Rgb], noise: NoiseLaw) -> Self {
        let white = colours.iter().position(|colour| *colour == Rgb::WHITE);
        let lines = Lines::new(places, white, noise);
        if lines.on.len() < ENOUGH {
            return Self::nominal(colours);
        }
        let r = lines.responses(colours.len());
        let excess = lines.excess(&r, noise);
        Self {
            r,
            line_level: lines.level,
            excess,
            measured: true,
        }
    }

    /// A camera without crosstalk.
    pub(super) fn nominal(colours: &[Rgb]) -> Self {
        Self {
            r: colours.iter().map(|colour| colour.0.map(linear)).collect(),
            line_level: 1.0,
            excess: 1.0,
            measured: false,
        }
    }
}

/// Whether projected light is seen at a place.
pub(super) fn is_lit(place: &Place, noise: NoiseLaw) -> bool {
    let light: f32 = place.white.iter().sum();
    let variance: f32 = place.dark.iter().map(|&dark| noise.variance(dark)).sum();
    light > REACH_SIGMAS * variance.sqrt()
}

/// The places in the middle of the lines, each with the light that a white line gives there.
struct Lines<'a> {
    on: Vec<(&'a Place, [f32; 3])>,
    level: f32,
}

impl<'a> Lines<'a> {
    fn new(places: &'a Places, white: Option<usize>, noise: NoiseLaw) -> Self {
        let mut lit: Vec<(&Place, [f32; 3], f32)> = Vec::new();
        for place in places.places.iter().filter(|place| is_lit(place, noise)) {
            let line = line_light(place, white);
            let whole: f32 = place.white.iter().sum();
            // between the lines and at their soft edges the share is lower; without a white frame it is
            // 1 everywhere, and what is lit is a line
            lit.push((place, line, line.iter().sum::<f32>() / whole));
        }
        let mut shares: Vec<f32> = lit.iter().map(|l| l.2).collect();
        let brightest = match shares.len() * 97 / 100 {
            _ if shares.is_empty() => 0.0,
            at => *shares.select_nth_unstable_by(at, f32::total_cmp).1,
        };
        let on: Vec<_> = lit.iter().filter(|l| l.2 > ON_LINE * brightest).collect();
        let sum = |of: fn(&(&Place, [f32; 3], f32)) -> f32| on.iter().map(|l| of(l)).sum::<f32>();
        let level = sum(|l| l.1.iter().sum()) / sum(|l| l.0.white.iter().sum()).max(1e-9);
        Self {
            on: on.iter().map(|l| (l.0, l.1)).collect(),
            level: level.clamp(0.05, 1.0),
        }
    }

    fn responses(&self, colours: usize) -> Vec<[f32; 3]> {
        let ratio = |k: usize, c: usize| {
            let (mut light, mut white) = (0.0_f64, 0.0_f64);
            for (place, line) in self.on.iter().filter(|(place, _)| place.usable[c]) {
                light += f64::from(place.shots[k][c]);
                white += f64::from(line[c]);
            }
            if white > 0.0 {
                (light / white).clamp(0.0, 2.0) as f32
            } else {
                0.0
            }
        };
        (0..colours)
            .map(|k| std::array::from_fn(|c| ratio(k, c)))
            .collect()
    }

    /// Each squared residual counts at most 25 times its variance, so that single wild places do not rule.
    fn excess(&self, r: &[[f32; 3]], noise: NoiseLaw) -> f32 {
        let (mut sum, mut count) = (0.0_f64, 0.0_f64);
        for (place, line) in &self.on {
            for (shot, r) in place.shots.iter().zip(r) {
                for c in (0..3).filter(|&c| place.usable[c]) {
                    let variance = noise.variance(place.dark[c] + shot[c])
                        + r[c] * r[c] * noise.variance(place.dark[c] + line[c])
                        + (1.0 - r[c]).powi(2) * noise.variance(place.dark[c]);
                    let residual = shot[c] - r[c] * line[c];
                    sum += f64::from((residual * residual / variance).min(25.0));
                    count += 1.0;
                }
            }
        }
        (sum / f64::max(count, 1.0)).max(1.0) as f32
    }
}

/// The light of a white line: its own shot, or else the brightest of the shots, channel by channel.
fn line_light(place: &Place, white: Option<usize>) -> [f32; 3] {
    if let Some(k) = white {
        return place.shots[k].map(|light| light.max(0.0));
    }
    std::array::from_fn(|c| place.shots.iter().fold(0.0, |most, shot| shot[c].max(most)))
}
