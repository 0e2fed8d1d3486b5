//! The controls of the simulated camera: those that a usual webcam has, with their effect on the picture.
//!
//! Takes settings and the frames that were made with them, gives the settings for the next frame. Automatic
//! exposure brings the mean of the picture near a middle grey within some frames, in whole half periods of the
//! mains where that fits; automatic white balance makes it neutral. Left out: gain under an automatic, and
//! exposures longer than a frame.

use std::time::Duration;

use image::RgbImage;
use shared::simulation::{CameraTuning, Scene};

use crate::camera::CameraError;
use crate::camera::controls::{ControlInfo, ControlKind, MenuItem, by_id, ids, standard};

/// V4L2's unit of exposure time.
const EXPOSURE_UNIT_S: f64 = 1e-4;
/// The gain that leaves the picture as it is.
const PLAIN_GAIN: i64 = 16;
/// The colour temperature at which the scene file's white balance holds, in kelvin.
const PLAIN_TEMPERATURE_K: i64 = 5000;
/// How strongly a channel follows the temperature's ratio: near to what daylight does between 3000 and 7000 K.
const TEMPERATURE_POWER: f64 = 0.6;
/// Mean light that automatic exposure aims at, as a share of white.
const MIDDLE_GREY: f64 = 0.18;
/// Share of the way that an automatic goes in one frame.
const AGILITY: f64 = 0.25;
/// An automatic looks at one pixel of so many.
const SAMPLE_EVERY: usize = 61;

const MANUAL: i64 = 1;
const APERTURE_PRIORITY: i64 = 3;

/// The settings of a simulated camera.
#[derive(Debug, Clone)]
pub(super) struct Controls {
    /// In seconds; finer than its control tells.
    exposure_s: f64,
    default_exposure: i64,
    longest_exposure: i64,
    automatic_exposure: bool,
    gain: i64,
    temperature_k: f64,
    automatic_white_balance: bool,
    power_line: i64,
    automatics_by_default: [bool; 2],
}

impl Controls {
    /// The settings that the scene's camera is opened with.
    pub(super) fn new(scene: &Scene) -> Self {
        let units = |time: Duration| (time.as_secs_f64() / EXPOSURE_UNIT_S).round() as i64;
        let exposure = scene.exposure();
        Self {
            exposure_s: exposure.as_secs_f64(),
            default_exposure: units(exposure).max(1),
            longest_exposure: units(scene.frame_period().max(exposure)).max(1),
            automatic_exposure: scene.auto_exposure(),
            gain: PLAIN_GAIN,
            temperature_k: PLAIN_TEMPERATURE_K as f64,
            automatic_white_balance: scene.auto_white_balance(),
            power_line: 1,
            automatics_by_default: [scene.auto_exposure(), scene.auto_white_balance()],
        }
    }

    /// What they make of a frame's light.
    pub(super) fn tuning(&self) -> CameraTuning {
        let warmth = (self.temperature_k / PLAIN_TEMPERATURE_K as f64).powf(TEMPERATURE_POWER);
        CameraTuning {
            exposure: Duration::from_secs_f64(self.exposure_s),
            gain: self.gain as f32 / PLAIN_GAIN as f32,
            white_balance: [warmth as f32, 1.0, (1.0 / warmth) as f32],
        }
    }

    /// The controls as V4L2 would tell them.
    pub(super) fn list(&self) -> Vec<ControlInfo> {
        let number = |least, most| ControlKind::Number {
            least,
            most,
            step: 1,
        };
        let [exposure_default, balance_default] = self.automatics_by_default;
        let controls = [
            (
                ids::WHITE_BALANCE_AUTOMATIC,
                ControlKind::Switch,
                i64::from(balance_default),
            ),
            (ids::GAIN, number(PLAIN_GAIN, 16 * PLAIN_GAIN), PLAIN_GAIN),
            (
                ids::POWER_LINE_FREQUENCY,
                menu(&[0, 1, 2], ids::POWER_LINE_FREQUENCY),
                1,
            ),
            (
                ids::WHITE_BALANCE_TEMPERATURE,
                number(2800, 7500),
                PLAIN_TEMPERATURE_K,
            ),
            (
                ids::AUTO_EXPOSURE,
                menu(&[MANUAL, APERTURE_PRIORITY], ids::AUTO_EXPOSURE),
                mode(exposure_default),
            ),
            (
                ids::EXPOSURE_TIME,
                number(1, self.longest_exposure),
                self.default_exposure,
            ),
        ];
        controls
            .into_iter()
            .map(|(id, kind, default)| self.info(id, kind, default))
            .collect()
    }

