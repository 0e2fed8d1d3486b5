//! What the operator wants of the controls: `[camera.controls]` of the configuration, `--control KEY=VALUE` of the
//! command line.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::{ControlInfo, ControlKind, find_control, hold, ids, is_automatic};
use crate::camera::{Camera, CameraError};

/// Values by the controls' keys; they are set when the camera is opened.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ControlWishes(BTreeMap<String, ControlValue>);

/// A value as the operator writes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ControlValue {
    /// On or off.
    Switch(bool),
    /// A number, in the control's unit.
    Number(i64),
    /// The name of a menu's item, `on`, `off`, a number, or an exposure time such as `12.5ms`.
    Text(String),
}

/// One `KEY=VALUE` of the command line.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlWish {
    /// The control's key.
    pub key: String,
    /// The wished value.
    pub value: ControlValue,
}

impl FromStr for ControlWish {
    type Err = CameraError;

    fn from_str(text: &str) -> Result<Self, CameraError> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => Ok(Self {
                key: key.trim().into(),
                value: ControlValue::Text(value.trim().into()),
            }),
            _ => Err(CameraError::BadControlValue {
                control: text.into(),
                value: String::new(),
                allowed: "KEY=VALUE, for example exposure=120 or mains=\"50 Hz\"".into(),
            }),
        }
    }
}

impl ControlWishes {
    /// Adds a wish, in place of an earlier one for the same key.
    pub fn add(&mut self, wish: ControlWish) {
        self.0.insert(wish.key, wish.value);
    }

    /// Whether nothing is wished.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Sets what is wished: automatics first, then the values. An automatic that has a wished value in hand is
/// switched off, unless there is a wish for it too.
///
/// # Errors
/// A key that the camera does not have, a value that it does not take; nothing is set then. Or a refusal.
pub(in crate::camera) fn apply<C: Camera + ?Sized>(
    camera: &mut C,
    wishes: &ControlWishes,
) -> Result<(), CameraError> {
    if wishes.is_empty() {
        return Ok(());
    }
    let controls = camera.controls()?;
    let mut settings = Vec::new();
    for (key, value) in &wishes.0 {
        let control = find_control(&controls, key)?;
        settings.push((control, number(control, value)?));
    }
    settings.sort_by_key(|(control, _)| !is_automatic(control.id));
    let wished: Vec<u32> = settings.iter().map(|(control, _)| control.id).collect();
    for (control, value) in settings {
        let governor = hold::governor_of(control.id);
        if governor.is_some_and(|id| !wished.contains(&id)) {
            hold::free(camera, &controls, control.id)?;
        }
        let taken = camera.set_control(control.id, value)?;
        if taken == value {
            tracing::info!("{} is {}", control.key, control.value_text(value));
        } else {
            let (wished, taken) = (control.value_text(value), control.value_text(taken));
            tracing::warn!(
                "{}: {wished} was asked for, the camera took {taken}",
                control.key
            );
        }
    }
    Ok(())
}

/// The number that a wish means for a control.
fn number(control: &ControlInfo, wish: &ControlValue) -> Result<i64, CameraError> {
    let number = match wish {
        ControlValue::Switch(on) => Some(i64::from(*on)),
        ControlValue::Number(number) => Some(*number),
        ControlValue::Text(text) => text.parse().ok().or_else(|| named(control, text)),
    };
    number
        .filter(|number| control.takes(*number))
        .ok_or_else(|| CameraError::BadControlValue {
            control: control.key.clone(),
            value: match wish {
                ControlValue::Switch(on) => on.to_string(),
                ControlValue::Number(number) => number.to_string(),
                ControlValue::Text(text) => text.clone(),
            },
            allowed: control.range_text(),
        })
}

fn named(control: &ControlInfo, text: &str) -> Option<i64> {
    match &control.kind {
        ControlKind::Switch => match text.to_ascii_lowercase().as_str() {
            "on" | "true" | "yes" => Some(1),
            "off" | "false" | "no" => Some(0),
            _ => None,
        },
        ControlKind::Menu { items } => {
            let same = |name: &str| super::key_of(name) == super::key_of(text);
            let item = items.iter().find(|item| same(&item.name));
            item.map(|item| item.value)
        }
        ControlKind::Number { .. } if control.id == ids::EXPOSURE_TIME => {
            let ms: f64 = text.strip_suffix("ms")?.trim().parse().ok()?;
            ms.is_finite().then(|| (ms * 10.0).round() as i64)
        }
        ControlKind::Number { .. } => None,
    }
}
