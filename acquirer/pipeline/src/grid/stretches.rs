//! The followed lines with their numbers.
//!
//! Takes the tracks and the crossings that were placed on them, gives each track as [`LineTrack`]s of one line
//! number each, a point for every camera pixel along it. Between two crossings of one number every point has it, unless a crossing between them has the wrong
//! colour; beyond the last and between different numbers none has. Smoothing along a line carries its ridge on over its end; what has faded there is left out.
//! A line that another one takes over between two crossings of equal numbers keeps the number quietly.

use std::ops::Range;

use bumpalo::{Bump, collections::Vec as BumpVec};
use shared::{geometry::CameraPixel, pattern::Axis};

use super::{DecodedCrossing, DropReason, LinePoint, LineTrack, find::Outcome};
use crate::{
    crossings::Crossings,
    lines::{Family, Track},
    spare::Spare,
};

/// Where a line ends its ridge has half the strength that it has inside; with this share it is inside by about half
/// the standard deviation of all blur along the line.
const FADED_SHARE: f32 = 0.7;

/// Points on the inside that an end's strength is compared with.
const INSIDE: usize = 8;

/// A crossing on a track that says something about its number.
#[derive(Debug, Clone, Copy)]
struct Known {
    along: f64,
    /// The number; `None` where the colour contradicts.
    line: Option<u16>,
    half_width_px: f64,
    confidence: f64,
}

/// Writes stretches one after the other, in the memory of those of the frame before.
pub(super) struct Stretches<'a> {
    all: &'a mut std::vec::Vec<LineTrack>,
    spare: &'a mut Spare<LineTrack>,
    count: usize,
}

impl<'a> Stretches<'a> {
    pub(super) fn new(
        all: &'a mut std::vec::Vec<LineTrack>,
        spare: &'a mut Spare<LineTrack>,
    ) -> Self {
        Self {
            all,
            spare,
            count: 0,
        }
    }

    /// A new stretch without points; it will have no more than `most`.
    fn begin(&mut self, axis: Axis, line: Option<u16>, most: usize) {
        if self.count == self.all.len() {
            self.spare.resize(self.all, self.count + 1);
        }
        let stretch = &mut self.all[self.count];
        self.count += 1;
        (stretch.axis, stretch.line) = (axis, line);
        stretch.points.clear();
        stretch.points.reserve(most); // it may have been a shorter one in the frame before
    }

    /// The stretch that was begun last.
    fn last(&mut self) -> &mut LineTrack {
        &mut self.all[self.count - 1]
    }

    /// Leaves out what the frame before had more.
    pub(super) fn end(self) {
        self.spare.resize(self.all, self.count);
    }
}

/// The tracks of the picture's `family`, which are the pattern's lines of direction `axis`, cut where their number
/// changes between two crossings.
pub(super) fn find_stretches(
    (family, axis): (Axis, Axis),
    lines: &Family,
    (crossings, outcome): (&Crossings, &[Outcome]),
    bump: &Bump,
    stretches: &mut Stretches<'_>,
) {
    let mut known = BumpVec::new_in(bump);
    for (track, on) in lines.tracks.iter().zip(crossings.on(family)) {
        let of_crossing = on.iter().filter_map(|&k| {
            let along = crossings.all[k].along(family);
            match &outcome[k] {
                Ok(crossing) => Some(Known {
                    along,
                    line: Some(crossing.index.line(axis)),
                    half_width_px: half_width(crossing, axis),
                    confidence: crossing.confidence,
                }),
                Err(DropReason::AmbiguousColour) => Some(Known {
                    along,
                    line: None,
                    half_width_px: 0.0,
                    confidence: 0.0,
                }),
                Err(_) => None,
            }
        });
        known.clear();
        known.extend(of_crossing);
        let half_width_px = 0.5 * lines.width_px;
        cut(track, (family, axis), &known, half_width_px, stretches);
    }
}