    fn info(&self, id: u32, kind: ControlKind, default: i64) -> ControlInfo {
        let known = standard(id);
        let key = known.as_ref().map_or("", |known| known.key);
        ControlInfo {
            id,
            key: key.into(),
            name: key.replace('_', " "),
            kind,
            unit: known.and_then(|known| known.unit),
            default,
            value: Some(self.value(id)),
            inactive: match id {
                ids::EXPOSURE_TIME => self.automatic_exposure,
                ids::WHITE_BALANCE_TEMPERATURE => self.automatic_white_balance,
                _ => false,
            },
            read_only: false,
        }
    }

    fn value(&self, id: u32) -> i64 {
        match id {
            ids::WHITE_BALANCE_AUTOMATIC => i64::from(self.automatic_white_balance),
            ids::GAIN => self.gain,
            ids::POWER_LINE_FREQUENCY => self.power_line,
            ids::WHITE_BALANCE_TEMPERATURE => self.temperature_k.round() as i64,
            ids::AUTO_EXPOSURE => mode(self.automatic_exposure),
            _ => (self.exposure_s / EXPOSURE_UNIT_S).round().max(1.0) as i64,
        }
    }

    /// Sets a control, as [`crate::camera::Camera::set_control`].
    pub(super) fn set(&mut self, id: u32, value: i64) -> Result<i64, CameraError> {
        let controls = self.list();
        let Some(control) = by_id(&controls, id) else {
            let keys: Vec<_> = controls.into_iter().map(|control| control.key).collect();
            return Err(CameraError::NoSuchControl {
                control: format!("{id:#010x}"),
                known: keys.join(", "),
            });
        };
        let refused = |reason: &str| CameraError::ControlRefused {
            control: control.key.clone(),
            reason: reason.into(),
        };
        if control.inactive {
            return Err(refused(
                "an automatic has it in hand; switch that off first",
            ));
        }
        let value = control.nearest(value);
        if !control.takes(value) {
            return Err(refused(&format!("it takes {}", control.range_text())));
        }
        match id {
            ids::WHITE_BALANCE_AUTOMATIC => self.automatic_white_balance = value != 0,
            ids::GAIN => self.gain = value,
            ids::POWER_LINE_FREQUENCY => self.power_line = value,
            ids::WHITE_BALANCE_TEMPERATURE => self.temperature_k = value as f64,
            ids::AUTO_EXPOSURE => self.automatic_exposure = value == APERTURE_PRIORITY,
            _ => self.exposure_s = value as f64 * EXPOSURE_UNIT_S,
        }
        Ok(self.value(id))
    }

    /// Lets the automatics look at a frame.
    pub(super) fn see(&mut self, picture: &RgbImage) {
        if !self.automatic_exposure && !self.automatic_white_balance {
            return;
        }
        let mean = mean_light(picture).map(|light| light.max(1e-3));
        if self.automatic_exposure {
            let longest_s = self.longest_exposure as f64 * EXPOSURE_UNIT_S;
            let wished_s =
                (self.exposure_s * MIDDLE_GREY / mean[1]).clamp(EXPOSURE_UNIT_S, longest_s);
            let step = (self.without_flicker(wished_s) / self.exposure_s).powf(AGILITY);
            self.exposure_s *= step;
        }
        if self.automatic_white_balance {
            let redder = (mean[2] / mean[0]).powf(AGILITY / (2.0 * TEMPERATURE_POWER));
            self.temperature_k = (self.temperature_k * redder).clamp(2800.0, 7500.0);
        }
    }

    /// The nearest whole number of half periods of the mains, for times that are not shorter than one.
    fn without_flicker(&self, exposure_s: f64) -> f64 {
        let half_period_s = match self.power_line {
            1 => 1.0 / 100.0,
            2 => 1.0 / 120.0,
            _ => return exposure_s,
        };
        let longest_s = self.longest_exposure as f64 * EXPOSURE_UNIT_S;
        let most = (longest_s / half_period_s).floor();
        if exposure_s < half_period_s || most < 1.0 {
            return exposure_s;
        }
        (exposure_s / half_period_s).round().min(most) * half_period_s
    }
}

fn mode(automatic: bool) -> i64 {
    if automatic { APERTURE_PRIORITY } else { MANUAL }
}

fn menu(values: &[i64], id: u32) -> ControlKind {
    let names = standard(id).map_or(&[][..], |known| known.menu);
    let items = values.iter().map(|value| MenuItem {
        value: *value,
        name: names
            .get(*value as usize)
            .copied()
            .unwrap_or_default()
            .into(),
    });
    ControlKind::Menu {
        items: items.collect(),
    }
}

/// Mean light of a picture per channel, as a share of white. A square is near enough to the sRGB curve for an
/// automatic.
fn mean_light(picture: &RgbImage) -> [f64; 3] {
    let (mut sums, mut count) = ([0.0; 3], 0.0_f64);
    for pixel in picture.pixels().step_by(SAMPLE_EVERY) {
        for (sum, byte) in sums.iter_mut().zip(pixel.0) {
            *sum += (f64::from(byte) / 255.0).powi(2);
        }
        count += 1.0;
    }
    sums.map(|sum| sum / count.max(1.0))
}
