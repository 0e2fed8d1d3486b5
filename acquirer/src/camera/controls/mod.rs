//! A camera's controls: exposure, gain, white balance, focus, power-line frequency, and the automatics
//! that would change them by themselves.
//!
//! Takes and gives plain values by V4L2 control number, for every kind of camera. A control has a key, the
//! word for it in `config/acquirer.toml` and in `--control KEY=VALUE`: that of the V4L2 documentation for the
//! usual ones, whatever the kernel's version calls them, and the driver's own name in lower case for the rest.

mod hold;
mod standard;
mod wishes;

pub use hold::Held;
pub(super) use hold::{governor_of, hold, is_automatic};
pub use standard::ids;
pub(super) use standard::standard;
pub(super) use wishes::apply;
pub use wishes::{ControlValue, ControlWish, ControlWishes};

use serde::{Serialize, Serializer};

use super::CameraError;

/// A control as it is now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ControlInfo {
    /// V4L2's number for it, see [`ids`]; `0x009a0902` in JSON.
    #[serde(serialize_with = "as_hex")]
    pub id: u32,
    /// The word for it in settings.
    pub key: String,
    /// The camera's words for it.
    pub name: String,
    /// What values there are.
    #[serde(flatten)]
    pub kind: ControlKind,
    /// Unit of the value, if it has one: `100 us`, `K`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'static str>,
    /// The camera's own choice.
    pub default: i64,
    /// The value now; an automatic may change it. Nothing when it cannot be read.
    pub value: Option<i64>,
    /// An automatic has it in hand at the moment, setting it is refused.
    pub inactive: bool,
    /// It can never be set.
    pub read_only: bool,
}

/// The values of a control.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ControlKind {
    /// Numbers from `least` to `most`, both included, in steps.
    Number {
        /// Smallest value.
        least: i64,
        /// Largest value.
        most: i64,
        /// Difference of neighbouring values, 1 or more.
        step: u64,
    },
    /// 0 is off, 1 is on.
    Switch,
    /// One of some named values.
    Menu {
        /// The values that this camera takes.
        items: Vec<MenuItem>,
    },
}

/// A value of a menu.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MenuItem {
    /// The value.
    pub value: i64,
    /// What it means.
    pub name: String,
}

impl ControlInfo {
    /// A value for people: with its unit, or by its name.
    #[must_use]
    pub fn value_text(&self, value: i64) -> String {
        match &self.kind {
            ControlKind::Switch => if value == 0 { "off" } else { "on" }.into(),
            ControlKind::Menu { items } => items
                .iter()
                .find(|item| item.value == value)
                .map_or_else(|| value.to_string(), |item| item.name.clone()),
            ControlKind::Number { .. } if self.id == ids::EXPOSURE_TIME => {
                format!("{value} ({} ms)", value as f64 / 10.0)
            }
            ControlKind::Number { .. } => match self.unit {
                Some(unit) => format!("{value} {unit}"),
                None => value.to_string(),
            },
        }
    }

    /// The values that can be set, for people.
    #[must_use]
    pub fn range_text(&self) -> String {
        match &self.kind {
            ControlKind::Switch => "off, on".into(),
            ControlKind::Menu { items } => {
                let items = items
                    .iter()
                    .map(|item| format!("{} = {}", item.value, item.name));
                items.collect::<Vec<_>>().join(", ")
            }
            ControlKind::Number { least, most, step } => {
                let steps = if *step > 1 {
                    format!(" in steps of {step}")
                } else {
                    String::new()
                };
                let unit = self
                    .unit
                    .map_or_else(String::new, |unit| format!(" {unit}"));
                format!("{least} to {most}{unit}{steps}")
            }
        }
    }

    /// Whether the camera takes a value.
    #[must_use]
    pub fn takes(&self, value: i64) -> bool {
        match &self.kind {
            ControlKind::Switch => (0..=1).contains(&value),
            ControlKind::Menu { items } => items.iter().any(|item| item.value == value),
            ControlKind::Number { least, most, .. } => (*least..=*most).contains(&value),
        }
    }

    /// The value nearest to a wish that the camera takes; a menu's wish must be one of its items.
    #[must_use]
    pub fn nearest(&self, wish: i64) -> i64 {
        let ControlKind::Number { least, most, step } = &self.kind else {
            return wish;
        };
        let step = i64::try_from(*step).unwrap_or(1).max(1);
        let above = wish.clamp(*least, *most).saturating_sub(*least);
        let rounded = least.saturating_add(above.saturating_add(step / 2) / step * step);
        if rounded > *most {
            rounded - step
        } else {
            rounded
        }
    }
}

/// Brings controls into the order in which people set them: exposure, gain, white balance, focus, mains, then the
/// others as the camera has them.
pub fn sort_for_people(controls: &mut [ControlInfo]) {
    controls.sort_by_key(|control| standard::place_in_list(control.id));
}

/// The control of a list that a number names.
pub(crate) fn by_id(controls: &[ControlInfo], id: u32) -> Option<&ControlInfo> {
    controls.iter().find(|control| control.id == id)
}

/// The control that a word names: its key, its number as `0x...`, or another usual word for it.
///
/// # Errors
/// [`CameraError::NoSuchControl`], with the keys there are.
pub fn find_control<'a>(
    controls: &'a [ControlInfo],
    word: &str,
) -> Result<&'a ControlInfo, CameraError> {
    let by_key = controls.iter().find(|control| control.key == word);
    let by_number = || {
        let number = u32::from_str_radix(word.strip_prefix("0x")?, 16).ok()?;
        by_id(controls, number)
    };
    let by_alias = || by_id(controls, standard::alias(word)?);
    by_key
        .or_else(by_number)
        .or_else(by_alias)
        .ok_or_else(|| CameraError::NoSuchControl {
            control: word.into(),
            known: controls
                .iter()
                .map(|control| control.key.clone())
                .collect::<Vec<_>>()
                .join(", "),
        })
}

/// The driver's name as a key: lower case, everything but letters and digits an underscore.
pub(super) fn key_of(name: &str) -> String {
    let mut key = String::new();
    for letter in name.chars() {
        if letter.is_ascii_alphanumeric() {
            key.push(letter.to_ascii_lowercase());
        } else if !key.is_empty() && !key.ends_with('_') {
            key.push('_');
        }
    }
    key.trim_end_matches('_').into()
}

fn as_hex<S: Serializer>(id: &u32, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{id:#010x}"))
}

#[cfg(test)]
mod tests;
