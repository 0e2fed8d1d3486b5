//! What was changed of a device's controls: so that it can be done again after a replug, and undone at the end.
//!
//! Takes each setting as it is made, with the device, and notes the values that were there before the first one.
//! Restoring sets values before automatics and the refused ones once more after them: a value cannot be set while
//! an automatic has it in hand, whichever of the two states is the one to come back to.

use std::io;

use crate::camera::controls::{ControlInfo, governor_of, is_automatic};

/// Access to the controls of a device.
pub(super) trait ControlPort {
    /// Every control with its value.
    fn list(&self) -> io::Result<Vec<ControlInfo>>;

    /// The value of a control.
    fn get(&self, id: u32) -> io::Result<i64>;

    /// Sets a control; gives the value that it has then.
    fn set(&self, id: u32, value: i64) -> io::Result<i64>;
}

/// The settings made, and the values before them.
#[derive(Debug, Default)]
pub(super) struct KeptControls {
    before: Vec<(u32, i64)>,
    set: Vec<(u32, i64)>,
}

impl KeptControls {
    /// Sets a control and notes it.
    pub(super) fn set(&mut self, port: &impl ControlPort, id: u32, value: i64) -> io::Result<i64> {
        self.note_before(port, id);
        let taken = port.set(id, value)?;
        match self.set.iter_mut().find(|(known, _)| *known == id) {
            Some(setting) => setting.1 = value,
            None => self.set.push((id, value)),
        }
        Ok(taken)
    }

    /// Notes the value of a control, and of what it has in hand: switching an automatic may change that.
    fn note_before(&mut self, port: &impl ControlPort, id: u32) {
        let known = |before: &[(u32, i64)], id| before.iter().any(|(known, _)| *known == id);
        if known(&self.before, id) {
            return;
        }
        let governed = if is_automatic(id) {
            port.list().unwrap_or_default()
        } else {
            vec![]
        };
        let governed = governed
            .into_iter()
            .filter(|control| governor_of(control.id) == Some(id) && !control.read_only);
        let values: Vec<_> = governed
            .filter_map(|control| Some((control.id, control.value?)))
            .chain(port.get(id).ok().map(|value| (id, value)))
            .collect();
        for value in values {
            if !known(&self.before, value.0) {
                self.before.push(value);
            }
        }
    }

    /// Makes the settings again, on a device that has forgotten them; gives how many it refused.
    pub(super) fn set_again(&self, port: &impl ControlPort) -> usize {
        let (automatics, values): (Vec<_>, Vec<_>) =
            self.set.iter().partition(|(id, _)| is_automatic(*id));
        let settings = automatics.iter().chain(&values);
        settings
            .filter(|(id, value)| port.set(*id, *value).is_err())
            .count()
    }

    /// Gives every control the value it had; gives those that could not be given theirs, with the reason.
    pub(super) fn restore(&mut self, port: &impl ControlPort) -> Vec<(u32, io::Error)> {
        self.set.clear();
        let before = std::mem::take(&mut self.before);
        let (automatics, values): (Vec<_>, Vec<_>) =
            before.into_iter().partition(|(id, _)| is_automatic(*id));
        let refused: Vec<_> = values
            .into_iter()
            .filter(|(id, value)| port.set(*id, *value).is_err())
            .collect();
        let set = |(id, value): (u32, i64)| port.set(id, value).err().map(|error| (id, error));
        let mut failed: Vec<_> = automatics.into_iter().filter_map(set).collect();
        failed.extend(refused.into_iter().filter_map(set));
        // what an automatic has in hand again need not be told
        let inactive = port.list().unwrap_or_default();
        failed.retain(|(id, _)| !inactive.iter().any(|now| now.id == *id && now.inactive));
        failed
    }

