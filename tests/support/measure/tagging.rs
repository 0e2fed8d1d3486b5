//! Tagging against known truth: a projector and a camera reduced to bands of light.
//!
//! Takes the conditions of a rig, gives how often a frame was given a pattern that it does not show, and how long a
//! pattern took. The model has what makes tagging hard and nothing else: a display latency with jitter, a refresh that
//! is not the camera's, clocks that are related with an error, exposure and rolling read-out, noise, frames that are
//! lost or given twice, and patterns that differ little: a unary grid in sixteen colours, the coded grid, black and
//! white, each band with surfaces of its own. Everything goes as in the product: the timing by flashes first, then a
//! recording (black, white, coded and unary grid, several frames each), then the trial of sixteen colours, again and
//! again for those patterns of which too few frames could be told.

mod random;
mod scene;

use acquirer::session::tagging::{
    BANDS, Band, Flash, FrameKind, Look, LookNoise, Seen, Tag, Timing, begin_seen, find_timing,
    tag_frames,
};
use random::Random;
use scene::Scene;

/// Rows of a band whose exposures are followed.
const ROWS: usize = 2;
/// Share of foreign light in a band from which a tagged frame counts as mislabelled.
const FOREIGN_SHARE: f64 = 0.10;
/// Error of the relation between the clocks and of a stamp, at most, in milliseconds.
const CLOCK_ERROR_MS: f64 = 1.0;
const STAMP_ERROR_MS: f64 = 0.5;
/// Black/white flashes for the timing.
const FLASHES: usize = 16;
/// Frames of black and white, of the grids, and of a colour on trial, as the programs take them by default.
const RECORDED: [usize; 4] = [3, 3, 2, 2];
const REFERENCES: usize = 2;
/// Passes over the patterns before one counts as not told.
const PASSES: usize = 12;

/// The conditions of a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaggingRig {
    /// Projector refreshes and camera frames per second.
    pub projector_hz: f64,
    /// Camera frames per second.
    pub camera_hz: f64,
    /// Display latency in milliseconds.
    pub latency_ms: f64,
    /// Width of its spread in milliseconds.
    pub jitter_ms: f64,
    /// From the first row to the last, in milliseconds; no longer than a frame.
    pub readout_ms: f64,
    /// Exposure of a row, in milliseconds; no longer than a frame.
    pub exposure_ms: f64,
    /// Probability that a frame is lost, and that a frame which is not is given twice in place of the next.
    pub loss: f64,
}

/// What became of the recordings and trials of some rigs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TaggingScore {
    /// Frames seen while patterns were recorded.
    pub frames: usize,
    /// Frames that were given a pattern.
    pub accepted: usize,
    /// Frames that were given a pattern which they do not show all over.
    pub mislabelled: usize,
    /// Patterns asked for.
    pub patterns: usize,
    /// Patterns of which no frame could be told, after all passes.
    pub untold: usize,
    /// Frames asked for beyond the first of each pattern.
    pub repeats: usize,
    /// Camera frame times from the first pattern's light to the last frame needed, all passes together.
    pub frame_times: f64,
    /// Rigs.
    pub rigs: usize,
    /// Rigs whose timing could not be measured.
    pub timeless: usize,
    /// Error of the measured latency, in milliseconds, summed without sign.
    pub latency_error_ms: f64,
}

impl TaggingScore {
    /// Camera frames for one change of the pattern, all passes and losses included, repeats left out.
    #[must_use]
    pub fn frames_per_change(&self) -> f64 {
        (self.frame_times - self.repeats as f64) / self.patterns.max(1) as f64
    }

    /// Adds another recording's.
    pub fn add(&mut self, other: &Self) {
        self.frames += other.frames;
        self.accepted += other.accepted;
        self.mislabelled += other.mislabelled;
        self.patterns += other.patterns;
        self.untold += other.untold;
        self.repeats += other.repeats;
        self.frame_times += other.frame_times;
        self.rigs += other.rigs;
        self.timeless += other.timeless;
        self.latency_error_ms += other.latency_error_ms;
    }
}

/// A rig at work.
struct Simulation {
    rig: TaggingRig,
    random: Random,
    scene: Scene,
    /// When which pattern became light, in milliseconds.
    light: Vec<(f64, usize)>,
    /// The camera's first exposure.
    phase_ms: f64,
    /// Error of the relation between the clocks.
    clock_error_ms: f64,
}