/// One track as stretches of one line number each.
fn cut(
    track: &Track,
    (family, axis): (Axis, Axis),
    known: &[Known],
    half_width_px: f64,
    stretches: &mut Stretches<'_>,
) {
    let most = (track.across.capacity() as f64 * track.spacing_px).ceil() as usize;
    let mut next = 0;
    // the line of the stretch that was written last
    let mut open = None;
    for run in unfaded(&track.strength) {
        let mut pixels = pixels_along(track, &run);
        while !pixels.is_empty() {
            let first = pixels.start as f64 + 0.5;
            next += known[next..].iter().take_while(|k| k.along < first).count();
            let before = next.checked_sub(1).map(|k| known[k]);
            let (after, end) = match known.get(next) {
                // the first pixel behind it lies between the next two
                Some(k) => (
                    Some(*k),
                    ((k.along - 0.5).floor() as i64 + 1).min(pixels.end),
                ),
                None => (None, pixels.end),
            };
            let around = Between::new((before, after), half_width_px);
            if open != Some(around.line) {
                open = Some(around.line);
                stretches.begin(axis, around.line, most);
            }
            let places = every_pixel(track, &run, pixels.start..end);
            let points = places.map(|(along, across)| LinePoint {
                position: match family {
                    Axis::Row => CameraPixel::new(along, across),
                    Axis::Column => CameraPixel::new(across, along),
                },
                half_width_px: around.half_width_px(along),
                confidence: around.confidence,
            });
            stretches.last().points.extend(points);
            pixels.start = end;
        }
    }
}

/// What holds between two crossings that say something about a line's number.
struct Between {
    line: Option<u16>,
    confidence: f64,
    /// A position along, half the line's width there, and by how much that grows per pixel.
    width: (f64, f64, f64),
}

impl Between {
    fn new(around: (Option<Known>, Option<Known>), half_width_px: f64) -> Self {
        match around {
            (Some(a), Some(b)) if a.line.is_some() && a.line == b.line => {
                let way = (b.along - a.along).max(1e-9);
                let growth = (b.half_width_px - a.half_width_px) / way;
                Self {
                    line: a.line,
                    confidence: a.confidence.min(b.confidence),
                    width: (a.along, a.half_width_px, growth),
                }
            }
            _ => Self {
                line: None,
                confidence: 0.0,
                width: (0.0, half_width_px, 0.0),
            },
        }
    }

    fn half_width_px(&self, along: f64) -> f64 {
        let (from, half_width_px, growth) = self.width;
        half_width_px + (along - from) * growth
    }
}

/// The camera pixels along a track whose middles lie within an unbroken run of samples.
fn pixels_along(track: &Track, run: &Range<usize>) -> Range<i64> {
    let pixel = |k: usize| track.along(k) - 0.5;
    match run.end.checked_sub(1) {
        Some(last) if last >= run.start => {
            pixel(run.start).ceil() as i64..pixel(last).floor() as i64 + 1
        }
        _ => 0..0,
    }
}

/// Positions along and across in the middles of some camera pixels of an unbroken run of samples, linear between them.
fn every_pixel(
    track: &Track,
    run: &Range<usize>,
    pixels: Range<i64>,
) -> impl Iterator<Item = (f64, f64)> {
    let (first, samples_per_px) = (track.along(run.start), 1.0 / track.spacing_px);
    let across = &track.across[run.clone()];
    let last = across.len() - 1;
    pixels.map(move |pixel| {
        let along = pixel as f64 + 0.5;
        let sample = (along - first) * samples_per_px;
        let before = (sample as u32 as usize).min(last);
        let after = (before + 1).min(last);
        let [a, b] = [before, after].map(|k| f64::from(across[k]));
        (along, a + (sample - before as f64) * (b - a))
    })
}

/// The unbroken runs of measured samples of a track without their faded ends.
fn unfaded(strength: &[f32]) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    std::iter::from_fn(move || {
        let rest = strength.get(start..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().take_while(|s| **s > 0.0).count();
        let run = &rest[..length];
        let head = faded(run.iter().copied());
        let tail = faded(run.iter().rev().copied());
        let kept = start + head..start + length.saturating_sub(tail).max(head);
        start += length + 1;
        Some(kept)
    })
}

/// Points at the beginning of a run that are weak beside those further inside.
fn faded(run: impl Iterator<Item = f32> + Clone) -> usize {
    let mut inside = [0.0; INSIDE];
    let places = inside.iter_mut().zip(run.clone());
    let count = places.map(|(place, strength)| *place = strength).count();
    let inside = &mut inside[..count];
    inside.sort_unstable_by(f32::total_cmp);
    let Some(&middle) = inside.get(count / 2) else {
        return 0;
    };
    run.take_while(|&s| s < FADED_SHARE * middle).count()
}

/// Half the width of a crossing's line of the given pattern axis, in camera pixels.
fn half_width(crossing: &DecodedCrossing, axis: Axis) -> f64 {
    let [upper_left, upper_right, _, lower_left] = crossing.vertices;
    let other = match axis {
        Axis::Row => lower_left,
        Axis::Column => upper_right,
    };
    0.5 * (other.x - upper_left.x).hypot(other.y - upper_left.y)
}
