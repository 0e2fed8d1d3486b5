//! The timing of the rig: how long after "the projector says that it is shown" a picture is seen, and how it is seen.
//!
//! Takes a rig, gives its [`Latency`]. The projector flashes black and white for pseudo-random times; how far each band
//! of each frame is on the way between the two gives latency, jitter, read-out and exposure
//! ([`super::tagging::find_timing`]). On the way the camera's automatics settle and are held, and the noise of frames
//! that should look the same is found. Recordings check the latency again at every change of the picture.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use shared::{protocol::View, stage::Stage};

use super::{
    Cancel, Progress, Report, Rig, SessionError,
    rig::FRAME_TIMEOUT,
    sequence::{Played, milliseconds},
    tagging::{Estimate, Flash, Look, LookNoise, Timing, find_timing},
};
use crate::{camera::Frame, clock::monotonic_now, scan::Shows};

/// Time that black and white are held before their level is taken: most projectors lag less than 200 ms.
const SETTLE: Duration = Duration::from_millis(600);
/// Frames of a level.
const LEVEL_FRAMES: usize = 8;
/// Smallest mean difference between white and black that counts as seen, in light from 0 to 255.
const MIN_CONTRAST: f32 = 0.3;
/// Shortest flash, in milliseconds and in frames: longer than any jitter and read-out.
const SHORTEST_MS: f64 = 100.0;
const SHORTEST_FRAMES: f64 = 3.0;
/// A flash is longer by up to this many frames.
const IRREGULAR_FRAMES: f64 = 3.0;
/// A frame rate that differs by more than this share from the promised one is told to the operator.
const RATE_TOLD: f64 = 0.1;
/// A camera is steady when its mean and its median frame time differ by less than this share.
const STEADY: f64 = 0.02;
/// The golden section: its multiples fall evenly and never in step.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// How the latency is measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LatencySettings {
    /// Number of black/white changes, 4 to 60.
    pub flashes: usize,
    /// While frames are read live, black is shown for a moment each time so many seconds are over, to check the latency
    /// by what the frames make of the two changes; 0 for never.
    pub check_every_s: f64,
}

impl Default for LatencySettings {
    fn default() -> Self {
        Self {
            flashes: 16,
            check_every_s: 60.0,
        }
    }
}

impl LatencySettings {
    /// Time between two checks; `None` for never.
    #[must_use]
    pub fn check_every(&self) -> Option<Duration> {
        let time = Duration::try_from_secs_f64(self.check_every_s).ok();
        time.filter(|time| !time.is_zero())
    }
}

/// The timing of a rig as measured, and how it was checked since.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Latency {
    /// Latency, jitter, read-out, exposure, frame time.
    #[serde(flatten)]
    pub timing: Timing,
    /// From one frame that was taken to the next, in milliseconds: longer than from frame to frame where this computer
    /// cannot keep up with the camera.
    pub taken_every_ms: f64,
    /// Black/white changes that were measured.
    pub flashes: usize,
    /// The projector's clock is known to this many milliseconds; part of the latency's uncertainty.
    pub clock_uncertainty_ms: f64,
    /// What frames differ by that should look the same, as light of 255.
    pub noise: LookNoise,
    /// Changes of the picture that were seen since.
    pub checked_changes: usize,
    /// By how much they corrected the latency, in milliseconds.
    pub drift_ms: f64,
}

impl Latency {
    /// From the projector's word until its picture is certainly all over a frame, as a time of the frame's stamp.
    #[must_use]
    pub fn settled(&self) -> Duration {
        Duration::from_secs_f64(self.timing.settled_ms().max(0.0) / 1000.0)
    }

