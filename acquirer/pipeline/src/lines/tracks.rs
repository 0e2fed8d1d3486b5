//! Ridges of successive picture rows linked into tracks.

use super::{Ridge, join::Reach, ridge_rows::RidgeRows};

/// One line followed through the picture: its position across for each sample along it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Track {
    /// Number of the first sample; sample 0 is the picture's first.
    pub start: usize,
    /// From sample to sample, in camera pixels.
    pub spacing_px: f64,
    /// Position across, camera pixels, edge coordinates, one per sample; interpolated where not measured.
    pub across: Vec<f32>,
    /// Strength of the ridge; 0 where the position is interpolated over a gap.
    pub strength: Vec<f32>,
}

impl Track {
    /// Becomes another one, with room for as many samples as that has.
    pub(super) fn copy_from(&mut self, other: &Self) {
        (self.start, self.spacing_px) = (other.start, other.spacing_px);
        for (list, others) in [
            (&mut self.across, &other.across),
            (&mut self.strength, &other.strength),
        ] {
            list.clear();
            list.reserve(others.capacity());
            list.extend_from_slice(others);
        }
    }

    /// One past the last sample.
    #[must_use]
    pub fn end(&self) -> usize {
        self.start + self.across.len()
    }

    /// Stretch along the line, in camera pixels, edge coordinates.
    #[must_use]
    pub fn stretch_px(&self) -> (f64, f64) {
        let edge = |sample: usize| sample as f64 * self.spacing_px;
        (edge(self.start), edge(self.end()))
    }

    /// Position along of the k-th sample, in camera pixels, edge coordinates.
    #[must_use]
    pub fn along(&self, k: usize) -> f64 {
        ((self.start + k) as f64 + 0.5) * self.spacing_px
    }

    /// The samples that were measured between two positions along: their numbers, from [`Self::start`].
    pub fn measured(&self, from_px: f64, to_px: f64) -> impl Iterator<Item = usize> + '_ {
        let number = |px: f64| (px / self.spacing_px - 0.5 - self.start as f64).max(0.0);
        let first = (number(from_px).ceil() as usize).min(self.across.len());
        let end = if to_px < self.along(0) {
            first
        } else {
            (number(to_px).floor() as usize + 1).clamp(first, self.across.len())
        };
        (first..end).filter(|&k| self.strength[k] > 0.0)
    }

    /// Position across at a position along, both in camera pixels, linear between samples; up to `beyond_px` past
    /// the ends the line goes on straight.
    #[must_use]
    pub fn at(&self, along: f64, beyond_px: f64) -> Option<f64> {
        let from_first = along / self.spacing_px - 0.5 - self.start as f64;
        let last = (self.across.len() - 1) as f64;
        let beyond = beyond_px / self.spacing_px;
        if !(-beyond..=last + beyond).contains(&from_first) {
            return None;
        }
        if from_first < 0.0 || from_first > last {
            let end = from_first.clamp(0.0, last);
            let way_px = (from_first - end) * self.spacing_px;
            return Some(self.value(end) + self.slope_around(end as usize) * way_px);
        }
        Some(self.value(from_first))
    }

    /// Range of positions across.
    #[must_use]
    pub fn span(&self) -> (f32, f32) {
        let fold = |(low, high): (f32, f32), &v: &f32| (low.min(v), high.max(v));
        self.across.iter().fold((f32::MAX, f32::MIN), fold)
    }

    /// Across per pixel along, from some points on either side of a position along.
    #[must_use]
    pub fn slope(&self, along: f64) -> f64 {
        self.slope_around((along / self.spacing_px - self.start as f64).max(0.0) as usize)
    }

    fn slope_around(&self, middle: usize) -> f64 {
        const REACH: usize = 10;
        let high = (middle + REACH).min(self.across.len() - 1);
        let low = middle.min(high).saturating_sub(REACH);
        if high == low {
            return 0.0;
        }
        f64::from(self.across[high] - self.across[low]) / ((high - low) as f64 * self.spacing_px)
    }

    fn value(&self, from_first: f64) -> f64 {
        let k = (from_first as usize).min(self.across.len() - 1);
        let next = (k + 1).min(self.across.len() - 1);
        let (a, b) = (f64::from(self.across[k]), f64::from(self.across[next]));
        a + (from_first - k as f64) * (b - a)
    }
}

/// A track that may still grow.
#[derive(Debug, Default)]
struct Growing {
    track: Track,
    strong: usize,
    slope: f32,
    recent: Recent,
    /// Number of its last ridge among those of its sample.
    place: usize,
}