/// A frame with the truth about it.
struct Truth {
    seen: Seen,
    /// The pattern it shows all over.
    shows: Option<usize>,
}

/// Black, white, the coded grid and the sixteen unary grids, in the order in which they are shown.
const BLACK: usize = 0;
const WHITE: usize = 1;
const CODED: usize = 2;

impl TaggingRig {
    /// A rig with these rates and losses and everything else by chance: latency to 300 ms, jitter to 30 ms, read-out to
    /// 30 ms or a frame, exposure from 2 ms to half a frame.
    #[must_use]
    pub fn by_chance(projector_hz: f64, camera_hz: f64, loss: f64, seed: u64) -> Self {
        let mut random = Random(seed);
        let frame_ms = 1000.0 / camera_hz;
        Self {
            projector_hz,
            camera_hz,
            latency_ms: random.within(0.0, 300.0),
            jitter_ms: random.within(0.0, 30.0),
            readout_ms: random.within(0.0, frame_ms.min(30.0)),
            exposure_ms: random.within(2.0, frame_ms / 2.0),
            loss,
        }
    }
}

/// Makes a recording and a trial of colours with this rig; gives what became of each.
#[must_use]
pub fn score_tagging(rig: TaggingRig, seed: u64) -> [TaggingScore; 2] {
    let mut simulation = Simulation::new(rig, seed);
    let none = TaggingScore::default();
    let Some((timing, noise, mut now)) = simulation.measure_timing() else {
        let timeless = TaggingScore {
            rigs: 1,
            timeless: 1,
            ..none
        };
        return [timeless, none];
    };
    let unary = simulation.scene.white_unary;
    let recording = [BLACK, WHITE, CODED, unary].into_iter().zip(RECORDED);
    let colours = (CODED + 1)..simulation.scene.patterns.len();
    let trial = [BLACK, WHITE].map(|k| (k, REFERENCES)).into_iter();
    let trial = trial.chain(colours.map(|k| (k, 1)));
    let tasks: [Vec<(usize, usize)>; 2] = [recording.collect(), trial.collect()];
    let mut scores = tasks.map(|shots| simulation.take(&shots, (&timing, noise), &mut now));
    scores[0].rigs = 1;
    scores[0].latency_error_ms = (timing.latency.ms - rig.latency_ms).abs();
    scores
}

impl Simulation {
    fn new(rig: TaggingRig, seed: u64) -> Self {
        let mut random = Random(seed);
        Self {
            scene: Scene::new(&mut random),
            phase_ms: random.within(0.0, 1000.0 / rig.camera_hz),
            clock_error_ms: random.within(-CLOCK_ERROR_MS, CLOCK_ERROR_MS),
            light: vec![(f64::NEG_INFINITY, BLACK)],
            random,
            rig,
        }
    }

    /// Takes so many frames of each pattern, in passes.
    fn take(
        &mut self,
        shots: &[(usize, usize)],
        (timing, noise): (&Timing, LookNoise),
        now: &mut f64,
    ) -> TaggingScore {
        let mut score = TaggingScore {
            patterns: shots.len(),
            repeats: shots.iter().map(|(_, count)| count - 1).sum(),
            ..TaggingScore::default()
        };
        let mut missing = shots.to_vec();
        for pass in 0..PASSES {
            if missing.is_empty() {
                break;
            }
            let after = (&timing.after_failures(pass), noise.after_failures(pass));
            missing = self.pass((&missing, pass), after, now, &mut score);
        }
        score.untold = missing.len();
        score
    }

