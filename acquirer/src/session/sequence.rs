//! Shows several views in a row and takes the frames that show each all over, without a round trip per view.
//!
//! Takes shots (a view, and how many frames of it), gives their frames. The projector is sent the whole sequence, each
//! view held for as long as the measured timing asks for; what it showed when comes back as notices. Which frame shows
//! which view is judged from the frames ([`super::tagging`]). Views of which too few frames could be told are shown
//! again, held for longer. Each pass measures the latency anew and corrects it.

use std::{collections::VecDeque, time::Duration};

use shared::{
    pattern::{Pattern, Rgb},
    protocol::{MAX_HOLD_MS, SequenceStep, View},
    stage::Stage,
};

use super::{
    Cancel, Rig, SessionError,
    rig::FRAME_TIMEOUT,
    tagging::{Alignment, FrameKind, Look, Seen, Tag, begin_seen, tag_frames},
};
use crate::{camera::Frame, clock::monotonic_now, projector_link::Notice, scan::Shows};

/// Passes over the views before the operator is told that some cannot be told.
const PASSES: usize = 8;
/// Memory that the frames of one pass may take, in bytes.
const PASS_BYTES: usize = 256 << 20;
/// Most views of one pass; one more may be needed before them.
const MOST_VIEWS: usize = 32;
/// What a sequence may take beyond its own time, in all and for each step: a software driver on a busy machine takes a
/// second for a picture.
const PATIENCE: Duration = Duration::from_secs(6);
const STEP_PATIENCE: Duration = Duration::from_secs(2);
/// Time for a sequence to reach the projector beyond what a message is on its way, before its first picture is due.
const ORDER_TIME: Duration = Duration::from_millis(5);
/// The latency as it was counts as much as this many changes: single changes jitter.
const KNOWN_CHANGES: f64 = 4.0;
/// A latency that is off by more than this is told to the operator, in milliseconds.
const DRIFT_TOLD_MS: f64 = 15.0;

/// A view of which frames are wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// What the projector shows.
    pub view: View,
    /// What that is called in a scan.
    pub shows: Shows,
    /// How many frames.
    pub count: usize,
}

/// What came of a sequence: when each step was due and when it was shown, in milliseconds on our clock, and the frames.
pub(super) struct Played {
    pub(super) due_ms: Vec<f64>,
    pub(super) shown_ms: Vec<f64>,
    pub(super) seen: Vec<Seen>,
    pub(super) frames: Vec<Frame>,
}

impl Rig {
    /// Shows the views one after the other and gives the frames of each that show it all over, as many as asked for.
    /// `done` is told how many views are finished.
    ///
    /// # Errors
    /// As [`Rig::shoot`], and [`SessionError::NotTold`] when the frames of a view cannot be told from others.
    pub fn shoot_all(
        &mut self,
        shots: &[Shot],
        stage: Stage,
        cancel: &Cancel,
        done: &mut dyn FnMut(usize),
    ) -> Result<Vec<Vec<Frame>>, SessionError> {
        let mut frames: Vec<Vec<Frame>> = shots.iter().map(|_| Vec::new()).collect();
        if self.latency.is_none() || !self.camera.follows_projector() {
            for (k, shot) in shots.iter().enumerate() {
                done(k);
                frames[k] = self.shoot(shot.view.clone(), shot.count, stage, shot.shows, cancel)?;
            }
            return Ok(frames);
        }
        if let Some(first) = shots.first() {
            self.camera.expect(first.shows, stage);
        }
        let mut missing: VecDeque<usize> = (0..shots.len()).collect();
        for pass in 0..PASSES {
            done(shots.len() - missing.len());
            let mut left = std::mem::take(&mut missing);
            while !left.is_empty() {
                let now = left
                    .drain(..self.views_at_once(&left, shots))
                    .collect::<Vec<_>>();
                let wanted: Vec<&Shot> = now.iter().map(|&k| &shots[k]).collect();
                for (k, taken) in now.into_iter().zip(self.pass(&wanted, pass, cancel)?) {
                    if taken.len() < shots[k].count {
                        missing.push_back(k);
                    } else {
                        frames[k] = taken;
                    }
                }
                done(shots.len() - missing.len() - left.len());
            }
            if missing.is_empty() {
                return Ok(frames);
            }
            tracing::info!("pass {}: {} views are shown again", pass + 1, missing.len());
        }
        let untold = missing.iter().map(|&k| String::from(shots[k].shows));
        Err(SessionError::NotTold {
            views: untold.collect::<Vec<_>>().join(", "),
        })
    }

    /// Shows black for a moment and then a view again, so that what the frames show of the two changes checks the
    /// latency. Frames that cannot be told, in a scene that moves, check nothing.
    ///
    /// # Errors
    /// As [`Rig::shoot_all`], but for views that cannot be told.
    pub fn check_latency_with(&mut self, shot: &Shot, cancel: &Cancel) -> Result<(), SessionError> {
        if self.latency.is_none() || !self.camera.follows_projector() {
            return Ok(());
        }
        let black = Shot {
            view: View::Black,
            shows: Shows::Black,
            count: 1,
        };
        self.pass(&[&black, shot], 0, cancel)?;
        Ok(())
    }

