//! Controls against a camera that is nothing but controls.

use std::time::Duration;

use super::*;
use crate::camera::{Camera, CaptureFormat, Frame, Losses, PixelFormat, Rate};

/// Exposure under an automatic, a menu of two, and gain in steps.
struct Toy {
    controls: Vec<ControlInfo>,
}

fn control(id: u32, kind: ControlKind, value: i64) -> ControlInfo {
    let known = standard(id).unwrap();
    ControlInfo {
        id,
        key: known.key.into(),
        name: known.key.into(),
        kind,
        unit: known.unit,
        default: value,
        value: Some(value),
        inactive: false,
        read_only: false,
    }
}

fn menu(names: &[(i64, &str)]) -> ControlKind {
    let item = |(value, name): &(i64, &str)| MenuItem {
        value: *value,
        name: (*name).into(),
    };
    ControlKind::Menu {
        items: names.iter().map(item).collect(),
    }
}

impl Toy {
    fn new() -> Self {
        let number = |least, most, step| ControlKind::Number { least, most, step };
        Self {
            controls: vec![
                control(ids::EXPOSURE_TIME, number(1, 5000, 1), 157),
                control(
                    ids::AUTO_EXPOSURE,
                    menu(&[(1, "Manual Mode"), (3, "Aperture Priority Mode")]),
                    3,
                ),
                control(ids::GAIN, number(0, 100, 10), 0),
                control(
                    ids::POWER_LINE_FREQUENCY,
                    menu(&[(0, "Disabled"), (1, "50 Hz"), (2, "60 Hz")]),
                    1,
                ),
                control(ids::WHITE_BALANCE_AUTOMATIC, ControlKind::Switch, 1),
            ],
        }
    }

    fn value(&self, id: u32) -> i64 {
        by_id(&self.controls, id).unwrap().value.unwrap()
    }
}

impl Camera for Toy {
    fn description(&self) -> String {
        "toy".into()
    }

    fn format(&self) -> CaptureFormat {
        CaptureFormat {
            width: 8,
            height: 8,
            rate: Rate::per_second(30),
            pixels: PixelFormat::Rgb,
        }
    }

    fn losses(&self) -> Losses {
        Losses::default()
    }

    fn next_frame(&mut self, timeout: Duration) -> Result<Frame, CameraError> {
        Err(CameraError::NoFrame {
            name: "toy".into(),
            waited: timeout,
        })
    }

    fn controls(&self) -> Result<Vec<ControlInfo>, CameraError> {
        let mut controls = self.controls.clone();
        controls[0].inactive = self.value(ids::AUTO_EXPOSURE) == 3;
        Ok(controls)
    }

    fn set_control(&mut self, id: u32, value: i64) -> Result<i64, CameraError> {
        let refuses = id == ids::EXPOSURE_TIME && self.value(ids::AUTO_EXPOSURE) == 3;
        if refuses {
            return Err(CameraError::ControlRefused {
                control: "exposure".into(),
                reason: "automatic".into(),
            });
        }
        let control = self
            .controls
            .iter_mut()
            .find(|known| known.id == id)
            .unwrap();
        let taken = control.nearest(value);
        control.value = Some(taken);
        Ok(taken)
    }
}

fn wishes(texts: &[&str]) -> ControlWishes {
    let mut wishes = ControlWishes::default();
    for text in texts {
        wishes.add(text.parse().unwrap());
    }
    wishes
}

#[test]
fn people_see_exposure_before_gain_before_white_balance_and_unknown_ones_last() {
    let number = ControlKind::Number {
        least: 0,
        most: 9,
        step: 1,
    };
    let mut controls = Toy::new().controls;
    let mut own = control(ids::GAIN, number, 1);
    (own.id, own.key) = (0x0a04_6d71, "led_mode".into());
    controls.insert(0, own);
    sort_for_people(&mut controls);
    let keys: Vec<_> = controls.iter().map(|c| c.key.as_str()).collect();
    let expected = [
        "auto_exposure",
        "exposure_time_absolute",
        "gain",
        "white_balance_automatic",
        "power_line_frequency",
        "led_mode",
    ];
    assert_eq!(keys, expected);
}

#[test]
fn a_wished_value_switches_its_automatic_off_first() {
    let mut toy = Toy::new();
    apply(&mut toy, &wishes(&["exposure=120"])).unwrap();
    assert_eq!(toy.value(ids::AUTO_EXPOSURE), 1);
    assert_eq!(toy.value(ids::EXPOSURE_TIME), 120);
}

