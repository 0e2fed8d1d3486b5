//! Sets the camera's exposure so that the white-lit scene fills the range and does not clip.
//!
//! Takes a rig, gives the [`Exposure`] found. White is shown, the automatics are held, the gain is set to its least,
//! and the exposure time is searched by the frames' brightest pixels: light grows in proportion to it, so a step or
//! two suffice where nothing clips, and halving finds out of clipping. The time is then cut to whole periods of the
//! projector, whose colours may come one after the other, or else of the lamps' flicker; only a scene that stays dark
//! at the longest time gets gain. Fails quietly where less than the tolerated share of the picture is lit.

use std::time::Duration;

use image::RgbImage;
use serde::{Deserialize, Serialize};
use shared::{protocol::View, stage::Stage};

use super::{Cancel, Progress, Report, Rig, SessionError, rig::FRAME_TIMEOUT};
use crate::{
    camera::{CameraError, ControlInfo, ControlKind, controls::ids},
    clock::monotonic_now,
    scan::Shows,
};

/// Time that white is held before it is looked at: most projectors lag less than 200 ms.
const SETTLE: Duration = Duration::from_millis(600);
/// Frames after a change that may still show the old setting, and those within which the new one must show.
const STALE_FRAMES: usize = 3;
const MOST_FRAMES: usize = 15;
/// Two frames with the same setting differ by less, in bytes.
const SAME: u8 = 3;
/// Looks that a search takes at most; each cuts what is left to a half or better.
const MOST_LOOKS: usize = 14;
/// A brightest byte this near to the aim is good enough.
const NEAR: u8 = 6;
/// A scene that stays below this at the longest exposure gets gain.
const DARK: u8 = 120;
/// V4L2's unit of exposure time.
const UNIT_MS: f64 = 0.1;

/// How the exposure is set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExposureSettings {
    /// Whether commands set it before they measure anything.
    pub set: bool,
    /// Byte that the brightest pixels are brought to, 100 to 245.
    pub brightest: u8,
    /// From this byte on a pixel counts as clipped, 200 to 255.
    pub clipped_from: u8,
    /// Share of the pixels that may be brighter, 0 to 0.1: glints clip at any useful exposure.
    pub brighter_share: f64,
    /// Refresh rate of the projector, in Hz; 0 if its light does not change within a picture.
    pub projector_hz: f64,
    /// Frequency of the mains, in Hz; 0 in daylight.
    pub mains_hz: f64,
}

impl Default for ExposureSettings {
    fn default() -> Self {
        Self {
            set: false,
            brightest: 225,
            clipped_from: 250,
            brighter_share: 0.001,
            projector_hz: 60.0,
            mains_hz: 50.0,
        }
    }
}

/// The exposure that was set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Exposure {
    /// Value of the camera's control: 100 us for a USB camera.
    pub value: i64,
    /// The same in milliseconds, where the unit is known.
    pub ms: Option<f64>,
    /// What it is a whole number of.
    pub whole_periods: WholePeriods,
    /// The camera's gain, if it has one.
    pub gain: Option<i64>,
    /// Byte that the brightest pixels have, but for the tolerated share.
    pub brightest: u8,
    /// Share of the pixels that clip.
    pub clipped_share: f64,
}

/// What an exposure time is a whole number of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WholePeriods {
    /// Periods of the projector.
    Projector(u32),
    /// Half periods of the mains, in which lamps flicker.
    Mains(u32),
    /// Of neither: the scene is too bright for that, or the camera does not tell its unit.
    None,
}

impl Exposure {
    /// The finding in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let time = self
            .ms
            .map_or_else(|| self.value.to_string(), |ms| format!("{ms:.1} ms"));
        let periods = match self.whole_periods {
            WholePeriods::Projector(n) => format!(", {n} period(s) of the projector"),
            WholePeriods::Mains(n) => format!(", {n} half period(s) of the mains"),
            WholePeriods::None => String::new(),
        };
        let gain = self
            .gain
            .map_or_else(String::new, |gain| format!(", gain {gain}"));
        format!(
            "exposure {time}{periods}{gain}: the white-lit scene reaches byte {}, {:.2} % of it clips",
            self.brightest,
            100.0 * self.clipped_share
        )
    }
}

