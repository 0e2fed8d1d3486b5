//! The time from "the projector says that it is shown" to the first frame wholly lit by it.
//!
//! Takes a rig, gives the latency's median, smallest and largest value. The projector flashes black and white in
//! a pseudo-random order; each change is looked for in the mean brightness of the frames that follow. What a
//! recording waits after each change is the largest value seen plus one frame. Fails quietly when something
//! else in the scene flickers in step with the flashes, which their irregular order makes unlikely.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use shared::{protocol::View, stage::Stage};

use super::{Cancel, Progress, Report, Rig, SessionError, rig::FRAME_TIMEOUT};
use crate::{camera::Frame, clock::monotonic_now, scan::Shows};

/// Longest time that one change is waited for: far beyond the lag of any projector.
const LOST: Duration = Duration::from_secs(2);
/// Time that black and white are held before their level is taken: most projectors lag less than 200 ms.
const SETTLE: Duration = Duration::from_millis(600);
/// Frames averaged for a level.
const LEVEL_FRAMES: u32 = 3;
/// A frame closer to one level than this share of the way is wholly lit by it.
const MIXED_SHARE: f64 = 0.08;
/// Smallest mean difference between white and black, in grey levels, that counts as seen.
const MIN_CONTRAST: f64 = 1.0;

/// How the latency is measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LatencySettings {
    /// Number of black/white changes, 2 to 100.
    pub flashes: usize,
}

impl Default for LatencySettings {
    fn default() -> Self {
        Self { flashes: 6 }
    }
}

/// The latency of a rig, display to capture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Latency {
    /// Median of the changes, in milliseconds. It can be negative: a frame may be stamped before the projector's
    /// word arrives.
    pub median_ms: f64,
    /// Smallest.
    pub min_ms: f64,
    /// Largest.
    pub max_ms: f64,
    /// Time from frame to frame, in milliseconds.
    pub frame_ms: f64,
    /// Changes measured.
    pub changes: usize,
}

impl Latency {
    /// What to wait after the projector's word until the picture is certainly settled: the largest latency seen
    /// and half a frame for what was not seen.
    #[must_use]
    pub fn settled(&self) -> Duration {
        Duration::from_secs_f64((self.max_ms + 0.5 * self.frame_ms).max(0.0) / 1000.0)
    }
}

/// Mean brightness of the camera's frames under black and white.
struct Levels {
    black: f64,
    white: f64,
}

impl Levels {
    /// Whether a frame is wholly black-lit (`false`), wholly white-lit (`true`), or mixed.
    fn side(&self, brightness: f64) -> Option<bool> {
        let share = (brightness - self.black) / (self.white - self.black);
        match share {
            s if s < MIXED_SHARE => Some(false),
            s if s > 1.0 - MIXED_SHARE => Some(true),
            _ => None,
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

/// Flashes black and white and looks for each change in the frames.
///
/// # Errors
/// [`SessionError::NotSeen`] when the frames do not follow the flashes; otherwise as [`Rig::shoot`].
pub fn measure_latency(
    rig: &mut Rig,
    settings: &LatencySettings,
    cancel: &Cancel,
    report: Report,
) -> Result<Latency, SessionError> {
    let flashes = settings.flashes.clamp(2, 100);
    let of = flashes + 2;
    let mut step = |done| {
        report(Progress {
            what: "measuring the latency".into(),
            done,
            of,
        });
    };
    step(0);
    // the camera's automatics settle on white; from here on the same light must give the same bytes
    settled_level(rig, true, cancel)?;
    hold_automatics(rig)?;
    let black = settled_level(rig, false, cancel)?;
    step(1);
    let white = settled_level(rig, true, cancel)?;
    let levels = Levels { black, white };
    if white - black < MIN_CONTRAST {
        return Err(SessionError::NotSeen {
            contrast: white - black,
        });
    }
    let mut latencies_ms = Vec::with_capacity(flashes);
    for flash in 0..flashes {
        step(flash + 2);
        // each state is held for an irregular number of frames, so that no periodic flicker keeps step
        for _ in 0..=(5 * flash + 3) % 4 {
            next_brightness(rig, cancel)?;
        }
        latencies_ms.push(one_change(rig, flash % 2 == 1, &levels, cancel)?);
    }
    step(of);
    latencies_ms.sort_by(f64::total_cmp);
    let latency = Latency {
        median_ms: latencies_ms[flashes / 2],
        min_ms: latencies_ms[0],
        max_ms: latencies_ms[flashes - 1],
        frame_ms: frame_ms(rig),
        changes: flashes,
    };
    rig.latency = Some(latency.clone());
    Ok(latency)
}

/// Changes the picture and gives the time, in milliseconds, from the projector's word to the begin of the first
/// frame wholly lit by it.
fn one_change(
    rig: &mut Rig,
    to_white: bool,
    levels: &Levels,
    cancel: &Cancel,
) -> Result<f64, SessionError> {
    show_flat(rig, to_white)?;
    let word = monotonic_now();
    loop {
        let (frame, brightness) = next_brightness(rig, cancel)?;
        if levels.side(brightness) == Some(to_white) {
            let after_word = frame.captured_at.as_secs_f64() - word.as_secs_f64();
            return Ok(1000.0 * after_word - frame_ms(rig));
        }
        if monotonic_now().saturating_sub(word) > LOST {
            return Err(SessionError::NotSeen {
                contrast: levels.white - levels.black,
            });
        }
    }
}

/// Shows white or black all over.
fn show_flat(rig: &mut Rig, white: bool) -> Result<(), SessionError> {
    let (view, shows) = if white {
        (View::White, Shows::White)
    } else {
        (View::Black, Shows::Black)
    };
    rig.camera.expect(shows, Stage::Background);
    rig.projector.show(view)?;
    Ok(())
}

/// Mean brightness once a view has been up for a while.
fn settled_level(rig: &mut Rig, white: bool, cancel: &Cancel) -> Result<f64, SessionError> {
    show_flat(rig, white)?;
    let until = monotonic_now() + SETTLE;
    let (mut sum, mut frames) = (0.0, 0);
    while frames < LEVEL_FRAMES {
        let (frame, brightness) = next_brightness(rig, cancel)?;
        if frame.captured_at > until {
            sum += brightness;
            frames += 1;
        }
    }
    Ok(sum / f64::from(frames))
}

fn frame_ms(rig: &Rig) -> f64 {
    1000.0 * rig.camera.format().rate.interval().as_secs_f64()
}

fn next_brightness(rig: &mut Rig, cancel: &Cancel) -> Result<(Frame, f64), SessionError> {
    if cancel.is_cancelled() {
        return Err(SessionError::Cancelled);
    }
    let frame = rig.next_frame(FRAME_TIMEOUT)?;
    let bytes = frame.picture.as_raw();
    let sum: u64 = bytes.iter().map(|&byte| u64::from(byte)).sum();
    let brightness = sum as f64 / bytes.len().max(1) as f64;
    Ok((frame, brightness))
}