#[test]
fn values_are_taken_by_name_number_and_time() {
    let mut toy = Toy::new();
    let wishes = wishes(&[
        "exposure=12.5ms",
        "mains=60 hz",
        "0x0098090c=off",
        "gain=44",
    ]);
    apply(&mut toy, &wishes).unwrap();
    assert_eq!(toy.value(ids::EXPOSURE_TIME), 125);
    assert_eq!(toy.value(ids::POWER_LINE_FREQUENCY), 2);
    assert_eq!(toy.value(ids::WHITE_BALANCE_AUTOMATIC), 0);
    assert_eq!(toy.value(ids::GAIN), 40, "the camera rounds");
}

#[test]
fn a_configuration_says_the_same() {
    let text = "exposure_time_absolute = 120\nwhite_balance_automatic = false\npower_line_frequency = \"Disabled\"";
    let mut toy = Toy::new();
    apply(&mut toy, &toml::from_str(text).unwrap()).unwrap();
    assert_eq!(toy.value(ids::EXPOSURE_TIME), 120);
    assert_eq!(toy.value(ids::WHITE_BALANCE_AUTOMATIC), 0);
    assert_eq!(toy.value(ids::POWER_LINE_FREQUENCY), 0);
}

#[test]
fn a_wrong_key_or_value_is_told_with_what_there_is_and_nothing_is_set() {
    let mut toy = Toy::new();
    let error = apply(&mut toy, &wishes(&["gain=10", "zoom=3"])).unwrap_err();
    assert!(
        error.to_string().contains("power_line_frequency"),
        "{error}"
    );
    let error = apply(&mut toy, &wishes(&["gain=10", "exposure=9000"])).unwrap_err();
    assert!(error.to_string().contains("1 to 5000"), "{error}");
    let error = apply(&mut toy, &wishes(&["gain=10", "mains=55"])).unwrap_err();
    assert!(error.to_string().contains("1 = 50 Hz"), "{error}");
    assert_eq!(toy.value(ids::GAIN), 0);
    for text in ["exposure", "=3", "gain="] {
        assert!(text.parse::<ControlWish>().is_err(), "{text}");
    }
}

#[test]
fn one_call_holds_every_automatic() {
    let mut toy = Toy::new();
    let held = toy.hold_automatics().unwrap();
    let names: Vec<_> = held.iter().map(|held| held.name).collect();
    assert_eq!(names, ["exposure time", "white balance"]);
    assert!(held.iter().all(|held| held.refused.is_none()));
    assert_eq!(toy.value(ids::AUTO_EXPOSURE), 1);
    assert_eq!(toy.value(ids::WHITE_BALANCE_AUTOMATIC), 0);
}

#[test]
fn an_automatic_that_cannot_stand_still_is_told() {
    let mut toy = Toy::new();
    toy.controls[1].kind = menu(&[(3, "Aperture Priority Mode")]);
    let held = toy.hold_automatics().unwrap();
    let refused = held[0].refused.as_ref().unwrap();
    assert!(refused.contains("Aperture"), "{refused}");
}

#[test]
fn the_nearest_value_lies_in_the_range_on_a_step() {
    let kind = ControlKind::Number {
        least: -5,
        most: 12,
        step: 5,
    };
    let control = control(ids::GAIN, kind, 0);
    let nearest: Vec<_> = [-90, -3, 3, 11, 12, i64::MAX]
        .map(|wish| control.nearest(wish))
        .into();
    assert_eq!(nearest, [-5, -5, 5, 10, 10, 10]);
}

#[test]
fn json_tells_number_key_and_range() {
    let json = serde_json::to_value(&Toy::new().controls).unwrap();
    assert_eq!(json[0]["id"], "0x009a0902");
    assert_eq!(json[0]["kind"], "number");
    assert_eq!(
        (&json[0]["least"], &json[0]["most"]),
        (&1.into(), &5000.into())
    );
    assert_eq!(json[1]["items"][1]["name"], "Aperture Priority Mode");
    assert_eq!(json[4]["kind"], "switch");
}

#[test]
fn a_drivers_name_makes_a_key() {
    assert_eq!(key_of("Exposure Time, Absolute"), "exposure_time_absolute");
    assert_eq!(key_of("  LED1 Mode (x) "), "led1_mode_x");
}