/// What a frame says of its exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Light {
    brightest: u8,
    clipped_share: f64,
}

impl Light {
    fn of(picture: &RgbImage, settings: &ExposureSettings) -> Self {
        let mut counts = [0_u64; 256];
        for pixel in picture.pixels() {
            let [r, g, b] = pixel.0;
            counts[usize::from(r.max(g).max(b))] += 1;
        }
        let pixels = counts.iter().sum::<u64>().max(1) as f64;
        let share_from = |byte: u8| counts[usize::from(byte)..].iter().sum::<u64>() as f64 / pixels;
        let above = |byte: &u8| share_from(*byte) > settings.brighter_share;
        Self {
            brightest: (1..=255).rev().find(above).unwrap_or(0),
            clipped_share: share_from(settings.clipped_from),
        }
    }

    fn clips(self, settings: &ExposureSettings) -> bool {
        self.brightest >= settings.clipped_from
    }
}

/// Shows white and sets the exposure for it. The automatics stay held.
///
/// # Errors
/// [`CameraError::NoSuchControl`] for a camera whose exposure cannot be set; otherwise as [`Rig::shoot`].
pub fn set_exposure(
    rig: &mut Rig,
    settings: &ExposureSettings,
    cancel: &Cancel,
    report: Report,
) -> Result<Exposure, SessionError> {
    let mut step = |done| {
        report(Progress {
            what: "setting the exposure".into(),
            done,
            of: 2,
        });
    };
    step(0);
    rig.camera.expect(Shows::White, Stage::Background);
    rig.projector.show(View::White)?;
    let until = monotonic_now() + SETTLE;
    while rig.next_frame(FRAME_TIMEOUT)?.captured_at < until {
        if cancel.is_cancelled() {
            return Err(SessionError::Cancelled);
        }
    }
    rig.camera.hold_automatics()?;
    step(1);
    let found = Search {
        rig,
        settings,
        cancel,
    }
    .run()?;
    tracing::info!("{}", found.sentence());
    step(2);
    Ok(found)
}

struct Search<'a> {
    rig: &'a mut Rig,
    settings: &'a ExposureSettings,
    cancel: &'a Cancel,
}

