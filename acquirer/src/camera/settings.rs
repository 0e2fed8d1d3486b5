//! What is asked of a camera when it is opened.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Wishes for the frames; the nearest that the camera offers is taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSettings {
    /// Wished width in pixels.
    pub width: u32,
    /// Wished height in pixels.
    pub height: u32,
    /// Highest rate taken, in frames per second.
    pub max_rate: u32,
    /// V4L2 code of the only pixel format allowed (`YUYV`, `NV12`, `RGB3`, `BGR3`, `MJPG`, `GREY`);
    /// empty for the best.
    pub pixel_format: String,
    /// Simulated room: time from the projector's notice to light on the scene, in milliseconds.
    pub simulated_latency_ms: f64,
    /// Simulated room: that time varies by up to this much to either side, in milliseconds.
    pub simulated_jitter_ms: f64,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            max_rate: 30,
            pixel_format: String::new(),
            simulated_latency_ms: 50.0,
            simulated_jitter_ms: 5.0,
        }
    }
}

impl CameraSettings {
    /// Simulated time from the projector's notice to light on the scene.
    #[must_use]
    pub fn simulated_latency(&self) -> Duration {
        milliseconds(self.simulated_latency_ms)
    }

    /// Half the range over which that time varies.
    #[must_use]
    pub fn simulated_jitter(&self) -> Duration {
        milliseconds(self.simulated_jitter_ms)
    }
}

/// Anything that is not a time a display could take counts as zero or as ten seconds.
fn milliseconds(value: f64) -> Duration {
    if value.is_nan() {
        Duration::ZERO
    } else {
        Duration::from_secs_f64(value.clamp(0.0, 10_000.0) / 1000.0)
    }
}
