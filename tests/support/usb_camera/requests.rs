//! The control endpoint: descriptors, what is streamed, and the camera's controls.

use acquirer::camera::controls::ids;
use acquirer::camera::{Camera, ControlInfo, ControlKind, SimulatedCamera};

use super::descriptors::{
    CAMERA, CODINGS, CONTROL, Coding, INTERVALS, PAYLOAD, PROCESSING, STREAMING, configuration,
    device, most_bytes, sizes, string,
};

/// Bytes of what driver and camera agree on before streaming.
const NEGOTIATED: usize = 26;
/// Requests of the video class.
const SET_CURRENT: u8 = 0x01;
const GET_CURRENT: u8 = 0x81;
const GET_LEAST: u8 = 0x82;
const GET_MOST: u8 = 0x83;
const GET_STEP: u8 = 0x84;
const GET_LENGTH: u8 = 0x85;
const GET_INFO: u8 = 0x86;
const GET_DEFAULT: u8 = 0x87;
/// What the driver may do with a control: get and set it; the camera changes it by itself.
const CAN_GET_AND_SET: u8 = 3;
const CHANGES: u8 = 8;

/// What the device says to a control request.
pub(super) enum Answer {
    Data(Vec<u8>),
    Taken,
    Stall,
}

/// What is sent, as numbers of the descriptors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Mode {
    format: u8,
    size: u8,
    /// Units of 100 ns.
    pub(super) interval: u32,
}

impl Mode {
    const FIRST: Self = Self {
        format: 1,
        size: 1,
        interval: INTERVALS[0],
    };

    /// The nearest one that the device has to what a driver proposes.
    fn proposed(bytes: &[u8]) -> Option<Self> {
        let interval = u32::from_le_bytes(bytes.get(4..8)?.try_into().ok()?);
        let nearest = INTERVALS
            .into_iter()
            .min_by_key(|known| known.abs_diff(interval));
        Some(Self {
            format: bytes[2].clamp(1, CODINGS.len() as u8),
            size: bytes[3].clamp(1, 2),
            interval: nearest?,
        })
    }

    pub(super) fn coding(self) -> Coding {
        CODINGS[usize::from(self.format) - 1]
    }

    pub(super) fn size(self, camera: [u32; 2]) -> [u32; 2] {
        sizes(camera)[usize::from(self.size) - 1]
    }

    fn bytes(self, camera: [u32; 2]) -> Vec<u8> {
        let mut bytes = vec![0; NEGOTIATED];
        (bytes[2], bytes[3]) = (self.format, self.size);
        bytes[4..8].copy_from_slice(&self.interval.to_le_bytes());
        bytes[18..22].copy_from_slice(&most_bytes(self.size(camera)).to_le_bytes());
        bytes[22..26].copy_from_slice(&(PAYLOAD as u32).to_le_bytes());
        bytes
    }
}

/// The device's state.
pub(super) struct Device {
    pub(super) camera: SimulatedCamera,
    /// Of the camera itself.
    pub(super) size: [u32; 2],
    proposed: Mode,
    /// What is streamed, while it is.
    pub(super) streams: Option<Mode>,
}

impl Device {
    pub(super) fn new(camera: SimulatedCamera) -> Self {
        let format = camera.format();
        Self {
            camera,
            size: [format.width, format.height],
            proposed: Mode::FIRST,
            streams: None,
        }
    }

    /// Forgets what was agreed on and set, as when its plug is pulled.
    pub(super) fn unplug(&mut self) {
        (self.proposed, self.streams) = (Mode::FIRST, None);
        // automatics come before what they have in hand
        for control in self.camera.controls().unwrap_or_default() {
            if let Err(error) = self.camera.set_control(control.id, control.default) {
                eprintln!("USB camera: {error}"); // an automatic has it in hand by default
            }
        }
    }

    /// Answers a control request with this head; `data` is what was written.
    pub(super) fn answer(&mut self, setup: [u8; 8], data: &[u8]) -> Answer {
        let [kind, request, value_low, value_high, index, entity, ..] = setup;
        match (kind, request) {
            (0x80, 6) => self.descriptor(value_high, value_low),
            (0x80..=0x82, 0) => Answer::Data(vec![0, 0]),
            (0x80, 8) => Answer::Data(vec![1]),
            (0x81, 10) => Answer::Data(vec![0]),
            // a bulk stream ends with the driver clearing its endpoint's halt
            (0x02, 1) | (0x01, 11) => {
                self.streams = None;
                Answer::Taken
            }
            (0x00, 9) => Answer::Taken,
            (0x21 | 0xa1, _) if index == STREAMING => self.negotiate(request, value_high, data),
            (0x21 | 0xa1, _) if index == CONTROL => self.control(request, entity, value_high, data),
            _ => Answer::Stall,
        }
    }