impl Search<'_> {
    fn run(&mut self) -> Result<Exposure, SessionError> {
        let controls = self.rig.camera.controls()?;
        let usable = |id: u32| {
            let control = controls.iter().find(|control| control.id == id);
            control
                .filter(|control| !control.read_only)
                .and_then(Range::of)
        };
        let (exposure, unit_ms) = match (usable(ids::EXPOSURE_TIME), usable(ids::EXPOSURE_OLD)) {
            (Some(range), _) => (range, Some(UNIT_MS)),
            (None, Some(range)) => (range, None),
            (None, None) => {
                let keys: Vec<_> = controls
                    .iter()
                    .map(|control| control.key.as_str())
                    .collect();
                return Err(CameraError::NoSuchControl {
                    control: "exposure_time_absolute".into(),
                    known: keys.join(", "),
                }
                .into());
            }
        };
        let exposure = match unit_ms {
            // longer than a frame, and the camera would give fewer frames
            Some(unit_ms) => exposure.up_to((self.rig.frame_ms() / unit_ms) as i64),
            None => exposure,
        };
        let gain = usable(ids::GAIN);
        let mut gain_value = None;
        if let Some(gain) = &gain {
            gain_value = Some(self.rig.camera.set_control(ids::GAIN, gain.least)?);
        }
        let (mut value, mut light) = self.search(&exposure)?;
        let mut whole_periods = WholePeriods::None;
        if let Some(unit_ms) = unit_ms {
            let (cut, periods) = cut_to_periods(value as f64 * unit_ms, self.settings);
            whole_periods = periods;
            let cut = (cut / unit_ms).round() as i64;
            if cut != value {
                light = self.look(exposure.id, cut)?;
                value = cut;
            }
        }
        if let Some(gain) = gain.filter(|_| light.brightest < DARK) {
            let (found, found_light) = self.search(&gain)?;
            (gain_value, light) = (Some(found), found_light);
        }
        Ok(Exposure {
            value,
            ms: unit_ms.map(|unit_ms| value as f64 * unit_ms),
            whole_periods,
            gain: gain_value,
            brightest: light.brightest,
            clipped_share: light.clipped_share,
        })
    }

    /// Sets a control to the value that brings the brightest pixels to the aim, and leaves it there.
    fn search(&mut self, range: &Range) -> Result<(i64, Light), SessionError> {
        let settings = self.settings.clone();
        let mut last = None;
        let found = search(range, &settings, |value| {
            last = Some(value);
            self.look(range.id, value)
        })?;
        if last != Some(found.0) {
            self.look(range.id, found.0)?;
        }
        Ok(found)
    }

    /// Sets a control and gives what the frames look like then.
    fn look(&mut self, id: u32, value: i64) -> Result<Light, SessionError> {
        self.rig.camera.set_control(id, value)?;
        let set_at = monotonic_now();
        let mut last: Option<Light> = None;
        for seen in 0..MOST_FRAMES {
            if self.cancel.is_cancelled() {
                return Err(SessionError::Cancelled);
            }
            let frame = self.rig.next_frame(FRAME_TIMEOUT)?;
            if frame.captured_at < set_at {
                continue;
            }
            let light = Light::of(&frame.picture, self.settings);
            let same = last.is_some_and(|last| last.brightest.abs_diff(light.brightest) <= SAME);
            if seen >= STALE_FRAMES && same {
                return Ok(light);
            }
            last = Some(light);
        }
        // it never came to rest: lamps flicker, or something moves; the newest will do
        Ok(last.unwrap_or(Light {
            brightest: 0,
            clipped_share: 0.0,
        }))
    }
}

/// The values of a control that light grows with.
#[derive(Debug, Clone)]
struct Range {
    id: u32,
    least: i64,
    most: i64,
    now: i64,
}

impl Range {
    fn of(control: &ControlInfo) -> Option<Self> {
        let ControlKind::Number { least, most, .. } = control.kind else {
            return None;
        };
        Some(Self {
            id: control.id,
            least,
            most,
            now: control.value.unwrap_or(control.default),
        })
    }

    fn up_to(&self, most: i64) -> Self {
        Self {
            most: most.clamp(self.least, self.most),
            ..self.clone()
        }
    }
}

/// The value whose light comes nearest to the aim without clipping, or the least one if all clip.
fn search<E>(
    range: &Range,
    settings: &ExposureSettings,
    mut look: impl FnMut(i64) -> Result<Light, E>,
) -> Result<(i64, Light), E> {
    let aim = settings.brightest;
    let (mut best, mut clipping): (Option<(i64, Light)>, Option<i64>) = (None, None);
    let mut value = range.now.clamp(range.least, range.most);
    let mut light = look(value)?;
    for _ in 1..MOST_LOOKS {
        let next = if light.clips(settings) {
            clipping = Some(value);
            match best {
                Some((good, _)) => good + (value - good) / 2,
                None => range.least + (value - range.least) / 4,
            }
        } else {
            let nearer = best.is_none_or(|(_, known)| light.brightest >= known.brightest);
            if nearer {
                best = Some((value, light));
            }
            if light.brightest.abs_diff(aim) <= NEAR {
                break;
            }
            let ratio = linear(aim) / linear(light.brightest.max(1));
            let proportional = (value.max(1) as f64 * ratio).min(range.most as f64) as i64;
            match clipping {
                Some(clipping) if proportional >= clipping => value + (clipping - value) / 2,
                _ => proportional,
            }
        };
        let next = next.clamp(range.least, range.most);
        if next == value {
            break;
        }
        value = next;
        light = look(value)?;
    }
    Ok(match best {
        Some((good, known)) if light.clips(settings) => (good, known),
        _ => (value, light),
    })
}