    /// How many of the first views fit into one pass.
    fn views_at_once(&self, views: &VecDeque<usize>, shots: &[Shot]) -> usize {
        let format = self.camera.format();
        let frame_bytes = 3 * format.width as usize * format.height as usize;
        let mut room = PASS_BYTES / frame_bytes.max(1);
        let fits = views.iter().take_while(|&&k| {
            let frames = self.hold_frames(shots[k].count);
            let fits = frames <= room;
            room = room.saturating_sub(frames);
            fits
        });
        fits.count().clamp(1, MOST_VIEWS).min(views.len())
    }

    fn hold_frames(&self, whole: usize) -> usize {
        let timing = self.latency.as_ref().map(|latency| latency.timing);
        timing.map_or(whole + 1, |timing| timing.hold_frames(whole))
    }

    /// Shows these views once; gives the frames of each, none or too few where they could not be told.
    fn pass(
        &mut self,
        shots: &[&Shot],
        pass: usize,
        cancel: &Cancel,
    ) -> Result<Vec<Vec<Frame>>, SessionError> {
        let taken = self.latency.as_ref().map(|latency| latency.taken_every_ms);
        let frame_ms = taken.unwrap_or_else(|| self.frame_ms());
        let up = self.projector.state()?.shown.pattern;
        let mut order: Vec<usize> = (0..shots.len()).collect();
        let is_seen = begin_seen(&mut order, |&k| is_of(&up, &shots[k].view));
        let lead = order.first().filter(|_| !is_seen);
        let lead = lead.map(|&k| lead_before(&shots[k].view));
        let skipped = usize::from(lead.is_some());
        let more = pass * (pass + 1) / 2; // a machine that is busy now may be so for long
        let held = order.iter().map(|&k| {
            let frames = self.hold_frames(shots[k].count) + more;
            (shots[k].view.clone(), frames as f64 * frame_ms)
        });
        let lead = lead.map(|view| (view, (self.hold_frames(1) + more) as f64 * frame_ms));
        let steps: Vec<(View, f64)> = lead.into_iter().chain(held).collect();
        let whole = shots.iter().map(|shot| shot.count).min().unwrap_or(1);
        let played = self.play(&steps, whole, cancel)?;
        let mut taken: Vec<Vec<Frame>> = shots.iter().map(|_| Vec::new()).collect();
        let Some(latency) = &self.latency else {
            return Ok(taken);
        };
        let noise = latency.noise.after_failures(pass);
        let timing = latency.timing.after_failures(pass);
        let told = tag_frames(&played.seen, &played.shown_ms, &timing, noise);
        self.check_latency(&told);
        let mut frames: Vec<Option<Frame>> = played.frames.into_iter().map(Some).collect();
        for (place, &k) in order.iter().enumerate() {
            let best = best_frames(&told, 1 + skipped + place, shots[k].count);
            taken[k] = best.iter().filter_map(|&at| frames[at].take()).collect();
        }
        Ok(taken)
    }

    /// Has a sequence shown, each view for its milliseconds, and takes every frame until the last view is settled and
    /// its time is over. The first view is due when at least so many `whole` frames of each are best seen.
    pub(super) fn play(
        &mut self,
        steps: &[(View, f64)],
        whole: usize,
        cancel: &Cancel,
    ) -> Result<Played, SessionError> {
        while self.projector.next_notice(Duration::ZERO)?.is_some() {}
        let clock = self.clock_offset()?;
        let order = steps.iter().map(|(view, hold_ms)| SequenceStep {
            view: view.clone(),
            hold_ms: hold_ms.clamp(1.0, MAX_HOLD_MS),
        });
        let order: Vec<SequenceStep> = order.collect();
        let whole_ms: f64 = steps.iter().map(|(_, ms)| ms).sum();
        let last_ms = steps.last().map_or(0.0, |(_, ms)| *ms);
        let mut played = Played {
            due_ms: Vec::new(),
            shown_ms: Vec::new(),
            seen: Vec::new(),
            frames: Vec::new(),
        };
        let stamp_ms = self.take(&mut played, cancel)?; // what is up before
        let earliest_ms = milliseconds(monotonic_now() + 2 * clock.uncertainty + ORDER_TIME);
        let begin_ms = match &self.latency {
            Some(latency) => latency.timing.begin_ms(earliest_ms, stamp_ms, whole),
            None => earliest_ms,
        };
        let mut due_ms = begin_ms;
        for step in &order {
            played.due_ms.push(due_ms);
            due_ms += step.hold_ms;
        }
        let begin = Duration::try_from_secs_f64(begin_ms / 1000.0).ok();
        let begin_ns = begin.map(|begin| clock.projector_ns(begin));
        self.projector.show_sequence(order, begin_ns)?;
        let deadline = monotonic_now()
            + Duration::from_secs_f64(whole_ms / 1000.0)
            + PATIENCE
            + STEP_PATIENCE * steps.len() as u32;
        let settled_ms = self.latency.as_ref().map_or(SETTLE_MS, |latency| {
            latency.timing.settled_ms() + latency.timing.readout.at_most()
        });
        loop {
            let stamp_ms = self.take(&mut played, cancel)?;
            let broken = self.hear(steps, &mut played.shown_ms)?;
            let last = played.shown_ms.get(steps.len() - 1);
            // two frames more than needed: a frame is judged by the next one too
            let end = last.map(|last| last + settled_ms + last_ms + 2.0 * self.frame_ms());
            if end.is_some_and(|end| stamp_ms > end) {
                return Ok(played);
            }
            if broken || monotonic_now() > deadline {
                return Err(SessionError::SequenceBroken {
                    shown: played.shown_ms.len(),
                    of: steps.len(),
                });
            }
        }
    }