    /// What the operator should know of it, in one line.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Timing {
            latency,
            jitter,
            readout,
            exposure,
            frame_ms,
            ..
        } = self.timing;
        format!(
            "latency {:.0} ms (+-{:.0}), jitter {:.0} ms, read-out {:.0} ms, exposure {:.0} ms, {:.1} frames a second; clocks \
             known to {:.1} ms",
            latency.ms,
            latency.uncertainty_ms,
            jitter.ms,
            readout.ms,
            exposure.ms,
            1000.0 / frame_ms,
            self.clock_uncertainty_ms
        )
    }

    /// For a recording, whose frames are there before anything is shown.
    fn of_recording(frame_ms: f64) -> Self {
        let nothing = Estimate {
            ms: 0.0,
            uncertainty_ms: 0.0,
        };
        Self {
            timing: Timing {
                latency: nothing,
                jitter: nothing,
                readout: nothing,
                exposure: nothing,
                change: nothing,
                frame_ms,
                settling: None,
                delay: None,
            },
            taken_every_ms: frame_ms,
            flashes: 0,
            clock_uncertainty_ms: 0.0,
            noise: LookNoise::of(&[], &[]),
            checked_changes: 0,
            drift_ms: 0.0,
        }
    }
}

/// Holds what the camera would change by itself, as far as it lets us.
fn hold_automatics(rig: &mut Rig) -> Result<(), SessionError> {
    for held in rig.camera.hold_automatics()? {
        match held.refused {
            None => tracing::info!("the camera's {} is held", held.name),
            Some(reason) => {
                tracing::warn!("the camera's {} can't be held: {reason}", held.name);
            }
        }
    }
    Ok(())
}

/// Flashes black and white and finds the timing under which the frames follow.
///
/// # Errors
/// [`SessionError::NotSeen`] when the frames do not follow the flashes; otherwise as [`Rig::shoot`].
pub fn measure_latency(
    rig: &mut Rig,
    settings: &LatencySettings,
    cancel: &Cancel,
    report: Report,
) -> Result<Latency, SessionError> {
    let of = 3;
    let mut step = |done| {
        report(Progress {
            what: "measuring the latency".into(),
            done,
            of,
        });
    };
    step(0);
    if !rig.camera.follows_projector() {
        let latency = Latency::of_recording(rig.frame_ms());
        rig.latency = Some(latency.clone());
        step(of);
        return Ok(latency);
    }
    rig.latency = None;
    // the camera's automatics settle on white; from here on the same light must give the same bytes
    settled(rig, true, cancel)?;
    hold_automatics(rig)?;
    let white = settled(rig, true, cancel)?;
    step(1);
    let black = settled(rig, false, cancel)?;
    let levels = Levels::new(&black, &white)?;
    step(2);
    let flashes = settings.flashes.clamp(4, 60);
    let steps = flash_steps(flashes, rig.frame_ms());
    let played = rig.play(&steps, 1, cancel)?;
    let frame_ms = frame_period_ms(&played.frames).unwrap_or_else(|| rig.frame_ms());
    if (frame_ms / rig.frame_ms() - 1.0).abs() > RATE_TOLD {
        tracing::warn!(
            "the camera gives {:.1} frames a second, not {:.1}: in dim light an automatic exposure may last longer than a \
             frame; fix the exposure or light the scene",
            1000.0 / frame_ms,
            1000.0 / rig.frame_ms()
        );
    }
    let timing = levels.timing(&steps, &played, frame_ms)?;
    let clock = rig.clock_offset()?;
    let latency = Latency {
        taken_every_ms: taken_every_ms(&played.frames).max(frame_ms),
        flashes,
        clock_uncertainty_ms: 1000.0 * clock.uncertainty.as_secs_f64(),
        noise: LookNoise::of(&black, &white),
        checked_changes: 0,
        drift_ms: 0.0,
        timing,
    };
    tracing::info!("{latency:?}");
    rig.latency = Some(latency.clone());
    step(of);
    Ok(latency)
}

/// How the camera sees black and white.
struct Levels<'a> {
    black: &'a Look,
    white: &'a Look,
}

impl<'a> Levels<'a> {
    fn new(black: &'a [Look], white: &'a [Look]) -> Result<Self, SessionError> {
        let not_seen = |light: f32| SessionError::NotSeen {
            percent: f64::from(light) / 2.55,
        };
        let (Some(black), Some(white)) = (black.last(), white.last()) else {
            return Err(not_seen(0.0));
        };
        let levels = Self { black, white };
        if levels.contrast() < MIN_CONTRAST {
            return Err(not_seen(levels.contrast()));
        }
        Ok(levels)
    }