/// Light of a byte, on any scale: near enough to the usual tone curves for a search.
fn linear(byte: u8) -> f64 {
    f64::from(byte).powf(2.2)
}

/// An exposure time cut to whole periods of the projector, or else of the lamps, where it holds one.
fn cut_to_periods(ms: f64, settings: &ExposureSettings) -> (f64, WholePeriods) {
    let whole = |hz: f64| {
        let period_ms = 1000.0 / hz;
        // a hair less than a whole number is that number, in the camera's own steps
        let count = (ms / period_ms + 0.01).floor();
        (hz > 0.0 && count >= 1.0).then_some((count * period_ms, count as u32))
    };
    if let Some((cut, count)) = whole(settings.projector_hz) {
        return (cut, WholePeriods::Projector(count));
    }
    match whole(2.0 * settings.mains_hz) {
        Some((cut, count)) => (cut, WholePeriods::Mains(count)),
        None => (ms, WholePeriods::None),
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    const RANGE: Range = Range {
        id: ids::EXPOSURE_TIME,
        least: 1,
        most: 333,
        now: 100,
    };

    /// A scene that reaches byte 255 at this value; how often it was looked at, and what was found.
    fn found(full_at: f64, now: i64) -> (i64, Light, usize) {
        let (settings, mut looks) = (ExposureSettings::default(), 0);
        let scene = |value: i64| {
            looks += 1;
            let brightest = 255.0 * (value as f64 / full_at).powf(1.0 / 2.2);
            Ok::<_, Infallible>(Light {
                brightest: brightest.min(255.0) as u8,
                clipped_share: 0.0,
            })
        };
        let range = Range { now, ..RANGE };
        let Ok((value, light)) = search(&range, &settings, scene);
        (value, light, looks)
    }

    #[test]
    fn from_anywhere_the_aim_is_reached_in_few_looks() {
        for full_at in [20.0, 60.0, 150.0, 300.0] {
            for now in [1, 30, 100, 333] {
                let (value, light, looks) = found(full_at, now);
                let off = light.brightest.abs_diff(225);
                assert!(
                    off <= 8,
                    "full at {full_at}, from {now}: {value}, {light:?}"
                );
                assert!(looks <= 9, "full at {full_at}, from {now}: {looks} looks");
            }
        }
    }

    #[test]
    fn a_dark_scene_takes_the_longest_time_and_a_glaring_one_the_shortest() {
        assert_eq!(found(5000.0, 100).0, 333);
        assert_eq!(found(0.1, 100).0, 1);
    }

    #[test]
    fn times_are_cut_to_the_projectors_periods_or_the_lamps() {
        let settings = ExposureSettings::default();
        let cut = |ms| cut_to_periods(ms, &settings);
        assert_eq!(cut(33.3).1, WholePeriods::Projector(2));
        assert!((cut(20.0).0 - 1000.0 / 60.0).abs() < 1e-9);
        assert_eq!(cut(12.0), (10.0, WholePeriods::Mains(1)));
        assert_eq!(cut(4.0), (4.0, WholePeriods::None));
        let daylight = ExposureSettings {
            projector_hz: 0.0,
            mains_hz: 0.0,
            ..settings
        };
        assert_eq!(cut_to_periods(20.0, &daylight), (20.0, WholePeriods::None));
    }

    #[test]
    fn glints_are_left_out_of_the_brightest_but_counted_as_clipped() {
        let glint = |x, y| {
            if x == 0 && y == 0 {
                [255; 3]
            } else {
                [90, 60, 10]
            }
        };
        let picture = RgbImage::from_fn(100, 100, |x, y| image::Rgb(glint(x, y)));
        let light = Light::of(&picture, &ExposureSettings::default());
        assert_eq!(light.brightest, 90);
        assert!((light.clipped_share - 1e-4).abs() < 1e-9);
    }
}
