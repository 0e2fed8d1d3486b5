//! What is asked of a camera when it is opened.

use serde::{Deserialize, Serialize};

use super::ControlWishes;

/// Wishes for the frames; the nearest that the camera offers is taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSettings {
    /// Wished width in pixels.
    pub width: u32,
    /// Wished height in pixels.
    pub height: u32,
    /// Highest rate taken, in frames per second; 12.5 and 29.97 are rates too.
    pub max_rate: f64,
    /// V4L2 code of the only pixel format allowed (`YUYV`, `NV12`, `RGB3`, `BGR3`, `MJPG`, `GREY`);
    /// empty for the best.
    pub pixel_format: String,
    /// Values of the camera's controls, by key; they are set when it is opened.
    pub controls: ControlWishes,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            max_rate: 30.0,
            pixel_format: String::new(),
            controls: ControlWishes::default(),
        }
    }
}
