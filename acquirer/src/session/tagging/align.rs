//! Which pattern of the sequence a run of frames shows: by the order, with the clocks as a prior.
//!
//! Takes the runs, the times at which the projector says that each pattern was shown, and the timing; gives each run
//! its pattern or none. Patterns come in their order, so the runs are aligned to the sequence as a whole (dynamic
//! programming over runs and patterns). What costs: a pattern that no run shows, a run that shows no pattern, and times
//! that do not fit. All times may be off together by a common offset, which is found along the way and is a new
//! measurement of the latency. For each run the best alignment is compared with the best one that gives the run another
//! pattern: without a clear lead the run is not labelled. Costs are in nats. It fails quietly when the scene itself
//! changes as often as the pattern does.

use super::{
    FrameKind, LookNoise, Seen, Timing,
    ends::LabelledRuns,
    runs::{Run, find_runs},
};

/// Common offsets that are tried, in milliseconds: from minus to plus this, in these steps.
const OFFSET_RANGE_MS: f64 = 250.0;
const OFFSET_STEP_MS: f64 = 2.5;
/// Standard deviation of the common offset, and the most that it can cost: a latency that has changed is found.
const OFFSET_SIGMA_MS: f64 = 6.0;
const OFFSET_MOST: f64 = 20.0;
/// Standard deviation of what a single time can miss its range by.
const TIME_SIGMA_MS: f64 = 2.0;
/// Most that one run's times can cost: beyond that they speak no louder.
const TIME_MOST: f64 = 200.0;
/// Cost of a pattern that no run shows, where frames were lost and where none was.
const SKIPPED_IN_DOUBT: f64 = 2.0;
const SKIPPED: f64 = 6.0;
/// Cost of a run that shows no pattern of the sequence: somebody walked by.
const FOREIGN: f64 = 14.0;
/// Lead over the best other label that a label needs.
const MARGIN: f64 = 9.2;
/// Changes that must have been seen for the clocks to vouch for a frame against its look.
const LEAST_CHANGES: usize = 8;
/// Most that one run's own times may cost for its label to be believed.
const BELIEVED: f64 = 8.0;

/// What a frame shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tag {
    /// One pattern all over: 0 is what was there before the sequence, `k` its step `k - 1`.
    Shows(usize),
    /// Parts of two patterns.
    Mixed,
    /// It cannot be told.
    Unknown,
}

/// The tags of some frames, and what the changes say of the latency.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// One per frame.
    pub tags: Vec<Tag>,
    /// The kind of each frame.
    pub kinds: Vec<FrameKind>,
    /// By how much the changes came later than the timing says, in milliseconds; `None` without a labelled change.
    pub offset_ms: Option<f64>,
    /// Patterns whose begin was seen.
    pub changes: usize,
}

/// Tags frames taken while a sequence was shown.
///
/// `shown_ms` are the times at which the projector says that its steps were shown, in order and on the clock of the
/// stamps; before the first one something else was up for some frames, and the last one stays.
#[must_use]
pub fn tag_frames(
    frames: &[Seen],
    shown_ms: &[f64],
    timing: &Timing,
    noise: LookNoise,
) -> Alignment {
    let (kinds, runs) = find_runs(frames, noise, timing.frame_ms);
    let problem = Problem {
        spans: runs
            .iter()
            .map(|run| Span::of(run, frames, &kinds))
            .collect(),
        runs: &runs,
        shown_ms,
        timing,
    };
    let (labels, offset_ms) = problem.solve();
    let mut tags: Vec<Tag> = kinds
        .iter()
        .map(|kind| match kind {
            FrameKind::Mixed => Tag::Mixed,
            _ => Tag::Unknown,
        })
        .collect();
    let labelled = LabelledRuns {
        frames,
        runs: &runs,
        labels: &labels,
        noise,
    };
    for (place, label) in labels.iter().enumerate() {
        let Some(label) = *label else { continue };
        let held = if runs[place].frames.len() > 1 {
            problem.held_for(label, timing.least_band_hold_ms())
        } else {
            problem.held_for(label, timing.least_hold_ms())
        };
        let settled = runs[place].frames.iter().copied();
        let settled =
            settled.filter(|&k| problem.is_settled(label, frames[k].stamp_ms - offset_ms));
        for frame in labelled
            .pure_frames(place, label, held)
            .into_iter()
            .chain(settled)
        {
            tags[frame] = Tag::Shows(label);
        }
    }
    let changes = labels
        .iter()
        .filter(|label| label.is_some_and(|k| k > 0))
        .count();
    if changes >= LEAST_CHANGES {
        let vouched = problem.vouched(frames, &kinds, &labels, offset_ms);
        for (frame, pattern) in vouched.unwrap_or_default() {
            tags[frame] = Tag::Shows(pattern);
        }
    }
    for (frame, kind) in kinds.iter().enumerate() {
        if let FrameKind::Duplicate { of } = *kind {
            tags[frame] = tags[of];
        }
    }
    Alignment {
        tags,
        kinds,
        offset_ms: (changes > 0).then_some(offset_ms),
        changes,
    }
}

