//! Measuring a camera's response from solid colours in simulated rooms.

#![allow(
    clippy::unwrap_used,
    reason = "a step that fails in a helper fails its test"
)]

use std::path::Path;

use image::RgbImage;
use pipeline::response::{
    MeasuredResponse, NoMeasurement, ResponseCurve, SolidCaptures, measure_response, ramp_colours,
};
use shared::{
    pattern::{Pattern, Rgb},
    simulation::{Room, Scene},
    stage::Stage,
};

/// A shipped room with some of its lines replaced.
fn room(name: &str, changes: &[(&str, &str)]) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/scenes");
    let mut text = std::fs::read_to_string(folder.join(name).with_extension("toml")).unwrap();
    for (key, value) in changes {
        // the first table of a scene is the camera's
        let others: Vec<&str> = text.lines().filter(|line| !line.starts_with(key)).collect();
        text = others
            .join("\n")
            .replacen("[camera]", &format!("[camera]\n{key} = {value}"), 1);
    }
    Scene::parse(&text, &folder).unwrap()
}

/// Black, white and all ramp colours as the room's camera sees them in both stages: `shown` is what the projector makes
/// of a colour, `seen` what the camera makes of the frame of colour k.
fn shoot(
    scene: &Scene,
    shown: impl Fn(Rgb) -> Rgb,
    seen: impl Fn(usize, RgbImage) -> RgbImage,
) -> [SolidCaptures; 2] {
    Stage::BOTH.map(|stage| {
        let room = Room::new(scene, stage);
        let mut solids = SolidCaptures::default();
        let colours = [Rgb::BLACK, Rgb::WHITE].into_iter().chain(ramp_colours());
        for (k, colour) in colours.enumerate() {
            let shown = Pattern::Solid {
                colour: shown(colour),
            };
            let light = scene.project(&shown.raster(scene.projector_size()));
            solids.add(colour, &seen(k, room.render(&light, k as u64)));
        }
        solids
    })
}

/// Error of a curve against the truth after a scale and a constant are fitted, which cancel in the light of a line over
/// white, both above black; root mean square over the bytes 16 to `up_to`, in byte values of the true curve.
fn error_levels(found: &[f64; 256], truth: impl Fn(f64) -> f64, up_to: usize) -> f64 {
    let true_light = |byte: usize| truth(byte as f64 / 255.0);
    let slope = |byte: usize| {
        let [low, high] = [-0.5, 0.5].map(|half| (byte as f64 + half) / 255.0);
        truth(high) - truth(low)
    };
    let weighted = |f: &dyn Fn(usize) -> f64| -> f64 {
        (16..up_to).map(|byte| f(byte) / slope(byte).powi(2)).sum()
    };
    let count = weighted(&|_| 1.0);
    let (x, y) = (
        weighted(&|b| found[b]) / count,
        weighted(&|b| true_light(b)) / count,
    );
    let scale =
        weighted(&|b| (found[b] - x) * (true_light(b) - y)) / weighted(&|b| (found[b] - x).powi(2));
    let error = |b: usize| (y + scale * (found[b] - x) - true_light(b)) / slope(b);
    let sum: f64 = (16..up_to).map(|byte| error(byte).powi(2)).sum();
    (sum / (up_to - 16) as f64).sqrt()
}

fn srgb(value: f64) -> f64 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

/// Byte values to light of a camera with the picture mode `contrast = 0.6`, found by halving intervals.
fn contrast(value: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle: f64 = 0.5 * (low + high);
        let turn = std::f64::consts::TAU;
        if middle - 0.6 * (turn * middle).sin() / turn < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    srgb(low)
}

fn with_curve(name: &str, curve: &str) -> MeasuredResponse {
    let solids = shoot(
        &room(name, &[("tone_curve", curve)]),
        |colour| colour,
        |_, frame| frame,
    );
    measure_response(&solids).unwrap()
}

/// Asserts that a curve is found within `most` byte values, and several times nearer to the truth than sRGB is.
fn assert_recovered(found: &MeasuredResponse, truth: impl Fn(f64) -> f64, most: f64) {
    let error = error_levels(&found.curve.table(), &truth, 240);
    let assumed = error_levels(&ResponseCurve::srgb().table(), &truth, 240);
    assert!(
        error < most && 4.0 * error < assumed,
        "off by {error} byte values, sRGB by {assumed}"
    );
    assert!(found.residual_levels < 1.0, "{found:?}");
    assert!(
        found.srgb_residual_levels > 1.5 * found.residual_levels,
        "{found:?}"
    );
}

#[test]
fn the_curve_of_a_camera_without_a_tone_curve_is_recovered_in_a_coloured_room() {
    assert_recovered(&with_curve("coloured-room", "\"linear\""), |v| v, 1.5);
}

#[test]
fn the_curve_of_a_picture_mode_is_recovered_with_a_dark_wall_and_a_white_box() {
    assert_recovered(
        &with_curve("glossy-mug", "{ contrast = 0.6 }"),
        contrast,
        1.5,
    );
}

#[test]
fn an_srgb_camera_keeps_the_srgb_table() {
    let found = with_curve("two-boxes", "\"srgb\"");
    assert!(found.is_srgb, "{found:?}");
    assert_eq!(found.curve, ResponseCurve::srgb());
}

#[test]
fn a_projector_that_brightens_white_changes_nothing_but_is_told() {
    // as a colour wheel with a clear segment: saturated colours give 60 % of their share
    let dim = |Rgb(drive): Rgb| {
        let is_saturated = drive.contains(&0) && drive.contains(&255);
        Rgb(drive.map(|byte| {
            if is_saturated && byte == 255 {
                202
            } else {
                byte
            }
        }))
    };
    let scene = room("figure", &[("tone_curve", "{ power = 3.0 }")]);
    let found = measure_response(&shoot(&scene, dim, |_, frame| frame)).unwrap();
    assert_recovered(&found, |v| v.powi(3), 2.0);
    let ratio = found.white_over_primaries;
    assert!(
        (ratio - 1.0 / 0.6).abs() < 0.1,
        "white is {ratio} times its primaries"
    );
}

#[test]
fn captures_with_changing_exposure_are_refused() {
    let scene = room("two-boxes", &[]);
    let brighter = |k: usize, mut frame: RgbImage| {
        let factor = [1.0, 0.8, 1.15][k % 3];
        frame
            .iter_mut()
            .for_each(|byte| *byte = (f64::from(*byte) * factor).min(255.0) as u8);
        frame
    };
    let error = measure_response(&shoot(&scene, |colour| colour, brighter)).unwrap_err();
    assert!(
        matches!(error, NoMeasurement::DoesNotAddUp { .. }),
        "{error}"
    );
}

#[test]
fn greys_alone_are_not_enough_and_a_dark_room_has_too_few_places() {
    let mut solids = SolidCaptures::default();
    for grey in [0, 60, 120, 180, 255] {
        solids.add(
            Rgb([grey; 3]),
            &RgbImage::from_pixel(64, 64, image::Rgb([grey; 3])),
        );
    }
    assert_eq!(measure_response(&[solids]), Err(NoMeasurement::Incomplete));
    let mut dark = SolidCaptures::default();
    for colour in [Rgb::BLACK, Rgb::WHITE].into_iter().chain(ramp_colours()) {
        dark.add(colour, &RgbImage::from_pixel(64, 64, image::Rgb([3; 3])));
    }
    assert_eq!(
        measure_response(&[dark]),
        Err(NoMeasurement::TooFewPlaces(0))
    );
}