    /// Shows patterns once; gives those of which too few frames could be told.
    fn pass(
        &mut self,
        (missing, pass): (&[(usize, usize)], usize),
        (timing, noise): (&Timing, LookNoise),
        now: &mut f64,
        score: &mut TaggingScore,
    ) -> Vec<(usize, usize)> {
        let before = self.up();
        let mut shots = missing.to_vec();
        if !begin_seen(&mut shots, |shot| shot.0 == before) {
            shots.insert(0, (if before == BLACK { WHITE } else { BLACK }, 0));
        }
        let hold_ms = |count: usize| (timing.hold_frames(count) + pass) as f64 * timing.frame_ms;
        let steps: Vec<(usize, f64)> = shots.iter().map(|&(k, n)| (k, hold_ms(n))).collect();
        let wanted = shots.iter().map(|shot| shot.1).filter(|&count| count > 0);
        let whole = wanted.min().unwrap_or(1);
        let so_far = self.frames(*now - 3.0 * hold_ms(1), *now);
        let stamp_ms = so_far.last().map_or(*now, |frame| frame.seen.stamp_ms);
        let (_, shown) = self.show(&steps, timing.begin_ms(*now, stamp_ms, whole));
        let first_light = shown[0] + self.rig.latency_ms;
        let last_hold = steps[steps.len() - 1].1;
        let end = shown[shown.len() - 1] + timing.settled_ms() + last_hold + 3.0 * hold_ms(1);
        let frames = self.frames(*now - 3.0 * hold_ms(1), end);
        let seen: Vec<Seen> = frames.iter().map(|frame| frame.seen.clone()).collect();
        let alignment = tag_frames(&seen, &shown, timing, noise);
        let mut last_needed = first_light;
        let mut told = vec![0; shots.len()];
        for (k, frame) in frames.iter().enumerate() {
            score.frames += 1;
            let Tag::Shows(step) = alignment.tags[k] else {
                continue;
            };
            score.accepted += 1;
            let pattern = step.checked_sub(1).map_or(before, |k| shots[k].0);
            score.mislabelled += usize::from(frame.shows != Some(pattern));
            let fresh = !matches!(alignment.kinds[k], FrameKind::Duplicate { .. });
            if let Some(step) = step.checked_sub(1).filter(|_| fresh) {
                told[step] += 1;
                if told[step] <= shots[step].1 {
                    last_needed = last_needed.max(frame.seen.stamp_ms);
                }
            }
        }
        let left: Vec<(usize, usize)> = (0..shots.len())
            .filter(|&k| told[k] < shots[k].1)
            .map(|k| shots[k])
            .collect();
        let whole_pass = shown[shown.len() - 1] + last_hold + self.rig.latency_ms;
        let used = if left.is_empty() {
            last_needed
        } else {
            whole_pass
        };
        score.frame_times += (used - first_light) / timing.frame_ms;
        *now = end + 4.0 * hold_ms(1);
        left
    }

    fn frame_ms(&self) -> f64 {
        1000.0 / self.rig.camera_hz
    }

    /// The pattern that is up, or will be once its light has come.
    fn up(&self) -> usize {
        self.light.last().map_or(BLACK, |light| light.1)
    }

    /// Has patterns shown, each for its time, the first one due at a time of the camera's clock; gives when each was due
    /// and when the projector says that it was shown.
    fn show(&mut self, steps: &[(usize, f64)], begin: f64) -> (Vec<f64>, Vec<f64>) {
        let refresh = 1000.0 / self.rig.projector_hz;
        let (mut due, mut dues) = (begin, Vec::new());
        let mut shown = Vec::new();
        for &(pattern, hold) in steps {
            let presented = ((due - self.clock_error_ms) / refresh).ceil() * refresh;
            let spread = self.random.within(-0.5, 0.5) * self.rig.jitter_ms;
            let last = self.light.last().map_or(f64::NEG_INFINITY, |light| light.0);
            let lit = (presented + self.rig.latency_ms + spread).max(last);
            self.light.push((lit, pattern));
            shown.push(presented + self.clock_error_ms);
            dues.push(due);
            due += hold;
        }
        (dues, shown)
    }

    /// The frames that the camera gives between two times.
    fn frames(&mut self, from: f64, to: f64) -> Vec<Truth> {
        let frame_ms = self.frame_ms();
        let first = ((from - self.phase_ms) / frame_ms).ceil() as i64;
        let last = ((to - self.phase_ms) / frame_ms).floor() as i64;
        let (mut frames, mut lost) = (Vec::new(), false);
        let mut before: Option<(Look, Option<usize>)> = None;
        for k in first..=last {
            if self.random.uniform() < self.rig.loss {
                // the driver does not always tell
                lost |= self.random.uniform() < 0.5;
                continue;
            }
            let end = self.phase_ms + k as f64 * frame_ms;
            let again = self.random.uniform() < self.rig.loss;
            let (look, shows) = match before.clone().filter(|_| again) {
                Some(earlier) => earlier,
                None => self.expose(end),
            };
            before = Some((look.clone(), shows));
            let error = self.random.within(-STAMP_ERROR_MS, STAMP_ERROR_MS);
            frames.push(Truth {
                seen: Seen {
                    stamp_ms: end + error,
                    after_loss: std::mem::take(&mut lost),
                    look,
                },
                shows,
            });
        }
        frames
    }