/// The stamps of a run's first and last frame, and of the mixed frames right before and after it, in milliseconds.
struct Span {
    first: f64,
    last: f64,
    mixed_before: Option<f64>,
    mixed_after: Option<f64>,
}

impl Span {
    fn of(run: &Run, frames: &[Seen], kinds: &[FrameKind]) -> Self {
        let (first, last) = (run.frames[0], run.frames[run.frames.len() - 1]);
        let mixed = |place: Option<usize>| {
            let place = place.filter(|&k| kinds.get(k) == Some(&FrameKind::Mixed));
            place.map(|k| frames[k].stamp_ms)
        };
        Self {
            first: frames[first].stamp_ms,
            last: frames[last].stamp_ms,
            mixed_before: mixed(first.checked_sub(1)),
            mixed_after: mixed(Some(last + 1)),
        }
    }
}

/// Runs to be aligned to a sequence.
struct Problem<'a> {
    runs: &'a [Run],
    spans: Vec<Span>,
    shown_ms: &'a [f64],
    timing: &'a Timing,
}

/// What alignments cost under one common offset.
struct Costs {
    least: f64,
    /// For each run, the least cost of an alignment that gives it this pattern; the last entry: none.
    by_label: Vec<Vec<f64>>,
}

impl Problem<'_> {
    /// Patterns, the one before the sequence included.
    fn patterns(&self) -> usize {
        self.shown_ms.len() + 1
    }

    /// The label of each run, where it is certain, and the common offset.
    fn solve(&self) -> (Vec<Option<usize>>, f64) {
        let steps = (OFFSET_RANGE_MS / OFFSET_STEP_MS) as i32;
        let mut best = (f64::INFINITY, 0.0);
        let mut by_label = vec![vec![f64::INFINITY; self.patterns() + 1]; self.runs.len()];
        for step in -steps..=steps {
            let offset = f64::from(step) * OFFSET_STEP_MS;
            let costs = self.costs(offset);
            if costs.least < best.0 {
                best = (costs.least, offset);
            }
            for (least, new) in by_label.iter_mut().zip(&costs.by_label) {
                for (least, new) in least.iter_mut().zip(new) {
                    *least = least.min(*new);
                }
            }
        }
        let labels = by_label.iter().enumerate();
        let labels = labels.map(|(run, costs)| self.label(run, costs, best.1));
        (labels.collect(), best.1)
    }

    fn label(&self, run: usize, costs: &[f64], offset: f64) -> Option<usize> {
        let (label, least) = argmin(costs)?;
        let others = costs.iter().enumerate().filter(|(k, _)| *k != label);
        let second = others.map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
        let certain = label < self.patterns()
            && second - least >= MARGIN
            && self.time_cost(run, label, offset) <= BELIEVED;
        certain.then_some(label)
    }

    /// Costs under one common offset, by dynamic programming forwards and backwards.
    fn costs(&self, offset: f64) -> Costs {
        let patterns = self.patterns();
        let times: Vec<Vec<f64>> = (0..self.runs.len())
            .map(|run| {
                (0..patterns)
                    .map(|k| self.time_cost(run, k, offset))
                    .collect()
            })
            .collect();
        let prior = (0.5 * (offset / OFFSET_SIGMA_MS).powi(2)).min(OFFSET_MOST);
        let forward = self.forward(&times);
        let mut behind: Vec<f64> = (0..=patterns)
            .map(|state| (patterns - state) as f64 * SKIPPED)
            .collect();
        let mut by_label = vec![Vec::new(); times.len()];
        for run in (0..times.len()).rev() {
            let (before, labelled) = &forward[run];
            let none = before.iter().zip(&behind);
            let none = none
                .map(|(a, b)| a + b + FOREIGN)
                .fold(f64::INFINITY, f64::min);
            by_label[run] = (0..patterns)
                .map(|k| labelled[k] + behind[k + 1])
                .chain([none])
                .map(|cost| cost + prior)
                .collect();
            behind = self.one_back(run, &times[run], &behind);
        }
        Costs {
            least: behind[0] + prior,
            by_label,
        }
    }

    /// For each run, the least cost of what came before it in each state, and of giving it each label.
    ///
    /// A state is the number of patterns that are over: 0 when no run is labelled yet, k + 1 when the newest labelled
    /// run shows k.
    fn forward(&self, times: &[Vec<f64>]) -> Vec<(Vec<f64>, Vec<f64>)> {
        let mut before = vec![f64::INFINITY; self.patterns() + 1];
        before[0] = 0.0;
        let mut forward = Vec::with_capacity(times.len());
        for (run, times) in times.iter().enumerate() {
            let skip = self.skip_cost(run);
            let labelled: Vec<f64> = (0..self.patterns())
                .map(|k| {
                    let states = before[..=k].iter().enumerate();
                    let costs = states.map(|(state, cost)| cost + (k - state) as f64 * skip);
                    costs.fold(f64::INFINITY, f64::min) + times[k]
                })
                .collect();
            let mut after: Vec<f64> = before.iter().map(|cost| cost + FOREIGN).collect();
            for (after, labelled) in after[1..].iter_mut().zip(&labelled) {
                *after = after.min(*labelled);
            }
            forward.push((std::mem::replace(&mut before, after), labelled));
        }
        forward
    }

    /// The least cost of a run and all behind it, from each state before it.
    fn one_back(&self, run: usize, times: &[f64], behind: &[f64]) -> Vec<f64> {
        let (patterns, skip) = (self.patterns(), self.skip_cost(run));
        (0..=patterns)
            .map(|state| {
                let labels =
                    (state..patterns).map(|k| (k - state) as f64 * skip + times[k] + behind[k + 1]);
                labels.fold(behind[state] + FOREIGN, f64::min)
            })
            .collect()
    }

    fn skip_cost(&self, run: usize) -> f64 {
        if self.runs[run].doubt_before {
            SKIPPED_IN_DOUBT
        } else {
            SKIPPED
        }
    }

    /// What the times of a run say against a pattern: its light came before the run's first frame but not before a mixed
    /// one ahead of that, and the next one's after the last frame but not after a mixed one behind it.
    fn time_cost(&self, run: usize, pattern: usize, offset: f64) -> f64 {
        let (span, timing) = (&self.spans[run], self.timing);
        let latency = timing.latency.ms + offset;
        let spread = timing.jitter.at_most() / 2.0;
        let begin = pattern.checked_sub(1).map(|k| self.shown_ms[k] + latency);
        let end = self.shown_ms.get(pattern).map(|shown| shown + latency);
        let begin_miss = begin.map_or(0.0, |lit| {
            let too_late = lit - spread + timing.exposure.at_least() - span.first;
            let mixed = span.mixed_before.unwrap_or(f64::NEG_INFINITY);
            let too_early = mixed - timing.exposure.at_most() - lit - spread;
            too_late.max(too_early)
        });
        let end_miss = end.map_or(0.0, |lit| {
            let too_early = span.last + timing.readout.at_least() - lit - spread;
            let mixed = span.mixed_after.unwrap_or(f64::INFINITY);
            let too_late = lit - spread - mixed - timing.readout.at_most();
            too_early.max(too_late)
        });
        let miss = begin_miss.max(0.0).hypot(end_miss.max(0.0));
        (0.5 * (miss / TIME_SIGMA_MS).powi(2)).min(TIME_MOST)
    }

    /// Whether the clocks vouch that a frame of this stamp shows a pattern all over.
    fn is_settled(&self, pattern: usize, stamp_ms: f64) -> bool {
        let begin = pattern.checked_sub(1).map(|k| stamp_ms - self.shown_ms[k]);
        let end = self.shown_ms.get(pattern).map(|next| stamp_ms - next);
        self.timing.is_settled(begin, end)
    }

    /// The frames that the clocks alone vouch for, with their patterns: those that stand between mixed ones, or beside lost
    /// ones, and so cannot be told by their look. `None` if the clocks are wrong for one of the frames that can.
    fn vouched(
        &self,
        frames: &[Seen],
        kinds: &[FrameKind],
        labels: &[Option<usize>],
        offset_ms: f64,
    ) -> Option<Vec<(usize, usize)>> {
        let mut told: Vec<Option<usize>> = vec![None; frames.len()];
        for (run, label) in self.runs.iter().zip(labels) {
            run.frames.iter().for_each(|&frame| told[frame] = *label);
        }
        let mut vouched = Vec::new();
        for (frame, kind) in kinds.iter().enumerate() {
            let pattern = self.settled_pattern(frames[frame].stamp_ms - offset_ms);
            let Some(pattern) = pattern.filter(|_| !matches!(kind, FrameKind::Duplicate { .. }))
            else {
                continue;
            };
            // a frame that is not like the whole ones of a pattern does not show it
            if labels.contains(&Some(pattern)) && told[frame] != Some(pattern) {
                return None;
            }
            if matches!(kind, FrameKind::Mixed | FrameKind::Unsure) {
                // nor do two that are not alike
                if vouched.last().is_some_and(|(_, other)| *other == pattern) {
                    return None;
                }
                vouched.push((frame, pattern));
            }
        }
        Some(vouched)
    }

    /// The pattern that the clocks vouch for at this stamp, if they do for one.
    fn settled_pattern(&self, stamp_ms: f64) -> Option<usize> {
        let newest = self.shown_ms.partition_point(|shown| *shown <= stamp_ms);
        (0..=newest).rev().find(|&k| self.is_settled(k, stamp_ms))
    }

    /// Whether the pattern and those beside it were up for so long, in milliseconds.
    fn held_for(&self, pattern: usize, least_ms: f64) -> bool {
        let changes = pattern.saturating_sub(2)..(pattern + 2).min(self.shown_ms.len());
        self.shown_ms[changes]
            .windows(2)
            .all(|pair| pair[1] - pair[0] >= least_ms)
    }
}

fn argmin(costs: &[f64]) -> Option<(usize, f64)> {
    let costs = costs.iter().copied().enumerate();
    costs.min_by(|a, b| a.1.total_cmp(&b.1))
}
