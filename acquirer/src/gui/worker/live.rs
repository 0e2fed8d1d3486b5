//! Live pictures: every frame that is taken goes to the window, read or not.

use std::{
    collections::VecDeque,
    ops::ControlFlow,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use super::{RigWorker, Session};
use crate::{
    camera::Frame,
    gui::{
        events::{Event, Who},
        live_picture::{LivePicture, LivePlace, LiveReading, Overlay, marks, wanted_picture},
        waker::Waker,
    },
    pipeline::{PipelineSettings, Projected, Reader},
    session::{LiveMode, LiveSettings, LiveView, Rig, Tap, projected, read_live},
};

/// Coded frames that are averaged where nothing moves.
const AVERAGED: usize = 4;
/// Frames between two looks at the coded grid where labels are carried on.
const REFRESHED_EVERY: usize = 60;

/// Puts frames where the window finds them. Copies go on counting together.
#[derive(Clone)]
pub(super) struct LiveTap {
    place: LivePlace,
    waker: Waker,
    counts: Arc<Mutex<Counts>>,
    /// Frames are shown with what was read from them, not before.
    only_read: Arc<AtomicBool>,
}

#[derive(Default)]
struct Counts {
    stamps: VecDeque<Instant>,
    lost: u64,
}

impl LiveTap {
    pub(super) fn new(place: LivePlace, waker: Waker) -> Self {
        Self {
            place,
            waker,
            counts: Arc::default(),
            only_read: Arc::default(),
        }
    }

    /// For frames that are taken and not read.
    pub(super) fn for_frames(self) -> Tap {
        Box::new(move |frame| {
            if !self.only_read.load(Ordering::Relaxed) {
                self.show(frame, None, None);
            }
        })
    }

    fn show(&self, frame: &Frame, reader: Option<&Reader>, reading: Option<LiveReading>) {
        let wishes = self.place.wishes();
        let (rate_hz, lost) = self.count(frame);
        let lit = reader
            .filter(|_| wishes.overlays.shadow)
            .and_then(Reader::lit_mask);
        let (image, recovered) = wanted_picture(&frame.picture, reader, &wishes);
        self.place.put(LivePicture {
            image,
            marks: marks(&frame.picture, lit.as_ref(), wishes.overlays),
            number: frame.number,
            rate_hz,
            lost,
            reading,
            recovered,
        });
        self.waker.wake();
    }

    fn count(&self, frame: &Frame) -> (f64, u64) {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        counts.lost += frame.dropped;
        (rate(&mut counts.stamps), counts.lost)
    }
}

impl RigWorker {
    /// Reads frame after frame until something else is asked for.
    pub(super) fn read_frames(&mut self, rig: &mut Rig, session: &mut Session, tap: &LiveTap) {
        self.cancel.reset();
        let read = self.read_until_asked(rig, session, tap);
        tap.only_read.store(false, Ordering::Relaxed);
        if read.is_err() || self.cancel.is_cancelled() {
            self.read_live = None;
            self.teller.tell(Event::ReadingStopped);
        }
        if let Err(error) = read {
            let told = format!("frames can't be read live: {error:#}");
            self.teller.tell(Event::Failed(told));
        }
        if session.queue.is_empty() {
            self.teller.tell(Event::Idle(Who::Rig));
        }
    }

    fn read_until_asked(
        &mut self,
        rig: &mut Rig,
        session: &mut Session,
        tap: &LiveTap,
    ) -> anyhow::Result<()> {
        let Some(mode) = self.read_live else {
            return Ok(());
        };
        rig.tap = Some(tap.clone().for_frames());
        self.need_latency(rig)?;
        self.teller
            .tell(Event::Projector(Box::new(rig.projector.state()?)));
        let now = projected(rig)?;
        let settings = LiveSettings {
            mode,
            average: AVERAGED,
            refresh: REFRESHED_EVERY,
            check_latency_every: self.config.latency.check_every(),
            record: self.config.record.clone(),
            pipeline: PipelineSettings::live(),
        };
        let calibration = self.calibration();
        let cancel = self.cancel.clone();
        let scene = (&now, calibration.as_ref());
        let mut begun = false;
        read_live(rig, scene, &settings, &cancel, &mut |seen| {
            if !std::mem::replace(&mut begun, true) {
                tap.only_read.store(true, Ordering::Relaxed);
                self.teller.tell(Event::Idle(Who::Rig));
            }
            self.show_read(seen, (mode, &now), tap);
            let asked = !self.take_jobs(session) || !session.queue.is_empty();
            let goes_on = self.read_live == Some(mode) && !seen.settings_changed;
            if asked || session.reopen || !goes_on {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        })?;
        Ok(())
    }

    fn show_read(&self, seen: &LiveView<'_>, (mode, now): (LiveMode, &Projected), tap: &LiveTap) {
        let Some(frame) = seen.frame else { return };
        let coded = &now.pattern.coded;
        let overlay = match seen.told.pattern {
            "coded" => Some(Overlay::of(seen.reader.grid(), coded)),
            "unary" if !seen.labels.is_empty() => {
                Some(Overlay::carried(seen.reader.grid(), seen.labels, coded))
            }
            _ => None,
        };
        let reading = LiveReading {
            mode,
            pattern: seen.told.pattern,
            crossings: seen.told.crossings,
            possible: coded.rows() * coded.columns(),
            reasons: seen.told.reasons.clone(),
            ms: seen.told.ms,
            overlay: Arc::new(overlay.unwrap_or_default()),
        };
        tap.show(frame, Some(seen.reader), Some(reading));
    }
}

/// Frames per second over the last second.
fn rate(stamps: &mut VecDeque<Instant>) -> f64 {
    let now = Instant::now();
    stamps.push_back(now);
    while stamps
        .front()
        .is_some_and(|&t| now - t > Duration::from_secs(1))
    {
        stamps.pop_front();
    }
    let span = stamps.front().map_or(0.0, |&t| (now - t).as_secs_f64());
    if span > 0.0 {
        (stamps.len() - 1) as f64 / span
    } else {
        0.0
    }
}