    /// A frame whose first row's exposure ends at a moment, and the pattern it shows all over.
    fn expose(&mut self, end: f64) -> (Look, Option<usize>) {
        let mut whole: Option<Option<usize>> = None;
        let bands: Vec<Band> = (0..BANDS)
            .map(|band| {
                let mut shares = vec![0.0; self.scene.patterns.len()];
                for row in 0..ROWS {
                    let place = (row as f64 + 0.5) / ROWS as f64;
                    let down = (band as f64 + place) / BANDS as f64;
                    let end = end + down * self.rig.readout_ms;
                    self.add_light(end, &mut shares);
                }
                let most = (0..shares.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
                let pure = most.filter(|&k| shares[k] >= 1.0 - FOREIGN_SHARE);
                whole = match whole {
                    None => Some(pure),
                    Some(others) if others == pure => Some(pure),
                    Some(_) => Some(None),
                };
                self.scene.band(band, &shares, &mut self.random)
            })
            .collect();
        (Look::from_bands(bands), whole.flatten())
    }

    /// Adds the share of a row's exposure under each pattern.
    fn add_light(&self, end: f64, shares: &mut [f64]) {
        let begin = end - self.rig.exposure_ms;
        for (k, &(lit, pattern)) in self.light.iter().enumerate() {
            let until = self.light.get(k + 1).map_or(f64::INFINITY, |next| next.0);
            let overlap = until.min(end) - lit.max(begin);
            if overlap > 0.0 {
                shares[pattern] += overlap / self.rig.exposure_ms / ROWS as f64;
            }
        }
    }

    /// Black and white held, then flashes: the timing, the noise, and when that ended.
    fn measure_timing(&mut self) -> Option<(Timing, LookNoise, f64)> {
        let frame_ms = self.frame_ms();
        let settle = 600.0 + 12.0 * frame_ms;
        self.show(&[(WHITE, settle), (BLACK, settle)], 0.0);
        let white = self.settled(settle - 60.0);
        let black = self.settled(2.0 * settle - 60.0);
        let noise = LookNoise::of(&black, &white);
        let least = (3.0 * frame_ms).max(100.0);
        let steps: Vec<(usize, f64)> = (0..FLASHES)
            .map(|k| {
                let hold = least + self.random.within(0.0, 3.0) * frame_ms;
                (if k % 2 == 0 { WHITE } else { BLACK }, hold)
            })
            .collect();
        let begin = 2.0 * settle + 100.0;
        let (due, shown) = self.show(&steps, begin);
        let end = shown[FLASHES - 1] + 800.0;
        let flashes = (0..FLASHES).map(|k| Flash {
            shown_ms: shown[k],
            due_ms: due[k],
            white: steps[k].0 == WHITE,
        });
        let flashes: Vec<Flash> = flashes.collect();
        let frames = self.frames(begin - 300.0, end);
        let (black, white) = (black.last()?, white.last()?);
        let mut last: Option<&Look> = None;
        let fresh = frames
            .iter()
            .filter(|frame| last.replace(&frame.seen.look) != Some(&frame.seen.look));
        let shares = fresh.map(|frame| {
            let share = frame.seen.look.share(black, white, 2.0);
            (frame.seen.stamp_ms, share)
        });
        let timing = find_timing(&flashes, &shares.collect::<Vec<_>>(), frame_ms)?;
        Some((timing, noise, end + 500.0))
    }

    /// Some different frames up to a moment.
    fn settled(&mut self, until: f64) -> Vec<Look> {
        let frames = self.frames(until - 8.0 * self.frame_ms(), until);
        let mut looks: Vec<Look> = frames.into_iter().map(|frame| frame.seen.look).collect();
        looks.dedup();
        looks
    }
}