/// Sums over the last points of a track, for their least-squares slope.
#[derive(Debug, Clone, Copy, Default)]
struct Recent {
    points: usize,
    /// Sum of the positions across.
    sum: f64,
    /// Sum of the positions across, each times its number from 0.
    moment: f64,
}

impl Recent {
    const MOST: usize = 24;

    /// Takes in the last of a track's positions; the oldest one drops out when there are enough.
    fn push(&mut self, across: &[f32]) {
        let newest = across.last().map_or(0.0, |&x| f64::from(x));
        if self.points == Self::MOST {
            let oldest = f64::from(across[across.len() - 1 - Self::MOST]);
            self.sum -= oldest;
            self.moment -= self.sum;
            self.points -= 1;
        }
        self.moment += self.points as f64 * newest;
        self.sum += newest;
        self.points += 1;
    }

    /// Across per sample; 0 until there are enough points.
    fn slope(&self) -> f32 {
        const FEWEST: usize = 4;
        if self.points < FEWEST {
            return 0.0;
        }
        let n = self.points as f64;
        let top = self.moment - 0.5 * (n - 1.0) * self.sum;
        (12.0 * top / (n * (n * n - 1.0))) as f32
    }
}

impl Growing {
    /// Begins anew at a ridge; no line has more than so many samples.
    fn begin(&mut self, start: usize, ridge: &Ridge, (spacing_px, most): (f64, usize)) {
        let track = &mut self.track;
        (track.start, track.spacing_px) = (start, spacing_px);
        for (list, value) in [
            (&mut track.across, ridge.across),
            (&mut track.strength, ridge.strength),
        ] {
            list.clear();
            list.reserve(most); // it may have been a shorter line in the frame before
            list.push(value);
        }
        (self.strong, self.slope) = (1, 0.0);
        self.recent = Recent::default();
        self.recent.push(&[ridge.across]);
    }

    /// Last measured pixel along.
    fn last(&self) -> usize {
        self.track.end() - 1
    }

    /// From the mean of the last few points, since near a crossing single ones drift aside.
    fn predicted(&self, along: usize) -> f32 {
        const LAST: usize = 6;
        let across = &self.track.across;
        let last = &across[across.len().saturating_sub(LAST)..];
        let n = last.len() as f32;
        let from_mean = (along - self.last()) as f32 + 0.5 * (n - 1.0);
        last.iter().sum::<f32>() / n + self.slope * from_mean
    }

    fn push(&mut self, along: usize, ridge: &Ridge) {
        let steps = along - self.last();
        let Track {
            across, strength, ..
        } = &mut self.track;
        let from = across[across.len() - 1];
        for k in 1..steps {
            across.push(from + (ridge.across - from) * k as f32 / steps as f32);
            strength.push(0.0);
            self.recent.push(across);
        }
        across.push(ridge.across);
        strength.push(ridge.strength);
        self.strong += usize::from(ridge.strong);
        self.recent.push(across);
        self.slope = self.recent.slope();
    }
}

/// Gate growth per pixel of gap: the slope's uncertainty.
const GATE_PER_PX: f32 = 0.1;
/// Steepest sideways step per pixel along: 45 degrees and a little.
const STEEPEST: f32 = 1.3;

/// Tracks and what following them takes, kept between frames.
#[derive(Debug, Default)]
pub(super) struct Followed {
    /// In the order in which they began; beyond `count` those of earlier frames.
    begun: Vec<Growing>,
    count: usize,
    /// Those that may still grow.
    growing: Vec<usize>,
    /// Those that are long enough, in the order of their first point (along, then across).
    done: Vec<usize>,
    pairs: Vec<(f32, usize, usize)>,
    track_taken: Vec<bool>,
    ridge_taken: Vec<bool>,
}

impl Followed {
    /// How many tracks there are.
    pub(super) fn len(&self) -> usize {
        self.done.len()
    }

    /// The tracks in the order of their first point (along, then across).
    pub(super) fn tracks(&self) -> impl Iterator<Item = &Track> {
        self.done.iter().map(|&k| &self.begun[k].track)
    }

    /// The k-th of them.
    pub(super) fn track(&self, k: usize) -> &Track {
        &self.begun[self.done[k]].track
    }

    fn begin(&mut self, along: usize, (place, ridge): (usize, &Ridge), size: (f64, usize)) {
        if self.count == self.begun.len() {
            self.begun.push(Growing::default());
        }
        self.begun[self.count].place = place;
        self.begun[self.count].begin(along, ridge, size);
        self.growing.push(self.count);
        self.count += 1;
    }

