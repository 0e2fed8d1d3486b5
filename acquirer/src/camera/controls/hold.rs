//! Which controls are automatics, what they have in hand, and how they are made to stand still.
//!
//! Cameras keep the value that an automatic had reached when it is switched off.

use super::{ControlInfo, by_id, ids};
use crate::camera::{Camera, CameraError};

/// A control that was made to stand still, or refused it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// What it does, in plain words.
    pub name: &'static str,
    /// The camera's refusal, if it has the control but did not take the value.
    pub refused: Option<String>,
}

/// A control that changes the picture by itself.
struct Automatic {
    name: &'static str,
    id: u32,
    /// Values with which it stands still, best first.
    still: &'static [i64],
    /// The controls that it has in hand otherwise.
    governs: &'static [u32],
}

const AUTOMATICS: [Automatic; 7] = [
    Automatic {
        name: "exposure time",
        id: ids::AUTO_EXPOSURE,
        still: &[1, 2],
        governs: &[ids::EXPOSURE_TIME, ids::EXPOSURE_OLD],
    },
    Automatic {
        name: "frame rate in poor light",
        id: ids::EXPOSURE_DYNAMIC_FRAMERATE,
        still: &[0],
        governs: &[],
    },
    Automatic {
        name: "gain",
        id: ids::GAIN_AUTOMATIC,
        still: &[0],
        governs: &[ids::GAIN],
    },
    Automatic {
        name: "white balance",
        id: ids::WHITE_BALANCE_AUTOMATIC,
        still: &[0],
        governs: &[ids::WHITE_BALANCE_TEMPERATURE, 0x0098_090e, 0x0098_090f],
    },
    Automatic {
        name: "hue",
        id: ids::HUE_AUTOMATIC,
        still: &[0],
        governs: &[0x0098_0903],
    },
    Automatic {
        name: "focus",
        id: ids::FOCUS_AUTOMATIC,
        still: &[0],
        governs: &[ids::FOCUS_ABSOLUTE],
    },
    Automatic {
        name: "backlight compensation",
        id: ids::BACKLIGHT_COMPENSATION,
        still: &[0],
        governs: &[],
    },
];

/// Whether a control is an automatic, which must be set before what it has in hand.
pub(in crate::camera) fn is_automatic(id: u32) -> bool {
    AUTOMATICS.iter().any(|automatic| automatic.id == id)
}

/// The automatic that has a control in hand.
pub(in crate::camera) fn governor_of(id: u32) -> Option<u32> {
    let governor = AUTOMATICS
        .iter()
        .find(|automatic| automatic.governs.contains(&id));
    governor.map(|automatic| automatic.id)
}

/// Makes every automatic of a camera stand still; gives those that it has.
pub(in crate::camera) fn hold<C: Camera + ?Sized>(
    camera: &mut C,
) -> Result<Vec<Held>, CameraError> {
    let controls = camera.controls()?;
    let mut held = Vec::new();
    for automatic in &AUTOMATICS {
        if let Some(control) = by_id(&controls, automatic.id).filter(|control| !control.read_only) {
            let refused = still(camera, control, automatic).err();
            held.push(Held {
                name: automatic.name,
                refused: refused.map(|error| error.to_string()),
            });
        }
    }
    Ok(held)
}

/// Makes the automatic stand still that has a control in hand, if there is one.
pub(super) fn free<C: Camera + ?Sized>(
    camera: &mut C,
    controls: &[ControlInfo],
    id: u32,
) -> Result<(), CameraError> {
    let governor = AUTOMATICS
        .iter()
        .find(|automatic| automatic.governs.contains(&id));
    let Some(automatic) = governor else {
        return Ok(());
    };
    match by_id(controls, automatic.id).filter(|control| !control.read_only) {
        Some(control) => still(camera, control, automatic),
        None => Ok(()),
    }
}

fn still<C: Camera + ?Sized>(
    camera: &mut C,
    control: &ControlInfo,
    automatic: &Automatic,
) -> Result<(), CameraError> {
    let values = automatic.still;
    if control.value.is_some_and(|value| values.contains(&value)) {
        return Ok(());
    }
    let value = values.iter().find(|value| control.takes(**value));
    let Some(value) = value else {
        return Err(CameraError::ControlRefused {
            control: control.key.clone(),
            reason: format!("it has {} only", control.range_text()),
        });
    };
    camera.set_control(control.id, *value).map(|_| ())
}
