//! Camera controls by their V4L2 numbers, on a second handle to the device.
//!
//! The v4l crate's list of controls panics on control types newer than itself, so controls are set
//! by number without asking for the list. USB cameras keep the value that an automatic control had
//! reached when it is switched off.

use std::path::Path;

use v4l::control::Value;
use v4l::{Control, Device};

use super::list::guarded;
use crate::camera::CameraError;

/// A control that was set, or refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// What it does, in plain words.
    pub name: &'static str,
    /// The camera's refusal, if it has the control but did not take the value.
    pub refused: Option<String>,
}

/// Name, V4L2 number (linux/v4l2-controls.h) and value that makes the control stand still.
const AUTOMATICS: [(&str, u32, Value); 6] = [
    ("exposure time", 0x009a_0901, Value::Integer(1)), // auto exposure: 1 is manual
    (
        "frame rate in poor light",
        0x009a_0903,
        Value::Boolean(false),
    ), // exposure dynamic framerate
    ("gain", 0x0098_0912, Value::Boolean(false)),
    ("white balance", 0x0098_090c, Value::Boolean(false)),
    ("focus", 0x009a_090c, Value::Boolean(false)),
    ("backlight compensation", 0x0098_091c, Value::Integer(0)),
];

/// Switches off what would change the picture by itself; gives the controls that the camera has,
/// and the values that switch them on again.
pub(super) fn hold_automatics(path: &Path) -> Result<(Vec<Held>, Vec<Control>), CameraError> {
    let device = open(path)?;
    let (mut held, mut before) = (Vec::new(), Vec::new());
    for (name, id, value) in AUTOMATICS {
        let Ok(previous) = guarded(|| device.control(id)) else {
            continue; // the camera has no such control
        };
        let refused = guarded(|| device.set_control(Control { id, value })).err();
        if refused.is_none() {
            before.push(previous);
        }
        held.push(Held {
            name,
            refused: refused.map(|error| error.to_string()),
        });
    }
    Ok((held, before))
}

/// Gives the controls the values they had.
pub(super) fn restore(path: &Path, before: Vec<Control>) -> Result<(), CameraError> {
    let device = open(path)?;
    for control in before {
        let id = control.id;
        if let Err(error) = guarded(|| device.set_control(control)) {
            tracing::warn!(%error, "control {id:#x} of {} stays as it is", path.display());
        }
    }
    Ok(())
}

fn open(path: &Path) -> Result<Device, CameraError> {
    Device::with_path(path).map_err(|error| CameraError::Setup {
        path: path.into(),
        step: "opening it for its controls",
        reason: error.to_string(),
    })
}
