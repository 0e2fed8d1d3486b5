//! The rig under examination: shows pictures, takes their frames, tells the progress, counts what got lost.

use std::time::Duration;

use shared::{protocol::View, stage::Stage};

use super::{Examination, Light};
use crate::{
    camera::{ControlInfo, Frame, Held, Losses, controls::ids},
    clock::monotonic_now,
    pipeline::response::Response,
    scan::Shows,
    session::{Cancel, Progress, Report, Rig, SessionError, rig::FRAME_TIMEOUT, tagging::Look},
};

/// Steps of the progress: as many as pictures are looked at.
const STEPS: usize = 15;
/// Time after which a picture is certainly seen while the latency is not known: most projectors lag less than 200 ms.
const SETTLE: Duration = Duration::from_millis(600);
/// How long black is looked at before white comes: automatics must have followed it.
const BLACK: Duration = Duration::from_millis(1200);
/// How long white is looked at: the automatics of webcams settle in one or two seconds.
const WHITE: Duration = Duration::from_millis(2500);

/// V4L2's unit of exposure time, in milliseconds.
const EXPOSURE_UNIT_MS: f64 = 0.1;

/// The rig and how to speak to the operator.
pub(super) struct Bench<'a> {
    pub(super) rig: &'a mut Rig,
    pub(super) examination: &'a Examination<'a>,
    pub(super) cancel: &'a Cancel,
    report: Report<'a>,
    done: usize,
    losses_before: Losses,
    /// Number and stamp of the first and of the newest frame.
    first: Option<(u64, Duration)>,
    last: Option<(u64, Duration)>,
}

/// The change from black to white, with the automatics held as far as the camera lets us.
pub(super) struct Step {
    pub(super) held: Vec<Held>,
    /// Frames before white was asked for, the picture settled.
    pub(super) black: Vec<Look>,
    /// Frames since.
    pub(super) white: Vec<Look>,
}

impl<'a> Bench<'a> {
    pub(super) fn new(
        rig: &'a mut Rig,
        examination: &'a Examination<'a>,
        cancel: &'a Cancel,
        report: Report<'a>,
    ) -> Self {
        let losses_before = rig.camera.losses();
        Self {
            rig,
            examination,
            cancel,
            report,
            done: 0,
            losses_before,
            first: None,
            last: None,
        }
    }

    /// Tells the operator what is done next.
    pub(super) fn tell(&mut self, what: &str) {
        (self.report)(Progress {
            what: format!("examining: {what}"),
            done: self.done,
            of: STEPS,
        });
        self.done = (self.done + 1).min(STEPS);
    }

    /// Tells the operator that all is done.
    pub(super) fn finish(&mut self) {
        self.done = STEPS;
        self.tell("done");
    }

    /// How camera bytes become light.
    pub(super) fn response(&self) -> Response {
        Response::new(self.examination.response)
    }

    /// Frames that were lost since the examination began: by camera or bus, and by this program.
    pub(super) fn losses(&self) -> Losses {
        let (now, before) = (self.rig.camera.losses(), self.losses_before);
        Losses {
            by_driver: now.by_driver.saturating_sub(before.by_driver),
            damaged: now.damaged.saturating_sub(before.damaged),
            overtaken: now.overtaken.saturating_sub(before.overtaken),
        }
    }

    /// First and last frame that were taken: number and stamp.
    pub(super) fn span(&self) -> Option<((u64, Duration), (u64, Duration))> {
        self.first.zip(self.last)
    }

    /// The exposure of a row in milliseconds: as the camera says, else as it was measured, where it is known to a
    /// quarter.
    pub(super) fn exposure_ms(&self) -> Option<f64> {
        let said = self.exposure_control().and_then(|control| control.value);
        if let Some(value) = said {
            return Some(value as f64 * EXPOSURE_UNIT_MS);
        }
        let exposure = self.rig.latency.as_ref()?.timing.exposure;
        (exposure.uncertainty_ms < 0.25 * exposure.ms).then_some(exposure.ms)
    }

    /// How the operator sets an exposure of so many milliseconds.
    pub(super) fn how_to_expose(&self, ms: f64) -> String {
        if self.exposure_control().is_some() {
            format!("add --control exposure={ms:.1}ms to this and other commands")
        } else {
            "by the camera's own switch or program, since it lets no other program do that".into()
        }
    }

    fn exposure_control(&self) -> Option<ControlInfo> {
        let controls = self.rig.camera.controls().ok()?;
        controls
            .into_iter()
            .find(|control| control.id == ids::EXPOSURE_TIME)
    }

    /// Share of the frames so far that came while this program was busy with others.
    pub(super) fn overtaken_share(&self) -> f64 {
        let count = self.span().map_or(0, |(first, last)| last.0 - first.0);
        (self.losses().overtaken as f64 / count.max(1) as f64).min(1.0)
    }

    fn next_frame(&mut self) -> Result<Frame, SessionError> {
        if self.cancel.is_cancelled() {
            return Err(SessionError::Cancelled);
        }
        let frame = self.rig.next_frame(FRAME_TIMEOUT)?;
        let seen = (frame.number, frame.captured_at);
        self.first.get_or_insert(seen);
        self.last = Some(seen);
        Ok(frame)
    }

    /// Shows a view; gives the stamp from which on frames certainly show it.
    fn show(&mut self, view: View) -> Result<Duration, SessionError> {
        // a simulated room is looked at without the object; a real camera does not care
        self.rig.camera.expect(Shows::Black, Stage::Background);
        let shown = self.rig.projector.show(view)?.shown;
        let Some(latency) = &self.rig.latency else {
            return Ok(monotonic_now() + SETTLE);
        };
        let settled = latency.settled();
        Ok(self.rig.clock_offset()?.local_time(shown.presented_ns) + settled)
    }

    /// The light of a view, from so many frames.
    pub(super) fn light(
        &mut self,
        name: &str,
        view: View,
        frames: usize,
    ) -> Result<Light, SessionError> {
        let mut light = Light::new(self.response());
        self.add_light(&mut light, name, view, frames)?;
        Ok(light)
    }

    /// Adds so many frames of a view to its light.
    pub(super) fn add_light(
        &mut self,
        light: &mut Light,
        name: &str,
        view: View,
        frames: usize,
    ) -> Result<(), SessionError> {
        self.tell(name);
        let from = self.show(view)?;
        let wanted = light.frames() + frames;
        while light.frames() < wanted {
            let frame = self.next_frame()?;
            if frame.captured_at >= from {
                light.add(&frame);
            }
        }
        Ok(())
    }

    /// Lets the automatics settle on white and holds them, then changes from black to white.
    pub(super) fn step(&mut self) -> Result<Step, SessionError> {
        self.tell("white, to hold the automatics");
        let settled = self.show(View::White)? + SETTLE;
        while self.next_frame()?.captured_at < settled {}
        let held = self.rig.camera.hold_automatics()?;
        self.tell("black");
        let settled = self.show(View::Black)?;
        let black = self.samples(settled, settled.saturating_add(BLACK))?;
        self.tell("the change to white");
        let asked = monotonic_now();
        self.show(View::White)?;
        let white = self.samples(asked, asked + WHITE)?;
        Ok(Step { held, black, white })
    }

    fn samples(&mut self, from: Duration, to: Duration) -> Result<Vec<Look>, SessionError> {
        let mut samples = Vec::new();
        loop {
            let frame = self.next_frame()?;
            if frame.captured_at >= from {
                samples.push(Look::of(&frame.picture));
            }
            if frame.captured_at > to {
                return Ok(samples);
            }
        }
    }
}