    fn descriptor(&self, kind: u8, number: u8) -> Answer {
        match kind {
            1 => Answer::Data(device()),
            2 => Answer::Data(configuration(self.size)),
            3 => string(number).map_or(Answer::Stall, Answer::Data),
            _ => Answer::Stall,
        }
    }

    fn negotiate(&mut self, request: u8, selector: u8, data: &[u8]) -> Answer {
        const PROBE: u8 = 1;
        const COMMIT: u8 = 2;
        match (request, selector) {
            (SET_CURRENT, PROBE | COMMIT) => {
                let Some(mode) = Mode::proposed(data) else {
                    return Answer::Stall;
                };
                self.proposed = mode;
                if selector == COMMIT {
                    self.streams = Some(mode);
                }
                Answer::Taken
            }
            (GET_CURRENT | GET_LEAST | GET_MOST, PROBE | COMMIT) => {
                Answer::Data(self.proposed.bytes(self.size))
            }
            (GET_DEFAULT, PROBE) => Answer::Data(Mode::FIRST.bytes(self.size)),
            (GET_LENGTH, PROBE | COMMIT) => Answer::Data(vec![NEGOTIATED as u8, 0]),
            (GET_INFO, PROBE | COMMIT) => Answer::Data(vec![CAN_GET_AND_SET]),
            _ => Answer::Stall,
        }
    }

    fn control(&mut self, request: u8, entity: u8, selector: u8, data: &[u8]) -> Answer {
        let Some(control) = Control::of(entity, selector) else {
            return Answer::Stall;
        };
        let Ok(controls) = self.camera.controls() else {
            return Answer::Stall;
        };
        let Some(info) = controls.iter().find(|info| info.id == control.id) else {
            return Answer::Stall;
        };
        let number = |value: i64| Answer::Data(control.bytes(value));
        match request {
            SET_CURRENT => {
                let set = self.camera.set_control(control.id, control.value(data));
                set.map_or(Answer::Stall, |_| Answer::Taken)
            }
            GET_CURRENT => info.value.map_or(Answer::Stall, number),
            GET_DEFAULT => number(info.default),
            GET_LEAST => number(range(info)[0]),
            GET_MOST => number(range(info)[1]),
            // of the exposure modes, those that there are
            GET_STEP if control.id == ids::AUTO_EXPOSURE => Answer::Data(vec![0b1001]),
            GET_STEP => number(1),
            GET_LENGTH => Answer::Data(vec![control.length as u8, 0]),
            GET_INFO => Answer::Data(vec![if control.changes {
                CAN_GET_AND_SET | CHANGES
            } else {
                CAN_GET_AND_SET
            }]),
            _ => Answer::Stall,
        }
    }
}

/// Least and most value of a control.
fn range(info: &ControlInfo) -> [i64; 2] {
    match &info.kind {
        ControlKind::Number { least, most, .. } => [*least, *most],
        ControlKind::Menu { items } => {
            let values = || items.iter().map(|item| item.value);
            [values().min().unwrap_or(0), values().max().unwrap_or(0)]
        }
        _ => [0, 1],
    }
}

/// A control of the video class.
struct Control {
    /// V4L2's number of it.
    id: u32,
    /// Bytes of its value.
    length: usize,
    /// An automatic may change it.
    changes: bool,
}

impl Control {
    fn of(entity: u8, selector: u8) -> Option<Self> {
        let (id, length, changes) = match (entity, selector) {
            (CAMERA, 2) => (ids::AUTO_EXPOSURE, 1, false),
            (CAMERA, 4) => (ids::EXPOSURE_TIME, 4, true),
            (PROCESSING, 4) => (ids::GAIN, 2, false),
            (PROCESSING, 5) => (ids::POWER_LINE_FREQUENCY, 1, false),
            (PROCESSING, 10) => (ids::WHITE_BALANCE_TEMPERATURE, 2, true),
            (PROCESSING, 11) => (ids::WHITE_BALANCE_AUTOMATIC, 1, false),
            _ => return None,
        };
        Some(Self {
            id,
            length,
            changes,
        })
    }

    /// A value as the class writes it: exposure modes are bits there, and numbers in V4L2.
    fn bytes(&self, value: i64) -> Vec<u8> {
        let value = match (self.id, value) {
            (ids::AUTO_EXPOSURE, 1) => 1,
            (ids::AUTO_EXPOSURE, _) => 8,
            (_, value) => value,
        };
        value.to_le_bytes()[..self.length].to_vec()
    }

    fn value(&self, bytes: &[u8]) -> i64 {
        let mut value = [0; 8];
        let length = bytes.len().min(self.length);
        value[..length].copy_from_slice(&bytes[..length]);
        match (self.id, i64::from_le_bytes(value)) {
            (ids::AUTO_EXPOSURE, 1) => 1,
            (ids::AUTO_EXPOSURE, _) => 3,
            (_, value) => value,
        }
    }
}
