//! Ridges of successive picture rows linked into tracks.

use super::{Ridge, join::Reach, ridge_rows::RidgeRows};

/// One line followed through the picture: its position across for each sample along it.
#[derive(Debug, Clone, PartialEq)]
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
struct Growing {
    start: usize,
    across: Vec<f32>,
    strength: Vec<f32>,
    strong: usize,
    slope: f32,
    recent: Recent,
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

/// A list with room for a line of common length.
fn started(value: f32) -> Vec<f32> {
    const ROOM: usize = 512;
    let mut values = Vec::with_capacity(ROOM);
    values.push(value);
    values
}

impl Growing {
    fn new(start: usize, ridge: &Ridge) -> Self {
        let mut recent = Recent::default();
        recent.push(&[ridge.across]);
        Self {
            start,
            across: started(ridge.across),
            strength: started(ridge.strength),
            strong: 1,
            slope: 0.0,
            recent,
        }
    }

    /// Last measured pixel along.
    fn last(&self) -> usize {
        self.start + self.across.len() - 1
    }

    /// From the mean of the last few points, since near a crossing single ones drift aside.
    fn predicted(&self, along: usize) -> f32 {
        const LAST: usize = 6;
        let last = &self.across[self.across.len().saturating_sub(LAST)..];
        let n = last.len() as f32;
        let from_mean = (along - self.last()) as f32 + 0.5 * (n - 1.0);
        last.iter().sum::<f32>() / n + self.slope * from_mean
    }

    fn push(&mut self, along: usize, ridge: &Ridge) {
        let from = self.across[self.across.len() - 1];
        let steps = along - self.last();
        for k in 1..steps {
            self.across
                .push(from + (ridge.across - from) * k as f32 / steps as f32);
            self.strength.push(0.0);
            self.recent.push(&self.across);
        }
        self.across.push(ridge.across);
        self.strength.push(ridge.strength);
        self.strong += usize::from(ridge.strong);
        self.recent.push(&self.across);
        self.slope = self.recent.slope();
    }
}

/// Gate growth per pixel of gap: the slope's uncertainty.
const GATE_PER_PX: f32 = 0.1;
/// Steepest sideways step per pixel along: 45 degrees and a little.
const STEEPEST: f32 = 1.3;

/// Links ridges into tracks; a track needs one and a half line widths of strong ridges, at least five pixels.
pub(super) fn follow(
    ridges: &RidgeRows,
    spacing_px: f64,
    width_px: f64,
    reach: &Reach,
) -> Vec<Track> {
    let fewest = ((1.5 * width_px).max(5.0) / spacing_px).ceil() as usize;
    let longest_gap = (reach.gap_px.max(1.0) / spacing_px) as usize;
    let gate = Gate {
        px: reach.gate_px as f32,
        spacing_px: spacing_px as f32,
    };
    let mut growing: Vec<Growing> = Vec::new();
    let mut done = Vec::new();
    let (mut pairs, mut track_taken, mut ridge_taken) = (Vec::new(), Vec::new(), Vec::new());
    for along in 0..ridges.len() {
        let row = ridges.row(along);
        growing.retain_mut(|track| {
            let goes_on = along - track.last() <= longest_gap + 1;
            if !goes_on {
                finish(track, (fewest, spacing_px), &mut done);
            }
            goes_on
        });
        candidates((&growing, row), along, gate, &mut pairs);
        track_taken.clear();
        track_taken.resize(growing.len(), false);
        ridge_taken.clear();
        ridge_taken.resize(row.len(), false);
        if any_conflict(&pairs, &mut ridge_taken) {
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        }
        ridge_taken.fill(false);
        for &(_, track, ridge) in &pairs {
            if !track_taken[track] && !ridge_taken[ridge] {
                (track_taken[track], ridge_taken[ridge]) = (true, true);
                growing[track].push(along, &row[ridge]);
            }
        }
        let fresh = row.iter().zip(&ridge_taken);
        growing.extend(
            fresh
                .filter(|(ridge, taken)| ridge.strong && !**taken)
                .map(|(ridge, _)| Growing::new(along, ridge)),
        );
    }
    growing
        .iter_mut()
        .for_each(|track| finish(track, (fewest, spacing_px), &mut done));
    done.sort_by(|a: &Track, b: &Track| {
        (a.start, a.across[0])
            .partial_cmp(&(b.start, b.across[0]))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    done
}

fn finish(track: &mut Growing, (fewest, spacing_px): (usize, f64), done: &mut Vec<Track>) {
    if track.strong >= fewest {
        done.push(Track {
            start: track.start,
            spacing_px,
            across: std::mem::take(&mut track.across),
            strength: std::mem::take(&mut track.strength),
        });
    }
}

/// How far beside its prediction a track's next ridge may lie.
#[derive(Debug, Clone, Copy)]
struct Gate {
    /// In the next pixel.
    px: f32,
    spacing_px: f32,
}

/// Whether two pairs share a track or a ridge; pairs come track by track. `seen` has a place for each ridge.
fn any_conflict(pairs: &[(f32, usize, usize)], seen: &mut [bool]) -> bool {
    let twice = |&(_, _, ridge): &(f32, usize, usize)| std::mem::replace(&mut seen[ridge], true);
    pairs.windows(2).any(|pair| pair[0].1 == pair[1].1) || pairs.iter().any(twice)
}

/// Tracks and ridges near each other, track by track.
fn candidates(
    (growing, row): (&[Growing], &[Ridge]),
    along: usize,
    gate: Gate,
    pairs: &mut Vec<(f32, usize, usize)>,
) {
    pairs.clear();
    for (t, track) in growing.iter().enumerate() {
        let way_px = (along - track.last()) as f32 * gate.spacing_px;
        let predicted = track.predicted(along);
        let reach = gate.px + GATE_PER_PX * (way_px - 1.0);
        let last = track.across[track.across.len() - 1];
        let first = row.partition_point(|ridge| ridge.across < predicted - reach);
        for (r, ridge) in row.iter().enumerate().skip(first) {
            if ridge.across > predicted + reach {
                break;
            }
            if (ridge.across - last).abs() <= STEEPEST * way_px + 0.5 {
                // a longer track is the better evidence when two reach for the same ridge
                let handicap = 1.0 / (1.0 + track.across.len() as f32);
                pairs.push(((ridge.across - predicted).abs() + handicap, t, r));
            }
        }
    }
}