    /// Whether there is anything to restore.
    pub(super) fn is_empty(&self) -> bool {
        self.before.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::collections::BTreeMap;

    use super::*;
    use crate::camera::controls::{ControlKind, ids};

    /// Exposure and its automatic, which refuses the one while the other is on, as cameras do.
    struct Device(RefCell<BTreeMap<u32, i64>>);

    impl Device {
        fn new(automatic: i64, exposure: i64) -> Self {
            let values = [
                (ids::AUTO_EXPOSURE, automatic),
                (ids::EXPOSURE_TIME, exposure),
                (ids::GAIN, 7),
            ];
            Self(RefCell::new(values.into()))
        }

        fn values(&self) -> [i64; 3] {
            let values = self.0.borrow();
            [ids::AUTO_EXPOSURE, ids::EXPOSURE_TIME, ids::GAIN].map(|id| values[&id])
        }
    }

    impl ControlPort for Device {
        fn list(&self) -> io::Result<Vec<ControlInfo>> {
            let values = self.0.borrow();
            let automatic = values[&ids::AUTO_EXPOSURE] == 3;
            let control = |(id, value): (&u32, &i64)| ControlInfo {
                id: *id,
                key: String::new(),
                name: String::new(),
                kind: ControlKind::Switch,
                unit: None,
                default: 0,
                value: Some(*value),
                inactive: *id == ids::EXPOSURE_TIME && automatic,
                read_only: false,
            };
            Ok(values.iter().map(control).collect())
        }

        fn get(&self, id: u32) -> io::Result<i64> {
            Ok(self.0.borrow()[&id])
        }

        fn set(&self, id: u32, value: i64) -> io::Result<i64> {
            if id == ids::EXPOSURE_TIME && self.get(ids::AUTO_EXPOSURE)? == 3 {
                return Err(io::ErrorKind::PermissionDenied.into());
            }
            self.0.borrow_mut().insert(id, value);
            Ok(value)
        }
    }

    #[test]
    fn a_device_with_its_automatic_on_gets_it_back() {
        let device = Device::new(3, 157);
        let mut kept = KeptControls::default();
        kept.set(&device, ids::AUTO_EXPOSURE, 1).unwrap();
        kept.set(&device, ids::EXPOSURE_TIME, 40).unwrap();
        kept.set(&device, ids::EXPOSURE_TIME, 50).unwrap();
        assert_eq!(device.values(), [1, 50, 7]);
        assert!(kept.restore(&device).is_empty());
        assert_eq!(device.values(), [3, 157, 7]);
        assert!(kept.is_empty());
    }

    #[test]
    fn a_value_that_was_set_by_hand_comes_back_from_under_an_automatic() {
        let device = Device::new(1, 90);
        let mut kept = KeptControls::default();
        kept.set(&device, ids::EXPOSURE_TIME, 40).unwrap();
        kept.set(&device, ids::AUTO_EXPOSURE, 3).unwrap();
        assert!(kept.restore(&device).is_empty());
        assert_eq!(device.values(), [1, 90, 7]);
    }

    #[test]
    fn a_device_that_came_back_is_set_again_and_still_restored_to_what_it_was_first() {
        let device = Device::new(3, 157);
        let mut kept = KeptControls::default();
        kept.set(&device, ids::AUTO_EXPOSURE, 1).unwrap();
        kept.set(&device, ids::EXPOSURE_TIME, 40).unwrap();
        kept.set(&device, ids::GAIN, 9).unwrap();
        let back = Device::new(3, 300);
        assert_eq!(kept.set_again(&back), 0);
        assert_eq!(back.values(), [1, 40, 9]);
        kept.restore(&back);
        assert_eq!(back.values(), [3, 157, 7]);
    }

    #[test]
    fn a_refused_setting_is_not_kept() {
        let device = Device::new(3, 157);
        let mut kept = KeptControls::default();
        assert!(kept.set(&device, ids::EXPOSURE_TIME, 40).is_err());
        assert_eq!(kept.set_again(&Device::new(3, 1)), 0);
    }
}
