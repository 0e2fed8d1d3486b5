//! What can go wrong between the scene and a frame, each with what to do about it.

use std::path::PathBuf;
use std::time::Duration;

use thiserror::Error;

/// Why there is no camera, or no frame.
#[derive(Debug, Error)]
pub enum CameraError {
    /// The `--camera` argument has none of the known forms.
    #[error(
        "'{text}' names no camera: give /dev/videoN (`acquirer cameras` lists them), replay:DIR (a recorded scan), or \
         sim:SCENE (a file's name in config/scenes)"
    )]
    BadSpec {
        /// The argument.
        text: String,
    },
    /// No such device, or not a camera.
    #[error("{}: {reason}; {present}", path.display())]
    NotACamera {
        /// The device asked for.
        path: PathBuf,
        /// What it is instead.
        reason: String,
        /// The cameras that are there, as a sentence.
        present: String,
    },
    /// The operator may not open the device.
    #[error("{}: permission denied; add yourself to its group (`sudo usermod -aG video $USER`) and log in again", path.display())]
    Denied {
        /// The device asked for.
        path: PathBuf,
    },
    /// Another program streams from the device.
    #[error("{}: another program is using this camera; close it (`fuser -v {}` names it) and try again", path.display(), path.display())]
    Busy {
        /// The device asked for.
        path: PathBuf,
    },
    /// The device offers nothing that can be decoded.
    #[error("{}: no usable format; it offers {offered}", path.display())]
    NoUsableFormat {
        /// The device asked for.
        path: PathBuf,
        /// What it offers.
        offered: String,
    },
    /// The device refused to be set up.
    #[error("{}: {step} failed: {reason}", path.display())]
    Setup {
        /// The device.
        path: PathBuf,
        /// What was being done.
        step: &'static str,
        /// The driver's answer.
        reason: String,
    },
    /// The camera has no such control.
    #[error("the camera has no control '{control}'; it has {}", if known.is_empty() { "none" } else { known.as_str() })]
    NoSuchControl {
        /// The control asked for.
        control: String,
        /// The keys there are.
        known: String,
    },
    /// A control does not take a value.
    #[error("'{value}' is no value of the control {control}: give {allowed}")]
    BadControlValue {
        /// The control.
        control: String,
        /// The value asked for.
        value: String,
        /// What it takes.
        allowed: String,
    },
    /// The camera has the control and takes the value, but not now.
    #[error("the camera refuses to set {control}: {reason}")]
    ControlRefused {
        /// The control.
        control: String,
        /// The driver's answer.
        reason: String,
    },
    /// Nothing came in time; the device is still there.
    #[error("{name} gave no frame for {} ms; if this goes on, unplug the camera and plug it in again", waited.as_millis())]
    NoFrame {
        /// The source.
        name: String,
        /// How long was waited.
        waited: Duration,
    },
    /// The device has gone; it is looked for in the background.
    #[error("{name} was unplugged; plug it in again and capture goes on by itself")]
    Unplugged {
        /// The camera's name.
        name: String,
    },
    /// The source has stopped for good.
    #[error("{name} has stopped: {reason}")]
    Ended {
        /// The source.
        name: String,
        /// Why.
        reason: String,
    },
    /// A recording cannot be replayed.
    #[error("cannot replay {}: {reason}", folder.display())]
    Replay {
        /// The folder.
        folder: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A simulated room cannot be built.
    #[error("simulated room '{scene}': {reason}")]
    Simulation {
        /// The scene asked for.
        scene: String,
        /// What is wrong.
        reason: String,
    },
}