    /// Takes over when steps were shown; whether something else was, which ends a sequence.
    fn hear(
        &mut self,
        steps: &[(View, f64)],
        shown_ms: &mut Vec<f64>,
    ) -> Result<bool, SessionError> {
        while let Some(notice) = self.projector.next_notice(Duration::ZERO)? {
            let Notice::Shown { shown, .. } = notice else {
                continue;
            };
            let step = steps.get(shown_ms.len());
            if !step.is_some_and(|(view, _)| is_of(&shown.pattern, view)) {
                return Ok(true);
            }
            let clock = self.known_clock_offset()?;
            shown_ms.push(milliseconds(clock.local_time(shown.presented_ns)));
        }
        Ok(false)
    }

    /// Takes the next frame; gives its stamp in milliseconds.
    fn take(&mut self, played: &mut Played, cancel: &Cancel) -> Result<f64, SessionError> {
        if cancel.is_cancelled() {
            return Err(SessionError::Cancelled);
        }
        let frame = self.next_frame(FRAME_TIMEOUT)?;
        let stamp_ms = milliseconds(frame.captured_at);
        played.seen.push(Seen {
            stamp_ms,
            after_loss: frame.dropped > 0,
            look: Look::of(&frame.picture),
        });
        played.frames.push(frame);
        Ok(stamp_ms)
    }

    /// Takes over what a pass says of the latency.
    fn check_latency(&mut self, told: &Alignment) {
        let Some(latency) = &mut self.latency else {
            return;
        };
        let Some(offset_ms) = told.offset_ms else {
            return;
        };
        let changes = told.changes as f64;
        let correction_ms = offset_ms * changes / (changes + KNOWN_CHANGES);
        latency.checked_changes += told.changes;
        latency.drift_ms += correction_ms;
        latency.timing.latency.ms += correction_ms;
        if offset_ms.abs() > DRIFT_TOLD_MS {
            tracing::warn!("the latency has changed by {offset_ms:.0} ms since it was measured");
        } else {
            tracing::debug!("{} changes came {offset_ms:.1} ms late", told.changes);
        }
    }
}

/// How long the end of a sequence is waited for while the latency is not known: most projectors lag less than 200 ms.
const SETTLE_MS: f64 = 600.0;

pub(super) fn milliseconds(time: Duration) -> f64 {
    1000.0 * time.as_secs_f64()
}

/// The frames that show a step, as many as asked for if there are: those in the middle, each given once.
fn best_frames(told: &Alignment, step: usize, count: usize) -> Vec<usize> {
    let tagged: Vec<usize> = (0..told.tags.len())
        .filter(|&k| told.tags[k] == Tag::Shows(step))
        .filter(|&k| !matches!(told.kinds[k], FrameKind::Duplicate { .. }))
        .collect();
    let first = tagged.len().saturating_sub(count) / 2;
    tagged.into_iter().skip(first).take(count).collect()
}

/// What is shown before a view that looks like what is up: its begin could not be seen.
fn lead_before(view: &View) -> View {
    match is_of(&Pattern::BLACK, view) {
        true => View::White,
        false => View::Black,
    }
}

/// Whether a picture is a view's; of the coded and the unary grid the settings are not asked.
fn is_of(pattern: &Pattern, view: &View) -> bool {
    match (pattern, view) {
        (Pattern::Grid(shown), View::Grid(grid)) => shown == grid,
        (Pattern::Grid(shown), View::Unary) => shown.is_unary(),
        (Pattern::Grid(shown), View::Coded) => !shown.is_unary(),
        (Pattern::Solid { colour }, View::Black) => *colour == Rgb::BLACK,
        (Pattern::Solid { colour }, View::White) => *colour == Rgb::WHITE,
        (Pattern::Solid { colour: shown }, View::Solid { colour }) => shown == colour,
        (Pattern::Grid(shown), View::TwoColour) => shown.colours().len() == 2,
        (Pattern::Ramp, View::Ramp)
        | (Pattern::TestCard, View::TestCard)
        | (Pattern::Identify { .. }, View::Identify) => true,
        _ => false,
    }
}