    /// Links ridges into tracks; a track needs one and a half line widths of strong ridges, at least five pixels.
    pub(super) fn follow(
        &mut self,
        ridges: &RidgeRows,
        spacing_px: f64,
        width_px: f64,
        reach: &Reach,
    ) {
        let fewest = ((1.5 * width_px).max(5.0) / spacing_px).ceil() as usize;
        let longest_gap = (reach.gap_px.max(1.0) / spacing_px) as usize;
        let gate = Gate {
            px: reach.gate_px as f32,
            spacing_px: spacing_px as f32,
        };
        self.count = 0;
        self.growing.clear();
        self.done.clear();
        for along in 0..ridges.len() {
            let row = ridges.row(along);
            self.finish(|track| along - track.last() > longest_gap + 1, fewest);
            self.grow(row, along, gate);
            for (k, ridge) in row.iter().enumerate() {
                if ridge.strong && !self.ridge_taken[k] {
                    self.begin(along, (k, ridge), (spacing_px, ridges.len()));
                }
            }
        }
        self.finish(|_| true, fewest);
        let begun = &self.begun;
        let first = |k: usize| (begun[k].track.start, begun[k].track.across[0]);
        self.done.sort_unstable_by(|&a, &b| {
            let order = first(a).partial_cmp(&first(b));
            order.unwrap_or(std::cmp::Ordering::Equal).then(a.cmp(&b))
        });
    }

    /// Ends the tracks that `ends` tells; those with enough strong ridges are done.
    fn finish(&mut self, ends: impl Fn(&Growing) -> bool, fewest: usize) {
        let Self {
            begun,
            growing,
            done,
            ..
        } = self;
        growing.retain(|&k| {
            let ended = ends(&begun[k]);
            if ended && begun[k].strong >= fewest {
                done.push(k);
            }
            !ended
        });
    }

    /// Gives the ridges of one sample along to the tracks that they continue.
    fn grow(&mut self, row: &[Ridge], along: usize, gate: Gate) {
        self.find_candidates(row, along, gate);
        let Self {
            begun,
            growing,
            pairs,
            track_taken,
            ridge_taken,
            ..
        } = self;
        track_taken.clear();
        track_taken.resize(growing.len(), false);
        ridge_taken.clear();
        ridge_taken.resize(row.len(), false);
        if any_conflict(pairs, ridge_taken) {
            pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        }
        ridge_taken.fill(false);
        for &(_, track, ridge) in &*pairs {
            if !track_taken[track] && !ridge_taken[ridge] {
                (track_taken[track], ridge_taken[ridge]) = (true, true);
                let track = &mut begun[growing[track]];
                track.push(along, &row[ridge]);
                track.place = ridge;
            }
        }
    }

    /// Notes tracks and ridges near each other, track by track.
    fn find_candidates(&mut self, row: &[Ridge], along: usize, gate: Gate) {
        self.pairs.clear();
        for (t, &k) in self.growing.iter().enumerate() {
            let growing = &self.begun[k];
            let way_px = (along - growing.last()) as f32 * gate.spacing_px;
            let predicted = growing.predicted(along);
            let reach = gate.px + GATE_PER_PX * (way_px - 1.0);
            let across = &growing.track.across;
            let last = across[across.len() - 1];
            let first = first_from(row, predicted - reach, growing.place);
            for (r, ridge) in row.iter().enumerate().skip(first) {
                if ridge.across > predicted + reach {
                    break;
                }
                if (ridge.across - last).abs() <= STEEPEST * way_px + 0.5 {
                    // a longer track is the better evidence when two reach for the same ridge
                    let handicap = 1.0 / (1.0 + across.len() as f32);
                    self.pairs
                        .push(((ridge.across - predicted).abs() + handicap, t, r));
                }
            }
        }
    }
}

/// How far beside its prediction a track's next ridge may lie.
#[derive(Debug, Clone, Copy)]
struct Gate {
    /// In the next pixel.
    px: f32,
    spacing_px: f32,
}

/// Number of the first ridge from a position on; it is looked for from `near` on.
fn first_from(row: &[Ridge], across: f32, near: usize) -> usize {
    let mut first = near.min(row.len());
    while first > 0 && row[first - 1].across >= across {
        first -= 1;
    }
    while first < row.len() && row[first].across < across {
        first += 1;
    }
    first
}

/// Whether two pairs share a track or a ridge; pairs come track by track. `seen` has a place for each ridge.
fn any_conflict(pairs: &[(f32, usize, usize)], seen: &mut [bool]) -> bool {
    let twice = |&(_, _, ridge): &(f32, usize, usize)| std::mem::replace(&mut seen[ridge], true);
    pairs.windows(2).any(|pair| pair[0].1 == pair[1].1) || pairs.iter().any(twice)
}