    fn contrast(&self) -> f32 {
        self.white.brightness() - self.black.brightness()
    }

    fn timing(
        &self,
        steps: &[(View, f64)],
        played: &Played,
        frame_ms: f64,
    ) -> Result<Timing, SessionError> {
        let times = played.shown_ms.iter().zip(&played.due_ms);
        let flashes: Vec<Flash> = times
            .zip(steps)
            .map(|((&shown_ms, &due_ms), (view, _))| Flash {
                shown_ms,
                due_ms,
                white: *view == View::White,
            })
            .collect();
        let mut last: Option<&Look> = None;
        let fresh = played.seen.iter().filter(|seen| {
            let again = last == Some(&seen.look) && !seen.look.is_blank();
            last = Some(&seen.look);
            !again
        });
        let shares = fresh.map(|seen| {
            let share = seen.look.share(self.black, self.white, MIN_CONTRAST);
            (seen.stamp_ms, share)
        });
        let shares: Vec<_> = shares.collect();
        find_timing(&flashes, &shares, frame_ms).ok_or_else(|| SessionError::NotSeen {
            percent: f64::from(self.contrast()) / 2.55,
        })
    }
}

/// From frame to frame, from the stamps and the camera's count, since a slow machine may miss frames; `None` for too
/// few of them.
fn frame_period_ms(frames: &[Frame]) -> Option<f64> {
    let period = |first: &Frame, last: &Frame| {
        let count = last.number.checked_sub(first.number)?;
        let ms = milliseconds(last.captured_at.checked_sub(first.captured_at)?);
        (count > 0).then(|| ms / count as f64)
    };
    let pairs = frames.windows(2);
    let mut steps: Vec<f64> = pairs
        .filter_map(|pair| period(&pair[0], &pair[1]))
        .collect();
    steps.sort_by(f64::total_cmp);
    let median = *steps.get(steps.len() / 2)?;
    // over all frames it is more exact, unless the camera paused or counted anew
    let whole = period(frames.first()?, frames.last()?)?;
    let alike = (whole / median - 1.0).abs() < STEADY;
    Some(if alike { whole } else { median })
}

/// The median step from a frame that was taken to the next, in milliseconds.
fn taken_every_ms(frames: &[Frame]) -> f64 {
    let pairs = frames.windows(2);
    let mut steps: Vec<f64> = pairs
        .map(|pair| milliseconds(pair[1].captured_at.saturating_sub(pair[0].captured_at)))
        .collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

/// White and black in turn, each for a time of its own, so that no periodic flicker keeps step.
fn flash_steps(flashes: usize, frame_ms: f64) -> Vec<(View, f64)> {
    let shortest = SHORTEST_MS.max(SHORTEST_FRAMES * frame_ms);
    (0..flashes)
        .map(|k| {
            let view = if k % 2 == 0 { View::White } else { View::Black };
            let irregular = IRREGULAR_FRAMES * (k as f64 * GOLDEN).fract();
            (view, shortest + irregular * frame_ms)
        })
        .collect()
}

/// Frames of white or black once it has been up for a while.
fn settled(rig: &mut Rig, white: bool, cancel: &Cancel) -> Result<Vec<Look>, SessionError> {
    let (view, shows) = if white {
        (View::White, Shows::White)
    } else {
        (View::Black, Shows::Black)
    };
    rig.camera.expect(shows, Stage::Background);
    rig.projector.show(view)?;
    let until = monotonic_now() + SETTLE;
    let mut looks = Vec::new();
    while looks.len() < LEVEL_FRAMES {
        if cancel.is_cancelled() {
            return Err(SessionError::Cancelled);
        }
        let frame = rig.next_frame(FRAME_TIMEOUT)?;
        if frame.captured_at > until {
            looks.push(Look::of(&frame.picture));
        }
    }
    Ok(looks)
}
